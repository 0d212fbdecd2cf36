// SPDX-License-Identifier: Apache-2.0
//
// EHXPLLL and OSCG: models of the ECP5's PLL and of its own oscillator.
//
// The PLL hands its input on, at all its outputs: the simulation's clock is the PLL's output. It is
// locked after 16 clocks. The oscillator's clock is made by the bench around the board.

`timescale 1ns / 1ps

module EHXPLLL (
    input  CLKI, CLKFB, RST, STDBY, PLLWAKESYNC, PHASESEL1, PHASESEL0, PHASEDIR, PHASESTEP,
    input  PHASELOADREG, ENCLKOP, ENCLKOS,
    output CLKOP, CLKOS, CLKINTFB, LOCK
);

    parameter PLLRST_ENA      = "DISABLED";
    parameter INTFB_WAKE      = "DISABLED";
    parameter STDBY_ENABLE    = "DISABLED";
    parameter DPHASE_SOURCE   = "DISABLED";
    parameter OUTDIVIDER_MUXA = "DIVA";
    parameter OUTDIVIDER_MUXB = "DIVB";
    parameter OUTDIVIDER_MUXC = "DIVC";
    parameter OUTDIVIDER_MUXD = "DIVD";
    parameter CLKI_DIV        = 1;
    parameter CLKFB_DIV       = 1;
    parameter CLKOP_DIV       = 8;
    parameter CLKOP_ENABLE    = "ENABLED";
    parameter CLKOP_CPHASE    = 0;
    parameter CLKOP_FPHASE    = 0;
    parameter CLKOS_DIV       = 8;
    parameter CLKOS_ENABLE    = "DISABLED";
    parameter CLKOS_CPHASE    = 0;
    parameter CLKOS_FPHASE    = 0;
    parameter FEEDBK_PATH     = "CLKOP";

    reg [4:0] clocks;

    initial begin
        clocks = 5'd0;
    end

    always @(posedge CLKI) begin
        clocks <= clocks + {4'd0, !clocks[4]};
    end

    assign CLKOP    = CLKI;
    assign CLKOS    = CLKI;
    assign CLKINTFB = CLKI;
    assign LOCK     = clocks[4];

endmodule

module OSCG (
    output OSC
);

    parameter DIV = 128;

    assign OSC = wh_board_bench.watch_clk;

endmodule
