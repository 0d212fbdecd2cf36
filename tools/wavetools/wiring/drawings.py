# SPDX-License-Identifier: Apache-2.0
"""The schematic of what hangs on a board, in sheets that a person can wire from."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path

from schemdraw import elements as elm
from wavehaptics.runtime.files import write_text
from wavehaptics.runtime.repository import ROOT

from wavetools.wiring.parts import FAMILY_NAMES, Family, Table, load_table
from wavetools.wiring.sheet import Point, Sheet, Side

FOLDER = Path("docs", "wiring")
"""Where the pictures are kept, from the root."""


def _enable(s: Sheet, table: Table, third: str, *, inverted: bool = False) -> Point:
    """The charge pump of ``alive``, Schmitt buffer, supervisor and U3; the place of its output.

    ``third`` is what U3's third input gets. U3 is a NAND gate where it is ``inverted``.
    """
    y = 3.2
    s.tag((0.4, y), "alive", "left")
    s.pull_down("R3", (1.2, y))
    s.resistor("R1", (1.9, y), (3.4, y), "top")
    s.wire((0.4, y), (1.9, y))
    s.capacitor("C1", (3.4, y), (4.9, y), "top")
    s.diode("D1", (4.9, y - 1.3), (4.9, y), "right", f"D1\n{table.text('D1')}\n(half)")
    s.ground((4.9, y - 1.3))
    s.dot((4.9, y))
    s.diode("D1", (4.9, y), (7.2, y), "top", "D1 (other half)")
    s.to_ground("C2", (7.6, y))
    s.wire((7.2, y), (10.6, y))
    s.pull_down("R2", (9.3, y))
    s.text((8.5, y + 0.2), "pass", align="bottom", small=True)
    clean = s.buffer("U1", (10.6, y))
    (top, middle, bottom), out = s.gate("U3", (17.0, y - 0.5), inputs=3, inverted=inverted)
    s.wire(clean, (clean[0], top[1]), top)
    s.text((16.3, y + 0.25), s.value("U3"), align="bottom", small=True)
    # The supervisor and the overcurrent.
    supervisor = s.box(
        "U2", (10.3, -0.9), (2.4, 1.1),
        {"right": {"RESET": 0.55}, "left": {"VCC": 0.75, "GND": 0.25}},
    )  # fmt: skip
    s.text((11.5, -1.05), s.value("U2", one_line=True), align="top", small=True)
    s.wire(supervisor["RESET"], (14.1, -0.35), (14.1, middle[1]), middle)
    s.wire(supervisor["VCC"], (9.3, -0.15), (9.3, 0.1))
    s.rail((9.3, 0.1), "3.3 V")
    s.wire(supervisor["GND"], (9.3, -0.65), (9.3, -0.8))
    s.ground((9.3, -0.8))
    s.wire(bottom, (14.7, bottom[1]), (14.7, 1.0), (15.2, 1.0))
    s.tag((15.2, 1.0), third, "right")
    return out


def gates(table: Table, family: Family) -> Sheet:
    """From the FPGA's pins through the AND gates to HI and LI, and what opens them."""
    s = Sheet(f"Gates of a motor and the charge pump, {FAMILY_NAMES[family]}", table, family)
    s.text((-1.4, 18.3), s.title)
    names = (("gate_ah", "HI of U5A (4)"), ("gate_al", "LI of U5A (5)"),
             ("gate_bh", "HI of U5B (4)"), ("gate_bl", "LI of U5B (5)"))  # fmt: skip
    numbers = (("1", "2", "3"), ("4", "5", "6"), ("9", "10", "8"), ("12", "13", "11"))
    bus_x = 4.4
    for row, ((signal, to), pins) in enumerate(zip(names, numbers, strict=True)):
        y = 16.2 - 2.7 * row
        s.tag((0.4, y), signal, "left")
        (upper, lower), out = s.gate("U4", (7.6, y - 0.25), unit="abcd"[row], pins=pins)
        s.wire((0.4, y), (upper[0], y), upper)
        s.pull_down("R4", (1.9, y))
        s.wire((bus_x, lower[1]), lower)
        s.dot((bus_x, lower[1]))
        s.wire(out, (11.6, out[1]))
        s.pull_down("R5", (9.6, out[1]))
        s.tag((11.6, out[1]), to, "right")
    s.wire((bus_x, 15.7), (bus_x, 7.6))
    s.text((4.25, 6.0), "enable", align="right", small=True)
    s.dot((bus_x, 7.3))
    s.wire((bus_x, 7.3), (5.2, 7.3))
    s.resistor("R21", (5.2, 7.3), (5.2, 6.25), "right")
    s.ground((5.2, 6.25))
    s.frame((-1.6, 17.4), (8.2, 5.5), "FPGA's side: U4 beside the FPGA board, R4 and R21 at it")
    s.frame((8.9, 17.4), (14.5, 5.5), "bridge's side: at the half bridges")
    out = _enable(s, table, "overcurrent_n, or 3.3 V without it")
    s.wire(out, (17.5, out[1]), (17.5, 5.2), (bus_x, 5.2), (bus_x, 7.6))
    # Decoupling.
    for x, reference, where in (
        (16.6, "C4", "at 14 and 7 of U4"),
        (20.0, "C3", "at each of U1, U2, U3"),
    ):
        s.wire((x, 11.0), (x, 10.7))
        s.rail((x, 11.0), "3.3 V")
        s.capacitor(reference, (x, 10.7), (x, 9.4), "right")
        s.ground((x, 9.4))
        s.text((x, 8.55), where, align="top", small=True)
    s.text((15.4, 16.4), f"U4 {table.text('U4')}: one for each motor.\n"
           "All else below the gates once for a board;\nenable goes to the U4 of every motor.\n"
           "U1 to U4 from the FPGA board's 3.3 V.", align="left", small=True)  # fmt: skip
    s.shown.add("U4")
    return s


