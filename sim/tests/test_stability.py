# SPDX-License-Identifier: Apache-2.0
"""Largest stable stiffnesses: the criteria, the bisection, and the known bounds."""

from __future__ import annotations

import pytest
from wavehaptics.laws import closed_forms
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.studies import stability


def load(*settings: str):
    return load_scene(find_scene("encoder_wall"), settings)


def test_encoders_limit_lies_near_the_bound_of_sampling():
    """Without Coulomb friction it takes about the damping of 2b/T to hold a sampled spring."""
    for damping in (0.5e-4, 1.53e-4, 1e-3):
        limit, capped = stability.largest_stiffness(load(f"hand.damping={damping}"), "encoder")
        assert not capped
        assert 0.5 < limit / (2 * damping / 1e-3) < 1.5


def test_the_verdict_is_that_of_both_sides_of_the_limit():
    limit, _ = stability.largest_stiffness(load(), "encoder")
    for part, wanted in ((0.8, True), (1.25, False)):
        scene = stability.with_stiffness(load(), "encoder", part * limit)
        assert stability.stable(scene, "encoder", part * limit) is wanted


@pytest.mark.parametrize("counts", [100, 1000])
def test_coulomb_friction_brings_the_rotor_to_rest_below_its_bound(counts):
    scene = load(f"encoder.counts_per_rev={counts}", "friction.coulomb_nm=5e-4")
    bound = 2 * 5e-4 / stability.cell_rad(scene)
    limit, _ = stability.largest_stiffness(scene, "encoder", stability.at_rest)
    assert bound < limit < 4 * bound
    unheld = load(f"encoder.counts_per_rev={counts}")
    assert not stability.at_rest(
        stability.with_stiffness(unheld, "encoder", bound), "encoder", bound
    )


@pytest.mark.parametrize("tick_hz", [1e3, 1e5])
@pytest.mark.parametrize("damping", [0.0, 1.53e-4])
def test_the_wave_wall_is_stable_up_to_the_stiffest(tick_hz, damping):
    """Passive by itself: with a hand that damps nothing, viscous friction alone, at any rate."""
    scene = load(f"controller.tick_hz={tick_hz}", f"hand.damping={damping}",
                 "friction.viscous=1e-5")  # fmt: skip
    limit, capped = stability.largest_stiffness(scene, "golden")
    assert capped
    motor = scene.motor
    tau = 2 / tick_hz
    assert limit == pytest.approx(
        closed_forms.stiffness(motor.k_t, motor.L_h, motor.R_ohm, tau), rel=1e-6
    )
    same = load(f"hand.damping={damping}", "friction.viscous=1e-5")
    assert not stability.largest_stiffness(same, "encoder")[1]


def test_delay_lowers_the_encoders_limit():
    limits = [
        stability.largest_stiffness(load(f"servo.delay_s={delay}"), "encoder", halvings=6)[0]
        for delay in (0.0, 1e-3, 10e-3)
    ]
    assert limits[0] > 2 * limits[1] > 4 * limits[2] > 0


def test_no_limit_where_nothing_holds():
    assert stability.largest_stiffness(load(), "encoder", lambda *_: False) == (None, False)
