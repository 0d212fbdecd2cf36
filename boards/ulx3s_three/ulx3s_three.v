// SPDX-License-Identifier: Apache-2.0
//
// ulx3s_three: three motors on a ULX3S (ECP5): pads, PLL, oscillator and reset.
//
// The clock is 60 MHz, a tenth of the VCO's 25 MHz * 24. README.md has the wiring.
// Reset: until the PLL has been locked for 2^16 clocks.

`default_nettype none
`include "wh_board_settings.vh"

module ulx3s_three (
    input  wire       clk_25mhz,

    output wire       adc_cs_n,
    output wire       adc_sclk,
    input  wire [2:0] adc_sdata,
    input  wire [2:0] enc_a,
    input  wire [2:0] enc_b,
    output wire [2:0] gate_ah,
    output wire [2:0] gate_al,
    output wire [2:0] gate_bh,
    output wire [2:0] gate_bl,
    output wire       alive,

    input  wire       uart_rx,       // USB serial, 115,200 bits a second at first
    output wire       uart_tx,
    input  wire       button_start,
    input  wire       stop,          // open, so high, is stop
    output wire       led_running,
    output wire       led_contact,
    output wire       led_fault,
    output wire       wifi_en          // low: the ESP32 is in reset
);

    // It shares header pins with the FPGA, and may have firmware of its own.
    assign wifi_en = 1'b0;

    wire clk;
    wire locked;

    wh_board_pll_ecp5 #(
        .CLKI_DIV  (1),
        .CLKFB_DIV (1),
        .CLKOP_DIV (24),
        .CLKOS_DIV (10)
    ) pll (
        .clk_i     (clk_25mhz),
        .clk_o     (clk),
        .locked_o  (locked)
    );

    wire rst;

    wh_board_reset board_reset (
        .clk      (clk),
        .locked_i (locked),
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

    wire [2:0] bridge_ah;
    wire [2:0] bridge_al;
    wire [2:0] bridge_bh;
    wire [2:0] bridge_bl;

    wh_board_clock_watch #(
        .GATES     (12)
    ) clock_watch (
        .clk       (clk),
        .rst       (rst),
        .watch_clk (watch_clk),
        .gates_i   ({bridge_ah, bridge_al, bridge_bh, bridge_bl}),
        .gates_o   ({gate_ah, gate_al, gate_bh, gate_bl}),
        .lost_o    (clock_lost)
    );

    wire       reader_cs_n;
    wire       reader_sclk;
    wire [2:0] reader_sdata;

    wh_board_adc_pads_ecp5 #(
        .LINES       (3)
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
        .start_i      (button_start),
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
        .running_o    (led_running),
        .contact_o    (led_contact),
        .fault_o      (led_fault)
    );

endmodule

`default_nettype wire
