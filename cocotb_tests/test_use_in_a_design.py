# SPDX-License-Identifier: Apache-2.0
"""The template of ``examples/use_in_a_design``: linted, elaborated, started and let run."""

import json
import subprocess
from pathlib import Path

import pytest
from simulators import BUILD_DIR, simulate
from wavehaptics.fpga.scene_registers import as_text, scene_registers
from wavehaptics.ladder.verilated import verilator_environment
from wavehaptics.runtime.files import write_text
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import find_scene, load_scene

TEMPLATE = ROOT / "examples" / "use_in_a_design"
SOURCES = (TEMPLATE / "use_in_a_design.v", TEMPLATE / "start_up.v")

# Its own scene, three motors, and a brushless one.
CASES = {
    "own": (TEMPLATE / "scene.toml", (), 1),
    "three": (TEMPLATE / "scene.toml", ("controller.tick_hz=250e3",), 3),
    "brushless": (find_scene("brushless_hold"), (), 1),
}


@pytest.fixture
def include(case: str, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the case's ``wh_scene.vh``; the bench finds the scene in the environment."""
    path, overrides, motors = CASES[case]
    monkeypatch.setenv("WH_SCENE", json.dumps((str(path), overrides, motors)))
    folder = BUILD_DIR / f"use_in_a_design-include-{case}"
    text = as_text(scene_registers(load_scene(path, overrides), motors), "verilog")
    write_text(folder / "wh_scene.vh", text)
    return folder


@pytest.mark.parametrize("case", CASES)
def test_the_template_is_clean(include: Path) -> None:
    """By the same lint as the RTL, with every module below it."""
    program, environment = verilator_environment()
    command = [
        program, "--lint-only", "-Wall", "--default-language", "1364-2005", f"-I{ROOT / 'rtl'}",
        f"-I{TEMPLATE}", f"-I{include}", "--top-module", "use_in_a_design", str(SOURCES[0]),
    ]  # fmt: skip
    found = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
    assert "%" not in found.stderr


@pytest.mark.parametrize("case", CASES)
def test_it_starts_with_the_scenes_settings(
    include: Path, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COCOTB_TEST_FILTER", "the_devices_settings")
    simulate(
        "icarus", "use_in_a_design", "tb_use_in_a_design", name=f"use_in_a_design-{case}",
        sources=SOURCES, includes=[include],
    )  # fmt: skip


@pytest.mark.parametrize("case", ["own"])
def test_it_runs(include: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COCOTB_TEST_FILTER", "a_press")
    simulate(
        "verilator", "use_in_a_design", "tb_use_in_a_design", name="use_in_a_design-runs",
        sources=SOURCES, includes=[include],
    )  # fmt: skip
