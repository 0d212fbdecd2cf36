// SPDX-License-Identifier: Apache-2.0
//
// The controller with its guard (GUARD = 1): pins_shim.cpp, with what a fault does to the pins.

#include <algorithm>

#include "pins_shim.cpp"

namespace {

constexpr int kHostClocks = 64;   // between two signs of the host
constexpr int kMostFrame = 1024;  // clocks of a conversion that the ADC can repeat
constexpr int kGlitchClocks = 97;  // from one glitch of the encoder's lines to the next

struct Guarded {
    Controller *controller = nullptr;
    int64_t clocks = 0;
    int64_t cause = -1;  // clock of the newest cause
    int64_t off = -1;    // first clock after it with the gates off for a fault
    bool host_silent = false;
    bool adc_repeats = false;
    int adc_level = -1;  // the data line, stuck
    int64_t encoder_flips = 0;
    int64_t encoder_holds = -1;
    int64_t glitch = 0;       // clocks that a glitch lasts
    int64_t adc_flip = -1;    // clock of a frame from which on one bit is inverted
    int64_t reset_clocks = 0; // clocks that the reset still lasts
    int64_t clear_clocks = 0; // and the command to clear
    int64_t on = 0;           // clocks with a gate on since the newest cause
    int in_frame = 0;
    bool frame[kMostFrame] = {};
};

constexpr int64_t kEncoderPins = 6;

// Kinds of wh_guarded_inject, in the order of Injection in sim/wavehaptics/ladder/guarded_pins.py.
enum class Injection {
    kStop, kDriver, kBus, kTrip, kAnchor, kHostSilent, kAdcRepeats, kAdcLevel, kEncoderFlips,
    kEncoderHolds, kRootWord, kSclkHalf, kEnable, kClear, kOutside, kEncoderGlitches, kAdcFlip,
    kReset
};

}  // namespace

