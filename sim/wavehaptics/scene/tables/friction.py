# SPDX-License-Identifier: Apache-2.0
"""``[friction]`` of the rotor."""

from __future__ import annotations

from wavehaptics.scene.keys import Table, scene_key


class Friction(Table):
    """Friction of the rotor; without this table there is none."""

    coulomb_nm: float = scene_key("N·m", "Coulomb friction", 0.0, ge=0, le=100)
    viscous: float = scene_key("N·m·s/rad", "Viscous friction", 0.0, ge=0, le=100)
