// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated controller of several motors (rtl/wh_ports.v) at its pins, by the clock. A loop sees
// each motor as that of pins_shim.cpp.

#include <array>
#include <cstdint>

#include "Vwh_ports.h"
#include "Vwh_ports___024root.h"
#include "ends.h"
#include "edges.h"
#include "give.h"
#include "verilated.h"
#include "words.h"

WH_EDGES(Vwh_ports)

// Signals of the module, which ports_shim.vlt shows.
#define SIGNAL(name) controller->top.rootp->wh_ports__DOT__##name

namespace {

constexpr int kMotors = WH_MOTORS;
constexpr int kMotorInputs = 3;
constexpr int kFaultsShift = 11;
constexpr int kPortShift = 28;   // of the port whose step is done
constexpr int kGatesShift = 32;  // of the second motor's gates, 4 each
constexpr int kMostSetupClocks = 1 << 20;
constexpr int kPosition = 4, kFlags = 5;  // WH_LIVE_...

// Of the newest step of a port, in the order of wh_pins_words; what follows them is the contact.
constexpr int kWords = 11;

struct Port {
    std::array<int64_t, kWords> step{};
    int64_t flux = 0, lag = 0;  // of its anchor
    int64_t position = 0, contact = 0, lost = 0;
};

struct Controller {
    VerilatedContext context;
    Vwh_ports top{&context};
    int64_t inputs = -1;  // at the last clock; -1: none
    bool overrun = false;
    std::array<Port, kMotors> ports{};

    ~Controller() { ends(context); }
};

int64_t signed_word(uint64_t raw) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(raw << kUnused) >> kUnused;
}

// As wh_pins_clock has them, for each motor from the lowest bits on.
void set_inputs(Vwh_ports &top, int64_t inputs) {
    int sdata = 0, a = 0, b = 0;
    for (int n = 0; n < kMotors; ++n, inputs >>= kMotorInputs) {
        sdata |= (inputs & 1) << n;
        a |= (inputs >> 1 & 1) << n;
        b |= (inputs >> 2 & 1) << n;
    }
    top.adc_sdata_i = sdata;
    top.enc_a_i = a;
    top.enc_b_i = b;
}

void clock(Vwh_ports &top) {
    rise(top);
    fall(top);
}

template <class Port>
const uint32_t *give_next(Port &port, const uint32_t *words) {
    give(port, words);
    return words + (sizeof(Port) + sizeof(uint32_t) - 1) / sizeof(uint32_t);
}

// Keeps what the clock has shown of ports; whether a step is done.
bool keep(Controller *controller) {
    const auto &top = controller->top;
    auto &ports = controller->ports;
    if (top.live_valid_o) {
        auto &port = ports[top.live_port_o];
        if (top.live_word_o == kPosition) port.position = static_cast<int32_t>(top.live_data_o);
        if (top.live_word_o == kFlags) port.contact = top.live_data_o & 1;
    }
    controller->overrun |= SIGNAL(slots_overrun) | SIGNAL(adc_overrun) | SIGNAL(missing);
    if (SIGNAL(flux_valid)) ports[SIGNAL(anchor_port)].flux = signed_word(SIGNAL(anchor_data));
    if (SIGNAL(lag_valid)) ports[SIGNAL(anchor_port)].lag = signed_word(SIGNAL(anchor_data));
    if (const uint32_t lost = SIGNAL(anchor_faults)) {
        for (int n = 0; n < kMotors; ++n) ports[n].lost |= lost >> n & 1;
    }
    if (!SIGNAL(core_valid)) return false;
    auto &step = ports[SIGNAL(core_port)].step;
    step[6] = ports[SIGNAL(core_port)].flux;
    step[7] = ports[SIGNAL(core_port)].lag;
    step[0] = signed_word(SIGNAL(current));
    step[1] = signed_word(SIGNAL(u));
    step[2] = signed_word(SIGNAL(v));
    step[3] = signed_word(SIGNAL(voltage));
    step[4] = SIGNAL(saturated);
    step[5] = signed_word(SIGNAL(correction));
    step[8] = SIGNAL(anchor_faults) >> SIGNAL(core_port) & 1;
    step[9] = static_cast<int32_t>(SIGNAL(position));
    step[10] = SIGNAL(clipped);
    return true;
}

}  // namespace

