# SPDX-License-Identifier: Apache-2.0
"""Pictures: that they are drawn for every kind of run, at their size, and hide no peak."""

import struct
from pathlib import Path

import numpy as np
import pytest
from wavehaptics.trace import pictures

METRICS = {
    "scene": "synthetic",
    "controller": "golden",
    "hand": "taps",
    "duration_s": 1.0,
    "k_l": 2.2815,
    "stiffness": 1.9,
    "stiffness_predicted": 1.95,
    "stiffness_zero_rad": 1e-5,
    "contact_edge_rad": 0.0,
    "peak_torque": 0.02,
    "torque_nrmse_vs_analog": 3e-5,
    "restitution": None,
}
NOTHING = dict.fromkeys(METRICS) | {
    "scene": "empty",
    "controller": "analog",
    "duration_s": 1.0,
    "k_l": 1.0,
    "peak_torque": 0.0,
}


def trace_of(ticks: int = 3000, contacts: float = 3.0, side: float = 1.0) -> pictures.Trace:
    t = (np.arange(ticks) + 0.5) / ticks
    depth = -0.012 * np.cos(2.0 * np.pi * contacts * t)
    push = np.maximum(1.9 * depth, 0.0)
    return {
        "t": t,
        "x": side * depth,
        "torque": -side * push,
        "e_a": -100.0 * side * push,
        "u": -push,
        "v": push,
        "eta": np.where(depth > 0.0, -1.0, 1.0),
        "x_hand": 2.0 * side * depth,
        "energy_out": -push,
        "contact": depth > 0.0,
        "saturated": depth > 0.011,
    }


def still(ticks: int) -> pictures.Trace:
    trace = {name: np.zeros(ticks) for name in trace_of(1)}
    trace["t"] = np.arange(ticks) * 1e-3
    return trace


def size_of(path: Path) -> tuple[int, int]:
    header = path.read_bytes()[:24]
    assert header[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", header[16:24])


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("ticks", [300, 40_000])
@pytest.mark.parametrize("with_reference", [False, True])
def test_the_figures_of_the_paper(tmp_path, side, ticks, with_reference):
    run = trace_of(ticks, side=side)
    reference = trace_of(ticks, side=side) if with_reference else None
    for draw in (pictures.fig10, pictures.fig11):
        path = draw(run, reference, METRICS, tmp_path / "new" / f"{draw.__name__}.png")
        width, height = size_of(path)
        assert width == 1600
        assert 900 < height < 1600


@pytest.mark.parametrize("hand", [None, "impact", "press"])
def test_the_picture_of_a_run(tmp_path, hand):
    metrics = METRICS | {"hand": hand, "restitution": 0.97 if hand == "impact" else None}
    path = pictures.run_picture(trace_of(), metrics, tmp_path / "run.png", walls=[(0.0, 1.0)])
    assert size_of(path)[0] == 1600


@pytest.mark.parametrize("ticks", [1, 2, 100])
def test_a_run_in_which_nothing_happens(tmp_path, ticks):
    trace = still(ticks)
    for draw in (pictures.fig10, pictures.fig11):
        assert size_of(draw(trace, trace, NOTHING, tmp_path / "still.png"))[0] == 1600
    assert size_of(pictures.run_picture(trace, NOTHING, tmp_path / "run.png"))[0] == 1600


def test_a_reference_of_other_times_is_drawn_without_a_difference(tmp_path):
    path = pictures.fig10(trace_of(300), trace_of(500), METRICS, tmp_path / "a.png")
    both = pictures.fig10(trace_of(300), trace_of(300), METRICS, tmp_path / "b.png")
    assert size_of(path)[1] < size_of(both)[1]


def test_many_contacts_stay_few_bars():
    trace = trace_of(400_000, contacts=50_000.0)
    assert len(pictures._spans(trace, "contact", 1.0)) <= 1600


def test_spans_are_the_times_of_the_flag():
    trace = trace_of(3000)
    spans = pictures._spans(trace, "contact", 1e3)
    assert [start for start, _ in spans] == pytest.approx([83.3, 416.7, 750.0], abs=0.5)
    assert [length for _, length in spans] == pytest.approx([166.7] * 3, abs=0.5)
    assert pictures._spans(still(10), "contact", 1.0) == []


def test_the_envelope_keeps_every_peak_in_order():
    t = np.arange(1_000_000) * 1e-6
    y = np.sin(40.0 * t)
    y[123_456], y[765_432] = 5.0, -7.0
    t_drawn, y_drawn = pictures.envelope(t, y)
    assert len(t_drawn) == 4 * 1600
    assert np.all(np.diff(t_drawn) >= 0.0)
    assert y_drawn.max() == 5.0
    assert y_drawn.min() == -7.0
    assert (t_drawn[0], t_drawn[-1]) == (t[0], t[-1])
    short = pictures.envelope(t[:100], y[:100])
    assert np.array_equal(short[1], y[:100])


def test_the_path_keeps_what_is_fast():
    # A slow way of a million rows and a jump and back of twenty.
    x = np.concatenate([np.linspace(0.0, 1.0, 1_000_000), np.full(20, 1.0)])
    y = np.concatenate([np.zeros(1_000_000), np.sin(np.pi * np.arange(20) / 19)])
    kept = pictures._path(x, y)
    assert len(kept) <= 20_001
    # Its two highest rows are equal, so that one of them is enough.
    assert len(np.unique(y[kept])) == len(np.unique(y))
