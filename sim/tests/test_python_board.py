# SPDX-License-Identifier: Apache-2.0
"""``wh.Board`` on a virtual board: names and units, what it refuses, and that it disarms."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import pytest
import wavehaptics as wh
from wavehaptics.api import boards
from wavehaptics.host.names import Place, Shape
from wavehaptics.runtime.terminals import check_terminals
from wavehaptics.runtime.toolchain import ToolError
from wavehaptics.words.table import WORDS


@pytest.fixture(scope="module")
def board() -> Iterator[wh.Board]:
    try:
        check_terminals()
    except ToolError as error:
        pytest.skip(str(error))
    with wh.Board.virtual(wh.load_scene("live_wall").with_(controller__eta_contact=-0.5)) as there:
        yield there


def test_names_and_units(board):
    """A change of the scene is on the board; copies are a list; every name of the device reads."""
    assert board["eta_contact"] == -0.5
    assert board["wall_min"] == [board[f"wall_min[{n}]"] for n in range(board.client.shape.walls)]
    units = board.units
    assert (units["position"], units["voltage"], units["arm"]) == ("counts", "V", "–")
    assert set(units) < set(WORDS)
    for name in units:
        if WORDS[name].row.kind != "command":
            assert isinstance(board[name], int | float | list), name


def test_set_applies_all_or_nothing(board):
    board.set({"wall_min[1]": 1234}, eta_contact=-0.75)
    assert (board["wall_min[1]"], board["eta_contact"]) == (1234, -0.75)
    for values, told in (
        ({"eta_contact": 0.5, "eta_free": 3.0}, "eta_free = 3.0 is out of range"),
        ({"wall_min": 3}, r"wall_min: which one\? Take wall_min\[0\]\.\.\.wall_min\["),
        ({"position": 3}, "position can't be set"),
        ({"eta_contcat": 3}, "did you mean eta_contact"),
    ):
        with pytest.raises(wh.HostError, match=told):
            board.set(values)
    assert board["eta_contact"] == -0.75
    with pytest.raises(wh.HostError, match="arm can't be read; it is a command"):
        board["arm"]


def test_the_bridges_are_off_at_the_end_of_the_block(board):
    class OwnError(Exception):
        pass

    with board.armed():
        assert board["armed"] == 1
    assert board["armed"] == 0

    def failing_inside() -> None:
        with board.armed():
            assert board["armed"] == 1
            raise OwnError

    with pytest.raises(OwnError):
        failing_inside()
    assert board["armed"] == 0


def test_a_board_that_was_disarmed_meanwhile_says_so(board):
    def disarmed_inside() -> None:
        with board.armed():
            board.disarm()

    with pytest.raises(wh.HostError, match=r"^disarmed: "):
        disarmed_inside()


@pytest.mark.parametrize(("armed", "told"), [(None, []), (1, [1, 0]), (2, [2, 0]), (0, [0])])
def test_what_another_program_armed_stays_on(monkeypatch, armed, told):
    """The end of a block disarms what this object armed, or kept armed, and nothing else."""
    line = Line()
    monkeypatch.setattr(boards, "Client", lambda *_: line)
    with wh.Board("/dev/ttyUSB0") as there:
        there.set(eta_contact=-0.5)
        if armed is not None:
            there.set(arm=armed)
    assert [raw for name, raw in line.written if name == "arm"] == told


class Line:
    """A client that notes what is written."""

    shape = Shape(1, 4, 1, 10)
    identification = SimpleNamespace(options={"arm": 1})

    def __init__(self) -> None:
        self.written: list[tuple[str, int]] = []

    def write(self, words: list[tuple[Place, int]]) -> None:
        self.written += [(place.text, raw) for place, raw in words]


def test_where_there_is_none(tmp_path):
    with pytest.raises(wh.HostError, match="is it plugged in"):
        wh.Board(str(tmp_path / "none"))
    with pytest.raises(wh.SceneError, match="no such scene"):
        wh.Board.virtual("no_such")
