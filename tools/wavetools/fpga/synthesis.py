# SPDX-License-Identifier: Apache-2.0
"""From Verilog to a bitstream: Yosys, nextpnr, icepack or ecppack, and everything that must hold.

A build either leaves a bitstream that meets its clock with room to spare, or an error of one line,
its logs and nothing else. ``python -m wavetools.cli.board_commands --help`` tells the commands.
"""

from __future__ import annotations

import json
import math
import re
import shutil
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from wavehaptics.fpga.boards import Board, write_headers
from wavehaptics.runtime.files import write_json
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain

from wavetools.fpga import board_pins, bridge_budget, multipliers, pad_timing, pll, tops

OUT = Path("build", "synth")
"""Where results go, from the root: a folder for each board, and the summary."""

SPARE = 0.10
"""Part of the clock that a design must have to spare."""

OSCILLATOR_HZ = 310e6
"""Rate of the ECP5's own oscillator before its divider."""

OSCILLATOR_TOLERANCE = 0.30
"""Part of its rate by which that oscillator may be off."""

PLACERS = {"ice40": "nextpnr-ice40", "ecp5": "nextpnr-ecp5"}
PACKERS = {"ice40": "icepack", "ecp5": "ecppack"}
PACK_OPTIONS: dict[str, list[str]] = {"ice40": [], "ecp5": ["--compress"]}
BITSTREAM_SUFFIX = {"ice40": ".bin", "ecp5": ".bit"}
PLACED_NETLIST = "-placed.json"
"""End of the name of the netlist as it was placed, which :mod:`wavetools.fpga.placed` reads."""

_DELAYS = "delays.sdf"
_PLACED_SUFFIX = {"ice40": ".asc", "ecp5": ".config"}


class SynthesisError(RuntimeError):
    """A build that failed, in one line."""


class TimingMissed(SynthesisError):
    """A placement that is too slow; ``reached_hz`` is what it came to."""

    def __init__(self, message: str, reached_hz: float) -> None:
        super().__init__(message)
        self.reached_hz = reached_hz


@dataclass(frozen=True)
class Design:
    """What is to be built. Paths are from ``root``, in which the tools run.

    ``clock_hz`` is the clock behind the PLL, or the input's own where there is no PLL; the placer
    is asked for SPARE more, with one of ``seeds`` after the other until it gets there. ``defines``
    are macros, ``parameters`` those of the top.
    """

    name: str
    top: str
    root: Path
    sources: tuple[Path, ...]
    includes: tuple[Path, ...]
    constraints: Path
    family: str
    device: str
    package: str
    speed: int | None
    input_hz: float
    clock_hz: float
    seeds: tuple[int, ...]
    motors: int = 1
    tick_hz: float = 0.0
    defines: tuple[tuple[str, int], ...] = ()
    parameters: tuple[tuple[str, int], ...] = ()
    board: Board | None = None


@dataclass(frozen=True)
class Result:
    """What came out: counts of cells, clocks in MHz, bytes of the bitstream.

    ``watch_mhz`` is the nominal rate of the FPGA's own oscillator, None where it isn't used.
    """

    board: str
    device: str
    motors: int
    tick_mhz: float
    logic_cells: int
    logic_cells_available: int
    lut: int
    ff: int
    dsp: int
    dsp_available: int
    block_ram: int
    block_ram_available: int
    clock_mhz: float
    reached_mhz: float
    dsp_path_mhz: float | None
    watch_mhz: float | None
    watch_reached_mhz: float | None
    slack_ns: float
    spare: float
    seed: int
    bitstream_bytes: int
    toolchain: str
    tools: dict[str, str]
    pads: dict[str, Any] | None = None
    """Round trip of the ADC, dead time and the gates' skew; None for a design that is no board."""
    anchor: bool = False
    guard: bool = False
    zero: bool = False
    """Whether the current's zero is measured before the gates go on."""
    settings: bool = False
    """Whether settings can be changed without another bitstream."""


