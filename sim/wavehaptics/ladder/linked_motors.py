# SPDX-License-Identifier: Apache-2.0
"""Several equal motors at one ``rtl/wh_linked_device.v``, each with a hand of its own."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from wavehaptics.controller.ports import Ports, hold_ticks
from wavehaptics.ladder import pins_loop
from wavehaptics.ladder.linked_pins import LinkedPins
from wavehaptics.ladder.pins import STEPS
from wavehaptics.motor.imperfections import real_parts
from wavehaptics.motor.plant import X
from wavehaptics.scene import Scene


class LinkedMotors(LinkedPins):
    """A scene's motor ``motors`` times, and :class:`LinkedPins` in all else; nothing has a trace.

    ``led`` is the motor whose hand :meth:`lead_hand` leads; the others' follow the scene. Each has
    a supply of its own. ``SceneError`` for what is simulated for one motor alone, and where the
    tick is too short for so many.
    """

    def __init__(self, scene: Scene, motors: int, *, led: int = 0, arm: bool = True) -> None:
        alone = {
            "thermal": scene.thermal is not None,
            "drive.bus_measured": scene.drive is not None and scene.drive.bus_measured,
        }
        for key in (key for key, there in alone.items() if there):
            raise scene.refusal(
                f"{key} is simulated for one motor, and these are {motors}; leave it out", key
            )
        self.motors = motors
        super().__init__(scene, arm=arm)
        self._each = tuple(self._another(scene) for _ in range(motors))
        # Places of the hand are those of the motor that is led.
        self._state, _, _, self._load, *_ = self._each[led]

    def _ports_of(self, scene: Scene, most_samples: int) -> Ports:
        ports = super()._ports_of(scene, most_samples)
        held = hold_ticks(scene, ports, self.motors)
        return replace(ports, words={**ports.words, "hold_ticks": held})

    def _parameters(self) -> dict[str, int]:
        return {**super()._parameters(), "N": self.motors}

    def _another(self, scene: Scene) -> tuple:
        """What the loop keeps of a motor, as it is at the beginning."""
        steps_s = [n * self._dt for n in range(STEPS + 1)]
        plant, cell_rad = self.winding.plant, self.settings.cell_rad
        return (
            self._state.copy(), self._kept.copy(), self._sums.copy(), self._load.copy(),
            self._bits.copy(), real_parts(scene, plant, cell_rad, steps_s, switching=True),
        )  # fmt: skip

    def _function(self, name: str) -> Any:
        return super()._function("clock_all" if name == "clock" else name)

    @property
    def clock_cycles(self) -> int:
        return int(self._each[0][1][pins_loop.NOW])

    def place_rad(self, motor: int) -> float:
        """Where a motor's rotor is, rad."""
        return float(self._each[motor][0][X])

    def elapse(self, ticks: int) -> None:
        pins_loop.pass_clocks(
            ticks * self.timing.tick_clocks, self._each, self._tables, self._ints, self._floats,
            self._sensor, self._rng,
        )  # fmt: skip