def power(table: Table) -> Sheet:
    """Bus and gate supply, with what switches them off, and where the grounds meet."""
    s = Sheet("Bus, gate supply, emergency stop and ground", table)
    s.text((-0.6, 7.9), s.title)
    y = 6.4
    source = s.box("PS1", (-0.4, 4.6), (2.1, 2.2), {"right": {"+": 1.8, "−": 0.4}}, label="PS1")
    s.text((0.65, 5.6), "bench supply\nwith a limit", align="top", small=True)
    s.wire(source["+"], (3.0, y))
    s.switch("S1", (3.0, y), (5.0, y), "S1a", "break contact")
    s.two_ended(elm.FuseIEC, "F1", (5.6, y), (7.6, y), "top", "F1 2 A; 5 A for three")
    s.wire((5.0, y), (5.6, y))
    s.resistor("R9", (5.6, y - 1.2), (7.6, y - 1.2), "bottom")
    s.terminal((5.6, y - 1.2), (7.6, y - 1.2))
    s.text((6.6, y - 0.35), "in F1's place at first", align="top", small=True, grey=True)
    s.wire((7.6, y), (16.6, y))
    s.dot((9.4, y))
    s.two_ended(elm.Zener, "D2", (9.4, y - 1.5), (9.4, y), "left")
    s.ground((9.4, y - 1.5))
    s.dot((11.5, y))
    s.capacitor("C8", (11.5, y), (11.5, y - 1.5), "right", s.value("C8") + "\n(each motor)")
    s.ground((11.5, y - 1.5))
    s.text((11.2, y - 0.55), "+", align="right", small=True)
    s.dot((14.6, y))
    s.resistor("R20", (14.6, y), (14.6, y - 1.5), "right", s.value("R20") + "\n(each motor)")
    s.ground((14.6, y - 1.5))
    s.tag((16.6, y), "VBUS of every bridge", "right")
    s.wire(source["−"], (2.6, 5.0))
    s.ground((2.6, 5.0))
    y = 2.6
    gate = s.box("PS2", (-0.4, 0.8), (2.1, 2.2), {"right": {"+": 1.8, "−": 0.4}}, label="PS2")
    s.text((0.65, 1.8), "5 V ± 5 %", align="top", small=True)
    s.wire(gate["+"], (3.0, y))
    s.dot((2.6, y))
    s.wire((2.6, y), (2.6, 3.7), (3.0, 3.7))
    s.tag((3.0, 3.7), "supply of an encoder of 5 V", "right")
    s.switch("S1", (3.0, y), (5.0, y), "S1b", "break contact")
    s.wire((5.0, y), (16.6, y))
    s.tag((16.6, y), "5 V of every bridge (VCC)", "right")
    s.wire(gate["−"], (2.6, 1.2))
    s.ground((2.6, 1.2))
    s.text((5.6, 1.9), "S1c is at the input stop, on the sheet of the inputs.\n"
           "The button opens all three contacts and stays open until it is turned.",
           align="left", small=True)  # fmt: skip
    # The star.
    x, y = 4.6, -2.9
    s.text(
        (-0.6, -0.4),
        "Ground: one point, at the bridges' bus capacitors C8; a wire of its own to each",
    )
    for dy, name in (
        (1.5, "− of PS1, thick"),
        (0.5, "PGND of the half bridges, thick; AGND joined to it there"),
        (-0.5, "− of PS2"),
        (-1.5, "FPGA board, beside the gates' wires"),
    ):
        s.wire((x, y), (x + 1.6, y + dy), (x + 2.4, y + dy))
        s.tag((x + 2.4, y + dy), name, "right")
    s.dot((x, y))
    s.wire((x, y), (x - 0.6, y))
    s.ground((x - 0.6, y))
    s.text((x - 1.1, y), "star", align="right")
    s.text((x + 2.6, y - 2.2), "U1 to U4 and U7 to U11 have their ground at the FPGA board: a\n"
           "ground wire beside each signal's, and this one wire from there to the star.",
           align="left", small=True)  # fmt: skip
    return s


