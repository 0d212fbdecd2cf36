// SPDX-License-Identifier: Apache-2.0
//
// wh_shaper_ports: the wave-domain filter W{v} of N ports that take turns, in SECTIONS sections of two states each.
//
//   [x1' x2' y] = M [x1 x2 v],  |M| <= 1;  budget += v^2 - y^2, and while it is below 0, y is 0
//
// It does for each port what wh_shaper does for one, in every bit: equations, formats, losses and the budget are in
// that header. Its multiplier is its own: a coefficient has more bits than the others', and its products are as many
// as all others' together.
//
// mode_i: 0 W = 1 and the states become 0, 1 W = 1 and they stay as they are, 2 W.
//
// The turn, in clocks since turn_i: value_i is taken in 5, value_o is there from 5 + 5 SECTIONS to the next
// turn's. mode_i counts from 8 on. The turn ends, and with it port_i, bank_i and mode_i need to hold, 20 clocks after
// turn_i at one section, 31 at two, and the next one may begin then.
// State, by port, in LUT RAM (wh_port_state): two states of 40 bits for each section, the budget (71).
// Settings: coefficients and losses in two block RAMs (wh_port_settings), each read in the clock before its use.
// Latency: above. Reset: all states and the budget 0, for all ports; a turn under way ends.

`default_nettype none
`include "wh_formats.vh"

