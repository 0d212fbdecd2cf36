// SPDX-License-Identifier: Apache-2.0
//
// Packs the words of W into the wide port that wh_shaper reads: 9 coefficients and 3 losses a section.

#pragma once

#include <cstdint>

template <class Port>
void set_shape_words(Port &port, const int64_t *words, int64_t count) {
    int place = 0;
    for (int64_t n = 0; n < count; ++n) {
        const int width = n % 12 < 9 ? WH_SHAPE_W : WH_SHAPE_LOSS_W;
        for (int bit = 0; bit < width; ++bit, ++place) {
            const uint32_t one = uint32_t{1} << place % 32;
            if ((words[n] >> bit) & 1) port[place / 32] |= one;
            else port[place / 32] &= ~one;
        }
    }
}
