# SPDX-License-Identifier: Apache-2.0
"""A whole board at its pins, with the motor: the netlist that is flashed, or the board's sources.

The top is the board's own, ``boards/<name>/<name>.v``, as place and route left it
(:mod:`wavetools.fpga.placed`). It is begun as a person begins: power-up with nobody near, the
rotor turned by hand to where the scene begins, the start button pressed with its bounces, and held
until the board says that it runs; or, on a board with a link, armed by a frame on its line.
Meanwhile the motor rests and the ADC reads no current. From the first gate on the loop is that of
``pins``.

At first several motors are all the same one: each port sees the one motor's encoder and ADC, and
the first port's gates drive it. The others' gates are the first one's, but for a period after an
edge of the encoder that comes between two ports' turns. :meth:`BoardSimulation.part` gives each
port a motor of its own.

Nothing inside the board is seen: the columns of the waves are NaN, contact is where the rotor
really is in a wall, and ticks are counted by the pin ``alive``.
"""

from __future__ import annotations

import ctypes
import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from wavehaptics.controller.ports import Ports, controller_ports
from wavehaptics.fpga.board_words import BoardWords, part_frame, turns_of
from wavehaptics.fpga.boards import Board, BoardError
from wavehaptics.ladder import brushless_pins, pins_loop, verilated
from wavehaptics.ladder.brushless import magnet_words
from wavehaptics.ladder.brushless_pins import BrushlessPinsSimulation
from wavehaptics.ladder.linked_pins import write_frame
from wavehaptics.ladder.pins import PinsSimulation, wire
from wavehaptics.motor.brushless import BrushlessPlant
from wavehaptics.motor.plant import OMEGA, C, P, R, S, X
from wavehaptics.motor.sensor import NOISE, sample_code
from wavehaptics.motor.sigma_delta import next_bit
from wavehaptics.parts.adcs import Frame, Part
from wavehaptics.runtime.compiled import compiled_drawing
from wavehaptics.runtime.files import digest_of, write_text
from wavehaptics.runtime.native_call import call2
from wavehaptics.runtime.repository import SHIMS
from wavehaptics.runtime.toolchain import Toolchain
from wavehaptics.scene import Scene, load_scene
from wavehaptics.scene.tables.hand import Hand
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words.modbus import BAUDS
from wavehaptics.words.table import WORDS

from wavetools.fpga import placed, synthesis

OUT = Path("build", "netlists")
"""Where the simulated files go, from the root."""

BENCH = "wh_board_bench"

GATES = {
    False: ("gate_ah", "gate_al", "gate_bh", "gate_bl"),
    True: ("gate_ah", "gate_bh", "gate_ch", "gate_al", "gate_bl", "gate_cl"),
}
"""Ports of a board's gates as the loops have them, by whether its motor is brushless."""

PRESS_CLOCKS = (700, 300, 1500, 100, 2200, 900)
"""How long the start button closes and opens by turns before it stays closed."""

COUNT_CLOCKS = 400
"""Clocks from one edge of the encoder to the next while the rotor is turned by hand."""

LONGEST_START = 2_000_000
"""Clocks from pressing the button until the gates go on, at most."""

ZERO_TICKS = 1 << 11
"""More ticks than the zero's measurement takes."""

SWING_TURNS = 6.0
"""Turns of a brushless motor's magnets in which a board that doesn't know their angle finds it."""

SWING_S, SWING_STIFFNESS, SWING_DAMPING = 0.1, 0.05, 0.5e-3
"""How long a hand takes for them, and how it holds the rotor, N·m/rad and N·m·s/rad."""

_PIECE = 4096
_UNSEEN = [Column.ETA, Column.U, Column.V, Column.CORRECTION, Column.X_HAT, Column.OMEGA_HAT,
           Column.FLUX, Column.FAULT]  # fmt: skip


