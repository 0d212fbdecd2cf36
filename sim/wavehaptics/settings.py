# SPDX-License-Identifier: Apache-2.0
"""From a scene's SI values to the words that the controller's ports take."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wavehaptics import formats, physics
from wavehaptics.reflection import WishError
from wavehaptics.scene import Scene, SceneError
from wavehaptics.shaper import Shaper, design
from wavehaptics.supply import reached_v

IDEAL_CELL_RAD = 2.0**-30
"""Cell of the position where a scene has no encoder, rad: fine enough to count as ideal."""


@dataclass(frozen=True)
class Settings:
    """Words of one port's parameters, and the SI values that they stand for."""

    tick_s: float
    extra_ticks: int
    root: int
    a: int
    u_max: int
    eta_contact: int
    eta_free: int
    cell_rad: float
    wall_min: np.ndarray
    wall_max: np.ndarray
    r_hat: float
    limit_v: float
    shaper: Shaper
    edge_hysteresis: bool
    shaped: np.ndarray
    """Which walls feel as the shaper has it, bool (walls,); the others are rigid."""

    @property
    def s(self) -> float:
        """s = √(2R̂), √Ω."""
        return formats.ROOT.to_value(self.root)

    @property
    def tau(self) -> float:
        """τ = T/a + k·T of the quantised a, s (design §1.1, fact 2)."""
        return physics.tau(self.tick_s, formats.A.to_value(self.a), self.extra_ticks)


def walls_in_cells(scene: Scene, cell_rad: float) -> tuple[np.ndarray, np.ndarray]:
    """Edges of the walls as the position's cells have them: int64 (walls,), (walls,)."""
    edges = np.asarray(scene.controller.walls, dtype=float).reshape(-1, 2) / cell_rad
    limit = float(1 << 60)
    whole = np.round(np.clip(edges, -limit, limit)).astype(np.int64)
    return np.ascontiguousarray(whole[:, 0]), np.ascontiguousarray(whole[:, 1])


def settings(
    scene: Scene,
    tick_s: float | None = None,
    cell_rad: float | None = None,
    limit_v: float | None = None,
) -> Settings:
    """Controller settings of a scene.

    ``tick_s`` and ``cell_rad`` take the place of the scene's tick and of its encoder's cell where a
    controller has its own; ``limit_v`` bounds the voltage besides the scene's own limit; by default
    that is what a measured bus reaches.
    :class:`SceneError` where the words can't hold a value.
    """
    control = scene.controller
    tick_s = 1.0 / control.tick_hz if tick_s is None else tick_s
    if cell_rad is None:
        cell_rad = 2 * math.pi / scene.encoder.counts_per_rev if scene.encoder else IDEAL_CELL_RAD
    r_hat = scene.motor.R_ohm if control.r_hat is None else control.r_hat
    a = physics.matched_a(tick_s, control.lambda_, control.extra_ticks)
    root_word = formats.ROOT.to_raw(physics.root(r_hat))
    a_word = formats.A.to_raw(a)
    if a_word == 0:
        raise SceneError(
            f"{scene.scene.name}: controller.lambda = {control.lambda_:g} rad/s at a tick of "
            f"{tick_s:g} s gives a below the last place {formats.A.step:.1e}; "
            "take a larger lambda or a slower tick"
        )
    if limit_v is None:
        limit_v = reached_v(scene)
    limit_v = min(limit_v, formats.VOLTAGE.largest)
    if scene.drive is not None and scene.drive.limit_v is not None:
        limit_v = min(limit_v, scene.drive.limit_v)
    u_max = _wave_limit(limit_v, r_hat)
    wall_min, wall_max = walls_in_cells(scene, cell_rad)
    tau_s = physics.tau(tick_s, formats.A.to_value(a_word), control.extra_ticks)
    try:
        shaper = design(scene, tick_s, tau_s, r_hat)
    except WishError as error:
        raise SceneError(f"{scene.scene.name}: {error}") from None
    shaped = np.ones(len(wall_min), dtype=np.bool_)
    if scene.shaper is not None and scene.shaper.walls is not None:
        shaped[:] = False
        shaped[list(scene.shaper.walls)] = True
    return Settings(
        tick_s=tick_s,
        extra_ticks=control.extra_ticks,
        root=root_word,
        a=a_word,
        u_max=u_max,
        eta_contact=formats.ETA.to_raw(control.eta_contact),
        eta_free=formats.ETA.to_raw(control.eta_free),
        cell_rad=cell_rad,
        wall_min=wall_min,
        wall_max=wall_max,
        r_hat=r_hat,
        limit_v=limit_v,
        shaper=shaper,
        edge_hysteresis=control.edge_hysteresis,
        shaped=shaped,
    )


def _wave_limit(limit_v: float, r_hat: float) -> int:
    """Word of u_max for a voltage limit in V."""
    return min(formats.WAVE.raw_max, math.floor(limit_v / physics.root(r_hat) / formats.WAVE.step))
