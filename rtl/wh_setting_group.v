// SPDX-License-Identifier: Apache-2.0
//
// wh_setting_group: words of the settings memory that a block needs side by side, in flip-flops.
//
// STAGED = 1: every word that is accepted is staged here (wh_registers gives it with write_i, and once
// more with copy_i when it copies its banks). While change_i is high, all staged words become active
// together on the first clock edge where hold_i is 0. pending_o is 1 from the first write on until then,
// or until discard_i: a group that nobody has written is never pending, whatever hold_i is.
// STAGED = 0, for words that change with the bridges off only: nothing is staged, and a word becomes
// active as wh_registers copies it, if hold_i is low. That takes half the flip-flops.
//
// With the macro WH_BOARD_ROM (wh_settings_rom) a word that the board's header has as fixed is a constant:
// nothing can write it, and the logic behind it is made for the one value.
//
// Latency: words_o change with the clock edge behind that of change_i or copy_i.
// Reset: pending. The words stay what they are, or unknown; wh_registers gives them all.

`default_nettype none

module wh_setting_group #(
    parameter integer           STAGED  = 1,     // 1: words become active together; 0: as each is copied
    parameter [3:0]             PART    = 4'd0,  // 0 the board's words, n + 1 those of motor n
    parameter [7:0]             FIRST   = 8'd0,  // address of the first word in its part
    parameter [7:0]             STRIDE  = 8'd1,  // from word to word
    parameter integer           WORDS   = 1,
    parameter [WORDS*8-1:0]     WIDTHS  = 8'd32, // bits of each, 1...32, the first lowest
    parameter integer           TOTAL_W = 32     // their sum
) (
    input  wire               clk,
    input  wire               rst,

    input  wire               write_i,    // strobe, a word was accepted
    input  wire               copy_i,     // strobe, a word is copied
    input  wire [11:0]        address_i,
    input  wire [31:0]        data_i,

    input  wire               change_i,   // staged words are to become active
    input  wire               discard_i,  // strobe, the words in force will be copied over those staged
    input  wire               hold_i,     // the words are being read
    output wire               pending_o,

    output wire [TOTAL_W-1:0] words_o     // side by side, the first lowest
);

    // Bits below word `count`.
    function integer below;
        input integer count;
        integer k;
        begin
            below = 0;
            for (k = 0; k < count; k = k + 1) begin
                below = below + {24'd0, WIDTHS[k*8 +: 8]};
            end
        end
    endfunction

    generate
        if (TOTAL_W != below(WORDS)) begin : illegal
            wh_illegal_parameter_setting_group_total_w_must_be_the_sum_of_widths stop ();
        end
        if (STAGED != 0 && STAGED != 1) begin : illegal_staged
            wh_illegal_parameter_setting_group_staged_must_be_0_or_1 stop ();
        end
    endgenerate

`ifdef WH_BOARD_ROM
    // What rows of words that can change are written with; these are not fixed, whatever it is.
    localparam integer WALLS  = 1;
    localparam integer SHAPER = 1;

    // A word, below whether it is fixed: one of the board's, or of a motor's, in all of which it is the same.
    function [32:0] fixed_word;
        input integer address;  // in its part; 0x100 more for a motor's
        integer i;
        begin
            fixed_word = 33'd0;
`define WH_SETTINGS_WORD(FIRST, COPIES, WHO, INFO, DEFAULT) \
            for (i = FIRST; i < FIRST + (COPIES); i = i + 1) begin \
                if (i == address) begin \
                    fixed_word[32]   = (((INFO) & 8'he0) == 8'he0); \
                    fixed_word[31:0] = DEFAULT; \
                end \
            end
`define WH_SETTINGS_TOLD(FIRST, COPIES, WHO, INFO)
`define WH_SETTINGS_BOUNDS(TYPE, LEAST, GREATEST)
`include "wh_board_settings_rom.vh"
`undef WH_SETTINGS_WORD
`undef WH_SETTINGS_TOLD
`undef WH_SETTINGS_BOUNDS
        end
    endfunction
`endif

    wire             here = (address_i[11:8] == PART);
    wire [WORDS-1:0] mine;
    wire             change;

    genvar n;
    generate
        if (STAGED != 0) begin : when_told
            reg pending_q;

            always @(posedge clk) begin
                if (rst || (write_i && (|mine))) begin
                    pending_q <= 1'b1;
                end else if (change || discard_i) begin
                    pending_q <= 1'b0;
                end
            end

            assign pending_o = pending_q;
            assign change    = change_i && !hold_i;
        end else begin : when_copied
            wire unused = &{1'b0, rst, change_i, discard_i, write_i};

            assign pending_o = 1'b0;
            assign change    = copy_i && !hold_i;
        end

        for (n = 0; n < WORDS; n = n + 1) begin : word
            localparam integer   WIDTH   = {24'd0, WIDTHS[n*8 +: 8]};
            localparam integer   LOW     = below(n);
            localparam [31:0]    OFFSET  = n * {24'd0, STRIDE};
            localparam [7:0]     ADDRESS = FIRST + OFFSET[7:0];

`ifdef WH_BOARD_ROM
            localparam [32:0]    FIXED   = fixed_word({23'd0, PART != 4'd0, ADDRESS});
`else
            localparam [32:0]    FIXED   = 33'd0;
`endif

            assign mine[n] = here && (address_i[7:0] == ADDRESS);

            if (FIXED[32]) begin : fixed
                wire unused_bus = &{1'b0, mine[n], change, copy_i, data_i[WIDTH-1:0]};

                assign words_o[LOW +: WIDTH] = FIXED[WIDTH-1:0];
            end

            if (!FIXED[32] && STAGED != 0) begin : staged
                reg [WIDTH-1:0] staged_q;
                reg [WIDTH-1:0] active_q;

                assign words_o[LOW +: WIDTH] = active_q;

                always @(posedge clk) begin
                    if ((write_i || copy_i) && mine[n]) begin
                        staged_q <= data_i[WIDTH-1:0];
                    end
                    if (change) begin
                        active_q <= staged_q;
                    end
                end
            end

            if (!FIXED[32] && STAGED == 0) begin : direct
                reg [WIDTH-1:0] active_q;

                assign words_o[LOW +: WIDTH] = active_q;

                always @(posedge clk) begin
                    if (change && mine[n]) begin
                        active_q <= data_i[WIDTH-1:0];
                    end
                end
            end

            if (WIDTH < 32) begin : narrow
                wire unused = &{1'b0, data_i[31:WIDTH]};
            end
        end
    endgenerate

endmodule

`default_nettype wire
