# SPDX-License-Identifier: Apache-2.0
"""Every word of small formats through wh_truncate, wh_saturate and wh_multiply."""

from __future__ import annotations

from pathlib import Path

import cocotb
import numpy as np
from cocotb.triggers import First, RisingEdge, Timer
from simulators import parameters

W = parameters()["W"]
SHORT_W = parameters()["LIMB_W"] + 1
WORDS = range(-(1 << (W - 1)), 1 << (W - 1))


def _fields(packed: int, count: int) -> list[int]:
    """Signed W-bit words out of a packed vector, the lowest first."""
    raw = [packed >> (W * n) & ((1 << W) - 1) for n in range(count)]
    return [word - (word >> (W - 1) << W) for word in raw]


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def truncate_is_toward_zero(dut) -> None:
    checked = 0
    for value in WORDS:
        dut.value_i.value = value & ((1 << W) - 1)
        await Timer(1, unit="ns")
        got = _fields(dut.truncated_o.value.to_unsigned(), W - 1)
        assert got == [int(value / 2**shift) for shift in range(1, W)], value
        checked += 1
    assert checked == 1 << W


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def saturate_limits_and_never_wraps(dut) -> None:
    checked = 0
    for value in WORDS:
        dut.value_i.value = value & ((1 << W) - 1)
        await Timer(1, unit="ns")
        got = _fields(dut.saturated_o.value.to_unsigned(), W - 2)
        tops = [1 << (width - 1) for width in range(2, W)]
        assert got == [min(max(value, -top), top - 1) for top in tops], value
        checked += 1
    assert checked == 1 << W


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def products_are_exact_three_clocks_late_and_stay(dut) -> None:
    dut.go_i.value = 1
    done = RisingEdge(dut.done_o)
    assert await First(done, Timer(9, unit="ms")) is done, "the bench never came to an end"
    assert dut.held_o.value == 1, "a product didn't stay"
    lines = Path("products.hex").read_text().splitlines()
    words = np.array([int(line, 16) for line in lines if not line.startswith("//")], dtype=object)
    assert words.size == 1 << (2 * W)

    def signed(raw: np.ndarray, width: int) -> np.ndarray:
        raw = raw & ((1 << width) - 1)
        return raw - (raw >> (width - 1) << width)

    pairs = np.arange(words.size, dtype=object)
    for data_w, coef_w in ((W, W), (W, SHORT_W), (SHORT_W, W), (SHORT_W, SHORT_W)):
        want = signed(pairs, data_w) * signed(pairs >> W, coef_w)
        wrong = np.flatnonzero(signed(words, data_w + coef_w) != want)
        assert wrong.size == 0, f"{data_w} x {coef_w} bits: {wrong.size} wrong, pair {wrong[0]:#x}"
        words = words >> (data_w + coef_w)
