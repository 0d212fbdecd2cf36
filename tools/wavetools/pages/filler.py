# SPDX-License-Identifier: Apache-2.0
"""The numbers in the pages, between markers that a command fills.

``boards/summary.json`` keeps what the last synthesis came to, ``sim/docs/measured.json`` what the
last demo, report, bench, study of holding and runs for tables found, and all that makes it
reliable, and ``sim/docs/faults.json`` how soon each fault switches off; of a quick run nothing is
kept. The text between ``<!-- begin NAME -->`` and ``<!-- end NAME -->`` of a page is made from it;
a test fails where the two differ, and another where a fresh synthesis comes to something else.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

from wavehaptics.runtime.files import replacing, write_json, write_text
from wavehaptics.runtime.repository import ROOT
from wavehaptics.studies import fault_table
from wavehaptics.studies.demo import RUNS as DEMO_RUNS

from wavetools import markers
from wavetools.checks import link_soak, soak
from wavetools.fpga.synthesis import Result
from wavetools.pages import (
    design,
    faults,
    front_picture,
    reliability,
    report_and_bench,
    runs,
    words,
)
from wavetools.pages import port_anchor as holding_tables
from wavetools.studies import gallery, surfaces
from wavetools.studies.anchored import pictures as holding_pictures

KEPT = Path("boards", "summary.json")
"""The numbers that the pages show, from the root."""

MEASURED = Path("sim", "docs", "measured.json")
"""What else has been measured and the pages show, from the root."""

PAGES = (
    "README.md", "boards/README.md", "docs/*.md", "rtl/faults.md", "rtl/wh_faults.vh",
    "rtl/wh_settings_rom.vh", "rtl/wh_words.vh", "rtl/wh_sine.vh",
    "sim/c/wavehaptics_words.h",
)  # fmt: skip
"""Pages that may hold markers, as patterns from the root."""


def pages(root: Path = ROOT) -> list[Path]:
    """The pages that are there, from the root."""
    return [path.relative_to(root) for pattern in PAGES for path in sorted(root.glob(pattern))]


def marked_pages(name: str, root: Path = ROOT) -> list[Path]:
    """The pages with the markers of a table."""
    mark = f"<!-- begin {name} -->"
    return [page for page in pages(root) if mark in (root / page).read_text(encoding="utf-8")]


_SUMMARY = Path("build", "synth", "summary.json")
_RESOURCES = Path("build", "synth", "resources.json")
_ADCS = Path("build", "adcs", "adcs.json")
_REPORT = Path("build", "report", "report.json")
_BENCH = Path("build", "bench", "summary.json")
_HOLDING = Path("build", "holding", "holding.json")
_TABLED = Path("build", "tables", "tables.json")
_SENSING = Path("build", "sensing", "sensing.json")
_ENCODERS = Path("build", "encoders", "encoders.json")
_DEMO = Path("build", "demo")
_FORMAL = Path("build", "formal", "summary.json")
_SOAK = Path("build", "soak", "summary.json")
_LINK_SOAK = Path("build", "soak-link", "summary.json")
_MUTATION = Path("build", "mutate", "summary.json")
_COVERAGE = Path("build", "coverage", "summary.json")
_DEVICE_NAMES = {
    "up5k": "iCE40 UP5K", "hx8k": "iCE40 HX8K", "25k": "ECP5-25F", "um5g-85k": "ECP5-5G-85F",
}  # fmt: skip


class NumbersError(ValueError):
    """Numbers or markers that are missing. The message is one line."""


def keep(root: Path = ROOT) -> list[Path]:
    """Take the numbers of ``build`` into the files that are kept; what is not there stays.

    So do the numbers of a whole run when the last one was a part: the files of those are returned.
    """
    kept = json.loads((root / KEPT).read_bytes()) if (root / KEPT).exists() else {}
    if (root / _SUMMARY).exists():
        kept["boards"] = json.loads((root / _SUMMARY).read_bytes())["boards"]
        expected = {field.name for field in fields(Result)}
        if any(set(board) != expected for board in kept["boards"]):
            raise NumbersError(f"{_SUMMARY} is that of another version; run `make synth`")
    if (root / _RESOURCES).exists():
        kept["resources"] = json.loads((root / _RESOURCES).read_bytes())
    if (root / _ADCS).exists():
        kept["adcs"] = json.loads((root / _ADCS).read_bytes())
        if kept["adcs"]["scene"] != "paper_taps" or kept["adcs"].get("settings"):
            raise NumbersError(f"{_ADCS} is of another scene than the pages'; run `make adcs`")
    measured, parts = _last_measured(root)
    if not kept and not measured:
        raise NumbersError("there are no numbers yet; run `make synth`")
    for path, numbers in ((KEPT, kept), (MEASURED, measured)):
        if numbers:
            write_json(root / path, _shortened(numbers), indent=1)
    for found, names in (
        (_REPORT, report_and_bench.PICTURES),
        (_HOLDING, holding_pictures.PICTURES),
        (_TABLED, (surfaces.PICTURE, gallery.PICTURE)),
    ):
        for name in names:
            picture = root / found.with_name(name)
            if found not in parts and picture.exists():
                with replacing(root / MEASURED.parent / name) as shown:
                    shown.write_bytes(picture.read_bytes())
    if (root / _DEMO / "stiffest" / "trace.npz").exists() and {"demo", "report"} <= set(measured):
        usual = front_picture.usual(measured["report"]["ratios"])
        k_l = measured["demo"][-1]["k_l"]
        front_picture.draw(root / _DEMO, usual, k_l, root / MEASURED.parent)
    return parts


_STUDIES: dict[Path, tuple[str, Callable[[dict[str, Any]], Any]]] = {
    _REPORT: ("report", report_and_bench.of_report),
    _BENCH: ("bench", report_and_bench.of_bench),
    _HOLDING: ("holding", holding_tables.of_holding),
    _TABLED: ("tables", runs.of_tables),
    _SENSING: ("sensing", runs.of_sensing),
    _ENCODERS: ("encoders", runs.of_encoders),
}
_CHECKS: dict[Path, tuple[str, Callable[[dict[str, Any]], Any]]] = {
    _FORMAL: ("proofs", reliability.of_formal),
    _SOAK: ("soak", reliability.of_soak),
    _LINK_SOAK: ("link soak", reliability.of_link_soak),
    _MUTATION: ("mutation", reliability.of_mutation),
    _COVERAGE: ("coverage", reliability.of_coverage),
}
"""Files of numbers, the names they are kept by, and what is kept of them."""


def _is_part(path: Path, found: dict[str, Any]) -> bool:
    """Whether a file is of a quick run, of a part of one, or of another scene."""
    if path == _SOAK:
        return found["ticks"] < soak.WHOLE_TICKS
    if path == _LINK_SOAK:
        return found["bytes"] < link_soak.WHOLE_BYTES
    if path == _SENSING:
        return bool(found["settings"])
    return bool(found.get("quick", path == _FORMAL))


def _last_measured(root: Path) -> tuple[dict[str, Any], list[Path]]:
    """What is kept, with what the last whole run of each found, and the files of other runs."""
    measured = json.loads((root / MEASURED).read_bytes()) if (root / MEASURED).exists() else {}
    checks, parts = measured.get("reliability", {}), []
    for files, into in ((_STUDIES, measured), (_CHECKS, checks)):
        for path, (name, wanted) in files.items():
            if not (root / path).exists():
                continue
            found = json.loads((root / path).read_bytes())
            if _is_part(path, found):
                parts.append(path)
            else:
                into[name] = wanted(found)
    demo = [root / _DEMO / folder / "metrics.json" for _, _, folder in DEMO_RUNS[1:]]
    if all(path.exists() for path in demo):
        measured["demo"] = design.of_demo([json.loads(path.read_bytes()) for path in demo])
    results = [root / path for path in reliability.TEST_RESULTS]
    if all(path.exists() for path in results):
        checks["tests"] = reliability.of_tests(results)
    if checks:
        measured["reliability"] = checks
    return measured, parts


def _shortened(numbers: Any) -> Any:
    """With eight places: another machine's rounding changes no file."""
    if isinstance(numbers, dict):
        return {name: _shortened(value) for name, value in numbers.items()}
    if isinstance(numbers, list):
        return [_shortened(value) for value in numbers]
    return float(f"{numbers:.8g}") if isinstance(numbers, float) else numbers


