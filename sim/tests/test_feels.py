# SPDX-License-Identifier: Apache-2.0
"""The shipped feels, whole: layers and walls by position, and what the RTL at its pins makes."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.ladder.run import measure, run_scene
from wavehaptics.ladder.sampled import SampledSimulation
from wavehaptics.scene import SceneError, find_scene, load_scene
from wavehaptics.trace.columns import Column, Word


def load(name: str, *settings: str):
    return load_scene(find_scene(name), settings)


def rows_of(simulation, duration_s: float) -> np.ndarray:
    ticks = round(duration_s / simulation.tick_s)
    rows = np.zeros((ticks, len(Column)))
    simulation.advance(rows, np.zeros((ticks, len(Word)), dtype=np.int64))
    return rows


def slope(rows: np.ndarray) -> float:
    return -np.polyfit(rows[:, Column.X], rows[:, Column.TORQUE], 1)[0]


def test_pins_render_the_spring(tmp_path):
    """The whole RTL, with the converter's bits and the bridge: stiffness within 1 % of the wish."""
    metrics = run_scene(load("spring_damper", "scene.duration_s=0.2"), "pins", tmp_path)
    assert metrics["stiffness_predicted"] == pytest.approx(0.45)
    assert metrics["stiffness"] == pytest.approx(0.45, rel=0.01)


@pytest.mark.parametrize("controller", ["analog", "encoder"])
def test_controllers_without_w_refuse_it(controller, tmp_path):
    with pytest.raises(SceneError, match=r"\[shaper\] is not for"):
        run_scene(load("spring_damper"), controller, tmp_path)


def test_soft_layer_over_a_rigid_wall():
    """Soft down to 20 mrad, then the motor's own spring; on the way back the layer again."""
    scene = load("soft_layer")
    rows = rows_of(SampledSimulation(scene, rtl=False), 0.4)
    x, torque = rows[:, Column.X], -rows[:, Column.TORQUE]
    deepest = x.argmax()
    assert x[deepest] > 0.021
    soft = rows[:deepest][(x[:deepest] > 0.008) & (x[:deepest] < 0.0195)]
    rigid = rows[:deepest][(x[:deepest] > 0.0201) & (x[:deepest] < 0.999 * x[deepest])]
    layer = 1 / (1 / 0.5 + 1 / 2.2508)
    assert slope(soft) == pytest.approx(layer, rel=0.05)
    assert slope(rigid) == pytest.approx(2.2508, rel=0.02)
    # No step in the torque at the layer's bottom, either way: the spring stays compressed below.
    edge = np.flatnonzero(np.diff((x > 0.02).astype(int)))
    assert len(edge) == 2
    for at in edge:
        assert abs(torque[at + 50] - torque[at - 50]) < 0.05 * torque[at]
    back = rows[edge[1] + 2000 :]
    back = back[(back[:, Column.X] > 0.008) & (back[:, Column.X] < 0.019)]
    assert slope(back) == pytest.approx(layer, rel=0.1)
    assert np.cumsum(rows[:, Column.ENERGY_OUT]).max() <= 0.0


@pytest.mark.parametrize(("soft", "spring"), [(0, False), (1, True)])
def test_a_wall_is_compared_with_its_own_spring(soft: int, spring: bool):
    """Of two walls one is soft: what is predicted is the one that the hand comes to first."""
    wish = ("shaper.feel=spring", "shaper.stiffness=0.6", f"shaper.walls=[{soft}]")
    found = measure(load("two_walls", *wish, "controller.extra_ticks=2"), "golden", compare=False)
    assert found["contact_edge_rad"] > 0.0
    assert (found["stiffness_predicted"] == pytest.approx(0.6)) == spring
    assert found["stiffness"] == pytest.approx(found["stiffness_predicted"], rel=0.005)


def test_two_walls_with_free_space_between():
    """Both push outward with the rigid spring, and nothing is felt between them."""
    scene = load("two_walls")
    rows = rows_of(SampledSimulation(scene, rtl=False), 0.5)
    x = rows[:, Column.X]
    high, low = rows[x > 0.0215], rows[x < -0.0215]
    assert slope(high) == pytest.approx(2.261, rel=0.02)
    assert slope(low) == pytest.approx(2.261, rel=0.02)
    assert high[:, Column.TORQUE].max() < 0 < low[:, Column.TORQUE].min()
    free = rows[(abs(x) < 0.019) & (rows[:, Column.CONTACT] == 0.0)]
    assert np.sqrt(np.mean(free[:, Column.TORQUE] ** 2)) < 1e-2 * abs(rows[:, Column.TORQUE]).max()


