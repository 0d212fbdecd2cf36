# SPDX-License-Identifier: Apache-2.0
"""The converters of the current: what their makers say, and the reader's settings that follow.

One table for the tests' models of the parts, the simulation at the pins, the boards' bitstreams and
the README. Figures are from HARDWARE notes made of the data sheets, unless a part's comment says
where else they come from: a figure *from memory* or *taken* must be looked up before a design leans
on it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

Kind = Literal["serial", "command", "sigma_delta"]

KINDS: tuple[Kind, ...] = ("serial", "command", "sigma_delta")
"""Readers in the order of ``wh_controller``'s parameter ADC: ``wh_adc_serial``,
``wh_adc_max11125``, ``wh_sinc3``."""

FRAME_WORDS = (
    "sclk_half_clocks", "frame_bits", "lead_bits", "data_bits", "quiet_clocks", "setup_clocks",
    "hold_clocks", "calibrate_bits", "sclk_idle", "read_trailing",
)  # fmt: skip
"""Settings of a frame, in the order of ``wh_adc_serial``'s ports."""

SINC_CLOCKS = 4
"""Clocks from a start to the word in ``wh_sinc3``."""

SINC_PIPELINE = 2
"""Starts from the one that a word of ``wh_sinc3`` belongs to, to the one that brings it."""

PIPELINES: dict[Kind, int] = {"serial": 0, "command": 1, "sigma_delta": SINC_PIPELINE}
"""Starts from the one that holds the input to the one that brings its word, of each reader."""

WANTED_OSR = 16
"""Fewest bits that are made a word where there is a choice."""

SLACK_S = 1e-12
"""Times are sums of periods in binary: a picosecond is not a violation."""


class PartError(ValueError):
    """A clock that a part can't be read with. The message is one line."""


@dataclass(frozen=True)
class Part:
    """A converter with a serial port, by its data sheet; times in s.

    A frame is ``frame_bits`` pulses of SCLK away from its level ``idle``: edge 1 is the first after
    CS has fallen, the odd edges are leading, the even ones trailing. CS puts out bit 1, and launch
    edge k (a leading one, or a trailing one where ``launch_trailing`` is set) puts out bit k + 1;
    with ``launch_late`` it puts out bit k.
    """

    name: str
    bits: int
    rate_hz: float
    """The maker's throughput."""
    sclk_hz: float
    duty: float
    """Least part of SCLK's period that it is high, and low."""
    idle: int
    launch_trailing: bool
    read_trailing: bool
    """On which edge the reader takes a bit: in the very clock that makes the edge, so before the
    part sees it."""
    lead_bits: int
    """Bits that are read before the data."""
    frame_bits: int
    setup_s: float
    """CS's fall to edge 1, least."""
    hold_s: float
    """Last edge to CS's rise, least."""
    cs_high_s: float
    release_s: float
    """From the last leading edge until the output is let go, most."""
    quiet_s: float
    """From there to CS's fall, least."""
    acquire_s: float
    """From edge ``track_edge``, where the input is followed again, to CS's fall, least."""
    track_edge: int
    cs_access_s: float
    """CS's fall to bit 1, most."""
    access_s: float
    """Launch edge to the next bit, most."""
    kind: Kind = "serial"
    calibrate_bits: int = 0
    """Pulses in the first frame after power-up, with which the part measures its own offset."""
    pipeline: int = 0
    """Frames from the one whose CS holds the input to the one that brings its code."""
    launch_late: bool = False
    data_hold_s: float = 0.0
    """Launch edge to the end of the bit before, least."""

    @property
    def periods(self) -> float:
        """Of SCLK, from the edge that launches a bit to the one at which it is read."""
        late = self.launch_trailing != self.read_trailing
        return 0.5 if late else 1.0


@dataclass(frozen=True)
class Modulator:
    """A sigma-delta modulator, by its data sheet; it answers to its clock's rises.

    ``linear`` is the part of full scale, where it clips, up to which it is linear; full scale is
    ± ``full_scale_v`` at its input.
    """

    name: str
    least_hz: float
    most_hz: float
    level_s: float
    """Least time that the clock is high, and low."""
    access_s: float
    """A rise of the clock to the new bit, most."""
    data_hold_s: float
    """A rise of the clock to the end of the old bit, least."""
    full_scale_v: float = 0.32
    linear: float = 0.25 / 0.32
    bits: int = 16
    """Of a word: the filter's, not the modulator's."""
    kind: Kind = "sigma_delta"