def write(root: Path = ROOT) -> list[Path]:
    """Fill the markers of every page; the pages that change by it. :class:`NumbersError`."""
    numbers = _read(root)
    written = []
    for page in pages(root):
        old = (root / page).read_text(encoding="utf-8")
        new = filled(old, numbers, str(page))
        if new != old:
            write_text(root / page, new)
            written.append(page)
    return written


def stale_pages(root: Path = ROOT) -> list[Path]:
    """Pages whose numbers aren't those that are kept."""
    numbers = _read(root)
    stale = []
    for page in pages(root):
        text = (root / page).read_text(encoding="utf-8")
        if filled(text, numbers, str(page)) != text:
            stale.append(page)
    return stale


def filled(text: str, numbers: dict[str, Any], page: str) -> str:
    """``text`` with its tables made of ``numbers``; :class:`NumbersError` for half a marker."""
    made = {name: partial(table, numbers) for name, table in TABLES.items()}
    try:
        return markers.filled(text, made, page)
    except markers.MarkerError as error:
        raise NumbersError(str(error)) from None


def _read(root: Path) -> dict[str, Any]:
    try:
        numbers = json.loads((root / KEPT).read_bytes())
    except FileNotFoundError:
        raise NumbersError(f"{KEPT} is not there; run `make synth numbers`") from None
    if (root / MEASURED).exists():
        numbers |= json.loads((root / MEASURED).read_bytes())
    if (root / fault_table.KEPT).exists():
        numbers["faults"] = json.loads((root / fault_table.KEPT).read_bytes())
    return numbers


