# SPDX-License-Identifier: Apache-2.0
"""From the delays that nextpnr wrote: an ADC's round trip at the pads, and the gates' skew.

A bit is launched by SCLK at the pad, and is read when SCLK's next edge of the kind is made; that of
a modulator where ``wh_sinc3`` takes it. So a period of SCLK, or that time, holds: clock to pad, the
wire there, the converter's access time, the wire back, and pad to flip-flop. nextpnr knows the way
between flip-flop and pad, not the pad's own buffer, whose times are here, each at its slowest.
"""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from wavehaptics.parts.adcs import Frame, Modulator, Part


class PadTimingError(ValueError):
    """A path that isn't there, or a margin that is negative. The message is one line."""


@dataclass(frozen=True)
class PadTimes:
    """A family's pads, ns: buffers beside routed logic, and with registers in the I/O cell.

    ``out_registered`` is from the clock to the pad, ``in_registered`` the set-up time at the pad.
    """

    out: float
    back: float
    out_registered: float
    in_registered: float


PAD_TIMES: dict[str, PadTimes] = {
    # Project IceStorm, icefuzz/timings_up5k.txt and timings_hx8k.txt, slowest figures: PRE_IO and
    # IO_PAD from DOUT0 to the pin and from the pin to DIN0; with registers PADOUT after OUTPUTCLK,
    # and PADIN before INPUTCLK.
    "up5k": PadTimes(3.12, 1.08, 3.88, 4.77),
    "hx8k": PadTimes(4.59, 1.21, 2.49, 2.48),
    # ECP5 family data sheet, speed 6, "external switching characteristics", 4.1 and 0.85 ns from
    # notes made of it. Beside routed logic the same figures, which the registers are part of.
    "ecp5": PadTimes(4.1, 0.85, 4.1, 0.85),
}
"""By device, or by family."""

_TOKEN = re.compile(
    r'\(CELLTYPE "(?P<type>[^"]+)"\)\s*\(INSTANCE (?P<instance>[^\s)]*)\s*\)'
    r"|\(INTERCONNECT (?P<source>\S+)/(?P<out>\w+) (?P<sink>\S+)/(?P<into>\w+) (?P<wire>\([^)]*\))"
    r"|\(IOPATH (?:\((?:pos|neg)edge )?(?P<start>\w+)\)? (?P<end>\w+) "
    r"(?P<delay>\([^)]*\) \([^)]*\))"
    r"|\(SETUPHOLD \((?:pos|neg)edge (?P<data>\w+)\) \((?:pos|neg)edge \w+\) (?P<setup>\([^)]*\))"
)
_CLOCKS = ("CLK", "CLOCK")
_REGISTERED = ("IOLOGIC", "SIOLOGIC")
_PADS = ("TRELLIS_IO", "SB_IO")


