# SPDX-License-Identifier: Apache-2.0
"""The scene of all its tables, and the rules between them."""

from __future__ import annotations

import math
from typing import Any, get_args

from pydantic import model_validator
from pydantic.functional_validators import ModelWrapValidatorHandler

from wavehaptics.laws.anchor_choice import choose_eta_free
from wavehaptics.laws.closed_forms import matched_a
from wavehaptics.scene.keys import Table, as_number, broken_rule
from wavehaptics.scene.placed import Placed
from wavehaptics.scene.tables.adc import Adc
from wavehaptics.scene.tables.brushes import Brushes
from wavehaptics.scene.tables.cogging import Cogging
from wavehaptics.scene.tables.controller import Controller
from wavehaptics.scene.tables.drive import Drive
from wavehaptics.scene.tables.encoder import Encoder
from wavehaptics.scene.tables.friction import Friction
from wavehaptics.scene.tables.general import SceneTable
from wavehaptics.scene.tables.guard import Guard
from wavehaptics.scene.tables.hand import Hand
from wavehaptics.scene.tables.host import Host
from wavehaptics.scene.tables.load import Load
from wavehaptics.scene.tables.motor import Motor
from wavehaptics.scene.tables.servo import Servo
from wavehaptics.scene.tables.shaper import Shaper
from wavehaptics.scene.tables.thermal import Thermal
from wavehaptics.scene.tables.transmission import Transmission
from wavehaptics.scene.tables.winding import Winding


class Scene(Placed):
    """A whole scene; a table that the file does not have is ``None`` and is not simulated.

    ``controller.r_hat``, ``l_hat``, ``k_t_hat``, ``j_hat``, ``eta_free`` and ``adc.full_scale_a``
    are never ``None``: defaults are filled in.
    ``drive.bus_v`` is ``None`` only if ``drive.limit_v`` is, which then means no limit.
    """

    scene: SceneTable
    motor: Motor
    load: Load | None = None
    friction: Friction | None = None
    brushes: Brushes | None = None
    winding: Winding | None = None
    cogging: Cogging | None = None
    hand: Hand | None = None
    encoder: Encoder | None = None
    adc: Adc | None = None
    drive: Drive | None = None
    guard: Guard | None = None
    thermal: Thermal | None = None
    transmission: Transmission | None = None
    servo: Servo | None = None
    host: Host | None = None
    controller: Controller
    shaper: Shaper | None = None

    @property
    def called(self) -> str:
        return self.scene.name

    @model_validator(mode="wrap")
    @classmethod
    def _resolve(cls, data: Any, handler: ModelWrapValidatorHandler[Scene]) -> Scene:
        scene = handler(data)
        if scene.motor.brushless and scene.drive is not None:
            given = data.get("drive", {}) if isinstance(data, dict) else {}
            scene = scene.model_copy(update={"drive": scene.drive.of_three_phases(given)})
        tick_s = 1 / scene.controller.tick_hz
        if scene.scene.duration_s < tick_s:
            broken_rule(
                f"scene.duration_s = {as_number(scene.scene.duration_s)} is shorter than a tick; "
                f"it must be at least {as_number(tick_s)} s",
                ("scene", "duration_s"),
                ("controller", "tick_hz"),
            )
        if scene.controller.edge_hysteresis and scene.encoder is None:
            broken_rule(
                "controller.edge_hysteresis is of an encoder's cells; give [encoder] or leave it "
                "out",
                ("controller", "edge_hysteresis"),
                ("encoder",),
            )
        if scene.shaper is not None and scene.shaper.walls:
            walls = len(scene.controller.walls)
            for n, wall in enumerate(scene.shaper.walls):
                if wall >= walls:
                    broken_rule(
                        f"shaper.walls[{n}] = {wall} is no wall: controller.walls has {walls}; "
                        "walls count from 0",
                        ("shaper", "walls", n),
                        ("controller", "walls"),
                    )
        cable = scene.transmission is not None and scene.transmission.cable_stiffness is not None
        if cable and (scene.hand is None or scene.hand.path == "impact"):
            broken_rule(
                "transmission.cable_stiffness has no hand at its other end; "
                "give [hand] with a path that has a spring",
                ("transmission", "cable_stiffness"),
                ("hand",),
            )
        motor, controller = scene.motor, scene.controller
        asks_angle = controller.anchored or scene.servo is not None
        if controller.magnet_hat_rad and not (motor.brushless and asks_angle):
            broken_rule(
                "controller.magnet_hat_rad belongs to a brushless motor's port anchor or servo; "
                "leave it out",
                ("controller", "magnet_hat_rad"),
            )
        if controller.find_magnet and not (motor.brushless and controller.anchored):
            broken_rule(
                "controller.find_magnet belongs to a brushless motor's port anchor; leave it out",
                ("controller", "find_magnet"),
            )
        servo = scene.servo
        if servo is not None and "foc_hz" in servo.model_fields_set and not motor.brushless:
            broken_rule(
                "servo.foc_hz belongs to a brushless motor; leave it out", ("servo", "foc_hz")
            )
        known = {
            "r_hat": motor.R_ohm, "l_hat": motor.L_h, "k_t_hat": motor.felt_k_t,
            "j_hat": motor.J_kgm2, "magnet_hat_rad": motor.magnet_rad,
        }  # fmt: skip
        missing = {key: value for key, value in known.items() if getattr(controller, key) is None}
        controller = controller.model_copy(update=missing)
        if scene.adc is not None:
            adc = scene.adc.resolved(controller.r_hat, scene.drive, scene.scene.duration_s)
            scene = scene.model_copy(update={"adc": adc})
        if controller.eta_free is None:
            controller = controller.model_copy(update={"eta_free": _eta_free(controller, scene)})
        return scene.model_copy(update={"controller": controller})


