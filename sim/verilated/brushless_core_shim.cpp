// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated ports of a brushless motor's two axes with their anchors
// (wh_core_axes.v): numbers in and out.

#include <cstdint>

#include "Vwh_core_axes.h"
#include "Vwh_core_axes___024root.h"
#include "ends.h"
#include "edges.h"
#include "give.h"
#include "verilated.h"
#include "words.h"

WH_EDGES(Vwh_core_axes)

namespace {

struct Core {
    VerilatedContext context;
    Vwh_core_axes top{&context};

    ~Core() { ends(context); }
};

static_assert(2 * WH_DATA_W <= 64, "both ports' words go through one of 64 bits");

constexpr int kNeverDone = 1000;

void clock(Core *core) {
    rise(core->top);
    fall(core->top);
}

uint64_t both(int64_t low, int64_t high) {
    constexpr uint64_t mask = (uint64_t{1} << WH_DATA_W) - 1;
    return (low & mask) | (high & mask) << WH_DATA_W;
}

// The signed word of a port out of both ports'.
int64_t word_of(uint64_t raw, int port) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(raw >> port * WH_DATA_W << kUnused) >> kUnused;
}

}  // namespace

extern "C" {

// A core after a reset, with the words of rtl/words.toml as words.h takes them, at a position whose
// angle is `zero`, or with `finds` isn't known, and a count of which is `turn`.
void *wh_axes_new(const uint32_t *words, int64_t position, int64_t zero, int64_t turn, int64_t finds) {
    Core *core = new Core;
    give_words(core->top, words);
    core->top.position_i = position;
    core->top.zero_angle_i = zero;
    core->top.count_angle_i = turn;
    core->top.find_magnet_i = finds;
    core->top.eval();  // the first one sees no edge
    core->top.rst = 1;
    clock(core);
    core->top.rst = 0;
    return core;
}

void wh_axes_delete(void *model) { delete static_cast<Core *>(model); }

// One tick. words: the currents of α and β, contact, position, whether the wall feels as W, and the ends of
// both currents' ranges; on return e, u_n and v_n of α and then of β, of both anchors c, offset, flux and
// lag, each of α and then of β, whether they have lost the rotor, whether a limit acted and whether a value
// was at its end. Returns the clocks from start to the end of all, or -1 when that never came.
int64_t wh_axes_step(int64_t model, int64_t words_address) {
    Core *core = reinterpret_cast<Core *>(model);
    int64_t *words = reinterpret_cast<int64_t *>(words_address);
    core->top.current_i = both(words[0], words[1]);
    core->top.contact_i = words[2] != 0;
    core->top.position_i = words[3];
    core->top.shaped_i = words[4] != 0;
    core->top.ends_i = words[5];
    core->top.eval();
    while (core->top.moving_o) clock(core);
    core->top.start_i = 1;
    clock(core);
    core->top.start_i = 0;
    int64_t clocks = 1;
    while (!core->top.done_o) {
        if (++clocks > kNeverDone) return -1;
        clock(core);
    }
    for (int port = 0; port < 2; ++port) {
        words[3 * port] = word_of(core->top.voltage_o, port);
        words[3 * port + 1] = word_of(core->top.u_o, port);
        words[3 * port + 2] = word_of(core->top.v_o, port);
        words[6 + port] = word_of(core->top.next_o, port);
        words[8 + port] = word_of(core->top.offset_o, port);
        words[10 + port] = word_of(core->top.flux_o, port);
        words[12 + port] = word_of(core->top.lag_o, port);
    }
    words[14] = core->top.fault_o;
    words[15] = core->top.saturated_o;
    words[16] = core->top.clipped_o;
    return clocks;
}

}  // extern "C"
