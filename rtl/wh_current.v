// SPDX-License-Identifier: Apache-2.0
//
// wh_current: the mean current of a tick from the sum of its ADC samples.
//
//   current = round((sum of samples_i samples - zero) * gain) - offset
//
// zero is the sum that stands for 0 A, measured with the bridge off. gain is the amperes of an ADC step over the number
// of samples. Rounding is to the nearest, halves away from zero; the result saturates. offset is what the port anchor
// finds besides zero.
// ends_o: the current is only bounded. A sample of its sum was at range_i or beyond, or the result saturated. At the
// high end (bit 0) the true current may be larger, at the low end (bit 1) smaller.
// The product comes from a multiplier shared with other blocks (wh_multiply_shared): request_o stays until grant_i,
// factor_o and gain_i are the operands, and done_i indicates that product_i is valid.
// Formats: below. Latency: 6 clocks from the last valid_i to valid_o, and one more for each clock without grant.
// first_i begins a new sum at any time. Reset: no sum has begun.

`default_nettype none
`include "wh_formats.vh"

module wh_current (
    input  wire                                    clk,
    input  wire                                    rst,

    input  wire                                    valid_i,    // strobe
    input  wire                                    first_i,    // with valid_i: first of a tick
    input  wire signed [`WH_SAMPLE_W-1:0]          sample_i,   // s16, +-2^15 is full scale

    input  wire [8:0]                              samples_i,  // words in a sum, 1...256
    input  wire [15:0]                             range_i,    // of 2^15, end of the range; more: none
    input  wire signed [`WH_SUM_W-1:0]             zero_i,     // s24, the sum at 0 A

    output wire                                    request_o,
    input  wire                                    grant_i,
    output wire signed [`WH_DATA_W-1:0]            factor_o,   // s31q0, sum - zero
    input  wire                                    done_i,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i,  // s58q35 A

    input  wire signed [`WH_DATA_W-1:0]            offset_i,   // s31q24 A, taken off

    output reg                                     valid_o,    // strobe
    output reg  signed [`WH_DATA_W-1:0]            current_o,  // s31q24 A, +-64 A
    output reg  [1:0]                              ends_o      // of current_o
);

    localparam integer DIFFERENCE_W = `WH_SUM_W + 1;
    localparam integer PRODUCT_W    = DIFFERENCE_W + `WH_COEF_W;  // as far as product_i is used
    localparam integer SHIFT        = `WH_GAIN_Q - `WH_CURRENT_Q;
    localparam integer ROUND_W      = PRODUCT_W - SHIFT + 1;
    localparam integer NEAR_W       = `WH_DATA_W + 1;
    localparam integer WIDE_W       = (ROUND_W > NEAR_W) ? ROUND_W : NEAR_W;

    generate
        if (`WH_DATA_W < DIFFERENCE_W) begin : illegal
            wh_illegal_WH_DATA_W_must_hold_a_tick_sum_WH_SUM_W_plus_1 stop ();
        end
    endgenerate

    // The sum begins at -zero, so that the difference is there with the last word. 256 words of 16
    // bits and the zero: 25 bits hold it.
    reg signed [DIFFERENCE_W-1:0] sum_q;
    reg        [8:0]              count_q;    // words in sum_q
    reg                           request_q;

    wire signed [DIFFERENCE_W-1:0] zero   = {zero_i[`WH_SUM_W-1], zero_i};
    wire signed [DIFFERENCE_W-1:0] base   = first_i ? ~zero : sum_q;
    wire signed [DIFFERENCE_W-1:0] sample =
        {{DIFFERENCE_W-`WH_SAMPLE_W{sample_i[`WH_SAMPLE_W-1]}}, sample_i};
    wire        [8:0]              count  = first_i ? 9'd1 : count_q + 9'd1;

    always @(posedge clk) begin
        if (valid_i) begin
            // -zero is ~zero + 1.
            sum_q <= base + sample + $signed({{DIFFERENCE_W-1{1'b0}}, first_i});
        end
    end

    always @(posedge clk) begin
        if (rst) begin
            count_q   <= 9'd0;
            request_q <= 1'b0;
        end else if (valid_i) begin
            count_q   <= count;
            request_q <= (count == samples_i);
        end else if (grant_i) begin
            request_q <= 1'b0;
        end
    end

    // Whether a word is at an end of the range, and which words of the sum were.
    reg  [1:0]              sum_ends_q;
    reg  [1:0]              ends_q;       // of the sum whose product was asked for
    wire [`WH_SAMPLE_W-1:0] magnitude = sample_i[`WH_SAMPLE_W-1] ? -sample_i : sample_i;
    wire                    at_end    = (magnitude >= range_i);
    wire [1:0]              word_ends = {at_end && sample_i[`WH_SAMPLE_W-1],
                                         at_end && !sample_i[`WH_SAMPLE_W-1]};

    always @(posedge clk) begin
        if (valid_i) begin
            sum_ends_q <= word_ends | (first_i ? 2'b00 : sum_ends_q);
        end
        if (grant_i) begin
            ends_q <= sum_ends_q;
        end
    end

    assign request_o = request_q;
    assign factor_o  = {{`WH_DATA_W-DIFFERENCE_W{sum_q[DIFFERENCE_W-1]}}, sum_q};

    // 25 x 27 bits: above the product there is nothing but its sign.
    wire unused = &{1'b0, product_i[`WH_DATA_W+`WH_COEF_W-1:PRODUCT_W]};

    // Rounded in one clock, in the next less the offset and saturated.
    wire signed [ROUND_W-1:0]    rounded;
    reg  signed [ROUND_W-1:0]    rounded_q;
    reg                          rounded_valid_q;
    wire signed [`WH_DATA_W-1:0] saturated;

    wh_round #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (SHIFT)
    ) round (
        .value_i ($signed(product_i[PRODUCT_W-1:0])),
        .value_o (rounded)
    );

    // What doesn't fit NEAR_W bits is saturated whatever the offset, so that no more are subtracted:
    // their carry would be the slowest path of an iCE40.
    wire signed [WIDE_W-1:0] wide = {{(WIDE_W - ROUND_W + 1){rounded_q[ROUND_W-1]}},
                                     rounded_q[ROUND_W-2:0]};
    wire                     back = wide[WIDE_W-1];
    wire                     far  = (wide[WIDE_W-1:NEAR_W-1] != {(WIDE_W - NEAR_W + 1){back}});
    wire signed [NEAR_W:0]   near = $signed({wide[NEAR_W-1], wide[NEAR_W-1:0]})
                                    - $signed({{2{offset_i[`WH_DATA_W-1]}}, offset_i});
    wire signed [NEAR_W:0]   less = $signed({far ? {back, !back} : near[NEAR_W:NEAR_W-1],
                                             near[NEAR_W-2:0]});

    wh_saturate #(
        .IN_W    (NEAR_W + 1),
        .OUT_W   (`WH_DATA_W)
    ) saturate (
        .value_i (less),
        .value_o (saturated)
    );

    wire high = !less[NEAR_W] && (|less[NEAR_W-1:`WH_DATA_W-1]);
    wire low  = less[NEAR_W] && !(&less[NEAR_W-1:`WH_DATA_W-1]);

    always @(posedge clk) begin
        rounded_q <= rounded;
        if (rst) begin
            rounded_valid_q <= 1'b0;
            valid_o         <= 1'b0;
            current_o       <= {`WH_DATA_W{1'b0}};
            ends_o          <= 2'b00;
        end else begin
            rounded_valid_q <= done_i;
            valid_o         <= rounded_valid_q;
            if (rounded_valid_q) begin
                current_o <= saturated;
                ends_o    <= ends_q | {low, high};
            end
        end
    end

endmodule

`default_nettype wire
