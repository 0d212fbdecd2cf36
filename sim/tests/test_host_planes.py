# SPDX-License-Identifier: Apache-2.0
"""Planes from a host: the frames on the line, what is refused, and the RTL of a virtual board."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import test_client
import wavehaptics as wh
from virtual_boards import told as command
from wavehaptics.controller import surfaces
from wavehaptics.controller.pins_timing import look_clocks, turns_clocks
from wavehaptics.controller.planes import (
    NOT_WHOLE,
    PLANE_ROW,
    as_registers,
    as_writes,
    refused_place,
)
from wavehaptics.controller.ports import controller_ports
from wavehaptics.host.client import Client
from wavehaptics.host.planes import Planes, set_planes, surfaces_state
from wavehaptics.laws.kinematics import matrix_arm, put_tip_force
from wavehaptics.laws.shapes import Shape
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.terminals import check_terminals
from wavehaptics.runtime.toolchain import ToolError
from wavehaptics.words import formats, modbus
from wavehaptics.words.table import WORDS

ONE = 1 << formats.SURFACE.fraction
MOTOR = wh.MotorData(23.4e-3, 0.24e-3, 10_000)
CELL_RAD = 2 * math.pi / 10_000
WINDOW, COMMIT = WORDS["surface_word"].at(), WORDS["surface_commit"].at()
TIMEOUT_S = 1.0
SLOWER = {
    "controller.clock_hz": 20e6, "controller.tick_hz": 20e6 / 416, "drive.pwm_hz": 20e6 / 208,
    "controller.extra_ticks": 1,
}  # fmt: skip
"""With which the three motors of a board have time for eight surfaces, which need 413 clocks.