def bridge(table: Table) -> Sheet:
    """The two half bridges of a motor, the shunt and the motor."""
    s = Sheet("Bridge of a motor: two half bridges, shunt and motor", table)
    s.text((-2.6, 16.6), s.title)
    for leg, base in (("A", 8.6), ("B", 0.0)):
        high, low = f"gate_{leg.lower()}h", f"gate_{leg.lower()}l"
        pins = s.box(
            "U5", (3.0, base + 1.2), (4.2, 3.6),
            {
                "left": {"HI": 2.6, "LI": 1.6, "AGND": 0.6},
                "top": {"VCC": 1.1, "VIN": 3.3},
                "right": {"HB": 2.9, "HS": 2.2, "SW": 1.2},
                "bottom": {"PGND": 3.0},
            },
            unit=leg, lead=0.6,
        )  # fmt: skip
        s.text((5.1, base + 3.1), f"U5{leg}\n{table.text('U5')}", align="top")
        numbers = {"HI": "4", "LI": "5", "AGND": "7", "VCC": "6", "VIN": "1",
                   "HB": "2", "HS": "3", "SW": "8", "PGND": "9"}  # fmt: skip
        for pin, (x, y) in pins.items():
            if pin in ("VCC", "VIN", "PGND"):
                s.text((x - 0.1, y + (0.3 if pin == "PGND" else -0.3)), numbers[pin],
                       align="right", small=True, grey=True)  # fmt: skip
            else:
                right = pin in ("HB", "HS", "SW")
                s.text((x + (-0.3 if right else 0.3), y + 0.06), numbers[pin],
                       align="bottom", small=True, grey=True)  # fmt: skip
        for pin, signal in (("HI", high), ("LI", low)):
            x, y = pins[pin]
            s.wire((x, y), (0.9, y))
            s.tag((0.9, y), f"U4, of {signal}", "left")
        s.wire(pins["AGND"], (2.0, pins["AGND"][1]))
        s.ground((2.0, pins["AGND"][1]))
        # Gate supply and its capacitor.
        x, y = pins["VCC"]
        s.wire((x, y), (x, y + 1.2))
        s.rail((x, y + 1.2), "5 V, from S1b")
        s.wire((x, y + 0.9), (2.0, y + 0.9))
        s.dot((x, y + 0.9))
        s.capacitor("C6", (2.0, y + 0.9), (2.0, y - 0.4), "left")
        s.ground((2.0, y - 0.4))
        # Bus and its capacitors.
        x, y = pins["VIN"]
        s.wire((x, y), (x, y + 1.2))
        s.rail((x, y + 1.2), "VBUS")
        s.wire((x, y + 0.9), (9.2, y + 0.9))
        s.dot((x, y + 0.9))
        s.capacitor("C7", (9.2, y + 0.9), (9.2, y - 0.4), "right",
                    f"C7 2 × {table.text('C7')}, VIN to PGND, within 5 mm")  # fmt: skip
        s.shown.add("C7")
        s.ground((9.2, y - 0.4))
        # Bootstrap.
        (x, top), (_, bottom) = pins["HB"], pins["HS"]
        s.capacitor("C5", (x + 0.35, top), (x + 0.35, bottom), "right",
                    s.value("C5", one_line=True))  # fmt: skip
        s.wire((x, top), (x + 0.35, top))
        s.wire((x, bottom), (x + 0.35, bottom))
        s.ground(pins["PGND"])
    # Shunt and motor.
    y = 8.6 + 1.2 + 1.2
    s.wire((7.8, y), (10.2, y))
    s.resistor("R6", (10.2, y), (13.2, y), "top")
    s.wire((13.2, y), (16.0, y), (16.0, 8.0))
    for x, name in ((10.2, "IN+ of U7"), (13.2, "IN− of U7")):
        s.dot((x, y))
        s.wire((x, y), (x, y - 1.0))
        s.tag((x, y - 1.0), name, "right")
    s.text((11.7, y - 1.65), "a pair of thin wires from the shunt's own ends", align="top",
           small=True, grey=True)  # fmt: skip
    s.load(elm.Motor, "motor", (16.0, 8.0), (16.0, 5.4))
    s.text((16.8, 6.7), "motor", align="left")
    s.text((16.2, y - 0.5), "lead A", align="left", small=True)
    s.text((16.2, 4.2), "lead B", align="left", small=True)
    s.wire((16.0, 5.4), (16.0, 2.4), (7.8, 2.4))
    s.text((9.3, 7.6), "A current from SW of U5A through R6\ninto lead A is positive.",
           align="left", small=True)  # fmt: skip
    return s


