# SPDX-License-Identifier: Apache-2.0
"""``[guard]``: what takes the bridge off."""

from __future__ import annotations

from wavehaptics.scene.keys import CURRENT_MAX_A, Table, scene_key


class Guard(Table):
    """What takes the bridge of `pins` off, as a board has it; without this table nothing does."""

    trip_a: float = scene_key(
        "A",
        "A sample of this magnitude switches the bridge off",
        ge=1e-3,
        le=CURRENT_MAX_A,
    )
    watch: bool = scene_key(
        "–",
        "Whether `wh_guard` watches as well, with the limits of a board",
        True,
        default_text="true",
        range_text="true, false",
    )
