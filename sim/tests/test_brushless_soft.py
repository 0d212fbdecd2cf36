# SPDX-License-Identifier: Apache-2.0
"""W on both axes of a brushless motor: what is felt, that no energy comes out, golden = core."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from device_pins import BrushlessDevicePins
from scipy.integrate import solve_ivp
from wavehaptics.controller import wave_core
from wavehaptics.controller.pins_timing import CORE_CLOCKS, SECTION_CLOCKS, turns_latency_clocks
from wavehaptics.controller.rendered import fragment
from wavehaptics.controller.settings import settings
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.brushless import BrushlessSimulation
from wavehaptics.ladder.brushless_pins import BrushlessPinsSimulation
from wavehaptics.ladder.linked_pins import linked_pins
from wavehaptics.ladder.run import CONTROLLERS, measure
from wavehaptics.scene import SCENES_DIR, Scene, SceneError, load_scene
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words import formats

# A gimbal's motor, as its page has it: what the computations below know of it.
R, L, PAIRS, PSI, J = 4.7, 0.96e-3, 7, 3.82e-3, 23e-7
K_T2 = 1.5 * (PAIRS * PSI) ** 2
TICK_S, EXTRA_TICKS = 1e-6, 2
TAU_S = TICK_S / 0.99 + EXTRA_TICKS * TICK_S
"""a is 0.99 where λ asks for more."""
FRONT = K_T2 / (L + R * TAU_S / 2)
"""K_L,eff, N·m/rad: no port is stiffer."""
ANGLES = [math.radians(degrees) for degrees in (0, 45, 117)]

BASE = f"""
[scene]
name = "soft"
duration_s = 0.05
[motor]
kind = "pmsm"
R_ohm = {R}
L_h = {L}
pole_pairs = {PAIRS}
psi_vs = {PSI}
J_kgm2 = {J}
[controller]
tick_hz = 1e6
lambda = 1e9
extra_ticks = {EXTRA_TICKS}
"""
EVERYWHERE = "controller.walls=[[-1000.0, 1000.0]]"
SPRING = ("shaper.feel=spring", "shaper.stiffness=0.22", "shaper.damping=0.1e-3")
TAP = ("hand.path='taps'", "hand.amplitude_rad=0.012", "hand.frequency_hz=20",
       "hand.stiffness=2", "hand.damping=2e-3", "controller.walls=[[0.0, 1.0]]")  # fmt: skip
SENSED = ("encoder.counts_per_rev=10000", "adc.bits=12", "adc.full_scale_a=1", "adc.noise_a=0.5e-3",
          "drive.bus_v=12")  # fmt: skip
SOS = "shaper.sos=[[0.98, -1.9, 0.925, 1.0, -1.92, 0.926], [0.9, 0.02, 0.0, 1.0, 0.01, 0.0]]"
"""Two sections of no feel: what comes in is nearly what goes out."""


@pytest.fixture
def make_scene(tmp_path: Path) -> Callable[..., Scene]:
    """A function that makes a scene of settings on the motor above."""
    path = tmp_path / "scene.toml"
    path.write_text(BASE)
    return lambda *sets: load_scene(path, sets)


def magnets_at(theta: float) -> str:
    """The setting with which x = 0 is the electrical angle ``theta``."""
    return f"motor.magnet_rad={-theta / PAIRS:.12g}"


def run(simulation, duration_s: float) -> tuple[np.ndarray, np.ndarray]:
    rows = np.zeros((round(duration_s / simulation.tick_s), len(Column)))
    words = np.zeros((len(rows), len(Word)), dtype=np.int64)
    simulation.advance(rows, words)
    return rows, words


def behind(stiffness: float) -> float:
    """The spring that feels like ``stiffness`` with the motor's own in front."""
    return 1.0 / (1.0 / stiffness - 1.0 / FRONT)


