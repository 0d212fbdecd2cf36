// SPDX-License-Identifier: Apache-2.0
//
// wh_surface_words: what a computer has written of a group's surfaces, in two banks, and the check of it.
//
//   word_o = word word_i of row row_i in the bank in force;  a row: 8 words of 32 bits
//
// A frame: words are written into the other bank, then commit_i. With the next take_i that bank is in force, as a
// whole. A frame names its surfaces: whichever PRESENT it doesn't write isn't there. Of those that are there it has
// to write every word. A write of BEGIN, which may come first, drops what was written since the last commit.
//
// No word that could give out energy gets into the memory. A vector is written as words 0, 1, 2 of its row, one after
// the other, and stored with the third, where
//
//   g_0^2 + g_1^2 + g_2^2 <= 1,   exactly
//
// and A in [0, 1], ETA in [-1, 1], ACROSS in [0, 1], VELOCITY_MAX >= 0. What is beyond that, or elsewhere, or
// written while busy_o, isn't stored, and the frame is refused with its commit: refused_o is 1 until one is accepted,
// and refused_row_o is the row of the first word that was refused. A commit while busy_o is refused with row 127.
//
// Rows, with s, t, r = surfaces in ascending order:
//
//   s                                       vector of s alone: words 0...2 g, s27q25; 3...5 shares of the set's
//   8 + t (t - 1)/2 + s                     of t beside s                            wall velocities, s30q25
//   36 + r (r - 1)(r - 2)/6 + t (t - 1)/2 + s    of r beside both
//   96 + 2 s      0: whole counts of d, s32; 1: PRESENT (bit 8), d's fraction (u8q8); 2...4: G, s27q25;
//                 5...7: C, s32q17 counts/A
//   97 + 2 s      0: GAIN, s32q30 √W/count; 1: A; 2: ETA; 3: ACROSS, s27q25
//   112           0: VELOCITY_MAX, s31q23 √W
//   126           0: BEGIN, any word
//
// A word shorter than 32 bits is sign-extended. The binary points are for WH_COEF_W = 27.
// busy_o is 1 while a square is made, WH_COEF_W clocks after each component and 3 more after the third, and from a
// commit until the bank is taken.
// Latency: word_o 1 clock. Reset: no surface is there; what was stored stays, and was accepted.

`default_nettype none
`include "wh_formats.vh"