def board_design(board: Board, out: Path) -> Design:
    """Design of a board, whose settings are in ``out`` already."""
    root = board.root
    sources = [
        *sorted((root / "rtl").glob("*.v")),
        *sorted((root / "boards").glob("*.v")),
        *sorted((root / board.folder).glob("*.v")),
    ]
    return Design(
        name=board.name,
        top=board.name,
        root=root,
        sources=tuple(path.relative_to(root) for path in sources),
        includes=(Path("rtl"), out),
        constraints=board.constraints,
        family=board.fpga.family,
        device=board.device,
        package=board.fpga.package,
        speed=board.fpga.speed,
        input_hz=board.fpga.input_hz,
        clock_hz=board.clock_hz,
        seeds=tuple(board.fpga.seeds),
        motors=board.fpga.motors,
        tick_hz=board.scene.controller.tick_hz,
        defines=tuple(board.defines.items()),
        board=board,
    )


def board_sources(board: Board) -> list[Path]:
    """Files that a board's bitstream is made of, from the root."""
    found = [
        path
        for pattern in ("rtl/*.v", "rtl/*.vh", "rtl/*.toml", "boards/*.v", f"{board.folder}/*.v")
        for path in sorted(board.root.glob(pattern))
    ]
    files = [path.relative_to(board.root) for path in found]
    scene = board.scene_path or board.folder / "board.toml"
    return [*files, scene, board.folder / "fpga.toml", board.constraints]


def bitstream_path(board: Board) -> Path:
    """Where a board's bitstream goes, from the root."""
    return OUT / board.made / f"{board.name}{BITSTREAM_SUFFIX[board.fpga.family]}"


def check_board(board: Board) -> None:
    """What can be said of a board without a tool; ``BoardError``, ``SceneError``, SynthesisError.

    It takes a second, and a build begins with it.
    """
    bridge_budget.check(board)
    board_pins.check(board)
    check_sources(board_design(board, OUT / board.made))


def check_sources(design: Design) -> None:
    """Pins, parameters and PLLs, as far as the text of the sources says them."""
    _check_constraints(design)
    headers = {} if design.board is None else design.board.headers()
    sources = {
        path.as_posix(): (design.root / path).read_text(encoding="utf-8") for path in design.sources
    }
    try:
        told = tops.netlist(design.top, sources, headers)
    except tops.TopError as error:
        raise SynthesisError(f"{design.name}: {error}") from None
    if told["ports"] is not None:
        _check_pins(design, told)
    if told["cells"] is not None:
        _check_pll(design, told)


def build_board(
    board: Board, tools: Toolchain, seed: int | None = None, say: Callable[[str], None] = print,
    out: Path | None = None,
) -> Result:  # fmt: skip
    """Make a board's bitstream; :class:`SynthesisError`, ``SceneError`` or ``ToolError``.

    ``seed`` takes the place of the board's own ones, ``out`` that of its folder, from the root.
    """
    check_board(board)
    out = out or OUT / board.made
    folder = board.root / out
    _clear(folder)
    write_headers(board, folder)
    design = board_design(board, out)
    return build(design if seed is None else replace(design, seeds=(seed,)), out, tools, say)


def build(
    design: Design, out: Path, tools: Toolchain, say: Callable[[str], None] = print
) -> Result:
    """Make a bitstream in ``out``, a folder from the root, which must exist.

    On any error all that was made in it is deleted, but for the logs and what was there before.
    """
    folder = design.root / out
    before = set(folder.iterdir())
    try:
        return _build(design, out, tools, say)
    except BaseException:
        for path in set(folder.iterdir()) - before:
            if path.suffix != ".log":
                path.unlink()
        raise


