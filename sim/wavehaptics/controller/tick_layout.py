# SPDX-License-Identifier: Apache-2.0
"""How ticks, carrier and ADC frames of the whole RTL are laid on its clock, for a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from wavehaptics.controller.pins_timing import (
    CENTRED_LEAD,
    ENCODER_CLOCKS,
    FLUX_CLOCKS,
    GATE_CLOCKS,
    latency_clocks,
    least_half_clocks,
    look_clocks,
    shortest_tick_clocks,
    turn_begin_clocks,
    turns_clocks,
    turns_latency_clocks,
)
from wavehaptics.parts.adcs import (
    MODULATORS,
    PARTS,
    Frame,
    PartError,
    frame,
    modulator_frame,
    plain_frame,
)
from wavehaptics.scene import Scene
from wavehaptics.words import formats
from wavehaptics.words.bridge_modes import HALF_BRIDGE, LOCKED, UNIPOLAR
from wavehaptics.words.table import WORDS

CLOCK_HZ = 48e6
"""Clock of the simulated board unless the scene names another."""

FASTEST_CLOCK_HZ = 100e6
"""A part that needs a faster clock than the usual one gets it, up to this."""

MIN_TICK_CLOCKS = 48
"""Clocks of the shortest tick: an ADC frame of 16 bits at half the clock and its quiet time."""

MIN_HALF_CLOCKS = 6
"""Clocks of the shortest carrier half: ``rtl/wh_modulator.v`` makes a width in five."""

MOST_TICK_CLOCKS = 48_000
"""Clocks of the longest tick unless the scene names a clock; the RTL counts 16 bits."""

SLOW_HALF_CLOCKS = 96
"""Longest carrier half period chosen when the scene names no ``pwm_hz``."""

MOST_SAMPLES = 16
"""Samples in a tick. Their sum is scaled by a word of 27 bits, which more would make too coarse."""

MOST_DEAD_CLOCKS = WORDS["dead_clocks"].fixed.raw_max
FrameAt = Callable[[float, int], Frame]
"""An ADC's frame for a clock in Hz and the clocks of a tick."""


@dataclass(frozen=True)
class Timing:
    """How ticks, carrier and ADC are laid on the clock; see ``rtl/wh_carrier.v``."""

    clock_hz: float
    half_clocks: int
    tick_halves: int
    sample_clocks: int
    samples: int
    extra_ticks: int
    hold_ticks: int
    latency_clocks: int
    frame: Frame

    @property
    def tick_clocks(self) -> int:
        return self.half_clocks * self.tick_halves

    @property
    def tick_s(self) -> float:
        return self.tick_clocks / self.clock_hz


def bridge_mode(scene: Scene) -> str:
    """How the scene's bridge switches; of three legs each is a half bridge."""
    if scene.motor.brushless:
        return HALF_BRIDGE
    return scene.drive.mode if scene.drive else UNIPOLAR


def sections_of(scene: Scene) -> int:
    """Sections of the scene's W."""
    return scene.shaper.sections if scene.shaper else 0


def _pulse_halves(scene: Scene) -> int:
    """Carrier halves that one pulse takes, which a tick has a whole number of: ``wh_pwm``."""
    return 1 if bridge_mode(scene) == UNIPOLAR else 2


def _whole_part(total: int, longest: int) -> int:
    """Largest divisor of ``total`` that is at most ``longest``."""
    return next(d for d in range(min(total, longest), 0, -1) if total % d == 0)


def scene_frame(scene: Scene) -> FrameAt:
    """The ADC's frame on a clock, for the scene's ADC or the finest one that the reader takes."""
    if scene.adc is None:
        return lambda clock_hz, _: plain_frame(0, formats.SAMPLE_W)
    part, bits = scene.adc.part, scene.adc.bits
    if part is None:
        return lambda clock_hz, _: plain_frame(2, bits)
    if part in MODULATORS:
        return lambda clock_hz, clocks: modulator_frame(MODULATORS[part], clock_hz, clocks)
    return lambda clock_hz, _: frame(PARTS[part], clock_hz)


