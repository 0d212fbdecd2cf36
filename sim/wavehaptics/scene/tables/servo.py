# SPDX-License-Identifier: Apache-2.0
"""``[servo]``: the encoder's servo."""

from __future__ import annotations

from wavehaptics.scene.keys import Table, scene_key


class Servo(Table):
    """The encoder's servo on the controller `encoder`; the wave controllers don't look at it."""

    rate_hz: float = scene_key(
        "Hz", "Rate of the servo; `tick_hz` is a whole multiple of it", 1e3, ge=10, le=4e6
    )
    stiffness: float | None = scene_key(
        "N·m/rad",
        "Virtual spring K of the walls",
        None,
        default_text="that of the analog wave wall",
        ge=1e-6,
        le=1e6,
    )
    damping: float = scene_key("N·m·s/rad", "Virtual damper B inside a wall", 0.0, ge=0, le=1000)
    amplifier_hz: float = scene_key(
        "Hz", "Bandwidth of the PI current amplifier, at most a tenth of `tick_hz`", 2e3,
        ge=1, le=4e5,
    )  # fmt: skip
    delay_s: float = scene_key(
        "s", "Time from sample to command, rounded to whole ticks", 0.0, ge=0, le=1
    )