@dataclass(frozen=True)
class Report:
    """What the pins have shown so far, in clocks from power-up.

    ``irregular`` counts ticks that ``alive`` told at another clock or not at all, ``both_on``
    clocks with both gates of a leg on, ``idle_on`` those with a gate on while the board doesn't
    say that it runs, but for the one in which they go off, ``apart`` those in which a motor's gates
    aren't the first one's; ``seen`` is a digest of all the pins at each clock from the 16th on:
    what no register begins with, reset gives it.
    """

    clocks: int
    ticks: int
    irregular: int
    both_on: int
    idle_on: int
    apart: int
    running: bool
    fault: bool
    seen: int


@dataclass(frozen=True)
class Build:
    """A board's Verilated library."""

    board: Board
    library: Path


def board_scene(
    board: Board, settings: Sequence[str] = (), hand: dict[str, Any] | None = None
) -> Scene:
    """The scene that a board is made for, with its ADC, ``settings`` and another hand."""
    path = board.scene_path or board.root / board.folder / "board.toml"
    scene = load_scene(path, [f"adc.part={board.converter.name}", *settings])
    if hand is None:
        return scene
    return scene.model_copy(update={"hand": Hand.model_validate(hand)})


def bench(board: Board, ports: dict[str, str]) -> str:
    """A top with the same pins for each board; ``ports`` are the board's, with their directions.

    A brushless motor's has more gates and ADCs.
    """
    motors, clocks, gates = board.fpga.motors, board.fpga.sclk_pins, GATES[board.brushless]
    roles = {"adc_sdata": "sdata", "enc_a": "a", "enc_b": "b", "stop": "stop",
             "adc_cs_n": "cs_n", "adc_sclk": "sclk", "alive": "alive",
             **{gate: f"gates[{n}]" for n, gate in enumerate(gates)},
             "uart_rx": "rx", "uart_tx": "tx"}  # fmt: skip
    # Nobody presses the reset, no MCU is on SPI, and no comparator shuts the gates.
    shown = {"button_start": "start", "start": "start", "button_reset": "1'b0",
             "spi_cs": "1'b0", "spi_sclk": "1'b0", "spi_mosi": "1'b0", "overcurrent": "1'b0",
             "led_running": "running", "led_fault": "fault", "led_contact": "contact"}  # fmt: skip
    pins, lines, found = [], [], set()
    for port, direction in ports.items():
        plain = port.removesuffix("_n")
        role = roles.get(port) or shown.get(plain) or ("clk" if port.startswith("clk_") else None)
        if role is None:
            continue
        found.add(role)
        inverted = port not in roles and port.endswith("_n")
        if inverted and direction == "input":
            role = "1'b1" if role == "1'b0" else f"!{role}"
        elif inverted:
            lines += [f"    wire {port};", f"    assign {role} = !{port};"]
            role = port
        wires = motors if port in gates else clocks if port in ("adc_cs_n", "adc_sclk") else 1
        if wires > 1:
            lines += [f"    wire [{wires - 1}:0] {port};", f"    assign {role} = {port}[0];"]
            role = port
        if motors > 1 and port in gates:
            place = gates.index(port)
            lines += [f"    assign gates[{n * len(gates) + place}] = {port}[{n}];"
                      for n in range(1, motors)]  # fmt: skip
        pins.append(f"        .{port} ({role})")
    missing = {"clk", *roles.values(), "start", "running", "fault"} - {"rx", "tx"} - found
    if missing:
        raise BoardError(
            f"{board.name}: its top has no pin for {', '.join(sorted(missing))}; they have "
            "the names of the other boards'"
        )
    lines += [f"    assign {role} = 1'b{level};" for role, level in (("contact", 0), ("tx", 1))
              if role not in found]  # fmt: skip
    others = [f"{gate} != {{{motors}{{{gate}[0]}}}}" for gate in gates if motors > 1]
    apart = " || ".join(others) or "1'b0"
    lines += [f"    assign apart = {apart};"]
    each = f" [{motors - 1}:0]" if motors > 1 else ""
    adcs = " [1:0]" if board.brushless else each
    return "\n".join([
        f"module {BENCH} (",
        f"    input clk, input watch_clk, input start, input stop, input{adcs} sdata,",
        f"    input{each} a, input{each} b, input rx, output tx,",
        f"    output [{motors * len(gates) - 1}:0] gates, output cs_n,",
        "    output sclk, output alive, output running, output fault, output contact, output apart",
        ");", *lines, f"    {board.name} board (", ",\n".join(pins), "    );", "endmodule", "",
    ])  # fmt: skip


