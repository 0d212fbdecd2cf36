# SPDX-License-Identifier: Apache-2.0
"""Captures of virtual boards, which run the RTL, through the integer model: no word differs."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner
from virtual_boards import told, virtual_board
from wavehaptics.cli import replaying
from wavehaptics.cli.shared import CommandError
from wavehaptics.host import capture, recording
from wavehaptics.host.captured_trace import device_of, save, trace_arrays
from wavehaptics.host.client import Client
from wavehaptics.host.replay import Outcome, replay
from wavehaptics.scene import find_scene
from wavehaptics.trace.columns import load_trace

NAMES = ["flags", "position", "current", "u", "v", "voltage", "correction", "flux"]
OTHERS = ["flags", "position", "current", "u", "offset", "lag"]
BOARD = ("controller.anchor_auto=true", "controller.tick_hz=100e3", "controller.clock_hz=8e6")
END_S = 180.0
"""Of the wall clock, on a busy machine."""
ROWS = 160


def taken(client: Client, folder: Path, names: list[str], trigger: str, before: int) -> Path:
    """A capture with its settings, armed before it begins or, with a trigger, in it; its path."""
    plan = capture.plan(client, names, rows=ROWS, trigger=trigger, before=before)
    settings = recording.settings_now(client)
    end = time.monotonic() + END_S

    def goes_on() -> bool:
        client.write([("arm", 2)])
        assert time.monotonic() < end, "no trigger"
        return False

    if plan.trigger.kind:
        capture.start(client, plan)
        client.write([("arm", 1)])
    else:
        client.write([("arm", 1)])
        while client.read(["running"]) != [1]:
            goes_on()
        capture.start(client, plan)

    assert capture.wait(client, plan, ended=goes_on)
    found = capture.download(client, plan)
    more = recording.recorded(client, found, settings, recording.settings_now(client))
    return save(trace_arrays(found, device_of(client)) | more, folder)


def disarm(client: Client) -> None:
    """The bridges off, which else go off in their own time."""
    client.write([("arm", 0)])
    assert client.read(["running"]) == [0]


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> Iterator[dict[str, Path]]:
    """One from before the bridges go on, with other words too, and one of their being on."""
    folder = tmp_path_factory.mktemp("captures")
    with virtual_board(find_scene("press_hold"), BOARD) as port:
        client = Client(port, timeout_s=END_S)
        found = {"start": taken(client, folder / "start", NAMES, "flags rises 4", 10)}
        found["midway"] = taken(client, folder / "midway", NAMES, "now", 0)
        disarm(client)
        found["others"] = taken(client, folder / "others", OTHERS, "flags rises 4", 3)
        disarm(client)
        written = folder / "command"
        words = ("position", "current", "flags", "--seconds", "1e-4", "--out", str(written))
        status, _, problem = told(port, "capture", *words, "--timeout", "60")
        assert status == 0, problem
        found["off"] = written / "trace.npz"
        yield found


def outcome(path: Path) -> Outcome:
    (found,) = replay(recording.read(path))
    return found


def changed(path: Path, folder: Path, **others: object) -> Path:
    """The file with other arrays or, of the header, other entries."""
    arrays = load_trace(path)
    header = json.loads(str(arrays[recording.HEADER]))
    for name, value in others.items():
        if name in header:
            header[name] = value
        else:
            arrays[name] = value
    arrays[recording.HEADER] = np.array(json.dumps(header))
    return save(arrays, folder)


def other_setting(path: Path, name: str) -> list[int]:
    """The settings, of which one is a 2^-10 smaller."""
    read = recording.read(path)
    place = [text for text, motor in read.settings].index(name)
    header = json.loads(str(load_trace(path)[recording.HEADER]))
    raws = header["settings"]
    signed = read.settings[name, 0]
    raws[place] = (signed - (signed >> 10)) & 0xFFFFFFFF
    return raws


def test_every_word_from_the_start_is_the_models(files):
    for name, words in (("start", NAMES), ("others", OTHERS)):
        found = outcome(files[name])
        assert not found.differs, found
        compared = {word for word, of in found.words.items() if of.compared == found.periods
                    or of.compared == found.periods - 1}  # fmt: skip
        assert compared >= {*words[3:], "contact", "saturated"}
        assert found.periods > ROWS // 2
    rows = recording.read(files["start"]).words
    assert np.ptp(rows["voltage", 0]) > 0
    assert np.ptp(rows["correction", 0]) > 0


def test_a_capture_that_begins_with_the_bridges_on(files):
    found = outcome(files["midway"])
    assert not found.differs, found
    assert {*found.words} == {"contact", "v", "voltage", "u"}
    assert min(word.compared for word in found.words.values()) > ROWS // 2
    assert {*found.unchecked} >= {"correction", "flux"}


@pytest.mark.parametrize("file", ["start", "midway"])
@pytest.mark.parametrize("word", ["u", "v", "voltage"])
def test_one_flipped_word_is_found(files, tmp_path, file, word):
    raws = load_trace(files[file])[f"raw_{word}"].copy()
    row = len(raws) // 2
    raws[row] ^= 1 << 12
    found = outcome(changed(files[file], tmp_path, **{f"raw_{word}": raws}))
    # With the bridges on from the first row, v and voltage are as of the row's u.
    first = found.words[word].first
    assert found.differs
    assert first is not None
    assert first.row == row
    assert abs(first.recorded - first.model) == 1 << 12


@pytest.mark.parametrize("file", ["start", "midway"])
@pytest.mark.parametrize("name", ["eta_contact", "root", "a", "anchor_flux_gain"])
def test_another_setting_is_found(files, tmp_path, file, name):
    settings = other_setting(files[file], name)
    found = outcome(changed(files[file], tmp_path, settings=settings, after=settings))
    # The anchor's own settings act on what isn't known midway.
    assert found.differs == (name != "anchor_flux_gain" or file == "start")


def test_a_flipped_current_or_position(files, tmp_path):
    for name, bit in (("raw_current", 10), ("raw_position", 0)):
        raws = load_trace(files["start"])[name].copy()
        raws[90] ^= 1 << bit
        found = outcome(changed(files["start"], tmp_path / name, **{name: raws}))
        assert found.differs
        assert min(w.first.row for w in found.words.values() if w.first) == 90


def test_the_command(files, tmp_path):
    runner = CliRunner()
    good = runner.invoke(replaying.app, [str(files["start"].parent)])
    assert good.exit_code == 0
    assert "no difference" in good.output
    assert "differ:" not in good.output
    raws = load_trace(files["start"])["raw_v"].copy()
    raws[80] += 7
    bad = runner.invoke(replaying.app, [str(changed(files["start"], tmp_path, raw_v=raws))])
    assert bad.exit_code == 1
    assert "first in row 80" in bad.output
    assert "by 7" in bad.output


@pytest.mark.parametrize(
    ("others", "message"),
    [
        ({"decimation": 4}, "a row is the mean of 4 control periods, .*--decimate 1"),
        ({"table": "00000000"}, "its register map has the CRC 00000000, .*"),
        ({"shape": [1]}, "its settings or words aren't whole; capture it anew"),
        ({"channels": [["u", "u", 0]]}, "position, current, flags of motor 0 wasn't captured; .*"),
        ({"raw_flags": np.zeros(3, dtype=np.int64)}, "its settings or words aren't whole; .*"),
    ],
)  # fmt: skip
def test_files_that_cant_be_replayed(files, tmp_path, others, message):
    path = changed(files["start"], tmp_path, **others)
    with pytest.raises(CommandError, match=message) as error:
        replaying.app([str(path)], standalone_mode=False)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(str(path))


def test_a_capture_with_the_bridges_off(files):
    """That `board capture` wrote: there is nothing to replay."""
    assert recording.read(files["off"]).settings["anchor_enable", 0] == 1
    message = "motor 0 has no control period with the bridges on, .*; arm while it is captured"
    with pytest.raises(CommandError, match=message):
        replaying.app([str(files["off"])], standalone_mode=False)


def test_settings_that_changed_meanwhile(files, tmp_path):
    path = changed(files["start"], tmp_path, after=other_setting(files["start"], "root"))
    with pytest.raises(CommandError, match="root was changed while it was captured"):
        replaying.app([str(path)], standalone_mode=False)


def test_a_file_without_raw_words(files, tmp_path):
    arrays = load_trace(files["start"])
    arrays.pop(recording.HEADER)
    path = save(arrays, tmp_path)
    with pytest.raises(CommandError, match=r"it has no raw words and settings: .*board capture"):
        replaying.app([str(path)], standalone_mode=False)
    with pytest.raises(CommandError, match="can't be read: No such file"):
        replaying.app([str(tmp_path / "none.npz")], standalone_mode=False)
    (tmp_path / "cut.npz").write_bytes(path.read_bytes()[:500])
    with pytest.raises(CommandError, match="is no whole trace"):
        replaying.app([str(tmp_path / "cut.npz")], standalone_mode=False)
