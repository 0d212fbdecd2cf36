// SPDX-License-Identifier: Apache-2.0
//
// wh_inverse_clarke: voltages of the legs a, b and c from those of the axes alpha and beta, about the
// middle of the bus.
//
//   a = alpha     b = √3/2 beta - alpha/2     c = -√3/2 beta - alpha/2
//   common = (max(a, b, c) + min(a, b, c)) / 2,     leg x = x - common
//
// What the legs have in common drives nothing in a star. With the highest and the lowest as far from
// the middle as each other, the bridge reaches all of its hexagon, 2/√3 of what it reaches without.
// sim/wavehaptics/controller/clarke.py, phases and centred, says the same with integers, and this
// module equals it bit for bit: products and halves are cut toward zero, and all three legs take off
// the same integer, so that what lies between two of them is what lies between the phases, to the bit.
// The product is made by a multiplier shared with other blocks (wh_multiply_shared), as in
// wh_current. alpha_i and beta_i hold from valid_i until valid_o.
//
// Formats: below; b and c saturate, and what is taken off them can't make them longer than a word.
// Latency: 8 clocks from valid_i to valid_o, and one more for each clock without grant; the legs hold
// until the next valid_o. Reset: no transform is under way, legs 0.

`default_nettype none
`include "wh_formats.vh"

