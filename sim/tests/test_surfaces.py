# SPDX-License-Identifier: Apache-2.0
"""The law of surfaces: passive whatever is written, and what real numbers make of it."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.controller import surfaces
from wavehaptics.controller.surfaces import (
    ACROSS,
    ETA,
    GAIN,
    MIX,
    MOST_ACTIVE,
    MOST_SURFACES,
    PLANE_WORDS,
    PORTS,
    PRESENT,
    VECTOR,
    VECTOR_WORDS,
    VECTORS,
    A,
    C,
    D,
    G,
    accepts,
    along,
    lose_across,
    pair_row,
    replace_along,
    surfaces_step,
    triple_row,
)
from wavehaptics.runtime.compiled import compiled_counting
from wavehaptics.words import formats

ONE = 1 << formats.SURFACE.fraction
ETA_ONE = 1 << formats.ETA.fraction
A_ONE = 1 << formats.A.fraction
MIX_ONE = 1 << formats.MIX.fraction
WAVE_MAX = formats.WAVE.raw_max
BEND = formats.CELLS.step * formats.CURRENT.step


@compiled_counting()
def every_reflection(q, ports, most_wave, most_y):
    """(cases, largest ``|u|² − |v|² − y² + p²``) over every accepted vector, wave and y."""
    one = 1 << q
    vector, before, waves = np.zeros(6, np.int64), np.zeros(3, np.int64), np.zeros(3, np.int64)
    cases, worst = 0, -(1 << 60)
    depth = one if ports == 3 else 0
    far = most_wave if ports == 3 else 0
    for g0 in range(-one, one + 1):
        for g1 in range(-one, one + 1):
            for g2 in range(-depth, depth + 1):
                if g0 * g0 + g1 * g1 + g2 * g2 > one * one:
                    continue
                vector[0], vector[1], vector[2] = g0, g1, g2
                for v0 in range(-most_wave, most_wave + 1):
                    for v1 in range(-most_wave, most_wave + 1):
                        for v2 in range(-far, far + 1):
                            before[0], before[1], before[2] = v0, v1, v2
                            p, side = along(vector, before, q)
                            square = v0 * v0 + v1 * v1 + v2 * v2
                            for y in range(-most_y, most_y + 1):
                                waves[:] = before
                                replace_along(vector, waves, p, side, y, q)
                                after = waves[0] ** 2 + waves[1] ** 2 + waves[2] ** 2
                                worst = max(worst, after - square - y * y + p * p)
                                cases += 1
    return cases, worst


@pytest.mark.parametrize(("q", "ports", "most_wave"), [(2, 2, 20), (4, 2, 9), (2, 3, 5)])
def test_no_reflection_gives_more_than_it_takes(q: int, ports: int, most_wave: int) -> None:
    """Every vector, wave and answer of short words: ``|u|² ≤ |v|² + y² − p²``."""
    cases, worst = every_reflection(q, ports, most_wave, 2 * most_wave)
    assert cases > 1_000_000
    assert worst == 0


@compiled_counting()
def every_loss(q, most_wave):
    one = 1 << q
    vector, waves = np.zeros(6, np.int64), np.zeros(3, np.int64)
    cases, worst = 0, -(1 << 60)
    for g0 in range(-one, one + 1):
        for g1 in range(-one, one + 1):
            if g0 * g0 + g1 * g1 > one * one:
                continue
            vector[0], vector[1] = g0, g1
            for v0 in range(-most_wave, most_wave + 1):
                for v1 in range(-most_wave, most_wave + 1):
                    for eta in range(one + 1):
                        waves[0], waves[1] = v0, v1
                        lose_across(vector, waves, eta, q, q)
                        after = waves[0] ** 2 + waves[1] ** 2
                        worst = max(worst, after - v0 * v0 - v1 * v1)
                        cases += 1
    return cases, worst


def test_no_loss_is_a_gain() -> None:
    cases, worst = every_loss(3, 20)
    assert cases > 1_000_000
    assert worst == 0


def random_words(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Words that a host may write, most of them senseless; a third of the vectors are as long as
    accepted."""
    planes = rng.integers(-(1 << 26), 1 << 26, (MOST_SURFACES, PLANE_WORDS))
    planes[:, PRESENT] = rng.random(MOST_SURFACES) < 0.6
    planes[:, D] = rng.integers(-(1 << 39), 1 << 39, MOST_SURFACES) >> rng.integers(0, 39)
    planes[:, ETA] = rng.choice([-ETA_ONE, ETA_ONE, -ETA_ONE // 2, 0], MOST_SURFACES)
    planes[:, ACROSS] = rng.choice([ETA_ONE, ETA_ONE - 1, ETA_ONE // 3], MOST_SURFACES)
    planes[:, A] = rng.choice([A_ONE, A_ONE - 1, A_ONE // 3, A_ONE // 1000, 1], MOST_SURFACES)
    vectors = rng.integers(-(1 << 26), 1 << 26, (VECTORS, VECTOR_WORDS))
    unit = rng.normal(size=(VECTORS, PORTS)) * (rng.random((VECTORS, PORTS)) < 0.8)
    unit /= np.maximum(np.linalg.norm(unit, axis=1), 1e-9)[:, None]
    length = rng.choice([1.0, 0.7, 0.0], (VECTORS, 1))
    vectors[:, VECTOR : VECTOR + PORTS] = np.trunc(unit * length * ONE)
    return planes, vectors


def squares(waves: np.ndarray) -> int:
    return sum(int(wave) ** 2 for wave in waves)


@pytest.mark.parametrize("budgets", [(0,), (1 << 50,), (0, 1 << 50, 1 << 45)])
@pytest.mark.parametrize("kind", ["full", "small", "echo"])
def test_a_group_gives_out_no_more_than_it_took(kind: str, budgets: tuple[int, ...]) -> None:
    """Random words and commits, waves of any size, and waves that are what came out before.

    Of several budgets one after another is set, and the largest is the bound.
    """
    rng = np.random.default_rng(7)
    seen: set[int] = set()
    for _ in range(40):
        state, spent = surfaces.new_state(), np.zeros(1, np.int64)
        active, limits = np.zeros(MOST_ACTIVE, np.int64), np.array([1 << 25, 0])
        taken, given = 0, 0
        waves = np.zeros(PORTS, np.int64)
        for period in range(400):
            if period % 50 == 0:
                planes, vectors = random_words(rng)
                assert accepts(planes, vectors)
                limits[surfaces.BUDGET] = budgets[period // 50 % len(budgets)]
            if kind == "full":
                waves[:] = rng.choice([-WAVE_MAX - 1, WAVE_MAX, 0, 1, -1, 12345678], PORTS)
            elif kind == "small":
                waves[:] = rng.integers(-3, 4, PORTS)
            elif period % 50 == 0:
                waves[:] = rng.integers(-WAVE_MAX, WAVE_MAX, PORTS)
            else:
                waves[:] = -waves
            taken += squares(waves)
            positions = rng.integers(-(1 << 31), 1 << 31, PORTS) >> rng.integers(0, 32)
            currents = rng.integers(-(1 << 30), 1 << 30, PORTS)
            free = int(rng.choice([ETA_ONE, ETA_ONE - 3, 0]))
            seen.add(surfaces_step(
                state, spent, active, planes, vectors, limits, positions, currents, free, waves
            ))  # fmt: skip
            given += squares(waves)
            assert given <= taken + max(budgets)
            assert 0 <= spent[0] <= max(budgets)
            assert (state[:, surfaces.ACCOUNT] >= 0).all()
    assert seen == {0, 1, 2, 3}


def test_a_changing_filter_gives_nothing() -> None:
    """A filter loaded with a = 1/2 and then slowed to a = 1/1000 would give out 500 times."""
    planes, vectors = surfaces.new_planes(), surfaces.new_vectors()
    planes[0, PRESENT], planes[0, ETA], planes[0, ACROSS] = 1, -ETA_ONE, ETA_ONE
    vectors[0, 0] = ONE
    state, spent = surfaces.new_state(), np.zeros(1, np.int64)
    active, nothing = np.zeros(3, np.int64), np.zeros(3, np.int64)
    taken, given = 0, 0
    for period in range(5000):
        planes[0, A] = A_ONE // 2 if period < 20 else A_ONE // 1000
        waves = np.array([1 << 20 if period < 20 else 0, 0, 0])
        taken += squares(waves)
        surfaces_step(
            state, spent, active, planes, vectors, np.zeros(2, np.int64), nothing, nothing,
            ETA_ONE, waves,
        )  # fmt: skip
        given += squares(waves)
    assert 0.9 * taken < given <= taken


@pytest.mark.parametrize(
    "change",
    [
        lambda planes, vectors: vectors.__setitem__((3, 0), ONE + 1),
        lambda planes, vectors: vectors.__setitem__((90, slice(0, 3)), ONE * 0.6),
        lambda planes, vectors: planes.__setitem__((2, ETA), ETA_ONE + 1),
        lambda planes, vectors: planes.__setitem__((2, ETA), -ETA_ONE - 1),
        lambda planes, vectors: planes.__setitem__((1, ACROSS), -1),
        lambda planes, vectors: planes.__setitem__((1, ACROSS), ETA_ONE + 1),
        lambda planes, vectors: planes.__setitem__((7, A), A_ONE + 1),
        lambda planes, vectors: planes.__setitem__((7, A), -1),
    ],
)
def test_words_that_could_give_out_energy_are_not_accepted(change) -> None:
    planes, vectors = surfaces.new_planes(), surfaces.new_vectors()
    vectors[5, 0] = ONE
    vectors[6, :3] = ONE // 2
    planes[:, ETA] = -ETA_ONE
    assert accepts(planes, vectors)
    change(planes, vectors)
    assert not accepts(planes, vectors)


def in_numbers(planes, vectors, limits, positions, currents, free, waves, filters, rests):
    """The law in real numbers, from its formulas alone; ``filters`` and ``rests`` are updated."""
    touching = []
    for n, plane in enumerate(planes):
        deep = plane[PRESENT] and plane[G : G + PORTS] @ positions / ONE >= plane[D] / 256
        if deep and len(touching) < MOST_ACTIVE:
            touching.append(n)
        else:
            filters[n], rests[n] = 0.0, None
    bends = {n: planes[n, C : C + PORTS] @ currents * BEND for n in touching}
    most = limits[0] * formats.WAVE.step
    velocity = {}
    for n in touching:
        plane = planes[n]
        rests[n] = bends[n] if rests[n] is None else rests[n]
        if len(touching) == 1:
            rests[n] = 0.0
        error = plane[G : G + PORTS] @ positions / ONE - plane[D] / 256 + bends[n] - rests[n]
        beyond = np.sign(error) * max(abs(error) - 0.5, 0.0)
        velocity[n] = np.clip(-beyond * plane[GAIN] / ONE, -most, most)
    rows = [lambda i, *_: i, lambda i, j, *_: pair_row(i, j), triple_row]
    chosen = [vectors[rows[order](*touching)] for order in range(len(touching))]
    v = waves * formats.WAVE.step
    if touching:
        across = planes[touching[0], ACROSS] if len(touching) == 1 else ETA_ONE
        eta = min(free, across) / ETA_ONE
        along_all = sum(row[:PORTS] / ONE * (row[:PORTS] / ONE @ v) for row in chosen)
        v = eta * v + (1.0 - eta) * along_all
    for order, (n, vector) in enumerate(zip(touching, chosen, strict=True)):
        g, shares = vector[:PORTS] / ONE, vector[MIX : MIX + 3] / MIX_ONE
        p = g @ v
        filters[n] += planes[n, A] / A_ONE * (planes[n, ETA] / ETA_ONE * p - filters[n])
        xi = sum(
            share * velocity[m] for share, m in zip(shares, touching[: order + 1], strict=False)
        )
        v = v + g * (filters[n] + np.clip(xi, -most, most) - p)
    return v, len(touching)


def test_the_integers_are_the_law() -> None:
    """Orthonormal sets, moving walls, filters and losses, to some last places of a wave."""
    rng = np.random.default_rng(11)
    counted = np.zeros(4, int)
    for _ in range(60):
        planes, vectors = surfaces.new_planes(), surfaces.new_vectors()
        basis, _ = np.linalg.qr(rng.normal(size=(PORTS, PORTS)))
        chosen = sorted(rng.choice(MOST_SURFACES, 3, replace=False).tolist())
        for n in chosen:
            planes[n, PRESENT] = 1
            unit = rng.normal(size=PORTS)
            planes[n, G : G + PORTS] = np.round(unit / np.linalg.norm(unit) * ONE)
            planes[n, D] = rng.integers(-1000, 1000)
            planes[n, C : C + PORTS] = rng.integers(-1000, 1000, PORTS)
            planes[n, GAIN] = rng.integers(0, ONE // 50)
            planes[n, A] = rng.choice([A_ONE, A_ONE // 20])
            planes[n, ETA] = rng.choice([-ETA_ONE, -ETA_ONE // 2])
            planes[n, ACROSS] = rng.choice([ETA_ONE, int(0.9 * ETA_ONE)])
        rows = (*chosen, *(pair_row(i, j) for i in chosen for j in chosen if i < j),
                triple_row(*chosen))  # fmt: skip
        for row, axis in zip(rows, (0, 1, 2, 1, 2, 2, 2), strict=True):
            vectors[row, :PORTS] = np.trunc(basis[axis] * ONE * (1.0 - 2.0**-24))
            vectors[row, MIX : MIX + 3] = rng.integers(-MIX_ONE, MIX_ONE, 3)
        assert accepts(planes, vectors)
        state, spent = surfaces.new_state(), np.zeros(1, np.int64)
        limits, filters = np.array([1 << 19, 1 << 60]), np.zeros(MOST_SURFACES)
        rests: list[float | None] = [None] * MOST_SURFACES
        active = np.zeros(MOST_ACTIVE, np.int64)
        positions = rng.integers(-40, 40, PORTS)
        for _ in range(30):
            positions = positions + rng.integers(-2, 3, PORTS)
            currents = rng.integers(-(1 << 22), 1 << 22, PORTS)
            waves = rng.integers(-(1 << 24), 1 << 24, PORTS)
            free = int(rng.choice([ETA_ONE, int(0.99 * ETA_ONE)]))
            wanted, touching = in_numbers(
                planes, vectors, limits, positions, currents, free, waves, filters, rests
            )
            found = surfaces_step(
                state, spent, active, planes, vectors, limits, positions, currents, free, waves
            )
            assert found == touching
            counted[found] += 1
            assert np.abs(waves * formats.WAVE.step - wanted).max() < 40 * formats.WAVE.step
    assert (counted > 50).all()


def test_a_rigid_plane_reflects_along_g_alone() -> None:
    planes, vectors = surfaces.new_planes(), surfaces.new_vectors()
    planes[0, PRESENT], planes[0, ETA], planes[0, A], planes[0, ACROSS] = (
        1,
        -ETA_ONE,
        A_ONE,
        ETA_ONE,
    )
    g = np.array([0.6, 0.8, 0.0])
    vectors[0, :3] = np.trunc(g * ONE)
    waves = np.round(np.array([0.3, -1.1, 0.7]) / formats.WAVE.step).astype(np.int64)
    wanted = (np.eye(3) - 2 * np.outer(g, g)) @ waves
    surfaces_step(
        surfaces.new_state(), np.zeros(1, np.int64), np.zeros(3, np.int64), planes, vectors,
        np.zeros(2, np.int64), np.zeros(3, np.int64), np.zeros(3, np.int64), ETA_ONE, waves,
    )  # fmt: skip
    assert waves == pytest.approx(wanted, abs=3)
