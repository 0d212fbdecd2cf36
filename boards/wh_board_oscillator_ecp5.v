// SPDX-License-Identifier: Apache-2.0
//
// wh_board_oscillator_ecp5: the ECP5's own oscillator, which needs no part outside the FPGA.
//
//   f(clk_o) = 310 MHz / DIV, within 30 %
//
// nextpnr times clk_o by DIV, and the build adds the 30 %.

`default_nettype none

module wh_board_oscillator_ecp5 #(
    parameter integer DIV = 16  // 2...128
) (
    output wire clk_o
);

    generate
        if (DIV < 2 || DIV > 128) begin : illegal_div
            wh_illegal_parameter_board_oscillator_ecp5_div_must_be_2_to_128 stop ();
        end
    endgenerate

    OSCG #(
        .DIV (DIV)
    ) oscillator (
        .OSC (clk_o)
    );

endmodule

`default_nettype wire
