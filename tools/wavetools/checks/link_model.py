# SPDX-License-Identifier: Apache-2.0
"""What the link has to do with the bytes that it receives, as docs/link.md says it.

It knows nothing of how rtl/wh_modbus.v does it: bytes with their times go in, and out come the
words that have to be written, in turn, and the answers. A byte of an answer that nobody can know,
of a live word, is None.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version

from pymodbus.framer import FramerRTU
from wavehaptics.words import table
from wavehaptics.words.places import Place, places
from wavehaptics.words.table import MEMORY, WORDS, Sizes

FUNCTION, ADDRESS, VALUE = 1, 2, 3
"""Exceptions."""

FIRST_REGISTER, LAST_REGISTER = 0x2000, 0x3FFF
"""Of the table."""

RATE, COUNTERS = 0x0A, 0x10
OBJECTS = {0: b"wave haptics", 1: b"controller", 2: f"v{version('wavehaptics')}".encode()}
"""What function 43/14 tells."""
COMMIT, DISCARD = WORDS["commit"].at(), WORDS["discard"].at()
UNDER_WAY = WORDS["settings_busy"].at()
LONGEST = 256
"""Bytes of a frame."""

Answer = list["int | None"]


class Undecided(RuntimeError):
    """A pause that may or may not be a silence."""


class Refused(Exception):
    """An exception's code, or one of several."""

    def __init__(self, *codes: int) -> None:
        super().__init__(*codes)
        self.codes = set(codes)


def crc(data: bytes) -> bytes:
    """The two bytes that end a frame."""
    return FramerRTU.compute_CRC(data).to_bytes(2, "big")


