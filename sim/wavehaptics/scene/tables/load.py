# SPDX-License-Identifier: Apache-2.0
"""``[load]``: what is fixed to the shaft."""

from __future__ import annotations

from wavehaptics.scene.keys import Table, scene_key


class Load(Table):
    """What is fixed to the shaft, a lever or a knob; without this table the rotor is bare."""

    inertia_kgm2: float = scene_key(
        "kg·m²", "Inertia, added to `J_kgm2`; a controller sees it only through `j_hat`", ge=0,
        le=1,
    )  # fmt: skip
