// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_shaper: a turn of one section, from any states, with any products. A result is what the
// products come to, brought nearer to zero by its loss or more and never past it: for y that is
// asserted as it stands, for the states by the words that it leads to. So, of a matrix that
// doesn't let |x'|^2 + y^2 grow, rounding and limits make none that does. The loss covers what the
// rounded states and the words of the matrix could have added (sim/wavehaptics/controller/normalised.py).
//
// And whatever the words are: the squares of what came in and of y are asked for, and the budget has
// them; y is 0 while it is below 0, so that it is never below a tick's largest square.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_shaper #(
    parameter integer PART = 0  // 0: y, 1: x1, 2: x2, 3: the other modes, 4: the budget
) (
    input wire clk
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer SHAPE_W   = `WH_SHAPE_W;
    localparam integer LOSS_W    = `WH_SHAPE_LOSS_W;
    localparam integer GUARD     = `WH_STATE_GUARD;
    localparam integer HEADROOM  = `WH_SHAPE_HEADROOM;
    localparam integer STATE_W   = DATA_W + GUARD;
    localparam integer SHIFT     = `WH_SHAPE_Q - GUARD;
    localparam integer PRODUCT_W = DATA_W + SHAPE_W;
    localparam integer BUDGET_W  = 2 * DATA_W + 2 * HEADROOM + 1;

    (* anyconst *) wire        [1:0]                      mode;
    (* anyconst *) wire        [9*SHAPE_W+3*LOSS_W-1:0]   words;
    (* anyconst *) wire signed [DATA_W-1:0]               value;
    (* anyseq *)   wire signed [PRODUCT_W-1:0]            product;

    reg [4:0] at = 5'd0;

    wire signed [DATA_W-1:0]  y;
    wire                      give;
    wire signed [DATA_W-1:0]  data;
    wire signed [SHAPE_W-1:0] coef;

    wh_shaper block (
        .clk       (clk),
        .rst       (1'b0),
        .turn_i    (at == 5'd0),
        .port_i    (1'b0),
        .mode_i    (mode),
        .words_i   (words),
        .value_i   (value),
        .value_o   (y),
        .give_o    (give),
        .data_o    (data),
        .coef_o    (coef),
        .product_i (product)
    );

    (* hierconn *) wire signed [STATE_W-1:0] \block.x1_q[0] ;
    (* hierconn *) wire signed [STATE_W-1:0] \block.x2_q[0] ;
    (* hierconn *) wire signed [BUDGET_W-1:0] \block.budget_q[0] ;
    (* hierconn *) wire [1:0]  \block.square_q1 ;
    (* hierconn *) wire [1:0]  \block.square_q2 ;
    (* hierconn *) wire [1:0]  \block.square_q3 ;
    (* hierconn *) wire [18:1] \block.at_q ;
    (* hierconn *) wire [2:0]  \block.any_q1 ;
    (* hierconn *) wire [2:0]  \block.any_q2 ;
    (* hierconn *) wire [2:0]  \block.any_q3 ;
    (* hierconn *) wire [2:0]  \block.kind_q1 ;
    (* hierconn *) wire [2:0]  \block.kind_q2 ;
    (* hierconn *) wire [2:0]  \block.kind_q3 ;
    (* hierconn *) wire [2:0]  \block.kind_q4 ;

    localparam signed [DATA_W-1:0]  WORD    = {1'b0, {(DATA_W - 1){1'b1}}};
    localparam signed [STATE_W-1:0] LARGEST = {WORD, {GUARD{1'b0}}};
    localparam signed [STATE_W-1:0] LEAST   = {1'b1, {(STATE_W - 1){1'b0}}};

    localparam integer W = PRODUCT_W + GUARD + 4;

    function signed [W-1:0] size(input signed [W-1:0] x);
        size = (x < 0) ? -x : x;
    endfunction

    // |small| <= max(0, |exact| - loss), on the same side of zero, in places 2^-shift of small's.
    function nearer(input signed [W-1:0] small, input signed [W-1:0] exact,
                    input [LOSS_W-1:0] loss, input integer shift);
        nearer = (small == 0)
                 || ((small < 0) == (exact < 0)
                     && ((size(small) + $signed({1'b0, loss})) <<< shift) <= size(exact));
    endfunction

    // A floor as it is brought nearer: below zero it is one place too far already.
    function signed [W-1:0] brought(input signed [W-1:0] floor, input [LOSS_W-1:0] loss);
        brought = (floor < 0) ? ((floor + $signed({1'b0, loss}) + 1 < 0) ? floor + $signed({1'b0, loss}) + 1 : 0)
                              : ((floor > $signed({1'b0, loss})) ? floor - $signed({1'b0, loss}) : 0);
    endfunction

    function signed [W-1:0] within(input signed [W-1:0] x);
        within = (x > LARGEST) ? LARGEST : (x < LEAST) ? LEAST : x;
    endfunction

    wire signed [STATE_W-1:0] x1 = \block.x1_q[0] ;
    wire signed [STATE_W-1:0] x2 = \block.x2_q[0] ;
    wire [LOSS_W-1:0] loss_x1 = words[9*SHAPE_W +: LOSS_W];
    wire [LOSS_W-1:0] loss_x2 = words[9*SHAPE_W+LOSS_W +: LOSS_W];
    wire [LOSS_W-1:0] loss_y  = words[9*SHAPE_W+2*LOSS_W +: LOSS_W];

    // A square of a wave, and a budget, in squares of a wave's last place.
    localparam signed [BUDGET_W+1:0] SQUARE = {{(BUDGET_W + 2 - 2 * DATA_W){1'b0}}, 2'b01, {(2 * DATA_W - 2){1'b0}}};
    localparam signed [BUDGET_W+1:0] MOST   = {3'b000, {(BUDGET_W - 1){1'b1}}};

    wire signed [BUDGET_W+1:0] budget = \block.budget_q[0] ;
    wire signed [BUDGET_W+1:0] square = product;
    reg signed [BUDGET_W+1:0]  paid;  // the budget with what came in, and then without what came out

    reg signed [STATE_W-1:0] x1_before, x2_before;
    reg signed [W-1:0]       sum_y, sum_x1, sum_x2;   // of the products
    // A wave's product with a state's place, as the sum has it: its own lowest bits are no more there.
    wire signed [W-1:0]      waves = product >>> HEADROOM;
    wire signed [W-1:0]      states = product;
    wire signed [W-1:0]      exact_x1 = ($signed(x1_before) <<< SHIFT) + sum_x1;
    wire signed [W-1:0]      exact_x2 = ($signed(x2_before) <<< SHIFT) + sum_x2;

    always @(posedge clk) begin
        at <= (at == 5'd20) ? 5'd20 : at + 5'd1;
        if (at == 5'd0) begin
            assume (\block.at_q == 18'd0);
            assume (\block.any_q1 == 0 && \block.any_q2 == 0 && \block.any_q3 == 0);
            assume (\block.kind_q1 == 0 && \block.kind_q2 == 0 && \block.kind_q3 == 0
                    && \block.kind_q4 == 0);
            assume (\block.square_q1 == 0 && \block.square_q2 == 0 && \block.square_q3 == 0);
            assume (budget >= -SQUARE);
            paid <= budget;
            assume (x1 <= LARGEST && x2 <= LARGEST);
            x1_before <= x1;
            x2_before <= x2;
        end
        // Three clocks after its factors were given, a product is there.
        if (at == 5'd6) sum_y <= states;
        if (at == 5'd7) sum_y <= sum_y + states;
        if (at == 5'd8) sum_y <= sum_y + waves;
        if (at == 5'd9) sum_x1 <= states;
        if (at == 5'd10) sum_x1 <= sum_x1 + states;
        if (at == 5'd11) sum_x1 <= sum_x1 + waves;
        if (at == 5'd14) sum_x2 <= states;
        if (at == 5'd15) sum_x2 <= sum_x2 + states;
        if (at == 5'd16) sum_x2 <= sum_x2 + waves;

        if (PART == 0 && at == 5'd10 && mode[1]) begin
            assert (nearer(y, sum_y, loss_y, SHIFT + GUARD - HEADROOM));
        end
        if (PART == 1 && at == 5'd18 && mode[1]) begin
            assert (x1 == within(brought(exact_x1 >>> SHIFT, loss_x1)));
        end
        if (PART == 2 && at == 5'd18 && mode[1]) begin
            assert (x2 == within(brought(exact_x2 >>> SHIFT, loss_x2)));
        end
        if (PART == 3 && at == 5'd18 && !mode[1]) begin
            assert (y == value);
            assert (x1 == (mode[0] ? x1_before : 0));
            assert (x2 == (mode[0] ? x2_before : 0));
        end
        if (PART == 3 && at == 5'd19) begin
            assert (\block.at_q == 18'd0 || \block.at_q == 18'h20000);
            assert (!give);
        end

        if (PART == 4 && at == 5'd14) begin
            assert (give && data == value && coef == $signed(value));
        end
        if (PART == 4 && at == 5'd15) begin
            assert (give && data == y && coef == $signed(y));
            assert (!mode[1] || paid >= 0 || y == 0);
        end
        if (at == 5'd17) begin
            assume (square >= 0 && square <= SQUARE);
            if (mode[1]) paid <= (paid + square > MOST) ? MOST : paid + square;
        end
        if (at == 5'd18) begin
            assume (square >= 0 && square <= SQUARE && (y != 0 || square == 0));
            if (mode[1]) paid <= paid - square;
        end
        if (PART == 4 && at == 5'd19) begin
            assert (budget == paid);
            assert (budget >= -SQUARE);
            assert (\block.square_q1 == 0 && \block.square_q2 == 0 && \block.square_q3 == 0);
        end
        cover (PART == 0 && at == 5'd19 && mode[1] && budget < 0 && y > 0);

        cover (PART == 0 && at == 5'd18 && mode[1] && y > 0 && x1 < 0 && x2 > 0 && x1 != x1_before);
        cover (PART == 0 && at == 5'd18 && mode[1] && y == WORD && x1 == LARGEST);
        cover (PART == 0 && at == 5'd18 && mode[1] && x1 == 0 && exact_x1 > 0 && exact_x1 != 0);
    end

endmodule

`default_nettype wire
