# SPDX-License-Identifier: Apache-2.0
"""The wave controller and its motor, simulated."""

from __future__ import annotations

import os

from wavehaptics.runtime.repository import BUILD


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
