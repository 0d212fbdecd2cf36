# SPDX-License-Identifier: Apache-2.0
"""A controller knows of the plant only what its ``_hat`` keys say.

Twice: no module of a control law reads a constant of the motor, and no key of the plant changes a
setting of any controller while the hats stay.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from test_abilities import ANCHORED, BASE, BRUSHLESS, DRIVEN, ENCODER, KEYS, SENSED, SERVO, SPRING
from wavehaptics.controller import guard
from wavehaptics.controller.ports import controller_ports
from wavehaptics.controller.settings import settings
from wavehaptics.ladder import encoder, field_oriented
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.brushless import magnet_words
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import Scene, SceneError, load_scene

PLANT = ("motor", "load", "friction", "brushes", "winding", "cogging", "hand", "thermal",
         "transmission")  # fmt: skip
"""Tables of the plant."""
ERRORS = (
    "encoder.uneven", "encoder.stops_at_s", "encoder.reverses_at_s", "encoder.skips_per_rev",
    "adc.noise_a", "adc.offset_a", "adc.common_mode_a", "adc.edge_settle_s", "adc.edge_hold_s",
    "adc.edge_hold_restarts", "adc.drift_a_per_s",
    "drive.gain_error", "drive.bus_actual_v", "drive.bus_ripple_v", "drive.bus_ripple_hz",
    "drive.step_v", "drive.step_s", "drive.sag_ohm",
)  # fmt: skip
"""Keys by which what a controller is connected to isn't as it takes it to be."""
KNOWN = {
    "motor.kind": "which bridge and how many ports there are",
    "motor.pole_pairs": "a whole number, as the encoder's counts are",
    "hand.path": "where the rotor stands at reset is where the counts begin",
    "hand.amplitude_rad": "the same",
}
"""Keys of the plant that a controller does know, and why."""

HATS = ("controller.r_hat=2.2", "controller.l_hat=0.25e-3", "controller.k_t_hat=0.024",
        "controller.j_hat=1.1e-6")  # fmt: skip
BRUSHLESS_HATS = ("controller.r_hat=4.6", "controller.l_hat=0.9e-3", "controller.k_t_hat=0.033",
                  "controller.j_hat=2e-6", "controller.magnet_hat_rad=0.02")  # fmt: skip
VARIANTS: dict[str, tuple[str, ...]] = {
    "plain": HATS,
    "with a bus and an ADC of its own scale": (*HATS, *DRIVEN, "adc.bits=12"),
    "anchored": (*HATS, *ENCODER, *SENSED, *DRIVEN, *ANCHORED),
    "measured bus": (*HATS, *ENCODER, *DRIVEN, "drive.bus_measured=true", "drive.sag_ohm=1"),
    "shaped": (*HATS, *ENCODER, *SENSED, *DRIVEN, *SPRING),
    "dead time": (*HATS, *SENSED, *DRIVEN, "drive.dead_time_s=200e-9"),
    "brushless": (*BRUSHLESS, *SERVO, *BRUSHLESS_HATS, *ANCHORED),
}


def plant_keys() -> list[str]:
    return [
        key for key in KEYS
        if (key.partition(".")[0] in PLANT or key in ERRORS) and key not in KNOWN
    ]  # fmt: skip


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("hats") / "every_key.toml"
    path.write_text(BASE)
    return path


def known(scene: Scene) -> dict[str, object]:
    """All that the controllers of a scene are set to, by name."""
    found: dict[str, object] = {}
    set_ = settings(scene)
    for field in fields(set_):
        found[f"settings.{field.name}"] = getattr(set_, field.name)
    found["settings.shaper"] = set_.shaper.words
    found["eta"] = (scene.controller.eta_free, scene.controller.eta_contact)
    found["full scale"] = scene.adc.full_scale_a if scene.adc else None
    try:
        refuse(scene, "pins")
        ports = controller_ports(scene)
        found["ports"] = ports.words
        found["walls"] = ports.walls
        found["scale"] = ports.sensor.full_scale_a
        for field in fields(ports.settings):
            found[f"ports.settings.{field.name}"] = getattr(ports.settings, field.name)
        found["ports.settings.shaper"] = ports.settings.shaper.words
        limits = guard.board_limits(scene, ports)
        unity = ports.timing.frame.unity
        found["guard"] = guard.settings(limits, set_.tick_s, ports.sensor, set_.s, unity)
        if scene.motor.brushless:
            found["magnets"] = magnet_words(scene, set_, ports.start_count)
    except SceneError as refusal:
        found["pins"] = str(refusal)
    try:
        refuse(scene, "encoder")
    except SceneError as refusal:
        return found | {"encoder": str(refusal)}
    if scene.motor.brushless:
        floats = field_oriented.FieldOrientedSimulation(scene)._floats
        own = (field_oriented._AMPS, field_oriented._KP, field_oriented._KI,
               field_oriented._LIMIT, field_oriented._TURN, field_oriented._ZERO)  # fmt: skip
    else:
        floats = encoder.EncoderSimulation(scene)._floats
        own = (encoder._KP, encoder._KI, encoder._LIMIT, encoder._K_T_HAT)
    found["servo"] = floats[[*range(encoder.SERVO_FLOATS), *own]]
    return found


