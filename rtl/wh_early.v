// SPDX-License-Identifier: Apache-2.0
//
// wh_early: the duty of the coming tick, ten clocks after the tick's last ADC bit.
//
// What the wave core makes of a tick is linear in the tick's sum of ADC words but for its last
// limit, and all the rest is known before the last word comes:
//
//   e    = limit(s (f + a (η (u_n - s i_n) + x - f))) + c,  i_n = gain (sum - zero) - offset
//   duty = clocks_per_volt e = base - slope (sum - zero), from low to high
//   base  = clocks_per_volt (s f + s a (η (u_n + s offset) + x - f)) + clocks_per_volt c
//   slope = (gain clocks_per_volt s) (s a η)
//   high  = clocks_per_volt s u_max + clocks_per_volt c,  low = the same with -u_max
//   still = clocks_per_volt (s f + s a (x - f)) + clocks_per_volt c, the duty of v = 0
//
// Where a word of the sum is at an end of its range, v is known from one side only, and 0 or of that sign
// (wh_wave_core): still takes high's place or low's.
// offset and c are the port anchor's, 0 without one. So base, slope and limits are made while the
// last word is converted, and a sample passes one multiplication. The core makes its step as ever,
// with the same η, x and u_max. η and x are taken over here when the frame of the last word begins,
// or when the step of the tick before has ended (busy_i) if that is later; the core's f and u are the
// state, and hold what was applied but for this block's last places: 1e-6 of it.
// The words are those of a step whose u goes out at once (hold_ticks_i = 0), with W = 1.
// sim/wavehaptics/controller/early.py says the same with integers, and this module equals it bit for bit.
//
// Formats: at the ports and below; rounding is down, and what is between the two ends saturates.
// Latency: 18 clocks from the frame's start (or the core's end) until a sum may come; 5 clocks from
// sum_valid_i to where wh_modulator's take_i finds the duty. A sum that comes too soon has no duty
// and shows as overrun_o. Reset: no duty; the words in preparation are dropped.

`default_nettype none
`include "wh_formats.vh"

