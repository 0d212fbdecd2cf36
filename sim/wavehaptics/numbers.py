# SPDX-License-Identifier: Apache-2.0
"""The numbers of the synthesis in the README pages, between markers that a command fills.

``boards/summary.json`` keeps what the last synthesis came to. The text between
``<!-- begin NAME -->`` and ``<!-- end NAME -->`` of a page is made from it; a test fails where the
two differ, and another where a fresh synthesis comes to something else.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from wavehaptics.boards import ROOT

KEPT = Path("boards", "summary.json")
"""The numbers that the pages show, from the root."""

PAGES = (Path("README.md"), Path("boards", "README.md"))
"""Pages that may hold markers, from the root."""

_SUMMARY = Path("build", "synth", "summary.json")
_RESOURCES = Path("build", "synth", "resources.json")
_MARKED = re.compile(r"(<!-- begin (\S+) -->\n)(.*?)(<!-- end \2 -->)", re.DOTALL)
_DEVICE_NAMES = {"up5k": "iCE40 UP5K", "hx8k": "iCE40 HX8K", "25k": "ECP5-25F"}


class NumbersError(ValueError):
    """Numbers or markers that are missing. The message is one line."""


def keep(root: Path = ROOT) -> None:
    """Take the numbers of ``build/synth`` into ``boards/summary.json``; what is not there stays."""
    kept = json.loads((root / KEPT).read_bytes()) if (root / KEPT).exists() else {}
    if (root / _SUMMARY).exists():
        kept["boards"] = json.loads((root / _SUMMARY).read_bytes())["boards"]
    if (root / _RESOURCES).exists():
        kept["resources"] = json.loads((root / _RESOURCES).read_bytes())
    if not kept:
        raise NumbersError("there are no numbers yet; run `make synth`")
    text = json.dumps(kept, indent=1, ensure_ascii=False)
    (root / KEPT).write_text(text + "\n", encoding="utf-8")


def write(root: Path = ROOT) -> list[Path]:
    """Fill the markers of every page; the pages that have some. :class:`NumbersError`."""
    numbers = _read(root)
    pages = []
    for page in PAGES:
        if not (root / page).exists():
            continue
        old = (root / page).read_text(encoding="utf-8")
        new = filled(old, numbers, str(page))
        if _MARKED.search(old):
            pages.append(page)
        if new != old:
            (root / page).write_text(new, encoding="utf-8")
    return pages


def stale_pages(root: Path = ROOT) -> list[Path]:
    """Pages whose numbers aren't those of ``boards/summary.json``."""
    numbers = _read(root)
    stale = []
    for page in PAGES:
        if (root / page).exists():
            text = (root / page).read_text(encoding="utf-8")
            if filled(text, numbers, str(page)) != text:
                stale.append(page)
    return stale


def filled(text: str, numbers: dict[str, Any], page: str) -> str:
    """``text`` with its markers filled; markers without a table are left to others."""
    begun = re.findall(r"<!-- begin (\S+) -->", text)
    for name in begun:
        if name in TABLES and not re.search(f"<!-- end {re.escape(name)} -->", text):
            raise NumbersError(f"{page}: <!-- begin {name} --> has no <!-- end {name} -->")

    def fill(found: re.Match[str]) -> str:
        if found[2] not in TABLES:
            return found[0]
        return found[1] + TABLES[found[2]](numbers) + found[4]

    return _MARKED.sub(fill, text)


def _read(root: Path) -> dict[str, Any]:
    try:
        return json.loads((root / KEPT).read_bytes())
    except FileNotFoundError:
        raise NumbersError(f"{KEPT} is not there; run `make synth numbers`") from None


# ---- The tables.


def _table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A table of Markdown; the first column to the left, the others to the right."""
    head = list(head)
    lines = [head, ["---", *["--:"] * (len(head) - 1)], *[[str(c) for c in row] for row in rows]]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _boards(numbers: dict[str, Any]) -> str:
    head = ("Board", "FPGA", "Clock", "Tick", "Logic cells", "FF", "DSP", "Block RAM",
            "Reached", "To spare", "Bitstream")  # fmt: skip
    rows = []
    for board in numbers["boards"]:
        part = board["logic_cells"] / board["logic_cells_available"]
        rows.append(
            (
                f"`{board['board']}`",
                _DEVICE_NAMES.get(board["device"], board["device"]),
                f"{board['clock_mhz']:g} MHz",
                f"{board['tick_mhz']:g} MHz"
                + (f" × {board['motors']}" if board["motors"] > 1 else ""),
                f"{board['logic_cells']} ({part:.0%})",
                board["ff"],
                f"{board['dsp']} of {board['dsp_available']}",
                f"{board['block_ram']} of {board['block_ram_available']}",
                f"{_reached(board):.1f} MHz",
                f"{board['spare']:.0%}",
                f"{board['bitstream_bytes'] / 1000:.0f} kB",
            )
        )
    return _table(head, rows)


def _reached(board: dict[str, Any]) -> float:
    return min(board["reached_mhz"], board["dsp_path_mhz"] or board["reached_mhz"])


def _resources(
    table: str, first: str, name: Callable[[dict[str, Any]], str]
) -> Callable[[dict[str, Any]], str]:
    """A row for each block or option, LUT / FF / DSP on each device."""

    def render(numbers: dict[str, Any]) -> str:
        rows: dict[str, dict[str, Any]] = {}
        for row in numbers.get("resources", ()):
            if row["table"] == table:
                rows.setdefault(name(row), {})[row["device"]] = row
        speed = any(r["reached_mhz"] for devices in rows.values() for r in devices.values())
        present = [name for name in _DEVICE_NAMES if any(name in on for on in rows.values())]
        head = [first, *(f"{_DEVICE_NAMES[name]}: LUT / FF / DSP" for name in present)]
        lines = []
        for label, devices in rows.items():
            cells = []
            for device in present:
                row = devices[device]
                cell = f"{row['lut']} / {row['ff']} / {row['dsp']}"
                cells.append(f"{cell}, {row['reached_mhz']:.0f} MHz" if speed else cell)
            lines.append((label, *cells))
        return _table(head, lines)

    return render


TABLES: dict[str, Callable[[dict[str, Any]], str]] = {
    "boards": _boards,
    "block-resources": _resources("blocks", "Block", lambda row: f"`{row['block']}`"),
    "port-resources": _resources("ports", "Motors", lambda row: row["option"].split()[-1]),
    "option-resources": _resources("options", "`wh_controller` with", lambda row: row["option"]),
    "width-resources": _resources(
        "widths", "`wh_wave_core`, data × coefficient", lambda row: row["option"]
    ),
}
"""What stands between the markers of each name."""
