// SPDX-License-Identifier: Apache-2.0
//
// wh_board_ecp5: all of an ECP5 board between its pads: clock, reset, the watch over the clock with its
// oscillator, registers in the pads of the converters, and wh_board_controller.
//
//   clk      = osc_i * CLKFB_DIV * CLKOP_DIV / (CLKI_DIV * CLKOS_DIV)  (wh_board_pll_ecp5 has the bounds)
//   watch    = 310 MHz / WATCH_DIV within 30 %                         (wh_board_clock_watch has them)
//
// All ports but osc_i and reset_n_i are what wh_board_controller has by these names, those of
// WH_BOARD_MORE_PORTS as well.
// Latency: that of wh_board_controller, and a clock more each way at a converter's pads.
// Reset: until the PLL has been locked, and reset_n_i high, for 2^16 clocks.

`default_nettype none
`include "wh_board_settings.vh"

module wh_board_ecp5 #(
    parameter integer CLKI_DIV  = 1,  // these are wh_board_pll_ecp5's
    parameter integer CLKFB_DIV = 1,
    parameter integer CLKOP_DIV = 18,
    parameter integer CLKOS_DIV = 5,
    parameter integer WATCH_DIV = 16, // 2...128
    parameter integer SCLK_PINS = 1   // pads of SCLK, and as many of CS_n, 1...
) (
    input  wire                   osc_i,        // the board's oscillator
    input  wire                   reset_n_i,    // asynchronous

    input  wire                   start_i,      // asynchronous
    input  wire                   stop_i,       // asynchronous

    input  wire                   uart_rx_i,    // asynchronous
    output wire                   uart_tx_o,
    `WH_BOARD_MORE_PORTS

    output wire [SCLK_PINS-1:0]   adc_cs_n_o,
    output wire [SCLK_PINS-1:0]   adc_sclk_o,
    input  wire [`WH_BOARD_N-1:0] adc_sdata_i,
    input  wire [`WH_BOARD_N-1:0] enc_a_i,      // asynchronous
    input  wire [`WH_BOARD_N-1:0] enc_b_i,      // asynchronous
    output wire [`WH_BOARD_N-1:0] gate_ah_o,
    output wire [`WH_BOARD_N-1:0] gate_al_o,
    output wire [`WH_BOARD_N-1:0] gate_bh_o,
    output wire [`WH_BOARD_N-1:0] gate_bl_o,

    output wire                   alive_o,
    output wire                   running_o,
    output wire                   contact_o,
    output wire                   fault_o
);

    localparam integer N = `WH_BOARD_N;

    wire clk;
    wire locked;
    wire rst;
    wire watch_clk;
    wire clock_lost;

    wh_board_pll_ecp5 #(
        .CLKI_DIV  (CLKI_DIV),
        .CLKFB_DIV (CLKFB_DIV),
        .CLKOP_DIV (CLKOP_DIV),
        .CLKOS_DIV (CLKOS_DIV)
    ) pll (
        .clk_i     (osc_i),
        .clk_o     (clk),
        .locked_o  (locked)
    );

    wh_board_reset board_reset (
        .clk       (clk),
        .locked_i  (locked && reset_n_i),
        .rst_o     (rst)
    );

    wh_board_oscillator_ecp5 #(
        .DIV       (WATCH_DIV)
    ) oscillator (
        .clk_o     (watch_clk)
    );

    wire [N-1:0]     gate_ah;
    wire [N-1:0]     gate_al;
    wire [N-1:0] gate_bh;
    wire [N-1:0] gate_bl;

    wh_board_clock_watch #(
        .GATES     (4 * N)
    ) clock_watch (
        .clk       (clk),
        .rst       (rst),
        .watch_clk (watch_clk),
        .gates_i   ({gate_ah, gate_al, gate_bh, gate_bl}),
        .gates_o   ({gate_ah_o, gate_al_o, gate_bh_o, gate_bl_o}),
        .lost_o    (clock_lost)
    );

    wire             adc_cs_n;
    wire             adc_sclk;
    wire [N-1:0] adc_sdata;

    wh_board_adc_pads_ecp5 #(
        .LINES       (N),
        .CLOCKS      (SCLK_PINS)
    ) adc_pads (
        .clk         (clk),
        .cs_n_i      (adc_cs_n),
        .sclk_i      (adc_sclk),
        .sdata_o     (adc_sdata),
        .adc_cs_n_o  (adc_cs_n_o),
        .adc_sclk_o  (adc_sclk_o),
        .adc_sdata_i (adc_sdata_i)
    );

    wh_board_controller board_controller (
        .clk          (clk),
        .rst          (rst),
        .start_i      (start_i),
        .stop_i       (stop_i),
        .clock_lost_i (clock_lost),
        .uart_rx_i    (uart_rx_i),
        .uart_tx_o    (uart_tx_o),
        `WH_BOARD_MORE_PINS
        .adc_cs_n_o   (adc_cs_n),
        .adc_sclk_o   (adc_sclk),
        .adc_sdata_i  (adc_sdata),
        .enc_a_i      (enc_a_i),
        .enc_b_i      (enc_b_i),
        .gate_ah_o    (gate_ah),
        .gate_al_o    (gate_al),
        .gate_bh_o    (gate_bh),
        .gate_bl_o    (gate_bl),
        .alive_o      (alive_o),
        .running_o    (running_o),
        .contact_o    (contact_o),
        .fault_o      (fault_o)
    );

endmodule

`default_nettype wire
