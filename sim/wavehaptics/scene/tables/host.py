# SPDX-License-Identifier: Apache-2.0
"""``[host]``: a computer that may have the environment."""

from __future__ import annotations

from wavehaptics.scene.keys import Table, scene_key


class Host(Table):
    """A computer that may have the port's environment, over the line of a virtual board."""

    rate_hz: float = scene_key(
        "Hz", "Packets a second; a packet covers the nearest power of two of control periods", 1e3,
        ge=1, le=1e5,
    )  # fmt: skip
    timeout: int = scene_key(
        "periods", "Time without an answer after which the port has its own environment again", 100,
        ge=1, le=255,
    )  # fmt: skip
