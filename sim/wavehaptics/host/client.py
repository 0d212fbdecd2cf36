# SPDX-License-Identifier: Apache-2.0
"""A device on a serial port: Modbus RTU by pymodbus, words by their places.

The port is taken for one exchange at a time, so several programs can use it by turns: one renews
the arming while another one sets words.
"""

from __future__ import annotations

import errno
import logging
import os
import socket
import stat
import struct
import termios
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TypeAlias

import serial
from pymodbus.client import ModbusSerialClient
from pymodbus.exceptions import ConnectionException, ModbusException
from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU, ModbusPDU
from pymodbus.pdu.register_message import ReadHoldingRegistersRequest, WriteMultipleRegistersRequest

from wavehaptics.host.framed_line import FramedLine
from wavehaptics.host.names import HostError, Place, Shape, listed, places, readable, settable
from wavehaptics.runtime.ends import ending
from wavehaptics.words import modbus, table
from wavehaptics.words.table import LEGS, THREE_PHASE_LEGS

BAUD = modbus.BAUDS[0]
"""Bits a second that a device begins with."""

RENEWAL_S = 0.05
"""Wall-clock time from one renewal of the arming to the next, a quarter of what it lasts."""

ZERO_S = 10.0
"""Wall-clock time in which a zero is measured, on a slow simulated board as well."""

_RATE = 2 * modbus.IDENTIFICATION.index("rate")

_FALLBACK_S = 1.2
"""Without a good frame for so long, or a little less, a device is at its first rate again."""

_TURN_S = 0.005

_SILENT_S = 0.05
"""Without a byte for so long nothing is under way, also through a USB bridge that hands on what it
has every 16 ms."""

_READ, _WRITE = 3, 16
"""Functions of Modbus."""

_STREAM_OFF, _STREAM, _STREAM_ON = 0, 1, 2
"""The word ``stream``: no more, begin, go on."""

Line: TypeAlias = "serial.Serial | FramedLine"

# Everything that goes wrong is told by exceptions.
logging.getLogger("pymodbus.logging").setLevel(logging.CRITICAL + 1)


@dataclass(frozen=True)
class Identification:
    """What a device says of itself: the words from register 0 on, by name, without signs."""

    words: Mapping[str, int]

    @property
    def options(self) -> dict[str, int]:
        """What the bitstream was made with."""
        found = self._options
        return found | {"shaper": 0} if self.brushless else found

    @property
    def _options(self) -> dict[str, int]:
        raw = self.words["options"]
        return {name: raw >> low & (1 << bits) - 1 for name, (low, bits) in modbus.OPTIONS.items()}

    @property
    def brushless(self) -> bool:
        """Whether its motors are brushless ones."""
        return self._options["shaper"] == modbus.BRUSHLESS_SHAPER

    @property
    def shape(self) -> Shape:
        """Its number of motors and of copies of words."""
        options = self.options
        return Shape(
            self.words["motors"], options["walls"], options["shaper"], options["delay_log2"],
            THREE_PHASE_LEGS if self.brushless else LEGS,
        )  # fmt: skip


