// SPDX-License-Identifier: Apache-2.0
//
// wh_trip: whether the last ADC word is at or beyond a threshold, on either side.
//
//   trip_o = |sample| >= trip_i
//
// Formats: sample s16, the threshold in the same unit; one above 2^15 is never reached. Latency: 1
// clock from valid_i. Reset: no trip.

`default_nettype none
`include "wh_formats.vh"

module wh_trip (
    input  wire                           clk,
    input  wire                           rst,

    input  wire                           valid_i,   // strobe
    input  wire signed [`WH_SAMPLE_W-1:0] sample_i,  // s16, +-2^15 is full scale
    input  wire [15:0]                    trip_i,    // of 2^15

    output reg                            trip_o     // until the next word
);

    wire [`WH_SAMPLE_W-1:0] magnitude =
        sample_i[`WH_SAMPLE_W-1] ? -sample_i : sample_i;

    always @(posedge clk) begin
        if (rst) begin
            trip_o <= 1'b0;
        end else if (valid_i) begin
            trip_o <= (magnitude >= trip_i);
        end
    end

endmodule

`default_nettype wire
