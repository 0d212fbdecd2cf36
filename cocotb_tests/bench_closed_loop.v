// SPDX-License-Identifier: Apache-2.0
//
// bench_closed_loop: wh_controller with a clock, settings to write to, and the ADC's shift register.
//
// The settings are registers by their ports' names, WH_BENCH_WIRES of wh_bench_words.vh, which the
// test makes of the table of words.
//
// The test loads shift when CS_n falls; the bits go out as an AD7276-like part sends them: a first
// lead bit with the fall of CS_n, the next bit after each fall of SCLK.

`timescale 1ns / 1ps
`default_nettype none
`include "wh_bench_words.vh"

module bench_closed_loop #(
    parameter integer CLOCK_PS = 20832  // even, so that a half is whole
) ();

    reg clk = 1'b0;
    always #(CLOCK_PS / 2000.0) clk = !clk;

    // Clocks since reset was released; the gates of clock n hold from edge n to edge n + 1.
    reg         rst = 1'b1;
    reg         enable = 1'b0;
    reg  [63:0] now = 64'd0;
    always @(posedge clk) now <= rst ? 64'd0 : now + 64'd1;

    reg         enc_a = 1'b0;
    reg         enc_b = 1'b0;
    reg  [31:0] shift = 32'd0;  // highest bit on the wire

    wire        cs_n;
    wire        sclk;
    wire [3:0]  gates;          // BL BH AL AH

    always @(negedge sclk) shift <= shift << 1;

    `WH_BENCH_WIRES

    wh_controller controller (
        .clk(clk), .rst(rst), .enable_i(enable),
        .adc_cs_n_o(cs_n), .adc_sclk_o(sclk), .adc_din_o(), .adc_sdata_i(shift[31]),
        .scale_hold_o(), .anchor_hold_o(),
        .enc_a_i(enc_a), .enc_b_i(enc_b),
        .gate_ah_o(gates[0]), .gate_al_o(gates[1]), .gate_bh_o(gates[2]), .gate_bl_o(gates[3]),
        `WH_BENCH_PORTS
        .stop_i(1'b0), .driver_fault_i(1'b0), .anchor_fault_i(1'b0)
    );

endmodule

`default_nettype wire
