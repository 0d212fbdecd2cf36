# SPDX-License-Identifier: Apache-2.0
"""The pages: their tables come from commands, their links lead somewhere, the README is short."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from wavehaptics.fpga.boards import board_names, load_board
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toml_source import parse
from wavetools.pages import design, filler, front_picture

LONGEST_README = 200
WIDEST_PROSE = 120
PROSE = ("*.md", "boards/**/*.md", "docs/**/*.md", "formal/*.md", "rtl/*.md", "sim/scenes/*.md")

TYPED = re.compile(r"\d[.,]\d|·10|\d ?%")
"""What a measured number looks like in a table."""


def test_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= LONGEST_README


def test_prose_is_no_wider_than_an_editor():
    """Tables, code and a picture's text may be."""
    found = [path for pattern in PROSE for path in ROOT.glob(pattern)]
    assert len(found) > 30
    wide = []
    for path in found:
        text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
        wide += [
            f"{path.relative_to(ROOT)}: {line}"
            for line in text.splitlines()
            if len(line) > WIDEST_PROSE and not line.lstrip().startswith(("|", "![", "<!"))
        ]
    assert wide == []


@pytest.mark.parametrize("name", filler.TABLES)
def test_every_table_is_on_a_page(name):
    assert filler.marked_pages(name)


@pytest.mark.parametrize("page", filler.pages(), ids=str)
def test_no_table_of_numbers_is_typed_by_hand(page):
    """Outside the markers a table holds words; what boards/ computes of parts stays its own."""
    text = (ROOT / page).read_text(encoding="utf-8")
    unmarked = re.sub(r"<!-- begin (\S+) -->\n.*?<!-- end \1 -->", "", text, flags=re.DOTALL)
    typed = [line for line in unmarked.splitlines() if line[:1] == "|" and TYPED.search(line)]
    if page.parts[0] == "boards":
        typed = [line for line in typed if "`" in line and "MHz" in line]
    assert typed == []


def test_status_knows_what_the_boards_have():
    """The rows are the board tops' own parameters, and one that isn't there would be seen."""
    options = design.options_of_boards()
    assert set(options) == {n for n in board_names() if not load_board(n).fpga.on_demand}
    assert options["hx8k"]["SHARED"] == 1
    assert options["icebreaker"]["SHARED"] == 0
    assert options["ulx3s_three"]["N"] == 3
    known = re.findall(
        r"parameter integer (\w+)", (ROOT / "rtl" / "wh_controller.v").read_text(encoding="utf-8")
    )
    rows = {parameter for _, parameter in design.STATUS if parameter}
    assert rows <= set(known)
    given = {name for of_board in options.values() for name in of_board}
    # Sizes, and what changes no word.
    assert given - {"WALLS", "DELAY_LOG2", "SHARED", "OSR"} <= rows
    scenes = design.options_of_boards(scenes=True)
    assert scenes["boards/ulx3s/patterns.toml"]["MODES"] == 1 > options["ulx3s"]["MODES"]
    assert scenes["boards/ulx3s/sigma_delta.toml"]["ADC"] == 2 > options["ulx3s"]["ADC"] == 0
    assert options["ulx3s_brushless"]["SENSE"] == options["ulx3s_brushless"]["ANCHOR"] == 1


LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
IMAGE = re.compile(r'<img src="([^"]+)"')
NARROW = 44
"""Characters of code that a telephone, 390 px wide, shows beside each other."""


@pytest.mark.parametrize("page", [p for p in filler.pages() if p.suffix == ".md"], ids=str)
def test_links_lead_to_files(page):
    """On GitHub as well, where nothing checks them; `make docs` checks the places in pages."""
    text = (ROOT / page).read_text(encoding="utf-8")
    links = LINK.findall(text) + IMAGE.findall(text)
    here = [link for link in links if "://" not in link]
    missing = [link for link in here if not (ROOT / page.parent / link).exists()]
    assert here or page.parts[0] == "docs"
    assert missing == []


