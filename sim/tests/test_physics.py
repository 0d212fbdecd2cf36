# SPDX-License-Identifier: Apache-2.0
"""The closed forms: their numbers, and that a controller by the book really obeys them."""

import math

import pytest
from wavehaptics.laws import closed_forms

R, L, K_T = 2.18, 0.24e-3, 23.4e-3
OMEGA = 0.7


def rise(part: float) -> float:
    """A smooth step from 0 at ``part`` ≤ 0 to 1 at ``part`` ≥ 1."""
    part = min(max(part, 0.0), 1.0)
    return part - math.sin(2.0 * math.pi * part) / (2.0 * math.pi)


def currents(
    tick_s: float, a: float, extra_ticks: int, eta: float, speeds: list[float]
) -> list[float]:
    """Mean currents of the ticks, A, of the motor under the controller with R̂ = R.

    ``speeds`` are those of the ticks, rad/s; the winding is advanced exactly for a speed that is
    constant within the tick.
    """
    s = closed_forms.root(R)
    decay = math.exp(-R * tick_s / L)
    pending = [0.0] * (extra_ticks + 1)
    i = f = 0.0
    means = []
    for speed in speeds:
        e = pending.pop(0)
        goal = (e - K_T * speed) / R
        i_end = goal + (i - goal) * decay
        mean = goal - L * (i_end - i) / (R * tick_s)
        i = i_end
        means.append(mean)
        f += a * (eta * (e / s - s * mean) - f)
        pending.append(s * f)
    return means


TICKS = [(1e-6, 0.0101, 1), (1e-6, 1.0, 1), (20e-6, 0.3, 0), (50e-6, 1.0, 3), (200e-6, 0.8, 2)]


def test_numbers_of_the_paper():
    assert closed_forms.k_l(K_T, L) == pytest.approx(2.2815)
    assert closed_forms.b_r(K_T, R) == pytest.approx(2.5117e-4, rel=1e-4)
    assert closed_forms.root(2.0) == 2.0
    # The preset of the paper's arm: 8:1 at 0.14 m, 7500 N/m at the tip.
    assert closed_forms.k_l(43.8e-3, 0.83e-3) * (8 / 0.14) ** 2 == pytest.approx(7547, abs=1)


def test_stiffest_wall_at_1_mhz():
    tau = closed_forms.tau(1e-6, 1.0, 1)
    assert tau == 2e-6
    assert closed_forms.stiffness(K_T, L, R, tau) / closed_forms.k_l(K_T, L) == pytest.approx(
        0.991, abs=1e-4
    )


@pytest.mark.parametrize(("tick_s", "a", "k"), TICKS)
def test_rigid_contact_is_the_predicted_spring(tick_s, a, k):
    # Speed comes smoothly: with a = 1 the loop around the inductor, which is lossless, rings on.
    tau = closed_forms.tau(tick_s, a, k)
    ticks = round(100 * (tau + L / R) / tick_s)
    i = currents(tick_s, a, k, -1.0, [OMEGA * rise(n / (0.9 * ticks)) for n in range(ticks)])
    slope = (i[-1] - i[-11]) / (10 * tick_s)
    stiffness = -K_T * slope / OMEGA
    assert stiffness == pytest.approx(closed_forms.stiffness(K_T, L, R, tau), rel=1e-6)


@pytest.mark.parametrize(("tick_s", "a", "k"), TICKS)
@pytest.mark.parametrize("g", [0.9, 0.5, 0.0, -0.5])
def test_damped_contact_is_the_predicted_resistance_and_inductance(tick_s, a, k, g):
    tau = closed_forms.tau(tick_s, a, k)
    resistance = closed_forms.series_resistance(R, g)
    inductance = closed_forms.l_eff(L, R, tau, g)
    ticks = round(60 * (tau + L / R + abs(inductance) / resistance) / tick_s) + 100
    i = currents(tick_s, a, k, -g, [OMEGA] * ticks)
    final = -K_T * OMEGA / resistance
    assert i[-1] == pytest.approx(final, rel=1e-9)
    # ∫(i(∞) − i) dt after a step is i(∞)·L_eff/R_series, whatever the higher terms are.
    missing = sum(final - value for value in i) * tick_s
    assert missing == pytest.approx(final * inductance / resistance, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize(("tick_s", "a", "k"), TICKS)
def test_free_space_is_the_predicted_inertia(tick_s, a, k):
    tau = closed_forms.tau(tick_s, a, k)
    ticks = round(100 * (tau + L / R) / tick_s)
    speeds, acceleration = [0.0], 50.0
    for n in range(ticks):
        speeds.append(speeds[-1] + acceleration * tick_s * rise(n / (0.9 * ticks)))
    torque = K_T * currents(tick_s, a, k, 1.0, speeds)[-1]
    inertia = closed_forms.free_space_inertia(K_T, R, tau)
    assert -torque / acceleration == pytest.approx(inertia, rel=1e-6)


def test_full_reflection_in_phase_has_no_inductance():
    for g in (-1.0, 1.0001, -2.0):
        with pytest.raises(ValueError, match="g = −η"):
            closed_forms.l_eff(L, R, 1e-6, g)
        with pytest.raises(ValueError, match="g = −η"):
            closed_forms.series_resistance(R, g)


@pytest.mark.parametrize("k", [0, 1, 50, 98])
def test_matched_a_gives_the_whole_delay(k):
    a = closed_forms.matched_a(1e-6, 1e4, k)
    assert 0.0 < a < 1.0
    assert closed_forms.tau(1e-6, a, k) == pytest.approx(1e-4, rel=1e-12)


@pytest.mark.parametrize(
    ("tick_s", "lambda_", "k"),
    [
        (1e-6, 1e4, 100),  # the latency takes all of 1/λ
        (1e-6, 1e4, 1000),  # and more
        (1e-6, 1e9, 0),
        (0.25, 4.0, 0),  # exactly one tick is left
        (0.25, 1.0, 3),
    ],
)
def test_matched_a_is_the_largest_where_the_latency_leaves_no_more(tick_s, lambda_, k):
    assert closed_forms.matched_a(tick_s, lambda_, k) == closed_forms.MOST_A


def test_filter_stiffness_is_twice_what_the_paper_prints():
    lambda_ = 1e4
    printed = K_T**2 * lambda_ / R
    assert closed_forms.filter_stiffness(K_T, R, lambda_) == pytest.approx(2.0 * printed)
    # In series with K_L it is the analog circuit's wall, τ = 1/λ.
    series = 1.0 / (
        1.0 / closed_forms.k_l(K_T, L) + 1.0 / closed_forms.filter_stiffness(K_T, R, lambda_)
    )
    assert series == pytest.approx(closed_forms.stiffness(K_T, L, R, 1.0 / lambda_), rel=1e-12)
