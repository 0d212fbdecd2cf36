# SPDX-License-Identifier: Apache-2.0
"""Bench of ``rtl/wh_multiply_shared.v``: each user gets its own product, in time."""

from __future__ import annotations

import cocotb
from bench import Bench, pack, random_source
from simulators import parameters
from wavehaptics.words import formats

LATENCY = 3


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def every_user_is_served(dut: object) -> None:
    """Random requests: one grant a clock, to the lowest; its product 3 clocks later."""
    bench = Bench(dut)
    rng = random_source("requests")
    users = parameters()["USERS"]
    corners = (-1, 0, 1)
    waiting: list[tuple[int, int] | None] = [None] * users
    due: dict[int, tuple[int, int]] = {}
    served = [0] * users
    longest = 0
    since = [0] * users
    await bench.start(request_i=0, data_i=0, coef_i=0, drop_i=0)
    for clock in range(3000):
        for user in range(users):
            if waiting[user] is None and rng.random() < 0.3:
                data = (1 << (formats.DATA_W - 1)) * rng.choice(corners) + rng.choice(corners)
                coef = (1 << (formats.COEF_W - 1)) * rng.choice(corners) + rng.choice(corners)
                if rng.random() < 0.7:
                    data, coef = rng.getrandbits(formats.DATA_W), rng.getrandbits(formats.COEF_W)
                waiting[user] = wrap(data, formats.DATA_W), wrap(coef, formats.COEF_W)
                since[user] = clock
        request = sum(1 << user for user in range(users) if waiting[user] is not None)
        await bench.settle(
            request_i=request,
            data_i=pack((pair[0] if pair else 0 for pair in waiting), formats.DATA_W),
            coef_i=pack((pair[1] if pair else 0 for pair in waiting), formats.COEF_W),
        )
        grant, done = bench.word("grant_o"), bench.word("done_o")
        assert grant == request & -request
        expected = due.pop(clock, None)
        if expected is None:
            assert done == 0
        else:
            user, product = expected
            assert done == 1 << user
            assert bench.signed("product_o") == product
            served[user] += 1
        if grant:
            user = grant.bit_length() - 1
            data, coef = waiting[user]
            due[clock + LATENCY] = user, data * coef
            waiting[user] = None
            longest = max(longest, clock - since[user])
        await bench.step()
    assert min(served) > 20
    assert longest >= users - 1


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_forgets_products(dut: object) -> None:
    bench = Bench(dut)
    await bench.start(request_i=1, data_i=3, coef_i=5, drop_i=0)
    await bench.step()
    await bench.step(request_i=0, rst=1)
    bench.drive(rst=0)
    for _ in range(2 * LATENCY):
        assert bench.word("done_o") == 0
        await bench.step()


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def a_drop_forgets_one_users_products(dut: object) -> None:
    """Random drops: no product granted up to one comes after it, and all others come."""
    bench = Bench(dut)
    rng = random_source("drops")
    users = parameters()["USERS"]
    every = range(users)
    due: dict[int, int] = {}
    dropped = served = 0
    await bench.start(request_i=0, data_i=0, coef_i=0, drop_i=0)
    for clock in range(3000):
        drop = sum(1 << user for user in every if rng.random() < 0.1)
        request = sum(1 << user for user in every if rng.random() < 0.3)
        await bench.settle(request_i=request, drop_i=drop)
        assert bench.word("grant_o") == request & -request
        assert bench.word("done_o") == due.pop(clock, 0)
        if request:
            due[clock + LATENCY] = request & -request
            served += 1
        dropped += sum(user & drop != 0 for user in due.values())
        due = {at: user for at, user in due.items() if not user & drop}
        await bench.step()
    assert dropped > 100
    assert served - dropped > 500


def wrap(value: int, width: int) -> int:
    half = 1 << (width - 1)
    return (value + half) % (2 * half) - half
