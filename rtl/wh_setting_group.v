// SPDX-License-Identifier: Apache-2.0
//
// wh_setting_group: settings of all ports that a block needs side by side, in flip-flops.
//
// STAGED = 1: each setting that wh_registers copies is staged here. All staged settings become active together, on the
// clock edge on which change_i is high.
// STAGED = 0, for a single setting, or a block that pauses during a commit: a setting becomes active as it is copied.
// That takes half the flip-flops.
//
// With the macro WH_BOARD_ROM (wh_settings_rom) a setting that the board's header has as fixed is a constant:
// nothing can write it, and the logic behind it is made for the one value.
//
// Latency: words_o change with the clock edge behind that of change_i or copy_i.
// Reset: none; wh_registers copies them all after its own.

`default_nettype none

module wh_setting_group #(
    parameter integer           STAGED  = 1,     // 1: words become active together; 0: as each is copied
    parameter [7:0]             FIRST   = 8'd0,  // address of the first word; those of the others follow
    parameter integer           WORDS   = 1,
    parameter [WORDS*8-1:0]     WIDTHS  = 8'd32, // bits of each, 1...32, the first lowest
    parameter integer           TOTAL_W = 32     // their sum
) (
    input  wire               clk,

    input  wire               copy_i,     // strobe, a word is copied
    input  wire [11:0]        address_i,
    input  wire [31:0]        data_i,
    input  wire               change_i,   // strobe, staged words become active; STAGED = 1

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

    // A word, below whether it is fixed.
    function [32:0] fixed_word;
        input integer address;
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

    genvar n;
    generate
        for (n = 0; n < WORDS; n = n + 1) begin : word
            localparam integer WIDTH   = {24'd0, WIDTHS[n*8 +: 8]};
            localparam integer LOW     = below(n);
            localparam [31:0]  PLACE   = n;
            localparam [7:0]   ADDRESS = FIRST + PLACE[7:0];

`ifdef WH_BOARD_ROM
            localparam [32:0]  FIXED   = fixed_word({24'd0, ADDRESS});
`else
            localparam [32:0]  FIXED   = 33'd0;
`endif

            wire mine = copy_i && (address_i == {4'd0, ADDRESS});

            if (FIXED[32]) begin : fixed
                wire unused_bus = &{1'b0, clk, mine, change_i, data_i[WIDTH-1:0]};

                assign words_o[LOW +: WIDTH] = FIXED[WIDTH-1:0];
            end

            if (!FIXED[32] && STAGED != 0) begin : staged
                reg [WIDTH-1:0] staged_q;
                reg [WIDTH-1:0] active_q;

                assign words_o[LOW +: WIDTH] = active_q;

                always @(posedge clk) begin
                    if (mine) begin
                        staged_q <= data_i[WIDTH-1:0];
                    end
                    if (change_i) begin
                        active_q <= staged_q;
                    end
                end
            end

            if (!FIXED[32] && STAGED == 0) begin : direct
                reg  [WIDTH-1:0] active_q;
                wire             unused = &{1'b0, change_i};

                assign words_o[LOW +: WIDTH] = active_q;

                always @(posedge clk) begin
                    if (mine) begin
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
