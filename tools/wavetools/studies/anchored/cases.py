# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a motor, one thing at a time and all at once, and what it is asked to do."""

from __future__ import annotations

import itertools
import math
from typing import Any

from wavehaptics.parts.motors import PRESETS
from wavehaptics.studies.sweeps import Task

from wavetools.studies.anchored import runs
from wavetools.studies.anchored.runs import PLAIN

MOTOR = PRESETS["re25-118743"]
LAG_S = 0.3e-6
LAG = f"adc.bandwidth_hz={1.0 / (2 * math.pi * LAG_S):.6g}"
BRUSHES = ("brushes.drop_v=0.5", "brushes.knee_a=5e-3")

NOTHING = (f"controller.r_hat={MOTOR.R_ohm}", "drive.gain_error=0", "adc.offset_a=0")
"""``held_wall`` with nothing wrong."""


def _hat(key: str, value: float, part: float) -> str:
    return f"controller.{key}={value * (1.0 + part):.9g}"


def _supply(part: float) -> tuple[str, ...]:
    return ("drive.bus_v=24", f"drive.step_v={24 * part:g}", "drive.step_s=0.5")


SLIDING = ("brushes.contact_noise=0.03",)
"""Noise of the sliding contact, over the angle: none at rest."""


def _flicker(noise_s: float) -> tuple[str, ...]:
    """Noise of a loose contact over time, at rest as well."""
    return ("brushes.flicker_noise=0.03", f"brushes.flicker_s={noise_s:g}")


ALONE: dict[str, tuple[str, ...]] = {
    "nothing": (),
    "brush 0.5 V, knee 5 mA": BRUSHES,
    "brush 0.5 V, knee 50 mA": ("brushes.drop_v=0.5", "brushes.knee_a=50e-3"),
    "R(θ) +4 %, 22 bars": ("brushes.segments=22", "brushes.ripple=0.04"),
    "R(θ) −4 %, 22 bars": ("brushes.segments=22", "brushes.ripple=-0.04"),
    "contact noise 3 %, over the angle": SLIDING,
    "contact noise 3 %, flicker of 10 µs": _flicker(1e-5),
    "contact noise 3 %, flicker of 0.1 ms": _flicker(1e-4),
    "contact noise 3 %, flicker of 1 ms": _flicker(1e-3),
    "supply steps by +5 %": _supply(0.05),
    "supply steps by −5 %": _supply(-0.05),
    "lag 0.3 µs": (LAG,),
    "L̂ +10 %": (_hat("l_hat", MOTOR.L_h, 0.1),),
    "L̂ −10 %": (_hat("l_hat", MOTOR.L_h, -0.1),),
    "k̂_T +10 %": (_hat("k_t_hat", MOTOR.k_t, 0.1),),
    "k̂_T −10 %": (_hat("k_t_hat", MOTOR.k_t, -0.1),),
    "R̂ +10 %": (_hat("r_hat", MOTOR.R_ohm, 0.1),),
    "R̂ −10 %": (_hat("r_hat", MOTOR.R_ohm, -0.1),),
    "gain +5 %": ("drive.gain_error=0.05",),
    "gain −5 %": ("drive.gain_error=-0.05",),
    "offset +4 mA": ("adc.offset_a=4e-3",),
    "offset −4 mA": ("adc.offset_a=-4e-3",),
}
"""Settings by what is wrong, over NOTHING."""

SIGNS = ((1, 1, 1, 1), (-1, -1, -1, -1), (1, -1, 1, -1), (-1, 1, -1, 1), (1, 1, -1, -1),
         (-1, -1, 1, 1))  # fmt: skip
"""Signs of all at once: of R̂ and gain, of L̂, of k̂_T and of offset, ripple and supply."""


def all_wrong(signs: tuple[int, ...], preset: str = "re25-118743") -> tuple[str, ...]:
    """Settings of everything at once but contact noise."""
    motor = PRESETS[preset]
    resistance, inductance, torque, rest = signs
    return (
        *BRUSHES, "brushes.segments=22", f"brushes.ripple={0.04 * rest:g}",
        *_supply(0.05 * rest), LAG,
        _hat("r_hat", motor.R_ohm, 0.1 * resistance), f"drive.gain_error={0.05 * resistance:g}",
        _hat("l_hat", motor.L_h, 0.1 * inductance), _hat("k_t_hat", motor.k_t, 0.1 * torque),
        f"adc.offset_a={4e-3 * rest:g}",
    )  # fmt: skip


def sign_text(signs: tuple[int, ...]) -> str:
    """``signs`` as the tables have them."""
    return "".join("+" if sign > 0 else "−" for sign in signs)


