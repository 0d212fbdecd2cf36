# SPDX-License-Identifier: Apache-2.0
"""What is built anew for a simulator, and what is not."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import simulators
from simulators import BUILD_DIR, RTL_DIR, SimulationError, simulate

pytestmark = pytest.mark.kept

BLOCK = "wh_synchroniser"
SECOND = "second_q <= first_q;"


def copied_rtl(monkeypatch, folder: Path, simulator: str) -> Path:
    """A copy of ``rtl`` that is built in its place."""
    rtl = folder / "rtl"
    shutil.copytree(RTL_DIR, rtl)
    arguments = [part.replace(str(RTL_DIR), str(rtl)) for part in simulators._BUILD_ARGS[simulator]]
    monkeypatch.setitem(simulators._BUILD_ARGS, simulator, arguments)
    monkeypatch.setattr(simulators, "RTL_DIR", rtl)
    return rtl


def test_a_build_follows_its_sources(monkeypatch, tmp_path, simulator):
    """It is used again until a source of it changes, and what fails then is what was changed."""
    rtl = copied_rtl(monkeypatch, tmp_path, simulator)
    stamp = BUILD_DIR / "test_simulators" / simulator / "built"

    def built() -> int:
        simulate(simulator, BLOCK, "tb_synchroniser", {"WIDTH": 5}, name="test_simulators")
        return stamp.stat().st_mtime_ns

    stamp.unlink(missing_ok=True)
    first = built()
    with (rtl / "wh_anchor.v").open("a") as file:
        file.write("// no business of this block\n")
    assert built() == first
    if simulator == "verilator":
        return  # its builds are slow, and how one is found to be old doesn't depend on it
    source = rtl / f"{BLOCK}.v"
    text = source.read_text()
    assert text.count(SECOND) == 1
    source.write_text(text.replace(SECOND, SECOND.replace("first_q", "level_i")))
    with pytest.raises(SimulationError, match="tests failed"):
        built()
    assert stamp.stat().st_mtime_ns != first


def test_used_files_follow_modules_and_headers():
    used = simulators._used_files([RTL_DIR / "wh_adc_serial.v"], [])
    names = {path.name for path in used}
    assert {"wh_adc_serial.v", "wh_formats.vh"} <= names
    assert "wh_anchor.v" not in names
    whole = simulators._used_files([RTL_DIR / "wh_controller.v"], [])
    assert {path.name for path in whole} >= {"wh_anchor.v", "wh_truncate.v", "wh_faults.vh"}
