// SPDX-License-Identifier: Apache-2.0
//
// Gives a port of a Verilated top level its word, from parts of 32 bits, the lowest first.

#pragma once

#include <cstddef>
#include <cstdint>

template <class Port>
void give(Port &port, const uint32_t *words) {
    if constexpr (requires { port[0]; }) {  // more than 64 bits
        for (size_t n = 0; n < sizeof(Port) / sizeof(uint32_t); ++n) port[n] = words[n];
    } else if constexpr (sizeof(Port) > sizeof(uint32_t)) {
        port = words[0] | static_cast<uint64_t>(words[1]) << 32;
    } else {
        port = static_cast<Port>(words[0]);
    }
}
