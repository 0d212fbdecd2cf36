# SPDX-License-Identifier: Apache-2.0
"""What stands in a scene's file: it knows where, so that a refusal can say so."""

from __future__ import annotations

from typing import TypeVar

from pydantic import PrivateAttr

from wavehaptics.runtime.toml_source import KeyPath
from wavehaptics.scene.keys import Table
from wavehaptics.scene.places import Places, SceneError

Self = TypeVar("Self", bound="Placed")


class Placed(Table):
    """Tables that stand in a file together."""

    _places: Places | None = PrivateAttr(default=None)

    @property
    def called(self) -> str:
        """What a refusal says where it knows no file."""
        return "scene"

    def placed(self: Self, places: Places) -> Self:
        """The same as it stands in a file."""
        copy = self.model_copy()
        copy._places = places
        return copy

    def refusal(self, problem: str, *keys: str | KeyPath) -> SceneError:
        """To be raised where what runs the scene can't do it: one line, and where the cause stands.

        ``keys`` are those involved, ``table``, ``table.key`` or a path, the one to blame first;
        what is there by default is to blame only where all are.
        """
        if self._places is None:
            return SceneError(f"{self.called}: {problem}")
        paths = [tuple(key.split(".")) if isinstance(key, str) else key for key in keys]
        written = [path for path in paths if self._places.written(path)]
        place = self._places.blamed(written or paths)[1]
        return SceneError(f"{place}: {self._places.of_motor}{problem}")
