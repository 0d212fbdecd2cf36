# SPDX-License-Identifier: Apache-2.0
"""The command line: what it runs, what it refuses in one line, and how it ends."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
import typer
from wavehaptics.cli import main
from wavehaptics.cli.shared import CONTROLLERS, shown_progress
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toml_source import parse
from wavehaptics.scene import SceneError, shipped_scenes

SCENE = """\
[scene]
name = "bench"
duration_s = 1e-3
[motor]
preset = "re25-118743"
[controller]
tick_hz = 1e4
lambda = 1e3
"""
TIMEOUT_S = 60


@pytest.fixture(autouse=True)
def in_own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench.toml").write_text(SCENE)


@pytest.fixture
def runs(monkeypatch):
    """Calls of a stand-in for the simulation, which takes seconds to import."""
    calls = []

    def run_scene(scene, controller, out, progress, motor):
        calls.append((scene, controller, out))
        progress(0.5)
        assert out.is_dir()
        if scene.scene.name == "refused":
            raise SceneError("refused: this controller can't; take another")
        if scene.scene.name == "interrupted":
            raise KeyboardInterrupt
        if scene.scene.name == "full":
            raise OSError(28, "No space left on device", str(out))
        return {"scene": scene.scene.name, "peak_torque": 0.0212345, "hold_error": None, "ticks": 7}

    module = ModuleType("wavehaptics.ladder.run")
    module.run_scene = run_scene
    monkeypatch.setitem(sys.modules, "wavehaptics.ladder.run", module)
    return calls


def call(capsys, monkeypatch, *arguments: str) -> tuple[int, str, str]:
    """Exit status, stdout and stderr of the command, run in this process."""
    monkeypatch.setattr(sys, "argv", ["wavehaptics", *arguments])
    with pytest.raises(SystemExit) as ended:
        main.main()
    captured = capsys.readouterr()
    return ended.value.code, captured.out, captured.err


SWALLOWED = """
import signal
import time
from wavehaptics.cli import main

# A shell has its children in the background ignore it.
signal.signal(signal.SIGINT, signal.default_int_handler)

class Interrupted:
    def __del__(self):
        raise KeyboardInterrupt

def app(**options):
    interrupted = Interrupted()
    del interrupted
    time.sleep(30)

main.app = app
main.main()
"""


def test_ctrl_c_that_python_only_reports_ends_the_command():
    """It came while something was thrown away, where an exception can't leave."""
    ended = subprocess.run(
        [sys.executable, "-c", SWALLOWED], capture_output=True, text=True, timeout=TIMEOUT_S,
        check=False,
    )  # fmt: skip
    assert ended.returncode == 130
    assert ended.stderr == "wavehaptics: interrupted\n"


def call_process(*arguments: str) -> subprocess.CompletedProcess[str]:
    """The command as a user starts it."""
    return subprocess.run(
        [sys.executable, "-m", "wavehaptics", *arguments],
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
        check=False,
    )


def assert_refused(status: int, out: str, err: str, fragment: str) -> None:
    assert status == 2
    assert out == ""
    assert re.fullmatch(r"wavehaptics: [^\n]+\n", err)
    assert fragment in err


def test_run_with_defaults(capsys, monkeypatch, runs):
    status, out, err = call(capsys, monkeypatch, "run", "bench.toml")
    assert (status, err) == (0, "")
    ((scene, controller, folder),) = runs
    assert scene.scene.name == "bench"
    assert controller == "golden"
    assert folder == Path("build/runs/bench-golden")
    assert re.search(r"^peak_torque +0.02123  N·m$", out, re.MULTILINE)
    assert re.search(r"^ticks +7$", out, re.MULTILINE)
    assert "hold_error" not in out
    assert out.endswith(f"results in {folder}\n")


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_run_with_options(capsys, monkeypatch, runs, controller):
    status, _, err = call(
        capsys,
        monkeypatch,
        *("run", "paper_taps", "--controller", controller, "--out", "deep/down"),
        *("--set", "controller.tick_hz=200e3", "--set", "motor.preset=re40-148877"),
    )
    assert (status, err) == (0, "")
    ((scene, name, folder),) = runs
    assert scene.scene.name == "paper_taps"
    assert scene.controller.tick_hz == 200e3
    assert scene.motor.preset == "re40-148877"
    assert (name, folder) == (controller, Path("deep/down"))


def test_progress_on_a_terminal_only(capsys, monkeypatch, runs):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    status, out, err = call(capsys, monkeypatch, "run", "bench.toml")
    assert status == 0
    assert "bench on golden" in err
    assert "bench on golden" not in out