def build(
    board: Board, tools: Toolchain, *, netlist: bool = True, synth: Path | None = None
) -> Build:
    """Build a board's netlist, or its sources, to be simulated; from ``synth``, or ``build/synth``.

    :class:`BoardError` where there is no bitstream, or one with other settings than the board's.
    """
    synth = synth or synthesis.OUT / board.made
    made = synth / f"{board.name}{synthesis.PLACED_NETLIST}"
    scene = f" SCENE={board.scene_file}" if board.scene_path else ""
    cure = f"run `make bitstream BOARD={board.name}{scene}`"
    if not (board.root / made).is_file():
        raise BoardError(f"{made} is not there; {cure}")
    kept = {name: board.root / synth / name for name in board.headers()}
    if any(not path.is_file() or path.read_text(encoding="utf-8") != board.headers()[name]
           for name, path in kept.items()):  # fmt: skip
        raise BoardError(
            f"{synth} was made with other settings than those of {board.scene_file}; {cure}"
        )
    what = "placed" if netlist else "sources"
    folder = OUT / f"{board.made}-{what}"
    (board.root / folder).mkdir(parents=True, exist_ok=True)
    (top,) = json.loads((board.root / made).read_bytes())["modules"].values()
    ports = {name: port["direction"] for name, port in top["ports"].items()}
    top_file = board.root / folder / f"{BENCH}.v"
    write_text(top_file, bench(board, ports))
    if netlist:
        files = placed.placed_verilog(board.name, board.fpga.family, made, folder, tools)
        includes: tuple[Path, ...] = ()
    else:
        own = board.root / board.folder / f"{board.name}.v"
        models = placed.models(board.fpga.family, board.root / folder, tools, placed=False)
        files = (own, *models)
        includes = tuple(board.root / path for path in ("rtl", "boards", synth))
    sources = [top_file, *files]
    counted = [*sources, SHIMS / "board_shim.cpp"]
    for path in includes:
        counted += sorted(path.glob("*.v*"))
    flags = (verilated.CXX_FLAGS, verilated.VERILATOR_FLAGS)
    digest = digest_of(flags, counted)[:16]
    arguments = [
        # The libraries' models widen and leave pins open as they like.
        "-Wno-fatal", "-Wno-lint", "-Wno-style",
        "-CFLAGS", f"-DWH_BOARD_LEGS={board.fpga.legs} -DWH_BOARD_MOTORS={board.fpga.motors}",
        *(f"-I{path}" for path in includes),
        *(f"-D{name}={value}" for name, value in board.defines.items()),
        str(SHIMS / "board_shim.cpp"), *map(str, sources),
    ]  # fmt: skip
    target = verilated.BUILD_DIR / f"{board.made}-{what}-{digest}.so"
    return Build(board, verilated.verilate(BENCH, arguments, target, covered=False))


