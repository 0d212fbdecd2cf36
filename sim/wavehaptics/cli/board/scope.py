# SPDX-License-Identifier: Apache-2.0
"""``board scope``: a page of this machine that shows a board live."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from wavehaptics.cli.board import common
from wavehaptics.cli.shared import CommandError, SetOption
from wavehaptics.scene import find_scene, load_device

SCOPE_SCENE = "live_wall"
"""What the scope's virtual board has behind it unless another scene is named."""

SCOPE_HTTP_PORT = 8317
SCOPE_TIMEOUT = 2.0


@common.board.command()
def scope(
    port: common.PortOption = "",
    virtual: Annotated[
        str | None,
        typer.Option(
            metavar="SCENE",
            help=f"In place of a port: a virtual board of its own, by default with {SCOPE_SCENE}.",
        ),
    ] = None,
    scene: Annotated[
        str | None,
        typer.Option(metavar="SCENE", help="With a port: what motor, encoder and W are behind it."),
    ] = None,
    overrides: SetOption = None,
    k_t: Annotated[
        float | None,
        typer.Option(
            min=1e-4, max=10, callback=common.finite, help="With a port: k_T of its motor, N·m/A."
        ),
    ] = None,
    counts: Annotated[
        int | None, typer.Option(min=4, help="With a port: its encoder's counts a turn.")
    ] = None,
    hand: Annotated[
        Path | None, typer.Option(metavar="PATH", help="With a port: the --hand of its board.")
    ] = None,
    http_port: Annotated[
        int, typer.Option(min=0, max=65535, help="Of the page; 0: any that is free.")
    ] = SCOPE_HTTP_PORT,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Open no browser with the page.")
    ] = False,
    motor: common.MotorOption = 0,
    unit: common.UnitOption = 1,
    timeout: common.TimeoutOption = SCOPE_TIMEOUT,
) -> None:
    """Show the board live on a page of this machine: push its wall, set it, stop it."""
    if virtual is not None and port:
        raise CommandError("--virtual is a board of its own: leave --port and WH_PORT out")
    told = {"--scene": scene, "--k-t": k_t, "--counts": counts, "--hand": hand}
    for option, value in told.items() if not port else ():
        if value is not None:
            raise CommandError(f"{option} goes with --port; a virtual board knows its own")
    if overrides and port and scene is None:
        raise CommandError("--set goes with a scene: name one with --scene")
    name = scene if port else virtual or SCOPE_SCENE
    path = find_scene(name) if name is not None else None
    if path is not None:
        load_device(path, overrides or ())

    from wavehaptics.host.scope import command
    from wavehaptics.host.scope.bench import Known
    from wavehaptics.host.scope.plug import Plug, VirtualPlug

    known, sets = Known(), tuple(overrides or ())
    if path is not None:
        known = Known.of_scene(path, sets, starts=not port or hand is not None)
    known = known.but(k_t, counts)
    with common.refusals():
        led = None if known.device else motor
        plug = Plug(port, hand) if port else VirtualPlug(str(path), sets, led)
        command.run(
            plug, known, http_port=http_port, browser=not no_browser, unit=unit, motor=motor,
            timeout_s=timeout,
        )  # fmt: skip
