# SPDX-License-Identifier: Apache-2.0
"""The wave controller and its motor, simulated."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path


def _cache_of_these_sources() -> None:
    """Keep what numba compiles under a name that follows every source and word length.

    numba alone looks at the file of the function that it compiles, not at those that this one
    calls: after a change in one of them it would go on with the old code.
    """
    package = Path(__file__).resolve().parent
    root = package.parents[1]
    own = root / "build" / "numba"
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given is not None and Path(given).parent != own:
        return
    digest = hashlib.sha256()
    for path in [*sorted(package.rglob("*.py")), root / "rtl" / "wh_formats.vh"]:
        digest.update(path.read_bytes())
    widths = {name: value for name, value in os.environ.items() if name.startswith("WH_")}
    digest.update(repr(sorted(widths.items())).encode())
    cache = own / digest.hexdigest()[:16]
    try:
        cache.mkdir(parents=True, exist_ok=True)
    except OSError:
        return  # a tree that can't be written to: numba finds a place of its own
    os.environ["NUMBA_CACHE_DIR"] = str(cache)


_cache_of_these_sources()