# ---- The tables.


def _table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A table of Markdown; the first column to the left, the others to the right."""
    head = list(head)
    lines = [head, ["---", *["--:"] * (len(head) - 1)], *[[str(c) for c in row] for row in rows]]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _boards(numbers: dict[str, Any]) -> str:
    head = ("Board", "FPGA", "Clock", "Tick", "Logic cells", "FF", "DSP", "Block RAM",
            "Reached", "To spare", "Watch's clock, reached", "Bitstream")  # fmt: skip
    rows = []
    for board in numbers["boards"]:
        part = board["logic_cells"] / board["logic_cells_available"]
        rows.append(
            (
                f"`{board['board']}`",
                _DEVICE_NAMES.get(board["device"], board["device"]),
                f"{board['clock_mhz']:g} MHz",
                f"{design.control_rate_hz(board) / 1e6:.4g} MHz"
                + (f" × {board['motors']}" if board["motors"] > 1 else ""),
                f"{board['logic_cells']} ({part:.0%})",
                board["ff"],
                f"{board['dsp']} of {board['dsp_available']}",
                f"{board['block_ram']} of {board['block_ram_available']}",
                f"{_reached(board):.1f} MHz",
                f"{board['spare']:.0%}",
                f"{board['watch_mhz']:.1f} MHz, {board['watch_reached_mhz']:.0f} MHz"
                if board["watch_mhz"]
                else "–",
                f"{board['bitstream_bytes'] / 1000:.0f} kB",
            )
        )
    return _table(head, rows)


def _pads(numbers: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    return [(f"`{b['board']}`", b["pads"]) for b in numbers["boards"] if b.get("pads")]


def _pad_timing(numbers: dict[str, Any]) -> str:
    """The ADC's round trip at the pads of each board."""
    head = ("Board", "SCLK", "Registers in the pads", "Period", "Clock to pad", "Wires",
            "ADC's access", "Pad to flip-flop", "To spare", "Hold")  # fmt: skip
    keys = ("available_ns", "out_ns", "wire_ns", "access_ns", "back_ns", "margin_ns", "hold_ns")
    rows = [
        (
            name,
            f"{pads['sclk_mhz']:.1f} MHz",
            "yes" if pads["registered"] else "no",
            *(f"{pads[key]:.1f} ns" for key in keys),
        )
        for name, pads in _pads(numbers)
    ]
    return _table(head, rows)


def _dead_times(numbers: dict[str, Any]) -> str:
    """What the dead time of each board has to cover, and covers."""
    head = ("Board", "Driver", "AND gates", "FPGA, found", "FPGA, granted", "Needed",
            "Dead time", "Shortest pulse", "Trip", "Amplifier clips")  # fmt: skip
    keys = ("mismatch_ns", "gate_skew_ns", "fpga_skew_ns", "fpga_skew_granted_ns",
            "dead_needed_ns", "dead_ns", "min_pulse_ns")  # fmt: skip
    rows = [
        (
            name,
            *(f"{pads[key]:.1f} ns" for key in keys),
            f"{pads['trip_a']:g} A",
            f"{pads['clip_a']:.2f} A",
        )
        for name, pads in _pads(numbers)
    ]
    return _table(head, rows)


def _reached(board: dict[str, Any]) -> float:
    return min(board["reached_mhz"], board["dsp_path_mhz"] or board["reached_mhz"])


_COUNTS = ("lut", "ff", "dsp")


def _plain(row: dict[str, Any], first: dict[str, Any]) -> str:
    return " / ".join(str(row[count]) for count in _COUNTS)


def _with_clock(row: dict[str, Any], first: dict[str, Any]) -> str:
    return f"{_plain(row, first)}, {row['reached_mhz']:.0f} MHz"


def _more(row: dict[str, Any], first: dict[str, Any]) -> str:
    """What a row takes more than the first, which is shown as it is."""
    if row is first:
        return _plain(row, first)
    return " / ".join(f"{row[count] - first[count]:+d}" for count in _COUNTS)