def felt(theta: float, spring: float, damper: float, amplitude: float, hertz: float, times):
    """(torque, place) of a tapping hand's rotor in the analog circuits, by scipy.

    Either axis is a spring FRONT, which is the winding, in series with a spring and a damper side
    by side. What moves their ends is the magnets' flux along α and β, −sin θ and cos θ of the
    speed, and by the same parts they push back.
    """
    hand_k, hand_b, turn = 2.0, 2e-3, 2 * math.pi * hertz

    def parts(x):
        angle = theta + PAIRS * x
        return np.array([-math.sin(angle), math.cos(angle)])

    def slope(t, y):
        x, omega, force, pressed = y[0], y[1], y[2:4], y[4:6]
        yields = (force - spring * pressed) / damper
        q = parts(x)
        torque = -q @ force
        hand, hand_speed = -amplitude * math.cos(turn * t), amplitude * turn * math.sin(turn * t)
        torque += hand_k * (hand - x) + hand_b * (hand_speed - omega)
        return [omega, torque / J, *(FRONT * (q * omega - yields)), *yields]

    start = [-amplitude, 0.0, 0.0, 0.0, 0.0, 0.0]
    done = solve_ivp(
        slope, (0.0, times[-1]), start, method="Radau", t_eval=times, rtol=1e-8, atol=1e-11
    )
    torque = [-parts(x) @ force for x, force in zip(done.y[0], done.y[2:4].T, strict=True)]
    return np.array(torque), done.y[0]


@pytest.mark.parametrize("theta", ANGLES, ids=["0", "45", "117-degrees"])
@pytest.mark.parametrize(
    ("stiffness", "damper", "amplitude"),
    [(0.22, 0.2e-3, 0.01), (0.22, 0.2e-3, 0.06), (0.6, 1e-3, 0.03)],
)
def test_the_wall_is_the_analog_circuits(make_scene, theta, stiffness, damper, amplitude):
    """A spring with a damper on both axes, up to 0.8 electrical radians deep, within 5·10⁻⁴."""
    hertz, scene = 20.0, make_scene(
        "hand.path='taps'", f"hand.amplitude_rad={amplitude}", "hand.frequency_hz=20",
        "hand.stiffness=2", "hand.damping=2e-3", EVERYWHERE, "shaper.feel=spring",
        f"shaper.stiffness={stiffness}", f"shaper.damping={damper}", magnets_at(theta),
    )  # fmt: skip
    rows, _ = run(BrushlessSimulation(scene, rtl=False), 0.1)
    rows = rows[::50]
    torque, x = felt(theta, behind(stiffness), damper, amplitude, hertz, rows[:, Column.T])
    assert np.abs(torque).max() > 3e-3
    off = np.sqrt(np.mean((rows[:, Column.TORQUE] - torque) ** 2))
    assert off < 5e-4 * np.abs(torque).max()
    assert np.abs(rows[:, Column.X] - x).max() < 1e-4 * np.ptp(x)


@pytest.mark.parametrize("theta", ANGLES, ids=["0", "45", "117-degrees"])
def test_a_soft_wall_is_the_sine_that_a_rigid_one_is(make_scene, theta):
    """Pressed slowly it has K/p·sin(p·depth), from the place where contact began."""
    scene = make_scene(
        "hand.path='press'", "hand.amplitude_rad=0.2", "hand.stiffness=0.2", "hand.damping=2e-3",
        EVERYWHERE, *SPRING, "scene.duration_s=0.12", magnets_at(theta),
    )  # fmt: skip
    rows, _ = run(BrushlessSimulation(scene, rtl=False), 0.12)
    depth = rows[-1, Column.X] + 0.02  # from -A/10, where the hand began
    assert PAIRS * depth > 0.7
    torque = -rows[-1000:, Column.TORQUE].mean()
    assert torque == pytest.approx(0.22 / PAIRS * math.sin(PAIRS * depth), rel=2e-3)
    assert torque < 0.93 * 0.22 * depth


