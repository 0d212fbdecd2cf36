# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_brushless.v`` at its pins, open loop.

ADC parts and an encoder are wired to the pins, and the gates are read in every clock. What the
controller shows of each step is compared with the integer models, from the codes to the gates.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import cocotb
import numpy as np
from adc_part import AdcPart
from bench import Bench, pack, random_source, unpack
from lost_encoder import LostEncoder
from simulators import parameters
from tb_quadrature import SETTLE_CLOCKS, levels
from tb_three_phase import Drive, gates_of
from wavehaptics.controller import clarke, wave_core
from wavehaptics.controller.guard import Fault
from wavehaptics.controller.modulator import duty_of, new_dead_time
from wavehaptics.controller.normalised import quantise, realise
from wavehaptics.controller.pins_timing import (
    CENTRED_LEAD,
    CORE_CLOCKS,
    CURRENT_CLOCKS,
    GATE_CLOCKS,
    HOLD_CLOCKS,
    SECTION_CLOCKS,
)
from wavehaptics.laws.reflection import Wish, reflection
from wavehaptics.motor.sensor import scale_sum
from wavehaptics.parts.adcs import PARTS, frame
from wavehaptics.words import formats, table
from wavehaptics.words.table import AXES, THREE_PHASE_LEGS, Sizes

