// SPDX-License-Identifier: Apache-2.0
//
// wh_core_port: the wave core of one port, numbers in and numbers out; the contact chooses η.
//
// This is also where the port anchor stands beside the core, once there is one.
// Latency and reset: the core's.

`default_nettype none
`include "wh_formats.vh"

module wh_core_port #(
    parameter integer DELAY_LOG2 = 2,  // the delay line keeps 2^DELAY_LOG2 steps, 1...
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
    input  wire signed [`WH_COEF_W-1:0]      eta_contact_i, // s27q25
    input  wire signed [`WH_COEF_W-1:0]      eta_free_i,    // s27q25
    input  wire        [1:0]                 shape_mode_i,
    input  wire        [SHAPE_BITS-1:0]      shape_words_i,
    input  wire signed [`WH_COEF_W-1:0]      a_i,           // s27q25
    input  wire        [DELAY_LOG2-1:0]      extra_ticks_i,
    input  wire        [DELAY_LOG2-1:0]      hold_ticks_i,

    input  wire signed [`WH_COEF_W-1:0]      root_i,        // s27q22 √Ω: s
    input  wire signed [`WH_DATA_W-1:0]      u_max_i,       // s31q23 √W

    output wire signed [`WH_DATA_W-1:0]      voltage_o,     // s31q23 V: e to be applied
    output wire signed [`WH_DATA_W-1:0]      u_o,           // s31q23 √W: u_n
    output wire signed [`WH_DATA_W-1:0]      v_o            // s31q23 √W: v_n
);

    localparam integer DATA_W = `WH_DATA_W;

    wire              busy;
    wire              overrun;
    wire              saturated;
    wire [DATA_W-1:0] newest_u;
    wire [DATA_W-1:0] next_u;
    wire              unused = &{1'b0, busy, overrun, saturated, newest_u, next_u};

    wh_wave_core #(
        .N             (1),
        .DELAY_LOG2    (DELAY_LOG2),
        .SHAPER        (SHAPER)
    ) core (
        .clk           (clk),
        .rst           (rst),
        .start_i       (start_i),
        .busy_o        (busy),
        .valid_o       (done_o),
        .overrun_o     (overrun),
        .current_i     (current_i),
        .eta_i         (contact_i ? eta_contact_i : eta_free_i),
        .outside_i     ({DATA_W{1'b0}}),
        .shape_mode_i  (shape_mode_i),
        .shape_words_i (shape_words_i),
        .root_i        (root_i),
        .a_i           (a_i),
        .u_max_i       (u_max_i),
        .extra_ticks_i (extra_ticks_i),
        .hold_ticks_i  (hold_ticks_i),
        .voltage_o     (voltage_o),
        .u_o           (u_o),
        .v_o           (v_o),
        .saturated_o   (saturated),
        .newest_u_o    (newest_u),
        .next_u_o      (next_u)
    );

endmodule

`default_nettype wire
