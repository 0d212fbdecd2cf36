// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_round: the nearest word, halves away from zero.

`default_nettype none

module prove_wh_round #(
    parameter integer IN_W  = 36,
    parameter integer SHIFT = 16
) (
    input wire                   clk,
    input wire signed [IN_W-1:0] value
);

    localparam integer OUT_W = IN_W - SHIFT + 1;

    wire signed [OUT_W-1:0] word;

    wh_round #(
        .IN_W    (IN_W),
        .SHIFT   (SHIFT)
    ) block (
        .value_i (value),
        .value_o (word)
    );

    // 2^SHIFT word, and how far the value is above it.
    wire signed [IN_W+1:0] back = $signed({{(IN_W + 2 - OUT_W - SHIFT){word[OUT_W-1]}}, word,
                                           {SHIFT{1'b0}}});
    wire signed [IN_W+1:0] over = value - back;
    wire signed [IN_W+1:0] half = $signed({{(IN_W + 2 - SHIFT){1'b0}}, 1'b1, {(SHIFT - 1){1'b0}}});

    always @(posedge clk) begin
        assert (over <= half && over >= -half);
        if (over == half) assert (value < 0);
        if (over == -half) assert (value > 0);
        cover (over == half);
        cover (over == -half);
        cover (value[IN_W-2:0] == {(IN_W - 1){1'b1}} && !value[IN_W-1]);
    end

endmodule

`default_nettype wire
