# SPDX-License-Identifier: Apache-2.0
"""Sweeps: order, resuming, a killed worker, a cluster given by its address."""

from __future__ import annotations

import os
import shutil
import signal
import threading
import time
from pathlib import Path

import pytest
from distributed import Client, LocalCluster
from wavehaptics.runtime.repository import PACKAGE, ROOT
from wavehaptics.studies import sweeps
from wavehaptics.studies.sweeps import SweepError, Task, sweep
from wavehaptics.words import formats
from wavetools.studies.anchored import motors

TIMEOUT_S = 60


def square(folder: str, n: int, wait_s: float = 0.0) -> int:
    """n², and a line for each time that it was started and that it ended."""
    with (Path(folder) / "started").open("a") as out:
        out.write(f"{n} {os.getpid()}\n")
    time.sleep(wait_s)
    with (Path(folder) / "ended").open("a") as out:
        out.write(f"{n}\n")
    return n * n


def refuse(n: int) -> int:
    raise ValueError(f"{n} is refused")


def lines(path: Path) -> list[str]:
    return path.read_text().splitlines() if path.exists() else []


def tasks(folder: Path, count: int, wait_s: float = 0.0) -> list[Task]:
    return [Task(square, {"folder": str(folder), "n": n, "wait_s": wait_s}) for n in range(count)]


@pytest.fixture(scope="module")
def cluster():
    with LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address="localhost:0", silence_logs="CRITICAL"
    ) as local:
        yield local


def test_results_in_order_and_kept(tmp_path):
    """On local processes; a second sweep starts none, and a new task only itself."""
    seen = []
    wanted = [n * n for n in range(5)]
    results = sweep(
        tasks(tmp_path, 5), tmp_path / "store", progress=lambda *part: seen.append(part)
    )
    assert results == wanted
    assert seen == [(n, 5) for n in range(6)]
    assert sweep(tasks(tmp_path, 6)[:5], tmp_path / "store") == wanted
    assert len(lines(tmp_path / "started")) == 5
    assert len({line.split()[1] for line in lines(tmp_path / "started")}) == 2
    assert os.getpid() not in {int(line.split()[1]) for line in lines(tmp_path / "started")}


def test_an_interrupted_sweep_goes_on(tmp_path, cluster):
    def interrupt(done: int, total: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(tasks(tmp_path, 8, 0.1), tmp_path / "store",
              cluster=cluster.scheduler_address, progress=interrupt)  # fmt: skip
    kept = len(list((tmp_path / "store").glob("*.json")))
    assert kept == 3
    first = []
    results = sweep(
        tasks(tmp_path, 8, 0.1), tmp_path / "store", cluster=cluster.scheduler_address,
        progress=lambda done, total: first.append(done),
    )  # fmt: skip
    assert first[0] == kept
    assert results == [n * n for n in range(8)]


def test_a_killed_worker_loses_nothing(tmp_path, cluster):
    """Two workers; one is killed in the middle of a task, which is done again."""
    with Client(cluster) as client:
        client.wait_for_workers(2, timeout=TIMEOUT_S)
    killed = []

    def kill() -> None:
        deadline = time.monotonic() + TIMEOUT_S
        while len(lines(tmp_path / "started")) < 4 and time.monotonic() < deadline:
            time.sleep(0.02)
        n, pid = lines(tmp_path / "started")[-1].split()
        os.kill(int(pid), signal.SIGKILL)
        killed.append(n)

    killer = threading.Thread(target=kill)
    killer.start()
    results = sweep(
        tasks(tmp_path, 12, 0.25), tmp_path / "store", cluster=cluster.scheduler_address
    )
    killer.join(TIMEOUT_S)
    assert results == [n * n for n in range(12)]
    started = [line.split()[0] for line in lines(tmp_path / "started")]
    assert killed
    assert started.count(killed[0]) >= 2
    assert set(lines(tmp_path / "ended")) == {str(n) for n in range(12)}
    assert len(list((tmp_path / "store").glob("*.json"))) == 12


def test_what_a_task_raises_is_told(tmp_path):
    with pytest.raises(ValueError, match="7 is refused"):
        sweep([Task(refuse, {"n": 7})], tmp_path / "store")
    assert list((tmp_path / "store").glob("*")) == []


def test_keys_depend_on_call_and_sources():
    one, other = Task(square, {"n": 1}), Task(square, {"n": 2})
    keys = {one.key("a"), one.key("b"), other.key("a"), Task(refuse, {"n": 1}).key("a")}
    assert len(keys) == 4
    assert one.key("a") == Task(square, {"n": 1}).key("a")


SOURCES = ("sim/wavehaptics", "sim/verilated", "rtl", "sim/scenes")


def test_every_source_counts(tmp_path):
    """A line more in any file that a result may depend on, and no old result is in force."""
    for folder in SOURCES:
        shutil.copytree(
            ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__")
        )
    (tmp_path / "sim" / "verilated" / "more.vh").write_text("// a header of the Verilog there\n")

    def digest_of_copy() -> str:
        return sweeps.digest_of(tmp_path, tmp_path / "sim" / "wavehaptics")

    digests = {digest_of_copy()}
    assert digests == {digest_of_copy()}
    files = [path for folder in SOURCES for path in (tmp_path / folder).rglob("*")]
    files = [path for path in files if path.suffix in (".py", ".cpp", ".h", ".v", ".vh", ".toml")]
    assert {path.suffix for path in files} == {".py", ".cpp", ".h", ".v", ".vh", ".toml"}
    unseen = []
    for path in files:
        kept = path.read_bytes()
        path.write_bytes(kept + b"\n")
        digest = digest_of_copy()
        if digest in digests:
            unseen.append(path.relative_to(tmp_path))
        digests.add(digest)
        path.write_bytes(kept)
    assert unseen == []
    assert sweeps.sources_digest() != digest_of_copy()  # which has more.vh
    (tmp_path / "sim" / "verilated" / "more.vh").unlink()
    assert sweeps.sources_digest() == digest_of_copy()


def test_sources_of_a_task_in_another_package_count(tmp_path):
    """A study of ``wavetools``: what is kept of it ends with a change of either package."""
    task = Task(motors.draw, {})
    assert sweeps.sources_of(task) == sweeps.sources_digest("wavetools")
    assert sweeps.sources_of(task) != sweeps.sources_of(Task(square, {}))
    one, other = tmp_path / "one", tmp_path / "other"
    for folder in (one, other):
        folder.mkdir()
        (folder / "a.py").write_text("a = 1\n")
    first = sweeps.digest_of(ROOT, one, other)
    (other / "a.py").write_text("a = 2\n")
    second = sweeps.digest_of(ROOT, one, other)
    (one / "a.py").write_text("a = 2\n")
    assert len({first, second, sweeps.digest_of(ROOT, one, other)}) == 3


def test_other_word_lengths_count(monkeypatch):
    """Those that the environment sets."""
    before = sweeps.digest_of(ROOT, PACKAGE)
    monkeypatch.setitem(formats.HEADER_VALUES, "DATA_W", formats.HEADER_VALUES["DATA_W"] - 1)
    assert sweeps.digest_of(ROOT, PACKAGE) != before


def test_workers_with_other_sources_are_refused(monkeypatch):
    with pytest.raises(SweepError, match="other sources than the sweep began with"):
        sweeps._call(Task(square, {}), "something else")


def test_no_scheduler(tmp_path):
    with pytest.raises(SweepError, match="--cluster nowhere:1"):
        sweep([Task(refuse, {"n": 1})], tmp_path, cluster="nowhere:1")