def sense(table: Table) -> Sheet:
    """The current of a motor: amplifier and ADC, and the comparators for those who build them."""
    s = Sheet("Current of a motor", table)
    s.text((-1.8, 12.9), s.title)
    amplifier = s.box(
        "U7", (1.6, 5.8), (3.4, 3.4),
        {
            "left": {"IN+": 2.7, "IN−": 1.9, "REF1": 1.1, "REF2": 0.4},
            "top": {"VS": 1.7}, "right": {"OUT": 2.3}, "bottom": {"GND": 1.7},
        },
        label="U7",
    )  # fmt: skip
    s.text((3.3, 7.4), f"{table.text('U7')}\n{table.current.gain:g} V/V", align="top", small=True)
    for pin, name in (("IN+", "R6, the bridge's end"), ("IN−", "R6, the motor's end")):
        s.wire(amplifier[pin], (0.6, amplifier[pin][1]))
        s.tag((0.6, amplifier[pin][1]), name, "left")
    s.wire(amplifier["REF1"], (0.6, 6.9))
    s.tag((0.6, 6.9), "3.3 V", "left")
    s.wire(amplifier["REF2"], (0.6, 6.2))
    s.ground((0.6, 6.2))
    s.ground(amplifier["GND"])
    s.wire(amplifier["VS"], (3.3, 11.0))
    s.rail((3.3, 11.0), "3.3 V")
    s.wire((3.3, 10.7), (5.6, 10.7))
    s.dot((3.3, 10.7))
    s.capacitor("C9", (5.6, 10.7), (5.6, 9.4), "right")
    s.ground((5.6, 9.4))
    y = amplifier["OUT"][1]
    s.wire(amplifier["OUT"], (6.4, y))
    s.resistor("R7", (6.4, y), (8.0, y), "top")
    s.dot((5.9, y))
    adc = s.box(
        "U8", (11.4, 6.4), (3.4, 2.6),
        {
            "left": {"VIN": 1.7}, "top": {"VDD": 1.7}, "bottom": {"GND": 1.7},
            "right": {"CS": 2.2, "SCLK": 1.3, "SDATA": 0.4},
        },
        label="U8",
    )  # fmt: skip
    s.text((13.1, 7.55), table.text("U8"), align="top", small=True)
    s.wire((8.0, y), adc["VIN"])
    s.to_ground("C10", (8.5, y), "left")
    s.pull_down("R23", (10.0, y))
    s.ground(adc["GND"])
    s.wire(adc["VDD"], (13.1, 11.7))
    s.rail((13.1, 11.7), "3.3 V")
    s.wire((13.1, 11.4), (20.4, 11.4))
    s.dot((13.1, 11.4), (14.7, 11.4))
    for x, pin in ((16.6, "CS"), (18.2, "SCLK")):
        s.wire((x, 11.4), (x, 10.6))
        s.resistor("R19", (x, 10.6), (x, 9.2), "right")
        s.wire((x, 9.2), (x, adc[pin][1]))
        s.dot((x, 11.4), (x, adc[pin][1]))
    for x, reference in ((14.7, "C12"), (20.4, "C11")):
        s.capacitor(reference, (x, 11.4), (x, 10.1), "right")
        s.ground((x, 10.1))
    ends: tuple[tuple[str, str, Side], ...] = (
        ("CS", "adc_cs_n", "top"),
        ("SCLK", "adc_sclk", "bottom"),
    )
    for pin, name, side in ends:
        y_pin = adc[pin][1]
        s.wire(adc[pin], (18.8, y_pin))
        s.resistor("R8", (18.8, y_pin), (20.6, y_pin), side)
        s.tag((20.6, y_pin), name, "right")
    s.wire(adc["SDATA"], (20.6, adc["SDATA"][1]))
    s.tag((20.6, adc["SDATA"][1]), "adc_sdata", "right")
    s.text((18.3, 6.2), "R8 at the FPGA's end", align="left", small=True, grey=True)
    # The option: overcurrent in hardware.
    upper = s.comparator("U9a", (9.0, 1.7))
    lower = s.comparator("U9b", (9.0, -0.7))
    s.shown.add("U9")
    high, low = upper["+"][1], lower["−"][1]
    s.rail((2.2, high + 1.4), "3.3 V")
    s.resistor("R14", (2.2, high + 1.4), (2.2, high), "left")
    s.resistor("R15", (2.2, high), (2.2, low), "left")
    s.resistor("R14", (2.2, low), (2.2, low - 1.4), "left")
    s.ground((2.2, low - 1.4))
    s.dot((2.2, high), (2.2, low))
    s.wire((2.2, high), upper["+"])
    s.wire((2.2, low), lower["−"])
    s.wire((5.9, y), (5.9, lower["+"][1]), lower["+"])
    s.wire((5.9, upper["−"][1]), upper["−"])
    s.dot((5.9, upper["−"][1]))
    s.text((7.7, -1.9), f"U9 {table.text('U9')}", align="top", small=True)
    s.wire(upper["out"], (10.4, 1.7), (10.4, -0.7), lower["out"])
    s.dot((10.4, 1.7))
    s.wire((10.4, 1.7), (10.4, 1.9))
    s.resistor("R16", (10.4, 1.9), (10.4, 3.2), "left")
    s.wire((10.4, 3.2), (10.4, 3.4))
    s.rail((10.4, 3.4), "3.3 V")
    latch = s.box(
        "U10", (12.2, -0.3), (3.0, 2.8),
        {"left": {"CLR": 2.0, "D": 1.2, "CLK": 0.5}, "right": {"Q": 1.3}, "top": {"PRE": 1.5}},
    )  # fmt: skip
    s.text((13.9, 1.1), f"U10\n{table.text('U10')}", align="top", small=True)
    s.wire((10.4, 1.7), latch["CLR"])
    s.wire(latch["D"], (11.4, latch["D"][1]), (11.4, latch["CLK"][1]), latch["CLK"])
    s.wire((11.4, latch["CLK"][1]), (11.4, -0.3))
    s.dot((11.4, latch["CLK"][1]))
    s.ground((11.4, -0.3))
    s.wire(latch["PRE"], (13.7, 3.2), (15.0, 3.2))
    s.tag((15.0, 3.2), "RESET of U2", "right")
    s.wire(latch["Q"], (16.2, latch["Q"][1]))
    s.tag((16.2, latch["Q"][1]), "overcurrent_n, to U3", "right")
    s.frame((-1.8, 4.5), (20.6, -3.5), "option: overcurrent shuts the gates until 3.3 V goes")
    s.text((10.9, -2.3), "several motors: the outputs of all U9 joined at one R16\n"
           f"U10 once for a board; {s.value('C14', one_line=True)} at each U9, "
           f"{s.value('C15', one_line=True)} at U10\n"
           "U9 and U10 on 3.3 V; a ULX3S also has a pin overcurrent_n",
           align="left", small=True)  # fmt: skip
    return s


