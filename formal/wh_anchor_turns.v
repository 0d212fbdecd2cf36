// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_anchor_turns: a turn comes to an end if every request is granted in PATIENCE clocks and every
// product comes three clocks after its grant, as wh_multiply_shared has it; reset at any clock leaves
// the anchor ready, and no product asked for before it is taken for another. The word of c's limit, once it
// is made, is as it is until the turn's end.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_anchor_turns #(
    parameter integer PATIENCE = 1
) (
    input wire                     clk,
    input wire                     rst,
    input wire                     waves,
    input wire                     grant,
    input wire                     contact,
    input wire [`WH_ANCHOR_W-1:0]  words,
    input wire [`WH_COUNT_W-1:0]   position,
    input wire [`WH_DATA_W+`WH_COEF_W-1:0] product
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

    wire busy, overrun, request, fault;
    wire signed [DATA_W-1:0] correction, next;

    reg [2:0] way;      // grants of the last clocks: products on their way
    wire      granted = request && grant;

    wh_anchor block (
        .clk           (clk),
        .rst           (rst),
        .position_i    (position),
        .place_i       ({(`WH_PLACE_W+`WH_SINE_Q){1'b0}}),
        .cell_i        ({(`WH_SINE_Q+2){1'b0}}),
        .contact_i     (contact),
        .waves_i       (waves),
        .current_i     ({DATA_W{1'b0}}),
        .u_i           ({DATA_W{1'b0}}),
        .v_i           ({DATA_W{1'b0}}),
        .withheld_i    ({DATA_W{1'b0}}),
        .voltage_i     ({DATA_W{1'b0}}),
        .saturated_i   (1'b0),
        .blind_i       (1'b0),
        .busy_o        (busy),
        .overrun_o     (overrun),
        .words_i       (words),
        .request_o     (request),
        .factor_o      (),
        .coefficient_o (),
        .grant_i       (granted),
        .done_i        (way[2]),
        .product_i     (product),
        .correction_o  (correction),
        .next_o        (next),
        .room_o        (),
        .offset_o      (),
        .flux_o        (),
        .lag_o         (),
        .fault_o       (fault)
    );

    (* hierconn *) wire [4:0] \block.step_q ;
    (* hierconn *) wire [4:0] \block.adds_q ;
    (* hierconn *) wire [3:0] \block.give_q ;
    (* hierconn *) wire [2:0] \block.open_q ;
    (* hierconn *) wire       \block.go_q ;
    (* hierconn *) wire       \block.writes_q ;
    (* hierconn *) wire       \block.stores_q ;
    (* hierconn *) wire [3:0] \block.store_to_q ;
    (* hierconn *) wire [4:0] \block.ahead_q ;
    (* hierconn *) wire       \block.waits_q ;
    (* hierconn *) wire [1:0] \block.pulls_q ;
    (* hierconn *) wire [3:0] \block.write_to_q ;
    (* hierconn *) wire signed [`WH_LONG_W-1:0] \block.memory[9] ;

    // Products that the steps before this one have taken.
    function [3:0] taken_before(input [4:0] step);
        taken_before = (step > 26) ? 4'd8 : (step > 23) ? 4'd7 : (step > 22) ? 4'd6
                     : (step > 8) ? 4'd5 : (step > 7) ? 4'd4 : (step > 6) ? 4'd3
                     : (step > 5) ? 4'd2 : (step > 4) ? 4'd1 : 4'd0;
    endfunction

    wire       in_turn = busy && !(\block.step_q == 5'd0);
    wire [4:0] step    = \block.step_q ;
    wire [3:0] used    = taken_before(step);
    wire [3:0] coming  = {3'd0, way[0]} + {3'd0, way[1]} + {3'd0, way[2]};
    wire       waits   = (step >= 4 && step <= 8) || step == 22 || step == 23 || step == 26;

    reg        begun = 1'b0;
    reg        rst_q;
    reg  [3:0] refused;   // clocks in a row without a grant
    reg  [9:0] turn;      // clocks of this turn
    reg        makes_q;   // the limit is being made, or there is no turn
    reg signed [`WH_LONG_W-1:0] word_9_q;
    reg  [5:0] stall;     // clocks in which this step has waited

    always @(posedge clk) begin
        begun   <= 1'b1;
        rst_q   <= rst;
        way     <= rst ? 3'd0 : {way[1:0], granted};
        refused <= (rst || !request || grant) ? 4'd0 : refused + 4'd1;
        makes_q    <= !begun || rst || !in_turn || \block.adds_q < 5'd4;
        word_9_q   <= \block.memory[9] ;
        turn    <= (rst || !in_turn) ? 10'd0 : (turn == 10'd1000) ? turn : turn + 10'd1;
        stall   <= (rst || !in_turn || !waits || way[2]) ? 6'd0 : stall + 6'd1;

        assume (!request || grant || refused < PATIENCE);
        if (!begun) assume (rst);

        if (begun) begin
            if (rst_q) assert (!busy && !overrun && !fault && step == 5'd0 && !\block.go_q
                               && correction == 0 && next == 0 && !request);
            assert (busy == (step != 5'd0 || (\block.go_q && \block.adds_q == 5'd27)));
            assert (step <= 5'd27);
            assert (\block.ahead_q == (step == 5'd27 ? 5'd0 : step + 5'd1));
            assert (\block.waits_q == waits);
            assert (\block.open_q [1:0] == {step > 5'd18, step > 5'd0});
            // The last product is asked for three clocks after the one before it was granted.
            assert (\block.open_q [2] == (in_turn && (\block.give_q == 4'd8
                                                      || (\block.give_q == 4'd7 && !way[0] && !way[1]))));
            assert (\block.pulls_q == {\block.give_q == 4'd7 && way[1] && !way[0], \block.give_q == 4'd7 && way[0]});
            // Each step waits for its own product, and none is lost or taken for another.
            if (in_turn) begin
                assert (\block.give_q == used + coming);
                assert (!way[2] || waits);
                assert (stall <= (waits ? 6'd3 + PATIENCE : 6'd0));
            end else begin
                assert (way == 3'd0);
            end
            // So it ends: 8 products, each waited for no longer than that.
            if (\block.go_q && \block.adds_q == 5'd21) assert (!\block.writes_q );
            if (\block.go_q && \block.adds_q == 5'd22) assert (\block.writes_q && \block.write_to_q == 4'd1);
            if (!makes_q && in_turn) begin
                assert (\block.memory[9] == word_9_q);
            end
            // Behind the step of CHOOSE comes one clock more.
            if (in_turn) assert (turn <= 10'd2 + step + used * (6'd4 + PATIENCE) + stall);
            assert (turn <= 10'd32 + 8 * (6'd4 + PATIENCE));
        end

        cover (begun && busy && step == 5'd27);
    end

endmodule

`default_nettype wire