def _eta_free(controller: Controller, scene: Scene) -> float:
    """η in free space where the scene has none."""
    if not controller.anchored:
        return 1.0
    lag_s = 0.0
    if scene.adc is not None and scene.adc.bandwidth_hz is not None:
        lag_s = 1.0 / (2.0 * math.pi * scene.adc.bandwidth_hz)
    tick_s = 1.0 / controller.tick_hz
    return choose_eta_free(
        controller.r_hat, controller.l_hat, lag_s,
        matched_a(tick_s, controller.lambda_, controller.extra_ticks), controller.extra_ticks,
        tick_s, controller.anchor_ohm,
    )  # fmt: skip


def without_anchor(scene: Scene) -> Scene:
    """The scene of a controller that has no port anchor, and for which there is no choice for one.

    η in free space is 1 again where it was chosen for the anchor.
    """
    control = scene.controller
    if not control.anchored:
        return scene
    changes: dict[str, Any] = {"anchor_auto": False, "anchor_ohm": None}
    if control.eta_free == _eta_free(control, scene):
        changes["eta_free"] = 1.0
    return scene.model_copy(update={"controller": control.model_copy(update=changes)})


def _table_of(annotation: Any) -> type[Table]:
    """The table in a field's annotation, which may be None besides."""
    parts = get_args(annotation) or (annotation,)
    table: type[Table] = next(part for part in parts if part is not type(None))
    return table


TABLES: dict[str, type[Table]] = {
    name: _table_of(field.annotation) for name, field in Scene.model_fields.items()
}
"""Model of each table, in the order of the format's description."""


def drive_gain(scene: Scene) -> float:
    """Voltage at the motor over the voltage asked for, within the limit; 1 without a drive."""
    return scene.drive.gain if scene.drive else 1.0


def encoder_end(scene: Scene) -> float:
    """Time from which a scene's encoder stands still, s; infinite where it goes on."""
    stops = scene.encoder.stops_at_s if scene.encoder else None
    return math.inf if stops is None else stops
