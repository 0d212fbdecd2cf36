// SPDX-License-Identifier: Apache-2.0
//
// Hands the port anchor's settings to a top level: one wide word, 32 bits of it in each of `words`.

#pragma once

#include <cstdint>

constexpr int kAnchorWords = (WH_ANCHOR_W + 31) / 32;

template <class Port>
void set_anchor_words(Port &port, const int64_t *words) {
    for (int n = 0; n < kAnchorWords; ++n) port[n] = static_cast<uint32_t>(words[n]);
}
