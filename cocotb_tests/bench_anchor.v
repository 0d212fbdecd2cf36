// SPDX-License-Identifier: Apache-2.0
//
// bench_anchor: wh_anchor with its multiplier, which another user takes whenever other_i is set.
//
// The multiplier has a reset of its own, so that products asked for before the anchor's reset may
// come after it.

`default_nettype none
`include "wh_formats.vh"

module bench_anchor #(
    parameter integer AXIS = 0  // as wh_anchor has it
) (
    input  wire                          clk,
    input  wire                          rst,
    input  wire                          rst_multiplier,

    input  wire signed [`WH_COUNT_W-1:0] position_i,
    input  wire signed [`WH_PLACE_W+`WH_SINE_Q-1:0] place_i,
    input  wire signed [`WH_SINE_Q+1:0]  cell_i,
    input  wire                          contact_i,
    input  wire                          waves_i,
    input  wire signed [`WH_DATA_W-1:0]  current_i,
    input  wire signed [`WH_DATA_W-1:0]  u_i,
    input  wire signed [`WH_DATA_W-1:0]  v_i,
    input  wire signed [`WH_DATA_W-1:0]  withheld_i,
    input  wire signed [`WH_DATA_W-1:0]  voltage_i,
    input  wire                          saturated_i,
    input  wire                          blind_i,
    output wire                          busy_o,
    output wire                          overrun_o,

    input  wire [`WH_ANCHOR_W-1:0]       words_i,

    input  wire                          other_i,
    input  wire signed [`WH_DATA_W-1:0]  other_data_i,
    input  wire signed [`WH_COEF_W-1:0]  other_coef_i,
    output wire                          request_o,      // the anchor's

    output wire signed [`WH_DATA_W-1:0]  correction_o,
    output wire signed [`WH_DATA_W-1:0]  next_o,
    output wire signed [`WH_DATA_W-1:0]  room_o,
    output wire signed [`WH_DATA_W-1:0]  offset_o,
    output wire signed [`WH_DATA_W-1:0]  flux_o,
    output wire signed [`WH_DATA_W-1:0]  lag_o,
    output wire                          fault_o
);

    wire                                    request;
    wire signed [`WH_DATA_W-1:0]            factor;
    wire signed [`WH_COEF_W-1:0]            coefficient;
    wire [1:0]                              grant;
    wire [1:0]                              done;
    wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product;

    assign request_o = request;

    // Settings change with the end of a clock in which none is read.
    wire reads;
    reg  reads_q;
    wire held = reads || reads_q || rst;

    always @(posedge clk) reads_q <= reads;

    // The other user comes first.
    wh_multiply_shared #(
        .USERS     (2)
    ) multiply_shared (
        .clk       (clk),
        .rst       (rst_multiplier),
        .drop_i    (2'b00),
        .request_i ({request, other_i}),
        .data_i    ({factor, other_data_i}),
        .coef_i    ({coefficient, other_coef_i}),
        .grant_o   (grant),
        .done_o    (done),
        .product_o (product)
    );

    wh_anchor #(
        .AXIS          (AXIS)
    ) anchor (
        .clk           (clk),
        .rst           (rst),
        .position_i    (position_i),
        .place_i       (place_i),
        .cell_i        (cell_i),
        .contact_i     (contact_i),
        .waves_i       (waves_i),
        .current_i     (current_i),
        .u_i           (u_i),
        .v_i           (v_i),
        .withheld_i    (withheld_i),
        .voltage_i     (voltage_i),
        .saturated_i   (saturated_i),
        .blind_i       (blind_i),
        .busy_o        (busy_o),
        .reads_o       (reads),
        .overrun_o     (overrun_o),
        .words_i       (held ? words_i : ~words_i),
        .request_o     (request),
        .factor_o      (factor),
        .coefficient_o (coefficient),
        .grant_i       (grant[1]),
        .done_i        (done[1]),
        .product_i     (product),
        .correction_o  (correction_o),
        .next_o        (next_o),
        .room_o        (room_o),
        .offset_o      (offset_o),
        .flux_o        (flux_o),
        .lag_o         (lag_o),
        .fault_o       (fault_o)
    );

endmodule

`default_nettype wire