EVERYTHING = {f"everything, {sign_text(signs)}": all_wrong(signs) for signs in SIGNS}
NOISY = {
    f"{name}, contact noise 3 %, {kind}": (*settings, *noise)
    for name, settings in itertools.islice(EVERYTHING.items(), 2)
    for kind, noise in (("over the angle", SLIDING), ("flicker of 1 ms", _flicker(1e-3)))
}

SHORT_S, LONG_S, QUICK_S = 3.0, 30.0, 5.0
LONG = ("nothing", "everything, ++++", "everything, −−−−")
"""What is held for LONG_S."""

# ---- The bar of a commutator whose edge lies where the rotor rests.

STEP_PLACES = (-0.4, -0.2, 0.0, 0.2, 0.4)
STEP_PARTS = (-0.04, -0.08, 0.04)
HANDS = {"hand": 0.5e-3, "light hand": 0.1e-3}


def bar_settings(part: float, place: float, damping: float) -> list[str]:
    """A hold where R changes by ``part`` in a step, ``place`` cells from where the rotor rests."""
    settings = [*NOTHING, f"hand.damping={damping}", "scene.duration_s=1"]
    rest = runs.hold("held_wall", "golden", settings)
    at = (rest["depth_cells"] + place) * rest["cell_rad"]
    return [*settings, "brushes.segments=22", f"brushes.step={part}", f"brushes.step_at_rad={at}"]


def bar(part: float, place: float, damping: float) -> dict[str, Any]:
    """The hold of :func:`bar_settings`."""
    found = runs.hold("held_wall", "golden", bar_settings(part, place, damping))
    return {"part": part, "place": place, "damping": damping} | found


# ---- Taps, soft walls, layers, detents.

SOFT = ("controller.lambda=1e6", "controller.extra_ticks=2")
FEELS: dict[str, tuple[str, tuple[str, ...], float]] = {
    "taps, 2 Hz": ("held_wall", ("hand.path=taps", "hand.frequency_hz=2",
        "hand.amplitude_rad=0.05", "hand.stiffness=0.5", "hand.damping=2e-3",
        "scene.duration_s=2"), 0.01),
    "soft wall, 0.45 N·m/rad": ("held_wall", (*SOFT, "shaper.feel=spring",
        "shaper.stiffness=0.45", "shaper.damping=0.05e-3", "hand.path=taps",
        "hand.frequency_hz=1", "hand.amplitude_rad=0.15", "scene.duration_s=2"), 0.02),
    "layer over a wall": ("held_wall", (*SOFT, "shaper.feel=layer", "shaper.stiffness=0.5",
        "shaper.damping=0.05e-3", "shaper.walls=[0]",
        "controller.walls=[[0.0, 0.02], [0.02, 1.0]]", "hand.path=taps", "hand.frequency_hz=1",
        "hand.amplitude_rad=0.25", "scene.duration_s=2"), 0.02),
    "detents": ("held_wall", ("encoder.counts_per_rev=36000", "controller.eta_free=0.95",
        "controller.walls=[[-0.1329, -0.1289], [-0.0457, -0.0417], [0.0416, 0.0456],"
        " [0.1289, 0.1329]]", "hand.path=sine", "hand.frequency_hz=1",
        "hand.amplitude_rad=0.2", "hand.stiffness=0.5", "hand.damping=2e-3",
        "scene.duration_s=1"), 0.02),
}  # fmt: skip
"""Scene, settings and the part of the depth that its target allows."""

FELT = {
    "nothing wrong": (),
    "everything, ++++": all_wrong((1, 1, 1, 1)),
    "everything, −−−−": all_wrong((-1, -1, -1, -1)),
    "everything, +−+−": all_wrong((1, -1, 1, -1)),
}


def feel(name: str, wrong: str) -> dict[str, Any]:
    """What the hand of FEELS does, under FELT."""
    scene, settings, part = FEELS[name]
    found = runs.swing(scene, [*NOTHING, *settings, *FELT[wrong]])
    return {"name": name, "wrong": wrong, "part": part} | found


# ---- Bounces.


def loaded(load: float, preset: str = "re25-118743") -> list[str]:
    """Settings of ``load`` times the rotor's inertia on the shaft, its own included."""
    return [f"load.inertia_kgm2={(load - 1.0) * PRESETS[preset].J_kgm2:.9g}"] if load > 1 else []


SPEEDS = (0.3, 1.0, 3.0, 10.0, 30.0)
BOUNCED = {"nothing": None} | {sign_text(signs): signs for signs in SIGNS[:4]}


