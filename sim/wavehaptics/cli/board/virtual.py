# SPDX-License-Identifier: Apache-2.0
"""``board --virtual``: a board without hardware, on a port of its own."""

from __future__ import annotations

import math
import os
import select
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wavehaptics.cli.board.common import asked_to_end, board, finite
from wavehaptics.cli.shared import CommandError, SetOption, told_waiting
from wavehaptics.runtime.files import try_file
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.terminals import check_terminals
from wavehaptics.scene import Device, Scene, find_scene, load_device

if TYPE_CHECKING:
    from wavehaptics.ladder.linked_pins import LinkedPins

_LONGEST_SOCKET = 107
"""Bytes of a socket's path, ``sun_path`` of unix(7) without its end."""


@board.callback()
def be_virtual(
    context: typer.Context,
    virtual: Annotated[
        str | None,
        typer.Option(metavar="SCENE", help="Be a board with this scene's motor and hand."),
    ] = None,
    overrides: SetOption = None,
    paced: Annotated[
        bool, typer.Option("--paced", help="With --virtual: no faster than real time.")
    ] = False,
    seconds: Annotated[
        float | None,
        typer.Option(
            min=0, callback=finite, help="With --virtual: end after so much simulated time, s."
        ),
    ] = None,
    link: Annotated[
        Path | None,
        typer.Option(metavar="PATH", help="With --virtual: a symbolic link to its port."),
    ] = None,
    hand: Annotated[
        Path | None,
        typer.Option(metavar="PATH", help="With --virtual: a socket that leads the scene's hand."),
    ] = None,
    motors: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=8,
            help="With --virtual: so many motors, each as the scene has it; by default as many as "
            "the board whose board.toml it is, else one.",
        ),
    ] = None,
    surfaces: Annotated[
        int,
        typer.Option(
            min=0,
            max=8,
            help="With --virtual: so many surfaces across 2 or 3 motors, which a computer writes.",
        ),
    ] = 0,
    hand_of: Annotated[
        int, typer.Option(min=0, max=7, help="With --hand: the motor whose hand is led.")
    ] = 0,
    tied: Annotated[
        bool, typer.Option("--tied", help="With --virtual: end with the standard input.")
    ] = False,
) -> None:
    """Be a virtual board, or leave it to the command that follows."""
    command = context.invoked_subcommand
    if virtual is None:
        for option in _given(context):
            there = f"and give its own behind `board {command}`" if command else (
                "or name a scene with --virtual SCENE"
            )  # fmt: skip
            raise CommandError(f"{option} goes with --virtual; leave it out, {there}")
    if command is not None:
        if virtual is not None:
            raise CommandError(
                f"board --virtual runs by itself; type `board {command}` in another terminal"
            )
        return
    if virtual is None:
        raise CommandError(
            "board: give a command, or --virtual SCENE; wavehaptics board --help lists them"
        )
    path = find_scene(virtual)
    device = load_device(path, overrides or ())
    if device.space is not None:
        for option in sorted({"--motors", "--surfaces", "--hand-of"} & set(_given(context))):
            raise CommandError(f"{option}: the scene's [device] says that; leave it out")
        loaded, count = device.scenes[0], len(device.scenes)
    else:
        loaded = device.one("one is taken here; leave one of them in the file")
        count = _motors_of(path, loaded) if motors is None else motors
    if count > 1 and loaded.motor.brushless:
        raise CommandError(f"--motors {count}: a virtual board has one brushless motor; take 1")
    if surfaces and count not in (2, 3):
        raise CommandError(
            f"--surfaces {surfaces}: they are across 2 or 3 motors, and here is {count}"
        )
    if hand_of >= count:
        raise CommandError(f"--hand-of {hand_of}: there is no such motor; take 0...{count - 1}")
    if link is not None:
        _check_place("--link", link, "link", Path.is_symlink)
    if hand is not None:
        _check_place("--hand", hand, "socket", Path.is_socket)
        if len(os.fsencode(hand)) > _LONGEST_SOCKET:
            raise CommandError(f"--hand {hand}: is too long for a socket; name a shorter path")
    lacks_hand = loaded.hand is None or loaded.hand.path == "impact"
    if hand is not None and device.space is None and lacks_hand:
        raise CommandError(f"--hand {hand}: {loaded.scene.name} has no hand that can be led")
    check_terminals()

    from wavehaptics.host.led_hand import MOST_M_S, LedHand
    from wavehaptics.host.virtual import VirtualBoard
    from wavehaptics.ladder.abilities import left_out
    from wavehaptics.ladder.refusals import check_device

    if missing := left_out(loaded, "pins", linked=True):
        # The first line of the output is the port's path, which others read.
        print(f"the board leaves out {', '.join(missing)}", file=sys.stderr)
    if device.space is not None:
        check_device(device, "pins")
    with told_waiting("building the simulated board, which takes minutes the first time"):
        pins = _pins(device, loaded, count, hand_of, surfaces)
        pins.elapse(1)  # compiles the loop
    with asked_to_end() as asked, ExitStack() as kept:
        led = None
        if hand is not None and device.space is not None:
            led = LedHand(hand, *device.space.home_m[:2], most=MOST_M_S)
        elif hand is not None:
            led = LedHand(hand, pins.hand_rad)
        if led is not None:
            kept.enter_context(led)
        running = kept.enter_context(VirtualBoard(pins, link, led))
        print(running.path, flush=True)
        fastest = 1.0 if paced else math.inf
        running.run(lambda: asked() or (tied and _input_ended()), seconds, fastest=fastest)


def _pins(device: Device, scene: Scene, count: int, hand_of: int, surfaces: int) -> LinkedPins:
    """The simulated device, with one motor, several or an arm."""
    from wavehaptics.ladder.linked_motors import LinkedArm, LinkedMotors
    from wavehaptics.ladder.linked_pins import linked_pins

    if device.space is not None:
        return LinkedArm(device)
    if count == 1:
        return linked_pins(scene)
    return LinkedMotors(scene, count, led=hand_of, surfaces=surfaces)


def _given(context: typer.Context) -> list[str]:
    """Options of a virtual board that were given."""
    sources = {
        p.opts[0]: context.get_parameter_source(p.name or "") for p in context.command.params
    }
    return [name for name, source in sources.items() if source and source.name == "COMMANDLINE"]


def _check_place(option: str, path: Path, kind: str, fits: Callable[[Path], bool]) -> None:
    """Refuse a place where nothing of its kind can be made: before what takes a minute."""
    folder = path.parent
    try:
        if os.path.lexists(path) and not fits(path):
            raise CommandError(f"{option} {path}: is there and no {kind}; name another path")
        if not folder.exists():
            reason = f"there is no folder {folder}; make it, or name another path"
            raise CommandError(f"{option} {path}: {reason}")
        if not folder.is_dir():
            raise CommandError(f"{option} {path}: {folder} is no folder; name another path")
        try_file(path)
    except OSError as error:
        reason = f"can't be made: {error.strerror}; name another path"
        raise CommandError(f"{option} {path}: {reason}") from None


def _motors_of(path: Path, scene: Scene) -> int:
    """Motors of the board whose scene this is; 1 where it is no board's, or they are brushless."""
    from wavehaptics.fpga.boards import load_board

    folder = path.resolve().parent
    if (
        scene.motor.brushless
        or path.name != "board.toml"
        or folder.parent != (ROOT / "boards").resolve()
    ):
        return 1
    return load_board(folder.name).fpga.motors


def _input_ended() -> bool:
    """Whether the standard input has ended; what it holds is thrown away."""
    return bool(select.select([0], [], [], 0.0)[0]) and not os.read(0, 4096)