def _build(design: Design, out: Path, tools: Toolchain, say: Callable[[str], None]) -> Result:
    folder = design.root / out
    check_sources(design)
    placer, packer = PLACERS[design.family], PACKERS[design.family]
    versions = {tool: tools.check_age(tool) for tool in ("yosys", placer)}
    named = ", ".join(f"{tool} {version}" for tool, version in versions.items())
    say(f"{design.name}: {named} ({tools.name}), some minutes")
    _check_part(design, tools, folder)
    netlist = _checked_netlist(design, out, tools)
    placed = _first_that_meets(design, netlist, out, tools, say)
    pads = None if design.board is None else board_pads(design.board, folder / _DELAYS)

    bitstream = out / f"{design.name}{BITSTREAM_SUFFIX[design.family]}"
    placed_path = _placed_path(design, out)
    arguments = [*PACK_OPTIONS[design.family], str(placed_path), str(bitstream)]
    log = folder / f"{packer}.log"
    if tools.run(packer, arguments, design.root, log):
        raise SynthesisError(f"{design.name}: {packer} failed: {last_line(log)}")
    size = (design.root / bitstream).stat().st_size
    if size == 0:
        raise SynthesisError(f"{design.name}: {packer} wrote an empty bitstream")
    made = replace(_result(design, netlist, placed, size, tools.name, versions), pads=pads)
    if design.board is None:
        return made
    words = design.board.words()
    return replace(
        made, zero=True, anchor=words.ports.settings.anchored, guard=words.guard is not None,
        settings=words.linked,
    )  # fmt: skip


def board_pads(board: Board, sdf: Path) -> dict[str, Any]:
    """What a board's pads come to by nextpnr's delays; :class:`SynthesisError` where that is late.

    The gates' skew is held against what the dead time's budget grants it.
    """
    words, bridge = board.words(), board.fpga.bridge
    time = bridge_budget.dead_time(board)
    motors, drive = board.fpga.motors, board.scene.drive
    try:
        delays = pad_timing.Delays.of_file(sdf)
        adc = pad_timing.adc_budget(
            delays, board.device, board.fpga.family, board.converter,
            words.ports.timing.frame, board.clock_hz, board.fpga.wire_s, board.adc_lines,
            board.sclk_pins,
        )  # fmt: skip
        skew_ns = pad_timing.gate_skew_ns(delays, motors, board.fpga.legs)
    except pad_timing.PadTimingError as error:
        raise SynthesisError(f"{board.name}: {error}") from None
    if skew_ns > 1e9 * bridge.fpga_skew_s:
        raise SynthesisError(
            f"{board.name}: the gates of a leg differ by {skew_ns:g} ns from clock to pad, and "
            f"bridge.fpga_skew_s of {board.folder}/fpga.toml grants {1e9 * bridge.fpga_skew_s:g} "
            "ns; raise it, and drive.dead_time_s with it, or take another seed"
        )
    return {
        **asdict(adc),
        "dead_ns": round(1e9 * time.made_s, 2),
        "dead_needed_ns": round(1e9 * time.needed_s, 2),
        "mismatch_ns": round(1e9 * time.mismatch_s, 2),
        "gate_skew_ns": round(1e9 * time.gate_skew_s, 2),
        "fpga_skew_ns": skew_ns,
        "fpga_skew_granted_ns": round(1e9 * time.fpga_skew_s, 2),
        "min_pulse_ns": round(1e9 * drive.min_pulse_s, 2) if drive else 0.0,
        "trip_a": board.sense.trip_a,
        "clip_a": round(board.sense.clip_a, 3),
    }


def _netlist_path(design: Design, out: Path) -> Path:
    return out / f"{design.name}.json"


def _placed_path(design: Design, out: Path) -> Path:
    return out / f"{design.name}{_PLACED_SUFFIX[design.family]}"


def _checked_netlist(design: Design, out: Path, tools: Toolchain) -> dict[str, Any]:
    """The top of the design's netlist, which holds what can be said before it is placed."""
    path = _netlist_path(design, out)
    synthesise(design, path, tools, design.root / out / "yosys.log")
    netlist = json.loads((design.root / path).read_bytes())["modules"][design.top]
    _check_pll(design, netlist)
    _check_pins(design, netlist)
    try:
        multipliers.check_registers(netlist)
    except multipliers.MultiplierError as error:
        raise SynthesisError(f"{design.name}: {error}") from None
    return netlist


