// SPDX-License-Identifier: Apache-2.0
//
// wh_modulator: makes a voltage into half pulse widths in whole clocks, with error feedback.
//
//   duty  = truncate(voltage * clocks_per_volt),  clocks_per_volt = half_clocks / (2 Vbus)
//   total = duty + extra + owed
//   width = round(total), clipped to +- limit,    limit = half_clocks / 2 (rounded down) - spare, or 0
//   rest  = total - width, or 0 if the width was clipped
//   owed  = rest                         order 1: the width's error is shaped by 1 - z^-1
//         = 2 rest - rest of the half before        order 2: by (1 - z^-1)^2
//
// once a half, so what the clock is too coarse for in one half is made good in the next ones: the
// sum of the widths stays within half a clock of the sum of the duties, or, with order 2, within
// one. What a clipped half could not give is not owed to later ones, or it would wind up.
// Everything is odd in the voltage. With MIN_PULSE = 1 a width below least_i is 0, or least_i where
// that is nearer, and what it is off by is owed like any rest; spare_i keeps the pulses on the other
// side of the half from getting too short. extra is what the bridge takes away (wh_dead_time): it is
// used from the next half on.
//
// A voltage becomes the pending duty; take_i, 4 clocks before the tick's last update_i, makes it that
// of the tick to come. width_o belongs to the half that begins after update_i, and is ready 5 clocks
// after the update_i before.
// The product is made by a multiplier shared with other blocks (wh_multiply_shared), as in
// wh_current; voltage_i holds from valid_i until grant_i.
//
// Formats: below; duty and total hold the whole product, and can't overflow. Latency: 4 clocks
// from valid_i to where take_i finds the duty, and one more for each clock without grant.
// Reset: duty, rests and width 0, after one clock of it; products under way are the multiplier's to
// drop.

`default_nettype none
`include "wh_formats.vh"