def inputs(table: Table) -> Sheet:
    """Encoder, stop and start."""
    s = Sheet("Inputs: encoder, stop, start", table)
    s.text((-2.2, 9.4), s.title)
    s.text((-2.2, 8.6), "Encoder of 3.3 V (A; B alike)", grey=True)
    s.tag((0.4, 6.2), "encoder's A", "left")
    s.wire((0.4, 6.2), (4.0, 6.2))
    s.tag((4.0, 6.2), "enc_a", "right")
    s.dot((2.2, 6.2))
    s.resistor("R13", (2.2, 6.2), (2.2, 7.5), "right")
    s.wire((2.2, 7.5), (2.2, 7.7))
    s.rail((2.2, 7.7), "3.3 V")
    s.text((7.4, 8.6), "Encoder of 5 V (A; B alike): never without one of these", grey=True)
    s.tag((10.0, 6.9), "encoder's A, 0 to 5 V", "left")
    s.resistor("R11", (10.4, 6.9), (12.0, 6.9), "top")
    s.wire((10.0, 6.9), (10.4, 6.9))
    s.wire((12.0, 6.9), (14.4, 6.9))
    s.pull_down("R12", (12.8, 6.9))
    s.tag((14.4, 6.9), "enc_a, 0 to 3.3 V", "right")
    s.tag((10.0, 4.3), "encoder's A, 0 to 5 V", "left")
    end = s.buffer("", (11.2, 4.3))
    s.wire((10.0, 4.3), (11.2, 4.3))
    s.dot((10.6, 4.3))
    s.resistor("R22", (10.6, 4.3), (10.6, 5.5), "right")
    s.rail((10.6, 5.5), "3.3 V")
    s.wire(end, (14.4, 4.3))
    s.tag((14.4, 4.3), "enc_a, 0 to 3.3 V", "right")
    half, beside = s.value("U11", one_line=True), s.value("C16", one_line=True)
    s.text((10.0, 3.4), f"or half of {half} on 3.3 V, {beside} at it", align="left", small=True)
    s.text((-2.2, 3.4), "Stop", grey=True)
    s.tag((4.0, 1.0), "stop", "right")
    s.wire((4.0, 1.0), (0.0, 1.0))
    s.dot((0.9, 1.0))
    s.resistor("R10", (0.9, 1.0), (0.9, 2.3), "right")
    s.wire((0.9, 2.3), (0.9, 2.5))
    s.rail((0.9, 2.5), "3.3 V")
    s.to_ground("C13", (2.6, 1.0))
    s.switch("S1", (-2.0, 1.0), (0.0, 1.0), "S1c", "break contact")
    s.wire((-2.0, 1.0), (-2.0, 0.6))
    s.ground((-2.0, 0.6))
    s.text((7.4, 2.6), "Start, where the board has no button", grey=True)
    s.tag((15.6, 1.0), "start_n", "right")
    s.dot((14.2, 1.0))
    s.resistor("R17", (14.2, 1.0), (14.2, 2.3), "right")
    s.wire((14.2, 2.3), (14.2, 2.4))
    s.rail((14.2, 2.4), "3.3 V")
    s.load(elm.Button, "S2", (10.4, 1.0), (13.4, 1.0))
    s.wire((13.4, 1.0), (15.6, 1.0))
    s.text((11.9, 1.7), s.value("S2", one_line=True), align="bottom", small=True)
    s.wire((10.4, 1.0), (10.4, 0.6))
    s.ground((10.4, 0.6))
    s.text((-2.2, -1.5), "Light for a fault, where the board has none (Colorlight i5)", grey=True)
    s.tag((0.4, -2.8), "led_fault", "left")
    s.wire((0.4, -2.8), (0.8, -2.8))
    s.resistor("R18", (0.8, -2.8), (2.4, -2.8), "top")
    s.load(elm.LED, "LED", (2.4, -2.8), (4.0, -2.8))
    s.text((2.6, -3.2), "red; its shorter leg to ground", align="top", small=True)
    s.wire((4.0, -2.8), (5.4, -2.8), (5.4, -3.2))
    s.ground((5.4, -3.2))
    s.text((7.4, -1.5), "Host MCU of 3.3 V on SPI, where the board has the pins (ULX3S)", grey=True)
    for row, (signal, at) in enumerate((("spi_cs_n", "CS"), ("spi_sclk", "SCLK"),
                                        ("spi_mosi", "MOSI"), ("spi_miso", "MISO"))):  # fmt: skip
        y = -2.4 - 0.7 * row
        s.tag((10.0, y), signal, "left")
        if signal == "spi_miso":
            s.wire((10.0, y), (10.6, y))
            s.resistor("R24", (10.6, y), (12.2, y), "bottom")
            s.wire((12.2, y), (12.8, y))
        else:
            s.wire((10.0, y), (12.8, y))
        s.tag((12.8, y), f"{at} of the MCU", "right")
    return s


