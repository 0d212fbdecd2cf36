// SPDX-License-Identifier: Apache-2.0
//
// placed_input, placed_output: pads of a placed netlist, which are wires.

`timescale 1ns / 1ps

module placed_input (
    input  PIN,
    output IN
);

    assign IN = PIN;

endmodule

module placed_output (
    output PIN,
    input  OUT
);

    assign PIN = OUT;

endmodule