class Slave:
    """A link at rest, the bridges off. ``identity`` are the words of its registers 0 to 15."""

    def __init__(self, sizes: Sizes, identity: Sequence[int], unit: int, silence: int) -> None:
        self.identity, self.unit, self.silence = list(identity), unit, silence
        self.places: dict[int, Place] = {
            place.address: place
            for kind in ("setting", "command", "live")
            for place in places(sizes, kind)
        }
        self.memory = {
            address: place.word.default & 0xFFFFFFFF
            for address, place in self.places.items()
            if place.word.row.kind == "setting"
        }
        self.rate = 0
        self.frames = self.crcs = self.framings = self.overruns = 0
        self.written: list[int] = []
        self.answers: list[tuple[Answer, set[int]]] = []
        """Answers, each with the exceptions that may stand in it."""
        self._frame = bytearray()
        self._skips = False
        self._last = 0

    # ---- The line.

    def receive(self, clock: int, data: int, broken: bool) -> None:
        """A byte, or something that has no stop bit."""
        pause = clock - self._last
        self._last = clock
        if pause > 2 * self.silence:
            self.rest()
        elif pause >= self.silence and (self._frame or self._skips):
            raise Undecided
        if broken:
            self.framings += 1
            self._skip()
        if self._skips:
            return
        self._frame.append(data)
        if len(self._frame) == self._whole():
            if self._is_right():
                self._act(bytes(self._frame))
                self._frame.clear()
            else:
                self.crcs += 1
                self._skip()
        elif len(self._frame) == LONGEST:
            self.overruns += 1
            self._skip()

    def rest(self) -> None:
        """Silence."""
        if self._frame:
            if self._whole() is None and len(self._frame) >= 4 and self._is_right():
                self._act(bytes(self._frame))
            else:
                self.crcs += 1
        self._frame.clear()
        self._skips = False

    def _skip(self) -> None:
        self._frame.clear()
        self._skips = True

    def _is_right(self) -> bool:
        return crc(bytes(self._frame[:-2])) == self._frame[-2:]

    def _whole(self) -> int | None:
        """Bytes of the frame, as far as its beginning says; of unknown ones silence is the end."""
        frame = self._frame
        if len(frame) < 2:
            return LONGEST
        function = frame[1]
        if function in (3, 4, 6):
            return 8
        if function == 16:
            return LONGEST if len(frame) < 7 else 9 + frame[6] if frame[6] < 248 else None
        if function == 43:
            return LONGEST if len(frame) < 3 else 7 if frame[2] == 14 else None
        return None

    # ---- Frames.

    def _act(self, frame: bytes) -> None:
        unit, pdu = frame[0], frame[1:-2]
        if unit not in (0, self.unit):
            return
        self.frames += 1
        codes: set[int] = set()
        try:
            body = self._reply(pdu, unit == 0)
        except Refused as refused:
            codes = refused.codes
            body = [pdu[0] | 0x80, None]
        if unit:
            self.answers.append(([unit, *body], codes))

    def _reply(self, pdu: bytes, for_all: bool) -> Answer:
        function, address = pdu[0], int.from_bytes(pdu[1:3], "big")
        second = int.from_bytes(pdu[3:5], "big")
        if function in (3, 4):
            if for_all:
                return []
            if not 1 <= second <= 125:
                raise Refused(VALUE)
            data = [half for at in range(address, address + second) for half in self._register(at)]
            return [function, len(data), *data]
        if function == 6:
            if not address & 1:
                raise Refused(ADDRESS)
            place = self.places.get(self._address(address))
            sign = place is not None and place.word.fixed.signed and second >> 15
            self._write(address - 1, [second | (0xFFFF0000 if sign else 0)])
            return [*pdu]
        if function == 16 and pdu[5] < 248:
            if not 1 <= second <= 122 or second & 1 or pdu[5] != 2 * second:
                raise Refused(VALUE)
            if address & 1:
                raise Refused(ADDRESS)
            values = [int.from_bytes(pdu[n : n + 4], "big") for n in range(6, len(pdu), 4)]
            self._write(address, values)
            return [*pdu[:5]]
        if function == 16:
            raise Refused(VALUE)
        if function == 43 and pdu[1:2] == b"\x0e":
            if not 1 <= pdu[2] <= 3:
                raise Refused(VALUE)
            first = pdu[3] if pdu[3] in OBJECTS else 0
            told = {number: text for number, text in OBJECTS.items() if number >= first}
            head = [43, 14, pdu[2], 1, 0, 0, len(told)]
            return head + [
                part for number, text in told.items() for part in (number, len(text), *text)
            ]
        raise Refused(FUNCTION)

    @staticmethod
    def _address(register: int) -> int:
        """Of a word of the table; -1 of any other register."""
        if not FIRST_REGISTER <= register <= LAST_REGISTER:
            return -1
        return (register - FIRST_REGISTER) >> 1

    def _register(self, register: int) -> Answer:
        """Its two bytes."""
        counters = (self.frames, self.crcs, self.framings, self.overruns)
        own = [*self.identity, *counters]
        if register < 2 * len(own):
            word: int | None = self.rate if register >> 1 == RATE >> 1 else own[register >> 1]
        else:
            place = self.places.get(self._address(register))
            if place is None or place.word.row.kind == "command":
                raise Refused(ADDRESS)
            word = self.memory.get(place.address)
            if place.word.block == MEMORY:
                # Nothing waits; words may still be under way that were just written.
                word = None if place.address == UNDER_WAY else 0
        if word is None:
            return [None, None]
        half = word & 0xFFFF if register & 1 else word >> 16 & 0xFFFF
        return [half >> 8, half & 0xFF]

    def _write(self, register: int, values: list[int]) -> None:
        """All words or none."""
        codes: set[int] = set()
        for at, value in zip(range(register, 1 << 17, 2), values, strict=False):
            code = self._judge(at, value)
            if code:
                codes.add(code)
        if codes:
            raise Refused(*codes)
        settings = False
        for at, value in zip(range(register, 1 << 17, 2), values, strict=False):
            if at == RATE:
                self.rate = value
                continue
            address = self._address(at)
            self.written += [address, value]
            if address in self.memory:
                self.memory[address] = value
                settings = True
        if settings:
            self.written += [COMMIT, 1]

    def _judge(self, register: int, value: int) -> int:
        """What a word is refused with, 0 for nothing."""
        if register == RATE:
            return 0 if value < self.identity[7] else VALUE
        place = self.places.get(self._address(register))
        if place is None or place.word.row.kind == "live" or place.address in (COMMIT, DISCARD):
            return ADDRESS
        low, high = place.limits
        signed = value - (1 << 32) if place.word.fixed.signed and value >> 31 else value
        return 0 if low <= signed <= high else VALUE


def identity(sizes: Sizes, options: int, build: int, clock_hz: int, rates: int) -> list[int]:
    """The words of registers 0 to 15."""
    return [table.crc(), build, options, clock_hz, sizes.motors, 0, 1, rates]
