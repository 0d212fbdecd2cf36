# SPDX-License-Identifier: Apache-2.0
"""How the simulation's loops are compiled: by numba, kept on disk, without reference counts.

A loop's arrays belong to its caller, who keeps them until it returns. To count references to them
in each tick would take four fifths of the integer model's time, as every count may write to memory
and so stands in the way of keeping numbers in registers. A function that makes arrays of its own
can't do without, and takes ``numba.njit``.
"""

from __future__ import annotations

import functools

import numba

compiled = functools.partial(numba.njit, cache=True, _nrt=False)
"""``numba.njit`` for functions that make no arrays; ``@compiled()`` takes its options too."""
