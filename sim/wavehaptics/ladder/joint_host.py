# SPDX-License-Identifier: Apache-2.0
"""What every controller of a device has: its host, and what its surfaces feel like.

The host looks at the encoders at a rate of its own, and what it makes of that comes later.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar

import numpy as np

from wavehaptics.controller import surfaces
from wavehaptics.controller.planes import Host, Planes, PortEstimate
from wavehaptics.controller.settings import Settings
from wavehaptics.ladder.design_spring import rendered_stiffness
from wavehaptics.laws import closed_forms
from wavehaptics.scene import Scene, Space
from wavehaptics.words import formats

JITTER_SEED = 20_260_102
"""Seed of the host's jitter."""


class JointHost:
    """The host of ``scenes`` in one ``space``, whose ports have these ``settings``.

    The law has real numbers and steps of ``step_s``, a delay of 1/λ and no anchor; without
    ``step_s`` it has the words of ``settings``. A ``servo`` makes springs of its own.
    """

    def __init__(
        self, space: Space, scenes: Sequence[Scene], settings: list[Settings],
        step_s: float | None = None, *, servo: bool = False,
    ) -> None:  # fmt: skip
        self.space, self.settings, self._is_servo = space, settings, servo
        self.tick_s = settings[0].tick_s
        has_words = step_s is None
        delays = [
            set_.tau if has_words else 1.0 / scene.controller.lambda_
            for scene, set_ in zip(scenes, settings, strict=True)
        ]
        self.line_ticks = -1
        """Ticks that the waves of a virtual shaft take from motor to motor; −1 without one."""
        if space.coupling is not None:
            self.line_ticks = round(space.coupling.delay_s / self.tick_s)
            delays = [delay + self.line_ticks * self.tick_s for delay in delays]
        self.joint_stiffness = np.array([
            rendered_stiffness(scene, set_.r_hat, tau, -1.0, set_.anchored and has_words, None)
            for scene, set_, tau in zip(scenes, settings, delays, strict=True)
        ])  # fmt: skip
        ports = [
            PortEstimate(
                scene.controller.k_t_hat or 0.0, set_.r_hat,
                closed_forms.l_eff(scene.controller.l_hat or 0.0, set_.r_hat, tau), set_.cell_rad,
                tau,
            )
            for scene, set_, tau in zip(scenes, settings, delays, strict=True)
        ]  # fmt: skip
        self.host = Host(
            space.arm, space.shapes, ports, step_s or self.tick_s,
            [one.stiffness for one in space.solids], [one.friction_loss for one in space.solids],
            space.device.wall_speed_m_per_s, [one.damping for one in space.solids],
        )  # fmt: skip

    @property
    def count_m(self) -> float:
        """The finest way along the first surface's normal that the encoders tell, m; least 1 nm."""
        cell = np.array([set_.cell_rad for set_ in self.settings])
        return max(float(np.linalg.norm(self._along() * cell)), 1e-9)

    def _along(self) -> np.ndarray:
        """``Jᵀn`` where the run begins, of the first surface's normal; of x without surfaces."""
        arm, places = self.space.arm, np.zeros(len(self.settings))
        normal = np.array([1.0, 0.0, 0.0])
        if self.space.shapes:
            normal = self.space.shapes[0].depth(arm.tip(places)[None, :])[1][0]
        along: np.ndarray = arm.jacobian(places).T @ normal
        return along

    def predicted(self) -> float | None:
        """K of the first surface where the run begins, ``1/Σ G_n²/K_n``, N/m; or what it wishes."""
        if not self.space.shapes:
            return None
        stiffest = 1.0 / float(self._along() ** 2 @ (1.0 / self.joint_stiffness))
        wished = self.space.solids[0].stiffness
        if self._is_servo and wished is not None:
            return wished
        return stiffest if wished is None else min(stiffest, wished)

    def shaft_predicted(self) -> float:
        """K of the virtual shaft between two motors, ``1/(1/K_0 + 1/K_1)``, N·m/rad."""
        return 1.0 / float(np.sum(1.0 / self.joint_stiffness))

    def wished_compliance(self) -> np.ndarray:
        """1/K of each surface where that is what it wishes, m/N; 0 where it is the motors'."""
        if self._is_servo:
            return 1.0 / np.array(self.springs)
        return np.array([1.0 / (one.stiffness or math.inf) for one in self.space.solids])

    @property
    def springs(self) -> list[float]:
        """The servo's K of each surface: as wished, or as the wave wall's at the start, N/m."""
        places = np.zeros(len(self.settings))
        return [
            one.stiffness or self.host.stiffest(n, places)
            for n, one in enumerate(self.space.solids)
        ]

    @property
    def budget(self) -> int:
        """The word of what moving surfaces may give out: E = ½T·Σu²."""
        square_j = 0.5 * self.tick_s * formats.WAVE.step**2
        return min(round(self.space.device.wall_energy_j / square_j), surfaces.ACCOUNT_MAX)

    def updates(self) -> Events[Planes]:
        """When the host looks, and when its planes are committed."""
        table = self.space.device
        every = max(1, round(1.0 / (table.update_hz * self.tick_s)))
        return Events(every, table.delay_s / self.tick_s, table.jitter_s / self.tick_s)


