// SPDX-License-Identifier: Apache-2.0
//
// wh_board_switch: what on a board lets the gates on and takes them off: button, stop, faults, clock.
//
// press_o tells that start_i has risen; permit_o that the gates may be on: stop_i is low and there was no
// fault: of the encoder, of waves and encoder that don't agree, of a tick too short for its work, of a sample
// of the current at trip, which lies below what clips, of what the guard finds where the board has one, and of
// a lost clock. A fault lasts until clear_i, a strobe, or reset; a lost clock until reset. Whether the gates
// are on is wh_arm's to say, which gets both. A zero beyond zero_limit is shown by fault_o and keeps the gates
// off, but it doesn't last: the next press, or a 1 over the line, measures it anew.
//
// start_i and stop_i are asynchronous, and start_i believed once it has been still for 2^SETTLE_LOG2
// clocks; off needs no patience. A first zero of the currents is measured unasked. What encoder, current and
// guard say before that, as long as an ADC wakes up, is forgotten (forget_o), and nothing is permitted.
//
// clock_lost_i is what wh_board_clock_watch found, which takes the gates off the pads; 0 where the board
// has none. alive_o changes at each tick while the gates are on, with AGAIN so many clocks after it once more, and is
// low otherwise; it stands still without a clock, and a charge pump behind it lets go of the bridge.
// Latency: permit_o is low 3 clocks after stop_i or clock_lost_i, 2 after a fault, and the gates a clock later.
// Reset: nothing permitted, alive_o low.

`default_nettype none

module wh_board_switch #(
    parameter integer N           = 1,
    parameter integer AGAIN       = 0,  // 0...65535; 0: alive_o changes once a tick
    parameter integer SETTLE_LOG2 = 16  // start_i must be still for 2^SETTLE_LOG2 clocks
) (
    input  wire         clk,
    input  wire         rst,

    input  wire         start_i,        // asynchronous
    input  wire         stop_i,         // asynchronous
    input  wire         clock_lost_i,   // asynchronous

    // What the controller says, as wh_controller has it.
    input  wire         tick_i,
    input  wire         running_i,      // the gates are on
    input  wire         overrun_i,
    input  wire         zero_busy_i,
    input  wire [N-1:0] zero_fault_i,
    input  wire [N-1:0] anchor_fault_i,
    input  wire [N-1:0] encoder_fault_i,
    input  wire [N-1:0] overcurrent_i,
    input  wire         guard_fault_i,  // any
    input  wire         guard_lasts_i,  // but a zero's
    input  wire         clear_i,        // strobe

    output wire         forget_o,       // faults, as long as it is high
    output wire         zero_start_o,   // strobe
    output wire         press_o,        // strobe
    output wire         permit_o,
    output wire         alive_o,
    output wire         fault_o
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

    wire settled = (settle_q == {SETTLE_LOG2{1'b1}});

    // The first zero comes unasked, so that what is judged with the gates off has one.
    reg        zero_start_q;
    reg        zero_asked_q;
    reg        zeroed_q;       // there is a zero
    reg  [2:0] zero_ticks_q;   // ticks since then: currents of before have passed
    wire       awake    = zero_ticks_q[2];

    reg        press_q;
    reg        permit_q;
    reg        fault_q;
    reg        clock_lost_q;
    reg  [2:0] clear_q;        // until then what says faults has forgotten them at the same strobe

    always @(posedge clk) begin
        if (rst) begin
            settle_q     <= {SETTLE_LOG2{1'b0}};
            pressed_q    <= 1'b1;
            zero_start_q <= 1'b0;
            zero_asked_q <= 1'b0;
            zeroed_q     <= 1'b0;
            zero_ticks_q <= 3'b000;
            press_q      <= 1'b0;
            permit_q     <= 1'b0;
            fault_q      <= 1'b0;
            clock_lost_q <= 1'b0;
            clear_q      <= 3'b000;
        end else begin
            if (start == pressed_q) begin
                settle_q <= {SETTLE_LOG2{1'b0}};
            end else begin
                settle_q <= settle_q + 1'b1;
                if (settled) begin
                    pressed_q <= start;
                end
            end
            press_q      <= settled && start && !pressed_q;
            zero_start_q <= settled && !zero_asked_q;
            zero_asked_q <= zero_asked_q || settled;
            zeroed_q     <= zeroed_q || (zero_asked_q && !zero_start_q && !zero_busy_i);
            if (tick_i) begin
                zero_ticks_q <= {zero_ticks_q[1:0], zeroed_q};
            end
            clock_lost_q <= clock_lost_q || clock_lost;
            clear_q      <= {clear_q[1:0], clear_i};
            fault_q      <= (fault_q && !clear_q[2]) || overrun_i || (|anchor_fault_i)
                            || (((|encoder_fault_i) || (|overcurrent_i) || guard_lasts_i) && awake);
            permit_q     <= awake && !stop && !fault_q && !clock_lost_q;
        end
    end

    assign forget_o     = !awake;
    assign zero_start_o = zero_start_q;
    assign press_o      = press_q;
    assign permit_o     = permit_q;
    assign fault_o      = fault_q || clock_lost_q || (|zero_fault_i) || (guard_fault_i && awake);

    reg  alive_q;
    wire again;

    generate
        if (AGAIN > 0) begin : twice
            reg [15:0] since_q;  // the tick; 0: it is longer ago

            assign again = since_q == AGAIN[15:0];

            always @(posedge clk) begin
                since_q <= rst ? 16'd0 : tick_i ? 16'd1 : (again || since_q == 16'd0) ? 16'd0 : since_q + 16'd1;
            end
        end else begin : once
            assign again = 1'b0;
        end
    endgenerate

    always @(posedge clk) begin
        alive_q <= !rst && running_i && (alive_q ^ (tick_i || again));
    end

    assign alive_o = alive_q;

endmodule

`default_nettype wire
