// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_truncate: floor_o + up_o is the value without its fraction, and never longer than it.

`default_nettype none

module prove_wh_truncate #(
    parameter integer IN_W  = 58,
    parameter integer SHIFT = 23
) (
    input wire                   clk,
    input wire signed [IN_W-1:0] value
);

    localparam integer OUT_W = IN_W - SHIFT;

    wire signed [OUT_W-1:0] floor;
    wire                    up;

    wh_truncate #(
        .IN_W    (IN_W),
        .SHIFT   (SHIFT)
    ) block (
        .value_i (value),
        .floor_o (floor),
        .up_o    (up)
    );

    // One bit more, so that nothing here can wrap.
    wire signed [IN_W:0] size = value[IN_W-1] ? -$signed({value[IN_W-1], value})
                                              : $signed({value[IN_W-1], value});
    wire signed [IN_W:0] cut  = size >>> SHIFT;
    wire signed [IN_W:0] want = value[IN_W-1] ? -cut : cut;
    wire signed [IN_W:0] sum  = floor + $signed({1'b0, up});

    // As the sums take it.
    wire signed [OUT_W-1:0] short_sum = floor + $signed({{(OUT_W - 1){1'b0}}, up});

    always @(posedge clk) begin
        assert (sum == want);
        assert (short_sum == sum);
        cover (up);
        cover (value[IN_W-1] && !up);
        cover (up && short_sum == 0);
    end

endmodule

`default_nettype wire
