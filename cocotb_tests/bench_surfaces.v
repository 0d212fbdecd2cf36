// SPDX-License-Identifier: Apache-2.0
//
// bench_surfaces: wh_surfaces with its words.

`default_nettype none
`timescale 1ns / 1ps
`include "wh_formats.vh"

module bench_surfaces #(
    parameter integer PORTS    = 3,
    parameter integer SURFACES = 8
) (
    input  wire                          clk,
    input  wire                          rst,

    input  wire                          write_i,
    input  wire [9:0]                    address_i,
    input  wire [31:0]                   data_i,
    input  wire                          commit_i,
    output wire                          busy_o,
    output wire                          refused_o,
    output wire [6:0]                    refused_row_o,

    input  wire                          valid_i,
    input  wire [1:0]                    port_i,
    input  wire signed [`WH_COUNT_W-1:0] position_i,
    input  wire signed [`WH_DATA_W-1:0]  current_i,
    input  wire signed [`WH_DATA_W-1:0]  wave_i,
    input  wire signed [`WH_COEF_W-1:0]  free_i,
    input  wire [61:0]                   budget_i,
    output wire                          valid_o,
    output wire [1:0]                    port_o,
    output wire signed [`WH_DATA_W-1:0]  wave_o,
    output wire [1:0]                    acting_o
);

    wire        take;
    wire        round_busy;
    wire        unused = &{1'b0, round_busy};
    wire [6:0]  row;
    wire [2:0]  word;
    wire [31:0] data;
    wire [7:0]  present;

    wh_surface_words words (
        .clk       (clk),
        .rst       (rst),
        .write_i   (write_i),
        .address_i (address_i),
        .data_i    (data_i),
        .commit_i  (commit_i),
        .busy_o    (busy_o),
        .refused_o (refused_o),
        .refused_row_o (refused_row_o),
        .take_i    (take),
        .row_i     (row),
        .word_i    (word),
        .word_o    (data),
        .present_o (present)
    );

    wh_surfaces #(
        .PORTS      (PORTS),
        .SURFACES   (SURFACES)
    ) surfaces (
        .clk        (clk),
        .rst        (rst),
        .valid_i    (valid_i),
        .port_i     (port_i),
        .position_i (position_i),
        .current_i  (current_i),
        .wave_i     (wave_i),
        .free_i     (free_i),
        .budget_i   (budget_i),
        .take_o     (take),
        .row_o      (row),
        .word_o     (word),
        .word_i     (data),
        .present_i  (present),
        .busy_o     (round_busy),
        .valid_o    (valid_o),
        .port_o     (port_o),
        .wave_o     (wave_o),
        .acting_o   (acting_o)
    );

endmodule

`default_nettype wire
