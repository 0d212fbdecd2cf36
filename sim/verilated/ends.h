// SPDX-License-Identifier: Apache-2.0
//
// What a model does before it goes. Verilator's own clean-up asks the thread's context, which may be that of
// a model that has gone already.

#pragma once

#include "coverage.h"
#include "verilated.h"

inline void ends(VerilatedContext &context) {
    Verilated::threadContextp(&context);
    write_coverage(context);
}
