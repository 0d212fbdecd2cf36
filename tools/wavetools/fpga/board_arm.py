# SPDX-License-Identifier: Apache-2.0
"""A whole board with a motor at each port, and an arm with a hand between them.

It is begun with one motor for all ports (:mod:`wavetools.fpga.board_simulation`), over its line.
To an arm a computer writes surfaces, and renews the arming.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy

import numpy as np
from wavehaptics.controller.planes import as_registers, as_words, as_writes
from wavehaptics.ladder import pins_loop
from wavehaptics.ladder.joint_host import JointHost
from wavehaptics.ladder.linked_pins import ANSWER_BYTES, write_frame
from wavehaptics.ladder.pins import pass_ticks
from wavehaptics.motor.tip_hand import HOME, hand_room, hand_words
from wavehaptics.scene import Scene, Space
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words.modbus import BAUDS
from wavehaptics.words.table import WORDS

from wavetools.fpga.board_simulation import Build, Report, on_board

ARMED_S = 0.1
"""How often an arm's arming is renewed, s; the board ends it after 200 ms."""

HAND_PARTS = 2
"""Parts of a tick, in each of which the hand's torque is constant."""


class MotorsOnBoard:
    """The board of ``built``, armed over its line, with a motor and hand of ``scene`` at each port.

    Angles are those of the scene.
    """

    def __init__(self, built: Build, scene: Scene, motors: int) -> None:
        self._board = first = on_board(built, scene, by_line=True)
        self.tick_s, self.settings = first.tick_s, first.settings
        self._kept = np.stack([first._kept] * motors)
        self._each = [copy(first) for _ in range(motors)]
        for motor, kept in zip(self._each, self._kept, strict=True):
            motor._model, motor._kept = None, kept  # the board is not its own
            motor._state, motor._sums = first._state.copy(), first._sums.copy()
            motor._pending, motor._buffer = first._pending.copy(), first._buffer.copy()
            motor._bits, motor._real = first._bits.copy(), first._imperfections(scene)
        first.part()

    def advance(self, seconds: float) -> np.ndarray:
        """Rows (motors, ticks, Column) of the next ``seconds``."""
        return self._pass(seconds)

    def _pass(self, seconds: float) -> np.ndarray:
        ticks = round(seconds / self.tick_s)
        rows = np.zeros((len(self._each), ticks, len(Column)))
        words = np.zeros((len(self._each), ticks, len(Word)), dtype=np.int64)
        pass_ticks(list(rows), list(words), self._kept, self._each, tip=self._tip(ticks))
        return rows

    def _tip(self, ticks: int) -> tuple | None:
        """What :func:`pass_ticks` has of a hand at the motors' tip for so many ticks."""
        del ticks
        return None

    def write(self, first: int, raws: Sequence[int]) -> bytes:
        """The board's answer to a write over its line; the motors go on meanwhile."""
        question = write_frame(first, list(raws))
        self.received()
        self._board.send(question)
        self._pass((len(question) + ANSWER_BYTES + 4) * 10 / BAUDS[0])
        return self.received()

    def received(self) -> bytes:
        """Bytes that came over the line since the last time."""
        return self._board.received()

    def report(self) -> Report:
        """What the pins have shown so far."""
        return self._board.report()


class ArmOnBoard(MotorsOnBoard):
    """The motors of ``space``, whose Jacobian is constant, each that of ``scene``, with its hand.

    Angles are 0 where the rotors are at reset, as are the board's counts. The arming is renewed.
    """

    def __init__(self, built: Build, scene: Scene, space: Space) -> None:
        motors = space.arm.motors
        super().__init__(built, scene, motors)
        self._space = space
        self._count_at_reset = built.board.words().ports.start_count
        hand = hand_words(space)
        hand[HOME : HOME + 3] += space.arm.tip(np.full(motors, self.at_reset_rad))
        self._hand = (
            space.arm.geometry, hand,
            np.array([self._kept[0, pins_loop.NOW], self._board.timing.tick_clocks // HAND_PARTS]),
        )  # fmt: skip
        self.host = JointHost(space, [scene] * motors, [self.settings] * motors).host
        """It knows of each motor what the scene does."""

    @property
    def at_reset_rad(self) -> float:
        """Where the rotors were at reset, in the angles of the board's scene."""
        return self._count_at_reset * self.settings.cell_rad

    def write_surfaces(self, stamp: int) -> list[bytes]:
        """Write what moving surfaces may give out, and the planes of the space's surfaces where the
        encoders are; the board's answers."""
        budget = WORDS["surface_budget"]
        energy = budget.fixed.to_raw(self._space.device.wall_energy_j / self.tick_s)
        words = as_words(self.host.look(self._kept[:, pins_loop.COUNT] - self._count_at_reset))
        registers = as_registers(*words, count=len(self._space.solids))
        writes = [(budget.at(), [energy]), *as_writes(registers, stamp)]
        return [self.write(first, raws) for first, raws in writes]

    def advance(self, seconds: float) -> np.ndarray:
        rows = []
        for n in range(math.ceil(seconds / ARMED_S - 1e-9)):
            self._board.send(write_frame(WORDS["arm"].at(), [1]))
            rows.append(self._pass(min(ARMED_S, seconds - n * ARMED_S)))
        found = np.concatenate(rows, axis=1)
        found[:, :, Column.X] -= self.at_reset_rad
        return found

    def _tip(self, ticks: int) -> tuple:
        return *self._hand, np.zeros(ticks, dtype=np.int64), *hand_room(len(self._each))
