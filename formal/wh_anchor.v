// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_anchor: a period's 29 steps with any products, which come at once. Part 0: from any state of
// rest to the next; c is 0 if it isn't enabled or after a fault, θ as a coefficient is 0 to learn_max, out of
// contact nothing of it is in c, and nothing is learned while blind, clipped or saturated. Part 1: the first
// steps make the limit of c. Part 2: in the last steps it limits all of c but the held voltage θ (y' + sgn y' y_b),
// whatever the state is otherwise. reach is 0 or more and below half a word's largest, learn_max 0 or more, as
// their settings are. After a clock in which reads_o is low, the settings may be anything, until it is high.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_anchor #(
    parameter integer PART = 0
) (
    input wire                         clk,
    input wire signed [`WH_COUNT_W-1:0] position,
    input wire                         start
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

    (* anyconst *) wire                         enable;
    (* anyconst *) wire signed [8*COEF_W-1:0]   gains;
    (* anyconst *) wire signed [DATA_W-1:0]     reach;
    (* anyconst *) wire signed [DATA_W-1:0]     strange;
    (* anyconst *) wire signed [DATA_W-1:0]     brush;
    (* anyconst *) wire [`WH_FOLLOW_W-1:0]      follow_ticks;
    (* anyconst *) wire [`WH_REST_W-1:0]        slow_ticks;
    (* anyconst *) wire signed [DATA_W-1:0]     voltage;
    (* anyconst *) wire                         saturated;
    (* anyconst *) wire                         blind;
    (* anyseq *)   wire signed [DATA_W+COEF_W-1:0] product;

    reg [5:0] at = 6'd0;

    wire                     busy, reads, overrun, request, fault;
    (* anyseq *) wire [`WH_ANCHOR_W-1:0] any_words;
    wire signed [DATA_W-1:0] factor, correction, next, room, offset, flux, lag;
    wire signed [COEF_W-1:0] coefficient;

    wh_anchor block (
        .clk           (clk),
        .rst           (1'b0),
        .start_i       (1'b0),
        .position_i    (position),
        .place_i       ({(`WH_PLACE_W+`WH_SINE_Q){1'b0}}),
        .cell_i        ({(`WH_SINE_Q+2){1'b0}}),
        .contact_i     (1'b0),
        .waves_i       (at == 6'd0),
        .current_i     ({DATA_W{1'b0}}),
        .u_i           ({DATA_W{1'b0}}),
        .v_i           ({DATA_W{1'b0}}),
        .withheld_i    ({DATA_W{1'b0}}),
        .voltage_i     (voltage),
        .saturated_i   (saturated),
        .blind_i       (blind),
        .busy_o        (busy),
        .reads_o       (reads),
        .overrun_o     (overrun),
        .words_i       ((reads || reads_q) ? {slow_ticks, follow_ticks, brush, strange, reach, gains, enable}
                              : any_words),
        .request_o     (request),
        .factor_o      (factor),
        .coefficient_o (coefficient),
        .grant_i       (1'b1),
        .done_i        (1'b1),
        .product_i     (product),
        .correction_o  (correction),
        .next_o        (next),
        .room_o        (room),
        .offset_o      (offset),
        .flux_o        (flux),
        .lag_o         (lag),
        .fault_o       (fault)
    );

    (* hierconn *) wire [4:0] \block.step_q ;
    (* hierconn *) wire       \block.go_q ;
    (* hierconn *) wire       \block.contact_q ;
    (* hierconn *) wire       \block.enable_q ;

    (* hierconn *) wire [4:0] \block.adds_q ;
    (* hierconn *) wire       \block.writes_q ;
    (* hierconn *) wire       \block.stores_q ;
    (* hierconn *) wire [3:0] \block.store_to_q ;
    (* hierconn *) wire [4:0] \block.ahead_q ;
    (* hierconn *) wire       \block.waits_q ;
    (* hierconn *) wire       \block.bare_q ;
    (* hierconn *) wire [3:0] \block.b_from_q ;
    (* hierconn *) wire       \block.chosen_q ;
    (* hierconn *) wire       \block.none_q ;
    (* hierconn *) wire       \block.first_q ;
    (* hierconn *) wire       \block.begins_q ;
    (* hierconn *) wire       \block.tracked_q ;
    (* hierconn *) wire       \block.clipped_q ;
    (* hierconn *) wire signed [DATA_W-1:0]      \block.brush_q ;
    (* hierconn *) wire signed [DATA_W-1:0]      \block.held_q ;
    (* hierconn *) wire signed [COEF_W-1:0]      \block.theta_q ;
    (* hierconn *) wire signed [`WH_LONG_W-1:0]  \block.memory[1] ;
    (* hierconn *) wire signed [`WH_LONG_W-1:0]  \block.memory[2] ;
    (* hierconn *) wire signed [`WH_LONG_W-1:0]  \block.memory[3] ;
    (* hierconn *) wire signed [DATA_W-1:0]      \block.voltage_q ;
    (* hierconn *) wire signed [`WH_LONG_W-1:0]  \block.memory[9] ;
    (* hierconn *) wire signed [`WH_LONG_W-1:0]  \block.memory[12] ;

    localparam integer VOLT_SHIFT = `WH_LONG_Q - `WH_VOLTAGE_Q;

    // The setting, of the eight gains the sixth.
    wire signed [COEF_W-1:0] learn_max = gains[5*COEF_W +: COEF_W];

    reg fault_before;
    reg reads_q = 1'b1;

    // What is learned, before the steps.
    reg                          first_before, tracked_before, clipped_before;
    reg signed [DATA_W-1:0]      brush_before;
    reg signed [`WH_LONG_W-1:0]  theta_before, mean_before, zero_before;

    // One bit more than a word, and more for a half's fraction.
    wire signed [DATA_W+3:0] size   = voltage[DATA_W-1] ? -$signed({{4{voltage[DATA_W-1]}}, voltage})
                                                        : $signed({{4{voltage[DATA_W-1]}}, voltage});
    // c without what is held, and c, held and all, which is 0 where it isn't wanted.
    wire signed [DATA_W-1:0] held   = \block.held_q ;
    wire signed [DATA_W-1:0] pulled = next - held;
    wire signed [DATA_W+3:0] c      = $signed({{4{pulled[DATA_W-1]}}, pulled});
    wire signed [DATA_W+3:0] all    = $signed({{4{next[DATA_W-1]}}, next});
    wire signed [DATA_W+3:0] share  = $signed({{4{held[DATA_W-1]}}, held});
    wire signed [DATA_W+3:0] c_size     = c[DATA_W+3] ? -c : c;
    wire signed [DATA_W+3:0] all_size   = all[DATA_W+3] ? -all : all;
    wire signed [DATA_W+3:0] share_size = share[DATA_W+3] ? -share : share;
    // Out of contact the reach is half, and the limit's fraction of a place goes up.
    wire signed [DATA_W+3:0] halves = 2 * (\block.contact_q ? reach : reach >>> 1) + size;
    wire signed [DATA_W+3:0] limit  = (halves + 1) >>> 1;

    // c_0 + |e_id|/2 in a long word's places.
    wire signed [`WH_LONG_W-1:0] limit_long = $signed({halves, {(VOLT_SHIFT - 1){1'b0}}});
    // At rest the first step, which waits for no product and takes a setting, is known already.
    wire first_known  = \block.ahead_q == 5'd1 && !\block.waits_q && !\block.bare_q
                        && \block.b_from_q == 4'd2;
    wire limit_stands = \block.memory[9] == limit_long && busy && \block.voltage_q == voltage;

    always @(posedge clk) begin
        at <= (at == 6'd40) ? 6'd40 : at + 6'd1;
        reads_q <= reads;
        assume (!reach[DATA_W-1] && !reach[DATA_W-2] && !strange[DATA_W-1] && !learn_max[COEF_W-1]);
        if (at == 6'd0) begin
            if (PART <= 1) assume (\block.step_q == 5'd0 && !\block.go_q && !busy && first_known);
            if (PART <= 1) assume (!\block.chosen_q && !\block.none_q );
            else assume (\block.go_q && \block.adds_q == \block.step_q - 5'd1 && limit_stands);
            // HELD, the step that is added up meanwhile, writes nothing, and LEARN before it θ.
            if (PART == 2) begin
                assume (\block.step_q == 5'd25 && \block.ahead_q == 5'd26 && !\block.writes_q );
                assume (!\block.stores_q || \block.store_to_q == 4'd1);
                assume (!\block.chosen_q && !\block.none_q );
            end
            assume (!overrun);
            if (PART == 2) assume (\block.enable_q == enable);
            fault_before <= fault;
        end
        if (at == 6'd1) begin
            first_before   <= \block.first_q ;
            tracked_before <= \block.tracked_q ;
            clipped_before <= \block.clipped_q ;
            brush_before   <= \block.brush_q ;
            theta_before   <= \block.memory[1] ;
            mean_before    <= \block.memory[2] ;
            zero_before    <= \block.memory[3] ;
        end
        if (at == 6'd30) begin
            if (PART == 0) begin
                assert (\block.step_q == 5'd0 && !\block.go_q && !busy && !overrun && first_known);
                if (!enable || fault || blind) assert (next == 0);
                if (enable && fault_before) assert (fault);
                if (!enable && fault) assert (fault_before);
                assert (\block.contact_q || room == 0);
                assert (!\block.theta_q [COEF_W-1] && \block.theta_q <= learn_max);
                assert (\block.contact_q || held == 0);
                if (!first_before && (blind || clipped_before || saturated || !\block.contact_q ))
                    assert (\block.memory[1] == theta_before);
                if (!first_before && blind && !\block.begins_q )
                    assert (\block.memory[2] == mean_before && \block.brush_q == brush_before);
                if (blind && (tracked_before || \block.contact_q ))
                    assert (\block.memory[3] == zero_before);
            end
        end
        // The third step has been made and written. Nothing touches its word until the last ones
        // (formal/wh_anchor_turns.v).
        if (PART == 1 && at == 6'd5) assert (\block.step_q == 5'd5 && limit_stands);
        if (PART == 2 && at == 6'd5) begin
            if (!\block.none_q ) assert (c_size <= limit);
            assert (all_size <= limit + share_size);
            assert (!\block.none_q || next == 0);
            // What was wanted is in the last of the words.
            assert (\block.none_q || pulled == 0 || pulled[DATA_W-1] == \block.memory[12] [`WH_LONG_W-1]);
            cover (next > 0 && voltage < 0 && c_size == limit);
            cover (next < 0 && saturated && c_size == limit && held > 0);
            cover (fault && !fault_before && next == 0 && held != 0);
            cover (!\block.none_q && next != 0 && held != 0 && all_size == limit + share_size);
            cover (!\block.none_q && pulled != 0 && c_size < limit);
        end
    end

endmodule

`default_nettype wire
