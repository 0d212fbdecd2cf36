# SPDX-License-Identifier: Apache-2.0
"""A motor's port whose environment this program has, with the names of ``sim/c/wavehaptics.h``.

It stands on :class:`~wavehaptics.host.client.Client`, which has words, time-outs and the matching
of answers already, and no library has to be built and found. It is slower than C: an exchange is
two questions, one after the other.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from wavehaptics.host.client import RENEWAL_S, ZERO_S, Client
from wavehaptics.host.names import HostError, Place, places
from wavehaptics.ladder.hosted import Environment
from wavehaptics.words.faults import FAULTS, arm_refusal, bits_of

SEQUENCES = 256


@dataclass(frozen=True)
class Packet:
    """``v`` is the mean over a period, √W; ``periods`` is 1, and one more for each packet that was
    missed; ``active`` says that the host's answers are in force."""

    sequence: int
    periods: int
    v: float
    active: bool


class HostPort:
    """Motor ``motor`` of a device with a link to a host; ``k_t`` in N·m/A.

    For fast exchanges use it within :meth:`~wavehaptics.host.client.Client.hurry`. All errors are
    :class:`HostError`, one line each.
    """

    def __init__(self, client: Client, k_t: float, motor: int = 0) -> None:
        if not client.identification.options["host"]:
            raise HostError(
                "the device has no link to a host; take a bitstream with HOST = 1, or a virtual "
                "board of a scene with [host]"
            )
        self._client, self._motor, self.k_t = client, motor, k_t
        root, half_clocks, halves, log2, timeout = self._read(
            "root", "half_clocks", "tick_halves", "host_period_log2", "host_timeout"
        )
        if not root > 0.0:
            raise HostError(f"root of motor {motor} is 0: set it to the square root of 2 R first")
        self.s = root
        self.b = 2.0 * (k_t / root) ** 2
        tick_s = half_clocks * halves / client.identification.words["clock_hz"]
        self.period_s = tick_s * 2.0 ** int(log2)
        self.timeout = int(timeout)
        self._sequence: int | None = None
        self._renewed_s = 0.0

    def _place(self, name: str) -> Place:
        return places(name, self._client.shape, self._motor)[0]

    def _read(self, *names: str) -> list[float]:
        found = [self._place(name) for name in names]
        raws = self._client.read(found)
        return [place.value(raw) for place, raw in zip(found, raws, strict=True)]

    def _write(self, **values: float) -> None:
        words = [(self._place(name), value) for name, value in values.items()]
        self._client.write([(place, place.raw(value)) for place, value in words])

    def arm(self) -> None:
        """The bridges on for 200 ms, once a zero is measured; :meth:`exchange` renews that."""
        self._write(arm=1)
        until = time.monotonic() + ZERO_S
        while True:
            armed, refused = self._read("armed", "arm_refused")
            if armed:
                self._renewed_s = time.monotonic()
                return
            if refused or time.monotonic() > until:
                raise HostError(f"can't be armed: {self._why_off(int(refused))}")

    def disarm(self) -> None:
        """The bridges off."""
        self._write(arm=0)

    def _why_off(self, refused: int) -> str:
        faults = [FAULTS[bit] for bit in bits_of(int(self._read("faults")[0]))]
        reasons = [arm_refusal(refused), *(meaning or name for name, meaning in faults)]
        return ", ".join(filter(None, reasons)) or "they were disarmed; arm them again"

    def speed(self, v: float, torque: float) -> float:
        """Speed that a packet and a torque on the rotor mean together, rad/s."""
        return self.s * v / self.k_t + torque / self.b

    def wave(self, v: float, torque: float) -> float:
        """The answer that makes that torque, √W."""
        return v + self.s * torque / self.k_t

    def next(self) -> Packet:
        """The next packet that is newer than the last one."""
        until = time.monotonic() + ZERO_S
        while True:
            number, v, active = self._read("host_packet_sequence", "host_v", "host_active")
            sequence, last = int(number), self._sequence
            self._sequence = sequence
            if last is not None and sequence != last:
                return Packet(sequence, (sequence - last) % SEQUENCES, v, bool(active))
            if time.monotonic() > until:
                armed, refused = self._read("armed", "arm_refused")
                why = "the bridges are on" if armed else self._why_off(int(refused))
                raise HostError(f"no packets: {why}")

    def exchange(self, u: float) -> Packet:
        """Answer the last packet with u, √W, and wait for the next one."""
        if self._sequence is None:
            raise HostError("there is no packet to be answered; take next first")
        if time.monotonic() - self._renewed_s > RENEWAL_S:
            self._write(host_alive=1)
            self._write(arm=2)
            self._renewed_s = time.monotonic()
        self._write(host_answer_sequence=self._sequence, host_u=u, host_answer=1)
        return self.next()

    def serve(self, environment: Environment, ended: Callable[[], bool]) -> int:
        """Answer each packet with the environment's step until ``ended``; the number of them."""
        packet, count = self.next(), 0
        while not ended():
            packet = self.exchange(environment.step(packet.v))
            count += 1
        return count
