# SPDX-License-Identifier: Apache-2.0
"""A board on a serial port, or a simulated one, by the names of the register map."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from wavehaptics.api.scenes import Scene, load_scene
from wavehaptics.host.client import RENEWAL_S, ZERO_S, Client
from wavehaptics.host.names import HostError, Place, places, readable, settable
from wavehaptics.host.planes import JointPlane, MotorData, Planes
from wavehaptics.host.scope.plug import VirtualPlug
from wavehaptics.runtime.ends import ending
from wavehaptics.scene import Scene as SceneTables
from wavehaptics.words.faults import arm_refusal
from wavehaptics.words.table import WORDS

ARM, RENEW, DISARM = 1, 2, 0
"""Values of the register ``arm``."""

START_S = 900.0
"""Longest start of a virtual board, s: the first time its RTL is compiled."""

VIRTUAL_TIMEOUT_S = 60.0
"""For an answer of a virtual board: on a busy machine it is slow."""


def _data(scene: SceneTables, name: str) -> MotorData:
    """What a scene says of a motor, by the controller's estimates."""
    control, encoder = scene.controller, scene.encoder
    if encoder is None or control.k_t_hat is None or control.l_hat is None:
        raise HostError(f"{name}: the scene has no [encoder] for this motor; give it one")
    return MotorData(control.k_t_hat, control.l_hat, encoder.counts_per_rev)


