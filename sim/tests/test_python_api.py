# SPDX-License-Identifier: Apache-2.0
"""``import wavehaptics as wh``: scenes, runs, sweeps; and the examples of ``examples/python``."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import wavehaptics as wh
from wavehaptics.ladder.run import run_scene
from wavehaptics.runtime.repository import PACKAGE, ROOT
from wavehaptics.runtime.terminals import check_terminals
from wavehaptics.runtime.toolchain import ToolError
from wavehaptics.scene import find_scene, load_scene
from wavehaptics.trace import columns, tip
from wavehaptics.trace.columns import load_trace

TIMEOUT_S = 900
EXAMPLES = ROOT / "examples" / "python"
SHORT = ("scene.duration_s=0.1",)


@pytest.fixture(scope="module")
def taps() -> wh.Scene:
    return wh.load_scene("paper_taps").with_(scene__duration_s=0.1)


@pytest.fixture(scope="module")
def taps_run(taps) -> wh.Run:
    return wh.run(taps, "golden")


def test_import_is_light_and_names_are_there():
    """Nothing that takes a second is imported until it is used, and the names are those listed."""
    code = (
        "import sys, wavehaptics as wh\n"
        "heavy = {'numpy', 'numba', 'scipy', 'pydantic', 'matplotlib', 'pymodbus', 'typer'}\n"
        "print(sorted(heavy & set(sys.modules)))\n"
        "print([n for n in wh.__all__ if not callable(getattr(wh, n))])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=TIMEOUT_S, check=True
    )
    assert done.stdout == "[]\n[]\n"
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        wh.nothing  # noqa: B018
    assert (PACKAGE / "py.typed").is_file()
    assert set(wh.__all__) <= set(dir(wh))


def test_a_change_makes_another_scene(taps):
    stiff = taps.with_(controller__lambda=2e4, motor__R_ohm=np.float64(3.0))
    assert (stiff["controller.lambda"], taps["controller.lambda"]) == (2e4, 1e4)
    # What follows from a changed key follows anew.
    assert (stiff["controller.r_hat"], taps["controller.r_hat"]) == (3.0, 2.18)
    walls = stiff.with_({"controller.walls": [(0.1, 0.2)], "controller.anchor_auto": True})
    assert walls["controller.walls"] == ((0.1, 0.2),)
    assert walls["controller.lambda"] == 2e4
    assert walls.with_(scene__name="other").name == "other"
    assert taps["thermal.magnet_per_k"] is None


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"controller__lambada": 1}, "controller.lambada=1: unknown key controller.lambada; did yo"
         "u mean lambda?"),
        ({"lambda": 1}, 'lambda=1: "lambda" names no table; did you mean controller.lambda?'),
        ({"controller__lambda": -1}, "controller.lambda=-1: controller.lambda = -1 is out of ran"),
        ({"controller__lambda": None}, "controller.lambda=None: a scene has no such value; give "),
        ({"motor__preset": "re25"}, 'motor.preset="re25": motor.preset "re25" is unknown; known: '),
        ({"motors__a__k_t": 1.0}, "motors.a.k_t=1.0: it must be motors.NAME.key=value"),
    ],
)  # fmt: skip
def test_a_wrong_change_is_told_with_place_and_cure(taps, keys, told):
    with pytest.raises(wh.SceneError, match="^" + re.escape(told)) as refused:
        taps.with_(**keys)
    assert "\n" not in str(refused.value)


def test_wrong_names_are_told(taps, taps_run, tmp_path):
    for key, told in (
        ("controller.lambada", "did you mean lambda?"),
        ("contoller.lambda", "did you mean controller.lambda?"),
    ):
        with pytest.raises(wh.SceneError, match=re.escape(told)):
            taps[key]
    with pytest.raises(wh.SceneError, match='"gold" is unknown; did you mean "golden"'):
        wh.run(taps, "gold")
    with pytest.raises(wh.SceneError, match="no such file"):
        wh.load_scene(tmp_path / "none.toml")
    with pytest.raises(KeyError, match="did you mean position"):
        taps_run.trace["postion"]


def test_what_is_no_scene_is_told():
    with pytest.raises(TypeError, match=r"a scene is a path, a name or a Scene of load_scene, not"):
        wh.run(load_scene(find_scene("paper_taps")), "golden")


def test_a_run_is_that_of_the_command(taps_run, tmp_path):
    """Metrics and arrays are those of the files, all of them, with a unit each."""
    scene = load_scene(find_scene("paper_taps"), SHORT)
    written = run_scene(scene, "golden", tmp_path)
    metrics = json.loads((tmp_path / "metrics.json").read_bytes())
    assert {**metrics, "wall_clock_s": 0} == {**taps_run.metrics, "wall_clock_s": 0}
    assert set(written) == set(metrics)
    arrays = load_trace(tmp_path)
    assert len(arrays) == len(taps_run.trace) > 10
    for name, array in arrays.items():
        assert np.array_equal(taps_run.trace[name], array), name
        assert taps_run.trace[columns.NAMES[name][0]] is taps_run.trace[name]
    assert set(taps_run.trace.units) == set(taps_run.trace)
    assert taps_run.trace.units["position"] == "rad"
    assert np.ptp(taps_run.trace["position"]) > 0.01


def test_every_array_has_a_name_and_a_unit(tmp_path):
    """With a port anchor there are more."""
    scene = wh.load_scene("press_hold").with_(
        scene__duration_s=0.01, controller__anchor_auto=True, controller__lambda=1e4
    )
    trace = wh.run(scene, "golden").trace
    assert set(trace) == {name for name, _ in columns.NAMES.values()}
    assert trace.units["position_estimate"] == "rad"


def test_motors_of_a_tip():
    scene = wh.load_scene("phantom_plane").with_(scene__duration_s=0.02, motors__lift__k_t=0.04)
    assert scene["motors.lift.motor.k_t"] == 0.04
    assert scene["motors.turn.motor.k_t"] != 0.04
    done = []
    run = wh.run(scene, progress=done.append)
    assert done[-1] == 1.0
    assert tuple(run.motors) == scene.motors == ("turn", "lift", "reach")
    assert set(run.trace) == {name for name, _ in tip.NAMES.values()}
    rows = len(run.trace["time"])
    assert run.trace["position"].shape == (rows, 3)
    assert run.motors["lift"].trace["torque"].shape == (rows,)
    assert run.motors["lift"].metrics["k_l"] < run.motors["turn"].metrics["k_l"]


def test_motors_apart():
    run = wh.run(wh.load_scene("two_motors").with_(scene__duration_s=0.01))
    assert len(run.trace) == 0
    with pytest.raises(KeyError, match=r"run\.motors has a trace of each motor"):
        run.trace["position"]
    assert all(len(motor.trace["position"]) for motor in run.motors.values())


def test_what_a_controller_leaves_out_is_noted(taps):
    run = wh.run(taps.with_(drive__dead_time_s=50e-9))
    assert any("drive.dead_time_s" in note for note in run.notes)


def test_a_table_of_pandas(taps_run, monkeypatch):
    """Without pandas one clear error; with it every array and the units."""
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="run `pip install pandas`"):
        taps_run.trace.to_pandas()

    class DataFrame(dict):
        """As much of pandas as is used."""

        def __init__(self, columns):
            super().__init__(columns)
            self.attrs = {}

    stand_in = type(sys)("pandas")
    stand_in.DataFrame = DataFrame
    monkeypatch.setitem(sys.modules, "pandas", stand_in)
    table = taps_run.trace.to_pandas()
    assert table.attrs["units"] == taps_run.trace.units
    assert list(table) == list(taps_run.trace)


def test_a_sweep_is_its_runs(taps, tmp_path):
    axes = {"controller.lambda": [5e3, 2e4], "controller.eta_contact": [-1.0, -2.0]}
    seen = []
    rows = wh.sweep(taps, axes, workers=1, progress=lambda *part: seen.append(part))
    assert seen == [(n, 4) for n in range(5)]
    assert [row["controller.lambda"] for row in rows] == [5e3, 5e3, 2e4, 2e4]
    for row in rows:
        assert (row["error"] is None) == (row["controller.eta_contact"] == -1.0)
        if row["error"] is None:
            alone = wh.run(taps.with_(controller__lambda=row["controller.lambda"]))
            assert row["stiffness_predicted"] == alone.metrics["stiffness_predicted"]
            assert row["peak_torque"] == alone.metrics["peak_torque"]
        else:
            assert row["error"].startswith("controller.eta_contact=-2.0: controller.eta_contact")
            assert row["peak_torque"] is None
    for axes, told in (({}, "nothing to sweep"), ({"controller.lambada": [1]}, "did you mean lam")):
        with pytest.raises(wh.SceneError, match=told):
            wh.sweep(taps, axes)


@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.py")))
def test_an_example_runs_to_its_plot(tmp_path, name):
    if name == "board":
        try:
            check_terminals()
        except ToolError as error:
            pytest.skip(str(error))
    source = EXAMPLES / f"{name}.py"
    assert len(source.read_text("utf-8").splitlines()) <= 45
    done = subprocess.run(
        [sys.executable, source], cwd=tmp_path, capture_output=True, text=True, timeout=TIMEOUT_S,
        env={**os.environ, "MPLBACKEND": "agg"}, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    picture = (tmp_path / f"{name}.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 5000
    told = {
        "first_wall": "stiffness: 1.569 N",
        "own_motor": "of 5.64 N·m/rad, K_L",
        "sweep": "8 points, the stiffest 2.1",
        "board": "eta_contact: -0.900, walls at [764, 0, ",
        "surface": "surface error: ",
    }
    assert told[name] in done.stdout
    if name == "board":
        assert "armed: 0" in done.stdout


def test_every_example_is_on_the_page():
    page = (ROOT / "docs" / "python.md").read_text("utf-8")
    paths = sorted(Path(path).name for path in EXAMPLES.glob("*.py"))
    assert len(paths) == 5
    assert [path for path in paths if f"../examples/python/{path}" not in page] == []