module wh_modulator #(
    parameter integer MIN_PULSE = 0   // 1: least_i and spare_i count; 0: both are 0
) (
    input  wire                                    clk,
    input  wire                                    rst,

    input  wire                                    valid_i,            // strobe
    input  wire signed [`WH_DATA_W-1:0]            voltage_i,          // s31q23 V, +-128 V

    input  wire signed [`WH_COEF_W-1:0]            clocks_per_volt_i,  // s27q16 clocks/V, 0...1023
    input  wire        [`WH_TICK_W-1:0]            half_clocks_i,      // clocks in a half, 6...
    input  wire                                    second_order_i,     // 1: order 2
    input  wire signed [`WH_EXTRA_W-1:0]           extra_i,            // s17q8 clocks
    input  wire        [7:0]                       least_i,            // clocks, width that isn't 0
    input  wire        [7:0]                       spare_i,            // clocks

    output wire                                    request_o,
    input  wire                                    grant_i,
    output wire signed [`WH_DATA_W-1:0]            factor_o,           // s31q23 V
    output wire signed [`WH_COEF_W-1:0]            coefficient_o,      // s27q16 clocks/V
    input  wire                                    done_i,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i,          // s58q39 clocks

    input  wire                                    take_i,             // strobe, tick_o - 4 clocks
    input  wire                                    update_i,           // strobe, end of a half, or
                                                                       // of a period (wh_pwm)
    output reg  signed [`WH_TICK_W-1:0]            width_o             // s16, clocks
);

    localparam integer PRODUCT_W = `WH_DATA_W + `WH_COEF_W;
    localparam integer FRACTION  = `WH_DUTY_Q;
    localparam integer DUTY_W    = PRODUCT_W - `WH_VOLTAGE_Q;   // s35q16
    localparam integer REST_W    = FRACTION + ((MIN_PULSE != 0) ? 9 : 1);     // s17q16
    localparam integer OWED_W    = `WH_EXTRA_W + FRACTION - `WH_EXTRA_Q
                                   + ((MIN_PULSE != 0) ? 2 : 1);              // s26q16
    localparam integer TOTAL_W   = DUTY_W + 1;                  // s36q16
    localparam integer ROUND_W   = TOTAL_W - FRACTION + 1;      // s21

    generate
        if (ROUND_W < `WH_TICK_W + 1) begin : illegal
            wh_illegal_WH_DATA_W_or_WH_COEF_W_too_small_for_a_pulse_width stop ();
        end
        if (MIN_PULSE != 0 && MIN_PULSE != 1) begin : illegal_min_pulse
            wh_illegal_parameter_modulator_min_pulse_must_be_0_or_1 stop ();
        end
    endgenerate

    reg waiting_q;

    always @(posedge clk) begin
        if (rst || grant_i) begin
            waiting_q <= 1'b0;
        end else if (valid_i) begin
            waiting_q <= 1'b1;
        end
    end

    assign request_o     = valid_i || waiting_q;
    assign factor_o      = voltage_i;
    assign coefficient_o = clocks_per_volt_i;

    // A duty is a floor and what wh_truncate leaves to be added, which the total takes as its carry.
    reg  signed [DUTY_W-1:0] pending_q;  // s35q16 clocks
    reg                      pending_up_q;
    reg  signed [DUTY_W-1:0] active_q;   // s35q16 clocks
    reg                      active_up_q;
    wire signed [DUTY_W-1:0] duty_floor;
    wire                     duty_up;

    wh_truncate #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (`WH_VOLTAGE_Q)
    ) truncate (
        .value_i (product_i),
        .floor_o (duty_floor),
        .up_o    (duty_up)
    );

    always @(posedge clk) begin
        if (rst) begin
            pending_q    <= {DUTY_W{1'b0}};
            pending_up_q <= 1'b0;
            active_q     <= {DUTY_W{1'b0}};
            active_up_q  <= 1'b0;
        end else begin
            if (done_i) begin
                pending_q    <= duty_floor;
                pending_up_q <= duty_up;
            end
            if (take_i) begin
                active_q    <= pending_q;
                active_up_q <= pending_up_q;
            end
        end
    end

    // The next half's total and width follow every change of the duty, of the rests and of extra.
    // With order 2, rests_q is 2 rest - rest before, and +-3/2 at most; three times half of least_i
    // and 3/2 with MIN_PULSE.
    reg  signed [REST_W:0]     rests_q;     // s18q16
    reg  signed [REST_W-1:0]   older_q;    // s17q16, rest of the half before
    reg  signed [OWED_W-1:0]   owed_q;      // s26q16
    reg  signed [TOTAL_W-1:0]  total_q;     // s36q16 clocks
    localparam integer         EXTRA_SIGN_W = OWED_W - `WH_EXTRA_W - FRACTION + `WH_EXTRA_Q;
    wire signed [OWED_W-1:0]   extra_long = $signed({{EXTRA_SIGN_W{extra_i[`WH_EXTRA_W-1]}}, extra_i,
                                                     {FRACTION-`WH_EXTRA_Q{1'b0}}});
    wire signed [OWED_W-1:0]   rests_long = $signed({{OWED_W-REST_W-1{rests_q[REST_W]}}, rests_q});
    wire signed [TOTAL_W:0]    sum = $signed({active_q[DUTY_W-1], active_q, 1'b1})
                                     + $signed({{TOTAL_W-OWED_W{owed_q[OWED_W-1]}},
                                                owed_q, active_up_q});

    always @(posedge clk) begin
        if (rst) begin
            owed_q  <= {OWED_W{1'b0}};
            total_q <= {TOTAL_W{1'b0}};
        end else begin
            owed_q  <= rests_long + extra_long;
            total_q <= $signed(sum[TOTAL_W:1]);
        end
    end

    wire unused_carry = &{1'b0, sum[0]};

    wire signed [ROUND_W-1:0] rounded;

    wh_round #(
        .IN_W    (TOTAL_W),
        .SHIFT   (FRACTION)
    ) round (
        .value_i (total_q),
        .value_o (rounded)
    );

    // Rounding up takes a whole clock from the fraction: its sign is the carry.
    reg signed [ROUND_W-1:0] rounded_q;
    reg signed [FRACTION:0]  rest_q;     // s17q16, +-1/2

    always @(posedge clk) begin
        if (rst) begin
            rounded_q <= {ROUND_W{1'b0}};
            rest_q    <= {FRACTION+1{1'b0}};
        end else begin
            rounded_q <= rounded;
            rest_q    <= $signed({rounded[0] ^ total_q[FRACTION], total_q[FRACTION-1:0]});
        end
    end

    // The limits come from settings, which stand still while it runs: they are made one and two clocks
    // before they are compared with. Half of an odd half_clocks_i is rounded down.
    // Legs that have to stay for longer than that have no pulse.
    wire        [7:0]            spare;
    wire signed [`WH_TICK_W-1:0] room       = $signed({1'b0, half_clocks_i[`WH_TICK_W-1:1]})
                                              - $signed({{`WH_TICK_W-8{1'b0}}, spare});
    wire signed [`WH_TICK_W-1:0] limit      = room[`WH_TICK_W-1] ? {`WH_TICK_W{1'b0}} : room;
    reg  signed [`WH_TICK_W-1:0] limit_q;
    reg  signed [`WH_TICK_W-1:0] minus_limit_q;
    wire signed [ROUND_W-1:0]    limit_long = {{ROUND_W-`WH_TICK_W{1'b0}}, limit_q};
    wire signed [ROUND_W-1:0]    minus_long = $signed({{ROUND_W-`WH_TICK_W{minus_limit_q[`WH_TICK_W-1]}},
                                                            minus_limit_q});
    wire                         above      = rounded_q > limit_long;
    wire                         below      = rounded_q < minus_long;
    wire                         unused     = &{1'b0, half_clocks_i[0]};

    always @(posedge clk) begin
        limit_q       <= limit;
        minus_limit_q <= -limit;
    end

    // What is too short becomes 0 or least_i. All comparisons are with the same word, so that none
    // waits for another.
    wire signed [`WH_TICK_W-1:0] bounded = above ? limit_q
                                         : below ? minus_limit_q
                                         : $signed(rounded_q[`WH_TICK_W-1:0]);
    wire signed [`WH_TICK_W-1:0] chosen;
    wire                         clipped;
    wire signed [REST_W-1:0]     rest_long = $signed({{REST_W-FRACTION{rest_q[FRACTION]}},
                                                      rest_q[FRACTION-1:0]});
    wire signed [REST_W-1:0]     left;    // total - chosen

    generate
        if (MIN_PULSE != 0) begin : minimum
            reg         [7:0]            least_q;
            reg  signed [8:0]            minus_least_q;
            reg                          wide_q;
            reg  signed [`WH_TICK_W-1:0] size_q;
            reg  signed [`WH_TICK_W-1:0] minus_size_q;
            wire signed [ROUND_W-1:0]    least       = $signed({{ROUND_W-8{1'b0}}, least_q});
            wire signed [ROUND_W-1:0]    minus_least = $signed({{ROUND_W-9{minus_least_q[8]}},
                                                                minus_least_q});
            wire                         wide        = least > limit_long;

            always @(posedge clk) begin
                least_q       <= least_i;
                minus_least_q <= -$signed({1'b0, least_i});
                wide_q        <= wide;
                size_q        <= wide ? limit_q : $signed(least[`WH_TICK_W-1:0]);
                minus_size_q  <= wide ? minus_limit_q : $signed(minus_least[`WH_TICK_W-1:0]);
            end

            wire signed [ROUND_W:0]      twice   = $signed({rounded_q, 1'b0});
            wire                         short   = rounded_q < least && rounded_q > minus_least;
            wire                         up      = twice >= $signed({1'b0, least});
            wire                         down    = twice <= $signed({minus_least[ROUND_W-1],
                                                                     minus_least});
            wire signed [`WH_TICK_W-1:0] instead = up ? size_q : down ? minus_size_q
                                                 : {`WH_TICK_W{1'b0}};
            // total - chosen: its whole clocks, of which rest_q is one below where it is negative.
            localparam integer CLOCKS_W = REST_W - FRACTION;
            wire signed [CLOCKS_W-1:0] few     = $signed(rounded_q[CLOCKS_W-1:0]);
            wire signed [CLOCKS_W-1:0] sign    = {CLOCKS_W{rest_q[FRACTION]}};
            wire signed [CLOCKS_W-1:0] nearly  = $signed({{CLOCKS_W-8{1'b0}}, least_q});
            wire signed [CLOCKS_W-1:0] less    = sign - nearly;
            wire signed [CLOCKS_W-1:0] more    = sign + nearly;
            wire signed [CLOCKS_W-1:0] if_up   = few + less;
            wire signed [CLOCKS_W-1:0] if_down = few + more;
            wire signed [CLOCKS_W-1:0] if_zero = few + sign;
            wire signed [CLOCKS_W-1:0] clocks  = up ? if_up : down ? if_down : if_zero;

            assign chosen  = short ? instead : bounded;
            assign clipped = short ? wide_q && (up || down) : above || below;
            assign left    = short ? $signed({clocks, rest_q[FRACTION-1:0]}) : rest_long;
            assign spare   = spare_i;
        end else begin : any_pulse
            wire unused_minimum = &{1'b0, least_i, spare_i};

            assign chosen  = bounded;
            assign clipped = above || below;
            assign left    = rest_long;
            assign spare   = 8'd0;
        end
    endgenerate

    reg  signed [REST_W-1:0] next_rest_q;
    wire signed [REST_W:0]   rest  = $signed({next_rest_q[REST_W-1], next_rest_q});
    wire signed [REST_W:0]   older = $signed({older_q[REST_W-1], older_q});

    always @(posedge clk) begin
        if (rst) begin
            width_o     <= {`WH_TICK_W{1'b0}};
            next_rest_q <= {REST_W{1'b0}};
            rests_q     <= {REST_W+1{1'b0}};
            older_q     <= {REST_W{1'b0}};
        end else begin
            width_o     <= chosen;
            next_rest_q <= clipped ? {REST_W{1'b0}} : left;
            if (update_i) begin
                rests_q <= second_order_i ? (rest <<< 1) - older : rest;
                older_q <= next_rest_q;
            end
        end
    end

endmodule

`default_nettype wire
