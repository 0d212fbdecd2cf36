# SPDX-License-Identifier: Apache-2.0
"""A sheet of a schematic: symbols of schemdraw at given places, with the table's values.

Places are (x, y) in units of half an inch, y upwards. A sheet remembers which parts it shows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Literal

import schemdraw
from schemdraw import elements as elm
from schemdraw import logic
from schemdraw.segments import SegmentText
from schemdraw.types import Halign, Valign

from wavehaptics.wiring.parts import Family, Table

Point = tuple[float, float]
Side = Literal["left", "right", "top", "bottom"]

_SIZE = 11.0
_SMALL = 9.5
_GREY = "#5a6472"
_AWAY = {"left": (-1, 0), "right": (1, 0), "top": (0, 1), "bottom": (0, -1)}


class _Text(elm.Element):
    """Text at a place, without the distances that a label keeps from its symbol."""

    def __init__(
        self, text: str, align: tuple[Halign, Valign], fontsize: float, color: str
    ) -> None:
        super().__init__()
        self.segments.append(SegmentText((0, 0), text, align=align, fontsize=fontsize, color=color))


class Sheet:
    """What is drawn on it goes into ``drawing``; ``shown`` are the references of its parts."""

    def __init__(self, title: str, table: Table, family: Family | None = None) -> None:
        schemdraw.use("svg")
        schemdraw.svgconfig.text = "text"
        schemdraw.svgconfig.useBatik = True  # not every viewer knows dominant-baseline
        self.title = title
        self.shown: set[str] = set()
        self._table = table
        self._family = family
        self.drawing = schemdraw.Drawing(show=False)
        self.drawing.config(fontsize=_SIZE, font="sans-serif", lw=1.4, bgcolor="white", margin=0.3)

    def svg(self) -> str:
        return self.drawing.get_imagedata("svg").decode()

    # ---- Text.

    def text(
        self, at: Point, text: str, *, align: Side = "left", small: bool = False, grey: bool = False
    ) -> None:
        """``align`` is the side of the text that ``at`` is at; ``top`` and ``bottom`` centre it."""
        across: Halign = "left" if align == "left" else "right" if align == "right" else "center"
        up: Valign = "top" if align == "top" else "bottom" if align == "bottom" else "center"
        self.drawing += (
            _Text(text, (across, up), _SMALL if small else _SIZE, _GREY if grey else "black")
            .at(at)
            .theta(0)
        )

    def value(self, reference: str, *, one_line: bool = False) -> str:
        """Reference and value, as they stand at a symbol."""
        self.shown.add(reference)
        gap = " " if one_line else "\n"
        return f"{reference}{gap}{self._table.text(reference, self._family)}"

    # ---- Wires.

    def wire(self, *points: Point, dot: bool = False) -> None:
        for start, end in pairwise(points):
            self.drawing += elm.Line().at(start).to(end)
        if dot:
            self.dot(points[-1])

    def dot(self, *points: Point) -> None:
        for point in points:
            self.drawing += elm.Dot(radius=0.07).at(point)

    def ground(self, at: Point) -> None:
        self.drawing += elm.Ground().at(at).theta(0)

    def rail(self, at: Point, name: str) -> None:
        """A supply, at the end of a wire that goes up to it."""
        x, y = at
        self.drawing += elm.Line().at((x - 0.3, y)).to((x + 0.3, y))
        self.text((x, y + 0.1), name, align="bottom")

    def tag(self, at: Point, name: str, side: Side) -> None:
        """A name where a wire leaves the sheet; ``side`` is where the name stands from ``at``."""
        dx, _ = _AWAY[side]
        self.drawing += elm.Dot(radius=0.07, open=True).at(at)
        self.text((at[0] + 0.2 * dx, at[1]), name, align="left" if side == "right" else "right")

    # ---- Parts of two ends.

    def _between(
        self, element: type[elm.Element2Term], reference: str, start: Point, end: Point, side: Side,
        text: str | None = None,
    ) -> None:  # fmt: skip
        self.drawing += element().at(start).to(end)
        middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        dx, dy = _AWAY[side]
        reach = 0.38
        opposite: dict[Side, Side] = {
            "left": "right", "right": "left", "top": "bottom", "bottom": "top"
        }  # fmt: skip
        upright = side in ("left", "right")
        self.text(
            (middle[0] + reach * dx, middle[1] + reach * dy),
            self.value(reference, one_line=not upright) if text is None else text,
            align=opposite[side],
            small=True,
        )
        self.shown.add(reference)

    def resistor(
        self, reference: str, start: Point, end: Point, side: Side, text: str | None = None
    ) -> None:
        self._between(elm.ResistorIEC, reference, start, end, side, text)

    def capacitor(
        self, reference: str, start: Point, end: Point, side: Side, text: str | None = None
    ) -> None:
        self._between(elm.Capacitor, reference, start, end, side, text)

    def diode(
        self, reference: str, start: Point, end: Point, side: Side, text: str | None = None
    ) -> None:
        self._between(elm.Schottky, reference, start, end, side, text)

    def two_ended(
        self, element: type[elm.Element2Term], reference: str, start: Point, end: Point, side: Side,
        text: str | None = None,
    ) -> None:  # fmt: skip
        """Any other part of two ends: a fuse, a switch, a clamp."""
        self._between(element, reference, start, end, side, text)

    def switch(self, reference: str, start: Point, end: Point, name: str, kind: str) -> None:
        """A contact that is closed in normal use."""
        (x, y), (right, _) = start, end
        self.shown.add(reference)
        left, last = x + 0.4, right - 0.4
        self.wire(start, (left, y))
        self.wire((last, y), end)
        self.drawing += elm.Dot(radius=0.07, open=True).at((left, y))
        self.drawing += elm.Dot(radius=0.07, open=True).at((last, y))
        self.drawing += elm.Line().at((left, y + 0.07)).to((last + 0.15, y + 0.14))
        middle = (x + right) / 2
        self.text((middle, y + 0.3), name, align="bottom", small=True)
        self.text((middle, y - 0.2), kind, align="top", small=True, grey=True)

    def terminal(self, *points: Point) -> None:
        """Free ends of a part that is not wired in."""
        for point in points:
            self.drawing += elm.Dot(radius=0.07, open=True).at(point)

    def comparator(self, name: str, out: Point) -> dict[str, Point]:
        """A comparator with its output at ``out``, + above; the places of its ends."""
        symbol = elm.Opamp(leads=True).right().anchor("out").at(out).flip().scale(0.8)
        self.drawing += symbol
        self.text((out[0] - 1.35, out[1]), name, align="bottom", small=True)
        ends = {"+": "in2", "−": "in1", "out": "out"}
        return {
            pin: (float(symbol.absanchors[anchor][0]), float(symbol.absanchors[anchor][1]))
            for pin, anchor in ends.items()
        }

    def pull_down(self, reference: str, at: Point, side: Side = "right") -> None:
        """From a point on a wire down to ground."""
        x, y = at
        self.dot(at)
        self.resistor(reference, (x, y), (x, y - 1.3), side)
        self.ground((x, y - 1.3))

    def to_ground(self, reference: str, at: Point, side: Side = "right") -> None:
        """A capacitor from a point on a wire down to ground."""
        x, y = at
        self.dot(at)
        self.capacitor(reference, (x, y), (x, y - 1.3), side)
        self.ground((x, y - 1.3))

    # ---- Parts of many ends.

    def gate(
        self, text: str, at: Point, inputs: int = 2, reference: str | None = None,
        pins: Sequence[str] = (),
    ) -> tuple[list[Point], Point]:  # fmt: skip
        """An AND gate whose output is at ``at``; the places of its inputs, the upper first, and of
        the output. ``pins`` are the numbers at inputs and output."""
        if reference:
            self.shown.add(reference)
        gate = logic.And(inputs=inputs).right().anchor("out").at(at)
        self.drawing += gate
        places = [tuple(gate.absanchors[f"in{n + 1}"]) for n in range(inputs)]
        self.text((at[0] - 0.65, at[1]), text, align="top", small=True)
        for place, number in zip([*places, at], pins, strict=False):
            sign = 1 if place == at else -1
            self.text(
                (place[0] - 0.02 * sign, place[1] + 0.05), number,
                align="bottom", small=True, grey=True,
            )  # fmt: skip
        return [(float(x), float(y)) for x, y in places], at

    def buffer(self, reference: str, at: Point) -> Point:
        """A Schmitt buffer whose input is at ``at``; the place of its output."""
        symbol = logic.Schmitt().right().at(at)
        self.drawing += symbol
        end = symbol.absanchors["end"]
        if reference:
            text = self.value(reference)
            self.text((at[0] + 0.7, at[1] + 0.55), text, align="bottom", small=True)
        return float(end[0]), float(end[1])

    def box(
        self, name: str, at: Point, size: Point, pins: Mapping[Side, Mapping[str, float]],
        reference: str | None = None, lead: float = 0.5,
    ) -> dict[str, Point]:  # fmt: skip
        """A rectangle with its lower left corner ``at``; the pins of a side stand at the given
        distances from its lower left, and the ends of their leads are returned."""
        if reference:
            self.shown.add(reference)
        (x, y), (width, height) = at, size
        self.drawing += elm.Rect(corner1=at, corner2=(x + width, y + height)).at((0, 0)).theta(0)
        self.text((x + width / 2, y + height / 2), name, align="bottom")
        ends: dict[str, Point] = {}
        for side, places in pins.items():
            dx, dy = _AWAY[side]
            for pin, along in places.items():
                if side in ("left", "right"):
                    edge = (x if side == "left" else x + width, y + along)
                else:
                    edge = (x + along, y if side == "bottom" else y + height)
                end = (edge[0] + lead * dx, edge[1] + lead * dy)
                self.drawing += elm.Line().at(edge).to(end)
                align: dict[Side, Side] = {
                    "left": "left", "right": "right", "top": "top", "bottom": "bottom"
                }  # fmt: skip
                self.text(
                    (edge[0] - 0.12 * dx, edge[1] - 0.12 * dy), pin.strip(),
                    align=align[side], small=True,
                )  # fmt: skip
                ends[pin] = end
        return ends

    def frame(self, corner: Point, opposite: Point, text: str) -> None:
        """A dashed frame around what belongs together."""
        self.drawing += (
            elm.Rect(corner1=corner, corner2=opposite)
            .at((0, 0))
            .theta(0)
            .linestyle("--")
            .color(_GREY)
        )
        x, y = min(corner[0], opposite[0]), max(corner[1], opposite[1])
        self.text((x + 0.15, y - 0.25), text, align="left", small=True, grey=True)
