# SPDX-License-Identifier: Apache-2.0
"""What others publish of field-oriented control in hardware: rates, latency, logic.

``FPGA-FOC``
    github.com/WangXuan95/FPGA-FOC at commit 3816c6c. Its README has the rate, a period of 2048
    clocks of 36.864 MHz; ``RTL/foc/svpwm.v`` takes a vector over at the end of a period. It gives
    no count of LUTs or multipliers.
``TMC4671``
    Data sheet of IC version V1.3, revision V2.00: a carrier of 25 to 100 kHz, and in 4.7.4 current
    controllers that step once a carrier's period. It is a chip, and has no LUTs to tell of; a
    latency was not found.
``Vitis Motor Control Library``
    github.com/Xilinx/Vitis_Libraries, ``motor_control/docs/src/benchmark.rst`` at commit 1388bc8:
    the blocks FOC, SVPWM_DUTY, PWM_GEN and QEI, each with its LUTs, multipliers and the rate that
    it can take at 100 MHz, for a Zynq 7010 as ``benchmark/FOC_sensor.rst`` has it. The slowest
    block's rate and the blocks' sums stand here; a latency was not found.
"""

from __future__ import annotations

from typing import NamedTuple


class FocDesign(NamedTuple):
    """A design as its makers describe it; ``None`` is what they don't tell."""

    name: str
    rate_hz: float
    latency: str | None
    """From a sample to the bridge."""
    lut: int | None
    dsp: int | None
    where: str


_VITIS_LUT = {"FOC": 5179, "SVPWM_DUTY": 2101, "PWM_GEN": 1094, "QEI": 867}
_VITIS_DSP = {"FOC": 67, "SVPWM_DUTY": 7, "PWM_GEN": 6, "QEI": 5}

DESIGNS = (
    FocDesign("FPGA-FOC", 36.864e6 / 2048, "the next period", None, None, "any FPGA"),
    FocDesign("TMC4671", 100e3, None, None, None, "a chip"),
    FocDesign(
        "Vitis Motor Control Library", 1e6, None, sum(_VITIS_LUT.values()),
        sum(_VITIS_DSP.values()), "Zynq 7010, LUTs of six inputs",
    ),
)  # fmt: skip
"""In the order of their rates."""
