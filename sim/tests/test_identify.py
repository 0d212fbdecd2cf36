# SPDX-License-Identifier: Apache-2.0
"""Motors identified over the link: what is found, and what is told where the wiring is wrong."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest
import tomllib
from quick_board import QuickBoard
from virtual_boards import told, virtual_board
from wavehaptics.host import capture, session
from wavehaptics.host.client import Identification
from wavehaptics.host.identify import encoder, result
from wavehaptics.host.identify.brushed import Found
from wavehaptics.host.identify.driver import Driver, EndedError
from wavehaptics.host.identify.identification import identify, try_signs
from wavehaptics.host.identify.segments import Estimate, Segment, best_harmonic, earlier, harmonics
from wavehaptics.host.identify.steps import NotPlausible, Wishes
from wavehaptics.host.names import HostError, Place
from wavehaptics.ladder.run import measure
from wavehaptics.parts.motors import PRESETS
from wavehaptics.scene import Scene, load_scene
from wavehaptics.words import formats, modbus, table

COUNTS = 10_000
REAL = (
    f"encoder.counts_per_rev={COUNTS}", "adc.bits=12", "adc.full_scale_a=2.5", "adc.noise_a=2e-3",
    "adc.offset_a=20e-3", "brushes.drop_v=0.3", "brushes.segments=11", "brushes.ripple=0.03",
    "friction.coulomb_nm=3e-4", "friction.viscous=1e-6", "drive.limit_v=12",
)  # fmt: skip
"""A converter with noise and offset, brushes of 0.3 V, R(θ) ±3 %, friction."""

MOTORS = {
    "re25-118743": ("motor.preset=re25-118743", "cogging.torque_nm=1e-3", "cogging.per_rev=14"),
    "re25-phantom": ("motor.preset=re25-phantom", "brushes.segments=9"),
    "re30-48v": ("motor.preset=re30-48v", "drive.limit_v=24"),
    "re40-148877": ("motor.preset=re40-148877", "drive.limit_v=24", "adc.full_scale_a=5"),
    "small": ("motor.R_ohm=12", "motor.L_h=0.7e-3", "motor.k_t=9e-3", "motor.J_kgm2=1e-7",
              "friction.coulomb_nm=1e-4", "encoder.counts_per_rev=2000",
              "adc.full_scale_a=1"),
    "slow tick": ("motor.R_ohm=0.6", "motor.L_h=0.3e-3", "motor.k_t=40e-3", "motor.J_kgm2=6e-6",
                  "controller.tick_hz=5e5", "adc.full_scale_a=6", "drive.gain_error=0",
                  "encoder.counts_per_rev=40000"),
}  # fmt: skip

SETTINGS = {name for name, word in table.WORDS.items() if word.row.kind == "setting"}

Maker = Callable[..., Scene]


@pytest.fixture(autouse=True)
def _impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A board that answers at once needs no pause."""
    monkeypatch.setattr(capture, "_POLL_S", 0.0)


def identified(
    scene: Scene, *, counts: int | None = None, expect: str | None = None,
    current: float | None = None, travel: float | None = None, **board: object,
) -> tuple[Found, QuickBoard, Driver]:  # fmt: skip
    quick = QuickBoard(scene, **board)
    driver = Driver(quick, clock=lambda: quick.time_s)
    counts = scene.encoder.counts_per_rev if counts is None else counts
    expected = PRESETS[expect] if expect else None
    return identify(driver, Wishes(counts, current, travel, expected)), quick, driver


