// SPDX-License-Identifier: Apache-2.0
//
// wh_modulator, as a proof of what is behind it sees it: any width in any clock, and any request.

`default_nettype none
`include "wh_formats.vh"

module wh_modulator #(
    parameter integer MIN_PULSE = 0
) (
    input  wire                                    clk,
    input  wire                                    rst,
    input  wire                                    valid_i,
    input  wire signed [`WH_DATA_W-1:0]            voltage_i,
    input  wire signed [`WH_COEF_W-1:0]            clocks_per_volt_i,
    input  wire        [`WH_TICK_W-1:0]            half_clocks_i,
    input  wire                                    second_order_i,
    input  wire signed [`WH_EXTRA_W-1:0]           extra_i,
    input  wire        [7:0]                       least_i,
    input  wire        [7:0]                       spare_i,
    output wire                                    request_o,
    input  wire                                    grant_i,
    output wire signed [`WH_DATA_W-1:0]            factor_o,
    output wire signed [`WH_COEF_W-1:0]            coefficient_o,
    input  wire                                    done_i,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i,
    input  wire                                    take_i,
    input  wire                                    update_i,
    output wire signed [`WH_TICK_W-1:0]            width_o
);

    (* anyseq *) wire signed [`WH_TICK_W-1:0] width;
    (* anyseq *) wire                         request;

    assign width_o       = width;
    assign request_o     = request;
    assign factor_o      = voltage_i;
    assign coefficient_o = clocks_per_volt_i;

    wire unused = &{1'b0, clk, rst, valid_i, half_clocks_i, second_order_i, extra_i, least_i, spare_i,
                    grant_i, done_i, product_i, take_i, update_i, MIN_PULSE[0]};

endmodule

`default_nettype wire
