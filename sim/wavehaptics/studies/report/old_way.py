# SPDX-License-Identifier: Apache-2.0
"""The usual way beside the wave wall: how stiff may an encoder's servo and amplifier be?"""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm

from wavehaptics.laws import closed_forms
from wavehaptics.studies import stability
from wavehaptics.studies.report import figures
from wavehaptics.studies.report.blocks import Block, Picture, Table, Text, number
from wavehaptics.studies.report.runs import load
from wavehaptics.studies.sweeps import Task

TITLE = "The usual way beside it: encoder and current amplifier"

SCENE = "encoder_wall"
TIP = (8.0 / 0.14) ** 2
"""N/m at the Phantom's tip for 1 N·m/rad at its rotor."""
K_L = closed_forms.k_l(43.8e-3, 0.83e-3)
"""The Phantom's motor's, N·m/rad."""
PAPER_TIP = (7500.0, 1100.0)
"""The paper's stiffnesses at the Phantom's tip, N/m: wave wall in theory, encoder's wall."""

RATES_HZ = (500.0, 1e3, 2e3, 5e3, 1e4, 2e4, 5e4, 1e5, 1e6)
QUICK_RATES_HZ = (500.0, 1e3, 1e4, 1e5, 1e6)
COUNTS = (100, 400, 1000, 4000, 10_000, 40_000, 100_000)
QUICK_COUNTS = (100, 1000, 10_000, 100_000)
HAND_DAMPING = tuple(1.53e-6 * 10 ** (n / 2) for n in range(8))
QUICK_HAND_DAMPING = HAND_DAMPING[::2]
DELAYS_S = (0.0, 0.2e-3, 0.5e-3, 1e-3, 2e-3, 5e-3, 10e-3)
QUICK_DELAYS_S = (0.0, 1e-3, 10e-3)
DAMPERS = (0.0, *(2e-5 * 2 ** (n / 2) for n in range(9)))
QUICK_DAMPERS = (DAMPERS[0], *DAMPERS[3::2])
MOTORS = ("re25-phantom", "re25-118743")
COULOMB_NM = 5e-4
VISCOUS = 1e-5
FAST_AMPLIFIER_HZ = 1e4
WAVE_TICK_HZ = 1e6


def limit(
    controller: str, settings: list[str], at_rest: bool = False, halvings: int = 10
) -> dict[str, Any]:
    """Largest stiffness of the scene with ``settings``, and the encoder's known bounds, N·m/rad."""
    scene = load(SCENE, settings)
    holds = stability.at_rest if at_rest else stability.stable
    stiffness, capped = stability.largest_stiffness(scene, controller, holds, halvings)
    friction, servo = scene.friction, scene.servo
    assert scene.hand is not None
    assert servo is not None
    viscous = scene.hand.damping + (friction.viscous if friction else 0.0)
    cell = stability.cell_rad(scene)
    quantisation = 2 * friction.coulomb_nm / cell if friction and cell else None
    return {
        "stiffness": stiffness,
        "capped": capped,
        "bound_sampling": 2 * viscous * servo.rate_hz,
        "bound_quantisation": quantisation,
    }


def _task(curve: str, controller: str, *settings: str, **options: Any) -> tuple[str, Task]:
    return curve, Task(
        limit, {"controller": controller, "settings": list(settings), **options}
    )  # fmt: skip


def _rate(hz: float) -> tuple[str, str]:
    """The servo's rate, and a tick that is fast enough for it."""
    return f"servo.rate_hz={hz}", f"controller.tick_hz={max(1e5, hz)}"


