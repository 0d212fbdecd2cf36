// SPDX-License-Identifier: Apache-2.0
//
// Cells that nextpnr places on the ECP5, as far as the boards use them.
//
// TRELLIS_COMB   half a slice's logic: a table of four inputs, half a carry cell, or a RAM of 16 bits
// TRELLIS_RAMW   hands a slice's inputs on to the write side of its RAMs
// SIOLOGIC       the registers in a pad's cell, one in and one out
// DCCA           into a clock network
//
// Yosys' library has a TRELLIS_COMB, but leaves its carry open. The wiring of the RAM and of the
// registers follows nextpnr, which makes these cells of DPR16X4C and IFS1P3DX. A mode that isn't
// here stops the simulation.

`timescale 1ns / 1ps

module TRELLIS_COMB (
    input  A, B, C, D, M,
    input  FCI, F1, FXA, FXB,
    input  WD, WAD0, WAD1, WAD2, WAD3, WRE, WCK,
    output F, FCO, OFX
);

    parameter        MODE         = "LOGIC";
    parameter [15:0] INITVAL      = 16'h0000;
    parameter        CCU2_INJECT1 = "NO";
    parameter [0:0]  IS_Z1        = 1'b0;

    generate
        if (MODE == "DPRAM") begin : dpram
            reg [15:0] ram;
            initial begin
                ram = INITVAL;
            end
            always @(posedge WCK) begin
                if (WRE) begin
                    ram[{WAD3, WAD2, WAD1, WAD0}] <= WD;
                end
            end
            assign F   = ram[{A, C, B, D}];
            assign FCO = 1'b0;
        end else begin : logic_or_carry
            wire whole;
            placed_table #(
                .INIT (INITVAL)
            ) table4 (
                .A    (A),
                .B    (B),
                .C    (C),
                .D    (D),
                .Z    (whole)
            );
            if (MODE == "CCU2") begin : carry
                wire joins  = (CCU2_INJECT1 != "YES");
                wire pair;
                placed_table #(
                    .INIT ({12'd0, INITVAL[3:0]})
                ) table2 (
                    .A    (A),
                    .B    (B),
                    .C    (1'b0),
                    .D    (1'b0),
                    .Z    (pair)
                );
                assign F    = whole ^ (joins & FCI);
                assign FCO  = whole ? FCI : (joins & pair);
            end else begin : only_logic
                assign F    = whole;
                assign FCO  = 1'b0;
            end
        end
    endgenerate

    // The slice's first half joins two tables, its second two such pairs.
    assign OFX = IS_Z1 ? (M ? FXB : FXA) : (M ? F1 : F);

    initial begin
        if (MODE != "LOGIC" && MODE != "CCU2" && MODE != "DPRAM") begin
            $display("TRELLIS_COMB: a mode is not in the model");
            $finish;
        end
    end

endmodule

module TRELLIS_RAMW (
    input  A0, B0, C0, D0, A1, B1, C1, D1,
    output WDO0, WDO1, WDO2, WDO3, WADO0, WADO1, WADO2, WADO3
);

    assign {WDO3, WDO2, WDO1, WDO0}     = {B1, D1, A1, C1};
    assign {WADO3, WADO2, WADO1, WADO0} = {A0, C0, B0, D0};

endmodule

module SIOLOGIC (
    input  CLK, CE, LSR, PADDI, TXDATA0,
    output INFF, IOLDO
);

    parameter MODE               = "NONE";
    parameter OUTREG_OUTREGMODE  = "BYPASS";
    parameter OUTREG_REGSET      = "RESET";
    parameter FF_INREGMODE       = "BYPASS";
    parameter FF_REGSET          = "RESET";

    reg in_q;
    reg out_q;

    initial begin
        in_q  = (FF_REGSET == "SET");
        out_q = (OUTREG_REGSET == "SET");
        if (MODE != "IREG_OREG" || (OUTREG_OUTREGMODE != "FF" && FF_INREGMODE != "FF")) begin
            $display("SIOLOGIC: only plain registers are in the model");
            $finish;
        end
    end

    always @(posedge CLK or posedge LSR) begin
        if (LSR) begin
            in_q  <= (FF_REGSET == "SET");
            out_q <= (OUTREG_REGSET == "SET");
        end else if (CE) begin
            in_q  <= PADDI;
            out_q <= TXDATA0;
        end
    end

    assign INFF  = in_q;
    assign IOLDO = out_q;

endmodule

module DCCA (
    input  CLKI, CE,
    output CLKO
);

    assign CLKO = CLKI & CE;

endmodule