def test_progress_before_the_first_part(capsys, monkeypatch):
    """While what is simulated is built there is a bar as well."""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    with shown_progress("press_hold on pins"):
        pass
    assert "press_hold on pins" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "status", "fragment"),
    [
        ("refused", 2, "wavehaptics: refused: this controller can't; take another"),
        ("full", 2, "No space left on device"),
        ("interrupted", 130, "wavehaptics: interrupted"),
    ],
)
def test_runs_that_end_early(capsys, monkeypatch, runs, name, status, fragment):
    ended, out, err = call(capsys, monkeypatch, "run", "bench.toml", "--set", f"scene.name={name}")
    assert (ended, out) == (status, "")
    assert fragment in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        ((), "Missing command"),
        (("rum",), "No such command"),
        (("run",), "Missing argument 'SCENE'"),
        (("run", "bench.toml", "--speed", "1"), "No such option"),
        (("run", "bench.toml", "more"), "unexpected extra argument"),
        (("run", "bench.toml", "--set"), "requires an argument"),
        (("run", "bench.toml", "--controller", "Gold"), "did you mean golden? the controllers are"),
        (("run", "bench.toml", "--controller", ""), "analog, golden, core, pins, encoder"),
        (("run", "bench.toml", "--out", "bench.toml"), "--out bench.toml: can't be written"),
        (("run", "bench.toml", "--out", "bench.toml/x"), "can't be written"),
        (("run", "bench.toml", "--out", "x" * 300), "can't be written"),
        (("run", "bench.toml", "--set", "controller.tick_hz=0"), "--set controller.tick_hz=0: "),
        (("run", "none.toml"), "none.toml: no such file"),
        (("run", ""), "is a directory"),
        (("check", "."), "is a directory"),
        (("check", "paper_tap"), "did you mean paper_taps?"),
        (("check", "bench.toml", "--set", "motor.L_h=0.24 mH"), "write 0.24e-3"),
        (("check", "bench.toml", "--set", "motor.\udcff=1"), "is not UTF-8"),
        (("board", "--virtual", "impact", "--hand", "hand"), "impact has no hand that can be led"),
        (("board", "--virtual", "press_hold", "--hand", "bench.toml"), "is there and no socket"),
        (("board", "scope", "--virtual", "press_hold", "--port", "p"), "is a board of its own"),
        (("board", "scope", "--scene", "press_hold"), "--scene goes with --port"),
        (("board", "scope", "--counts", "400"), "--counts goes with --port"),
        (("board", "scope", "--port", "p", "--set", "motor.k_t=1"), "name one with --scene"),
        (("board", "scope", "--virtual", "no_such"), "no_such"),
    ],
)
def test_refused(capsys, monkeypatch, runs, arguments, fragment):
    assert_refused(*call(capsys, monkeypatch, *arguments), fragment)
    assert runs == []


def test_out_without_permission(capsys, monkeypatch, runs, tmp_path):
    folder = tmp_path / "locked"
    folder.mkdir(mode=0o500)
    if os.access(folder, os.W_OK):
        pytest.skip("root writes everywhere")
    assert_refused(*call(capsys, monkeypatch, "run", "bench.toml", "--out", str(folder)), "denied")


def test_check(capsys, monkeypatch):
    status, told, err = call(capsys, monkeypatch, "check", "bench.toml")
    assert (status, err) == (0, "")
    first, *others = told.splitlines()
    assert first == "bench.toml: ok"
    assert all(line.startswith("not on `encoder`: bench.toml:7: servo") for line in others)


@pytest.mark.parametrize("name", main.OF_A_CHECKOUT)
def test_a_command_of_the_repository_says_where_it_is(capsys, monkeypatch, name):
    monkeypatch.setattr(main, "find_spec", lambda name: None)
    ended = call(capsys, monkeypatch, name, "--out", "x")
    assert_refused(*ended, f"run `python -m wavetools {name}` in a checkout")


def test_a_command_of_the_repository_runs_in_a_checkout():
    """As it always did, with a note of its new name."""
    words = ["-m", "wavehaptics", "soak", "--help"]
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True)
    assert done.returncode == 0
    assert "--ticks" in done.stdout
    assert done.stderr == "wavehaptics: soak is `python -m wavetools soak`\n"


def test_report_refuses_workers_of_a_cluster(capsys, monkeypatch):
    """A cluster has its own: the option would say nothing."""
    ended = call(capsys, monkeypatch, "report", "--cluster", "nowhere:1", "--workers", "3")
    assert_refused(*ended, "--workers 3")


