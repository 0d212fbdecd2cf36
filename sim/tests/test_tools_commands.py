# SPDX-License-Identifier: Apache-2.0
"""``python -m wavetools``: the commands that measure and check the repository."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import ModuleType

import pytest
import typer
from wavehaptics.cli.main import OF_A_CHECKOUT
from wavehaptics.runtime.repository import ROOT
from wavetools.cli import main


def call(capsys, monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["wavetools", *arguments])
    with pytest.raises(SystemExit) as ended:
        main.main()
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def test_they_are_those_that_wavehaptics_names():
    assert set(typer.main.get_command(main.app).commands) == set(OF_A_CHECKOUT)


@pytest.mark.parametrize("name", OF_A_CHECKOUT)
def test_help_of_each(capsys, monkeypatch, name):
    status, out, err = call(capsys, monkeypatch, name, "--help")
    assert (status, err) == (0, "")
    assert f"wavetools {name}" in out


def test_the_makefile_calls_what_is_there():
    text = "".join((ROOT / path).read_text() for path in ("Makefile", "boards/boards.mk"))
    called = re.findall(r"-m wavetools ([\w-]+)", text)
    assert sorted([*called, "patch"]) == sorted(OF_A_CHECKOUT)  # of a file, not of the repository
    assert re.findall(r"bin/wavehaptics (\w+)", text) == ["demo", "board", "report"]


def test_an_unknown_option_is_one_line(capsys, monkeypatch):
    status, out, err = call(capsys, monkeypatch, "bench", "--no-such")
    assert (status, out) == (2, "")
    assert re.fullmatch(r"wavetools: [^\n]*--no-such; wavetools --help shows the use\n", err)


@pytest.fixture
def adcs_run(tmp_path, monkeypatch):
    """Scenes and settings that a stand-in for the comparison of ADCs was called with."""
    monkeypatch.chdir(tmp_path)
    calls = []

    def compare(path, settings, out, progress):
        calls.append((path.stem, list(settings), out))
        return {}

    module = ModuleType("wavetools.studies.adcs")
    module.compare, module.adc_table = compare, lambda found: ""
    monkeypatch.setitem(sys.modules, "wavetools.studies.adcs", module)
    return calls


@pytest.mark.parametrize(
    ("arguments", "name"), [((), "paper_taps"), (("--scene", "stiffest"), "stiffest")]
)
def test_adcs_runs_the_scene_that_is_named(capsys, monkeypatch, adcs_run, arguments, name):
    more = ("--out", "found", "--set", "drive.limit_v=3.0")
    status, _, err = call(capsys, monkeypatch, "adcs", *arguments, *more)
    assert (status, err) == (0, "")
    assert adcs_run == [(name, ["drive.limit_v=3.0"], Path("found/adcs.json"))]


def test_adcs_refuses_a_scene_that_is_not_there_or_of_two_motors(capsys, monkeypatch, adcs_run):
    for name, problem in (("stiff", "no such"), ("two_motors", "the scene has 2 motors")):
        status, out, err = call(capsys, monkeypatch, "adcs", "--scene", name)
        assert (status, out) == (2, "")
        assert re.fullmatch(rf"wavetools: [^\n]*{problem}[^\n]*\n", err)
    assert adcs_run == []
