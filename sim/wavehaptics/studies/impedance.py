# SPDX-License-Identifier: Apache-2.0
"""What contact feels like over frequency: measured by a swept hand, against what was designed.

The rotor is moved inside a wall without edges by a hand on a spring, one frequency after the other,
and the mechanical impedance is the torque against the motion over the speed, both as means over
ticks and brought to the frequency by whole periods.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from wavehaptics.controller.rendered import rendered
from wavehaptics.controller.settings import settings
from wavehaptics.controller.shaper import NONE
from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.laws.reflection import Wish
from wavehaptics.scene import Scene
from wavehaptics.scene.tables.hand import Hand
from wavehaptics.trace.columns import Column, Word

USUAL_HZ = (1.0, 3.0, 10.0, 30.0, 60.0, 100.0, 160.0, 240.0, 340.0, 500.0)
"""Frequencies from next to DC to where hands stop feeling vibrations well."""

TORQUE_NM = 0.02
"""Amplitude of the torque that the hand is to meet, what a small motor holds for long."""

EVERYWHERE = (-1000.0, 1000.0)
_SETTLE_S = 0.15
_LEAST_S = 0.05
_LONGEST_SETTLE_S = 3.0
_FARTHEST_RAD = 1.0
_CHUNK_TICKS = 1 << 16


@dataclass(frozen=True)
class Impedance:
    """Impedances at the shaft over frequency, N·m·s/rad, complex, shape (frequencies,)."""

    hertz: np.ndarray
    measured: np.ndarray
    rendered: np.ndarray
    """Predicted of the controller's words, with every delay."""
    wished: np.ndarray | None
    """What ``[shaper]`` wishes for; None where it does not."""
    energy_out_j: float
    """Most net energy that the port ever had given out."""

    @property
    def designed(self) -> np.ndarray:
        """What the measurement has to meet."""
        return self.rendered if self.wished is None else self.wished

    @property
    def errors(self) -> np.ndarray:
        """Relative errors of what was measured."""
        errors: np.ndarray = np.abs(self.measured / self.designed - 1.0)
        return errors


def contact_everywhere(scene: Scene) -> Scene:
    """The scene with one wall that has no edges, made as its first is; no wall stays none."""
    if not scene.controller.walls:
        return scene
    controller = scene.controller.model_copy(update={"walls": (EVERYWHERE,)})
    shaper = scene.shaper and scene.shaper.model_copy(update={"walls": None})
    return scene.model_copy(update={"controller": controller, "shaper": shaper})


def measure(
    scene: Scene,
    hertz: tuple[float, ...] = USUAL_HZ,
    *,
    rtl: bool = False,
    torque_nm: float = TORQUE_NM,
    progress: Callable[[float], None] | None = None,
) -> Impedance:
    """Sweep a hand over ``hertz`` in contact, or in free space where the scene has no walls.

    The amplitude is the one that should meet a torque of ``torque_nm``, but 1 rad at most.
    """
    scene = contact_everywhere(scene)
    set_ = settings(scene)
    if not scene.controller.walls:
        set_ = replace(set_, eta_contact=set_.eta_free, shaper=NONE)
    motor = scene.motor
    places = np.array(hertz)
    predicted = rendered(set_, motor.k_t, motor.L_h, places)
    wish = set_.shaper.wish
    measured = np.zeros(len(hertz), dtype=complex)
    energy_out = -math.inf
    for n, frequency in enumerate(hertz):
        omega = 2.0 * math.pi * frequency
        load = omega * abs(predicted[n])
        amplitude = min(_FARTHEST_RAD, torque_nm / load)
        # Stiff beside what it moves, the rotor's own inertia among it.
        stiffness = 4.0 * max(load, motor.J_kgm2 * omega**2, 0.1)
        hand = Hand(
            path="sine", amplitude_rad=max(amplitude, 1e-6), frequency_hz=frequency,
            stiffness=stiffness, damping=2.0 * math.sqrt(stiffness * motor.J_kgm2),
        )  # fmt: skip
        simulation = SampledSimulation(scene.model_copy(update={"hand": hand}), rtl=rtl)
        measured[n], energy = _one(simulation, frequency, _settle_s(wish))
        energy_out = max(energy_out, energy)
        if progress is not None:
            progress((n + 1) / len(hertz))
    return Impedance(
        hertz=places,
        measured=measured,
        rendered=predicted,
        wished=None if wish is None else wish.felt(2j * math.pi * places),
        energy_out_j=energy_out,
    )


def _settle_s(wish: Wish | None) -> float:
    """Time after which what the start has set going is gone, s: a mass rings for long."""
    if wish is None or wish.damping == 0.0:
        return _SETTLE_S
    return min(_LONGEST_SETTLE_S, max(_SETTLE_S, 12.0 * wish.mass / wish.damping))


def _one(simulation: SampledSimulation, hertz: float, settle_s: float) -> tuple[complex, float]:
    """Impedance at one frequency, and the most net energy given out on the way, J."""
    tick_s = simulation.tick_s
    periods = max(1, math.ceil(_LEAST_S * hertz))
    settle = round(math.ceil(settle_s * hertz) / hertz / tick_s)
    ticks = settle + round(periods / hertz / tick_s)
    rows = np.zeros((min(ticks, _CHUNK_TICKS), len(Column)))
    words = np.zeros((len(rows), len(Word)), dtype=np.int64)
    torque = omega = 0j
    energy, most = 0.0, -math.inf
    done = 0
    while done < ticks:
        part = rows[: min(len(rows), ticks - done if done >= settle else settle - done)]
        simulation.advance(part, words[: len(part)])
        given = energy + np.cumsum(part[:, Column.ENERGY_OUT])
        energy, most = float(given[-1]), max(most, float(given.max()))
        if done >= settle:
            turns = np.exp(-2j * math.pi * hertz * part[:, Column.T])
            torque += part[:, Column.TORQUE] @ turns
            omega += part[:, Column.OMEGA] @ turns
        done += len(part)
    return -torque / omega, most
