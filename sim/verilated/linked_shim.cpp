// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated wh_linked_device, of one motor or several: device_shim.cpp, with a serial
// line in place of the bus.

#include <algorithm>
#include <cstdint>

#include "Vwh_linked_device.h"
#include "Vwh_linked_device___024root.h"
#include "ends.h"
#include "edges.h"
#include "uart_host.h"
#include "verilated.h"

WH_EDGES(Vwh_linked_device)

#include "words.h"

// Signals of the modules, which device_shim.vlt and linked_shim.vlt show.
#if WH_MOTORS > 1
#define SIGNAL(name) root->wh_linked_device__DOT__device__DOT__of_ports__DOT__device__DOT__##name
#else
#define SIGNAL(name) root->wh_linked_device__DOT__device__DOT__of_motor__DOT__device__DOT__##name
#endif
#define BIT_CLOCKS linked->root->wh_linked_device__DOT__link__DOT__uart__DOT__bit_clocks_i

#include "device_pins.h"

namespace {

struct Linked {
    VerilatedContext context;
    Vwh_linked_device top{&context};
    const Vwh_linked_device___024root *root = top.rootp;
    int64_t clocks = 0;
    UartHost host;
    int64_t tick_clocks = 0;
    int motors = 1;
    int64_t silent_clocks = 0;  // since the last step, or what stands in for one
    int silent_ticks = 0;

    ~Linked() { ends(context); }
};

constexpr int64_t kMostSetupClocks = 1 << 24;
constexpr int kSilentTicks = 4;
constexpr int kAnswer = 8;  // bytes, to a write

constexpr int kMotorInputs = 3;
constexpr int kMotorGates = 4;
constexpr int kOthers = 32;  // place of the second motor's gates, where there are several

// A bit for each line of an ADC.
int all_lines(const Linked *linked) { return kBrushless ? 1 : (1 << linked->motors) - 1; }

// Of several motors: those of each, as set_inputs has them of one.
void set_all_inputs(Linked *linked, int64_t inputs) {
    if (linked->motors == 1) {
        set_inputs(linked->top, inputs);
        return;
    }
    int sdata = 0, a = 0, b = 0;
    for (int n = 0; n < linked->motors; ++n, inputs >>= kMotorInputs) {
        sdata |= (inputs & 1) << n;
        a |= (inputs >> 1 & 1) << n;
        b |= (inputs >> 2 & 1) << n;
    }
    linked->top.adc_sdata_i = sdata;
    linked->top.enc_a_i = a;
    linked->top.enc_b_i = b;
}

void clock(Linked *linked) {
    auto &top = linked->top;
    top.uart_rx_i = linked->host.level();
    rise(top);
    linked->host.clock(top.uart_tx_o, BIT_CLOCKS);
    ++linked->clocks;
}

void end_clock(Linked *linked) {
    fall(linked->top);
}

// As in device_shim.cpp.
template <class Done>
bool pass(Linked *linked, Done done) {
    auto &top = linked->top;
    bool sclk = top.adc_sclk_o;
    for (int64_t n = 0; n < kMostSetupClocks; ++n) {
        if (done()) return true;
        if (top.adc_sclk_o && !sclk) top.adc_sdata_i = top.adc_sdata_i ? 0 : all_lines(linked);
        sclk = top.adc_sclk_o;
        clock(linked);
        end_clock(linked);
    }
    return false;
}

// Send a frame, and wait until it restarts carrier and ADC: the clocks that takes, -1 for never.
int64_t restart(Linked *linked, const uint8_t *frame, int64_t count) {
    const int64_t first = linked->clocks;
    linked->host.to_send.insert(linked->host.to_send.end(), frame, frame + count);
    return pass(linked, [root = linked->root] { return SIGNAL(set_restart); }) ? linked->clocks - first : -1;
}

}  // namespace

