# SPDX-License-Identifier: Apache-2.0
"""What of a scene with a ``[device]`` a controller does, leaves out or refuses.

Besides what it does of each motor (:mod:`wavehaptics.ladder.abilities`).
"""

from __future__ import annotations

import numpy as np

from wavehaptics.ladder.abilities import asked
from wavehaptics.ladder.joint import JointSimulation
from wavehaptics.ladder.joint_pins import host_of_pins
from wavehaptics.scene import Device

DEVICE_CONTROLLERS = ("analog", "golden", "pins", "encoder")
"""Controllers that move the motors of a device together."""

MOTOR_REFUSES = {
    "hand": "the hand holds the tip; write [hand] with path and amplitude_m",
    "shaper": "a surface has a stiffness of its own; leave it out",
    "thermal": "it is not had with a [device] yet; leave it out",
    "transmission": "the gear is the device's; write device.ratio",
}
"""Tables of a motor that a device does without, with the cure."""

LEFT_OUT: dict[str, tuple[str, ...]] = {
    "analog": ("device.wall_energy_j",),
    "golden": (),
    "pins": (),
    "encoder": (
        "device.update_hz", "device.delay_s", "device.jitter_s", "device.wall_speed_m_per_s",
        "device.wall_energy_j", "surface.friction_loss",
    ),
}  # fmt: skip
"""Keys of a device without effect: the circuit counts no energy, and a servo needs no planes."""

SERVO_REFUSES = {
    "controller.walls": "its servo knows surfaces alone; leave it out",
    "servo.stiffness": "a surface has its own; write surface.stiffness, in N/m",
    "servo.damping": "a surface has its own; write surface.damping, in N·s/m",
    "encoder.kind": "its servo reads A and B; leave it out",
}
"""Keys that a device does without on `encoder`, with the cure."""

ROOM = 1.001
"""A wished stiffness may exceed the largest by this factor, for what words round."""


PLANES_ONLY = (
    "device.update_hz", "device.delay_s", "device.jitter_s", "device.wall_speed_m_per_s",
    "device.wall_energy_j",
)  # fmt: skip
"""Keys that a virtual shaft does without: no host sends planes."""


def refuse_device(device: Device, controller: str) -> None:
    """:class:`SceneError` where ``controller`` can't do what the device's tables ask for."""
    space = device.space
    if space is None:
        return
    if controller not in DEVICE_CONTROLLERS:
        raise space.refusal(
            f"[device] is not for `{controller}`, whose RTL is the wave core of one motor; take "
            "`pins`, `analog`, `golden` or `encoder`",
            "device",
        )
    if space.coupling is not None and controller != "golden":
        raise space.refusal(
            f"[coupling] is not for `{controller}`; take `golden`, or two opposite planes as "
            "[[surface]], which couple without a delay",
            "coupling",
        )
    if controller == "pins" and space.surface and len(device.scenes) == 1:
        raise space.refusal(
            "[[surface]] of a single motor is not for `pins`, whose surfaces lie across two or "
            "three; write controller.walls, or take `golden`",
            "surface", "device",
        )  # fmt: skip
    for scene in device.scenes:
        if scene.motor.brushless:
            raise scene.refusal(
                'motor.kind = "pmsm" is not had with a [device] yet; take a motor with brushes',
                "motor.kind", "motor.preset",
            )  # fmt: skip
        for table in sorted(set(MOTOR_REFUSES) & asked(scene)):
            raise scene.refusal(
                f"[{table}] of a motor is not for a [device]: {MOTOR_REFUSES[table]}", table
            )
        for key, why in SERVO_REFUSES.items():
            if controller == "encoder" and key in asked(scene):
                raise scene.refusal(f"{key} is not for `encoder` with a [device]: {why}", key)
        if controller == "encoder" and scene.servo != device.scenes[0].servo:
            raise scene.refusal(
                "[servo] is the same for all motors of a [device]; move it out of [[motors]]",
                "servo",
            )
    simulation = (
        host_of_pins(device) if controller == "pins" else JointSimulation(device, controller)
    )
    if space.coupling is not None:
        alike = {
            (scene.controller.k_t_hat, set_.root, set_.cell_rad)
            for scene, set_ in zip(device.scenes, simulation.settings, strict=True)
        }
        if len(alike) > 1:
            raise space.refusal(
                "[coupling] needs one k_t_hat, r_hat and counts_per_rev for both motors, else a "
                "turn of one isn't that of the other; move them out of [[motors]]",
                "coupling",
            )
    start = np.zeros(len(device.scenes))
    for solid in simulation.host.look(start).singular:
        missing = space.number(solid)
        raise space.refusal(
            f"surface[{missing}] can't be felt where the run begins: no motor moves the tip along "
            "its normal; take another device.home_rad or another normal",
            ("surface", missing), "device.home_rad", "device.jacobian",
        )  # fmt: skip
    if controller == "encoder":
        return
    for solid, one in enumerate(space.solids):
        n, stiffest = space.number(solid), simulation.host.stiffest(solid, start)
        if one.stiffness is not None and one.stiffness > ROOM * stiffest:
            raise space.refusal(
                f"surface[{n}].stiffness = {one.stiffness:g} N/m is more than the {stiffest:.4g} "
                "that the motors make there; take that or less, or leave it out",
                ("surface", n, "stiffness"),
            )
        if one.stiffness is None or not one.damping:
            continue
        softer = 1.0 / one.stiffness - 1.0 / stiffest
        least = simulation.host.delay_s / max(softer, 1e-9)
        if one.damping < least:
            raise space.refusal(
                f"surface[{n}].damping = {one.damping:g} N·s/m is less than the {least:.2g} that "
                f"the controller's delay leaves beside {one.stiffness:g} N/m; take a smaller "
                "stiffness, or leave damping out",
                ("surface", n, "damping"),
            )


def left_out_of_device(device: Device, controller: str) -> list[str]:
    """What the device's tables ask for and ``controller`` leaves out, in alphabetical order."""
    if device.space is None:
        return []
    given = {f"device.{key}" for key in device.space.device.model_fields_set}
    given |= {f"surface.{key}" for one in device.space.surface for key in one.model_fields_set}
    unused = set(LEFT_OUT[controller])
    if device.space.coupling is not None:
        unused |= set(PLANES_ONLY)
    return sorted(given & unused)
