// SPDX-License-Identifier: Apache-2.0
//
// wh_quadrature: counts the edges of an incremental encoder's A and B.
//
//   position' = position + 1 if A leads B, - 1 if B leads A, at each edge of A and of B
//
// A level of A or B counts once it has held for filter_clocks_i consecutive samples; anything shorter is a glitch. Each
// line has its own filter, so the lines may change right after each other, and each again after filter_clocks_i + 1
// clocks: two counts in that time.
// If A and B change in the same clock, the direction is unknown. Such a move isn't counted: illegal_o strobes, fault_o
// latches it, and faults_o counts it, also in the clock of a clear_i.
// Formats: position s32, counts, wraps at +-2^31. Latency: 2 clocks of synchroniser, filter_clocks_i of filter and 1 of
// counting from a pin to position_o; illegal_o comes 1 clock before fault_o.
// Reset: position 0, no fault. For SETTLE_CLOCKS after it the lines are followed without counting, so the encoder's
// levels at rest aren't a move.

`default_nettype none
`include "wh_formats.vh"

module wh_quadrature #(
    parameter integer COUNT_W = `WH_COUNT_W  // 2...: who adds up itself needs no more than moves between two looks
) (
    input  wire                         clk,
    input  wire                         rst,

    input  wire                         a_i,              // encoder's A, asynchronous
    input  wire                         b_i,              // encoder's B, asynchronous

    input  wire [3:0]                   filter_clocks_i,  // 1...15; 2 or 3 are usual
    input  wire                         clear_i,          // clears fault_o and faults_o

    output wire signed [COUNT_W-1:0]    position_o,     // s32, counts
    output reg                          moved_o,          // position_o has changed in this clock
    output reg                          direction_o,      // of the last move: 1 is +, 0 is -
    output wire                         illegal_o,        // strobe, illegal move
    output reg                          fault_o,          // illegal move seen; until clear_i
    output reg  [7:0]                   faults_o          // illegal moves, stops at 255
);

    localparam integer SETTLE_CLOCKS = 15;

    wire [1:0] seen;  // A, B

    wh_synchroniser #(
        .WIDTH   (2)
    ) synchroniser (
        .clk     (clk),
        .level_i ({a_i, b_i}),
        .level_o (seen)
    );

    reg [3:0] settle_q;
    wire      settled = (settle_q == SETTLE_CLOCKS[3:0]);

    always @(posedge clk) begin
        if (rst) begin
            settle_q <= 4'd0;
        end else if (!settled) begin
            settle_q <= settle_q + 4'd1;
        end
    end

    // A believed level gives way at the last of filter_clocks_i samples in a row that contradict
    // it.
    wire [1:0] level;

    genvar n;
    generate
        for (n = 0; n < 2; n = n + 1) begin : line
            reg       level_q;
            reg [3:0] against_q;  // samples in a row that contradicted level_q

            always @(posedge clk) begin
                if (rst || !settled) begin
                    level_q   <= seen[n];
                    against_q <= 4'd0;
                end else if (seen[n] == level_q) begin
                    against_q <= 4'd0;
                end else if (against_q + 4'd1 >= filter_clocks_i) begin
                    level_q   <= seen[n];
                    against_q <= 4'd0;
                end else begin
                    against_q <= against_q + 4'd1;
                end
            end

            assign level[n] = level_q;
        end
    endgenerate

    // A leads B: 00, 10, 11, 01 as A, B. Then B follows the old A: the new level of a line that
    // changed tells the direction.
    reg  [1:0] before_q;
    wire [1:0] change  = level ^ before_q;
    wire       one     = change[1] ^ change[0];
    wire       both    = change[1] && change[0];
    wire       forward = level[1] ^ before_q[0];

    reg signed [COUNT_W-1:0] position_q;

    assign position_o = position_q;

    always @(posedge clk) begin
        before_q <= level;
        moved_o  <= 1'b0;
        if (rst || !settled) begin
            position_q  <= {COUNT_W{1'b0}};
            direction_o <= 1'b0;
        end else if (one) begin
            position_q  <= forward ? position_q + {{COUNT_W-1{1'b0}}, 1'b1}
                                   : position_q - {{COUNT_W-1{1'b0}}, 1'b1};
            direction_o <= forward;
            moved_o     <= 1'b1;
        end
    end

    assign illegal_o = settled && both;

    always @(posedge clk) begin
        if (rst) begin
            fault_o  <= 1'b0;
            faults_o <= 8'd0;
        end else if (clear_i) begin
            fault_o  <= illegal_o;
            faults_o <= {7'd0, illegal_o};
        end else if (illegal_o) begin
            fault_o  <= 1'b1;
            faults_o <= (faults_o == 8'hFF) ? faults_o : faults_o + 8'd1;
        end
    end

endmodule

`default_nettype wire
