# SPDX-License-Identifier: Apache-2.0
"""Bench of ``examples/use_in_a_design``: from reset to running gates, with a scene's registers."""

from __future__ import annotations

import json
import os

import cocotb
from adc_part import AD7276, AdcPart
from bench import Bench
from wavehaptics.fpga.scene_registers import SceneRegisters, scene_registers
from wavehaptics.scene import load_scene
from wavehaptics.words.table import LEGS, THREE_PHASE_LEGS, Sizes

SCENE, OVERRIDES, MOTORS = json.loads(os.environ["WH_SCENE"])
MADE: SceneRegisters = scene_registers(load_scene(SCENE, OVERRIDES), MOTORS)
P = MADE.parameters
SIZES = Sizes(
    MOTORS, P["WALLS"], P["SHAPER"], P["DELAY_LOG2"], THREE_PHASE_LEGS if P["AXES"] else LEGS
)
PERIOD_NS = 1e9 / MADE.clock_hz
MIDDLE = 1 << AD7276.bits - 1
GATES = ("gate_ah_o", "gate_al_o", "gate_bh_o", "gate_bl_o")
START_CLOCKS = 40_000
"""Until all is written and applied, at most."""
ZERO_TICKS = 1 << 10


def register_place(address: int) -> int:
    """Where ``rtl/wh_registers.v`` keeps a setting."""
    return 0xA0 + address if address < 0x100 else address - 0x100


class Template(Bench):
    """The template with its ADC, which reads 0 A, with a code more in every second frame."""

    def __init__(self, dut: object) -> None:
        super().__init__(dut)
        self.adc = AdcPart(AD7276, self._convert)
        self._frames = 0

    def _convert(self) -> int:
        self._frames += 1
        return MIDDLE + self._frames % 2

    async def begin(self) -> None:
        await self.start(enable_i=0, press_i=0, clear_i=0, adc_sdata_i=0, enc_a_i=0, enc_b_i=0)

    async def starts_up(self) -> int:
        """Clocks until the registers are written; no gate is on meanwhile."""
        for clocks in range(START_CLOCKS):
            assert not self.word("failed_o")
            assert not any(self.word(gate) for gate in GATES)
            if self.word("started_o"):
                return clocks
            await self.step_with_adc()
        raise AssertionError(f"not started in {START_CLOCKS} clocks")

    async def step_with_adc(self) -> None:
        edge = (self.clocks + 1) * PERIOD_NS
        level = self.adc.sdata(edge)
        self.drive(adc_sdata_i=(1 << len(self.handle("adc_sdata_i"))) - 1 if level else 0)
        await self.step()
        if self.word("started_o"):
            self.adc.pins(edge, self.word("adc_cs_n_o"), self.word("adc_sclk_o"))
        else:
            self.adc.cut_off()  # the frame is not yet this part's


@cocotb.test()
async def the_devices_settings_are_the_scenes(dut: object) -> None:
    bench = Template(dut)
    await bench.begin()
    await bench.starts_up()
    memory = dut.device.registers.in_force_ram.memory
    for one in MADE.registers:
        assert int(memory[register_place(one.address)].value) == one.raw, one.name
    assert len({one.name for one in MADE.registers}) > 40


@cocotb.test()
async def a_press_lets_the_gates_on(dut: object) -> None:
    bench = Template(dut)
    await bench.begin()
    await bench.starts_up()
    assert not bench.word("running_o")
    bench.drive(enable_i=1)
    for pins in ({}, {"clear_i": 1}, {"clear_i": 0}):  # what was read before is no fault of now
        bench.drive(**pins)
        for _ in range(400):
            await bench.step_with_adc()
    bench.drive(press_i=1)
    await bench.step_with_adc()
    bench.drive(press_i=0)
    tick_clocks = 2 * next(one.raw for one in MADE.registers if one.name == "half_clocks")
    for _ in range(2 * ZERO_TICKS * tick_clocks):
        await bench.step_with_adc()
        if bench.word("running_o"):
            break
    assert bench.word("running_o")
    assert not bench.word("fault_o")
    switched = 0
    for _ in range(20 * tick_clocks):
        before = [bench.word(gate) for gate in GATES]
        await bench.step_with_adc()
        switched += before != [bench.word(gate) for gate in GATES]
        assert not bench.word("gate_ah_o") & bench.word("gate_al_o")
    assert switched > 40
    assert bench.adc.complete > ZERO_TICKS
    bench.drive(enable_i=0)
    await bench.step(2)
    assert not any(bench.word(gate) for gate in GATES)
