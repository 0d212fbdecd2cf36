# SPDX-License-Identifier: Apache-2.0
"""Boards: a folder under ``boards/`` and a file under ``constraints/`` each.

``boards/<name>/fpga.toml`` says what the board is, ``board.toml`` is the scene that its bitstream
is made for, ``<name>.v`` is its top, and ``constraints/<name>.pcf`` or ``.lpf`` has its pins.
``boards/README.md`` tells how to add one.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from wavehaptics.controller.ports import MOST_WALLS
from wavehaptics.fpga.board_words import (
    LINKED_WALLS,
    BoardWords,
    board_words,
    memory_header,
    verilog_header,
)
from wavehaptics.parts.adcs import MODULATORS, PARTS, Modulator, Part
from wavehaptics.runtime.files import write_text
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toml_source import TomlError, dotted, parse
from wavehaptics.scene import Scene, load_scene
from wavehaptics.scene.keys import as_written, nearest
from wavehaptics.scene.places import Places
from wavehaptics.words.table import AXES, LEGS, MOST, THREE_PHASE_LEGS

CONSTRAINT_SUFFIX = {"ice40": ".pcf", "ecp5": ".lpf"}


_DELAY_LOG2 = {"ice40": 6, "ecp5": 1}
"""Steps that a board's delay line has at least, 2 to the power of this: so many make a memory of
it, where flip-flops are scarce."""


MOST_PORTS = 8
"""Ports of ``rtl/wh_ports.v``."""


class BoardError(ValueError):
    """A board that can't be read. The message is one line: where, what is wrong."""


