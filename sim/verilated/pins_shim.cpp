// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated controller (rtl/wh_controller.v, one port) at its pins, by the clock.

#include <cstdint>

#include "Vwh_controller.h"
#include "Vwh_controller___024root.h"
#include "ends.h"
#include "edges.h"
#include "give.h"
#include "verilated.h"
#include "words.h"

WH_EDGES(Vwh_controller)

namespace {

constexpr int64_t kOthers = -1;

struct Controller {
    VerilatedContext context;
    Vwh_controller top{&context};
    int64_t packets = 0;
    int64_t inputs = kOthers;  // at the last clock; kOthers: others than set_inputs() has changed since

    ~Controller() { ends(context); }
};

int64_t signed_word(uint64_t raw) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(raw << kUnused) >> kUnused;
}

constexpr uint64_t mask(int width) { return (uint64_t{1} << width) - 1; }

constexpr int kMostSetupClocks = 1 << 20;
constexpr int kFaultsShift = 11;  // of wh_pins_clock

void clock(Vwh_controller &top) {
    rise(top);
    fall(top);
}

// Bit 0 ADC data, bit 1 encoder A, bit 2 encoder B.
void set_inputs(Vwh_controller &top, int64_t inputs) {
    top.adc_sdata_i = inputs & 1;
    top.enc_a_i = (inputs >> 1) & 1;
    top.enc_b_i = (inputs >> 2) & 1;
}

}  // namespace

extern "C" {

// A controller just before its first tick, or null if its ADC never gets ready. Words are those of
// rtl/words.toml, as words.h takes them.
void *wh_pins_new(const uint32_t *words, int64_t inputs) {
    Controller *controller = new Controller;
    auto &top = controller->top;
    give_words(top, words);
    set_inputs(top, inputs);
    top.rst = 1;
    top.enable_i = 0;
    top.eval();
    for (int n = 0; n < 4; ++n) clock(top);
    top.rst = 0;
    top.enable_i = 1;
    // The frames that set an ADC up bring no words, so it needs no answers yet; a modulator's filter
    // settles on as many ones as zeros, 0 A.
    bool sclk = top.adc_sclk_o;
    for (int n = 0; !top.adc_ready_o; ++n) {
        if (n == kMostSetupClocks) {
            delete controller;
            return nullptr;
        }
        if (top.adc_sclk_o && !sclk) top.adc_sdata_i = !top.adc_sdata_i;
        sclk = top.adc_sclk_o;
        clock(top);
    }
    return controller;
}

// The link to a host, HOST = 1: periods of 2^log2 ticks, silence after so many of them.
void wh_pins_host(void *model, int64_t log2, int64_t timeout) {
    auto *controller = static_cast<Controller *>(model);
    auto &top = controller->top;
    controller->inputs = kOthers;
    top.host_period_log2_i = log2;
    top.host_timeout_i = timeout;
}

// An answer to packet `sequence`, for the next clock.
void wh_pins_answer(void *model, int64_t sequence, int64_t u) {
    auto *controller = static_cast<Controller *>(model);
    auto &top = controller->top;
    controller->inputs = kOthers;
    top.host_strobe_i = 1;
    top.host_sequence_i = sequence;
    top.host_u_i = u & mask(WH_DATA_W);
}

// The newest packet into words[0..2]: packets so far, number, mean of v; words[3]: active.
void wh_pins_packet(void *model, int64_t *words) {
    auto *controller = static_cast<Controller *>(model);
    words[0] = controller->packets;
    words[1] = controller->top.host_sequence_o;
    words[2] = signed_word(controller->top.host_v_o);
    words[3] = controller->top.host_active_o;
}

// The measured bus, BUS = 1, from the next clock on.
int64_t wh_pins_bus(int64_t model, int64_t word) {
    auto *controller = reinterpret_cast<Controller *>(model);
    controller->inputs = kOthers;
    controller->top.bus_i = word;
    return 0;
}

void wh_pins_delete(void *model) { delete static_cast<Controller *>(model); }

// One clock with these inputs (set_inputs). Returns, as they stand after the edge: bits 0-3 gates
// AH AL BH BL, 4 CS_n, 5 SCLK, 6 tick, 7 core valid, 8 contact, 9 overrun, 10 encoder fault, from 11 on
// the guard's faults.
int64_t wh_pins_clock(int64_t model, int64_t inputs) {
    auto *controller = reinterpret_cast<Controller *>(model);
    auto &top = controller->top;
    if (inputs == controller->inputs) {
        again(top);
    } else {
        set_inputs(top, inputs);
        rise(top);
        fall(top);
        controller->inputs = top.host_strobe_i ? kOthers : inputs;
        top.host_strobe_i = 0;
    }
    controller->packets += top.host_strobe_o;
    return top.gate_ah_o | top.gate_al_o << 1 | top.gate_bh_o << 2 | top.gate_bl_o << 3 |
           top.adc_cs_n_o << 4 | top.adc_sclk_o << 5 | top.tick_o << 6 | top.core_valid_o << 7 |
           top.contact_o << 8 | top.overrun_o << 9 | top.encoder_fault_o << 10 |
           int64_t{top.faults_o} << kFaultsShift;
}

// The words of the newest step into words[0..10]: i, u_n, v_n, e, whether the voltage limit acted, of
// the port anchor c, χ, ω̂'s lag, its fault, and the position, and whether a value was at its end.
int64_t wh_pins_words(int64_t model, int64_t words_address) {
    auto &top = reinterpret_cast<Controller *>(model)->top;
    int64_t *words = reinterpret_cast<int64_t *>(words_address);
    words[0] = signed_word(top.current_o);
    words[1] = signed_word(top.u_o);
    words[2] = signed_word(top.v_o);
    words[3] = signed_word(top.voltage_o);
    words[4] = top.saturated_o;
    words[5] = signed_word(top.correction_o);
    words[6] = signed_word(top.flux_o);
    words[7] = signed_word(top.lag_o);
    words[8] = top.anchor_fault_o;
    words[9] = static_cast<int32_t>(top.position_o);
    words[10] = top.clipped_o;
    return 0;
}

}  // extern "C"