def test_code_on_the_front_page_is_narrow():
    """What a person writes there; a command's output is as wide as it is."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    unmarked = re.sub(r"<!-- begin (\S+) -->\n.*?<!-- end \1 -->", "", text, flags=re.DOTALL)
    lines = "".join(
        re.findall(r"^```\n(.*?)^```$", unmarked, re.DOTALL | re.MULTILINE)
    ).splitlines()
    assert lines
    assert [line for line in lines if len(line) > NARROW] == []


def test_pages_are_found(tmp_path):
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "b.md").write_text("<!-- begin boards -->\n")
    (tmp_path / "README.md").write_text("")
    assert filler.pages(tmp_path) == [Path("README.md"), Path("docs", "b.md")]
    assert filler.marked_pages("boards", tmp_path) == [Path("docs", "b.md")]


NAMED_TEST = re.compile(r"`(test_\w+)`")


@pytest.mark.parametrize("page", filler.pages(), ids=str)
def test_tests_that_pages_name_are_there(page):
    """Each in a file that the page links to."""
    text = (ROOT / page).read_text(encoding="utf-8")
    names = set(NAMED_TEST.findall(text))
    files = {link for link in LINK.findall(text) if Path(link).name.startswith("test_")}
    defined = {
        name
        for link in files
        for name in re.findall(
            r"^def (test_\w+)", (ROOT / page.parent / link).read_text(encoding="utf-8"), re.M
        )
    }
    assert names <= defined


TEXTS = [
    path.relative_to(ROOT)
    for pattern in ("*.md", "boards/**/*.md", "docs/**/*.md", "formal/*.md", "rtl/*.md",
                    "sim/scenes/*.md")
    for path in sorted(ROOT.glob(pattern))
]  # fmt: skip
"""All that is written for people."""

COMMAND = re.compile(r"python -m ((wavehaptics|wavetools)[\w.]*)")
FOLDERS = {"wavehaptics": ROOT / "sim", "wavetools": ROOT / "tools"}


@pytest.mark.parametrize("page", TEXTS, ids=str)
def test_modules_that_pages_call_do_something(page):
    """One without a main would be imported, and end well with nothing done."""
    for module, package in COMMAND.findall((ROOT / page).read_text(encoding="utf-8")):
        path = FOLDERS[package] / Path(*module.split("."))
        path = path / "__main__.py" if path.is_dir() else path.with_suffix(".py")
        assert path.exists(), module
        named = path.name == "__main__.py"
        assert named or 'if __name__ == "__main__":' in path.read_text(encoding="utf-8"), module


LINKED_NAME = re.compile(r"\[`([^`]+)`\]\(([^)#\s]+)\)")
NAME_BEHIND = re.compile(r"\[`[^`]+`\]\(([^)#\s]+)\)\s+`([A-Za-z]\w+)`")


@pytest.mark.parametrize("page", TEXTS, ids=str)
def test_what_links_to_a_file_is_in_it(page):
    """A name in backticks is the file's own, or its folder's, or stands in it."""
    for name, link in LINKED_NAME.findall((ROOT / page).read_text(encoding="utf-8")):
        if "://" in link:
            continue
        path = (ROOT / page.parent / link).resolve()
        places = (path.as_posix(), path.parent.as_posix())
        own = any(place.endswith(f"/{name.rstrip('/')}") for place in places)
        words = name.partition("(")[0]
        assert own or path.stem == name or words in path.read_text(encoding="utf-8"), name
    for link, name in NAME_BEHIND.findall((ROOT / page).read_text(encoding="utf-8")):
        path = ROOT / page.parent / link
        found = path.read_text(encoding="utf-8")
        assert re.search(rf"^(def|class) {name}\b|^{name}\b", found, re.MULTILINE), (link, name)


STEP = re.compile(r"^\d+\. .*\n(?:   .*\n)*", re.MULTILINE)


def test_steps_name_what_is_in_their_files():
    """What CONTRIBUTING says to change in a file is there under that name."""
    seen = set()
    for step in STEP.findall((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")):
        paths = [ROOT / link for _, link in LINKED_NAME.findall(step)]
        text = "".join(p.read_text(encoding="utf-8") for p in paths if p.is_file())
        for name in re.findall(r"(?<!\[)`([A-Za-z_]\w*)`", step):
            if (ROOT / name).is_dir():
                continue
            assert re.search(rf"\b{name}\b", text), (name, step)
            seen.add(name)
    assert {"_NEEDS", "KEYS"} <= seen


def test_architecture_names_every_block():
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    blocks = {path.stem for path in (ROOT / "rtl").glob("wh_*.v")}
    assert set(re.findall(r"rtl/(wh_\w+)\.v", text)) == blocks


@pytest.mark.parametrize(
    ("package", "head"), [("wavehaptics", "| layer |"), ("wavetools", "| layer of the tools |")]
)
def test_architecture_has_the_layers_of_a_package(package, head):
    """Each folder once, and none above what it may import, which pyproject.toml says."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    shown = text.partition(head)[2].partition("\n\n")[0]
    told = [
        name
        for row in re.findall(r"^\| (`.*?) \|", shown, re.MULTILINE)
        for name in re.findall(r"`(\w+)`", row)
    ]
    folders = {path.parent.name for path in (FOLDERS[package] / package).glob("*/__init__.py")}
    assert sorted(told) == sorted(folders)
    project, _ = parse((ROOT / "pyproject.toml").read_bytes())
    (layers,) = (
        contract
        for contract in project["tool"]["importlinter"]["contracts"]
        if contract["type"] == "layers" and contract["containers"] == [package]
    )
    height = {
        name: -place for place, names in enumerate(layers["layers"]) for name in names.split(" | ")
    }
    assert told == sorted(told, key=height.__getitem__)