GUARD = parameters().get("GUARD", 0)
SENSE = parameters().get("SENSE", 0)
SHAPER = parameters().get("SHAPER", 0)
ZERO_TICKS = 1 << parameters().get("ZERO_LOG2", 10)
WALLS = 4
DELAY_LOG2 = 2
SIZES = Sizes(1, WALLS, 0, DELAY_LOG2, THREE_PHASE_LEGS)
CLOCK_HZ = 52e6
PERIOD_NS = 1e9 / CLOCK_HZ
PINS_NS = 2.0
PART = PARTS["AD7276"]
FRAME = frame(PART, CLOCK_HZ)
MIDDLE = 1 << (PART.bits - 1)
SHIFT = formats.SAMPLE_W - PART.bits
RANGE = (MIDDLE // 2) << SHIFT
"""A converter that may be trusted up to half of its scale, so that some words are clipped."""
R_OHM = 4.7
FULL_SCALE_A = 2.0
WALL = (0, 1000)
PLACES = [(5, 10), (21, 42), (53, 64), (73, 86)]
"""Walls; of their places and of those mirrored every bit is set in some and clear in others."""
Walls = Sequence[tuple[int, int]]
ETA_CONTACT = formats.ETA.to_raw(-0.9)
ETA_FREE = formats.ETA.to_raw(0.8)
ROOT = formats.ROOT.to_raw(math.sqrt(2 * R_OHM))
A = formats.A.to_raw(0.7)
U_MAX = formats.WAVE.to_raw(4.0 / math.sqrt(2 * R_OHM))
EXTRA_CLOCKS = 7
"""Clocks from a current to the end of a period that it counts for: wh_dead_time, wh_modulator."""
CLARKE_CLOCKS = 7
"""Clocks from the currents of the phases to those of the axes."""
LATENCY = FRAME.conversion_clocks + 80 + 10 * SHAPER
STEP_CLOCKS = AXES * (CORE_CLOCKS + SECTION_CLOCKS * SHAPER)
HALF = STEP_CLOCKS // 2 + 2
"""Clocks of a carrier half, of which a tick has two."""


@dataclass
class Step:
    """What the controller showed with core_valid_o: of alpha and beta, or a and b."""

    clock: int
    phases: list[int]
    current: list[int]
    u: list[int]
    v: list[int]
    voltage: list[int]
    contact: int
    saturated: int
    clipped: int
    anchored: int
    """Whatever only anchors make."""
    rests: int
    """Clocks since the encoder moved."""
    position: int


def wave_filter() -> np.ndarray:
    """Words of W: a soft wall's sections, which differ."""
    wishes = [Wish(0.0, 1e-4, spring, 1.117) for spring in (0.3, 0.8)[:SHAPER]]
    sections = [quantise(realise(*reflection(wish, 2.28e-4), 3e-5)) for wish in wishes]
    return np.array(sections, dtype=np.int64).reshape(SHAPER, wave_core.SECTION_WORDS)


W = wave_filter()


def ends_of(codes: list[int]) -> int:
    """At which ends of the range a sum's codes are."""
    words = [(code - MIDDLE) << SHIFT for code in codes]
    high, low = max(words) >= RANGE, min(words) <= -RANGE
    return high * formats.AT_HIGH | low * formats.AT_LOW


def lead(drive: Drive) -> int:
    """Clocks that samples come early, for the middle of the gates' pulse."""
    return CENTRED_LEAD - drive.dead_clocks // 2


def settings(
    drive: Drive, samples: int = 1, extra: int = 2, walls: Walls = (WALL,) * WALLS,
    enable: Sequence[int] = (1, 0, 0, 0), shaped: Sequence[int] = (0,) * WALLS, **others: int,
) -> dict[str, int]:  # fmt: skip
    """The controller's inputs, as words."""
    values = {
        "half_clocks": drive.half_clocks,
        "tick_halves": drive.tick_halves,
        "sample_clocks": drive.tick_clocks // samples,
        "samples": samples,
        "sample_lead": lead(drive),
        "range": RANGE,
        **FRAME.words(),
        "eta_contact": ETA_CONTACT,
        "eta_free": ETA_FREE,
        "wall_min": [wall[0] for wall in walls],
        "wall_max": [wall[1] for wall in walls],
        "wall_enable": enable,
        "root": ROOT,
        "a": A,
        "u_max": U_MAX,
        "extra_ticks": extra,
        "clocks_per_volt": drive.per_volt,
        "dead_clocks": drive.dead_clocks,
        "second_order": int(drive.second_order),
        "compensate": int(drive.compensate),
        "side_current": drive.side_current,
        "settle_ticks": drive.settle_ticks,
        **others,
    }
    values["gain"] = formats.GAIN.to_raw(FULL_SCALE_A / ((1 << 15) * samples))
    shape = {
        "shape_coefficient": W[:, : wave_core.LOSS1].ravel().tolist(),
        "shape_loss": W[:, wave_core.LOSS1 :].ravel().tolist(),
    }
    words = table.inputs(shape if SHAPER else {}, Sizes(1, WALLS, SHAPER))["shape_words_i"]
    return table.inputs(values, SIZES) | {
        "shape_words_i": words, "wall_shaped_i": pack(shaped, 1)
    }  # fmt: skip


class BrushlessBench(Bench):
    """Parts on the pins, and a log of what the pins did."""

    zeros = (0, 0)

    async def begin(self, inputs: dict[str, int], zeros: tuple[int, int] = (0, 0)) -> None:
        self.codes = [MIDDLE, MIDDLE]
        self.position = self._stood_at = self._rests = 0
        self.zeros = zeros
        self.parts = [AdcPart(PART, lambda n=n: self.codes[n]) for n in range(2)]
        self.age = 0
        self.conversions: list[tuple[int, list[int]]] = []
        """Clock of each conversion's sample strobe, and the codes held."""
        self.steps: list[Step] = []
        self.ticks: list[int] = []
        self.gates: list[tuple[int, int]] = []
        self._cs_n = 1
        self._phases: deque[int] = deque(maxlen=STEP_CLOCKS + 1)
        await self.start(
            enable_i=1, adc_sdata_i=0, enc_a_i=0, enc_b_i=0, stop_i=0, driver_fault_i=0,
            **(inputs | {"zero_i": pack(zeros, formats.SUM_W)}),
        )  # fmt: skip

    async def clock(self, **inputs: int) -> None:
        """One clock; what it shows goes into the log."""
        self.age += 1
        edge = self.age * PERIOD_NS
        sdata = sum(self.parts[n].sdata(edge - PINS_NS) << n for n in range(2))
        a, b = levels(self.position)
        self._rests = self._rests + 1 if self.position == self._stood_at else 0
        self._stood_at = self.position
        await self.step(adc_sdata_i=sdata, enc_a_i=a, enc_b_i=b, **inputs)
        cs_n, sclk = self.word("adc_cs_n_o"), self.word("adc_sclk_o")
        for part in self.parts:
            part.pins(edge + PINS_NS, cs_n, sclk)
        now = len(self.gates)
        if self._cs_n and not cs_n:
            self.conversions.append((now - HOLD_CLOCKS, [part.held for part in self.parts]))
        self._cs_n = cs_n
        gates = self.word("gate_high_o"), self.word("gate_low_o")
        assert gates[0] & gates[1] == 0
        self.gates.append(gates)
        if self.word("tick_o"):
            self.ticks.append(now)
        self._phases.append(self.word("phase_current_o"))
        if self.word("core_valid_o"):
            self.steps.append(
                Step(
                    now,
                    *(
                        unpack(word, formats.DATA_W, 2)
                        for word in (
                            # Those of the step's start: when it ends the next may have come.
                            self._phases[0],
                            *(self.word(f"{name}_o") for name in ("current", "u", "v", "voltage")),
                        )
                    ),
                    self.word("contact_o"),
                    self.word("saturated_o"),
                    self.word("clipped_o"),
                    self.word("correction_o") | self.word("flux_o") | self.word("lag_o"),
                    self._rests,
                    self.position,
                )
            )

    def _out_of_the_legs(self, step: Step) -> list[tuple[int, int]]:
        """Clock and current of each leg, of which b's begins the step's transform."""
        b_at = step.clock - STEP_CLOCKS - CLARKE_CLOCKS
        a, b = step.phases
        c = wave_core.saturate.py_func(-a - b)
        return [(b_at - 1, a), (b_at, b), (b_at + 1, c)]

    def check(self, drive: Drive, samples: int, extra: int, soft: bool) -> list[list[int]]:
        """Every sample's instant, every step by the models, every gate; the widths of each leg.

        ``soft``: all walls feel as W, or none.
        """
        gain = formats.GAIN.to_raw(FULL_SCALE_A / ((1 << 15) * samples))
        ports = [wave_core.new_state() for _ in range(2)]
        lines = [wave_core.new_line(extra) for _ in range(2)]
        states = [wave_core.new_shaper_state(SHAPER) for _ in range(2)]
        legs_of: list[tuple[int, int, int]] = []
        # The carrier starts a clock behind the end of a tick that wasn't there.
        started = self.ticks[0] - drive.tick_clocks + 1
        between = drive.tick_clocks // samples
        for n, step in enumerate(self.steps):
            group = self.conversions[n * samples : (n + 1) * samples]
            assert len(group) == samples
            first = started + n * drive.tick_clocks + between // 2 - lead(drive)
            assert [clock for clock, _ in group] == [first + m * between for m in range(samples)]
            for m in range(2):
                total = sum((codes[m] - MIDDLE) << SHIFT for _, codes in group)
                assert step.phases[m] == scale_sum.py_func(total - self.zeros[m], gain)
            assert tuple(step.current) == clarke.currents.py_func(*step.phases)
            phase_ends = [ends_of([codes[m] for _, codes in group]) for m in range(2)]
            ends = phase_ends[0], phase_ends[0] | phase_ends[1]
            assert step.anchored == 0
            eta = ETA_CONTACT if step.contact else ETA_FREE
            touched = wave_core.SHAPE if soft else wave_core.HOLD
            mode = touched if step.contact else wave_core.CLEAR
            for m in range(2):
                found = wave_core.shaped_core_step.py_func(
                    ports[m], lines[m], W, states[m], mode, step.current[m], eta, 0, ROOT, A,
                    U_MAX, extra, 0, ends[m],
                )  # fmt: skip
                assert (step.voltage[m], step.u[m], step.v[m]) == found
                assert step.saturated >> m & 1 == ports[m][wave_core.STATE_SATURATED]
                assert step.clipped >> m & 1 == ports[m][wave_core.STATE_CLIPPED]
            began = group[-1][0] + FRAME.conversion_clocks
            began += CURRENT_CLOCKS + 1 + CLARKE_CLOCKS
            assert step.clock == began + STEP_CLOCKS
            legs_of.append(clarke.centred.py_func(*clarke.phases.py_func(*step.voltage)))
        # What each tick drives, by the latency that the settings count on, and what its dead time
        # takes, by the currents that were there in time.
        currents = [self._out_of_the_legs(step) for step in self.steps]
        dead_times = [new_dead_time() for _ in range(3)]
        # Until the first current the side is +1.
        before = drive.dead_clocks << (formats.EXTRA.fraction - 1) if drive.compensate else 0
        extra = [before] * 3
        taken = [0, 0, 0]
        models = [drive.model() for _ in range(3)]
        widths: list[list[int]] = [[], [], []]
        ends = [self.ticks[0] - drive.tick_clocks, *self.ticks]
        ends = [end for end in ends if end < self.steps[-1].clock - drive.tick_clocks]
        strobes = [group[0] for group in self.conversions[samples - 1 :: samples]]
        made = 0
        for end in ends:
            while made < len(legs_of) and strobes[made] + LATENCY <= end:
                made += 1
            for n in range(3):
                duty = duty_of.py_func(legs_of[made - 1][n], drive.per_volt) if made else 0
                for period in range(drive.tick_halves // 2):
                    update = end + 2 * period * drive.half_clocks
                    if update == ends[0]:
                        # The carrier begins with a width of reset.
                        widths[n].append(0)
                        continue
                    while currents[taken[n]][n][0] + EXTRA_CLOCKS <= update:
                        extra[n] = drive.extra(n, dead_times[n], currents[taken[n]][n][1])
                        taken[n] += 1
                    widths[n].append(models[n].width(duty, extra[n]))
        first = ends[0] + 1
        for n in range(3):
            periods = [level for width in widths[n] for level in drive.period(width)]
            expected = gates_of([0] * GATE_CLOCKS + periods, drive.dead_clocks)
            # Before the carrier starts the dead time after reset is over.
            start = first + GATE_CLOCKS + drive.dead_clocks + 1
            for now in range(start, ends[-1]):
                high, low = self.gates[now]
                wanted = expected[now - first]
                assert (high >> n & 1, low >> n & 1) == wanted, (n, now, wanted)
        return widths


@cocotb.test(timeout_time=60, timeout_unit="ms")
async def equals_the_models(dut: object) -> None:
    """Random currents, an encoder that crosses an edge: every word of every step, every gate."""
    bench = BrushlessBench(dut)
    rng = random_source("brushless")
    widths, touched, judged, limited, clipped = set(), set(), set(), 0, 0
    for drive, samples, extra, zeros in (
        (Drive(HALF), 1, 2, (0, 0)),
        (Drive(HALF, 12.0, 4, 2, second_order=True), 2, 1, (700, -1234)),
        (Drive(HALF - 1, 36.0, 4, 1), 1, 1, (-5, 0)),
        (Drive(HALF, 29.7, 2, 4, 0, False, True, 200_000, 2), 1, 2, (0, 0)),
        (Drive(HALF, 17.3, 2, 3, 0, False, True, 3_000_000, 0), 1, 2, (90, 0)),
    ):
        lows = [rng.randint(-6, 5) for _ in range(WALLS)]
        walls = [(low, low + rng.randint(1, 5)) for low in lows]
        enable = rng.sample((1, 1, 1, 0), WALLS)
        # A wall that isn't there may be whatever it is.
        soft = samples == 1
        shaped = [int(soft == bool(on)) for on in enable]
        await bench.begin(settings(drive, samples, extra, walls, enable, shaped), zeros)
        size = rng.uniform(0.2, 1.0) * MIDDLE
        for clock in range(60 * drive.tick_clocks):
            angle = 0.003 * clock
            if clock % 17 == 0:
                for n in range(2):
                    wave = 0.2 * size * math.cos(angle - 2 * math.pi / 3 * n)
                    noise = rng.choice((0.01, 0.01, 0.01, 1.0)) * rng.uniform(-size, size)
                    bench.codes[n] = min(max(round(MIDDLE + wave + noise), 0), 2 * MIDDLE - 1)
            if clock % 50 == 0 and clock // 500 % 2:
                bench.position = max(-9, min(9, bench.position + rng.choice((-1, 1))))
            await bench.clock()
        assert not bench.word("overrun_o")
        assert len(bench.steps) >= 55
        for step in bench.steps:
            if step.rests > 3 * drive.tick_clocks:
                inside = any(
                    on and low <= step.position < high
                    for on, (low, high) in zip(enable, walls, strict=True)
                )
                assert step.contact == inside
                judged.add(inside)
        found = bench.check(drive, samples, extra, soft)
        widths |= {width for leg in found for width in leg}
        touched |= {step.contact for step in bench.steps}
        limited += sum(step.saturated != 0 for step in bench.steps)
        clipped += sum(step.clipped != 0 for step in bench.steps)
    assert len(widths) > 10
    assert touched == judged == {0, 1}
    assert limited > 5
    assert clipped > 5


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def each_wall_is_where_it_is_said(dut: object) -> None:
    """Four walls apart from each other, at each of their edges, on either side of 0."""
    bench = BrushlessBench(dut)
    drive = Drive(HALF)
    for side in (1, -1):
        edges = [sorted((side * near, side * far)) for near, far in PLACES]
        await bench.begin(settings(drive, walls=edges, enable=(1,) * WALLS))
        for _ in range(SETTLE_CLOCKS):
            await bench.clock()
        inside = 0
        for position in sorted(
            {edge - back for wall in edges for edge in wall for back in range(2)}, key=abs
        ):
            while bench.position != position:
                bench.position += 1 if bench.position < position else -1
                for _ in range(4):
                    await bench.clock()
            for _ in range(3 * drive.tick_clocks):
                await bench.clock()
            touched = any(low <= position < high for low, high in edges)
            assert bench.word("contact_o") == touched, (position, edges)
            inside += touched
        assert inside == 2 * WALLS
        assert bench.signed("position_o") == bench.position


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def shortest_tick(dut: object) -> None:
    """Two clocks more than two ports' steps go on without an overrun, with late samples as well."""
    bench = BrushlessBench(dut)
    for late in (0, 1):
        await bench.begin(settings(Drive(HALF - 1), sample_late=late))
        for _ in range(40 * Drive(HALF - 1).tick_clocks):
            await bench.clock()
        assert not bench.word("overrun_o")
        assert len(bench.steps) > 30
    # One fewer than they take is told.
    await bench.begin(settings(Drive(HALF - 3)))
    for _ in range(1000):
        await bench.clock()
    assert bench.word("overrun_o")


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def off_and_on_again(dut: object) -> None:
    """enable_i = 0 takes all six gates in the next clock; f begins at 0 after it."""
    bench = BrushlessBench(dut)
    await bench.begin(settings(Drive(HALF, dead_clocks=2)))
    bench.codes = [MIDDLE + 300, MIDDLE - 100]
    for clock in range(1500):
        off = 700 <= clock < 1000
        await bench.clock(enable_i=int(not off))
        if off:
            assert bench.gates[-1] == (0, 0)
    after = [step for step in bench.steps if step.clock > 1000]
    assert len(bench.steps) > len(after) > 5
    assert after[0].u == [0, 0]
    assert any(gates[0] for gates in bench.gates[1100:])


@cocotb.test(timeout_time=20, timeout_unit="ms")
async def all_legs_have_the_scale_of_their_step(dut: object) -> None:
    """clocks_per_volt_i changes with any clock in which scale_hold_o lets it.

    The legs' products are made one after another behind the step, and the tick is the shortest.
    """
    bench, rng = BrushlessBench(dut), random_source("scale")
    drive = Drive(HALF - 1)
    await bench.begin(settings(drive))
    scales = [round(drive.per_volt * part) for part in (1.0, 0.7, 0.4)]
    present, changed = scales[0], 0
    seen, after, later = set(), None, 0
    modulators = [dut.three_phase.leg[n].modulator for n in range(3)]
    for clock in range(200 * drive.tick_clocks):
        if clock % 31 == 0:
            bench.codes = [MIDDLE + rng.randint(-1500, 1500) for _ in range(2)]
        may_change, steps = not bench.word("scale_hold_o"), len(bench.steps)
        await bench.clock()
        if clock % 3 == 0 and may_change:
            present = rng.choice(scales)
            changed += 1
            bench.drive(clocks_per_volt_i=present)
        if len(bench.steps) > steps:
            after, later = present, 0
        later += 1
        # Behind the last leg's product, and before the next step's first.
        if after is not None and later == 30:
            legs = clarke.centred.py_func(*clarke.phases.py_func(*bench.steps[-1].voltage))
            duties = [m.pending_q.value.to_signed() + int(m.pending_up_q.value) for m in modulators]
            fits = [
                scale for scale in scales
                if duties == [duty_of.py_func(leg, scale) for leg in legs]
            ]  # fmt: skip
            assert fits, (clock, legs, duties)
            seen |= set(fits) if len(fits) == 1 else set()
            if any(abs(leg) > 1 << 20 for leg in legs):
                assert fits == [after]
    assert seen == set(scales)
    assert changed > 100


if SENSE:
    SENSED = Drive(HALF)

    async def ticks(bench: BrushlessBench, number: int) -> None:
        for _ in range(number * SENSED.tick_clocks):
            await bench.clock()

    async def measured(bench: BrushlessBench) -> int:
        """Ask for a zero, and wait for it; the ticks that it took."""
        await bench.clock(zero_start_i=1)
        bench.drive(zero_start_i=0)
        assert bench.word("zero_busy_o") == 3
        begun = len(bench.ticks)
        while bench.word("zero_busy_o"):
            await bench.clock()
            assert len(bench.ticks) - begun <= ZERO_TICKS + 3
        return len(bench.ticks) - begun

    def shown(bench: BrushlessBench) -> list[int]:
        return unpack(bench.word("phase_current_o"), formats.DATA_W, 2)

    def current_of(code: int, zero: int) -> int:
        gain = formats.GAIN.to_raw(FULL_SCALE_A / (1 << 15))
        return scale_sum.py_func(((code - MIDDLE) << SHIFT) - zero, gain)

    @cocotb.test(timeout_time=60, timeout_unit="ms")
    async def each_phase_has_its_own_zero(dut: object) -> None:
        """What it measures with the gates off comes on top of the zero that it was given."""
        bench = BrushlessBench(dut)
        given = (700, -1234)
        await bench.begin(settings(SENSED, zero_limit=1 << 20), given)
        bench.drive(enable_i=0)
        # At first it is the given one alone.
        bench.codes = [MIDDLE + 31, MIDDLE - 57]
        await ticks(bench, 3)
        assert shown(bench) == [
            current_of(code, zero) for code, zero in zip(bench.codes, given, strict=True)
        ]
        assert ZERO_TICKS <= await measured(bench) <= ZERO_TICKS + 2
        assert bench.word("zero_fault_o") == 0
        found = [zero + ((code - MIDDLE) << SHIFT)
                 for code, zero in zip(bench.codes, given, strict=True)]  # fmt: skip
        bench.codes = [MIDDLE + 400, MIDDLE - 300]
        bench.drive(enable_i=1)
        await ticks(bench, 4)
        wanted = [current_of(code, zero) for code, zero in zip(bench.codes, found, strict=True)]
        assert shown(bench) == wanted
        assert len(set(wanted) | {current_of(code, 0) for code in bench.codes}) == 4
        assert any(high for high, _ in bench.gates[-SENSED.tick_clocks :])

    @cocotb.test(timeout_time=60, timeout_unit="ms")
    async def a_zero_that_is_none(dut: object) -> None:
        """Beyond the limit in one phase, or with the gates on: a fault, and the zero of before."""
        bench = BrushlessBench(dut)
        limit = 40 << SHIFT
        zero_fault = 1 << Fault.ZERO
        await bench.begin(
            settings(SENSED, zero_limit=limit, guard_mask=zero_fault, guard_zero_ticks=0xFFFF,
                     guard_bus_max=0xFFFF)
        )  # fmt: skip
        bench.drive(enable_i=0)
        for codes, faults in (((40, -40), 0), ((41, 0), 1), ((0, -41), 2), ((-50, 50), 3)):
            bench.codes = [MIDDLE + code for code in codes]
            await measured(bench)
            assert bench.word("zero_fault_o") == faults
            await ticks(bench, 2)
            if not faults:
                assert shown(bench) == [0, 0]
                kept = [code << SHIFT for code in codes]
            if faults == 3:
                assert shown(bench) == [
                    current_of(MIDDLE + code, zero) for code, zero in zip(codes, kept, strict=True)
                ]
            elif faults:
                # The phase that is right has got its own.
                kept = [kept[n] if faults >> n & 1 else codes[n] << SHIFT for n in range(2)]
            if GUARD:
                assert bench.word("faults_o") == (zero_fault if faults else 0)
        bench.codes = [MIDDLE, MIDDLE]
        await measured(bench)
        assert bench.word("zero_fault_o") == 0
        await bench.clock(zero_start_i=1)
        await bench.clock(zero_start_i=0)
        await bench.clock(enable_i=1)
        assert bench.word("zero_fault_o") == 3
        assert bench.word("zero_busy_o") == 0

    @cocotb.test(timeout_time=60, timeout_unit="ms")
    async def words_are_checked_in_both_phases(dut: object) -> None:
        """At the end of the scale, and the same for some words, each phase by itself."""
        bench = BrushlessBench(dut)
        alike = 6
        await bench.begin(settings(SENSED, range=2000 << SHIFT, stuck_words=alike))
        for still in range(2):
            moves = 1 - still
            for n in range(3 * alike):
                bench.codes[moves] = MIDDLE + n % 2
                bench.codes[still] = MIDDLE + 5
                await ticks(bench, 1)
            assert bench.word("adc_stuck_o") == 1 << still
            assert bench.word("adc_range_o") == 0
            bench.codes[still] = MIDDLE - 2001
            await ticks(bench, 3)
            assert bench.word("adc_range_o") == 1 << still


if GUARD:
    LIMIT = 12_000
    CURRENT_FAULT, SETTING_FAULT, ENCODER_FAULT = Fault.CURRENT, Fault.SETTING, Fault.ENCODER

    def guarded(damp: int = 0, **others: int) -> dict[str, int]:
        """Settings with a guard for a sample's limit, an encoder's move and settings."""
        mask = 1 << CURRENT_FAULT | 1 << SETTING_FAULT | 1 << ENCODER_FAULT
        words = {
            "guard_mask": mask, "guard_damp": damp, "guard_current": LIMIT, "guard_bus_max": 0xFFFF,
        }  # fmt: skip
        return settings(Drive(HALF), **words, **others)

    @cocotb.test(timeout_time=20, timeout_unit="ms")
    async def each_phase_has_its_limit(dut: object) -> None:
        """The third as well, whose current is what the other two leave: all gates off, latched."""
        bench = BrushlessBench(dut)
        code = LIMIT >> SHIFT
        for a, b, trips in (
            (code, 0, False), (code + 2, 0, True), (-code - 2, code, True), (0, -code - 2, True),
            (code - 2, -code + 2, False), (code // 2, code // 2, False),
            (code // 2 + 2, code // 2 + 2, True), (-code // 2 - 2, -code // 2 - 2, True),
        ):  # fmt: skip
            await bench.begin(guarded())
            for _ in range(300):
                await bench.clock()
            assert bench.word("running_o")
            bench.codes = [MIDDLE + a, MIDDLE + b]
            for _ in range(120):
                await bench.clock()
            bench.codes = [MIDDLE, MIDDLE]
            for _ in range(100):
                await bench.clock()
            assert bench.word("running_o") == int(not trips)
            assert bench.word("faults_o") == int(trips) << CURRENT_FAULT
            assert (bench.gates[-1] == (0, 0)) == trips
            if trips:
                await bench.clock(clear_i=1)
                for _ in range(100):
                    await bench.clock(clear_i=0)
                assert bench.word("running_o")
                assert bench.gates[-1] != (0, 0)

    @cocotb.test(timeout_time=20, timeout_unit="ms")
    async def illegal_words_and_moves(dut: object) -> None:
        """A word that means nothing keeps it off; a fault that damps makes both ports' η 0."""
        bench = BrushlessBench(dut)
        for word, value in (("root", 0), ("a", -5), ("tick_halves", 3), ("clocks_per_volt", 0)):
            await bench.begin(guarded(**{word: value}))
            for _ in range(60):
                await bench.clock()
            assert bench.word("faults_o") == 1 << SETTING_FAULT
            assert bench.gates[-1] == (0, 0)
        # Both ends of what is permitted.
        one = 1 << formats.ETA.fraction
        for end in (one, -one):
            await bench.begin(guarded(eta_contact=end, eta_free=-end))
            for _ in range(60):
                await bench.clock()
            assert bench.word("faults_o") == 0
            assert bench.word("running_o")
        for word in ("eta_contact", "eta_free"):
            for beyond in (one + 1, -one - 1):
                await bench.begin(guarded(**{word: beyond}))
                for _ in range(60):
                    await bench.clock()
                assert bench.word("faults_o") == 1 << SETTING_FAULT
        await bench.begin(guarded(damp=1 << ENCODER_FAULT))
        for _ in range(100):
            await bench.clock()
        bench.codes = [MIDDLE + 200, MIDDLE - 350]
        bench.position += 2
        for _ in range(300):
            await bench.clock()
        assert bench.word("faults_o") == 1 << ENCODER_FAULT
        assert bench.word("running_o")
        bench.steps.clear()
        for _ in range(2000):
            await bench.clock()
        # Nothing is sent back: f dies away, and v is that of the current alone.
        assert all(abs(u) <= 1 for u in bench.steps[-1].u)
        assert all(abs(v) > 1000 for v in bench.steps[-1].v)

    def lost_after(steps: Sequence[Step], port: int, limit: int, enough: int) -> int | None:
        """Steps until this port has turned for too long without a count; None if it hasn't."""
        model, shift = LostEncoder(limit, enough), formats.DATA_W - 16
        for number, step in enumerate(steps, 1):
            if model.tick(step.u[port] >> shift, step.v[port] >> shift):
                return number
        return None

    @cocotb.test(timeout_time=20, timeout_unit="ms")
    async def each_port_tells_that_the_encoder_is_lost(dut: object) -> None:
        """Waves that turn and no counts: told in the tick in which integers have it."""
        bench, rng = BrushlessBench(dut), random_source("lost")
        drive = Drive(HALF)
        behind, ports = set(), set()
        for trial in range(8):
            limit, enough = rng.randint(20, 100), rng.randint(1, 8)
            words = {
                "guard_mask": 1 << Fault.LOST, "guard_lost": limit, "guard_lost_ticks": enough,
                "guard_bus_max": 0xFFFF,
            }  # fmt: skip
            await bench.begin(settings(drive, walls=[(500, 600)] * WALLS, **words))
            current = rng.choice((1, -1)) * rng.randint(200, 900)
            for _ in range(150 * drive.tick_clocks):
                # Either only alpha has a current, or only beta.
                a, b = (current, -current // 2) if trial % 2 else (0, current)
                bench.codes = [MIDDLE + a, MIDDLE + b]
                current += rng.randint(-20, 20) if rng.random() < 0.02 else 0
                await bench.clock()
                if bench.word("faults_o"):
                    break
            assert bench.word("faults_o") == 1 << Fault.LOST
            first = [lost_after(bench.steps, port, limit, enough) for port in range(2)]
            at = min(number for number in first if number)
            ports.add(first.index(at))
            behind.add(len(bench.steps) - at)
        assert behind == {0}
        assert ports == {0, 1}
