# SPDX-License-Identifier: Apache-2.0
"""A board's constraint file against the table of its pins, ``free`` and ``taken`` in ``fpga.toml``.

A pin of a header that nothing else drives is free. A taken one belongs to a part on the board: it
may be used by the port that is named there and by no other.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from wavehaptics.fpga.boards import Board, BoardError

PIN_LINES = {
    "ice40": re.compile(
        r"^[ \t]*set_io[ \t]+(?P<options>(?:-\S+[ \t]+(?:(?:yes|no|\d+)[ \t]+)?)*)"
        r"(?P<port>\S+)[ \t]+(?P<site>\w+)",
        re.MULTILINE,
    ),
    "ecp5": re.compile(
        r'^[ \t]*LOCATE[ \t]+COMP[ \t]+"(?P<port>[^"]+)"[ \t]+SITE[ \t]+"(?P<site>\w+)"',
        re.MULTILINE,
    ),
}
"""A port's place in the constraint files of each family."""

_ECP5_BUFFER = re.compile(
    r'^[ \t]*IOBUF[ \t]+PORT[ \t]+"(?P<port>[^"]+)"(?P<rest>[^;]*);', re.MULTILINE
)
_PULLS = {
    "UP": re.compile(
        r"(adc_sdata|enc_a|enc_b|button_start_n|start_n|stop|uart_rx|spi_cs_n|overcurrent_n)"
        r"(\[\d+\])?"
    ),
    "DOWN": re.compile(r"button_start|spi_sclk|spi_mosi"),
}
"""Ports that come in by a wire or a button, and where one that is off has to leave them."""

_CURES = {
    "ice40": {
        "UP": "give it set_io -pullup yes",
        "DOWN": "an iCE40 pulls up only, so take a button to ground",
    },
    "ecp5": {"UP": "give it PULLMODE=UP", "DOWN": "give it PULLMODE=DOWN"},
}


_OF_KEYS = {
    "spi": ("spi_cs_n", "spi_sclk", "spi_mosi", "spi_miso"),
    "overcurrent": ("overcurrent_n",),
}
"""Ports that a top has where a key of ``fpga.toml`` says so, and only there."""

_USUAL_BANK_V = 3.3
"""Supply of a bank, where ``fpga.toml`` says no other."""


@dataclass(frozen=True)
class Pin:
    """A line of a constraint file.

    ``pull`` is ``UP``, ``DOWN`` or empty for none; ``io_type`` is empty of an iCE40.
    """

    port: str
    site: str
    line: int
    pull: str
    io_type: str = ""

    @property
    def volts(self) -> float | None:
        """The bank's supply that its standard is for, V; None without one."""
        found = re.search(r"(\d)(\d+)", self.io_type)
        return float(f"{found[1]}.{found[2]}") if found else None


def read_pins(text: str, family: str) -> list[Pin]:
    """The pins of a constraint file, in its order."""
    buffers = {found["port"]: found["rest"] for found in _ECP5_BUFFER.finditer(text)}
    pins = []
    for found in PIN_LINES[family].finditer(text):
        if family == "ice40":
            pull = "UP" if re.search(r"-pullup\s+yes", found["options"]) else ""
        else:
            mode = re.search(r"PULLMODE=(UP|DOWN)\b", buffers.get(found["port"], ""))
            pull = mode[1] if mode else ""
        io_type = re.search(r"IO_TYPE=(\w+)", buffers.get(found["port"], ""))
        line = text.count("\n", 0, found.start()) + 1
        pins.append(Pin(found["port"], found["site"], line, pull, io_type[1] if io_type else ""))
    return pins


def check(board: Board, constraints: Path | None = None) -> None:
    """:class:`BoardError` at the first pin that is wrong.

    It isn't the board's to use, is pulled wrongly, or is for another supply than its bank's; or it
    isn't there, and ``fpga.toml`` says that the board has it.
    """
    path = constraints or board.root / board.constraints
    name = board.constraints if constraints is None else constraints
    table = f"{Path('boards') / (board.fpga.pins_of or board.name)}/fpga.toml"
    free = set(board.fpga.free)
    seen: dict[str, str] = {}
    for pin in read_pins(path.read_text(encoding="utf-8"), board.fpga.family):
        place = f"{name}:{pin.line}: {pin.port} is at {pin.site}"
        if pin.site in seen:
            raise BoardError(f"{place}, where {seen[pin.site]} is already; take another pin")
        seen[pin.site] = pin.port
        owner = board.fpga.taken.get(pin.site)
        if owner is not None and owner != pin.port:
            raise BoardError(f"{place}, which is taken: {owner} ({table}); take a free pin")
        if owner is None and pin.site not in free:
            raise BoardError(f"{place}, unknown to {table}; enter it there as free or taken")
        bank_v = board.fpga.bank_v.get(pin.site, _USUAL_BANK_V)
        if pin.volts not in (None, bank_v):
            raise BoardError(
                f"{place}, of a bank on {bank_v:g} V ({table}), and {pin.io_type} is of "
                f"{pin.volts:g} V; give it an IO_TYPE of {bank_v:g} V, or take another pin"
            )
        wanted = next((pull for pull, of in _PULLS.items() if of.fullmatch(pin.port)), pin.pull)
        if pin.pull != wanted:
            found = f"is pulled {pin.pull}" if pin.pull else "floats"
            cure = _CURES[board.fpga.family][wanted]
            raise BoardError(f"{place} and {found} where its wire is off; {cure}")
    for key, ports in _OF_KEYS.items():
        there = [port for port in ports if port in seen.values()]
        if getattr(board.fpga, key) and there != [*ports]:
            missing = next(port for port in ports if port not in there)
            raise BoardError(
                f"{name}: {missing} is missing, and {board.folder}/fpga.toml has {key} = true; "
                "give it a pin, or leave the key out"
            )
        if there and not getattr(board.fpga, key):
            raise BoardError(
                f"{name}: {there[0]} has a pin, and {board.folder}/fpga.toml has no {key} = true; "
                "set it there, or delete the line"
            )