@pytest.mark.parametrize("name", MOTORS)
def test_motors(make_scene: Maker, name: str):
    """Every value near the true one, and as near as its spread says."""
    scene = make_scene(*REAL, *MOTORS[name])
    found, _, _ = identified(scene)
    motor, friction, brushes = scene.motor, scene.friction, scene.brushes
    for what, estimate, true, part in (
        ("R", found.resistance.ohm, motor.R_ohm, 0.005),
        ("V_b", found.resistance.drop_v, brushes.drop_v, 0.1),
        ("ripple", found.resistance.ripple, brushes.ripple, 0.1),
        ("L", found.inductance, motor.L_h, 0.03),
        ("k_T", found.back_emf.k_t, motor.k_t, 0.03),
        ("forward", found.back_emf.forward, motor.k_t, 0.03),
        ("backward", found.back_emf.backward, motor.k_t, 0.03),
        ("J", found.mechanics.inertia, motor.J_kgm2, 0.1),
        ("friction", found.mechanics.coulomb, friction.coulomb_nm, 0.2),
    ):
        assert estimate.value == pytest.approx(true, rel=part), what
        assert 0 < estimate.sd < part * true, what
        if what in ("R", "L", "k_T"):
            assert abs(estimate.value - true) < 5 * estimate.sd + 5e-4 * true, what
    assert found.resistance.segments == brushes.segments
    assert found.mechanics.per_rev == (scene.cogging.per_rev if scene.cogging else 0)
    assert found.offset_a.value == pytest.approx(scene.adc.offset_a, abs=2e-3)


@pytest.mark.parametrize("noise_a", ["0", "0.5e-3"])
@pytest.mark.parametrize(
    "sets",
    [
        ("motor.R_ohm=20", "motor.L_h=2e-3", "motor.k_t=0.1", "motor.J_kgm2=6e-6",
         "controller.tick_hz=5e4", "encoder.counts_per_rev=40000", "brushes.segments=9",
         "friction.coulomb_nm=1.5e-3", "cogging.torque_nm=1e-3", "cogging.per_rev=12",
         "drive.limit_v=44", "adc.full_scale_a=2"),
        ("motor.R_ohm=10", "motor.L_h=0.1e-3", "motor.k_t=10e-3", "motor.J_kgm2=1e-7",
         "controller.tick_hz=2.5e5", "encoder.counts_per_rev=16384", "brushes.segments=7",
         "drive.limit_v=11", "adc.full_scale_a=1"),
    ],
)  # fmt: skip
def test_a_winding_of_few_ticks(make_scene: Maker, sets: tuple[str, ...], noise_a: str):
    """L/R is 5 and 2.5 ticks. The first one has cogging, too little beside friction to be found.

    Records of the step that went on for a dozen time constants told of friction as of L.
    """
    scene = make_scene(*REAL, *sets, f"adc.noise_a={noise_a}")
    found, _, _ = identified(scene)
    motor = scene.motor
    assert found.resistance.ohm.value == pytest.approx(motor.R_ohm, rel=0.005)
    assert found.inductance.value == pytest.approx(motor.L_h, rel=0.015)
    assert found.back_emf.k_t.value == pytest.approx(motor.k_t, rel=0.005)
    assert found.mechanics.inertia.value == pytest.approx(motor.J_kgm2, rel=0.02)


def test_a_current_that_is_noise_is_refused(make_scene: Maker):
    scene = make_scene(*REAL, "adc.noise_a=5e-3")
    with pytest.raises(HostError, match=r"--current 0\.01 A is too little beside .*; take 0\.0\d+"):
        identified(scene, current=0.01)


@pytest.mark.parametrize(
    ("name", "beside"),
    [
        ("m.toml", "m.words.toml"),
        ("m.left", "m.left.words.toml"),
        ('a"b\\c.toml', 'a"b\\c.words.toml'),
    ],
)
def test_names_of_what_is_written(make_scene: Maker, tmp_path: Path, name: str, beside: str):
    found, _, driver = identified(make_scene(*REAL))
    paths = result.write(found, driver, tmp_path / name, 0)
    assert [path.name for path in paths] == [name, beside]
    assert load_scene(paths[0]).motor.R_ohm == pytest.approx(found.resistance.ohm.value, rel=1e-3)
    assert session.read(paths[1], driver.shape)


