// SPDX-License-Identifier: Apache-2.0
//
// wh_board_adc_pads_ecp5: registers in the ECP5's I/O cells at the pads of serial converters.
//
// From flip-flop to pad and from pad to flip-flop nothing is routed, so that the round trip through
// the converter takes what the data sheets say. CS_n and SCLK come out a clock late and SDATA comes
// in through another one; at an SCLK of half the clock that is one pulse, and the reader is told
// of one more zero in front of the data (pad_registers, sim/wavehaptics/parts/adcs.py).
// CS_n and SCLK have CLOCKS pads each, all alike, where one would drive too many converters.
// The registers begin at CS_n and SCLK high.

`default_nettype none

module wh_board_adc_pads_ecp5 #(
    parameter integer LINES  = 1, // converters, 1...
    parameter integer CLOCKS = 1  // pads of CS_n, and of SCLK, 1...
) (
    input  wire              clk,

    input  wire              cs_n_i,
    input  wire              sclk_i,
    output wire [LINES-1:0]  sdata_o,

    output wire [CLOCKS-1:0] adc_cs_n_o,   // to the pads
    output wire [CLOCKS-1:0] adc_sclk_o,
    input  wire [LINES-1:0]  adc_sdata_i
);

    OFS1P3BX cs_n_pads [CLOCKS-1:0] (
        .SCLK (clk),
        .SP   (1'b1),
        .PD   (1'b0),
        .D    (cs_n_i),
        .Q    (adc_cs_n_o)
    );

    OFS1P3BX sclk_pads [CLOCKS-1:0] (
        .SCLK (clk),
        .SP   (1'b1),
        .PD   (1'b0),
        .D    (sclk_i),
        .Q    (adc_sclk_o)
    );

    IFS1P3DX sdata_pads [LINES-1:0] (
        .SCLK (clk),
        .SP   (1'b1),
        .CD   (1'b0),
        .D    (adc_sdata_i),
        .Q    (sdata_o)
    );

endmodule

`default_nettype wire