def bounce_settings(
    preset: str, speed: float, signs: tuple[int, ...] | None, load: float = 1.0
) -> list[str]:
    """Settings of a bounce at a speed in rad/s; 12 bits for twice the hit's current.

    On the shaft is ``load`` times the rotor's own inertia, its own included.
    """
    motor = PRESETS[preset]
    inertia = motor.J_kgm2 * load
    way = min(0.05, 0.01 * speed)
    peak_a = speed * math.sqrt(inertia / motor.L_h)
    contact_s = math.pi * math.sqrt(inertia * motor.L_h) / motor.k_t
    limit_v = min(127.0, max(12.0, 2.0 * motor.R_ohm * peak_a))
    settings = [
        f"motor.preset={preset}", f"hand.speed_rad_s={speed}", f"hand.amplitude_rad={way}",
        f"scene.duration_s={1.5 * way / speed + 3 * contact_s}", "adc.bits=12",
        f"adc.full_scale_a={max(2.5, 2 * peak_a):.6g}", "adc.noise_a=1e-3",
        f"drive.bus_v={limit_v}", f"drive.limit_v={limit_v}",
        f"controller.r_hat={motor.R_ohm}",
    ]  # fmt: skip
    settings += loaded(load, preset)
    if signs is not None:
        settings += [s for s in all_wrong(signs, preset) if not s.startswith(
            ("drive.bus_v", "drive.step"))]  # fmt: skip
    return settings


def bounces(preset: str, wrong: str, load: float = 1.0) -> list[dict[str, Any]]:
    """Bounces of a preset's rotor at SPEEDS, as in :func:`bounce_settings`."""
    return [
        {"speed": speed}
        | runs.bounce("bounce", bounce_settings(preset, speed, BOUNCED[wrong], load))
        for speed in SPEEDS
    ]


# ---- Free space.

SWEPT = ("hand.path=free", "hand.amplitude_rad=0.225", "hand.frequency_hz=2", "scene.duration_s=1",
         "hand.stiffness=0.1", "controller.lambda=1e4", "drive.limit_v=2.1")  # fmt: skip
LOOSE = ("hand.amplitude_rad=900", "hand.speed_rad_s=1e-6", "scene.duration_s=1",
         f"controller.r_hat={MOTOR.R_ohm}", "adc.bits=12", "adc.full_scale_a=2.5",
         "adc.noise_a=1e-3")  # fmt: skip
FREE: dict[str, tuple[str, tuple[str, ...]]] = {
    "hand, nothing wrong": ("held_wall", (*NOTHING, *SWEPT)),
    "hand, nothing wrong, no anchor": ("held_wall", (*NOTHING, *SWEPT, PLAIN)),
    "hand, k̂_T +10 %": ("held_wall", (*NOTHING, *SWEPT, *ALONE["k̂_T +10 %"])),
    "hand, k̂_T −10 %": ("held_wall", (*NOTHING, *SWEPT, *ALONE["k̂_T −10 %"])),
    "hand, k̂_T +10 %, 13 rad/s": ("held_wall", (*NOTHING, *SWEPT, *ALONE["k̂_T +10 %"],
        "hand.frequency_hz=9", "drive.limit_v=12")),
    "hand, everything, ++++": ("held_wall", (*NOTHING, *SWEPT, *all_wrong((1, 1, 1, 1)))),
    "free rotor, 5 mA": ("bounce", (*LOOSE, "adc.offset_a=5e-3")),
    "free rotor, −5 mA": ("bounce", (*LOOSE, "adc.offset_a=-5e-3")),
    "free rotor, 5 mA, no anchor": ("bounce", (*LOOSE, "adc.offset_a=5e-3", PLAIN)),
    "free rotor, 5 mA, friction 0.2 mN·m": ("bounce", (*LOOSE, "adc.offset_a=5e-3",
        "friction.coulomb_nm=0.2e-3")),
    "free rotor, 5 mA, R̂ +10 %, k̂_T −10 %": ("bounce", (*LOOSE, "adc.offset_a=5e-3",
        *ALONE["R̂ +10 %"], *ALONE["k̂_T −10 %"])),
    "free rotor, 5 mA, brush 0.5 V": ("bounce", (*LOOSE, "adc.offset_a=5e-3", *BRUSHES)),
}  # fmt: skip
"""Scene and settings by name."""


def free(name: str) -> dict[str, Any]:
    """A run of FREE."""
    scene, settings = FREE[name]
    return {"name": name} | runs.free(scene, list(settings))


# ---- The voltage limit.

