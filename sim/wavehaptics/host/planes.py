# SPDX-License-Identifier: Apache-2.0
"""Surfaces across the motors of a device, from a computer: planes go there, and where the tip is.

A plane in joint space is ``normal·q >= offset`` in the motors' angles q, 0 where the encoders count
0. With an arm, planes are those of solids about the tip: ``G = Jᵀn`` where the encoders now are
(:mod:`wavehaptics.controller.planes`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wavehaptics.controller.planes import (
    NOT_WHOLE,
    Host,
    PortEstimate,
    as_registers,
    as_words,
    as_writes,
    refused_place,
)
from wavehaptics.host.capture import tick_s
from wavehaptics.host.client import Client
from wavehaptics.host.names import HostError, places, readable, settable
from wavehaptics.laws import closed_forms
from wavehaptics.laws.kinematics import Arm, matrix_arm, put_tip_force
from wavehaptics.laws.shapes import Shape
from wavehaptics.words.table import WORDS

_STATE = ("surfaces", "surfaces_acting", "surfaces_pending", "surfaces_refused", "surfaces_stamp")
_MIDDLE = 0.5
"""Of a count, which is added for the angle."""


@dataclass(frozen=True)
class MotorData:
    """What planes need of a motor: k̂_T in N·m/A, L̂ in H, and the encoder's counts, four a line."""

    k_t: float
    inductance: float
    counts_per_rev: float


@dataclass(frozen=True)
class JointPlane:
    """``normal·q >= offset``: ``normal`` of each motor, ``offset`` in the unit of normal times rad.

    Only its direction matters. ``stiffness`` along it, in N·m/rad, is that of the motors without
    it; ``loss`` from 0 to 1 is the part of the waves across it that is lost in each period.
    """

    normal: Sequence[float]
    offset: float
    stiffness: float | None = None
    loss: float = 0.0


@dataclass(frozen=True)
class SurfacesState:
    """What a device says of its surfaces."""

    surfaces: int
    """That it can have; 0: none."""
    acting: int
    """In contact."""
    pending: bool
    """A frame is accepted, and applies with the next control period."""
    refused: str
    """What the last frame was refused for; "" if it was accepted."""
    stamp: int
    """Of the last accepted frame."""


class SingularError(HostError):
    """No motor moves the tip along a surface's normal where the arm is."""


