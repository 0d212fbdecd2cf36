# SPDX-License-Identifier: Apache-2.0
"""Where the keys of a scene stand, and refusals that say so."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from wavehaptics.runtime.toml_source import KeyPath


class SceneError(ValueError):
    """A refused scene. The message is one line: where, what is wrong, what would be right."""

    def __init__(self, message: str) -> None:
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in message))


@dataclass(frozen=True, eq=False)
class Places:
    """Lines of a scene's keys in its file, and by its key where an override is from.

    Two scenes are the same wherever they stand, so any two of these are equal.
    """

    path: str
    lines: Mapping[KeyPath, int]
    overridden: Mapping[KeyPath, str]
    of_motor: str = ""
    """What a message says of the motor before the problem, where there are several."""

    def __eq__(self, other: object) -> bool:
        return other is None or isinstance(other, Places)

    __hash__ = None  # type: ignore[assignment]

    def of(self, at: KeyPath) -> tuple[int, str]:
        """Line (0 for an override) and its label, of ``at`` or of what holds it."""
        for length in range(len(at), 0, -1):
            if at[:length] in self.overridden:
                return 0, self.overridden[at[:length]]
            if at[:length] in self.lines:
                line = self.lines[at[:length]]
                return line, f"{self.path}:{line}"
        made_by = [text for key, text in self.overridden.items() if key[0] == at[0]]
        return (0, made_by[0]) if made_by else (1, f"{self.path}:1")

    def blamed(self, paths: Sequence[KeyPath]) -> tuple[int, str]:
        """The same of those of ``paths`` that go together badly, the one to blame first.

        What the user changed on the command line is to blame before what stood in the file.
        """
        places = [self.of(at) for at in paths]
        return next((place for place in places if place[0] == 0), places[0])

    def written(self, at: KeyPath) -> bool:
        """Whether the scene has ``at`` from its file or the command line, and not by default."""
        return at in self.lines or at in self.overridden
