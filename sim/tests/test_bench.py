# SPDX-License-Identifier: Apache-2.0
"""The bench: what it measures is what runs, by turns, and failures are told."""

from __future__ import annotations

import json

import pytest
from rich.console import Console
from wavetools.studies.bench import measure, once


@pytest.mark.parametrize("controller", ["golden", "encoder"])
def test_a_controller_is_measured_as_often_as_is_asked(controller):
    known, measure_once = once.whole(controller, 0.1)
    assert (known["ticks"], known["duration_s"]) == (100_000, 0.1)
    assert known["clock_cycles"] is None
    for seconds in (measure_once(), measure_once()):
        assert seconds["cpu_s"] > 0
        assert seconds["wall_s"] > 0


def test_every_controller_presses_into_the_wall():
    """The first tap meets it after an eighth of a second; without torque an error means nothing."""
    assert min(once.DURATIONS_S.values()) >= 0.2
    assert set(once.DURATIONS_S) == set(measure.CONTROLLERS)


def test_a_process_measures_each_time_that_it_is_asked():
    with measure._runner("encoder") as runner:
        ((first, second),) = measure._by_turns([runner], 2)
    assert runner.known["ticks"] == round(1e6 * once.DURATIONS_S["encoder"])
    assert first["cpu_s"] > 0 < second["cpu_s"]
    assert runner.process.returncode == 0


def test_what_fails_is_told():
    with pytest.raises(measure.MeasurementError, match="nothing"), measure._runner("nothing"):
        pass


def test_runners_take_turns():
    """What else the machine does then falls on both."""
    order = []

    class Fake:
        def __init__(self, name: str) -> None:
            self.name = name

        def once(self):
            order.append(self.name)
            return {"cpu_s": 1.0, "wall_s": 2.0}

    found = measure._by_turns([Fake("A"), Fake("B")], 3)
    assert order == list("ABABAB")
    assert [len(kept) for kept in found] == [3, 3]


def test_table_of_a_summary():
    speed = {"simulated_s_per_s": 0.15, "ticks_per_s": 1.5e5, "cycles_per_s": None,
             "times_pins": 40.0, "torque_error": 1e-3}  # fmt: skip
    console = Console(record=True, width=160)
    console.print(measure.table(json.loads(json.dumps({"controllers": {"golden": speed}}))))
    text = console.export_text()
    for part in ("golden", "0.15", "1.5·10⁵", "0.1 %"):
        assert part in text
