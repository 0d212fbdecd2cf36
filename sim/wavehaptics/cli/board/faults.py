# SPDX-License-Identifier: Apache-2.0
"""``board faults``: what the guard found."""

from __future__ import annotations

from typing import Annotated

import typer

from wavehaptics.cli.board import common


@common.board.command()
def faults(
    clear: Annotated[bool, typer.Option("--clear", help="Forget those that are over.")] = False,
    port: common.PortOption = "",
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Tell what the guard found, and what disarmed the device."""
    from wavehaptics.host.names import places
    from wavehaptics.words.faults import FAULTS, REFUSED_BY_FAULT, arm_refusal, bits_of

    with common.refusals():
        client = common.connected(port, unit, timeout)
        if clear:
            client.write([(places("clear", client.shape)[0], 1)])
        names = ("faults", "overrun", "armed", "arm_refused", "running")
        found = dict(
            zip(names, client.read(places(n, client.shape)[0] for n in names), strict=True)
        )
    for bit in bits_of(found["faults"]):
        name, meaning = FAULTS[bit]
        print(f"{name}: {meaning}" if meaning else name)
    if found["overrun"]:
        print("a tick is too short for its work, or ticks pass without")
    refused = found["arm_refused"]
    if not found["faults"] and not found["overrun"]:
        print("no faults")
        # The reasons are those of the last time, and stay until it is armed anew.
        over, refused = refused & REFUSED_BY_FAULT, refused & ~REFUSED_BY_FAULT
    else:
        over = 0
    if refused:
        print(f"not armed: {arm_refusal(refused)}")
    if over:
        print("a fault was against arming, and is over")
    state = "on" if found["running"] else "armed, but off" if found["armed"] else "off"
    print(f"the bridges are {state}")