@dataclass(frozen=True)
class Frame:
    """Settings of the readers, in clocks; the names are those of ``wh_adc_serial``'s ports.

    Of a modulator's, ``osr`` bits make a word; the settings of frames mean nothing to it.
    """

    sclk_half_clocks: int
    frame_bits: int
    lead_bits: int
    data_bits: int
    setup_clocks: int = 1
    hold_clocks: int = 0
    quiet_clocks: int = 2
    calibrate_bits: int = 0
    sclk_idle: int = 1
    read_trailing: int = 0
    kind: Kind = "serial"
    pipeline: int = 0
    osr: int = 0
    pad_clocks: int = 0
    """Registers between the reader and the pads of CS and SCLK; SDATA comes through as many."""

    @property
    def bit_clocks(self) -> int:
        """A period of SCLK."""
        return 2 * self.sclk_half_clocks

    @property
    def unity(self) -> float:
        """Word of full scale, in parts of 2¹⁵."""
        return self.osr**3 / (1 << (self.osr**3 - 1).bit_length()) if self.osr else 1.0

    @property
    def taken_clocks(self) -> int:
        """Of a modulator: from the clock's rise at its pad until the bit of it is taken there.

        ``wh_sinc3`` takes one as its clock falls.
        """
        return (self.sclk_half_clocks - 2 * self.pad_clocks - 1) % self.bit_clocks + 1

    @property
    def cycle_clocks(self) -> int:
        """From one start to the soonest next; of a modulator, to the next."""
        if self.osr:
            return self.osr * self.bit_clocks
        pulses = (2 * self.frame_bits - 1) * self.sclk_half_clocks
        return self.setup_clocks + pulses + self.hold_clocks + max(1, self.quiet_clocks)

    @property
    def conversion_clocks(self) -> int:
        """From the start strobe to the word's strobe, of the frame that brings the word."""
        if self.osr:
            return SINC_CLOCKS
        bits = self.lead_bits + self.data_bits
        edge = 2 * bits - (0 if self.read_trailing else 1)
        return 1 + self.setup_clocks + (edge - 1) * self.sclk_half_clocks

    def words(self) -> dict[str, int]:
        """The ports' words."""
        return {name: getattr(self, name) for name in FRAME_WORDS}


def _ad(name: str, bits: int, lead: int, frame: int, **figures: Any) -> Part:
    """A part of the AD7476A's kind: SCLK idles high, its falls launch and are read at."""
    return Part(
        name=name, bits=bits, idle=1, launch_trailing=False, read_trailing=False, lead_bits=lead,
        frame_bits=frame, hold_s=0.0, duty=0.4, **figures,
    )  # fmt: skip


# AD7276, rev. C: timing examples 1 and 2 (t2 6 ns, 12.5 periods of SCLK, then t_ACQ 60 ns; CS high
# at the 14th rise gives 3 MSPS), t_QUIET 4 ns. Access times 15 ns, the data's hold time 5 ns and
# the shortest CS high 3 ns from memory. The AD7277 and AD7278 follow their input again 2 and 4
# periods sooner (from memory; the AD7478A's page says the same of its own frame).
_AD7276 = {
    "sclk_hz": 48e6, "setup_s": 6e-9, "cs_high_s": 3e-9, "release_s": 14e-9, "quiet_s": 4e-9,
    "acquire_s": 60e-9, "cs_access_s": 15e-9, "access_s": 15e-9, "data_hold_s": 5e-9,
}  # fmt: skip

