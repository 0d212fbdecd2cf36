// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated controller of several motors (rtl/wh_ports.v) at its pins, by the clock. A loop sees
// each motor as that of pins_shim.cpp, and a brushless one as ports_steps.h has it.

#include <cstdint>
#include <vector>

#include "Vwh_ports.h"
#include "Vwh_ports___024root.h"
#include "ends.h"
#include "edges.h"
#include "give.h"
#include "verilated.h"

WH_EDGES(Vwh_ports)

#define PORTS(name) root->wh_ports__DOT__##name

#include "ports_steps.h"

namespace {

constexpr int kFaultsShift = WH_LEGS == 3 ? 13 : 11;
constexpr int kMostSetupClocks = 1 << 20;
constexpr int kContactShift = 8;
constexpr int kActingShift = 62;  // surfaces that act

// A frame of wh_surface_words: addresses and words in turn.
using Frame = std::vector<uint32_t>;

struct Controller {
    VerilatedContext context;
    Vwh_ports top{&context};
    int64_t inputs = -1;  // at the last clock; -1: none
    Steps steps;
    Frame frame, next;      // what is being written, and what comes then
    size_t place = 0;       // in `frame`
    bool writes = false;    // a frame is under way
    bool waits = false;     // there is a next one

    ~Controller() { ends(context); }
};

void clock(Vwh_ports &top) {
    rise(top);
    fall(top);
}

// The coming clock's word of a frame, or its commit, when the one before is stored.
void write_frame(Controller &controller) {
    auto &top = controller.top;
    if (!controller.writes) {
        controller.frame.swap(controller.next);
        controller.place = 0;
        controller.writes = true;
        controller.waits = false;
    }
    top.surface_write_i = top.surface_commit_i = 0;
    if (top.surface_busy_o) return;
    if (controller.place < controller.frame.size()) {
        top.surface_address_i = controller.frame[controller.place];
        top.data_i = controller.frame[controller.place + 1];
        top.surface_write_i = 1;
        controller.place += 2;
    } else {
        top.surface_commit_i = 1;
        controller.writes = false;
    }
}

// How many surfaces act on the ports' goals: none where an anchor has lost its rotor.
int64_t acting(const Controller &controller) {
    for (const Port &port : controller.steps.ports) {
        if (port.step[8]) return 0;
    }
    return controller.top.acting_o;
}

template <class Port>
const uint32_t *give_next(Port &port, const uint32_t *words) {
    give(port, words);
    return words + (sizeof(Port) + sizeof(uint32_t) - 1) / sizeof(uint32_t);
}

}  // namespace

extern "C" {

// A controller just before its first tick, or null if its ADC never gets ready. `shared` are wh_ports' packed settings
// of all ports in turn, the magnets' last, `pairs` the address and word of each setting of one port, `count` of them.
void *wh_ports_new(const uint32_t *shared, const uint32_t *pairs, int64_t count, int64_t bus, int64_t budget,
                   int64_t inputs) {
    auto *controller = new Controller;
    auto &top = controller->top;
    shared = give_next(top.carrier_i, shared);
    shared = give_next(top.frame_i, shared);
    shared = give_next(top.sense_i, shared);
    shared = give_next(top.filter_clocks_i, shared);
    shared = give_next(top.delay_i, shared);
    shared = give_next(top.bridge_i, shared);
    shared = give_next(top.guard_i, shared);
    shared = give_next(top.host_i, shared);
    give_next(top.magnets_i, shared);
    top.bus_i = bus;
    top.budget_i = budget;
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

// Write and commit a frame from the coming clock on: `count` addresses and words. One that waits is forgotten.
void wh_ports_frame(void *model, const uint32_t *pairs, int64_t count) {
    auto *controller = static_cast<Controller *>(model);
    controller->next.assign(pairs, pairs + 2 * count);
    controller->waits = true;
}

// Whether the last frame that was committed was refused.
int64_t wh_ports_refused(void *model) { return static_cast<Controller *>(model)->top.surface_refused_o; }

// One clock with these inputs (set_inputs): pins_of, with the guard's faults behind it. From bit 62 on how many surfaces
// act in the step that is done; the contact then is theirs, too.
int64_t wh_ports_clock(int64_t model, int64_t inputs) {
    auto *controller = reinterpret_cast<Controller *>(model);
    auto &top = controller->top;
    const bool writes = controller->writes || controller->waits;
    if (writes) {
        write_frame(*controller);
        controller->inputs = -1;
    }
    if (inputs == controller->inputs) {
        again(top);
    } else {
        if (!writes) top.surface_write_i = top.surface_commit_i = 0;
        set_inputs(top, inputs);
        rise(top);
        fall(top);
        controller->inputs = writes ? -1 : inputs;
    }
    const bool step = keep(controller->steps, top.rootp);
    const uint64_t surfaces = step ? acting(*controller) : 0;
    return pins_of(top, top.rootp, controller->steps, step) | int64_t{top.faults_o} << kFaultsShift |
           int64_t{surfaces != 0} << kContactShift | static_cast<int64_t>(surfaces << kActingShift);
}

// words_of.
int64_t wh_ports_words(int64_t model, int64_t words_address) {
    const auto *controller = reinterpret_cast<Controller *>(model);
    words_of(controller->top, controller->steps, reinterpret_cast<int64_t *>(words_address));
    return 0;
}

}  // extern "C"
