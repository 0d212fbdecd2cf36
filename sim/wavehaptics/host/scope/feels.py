# SPDX-License-Identifier: Apache-2.0
"""Feels that the scope sets by one click: walls, η and W.

They fit any board. Places are fractions of the *span*, which is how far the wall's slider goes to
each side (0.2 rad, or 1000 counts), and count from the wall that the board had at first. Stiffness
is a fraction of the board's own rigid wall, damping one of k_T²/R̂. A thin wall pushes back with up
to the wall's stiffness times its width, and then lets go.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from wavehaptics.host.names import HostError

FAR = 5.0
"""Where a wall without end ends, in spans: 1 rad."""

LEAST_COUNTS = 2
"""Least width of a wall and least gap between two walls, counts."""

PLAY = 0.03
"""Free space to each side of a joystick's middle, spans. A spring begins where the rotor enters its
wall; with play both springs begin anew, at their faces, each time the rotor comes through."""

QUIET = 0.95
"""Largest η in free space behind a thin wall: less than 1 takes what rings after it let go."""


@dataclass(frozen=True)
class Feel:
    """One feel. W's values mean nothing where no wall is soft."""

    title: str
    meaning: str
    walls: tuple[tuple[float, float], ...] = ()
    """Both edges of each, in spans; the first wall that has the rotor wins."""
    soft: int = 0
    """How many of them, the first ones, have W; the others are rigid."""
    ridges: tuple[float, float] | None = None
    """In place of ``walls``: distance and width of thin walls, spans; as many as the board has."""
    start: tuple[float, float] = (-math.inf, math.inf)
    """Where the rotor has to be, spans: a wall that begins around a rotor would hold it there."""
    stiffness: float = 0.0
    damping: float = 0.0
    eta_contact: float = -1.0
    eta_free: float = 1.0
    """Largest η in free space; the board's own may be less."""


_LEFT = (-math.inf, 0.0)
FEELS = {
    "wall": Feel("Wall", "one rigid wall", ((0.0, FAR),), start=_LEFT),
    "stops": Feel("End stops", "two rigid walls", ((0.7, FAR), (-FAR, -0.7)), start=(-0.7, 0.7)),
    "soft": Feel("Soft wall", "a spring with a damper", ((0.0, FAR),), 1,
                 start=_LEFT, stiffness=0.2, damping=1.5),
    "layer": Feel("Soft layer", "a soft wall in front of a rigid one", ((0.0, 0.25), (0.25, FAR)),
                  1, start=_LEFT, stiffness=0.1, damping=0.5),
    "joystick": Feel("Joystick", "a spring towards the middle, between two stops",
                     ((PLAY, 0.7), (-0.7, -PLAY), (0.7, FAR), (-FAR, -0.7)), 2,
                     start=(-PLAY, PLAY), stiffness=0.05, damping=0.5),
    "detents": Feel("Detents", "thin walls: the torque climbs, then lets go",
                    ridges=(0.5, 0.01), eta_free=QUIET),
    "button": Feel("Push button", "a thin wall that gives way, and a rigid one behind it",
                   ((0.1, 0.12), (0.3, FAR)), start=(-math.inf, 0.1), eta_free=QUIET),
    "rough": Feel("Rough surface", "thin walls close together",
                  ridges=(0.08, 0.002), eta_free=QUIET),
    "honey": Feel("Honey", "a damper: its η is between rigid and free", ((-1.0, 1.0),),
                  eta_contact=-0.75),
}  # fmt: skip


def placed(feel: Feel, walls: int, span: float) -> list[tuple[int, int]]:
    """Both edges of each wall in counts from the board's own wall.

    ``walls``: how many the device has. ``span`` in counts. :class:`HostError` where there are too
    few walls, or the encoder is too coarse.
    """
    parts = feel.walls
    if feel.ridges is not None:
        distance, width = feel.ridges
        middles = [distance * (n - 0.5 * (walls - 1)) for n in range(max(2, walls))]
        parts = tuple((middle - 0.5 * width, middle + 0.5 * width) for middle in middles)
    if walls < len(parts):
        raise HostError(f"{feel.title}: it takes {len(parts)} walls, and the device has {walls}")
    firsts = [round(low * span) for low, _ in parts]
    found = [
        (first, max(round(high * span), first + LEAST_COUNTS))
        for first, (_, high) in zip(firsts, parts, strict=True)
    ]
    ordered = sorted(zip(found, parts, strict=True))
    for ((_, end), (_, ends)), ((begin, _), (begins, _)) in pairwise(ordered):
        if begin - end < (LEAST_COUNTS if begins > ends else 0):
            raise HostError(f"{feel.title}: the encoder is too coarse for it")
    return found
