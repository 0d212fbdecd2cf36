# SPDX-License-Identifier: Apache-2.0
"""A port on which a device frames its answers, as docs/link.md has it while it streams."""

from __future__ import annotations

import select
import threading
from collections.abc import Callable

import serial
from pymodbus.framer import FramerRTU

FIRST_PACKET = 248
"""From here on a frame's first byte is no unit, but a packet's."""

_POLL_S = 0.02


def unstuffed(frame: bytes) -> bytes | None:
    """What a frame of COBS, without the zero at its end, stands for; None of one that is broken."""
    found, place = bytearray(), 0
    while place < len(frame):
        code = frame[place]
        piece = frame[place + 1 : place + code]
        if len(piece) != code - 1:
            return None
        place += code
        found += piece
        if code < 255 and place < len(frame):
            found.append(0)
    return bytes(found)


def is_right(data: bytes) -> bool:
    """Whether the two bytes at the end are the CRC of those before."""
    return len(data) > 2 and FramerRTU.check_CRC(data[:-2], int.from_bytes(data[-2:], "big"))


class FramedLine:
    """A serial port as a Modbus client wants it, of which a thread reads.

    ``packet`` is called by the thread with each packet whose CRC is right; answers are what
    :meth:`read` gives. ``question`` is sent every ``every_s``, and its answer, an echo of six bytes
    and the CRC, is kept from the client. One that comes without a frame says that frames are over:
    ``lapsed``. ``broken`` counts frames that can't be read, and ``error`` is why nothing comes any
    more.
    """

    def __init__(self, line: serial.Serial, packet: Callable[[bytes], None]) -> None:
        self._line, self._packet = line, packet
        self._answers = bytearray()
        self._buffer = bytearray()
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._threads = [threading.Thread(target=self._listen, daemon=True)]
        self._question = self._echo = b""
        self._owed = 0  # echoes that are to come
        self._waits = False  # for the last one
        self._ending = False
        self._ended = threading.Event()
        self.broken = 0
        self.lapsed = False
        self.error: OSError | None = None
        self._threads[0].start()

    # ---- What a Modbus client asks of a port.

    is_open = True

    @property
    def in_waiting(self) -> int:
        """Bytes of answers."""
        if self.error is not None:
            raise self.error
        return len(self._answers)

    def read(self, size: int = 1) -> bytes:
        """Bytes of answers that are there, up to so many."""
        with self._lock:
            found = bytes(self._answers[:size])
            del self._answers[:size]
        return found

    def write(self, data: bytes) -> int | None:
        """Send a question, in one piece."""
        with self._lock:
            written: int | None = self._line.write(data)
            return written

    def close(self) -> None:
        """The port stays open: it belongs to whoever gave it."""

    # ---- Frames.

    def renew(self, question: bytes, every_s: float) -> None:
        """Send a write of a word from now on, every so often."""
        self._question, self._echo = question, echo(question)
        self._threads.append(threading.Thread(target=self._renew, args=(every_s,), daemon=True))
        self._threads[-1].start()

    def _renew(self, every_s: float) -> None:
        """One waits for the echo of the one before, each time for twice as long as the last.

        A simulated board can stand still for seconds: what has gathered before its line then is
        less than the device keeps.
        """
        most = passed = 1
        while not self._closing.wait(every_s) and not self.lapsed and self.error is None:
            if self._waits and passed < most:
                passed += 1
                continue
            most, passed = (2 * most if self._waits else 2), 1
            with self._lock:
                self._owed, self._waits = self._owed + 1, True
                self._send(self._question)

    def _send(self, question: bytes) -> None:
        try:
            self._line.write(question)
        except OSError as error:
            self._fail(error)

    def _fail(self, error: OSError) -> None:
        """Nothing comes any more, and nobody has to wait for it."""
        self.error = self.error or error
        self._ended.set()

    def end(self, question: bytes, timeout_s: float) -> bool:
        """Send the question that ends the frames; whether it was answered, without a frame.

        The port is then whoever's it was. What goes wrong is in ``error``.
        """
        self._closing.set()
        for thread in self._threads[1:]:
            thread.join()
        if self.error is None and not self.lapsed:
            with self._lock:
                self._echo, self._ending = echo(question), True
                self._send(question)
            self._ended.wait(timeout_s)
        answered = self._ended.is_set()
        self._ended.set()
        self._threads[0].join()
        return answered and self.error is None

    def _listen(self) -> None:
        """The thread that reads, until the frames are over."""
        while not self._ended.is_set():
            try:
                if not select.select([self._line], [], [], _POLL_S)[0]:
                    continue
                # One that has gone seems to have bytes, and has none.
                data = self._line.read(max(1, self._line.in_waiting))
            except OSError as error:
                self._fail(error)
                return
            except TypeError:  # pyserial, of a port that was closed meanwhile
                self._fail(OSError("the port was closed"))
                return
            with self._lock:
                self._buffer += data
                self._take()

    def _take(self) -> None:
        """What the buffer holds: whole frames, and behind them a plain answer."""
        head = self._echo.partition(b"\0")[0]
        while True:
            if head and self._buffer.startswith(head + b"\0"):
                if len(self._buffer) < len(self._echo):
                    return
                if self._buffer.startswith(self._echo):
                    self._buffer.clear()
                    self.lapsed = not self._ending
                    self._ended.set()
                    return
            frame, zero, rest = self._buffer.partition(b"\0")
            if not zero:
                return
            self._buffer = rest
            self._frame(bytes(frame))

    def _frame(self, frame: bytes) -> None:
        found = unstuffed(frame)
        if found is None or not is_right(found):
            self.broken += 1
        elif found[0] >= FIRST_PACKET:
            self._packet(found)
        elif self._owed and found == self._echo:
            self._owed, self._waits = self._owed - 1, False
        else:
            self._answers += found


def echo(question: bytes) -> bytes:
    """The answer to a write by function 16."""
    head = question[:6]
    return head + FramerRTU.compute_CRC(head).to_bytes(2, "big")
