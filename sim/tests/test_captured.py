# SPDX-License-Identifier: Apache-2.0
"""Captures: the device's memory beside the simulation's words, and what a host makes of it."""

from __future__ import annotations

import contextlib
import math

import numpy as np
import pytest
from device_pins import DevicePins
from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU
from pymodbus.pdu.register_message import ReadHoldingRegistersRequest
from wavehaptics.host import capture
from wavehaptics.host.capture import DONE, REST, Captured, Plan, Trigger
from wavehaptics.host.captured_trace import Device, save, trace_arrays
from wavehaptics.host.client import Client, Identification
from wavehaptics.host.names import HostError, places
from wavehaptics.ladder.linked_pins import CAPTURE, LinkedPins, write_frame
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.trace.columns import FLOAT_COLUMNS, Column, Word, load_trace
from wavehaptics.trace.pictures import run_picture, strips_picture
from wavehaptics.words import formats, modbus
from wavehaptics.words.table import WORDS

BOARD = ("drive.bus_v=12", "adc.bits=12", "adc.full_scale_a=2.5", "encoder.counts_per_rev=10000")
CHUNK = 64
MOST_CHUNKS = 2000
"""Ticks, in which the longest answer comes at 115,200 bits a second five times."""
NAMES = ("current", "u", "v", "voltage")
COLUMNS = [Word.I, Word.U, Word.V, Word.E]

# ---- The device.


class Line:
    """A master in the simulation's own time, which keeps the words of every tick."""

    def __init__(self, simulation: LinkedPins) -> None:
        self.simulation = simulation
        self.rows: list[np.ndarray] = []
        self.words: list[np.ndarray] = []

    def elapse(self) -> None:
        rows, words = np.zeros((CHUNK, len(Column))), np.zeros((CHUNK, len(Word)), dtype=np.int64)
        self.simulation.advance(rows, words)
        self.rows.append(rows)
        self.words.append(words)

    def ask(self, frame: bytes, length: int) -> bytes:
        self.simulation.send(frame)
        answer = self.answer(length)
        assert answer[1] == frame[1]
        return answer

    def answer(self, length: int) -> bytes:
        found = b""
        for _ in range(MOST_CHUNKS):
            self.elapse()
            found += self.simulation.received()
            if len(found) >= length:
                return found
        raise AssertionError(f"{len(found)} of {length} bytes came")

    def write(self, name: str, *raws: int) -> None:
        self.ask(write_frame(WORDS[name].at(), [*raws]), 8)

    def read(self, name: str, count: int = 1) -> list[int]:
        request = ReadHoldingRegistersRequest(
            address=modbus.word_register(WORDS[name].at()), count=2 * count, dev_id=1
        )
        frame = FramerRTU(DecodePDU(False)).buildFrame(request)
        data = self.ask(frame, 5 + 4 * count)[3:-2]
        return modbus.whole(np.frombuffer(data, dtype=">u2").tolist())


@pytest.mark.parametrize("log2", [0, 3])
def test_a_capture_is_what_the_simulation_had(log2):
    """Row for row, or the mean of eight; and the motor goes as on a device that none listens to."""
    scene = load_scene(find_scene("press_hold"), BOARD)
    line = Line(LinkedPins(scene, arm=False))
    rows, before = 31, 12
    channels = [WORDS[name].at() for name in NAMES]
    line.write("capture_channel", *channels, 0, 0, 0, 0, len(channels), rows, before, log2, 0, 0)
    line.write("capture", 1)
    line.write("capture", 2)
    while line.read("capture_state") != [DONE]:
        assert len(line.words) < 4000
    count, first, left = line.read("capture_count", 3)
    assert (count, left) == (rows, 0)
    found = []
    for offset in range(0, rows * len(channels), 62):
        line.write("capture_offset", offset)
        found += line.read("capture_data", 62)
    ring = np.array(found[: rows * len(channels)], dtype=np.uint32).astype(np.int32)
    ordered = np.roll(ring.reshape(rows, -1), -first, axis=0)
    words = np.concatenate(line.words)
    length = rows << log2
    same = [
        n
        for n in range(len(words) - length)
        if np.array_equal(
            words[n : n + length, COLUMNS].reshape(rows, -1, len(COLUMNS)).sum(axis=1) >> log2,
            ordered,
        )
    ]
    assert len(same) == 1
    assert np.ptp(ordered, axis=0).min() > 0
    alone = DevicePins(scene)
    expected = np.zeros((len(words), len(Word)), dtype=np.int64)
    alone.advance(np.zeros((len(words), len(Column))), expected)
    np.testing.assert_array_equal(words, expected)