def test_the_board_is_left_as_it_was(make_scene: Maker, tmp_path: Path):
    """Disarmed, with the settings of before; and what is found goes back into scene and device."""
    scene = make_scene(*REAL)
    quick = QuickBoard(scene)
    before = dict(quick.settings)
    driver = Driver(quick, clock=lambda: quick.time_s)
    told: list[str] = []
    found = identify(driver, Wishes(COUNTS), told.append)
    assert not quick.running
    changed = {name[0] for name, raw in quick.settings.items() if before[name] != raw}
    assert changed & SETTINGS == set()
    assert [line.split(":")[0] for line in told] == [
        "zero", "sign", "pulses", "coasting", "steps", "R", "k_T", "J", "L"
    ]  # fmt: skip
    path, beside = result.write(found, driver, tmp_path / "motor.toml", 0)
    again = load_scene(path)
    assert again.motor.R_ohm == pytest.approx(found.resistance.ohm.value, rel=1e-3)
    assert again.brushes.drop_v == pytest.approx(0.3, rel=0.1)
    assert again.controller.tick_hz == pytest.approx(scene.controller.tick_hz)
    assert again.controller.lambda_ == pytest.approx(scene.controller.lambda_, rel=1e-3)
    given = {place.text: place.value(raw & 0xFFFFFFFF)
             for place, raw in session.read(beside, quick.shape)}  # fmt: skip
    assert given["root"] == pytest.approx((2 * found.resistance.ohm.value) ** 0.5, rel=1e-3)
    assert given["root"] * given["u_max"] == pytest.approx(12, rel=1e-3)
    assert tomllib.loads(path.read_text("utf-8"))["motor"]["J_kgm2"] > 0


def test_progress_from_the_beginning(make_scene: Maker):
    """Each stage says what it is before it is made, and how far it is, in simulated time."""
    quick = QuickBoard(make_scene(*REAL))
    driver = Driver(quick, clock=lambda: quick.time_s)
    seen: list[tuple[str, float, float]] = []
    told: dict[str, float] = {}

    def shows(stage: str, part: float) -> None:
        seen.append((stage, part, quick.time_s))

    def tells(line: str) -> None:
        told[line.split(":")[0]] = quick.time_s

    identify(driver, Wishes(COUNTS), tells, shows)
    end = quick.time_s
    assert seen[0][2] < 0.1 * end
    stages = list(dict.fromkeys(stage for stage, _, _ in seen))
    assert stages == ["zero", "sign", "pulses", "coasting", "steps"]
    for stage in stages:
        parts = [part for s, part, _ in seen if s == stage]
        assert parts == sorted(parts)
        assert (parts[0], parts[-1]) == (0.0, 1.0)
    # Of those that last: how long they will, before they do.
    for stage in ("pulses", "coasting", "steps"):
        assert told[stage] <= min(at for s, part, at in seen if s == stage and part > 0.0)
    moments = [at for _, _, at in seen] + [end]
    assert max(np.diff(moments)) < 0.15 * end


def test_a_wall_so_identified_holds(make_scene: Maker):
    """A press on the true motor, of which the controller knows what was identified and no more."""
    scene = make_scene(*REAL)
    found, _, _ = identified(scene)
    press = make_scene(
        *REAL, "scene.duration_s=2", "adc.offset_a=4e-3", "hand.path=press",
        "hand.amplitude_rad=0.15", "hand.stiffness=0.1", "hand.damping=0.5e-3",
        "controller.walls=[[0.0, 1.0]]", "controller.lambda=5e5", "controller.anchor_auto=true",
        f"controller.r_hat={found.resistance.ohm.value}",
        f"controller.l_hat={found.inductance.value}",
        f"controller.k_t_hat={found.back_emf.k_t.value}",
    )  # fmt: skip
    held = measure(press, "golden", compare=False)
    cell = 2 * np.pi / COUNTS
    depth = held["peak_torque"] / held["stiffness_predicted"]
    # The anchor's zone leads by a quarter of a count.
    assert abs(held["hold_offset_rad"]) < 1.25 * cell + 0.01 * depth
    assert held["hold_ripple_rms"] < 0.005 * held["peak_torque"]


