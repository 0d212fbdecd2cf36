# SPDX-License-Identifier: Apache-2.0
"""``formal/mutate.toml``: which tests each module's mutants are given to, and how many they are."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toml_source import tomllib

TABLE = Path("formal", "mutate.toml")


class MutationError(RuntimeError):
    """What can't be mutated or run, in one line."""


@dataclass(frozen=True)
class Block:
    """A module and the bench that its mutants run on.

    ``parameters`` are the bench's, ``own`` those with which it holds the module; by default the
    same, because most benches are about their top. ``without`` are tests of the bench that look
    inside, where a netlist has other names. ``equivalent`` says of mutants, by
    ``<place> <what>``, why no test can see them.
    """

    module: str
    mutants: int
    test: str
    top: str
    name: str
    parameters: dict[str, int] = field(default_factory=dict)
    own: dict[str, int] = field(default_factory=dict)
    quick: bool = False
    without: tuple[str, ...] = ()
    equivalent: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Model:
    """A module of the Python models, the functions that are mutated (none: all), and its tests.

    ``module`` is its path in the package, without ``.py``; it goes by its file's name.
    ``compiled`` leaves numba at work, for tests that would take too long without.
    """

    module: str
    mutants: int
    tests: tuple[str, ...]
    functions: tuple[str, ...] = ()
    compiled: bool = False
    quick: bool = False
    equivalent: dict[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return f"{self.module.rpartition('/')[2]}.py"


@dataclass(frozen=True)
class Table:
    """All of the table; ``seed`` picks the mutants."""

    seed: int
    blocks: tuple[Block, ...]
    models: tuple[Model, ...]


def load_table(path: Path = ROOT / TABLE) -> Table:
    """The table; :class:`MutationError` where it can't be used."""
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise MutationError(f"{path}: {error}") from None
    blocks = tuple(_block(entry) for entry in data.get("block", []))
    models = tuple(_model(entry) for entry in data.get("model", []))
    names = [block.name for block in blocks] + [model.name for model in models]
    for name in names:
        if names.count(name) > 1:
            raise MutationError(f"{TABLE}: {name} is there twice; give one a name of its own")
    return Table(int(data["seed"]), blocks, models)


def _block(entry: dict[str, Any]) -> Block:
    entry = dict(entry)
    module = entry.get("module", "?")
    short = module.removeprefix("wh_")
    entry.setdefault("test", f"tb_{short}")
    entry.setdefault("top", module)
    entry.setdefault("name", short)
    entry["without"] = tuple(entry.get("without", ()))
    entry.setdefault("own", entry.get("parameters", {}) if entry["top"] == module else {})
    return _made(Block, entry, module)


def _model(entry: dict[str, Any]) -> Model:
    entry = {key: tuple(v) if isinstance(v, list) else v for key, v in entry.items()}
    return _made(Model, entry, entry.get("module", "?"))


def _made(kind: type, entry: dict[str, Any], name: str) -> Any:
    try:
        return kind(**entry)
    except TypeError as error:
        raise MutationError(f"{TABLE}: {name}: {str(error).split('() ', 1)[-1]}") from None
