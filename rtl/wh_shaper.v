// SPDX-License-Identifier: Apache-2.0
//
// wh_shaper: the wave-domain filter W{v} between the incoming wave and the λ filter, for the port
// whose turn it is, in SECTIONS sections of two states each, one after the other:
//
//   [x1' x2' y] = M [x1 x2 v],  |M| <= 1
//
// A contractive M makes |x'|^2 + y^2 <= |x|^2 + v^2 in every tick, and no rounding, limit, pause or
// change of M can break that: sim/wavehaptics/controller/normalised.py makes such words, and says why. A state
// is rounded to the nearest for the multiplier. What the bits below could have added, and what is
// cut, is taken back: each result is brought nearer to zero by its loss, but not past it.
//
// Words needn't be contractive: whoever can write them can write others. So W pays for what it gives,
//
//   budget += v^2 - y^2                              of each tick in which W is at work; 0 at first
//
// and while the budget is below 0, y is 0. Whatever M is, no more has come out than went in but for
// one tick's y^2. With a contractive M the budget is |x|^2 or more, and nobody ever meets it.
//
// sim/wavehaptics/controller/wave_core.py says the same with integers (shaper_step).
//
// mode_i: 0 W = 1 and the states become 0, 1 W = 1 and they stay as they are, 2 W.
//
// words_i of a section, from its lowest bit: e11 e12 e21 e22 b1 b2 c1 c2 d, s31q29 each, with
// M = [1 + e11, e12, b1; e21, 1 + e22, b2; c1, c2, d]; then the losses of x1 and x2 in last places
// of a state, and of y in those of a wave, 12 bits each.
// Formats: waves s31q23 √W; states s40q28 √W, ±2048 √W; the budget s71q46 W, limited at 2^24 W, which is
// more than states can hold.
// Latency, in clocks after turn_i, the first clock of a turn: value_i is taken at VALUE, value_o
// holds from VALUE + 5 SECTIONS to the next turn's. The multiplier is wanted where give_o is high,
// from 3 on, never at VALUE + 5 SECTIONS nor 6 clocks later, and for the last time at
// 10 + 5 SECTIONS at one section, 16 + 5 SECTIONS at two. The budget has it 4 clocks later.
// Reset: all states and the budget 0.

`default_nettype none
`include "wh_formats.vh"

