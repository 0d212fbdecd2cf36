// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated controller of a brushless motor (rtl/wh_brushless.v) at its pins, by the
// clock.

#include <cstdint>

#include "Vwh_brushless.h"
#include "Vwh_brushless___024root.h"
#include "ends.h"
#include "edges.h"
#include "give.h"
#include "verilated.h"
#include "words.h"

WH_EDGES(Vwh_brushless)

namespace {

struct Controller {
    VerilatedContext context;
    Vwh_brushless top{&context};
    int64_t inputs = -1;  // at the last clock; -1: others than set_inputs() has changed since

    ~Controller() { ends(context); }
};

static_assert(2 * WH_DATA_W <= 64, "both ports' words go through one of 64 bits");

constexpr int kMostSetupClocks = 1 << 20;

// The signed word of an axis out of both axes'.
int64_t word_of(uint64_t raw, int axis) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(raw >> axis * WH_DATA_W << kUnused) >> kUnused;
}

// Bits 0 and 1 ADC data of the phases a and b, 2 encoder A, 3 encoder B.
void set_inputs(Vwh_brushless &top, int64_t inputs) {
    top.adc_sdata_i = inputs & 3;
    top.enc_a_i = (inputs >> 2) & 1;
    top.enc_b_i = (inputs >> 3) & 1;
}

}  // namespace

extern "C" {

// A controller just before its first tick, or null if its ADC never gets ready. Words are those of
// rtl/words.toml, as words.h takes them; `shape` are those of W, which are no words of the table here, and
// behind them which walls feel so, each a word of 32 bits or more.
void *wh_brushless_new(const uint32_t *words, int64_t inputs, int64_t shape) {
    Controller *controller = new Controller;
    auto &top = controller->top;
    give_words(top, words);
    const uint32_t *shape_words = reinterpret_cast<const uint32_t *>(shape);
    give(top.shape_words_i, shape_words);
    give(top.wall_shaped_i, shape_words + sizeof(top.shape_words_i) / sizeof(uint32_t));
    set_inputs(top, inputs);
    top.rst = 1;
    top.enable_i = 0;
    top.eval();  // the first one sees no edge
    for (int n = 0; n < 4; ++n) {
        rise(top);
        fall(top);
    }
    top.rst = 0;
    top.enable_i = 1;
    // The frames that set an ADC up bring no words, so it needs no answers yet.
    for (int n = 0; !top.adc_ready_o; ++n) {
        if (n == kMostSetupClocks) {
            delete controller;
            return nullptr;
        }
        rise(top);
        fall(top);
    }
    return controller;
}

void wh_brushless_delete(void *model) { delete static_cast<Controller *>(model); }

// One clock with these inputs (set_inputs). Returns, as they stand after the edge: bits 0-2 high gates
// of the legs a, b and c, 3-5 low gates, 6 CS_n, 7 SCLK, 8 tick, 9 core valid, 10 contact, 11 overrun,
// 12 encoder fault, from 13 on the guard's faults.
int64_t wh_brushless_clock(int64_t model, int64_t inputs) {
    auto *controller = reinterpret_cast<Controller *>(model);
    auto &top = controller->top;
    if (inputs == controller->inputs) {
        again(top);
    } else {
        set_inputs(top, inputs);
        rise(top);
        fall(top);
        controller->inputs = inputs;
    }
    return top.gate_high_o | top.gate_low_o << 3 | top.adc_cs_n_o << 6 | top.adc_sclk_o << 7 |
           top.tick_o << 8 | top.core_valid_o << 9 | top.contact_o << 10 | top.overrun_o << 11 |
           top.encoder_fault_o << 12 | int64_t{top.faults_o} << 13;
}

// The words of the newest step into words[0..17]: i, u_n, v_n, e of alpha, then of beta, whether the
// voltage limit acted on either; of the anchors c, χ and ω̂'s lag, of alpha and then of beta, whether they
// have lost the rotor, the position, and whether a value of either was at its end.
int64_t wh_brushless_words(int64_t model, int64_t words_address) {
    auto &top = reinterpret_cast<Controller *>(model)->top;
    int64_t *words = reinterpret_cast<int64_t *>(words_address);
    for (int axis = 0; axis < 2; ++axis) {
        words[4 * axis] = word_of(top.current_o, axis);
        words[4 * axis + 1] = word_of(top.u_o, axis);
        words[4 * axis + 2] = word_of(top.v_o, axis);
        words[4 * axis + 3] = word_of(top.voltage_o, axis);
    }
    words[8] = top.saturated_o;
    for (int axis = 0; axis < 2; ++axis) {
        words[9 + axis] = word_of(top.correction_o, axis);
        words[11 + axis] = word_of(top.flux_o, axis);
        words[13 + axis] = word_of(top.lag_o, axis);
    }
    words[15] = top.anchor_fault_o;
    words[16] = static_cast<int32_t>(top.position_o);
    words[17] = top.clipped_o;
    return 0;
}

}  // extern "C"
