# SPDX-License-Identifier: Apache-2.0
"""wh_wave_core against the integer model, word for word (bench: ``bench_wave_core.v``)."""

from __future__ import annotations

import importlib
import os
import re
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import cocotb
import numpy as np
from cocotb.triggers import First, RisingEdge, Timer
from simulators import RTL_DIR, defines, parameters

TICKS = parameters()["TICKS"]
PORTS = parameters()["N"]
DELAY_LOG2 = parameters()["DELAY_LOG2"]
OUTSIDE = parameters().get("OUTSIDE", 1)
SHAPER = parameters().get("SHAPER", 0)
WITHHELD = parameters().get("WITHHELD", 0)
CLOCKS_A_PORT = 24 + 5 * SHAPER
EIGHTHS = 200
"""Ticks of small waves through W, behind the TICKS; the bench has room for them."""
LIMITS = 60
"""Ticks behind all others that come out at the limit or a place beside it; there is room, too."""
AGE_MAX = (1 << DELAY_LOG2) - 1


def _load_model() -> tuple[ModuleType, ModuleType]:
    """The modules ``formats`` and ``golden`` at the widths that the RTL was built with.

    The package reads the header that stands beside it. For other widths, a copy of both is put
    into the simulation's folder, with the header's numbers changed.
    """
    if defines():
        os.environ["NUMBA_DISABLE_JIT"] = "1"  # compiling would take longer than it saves
        root = Path("model").resolve()
        package = RTL_DIR.parent / "sim" / "wavehaptics"
        ignore = shutil.ignore_patterns("__pycache__")
        shutil.copytree(package, root / "sim" / "wavehaptics", ignore=ignore, dirs_exist_ok=True)
        text = (RTL_DIR / "wh_formats.vh").read_text(encoding="utf-8")
        for macro, value in defines().items():
            text, changes = re.subn(rf"(`define {macro}) \d+", rf"\1 {value}", text)
            assert changes == 1, f"{macro} is not in the header"
        (root / "rtl").mkdir(exist_ok=True)
        (root / "rtl" / "wh_formats.vh").write_text(text, encoding="utf-8")
        sys.path.insert(0, str(root / "sim"))
        # What the benches have of the package is of the header's own widths.
        for name in [name for name in sys.modules if name.split(".")[0] == "wavehaptics"]:
            del sys.modules[name]
    formats = importlib.import_module("wavehaptics.words.formats")
    for macro, value in defines().items():
        assert formats.HEADER_VALUES[macro.removeprefix("WH_")] == value
    return formats, importlib.import_module("wavehaptics.controller.wave_core")


FORMATS, GOLDEN = _load_model()


@dataclass
class Stream:
    """Inputs of a run of ticks: int64, shape (ticks, ports) where each port has its own."""

    current: np.ndarray
    eta: np.ndarray
    outside: np.ndarray
    ends: np.ndarray
    """At which ends of its range the current is."""
    mode: np.ndarray
    shape: np.ndarray
    """Words of W: int64, shape (ticks, ports, max(SHAPER, 1), SECTION_WORDS)."""
    root: np.ndarray
    a: np.ndarray
    u_max: np.ndarray
    extra: np.ndarray
    hold: np.ndarray
    pause: np.ndarray
    at: np.ndarray
    poke: np.ndarray
    abort: np.ndarray
    reset: np.ndarray

    @property
    def ticks(self) -> int:
        return self.current.shape[0]

    def words(self) -> list[int]:
        """A word a tick, in the bench's layout."""
        fields = [(getattr(self, name).astype(bool), 1) for name in ("reset", "abort", "poke")]
        fields += [(self.at, 8), (self.pause, 8), (self.extra, DELAY_LOG2), (self.hold, DELAY_LOG2)]
        for words in (self.ends, self.mode):
            fields += [(words[:, port], 2) for port in reversed(range(PORTS))]
        widths = [FORMATS.SHAPE.width] * GOLDEN.LOSS1 + [FORMATS.SHAPE_LOSS_W] * 3
        for port in reversed(range(PORTS)):
            for section in reversed(range(self.shape.shape[2])):
                words = self.shape[:, port, section]
                fields += [(words[:, n], widths[n]) for n in reversed(range(len(widths)))]
        for words, width in (
            (self.u_max, FORMATS.DATA_W),
            (self.a, FORMATS.COEF_W),
            (self.root, FORMATS.COEF_W),
            (self.outside, FORMATS.DATA_W),
            (self.eta, FORMATS.COEF_W),
            (self.current, FORMATS.DATA_W),
        ):
            fields += [(words[:, port], width) for port in reversed(range(PORTS))]
        packed = [0] * self.ticks
        for values, width in fields:
            mask = (1 << width) - 1
            packed = [
                word << width | value & mask
                for word, value in zip(packed, values.tolist(), strict=True)
            ]
        return packed


