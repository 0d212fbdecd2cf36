# SPDX-License-Identifier: Apache-2.0
"""Calling a function of a shared library from compiled Python by its address.

An address is an argument like any other, so a compiled loop is cached on disk although the library
is loaded somewhere else in each process.
"""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def _caller(arguments: int):
    @intrinsic
    def call(typing_context, address, *values):
        del typing_context
        signature = types.int64(types.int64, types.UniTuple(types.int64, arguments))

        def codegen(context, builder, signature, values):
            del context, signature
            word = ir.IntType(64)
            function = ir.FunctionType(word, [word] * arguments)
            pointer = builder.inttoptr(values[0], function.as_pointer())
            unpacked = [builder.extract_value(values[1], n) for n in range(arguments)]
            return builder.call(pointer, unpacked)

        return signature, codegen

    return call


call2 = _caller(2)
"""``call2(address, a, b)``: the C function ``int64_t f(int64_t, int64_t)`` at that address."""
call4 = _caller(4)
"""``call4(address, a, b, c, d)``: likewise with four arguments."""
