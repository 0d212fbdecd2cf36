# SPDX-License-Identifier: Apache-2.0
"""A planar arm on the bench: the scope is the host that sends its surfaces, and shows its tip."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from wavehaptics.host.client import Client
from wavehaptics.host.names import HostError, places, readable
from wavehaptics.host.planes import MotorData, Planes, SingularError
from wavehaptics.laws.kinematics import put_tip_force
from wavehaptics.scene import Device

NEAR_M = 0.03
"""A surface further from the tip isn't sent: the line is slow."""

MARGIN_M = 0.03
"""What the page shows around base, tip and surfaces, m."""


class ArmBench:
    """The arm, motors and surfaces of a scene's ``device``, behind ``client``.

    :class:`HostError` where the device has no surfaces, or other motors.
    """

    def __init__(self, client: Client, device: Device) -> None:
        space = device.space
        assert space is not None
        data = []
        for name, scene in device.motors.items():
            if scene.encoder is None:
                raise HostError(f"{name} has no [encoder], and planes need its counts_per_rev")
            control = scene.controller
            data.append(
                MotorData(
                    control.k_t_hat or 0.0, control.l_hat or 0.0, scene.encoder.counts_per_rev
                )
            )
        self._space, self._client = space, client
        self._planes = Planes(
            client, data, space.arm, speed=space.device.wall_speed_m_per_s,
            energy=space.device.wall_energy_j,
        )  # fmt: skip
        self._k_t = np.array([motor.k_t for motor in data])
        self._cell = 2.0 * np.pi / np.array([motor.counts_per_rev for motor in data])
        names = ("position", "current")
        found = [places(name, client.shape, n)[0] for name in names for n in range(len(data))]
        self._places = [*map(readable, found), readable(places("surfaces_acting", client.shape)[0])]

    def shown(self) -> dict[str, Any]:
        """What the page draws, in m: base, surfaces and the part of the plane around them."""
        arm, home = self._space.arm, np.zeros(len(self._k_t))
        shapes, corners = [], [np.zeros(2), arm.tip(home)[:2], arm.elbow(home)]
        for one in self._space.shapes:
            point = one.point[:2]
            half = np.array([one.radius] * 2) if one.size is None else 0.5 * one.size[:2]
            corners += [point - half, point + half]
            shapes.append({
                "kind": one.kind, "point": point.tolist(), "normal": one.normal[:2].tolist(),
                "radius": one.radius, "size": (2 * half).tolist(),
            })  # fmt: skip
        low, high = np.min(corners, axis=0) - MARGIN_M, np.max(corners, axis=0) + MARGIN_M
        return {"shapes": shapes, "view": [*low.tolist(), *high.tolist()]}

    def renew(self) -> dict[str, float]:
        """Read the arm, send the planes near its tip, and tell both: columns of a row, m and N."""
        values = [
            place.value(raw)
            for place, raw in zip(self._places, self._client.read(self._places), strict=True)
        ]
        motors, arm = len(self._k_t), self._space.arm
        counts = np.array(values[:motors])
        q = (counts + 0.5) * self._cell
        tip, elbow, force = arm.tip(q), arm.elbow(q), np.zeros(3)
        put_tip_force(arm.jacobian(q), self._k_t * np.array(values[motors:-1]), force)
        near = [
            (shape, one) for shape, one in zip(self._space.shapes, self._space.solids, strict=True)
            if shape.depth(tip[None, :])[0][0] > -NEAR_M
        ]  # fmt: skip
        # Where the arm is stretched along a normal, what was sent before stays.
        with suppress(SingularError):
            self._planes.set_shapes(
                [shape for shape, _ in near], [one.stiffness for _, one in near],
                [one.friction_loss for _, one in near], [one.damping for _, one in near],
                counts, check=False,
            )  # fmt: skip
        return {
            "tip_x": tip[0], "tip_y": tip[1], "elbow_x": elbow[0], "elbow_y": elbow[1],
            "force_x": force[0], "force_y": force[1], "acting": values[-1],
        }  # fmt: skip
