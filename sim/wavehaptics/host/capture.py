# SPDX-License-Identifier: Apache-2.0
"""Live words of a device over time, as its ``rtl/wh_capture.v`` keeps them around a trigger.

One call starts it, waits and gives arrays in SI units::

    found = take(client, ["current", "voltage"], rows=2000, trigger="current rises 0.5", before=200)
    plot(found.t, found["current"])

:func:`start`, :func:`wait`, :func:`stop` and :func:`download` are its parts.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from wavehaptics.host.client import Client
from wavehaptics.host.names import HostError, Place, listed, places
from wavehaptics.words.faults import FLAGS
from wavehaptics.words.modbus import MOST_READ

MOTOR_WORDS = (
    "voltage", "u", "v", "current", "position", "flags", "correction", "offset", "flux", "lag",
)  # fmt: skip
BOARD_WORDS = ("faults", "bus")
WORDS = (*MOTOR_WORDS, *BOARD_WORDS)
"""Words that can be captured."""

SETTINGS = (
    "capture_channel", "capture_channels", "capture_rows", "capture_pre", "capture_decimation",
    "capture_trigger", "capture_level",
)  # fmt: skip
"""Settings that a start takes over, all of which :func:`start` writes."""

PICTURED = ("position", "current", "voltage", "u", "v", "flags")
"""Of these, what the picture of a run is drawn from."""

MOST_CHANNELS = 8
MOST_DECIMATION = 1 << 15

REST, FILLS, WAITS, TRIGGERED, DONE = range(5)
"""The word ``capture_state``."""

_START, _TRIGGER, _STOP = 1, 2, 0
_ARMED_BURST = 8
"""Reads at a stretch while somebody may have to renew the arming."""
_GIVE_WAY_S = 0.05
"""And how long the line is left to others then, who look for it every few milliseconds."""
_POLL_S = 0.02
_STILL_S = 30.0
"""Wall-clock time without a tick after which there are none, on a slow simulated board as well."""

_NUMBER = r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)"
_KINDS = (
    (rf"(\S+?)\s*>=?\s*{_NUMBER}", 1),
    (rf"(\S+?)\s*<\s*{_NUMBER}", 2),
    (rf"(\S+)\s+rises\s+{_NUMBER}", 3),
    (rf"(\S+)\s+falls\s+{_NUMBER}", 4),
    (r"(\S+)\s+changes", 5),
    ("contact", 6),
    ("fault", 7),
    ("now", 0),
)
"""What a trigger can be, and its number in the word ``capture_trigger``."""


class Trigger(NamedTuple):
    """A trigger: its kind, the channel that it looks at ("" for none), the level, SI, its text."""

    kind: int
    channel: str = ""
    level: float = 0.0
    text: str = "now"


NOW = Trigger(0)
"""At once."""


def trigger_of(text: str) -> Trigger:
    """The trigger that a text means; :class:`HostError` for one that means none.

    ``now``, ``contact``, ``fault``, ``NAME>VALUE``, ``NAME<VALUE`` (also where it is so at once),
    ``NAME rises VALUE``, ``NAME falls VALUE``, ``NAME changes``.
    """
    for pattern, kind in _KINDS:
        found = re.fullmatch(pattern, text.strip())
        if found:
            given = list(found.groups())
            channel, level = given + ["", "0"][len(given) :]
            try:
                wanted = Trigger(kind, channel, float(level), text.strip())
            except ValueError:
                break
            if math.isfinite(wanted.level):
                return wanted
    raise HostError(
        f"trigger {text}: write now, contact, fault, NAME>VALUE, NAME<VALUE, NAME rises VALUE, "
        "NAME falls VALUE or NAME changes"
    )


@dataclass(frozen=True)
class Plan:
    """What is captured. ``channels`` as the memory has them, that of the trigger first.

    ``rows`` in all, ``before`` of them before the trigger's; a row is of ``decimation`` ticks.
    """

    channels: tuple[Place, ...]
    names: tuple[str, ...]
    rows: int
    before: int
    decimation: int
    trigger: Trigger
    tick_s: float

    @property
    def row_s(self) -> float:
        """Time from row to row, s."""
        return self.decimation * self.tick_s


@dataclass(frozen=True)
class Captured:
    """Rows of a capture: ``values`` by the channels' names, float64 of shape (rows,), SI units.

    ``t`` is the time of a row's middle, s, from that of the trigger's on, or from the first row's
    where there was none. Words with a sign and the bus are means over the row, ``flags`` and
    ``faults`` what was set in any tick of it, as integers, ``position`` is that of its end.
    """

    plan: Plan
    t: np.ndarray
    values: Mapping[str, np.ndarray]
    trigger_row: int | None
    """Row of the trigger; None where it was stopped before. Not there, if it was cut off before."""

    def __getitem__(self, name: str) -> np.ndarray:
        """The values of a channel."""
        return self.values[name]

    def flag(self, name: str, channel: str = "flags") -> np.ndarray:
        """A bit of ``flags``, bool, by its name in :data:`wavehaptics.words.faults.FLAGS`."""
        return (self.values[channel] >> FLAGS.index(name) & 1).astype(bool)


class CutOffError(HostError):
    """A download that failed; ``found`` has the first of its rows, which had come before."""

    def __init__(self, problem: str, found: Captured) -> None:
        self.found = found
        super().__init__(problem)


class Progress(NamedTuple):
    """How far a capture is: its state, and the part of it that is done, 0 to 1."""

    state: int
    part: float


def depth(client: Client) -> int:
    """Words that the device's capture takes; :class:`HostError` where it has none."""
    log2 = client.identification.options["capture"]
    if not log2:
        raise HostError("the device has no capture; its bitstream was made without")
    return 1 << log2