class Planes:
    """Planes of the device behind ``client``, whose motors are those of ``motors`` in order.

    ``arm`` is what they move, with its angles 0 where the encoders count 0; without it there are
    planes in joint space alone. ``speed`` is the most with which a surface moves, in m/s, in joint
    space in rad/s, and ``energy`` the most in J that moving surfaces give out beyond what they
    took: the device's setting ``surface_budget``. :class:`HostError` where the device has no
    surfaces or other motors.
    """

    def __init__(
        self, client: Client, motors: Sequence[MotorData], arm: Arm | None = None,
        *, speed: float = 0.1, energy: float = 1e-3,
    ) -> None:  # fmt: skip
        self._client, self._arm = client, arm
        count = client.shape.motors
        found = surfaces_state(client)
        self._most, self._stamp = found.surfaces, found.stamp
        if not self._most:
            raise HostError(
                f"{client.port}: the device has no surfaces; take a bitstream with SURFACES, or a "
                "virtual board with --surfaces"
            )
        if len(motors) != count or (arm is not None and arm.motors != count):
            raise HostError(
                f"{client.port}: the device has {count} motors, and the data are of {len(motors)}"
                f"{'' if arm is None else f', the arm of {arm.motors}'}; give as many"
            )
        for n, motor in enumerate(motors):
            if not (motor.k_t > 0 and motor.inductance >= 0 and motor.counts_per_rev > 0):
                raise HostError(
                    f"motor {n}: k_t = {motor.k_t:g}, inductance = {motor.inductance:g}, "
                    f"counts_per_rev = {motor.counts_per_rev:g}; they have to be above 0"
                )
        self._cell = np.array([2.0 * math.pi / motor.counts_per_rev for motor in motors])
        self._k_t = np.array([motor.k_t for motor in motors])
        self._tick_s, extra_ticks = tick_s(client), int(self._value("extra_ticks"))
        ports = []
        for n, motor in enumerate(motors):
            root, a = self._value("root", n), self._value("a", n)
            if root <= 0 or a <= 0:
                raise HostError(f"motor {n}: root or a is 0; set the motor's registers first")
            r_hat = 0.5 * root**2
            tau = closed_forms.tau(self._tick_s, a, extra_ticks)
            ports.append(PortEstimate(
                motor.k_t, r_hat, closed_forms.l_eff(motor.inductance, r_hat, tau),
                float(self._cell[n]), tau,
            ))  # fmt: skip
        self._ports, self._speed = ports, speed
        budget = settable(places("surface_budget", client.shape)[0])
        client.write([(budget, budget.raw(energy / self._tick_s))])

    def _value(self, name: str, motor: int = 0) -> float:
        (place,) = places(name, self._client.shape, motor)
        return place.value(self._client.read([readable(place)])[0])

    def _each(self, name: str) -> np.ndarray:
        return np.array([self._value(name, n) for n in range(len(self._ports))])

    # ---- What the device says.

    @property
    def state(self) -> SurfacesState:
        """What it says of its surfaces."""
        return surfaces_state(self._client)

    def counts(self) -> np.ndarray:
        """Encoder counts of the motors: float64 (motors,)."""
        return self._each("position")

    def angles(self) -> np.ndarray:
        """Angles of the motors in rad, in the middle of the count: float64 (motors,)."""
        angles: np.ndarray = (self.counts() + _MIDDLE) * self._cell
        return angles

    def tip(self) -> np.ndarray:
        """Place of the tip in m: float64 (3,)."""
        return self._needs_arm().tip(self.angles())

    def tip_force(self) -> np.ndarray:
        """Force of the motors on the hand at the tip in N, of their last currents: float64 (3,)."""
        arm = self._needs_arm()
        force = np.zeros(3)
        put_tip_force(arm.jacobian(self.angles()), self._k_t * self._each("current"), force)
        return force

    def _needs_arm(self) -> Arm:
        if self._arm is None:
            raise HostError("there is no arm, so no tip; give arm, or a scene with a [device]")
        return self._arm

    # ---- What it is told.

    def set_joint(self, planes: Sequence[JointPlane], **how: int | bool) -> int:
        """Give planes in joint space, all there are from now on; as :meth:`set_shapes`."""
        motors = len(self._ports)
        shapes = []
        for n, plane in enumerate(planes):
            normal = np.zeros(3)
            if len(plane.normal) != motors:
                raise HostError(
                    f"plane {n}: its normal has {len(plane.normal)} numbers; give {motors}, one of "
                    "each motor"
                )
            normal[:motors] = plane.normal
            length = float(np.linalg.norm(normal))
            if not (math.isfinite(length) and length > 0 and math.isfinite(plane.offset)):
                raise HostError(
                    f"plane {n}: its normal is {list(plane.normal)}, its offset {plane.offset:g}; "
                    "give finite numbers, not all 0"
                )
            shapes.append(Shape("plane", plane.offset / length**2 * normal, -normal / length))
        hard, lost = [plane.stiffness for plane in planes], [plane.loss for plane in planes]
        arm = matrix_arm(np.eye(3)[:, :motors].tolist())
        return self._give(arm, shapes, hard, lost, None, (), **how)

    def set_shapes(
        self, shapes: Sequence[Shape], stiffness: Sequence[float | None] | None = None,
        loss: Sequence[float] | None = None, damping: Sequence[float] | None = None,
        counts: np.ndarray | None = None, **how: int | bool,
    ) -> int:  # fmt: skip
        """Give the planes of solids about the tip, all there are from now on. Returns the stamp.

        The planes are those where the encoders are, at ``counts`` (motors,) or as they are read
        now. ``stiffness`` in N/m of each, None for the largest; ``loss`` from 0 to 1; ``damping``
        in N·s/m beside a stiffness, 0 for that of the motors. The device applies them together.
        With ``check``, the default, :class:`HostError` where it refuses them, and says which.
        ``stamp`` of 16 bits can be read back; by default it counts.
        """
        return self._give(
            self._needs_arm(), shapes, stiffness or [None] * len(shapes),
            loss or [0.0] * len(shapes), counts, damping or (), **how,
        )  # fmt: skip

    def _give(
        self, arm: Arm, shapes: Sequence[Shape], stiffness: Sequence[float | None],
        loss: Sequence[float], counts: np.ndarray | None, damping: Sequence[float],
        stamp: int | bool | None = None, check: int | bool = True,
    ) -> int:  # fmt: skip
        if len(shapes) > self._most:
            raise HostError(
                f"{len(shapes)} surfaces, and the device can have {self._most}; give the nearest"
            )
        if len(stiffness) != len(shapes) or len(loss) != len(shapes):
            raise HostError(f"stiffness and loss have to be of each of the {len(shapes)} surfaces")
        for n, (hard, lost) in enumerate(zip(stiffness, loss, strict=True)):
            if not (0.0 <= lost <= 1.0 and (hard is None or hard > 0.0)):
                raise HostError(
                    f"surface {n}: stiffness = {hard}, loss = {lost:g}; the one has to be above 0, "
                    "the other from 0 to 1"
                )
        if damping and len(damping) != len(shapes):
            raise HostError(f"damping has to be of each of the {len(shapes)} surfaces")
        for n, damper in enumerate(damping):
            if not damper >= 0.0 or (damper and stiffness[n] is None):
                raise HostError(
                    f"surface {n}: damping = {damper:g}; it has to be 0, or above that with a "
                    "stiffness"
                )
        if counts is None:
            counts = self.counts()
        host = Host(arm, shapes, self._ports, self._tick_s, stiffness, loss, self._speed, damping)
        update = host.look(counts, _MIDDLE)
        if update.singular:
            raise SingularError(
                f"surface {update.singular[0]}: no motor moves the tip along its normal there; "
                "leave it out, or move the arm"
            )
        stamp = (self._stamp + 1) & 0xFFFF if stamp is None else int(stamp)
        words = as_words(update)
        set_planes(self._client, as_registers(*words, count=self._most), stamp, check=bool(check))
        self._stamp = stamp
        return stamp


