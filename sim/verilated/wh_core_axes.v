// SPDX-License-Identifier: Apache-2.0
//
// wh_core_axes: the two ports of a brushless motor with their anchors, numbers in and numbers out; the
// contact chooses η.
//
// Latency and reset: those of wh_axes; moving_o until the position's flux is there.

`default_nettype none
`include "wh_formats.vh"

module wh_core_axes #(
    parameter integer DELAY_LOG2 = 2,  // the delay line keeps 2^DELAY_LOG2 steps, 1...
    parameter integer SHAPER     = 0,  // sections of W, 0...2
    parameter integer ANCHOR     = 0,  // 1: there are port anchors
    parameter integer SHAPE_BITS = ((SHAPER > 0) ? SHAPER : 1)  // derived, leave it
                                   * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W)
) (
    input  wire                         clk,
    input  wire                         rst,

    input  wire                         start_i,
    output wire                         done_o,          // strobe
    output wire                         moving_o,        // a step may not start

    // Of two words, alpha's lowest.
    input  wire [2*`WH_DATA_W-1:0]      current_i,       // s31q24 A
    input  wire [3:0]                   ends_i,          // at the high, low end of its range, each axis
    input  wire                         contact_i,
    input  wire [`WH_COEF_W-1:0]        eta_contact_i,   // s27q25
    input  wire [`WH_COEF_W-1:0]        eta_free_i,      // s27q25
    input  wire [SHAPE_BITS-1:0]        shape_words_i,
    input  wire                         shaped_i,        // W is of the wall in contact
    input  wire [`WH_COEF_W-1:0]        root_i,          // s27q22 √Ω
    input  wire [`WH_COEF_W-1:0]        a_i,             // s27q25
    input  wire [`WH_DATA_W-1:0]        u_max_i,         // s31q23 √W
    input  wire [DELAY_LOG2-1:0]        extra_ticks_i,
    input  wire [DELAY_LOG2-1:0]        hold_ticks_i,

    input  wire signed [`WH_COUNT_W-1:0] position_i,     // s32, counts
    input  wire [31:0]                  count_angle_i,
    input  wire [31:0]                  zero_angle_i,
    input  wire [`WH_ANCHOR_W-1:0]      anchor_words_i,
    input  wire                         find_magnet_i,

    output wire [2*`WH_DATA_W-1:0]      voltage_o,       // s31q23 V: e to be applied
    output wire [2*`WH_DATA_W-1:0]      u_o,             // s31q23 √W: u_n
    output wire [2*`WH_DATA_W-1:0]      v_o,             // s31q23 √W: v_n
    output wire [1:0]                   saturated_o,
    output wire [1:0]                   clipped_o,       // i_n or v_n is at the end of its range
    output wire [2*`WH_DATA_W-1:0]      next_o,          // s31q23 V: c of the next tick
    output wire [2*`WH_DATA_W-1:0]      offset_o,        // s31q24 A
    output wire [2*`WH_DATA_W-1:0]      flux_o,          // s31q16 cells
    output wire [2*`WH_DATA_W-1:0]      lag_o,           // s31q16 cells
    output wire                         fault_o
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

    wire                                       busy;
    wire                                       anchor_busy;
    wire [1:0]                                 reads;
    wire                                       valid;
    wire                                       overrun;
    wire signed [`WH_COUNT_W-1:0]              position;
    wire [2*(`WH_PLACE_W+`WH_SINE_Q)-1:0]      place;
    wire [2*(`WH_SINE_Q+2)-1:0]                last_cell;
    wire [2*DATA_W-1:0]                        current;
    wire [2*DATA_W-1:0]                        correction;
    wire [1:0]                                 request;
    wire [2*DATA_W-1:0]                        factor;
    wire [2*COEF_W-1:0]                        coefficient;
    wire [1:0]                                 grant;
    wire [1:0]                                 done;
    wire signed [DATA_W+COEF_W-1:0]            product;
    wire                                       turn;
    wire [31:0]                                by;
    wire                                       turned;
    wire                                       found;
    wire [31:0]                                angle;
    wire                                       load, load_motor;
    wire signed [`WH_COUNT_W-1:0]              load_position;
    wire                                       unused = &{1'b0, overrun, current, correction, found, angle, reads,
                                                          load, load_motor, load_position};

    wh_rotor_flux rotor_flux (
        .clk           (clk),
        .rst           (rst),
        .position_i    (position_i),
        .count_angle_i (count_angle_i),
        .zero_angle_i  (zero_angle_i),
        .turn_i        (turn),
        .turn_motor_i  (1'b0),
        .by_i          (by),
        .turned_o      (turned),
        .angle_o       (angle),
        .load_o        (load),
        .load_motor_o  (load_motor),
        .load_position_o (load_position),
        .motor_i       (1'b0),
        .position_o    (position),
        .place_o       (place),
        .cell_o        (last_cell)
    );

    assign moving_o = (position != position_i);

    wh_multiply_shared #(
        .USERS     (2)
    ) multiply_shared (
        .clk       (clk),
        .rst       (rst),
        .drop_i    (2'b00),
        .request_i (request),
        .data_i    (factor),
        .coef_i    (coefficient),
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
        .damp_i         (1'b0),
        .start_i        (start_i),
        .busy_o         (busy),
        .reads_o        (reads[0]),
        .anchor_busy_o  (anchor_busy),
        .anchor_reads_o (reads[1]),
        .valid_o        (valid),
        .overrun_o      (overrun),
        .current_i      (current_i),
        .ends_i         (ends_i),
        .eta_i          (contact_i ? eta_contact_i : eta_free_i),
        .root_i         (root_i),
        .a_i            (a_i),
        .u_max_i        (u_max_i),
        .extra_ticks_i  (extra_ticks_i),
        .hold_ticks_i   (hold_ticks_i),
        .shape_words_i  (shape_words_i),
        .shaped_i       (shaped_i),
        .position_i     (position),
        .place_i        (place),
        .cell_i         (last_cell),
        .contact_i      (contact_i),
        .anchor_words_i (anchor_words_i),
        .angle_rst_i    (rst),
        .find_magnet_i  (find_magnet_i),
        .count_angle_i  (count_angle_i),
        .turn_o         (turn),
        .by_o           (by),
        .turned_i       (turned),
        .magnet_found_o (found),
        .voltage_o      (voltage_o),
        .current_o      (current),
        .u_o            (u_o),
        .v_o            (v_o),
        .saturated_o    (saturated_o),
        .clipped_o      (clipped_o),
        .correction_o   (correction),
        .next_o         (next_o),
        .offset_o       (offset_o),
        .flux_o         (flux_o),
        .lag_o          (lag_o),
        .anchor_fault_o (fault_o),
        .request_o      (request),
        .factor_o       (factor),
        .coefficient_o  (coefficient),
        .grant_i        (grant),
        .done_i         (done),
        .product_i      (product)
    );

    generate
        if (ANCHOR == 1) begin : anchored
            // next_o is there a clock after the anchors are done.
            wire works = start_i || busy || anchor_busy;
            reg  works_q, ends_q;

            always @(posedge clk) begin
                works_q <= !rst && works;
                ends_q  <= !rst && works_q && !works;
            end

            assign done_o = ends_q;

            wire unused_valid = &{1'b0, valid};
        end else begin : plain
            wire unused_busy = &{1'b0, busy, anchor_busy};

            assign done_o = valid;
        end
    endgenerate

endmodule

`default_nettype wire
