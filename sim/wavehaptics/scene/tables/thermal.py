# SPDX-License-Identifier: Apache-2.0
"""``[thermal]``: warming of winding and magnets."""

from __future__ import annotations

from wavehaptics.scene.keys import Table, scene_key

REFERENCE_C = 25.0
"""Temperature at which the constants of ``[motor]`` hold, °C."""


class Thermal(Table):
    """Warming of winding and magnets; without this table R and k_T are constant.

    Defaults are the RE 25's.
    """

    rth_winding: float = scene_key(
        "K/W", "Thermal resistance, winding to housing", 3.1, ge=1e-3, le=1e4
    )
    rth_housing: float = scene_key(
        "K/W", "Thermal resistance, housing to ambient", 14.0, ge=1e-3, le=1e4
    )
    tau_winding_s: float = scene_key("s", "Time constant of the winding", 12.0, ge=0.5, le=1e6)
    tau_housing_s: float = scene_key("s", "Time constant of the housing", 612.0, ge=0.5, le=1e7)
    alpha_per_k: float = scene_key(
        "1/K", "Temperature coefficient of the winding, copper's", 0.0039, ge=0, le=0.01
    )
    magnet_per_k: float = scene_key(
        "1/K",
        "Temperature coefficient of the magnets and so of k_T; -0.002 for ferrite, -0.0011 for "
        "NdFeB",
        0.0, ge=-0.01, le=0,
    )  # fmt: skip
    ambient_c: float = scene_key("°C", "Temperature around the motor", 25.0, ge=-50, le=150)
    start_c: float | None = scene_key(
        "°C", "Temperature of winding and housing at the start; `R_ohm` and `k_t` hold at 25", None,
        default_text="`ambient_c`", ge=-50, le=200,
    )  # fmt: skip
