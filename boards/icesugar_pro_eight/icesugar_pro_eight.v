// SPDX-License-Identifier: Apache-2.0
//
// icesugar_pro_eight: eight motors on an iCESugar-pro (ECP5): its pads.
//
// The clock is 66.67 MHz, a ninth of the VCO's 25 MHz * 24. README.md has the wiring.
// Reset: until the PLL has been locked for 2^16 clocks.

`default_nettype none

module icesugar_pro_eight (
    input  wire       clk_25mhz,

    output wire [3:0] adc_cs_n,      // one of each for the two motors of a header
    output wire [3:0] adc_sclk,
    input  wire [7:0] adc_sdata,
    input  wire [7:0] enc_a,
    input  wire [7:0] enc_b,
    output wire [7:0] gate_ah,
    output wire [7:0] gate_al,
    output wire [7:0] gate_bh,
    output wire [7:0] gate_bl,
    output wire       alive,

    input  wire       uart_rx,       // USB serial, 115,200 bits a second at first
    output wire       uart_tx,
    input  wire       start_n,
    input  wire       stop,          // open, so high, is stop
    output wire       led_running_n,
    output wire       led_contact_n,
    output wire       led_fault_n
);

    wire running;
    wire contact;
    wire fault;

    // The watch has 19.4 MHz.
    wh_board_ecp5 #(
        .CLKOP_DIV  (24),
        .CLKOS_DIV  (9),
        .WATCH_DIV  (16),
        .SCLK_PINS  (4)
    ) board (
        .osc_i       (clk_25mhz),
        .reset_n_i   (1'b1),
        .start_i     (!start_n),
        .stop_i      (stop),
        .uart_rx_i   (uart_rx),
        .uart_tx_o   (uart_tx),
        .adc_cs_n_o  (adc_cs_n),
        .adc_sclk_o  (adc_sclk),
        .adc_sdata_i (adc_sdata),
        .enc_a_i     (enc_a),
        .enc_b_i     (enc_b),
        .gate_ah_o   (gate_ah),
        .gate_al_o   (gate_al),
        .gate_bh_o   (gate_bh),
        .gate_bl_o   (gate_bl),
        .alive_o     (alive),
        .running_o   (running),
        .contact_o   (contact),
        .fault_o     (fault)
    );

    assign led_running_n = !running;
    assign led_contact_n = !contact;
    assign led_fault_n   = !fault;

endmodule

`default_nettype wire
