# SPDX-License-Identifier: Apache-2.0
"""Arming by the line: the bridges are on for as long as it is renewed."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from wavehaptics.cli.board import common
from wavehaptics.runtime.ends import ending

if TYPE_CHECKING:
    from wavehaptics.host.client import Client


@common.board.command()
def arm(
    port: common.PortOption = "",
    seconds: Annotated[
        float | None,
        typer.Option(
            min=0, callback=common.finite, help="Disarm after so much time; else at Ctrl-C."
        ),
    ] = None,
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Let the bridges on, and renew that until Ctrl-C; then disarm."""
    with common.refusals():
        client = common.connected(port, unit, timeout)
        with common.asked_to_end() as asked, ending(partial(write_arm, client, 0)):
            stay_armed(client, asked, seconds)
    print("disarmed")


def write_arm(client: Client, value: int) -> None:
    """Write the word ``arm``: 1 arms, 2 renews, 0 disarms."""
    from wavehaptics.host.names import places

    client.write([(places("arm", client.shape)[0], value)])


def stay_armed(client: Client, asked: Callable[[], bool], seconds: float | None) -> None:
    """Arm, and renew it for so many seconds or until somebody asks to end; HostError otherwise."""
    from wavehaptics.host.client import RENEWAL_S, ZERO_S
    from wavehaptics.host.names import HostError, places
    from wavehaptics.words.faults import arm_refusal

    live = [places(name, client.shape)[0] for name in ("armed", "arm_refused")]
    if not client.identification.options["arm"]:
        raise HostError("the device can't be armed by a word; its switch alone lets it run")
    start, told = time.monotonic(), False
    write_arm(client, 1)
    while not asked():
        armed, refused = client.read(live)
        passed = time.monotonic() - start
        if armed and not told:
            print("armed; Ctrl-C disarms", flush=True)
            told, start = True, time.monotonic()
        elif refused or (told and not armed):
            reason = arm_refusal(refused) or "somebody has disarmed it"
            cure = "`board faults` tells more, and --clear forgets what is over"
            raise HostError(f"{'disarmed' if told else 'not armed'}: {reason}; {cure}")
        elif not armed and passed > ZERO_S:
            raise HostError("not armed: the zero takes too long; are there ticks at all?")
        if told and seconds is not None and passed >= seconds:
            return
        time.sleep(RENEWAL_S)
        write_arm(client, 2)


@common.board.command()
def disarm(
    port: common.PortOption = "",
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = common.DEFAULT_TIMEOUT,
) -> None:
    """Switch the bridges off."""
    with common.refusals():
        write_arm(common.connected(port, unit, timeout), 0)