@dataclass(frozen=True)
class Placed:
    """What a seed came to; ``dsp_hz`` is the clock that paths through multiplier blocks allow.

    ``watch_hz`` is what the logic on the FPGA's own oscillator reaches, None without one.
    """

    seed: int
    report: dict[str, Any]
    reached_hz: float
    watch_hz: float | None
    dsp_hz: float | None

    @property
    def slowest_hz(self) -> float:
        return min(self.reached_hz, self.dsp_hz or self.reached_hz)


def _place_seed(
    design: Design, netlist: dict[str, Any], out: Path, tools: Toolchain, seed: int
) -> Placed:
    """Place and route with ``seed``; :class:`TimingMissed` where that is too slow."""
    report_path, delays_path = out / "report.json", out / _DELAYS
    place(
        design, seed, _netlist_path(design, out), _placed_path(design, out),
        report_path, delays_path, tools, design.root / out,
    )  # fmt: skip
    report = json.loads((design.root / report_path).read_bytes())
    reached_hz, watch_hz = _reached_hz(design, netlist, report)
    dsp_hz = _dsp_hz(design, netlist, design.root / delays_path)
    return Placed(seed, report, reached_hz, watch_hz, dsp_hz)


def _first_that_meets(
    design: Design, netlist: dict[str, Any], out: Path, tools: Toolchain, say: Callable[[str], None]
) -> Placed:
    """The first of the design's seeds that meets its clock; :class:`TimingMissed` if none does."""
    missed: dict[int, TimingMissed] = {}
    for seed in design.seeds:
        try:
            return _place_seed(design, netlist, out, tools, seed)
        except TimingMissed as error:
            missed[seed] = error
            say(f"{design.name}: seed {seed} reaches {error.reached_hz / 1e6:.2f} MHz: too slow")
    best = max(missed, key=lambda seed: missed[seed].reached_hz)
    if len(missed) == 1:
        raise missed[best]
    raise TimingMissed(
        f"{missed[best]}; that is seed {best}, the best of {len(missed)}", missed[best].reached_hz
    )


def survey_seeds(
    board: Board, tools: Toolchain, seeds: Iterable[int], say: Callable[[str], None] = print
) -> list[tuple[float, int]]:
    """(part of the clock to spare, seed) of each of ``seeds``, the best first.

    It works in a folder of its own beside the board's, whose bitstream stays.
    """
    out = OUT / f"{board.name}-seeds"
    folder = board.root / out
    _clear(folder)
    try:
        write_headers(board, folder)
        design = board_design(board, out)
        check_sources(design)
        netlist = _checked_netlist(design, out, tools)
        found = []
        for seed in seeds:
            try:
                reached_hz = _place_seed(design, netlist, out, tools, seed).slowest_hz
            except TimingMissed as error:
                reached_hz = error.reached_hz
            found.append((reached_hz / design.clock_hz - 1, seed))
            say(
                f"{board.name}: seed {seed} reaches {reached_hz / 1e6:.2f} MHz, {found[-1][0]:+.1%}"
            )
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return sorted(found, key=lambda pair: (-pair[0], pair[1]))


# ---- Yosys.

_EXPECTED_WARNINGS = (
    # Yosys reads a library of its own; `bit` is a name there, and not a keyword of Verilog.
    r"Lexer warning: The SystemVerilog keyword `bit' \(at /?\S*abc9_map\.v:\d+\)",
)

_YOSYS_FAULTS: tuple[tuple[str, str], ...] = (
    (
        r"Driver-driver conflict for (\S+) .*",
        "Yosys lost a multiplier (Driver-driver conflict at {0}); "
        "put another sum or no second register behind the product",
    ),
    (
        r"Latch inferred for signal `([^']+)'.*",
        "{0} is a latch; give it a value on every path of its always block",
    ),
    (
        r"multiple conflicting drivers for ([^:]+):.*",
        "{0} is driven more than once; leave it one driver",
    ),
    (r"Wire (\S+) is used but has no driver\.?", "{0} is used, but nothing drives it"),
)

