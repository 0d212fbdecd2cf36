// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated wh_device, of one motor: ports_shim.cpp, with its
// settings over the bus.

#include <algorithm>
#include <cstdint>
#include <deque>
#include <vector>

#include "Vwh_device.h"
#include "Vwh_device___024root.h"
#include "ends.h"
#include "edges.h"
#include "verilated.h"

WH_EDGES(Vwh_device)

#include "words.h"

// Signals that device_shim.vlt and ports_steps.vlt show.
#define SIGNAL(name) root->wh_device__DOT__##name
#define PORTS(name) SIGNAL(ports__DOT__##name)
#include "ports_steps.h"

namespace {

struct Request {
    int64_t clock;  // it stands on the bus from then on
    bool write;
    uint32_t address;
    uint32_t data;
    bool told = true;  // its answer is kept
};

struct Answer {
    int64_t clock;
    uint32_t data;
    uint32_t error;
};

struct Device {
    VerilatedContext context;
    Vwh_device top{&context};
    const Vwh_device___024root *root = top.rootp;
    int64_t clocks = 0;
    std::deque<Request> requests;
    std::vector<Answer> answers;
    Steps steps;

    ~Device() { ends(context); }
};

constexpr int kMostSetupClocks = 1 << 20;
constexpr int kCommandClocks = 6;  // from a request to what it commands

// A clock with what is asked of the bus; what is ready ends with it.
void clock(Device *device) {
    auto &top = device->top;
    const bool asks = !device->requests.empty() && device->requests.front().clock <= device->clocks;
    top.bus_valid_i = asks;
    if (asks) {
        const Request &request = device->requests.front();
        top.bus_write_i = request.write;
        top.bus_address_i = request.address;
        top.bus_data_i = request.data;
        top.eval();
        if (top.bus_ready_o) {
            if (request.told) {
                device->answers.push_back({device->clocks, top.bus_data_o, top.bus_error_o});
            }
            device->requests.pop_front();
        }
    }
    rise(top);
    ++device->clocks;
}

void end_clock(Device *device) {
    fall(device->top);
}

// Clocks until `done`; the ADC's line changes with each period of SCLK, which is 0 A to a filter.
template <class Done>
bool pass(Device *device, Done done) {
    auto &top = device->top;
    bool sclk = top.adc_sclk_o;
    for (int n = 0; n < kMostSetupClocks; ++n) {
        if (done()) return true;
        if (top.adc_sclk_o && !sclk) top.adc_sdata_i = !top.adc_sdata_i;
        sclk = top.adc_sclk_o;
        clock(device);
        end_clock(device);
    }
    return false;
}

}  // namespace

extern "C" {

// A device just before its first tick with the bridges on, or null where it never gets there: `count`
// pairs of address and word are written over the bus, the last of which gives them; `restart` and
// `magnet_start` are the addresses of these commands, the latter for a brushless motor.
void *wh_device_new(const uint32_t *pairs, int64_t count, int64_t restart, int64_t magnet_start,
                    int64_t inputs) {
    auto *device = new Device;
    const auto *root = device->root;
    auto &top = device->top;
    set_inputs(top, inputs);
    top.stop_i = 1;
    top.driver_fault_i = (1 << kMotors) - 1;
    top.rst = 1;
    top.eval();
    for (int n = 0; n < 4; ++n) clock(device), end_clock(device);
    top.rst = 0;
    bool good = pass(device, [root] { return !SIGNAL(busy); });
    for (int64_t n = 0; n < count; ++n) {
        device->requests.push_back({0, true, pairs[2 * n], pairs[2 * n + 1]});
    }
    good = good && pass(device, [device] { return device->requests.empty(); });
    for (const Answer &answer : device->answers) good = good && answer.error == 0;
    good = good && pass(device, [root] { return !SIGNAL(busy); });
#if WH_LEGS == 3
    device->requests.push_back({0, true, static_cast<uint32_t>(magnet_start), 1});
    pass(device, [device] { return device->requests.empty(); });
#endif
    // Carrier and ADC begin anew, with the bridges.
    const int64_t last = device->clocks + kCommandClocks;
    device->requests.push_back(
        {last - kCommandClocks, true, static_cast<uint32_t>(restart), 1, false});
    pass(device, [device, last] { return device->clocks > last; });
    top.enable_i = 1;
    good = good && pass(device, [root] { return SIGNAL(adc_ready); });
    device->answers.clear();
    if (!good) {
        delete device;
        return nullptr;
    }
    return device;
}

void wh_device_delete(void *model) { delete static_cast<Device *>(model); }

// A request that stands on the bus from a clock on, in turn; clocks are those of wh_device_clocks.
void wh_device_request(void *model, int64_t clock, int64_t write, int64_t address, int64_t data) {
    static_cast<Device *>(model)->requests.push_back(
        {clock, write != 0, static_cast<uint32_t>(address), static_cast<uint32_t>(data)});
}

int64_t wh_device_clocks(void *model) { return static_cast<Device *>(model)->clocks; }

// Clock, word and error of as many answers as there are room for, whose number is returned; they are
// forgotten.
int64_t wh_device_answers(void *model, int64_t *words, int64_t room) {
    auto *device = static_cast<Device *>(model);
    const int64_t count = std::min<int64_t>(room, device->answers.size());
    for (int64_t n = 0; n < count; ++n) {
        const Answer &answer = device->answers[n];
        words[3 * n] = answer.clock;
        words[3 * n + 1] = answer.data;
        words[3 * n + 2] = answer.error;
    }
    device->answers.erase(device->answers.begin(), device->answers.begin() + count);
    return count;
}

int64_t wh_device_bus(int64_t model, int64_t word) {
    reinterpret_cast<Device *>(model)->top.bus_i = word;
    return 0;
}

// As wh_ports_clock without the guard's faults.
int64_t wh_device_clock(int64_t model, int64_t inputs) {
    auto *device = reinterpret_cast<Device *>(model);
    set_inputs(device->top, inputs);
    clock(device);
    const bool step = keep(device->steps, device->root);
    const int64_t out = pins_of(device->top, device->root, device->steps, step);
    end_clock(device);
    return out;
}

// As wh_ports_words.
int64_t wh_device_words(int64_t model, int64_t words_address) {
    const auto *device = reinterpret_cast<Device *>(model);
    words_of(device->top, device->steps, reinterpret_cast<int64_t *>(words_address));
    return 0;
}

}  // extern "C"
