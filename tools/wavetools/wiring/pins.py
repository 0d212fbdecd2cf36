# SPDX-License-Identifier: Apache-2.0
"""Which wire goes to which pin of a board: its constraint file laid over its maker's headers."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from pydantic import BaseModel, ConfigDict, ValidationError
from wavehaptics.fpga.boards import load_board
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toml_source import TomlError, parse
from wavehaptics.words.table import AXES

from wavetools.wiring.parts import WiringError, load_table

HEADERS = Path("boards", "headers.toml")
"""The headers as their makers print them, from the root."""

_PCF = re.compile(r"^\s*set_io(?:\s+-\S+\s+\S+)*\s+(\S+)\s+(\w+)", re.MULTILINE)
_LPF = re.compile(r'^\s*LOCATE\s+COMP\s+"([^"]+)"\s+SITE\s+"(\w+)"', re.MULTILINE)

_TO = {
    "adc_cs_n": "R8, CS of U8",
    "adc_sclk": "R8, SCLK of U8",
    "adc_sdata": "SDATA of U8",
    "enc_a": "encoder A, R13",
    "enc_b": "encoder B, R13",
    "alive": "R3, R1",
    "stop": "S1c, R10, C13",
    "start_n": "S2, R17",
    "led_fault": "LED to ground, R18",
    "uart_rx": "serial adapter, its TX",
    "uart_tx": "serial adapter, its RX",
    "spi_cs_n": "host MCU, CS",
    "spi_sclk": "host MCU, SCLK",
    "spi_mosi": "host MCU, MOSI",
    "spi_miso": "R24, host MCU, MISO",
    "overcurrent_n": "Q of U10",
    "gate_ah": "R4, U4 pin 1",
    "gate_al": "R4, U4 pin 4",
    "gate_bh": "R4, U4 pin 9",
    "gate_bl": "R4, U4 pin 12",
    "gate_ch": "R4, second U4 pin 1",
    "gate_cl": "R4, second U4 pin 4",
}
"""Where the wire of each port of a board's top goes, by the references of the schematic."""

_SHARED = ("adc_cs_n", "adc_sclk")
"""Ports that serve the converters of several motors."""


class _Header(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    upper: list[str]
    lower: list[str]


class _Headers(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    source: str
    on_board: dict[str, str]
    headers: list[_Header]


class Pin(NamedTuple):
    """A pin of a header: what is printed beside it, the FPGA's site or a supply, and its port."""

    printed: str
    place: str
    port: str | None


class Wires(NamedTuple):
    """The rows of each header that carries a signal, and the ports that the board has itself."""

    headers: dict[str, list[tuple[Pin, Pin]]]
    on_board: list[tuple[str, str, str]]


def ports(board: str, root: Path = ROOT) -> dict[str, str]:
    """The site of each port, of the board's constraint file."""
    loaded = load_board(board, root=root)
    text = (root / loaded.constraints).read_text(encoding="utf-8")
    return dict((_PCF if loaded.fpga.family == "ice40" else _LPF).findall(text))


def _headers(board: str, root: Path) -> _Headers:
    path = root / HEADERS
    try:
        data, _ = parse(path.read_bytes())
        entry = data[board]
        return _Headers.model_validate(data[entry["as"]] if "as" in entry else entry)
    except TomlError as error:
        raise WiringError(f"{path}:{error.line}: {error.problem}") from None
    except KeyError as error:
        raise WiringError(f"{path}: there is no table [{error.args[0]}]; add it") from None
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise WiringError(f"{path}: {board}.{key}: {first['msg']}") from None


def wires(board: str, root: Path = ROOT) -> Wires:
    """A port that is neither on a header nor known as the board's own is a :class:`WiringError`."""
    known, sites = _headers(board, root), {site: port for port, site in ports(board, root).items()}
    left = dict(sites)
    found: dict[str, list[tuple[Pin, Pin]]] = {}
    for header in known.headers:
        rows: list[tuple[Pin, Pin]] = []
        for pair in zip(header.upper, header.lower, strict=True):
            split = [cell.split(":", 1) for cell in pair]
            upper, lower = (Pin(name, place, sites.get(place)) for name, place in split)
            rows.append((upper, lower))
            for _, place in split:
                left.pop(place, None)
        if any(pin.port for row in rows for pin in row):
            found[header.name] = rows
    on_board = []
    for site, port in left.items():
        what = known.on_board.get(port)
        if what is None:
            raise WiringError(
                f"{root / HEADERS}: {port} of {board} at {site} is on no header; "
                "name it in on_board or move it"
            )
        on_board.append((port, site, what))
    return Wires(found, on_board)


def goes_to(
    pin: Pin, brushless: bool = False, sharing: int = 1, own: Mapping[str, str] = _TO,
    motors: int = 1,
) -> str:  # fmt: skip
    """Where a pin's wire goes; nowhere for one that is not used.

    Several ports of a name are those of several ``motors``, SDATA's of each phase of ``brushless``
    ones; of CS and SCLK each is that of ``sharing`` motors. ``own`` is where a power board's wires
    go.
    """
    if pin.port is None:
        if pin.place == "GND":
            return "ground"
        if pin.place in ("5 V", "1.2 V core"):
            return "**never**"
        if pin.place == "supplies":
            return "measure first"
        return "3.3 V of the sheets" if "3.3 V" in pin.place else "–"
    base, _, index = pin.port.rstrip("]").partition("[")
    if pin.port in own:
        return own[pin.port]
    if base not in _TO:
        raise WiringError(f"nobody has said where the wire of {pin.port} goes; add it to pins.py")
    if not index:
        return _TO[base]
    if brushless and base == "adc_sdata":
        motor, phase = divmod(int(index), AXES)
        return f"{f'motor {motor}, ' * (motors > 1)}phase {'ab'[phase]}: {_TO[base]}"
    if base not in _SHARED or sharing == 1:
        return f"motor {index}: {_TO[base]}"
    first = int(index) * sharing
    joined = "and" if sharing == 2 else "to"
    return f"motors {first} {joined} {first + sharing - 1}: {_TO[base]}"


def table(board: str, root: Path = ROOT) -> str:
    """The headers and the board's own ports as tables of Markdown."""
    found, loaded = wires(board, root), load_board(board, root=root)
    own = _TO if loaded.fpga.wiring is None else {**_TO, **load_table(root, loaded.fpga.wiring).to}
    sharing = loaded.fpga.motors // loaded.fpga.sclk_pins
    lines: list[str] = []
    for name, rows in found.headers.items():
        lines += [f"**{name}**, as it is printed, row by row:", ""]
        lines += ["| pin | FPGA | signal | to | pin | FPGA | signal | to |"]
        lines += ["|--:|---|---|---|--:|---|---|---|"]
        for row in rows:
            cells = [
                text
                for pin in row
                for text in (
                    pin.printed, pin.place, f"`{pin.port}`" if pin.port else "–",
                    goes_to(pin, loaded.brushless, sharing, own, loaded.fpga.motors),
                )
            ]  # fmt: skip
            lines.append(f"| {' | '.join(cells)} |")
        lines.append("")
    lines += ["On the board:", "", "| signal | FPGA | what |", "|---|---|---|"]
    lines += [f"| `{port}` | {site} | {what} |" for port, site, what in found.on_board]
    source = textwrap.fill(f"Source: {_headers(board, root).source}.", 120, break_on_hyphens=False)
    return "\n".join([*lines, "", source, ""])
