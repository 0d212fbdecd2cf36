// SPDX-License-Identifier: Apache-2.0
//
// wh_motion: speeds and positions of N ports, which take turns, against their limits.
//
//   overspeed_o   a port moved by more than overspeed_i counts within a span; a limit of 0: no check
//   outside_o     a port's position < low_i or > high_i
//
// A span is 2^SPAN_LOG2 rounds, for all ports the same. In each round the position is compared with that at the span's
// begin, so a rotor that shakes on an edge adds up nothing. A steady speed of s counts a span raises overspeed_o if
// s >= limit + 1, after two spans at most, and never if s <= limit.
//
// Both are levels, with the bridges on or off. A speed is too high until a whole span has passed in which it wasn't. A
// position is outside until the port's next turn. With restart_i a new span begins: between two rounds any time may
// have passed. What was judged stays.
//
// The turn, in clocks since valid_i: 2, position and limits are taken; 3, they are judged, and overspeed_i still holds.
// A round begins with port 0. The next valid_i may come 3 clocks after this one. A port moves by less than
// 2^LIMIT_W counts from one turn to the next.
// State, by port: the position at the span's begin, LIMIT_W + 2 bits in LUT RAM (wh_port_state); three bits.
// Formats: s32 counts. Latency: 4 clocks from valid_i. Reset: nothing is beyond a limit.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_motion #(
    parameter integer N         = 1,                       // ports, 1...8
    parameter integer SPAN_LOG2 = `WH_SPAN_LOG2,           // 1...16
    parameter integer LIMIT_W   = 16,                      // bits of overspeed_i
    parameter integer PORT_W    = (N > 1) ? $clog2(N) : 1  // derived, leave it
) (
    input  wire                          clk,
    input  wire                          rst,
    input  wire                          restart_i,

    // A turn.
    input  wire                          valid_i,      // strobe
    input  wire [PORT_W-1:0]             port_i,
    input  wire signed [`WH_COUNT_W-1:0] position_i,   // s32, counts
    input  wire [LIMIT_W-1:0]            overspeed_i,  // counts
    input  wire signed [`WH_COUNT_W-1:0] low_i,        // s32, counts
    input  wire signed [`WH_COUNT_W-1:0] high_i,       // s32, counts

    output wire                          overspeed_o,
    output wire                          outside_o
);

    localparam integer WAY_W = LIMIT_W + 2;

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_motion_n_must_be_1_to_8 stop ();
        end
    endgenerate

    // ---- The turn: at_q[n] is clock n of it.
    reg [3:1]        at_q;
    reg [PORT_W-1:0] port_q;

    always @(posedge clk) begin
        if (valid_i) begin
            port_q <= port_i;
        end
        at_q <= rst ? 3'd0 : {at_q[2:1], valid_i};
    end

    // ---- The span. After restart_i no span ends as the first one begins.
    reg [SPAN_LOG2-1:0] rounds_q;
    reg                 begins_q;  // this round ends a span and begins the next
    reg                 first_q;   // this round only begins one
    reg                 fresh_q;   // the next round will

    always @(posedge clk) begin
        if (rst || restart_i) begin
            rounds_q <= {SPAN_LOG2{1'b0}};
            fresh_q  <= 1'b1;
        end else if (valid_i && port_i == {PORT_W{1'b0}}) begin
            rounds_q <= rounds_q + 1'b1;
            fresh_q  <= 1'b0;
            begins_q <= rounds_q == {SPAN_LOG2{1'b0}};
            first_q  <= fresh_q;
        end
    end

    // ---- The way since the span's begin.
    wire        [WAY_W-1:0] began;
    reg  signed [WAY_W-1:0] way_q;
    reg                     beyond_q;

    wh_port_state #(
        .N           (N),
        .W           (WAY_W)
    ) began_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_q),
        .save_i      (at_q[2] && begins_q),
        .save_port_i (port_q),
        .value_i     (position_i[WAY_W-1:0]),
        .value_o     (began)
    );

    always @(posedge clk) begin
        way_q    <= $signed(position_i[WAY_W-1:0] - began);
        beyond_q <= position_i < low_i || position_i > high_i;
    end

    // ---- What was judged, by port.
    // A sum that overflows is of a way beyond the limit, and has the sign of one.
    wire signed [WAY_W-1:0] limit   = $signed({2'b00, overspeed_i});
    wire signed [WAY_W-1:0] forth   = limit - way_q;
    wire signed [WAY_W-1:0] back    = limit + way_q;
    wire                    far     = !first_q && |overspeed_i && (forth[WAY_W-1] || back[WAY_W-1]);
    reg  [N-1:0]            far_q;      // in this span,
    reg  [N-1:0]            fast_q;     // or in this one or the last
    reg  [N-1:0]            outside_q;
    wire                    unused  = &{1'b0, forth, back};

    always @(posedge clk) begin
        if (rst) begin
            far_q     <= {N{1'b0}};
            fast_q    <= {N{1'b0}};
            outside_q <= {N{1'b0}};
        end else if (at_q[3]) begin
            far_q[port_q]     <= !begins_q && (far || far_q[port_q]);
            fast_q[port_q]    <= far || ((begins_q && !first_q) ? far_q[port_q] : fast_q[port_q]);
            outside_q[port_q] <= beyond_q;
        end
    end

    assign overspeed_o = |fast_q;
    assign outside_o   = |outside_q;

endmodule

`default_nettype wire
