// SPDX-License-Identifier: Apache-2.0
//
// wh_core_port: the wave core of one port with its port anchor, numbers in and numbers out; the
// contact chooses η.
//
// Latency and reset: the core's.

`default_nettype none
`include "wh_formats.vh"

module wh_core_port #(
    parameter integer DELAY_LOG2 = 2,  // the delay line keeps 2^DELAY_LOG2 steps, 1...
    parameter integer SHAPER     = 0,  // sections of W, 0...2
    parameter integer ANCHOR     = 0,  // 1: there is a port anchor
    parameter integer SHAPE_BITS = ((SHAPER > 0) ? SHAPER : 1)  // derived, leave it
                                   * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W)
) (
    input  wire                              clk,
    input  wire                              rst,

    input  wire                              start_i,
    output wire                              done_o,        // strobe

    input  wire signed [`WH_DATA_W-1:0]      current_i,     // s31q24 A: i_n
    input  wire        [1:0]                 ends_i,        // it is at the high (bit 0), low end of its range
    input  wire                              contact_i,
    input  wire signed [`WH_COEF_W-1:0]      eta_contact_i, // s27q25
    input  wire signed [`WH_COEF_W-1:0]      eta_free_i,    // s27q25
    input  wire        [1:0]                 shape_mode_i,
    input  wire        [SHAPE_BITS-1:0]      shape_words_i,
    input  wire signed [`WH_COEF_W-1:0]      a_i,           // s27q25
    input  wire        [DELAY_LOG2-1:0]      extra_ticks_i,
    input  wire        [DELAY_LOG2-1:0]      hold_ticks_i,

    input  wire signed [`WH_COEF_W-1:0]      root_i,        // s27q22 √Ω: s
    input  wire signed [`WH_DATA_W-1:0]      u_max_i,       // s31q23 √W

    input  wire signed [`WH_COUNT_W-1:0]     position_i,    // s32, counts
    input  wire        [`WH_ANCHOR_W-1:0]    anchor_words_i,

    output wire signed [`WH_DATA_W-1:0]      voltage_o,     // s31q23 V: e to be applied
    output wire signed [`WH_DATA_W-1:0]      u_o,           // s31q23 √W: u_n
    output wire signed [`WH_DATA_W-1:0]      v_o,           // s31q23 √W: v_n
    output wire signed [`WH_DATA_W-1:0]      next_o,        // s31q23 V: c of the next tick
    output wire                              saturated_o,   // the limit acted in this step
    output wire                              clipped_o,     // i_n or v_n is at the end of its range
    output wire signed [`WH_DATA_W-1:0]      offset_o,      // s31q24 A
    output wire signed [`WH_DATA_W-1:0]      flux_o,        // s31q16 cells
    output wire signed [`WH_DATA_W-1:0]      lag_o,         // s31q16 cells
    output wire                              fault_o
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

    wire                     core_busy;
    wire                     core_reads;
    wire                     core_valid;
    wire                     core_overrun;
    wire                     waves;
    wire signed [DATA_W-1:0] withheld;
    wire signed [DATA_W-1:0] wave_voltage;
    wire signed [DATA_W-1:0] correction;
    wire signed [DATA_W-1:0] current;
    wire signed [DATA_W-1:0] room;
    wire                     core_request;  // of a shared multiplier
    wire        [DATA_W-1:0] core_factor;
    wire        [COEF_W-1:0] core_coefficient;
    wire                     unused = &{1'b0, core_reads, core_overrun, core_request, core_factor,
                                        core_coefficient};

    wire signed [DATA_W:0] wide_current = $signed({current_i[DATA_W-1], current_i})
                                        - $signed({offset_o[DATA_W-1], offset_o});
    wire signed [DATA_W:0] wide_voltage = $signed({wave_voltage[DATA_W-1], wave_voltage})
                                        + $signed({correction[DATA_W-1], correction});

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_current (
        .value_i (wide_current),
        .value_o (current)
    );

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_voltage (
        .value_i (wide_voltage),
        .value_o (voltage_o)
    );

    // What the anchor leaves of the limit, one word for a step.
    wire signed [DATA_W-1:0] left = u_max_i - room;
    reg  signed [DATA_W-1:0] u_max_q;

    always @(posedge clk) begin
        if (start_i) begin
            u_max_q <= left[DATA_W-1] ? {DATA_W{1'b0}} : left;
        end
    end

    // An anchor that has lost the rotor leaves a port that only damps.
    wh_wave_core #(
        .N             (1),
        .DELAY_LOG2    (DELAY_LOG2),
        .SHAPER        (SHAPER),
        .WITHHELD      (ANCHOR)
    ) core (
        .clk           (clk),
        .rst           (rst),
        .start_i       (start_i),
        .busy_o        (core_busy),
        .reads_o       (core_reads),
        .valid_o       (core_valid),
        .overrun_o     (core_overrun),
        .current_i     (current),
        .eta_i         (fault_o ? {COEF_W{1'b0}} : !contact_i ? eta_free_i : eta_contact_i),
        .outside_i     ({DATA_W{1'b0}}),
        .ends_i        (ends_i),
        .shape_mode_i  (shape_mode_i),
        .shape_words_i (shape_words_i),
        .root_i        (root_i),
        .a_i           (a_i),
        .u_max_i       (u_max_q),
        .extra_ticks_i (extra_ticks_i),
        .hold_ticks_i  (hold_ticks_i),
        .voltage_o     (wave_voltage),
        .u_o           (u_o),
        .v_o           (v_o),
        .saturated_o   (saturated_o),
        .withheld_o    (withheld),
        .clipped_o     (clipped_o),
        .waves_o       (waves),
        .request_o     (core_request),
        .factor_o      (core_factor),
        .coefficient_o (core_coefficient),
        .product_i     ({DATA_W + COEF_W{1'b0}})
    );

    generate
        if (ANCHOR == 1) begin : anchored
            wire                            anchor_busy;
            wire                            anchor_reads;
            wire                            anchor_overrun;
            wire                            request;
            wire signed [DATA_W-1:0]        factor;
            wire signed [COEF_W-1:0]        coefficient;
            wire                            grant;
            wire                            done;
            wire signed [DATA_W+COEF_W-1:0] product;
            wire                            unused_anchor = &{1'b0, anchor_reads, anchor_overrun};

            wh_multiply_shared #(
                .USERS     (1)
            ) multiply_shared (
                .clk       (clk),
                .rst       (rst),
                .drop_i    (1'b0),
                .request_i (request),
                .data_i    (factor),
                .coef_i    (coefficient),
                .grant_o   (grant),
                .done_o    (done),
                .product_o (product)
            );

            wh_anchor anchor (
                .clk           (clk),
                .rst           (rst),
                .position_i    (position_i),
                .place_i       ({(`WH_PLACE_W+`WH_SINE_Q){1'b0}}),
                .cell_i        ({(`WH_SINE_Q+2){1'b0}}),
                .contact_i     (contact_i),
                .waves_i       (waves),
                .current_i     (current),
                .u_i           (u_o),
                .v_i           (v_o),
                .withheld_i    (withheld),
                .voltage_i     (wave_voltage),
                .saturated_i   (saturated_o),
                .blind_i       (clipped_o),
                .busy_o        (anchor_busy),
                .reads_o       (anchor_reads),
                .overrun_o     (anchor_overrun),
                .words_i       (anchor_words_i),
                .request_o     (request),
                .factor_o      (factor),
                .coefficient_o (coefficient),
                .grant_i       (grant),
                .done_i        (done),
                .product_i     (product),
                .correction_o  (correction),
                .next_o        (next_o),
                .room_o        (room),
                .offset_o      (offset_o),
                .flux_o        (flux_o),
                .lag_o         (lag_o),
                .fault_o       (fault_o)
            );

            // The core may be done before the anchor, and the other way round; next_o is there a clock later.
            wire works = start_i || core_busy || anchor_busy;
            reg  works_q, ends_q;

            always @(posedge clk) begin
                works_q <= !rst && works;
                ends_q  <= !rst && works_q && !works;
            end

            assign done_o = ends_q;

            wire unused_valid = &{1'b0, core_valid};
        end else begin : plain
            wire unused_plain = &{1'b0, core_busy, waves, withheld, position_i,
                                  anchor_words_i};

            assign done_o     = core_valid;
            assign correction = {DATA_W{1'b0}};
            assign next_o     = {DATA_W{1'b0}};
            assign room       = {DATA_W{1'b0}};
            assign offset_o   = {DATA_W{1'b0}};
            assign flux_o     = {DATA_W{1'b0}};
            assign lag_o      = {DATA_W{1'b0}};
            assign fault_o    = 1'b0;
        end
    endgenerate

endmodule

`default_nettype wire
