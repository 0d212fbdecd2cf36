// SPDX-License-Identifier: Apache-2.0
//
// wh_sense_check: plausibility checks of a current sensor's samples.
//
//   range_o = |sample| >= range_i for the last sample: it is at or beyond the end of the scale
//   stuck_o = the last stuck_words_i samples were identical
//
// An amplifier and an ADC with any noise don't repeat a sample for long. If they do, they are broken, held in reset or
// not connected.
// Formats: sample s16, range_i in the same unit. stuck_words_i = 0 or 1 switches the check off. Both outputs are levels
// that follow the samples; the guard latches them. Latency: 1 clock from valid_i. Reset: no sample yet.

`default_nettype none
`include "wh_formats.vh"

module wh_sense_check (
    input  wire                           clk,
    input  wire                           rst,

    input  wire                           valid_i,        // strobe
    input  wire signed [`WH_SAMPLE_W-1:0] sample_i,       // s16, +-2^15 is full scale

    input  wire [15:0]                    range_i,        // of 2^15; 65535: off
    input  wire [15:0]                    stuck_words_i,  // 2...65535; 0, 1: off

    output wire                           range_o,
    output reg                            stuck_o
);

    wh_trip range (
        .clk      (clk),
        .rst      (rst),
        .valid_i  (valid_i),
        .sample_i (sample_i),
        .trip_i   (range_i),
        .trip_o   (range_o)
    );

    reg signed [`WH_SAMPLE_W-1:0] last_q;
    reg        [15:0]             same_q;   // words that are all last_q

    wire        same  = (sample_i == last_q);
    wire [15:0] count = !same ? 16'd1 : (same_q == 16'hffff) ? same_q : same_q + 16'd1;

    always @(posedge clk) begin
        if (rst) begin
            last_q  <= {`WH_SAMPLE_W{1'b0}};
            same_q  <= 16'd0;
            stuck_o <= 1'b0;
        end else if (valid_i) begin
            last_q  <= sample_i;
            same_q  <= count;
            stuck_o <= (stuck_words_i > 16'd1) && (count >= stuck_words_i);
        end
    end

endmodule

`default_nettype wire