module wh_shaper_ports #(
    parameter integer N        = 1,                        // ports, 1...8
    parameter integer SECTIONS = 1,                        // 1...2
    parameter integer PORT_W   = (N > 1) ? $clog2(N) : 1   // derived, leave it
) (
    input  wire                         clk,
    input  wire                         rst,

    // A turn.
    input  wire                         turn_i,     // strobe
    input  wire        [PORT_W-1:0]     port_i,
    input  wire                         bank_i,     // of its settings
    input  wire        [1:0]            mode_i,
    input  wire signed [`WH_DATA_W-1:0] value_i,    // s31q23 √W, ±128 √W
    output wire signed [`WH_DATA_W-1:0] value_o,    // s31q23 √W, ±128 √W

    // The register bus (wh_port_settings).
    input  wire                         write_i,
    input  wire                         write_bank_i,
    input  wire        [11:0]           address_i,
    input  wire        [31:0]           data_i
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer SHAPE_W   = `WH_SHAPE_W;
    localparam integer LOSS_W    = `WH_SHAPE_LOSS_W;
    localparam integer GUARD     = `WH_STATE_GUARD;
    localparam integer HEADROOM  = `WH_SHAPE_HEADROOM;
    localparam integer STATE_W   = DATA_W + GUARD;
    localparam integer PRODUCT_W = DATA_W + SHAPE_W;
    localparam integer SHIFT     = `WH_SHAPE_Q - GUARD;   // from a product to a state
    localparam integer Y_SHIFT   = GUARD - HEADROOM;      // from a state to a wave
    localparam integer SUM_W     = PRODUCT_W + 2;         // three products
    localparam integer FLOOR_W   = SUM_W - SHIFT;
    localparam integer NEXT_W    = 1 + ((FLOOR_W > STATE_W) ? FLOOR_W : STATE_W);
    localparam integer PLACES    = N * SECTIONS;
    localparam integer PLACE_W   = (PLACES > 1) ? $clog2(PLACES) : 1;

    generate
        if (N < 1 || N > 8 || SECTIONS < 1 || SECTIONS > 2) begin : illegal_parameter
            wh_illegal_parameter_shaper_ports_n_or_sections stop ();
        end
        if (SHIFT < 1 || Y_SHIFT < 1 || GUARD < 2 || SHAPE_W < DATA_W) begin : illegal_format
            wh_illegal_parameter_shaper_ports_formats stop ();
        end
    endgenerate

    // ---- The table of slots, by the clock of the turn: three slots make a result, the first two with the states,
    // the third with the wave that comes in. From the lowest bit: the slots of y, x1 and x2 of the first section,
    // then of the second.
    localparam integer VALUE  = 5;   // value_i is there
    localparam integer SQUARE = (SECTIONS == 1) ? 14 : 25;  // of what came in, and then of what comes out
    localparam integer LAST   = SQUARE + 1;

    reg  [LAST:1] at_q;
    wire [LAST:1] ahead = {at_q[LAST-1:1], turn_i};  // the clock after this one
    wire [17:0]   slots;
    wire [17:0]   next;

    generate
        if (SECTIONS == 1) begin : slots_of_one
            assign slots = {9'd0, at_q[13:11], at_q[8:6], at_q[5:3]};
            assign next  = {9'd0, ahead[13:11], ahead[8:6], ahead[5:3]};
        end else begin : slots_of_two
            assign slots = {at_q[24:22], at_q[20:18], at_q[10:8], at_q[17:16], at_q[14], at_q[13:11], at_q[5:3]};
            assign next  = {ahead[24:22], ahead[20:18], ahead[10:8], ahead[17:16], ahead[14], ahead[13:11],
                            ahead[5:3]};
        end
    endgenerate

    always @(posedge clk) begin
        at_q <= rst ? {LAST{1'b0}} : ahead;
    end

    wire [2:0] y_at      = slots[2:0] | slots[11:9];
    wire [2:0] x1_at     = slots[5:3] | slots[14:12];
    wire [2:0] x2_at     = slots[8:6] | slots[17:15];
    wire [2:0] any       = y_at | x1_at | x2_at;
    wire       second    = |slots[17:9];  // section of the slot
    wire [1:0] square_at = {at_q[SQUARE+1], at_q[SQUARE]};
    wire       runs      = mode_i[1];
    wire       clear     = (mode_i == 2'd0);

    // ---- Coefficients, in the order of the register map: e11 e12 e21 e22 b1 b2 c1 c2 d.
    wire        [2:0]         y_next  = next[2:0] | next[11:9];
    wire        [2:0]         x1_next = next[5:3] | next[14:12];
    wire        [2:0]         x2_next = next[8:6] | next[17:15];
    reg         [4:0]         word;
    wire        [SHAPE_W-1:0] coefficient;

    always @* begin
        case ({y_next, x1_next, x2_next})
            9'b001_000_000: word = 5'd6;
            9'b010_000_000: word = 5'd7;
            9'b100_000_000: word = 5'd8;
            9'b000_001_000: word = 5'd0;
            9'b000_010_000: word = 5'd1;
            9'b000_100_000: word = 5'd4;
            9'b000_000_001: word = 5'd2;
            9'b000_000_010: word = 5'd3;
            default:        word = 5'd5;
        endcase
    end

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (5),
        .W            (SHAPE_W),
        .FIRST        (128)
    ) coefficients (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (|next),
        .bank_i       (bank_i),
        .port_i       (port_i),
        .word_i       ((|next[17:9]) ? word + 5'd9 : word),
        .word_o       (coefficient)
    );

    // ---- A place of the states for each section of each port.
    wire [PLACE_W-1:0] place;
    reg  [PLACE_W-1:0] place_q1, place_q2, place_q3, place_q4;
    reg                second_q1, second_q2, second_q3, second_q4;

    generate
        if (SECTIONS == 1) begin : places_of_one
            assign place = port_i;
        end else if (N == 1) begin : places_of_two
            wire unused_port = &{1'b0, port_i};

            assign place = second;
        end else begin : places_of_many
            assign place = {port_i, second};
        end
    endgenerate

    // ---- The states. A result's base is read where no slot of another section has the state.
    reg  [2:0]                any_q1, any_q2, any_q3;
    reg  [2:0]                kind_q1, kind_q2, kind_q3, kind_q4;  // last product of y, x1, x2
    wire signed [STATE_W-1:0] x1;
    wire signed [STATE_W-1:0] x2;
    wire signed [STATE_W-1:0] x_next;

    wh_port_state #(
        .N           (PLACES),
        .W           (STATE_W)
    ) x1_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (kind_q3[1] ? place_q3 : place),
        .save_i      (kind_q4[1] && (runs || clear)),
        .save_port_i (place_q4),
        .value_i     (x_next),
        .value_o     (x1)
    );

    wh_port_state #(
        .N           (PLACES),
        .W           (STATE_W)
    ) x2_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (kind_q3[2] ? place_q3 : place),
        .save_i      (kind_q4[2] && (runs || clear)),
        .save_port_i (place_q4),
        .value_i     (x_next),
        .value_o     (x2)
    );

    // ---- The factors.
    wire signed [STATE_W-1:0] state   = any[0] ? x1 : x2;
    // A state has no more than the largest word above its guard bits, so that this can't carry out.
    wire signed [STATE_W-1:0] rounded = state + $signed({{DATA_W{1'b0}}, 1'b1, {(GUARD-1){1'b0}}});
    wire                      unused_rounded = &{1'b0, rounded[GUARD-1:0]};
    reg  signed [DATA_W-1:0]  wave0_q;  // what the first section takes
    wire signed [DATA_W-1:0]  wave;
    wire signed [DATA_W-1:0]  passed_on;  // what a section took and gives on where W is 1
    reg  signed [DATA_W-1:0]  y_q;

    generate
        if (SECTIONS == 1) begin : wave_of_one
            wire unused_second = &{1'b0, second_q4};

            assign wave      = at_q[VALUE] ? value_i : wave0_q;
            assign passed_on = wave0_q;
        end else begin : wave_of_two
            reg signed [DATA_W-1:0] wave1_q;  // what the second takes

            assign wave      = at_q[VALUE] ? value_i : slots[11] ? y_q : second ? wave1_q : wave0_q;
            assign passed_on = second_q4 ? wave1_q : wave0_q;

            always @(posedge clk) begin
                if (slots[11]) begin
                    wave1_q <= y_q;
                end
            end
        end
    endgenerate

    wire signed [DATA_W-1:0]    squared = square_at[1] ? y_q : wave0_q;
    wire signed [DATA_W-1:0]    factor  = (|square_at) ? squared : any[2] ? wave : $signed(rounded[STATE_W-1:GUARD]);
    wire signed [SHAPE_W-1:0]   coef    = (|square_at) ? $signed({{(SHAPE_W - DATA_W + 1){squared[DATA_W-1]}},
                                                                  squared[DATA_W-2:0]})
                                                       : $signed(coefficient);
    wire signed [PRODUCT_W-1:0] product;
    reg                         given_q;

    wh_multiply #(
        .COEF_W    (SHAPE_W)
    ) multiply (
        .clk       (clk),
        .take_i    (given_q),
        .data_i    (factor),
        .coef_i    (coef),
        .product_o (product)
    );

    // ---- The sum of a result's products, and the slot's own story 3 clocks later.
    reg  signed [SUM_W-1:0]     sum_q;
    wire signed [PRODUCT_W-1:0] aligned = any_q3[2] ? (product >>> HEADROOM) : product;
    wire signed [SUM_W-1:0]     sum     = (any_q3[0] ? {SUM_W{1'b0}} : sum_q)
                                        + {{2{aligned[PRODUCT_W-1]}}, aligned};
    wire                        unused_fraction = &{1'b0, sum[SHIFT-1:0]};

    always @(posedge clk) begin
        given_q   <= (|any) || (|square_at);
        any_q1    <= any;
        any_q2    <= any_q1;
        any_q3    <= any_q2;
        place_q1  <= place;
        place_q2  <= place_q1;
        place_q3  <= place_q2;
        place_q4  <= place_q3;
        second_q1 <= second;
        second_q2 <= second_q1;
        second_q3 <= second_q2;
        second_q4 <= second_q3;
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

    // ---- Losses, in the order of the register map behind the coefficients: x1 x2 y.
    wire [LOSS_W-1:0] loss_word;
    wire [2:0]        loss_place = (second_q3 ? 3'd5 : 3'd2) + {1'b0, kind_q3[0], kind_q3[2]};

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (3),
        .W            (LOSS_W),
        .FIRST        (144)
    ) losses (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (|kind_q3),
        .bank_i       (bank_i),
        .port_i       (port_i),
        .word_i       (loss_place),
        .word_o       (loss_word)
    );

    // ---- x + (E h + B v), or C h + D v, without its fraction and before the loss.
    wire signed [FLOOR_W-1:0] floor   = $signed(sum[SUM_W-1:SHIFT]);
    wire signed [FLOOR_W-1:0] y_floor = floor >>> Y_SHIFT;
    wire signed [STATE_W-1:0] base    = kind_q3[1] ? x1 : x2;
    reg  signed [NEXT_W-1:0]  next_q;

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
    wire signed [NEXT_W-1:0] loss     = $signed({{(NEXT_W - LOSS_W){1'b0}}, loss_word});
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

    wire             at_the_top = (x_limited == {1'b0, {(DATA_W - 1){1'b1}}});
    wire [GUARD-1:0] x_guard    = (x_fits && !at_the_top) ? kept[GUARD-1:0] : {GUARD{1'b0}};

    assign x_next = clear ? {STATE_W{1'b0}} : $signed({x_limited, x_guard});

    // ---- What W was paid, less what it has given.
    localparam integer BUDGET_W = 2 * DATA_W + 2 * HEADROOM + 1;

    reg         [1:0]          square_q1, square_q2, square_q3;  // a square is due: of v, of y
    wire signed [BUDGET_W-1:0] budget;
    wire                       owes = budget[BUDGET_W-1];
    wire        [BUDGET_W:0]   due  = {{(BUDGET_W + 1 - 2 * DATA_W){1'b0}}, product[2*DATA_W-1:0]};
    wire signed [BUDGET_W:0]   rest = $signed({budget[BUDGET_W-1], budget})
                                      + $signed(square_q3[1] ? ~due : due)
                                      + $signed({{BUDGET_W{1'b0}}, square_q3[1]});
    wire                       full = !rest[BUDGET_W] && rest[BUDGET_W-1];
    wire        [BUDGET_W-1:0] paid = full ? {1'b0, {(BUDGET_W - 1){1'b1}}} : rest[BUDGET_W-1:0];

    always @(posedge clk) begin
        if (rst) begin
            {square_q3, square_q2, square_q1} <= 6'd0;
        end else begin
            {square_q3, square_q2, square_q1} <= {square_q2, square_q1, square_at & {2{runs}}};
        end
    end

    wh_port_state #(
        .N           (N),
        .W           (BUDGET_W)
    ) budget_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_i),
        .save_i      (|square_q3),
        .save_port_i (port_i),
        .value_i     (paid),
        .value_o     (budget)
    );

    // ---- The wave: the last section's y is W's.
    wire last = (SECTIONS == 1) || second_q4;

    always @(posedge clk) begin
        if (at_q[VALUE]) begin
            wave0_q <= value_i;
        end
        if (kind_q4[0]) begin
            y_q <= !runs ? passed_on : (last && owes) ? {DATA_W{1'b0}} : y_limited;
        end
    end

    assign value_o = y_q;

endmodule

`default_nettype wire
