# SPDX-License-Identifier: Apache-2.0
"""The page docs/use_in_your_design.md: its tables are the RTL's, its commands are the command's."""

from __future__ import annotations

import re

import pytest
import typer
from wavehaptics.cli.main import app
from wavehaptics.fpga.scene_registers import FORMATS, scene_registers
from wavehaptics.runtime.repository import ROOT
from wavehaptics.scene import load_scene
from wavehaptics.words.table import WORDS

PAGE = (ROOT / "docs" / "use_in_your_design.md").read_text(encoding="utf-8")
TEMPLATE = ROOT / "examples" / "use_in_a_design"

PORT = re.compile(r"^ +(input|output) +(?:wire|reg) +(?:\[(.+?)\])? *(\w+)", re.MULTILINE)
ROW = re.compile(r"^\| `(\w+)` \| (in|out) \| (\w+) \|", re.MULTILINE)
SECTION = r"^Of \[`{module}`\].*?(?=^Of \[|^## )"


def _width(bits: str) -> str:
    """A range of the RTL as the page has it."""
    if not bits:
        return "1"
    first = bits.removesuffix(":0").replace("`", "")
    return first.removesuffix("-1") if "-" in first else str(int(first) + 1)


def _ports(module: str) -> list[tuple[str, str, str]]:
    """(name, in or out, width) of the RTL's ports, in its order."""
    text = (ROOT / "rtl" / f"{module}.v").read_text(encoding="utf-8")
    header = text[text.index(f"\nmodule {module}") : text.index("\n);")]
    return [
        (name, {"input": "in", "output": "out"}[direction], _width(bits))
        for direction, bits, name in PORT.findall(header)
    ]


@pytest.mark.parametrize("module", ["wh_wishbone", "wh_device"])
def test_the_port_tables_are_the_rtl(module):
    ports = _ports(module)
    found = re.search(SECTION.format(module=module), PAGE, re.MULTILINE | re.DOTALL)
    assert found is not None
    assert ROW.findall(found[0]) == ports
    assert len(ports) > 15


@pytest.mark.parametrize("module", ["wh_wishbone", "wh_device"])
def test_litex_connects_every_input(module):
    """And no port that isn't there, as far as its text says without LiteX."""
    wrapper = (ROOT / "examples" / "litex" / "wave_haptics.py").read_text(encoding="utf-8")
    part = wrapper[wrapper.index(f'"{module}"') :].partition("# fmt: skip")[0]
    given = {("in" if way == "i" else "out", name)
             for way, name in re.findall(r"\b([io])_(\w+)=", part)}  # fmt: skip
    ports = {(way, name) for name, way, _ in _ports(module)}
    assert given <= ports
    inputs = {name for way, name in ports if way == "in"}
    assert inputs - {name for way, name in given if way == "in"} == {"clk", "rst"}


def test_parameters_are_the_devices():
    """Those of the scene and those of one's choice."""
    text = (ROOT / "rtl" / "wh_device.v").read_text(encoding="utf-8")
    known = set(re.findall(r"parameter integer (\w+)", text))
    part = PAGE[PAGE.index("## Parameters") : PAGE.index("## Ports")]
    named = set(re.findall(r"`([A-Z_0-9]+)`", part))
    assert named <= known
    made = scene_registers(load_scene(TEMPLATE / "scene.toml"))
    assert set(made.parameters) <= named
    template = (TEMPLATE / "use_in_a_design.v").read_text(encoding="utf-8")
    for name in made.parameters:
        assert f"`WH_SCENE_{name}" in template, name


def test_registers_that_the_start_needs_are_there():
    start = PAGE[PAGE.index("## Reset and start-up") : PAGE.index("## FuseSoC")]
    for name in ("settings_busy", "commit", "magnet_start", "clear", "arm", "arm_refused"):
        assert f"`{name}`" in start
        assert name in WORDS


def test_options_of_the_command_are_there():
    command = typer.main.get_command(app).commands["registers"]  # type: ignore[attr-defined]
    options = {option for one in command.params for option in one.opts}
    part = PAGE[PAGE.index("## From a scene") : PAGE.index("## Parameters")]
    named = set(re.findall(r"--[a-z]+", part)) - {"--controller"}
    assert named <= options
    assert {one for one in options if one.startswith("--")} <= named
    for form in FORMATS:
        assert f"`{form}`" in part


def test_addresses_count_from_the_table():
    """`adr_i` has the bits of an address of the table."""
    assert max(word.at(7) if word.row.per != "board" else word.at() for word in WORDS.values()) < (
        1 << 12
    )
