# SPDX-License-Identifier: Apache-2.0
"""What each block and each option of the RTL costs on each FPGA, and how fast the wave core is."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wavehaptics.runtime.files import digest_of, write_json
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain

from wavetools.fpga import synthesis
from wavetools.fpga.synthesis import SynthesisError

OUT = Path("build", "synth", "resources")
"""Where the netlists go, from the root."""

DEVICES = {"up5k": ("ice40", "sg48"), "hx8k": ("ice40", "ct256"), "25k": ("ecp5", "CABGA381")}
"""FPGAs that are counted for: family and package by nextpnr's name of the device."""

_PIECES = frozenset(("wh_round", "wh_saturate", "wh_synchroniser", "wh_truncate"))
"""Modules of a few lines, which are counted with the blocks that hold them."""

OPTIONS: tuple[Mapping[str, int], ...] = (
    {},
    {"WALLS": 1},
    {"WALLS": 16},
    {"DELAY_LOG2": 1},
    {"DELAY_LOG2": 6},
    {"DELAY_LOG2": 10},
    {"ADC": 1},
    {"ADC": 2},
    {"SENSE": 1},
    {"SHAPER": 1},
    {"SHAPER": 2},
    {"DEAD_TIME": 0},
    {"MODES": 1},
    {"MIN_PULSE": 1},
    {"BUS": 1},
    {"HOST": 1},
    {"GUARD": 1},
    {"ANCHOR": 1},
)
"""Parameters of ``wh_controller``, a line of the table each; the first line is the defaults."""

LINE: Mapping[str, int] = {"ARM": 1, "CAPTURE": 12, "STREAM": 1}
"""Parameters of ``wh_linked_device`` with which one motor and several are counted."""

BRUSHLESS: Mapping[str, int] = {"N": 2, "AXES": 1}
"""Parameters of ``wh_ports`` for one brushless motor, counted for what is beside it."""

_WIDTHS = ((18, 18), (24, 18), (27, 24), (31, 27))
_SEED = 1
JOBS = 2
"""Cases that are counted at a time."""

_ASKED_HZ = {"up5k": 60e6, "hx8k": 120e6, "25k": 200e6}  # more than can be reached


@dataclass(frozen=True)
class Case:
    """A block with options: parameters of the top, and macros of ``rtl/wh_formats.vh``."""

    table: str
    block: str
    parameters: Mapping[str, int] = field(default_factory=dict)
    defines: Mapping[str, int] = field(default_factory=dict)
    devices: tuple[str, ...] = tuple(DEVICES)

    @property
    def option(self) -> str:
        """The options in words."""
        words = [f"{name} = {value}" for name, value in self.parameters.items()]
        if self.defines:
            words.append(f"{self.defines['WH_DATA_W']} × {self.defines['WH_COEF_W']} bits")
        return ", ".join(words) or "defaults"


def cases(root: Path = ROOT) -> Iterator[Case]:
    """Everything that is counted: each block of ``rtl``, and the options."""
    for path in sorted((root / "rtl").glob("wh_*.v")):
        if path.stem not in _PIECES:
            yield Case("blocks", path.stem)
    for parameters in OPTIONS:
        yield Case("options", "wh_controller", parameters, devices=("up5k", "25k"))
    yield Case("brushless", "wh_ports", BRUSHLESS, devices=("25k",))
    for ports in (1, 2, 3, 4, 8):
        yield Case("ports", "wh_ports", {"N": ports}, devices=("25k",))
        yield Case("shaped-ports", "wh_ports", {"SHAPER": 2, "N": ports}, devices=("25k",))
        yield Case("line-ports", "wh_linked_device", {**LINE, "N": ports}, devices=("25k",))
    for data_w, coef_w in _WIDTHS:
        yield Case("widths", "wh_wave_core", {}, {"WH_DATA_W": data_w, "WH_COEF_W": coef_w})


def measure(tools: Toolchain, say: Callable[[str], None] = print) -> Path:
    """Count every case on its devices into ``build/synth/resources.json``, whose path it gives.

    Wave cores of each word length are placed as well. A row has ``table block option device lut ff
    dsp block_ram`` and ``reached_mhz``, which is ``None`` where nothing was placed. A run that was
    stopped is taken up where it was, unless the RTL or the tools have changed.
    """
    (ROOT / OUT).mkdir(parents=True, exist_ok=True)
    done, begun = ROOT / OUT.with_suffix(".json"), ROOT / OUT / "begun.json"
    sources = _fingerprint(tools)
    todo = [(case, device) for case in cases() for device in case.devices]
    rows = {_key(row): row for row in _rows_of(begun, sources)}

    def count(place: int) -> dict[str, Any]:
        case, device = todo[place]
        known = rows.get((case.table, case.block, case.option, device))
        return known or _count(case, device, OUT / str(place), tools)

    with ThreadPoolExecutor(JOBS) as workers:
        started = [workers.submit(count, place) for place in range(len(todo))]
        try:
            for number, future in enumerate(as_completed(started), 1):
                row = future.result()
                rows[_key(row)] = row
                write_json(begun, {"sources": sources, "rows": list(rows.values())}, indent=1)
                say(f"{number} of {len(todo)}: {_line(row)}")
        except BaseException:
            workers.shutdown(wait=False, cancel_futures=True)
            raise
    write_json(done, [future.result() for future in started], indent=1)
    shutil.rmtree(ROOT / OUT)
    return done.relative_to(ROOT)


