# SPDX-License-Identifier: Apache-2.0
"""Surfaces across motors with the errors of real ones: how far they are from where they should be.

The numbers of [docs/surfaces.md], by ``make tables``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from wavehaptics.ladder.joint import JointSimulation
from wavehaptics.ladder.joint_run import TIP_PICTURE, measure_device, run_joint
from wavehaptics.scene import Device, find_scene, load_device
from wavehaptics.trace.tip import Tip, deepest

PLANE, DISC = "phantom_plane", "planar_disc"
PICTURE = f"{DISC}.png"
SETS = 6
"""Sets of motor errors, drawn with SEED."""
SEED = 1
R_PART, L_PART, K_T_PART, GAIN_PART, OFFSET_A = 0.1, 0.1, 0.05, 0.05, 3e-3
"""Errors of R̂, L̂, k̂_T and the drive's gain as parts, and of the sensor in A, each with a sign."""
REST_S = 0.1
"""A press without the slide ends when that would begin, s."""

RATES = ((1000.0, 1e-3), (100.0, 10e-3))
"""How often planes come, Hz, and how late, s."""
TURNS_HZ = (0.1, 0.3, 1.0, 2.3)
HANDS = (5.0, 1.0, 0.5)
"""Damping of the hand at the tip with which an encoder's servo is tried, N·s/m."""
STILL_COUNTS = 2.0
"""A press that swings by more isn't stable: the report's limit of a single motor."""
SOFT, STIFF, STEPS = 100.0, 1e4, 8
"""Stiffnesses between which the largest stable one is looked for, N/m, and in how many steps."""
IDEAL = ("brushes.drop_v=0", "controller.r_hat=7.6", "adc.offset_a=0")
TURNS = (0.0, 0.6)
LIFTS_AND_REACHES = ((-0.3, -0.3), (-0.3, 0.4), (0.2, -0.3), (0.2, 0.4), (0.7, -0.3), (0.7, 0.4))
"""Angles of a PHANTOM's axes, rad, at which its tip is pressed on the plane."""
GAP_M, DEEP_M = 1e-3, 5e-3
"""How far the plane is from the tip, and how far beyond that place the hand is, m."""
LONGEST_S = 3.0
"""Most of a way around the disc that is run, s."""


def wrong_motors(device: Device, rng: np.random.Generator) -> tuple[str, ...]:
    """Settings that make every estimate of a scene's motors wrong, with signs by ``rng``."""
    sets: list[str] = []
    for name, scene in device.motors.items():
        r, l, k_t, gain, offset = rng.choice([-1.0, 1.0], 5)  # noqa: E741
        motor, of = scene.motor, f"motors.{name}"
        sets += [
            f"{of}.controller.r_hat={motor.R_ohm * (1 + R_PART * r):.6g}",
            f"{of}.controller.l_hat={motor.L_h * (1 + L_PART * l):.6g}",
            f"{of}.controller.k_t_hat={motor.k_t * (1 + K_T_PART * k_t):.6g}",
            f"{of}.drive.gain_error={GAIN_PART * gain:.6g}",
            f"{of}.adc.offset_a={OFFSET_A * offset:.6g}",
        ]
    return tuple(sets)


def _row(what: str, runs: list[tuple[Device, dict[str, Any]]]) -> dict[str, Any]:
    """The worst of some runs; errors in counts of the tip."""
    counts = [JointSimulation(device, "golden").count_m for device, _ in runs]
    found = [metrics for _, metrics in runs]

    def worst(key: str) -> float:
        values = zip(found, counts, strict=True)
        return max((metrics[key] / count for metrics, count in values), key=abs)

    return {
        "what": what,
        "mean": worst("surface_error_mean_m"),
        "largest": worst("surface_error_max_m"),
        "drag": max(metrics["tangential_part"] for metrics in found),
        "energy": max(metrics["contact_energy_ratio"] for metrics in found),
        "contact": min(metrics["contact_fraction"] for metrics in found),
    }


def _held(controller: str, damping: float, stiffness: float | None) -> tuple[float, float]:
    """A press on the oblique plane by ideal motors, in its last tenth: swing in counts, and the
    force over the depth, N/m."""
    wish = () if stiffness is None else (f"surface.0.stiffness={stiffness:.6g}",)
    still = (f"scene.duration_s={4 * REST_S}", "hand.slide_m=0")
    sets = (*IDEAL, *still, f"hand.damping_n_s_per_m={damping}", *wish)
    return _rest(load_device(find_scene(PLANE), sets), controller)