extern "C" {

// As wh_pins_new. Guard is its settings, 32 bits each, the lowest first; levels those of a pin at
// fault, bit 0 of the emergency stop, bit 1 of the driver.
void *wh_guarded_new(const uint32_t *words, int64_t inputs, const uint32_t *guard, int64_t count,
                     int64_t levels, int64_t bus) {
    auto *controller = static_cast<Controller *>(wh_pins_new(words, inputs));
    if (!controller) return nullptr;
    auto *guarded = new Guarded;
    guarded->controller = controller;
    auto &top = controller->top;
    top.stop_i = !(levels & 1);
    top.driver_fault_i = !((levels >> 1) & 1);
    top.bus_i = bus;
    // The pins' levels have passed their synchronisers before any fault counts.
    for (int n = 0; n < 4; ++n) clock(top);
    for (int64_t n = 0; n < count; ++n) top.guard_i[n] = guard[n];
    return guarded;
}

void wh_guarded_delete(void *model) {
    auto *guarded = static_cast<Guarded *>(model);
    delete guarded->controller;
    delete guarded;
}

// Also what the guard takes for the bus.
int64_t wh_guarded_bus(int64_t model, int64_t word) {
    auto *controller = reinterpret_cast<Guarded *>(model)->controller;
    return wh_pins_bus(reinterpret_cast<int64_t>(controller), word);
}

int64_t wh_guarded_words(int64_t model, int64_t words_address) {
    auto *controller = reinterpret_cast<Guarded *>(model)->controller;
    return wh_pins_words(reinterpret_cast<int64_t>(controller), words_address);
}

// As wh_pins_clock, but for the faults: wh_guarded_report has them.
int64_t wh_guarded_clock(int64_t model, int64_t inputs) {
    auto *guarded = reinterpret_cast<Guarded *>(model);
    auto &top = guarded->controller->top;
    top.host_alive_i = !guarded->host_silent && guarded->clocks % kHostClocks == 0;
    guarded->in_frame = top.adc_cs_n_o ? 0 : std::min(guarded->in_frame + 1, kMostFrame - 1);
    bool &bit = guarded->frame[guarded->in_frame];
    if (guarded->adc_repeats) {
        inputs = (inputs & ~int64_t{1}) | bit;
    } else {
        bit = inputs & 1;
    }
    if (guarded->adc_level >= 0) inputs = (inputs & ~int64_t{1}) | guarded->adc_level;
    if (guarded->adc_flip >= 0) {
        const int64_t into = guarded->in_frame - guarded->adc_flip;
        const int64_t bit_clocks = 2 * top.sclk_half_clocks_i;
        if (into >= 0 && into < bit_clocks) inputs ^= 1;
        if (into == bit_clocks - 1) guarded->adc_flip = -1;
    }
    if (guarded->encoder_holds >= 0) inputs = (inputs & ~kEncoderPins) | guarded->encoder_holds;
    if (guarded->clocks % kGlitchClocks < guarded->glitch) {
        inputs ^= guarded->clocks / kGlitchClocks % 2 ? 4 : 2;  // A and B by turns
    }
    top.rst = guarded->reset_clocks > 0;
    if (top.rst) --guarded->reset_clocks;
    top.clear_i = guarded->clear_clocks > 0;
    if (top.clear_i) --guarded->clear_clocks;
    guarded->controller->inputs = kOthers;
    const int64_t out = wh_pins_clock(reinterpret_cast<int64_t>(guarded->controller),
                                      inputs ^ guarded->encoder_flips);
    ++guarded->clocks;
    guarded->on += (out & 15) != 0;
    if (guarded->off < 0 && top.faults_o && !top.running_o && !(out & 15)) {
        guarded->off = guarded->clocks;
    }
    return out & mask(kFaultsShift);
}

// Does something to the inputs, from the next clock on; that clock is kept as the cause's.
void wh_guarded_inject(void *model, int64_t kind, int64_t value) {
    auto *guarded = static_cast<Guarded *>(model);
    auto &top = guarded->controller->top;
    guarded->cause = guarded->clocks;
    guarded->off = -1;
    guarded->on = 0;
    switch (static_cast<Injection>(kind)) {
        case Injection::kStop: top.stop_i = value; break;
        case Injection::kDriver: top.driver_fault_i = value; break;
        case Injection::kBus: top.bus_i = value; break;
        case Injection::kTrip: top.trip_i = value; break;
        case Injection::kAnchor: top.anchor_fault_i = value; break;
        case Injection::kHostSilent: guarded->host_silent = value; break;
        case Injection::kAdcRepeats: guarded->adc_repeats = value; break;
        case Injection::kAdcLevel: guarded->adc_level = static_cast<int>(value); break;
        case Injection::kEncoderFlips: guarded->encoder_flips = value ? kEncoderPins : 0; break;
        case Injection::kEncoderHolds:
            guarded->encoder_holds = value ? top.enc_a_i << 1 | top.enc_b_i << 2 : -1;
            break;
        case Injection::kRootWord: top.root_i = value & mask(WH_COEF_W); break;
        case Injection::kSclkHalf: top.sclk_half_clocks_i = value; break;
        case Injection::kEnable: top.enable_i = value; break;
        case Injection::kClear: guarded->clear_clocks = value; break;
        case Injection::kEncoderGlitches: guarded->glitch = value; break;
        case Injection::kAdcFlip: guarded->adc_flip = value; break;
        case Injection::kReset: guarded->reset_clocks = value; break;
        default: break;  // kOutside: the cause is in the motor or its sensor
    }
}

// Clock of the newest cause, first clock after it with the gates off for a fault or -1, faults,
// whether the bridges are on, the clock now, the clocks with a gate on since the cause, and what the contact
// delivered, and the most of it.
void wh_guarded_report(void *model, int64_t *report) {
    auto *guarded = static_cast<Guarded *>(model);
    report[0] = guarded->cause;
    report[1] = guarded->off;
    report[2] = guarded->controller->top.faults_o;
    report[3] = guarded->controller->top.running_o;
    report[4] = guarded->clocks;
    report[5] = guarded->on;
    constexpr int kUnused = 64 - WH_ENERGY_W;
    const auto &top = guarded->controller->top;
    report[6] = static_cast<int64_t>(uint64_t{top.contact_energy_o} << kUnused) >> kUnused;
    report[7] = top.contact_energy_peak_o;
}

}  // extern "C"
