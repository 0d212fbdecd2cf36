// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated wave core of a brushless motor's two ports (rtl/wh_wave_core.v, N = 2):
// numbers in and out.

#include <cstdint>

#include "Vwh_wave_core.h"
#include "Vwh_wave_core___024root.h"
#include "ends.h"
#include "edges.h"
#include "give.h"
#include "verilated.h"
#include "words.h"

WH_EDGES(Vwh_wave_core)

namespace {

struct Core {
    VerilatedContext context;
    Vwh_wave_core top{&context};

    ~Core() { ends(context); }
};

static_assert(2 * WH_DATA_W <= 64, "both ports' words go through one of 64 bits");

constexpr int kNeverDone = 1000;

void clock(Core *core) {
    rise(core->top);
    fall(core->top);
}

uint64_t both(int64_t low, int64_t high, int width) {
    const uint64_t mask = (uint64_t{1} << width) - 1;
    return (low & mask) | (high & mask) << width;
}

// The signed word of a port out of both ports'.
int64_t word_of(uint64_t raw, int port) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(raw >> port * WH_DATA_W << kUnused) >> kUnused;
}

}  // namespace

extern "C" {

// A core after a reset, with the words of rtl/words.toml as words.h takes them.
void *wh_axes_new(const uint32_t *words) {
    Core *core = new Core;
    give_words(core->top, words);
    core->top.eval();  // the first one sees no edge
    core->top.rst = 1;
    clock(core);
    core->top.rst = 0;
    return core;
}

void wh_axes_delete(void *model) { delete static_cast<Core *>(model); }

// One tick. words: the currents of α and β, and η; on return e, u_n and v_n of α and then of β. Returns
// the clocks from start to the end, or -1 when that never came.
int64_t wh_axes_step(int64_t model, int64_t words_address) {
    Core *core = reinterpret_cast<Core *>(model);
    int64_t *words = reinterpret_cast<int64_t *>(words_address);
    core->top.current_i = both(words[0], words[1], WH_DATA_W);
    core->top.eta_i = both(words[2], words[2], WH_COEF_W);
    core->top.start_i = 1;
    clock(core);
    core->top.start_i = 0;
    int64_t clocks = 1;
    while (!core->top.valid_o) {
        if (++clocks > kNeverDone) return -1;
        clock(core);
    }
    for (int port = 0; port < 2; ++port) {
        words[3 * port] = word_of(core->top.voltage_o, port);
        words[3 * port + 1] = word_of(core->top.u_o, port);
        words[3 * port + 2] = word_of(core->top.v_o, port);
    }
    return clocks;
}

}  // extern "C"
