# SPDX-License-Identifier: Apache-2.0
"""The bridge's switching patterns, by name."""

from __future__ import annotations

from wavehaptics.words import formats

UNIPOLAR = "unipolar"
LOCKED = "locked-anti-phase"
SIGN_MAGNITUDE = "sign-magnitude"
HALF_BRIDGE = "half-bridge"

MODE_WORDS = {
    UNIPOLAR: formats.HEADER_VALUES["MODE_UNIPOLAR"],
    LOCKED: formats.HEADER_VALUES["MODE_LOCKED"],
    SIGN_MAGNITUDE: formats.HEADER_VALUES["MODE_SIGN_MAGNITUDE"],
    HALF_BRIDGE: formats.HEADER_VALUES["MODE_HALF_BRIDGE"],
}
"""Switching patterns by their names in a scene, and their words (``rtl/wh_pwm.v``)."""