def _slowest_ns(text: str) -> float:
    return max(float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", text)) / 1000


@dataclass(frozen=True)
class Way:
    """A way between flip-flop and pad as nextpnr routed it, ns."""

    registered: bool
    ns: float


class Delays:
    """Delays of a placed design, from the file that nextpnr writes for ``--sdf``."""

    def __init__(self, sdf: str) -> None:
        self._types: dict[str, str] = {}
        self._drivers: dict[tuple[str, str], tuple[str, str, float]] = {}
        self._loads: dict[str, list[tuple[str, str, str, float]]] = defaultdict(list)
        self._through: dict[str, list[tuple[str, str, float]]] = defaultdict(list)
        self._setups: dict[tuple[str, str], float] = {}
        instance = ""
        for found in _TOKEN.finditer(sdf.replace("\\", "")):
            if found["type"]:
                instance = found["instance"]
                self._types[instance] = found["type"]
            elif found["source"]:
                wire = _slowest_ns(found["wire"])
                source, out, sink, into = (found[key] for key in ("source", "out", "sink", "into"))
                self._drivers[sink, into] = (source, out, wire)
                self._loads[source].append((out, sink, into, wire))
            elif found["start"]:
                self._through[instance].append(
                    (found["start"], found["end"], _slowest_ns(found["delay"]))
                )
            else:
                key = instance, found["data"]
                self._setups[key] = max(self._setups.get(key, 0.0), _slowest_ns(found["setup"]))

    @classmethod
    def of_file(cls, path: Path) -> Delays:
        return cls(path.read_text(encoding="utf-8"))

    def _pad(self, port: str) -> str:
        for name, kind in self._types.items():
            if kind in _PADS and re.fullmatch(re.escape(port) + r"\$(tr|sb)_io", name):
                return name
        raise PadTimingError(f"nextpnr's delays have no pad for {port}")

    def to_pad(self, port: str) -> Way:
        """From the clock to the pad of an output, or to its I/O cell's register."""
        pad = self._pad(port)
        ways = [(into, found) for (sink, into), found in self._drivers.items() if sink == pad]
        if not ways:
            raise PadTimingError(f"nothing drives the pad of {port}")
        slowest = 0.0
        for _, (source, out, wire) in ways:
            if self._types.get(source) in _REGISTERED:
                return Way(True, 0.0)
            slowest = max(slowest, wire + self._arrival(source, out))
        return Way(False, slowest)

    def _arrival(self, instance: str, out: str) -> float:
        """From the clock until ``out`` changes; 0 where it doesn't come from a flip-flop."""
        slowest = 0.0
        for start, end, delay in self._through[instance]:
            if end != out:
                continue
            if start in _CLOCKS:
                slowest = max(slowest, delay)
            elif (instance, start) in self._drivers:
                source, pin, wire = self._drivers[instance, start]
                slowest = max(slowest, delay + wire + self._arrival(source, pin))
        return slowest

    def from_pad(self, port: str) -> Way:
        """From the pad of an input to the flip-flops behind it, set-up time included."""
        pad = self._pad(port)
        loads = self._loads[pad]
        if not loads:
            raise PadTimingError(f"the pad of {port} drives nothing")
        if any(self._types.get(sink) in _REGISTERED for _, sink, _, _ in loads):
            return Way(True, 0.0)
        slowest = max(self._behind(pad, out) for out in {load[0] for load in loads})
        if slowest == -math.inf:
            raise PadTimingError(f"no flip-flop takes {port}")
        return Way(False, slowest)

    def _behind(self, instance: str, out: str) -> float:
        """From ``out`` to the flip-flops behind it; minus infinity where there is none."""
        slowest = -math.inf
        for pin, sink, into, wire in self._loads[instance]:
            if pin != out:
                continue
            if (sink, into) in self._setups:
                slowest = max(slowest, wire + self._setups[sink, into])
            for start, end, delay in self._through[sink]:
                if start == into:
                    slowest = max(slowest, wire + delay + self._behind(sink, end))
        return slowest


@dataclass(frozen=True)
class AdcBudget:
    """An ADC's round trip, ns: what a period of SCLK holds, and what it leaves.

    ``hold_ns`` is what is left at the other end of a bit, pads and wires taken to be without delay.
    """

    sclk_mhz: float
    registered: bool
    available_ns: float
    out_ns: float
    wire_ns: float
    access_ns: float
    back_ns: float
    margin_ns: float
    hold_ns: float


def adc_budget(
    delays: Delays, device: str, family: str, part: Part | Modulator, made: Frame, clock_hz: float,
    wire_s: float, lines: Iterable[str], clocks: Iterable[str] = ("adc_sclk",),
) -> AdcBudget:  # fmt: skip
    """The round trip of a placed board's converters.

    From SCLK's outputs ``clocks`` to the inputs ``lines``; ``wire_s`` is one way's.
    :class:`PadTimingError` where no time is left.
    """
    times = PAD_TIMES.get(device) or PAD_TIMES[family]
    outs = [delays.to_pad(clock) for clock in clocks]
    backs = [delays.from_pad(line) for line in lines]
    registered = bool(made.pad_clocks)
    if any(way.registered != registered for way in (*outs, *backs)):
        raise PadTimingError(
            "registers in the I/O cells of the ADC's pins are not what pad_registers in fpga.toml "
            "says; take wh_board_adc_pads_ecp5 in the top and set it, or neither"
        )
    out_ns = max(times.out_registered if out.registered else out.ns + times.out for out in outs)
    back_ns = max(
        times.in_registered if back.registered else back.ns + times.back for back in backs
    )
    available_clocks = (
        made.taken_clocks if isinstance(part, Modulator) else made.bit_clocks * part.periods
    )
    available_ns = 1e9 * available_clocks / clock_hz
    taken_ns = out_ns + 2e9 * wire_s + 1e9 * part.access_s + back_ns
    budget = AdcBudget(
        sclk_mhz=round(clock_hz / made.bit_clocks / 1e6, 2),
        registered=registered,
        available_ns=round(available_ns, 2),
        out_ns=round(out_ns, 2),
        wire_ns=round(2e9 * wire_s, 2),
        access_ns=round(1e9 * part.access_s, 2),
        back_ns=round(back_ns, 2),
        margin_ns=round(available_ns - taken_ns, 2),
        hold_ns=round(1e9 * part.data_hold_s, 2),
    )
    if budget.margin_ns < 0:
        raise PadTimingError(
            f"the {part.name}'s bits come {-budget.margin_ns:g} ns too late: clock to pad "
            f"{out_ns:.1f}, wires {budget.wire_ns:g}, access {budget.access_ns:g}, pad to "
            f"flip-flop {back_ns:.1f} ns of {available_ns:.1f} ns; lower controller.clock_hz"
            + ("" if registered else ", or take registers at the pads (pad_registers)")
        )
    return budget


def gate_skew_ns(delays: Delays, motors: int, legs: int = 2) -> float:
    """Most by which the two gates of a leg differ from clock to pad, ns; their pads are alike."""
    skew = 0.0
    for motor in range(motors):
        place = f"[{motor}]" if motors > 1 else ""
        for leg in "abc"[:legs]:
            high, low = (delays.to_pad(f"gate_{leg}{side}{place}") for side in "hl")
            skew = max(skew, abs(high.ns - low.ns))
    return round(skew, 2)