class _Table(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class Bridge(_Table):
    """What the half bridges and the way to them need of the gates' timing, s, and of the bus.

    ``mismatch_s`` is by how much the driver delays HI and LI differently, ``gate_skew_s`` the AND
    gates before it, ``fpga_skew_s`` what is granted to the FPGA from its flip-flops to its pads.
    ``clamp`` is D2, which ends the rise of a bus whose parts bear ``bus_max_v``.
    """

    driver: str
    mismatch_s: float = Field(ge=0)
    gate_skew_s: float = Field(ge=0)
    fpga_skew_s: float = Field(ge=0)
    min_pulse_s: float = Field(ge=0)
    clamp: str
    bus_max_v: float = Field(gt=0)


class Sense(_Table):
    """The current's way to the ADC: shunt, amplifier with its reference at half its supply.

    The output ends ``swing_v`` before either rail; ``trip_a`` takes the gates off, and at 0 A the
    ADC may read up to ``zero_a``, which is measured before the gates go on.
    """

    amplifier: str
    supply_v: float = Field(gt=0)
    swing_v: float = Field(ge=0)
    shunt_ohm: float = Field(gt=0)
    gain: float = Field(gt=0)
    trip_a: float = Field(gt=0)
    zero_a: float = Field(gt=0)

    @property
    def full_scale_a(self) -> float:
        """Current at the end of the ADC's scale, whose reference is the amplifier's supply."""
        return 0.5 * self.supply_v / (self.shunt_ohm * self.gain)

    @property
    def clip_a(self) -> float:
        """Current at which the amplifier's output ends."""
        return (0.5 * self.supply_v - self.swing_v) / (self.shunt_ohm * self.gain)


class Modulated(_Table):
    """A sigma-delta modulator on a shunt of its own, in the place of amplifier and ADC.

    The current is :class:`Sense`'s in all else.
    """

    part: str
    shunt_ohm: float = Field(gt=0)
    trip_a: float = Field(gt=0)
    zero_a: float = Field(gt=0)

    @property
    def amplifier(self) -> str:
        """The modulator, by which ``boards/sensing.toml`` knows it."""
        return self.part

    @property
    def full_scale_a(self) -> float:
        """Current at which all bits are ones."""
        return MODULATORS[self.part].full_scale_v / self.shunt_ohm

    @property
    def clip_a(self) -> float:
        """Current up to which the words are right."""
        return MODULATORS[self.part].linear * self.full_scale_a


class Fpga(_Table):
    """What ``fpga.toml`` holds.

    ``modulator`` is there for a scene whose ``adc.part`` is its.

    ``wiring`` names a power board that has a table of parts of its own. ``make synth``, and so a
    release, leaves out a board that is made ``on_demand``.
    """

    family: Literal["ice40", "ecp5"]
    devices: list[str] = Field(min_length=1)
    package: str
    speed: int | None = None
    input_hz: float = Field(gt=0)
    adc: str
    motors: int = Field(1, ge=1, le=MOST_PORTS)
    legs: Literal[2, 3] = 2
    guard: bool = False
    link: bool = False
    capture: Literal[0, 9, 10, 11, 12, 13, 14, 15] = 0
    stream: bool = False
    surfaces: int = Field(0, ge=0, le=8)
    spi: bool = False
    overcurrent: bool = False
    walls: int = Field(LINKED_WALLS, ge=1, le=MOST["wall"])
    shared_multiplier: bool = False
    pad_registers: bool = False
    sclk_pins: int = Field(1, ge=1)
    wire_s: float = Field(0.6e-9, ge=0)
    wiring: str | None = None
    on_demand: bool = False
    seeds: list[int] = Field(min_length=1)
    program: list[str] = Field(min_length=1)
    flash: list[str] = Field(min_length=1)
    bridge: Bridge
    sense: Sense
    modulator: Modulated | None = None
    free: list[str] = Field(default_factory=list)
    taken: dict[str, str] = Field(default_factory=dict)
    bank_v: dict[str, float] = Field(default_factory=dict)
    pins_of: str | None = None


TICK_PART = 0.01
"""How far the control rate may be from that of a user's scene, in parts."""


@dataclass(frozen=True)
class Board:
    """A board as it is to be built: ``device`` is the one of ``fpga.devices`` that is fitted."""

    name: str
    root: Path
    fpga: Fpga
    device: str
    scene: Scene
    scene_path: Path | None = None
    """File of a scene that isn't the board's own ``board.toml``."""

    @property
    def scene_file(self) -> str:
        """Where the scene is, as it is told to people."""
        path = self.scene_path or self.folder / "board.toml"
        return str(path.relative_to(self.root) if path.is_relative_to(self.root) else path)

    @property
    def made(self) -> str:
        """Folder of ``build/synth`` with its bitstream: that of another scene is one of its own."""
        return self.name if self.scene_path is None else f"{self.name}-{self.scene_path.stem}"

    @property
    def folder(self) -> Path:
        """The board's folder, from the root."""
        return Path("boards", self.name)

    @property
    def constraints(self) -> Path:
        """The board's pins, from the root."""
        return Path("constraints", self.name + CONSTRAINT_SUFFIX[self.fpga.family])

    @property
    def wiring(self) -> list[Path]:
        """Tables of what is soldered, from the root: the board's own, then what it changes."""
        own = self.fpga.wiring
        return [*([own_wiring(own)] if own else []), Path("boards", "wiring.toml")]

    @property
    def clock_hz(self) -> float:
        return self.words().ports.timing.clock_hz

    @property
    def brushless(self) -> bool:
        """Whether its motors are brushless ones."""
        return self.fpga.legs == THREE_PHASE_LEGS

    @property
    def sense(self) -> Sense | Modulated:
        """What the current comes through: a modulator where the scene names that of the board."""
        modulator, adc = self.fpga.modulator, self.scene.adc
        if modulator is None or adc is None or adc.part != modulator.part:
            return self.fpga.sense
        return modulator

    @property
    def converter(self) -> Part | Modulator:
        """What makes words of the current."""
        sense = self.sense
        return MODULATORS[sense.part] if isinstance(sense, Modulated) else PARTS[self.fpga.adc]

    @property
    def adc_lines(self) -> list[str]:
        """Ports of the top at which the converters' bits come in."""
        lines = self.fpga.motors * (AXES if self.brushless else 1)
        return ["adc_sdata"] if lines == 1 else [f"adc_sdata[{n}]" for n in range(lines)]

    @property
    def sclk_pins(self) -> list[str]:
        """Ports of the top that are SCLK; each serves as many converters as any other."""
        clocks = self.fpga.sclk_pins
        return ["adc_sclk"] if clocks == 1 else [f"adc_sclk[{n}]" for n in range(clocks)]

    def words(self) -> BoardWords:
        """Words of the controller's settings; :class:`SceneError` where the board can't do them."""
        return board_words(
            self.scene, self.converter, self.fpga.motors, guarded=self.fpga.guard,
            pad_registers=self.fpga.pad_registers, trip_a=self.sense.trip_a,
            zero_a=self.sense.zero_a, delay_log2=_DELAY_LOG2[self.fpga.family],
            linked=self.fpga.link, capture=self.fpga.capture, stream=self.fpga.stream,
            surfaces=self.fpga.surfaces, linked_walls=self.fpga.walls,
            legs=self.fpga.legs, shared=self.fpga.shared_multiplier,
            spi=self.fpga.spi, overcurrent=self.fpga.overcurrent,
        )  # fmt: skip

    def headers(self) -> dict[str, str]:
        """Texts of the headers that the board's design includes, by their files' names."""
        words, source = self.words(), self.scene_file
        found = {"wh_board_settings.vh": verilog_header(words, source)}
        if words.linked:
            found["wh_board_settings_rom.vh"] = memory_header(words, source)
        return found

    @property
    def defines(self) -> dict[str, int]:
        """Macros that the board's design is read with."""
        return {"WH_BOARD_ROM": 1} if self.fpga.link else {}


def write_headers(board: Board, folder: Path) -> None:
    """Write :meth:`Board.headers` into ``folder``, from the working directory."""
    for name, text in board.headers().items():
        write_text(folder / name, text)


def own_wiring(name: str) -> Path:
    """The table of a power board: what it changes in ``boards/wiring.toml``, from the root."""
    return Path("boards", f"wiring_{name}.toml")


def board_names(root: Path = ROOT) -> list[str]:
    """Names of all boards, in alphabetical order."""
    return sorted(path.parent.name for path in (root / "boards").glob("*/fpga.toml"))


def _problem(detail: ErrorDetails) -> str:
    """What is wrong with a key of ``fpga.toml``, and what would be right."""
    path = detail["loc"]
    name = dotted(path)
    if detail["type"] == "extra_forbidden":
        tables: dict[str, type[_Table]] = {
            "bridge": Bridge, "sense": Sense, "modulator": Modulated,
        }  # fmt: skip
        table = tables.get(str(path[0]), Fpga) if path[1:] else Fpga
        near = nearest(str(path[-1]), table.model_fields)
        return f"{name} is no key of a board; " + (
            f"did you mean {near}?" if near else f"it has {', '.join(table.model_fields)}"
        )
    if detail["type"] == "missing":
        return f"{name} is missing; another board's fpga.toml shows what it says"
    right = detail["msg"].removeprefix("Input should be ")
    return f"{name} = {as_written(detail['input'])}: it must be {right}"


def load_board(
    name: str, device: str | None = None, root: Path = ROOT, scene_path: Path | None = None
) -> Board:
    """Read the board ``name``; :class:`BoardError` or :class:`SceneError` in one line.

    ``scene_path`` is a scene in place of the board's own, whose settings it then begins with.
    """
    names = board_names(root)
    if name not in names:
        raise BoardError(f"there is no board {name!r}; take one of {', '.join(names)}")
    path = root / "boards" / name / "fpga.toml"
    try:
        data, lines = parse(path.read_bytes())
        places = Places(str(path), lines, {})
        fpga = Fpga.model_validate(data)
    except TomlError as error:
        raise BoardError(f"{path}:{error.line}: {error.problem}") from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise BoardError(f"{places.of(first['loc'])[1]}: {_problem(first)}") from None
    for key in ("capture", "stream", "surfaces", "walls", "spi"):
        if key in fpga.model_fields_set and getattr(fpga, key) and not fpga.link:
            raise BoardError(
                f"{places.of((key,))[1]}: {key} goes with a link; set link = true or leave it out"
            )
    if fpga.overcurrent and not fpga.guard:
        raise BoardError(
            f"{places.of(('overcurrent',))[1]}: overcurrent goes with a guard; set guard = true or "
            "leave it out"
        )
    if fpga.surfaces and (fpga.legs != LEGS or fpga.motors not in (2, 3)):
        raise BoardError(
            f"{places.of(('surfaces',))[1]}: surfaces are across 2 or 3 motors with brushes; "
            "set motors so or leave surfaces out"
        )
    if fpga.pins_of is not None:
        others = load_board(fpga.pins_of, root=root).fpga
        pins = {key: getattr(others, key) for key in ("free", "taken", "bank_v")}
        fpga = fpga.model_copy(update=pins)
    if fpga.legs == THREE_PHASE_LEGS:
        for key, wrong, right in (
            ("link", not fpga.link, "its settings over a link; set link = true"),
            ("motors", AXES * fpga.motors > MOST_PORTS,
             f"at most {MOST_PORTS // AXES} motors, which have two ports each; take fewer"),
            ("shared_multiplier", fpga.shared_multiplier,
             "a multiplier for its core; leave shared_multiplier out"),
        ):  # fmt: skip
            if wrong:
                at = places.of((key,) if key in data else ("legs",))[1]
                raise BoardError(f"{at}: a board with legs = {fpga.legs} has {right}")
    elif fpga.link:
        for key, wrong, right in (
            ("shared_multiplier", fpga.shared_multiplier,
             "one multiplier for all products always; leave shared_multiplier out"),
            ("walls", fpga.walls > MOST_WALLS,
             f"{MOST_WALLS} walls for a motor; take walls = {MOST_WALLS} or fewer"),
        ):  # fmt: skip
            if wrong:
                raise BoardError(f"{places.of((key,))[1]}: a board with link = true has {right}")
    if fpga.motors % fpga.sclk_pins:
        raise BoardError(
            f"{places.of(('sclk_pins',))[1]}: sclk_pins = {fpga.sclk_pins} can't be shared "
            f"evenly by {fpga.motors} motors; take a divisor of motors"
        )
    if fpga.wiring is not None and not (root / own_wiring(fpga.wiring)).is_file():
        raise BoardError(
            f"{places.of(('wiring',))[1]}: there is no {own_wiring(fpga.wiring)}; "
            "add it, or leave wiring out"
        )
    if fpga.adc not in PARTS:
        raise BoardError(f"{path}: adc = {fpga.adc!r} is not known; {', '.join(PARTS)} are")
    if fpga.modulator is not None and fpga.modulator.part not in MODULATORS:
        at = places.of(("modulator", "part"))[1]
        raise BoardError(
            f"{at}: modulator.part = {fpga.modulator.part!r} is not known; "
            f"{', '.join(MODULATORS)} are"
        )
    device = device or fpga.devices[0]
    if device not in fpga.devices:
        raise BoardError(f"{name} has no device {device!r}; take one of {', '.join(fpga.devices)}")
    if scene_path is None:
        return Board(name, root, fpga, device, load_scene(path.with_name("board.toml")))
    scene = _own_scene(scene_path, fpga)
    board = Board(name, root, fpga, device, scene, scene_path.resolve())
    made_hz = 1.0 / board.words().ports.timing.tick_s
    if abs(scene.controller.tick_hz / made_hz - 1.0) > TICK_PART:
        raise scene.refusal(
            f"controller.tick_hz = {scene.controller.tick_hz:.7g}, and this board's clock and the "
            f"scene's carrier make {made_hz:.7g} of it; set it so, or change drive.pwm_hz",
            "controller.tick_hz",
        )
    return board


def _own_scene(path: Path, fpga: Fpga) -> Scene:
    """A user's scene for a board; ``SceneError`` for what :func:`board_words` can't refuse."""
    scene = load_scene(path)
    for table in ("adc", "drive", "encoder"):
        if getattr(scene, table) is None:
            raise scene.refusal(
                f"the scene has no [{table}], which a board has; take that of the board's own "
                "board.toml",
                table,
            )
    if scene.drive is not None and scene.drive.bus_v is None:
        raise scene.refusal("a board's bus has a voltage; set drive.bus_v", "drive.bus_v")
    walls = len(scene.controller.walls)
    most = MOST_WALLS if fpga.link or fpga.motors > 1 else MOST["wall"]
    if walls > most:
        raise scene.refusal(
            f"the scene has {walls} walls, and a motor of this board at most {most}; leave some "
            "out",
            "controller.walls",
        )
    return scene