@compiled_drawing
def _rest(kept, ints, sensor, rng, bits, clocks):
    """Clock the board with the motor at rest; the clocks until a gate went on, else ``clocks``."""
    data_bits = ints[pins_loop.DATA_BITS]
    for n in range(clocks):
        inputs = ((kept[pins_loop.SHIFT] >> 63) & 1) | pins_loop.encoder_levels(
            kept[pins_loop.COUNT]
        )
        pins = call2(ints[pins_loop.CLOCK], ints[pins_loop.MODEL], inputs)
        changed = kept[pins_loop.PINS] ^ pins
        kept[pins_loop.PINS] = pins
        if ints[pins_loop.OSR]:
            if changed & pins & 1 << pins_loop.SCLK:
                level = pins_loop.modulated(0.0, sensor, ints[pins_loop.OSR], rng)
                kept[pins_loop.SHIFT] = next_bit(bits, level) << 63
        elif changed & 1 << pins_loop.CS_N:
            if not pins & 1 << pins_loop.CS_N:
                noise = rng.standard_normal() if sensor[NOISE] > 0.0 else 0.0
                code = sample_code(0.0, sensor, noise) + (1 << (data_bits - 1))
                shown = kept[pins_loop.HELD] if ints[pins_loop.PIPELINE] else code
                kept[pins_loop.SHIFT] = shown << ints[pins_loop.CODE_SHIFT]
                kept[pins_loop.HELD] = code
        elif changed & 1 << pins_loop.SCLK and (
            (pins >> pins_loop.SCLK) & 1 == ints[pins_loop.LAUNCH_LEVEL]
        ):
            kept[pins_loop.SHIFT] <<= 1
        if pins & 15:
            return n
    return clocks


