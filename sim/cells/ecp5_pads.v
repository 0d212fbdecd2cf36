// SPDX-License-Identifier: Apache-2.0
//
// OFS1P3BX, IFS1P3DX and OBZ: the ECP5's I/O cells, registers and a pad that can be off, as the boards' sources name
// them.

`timescale 1ns / 1ps

module OFS1P3BX (
    input  SCLK, SP, PD, D,
    output Q
);

    TRELLIS_FF #(
        .CEMUX  ("CE"),
        .REGSET ("SET"),
        .SRMODE ("ASYNC")
    ) ff (
        .CLK (SCLK),
        .LSR (PD),
        .CE  (SP),
        .DI  (D),
        .M   (1'b0),
        .Q   (Q)
    );

endmodule

module IFS1P3DX (
    input  SCLK, SP, CD, D,
    output Q
);

    TRELLIS_FF #(
        .CEMUX  ("CE"),
        .REGSET ("RESET"),
        .SRMODE ("ASYNC")
    ) ff (
        .CLK (SCLK),
        .LSR (CD),
        .CE  (SP),
        .DI  (D),
        .M   (1'b0),
        .Q   (Q)
    );

endmodule

module OBZ (
    input  I, T,
    output O
);

    assign O = T ? 1'bz : I;

endmodule
