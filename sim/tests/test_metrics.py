# SPDX-License-Identifier: Apache-2.0
"""Metrics of synthetic runs whose stiffness, bounce, energy and offsets are known."""

import json
import math

import numpy as np
import pytest
from wavehaptics.laws import closed_forms
from wavehaptics.runtime.files import write_json
from wavehaptics.scene import Scene
from wavehaptics.trace.columns import Column
from wavehaptics.trace.metrics import LEAST_COUNTS, LEAST_R2, LEAST_TICKS, Metrics

TICK_S = 1e-4
COUNTS = 10_000
CELL = 2.0 * math.pi / COUNTS
K = 1.9
WALLS = ((-1.0, -0.5), (0.5, 1.0))
# A rotor comes to the upper wall through its lower edge, to the lower wall through its upper one.
SIDES = [pytest.param(0.5, 1.0, id="at x_min"), pytest.param(-0.5, -1.0, id="at x_max")]

NAMES = {
    *("scene", "controller", "hand", "duration_s", "wall_clock_s", "ticks", "tick_hz"),
    "clock_cycles",
    *("k_l", "stiffness", "stiffness_zero_rad", "contact_edge_rad", "stiffness_predicted"),
    *("tip_stiffness", "peak_torque", "peak_current_a", "current_ripple_a"),
    *("torque_nrmse_vs_analog", "free_space_torque_rms", "energy_out_max_j"),
    *("hold_offset_rad", "hold_error", "hold_torque", "hold_ripple_rms", "restitution"),
    *("saturated_fraction", "contact_energy_j", "contact_energy_ratio", "swing_rad", "swing_hz"),
    "clipped_fraction",
    "reasons",
}
ANCHOR_NAMES = {
    *("correction_out_max_j", "correction_bound_j", "x_hat_error_rms_rad"),
    *("omega_hat_error_rms", "anchor_fault_s"),
}
NAMES |= ANCHOR_NAMES


def scene_of(path: str | None = "taps", ticks: int = 1000, **tables) -> Scene:
    hand = {"path": path, "amplitude_rad": 1.0}
    if path == "impact":
        hand["speed_rad_s"] = 1.0
    else:
        hand["stiffness"] = 1.0
        if path != "press":
            hand["frequency_hz"] = 1.0
    data = {
        "scene": {"name": "synthetic", "duration_s": ticks * TICK_S},
        "motor": {"preset": "re25-118743"},
        "encoder": {"counts_per_rev": COUNTS},
        "controller": {"tick_hz": 1.0 / TICK_S, "lambda": 1e4},
        "hand": hand,
    } | tables
    return Scene.model_validate({name: table for name, table in data.items() if table is not None})


def rows_of(depth: np.ndarray, push: np.ndarray, edge: float, side: float) -> np.ndarray:
    """Rows of a rotor ``depth`` beyond ``edge``, in contact where that is above zero.

    ``push`` is the torque out of the wall; ``side`` = +1 for a lower edge.
    """
    rows = np.zeros((len(depth), len(Column)))
    rows[:, Column.T] = (np.arange(len(depth)) + 0.5) * TICK_S
    rows[:, Column.X] = edge + side * depth
    rows[:, Column.OMEGA] = side * np.gradient(depth, TICK_S)
    rows[:, Column.TORQUE] = -side * push
    rows[:, Column.I] = rows[:, Column.TORQUE] / 0.0234
    rows[:, Column.CONTACT] = depth > 0.0
    return rows


def taps(ticks: int = 1000, deep: float = 12e-3, turns: float = 2.0) -> np.ndarray:
    """Depth of a rotor that dips into the wall and comes out again."""
    return -deep * np.cos(2.0 * np.pi * turns * np.arange(ticks) / ticks)


def result_of(
    rows: np.ndarray,
    scene: Scene | None = None,
    reference: np.ndarray | None = None,
    size: int | None = None,
    predicted: float | None = K,
    root: float | None = None,
    **further,
) -> dict:
    scene = scene_of(ticks=len(rows)) if scene is None else scene
    metrics = Metrics(
        scene, TICK_S, controller="golden", stiffness_predicted=predicted, walls=WALLS, root=root,
        **further,
    )  # fmt: skip
    for start in range(0, len(rows), size or len(rows)):
        part = slice(start, start + (size or len(rows)))
        metrics.update(rows[part], None if reference is None else reference[part])
    return metrics.result()


def spring(depth: np.ndarray, k: float = K) -> np.ndarray:
    return np.where(depth > 0.0, k * depth, 0.0)


# Stiffness


@pytest.mark.parametrize(("edge", "side"), SIDES)
def test_stiffness_is_that_of_the_spring(edge, side):
    depth = taps()
    result = result_of(rows_of(depth, spring(depth), edge, side))
    assert result["stiffness"] == pytest.approx(K, rel=1e-9)
    assert result["stiffness_zero_rad"] == pytest.approx(edge, abs=1e-12)
    assert result["contact_edge_rad"] == edge
    assert result["peak_torque"] == pytest.approx(K * 12e-3, rel=1e-9)
    assert result["stiffness_predicted"] == K
    assert result["k_l"] == pytest.approx(2.2815)


@pytest.mark.parametrize(("edge", "side"), SIDES)
def test_a_spring_that_starts_late_is_fitted_from_the_edge_on(edge, side):
    depth = taps()
    lag = 2e-3
    push = np.where(depth > lag, K * (depth - lag), 0.0)
    rows = rows_of(depth, push, edge, side)
    result = result_of(rows)
    first = np.flatnonzero(depth > 0.0)
    first = first[: int(np.argmax(np.diff(first) > 1)) + 1]
    end = first[0] + int(np.argmax(push[first] >= 0.9 * push[first].max())) + 1
    slope, zero = np.polyfit(
        rows[first[0] : end, Column.X], -rows[first[0] : end, Column.TORQUE], 1
    )
    assert result["stiffness"] == pytest.approx(slope, rel=1e-9)
    assert result["stiffness_zero_rad"] == pytest.approx(-zero / slope, abs=1e-9)
    assert result["stiffness"] < 0.99 * K