@pytest.mark.parametrize(
    ("fault", "sets", "others"),
    [
        ("unplugged", (), {"unplugged": True}),
        ("shorted", ("motor.R_ohm=0.02", "motor.L_h=5e-6", "motor.k_t=1e-4"), {}),
        ("jammed", ("friction.coulomb_nm=1",), {}),
        ("encoder reversed", (), {"encoder": -1}),
        ("encoder silent", (), {"encoder": 0}),
        ("wrong counts", (), {"counts": COUNTS // 2, "expect": "re25-118743"}),
        ("wrong motor", (), {"expect": "re40-148877"}),
        ("zero", ("adc.offset_a=0.3",), {}),
    ],
)
def test_faults_by_name(make_scene: Maker, fault: str, sets: tuple[str, ...], others: dict):
    """One line that begins with the fault and says what to check; the bridges are off."""
    with pytest.raises(NotPlausible) as error:
        identified(make_scene(*REAL, *sets), **others)
    assert error.value.fault == fault
    assert re.fullmatch(rf"{fault}: [^\n]+; check [^\n]+", str(error.value))


@pytest.mark.parametrize("name", MOTORS)
def test_signs_in_three_turns(make_scene: Maker, name: str):
    """Told within three turns, most of them by the first voltages; the device is as it was."""
    quick, told = QuickBoard(make_scene(*REAL, *MOTORS[name])), []
    before = dict(quick.settings)
    try_signs(Driver(quick, clock=lambda: quick.time_s), COUNTS, told.append)
    assert told[-2].startswith("sign: right")
    assert told[-1].startswith("encoder's sign: right, by")
    low, high = quick.reach
    assert high - low < 6 * np.pi
    assert not quick.running
    changed = {name[0] for name, raw in quick.settings.items() if before[name] != raw}
    assert changed & SETTINGS == set()


@pytest.mark.parametrize(
    ("fault", "sets", "others"),
    [
        ("unplugged", (), {"unplugged": True}),
        ("jammed", ("friction.coulomb_nm=1",), {}),
        ("encoder reversed", (), {"encoder": -1}),
        ("encoder silent", (), {"encoder": 0}),
    ],
)
def test_wrong_signs_by_name(make_scene: Maker, fault: str, sets: tuple[str, ...], others: dict):
    quick = QuickBoard(make_scene(*REAL, *sets), **others)
    with pytest.raises(NotPlausible) as error:
        try_signs(Driver(quick, clock=lambda: quick.time_s), COUNTS)
    assert error.value.fault == fault
    low, high = quick.reach
    assert high - low < 6 * np.pi


def test_a_wheel_comes_to_rest_before_it_is_judged(make_scene: Maker):
    """Its pulses make a few counts, and it coasts from one into the next."""
    quick = QuickBoard(make_scene(*REAL, "motor.J_kgm2=1e-3"), encoder=-1)
    with pytest.raises(NotPlausible, match=r"^encoder reversed: the rotor goes \d+ counts"):
        try_signs(Driver(quick, clock=lambda: quick.time_s), COUNTS)


def test_a_rotor_that_turns_has_no_sign(make_scene: Maker):
    """Its back-EMF is more than the first voltages."""
    quick, told = QuickBoard(make_scene(*REAL, "motor.J_kgm2=1e-4")), []
    quick.spin(60.0)
    with pytest.raises(NotPlausible, match=r"^turning: "):
        try_signs(Driver(quick, clock=lambda: quick.time_s), COUNTS, told.append)
    assert not any(line.startswith("sign") for line in told)
    assert not quick.running


def test_pulses_that_end_where_they_began_have_no_sign(
    make_scene: Maker, monkeypatch: pytest.MonkeyPatch
):
    quick, told = QuickBoard(make_scene(*REAL)), []
    monkeypatch.setattr(encoder, "counts_along", lambda _, __: -4.0)
    with pytest.raises(NotPlausible, match=r"^encoder's sign: .*too few"):
        try_signs(Driver(quick, clock=lambda: quick.time_s), COUNTS, told.append)
    assert not any("encoder's sign: right" in line for line in told)


def test_a_modulators_scale(make_scene: Maker):
    """Its word of full scale isn't 2¹⁵; the trip's is, and the guard's limit is a word's."""
    quick = QuickBoard(make_scene(*REAL, "adc.full_scale_a=3.2"))
    words, at = dict(quick.identification.words), modbus.OPTIONS["adc"][0]
    quick.identification = Identification(words | {"options": words["options"] | 2 << at})
    unity = 21**3 / 2**14
    changed = {
        "sclk_half_clocks": 2, "sample_clocks": 84, "samples": 2,
        "gain": formats.GAIN.to_raw(3.2 / (2 * unity * 2**15)),
        "trip": round(2.0 / 3.2 * 2**15), "guard_current": 0xFFFF,
    }  # fmt: skip
    for name, raw in changed.items():
        quick.settings[name, 0] = raw
    assert Driver(quick).full_scale_a == pytest.approx(3.2, rel=1e-3)
    assert Driver(quick).most_current() == pytest.approx(0.6 * 2.0, rel=1e-3)
    quick.settings["guard_current", 0] = round(1.5 / 3.2 * unity * 2**15)
    assert Driver(quick).most_current() == pytest.approx(0.6 * 1.5, rel=1e-3)


def test_what_is_asked_for_too_much(make_scene: Maker):
    scene = make_scene(*REAL)
    with pytest.raises(HostError, match=r"--current 5 A is more than the board's settings permit"):
        identified(scene, current=5.0)
    with pytest.raises(HostError, match=r"--travel 1 rad|out of --travel"):
        identified(scene, travel=1.0)


def test_a_board_with_a_button(make_scene: Maker):
    """The line can't arm it; it stays on, without a current in the end."""
    scene = make_scene(*REAL)
    found, quick, driver = identified(scene, switched=True)
    assert not driver.arms
    assert found.resistance.ohm.value == pytest.approx(scene.motor.R_ohm, rel=0.005)
    assert quick.running
    assert abs(quick.current) < 0.05


@pytest.mark.parametrize("encoder", [1, -1])
def test_signs_of_a_board_with_a_button(make_scene: Maker, encoder: int):
    """Whose bridges are on from the first: it is braked before the first voltage."""
    quick, told = QuickBoard(make_scene(*REAL), switched=True, encoder=encoder), []
    driver = Driver(quick, clock=lambda: quick.time_s)
    if encoder == 1:
        try_signs(driver, COUNTS, told.append)
        assert told[-1].startswith("encoder's sign: right, by")
        return
    with pytest.raises(NotPlausible, match=r"^encoder reversed: "):
        try_signs(driver, COUNTS, told.append)


@pytest.mark.parametrize("switched", [False, True])
@pytest.mark.parametrize("deaf", [False, True])
def test_it_is_ended_from_outside(make_scene: Maker, switched: bool, deaf: bool):
    """Settings come back, also where the bridges can't be switched off first."""
    quick, asked = QuickBoard(make_scene(*REAL), switched=switched), []
    before, write = dict(quick.settings), quick.write

    def wrong(words: Iterable[tuple[Place, int]]) -> int:
        given = list(words)
        if deaf and given[0][0].word.name == "arm" and given[0][1] == 0:
            raise HostError("no answer")
        if given[0][0].word.name == "zero" and quick.settings["capture_state", 0]:
            asked.append(True)  # in the midst of a record
        return write(given)

    quick.write = wrong
    driver = Driver(quick, clock=lambda: quick.time_s, ended=lambda: bool(asked))
    with pytest.raises(HostError if deaf and not switched else EndedError):
        identify(driver, Wishes(COUNTS))
    assert asked
    changed = {name[0] for name, raw in quick.settings.items() if before[name] != raw}
    assert changed & SETTINGS == set()
    assert quick.running == (switched or deaf)


def test_little_room(make_scene: Maker):
    """A rotor with room to turn stays within it."""
    scene = make_scene(*REAL)
    travel = 6.0
    found, quick, _ = identified(scene, current=0.3, travel=travel, exchange_s=5e-4)
    low, high = quick.reach
    assert high - low < travel
    assert found.resistance.ohm.value == pytest.approx(2.18, rel=0.01)


def test_a_record():
    """Rows are means; sums and ends are those of the rows' ends."""
    n = np.arange(10.0)
    record = Segment(0.5, n, 2 * n + 1, n, 1.0)
    assert record.t.tolist() == [0.5 * k for k in range(1, 10)]
    assert record.sum(record.voltage)[-1] == 0.5 * sum(range(9))
    assert record.ends.tolist() == [2.0 * k + 2 for k in range(9)]
    assert np.allclose(record.speed, 2.0, atol=0.5)
    assert result.rounded(2.17962, 0.0002) == "2.17962"
    assert result.Row("R", Estimate(2.0, 0.5), 1, "Ω").spread == "0.5"


ROWS = 150
TRIALS = 60
COGGING = 300.0


def spun(rng: np.random.Generator, cogging: float) -> tuple[list, list, list, list]:
    """Records as of a rotor that spins: twenty of short pulses, six in which it coasts far.

    The torque's errors are noise of each record's own, which adds up twice in its position.
    """
    wanted, columns, pairs, free = [], [], [], []
    for span in [*rng.uniform(0.5, 2.0, 20), *rng.uniform(5.0, 20.0, 6)]:
        angle = rng.uniform(0.0, 2 * np.pi) + np.linspace(0.0, span, ROWS)
        waves = np.cumsum(np.cumsum(harmonics(angle), axis=0), axis=0) * span**2 / ROWS**2
        drive = np.cumsum(np.cumsum(rng.choice([-1.0, 1.0]) * (angle < angle[ROWS // 3])))
        error = np.cumsum(np.cumsum(rng.standard_normal(ROWS))) * span**2 / ROWS**2
        wanted.append(drive + error + cogging * (waves[:, 13] @ (0.6, 0.8)))
        columns.append([drive])
        pairs.append(waves)
        free.append(np.arange(float(ROWS)))
    return wanted, columns, pairs, free


def test_a_position_that_came_late():
    """A straight line and a square, by parts of rows either way, and by whole ones."""
    n = np.arange(10.0)
    for late in (0.0, 0.4, 1.0, 2.5, -0.4, -1.7):
        assert earlier(3 * (n + late), late) == pytest.approx(3 * n)
    squares = earlier((n + 0.5) ** 2, 0.5)
    assert squares[1:] == pytest.approx(n[1:] ** 2, abs=0.25)


def test_a_harmonic_is_more_than_the_best_of_noise():
    """The best of all periods explains half of noise often enough; that is no harmonic."""
    rng = np.random.default_rng(1)
    found = [best_harmonic(*spun(rng, 0.0)).periods for _ in range(TRIALS)]
    assert found == [0] * TRIALS


def test_a_harmonic_that_is_there_is_found():
    """Its size to the spread that it is told with, which is no more than the noise leaves."""
    rng = np.random.default_rng(2)
    sizes = []
    for _ in range(TRIALS):
        found = best_harmonic(*spun(rng, COGGING))
        assert found.periods == 14
        sizes.append((found.size.value - COGGING) / found.size.sd)
        assert found.size.sd < 0.05 * COGGING
    assert 0.5 < np.sqrt(np.mean(np.square(sizes))) < 1.5


# ---- Over a line.


def over_the_line(scene: Path, sets: tuple[str, ...], *words: str) -> tuple[int, str, str]:
    """Status, stdout and stderr of an identification of a virtual board."""
    with virtual_board(scene, sets) as port:
        return told(port, "identify", "--counts", str(COUNTS), "--timeout", "60", *words)


SCENE = """
[scene]
name = "virtual"
duration_s = 1.0
[motor]
preset = "re25-118743"
[controller]
tick_hz = 1e6
lambda = 1e4
"""


def test_jammed_over_the_line(tmp_path: Path):
    """The virtual board's rotor is held: one line, and status 2."""
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE)
    status, out, err = over_the_line(scene, (*REAL, "friction.coulomb_nm=1"))
    assert status == 2
    assert re.fullmatch(r"wavehaptics: jammed: [^\n]+\n", err)
    first, second = out.splitlines()[:2]
    assert first == "the rotor turns: seconds on a board, minutes on a simulated one"
    assert second.startswith("zero: ")


@pytest.mark.long
def test_identified_over_the_line(tmp_path: Path):
    """The whole RTL behind its serial line: the table, and the files."""
    scene, file = tmp_path / "scene.toml", tmp_path / "found.toml"
    scene.write_text(SCENE)
    status, out, err = over_the_line(scene, REAL, "--out", str(file), "--expect", "re25-118743")
    assert (status, err) == (0, "")
    assert "k_T" in out
    motor = load_scene(file).motor
    assert motor.R_ohm == pytest.approx(2.18, rel=0.005)
    assert motor.L_h == pytest.approx(0.24e-3, rel=0.03)
    assert motor.k_t == pytest.approx(23.4e-3, rel=0.03)
    assert motor.J_kgm2 == pytest.approx(10.3e-7, rel=0.1)
    assert load_scene(file).brushes.drop_v == pytest.approx(0.3, rel=0.1)


SLOW = """
[scene]
name = "slow"
duration_s = 1.0
[motor]
R_ohm = 0.5
L_h = 80e-6
k_t = 12e-3
J_kgm2 = 1.2e-6
[brushes]
drop_v = 0.4
[friction]
coulomb_nm = 0.6e-3
viscous = 1e-6
[encoder]
counts_per_rev = 10_000
[adc]
bits = 12
full_scale_a = 10
noise_a = 4e-3
offset_a = 30e-3
[drive]
bus_v = 12
limit_v = 9
[controller]
tick_hz = 1e5
clock_hz = 5e6
lambda = 1e6
"""


def test_spreads_over_the_line(tmp_path: Path):
    """What the RTL's words are late by, and what a sample isn't the mean of, is in the spreads.

    A position half a tick too young made R 19 spreads too low, V_b at the samples friction 112.
    """
    scene, file = tmp_path / "slow.toml", tmp_path / "found.toml"
    scene.write_text(SLOW)
    status, _, err = over_the_line(scene, (), "--out", str(file))
    assert (status, err) == (0, "")
    given = re.findall(r"^(\w+) = (\S+) # ± (\S+)$", file.read_text(), re.MULTILINE)
    found = {name: (float(value), float(spread)) for name, value, spread in given}
    true = {
        key: value
        for table in ("motor", "brushes", "friction")
        for key, value in tomllib.loads(SLOW)[table].items()
    }
    assert found.keys() == true.keys()
    for name, (value, spread) in found.items():
        assert abs(value - true[name]) < 4 * spread, name
    for name, part in (("R_ohm", 1e-3), ("L_h", 0.01), ("k_t", 2e-3), ("J_kgm2", 0.02)):
        assert found[name][0] == pytest.approx(true[name], rel=part), name
        assert found[name][1] < 0.5 * part * true[name], name