module wh_inverse_clarke (
    input  wire                                    clk,
    input  wire                                    rst,

    input  wire                                    valid_i,        // strobe
    input  wire signed [`WH_DATA_W-1:0]            alpha_i,        // s31q23 V, +-128 V
    input  wire signed [`WH_DATA_W-1:0]            beta_i,         // s31q23 V, +-128 V

    output wire                                    request_o,
    input  wire                                    grant_i,
    output wire signed [`WH_DATA_W-1:0]            factor_o,       // s31q23 V, beta
    output wire signed [`WH_COEF_W-1:0]            coefficient_o,  // s27q25, √3/2
    input  wire                                    done_i,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i,      // s58q48 V

    output reg                                     valid_o,        // strobe
    output wire [3*`WH_DATA_W-1:0]                 legs_o          // s31q23 V each, leg a lowest
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam integer COEF_Q = COEF_W - 2;
    localparam integer SIDE_W = DATA_W + COEF_W - COEF_Q;
    localparam integer SUM_W  = SIDE_W + 1;

    localparam [61:0] HALF_ROOT3 = 62'h0ddb3d742c265539;  // u62q60, rounded down
    localparam [61:0] CONSTANT   = HALF_ROOT3 >> (60 - COEF_Q);

    generate
        if (COEF_Q < 1 || COEF_Q > 60) begin : illegal
            wh_illegal_WH_COEF_W_must_hold_half_of_root_3 stop ();
        end
    endgenerate

    wire unused_constant = &{1'b0, CONSTANT[61:COEF_W]};

    reg waiting_q;

    always @(posedge clk) begin
        if (rst || grant_i) begin
            waiting_q <= 1'b0;
        end else if (valid_i) begin
            waiting_q <= 1'b1;
        end
    end

    assign request_o     = valid_i || waiting_q;
    assign factor_o      = beta_i;
    assign coefficient_o = $signed(CONSTANT[COEF_W-1:0]);

    // ---- -alpha/2, toward zero: alpha stands long before the product does.
    wire signed [DATA_W-2:0] half_floor;
    wire                     half_up;
    reg  signed [DATA_W-1:0] minus_half_q;

    wh_truncate #(
        .IN_W    (DATA_W),
        .SHIFT   (1)
    ) truncate_half (
        .value_i (alpha_i),
        .floor_o (half_floor),
        .up_o    (half_up)
    );

    always @(posedge clk) begin
        minus_half_q <= $signed({DATA_W{1'b0}}) - $signed({half_floor[DATA_W-2], half_floor})
                        - $signed({{(DATA_W - 1){1'b0}}, half_up});
    end

    // ---- √3/2 beta, then b and c. What truncation adds goes in as a carry from a place below the
    // last: floor(((2 x + 1) + (2 y + up)) / 2) = x + y + up, floor((2 x - (2 y + up)) / 2) = x - y - up.
    wire signed [SIDE_W-1:0] side_floor;
    wire                     side_up;
    reg  signed [SIDE_W-1:0] side_floor_q;
    reg                      side_up_q;
    wire signed [SUM_W:0]    b_sum;
    wire signed [SUM_W:0]    c_sum;
    wire signed [DATA_W-1:0] b;
    wire signed [DATA_W-1:0] c;
    reg  signed [DATA_W-1:0] b_q;
    reg  signed [DATA_W-1:0] c_q;

    wh_truncate #(
        .IN_W    (DATA_W + COEF_W),
        .SHIFT   (COEF_Q)
    ) truncate_side (
        .value_i (product_i),
        .floor_o (side_floor),
        .up_o    (side_up)
    );

    wire signed [SUM_W-1:0] minus_half =
        $signed({{(SUM_W - DATA_W){minus_half_q[DATA_W-1]}}, minus_half_q});

    assign b_sum = $signed({minus_half, 1'b1})
                   + $signed({side_floor_q[SIDE_W-1], side_floor_q, side_up_q});
    assign c_sum = $signed({minus_half, 1'b0})
                   - $signed({side_floor_q[SIDE_W-1], side_floor_q, side_up_q});

    wh_saturate #(
        .IN_W    (SUM_W),
        .OUT_W   (DATA_W)
    ) saturate_b (
        .value_i ($signed(b_sum[SUM_W:1])),
        .value_o (b)
    );

    wh_saturate #(
        .IN_W    (SUM_W),
        .OUT_W   (DATA_W)
    ) saturate_c (
        .value_i ($signed(c_sum[SUM_W:1])),
        .value_o (c)
    );

    always @(posedge clk) begin
        if (done_i) begin
            side_floor_q <= side_floor;
            side_up_q    <= side_up;
        end
        b_q <= b;
        c_q <= c;
    end

    // ---- The middle between the highest and the lowest.
    wire                     a_over_b = alpha_i > b_q;
    wire                     b_over_c = b_q > c_q;
    wire                     a_over_c = alpha_i > c_q;
    wire signed [DATA_W-1:0] highest  = a_over_b ? (a_over_c ? alpha_i : c_q)
                                                 : (b_over_c ? b_q : c_q);
    wire signed [DATA_W-1:0] lowest   = a_over_b ? (b_over_c ? c_q : b_q)
                                                 : (a_over_c ? c_q : alpha_i);
    reg  signed [DATA_W-1:0] highest_q;
    reg  signed [DATA_W-1:0] lowest_q;
    reg  signed [DATA_W:0]   ends_q;
    wire signed [DATA_W-1:0] common_floor;
    wire                     common_up;

    wh_truncate #(
        .IN_W    (DATA_W + 1),
        .SHIFT   (1)
    ) truncate_common (
        .value_i (ends_q),
        .floor_o (common_floor),
        .up_o    (common_up)
    );

    always @(posedge clk) begin
        highest_q <= highest;
        lowest_q  <= lowest;
        ends_q    <= $signed({highest_q[DATA_W-1], highest_q})
                     + $signed({lowest_q[DATA_W-1], lowest_q});
    end

    // ---- The legs. x - common is shorter than a word, whatever the words: no limit is needed.
    reg signed [DATA_W-1:0] a_leg_q;
    reg signed [DATA_W-1:0] b_leg_q;
    reg signed [DATA_W-1:0] c_leg_q;

    wire signed [DATA_W-1:0] common = common_floor + $signed({{(DATA_W - 1){1'b0}}, common_up});

    reg [3:0] stage_q;  // clocks since the product, one bit each

    always @(posedge clk) begin
        if (rst) begin
            stage_q <= 4'd0;
            valid_o <= 1'b0;
            a_leg_q <= {DATA_W{1'b0}};
            b_leg_q <= {DATA_W{1'b0}};
            c_leg_q <= {DATA_W{1'b0}};
        end else begin
            stage_q <= {stage_q[2:0], done_i};
            valid_o <= stage_q[3];
            if (stage_q[3]) begin
                a_leg_q <= alpha_i - common;
                b_leg_q <= b_q - common;
                c_leg_q <= c_q - common;
            end
        end
    end

    assign legs_o = {c_leg_q, b_leg_q, a_leg_q};

    wire unused = &{1'b0, b_sum[0], c_sum[0]};

endmodule

`default_nettype wire