_YOSYS_ERRORS: tuple[tuple[str, str], ...] = (
    (r"Module `\\?wh_illegal_parameter_(\w+)' referenced in .*", "an illegal parameter: {0}"),
)


_CELL_LIBRARIES = {
    "ice40": "+/ice40/cells_sim.v",
    "ecp5": "+/ecp5/cells_sim.v +/ecp5/cells_bb.v",
}


def yosys_script(design: Design, netlist: Path) -> str:
    """Commands that make a netlist of a design, and stop where it contradicts itself."""
    defines = "".join(f" -D{name}={value}" for name, value in design.defines)
    includes = "".join(f" -I{path}" for path in design.includes)
    parameters = "".join(f" -chparam {name} {value}" for name, value in design.parameters)
    sources = " ".join(map(str, design.sources))
    return "; ".join(
        (
            f"read_verilog -lib {_CELL_LIBRARIES[design.family]}",
            # Deferred, so that only the modules which the top needs are looked at.
            f"read_verilog -defer{defines}{includes} {sources}",
            f"hierarchy -check -top {design.top}{parameters}",
            "proc",
            # Before logic is mapped, so that the names are those of the source.
            "check -assert",
            f"{synthesis_command(design.family, design.device)} -top {design.top} -json {netlist}",
            "check -assert",
        )
    )


def synthesis_command(family: str, device: str) -> str:
    """Yosys' command for a device, without its top.

    Wider LUTs of an ECP5 are several of four inputs and multiplexers behind them: mapped for speed
    they make an anchor twice as large, and what is larger is placed further apart.
    """
    if family == "ecp5":
        return "synth_ecp5 -nowidelut"
    return {"up5k": "synth_ice40 -dsp -device u", "u4k": "synth_ice40 -dsp -device u"}.get(
        device, "synth_ice40"
    )


def synthesise(design: Design, netlist: Path, tools: Toolchain, log: Path) -> None:
    """Make the netlist; :class:`SynthesisError` at the first fault, or any warning."""
    status = tools.run("yosys", ["-p", yosys_script(design, netlist)], design.root, log)
    warnings: list[str] = []
    errors: list[str] = []
    for line in _text(log).splitlines():
        found = re.match(r"(?:\S+:\d+: )?(Warning|ERROR|Lexer warning|Parser warning)\b:?\s*", line)
        if not found or any(re.match(expected, line) for expected in _EXPECTED_WARNINGS):
            continue
        (errors if found[1] == "ERROR" else warnings).append(line[found.end() :].strip())
    for problem in warnings:
        for pattern, text in _YOSYS_FAULTS:
            fault = re.fullmatch(pattern, problem)
            if fault:
                raise SynthesisError(f"{design.name}: {text.format(_plain(fault[1]))}")
    if errors:
        for pattern, text in _YOSYS_ERRORS:
            fault = re.match(pattern, errors[0])
            if fault:
                raise SynthesisError(f"{design.name}: {text.format(fault[1].replace('_', ' '))}")
    if errors or status:
        raise SynthesisError(f"{design.name}: yosys: {(errors or [last_line(log)])[0]}")
    if warnings:
        raise SynthesisError(f"{design.name}: yosys warns: {warnings[0]}")


def _plain(name: str) -> str:
    """A name of Yosys without its escapes."""
    return name.replace("\\", "")


# ---- What the netlist must be.


def _check_pll(design: Design, netlist: dict[str, Any]) -> None:
    """Every PLL keeps to its data sheet and makes the clock of the settings."""
    clock_hz = design.input_hz
    for cell in netlist["cells"].values():
        if not cell["type"].startswith(pll.CELLS):
            continue
        try:
            made = pll.of_cell(cell, design.input_hz)
            made.check()
        except pll.PllError as error:
            raise SynthesisError(f"{design.name}: {error}") from None
        clock_hz = made.clock_hz
    if not math.isclose(clock_hz, design.clock_hz, rel_tol=1e-6):
        raise SynthesisError(
            f"{design.name}: the top's clock is {clock_hz / 1e6:g} MHz, but controller.clock_hz "
            f"of its scene is {design.clock_hz / 1e6:g} MHz"
        )


