# SPDX-License-Identifier: Apache-2.0
"""The trace file: what goes in comes out, thinned alike however the run is cut into chunks."""

import numpy as np
import pytest
from wavehaptics.trace import columns
from wavehaptics.trace.columns import (
    FLOAT_COLUMNS,
    Column,
    TraceWriter,
    Word,
    load_trace,
    put_anchor,
    put_estimate,
    put_motion,
    put_port,
    write_npz,
)

TICK_S = 1e-6


def run_of(ticks: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(ticks, len(Column)))
    rows[:, Column.T] = (np.arange(ticks) + 0.5) * TICK_S
    rows[:, Column.CONTACT] = rng.integers(0, 2, ticks)
    rows[:, Column.SATURATED] = rng.integers(0, 2, ticks)
    rows[:, Column.CLIPPED] = rng.integers(0, 2, ticks)
    words = rng.integers(-(1 << 30), 1 << 30, size=(ticks, len(Word)))
    words[0], words[-1] = -(1 << 30), (1 << 30) - 1
    return rows, words


def chunks(ticks: int, size: int) -> list[slice]:
    return [slice(start, min(start + size, ticks)) for start in range(0, ticks, size)]


def test_every_tick_comes_back(tmp_path):
    rows, words = run_of(1000)
    writer = TraceWriter(tmp_path / "run", TICK_S, ticks=1000)
    for part in chunks(1000, 300):
        writer.write(rows[part], words[part])
    path = writer.save()
    assert path == tmp_path / "run" / "trace.npz"
    assert [p.name for p in path.parent.iterdir()] == ["trace.npz"]
    loaded = load_trace(path.parent)
    assert set(loaded) == {
        *("t", "x", "omega", "i", "e_a", "torque", "eta", "u", "v", "x_hand", "energy_out"),
        *("contact", "saturated", "clipped", "i_word", "u_word", "v_word", "e_word"),
    }
    for column in FLOAT_COLUMNS:
        assert np.array_equal(loaded[column.name.lower()], rows[:, column])
    for word in Word:
        assert np.array_equal(loaded[f"{word.name.lower()}_word"], words[:, word])
    for column in (Column.CONTACT, Column.SATURATED, Column.CLIPPED):
        flag = loaded[column.name.lower()]
        assert flag.dtype == np.bool_
        assert np.array_equal(flag, rows[:, column] == 1.0)
    assert np.array_equal(loaded["energy_out"], np.cumsum(rows[:, Column.ENERGY_OUT]))


@pytest.mark.parametrize("size", [1, 2, 3, 7, 64, 999, 1000, 5000])
@pytest.mark.parametrize(("trace_hz", "step"), [(1e5, 10), (3e5, 3), (7e5, 1), (90.0, 11111)])
def test_thinning_does_not_depend_on_the_chunks(tmp_path, size, trace_hz, step):
    rows, words = run_of(2000)
    writer = TraceWriter(tmp_path, TICK_S, trace_hz)
    assert writer.step == step
    for part in chunks(2000, size):
        writer.write(rows[part], words[part])
    kept = writer.arrays()
    assert writer.kept == len(kept["t"]) == len(range(0, 2000, step))
    assert np.array_equal(kept["t"], rows[::step, Column.T])
    assert np.array_equal(kept["x_hand"], rows[::step, Column.X_HAND])
    assert np.array_equal(kept["contact"], rows[::step, Column.CONTACT] == 1.0)
    assert np.array_equal(kept["e_word"], words[::step, Word.E])
    # The energy is summed over all ticks, not only over those that are kept.
    assert np.array_equal(kept["energy_out"], np.cumsum(rows[:, Column.ENERGY_OUT])[::step])


@pytest.mark.parametrize("size", [1, 7, 1000])
def test_an_anchor_adds_what_it_knows(tmp_path, size):
    rows, words = run_of(1000)
    rows[:, Column.FAULT] = np.arange(1000) > 500
    writer = TraceWriter(tmp_path, TICK_S, 3e5, anchored=True)
    plain = TraceWriter(tmp_path, TICK_S, 3e5)
    for part in chunks(1000, size):
        writer.write(rows[part], words[part])
        plain.write(rows[part], words[part])
    kept, before = writer.arrays(), plain.arrays()
    names = {"x_hat", "omega_hat", "correction", "flux", "fault"}
    assert set(kept) - set(before) == names
    assert all(np.array_equal(kept[name], before[name]) for name in before)
    for name in names - {"fault"}:
        assert np.array_equal(kept[name], rows[::3, Column[name.upper()]])
    assert np.array_equal(kept["fault"], np.arange(1000)[::3] > 500)


