# SPDX-License-Identifier: Apache-2.0
"""What each thing that runs a scene does of it, idealises away, or refuses.

A scene runs on every rung of the ladder, so a lower one may leave out what only a higher one has:
the analog circuit has no ADC. That is said (:func:`left_out`), never silent. What would be another
wall without it is refused in one line (:func:`refuse`). ``sim/tests/test_abilities.py`` tries every
key of the format on every controller, and holds this table to what it finds.
"""

from __future__ import annotations

from typing import NamedTuple

from wavehaptics.scene import Scene


class Ability(NamedTuple):
    """Tables and keys (``table`` or ``table.key``) that something doesn't do."""

    left_out: frozenset[str] = frozenset()
    """Without effect: idealised there, or the business of another controller."""
    refused: dict[str, str] = {}  # noqa: RUF012 - never changed
    """With the cure, as the end of a sentence."""


_PINS = frozenset(
    f"drive.{key}"
    for key in ("mode", "pwm_hz", "dead_time_s", "compensate", "min_pulse_s", "bus_ripple_v",
                "bus_ripple_hz", "supply_sinks", "bus_farad")
) | {"controller.clock_hz", "adc.part", "guard"}  # fmt: skip
"""Of clocks and gates."""

_ANCHOR = frozenset(
    f"controller.{key}" for key in ("anchor_ohm", "anchor_ohm_per_s", "anchor_limit_v")
)

_INERTIA = frozenset({"controller.j_hat"})
"""No law needs it."""

_MAGNET = frozenset({"controller.magnet_hat_rad", "controller.find_magnet"})

_DIGITAL = frozenset(("controller.extra_ticks", "controller.edge_hysteresis"))

_BESIDE = frozenset({"servo", "host"})
"""Of the encoder's servo, and of what has a line: a port whose host is silent has its own walls."""

_READINGS = frozenset(
    f"encoder.{key}"
    for key in ("kind", "part", "bits", "read_hz", "latency_s", "noise_counts", "bandwidth_hz",
                "hysteresis_counts")
)  # fmt: skip
"""Of an absolute encoder."""

_NO_W = {"shaper": "leave it out or take `golden`"}
_NO_EDGES = dict.fromkeys(
    ("adc.edge_settle_s", "adc.edge_hold_s"),
    "it has no edges of a bridge; leave it out or take `pins`",
)

ABILITIES: dict[str, Ability] = {
    "analog": Ability(
        _PINS | _ANCHOR | _INERTIA | _MAGNET | _DIGITAL | _BESIDE | _READINGS
        | {"encoder.stops_at_s", "encoder.reverses_at_s", "encoder.uneven",
           "encoder.skips_per_rev", "adc", "controller.l_hat", "controller.k_t_hat",
           "controller.anchor_auto", "controller.r_hat_part"},
        _NO_W,
    ),
    "golden": Ability(_PINS | _INERTIA | _BESIDE, _NO_EDGES),
    "core": Ability(_PINS | _INERTIA | _BESIDE, _NO_EDGES),
    "pins": Ability(_INERTIA | _BESIDE),
    "encoder": Ability(
        _PINS | _ANCHOR | _INERTIA | _DIGITAL
        | {"adc", "host", "encoder.uneven", "controller.eta_contact", "controller.eta_free",
           "controller.anchor_auto", "controller.r_hat_part"},
        _NO_W | {"controller.find_magnet": "a servo has to know the angle; leave it out"},
    ),
    "hosted": Ability(
        _PINS | _INERTIA | _BESIDE,
        _NO_EDGES
        | {
            "shaper": "the environment is the host's; leave it out",
            "thermal": "leave it out or take `golden`",
            "controller.edge_hysteresis": "leave it out or take `golden`",
        },
    ),
    "a board": Ability(
        _INERTIA | {"guard.trip_a", "guard.watch"},
        refused={
            "servo": "leave it out",
            "encoder.kind": "it reads A and B; leave it out, and set counts_per_rev to theirs",
            "drive.bus_measured": "no board measures its bus yet; set it to false",
        },
    ),
}  # fmt: skip
"""By what runs a scene."""


WITHOUT_WORDS = ("analog", "encoder", "a board")
"""Controllers that compute in real numbers, or don't show theirs."""

BRUSHLESS_RUNGS = ("analog", "golden", "core", "pins", "encoder")
"""Controllers that a brushless motor runs on, besides a board with three legs."""

BRUSHLESS_USES = {"encoder": frozenset({"adc"})}
"""What is left out with brushes alone: the usual way of a brushless motor samples its currents."""

_NO_READINGS = {
    "encoder.kind": "with a brushless motor only `golden` and `core` have it; leave it out"
}