class Board:
    """A device on the serial port ``port``; at the end of its ``with`` block it is disarmed.

    That is so if this object has armed it. What another program has armed stays on.
    ``unit`` is the device's address on the line, ``motor`` the one whose registers are meant,
    ``timeout_s`` that of an answer. Every error is a :class:`HostError`, one line with the cure.
    """

    def __init__(self, port: str, *, unit: int = 1, motor: int = 0, timeout_s: float = 5.0) -> None:
        self._client = Client(port, unit, timeout_s)
        self._motor = motor
        self._plug: VirtualPlug | None = None
        self._has_armed = False

    @classmethod
    def virtual(
        cls, scene: Scene | str, *, motor: int = 0, motors: int | None = None, surfaces: int = 0,
        timeout_s: float = VIRTUAL_TIMEOUT_S,
    ) -> Board:  # fmt: skip
        """A simulated board with the motor and the hand of a scene, no faster than real time.

        It has so many ``motors``, each as the scene has it, by default as many as the board whose
        ``board.toml`` it is, else one; and so many ``surfaces`` across two or three of them. With
        a planar arm both are the scene's. The scene needs a ``[hand]`` that isn't an impact, and is
        read from its file again. The board is a process that ends with :meth:`close` or the
        ``with`` block. The first time the RTL is compiled, for minutes.
        """
        if not isinstance(scene, Scene):
            scene = load_scene(scene)
        more = ["--motors", str(motors)] if motors is not None else []
        more += ["--surfaces", str(surfaces)] if surfaces else []
        led = None if scene.device.space is not None else 0
        plug = VirtualPlug(str(scene.path), scene.changes, led, more)
        try:
            until = time.monotonic() + START_S
            while problem := plug.problem:
                if not plug.plugged or time.monotonic() > until:
                    raise HostError(problem)
                time.sleep(0.05)
            board = cls(plug.port, motor=motor, timeout_s=timeout_s)
        except BaseException:
            plug.close()
            raise
        board._plug = plug
        return board

    @property
    def client(self) -> Client:
        """The client of the line, for what isn't here."""
        return self._client

    @property
    def units(self) -> dict[str, str]:
        """Unit of each register that this device has, by its name; – stands for none."""
        shape = self._client.shape
        return {
            name: word.row.unit or "–"
            for name, word in WORDS.items() if shape.has(word) and shape.copies(word)
        }  # fmt: skip

    def __getitem__(self, name: str) -> Any:
        """Value of a register in its unit; a list where it has several, as ``wall_min`` has.

        ``wall_min[2]`` is one of them.
        """
        found = self._places(name)
        values = [
            place.value(raw)
            for place, raw in zip(found, self._client.read(map(readable, found)), strict=True)
        ]
        return values[0] if len(values) == 1 and found[0].text == name else values

    def _places(self, name: str) -> list[Place]:
        return places(name, self._client.shape, self._motor)

    def set(self, values: Mapping[str, float] | None = None, /, **named: float) -> None:
        """Write registers in their units; those of one group are applied together.

        ``set(eta_contact=-0.9)``, or ``set({"wall_min[0]": 100})`` for one of several. Nothing is
        written where one of them is refused.
        """
        words = []
        for name, value in {**(values or {}), **named}.items():
            found = [settable(place) for place in self._places(name)]
            if len(found) > 1:
                raise HostError(f"{name}: which one? Take {found[0].text}...{found[-1].text}")
            words.append((found[0], found[0].raw(value)))
        # Noted before it is written: an arming without an answer may have been heard.
        self._has_armed |= any(place.word.name == "arm" and raw for place, raw in words)
        self._client.write(words)

    def set_planes(
        self, planes: Sequence[JointPlane], motors: Sequence[MotorData], *, speed: float = 0.1,
        stamp: int | None = None,
    ) -> int:  # fmt: skip
        """Give the device planes across its motors, all that there are from now on, together.

        Each is ``normal·q >= offset`` in the motors' angles. :meth:`planes` is for programs that
        give new ones again and again, and for an arm with a tip. Returns the stamp.
        """
        made = Planes(self._client, motors, speed=speed)
        return made.set_joint(planes) if stamp is None else made.set_joint(planes, stamp=stamp)

    def planes(
        self, scene: Scene | str | None = None, motors: Sequence[MotorData] | None = None,
        *, speed: float | None = None,
    ) -> Planes:  # fmt: skip
        """Planes of this device, for the arm and the motors of a scene with a ``[device]``.

        The arm is where the scene begins while the encoders count 0. Without a scene there are
        planes in joint space alone, of ``motors``.
        """
        if scene is None:
            if motors is None:
                raise HostError("planes of which motors? Give motors, or a scene with a [device]")
            return Planes(self._client, motors, speed=0.1 if speed is None else speed)
        found = scene if isinstance(scene, Scene) else load_scene(scene)
        space = found.device.space
        if space is None:
            raise HostError(f"{found.path}: the scene has no [device]; take one that has an arm")
        if motors is None:
            motors = [_data(one, name) for name, one in found.device.motors.items()]
        most = space.device.wall_speed_m_per_s if speed is None else speed
        energy = space.device.wall_energy_j
        return Planes(self._client, motors, space.arm, speed=most, energy=energy)

    @contextmanager
    def armed(self) -> Iterator[Board]:
        """Within the block the bridges are on; at its end, however that comes, they are off.

        A thread renews the arming. :class:`HostError` where the board can't be armed, and at the
        end of the block where it didn't stay so.
        """
        over = threading.Event()
        lost: list[HostError] = []

        def renew() -> None:
            while not over.wait(RENEWAL_S):
                try:
                    self.set(arm=RENEW)
                except HostError as error:
                    lost.append(error)
                    return

        def end() -> None:
            over.set()
            renewing.join()
            on = not lost and self["armed"]
            self.disarm()
            if not on:
                raise lost[0] if lost else HostError(f"disarmed: {self._why_off()}")

        self._arm()
        renewing = threading.Thread(target=renew, name="arming", daemon=True)
        with ending(end):
            renewing.start()
            yield self

    def _arm(self) -> None:
        self.set(arm=ARM)
        until = time.monotonic() + ZERO_S
        while not self["armed"]:
            if self["arm_refused"] or time.monotonic() > until:
                why = self._why_off()
                self.disarm()
                raise HostError(f"not armed: {why}")
            time.sleep(RENEWAL_S)
            self.set(arm=RENEW)

    def _why_off(self) -> str:
        refused = int(self["arm_refused"])
        return arm_refusal(refused) or "the line was silent, or somebody has disarmed it"

    def disarm(self) -> None:
        """The bridges off, where they can be armed over the line."""
        if self._client.identification.options["arm"]:
            self.set(arm=DISARM)

    def close(self) -> None:
        """Disarm what this object has armed; the process of a virtual board ends."""
        plug, self._plug = self._plug, None
        with ending(plug.close if plug is not None else lambda: None):
            if self._has_armed:
                self.disarm()

    def __enter__(self) -> Board:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