def test_version_is_one():
    project, _ = parse((ROOT / "pyproject.toml").read_bytes())
    version = project["project"]["version"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"\nversion: {version}\n" in citation
    (newest, *_) = re.findall(r"^## \[(\S+)\] - \d{4}-\d\d-\d\d$", changelog, re.MULTILINE)
    assert newest == version
    core = (ROOT / "wavehaptics.core").read_text(encoding="utf-8")
    assert f"\nname: ::wavehaptics:{version}\n" in core
    answers = (ROOT / "rtl" / "wh_modbus.v").read_text(encoding="utf-8")
    ((length, told),) = re.findall(r"REVISION = \{8'd2, 8'd(\d+), \"(\S+)\"\}", answers)
    assert (int(length), told) == (len(told), f"v{version}")


def test_front_page_compares_walls_of_the_demos_motor():
    """No wave wall in it is above the K_L that stands beside it, and both sides are told."""
    measured = json.loads((ROOT / filler.MEASURED).read_bytes())
    usual = front_picture.usual(measured["report"]["ratios"])
    assert "servo at 1 kHz" in usual["case"]
    assert usual["wave"] < measured["demo"][-1]["k_l"]
    table = filler.TABLES["results"](measured)
    (row,) = [line for line in table.splitlines() if "encoder's servo at 1 kHz" in line]
    assert f"| {usual['wave']:.3g} against {usual['encoder']:.3g} N·m/rad; at equal rates" in row


def test_front_picture_shows_the_first_tap(tmp_path):
    """Its lines end where the first tap is deepest, whatever the later ones do."""
    t = np.linspace(0.0, 1.5, 3001)
    x = -0.01 * np.cos(4 * np.pi * t) * np.where(t < 0.5, 1.0, 2.0)
    trace = {"t": t, "x": x, "torque": -2.0 * np.maximum(x, 0.0), "contact": x > 0}
    for folder in ("", "analog", "stiffest"):
        (tmp_path / folder).mkdir(exist_ok=True)
        np.savez(tmp_path / folder / "trace.npz", **trace)
    found = front_picture.way_in(trace)
    assert found[0][-1] == pytest.approx(10.0, rel=1e-3)
    assert found[1] == pytest.approx(2.0 * found[0])
    paths = front_picture.draw(tmp_path, {"encoder": 0.25}, 2.28, tmp_path / "pages")
    assert [path.name for path in paths] == ["tap.png", "walls.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)
