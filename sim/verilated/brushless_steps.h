// SPDX-License-Identifier: Apache-2.0
//
// As ports_steps.h, of wh_device with three legs: the words of its newest step, and its pins, packed as in
// brushless_pins_shim.cpp. A shim defines SIGNAL(name) as a wire of the device in `root`.

#pragma once

#include <cstdint>

#include "words.h"

constexpr int kMotors = 1;

struct Steps {};  // the device keeps them itself

// The lowest 64 bits of a signal, in which both axes' words are.
template <class Signal>
uint64_t lowest(const Signal &signal) {
    if constexpr (requires { signal[0]; }) {
        return signal[0] | static_cast<uint64_t>(signal[1]) << 32;
    } else {
        return signal;
    }
}

// The signed word of an axis out of both.
template <class Signal>
int64_t signed_word(const Signal &signal, int axis) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(lowest(signal) >> axis * WH_DATA_W << kUnused) >> kUnused;
}

template <class Root>
bool keep(Steps &, const Root *root) {
    return SIGNAL(core_valid);
}

// Bits of the ADCs, then encoder A and B.
template <class Top>
void set_inputs(Top &top, int64_t inputs) {
    top.adc_sdata_i = inputs & 3;
    top.enc_a_i = inputs >> 2 & 1;
    top.enc_b_i = inputs >> 3 & 1;
}

// The gates b and c come side by side, all high ones first.
template <class Top, class Root>
int64_t pins_of(const Top &top, const Root *root, const Steps &, bool step) {
    const int64_t seen = top.adc_cs_n_o | top.adc_sclk_o << 1 | top.tick_o << 2 | int64_t{step} << 3 |
                         top.contact_o << 4 | SIGNAL(overrun) << 5 | (SIGNAL(encoder_fault) & 1) << 6;
    return top.gate_ah_o | top.gate_bh_o << 1 | top.gate_al_o << 3 | top.gate_bl_o << 4 | seen << 6;
}

template <class Top>
void words_of(const Top &top, const Steps &, int64_t *words) {
    const auto *root = top.rootp;
    const auto both = [&words](const auto &raw) {
        *words++ = signed_word(raw, 0);
        *words++ = signed_word(raw, 1);
    };
    for (int axis = 0; axis < 2; ++axis) {
        *words++ = signed_word(SIGNAL(current), axis);
        *words++ = signed_word(SIGNAL(u), axis);
        *words++ = signed_word(SIGNAL(v), axis);
        *words++ = signed_word(SIGNAL(voltage), axis);
    }
    *words++ = SIGNAL(saturated);
    both(SIGNAL(correction));
    both(SIGNAL(flux));
    both(SIGNAL(lag));
    *words++ = SIGNAL(anchor_fault) & 1;
    *words++ = static_cast<int32_t>(lowest(SIGNAL(position)));
    *words++ = SIGNAL(clipped) & 3;
}
