# SPDX-License-Identifier: Apache-2.0
"""Calling a function of a shared library from compiled Python by its address.

An address is an argument like any other, so a compiled loop is cached on disk although the library
is loaded somewhere else in each process.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


@intrinsic
def _call2(
    typing_context: Any, address: Any, first: Any, second: Any
) -> tuple[Any, Callable[..., Any]]:
    del typing_context, address, first, second
    signature = types.int64(types.int64, types.int64, types.int64)

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        del context, signature
        word = ir.IntType(64)
        pointer = builder.inttoptr(values[0], ir.FunctionType(word, [word, word]).as_pointer())
        return builder.call(pointer, values[1:])

    return signature, codegen


call2 = cast(Callable[[int, int, int], int], _call2)
"""``call2(address, a, b)``: the C function ``int64_t f(int64_t, int64_t)`` at that address."""