extern "C" {

// A controller just before its first tick, or null if its ADC never gets ready. `shared` are wh_ports' packed settings
// of all ports in turn, `pairs` the address and word of each setting of one port, `count` of them.
void *wh_ports_new(const uint32_t *shared, const uint32_t *pairs, int64_t count, int64_t bus, int64_t inputs) {
    auto *controller = new Controller;
    auto &top = controller->top;
    shared = give_next(top.carrier_i, shared);
    shared = give_next(top.frame_i, shared);
    shared = give_next(top.sense_i, shared);
    shared = give_next(top.filter_clocks_i, shared);
    shared = give_next(top.delay_i, shared);
    shared = give_next(top.bridge_i, shared);
    shared = give_next(top.guard_i, shared);
    give_next(top.host_i, shared);
    top.bus_i = bus;
    set_inputs(top, inputs);
    top.rst = 1;
    top.enable_i = 0;
    top.eval();
    top.write_i = 1;
    for (int64_t n = 0; n < count; ++n, pairs += 2) {
        top.address_i = pairs[0];
        top.data_i = pairs[1];
        clock(top);
    }
    top.write_i = 0;
    for (int n = 0; n < 4; ++n) clock(top);
    top.rst = 0;
    top.enable_i = 1;
    // As in pins_shim.cpp.
    bool sclk = top.adc_sclk_o;
    for (int n = 0; !top.adc_ready_o; ++n) {
        if (n == kMostSetupClocks) {
            delete controller;
            return nullptr;
        }
        if (top.adc_sclk_o && !sclk) top.adc_sdata_i = top.adc_sdata_i ? 0 : (1 << kMotors) - 1;
        sclk = top.adc_sclk_o;
        clock(top);
    }
    return controller;
}

void wh_ports_delete(void *model) { delete static_cast<Controller *>(model); }

// One clock with these inputs (set_inputs). Returns what wh_pins_clock does: the gates of the first motor, what all
// share, and core valid and contact of the port that bits 28-30 name; from bit 32 on the others' gates.
int64_t wh_ports_clock(int64_t model, int64_t inputs) {
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
    const int64_t step = keep(controller);
    int64_t out = top.adc_cs_n_o << 4 | top.adc_sclk_o << 5 | top.tick_o << 6 | step << 7 |
                  (SIGNAL(contact) & step) << 8 | int64_t{controller->overrun} << 9 |
                  int64_t{SIGNAL(encoder_faults) != 0} << 10 | int64_t{top.faults_o} << kFaultsShift |
                  int64_t{SIGNAL(core_port)} << kPortShift;
    for (int n = 0; n < kMotors; ++n) {
        const int64_t gates = (top.gate_ah_o >> n & 1) | (top.gate_al_o >> n & 1) << 1 |
                              (top.gate_bh_o >> n & 1) << 2 | (top.gate_bl_o >> n & 1) << 3;
        out |= gates << (n ? kGatesShift - 4 + 4 * n : 0);
    }
    return out;
}

// As wh_pins_words, of the port words[11], which then is its contact. With the gates off there is no step.
int64_t wh_ports_words(int64_t model, int64_t words_address) {
    const auto *controller = reinterpret_cast<Controller *>(model);
    auto *words = reinterpret_cast<int64_t *>(words_address);
    const auto &port = controller->ports[words[kWords]];
    const bool off = !controller->top.running_o;
    for (int n = 0; n < kWords; ++n) words[n] = off ? 0 : port.step[n];
    if (off) {
        words[8] = port.lost;
        words[9] = port.position;
    }
    words[kWords] = port.contact;
    return 0;
}

}  // extern "C"
