# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_controller.v`` at its pins, open loop.

ADC parts and encoders are wired to the pins and the gates are read in every clock. The words that
the controller shows are compared with the integer models, and so are the pulses at the gates.
"""

from __future__ import annotations

import dataclasses
import math
import random
from collections import deque
from dataclasses import dataclass, field
from itertools import pairwise

import cocotb
import numpy as np
from adc_part import AdcPart
from bench import Bench, pack, random_source, unpack
from random_anchor import random_anchor
from simulators import parameters
from tb_modulator import Model as Modulator
from tb_quadrature import levels
from wavehaptics.controller import anchor, bus_scale, pins_timing, wave_core
from wavehaptics.controller.modulator import duty_of, width_bounds
from wavehaptics.motor.sensor import scale_sum
from wavehaptics.parts.adcs import KINDS, PARTS, Frame, Part, frame
from wavehaptics.words import formats, table
from wavehaptics.words.bridge_modes import HALF_BRIDGE, LOCKED, MODE_WORDS, SIGN_MAGNITUDE, UNIPOLAR
from wavehaptics.words.table import Sizes

N = parameters().get("N", 1)
WALLS = parameters().get("WALLS", 4)
DELAY_LOG2 = parameters().get("DELAY_LOG2", 2)
SENSE = parameters().get("SENSE", 0)
MODES = parameters().get("MODES", 0)
MIN_PULSE = parameters().get("MIN_PULSE", 0)
BUS = parameters().get("BUS", 0)
KIND = KINDS[parameters().get("ADC", 0)]
ANCHOR = parameters().get("ANCHOR", 0)
SHARED = parameters().get("SHARED", 0)
SHAPER = parameters().get("SHAPER", 0)
"""Sections of W; no wall of these tests is shaped, so that they only take their clocks."""

CLOCK_HZ = 96e6 if KIND == "command" else 48e6
PERIOD_NS = 1e9 / CLOCK_HZ
PINS_NS = 2.0
PART = PARTS["MAX11125" if KIND == "command" else "AD7276"]
PART_FRAME = frame(PART, CLOCK_HZ)
MID_CODE = 1 << (PART.bits - 1)
BUS_V = 24.0
BUS_FOR_LIMIT_V = 20.0
"""Bus that u_max takes, BUS = 1."""
BUS_CLOCKS = 119
"""Clocks from another bus to its words, at most, if no step is under way."""
MOTOR_OHM = 2.18
FULL_SCALE_A = 8.0

_ETA_Q = formats.ETA.fraction
_GUARD = formats.STATE_GUARD
_A_SHIFT = formats.A.fraction - _GUARD

_GUARDED = formats.LONG_GUARD
_STEP_CLOCKS = pins_timing.CORE_CLOCKS + pins_timing.SECTION_CLOCKS * SHAPER
ANCHOR_WORDS = ("position_o", "offset_o", "flux_o", "lag_o", "anchor_fault_o")

GATES = ("gate_ah_o", "gate_al_o", "gate_bh_o", "gate_bl_o")

# A tick long enough for the steps of N ports, and for the encoder to settle between two of them.
TICK_CLOCKS = 48 if N == 1 and KIND == "serial" else 96
if ANCHOR and N > 1:
    TICK_CLOCKS = pins_timing.CORE_CLOCKS * N + 12


def no_anchor() -> np.ndarray:
    return np.zeros(anchor.SETTINGS, dtype=np.int64)


@dataclass
class PortSettings:
    """One port's words."""

    root: int = formats.ROOT.to_raw(math.sqrt(2 * MOTOR_OHM))
    a: int = formats.A.to_raw(1.0)
    u_max: int = formats.WAVE.to_raw(20.0 / math.sqrt(2 * MOTOR_OHM))
    eta_contact: int = formats.ETA.to_raw(-1.0)
    eta_free: int = formats.ETA.to_raw(1.0)
    zero: int = 0
    gain_a: float = FULL_SCALE_A
    walls: tuple[tuple[int, int], ...] = ((1000, 2000),) * WALLS
    anchor: np.ndarray = field(default_factory=no_anchor, compare=False)


@dataclass
class Settings:
    """The controller's settings; the defaults are those of PART."""

    half_clocks: int = TICK_CLOCKS
    tick_halves: int = 1
    samples: int = 1
    lead: int = pins_timing.CENTRED_LEAD
    extra_ticks: int = 1
    hold_ticks: int = 0
    mode: str = UNIPOLAR
    min_pulse: int = 0
    dead_clocks: int = 0
    trip: int = 0xFFFF
    range_word: int = 0xFFFF
    stuck_words: int = 0
    zero_limit: int = 0
    bus: int = bus_scale.bus_word(BUS_V)
    bus_share: int = bus_scale.bus_share_word(BUS_FOR_LIMIT_V, 1.0)
    part: Part = PART
    frame: Frame = PART_FRAME
    ports: list[PortSettings] = field(default_factory=lambda: [PortSettings() for _ in range(N)])

    @property
    def tick_clocks(self) -> int:
        return self.half_clocks * self.tick_halves

    @property
    def sample_at(self) -> int:
        """Clock of the tick's last sample strobe, from the tick's first clock."""
        sample_clocks = self.tick_clocks // self.samples
        return (self.samples - 1) * sample_clocks + sample_clocks // 2 - self.lead

    @property
    def latency(self) -> int:
        return pins_timing.latency_clocks(self.frame.conversion_clocks, N, SHAPER, bool(ANCHOR))

    def gain(self, port: int) -> int:
        return formats.GAIN.to_raw(self.ports[port].gain_a / ((1 << 15) * self.samples))

    def clocks_per_volt(self, port: int) -> int:
        if BUS:
            half_bridge = self.mode == HALF_BRIDGE
            return bus_scale.clocks_per_volt(self.half_clocks, self.bus, half_bridge)
        return formats.DUTY.to_raw(self.half_clocks / (2 * BUS_V))

    def u_max(self, port: int) -> int:
        u_max = self.ports[port].u_max
        if BUS:
            return bus_scale.limited(u_max, bus_scale.share(self.bus, self.bus_share))
        return u_max

    def inputs(self) -> dict[str, int]:
        """The controller's inputs, as words."""

        ports, each = self.ports, range(N)
        edges = [wall for port in ports for wall in port.walls]
        values = {
            "half_clocks": self.half_clocks,
            "tick_halves": self.tick_halves,
            "sample_clocks": self.tick_clocks // self.samples,
            "samples": self.samples,
            "sample_lead": self.lead,
            **self.frame.words(),
            "trip": self.trip,
            "range": self.range_word,
            "stuck_words": self.stuck_words,
            "zero_limit": self.zero_limit,
            "zero": [port.zero for port in ports],
            "gain": [self.gain(n) for n in each],
            "wall_min": [wall[0] for wall in edges],
            "wall_max": [wall[1] for wall in edges],
            "wall_enable": 1,
            "eta_contact": [port.eta_contact for port in ports],
            "eta_free": [port.eta_free for port in ports],
            "root": [port.root for port in ports],
            "a": [port.a for port in ports],
            "u_max": [port.u_max for port in ports],
            "anchor_words": [anchor.packed(port.anchor) for port in ports],
            "extra_ticks": self.extra_ticks,
            "hold_ticks": self.hold_ticks,
            "mode": MODE_WORDS[self.mode],
            "min_pulse": self.min_pulse,
            "clocks_per_volt": [self.clocks_per_volt(n) for n in each],
            "bus": self.bus,
            "bus_share": self.bus_share,
            "dead_clocks": self.dead_clocks,
        }
        return table.inputs(values, Sizes(N, WALLS, SHAPER, DELAY_LOG2))


