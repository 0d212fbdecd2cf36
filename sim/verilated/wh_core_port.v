// SPDX-License-Identifier: Apache-2.0
//
// wh_core_port: the wave core of one port with its anchor, numbers in and numbers out.
//
// A step is the core's; done_o comes when the anchor has ended its own as well, and its words are
// taken by the next step. Latency: the core's, or the anchor's where that is longer. Reset: both's.

`default_nettype none
`include "wh_formats.vh"

module wh_core_port #(
    parameter integer DELAY_LOG2 = 2,  // the delay line keeps 2^DELAY_LOG2 steps, 1...
    parameter integer ANCHOR     = 0,  // 1: with wh_anchor
    parameter integer SHAPER     = 0,  // sections of W, 0...2
    parameter integer SHAPE_BITS = ((SHAPER > 0) ? SHAPER : 1)  // derived, leave it
                                   * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W)
) (
    input  wire                              clk,
    input  wire                              rst,

    input  wire                              start_i,
    output wire                              done_o,        // strobe

    input  wire signed [`WH_DATA_W-1:0]      current_i,     // s31q24 A: i_n
    input  wire                              contact_i,
    input  wire signed [`WH_COUNT_W-1:0]     position_i,    // s32, counts
    input  wire signed [`WH_COUNT_W-1:0]     depth_i,       // s32, counts
    input  wire signed [`WH_COEF_W-1:0]      eta_contact_i, // s27q25
    input  wire signed [`WH_COEF_W-1:0]      eta_free_i,    // s27q25
    input  wire        [1:0]                 shape_mode_i,
    input  wire        [SHAPE_BITS-1:0]      shape_words_i,
    input  wire signed [`WH_COEF_W-1:0]      a_i,           // s27q25
    input  wire        [DELAY_LOG2-1:0]      extra_ticks_i,
    input  wire        [DELAY_LOG2-1:0]      hold_ticks_i,

    input  wire signed [`WH_COEF_W-1:0]      root_i,        // s27q22 √Ω: s without an anchor
    input  wire signed [`WH_DATA_W-1:0]      u_max_i,       // s31q23 √W: without an anchor
    input  wire [`WH_ANCHOR_W-1:0]           anchor_words_i, // as wh_anchor has them

    output wire signed [`WH_DATA_W-1:0]      voltage_o,     // s31q23 V: e to be applied
    output wire signed [`WH_DATA_W-1:0]      u_o,           // s31q23 √W: u_n
    output wire signed [`WH_DATA_W-1:0]      v_o,           // s31q23 √W: v_n
    output wire                              pulled_o,      // of the next step: the contact is over
    output wire signed [`WH_COEF_W-1:0]      root_o,        // s27q22 √Ω: s of the next step
    output wire signed [`WH_COEF_W-1:0]      tracked_o,     // s27q22 √Ω: s in contact
    output wire signed [`WH_DATA_W-1:0]      limit_o,       // s31q23 √W: u_max of the next step
    output wire                              fault_o        // encoder lost
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

    wire                     core_busy;
    wire                     core_valid;
    wire                     core_overrun;
    wire                     saturated;
    wire signed [DATA_W-1:0] wave;
    wire                     touching = contact_i && !pulled_o;

    wire [DATA_W-1:0] newest_u;
    wire [DATA_W-1:0] next_u;
    wire              unused_ahead = &{1'b0, newest_u, next_u};

    wh_wave_core #(
        .N             (1),
        .DELAY_LOG2    (DELAY_LOG2),
        .ANCHOR        (ANCHOR),
        .SHAPER        (SHAPER)
    ) core (
        .clk           (clk),
        .rst           (rst),
        .start_i       (start_i),
        .busy_o        (core_busy),
        .valid_o       (core_valid),
        .overrun_o     (core_overrun),
        .current_i     (current_i),
        .eta_i         (touching ? eta_contact_i : eta_free_i),
        .anchor_i      (touching ? wave : {DATA_W{1'b0}}),
        .shape_mode_i  (shape_mode_i),
        .shape_words_i (shape_words_i),
        .root_i        (root_o),
        .a_i           (a_i),
        .u_max_i       (limit_o),
        .extra_ticks_i (extra_ticks_i),
        .hold_ticks_i  (hold_ticks_i),
        .voltage_o     (voltage_o),
        .u_o           (u_o),
        .v_o           (v_o),
        .saturated_o   (saturated),
        .newest_u_o    (newest_u),
        .next_u_o      (next_u)
    );

    generate
        if (ANCHOR == 1) begin : anchored
            wire                            anchor_busy;
            wire                            request;
            wire signed [DATA_W-1:0]        factor;
            wire signed [COEF_W-1:0]        coefficient;
            wire                            grant;
            wire                            done;
            wire signed [DATA_W+COEF_W-1:0] product;
            wire                            overrun;

            wh_multiply_shared #(
                .USERS     (1)
            ) multiply_shared (
                .clk       (clk),
                .rst       (rst),
                .request_i (request),
                .data_i    (factor),
                .coef_i    (coefficient),
                .grant_o   (grant),
                .done_o    (done),
                .product_o (product)
            );

            wh_anchor anchor (
                .clk             (clk),
                .rst             (rst),
                .start_i         (start_i),
                .update_i        (core_valid),
                .busy_o          (anchor_busy),
                .overrun_o       (overrun),
                .position_i      (position_i),
                .contact_i       (contact_i),
                .depth_i         (depth_i),
                .current_i       (current_i),
                .saturated_i     (saturated),
                .words_i         (anchor_words_i),
                .request_o       (request),
                .factor_o        (factor),
                .coefficient_o   (coefficient),
                .grant_i         (grant),
                .done_i          (done),
                .product_i       (product),
                .wave_o          (wave),
                .root_o          (root_o),
                .limit_o         (limit_o),
                .pulled_o        (pulled_o),
                .tracked_o       (tracked_o),
                .fault_o         (fault_o)
            );

            // The core may be done before the anchor, and the other way round.
            reg working_q;

            always @(posedge clk) begin
                working_q <= !rst && (start_i || core_busy || anchor_busy);
            end

            assign done_o = working_q && !core_busy && !anchor_busy;
        end else begin : plain
            assign pulled_o = 1'b0;
            assign tracked_o = root_i;
            assign fault_o  = 1'b0;
            assign wave     = {DATA_W{1'b0}};
            assign root_o   = root_i;
            assign limit_o  = u_max_i;
            assign done_o   = core_valid;
        end
    endgenerate

endmodule

`default_nettype wire
