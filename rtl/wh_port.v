// SPDX-License-Identifier: Apache-2.0
//
// wh_port: what one port has of its own beside the wave core that all share.
//
//   contact, a host's answers -> wh_environment -> eta, wave, mode -> wave core
//   the core's waves, position -> wh_anchor -> correction, the limit that it leaves the waves
//   e_id + correction -> voltage
//   current, position, contact -> wh_energy -> what a contact of its own walls delivers
//
// Formats: those of the blocks.
// Latency: the voltage follows the core's in the same clock, driven_* a clock later with ANCHOR = 1:
// the sum and what chooses the multiplier's user are too much for one.
// Reset: rst and run_i = 0 alike; damp_i resets anchor and host.

`default_nettype none
`include "wh_formats.vh"

module wh_port #(
    parameter integer HOST   = 0,  // these are wh_controller's
    parameter integer ANCHOR = 0
) (
    input  wire                              clk,
    input  wire                              rst,
    input  wire                              run_i,
    input  wire                              damp_i,             // the guard wants a damper

    // The step of the wave core.
    input  wire                              core_start_i,
    input  wire                              core_valid_i,
    input  wire                              waves_i,            // strobe, this port's waves are new
    input  wire                              clipped_i,          // current or v at the end of its range
    input  wire signed [`WH_DATA_W-1:0]      current_i,
    input  wire signed [`WH_DATA_W-1:0]      u_i,
    input  wire signed [`WH_DATA_W-1:0]      v_i,
    input  wire signed [`WH_DATA_W-1:0]      withheld_i,
    input  wire signed [`WH_DATA_W-1:0]      wave_voltage_i,     // e_id
    input  wire                              saturated_i,
    input  wire signed [`WH_DATA_W-1:0]      u_max_i,            // what the bus allows
    output wire signed [`WH_DATA_W-1:0]      step_max_o,         // what a step's waves may have of it
    output wire signed [`WH_COEF_W-1:0]      eta_o,
    output wire signed [`WH_DATA_W-1:0]      wave_o,
    output wire [1:0]                        shape_mode_o,

    // Position and contact (wh_motor).
    input  wire signed [`WH_COUNT_W-1:0]     position_i,
    input  wire                              contact_i,
    input  wire                              shaped_i,
    input  wire signed [`WH_COEF_W-1:0]      contact_eta_i,

    // A host (wh_host_link).
    input  wire [3:0]                        host_period_log2_i,
    input  wire [7:0]                        host_timeout_i,
    input  wire                              host_strobe_i,
    input  wire [7:0]                        host_sequence_i,
    input  wire signed [`WH_DATA_W-1:0]      host_u_i,
    output wire                              host_strobe_o,
    output wire [7:0]                        host_sequence_o,
    output wire signed [`WH_DATA_W-1:0]      host_v_o,
    output wire                              host_active_o,

    // What a contact delivers (wh_energy).
    input  wire [`WH_ENERGY_LIMIT_W-1:0]     energy_limit_i,
    output wire signed [`WH_ENERGY_W-1:0]    energy_o,
    output wire signed [`WH_ENERGY_W-1:0]    energy_peak_o,
    output wire                              energy_over_o,
    output reg                               limited_o,          // the limit acts in contact with its walls

    // The voltage, and what an anchor makes of it.
    input  wire [`WH_ANCHOR_W-1:0]           anchor_words_i,
    output wire                              driven_valid_o,     // strobe
    output wire signed [`WH_DATA_W-1:0]      driven_o,           // s31q23 V, to the drive
    output wire signed [`WH_DATA_W-1:0]      voltage_o,          // the same, with core_valid_i
    output wire signed [`WH_DATA_W-1:0]      correction_o,
    output wire signed [`WH_DATA_W-1:0]      offset_o,
    output wire signed [`WH_DATA_W-1:0]      flux_o,
    output wire signed [`WH_DATA_W-1:0]      lag_o,
    output wire                              anchor_reads_o,     // its words
    output wire                              anchor_overrun_o,
    output wire                              anchor_fault_o,

    // The shared multiplier, for the anchor.
    output wire                              request_o,
    output wire signed [`WH_DATA_W-1:0]      factor_o,
    output wire signed [`WH_COEF_W-1:0]      coefficient_o,
    input  wire                              grant_i,
    input  wire                              done_i,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

    generate
        if (ANCHOR != 0 && ANCHOR != 1) begin : illegal_anchor
            wh_illegal_parameter_port_anchor_must_be_0_or_1 stop ();
        end
    endgenerate

    wire drive_rst = rst || !run_i;
    wire calm_rst  = drive_rst || damp_i;

    // ---- Environment. An anchor that has lost the rotor leaves a port that only damps.

    wh_environment #(
        .HOST               (HOST)
    ) environment (
        .clk                (clk),
        .rst                (calm_rst),
        .damps_i            (damp_i || anchor_fault_o),
        .contact_i          (contact_i),
        .shaped_i           (shaped_i),
        .eta_i              (contact_eta_i),
        .host_period_log2_i (host_period_log2_i),
        .host_timeout_i     (host_timeout_i),
        .valid_i            (core_valid_i),
        .v_i                (v_i),
        .host_strobe_i      (host_strobe_i),
        .host_sequence_i    (host_sequence_i),
        .host_u_i           (host_u_i),
        .host_strobe_o      (host_strobe_o),
        .host_sequence_o    (host_sequence_o),
        .host_v_o           (host_v_o),
        .host_active_o      (host_active_o),
        .eta_o              (eta_o),
        .wave_o             (wave_o),
        .mode_o             (shape_mode_o)
    );

    // ---- The position that belongs to the contact, until the port's turn: anchor and observer may still be
    // at the step before when the core starts.

    reg [`WH_COUNT_W-1:0] position_q;

    always @(posedge clk) begin
        if (core_start_i) begin
            position_q <= position_i;
        end
    end

    // ---- Energy. What a host's environment delivers is the host's.

    wh_energy energy (
        .clk        (clk),
        .rst        (rst),
        .run_i      (run_i),
        .start_i    (waves_i),
        .contact_i  (contact_i && !host_active_o),
        .position_i (position_q[`WH_MOVE_W-1:0]),
        .current_i  (current_i),
        .limit_i    (energy_limit_i),
        .energy_o   (energy_o),
        .peak_o     (energy_peak_o),
        .over_o     (energy_over_o)
    );

    always @(posedge clk) begin
        if (drive_rst) begin
            limited_o <= 1'b0;
        end else if (waves_i) begin
            limited_o <= saturated_i && contact_i && !host_active_o;
        end
    end

    // ---- Port anchor.

    generate
        if (ANCHOR != 0) begin : anchored
            wire signed [DATA_W:0] wide_voltage =
                $signed({wave_voltage_i[DATA_W-1], wave_voltage_i})
                + $signed({correction_o[DATA_W-1], correction_o});

            wh_saturate #(
                .IN_W    (DATA_W + 1),
                .OUT_W   (DATA_W)
            ) saturate_voltage (
                .value_i (wide_voltage),
                .value_o (voltage_o)
            );

            reg                     driven_valid_q;
            reg signed [DATA_W-1:0] driven_q;

            assign driven_valid_o = driven_valid_q;
            assign driven_o       = driven_q;

            always @(posedge clk) begin
                driven_valid_q <= core_valid_i && !drive_rst;
                driven_q       <= voltage_o;
            end

            // One limit for a step, which takes room from the next one; c may want more than there is, and a
            // limit below 0 would be a source.
            reg  [DATA_W-1:0]        step_max_q;
            wire signed [DATA_W-1:0] room;
            wire signed [DATA_W-1:0] left = u_max_i - room;

            assign step_max_o = step_max_q;

            always @(posedge clk) begin
                if (core_start_i) begin
                    step_max_q <= left[DATA_W-1] ? {DATA_W{1'b0}} : left;
                end
            end

            wire              anchor_busy;
            wire [DATA_W-1:0] next_correction;
            wire              unused_anchor = &{1'b0, anchor_busy, next_correction};

            // A host's environment counts as contact: its current may be what it likes.
            wh_anchor anchor (
                .clk           (clk),
                .rst           (calm_rst),
                .position_i    (position_q),
                .place_i       ({(`WH_PLACE_W+`WH_SINE_Q){1'b0}}),
                .cell_i        ({(`WH_SINE_Q+2){1'b0}}),
                .contact_i     (contact_i || host_active_o),
                .waves_i       (waves_i),
                .current_i     (current_i),
                .u_i           (u_i),
                .v_i           (v_i),
                .withheld_i    (withheld_i),
                .voltage_i     (wave_voltage_i),
                .saturated_i   (saturated_i),
                .blind_i       (clipped_i),
                .busy_o        (anchor_busy),
                .reads_o       (anchor_reads_o),
                .overrun_o     (anchor_overrun_o),
                .words_i       (anchor_words_i),
                .request_o     (request_o),
                .factor_o      (factor_o),
                .coefficient_o (coefficient_o),
                .grant_i       (grant_i),
                .done_i        (done_i),
                .product_i     (product_i),
                .correction_o  (correction_o),
                .next_o        (next_correction),
                .room_o        (room),
                .offset_o      (offset_o),
                .flux_o        (flux_o),
                .lag_o         (lag_o),
                .fault_o       (anchor_fault_o)
            );
        end else begin : by_its_waves_alone
            wire unused_anchor = &{1'b0, position_q[`WH_COUNT_W-1:`WH_MOVE_W], u_i, withheld_i,
                                   clipped_i, anchor_words_i, grant_i, done_i, product_i};

            assign driven_valid_o   = core_valid_i;
            assign driven_o         = wave_voltage_i;
            assign voltage_o        = wave_voltage_i;
            assign correction_o     = {DATA_W{1'b0}};
            assign offset_o         = {DATA_W{1'b0}};
            assign flux_o           = {DATA_W{1'b0}};
            assign lag_o            = {DATA_W{1'b0}};
            assign step_max_o       = u_max_i;
            assign anchor_reads_o   = 1'b0;
            assign anchor_overrun_o = 1'b0;
            assign anchor_fault_o   = 1'b0;
            assign request_o        = 1'b0;
            assign factor_o         = {DATA_W{1'b0}};
            assign coefficient_o    = {COEF_W{1'b0}};
        end
    endgenerate

endmodule

`default_nettype wire
