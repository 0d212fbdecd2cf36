# SPDX-License-Identifier: Apache-2.0
"""The hand at the tip of a device: a spring and damper to a point that moves in space.

    F = −K (p − h(t)) − B (dp/dt − dh/dt),   torques Jᵀ F on the rotors.

K and B are alike in all directions. What the rotors feel of it depends on where the arm is, so the
hand is no part of a motor's linear system, as that of a single motor is: its torque is constant
over a step, and taken in the step's middle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wavehaptics.laws.kinematics import put_jacobian, put_tip
from wavehaptics.motor.hand import PRESS_RAMP_S
from wavehaptics.motor.plant import PART_OF_CABLE, Plant
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Space
from wavehaptics.scene.tables.surface import unit

NONE, PRESS, TAPS, SLIDE, CIRCLE, LED = range(6)
_PATHS = {"press": PRESS, "taps": TAPS, "slide": SLIDE, "circle": CIRCLE}

PATH, K, B, AMPLITUDE, OMEGA, SPAN, HOME, ALONG, ACROSS = 0, 1, 2, 3, 4, 5, 6, 9, 12
"""Places in a hand's words: path, N/m, N·s/m, m, rad/s, how far it slides or the circle's radius in
m, the tip's place at the start, and two directions. A hand that is LED was at
HOME at the time SPAN, and its speed is ALONG."""
_SIZE = 15

SLIDE_START_S = 2.0 * PRESS_RAMP_S
"""When ``slide`` and ``circle`` begin to go across."""


def hand_words(space: Space) -> np.ndarray:
    """The hand of a device as :func:`put_hand_torque` takes it: float64 (15,)."""
    words = np.zeros(_SIZE)
    hand = space.hand
    if hand is None:
        return words
    home = np.array(space.home_m)
    words[PATH], words[K], words[B] = (
        _PATHS[hand.path], hand.stiffness_n_per_m, hand.damping_n_s_per_m,
    )  # fmt: skip
    words[AMPLITUDE] = hand.amplitude_m
    words[OMEGA] = 2.0 * math.pi * (hand.frequency_hz or 0.0)
    words[HOME : HOME + 3] = home
    if hand.direction is not None:
        words[ALONG : ALONG + 3] = unit(hand.direction)
    if hand.across is not None:
        words[ACROSS : ACROSS + 3] = unit(hand.across)
    words[SPAN] = hand.slide_m or 0.0
    if hand.center_m is not None:
        inward = np.array(hand.center_m) - home
        words[SPAN] = np.linalg.norm(inward)
        inward /= words[SPAN]
        words[ALONG : ALONG + 3] = inward
        across = words[ACROSS : ACROSS + 3]
        across -= inward * (inward @ across)
        across /= np.linalg.norm(across)
    return words


def lead(words: np.ndarray, time_s: float, speed: np.ndarray) -> None:
    """From ``time_s`` on the hand of ``words`` goes with ``speed`` (3,) in m/s, and its path is
    forgotten: it begins at the tip's home, or where it was led to."""
    home, along = slice(HOME, HOME + 3), slice(ALONG, ALONG + 3)
    if words[PATH] == LED:
        words[home] += words[along] * (time_s - words[SPAN])
    words[PATH], words[SPAN], words[along] = LED, time_s, speed


def hand_substeps(plants: Sequence[Plant], space: Space, step_s: float) -> int:
    """Into how many equal parts a step of ``step_s`` is cut for the hand's spring and damper."""
    if space.hand is None:
        return 1
    longest = step_s
    jacobian = space.arm.jacobian(np.zeros(len(plants)))
    for n, plant in enumerate(plants):
        square = float(jacobian[:, n] @ jacobian[:, n])
        spring = space.hand.stiffness_n_per_m * square
        damper = space.hand.damping_n_s_per_m * square
        if spring:
            longest = min(longest, PART_OF_CABLE * math.sqrt(plant.inertia / spring))
        if damper:
            longest = min(longest, PART_OF_CABLE * plant.inertia / damper)
    return math.ceil(step_s / longest - 1e-9)


@compiled()
def put_hand(words: np.ndarray, time: float, place: np.ndarray, speed: np.ndarray) -> None:
    """Where the hand is at ``time`` s and how fast, into float64 (3,) and (3,), m and m/s."""
    if words[PATH] == LED:
        for row in range(3):
            speed[row] = words[ALONG + row]
            place[row] = words[HOME + row] + speed[row] * (time - words[SPAN])
        return
    path, amplitude, omega, span = words[PATH], words[AMPLITUDE], words[OMEGA], words[SPAN]
    part = min(time / PRESS_RAMP_S, 1.0)
    along, along_speed = amplitude * part, amplitude / PRESS_RAMP_S if part < 1.0 else 0.0
    across, across_speed = 0.0, 0.0
    since = max(time - SLIDE_START_S, 0.0)
    if path == TAPS:
        along = amplitude * (1.0 - math.cos(omega * time))
        along_speed = amplitude * omega * math.sin(omega * time)
    elif path == SLIDE:
        across = 0.5 * span * (1.0 - math.cos(omega * since))
        across_speed = 0.5 * span * omega * math.sin(omega * since)
    elif path == CIRCLE:
        starts = min(since / PRESS_RAMP_S, 1.0)
        turned = omega * (since - PRESS_RAMP_S * starts + 0.5 * PRESS_RAMP_S * starts * starts)
        rate, radius = omega * starts, span - along
        sine, cosine = math.sin(turned), math.cos(turned)
        across, across_speed = radius * sine, radius * rate * cosine - along_speed * sine
        along_speed = along_speed * cosine + radius * rate * sine
        along = span - radius * cosine
    for row in range(3):
        place[row] = words[HOME + row] + words[ALONG + row] * along + words[ACROSS + row] * across
        speed[row] = words[ALONG + row] * along_speed + words[ACROSS + row] * across_speed


def hand_room(motors: int, places: int = 4) -> tuple[np.ndarray, ...]:
    """What :func:`put_hand_torque` works in: q and omega, jacobian, room, and torque, all zeros.

    A caller may have more rows of ``room`` than it needs: ``places``.
    """
    return (
        np.zeros(motors), np.zeros(motors), np.zeros((3, motors)), np.zeros((places, 3)),
        np.zeros(motors),
    )  # fmt: skip


@compiled()
def put_hand_torque(
    geometry: np.ndarray, words: np.ndarray, time: float, q: np.ndarray, omega: np.ndarray,
    jacobian: np.ndarray, room: np.ndarray, torque: np.ndarray,
) -> None:  # fmt: skip
    """The hand's torques on the rotors at ``q`` rad and ``omega`` rad/s into ``torque`` (motors,).

    N·m. J is left in ``jacobian`` (3, motors), the tip's place, the hand's and its speed in the
    first three rows of ``room`` float64 (4, 3).
    """
    put_tip(geometry, q, room[0])
    put_jacobian(geometry, q, jacobian)
    for n in range(q.shape[0]):
        torque[n] = 0.0
    if words[PATH] == NONE:
        return
    put_hand(words, time, room[1], room[2])
    for row in range(3):
        speed = 0.0
        for n in range(q.shape[0]):
            speed += jacobian[row, n] * omega[n]
        force = -words[K] * (room[0, row] - room[1, row]) - words[B] * (speed - room[2, row])
        for n in range(q.shape[0]):
            torque[n] += jacobian[row, n] * force
