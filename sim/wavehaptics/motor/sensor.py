# SPDX-License-Identifier: Apache-2.0
"""The current sensor: amplifier, ADC and the word that the controller makes of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wavehaptics.parts.adcs import MODULATORS
from wavehaptics.runtime.compiled import compiled
from wavehaptics.scene import Scene
from wavehaptics.words import formats

_CURRENT_SCALE = 2.0**formats.CURRENT.fraction
_CURRENT_MAX = formats.CURRENT.raw_max
_GAIN_SHIFT = formats.GAIN.fraction - formats.CURRENT.fraction
_SAMPLE_HALF = 1 << (formats.SAMPLE_W - 1)

NOISE_SEED = 20_260_101
"""Seed of the ADC's noise: the same scene gives the same noise on every controller and run."""

(
    IDEAL, BITS, FULL_SCALE, NOISE, OFFSET, GAIN, LAG_RATE, COMMON_MODE, DRIFT, SETTLE_RATE, END,
    HOLD_S, RESTARTS,
) = range(13)  # fmt: skip
"""Places in :meth:`Sensor.constants`; LAG_RATE in rad/s is 0 without a lag, and SETTLE_RATE in 1/s
where COMMON_MODE goes by the voltage's sign. END is the current word at the end of the range.
HOLD_S is 0 where the amplifier never holds its output, RESTARTS whether an edge begins it anew."""

SETTLED = 0.01
"""Part of what an edge adds that is left after ``edge_settle_s``."""

KEEP, FIRST, SLOPE, CURVE = range(4)
"""Places in a row of :meth:`Sensor.lag_table`."""

LEVEL, UNTIL, HELD_A = range(3)
"""Columns of :func:`new_holds`: the lead's level, 0 before the first, the clock at which the hold
ends, and the output that is held, A."""

_TIE_CLOCKS = 1e-6
"""A hold that ends with an edge or a sample is over then, however its length is rounded."""


@dataclass(frozen=True)
class Sensor:
    """A current sensor; ``ideal`` passes the current on in the controller's own word length.

    ``bits`` and ``full_scale_a`` (± that current) describe the ADC, the others the amplifier before
    it: ``noise_a`` (RMS), ``offset_a`` and its ``drift_a_per_s``, ``common_mode_a`` by the sign of
    the motor's voltage or with ``edge_settle_s`` by each edge of lead A, all in A, and
    ``bandwidth_hz``, infinite without a lag. For ``edge_hold_s`` after an edge of its lead the
    amplifier holds its output; with ``edge_hold_restarts`` an edge in that time begins it anew.
    ``linear`` is the part of the full scale up to which the converter's words can be trusted.
    """

    ideal: bool
    bits: int = formats.SAMPLE_W
    full_scale_a: float = 1.0
    noise_a: float = 0.0
    offset_a: float = 0.0
    bandwidth_hz: float = math.inf
    common_mode_a: float = 0.0
    drift_a_per_s: float = 0.0
    edge_settle_s: float | None = None
    edge_hold_s: float = 0.0
    edge_hold_restarts: bool = True
    linear: float = 1.0

    @classmethod
    def of_scene(cls, scene: Scene) -> Sensor:
        """The scene's sensor; without ``[adc]`` an ideal one."""
        if scene.adc is None:
            return cls(ideal=True)
        adc = scene.adc
        bandwidth_hz = math.inf if adc.bandwidth_hz is None else adc.bandwidth_hz
        modulator = MODULATORS.get(adc.part or "")
        return cls(
            False, adc.bits, adc.full_scale_a, adc.noise_a, adc.offset_a, bandwidth_hz,
            adc.common_mode_a, adc.drift_a_per_s, adc.edge_settle_s, adc.edge_hold_s,
            adc.edge_hold_restarts,
            1.0 if modulator is None else modulator.linear,
        )  # fmt: skip

    def gain_word(self, samples: float) -> int:
        """Word of A per unit of the sum of ``samples`` left-justified ADC words.

        Words whose full scale isn't 2¹⁵ count for less than one each.
        """
        return formats.GAIN.to_raw(self.full_scale_a / (_SAMPLE_HALF * samples))

    def range_word(self, unity: float = 1.0) -> int:
        """Magnitude of an ADC word at the end of the range, of 2¹⁵: ``wh_current``'s ``range_i``.

        ``unity`` is the word of full scale, in parts of 2¹⁵. The highest code is a step below that.
        """
        top = _SAMPLE_HALF - (1 << (formats.SAMPLE_W - self.bits))
        return min(top, math.floor(self.linear * unity * _SAMPLE_HALF))

    def constants(self) -> np.ndarray:
        """For the functions below: float64 (13,)."""
        gain = 0 if self.ideal else self.gain_word(1)
        end = _CURRENT_MAX if self.ideal else scale_sum.py_func(self.range_word(), gain)
        return np.array(
            [self.ideal, self.bits, self.full_scale_a, self.noise_a, self.offset_a, gain,
             self._lag_rate, self.common_mode_a, self.drift_a_per_s, self._settle_rate, end,
             self.edge_hold_s, self.edge_hold_restarts],
            float,
        )  # fmt: skip

    @property
    def _settle_rate(self) -> float:
        return -math.log(SETTLED) / self.edge_settle_s if self.edge_settle_s else 0.0

    @property
    def _lag_rate(self) -> float:
        return 0.0 if math.isinf(self.bandwidth_hz) else 2 * math.pi * self.bandwidth_hz

    def lag_table(self, steps_s: Sequence[float] | np.ndarray) -> np.ndarray:
        """Words of :func:`lagged` for steps of the lengths ``steps_s``, in s: (steps, 4).

        ``dz/dt = ω_b (i − z)`` solved for a current that is a parabola within the step.
        """
        x = self._lag_rate * np.asarray(steps_s, dtype=float)
        table = np.zeros((len(x), 4))
        table[:, KEEP] = np.exp(-x)
        with np.errstate(divide="ignore", invalid="ignore"):
            table[:, FIRST] = -np.expm1(-x)
            table[:, SLOPE] = np.where(x > 0, 1 - table[:, FIRST] / x, 0.0)
            table[:, CURVE] = np.where(x > 0, 1 - 2 * table[:, SLOPE] / x, 0.0)
        return table


