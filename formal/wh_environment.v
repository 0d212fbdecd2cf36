// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_environment: a port has one environment at a time, and none that a fault has taken away.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_environment (
    input wire                         clk,
    input wire                         rst,
    input wire                         damps,
    input wire                         contact,
    input wire                         shaped,
    input wire signed [`WH_COEF_W-1:0] eta,
    input wire                         valid,
    input wire        [`WH_DATA_W-1:0] v,
    input wire                         answer,
    input wire        [7:0]            sequence_of,
    input wire        [`WH_DATA_W-1:0] u
);

    (* anyconst *) wire [3:0] period_log2;
    (* anyconst *) wire [7:0] timeout;

    wire                  strobe;
    wire [7:0]            sequence;
    wire [`WH_DATA_W-1:0] v_mean;
    wire                  active;
    wire [`WH_COEF_W-1:0] eta_out;
    wire [`WH_DATA_W-1:0] wave;
    wire [1:0]            mode;

    wh_environment #(
        .HOST               (1)
    ) block (
        .clk                (clk),
        .rst                (rst),
        .damps_i            (damps),
        .contact_i          (contact),
        .shaped_i           (shaped),
        .eta_i              (eta),
        .host_period_log2_i (period_log2),
        .host_timeout_i     (timeout),
        .valid_i            (valid),
        .v_i                (v),
        .host_strobe_i      (answer),
        .host_sequence_i    (sequence_of),
        .host_u_i           (u),
        .host_strobe_o      (strobe),
        .host_sequence_o    (sequence),
        .host_v_o           (v_mean),
        .host_active_o      (active),
        .eta_o              (eta_out),
        .wave_o             (wave),
        .mode_o             (mode)
    );

    always @(posedge clk) begin
        // Never what v makes and what a host wants at once: each alone is passive, their sum isn't.
        assert (eta_out == 0 || wave == 0);
        if (damps) assert (eta_out == 0 && wave == 0);
        if (!damps && !active) assert (eta_out == eta && wave == 0);
        if (active) assert (eta_out == 0);
        // W moves in a shaped wall only, and begins at rest whenever there is none.
        assert (mode != 2'd3);
        if (mode != 2'd0) assert (contact && !active);
        if (mode == 2'd2) assert (shaped);
        if (!contact) assert (mode == 2'd0);
        cover (active && wave != 0);
        cover (mode == 2'd1);
        cover (mode == 2'd2 && eta_out != 0);
    end

endmodule

`default_nettype wire