@dataclass
class Step:
    """What the controller showed with core_valid_o: a list of N for each word."""

    clock: int
    current: list[int]
    u: list[int]
    v: list[int]
    voltage: list[int]
    contact: list[int]
    saturated: list[int]
    clipped: list[int]
    position: list[int]
    correction: list[int]
    before: list[tuple[int, int, int, int, int]]
    """Of each port: its position as the step starts, and what its anchor has made of the step
    before, as its own step starts: offset, flux, lag and fault."""
    u_max: list[int]
    clocks_per_volt: list[int]
    """These two as they stand at the step's end."""


@dataclass
class Made:
    """What one port's models make of a step."""

    current: int
    eta: int
    voltage: int
    u: int
    v: int
    saturated: int
    clipped: int
    correction: int
    offset: int
    flux: int
    lag: int
    fault: int
    left: int


class GateWatch:
    """Interlock, dead time and shortest pulse of one leg, in every clock."""

    def __init__(self, dead_clocks: int, min_pulse: int = 0) -> None:
        self.dead_clocks, self.min_pulse = dead_clocks, min_pulse
        self.on = (0, 0)
        self._off_clocks = [1 << 20, 1 << 20]
        self._on_clocks = [0, 0]
        self._pulses = [0, 0]
        self.turned_on = 0

    def clock(self, high: int, low: int, forced_off: bool = False) -> None:
        assert not (high and low)
        for gate, level in enumerate((high, low)):
            if level and not self.on[gate]:
                assert self._off_clocks[1 - gate] >= self.dead_clocks
                self.turned_on += 1
            if self.on[gate] and not level and not forced_off:
                # The first one begins anywhere in a pulse.
                self._pulses[gate] += 1
                if self._pulses[gate] > 1:
                    assert self._on_clocks[gate] >= self.min_pulse - self.dead_clocks
            self._on_clocks[gate] = self._on_clocks[gate] + 1 if level else 0
            self._off_clocks[gate] = 0 if level else self._off_clocks[gate] + 1
        self.on = (high, low)


