// SPDX-License-Identifier: Apache-2.0
//
// ulx3s_gan: a brushless motor on a bought power board, on a ULX3S (ECP5): its pads.
//
// The clock is 30 MHz, a twentieth of the VCO's 25 MHz * 24. README.md has the wiring.
// Reset: until the PLL has been locked for 2^16 clocks.

`default_nettype none

module ulx3s_gan (
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
    output wire       wifi_en,         // low: the ESP32 is in reset, to v3.0
    output wire       wifi_en_v31      // the same from v3.1 on
);

    // It shares header pins with the FPGA, and may have firmware of its own.
    assign wifi_en     = 1'b0;
    assign wifi_en_v31 = 1'b0;

    // Two ports: leg c is leg A of the second one, whose leg B is none.
    wire no_bh;
    wire no_bl;
    wire unused = &{1'b0, no_bh, no_bl};

    // The watch has 8.9 MHz: a beat of the slower clock lasts longer.
    wh_board_ecp5 #(
        .CLKOP_DIV  (24),
        .CLKOS_DIV  (20),
        .WATCH_DIV  (35)
    ) board (
        .osc_i       (clk_25mhz),
        .reset_n_i   (1'b1),
        .start_i     (button_start),
        .stop_i      (stop),
        .uart_rx_i   (uart_rx),
        .uart_tx_o   (uart_tx),
        .adc_cs_n_o  (adc_cs_n),
        .adc_sclk_o  (adc_sclk),
        .adc_sdata_i (adc_sdata),
        .enc_a_i     ({1'b0, enc_a}),
        .enc_b_i     ({1'b0, enc_b}),
        .gate_ah_o   ({gate_ch, gate_ah}),
        .gate_al_o   ({gate_cl, gate_al}),
        .gate_bh_o   ({no_bh, gate_bh}),
        .gate_bl_o   ({no_bl, gate_bl}),
        .alive_o     (alive),
        .running_o   (led_running),
        .contact_o   (led_contact),
        .fault_o     (led_fault)
    );

endmodule

`default_nettype wire
