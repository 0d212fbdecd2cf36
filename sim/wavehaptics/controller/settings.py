# SPDX-License-Identifier: Apache-2.0
"""From a scene's SI values to the words that the controller's ports take."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from wavehaptics.controller import anchor, wave_core
from wavehaptics.controller.normalised import response
from wavehaptics.controller.shaper import Shaper, design
from wavehaptics.laws import closed_forms
from wavehaptics.laws.anchor_choice import (
    SLOW_RAD_S,
    STRANGE_CELLS,
    STRANGE_PART,
    choose_anchor,
    choose_zero_rate,
)
from wavehaptics.laws.reflection import WishError
from wavehaptics.motor.supply import reached_v
from wavehaptics.scene import Scene
from wavehaptics.scene.tables.controller import Controller
from wavehaptics.words import formats

IDEAL_CELL_RAD = 2.0**-30
"""Cell of the position where a scene has no encoder, rad: fine enough to count as ideal."""

IDEAL_ANCHOR_CELL_RAD = 2.0**-14
"""That cell with a port anchor, which counts in cells: 103,000 of them a turn."""

HOLDS = 1e-3
"""How near to −1 the environment has to be at rest to count as one that holds a position."""

_SLOW_TURN = 1e-9
_MOST_REST = (1 << formats.REST_W) - 1
_MOST_FOLLOW = (1 << formats.FOLLOW_W) - 1


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
    """Words of the port anchor, int64 (anchor.SETTINGS,); its ENABLE is 0 without one."""

    @property
    def anchored(self) -> bool:
        """Whether there is a port anchor."""
        return bool(self.anchor[anchor.ENABLE])

    def for_a_host(self) -> Settings:
        """The same for a port whose environment a host may have, which need not hold a position.

        What the voltage limit withholds is then no flux.
        """
        words = self.anchor.copy()
        words[anchor.OWED_GAIN] = 0
        return replace(self, anchor=words)

    def words(self) -> dict[str, int | list[int]]:
        """The port's words of ``rtl/words.toml``, but for its walls: the RTL counts its own way."""
        words: dict[str, int | list[int]] = {
            "root": self.root,
            "a": self.a,
            "u_max": self.u_max,
            "eta_contact": self.eta_contact,
            "eta_free": self.eta_free,
            "edge_hysteresis": int(self.edge_hysteresis),
            "extra_ticks": self.extra_ticks,
            "anchor_words": anchor.packed(self.anchor),
        }
        if len(self.shaper.words):
            words["shape_coefficient"] = self.shaper.words[:, : wave_core.LOSS1].ravel().tolist()
            words["shape_loss"] = self.shaper.words[:, wave_core.LOSS1 :].ravel().tolist()
        return words

    @property
    def s(self) -> float:
        """s = √(2R̂), √Ω."""
        return formats.ROOT.to_value(self.root)

    @property
    def tau(self) -> float:
        """τ = T/a + k·T of the quantised a, s."""
        return closed_forms.tau(self.tick_s, formats.A.to_value(self.a), self.extra_ticks)


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
    r_hat = control.r_hat * control.r_hat_part if control.anchored else control.r_hat
    a = closed_forms.matched_a(tick_s, control.lambda_, control.extra_ticks)
    root_word = formats.ROOT.to_raw(closed_forms.root(r_hat))
    a_word = formats.A.to_raw(a)
    if a_word == 0:
        raise scene.refusal(
            f"controller.lambda = {control.lambda_:g} rad/s at a tick of "
            f"{tick_s:g} s gives a below the last place {formats.A.step:.1e}; "
            "take a larger lambda or a slower tick",
            "controller.lambda",
            "controller.tick_hz",
        )
    if limit_v is None:
        limit_v = reached_v(scene)
    limit_v = min(limit_v, formats.VOLTAGE.largest)
    # The anchor's own limits are parts of what the drive makes, whatever limits the current.
    drive_v = limit_v
    if scene.drive is not None:
        if scene.drive.limit_v is not None:
            drive_v = min(limit_v, scene.drive.limit_v)
        limit_v = min(limit_v, scene.drive.limit(control.r_hat))
    u_max = _wave_limit(limit_v, r_hat)
    wall_min, wall_max = walls_in_cells(scene, cell_rad)
    for n in np.flatnonzero(wall_min == wall_max).tolist():
        low, high = control.walls[n]
        raise scene.refusal(
            f"controller.walls: [{low:g}, {high:g}] lies between two counts of {cell_rad:.3g} rad "
            "and would never be felt; make it wider, or raise encoder.counts_per_rev",
            "controller.walls",
        )
    tau_s = closed_forms.tau(tick_s, formats.A.to_value(a_word), control.extra_ticks)
    try:
        # For the port as its words have it, τ and R̂ alike.
        shaper = design(scene, tick_s, tau_s, formats.ROOT.to_value(root_word) ** 2 / 2.0)
    except WishError as error:
        raise scene.refusal(f"{error}", "shaper") from None
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
        anchor=_anchor_words(scene, tick_s, cell_rad, r_hat, a_word, drive_v, shaper),
    )


