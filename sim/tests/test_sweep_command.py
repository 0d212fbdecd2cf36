# SPDX-License-Identifier: Apache-2.0
"""``wavehaptics sweep``: its grid, its CSV, what goes on after an interruption, what is refused."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from distributed import LocalCluster
from wavehaptics.cli.shared import CommandError
from wavehaptics.cli.sweeping import axis
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.studies import grid, grid_picture
from wavehaptics.studies.report import latency
from wavehaptics.studies.sweeps import SweepError
from wavetools.studies.tabled_runs import R_HAT_PARTS

TIMEOUT_S = 600
SHORT = ("--set", "scene.duration_s=0.1")


def command(*words: object) -> list[str]:
    return [sys.executable, "-m", "wavehaptics", "sweep", *map(str, words)]


def swept(*words: object, status: int = 0) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        command(*words), capture_output=True, text=True, timeout=TIMEOUT_S, check=False
    )
    assert done.returncode == status, done.stderr
    return done


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "sweep.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("controller.lambda=1e4:1e5:3:log", [10000, 31622.7766017, 100000]),
        ("encoder.counts_per_rev=1000:4000:4", [1000, 2000, 3000, 4000]),
        ("controller.eta_contact=-1:-0.5:3", [-1, -0.75, -0.5]),
        ("drive.limit_v=2.5,1e1", [2.5, 10.0]),
        ("adc.part=AD7276,ADS7042", ["AD7276", "ADS7042"]),
        ("controller.anchor_auto=true,false", [True, False]),
    ],
)
def test_an_axis(text, values):
    assert axis(text) == (text.partition("=")[0], values)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("controller.lambda", "write table.key=low:high:count, low:high:count:log or a,b,c"),
        ("controller.lambda=1:2", "write table.key=low:high:count"),
        ("controller.lambda=1:2:3:cubic", "write table.key=low:high:count"),
        ("controller.lambda=1:x:3", "low and high are numbers"),
        ("controller.lambda=1:2:1", "count 2 to 100000"),
        ("controller.lambda=1:inf:3", "must be finite"),
        ("controller.lambda=0:2:3:log", "above 0 on a logarithmic scale"),
        ("controller.lambda=2:2:3", "write controller.lambda=2"),
        ("controller.lambda=1,,2", "empty or there twice"),
        ("controller.lambda=1,1.0", "empty or there twice"),
    ],
)
def test_a_wrong_axis_is_told(text, told):
    with pytest.raises(CommandError, match=re.escape(told)):
        axis(text)


def test_the_csv_has_the_numbers_of_the_tables(tmp_path):
    """R̂ off on ``analog``, which ``make tables`` measures: the same stiffness and peak."""
    ohm = load_scene(find_scene("paper_taps")).motor.R_ohm
    texts = [f"{ohm * (1.0 + part):.9g}" for part in R_HAT_PARTS]
    sets = ("--set", "scene.duration_s=0.5")
    key = "controller.r_hat"
    swept("paper_taps", f"{key}={','.join(texts)}", "-c", "analog", *sets, "--workers", "2",
          "--out", tmp_path)  # fmt: skip
    measured = json.loads((ROOT / "sim" / "docs" / "measured.json").read_bytes())["tables"]["r_hat"]
    rows = rows_of(tmp_path)
    assert len(rows) == len(measured) == 4
    for row, text, kept in zip(rows, texts, measured, strict=True):
        assert float(row[key]) == float(text)
        assert float(row["stiffness"]) == pytest.approx(kept["stiffness"], rel=1e-7)
        assert float(row["peak_torque"]) == pytest.approx(kept["peak_torque"], rel=1e-7)
        assert row["error"] == ""
    assert (tmp_path / "sweep.png").read_bytes().startswith(b"\x89PNG")


def test_an_interrupted_sweep_goes_on_from_its_csv(tmp_path):
    words = ("paper_taps", "controller.lambda=5e3:5e4:8:log", *SHORT, "--workers", "1", "--out")
    process = subprocess.Popen(
        command(*words, tmp_path), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    for line in process.stderr:
        if line.startswith("3 of 8"):
            break
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 130
    first = rows_of(tmp_path)
    assert 3 <= len(first) < 8
    done = swept(*words, tmp_path)
    assert done.stderr.startswith(f"{len(first)} of 8 points\n")
    rows = rows_of(tmp_path)
    assert len(rows) == 8
    # What each took is what it took before the interruption: it hasn't run again.
    assert [row["wall_clock_s"] for row in rows[: len(first)]] == [
        row["wall_clock_s"] for row in first
    ]
    before = (tmp_path / "sweep.csv").read_bytes()
    assert "8 points, 0 refused" in swept(*words, tmp_path).stdout
    assert (tmp_path / "sweep.csv").read_bytes() == before

    def refused(*others: object) -> str:
        told = swept(*others, "--out", tmp_path, status=2).stderr.splitlines()[-1]
        assert (tmp_path / "sweep.csv").read_bytes() == before
        return told

    key = "controller.lambda=5e3:5e4:8:log"
    another = "is of another scene, controller, set of keys or version; remove it, or name"
    assert another in refused("paper_taps", key, "--set", "scene.duration_s=0.05")
    assert another in refused("stiffest", key, *SHORT)
    assert another in refused("paper_taps", key, *SHORT, "-c", "analog")
    assert another in refused("paper_taps", "controller.tick_hz=1e5,1e6", *SHORT)
    assert "has controller.lambda=" in refused("paper_taps", "controller.lambda=5e3,6e3", *SHORT)
    assert "did you mean stiffness?" in refused("paper_taps", key, *SHORT, "--plot", "stiffnes")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("paper_tap", "controller.lambda=1e4,2e4"), "did you mean paper_taps?"),
        (("paper_taps", "controller.lambda=1e4", "-c", "gold"), "did you mean golden?"),
        (("paper_taps", "controller.lambada=1e4,2e4"), "did you mean lambda?"),
        (("paper_taps", "drive.limit_v=1", "drive.limit_v=2"), "a key is there twice"),
        (("paper_taps", "drive.limit_v=1:2:1000", "drive.gain_error=0:0.1:1000"), "1000000 points"),
        (("paper_taps", "drive.limit_v=1,2", "--workers", "2", "--cluster", "x:1"), "has its own"),
    ],
)
def test_refused_in_one_line(tmp_path, words, told):
    done = swept(*words, "--out", tmp_path, status=2)
    assert done.stdout == ""
    assert re.fullmatch(r"wavehaptics: [^\n]+\n", done.stderr), done.stderr
    assert told in done.stderr


def test_a_refused_point_is_a_row(tmp_path):
    words = ("controller.eta_contact=-1,2", "controller.lambda=1e4,2e4")
    done = swept("paper_taps", *words, *SHORT, "--workers", "1", "--out", tmp_path)
    assert "4 points, 2 refused" in done.stdout
    rows = rows_of(tmp_path)
    assert [row["controller.lambda"] for row in rows] == ["10000.0", "20000.0"] * 2
    assert [bool(row["error"]) for row in rows] == [False, False, True, True]
    assert "controller.eta_contact = 2 is out of range" in rows[2]["error"]
    assert rows[2]["peak_torque"] == ""
    assert float(rows[0]["peak_torque"]) > 0


def test_on_processes_and_on_a_cluster_as_alone():
    """The same rows, but for the time that they took."""
    scene = find_scene("paper_taps")
    of = grid.Grid(
        scene, scene.read_bytes(), (SHORT[1],), "golden", {"controller.lambda": [1e4, 2e4, -1]}
    )

    def rows(**how: object) -> list[dict]:
        return [{**row, "wall_clock_s": 0} for row in grid.sweep(of, None, **how)]

    alone = rows(workers=1)
    assert [row["error"] is None for row in alone] == [True, True, False]
    assert rows(workers=2) == alone
    with LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address="localhost:0", silence_logs="CRITICAL"
    ) as local:
        assert rows(workers=2, cluster=local.scheduler_address) == alone


def test_a_worker_that_ends_is_told(monkeypatch):
    scene = find_scene("paper_taps")
    of = grid.Grid(scene, scene.read_bytes(), (), "golden", {"controller.lambda": [1e4, 2e4]})
    monkeypatch.setattr(grid.signal, "signal", os._exit)
    with pytest.raises(SweepError, match="a worker has ended; start the sweep again"):
        list(grid.ran(of, of.points(), workers=2))


def test_the_picture_takes_what_there_is(tmp_path):
    """Names on the axis, bools, a metric without a value at some points."""
    rows = [
        {"adc.part": part, "drive.compensate": on, "error": None, "stiffness": k, "note": "x"}
        for part, on, k in (("A", True, 1.0), ("A", False, None), ("B", True, 2), ("B", False, 3))
    ]
    keys = ["adc.part", "drive.compensate"]
    assert grid_picture.draw(rows, keys, (), tmp_path / "a.png") == ["stiffness"]
    assert grid_picture.draw(rows, keys, ["note"], tmp_path / "b.png") == ["note"]
    bare = [{"adc.part": "A", "error": "refused"}]
    assert grid_picture.draw(bare, ["adc.part"], (), tmp_path / "c.png") == []
    assert all((tmp_path / f"{name}.png").stat().st_size > 2000 for name in "abc")


def test_the_csv_is_a_table_of_the_report(tmp_path):
    """Stiffness over latency, as the report has it, to the last digit."""
    own = [word for text in ("controller.lambda=1e9", latency.LIMIT, latency.DURATION)
           for word in ("--set", text)]  # fmt: skip
    swept("stiffest", "controller.extra_ticks=1,100", *own, "--workers", 1, "--out", tmp_path)
    rows = rows_of(tmp_path)
    assert len(rows) == 2
    for row in rows:
        told = latency.at_latency(int(row["controller.extra_ticks"]))
        for name in ("stiffness", "k_l", "energy_out_max_j"):
            assert float(row[name]) == told[name]
