// SPDX-License-Identifier: Apache-2.0
//
// wh_surface_frame: a frame of surfaces as a computer writes it over the register bus, on its way to wh_surface_words.
//
//   surface_word: runs of words, one after another      run: a head, then as many words as it says
//   surface_commit: the frame's end, with its stamp
//
// A head: 31 a frame begins, and what was written of another one is dropped; 15:10 words that follow; 9:0 the address
// of the first one (wh_surface_words). The others have the addresses after it. It doesn't matter to which of the
// addresses of surface_word something is written, so one write of consecutive registers can have several runs, and end
// with the commit. A frame may come in several writes.
//
// A commit of a frame that didn't begin, or in the midst of a run, is refused, with row 127. An accepted one is a sign
// of life of the host, and its stamp is in stamp_o.
//
// hold_o: the bus has to wait, no longer than HOLD clocks for each word, and until free_i.
// Latency: from word_i to write_o 1 clock while free_i. Reset: no frame, stamp 0.

`default_nettype none
`include "wh_formats.vh"

module wh_surface_frame (
    input  wire        clk,
    input  wire        rst,

    // Registers.
    input  wire        word_i,      // strobe
    input  wire        commit_i,    // strobe
    input  wire [31:0] data_i,
    output wire        hold_o,
    output wire [15:0] stamp_o,     // of the last accepted frame
    output wire        alive_o,     // strobe

    // wh_surface_words.
    input  wire        free_i,      // it takes data_o in this clock
    output wire        write_o,     // strobe
    output wire [9:0]  address_o,
    output wire [31:0] data_o,
    output wire        commit_o,    // strobe
    input  wire        refused_i
);

    localparam integer HOLD   = `WH_COEF_W + 6;  // clocks of a square, and of storing a vector
    localparam integer HOLD_W = $clog2(HOLD + 1);
    localparam [9:0]   BEGIN   = {7'd126, 3'd0};
    localparam [9:0]   NOWHERE = {7'd127, 3'd7};

    reg               open_q;     // a frame has begun
    reg [5:0]         left_q;     // words of the run that are still to come
    reg [9:0]         next_q;     // the address of the next one
    reg               write_q;    // a word waits
    reg [9:0]         address_q;
    reg [31:0]        data_q;
    reg               commit_q;   // a commit waits, behind the word
    reg               ends_q;     // a commit was done
    reg [15:0]        coming_q;
    reg [15:0]        stamp_q;
    reg [HOLD_W-1:0]  hold_q;

    wire              head   = left_q == 6'd0;
    wire              begins = head && data_i[31];

    assign hold_o    = word_i || commit_i || write_q || commit_q || (|hold_q);
    assign write_o   = write_q && free_i;
    assign address_o = address_q;
    assign data_o    = data_q;
    assign commit_o  = commit_q && !write_q && hold_q == {HOLD_W{1'b0}};
    assign stamp_o   = stamp_q;
    assign alive_o   = ends_q && !refused_i;

    always @(posedge clk) begin
        hold_q <= write_o ? HOLD[HOLD_W-1:0] : (|hold_q) ? hold_q - {{(HOLD_W - 1){1'b0}}, 1'b1} : hold_q;
        ends_q <= commit_o;
        if (write_o) begin
            write_q <= 1'b0;
        end
        if (commit_o) begin
            commit_q <= 1'b0;
        end
        if (alive_o) begin
            stamp_q <= coming_q;
        end
        if (word_i) begin
            data_q <= data_i;
            if (head) begin
                open_q    <= open_q || begins;
                left_q    <= data_i[15:10];
                next_q    <= data_i[9:0];
                write_q   <= begins || !open_q;
                address_q <= begins ? BEGIN : NOWHERE;
            end else begin
                left_q    <= left_q - 6'd1;
                next_q    <= next_q + 10'd1;
                write_q   <= 1'b1;
                address_q <= open_q ? next_q : NOWHERE;
            end
        end
        if (commit_i) begin
            commit_q  <= 1'b1;
            coming_q  <= data_i[15:0];
            write_q   <= !open_q || !head;  // a word that is refused
            address_q <= NOWHERE;
            open_q    <= 1'b0;
            left_q    <= 6'd0;
        end
        if (rst) begin
            open_q   <= 1'b0;
            left_q   <= 6'd0;
            write_q  <= 1'b0;
            commit_q <= 1'b0;
            ends_q   <= 1'b0;
            stamp_q  <= 16'd0;
            hold_q   <= {HOLD_W{1'b0}};
        end
    end

endmodule

`default_nettype wire