A slow clock, as a simulated board takes as long for one as for another.
"""


def frame(rng: np.random.Generator, count: int) -> list[tuple[int, int]]:
    """Registers of any words of ``count`` surfaces."""
    planes, vectors = surfaces.new_planes(), surfaces.new_vectors()
    planes[:] = rng.integers(-ONE, ONE, planes.shape)
    vectors[:] = rng.integers(-ONE, ONE, vectors.shape)
    planes[:, surfaces.PRESENT] = 0
    planes[rng.permutation(surfaces.MOST_SURFACES)[:count], surfaces.PRESENT] = 1
    return as_registers(planes, vectors, int(rng.integers(1 << 29)))


class Device(test_client.Board):
    """A device of three motors with surfaces, which keeps the frames that are written."""

    def __init__(self) -> None:
        super().__init__()
        self.frames: list[tuple[dict[int, int], int]] = []
        self.coming: dict[int, int] | None = None
        self.refused = 0
        self.put(2 * modbus.IDENTIFICATION.index("options"), [3 | 4 << 4 | 2 << 11])
        self.put(2 * modbus.IDENTIFICATION.index("motors"), [3])
        values = {"half_clocks": 104, "tick_halves": 4, "extra_ticks": 1, "surfaces": 8}
        for name, raw in values.items():
            self.put(modbus.word_register(WORDS[name].at()), [raw])
        for motor in range(3):
            for name, value in (("root", 2.0), ("a", 0.5), ("current", 0.1 * (motor + 1))):
                word = WORDS[name]
                self.put(modbus.word_register(word.at(motor)), [word.fixed.to_raw(value)])
            self.put(modbus.word_register(WORDS["position"].at(motor)), [1000 * (motor + 1)])

    def _answer(self, question: bytes) -> None:
        _, function, register, count = struct.unpack(">BBHH", question[:6])
        first = (register - modbus.TABLE) // 2
        if function == 16 and WINDOW <= first <= COMMIT:
            raws = modbus.whole(struct.unpack(f">{count}H", question[7:-2]))
            self._take(first, raws)
        super()._answer(question)

    def _take(self, first: int, raws: list[int]) -> None:
        assert first + len(raws) <= COMMIT + 1
        stamp = raws.pop() if first + len(raws) == COMMIT + 1 else None
        while raws:
            head = raws.pop(0)
            run, address = head >> 10 & 63, head & 0x3FF
            if head >> 31:
                self.coming = {}
            if self.coming is not None:
                self.coming |= enumerate(raws[:run], address)
            assert len(raws) >= run
            del raws[:run]
        if stamp is not None:
            if self.coming is None:
                self.refused = 255
            elif not self.refused:
                self.frames.append((self.coming, stamp))
                self.put(modbus.word_register(WORDS["surfaces_stamp"].at()), [stamp])
            self.coming = None
            self.put(modbus.word_register(WORDS["surfaces_refused"].at()), [self.refused])


@pytest.fixture
def device() -> Iterator[Device]:
    found = Device()
    found.start()
    yield found
    found.close()


@pytest.fixture
def client(device: Device) -> Client:
    return Client(device.path, timeout_s=TIMEOUT_S)


@pytest.mark.parametrize("count", range(9))
def test_every_word_of_a_frame_is_written(count):
    """Writes of one frame of Modbus each, that end where the commit is."""
    written = frame(np.random.default_rng(count), count)
    device = Device()
    writes = as_writes(written, 0xBEEF)
    for first, raws in writes:
        assert len(raws) <= modbus.MOST_WRITTEN
        device._take(first, list(raws))
    assert device.frames == [({at: raw & 0xFFFFFFFF for at, raw in written}, 0xBEEF)]
    # One surface, or two with their pair, are one write: what a host sends 1000 times a second.
    assert (len(writes) == 1) == (count <= 2)
    device.close()


def test_the_place_that_was_refused():
    assert refused_place(0) == ""
    rows = {surfaces.pair_row(2, 5): "surface 5 beside 2", 7: "surface 7:",
            surfaces.triple_row(0, 3, 4): "surface 4 beside 0 and 3", 96 + 2 * 6: "surface 6",
            97 + 2 * 6: "surface 6", 112: "velocity"}  # fmt: skip
    for row, told in rows.items():
        assert told in refused_place(128 + row)
    assert refused_place(255) == NOT_WHOLE


def test_a_frame_on_the_line(device, client):
    rng = np.random.default_rng(3)
    for stamp in (0, 1, 0xFFFF):
        written = frame(rng, 4)
        set_planes(client, written, stamp)
        assert device.frames.pop() == ({at: raw & 0xFFFFFFFF for at, raw in written}, stamp)
    # The answer to a frame's end is lost: it is asked again, and the frame is in force.
    written = frame(rng, 2)
    device.instead = [None]
    set_planes(client, written, 5)
    assert device.frames.pop() == ({at: raw & 0xFFFFFFFF for at, raw in written}, 5)
    device.frames.clear()
    device.refused = 128 + 3
    with pytest.raises(wh.HostError, match=r"^planes: the device refuses the vector of surface 3"):
        set_planes(client, frame(rng, 1), 7)
    with pytest.raises(wh.HostError, match=r"^stamp = 65536: it has 16 bits"):
        set_planes(client, frame(rng, 1), 1 << 16)
    assert not device.frames


def test_planes_in_joint_space(device, client):
    """G, d and g of a plane follow from its normal and offset, whatever these are multiplied by."""
    made = Planes(client, [MOTOR] * 3)
    normal, offset = np.array([0.0, 3.0, 4.0]), 0.7
    for factor in (1.0, 1e3):
        stamp = made.set_joint([wh.JointPlane(list(factor * normal), factor * offset)])
        words, told = device.frames.pop()
        assert told == stamp
        plane = 8 * 96
        assert words[plane + 1] >> 8 == 1
        step = formats.SURFACE.step
        direction = np.array([words[plane + 2 + n] * step for n in range(3)])
        assert direction == pytest.approx(normal / 5, abs=2 * step)
        assert [words[n] * step for n in range(3)] == pytest.approx(normal / 5, abs=1e-6)
        # Less half a count of each motor, which a count's middle is beyond its number.
        d = words[plane] + (words[plane + 1] & 0xFF) / 256
        assert d == pytest.approx(offset / 5 / CELL_RAD - 0.5 * direction.sum(), abs=0.01)
    assert stamp == 2
    assert made.set_joint([], stamp=9) == 9
    assert device.frames.pop()[0] == {8 * 112: 0}
    assert made.state == replace(surfaces_state(client), stamp=9)


@pytest.mark.parametrize(
    ("planes", "told"),
    [
        ([wh.JointPlane((1, 0), 0)], "plane 0: its normal has 2 numbers; give 3"),
        ([wh.JointPlane((0, 0, 0), 0)], "plane 0: its normal is .* not all 0"),
        ([wh.JointPlane((math.nan, 0, 1), 0)], "plane 0: its normal is .*finite"),
        ([wh.JointPlane((0, 0, 1), math.inf)], "plane 0: .*finite"),
        ([wh.JointPlane((0, 0, 1), 0, stiffness=-1.0)], "surface 0: stiffness = -1.0"),
        ([wh.JointPlane((0, 0, 1), 0, loss=1.5)], "surface 0: .*loss = 1.5"),
        ([wh.JointPlane((0, 0, 1), 0)] * 9, "9 surfaces, and the device can have 8"),
    ],
)
def test_bad_planes_are_one_error(device, client, planes, told):
    made = Planes(client, [MOTOR] * 3)
    with pytest.raises(wh.HostError, match=told) as error:
        made.set_joint(planes)
    assert "\n" not in str(error.value)
    assert not device.frames


def test_planes_set_what_moving_surfaces_may_give_out(device, client):
    """1 mJ in a control period, unless the caller says otherwise."""
    for energy, wanted in (({}, 1e-3), ({"energy": 0.0}, 0.0), ({"energy": 2e-4}, 2e-4)):
        Planes(client, [MOTOR] * 3, **energy)
        assert client.read(["surface_budget"]) == [round(wanted / (416 / 48e6) * 2**16)]


def test_a_damper_is_the_eta_of_a_surface(device, client):
    """(B - b)/(B + b), with B of three equal motors that move the tip by 0.1 m/rad each."""
    made = Planes(client, [MOTOR] * 3, matrix_arm((0.1 * np.eye(3)).tolist()))
    solid = [Shape("plane", np.zeros(3), np.array([0.0, 0.0, 1.0]))]
    own = MOTOR.k_t**2 / 2.0 / 0.1**2
    made.set_shapes(solid, [0.1 / 0.1**2], damping=[3.0 * own])
    words, _ = device.frames.pop()
    raws = [words[8 * (PLANE_ROW + 1) + n] for n in (2, 1)]
    eta, a = (formats.ETA.to_value(raw - (raw >> 31 << 32)) for raw in raws)
    assert (eta, a) == (pytest.approx(-0.5, abs=1e-6), 1.0)
    for damping, told in (([1.0, 2.0], "of each of the 1"), ([-1.0], "surface 0: damping = -1"),
                          ([math.nan], "damping = nan")):  # fmt: skip
        with pytest.raises(wh.HostError, match=told):
            made.set_shapes(solid, [10.0], damping=damping)
    with pytest.raises(wh.HostError, match=r"damping = 1; .* with a stiffness"):
        made.set_shapes(solid, damping=[1.0])
    assert not device.frames


def test_a_device_or_data_that_dont_fit(device, client):
    with pytest.raises(wh.HostError, match="has 3 motors, and the data are of 2"):
        Planes(client, [MOTOR] * 2)
    with pytest.raises(wh.HostError, match="motor 1: k_t = 0"):
        Planes(client, [MOTOR, wh.MotorData(0.0, 1e-3, 100), MOTOR])
    with pytest.raises(wh.HostError, match="there is no arm, so no tip"):
        Planes(client, [MOTOR] * 3).tip()
    device.put(modbus.word_register(WORDS["root"].at(2)), [0])
    with pytest.raises(wh.HostError, match="motor 2: root or a is 0"):
        Planes(client, [MOTOR] * 3)
    device.put(modbus.word_register(WORDS["surfaces"].at()), [0])
    with pytest.raises(wh.HostError, match="has no surfaces; take a bitstream with SURFACES"):
        Planes(client, [MOTOR] * 3)


def test_tip_and_force_of_an_arm(client):
    """Those of the kinematics, at the angles and currents that the device tells."""
    space = wh.load_scene("phantom_plane").device.space
    made = Planes(client, [MOTOR] * 3, space.arm)
    angles = (1000 * np.arange(1, 4) + 0.5) * CELL_RAD
    assert made.angles() == pytest.approx(angles)
    assert made.tip() == pytest.approx(space.arm.tip(angles))
    torque = MOTOR.k_t * 0.1 * np.arange(1, 4)
    jacobian, force = space.arm.jacobian(angles), np.zeros(3)
    put_tip_force(jacobian, torque, force)
    assert np.linalg.norm(force) > 0.01
    assert made.tip_force() == pytest.approx(force, rel=1e-5)
    assert jacobian.T @ made.tip_force() == pytest.approx(torque, rel=1e-5)


# ---- The RTL.


@pytest.fixture(scope="module")
def board() -> Iterator[wh.Board]:
    try:
        check_terminals()
    except ToolError as error:
        pytest.skip(str(error))
    scene = wh.load_scene(ROOT / "boards" / "ulx3s_three" / "board.toml").with_(SLOWER)
    with wh.Board.virtual(scene, surfaces=8) as there:
        yield there


def test_a_virtual_board_meets_planes(board):
    """Beyond a plane of three motors a surface acts; the longest vector is refused, and named."""
    made = board.planes(motors=[MOTOR] * 3)
    assert made.state.surfaces == 8
    with board.armed():
        turns = made.angles()
        across = (1.0, -1.0, 0.5)
        beyond = float(np.dot(across, turns))
        for offset, acting in ((beyond - 0.5, 1), (beyond + 0.5, 0)):
            stamp = made.set_joint([wh.JointPlane(across, offset)])
            assert made.state.acting == acting
            assert made.state.stamp == stamp
        assert board.set_planes([wh.JointPlane(across, beyond - 0.5)], [MOTOR] * 3, stamp=77) == 77
        assert (made.state.acting, made.state.stamp) == (1, 77)
        planes, vectors = surfaces.new_planes(), surfaces.new_vectors()
        planes[2, surfaces.PRESENT], vectors[2, 0], vectors[2, 1] = 1, ONE, 1
        with pytest.raises(wh.HostError, match="refuses the vector of surface 2: it is longer"):
            set_planes(board.client, as_registers(planes, vectors, 0), 78)
        assert made.state.refused
        assert (made.state.acting, made.state.stamp) == (1, 77)


def test_planes_about_the_tip_of_a_virtual_board(board):
    """Solids of a scene's arm: inside one of them a surface acts, and outside none."""
    made = board.planes("phantom_plane")
    arm = wh.load_scene("phantom_plane").device.space.arm
    before, tip, after = arm.tip(made.angles()), made.tip(), arm.tip(made.angles())
    assert np.linalg.norm(tip - before) < 2e-3  # the hands go on meanwhile
    assert np.linalg.norm(tip - after) < 2e-3
    assert np.linalg.norm(tip) > 1e-3
    normal = np.array([0.3, 0.5, 1.0]) / np.linalg.norm([0.3, 0.5, 1.0])
    with board.armed():
        for deep, acting in ((0.01, 1), (-0.01, 0)):
            stamp = made.set_shapes([wh.Shape("plane", tip + deep * normal, normal)])
            assert (made.state.acting, made.state.stamp) == (acting, stamp)
        assert np.isfinite(made.tip_force()).all()
    with pytest.raises(wh.HostError, match=r"has no \[device\]"):
        board.planes("live_wall")
    with pytest.raises(wh.HostError, match="planes of which motors"):
        board.planes()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({}, r"a tick of 102 clocks is shorter than the 413 that `pins` needs for 3 motors with "
             r"8 surfaces; take .* or controller\.tick_hz <= 174031"),
        ({**SLOWER, "controller.extra_ticks": 0}, r"set extra_ticks = 1 or more"),
    ],
)  # fmt: skip
def test_a_period_that_is_too_short(changes, message):
    """Told with the cure, before anything is built."""
    scene = wh.load_scene(ROOT / "boards" / "ulx3s_three" / "board.toml").with_(changes)
    scene = scene.device.scenes[0]
    with pytest.raises(wh.SceneError, match=message):
        controller_ports(scene, turns=3, surfaces=8)


def test_the_delay_of_surfaces():
    """As many ticks with surfaces in contact as without; what a port waits beside is less by it."""
    for extra in (1, 3):
        scene = wh.load_scene(ROOT / "boards" / "ulx3s_three" / "board.toml")
        scene = scene.with_({**SLOWER, "controller.extra_ticks": extra}).device.scenes[0]
        ports = controller_ports(scene, turns=3, surfaces=8)
        assert ports.words["hold_ticks"] == ports.timing.hold_ticks == extra - 1
    # As the header of rtl/wh_ports.v and the table of docs/surfaces.md have it.
    assert turns_clocks(3, surfaces=8) == 413
    assert look_clocks(3, 8)[0] == 64 + 18 + 52


def test_surfaces_of_one_motor():
    status, _, err = command("", "--virtual", "live_wall", "--surfaces", "3")
    assert (status, err) == (
        2, "wavehaptics: --surfaces 3: they are across 2 or 3 motors, and here is 1\n",
    )  # fmt: skip
