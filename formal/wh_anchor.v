// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_anchor: a period's 28 steps with any products, which come at once. Part 0: from any state of
// rest, in which nothing is left to be written, to the next; c is 0 if it isn't enabled or after a fault.
// Part 3: the steps from TAKE_THETA on leave θ as a coefficient 0 to learn_max; nothing is learned while blind or
// saturated, and θ doesn't grow while clipped, whatever the state is otherwise. Part 4: from any state of rest, y',
// y_b and the offset stay while blind. Part 1: the first steps make the limit of c. Part 2: the last steps make
// c = limited(θ (y' + sgn y' y_b - d) + clamp(-g_ρ p, ± limit)), the first term in contact only, whatever the state
// is otherwise. reach is 0 or more and below half a word's largest, strange, learn_max and brush 0 or more, as their
// settings are. After a clock in which reads_o is low, the settings may be anything, until it is high.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_anchor #(
    parameter integer PART  = 0,
    parameter integer SHOWN = 0   // for faults that are to be found: 1: one product, the first step; 2: another
) (
    input wire                         clk,
    input wire signed [`WH_COUNT_W-1:0] position
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
    (* anyconst *) wire                         contact;
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
        .position_i    (position),
        .place_i       ({(`WH_PLACE_W+`WH_SINE_Q){1'b0}}),
        .cell_i        ({(`WH_SINE_Q+2){1'b0}}),
        .contact_i     (contact),
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
    (* hierconn *) wire [3:0] \block.write_to_q ;
    (* hierconn *) wire [1:0] \block.low_q ;
    (* hierconn *) wire [1:0] \block.mid_q ;
    (* hierconn *) wire [1:0] \block.high_q ;
    (* hierconn *) wire [1:0] \block.top_q ;
    (* hierconn *) wire [4:0] \block.high_by_q ;
    (* hierconn *) wire [1:0] \block.top_by_q ;
    (* hierconn *) wire       \block.near_q ;
    (* hierconn *) wire       \block.chosen_q ;
    (* hierconn *) wire       \block.none_q ;
    (* hierconn *) wire       \block.first_q ;
    (* hierconn *) wire       \block.begins_q ;
    (* hierconn *) wire       \block.tracked_q ;
    (* hierconn *) wire       \block.clipped_q ;
    (* hierconn *) wire       \block.sinks_p_q ;
    (* hierconn *) wire       \block.void_q ;
    (* hierconn *) wire       \block.blind_q ;
    (* hierconn *) wire       \block.saturated_q ;
    (* hierconn *) wire       \block.fading_q ;
    (* hierconn *) wire       \block.start_q ;  // the clock after a turn was accepted
    (* hierconn *) wire signed [DATA_W-1:0]      \block.brush_q ;
    (* hierconn *) wire signed [COEF_W-1:0]      \block.theta_q ;
    (* hierconn *) wire signed [`WH_LONG_W-1:0]  \block.memory[1] ;
    (* hierconn *) wire signed [`WH_LONG_W-1:0]  \block.memory[2] ;
    (* hierconn *) wire signed [`WH_LONG_W-1:0]  \block.memory[3] ;
    (* hierconn *) wire signed [`WH_LONG_W-1:0]  \block.memory[9] ;

    localparam integer VOLT_SHIFT = `WH_LONG_Q - `WH_VOLTAGE_Q;
    localparam integer NEAR_SHIFT = `WH_CURRENT_Q + `WH_CELLS_Q - `WH_LONG_Q;
    localparam integer WIDE_W     = DATA_W + COEF_W + 2;
    localparam integer FAR_SHIFT  = `WH_WAVE_Q + `WH_FLUX_Q - `WH_LONG_Q;
    localparam signed [`WH_LONG_W-1:0] THETA_LEAST = -(48'sd1 <<< (DATA_W + COEF_W - 1 - FAR_SHIFT));

    // The setting, of the eight gains the sixth.
    wire signed [COEF_W-1:0] learn_max = gains[5*COEF_W +: COEF_W];

    reg fault_before;
    reg none;
    reg reads_q = 1'b1;

    // What is learned, before the steps.
    reg                          first_before, tracked_before, clipped_before, fades;
    reg signed [DATA_W-1:0]      brush_before;
    reg signed [`WH_LONG_W-1:0]  theta_before, mean_before, zero_before;

    // One bit more than a word, and more for a half's fraction.
    wire signed [DATA_W+3:0] size   = voltage[DATA_W-1] ? -$signed({{4{voltage[DATA_W-1]}}, voltage})
                                                        : $signed({{4{voltage[DATA_W-1]}}, voltage});
    // Out of contact the reach is half.
    wire signed [DATA_W+3:0] halves = 2 * (\block.contact_q ? reach : reach >>> 1) + size;

    // c_0 + |e_id|/2 in a long word's places.
    wire signed [`WH_LONG_W-1:0] limit_long = $signed({halves, {(VOLT_SHIFT - 1){1'b0}}});
    // At rest the first step, which waits for no product and takes the voltage, is known already.
    wire first_known  = \block.ahead_q == 5'd1 && !\block.waits_q && !\block.bare_q && !\block.near_q
                        && \block.low_q == 0 && \block.mid_q == 0 && \block.high_q == 0 && \block.top_q == 0
                        && \block.high_by_q == 5'b00001 && \block.top_by_q == 2'b01;
    wire limit_stands = \block.memory[9] == limit_long && busy;

    // c as it is meant, of the products of the steps CORRECT and HELD.
    reg  signed [WIDE_W-1:0] wanted, held;
    wire signed [WIDE_W-1:0] share = product >>> NEAR_SHIFT;
    wire signed [WIDE_W-1:0] most  = limit_long;
    wire signed [WIDE_W-1:0] pull  = (wanted > most) ? most : (wanted < -most) ? -most : wanted;
    wire signed [WIDE_W-1:0] all   = (held + pull) >>> VOLT_SHIFT;
    wire signed [WIDE_W-1:0] top   = {{(WIDE_W - DATA_W + 1){1'b0}}, {(DATA_W - 1){1'b1}}};
    wire signed [WIDE_W-1:0] meant = (all > top) ? top : (all < ~top) ? ~top : all;

    always @(posedge clk) begin
        at <= (at == 6'd40) ? 6'd40 : at + 6'd1;
        reads_q <= reads;
        assume (!reach[DATA_W-1] && !reach[DATA_W-2] && !strange[DATA_W-1] && !learn_max[COEF_W-1]
                && !brush[DATA_W-1]);
        if (SHOWN != 0) begin
            assume (product == 1 << 30 && position == 0 && voltage == 1 << 20 && reach == 1 << 20 && strange == 0
                    && brush == 0 && follow_ticks == 1 && slow_ticks == 1);
            if (at == 6'd0) assume (\block.first_q == (SHOWN == 1) && \block.brush_q == 0 && \block.theta_q == 0);
            if (SHOWN == 1) assume (gains == 0 && (at != 6'd0 || !\block.clipped_q ));
            if (SHOWN == 2) begin
                assume (learn_max == 1 << 20);
                if (at == 6'd0) assume (\block.memory[2] == 0 && \block.memory[3] == 0);
            end
        end
        if (at == 6'd0) begin
            if (PART == 3)  // the step before TAKE_THETA is added up meanwhile, and may write x̂'s slow copy
                assume (!\block.start_q && \block.step_q == 5'd21 && \block.ahead_q == 5'd22 && \block.go_q
                        && \block.adds_q == 5'd20
                        && \block.write_to_q == 4'd4 && busy
                        && !\block.waits_q && \block.bare_q == !\block.first_q && !\block.near_q
                        && \block.low_q == 0 && \block.mid_q == 3 && \block.high_q == 3 && \block.top_q == 0
                        && \block.high_by_q == 5'b00001 && \block.top_by_q == 0);
            else if (PART != 2) assume (\block.step_q == 5'd0 && !\block.go_q && !busy && first_known);
            // LEARN, the step that is added up meanwhile, writes θ, and the one before it nothing.
            else assume (\block.step_q == 5'd23 && \block.ahead_q == 5'd24 && \block.go_q && \block.adds_q == 5'd22
                         && \block.write_to_q == 4'd1 && limit_stands
                         && \block.waits_q && !\block.bare_q && \block.near_q
                         && \block.low_q == 1 && \block.mid_q == 1 && \block.high_q == 1 && \block.top_q == 1
                         && \block.high_by_q == 0 && \block.top_by_q == 0);
            assume (!\block.chosen_q && !\block.none_q && !\block.stores_q );
            assume (!overrun);
            if (PART == 2) assume (\block.enable_q == enable);
            // void_q is θ's sign, as the last clock below shows, but before the first period.
            if (PART == 3) assume (\block.first_q || \block.void_q == \block.memory[1] [`WH_LONG_W-1]);
            // A step of θ is smaller than THETA_LEAST, and θ below 0 gets none downwards.
            if (PART == 3) assume (\block.first_q || $signed(\block.memory[1] ) >= THETA_LEAST);
            fault_before <= fault;
        end
        if (at == 6'd1) begin
            first_before   <= \block.first_q ;
            tracked_before <= \block.tracked_q ;
            clipped_before <= \block.clipped_q ;
            fades          <= \block.fading_q ;
            brush_before   <= \block.brush_q ;
            theta_before   <= \block.memory[1] ;
            mean_before    <= \block.memory[2] ;
            zero_before    <= \block.memory[3] ;
        end
        // g_θ is 0 or more, so g_θ p, which the step LEARN takes, has p's sign.
        if (PART == 3 && \block.step_q == 5'd22)
            assume (product[DATA_W+COEF_W-1] == \block.sinks_p_q || product == 0);
        if (PART == 0 && at == 6'd30) begin
            assert (\block.step_q == 5'd0 && !\block.go_q && !busy && !overrun && first_known);
            assert (!\block.chosen_q && !\block.none_q && !\block.stores_q );
            if (!enable || fault || blind) assert (next == 0);
            if (enable && fault_before) assert (fault);
            if (!enable && fault) assert (fault_before);
            assert (\block.contact_q || room == 0);
        end
        if (PART == 3 && at == 6'd6) begin
            assert (\block.step_q == 5'd27);
            assert (\block.void_q == \block.memory[1] [`WH_LONG_W-1]);
            assert (!\block.theta_q [COEF_W-1] && \block.theta_q <= learn_max);
            if (!first_before && !fades && (\block.blind_q || \block.saturated_q || !\block.contact_q ))
                assert (\block.memory[1] == theta_before);
            if (!first_before && !fades && clipped_before) assert ($signed(\block.memory[1] ) <= theta_before);
            if (!first_before && theta_before < -THETA_LEAST)
                assert ($signed(\block.memory[1] ) >= THETA_LEAST);
            // A turn outwards moves θ toward 0, and not past it.
            if (!first_before && fades && theta_before >= 0)
                assert ($signed(\block.memory[1] ) >= 0 && $signed(\block.memory[1] ) <= theta_before);
            if (!first_before && fades && theta_before < 0)
                assert ($signed(\block.memory[1] ) <= 0 && $signed(\block.memory[1] ) >= theta_before);
        end
        if (PART == 4 && at == 6'd17) begin
            assert (\block.step_q == 5'd17);
            if (!first_before && blind && !\block.begins_q )
                assert (\block.memory[2] == mean_before && \block.brush_q == brush_before);
            if (blind && (tracked_before || \block.contact_q ))
                assert (\block.memory[3] == zero_before);
        end
        // The second step has been made and written. Nothing touches its word until the last ones
        // (formal/wh_anchor_turns.v).
        if (PART == 1 && at == 6'd4) assert (\block.step_q == 5'd4 && limit_stands);
        if (PART == 2) begin
            if (at == 6'd0) wanted <= -share;
            if (at == 6'd3) held   <= \block.contact_q ? share : {WIDE_W{1'b0}};
            if (at == 6'd6) none   <= \block.none_q ;
            if (at == 6'd7) begin
                assert (none ? next == 0 : next == meant);
                cover (!none && next > 0 && voltage < 0 && pull == most && held < 0);
                cover (!none && next < 0 && saturated && pull == -most && held > 0);
                cover (fault && !fault_before && next == 0 && held != 0);
                cover (!none && pull != most && pull != -most && held != 0 && all < top && all > ~top);
                cover (!none && all > top);
                cover (!none && all < ~top);
                cover (!none && wanted > (most <<< 8));
            end
        end
    end

endmodule

`default_nettype wire
