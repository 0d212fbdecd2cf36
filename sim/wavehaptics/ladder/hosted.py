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

from wavehaptics.controller import anchor, host_link, wave_core
from wavehaptics.controller.normalised import realise
from wavehaptics.controller.settings import Settings, settings
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.pins import PinsSimulation
from wavehaptics.laws import closed_forms
from wavehaptics.laws.reflection import Wish, reflection
from wavehaptics.motor.imperfections import (
    AMPLIFIED,
    LAG,
    LAG_TABLE,
    MOTOR,
    amplified,
    counted,
    real_parts,
    supplied,
)
from wavehaptics.motor.plant import TIME, C, I, P, Plant, X, load_words, plant_step
from wavehaptics.motor.sensor import (
    LAG_RATE,
    NOISE_SEED,
    Sensor,
    current_word,
    draw_noise,
    lagged,
    noise_at,
    range_ends,
)
from wavehaptics.motor.step import motor_step
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene, drive_gain, encoder_end
from wavehaptics.trace.columns import Column, Word, put_anchor, put_motion, put_port
from wavehaptics.words import formats

USUAL_TIMEOUT = 100
"""Periods without an answer after which the port is on its own."""

_VOLT = formats.VOLTAGE.step
_WAVE = formats.WAVE.step
_ETA = formats.ETA.step

_POSITION, _WAVE_VOLTAGE, _CORRECTION = range(3)
_ROOT, _A, _U_MAX, _EXTRA, _ETA_CONTACT, _ETA_FREE, _SUBSTEPS, _PERIOD_LOG2, _TIMEOUT = range(9)


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


