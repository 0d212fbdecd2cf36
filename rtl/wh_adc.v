// SPDX-License-Identifier: Apache-2.0
//
// wh_adc: the currents' ADC, read as its kind wants it, and the fast path past every average.
//
//   ADC   0 wh_adc_serial   1 wh_adc_max11125   2 wh_sinc3
//
// The fast path compares the last word (wh_trip), or with ADC = 2 a filter of its own.
// Formats: a word is s16, full scale 2^15.
// Latency: that of the reader; trip_o a clock more, of which wh_sinc3 says its own.
// Reset: that of the reader; restart_i resets the reader and leaves the fast path's last word.

`default_nettype none
`include "wh_formats.vh"

module wh_adc #(
    parameter integer LINES = 1,  // currents
    parameter integer ADC   = 0,
    parameter integer OSR   = 32  // of wh_sinc3
) (
    input  wire                             clk,
    input  wire                             rst,
    input  wire                             restart_i,

    // Pins.
    output wire                             adc_cs_n_o,
    output wire                             adc_sclk_o,
    output wire                             adc_din_o,           // ADC = 1: commands
    input  wire [LINES-1:0]                 adc_sdata_i,         // ADC = 1: bit 0, from one part

    // The frame.
    input  wire [7:0]                       sclk_half_clocks_i,
    input  wire [5:0]                       frame_bits_i,
    input  wire [5:0]                       lead_bits_i,
    input  wire [4:0]                       data_bits_i,
    input  wire [7:0]                       quiet_clocks_i,
    input  wire [7:0]                       setup_clocks_i,
    input  wire [7:0]                       hold_clocks_i,
    input  wire [5:0]                       calibrate_bits_i,
    input  wire                             sclk_idle_i,
    input  wire                             read_trailing_i,
    input  wire [15:0]                      trip_i,              // of 2^15, full scale; more: never

    input  wire                             start_i,             // strobe, a sample
    input  wire                             first_i,             // of a tick
    output wire                             ready_o,             // the part is set up
    output wire                             valid_o,             // strobe, words of all lines
    output wire                             first_o,
    output wire [LINES*`WH_SAMPLE_W-1:0]    sample_o,
    output wire [LINES-1:0]                 trip_o,              // as long as it is
    output wire                             overrun_o            // a start while busy; until reset
);

    wire reader_rst = rst || restart_i;

    generate
        if (ADC < 0 || ADC > 2) begin : illegal
            wh_illegal_parameter_adc_adc_must_be_0_to_2 stop ();
        end

        if (ADC == 0) begin : serial
            wire busy;
            wire lead_edge;
            wire unused = &{1'b0, busy, lead_edge};

            assign adc_din_o = 1'b0;

            wh_adc_serial #(
                .LINES              (LINES)
            ) reader (
                .clk                (clk),
                .rst                (reader_rst),
                .adc_cs_n_o         (adc_cs_n_o),
                .adc_sclk_o         (adc_sclk_o),
                .adc_sdata_i        (adc_sdata_i),
                .sclk_half_clocks_i (sclk_half_clocks_i),
                .frame_bits_i       (frame_bits_i),
                .lead_bits_i        (lead_bits_i),
                .data_bits_i        (data_bits_i),
                .quiet_clocks_i     (quiet_clocks_i),
                .setup_clocks_i     (setup_clocks_i),
                .hold_clocks_i      (hold_clocks_i),
                .calibrate_bits_i   (calibrate_bits_i),
                .sclk_idle_i        (sclk_idle_i),
                .read_trailing_i    (read_trailing_i),
                .start_i            (start_i),
                .first_i            (first_i),
                .ready_o            (ready_o),
                .busy_o             (busy),
                .lead_edge_o        (lead_edge),
                .valid_o            (valid_o),
                .first_o            (first_o),
                .sample_o           (sample_o),
                .overrun_o          (overrun_o)
            );
        end else if (ADC == 1) begin : command
            wire busy;
            wire unused = &{1'b0, busy, adc_sdata_i, calibrate_bits_i};

            wh_adc_max11125 #(
                .LINES              (LINES)
            ) reader (
                .clk                (clk),
                .rst                (reader_rst),
                .adc_cs_n_o         (adc_cs_n_o),
                .adc_sclk_o         (adc_sclk_o),
                .adc_din_o          (adc_din_o),
                .adc_sdata_i        (adc_sdata_i[0]),
                .sclk_half_clocks_i (sclk_half_clocks_i),
                .frame_bits_i       (frame_bits_i),
                .lead_bits_i        (lead_bits_i),
                .data_bits_i        (data_bits_i),
                .quiet_clocks_i     (quiet_clocks_i),
                .setup_clocks_i     (setup_clocks_i),
                .hold_clocks_i      (hold_clocks_i),
                .sclk_idle_i        (sclk_idle_i),
                .read_trailing_i    (read_trailing_i),
                .start_i            (start_i),
                .first_i            (first_i),
                .ready_o            (ready_o),
                .busy_o             (busy),
                .valid_o            (valid_o),
                .first_o            (first_o),
                .sample_o           (sample_o),
                .overrun_o          (overrun_o)
            );
        end else begin : sigma_delta
            wire unused = &{1'b0, frame_bits_i, lead_bits_i, data_bits_i, quiet_clocks_i,
                            setup_clocks_i, hold_clocks_i, calibrate_bits_i, sclk_idle_i,
                            read_trailing_i};

            assign adc_cs_n_o = 1'b1;
            assign adc_din_o  = 1'b0;

            wh_sinc3 #(
                .LINES              (LINES),
                .OSR                (OSR)
            ) reader (
                .clk                (clk),
                .rst                (reader_rst),
                .adc_sclk_o         (adc_sclk_o),
                .adc_sdata_i        (adc_sdata_i),
                .sclk_half_clocks_i (sclk_half_clocks_i),
                .trip_i             (trip_i),
                .start_i            (start_i),
                .first_i            (first_i),
                .ready_o            (ready_o),
                .valid_o            (valid_o),
                .first_o            (first_o),
                .sample_o           (sample_o),
                .trip_o             (trip_o),
                .overrun_o          (overrun_o)
            );
        end
    endgenerate

    genvar n;
    generate
        if (ADC != 2) begin : by_word
            for (n = 0; n < LINES; n = n + 1) begin : line
                wh_trip trip (
                    .clk      (clk),
                    .rst      (rst),
                    .valid_i  (valid_o),
                    .sample_i (sample_o[n*`WH_SAMPLE_W +: `WH_SAMPLE_W]),
                    .trip_i   (trip_i),
                    .trip_o   (trip_o[n])
                );
            end
        end
    endgenerate

endmodule

`default_nettype wire