module wh_surface_words (
    input  wire        clk,
    input  wire        rst,

    // The computer.
    input  wire        write_i,    // strobe
    input  wire [9:0]  address_i,  // row, word
    input  wire [31:0] data_i,
    input  wire        commit_i,   // strobe, while not busy_o
    output wire        busy_o,
    output wire        refused_o,
    output wire [6:0]  refused_row_o,

    // wh_surfaces.
    input  wire        take_i,     // strobe: a round begins
    input  wire [6:0]  row_i,
    input  wire [2:0]  word_i,
    output wire [31:0] word_o,
    output wire [7:0]  present_o
);

    localparam integer Q      = `WH_SURFACE_Q;
    localparam integer SIZE_W = Q + 1;       // |g|
    localparam integer SUM_W  = 2 * Q + 3;   // 1 less three squares

    // ---- What a word is.
    wire [6:0] row    = address_i[9:3];
    wire [2:0] word   = address_i[2:0];
    wire       vector = row < 7'd96;
    wire       plane  = row[6:4] == 3'b110;
    wire       g_word = vector && word < 3'd3;
    wire [3:0] place  = {row[0], word};      // of a plane's word
    wire       most   = row == 7'd112 && word == 3'd0;
    wire       begins = row == 7'd126 && word == 3'd0;

    wire              negative = data_i[31];
    wire [31:0]       size     = negative ? -data_i : data_i;
    wire              beyond   = (|size[31:Q+1]) || (size[Q] && (|size[Q-1:0]));  // |data| > 1

    // In its range, but for the sum of a vector's squares.
    reg legal;

    always @* begin
        legal = 1'b0;
        if (vector) begin
            legal = (word < 3'd3) ? !beyond : word < 3'd6;
        end else if (plane) begin
            case (place)
                4'd2, 4'd3, 4'd4: legal = (&data_i[31:`WH_COEF_W-1]) || !(|data_i[31:`WH_COEF_W-1]);
                4'd9, 4'd11:      legal = !beyond && !negative;
                4'd10:            legal = !beyond;
                default:          legal = place < 4'd9;
            endcase
        end else begin
            legal = begins || (most && !(|data_i[31:`WH_DATA_W-1]));
        end
    end

    // ---- The squares of a vector, one bit of a component after the other.
    reg [1:0]               next_q;    // which component is to come
    reg [6:0]               row_q;
    reg [`WH_COEF_W-1:0]    g0_q, g1_q, g2_q;
    reg [4:0]               left_q;    // bits of a square that are still to come
    reg [SIZE_W-1:0]        size_q;
    reg [SIZE_W-1:0]        bits_q;
    reg [2*Q+1:0]           square_q;
    reg signed [SUM_W-1:0]  sum_q;
    reg                     squares_q; // in the midst of it
    reg                     ends_q;
    reg [1:0]               stores_q;  // words that are still to be stored

    // ---- Banks.
    reg       bank_q;     // in force
    reg       pending_q;
    reg       bad_q;
    reg       refused_q;
    reg [6:0] bad_row_q;
    reg [6:0] refused_row_q;
    reg [7:0] present_q;
    reg [7:0] coming_q;   // of the other bank

    assign busy_o    = squares_q || ends_q || (|stores_q) || pending_q;
    assign present_o = present_q;

    assign refused_o     = refused_q;
    assign refused_row_o = refused_row_q;

    localparam [SUM_W-1:0] ONE = {{(SUM_W - 1){1'b0}}, 1'b1} << (2 * Q);

    wire              takes  = write_i && !busy_o;
    wire              starts = takes && g_word && legal && (word == 3'd0 || (word[1:0] == next_q && row == row_q));
    wire signed [SUM_W-1:0] rest = sum_q - $signed({1'b0, square_q});
    wire              too_long = ends_q && next_q == 2'd3 && rest[SUM_W-1];
    wire              wrong    = (write_i && (busy_o || !legal || (g_word && !starts))) || too_long;

    always @(posedge clk) begin
        ends_q <= 1'b0;
        if (starts) begin
            row_q     <= row;
            size_q    <= size[SIZE_W-1:0];
            bits_q    <= size[SIZE_W-1:0];
            square_q  <= {(2*Q+2){1'b0}};
            left_q    <= SIZE_W[4:0];
            squares_q <= 1'b1;
            next_q    <= word[1:0] + 2'd1;
            if (word == 3'd0) begin
                sum_q <= $signed(ONE);
                g0_q  <= data_i[`WH_COEF_W-1:0];
            end else if (word == 3'd1) begin
                g1_q  <= data_i[`WH_COEF_W-1:0];
            end else begin
                g2_q  <= data_i[`WH_COEF_W-1:0];
            end
        end else if (takes && g_word) begin
            next_q <= 2'd3;
        end
        if (squares_q) begin
            square_q <= {square_q[2*Q:0], 1'b0} + (bits_q[SIZE_W-1] ? {{(Q+1){1'b0}}, size_q} : {(2*Q+2){1'b0}});
            bits_q   <= {bits_q[SIZE_W-2:0], 1'b0};
            left_q   <= left_q - 5'd1;
            if (left_q == 5'd1) begin
                squares_q <= 1'b0;
                ends_q    <= 1'b1;
            end
        end
        if (ends_q) begin
            sum_q <= rest;
        end
        stores_q <= (ends_q && next_q == 2'd3 && !rest[SUM_W-1]) ? 2'd3
                    : (stores_q != 2'd0)                         ? stores_q - 2'd1 : 2'd0;

        if (wrong || (commit_i && busy_o)) begin
            bad_q <= 1'b1;
        end
        if (wrong && !bad_q) begin
            bad_row_q <= too_long ? row_q : row;
        end
        if (takes && begins) begin
            bad_q    <= 1'b0;
            coming_q <= 8'd0;
            next_q   <= 2'd3;
        end
        if (takes && legal && plane && place == 4'd1) begin
            coming_q[row[3:1]] <= data_i[8];
        end
        if (commit_i && !busy_o) begin
            pending_q     <= !bad_q;
            refused_q     <= bad_q;
            refused_row_q <= bad_row_q;
            bad_q         <= 1'b0;
            next_q        <= 2'd3;
            if (bad_q) begin
                coming_q <= 8'd0;
            end
        end
        if (commit_i && busy_o) begin
            refused_q     <= 1'b1;
            refused_row_q <= 7'd127;
        end
        if (take_i && pending_q) begin
            bank_q    <= !bank_q;
            present_q <= coming_q;
            coming_q  <= 8'd0;
            pending_q <= 1'b0;
        end

        if (rst) begin
            next_q    <= 2'd3;
            squares_q <= 1'b0;
            ends_q    <= 1'b0;
            stores_q  <= 2'd0;
            bank_q    <= 1'b0;
            pending_q <= 1'b0;
            bad_q     <= 1'b0;
            refused_q <= 1'b0;
            present_q <= 8'd0;
            coming_q  <= 8'd0;
        end
    end

    // ---- The memory. What a computer writes is stored at once, and a vector with its third component.
    wire        stores = stores_q != 2'd0;
    wire        writes = stores || (takes && legal && !g_word);
    wire [1:0]  store  = 2'd3 - stores_q;
    wire [`WH_COEF_W-1:0] g = (store == 2'd0) ? g0_q : (store == 2'd1) ? g1_q : g2_q;
    wire [31:0] data   = stores                     ? {{(32 - `WH_COEF_W){g[`WH_COEF_W-1]}}, g}
                         : (plane && place == 4'd1) ? {24'd0, data_i[7:0]} : data_i;
    wire [10:0] write_place = {!bank_q, stores ? {row_q, 1'b0, store} : address_i};
    wire [10:0] read_place  = {bank_q ^ (take_i && pending_q), row_i, word_i};

    (* ram_style = "block", no_rw_check *)
    reg [31:0] words [0:2047];
    reg [31:0] word_q;
    integer    n;

    // A vector that nobody wrote reflects nothing.
    initial begin
        for (n = 0; n < 2048; n = n + 1) begin
            words[n] = 32'd0;
        end
    end

    always @(posedge clk) begin
        if (writes) begin
            words[write_place] <= data;
        end
        word_q <= words[read_place];
    end

    assign word_o = word_q;

endmodule

`default_nettype wire
