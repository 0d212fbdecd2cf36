// SPDX-License-Identifier: Apache-2.0
//
// What a loop sees of wh_device, alone or with a line: for device_shim.cpp and linked_shim.cpp, which
// define SIGNAL(name) as a wire of the device in `root`. kLegs, of words.h, says which motor it has: its
// pins are packed as in pins_shim.cpp, with three legs as in brushless_pins_shim.cpp.

#pragma once

#include <cstdint>

#include "give.h"
#include "words.h"

constexpr bool kBrushless = kLegs == 3;

// The lowest 64 bits of a signal, in which the first motor's word is, or both axes'.
template <class Signal>
uint64_t lowest(const Signal &signal) {
    if constexpr (requires { signal[0]; }) {
        return signal[0] | static_cast<uint64_t>(signal[1]) << 32;
    } else {
        return signal;
    }
}

// The signed word of a motor, or of an axis, out of all.
template <class Signal>
int64_t signed_word(const Signal &signal, int part = 0) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(lowest(signal) >> part * WH_DATA_W << kUnused) >> kUnused;
}

// Bits of the ADCs, then encoder A and B.
template <class Top>
void set_inputs(Top &top, int64_t inputs) {
    constexpr int kAdcs = kBrushless ? 2 : 1;
    top.adc_sdata_i = inputs & ((1 << kAdcs) - 1);
    top.enc_a_i = (inputs >> kAdcs) & 1;
    top.enc_b_i = (inputs >> (kAdcs + 1)) & 1;
}

// What the loop is told of a clock; `step` says that a step's words are new.
template <class Top, class Root>
int64_t pins_of(const Top &top, const Root *root, bool step) {
    const int64_t seen = top.adc_cs_n_o | top.adc_sclk_o << 1 | top.tick_o << 2 | int64_t{step} << 3 |
                         top.contact_o << 4 | SIGNAL(overrun) << 5 | (SIGNAL(encoder_fault) & 1) << 6;
    // Of three legs the gates b and c come side by side, all high ones first.
    if (kBrushless) {
        return top.gate_ah_o | top.gate_bh_o << 1 | top.gate_al_o << 3 | top.gate_bl_o << 4 | seen << 6;
    }
    return top.gate_ah_o | top.gate_al_o << 1 | top.gate_bh_o << 2 | top.gate_bl_o << 3 | seen << 4;
}

// The words of the newest step.
template <class Root>
void words_of(const Root *root, int64_t *words) {
    const auto both = [&words](const auto &raw) {
        *words++ = signed_word(raw);
        if (kBrushless) *words++ = signed_word(raw, 1);
    };
    for (int part = 0; part < (kBrushless ? 2 : 1); ++part) {
        *words++ = signed_word(SIGNAL(current), part);
        *words++ = signed_word(SIGNAL(u), part);
        *words++ = signed_word(SIGNAL(v), part);
        *words++ = signed_word(SIGNAL(voltage), part);
    }
    *words++ = SIGNAL(saturated);
    both(SIGNAL(correction));
    both(SIGNAL(flux));
    both(SIGNAL(lag));
    *words++ = SIGNAL(anchor_fault) & 1;
    *words++ = static_cast<int32_t>(lowest(SIGNAL(position)));
    *words++ = SIGNAL(clipped) & (kBrushless ? 3 : 1);
}
