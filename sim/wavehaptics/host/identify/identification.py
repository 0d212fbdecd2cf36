# SPDX-License-Identifier: Apache-2.0
"""A motor of a device identified, whichever of the two kinds it is of."""

from __future__ import annotations

from collections.abc import Callable

from wavehaptics.host.identify.brushed import BrushedProcedure, Found
from wavehaptics.host.identify.brushless import BrushlessProcedure, FoundBrushless
from wavehaptics.host.identify.driver import Driver
from wavehaptics.host.identify.steps import Shown, Told, Wishes
from wavehaptics.runtime.ends import ending

_MOVES = "the rotor moves, and the device isn't told where they are"


def _procedure(
    driver: Driver, wishes: Wishes, tell: Told, show: Shown
) -> BrushedProcedure | BrushlessProcedure:
    kind = BrushlessProcedure if driver.brushless else BrushedProcedure
    return kind(driver, wishes, tell, show)


def try_signs(
    driver: Driver,
    counts: int,
    tell: Told = lambda _: None,
    show: Shown = lambda _, __: None,
    current_a: float | None = None,
) -> None:
    """Whether current and encoder have the right sign, by the first voltages and pulses alone.

    No wall and no anchor is on, so a wrong sign doesn't run away. Errors are :func:`identify`'s.
    """
    with driver:
        _procedure(driver, Wishes(counts, current_a, signs=True), tell, show).record()


def identify(
    driver: Driver,
    wishes: Wishes,
    tell: Told = lambda _: None,
    show: Shown = lambda _, __: None,
    keep: Callable[[Found | FoundBrushless], None] = lambda _: None,
) -> Found | FoundBrushless:
    """Every step in turn. ``tell`` takes a line for each, ``show`` a stage and its part done.

    ``keep`` takes what was found, also where the device fails once all is measured. A brushless
    motor's device knows its magnets' angle after that, if its bridges are off then.

    :class:`~wavehaptics.host.identify.steps.NotPlausible` for what can't be a motor that is
    well wired, :class:`~wavehaptics.host.names.HostError` else.
    """
    procedure = _procedure(driver, wishes, tell, show)
    recorded: list[bool] = []
    results: list[Found | FoundBrushless] = []

    def estimated() -> None:
        if recorded:
            results.append(procedure.estimate())
            keep(results[0])

    with ending(estimated), driver:
        procedure.record()
        recorded.append(True)
    (found,) = results
    if isinstance(found, FoundBrushless) and driver.anchored and not driver.running:
        pairs, place = found.magnets.pole_pairs, found.magnet_place.value
        given = driver.give_magnets(pairs, found.counts, place)
        tell(f"magnets: {'the device knows where they are' if given else _MOVES}")
    return found
