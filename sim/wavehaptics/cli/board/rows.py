# SPDX-License-Identifier: Apache-2.0
"""What a capture and a stream have in common: rows of live words, kept and told."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wavehaptics.cli.board.common import finite
from wavehaptics.cli.shared import CommandError

if TYPE_CHECKING:
    import numpy as np

    from wavehaptics.host.capture import Captured, Plan
    from wavehaptics.host.captured_trace import Device
    from wavehaptics.host.names import Place


CountsOption = Annotated[
    int | None, typer.Option(min=1, help="Of the encoder, for the position in rad.")
]
PresetOption = Annotated[
    str | None, typer.Option(metavar="MOTOR", help="A motor's preset, for the torque.")
]
TorqueOption = Annotated[
    float | None,
    typer.Option("--k-t", min=0, callback=finite, help="Or its torque constant, N·m/A."),
]


def torque_constant(preset: str | None, k_t: float | None) -> float | None:
    """k_T in N·m/A of one of two options, or None."""
    from wavehaptics.parts.motors import PRESETS

    if preset is None:
        return k_t
    if k_t is not None:
        raise CommandError("--preset and --k-t: give one of them")
    if preset not in PRESETS:
        raise CommandError(f"--preset {preset}: there is none; take {', '.join(PRESETS)}")
    return PRESETS[preset].k_t


def keep(
    plan: Plan, found: Captured, device: Device, out: Path, picture: str,
    more: dict[str, np.ndarray] | None = None,
) -> None:  # fmt: skip
    """Write trace and picture into the folder ``out``, and tell where they are.

    ``more`` arrays go into the trace's file.
    """
    from wavehaptics.host.captured_trace import save, trace_arrays

    arrays = trace_arrays(found, device)
    print(save(arrays | (more or {}), out))
    print(_picture(plan, found, arrays, out / picture))


def _picture(plan: Plan, found: Captured, arrays: dict[str, np.ndarray], path: Path) -> Path:
    from wavehaptics.trace.pictures import strips_picture

    bits = ("flags", "faults")
    shown = {
        name: (found[name], place.word.row.unit)
        for name, place in zip(plan.names, plan.channels, strict=True)
        if place.word.name not in bits or len(plan.names) == 1
    }
    title = f"{len(found.t)} rows of {plan.row_s * 1e6:.6g} µs"
    if plan.trigger.kind:
        title += f" · trigger: {plan.trigger.text}"
    return strips_picture(arrays, shown, title, path)


def channel_lines(plan: Plan, found: Captured) -> Iterator[str]:
    """A line for each channel: least, mean and greatest value, or the bits that were there."""
    width = max(len(name) for name in plan.names)
    for name, place in zip(plan.names, plan.channels, strict=True):
        values = found[name]
        if place.word.name in ("flags", "faults"):
            yield f"{name:<{width}}  {', '.join(_bit_names(place, values)) or 'none'}"
            continue
        there = values[values == values]  # a number; rows of a stream may be lost
        texts = (f"{value:.6g}" for value in (there.min(), there.mean(), there.max()))
        yield f"{name:<{width}}  {' ... '.join(texts)} {place.word.row.unit}".rstrip()


def _bit_names(place: Place, values: Iterable[int]) -> list[str]:
    """What was there in any row."""
    from wavehaptics.words.faults import FAULTS, FLAGS, bits_of

    there = 0
    for value in values:
        there |= int(value)
    if place.word.name == "flags":
        return [FLAGS[bit] for bit in bits_of(there)]
    return [FAULTS[bit][0] for bit in bits_of(there)]
