// SPDX-License-Identifier: Apache-2.0
//
// What placed netlists of both families have: pads, which are wires, and tables of four inputs.
//
// A table that doesn't depend on an input doesn't look at it: a logic cell's carry may take the
// cell's own output from the same pin, which is no loop.

`timescale 1ns / 1ps

module placed_table (
    input  A, B, C, D,
    output Z
);

    parameter [15:0] INIT = 16'h0000;

    localparam [0:0] ON_B = {INIT[15:14], INIT[11:10], INIT[7:6], INIT[3:2]}
                            != {INIT[13:12], INIT[9:8], INIT[5:4], INIT[1:0]};
    localparam [0:0] ON_C = {INIT[15:12], INIT[7:4]} != {INIT[11:8], INIT[3:0]};
    localparam [0:0] ON_D = INIT[15:8] != INIT[7:0];

    wire b = ON_B ? B : 1'b0;
    wire c = ON_C ? C : 1'b0;
    wire d = ON_D ? D : 1'b0;

// Entries n and n + 1, of which A chooses one.
`define WH_PAIR(n) ((INIT[(n) + 1] == INIT[n]) ? INIT[n] : (INIT[(n) + 1] ? A : !A))

    assign Z = d ? (c ? (b ? `WH_PAIR(14) : `WH_PAIR(12)) : (b ? `WH_PAIR(10) : `WH_PAIR(8)))
                 : (c ? (b ? `WH_PAIR(6)  : `WH_PAIR(4))  : (b ? `WH_PAIR(2)  : `WH_PAIR(0)));

`undef WH_PAIR

endmodule

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

module placed_tristate (
    output PIN,
    input  OUT,
    input  OFF
);

    assign PIN = OFF ? 1'bz : OUT;

endmodule
