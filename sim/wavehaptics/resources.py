# SPDX-License-Identifier: Apache-2.0
"""What each block and each option of the RTL costs on each FPGA, and how fast the wave core is."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wavehaptics import synthesis
from wavehaptics.boards import ROOT
from wavehaptics.synthesis import SynthesisError
from wavehaptics.toolchain import Toolchain

OUT = Path("build", "synth", "resources")
"""Where the netlists go, from the root."""

DEVICES = {"up5k": ("ice40", "sg48"), "hx8k": ("ice40", "ct256"), "25k": ("ecp5", "CABGA381")}
"""FPGAs that are counted for: family and package by nextpnr's name of the device."""

BLOCKS = (
    "wh_carrier", "wh_adc_serial", "wh_current", "wh_multiply", "wh_wave_core", "wh_modulator",
    "wh_pwm", "wh_half_bridge", "wh_quadrature", "wh_contact", "wh_controller",
)  # fmt: skip

_WIDTHS = ((18, 18), (24, 18), (27, 24), (31, 27))
_SEED = 1
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
        """The options in words, empty where all are the defaults."""
        words = [f"{name} = {value}" for name, value in self.parameters.items()]
        if self.defines:
            words.append(f"{self.defines['WH_DATA_W']} × {self.defines['WH_COEF_W']} bits")
        return ", ".join(words)


def cases() -> Iterator[Case]:
    """Everything that is counted."""
    for block in BLOCKS:
        yield Case("blocks", block)
    for ports in range(1, 9):
        yield Case("ports", "wh_controller", {"N": ports}, devices=("25k",))
    for walls in (1, 16):
        yield Case("options", "wh_controller", {"WALLS": walls}, devices=("25k",))
    for delay_log2 in (1, 6, 10):
        yield Case("options", "wh_controller", {"DELAY_LOG2": delay_log2}, devices=("25k",))
    for data_w, coef_w in _WIDTHS:
        yield Case("widths", "wh_wave_core", {}, {"WH_DATA_W": data_w, "WH_COEF_W": coef_w})


def measure(tools: Toolchain, say: Callable[[str], None] = print) -> list[dict[str, Any]]:
    """Count every case on its devices; wave cores of each word length are placed as well.

    A row has ``table block option device lut ff dsp block_ram`` and ``reached_mhz``, which is
    ``None`` where nothing was placed.
    """
    (ROOT / OUT).mkdir(parents=True, exist_ok=True)
    rows = []
    for case in cases():
        for device in case.devices:
            row = _count(case, device, tools)
            rows.append(row)
            fast = "" if row["reached_mhz"] is None else f", {row['reached_mhz']} MHz"
            say(
                f"{case.block} {case.option} on {device}: {row['lut']} LUT, {row['ff']} FF, "
                f"{row['dsp']} DSP, {row['block_ram']} RAM{fast}"
            )
    return rows


def _design(case: Case, device: str, top: str, extra: tuple[Path, ...] = ()) -> synthesis.Design:
    family, package = DEVICES[device]
    return synthesis.Design(
        name="block",
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
        seed=_SEED,
        defines=tuple(case.defines.items()),
        parameters=tuple(case.parameters.items()),
    )


def _count(case: Case, device: str, tools: Toolchain) -> dict[str, Any]:
    netlist = OUT / "block.json"
    design = _design(case, device, case.block)
    synthesis.synthesise(design, netlist, tools, ROOT / OUT / "yosys.log")
    cells = json.loads((ROOT / netlist).read_bytes())["modules"][case.block]["cells"].values()
    counts = synthesis.cell_counts(design.family, (cell["type"] for cell in cells))
    reached = _reached_mhz(case, device, tools) if case.table == "widths" else None
    row = {"table": case.table, "block": case.block, "option": case.option, "device": device}
    return {**row, **counts, "reached_mhz": reached}


def _reached_mhz(case: Case, device: str, tools: Toolchain) -> float:
    """Clock of the block between shift registers, so that few pins are enough."""
    ports = _ports(case, device)
    bench = OUT / "bench.v"
    (ROOT / bench).write_text(_bench(case.block, ports), encoding="utf-8")
    design = _design(case, device, "bench", (bench,))
    netlist, report = OUT / "bench.json", OUT / "bench_report.json"
    synthesis.synthesise(design, netlist, tools, ROOT / OUT / "yosys.log")
    arguments = [
        f"--{device}", "--package", design.package, "--json", str(netlist),
        "--seed", str(_SEED), "--freq", f"{_ASKED_HZ[device] / 1e6:g}", "--report", str(report),
        "--timing-allow-fail",  # how fast it can be is the question
    ]  # fmt: skip
    arguments += ["--pcf-allow-unconstrained"] if design.family == "ice40" else ["--speed", "6"]
    log = ROOT / OUT / "nextpnr.log"
    if tools.run(synthesis.PLACERS[design.family], arguments, ROOT, log):
        raise SynthesisError(f"{case.block} {case.option} on {device}: see {log}")
    clocks = json.loads((ROOT / report).read_bytes())["fmax"]
    return round(min(clock["achieved"] for clock in clocks.values()), 1)


def _ports(case: Case, device: str) -> dict[str, tuple[str, int]]:
    """Direction and width of each port, of the netlist that was just made."""
    top = json.loads((ROOT / OUT / "block.json").read_bytes())["modules"][case.block]
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
