// SPDX-License-Identifier: Apache-2.0
//
// icebreaker: the wave controller on an iCEBreaker (iCE40 UP5K): pads, PLL and reset.
//
// The clock is 27 MHz, 12 MHz * 72 / 2^5. README.md has the wiring.
// Reset: until the PLL has been locked for 2^16 clocks.

`default_nettype none
`include "wh_board_settings.vh"

module icebreaker (
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

    input  wire button_start_n,
    input  wire stop,            // open, so high, is stop
    output wire led_running_n,
    output wire led_fault_n
);

    wire clk;
    wire locked;

    SB_PLL40_PAD #(
        .FEEDBACK_PATH ("SIMPLE"),
        .DIVR          (4'd0),
        .DIVF          (7'd71),
        .DIVQ          (3'd5),
        .FILTER_RANGE  (3'd1)
    ) pll (
        .PACKAGEPIN    (clk_12mhz),
        .PLLOUTGLOBAL  (clk),
        .LOCK          (locked),
        .BYPASS        (1'b0),
        .RESETB        (1'b1)
    );

    // Pull-ups: a wire that is open stops the bridge, and no button is no start.
    wire start_n_in;
    wire stop_in;

    SB_IO #(
        .PIN_TYPE  (6'b000001),
        .PULLUP    (1'b1)
    ) pads [1:0] (
        .PACKAGE_PIN ({button_start_n, stop}),
        .D_IN_0      ({start_n_in, stop_in})
    );

    wire rst;
    wire running;
    wire fault;

    wh_board_reset board_reset (
        .clk      (clk),
        .locked_i (locked),
        .rst_o    (rst)
    );

    wire contact;
    wire uart_tx;  // of a link, which is too large for this FPGA
    wire unused = &{1'b0, contact, uart_tx};

    wh_board_controller board_controller (
        .clk          (clk),
        .rst          (rst),
        .start_i      (!start_n_in),
        .stop_i       (stop_in),
        .clock_lost_i (1'b0),
        .uart_rx_i    (1'b1),
        .uart_tx_o    (uart_tx),
        .adc_cs_n_o   (adc_cs_n),
        .adc_sclk_o   (adc_sclk),
        .adc_sdata_i  (adc_sdata),
        .enc_a_i      (enc_a),
        .enc_b_i      (enc_b),
        .gate_ah_o    (gate_ah),
        .gate_al_o    (gate_al),
        .gate_bh_o    (gate_bh),
        .gate_bl_o    (gate_bl),
        .alive_o      (alive),
        .running_o    (running),
        .contact_o    (contact),
        .fault_o      (fault)
    );

    assign led_running_n = !running;
    assign led_fault_n   = !fault;

endmodule

`default_nettype wire
