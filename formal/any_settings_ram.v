// SPDX-License-Identifier: Apache-2.0
//
// wh_settings_ram as the proofs of wh_settings have it: one word of a place, which may be any, in both
// banks and among the defaults; what stands in other places is any word.

`default_nettype none

module wh_settings_ram #(
    parameter integer WALLS  = 4,
    parameter integer SHAPER = 0,
    parameter integer PART_W = 1,
    parameter integer SLOT_W = 7
) (
    input  wire                     clk,
    input  wire                     write_i,
    input  wire [1:0]               write_bank_i,
    input  wire [PART_W+SLOT_W-1:0] write_address_i,
    input  wire [31:0]              write_data_i,
    input  wire [1:0]               read_bank_i,
    input  wire [PART_W+SLOT_W-1:0] read_address_i,
    output reg  [31:0]              read_data_o
);

    (* anyconst *) wire [PART_W+SLOT_W-1:0] place;
    (* anyconst *) wire [31:0]              first;
    (* anyseq *)   wire [31:0]              other;

    reg [31:0] low_q;   // bank 0
    reg [31:0] high_q;  // bank 1

    wire [31:0] here = read_bank_i[1] ? first : read_bank_i[0] ? high_q : low_q;

    always @(posedge clk) begin
        if (write_i && write_address_i == place) begin
            if (write_bank_i == 2'd0) low_q  <= write_data_i;
            if (write_bank_i == 2'd1) high_q <= write_data_i;
        end
        read_data_o <= (read_address_i == place) ? here : other;
    end

endmodule

`default_nettype wire