# ---- A host, beside a device that is a dictionary.


class Told(Client):
    """A device whose words are given."""

    def __init__(self, log2: int = CAPTURE, **words: int) -> None:
        options = 2 | 4 << 4 | 2 << 11 | log2 << 28
        self.identification = Identification(
            {"options": options, "motors": 2, "clock_hz": 48_000_000, "rates": 4}
        )
        self.words = {"half_clocks": 24, "tick_halves": 2, **words}
        self.memory: list[int] = []
        self.offset = 0
        self.bursts = 0

    def read(self, wanted):
        found = []
        for place in wanted:
            if place.word.name == "capture_data":
                found.append(self.memory[self.offset + place.index])
            else:
                found.append(self.words.get(place.text, 0))
        return found

    def write(self, words):
        for place, raw in words:
            self.words[place.text] = raw
            if place.word.name == "capture_offset":
                self.offset = raw
        return 1

    @contextlib.contextmanager
    def hurry(self):
        self.bursts += 1
        yield


def test_what_is_written_to_start():
    client = Told()
    plan = capture.plan(
        client, ["current@1", "flags"], rows=100, before=40, decimation=8,
        trigger="voltage rises -1.5",
    )  # fmt: skip
    assert plan.names == ("voltage", "current@1", "flags")
    assert plan.row_s == 8e-6
    capture.start(client, plan)
    codes = [client.words[f"capture_channel[{n}]"] for n in range(8)]
    assert codes == [WORDS["voltage"].at(0), WORDS["current"].at(1), WORDS["flags"].at(0), *[0] * 5]
    assert client.words["capture_level"] == -3 << formats.VOLTAGE.fraction - 1
    assert [client.words[f"capture_{name}"] for name in
            ("channels", "rows", "pre", "decimation", "trigger")] == [3, 100, 40, 3, 3]  # fmt: skip
    assert client.words["capture"] == 1
    capture.start(client, capture.plan(client, ["u"], rows=1))
    assert client.words["capture"] == 2


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("now", (0, "", 0.0)),
        ("contact", (6, "", 0.0)),
        ("fault", (7, "", 0.0)),
        ("current>0.5", (1, "current", 0.5)),
        ("u@1 < -2e-3", (2, "u@1", -2e-3)),
        ("position rises 100", (3, "position", 100.0)),
        ("v falls +.5", (4, "v", 0.5)),
        ("flags changes", (5, "flags", 0.0)),
    ],
)
def test_triggers(text, expected):
    assert capture.trigger_of(text) == Trigger(*expected, text)


@pytest.mark.parametrize(
    ("channels", "wanted", "message"),
    [
        (["current"], {"trigger": "current=1"}, r"trigger current=1: write now, contact, fault,"),
        (["current"], {"trigger": "current>1e"}, r"trigger current>1e: write now"),
        (["current"], {"trigger": "current>1.2.3"}, r"trigger current>1.2.3: write now"),
        (["current"], {"trigger": "current>64"}, r"trigger at current = 64: take -64...64 A"),
        (["current"], {"trigger": "current rises 1e999"}, r"trigger .* 1e999: write now"),
        (["current"], {"trigger": "current>1e308"}, r"trigger at current = 1e\+308: take -64...64"),
        (["current"], {"trigger": "current<-1e300"}, r"trigger at current = -1e\+300: take -64"),
        (["u"], {"seconds": math.nan}, r"nan seconds: take a number"),
        (["u"], {"seconds": math.inf}, r"inf seconds: take a number"),
        (["u"], {"before_s": math.inf}, r"inf seconds before the trigger: take a number"),
        (["current@²"], {}, r"current@²: can't be captured"),
        (["root"], {}, r"root: can't be captured; take voltage, u, v, current, position"),
        (["current@x"], {}, r"current@x: can't be captured"),
        (["current@2"], {}, r"current: the device has no motor 2; take --motor 0...1"),
        ([], {}, r"0 channels: take 1 to 8"),
        ([*capture.WORDS[:8]], {"trigger": "lag>1"}, r"9 channels: take 1 to 8"),
        (["u"], {"decimation": 3}, r"decimation 3: take 1, 2, 4 ... 32768 ticks a row; .* 134 s"),
        (["u"], {"rows": 4097}, r"4097 rows of 1 channels: the device has room for 1...4096, 0.0"),
        (["u"], {"seconds": 1e3}, r"decimation 262144: take 1, 2, 4 ... 32768"),
        (["u", "v"], {"seconds": 1, "decimation": 1}, r"1000000 rows of 2 .*room for 1...2048"),
        (["u"], {"rows": 8, "before": 8}, r"8 rows before the trigger's: take 0...7 of 8"),
    ],
)
def test_plans_that_are_refused(channels, wanted, message):
    with pytest.raises(HostError, match=message) as error:
        capture.plan(Told(), channels, **wanted)
    assert "\n" not in str(error.value)


