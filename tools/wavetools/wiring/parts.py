# SPDX-License-Identifier: Apache-2.0
"""The table of parts, ``boards/wiring.toml``."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from matplotlib.ticker import EngFormatter
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from wavehaptics.fpga.boards import board_names, load_board, own_wiring
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toml_source import TomlError, parse

TABLE = Path("boards", "wiring.toml")
"""The table, from the root."""

Family = Literal["ice40", "ecp5"]
FAMILIES: tuple[Family, ...] = ("ice40", "ecp5")
FAMILY_NAMES = {"ice40": "iCE40", "ecp5": "ECP5"}

Pair = tuple[float, float]


class WiringError(ValueError):
    """A table that can't be read, or a circuit that can't be simulated. One line."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Part(_Strict):
    """A row of the table; ``value`` is in ``unit``, one for each family where it hangs on that."""

    role: str
    each: Literal["board", "motor", "sclk_pin"]
    number: int = Field(ge=1)
    rating: str
    substitute: str
    type: str | None = None
    value: float | dict[Family, float] | None = None
    unit: Literal["Ω", "F"] | None = None
    tolerance: float = Field(0.0, ge=0, lt=1)
    option: str | None = None

    @model_validator(mode="after")
    def _named(self) -> Part:
        if (self.type is None) == (self.value is None):
            raise ValueError("a part has either a type or a value")
        if (self.value is None) != (self.unit is None):
            raise ValueError("a value has a unit, and nothing else has one")
        if isinstance(self.value, dict) and set(self.value) != set(FAMILIES):
            raise ValueError(f"one value for each of {', '.join(FAMILIES)}")
        return self

    def of(self, family: Family) -> float:
        """The value on a board of this family; :class:`WiringError` for a part without one."""
        value = self.value[family] if isinstance(self.value, dict) else self.value
        if value is None:
            raise WiringError(f"{self.type} has no value")
        return value

    def text(self, family: Family | None = None) -> str:
        """What is printed beside the symbol: ``2.2 nF``, or the part's name."""
        if self.type is not None:
            return self.type
        if family is None and isinstance(self.value, dict):
            return ", ".join(f"{self.text(f)} ({FAMILY_NAMES[f]})" for f in FAMILIES)
        return EngFormatter(self.unit or "")(self.of(family or FAMILIES[0]))


class Supply(_Strict):
    logic_v: float
    tolerance: float
    temperature_c: list[float]


class Levels(_Strict):
    v_il: float
    v_ih: float


class Schmitt(_Strict):
    """Thresholds at two supplies."""

    supply_v: Pair
    rising_max_v: Pair
    falling_max_v: Pair
    falling_min_v: Pair

    def at(self, name: str, supply_v: float) -> float:
        """A threshold at a supply, by the straight line through both."""
        (low, high), (first, second) = self.supply_v, getattr(self, name)
        return first + (second - first) * (supply_v - low) / (high - low)


class Fpga(_Strict):
    pull_a: float


class Pad(_Strict):
    ohm: float
    farad: float


class Supervisor(_Strict):
    trip_v: Pair
    delay_s: float


class Diode(_Strict):
    points_a: list[float]
    typical_v: list[float]
    most_v: list[float]
    typical_model: str
    most_model: str


class Current(_Strict):
    gain: float
    swing_v: float


class Stop(_Strict):
    longest_s: float
    longest_tick_s: float


class Table(_Strict):
    """The whole of ``boards/wiring.toml``, or of what a power board makes of it.

    ``name`` is the power board's, and ``to`` where the wires of the FPGA's ports go there, as far
    as that differs.
    """

    name: str | None = None
    to: dict[str, str] = Field(default_factory=dict)
    supply: Supply
    levels: Levels
    schmitt: Schmitt
    fpga: dict[Family, Fpga]
    pad: Pad
    supervisor_levels: Supervisor
    diode: Diode
    current: Current
    stop: Stop
    parts: dict[str, Part]

    def text(self, reference: str, family: Family | None = None) -> str:
        return self.part(reference).text(family)

    def part(self, reference: str) -> Part:
        if reference not in self.parts:
            raise WiringError(f"{TABLE}: there is no part {reference}; add [parts.{reference}]")
        return self.parts[reference]

    def changed(self, **values: float | dict[Family, float]) -> Table:
        """The table with other values of parts, to try what they do."""
        parts = {
            name: part.model_copy(update={"value": values[name]}) if name in values else part
            for name, part in self.parts.items()
        }
        return self.model_copy(update={"parts": parts})


def power_boards() -> list[Table]:
    """The tables of the power boards that a board of ``boards/`` has."""
    names = {load_board(name).fpga.wiring for name in board_names()}
    return [load_table(name=name) for name in sorted(name for name in names if name)]


def load_table(root: Path = ROOT, name: str | None = None) -> Table:
    """Read the table, or that of the power board ``name``; :class:`WiringError` in one line.

    A power board's table has parts in place of others, the list ``without`` of those that it
    leaves out, and other values of any table.
    """
    path = root / TABLE
    try:
        data, lines = parse(path.read_bytes())
        if name is not None:
            path = root / own_wiring(name)
            own, lines = parse(path.read_bytes())
            left_out = own.pop("without", [])
            unknown = sorted(set(left_out) - set(data["parts"]))
            if unknown:
                raise WiringError(f"{path}: without: there is no part {unknown[0]}; leave it out")
            own["parts"] = {**data["parts"], **own.get("parts", {})}
            own["parts"] = {key: own["parts"][key] for key in own["parts"] if key not in left_out}
            data = {key: {**data.get(key, {}), **own.get(key, {})} for key in {*data, *own}}
            data["name"], data["parts"] = name, own["parts"]
        return Table.model_validate(data)
    except OSError as error:
        raise WiringError(f"{path}: {error.strerror}") from None
    except TomlError as error:
        raise WiringError(f"{path}:{error.line}: {error.problem}") from None
    except ValidationError as error:
        first = error.errors()[0]
        place = tuple(first["loc"])
        while place and place not in lines:
            place = place[:-1]
        key = ".".join(str(part) for part in first["loc"])
        raise WiringError(f"{path}:{lines.get(place, 1)}: {key}: {first['msg']}") from None