def test_memory_grows_past_the_ticks_that_were_expected(tmp_path):
    rows, words = run_of(500)
    writer = TraceWriter(tmp_path, TICK_S, ticks=10)
    for part in chunks(500, 33):
        writer.write(rows[part], words[part])
    kept = writer.arrays()
    assert np.array_equal(kept["torque"], rows[:, Column.TORQUE])
    assert np.array_equal(kept["i_word"], words[:, Word.I])


def test_a_controller_without_words_has_none_in_the_file(tmp_path):
    rows, _ = run_of(10)
    writer = TraceWriter(tmp_path / "other.npz", TICK_S)
    writer.write(rows)
    assert writer.save() == tmp_path / "other.npz"
    assert not any(name.endswith("_word") for name in load_trace(tmp_path / "other.npz"))


def test_an_empty_run_is_a_file_too(tmp_path):
    TraceWriter(tmp_path, TICK_S).save()
    assert load_trace(tmp_path)["t"].shape == (0,)


def test_a_failed_save_leaves_the_old_file(tmp_path, monkeypatch):
    rows, words = run_of(10)
    writer = TraceWriter(tmp_path, TICK_S)
    writer.write(rows, words)
    before = writer.save().read_bytes()

    def fail(file, **arrays):
        file.write(b"half a file")
        raise OSError("disk full")

    monkeypatch.setattr(columns.np, "savez", fail)
    writer.write(rows, words)
    with pytest.raises(OSError, match="disk full"):
        writer.save()
    assert [p.name for p in tmp_path.iterdir()] == ["trace.npz"]
    assert (tmp_path / "trace.npz").read_bytes() == before


def test_what_does_not_fit_is_refused(tmp_path):
    rows, words = run_of(10)
    writer = TraceWriter(tmp_path, TICK_S)
    with pytest.raises(ValueError, match="rows must be"):
        writer.write(rows[:, :-1])
    with pytest.raises(ValueError, match="words must be"):
        writer.write(rows, words[:5])
    writer.write(rows, words)
    with pytest.raises(ValueError, match="every chunk or with none"):
        writer.write(rows)
    assert writer.kept == 10
    with pytest.raises(ValueError, match="above zero"):
        TraceWriter(tmp_path, 0.0)
    with pytest.raises(ValueError, match="above zero"):
        TraceWriter(tmp_path, TICK_S, 0.0)


def test_a_tick_is_written_whole():
    """Motor, port and anchor fill every column of a row, each once."""
    row, parts = np.full(len(Column), np.nan), []
    for put, values in (
        (put_motion, (1.0, 0.5, 2.0, 3.0, 0.25, 6.0, 0.125, 7.0, 8.0, 9.0)),
        (put_port, (-1.0, 10.0, 11.0, True, False, True)),
        (put_anchor, (12.0, 1)),
        (put_estimate, (13.0, 14.0, 15.0)),
    ):
        before = np.isnan(row)
        put.py_func(row, *values)
        parts.append(int(np.count_nonzero(before & ~np.isnan(row))))
    assert parts == [9, 6, 2, 3]
    assert not np.isnan(row).any()
    assert row[[Column.T, Column.X, Column.OMEGA]].tolist() == [1.25, 2.5, 2.0]
    flags = row[[Column.CONTACT, Column.SATURATED, Column.CLIPPED]]
    assert flags.tolist() == [1.0, 0.0, 1.0]


def test_a_trace_that_was_cut(tmp_path):
    """Wherever: one line with its path."""
    path = write_npz(tmp_path / "trace.npz", {"t": np.arange(300.0), "x": np.zeros(300)})
    whole = path.read_bytes()
    for length in (*range(0, len(whole), 101), len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(
            ValueError, match=r"trace.npz: is no whole trace; was it cut\?"
        ) as error:
            load_trace(tmp_path)
        assert "\n" not in str(error.value)
