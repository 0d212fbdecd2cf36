# SPDX-License-Identifier: Apache-2.0
"""The soak of the link: it finds nothing, and finds what is planted."""

from __future__ import annotations

import pytest
from wavetools.checks import link_soak
from wavetools.checks.link_model import Slave, Undecided
from wavetools.checks.link_soak import Burst, Failure, Line, framed, read, write

KINDS, COUNT = 4, 100_000


def test_nothing_is_found():
    found = link_soak.soak(5, COUNT, KINDS)
    print(found)
    assert found["wrong"] is None
    assert found["bytes"] > COUNT
    assert found["bursts"] > 500
    assert found["frames"] > 500
    assert found["crcs"] > 100
    assert found["overruns"] > 0


def planted(monkeypatch: pytest.MonkeyPatch, name: str, change) -> str | None:
    """What the soak says beside a model with another method."""
    told = getattr(Slave, name)
    monkeypatch.setattr(Slave, name, lambda self, *given: change(told, self, *given))
    return link_soak.soak(5, COUNT, 0)["wrong"]


def test_a_word_that_is_not_written_is_found(monkeypatch):
    def other(told, self, register, values):
        told(self, register, values)
        del self.written[-2:]

    assert "written" in planted(monkeypatch, "_write", other)


def test_a_frame_that_is_not_counted_is_found(monkeypatch):
    def other(told, self):
        before = self.crcs
        told(self)
        self.crcs = before

    assert "answer" in planted(monkeypatch, "rest", other)


def test_another_exception_is_found(monkeypatch):
    assert "exception" in planted(
        monkeypatch, "_judge", lambda told, self, *given: 4 if told(self, *given) else 0
    )


def test_a_byte_that_gets_lost_is_found():
    line = Line()
    try:
        line.go(Burst(read(0, 4)))
        line.send(Burst(b"\x01\x03", factor=1.2))
        with pytest.raises(Failure, match="what was received"):
            line.settle(Burst(b"\x01\x03"))
    finally:
        line.close()


def test_a_pause_between_short_and_long_is_undecided():
    line = Line()
    try:
        frame = read(0, 4)
        with pytest.raises(Undecided):
            line.go(Burst(frame, [0, link_soak.SILENCE + 100] + [0] * 6))
    finally:
        line.close()


def test_frames_are_those_of_the_standard():
    assert read(0x006B, 3).hex() == "0103006b00037417"
    assert write(1, [0x000A0102], unit=17).hex()[:14] == "11100001000204"
    assert framed(b"\x11\x03\x00\x6b\x00\x03").hex() == "1103006b00037687"


def test_the_tasks_cover_the_bytes():
    tasks = link_soak.tasks(1_000_001, seed=7)
    assert sum(task.arguments["count"] for task in tasks) >= 1_000_001
    assert sum(task.arguments["frames"] > 0 for task in tasks) == 1
    one = {"seed": 1, "bytes": 10, "wrong": None}
    two = {"seed": 2, "bytes": 5, "wrong": "burst 3: something"}
    assert link_soak.summary([one, two]) == {"bytes": 15, "wrong": ["seed 2, burst 3: something"]}
