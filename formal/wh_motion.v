// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_motion: of two ports, the one that is watched. Its position is outside exactly if the last one that was
// judged is; its speed is too high exactly if it went further than its limit, in whole words, in the present span or
// the last one. A restart forgets neither, and the span that it begins has no way from before it. The outputs are
// of any port. The watched port's limits are any constants, all else does what it likes; from a turn to the next
// a port moves by less than 2^16 counts, unless there was a restart.
// Mode prove, depth 4; cover and mutants with a span of two rounds.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module prove_wh_motion #(
    parameter integer SPAN_LOG2 = `WH_SPAN_LOG2
) (
    input wire                          clk,
    input wire                          rst,
    input wire                          restart,
    input wire                          valid,
    input wire                          port,
    input wire signed [`WH_COUNT_W-1:0] position,
    input wire [15:0]                   overspeed,
    input wire signed [`WH_COUNT_W-1:0] low,
    input wire signed [`WH_COUNT_W-1:0] high
);

    localparam integer W = `WH_COUNT_W + 1;  // of a way

    (* anyconst *) wire                          which;
    (* anyconst *) wire [15:0]                   limit;
    (* anyconst *) wire signed [`WH_COUNT_W-1:0] least;
    (* anyconst *) wire signed [`WH_COUNT_W-1:0] most;

    wire too_fast, outside;

    wh_motion #(
        .N           (2),
        .SPAN_LOG2   (SPAN_LOG2)
    ) block (
        .clk         (clk),
        .rst         (rst),
        .restart_i   (restart),
        .valid_i     (valid),
        .port_i      (port),
        .position_i  (position),
        .overspeed_i (overspeed),
        .low_i       (low),
        .high_i      (high),
        .overspeed_o (too_fast),
        .outside_o   (outside)
    );

    (* hierconn *) wire [3:1]           \block.at_q ;
    (* hierconn *) wire [0:0]           \block.port_q ;
    (* hierconn *) wire [SPAN_LOG2-1:0] \block.rounds_q ;
    (* hierconn *) wire                 \block.begins_q ;
    (* hierconn *) wire                 \block.first_q ;
    (* hierconn *) wire                 \block.fresh_q ;
    (* hierconn *) wire [17:0]          \block.way_q ;
    (* hierconn *) wire                 \block.beyond_q ;
    (* hierconn *) wire [1:0]           \block.far_q ;
    (* hierconn *) wire [1:0]           \block.fast_q ;
    (* hierconn *) wire [1:0]           \block.outside_q ;
    (* hierconn *) wire [17:0]          \block.began_state.several.words[0] ;
    (* hierconn *) wire [17:0]          \block.began_state.several.words[1] ;
    (* hierconn *) wire [1:0]           \block.began_state.several.written_q ;

    wire [17:0] kept  = which ? \block.began_state.several.words[1] : \block.began_state.several.words[0] ;
    wire [17:0] began = \block.began_state.several.written_q [which] ? kept : 18'd0;

    // The turns, and the rounds.
    reg                  begun = 1'b0;
    reg  [3:1]           turn;       // clock of any turn,
    reg  [3:1]           mine;       // and of one of the watched port
    reg  [SPAN_LOG2-1:0] rounds;
    reg                  fresh, begins, first;
    reg                  known = 1'b0;  // a round has begun

    // The watched port.
    reg  signed [W-1:0]  start;      // its position as the span began,
    reg  signed [W-1:0]  before;     // and at its last turn
    reg  signed [W-1:0]  way;
    reg                  further;    // beyond the limit in this span,
    reg                  fast;       // or in the last one
    reg                  out, strays;

    wire signed [W-1:0]  here   = {position[W-2], position};
    wire signed [W-1:0]  step   = here - before;
    wire signed [W-1:0]  bound  = {{(W-16){1'b0}}, limit};
    wire signed [W-1:0]  stride = {{(W-17){1'b0}}, 1'b1, 16'd0};
    wire                 far    = !first && limit != 0 && (way > bound || way < -bound);
    wire                 opens  = valid && !port && !restart;

    always @(posedge clk) begin
        begun <= 1'b1;
        turn  <= rst ? 3'd0 : {turn[2:1], valid};
        mine  <= rst ? 3'd0 : {mine[2:1], valid && port == which};
        if (rst || restart) begin
            rounds <= 0;
            fresh  <= 1'b1;
        end else if (opens) begin
            rounds <= rounds + 1'b1;
            fresh  <= 1'b0;
        end
        if (opens && !rst) begin
            known  <= 1'b1;
            begins <= (rounds == 0);
            first  <= fresh;
        end
        if (rst) begin
            start   <= 0;
            before  <= 0;
            further <= 1'b0;
            fast    <= 1'b0;
            strays  <= 1'b0;
        end else begin
            if (mine[2]) begin
                way <= here - start;
                out <= here < $signed({least[W-2], least}) || here > $signed({most[W-2], most});
                before <= here;
                if (begins) start <= here;
            end
            if (mine[3]) begin
                further <= !begins && (further || far);
                fast    <= far || ((begins && !first) ? further : fast);
                strays  <= out;
            end
        end

        if (!begun) begin
            assume (rst);
        end else begin
            assume (!valid || turn[2:1] == 2'b00);
            assume (!restart || !valid);
            assume (known || !valid || !port);
            if (mine[2]) begin
                assume (low == least && high == most);
                assume (first || (step < stride && step > -stride));
            end
            if (mine[3]) assume (overspeed == limit);

            assert (too_fast == |\block.fast_q );
            assert (outside == |\block.outside_q );
            assert (\block.fast_q [which] == fast);
            assert (\block.outside_q [which] == strays);
            // What makes that inductive.
            assert (turn[3:2] != 2'b11 && turn[2:1] != 2'b11 && !(turn[3] && turn[1]));
            assert ((mine & ~turn) == 0);
            assert (\block.at_q == turn);
            if (|turn) assert ((\block.port_q == which) == |mine);
            assert (\block.rounds_q == rounds);
            assert (\block.fresh_q == fresh);
            assert (rounds == 0 || !fresh);
            if (known) begin
                assert (\block.begins_q == begins && \block.first_q == first);
                assert (begins || !first);
            end
            assert (known || turn == 0);
            assert (began == start[17:0]);
            assert (\block.far_q [which] == further);
            assert (fast || !further);
            if (mine[3]) begin
                assert (\block.way_q == way[17:0] && \block.beyond_q == out);
                assert (begins ? before == start : way == before - start);
            end
            // In a span in which the way isn't beyond the limit yet, 18 bits hold it.
            if (limit != 0 && !further) begin
                if (mine[3]) begin
                    assert (first || (way < bound + stride && way > -bound - stride));
                end else begin
                    assert (before - start <= bound && before - start >= -bound);
                end
            end
        end

        cover (begun && too_fast && !further && fast && !outside);
        cover (begun && outside && !strays && fast && rounds == 1);
        cover (begun && fresh && fast);
    end

endmodule

`default_nettype wire