def test_the_fit_ends_at_90_percent_of_the_peak():
    depth = taps(20_000)
    knee, deepest = 7.2e-3, 12e-3  # beyond the knee the wall is soft, up to 1/0.9 of its torque
    soft = K * knee * (1.0 + (1.0 / 0.9 - 1.0) * (depth - knee) / (deepest - knee))
    result = result_of(rows_of(depth, np.where(depth > knee, soft, spring(depth)), 0.5, 1.0))
    assert result["stiffness"] == pytest.approx(K, rel=1e-4)


@pytest.mark.parametrize(("edge", "side"), SIDES)
def test_the_fit_ends_where_the_voltage_saturates(edge, side):
    depth = taps()
    push = np.minimum(spring(depth), 0.3 * K * 12e-3)
    rows = rows_of(depth, push, edge, side)
    rows[:, Column.SATURATED] = push >= 0.3 * K * 12e-3
    result = result_of(rows)
    assert result["stiffness"] == pytest.approx(K, rel=1e-9)
    assert result["saturated_fraction"] == pytest.approx(rows[:, Column.SATURATED].mean())
    assert result["clipped_fraction"] == pytest.approx(rows[:, Column.CLIPPED].mean())


def test_saturated_from_the_first_tick_on_there_is_no_stiffness():
    depth = taps()
    rows = rows_of(depth, spring(depth), 0.5, 1.0)
    rows[:, Column.SATURATED] = 1.0
    result = result_of(rows)
    assert result["stiffness"] is None
    assert result["tip_stiffness"] is None
    assert result["saturated_fraction"] == 1.0


def test_only_the_first_contact_and_its_compression_are_fitted():
    depth = taps()
    push = spring(depth)
    push[depth.argmax() + 1 : 500] *= 0.5  # the way out
    push[500:] *= 3.0  # the second contact
    result = result_of(rows_of(depth, push, 0.5, 1.0))
    assert result["stiffness"] == pytest.approx(K, rel=1e-9)
    assert result["peak_torque"] == pytest.approx(3.0 * K * 12e-3, rel=1e-4)


def test_noise_and_ripple_average_out():
    rng = np.random.default_rng(3)
    depth = taps(20_000)
    push = spring(depth) + 0.01 * K * 12e-3 * rng.normal(size=len(depth))
    result = result_of(rows_of(depth, push, -0.5, -1.0))
    assert result["stiffness"] == pytest.approx(K, rel=2e-3)


def test_chatter_at_the_edge_is_not_the_first_contact():
    depth, wild = taps(), np.full(1000, -1e-3)
    wild[100:103] = 20.0 * CELL  # shorter than LEAST_TICKS
    wild[200:260] = 0.9 * CELL * np.hanning(60)  # not a cell deep
    wild[300:400:2] = 2.0 * CELL  # on one tick, off the next
    assert LEAST_TICKS == 4
    both = np.concatenate([wild, depth])
    push = np.concatenate([np.where(wild > 0.0, 7.0 * wild + 1e-3, 0.0), spring(depth)])
    result = result_of(rows_of(both, push, 0.5, 1.0))
    assert result["stiffness"] == pytest.approx(K, rel=1e-9)
    assert result["reasons"]["stiffness"] == (
        "52 contacts before, shorter than 4 ticks or less deep than 4 counts, passed over"
    )
    only = result_of(rows_of(wild, np.where(wild > 0.0, 7.0 * wild, 0.0), 0.5, 1.0))
    assert only["stiffness"] is None
    assert only["contact_edge_rad"] is None
    assert only["reasons"]["stiffness"] == (
        "no contact lasts 4 ticks and is 1 counts deep; the deepest is 20 counts"
    )


def test_a_contact_of_a_few_counts_is_not_the_first():
    """A chattering one, whose force has nothing of a spring, comes before a tap."""
    rng = np.random.default_rng(5)
    free = np.full(50, -1e-3)
    few = taps(800, (LEAST_COUNTS - 0.5) * CELL)
    depth = np.concatenate([free, few, free, taps(), free])
    push = spring(depth)
    push[50:850] = rng.normal(size=800) * (few > 0.0)
    result = result_of(rows_of(depth, push, 0.5, 1.0))
    assert result["stiffness"] == pytest.approx(K, rel=1e-9)
    assert result["reasons"]["stiffness"].startswith("2 contacts before, ")
    # Alone it is taken as far as it is a line.
    alone = result_of(rows_of(depth[:900], push[:900], 0.5, 1.0))
    assert alone["stiffness"] is None
    assert alone["reasons"]["stiffness"].startswith("the force ")
    assert "of a contact of only 3.5 counts" in alone["reasons"]["stiffness"]
    line = result_of(rows_of(depth[:900], spring(depth[:900]), 0.5, 1.0))
    assert line["stiffness"] == pytest.approx(K, rel=1e-9)
    assert line["reasons"]["stiffness"] == "of a contact of only 3.5 counts"


def test_of_several_that_are_not_deep_the_deepest_is_taken():
    free = np.full(50, -1e-3)
    parts = [taps(400, n * CELL) for n in (2.0, 3.0, 1.5)]
    depth = np.concatenate([free, parts[0], free, parts[1], free, parts[2], free])
    push = np.concatenate([np.zeros(50)] + [
        part for n, one in zip((1.0, 2.0, 3.0), parts, strict=True)
        for part in (n * spring(one), np.zeros(50))
    ])  # fmt: skip
    result = result_of(rows_of(depth, push, 0.5, 1.0))
    assert result["stiffness"] == pytest.approx(2.0 * K, rel=1e-9)
    assert result["reasons"]["stiffness"] == "of a contact of only 3 counts"


