// SPDX-License-Identifier: Apache-2.0
//
// wh_pwm, as a proof of the gates behind it sees it: any levels in any clock.

`default_nettype none
`include "wh_formats.vh"

module wh_pwm #(
    parameter integer MODES = 0
) (
    input  wire                         clk,
    input  wire                         rst,
    input  wire        [`WH_MODE_W-1:0] mode_i,
    input  wire        [`WH_TICK_W-1:0] half_clocks_i,
    input  wire        [`WH_TICK_W-1:0] phase_i,
    input  wire        [`WH_TICK_W-1:0] remaining_i,
    input  wire                         half_i,
    input  wire                         update_i,
    input  wire signed [`WH_TICK_W-1:0] width_i,
    output wire                         leg_a_o,
    output wire                         leg_b_o
);

    (* anyseq *) wire leg_a;
    (* anyseq *) wire leg_b;

    assign leg_a_o = leg_a;
    assign leg_b_o = leg_b;

    wire unused = &{1'b0, clk, rst, mode_i, half_clocks_i, phase_i, remaining_i, half_i, update_i,
                    width_i, MODES[0]};

endmodule

`default_nettype wire
