// SPDX-License-Identifier: Apache-2.0
//
// wh_port_settings: the settings of one station, a few words for each of N ports, in two banks.
//
//   word_o = word word_i of port port_i in bank bank_i, as of the last read_i
//
// The register bus writes one bank while a station reads the other one: wh_slots says which bank a slot has,
// so what a commit changes, it changes between two rounds. A write goes to part 1 + port, as the register map
// has it, from the place FIRST on.
// Formats: words of W bits, the lowest of data_i. Latency: 1 clock from read_i; word_o then holds until the
// next. A word that is written can be read a clock later. No reset: what nobody wrote means nothing.

`default_nettype none

module wh_port_settings #(
    parameter integer N          = 1,                       // ports, 1...12
    parameter integer WORDS_LOG2 = 4,                       // words of a port, 2^this: 0...6
    parameter integer W          = 31,                      // bits of a word, 1...32
    parameter integer FIRST      = 0,                       // place of the first, a multiple of the words: 0...255
    parameter integer BLOCK      = 1,                       // 1: in a block RAM, 0: in the FPGA's LUTs
    parameter integer PORT_W     = (N > 1) ? $clog2(N) : 1, // these two are derived, leave them
    parameter integer WORD_W     = (WORDS_LOG2 > 0) ? WORDS_LOG2 : 1
) (
    input  wire              clk,

    // The register bus.
    input  wire              write_i,    // strobe
    input  wire              write_bank_i,
    input  wire [11:0]       address_i,  // part and place
    input  wire [31:0]       data_i,

    // The station.
    input  wire              read_i,
    input  wire              bank_i,
    input  wire [PORT_W-1:0] port_i,
    input  wire [WORD_W-1:0] word_i,
    output wire [W-1:0]      word_o
);

    localparam integer PLACE_W = ((N > 1) ? PORT_W : 0) + WORDS_LOG2 + 1;
    localparam [7:0]   FIRST_PLACE = FIRST[7:0];

    generate
        if (N < 1 || N > 12 || W < 1 || W > 32 || WORDS_LOG2 < 0 || WORDS_LOG2 > 6 || FIRST < 0 || FIRST > 255
            || FIRST % (1 << WORDS_LOG2) != 0) begin : illegal
            wh_illegal_parameter_port_settings_n_w_words_log2_or_first stop ();
        end
        if (BLOCK != 0 && BLOCK != 1) begin : illegal_block
            wh_illegal_parameter_port_settings_block_must_be_0_or_1 stop ();
        end
    endgenerate

    // Its part is 1...8, of which the lowest bits less 1 are the port.
    wire [3:0]         part  = address_i[11:8] - 4'd1;
    wire               here  = address_i[7:WORDS_LOG2] == FIRST_PLACE[7:WORDS_LOG2] && {28'd0, part} < N;
    wire [PLACE_W-1:0] write_place;
    wire [PLACE_W-1:0] read_place;

    generate
        if (N > 1 && WORDS_LOG2 > 0) begin : several
            assign write_place = {write_bank_i, part[PORT_W-1:0], address_i[WORD_W-1:0]};
            assign read_place  = {bank_i, port_i, word_i};
        end else if (N > 1) begin : several_of_one_word
            wire unused = &{1'b0, word_i};

            assign write_place = {write_bank_i, part[PORT_W-1:0]};
            assign read_place  = {bank_i, port_i};
        end else if (WORDS_LOG2 > 0) begin : one
            wire unused = &{1'b0, port_i};

            assign write_place = {write_bank_i, address_i[WORD_W-1:0]};
            assign read_place  = {bank_i, word_i};
        end else begin : one_word
            wire unused = &{1'b0, port_i, word_i};

            assign write_place = write_bank_i;
            assign read_place  = bank_i;
        end
    endgenerate

    // Never written where it is read: these are two banks. A few short words aren't worth a block RAM.
    reg [W-1:0] word_q;

    generate
        if (BLOCK == 1) begin : in_block_ram
            (* ram_style = "block", no_rw_check *)
            reg [W-1:0] words [0:(1<<PLACE_W)-1];

            always @(posedge clk) begin
                if (write_i && here) begin
                    words[write_place] <= data_i[W-1:0];
                end
                if (read_i) begin
                    word_q <= words[read_place];
                end
            end
        end else begin : in_luts
            (* no_rw_check *)
            reg [W-1:0] words [0:(1<<PLACE_W)-1];

            always @(posedge clk) begin
                if (write_i && here) begin
                    words[write_place] <= data_i[W-1:0];
                end
                if (read_i) begin
                    word_q <= words[read_place];
                end
            end
        end
        if (W < 32) begin : short_words
            wire unused_high = &{1'b0, data_i[31:W]};
        end
    endgenerate

    assign word_o = word_q;

endmodule

`default_nettype wire
