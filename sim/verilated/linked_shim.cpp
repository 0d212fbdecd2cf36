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

// Signals that linked_shim.vlt, device_shim.vlt and ports_steps.vlt show.
#define SIGNAL(name) root->wh_linked_device__DOT__device__DOT__##name
#define PORTS(name) SIGNAL(ports__DOT__##name)
#include "ports_steps.h"
#define BIT_CLOCKS linked->root->wh_linked_device__DOT__link__DOT__uart__DOT__bit_clocks_i

namespace {

struct Linked {
    VerilatedContext context;
    Vwh_linked_device top{&context};
    const Vwh_linked_device___024root *root = top.rootp;
    int64_t clocks = 0;
    UartHost host;
    int64_t tick_clocks = 0;
    Steps steps;
    int64_t silent_clocks = 0;  // since the last step, or what stands in for one
    int silent_ticks = 0;

    ~Linked() { ends(context); }
};

constexpr int64_t kMostSetupClocks = 1 << 24;
constexpr int kSilentTicks = 4;
constexpr int kAnswer = 8;  // bytes, to a write

// A bit for each motor, or for each phase's ADC.
constexpr int kAll = (1 << kMotors) - 1;

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
        if (top.adc_sclk_o && !sclk) top.adc_sdata_i = top.adc_sdata_i ? 0 : kAll;
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
void *wh_linked_new(int64_t inputs, int64_t tick_clocks) {
    auto *linked = new Linked;
    auto &top = linked->top;
    linked->tick_clocks = tick_clocks;
    set_inputs(top, inputs);
    top.stop_i = 1;
    top.driver_fault_i = kAll;
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
int64_t wh_linked_begin(void *model, const uint8_t *frame, int64_t count) {
    auto *linked = static_cast<Linked *>(model);
    if (!pass(linked, [root = linked->root] { return !SIGNAL(busy); })) return false;
    const int64_t way = restart(linked, frame, count);
    if (way < 0) return false;
    clock(linked), end_clock(linked);
    linked->top.enable_i = 1;
    return pass(linked, [root = linked->root] { return SIGNAL(adc_ready); });
}

int64_t wh_linked_running(void *model) { return static_cast<Linked *>(model)->top.running_o; }

int64_t wh_linked_bus(int64_t model, int64_t word) {
    reinterpret_cast<Linked *>(model)->top.bus_i = word;
    return 0;
}

// As wh_ports_clock without the guard's faults. With the bridges off, where there are no
// steps, each tick tells of one, and so do four ticks without: the loop around goes on with its motor, whatever the
// settings make of the ticks. Of the steps of several motors nothing is told.
int64_t wh_linked_clock(int64_t model, int64_t inputs) {
    auto *linked = reinterpret_cast<Linked *>(model);
    auto &top = linked->top;
    set_inputs(top, inputs);
    clock(linked);
    bool step = keep(linked->steps, linked->root);
    ++linked->silent_clocks;
    linked->silent_ticks += top.tick_o;
    if (!step) {
        step = (top.tick_o && !top.running_o) || linked->silent_ticks >= kSilentTicks ||
               linked->silent_clocks >= kSilentTicks * linked->tick_clocks;
    }
    if (step) linked->silent_clocks = linked->silent_ticks = 0;
    const int64_t out = pins_of(top, linked->root, linked->steps, step && WH_MOTORS == 1);
    end_clock(linked);
    return out;
}

// As wh_ports_words.
int64_t wh_linked_words(int64_t model, int64_t words_address) {
    const auto *linked = reinterpret_cast<Linked *>(model);
    words_of(linked->top, linked->steps, reinterpret_cast<int64_t *>(words_address));
    return 0;
}

}  // extern "C"
