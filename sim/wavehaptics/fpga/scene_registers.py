# SPDX-License-Identifier: Apache-2.0
"""From a scene to the registers of ``rtl/wh_device.v``, for a design that isn't one of the boards.

The values are those that a board of the same scene starts with: :mod:`.board_words` computes them,
and :mod:`wavehaptics.words.memory` gives each its address. Here they get names, values and units,
and become a C header, a Verilog include or JSON.
"""

from __future__ import annotations

import json
from dataclasses import dataclass

from wavehaptics.fpga.board_words import BoardWords, board_words, first_values, parameters
from wavehaptics.scene import Scene
from wavehaptics.words import table
from wavehaptics.words.generated import LICENCE
from wavehaptics.words.memory import settings_requests
from wavehaptics.words.places import places
from wavehaptics.words.table import (
    LEGS,
    MOST,
    MOTOR_STRIDE,
    THREE_PHASE_LEGS,
    WORDS,
    Sizes,
    Word,
)

FORMATS = ("c", "verilog", "json")

COMMANDS = ("commit", "restart", "clear", "zero_start", "arm", "magnet_start", "settings_busy")
"""Registers, besides the settings, that a start-up sequence needs."""

_NEEDED = {"adc": "adc.bits and adc.full_scale_a", "encoder": "encoder.counts_per_rev"}


@dataclass(frozen=True)
class Register:
    """One register and what a scene writes to it.

    ``motor`` counts the motors, or the axes of brushless ones; ``index`` counts the motor's walls,
    or the rows of its sections.
    """

    word: Word
    motor: int
    index: int
    raw: int
    """As it is on the bus: 32 bits, sign-extended."""

    @property
    def name(self) -> str:
        """Name in ``rtl/words.toml``."""
        return self.word.name

    @property
    def address(self) -> int:
        """Address in words of 32 bits."""
        return self.word.at(self.motor, self.index)

    @property
    def value(self) -> float | int:
        """Value in the register's unit."""
        fixed = self.word.fixed
        raw = self.raw - (1 << 32) if fixed.signed and self.raw >> 31 else self.raw
        return fixed.to_value(raw) if fixed.fraction else raw

    @property
    def unit(self) -> str:
        return self.word.row.unit

    @property
    def text(self) -> str:
        """Name with index and motor, where there are several, its value and its unit."""
        several = MOST[self.word.row.per] * self.word.row.count > 1
        index = f"[{self.index}]" if several else ""
        of = "" if self.word.row.per == "board" else f" of {self.motor}"
        return f"{self.name}{index}{of} = {self.value:.9g} {self.unit}".rstrip()


@dataclass(frozen=True)
class SceneRegisters:
    """What a scene makes of ``wh_device``: its parameters, and the registers' values."""

    scene: str
    clock_hz: float
    parameters: dict[str, int]
    registers: list[Register]


def scene_registers(scene: Scene, motors: int = 1, trip_a: float | None = None) -> SceneRegisters:
    """Parameters and registers for ``motors`` motors that are all the scene's.

    A current of ``trip_a``, or of the scene's ``[guard]``, switches the gates off at once.
    :class:`SceneError` in one line where the registers can't express what the scene asks for.
    """
    for needed, keys in _NEEDED.items():
        if getattr(scene, needed) is None:
            raise scene.refusal(
                f"the scene has no [{needed}], whose figures are in the registers; add {keys}",
                needed,
            )
    legs = THREE_PHASE_LEGS if scene.motor.brushless else LEGS
    if scene.motor.brushless and scene.host is not None:
        raise scene.refusal(
            "[host] is not for a wh_device with a brushless motor; leave it out", "host"
        )
    guarded = scene.guard is None or scene.guard.watch
    if trip_a is None and scene.guard is not None:
        trip_a = scene.guard.trip_a
    board = board_words(scene, None, motors, guarded=guarded, trip_a=trip_a, linked=True, legs=legs)
    return SceneRegisters(
        scene.scene.name, board.ports.timing.clock_hz, parameters(board), _registers(board)
    )


