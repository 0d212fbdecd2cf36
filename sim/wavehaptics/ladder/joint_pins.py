# SPDX-License-Identifier: Apache-2.0
"""`pins` of a device: its motors are ports of one ``rtl/wh_ports.v``, with surfaces across them.

The host writes its frames into the RTL word by word, and reads the positions that the RTL has. A
hand at the tip pulls on all rotors; its torques are constant over a step, and of its middle.
"""

from __future__ import annotations

import ctypes

import numpy as np

from wavehaptics.controller import surfaces
from wavehaptics.controller.planes import Planes, as_registers, as_words
from wavehaptics.controller.turns import turns_ports
from wavehaptics.ladder import pins_loop
from wavehaptics.ladder.joint_host import JointHost, JointLoop
from wavehaptics.ladder.pins import PinsSimulation, pass_ticks
from wavehaptics.ladder.turns_pins import TurnsSimulation
from wavehaptics.laws.kinematics import put_jacobian, put_tip, put_tip_force
from wavehaptics.motor.plant import Plant
from wavehaptics.motor.tip_hand import hand_room, hand_substeps, hand_words, put_hand
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Device
from wavehaptics.trace.columns import Column
from wavehaptics.trace.tip import put_tip_row


@compiled()
def _put_tips(
    rows: np.ndarray, tips: np.ndarray, tick: float, arm: np.ndarray, hand: np.ndarray,
    active: np.ndarray, q: np.ndarray, jacobian: np.ndarray, room: np.ndarray, torque: np.ndarray,
) -> None:  # fmt: skip
    """The tip's rows of ticks whose ``rows`` (motors, ticks, Column) are made."""
    for n in range(tips.shape[0]):
        for motor in range(q.shape[0]):
            q[motor] = rows[motor, n, Column.X]
            torque[motor] = rows[motor, n, Column.TORQUE]
        time = rows[0, n, Column.T]
        put_tip(arm, q, room[0])
        put_jacobian(arm, q, jacobian)
        put_tip_force(jacobian, torque, room[3])
        put_hand(hand, time, room[1], room[2])
        put_tip_row(tips[n], time - 0.5 * tick, tick, room[0], room[0], room[1], room[3], active[n])


def host_of_pins(device: Device) -> JointHost:
    """The host of a device whose motors are ports of the whole RTL; no RTL is built."""
    space = device.space
    assert space is not None
    ports = turns_ports(device.scenes, len(space.solids))
    return JointHost(space, device.scenes, [one.settings for one in ports])


class JointPins(JointLoop):
    """The motors of ``device`` at one controller, with a hand at their tip."""

    def __init__(self, device: Device) -> None:
        space, motors = device.space, len(device.scenes)
        assert space is not None
        laid = host_of_pins(device)
        self._turns = TurnsSimulation(device.scenes, len(space.solids), laid.budget)
        self.motors: list[PinsSimulation] = [*self._turns.motors]
        super().__init__(space, device.scenes, [motor.settings for motor in self.motors])
        plants = [Plant.of_scene(scene) for scene in device.scenes]
        self._tick_clocks = self.motors[0].timing.tick_clocks
        parts = hand_substeps(plants, space, self.tick_s)
        self._hand_clocks = np.array([0, max(1, self._tick_clocks // parts)])
        self._room = hand_room(motors)
        self._arm = space.arm.geometry, hand_words(space)
        self._events = self.updates()
        self._declare()
        self._commit(self._look())  # the host knows where the arm is before the run

    @property
    def clock_cycles(self) -> int:
        return self.motors[0].clock_cycles

    def _run(self, rows: np.ndarray, words: np.ndarray, tips: np.ndarray) -> None:
        active = np.zeros(len(tips), dtype=np.int64)
        tip = (*self._arm, self._hand_clocks, active, *self._room)
        pass_ticks(list(rows), list(words), self._turns._kept, self.motors, tip=tip)
        q, _, jacobian, room, torque = self._room
        _put_tips(rows, tips, self.tick_s, *self._arm, active, q, jacobian, room, torque)

    def _look(self) -> Planes:
        """As the RTL has its positions, which begin at 0 where the rotors start."""
        return self.host.look(
            np.array([motor._buffer[pins_loop.POSITION_WORD] for motor in self.motors])
        )

    def _declare(self) -> None:
        library = self._turns._library
        self._frame, self._refused = library.wh_ports_frame, library.wh_ports_refused
        self._frame.argtypes = [
            ctypes.c_void_p, ctypes.POINTER(ctypes.c_uint32), ctypes.c_int64
        ]  # fmt: skip
        self._frame.restype = None
        self._refused.argtypes, self._refused.restype = [ctypes.c_void_p], ctypes.c_int64

    def _commit(self, update: Planes) -> None:
        if self._refused(self._turns._model):
            raise RuntimeError("the controller's RTL refused a frame of surfaces")
        self.singular_updates += len(update.singular)
        planes, vectors, most = as_words(update)
        if not self.space.surface or not surfaces.accepts(planes, vectors):
            return
        frame = as_registers(planes, vectors, most, len(self.space.solids))
        flat = [word & 0xFFFFFFFF for pair in frame for word in pair]
        self._frame(self._turns._model, (ctypes.c_uint32 * len(flat))(*flat), len(frame))