def test_a_mass_is_the_same_at_any_angle(make_scene):
    """Swung slowly through more than an electrical turn, a flywheel of that inertia is felt."""
    mass, damping, hertz = 5e-6, 5e-5, 1.5
    scene = make_scene(
        "hand.path='taps'", "hand.amplitude_rad=0.5", f"hand.frequency_hz={hertz}",
        "hand.stiffness=0.2", "hand.damping=1e-3", EVERYWHERE, "shaper.feel=mass",
        f"shaper.mass_kgm2={mass}", f"shaper.damping={damping}", magnets_at(0.4),
    )  # fmt: skip
    period = round(1.0 / hertz / TICK_S)
    rows, _ = run(BrushlessSimulation(scene, rtl=False), 2.5 / hertz)
    x, torque = rows[-period:, Column.X], rows[-period:, Column.TORQUE]
    assert np.ptp(x) * PAIRS > 2 * math.pi
    turn = 2 * math.pi * hertz
    wave = np.exp(-1j * turn * TICK_S * np.arange(period))
    impedance = -(torque @ wave) / (1j * turn * (x @ wave))
    assert impedance == pytest.approx(damping + 1j * turn * mass, rel=0.01)


def test_what_is_said_of_w_is_for_the_felt_constant(make_scene):
    """√1.5·pψ: what `wavehaptics shaper` finds is off the wish by what the words' places are."""
    scene = make_scene(EVERYWHERE, *SPRING)
    text = fragment(scene, settings(scene), scene.motor.felt_k_t, scene.motor.L_h)
    (percent,) = re.findall(r"off the wish by (\S+) % at most", text)
    assert float(percent) < 1.0


LAYERS = ("controller.walls=[[0.0, 0.006], [0.006, 1.0]]", "shaper.walls=[0]")
DEEP = ("hand.amplitude_rad=0.03", "encoder.counts_per_rev=10000")
ANCHORED = ("controller.anchor_auto=true", "controller.r_hat=5.0", *SENSED)


@pytest.mark.parametrize(
    "sets",
    [
        (*TAP, *SPRING, "adc.bits=12", "adc.full_scale_a=1", "adc.noise_a=1e-3", magnets_at(0.8),
         "encoder.counts_per_rev=10000"),
        (*TAP, *SPRING, *LAYERS, *DEEP, "drive.limit_v=0.4", "controller.edge_hysteresis=true"),
        (*TAP, SOS, *LAYERS, *DEEP, "controller.eta_contact=-0.7", magnets_at(2.0)),
        (*TAP, *SPRING, *LAYERS, *DEEP, *ANCHORED, magnets_at(2.0)),
        (*TAP, SOS, *ANCHORED),
    ],
    ids=["sensed", "layer", "two-sections", "layer-with-anchors", "two-sections-with-anchors"],
)  # fmt: skip
def test_core_is_golden(make_scene, sets):
    """Every bit of every word and row; without anchors in 5 clocks a port and section more."""
    scene = make_scene(*sets)
    found = []
    for name in ("golden", "core"):
        simulation = CONTROLLERS[name](scene)
        found.append((*run(simulation, 0.05), simulation.clock_cycles))
    (rows, words, _), (core_rows, core_words, clocks) = found
    assert np.array_equal(rows, core_rows)
    assert np.array_equal(words, core_words)
    assert np.count_nonzero(np.diff(rows[:, Column.CONTACT])) >= 2
    assert scene.shaper is not None
    if not scene.controller.anchored:
        assert clocks == 2 * (CORE_CLOCKS + SECTION_CLOCKS * scene.shaper.sections) * len(rows)
    # W was there: without it everything is another thing.
    plain, _ = run(CONTROLLERS["golden"](scene.model_copy(update={"shaper": None})), 0.05)
    assert np.abs(plain - rows)[:, Column.TORQUE].max() > 1e-4


