# SPDX-License-Identifier: Apache-2.0
"""``[cogging]``: torque of the iron on the rotor."""

from __future__ import annotations

from wavehaptics.scene.keys import Table, scene_key


class Cogging(Table):
    """Torque of the iron on the rotor; without this table there is none."""

    torque_nm: float = scene_key("N·m", "Amplitude: −torque_nm·sin(per_rev·x)", ge=0, le=100)
    per_rev: int = scene_key("–", "Periods a revolution", ge=1, le=1000)
