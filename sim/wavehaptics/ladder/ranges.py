# SPDX-License-Identifier: Apache-2.0
"""What a scene may ask of the controller beyond the range of a word or of the ADC, without a run.

A run goes on all the same: what a range cuts off is never a source. But it is another wall, or a
lower voltage, than the scene says. The expected values are those of a static contact with the hand,
or of the impact of a free rotor, and of the hand's fastest movement: a run may exceed them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from wavehaptics.controller import anchor
from wavehaptics.controller.normalised import state_gain
from wavehaptics.controller.ports import controller_ports
from wavehaptics.controller.settings import Settings, settings
from wavehaptics.ladder.abilities import WITHOUT_WORDS
from wavehaptics.ladder.design_spring import rendered_stiffness
from wavehaptics.laws.anchor_choice import SLOW_RAD_S
from wavehaptics.laws.closed_forms import root
from wavehaptics.motor.hand import PRESS_RAMP_S
from wavehaptics.motor.sensor import Sensor
from wavehaptics.motor.supply import reached_v
from wavehaptics.scene import Scene
from wavehaptics.words import formats

CURRENT = "the current"
LARGER_UNITS = "or count in larger units (docs/sensing.md, Beyond the ranges)"


@dataclass(frozen=True)
class Exceeded:
    """A quantity that may leave its range: what it may reach, and what happens then."""

    quantity: str
    reaches: float
    limit: float
    unit: str
    where: str
    """What ends there."""
    remedy: str

    def __str__(self) -> str:
        return (
            f"{self.quantity} may reach {self.reaches:.3g} {self.unit}, beyond "
            f"±{self.limit:.3g} {self.unit}, {self.where}; {self.remedy}"
        )


def exceeded(scene: Scene, controller: str) -> list[Exceeded]:
    """What the scene may ask of ``controller`` beyond a range, in no particular order.

    :class:`SceneError` where it can't run there.
    """
    if controller in WITHOUT_WORDS:
        return []
    sensor = Sensor.of_scene(scene)
    if controller == "pins":
        ports = controller_ports(scene)
        set_, sensor = ports.settings, ports.sensor
    else:
        set_ = settings(scene)
    push = _push(scene, set_)
    found = [_current(scene, sensor, push), _voltage(scene, set_, push), _wave(scene, set_, push)]
    if set_.anchored:
        found += [_moves(scene, set_), _flux(scene, set_, sensor, push), *_gains(set_)]
    found += _filter_states(scene, set_, push)
    return [one for one in found if one is not None]


# ---- What the hand asks for.


@dataclass(frozen=True)
class _Push:
    """The largest of a contact: torque in N·m, how far the hand is in, rad; K's and the hand's
    compliance together, rad/(N·m).
    """

    torque: float = 0.0
    depth: float = 0.0
    compliance: float = math.inf


def _speed(scene: Scene) -> float:
    """Fastest movement of the hand, or of a rotor that is released, rad/s."""
    hand = scene.hand
    if hand is None:
        return 0.0
    if hand.path == "impact":
        return abs(hand.speed_rad_s or 0.0)
    if hand.path == "press":
        return 1.1 * hand.amplitude_rad / PRESS_RAMP_S
    return 2.0 * math.pi * (hand.frequency_hz or 0.0) * hand.amplitude_rad


def _depth(scene: Scene) -> float:
    """How far the hand's path leads into a wall, rad."""
    hand = scene.hand
    if hand is None or hand.path == "impact":
        return 0.0
    a = hand.amplitude_rad
    low, high = {"press": (-0.1 * a, a), "free": (-3.0 * a, -a)}.get(hand.path, (-a, a))
    depth = 0.0
    for edge_low, edge_high in scene.controller.walls:
        if low < edge_low < high:
            depth = max(depth, min(high, edge_high) - edge_low)
        if low < edge_high < high:
            depth = max(depth, edge_high - max(low, edge_low))
    return depth


def _push(scene: Scene, set_: Settings) -> _Push:
    hand, motor, eta = scene.hand, scene.motor, scene.controller.eta_contact
    if hand is None or not scene.controller.walls or eta >= 0.0:
        return _Push()
    wish = set_.shaper.wish if set_.shaped.all() else None
    spring = rendered_stiffness(
        scene, set_.r_hat, set_.tau, eta, set_.anchored, wish.spring if wish else None
    )
    if spring <= 0.0:
        return _Push()
    if hand.path == "impact":
        return _Push(_speed(scene) * math.sqrt(motor.J_kgm2 * spring))
    depth, compliance = _depth(scene), 1.0 / spring + 1.0 / (hand.stiffness or math.inf)
    torque = depth / compliance
    if motor.brushless and motor.pole_pairs:
        torque = min(torque, spring / motor.pole_pairs)  # where its wall gives way by itself
    return _Push(torque, depth, compliance)


# ---- The ranges.


def range_a(sensor: Sensor) -> float:
    return formats.CURRENT.largest if sensor.ideal else sensor.linear * sensor.full_scale_a


