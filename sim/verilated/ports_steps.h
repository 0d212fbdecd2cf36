// SPDX-License-Identifier: Apache-2.0
//
// What a loop sees of wh_ports, alone or in a device: the newest step of each port, and the pins. A shim defines
// PORTS(name) as a signal of wh_ports in `root`; ports_steps.vlt shows them. With WH_LEGS 3 there is one brushless motor,
// whose axes are two ports.

#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "words.h"

#if WH_LEGS == 3
constexpr int kMotors = 2;  // axes
#else
constexpr int kMotors = WH_MOTORS;
#endif
constexpr int kMotorInputs = 3;
constexpr int kMotorGates = 4;
constexpr int kPortShift = 31;   // of the port whose step is done
constexpr int kGatesShift = 34;  // of the second motor's gates

// Of the newest step of a port, in the order of wh_pins_words; what follows them is the contact.
constexpr int kWords = 11;

struct Port {
    std::array<int64_t, kWords> step{};
    int64_t flux = 0, lag = 0;  // of its anchor
    int64_t position = 0, contact = 0, lost = 0;
};

struct Steps {
    std::array<Port, kMotors> ports{};
    bool overrun = false;  // since it was forgotten
};

inline int64_t signed_word(uint64_t raw) {
    constexpr int kUnused = 64 - WH_DATA_W;
    return static_cast<int64_t>(raw << kUnused) >> kUnused;
}

// Keeps what a clock has shown of ports; whether a step is done.
template <class Root>
bool keep(Steps &steps, const Root *root) {
    constexpr int kPosition = 4, kFlags = 5;  // WH_LIVE_...
    auto &ports = steps.ports;
    if (PORTS(live_valid_q)) {
        auto &port = ports[PORTS(live_port_q)];
        if (PORTS(live_word_q) == kPosition) port.position = static_cast<int32_t>(PORTS(live_data_q));
        if (PORTS(live_word_q) == kFlags) port.contact = PORTS(live_data_q) & 1;
    }
    steps.overrun |= PORTS(slots_overrun) | PORTS(adc_overrun) | PORTS(missing);
    if (PORTS(flux_valid)) ports[PORTS(anchor_port)].flux = signed_word(PORTS(anchor_data));
    if (PORTS(lag_valid)) ports[PORTS(anchor_port)].lag = signed_word(PORTS(anchor_data));
    if (const uint32_t lost = PORTS(anchor_faults)) {
        for (int n = 0; n < kMotors; ++n) ports[n].lost |= lost >> n & 1;
    }
    if (!PORTS(core_valid)) return false;
    auto &step = ports[PORTS(core_port)].step;
    step[6] = ports[PORTS(core_port)].flux;
    step[7] = ports[PORTS(core_port)].lag;
    step[0] = signed_word(PORTS(current));
    step[1] = signed_word(PORTS(u));
    step[2] = signed_word(PORTS(v));
    step[3] = signed_word(PORTS(voltage));
    step[4] = PORTS(saturated);
    step[5] = signed_word(PORTS(correction));
    step[8] = PORTS(anchor_faults) >> PORTS(core_port) & 1;
    step[9] = static_cast<int32_t>(PORTS(position));
    step[10] = PORTS(clipped);
    return true;
}

#if WH_LEGS == 3
// Bits 0 and 1 ADC data of the phases a and b, 2 encoder A, 3 encoder B.
template <class Top>
void set_inputs(Top &top, int64_t inputs) {
    top.adc_sdata_i = inputs & 3;
    top.enc_a_i = inputs >> 2 & 1;
    top.enc_b_i = inputs >> 3 & 1;
}

