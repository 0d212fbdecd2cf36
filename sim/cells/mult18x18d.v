// SPDX-License-Identifier: Apache-2.0
//
// MULT18X18D: model of the ECP5's multiplier block, as far as Yosys uses it for wh_multiply.
//
//   P = A * B,   A signed where SIGNEDA, B signed where SIGNEDB
//
// Yosys has this block as a black box. The model is written from the vendor's description of the
// sysDSP slice, so what the netlist's agreement with the RTL says of the block rests on that: it
// checks how the block is wired, not the block. Only the combinational block is modelled. One with
// registers, cascades or a C operand stops the simulation.

`timescale 1ns / 1ps

module MULT18X18D (
    input A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0,
    input B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0,
    input C17, C16, C15, C14, C13, C12, C11, C10, C9, C8, C7, C6, C5, C4, C3, C2, C1, C0,
    input SIGNEDA, SIGNEDB, SOURCEA, SOURCEB,
    input CLK3, CLK2, CLK1, CLK0, CE3, CE2, CE1, CE0, RST3, RST2, RST1, RST0,
    output P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18,
    output P17, P16, P15, P14, P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0
);

    parameter REG_INPUTA_CLK   = "NONE";
    parameter REG_INPUTB_CLK   = "NONE";
    parameter REG_PIPELINE_CLK = "NONE";
    parameter REG_OUTPUT_CLK   = "NONE";

    initial begin
        if (REG_INPUTA_CLK != "NONE" || REG_INPUTB_CLK != "NONE"
            || REG_PIPELINE_CLK != "NONE" || REG_OUTPUT_CLK != "NONE"
            || SOURCEA === 1'b1 || SOURCEB === 1'b1) begin
            $display("MULT18X18D: registers and cascades are not in the model");
            $finish;
        end
    end

    wire [17:0] a = {A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0};
    wire [17:0] b = {B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0};

    // 18 bits unsigned or signed are 19 bits signed.
    wire signed [18:0] a_signed = $signed({SIGNEDA & a[17], a});
    wire signed [18:0] b_signed = $signed({SIGNEDB & b[17], b});
    wire signed [37:0] product  = a_signed * b_signed;

    assign {P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18,
            P17, P16, P15, P14, P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0}
        = product[35:0];

endmodule
