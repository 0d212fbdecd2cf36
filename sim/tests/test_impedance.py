# SPDX-License-Identifier: Apache-2.0
"""What a swept hand measures of every feel, against what was designed: within 2 % to 500 Hz."""

from __future__ import annotations

import json

import numpy as np
import pytest
from wavehaptics.studies import impedance_picture
from wavehaptics.studies.impedance import measure

HERTZ = (2.0, 20.0, 100.0, 250.0, 500.0)
CONTACT = ("controller.walls=[[0, 1]]", "controller.lambda=1e9")
FEELS = {
    "rigid": CONTACT,
    "damped": (*CONTACT, "controller.eta_contact=-0.5"),
    "damper": (*CONTACT, "controller.eta_contact=0.0"),
    "spring": (*CONTACT, "shaper.feel=spring", "shaper.stiffness=0.5"),
    "stiff spring": (*CONTACT, "shaper.feel=spring", "shaper.stiffness=2.2"),
    "spring-damper": (
        *CONTACT, "shaper.feel=spring", "shaper.stiffness=0.5", "shaper.damping=2e-4",
    ),
    "layer": (*CONTACT, "shaper.feel=layer", "shaper.stiffness=0.5", "shaper.damping=1e-4"),
    "mass": (*CONTACT, "shaper.feel=mass", "shaper.mass_kgm2=1e-5", "shaper.damping=5e-4"),
    "resonance": (
        *CONTACT, "shaper.feel=resonance", "shaper.stiffness=0.5", "shaper.mass_kgm2=2.5e-6",
        "shaper.damping=2e-4",
    ),
}  # fmt: skip


@pytest.mark.parametrize("feel", FEELS)
def test_what_is_felt_is_what_was_designed(feel, make_scene):
    found = measure(make_scene(*FEELS[feel]), HERTZ)
    assert np.abs(found.errors).max() < 0.02, dict(zip(HERTZ, found.errors, strict=True))
    # The port's own prediction, with every delay, is met closer than the wish.
    assert np.abs(found.measured / found.rendered - 1.0).max() < 0.004
    assert found.energy_out_j <= 0.0


def test_free_space_adds_nothing_to_the_rotors_own_inertia(make_scene):
    """It is the delay's inertia, 4·10⁻⁴ of the rotor's; seen beside the rotor's, to 10⁻⁴."""
    scene = make_scene("controller.lambda=1e9")
    found = measure(scene, HERTZ)
    rotor = 2 * np.pi * np.array(HERTZ) * scene.motor.J_kgm2
    assert np.abs(found.measured / rotor).max() < 1e-3
    assert np.abs((found.measured - found.rendered) / rotor).max() < 1e-4
    assert found.energy_out_j <= 0.0


def test_a_soft_wish_is_limited_by_the_delay_in_free_space(make_scene):
    """Below the inertia that the delay adds nothing can be rendered, and the prediction says so."""
    scene = make_scene(*CONTACT, "shaper.feel=spring", "shaper.stiffness=0.005")
    found = measure(scene, (20.0, 500.0))
    assert found.errors[0] < 0.02
    assert found.errors[1] > 0.2
    assert np.abs(found.measured / found.rendered - 1.0).max() < 0.004


def test_files(make_scene, tmp_path):
    scene = make_scene(*FEELS["spring-damper"])
    found = impedance_picture.write(scene, measure(scene, (50.0, 200.0)), tmp_path)
    assert json.loads((tmp_path / "impedance.json").read_text()) == found
    assert found["error_max"] == max(found["error"])
    assert (tmp_path / "impedance.png").stat().st_size > 10_000
