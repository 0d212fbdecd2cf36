// SPDX-License-Identifier: Apache-2.0
//
// wh_board_pll_ecp5: the ECP5's PLL with one output, which is its feedback.
//
//   f(clk_o) = f(clk_i) / CLKI_DIV * CLKFB_DIV,   VCO at f(clk_o) * CLKOP_DIV, 400 to 800 MHz
//
// The build compares both with the board's scene and the VCO's range.

`default_nettype none

module wh_board_pll_ecp5 #(
    parameter integer CLKI_DIV  = 1,
    parameter integer CLKFB_DIV = 1,
    parameter integer CLKOP_DIV = 8
) (
    input  wire clk_i,
    output wire clk_o,
    output wire locked_o
);

    (* ICP_CURRENT = "12", LPF_RESISTOR = "8", MFG_ENABLE_FILTEROPAMP = "1",
       MFG_GMCREF_SEL = "2" *)
    EHXPLLL #(
        .PLLRST_ENA       ("DISABLED"),
        .INTFB_WAKE       ("DISABLED"),
        .STDBY_ENABLE     ("DISABLED"),
        .DPHASE_SOURCE    ("DISABLED"),
        .OUTDIVIDER_MUXA  ("DIVA"),
        .OUTDIVIDER_MUXB  ("DIVB"),
        .OUTDIVIDER_MUXC  ("DIVC"),
        .OUTDIVIDER_MUXD  ("DIVD"),
        .CLKI_DIV         (CLKI_DIV),
        .CLKFB_DIV        (CLKFB_DIV),
        .CLKOP_DIV        (CLKOP_DIV),
        .CLKOP_ENABLE     ("ENABLED"),
        .CLKOP_CPHASE     (CLKOP_DIV / 2 - 1),
        .CLKOP_FPHASE     (0),
        .FEEDBK_PATH      ("CLKOP")
    ) pll (
        .RST              (1'b0),
        .STDBY            (1'b0),
        .CLKI             (clk_i),
        .CLKOP            (clk_o),
        .CLKFB            (clk_o),
        .CLKINTFB         (),
        .PHASESEL0        (1'b0),
        .PHASESEL1        (1'b0),
        .PHASEDIR         (1'b1),
        .PHASESTEP        (1'b1),
        .PHASELOADREG     (1'b1),
        .PLLWAKESYNC      (1'b0),
        .ENCLKOP          (1'b0),
        .LOCK             (locked_o)
    );

endmodule

`default_nettype wire
