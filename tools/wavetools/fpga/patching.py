# SPDX-License-Identifier: Apache-2.0
"""Another scene's settings in a built bitstream of an ECP5, without place and route.

The first words of all registers are one block RAM of the bitstream (``defaults`` of
``rtl/wh_registers.v``). A scene that needs no other hardware than the bitstream has differs from it
in that block's contents only. The bitstream is unpacked, the block found by what it holds, and the
rest is packed again as it was.

Registers of the hardware and its limits, which the line can't change either, are constants in the
logic as well (``rtl/wh_setting_group.v``): a scene has to have the bitstream's own ones.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from wavehaptics.fpga.board_words import CHANGEABLE, hardware, memory_words
from wavehaptics.fpga.boards import Board
from wavehaptics.runtime.files import replacing
from wavehaptics.runtime.toolchain import Toolchain
from wavehaptics.words.memory import rom_slots

from wavetools.fpga import synthesis

FAMILY = "ecp5"

KEYS = {
    "WALLS": "controller.walls",
    "MODES": "drive.mode",
    "SHORTEST": "drive.min_pulse_s",
    "DELAY_LOG2": "controller.extra_ticks",
    "SHAPER": "shaper",
    "ANCHOR": "controller.anchor_auto",
    "AGAIN": "drive.pwm_hz",
    "HOST": "host",
    "CLOCK_HZ": "controller.clock_hz",
}
"""What of a scene decides about hardware, by the hardware's name; the rest is the board's."""

_BLOCK = re.compile(r"^\.bram_init \d+\n((?:[0-9a-f]{3}[ \n]){2048})", re.MULTILINE)
_BITS, _EACH, _IN_A_LINE = 9, 4, 8
"""A block RAM in ecpunpack's text has 2,048 cells of 9 bits; four of them are a word of 36 bits."""


class PatchError(RuntimeError):
    """A bitstream that can't be patched. The message is one line."""


def check(built: Board, wanted: Board) -> tuple[list[int], list[int]]:
    """The ROM's words of ``built`` and of ``wanted``, whose scene needs the same board's hardware.

    Raises what a build of the scene raises; ``SceneError`` where hardware differs, and
    :class:`PatchError` where the board's settings are no block RAM, or a limit is in its logic.
    """
    synthesis.check_board(wanted)
    again = build_command(wanted)
    if built.fpga.family != FAMILY or not built.fpga.link:
        raise PatchError(
            f"the settings of {built.name} are constants in its logic, not in a block RAM of an "
            f"ECP5; run `{again}`"
        )
    before, after = built.words(), wanted.words()
    has, needs = hardware(before), hardware(after)
    for name, value in needs.items():
        if value != has[name]:
            key = KEYS[name]
            raise wanted.scene.refusal(
                f"{key} needs other hardware than the bitstream has: {name} is {value}, "
                f"and {has[name]} there; set it as in {built.scene_file}, or run `{again}`",
                key,
            )
    old, new = memory_words(before), memory_words(after)
    for word, slots in rom_slots():
        if f"{word.block}.{word.group}" in CHANGEABLE or word.name in after.ranges:
            continue
        for slot in slots:
            if old[slot] != new[slot]:
                raise PatchError(
                    f"{wanted.scene_file}: the scene makes {word.name} = {new[slot]:#x}, "
                    f"and {old[slot]:#x} is a constant in the bitstream's logic; run `{again}`"
                )
    return old, new


def build_command(board: Board) -> str:
    """The command that makes the bitstream of a board's scene from its sources."""
    return f"make bitstream BOARD={board.name} SCENE={board.scene_file}"


def blocks(config: str) -> list[tuple[re.Match[str], list[int]]]:
    """The block RAMs in a configuration's text, each with its contents as words of 36 bits."""
    found = []
    for block in _BLOCK.finditer(config):
        cells = [int(text, 16) for text in block[1].split()]
        words = [
            sum(cell << _BITS * n for n, cell in enumerate(cells[at : at + _EACH]))
            for at in range(0, len(cells), _EACH)
        ]
        found.append((block, words))
    return found


def replaced(config: str, old: list[int], new: list[int]) -> str | None:
    """``config`` with the words ``new`` in the one block RAM that holds ``old`` and nothing else.

    None where no block does, or more than one.
    """
    same = [
        (block, words) for block, words in blocks(config)
        if words[: len(old)] == old and not any(words[len(old) :])
    ]  # fmt: skip
    if len(same) != 1:
        return None
    block, words = same[0]
    words[: len(new)] = new
    cells = [f"{word >> _BITS * n & 0x1FF:03x}" for word in words for n in range(_EACH)]
    lines = [
        " ".join(cells[at : at + _IN_A_LINE]) + "\n" for at in range(0, len(cells), _IN_A_LINE)
    ]
    return config[: block.start(1)] + "".join(lines) + config[block.end(1) :]


def patch(bitstream: Path, built: Board, wanted: Board, out: Path, tools: Toolchain) -> None:
    """Write ``bitstream``, made of ``built``, with the settings of ``wanted`` into ``out``.

    Raises as :func:`check` does; :class:`PatchError` where the file isn't of ``built``, or where
    anything else than the settings would change.
    """
    old, new = check(built, wanted)
    with tempfile.TemporaryDirectory(prefix="wavehaptics-patch-") as name:
        folder = Path(name)
        (folder / "old.bit").write_bytes(bitstream.read_bytes())
        config = _unpacked(folder, "old", tools, bitstream)
        if _packed(folder, "old", tools, bitstream) != (folder / "old.bit").read_bytes():
            raise PatchError(
                f"{bitstream}: packed again it is another file, so its header has options that "
                f"would be lost; run `{build_command(wanted)}`"
            )
        text = replaced(config, old, new)
        if text is None:
            raise PatchError(
                f"{bitstream}: no block RAM has the settings of {built.scene_file}; name the "
                "scene that it was built with (--built-with) and its board (--board), or run "
                f"`{build_command(wanted)}`"
            )
        (folder / "new.config").write_text(text, encoding="utf-8")
        made = _packed(folder, "new", tools, bitstream)
        (folder / "new.bit").write_bytes(made)
        if _unpacked(folder, "new", tools, bitstream) != text:
            raise PatchError(f"{bitstream}: unpacked again the result isn't what was to be written")
    with replacing(out) as part:
        part.write_bytes(made)


def _unpacked(folder: Path, name: str, tools: Toolchain, bitstream: Path) -> str:
    """Configuration of ``name``.bit in ``folder``, which becomes ``name``.config."""
    _run("ecpunpack", [f"{name}.bit", f"{name}.config"], folder, tools, bitstream)
    return (folder / f"{name}.config").read_text(encoding="utf-8")


def _packed(folder: Path, name: str, tools: Toolchain, bitstream: Path) -> bytes:
    """Bitstream of ``name``.config in ``folder``, as a build packs it."""
    arguments = [*synthesis.PACK_OPTIONS[FAMILY], f"{name}.config", "packed.bit"]
    _run("ecppack", arguments, folder, tools, bitstream)
    return (folder / "packed.bit").read_bytes()


def _run(
    tool: str, arguments: list[str], folder: Path, tools: Toolchain, bitstream: Path
) -> None:  # fmt: skip
    log = folder / f"{tool}.log"
    if tools.run(tool, arguments, folder, log):
        raise PatchError(f"{bitstream}: {tool} failed: {synthesis.last_line(log)}")
