# SPDX-License-Identifier: Apache-2.0
"""Commands for one scene: run, measure, check, list."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from wavehaptics.cli.shared import (
    CONTROLLERS,
    DEFAULT_CONTROLLER,
    RUNS_DIR,
    CommandError,
    SceneArgument,
    SceneMotorOption,
    SetOption,
    make_folder,
    metrics_table,
    scene_of_one,
    shown_progress,
    shown_stages,
    warn,
)
from wavehaptics.scene import (
    Device,
    SceneError,
    find_scene,
    first_comment,
    load_device,
    shipped_scenes,
)

app = typer.Typer()


ControllerOption = Annotated[
    str,
    typer.Option("--controller", "-c", metavar="NAME", help=f"One of {', '.join(CONTROLLERS)}."),
]


def checked_controller(controller: str) -> None:
    """:class:`CommandError` with the cure where there is no such controller."""
    if controller not in CONTROLLERS:
        near = difflib.get_close_matches(controller, CONTROLLERS, n=1)
        meant = f"did you mean {near[0]}? " if near else ""
        known = ", ".join(CONTROLLERS)
        raise CommandError(
            f"--controller {controller}: unknown; {meant}the controllers are {known}"
        )


def _checked(
    path: Path, controller: str, overrides: Sequence[str] | None, motor: str | None
) -> tuple[Device, list[str]]:
    """Motors that ``controller`` can run, and what a person should know of how it does."""
    checked_controller(controller)
    device = load_device(path, overrides or ())
    if motor is not None:
        device = device.only(motor)

    from wavehaptics.ladder.refusals import check_device

    return device, check_device(device, controller)


def _of(device: Device, motor: str) -> str:
    """What a line says of the motor first, where there are several."""
    return f"{motor}: " if len(device.motors) > 1 else ""


def _beyond(device: Device, controller: str) -> list[str]:
    """What the motors' scenes may ask for beyond a range, a line each."""
    from wavehaptics.ladder.ranges import exceeded

    return [
        f"warning: {_of(device, name)}{one}"
        for name, loaded in device.motors.items()
        for one in exceeded(loaded, controller)
    ]


@app.command()
def run(
    scene: SceneArgument,
    controller: ControllerOption = DEFAULT_CONTROLLER,
    overrides: SetOption = None,
    motor: SceneMotorOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help=f"Folder for the results; {RUNS_DIR}/<scene name>-<controller> by default.",
        ),
    ] = None,
) -> None:
    """Simulate SCENE and write trace.npz, metrics.json and pictures, of each motor of several."""
    device, told = _checked(find_scene(scene), controller, overrides, motor)
    folder = _folder(f"{device.name}-{controller}", motor) if out is None else out
    several = len(device.motors) > 1 or device.space is not None
    for below in [folder / name for name in device.motors] if several else [folder]:
        make_folder(below)

    from wavehaptics.ladder.ranges import CURRENT, exceeded

    for name, loaded in device.motors.items():
        for beyond in exceeded(loaded, controller):
            if beyond.quantity != CURRENT:  # whether it was is known after the run
                warn(f"{_of(device, name)}{beyond}")
    found = _run(device, controller, folder, named=motor is not None)
    for line in told:
        print(line)
    for number, (name, metrics) in enumerate(found.items()):
        print(metrics_table(metrics), end="\n" if number == len(found) - 1 else "\n\n")
        if clipped := metrics.get("clipped_fraction"):
            warn(
                f"{_of(device, name)}in {100 * clipped:.2g} % of the ticks the current, a sample "
                "of it or v was at the end of its range (clipped_fraction): the port gave way "
                "there, or only damped"
            )
    print(f"results in {folder}")


def _folder(name: str, motor: str | None) -> Path:
    """Where results go by default: those of one motor of several where a run of all has them."""
    return RUNS_DIR / name if motor is None else RUNS_DIR / name / motor


def _run(
    device: Device, controller: str, folder: Path, *, named: bool
) -> dict[str, dict[str, Any]]:
    """Metrics of each motor, whose files are written; ``named``: one alone says its name.

    Of a device those of the tip.
    """
    if device.space is not None:
        from wavehaptics.ladder.joint_run import run_joint

        with shown_progress(f"{device.name} on {controller}") as progress:
            found = run_joint(device, controller, folder, progress)
        return {device.name: {key: value for key, value in found.items() if key != "motors"}}

    if len(device.motors) == 1:
        from wavehaptics.ladder.run import run_scene

        ((name, loaded),) = device.motors.items()
        with shown_progress(f"{device.name} on {controller}") as progress:
            motor = name if named else None
            return {name: run_scene(loaded, controller, folder, progress, motor)}

    from wavehaptics.ladder.run import run_device

    with shown_stages() as stages:

        def show(name: str, part: float) -> None:
            stages(f"{device.name}, {name} on {controller}", part)

        for name in device.motors:  # what is simulated may have to be built first
            show(name, 0.0)
        motors: dict[str, dict[str, Any]] = run_device(device, controller, folder, show)["motors"]
        return motors