def same(first: object, second: object) -> bool:
    if isinstance(first, np.ndarray):
        return isinstance(second, np.ndarray) and np.array_equal(first, second)
    return first == second


def test_the_lists_name_keys_that_there_are() -> None:
    assert set(ERRORS) | set(KNOWN) <= set(KEYS)
    assert all(any(key.startswith(f"{table}.") for key in KEYS) for table in PLANT)


def test_no_key_of_the_plant_changes_a_controller(base: Path) -> None:
    wrong, compared = [], set()
    for name, variant in VARIANTS.items():
        for key in plant_keys():
            others, change = KEYS[key]
            if key in ERRORS and name == "measured bus" and key.startswith("drive."):
                continue  # what is measured is known
            if BRUSHLESS[0] in others and BRUSHLESS[0] not in variant:
                continue
            try:
                before = load_scene(base, (*others, *variant))
                after = load_scene(base, (*others, *variant, *change))
                refuse(after, "pins")
                first, second = known(before), known(after)
            except SceneError:
                continue  # the table isn't for this kind of motor
            if key == "adc.edge_hold_s" and "servo" in first and "encoder" in second:
                del first["servo"], second["encoder"]  # it has no edges of a bridge
            assert set(first) == set(second), (name, key)
            if before != after:
                compared.add(key)
            protects = {"guard"} if key.startswith("thermal.") else set()
            for setting in first.keys() - protects:
                if not same(first[setting], second[setting]):
                    wrong.append(f"{name}: {key} changes {setting}")
    assert not wrong, "\n".join(wrong)
    # Each key was tried on some controller.
    assert compared == set(plant_keys())


@pytest.mark.parametrize("hat", ["r_hat", "l_hat", "k_t_hat", "magnet_hat_rad"])
def test_every_hat_does_change_one(base: Path, hat: str) -> None:
    variant = VARIANTS["brushless" if hat == "magnet_hat_rad" else "anchored"]
    first = known(load_scene(base, variant))
    (given,) = (float(key.partition("=")[2]) for key in variant if f".{hat}=" in key)
    second = known(load_scene(base, (*variant, f"controller.{hat}={1.3 * given}")))
    assert any(not same(first[setting], second[setting]) for setting in first)


def test_no_law_needs_an_inertia(base: Path) -> None:
    first = known(load_scene(base, VARIANTS["anchored"]))
    second = known(load_scene(base, (*VARIANTS["anchored"], "controller.j_hat=5e-5")))
    assert all(same(first[setting], second[setting]) for setting in first)


def test_by_default_the_hats_are_the_bare_motors(base: Path) -> None:
    scene = load_scene(base, ("load.inertia_kgm2=5e-6", "hand.inertia_kgm2=3e-6"))
    control, motor = scene.controller, scene.motor
    hats = (control.r_hat, control.l_hat, control.k_t_hat, control.j_hat)
    assert hats == (motor.R_ohm, motor.L_h, motor.k_t, motor.J_kgm2)


def test_a_released_rotor_has_no_hand_to_have_a_mass(make_scene) -> None:
    with pytest.raises(SceneError, match=r'hand\.inertia_kgm2 makes no sense: path = "impact"'):
        make_scene("hand.path=impact", "hand.amplitude_rad=0.1", "hand.speed_rad_s=1",
                   "hand.inertia_kgm2=1e-6")  # fmt: skip


LAWS = ("laws", "controller")
"""Layers of the control laws; what runs them beside a motor, the ladder, has both."""
READ = {("guard.py", "thermal"): "what a winding bears, for its protection"}
"""Tables of the plant that a module of LAWS does read, and why."""
OF_THE_MOTOR = {"brushless"}
"""Of ``[motor]``: which controller it is."""


def reads(path: Path) -> Iterator[tuple[str, str]]:
    """(table, key) of each key of the motor, and (table, "") of each table of a scene's plant."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Attribute):
            continue
        inner = node.value
        if isinstance(inner, ast.Attribute) and inner.attr == "motor":
            yield "motor", node.attr
        if isinstance(inner, ast.Name) and inner.id == "motor":
            yield "motor", node.attr
        if isinstance(inner, ast.Name) and inner.id == "scene" and node.attr in PLANT:
            yield node.attr, ""


def test_no_control_law_reads_the_plant() -> None:
    wrong, seen = [], set()
    modules = [path for layer in LAWS for path in (ROOT / "sim/wavehaptics" / layer).glob("*.py")]
    assert len(modules) > 15
    for path in modules:
        for table, key in reads(path):
            if table == "motor" and key in (*OF_THE_MOTOR, ""):
                continue
            if (path.name, table) in READ:
                seen.add((path.name, table))
                continue
            wrong.append(f"{path.name} reads {table}.{key}")
    assert not wrong, "\n".join(wrong)
    assert seen == set(READ)
