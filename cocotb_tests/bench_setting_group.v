// SPDX-License-Identifier: Apache-2.0
//
// bench_setting_group: wh_setting_group with three words of motor 1, of 1, 5 and 32 bits.

`default_nettype none

module bench_setting_group #(
    parameter integer STAGED = 1
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        write_i,
    input  wire        copy_i,
    input  wire [11:0] address_i,
    input  wire [31:0] data_i,
    input  wire        change_i,
    input  wire        discard_i,
    input  wire        hold_i,
    output wire        pending_o,
    output wire [37:0] words_o
);

    wh_setting_group #(
        .STAGED    (STAGED),
        .PART      (4'd2),
        .FIRST     (8'h40),
        .STRIDE    (8'd4),
        .WORDS     (3),
        .WIDTHS    ({8'd32, 8'd5, 8'd1}),
        .TOTAL_W   (38)
    ) group (
        .clk       (clk),
        .rst       (rst),
        .write_i   (write_i),
        .copy_i    (copy_i),
        .address_i (address_i),
        .data_i    (data_i),
        .change_i  (change_i),
        .discard_i (discard_i),
        .hold_i    (hold_i),
        .pending_o (pending_o),
        .words_o   (words_o)
    );

endmodule

`default_nettype wire
