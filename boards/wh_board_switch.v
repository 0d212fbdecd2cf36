// SPDX-License-Identifier: Apache-2.0
//
// wh_board_switch: the switch that lets a board run.
//
// When start_i rises while stop_i is low, the zero of the currents is measured, and then the gates go
// on. They go off when stop_i is high, at a fault of the encoder, when waves and encoder don't agree,
// when a tick is too short for its work, when a sample of the current reaches trip, which lies below
// what clips, at what the guard finds where the board has one, when the clock was lost, and in reset.
// They stay off until start_i rises again; after a fault, until reset. A zero beyond zero_limit is a
// fault. start_i and stop_i are asynchronous, and believed once they have been still for 2^SETTLE_LOG2
// clocks; off needs no patience. What encoder, current and guard say before that time is over, as long
// as an ADC wakes up, and before a first zero, is forgotten: forget_o.
//
// clock_lost_i is what wh_board_clock_watch found, which takes the gates off the pads; 0 where the board
// has none. alive_o changes at each tick while the gates are on, and is low otherwise; it stands still
// without a clock, and a charge pump behind it lets go of the bridge.
// Latency: gates go off 4 clocks after stop_i or clock_lost_i, 2 after a fault.
// Reset: gates off, not running, alive_o low.

`default_nettype none

module wh_board_switch #(
    parameter integer N           = 1,
    parameter integer SETTLE_LOG2 = 16  // start_i must be still for 2^SETTLE_LOG2 clocks
) (
    input  wire         clk,
    input  wire         rst,

    input  wire         start_i,        // asynchronous
    input  wire         stop_i,         // asynchronous
    input  wire         clock_lost_i,   // asynchronous

    // What the controller says, as wh_controller has it.
    input  wire         tick_i,
    input  wire         overrun_i,
    input  wire [N-1:0] zero_busy_i,
    input  wire [N-1:0] zero_fault_i,
    input  wire [N-1:0] anchor_fault_i,
    input  wire [N-1:0] encoder_fault_i,
    input  wire [N-1:0] overcurrent_i,
    input  wire         guard_fault_i,  // any

    output wire         forget_o,       // faults, as long as it is high
    output wire         zero_start_o,
    output wire         alive_o,
    output wire         running_o,
    output wire         fault_o         // until reset
);

    wire start;
    wire stop;
    wire clock_lost;

    wh_synchroniser #(
        .WIDTH   (3)
    ) synchroniser (
        .clk     (clk),
        .level_i ({start_i, stop_i, clock_lost_i}),
        .level_o ({start, stop, clock_lost})
    );

    // Pressed is a level that has lasted: it may be the press that goes on through reset, which is
    // no rise.
    reg [SETTLE_LOG2-1:0] settle_q;
    reg                   pressed_q;
    reg                   running_q;
    reg                   fault_q;

    wire settled = (settle_q == {SETTLE_LOG2{1'b1}});

    // The first zero comes unasked, so that what is judged with the gates off has one.
    reg        starting_q;     // the gates are to go on after this zero
    reg        measuring_q;
    reg        zero_start_q;
    reg        zeroed_q;       // there is a zero
    reg  [2:0] zero_ticks_q;   // ticks since then: currents of before have passed
    wire       awake    = zero_ticks_q[2];
    wire       pressed  = settled && start && !pressed_q;
    wire       measures = settled && !running_q && (start || !zeroed_q);
    wire       measured = measuring_q && !zero_start_q && !(|zero_busy_i);

    always @(posedge clk) begin
        if (rst) begin
            settle_q     <= {SETTLE_LOG2{1'b0}};
            pressed_q    <= 1'b1;
            running_q    <= 1'b0;
            fault_q      <= 1'b0;
            starting_q   <= 1'b0;
            measuring_q  <= 1'b0;
            zero_start_q <= 1'b0;
            zeroed_q     <= 1'b0;
            zero_ticks_q <= 3'b000;
        end else begin
            fault_q <= fault_q || overrun_i || clock_lost || (|zero_fault_i) || (|anchor_fault_i)
                       || (((|encoder_fault_i) || (|overcurrent_i) || guard_fault_i) && awake);
            if (start == pressed_q) begin
                settle_q <= {SETTLE_LOG2{1'b0}};
            end else begin
                settle_q <= settle_q + 1'b1;
                if (settled) begin
                    pressed_q <= start;
                end
            end
            zero_start_q <= measures;
            measuring_q  <= measures || (measuring_q && !measured);
            zeroed_q     <= zeroed_q || measured;
            if (tick_i) begin
                zero_ticks_q <= {zero_ticks_q[1:0], zeroed_q};
            end
            if (stop || fault_q) begin
                starting_q <= 1'b0;
                running_q  <= 1'b0;
            end else if (pressed) begin
                starting_q <= !running_q;
            end else if (starting_q && measured && !(|zero_fault_i)) begin
                starting_q <= 1'b0;
                running_q  <= 1'b1;
            end
        end
    end

    assign forget_o     = !awake;
    assign zero_start_o = zero_start_q;
    assign running_o    = running_q;
    assign fault_o      = fault_q;

    reg alive_q;

    always @(posedge clk) begin
        alive_q <= !rst && running_q && (alive_q ^ tick_i);
    end

    assign alive_o = alive_q;

endmodule

`default_nettype wire
