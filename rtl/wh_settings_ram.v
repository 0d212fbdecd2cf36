// SPDX-License-Identifier: Apache-2.0
//
// wh_settings_ram: the words of the settings memory, in block RAM: two banks and the defaults.
//
//   bank 0, 1   one is in force, the other one takes what is written
//   bank 2      the defaults of wh_settings_rom.vh, never written
//
// A bank has a part for the board and one for each motor, of 2^SLOT_W words each.
// Latency: read_data_o is that of the address a clock before. A word that is read in the clock in
// which it is written is the old one.

`default_nettype none
`include "wh_formats.vh"

module wh_settings_ram #(
    parameter integer WALLS  = 4,  // as wh_controller has them
    parameter integer SHAPER = 0,
    parameter integer PART_W = 1,  // bits of a part: 0 the board, n + 1 motor n
    parameter integer SLOT_W = 7   // bits of a word's address in its part
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

    localparam integer WORDS = 1 << (PART_W + SLOT_W);

    // Not every bank is whole in what is read of it: what has no word stays 0.
    (* ram_style = "block" *) reg [31:0] memory [0:4*WORDS-1];

    integer i;
    integer part;

    // A row of the table: who has it and `info` are the ROM's. A motor's words stand in each motor's part.
`define WH_SETTINGS_WORD(FIRST, COPIES, WHO, INFO, DEFAULT) \
        for (i = FIRST; i < FIRST + (COPIES); i = i + 1) begin \
            for (part = (FIRST >> 8); part < ((FIRST < 256) ? 1 : (1 << PART_W)); part = part + 1) begin \
                memory[2*WORDS + part*(1 << SLOT_W) + (i & ((1 << SLOT_W) - 1))] = DEFAULT; \
            end \
        end
`define WH_SETTINGS_TOLD(FIRST, COPIES, WHO, INFO)
`define WH_SETTINGS_BOUNDS(TYPE, LEAST, GREATEST)

    initial begin
        for (i = 0; i < 4*WORDS; i = i + 1) begin
            memory[i] = 32'd0;
        end
`ifdef WH_BOARD_ROM
`include "wh_board_settings_rom.vh"
`else
`include "wh_settings_rom.vh"
`endif
    end

`undef WH_SETTINGS_WORD
`undef WH_SETTINGS_TOLD
`undef WH_SETTINGS_BOUNDS

    always @(posedge clk) begin
        if (write_i) begin
            memory[{write_bank_i, write_address_i}] <= write_data_i;
        end
        read_data_o <= memory[{read_bank_i, read_address_i}];
    end

endmodule

`default_nettype wire