def _key(row: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(row[name] for name in ("table", "block", "option", "device"))


def _line(row: Mapping[str, Any]) -> str:
    fast = "" if row["reached_mhz"] is None else f", {row['reached_mhz']} MHz"
    return (
        f"{row['block']}, {row['option']}, on {row['device']}: {row['lut']} LUT, {row['ff']} FF, "
        f"{row['dsp']} DSP, {row['block_ram']} RAM{fast}"
    )


def _fingerprint(tools: Toolchain) -> str:
    """Digest of all that the counts follow from."""
    sources = [Path(__file__), *sorted((ROOT / "rtl").glob("wh_*.v*"))]
    return digest_of((tools.name, tools.version("yosys")), sources)


def _rows_of(begun: Path, sources: str) -> list[dict[str, Any]]:
    """Rows of a run with the same sources that was stopped."""
    if not begun.exists():
        return []
    data = json.loads(begun.read_bytes())
    return data["rows"] if data["sources"] == sources else []


def _design(case: Case, device: str, top: str, extra: tuple[Path, ...] = ()) -> synthesis.Design:
    family, package = DEVICES[device]
    return synthesis.Design(
        name=f"{case.block}, {case.option}, on {device}",
        top=top,
        root=ROOT,
        sources=(*(p.relative_to(ROOT) for p in sorted((ROOT / "rtl").glob("*.v"))), *extra),
        includes=(Path("rtl"),),
        constraints=Path("none"),
        family=family,
        device=device,
        package=package,
        speed=6 if family == "ecp5" else None,
        input_hz=_ASKED_HZ[device],
        clock_hz=_ASKED_HZ[device],
        seeds=(_SEED,),
        defines=tuple(case.defines.items()),
        parameters=tuple(case.parameters.items()),
    )


def _count(case: Case, device: str, out: Path, tools: Toolchain) -> dict[str, Any]:
    (ROOT / out).mkdir(exist_ok=True)
    netlist = out / "block.json"
    design = _design(case, device, case.block)
    synthesis.synthesise(design, netlist, tools, ROOT / out / "yosys.log")
    cells = json.loads((ROOT / netlist).read_bytes())["modules"][case.block]["cells"].values()
    counts = synthesis.cell_counts(design.family, (cell["type"] for cell in cells))
    reached = _reached_mhz(case, device, out, tools) if case.table == "widths" else None
    row = {"table": case.table, "block": case.block, "option": case.option, "device": device}
    return {**row, **counts, "reached_mhz": reached}


def _reached_mhz(case: Case, device: str, out: Path, tools: Toolchain) -> float:
    """Clock of the block between shift registers, so that few pins are enough."""
    ports = _ports(case, out)
    bench = out / "bench.v"
    (ROOT / bench).write_text(_bench(case.block, ports), encoding="utf-8")
    design = _design(case, device, "bench", (bench,))
    netlist, report = out / "bench.json", out / "bench_report.json"
    synthesis.synthesise(design, netlist, tools, ROOT / out / "yosys.log")
    arguments = [
        f"--{device}", "--package", design.package, "--json", str(netlist),
        "--seed", str(_SEED), "--freq", f"{_ASKED_HZ[device] / 1e6:g}", "--report", str(report),
        "--timing-allow-fail",  # how fast it can be is the question
    ]  # fmt: skip
    arguments += ["--pcf-allow-unconstrained"] if design.family == "ice40" else ["--speed", "6"]
    log = ROOT / out / "nextpnr.log"
    if tools.run(synthesis.PLACERS[design.family], arguments, ROOT, log):
        raise SynthesisError(f"{case.block} {case.option} on {device}: see {log}")
    clocks = json.loads((ROOT / report).read_bytes())["fmax"]
    return round(min(clock["achieved"] for clock in clocks.values()), 1)


def _ports(case: Case, out: Path) -> dict[str, tuple[str, int]]:
    """Direction and width of each port, of the netlist that was just made."""
    top = json.loads((ROOT / out / "block.json").read_bytes())["modules"][case.block]
    return {name: (port["direction"], len(port["bits"])) for name, port in top["ports"].items()}


def _bench(block: str, ports: Mapping[str, tuple[str, int]]) -> str:
    inputs = [(n, w) for n, (d, w) in ports.items() if d == "input" and n not in ("clk", "rst")]
    outputs = [(n, w) for n, (d, w) in ports.items() if d == "output"]
    ins, outs = sum(w for _, w in inputs), sum(w for _, w in outputs)
    pins, place = [".clk(clk), .rst(rst_q)" if "rst" in ports else ".clk(clk)"], 0
    for name, width in inputs:
        pins.append(f".{name}(in_q[{place} +: {width}])")
        place += width
    place = 0
    for name, width in outputs:
        pins.append(f".{name}(out[{place} +: {width}])")
        place += width
    return f"""\
module bench (input wire clk, input wire rst, input wire load, input wire d, output wire q);
    reg rst_q, load_q;
    reg [{ins - 1}:0] in_q;
    reg [{outs - 1}:0] out_q;
    wire [{outs - 1}:0] out;
    {block} block ({", ".join(pins)});
    always @(posedge clk) begin
        rst_q  <= rst;
        load_q <= load;
        in_q   <= {{in_q[{ins - 2}:0], d}};
        out_q  <= load_q ? out : {{out_q[{outs - 2}:0], 1'b0}};
    end
    assign q = out_q[{outs - 1}];
endmodule
"""