def test_a_fit_ends_where_the_current_is_clipped():
    depth = taps()
    push = np.minimum(spring(depth), 0.5 * K * 12e-3)
    rows = rows_of(depth, push, 0.5, 1.0)
    rows[:, Column.CLIPPED] = push >= 0.5 * K * 12e-3
    assert result_of(rows)["stiffness"] == pytest.approx(K, rel=1e-6)


def test_what_has_no_value_has_a_reason():
    """Where the scene defines a metric and the run has none."""
    free = rows_of(np.full(2500, -1e-3), np.zeros(2500), 0.5, 1.0)
    held = result_of(free, scene_of("press", 2500))
    assert held["reasons"] == {
        "stiffness": "the rotor never came into a wall",
        "hold_error": "the rotor isn't in contact in all of the last tenth",
    }
    missed = result_of(free, scene_of("impact", 2500))
    assert missed["reasons"]["restitution"] == "the rotor never came into a wall"
    depth = taps()
    closed = rows_of(depth, spring(depth), 0.5, 1.0)
    closed[:, Column.SATURATED] = 1.0
    assert result_of(closed)["reasons"]["stiffness"].startswith("voltage or current were at their")
    pulls = result_of(rows_of(depth, -spring(depth), 0.5, 1.0))
    assert pulls["stiffness"] is None
    assert pulls["reasons"]["stiffness"] == "the wall never pushed outwards in the first contact"


def test_without_an_encoder_a_shallow_contact_counts():
    depth = taps(deep=0.3 * CELL)
    rows = rows_of(depth, spring(depth), 0.5, 1.0)
    assert result_of(rows)["stiffness"] is None
    ideal = result_of(rows, scene_of(encoder=None))
    assert ideal["stiffness"] == pytest.approx(K, rel=1e-6)


def test_a_contact_under_way_at_the_start_counts_only_without_another():
    inside = 12e-3 * (1.0 - np.cos(2.0 * np.pi * np.arange(400) / 400)) / 2.0 + 1e-4
    rows = rows_of(inside, 0.5 * K * inside, 0.5, 1.0)
    alone = result_of(rows)
    assert alone["stiffness"] == pytest.approx(0.5 * K, rel=1e-9)
    assert alone["contact_edge_rad"] == 0.5
    depth = np.concatenate([inside, taps()])
    push = np.concatenate([0.5 * K * inside, spring(taps())])
    assert result_of(rows_of(depth, push, 0.5, 1.0))["stiffness"] == pytest.approx(K, rel=1e-9)


@pytest.mark.parametrize(("edge", "side"), SIDES)
def test_a_wall_that_grows_while_held_does_not_move_the_fit(edge, side):
    entry = 12e-3 * np.linspace(-0.2, 1.0, 600)
    ring = 12e-3 * (0.8 + 0.2 * np.cos(np.linspace(0.0, 60.0, 20_000)))
    depth = np.concatenate([entry, ring])
    push = spring(depth)
    push[600:] += np.linspace(0.0, 5.0 * K * 12e-3, 20_000)
    result = result_of(rows_of(depth, push, edge, side))
    assert result["stiffness"] == pytest.approx(K, rel=0.02)


def fitted_afterwards(rows: np.ndarray, edge: float, side: float) -> tuple[float, float]:
    """The definition of ``stiffness``, and r², applied to a whole run that is one contact."""
    depth, push = side * (rows[:, Column.X] - edge), -side * rows[:, Column.TORQUE]
    peak = push[: depth.argmax() + 1].max()
    end = int(np.argmax(push >= 0.9 * peak)) + 1
    if rows[:end, Column.SATURATED].any():
        end = int(rows[:, Column.SATURATED].argmax())
    x, f = rows[:end, Column.X], -rows[:end, Column.TORQUE]
    return np.polyfit(x, f, 1)[0], np.corrcoef(x, f)[0, 1] ** 2


@pytest.mark.parametrize(("edge", "side"), SIDES)
@pytest.mark.parametrize("seed", range(30))
def test_ringing_growing_saturating_contacts_are_fitted_as_defined(edge, side, seed):
    # Coarse steps, so that every new height of the push is far more than 10⁻⁴ above the last.
    rng = np.random.default_rng(seed)
    n = np.arange(60)
    depth = 1e-3 + 0.2e-3 * n * rng.random() + 2e-3 * rng.random() * np.sin(n * rng.random()) ** 2
    push = K * depth + 2e-3 * rng.random() * np.sin(n * rng.random()) + 1e-3 * rng.normal(size=60)
    depth += 1e-4 * rng.normal(size=60)
    push += n * 1e-3 * rng.normal()
    rows = rows_of(depth, push, edge, side)
    if seed % 3 == 0:
        rows[rng.integers(3, 60), Column.SATURATED] = 1.0
    free = rows_of(np.full(5, -1e-3), np.zeros(5), edge, side)
    result = result_of(np.concatenate([free, rows]))
    if result["stiffness"] is None:
        pushes = push[: depth.argmax() + 1]
        short = pushes.max() <= 0.0 or int(np.argmax(pushes >= 0.9 * pushes.max())) < 2
        assert short or fitted_afterwards(rows, edge, side)[1] < LEAST_R2
        assert result["reasons"]["stiffness"]
    else:
        slope, explained = fitted_afterwards(rows, edge, side)
        assert result["stiffness"] == pytest.approx(slope, rel=1e-6)
        assert explained >= LEAST_R2
        assert "stiffness" not in result["reasons"]


