# SPDX-License-Identifier: Apache-2.0
"""The whole RTL at its pins with the Python motor: a bare rotor taps the stiffest wall once."""

from __future__ import annotations

import math

import cocotb
import numpy as np
from cocotb.triggers import FallingEdge, ReadOnly, RisingEdge, Timer, ValueChange, with_timeout
from simulators import TESTS_DIR
from wavehaptics.controller import wave_core
from wavehaptics.controller.pins_timing import GATE_CLOCKS
from wavehaptics.controller.ports import controller_ports
from wavehaptics.laws import closed_forms
from wavehaptics.motor import sensor
from wavehaptics.motor.bridge import GATES, bridge_voltage
from wavehaptics.motor.plant import OMEGA, I, Plant, X, load_words, plant_step
from wavehaptics.scene import Scene, load_scene
from wavehaptics.words import formats, table
from wavehaptics.words.table import Sizes

SCENE = TESTS_DIR / "one_tap.toml"


class Motor:
    """Motor, bridge and encoder, advanced to whole clocks of the controller."""

    def __init__(self, scene: Scene, clock_s: float, bus_v: float, cell_rad: float) -> None:
        self.plant = Plant.of_scene(scene)
        self.state = self.plant.start.copy()
        self.clock_s, self.bus_v, self.cell_rad = clock_s, bus_v, cell_rad
        self.gates, self.now = 0, 0
        self.charge = 0.0
        self._load = load_words(self.plant)
        self._matrices: dict[int, np.ndarray] = {}

    def advance(self, now: int) -> None:
        """Advance to clock ``now`` with the gates as they are."""
        clocks = now - self.now
        if clocks <= 0:
            return
        if clocks not in self._matrices:
            self._matrices[clocks] = self.plant.transition(clocks * self.clock_s)
        e = bridge_voltage(self.gates, self.state[I], self.bus_v)
        if self.gates == 0:
            e = self.plant.k_t * self.state[OMEGA]  # no current flows yet, and none can
        step = plant_step(self.state, self._matrices[clocks], clocks * self.clock_s, e, self._load)
        self.charge += step[0]
        self.now = now

    @property
    def count(self) -> int:
        """Encoder count: the cell that holds the rotor."""
        return math.floor(self.state[X] / self.cell_rad)


