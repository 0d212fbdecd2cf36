// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_tick_words: a reader that chooses, whoever else there is and however soon ticks follow, has the words of
// one tick, those of the strobe that came last when nobody was reading; it is given them when it wants them, and
// never both at once. Readers keep to the page: one that was given words chooses from the next clock on for as
// long as it likes, and nobody else does. Proven by induction, smtbmc z3.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module prove_wh_tick_words (
    input wire                    clk,
    input wire                    rst,
    input wire                    tick,
    input wire                    valid,
    input wire [9*`WH_DATA_W-1:0] words,
    input wire [`WH_COUNT_W-1:0]  position,
    input wire [7:0]              flags,
    input wire [1:0]              want,
    input wire [1:0]              more,   // a reader chooses on
    input wire [23:0]             code
);

    wire        strobe;
    wire [1:0]  take;
    wire [31:0] word;
    wire        mean;
    wire        any;
    reg  [1:0]  reads;

    wh_tick_words block (
        .clk          (clk),
        .rst          (rst),
        .tick_i       (tick),
        .valid_i      (valid),
        .voltage_i    (words[0*`WH_DATA_W +: `WH_DATA_W]),
        .u_i          (words[1*`WH_DATA_W +: `WH_DATA_W]),
        .v_i          (words[2*`WH_DATA_W +: `WH_DATA_W]),
        .current_i    (words[3*`WH_DATA_W +: `WH_DATA_W]),
        .position_i   (position),
        .correction_i (words[4*`WH_DATA_W +: `WH_DATA_W]),
        .offset_i     (words[5*`WH_DATA_W +: `WH_DATA_W]),
        .flux_i       (words[6*`WH_DATA_W +: `WH_DATA_W]),
        .lag_i        (words[7*`WH_DATA_W +: `WH_DATA_W]),
        .flags_i      (flags),
        .bus_i        (words[8*`WH_DATA_W +: `WH_BUS_W]),
        .faults_i     (position[`WH_FAULTS-1:0]),
        .want_i       (want),
        .reads_i      (reads),
        .code_i       (code),
        .strobe_o     (strobe),
        .take_o       (take),
        .word_o       (word),
        .mean_o       (mean),
        .any_o        (any)
    );

    (* hierconn *) wire                   \block.second_q ;
    (* hierconn *) wire [`WH_DATA_W-1:0]  \block.current_q ;
    (* hierconn *) wire [`WH_COUNT_W-1:0] \block.position_q ;

    wire second = \block.second_q ;
    reg  [11:0] chosen;  // a clock ago, by who reads now
    wire [`WH_DATA_W-1:0] current = words[3*`WH_DATA_W +: `WH_DATA_W];

    // The tick's, by who listens: of the last strobe with which somebody was given words.
    reg                   begun = 1'b0;
    reg                   rst_q;
    reg                   kept;    // there was one
    reg [`WH_DATA_W-1:0]  current_q;
    reg [`WH_COUNT_W-1:0] position_q;
    reg                   first_q; // reader 0 was given them

    always @(posedge clk) begin
        begun  <= 1'b1;
        chosen <= (take[1] || (reads[1] && more[1])) ? code[23:12] : code[11:0];
        rst_q <= rst;
        reads <= rst ? 2'b00 : take | (reads & more);
        kept  <= !rst && (kept || (strobe && (|take)));
        if (strobe && (|take) && !second) begin
            current_q  <= current;
            position_q <= position;
            first_q    <= take[0];
        end

        if (!begun) begin
            assume (rst);
        end else begin
            if (rst_q) assert (!second && reads == 2'b00);

            assert ((take & ~want) == 2'b00);
            assert (take != 2'b11);
            if (take[0]) assert (strobe && reads == 2'b00 && !second);
            if (take[1]) assert (!reads[0] && (strobe || second));
            assert (reads != 2'b11 && !(second && reads[1]));
            // Who waits is behind reader 0, which was given the words then.
            if (second) assert (kept && first_q);
            if (|reads) assert (kept);

            if (kept) begin
                assert (\block.current_q == current_q && \block.position_q == position_q);
            end
            if (|reads) begin
                if (chosen == 12'h1b3) begin
                    assert (word == {{32-`WH_DATA_W{current_q[`WH_DATA_W-1]}}, current_q} && mean && !any);
                end
                if (chosen == 12'h1b4) begin
                    assert (word == {{32-`WH_COUNT_W{position_q[`WH_COUNT_W-1]}}, position_q} && !mean && !any);
                end
                if (chosen[11:8] > 4'd1) assert (word == 32'd0);
            end

            // Nobody waits for ever: who wants has the words when reader 0 has chosen.
            if (strobe && reads == 2'b00 && !second) assert (want == 2'b00 || take == (want[0] ? 2'b01 : 2'b10));
            if (second && !reads[0] && want[1]) assert (take[1]);

            cover (reads[1] && strobe && first_q);
            cover (take[1] && strobe && !second);
        end
    end

endmodule

`default_nettype wire
