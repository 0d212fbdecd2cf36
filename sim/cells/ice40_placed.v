// SPDX-License-Identifier: Apache-2.0
//
// Cells that nextpnr places on the iCE40, as far as the boards use them.
//
// ICESTORM_LC   a logic cell: table, carry and flip-flop
// ICESTORM_DSP  the multiplier, by SB_MAC16 of Yosys' library
// ICESTORM_RAM  a block RAM of 256 words, which begins with zeros
// ICESTORM_PLL  the PLL, by SB_PLL40_PAD
//
// Yosys' library has an ICESTORM_LC with an asynchronous reset in each cell, which simulates at a
// twentieth of the speed. Here that, and a clock that falls, stop the simulation.

`timescale 1ns / 1ps

module ICESTORM_LC (
    input  I0, I1, I2, I3, CIN, CLK, CEN, SR,
    output LO, O, COUT
);

    parameter [15:0] LUT_INIT     = 16'h0000;
    parameter [0:0]  NEG_CLK      = 1'b0;
    parameter [0:0]  CARRY_ENABLE = 1'b0;
    parameter [0:0]  DFF_ENABLE   = 1'b0;
    parameter [0:0]  SET_NORESET  = 1'b0;
    parameter [0:0]  ASYNC_SR     = 1'b0;
    parameter [0:0]  CIN_CONST    = 1'b0;
    parameter [0:0]  CIN_SET      = 1'b0;

    wire carry = CIN_CONST ? CIN_SET : CIN;

    assign COUT = CARRY_ENABLE && ((I1 && I2) || ((I1 || I2) && carry));

    placed_table #(
        .INIT (LUT_INIT)
    ) table4 (
        .A    (I0),
        .B    (I1),
        .C    (I2),
        .D    (I3),
        .Z    (LO)
    );

    generate
        if (DFF_ENABLE) begin : ff
            reg q;
            initial begin
                q = 1'b0;
            end
            always @(posedge CLK) begin
                if (CEN) begin
                    q <= SR ? SET_NORESET : LO;
                end
            end
            assign O = q;
        end else begin : no_ff
            assign O = LO;
        end
    endgenerate

    initial begin
        if (ASYNC_SR || NEG_CLK) begin
            $display("ICESTORM_LC: asynchronous resets and falling clocks are not in the model");
            $finish;
        end
    end

endmodule

module ICESTORM_DSP (
    input A_15, A_14, A_13, A_12, A_11, A_10, A_9, A_8, A_7, A_6, A_5, A_4, A_3, A_2, A_1, A_0,
    input B_15, B_14, B_13, B_12, B_11, B_10, B_9, B_8, B_7, B_6, B_5, B_4, B_3, B_2, B_1, B_0,
    input C_15, C_14, C_13, C_12, C_11, C_10, C_9, C_8, C_7, C_6, C_5, C_4, C_3, C_2, C_1, C_0,
    input D_15, D_14, D_13, D_12, D_11, D_10, D_9, D_8, D_7, D_6, D_5, D_4, D_3, D_2, D_1, D_0,
    input CLK, CE, AHOLD, BHOLD, CHOLD, DHOLD, IRSTTOP, IRSTBOT, ORSTTOP, ORSTBOT,
    input OLOADTOP, OLOADBOT, ADDSUBTOP, ADDSUBBOT, OHOLDTOP, OHOLDBOT, CI, ACCUMCI, SIGNEXTIN,
    output O_31, O_30, O_29, O_28, O_27, O_26, O_25, O_24, O_23, O_22, O_21, O_20, O_19, O_18,
    output O_17, O_16, O_15, O_14, O_13, O_12, O_11, O_10, O_9, O_8, O_7, O_6, O_5, O_4, O_3, O_2,
    output O_1, O_0, CO, ACCUMCO, SIGNEXTOUT
);

    parameter [0:0] NEG_TRIGGER              = 0;
    parameter [0:0] A_REG                    = 0;
    parameter [0:0] B_REG                    = 0;
    parameter [0:0] C_REG                    = 0;
    parameter [0:0] D_REG                    = 0;
    parameter [0:0] TOP_8x8_MULT_REG         = 0;
    parameter [0:0] BOT_8x8_MULT_REG         = 0;
    parameter [0:0] PIPELINE_16x16_MULT_REG1 = 0;
    parameter [0:0] PIPELINE_16x16_MULT_REG2 = 0;
    parameter [1:0] TOPOUTPUT_SELECT         = 0;
    parameter [1:0] TOPADDSUB_LOWERINPUT     = 0;
    parameter [0:0] TOPADDSUB_UPPERINPUT     = 0;
    parameter [1:0] TOPADDSUB_CARRYSELECT    = 0;
    parameter [1:0] BOTOUTPUT_SELECT         = 0;
    parameter [1:0] BOTADDSUB_LOWERINPUT     = 0;
    parameter [0:0] BOTADDSUB_UPPERINPUT     = 0;
    parameter [1:0] BOTADDSUB_CARRYSELECT    = 0;
    parameter [0:0] MODE_8x8                 = 0;
    parameter [0:0] A_SIGNED                 = 0;
    parameter [0:0] B_SIGNED                 = 0;

    SB_MAC16 #(
        .NEG_TRIGGER              (NEG_TRIGGER),
        .A_REG                    (A_REG),
        .B_REG                    (B_REG),
        .C_REG                    (C_REG),
        .D_REG                    (D_REG),
        .TOP_8x8_MULT_REG         (TOP_8x8_MULT_REG),
        .BOT_8x8_MULT_REG         (BOT_8x8_MULT_REG),
        .PIPELINE_16x16_MULT_REG1 (PIPELINE_16x16_MULT_REG1),
        .PIPELINE_16x16_MULT_REG2 (PIPELINE_16x16_MULT_REG2),
        .TOPOUTPUT_SELECT         (TOPOUTPUT_SELECT),
        .TOPADDSUB_LOWERINPUT     (TOPADDSUB_LOWERINPUT),
        .TOPADDSUB_UPPERINPUT     (TOPADDSUB_UPPERINPUT),
        .TOPADDSUB_CARRYSELECT    (TOPADDSUB_CARRYSELECT),
        .BOTOUTPUT_SELECT         (BOTOUTPUT_SELECT),
        .BOTADDSUB_LOWERINPUT     (BOTADDSUB_LOWERINPUT),
        .BOTADDSUB_UPPERINPUT     (BOTADDSUB_UPPERINPUT),
        .BOTADDSUB_CARRYSELECT    (BOTADDSUB_CARRYSELECT),
        .MODE_8x8                 (MODE_8x8),
        .A_SIGNED                 (A_SIGNED),
        .B_SIGNED                 (B_SIGNED)
    ) mac (
        .CLK        (CLK),
        .CE         (CE),
        .A          ({A_15, A_14, A_13, A_12, A_11, A_10, A_9, A_8,
                      A_7, A_6, A_5, A_4, A_3, A_2, A_1, A_0}),
        .B          ({B_15, B_14, B_13, B_12, B_11, B_10, B_9, B_8,
                      B_7, B_6, B_5, B_4, B_3, B_2, B_1, B_0}),
        .C          ({C_15, C_14, C_13, C_12, C_11, C_10, C_9, C_8,
                      C_7, C_6, C_5, C_4, C_3, C_2, C_1, C_0}),
        .D          ({D_15, D_14, D_13, D_12, D_11, D_10, D_9, D_8,
                      D_7, D_6, D_5, D_4, D_3, D_2, D_1, D_0}),
        .AHOLD      (AHOLD),
        .BHOLD      (BHOLD),
        .CHOLD      (CHOLD),
        .DHOLD      (DHOLD),
        .IRSTTOP    (IRSTTOP),
        .IRSTBOT    (IRSTBOT),
        .ORSTTOP    (ORSTTOP),
        .ORSTBOT    (ORSTBOT),
        .OLOADTOP   (OLOADTOP),
        .OLOADBOT   (OLOADBOT),
        .ADDSUBTOP  (ADDSUBTOP),
        .ADDSUBBOT  (ADDSUBBOT),
        .OHOLDTOP   (OHOLDTOP),
        .OHOLDBOT   (OHOLDBOT),
        .CI         (CI),
        .ACCUMCI    (ACCUMCI),
        .SIGNEXTIN  (SIGNEXTIN),
        .O          ({O_31, O_30, O_29, O_28, O_27, O_26, O_25, O_24, O_23, O_22, O_21, O_20,
                      O_19, O_18, O_17, O_16, O_15, O_14, O_13, O_12, O_11, O_10, O_9, O_8, O_7,
                      O_6, O_5, O_4, O_3, O_2, O_1, O_0}),
        .CO         (CO),
        .ACCUMCO    (ACCUMCO),
        .SIGNEXTOUT (SIGNEXTOUT)
    );

endmodule

module ICESTORM_RAM (
    input
        RCLK, RCLKE, RE, WCLK, WCLKE, WE, RADDR_10, RADDR_9, RADDR_8, RADDR_7, RADDR_6, RADDR_5,
        RADDR_4, RADDR_3, RADDR_2, RADDR_1, RADDR_0, WADDR_10, WADDR_9, WADDR_8, WADDR_7,
        WADDR_6, WADDR_5, WADDR_4, WADDR_3, WADDR_2, WADDR_1, WADDR_0, MASK_15, MASK_14,
        MASK_13, MASK_12, MASK_11, MASK_10, MASK_9, MASK_8, MASK_7, MASK_6, MASK_5, MASK_4,
        MASK_3, MASK_2, MASK_1, MASK_0, WDATA_15, WDATA_14, WDATA_13, WDATA_12, WDATA_11,
        WDATA_10, WDATA_9, WDATA_8, WDATA_7, WDATA_6, WDATA_5, WDATA_4, WDATA_3, WDATA_2,
        WDATA_1, WDATA_0,
    output
        RDATA_15, RDATA_14, RDATA_13, RDATA_12, RDATA_11, RDATA_10, RDATA_9, RDATA_8, RDATA_7,
        RDATA_6, RDATA_5, RDATA_4, RDATA_3, RDATA_2, RDATA_1, RDATA_0
);

    parameter [1:0] READ_MODE  = 2'd0;
    parameter [1:0] WRITE_MODE = 2'd0;
    parameter [0:0] NEG_CLK_R  = 1'b0;
    parameter [0:0] NEG_CLK_W  = 1'b0;

    wire [7:0]  read_at  = {
        RADDR_7, RADDR_6, RADDR_5, RADDR_4, RADDR_3, RADDR_2, RADDR_1, RADDR_0
    };
    wire [7:0]  write_at = {
        WADDR_7, WADDR_6, WADDR_5, WADDR_4, WADDR_3, WADDR_2, WADDR_1, WADDR_0
    };
    wire [15:0] keeps    = {
        MASK_15, MASK_14, MASK_13, MASK_12, MASK_11, MASK_10, MASK_9, MASK_8, MASK_7, MASK_6,
        MASK_5, MASK_4, MASK_3, MASK_2, MASK_1, MASK_0
    };
    wire [15:0] in       = {
        WDATA_15, WDATA_14, WDATA_13, WDATA_12, WDATA_11, WDATA_10, WDATA_9, WDATA_8, WDATA_7,
        WDATA_6, WDATA_5, WDATA_4, WDATA_3, WDATA_2, WDATA_1, WDATA_0
    };

    reg [15:0] ram [0:255];
    reg [15:0] out;
    integer    n;

    initial begin
        for (n = 0; n < 256; n = n + 1) begin
            ram[n] = 16'd0;
        end
        out = 16'd0;
        if (READ_MODE != 2'd0 || WRITE_MODE != 2'd0 || NEG_CLK_R || NEG_CLK_W) begin
            $display("ICESTORM_RAM: only 256 words of 16 bits and rising clocks are in the model");
            $finish;
        end
    end

    always @(posedge WCLK) begin
        if (WCLKE && WE) begin
            ram[write_at] <= (in & ~keeps) | (ram[write_at] & keeps);
        end
    end

    always @(posedge RCLK) begin
        if (RCLKE && RE) begin
            out <= ram[read_at];
        end
    end

    assign {
        RDATA_15, RDATA_14, RDATA_13, RDATA_12, RDATA_11, RDATA_10, RDATA_9, RDATA_8, RDATA_7,
        RDATA_6, RDATA_5, RDATA_4, RDATA_3, RDATA_2, RDATA_1, RDATA_0
    } = out;

endmodule

module ICESTORM_PLL (
    input  REFERENCECLK,
    output PLLOUT_A,
    output PLLOUT_A_GLOBAL,
    output LOCK
);

    SB_PLL40_PAD pll (
        .PACKAGEPIN   (REFERENCECLK),
        .PLLOUTCORE   (PLLOUT_A),
        .PLLOUTGLOBAL (PLLOUT_A_GLOBAL),
        .BYPASS       (1'b0),
        .RESETB       (1'b1),
        .LOCK         (LOCK)
    );

endmodule