def _registers(board: BoardWords) -> list[Register]:
    """The registers in the order of their addresses."""
    sizes = Sizes(
        board.motors, board.walls, len(board.ports.settings.shaper.words), board.delay_log2,
        board.legs,
    )  # fmt: skip
    words = {place.address: place.word for place in places(sizes, "setting")}
    values = first_values(board, 1)
    pairs: dict[int, int] = {}
    for motor in range(board.motors):
        pairs |= dict(settings_requests(values, board.legs, motor))
    found = []
    for address, raw in sorted(pairs.items()):
        word = words[address]
        motor = 0 if word.row.per == "board" else (address - word.at()) // MOTOR_STRIDE
        found.append(Register(word, motor, address - word.at(motor), raw))
    return found


def as_text(made: SceneRegisters, form: str) -> str:
    """The file's text in one of :data:`FORMATS`."""
    return {"c": _c, "verilog": _verilog, "json": _json}[form](made)


def _json(made: SceneRegisters) -> str:
    rows = [
        {
            "name": one.name,
            "motor": one.motor,
            "index": one.index,
            "address": one.address,
            "raw": one.raw,
            "value": one.value,
            "unit": one.unit,
        }
        for one in made.registers
    ]
    return "[\n" + ",\n".join(json.dumps(row, ensure_ascii=False) for row in rows) + "\n]\n"


def _text(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _c(made: SceneRegisters) -> str:
    rows = [
        f"    X({one.name.upper()}, {one.motor}, {one.index}, 0x{one.address:03x}u, "
        f"0x{one.raw:08x}u, {float(one.value)!r}, {_text(one.unit)})"
        for one in made.registers
    ]
    return "\n".join(
        [
            f"{LICENCE}//",
            f"// Registers of wh_device for the scene {made.scene}, written by "
            "`wavehaptics registers`.",
            "//",
            "// WH_SCENE_REGISTERS(X) calls X(NAME, motor, index, address, raw, value, unit) for",
            "// each register: addresses count words of 32 bits, raw is what is written there.",
            "// The settings take effect when 1 is written to WH_SCENE_AT_COMMIT.",
            "",
            "#ifndef WH_SCENE_REGISTERS_H",
            "#define WH_SCENE_REGISTERS_H",
            "",
            "// The register map that this was made for.",
            f"#define WH_SCENE_MAP_CRC 0x{table.crc():08x}u",
            "#if defined(WH_WORDS_CRC) && WH_WORDS_CRC != WH_SCENE_MAP_CRC",
            '#error "wavehaptics_words.h is of another register map; write this file anew"',
            "#endif",
            "",
            "// Parameters of wh_device.",
            *(f"#define WH_SCENE_{name} {value}" for name, value in made.parameters.items()),
            f"#define WH_SCENE_CLOCK_HZ {round(made.clock_hz)}",
            "",
            "// Addresses of the registers of a start-up sequence.",
            *(f"#define WH_SCENE_AT_{name.upper()} 0x{WORDS[name].at():03x}u" for name in COMMANDS),
            "",
            f"#define WH_SCENE_COUNT {len(made.registers)}",
            " \\\n".join(["#define WH_SCENE_REGISTERS(X)", *rows]),
            "",
            "#endif",
            "",
        ]
    )


def _verilog(made: SceneRegisters) -> str:
    macros = {
        **made.parameters,
        "CLOCK_HZ": round(made.clock_hz),
        **{f"AT_{name.upper()}": f"12'h{WORDS[name].at():03x}" for name in COMMANDS},
        "COUNT": len(made.registers),
    }
    rows = [
        f"`WH_SCENE_WRITE({n}, 12'h{one.address:03x}, 32'h{one.raw:08x})  // {one.text}"
        for n, one in enumerate(made.registers)
    ]
    return "\n".join(
        [
            f"{LICENCE}//",
            f"// Registers of wh_device for the scene {made.scene}, written by "
            "`wavehaptics registers`.",
            "//",
            "// Include it twice. At the top of a file it defines the parameters of wh_device,",
            "// addresses for a start-up sequence, and WH_SCENE_COUNT, the number of registers.",
            "// Where a macro WH_SCENE_WRITE(number, address, raw) is defined, it is a row for",
            "// each register: `address` counts words of 32 bits, `raw` is what is written",
            "// there. The settings take effect when 1 is written to WH_SCENE_AT_COMMIT.",
            "",
            "`ifndef WH_SCENE_COUNT",
            *(f"`define WH_SCENE_{name} {value}" for name, value in macros.items()),
            "`endif",
            "",
            "`ifdef WH_SCENE_WRITE",
            *rows,
            "`endif",
            "",
        ]
    )
