# SPDX-License-Identifier: Apache-2.0
"""``[servo]``: the encoder's servo."""

from __future__ import annotations

import math

from wavehaptics.scene.keys import Table, scene_key

ANALOG_HZ = 2e3
"""Bandwidth of the amplifier of a motor with brushes where a scene has none, Hz."""


class Servo(Table):
    """The encoder's servo on the controller `encoder`; the wave controllers don't look at it."""

    rate_hz: float = scene_key(
        "Hz", "Rate of the servo; `tick_hz` is a whole multiple of it", 1e3, ge=10, le=4e6
    )
    stiffness: float | None = scene_key(
        "N·m/rad", "Virtual spring K of the walls", None,
        default_text="that of the analog wave wall", ge=1e-6, le=1e6,
    )  # fmt: skip
    damping: float = scene_key("N·m·s/rad", "Virtual damper B inside a wall", 0.0, ge=0, le=1000)
    amplifier_hz: float | None = scene_key(
        "Hz", "Bandwidth of the PI current control, at most a tenth of `tick_hz`, or of `foc_hz`",
        None, default_text="2000; of a `pmsm` `foc_hz`/6π", ge=1, le=4e5,
    )  # fmt: skip
    foc_hz: float = scene_key(
        "Hz",
        "Rate of the current control of a `pmsm`, which alone takes this key; `tick_hz` is a whole "
        "multiple of it",
        20e3, ge=10, le=4e6,
    )  # fmt: skip
    delay_s: float = scene_key(
        "s", "Time from sample to command, rounded to whole ticks", 0.0, ge=0, le=1
    )

    @property
    def analog_hz(self) -> float:
        """Bandwidth of the amplifier of a motor with brushes, Hz."""
        return ANALOG_HZ if self.amplifier_hz is None else self.amplifier_hz

    @property
    def field_oriented_hz(self) -> float:
        """Bandwidth of the sampled current control of a motor without, Hz.

        By default the magnitude optimum for what is late: a voltage comes one period after its
        sample and holds for another, 1.5 periods on the mean, and 1/ω is twice that.
        """
        return self.foc_hz / (6 * math.pi) if self.amplifier_hz is None else self.amplifier_hz
