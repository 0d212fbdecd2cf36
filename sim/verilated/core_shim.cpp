// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated wave core with its anchor (wh_core_port.v): numbers in and out.

#include <cstdint>

#include "Vwh_core_port.h"
#include "Vwh_core_port___024root.h"
#include "ends.h"
#include "edges.h"
#include "give.h"
#include "verilated.h"
#include "words.h"

WH_EDGES(Vwh_core_port)

namespace {

struct Core {
    VerilatedContext context;
    Vwh_core_port top{&context};

    ~Core() { ends(context); }
};

constexpr int kNeverDone = 1000;

// Ports are unsigned in C++: carry the sign of a DATA_W-bit word into 64 bits.
int64_t signed_word(uint64_t raw) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(raw << kUnused) >> kUnused;
}

void clock(Core *core) {
    rise(core->top);
    fall(core->top);
}

constexpr uint64_t mask(int width) { return (uint64_t{1} << width) - 1; }

}  // namespace

extern "C" {

// Words of rtl/words.toml, as words.h takes them. Between two steps η may change; anything else asks
// for wh_core_stop.
void wh_core_set(void *model, const uint32_t *words) {
    give_words(static_cast<Core *>(model)->top, words);
}

// A reset of one clock, `into` clocks after a step began; with 0 no step is under way.
void wh_core_stop(void *model, int64_t into) {
    Core *core = static_cast<Core *>(model);
    core->top.start_i = into > 0;
    for (int64_t n = 0; n < into; ++n) {
        clock(core);
        core->top.start_i = 0;
    }
    core->top.rst = 1;
    clock(core);
    core->top.rst = 0;
}

void *wh_core_new(const uint32_t *words) {
    Core *core = new Core;
    wh_core_set(core, words);
    core->top.eval();  // the first one sees no edge
    wh_core_stop(core, 0);
    return core;
}

void wh_core_delete(void *model) { delete static_cast<Core *>(model); }

// One tick. words: current, contact, the shaper's mode, position, the ends of the current's range; on
// return e, u_n, v_n, of the anchor c, offset, flux, lag and fault, and whether the limit acted and a
// value was at its end. Returns the clocks from start to the end of both, or -1 when that never came.
int64_t wh_core_step(int64_t model, int64_t words_address) {
    Core *core = reinterpret_cast<Core *>(model);
    int64_t *words = reinterpret_cast<int64_t *>(words_address);
    core->top.current_i = words[0] & mask(WH_DATA_W);
    core->top.contact_i = words[1] != 0;
    core->top.shape_mode_i = words[2];
    core->top.position_i = words[3];
    core->top.ends_i = words[4];
    core->top.start_i = 1;
    clock(core);
    core->top.start_i = 0;
    int64_t clocks = 1;
    while (!core->top.done_o) {
        if (++clocks > kNeverDone) return -1;
        clock(core);
    }
    words[0] = signed_word(core->top.voltage_o);
    words[1] = signed_word(core->top.u_o);
    words[2] = signed_word(core->top.v_o);
    words[3] = signed_word(core->top.next_o);
    words[4] = signed_word(core->top.offset_o);
    words[5] = signed_word(core->top.flux_o);
    words[6] = signed_word(core->top.lag_o);
    words[7] = core->top.fault_o;
    words[8] = core->top.saturated_o;
    words[9] = core->top.clipped_o;
    return clocks;
}

}  // extern "C"