def draw_noise(rng: np.random.Generator, sensor: np.ndarray, count: int) -> np.ndarray:
    """Noise of ``count`` samples in units of ``noise_a``: (count,), or (0,) without noise."""
    return rng.standard_normal(count if sensor[NOISE] > 0.0 else 0)


@compiled(inline="always")
def noise_at(noise: np.ndarray, n: int) -> float:
    """The noise of sample ``n`` of :func:`draw_noise`."""
    return noise[n] if noise.shape[0] else 0.0


@compiled(inline="always")
def lagged(z: float, first: float, last: float, mean: float, words: np.ndarray) -> float:
    """The amplifier's output after a step, A, from ``z`` before it.

    The current goes from ``first`` to ``last`` with the given ``mean``; ``words`` is a row of
    :meth:`Sensor.lag_table`.
    """
    curve = 3.0 * (first + last) - 6.0 * mean
    slope = last - first - curve
    z = words[KEEP] * z + words[FIRST] * first + words[SLOPE] * slope + words[CURVE] * curve
    return z


@compiled(inline="always")
def disturbed(current: float, volts: float, time: float, sensor: np.ndarray) -> float:
    """A current in A with what the amplifier adds at a ``time``, the motor having ``volts``."""
    if sensor[COMMON_MODE] != 0.0 and volts != 0.0 and sensor[SETTLE_RATE] == 0.0:
        current += sensor[COMMON_MODE] if volts > 0.0 else -sensor[COMMON_MODE]
    if sensor[DRIFT] != 0.0:
        current += sensor[DRIFT] * time
    return current


def new_holds(leads: int) -> np.ndarray:
    """Memory of the amplifiers in ``leads`` leads before the first edge: float64 (leads, 3)."""
    return np.zeros((leads, 3))


@compiled(inline="always")
def hold_at_edge(
    holds: np.ndarray, lead: int, level: float, clock: float, output: float, hold_clocks: float,
    restarts: float,
) -> None:  # fmt: skip
    """Let an amplifier hold its ``output`` in A from ``clock`` on, if ``level`` is a new one.

    ``level`` is the lead's from then on, either sign; its first is no edge. An edge in a hold
    begins it anew with the same output where ``restarts`` isn't 0, and is ignored otherwise.
    """
    before = holds[lead, LEVEL]
    if level != before:
        holds[lead, LEVEL] = level
        holding = clock < holds[lead, UNTIL] - _TIE_CLOCKS
        if before != 0.0 and (restarts != 0.0 or not holding):
            holds[lead, UNTIL] = clock + hold_clocks
            if not holding:
                holds[lead, HELD_A] = output


@compiled(inline="always")
def held_output(holds: np.ndarray, lead: int, clock: float, output: float) -> float:
    """What the converter gets at ``clock``, A, of an amplifier that would follow to ``output``."""
    return holds[lead, HELD_A] if clock < holds[lead, UNTIL] - _TIE_CLOCKS else output


@compiled(inline="always")
def sample_code(current: float, sensor: np.ndarray, noise: float) -> int:
    """The ADC's signed code of a current in A; mid-scale is 0 A, codes end at full scale."""
    current += sensor[NOISE] * noise
    half = 1 << (int(sensor[BITS]) - 1)
    code = round((current + sensor[OFFSET]) / sensor[FULL_SCALE] * half)
    return min(max(int(code), -half), half - 1)


@compiled()
def scale_sum(total: int, gain: int) -> int:
    """Current word of a tick's sum of ADC words (sum minus zero): ``rtl/wh_current.v``.

    The product is rounded to the nearest word, halves away from zero: this is a sensor, where
    rounding toward zero would be an offset.
    """
    product = total * gain
    half = 1 << (_GAIN_SHIFT - 1)
    magnitude = (abs(product) + half) >> _GAIN_SHIFT
    return min(magnitude, _CURRENT_MAX) if product >= 0 else -min(magnitude, _CURRENT_MAX + 1)


@compiled(inline="always")
def current_word(current: float, sensor: np.ndarray, noise: float) -> int:
    """Word that the wave core gets for a tick's mean current in A."""
    if sensor[IDEAL] != 0.0:
        word = round(current * _CURRENT_SCALE)
        return int(min(max(word, -_CURRENT_MAX - 1), _CURRENT_MAX))
    code = sample_code(current, sensor, noise) << (formats.SAMPLE_W - int(sensor[BITS]))
    return scale_sum(code, int(sensor[GAIN]))


@compiled(inline="always")
def range_ends(word: int, sensor: np.ndarray) -> int:
    """At which end of the range a :func:`current_word` is: ``formats.AT_HIGH``, ``AT_LOW`` or 0."""
    return formats.AT_HIGH if word >= sensor[END] else formats.AT_LOW if word <= -sensor[END] else 0
