# SPDX-License-Identifier: Apache-2.0
"""Tables of the pages that are made of several commands' numbers, or of the design itself."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from rich.console import Console
from wavehaptics.controller import pins_timing
from wavehaptics.fpga.boards import board_names, load_board
from wavehaptics.ladder.abilities import ABILITIES
from wavehaptics.parts.adcs import PARTS, frame
from wavehaptics.runtime.repository import ROOT
from wavehaptics.studies.demo import RUNS as DEMO_RUNS
from wavehaptics.studies.demo import demo_table
from wavehaptics.studies.report.blocks import number, percent
from wavehaptics.words import formats

from wavetools.fpga.synthesis import SPARE
from wavetools.pages import front_picture

Table = Callable[[Iterable[str], Iterable[Iterable[object]]], str]

DEMO_METRICS = (
    "scene",
    "controller",
    "stiffness",
    "stiffness_predicted",
    "k_l",
    "peak_torque",
    "torque_nrmse_vs_analog",
)


def _words(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table of Markdown whose columns are words, to the left."""
    head = list(head)
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def control_rate_hz(board: dict[str, Any]) -> float:
    """The control rate of a board in the kept numbers: its scene's."""
    return load_board(board["board"]).scene.controller.tick_hz


def of_demo(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What the pages show of the demo's metrics."""
    return [{key: run[key] for key in DEMO_METRICS} for run in found]


def _demo(numbers: dict[str, Any], table: Table) -> str:
    """What ``make demo`` prints, as it prints it, but for how fast the machine was."""
    text = io.StringIO()
    console = Console(file=text, width=84, force_terminal=False)
    missing: list[dict[str, Any]] = [{}] * (len(DEMO_RUNS) - len(numbers["demo"]))
    console.print(demo_table(missing + numbers["demo"], timed=False))
    lines = "\n".join(line.rstrip() for line in text.getvalue().splitlines())
    return f"```\n{lines}\n```\n"


def _place(value: float, unit: str) -> str:
    """A small quantity with the prefix that makes it 0.1 or more."""
    for factor, prefix in ((1.0, ""), (1e3, "m"), (1e6, "µ"), (1e9, "n")):
        if value * factor >= 0.1:
            return f"{number(value * factor, 2)} {prefix}{unit}"
    return f"{number(value, 2)} {unit}".rstrip()


def _formats(numbers: dict[str, Any], table: Table) -> str:
    """Word lengths as ``rtl/wh_formats.vh`` has them."""
    state = formats.Fixed(
        formats.DATA_W + formats.STATE_GUARD, formats.WAVE.fraction + formats.STATE_GUARD
    )
    words = (
        ("current", formats.CURRENT, "A"),
        ("voltage", formats.VOLTAGE, "V"),
        ("waves u, v", formats.WAVE, "√W"),
        ("filter state f", state, "√W"),
        ("s = √(2R̂)", formats.ROOT, "√Ω"),
        ("η, a, used to ±1", formats.A, ""),
        ("W's coefficients", formats.SHAPE, ""),
        ("W's states", formats.SHAPE_STATE, "√W"),
        ("the port anchor's sums", formats.LONG, "cells, V or A"),
    )
    rows = []
    for name, word, unit in words:
        last = _place(word.step, unit) if unit and " " not in unit else number(word.step, 2)
        scale = f"±{number(2.0 ** (word.width - 1 - word.fraction), 5)} {unit}".rstrip()
        rows.append((name, f"s{word.width}q{word.fraction}", scale, last))
    return table(("quantity", "word", "full scale", "last place"), rows)


def _latency(numbers: dict[str, Any], table: Table) -> str:
    """A sample's way to the gates, in clocks: one motor, an AD7276 at 80 MHz, no W."""
    clock_hz = 80e6
    reader = frame(PARTS["AD7276"], clock_hz).conversion_clocks
    steps = (
        ("ADC's frame, from the carrier's sample strobe to the word", "wh_adc_serial", reader),
        ("mean current of the tick", "wh_current", pins_timing.CURRENT_CLOCKS),
        ("one port's step of the waves", "wh_wave_core", pins_timing.CORE_CLOCKS),
        ("voltage into the pulse's width", "wh_modulator", pins_timing.DUTY_CLOCKS),
        ("pulse and gates", "wh_pwm", pins_timing.GATE_CLOCKS),
    )
    total = pins_timing.latency_clocks(reader)
    assert sum(clocks for *_, clocks in steps[:-1]) == total, "the steps make the whole"
    rows = [
        (what, f"[`{block}`](../rtl/{block}.v)", clocks, f"{1e9 * clocks / clock_hz:.0f} ns")
        for what, block, clocks in steps
    ]
    return table(("step", "file", "clocks", "at 80 MHz"), rows)


_RATES = ("ulx3s", "ulx3s_three", "icesugar_pro_eight", "ulx3s_brushless")
"""Boards of speed grade 6 whose rates are told, by the number of their ports."""


def _rates(numbers: dict[str, Any], table: Table) -> str:
    """What the logic alone could do, with a tenth of the clock that was reached to spare."""
    placed = {board["board"]: board for board in numbers["boards"]}
    rows = []
    for name in _RATES:
        board = placed[name]
        motors, brushless = board["motors"], load_board(name).brushless
        clocks = pins_timing.turns_clocks(motors, brushless=brushless)
        clock_hz = 1e6 * board["reached_mhz"] / (1.0 + SPARE)
        rows.append(
            (
                f"`{name}`", f"{motors} brushless" if brushless else motors, clocks,
                f"{board['reached_mhz']:.1f} MHz", f"{clock_hz / clocks / 1e6:.2f} MHz",
                f"{control_rate_hz(board) / 1e6:.2f} MHz",
            )
        )  # fmt: skip
    return table(
        (
            "board",
            "motors",
            "clocks a period",
            "clock reached",
            "rate of the logic",
            "board's rate",
        ),
        rows,
    )


def _found(numbers: dict[str, Any]) -> Iterator[tuple[str, str, str]]:
    """One result of each kind: what it is of, what was found, and by which command."""
    if "demo" in numbers:
        taps, stiff = numbers["demo"]
        yield (
            "the stiffest wall, the whole RTL at its pins",
            f"{number(stiff['stiffness'])} N·m/rad, "
            f"{percent(stiff['stiffness'] / stiff['k_l'], 3)} of the inductor's K_L",
            "make demo",
        )
        yield (
            "torque of the paper's taps against its analog circuit",
            f"off by {percent(taps['torque_nrmse_vs_analog'])} of the peak",
            "make demo",
        )
    if "report" in numbers:
        usual = front_picture.usual(numbers["report"]["ratios"])
        yield (
            "stiffest stable wall under a light hand, beside an encoder's servo at 1 kHz",
            f"{number(usual['wave'])} against {number(usual['encoder'])} N·m/rad; at equal "
            "rates an encoder's servo [can be stiffer](docs/report.md)",
            "make report",
        )
    if "holding" in numbers:
        held = next(
            row
            for row in numbers["holding"]["holds"]
            if row["name"].startswith("everything") and row["controller"] == "core"
        )
        yield (
            f"a wall pressed for {held['duration_s']:.0f} s with everything wrong "
            "that a real motor has",
            f"moved by {number(abs(held['moved_cells']), 2)} of an encoder count, "
            f"ripple {percent(held['hold_ripple_rms'] / held['force'])} of the force",
            "make holding",
        )
    if "in_hands" in numbers.get("holding", {}):
        motors = numbers["holding"]["in_hands"]
        first, last = motors["seeds"]
        yield (
            f"{last - first + 1} random motors in random hands, everything wrong",
            f"{len(motors['lost']['hold'])} still bouncing after 0.6 s, "
            f"{len(motors['missed']['hold_cells'])} beyond a count and 1 % of the depth",
            "make holding",
        )
    if "tables" in numbers:
        felt = next(
            row for row in numbers["tables"]["impedance"] if row["scene"] == "spring_damper"
        )
        yield (
            "a soft spring with a damper, felt from 1 to 500 Hz",
            f"within {percent(felt['error_max'])} of the wish",
            "make tables",
        )
        angles = numbers["tables"]["brushless"]
        off = max(abs(row["pins"] / row["predicted"] - 1.0) for row in angles)
        yield (
            "a brushless motor's wall on two ports without an angle, "
            f"the whole RTL at its pins, at {len(angles)} angles",
            f"within {percent(off)} of [the closed form](docs/brushless.md)",
            "make tables",
        )
    if "boards" in numbers:
        fastest = max(numbers["boards"], key=lambda board: (control_rate_hz(board), board["spare"]))
        yield (
            f"control rate in a bitstream, as fast as its current sensor, `{fastest['board']}`",
            f"{control_rate_hz(fastest) / 1e6:.4g} MHz, "
            f"{percent(fastest['spare'])} of timing to spare",
            "make synth",
        )
    if "adcs" in numbers:
        soonest = min(numbers["adcs"]["parts"], key=lambda row: row["digital_ns"])
        yield (
            "from the last ADC bit to the new duty",
            f"{soonest['digital_ns']:.0f} ns",
            "make adcs",
        )
    if "bench" in numbers:
        yield (
            "simulation with motor, bridge and sensors in the loop, one thread",
            f"{number(numbers['bench']['controllers']['pins']['cycles_per_s'], 3)} clocks "
            "a second of the RTL",
            "make bench",
        )


def _results(numbers: dict[str, Any], table: Table) -> str:
    rows = ((what, found, f"`{by}`") for what, found, by in _found(numbers))
    return _words(("", "found", "by"), rows)


_GIVEN = r"define WH_SAME_PARAMETERS(.*?)\n\n"
_GIVEN_ALONE = r"wh_controller #\((.*?)\) controller"
_ALWAYS = {"SENSE": 1, "GUARD": 1, "ANCHOR": 1}
"""What ``wh_device`` has whatever its parameters are."""
_OPTION = re.compile(r"\.([A-Z][A-Z0-9_]*)\s*\(([^()]*)\)")

_ONE_PORTS = "PWM of a full bridge with dead time made good"
"""What a brushless motor has no use for."""

STATUS = (
    ("the waves, λ and η: `wh_wave_core`", None),
    ("position, walls, contact: `wh_quadrature`, `wh_contact`", None),
    (_ONE_PORTS, None),
    ("two to eight motors that take turns", "N"),
    ("guard with twenty latched faults", "GUARD"),
    ("port anchor: a wall that holds on a real motor", "ANCHOR"),
    ("one multiplier for all products", "SHARED"),
    ("soft walls, layers, detents with W", "SHAPER"),
    ("an environment on a computer", "HOST"),
    ("zero of the current measured before the gates go on", "SENSE"),
    ("bus measured", "BUS"),
    ("other patterns of the bridge", "MODES"),
    ("shortest pulses kept", "MIN_PULSE"),
    ("ADCs other than AD7276 and its like", "ADC"),
)
"""What there is, and the parameter of ``wh_controller`` that puts it in; None: always there."""


def options_of_boards(root: Path = ROOT, scenes: bool = False) -> dict[str, dict[str, int]]:
    """Parameters of ``wh_controller`` or ``wh_device`` in each board's bitstream.

    One that isn't set is left out, and so are boards that are made on demand. ``scenes``: those of
    the bitstreams of other scenes that a board's folder has, by the names of their files.
    """
    found = {}
    boards = {name: load_board(name, root=root) for name in board_names(root)}
    if scenes:
        others = {path: path.parent.name for path in sorted(root.glob("boards/*/*.toml"))
                  if path.name not in ("board.toml", "fpga.toml")}  # fmt: skip
        boards = {path.relative_to(root).as_posix(): load_board(name, root=root, scene_path=path)
                  for path, name in others.items()}  # fmt: skip
    for name, board in boards.items():
        if board.fpga.on_demand:
            continue
        top = (root / "boards" / "wh_board_controller.v").read_text(encoding="utf-8")
        (given,) = re.findall(_GIVEN, top, re.DOTALL)
        if not board.fpga.link:
            given += "".join(re.findall(_GIVEN_ALONE, top, re.DOTALL))
        macros = dict(
            re.findall(
                r"^`define (WH_BOARD_\w+) (\d+)$", board.headers()["wh_board_settings.vh"],
                re.MULTILINE,
            )
        )  # fmt: skip
        macros["N"] = str(board.fpga.motors)
        found[name] = dict(_ALWAYS) if board.fpga.link else {}
        found[name] |= {
            parameter: int(macros.get(value.strip(" `"), value))
            for parameter, value in _OPTION.findall(given)
            if parameter == "N" or parameter != value  # what the top passes on is of simulations
        }
    return found


def _status(numbers: dict[str, Any], table: Table) -> str:
    """Simulated, in a bitstream, on a motor: what has come how far."""
    boards, scenes = options_of_boards(), options_of_boards(scenes=True)
    brushless = [name for name in boards if load_board(name).brushless]
    rows = []
    for what, parameter in STATUS:
        least = 2 if parameter == "N" else 1
        names = [
            name
            for name, options in boards.items()
            if (parameter is None or options.get(parameter, 0) >= least)
            and (what != _ONE_PORTS or name not in brushless)
        ]
        but = " but " + ", ".join(f"`{n}`" for n in brushless) if what == _ONE_PORTS else ""
        everywhere = len(names) == len(boards) - (len(brushless) if but else 0)
        built = f"all boards{but}" if everywhere else ", ".join(f"`{n}`" for n in names)
        with_scene = [name for name, options in scenes.items() if options.get(parameter or "")]
        if not built and with_scene:
            built = "with " + ", ".join(f"`SCENE={name}`" for name in with_scene)
        label = f"{what}, `{parameter}`" if parameter else what
        rows.append((label, "yes", built or "**none**", "no"))
    of_boards = {name: load_board(name).fpga for name in boards}

    def having(key: str) -> list[str]:
        return [name for name, fpga in of_boards.items() if getattr(fpga, key)]

    for what, names in (
        ("settings changed by Modbus while it runs: `wh_device`, `wh_linked_device`",
         having("link")),
        ("a host MCU in place of the line: `wh_spi`", having("spi")),
        ("live values captured around a trigger: `wh_capture`", having("capture")),
        ("live values streamed: `wh_stream`", having("stream")),
        ("comparators beside the FPGA that tell when they shut the gates: `DRIVER`",
         having("overcurrent")),
        ("brushless motors: `wh_device`, `AXES`", brushless),
    ):  # fmt: skip
        built = ", ".join(f"`{name}`" for name in names) or "**none**"
        rows.append((what, "yes", built, "no"))
    return _words(("", "simulated", "in a bitstream", "tried on a motor"), rows)


def _abilities(numbers: dict[str, Any], table: Table) -> str:
    """What each that runs a scene leaves out or refuses of it."""

    def listed(names: Iterable[str]) -> str:
        return ", ".join(f"`{n}`" if "." in n else f"`[{n}]`" for n in sorted(names)) or "nothing"

    rows = ((f"`{name}`", listed(a.left_out), listed(a.refused)) for name, a in ABILITIES.items())
    return _words(("", "leaves out, and says so", "refuses"), rows)


def _once(render: Callable[..., str], key: str) -> Callable[..., str]:
    """``render``, which makes nothing before its numbers are there."""
    return lambda numbers, table: render(numbers, table) if key in numbers else ""


TABLES = {
    "abilities": _abilities,
    "demo": _once(_demo, "demo"),
    "formats": _formats,
    "latency": _latency,
    "rates": _once(_rates, "boards"),
    "results": _results,
    "status": _status,
}
"""Tables of Markdown by marker, made with the given function of head and rows."""
