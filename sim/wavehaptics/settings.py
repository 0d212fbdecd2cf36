# SPDX-License-Identifier: Apache-2.0
"""From a scene's SI values to the words that the controller's ports take."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wavehaptics import anchor, formats, physics
from wavehaptics.anchor_choice import FREE_OF_R, SURFACE_OF_R, choose_anchor
from wavehaptics.reflection import WishError
from wavehaptics.scene import Scene, SceneError
from wavehaptics.shaper import Shaper, design
from wavehaptics.supply import reached_v

IDEAL_CELL_RAD = 2.0**-30
"""Cell of the position where a scene has no encoder, rad: fine enough to count as ideal."""

IDEAL_ANCHOR_CELL_RAD = 2.0**-20
"""That cell where an anchor uses the position: its word for half a cell's current must be above the
last place by far."""

USUAL_LIMIT_V = 12.0
"""Voltage limit that the anchor is chosen for where a scene has none or a larger one, V."""

RELEASE_OF_BOUNCE = 1.5
"""How long after an edge the rotor counts as moving, over the time π·√(J L_eff)/k_T in which the
wall turns the bare rotor round."""

MOST_TICKS = (1 << formats.ANCHOR_TICK_W) - 1
"""Longest time that the anchor counts, ticks."""

LOST_S = 0.1
"""How long R̂ may stay at its limit until the encoder counts as lost, s; an eighth of it for an
error of the current larger than LOST_PART of the reference current."""
LOST_PART = 0.5

WARMING_PER_S = 0.05
"""How fast R may rise or fall with the winding's temperature, in parts of itself a second."""

LOST_LIMIT = 0.005
"""Default of ``controller.lost_limit``."""

TRACK_LIMIT = 0.5
"""Default of ``controller.track_limit``."""


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
    anchor: np.ndarray
    """Words of the anchor, int64 (anchor.SETTINGS,); its ENABLE is 0 without one."""

    @property
    def anchored(self) -> bool:
        """Whether the anchor has anything to do."""
        return bool(self.anchor[anchor.ENABLE])

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
        ideal = IDEAL_ANCHOR_CELL_RAD if control.anchored else IDEAL_CELL_RAD
        cell_rad = 2 * math.pi / scene.encoder.counts_per_rev if scene.encoder else ideal
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
        anchor=_anchor_words(scene, tick_s, cell_rad, r_hat, a_word, u_max, limit_v),
    )


def _wave_limit(limit_v: float, r_hat: float) -> int:
    """Word of u_max for a voltage limit in V."""
    return min(formats.WAVE.raw_max, math.floor(limit_v / physics.root(r_hat) / formats.WAVE.step))


def _ticks(time_s: float, tick_s: float) -> int:
    """A time in ticks, as the anchor can count it."""
    return max(1, min(MOST_TICKS, round(time_s / tick_s)))


def _anchor_words(
    scene: Scene,
    tick_s: float,
    cell_rad: float,
    r_hat: float,
    a_word: int,
    u_max: int,
    limit_v: float,
) -> np.ndarray:
    """Settings of :mod:`wavehaptics.anchor`; all zero but the limit for the plain wave wall."""
    words = np.zeros(anchor.SETTINGS, dtype=np.int64)
    control, motor = scene.controller, scene.motor
    s = physics.root(r_hat)
    words[anchor.ROOT_START] = words[anchor.ROOT_MIN] = words[anchor.ROOT_MAX] = (
        formats.ROOT.to_raw(s)
    )
    words[anchor.ROOT_FREE] = words[anchor.ROOT_START]
    words[anchor.LIMIT_BASE] = words[anchor.LIMIT_FREE] = u_max
    if not control.anchored:
        return words
    tau = physics.tau(tick_s, formats.A.to_value(a_word), control.extra_ticks)
    l_eff = physics.l_eff(motor.L_h, r_hat, tau)
    per_rad = motor.k_t / l_eff
    reference_v = min(limit_v, USUAL_LIMIT_V)
    chosen = choose_anchor(r_hat, l_eff, tick_s, control.extra_ticks, reference_v)

    def value(key: str, otherwise: float) -> float:
        given = getattr(control, key)
        if given is not None:
            return given
        return getattr(chosen, key) if control.anchor_auto else otherwise

    release = value("release_ohm", 0.0)
    surface = value("surface_ohm", SURFACE_OF_R * r_hat if release else 0.0) if release else 0.0
    track_gain = value("track_gain", 0.0)
    span = TRACK_LIMIT if control.track_limit is None else control.track_limit
    span = span if track_gain else 0.0

    def word(format_: formats.Fixed, number: float, key: str) -> int:
        try:
            return format_.to_raw(number)
        except OverflowError as problem:
            raise SceneError(
                f"{scene.scene.name}: controller.{key} can't be had at this motor, encoder and "
                f"tick: its word would be {problem}"
            ) from None

    words[anchor.ENABLE] = 1
    words[anchor.HALF_CELL] = word(formats.CELL_CURRENT, per_rad * cell_rad / 2, "anchor_ohm")
    words[anchor.DEAD_ZONE] = word(
        formats.CURRENT, per_rad * cell_rad * control.dead_zone_cells, "dead_zone_cells"
    )
    words[anchor.ANCHOR_GAIN] = word(formats.PULL, 2 * value("anchor_ohm", 0.0) / s, "anchor_ohm")
    words[anchor.RELEASE_GAIN] = word(formats.PULL, 2 * release / s, "release_ohm")
    words[anchor.SURFACE_GAIN] = word(formats.PULL, 2 * surface / s, "surface_ohm")
    words[anchor.TRACK_GAIN] = word(formats.TRACK, track_gain * tick_s / s, "track_gain")
    words[anchor.ROOT_MIN] = word(formats.ROOT, physics.root(r_hat * (1 - span)), "track_limit")
    words[anchor.ROOT_MAX] = word(formats.ROOT, physics.root(r_hat * (1 + span)), "track_limit")
    r_hat_free = FREE_OF_R * r_hat if control.r_hat_free is None else control.r_hat_free
    words[anchor.ROOT_FREE] = word(formats.ROOT, physics.root(r_hat_free), "r_hat_free")
    words[anchor.LIMIT_FREE] = _wave_limit(limit_v, r_hat_free)
    bounce_s = math.pi * math.sqrt(motor.J_kgm2 * l_eff) / motor.k_t
    words[anchor.RELEASE_TICKS] = _ticks(RELEASE_OF_BOUNCE * bounce_s, tick_s)
    words[anchor.PUSH_ONLY] = control.push_only is not False
    words[anchor.LOST_CURRENT] = word(
        formats.CURRENT, LOST_PART * reference_v / (4 * r_hat), "anchor_ohm"
    )
    words[anchor.LOST_TICKS] = _ticks(LOST_S, tick_s)
    if span:
        # dR/R = 2 ds/s
        lost = LOST_LIMIT if control.lost_limit is None else control.lost_limit
        words[anchor.LOST_ROOT] = word(formats.ROOT, s * lost / 2, "lost_limit")
        warming = min(s * WARMING_PER_S / 2 * tick_s, formats.WARM.largest)
        words[anchor.WARM_ROOT] = word(formats.WARM, warming, "tick_hz")
        # u_max follows s along the tangent of limit/s, as far as the slope's word goes.
        slope = min(u_max * formats.WAVE.step / s, formats.WAVE.largest)
        words[anchor.LIMIT_SLOPE] = math.floor(slope / formats.WAVE.step)
        words[anchor.LIMIT_BASE] = min(
            formats.WAVE.raw_max, math.floor(2 * slope * s / formats.WAVE.step)
        )
    return words
