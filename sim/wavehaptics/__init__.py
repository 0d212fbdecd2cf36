# SPDX-License-Identifier: Apache-2.0
"""The wave controller and its motor, simulated: ``import wavehaptics as wh``.

``docs/python.md`` shows the use. A name's module is imported when the name is first used, so that
the import itself is fast.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

from wavehaptics.runtime.repository import BUILD

if TYPE_CHECKING:
    from wavehaptics.api.boards import Board
    from wavehaptics.api.runs import Run, Trace, run
    from wavehaptics.api.scenes import Scene, load_scene
    from wavehaptics.api.sweeping import sweep
    from wavehaptics.host.names import HostError
    from wavehaptics.host.planes import JointPlane, MotorData, Planes
    from wavehaptics.laws.shapes import Shape
    from wavehaptics.runtime.toolchain import ToolError
    from wavehaptics.scene import SceneError

__all__ = [
    "Board", "HostError", "JointPlane", "MotorData", "Planes", "Run", "Scene", "SceneError",
    "Shape", "ToolError", "Trace", "load_scene", "run", "sweep",
]  # fmt: skip

_HOMES = {
    "Board": "api.boards",
    "HostError": "host.names",
    "JointPlane": "host.planes",
    "MotorData": "host.planes",
    "Planes": "host.planes",
    "Run": "api.runs",
    "Scene": "api.scenes",
    "SceneError": "scene",
    "Shape": "laws.shapes",
    "ToolError": "runtime.toolchain",
    "Trace": "api.runs",
    "load_scene": "api.scenes",
    "run": "api.runs",
    "sweep": "api.sweeping",
}
"""Module of each public name."""


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'wavehaptics' has no attribute {name!r}")
    return getattr(import_module(f"wavehaptics.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def _cache_in_the_tree() -> None:
    """Keep what numba compiles where all builds go, unless the user has a place for it.

    How it is found there again is said in :mod:`wavehaptics.runtime.compiled`.
    """
    cache = BUILD / "numba"
    try:
        cache.mkdir(parents=True, exist_ok=True)
    except OSError:
        return  # a tree that can't be written to: numba finds a place of its own
    os.environ.setdefault("NUMBA_CACHE_DIR", str(cache))


_cache_in_the_tree()

# The matrices here are small: BLAS's threads would only wait for each other, and use up a processor
# that another process could have.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