BRUSHLESS_REFUSES = {"encoder": _NO_EDGES | _NO_READINGS, "pins": _NO_READINGS}
"""What is refused with a brushless motor alone."""

_LEAVE_OUT = "a brushless motor does without it yet; leave it out"

BRUSHLESS: dict[str, str] = {
    "brushes": "a brushless motor has none; leave it out",
    "drive.mode": "a brushless motor has a bridge of three legs; leave it out",
    **dict.fromkeys(
        ("winding", "thermal", "transmission.cable_stiffness", "encoder.stops_at_s",
         "encoder.reverses_at_s", "encoder.uneven", "encoder.skips_per_rev", "adc.bandwidth_hz",
         "adc.common_mode_a", "adc.drift_a_per_s", "drive.bus_measured", "drive.step_v",
         "drive.sag_ohm"),
        _LEAVE_OUT,
    ),
}  # fmt: skip
"""What is refused besides where the motor is a ``pmsm``, with the cure."""

BRUSHLESS_DEVICE: dict[str, str] = {
    "shaper": "with a brushless motor it does without it yet; leave it out, or `run` the scene"
}
"""And what besides that where its controller is in ``rtl/wh_device.v``: on a board, real or
virtual."""


def asked(scene: Scene) -> set[str]:
    """Tables and keys (``table``, ``table.key``) in which a scene asks for more than their default.

    What the loader fills in is none of it: estimates that are the motor's own, an anchor's η.
    """
    usual = {
        "controller.l_hat": scene.motor.L_h,
        "controller.k_t_hat": scene.motor.felt_k_t,
        "controller.j_hat": scene.motor.J_kgm2,
        "controller.magnet_hat_rad": scene.motor.magnet_rad,
        "controller.r_hat": scene.motor.R_ohm,
        "controller.eta_free": scene.controller.eta_free if scene.controller.anchored else 1.0,
    }
    found = set()
    for table in type(scene).model_fields:
        values = getattr(scene, table)
        if values is None:
            continue
        keys = {
            f"{table}.{key}"
            for key in values.model_fields_set
            if getattr(values, key) not in (
                type(values).model_fields[key].default, usual.get(f"{table}.{key}")
            )
        }  # fmt: skip
        found |= keys | {table}
    return found


def refuse(scene: Scene, name: str, *, device: bool = False) -> None:
    """:class:`SceneError` where ``name`` of ABILITIES can't do what the scene asks for.

    ``device``: its controller is in ``rtl/wh_device.v``, as a board's always is.
    """
    asked_for = asked(scene)
    refused = ABILITIES[name].refused
    if scene.motor.brushless:
        if name not in (*BRUSHLESS_RUNGS, "a board"):
            *others, last = (f"`{rung}`" for rung in BRUSHLESS_RUNGS)
            raise scene.refusal(
                f'motor.kind = "pmsm" is not for `{name}` yet; take {", ".join(others)} or {last}',
                "motor.kind",
                "motor.preset",
            )
        refused = {**BRUSHLESS, **refused, **BRUSHLESS_REFUSES.get(name, {})}
        if device or name == "a board":
            refused |= BRUSHLESS_DEVICE
    for what, cure in refused.items():
        if what in asked_for:
            shown = what if "." in what else f"[{what}]"
            by = "a board" if device and what in BRUSHLESS_DEVICE else f"`{name}`"
            raise scene.refusal(f"{shown} is not for {by}; {cure}", what)


def _without_use(scene: Scene, name: str) -> set[str]:
    """Estimates that nothing in this scene is made from: the waves take R̂ alone."""
    control = scene.controller
    if name == "encoder":
        return set()
    unused = set() if control.anchored else {"controller.magnet_hat_rad"}
    if control.anchored or scene.shaper is not None:
        return unused
    corrects = name == "pins" and scene.drive is not None and scene.drive.compensate
    return unused | {"controller.k_t_hat"} | (set() if corrects else {"controller.l_hat"})


def left_out(scene: Scene, name: str, *, linked: bool = False) -> list[str]:
    """What the scene asks for and ``name`` of ABILITIES leaves out, in alphabetical order.

    ``linked``: it has a line, as a virtual board has, and so a host.
    """
    asked_for = asked(scene)
    without = ABILITIES[name].left_out | _without_use(scene, name)
    if linked:
        without -= {"host"}
    if scene.motor.brushless:
        without -= BRUSHLESS_USES.get(name, frozenset())
    tables = {what for what in without if "." not in what} & asked_for
    keys = {
        what for what in without & asked_for
        if "." in what and what.partition(".")[0] not in tables
    }  # fmt: skip
    return sorted(keys | {f"[{table}]" for table in tables})
