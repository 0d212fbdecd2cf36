// SPDX-License-Identifier: Apache-2.0
//
// The far end of a serial line: bytes that wait to be sent, and bytes that came, 8 bits, no parity, one
// stop bit, at the rate that the near end has now, in clocks / 16 of a bit.

#pragma once

#include <cstdint>
#include <deque>

class UartHost {
  public:
    std::deque<uint8_t> to_send;
    std::deque<uint8_t> received;

    // The level that is sent in this clock.
    bool level() const { return sending_ ? bits_ & 1 : true; }

    // A clock has passed, at whose end `line` is what the near end sends.
    void clock(bool line, int bit_clocks) {
        send(bit_clocks);
        receive(line, bit_clocks);
    }

  private:
    static constexpr int kClock = 16;
    static constexpr int kBits = 10;  // with start and stop

    void send(int bit_clocks) {
        if (!sending_) {
            if (to_send.empty()) return;
            bits_ = 0x200 | to_send.front() << 1;
            to_send.pop_front();
            sending_ = kBits;
            send_left_ = bit_clocks;
            return;
        }
        send_left_ -= kClock;
        if (send_left_ < kClock) {
            send_left_ += bit_clocks;
            bits_ >>= 1;
            --sending_;
        }
    }

    void receive(bool line, int bit_clocks) {
        if (!receiving_) {
            if (line) return;
            receiving_ = kBits;
            receive_left_ = bit_clocks / 2;
            return;
        }
        receive_left_ -= kClock;
        if (receive_left_ >= kClock) return;
        receive_left_ += bit_clocks;
        shift_ = shift_ >> 1 | (line ? 0x200 : 0);
        if (--receiving_ == 0 && line) received.push_back(shift_ >> 1 & 0xff);
    }

    int sending_ = 0;  // bits to go
    int send_left_ = 0;
    unsigned bits_ = 0;
    int receiving_ = 0;
    int receive_left_ = 0;
    unsigned shift_ = 0;
};