def _current(scene: Scene, sensor: Sensor, push: _Push) -> Exceeded | None:
    current, limit = push.torque / scene.motor.k_t, range_a(sensor)
    if current <= limit:
        return None
    if scene.adc is None:
        return Exceeded(
            CURRENT, current, limit, "A", "where its word ends",
            f"the wall gives way there; take a softer hand {LARGER_UNITS}",
        )  # fmt: skip
    return Exceeded(
        CURRENT, current, limit, "A", "where the ADC's range ends",
        "the wall gives way there; take a larger adc.full_scale_a or a softer hand",
    )  # fmt: skip


def _asked_v(scene: Scene) -> float:
    """The voltage limit that the scene asks for, V; infinite where it has none."""
    drive = scene.drive
    asked = reached_v(scene)
    return asked if drive is None else min(asked, drive.limit(scene.controller.r_hat))


def _voltage(scene: Scene, set_: Settings, push: _Push) -> Exceeded | None:
    limit = min(formats.VOLTAGE.largest, root(set_.r_hat) * formats.WAVE.largest)
    asked = _asked_v(scene)
    if math.isinf(asked):
        motor = scene.motor
        back = (motor.felt_k_t / math.sqrt(1.5) if motor.brushless else motor.k_t) * _speed(scene)
        asked = max(back, set_.r_hat * push.torque / motor.k_t)
    if asked <= limit * (1.0 + 1e-6):
        return None
    where = "where its word ends"
    if limit < formats.VOLTAGE.largest:
        where = f"where the word of u ends ({formats.WAVE.largest:.3g} √W, R̂ = {set_.r_hat:.3g} Ω)"
    return Exceeded(
        "the voltage", asked, limit, "V", where, f"it is limited there; lower it {LARGER_UNITS}"
    )


def _wave(scene: Scene, set_: Settings, push: _Push) -> Exceeded | None:
    wave = set_.s * min(push.torque / scene.motor.k_t, formats.CURRENT.largest)
    if wave <= formats.WAVE.largest:
        return None
    return Exceeded(
        "the wave v", wave, formats.WAVE.largest, "√W", "where its word ends",
        f"the wall gives way there; take a softer hand {LARGER_UNITS}",
    )  # fmt: skip


def _moves(scene: Scene, set_: Settings) -> Exceeded | None:
    moves = _speed(scene) * set_.tick_s / set_.cell_rad
    most = (1 << (formats.MOVE_W - 1)) - 1
    if moves <= most:
        return None
    return Exceeded(
        "the movement in a tick", moves, most, "counts", "what the port anchor counts",
        "it loses the rotor; take a coarser encoder or a faster tick",
    )  # fmt: skip


def _flux(scene: Scene, set_: Settings, sensor: Sensor, push: _Push) -> Exceeded | None:
    """χ is how far the rotor goes in beyond what the largest force holds.

    That of a brushless motor's axis is no more than twice the magnets' flux.
    """
    most = scene.motor.k_t * min(range_a(sensor), set_.limit_v / set_.r_hat)
    if push.torque <= most:
        return None
    beyond = (push.depth - most * push.compliance) / set_.cell_rad
    if scene.motor.pole_pairs:
        beyond = min(beyond, 2.0 / (scene.motor.pole_pairs * set_.cell_rad))
    limit = 0.5 * formats.LONG.largest
    if beyond <= limit:
        return None
    return Exceeded(
        "the flux χ", beyond, limit, "cells", "where the port anchor takes the rotor for lost",
        "the port only damps then; take a coarser encoder or a softer hand",
    )  # fmt: skip


def _gains(set_: Settings) -> list[Exceeded]:
    """Settings of the port anchor that are limited to their words."""
    words = set_.anchor
    found = []
    if words[anchor.OWED_GAIN] == formats.FLUX.raw_max:
        owed = formats.FLUX.to_value(int(words[anchor.FLUX_GAIN])) / formats.A.to_value(set_.a)
        found.append(Exceeded(
            "the gain of what the voltage limit withholds", owed, formats.FLUX.largest, "cells/√W",
            "where its word ends", "a wall moves when the limit was at work; take a larger lambda "
            "or a coarser encoder",
        ))  # fmt: skip
    most = (1 << formats.REST_W) - 1
    slow_s = set_.cell_rad / SLOW_RAD_S
    if slow_s > most * set_.tick_s:
        found.append(Exceeded(
            "the time between two edges of a slow rotor", slow_s / set_.tick_s, most, "ticks",
            "where its word ends", "the offset is tracked at higher speeds; take a slower tick",
        ))  # fmt: skip
    return found


def _filter_states(scene: Scene, set_: Settings, push: _Push) -> list[Exceeded]:
    """States of W, of the largest wave of a contact at whatever frequency."""
    wave = 0.5 * set_.s * push.torque / scene.motor.k_t
    limit = formats.SHAPE_STATE.largest
    states = [wave * state_gain(words) for words in set_.shaper.words]
    return [
        Exceeded(
            f"a state of section {n} of W", state, limit, "√W", "where its word ends",
            "W gives less back; take a slower tick or a softer hand",
        )
        for n, state in enumerate(states) if state > limit
    ]  # fmt: skip
