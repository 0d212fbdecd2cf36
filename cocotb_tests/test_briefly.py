# SPDX-License-Identifier: Apache-2.0
"""Benches that take long on Icarus, by some of their tests, for `make check`."""

import pytest
from simulators import simulate
from test_device import SIZES as DEVICES
from test_settings import SIZES as MEMORIES

PORT = {"N": 1, "DELAY_LOG2": 2, "TICKS": 500}

BENCHES = {
    "anchor": (
        "bench_anchor",
        {},
        "any_words|a_reset_at_any_clock|waves_while_busy|a_swing_of_four_cells",
    ),
    "capture": (
        "bench_listeners",
        {"N": 1, "DEPTH_LOG2": 6},
        "orders_at_any_time|what_does_not_fit",
    ),
    "cobs": ("wh_cobs", {}, "without_credit|goes_first|credit_that_ends"),
    "device": ("wh_motor_device", DEVICES["one"], "nothing_on_the_bus|live_words|enable_waits"),
    "guard": ("wh_guard", {"N": 1}, "latches|off_or_damp|any_value|a_judgement|clear|rest|heat"),
    "host_link": ("wh_host_link", {}, "never_pays|a_late_answer|reset_in_mid_stream"),
    "modulator": ("wh_modulator", {"MIN_PULSE": 0}, "random_voltages|clips|latency|reset"),
    "settings": ("bench_settings", MEMORIES["one"], "defaults|range|off|readers|handed_on"),
    "shaper": ("bench_wave_core", {**PORT, "SHAPER": 2, "WITHHELD": 1, "TICKS": 2000}, "equals"),
    "stream": ("bench_listeners", {"N": 1, "CREDIT": 4000}, "too_fast|lasts_so_long"),
    "three_phase": ("wh_three_phase", {"MIN_PULSE": 0}, "mean_is|equal_legs|off_in_any_clock"),
    "uart": ("wh_uart", {}, "every_byte_is_sent|what_is_no_byte|reset_in_a_byte"),
    "wave_core": ("bench_wave_core", {**PORT, "OUTSIDE": 0, "TICKS": 2000}, "equals"),
    "wishbone": ("bench_wishbone", {}, "is_not_there|partial|alone|given_up|page"),
}
"""Top, parameters and which of the tests."""


@pytest.mark.parametrize("bench", BENCHES)
def test_briefly(bench: str, monkeypatch: pytest.MonkeyPatch) -> None:
    top, parameters, tests = BENCHES[bench]
    monkeypatch.setenv("COCOTB_TEST_FILTER", tests)
    module = "tb_wave_core" if top == "bench_wave_core" else f"tb_{bench}"
    simulate("icarus", top, module, parameters, name=f"{bench}-briefly")
