// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_setting_group: of a staged group, its words change together in one clock, to those that were
// accepted or copied last for their addresses, while change_i is high and never while hold_i is. pending_o
// is high from a write of one of its words (or reset) until then, or until discard_i, and at no other time.
// Of a group without staging, a word changes when it is copied, alone, and never while hold_i is high.
// Whatever write_i, copy_i, change_i, discard_i and hold_i do.
// Proven by induction, smtbmc z3.

`default_nettype none

module prove_wh_setting_group (
    input wire        clk,
    input wire        rst,
    input wire        write,
    input wire        copy,
    input wire [11:0] address,
    input wire [31:0] data,
    input wire        change,
    input wire        discard,
    input wire        hold
);

    localparam [11:0] FIRST  = 12'h250;
    localparam [11:0] STRIDE = 12'h003;

    wire        pending;
    wire        no_pending;
    wire [40:0] words;
    wire [40:0] plain;

    wh_setting_group #(
        .PART      (FIRST[11:8]),
        .FIRST     (FIRST[7:0]),
        .STRIDE    (STRIDE[7:0]),
        .WORDS     (3),
        .WIDTHS    ({8'd1, 8'd32, 8'd8}),
        .TOTAL_W   (41)
    ) block (
        .clk       (clk),
        .rst       (rst),
        .write_i   (write),
        .copy_i    (copy),
        .address_i (address),
        .data_i    (data),
        .change_i  (change),
        .discard_i (discard),
        .hold_i    (hold),
        .pending_o (pending),
        .words_o   (words)
    );

    wh_setting_group #(
        .STAGED    (0),
        .PART      (FIRST[11:8]),
        .FIRST     (FIRST[7:0]),
        .STRIDE    (STRIDE[7:0]),
        .WORDS     (3),
        .WIDTHS    ({8'd1, 8'd32, 8'd8}),
        .TOTAL_W   (41)
    ) unstaged (
        .clk       (clk),
        .rst       (rst),
        .write_i   (write),
        .copy_i    (copy),
        .address_i (address),
        .data_i    (data),
        .change_i  (change),
        .discard_i (discard),
        .hold_i    (hold),
        .pending_o (no_pending),
        .words_o   (plain)
    );

    // What the addresses hold, as a listener finds it.
    reg         begun = 1'b0;
    reg  [40:0] told_q;
    reg  [2:0]  known_q;    // told since reset
    reg         due_q;      // written, and neither changed nor discarded
    reg  [40:0] words_q;
    reg  [40:0] plain_q;
    reg  [40:0] before_q;   // told, a clock before
    reg  [2:0]  known_before_q;
    reg         hold_q;
    reg         asked_q;    // change_i a clock before
    reg         copied_q;
    reg  [40:0] copied_words_q;
    reg         rst_q;

    wire [2:0]  mine   = {address == FIRST + 2 * STRIDE, address == FIRST + STRIDE,
                          address == FIRST};
    wire        listen = write || copy;
    wire [40:0] mask   = {mine[2], {32{mine[1]}}, {8{mine[0]}}};
    wire [40:0] value  = {data[0], data, data[7:0]};
    wire [40:0] known_mask = {known_before_q[2], {32{known_before_q[1]}}, {8{known_before_q[0]}}};

    (* hierconn *) wire [7:0]  \block.word[0].staged.staged_q ;
    (* hierconn *) wire [31:0] \block.word[1].staged.staged_q ;
    (* hierconn *) wire        \block.word[2].staged.staged_q ;

    wire [40:0] staged = {\block.word[2].staged.staged_q , \block.word[1].staged.staged_q ,
                          \block.word[0].staged.staged_q };
    wire [40:0] heard  = {known_q[2], {32{known_q[1]}}, {8{known_q[0]}}};

    always @(posedge clk) begin
        begun          <= 1'b1;
        rst_q          <= rst;
        told_q         <= listen ? (told_q & ~mask) | (value & mask) : told_q;
        known_q        <= !begun ? 3'd0 : listen ? known_q | mine : known_q;
        before_q       <= told_q;
        known_before_q <= !begun ? 3'd0 : known_q;
        due_q          <= rst || (write && (|mine)) || (due_q && !(change && !hold) && !discard);
        asked_q        <= change;
        hold_q         <= hold;
        words_q        <= words;
        plain_q        <= plain;
        copied_q       <= copy;
        copied_words_q <= copy ? (plain & ~mask) | (value & mask) : plain;

        if (!begun) begin
            assume (rst && due_q == pending && known_q == 3'd0);
        end else begin
            assert (no_pending == 1'b0);
            assert (pending == due_q);
            if (hold_q) assert (words == words_q && plain == plain_q);
            if (!asked_q) assert (words == words_q);
            if (asked_q && !hold_q) assert ((words & known_mask) == (before_q & known_mask));
            if (!hold_q) assert (plain == copied_words_q);

            assert ((staged & heard) == (told_q & heard));
        end

        cover (begun && known_q == 3'd7 && !rst_q && asked_q && !hold_q && words != words_q
               && words[7:0] != words_q[7:0] && words[39:8] != words_q[39:8]);
        cover (begun && due_q && asked_q && hold_q && pending);
        cover (begun && asked_q && hold_q && !pending && !rst_q);
        cover (begun && copied_q && plain != plain_q);
    end

endmodule

`default_nettype wire