def _grid(quick: bool) -> list[tuple[str, Task]]:
    rates = QUICK_RATES_HZ if quick else RATES_HZ
    slow = [hz for hz in rates if hz <= 1e5]
    counts = QUICK_COUNTS if quick else COUNTS
    found = []
    for hz in rates:
        few = {"halvings": 8} if hz > 1e5 else {}
        found.append(_task("rate", "encoder", *_rate(hz), **few))
        found.append(
            _task(
                "rate fast", "encoder", *_rate(hz), f"servo.amplifier_hz={FAST_AMPLIFIER_HZ}", **few
            )
        )
        found.append(_task("rate RE 25", "encoder", *_rate(hz), f"motor.preset={MOTORS[1]}", **few))
        wave = (f"controller.tick_hz={hz}", "controller.lambda=1e9")
        found.append(_task("wave rate", "golden", *wave, "controller.extra_ticks=1"))
        found.append(_task("wave rate 0", "golden", *wave, "controller.extra_ticks=0"))
    for hz, n in itertools.product(slow, counts):
        found.append(_task("map", "encoder", *_rate(hz), f"encoder.counts_per_rev={n}"))
    for n in counts:
        friction = f"friction.coulomb_nm={COULOMB_NM}"
        at = (f"encoder.counts_per_rev={n}", friction)
        found.append(_task("counts", "encoder", *_rate(1e3), *at))
        found.append(_task("counts rest", "encoder", *_rate(1e3), *at, at_rest=True))
    for b in QUICK_HAND_DAMPING if quick else HAND_DAMPING:
        at = (f"hand.damping={b}", f"friction.viscous={VISCOUS}")
        found.append(_task("hand", "encoder", *_rate(1e3), *at))
        found.append(_task("hand wave", "golden", *_wave(), *at))
    for delay in QUICK_DELAYS_S if quick else DELAYS_S:
        found.append(_task("delay", "encoder", *_rate(1e4), f"servo.delay_s={delay}"))
        found.append(
            _task("delay wave", "golden", "controller.tick_hz=1e5", "controller.lambda=1e9",
                  f"controller.extra_ticks={round(delay * 1e5)}")
        )  # fmt: skip
    for hz, b in itertools.product((1e3, 1e4), QUICK_DAMPERS if quick else DAMPERS):
        found.append(_task(f"z {hz:g}", "encoder", *_rate(hz), f"servo.damping={b}"))
    for motor in MOTORS:
        found.append(_task("wave", "golden", *_wave(), f"motor.preset={motor}"))
    return found


def _wave() -> tuple[str, ...]:
    return f"controller.tick_hz={WAVE_TICK_HZ}", "controller.lambda=1e9"


def tasks(quick: bool) -> list[Task]:
    return [task for _, task in _grid(quick)]


def _value(task: Task, key: str) -> Any:
    """What a task's settings give to a key."""
    found = [s.split("=")[1] for s in task.arguments["settings"] if s.startswith(f"{key}=")]
    return found[-1] if found else None


_AXES = {
    "rate": "servo.rate_hz", "rate fast": "servo.rate_hz", "rate RE 25": "servo.rate_hz",
    "wave rate": "controller.tick_hz", "wave rate 0": "controller.tick_hz",
    "counts": "encoder.counts_per_rev", "counts rest": "encoder.counts_per_rev",
    "hand": "hand.damping", "hand wave": "hand.damping", "delay": "servo.delay_s",
    "z 1000": "servo.damping", "z 10000": "servo.damping",
}  # fmt: skip


def gather(tasks: list[Task], results: list[Any]) -> dict[str, Any]:
    grids = (_grid(True), _grid(False))
    names = next(grid for grid in grids if [task for _, task in grid] == tasks)
    curves: dict[str, list[dict[str, Any]]] = {}
    for (curve, _), task, result in zip(names, tasks, results, strict=True):
        point = dict(result)
        if curve in _AXES:
            point["at"] = float(_value(task, _AXES[curve]))
        elif curve == "map":
            point["rate_hz"] = float(_value(task, "servo.rate_hz"))
            point["counts"] = int(_value(task, "encoder.counts_per_rev"))
        elif curve == "delay wave":
            point["at"] = int(_value(task, "controller.extra_ticks")) / 1e5
        else:
            point["motor"] = _value(task, "motor.preset")
        curves.setdefault(curve, []).append(point)
    return {"curves": curves, "ratios": _ratios(curves), "paper": list(PAPER_TIP)}


