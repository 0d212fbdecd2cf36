// SPDX-License-Identifier: Apache-2.0
//
// icesugar_pro_brushless: four brushless motors on an iCESugar-pro (ECP5): its pads.
//
// The clock is 37.5 MHz, a sixteenth of the VCO's 25 MHz * 24. README.md has the wiring.
// Reset: until the PLL has been locked for 2^16 clocks.

`default_nettype none

module icesugar_pro_brushless (
    input  wire       clk_25mhz,

    output wire [3:0] adc_cs_n,      // one of each for the two phases of a motor
    output wire [3:0] adc_sclk,
    input  wire [7:0] adc_sdata,     // two of each motor, its phases a and b
    input  wire [3:0] enc_a,
    input  wire [3:0] enc_b,
    output wire [3:0] gate_ah,
    output wire [3:0] gate_al,
    output wire [3:0] gate_bh,
    output wire [3:0] gate_bl,
    output wire [3:0] gate_ch,
    output wire [3:0] gate_cl,
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

    // Two ports for each motor. The second one's leg A is the motor's leg c. Its leg B and its encoder are none.
    wire [3:0] no_bh;
    wire [3:0] no_bl;
    wire       unused = &{1'b0, no_bh, no_bl};

    // The watch has 11.1 MHz: a beat of the slower clock lasts longer.
    wh_board_ecp5 #(
        .CLKOP_DIV  (24),
        .CLKOS_DIV  (16),
        .WATCH_DIV  (28),
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
        .enc_a_i     ({1'b0, enc_a[3], 1'b0, enc_a[2], 1'b0, enc_a[1], 1'b0, enc_a[0]}),
        .enc_b_i     ({1'b0, enc_b[3], 1'b0, enc_b[2], 1'b0, enc_b[1], 1'b0, enc_b[0]}),
        .gate_ah_o   ({gate_ch[3], gate_ah[3], gate_ch[2], gate_ah[2], gate_ch[1], gate_ah[1], gate_ch[0], gate_ah[0]}),
        .gate_al_o   ({gate_cl[3], gate_al[3], gate_cl[2], gate_al[2], gate_cl[1], gate_al[1], gate_cl[0], gate_al[0]}),
        .gate_bh_o   ({no_bh[3], gate_bh[3], no_bh[2], gate_bh[2], no_bh[1], gate_bh[1], no_bh[0], gate_bh[0]}),
        .gate_bl_o   ({no_bl[3], gate_bl[3], no_bl[2], gate_bl[2], no_bl[1], gate_bl[1], no_bl[0], gate_bl[0]}),
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
