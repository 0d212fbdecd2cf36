// SPDX-License-Identifier: Apache-2.0
//
// bench_anchor: wh_anchor with its multiplier, which another user takes whenever busy_i is set.

`default_nettype none
`include "wh_formats.vh"

module bench_anchor (
    input  wire                              clk,
    input  wire                              rst,
    input  wire                              start_i,
    input  wire                              update_i,
    input  wire                              busy_i,
    output wire                              busy_o,
    output wire                              overrun_o,
    input  wire signed [`WH_COUNT_W-1:0]     position_i,
    input  wire                              contact_i,
    input  wire signed [`WH_COUNT_W-1:0]     depth_i,
    input  wire signed [`WH_DATA_W-1:0]      current_i,
    input  wire                              saturated_i,
    input  wire signed [`WH_COEF_W-1:0]      coef_i,         // of the other user
    input  wire [`WH_ANCHOR_W-1:0]           words_i,
    output wire signed [`WH_DATA_W-1:0]      wave_o,
    output wire signed [`WH_COEF_W-1:0]      root_o,
    output wire signed [`WH_DATA_W-1:0]      limit_o,
    output wire                              pulled_o,
    output wire signed [`WH_COEF_W-1:0]      tracked_o,
    output wire                              fault_o
);

    wire                               request;
    wire signed [`WH_DATA_W-1:0]       factor;
    wire signed [`WH_COEF_W-1:0]       coefficient;
    wire [1:0]                         grant;
    wire [1:0]                         done;
    wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product;

    // The other user comes first, with factors of its own.
    wh_multiply_shared #(
        .USERS     (2)
    ) multiply_shared (
        .clk       (clk),
        .rst       (rst),
        .request_i ({request, busy_i}),
        .data_i    ({factor, current_i}),
        .coef_i    ({coefficient, coef_i}),
        .grant_o   (grant),
        .done_o    (done),
        .product_o (product)
    );

    wh_anchor anchor (
        .clk             (clk),
        .rst             (rst),
        .start_i         (start_i),
        .update_i        (update_i),
        .busy_o          (busy_o),
        .overrun_o       (overrun_o),
        .position_i      (position_i),
        .contact_i       (contact_i),
        .depth_i         (depth_i),
        .current_i       (current_i),
        .saturated_i     (saturated_i),
        .words_i         (words_i),
        .request_o       (request),
        .factor_o        (factor),
        .coefficient_o   (coefficient),
        .grant_i         (grant[1]),
        .done_i          (done[1]),
        .product_i       (product),
        .wave_o          (wave_o),
        .root_o          (root_o),
        .limit_o         (limit_o),
        .pulled_o        (pulled_o),
        .tracked_o       (tracked_o),
        .fault_o         (fault_o)
    );

endmodule

`default_nettype wire