extern "C" {

// A device after reset, with its defaults and the bridges off.
void *wh_linked_new(int64_t inputs, int64_t tick_clocks, int64_t motors) {
    auto *linked = new Linked;
    auto &top = linked->top;
    linked->tick_clocks = tick_clocks;
    linked->motors = motors;
    set_all_inputs(linked, inputs);
    top.stop_i = 1;
    top.driver_fault_i = (1 << motors) - 1;
    top.uart_rx_i = 1;
    top.rst = 1;
    top.eval();
    for (int n = 0; n < 4; ++n) clock(linked), end_clock(linked);
    top.rst = 0;
    pass(linked, [root = linked->root] { return !SIGNAL(busy); });
    return linked;
}

void wh_linked_delete(void *model) { delete static_cast<Linked *>(model); }

// Bytes that stand before the line, and those taken from it, whose number is returned.
void wh_linked_send(void *model, const uint8_t *bytes, int64_t count) {
    auto &queue = static_cast<Linked *>(model)->host.to_send;
    queue.insert(queue.end(), bytes, bytes + count);
}

int64_t wh_linked_waiting(void *model) {
    return static_cast<Linked *>(model)->host.to_send.size();
}

int64_t wh_linked_received(void *model, uint8_t *bytes, int64_t room) {
    auto &queue = static_cast<Linked *>(model)->host.received;
    const int64_t count = std::min<int64_t>(room, queue.size());
    std::copy_n(queue.begin(), count, bytes);
    queue.erase(queue.begin(), queue.begin() + count);
    return count;
}

// Clocks until so many bytes have come, and two bits more, with 0 A and the rotor at rest; whether they
// have. In these a new rate comes into force.
int64_t wh_linked_await(void *model, int64_t count) {
    auto *linked = static_cast<Linked *>(model);
    const auto enough = [linked, count] {
        return static_cast<int64_t>(linked->host.received.size()) >= count;
    };
    if (!pass(linked, enough)) return false;
    return pass(linked, [linked, still = linked->clocks + BIT_CLOCKS / 8] {
        return linked->clocks >= still;
    });
}

// To just before the first tick, with enable_i high; whether it gets there. `frame` commands a restart.
// As wh_device_new has it, carrier and ADC begin in a clock in which the walls' rounds do: the frame is
// sent twice, as its way takes the same time.
int64_t wh_linked_begin(void *model, const uint8_t *frame, int64_t count) {
    auto *linked = static_cast<Linked *>(model);
    const int64_t way = restart(linked, frame, count);
    wh_linked_await(model, kAnswer);
    linked->host.received.clear();
    if (way < 0 || !pass(linked, [root = linked->root] { return !SIGNAL(busy); })) return false;
#if WH_MOTORS == 1
    const auto round_ends = [root = linked->root] { return !SIGNAL(hold_round); };
    pass(linked, round_ends);
    const int64_t first = linked->clocks;
    clock(linked), end_clock(linked);
    pass(linked, round_ends);
    const int64_t period = linked->clocks - first;
    const int64_t last = first + ((way + period) / period + 1) * period;
    pass(linked, [=] { return linked->clocks >= last - way; });
#endif
    if (restart(linked, frame, count) != way) return false;
    clock(linked), end_clock(linked);
    linked->top.enable_i = 1;
    return pass(linked, [root = linked->root] { return SIGNAL(adc_ready); });
}

int64_t wh_linked_running(void *model) { return static_cast<Linked *>(model)->top.running_o; }

int64_t wh_linked_bus(int64_t model, int64_t word) {
    reinterpret_cast<Linked *>(model)->top.bus_i = word;
    return 0;
}

#if WH_MOTORS == 1
// As wh_pins_clock, or wh_brushless_clock. With the bridges off, where there are no steps, each tick tells of
// one, and so do four ticks without: the loop around goes on with its motor, whatever the settings make of the
// ticks.
int64_t wh_linked_clock(int64_t model, int64_t inputs) {
    auto *linked = reinterpret_cast<Linked *>(model);
    auto &top = linked->top;
    const auto *root = linked->root;
    set_inputs(top, inputs);
    clock(linked);
    bool step = SIGNAL(core_valid);
    ++linked->silent_clocks;
    linked->silent_ticks += top.tick_o;
    if (!step) {
        step = (top.tick_o && !top.running_o) || linked->silent_ticks >= kSilentTicks ||
               linked->silent_clocks >= kSilentTicks * linked->tick_clocks;
    }
    if (step) linked->silent_clocks = linked->silent_ticks = 0;
    const int64_t out = pins_of(top, root, step);
    end_clock(linked);
    return out;
}
#else
// One clock of several motors, with three inputs and four gates of each, as wh_ports_clock has them; of its steps
// nothing is told.
int64_t wh_linked_clock(int64_t model, int64_t inputs) {
    auto *linked = reinterpret_cast<Linked *>(model);
    auto &top = linked->top;
    set_all_inputs(linked, inputs);
    clock(linked);
    int64_t out = top.adc_cs_n_o << 4 | top.adc_sclk_o << 5 | top.tick_o << 6;
    for (int n = 0; n < linked->motors; ++n) {
        const int64_t gates = (top.gate_ah_o >> n & 1) | (top.gate_al_o >> n & 1) << 1 |
                              (top.gate_bh_o >> n & 1) << 2 | (top.gate_bl_o >> n & 1) << 3;
        out |= gates << (n ? kOthers - kMotorGates + kMotorGates * n : 0);
    }
    end_clock(linked);
    return out;
}
#endif

// As wh_pins_words, or wh_brushless_words; nothing of several motors.
int64_t wh_linked_words(int64_t model, int64_t words_address) {
#if WH_MOTORS == 1
    words_of(reinterpret_cast<Linked *>(model)->root, reinterpret_cast<int64_t *>(words_address));
#endif
    return 0;
}

}  // extern "C"
