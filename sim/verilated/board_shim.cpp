// SPDX-License-Identifier: Apache-2.0
//
// C interface to a whole board at its pins, by the clock: its sources, or its placed netlist. The top
// is the bench that tools/wavetools/fpga/board_simulation.py writes around the board's own. WH_BOARD_LEGS
// is how many half bridges a motor has; with three, for a brushless motor, it has two ADCs. WH_BOARD_MOTORS is how many
// motors there are.

#include <algorithm>
#include <cstdint>

#include "Vwh_board_bench.h"
#include "uart_host.h"
#include "verilated.h"

namespace {

// Clocks until reset has given every register that has no beginning its value.
constexpr int64_t kUnset = 16;

constexpr int kAdcs = WH_BOARD_LEGS - 1;
constexpr int kGates = 2 * WH_BOARD_LEGS;
constexpr int64_t kAllGates = (1 << kGates) - 1;
constexpr int kMotors = WH_BOARD_MOTORS;
// As ports_steps.h has them: inputs of a motor, and where the second motor's gates are.
constexpr int kMotorInputs = 3, kPortShift = 31, kGatesShift = 34;
// Places of the pins behind the gates.
constexpr int kCsN = kGates, kSclk = kGates + 1, kTick = kGates + 2, kRow = kGates + 3, kFault = kGates + 5;

// The high gates of both legs of a motor with brushes stand before their low ones, those of three
// before all low ones.
bool both_on(int64_t gates) {
    if constexpr (WH_BOARD_LEGS == 2) return (gates & 3) == 3 || (gates & 12) == 12;
    return gates & gates >> WH_BOARD_LEGS & ((1 << WH_BOARD_LEGS) - 1);
}

struct Board {
    VerilatedContext context;
    Vwh_board_bench top{&context};
    int64_t tick_clocks = 0;
    int64_t again = 0;       // clocks after a tick at which alive changes once more; 0: it changes once
    UartHost host;
    int bit_clocks = 0;      // clocks / 16 of a bit of the line
    double watch_step = 0;   // half periods of the FPGA's own oscillator in a clock
    double watch_phase = 0;
    int64_t clocks = 0;
    int64_t ticks = 0;
    int64_t strobe = -1;     // clock of the newest tick's strobe
    bool told = false;       // alive has changed for it
    bool began = false;      // the bridges were on as it began
    bool marked = false;     // a tick was handed on
    int64_t irregular = 0;   // ticks that alive told at another clock, or not
    int64_t both_on = 0;     // clocks with both gates of a leg on
    int64_t idle_on = 0;     // and with a gate on while the board says that it doesn't run, but for
                             // the clock that it takes to go off
    int64_t apart = 0;       // and in which a motor's gates aren't the first one's
    bool ran = false;        // the clock before
    bool parted = false;     // each port has a motor of its own
    uint64_t seen = 0xcbf29ce484222325;  // digest of the pins at each clock from kUnset on
    int last_alive = 0;
};

// One clock; the pins as they stand after its edge.
int64_t step(Board &board) {
    auto &top = board.top;
    top.rx = board.host.level();
    top.clk = 1;
    top.eval();
    board.host.clock(top.tx, board.bit_clocks);
    const int64_t gates = top.gates;
    const int64_t pins = (gates & kAllGates) | top.cs_n << kCsN | top.sclk << kSclk;
    const int64_t shown = pins | (top.alive | top.running << 1 | top.fault << 2 | top.contact << 3 |
                                  top.tx << 4) << kTick;
    top.clk = 0;
    // The oscillator's edges lie between those of the clock, of which it knows nothing.
    board.watch_phase += board.watch_step;
    while (board.watch_phase >= 1.0) {
        board.watch_phase -= 1.0;
        top.watch_clk = !top.watch_clk;
        top.eval();
    }
    top.eval();
    if (board.clocks >= kUnset) {
        board.seen = (board.seen ^ static_cast<uint64_t>(shown)) * 0x100000001b3;
    }
    bool shorted = false;
    for (int n = 0; n < kMotors; ++n) shorted |= both_on(gates >> kGates * n & kAllGates);
    board.both_on += shorted;
    board.idle_on += gates && !top.running && !board.ran;
    board.apart += top.apart;
    board.ran = top.running;
    return board.parted ? pins | gates >> kGates << kGatesShift : pins;
}

// Bits of the ADCs, then encoder A and B, of all motors or, where they are parted, of each in turn.
void set_inputs(Board &board, int64_t inputs) {
    auto &top = board.top;
    if constexpr (kMotors > 1) {
        int sdata = 0, a = 0, b = 0;
        for (int n = 0; n < kMotors; ++n) {
            const int64_t own = board.parted ? inputs >> kMotorInputs * n : inputs;
            sdata |= (own & 1) << n;
            a |= (own >> 1 & 1) << n;
            b |= (own >> 2 & 1) << n;
        }
        top.sdata = sdata;
        top.a = a;
        top.b = b;
        return;
    }
    top.sdata = inputs & ((1 << kAdcs) - 1);
    top.a = (inputs >> kAdcs) & 1;
    top.b = (inputs >> (kAdcs + 1)) & 1;
}

}  // namespace