def _rest(device: Device, controller: str) -> tuple[float, float]:
    """Swing in counts, and the force over the depth, N/m, in the last tenth of a press."""
    space = device.space
    assert space is not None
    kept: list[np.ndarray] = []

    def keep(rows: np.ndarray, words: np.ndarray, tips: np.ndarray) -> None:
        depth, normal, _ = deepest(space, tips[:, Tip.X : Tip.Z + 1])
        force = tips[:, Tip.FORCE_X : Tip.FORCE_Z + 1]
        kept.append(np.array([depth, -np.einsum("ij,ij->i", force, normal)]))

    measure_device(device, controller, keep=keep)
    depth, push = np.concatenate(kept, axis=1)
    rest = slice(-len(depth) // 10, None)
    count = JointSimulation(device, controller).count_m
    swing = math.sqrt(2.0) * float(depth[rest].std()) / count
    return swing, float(push[rest].mean() / depth[rest].mean())


def beside(progress: Callable[[str, float], None]) -> list[dict[str, Any]]:
    """The stiffest plane that a servo at 1 kHz holds still, and the wave's, for each hand."""
    rows = []
    for n, damping in enumerate(HANDS):
        progress("an encoder's servo at the same tip", n / len(HANDS))
        low, high = SOFT, STIFF
        for _ in range(STEPS):
            middle = math.sqrt(low * high)
            if _held("encoder", damping, middle)[0] <= STILL_COUNTS:
                low = middle
            else:
                high = middle
        swing, stiffness = _held("golden", damping, None)
        rows.append({
            "damping": damping, "encoder": low, "wave": stiffness, "wave_swing": swing,
        })  # fmt: skip
    return rows


def stiffness_map(progress: Callable[[str, float], None]) -> list[dict[str, Any]]:
    """K of the oblique plane at a dozen poses of the arm, N/m: by ``1/Σ G_n²/K_n`` and measured.

    Measured is the push over the depth in the last tenth of a press by ideal motors.
    """
    poses = [(turn, *others) for turn in TURNS for others in LIFTS_AND_REACHES]
    rows = []
    for n, pose in enumerate(poses):
        progress("stiffness over the workspace", n / len(poses))
        home = f"device.home_rad={list(pose)}"
        space = load_device(find_scene(PLANE), (home,)).space
        assert space is not None
        inward = -np.array(space.shapes[0].normal)
        point = (np.array(space.home_m) + GAP_M * inward).tolist()
        sets = (
            *IDEAL, home, f"surface.0.point_m={point}", f"scene.duration_s={3 * REST_S}",
            "hand.slide_m=0", f"hand.amplitude_m={DEEP_M}",
        )  # fmt: skip
        device = load_device(find_scene(PLANE), sets)
        rows.append({
            "turn": pose[0], "lift": pose[1], "reach": pose[2],
            "formula": JointSimulation(device, "golden").predicted(),
            "measured": _rest(device, "golden")[1],
        })  # fmt: skip
    return rows


def collect(out: Path, progress: Callable[[str, float], None]) -> list[dict[str, Any]]:
    """Run them all on ``golden``; the rows, and the picture of the disc in ``out``."""
    plane, disc = find_scene(PLANE), find_scene(DISC)
    cases: list[tuple[str, list[Device]]] = []
    rng = np.random.default_rng(SEED)
    wrong = [wrong_motors(load_device(plane), rng) for _ in range(SETS)]
    still = (f"scene.duration_s={4 * REST_S}", "hand.slide_m=0")
    cases.append((
        f"held on an oblique plane, the worst of {SETS} sets of motor errors",
        [load_device(plane, (*sets, *still)) for sets in wrong],
    ))  # fmt: skip
    cases.append(
        ("slid along it by 20 mm at 2 Hz, the same", [load_device(plane, sets) for sets in wrong])
    )
    for rate_hz, late_s in RATES:
        for turns_hz in TURNS_HZ:
            sets = (
                f"device.update_hz={rate_hz:g}", f"device.delay_s={late_s:g}",
                f"hand.frequency_hz={turns_hz:g}",
                f"scene.duration_s={3 * REST_S + min(1.0 / turns_hz, LONGEST_S):.3g}",
            )  # fmt: skip
            device = load_device(disc, sets)
            assert device.space is not None
            radius = device.space.surface[0].radius_m or 0.0
            speed = 2.0 * math.pi * turns_hz * radius
            what = f"around a disc at {speed:.2g} m/s, planes at {rate_hz:g} Hz, "
            cases.append((what + f"{1e3 * late_s:g} ms late", [device]))
    rows = []
    for n, (what, devices) in enumerate(cases):
        progress("surfaces across motors", n / len(cases))
        rows.append(_row(what, [(one, measure_device(one, "golden")) for one in devices]))
    run_joint(load_device(disc), "golden", out / DISC)
    (out / PICTURE).write_bytes((out / DISC / TIP_PICTURE).read_bytes())
    return rows
