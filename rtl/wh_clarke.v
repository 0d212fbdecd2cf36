// SPDX-License-Identifier: Apache-2.0
//
// wh_clarke: currents of the axes alpha and beta from those of the phases a and b of a star, whose
// third is c = -a - b.
//
//   alpha = a      beta = (a + 2 b)/√3 = 2/√3 (a/2 + b)
//
// Amplitude-invariant. sim/wavehaptics/controller/clarke.py, currents, says the same with integers, and
// this module equals it bit for bit: cut toward zero twice, with a coefficient that is rounded down,
// so that the vector never gets longer; sums saturate.
// A current beyond its word is at the end of its range (ends_o, as wh_current has it): beta's, where
// the saturated sum takes beta to its end.
// The product is made by a multiplier shared with other blocks (wh_multiply_shared), as in
// wh_current. a_i and b_i hold from valid_i until valid_o.
//
// Formats: below. Latency: 7 clocks from valid_i to valid_o, and one more for each clock without
// grant. Reset: no transform is under way.

`default_nettype none
`include "wh_formats.vh"

module wh_clarke (
    input  wire                                    clk,
    input  wire                                    rst,

    input  wire                                    valid_i,        // strobe
    input  wire signed [`WH_DATA_W-1:0]            a_i,            // s31q24 A, +-64 A
    input  wire signed [`WH_DATA_W-1:0]            b_i,            // s31q24 A, +-64 A

    output wire                                    request_o,
    input  wire                                    grant_i,
    output wire signed [`WH_DATA_W-1:0]            factor_o,       // s31q24 A, a/2 + b
    output wire signed [`WH_COEF_W-1:0]            coefficient_o,  // s27q25, 2/√3
    input  wire                                    done_i,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i,      // s58q49 A

    output reg                                     valid_o,        // strobe
    output reg  signed [`WH_DATA_W-1:0]            alpha_o,        // s31q24 A, +-64 A
    output reg  signed [`WH_DATA_W-1:0]            beta_o,         // s31q24 A, +-64 A
    output wire [1:0]                              beta_ends_o     // it is the largest, the least word
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam integer COEF_Q = COEF_W - 2;
    localparam integer SUM_W  = DATA_W + 2;
    localparam integer HALF_W = SUM_W - 1;
    localparam integer BETA_W = DATA_W + COEF_W - COEF_Q;

    localparam [61:0] TWO_OVER_ROOT3 = 62'h1279a74590331c4d;  // u62q60, rounded down
    localparam [61:0] CONSTANT       = TWO_OVER_ROOT3 >> (60 - COEF_Q);

    assign coefficient_o = $signed(CONSTANT[COEF_W-1:0]);

    generate
        if (COEF_Q < 1 || COEF_Q > 60) begin : illegal
            wh_illegal_WH_COEF_W_must_hold_2_over_root_3 stop ();
        end
    endgenerate

    wire unused_constant = &{1'b0, CONSTANT[61:COEF_W]};

    // ---- a + 2 b, then half of it.
    reg                      summed_q;
    reg                      request_q;
    reg  signed [SUM_W-1:0]  sum_q;
    reg  signed [DATA_W-1:0] half_q;
    wire signed [HALF_W-1:0] half_floor;
    wire                     half_up;
    wire signed [DATA_W-1:0] half;

    wh_truncate #(
        .IN_W    (SUM_W),
        .SHIFT   (1)
    ) truncate_half (
        .value_i (sum_q),
        .floor_o (half_floor),
        .up_o    (half_up)
    );

    wh_saturate #(
        .IN_W    (HALF_W),
        .OUT_W   (DATA_W)
    ) saturate_half (
        .value_i (half_floor + $signed({{(HALF_W - 1){1'b0}}, half_up})),
        .value_o (half)
    );

    always @(posedge clk) begin
        sum_q <= $signed({{2{a_i[DATA_W-1]}}, a_i}) + $signed({b_i[DATA_W-1], b_i, 1'b0});
        if (summed_q) begin
            half_q <= half;
        end
        if (rst) begin
            summed_q  <= 1'b0;
            request_q <= 1'b0;
        end else begin
            summed_q  <= valid_i;
            request_q <= summed_q || (request_q && !grant_i);
        end
    end

    assign request_o = request_q;
    assign factor_o  = half_q;

    // ---- The product, cut in one clock, summed and saturated in the next.
    wire signed [BETA_W-1:0] beta_floor;
    wire                     beta_up;
    reg  signed [BETA_W-1:0] beta_floor_q;
    reg                      beta_up_q;
    reg                      cut_q;
    wire signed [DATA_W-1:0] beta;

    wh_truncate #(
        .IN_W    (DATA_W + COEF_W),
        .SHIFT   (COEF_Q)
    ) truncate_beta (
        .value_i (product_i),
        .floor_o (beta_floor),
        .up_o    (beta_up)
    );

    wh_saturate #(
        .IN_W    (BETA_W),
        .OUT_W   (DATA_W)
    ) saturate_beta (
        .value_i (beta_floor_q + $signed({{(BETA_W - 1){1'b0}}, beta_up_q})),
        .value_o (beta)
    );

    always @(posedge clk) begin
        beta_floor_q <= beta_floor;
        beta_up_q    <= beta_up;
        if (rst) begin
            cut_q   <= 1'b0;
            valid_o <= 1'b0;
            alpha_o <= {DATA_W{1'b0}};
            beta_o  <= {DATA_W{1'b0}};
        end else begin
            cut_q   <= done_i;
            valid_o <= cut_q;
            if (cut_q) begin
                alpha_o <= a_i;
                beta_o  <= beta;
            end
        end
    end

    assign beta_ends_o = {beta_o[DATA_W-1] && !(|beta_o[DATA_W-2:0]),
                          !beta_o[DATA_W-1] && (&beta_o[DATA_W-2:0])};

endmodule

`default_nettype wire
