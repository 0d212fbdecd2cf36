# SPDX-License-Identifier: Apache-2.0
"""The soak: it finds nothing, and finds what is planted."""

from __future__ import annotations

import numpy as np
import pytest
from wavehaptics.controller import wave_core
from wavehaptics.words import formats
from wavetools.checks import soak

TICKS = 60_000


def test_nothing_is_found():
    found = soak.soak(3, TICKS)
    print(found)
    assert found["wrong"] is None
    assert found["ticks"] >= TICKS
    assert found["resets"] > 2
    assert found["spells"] > 50
    assert 0 < found["touched"] < found["ticks"]


def planted(monkeypatch, place: int, change):
    """Let the RTL have other settings than the integer model."""
    told = soak._set_eta

    def other(library, model, set_, spell):
        spell = spell.copy()
        spell[place] = change(spell[place])
        told(library, model, set_, spell)

    monkeypatch.setattr(soak, "_set_eta", other)
    return soak.soak(3, TICKS)


def test_a_last_place_of_eta_is_found(monkeypatch):
    found = planted(monkeypatch, soak._ETA_IN, lambda eta: eta - 1 if eta > 0 else eta + 1)
    assert "words" in found["wrong"]
    assert found["ticks"] < TICKS


def test_energy_that_the_waves_give_out_is_found(monkeypatch):
    spell = soak._spell

    def greedy(rng):
        chosen = spell(rng)
        chosen[[soak._ETA_IN, soak._ETA_OUT]] = (1 << formats.ETA.fraction) * 5 // 4
        chosen[soak._MODE] = wave_core.HOLD
        return chosen

    monkeypatch.setattr(soak, "_spell", greedy)
    assert "energy" in soak.soak(3, TICKS)["wrong"]


def test_the_summary_adds_up_and_names_the_seeds():
    one = {"seed": 1, "ticks": 10, "wrong": None}
    two = {"seed": 2, "ticks": 5, "wrong": "episode 0, tick 3: something"}
    assert soak.summary([one, two]) == {
        "ticks": 15, "wrong": ["seed 2, episode 0, tick 3: something"],
    }  # fmt: skip


@pytest.mark.parametrize("ticks", [1, 500_000, 500_001])
def test_the_tasks_cover_the_ticks(ticks):
    tasks = soak.tasks(ticks, seed=7)
    assert sum(task.arguments["ticks"] for task in tasks) >= ticks
    assert len({task.arguments["seed"] for task in tasks}) == len(tasks)
    assert np.diff([task.arguments["seed"] for task in tasks]).tolist() == [1] * (len(tasks) - 1)
