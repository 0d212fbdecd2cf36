# SPDX-License-Identifier: Apache-2.0
"""A sheet of a schematic: symbols of schemdraw at given places, with the table's values.

Places are (x, y) in units of half an inch, y upwards. A sheet remembers what is joined to what, so
that what it shows can be compared with what is simulated.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Literal

import numpy as np
import schemdraw
from schemdraw import elements as elm
from schemdraw import logic
from schemdraw.segments import SegmentText
from schemdraw.types import Halign, Valign
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from wavetools.wiring.parts import Family, Table

Point = tuple[float, float]
Side = Literal["left", "right", "top", "bottom"]

_SIZE = 11.0
_SMALL = 9.5
_GREY = "#5a6472"
_AWAY = {"left": (-1, 0), "right": (1, 0), "top": (0, 1), "bottom": (0, -1)}


def _grid(point: Point) -> Point:
    """The place to a hundredth: what is closer is the same."""
    return round(point[0], 2), round(point[1], 2)


def _between(point: Point, start: Point, end: Point) -> bool:
    """Whether a point lies on a wire, its ends included."""
    along = np.subtract(end, start)
    to = np.subtract(point, start)
    length = float(np.hypot(*along))
    if length == 0:
        return point == start
    off = abs(float(along[0] * to[1] - along[1] * to[0])) / length
    return off < 0.01 and -0.01 <= float(np.dot(along, to)) / length <= length + 0.01


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
        self._wires: list[tuple[Point, Point]] = []
        self._dots: list[Point] = []
        self._ends: list[tuple[str, Point]] = []
        self._drawn: Counter[str] = Counter()
        self._table = table
        self._family = family
        self.drawing = schemdraw.Drawing(show=False)
        self.drawing.config(fontsize=_SIZE, font="sans-serif", lw=1.4, bgcolor="white", margin=1.0)

    def svg(self) -> str:
        return self.drawing.get_imagedata("svg").decode()

    # ---- What is joined.

    def _end(self, name: str, at: Point) -> None:
        """An end of a part, or the name of a net, at a place."""
        self._ends.append((name, at))

    def _numbered(self, reference: str) -> str:
        """``R4#2`` for the second R4 that is drawn."""
        self.shown.add(reference)
        self._drawn[reference] += 1
        return f"{reference}#{self._drawn[reference]}"

    def nets(self) -> list[frozenset[str]]:
        """What is joined: ends of parts (``R4#2.1``, ``U5A.HI``) and names of wires."""
        places = {_grid(point) for wire in self._wires for point in wire}
        places |= {_grid(at) for _, at in self._ends}
        index = {place: number for number, place in enumerate(sorted(places))}
        joined = [(index[_grid(a)], index[_grid(b)]) for a, b in self._wires]
        for dot in map(_grid, self._dots):
            joined += [
                (index[_grid(a)], index.setdefault(dot, len(index)))
                for a, b in self._wires
                if _between(dot, _grid(a), _grid(b))
            ]
        rows, columns = zip(*joined, strict=True)
        graph = coo_array((np.ones(len(joined)), (rows, columns)), shape=(len(index),) * 2)
        _, net_of = connected_components(graph, directed=False)
        nets: dict[int, set[str]] = defaultdict(set)
        # A name joins all places where it stands.
        named: dict[str, int] = {}
        for name, at in self._ends:
            net = int(net_of[index[_grid(at)]])
            first = named.setdefault(name, net)
            if first != net:
                net_of[net_of == net] = first
        for name, at in self._ends:
            nets[int(net_of[index[_grid(at)]])].add(name)
        return [frozenset(net) for net in nets.values()]

    def net_of(self, name: str) -> frozenset[str]:
        """All that is joined to an end or a name."""
        return next(net for net in self.nets() if name in net)

    def loose(self) -> list[Point]:
        """Places where a wire or a part ends at nothing, or at a wire without a dot."""
        count = Counter(_grid(point) for wire in self._wires for point in wire)
        count.update(_grid(at) for _, at in self._ends)
        dots = set(map(_grid, self._dots))
        return sorted(place for place, ends in count.items() if ends < 2 and place not in dots)

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
            self._wires.append((start, end))
            self.drawing += elm.Line().at(start).to(end)
        if dot:
            self.dot(points[-1])

    def dot(self, *points: Point) -> None:
        for point in points:
            self._dots.append(point)
            self.drawing += elm.Dot(radius=0.07).at(point)

    def ground(self, at: Point) -> None:
        self._end("ground", at)
        self.drawing += elm.Ground().at(at).theta(0)

    def rail(self, at: Point, name: str) -> None:
        """A supply, at the end of a wire that goes up to it."""
        x, y = at
        self._end(name, at)
        self.drawing += elm.Line().at((x - 0.3, y)).to((x + 0.3, y))
        self.text((x, y + 0.1), name, align="bottom")

    def tag(self, at: Point, name: str, side: Side) -> None:
        """A name where a wire leaves the sheet; ``side`` is where the name stands from ``at``."""
        dx, _ = _AWAY[side]
        self._end(name, at)
        self.drawing += elm.Dot(radius=0.07, open=True).at(at)
        self.text((at[0] + 0.2 * dx, at[1]), name, align="left" if side == "right" else "right")

    # ---- Parts of two ends.

    def _two(
        self, element: type[elm.Element2Term], reference: str, start: Point, end: Point, side: Side,
        text: str | None = None,
    ) -> None:  # fmt: skip
        self.drawing += element().at(start).to(end)
        name = self._numbered(reference)
        self._end(f"{name}.1", start)
        self._end(f"{name}.2", end)
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

    def resistor(
        self, reference: str, start: Point, end: Point, side: Side, text: str | None = None
    ) -> None:
        self._two(elm.ResistorIEC, reference, start, end, side, text)

    def capacitor(
        self, reference: str, start: Point, end: Point, side: Side, text: str | None = None
    ) -> None:
        self._two(elm.Capacitor, reference, start, end, side, text)

    def diode(
        self, reference: str, start: Point, end: Point, side: Side, text: str | None = None
    ) -> None:
        self._two(elm.Schottky, reference, start, end, side, text)

    def two_ended(
        self, element: type[elm.Element2Term], reference: str, start: Point, end: Point, side: Side,
        text: str | None = None,
    ) -> None:  # fmt: skip
        """Any other part of two ends: a fuse, a switch, a clamp."""
        self._two(element, reference, start, end, side, text)

    def switch(self, reference: str, start: Point, end: Point, name: str, kind: str) -> None:
        """A contact that is closed in normal use."""
        (x, y), (right, _) = start, end
        self.shown.add(reference)
        self._end(f"{name}.1", start)
        self._end(f"{name}.2", end)
        left, last = x + 0.4, right - 0.4
        self.drawing += elm.Line().at(start).to((left, y))
        self.drawing += elm.Line().at((last, y)).to(end)
        self.drawing += elm.Dot(radius=0.07, open=True).at((left, y))
        self.drawing += elm.Dot(radius=0.07, open=True).at((last, y))
        self.drawing += elm.Line().at((left, y + 0.07)).to((last + 0.15, y + 0.14))
        middle = (x + right) / 2
        self.text((middle, y + 0.3), name, align="bottom", small=True)
        self.text((middle, y - 0.2), kind, align="top", small=True, grey=True)

    def load(self, element: type[elm.Element2Term], name: str, start: Point, end: Point) -> None:
        """What is connected but is no part of the table, or bears its text elsewhere."""
        self._end(f"{name}.1", start)
        self._end(f"{name}.2", end)
        self.drawing += element().at(start).to(end)

    def terminal(self, *points: Point) -> None:
        """Free ends of a part that is not wired in."""
        for number, point in enumerate(points, 1):
            self._end(f"free {number}", point)
            self.drawing += elm.Dot(radius=0.07, open=True).at(point)

    def comparator(self, name: str, out: Point) -> dict[str, Point]:
        """A comparator with its output at ``out``, + above; the places of its ends."""
        symbol = elm.Opamp(leads=True).right().anchor("out").at(out).flip().scale(0.8)
        self.drawing += symbol
        self.text((out[0] - 1.35, out[1]), name, align="bottom", small=True)
        ends = {
            pin: (float(symbol.absanchors[anchor][0]), float(symbol.absanchors[anchor][1]))
            for pin, anchor in {"+": "in2", "−": "in1", "out": "out"}.items()
        }
        for pin, at in ends.items():
            self._end(f"{name}.{pin}", at)
        return ends

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
        self, reference: str, at: Point, *, unit: str = "", inputs: int = 2,
        pins: Sequence[str] = (), inverted: bool = False,
    ) -> tuple[list[Point], Point]:  # fmt: skip
        """An AND gate, or an ``inverted`` one, whose output is at ``at``.

        Returned are the places of its inputs, the upper first, and of the output. ``unit`` is its
        letter, ``pins`` are the numbers at inputs and output.
        """
        self.shown.add(reference)
        gate = (logic.Nand if inverted else logic.And)(inputs=inputs).right().anchor("out").at(at)
        self.drawing += gate
        anchors = [gate.absanchors[f"in{n + 1}"] for n in range(inputs)]
        places = [(float(x), float(y)) for x, y in anchors]
        if unit:
            self.text((at[0] - 0.65, at[1]), reference + unit, align="right", small=True)
        names = [f"in{n + 1}" for n in range(inputs)]
        for pin, place in zip([*names, "out"], [*places, at], strict=True):
            self._end(f"{reference}{unit}.{pin}", place)
        for place, number in zip([*places, at], pins, strict=False):
            sign = 1 if place == at else -1
            self.text(
                (place[0] - 0.02 * sign, place[1] + 0.05), number,
                align="bottom", small=True, grey=True,
            )  # fmt: skip
        return places, at

    def buffer(self, reference: str, at: Point) -> Point:
        """A Schmitt buffer whose input is at ``at``; the place of its output."""
        symbol = logic.Schmitt().right().at(at)
        self.drawing += symbol
        x, y = symbol.absanchors["end"]
        end = (float(x), float(y))
        self._end(f"{reference or 'buffer'}.in", at)
        self._end(f"{reference or 'buffer'}.out", end)
        if reference:
            text = self.value(reference)
            self.text((at[0] + 0.7, at[1] + 0.55), text, align="bottom", small=True)
        return end

    def box(
        self, reference: str, at: Point, size: Point, pins: Mapping[Side, Mapping[str, float]],
        *, unit: str = "", label: str = "", lead: float = 0.5,
    ) -> dict[str, Point]:  # fmt: skip
        """A rectangle with its lower left corner ``at``; the pins of a side stand at the given
        distances from its lower left, and the ends of their leads are returned. ``unit`` is its
        letter where there are several, ``label`` what stands in it."""
        self.shown.add(reference)
        (x, y), (width, height) = at, size
        self.drawing += elm.Rect(corner1=at, corner2=(x + width, y + height)).at((0, 0)).theta(0)
        self.text((x + width / 2, y + height / 2), label, align="bottom")
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
                self._end(f"{reference}{unit}.{pin}", end)
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