def tick_s(client: Client) -> float:
    """The device's tick, s."""
    found = [places(name, client.shape)[0] for name in ("half_clocks", "tick_halves")]
    return math.prod(client.read(found)) / client.identification.words["clock_hz"]


def plan(
    client: Client,
    channels: Sequence[str],
    *,
    rows: int | None = None,
    seconds: float | None = None,
    decimation: int | None = None,
    trigger: str | Trigger = NOW,
    before: int = 0,
    before_s: float | None = None,
    motor: int = 0,
) -> Plan:
    """What a capture of ``channels`` is to be; :class:`HostError` for what the device can't do.

    A channel is a name of :data:`WORDS`, of ``motor``, or ``NAME@MOTOR``. It takes ``rows`` of
    ``decimation`` ticks each, a power of two, or what makes ``seconds``. Without a decimation it is
    the smallest with which these fit, 1 without seconds; without rows there are as many as fit. Of
    all, ``before`` rows or ``before_s`` seconds are before the trigger's.
    """
    room = depth(client)
    for what, time_s in (("seconds", seconds), ("seconds before the trigger", before_s)):
        if time_s is not None and not math.isfinite(time_s):
            raise HostError(f"{time_s} {what}: take a number of seconds")
    wanted = trigger_of(trigger) if isinstance(trigger, str) else trigger
    names = [*dict.fromkeys(listed(channels))]
    if wanted.channel:
        names = [wanted.channel, *(name for name in names if name != wanted.channel)]
    if not 1 <= len(names) <= MOST_CHANNELS:
        raise HostError(f"{len(names)} channels: take 1 to {MOST_CHANNELS}")
    found = tuple(channel(client, name, motor) for name in names)
    most = room // len(found)
    tick = tick_s(client)
    if decimation is None:
        decimation = 1
        while seconds is not None and seconds > most * decimation * tick * (1 + 1e-9):
            decimation *= 2
    if not 1 <= decimation <= MOST_DECIMATION or decimation & (decimation - 1):
        raise HostError(
            f"decimation {decimation}: take 1, 2, 4 ... {MOST_DECIMATION} ticks a row; "
            f"all {most} rows are then up to {most * MOST_DECIMATION * tick:.3g} s"
        )
    if seconds is not None:
        rows = max(1, round(seconds / (decimation * tick)))
    rows = most if rows is None else rows
    if before_s is not None:
        before = round(before_s / (decimation * tick))
    if not 1 <= rows <= most:
        raise HostError(
            f"{rows} rows of {len(found)} channels: the device has room for 1...{most}, "
            f"{most * decimation * tick:.3g} s; take fewer, or a larger decimation"
        )
    if not 0 <= before < rows:
        raise HostError(f"{before} rows before the trigger's: take 0...{rows - 1} of {rows}")
    if wanted.channel:
        _level(found[0], wanted)
    return Plan(found, tuple(names), rows, before, decimation, wanted, tick)


def channel(client: Client, name: str, motor: int, what: str = "captured") -> Place:
    """The word that ``NAME`` or ``NAME@MOTOR`` means; others can't be ``what``."""
    base, at, number = name.partition("@")
    if base not in WORDS or (at and not re.fullmatch("[0-9]{1,9}", number)):
        raise HostError(f"{name}: can't be {what}; take {', '.join(WORDS)}")
    return places(base, client.shape, int(number) if at else motor)[0]


def _level(place: Place, wanted: Trigger) -> int:
    """The level as a raw word of the channel, the least one that is as much or more."""
    fixed = place.word.fixed
    far = abs(wanted.level) > 2.0**32  # than all words; times a power of two it may be endless
    raw = 0 if far else math.ceil(wanted.level * 2.0**fixed.fraction)
    if far or not fixed.holds(raw):
        raise HostError(f"trigger at {wanted.channel} = {wanted.level:g}: take {place.range_text}")
    return raw


