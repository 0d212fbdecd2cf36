// SPDX-License-Identifier: Apache-2.0
//
// wh_step_watch: tells of ticks in which the wave core isn't asked for a step.
//
// A step starts in each tick. Without one, for want of a word that the tick's sum waits for, the
// gates would go on with the last voltage, and nothing else would tell.
// Ticks' ends are counted against starts, so that a lost step stays lost. Two ends may pass from one
// start to the next: starts wander by the clocks that samples and shared multiplications do, and
// where one is at the very end of a tick the next may be just behind the next end. So a single lost
// step may pass, and the second is told. Before the first start eight ends may pass, for a
// reader that has to settle.
//
// Latency: overrun_o 1 clock after the tick_i that is too many. Reset: no start yet.

`default_nettype none

module wh_step_watch (
    input  wire clk,
    input  wire rst,

    input  wire start_i,   // strobe, a step starts
    input  wire tick_i,    // strobe, a tick ends

    output reg  overrun_o  // until rst
);

    localparam [3:0] FIRST = 4'd8;
    localparam [3:0] LATER = 4'd2;

    reg       started_q;
    reg [3:0] left_q;  // ends that may still pass

    always @(posedge clk) begin
        if (rst) begin
            started_q <= 1'b0;
            left_q    <= FIRST;
            overrun_o <= 1'b0;
        end else if (start_i && !started_q) begin
            started_q <= 1'b1;
            left_q    <= tick_i ? LATER - 4'd1 : LATER;
        end else if (start_i && !tick_i && left_q <= LATER) begin
            left_q    <= left_q + 4'd1;
        end else if (tick_i && !start_i) begin
            overrun_o <= overrun_o || left_q == 4'd0;
            left_q    <= (left_q == 4'd0) ? 4'd0 : left_q - 4'd1;
        end
    end

endmodule

`default_nettype wire