@dataclass(frozen=True)
class Oscillator:
    """The FPGA's own oscillator in a netlist: its nominal rate, and the names of its net."""

    hz: float
    nets: frozenset[str]


def oscillator(netlist: dict[str, Any]) -> Oscillator | None:
    """The oscillator that a netlist uses, None where it uses none."""
    for cell in netlist["cells"].values():
        if cell["type"] == "OSCG":
            (bit,) = cell["connections"]["OSC"]
            nets = (name for name, net in netlist["netnames"].items() if bit in net["bits"])
            return Oscillator(OSCILLATOR_HZ / pll.parameter(cell, "DIV", 128), frozenset(nets))
    return None


_CLOCK_LINE = {"ice40": r"^\s*set_frequency\b", "ecp5": r"^\s*FREQUENCY\b"}


def _check_constraints(design: Design) -> None:
    """No clock among the pins: it would silently take the place of the one asked for here."""
    text = (design.root / design.constraints).read_text(encoding="utf-8")
    for number, line in enumerate(text.splitlines(), 1):
        if re.match(_CLOCK_LINE[design.family], line):
            raise SynthesisError(
                f"{design.constraints}:{number}: sets a clock, which would silently replace the "
                "one that the build asks for; delete the line"
            )


def _check_pins(design: Design, netlist: dict[str, Any]) -> None:
    """Every pin of the top has its line, and every line its pin."""
    text = (design.root / design.constraints).read_text(encoding="utf-8")
    constrained = {pin.port for pin in board_pins.read_pins(text, design.family)}
    pins = set()
    for name, port in netlist["ports"].items():
        width = len(port["bits"])
        pins |= {name} if width == 1 else {f"{name}[{bit}]" for bit in range(width)}
    for pin in sorted(pins - constrained):
        raise SynthesisError(
            f"{design.name}: pin {pin} is unconstrained; give it a line in {design.constraints}"
        )
    for pin in sorted(constrained - pins):
        raise SynthesisError(
            f"{design.constraints}: {pin} is no pin of the top {design.top}; delete the line"
        )


def _check_part(design: Design, tools: Toolchain, folder: Path) -> None:
    """The placer knows device, package and speed: without a design it says so at once."""
    log = folder / "nextpnr.log"
    if tools.run(PLACERS[design.family], _part(design), design.root, log):
        said = re.search(r"^(?:ERROR: )?(unrecognised option .*|Unsupported .*)$", _text(log), re.M)
        problem = said[1].rstrip(".") if said else last_line(log)
        raise SynthesisError(
            f"{design.name}: nextpnr: {problem}; fpga.toml has devices, package and speed"
        )


def _part(design: Design) -> list[str]:
    """The FPGA, as nextpnr is told."""
    part = [f"--{design.device}", "--package", design.package]
    return part if design.speed is None else [*part, "--speed", str(design.speed)]


def _text(log: Path) -> str:
    return log.read_text(encoding="utf-8", errors="replace")


def _dsp_hz(design: Design, netlist: dict[str, Any], delays: Path) -> float | None:
    """Clock in Hz that the paths through multiplier blocks allow, None where there are none."""
    if design.family != "ice40":
        return None
    try:
        reached_hz = multipliers.reached_hz(netlist, delays)
    except multipliers.MultiplierError as error:
        raise SynthesisError(f"{design.name}: {error}") from None
    if reached_hz is not None and reached_hz < (1 + SPARE) * design.clock_hz:
        raise _missed(design, reached_hz, "the paths through the multiplier blocks reach")
    return reached_hz


# ---- nextpnr.