// What the loop is told of a clock, but for the guard's faults: bits 0-2 high gates of the legs a, b and c, 3-5 low
// gates, 6 CS_n, 7 SCLK, 8 tick, 9 a step of both axes is done, 10 contact, 11 overrun, 12 encoder fault. Leg c is leg A
// of the second port.
template <class Top, class Root>
int64_t pins_of(const Top &top, const Root *root, const Steps &steps, bool step) {
    const bool both = step && (!PORTS(core_valid) || PORTS(core_port) == 1);
    const int c_high = top.gate_ah_o >> 1 & 1, c_low = top.gate_al_o >> 1 & 1;
    const int high = (top.gate_ah_o & 1) | (top.gate_bh_o & 1) << 1 | c_high << 2;
    const int low = (top.gate_al_o & 1) | (top.gate_bl_o & 1) << 1 | c_low << 2;
    return high | low << 3 | top.adc_cs_n_o << 6 | top.adc_sclk_o << 7 | top.tick_o << 8 | int64_t{both} << 9 |
           PORTS(contact) << 10 | int64_t{steps.overrun} << 11 | int64_t{PORTS(encoder_faults) != 0} << 12;
}

// The words of the newest step: i, u_n, v_n, e of alpha, then of beta, whether the voltage limit acted on either; of the
// anchors c, χ and ω̂'s lag, of alpha and then of beta, whether they have lost the rotor, the position, and whether a
// value of either was at its end.
template <class Top>
void words_of(const Top &, const Steps &steps, int64_t *words) {
    const auto &[a, b] = steps.ports;
    for (const auto &axis : steps.ports) words = std::copy_n(axis.step.begin(), 4, words);
    for (const int64_t word : {a.step[4] | b.step[4], a.step[5], b.step[5], a.flux, b.flux, a.lag, b.lag,
                               a.step[8] | b.step[8], b.step[9], a.step[10] | b.step[10]}) {
        *words++ = word;
    }
}
#else
// ADC bit, encoder A and B of each motor, from the lowest bits on.
template <class Top>
void set_inputs(Top &top, int64_t inputs) {
    int sdata = 0, a = 0, b = 0;
    for (int n = 0; n < kMotors; ++n, inputs >>= kMotorInputs) {
        sdata |= (inputs & 1) << n;
        a |= (inputs >> 1 & 1) << n;
        b |= (inputs >> 2 & 1) << n;
    }
    top.adc_sdata_i = sdata;
    top.enc_a_i = a;
    top.enc_b_i = b;
}

// What the loop is told of a clock, as wh_pins_clock has it but for the guard's faults: the gates of the first motor,
// what all share, and `step` and contact of the port that bits 31-33 name; from bit 34 on the others' gates. The
// contact of a single motor stands there in any clock.
template <class Top, class Root>
int64_t pins_of(const Top &top, const Root *root, const Steps &steps, bool step) {
    const int64_t contact = PORTS(core_valid) ? PORTS(contact) : kMotors == 1 ? steps.ports[0].contact : 0;
    int64_t out = top.adc_cs_n_o << 4 | top.adc_sclk_o << 5 | top.tick_o << 6 | int64_t{step} << 7 | contact << 8 |
                  int64_t{steps.overrun} << 9 | int64_t{PORTS(encoder_faults) != 0} << 10 |
                  int64_t{PORTS(core_port)} << kPortShift;
    for (int n = 0; n < kMotors; ++n) {
        const int64_t gates = (top.gate_ah_o >> n & 1) | (top.gate_al_o >> n & 1) << 1 |
                              (top.gate_bh_o >> n & 1) << 2 | (top.gate_bl_o >> n & 1) << 3;
        out |= gates << (n ? kGatesShift + kMotorGates * (n - 1) : 0);
    }
    return out;
}

// As wh_pins_words, of the port words[kWords], which then is its contact. With the gates off there is no step.
template <class Top>
void words_of(const Top &top, const Steps &steps, int64_t *words) {
    const Port &port = steps.ports[words[kWords]];
    const bool off = !top.running_o;
    for (int n = 0; n < kWords; ++n) words[n] = off ? 0 : port.step[n];
    if (off) {
        words[8] = port.lost;
        words[9] = port.position;
    }
    words[kWords] = port.contact;
}
#endif
