# SPDX-License-Identifier: Apache-2.0
"""A scene whose environment runs on a computer, behind a line that delays, loses and repeats.

Two environments of a spring and a damper: :class:`WaveEnvironment` works on the waves themselves,
:class:`PowerEnvironment` takes them apart into speed and torque with a wave transform of its own
(the paper's section III). Both are a step a packet.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from wavehaptics.controller import host_link
from wavehaptics.controller.normalised import realise
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.laws import closed_forms
from wavehaptics.laws.reflection import Wish, reflection
from wavehaptics.scene import Scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats

USUAL_TIMEOUT = 100
"""Periods without an answer after which the port is on its own."""

_WAVE = formats.WAVE.step


class Environment(Protocol):
    """What a host computes: a wave for a wave, √W, once a packet."""

    def step(self, v: float) -> float: ...


class WaveEnvironment:
    """A linear wish in wave space: D as a contractive matrix at the host's period."""

    def __init__(self, wish: Wish, wave_damper: float, period_s: float) -> None:
        matrix = realise(*reflection(wish, wave_damper), period_s)
        self._matrix = matrix + np.diag([1.0, 1.0, 0.0])
        self._x = np.zeros(3)

    def step(self, v: float) -> float:
        self._x[2] = v
        self._x = self._matrix @ self._x
        return -float(self._x[2])


class PowerEnvironment:
    """A wall of a spring and a damper at x > 0, in speed and torque.

    The wave is decoded as ``ω = (s v + R̂ i)/k_T``, the speed behind the motor's inductance, x is
    its integral, and ``k_T i = −(K x + b ω)`` in the wall; backward Euler, solved for ω, encoded as
    ``u = v + s i``. ``everywhere`` has the spring pull as well.
    """

    def __init__(
        self, stiffness: float, damping: float, k_t: float, r_hat: float, period_s: float,
        *, everywhere: bool = False,
    ) -> None:  # fmt: skip
        self._k, self._b, self._k_t, self._period = stiffness, damping, k_t, period_s
        self._s = closed_forms.root(r_hat)
        self._mobility = r_hat / k_t**2
        self._everywhere = everywhere
        self._x = 0.0

    def step(self, v: float) -> float:
        free = self._s * v / self._k_t
        touched = (free - self._mobility * self._k * self._x) / (
            1.0 + self._mobility * (self._k * self._period + self._b)
        )
        in_wall = self._everywhere or self._x + self._period * touched > 0.0
        omega = touched if in_wall else free
        self._x += self._period * omega
        torque = -(self._k * self._x + self._b * omega) if in_wall else 0.0
        if not self._everywhere:
            torque = min(torque, 0.0)
        return v + self._s * torque / self._k_t


@dataclass(frozen=True)
class Line:
    """What lies between port and host: delay there and back together, and what goes wrong."""

    delay_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    """Part of the packets that are lost, each way."""
    repeats: float = 0.0
    """Part of the answers that come a second time, later."""
    seed: int = 20


class HostedSimulation:
    """A scene on the integer wave core whose goal a host gives, packet by packet.

    ``environment`` None is a silent host. A period is ``2**period_log2`` ticks. Column CONTACT says
    whether the host's answers are in force.
    """

    def __init__(
        self, scene: Scene, environment: Environment | None, period_log2: int, line: Line,
        timeout: int = USUAL_TIMEOUT,
    ) -> None:  # fmt: skip
        refuse(scene, "hosted")
        self.link = host_link.new_state()
        self._core = SampledSimulation(scene, rtl=False, host=(self.link, period_log2, timeout))
        self.settings, self.tick_s = self._core.settings, self._core.tick_s
        self.period_ticks = 1 << period_log2
        self.environment = environment
        self._line_end = LineEnd(line)

    def advance(self, periods: int) -> np.ndarray:
        """Rows (Column) of the coming ``periods`` periods."""
        rows = np.zeros((periods * self.period_ticks, len(Column)))
        words = np.zeros((self.period_ticks, len(Word)), dtype=np.int64)
        for n in range(periods):
            part = rows[n * self.period_ticks : (n + 1) * self.period_ticks]
            for sequence, u in self._line_end.due(self.period_ticks * self.tick_s):
                host_link.answer(self.link, sequence, u)
            self._core.advance(part, words)
            self._line_end.ask(self.environment, *self._core.packet)
        return rows


class PinsHostedSimulation:
    """The same with the whole RTL at its pins, through the ports that a board's link has.

    No command runs it: tests hold the RTL's budget and the port anchor with a host to it.
    """

    def __init__(
        self, scene: Scene, environment: Environment | None, period_log2: int, line: Line,
        timeout: int = USUAL_TIMEOUT,
    ) -> None:  # fmt: skip
        self._pins = PinsSimulation(scene, host=True)
        self.settings, self.tick_s = self._pins.settings, self._pins.tick_s
        self.period_ticks = 1 << period_log2
        self.environment = environment
        self._line_end = LineEnd(line)
        self._pins.connect_host(period_log2, timeout)

    def advance(self, periods: int) -> np.ndarray:
        """Rows (Column) of the coming ``periods`` periods; CONTACT as of :class:`HostedSimulation`.

        The packet of a period comes in the first tick of the next, and so do the answers, one a
        tick.
        """
        rows = np.zeros((periods * self.period_ticks, len(Column)))
        words = np.zeros((self.period_ticks, len(Word)), dtype=np.int64)
        for n in range(periods):
            part = rows[n * self.period_ticks : (n + 1) * self.period_ticks]
            self._pins.advance(part[:1], words[:1])
            packets, sequence, mean, active = self._pins.host_packet()
            if packets:
                self._line_end.ask(self.environment, sequence, mean)
            at = 1
            for sequence, u in self._line_end.due(self.period_ticks * self.tick_s):
                if at < self.period_ticks - 2:
                    self._pins.host_answer(sequence, u)
                    self._pins.advance(part[at : at + 1], words[:1])
                    at += 1
            self._pins.advance(part[at:], words[at:])
            part[:, Column.CONTACT] = active
        return rows


class LineEnd:
    """The host's end of a line: what is on its way, and when it comes."""

    def __init__(self, line: Line) -> None:
        self._line = line
        self._random = np.random.default_rng(line.seed)
        self._on_the_way: list[tuple[float, int, int, int]] = []
        self._now = 0.0
        self._sent = 0

    def due(self, for_s: float) -> list[tuple[int, int]]:
        """Answers (number, u) that arrive in the coming ``for_s``, in their order."""
        self._now += for_s
        arrived = []
        while self._on_the_way and self._on_the_way[0][0] < self._now:
            _, _, sequence, u = heapq.heappop(self._on_the_way)
            arrived.append((sequence, u))
        return arrived

    def ask(self, environment: Environment | None, sequence: int, mean: int) -> None:
        """The packet goes to the host, and the host's answer on its way, if the line lets them."""
        line, random = self._line, self._random
        if environment is None or random.random() < line.loss:
            return
        u = environment.step(mean * _WAVE)
        word = min(max(math.trunc(u / _WAVE), formats.WAVE.raw_min), formats.WAVE.raw_max)
        if random.random() >= line.loss:
            self._send(sequence, word, line.delay_s)
        if random.random() < line.repeats:
            self._send(sequence, word, line.delay_s + random.random() * 4e-3)

    def _send(self, sequence: int, word: int, delay_s: float) -> None:
        arrives = self._now + delay_s + self._random.random() * self._line.jitter_s
        self._sent += 1
        heapq.heappush(self._on_the_way, (arrives, self._sent, sequence, word))