def boostxl(table: Table) -> Sheet:
    """The wires between an FPGA board, a BOOSTXL-3PHGANINV and a PmodAD1."""
    s = Sheet("Three boards: FPGA, BOOSTXL-3PHGANINV and PmodAD1", table, "ecp5")
    s.text((-1.4, 18.3), s.title)
    ways = {"40 PWM_AH": "gate_ah", "39 PWM_AL": "gate_al", "38 PWM_BH": "gate_bh",
            "37 PWM_BL": "gate_bl", "36 PWM_CH": "gate_ch", "35 PWM_CL": "gate_cl",
            "13 nEn_uC": "nEn_uC", "27 IA": "IA", "28 IB": "IB"}  # fmt: skip
    board = s.box(
        "PB", (3.4, 6.4), (6.4, 9.8),
        {
            "left": {pin: 9.2 - 0.9 * row for row, pin in enumerate(ways)} | {"20, 22 GND": 0.6},
            "right": {"VA": 7.0, "VB": 6.0, "VC": 5.0},
            "top": {"J4 +": 2.0, "J4 −": 4.4},
        },
    )  # fmt: skip
    s.text((7.0, 8.9), s.value("PB"), align="top", small=True)
    inside = [s.value(name, one_line=True) for name in ("U4", "R4", "R5", "R6", "U7", "C8")]
    s.text((6.0, 12.3), "on it:\n" + "\n".join(inside), align="left", small=True, grey=True)
    for pin, name in ways.items():
        s.tag(board[pin], name, "left")
    s.wire(board["20, 22 GND"], (2.4, board["20, 22 GND"][1]))
    s.ground((2.4, board["20, 22 GND"][1]))
    for lead in "ABC":
        s.tag(board[f"V{lead}"], f"lead {lead.lower()} of the motor", "right")
    s.wire(board["J4 −"], (board["J4 −"][0], 17.0), (9.2, 17.0))
    s.ground((9.2, 17.0))
    s.tag(board["J4 +"], "VBUS", "left")
    # The bus.
    y = 16.4
    source = s.box("PS1", (14.2, 14.6), (2.1, 2.2), {"right": {"+": 1.8, "−": 0.4}}, label="PS1")
    s.text((15.25, 15.6), "12 V with\na limit", align="top", small=True)
    s.wire(source["+"], (17.6, y))
    s.switch("S1", (17.6, y), (19.6, y), "S1a", "break contact")
    s.two_ended(elm.FuseIEC, "F1", (20.2, y), (22.2, y), "top", "F1 4 A")
    s.wire((19.6, y), (20.2, y))
    s.resistor("R9", (20.2, y - 1.2), (22.2, y - 1.2), "bottom")
    s.terminal((20.2, y - 1.2), (22.2, y - 1.2))
    s.text((21.2, y - 0.35), "in F1's place at first", align="top", small=True, grey=True)
    s.wire((22.2, y), (26.2, y))
    s.dot((24.2, y))
    s.two_ended(elm.Zener, "D2", (24.2, y - 1.5), (24.2, y), "left")
    s.ground((24.2, y - 1.5))
    s.tag((26.2, y), "VBUS", "right")
    s.wire(source["−"], (17.2, 15.0))
    s.ground((17.2, 15.0))
    # The converters.
    adc = s.box(
        "U8", (20.2, 6.6), (3.8, 4.6),
        {
            "left": {"1 CS": 3.9, "2 D0": 2.9, "3 D1": 1.9, "4 SCLK": 0.9},
            "right": {"A0": 3.4, "A1": 1.9}, "top": {"6 VCC": 1.0}, "bottom": {"5 GND": 1.9},
        },
    )  # fmt: skip
    s.text((22.1, 9.4), s.value("U8"), align="top", small=True)
    s.ground(adc["5 GND"])
    s.wire(adc["6 VCC"], (21.2, 13.2))
    s.rail((21.2, 13.2), "3.3 V")
    s.wire((21.2, 12.9), (16.2, 12.9))
    s.dot((21.2, 12.9), (18.0, 12.9))
    sclk, chosen = adc["4 SCLK"][1], adc["1 CS"][1]
    for x, y_pin in ((18.0, chosen), (16.2, sclk)):
        s.wire((x, 12.9), (x, 12.6))
        s.resistor("R19", (x, 12.6), (x, 11.3), "left")
        s.wire((x, 11.3), (x, y_pin))
        s.dot((x, y_pin))
    sides: tuple[tuple[str, str, float, Side], ...] = (
        ("1 CS", "adc_cs_n", 17.6, "bottom"),
        ("4 SCLK", "adc_sclk", 15.8, "bottom"),
    )
    for pin, name, x, side in sides:
        y_pin = adc[pin][1]
        s.wire(adc[pin], (x, y_pin))
        s.resistor("R8", (x - 1.6, y_pin), (x, y_pin), side)
        s.tag((x - 1.6, y_pin), name, "left")
    for pin, name in (("2 D0", "adc_sdata[0]"), ("3 D1", "adc_sdata[1]")):
        s.tag(adc[pin], name, "left")
    for pin, name in (("A0", "IA"), ("A1", "IB")):
        y_pin = adc[pin][1]
        s.wire(adc[pin], (27.4, y_pin))
        s.pull_down("R23", (25.4 if name == "IA" else 26.6, y_pin))
        s.tag((27.4, y_pin), name, "right")
    # What enables the gates.
    out = _enable(s, table, "3.3 V", inverted=True)
    s.wire(out, (17.6, out[1]))
    s.switch("S1", (17.6, out[1]), (19.6, out[1]), "S1b", "break contact")
    s.tag((19.6, out[1]), "nEn_uC", "right")
    s.wire((23.4, 3.6), (23.4, 3.3))
    s.rail((23.4, 3.6), "3.3 V")
    s.capacitor("C3", (23.4, 3.3), (23.4, 2.0), "right")
    s.ground((23.4, 2.0))
    s.text((22.6, 1.2), "at each of U1, U2, U3", align="left", small=True)
    beside = "beside the FPGA board, on its 3.3 V: what pulls nEn_uC low while alive changes"
    s.frame((-1.6, 5.2), (26.0, -1.9), beside)
    five = s.value("PS2", one_line=True)
    s.text((16.6, -0.7), f"Encoder (its 5 V from {five}) and stop (S1c):\n"
           "sheet of the inputs. PB has 3.3 V of its own: join grounds alone.",
           align="left", small=True)  # fmt: skip
    return s


