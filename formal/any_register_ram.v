// SPDX-License-Identifier: Apache-2.0
//
// wh_register_ram as the proof of wh_registers has it: one word, which may be any; in other places any word is.

`default_nettype none

module wh_register_ram #(
    parameter integer PLACE_W = 8,
    parameter integer W       = 32
) (
    input  wire               clk,
    input  wire               write_i,
    input  wire [PLACE_W-1:0] write_place_i,
    input  wire [W-1:0]       write_data_i,
    input  wire [PLACE_W-1:0] read_place_i,
    output reg  [W-1:0]       read_data_o
);

    (* anyconst *) wire [PLACE_W-1:0] place;
    (* anyseq *)   wire [W-1:0]       other;

    reg [W-1:0] word_q;

    always @(posedge clk) begin
        if (write_i && write_place_i == place) begin
            word_q <= write_data_i;
        end
        read_data_o <= (read_place_i == place) ? word_q : other;
    end

endmodule

`default_nettype wire
