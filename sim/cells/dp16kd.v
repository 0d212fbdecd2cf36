// SPDX-License-Identifier: Apache-2.0
//
// DP16KD: model of the ECP5's block RAM, as far as Yosys uses it for the boards.
//
//   1,024 words of 18 bits, each of two bytes of nine; a port of 18 bits has word AD[13:4]
//   36 bits are two words, from AD[13:5]; 9, 4, 2 and 1 are a part of a word, of the byte AD[3], at
//     AD[2], AD[2:1] and AD[2:0] in the eight lower bits of that byte
//   port A writes and reads; ADA[1:0], of 36 bits ADA[3:0], are the bytes that it writes
//   port B reads; of 36 bits port A writes {DIB, DIA}, and port B reads {DOB, DOA}
//   what is read comes a clock later, and is what stood there before
//
// Yosys has this block as a black box. The model follows its mapping (lattice/brams_map_16kd.v) and
// the vendor's description, so what a netlist's agreement with the RTL says of the block rests on
// these. Contents: INITVAL_n has words 16 n and up, each in 20 bits. Writes at port B, output
// registers, what is written read at once, and resets stop the simulation.

`timescale 1ns / 1ps

module DP16KD (
    input
        CLKA, CLKB, CEA, CEB, OCEA, OCEB, RSTA, RSTB, WEA, WEB, CSA2, CSA1, CSA0, CSB2, CSB1,
        CSB0,
    input
        ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0,
        ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0,
    input
        DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5,
        DIA4, DIA3, DIA2, DIA1, DIA0, DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10,
        DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2, DIB1, DIB0,
    output
        DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5,
        DOA4, DOA3, DOA2, DOA1, DOA0, DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10,
        DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2, DOB1, DOB0
);

    parameter DATA_WIDTH_A = 18;
    parameter DATA_WIDTH_B = 18;
    parameter REGMODE_A    = "NOREG";
    parameter REGMODE_B    = "NOREG";
    parameter WRITEMODE_A  = "NORMAL";
    parameter WRITEMODE_B  = "NORMAL";
    parameter CSDECODE_A   = "0b000";
    parameter CSDECODE_B   = "0b000";

    parameter [319:0] INITVAL_00 = 320'd0;
    parameter [319:0] INITVAL_01 = 320'd0;
    parameter [319:0] INITVAL_02 = 320'd0;
    parameter [319:0] INITVAL_03 = 320'd0;
    parameter [319:0] INITVAL_04 = 320'd0;
    parameter [319:0] INITVAL_05 = 320'd0;
    parameter [319:0] INITVAL_06 = 320'd0;
    parameter [319:0] INITVAL_07 = 320'd0;
    parameter [319:0] INITVAL_08 = 320'd0;
    parameter [319:0] INITVAL_09 = 320'd0;
    parameter [319:0] INITVAL_0A = 320'd0;
    parameter [319:0] INITVAL_0B = 320'd0;
    parameter [319:0] INITVAL_0C = 320'd0;
    parameter [319:0] INITVAL_0D = 320'd0;
    parameter [319:0] INITVAL_0E = 320'd0;
    parameter [319:0] INITVAL_0F = 320'd0;
    parameter [319:0] INITVAL_10 = 320'd0;
    parameter [319:0] INITVAL_11 = 320'd0;
    parameter [319:0] INITVAL_12 = 320'd0;
    parameter [319:0] INITVAL_13 = 320'd0;
    parameter [319:0] INITVAL_14 = 320'd0;
    parameter [319:0] INITVAL_15 = 320'd0;
    parameter [319:0] INITVAL_16 = 320'd0;
    parameter [319:0] INITVAL_17 = 320'd0;
    parameter [319:0] INITVAL_18 = 320'd0;
    parameter [319:0] INITVAL_19 = 320'd0;
    parameter [319:0] INITVAL_1A = 320'd0;
    parameter [319:0] INITVAL_1B = 320'd0;
    parameter [319:0] INITVAL_1C = 320'd0;
    parameter [319:0] INITVAL_1D = 320'd0;
    parameter [319:0] INITVAL_1E = 320'd0;
    parameter [319:0] INITVAL_1F = 320'd0;
    parameter [319:0] INITVAL_20 = 320'd0;
    parameter [319:0] INITVAL_21 = 320'd0;
    parameter [319:0] INITVAL_22 = 320'd0;
    parameter [319:0] INITVAL_23 = 320'd0;
    parameter [319:0] INITVAL_24 = 320'd0;
    parameter [319:0] INITVAL_25 = 320'd0;
    parameter [319:0] INITVAL_26 = 320'd0;
    parameter [319:0] INITVAL_27 = 320'd0;
    parameter [319:0] INITVAL_28 = 320'd0;
    parameter [319:0] INITVAL_29 = 320'd0;
    parameter [319:0] INITVAL_2A = 320'd0;
    parameter [319:0] INITVAL_2B = 320'd0;
    parameter [319:0] INITVAL_2C = 320'd0;
    parameter [319:0] INITVAL_2D = 320'd0;
    parameter [319:0] INITVAL_2E = 320'd0;
    parameter [319:0] INITVAL_2F = 320'd0;
    parameter [319:0] INITVAL_30 = 320'd0;
    parameter [319:0] INITVAL_31 = 320'd0;
    parameter [319:0] INITVAL_32 = 320'd0;
    parameter [319:0] INITVAL_33 = 320'd0;
    parameter [319:0] INITVAL_34 = 320'd0;
    parameter [319:0] INITVAL_35 = 320'd0;
    parameter [319:0] INITVAL_36 = 320'd0;
    parameter [319:0] INITVAL_37 = 320'd0;
    parameter [319:0] INITVAL_38 = 320'd0;
    parameter [319:0] INITVAL_39 = 320'd0;
    parameter [319:0] INITVAL_3A = 320'd0;
    parameter [319:0] INITVAL_3B = 320'd0;
    parameter [319:0] INITVAL_3C = 320'd0;
    parameter [319:0] INITVAL_3D = 320'd0;
    parameter [319:0] INITVAL_3E = 320'd0;
    parameter [319:0] INITVAL_3F = 320'd0;

    localparam [20479:0] CONTENTS = {
        INITVAL_3F, INITVAL_3E, INITVAL_3D, INITVAL_3C, INITVAL_3B, INITVAL_3A, INITVAL_39,
        INITVAL_38, INITVAL_37, INITVAL_36, INITVAL_35, INITVAL_34, INITVAL_33, INITVAL_32,
        INITVAL_31, INITVAL_30, INITVAL_2F, INITVAL_2E, INITVAL_2D, INITVAL_2C, INITVAL_2B,
        INITVAL_2A, INITVAL_29, INITVAL_28, INITVAL_27, INITVAL_26, INITVAL_25, INITVAL_24,
        INITVAL_23, INITVAL_22, INITVAL_21, INITVAL_20, INITVAL_1F, INITVAL_1E, INITVAL_1D,
        INITVAL_1C, INITVAL_1B, INITVAL_1A, INITVAL_19, INITVAL_18, INITVAL_17, INITVAL_16,
        INITVAL_15, INITVAL_14, INITVAL_13, INITVAL_12, INITVAL_11, INITVAL_10, INITVAL_0F,
        INITVAL_0E, INITVAL_0D, INITVAL_0C, INITVAL_0B, INITVAL_0A, INITVAL_09, INITVAL_08,
        INITVAL_07, INITVAL_06, INITVAL_05, INITVAL_04, INITVAL_03, INITVAL_02, INITVAL_01,
        INITVAL_00
    };

    // Where a port's bits begin in their word, and how many they are.
    function [4:0] begins(input [3:0] at, input integer width);
        case (width)
            1:       begins = (at[3] ? 5'd9 : 5'd0) + {2'd0, at[2:0]};
            2:       begins = (at[3] ? 5'd9 : 5'd0) + {2'd0, at[2:1], 1'b0};
            4:       begins = (at[3] ? 5'd9 : 5'd0) + {2'd0, at[2], 2'b00};
            9:       begins = (at[3] ? 5'd9 : 5'd0);
            default: begins = 5'd0;
        endcase
    endfunction

    localparam [17:0] ONES_A = (DATA_WIDTH_A >= 18) ? 18'h3ffff : (18'd1 << DATA_WIDTH_A) - 18'd1;
    localparam [17:0] ONES_B = (DATA_WIDTH_B >= 18) ? 18'h3ffff : (18'd1 << DATA_WIDTH_B) - 18'd1;

    wire [9:0]  word_a  = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4};
    wire [9:0]  word_b  = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4};
    wire [4:0]  begin_a = begins({ADA3, ADA2, ADA1, ADA0}, DATA_WIDTH_A);
    wire [4:0]  begin_b = begins({ADB3, ADB2, ADB1, ADB0}, DATA_WIDTH_B);
    wire [17:0] low     = {
        DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5,
        DIA4, DIA3, DIA2, DIA1, DIA0
    };
    wire [17:0] high    = {
        DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5,
        DIB4, DIB3, DIB2, DIB1, DIB0
    };
    wire [17:0] of_low  = (DATA_WIDTH_A >= 18) ? {{9{ADA1}}, {9{ADA0}}} : ONES_A << begin_a;
    wire [17:0] of_high = {{9{ADA3}}, {9{ADA2}}};

    reg [17:0] ram [0:1023];
    reg [17:0] out_a;
    reg [17:0] out_b;
    reg [17:0] out_low;
    integer    n;

    initial begin
        for (n = 0; n < 1024; n = n + 1) begin
            ram[n] = CONTENTS[20*n +: 18];
        end
        out_a   = 18'd0;
        out_b   = 18'd0;
        out_low = 18'd0;
        if (REGMODE_A != "NOREG" || REGMODE_B != "NOREG" || CSDECODE_A != "0b000"
            || CSDECODE_B != "0b000" || WRITEMODE_A == "WRITETHROUGH") begin
            $display("DP16KD: an output register or a write read at once is not in the model");
            $finish;
        end
    end

    always @(posedge CLKA) begin
        if (CEA && WEA) begin
            if (DATA_WIDTH_A == 36) begin
                ram[{word_a[9:1], 1'b0}] <= (low & of_low) | (ram[{word_a[9:1], 1'b0}] & ~of_low);
                ram[{word_a[9:1], 1'b1}] <=
                    (high & of_high) | (ram[{word_a[9:1], 1'b1}] & ~of_high);
            end else begin
                ram[word_a] <= ((low << begin_a) & of_low) | (ram[word_a] & ~of_low);
            end
        end
        if (CEA && (!WEA || WRITEMODE_A == "READBEFOREWRITE")) begin
            out_a <= (ram[word_a] >> begin_a) & ONES_A;
        end
    end

    always @(posedge CLKB) begin
        if (CEB) begin
            if (DATA_WIDTH_B == 36) begin
                out_low <= ram[{word_b[9:1], 1'b0}];
                out_b   <= ram[{word_b[9:1], 1'b1}];
            end else begin
                out_b   <= (ram[word_b] >> begin_b) & ONES_B;
            end
        end
    end

    // The model leaves these out, so they have to stand still.
    always @(posedge CLKA or posedge CLKB) begin
        if (WEB || RSTA || RSTB || CSA2 || CSA1 || CSA0 || CSB2 || CSB1 || CSB0) begin
            $display("DP16KD: a write at port B, a reset or a select is not in the model");
            $finish;
        end
    end

    assign {
        DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5,
        DOA4, DOA3, DOA2, DOA1, DOA0
    } = (DATA_WIDTH_B == 36) ? out_low : out_a;
    assign {
        DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5,
        DOB4, DOB3, DOB2, DOB1, DOB0
    } = out_b;

endmodule
