# SPDX-License-Identifier: Apache-2.0
"""What trying a hard case came to."""

from __future__ import annotations

from typing import Any, NamedTuple


class Outcome(NamedTuple):
    """The numbers of a case, what was found in words, and whether that was expected."""

    numbers: dict[str, Any]
    found: str
    ok: bool
