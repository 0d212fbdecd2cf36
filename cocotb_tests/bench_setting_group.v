// SPDX-License-Identifier: Apache-2.0
//
// bench_setting_group: wh_setting_group with three words, of 1, 5 and 32 bits.

`default_nettype none

module bench_setting_group #(
    parameter integer STAGED = 1
) (
    input  wire        clk,
    input  wire        copy_i,
    input  wire [11:0] address_i,
    input  wire [31:0] data_i,
    input  wire        change_i,
    output wire [37:0] words_o
);

    wh_setting_group #(
        .STAGED    (STAGED),
        .FIRST     (8'h4e),
        .WORDS     (3),
        .WIDTHS    ({8'd32, 8'd5, 8'd1}),
        .TOTAL_W   (38)
    ) group (
        .clk       (clk),
        .copy_i    (copy_i),
        .address_i (address_i),
        .data_i    (data_i),
        .change_i  (change_i),
        .words_o   (words_o)
    );

endmodule

`default_nettype wire