def surfaces_state(client: Client) -> SurfacesState:
    """What the device behind ``client`` says of its surfaces."""
    if not all(client.shape.has(WORDS[name]) for name in _STATE):
        return SurfacesState(0, 0, False, "", 0)  # of a brushless motor
    found = [place for name in _STATE for place in places(name, client.shape)]
    have, acting, pending, refused, stamp = client.read(map(readable, found))
    return SurfacesState(have, acting, bool(pending), refused_place(refused), stamp)


def set_planes(
    client: Client, registers: Sequence[tuple[int, int]], stamp: int, *, check: bool = True
) -> None:
    """Write a frame of raw words, those of ``as_registers``; the device applies it as a whole.

    ``stamp`` should differ from that of the frame before. With ``check``, :class:`HostError` where
    the device refuses the frame, with what it refuses.
    """
    if not 0 <= stamp <= 0xFFFF:
        raise HostError(f"stamp = {stamp}: it has 16 bits; give 0...65535")
    for first, raws in as_writes(registers, stamp):
        client.write_raw(first, raws, "planes")
    if not check:
        return
    # The end of a frame that was accepted may have come once more, as its answer was lost.
    state = surfaces_state(client)
    if state.stamp != stamp or (state.refused and state.refused != NOT_WHOLE):
        raise HostError(
            f"planes: the device refuses {state.refused or 'them, or somebody else writes them'}; "
            "what it had before is in force"
        )
