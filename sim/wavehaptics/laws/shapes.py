# SPDX-License-Identifier: Apache-2.0
"""Solids that a tip touches: how deep a point is inside, and which way is inwards.

A depth is above 0 inside and below 0 outside; the normal is a unit vector into the solid, across
the nearest part of its surface. Both are of many points at a time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class Shape:
    """A ``plane``, ``sphere`` or ``box``.

    ``point`` (3,) in m is a point of the plane, or the middle of the others. ``normal`` (3,) is the
    plane's, out of the solid; ``radius`` in m the sphere's; ``size`` (3,) in m the box's, along
    x, y and z.
    """

    kind: str
    point: np.ndarray
    normal: np.ndarray
    radius: float = 0.0
    size: np.ndarray | None = None

    def depth(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Depths (n,) in m and inward normals (n, 3) of ``points`` (n, 3) in m."""
        away = points - self.point
        if self.kind == "plane":
            return -away @ self.normal, np.broadcast_to(-self.normal, points.shape)
        if self.kind == "sphere":
            distance = np.linalg.norm(away, axis=1)
            outward = away / np.maximum(distance, _TINY)[:, None]
            outward[distance < _TINY] = (0.0, 0.0, 1.0)
            return self.radius - distance, -outward
        return self._of_box(away)

    def _of_box(self, away: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        assert self.size is not None
        beyond = np.abs(away) - 0.5 * self.size
        side = np.where(away < 0.0, -1.0, 1.0)
        outside = np.maximum(beyond, 0.0)
        distance = np.linalg.norm(outside, axis=1)
        # Inside, the nearest face; outside, the nearest point, so that an edge is round.
        face = np.eye(3)[np.argmax(beyond, axis=1)]
        inside = distance < _TINY
        outward = np.where(
            inside[:, None], face, outside / np.maximum(distance, _TINY)[:, None]
        ) * side  # fmt: skip
        return np.where(inside, -np.max(beyond, axis=1), -distance), -outward
