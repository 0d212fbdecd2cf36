// SPDX-License-Identifier: Apache-2.0
//
// DP16KD: model of the ECP5's block RAM, as far as Yosys uses it for the boards.
//
//   port A writes 36 bits, {DIB, DIA}, at ADA[13:5], nine for each of ADA[3:0]
//   port B reads 36 bits, {DOB, DOA}, at ADB[13:5], a clock later, what stood there before
//
// Yosys has this block as a black box. The model follows its mapping of pseudo dual ports
// (brams_map_16kd.v) and the vendor's description, so what a netlist's agreement with the RTL says
// of the block rests on these. Other widths, output registers and resets stop the simulation; it
// begins with zeros.

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

    parameter DATA_WIDTH_A = 36;
    parameter DATA_WIDTH_B = 36;
    parameter REGMODE_A    = "NOREG";
    parameter REGMODE_B    = "NOREG";
    parameter CSDECODE_A   = "0b000";
    parameter CSDECODE_B   = "0b000";

    wire [8:0]  write_at = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5};
    wire [8:0]  read_at  = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5};
    wire [35:0] bytes    = {{9{ADA3}}, {9{ADA2}}, {9{ADA1}}, {9{ADA0}}};
    wire [35:0] in       = {
        DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5,
        DIB4, DIB3, DIB2, DIB1, DIB0, DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10,
        DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1, DIA0
    };

    reg [35:0] ram [0:511];
    reg [35:0] out;
    integer    n;

    initial begin
        for (n = 0; n < 512; n = n + 1) begin
            ram[n] = 36'd0;
        end
        out = 36'd0;
        if (DATA_WIDTH_A != 36 || DATA_WIDTH_B != 36 || REGMODE_A != "NOREG"
            || REGMODE_B != "NOREG" || CSDECODE_A != "0b000" || CSDECODE_B != "0b000") begin
            $display("DP16KD: only a port of 36 bits to write and one to read are in the model");
            $finish;
        end
    end

    always @(posedge CLKA) begin
        if (CEA && WEA) begin
            ram[write_at] <= (in & bytes) | (ram[write_at] & ~bytes);
        end
    end

    always @(posedge CLKB) begin
        if (CEB) begin
            out <= ram[read_at];
        end
    end

    // The model leaves these out, so they have to stand still.
    always @(posedge CLKB) begin
        if (WEB || RSTA || RSTB || CSA2 || CSA1 || CSA0 || CSB2 || CSB1 || CSB0) begin
            $display("DP16KD: a write at port B, a reset or a select is not in the model");
            $finish;
        end
    end

    assign {
        DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5,
        DOB4, DOB3, DOB2, DOB1, DOB0, DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10,
        DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2, DOA1, DOA0
    } = out;

endmodule