def place(
    design: Design,
    seed: int,
    netlist: Path,
    placed: Path,
    report: Path,
    delays: Path,
    tools: Toolchain,
    folder: Path,
) -> None:
    """Place and route; :class:`SynthesisError` at any error or warning."""
    arguments = [
        *_part(design), "--json", str(netlist),
        "--seed", str(seed), "--freq", f"{(1 + SPARE) * design.clock_hz / 1e6:.6f}",
        "--report", str(report), "--sdf", str(delays),
        "--write", str(netlist.with_name(f"{netlist.stem}{PLACED_NETLIST}")),
    ]  # fmt: skip
    if design.family == "ice40":
        # router1, the default, never comes to an end with some seeds.
        # Ways are made again where they are too slow: 1 to 4 % more of the iCEBreaker's clock.
        arguments += ["--router", "router2", "--tmg-ripup", "--pcf", str(design.constraints)]
        arguments += ["--asc", str(placed)]
    else:
        arguments += ["--lpf", str(design.constraints), "--textcfg", str(placed)]
    log = folder / "nextpnr.log"
    status = tools.run(PLACERS[design.family], arguments, design.root, log)
    text = _text(log)
    problems = re.findall(r"^(ERROR|Warning): (.*)$", text, re.MULTILINE)
    errors = [problem for kind, problem in problems if kind == "ERROR"]
    for problem in errors:
        pin = re.match(r"IO '([^']+)' is unconstrained", problem)
        if pin:
            raise SynthesisError(
                f"{design.name}: pin {pin[1]} is unconstrained; "
                f"give it a line in {design.constraints}"
            )
        clock = re.match(r"Max frequency for clock\s+'([^']+)':\s+([\d.]+) MHz \(FAIL", problem)
        if clock:
            raise _missed(design, float(clock[2]) * 1e6)
    if errors or status:
        raise SynthesisError(f"{design.name}: nextpnr: {(errors or [last_line(log)])[0]}")
    if problems:
        raise SynthesisError(f"{design.name}: nextpnr warns: {problems[0][1]}")


def _missed(
    design: Design,
    reached_hz: float,
    what: str = "the clock reaches",
    clock_hz: float | None = None,
) -> TimingMissed:
    clock_hz = clock_hz or design.clock_hz
    needed = (1 + SPARE) * clock_hz / 1e6
    message = (
        f"{design.name}: timing missed: {what} {reached_hz / 1e6:.2f} MHz, and {needed:.2f} MHz "
        f"are needed ({clock_hz / 1e6:g} MHz and {SPARE:.0%} to spare)"
    )
    return TimingMissed(message, reached_hz)


def _reached_hz(
    design: Design, netlist: dict[str, Any], report: dict[str, Any]
) -> tuple[float, float | None]:
    """Rates of the clock and of what the FPGA's own oscillator drives, each judged by its own.

    nextpnr asks of the oscillator's clock no more than its nominal rate; here it is the fastest
    that it may have. Of several other clocks the slowest counts.
    """
    clocks = {
        name.removeprefix("$glbnet$"): clock["achieved"] * 1e6
        for name, clock in report["fmax"].items()
    }
    watch_hz, own = None, oscillator(netlist)
    if own:
        timed = own.nets & clocks.keys()
        if not timed:
            raise SynthesisError(f"{design.name}: nextpnr didn't time the oscillator's clock")
        watch_hz = clocks.pop(next(iter(timed)))
        fastest_hz = (1 + OSCILLATOR_TOLERANCE) * own.hz
        if watch_hz < (1 + SPARE) * fastest_hz:
            raise _missed(design, watch_hz, "the oscillator's clock reaches", fastest_hz)
    if not clocks:
        raise SynthesisError(f"{design.name}: nextpnr timed no clock")
    reached_hz = min(clocks.values())
    if reached_hz < (1 + SPARE) * design.clock_hz:
        raise _missed(design, reached_hz)
    return reached_hz, watch_hz


# ---- The result.

_CELLS = {
    "ice40": ("ICESTORM_LC", "ICESTORM_DSP", "ICESTORM_RAM"),
    "ecp5": ("TRELLIS_COMB", "MULT18X18D", "DP16KD"),
}
_LUT = {"ice40": "SB_LUT4", "ecp5": "LUT4"}
_FF = {"ice40": "SB_DFF", "ecp5": "TRELLIS_FF"}