@pytest.mark.parametrize("later", [12e-3, 12.1e-3])
@pytest.mark.parametrize("grows", [30_000, 31_500, 33_000, 34_500])  # to four places of the ring
def test_a_push_that_grew_past_the_ring_counts_once_the_rotor_goes_deeper(
    later, grows, monkeypatch
):
    # Fine steps up while the rotor is not at its deepest; at the end it goes deeper, or does not.
    depth = np.concatenate(
        [np.linspace(-1e-3, 12e-3, 2000), np.full(grows, 11e-3), [later] * 10, np.full(9, -1e-3)]
    )
    push = spring(depth)
    push[2000:-9] = K * 12e-3 * np.exp(3.7e-5 * np.arange(grows + 10))
    rows = rows_of(depth, push, 0.5, 1.0)
    result = result_of(rows)
    if later == 12e-3:
        assert result["stiffness"] == pytest.approx(K, rel=1e-9)
    else:
        expected, explained = fitted_afterwards(rows[int(np.argmax(depth > 0.0)) : -9], 0.5, 1.0)
        assert expected > 2.0 * K
        assert explained < LEAST_R2
        assert result["stiffness"] is None
        assert result["reasons"]["stiffness"] == (
            f"the force is no line over the depth: r² is {explained:.2g}"
        )
        monkeypatch.setattr("wavehaptics.trace.metrics.LEAST_R2", 0.0)
        assert result_of(rows)["stiffness"] == pytest.approx(expected, rel=1e-3)


def test_more_heights_than_the_ring_holds():
    depth = 1e-6 * 1.0002 ** np.arange(60_000) - 1.0005e-6  # to 0.16 rad, 16,000 a factor of 24
    rows = rows_of(depth, spring(depth), 0.5, 1.0)
    assert result_of(rows)["stiffness"] == pytest.approx(K, rel=1e-6)


def test_the_tick_of_entry_may_lie_outside_the_wall_on_average():
    depth = taps()
    rows = rows_of(depth, spring(depth), -0.5, -1.0)
    first = int(np.argmax(depth > 0.0))
    rows[first - 1, Column.CONTACT] = 1.0
    result = result_of(rows)
    assert result["contact_edge_rad"] == -0.5
    assert result["stiffness"] == pytest.approx(K, rel=1e-3)


def test_tip_stiffness_with_a_transmission():
    depth = taps()
    scene = scene_of(transmission={"ratio": 8.0, "lever_m": 0.14})
    result = result_of(rows_of(depth, spring(depth), 0.5, 1.0), scene)
    assert result["tip_stiffness"] == pytest.approx(K * (8.0 / 0.14) ** 2, rel=1e-9)


# Hold


def press(edge: float, side: float, moved: float, ripple: float, ticks: int = 5000) -> np.ndarray:
    """A hold 12 mrad deep at a wall that has moved by ``moved`` rad inwards."""
    depth = np.minimum(np.linspace(-1e-3, 0.1, ticks), 12e-3)
    push = spring(depth)
    held = depth == 12e-3
    push[held] -= K * moved
    push[held] += ripple * math.sqrt(2.0) * np.cos(np.pi / 5.0 * np.arange(held.sum()))
    return rows_of(depth, push, edge, side)


@pytest.mark.parametrize(("edge", "side"), SIDES)
@pytest.mark.parametrize("moved", [0.0, 3e-4, -3e-4])
def test_hold_tells_how_far_the_wall_has_moved(edge, side, moved):
    rows = press(edge, side, moved, ripple=2e-5)
    result = result_of(rows, scene_of("press", len(rows)))
    assert result["hold_offset_rad"] == pytest.approx(side * moved, abs=1e-12)
    assert result["hold_error"] == pytest.approx(moved / 12e-3, abs=1e-10)
    assert result["hold_torque"] == pytest.approx(-side * K * (12e-3 - moved), rel=1e-9)
    assert result["hold_ripple_rms"] == pytest.approx(2e-5, rel=1e-9)


@pytest.mark.parametrize("power", [1, 2])
@pytest.mark.parametrize("turn", [0.0, 0.1, 0.5])
def test_a_wall_of_less_torque_for_an_ampere_has_not_moved(turn, power):
    """The motor's own k_T where it rests, by the shape of its back-EMF."""
    pairs, moved, place = 7, 2e-4, 0.5 + 12e-3
    magnet = place - 2.0 * math.pi * turn / 6.0 / pairs
    motor = {"preset": "gbm2804-100t", "harmonic_5": 0.03, "harmonic_7": -0.02,
             "magnet_rad": magnet}  # fmt: skip
    own = closed_forms.brushless_own_k_t(pairs * (place - magnet), 0.03, -0.02)
    assert own == pytest.approx(1.0 - 0.05 * math.cos(2.0 * math.pi * turn))
    rows = press(0.5, 1.0, moved, 0.0)
    rows[:, Column.TORQUE] *= own**power
    result = result_of(rows, scene_of("press", len(rows), motor=motor), shape_power=power)
    assert result["hold_offset_rad"] == pytest.approx(moved, abs=1e-12)
    assert result["hold_torque"] == pytest.approx(-(own**power) * K * (12e-3 - moved), rel=1e-9)


def test_a_drift_counts_as_ripple():
    rows = press(0.5, 1.0, 0.0, 0.0)
    rows[-500:, Column.TORQUE] += np.linspace(-1e-3, 1e-3, 500)
    result = result_of(rows, scene_of("press", len(rows)))
    assert result["hold_ripple_rms"] == pytest.approx(1e-3 / math.sqrt(3.0), rel=5e-3)
    assert result["hold_offset_rad"] == pytest.approx(0.0, abs=1e-12)