def start(client: Client, wanted: Plan) -> None:
    """Tell the device what to capture, and start it. What it has captured before is lost."""
    addresses = [place.address for place in wanted.channels]
    addresses += [0] * (MOST_CHANNELS - len(addresses))
    level = _level(wanted.channels[0], wanted.trigger) if wanted.trigger.channel else 0
    words: dict[str, int] = {
        **{f"capture_channel[{n}]": address for n, address in enumerate(addresses)},
        "capture_channels": len(wanted.channels),
        "capture_rows": wanted.rows,
        "capture_pre": wanted.before,
        "capture_decimation": wanted.decimation.bit_length() - 1,
        "capture_trigger": wanted.trigger.kind,
        "capture_level": level,
    }
    client.write((places(name, client.shape)[0], raw) for name, raw in words.items())
    _command(client, _START)
    if not wanted.trigger.kind:
        _command(client, _TRIGGER)


def stop(client: Client) -> None:
    """Stop a capture. The rows that are there can be had by :func:`download`."""
    _command(client, _STOP)


def _command(client: Client, value: int) -> None:
    client.write([(places("capture", client.shape)[0], value)])


def _state(client: Client, *more: str) -> list[int]:
    names = ("capture_state", "capture_count", "capture_first", "capture_left", *more)
    return client.read(places(name, client.shape)[0] for name in names)


def wait(
    client: Client,
    wanted: Plan,
    progress: Callable[[Progress], None] = lambda _: None,
    ended: Callable[[], bool] = lambda: False,
) -> bool:
    """Wait until a capture is done, or ``ended`` says to stop it; whether it is done by itself.

    It waits for a trigger as long as that takes. :class:`HostError` if the device isn't at it, or
    there are no ticks.
    """
    last, since = -1, time.monotonic()
    while True:
        state, count, _, left, ticks = _state(client, "ticks")
        after = wanted.rows - wanted.before
        came = after - left
        part = (min(count, wanted.before) + came) / wanted.rows
        progress(Progress(state, part))
        if state == DONE:
            return left == 0
        if state == REST:
            raise HostError("the device isn't capturing: was it reset? Start it anew")
        if ticks != last:
            last, since = ticks, time.monotonic()
        elif time.monotonic() - since > _STILL_S:
            raise HostError("there are no ticks, and so nothing to capture; is the ADC there?")
        if ended():
            stop(client)
        time.sleep(_POLL_S)


def download(
    client: Client, wanted: Plan, progress: Callable[[float], None] = lambda _: None
) -> Captured:
    """What the device has captured, once it is done. ``progress`` takes the part that is here.

    :class:`CutOffError` where the line fails behind the first row.
    """
    state, count, first, left, armed = _state(client, "armed")
    if state != DONE:
        raise HostError("the capture isn't done; wait for it, or stop it")
    total = count * len(wanted.channels)
    came = wanted.rows - wanted.before - left
    trigger_row = count - came if came else None
    raws: list[int] = []
    try:
        while len(raws) < total:
            with client.hurry():
                reads = 0
                while len(raws) < total and not (armed and reads == _ARMED_BURST):
                    # In the order of time, round the ring.
                    at = (first * len(wanted.channels) + len(raws)) % total
                    most = min(MOST_READ, total - len(raws), total - at)
                    raws += _window(client, at, most)
                    reads += 1
                    progress(len(raws) / total)
            if armed:
                time.sleep(_GIVE_WAY_S)
    except HostError as error:
        if len(raws) < len(wanted.channels):
            raise
        raise CutOffError(str(error), _rows(wanted, raws, trigger_row)) from None
    return _rows(wanted, raws, trigger_row)


def _rows(wanted: Plan, raws: list[int], trigger_row: int | None) -> Captured:
    """Whole rows of words that stand side by side, from the first row on."""
    count = len(raws) // len(wanted.channels)
    table = np.array(raws[: count * len(wanted.channels)], dtype=np.uint32)
    table = table.reshape(count, len(wanted.channels))  # of no row as well
    values = {
        name: _values(place, table[:, n])
        for n, (name, place) in enumerate(zip(wanted.names, wanted.channels, strict=True))
    }
    t = (np.arange(count) - (trigger_row or 0)) * wanted.row_s
    return Captured(wanted, t, values, trigger_row)


def _window(client: Client, offset: int, count: int) -> list[int]:
    """Words of the capture's memory."""
    client.write([(places("capture_offset", client.shape)[0], offset)])
    return client.read(places("capture_data", client.shape)[:count])


def _values(place: Place, raws: np.ndarray) -> np.ndarray:
    fixed = place.word.fixed
    if not fixed.signed and not fixed.fraction:
        return raws
    signed = raws.astype(np.int32) if fixed.signed else raws
    return signed * fixed.step


def take(
    client: Client,
    channels: Sequence[str],
    *,
    progress: Callable[[Progress], None] = lambda _: None,
    **wanted: object,
) -> Captured:
    """Capture ``channels`` and give them; keywords are those of :func:`plan`."""
    planned = plan(client, channels, **wanted)  # type: ignore[arg-type]
    start(client, planned)
    wait(client, planned, progress)
    return download(client, planned)