class Client:
    """A device of one unit on the port at ``port``.

    ``timeout_s`` is that of an answer, and of waiting for others who have the port; a question is
    repeated once. All errors are :class:`HostError`, one line each.
    """

    def __init__(self, port: str, unit: int = 1, timeout_s: float = 5.0) -> None:
        self._port, self._unit, self._timeout_s = port, unit, timeout_s
        self._heard = 0
        self._astray = False  # whether answers to earlier questions may still come
        self._probes = 0
        self._known = False
        self.before_each: Callable[[], None] = lambda: None
        """Called before each exchange; those that it makes itself call it as well."""
        self._held: serial.Serial | FramedLine | None = None
        self._lock = threading.RLock()
        self._baud = BAUD
        self._hurries: bool | None = None  # whether that is known to work
        self.identification = self._identify()
        self._known = True

    @property
    def shape(self) -> Shape:
        """The device's number of motors and of copies of words."""
        return self.identification.shape

    @property
    def port(self) -> str:
        """Where it is."""
        return self._port

    @property
    def baud(self) -> int:
        """Bits a second of the line, as it is now."""
        return self._baud

    def identify(self) -> Identification:
        """The identification anew, with its counters."""
        count = 2 * len(modbus.IDENTIFICATION)
        words = modbus.whole(self._read(0, count, "the identification"))
        return Identification(dict(zip(modbus.IDENTIFICATION, words, strict=True)))

    def _identify(self) -> Identification:
        found = self.identify()
        if found.words["version"] != modbus.MAP_VERSION:
            raise HostError(
                f"{self._port}: the device's map of registers is of version "
                f"{found.words['version']}, not {modbus.MAP_VERSION}; take the package of its "
                "bitstream"
            )
        if found.words["table"] != table.crc():
            raise HostError(
                f"{self._port}: the device has another table of words, CRC "
                f"{found.words['table']:08x} and not {table.crc():08x}; "
                "take the package of its bitstream"
            )
        return found

    def read(self, places: Iterable[Place | str]) -> list[int]:
        """Raw words without signs, in the order of ``places``; successive ones by one frame.

        A name is motor 0's word, and all its copies where it has several.
        """
        wanted = [found for place in listed(places) for found in self._places(place, readable)]
        found: dict[int, int] = {}
        pairs = {(place.address, 0) for place in wanted}
        names = {place.address: place.text for place in wanted}
        for first, raws in modbus.runs(pairs, modbus.MOST_READ):
            registers = self._read(modbus.word_register(first), 2 * len(raws), names[first])
            found |= zip(range(first, first + len(raws)), modbus.whole(registers), strict=True)
        return [found[place.address] for place in wanted]

    def _places(self, place: Place | str, checked: Callable[[Place], Place]) -> list[Place]:
        if isinstance(place, Place):
            return [place]
        return [checked(found) for found in places(str(place), self.shape)]

    def write(self, words: Iterable[tuple[Place | str, int]]) -> int:
        """Write raw words; successive ones in one frame. The number of frames is returned.

        A name is motor 0's word. Words between two of one group that aren't named are read, and
        written as they are.
        """
        given: dict[int, tuple[Place, int]] = {}
        for word, raw in words:
            meant = self._places(word, settable)
            if len(meant) > 1:
                raise HostError(f"{word}: which one? Take {meant[0].text}...{meant[-1].text}")
            given[meant[0].address] = meant[0], raw
        filled = {address: raw for address, (_, raw) in given.items()}
        for place in self._between(place for place, _ in given.values()):
            filled[place.address] = self.read([place])[0]
        frames = 0
        for first, raws in modbus.runs(filled.items(), modbus.MOST_WRITTEN):
            named = [given[n][0].text for n in range(first, first + len(raws)) if n in given]
            self._write(modbus.word_register(first), modbus.halves(raws), ", ".join(named))
            frames += 1
        return frames

    def write_raw(self, address: int, raws: Sequence[int], what: str) -> None:
        """Write raw words from an address of the register map on, in one frame, as they are.

        ``what`` they are is named where the device refuses them.
        """
        self._write(modbus.word_register(address), modbus.halves(raws), what)

    def _between(self, places: Iterable[Place]) -> list[Place]:
        """Settings of the same groups that lie between those that are given."""
        ordered = sorted(places, key=lambda place: place.address)
        found = []
        for low, high in pairwise(ordered):
            gap = range(low.address + 1, high.address)
            mates = {
                mate.address: mate
                for word in table.WORDS.values()
                if (word.block, word.group) == (low.word.block, low.word.group)
                and word.row.kind == "setting"
                and low.motor in self.shape.has(word)
                for index in range(self.shape.copies(word))
                for mate in [Place(word, low.motor, index, self.shape)]
            }
            if high.address in mates and all(address in mates for address in gap):
                found += [mates[address] for address in gap]
        return found

    @property
    def awaited(self) -> bool:
        """Whether somebody else waits for the port."""
        with socket.socket(socket.AF_UNIX) as place:
            return not _is_next(place, self._port)

    @contextmanager
    def hurry(self) -> Iterator[None]:
        """Keep the port, at the fastest rate of the device, for the exchanges within.

        Nobody else has the port meanwhile: who renews the arming of the bridges has to wait. Where
        the way there can't bear the rate, it stays at the first one, then and later.
        """
        rate = min(self.identification.words["rates"], len(modbus.BAUDS)) - 1
        with self._taken() as line, ending(self._slow_down, partial(self._hold, None)):
            self._hold(line)
            if rate > 0 and self._hurries:
                self._set_rate(rate)
            elif rate > 0 and self._hurries is None:
                self._try_rate(rate)
            yield

    def _hold(self, line: Line | None) -> None:
        self._held = line

    def _slow_down(self) -> None:
        """To the first rate, by a word or by silence."""
        if self._baud != BAUD:
            with suppress(HostError):
                self._set_rate(0)
        if self._baud != BAUD:
            self._go_back()

    @contextmanager
    def streaming(self, packet: Callable[[bytes], None]) -> Iterator[FramedLine]:
        """Within :meth:`hurry`: the device streams, and ``packet`` is called with what comes.

        Exchanges go on meanwhile, from any thread. Credit is renewed by a thread of its own. If the
        port has gone, the end raises that.
        """
        line = self._held
        assert isinstance(line, serial.Serial)
        place = places("stream", self.shape)[0]
        framed = FramedLine(line, packet)

        def end() -> None:
            # Behind an answer without a frame nothing comes any more; without it nobody knows.
            if not framed.end(self._question(place, _STREAM_OFF), self._timeout_s):
                self._astray = True
            if framed.error is not None:
                raise self.gone(framed.error)

        with ending(end, partial(self._hold, line)):
            self._hold(framed)
            self.write([(place, _STREAM)])
            framed.renew(self._question(place, _STREAM_ON), RENEWAL_S)
            yield framed

    def _question(self, place: Place, raw: int) -> bytes:
        """A write of a word, as it stands on the line."""
        request = WriteMultipleRegistersRequest(
            address=modbus.word_register(place.address), registers=modbus.halves([raw]),
            dev_id=self._unit,
        )  # fmt: skip
        return FramerRTU(DecodePDU(False)).buildFrame(request)

    def _try_rate(self, rate: int) -> None:
        """Ask at the new rate; without an answer, or a port that has it, this is the last time."""
        try:
            self._set_rate(rate)
            self.identify()
            self._hurries = True
        except HostError as error:
            self._hurries = False
            try:
                self._go_back()
            except HostError:
                raise error from None

    def _set_rate(self, rate: int) -> None:
        self._write(_RATE, [0, rate], "rate")
        self._speak(modbus.BAUDS[rate])

    def _speak(self, baud: int) -> None:
        assert isinstance(self._held, serial.Serial)
        # Noted before, so that it is gone back from a rate that the port's driver refuses.
        self._baud = baud
        try:
            self._held.baudrate = baud
        except (ValueError, OSError, termios.error) as error:
            raise HostError(
                f"{self._port}: can't be set to {baud} bits a second: {_reason(error)}; "
                "was it unplugged?"
            ) from None

    def _go_back(self) -> None:
        """Wait until the device has gone back to its first rate by itself."""
        time.sleep(_FALLBACK_S)
        self._speak(BAUD)

    # ---- The line.

    def _read(self, register: int, count: int, what: str) -> Sequence[int]:
        return self._exchange(
            lambda client: client.read_holding_registers(
                register, count=count, device_id=self._unit
            ),
            lambda answer: answer.function_code == _READ and len(answer.registers) == count,
            _READ, what,
        ).registers  # fmt: skip

    def _write(self, register: int, registers: list[int], what: str) -> None:
        echo = (_WRITE, register, len(registers))
        self._exchange(
            lambda client: client.write_registers(register, registers, device_id=self._unit),
            lambda answer: (answer.function_code, answer.address, answer.count) == echo,
            _WRITE, what,
        )  # fmt: skip

    def _exchange(
        self,
        ask: Callable[[ModbusSerialClient], ModbusPDU],
        fits: Callable[[ModbusPDU], bool],
        function: int,
        what: str,
    ) -> ModbusPDU:
        """The answer to a question about ``what``, asked once more if it doesn't come.

        An answer tells neither which question it is to nor, of a read, which words it has. So
        once one is late or doesn't fit, the line is settled before anything is asked again.
        """
        self.before_each()
        with self._lock, nullcontext(self._held) if self._held else self._taken() as line:
            self._heard = 0
            for _ in range(2):
                answer = self._ask(line, ask, blindly=function == _WRITE)
                if answer is None:
                    continue
                if answer.isError() and answer.function_code == function | 0x80:
                    self._astray = False
                    code = answer.exception_code
                    meaning = modbus.EXCEPTIONS.get(code, "unknown")
                    raise HostError(f"{what}: the device refuses with exception {code}: {meaning}")
                if not answer.isError() and fits(answer):
                    self._astray = False
                    return answer
        raise HostError(self._silence())

    def _ask(
        self, line: Line, ask: Callable[[ModbusSerialClient], ModbusPDU], *, blindly: bool
    ) -> ModbusPDU | None:
        """What comes after a question, None without an answer.

        ``blindly``: it is told the device also where nothing comes back, as it may still hear.
        """
        client = ModbusSerialClient(
            self._port, baudrate=self._baud, timeout=self._timeout_s, retries=0,
            trace_packet=self._listen,
        )  # fmt: skip
        client.socket = line
        try:
            if not line.is_open:  # Modbus' client closed it, as it had gone
                raise OSError(errno.EIO, os.strerror(errno.EIO))
            if self._astray and not self._settled(line):
                if blindly:
                    with suppress(ModbusException, struct.error):
                        ask(client)
                raise HostError(self._silence())
            # Until the right answer is here; a Ctrl-C may come before.
            self._astray = True
            return ask(client)
        except ConnectionException as error:
            # What Modbus' client makes of an error of the port.
            found = error.__context__
            if isinstance(found, OSError) and not isinstance(found, serial.SerialTimeoutException):
                raise self.gone(found) from None
            raise HostError(self._silence()) from None
        except (ModbusException, struct.error):
            return None
        except OSError as error:
            raise self.gone(error) from None

    def gone(self, error: BaseException) -> HostError:
        """What an error of the port is to a user."""
        return HostError(f"{self._port}: {_reason(error)}; was it unplugged?")

    def _settled(self, line: Line) -> bool:
        """Whether nothing of earlier questions can come any more.

        Answers come in the order of the questions, so all are over with that to a question whose
        answer is like no other: the identification, of another length than the last time.
        """
        self._drain(line)
        self._probes = self._probes % len(modbus.IDENTIFICATION) + 1
        question = ReadHoldingRegistersRequest(address=0, count=2 * self._probes, dev_id=self._unit)
        head = bytes([self._unit, _READ, 4 * self._probes])
        if self._known:
            head += table.crc().to_bytes(4, "big")
        line.write(FramerRTU(DecodePDU(False)).buildFrame(question))
        found, until = b"", time.monotonic() + self._timeout_s
        while time.monotonic() < until:
            found += line.read(line.in_waiting)
            self._listen(False, found)
            first = found.find(head)
            last = first + 3 + 4 * self._probes
            crc = found[last : last + 2]
            if first >= 0 and len(crc) == 2 and FramerRTU.check_CRC(
                found[first:last], int.from_bytes(crc, "big")
            ):  # fmt: skip
                self._astray = False
                return True
            time.sleep(1e-3)
        return False

    def _drain(self, line: Line) -> None:
        """Throw away what comes, until the line is silent, or always babbles."""
        until = time.monotonic() + self._timeout_s
        silent = time.monotonic()
        while time.monotonic() < min(until, silent + _SILENT_S):
            if line.in_waiting:
                line.read(line.in_waiting)
                silent = time.monotonic()
            time.sleep(1e-3)

    def _listen(self, sending: bool, data: bytes) -> bytes:
        if not sending:
            self._heard = max(self._heard, len(data))
        return data

    def _silence(self) -> str:
        if self._heard:
            return (
                f"{self._port}: {self._heard} bytes came, but no answer with a right CRC; is it "
                f"unit {self._unit}, at {self._baud} bits a second, and nobody else on the line?"
            )
        return (
            f"{self._port}: no answer within {self._timeout_s:g} s; is it the right port, the "
            f"device on and of unit {self._unit}? A simulated one may need a longer --timeout"
        )

    def _taken(self) -> serial.Serial:
        """The port, once nobody else has it."""
        until = time.monotonic() + self._timeout_s
        with _next(self._port, until):
            while True:
                try:
                    return serial.Serial(
                        self._port, BAUD, timeout=self._timeout_s, write_timeout=self._timeout_s,
                        exclusive=True,
                    )  # fmt: skip
                except (OSError, ValueError, termios.error) as error:
                    if not _is_busy(error) or time.monotonic() > until:
                        raise HostError(f"{self._port}: {self._closed(error)}") from None
                time.sleep(_TURN_S)

    def _closed(self, error: Exception) -> str:
        """Why the port can't be opened, and the cure."""
        with suppress(OSError, ValueError):
            if not stat.S_ISCHR(os.stat(self._port).st_mode):
                return "is no serial port; name the device's with --port"
        number = _number(error)
        if number == errno.ENOTTY:
            return "is no serial port; name the device's with --port"
        if _is_busy(error):
            return "can't be opened: somebody else has it; name the port with --port"
        cure = "was it unplugged?"
        if number in (errno.EACCES, errno.EPERM):
            cure = "let your user into the port's group, which often is dialout"
        elif not self._known:
            cure = "is it plugged in? Else name its port with --port"
        return f"can't be opened: {_reason(error)}; {cure}"


