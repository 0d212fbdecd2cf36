// SPDX-License-Identifier: Apache-2.0
//
// wh_environment: what one port's waves come back from, as three words for the wave core.
//
//   w = eta_o v + wave_o, shaped as mode_o says
//
//   in a wall          eta of contact, W as the wall wants it: mode 2 it shapes, 1 it stands still
//   in free space      eta of free space, mode 0: W begins at rest
//   a host has it      eta 0, its goal (wh_host_link), HOST = 1
//   damps_i            eta 0 and wave 0: the port takes in all that comes
//
// Whatever another environment would be, it gives these words of a step before that step begins.
// Formats: eta s27q25 in [-1, 1]; waves s31q23 √W.
// Latency: none but that of wh_host_link. Reset: that of wh_host_link.

`default_nettype none
`include "wh_formats.vh"

module wh_environment #(
    parameter integer HOST = 0  // 1: a computer can have it
) (
    input  wire                         clk,
    input  wire                         rst,
    input  wire                         damps_i,

    // What the encoder says (wh_contact).
    input  wire                         contact_i,
    input  wire                         shaped_i,
    input  wire signed [`WH_COEF_W-1:0] eta_i,

    // A host's (wh_host_link).
    input  wire [3:0]                   host_period_log2_i,
    input  wire [7:0]                   host_timeout_i,
    input  wire                         valid_i,         // strobe, v_i is new
    input  wire [`WH_DATA_W-1:0]        v_i,
    input  wire                         host_strobe_i,
    input  wire [7:0]                   host_sequence_i,
    input  wire [`WH_DATA_W-1:0]        host_u_i,
    output wire                         host_strobe_o,
    output wire [7:0]                   host_sequence_o,
    output wire [`WH_DATA_W-1:0]        host_v_o,
    output wire                         host_active_o,

    output wire [`WH_COEF_W-1:0]        eta_o,
    output wire [`WH_DATA_W-1:0]        wave_o,
    output wire [1:0]                   mode_o           // of wh_wave_core's shape_mode_i
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

    wire signed [DATA_W-1:0] goal;

    generate
        if (HOST != 0 && HOST != 1) begin : illegal_host
            wh_illegal_parameter_environment_host_must_be_0_or_1 stop ();
        end

        if (HOST == 1) begin : hosted
            wh_host_link host_link (
                .clk           (clk),
                .rst           (rst),
                .period_log2_i (host_period_log2_i),
                .timeout_i     (host_timeout_i),
                .valid_i       (valid_i),
                .v_i           (v_i),
                .active_o      (host_active_o),
                .u_o           (goal),
                .strobe_o      (host_strobe_o),
                .sequence_o    (host_sequence_o),
                .v_mean_o      (host_v_o),
                .strobe_i      (host_strobe_i),
                .sequence_i    (host_sequence_i),
                .u_i           (host_u_i)
            );
        end else begin : alone
            wire unused = &{1'b0, clk, rst, host_period_log2_i, host_timeout_i, valid_i, v_i,
                            host_strobe_i, host_sequence_i, host_u_i};

            assign goal            = {DATA_W{1'b0}};
            assign host_active_o   = 1'b0;
            assign host_strobe_o   = 1'b0;
            assign host_sequence_o = 8'd0;
            assign host_v_o        = {DATA_W{1'b0}};
        end
    endgenerate

    // While a host has it v is the host's, and W may not keep a part of it.
    assign mode_o = (!contact_i || host_active_o) ? 2'd0 : shaped_i ? 2'd2 : 2'd1;
    assign wave_o = (host_active_o && !damps_i) ? goal : {DATA_W{1'b0}};
    assign eta_o  = (host_active_o || damps_i) ? {COEF_W{1'b0}} : eta_i;

endmodule

`default_nettype wire