class BoardSimulation(PinsSimulation):
    """What a simulated board has of its own, beside the loop of its kind of motor.

    :func:`on_board` makes one. At the constructor's end the board's gates have gone on.
    """

    PREFIX = "wh_board"

    def __init__(self, built: Build, scene: Scene, by_line: bool) -> None:
        self._built = built
        self._by_line = by_line
        super().__init__(scene)
        # Of the anchor nothing is seen.
        self._ints[pins_loop.ANCHORED] = 0
        self._switch_on_with(scene)

    def _ports_of(self, scene: Scene, most_samples: int) -> Ports:
        del most_samples
        return self._board_ports(scene)

    def _begin(self, scene: Scene, ports: Ports, host: bool) -> None:
        del scene, host
        self._power_up(ports)

    def _switch_on_with(self, scene: Scene) -> None:
        """Switch the board on, with the motor of the scene."""
        del scene
        self._start()

    def _start(self) -> None:
        """Switch the board on; the last of a constructor."""
        self._walls = np.array(
            [(low * self.settings.cell_rad, high * self.settings.cell_rad) for low, high in zip(
                self.settings.wall_min, self.settings.wall_max, strict=True)]
        )  # fmt: skip
        self._switch_on()
        # Until alive has told where ticks begin, rows have no certain length.
        self._loop(np.zeros((2, len(Column))), np.zeros((2, len(Word)), dtype=np.int64))

    def _loop(self, rows: np.ndarray, words: np.ndarray) -> None:
        """Simulate as ``pins`` does."""
        super().advance(rows, words)

    def _rest_for(self, clocks: int) -> bool:
        """Let ``clocks`` pass with the motor at rest; False if the gates went on before."""
        passed = _rest(self._kept, self._ints, self._sensor, self._rng, self._bits, clocks)
        return passed == clocks

    @property
    def clock_cycles(self) -> int:
        """Clocks since its gates went on."""
        return int(self._kept[pins_loop.NOW])

    def _board_ports(self, scene: Scene) -> Ports:
        board = self._built.board
        fpga = board.fpga
        ports = controller_ports(
            scene, partial(part_frame, board.converter, fpga.pad_registers),
            turns=turns_of(fpga.motors, fpga.legs, linked=fpga.link),
        )  # fmt: skip
        _same_settings(board.words(), scene, ports)
        return ports

    def _wire(self, scene: Scene, frame: Frame) -> tuple[int, int]:
        """Of the part itself: it knows nothing of the registers at the board's pads."""
        del scene
        part = self._built.board.converter
        shift, level = wire(part if isinstance(part, Part) else None, frame)
        return shift + frame.pad_clocks, level

    def _function(self, name: str) -> Any:
        return getattr(self._library, f"{self.PREFIX}_{name}")

    def _power_up(self, ports: Ports) -> None:
        self._library = ctypes.CDLL(str(self._built.library))
        verilated.declare_destructor(self._function("delete"))
        self._library.wh_board_part.argtypes = [ctypes.c_void_p]
        self._library.wh_board_press.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64]
        self._library.wh_board_report.argtypes = [ctypes.c_void_p, ctypes.POINTER(ctypes.c_int64)]
        new = self._library.wh_board_new
        new.argtypes = [*[ctypes.c_int64] * 3, ctypes.c_double, ctypes.c_int64]
        for name in ("send", "received"):
            function = self._function(name)
            function.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int64]
            function.restype = ctypes.c_int64
        new.restype = ctypes.c_void_p
        at_reset = self._built.board.words().ports.start_count
        levels = pins_loop.encoder_levels.py_func(at_reset) << self.INPUTS_SHIFT
        time = ports.timing
        bit_clocks = round(16 * time.clock_hz / BAUDS[0])
        watch = 2 * self._watch_hz() / time.clock_hz
        again = self._built.board.words().alive_again
        self._model = new(levels, time.tick_clocks, bit_clocks, watch, again)
        if not self._model:
            raise RuntimeError("a model of the FPGA's cells can't do what the netlist asks for")

    def _watch_hz(self) -> float:
        """The FPGA's own oscillator, 0 where the board's top uses none."""
        board = self._built.board
        text = (board.root / board.folder / f"{board.name}.v").read_text(encoding="utf-8")
        divider = re.search(r"\.WATCH_DIV\s*\((\d+)\)", text)
        return synthesis.OSCILLATOR_HZ / int(divider[1]) if divider else 0.0

    # ---- What a person does.

    def _switch_on(self) -> None:
        start, at_reset = (int(self._kept[pins_loop.COUNT]),
                           self._built.board.words().ports.start_count)  # fmt: skip
        settle = 1 << 16
        self._kept[pins_loop.COUNT] = at_reset
        self._press(False)
        # Reset, and the button believed to be open.
        still = self._rest_for(3 * settle)
        while self._kept[pins_loop.COUNT] != start:
            self._kept[pins_loop.COUNT] += 1 if start > at_reset else -1
            still = still and self._rest_for(COUNT_CLOCKS)
        if self._by_line:
            # Before there is a zero the arming is refused.
            still = still and self._rest_for(ZERO_TICKS * self.timing.tick_clocks)
            self.send(write_frame(WORDS["arm"].at(), [1]))
        else:
            for n, clocks in enumerate(PRESS_CLOCKS):
                self._press(n % 2 == 0)
                still = still and self._rest_for(clocks)
            self._press(True)
        if not still:
            raise RuntimeError("the gates went on before anybody wanted it")
        for _ in range(LONGEST_START // _PIECE):
            if not self._rest_for(_PIECE):
                return
        raise RuntimeError(f"the gates don't go on; {self.report()}")

    def _press(self, start: bool, stop: bool = False) -> None:
        self._library.wh_board_press(self._model, start, stop)

    def release(self) -> None:
        """Take the finger off the start button."""
        self._press(False)

    def stop(self) -> None:
        """Open the wire of the emergency stop."""
        self._press(False, True)

    def part(self) -> None:
        """From now on each port has a motor of its own, in a loop of all."""
        self._library.wh_board_part(self._model)

    # ---- The line, at the rate with which it begins.

    def send(self, frame: bytes) -> None:
        """Put bytes before the line, which sends them one after another."""
        self._library.wh_board_send(self._model, frame, len(frame))

    def received(self) -> bytes:
        """Bytes that came since the last time, 4096 at most."""
        buffer = ctypes.create_string_buffer(4096)
        count = self._library.wh_board_received(self._model, buffer, len(buffer))
        return buffer.raw[:count]

    # ---- What is seen.

    def report(self) -> Report:
        """What the pins have shown so far."""
        words = (ctypes.c_int64 * 9)()
        self._library.wh_board_report(self._model, words)
        clocks, ticks, irregular, both_on, idle_on, apart, running, fault, seen = words
        return Report(
            clocks, ticks, irregular, both_on, idle_on, apart, bool(running), bool(fault), seen
        )

    def advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        """As ``pins`` does; what nobody sees at the pins is NaN, and there are no words."""
        self._loop(rows, words)
        x = rows[:, Column.X]
        inside = np.zeros(len(rows), dtype=bool)
        for low, high in self._walls:
            inside |= (low <= x) & (x < high)
        rows[:, _UNSEEN] = math.nan
        rows[:, Column.CONTACT] = inside
        rows[:, Column.SATURATED] = 0.0


class _BrushlessOnBoard(BoardSimulation, BrushlessPinsSimulation):
    """A board with a brushless motor."""

    def _switch_on_with(self, scene: Scene) -> None:
        if scene.controller.find_magnet:
            self._start_with_a_swing(scene)
        else:
            self._start()

    def _start_with_a_swing(self, scene: Scene) -> None:
        """Begin some turns of the magnets away, from where a hand brings the rotor once it runs.

        By that the board finds their angle. The hand stops where the scene begins.
        """
        scenes, load, steps = self._state.copy(), self._load, self._steps
        plant = BrushlessPlant.of_scene(scene)
        way = SWING_TURNS * 2 * math.pi / plant.pole_pairs
        hand = replace(
            plant.plant, hand_stiffness=SWING_STIFFNESS, hand_damping=SWING_DAMPING,
            hand_omega=math.pi / SWING_S, ramp_end_s=math.inf,
        )  # fmt: skip
        plant = replace(plant, plant=hand)
        self._load = plant.words()
        self._steps = np.stack([plant.step_words(n / self.timing.clock_hz)
                                for n in range(len(steps))])  # fmt: skip
        self._state[X] -= way
        self._state[OMEGA] = 0.0
        self._state[[P, R, C, S]] = scenes[P] + scenes[C] - 0.5 * way, 0.0, -0.5 * way, 0.0
        self._kept[pins_loop.COUNT] = math.floor(self._state[X] / self.settings.cell_rad)
        self.forget_the_past()
        self._start()
        ticks = round(SWING_S / self.tick_s)
        self._loop(np.zeros((ticks, len(Column))), np.zeros((ticks, len(Word)), dtype=np.int64))
        self._load, self._steps = load, steps
        self._state[[P, R, C, S]] = scenes[[P, R, C, S]]
        self.forget_the_past()

    def _rest_for(self, clocks: int) -> bool:
        went = brushless_pins.rest(
            self._state, self._kept, self._ints, self._sensor, self._rng, clocks
        )  # fmt: skip
        return went == clocks


def on_board(built: Build, scene: Scene, *, by_line: bool = False) -> BoardSimulation:
    """``scene`` on a board that was built, whose gates have gone on.

    The scene says what is connected to the board and what the hand does; its walls and what else
    the bitstream holds must be the board's own. With ``by_line`` nobody presses the button: the
    word ``arm`` is written over the board's line, and not renewed.
    """
    kind = _BrushlessOnBoard if built.board.brushless else BoardSimulation
    return kind(built, scene, by_line)


def _same_settings(board: BoardWords, scene: Scene, scenes: Ports) -> None:
    """What the scene asks for is in the bitstream; its walls are counted from where it begins.

    So is the magnets' angle, but from where the board begins.
    """
    ours = board.ports
    moved = scenes.start_count - ours.start_count
    angle = magnet_words(scene, scenes.settings, ours.start_count) if scene.motor.brushless else {}
    held = {**ours.words, **ours.settings.words(), **{name: board.words[name] for name in angle}}
    asked = {**scenes.words, **scenes.settings.words(), **angle}
    different = {key for key in held if asked.get(key) != held[key]}
    if [(low + moved, high + moved) for low, high in scenes.walls] != ours.walls:
        different |= {"walls"}
    if different:
        raise BoardError(
            "the scene asks for other settings than the bitstream holds: "
            + ", ".join(sorted(different))
        )
