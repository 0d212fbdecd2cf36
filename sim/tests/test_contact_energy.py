# SPDX-License-Identifier: Apache-2.0
"""The judges of a wall in a hand against a simulation in floats of its own.

Motor, waves, hand and the integrals of energy are written here a second time, by the equations of
``docs/principle.md`` and Runge-Kutta's fourth order; of the package only the compiler is used.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from wavehaptics.ladder.run import measure
from wavehaptics.runtime.compiled import compiled_counting

R, L, K_T, J = 2.18, 0.24e-3, 23.4e-3, 10.3e-7
T, PARTS, A = 10e-6, 16, 0.99
CELL = 2.0 * math.pi / 10_000
HAND_K, HAND_B = 0.3, 1e-3
BASE = ("controller.tick_hz=100e3", "controller.lambda=1e9", "controller.extra_ticks=1",
        "encoder.counts_per_rev=10000", "hand.stiffness=0.3")  # fmt: skip
WALL = ("controller.walls=[[0.0, 1.0]]", "hand.damping=1e-3")


@compiled_counting()
def _hand(kind, amplitude, hertz, time):
    """(x_h, dx_h/dt) of the path `taps` (kind 0) or `press` (1)."""
    if kind == 0:
        turn = 2.0 * math.pi * hertz
        return -amplitude * math.cos(turn * time), amplitude * turn * math.sin(turn * time)
    if time < 0.05:
        return amplitude * (22.0 * time - 0.1), 22.0 * amplitude
    return amplitude, 0.0


@compiled_counting()
def _slopes(z, out, e, kind, amplitude, hertz, time, hand_b):
    """Of i, ω, x and the work of the motor's torque."""
    hand, hand_speed = _hand(kind, amplitude, hertz, time)
    out[0] = (e - R * z[0] - K_T * z[1]) / L
    out[1] = (K_T * z[0] - HAND_K * (z[2] - hand) - hand_b * (z[1] - hand_speed)) / J
    out[2] = z[1]
    out[3] = K_T * z[0] * z[1]


@compiled_counting()
def _simulate(ticks, r_hat, wall, kind, amplitude, hertz, hand_b, out):
    """Fill ``out`` (ticks, 5): contact, x, mean torque, work so far, mean of x, at ticks' ends."""
    s = math.sqrt(2.0 * r_hat)
    z, mid = np.zeros(4), np.zeros(4)
    k1, k2, k3, k4 = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    z[2] = -amplitude if kind == 0 else -0.1 * amplitude
    z[1] = 0.0 if kind == 0 else 22.0 * amplitude
    f, u_now, u_next = 0.0, 0.0, 0.0
    h = T / PARTS
    for n in range(ticks):
        e, charge, way = s * u_now, 0.0, 0.0
        for p in range(PARTS):
            time = n * T + p * h
            _slopes(z, k1, e, kind, amplitude, hertz, time, hand_b)
            for q in range(4):
                mid[q] = z[q] + 0.5 * h * k1[q]
            _slopes(mid, k2, e, kind, amplitude, hertz, time + 0.5 * h, hand_b)
            for q in range(4):
                mid[q] = z[q] + 0.5 * h * k2[q]
            _slopes(mid, k3, e, kind, amplitude, hertz, time + 0.5 * h, hand_b)
            i_middle, x_middle = mid[0], mid[2]
            for q in range(4):
                mid[q] = z[q] + h * k3[q]
            _slopes(mid, k4, e, kind, amplitude, hertz, time + h, hand_b)
            before, x_before = z[0], z[2]
            for q in range(4):
                z[q] += h / 6.0 * (k1[q] + 2.0 * k2[q] + 2.0 * k3[q] + k4[q])
            charge += (before + 4.0 * i_middle + z[0]) / 6.0
            way += (x_before + 4.0 * x_middle + z[2]) / 6.0
        v = u_now - s * charge / PARTS
        touching = wall and z[2] >= 0.0
        f += A * ((-v if touching else v) - f)
        u_now, u_next = u_next, f
        out[n, 0], out[n, 1], out[n, 3] = touching, z[2], z[3]
        out[n, 2], out[n, 4] = K_T * charge / PARTS, way / PARTS


def simulated(duration_s, r_hat, wall, kind, amplitude, hertz=0.0, hand_b=HAND_B):
    """The trace of the float simulation, a row a tick."""
    out = np.zeros((round(duration_s / T), 5))
    _simulate(len(out), r_hat, wall, kind, amplitude, hertz, hand_b, out)
    return out


