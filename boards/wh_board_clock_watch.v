// SPDX-License-Identifier: Apache-2.0
//
// wh_board_clock_watch: takes the gates off the pads when the clock stops.
//
//   beat     changes every 2^BEAT_LOG2 clocks of clk
//   gates_o  = gates_i while the beat is heard, else 0
//   lost_o   = 1 while it is not
//
// The only block with two clocks: what judges a clock can't run on it. watch_clk comes from an
// oscillator of its own, in the FPGA, and need not be exact. A beat that has not changed for
// 2^PATIENCE_LOG2 clocks of watch_clk is not heard any more, and so is one that is too slow. It is
// heard again once it has changed twice in reset: then the flip-flops before gates_i have been off
// for 2^BEAT_LOG2 clocks. So a clock that comes back by itself leaves the gates off.
//
// With T_w a period of watch_clk and T_b = 2^BEAT_LOG2 periods of clk there are no false alarms for
//
//   T_w < T_b < (2^PATIENCE_LOG2 - 2) * T_w
//
// Between gates_i and gates_o is one AND gate: a flip-flop that stands still at 1 holds nothing on.
// Its other input is a flip-flop's output, so it makes no glitch. lost_o belongs to watch_clk: to
// be taken through a synchroniser.
// Latency: gates off at most 2^PATIENCE_LOG2 + 3 clocks of watch_clk after the last clock of clk.
// Reset: the gates pass again from the second beat on, see above. The registers begin at 0, as the
// FPGA's configuration leaves them, which is a beat not heard: without watch_clk, without clk, and
// until the first reset is over the gates are off. The beat goes on in reset.

`default_nettype none

module wh_board_clock_watch #(
    parameter integer GATES         = 4,  // 1...
    parameter integer BEAT_LOG2     = 4,  // 2...16; T_b = 2^BEAT_LOG2 clocks
    parameter integer PATIENCE_LOG2 = 4   // 2...16
) (
    input  wire             clk,
    input  wire             rst,        // on clk

    input  wire             watch_clk,  // any phase and any rate within the bounds above

    input  wire [GATES-1:0] gates_i,    // on clk, from flip-flops
    output wire [GATES-1:0] gates_o,
    output wire             lost_o      // on watch_clk
);

    generate
        if (GATES < 1) begin : illegal_gates
            wh_illegal_parameter_clock_watch_gates_must_be_1_or_more stop ();
        end
        if (BEAT_LOG2 < 2 || BEAT_LOG2 > 16) begin : illegal_beat
            wh_illegal_parameter_clock_watch_beat_log2_must_be_2_to_16 stop ();
        end
        if (PATIENCE_LOG2 < 2 || PATIENCE_LOG2 > 16) begin : illegal_patience
            wh_illegal_parameter_clock_watch_patience_log2_must_be_2_to_16 stop ();
        end
    endgenerate

    // ---- On clk.

    reg [BEAT_LOG2:0] clocks_q;

    initial begin
        clocks_q = {BEAT_LOG2+1{1'b0}};
    end

    always @(posedge clk) begin
        clocks_q <= clocks_q + 1'b1;
    end

    // ---- On watch_clk.

    wire beat;
    wire in_reset;

    wh_synchroniser #(
        .WIDTH   (2)
    ) synchroniser (
        .clk     (watch_clk),
        .level_i ({rst, clocks_q[BEAT_LOG2]}),
        .level_o ({in_reset, beat})
    );

    reg                     before_q;  // the beat a clock ago
    reg [PATIENCE_LOG2-1:0] still_q;   // clocks without a change
    reg                     reset_q;   // in_reset a clock ago
    reg                     once_q;    // the beat has changed in this reset
    reg                     heard_q;

    initial begin
        before_q = 1'b0;
        still_q  = {PATIENCE_LOG2{1'b0}};
        reset_q  = 1'b0;
        once_q   = 1'b0;
        heard_q  = 1'b0;
    end

    wire change = (beat != before_q);
    wire late   = (still_q == {PATIENCE_LOG2{1'b1}});

    always @(posedge watch_clk) begin
        before_q <= beat;
        reset_q  <= in_reset;
        if (change) begin
            still_q <= {PATIENCE_LOG2{1'b0}};
        end else if (!late) begin
            still_q <= still_q + 1'b1;
        end
        if (late) begin
            once_q  <= 1'b0;
            heard_q <= 1'b0;
        end else begin
            // Not a change from before the reset that is seen with it.
            once_q  <= in_reset && (once_q || (reset_q && change));
            heard_q <= heard_q || (in_reset && once_q && change);
        end
    end

    assign gates_o = gates_i & {GATES{heard_q}};
    assign lost_o  = !heard_q;

endmodule

`default_nettype wire
