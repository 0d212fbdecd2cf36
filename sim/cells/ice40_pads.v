// SPDX-License-Identifier: Apache-2.0
//
// SB_IO, SB_PLL40_PAD and SB_PLL40_CORE: models of the iCE40's pads and PLL, as far as the boards use
// them.
//
// A pad is an input without a register; another kind stops the simulation. The PLL hands its input
// on: the simulation's clock is the PLL's output. It is locked after 16 clocks.

`timescale 1ns / 1ps

module SB_IO (
    input  PACKAGE_PIN,
    output D_IN_0
);

    parameter [5:0] PIN_TYPE = 6'b000000;
    parameter [0:0] PULLUP   = 1'b0;

    initial begin
        if (PIN_TYPE != 6'b000001) begin
            $display("SB_IO: pin type %b is not in the model", PIN_TYPE);
            $finish;
        end
    end

    assign D_IN_0 = PACKAGE_PIN;

endmodule

module SB_PLL40_PAD (
    input  PACKAGEPIN,
    output PLLOUTCORE,
    output PLLOUTGLOBAL,
    input  BYPASS,
    input  RESETB,
    output LOCK
);

    parameter       FEEDBACK_PATH = "SIMPLE";
    parameter [3:0] DIVR          = 4'd0;
    parameter [6:0] DIVF          = 7'd0;
    parameter [2:0] DIVQ          = 3'd0;
    parameter [2:0] FILTER_RANGE  = 3'd0;

    reg [4:0] clocks;

    initial begin
        clocks = 5'd0;
    end

    always @(posedge PACKAGEPIN) begin
        clocks <= clocks + {4'd0, !clocks[4]};
    end

    assign PLLOUTCORE   = PACKAGEPIN;
    assign PLLOUTGLOBAL = PACKAGEPIN;
    assign LOCK         = clocks[4];

endmodule

module SB_PLL40_CORE (
    input  REFERENCECLK,
    output PLLOUTCORE,
    output PLLOUTGLOBAL,
    input  BYPASS,
    input  RESETB,
    output LOCK
);

    parameter       FEEDBACK_PATH = "SIMPLE";
    parameter [3:0] DIVR          = 4'd0;
    parameter [6:0] DIVF          = 7'd0;
    parameter [2:0] DIVQ          = 3'd0;
    parameter [2:0] FILTER_RANGE  = 3'd0;

    SB_PLL40_PAD pll (
        .PACKAGEPIN   (REFERENCECLK),
        .PLLOUTCORE   (PLLOUTCORE),
        .PLLOUTGLOBAL (PLLOUTGLOBAL),
        .BYPASS       (BYPASS),
        .RESETB       (RESETB),
        .LOCK         (LOCK)
    );

endmodule
