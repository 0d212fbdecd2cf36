# SPDX-License-Identifier: Apache-2.0
"""Meanings of the bits of registers that give reasons."""

from __future__ import annotations

import re

from wavehaptics.runtime.repository import RTL_DIR

_LINE = r"^`define WH_FAULT_(\w+)[ \t]+(\d+)[ \t]*(?://[ \t]*(.*))?$"

FAULTS = {
    int(bit): (name, meaning)
    for name, bit, meaning in re.findall(
        _LINE, (RTL_DIR / "wh_faults.vh").read_text(encoding="utf-8"), re.MULTILINE
    )
}
"""(name, meaning or "") by the bit of the word ``faults``, of ``rtl/wh_faults.vh``."""

ARM_REFUSALS = (
    "the board's switch is off (enable_i)",
    "there is a fault",
    "settings were being committed",
    "no permitted zero of the currents was found",
    "it wasn't renewed in time",
)
"""By the bit of the word ``arm_refused``, of ``rtl/wh_arm.v``."""

REFUSED_BY_FAULT = 1 << ARM_REFUSALS.index("there is a fault")
"""Bit of the word ``arm_refused``; :data:`FAULTS` say which."""

FLAGS = (
    "contact", "saturated", "running", "overcurrent", "adc_range", "encoder_fault", "anchor_fault",
    "host_active",
)  # fmt: skip
"""By the bit of the word ``flags``, of ``rtl/wh_device.v``."""


def bits_of(raw: int) -> list[int]:
    """The bits that a word has, the lowest first."""
    return [bit for bit in range(raw.bit_length()) if raw >> bit & 1]


def arm_refusal(raw: int) -> str:
    """The reasons of a word ``arm_refused`` in words, "" for none."""
    return ", ".join(ARM_REFUSALS[bit] for bit in bits_of(raw))
