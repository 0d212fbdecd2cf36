# SPDX-License-Identifier: Apache-2.0
"""Several equal motors at one ``rtl/wh_linked_device.v``: each with its own hand, or an arm."""

from __future__ import annotations

from copy import copy

import numpy as np

from wavehaptics.controller.ports import Ports, controller_ports
from wavehaptics.ladder import pins_loop
from wavehaptics.ladder.linked_pins import LinkedPins
from wavehaptics.ladder.pins import pass_clocks
from wavehaptics.motor.plant import TIME, Plant, X
from wavehaptics.motor.tip_hand import hand_room, hand_substeps, hand_words, lead
from wavehaptics.scene import Device, Scene


class LinkedMotors(LinkedPins):
    """A scene's motor ``motors`` times, and :class:`LinkedPins` in all else; nothing has a trace.

    ``led`` is the motor whose hand :meth:`lead_hand` leads; the others' follow the scene. Each has
    a supply of its own. With ``surfaces`` the device can have so many across its motors, and no
    arm connects these. ``SceneError`` for what is simulated for one motor alone, and where the tick
    is too short for so many.
    """

    def __init__(
        self, scene: Scene, motors: int, *, led: int = 0, arm: bool = True, surfaces: int = 0
    ) -> None:
        if scene.thermal is not None:
            raise scene.refusal(
                f"thermal is simulated for one motor, and these are {motors}; leave it out",
                "thermal",
            )
        self.motors = self.turns = motors
        self._surfaces = surfaces
        super().__init__(scene, arm=arm)
        self._each = [copy(self) for _ in range(motors)]
        self._all = np.stack([self._kept] * motors)
        for motor, kept in zip(self._each, self._all, strict=True):
            motor._model, motor._kept = None, kept  # the controller is not its own
            motor._state, motor._sums = self._state.copy(), self._sums.copy()
            motor._load, motor._bits = self._load.copy(), self._bits.copy()
            motor._real = self._imperfections(scene)
        # Places of the hand are those of the motor that is led.
        self._state, self._load = self._each[led]._state, self._each[led]._load

    def _parameters(self) -> dict[str, int]:
        more = {"SURFACES": self._surfaces} if self._surfaces else {}
        return {**super()._parameters(), **more}

    def _ports_of(self, scene: Scene, most_samples: int) -> Ports:
        if self._surfaces and scene.shaper is not None:
            raise scene.refusal(
                "[shaper] is not for surfaces across motors; leave it out", "shaper"
            )
        return controller_ports(
            scene, most_samples=most_samples, turns=self.motors, surfaces=self._surfaces
        )

    @property
    def clock_cycles(self) -> int:
        return int(self._all[0, pins_loop.NOW])

    def place_rad(self, motor: int) -> float:
        """Where a motor's rotor is, rad."""
        return float(self._each[motor]._state[X])

    def elapse(self, ticks: int) -> None:
        pass_clocks(ticks * self.timing.tick_clocks, self._all, self._each)


class LinkedArm(LinkedMotors):
    """The motors of ``device`` behind one line, with its arm, a hand at its tip and its surfaces.

    ``SceneError`` where the motors are not alike, or the arm isn't planar.
    """

    def __init__(self, device: Device, *, arm: bool = True) -> None:
        space, (first, *others) = device.space, device.scenes
        assert space is not None
        if space.device.kinematics != "planar":
            raise space.refusal(
                'a virtual board has kinematics = "planar" alone; `run` has all arms',
                "device.kinematics",
            )
        if not space.surface or space.hand is None:
            raise space.refusal(
                "a virtual board of a [device] has surfaces and a hand; write a [[surface]] and "
                "[hand]", "device",
            )  # fmt: skip
        if any(one.model_dump() != first.model_dump() for one in others):
            raise space.refusal(
                "the motors of a virtual board are alike; leave what differs out of [[motors]]",
                "device",
            )
        super().__init__(first, len(device.scenes), arm=arm, surfaces=len(space.solids))
        parts = hand_substeps([Plant.of_scene(one) for one in device.scenes], space, self.tick_s)
        self._hand = hand_words(space)
        self._tip = (
            space.arm.geometry, self._hand,
            np.array([0, max(1, self.timing.tick_clocks // parts)]), np.zeros(0, dtype=np.int64),
            *hand_room(len(device.scenes)),
        )  # fmt: skip

    def lead_hand(self, *speed: float) -> None:
        """From now on the hand goes at this speed, x and y in m/s, and its path is forgotten."""
        lead(self._hand, float(self._each[0]._state[TIME]), np.array([*speed, 0.0]))

    def elapse(self, ticks: int) -> None:
        pass_clocks(ticks * self.timing.tick_clocks, self._all, self._each, self._tip)
