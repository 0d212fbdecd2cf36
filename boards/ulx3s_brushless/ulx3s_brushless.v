// SPDX-License-Identifier: Apache-2.0
//
// ulx3s_brushless: a brushless motor on a ULX3S (ECP5): pads, PLL, oscillator and reset.
//
// The clock is 37.5 MHz, a sixteenth of the VCO's 25 MHz * 24. README.md has the wiring.
// Reset: until the PLL has been locked for 2^16 clocks.

`default_nettype none
`include "wh_board_settings.vh"

module ulx3s_brushless (
    input  wire       clk_25mhz,

    output wire       adc_cs_n,
    output wire       adc_sclk,
    input  wire [1:0] adc_sdata,       // phase a lowest
    input  wire       enc_a,
    input  wire       enc_b,
    output wire       gate_ah,
    output wire       gate_al,
    output wire       gate_bh,
    output wire       gate_bl,
    output wire       gate_ch,
    output wire       gate_cl,
    output wire       alive,

    input  wire       uart_rx,         // USB serial, 115,200 bits a second at first
    output wire       uart_tx,
    input  wire       button_start,
    input  wire       stop,            // open, so high, is stop
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
        .CLKOS_DIV (16)
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

    // 11.1 MHz: a beat of the slower clock lasts longer.
    wh_board_oscillator_ecp5 #(
        .DIV (28)
    ) oscillator (
        .clk_o (watch_clk)
    );

    wire [2:0] bridge_high;
    wire [2:0] bridge_low;

    wh_board_clock_watch #(
        .GATES     (6)
    ) clock_watch (
        .clk       (clk),
        .rst       (rst),
        .watch_clk (watch_clk),
        .gates_i   ({bridge_high, bridge_low}),
        .gates_o   ({gate_ch, gate_bh, gate_ah, gate_cl, gate_bl, gate_al}),
        .lost_o    (clock_lost)
    );

    wire       reader_cs_n;
    wire       reader_sclk;
    wire [1:0] reader_sdata;

    wh_board_adc_pads_ecp5 #(
        .LINES       (2)
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
        .gate_ah_o    (bridge_high[0]),
        .gate_al_o    (bridge_low[0]),
        .gate_bh_o    (bridge_high[2:1]),
        .gate_bl_o    (bridge_low[2:1]),
        .alive_o      (alive),
        .running_o    (led_running),
        .contact_o    (led_contact),
        .fault_o      (led_fault)
    );

endmodule

`default_nettype wire