@dataclass
class Answers:
    """What came out: int64, shape (ticks, ports); clocks, overrun and faults of shape (ticks,)."""

    voltage: np.ndarray
    u: np.ndarray
    v: np.ndarray
    withheld: np.ndarray
    saturated: np.ndarray
    clipped: np.ndarray
    overrun: np.ndarray
    clocks: np.ndarray
    faults: np.ndarray

    @classmethod
    def empty(cls, ticks: int) -> Answers:
        several = [np.zeros((ticks, PORTS), dtype=np.int64) for _ in range(6)]
        return cls(*several, *(np.zeros(ticks, dtype=np.int64) for _ in range(3)))

    @classmethod
    def from_words(cls, words: list[int]) -> Answers:
        """Take apart the bench's words."""
        self = cls.empty(len(words))

        def take(width: int, signed: bool) -> np.ndarray:
            nonlocal words
            values = np.array([word & ((1 << width) - 1) for word in words], dtype=np.int64)
            words = [word >> width for word in words]
            return values - (values >> (width - 1) << width) if signed else values

        for values in (self.voltage, self.u, self.v, self.withheld):
            for port in range(PORTS):
                values[:, port] = take(FORMATS.DATA_W, signed=True)
        for values in (self.saturated, self.clipped):
            for port in range(PORTS):
                values[:, port] = take(1, signed=False)
        self.overrun = take(1, signed=False)
        self.clocks = take(16, signed=False)
        self.faults = take(8, signed=False)
        return self


def expected(stream: Stream) -> tuple[Answers, np.ndarray]:
    """The integer model's answers to a stream, and bool (ticks, ports), whether W owes."""
    answers = Answers.empty(stream.ticks)
    owes = np.zeros((stream.ticks, PORTS), dtype=bool)
    answers.clocks[:] = np.where(stream.abort, stream.at, CLOCKS_A_PORT * PORTS)

    def fresh() -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        line = np.zeros(AGE_MAX + 1, dtype=np.int64)
        return [
            (GOLDEN.new_state(), line.copy(), GOLDEN.new_shaper_state(SHAPER)) for _ in range(PORTS)
        ]

    memories = fresh()
    overrun = False
    outside = stream.outside if OUTSIDE else np.zeros_like(stream.outside)
    words = [stream.current, stream.eta, outside, stream.root, stream.a]
    inputs = np.stack(words, axis=-1).tolist()
    limits, ages = stream.u_max.tolist(), np.stack([stream.extra, stream.hold], axis=-1).tolist()
    for tick in range(stream.ticks):
        if stream.reset[tick] or stream.abort[tick]:
            memories, overrun = fresh(), False
        if stream.abort[tick]:
            continue
        overrun |= bool(stream.poke[tick])
        answers.overrun[tick] = overrun
        for port, (state, line, shaper) in enumerate(memories):
            u_max = limits[tick][port]
            owes[tick, port] = shaper[SHAPER, 0] < 0
            words = GOLDEN.shaped_core_step(
                state, line, stream.shape[tick, port, :SHAPER], shaper, stream.mode[tick, port],
                *inputs[tick][port], u_max, *ages[tick], int(stream.ends[tick, port]),
            )  # fmt: skip
            answers.voltage[tick, port], answers.u[tick, port], answers.v[tick, port] = words
            answers.saturated[tick, port] = state[GOLDEN.STATE_SATURATED]
            answers.clipped[tick, port] = state[GOLDEN.STATE_CLIPPED]
            if WITHHELD:
                answers.withheld[tick, port] = state[GOLDEN.STATE_WITHHELD]
    return answers, owes


