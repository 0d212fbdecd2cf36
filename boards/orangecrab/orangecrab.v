// SPDX-License-Identifier: Apache-2.0
//
// orangecrab: the wave controller on an OrangeCrab r0.2 (ECP5): its pads.
//
// The clock is 64 MHz, a twelfth of the VCO's 48 MHz * 16. README.md has the wiring.
// Reset: until the PLL has been locked, and the board's button up, for 2^16 clocks.

`default_nettype none

module orangecrab (
    input  wire clk_48mhz,

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
    input  wire start_n,
    input  wire stop,          // open, so high, is stop
    output wire led_running_n,
    output wire led_contact_n,
    output wire led_fault_n
);

    wire running;
    wire contact;
    wire fault;

    // The watch has 19.4 MHz.
    wh_board_ecp5 #(
        .CLKI_DIV   (1),
        .CLKOP_DIV  (16),
        .CLKOS_DIV  (12),
        .WATCH_DIV  (16)
    ) board (
        .osc_i       (clk_48mhz),
        .reset_n_i   (button_reset_n),
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
