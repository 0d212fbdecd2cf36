# SPDX-License-Identifier: Apache-2.0
"""All mutants of ``formal/mutate.toml``, and ``build/mutate/summary.json`` of what became of them.

An interrupted run goes on where it stopped; what has run before with the same sources, benches and
tools is not run again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any

from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain, ToolError

from wavetools.checks.mutation import processes
from wavetools.checks.mutation.models import run_model
from wavetools.checks.mutation.results import Mutant, summary, write_summary
from wavetools.checks.mutation.rtl import run_block
from wavetools.checks.mutation.table import Block, Model, MutationError, Table, load_table

Progress = Callable[[str, float], None]


def chosen(table: Table, names: Iterable[str], quick: bool) -> list[Block | Model]:
    """Blocks and models by name, all without one; ``quick`` takes the marked ones only.

    A block goes by its module's name, a model by its file's: `anchor`, `wh_anchor` or `anchor.py`.
    """
    entries: list[Block | Model] = [*table.blocks, *table.models]
    wanted = {name.removeprefix("wh_") for name in names}
    if unknown := wanted - {word for entry in entries for word in _words(entry)}:
        raise MutationError(f"no block {', '.join(sorted(unknown))}; see formal/mutate.toml")
    if wanted:
        entries = [entry for entry in entries if _words(entry) & wanted]
    return [entry for entry in entries if entry.quick or not quick]


def _words(entry: Block | Model) -> set[str]:
    return (
        {entry.name, entry.module.removeprefix("wh_")} if isinstance(entry, Block) else {entry.name}
    )


def mutate(
    names: Iterable[str] = (),
    quick: bool = False,
    jobs: int = 2,
    progress: Progress = lambda stage, part: None,
    root: Path = ROOT,
) -> tuple[dict[str, Any], Path]:
    """Run the mutants; (summary, its path). It is written again whenever a block has ended."""
    names = tuple(names)
    table = load_table()
    blocks = chosen(table, names, quick)
    try:
        tools = Toolchain.of_environment()
        versions = f"Yosys {tools.check_age('yosys')}"
    except ToolError as error:
        raise MutationError(str(error)) from None
    order = sorted(blocks, key=lambda block: -block.mutants)  # so that no long one ends alone
    done: dict[str, list[Mutant]] = {}
    failed: dict[str, str] = {}

    def told() -> dict[str, Any]:
        found = {b.name: done[b.name] for b in blocks if b.name in done}
        part = bool(names) or quick or len(found) < len(blocks)
        return {"tools": versions, "seed": table.seed, "quick": part, **summary(found, failed)}

    processes.start()
    with ThreadPoolExecutor(jobs) as pool:
        waiting: dict[Future, Block | Model] = {}
        for block in order:
            show = _part(progress, block)
            if isinstance(block, Model):
                job = pool.submit(run_model, block, table.seed, versions, show)
            else:
                job = pool.submit(run_block, block, table.seed, tools, versions, show)
            waiting[job] = block
        try:
            while waiting:
                ended, _ = wait(waiting, return_when=FIRST_COMPLETED)
                for future in ended:
                    block = waiting.pop(future)
                    try:
                        done[block.name] = future.result()
                    except (MutationError, ToolError) as error:
                        failed[block.name] = str(error)
                    progress(block.name, 1.0)
                    write_summary(told(), root)
        except BaseException:
            processes.stop()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return told(), write_summary(told(), root)


def _part(progress: Progress, block: Block | Model) -> Callable[[int], None]:
    return lambda number: progress(block.name, number / block.mutants)
