# SPDX-License-Identifier: Apache-2.0
"""Words that change while the motor runs: nothing is half changed, and no energy is made of it.

What is checked here knows nothing of the integer models. A step is three equations between words
that are seen, where f_n+1 is u of k + 1 ticks later:

    (1)  v_n   = u_n − s·i_n
    (2)  f_n+1 = clip(f_n + a·(η·W{v_n} − f_n), ±(u_max − |c|/s))
    (3)  e_n   = s·f_n+1 + c

and the bridge makes h·e_n V of it, h being clocks_per_volt over what the bus wants.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from device_pins import COMMIT, DevicePins
from live_device import ANCHOR, BOARD, FEEL, OTHER_FEEL, copied_clocks, load, run
from wavehaptics.controller import anchor, wave_core
from wavehaptics.controller.settings import settings
from wavehaptics.laws import closed_forms
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats
from wavehaptics.words.memory import settings_requests
from wavehaptics.words.table import Values

PREFIX = 40_000
"""Ticks before the first change: in the midst of the press, which takes 50 ms."""

ASKED = 4
"""Ticks before the commit in which its words are written."""


class Run:
    """A device, what was asked of it and what it did."""

    def __init__(self, *scene: str, prefix: int = PREFIX) -> None:
        self.simulation = DevicePins(load(*scene))
        self.clocks: int = self.simulation.timing.tick_clocks
        self.tick_s = self.simulation.tick_s
        self.late: int = self.simulation._values["extra_ticks"]
        assert self.simulation._values["hold_ticks"] == 0
        self.base: Values = dict(self.simulation._values)
        self.rows, self.words = run(self.simulation, prefix)
        self.first = self.simulation.bus_clock
        self.prefix = prefix

    def change(self, plan: list[tuple[int, Values]], ticks: int) -> list[int]:
        """Commit words at clocks from now on; the row of the tick in which each was accepted."""
        begin, before = self.simulation.bus_clock, len(self.rows)
        sizes = []
        for clock, values in plan:
            pairs = settings_requests(values)
            sizes.append(len(pairs) + 1)
            for address, raw in pairs:
                self.simulation.ask(address, raw, begin + clock - ASKED * self.clocks)
            self.simulation.ask(COMMIT, 1, begin + clock)
        rows, words = run(self.simulation, ticks)
        answers = self.simulation.answers()
        assert len(answers) == sum(sizes)
        assert all(answer.error == 0 for answer in answers)
        assert self.simulation.faults == 0
        self.rows = np.vstack([self.rows, rows])
        self.words = np.vstack([self.words, words])
        ends = np.cumsum(sizes) - 1
        return [before + (answers[end].clock - begin) // self.clocks for end in ends]

    @property
    def contact(self) -> np.ndarray:
        """Where the rotor is in a wall, bool."""
        return self.column(Column.CONTACT) != 0.0

    def column(self, column: Column) -> np.ndarray:
        return self.rows[:, column]

    def si(self, word: Word, format_: formats.Fixed) -> np.ndarray:
        return self.words[:, word] * format_.step


# ---- Nothing is half changed.


States = tuple[tuple[float, float], ...]
"""Of each section of W, √W."""


@dataclass(frozen=True)
class Set:
    """What of the words a step is made with, in SI."""

    s: float
    a: float
    u_max: float
    eta: float
    scale: float
    shape: tuple[tuple[float, ...], ...]

    @staticmethod
    def of(values: Values, base: Values) -> Set:
        coefficients = np.array(values.get("shape_coefficient", []), dtype=float)
        shape = coefficients.reshape(-1, wave_core.LOSS1) * formats.SHAPE.step
        return Set(
            formats.ROOT.to_value(int(values["root"])), formats.A.to_value(int(values["a"])),
            int(values["u_max"]) * formats.WAVE.step,
            formats.ETA.to_value(int(values["eta_contact"])),
            int(values["clocks_per_volt"]) / int(base["clocks_per_volt"]),
            tuple(map(tuple, shape.tolist())),
        )  # fmt: skip

    def shaped(self, states: States, v: float) -> tuple[float, States]:
        """W{v}, and the states after it."""
        after = []
        for (e11, e12, e21, e22, b1, b2, c1, c2, d), (x, y) in zip(self.shape, states, strict=True):
            after.append((x + e11 * x + e12 * y + b1 * v, y + e21 * x + e22 * y + b2 * v))
            v = c1 * x + c2 * y + d * v
        return v, tuple(after)

    def at_rest(self) -> States:
        """The states of a W that begins."""
        return ((0.0, 0.0),) * len(self.shape)


def energy(states: States) -> float:
    """|x|², W."""
    return sum(x * x + y * y for x, y in states)


BUS_V = 12.0
assert f"drive.bus_v={BUS_V:g}" in BOARD

STEP = 3e-5
"""What (1) to (3) may be off by, √W and V: their roundings, and those of W's states."""


