// SPDX-License-Identifier: Apache-2.0
//
// ecp5_evn: the wave controller on an ECP5 Evaluation Board: pads, PLL, oscillator and reset.
//
// The clock is 72 MHz, a tenth of the VCO's 12 MHz * 60. README.md has the wiring.
// Reset: until the PLL has been locked, and the board's button for it up, for 2^16 clocks.

`default_nettype none
`include "wh_board_settings.vh"

module ecp5_evn (
    input  wire clk_12mhz,

    output wire adc_cs_n,
    output wire adc_sclk,
    input  wire adc_sdata,
    input  wire enc_a,
    input  wire enc_b,
    output wire gate_ah,
    output wire gate_al,
    output wire gate_bh,
    output wire gate_bl,
    output wire alive,

    input  wire uart_rx,       // serial adapter, 115,200 bits a second at first
    output wire uart_tx,
    input  wire button_reset_n,
    input  wire button_start_n,
    input  wire stop,          // open, so high, is stop
    output wire led_running_n,
    output wire led_contact_n,
    output wire led_fault_n
);

    wire clk;
    wire locked;

    wh_board_pll_ecp5 #(
        .CLKI_DIV  (1),
        .CLKFB_DIV (1),
        .CLKOP_DIV (60),
        .CLKOS_DIV (10)
    ) pll (
        .clk_i     (clk_12mhz),
        .clk_o     (clk),
        .locked_o  (locked)
    );

    wire rst;
    wire running;
    wire contact;
    wire fault;

    wh_board_reset board_reset (
        .clk      (clk),
        .locked_i (locked && button_reset_n),
        .rst_o    (rst)
    );

    wire watch_clk;
    wire clock_lost;

    // 19.4 MHz.
    wh_board_oscillator_ecp5 #(
        .DIV   (16)
    ) oscillator (
        .clk_o (watch_clk)
    );

    wire bridge_ah;
    wire bridge_al;
    wire bridge_bh;
    wire bridge_bl;

    wh_board_clock_watch #(
        .GATES     (4)
    ) clock_watch (
        .clk       (clk),
        .rst       (rst),
        .watch_clk (watch_clk),
        .gates_i   ({bridge_ah, bridge_al, bridge_bh, bridge_bl}),
        .gates_o   ({gate_ah, gate_al, gate_bh, gate_bl}),
        .lost_o    (clock_lost)
    );

    wire reader_cs_n;
    wire reader_sclk;
    wire reader_sdata;

    wh_board_adc_pads_ecp5 #(
        .LINES       (1)
    ) adc_pads (
        .clk         (clk),
        .cs_n_i      (reader_cs_n),
        .sclk_i      (reader_sclk),
        .sdata_o     (reader_sdata),
        .adc_cs_n_o  (adc_cs_n),
        .adc_sclk_o  (adc_sclk),
        .adc_sdata_i (adc_sdata)
    );

    wh_board_controller board_controller (
        .clk          (clk),
        .rst          (rst),
        .start_i      (!button_start_n),
        .stop_i       (stop),
        .clock_lost_i (clock_lost),
        .uart_rx_i    (uart_rx),
        .uart_tx_o    (uart_tx),
        .adc_cs_n_o   (reader_cs_n),
        .adc_sclk_o   (reader_sclk),
        .adc_sdata_i  (reader_sdata),
        .enc_a_i      (enc_a),
        .enc_b_i      (enc_b),
        .gate_ah_o    (bridge_ah),
        .gate_al_o    (bridge_al),
        .gate_bh_o    (bridge_bh),
        .gate_bl_o    (bridge_bl),
        .alive_o      (alive),
        .running_o    (running),
        .contact_o    (contact),
        .fault_o      (fault)
    );

    assign led_running_n = !running;
    assign led_contact_n = !contact;
    assign led_fault_n   = !fault;

endmodule

`default_nettype wire