class Bench:
    """The bench: hands a stream to the core and checks every word of the answers."""

    def __init__(self, dut) -> None:
        self.dut = dut

    async def run(self, stream: Stream) -> Answers:
        """The core's answers to a stream of at most TICKS + EIGHTHS + LIMITS ticks."""
        text = "\n".join(f"{word:x}" for word in stream.words())
        Path("stimulus.hex").write_text(text + "\n")
        self.dut.ticks_i.value = stream.ticks
        self.dut.go_i.value = 1
        timeout = Timer(10 * stream.ticks * (CLOCKS_A_PORT * PORTS + 300) + 1000, unit="ns")
        done = RisingEdge(self.dut.done_o)
        assert await First(done, timeout) is done, "the bench never came to an end"
        lines = Path("response.hex").read_text().splitlines()
        words = [line for line in lines if not line.startswith("//")][: stream.ticks]
        return Answers.from_words([int(word, 16) for word in words])

    def check(self, stream: Stream, answers: Answers) -> None:
        """Every word equal to the model's; names the first tick that is not."""
        model, owes = expected(stream)
        shapes = stream.mode == GOLDEN.SHAPE
        # What W gives is seen, and that it gives nothing while it owes.
        assert SHAPER == 0 or 0.02 < owes[shapes].mean() < 0.5
        checked = 0
        names = ("faults", "clocks", "overrun", "u", "v", "voltage", "withheld", "saturated",
                 "clipped")  # fmt: skip
        for name in names:
            got, want = getattr(answers, name), getattr(model, name)
            wrong = np.flatnonzero((got != want).reshape(stream.ticks, -1).any(axis=1))
            assert wrong.size == 0, (
                f"{name} of tick {wrong[0]} is {got[wrong[0]]} instead of {want[wrong[0]]}, "
                f"and {wrong.size - 1} more are wrong"
            )
            checked += got.size
        assert checked == stream.ticks * (3 + 6 * PORTS) > 0


def shaper_words(rng: np.random.Generator, ticks: int) -> np.ndarray:
    """Words of W, at times constant: any, corners, eighths, or like real ones of low frequencies.

    With eighths alone, or a bit less, sums end on whole places or just below, where each bit below
    decides. Half of them are brought to matrices that give out no more than they get, or W would
    owe most of the time.
    """
    shape = (ticks if rng.random() < 0.3 else 1, PORTS, max(SHAPER, 1), GOLDEN.SECTION_WORDS)
    format_ = FORMATS.SHAPE
    kind = rng.integers(4)
    if kind == 0:
        words = rng.integers(format_.raw_min, format_.raw_max, shape, endpoint=True)
    elif kind == 1:
        corners = [format_.raw_min, -1, 0, 1, 1 << format_.fraction, format_.raw_max]
        words = rng.choice(np.array(corners, dtype=np.int64), shape)
    elif kind == 2:
        words = (rng.integers(-7, 8, shape) << (format_.fraction - 3)) - rng.integers(0, 2, shape)
    else:
        small = 1 << int(rng.integers(1, format_.fraction))
        words = rng.integers(-small, small, shape)
        words[..., GOLDEN.D] = rng.integers(-1 << format_.fraction, 1 << format_.fraction)
    if SHAPER and rng.random() < 0.5:
        words[..., : GOLDEN.LOSS1] = contractive(words[..., : GOLDEN.LOSS1])
    largest = 1 << int(rng.integers(0, FORMATS.SHAPE_LOSS_W, endpoint=True))
    words[..., GOLDEN.LOSS1 :] = rng.integers(0, largest, (*shape[:3], 3)) if kind != 2 else 0
    return np.broadcast_to(words, (ticks, *shape[1:]))


def contractive(words: np.ndarray) -> np.ndarray:
    """Coefficients (..., 9) of matrices like those given, brought to a norm of 1 or less."""
    places = [[GOLDEN.E11, GOLDEN.E12, GOLDEN.B1], [GOLDEN.E21, GOLDEN.E22, GOLDEN.B2],
              [GOLDEN.C1, GOLDEN.C2, GOLDEN.D]]  # fmt: skip
    one = 1 << FORMATS.SHAPE.fraction
    states = np.diag([1.0, 1.0, 0.0])
    matrix = words[..., places] / one + states
    norm = np.linalg.norm(matrix, 2, axis=(-2, -1))[..., None, None]
    scaled = np.trunc((matrix / np.maximum(norm, 1.0) - states) * one).astype(np.int64)
    found = np.empty_like(words)
    found[..., np.ravel(places)] = scaled.reshape(*words.shape[:-1], 9)
    return found