_Update = TypeVar("_Update")


class Events(Generic[_Update]):
    """When a host looks, ``every`` so many ticks, and when what it made of that is committed:
    ``delay`` ticks later and up to ``jitter`` more, but never before what it saw earlier.
    """

    def __init__(self, every: int, delay: float, jitter: float) -> None:
        self._every, self._delay, self._jitter = every, delay, jitter
        self._rng = np.random.default_rng(JITTER_SEED)
        self._now, self._next_look, self._last = 0, every, 0
        self._coming: deque[tuple[int, _Update]] = deque()

    def ticks_left(self) -> int:
        """Ticks until the next event."""
        commit = self._coming[0][0] if self._coming else self._next_look
        return min(commit, self._next_look) - self._now

    def pass_(self, ticks: int) -> None:
        self._now += ticks

    def due(self, look: Callable[[], _Update]) -> _Update | None:
        """What is committed now, after ``look`` was called where it is time to."""
        if self._now == self._next_look:
            self._next_look += self._every
            late = self._delay + self._jitter * self._rng.random()
            self._last = max(self._last, self._now + round(late))
            self._coming.append((self._last, look()))
        if self._coming and self._coming[0][0] == self._now:
            return self._coming.popleft()[1]
        return None


class JointLoop(JointHost):
    """The motors of a device in one loop, of which the host looks and commits between ticks."""

    singular_updates = 0
    """Planes that the host didn't send, as no motor moves the tip along their normal."""

    _events: Events[Any]

    @property
    def clock_cycles(self) -> int | None:
        """Clocks of the RTL so far; None without RTL."""
        return None

    def advance(self, rows: np.ndarray, words: np.ndarray, tips: np.ndarray) -> None:
        """Simulate ``len(tips)`` ticks into ``rows`` (motors, ticks, Column), ``words`` of the same
        shape (Word) and ``tips`` (ticks, Tip).
        """
        at = 0
        while at < len(tips) or not len(tips):
            more = min(self._events.ticks_left(), len(tips) - at)
            part = slice(at, at + more)
            self._run(rows[:, part], words[:, part], tips[part])
            at += more
            self._events.pass_(more)
            if not len(tips):
                return
            while (update := self._events.due(self._look)) is not None:
                self._commit(update)

    def _run(self, rows: np.ndarray, words: np.ndarray, tips: np.ndarray) -> None:
        """Simulate as many ticks, between which nothing is committed."""
        raise NotImplementedError

    def _look(self) -> Any:
        """What the host makes of the encoders."""
        raise NotImplementedError

    def _commit(self, update: Any) -> None:
        """Put in force what :meth:`_look` made."""
        raise NotImplementedError