@app.command()
def speed(
    scene: SceneArgument = "paper_taps", overrides: SetOption = None, motor: SceneMotorOption = None
) -> None:
    """Run SCENE on every controller, and tell how fast and how exact each is."""
    loaded = scene_of_one(scene, overrides, motor)

    from rich.console import Console

    from wavehaptics.studies.speed import measure_speed, speed_table

    with shown_stages() as progress:
        results = measure_speed(loaded, progress)
    Console().print(speed_table(results))


@app.command()
def impedance(
    scene: SceneArgument,
    controller: Annotated[str, typer.Option(metavar="NAME", help="golden or core.")] = "golden",
    overrides: SetOption = None,
    motor: SceneMotorOption = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help=f"Folder; {RUNS_DIR}/<scene name>-impedance by default."),
    ] = None,
) -> None:
    """Sweep a hand over contact in SCENE: what it feels like against what was designed."""
    if controller not in ("golden", "core"):
        raise CommandError(f"--controller {controller}: has no sweep; take golden or core")
    loaded = scene_of_one(scene, overrides, motor)
    folder = _folder(f"{loaded.scene.name}-impedance", motor) if out is None else out
    make_folder(folder)

    from wavehaptics.studies.impedance import measure
    from wavehaptics.studies.impedance_picture import write

    with shown_progress(f"{loaded.scene.name}, impedance on {controller}") as progress:
        found = write(loaded, measure(loaded, rtl=controller == "core", progress=progress), folder)
    print(metrics_table({key: found[key] for key in ("scene", "error_max", "energy_out_max_j")}))
    print(f"results in {folder}")


@app.command()
def shaper(
    scene: SceneArgument, overrides: SetOption = None, motor: SceneMotorOption = None
) -> None:
    """Design W for what SCENE's \\[shaper] wishes, prove it passive and say what will be felt."""
    loaded = scene_of_one(scene, overrides, motor)
    if loaded.shaper is None:
        raise CommandError(
            f"{loaded.scene.name}: the scene wishes for nothing; give it a [shaper], or "
            "--set shaper.feel=spring --set shaper.stiffness=0.5"
        )

    from wavehaptics.controller.rendered import fragment
    from wavehaptics.controller.settings import settings

    print(fragment(loaded, settings(loaded), loaded.motor.felt_k_t, loaded.motor.L_h), end="")


@app.command()
def registers(
    scene: SceneArgument,
    form: Annotated[str, typer.Option("--format", metavar="NAME", help="c, verilog or json.")],
    overrides: SetOption = None,
    motor: SceneMotorOption = None,
    motors: Annotated[int, typer.Option(min=1, max=8, help="Equal motors of the device.")] = 1,
    trip: Annotated[
        float | None,
        typer.Option(metavar="A", help="Current that switches the gates off at once; none: never."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File to write; by default stdout.")
    ] = None,
) -> None:
    """Write the registers of wh_device for SCENE: a C header, a Verilog include, or JSON."""
    from wavehaptics.fpga.scene_registers import FORMATS, as_text, scene_registers

    if form not in FORMATS:
        raise CommandError(f"--format {form}: unknown; take one of {', '.join(FORMATS)}")
    loaded = scene_of_one(scene, overrides, motor)
    if trip is not None and not (math.isfinite(trip) and trip > 0):
        raise CommandError(f"--trip {trip:g}: must be a current in A above 0")
    made = scene_registers(loaded, motors, trip)
    text = as_text(made, form)
    if out is None:
        print(text, end="")
        return

    from wavehaptics.runtime.files import write_text

    try:
        write_text(out, text)
    except OSError as error:
        raise CommandError(
            f"--out {out}: can't be written: {error.strerror}; name a file that can"
        ) from None
    print(f"{out}: {len(made.registers)} registers of {made.scene}")


@app.command()
def check(
    scene: SceneArgument, controller: ControllerOption = "", overrides: SetOption = None
) -> None:
    """Check SCENE without running it: on a controller, or what of it each can't do."""
    path = find_scene(scene)
    if controller:
        checked, told = _checked(path, controller, overrides, None)
        print(f"{path}: ok on {controller}")
        for line in told + _beyond(checked, controller):
            print(line)
        return
    device = load_device(path, overrides or ())

    from wavehaptics.ladder.device_abilities import refuse_device
    from wavehaptics.ladder.refusals import check as check_on

    refused = {}
    for name in CONTROLLERS:
        try:
            refuse_device(device, name)
            for loaded in device.scenes:
                check_on(loaded, name, device.scenes)
        except SceneError as error:
            refused[name] = error
    if len(refused) == len(CONTROLLERS):
        raise refused[DEFAULT_CONTROLLER]
    print(f"{path}: ok")
    for name, problem in refused.items():
        print(f"not on `{name}`: {problem}")
    if DEFAULT_CONTROLLER not in refused:
        for line in _beyond(device, DEFAULT_CONTROLLER):
            print(line)


@app.command()
def scenes() -> None:
    """List the shipped scenes."""
    shipped = shipped_scenes()
    width = max(map(len, shipped), default=0)
    for name, path in shipped.items():
        print(f"{name:<{width}}  {first_comment(path)}")
