// SPDX-License-Identifier: Apache-2.0
//
// wh_settings_rom: what the table of words says of an address: its kind, its range, and when it may
// change. All ports share what is said of the first one; with BOTH = 1 that is the words of motors with brushes and
// those of brushless ones. With the macro WH_BOARD_ROM a header wh_board_settings_rom.vh says it, in place of
// wh_settings_rom.vh: another first word, another kind.
//
// Formats: least_o and greatest_o take turns in bound_o; of a word with a sign (signed_o) they are
// 2^31 more than the word, so that both are compared without a sign.
// Latency: kind_o, off_o and signed_o are those of the address a clock before, bound_o that of the
// address and of greatest_i two and one clocks before.

`default_nettype none
`include "wh_formats.vh"

module wh_settings_rom #(
    parameter integer WALLS      = 4,  // as wh_controller has them
    parameter integer SHAPER     = 0,
    parameter integer DELAY_LOG2 = 2,
    parameter integer BOTH       = 0   // 1: words of brushless motors, too
) (
    input  wire        clk,

    input  wire [8:0]  address_i,   // 0x000...0x0ff the board's, 0x100...0x1ff a motor's
    output wire [1:0]  kind_o,      // 0 no word, 1 setting, 2 command, 3 live
    output wire        off_o,       // with the bridges off only; with kind 3: a setting that is fixed
    output wire        signed_o,

    input  wire        greatest_i,  // the greatest word is asked for, else the least
    output reg  [31:0] bound_o
);

    // Words with a sign have the types from here on.
    localparam [4:0] SIGNED = 5'd20;

    localparam [1:0] MOTORS = (BOTH == 1) ? 2'b11 : 2'b01;  // whose words these are

    generate
        if (BOTH != 0 && BOTH != 1) begin : illegal_both
            wh_illegal_parameter_settings_rom_both_must_be_0_or_1 stop ();
        end
    endgenerate

    (* rom_style = "block" *) reg [7:0]  info [0:511];
    (* rom_style = "block" *) reg [31:0] bounds [0:63];

    integer i;

`define WH_SETTINGS_WORD(FIRST, COPIES, WHO, INFO, DEFAULT) \
        for (i = FIRST; i < FIRST + (COPIES); i = i + 1) begin \
            if (((WHO) & MOTORS) != 2'd0) begin \
                info[i] = INFO; \
            end \
        end
`define WH_SETTINGS_TOLD(FIRST, COPIES, WHO, INFO) `WH_SETTINGS_WORD(FIRST, COPIES, WHO, INFO, 0)
`define WH_SETTINGS_BOUNDS(TYPE, LEAST, GREATEST) \
        bounds[2*TYPE] = LEAST; \
        bounds[2*TYPE + 1] = GREATEST;

    initial begin
        for (i = 0; i < 512; i = i + 1) begin
            info[i] = 8'd0;
        end
        for (i = 0; i < 64; i = i + 1) begin
            bounds[i] = 32'd0;
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

    // What a block RAM puts out comes late in its clock.
    reg [7:0]  info_q;
    reg [31:0] bound_q;
    reg [1:0]  kind_q;
    reg        off_q;
    reg        signed_q;

    assign kind_o   = kind_q;
    assign off_o    = off_q;
    assign signed_o = signed_q;

    always @(posedge clk) begin
        info_q   <= info[address_i];
        kind_q   <= info_q[7:6];
        off_q    <= info_q[5];
        signed_q <= (info_q[4:0] >= SIGNED);
        bound_q  <= bounds[{info_q[4:0], greatest_i}];
        bound_o  <= bound_q;
    end

endmodule

`default_nettype wire