def _wave_limit(limit_v: float, r_hat: float) -> int:
    """Word of u_max for a voltage limit in V."""
    return min(
        formats.WAVE.raw_max, math.floor(limit_v / closed_forms.root(r_hat) / formats.WAVE.step)
    )


def holds_position(control: Controller, shaper: Shaper) -> bool:
    """Whether contact pushes back for good: η·W is −1 at rest, in every wall."""
    at_rest = control.eta_contact
    for words in shaper.words:
        at_rest *= response(words, np.full(1, _SLOW_TURN))[0].real
    return abs(at_rest + 1.0) < HOLDS and abs(control.eta_contact + 1.0) < HOLDS


def _anchor_words(
    scene: Scene, tick_s: float, cell_rad: float, r_hat: float, a_word: int, limit_v: float,
    shaper: Shaper,
) -> np.ndarray:  # fmt: skip
    """Settings of :mod:`wavehaptics.controller.anchor`; all zero without one.

    ``r_hat`` is the port's.
    """
    words = np.zeros(anchor.SETTINGS, dtype=np.int64)
    control = scene.controller
    if not control.anchored:
        return words
    # A brushless motor's axis has pψ, of which both together feel as √1.5 times as much.
    cell_vs = control.k_t_hat * cell_rad / (math.sqrt(1.5) if scene.motor.brushless else 1.0)
    chosen = choose_anchor(
        control.r_hat, r_hat, control.l_hat, tick_s, control.extra_ticks, limit_v,
        brushed=not scene.motor.brushless,
    )  # fmt: skip

    def given(key: str, otherwise: float) -> float:
        value = getattr(control, key)
        return otherwise if value is None else value

    ohm = given("anchor_ohm", chosen.ohm)
    learn = given("anchor_ohm_per_s", chosen.ohm_per_s * ohm / chosen.ohm)
    reach_v = given("anchor_limit_v", chosen.limit_v)
    cells_per_a = control.l_hat / cell_vs
    most_a = formats.CURRENT.largest if scene.adc is None else scene.adc.full_scale_a
    most_a = min(most_a, 4.0 * limit_v / control.r_hat)
    slow = round(cell_rad / SLOW_RAD_S / tick_s)
    mean = anchor.AXIS_INNER_SHIFT if scene.motor.brushless else anchor.INNER_SHIFT
    follow = round(chosen.follow_s / (tick_s * (1 << mean)))

    def word(format_: formats.Fixed, value: float, key: str) -> int:
        try:
            return format_.to_raw(value)
        except OverflowError as problem:
            raise scene.refusal(
                f"controller.{key} can't be had at this motor, encoder and "
                f"tick: its word would be {problem}; take a finer encoder or a faster tick",
                f"controller.{key}",
            ) from None

    if cells_per_a * most_a > formats.LONG.largest:
        raise scene.refusal(
            f"controller.anchor_auto can't be had: {most_a:g} A are "
            f"{cells_per_a * most_a:.3g} cells of the encoder, more than {formats.LONG.largest:g}; "
            "take a coarser encoder or a smaller adc.full_scale_a",
            "controller.anchor_auto",
            "encoder.counts_per_rev",
            "adc.full_scale_a",
        )
    flux = closed_forms.root(r_hat) * tick_s / (2.0 * cell_vs)
    owed = flux / formats.A.to_value(a_word) if holds_position(control, shaper) else 0.0
    zero_rate = choose_zero_rate(r_hat, cell_vs, most_a)
    words[anchor.ENABLE] = 1
    words[anchor.FLUX_GAIN] = word(formats.FLUX, flux, "anchor_auto")
    words[anchor.OWED_GAIN] = min(round(owed / formats.FLUX.step), formats.FLUX.raw_max)
    words[anchor.CELLS_GAIN] = word(formats.CELLS, cells_per_a, "anchor_auto")
    words[anchor.PULL_GAIN] = word(formats.PULL, ohm / cells_per_a, "anchor_ohm")
    per_count = learn * tick_s / cells_per_a / (chosen.learn_a * cells_per_a)
    words[anchor.LEARN_GAIN] = word(formats.LEARN, per_count, "anchor_ohm_per_s")
    words[anchor.LEARN_MAX] = word(formats.PULL, chosen.most_ohm / cells_per_a, "anchor_auto")
    words[anchor.BRUSH] = min(
        round(chosen.brush_a * cells_per_a / anchor.SEEN_CELLS), 1 << (formats.DATA_W - 2)
    )
    words[anchor.ZERO_GAIN] = word(formats.FLUX, zero_rate * tick_s / r_hat, "anchor_auto")
    words[anchor.REACH] = formats.VOLTAGE.to_raw(reach_v)
    words[anchor.ROOM_GAIN] = word(formats.FLUX, 1.0 / closed_forms.root(r_hat), "anchor_auto")
    strange_v = reach_v + max(STRANGE_CELLS * ohm / cells_per_a, STRANGE_PART * limit_v)
    words[anchor.STRANGE] = min(round(strange_v / formats.VOLTAGE.step), formats.VOLTAGE.raw_max)
    words[anchor.FOLLOW_TICKS] = min(max(follow, 1), _MOST_FOLLOW)
    words[anchor.SLOW_TICKS] = min(max(slow, 1), _MOST_REST)
    return words