class Work(NamedTuple):
    """What a controller does in a tick."""

    turns: int = 0
    """Motors that take turns (:func:`timing`)."""
    sections: int = 0
    """Sections of W."""
    anchored: bool = False
    brushless: bool = False
    surfaces: int = 0
    """Across all motors that take turns."""


def natural_ticks(tick_clocks: int, samples: int, lead: int, frame: Frame, work: Work) -> int:
    """Whole ticks from a tick's end until the voltage made of its samples can be driven."""
    return _ticks_of_latency(tick_clocks, samples, lead, frame, work)[1]


def _ticks_of_latency(
    tick_clocks: int, samples: int, lead: int, frame: Frame, work: Work
) -> tuple[int, int]:
    """:func:`natural_ticks` where the fewest of the surfaces act, and where the most do."""
    strobe = _word_strobe(tick_clocks, samples, lead, frame) + _latency_clocks(frame, work)
    fewest, most = look_clocks(work.turns, work.surfaces)
    return (strobe + fewest) // tick_clocks, (strobe + most) // tick_clocks


def _latency_clocks(frame: Frame, work: Work) -> int:
    """Without surfaces."""
    turns, sections, anchored, brushless, _ = work
    if turns or brushless:
        return turns_latency_clocks(
            frame.conversion_clocks, max(1, turns), sections, brushless=brushless
        )
    return latency_clocks(frame.conversion_clocks, 1, sections, anchored)


def _word_strobe(tick_clocks: int, samples: int, lead: int, frame: Frame) -> int:
    """Clocks from a tick's start to the carrier's strobe that brings its last word."""
    sample_clocks = tick_clocks // samples
    last_sample = tick_clocks - sample_clocks + sample_clocks // 2 - lead
    return last_sample + frame.pipeline * sample_clocks


def position_late_clocks(
    tick_clocks: int, samples: int, lead: int, frame: Frame, filter_clocks: int, motor: int = 0,
    sections: int = 0, brushless: bool = False,
) -> int:  # fmt: skip
    """By how much a tick's ``position`` is younger than the end of what its ``current`` is of.

    The position is looked at as the motor's turn begins; a brushless one's comes by its rotor's
    flux. The current is the mean of the tick as the gates had it, in whose middle it was sampled,
    and the position is the pins' of some clocks before. Less than 0 where it is looked at within
    the tick.
    """
    looked = _word_strobe(tick_clocks, samples, lead, frame) + turn_begin_clocks(
        frame.conversion_clocks, 0 if brushless else motor, sections
    )
    late = ENCODER_CLOCKS + (FLUX_CLOCKS if brushless else 0) + filter_clocks
    return looked - late - (tick_clocks + GATE_CLOCKS)


def sample_lead(made: Frame, pulse_delay: int) -> int:
    """Clocks that the ADC's starts come early, for pulses that are ``pulse_delay`` clocks late.

    A code is held in the middle of the gates' pulse. A modulator's word is of three intervals
    between starts, and its middle one and a half before the start: here is what is left of that
    when the delay of the bits is taken off (``rtl/wh_sinc3.v``; a bit is decided with the clock's
    rise, taken with its fall or where registers at the pads have it, and goes through two
    registers), in whole periods of its clock.
    """
    if not made.osr:
        return CENTRED_LEAD + made.pad_clocks - pulse_delay
    late = made.taken_clocks - made.sclk_half_clocks + made.pad_clocks
    periods = round(1 + (late + 1 + GATE_CLOCKS + pulse_delay) / made.bit_clocks)
    return made.cycle_clocks // 2 - periods * made.bit_clocks


def _is_steady(ticks: tuple[int, int], most: int) -> bool:
    """Whether the latency is the same with and without surfaces, and at most ``most``."""
    fewest, natural = ticks
    return fewest == natural <= most