def cell_counts(family: str, cells: Iterable[str]) -> dict[str, int]:
    """LUTs, flip-flops, multipliers and block RAMs among the types of a netlist's cells.

    The ECP5's carry cells are two LUTs each; the iCE40's are part of a LUT's logic cell.
    """
    kinds = Counter(cells)
    lut = kinds[_LUT[family]] + (2 * kinds["CCU2C"] if family == "ecp5" else 0)
    return {
        "lut": lut,
        "ff": sum(n for kind, n in kinds.items() if kind.startswith(_FF[family])),
        "dsp": kinds["SB_MAC16"] + kinds["MULT18X18D"],
        "block_ram": kinds["DP16KD"] + sum(
            n for kind, n in kinds.items() if kind.startswith("SB_RAM40")
        ),
    }  # fmt: skip


def _result(
    design: Design,
    netlist: dict[str, Any],
    placed: Placed,
    bitstream_bytes: int,
    toolchain: str,
    versions: dict[str, str],
) -> Result:
    used = placed.report["utilization"]
    logic, dsp, ram = (
        used.get(name, {"used": 0, "available": 0}) for name in _CELLS[design.family]
    )
    counts = cell_counts(design.family, (cell["type"] for cell in netlist["cells"].values()))
    own = oscillator(netlist)
    return Result(
        board=design.name,
        device=design.device,
        motors=design.motors,
        tick_mhz=design.tick_hz / 1e6,
        logic_cells=logic["used"],
        logic_cells_available=logic["available"],
        lut=counts["lut"],
        ff=counts["ff"],
        dsp=dsp["used"],
        dsp_available=dsp["available"],
        block_ram=ram["used"],
        block_ram_available=ram["available"],
        clock_mhz=design.clock_hz / 1e6,
        reached_mhz=round(placed.reached_hz / 1e6, 2),
        dsp_path_mhz=None if placed.dsp_hz is None else round(placed.dsp_hz / 1e6, 2),
        watch_mhz=None if own is None else round(own.hz / 1e6, 2),
        watch_reached_mhz=None if placed.watch_hz is None else round(placed.watch_hz / 1e6, 2),
        slack_ns=round(1e9 / design.clock_hz - 1e9 / placed.slowest_hz, 2),
        spare=round(placed.slowest_hz / design.clock_hz - 1, 3),
        seed=placed.seed,
        bitstream_bytes=bitstream_bytes,
        toolchain=toolchain,
        tools=versions,
    )


def summary_line(result: Result) -> str:
    """A result in one line for a terminal."""
    part = result.logic_cells / result.logic_cells_available
    watch = (
        f"the watch's {result.watch_mhz:g} MHz, {result.watch_reached_mhz:g} MHz reached; "
        if result.watch_mhz
        else ""
    )
    return (
        f"{result.board}: {result.device}, {result.logic_cells} logic cells ({part:.0%}), "
        f"{result.ff} FF, {result.dsp} DSP, {result.block_ram} block RAM; "
        f"{result.clock_mhz:g} MHz asked, {result.reached_mhz:g} MHz reached "
        f"({result.spare:+.0%}, slack {result.slack_ns:g} ns); {watch}seed {result.seed}; "
        f"{result.bitstream_bytes} bytes"
    )


def write_summary(results: Iterable[Result], root: Path = ROOT) -> Path:
    """Write ``build/synth/summary.json``, whole or not at all."""
    path = root / OUT / "summary.json"
    return write_json(path, {"boards": [asdict(result) for result in results]})


def _clear(folder: Path) -> None:
    """An empty folder: nothing of an earlier build can be taken for this one's."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)


def last_line(log: Path) -> str:
    """The last line of a tool's log that says anything."""
    lines = list(_lines(log))
    return lines[-1] if lines else f"see {log}"


def _lines(log: Path) -> Iterator[str]:
    for line in _text(log).splitlines():
        if line.strip():
            yield line.strip()