def followed(device: Run, sets: list[Set], accepted: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """(which of ``sets`` is in force, |x|² of W's states before the step) of every tick.

    Each step fits to all words of one set, and from the first one that fits to the next on all do.
    """
    u, v = device.si(Word.U, formats.WAVE).tolist(), device.si(Word.V, formats.WAVE).tolist()
    i, e = device.si(Word.I, formats.CURRENT).tolist(), device.si(Word.E, formats.VOLTAGE).tolist()
    c = [*device.column(Column.CORRECTION)[1:].tolist(), 0.0]
    late = device.late
    states = sets[0].at_rest()

    def wrong(n: int, words: Set) -> tuple[float, States]:
        """How far the step of tick ``n`` is from these words, and W's states after it."""
        shaped, after = words.shaped(states, v[n])
        goal = u[n + late] + words.a * (words.eta * shaped - u[n + late])
        off = []
        for room in {abs(c[n - 1]) / one.s for one in sets[:2]}:  # of c as it was a step ago
            limit = max(words.u_max - room, 0.0)
            off.append(abs(u[n + late + 1] - min(max(goal, -limit), limit)))
        return max(
            abs(v[n] - (u[n] - words.s * i[n])), min(off),
            abs(e[n] - c[n] - words.s * u[n + late + 1]),
        ), after  # fmt: skip

    present = np.zeros(len(u), dtype=np.int64)
    held = np.zeros(len(u))
    now = 0
    begin = int(np.flatnonzero(~device.contact)[-1]) + 1
    for n in range(begin, len(u) - late - 2):
        off, after = wrong(n, sets[now])
        if off > STEP and now < len(accepted):
            copied = copied_clocks(len(sets[0].shape)) // device.clocks
            assert accepted[now] + copied - 1 <= n <= accepted[now] + copied + 3, n
            now += 1
            off, after = wrong(n, sets[now])
        assert off < STEP, (n, now)
        present[n], held[n] = now, energy(states)
        states = after
    present[len(u) - late - 2 :] = now
    assert now == len(accepted)
    return present, held


@pytest.mark.parametrize(
    "scene",
    [(), ANCHOR, (*ANCHOR, "controller.clock_hz=38e6", "controller.extra_ticks=2"), FEEL],
    ids=["plain", "anchor", "short", "w"],
)
def test_a_tick_is_made_with_old_words_or_with_new_ones(scene):
    """(1) to (3) and the bridge, each by the words of before or each by those that were given.

    At each clock of a tick, to and fro, in contact. The pulses come to Σ e·h/h₀ within a clock of
    the bridge: one voltage of the old words scaled by the new ones would be more than that off, and
    for good, as the modulator owes no more than half of it. Each duty is cut by a last place.
    """
    far = 60
    device = Run(*scene)
    base, late = device.base, device.late
    other = dict(base) | {
        "root": int(int(base["root"]) * 0.8),
        "a": int(int(base["a"]) * 0.6),
        "u_max": formats.WAVE.to_raw(0.15),
        "eta_contact": int(int(base["eta_contact"]) * 0.9),
        "clocks_per_volt": int(int(base["clocks_per_volt"]) * 0.6),
    }
    if scene == FEEL:
        shaper = settings(load(*OTHER_FEEL)).shaper.words
        other["shape_coefficient"] = shaper[:, : wave_core.LOSS1].ravel().tolist()
        other["shape_loss"] = shaper[:, wave_core.LOSS1 :].ravel().tolist()
    names = ("root", "a", "u_max", "eta_contact", "clocks_per_volt",
             *(("shape_coefficient", "shape_loss") if scene == FEEL else ()))  # fmt: skip
    given = [other, base] * device.clocks
    plan = [
        ((n + 1) * far * device.clocks + n // 2, {name: words[name] for name in names})
        for n, words in enumerate(given)
    ]
    accepted = device.change(plan, (len(plan) + 2) * far)

    sets = [Set.of(words, base) for words in (base, *given)]
    assert device.contact[device.prefix :].all()
    present, _ = followed(device, sets, accepted)
    u, e = device.si(Word.U, formats.WAVE), device.si(Word.E, formats.VOLTAGE)
    limits = np.array([one.u_max for one in sets])[present]
    scales = np.array([one.scale for one in sets])[present]
    assert (np.abs(u) > 0.999 * limits)[device.prefix :].sum() > 10

    wanted = np.zeros(len(u))
    wanted[1 + late :] = (e * scales)[: -1 - late]
    clock_v = 2 * BUS_V / device.simulation.timing.half_clocks
    owed = np.cumsum((device.column(Column.E_A) - wanted)[device.prefix : -late - 2])
    assert np.ptp(owed) < clock_v * (1.0 + len(owed) * formats.DUTY.step)


SHAKEN = ("hand.path=sine", "hand.frequency_hz=5", "controller.walls=[[-2.0, 2.0]]")


def test_a_limit_below_what_the_anchor_takes_leaves_no_wave():
    """With u_max = 0 in contact u is 0, c within its limits, and the port gives no energy.

    The room that c takes is more than there is then. As a limit below 0 it made |c|/s of it, a wave
    that no other one had caused, always the same way: it took c with it to 2 c_0, a wall on one
    side was gone, and the waves gave out 2 mJ in the quarter of a second.
    """
    device = Run(*ANCHOR, *SHAKEN, prefix=60_000)
    taken = device.change([(10 * device.clocks, {"u_max": 0})], 200_000)[0]
    copied = copied_clocks() // device.clocks
    still = slice(taken + copied + device.late + 3, None)
    assert not device.words[still, Word.U].any()
    c, i = device.column(Column.CORRECTION)[still], device.column(Column.I)[still]
    words = device.simulation.settings.anchor
    c_0 = words[anchor.REACH] * formats.VOLTAGE.step
    y = np.abs(device.column(Column.I)).max() * words[anchor.CELLS_GAIN] * formats.CELLS.step
    y_b = words[anchor.BRUSH] * anchor.SEEN_CELLS
    assert np.abs(c).max() > c_0
    assert np.abs(c).max() < c_0 + words[anchor.LEARN_MAX] * formats.PULL.step * (y + y_b)
    assert i.min() < -0.3
    assert i.max() > 0.3
    waves = np.cumsum(device.column(Column.ENERGY_OUT)[still] - c * i * device.tick_s)
    assert (waves - np.minimum.accumulate(waves)).max() < 1e-6
    assert waves[-1] < -10e-3


# ---- No energy is made of it.

WINDOW = 300
"""Ticks from one change to the next, in which what was stored comes out."""

R_OHM, L_H = 2.18, 0.24e-3
LOW = f"controller.r_hat={0.9 * R_OHM}"
"""R̂ as it is with an anchor, too."""

QUIET = ("adc.noise_a=0",)
SHAKE = ("hand.path=sine", "hand.frequency_hz=200", "hand.amplitude_rad=0.04",
         "hand.stiffness=0.5", "controller.walls=[[-1.0, 1.0]]")  # fmt: skip
STATES = {
    "held": ANCHOR,
    "free": (*ANCHOR, "controller.walls=[[0.5, 1.0]]", "hand.path=sine", "hand.frequency_hz=20"),
    "limited": (*SHAKE, LOW, "drive.limit_v=2.0"),
    "worked": (*ANCHOR, *SHAKE),
    "soft": (*FEEL, LOW),
}  # fmt: skip
"""The rotor whose words change: a hand rests on it in a wall; it swings freely; it is shaken in a
wall that is at the voltage limit, and in one that isn't; a hand rests in a layer of W."""

HOLDS = ("lambda", "R up", "R down", "limit down", "limit up", "gain up", "gain down", "volts up",
         "volts down", "hysteresis", "wall moved over the rotor")  # fmt: skip
"""What leaves a wall as hard as it was, or nearly, and where it was."""


def changes(device: Run, scene: tuple[str, ...]) -> dict[str, Values]:
    """Words to be given and taken back, raw, by what they change."""
    base, one = device.base, 1 << formats.ETA.fraction
    walls = {name: list(base[name]) for name in ("wall_min", "wall_max", "wall_enable")}
    count = int(device.column(Column.X)[-1] / device.simulation.settings.cell_rad)

    def port(*words: str) -> Values:
        """λ or R̂ as a scene has it, and all that goes with it: limit and anchor as well."""
        names = ("root", "a", "u_max", "anchor_words")
        return {n: w for n, w in settings(load(*scene, *words)).words().items() if n in names}

    def wall(**first: int) -> Values:
        return {name: [first.get(name, old[0]), *old[1:]] for name, old in walls.items()}

    def part(name: str, times: float) -> Values:
        return {name: int(int(base[name]) * times)}

    r_hat = R_OHM * (1.0 if ANCHOR[0] in scene else 0.9)
    found = {
        "lambda": port("controller.lambda=2e4"),
        "eta": {"eta_contact": -one // 2, "eta_free": one // 2},
        "eta turned": {"eta_contact": one, "eta_free": -one},
        "wall moved": wall(wall_min=walls["wall_min"][0] + 4000),
        "wall moved over the rotor": wall(
            wall_min=count - 400, wall_max=count + 400, wall_enable=1
        ),
        "wall switched": wall(wall_enable=1 - walls["wall_enable"][0]),
        "wall's other side": wall(wall_min=count - 400, wall_max=count + 20, wall_enable=1),
        "hysteresis": {"edge_hysteresis": 1},
        "R up": port(f"controller.r_hat={1.1 * r_hat}"),
        "R down": port(f"controller.r_hat={0.9 * r_hat}"),
        "limit down": part("u_max", 0.25),
        "no limit": part("u_max", 0.0),
        "limit up": part("u_max", 1.2),
        "gain up": part("gain", 1.1),
        "gain down": part("gain", 0.9),
        "zero": {"zero": 64},
        "volts up": part("clocks_per_volt", 1.1),
        "volts down": part("clocks_per_volt", 0.9),
    }
    if device.base.get("shape_coefficient"):
        other = settings(load(*scene, *OTHER_FEEL)).shaper.words
        found["W"] = {
            "shape_coefficient": other[:, : wave_core.LOSS1].ravel().tolist(),
            "shape_loss": other[:, wave_core.LOSS1 :].ravel().tolist(),
        }
        found["rigid"] = {"wall_shaped": [0] * len(walls["wall_min"])}
    return found


SOME = ("lambda", "R up", "limit down", "wall switched", "W")


def w_energies(device: Run, words: Values, accepted: list[int]) -> np.ndarray:
    """|x|² of W's states before the step of each tick, W."""
    held = np.zeros(len(device.rows))
    base = Set.of(device.base, device.base)
    if not base.shape:
        return held
    if "shape_coefficient" in words:
        other = Set.of(dict(device.base) | dict(words), device.base)
        return followed(device, [base, *[other, base] * device.clocks], accepted)[1]
    rigid = np.zeros(len(held), dtype=np.bool_)
    if "wall_shaped" in words:
        for out, back in zip(accepted[::2], accepted[1::2], strict=True):
            rigid[out + 1 : back + 1] = True
    states, contact = base.at_rest(), device.contact
    for n, v in enumerate(device.si(Word.V, formats.WAVE).tolist()):
        held[n] = energy(states)
        if not contact[n]:
            states = base.at_rest()
        elif not rigid[n]:
            _, states = base.shaped(states, v)
    return held


def given_out(device: Run, words: Values) -> np.ndarray:
    """(most energy that the port gives out, its bound), J, of a change at each clock, to and fro.

    ``float (changes, 2)``; the derivation is that of :func:`test_no_energy_is_made_of_a_change`.
    """
    back = {name: device.base.get(name, 0) for name in words}
    plan = [
        ((n + 1) * WINDOW * device.clocks + n // 2, (words, back)[n % 2])
        for n in range(2 * device.clocks)
    ]
    accepted = device.change(plan, (len(plan) + 2) * WINDOW)
    late, tick_s = device.late, device.tick_s
    u, v, i = (device.column(column) for column in (Column.U, Column.V, Column.I))
    c = np.zeros(len(i))
    if device.simulation.settings.anchored:  # what was in the measured tick's voltage, k ticks late
        c[late:] = device.column(Column.CORRECTION)[: len(i) - late]
    power = device.column(Column.ENERGY_OUT) - c * i * tick_s

    def both(name: str) -> tuple[int, int]:
        return int(device.base[name]), int(words.get(name, device.base[name]))

    a = formats.A.to_value(min(both("a")))
    s = [formats.ROOT.to_value(raw) for raw in both("root")]
    volts, gains = both("clocks_per_volt"), both("gain")
    weight = max(1.0, volts[1] / volts[0]) * max(1.0, gains[0] / gains[1])
    wrong_a = device.simulation.sensor.full_scale_a / (1 << device.simulation.sensor.bits)
    wrong_a += abs(int(words.get("zero", 0))) * max(gains) * formats.GAIN.step
    clock_v = 2 * BUS_V / device.simulation.timing.half_clocks
    held = w_energies(device, words, accepted)
    found = []
    for at, end in zip(accepted, [*accepted[1:], len(u)], strict=True):
        begin, end = at - 1, end - 1
        flying = [slice(n, n + late + 1) for n in range(begin, at + 3)]
        stored = 0.5 * tick_s * max(
            (u[some] ** 2).sum() + (1.0 / a - 1.0) * u[some][-1] ** 2 for some in flying
        )  # fmt: skip
        stored += 0.5 * tick_s * held[begin : at + 3].max()
        misjudged = (late + 1) * tick_s * abs(s[1] - s[0]) * np.abs(u * i)[begin : at + 6].max()
        steps = tick_s * (end - begin) * max(s) * np.abs(v[begin:end]).max() * wrong_a
        clocks = tick_s * clock_v / 2 * (np.abs(i[begin]) + np.abs(np.diff(i[begin:end])).sum())
        found.append(
            (np.cumsum(power[begin:end]).max(), weight * (stored + steps) + misjudged + clocks)
        )
    return np.array(found)


@pytest.mark.kept("held-some", "free-some", "limited-some", "worked-some", "soft-some")
@pytest.mark.parametrize("every", [False, True], ids=["some", "every"])
@pytest.mark.parametrize("state", STATES)
def test_no_energy_is_made_of_a_change(state, every):
    """The port gives out no more than was stored in it, after a change at any clock of a tick.

    Let the bridge give h·e for e = s·u + c, the sensor tell g·i + δ, R be the winding's and
    R̂ = s²/2. With v = u − s·(g·i + δ), a tick's energy out of the port but for c is, by Jensen,

        E_n = T·(h·s·u·i − R·⟨i²⟩) ≤ w·T·½(u² − v²) − T·(R − h·g·R̂)·i² + w·T·δ·(…),   w = h/g  (4)

    and h·g·R̂ ≤ R here. What comes back, |η·W{v}|, and the filter, f' = f + a(η·W{v} − f), obey

        f'² + (1/a − 1)·f'² ≤ (1/a − 1)·f² + v² − Δ|x|²                                      (5)

    as the square is convex, for W with the states x, |x'|² + y² ≤ |x|² + v²; a limit only lessens
    f'. f' is u of k + 1 ticks later. So from a step n on

        Σ E ≤ w·½T·(Σ_{n…n+k} u² + (1/a − 1)·u_{n+k}² + |x_n|²)                               (6)

    is all that can come out: the waves in flight, the filter's, W's. A change of a raises the
    filter's, so its new a counts; of w the larger; one of η, W's words, walls and limits changes
    none of them. One of s finds k + 1 waves made with the old s: T·|s₁ − s₂|·|u·i| for each. The
    ADC's δ is half a step, and what a zero is off by, T·s·|v|·δ for each tick; the pulses are off
    by half a clock in their sum. A hand that rests in a wall is moved by less than two cells where
    the port is still one that holds.
    """
    scene = (*QUIET, *STATES[state])
    for name in changes(Run(*scene, prefix=1000), scene):
        if not every and name not in SOME:
            continue
        device = Run(*scene, prefix=60_000)
        found = given_out(device, changes(device, scene)[name])
        assert not device.column(Column.FAULT).any()
        assert len(found) == 2 * device.clocks
        assert (found[:, 0] < found[:, 1]).all(), name
        if state == "held" and name in HOLDS:
            moved = np.ptp(device.column(Column.X)[60_000:])
            assert moved < 2 * device.simulation.settings.cell_rad, name


@pytest.mark.parametrize("gain", [1.999, -2.0, -1.1])
def test_no_words_of_w_make_the_port_a_source(gain):
    """W = 2 would be a source: 0.4 mJ in 40 ms. It pays for what it gives, but for one tick's wave.

    Whatever is written, Σ y² ≤ Σ v² + y², and as |u| ≤ u_max no more than ½T·u_max² comes out.
    """
    device = Run(*QUIET, *STATES["soft"], prefix=2000)
    words = [0] * len(device.base["shape_coefficient"])
    words[wave_core.D] = formats.SHAPE.to_raw(gain)
    loss = [0] * len(device.base["shape_loss"])
    device.change([(10 * device.clocks, {"shape_coefficient": words, "shape_loss": loss})], 100_000)
    assert device.contact[-1]
    assert device.words[-1, Word.V] != 0
    u_max = formats.WAVE.to_value(device.base["u_max"])
    out = np.cumsum(device.column(Column.ENERGY_OUT))
    assert out.max() < 0.5 * device.tick_s * u_max**2


def test_a_port_that_gives_energy_is_seen():
    """The check can fail: with h·g·R̂ = 1.6 R, against (4), more comes out than was there."""
    device = Run(*QUIET, *STATES["worked"], prefix=60_000)
    found = given_out(device, {"clocks_per_volt": int(int(device.base["clocks_per_volt"]) * 1.8)})
    assert found[:, 0].max() > 10 * found[:, 1].max()


def test_a_slower_lambda_gives_out_what_the_softer_spring_holds():
    """Pressed with λ = 5·10⁵ and let go with 10⁴, a rotor gets back more than it took.

    The filter's wave is the force, which stays, and its spring is 2·k_T²·λ/R: at the same force F a
    softer one holds ½F²(1/K₂ − 1/K₁) more. That is ½T·u²·(1/a₂ − 1/a₁) of (6), with u = s·i/2 at
    rest, and a hand that draws back at once gets nearly all of it.
    """
    taps = ("hand.path=taps", "hand.frequency_hz=40", "hand.amplitude_rad=0.02",
            "hand.stiffness=1", f"controller.r_hat={R_OHM}")  # fmt: skip
    rows = 12_500
    device = Run(*QUIET, *taps, prefix=rows)
    slow = settings(load("controller.lambda=1e4")).a
    (at,) = device.change([(ASKED * device.clocks, {"a": slow})], rows)
    plant, a = device.simulation.winding.plant, formats.A.to_value
    fast, slow = a(int(device.base["a"])), a(slow)
    force = plant.k_t * device.rows[at, Column.I]
    spring = 2 * plant.k_t**2 / (R_OHM * device.tick_s)
    more = 0.5 * force**2 / spring * (1.0 / slow - 1.0 / fast)
    u = device.column(Column.U)[at : at + device.late + 1]
    stored = 0.5 * device.tick_s * ((u**2).sum() + (1.0 / slow - 1.0) * u[-1] ** 2)
    out = np.cumsum(device.column(Column.ENERGY_OUT))
    assert more == pytest.approx(16.8e-6, rel=0.02)
    assert 0.85 * more < out[at:].max() - out[at] < stored
    assert out.max() > 0.8 * more
    same = Run(*QUIET, *taps, prefix=2 * rows)
    assert np.cumsum(same.column(Column.ENERGY_OUT)).max() < 0.01 * more


@pytest.mark.parametrize("factor", [4.5, 2.0, 1.25])
def test_a_limit_that_is_raised_while_it_is_at_work(factor):
    """The wall comes back to where it was.

    Pressed beyond a limit of 2.1 V the wall owes the way that it gave, χ of a hundred cells. A
    lost encoder looks like that, but the limit excuses it until the rotor has followed.
    """
    device = Run(*ANCHOR, *QUIET, "drive.limit_v=2.1", "hand.stiffness=0.3", prefix=60_000)
    assert device.rows[-1, Column.SATURATED] == 1.0
    assert device.rows[-1, Column.FLUX] > 50.0
    limit_v, times = 2.1, 1.0
    while limit_v * times < 9.0:
        times *= factor
        u_max = int(int(device.base["u_max"]) * times)
        device.change([(ASKED * device.clocks, {"u_max": u_max})], 20_000)
    assert not device.column(Column.FAULT).any()
    torque, x = device.rows[-1, Column.TORQUE], device.rows[-1, Column.X]
    plant, made = device.simulation.winding.plant, device.simulation.settings
    k = closed_forms.stiffness(plant.k_t, L_H, R_OHM, made.tau)
    assert -torque / k == pytest.approx(x, abs=2 * made.cell_rad)