class ControllerBench(Bench):
    """Parts on the pins, a log of what the pins did, and what must hold in any clock."""

    def __init__(self, dut: object) -> None:
        super().__init__(dut)
        self.settings: Settings
        self.codes = [MID_CODE] * N
        self.position = [0] * N

    async def begin(self, settings: Settings, enable: int = 1) -> None:
        """Reset with ``settings``; logs begin anew."""
        self.settings = settings
        self.parts = [
            AdcPart(settings.part, lambda channel=0, n=n: self.codes[n]) for n in range(N)
        ]
        self._age = 0
        self.position = [0] * N
        self.ticks: list[int] = []
        """Clocks with tick_o, counted from the first after reset."""
        self.conversions: list[tuple[int, list[int]]] = []
        """Clock of each conversion's sample strobe, and the codes held."""
        self.steps: list[Step] = []
        self.bridge: list[list[int]] = []
        """For each clock the voltage of each port's bridge, in parts of the bus."""
        self.recent: deque[tuple[int, ...]] = deque(maxlen=_STEP_CLOCKS * N + 1)
        """The anchors' words of the last clocks, the newest last."""
        self.scaled: deque[tuple[int, int]] = deque(maxlen=6)
        """What the bus has scaled, in the last clocks: a step reads none of it in its last ones."""
        self.watches = [GateWatch(settings.dead_clocks, settings.min_pulse) for _ in range(2 * N)]
        self.disabled = True
        self._cs_n = 1
        await self.start(enable_i=enable, adc_sdata_i=0, enc_a_i=0, enc_b_i=0, **settings.inputs())
        # The ticks begin when the ADC has been set up.
        while not self.word("adc_ready_o"):
            self._age += 1
            await self.step()
            self._adc_pins(self._age * PERIOD_NS + PINS_NS)
            assert self._age < 1000
        self.conversions.clear()
        self.clocks = 0
        self.disabled = not enable

    async def clock(self, enable: int = 1, rst: int = 0) -> Step | None:
        """One clock; the step of the wave core if it shows one."""
        self._age += 1
        edge = self._age * PERIOD_NS
        if rst:
            for part in self.parts:
                part.cut_off()
        sdata = a = b = 0
        for n in range(N):
            sdata |= self.parts[n].sdata(edge - PINS_NS) << n
            level_a, level_b = levels(self.position[n])
            a |= level_a << n
            b |= level_b << n
        await self.step(adc_sdata_i=sdata, enc_a_i=a, enc_b_i=b, enable_i=enable, rst=rst)
        self._adc_pins(edge + PINS_NS)
        self._gate_pins(off=bool(rst or not enable))
        clock = len(self.bridge) - 1
        if ANCHOR:
            self.recent.append(tuple(self.word(name) for name in ANCHOR_WORDS))
        if BUS or self.word("core_valid_o"):
            self.scaled.append((self._scaled("u_max"), self._scaled("clocks_per_volt")))
        if self.word("tick_o"):
            self.ticks.append(clock)
        if not self.word("core_valid_o"):
            return None
        u_max, clocks_per_volt = self.scaled[0]
        shown = Step(
            clock,
            *(
                unpack(self.word(name), formats.DATA_W, N)
                for name in ("current_o", "u_o", "v_o", "voltage_o")
            ),
            [(self.word("contact_o") >> n) & 1 for n in range(N)],
            [(self.word("saturated_o") >> n) & 1 for n in range(N)],
            [(self.word("clipped_o") >> n) & 1 for n in range(N)],
            unpack(self.word("position_o"), formats.COUNT_W, N),
            unpack(self.word("correction_o"), formats.DATA_W, N),
            [self._before(n) for n in range(N)] if ANCHOR else [],
            unpack(u_max, formats.DATA_W, N),
            unpack(clocks_per_volt, formats.COEF_W, N),
        )
        self.steps.append(shown)
        return shown

    def _scaled(self, name: str) -> int:
        """The words as the bus has scaled them; a netlist of mutants has no name for the wires."""
        return self.word(name if hasattr(self.dut, name) else f"{name}_i")

    def _before(self, n: int) -> tuple[int, int, int, int, int]:
        """``Step.before`` of one port."""
        position = unpack(self.recent[0][0], formats.COUNT_W, N)[n]
        words = self.recent[_STEP_CLOCKS * n + pins_timing.WAVES_CLOCKS]
        offset, flux, lag = (unpack(word, formats.DATA_W, N)[n] for word in words[1:4])
        return position, offset, flux, lag, words[4] >> n & 1

    def _adc_pins(self, now: float) -> None:
        cs_n, sclk = self.word("adc_cs_n_o"), self.word("adc_sclk_o")
        din = self.word("adc_din_o")
        for part in self.parts:
            part.pins(now, cs_n, sclk, din)
        if self._cs_n and not cs_n:
            strobe = len(self.bridge) - pins_timing.HOLD_CLOCKS
            self.conversions.append((strobe, [part.held for part in self.parts]))
        self._cs_n = cs_n

    def _gate_pins(self, off: bool) -> None:
        gates = [self.word(name) for name in GATES]
        if off:
            assert gates == [0, 0, 0, 0]
        row = []
        for n in range(N):
            ah, al, bh, bl = ((gate >> n) & 1 for gate in gates)
            self.watches[2 * n].clock(ah, al, off)
            self.watches[2 * n + 1].clock(bh, bl, off)
            if self.settings.mode == HALF_BRIDGE:
                assert (bh, bl) == (0, 0)
                row.append(ah - al)
            else:
                row.append((ah & bl) - (al & bh))
        self.bridge.append(row)

    async def run(self, clocks: int) -> None:
        for _ in range(clocks):
            await self.clock()

    # ---- What the words and pulses must be.

    def sums(self) -> list[tuple[int, list[int]]]:
        """Per tick: clock of the strobe that brings its last word, and the N sums less zero."""
        settings = self.settings
        samples = settings.samples
        shift, middle = formats.SAMPLE_W - settings.part.bits, 1 << (settings.part.bits - 1)
        result = []
        for last in range(samples - 1, len(self.conversions), samples):
            group = self.conversions[last - samples + 1 : last + 1]
            words = []
            for n in range(N):
                total = sum((codes[n] - middle) << shift for _, codes in group)
                words.append(total - self.settings.ports[n].zero)
            late = settings.frame.pipeline * (settings.tick_clocks // samples)
            result.append((group[-1][0] + late, words))
        return result

    def ends(self) -> list[list[int]]:
        """Per tick: at which ends of the range its N sums have words."""
        settings = self.settings
        shift, middle = formats.SAMPLE_W - settings.part.bits, 1 << (settings.part.bits - 1)
        result = []
        for first in range(0, len(self.conversions), settings.samples):
            group = [codes for _, codes in self.conversions[first : first + settings.samples]]
            words = [
                [(code - middle) << shift for code in line] for line in zip(*group, strict=True)
            ]
            high = [max(line) >= settings.range_word for line in words]
            low = [min(line) <= -settings.range_word for line in words]
            result.append(
                [
                    up * formats.AT_HIGH | down * formats.AT_LOW
                    for up, down in zip(high, low, strict=True)
                ]
            )
        return result

    def currents(self) -> list[tuple[int, list[int]]]:
        """The same with the N current words."""
        return [
            (strobe, [scale_sum.py_func(sums[n], self.settings.gain(n)) for n in range(N)])
            for strobe, sums in self.sums()
        ]

    def made(self, n: int, late_fault: bool = False) -> list[Made]:
        """Each step of one port as the integer models have it, from the ADC's codes and contact.

        ``late_fault``: in the shortest ticks a port's step may start before its anchor's fault of
        the step before is known. Then the fault damps a step later.
        """
        settings, port = self.settings, self.settings.ports[n]
        state, line = wave_core.new_state(), wave_core.new_line(settings.extra_ticks)
        held, e, result = anchor.new_state(), 0, []
        fault_before = 0
        for step, (_, words), ends in zip(self.steps, self.currents(), self.ends(), strict=False):
            offset, correction = int(held[anchor.OFFSET]), int(held[anchor.CORRECTION])
            left = int(anchor.left.py_func(step.u_max[n], held))
            seen = [int(held[place]) >> _GUARDED for place in (anchor.CHI, anchor.LAG)]
            known = int(held[anchor.FAULT])
            fault = step.before[n][-1] if late_fault else known
            assert fault in (known, fault_before)
            fault_before = known
            current = wave_core.saturate.py_func(words[n] - offset)
            eta = 0 if fault else port.eta_contact if step.contact[n] else port.eta_free
            withheld, saturated = (
                int(state[wave_core.STATE_WITHHELD]),
                state[wave_core.STATE_SATURATED],
            )
            e_before = e
            e, u, v = wave_core.wave_core_step.py_func(
                state, line, current, eta, 0, port.root, port.a, left,
                settings.extra_ticks, settings.hold_ticks, ends[n],
            )  # fmt: skip
            e, u, v = int(e), int(u), int(v)
            clipped = int(state[wave_core.STATE_CLIPPED])
            if ANCHOR:
                anchor.anchor_step(
                    held, port.anchor, step.before[n][0], bool(step.contact[n]), current, u, v,
                    withheld, e_before, bool(saturated), bool(clipped),
                )  # fmt: skip
            voltage = wave_core.saturate.py_func(e + correction)
            saturated = int(state[wave_core.STATE_SATURATED])
            result.append(
                Made(
                    current, eta, voltage, u, v, saturated, clipped, correction, offset, *seen,
                    fault, left,
                )
            )  # fmt: skip
        return result

    def check_steps(self, one_bus: bool = True, late_fault: bool = False) -> None:
        """Every step's words equal the integer models, fed with the ADC's codes and contact.

        Without ``one_bus`` the bus changes from step to step.
        """
        expected = len(self.currents())
        if one_bus:
            # The bus was another before a current flowed.
            for step in self.steps[-30:]:
                for n in range(N):
                    assert step.u_max[n] == self.settings.u_max(n)
                    assert step.clocks_per_volt[n] == self.settings.clocks_per_volt(n)
        assert len(self.steps) >= expected - 2 - self.settings.frame.pipeline
        for n in range(N):
            for step, made in zip(self.steps, self.made(n, late_fault), strict=False):
                assert step.current[n] == made.current
                shown = (step.voltage[n], step.u[n], step.v[n])
                assert shown == (made.voltage, made.u, made.v)
                assert step.saturated[n] == made.saturated
                assert step.clipped[n] == made.clipped
                assert step.correction[n] == made.correction
                if ANCHOR:
                    assert step.before[n][1:] == (made.offset, made.flux, made.lag, made.fault)

    def check_pulses(self) -> int:
        """Each pulse at the gates is the model's, in its place; number of pulses.

        There is one in each half, or in each period.
        """
        settings = self.settings
        strobes = [strobe for strobe, _ in self.currents()]
        unipolar = settings.mode == UNIPOLAR
        centred = settings.mode in (LOCKED, HALF_BRIDGE)
        pulse_clocks = settings.half_clocks * (1 if unipolar else 2)
        starts = range(0, len(self.bridge) - pulse_clocks - pins_timing.GATE_CLOCKS, pulse_clocks)
        pulses = 0
        for n in range(N):
            # The formula is for the last port; the ports before it are served before it.
            latency = settings.latency - (N - 1 - n)
            made = [
                duty_of.py_func(step.voltage[n], settings.clocks_per_volt(n)) for step in self.steps
            ]
            duties = [(strobe + latency, duty) for strobe, duty in zip(strobes, made, strict=False)]
            least, spare = width_bounds(settings.mode, settings.min_pulse)
            modulator, duty = Modulator(settings.half_clocks, False, least, spare), 0
            for start in starts:
                if start % settings.tick_clocks == 0:
                    due = [duty for ready, duty in duties if ready <= start - 1]
                    duty = due[-1] if due else 0
                width = modulator.width(duty) if start else 0
                first = start + pins_timing.GATE_CLOCKS
                shown = [row[n] for row in self.bridge[first : first + pulse_clocks]]
                assert sum(shown) == (2 if unipolar else 4) * width, (n, start, width)
                if centred and settings.half_clocks % 2:
                    shown.pop()
                assert shown == shown[::-1]
                assert set(shown) <= ({-1, 1} if centred else {0, 1 if width > 0 else -1})
                pulses += width != 0
        return pulses


def random_port(rng: random.Random) -> PortSettings:
    """A port with its own words, and walls in reach of a short walk."""
    ohm = rng.uniform(0.5, 10.0)
    walls = []
    for _ in range(WALLS):
        low = rng.randint(-6, 4)
        walls.append((low, low + rng.randint(0, 6)))
    return PortSettings(
        root=formats.ROOT.to_raw(math.sqrt(2 * ohm)),
        a=formats.A.to_raw(rng.choice((1.0, rng.uniform(0.001, 1.0)))),
        u_max=formats.WAVE.to_raw(rng.uniform(0.3, 1.1) * BUS_V / math.sqrt(2 * ohm)),
        eta_contact=formats.ETA.to_raw(rng.choice((-1.0, -0.9))),
        eta_free=formats.ETA.to_raw(rng.choice((1.0, 0.5))),
        zero=rng.randint(-3000, 3000),
        gain_a=rng.uniform(0.5, 15.0),
        walls=tuple(walls),
        anchor=random_anchor(rng, ohm, (0.5, 5.0, 100.0)) if ANCHOR else no_anchor(),
    )


def random_settings(rng: random.Random) -> Settings:
    half_clocks, tick_halves, samples = rng.choice(
        [
            (TICK_CLOCKS, 1, 1),
            (TICK_CLOCKS // 2, 2, 1),
            (TICK_CLOCKS, 2, 2),
            (TICK_CLOCKS + 3, 3, 3),
        ]
    )
    mode = rng.choice(tuple(MODE_WORDS)) if MODES else UNIPOLAR
    if mode != UNIPOLAR:
        half_clocks, tick_halves, samples = rng.choice(
            [(TICK_CLOCKS // 2, 2, 1), (TICK_CLOCKS // 2 + 1, 2, 1), (TICK_CLOCKS, 4, 2)]
        )
    latency = math.ceil((Settings().latency + TICK_CLOCKS) / TICK_CLOCKS)
    extra = rng.randint(0, (1 << DELAY_LOG2) - 1)
    return Settings(
        half_clocks=half_clocks,
        tick_halves=tick_halves,
        samples=samples,
        lead=rng.randint(-6, 6),
        mode=mode,
        min_pulse=rng.choice((0, 3, 6)) if MIN_PULSE else 0,
        extra_ticks=extra,
        hold_ticks=rng.randint(0, min(extra, max(0, extra - latency + 1))),
        range_word=(0x7FF0, 0x6000)[extra & 1],
        ports=[random_port(rng) for _ in range(N)],
    )


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def open_loop_equals_the_models(dut: object) -> None:
    """Random currents and encoders through walls: currents, waves, voltages, contact, pulses."""
    bench = ControllerBench(dut)
    rng = random_source("open loop")
    pulses = contacts = moves = saturated = clipped = corrected = tracked = strange = 0
    for _ in range(12 if ANCHOR else 6):
        await bench.begin(random_settings(rng))
        contact_states = [np.array([-1, 0]) for _ in range(N)]
        while len(bench.steps) < 40:
            shown = await bench.clock()
            assert len(bench.ticks) < 60
            if len(bench.bridge) % 31 == 0:
                bench.codes = [random_code(rng) for _ in range(N)]
            if shown is None:
                continue
            # The encoders have been still since the last step: the walls have been looked at.
            assert shown.position == bench.position
            for n in range(N):
                walls = np.array(bench.settings.ports[n].walls)
                state, position = contact_states[n], bench.position[n]
                contact, _ = wave_core.contact_step.py_func(
                    state, position, walls[:, 0], walls[:, 1]
                )
                assert shown.contact[n] == contact
                contacts += contact
                saturated += shown.saturated[n]
                clipped += shown.clipped[n]
                corrected += shown.correction[n] != 0
                if ANCHOR:
                    tracked += shown.before[n][1] != 0
                    strange += shown.before[n][4]
                move = rng.choice((-1, 0, 1))
                bench.position[n] += move
                moves += move != 0
        bench.check_steps()
        pulses += bench.check_pulses()
        assert not bench.word("overrun_o")
        assert not bench.word("encoder_fault_o")
    assert pulses > 150
    assert contacts > 30
    assert moves > 100
    assert saturated > 10
    assert clipped > 10
    if ANCHOR:
        assert min(corrected, tracked) > 30 * N
        assert strange > 3 * N


@cocotb.test(timeout_time=50, timeout_unit="ms", skip=not SHARED)
async def a_shared_multiplier_is_in_time_in_the_shortest_tick(dut: object) -> None:
    """Currents, steps and voltages come as they would with two multipliers, anchors soon enough."""
    bench = ControllerBench(dut)
    rng = random_source("shared")
    shortest = max(pins_timing.shared_tick_clocks(N, bool(ANCHOR)), PART_FRAME.cycle_clocks)
    pulses = 0
    for _ in range(8):
        settings = Settings(
            half_clocks=shortest, extra_ticks=1, ports=[random_port(rng) for _ in range(N)]
        )
        await bench.begin(settings)
        for _ in range(20):
            bench.codes = [random_code(rng) for _ in range(N)]
            await bench.run(shortest)
        assert not bench.word("overrun_o")
        bench.check_steps()
        pulses += bench.check_pulses()
    assert pulses > 30 * N


@cocotb.test(timeout_time=50, timeout_unit="ms", skip=not BUS)
async def the_measured_bus_scales_the_pulse_and_the_limit(dut: object) -> None:
    """Each bus gives the same volts with another pulse, and bounds u by what it reaches."""
    bench = ControllerBench(dut)
    rng = random_source("bus")
    saturated = pulses = 0
    for bus_v in (5.0, 15.0, 40.0):
        settings = random_settings(rng)
        for port in settings.ports:
            port.zero = 0
        bench.codes = [MID_CODE] * N
        await bench.begin(settings)
        # Without a current there is nothing to scale until the bus is known.
        settings.bus = bus_scale.bus_word(bus_v)
        bench.drive(bus_i=settings.bus)
        await bench.run(BUS_CLOCKS + settings.tick_clocks)
        for _ in range(80):
            bench.codes = [random_code(rng) for _ in range(N)]
            shown = [await bench.clock() for _ in range(settings.tick_clocks)]
            saturated += sum(sum(step.saturated) for step in shown if step)
        bench.check_steps()
        pulses += bench.check_pulses()
        assert not bench.word("overrun_o")
    assert pulses > 150
    assert saturated > 10


# The pulse is made of the voltage after the step, by the bus that is the newest then.
@cocotb.test(timeout_time=50, timeout_unit="ms", skip=not BUS)
async def a_step_is_made_with_one_bus(dut: object) -> None:
    """A bus that changes at any clock: what the models make of the words at a step's end, it is.

    Both words are of one bus. So a limit never raises u.
    """
    bench = ControllerBench(dut)
    rng = random_source("one bus")
    saturated = changed = 0
    for _ in range(3):
        settings = random_settings(rng)
        settings.mode, settings.min_pulse = UNIPOLAR, 0
        settings.half_clocks, settings.tick_halves, settings.samples = TICK_CLOCKS, 1, 1
        settings.hold_ticks = 0
        for port in settings.ports:
            port.gain_a = 15.0
            port.anchor[:] = 0
        await bench.begin(settings)
        buses = [bus_scale.bus_word(rng.uniform(4.0, 40.0)) for _ in range(6)]
        while len(bench.steps) < 500:
            if rng.random() < 0.03:
                bench.drive(bus_i=rng.choice(buses))
            if len(bench.bridge) % 31 == 0:
                bench.codes = [random_code(rng) for _ in range(N)]
            await bench.clock()
        bench.check_steps(one_bus=False)
        words = [dataclasses.replace(settings, bus=bus) for bus in (settings.bus, *buses)]
        allowed = {
            tuple((of_bus.clocks_per_volt(n), of_bus.u_max(n)) for n in range(N))
            for of_bus in words
        }
        for step in bench.steps:
            assert tuple(zip(step.clocks_per_volt, step.u_max, strict=True)) in allowed
        saturated += sum(sum(step.saturated) for step in bench.steps)
        changed += sum(a.u_max != b.u_max for a, b in pairwise(bench.steps))
    assert saturated > 100
    assert changed > 100


def random_code(rng: random.Random) -> int:
    top = (1 << PART.bits) - 1
    return rng.choice((0, top, MID_CODE, rng.randint(0, top), rng.randint(0, top)))


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def contact_at_any_time(dut: object) -> None:
    """A wall that is met while the core is at work changes the next step, not half of this one."""
    bench = ControllerBench(dut)
    rng = random_source("any time")
    changes = 0
    for run in range(4):
        settings = random_settings(rng)
        if run == 3:
            # A step's currents come as the one before ends; the anchors are still at that one.
            shortest = pins_timing.shortest_tick_clocks(N, SHAPER, bool(ANCHOR), bool(SHARED))
            settings.half_clocks = max(PART_FRAME.cycle_clocks, _STEP_CLOCKS * N + N, shortest)
            settings.tick_halves = settings.samples = 1
            settings.mode, settings.hold_ticks = UNIPOLAR, 0
        await bench.begin(settings)
        next_move = 0
        while len(bench.steps) < 50:
            await bench.clock()
            assert len(bench.ticks) < 70
            next_move -= 1
            if next_move < 0:
                next_move = rng.randint(3, 20)
                bench.position = [at + rng.choice((-1, 1)) for at in bench.position]
                bench.codes = [random_code(rng) for _ in range(N)]
        bench.check_steps(late_fault=bool(ANCHOR) and run == 3)
        for before, after in pairwise(bench.steps):
            changes += before.contact != after.contact
    assert changes > 10


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def latency_is_the_formula(dut: object) -> None:
    """The tick from which a sample's voltage is driven, with the sample moved clock by clock."""
    bench = ControllerBench(dut)
    if KIND == "command":
        cases = [(PART, PART_FRAME)]
    else:
        slow = dataclasses.replace(PART_FRAME, sclk_half_clocks=2)
        names = ["AD7276", "AD7476A"] if N > 1 else ["AD7276", "AD7476A", "ADS7042", "ADS7056"]
        cases = [(PARTS[name], frame(PARTS[name], CLOCK_HZ)) for name in names]
        cases.append((PART, slow))
    for part, made in cases:
        seen = set()
        latency = Settings(part=part, frame=made).latency
        # A tick for which the boundary is near the middle of the leads that are tried.
        tick_clocks = max(TICK_CLOCKS, N * made.cycle_clocks + 1)
        if not boundary_leads(tick_clocks, latency)[1:]:
            tick_clocks += 16
        for lead in boundary_leads(tick_clocks, latency):
            settings = Settings(half_clocks=tick_clocks, part=part, frame=made, lead=lead)
            expected = max(
                0, math.ceil((latency - (tick_clocks - settings.sample_at) + 1) / tick_clocks)
            )
            middle = 1 << (part.bits - 1)
            bench.codes = [middle] * N
            await bench.begin(settings)
            await bench.run(3 * tick_clocks)
            before = len(bench.conversions)
            # From the next conversion on there is current.
            bench.codes = [middle + 400] * N
            await bench.run(5 * tick_clocks)
            strobe = bench.conversions[before][0] + made.pipeline * tick_clocks
            first = next(n for n, row in enumerate(bench.bridge) if all(row))
            driven_tick = (first - pins_timing.GATE_CLOCKS) // tick_clocks
            assert driven_tick - strobe // tick_clocks - 1 == expected, (part.name, lead)
            bench.check_pulses()
            assert {part.pulses for part in bench.parts} == {made.frame_bits}
            seen.add(expected)
        # Both sides of the boundary: the formula is right to the clock.
        assert len(seen) == 2


def boundary_leads(tick_clocks: int, latency: int) -> list[int]:
    """Leads around the one at which the voltage just makes an earlier tick."""
    middle = tick_clocks // 2
    for at in range(tick_clocks):
        if (at + latency + 1) % tick_clocks == 0:
            return [lead for lead in range(middle - at - 2, middle - at + 3)
                    if 0 <= middle - lead < tick_clocks]  # fmt: skip
    raise AssertionError("every latency ends a tick for some sample instant")


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def signs(dut: object) -> None:
    """In contact a positive current is answered by a positive voltage: A high while B is low."""
    bench = ControllerBench(dut)
    for current_sign in (1, -1):
        for in_wall in (False, True):
            port = PortSettings(walls=((-1, 5),) * WALLS if in_wall else ((7, 9),) * WALLS)
            bench.codes = [MID_CODE + 300 * current_sign] * N
            await bench.begin(Settings(ports=[port] * N))
            await bench.run(6 * TICK_CLOCKS)
            sign = current_sign if in_wall else -current_sign
            shown = bench.steps[0]
            for n in range(N):
                assert shown.contact[n] == in_wall
                assert (shown.current[n] > 0) == (current_sign > 0)
                assert (shown.voltage[n] > 0) == (sign > 0)
                first = next(row[n] for row in bench.bridge if row[n])
                assert first == sign
            assert bench.check_pulses() > 0


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def enable(dut: object) -> None:
    """Disabled: gates off at once, waves at rest, currents and positions go on."""
    bench = ControllerBench(dut)
    rng = random_source("enable")
    ports = [PortSettings(walls=((-1, 5),) * WALLS) for _ in range(N)]
    await bench.begin(Settings(ports=ports, dead_clocks=2))
    bench.codes = [MID_CODE + 300] * N
    for _ in range(6):
        # A step late, a wall's answer to a constant current is 0 in two ticks of four.
        await bench.run(4 * TICK_CLOCKS + rng.randint(0, TICK_CLOCKS))
        assert any(any(row) for row in bench.bridge[-3 * TICK_CLOCKS :])
        steps, conversions = len(bench.steps), len(bench.conversions)
        for _ in range(rng.randint(1, 3) * TICK_CLOCKS):
            # GateWatch and the bench see to it that no gate goes on.
            await bench.clock(enable=0)
        assert len(bench.steps) == steps
        assert len(bench.conversions) > conversions
        current = unpack(bench.word("current_o"), formats.DATA_W, N)
        assert current == [scale_sum.py_func(300 << 4, bench.settings.gain(n)) for n in range(N)]
        enabled = len(bench.bridge)
        while len(bench.steps) == steps:
            await bench.clock()
        # Nothing of the voltage before is left.
        assert not any(any(row) for row in bench.bridge[enabled:])
        # The waves start from rest: the first step's u_n is 0.
        assert bench.steps[-1].u == [0] * N
    assert not bench.word("overrun_o")


STATE_WORDS = (
    "core_valid_o", "voltage_o", "correction_o", "offset_o", "flux_o", "lag_o", "anchor_fault_o",
    "u_o", "v_o", "contact_o", "saturated_o", "overrun_o", *GATES,
)  # fmt: skip


@cocotb.test(timeout_time=200, timeout_unit="ms")
async def a_stop_of_one_clock_is_a_stop(dut: object) -> None:
    """enable_i low for 1, 2 or 3 clocks, at any phase: then all is as after a long stop."""
    bench = ControllerBench(dut)
    rng = random_source("short stops")
    ports = [random_port(rng) for _ in range(N)]
    for port in ports:
        # In contact, where an anchor takes no offset off the current that is under way.
        port.walls = ((-1000, 1000),) * WALLS
        port.eta_contact, port.a = formats.ETA.to_raw(-1.0), formats.A.to_raw(0.99)
        port.anchor[anchor.ENABLE] = int(ANCHOR)
        port.anchor[anchor.STRANGE] = formats.VOLTAGE.to_raw(100.0)
    settings = Settings(ports=ports, dead_clocks=2, extra_ticks=1)
    tick = settings.tick_clocks
    before, after = 5 * tick, 4 * tick
    codes = [[random_code(rng) for _ in range(N)] for _ in range(before + after + tick)]
    moves = [[rng.choice((-1, 0, 1)) for _ in range(N)] for _ in codes]

    async def run(end: int, clocks: int) -> list[tuple[int, ...]]:
        """The words after a stop of so many clocks that ends there."""
        bench.codes = [MID_CODE] * N
        await bench.begin(settings)
        bench.drive(
            compensate_i=1, settle_ticks_i=2, second_order_i=1,
            side_current_i=pack([formats.CURRENT.to_raw(0.1)] * N, formats.DATA_W),
        )  # fmt: skip
        rows = []
        for clock in range(end + after):
            if clock % 31 == 0:
                bench.codes = codes[clock]
            if clock % 53 == 52:
                pairs = zip(bench.position, moves[clock], strict=True)
                bench.position = [at + move for at, move in pairs]
            await bench.clock(enable=int(not end - clocks <= clock < end))
            if clock >= end:
                rows.append(tuple(bench.word(name) for name in STATE_WORDS))
        return rows

    wrong = []
    for phase in range(tick):
        long = await run(before + phase, 2 * tick)
        changes = [len(set(words)) for words in zip(*long, strict=True)]
        shown = dict(zip(STATE_WORDS, changes, strict=True))
        assert min(shown[name] for name in ("voltage_o", "u_o", "v_o", "gate_ah_o")) > 1
        if ANCHOR:
            assert min(shown[name] for name in ("flux_o", "lag_o", "correction_o")) > 1
        for clocks in (1, 2, 3) if N == 1 else (1 + phase % 3,):
            short = await run(before + phase, clocks)
            for clock, pair in enumerate(zip(short, long, strict=True)):
                words = zip(STATE_WORDS, *pair, strict=True)
                differ = [name for name, one, other in words if one != other]
                if differ:
                    wrong.append((phase, clocks, clock, differ))
                    break
    assert not wrong, (len(wrong), wrong[:20])


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def reset_in_contact(dut: object) -> None:
    """Everything is off and at rest in the next clock, and the same run follows again."""
    bench = ControllerBench(dut)
    walls = ((3, 30),) * WALLS
    runs = []
    for clocks in (8 * TICK_CLOCKS, 8 * TICK_CLOCKS + 7, 9 * TICK_CLOCKS - 2):
        bench.codes = [MID_CODE + 200] * N
        await bench.begin(Settings(ports=[PortSettings(walls=walls)] * N, dead_clocks=1))
        for position in range(1, 6):
            bench.position = [position] * N
            await bench.run(12)
        await bench.run(clocks)
        assert bench.word("contact_o") == (1 << N) - 1
        runs.append(bench.steps[4])
        await bench.clock(rst=1)
        assert bench.word("adc_cs_n_o") == 1
        assert bench.word("contact_o") == 0
        for name in ("position_o", "current_o", "voltage_o", "u_o", "v_o"):
            assert bench.word(name) == 0
    assert runs[1:] == runs[:1] * 2


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def gates_in_any_state(dut: object) -> None:
    """Random dead times, currents, enables and resets: a leg always has its dead time."""
    bench = ControllerBench(dut)
    rng = random_source("gates")
    turned_on = 0
    cases = [(dead_clocks, UNIPOLAR) for dead_clocks in (0, 1, 5, 30)]
    if MODES:
        cases += [(5, mode) for mode in (LOCKED, SIGN_MAGNITUDE, HALF_BRIDGE)]
    for dead_clocks, mode in cases:
        ports = [PortSettings(walls=((-1, 5),) * WALLS) for _ in range(N)]
        settings = Settings(
            ports=ports, dead_clocks=dead_clocks, mode=mode, half_clocks=TICK_CLOCKS // 2,
            tick_halves=2,
        )  # fmt: skip
        await bench.begin(settings)
        for _ in range(25):
            bench.codes = [random_code(rng) for _ in range(N)]
            await bench.run(rng.randint(1, TICK_CLOCKS))
            if rng.random() < 0.3:
                for _ in range(rng.choice((1, 2, 40))):
                    await bench.clock(enable=0)
            if rng.random() < 0.1:
                await bench.clock(rst=1)
        turned_on += min(watch.turned_on for watch in bench.watches[:: 1 + (mode == HALF_BRIDGE)])
    assert turned_on > 30


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def faults_show(dut: object) -> None:
    """A tick too short for the frame or for the core latches overrun_o; so does an illegal move."""
    bench = ControllerBench(dut)
    bench.codes = [MID_CODE] * N
    short = 22 * N if N > 1 else PART_FRAME.cycle_clocks - 2
    await bench.begin(Settings(half_clocks=short))
    await bench.run(6 * short + 60 * N)
    assert bench.word("overrun_o") == 1
    await bench.begin(Settings())
    await bench.run(4 * TICK_CLOCKS)
    assert (bench.word("overrun_o"), bench.word("encoder_fault_o")) == (0, 0)
    bench.position[N - 1] += 2
    await bench.run(20)
    assert bench.word("encoder_fault_o") == 1 << (N - 1)
    assert bench.word("position_o") == 0
    await bench.begin(Settings())
    assert (bench.word("overrun_o"), bench.word("encoder_fault_o")) == (0, 0)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def each_motor_trips_by_itself(dut: object) -> None:
    """Any of them beyond the trip, beside any others."""
    bench = ControllerBench(dut)
    settings = Settings(trip=1 << 14)
    await bench.begin(settings)
    beyond = (1 << PART.bits) // 3
    for trips in range(1 << N):
        bench.codes = [MID_CODE + beyond * (trips >> n & 1) for n in range(N)]
        await bench.run((3 + settings.frame.pipeline) * TICK_CLOCKS)
        assert bench.word("overcurrent_o") == trips


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def both_zero_vectors_take_turns(dut: object) -> None:
    """Without a voltage each leg's upper gate is on as long as its lower one, half by half."""
    bench = ControllerBench(dut)
    bench.codes = [MID_CODE] * N
    dead_clocks = 2
    await bench.begin(
        Settings(half_clocks=TICK_CLOCKS // 2, tick_halves=2, dead_clocks=dead_clocks)
    )
    await bench.run(3 * TICK_CLOCKS)
    on = [0] * len(GATES) * N
    for _ in range(20 * TICK_CLOCKS):
        await bench.clock()
        for place, name in enumerate(GATES):
            for n in range(N):
                on[place * N + n] += bench.word(name) >> n & 1
    assert on == [20 * (TICK_CLOCKS // 2 - dead_clocks)] * len(on)


@cocotb.test(timeout_time=50, timeout_unit="ms")
async def walls_may_change_between_two_rounds(dut: object) -> None:
    """Whatever else goes on, in one clock of as many as there are walls."""
    bench = ControllerBench(dut)
    await bench.begin(Settings())
    for _ in range(60):
        lets = 0
        for _ in range(WALLS):
            await bench.clock()
            lets += not bench.word("words_hold_o") >> 3 & 1
        assert lets == 1


@cocotb.test(timeout_time=50, timeout_unit="ms", skip=not ANCHOR)
async def words_of_an_anchor_hold_while_it_reads_them(dut: object) -> None:
    """From its port's waves to the last setting of its step, each motor's for itself."""
    bench = ControllerBench(dut)
    await bench.begin(Settings())
    # Three more steps of the last port's anchor, and the clock in which it ends, read none.
    behind = pins_timing.WAVES_CLOCKS + pins_timing.ANCHOR_CLOCKS - 1 - _STEP_CLOCKS - 4
    free = [0] * N
    for _ in range(4):
        before = list(free)
        while not await bench.clock():
            holds = bench.word("anchor_hold_o")
            assert bench.word("words_hold_o") >> 1 & 1 == (holds != 0)
            for n in range(N):
                free[n] += not holds >> n & 1
        for _ in range(behind):
            assert bench.word("anchor_hold_o") >> (N - 1) & 1
            await bench.clock()
        assert all(now - then >= 2 for now, then in zip(free, before, strict=True))


@cocotb.test(timeout_time=50, timeout_unit="ms", skip=not SENSE)
async def sense_flags(dut: object) -> None:
    """Words at the end of the scale, words that never change and a word beyond the trip."""
    bench = ControllerBench(dut)
    rng = random_source("sense")
    top = (1 << PART.bits) - 1
    settings = Settings(trip=1 << 14, stuck_words=6, range_word=(1 << 15) - (1 << (16 - PART.bits)))
    bench.codes = [MID_CODE] * N
    await bench.begin(settings)

    async def show(code: int, ticks: int) -> list[tuple[int, int, int]]:
        seen = []
        bench.codes[N - 1] = code
        for _ in range(ticks):
            await bench.run(TICK_CLOCKS)
            for n in range(N - 1):
                bench.codes[n] = MID_CODE + rng.randint(1, 5) * (-1) ** rng.randint(0, 1)
            names = ("adc_range_o", "adc_stuck_o", "overcurrent_o")
            seen.append(tuple(bench.word(name) >> (N - 1) & 1 for name in names))
            assert all(bench.word(name) & ((1 << (N - 1)) - 1) == 0 for name in names[:1])
        return seen

    await show(MID_CODE + 1, 2 + settings.frame.pipeline)
    for code, flags in (
        (top, (1, 0, 1)),
        (0, (1, 0, 1)),
        (MID_CODE + top // 3, (0, 0, 1)),
        (MID_CODE - 3, (0, 0, 0)),
    ):
        seen = await show(code, 3 + settings.frame.pipeline)
        assert seen[-1] == flags, code
    # A trip is met to the code, with every bit of it 0 and 1.
    step = 1 << (16 - PART.bits)
    for trip in (0x5555 // step, 0x2AAA // step):
        bench.drive(trip_i=trip * step)
        for code in (trip, trip - 1, -trip, 1 - trip):
            seen = await show(MID_CODE + code, 3 + settings.frame.pipeline)
            assert seen[-1] == (0, 0, abs(code) >= trip), code
    bench.drive(trip_i=settings.trip)
    await show(MID_CODE - 2, 3 + settings.frame.pipeline)
    assert (await show(MID_CODE - 3, 8))[-1] == (0, 1, 0)
    assert (await show(MID_CODE - 2, 3 + settings.frame.pipeline))[-1] == (0, 0, 0)


@cocotb.test(timeout_time=50, timeout_unit="ms", skip=not SENSE)
async def measured_zero(dut: object) -> None:
    """With the bridge off the sensor's offset is found, and is no current any more."""
    bench = ControllerBench(dut)
    offset = 37
    samples = 1 if KIND == "command" else 2
    settings = Settings(
        half_clocks=samples * TICK_CLOCKS, samples=samples, zero_limit=(40 << 4) * samples
    )
    ticks = 1 << parameters().get("ZERO_LOG2", 10)

    async def measure() -> None:
        bench.drive(zero_start_i=1)
        await bench.clock(enable=0)
        bench.drive(zero_start_i=0)
        waited = 0
        while bench.word("zero_busy_o"):
            await bench.clock(enable=0)
            waited += 1
            assert waited < (ticks + 3) * settings.tick_clocks

    bench.codes = [MID_CODE + offset] * N
    await bench.begin(settings, enable=0)
    for _ in range(4 * settings.tick_clocks):
        await bench.clock(enable=0)
    assert all(word > 0 for word in unpack(bench.word("current_o"), formats.DATA_W, N))
    await measure()
    assert bench.word("zero_fault_o") == 0
    for _ in range(4 * settings.tick_clocks):
        await bench.clock(enable=0)
    assert unpack(bench.word("current_o"), formats.DATA_W, N) == [0] * N
    # A sensor that is too far off is told, and its zero isn't taken.
    bench.codes = [MID_CODE + offset + 10] * N
    await measure()
    assert bench.word("zero_fault_o") == (1 << N) - 1
    for _ in range(4 * settings.tick_clocks):
        await bench.clock(enable=0)
    words = unpack(bench.word("current_o"), formats.DATA_W, N)
    shift = formats.SAMPLE_W - PART.bits
    expected = [scale_sum.py_func((10 << shift) * samples, settings.gain(n)) for n in range(N)]
    assert words == expected
    # The word is taken off besides, and their sum never wraps.
    most = (1 << (formats.SUM_W - 1)) - 1
    measured = (offset << shift) * samples
    for zero in (-5, most):
        bench.drive(zero_i=pack([zero] * N, formats.SUM_W))
        for _ in range(4 * settings.tick_clocks):
            await bench.clock(enable=0)
        words = unpack(bench.word("current_o"), formats.DATA_W, N)
        seen = measured + (10 << shift) * samples - min(most, measured + zero)
        assert words == [scale_sum.py_func(seen, settings.gain(n)) for n in range(N)]
    # A bridge that goes on in the middle: no zero.
    bench.codes = [MID_CODE + offset] * N
    await measure()
    assert bench.word("zero_fault_o") == 0
    bench.drive(zero_start_i=1)
    await bench.clock(enable=0)
    bench.drive(zero_start_i=0)
    await bench.run(3)
    assert bench.word("zero_fault_o") == (1 << N) - 1
    assert bench.word("zero_busy_o") == 0
