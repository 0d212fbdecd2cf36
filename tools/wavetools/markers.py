# SPDX-License-Identifier: Apache-2.0
"""Tables of a page, between ``<!-- begin NAME -->`` and ``<!-- end NAME -->``, made anew."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

_MARKED = re.compile(r"(<!-- begin (\S+) -->\n)(.*?)(<!-- end \2 -->)", re.DOTALL)


class MarkerError(ValueError):
    """A marker without its other one. The message is one line: the page, what is wrong."""


def tables_of(text: str) -> dict[str, str]:
    """What stands between the markers of a page, by name."""
    return {name: inside for _, name, inside, _ in _MARKED.findall(text)}


def filled(text: str, made: Mapping[str, Callable[[], str]], page: str) -> str:
    """``text`` with the tables that ``made`` has; markers of others stay. :class:`MarkerError`."""
    whole = tables_of(text)
    for name in re.findall(r"<!-- begin (\S+) -->", text):
        if name in made and name not in whole:
            raise MarkerError(f"{page}: <!-- begin {name} --> has no <!-- end {name} -->")

    def fill(found: re.Match[str]) -> str:
        return found[1] + made[found[2]]() + found[4] if found[2] in made else found[0]

    return _MARKED.sub(fill, text)
