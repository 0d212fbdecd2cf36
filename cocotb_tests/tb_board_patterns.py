# SPDX-License-Identifier: Apache-2.0
"""A board whose line chooses between patterns of the bridge, of ``boards/<name>/patterns.toml``."""

from __future__ import annotations

import cocotb
from modbus_frames import words
from tb_board_controller import TICK
from tb_board_link import Armed
from wavehaptics.words.bridge_modes import HALF_BRIDGE, LOCKED, MODE_WORDS, SIGN_MAGNITUDE, UNIPOLAR
from wavehaptics.words.table import WORDS

MODE = WORDS["mode"].at()


async def legs(board: Armed) -> tuple[set[int], set[int]]:
    """What each leg shows in some ticks at about 0 V: 1 or 0 for its gate that is on."""
    seen: tuple[set[int], set[int]] = (set(), set())
    for _ in range(4 * TICK):
        await board.step()
        for leg, found in zip("ab", seen, strict=True):
            high, low = board.word(f"gate_{leg}h_o"), board.word(f"gate_{leg}l_o")
            assert not (high and low)
            if high or low:
                found.add(high)
    return seen


@cocotb.test(timeout_time=500, timeout_unit="ms")
async def the_line_chooses_the_pattern_with_the_bridge_off(dut: object) -> None:
    """At 0 V both legs switch in one pattern, and leg B rests in the other."""
    board = Armed(dut)
    await board.begin()
    await board.arm()
    assert await board.told("mode") == MODE_WORDS[LOCKED]
    assert await legs(board) == ({0, 1}, {0, 1})
    refused = await board.ask(words(MODE, [MODE_WORDS[SIGN_MAGNITUDE]]))
    assert refused.isError(), "the bridge is on"
    assert await board.told("mode") == MODE_WORDS[LOCKED]

    await board.give("arm", 0)
    await board.expect_off()
    for other in (UNIPOLAR, HALF_BRIDGE):
        assert (await board.ask(words(MODE, [MODE_WORDS[other]]))).isError(), other
    await board.give("mode", MODE_WORDS[SIGN_MAGNITUDE])
    await board.arm()
    assert await board.told("mode") == MODE_WORDS[SIGN_MAGNITUDE]
    _, second = await legs(board)
    assert len(second) == 1
    assert not board.word("fault_o")