def test_hold_is_over_the_last_tenth():
    rows = press(0.5, 1.0, 0.0, 0.0)
    rows[:-500, Column.TORQUE] *= 1.1
    result = result_of(rows, scene_of("press", len(rows)))
    assert result["hold_offset_rad"] == pytest.approx(0.0, abs=1e-12)
    rows[-501:, Column.TORQUE] *= 1.1
    result = result_of(rows, scene_of("press", len(rows)))
    assert result["hold_error"] == pytest.approx(-0.1, abs=1e-9)


def test_a_lost_wall_is_no_hold():
    rows = press(0.5, 1.0, 0.0, 0.0)
    rows[-7, Column.CONTACT] = 0.0
    result = result_of(rows, scene_of("press", len(rows)))
    assert [result[f"hold_{name}"] for name in ("offset_rad", "error", "ripple_rms")] == [None] * 3


def test_only_a_press_holds_and_only_against_a_known_spring():
    rows = press(0.5, 1.0, 0.0, 0.0)
    for scene, predicted in (
        (scene_of("taps", len(rows)), K),
        (scene_of("press", len(rows)), None),
        (scene_of("press", len(rows)), 0.0),
        (scene_of("press", 2 * len(rows)), K),  # the run has not come to its last tenth
    ):
        result = result_of(rows, scene, predicted=predicted)
        assert result["hold_offset_rad"] is None
        assert result["hold_ripple_rms"] is None


@pytest.mark.parametrize(("edge", "side"), SIDES)
@pytest.mark.parametrize("hertz", [7.0, 25.0, 50.0])
@pytest.mark.parametrize("drift", [0.0, 0.2])
def test_swing_of_a_hold_is_that_of_its_sine_whatever_the_wall_drifts(edge, side, hertz, drift):
    t = (np.arange(50_000) + 0.5) * TICK_S
    depth = 20e-3 + drift * (t - t[-1]) * 1e-3
    rows = rows_of(depth, spring(depth), edge, side)
    turn = 2.0 * math.pi * hertz
    ends = 3e-4 * np.sin(turn * (np.arange(50_001) * TICK_S) + 0.7)
    rows[:, Column.X] += 0.5 * (ends[1:] + ends[:-1])
    rows[:, Column.OMEGA] += (ends[1:] - ends[:-1]) / TICK_S
    result = result_of(rows, scene_of("press", len(rows)))
    assert result["swing_hz"] == pytest.approx(hertz, rel=1e-3)
    # The line takes some of a sine that isn't there a whole number of times: 3.5 times at 7 Hz.
    whole = (hertz * 5000 * TICK_S) % 1.0 == 0.0
    assert result["swing_rad"] == pytest.approx(3e-4, rel=5e-3 if whole else 0.06)


def test_a_rotor_at_rest_or_on_its_way_does_not_swing():
    rows = press(0.5, 1.0, 0.0, 2e-5)
    result = result_of(rows, scene_of("press", len(rows)))
    assert (result["swing_rad"], result["swing_hz"]) == (0.0, None)
    t = np.arange(500) * TICK_S
    rows[-500:, Column.X] += 1e-3 * np.expm1(20.0 * t)  # it runs away
    rows[-500:, Column.OMEGA] += 20e-3 * np.exp(20.0 * t)
    result = result_of(rows, scene_of("press", len(rows)))
    assert result["swing_rad"] > 5e-5
    assert result["swing_hz"] is None
    assert result_of(rows, scene_of("taps", len(rows)))["swing_rad"] is None


# Energy of contacts


def moved(depth: np.ndarray, push: np.ndarray, edge: float = 0.5, side: float = 1.0) -> np.ndarray:
    """Rows of ``depth`` at the ticks' ends, one more than there are rows; ``push`` in the ticks."""
    rows = rows_of(0.5 * (depth[1:] + depth[:-1]), push, edge, side)
    rows[:, Column.OMEGA] = side * np.diff(depth) / TICK_S
    rows[:, Column.CONTACT] = depth[1:] >= 0.0
    return rows