@contextmanager
def _next(port: str, until: float) -> Iterator[None]:
    """The place of the one who waits for a port; without it as well once the time is up.

    Whoever has just had the port finds it taken by those who wait, so none is ever passed by. It is
    a name of the kernel's, which is free again when its process is gone, however it went.
    """
    with socket.socket(socket.AF_UNIX) as place:
        while time.monotonic() < until and not _is_next(place, port):
            time.sleep(_TURN_S)
        yield


def _is_next(place: socket.socket, port: str) -> bool:
    """Take the place of the one who waits for a port, if nobody has it."""
    try:
        place.bind(f"\0wavehaptics waits for {os.path.realpath(port)}")
    except OSError:
        return False
    return True


def _number(error: BaseException | None) -> int | None:
    """``errno`` of an error, or of that which pyserial has made a text of."""
    while error is not None:
        number = error.args[0] if error.args else None
        if isinstance(number, int):
            return number
        error = error.__context__
    return None


def _is_busy(error: Exception) -> bool:
    """Whether somebody else has the port for himself."""
    return _number(error) in (errno.EWOULDBLOCK, errno.EBUSY)


def _reason(error: BaseException) -> str:
    number = _number(error)
    if number is not None:
        return os.strerror(number)
    # Of a port that has gone pyserial says that it reads nothing.
    return str(error) if isinstance(error, ValueError) else "the line has ended"
