// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated wave core (rtl/wh_wave_core.v, one port): numbers in, numbers out.

#include <cstdint>

#include "Vwh_wave_core.h"
#include "verilated.h"

namespace {

struct Core {
    VerilatedContext context;
    Vwh_wave_core top{&context};
};

constexpr int kNeverDone = 1000;

// Ports are unsigned in C++: carry the sign of a DATA_W-bit word into 64 bits.
int64_t signed_word(uint64_t raw) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(raw << kUnused) >> kUnused;
}

void clock(Core *core) {
    core->top.clk = 1;
    core->top.eval();
    core->top.clk = 0;
    core->top.eval();
}

constexpr uint64_t mask(int width) { return (uint64_t{1} << width) - 1; }

}  // namespace

extern "C" {

void *wh_core_new(int64_t root, int64_t a, int64_t u_max, int64_t extra_ticks, int64_t hold_ticks) {
    Core *core = new Core;
    core->top.root_i = root & mask(WH_COEF_W);
    core->top.a_i = a & mask(WH_COEF_W);
    core->top.u_max_i = u_max & mask(WH_DATA_W);
    core->top.extra_ticks_i = extra_ticks;
    core->top.hold_ticks_i = hold_ticks;
    core->top.start_i = 0;
    core->top.rst = 1;
    clock(core);
    clock(core);
    core->top.rst = 0;
    return core;
}

void wh_core_delete(void *model) { delete static_cast<Core *>(model); }

// One tick: words[0] is the current and words[1] is eta; on return words[0..2] are e, u_n and v_n.
// Returns the clocks from start to valid, or -1 when the core never answered.
int64_t wh_core_step(int64_t model, int64_t words_address) {
    Core *core = reinterpret_cast<Core *>(model);
    int64_t *words = reinterpret_cast<int64_t *>(words_address);
    core->top.current_i = words[0] & mask(WH_DATA_W);
    core->top.eta_i = words[1] & mask(WH_COEF_W);
    core->top.start_i = 1;
    clock(core);
    core->top.start_i = 0;
    int64_t clocks = 1;
    while (!core->top.valid_o) {
        if (++clocks > kNeverDone) return -1;
        clock(core);
    }
    words[0] = signed_word(core->top.voltage_o);
    words[1] = signed_word(core->top.u_o);
    words[2] = signed_word(core->top.v_o);
    return clocks;
}

}  // extern "C"
