// SPDX-License-Identifier: Apache-2.0
//
// bench_arithmetic: every word of small formats through the arithmetic modules.
//
// Raised go_i runs all pairs of two W-bit words, and done_o follows; a word of answers a pair is then
// in products.hex. Another pair comes after each, which isn't to be taken: the product must stay for
// a second clock, or held_o falls. The modules without a clock have value_i for all of them.

`default_nettype none
`timescale 1ns / 1ps

module bench_arithmetic #(
    parameter integer W      = 7,  // of value_i and of the factors
    parameter integer LIMB_W = 3
) (
    input  wire               go_i,
    output reg                done_o,
    output reg                held_o,

    input  wire [W-1:0]       value_i,
    output wire [(W-1)*W-1:0] truncated_o,  // field n: SHIFT = n + 1, sign-extended to W bits
    output wire [(W-2)*W-1:0] saturated_o   // field n: OUT_W = n + 2, sign-extended to W bits
);

    genvar n;
    generate
        for (n = 0; n < W - 1; n = n + 1) begin : shifts
            wire signed [W-n-2:0] floor;
            wire                  up;
            wh_truncate #(
                .IN_W    (W),
                .SHIFT   (n + 1)
            ) truncate (
                .value_i ($signed(value_i)),
                .floor_o (floor),
                .up_o    (up)
            );
            assign truncated_o[n*W +: W] =
                {{(n + 1){floor[W-n-2]}}, floor} + {{(W - 1){1'b0}}, up};
        end
        for (n = 0; n < W - 2; n = n + 1) begin : widths
            wire signed [n+1:0] value;
            wh_saturate #(
                .IN_W    (W),
                .OUT_W   (n + 2)
            ) saturate (
                .value_i ($signed(value_i)),
                .value_o (value)
            );
            assign saturated_o[n*W +: W] = {{(W - n - 2){value[n+1]}}, value};
        end
    endgenerate

    reg clk = 1'b0;
    always #5 clk = !clk;

    // Four, two and two partial products, and one: W > LIMB_W + 1 >= SHORT_W.
    localparam integer SHORT_W = LIMB_W + 1;

    reg                         take = 1'b0;
    reg  [2*W-1:0]              pair = {2 * W{1'b0}};
    wire signed [W-1:0]         data = $signed(pair[W-1:0]);
    wire signed [W-1:0]         coef = $signed(pair[2*W-1:W]);
    wire signed [SHORT_W-1:0]   short_data = $signed(pair[SHORT_W-1:0]);
    wire signed [SHORT_W-1:0]   short_coef = $signed(pair[W+SHORT_W-1:W]);
    wire signed [2*W-1:0]       long_long;
    wire signed [W+SHORT_W-1:0] long_short;
    wire signed [W+SHORT_W-1:0] short_long;
    wire signed [2*SHORT_W-1:0] short_short;

    wh_multiply #(.DATA_W(W), .COEF_W(W), .LIMB_W(LIMB_W)) multiply_long_long (
        .clk(clk), .take_i(take), .data_i(data), .coef_i(coef), .product_o(long_long)
    );
    wh_multiply #(.DATA_W(W), .COEF_W(SHORT_W), .LIMB_W(LIMB_W)) multiply_long_short (
        .clk(clk), .take_i(take), .data_i(data), .coef_i(short_coef), .product_o(long_short)
    );
    wh_multiply #(.DATA_W(SHORT_W), .COEF_W(W), .LIMB_W(LIMB_W)) multiply_short_long (
        .clk(clk), .take_i(take), .data_i(short_data), .coef_i(coef), .product_o(short_long)
    );
    wh_multiply #(.DATA_W(SHORT_W), .COEF_W(SHORT_W), .LIMB_W(LIMB_W)) multiply_short_short (
        .clk(clk), .take_i(take), .data_i(short_data), .coef_i(short_coef), .product_o(short_short)
    );

    localparam integer LATENCY = 3;

    wire [4*W+4*SHORT_W-1:0] answers = {short_short, short_long, long_short, long_long};
    reg  [4*W+4*SHORT_W-1:0] products [0:(1<<(2*W))-1];
    integer                  clocks;

    initial begin
        done_o = 1'b0;
        held_o = 1'b1;
        wait (go_i);
        for (clocks = 0; clocks < (2 << (2 * W)) + LATENCY; clocks = clocks + 1) begin
            take = clocks[0];
            pair = clocks[2*W:1] ^ {2 * W{take}};
            if (clocks >= LATENCY && clocks[0] == 1'b1) begin
                products[(clocks-LATENCY)/2] = answers;
            end
            if (clocks > LATENCY && clocks[0] == 1'b0 && products[(clocks-LATENCY-1)/2] !== answers)
            begin
                held_o = 1'b0;
            end
            @(negedge clk);
        end
        $writememh("products.hex", products);
        done_o = 1'b1;
    end

endmodule

`default_nettype wire
