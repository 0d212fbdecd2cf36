// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_round_words: of one value of a port, which may be the position or ω̂, and whatever readers there are: who
// chooses reads it as it came in the round that ended last as nobody was reading, ω̂ as 0 where that round's step had
// no end; it is given the round when it wants it, and never both at once. Rounds keep to the schedule of wh_slots,
// readers to the page: one that was given a round chooses for 9 clocks at most. The memory has the value's place in
// either bank (any_register_ram); the invariant says what stands there. Proven by induction, smtbmc z3.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module prove_wh_round_words (
    input wire                  clk,
    input wire                  rst,
    input wire                  live_valid,
    input wire [3:0]            live_word,
    input wire [31:0]           live_data,
    input wire [`WH_BUS_W-1:0]  bus,
    input wire [`WH_FAULTS-1:0] faults,
    input wire [1:0]            want,
    input wire [1:0]            more,   // a reader chooses on
    input wire [23:0]           code
);

    localparam [5:0] TAIL  = 6'd29;  // clocks from the flags to the round's end,
    localparam [5:0] NEXT  = 6'd31;  // to the next round's first value,
    localparam [5:0] AGAIN = 6'd38;  // and to the next flags

    wire        contact, strobe, mean, any;
    wire [1:0]  take;
    wire [31:0] word;
    reg  [1:0]  reads;

    wh_round_words block (
        .clk          (clk),
        .rst          (rst),
        .live_valid_i (live_valid),
        .live_port_i  (1'b0),
        .live_word_i  (live_word),
        .live_data_i  (live_data),
        .bus_i        (bus),
        .faults_i     (faults),
        .contact_o    (contact),
        .want_i       (want),
        .reads_i      (reads),
        .code_i       (code),
        .strobe_o     (strobe),
        .take_o       (take),
        .word_o       (word),
        .mean_o       (mean),
        .any_o        (any)
    );

    (* hierconn *) wire        \block.second_q ;
    (* hierconn *) wire        \block.bank_q ;
    (* hierconn *) wire [4:0]  \block.tail_q ;
    (* hierconn *) wire [1:0]  \block.step_q ;
    (* hierconn *) wire        \block.stepped_q ;
    (* hierconn *) wire [4:0]  \block.values.place ;
    (* hierconn *) wire [31:0] \block.values.word_q ;

    wire        second   = \block.second_q ;
    wire        bank     = \block.bank_q ;
    wire [3:0]  value    = \block.values.place [3:0];
    wire        of_step  = (value == `WH_LIVE_LAG);
    wire [11:0] its_code = of_step ? 12'h1c3 : 12'h1b4;

    reg         begun = 1'b0;
    reg         rst_q;
    reg  [5:0]  age_q;     // clocks since the flags, AGAIN at most
    reg         came_q;    // the value did, in this round
    reg  [31:0] now_q;
    reg  [1:0]  step_q;    // ω̂ and c did
    reg         ended_q;   // a round has ended since reset,
    reg  [31:0] last_q;    // its value, at its place in the other bank,
    reg         whole_q;   // and its step had an end
    reg  [5:0]  reading_q; // clocks since the round's end, AGAIN at most
    reg         second_at; // reader 0 was given the round
    reg  [11:0] chosen;    // a clock ago, by who reads now
    reg         watched;   // and the bank is the place's

    wire        flags    = live_valid && live_word == `WH_LIVE_FLAGS;
    wire        its      = live_valid && live_word == value;
    wire [31:0] expected = (of_step && !whole_q) ? 32'd0 : last_q;

    // ---- The invariant.
    wire clocks = age_q != 6'd0 && age_q <= AGAIN && reading_q != 6'd0 && reading_q <= AGAIN
                  && (!ended_q || (age_q <= TAIL ? reading_q == AGAIN || reading_q >= age_q + 6'd9
                                   : reading_q >= age_q - TAIL));
    wire turns  = (!(|reads || second) || ended_q) && (!reads[0] || (second_at && reading_q <= 6'd9))
                  && (!second || (second_at && reading_q <= 6'd10)) && (!reads[1] || reading_q <= 6'd18)
                  && reads != 2'b11 && !(second && reads[1]);
    wire tail   = \block.tail_q == ((age_q <= TAIL) ? TAIL[4:0] + 5'd1 - age_q[4:0] : 5'd0);
    wire step   = \block.step_q == step_q && (!ended_q || \block.stepped_q == whole_q);
    wire came   = of_step ? came_q == step_q[1] : age_q > TAIL || came_q;
    wire stands = (!came_q || \block.values.place [4] != bank || \block.values.word_q == now_q)
                  && (!ended_q || (of_step && !whole_q) || \block.values.place [4] == bank
                      || \block.values.word_q == last_q);
    wire invariant = clocks && turns && tail && step && came && stands;

    always @(posedge clk) begin
        begun  <= 1'b1;
        rst_q  <= rst;
        reads  <= rst ? 2'b00 : take | (reads & more);
        chosen <= (take[1] || (reads[1] && more[1])) ? code[23:12] : code[11:0];
        watched <= (\block.values.place [4] == (strobe ? bank : !bank));
        age_q  <= rst ? AGAIN : flags ? 6'd1 : (age_q == AGAIN) ? AGAIN : age_q + 6'd1;
        reading_q <= (rst || !(strobe || ended_q)) ? AGAIN : strobe ? 6'd1 : (reading_q == AGAIN) ? AGAIN
                     : reading_q + 6'd1;
        came_q <= !rst && !strobe && (came_q || its);
        step_q <= rst ? 2'b00 : {live_valid && live_word == `WH_LIVE_LAG, live_valid && live_word == `WH_LIVE_CORRECTION}
                  | (strobe ? 2'b00 : step_q);
        if (its) now_q <= live_data;
        if (strobe) begin
            last_q    <= now_q;
            whole_q   <= &step_q;
            second_at <= take[0];
        end
        ended_q <= !rst && (ended_q || strobe);

        assume (value == `WH_LIVE_POSITION || value == `WH_LIVE_LAG);
        // The schedule: position before the flags, ω̂ and c after them, and a pause between two rounds.
        if (live_valid && live_word == `WH_LIVE_POSITION) assume (age_q >= NEXT);
        if (live_valid && (live_word == `WH_LIVE_LAG || live_word == `WH_LIVE_CORRECTION)) begin
            assume (age_q < TAIL);
        end
        if (flags) assume (age_q >= AGAIN && (of_step || came_q));
        // A reader chooses for 9 clocks at most, the second one behind the first.
        if (reading_q >= (second_at ? 6'd9 : 6'd18)) assume ((reads & more & 2'b01) == 2'b00);
        if (reading_q >= 6'd18) assume ((reads & more) == 2'b00);

        if (!begun) begin
            assume (rst || invariant);
        end else begin
            if (rst_q) assert (!second && reads == 2'b00 && !strobe);

            assert ((take & ~want) == 2'b00);
            assert (take != 2'b11);
            if (take[0]) assert (strobe && reads == 2'b00 && !second);
            if (take[1]) assert (!reads[0] && (strobe || second));
            if (strobe && reads == 2'b00 && !second) assert (want == 2'b00 || take == (want[0] ? 2'b01 : 2'b10));
            if (second && !reads[0] && want[1]) assert (take[1]);

            assert (clocks);
            assert (turns);
            assert (tail);
            assert (step);
            assert (came);
            assert (stands);

            // What is read.
            if (|reads && chosen == its_code && watched) begin
                assert (word == expected && any == 1'b0 && mean == of_step);
            end
            if (|reads && chosen[11:8] > 4'd1) assert (word == 32'd0);

            cover (reads[1] && second_at && chosen == its_code && watched && word != 32'd0);
            cover (take[1] && strobe);
        end
    end

endmodule

`default_nettype wire
