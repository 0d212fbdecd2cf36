// SPDX-License-Identifier: Apache-2.0
//
// The controller's C interface, and what is only measured: many clocks in one call.

#include "pins_shim.cpp"

extern "C" {

// So many clocks with the same inputs; the pins after the last.
int64_t wh_bench_clocks(int64_t model, int64_t inputs, int64_t clocks) {
    int64_t out = 0;
    for (int64_t n = 0; n < clocks; ++n) out = wh_pins_clock(model, inputs);
    return out;
}

// The same, until a pin changes: what a loop could skip if it looked at the pins only then.
int64_t wh_bench_quiet(int64_t model, int64_t inputs, int64_t clocks) {
    int64_t changes = 0;
    int64_t before = -1;
    for (int64_t n = 0; n < clocks; ++n) {
        const int64_t out = wh_pins_clock(model, inputs);
        changes += out != before;
        before = out;
    }
    return changes;
}

}  // extern "C"