SHEETS: dict[str, Callable[[Table], Sheet]] = {
    "gates_ice40": lambda table: gates(table, "ice40"),
    "gates_ecp5": lambda table: gates(table, "ecp5"),
    "power": power,
    "bridge": bridge,
    "sense": sense,
    "inputs": inputs,
}
"""Sheets by the names of their files."""

POWER_BOARDS: dict[str, Callable[[Table], Sheet]] = {"boostxl": boostxl}
"""The sheet of each power board that has a table of its own, by its name."""


def texts(svg: str) -> list[str]:
    """All text of a picture, sorted: what a sheet says, whatever it looks like."""
    found = [(element.text or "").strip() for element in ElementTree.fromstring(svg).iter()]
    return sorted(text for text in found if text)


def lines(svg: str) -> list[tuple[float, ...]]:
    """All lines of a picture as rounded numbers, sorted: where its wires and symbols are."""
    paths = (element.get("d") for element in ElementTree.fromstring(svg).iter())
    return sorted(
        tuple(round(float(number), 1) for number in re.findall(r"-?[\d.]+(?:e-?\d+)?", path))
        for path in paths
        if path
    )


def write(table: Table, root: Path = ROOT) -> list[Path]:
    """Draw every sheet into ``docs/wiring``."""
    drawn = {name: draw(table) for name, draw in SHEETS.items()}
    drawn |= {name: draw(load_table(root, name)) for name, draw in POWER_BOARDS.items()}
    paths = []
    for name, sheet in drawn.items():
        path = root / FOLDER / f"{name}.svg"
        write_text(path, sheet.svg() + "\n")
        paths.append(path.relative_to(root))
    return paths