def test_modes_are_those_of_one_port(make_scene):
    """Free: the states are emptied; in the rigid wall below the layer they stand still."""
    scene = make_scene(*TAP, *SPRING, *LAYERS, *DEEP, magnets_at(0.3))
    simulation = BrushlessSimulation(scene, rtl=False)
    states = simulation._shaper[1][:, :-1]  # without their budgets
    before, seen = states.copy(), set()
    rows, words = np.zeros((1, len(Column))), np.zeros((1, len(Word)), dtype=np.int64)
    for _ in range(50_000):
        simulation.advance(rows, words)
        wall = int(simulation._contact[0])
        if wall < 0:
            assert not states.any()
        elif wall == 1:
            assert np.array_equal(states, before)
            assert (states[:, 0, 0] != 0).all()  # the one of a spring with a damper, of each axis
        seen.add(wall)
        before = states.copy()
    assert seen == {-1, 0, 1}


def pushes(seed: int) -> tuple[str, ...]:
    """Stripes of soft, rigid and no wall, W, magnets and a hand, all of them random."""
    rng = np.random.default_rng(seed)
    edges = np.round(np.cumsum(rng.uniform(0.002, 0.03, 40)) - 0.4, 6).tolist()
    walls = [list(pair) for n, pair in enumerate(itertools.pairwise(edges)) if n % 3 < 2]
    soft = sorted(rng.choice(len(walls), len(walls) // 2, replace=False).tolist())
    return (
        f"controller.walls={walls}", f"shaper.walls={soft}", "shaper.feel=spring",
        f"shaper.stiffness={rng.uniform(0.05, 0.9)}", f"shaper.damping={rng.uniform(0, 1e-3)}",
        "hand.path='sine'", f"hand.amplitude_rad={rng.uniform(0.05, 0.4)}",
        f"hand.frequency_hz={rng.uniform(5, 60)}", f"hand.stiffness={rng.uniform(0.2, 3)}",
        f"hand.damping={rng.uniform(0.3e-3, 3e-3)}", magnets_at(rng.uniform(0, 2 * math.pi)),
        f"controller.eta_contact={rng.choice((-1.0, rng.uniform(-1, 0)))}",
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(8))
def test_ports_give_no_energy(make_scene, seed):
    """Whatever is pushed, and where, what has come out is never more than what went in."""
    rows, _ = run(BrushlessSimulation(make_scene(*pushes(seed)), rtl=False), 0.2)
    energy = np.cumsum(rows[:, Column.ENERGY_OUT])
    assert energy.max() <= 0.0
    assert energy.min() < -1e-5
    assert np.count_nonzero(np.diff(rows[:, Column.CONTACT])) >= 2


@pytest.mark.parametrize("paid", [False, True])
def test_a_filter_that_is_not_contractive_gives_what_was_paid(make_scene, paid):
    """What the test before looks at can be above 0: of a budget that was full from the start."""
    simulation = BrushlessSimulation(make_scene(*pushes(1), EVERYWHERE, "shaper.walls=[0]"),
                                     rtl=False)  # fmt: skip
    words = simulation._shaper[0]
    words[:, wave_core.B1 : wave_core.LOSS1] = words[:, wave_core.B1 : wave_core.LOSS1] * 1.1
    simulation._shaper[1][:, -1, 0] = (1 << formats.DATA_W) if paid else 0
    rows, _ = run(simulation, 0.2)
    assert (np.cumsum(rows[:, Column.ENERGY_OUT]).max() > 1e-6) == paid


# ---- The whole RTL at its pins.


@pytest.mark.parametrize("theta", ANGLES, ids=["0", "45", "117-degrees"])
def test_pins_have_goldens_stiffness(make_scene, theta):
    """12 bits and noise, edges and three legs: within 1 %, as without W."""
    scene = make_scene(*TAP, *SPRING, *SENSED, magnets_at(theta))
    result = measure(scene, "pins")
    # Quick taps find the damper as well.
    assert result["stiffness_predicted"] == pytest.approx(0.22)
    assert result["stiffness"] == pytest.approx(measure(scene, "golden")["stiffness"], rel=0.01)
    assert result["stiffness"] == pytest.approx(0.22, rel=0.03)
    assert "faults" not in result
    # Two axes with a section of W need 90 clocks, and a tick is a multiple of four.
    assert result["clock_cycles"] == pytest.approx(92 * result["ticks"], rel=1e-3)


def test_pins_render_the_spring():
    """The shipped scene on the whole RTL: slow taps find the wish within 1 %."""
    scene = load_scene(SCENES_DIR / "brushless_soft.toml", ("scene.duration_s=0.2",))
    result = measure(scene, "pins")
    assert result["stiffness_predicted"] == pytest.approx(0.22)
    assert result["stiffness"] == pytest.approx(0.22, rel=0.01)


@pytest.mark.parametrize(
    "sets",
    [(*LAYERS, *SPRING), (*LAYERS, SOS), (*LAYERS, *SPRING, *ANCHORED), (SOS, *ANCHORED)],
    ids=["layer", "two-sections", "layer-with-anchors", "two-sections-with-anchors"],
)
def test_pins_feel_as_golden(make_scene, sets):
    """Layers and anchors, one section of W and two, at their shortest tick: no overrun."""
    scene = make_scene(*TAP, *DEEP, *SENSED, *sets, "adc.noise_a=0", "adc.bits=16", magnets_at(0.5))
    pins = BrushlessPinsSimulation(scene)
    rows, _ = run(pins, 0.05)
    assert pins.faults == 0
    golden, _ = run(CONTROLLERS["golden"](scene), 0.05)
    torque = golden[:, Column.TORQUE]
    off = np.sqrt(np.mean((rows[:, Column.TORQUE] - torque) ** 2))
    assert off < 2e-3 * np.abs(torque).max()


def test_latency_and_shortest_tick(make_scene):
    assert turns_latency_clocks(28, 1, 1, brushless=True) == 28 + 32 + 70 + 3
    assert turns_latency_clocks(28, 1, 2, brushless=True) == 28 + 36 + 75 + 3
    for sets, least in (
        (SPRING, 92),
        ((SOS,), 100),
        ((*SPRING, *ANCHORED), 92),
        ((SOS, *ANCHORED), 100),
    ):
        scene = make_scene(*TAP, *SENSED, *sets)
        assert BrushlessPinsSimulation(scene).timing.tick_clocks == least


@pytest.mark.parametrize(
    ("sets", "told"),
    [
        ((*SPRING, "controller.clock_hz=88e6"),
         r"shorter than the 90 that `pins` needs for two ports with W; take .* >= 9e\+07"),
        ((SOS, *ANCHORED, "controller.clock_hz=98e6"),
         r"than the 99 that `pins` needs for two ports with W; take"),
        ((*SPRING, "controller.extra_ticks=0"), r"set extra_ticks = 1 or more"),
        (("shaper.feel=spring", "shaper.stiffness=1.2"), r"1.2 is stiffer"),
    ],
    ids=["tick", "tick-with-two-sections", "latency", "stiffer-than-the-motor"],
)  # fmt: skip
def test_refused_in_one_line(make_scene, sets, told):
    with pytest.raises(SceneError, match=told) as refused:
        BrushlessPinsSimulation(make_scene(*TAP, *SENSED, *sets))
    assert "\n" not in str(refused.value)


def test_who_has_no_w_refuses_it_in_one_line(make_scene):
    """Circuit, servo and host as with brushes; and whatever has words for the device's line."""
    scene = make_scene(*TAP, *SENSED, *SPRING)
    makers = {
        "analog": CONTROLLERS["analog"],
        "encoder": CONTROLLERS["encoder"],
        "a board": lambda scene: refuse(scene, "a board"),
        "pins": linked_pins,
        "pins, without a line": BrushlessDevicePins,
    }
    for name, make in makers.items():
        # On `pins` by itself it has W: it's the device that doesn't.
        shown = "a board" if name.startswith("pins") else f"`{name}`"
        with pytest.raises(SceneError, match=re.escape("[shaper] is not for")) as refused:
            make(scene)
        assert f"[shaper] is not for {shown}; " in str(refused.value)
        assert "leave it out" in str(refused.value)
        assert "\n" not in str(refused.value)
