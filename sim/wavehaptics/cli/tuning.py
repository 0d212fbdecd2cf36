# SPDX-License-Identifier: Apache-2.0
"""``new-scene`` and ``tune``: from a motor's data sheet to what it can render."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Annotated, Any

import typer

from wavehaptics.cli.shared import (
    CommandError,
    SceneArgument,
    SceneMotorOption,
    SetOption,
    shown_stages,
)
from wavehaptics.scene import device_of, find_scene, read_scene

app = typer.Typer()

NEW_SCENE = """\
# {name}: made by `wavehaptics new-scene`. sim/scenes/README.md lists every key.

[scene]
name = {quoted}
duration_s = 0.6
trace_hz = 20e3

[motor] # of the data sheet
R_ohm = {r_ohm!r}
L_h = {l_h!r}
k_t = {k_t!r}
J_kgm2 = {j_kgm2!r}

[hand] # a finger that presses with the torque of half the ADC's range
path = "press"
amplitude_rad = {amplitude_rad!r}
stiffness = 0.1
damping = 0.5e-3

[encoder]
counts_per_rev = {counts}

[adc]
bits = {bits}
full_scale_a = {full_scale_a!r}

[drive]
bus_v = {bus_v!r}

[controller]
tick_hz = 800e3
lambda = 1e4
walls = [[0.0, 100.0]]
anchor_auto = true # holds the wall although R, sensor and drive are never as written
"""

HAND_STIFFNESS = 0.1


@app.command("new-scene")
def new_scene(
    path: Annotated[Path, typer.Argument(metavar="FILE", help="The scene to write, .toml.")],
    r_ohm: Annotated[float, typer.Option(metavar="OHM", help="Resistance between terminals, Ω.")],
    l_h: Annotated[float, typer.Option(metavar="H", help="Inductance between terminals, H.")],
    k_t: Annotated[float, typer.Option(metavar="NM/A", help="Torque constant, N·m/A.")],
    j_kgm2: Annotated[float, typer.Option(metavar="KGM2", help="Rotor inertia, kg·m².")],
    bus_v: Annotated[float, typer.Option(metavar="V", help="Bus of the bridge, V.")] = 12.0,
    full_scale_a: Annotated[
        float | None, typer.Option(metavar="A", help="± range of the ADC; by default V/R, A.")
    ] = None,
    bits: Annotated[int, typer.Option(metavar="N", help="Bits of the ADC.")] = 12,
    counts: Annotated[int, typer.Option(metavar="N", help="Encoder counts a turn.")] = 4000,
) -> None:
    """Write a scene of a motor with brushes from its data sheet, for `tune` and `run`."""
    if path.exists():
        raise CommandError(f"{path}: is there already; name another file")
    if not (r_ohm > 0 and bus_v > 0):
        raise CommandError(f"--r-ohm {r_ohm:g}, --bus-v {bus_v:g}: must be above 0")
    current = bus_v / r_ohm if full_scale_a is None else full_scale_a
    text = NEW_SCENE.format(
        name=path.stem, quoted=json.dumps(path.stem, ensure_ascii=False), r_ohm=r_ohm, l_h=l_h,
        k_t=k_t, j_kgm2=j_kgm2, bus_v=bus_v, bits=bits, counts=counts,
        full_scale_a=float(f"{current:.4g}"),
        amplitude_rad=float(f"{0.5 * k_t * current / HAND_STIFFNESS:.4g}"),
    )  # fmt: skip
    device_of(text.encode("utf-8"), path)

    from wavehaptics.runtime.files import write_text

    try:
        write_text(path, text)
    except OSError as error:
        raise CommandError(
            f"{path}: can't be written: {error.strerror}; name a file that can"
        ) from None
    print(f"{path}: written; wavehaptics tune {shlex.quote(str(path))} says what it can render")


@app.command()
def tune(
    scene: SceneArgument,
    overrides: SetOption = None,
    motor: SceneMotorOption = None,
    sensor: Annotated[
        str | None,
        typer.Option(
            metavar="PART", help="What senses the current: a part of boards/sensing.toml."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="JSON in place of the page.")] = False,
) -> None:
    """Say what SCENE's motor, encoder, ADC and bridge can render, and which limit is first."""
    path = find_scene(scene)
    content = read_scene(path)
    device_of(content, path, overrides or ())

    from wavehaptics.studies.tune import tune as tuned

    with shown_stages() as progress:
        found = tuned(path, content, overrides or (), motor, sensor, progress)
    if as_json:
        print(json.dumps(found, indent=2, ensure_ascii=False))
        return
    print(page(found, scene, sensor, motor))


def page(found: dict[str, Any], scene: str, sensor: str | None, motor: str | None) -> str:
    """What was found, in text for a terminal."""
    own, best, wall, hold = found["motor"], found["best"], found["wall"], found["hold"]
    encoder, forces = found["encoder"], found["forces"]
    lines = [
        f"{found['scene']}: what it can render",
        "",
        f"stiffest wall       {wall['stiffness_predicted']:.4g} N·m/rad, "
        f"{100 * wall['of_k_l']:.3g} % of K_L = {own['k_l']:.4g}; limited by {wall['limit']}",
        f"  simulated         {_or(wall['stiffness'], '.4g', ' N·m/rad')}",
        f"λ                   {best['lambda']:.6g} rad/s, a = {best['a']:.3g}",
        f"carrier             {1e-3 * best['carrier_hz']:.4g} kHz; control rate "
        f"{1e-3 * best['tick_hz']:.4g} kHz, clock {1e-6 * best['clock_hz']:.4g} MHz, "
        f"latency k = {best['extra_ticks']}",
        "",
        "torque              ends at the first of",
        *(
            f"  {limit['torque']:>9.4g} N·m   {limit['current_a']:>8.4g} A   {limit['name']}"
            for limit in forces
        ),
        "",
        f"encoder             {_or(encoder['counts_per_rev'], 'd', ' counts a turn')}; "
        f"{encoder['counts_needed']} are needed, so that the largest torque is 4 counts deep",
        f"  one count         {_or(encoder['count_torque'], '.3g', ' N·m of the wall')}",
        "",
        f"hold at {hold['pressed_with']:.3g} N·m "
        + ("(with the port anchor)" if own["anchored"] else "(without a port anchor)"),
        f"  moved by          {_or(hold['offset_rad'], '.3g', ' rad')}, "
        f"{_or(hold['offset_counts'], '.3g', ' counts')}",
        f"  ripple            {_or(hold['ripple_rms'], '.3g', ' N·m RMS')}",
        *([f"  {hold['reason']}"] if hold["reason"] else []),
        "",
        "carriers            stiffest wall, N·m/rad",
        *(
            f"  {1e-3 * row['carrier_hz']:>9.4g} kHz   "
            + (f"{row['stiffness']:.4g}" if row["refusal"] is None else f"no: {row['refusal']}")
            for row in found["carriers"]
        ),
    ]
    if sensor is None:
        lines.append("  what senses the current may follow less: --sensor PART, or adc.edge_hold_s")
    words = [word for text in best["settings"] for word in ("--set", text)]
    words += ["--motor", motor] if motor else []
    return "\n".join([*lines, "", f"run it: wavehaptics run {shlex.join([scene, *words])}"])


def _or(value: Any, form: str, unit: str) -> str:
    return "none" if value is None else f"{value:{form}}{unit}"