def _resources(
    table: str,
    first: str,
    name: Callable[[dict[str, Any]], str],
    cell: Callable[[dict[str, Any], dict[str, Any]], str] = _plain,
) -> Callable[[dict[str, Any]], str]:
    """A row for each block or option; ``cell`` writes what a device needs for it."""

    def render(numbers: dict[str, Any]) -> str:
        rows: dict[str, dict[str, Any]] = {}
        for row in numbers.get("resources", ()):
            if row["table"] == table:
                rows.setdefault(name(row), {})[row["device"]] = row
        present = [name for name in _DEVICE_NAMES if any(name in on for on in rows.values())]
        head = [first, *(f"{_DEVICE_NAMES[name]}: LUT / FF / DSP" for name in present)]
        top = next(iter(rows.values()), {})
        lines = [
            (label, *(cell(devices[device], top[device]) for device in present))
            for label, devices in rows.items()
        ]
        return _table(head, lines)

    return render


_OF_MOTORS = {
    "ports": "controller",
    "shaped-ports": "with W of two sections",
    "line-ports": "controller, registers, line, capture and stream",
}


def _motors(numbers: dict[str, Any]) -> str:
    """What so many motors take, and each but the first two on the average."""
    counts: dict[str, dict[int, tuple[int, int]]] = {table: {} for table in _OF_MOTORS}
    for row in numbers.get("resources", ()):
        if row["table"] in counts:
            motors = int(row["option"].rsplit(maxsplit=1)[-1])
            counts[row["table"]][motors] = (row["lut"], row["ff"])
    head = ("Motors", *(f"{what}: LUT / FF" for what in _OF_MOTORS.values()))
    lines = [
        (str(motors), *(_pair(of.get(motors)) for of in counts.values()))
        for motors in sorted({motors for of in counts.values() for motors in of})
    ]
    each = [_pair(_each(of)) for of in counts.values()]
    return _table(head, [*lines, ("each but the first two", *each)])


def _each(of: dict[int, tuple[int, int]]) -> tuple[int, ...] | None:
    """One motor alone is another device, so that the first two are not of one kind."""
    if 2 not in of or len(of) < 3:
        return None
    others = max(of) - 2
    return tuple((of[max(of)][n] - of[2][n]) // others for n in range(2))


def _pair(counts: tuple[int, ...] | None) -> str:
    return "–" if counts is None else " / ".join(map(str, counts))


def _adcs(numbers: dict[str, Any]) -> str:
    """What each converter is worth: times, the stiffness that is felt, the torque's error."""
    head = ("ADC", "Bits", "Clock, SCLK", "kS/s at most", "Sample to last bit", "Last bit to duty",
            "Sample to gate edge", "k", "τ, measured of set", "τ at a = 0.99",
            "Torque error", "Energy out")  # fmt: skip
    rows = (
        (
            row["part"],
            row["bits"],
            f"{row['clock_mhz']:g}, {row['sclk_mhz']:.3g} MHz",
            f"{row['rate_hz'] / 1e3:.0f}",
            f"{row['conversion_ns']:.0f} ns",
            f"{row['digital_ns']:.0f} ns",
            f"{row['gate_ns']:.0f} ns",
            row["extra_ticks"],
            _measured(row["tau_us"], row["tau_set_us"]),
            _measured(row["stiff_tau_us"], row["stiff_tau_set_us"]),
            f"{row['torque_error']:.1e}",
            f"{row['energy_out_max_j']:.0e} J",
        )
        for row in numbers.get("adcs", {}).get("parts", ())
    )
    return _table(head, rows)


def _measured(found: float | None, wanted: float) -> str:
    return "no wall" if found is None else f"{found:.1f} of {wanted:.0f} µs"


def _energies(numbers: dict[str, Any]) -> str:
    """Most net energy that the port gave out, by how the current is taken."""
    head = ("Tick", "`golden`, mean", "`golden`, point", "`pins`, one sample", "`pins`, several")
    rows = (
        (
            f"{1e6 * row['tick_s']:g} µs",
            *(f"{row[name]:.1e} J" for name in ("mean_j", "point_j", "one_j")),
            f"{row['several_j']:.1e} J ({row['samples']})",
        )
        for row in numbers.get("adcs", {}).get("energies", ())
    )
    return _table(head, rows)


TABLES: dict[str, Callable[[dict[str, Any]], str]] = {
    "boards": _boards,
    "pad-timing": _pad_timing,
    "dead-times": _dead_times,
    "adcs": _adcs,
    "energies": _energies,
    "faults": lambda numbers: faults.table(numbers["faults"]),
    "block-resources": _resources("blocks", "Block", lambda row: f"`{row['block']}`"),
    "port-resources": _motors,
    "option-resources": _resources(
        "options", "`wh_controller` with", lambda row: row["option"], _more
    ),
    "width-resources": _resources(
        "widths", "`wh_wave_core`, data × coefficient", lambda row: row["option"], _with_clock
    ),
} | {
    name: partial(render, table=_table)
    for name, render in (
        report_and_bench.TABLES
        | holding_tables.TABLES
        | reliability.TABLES
        | runs.TABLES
        | design.TABLES
        | words.TABLES
    ).items()
}
"""What stands between the markers of each name."""