@pytest.mark.parametrize("tremor_hz", [8.0, 10.0, 12.0])
@pytest.mark.parametrize("cells", [0.15, 0.45, 0.8])
def test_a_finger_that_rests_on_the_edge_does_not_chatter(make_scene, tremor_hz, cells):
    """Tremor of less than a cell about the edge: two switchings a period without, none with."""
    cell = 2 * np.pi / 10_000
    switchings = {}
    for hysteresis in ("false", "true"):
        scene = make_scene(
            "encoder.counts_per_rev=10000", "controller.walls=[[0, 1]]", "controller.tick_hz=1e5",
            "controller.lambda=1e9", "hand.path=sine", "hand.stiffness=2", "hand.damping=1e-3",
            f"hand.frequency_hz={tremor_hz}", f"hand.amplitude_rad={cells * cell}",
            f"controller.edge_hysteresis={hysteresis}",
        )  # fmt: skip
        rows = rows_of(SampledSimulation(scene, rtl=False), 1.0)
        switchings[hysteresis] = np.count_nonzero(np.diff(rows[:, Column.CONTACT]))
        assert np.cumsum(rows[:, Column.ENERGY_OUT]).max() <= 0.0
    assert switchings["false"] == pytest.approx(2 * tremor_hz, abs=1)
    assert switchings["true"] == 0


def test_detents_climb_at_their_period_and_let_go():
    """Torque over angle of a slow, stiff hand: K from each edge, ½·K·w² lost at its end."""
    scene = load(
        "detents", "hand.amplitude_rad=0.1", "hand.stiffness=4", "hand.damping=5e-3",
    )  # fmt: skip
    rows = rows_of(SampledSimulation(scene, rtl=False), 0.5)
    # From the lowest point on, the rotor goes up through three detents.
    rows = rows[rows[:, Column.X].argmin() :] if rows[-1, Column.X] > 0 else rows[:250_000]
    contact = rows[:, Column.CONTACT]
    into, out = np.flatnonzero(np.diff(contact) > 0) + 1, np.flatnonzero(np.diff(contact) < 0)
    assert len(into) >= 2
    ups = [(a, b) for a, b in zip(into, out, strict=False) if rows[b, Column.X] > rows[a, Column.X]]
    edges = np.array([rows[a, Column.X] for a, _ in ups])
    assert np.diff(edges) == pytest.approx(np.radians(5.0), abs=4e-4)
    for a, b in ups:
        climb = rows[a + 500 : b]
        assert slope(climb) == pytest.approx(2.261, rel=0.05)
        width = rows[b, Column.X] - rows[a, Column.X]
        assert -rows[b, Column.TORQUE] == pytest.approx(2.261 * width, rel=0.08)
        assert -rows[b, Column.TORQUE] == pytest.approx(9e-3, rel=0.12)
        # A millisecond on nothing is left of the torque.
        assert abs(rows[b + 1000, Column.TORQUE]) < 2e-4
        energy = -rows[a : b + 1000, Column.ENERGY_OUT].sum()
        assert energy == pytest.approx(0.5 * 2.261 * width**2, rel=0.2)


def test_a_button_gives_way_before_its_stop():
    """The click's height is K times its width, then free space, then the stop; no energy out."""
    rows = rows_of(SampledSimulation(load("click"), rtl=False), 0.25)
    x, torque = rows[:, Column.X], -rows[:, Column.TORQUE]
    down = slice(x.argmin(), x.argmax())
    ranges = ((0.02, 0.0241), (0.028, 0.0395), (0.0405, 0.07))
    thin, free, stop = ((x[down] > low) & (x[down] < high) for low, high in ranges)
    assert torque[down][thin].max() == pytest.approx(2.26 * 4e-3, rel=0.08)
    assert np.abs(torque[down][free]).max() < 3e-4
    assert torque[down][stop].max() > 5e-3
    assert np.cumsum(rows[:, Column.ENERGY_OUT]).max() <= 0.0


def test_a_joystick_is_centred_from_both_sides():
    """One straight line through the middle, and rigid behind 80 mrad."""
    rows = rows_of(SampledSimulation(load("centring"), rtl=False), 1.0)
    x, torque = rows[:, Column.X], rows[:, Column.TORQUE]
    soft = (np.abs(x) < 0.07) & (rows[:, Column.T] > 0.1)
    assert np.polyfit(x[soft], torque[soft], 1) == pytest.approx((-0.1, 0.0), abs=2e-3)
    assert np.abs(torque[soft] + 0.1 * x[soft]).max() < 3e-4
    assert np.abs(torque).max() > 14e-3
    assert np.cumsum(rows[:, Column.ENERGY_OUT]).max() <= 0.0


def test_a_wall_that_lets_go_rings_in_lossless_free_space():
    """Why the detents' scene has η = 0.95 outside: with 1 the released current goes to and fro."""
    peaks = {}
    for eta in (0.95, 1.0):
        scene = load(
            "detents", "hand.amplitude_rad=0.1", "hand.stiffness=4", "hand.damping=5e-3",
            f"controller.eta_free={eta}",
        )  # fmt: skip
        rows = rows_of(SampledSimulation(scene, rtl=False), 0.1)
        at = np.flatnonzero(np.diff(rows[:, Column.CONTACT]) < 0)[0]
        peaks[eta] = np.abs(rows[at + 1000 : at + 2000, Column.TORQUE]).max()
    assert peaks[1.0] > 5e-3
    assert peaks[0.95] < 2e-4
