# SPDX-License-Identifier: Apache-2.0
"""What became of each mutant, kept as it is found, and the summary of all."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from wavehaptics.runtime.files import write_json
from wavehaptics.runtime.repository import ROOT

from wavetools.checks.mutation.table import MutationError

OUT = Path("build", "mutate")
WANTED = 0.95
"""The part of the mutants that aren't equivalent that has to be killed."""

KILLED, EQUIVALENT, SURVIVED = "killed", "equivalent", "survived"


@dataclass(frozen=True)
class Mutant:
    """``what`` was changed at ``place`` (``file:line``), and what became of it and ``by`` what."""

    block: str
    number: int
    place: str
    what: str
    state: str
    by: str
    seconds: float


class Store:
    """A file of a block's results; those found with another ``digest`` are forgotten."""

    def __init__(self, path: Path, digest: str) -> None:
        self.path, self.digest = path, digest
        self.mutants: dict[int, Mutant] = {}
        self.clean_s: float | None = None
        if path.exists():
            kept = json.loads(path.read_text(encoding="utf-8"))
            if kept["digest"] == digest:
                self.clean_s = kept["clean_s"]
                self.mutants = {entry["number"]: Mutant(**entry) for entry in kept["mutants"]}

    def keep(self, mutant: Mutant | None = None) -> None:
        """Add a result, and write all of them whole or not at all."""
        if mutant is not None:
            self.mutants[mutant.number] = mutant
        kept = {
            "digest": self.digest,
            "clean_s": self.clean_s,
            "mutants": [asdict(self.mutants[number]) for number in sorted(self.mutants)],
        }
        write_json(self.path, kept)


def with_reasons(mutants: list[Mutant], reasons: dict[str, str]) -> list[Mutant]:
    """The mutants with those that the table calls equivalent; each has to fit a survivor."""
    open_reasons = dict(reasons)
    told = []
    for mutant in mutants:
        key = f"{mutant.place} {mutant.what}"
        if mutant.state == SURVIVED and key in open_reasons:
            reason = open_reasons.pop(key)
            mutant = Mutant(**{**asdict(mutant), "state": EQUIVALENT, "by": reason})
        told.append(mutant)
    if open_reasons:
        raise MutationError(f"equivalent, but no survivor: {'; '.join(open_reasons)}")
    return told


def summary(groups: Mapping[str, Iterable[Mutant]], failed: dict[str, str]) -> dict[str, Any]:
    """Counts of all and of each group, survivors and equivalents in full.

    ``failed`` says of what couldn't be run why; then nothing is as it must be.
    """
    found = {name: list(mutants) for name, mutants in groups.items()}
    everything = [mutant for mutants in found.values() for mutant in mutants]
    total = counts(everything)
    return {
        **total,
        "wanted": WANTED,
        "enough": not failed and bool(everything) and total["score"] >= WANTED,
        "blocks": {name: counts(mutants) for name, mutants in found.items()},
        "failed": failed,
        "survivors": [asdict(m) for m in everything if m.state == SURVIVED],
        "equivalents": [asdict(m) for m in everything if m.state == EQUIVALENT],
    }


def counts(mutants: Iterable[Mutant]) -> dict[str, int | float]:
    """Mutants by state, and ``score``: killed of those that aren't equivalent."""
    states = [mutant.state for mutant in mutants]
    told = states.count(KILLED) + states.count(SURVIVED)
    return {
        "mutants": len(states),
        KILLED: states.count(KILLED),
        EQUIVALENT: states.count(EQUIVALENT),
        SURVIVED: states.count(SURVIVED),
        "score": round(states.count(KILLED) / told, 4) if told else 1.0,
    }


def write_summary(data: dict[str, Any], root: Path = ROOT) -> Path:
    """Write ``build/mutate/summary.json``."""
    return write_json(root / OUT / "summary.json", data)