def test_a_device_without_a_capture():
    with pytest.raises(HostError, match="has no capture"):
        capture.plan(Told(0), ["u"])


def test_one_word_by_its_name():
    """It is no list of its letters."""
    assert capture.plan(Told(), "current").names == ("current",)


def test_seconds_choose_the_decimation():
    plan = capture.plan(Told(), ["u", "v", "current"], seconds=0.01, before_s=0.002)
    assert (plan.decimation, plan.rows, plan.before) == (8, 1250, 250)
    assert capture.plan(Told(), ["u"], seconds=4096e-6).decimation == 1
    assert capture.plan(Told(), ["u"]).rows == 4096


def test_waiting(monkeypatch):
    """What is done, was never begun, has no ticks, or is stopped."""
    plan = capture.plan(Told(), ["u"], rows=10, before=4)
    client = Told(capture_state=DONE, capture_count=10)
    seen = []
    assert capture.wait(client, plan, seen.append)
    assert seen == [(DONE, 1.0)]
    with pytest.raises(HostError, match="isn't capturing: was it reset"):
        capture.wait(Told(capture_state=REST), plan)
    monkeypatch.setattr(capture, "_STILL_S", 0.05)
    client = Told(capture_state=capture.WAITS, capture_count=4, capture_left=6)
    with pytest.raises(HostError, match="there are no ticks"):
        capture.wait(client, plan, seen.append)
    assert seen[-1] == (capture.WAITS, 0.4)

    def stopped() -> bool:
        client.words["capture_state"] = DONE
        return True

    assert not capture.wait(client, plan, ended=stopped)
    assert client.words["capture"] == 0


@pytest.mark.parametrize("armed", [0, 1])
@pytest.mark.parametrize(
    ("count", "first", "left", "trigger_row"),
    [(200, 0, 0, 60), (200, 77, 0, 60), (200, 5, 30, 90), (150, 0, 60, 70), (40, 0, 140, None)],
)
def test_a_ring_is_put_in_order(armed, count, first, left, trigger_row):
    """Done, or stopped in the middle: time runs, and is 0 where the trigger was."""
    client = Told(capture_state=DONE, capture_count=count, capture_first=first, capture_left=left,
                  armed=armed)  # fmt: skip
    plan = capture.plan(client, ["current", "position", "flags"], rows=200, before=60, decimation=4)
    order = (np.arange(count) - first) % count
    for n in order:
        client.memory += [n - 100 & 0xFFFFFFFF, -n & 0xFFFFFFFF, n & 3]
    client.memory += [0xDEAD] * 64
    found = capture.download(client, plan)
    assert found.trigger_row == trigger_row
    np.testing.assert_array_equal(found["position"], -np.arange(count))
    np.testing.assert_array_equal(found["current"] / formats.CURRENT.step, np.arange(count) - 100)
    np.testing.assert_array_equal(found.flag("saturated"), np.arange(count) >> 1 & 1)
    assert np.allclose(np.diff(found.t), 4e-6)
    assert found.t[trigger_row or 0] == 0.0
    assert client.bursts == (math.ceil(math.ceil(3 * count / 62) / 8) if armed else 1)


