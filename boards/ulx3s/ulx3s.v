// SPDX-License-Identifier: Apache-2.0
//
// ulx3s: the wave controller on a ULX3S (ECP5): its pads.
//
// The clock is 70 MHz, a tenth of the VCO's 25 MHz * 28. README.md has the wiring.
// Reset: until the PLL has been locked for 2^16 clocks.

`default_nettype none

module ulx3s (
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

    input  wire uart_rx,       // USB serial, 115,200 bits a second at first
    output wire uart_tx,
    input  wire spi_cs_n,      // a host MCU, in place of the USB serial
    input  wire spi_sclk,
    input  wire spi_mosi,
    output wire spi_miso,
    input  wire overcurrent_n, // low: U10 has shut the gates
    input  wire button_start,
    input  wire stop,          // open, so high, is stop
    output wire led_running,
    output wire led_contact,
    output wire led_fault,
    output wire wifi_en,         // low: the ESP32 is in reset, to v3.0
    output wire wifi_en_v31      // the same from v3.1 on
);

    // It shares header pins with the FPGA, and may have firmware of its own.
    assign wifi_en     = 1'b0;
    assign wifi_en_v31 = 1'b0;

    // A pad that is off while CS is high: others may share MISO.
    wire miso;
    wire miso_drives;

    OBZ miso_pad (
        .I (miso),
        .T (!miso_drives),
        .O (spi_miso)
    );

    // The watch has 19.4 MHz.
    wh_board_ecp5 #(
        .CLKOP_DIV  (28),
        .CLKOS_DIV  (10),
        .WATCH_DIV  (16)
    ) board (
        .osc_i           (clk_25mhz),
        .reset_n_i       (1'b1),
        .start_i         (button_start),
        .stop_i          (stop),
        .uart_rx_i       (uart_rx),
        .uart_tx_o       (uart_tx),
        .spi_cs_n_i      (spi_cs_n),
        .spi_sclk_i      (spi_sclk),
        .spi_mosi_i      (spi_mosi),
        .spi_miso_o      (miso),
        .spi_drives_o    (miso_drives),
        .overcurrent_n_i (overcurrent_n),
        .adc_cs_n_o      (adc_cs_n),
        .adc_sclk_o      (adc_sclk),
        .adc_sdata_i     (adc_sdata),
        .enc_a_i         (enc_a),
        .enc_b_i         (enc_b),
        .gate_ah_o       (gate_ah),
        .gate_al_o       (gate_al),
        .gate_bh_o       (gate_bh),
        .gate_bl_o       (gate_bl),
        .alive_o         (alive),
        .running_o       (led_running),
        .contact_o       (led_contact),
        .fault_o         (led_fault)
    );

endmodule

`default_nettype wire
