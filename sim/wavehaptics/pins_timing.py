# SPDX-License-Identifier: Apache-2.0
"""Latencies of ``rtl/wh_controller.v``, in clocks; a cocotb test measures each at the RTL."""

from __future__ import annotations

CORE_CLOCKS = 24
"""Clocks that one port's step takes in ``wh_wave_core``."""

GATE_CLOCKS = 2
"""Clocks from the carrier's phase to the gates, dead time aside: ``wh_pwm``, ``wh_half_bridge``."""

HOLD_CLOCKS = 1
"""Clocks from the carrier's sample strobe to the fall of CS, where the ADC holds its input."""

CENTRED_LEAD = HOLD_CLOCKS - GATE_CLOCKS
"""``sample_lead_i`` with which the ADC holds its input in the exact middle of the gates' pulse."""

_CURRENT_CLOCKS = 6
_DUTY_CLOCKS = 8


def latency_clocks(sclk_half_clocks: int, frame_bits: int, ports: int = 1) -> int:
    """Clocks from a sample strobe to the soonest tick strobe after which its voltage is driven.

    The conversion's last data bit is taken as the frame's last (``lead_bits + data_bits``): that is
    bit k read at fall k of SCLK, 1 + (2k − 1) half periods after the strobe. Then come the mean
    current, the wave core's step for each port, and the duty; currents and duties of several ports
    pass one multiplier in turn. The strobe meant is the carrier's for the tick's last sample.
    """
    frame = 1 + (2 * frame_bits - 1) * sclk_half_clocks
    in_turn = ports - 1
    return (
        frame
        + _CURRENT_CLOCKS + in_turn
        + CORE_CLOCKS * ports
        + _DUTY_CLOCKS + in_turn
    )  # fmt: skip