module wh_early (
    input  wire                         clk,
    input  wire                         rst,

    // Words of the ADC, and the frame that will bring one.
    input  wire                         frame_i,            // strobe, a frame begins
    input  wire                         word_valid_i,       // strobe, a word is there
    input  wire                         word_first_i,       // with word_valid_i: first of a tick
    input  wire        [8:0]            samples_i,          // words in a sum, 1...256
    input  wire                         busy_i,             // the words below aren't settled yet

    // The state and the settings; they hold while busy_i is 0. u_max_i and clocks_per_volt_i hold until
    // the core's step with them has ended.
    input  wire signed [`WH_DATA_W-1:0] f_i,                // s31q23 √W, without its guard bits
    input  wire signed [`WH_DATA_W-1:0] u_n_i,              // s31q23 √W: u of the tick's voltage
    input  wire signed [`WH_DATA_W-1:0] u_max_i,            // s31q23 √W, 0...
    input  wire signed [`WH_COEF_W-1:0] root_i,             // s27q22 √Ω: s
    input  wire signed [`WH_COEF_W-1:0] a_i,                // s27q25
    input  wire signed [`WH_COEF_W-1:0] gain_i,             // s27q35 A
    input  wire signed [`WH_COEF_W-1:0] clocks_per_volt_i,  // s27q16 clocks/V

    // The environment, and what of it goes on to the core's step.
    input  wire signed [`WH_COEF_W-1:0] eta_i,              // s27q25
    input  wire signed [`WH_DATA_W-1:0] wave_i,             // s31q23 √W: x
    output reg  signed [`WH_COEF_W-1:0] eta_o,
    output reg  signed [`WH_DATA_W-1:0] wave_o,

    // Of the port anchor, for the step to come: taken over as well. 0 without one.
    input  wire signed [`WH_DATA_W-1:0] offset_i,           // s31q24 A, taken off the current
    input  wire signed [`WH_DATA_W-1:0] correction_i,       // s31q23 V: c, behind the limit

    input  wire                         sum_valid_i,        // its first clock counts
    input  wire signed [`WH_DATA_W-1:0] sum_i,              // s31q0: the tick's sum - zero
    input  wire        [1:0]            sum_ends_i,         // of its words: one is at the high, the low end

    output wire                         duty_valid_o,       // strobe
    output wire signed [`WH_DATA_W+`WH_COEF_W-`WH_VOLTAGE_Q-1:0] duty_o,  // s35q16 clocks
    output reg                          overrun_o           // until rst
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer COEF_W    = `WH_COEF_W;
    localparam integer PRODUCT_W = DATA_W + COEF_W;
    localparam integer DUTY_W    = PRODUCT_W - `WH_VOLTAGE_Q;  // s35q16

    // Binary points of what is made on the way.
    localparam integer SA_Q     = DATA_W - 5;   // s a in √Ω as a data word, ±16
    localparam integer SCALE_Q  = DATA_W + 3;   // gain clocks_per_volt, ±1/16 clocks a unit
    localparam integer SLOPE_Q  = DATA_W + 2;   // ±1/8 clocks a unit, with or without √Ω

    localparam integer SA_SHIFT    = `WH_ROOT_Q + `WH_A_Q - SA_Q;
    localparam integer SA_CUT      = `WH_A_Q;                              // to s27q22
    localparam integer GOAL_SHIFT  = `WH_ETA_Q;
    localparam integer VOLT_SHIFT  = `WH_ROOT_Q;                           // wave to voltage
    localparam integer DROP_SHIFT  = `WH_ROOT_Q + `WH_CURRENT_Q - `WH_WAVE_Q;  // current to wave
    localparam integer SCALE_SHIFT = `WH_GAIN_Q + `WH_DUTY_Q - SCALE_Q;
    localparam integer SAE_SHIFT   = SA_Q + `WH_ETA_Q - `WH_ROOT_Q;        // to s27q22
    localparam integer SS_SHIFT    = SCALE_Q + `WH_ROOT_Q - SLOPE_Q;
    localparam integer SLOPE_SHIFT = `WH_ROOT_Q;
    localparam integer PASS_SHIFT  = SLOPE_Q - `WH_DUTY_Q;

    localparam integer PASS_W = PRODUCT_W - PASS_SHIFT;
    localparam integer SUM_W  = 2 + ((PASS_W > DUTY_W) ? PASS_W : DUTY_W);

    generate
        if (COEF_W > DATA_W || COEF_W < `WH_SUM_W + 1 || SCALE_SHIFT < 1 || SA_SHIFT < 1)
        begin : illegal_format
            wh_illegal_parameter_early_formats stop ();
        end
    endgenerate

    // ---- When: the frame of the tick's last word has begun, and nothing is under way.
    reg [8:0] words_q;  // of the tick's, so far
    reg       waiting_q;
    reg [4:0] step_q;   // 0: nothing is ready, LAST: all is
    reg       sum_q;    // sum_valid_i a clock before

    reg signed [DATA_W-1:0] offset_q;
    reg signed [DATA_W-1:0] correction_q;

    localparam [4:0] LAST = 5'd18;

    wire last_frame = frame_i && (samples_i == 9'd1 || words_q == samples_i - 9'd1);
    wire begins     = (waiting_q || last_frame) && !busy_i;
    wire ready      = (step_q == LAST);
    wire new_sum    = sum_valid_i && !sum_q;
    wire fire       = new_sum && ready;

    always @(posedge clk) begin
        if (word_valid_i) begin
            words_q <= word_first_i ? 9'd1 : words_q + 9'd1;
        end
    end

    always @(posedge clk) begin
        if (rst) begin
            waiting_q <= 1'b0;
            sum_q     <= 1'b0;
            step_q    <= 5'd0;
            overrun_o <= 1'b0;
            eta_o     <= {COEF_W{1'b0}};
            wave_o    <= {DATA_W{1'b0}};
        end else begin
            waiting_q <= (waiting_q || last_frame) && busy_i;
            sum_q     <= sum_valid_i;
            if (begins) begin
                step_q <= 5'd1;
                eta_o  <= eta_i;
                wave_o <= wave_i;
            end else if (fire) begin
                step_q <= 5'd0;
            end else if (step_q != 5'd0 && !ready) begin
                step_q <= step_q + 5'd1;
            end
            if (new_sum && (waiting_q || (step_q != 5'd0 && !ready))) begin
                overrun_o <= 1'b1;
            end
        end
    end

    always @(posedge clk) begin
        if (begins) begin
            offset_q     <= offset_i;
            correction_q <= correction_i;
        end
    end

    // ---- The multiplier, by the step. A product is there 3 clocks later.
    reg signed [DATA_W-1:0]  sa_q;
    reg signed [COEF_W-1:0]  sa_cut_q;
    reg signed [DATA_W-1:0]  wave_q;       // u_n + s offset
    reg signed [DATA_W-1:0]  goal_q;
    reg signed [DATA_W-1:0]  error_q;
    reg signed [DATA_W-1:0]  volt_q;       // s f, then e without the sample
    reg signed [DATA_W-1:0]  scale_q;
    reg signed [DATA_W-1:0]  limit_volt_q;
    reg signed [COEF_W-1:0]  sae_q;
    reg signed [DATA_W-1:0]  ss_q;
    reg signed [DATA_W-1:0]  slope_q;
    reg signed [DUTY_W-1:0]  limit_q;
    reg signed [DUTY_W-1:0]  added_q;      // clocks_per_volt c
    reg signed [DUTY_W-1:0]  base_q;       // without it
    reg signed [DATA_W-1:0]  still_error_q;
    reg signed [DATA_W-1:0]  still_volt_q;
    reg signed [DUTY_W-1:0]  still_q;      // without it
    reg                      last_q;       // the first clock of the last step

    reg  signed [DATA_W-1:0]    data;
    reg  signed [COEF_W-1:0]    coef;
    wire signed [PRODUCT_W-1:0] product;

    wire signed [DATA_W-1:0] root_long = $signed({{DATA_W-COEF_W+1{root_i[COEF_W-1]}},
                                                  root_i[COEF_W-2:0]});
    wire signed [DATA_W-1:0] gain_long = $signed({{DATA_W-COEF_W+1{gain_i[COEF_W-1]}},
                                                  gain_i[COEF_W-2:0]});

    always @* begin
        case (step_q)
            5'd1: begin
                data = offset_q;
                coef = root_i;
            end
            5'd2: begin
                data = root_long;
                coef = a_i;
            end
            5'd3: begin
                data = f_i;
                coef = root_i;
            end
            5'd4: begin
                data = gain_long;
                coef = clocks_per_volt_i;
            end
            5'd5: begin
                data = wave_q;
                coef = eta_o;
            end
            5'd6: begin
                data = u_max_i;
                coef = root_i;
            end
            5'd7: begin
                data = sa_q;
                coef = eta_o;
            end
            5'd8: begin
                data = scale_q;
                coef = root_i;
            end
            5'd9: begin
                data = still_error_q;
                coef = sa_cut_q;
            end
            5'd10: begin
                data = error_q;
                coef = sa_cut_q;
            end
            5'd11: begin
                data = limit_volt_q;
                coef = clocks_per_volt_i;
            end
            5'd12: begin
                data = ss_q;
                coef = sae_q;
            end
            5'd13: begin
                data = still_volt_q;
                coef = clocks_per_volt_i;
            end
            5'd14: begin
                data = volt_q;
                coef = clocks_per_volt_i;
            end
            5'd15: begin
                data = correction_q;
                coef = clocks_per_volt_i;
            end
            default: begin
                data = slope_q;
                coef = $signed(sum_i[COEF_W-1:0]);
            end
        endcase
    end

    wire unused_sum = &{1'b0, sum_i[DATA_W-1:COEF_W-1]};

    wh_multiply multiply (
        .clk       (clk),
        .take_i    (1'b1),
        .data_i    (data),
        .coef_i    (coef),
        .product_o (product)
    );

    // ---- What a product is cut to, in its step.
    wire signed [DATA_W-1:0] as_drop;
    wire signed [DATA_W-1:0] as_sa;
    wire signed [COEF_W-1:0] as_sa_cut;
    wire signed [DATA_W-1:0] as_goal;
    wire signed [DATA_W-1:0] as_volt;
    wire signed [DATA_W-1:0] as_scale;
    wire signed [COEF_W-1:0] as_sae;
    wire signed [DATA_W-1:0] as_ss;
    wire signed [DATA_W-1:0] as_slope;

    wh_saturate #(
        .IN_W    (PRODUCT_W - DROP_SHIFT),
        .OUT_W   (DATA_W)
    ) saturate_drop (
        .value_i ($signed(product[PRODUCT_W-1:DROP_SHIFT])),
        .value_o (as_drop)
    );

    wh_saturate #(
        .IN_W    (PRODUCT_W - SA_SHIFT),
        .OUT_W   (DATA_W)
    ) saturate_sa (
        .value_i ($signed(product[PRODUCT_W-1:SA_SHIFT])),
        .value_o (as_sa)
    );

    wh_saturate #(
        .IN_W    (PRODUCT_W - SA_CUT),
        .OUT_W   (COEF_W)
    ) saturate_sa_cut (
        .value_i ($signed(product[PRODUCT_W-1:SA_CUT])),
        .value_o (as_sa_cut)
    );

    wh_saturate #(
        .IN_W    (PRODUCT_W - GOAL_SHIFT),
        .OUT_W   (DATA_W)
    ) saturate_goal (
        .value_i ($signed(product[PRODUCT_W-1:GOAL_SHIFT])),
        .value_o (as_goal)
    );

    wh_saturate #(
        .IN_W    (PRODUCT_W - VOLT_SHIFT),
        .OUT_W   (DATA_W)
    ) saturate_volt (
        .value_i ($signed(product[PRODUCT_W-1:VOLT_SHIFT])),
        .value_o (as_volt)
    );

    wh_saturate #(
        .IN_W    (PRODUCT_W - SCALE_SHIFT),
        .OUT_W   (DATA_W)
    ) saturate_scale (
        .value_i ($signed(product[PRODUCT_W-1:SCALE_SHIFT])),
        .value_o (as_scale)
    );

    wh_saturate #(
        .IN_W    (PRODUCT_W - SAE_SHIFT),
        .OUT_W   (COEF_W)
    ) saturate_sae (
        .value_i ($signed(product[PRODUCT_W-1:SAE_SHIFT])),
        .value_o (as_sae)
    );

    wh_saturate #(
        .IN_W    (PRODUCT_W - SS_SHIFT),
        .OUT_W   (DATA_W)
    ) saturate_ss (
        .value_i ($signed(product[PRODUCT_W-1:SS_SHIFT])),
        .value_o (as_ss)
    );

    wh_saturate #(
        .IN_W    (PRODUCT_W - SLOPE_SHIFT),
        .OUT_W   (DATA_W)
    ) saturate_slope (
        .value_i ($signed(product[PRODUCT_W-1:SLOPE_SHIFT])),
        .value_o (as_slope)
    );

    // u_n + s offset
    wire signed [DATA_W:0]   wide_wave = $signed({u_n_i[DATA_W-1], u_n_i})
                                       + $signed({as_drop[DATA_W-1], as_drop});
    wire signed [DATA_W-1:0] wave;

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_wave (
        .value_i (wide_wave),
        .value_o (wave)
    );

    // η (u_n + s offset) + x - f
    wire signed [DATA_W+1:0] wide_error = $signed({{2{goal_q[DATA_W-1]}}, goal_q})
                                        + $signed({{2{wave_o[DATA_W-1]}}, wave_o})
                                        - $signed({{2{f_i[DATA_W-1]}}, f_i});
    wire signed [DATA_W-1:0] error;

    wh_saturate #(
        .IN_W    (DATA_W + 2),
        .OUT_W   (DATA_W)
    ) saturate_error (
        .value_i (wide_error),
        .value_o (error)
    );

    // x - f
    wire signed [DATA_W:0]   wide_still = $signed({wave_o[DATA_W-1], wave_o})
                                        - $signed({f_i[DATA_W-1], f_i});
    wire signed [DATA_W-1:0] still_error;

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_still (
        .value_i (wide_still),
        .value_o (still_error)
    );

    // s f + s a (...), of either
    wire signed [DATA_W:0]   wide_volt = $signed({volt_q[DATA_W-1], volt_q})
                                       + $signed({as_volt[DATA_W-1], as_volt});
    wire signed [DATA_W-1:0] volt;

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_sum (
        .value_i (wide_volt),
        .value_o (volt)
    );

    always @(posedge clk) begin
        case (step_q)
            5'd4:  wave_q       <= wave;
            5'd5: begin
                sa_q          <= as_sa;
                sa_cut_q      <= as_sa_cut;
                still_error_q <= still_error;
            end
            5'd6:  volt_q       <= as_volt;
            5'd7:  scale_q      <= as_scale;
            5'd8:  goal_q       <= as_goal;
            5'd9: begin
                error_q      <= error;
                limit_volt_q <= as_volt;
            end
            5'd10: sae_q        <= as_sae;
            5'd11: ss_q         <= as_ss;
            5'd12: still_volt_q <= volt;
            5'd13: volt_q       <= volt;
            5'd14: limit_q      <= $signed(product[PRODUCT_W-1:`WH_VOLTAGE_Q]);
            5'd15: slope_q      <= as_slope;
            5'd16: still_q      <= $signed(product[PRODUCT_W-1:`WH_VOLTAGE_Q]);
            5'd17: base_q       <= $signed(product[PRODUCT_W-1:`WH_VOLTAGE_Q]);
            default: begin
            end
        endcase
        // The last product is there with the first clock of the last step, which may be its only one.
        last_q <= (step_q == LAST - 5'd1);
        if (last_q) begin
            added_q <= $signed(product[PRODUCT_W-1:`WH_VOLTAGE_Q]);
        end
    end

    // ---- Limits and base with c. They are registered twice on their way to the sample's product,
    // which comes 3 clocks after the sum.
    // What isn't known of the current is known of the duty: on one side of v = 0.
    reg  signed [DUTY_W-1:0] within_q;     // still, within the limits
    wire                     back      = eta_o[COEF_W-1];
    wire signed [DUTY_W-1:0] most      = (back ? sum_ends_i[1] : sum_ends_i[0]) ? within_q : limit_q;
    wire signed [DUTY_W-1:0] least     = (back ? sum_ends_i[0] : sum_ends_i[1]) ? within_q : -limit_q;
    wire signed [DUTY_W:0]   wide_high = $signed({added_q[DUTY_W-1], added_q})
                                       + $signed({most[DUTY_W-1], most});
    wire signed [DUTY_W:0]   wide_low  = $signed({added_q[DUTY_W-1], added_q})
                                       + $signed({least[DUTY_W-1], least});
    wire signed [DUTY_W-1:0] high;
    wire signed [DUTY_W-1:0] low;

    wh_saturate #(
        .IN_W    (DUTY_W + 1),
        .OUT_W   (DUTY_W)
    ) saturate_high (
        .value_i (wide_high),
        .value_o (high)
    );

    wh_saturate #(
        .IN_W    (DUTY_W + 1),
        .OUT_W   (DUTY_W)
    ) saturate_low (
        .value_i (wide_low),
        .value_o (low)
    );

    reg signed [DUTY_W-1:0] high_q;
    reg signed [DUTY_W-1:0] low_q;
    reg signed [DUTY_W:0]   whole_q;       // base with c

    // ---- The sample's way: its product off the base, and off the base's distances to the limits.
    reg signed [SUM_W-1:0]  above_low_q;   // base - low
    reg signed [SUM_W-1:0]  below_high_q;  // base - high
    reg        [3:0]        fire_q;        // fire_q[n]: fire was n + 1 clocks ago
    reg signed [DUTY_W-1:0] duty_q;
    reg                     over_q;
    reg                     under_q;

    wire signed [SUM_W-1:0] whole_wide = $signed({{SUM_W-DUTY_W-1{whole_q[DUTY_W]}}, whole_q});
    wire signed [SUM_W-1:0] high_wide  = $signed({{SUM_W-DUTY_W{high_q[DUTY_W-1]}}, high_q});
    wire signed [SUM_W-1:0] low_wide   = $signed({{SUM_W-DUTY_W{low_q[DUTY_W-1]}}, low_q});
    wire signed [SUM_W-1:0] pass       = $signed({{SUM_W-PASS_W{product[PRODUCT_W-1]}},
                                                  product[PRODUCT_W-1:PASS_SHIFT]});
    wire signed [SUM_W-1:0] duty_wide  = whole_wide - pass;
    wire signed [SUM_W-1:0] from_low   = above_low_q - pass;
    wire signed [SUM_W-1:0] from_high  = below_high_q - pass;

    always @(posedge clk) begin
        within_q     <= (still_q > limit_q) ? limit_q : (still_q < -limit_q) ? -limit_q : still_q;
        high_q       <= high;
        low_q        <= low;
        whole_q      <= $signed({base_q[DUTY_W-1], base_q}) + $signed({added_q[DUTY_W-1], added_q});
        above_low_q  <= whole_wide - low_wide;
        below_high_q <= whole_wide - high_wide;
        duty_q       <= $signed(duty_wide[DUTY_W-1:0]);
        over_q       <= !from_high[SUM_W-1];
        under_q      <= from_low[SUM_W-1];
        fire_q       <= rst ? 4'd0 : {fire_q[2:0], fire};
    end

    wire unused = &{1'b0, duty_wide[SUM_W-1:DUTY_W], from_high[SUM_W-2:0], from_low[SUM_W-2:0]};

    assign duty_valid_o = fire_q[3];
    assign duty_o       = over_q ? high_q : under_q ? low_q : duty_q;

endmodule

`default_nettype wire