extern "C" {

// A board just after power-up, nobody at its buttons; inputs as for wh_board_clock. Null where a
// model of a cell can't do what the netlist asks for.
void *wh_board_new(int64_t inputs, int64_t tick_clocks, int64_t bit_clocks, double watch_step, int64_t again) {
    auto *board = new Board;
    board->tick_clocks = tick_clocks;
    board->bit_clocks = bit_clocks;
    board->watch_step = watch_step;
    board->again = again;
    set_inputs(*board, inputs);
    board->top.eval();
    // What the pins show before is no conversion.
    while (board->clocks < kUnset) {
        step(*board);
        ++board->clocks;
    }
    if (!board->context.gotFinish()) return board;
    delete board;
    return nullptr;
}

void wh_board_delete(void *model) { delete static_cast<Board *>(model); }

// The start button pressed or not, and the stop's wire open or not, from the next clock on.
void wh_board_press(void *model, int64_t start, int64_t stop) {
    auto &top = static_cast<Board *>(model)->top;
    top.start = start;
    top.stop = stop;
}

// Each port has a motor of its own from the next clock on.
void wh_board_part(void *model) { static_cast<Board *>(model)->parted = true; }

// Bytes that are put before the line, how many stand there; and those that came from it, how many.
int64_t wh_board_send(void *model, const uint8_t *bytes, int64_t count) {
    auto &queue = static_cast<Board *>(model)->host.to_send;
    queue.insert(queue.end(), bytes, bytes + count);
    return queue.size();
}

int64_t wh_board_received(void *model, uint8_t *bytes, int64_t room) {
    auto &queue = static_cast<Board *>(model)->host.received;
    const int64_t count = std::min<int64_t>(room, queue.size());
    std::copy_n(queue.begin(), count, bytes);
    queue.erase(queue.begin(), queue.begin() + count);
    return count;
}

// One clock with these inputs (set_inputs). Returns the gates, AH AL BH BL or of three legs AH BH CH AL BL
// CL, from bit 0, and behind them CS_n, SCLK, tick, whether a row is due, and with one free the fault's
// LED; where motors are parted, those of them that wh_ports_clock has, too. Inside the board nothing is seen:
// ticks are counted from alive, which changes a clock after each, and a row is due when half of the tick
// after it is over.
int64_t wh_board_clock(int64_t model, int64_t inputs) {
    auto &board = *reinterpret_cast<Board *>(model);
    auto &top = board.top;
    set_inputs(board, inputs);
    int64_t pins = step(board);
    const int64_t since = board.clocks - board.strobe;
    if (board.strobe >= 0 && since == board.tick_clocks) {
        pins |= 1 << kTick;
        // The bridges go on at any clock: alive has to tell a tick that began with them on.
        board.irregular += !board.told && board.began && top.running;
        board.told = false;
        board.began = top.running;
        board.marked = true;
        board.strobe = board.clocks;
    }
    const int64_t port = since - board.tick_clocks / 2;
    if (board.marked && port >= 0 && port < (board.parted ? kMotors : 1)) pins |= 1 << kRow | port << kPortShift;
    const bool once_more = board.again && board.told && since - 1 == board.again;
    if (top.alive != board.last_alive && top.running && !once_more) {
        board.irregular += board.strobe >= 0 && board.strobe != board.clocks - 1;
        board.strobe = board.clocks - 1;
        board.told = true;
        ++board.ticks;
    }
    board.last_alive = top.alive;
    pins |= static_cast<int64_t>(top.fault) << kFault;
    ++board.clocks;
    return pins;
}

// No words are seen at the pins.
int64_t wh_board_words(int64_t, int64_t) { return 0; }

// Clocks, ticks told by alive, irregular ones, clocks with both gates of a leg on, with a gate on
// while not running, in which a motor's gates aren't the first one's, whether it runs, its fault, and the
// digest of all pins at all clocks.
void wh_board_report(void *model, int64_t *report) {
    const auto &board = *static_cast<Board *>(model);
    report[0] = board.clocks;
    report[1] = board.ticks;
    report[2] = board.irregular;
    report[3] = board.both_on;
    report[4] = board.idle_on;
    report[5] = board.apart;
    report[6] = board.top.running;
    report[7] = board.top.fault;
    report[8] = static_cast<int64_t>(board.seen);
}

}  // extern "C"
