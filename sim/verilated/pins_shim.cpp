// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated controller (rtl/wh_controller.v, one port) at its pins, by the clock.

#include <cstdint>

#include "Vwh_controller.h"
#include "verilated.h"

namespace {

struct Controller {
    VerilatedContext context;
    Vwh_controller top{&context};
};

int64_t signed_word(uint64_t raw) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(raw << kUnused) >> kUnused;
}

constexpr uint64_t mask(int width) { return (uint64_t{1} << width) - 1; }

// Sets bits [width*index +: width] of a wide port. Verilator keeps wide ports in 32-bit words.
template <class Port>
void set_count(Port &port, int index, int64_t value) {
    static_assert(WH_COUNT_W == 32, "a wall's edge is one 32-bit word of the port");
    port[index] = static_cast<uint32_t>(value);
}

// Order of the parameters in the array that wh_pins_new takes: that of controller_ports in
// sim/wavehaptics/pins.py.
enum Parameter {
    kHalfClocks, kTickHalves, kSampleClocks, kSamples, kSampleLead,
    kSclkHalfClocks, kFrameBits, kLeadBits, kDataBits, kQuietClocks,
    kZero, kGain, kFilterClocks, kEtaContact, kEtaFree, kRoot, kA, kUMax,
    kExtraTicks, kHoldTicks, kClocksPerVolt, kDeadClocks, kWalls, kWallEdges
};

}  // namespace

extern "C" {

void *wh_pins_new(const int64_t *p) {
    Controller *controller = new Controller;
    auto &top = controller->top;
    top.half_clocks_i = p[kHalfClocks];
    top.tick_halves_i = p[kTickHalves];
    top.sample_clocks_i = p[kSampleClocks];
    top.samples_i = p[kSamples];
    top.sample_lead_i = p[kSampleLead];
    top.sclk_half_clocks_i = p[kSclkHalfClocks];
    top.frame_bits_i = p[kFrameBits];
    top.lead_bits_i = p[kLeadBits];
    top.data_bits_i = p[kDataBits];
    top.quiet_clocks_i = p[kQuietClocks];
    top.zero_i = p[kZero] & mask(WH_SUM_W);
    top.gain_i = p[kGain] & mask(WH_COEF_W);
    top.filter_clocks_i = p[kFilterClocks];
    top.eta_contact_i = p[kEtaContact] & mask(WH_COEF_W);
    top.eta_free_i = p[kEtaFree] & mask(WH_COEF_W);
    top.root_i = p[kRoot] & mask(WH_COEF_W);
    top.a_i = p[kA] & mask(WH_COEF_W);
    top.u_max_i = p[kUMax] & mask(WH_DATA_W);
    top.extra_ticks_i = p[kExtraTicks];
    top.hold_ticks_i = p[kHoldTicks];
    top.clocks_per_volt_i = p[kClocksPerVolt] & mask(WH_COEF_W);
    top.dead_clocks_i = p[kDeadClocks];
    for (int n = 0; n < p[kWalls]; ++n) {
        set_count(top.wall_min_i, n, p[kWallEdges + 2 * n]);
        set_count(top.wall_max_i, n, p[kWallEdges + 2 * n + 1]);
    }
    top.wall_enable_i = mask(static_cast<int>(p[kWalls]));
    top.rst = 1;
    top.enable_i = 0;
    for (int n = 0; n < 4; ++n) {
        top.clk = 1;
        top.eval();
        top.clk = 0;
        top.eval();
    }
    top.rst = 0;
    top.enable_i = 1;
    return controller;
}

void wh_pins_delete(void *model) { delete static_cast<Controller *>(model); }

// One clock. Inputs: bit 0 ADC data, bit 1 encoder A, bit 2 encoder B. Returns, as they stand after
// the edge: bits 0-3 gates AH AL BH BL, 4 CS_n, 5 SCLK, 6 tick, 7 core valid, 8 contact,
// 9 overrun, 10 encoder fault.
int64_t wh_pins_clock(int64_t model, int64_t inputs) {
    auto &top = reinterpret_cast<Controller *>(model)->top;
    top.adc_sdata_i = inputs & 1;
    top.enc_a_i = (inputs >> 1) & 1;
    top.enc_b_i = (inputs >> 2) & 1;
    top.clk = 1;
    top.eval();
    const int64_t out = top.gate_ah_o | top.gate_al_o << 1 | top.gate_bh_o << 2 |
                        top.gate_bl_o << 3 | top.adc_cs_n_o << 4 | top.adc_sclk_o << 5 |
                        top.tick_o << 6 | top.core_valid_o << 7 | top.contact_o << 8 |
                        top.overrun_o << 9 | top.encoder_fault_o << 10;
    top.clk = 0;
    top.eval();
    return out;
}

// The words of the newest step into words[0..3]: i, u_n, v_n, e.
int64_t wh_pins_words(int64_t model, int64_t words_address) {
    auto &top = reinterpret_cast<Controller *>(model)->top;
    int64_t *words = reinterpret_cast<int64_t *>(words_address);
    words[0] = signed_word(top.current_o);
    words[1] = signed_word(top.u_o);
    words[2] = signed_word(top.v_o);
    words[3] = signed_word(top.voltage_o);
    return 0;
}

}  // extern "C"
