# SPDX-License-Identifier: Apache-2.0
"""``wavehaptics.core``: its files are those of the builds and the lint, and FuseSoC takes it."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
import yaml
from wavehaptics.fpga.boards import load_board
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toml_source import parse
from wavehaptics.scene import load_scene
from wavetools.fpga import synthesis

CORE = ROOT / "wavehaptics.core"
BOARD = "icebreaker"


@pytest.fixture(scope="module")
def core() -> dict[str, Any]:
    text = CORE.read_text(encoding="utf-8")
    assert text.startswith("CAPI=2:\n")
    return yaml.safe_load(text.partition("\n")[2])


def _files(core: dict[str, Any], *filesets: str) -> dict[str, dict[str, Any]]:
    """What the core says of each file: its type, and whether it is included."""
    found = {}
    for name in filesets:
        fileset = core["filesets"][name]
        for entry in fileset["files"]:
            ((path, own),) = entry.items() if isinstance(entry, dict) else ((entry, {}),)
            assert path not in found, path
            found[path] = {"file_type": fileset.get("file_type"), **own}
    return found


def _of(*patterns: str) -> set[str]:
    return {
        path.relative_to(ROOT).as_posix() for pattern in patterns for path in ROOT.glob(pattern)
    }


def test_every_file_is_there(core):
    for path in _files(core, *core["filesets"]):
        assert (ROOT / path).is_file(), path


def test_none_is_forgotten(core):
    """What the lint and the boards' builds read, by the same patterns."""
    assert _files(core, "rtl").keys() == _of("rtl/*.v", "rtl/*.vh")
    assert _files(core, "boards", "ecp5").keys() == _of("boards/*.v")
    assert _files(core, "simulation").keys() == _of("sim/cells/*.v")
    assert _files(core, "example").keys() == _of("examples/use_in_a_design/*.v")


def test_the_bitstream_has_the_boards_sources(core):
    board = load_board(BOARD)
    sources = synthesis.board_design(board, synthesis.OUT / BOARD).sources
    files = _files(core, *core["targets"][BOARD]["filesets"], "ecp5")
    read = {path for path, told in files.items() if path.endswith(".v")}
    assert read == {path.as_posix() for path in sources}
    assert files[board.constraints.as_posix()]["file_type"] == "PCF"


def test_headers_are_included_and_all_else_is_read(core):
    for path, told in _files(core, *core["filesets"]).items():
        assert told.get("is_include_file", False) == path.endswith(".vh"), path
        if not path.endswith(".pcf"):
            assert told["file_type"] == "verilogSource-2005", path


def test_blocks_outside_the_rtl_are_in_its_own_filesets(core):
    """No vendor primitive in what every FPGA gets."""
    for path in _files(core, "rtl", "boards"):
        text = re.sub(r"//.*", "", (ROOT / path).read_text(encoding="utf-8"))
        assert not re.search(r"\b(SB_\w+|EHXPLLL|OSCG|MULT18X18D|DCCA|IFS1P3DX)\b", text), path


def test_targets_use_what_there_is(core):
    for name, target in core["targets"].items():
        assert set(target["filesets"]) <= set(core["filesets"]), name
        assert set(target.get("generate", [])) <= set(core["generate"]), name
        if top := target.get("toplevel"):
            files = _files(core, *target["filesets"])
            assert any(Path(path).stem == top for path in files), name
    for name, made in core["generate"].items():
        assert made["generator"] in core["generators"], name
        if "scene" in made["parameters"]:
            load_scene(ROOT / made["parameters"]["scene"])
    assert (ROOT / core["generators"]["wavehaptics_headers"]["command"]).is_file()


def test_the_bitstream_is_made_as_the_boards(core):
    """FPGA, package, clock and options of the synthesis."""
    board = load_board(BOARD)
    options = core["targets"][BOARD]["flow_options"]
    placer = options["nextpnr_options"]
    assert placer[:3] == [f"--{board.device}", "--package", board.fpga.package]
    asked_mhz = float(placer[placer.index("--freq") + 1])
    assert asked_mhz == pytest.approx(board.clock_hz / 1e6)
    assert int(placer[placer.index("--seed") + 1]) in board.fpga.seeds
    command = synthesis.synthesis_command(board.fpga.family, board.device).split()
    assert options["yosys_synth_options"] == command[1:]


def test_version_is_the_packages(core):
    data, _ = parse((ROOT / "pyproject.toml").read_bytes())
    assert core["name"] == f"::wavehaptics:{data['project']['version']}"


@pytest.mark.parametrize("made", ["icebreaker_headers", "example_headers"])
def test_the_generator_writes_headers_and_their_core(core, tmp_path, made):
    asked = {
        "vlnv": "::wavehaptics-headers:0", "files_root": str(ROOT),
        "parameters": core["generate"][made]["parameters"],
    }  # fmt: skip
    (tmp_path / "asked.yml").write_text(yaml.safe_dump(asked), encoding="utf-8")
    command = ROOT / core["generators"]["wavehaptics_headers"]["command"]
    subprocess.run([sys.executable, command, "asked.yml"], cwd=tmp_path, check=True)
    text = (tmp_path / "headers.core").read_text(encoding="utf-8")
    told = yaml.safe_load(text.partition("\n")[2])
    assert told["name"] == asked["vlnv"]
    names = [next(iter(entry)) for entry in told["filesets"]["headers"]["files"]]
    wanted = "wh_scene.vh" if made == "example_headers" else "wh_board_settings.vh"
    assert wanted in names
    for name in names:
        assert (tmp_path / name).read_text(encoding="utf-8").startswith("// SPDX")


@pytest.mark.skipif(find_spec("fusesoc") is None, reason="there is no FuseSoC")
def test_fusesoc_takes_it(core, tmp_path):
    shutil.copy(CORE, tmp_path)
    found = subprocess.run(
        [sys.executable, "-m", "fusesoc.main", "--cores-root", ".", "core", "show", core["name"]],
        cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    for name in core["targets"]:
        assert re.search(rf"^{name}\s*:", found.stdout, re.MULTILINE), found.stdout