PRESSED = {
    "2.1 V": ("drive.limit_v=2.1", "hand.amplitude_rad=0.5", "hand.frequency_hz=0.5"),
    "12 V": ("drive.limit_v=12", "hand.amplitude_rad=2", "hand.frequency_hz=0.25",
             "adc.full_scale_a=10"),
}  # fmt: skip
FIRMNESS = {
    "rigid": (),
    "soft": (*SOFT, "shaper.feel=spring", "shaper.stiffness=0.45", "shaper.damping=0.05e-3",
             "controller.walls=[[0.0, 10.0]]"),
}  # fmt: skip
LIMITED_WRONG = ("nothing wrong", "everything, ++++", "everything, −−−−")


def overload(limit: str, firmness: str, wrong: str) -> dict[str, Any]:
    """Press beyond what the limit lets the wall push, and let go."""
    settings = [*NOTHING, "hand.path=taps", *FIRMNESS[firmness]]
    settings += [s for s in FELT[wrong] if not s.startswith(("drive.bus_v", "drive.step"))]
    period = 2.0 if limit == "2.1 V" else 4.0
    settings += [*PRESSED[limit], f"scene.duration_s={period}"]
    return {"limit": limit, "firmness": firmness, "wrong": wrong} | runs.overload(settings)


LIMITS: dict[str, tuple[str, ...]] = {
    "12 V": (),
    "12 V, 1.3 A": ("drive.current_limit_a=1.3",),
    "3 V": ("drive.limit_v=3",),
}
HIT_LOADS = (1.0, 10.0, 50.0)
HIT_SPEEDS = (5.0, 10.0, 20.0, 40.0, 80.0)


def limited_hit(limit: str, load: float, wrong: str) -> dict[str, Any]:
    """Hits at the boards' λ, the fast ones with more force than the limit lets the wall make."""
    points = []
    for speed in HIT_SPEEDS:
        # Long enough for a wall that pushes with 20 mN·m.
        duration_s = 0.1 + 3.0 * load * MOTOR.J_kgm2 * speed / 20e-3
        settings = [
            *bounce_settings("re25-118743", speed, BOUNCED[wrong], load), "controller.lambda=1e4",
            f"scene.duration_s={duration_s:.6g}", "adc.full_scale_a=10", "drive.bus_v=12",
            "drive.limit_v=12", *LIMITS[limit], "controller.walls=[[0.0, 100.0]]",
        ]  # fmt: skip
        points.append(runs.bounce("bounce", settings))
    return {
        "limit": limit,
        "load": load,
        "wrong": wrong,
        "restitution": [point["restitution"] for point in points],
        "fault": [point["anchor_fault_s"] is not None for point in points],
    }


# ---- All of them.


def tasks(quick: bool = False) -> dict[str, list[Task]]:
    """Tasks by the name of their group; ``quick`` holds for seconds, not for a minute."""
    long_s, short_s = (QUICK_S, 1.0) if quick else (LONG_S, SHORT_S)

    def held(name: str, settings: tuple[str, ...], controller: str, duration_s: float) -> Task:
        all_settings = [*NOTHING, *settings, f"scene.duration_s={duration_s:g}"]
        return Task(named_hold, {"name": name, "controller": controller, "settings": all_settings})

    many = ALONE | EVERYTHING | NOISY
    return {
        "holds": [
            held(name, many[name], controller, long_s)
            for controller in ("core", "golden")
            for name in LONG
        ]
        + [held(name, settings, "golden", short_s) for name, settings in many.items()],
        "plain": [held(name, (*settings, PLAIN), "golden", 1.0) for name, settings in many.items()],
        "bars": [
            Task(bar, {"part": part, "place": place, "damping": damping})
            for damping in HANDS.values()
            for part in STEP_PARTS
            for place in STEP_PLACES
        ],
        "feels": [Task(feel, {"name": name, "wrong": wrong}) for name in FEELS for wrong in FELT],
        "bounces": [
            Task(bounces, {"preset": preset, "wrong": wrong})
            for preset in PRESETS
            for wrong in BOUNCED
        ],
        "free": [Task(free, {"name": name}) for name in FREE],
        "overloads": [
            Task(overload, {"limit": limit, "firmness": firmness, "wrong": wrong})
            for limit in PRESSED
            for firmness in FIRMNESS
            for wrong in LIMITED_WRONG
        ],
        "hits": [
            Task(limited_hit, {"limit": limit, "load": load, "wrong": wrong})
            for limit in LIMITS
            for load in HIT_LOADS
            for wrong in BOUNCED
        ],
    }


def named_hold(name: str, controller: str, settings: list[str]) -> dict[str, Any]:
    """A hold of ``held_wall`` under a name."""
    return {"name": name} | runs.hold("held_wall", controller, settings)
