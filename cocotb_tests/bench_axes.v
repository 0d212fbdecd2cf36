// SPDX-License-Identifier: Apache-2.0
//
// bench_axes: wh_axes with its multiplier, which another user takes whenever other_i is set.

`default_nettype none
`include "wh_formats.vh"

module bench_axes #(
    parameter integer DELAY_LOG2 = 2,  // as wh_axes has them
    parameter integer SHAPER     = 0,
    parameter integer ANCHOR     = 0,
    parameter integer SHAPE_BITS = ((SHAPER > 0) ? SHAPER : 1)  // derived, leave it
                                   * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W)
) (
    input  wire                              clk,
    input  wire                              rst,

    input  wire                              damp_i,
    input  wire                              start_i,
    output wire                              busy_o,
    output wire                              anchor_busy_o,
    output wire                              valid_o,
    output wire                              overrun_o,

    input  wire [2*`WH_DATA_W-1:0]           current_i,
    input  wire [`WH_COEF_W-1:0]             eta_i,
    input  wire [`WH_COEF_W-1:0]             root_i,
    input  wire [`WH_COEF_W-1:0]             a_i,
    input  wire [`WH_DATA_W-1:0]             u_max_i,
    input  wire [DELAY_LOG2-1:0]             extra_ticks_i,
    input  wire [DELAY_LOG2-1:0]             hold_ticks_i,
    input  wire [SHAPE_BITS-1:0]             shape_words_i,
    input  wire                              shaped_i,

    input  wire signed [`WH_COUNT_W-1:0]     position_i,
    input  wire [2*(`WH_PLACE_W+`WH_SINE_Q)-1:0] place_i,
    input  wire [2*(`WH_SINE_Q+2)-1:0]       cell_i,
    input  wire                              contact_i,
    input  wire [`WH_ANCHOR_W-1:0]           anchor_words_i,
    input  wire                              angle_rst_i,
    input  wire                              find_magnet_i,
    input  wire [31:0]                       count_angle_i,
    output wire                              turn_o,
    output wire [31:0]                       by_o,
    input  wire                              turned_i,
    output wire                              magnet_found_o,

    input  wire                              other_i,

    output wire [2*`WH_DATA_W-1:0]           voltage_o,
    output wire [2*`WH_DATA_W-1:0]           current_o,
    output wire [2*`WH_DATA_W-1:0]           u_o,
    output wire [2*`WH_DATA_W-1:0]           v_o,
    output wire [1:0]                        saturated_o,
    output wire [2*`WH_DATA_W-1:0]           correction_o,
    output wire [2*`WH_DATA_W-1:0]           next_o,
    output wire [2*`WH_DATA_W-1:0]           offset_o,
    output wire [2*`WH_DATA_W-1:0]           flux_o,
    output wire [2*`WH_DATA_W-1:0]           lag_o,
    output wire                              anchor_fault_o
);

    wire [1:0]                              request;
    wire [2*`WH_DATA_W-1:0]                 factor;
    wire [2*`WH_COEF_W-1:0]                 coefficient;
    wire [2:0]                              grant;
    wire [2:0]                              done;
    wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product;
    wire                                    reads;
    wire                                    anchor_reads;

    // The other user comes first; its product is nobody's.
    wh_multiply_shared #(
        .USERS     (3)
    ) multiply_shared (
        .clk       (clk),
        .rst       (rst),
        .drop_i    (3'b000),
        .request_i ({request, other_i}),
        .data_i    ({factor, ~factor[`WH_DATA_W-1:0]}),
        .coef_i    ({coefficient, ~coefficient[`WH_COEF_W-1:0]}),
        .grant_o   (grant),
        .done_o    (done),
        .product_o (product)
    );

    wh_axes #(
        .DELAY_LOG2     (DELAY_LOG2),
        .SHAPER         (SHAPER),
        .ANCHOR         (ANCHOR)
    ) axes (
        .clk            (clk),
        .rst            (rst),
        .damp_i         (damp_i),
        .start_i        (start_i),
        .busy_o         (busy_o),
        .reads_o        (reads),
        .anchor_busy_o  (anchor_busy_o),
        .anchor_reads_o (anchor_reads),
        .valid_o        (valid_o),
        .overrun_o      (overrun_o),
        .current_i      (current_i),
        .eta_i          (eta_i),
        .root_i         (reads ? root_i : ~root_i),
        .a_i            (reads ? a_i : ~a_i),
        .u_max_i        (u_max_i),
        .extra_ticks_i  (extra_ticks_i),
        .hold_ticks_i   (hold_ticks_i),
        .shape_words_i  (shape_words_i),
        .shaped_i       (shaped_i),
        .position_i     (position_i),
        .place_i        (place_i),
        .cell_i         (cell_i),
        .contact_i      (contact_i),
        .anchor_words_i (anchor_words_i),
        .angle_rst_i    (angle_rst_i),
        .find_magnet_i  (find_magnet_i),
        .count_angle_i  (count_angle_i),
        .turn_o         (turn_o),
        .by_o           (by_o),
        .turned_i       (turned_i),
        .magnet_found_o (magnet_found_o),
        .voltage_o      (voltage_o),
        .current_o      (current_o),
        .u_o            (u_o),
        .v_o            (v_o),
        .saturated_o    (saturated_o),
        .correction_o   (correction_o),
        .next_o         (next_o),
        .offset_o       (offset_o),
        .flux_o         (flux_o),
        .lag_o          (lag_o),
        .anchor_fault_o (anchor_fault_o),
        .request_o      (request),
        .factor_o       (factor),
        .coefficient_o  (coefficient),
        .grant_i        (grant[2:1]),
        .done_i         (done[2:1]),
        .product_i      (product)
    );

endmodule

`default_nettype wire
