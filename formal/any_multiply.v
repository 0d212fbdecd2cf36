// SPDX-License-Identifier: Apache-2.0
//
// wh_multiply, as a proof sees it: any product that has the right sign and, where the coefficient is
// in [-1, 1] (COEF_W - 2 places), isn't larger than the other factor. The real one is among them
// (formal/wh_multiply.v), and so is each that rounds in whatever way.

`default_nettype none
`include "wh_formats.vh"

module wh_multiply #(
    parameter integer DATA_W = `WH_DATA_W,
    parameter integer COEF_W = `WH_COEF_W,
    parameter integer LIMB_W = `WH_LIMB_W
) (
    input wire clk,

    input  wire                            take_i,
    input  wire signed [DATA_W-1:0]        data_i,
    input  wire signed [COEF_W-1:0]        coef_i,
    output wire signed [DATA_W+COEF_W-1:0] product_o
);

    localparam integer PRODUCT_W = DATA_W + COEF_W;
    localparam integer Q = COEF_W - 2;

    (* anyseq *) wire signed [PRODUCT_W-1:0] free;

    reg signed [DATA_W-1:0] data_q1, data_q2, data_q3;
    reg signed [COEF_W-1:0] coef_q1, coef_q2, coef_q3;

    always @(posedge clk) begin
        {data_q3, data_q2, data_q1} <= {data_q2, data_q1, data_i};
        {coef_q3, coef_q2, coef_q1} <= {coef_q2, coef_q1, coef_i};
    end

    wire                        negative = data_q3[DATA_W-1] ^ coef_q3[COEF_W-1];
    wire signed [PRODUCT_W-1:0] data_3   = data_q3;
    wire signed [PRODUCT_W-1:0] at_most  = (data_q3[DATA_W-1] ? -data_3 : data_3) <<< Q;
    wire                        within   = coef_q3 <= $signed({2'b01, {Q{1'b0}}})
                                           && coef_q3 >= -$signed({2'b01, {Q{1'b0}}});

    always @* begin
        assume (free == 0 || (data_q3 != 0 && coef_q3 != 0 && free[PRODUCT_W-1] == negative));
        assume (!within || (free <= at_most && free >= -at_most));
    end

    assign product_o = free;

    wire unused = &{1'b0, take_i};

endmodule

`default_nettype wire
