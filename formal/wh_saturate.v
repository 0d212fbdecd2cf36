// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_saturate: the word that is nearest.

`default_nettype none

module prove_wh_saturate #(
    parameter integer IN_W  = 64,
    parameter integer OUT_W = 31
) (
    input wire                   clk,
    input wire signed [IN_W-1:0] value
);

    localparam signed [IN_W-1:0] TOP    = (64'sd1 <<< (OUT_W - 1)) - 64'sd1;
    localparam signed [IN_W-1:0] BOTTOM = -(64'sd1 <<< (OUT_W - 1));

    wire signed [OUT_W-1:0] word;
    wire signed [IN_W-1:0]  long_word = word;

    wh_saturate #(
        .IN_W    (IN_W),
        .OUT_W   (OUT_W)
    ) block (
        .value_i (value),
        .value_o (word)
    );

    always @(posedge clk) begin
        if (value > TOP) assert (long_word == TOP);
        else if (value < BOTTOM) assert (long_word == BOTTOM);
        else assert (long_word == value);
        cover (value > TOP);
        cover (value < BOTTOM);
        cover (value == TOP);
    end

endmodule

`default_nettype wire