def _soonest(tick_clocks: int, made: Frame, lead: int, work: Work) -> int:
    """Fewest ticks of latency that the ADC allows."""
    samples = tick_clocks // made.cycle_clocks if made.osr else 1
    return natural_ticks(tick_clocks, samples, lead, made, work)


def _in_time(scene: Scene, clocks: int, made: Frame, work: Work) -> bool:
    """Whether motors that take turns have the latency that the scene names, if it does.

    In a tick of a clock that is free.
    """
    control = scene.controller
    if not work.turns or "extra_ticks" not in control.model_fields_set:
        return True
    return _soonest(clocks, made, sample_lead(made, 0), work) <= control.extra_ticks


def _tick_clocks(
    scene: Scene, tick_hz: float, halves: int, frame_at: FrameAt, least: int, work: Work
) -> tuple[int, Frame]:
    """Clocks of a tick, ``least`` or more of a clock that is free, and the ADC's frame on it."""
    named = scene.controller.clock_hz
    if named is not None:
        clocks = round(named / tick_hz)
        return clocks, frame_at(clocks * tick_hz, clocks)
    usual = min(max(least, round(CLOCK_HZ / tick_hz)), MOST_TICK_CLOCKS)
    found = None
    clocks = usual
    while clocks == usual or clocks * tick_hz <= FASTEST_CLOCK_HZ:
        try:
            made = frame_at(clocks * tick_hz, clocks)
        except PartError:
            made = None
        if made is not None and made.cycle_clocks <= clocks and clocks % halves == 0:
            if not made.osr:
                # Of four, so that a carrier half is whole, and half of it.
                suits = clocks == usual or not work.turns or clocks % 4 == 0
                if suits and _in_time(scene, clocks, made, work):
                    return clocks, made
                found = found or (clocks, made)
            # A modulator: the more bits a tick, the better.
            elif found is None or clocks // made.bit_clocks > found[0] // found[1].bit_clocks:
                found = clocks, made
        if clocks - usual > MOST_TICK_CLOCKS // 40:
            break
        clocks += 1
    return found or (usual, frame_at(usual * tick_hz, usual))