module wh_shaper #(
    parameter integer N         = 1,  // ports, 1...
    parameter integer SECTIONS  = 1,  // 1...2
    parameter integer PRODUCT_W = `WH_DATA_W + `WH_SHAPE_W,           // of the multiplier
    parameter integer PORT_W    = (N > 1) ? $clog2(N) : 1,            // derived, leave it
    parameter integer SECTION_W = 9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W  // derived, leave it
) (
    input  wire                                clk,
    input  wire                                rst,

    input  wire                                turn_i,
    input  wire        [PORT_W-1:0]            port_i,
    input  wire        [2*N-1:0]               mode_i,
    input  wire        [N*SECTIONS*SECTION_W-1:0] words_i,

    input  wire signed [`WH_DATA_W-1:0]        value_i,    // s31q23 √W, ±128 √W
    output wire signed [`WH_DATA_W-1:0]        value_o,    // s31q23 √W, ±128 √W

    // The core's multiplier.
    output wire                                give_o,
    output wire signed [`WH_DATA_W-1:0]        data_o,
    output wire signed [`WH_SHAPE_W-1:0]       coef_o,
    input  wire signed [PRODUCT_W-1:0]         product_i   // 3 clocks later
);

    localparam integer DATA_W   = `WH_DATA_W;
    localparam integer SHAPE_W  = `WH_SHAPE_W;
    localparam integer LOSS_W   = `WH_SHAPE_LOSS_W;
    localparam integer GUARD    = `WH_STATE_GUARD;
    localparam integer HEADROOM = `WH_SHAPE_HEADROOM;
    localparam integer STATE_W  = DATA_W + GUARD;
    localparam integer SHIFT    = `WH_SHAPE_Q - GUARD;   // from a product to a state
    localparam integer Y_SHIFT  = GUARD - HEADROOM;      // from a state to a wave
    localparam integer SUM_W    = PRODUCT_W + 2;         // three products
    localparam integer FLOOR_W  = SUM_W - SHIFT;
    localparam integer NEXT_W   = 1 + ((FLOOR_W > STATE_W) ? FLOOR_W : STATE_W);

    generate
        if (N < 1 || SECTIONS < 1 || SECTIONS > 2) begin : illegal_parameter
            wh_illegal_parameter_shaper_n_or_sections stop ();
        end
        if (SHIFT < 1 || Y_SHIFT < 1 || GUARD < 2 || PRODUCT_W < DATA_W + SHAPE_W
            || SHAPE_W < DATA_W) begin : illegal
            wh_illegal_parameter_shaper_formats stop ();
        end
    endgenerate

    // ---- The table of slots: in slot n the factors of a product are given. Three slots make a
    // result: two with the states, the third with the wave that comes in.
    localparam integer VALUE = 5;   // clock of the turn at which value_i is there
    localparam integer LAST  = (SECTIONS == 1) ? 18 : 29;

    // Then the square of what came in, and in the next clock that of what comes out.
    localparam integer SQUARE = (SECTIONS == 1) ? 14 : 25;

    reg  [LAST:1] at_q;

    always @(posedge clk) begin
        if (rst) begin
            at_q <= {LAST{1'b0}};
        end else begin
            at_q <= {at_q[LAST-1:1], turn_i};
        end
    end

    // The three slots of each result, by what is given: x1's product, x2's, the wave's.
    wire [2:0] y0_at;
    wire [2:0] x1_of_0_at;
    wire [2:0] x2_of_0_at;
    wire [2:0] y1_at;
    wire [2:0] x1_of_1_at;
    wire [2:0] x2_of_1_at;

    assign y0_at = {at_q[VALUE], at_q[VALUE-1], at_q[VALUE-2]};

    generate
        if (SECTIONS == 1) begin : slots_of_one
            assign x1_of_0_at = {at_q[8], at_q[7], at_q[6]};
            assign x2_of_0_at = {at_q[13], at_q[12], at_q[11]};
            assign y1_at      = 3'b000;
            assign x1_of_1_at = 3'b000;
            assign x2_of_1_at = 3'b000;
        end else begin : slots_of_two
            assign y1_at      = {at_q[10], at_q[9], at_q[8]};
            assign x1_of_0_at = {at_q[13], at_q[12], at_q[11]};
            assign x2_of_0_at = {at_q[17], at_q[16], at_q[14]};
            assign x1_of_1_at = {at_q[20], at_q[19], at_q[18]};
            assign x2_of_1_at = {at_q[24], at_q[23], at_q[22]};
        end
    endgenerate

    wire [2:0] y_at  = y0_at | y1_at;
    wire [2:0] x1_at = x1_of_0_at | x1_of_1_at;
    wire [2:0] x2_at = x2_of_0_at | x2_of_1_at;
    wire [2:0] any   = y_at | x1_at | x2_at;
    wire       second = |(y1_at | x1_of_1_at | x2_of_1_at);  // section of the slot

    wire [1:0] square_at = {at_q[SQUARE+1], at_q[SQUARE]};

    assign give_o = (|any) || (|square_at);

    // ---- What belongs to the port and to the slot's section.
    reg  signed [STATE_W-1:0] x1_q [0:N*SECTIONS-1];
    reg  signed [STATE_W-1:0] x2_q [0:N*SECTIONS-1];

    localparam integer PLACE_W = (N * SECTIONS > 1) ? $clog2(N * SECTIONS) : 1;

    wire [PLACE_W-1:0] place;

    generate
        if (SECTIONS == 1) begin : places_of_one
            wire unused_second = &{1'b0, second};

            assign place = port_i;
        end else if (N == 1) begin : places_of_two
            assign place = second;
        end else begin : places_of_many
            assign place = {port_i, second};
        end
    endgenerate

    wire        [SECTION_W-1:0] words = words_i[place*SECTION_W +: SECTION_W];
    wire        [1:0]           mode  = mode_i[port_i*2 +: 2];
    wire                        runs  = mode[1];
    wire                        clear = (mode == 2'd0);

    wire signed [SHAPE_W-1:0] e11 = $signed(words[0*SHAPE_W +: SHAPE_W]);
    wire signed [SHAPE_W-1:0] e12 = $signed(words[1*SHAPE_W +: SHAPE_W]);
    wire signed [SHAPE_W-1:0] e21 = $signed(words[2*SHAPE_W +: SHAPE_W]);
    wire signed [SHAPE_W-1:0] e22 = $signed(words[3*SHAPE_W +: SHAPE_W]);
    wire signed [SHAPE_W-1:0] b1  = $signed(words[4*SHAPE_W +: SHAPE_W]);
    wire signed [SHAPE_W-1:0] b2  = $signed(words[5*SHAPE_W +: SHAPE_W]);
    wire signed [SHAPE_W-1:0] c1  = $signed(words[6*SHAPE_W +: SHAPE_W]);
    wire signed [SHAPE_W-1:0] c2  = $signed(words[7*SHAPE_W +: SHAPE_W]);
    wire signed [SHAPE_W-1:0] d   = $signed(words[8*SHAPE_W +: SHAPE_W]);

    // ---- The factors.
    wire signed [STATE_W-1:0] state   = any[0] ? x1_q[place] : x2_q[place];
    // A state has no more than the largest word above its guard bits, so that this can't carry out.
    wire signed [STATE_W-1:0] rounded = state + $signed({{DATA_W{1'b0}}, 1'b1, {(GUARD-1){1'b0}}});
    reg  signed [DATA_W-1:0]  wave0_q;  // what the first section takes
    reg  signed [SHAPE_W-1:0] coef;
    wire signed [DATA_W-1:0]  wave;
    wire signed [DATA_W-1:0]  passed_on;  // what a section took and gives on where W is 1
    reg  [PLACE_W-1:0]        place_q1, place_q2, place_q3, place_q4;
    reg  signed [DATA_W-1:0]  y_q;

    generate
        if (SECTIONS == 1) begin : wave_of_one
            assign wave      = at_q[VALUE] ? value_i : wave0_q;
            assign passed_on = wave0_q;
        end else begin : wave_of_two
            reg signed [DATA_W-1:0] wave1_q;  // what the second takes

            assign wave      = at_q[VALUE] ? value_i : y1_at[2] ? y_q : second ? wave1_q : wave0_q;
            assign passed_on = place_q4[0] ? wave1_q : wave0_q;

            always @(posedge clk) begin
                if (y1_at[2]) begin
                    wave1_q <= y_q;
                end
            end
        end
    endgenerate

    always @* begin
        case ({y_at, x1_at, x2_at})
            9'b001_000_000: coef = c1;
            9'b010_000_000: coef = c2;
            9'b100_000_000: coef = d;
            9'b000_001_000: coef = e11;
            9'b000_010_000: coef = e12;
            9'b000_100_000: coef = b1;
            9'b000_000_001: coef = e21;
            9'b000_000_010: coef = e22;
            default:        coef = b2;
        endcase
    end

    wire signed [DATA_W-1:0] squared = square_at[1] ? y_q : wave0_q;

    assign data_o = (|square_at) ? squared : any[2] ? wave : $signed(rounded[STATE_W-1:GUARD]);
    assign coef_o = (|square_at) ? $signed({{(SHAPE_W - DATA_W + 1){squared[DATA_W-1]}},
                                            squared[DATA_W-2:0]}) : coef;

    wire unused_rounded = &{1'b0, rounded[GUARD-1:0]};

    // ---- The sum of a result's products, and the slot's own story 3 clocks later.
    reg  [2:0]               any_q1, any_q2, any_q3;
    reg  [2:0]               kind_q1, kind_q2, kind_q3, kind_q4;  // last product of y, x1, x2
    reg  [LOSS_W-1:0]        loss_q1, loss_q2, loss_q3, loss_q4;
    reg  signed [SUM_W-1:0]  sum_q;

    wire signed [PRODUCT_W-1:0] aligned = any_q3[2] ? (product_i >>> HEADROOM) : product_i;
    wire signed [SUM_W-1:0]     sum     = (any_q3[0] ? {SUM_W{1'b0}} : sum_q)
                                        + {{2{aligned[PRODUCT_W-1]}}, aligned};

    always @(posedge clk) begin
        any_q1   <= any;
        any_q2   <= any_q1;
        any_q3   <= any_q2;
        place_q1 <= place;
        place_q2 <= place_q1;
        place_q3 <= place_q2;
        place_q4 <= place_q3;
        loss_q1  <= y_at[2]  ? words[9*SHAPE_W+2*LOSS_W +: LOSS_W]
                  : x1_at[2] ? words[9*SHAPE_W          +: LOSS_W]
                             : words[9*SHAPE_W+1*LOSS_W +: LOSS_W];
        loss_q2  <= loss_q1;
        loss_q3  <= loss_q2;
        loss_q4  <= loss_q3;
        if (|any_q3) begin
            sum_q <= sum;
        end
        if (rst) begin
            {kind_q4, kind_q3, kind_q2, kind_q1} <= 12'd0;
        end else begin
            {kind_q4, kind_q3, kind_q2, kind_q1} <=
                {kind_q3, kind_q2, kind_q1, x2_at[2], x1_at[2], y_at[2]};
        end
    end

    // ---- x + (E h + B v), or C h + D v, without its fraction and before the loss.
    wire signed [FLOOR_W-1:0] floor = $signed(sum[SUM_W-1:SHIFT]);
    wire signed [STATE_W-1:0] base  = kind_q3[1] ? x1_q[place_q3] : x2_q[place_q3];
    reg  signed [NEXT_W-1:0]  next_q;

    wire signed [FLOOR_W-1:0] y_floor = floor >>> Y_SHIFT;
    wire unused_fraction = &{1'b0, sum[SHIFT-1:0]};

    always @(posedge clk) begin
        if (kind_q3[0]) begin
            next_q <= {{(NEXT_W - FLOOR_W){y_floor[FLOOR_W-1]}}, y_floor};
        end else begin
            next_q <= {{(NEXT_W - FLOOR_W){floor[FLOOR_W-1]}}, floor}
                    + {{(NEXT_W - STATE_W){base[STATE_W-1]}}, base};
        end
    end

    // ---- Nearer to zero by the loss, not past it: value - loss, or value + loss + 1 below zero.
    wire                     negative = next_q[NEXT_W-1];
    wire signed [NEXT_W-1:0] loss     = $signed({{(NEXT_W - LOSS_W){1'b0}}, loss_q4});
    wire signed [NEXT_W-1:0] brought  = next_q + (negative ? loss : ~loss)
                                      + $signed({{(NEXT_W-1){1'b0}}, 1'b1});
    wire                     passed   = brought[NEXT_W-1] != negative;
    wire signed [NEXT_W-1:0] kept     = passed ? {NEXT_W{1'b0}} : brought;

    wire signed [DATA_W-1:0]  y_limited;
    wire signed [DATA_W-1:0]  x_limited;
    wire                      x_fits = (kept[NEXT_W-1:STATE_W-1]
                                        == {(NEXT_W - STATE_W + 1){kept[NEXT_W-1]}});

    wh_saturate #(
        .IN_W    (NEXT_W),
        .OUT_W   (DATA_W)
    ) saturate_y (
        .value_i (kept),
        .value_o (y_limited)
    );

    // A state is limited in front of its guard bits, which are 0 at either limit.
    wh_saturate #(
        .IN_W    (NEXT_W - GUARD),
        .OUT_W   (DATA_W)
    ) saturate_x (
        .value_i ($signed(kept[NEXT_W-1:GUARD])),
        .value_o (x_limited)
    );

    wire at_the_top = (x_limited == {1'b0, {(DATA_W - 1){1'b1}}});
    wire [GUARD-1:0]          x_guard = (x_fits && !at_the_top) ? kept[GUARD-1:0] : {GUARD{1'b0}};
    wire signed [STATE_W-1:0] x_next  = clear ? {STATE_W{1'b0}} : $signed({x_limited, x_guard});

    // ---- What W was paid, less what it has given, of the port.
    localparam integer BUDGET_W = 2 * DATA_W + 2 * HEADROOM + 1;

    reg  signed [BUDGET_W-1:0] budget_q [0:N-1];
    reg         [1:0]          square_q1, square_q2, square_q3;  // a square is due: of v, of y

    wire signed [BUDGET_W-1:0] budget = budget_q[port_i];
    wire                       owes   = budget[BUDGET_W-1];
    wire        [BUDGET_W:0]   due    = {{(BUDGET_W + 1 - 2 * DATA_W){1'b0}}, product_i[2*DATA_W-1:0]};
    wire signed [BUDGET_W:0]   rest   = $signed({budget[BUDGET_W-1], budget})
                                      + $signed(square_q3[1] ? ~due : due)
                                      + $signed({{BUDGET_W{1'b0}}, square_q3[1]});
    wire                       full   = !rest[BUDGET_W] && rest[BUDGET_W-1];

    integer m;

    always @(posedge clk) begin
        if (rst) begin
            {square_q3, square_q2, square_q1} <= 6'd0;
            for (m = 0; m < N; m = m + 1) begin
                budget_q[m] <= {BUDGET_W{1'b0}};
            end
        end else begin
            {square_q3, square_q2, square_q1} <= {square_q2, square_q1, square_at & {2{runs}}};
            if (|square_q3) begin
                budget_q[port_i] <= full ? {1'b0, {(BUDGET_W - 1){1'b1}}} : $signed(rest[BUDGET_W-1:0]);
            end
        end
    end

    wire    last = (SECTIONS == 1) || place_q4[0];  // section, whose y is W's
    integer n;

    always @(posedge clk) begin
        if (at_q[VALUE]) begin
            wave0_q <= value_i;
        end
        if (kind_q4[0]) begin
            y_q <= !runs ? passed_on : (last && owes) ? {DATA_W{1'b0}} : y_limited;
        end
        if (rst) begin
            for (n = 0; n < N * SECTIONS; n = n + 1) begin
                x1_q[n] <= {STATE_W{1'b0}};
                x2_q[n] <= {STATE_W{1'b0}};
            end
        end else begin
            if (kind_q4[1] && (runs || clear)) begin
                x1_q[place_q4] <= x_next;
            end
            if (kind_q4[2] && (runs || clear)) begin
                x2_q[place_q4] <= x_next;
            end
        end
    end

    assign value_o = y_q;

    wire unused = &{1'b0, mode[0]};

endmodule

`default_nettype wire