PARTS: dict[str, Part] = {
    part.name: part
    for part in (
        # AD7476A, rev. F: timing table and timing example 1 (t_ACQ 250 ns from 12.5 periods on).
        _ad("AD7476A", 12, 4, 16, rate_hz=1e6, sclk_hz=20e6, setup_s=10e-9, cs_high_s=10e-9,
            release_s=36e-9, quiet_s=50e-9, acquire_s=250e-9, track_edge=26,
            cs_access_s=22e-9, access_s=40e-9, data_hold_s=7e-9),
        _ad("AD7276", 12, 2, 14, rate_hz=3e6, track_edge=26, **_AD7276),
        _ad("AD7277", 10, 2, 12, rate_hz=3e6, track_edge=22, **_AD7276),
        _ad("AD7278", 8, 2, 10, rate_hz=3e6, track_edge=18, **_AD7276),
        # ADS7042: frame and rate of the notes; 16 MHz, 12.5 periods of conversion, t_ACQ 200 ns,
        # set-up 15 ns and 30 ns of access from memory. Its duty is that of its family (ADS7028,
        # ADS7066: 45 %).
        Part(
            name="ADS7042", bits=12, rate_hz=1e6, sclk_hz=16e6, duty=0.45, idle=0,
            launch_trailing=True, read_trailing=True, lead_bits=2, frame_bits=14, setup_s=15e-9,
            hold_s=10e-9, cs_high_s=10e-9, release_s=0.0, quiet_s=0.0,
            acquire_s=200e-9, track_edge=26, cs_access_s=30e-9, access_s=30e-9,
        ),
        # ADS7046, ADS7052, ADS7056: frames and rates of the notes (MSB launched by the rise after
        # the first fall, 15 or 18 falls). Acquisition times are taken from the rate: what it leaves
        # of a cycle beside the frame. Set-up, hold and access times from memory of the family; the
        # ADS7046's 60 MHz and its launch edge are taken to be the ADS7056's.
        Part(
            name="ADS7046", bits=12, rate_hz=3e6, sclk_hz=60e6, duty=0.45, idle=0,
            launch_trailing=False, read_trailing=False, lead_bits=2, frame_bits=15, setup_s=7e-9,
            hold_s=0.8e-9, cs_high_s=10e-9, release_s=0.0, quiet_s=0.0,
            acquire_s=75e-9, track_edge=30, cs_access_s=12e-9, access_s=12e-9,
        ),
        Part(
            name="ADS7052", bits=14, rate_hz=1e6, sclk_hz=24e6, duty=0.45, idle=0,
            launch_trailing=False, read_trailing=False, lead_bits=2, frame_bits=18, setup_s=7e-9,
            hold_s=0.8e-9, cs_high_s=10e-9, release_s=0.0, quiet_s=0.0,
            acquire_s=230e-9, track_edge=36, cs_access_s=12e-9, access_s=12e-9, calibrate_bits=24,
        ),
        Part(
            name="ADS7056", bits=14, rate_hz=2.5e6, sclk_hz=60e6, duty=0.45, idle=0,
            launch_trailing=False, read_trailing=False, lead_bits=2, frame_bits=18, setup_s=7e-9,
            hold_s=0.8e-9, cs_high_s=10e-9, release_s=0.0, quiet_s=0.0,
            acquire_s=95e-9, track_edge=36, cs_access_s=12e-9, access_s=12e-9, calibrate_bits=24,
        ),
        # MAX11123/MAX11125: words, mode, 16 clocks and 4 to 15 ns of the notes. The result comes in
        # the frame after the one that holds the input. CS times from memory (4, 1, 5 ns).
        *(
            Part(
                name=name, bits=bits, rate_hz=1e6, sclk_hz=16e6, duty=0.4, idle=1,
                launch_trailing=False, read_trailing=True, lead_bits=1, frame_bits=16,
                setup_s=4e-9, hold_s=1e-9, cs_high_s=5e-9, release_s=0.0, quiet_s=0.0,
                acquire_s=0.0, track_edge=32, cs_access_s=15e-9, access_s=15e-9,
                kind="command", pipeline=1, launch_late=True, data_hold_s=4e-9,
            )
            for name, bits in (("MAX11125", 12), ("MAX11123", 10))
        ),
    )
}  # fmt: skip
"""Converters by name."""


def _clocks(seconds: float, clock_hz: float) -> int:
    """Whole clocks that last ``seconds`` or longer."""
    return max(0, math.ceil((seconds - SLACK_S) * clock_hz))