@compiled(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _period(
    rows, state, voltage, core, line, link, contact, wall_min, wall_max, anchored, ints, kept, dt,
    cell, k_t, resistance, gain, encoder_end_s, load, matrix, real, sensor, noise,
):  # fmt: skip
    """A period of the link into ``rows``; returns the voltage's word, the packet's number, v̄.

    ``anchored`` as :mod:`wavehaptics.ladder.sampled` has it; ``kept`` are position, e_id and c.
    """
    substeps, extra = ints[_SUBSTEPS], ints[_EXTRA]
    tick = dt * substeps
    sequence, mean_v = 0, 0
    for n in range(rows.shape[0]):
        e_a = voltage * _VOLT * gain
        sag = 0.0
        if real is not None:
            e_a, sag = supplied(e_a, state[TIME], real)
        x_before, hand_before, t_before = state[X], state[P] + state[C], state[TIME]
        charge, square = 0.0, 0.0
        lag_before = 0.0 if real is None else real[LAG][AMPLIFIED]
        for _ in range(substeps):
            i_start = state[I]
            if real is None:
                part, part_square = plant_step(state, matrix, dt, e_a, load)
            else:
                part, part_square = motor_step(state, matrix, dt, e_a, load, real[MOTOR])
                if sensor[LAG_RATE] != 0.0:
                    real[LAG][AMPLIFIED] = lagged(
                        real[LAG][AMPLIFIED], i_start, state[I], part / dt, real[LAG_TABLE][0]
                    )
            charge += part
            square += part_square
        mean = charge / tick
        sensed = mean
        if real is not None:
            sensed = amplified(mean, 0, lag_before, tick, e_a, state[TIME], sensor, real)
        current = current_word(sensed, sensor, noise_at(noise, n))
        ends = range_ends(current, sensor)
        if real is not None:
            kept[_POSITION] = counted(
                kept[_POSITION], state[X], state[TIME], cell, encoder_end_s, real
            )
        elif state[TIME] < encoder_end_s:
            kept[_POSITION] = int(np.floor(state[X] / cell))
        position = kept[_POSITION]
        touching, _ = wave_core.contact_step(contact, position, wall_min, wall_max)
        eta = ints[_ETA_CONTACT] if touching else ints[_ETA_FREE]
        active = link[host_link.ACTIVE]
        goal = link[host_link.U] if active else 0
        if active:
            eta = 0
        u_max = ints[_U_MAX]
        if anchored is not None:
            current = wave_core.saturate(current - anchored[1][anchor.OFFSET])
            u_max = anchor.left(u_max, anchored[1])
            if anchored[1][anchor.FAULT] != 0:
                eta, goal = 0, 0
        withheld, saturated = core[wave_core.STATE_WITHHELD], core[wave_core.STATE_SATURATED] != 0
        voltage, u_n, v_n = wave_core.wave_core_step(
            core, line, current, eta, goal, ints[_ROOT], ints[_A], u_max, extra, extra, ends
        )
        sent, number, packet = host_link.tick(link, v_n, ints[_PERIOD_LOG2], ints[_TIMEOUT])
        if sent:
            sequence, mean_v = number, packet
        row = rows[n]
        put_motion(
            row, t_before, tick, x_before, state[X], mean, e_a - sag * mean, k_t * mean,
            0.5 * (hand_before + state[P] + state[C]), e_a * charge - resistance * square, 0.0,
        )  # fmt: skip
        limited = abs(u_n) >= u_max
        if anchored is not None:  # whose limit is not the same in every tick
            limited = core[wave_core.STATE_SATURATED] != 0
        clipped = core[wave_core.STATE_CLIPPED] != 0
        put_port(row, eta * _ETA, u_n * _WAVE, v_n * _WAVE, active, limited, clipped)
        if anchored is not None:
            held = anchored[1]
            applied = kept[_CORRECTION] * _VOLT
            kept[_CORRECTION] = held[anchor.CORRECTION]
            anchor.anchor_step(
                held, anchored[0], position, touching or active != 0, current, u_n, v_n, withheld,
                kept[_WAVE_VOLTAGE], saturated, clipped,
            )  # fmt: skip
            kept[_WAVE_VOLTAGE] = voltage
            voltage = wave_core.saturate(voltage + kept[_CORRECTION])
            put_anchor(row, applied, held[anchor.FAULT])
    return voltage, sequence, mean_v


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
        set_: Settings = settings(scene).for_a_host()
        self.settings, self.tick_s = set_, set_.tick_s
        self.period_ticks = 1 << period_log2
        self.environment = environment
        self._line_end = LineEnd(line)
        plant = Plant.of_scene(scene)
        substeps = plant.substeps(set_.tick_s)
        dt = set_.tick_s / substeps
        self.link = host_link.new_state()
        self._state = plant.start.copy()
        self._voltage = 0
        self._memory = (wave_core.new_state(), wave_core.new_line(set_.extra_ticks), self.link)
        self._walls = (np.array([-1, 0], dtype=np.int64), set_.wall_min, set_.wall_max)
        self._anchored = (set_.anchor, anchor.new_state()) if set_.anchored else None
        self._ints = np.array(
            [set_.root, set_.a, set_.u_max, set_.extra_ticks, set_.eta_contact, set_.eta_free,
             substeps, period_log2, timeout],
            dtype=np.int64,
        )  # fmt: skip
        gain = drive_gain(scene)
        start = math.floor(plant.start[X] / set_.cell_rad)
        self._kept = np.array([start, 0, 0], dtype=np.int64)
        self._floats = (
            dt, set_.cell_rad, plant.k_t, plant.resistance, gain, encoder_end(scene)
        )  # fmt: skip
        self._plant = (
            load_words(plant), plant.transition(dt), real_parts(scene, plant, set_.cell_rad, [dt])
        )  # fmt: skip
        self._sensor = Sensor.of_scene(scene).constants()
        self._rng = np.random.default_rng(NOISE_SEED)

    def advance(self, periods: int) -> np.ndarray:
        """Rows (Column) of the coming ``periods`` periods."""
        rows = np.zeros((periods * self.period_ticks, len(Column)))
        for n in range(periods):
            part = rows[n * self.period_ticks : (n + 1) * self.period_ticks]
            for sequence, u in self._line_end.due(self.period_ticks * self.tick_s):
                host_link.answer(self.link, sequence, u)
            self._voltage, sequence, mean = _period(
                part, self._state, self._voltage, *self._memory, *self._walls, self._anchored,
                self._ints, self._kept, *self._floats, *self._plant, self._sensor,
                draw_noise(self._rng, self._sensor, len(part)),
            )  # fmt: skip
            self._line_end.ask(self.environment, sequence, mean)
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