def timing(
    scene: Scene, frame_at: FrameAt, most_samples: int = MOST_SAMPLES, turns: int = 0,
    most_sections: int = 0, surfaces: int = 0,
) -> Timing:  # fmt: skip
    """Lay the scene's tick and carrier on a clock, for an ADC with the frame ``frame_at(clock)``.

    So many motors take ``turns`` in ``rtl/wh_ports.v``, of ``most_sections`` of W each and with so
    many ``surfaces`` across them; 0: a single one, with brushes at a controller of its own,
    ``wh_controller``.

    A carrier slower than half the tick rate sets the pace: the tick is then its half period, and
    the current is the mean of the samples that fit in. :class:`SceneError` where the carrier can't
    be had, the ADC is too slow or the scene's latency is shorter than the hardware's.
    """
    control, drive = scene.controller, scene.drive
    tick_hz = control.tick_hz
    pwm_hz = drive.pwm_hz if drive else None
    pulse_halves = _pulse_halves(scene)
    pulse_hz = None if pwm_hz is None else 2 * pwm_hz / pulse_halves
    if pulse_hz is not None and pulse_hz < tick_hz:
        tick_hz = pulse_hz
    pulses = 1 if pulse_hz is None else max(1, round(pulse_hz / tick_hz))
    halves = pulses * pulse_halves
    sections = max(most_sections, sections_of(scene))
    brushless = scene.motor.brushless
    anchored = control.anchored
    work = Work(turns, sections, anchored, brushless, surfaces)
    together = turns > 0 or brushless
    turning = 0
    if together:
        turning = turns_clocks(max(1, turns), sections, brushless=brushless, surfaces=surfaces)
    try:
        tick_clocks, made = _tick_clocks(
            scene, tick_hz, halves, frame_at, max(MIN_TICK_CLOCKS, turning + -turning % 4), work
        )
    except PartError as error:
        raise scene.refusal(
            f"adc.part: {error}; take another clock_hz", "adc.part", "controller.clock_hz"
        ) from None
    clock_hz = control.clock_hz if control.clock_hz is not None else tick_hz * tick_clocks
    if pwm_hz is None or pulse_hz is None:
        if tick_clocks % pulse_halves:
            raise scene.refusal(
                f"drive.mode = {bridge_mode(scene)} needs an even number of "
                f"clocks in a tick, not {tick_clocks}; take another controller.clock_hz",
                "drive.mode",
                "controller.clock_hz",
                "controller.tick_hz",
            )
        pulse_clocks = pulse_halves * _whole_part(
            tick_clocks // pulse_halves, SLOW_HALF_CLOCKS // pulse_halves
        )
        if pulse_clocks < MIN_TICK_CLOCKS:
            pulse_clocks = tick_clocks
    else:
        if abs(pulses * tick_hz / pulse_hz - 1) > 0.01 or tick_clocks % halves:
            twice = (
                "twice pwm_hz" if pulse_halves == 1 else f"with mode = {bridge_mode(scene)} pwm_hz"
            )
            raise scene.refusal(
                f"drive.pwm_hz = {pwm_hz:g} Hz doesn't fit "
                f"controller.tick_hz = {control.tick_hz:g} Hz on `pins`; "
                f"{twice} must be slower than tick_hz, or a multiple of it that divides its "
                f"{tick_clocks} clocks{'' if pulse_halves == 1 else ', in two halves each'}",
                "drive.pwm_hz",
                "controller.tick_hz",
            )
        pulse_clocks = tick_clocks // pulses
    half_clocks = pulse_clocks // pulse_halves
    limit = (1 << formats.TICK_W) - 1
    if tick_clocks > limit:
        raise scene.refusal(
            f"a tick of {tick_clocks} clocks is longer than `pins` can count; "
            f"take controller.clock_hz <= {limit * tick_hz:g}",
            "controller.clock_hz",
            "controller.tick_hz",
        )
    shared = least_half_clocks(max(1, turns), brushless=brushless) if together else 0
    least_half = max(MIN_HALF_CLOCKS, shared)
    if half_clocks < least_half:
        raise scene.refusal(
            f"a carrier half of {half_clocks} clocks of {clock_hz:g} Hz is "
            f"shorter than the {least_half} that `pins` needs; lower drive.pwm_hz or "
            "controller.tick_hz, or take a faster clock_hz",
            "drive.pwm_hz",
            "controller.tick_hz",
            "controller.clock_hz",
        )
    # Without an ADC in the scene it is one of as many bits as a word has, and takes as long. Where
    # samples come a clock later in every other tick (sample_late), two of them are closer once.
    delay = pulse_delay(scene, clock_hz, half_clocks)
    cycle_clocks = made.cycle_clocks + (0 if made.osr else delay % 2)
    if cycle_clocks > tick_clocks:
        name = (scene.adc and scene.adc.part) or "the ADC"
        raise scene.refusal(
            f"{name} needs {cycle_clocks} clocks of {clock_hz:g} Hz from "
            f"sample to sample, and controller.tick_hz leaves {tick_clocks}; lower it or take "
            "another clock_hz",
            "controller.clock_hz",
            "adc.part",
            "controller.tick_hz",
        )
    least = turning or shortest_tick_clocks(1, sections, anchored)
    if tick_clocks < least:
        ports = f"{turns} motors" if turns > 1 else "a motor" if turns else "a port"
        ports = "two ports" if brushless and not turns else ports
        shaper = " with W" if sections else ""
        if surfaces:
            shaper = f" with {surfaces} surface{'s' * (surfaces > 1)}"
        anchors = " and its anchor" if anchored and not together else ""
        raise scene.refusal(
            f"a tick of {tick_clocks} clocks is shorter than the "
            f"{least} that `pins` needs for {ports}{shaper}{anchors}; take "
            f"controller.clock_hz >= {least * tick_hz:g} or controller.tick_hz <= "
            f"{clock_hz / least:g}",
            "controller.tick_hz",
            "controller.clock_hz",
        )
    # The scene's latency, or without one in it, as much as is needed.
    lead = sample_lead(made, (delay + 1) // 2)
    extra = control.extra_ticks
    if "extra_ticks" not in control.model_fields_set:
        extra = max(extra, _soonest(tick_clocks, made, lead, work))
    # As many samples as the ADC can make and the latency allows, but each in the middle of
    # as many whole pulses as any other, or several within the only one. A modulator has its own
    # number, of words that follow each other.
    parts = tick_clocks if tick_clocks == pulse_clocks else tick_clocks // pulse_clocks
    samples = next(
        n
        for n in range(most_samples, 0, -1)
        if n == 1
        or (
            not made.osr
            and (
                parts % n == 0
                and tick_clocks // n >= cycle_clocks
                and _is_steady(_ticks_of_latency(tick_clocks, n, lead, made, work), extra)
            )
        )
    )
    if made.osr:
        samples = tick_clocks // made.cycle_clocks
    soonest, natural = _ticks_of_latency(tick_clocks, samples, lead, made, work)
    latency = _latency_clocks(made, work) + look_clocks(turns, surfaces)[1]
    if extra < natural:
        late = " and a sample" if made.pipeline else ""
        raise scene.refusal(
            f"controller.extra_ticks = {extra} is less than "
            f"`pins` needs: {latency} clocks{late} from sample to duty are {natural} ticks of "
            f"{tick_clocks} clocks; set extra_ticks = {natural} or more",
            "controller.extra_ticks",
        )
    if soonest != natural:
        raise scene.refusal(
            f"in contact with surfaces the voltage would come a tick of {tick_clocks} clocks later "
            "than in free space; take another controller.tick_hz or clock_hz",
            "controller.tick_hz",
            "controller.clock_hz",
        )
    return Timing(
        clock_hz, half_clocks, tick_clocks // half_clocks, tick_clocks // samples, samples,
        extra, extra - natural, latency, made,
    )  # fmt: skip


def dead_clocks(scene: Scene, clock_hz: float) -> int:
    """Dead time of the scene's drive in clocks; :class:`SceneError` where they are too many."""
    dead_s = scene.drive.dead_time_s if scene.drive else 0.0
    clocks = round(dead_s * clock_hz)
    if dead_s and not clocks:
        raise scene.refusal(
            f"drive.dead_time_s = {dead_s:g} s is less than half a clock of "
            f"`pins`, which would be none; take {1 / clock_hz:.3g} s or more, or leave it out",
            "drive.dead_time_s",
        )
    if clocks > MOST_DEAD_CLOCKS:
        raise scene.refusal(
            f"drive.dead_time_s = {dead_s:g} s is {clocks} "
            f"clocks of `pins`, which counts {MOST_DEAD_CLOCKS}; "
            f"take controller.clock_hz <= {MOST_DEAD_CLOCKS / dead_s:g}",
            "drive.dead_time_s",
            "controller.clock_hz",
        )
    return clocks


def pulse_delay(scene: Scene, clock_hz: float, half_clocks: int) -> int:
    """How late the pulse's middle is, in half clocks.

    Dead time delays it by half of itself. Where half the half is on at 0 V, an odd clock makes the
    end of a period the longer one (``rtl/wh_pwm.v``).
    """
    odd = half_clocks % 2 if bridge_mode(scene) in (LOCKED, HALF_BRIDGE) else 0
    return dead_clocks(scene, clock_hz) - odd