class ClosedLoop:
    """Drives the pins of ``bench_closed_loop`` from the motor, and gathers a row a tick."""

    def __init__(self, dut, scene: Scene) -> None:
        self.dut, self.scene = dut, scene
        self.ports = controller_ports(scene)
        timing = self.ports.timing
        self.motor = Motor(
            scene, 1 / timing.clock_hz, scene.drive.bus_v, self.ports.settings.cell_rad
        )
        self.adc = self.ports.sensor.constants()
        self.rng = np.random.default_rng(1)
        self.rows: list[tuple[float, float]] = []  # mean current in A, position in rad
        self.steps = 0

    async def start(self) -> None:
        """Write the settings, and let go of reset."""
        dut = self.dut
        sizes = Sizes()
        values = {**self.ports.words, **self.ports.wall_words(sizes.walls)}
        for name, word in table.inputs(values, sizes).items():
            getattr(dut, name).value = word
        self._drive_encoder()
        for _ in range(8):
            await RisingEdge(dut.clk)
        dut.rst.value = 0
        dut.enable.value = 1

    def _drive_encoder(self) -> None:
        quarter = (self.motor.count - self.ports.start_count) & 3
        self.dut.enc_a.value = int(quarter in (1, 2))
        self.dut.enc_b.value = quarter >> 1

    async def run(self, ticks: int) -> None:
        """Serve the pins until the RTL has made ``ticks`` steps."""
        self._core = wave_core.new_state()
        self._line = wave_core.new_line(self.ports.settings.extra_ticks)
        cocotb.start_soon(self._bridge())
        cocotb.start_soon(self._convert())
        cocotb.start_soon(self._measure())
        while self.steps < ticks:
            await with_timeout(RisingEdge(self.dut.core_valid), 5, "us")
            await ReadOnly()
            self._check_step()

    def _now(self) -> int:
        """Clock of the edge that has just been: the state of the gates holds from there on."""
        return int(self.dut.now.value) - 1

    async def _bridge(self) -> None:
        while True:
            await ValueChange(self.dut.gates)
            await ReadOnly()
            gates = int(self.dut.gates.value)
            assert gates & 3 != 3, "both gates of leg A are on"
            assert gates & 12 != 12, "both gates of leg B are on"
            self.motor.advance(self._now())
            self.motor.gates = gates & GATES

    async def _convert(self) -> None:
        while True:
            await FallingEdge(self.dut.cs_n)
            await ReadOnly()
            self.motor.advance(self._now())
            bits = self.ports.sensor.bits
            noise = self.rng.standard_normal()
            code = sensor.sample_code(self.motor.state[I], self.adc, noise) + (1 << (bits - 1))
            await Timer(1, "ns")
            self.dut.shift.value = code << (32 - self.ports.words["lead_bits"] - bits)

    async def _measure(self) -> None:
        """Close a row where the gates have the tick's end; look at the encoder there."""
        dut = self.dut
        before = self.motor.state[X]
        while True:
            await RisingEdge(dut.tick)
            for _ in range(GATE_CLOCKS + 1):
                await RisingEdge(dut.clk)
            await ReadOnly()
            self.motor.advance(self._now())
            x = self.motor.state[X]
            self.rows.append((self.motor.charge / self.ports.timing.tick_s, (before + x) / 2))
            before, self.motor.charge = x, 0.0
            await Timer(1, "ns")
            self._drive_encoder()

    def _check_step(self) -> None:
        """The step just made, word for word, and its current against the motor's mean."""
        dut, set_ = self.dut, self.ports.settings
        current = dut.current.value.to_signed()
        eta = set_.eta_contact if int(dut.contact.value) else set_.eta_free
        expected = wave_core.wave_core_step(
            self._core, self._line, current, eta, 0, set_.root, set_.a, set_.u_max,
            set_.extra_ticks, self.ports.timing.hold_ticks,
        )  # fmt: skip
        got = tuple(getattr(dut, name).value.to_signed() for name in ("voltage", "u", "v"))
        assert got == tuple(expected[:3]), f"step {self.steps}: {got} is not {expected}"
        mean = self.rows[self.steps][0]
        lsb = 2 * self.ports.sensor.full_scale_a / (1 << self.ports.sensor.bits)
        error = formats.CURRENT.to_value(current) - mean
        assert abs(error) < lsb, f"step {self.steps}: current is off by {error:.2e} A"
        self.steps += 1


@cocotb.test()
async def one_tap_on_the_stiffest_wall(dut):
    """K as predicted, energy given back but not made, every word as the integer model has it."""
    scene = load_scene(SCENE)
    loop = ClosedLoop(dut, scene)
    await loop.start()
    ticks = round(scene.scene.duration_s / loop.ports.timing.tick_s)
    await loop.run(ticks)
    assert loop.steps == ticks
    assert not int(dut.encoder_fault.value)
    assert not int(dut.overrun.value)
    rows = np.array(loop.rows[:ticks])
    torque, x = loop.motor.plant.k_t * rows[:, 0], rows[:, 1]
    deepest = int(x.argmax())
    assert 100 < deepest < ticks - 100, "the rotor must come and go"
    inside = slice(int(np.argmax(x > 0)), int(np.argmax(-torque > 0.9 * -torque.min())))
    stiffness = -np.polyfit(x[inside], torque[inside], 1)[0]
    motor, set_ = scene.motor, loop.ports.settings
    predicted = closed_forms.stiffness(motor.k_t, motor.L_h, set_.r_hat, set_.tau)
    dut._log.info("K measured %.4f, predicted %.4f N·m/rad", stiffness, predicted)
    assert abs(stiffness / predicted - 1) < 0.01
    assert torque.min() < 0 < stiffness, "the wall must push back"
    returned = -loop.motor.state[OMEGA] / loop.motor.plant.start[OMEGA]
    dut._log.info("the rotor came back %.4f times as fast as it hit", returned)
    assert 0.97 < returned < 1.001
