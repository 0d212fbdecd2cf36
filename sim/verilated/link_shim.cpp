// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated wh_linked_device, at its line: bytes at any rate, edges at any time, and
// what came of them: what its UART made of the line, what was written, and what it said.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "Vwh_linked_device.h"
#include "Vwh_linked_device___024root.h"
#include "ends.h"
#include "edges.h"
#include "verilated.h"

WH_EDGES(Vwh_linked_device)

namespace {

// What must never be.
enum Wrong : int64_t { kGate = 1, kRunning = 2, kBrokenAnswer = 4 };

struct Link {
    VerilatedContext context;
    Vwh_linked_device top{&context};
    int64_t clocks = 0;
    int64_t wrong = 0;
    double bit = 1;       // clocks of an answer's bit
    std::vector<int64_t> received;  // clock, byte with 256 for one without a stop bit
    std::vector<int64_t> written;   // address, word
    std::vector<int64_t> answered;  // bytes
    // The answer's receiver.
    bool hears = false;
    double heard_at = 0;
    int heard_bit = 0;
    int heard = 0;

    ~Link() { ends(context); }
};

// Signals of the module, which link_shim.vlt shows.
#define SIGNAL(name) link->top.rootp->wh_linked_device__DOT__##name

void hear(Link *link) {
    const bool level = link->top.uart_tx_o;
    if (!link->hears) {
        if (level) return;
        link->hears = true;
        link->heard_at = link->clocks + link->bit / 2;
        link->heard_bit = link->heard = 0;
    }
    if (link->clocks < link->heard_at) return;
    link->heard_at += link->bit;
    const int bit = link->heard_bit++;
    if (bit == 0) {
        if (level) link->wrong |= kBrokenAnswer;
    } else if (bit < 9) {
        link->heard |= level << (bit - 1);
    } else {
        if (!level) link->wrong |= kBrokenAnswer;
        link->answered.push_back(link->heard);
        link->hears = false;
    }
}

void clock(Link *link, bool level) {
    auto &top = link->top;
    top.uart_rx_i = level;
    rise(top);
    fall(top);
    ++link->clocks;
    if (SIGNAL(link__DOT__rx_valid)) {
        link->received.push_back(link->clocks);
        link->received.push_back(SIGNAL(link__DOT__rx_data) | SIGNAL(link__DOT__rx_error) << 8);
    }
    if (SIGNAL(bus_ready) && SIGNAL(bus_valid) && SIGNAL(bus_write) && !SIGNAL(bus_check) &&
        !SIGNAL(bus_error)) {
        link->written.push_back(SIGNAL(bus_address));
        link->written.push_back(SIGNAL(bus_data));
    }
    if (top.gate_ah_o || top.gate_al_o || top.gate_bh_o || top.gate_bl_o) link->wrong |= kGate;
    if (top.running_o) link->wrong |= kRunning;
    hear(link);
}

void until(Link *link, double time, bool level) {
    while (link->clocks < time) clock(link, level);
}

}  // namespace

extern "C" {

void *wh_link_new() {
    auto *link = new Link;
    auto &top = link->top;
    top.uart_rx_i = 1;
    top.stop_i = 1;
    top.driver_fault_i = 1;
    top.rst = 1;
    top.eval();
    for (int n = 0; n < 4; ++n) clock(link, true);
    top.rst = 0;
    return link;
}

void wh_link_delete(void *model) { delete static_cast<Link *>(model); }

// Clocks of a bit of the answers.
void wh_link_bit(void *model, double clocks) { static_cast<Link *>(model)->bit = clocks; }

// Bytes, with bits of so many clocks, and clocks of pause after each.
void wh_link_send(void *model, const uint8_t *bytes, const int64_t *pauses, int64_t count, double bit) {
    auto *link = static_cast<Link *>(model);
    double edge = link->clocks;
    for (int64_t n = 0; n < count; ++n) {
        const int bits = bytes[n] << 1 | 1 << 9;
        for (int place = 0; place < 10; ++place) {
            edge += bit;
            until(link, edge, bits >> place & 1);
        }
        edge += pauses[n];
        until(link, edge, true);
    }
}

// The line goes low and high in turn, for so many clocks each; it ends high.
void wh_link_edges(void *model, const int64_t *lengths, int64_t count) {
    auto *link = static_cast<Link *>(model);
    for (int64_t n = 0; n < count; ++n) until(link, link->clocks + lengths[n], n & 1);
}

void wh_link_rest(void *model, int64_t clocks) {
    auto *link = static_cast<Link *>(model);
    until(link, link->clocks + clocks, true);
}

int64_t wh_link_clocks(void *model) { return static_cast<Link *>(model)->clocks; }

// What was never to be, as bits.
int64_t wh_link_wrong(void *model) { return static_cast<Link *>(model)->wrong; }

// How many numbers there are of what the UART received (0), was written (1) or answered (2).
int64_t wh_link_count(void *model, int64_t which) {
    auto *link = static_cast<Link *>(model);
    return (which == 0 ? link->received : which == 1 ? link->written : link->answered).size();
}

// These, which are forgotten then.
void wh_link_take(void *model, int64_t which, int64_t *numbers) {
    auto *link = static_cast<Link *>(model);
    auto &from = which == 0 ? link->received : which == 1 ? link->written : link->answered;
    std::copy(from.begin(), from.end(), numbers);
    from.clear();
}

}  // extern "C"