def paid_at_first(part: dict[str, np.ndarray]) -> None:
    """Let the first tick of a stretch pay for more: a large wave of which W gives nothing back."""
    for name in ("ends", "mode", "shape", "current", "root"):
        part[name] = part[name].copy()
    part["ends"][0] = 0
    part["mode"][0] = GOLDEN.SHAPE
    part["shape"][0] = 0
    part["current"][0] = FORMATS.CURRENT.raw_max
    part["root"][0] = FORMATS.ROOT.raw_max


def random_stream(seed: int) -> Stream:
    """TICKS ticks in stretches of different character: corners, the whole range, and real life."""
    rng = np.random.default_rng(seed)
    data, eta_format, a_format = FORMATS.WAVE, FORMATS.ETA, FORMATS.A
    eta_one, a_one = 1 << eta_format.fraction, 1 << a_format.fraction
    root_real = FORMATS.ROOT.to_raw(np.sqrt(2 * 2.18))

    def words(ticks: int, draw) -> np.ndarray:
        """Words of each tick, or one for the whole stretch, so that f has time to settle."""
        if rng.random() < 0.5:
            return np.broadcast_to(draw((1, PORTS)), (ticks, PORTS))
        return draw((ticks, PORTS))

    def among(*values: int):
        return lambda shape: rng.choice(np.array(values, dtype=np.int64), shape)

    def between(low: int, high: int):
        return lambda shape: rng.integers(low, high, shape, endpoint=True)

    def small(format_):
        """All magnitudes alike, from one bit to the whole word."""

        def draw(shape):
            bits = rng.integers(1, format_.width, shape)
            return rng.integers(0, 1 << bits) * rng.choice([-1, 1], shape)

        return draw

    corners = among(data.raw_min, data.raw_min + 1, -1, 0, 1, data.raw_max - 1, data.raw_max)
    coefficient_corners = among(eta_format.raw_min, -eta_one, -1, 0, 1, eta_one, eta_format.raw_max)
    draws = {
        "current": [corners, between(data.raw_min, data.raw_max), small(data)],
        "eta": [
            coefficient_corners,
            between(eta_format.raw_min, eta_format.raw_max),
            between(-eta_one, eta_one),
            among(-eta_one, eta_one),
        ],
        "outside": [corners, between(data.raw_min, data.raw_max), small(data), among(0)],
        "root": [
            coefficient_corners,
            between(eta_format.raw_min, eta_format.raw_max),
            among(root_real),
        ],
        "a": [
            coefficient_corners,
            between(1, a_one),
            small(a_format),
            among(a_one),
            among(max(1, a_one >> 20)),
        ],
        "u_max": [
            corners,
            between(0, data.raw_max),
            lambda shape: np.abs(small(data)(shape)),
            among(data.raw_max),
            among(0),
        ],
    }
    parts: list[dict[str, np.ndarray]] = []
    left = TICKS
    while left:
        ticks = min(left, int(rng.integers(1, 300)))
        left -= ticks
        part = {
            name: words(ticks, choices[rng.integers(len(choices))])
            for name, choices in draws.items()
        }
        for name in ("extra", "hold"):
            ages = rng.integers(0, AGE_MAX, ticks, endpoint=True)
            part[name] = ages if rng.random() < 0.3 else np.full(ticks, ages[0])
        ends = rng.integers(0, 4, (ticks, PORTS))
        part["ends"] = ends * (rng.random((ticks, PORTS)) < rng.choice((0.0, 0.0, 0.1, 0.9)))
        modes = rng.integers(0, 3, (ticks, PORTS))
        part["mode"] = modes if rng.random() < 0.2 else np.full((ticks, PORTS), modes[0])
        part["shape"] = shaper_words(rng, ticks)
        if SHAPER and rng.random() < 0.8:
            paid_at_first(part)
        part["pause"] = np.where(rng.random(ticks) < 0.1, rng.integers(0, 40, ticks), 0)
        part["at"] = rng.integers(1, CLOCKS_A_PORT * PORTS, ticks)
        part["poke"] = rng.random(ticks) < 0.02
        part["abort"] = (rng.random(ticks) < 0.005) & ~part["poke"]
        part["reset"] = rng.random(ticks) < 0.01
        parts.append(part)
    return Stream(**{name: np.concatenate([part[name] for part in parts]) for name in parts[0]})


