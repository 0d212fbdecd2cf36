// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_setting_group: of a staged group, its words change together, in the clock after change_i and in no other,
// to those that were copied last for their addresses. Of a group without staging, a word changes when it is copied,
// alone. Whatever copy_i and change_i do.
// Proven by induction, smtbmc z3.

`default_nettype none

module prove_wh_setting_group (
    input wire        clk,
    input wire        copy,
    input wire [11:0] address,
    input wire [31:0] data,
    input wire        change
);

    localparam [11:0] FIRST = 12'h050;

    wire [40:0] words;
    wire [40:0] plain;

    wh_setting_group #(
        .FIRST     (FIRST[7:0]),
        .WORDS     (3),
        .WIDTHS    ({8'd1, 8'd32, 8'd8}),
        .TOTAL_W   (41)
    ) block (
        .clk       (clk),
        .copy_i    (copy),
        .address_i (address),
        .data_i    (data),
        .change_i  (change),
        .words_o   (words)
    );

    wh_setting_group #(
        .STAGED    (0),
        .FIRST     (FIRST[7:0]),
        .WORDS     (3),
        .WIDTHS    ({8'd1, 8'd32, 8'd8}),
        .TOTAL_W   (41)
    ) unstaged (
        .clk       (clk),
        .copy_i    (copy),
        .address_i (address),
        .data_i    (data),
        .change_i  (change),
        .words_o   (plain)
    );

    // What the addresses hold, as a listener finds it.
    reg         begun = 1'b0;
    reg  [40:0] told_q;
    reg  [2:0]  known_q;    // told since the beginning
    reg  [40:0] words_q;
    reg  [40:0] plain_q;
    reg  [40:0] before_q;   // told, a clock before
    reg  [2:0]  known_before_q;
    reg         change_q;
    reg  [40:0] copied_q;   // the words of the group without staging, with the one that was copied

    wire [2:0]  mine   = {address == FIRST + 12'd2, address == FIRST + 12'd1, address == FIRST};
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
        told_q         <= copy ? (told_q & ~mask) | (value & mask) : told_q;
        known_q        <= !begun ? 3'd0 : copy ? known_q | mine : known_q;
        before_q       <= told_q;
        known_before_q <= !begun ? 3'd0 : known_q;
        change_q       <= change;
        words_q        <= words;
        plain_q        <= plain;
        copied_q       <= copy ? (plain & ~mask) | (value & mask) : plain;

        if (!begun) begin
            assume (known_q == 3'd0);
        end else begin
            if (!change_q) assert (words == words_q);
            if (change_q) assert ((words & known_mask) == (before_q & known_mask));
            assert (plain == copied_q);

            assert ((staged & heard) == (told_q & heard));
        end

        cover (begun && known_q == 3'd7 && change_q && words != words_q
               && words[7:0] != words_q[7:0] && words[39:8] != words_q[39:8]);
        cover (begun && change_q && copy && (|mine));
        cover (begun && plain != plain_q);
    end

endmodule

`default_nettype wire