def swings(turns: float, deep: float, ticks: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Depth at the ends of ticks, and in their middles, of a rotor that dips in and out."""
    ends = -deep * np.cos(2.0 * np.pi * turns * np.arange(ticks + 1) / ticks)
    return ends, 0.5 * (ends[1:] + ends[:-1])


@pytest.mark.parametrize(("edge", "side"), SIDES)
def test_a_spring_gives_back_what_it_took(edge, side):
    ends, middle = swings(2.0, 12e-3)
    result = result_of(moved(ends, spring(middle), edge, side))
    assert result["contact_energy_j"] == pytest.approx(0.0, abs=1e-4 * 0.5 * K * 12e-3**2)
    assert result["contact_energy_ratio"] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize(("edge", "side"), SIDES)
@pytest.mark.parametrize("extra", [0.25, -0.4])
def test_a_wall_that_pushes_harder_on_the_way_out_gives_the_difference(edge, side, extra):
    ends, middle = swings(1.0, 12e-3)
    out = np.where(np.diff(ends) < 0.0, 1.0 + extra, 1.0)
    result = result_of(moved(ends, out * spring(middle), edge, side))
    held = 0.5 * K * 12e-3**2
    assert result["contact_energy_j"] == pytest.approx(extra * held, rel=1e-3)
    most = max(1.0, 1.0 + extra) ** 2
    assert result["contact_energy_ratio"] == pytest.approx(extra / most, rel=2e-3)


def test_the_largest_of_the_contacts_counts_each_against_its_own_spring():
    """A deep press that loses 1 %, and a shallower one that gives 30 % of less."""
    deep, middle_deep = swings(1.0, 20e-3)
    less, middle = swings(1.0, 6e-3)
    lossy = np.where(np.diff(deep) < 0.0, 0.99, 1.0) * spring(middle_deep)
    active = np.where(np.diff(less) < 0.0, 1.3, 1.0) * spring(middle)
    rows = np.concatenate([moved(deep, lossy), moved(less, active), moved(deep, lossy)])
    result = result_of(rows)
    assert result["contact_energy_j"] == pytest.approx(0.3 * 0.5 * K * 6e-3**2, rel=1e-2)
    assert result["contact_energy_ratio"] == pytest.approx(0.3 / 1.69, rel=1e-2)


def test_chatter_at_the_edge_belongs_to_its_contact():
    """Hits within two counts of the edge, each of which gives something, are one contact."""
    deep, middle = swings(1.0, 12e-3)
    turned = int(np.flatnonzero(deep >= 0.0)[-1])
    depth = 1.2 * CELL * np.sin(2.0 * np.pi * np.arange(1, 2001) / 100)
    ends = np.concatenate([deep[: turned + 1], depth, deep[turned + 1 :]])
    middle = 0.5 * (ends[1:] + ends[:-1])
    push = spring(middle)
    push[turned : turned + 2000] = np.where(np.diff(depth, prepend=0.0) < 0.0, 1.0, 0.2) * 1e-3
    push[turned : turned + 2000][depth < 0.0] = 0.0
    rows = moved(ends, push)
    entries = np.count_nonzero(np.diff(rows[:, Column.CONTACT]) > 0.0)
    assert entries > 15
    given = float(np.sum(rows[:, Column.TORQUE] * rows[:, Column.OMEGA]) * TICK_S)
    result = result_of(rows)
    assert given > 2e-6
    assert result["contact_energy_j"] == pytest.approx(given, rel=1e-6)
    assert result["contact_energy_ratio"] == pytest.approx(given / (0.5 * K * 12e-3**2), rel=1e-3)


def test_a_touch_of_less_than_two_counts_is_not_judged_by_its_own_depth():
    deep = 0.1 * CELL
    ends, middle = swings(1.0, 12e-3)
    ends, middle = ends - 12e-3 + deep, middle - 12e-3 + deep
    out = np.where(np.diff(ends) < 0.0, 3.0, 1.0)
    result = result_of(moved(ends, out * spring(middle)))
    given = 2.0 * 0.5 * K * deep**2
    assert result["contact_energy_j"] == pytest.approx(given, rel=0.05)
    assert result["contact_energy_ratio"] == pytest.approx(2.0 * 0.1**2 / 2.0**2, rel=0.05)


@pytest.mark.parametrize("late", [1.0, 1.5])
def test_a_contact_that_is_still_open_counts_with_what_its_spring_holds(late):
    """One that only holds is not above zero; one that now pushes harder has more to give."""
    ends = np.minimum(np.linspace(-2e-3, 0.1, 5001), 12e-3)
    push = spring(0.5 * (ends[1:] + ends[:-1]))
    push[-1000:] *= late
    result = result_of(moved(ends, push))
    assert result["contact_energy_ratio"] == pytest.approx(1.0 - 1.0 / late**2, abs=2e-3)


def test_a_wall_without_a_spring_has_an_energy_and_no_ratio():
    ends, middle = swings(1.0, 12e-3)
    result = result_of(moved(ends, 2.0 * spring(middle)), predicted=0.0)
    assert result["contact_energy_j"] == pytest.approx(0.0, abs=1e-8)
    assert result["contact_energy_ratio"] is None


# Bounce


def impact(edge: float, side: float, speed_in: float, speed_out: float) -> np.ndarray:
    """400 ticks towards the wall, 20 in it and 400 away; ``speed_out`` is positive inwards."""
    speed = np.concatenate(
        [
            np.full(400, speed_in),
            np.linspace(speed_in, speed_out, 22)[1:-1],
            np.full(400, speed_out),
        ]
    )
    depth = np.cumsum(speed) * TICK_S
    depth -= depth[399] + 1e-9
    rows = rows_of(depth, np.zeros_like(depth), edge, side)
    rows[:, Column.CONTACT] = 0.0
    rows[400:420, Column.CONTACT] = 1.0
    rows[:, Column.OMEGA] = side * speed
    return rows


@pytest.mark.parametrize(("edge", "side"), SIDES)
@pytest.mark.parametrize("restitution", [0.5, 0.97, 1.18])
@pytest.mark.parametrize("speed", [0.01, 1.0, 30.0])  # the slowest does not enter a second cell
def test_restitution(edge, side, restitution, speed):
    rows = impact(edge, side, speed, -restitution * speed)
    result = result_of(rows, scene_of("impact", len(rows)))
    assert result["restitution"] == pytest.approx(restitution, rel=1e-12)


def test_restitution_is_that_of_the_first_contact():
    first, second = impact(0.5, 1.0, 3.0, -2.4), impact(0.5, 1.0, 2.0, -4.0)
    rows = np.concatenate([first, second])
    result = result_of(rows, scene_of("impact", len(rows)))
    assert result["restitution"] == pytest.approx(0.8, rel=1e-12)


def test_chatter_on_the_way_in_is_no_bounce():
    rows = impact(0.5, 1.0, 3.0, -2.4)
    rows[399, Column.CONTACT] = 1.0
    rows[401:403, Column.CONTACT] = 0.0
    result = result_of(rows, scene_of("impact", len(rows)))
    assert result["restitution"] == pytest.approx(2.4 / rows[402, Column.OMEGA], rel=1e-12)


def test_a_rotor_that_goes_through_stays_or_starts_inside_has_no_restitution():
    through = impact(0.5, 1.0, 3.0, 1.0)
    back_later = np.concatenate([through, impact(-0.5, -1.0, 3.0, -2.0)])
    started = impact(0.5, 1.0, 3.0, -2.4)[405:]
    for rows in (through, back_later, impact(0.5, 1.0, 3.0, -2.4)[:415], started):
        assert result_of(rows, scene_of("impact", len(rows)))["restitution"] is None


# Sums over the run


def test_energy_is_the_most_ever_given_out():
    rows = np.zeros((6, len(Column)))
    rows[:, Column.ENERGY_OUT] = [-1.0, 3.0, -5.0, 4.0, 2.5, -9.0]
    assert result_of(rows)["energy_out_max_j"] == pytest.approx(3.5)
    rows[:, Column.ENERGY_OUT] = [-1.0, 0.5, 0.25, -3.0, 2.0, 1.0]
    assert result_of(rows)["energy_out_max_j"] == 0.0


def test_peaks_ripple_and_free_torque():
    rng = np.random.default_rng(5)
    rows = np.zeros((4001, len(Column)))
    rows[:, Column.TORQUE] = rng.normal(size=4001)
    rows[:, Column.I] = rng.normal(size=4001)
    rows[:, Column.RIPPLE] = rng.lognormal(-3.0, 1.0, 4001)
    rows[:, Column.X] = 0.6
    rows[1000:2000, Column.CONTACT] = 1.0
    result = result_of(rows)
    free = np.delete(rows[:, Column.TORQUE], slice(1000, 2000))
    assert result["free_space_torque_rms"] == pytest.approx(np.sqrt(np.mean(free**2)), rel=1e-12)
    assert result["peak_torque"] == np.abs(rows[:, Column.TORQUE]).max()
    assert result["peak_current_a"] == np.abs(rows[:, Column.I]).max()
    assert result["current_ripple_a"] == pytest.approx(np.median(rows[:, Column.RIPPLE]), rel=1e-3)


@pytest.mark.parametrize("ripple", [0.0, 0.1, 1e-20, 1e6])
def test_a_constant_ripple_is_told_exactly(ripple):
    rows = np.zeros((1001, len(Column)))
    rows[:, Column.RIPPLE] = ripple
    assert result_of(rows)["current_ripple_a"] == pytest.approx(ripple, rel=1e-12)


def test_always_in_contact_there_is_no_free_space():
    rows = np.zeros((10, len(Column)))
    rows[:, Column.X], rows[:, Column.CONTACT] = 0.6, 1.0
    assert result_of(rows)["free_space_torque_rms"] is None


def test_torque_error_is_over_the_peak_of_the_reference():
    rows, reference = np.zeros((2, 1000, len(Column)))
    reference[:, Column.TORQUE] = 0.02 * np.sin(np.arange(1000.0))
    rows[:, Column.TORQUE] = reference[:, Column.TORQUE] + 1e-4 * (-1.0) ** np.arange(1000)
    peak = np.abs(reference[:, Column.TORQUE]).max()
    result = result_of(rows, reference=reference)
    assert result["torque_nrmse_vs_analog"] == pytest.approx(1e-4 / peak, rel=1e-12)
    assert result_of(rows, reference=rows)["torque_nrmse_vs_analog"] == 0.0
    assert result_of(rows)["torque_nrmse_vs_analog"] is None
    still = np.zeros_like(rows)
    assert result_of(rows, reference=still)["torque_nrmse_vs_analog"] is None


# The whole


def everything(path: str) -> tuple[np.ndarray, np.ndarray]:
    """A run that has a bit of all, with noise, and its reference."""
    rng = np.random.default_rng(11)
    depth = np.concatenate([taps(1500), np.linspace(-12e-3, 14e-3, 300), np.full(700, 14e-3)])
    rows = rows_of(depth, spring(depth), 0.5, 1.0)
    reference = rows.copy()
    rows += 1e-4 * np.abs(rows) * rng.normal(size=rows.shape)
    rows[:, Column.CONTACT] = depth > 0.0
    rows[rng.integers(0, 2500, 40), Column.CONTACT] = 0.0
    rows[-260:, Column.CONTACT] = 1.0
    rows[:, Column.SATURATED] = rng.random(2500) < 0.001
    rows[:, Column.CLIPPED] = rng.random(2500) < 0.01
    rows[:, Column.ENERGY_OUT] = rng.normal(size=2500)
    rows[:, Column.RIPPLE] = rng.random(2500)
    if path == "impact":
        rows[:, Column.CONTACT] = depth > 0.0
    return rows, reference


@pytest.mark.parametrize("path", ["taps", "press", "impact"])
def test_the_chunks_do_not_matter(path):
    rows, reference = everything(path)
    scene = scene_of(path, len(rows))
    whole = result_of(rows, scene, reference)
    assert whole["stiffness"] is not None
    assert (whole["hold_error"] is not None) == (path == "press")
    assert (whole["restitution"] is not None) == (path == "impact")
    for size in (1, 2, 7, 250, 999, 2499):
        assert result_of(rows, scene, reference, size) == whole
    rows[:, Column.U : Column.V + 1] += np.random.default_rng(12).normal(size=(2500, 2))
    rows[1234:, Column.FAULT] = 1.0
    anchored = result_of(rows, scene, reference, root=2.0)
    assert all(anchored[name] for name in ANCHOR_NAMES)
    assert anchored["anchor_fault_s"] == rows[1234, Column.T]
    for size in (1, 7, 999):
        assert result_of(rows, scene, reference, size, root=2.0) == anchored


def test_all_names_are_there_and_json_takes_them(tmp_path):
    rows, reference = everything("press")
    metrics = Metrics(
        scene_of("press", 2500, transmission={"ratio": 8.0, "lever_m": 0.14}),
        TICK_S,
        controller="core",
        stiffness_predicted=np.float64(K),
        walls=[(np.float64(0.5), np.float64(1.0))],
    )
    metrics.update(rows, reference)
    result = metrics.result(wall_clock_s=1.25, clock_cycles=240_000)
    assert set(result) == NAMES
    assert {name for name, value in result.items() if value is None} == ANCHOR_NAMES | {
        "restitution", "swing_hz",
    }  # fmt: skip
    path = write_json(tmp_path / "out" / "metrics.json", result)
    assert json.loads(path.read_text(encoding="utf-8")) == result
    assert result["scene"] == "synthetic"
    assert result["controller"] == "core"
    assert result["ticks"] == 2500
    assert result["duration_s"] == pytest.approx(0.25)
    assert result["wall_clock_s"] == 1.25
    assert result["clock_cycles"] == 240_000


def test_what_a_scene_does_not_define_is_none():
    scene = scene_of(None, hand=None, encoder=None)
    metrics = Metrics(scene, TICK_S, controller="analog")
    nothing = metrics.result()
    given = {"scene", "controller", "duration_s", "ticks", "tick_hz", "k_l"}
    assert {name for name, value in nothing.items() if value not in (None, {})} == given
    assert set(nothing) == NAMES
    metrics.update(np.zeros((100, len(Column))))
    result = metrics.result()
    zero = {"peak_torque", "peak_current_a", "current_ripple_a", "free_space_torque_rms"}
    zero |= {"energy_out_max_j", "saturated_fraction", "clipped_fraction"}
    assert {name for name, value in result.items() if value not in (None, {})} == given | zero
    assert all(result[name] == 0.0 for name in zero)
    json.dumps(result, allow_nan=False)


def test_asking_for_the_result_does_not_disturb_the_run():
    rows, reference = everything("press")
    scene = scene_of("press", len(rows))
    metrics = Metrics(scene, TICK_S, controller="golden", stiffness_predicted=K, walls=WALLS)
    for start in range(0, len(rows), 100):
        metrics.update(rows[start : start + 100], reference[start : start + 100])
        json.dumps(metrics.result(), allow_nan=False)
    assert metrics.result() == result_of(rows, scene, reference)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    "column", [Column.X, Column.OMEGA, Column.I, Column.TORQUE, Column.ENERGY_OUT, Column.RIPPLE]
)
def test_a_run_that_has_left_the_finite_numbers_is_refused(bad, column):
    rows = np.zeros((10, len(Column)))
    rows[:, Column.T] = np.arange(10.0)
    rows[7, column] = bad
    with pytest.raises(FloatingPointError, match="t = 7 s"):
        result_of(rows)


def test_what_does_not_fit_is_refused():
    rows = np.zeros((10, len(Column)))
    metrics = Metrics(scene_of(), TICK_S, controller="golden")
    with pytest.raises(ValueError, match="rows must be"):
        metrics.update(rows[:, 1:])
    with pytest.raises(ValueError, match="reference rows are"):
        metrics.update(rows, rows[1:])
    metrics.update(rows, rows)
    with pytest.raises(ValueError, match="every chunk or with none"):
        metrics.update(rows)
    rows[:, Column.CONTACT] = 1.0
    with pytest.raises(ValueError, match="no walls"):
        metrics.update(rows, rows)


# The port anchor


def anchored_rows(chi: np.ndarray, i: np.ndarray, contact: np.ndarray) -> np.ndarray:
    """Rows of a rotor at rest whose port's flux at the ticks' middles is ``chi``, V·s, of s = 2."""
    rows = np.zeros((len(chi), len(Column)))
    motor = scene_of().motor
    rows[:, Column.T] = (np.arange(len(chi)) + 0.5) * TICK_S
    rows[:, Column.I] = i
    rows[:, Column.CONTACT] = contact
    flux = motor.L_h * i - chi
    ends = np.concatenate([flux[:1], 0.5 * (flux[1:] + flux[:-1]), flux[-1:]])
    rows[:, Column.U] = np.diff(ends) / TICK_S
    ends = np.concatenate([i[:1], 0.5 * (i[1:] + i[:-1]), i[-1:]])
    rows[:, Column.ENERGY_OUT] = 0.5 * motor.L_h * np.diff(ends**2)
    return rows


def test_correction_bound_counts_range_and_variation_of_each_contact():
    n = np.arange(400)
    contact = (n >= 100) & (n < 300)
    i = np.where(contact, 0.5 * np.sin(np.pi * (n - 100) / 200), 0.0)
    chi = np.where(contact, 1e-5 * np.sin(np.pi * (n - 100) / 100), 0.0)
    result = result_of(anchored_rows(chi, i, contact), root=2.0)
    assert result["correction_bound_j"] == pytest.approx(1e-5 * 2 * 0.5, rel=1e-2)
    assert result["anchor_fault_s"] is None


def test_correction_gives_what_its_flux_and_the_current_say():
    """∫ i dχ of a flux that grows while the current is there, and falls without it."""
    n = np.arange(400)
    i = np.interp(n, [0, 50, 250, 300], [0.0, 0.5, 0.5, 0.0])
    chi = np.interp(n, [0, 100, 200, 300, 400], [0.0, 0.0, 2e-5, 2e-5, 0.0])
    result = result_of(anchored_rows(chi, i, n < 0), root=2.0)
    assert result["correction_out_max_j"] == pytest.approx(1e-5, rel=2e-2)
    assert result["correction_out_max_j"] <= result["correction_bound_j"] <= 1.1e-5


def test_errors_of_position_and_speed_are_at_the_ticks_end_and_of_its_mean():
    rows = np.zeros((100, len(Column)))
    rows[:, Column.OMEGA] = 3.0
    rows[:, Column.X] = 3.0 * TICK_S * np.arange(100)
    rows[:, Column.X_HAT] = rows[:, Column.X] + 1.5 * TICK_S + 1e-4
    rows[:, Column.OMEGA_HAT] = 2.5
    result = result_of(rows, root=2.0)
    assert result["x_hat_error_rms_rad"] == pytest.approx(1e-4)
    assert result["omega_hat_error_rms"] == pytest.approx(0.5)