def small_waves_through_eighths(stream: Stream, seed: int) -> Stream:
    """The stream and EIGHTHS ticks more, in which W's sums end on a whole place or just below it.

    Their waves are so small that one less in a coefficient is next to nothing in the sum.
    """
    rng = np.random.default_rng([seed, 1])
    more = first_ticks(stream, EIGHTHS)
    size = more["shape"].shape
    eighths = rng.integers(-7, 8, size) << (FORMATS.SHAPE.fraction - 3)
    more["shape"] = eighths - rng.integers(0, 2, size)
    more["shape"][..., GOLDEN.LOSS1 :] = 0
    more["mode"][:] = 2
    more["u_max"][:] = FORMATS.WAVE.raw_max
    largest = 1 << rng.integers(1, FORMATS.DATA_W - 11, (EIGHTHS, PORTS))
    for name in ("outside", "current"):
        more[name] = rng.integers(-largest, largest)
    more["reset"][:] = more["abort"][:] = False
    paid_at_first(more)
    return joined(stream, more)


def at_the_limit(stream: Stream, seed: int) -> Stream:
    """The stream and LIMITS ticks more, whose f comes out at ±u_max or a guarded place beside it.

    Each begins at f = 0 with a goal from outside alone, of which a power of two is taken.
    """
    rng = np.random.default_rng([seed, 2])
    more = first_ticks(stream, LIMITS)
    shift = rng.integers(0, FORMATS.STATE_GUARD + 1, (LIMITS, PORTS))
    more["a"] = (1 << FORMATS.A.fraction) >> shift
    more["u_max"] = rng.integers(0, FORMATS.WAVE.raw_max >> FORMATS.STATE_GUARD, (LIMITS, PORTS))
    goal = (more["u_max"] << shift) + rng.integers(-1, 2, (LIMITS, PORTS))
    more["outside"] = goal * rng.choice((-1, 1), (LIMITS, PORTS))
    more["eta"][:] = 0
    more["reset"][:] = True
    more["abort"][:] = more["poke"][:] = False
    return joined(stream, more)


def first_ticks(stream: Stream, ticks: int) -> dict[str, np.ndarray]:
    """Words of a stream's first ticks, to be changed."""
    return {name: words[:ticks].copy() for name, words in vars(stream).items()}


def joined(stream: Stream, more: dict[str, np.ndarray]) -> Stream:
    """The stream with more ticks behind it."""
    return Stream(
        **{name: np.concatenate([words, more[name]]) for name, words in vars(stream).items()}
    )


@cocotb.test(timeout_time=60, timeout_unit="sec")
async def equals_the_integer_model(dut) -> None:
    """Every word of a long stream, the clocks, the overruns, and what resets leave behind."""
    seed = int(os.environ.get("WH_SEED", "20"))
    dut._log.info("WH_SEED=%d", seed)
    bench = Bench(dut)
    stream = random_stream(seed)
    if SHAPER:
        stream = small_waves_through_eighths(stream, seed)
    stream = at_the_limit(stream, seed)
    answers = await bench.run(stream)
    bench.check(stream, answers)
    if OUTSIDE:
        # Whole guarded places: only what is beyond the limit is limited.
        last = {name: words[-LIMITS:] for name, words in vars(stream).items()}
        places = last["a"] >> (FORMATS.A.fraction - FORMATS.STATE_GUARD)
        f = np.abs(last["outside"]) * places
        limit = last["u_max"] << FORMATS.STATE_GUARD
        assert np.array_equal(answers.saturated[-LIMITS:] != 0, f > limit)
        assert (f == limit).any()
        assert (f == limit + 1).any()
    # The stream has gone where it was meant to.
    assert answers.saturated.any()
    assert not answers.saturated.all()
    assert answers.u.max() > FORMATS.WAVE.raw_max // 2
    for values in (answers.v, answers.voltage):
        assert values.max() == FORMATS.WAVE.raw_max
        assert values.min() == FORMATS.WAVE.raw_min
    if WITHHELD:
        assert answers.withheld.max() == FORMATS.WAVE.raw_max
        assert answers.withheld.min() == FORMATS.WAVE.raw_min
        assert np.isin((-1, 1), answers.withheld).all()
    assert SHAPER == 0 or set(np.unique(stream.mode)) == {0, 1, 2}
    # Clipped with either sign of v and v at 0, and by v alone.
    ended = stream.ends != 0
    assert answers.clipped[ended & ~stream.abort[:, None]].all()
    assert {-1, 0, 1} == set(np.unique(np.sign(answers.v[ended])))
    assert answers.clipped[~ended].any()
    assert not answers.clipped.all()
    assert stream.abort.any()
    assert stream.reset.any()
    assert answers.overrun.any()