def _ratios(curves: dict[str, list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """The wave wall over the encoder's wall, at a 1 kHz servo and at equal rates."""

    def at(curve: str, x: float) -> float:
        found: float = next(p["stiffness"] for p in curves[curve] if math.isclose(p["at"], x))
        return found

    wave = {point["motor"]: point["stiffness"] for point in curves["wave"]}
    rows = []
    for motor, curve in zip(MOTORS, ("rate", "rate RE 25"), strict=True):
        rows.append(
            {"case": f"{motor}: wave at 1 MHz, servo at 1 kHz", "motor": motor,
             "wave": wave[motor], "encoder": at(curve, 1e3)}
        )  # fmt: skip
    for hz, name in ((1e3, "1 kHz"), (1e5, "100 kHz"), (1e6, "1 MHz")):
        for curve, which in (("wave rate 0", "k = 0"), ("wave rate", "k = 1")):
            rows.append(
                {"case": f"{MOTORS[0]}: both at {name}, wave with {which}", "motor": MOTORS[0],
                 "wave": at(curve, hz), "encoder": at("rate", hz)}
            )  # fmt: skip
    rows.append(
        {"case": f"{MOTORS[0]}: both at 1 MHz, amplifier of 10 kHz", "motor": MOTORS[0],
         "wave": at("wave rate", 1e6), "encoder": at("rate fast", 1e6)}
    )  # fmt: skip
    for row in rows:
        row["ratio"] = row["wave"] / row["encoder"]
    return rows


def _draw(curves: dict[str, Any], folder: Path) -> list[Path]:
    paths = []

    def xy(curve: str, key: str = "stiffness") -> tuple[list[float], list[float | None]]:
        return [p["at"] for p in curves[curve]], [p[key] for p in curves[curve]]

    figure, (left, right) = figures.panels(2)
    figures.curve(left, *xy("rate"), 0, "encoder, amplifier 2 kHz")
    figures.curve(left, *xy("rate RE 25"), 4, "same, RE 25 118743", ls=":")
    figures.curve(left, *xy("rate fast"), 1, "encoder, amplifier 10 kHz")
    figures.curve(left, *xy("wave rate"), 2, "wave wall, k = 1")
    figures.curve(left, *xy("rate", "bound_sampling"), 7, "2b/T", marker="", ls="--", lw=1)
    left.axhline(PAPER_TIP[1] / TIP, color=figures.GREY, lw=1, ls=":", label="1100 N/m at the tip")
    left.axhline(K_L, color=figures.GREEN, lw=1, ls=":", label="K_L")
    figures.label(left, "rate of servo or wave controller, Hz", "largest stable K, N·m/rad",
                  "over the rate")  # fmt: skip
    figures.curve(right, *xy("counts"), 0, "stable")
    figures.curve(right, *xy("counts rest"), 1, "comes to rest")
    figures.curve(right, *xy("counts", "bound_quantisation"), 7, "2f_c/Δ", marker="", ls="--", lw=1)
    figures.label(right, "encoder, counts a revolution", "largest stable K, N·m/rad",
                  f"over the counts: 1 kHz, friction {1e3 * COULOMB_NM:g} mN·m")  # fmt: skip
    for ax in (left, right):
        ax.set_xscale("log")
        ax.set_yscale("log")
        figures.legend(ax)
    paths.append(figures.save(figure, folder / "old_way_limits.png"))

    figure, (left, right) = figures.panels(2)
    damping, encoder = xy("hand")
    tip = [b * TIP for b in damping]
    figures.curve(left, tip, encoder, 0, "encoder, 1 kHz")
    figures.curve(left, tip, xy("hand wave")[1], 2, "wave wall, 1 MHz")
    bound = xy("hand", "bound_sampling")[1]
    figures.curve(left, tip, bound, 7, "2b/T", marker="", ls="--", lw=1)
    left.axhline(PAPER_TIP[1] / TIP, color=figures.GREY, lw=1, ls=":", label="1100 N/m at the tip")
    figures.label(left, "damping of the hand at the tip, N·s/m", "largest stable K, N·m/rad",
                  "over the hand")  # fmt: skip
    delay, encoder = xy("delay")
    figures.curve(right, [1e3 * d for d in delay], encoder, 0, "torque loop (encoder, 10 kHz)")
    delay, wave = xy("delay wave")
    figures.curve(right, [1e3 * d for d in delay], wave, 2, "wave loop (100 kHz)")
    figures.label(right, "delay in the loop, ms", "largest stable K, N·m/rad", "over the delay")
    for ax, scale in ((left, "log"), (right, "linear")):
        ax.set_xscale(scale)
        ax.set_yscale("log")
        figures.legend(ax)
    paths.append(figures.save(figure, folder / "old_way_hand.png"))

    figure, (left, right) = figures.panels(2)
    points = curves["map"]
    rates = sorted({p["rate_hz"] for p in points})
    counts = sorted({p["counts"] for p in points})
    grid = np.full((len(counts), len(rates)), np.nan)
    for p in points:
        if p["stiffness"] is not None:
            grid[counts.index(p["counts"]), rates.index(p["rate_hz"])] = p["stiffness"]
    image = left.imshow(grid, origin="lower", aspect="auto", norm=LogNorm(), cmap="viridis")
    for row, column in np.ndindex(grid.shape):
        value = grid[row, column]
        text = "–" if np.isnan(value) else f"{value:.2g}"
        dark = not np.isnan(value) and value < np.nanmax(grid) / 3
        left.text(column, row, text, ha="center", va="center", fontsize=8,
                  color="white" if dark else "black")  # fmt: skip
    left.set_xticks(range(len(rates)), [f"{hz / 1e3:g}k" for hz in rates])
    left.set_yticks(range(len(counts)), [f"{n:,}" for n in counts])
    left.grid(False)
    figures.label(left, "servo rate, Hz", "counts a revolution", "Largest stable K, N·m/rad")
    figure.colorbar(image, ax=left, shrink=0.85)
    for n, hz in enumerate((1000, 10_000)):
        b, k = xy(f"z {hz}")
        figures.curve(right, [1e3 * value for value in b], k, n, f"{hz / 1e3:g} kHz")
    none = [1e3 * value for value, limit_ in zip(b, k, strict=True) if limit_ is None]
    right.plot(none, [0.03] * len(none), "x", color=figures.BLACK, label="none is stable",
               transform=right.get_xaxis_transform())  # fmt: skip
    figures.label(right, "virtual damper B, mN·m·s/rad", "largest stable K, N·m/rad", "Z-width")
    right.set_yscale("log")
    right.yaxis.set_major_formatter("{x:g}")
    right.yaxis.set_minor_formatter("{x:g}")
    figures.legend(right)
    paths.append(figures.save(figure, folder / "old_way_maps.png"))
    return paths


def show(data: dict[str, Any], folder: Path) -> list[Block]:
    curves = data["curves"]
    limits, hand, maps = _draw(curves, folder)
    ratio = PAPER_TIP[0] / PAPER_TIP[1]
    first = data["ratios"][0]
    crossing = [
        p["at"] * TIP
        for p, w in zip(curves["hand"], curves["hand wave"], strict=True)
        if p["stiffness"] and w["stiffness"] / p["stiffness"] >= ratio
    ]
    return [
        Text(
            "The paper's Fig. 1 is how haptic walls are made today: a servo reads an encoder, "
            "computes the torque of a virtual spring, and a PI current amplifier makes it. The "
            "wall is called stable if pressing it (0.6 s) leaves no oscillation above two counts "
            "that does not die away, and if tapping it never throws the rotor more than 1.5 times "
            "as fast as an ideal spring of the same stiffness does. The largest stable stiffness "
            "is found by bisection. The hand is a light one (50 N/m and 0.5 N·s/m at the tip of "
            "the Phantom), which is what makes the difference, see below."
        ),
        Text(
            f"With a 1 kHz servo of {4000} counts the encoder's wall reaches "
            f"{first['encoder'] * TIP:.0f} N/m at the Phantom's tip, the wave wall "
            f"{first['wave'] * TIP:.0f} N/m (K_L alone: {K_L * TIP:.0f}): {first['ratio']:.1f} "
            f"times as much. The paper has {PAPER_TIP[0]:.0f} over {PAPER_TIP[1]:.0f} N/m, "
            f"{ratio:.1f} times."
        ),
        Table(
            "Wave wall over encoder's wall",
            ("case", "wave, N·m/rad", "encoder, N·m/rad", "ratio"),
            [
                (row["case"], number(row["wave"]), number(row["encoder"]), number(row["ratio"]))
                for row in data["ratios"]
            ],
        ),
        Picture(
            limits,
            "Left: the encoder's limit follows 2b/T of the damping in its loop until the "
            "amplifier's lag takes over; the wave wall nears K_L. Right: with Coulomb friction the "
            "rotor comes to rest up to 2f_c/Δ and beyond, until sampling sets the limit. “Stable” "
            "forgives a buzz of two counts, but also asks that a tap is not thrown back; “comes to "
            "rest” is asked of a press alone.",
        ),
        Text(
            "What holds an encoder's wall is damping, and most of it is the hand's: a firm grip "
            "carries even a 1 kHz servo to K_L, a finger that hardly holds on to a small part "
            "of it. The wave wall needs none, because it is passive by itself. "
            + (
                f"The ratio is {ratio:.1f} or more for hands of up to {max(crossing):.2g} N·s/m "
                "among those tried."
                if crossing
                else "The paper's ratio was not reached with any of the hands tried."
            )
            + " Delay divides the torque loop's stable stiffness and the wave loop's stiffness "
            "alike; but the wave loop does not swing at any of them, whatever the hand. (After "
            "some milliseconds it gives a tap back so late that the rotor is moved more than 1.5 "
            "times as fast as by the ideal spring, so that only a part of its stiffness passes "
            "that test.)"
        ),
        Text(
            "At equal rates the wave wall is not the stiffer one: with a damping hand, a fast "
            "amplifier and a servo of 10 kHz or more the encoder's wall goes beyond K_L, which is "
            "the most that a wave wall can have. What the wave wall has instead is its "
            "independence of the hand, of the encoder's counts and of delay."
        ),
        Picture(hand, "Largest stable stiffness over the hand's damping, and over delay."),
        Picture(
            maps,
            "Left: the encoder's largest stable stiffness over servo rate and counts. Right: the "
            "virtual damper helps, until the counts' noise in the velocity leaves no wall stable.",
        ),
    ]
