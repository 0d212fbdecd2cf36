// SPDX-License-Identifier: Apache-2.0
//
// wh_board_pll_ecp5: the ECP5's PLL, whose feedback has an output of its own.
//
//   phase detector at f(clk_i) / CLKI_DIV                           10 to 400 MHz
//   VCO at            f(clk_i) / CLKI_DIV * CLKFB_DIV * CLKOP_DIV   400 to 800 MHz
//   f(clk_o) =        VCO / CLKOS_DIV
//
// The feedback is CLKOP, VCO / CLKOP_DIV, which nothing else uses: so the clock need not be a
// multiple of the phase detector's rate, which CLKI_DIV would otherwise push below its limit.
// The build compares all three with the data sheet and the clock with the board's scene.

`default_nettype none

module wh_board_pll_ecp5 #(
    parameter integer CLKI_DIV  = 1,
    parameter integer CLKFB_DIV = 1,
    parameter integer CLKOP_DIV = 18,
    parameter integer CLKOS_DIV = 5
) (
    input  wire clk_i,
    output wire clk_o,
    output wire locked_o
);

    wire feedback;

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
        .CLKOS_DIV        (CLKOS_DIV),
        .CLKOS_ENABLE     ("ENABLED"),
        .CLKOS_CPHASE     (CLKOS_DIV / 2 - 1),
        .CLKOS_FPHASE     (0),
        .FEEDBK_PATH      ("CLKOP")
    ) pll (
        .RST              (1'b0),
        .STDBY            (1'b0),
        .CLKI             (clk_i),
        .CLKOP            (feedback),
        .CLKOS            (clk_o),
        .CLKFB            (feedback),
        .CLKINTFB         (),
        .PHASESEL0        (1'b0),
        .PHASESEL1        (1'b0),
        .PHASEDIR         (1'b1),
        .PHASESTEP        (1'b1),
        .PHASELOADREG     (1'b1),
        .PLLWAKESYNC      (1'b0),
        .ENCLKOP          (1'b0),
        .ENCLKOS          (1'b0),
        .LOCK             (locked_o)
    );

endmodule

`default_nettype wire
