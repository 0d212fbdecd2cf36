# SPDX-License-Identifier: Apache-2.0
"""``[coupling]``: two motors of a device on one virtual shaft."""

from __future__ import annotations

from wavehaptics.scene.keys import Table, scene_key


class Coupling(Table):
    """A virtual shaft between two equal motors, on a line that may delay the waves."""

    delay_s: float = scene_key(
        "s", "Time that the waves take from one motor to the other", 0.0, ge=0, le=0.1
    )
