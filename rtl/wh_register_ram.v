// SPDX-License-Identifier: Apache-2.0
//
// wh_register_ram: a memory of wh_registers, in block RAM: one write and one read a clock.
//
// Latency: read_data_o is that of the address a clock before. A word that is read in the clock in which it is
// written is the old one. No reset: what nobody wrote means nothing.

`default_nettype none

module wh_register_ram #(
    parameter integer PLACE_W = 8,  // bits of an address
    parameter integer W       = 32  // bits of a word
) (
    input  wire               clk,

    input  wire               write_i,
    input  wire [PLACE_W-1:0] write_place_i,
    input  wire [W-1:0]       write_data_i,

    input  wire [PLACE_W-1:0] read_place_i,
    output reg  [W-1:0]       read_data_o
);

    (* ram_style = "block" *) reg [W-1:0] memory [0:(1<<PLACE_W)-1];

    always @(posedge clk) begin
        if (write_i) begin
            memory[write_place_i] <= write_data_i;
        end
        read_data_o <= memory[read_place_i];
    end

endmodule

`default_nettype wire