def energies(out: np.ndarray, r_hat: float) -> tuple[float, float]:
    """(largest energy, largest energy over what the spring held) of a run's contacts.

    Cut by hand: a contact ends where the rotor is two counts away from it.
    """
    k = K_T**2 / (L + r_hat * (T / A + T) / 2.0)
    found, n = [], 0
    inside, x, torque, work = out[:, 0] > 0.0, out[:, 1], out[:, 2], out[:, 3]
    while n < len(out):
        if not inside[n]:
            n += 1
            continue
        away = np.flatnonzero(~inside[n:] & (x[n:] < -2.0 * CELL))
        end = n + (int(away[0]) if len(away) else len(out) - n)
        energy = work[end - 1] - (work[n - 1] if n else 0.0)
        held = 0.5 * torque[n:end] ** 2 / k
        if not len(away):
            energy += held[-1]
        found.append((energy, energy / max(held.max(), 0.5 * k * (2.0 * CELL) ** 2)))
        n = end
    return max(e for e, _ in found), max(part for _, part in found)


@pytest.mark.parametrize("part", [0.98, 1.0, 1.003, 1.01], ids="R̂ {}".format)
@pytest.mark.parametrize("hertz", [8.0, 20.0], ids="{} Hz".format)
def test_taps_give_what_a_float_integral_says(make_scene, part, hertz):
    r_hat, amplitude, duration = part * R, 0.05, 0.9 / hertz
    out = simulated(duration, r_hat, True, 0, amplitude, hertz)
    energy, ratio = energies(out, r_hat)
    scene = make_scene(
        *BASE, *WALL, "hand.path=taps", f"hand.amplitude_rad={amplitude}",
        f"hand.frequency_hz={hertz}", f"controller.r_hat={r_hat}", f"scene.duration_s={duration}",
    )  # fmt: skip
    got = measure(scene, "golden", compare=False)
    print(part, hertz, energy, ratio, got["contact_energy_j"], got["contact_energy_ratio"])
    assert got["contact_energy_j"] == pytest.approx(energy, rel=2e-3, abs=1e-4 * energy / ratio)
    assert got["contact_energy_ratio"] == pytest.approx(ratio, rel=2e-3, abs=1e-4)


@pytest.mark.parametrize("part", [0.98, 1.0, 1.005], ids="R̂ {}".format)
def test_a_hold_counts_with_what_its_spring_still_holds(make_scene, part):
    r_hat, amplitude, duration = part * R, 0.08, 0.12
    out = simulated(duration, r_hat, True, 1, amplitude)
    energy, ratio = energies(out, r_hat)
    assert out[-1, 0]
    scene = make_scene(
        *BASE, *WALL, "hand.path=press", f"hand.amplitude_rad={amplitude}",
        f"controller.r_hat={r_hat}", f"scene.duration_s={duration}",
    )  # fmt: skip
    got = measure(scene, "golden", compare=False)
    print(part, energy, ratio, got["contact_energy_j"], got["contact_energy_ratio"])
    assert got["contact_energy_j"] == pytest.approx(energy, rel=2e-3, abs=1e-4 * energy / ratio)
    assert got["contact_energy_ratio"] == pytest.approx(ratio, rel=2e-3, abs=1e-4)


@pytest.mark.parametrize("hand_b", [0.0, 10e-6])
def test_a_hold_swings_as_a_float_simulation_does(make_scene, hand_b):
    """A rotor that swings on the hand's spring, free of walls: a sine fitted to its last tenth."""
    amplitude, duration = 0.02, 0.5
    out = simulated(duration, R, False, 1, amplitude, hand_b=hand_b)
    last = out[-len(out) // 10 :, 4]
    t = np.arange(len(last)) * T

    def fitted(hertz: float) -> tuple[float, float]:
        """Amplitude of the best sine of a frequency, and what is left, RMS."""
        turn = 2.0 * math.pi * hertz * t
        basis = np.stack([np.cos(turn), np.sin(turn), np.ones_like(t), t], axis=1)
        best, _, _, _ = np.linalg.lstsq(basis, last, rcond=None)
        return math.hypot(*best[:2]), float(np.std(last - basis @ best))

    hertz = min(np.arange(80.0, 90.0, 0.05), key=lambda f: fitted(f)[1])
    swing, _ = fitted(hertz)
    scene = make_scene(
        *BASE, f"hand.damping={hand_b}", "hand.path=press", f"hand.amplitude_rad={amplitude}",
        f"scene.duration_s={duration}",
    )  # fmt: skip
    got = measure(scene, "golden", compare=False)
    about_line = float(np.std(last - np.polyval(np.polyfit(t, last, 1), t)))
    print(hand_b, swing, hertz, about_line, got["swing_rad"], got["swing_hz"])
    assert swing > 2e-5
    assert got["swing_rad"] == pytest.approx(math.sqrt(2.0) * about_line, rel=2e-3)
    assert got["swing_rad"] == pytest.approx(swing, rel=0.05)  # not a whole number of periods
    assert got["swing_hz"] == pytest.approx(hertz, rel=2e-3)