def test_a_capture_that_is_stopped_before_the_first_row():
    client = Told(capture_state=DONE, capture_count=0, capture_left=10)
    found = capture.download(client, capture.plan(client, ["u", "current"], rows=10))
    assert (found.t.shape, found["u"].shape, found["current"].shape) == ((0,), (0,), (0,))
    assert found.trigger_row is None


def test_nothing_is_downloaded_before_it_is_done():
    client = Told(capture_state=capture.TRIGGERED)
    with pytest.raises(HostError, match="isn't done"):
        capture.download(client, capture.plan(client, ["u"], rows=1))


# ---- A trace.


def _captured(names: tuple[str, ...], decimation: int = 1, rows: int = 500) -> Captured:
    shape = Told().shape
    channels = tuple(places(name, shape)[0] for name in names)
    plan = Plan(channels, names, rows, 100, decimation, capture.NOW, 1e-6)
    t = (np.arange(rows) - 100) * plan.row_s
    wave = np.sin(2e3 * np.pi * t)
    found = {name: wave * (n + 1) for n, name in enumerate(names)}
    if "flags" in found:
        found["flags"] = (wave > 0.5).astype(np.uint32) | 2 * (wave > 0.9).astype(np.uint32)
    if "position" in found:
        found["position"] = np.round(1000 * wave)
    return Captured(plan, t, found, 100)


DEVICE = Device(-1.0, 1.0, 2, 2 * np.pi / 10_000, 0.02)


def test_a_trace_has_a_simulations_arrays(tmp_path):
    found = _captured(("current", "voltage", "u", "v", "position", "flags"))
    save(trace_arrays(found, DEVICE), tmp_path)
    trace = load_trace(tmp_path)
    names = {column.name.lower() for column in FLOAT_COLUMNS}
    assert names | {"energy_out", "contact", "saturated"} <= {*trace}
    np.testing.assert_array_equal(trace["i"], found["current"])
    np.testing.assert_allclose(trace["torque"], 0.02 * found["current"])
    np.testing.assert_allclose(trace["e_a"][2:], found["voltage"][:-2], atol=1e-12)
    ends = found["position"] * DEVICE.cell_rad
    np.testing.assert_allclose(trace["x"][1:], 0.5 * (ends[1:] + ends[:-1]))
    np.testing.assert_allclose(np.cumsum(trace["omega"]) * 1e-6, ends - ends[0], atol=1e-9)
    np.testing.assert_array_equal(trace["contact"], found["flags"] & 1)
    np.testing.assert_array_equal(trace["eta"], np.where(trace["contact"], -1.0, 1.0))
    power = np.diff(trace["energy_out"]) / 1e-6
    np.testing.assert_allclose(power, (found["u"] ** 2 - found["v"] ** 2)[1:] / 2, atol=1e-9)
    assert np.isnan(trace["x_hand"]).all()
    metrics = {"scene": "a board", "controller": "device", "duration_s": 5e-4, "peak_torque": 0.02}
    for picture in (run_picture(trace, metrics, tmp_path / "run.png"),
                    strips_picture(trace, {"current": (trace["i"], "A")}, "it",
                                   tmp_path / "strips.png")):  # fmt: skip
        assert picture.stat().st_size > 10_000


def test_what_was_not_captured_is_not_a_number():
    arrays = trace_arrays(_captured(("current", "faults"), decimation=8), Device())
    assert np.isnan(arrays["torque"]).all()
    assert np.isnan(arrays["x"]).all()
    assert np.isnan(arrays["energy_out"]).all()
    assert not arrays["contact"].any()
    assert "faults" in arrays
    assert "x_hat" not in arrays
    anchored = trace_arrays(_captured(("flux", "lag", "position", "flags")), DEVICE)
    cells = anchored["x_hat"] / DEVICE.cell_rad
    np.testing.assert_allclose(cells + anchored["flux"], np.round(1000 * np.sin(
        2e3 * np.pi * anchored["t"])) + 0.5)  # fmt: skip
    assert not anchored["fault"].any()
