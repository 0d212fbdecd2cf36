// SPDX-License-Identifier: Apache-2.0
//
// wh_half_bridge: the two gates of a leg, with dead time and interlock.
//
//   leg 1: high_o on, low_o off      leg 0: high_o off, low_o on
//
// A gate goes off in the clock edge that sees the leg change, and the other goes on dead_clocks_i
// later: both are off for dead_clocks_i clocks. A leg that changes again in its dead time starts
// the dead time anew. With dead_clocks_i = 0 one edge turns one gate off and the other on. The
// gates come straight from flip-flops, so they have no glitches.
// Latency: 1 clock to off, 1 + dead_clocks_i to on. Reset or enable_i low: both off at the next
// clock edge; after it the dead time passes before a gate goes on.

`default_nettype none

module wh_half_bridge (
    input  wire       clk,
    input  wire       rst,

    input  wire       enable_i,
    input  wire       leg_i,
    input  wire [7:0] dead_clocks_i,

    output reg        high_o,
    output reg        low_o
);

    reg       leg_q;
    reg [7:0] dead_q;  // clocks of dead time still to come

    wire change = (leg_i != leg_q);
    wire dead   = change ? (dead_clocks_i != 8'd0) : (dead_q != 8'd0);

    always @(posedge clk) begin
        leg_q <= leg_i;
        if (rst || !enable_i) begin
            dead_q <= dead_clocks_i;
            high_o <= 1'b0;
            low_o  <= 1'b0;
        end else begin
            if (change) begin
                dead_q <= (dead_clocks_i == 8'd0) ? 8'd0 : dead_clocks_i - 8'd1;
            end else if (dead_q != 8'd0) begin
                dead_q <= dead_q - 8'd1;
            end
            high_o <= leg_i && !dead;
            low_o  <= !leg_i && !dead;
        end
    end

endmodule

`default_nettype wire