def frame(part: Part, clock_hz: float, pad_registers: bool = False) -> Frame:
    """The part's fastest frame on a clock.

    ``pad_registers``: CS, SCLK and SDATA pass a register each between the reader and the pads, so
    that the bits come two clocks late. At an SCLK of half the clock that is one pulse, which is
    taken for a further zero in front.
    """
    half = max(1, _clocks(0.5 / part.sclk_hz, clock_hz))
    setup = max(1, _clocks(part.setup_s, clock_hz))
    hold = _clocks(part.hold_s, clock_hz)
    end = setup + (2 * part.frame_bits - 1) * half + hold
    tracking = setup + (part.track_edge - 1) * half
    released = setup + (2 * part.frame_bits - 2) * half
    quiet = max(
        1,
        _clocks(part.cs_high_s, clock_hz),
        released + _clocks(part.release_s + part.quiet_s, clock_hz) - end,
        tracking + _clocks(part.acquire_s, clock_hz) - end,
        _clocks(1 / part.rate_hz, clock_hz) - end,
    )
    made = Frame(
        sclk_half_clocks=half, frame_bits=part.frame_bits, lead_bits=part.lead_bits,
        data_bits=part.bits, setup_clocks=setup, hold_clocks=hold, quiet_clocks=quiet,
        calibrate_bits=part.calibrate_bits, sclk_idle=part.idle,
        read_trailing=int(part.read_trailing), kind=part.kind, pipeline=part.pipeline,
    )  # fmt: skip
    if pad_registers:
        if half != 1 or part.kind != "serial":
            raise PartError(
                f"{part.name} at a clock of {clock_hz:g} Hz: registers at the pads need a part "
                f"without commands, and SCLK at half the clock instead of 1/{2 * half}"
            )
        made = replace(
            made, lead_bits=made.lead_bits + 1, frame_bits=made.frame_bits + 1, pad_clocks=1
        )
    for name, word in made.words().items():
        if word >= (64 if name.endswith("bits") else 256):
            raise PartError(f"{part.name} at a clock of {clock_hz:g} Hz: {name} = {word}")
    return made


MODULATORS: dict[str, Modulator] = {
    part.name: part
    for part in (
        # AMC1306M25: clock and levels of the notes; the least 20 ns high and low are the AMC1106's
        # (SBAS789B), the access time of 15 ns the AMC1305's (the maker's forum), the hold time of
        # 3.5 ns from memory.
        Modulator("AMC1306M25", 5e6, 21e6, 20e-9, 15e-9, 3.5e-9),
        # AD7403: 5 to 20 MHz, access and hold from memory.
        Modulator("AD7403", 5e6, 20e6, 20e-9, 30e-9, 10e-9),
    )
}
"""Modulators by name."""

ALL_BITS: dict[str, int] = {name: part.bits for name, part in (PARTS | MODULATORS).items()}
"""Bits of the words of every converter that a scene may name."""


def modulator_frame(
    part: Modulator, clock_hz: float, tick_clocks: int, pad_registers: bool = False
) -> Frame:
    """The modulator at its fastest, and the bits of a word such that whole words fill a tick.

    ``pad_registers``: its clock and its bits pass a register each at the pads.
    """
    half = max(_clocks(0.5 / part.most_hz, clock_hz), _clocks(part.level_s, clock_hz))
    period = 2 * half
    bits = tick_clocks // period
    if clock_hz / period < part.least_hz or tick_clocks % period or bits < 4:
        raise PartError(
            f"{part.name} at a clock of {clock_hz:g} Hz: a tick of {tick_clocks} clocks is not a "
            f"whole number of bits of {period} clocks, at least four"
        )
    words = max(
        n for n in range(1, bits + 1) if bits % n == 0 and (n == 1 or bits >= WANTED_OSR * n)
    )
    osr = bits // words
    if osr > 256:
        osr = max((n for n in range(4, 257) if bits % n == 0), default=0)
    if not osr:
        raise PartError(
            f"{part.name} at a clock of {clock_hz:g} Hz: a tick of {tick_clocks} clocks has {bits} "
            "bits, which no word of 4 to 256 bits divides"
        )
    return Frame(
        sclk_half_clocks=half, frame_bits=part.bits, lead_bits=0, data_bits=part.bits,
        sclk_idle=0, kind="sigma_delta", pipeline=SINC_PIPELINE, osr=osr,
        pad_clocks=int(pad_registers),
    )  # fmt: skip


def frame_of_words(words: Mapping[str, int], kind: Kind, sample_clocks: int) -> Frame:
    """What :meth:`Frame.words` were made of, whose words come ``sample_clocks`` apart."""
    own = {name: words[name] for name in FRAME_WORDS}
    period = 2 * own["sclk_half_clocks"]
    osr = sample_clocks // period if kind == "sigma_delta" else 0
    return Frame(**own, kind=kind, pipeline=PIPELINES[kind], osr=osr)


def plain_frame(lead_bits: int, data_bits: int) -> Frame:
    """The frame of a converter without a name: as the AD7276, at half the clock."""
    return Frame(
        sclk_half_clocks=1,
        frame_bits=lead_bits + data_bits,
        lead_bits=lead_bits,
        data_bits=data_bits,
    )
