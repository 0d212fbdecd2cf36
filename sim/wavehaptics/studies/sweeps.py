# SPDX-License-Identifier: Apache-2.0
"""Many runs at a time, on local processes or on a cluster, each finished one kept at once.

A task is a function of a module and the arguments of one call, plain JSON values; so is its result.
Each result is a file named after a digest of the task and of the project's sources, written whole
or not at all. So a sweep that is started again goes on where it was interrupted, a worker that dies
costs no more than the task that it was at, and nothing outlives a change of the code or a scene.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from wavehaptics.runtime import files
from wavehaptics.runtime.repository import PACKAGE, ROOT
from wavehaptics.words import formats

if TYPE_CHECKING:
    from distributed import Client

WORKER_DEATHS = 5
"""Workers that may die over one task before it is taken for the cause."""

PATIENCE_S = 600
"""How long an answer from this machine's processes may take: others may keep the machine busy."""

_SOURCES = (("sim/verilated", "*"), ("rtl", "*.v*"), ("rtl", "*.toml"), ("sim/scenes", "*.toml"))


class SweepError(RuntimeError):
    """A sweep that can't go on. The message is one line."""


@dataclass(frozen=True)
class Task:
    """One call of a module's function; ``arguments`` are JSON values by parameter."""

    function: Callable[..., Any]
    arguments: dict[str, Any] = field(default_factory=dict)

    def key(self, sources: str) -> str:
        """Name of the result's file: the same for the same call of the same sources."""
        name = f"{self.function.__module__}.{self.function.__qualname__}"
        text = json.dumps([name, self.arguments, sources], sort_keys=True, ensure_ascii=False)
        return files.digest_of(text)[:24]


def sources_of(task: Task) -> str:
    """:func:`sources_digest` of the package that a task's function is in."""
    return sources_digest(task.function.__module__.partition(".")[0])


@cache
def sources_digest(package: str = "wavehaptics") -> str:
    """:func:`digest_of` this package and another, as they are when this process asks first."""
    folders = getattr(sys.modules[package], "__path__", ())
    return digest_of(ROOT, *dict.fromkeys([PACKAGE, *(Path(each).resolve() for each in folders)]))


def digest_of(root: Path, *packages: Path) -> str:
    """Digest of all that a result may depend on: packages, shims, RTL, scenes and word lengths."""
    code = [
        files.digest_of(formats.HEADER_VALUES, sorted(package.rglob("*.py")), package)
        for package in packages
    ]
    sources = (
        path
        for folder, pattern in _SOURCES
        for path in sorted(filter(Path.is_file, (root / folder).glob(pattern)))
    )
    return files.digest_of(code, sources, root)


def sweep(
    tasks: Sequence[Task],
    store: Path,
    *,
    cluster: str | None = None,
    workers: int = 2,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Any]:
    """Results of ``tasks`` in their order; those already in ``store`` are read from there.

    ``cluster`` is the address of a dask scheduler whose workers have this very project; without
    one, ``workers`` processes of this machine do the work. ``progress`` is called with the tasks
    done and all tasks. What a task raises ends the sweep; what was finished before stays.
    """
    store.mkdir(parents=True, exist_ok=True)
    kept = [store / f"{task.key(sources_of(task))}.json" for task in tasks]
    missing = {file: task for file, task in zip(kept, tasks, strict=True) if not file.exists()}
    done, total = len(set(kept)) - len(missing), len(set(kept))
    progress(done, total)
    if missing:
        for file, result in finished(missing, cluster, workers):
            files.write_json(file, {"result": result})
            done += 1
            progress(done, total)
    return [json.loads(file.read_bytes())["result"] for file in kept]


_Name = TypeVar("_Name")


def finished(
    tasks: Mapping[_Name, Task], cluster: str | None, workers: int = 2
) -> Iterator[tuple[_Name, Any]]:
    """Each task's name and result, as soon as there is one; by whom, says :func:`sweep`."""
    from distributed import as_completed

    with _client(cluster, min(workers, len(tasks))) as client:
        futures = {
            client.submit(_call, task, sources, key=task.key(sources), pure=False): name
            for name, task in tasks.items()
            for sources in [sources_of(task)]
        }
        for future in as_completed(list(futures)):
            yield futures[future], future.result()
            future.release()


def _call(task: Task, sources: str) -> Any:
    """What a worker does."""
    if sources_of(task) != sources:
        raise SweepError(
            "a worker has other sources than the sweep began with; update it and start again"
        )
    return task.function(**task.arguments)


@contextmanager
def _client(address: str | None, workers: int) -> Iterator[Client]:
    import dask
    from distributed import Client, LocalCluster

    quiet = {
        "distributed.scheduler.allowed-failures": WORKER_DEATHS,
        "distributed.admin.large-graph-warning-threshold": "1GB",
        # A compiled loop lets no heartbeat through, however long it takes.
        "distributed.scheduler.worker-ttl": None,
    }
    with dask.config.set(quiet):
        if address is None:
            with (
                LocalCluster(
                    n_workers=workers, threads_per_worker=1, dashboard_address="localhost:0",
                    memory_limit=0, silence_logs="CRITICAL",
                ) as local,
                Client(local, timeout=PATIENCE_S) as client,
            ):  # fmt: skip
                yield client
            return
        try:
            client = Client(address, timeout="10s")
        except (OSError, ValueError) as error:
            raise SweepError(f"--cluster {address}: no scheduler answers there: {error}") from None
        with client:
            yield client
