// SPDX-License-Identifier: Apache-2.0
//
// colorlight_i5: the wave controller on a Colorlight i5 (ECP5): pads, PLL and reset.
//
// The clock is 90 MHz, 25 MHz / 5 * 18, from a VCO at 540 MHz. README.md has the wiring.
// Reset: until the PLL has been locked for 2^16 clocks.

`default_nettype none
`include "wh_board_settings.vh"

module colorlight_i5 (
    input  wire clk_25mhz,

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

    input  wire start_n,
    input  wire stop,          // open, so high, is stop
    output wire led_running_n,
    output wire led_fault
);

    wire clk;
    wire locked;

    wh_board_pll_ecp5 #(
        .CLKI_DIV  (5),
        .CLKFB_DIV (18),
        .CLKOP_DIV (6)
    ) pll (
        .clk_i     (clk_25mhz),
        .clk_o     (clk),
        .locked_o  (locked)
    );

    wire rst;
    wire running;
    wire contact;
    wire unused = &{1'b0, contact};

    wh_board_reset board_reset (
        .clk      (clk),
        .locked_i (locked),
        .rst_o    (rst)
    );

    wh_board_controller board_controller (
        .clk         (clk),
        .rst         (rst),
        .start_i     (!start_n),
        .stop_i      (stop),
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
        .fault_o     (led_fault)
    );

    assign led_running_n = !running;

endmodule

`default_nettype wire