@pytest.mark.parametrize(
    ("words", "fragment"),
    [
        (("board", "get", "x", "--virtual"), "--virtual; it belongs to `wavehaptics board "
         "--virtual SCENE`, which runs by itself in another terminal; `get` reaches it by --port"),
        (("board", "get", "x", "--virtual", "press_hold"), "`wavehaptics board --virtual SCENE`"),
        (("board", "arm", "--link", "x"), "it belongs to `wavehaptics board --link PATH`"),
        (("board", "identify", "--counts", "9", "--paced"), "to `wavehaptics board --paced`"),
        (("run", "bench.toml", "--version"), "it belongs to `wavehaptics --version`"),
        (("board", "info", "--version"), "it belongs to `wavehaptics --version`"),
        (("board", "--port", "x", "get", "root"), "--port; write it behind the command, as in "
         "`wavehaptics board get --port`"),
        (("board", "--counts", "9", "identify"), "`wavehaptics board identify --counts`"),
        (("--controller", "pins", "run", "bench.toml"), "`wavehaptics run --controller`"),
        (("--port", "x", "board", "get", "root"), "`wavehaptics board get --port`"),
        (("--virtual", "press_hold", "board"), "`wavehaptics board --virtual`"),
        (("board", "get", "x", "--no-such"), "--no-such; wavehaptics --help shows the use"),
        (("--no-such",), "--no-such; wavehaptics --help shows the use"),
    ],
)  # fmt: skip
def test_an_option_in_the_wrong_place(capsys, monkeypatch, words, fragment):
    """It is told where it belongs."""
    assert_refused(*call(capsys, monkeypatch, *words), fragment)


def test_scenes(capsys, monkeypatch):
    status, out, _ = call(capsys, monkeypatch, "scenes")
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()] == list(shipped_scenes())
    assert all(len(line.split()) > 3 for line in out.splitlines())


def test_help(capsys, monkeypatch):
    status, out, _ = call(capsys, monkeypatch, "run", "--help")
    assert status == 0
    assert "TABLE.KEY=VALUE" in out


def test_version_is_the_packages(capsys, monkeypatch):
    project, _ = parse((ROOT / "pyproject.toml").read_bytes())
    status, out, _ = call(capsys, monkeypatch, "--version")
    assert (status, out) == (0, f"wavehaptics {project['project']['version']}\n")


def told_of(command) -> str:
    """What a command's help says of it; of a group of commands what the group was given."""
    return command.help if hasattr(command, "commands") else command.callback.__doc__


@pytest.mark.parametrize("command", [None, *sorted(typer.main.get_command(main.app).commands)])
def test_help_says_every_word(capsys, monkeypatch, command):
    """Also those in brackets, which markup takes for its own."""
    monkeypatch.setenv("COLUMNS", "200")
    group = typer.main.get_command(main.app)
    asked = group if command is None else group.commands[command]
    texts = [one.help or "" for one in asked.params if hasattr(one, "help")]
    if command is None:
        texts.append(main.app.info.help)
        texts += [told_of(one).partition("\n\n")[0] for one in group.commands.values()]
    else:
        texts.append(told_of(asked))
    status, out, _ = call(capsys, monkeypatch, *([command] if command else []), "--help")
    assert status == 0
    words = [word for text in texts for word in text.replace("\\[", "[").split()]
    assert len(words) >= 4
    assert [word for word in words if word not in out] == []


@pytest.mark.parametrize(
    ("scene", "status", "fragment"),
    [
        (SCENE, 0, ""),
        (SCENE + "eta_free = 2\n", 2, "bad.toml:9: controller.eta_free = 2 is out of range"),
        (SCENE + "eta_free = \n", 2, "bad.toml:9: not valid TOML"),
        (SCENE + "[thermal]\nrth = 1\n", 2, "bad.toml:10: unknown key thermal.rth"),
    ],
)
def test_status_of_the_process(scene, status, fragment):
    Path("bad.toml").write_text(scene)
    ended = call_process("check", "bad.toml")
    assert ended.returncode == status
    if status:
        assert_refused(ended.returncode, ended.stdout, ended.stderr, fragment)


def test_bad_scene_is_refused_before_anything_slow_is_imported():
    """numba alone takes longer than the whole refusal."""
    code = (
        "import runpy, sys\n"
        "sys.argv = ['wavehaptics', 'run', 'bench.toml', '--set', 'motor.L_h=-1']\n"
        "try:\n"
        "    runpy.run_module('wavehaptics', run_name='__main__', alter_sys=True)\n"
        "finally:\n"
        "    print([m for m in sys.modules if m in {'numba', 'scipy'}])\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=TIMEOUT_S, check=False
    )
    assert ended.stdout == "[]\n"
    assert_refused(ended.returncode, "", ended.stderr, "motor.L_h = -1")


def test_plain_ascii_streams():
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    ended = subprocess.run(
        [sys.executable, "-m", "wavehaptics", "check", "bench.toml", "--set", "motor.R_ohm=Ω"],
        capture_output=True,
        timeout=TIMEOUT_S,
        check=False,
        env=environment,
    )
    assert ended.returncode == 2
    assert ended.stderr.startswith(b"wavehaptics: --set motor.R_ohm=")
