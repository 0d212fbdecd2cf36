// SPDX-License-Identifier: Apache-2.0
//
// wh_wave_core: one step of the wave controller for each of N ports, one port after the other.
//
//   v  = u_n - s i_n            u_n: the wave applied in the measured tick, from the delay line
//   f += a (η W{v} + x - f)     D(s) = η λ/(s + λ) W(s); η is that of contact or free space. x is a wave from
//                               outside (OUTSIDE = 1): a host's goal
//   f  = clamp(f, ±u_max)       u_max: the drive's limit over s
//   e  = s u                    u: f, or an earlier one from the delay line
//
// sim/wavehaptics/controller/wave_core.py is the same with integers, and this module equals it bit for bit.
// Rounding is always toward zero; sums saturate. f has WH_STATE_GUARD more fraction bits than a wave.
//
// If i_n is at an end of its range (ends_i, or the largest or least value), it bounds v on one side only. v is then the
// smallest value within that bound: 0, unless its sign is opposite to the current's. So |v| never exceeds the true one,
// and a port with |η| <= 1 is passive, whatever the true current is. clipped_o indicates this, and a saturated v.
//
// extra_ticks_i is the age, in steps, of the u that was applied in the measured tick, relative to the newest u in the
// delay line as the step starts. hold_ticks_i is the age of the u that this step puts out, relative to the one that it
// computes: with 0 that one is put out at once.
//
// Latency: 24 clocks a port, and 5 for each section of W; valid_o comes N times that after start_i. The next start_i
// may come together with valid_o. A start_i while busy is ignored, and sets overrun_o until reset.
// All inputs hold from start_i until valid_o, with these exceptions. A port's are read only during its own turn. eta_i,
// outside_i, shape_mode_i and u_max_i are not read in the clock of start_i, so they may change whenever busy_o is 0.
// These, root_i, a_i and shape_words_i may also change on a clock edge where reads_o is 0, as it is in the last 4
// clocks of every step. Outputs hold from valid_o to the next start_i.
// Reset: f = 0, the delay line reads as 0 until it has been filled, outputs 0; a step that has begun is dropped.

`default_nettype none
`include "wh_formats.vh"

module wh_wave_core #(
    parameter integer N          = 1,  // ports, 1...
    parameter integer DELAY_LOG2 = 2,  // the delay line keeps 2^DELAY_LOG2 steps, 1...
    parameter integer OUTSIDE    = 0,  // 1: outside_i is added to the goal, 0: it is not looked at
    parameter integer SHAPER     = 0,  // sections of W (wh_shaper), 0...2; 0: W = 1
    parameter integer WITHHELD   = 0,  // 1: withheld_o is there, 0: it is 0
    parameter integer SHARED     = 0,  // 1: the multiplier is outside, and SHAPER is 0
    parameter integer SHAPE_BITS = N * ((SHAPER > 0) ? SHAPER : 1)  // derived, leave it
                                   * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W)
) (
    input wire clk,
    input wire rst,

    input  wire start_i,
    output wire busy_o,
    output wire reads_o,
    output reg  valid_o,
    output reg  overrun_o,

    input wire signed [N*`WH_DATA_W-1:0] current_i,      // s31q24 A, ±64 A: the tick's mean i_n
    input wire signed [N*`WH_COEF_W-1:0] eta_i,          // s27q25 η, used in [-1, 1]
    input wire signed [N*`WH_DATA_W-1:0] outside_i,      // s31q23 √W, ±128 √W: x
    input wire        [2*N-1:0]          ends_i,         // i_n is at the high (bit 0), low end of its range
    input wire        [2*N-1:0]          shape_mode_i,   // as wh_shaper has it
    input wire        [SHAPE_BITS-1:0]   shape_words_i,  // as wh_shaper has it, port 0 lowest
    input wire signed [N*`WH_COEF_W-1:0] root_i,         // s27q22 √Ω, ±16: s = √(2R̂)
    input wire signed [N*`WH_COEF_W-1:0] a_i,            // s27q25 a, used in (0, 1]
    input wire signed [N*`WH_DATA_W-1:0] u_max_i,        // s31q23 √W, 0...128 √W
    input wire        [DELAY_LOG2-1:0]   extra_ticks_i,
    input wire        [DELAY_LOG2-1:0]   hold_ticks_i,

    output reg signed [N*`WH_DATA_W-1:0] voltage_o,      // s31q23 V, ±128 V: e to be applied
    output reg signed [N*`WH_DATA_W-1:0] u_o,            // s31q23 √W, ±128 √W: u_n, measured tick
    output reg signed [N*`WH_DATA_W-1:0] v_o,            // s31q23 √W, ±128 √W: v_n, measured tick
    output reg        [N-1:0]            saturated_o,    // f was outside ±u_max in this step
    output wire       [N*`WH_DATA_W-1:0] withheld_o,     // s31q23 √W: by how much; else -1, 0 or 1,
                                                         // the sum of what u lacks of f
    output reg        [N-1:0]            clipped_o,      // i_n or v_n is at the end of its range
    output wire       [N-1:0]            waves_o,        // strobe: u_o, v_o, clipped_o are this step's

    // The shared multiplier, SHARED = 1 (wh_multiply_shared). The schedule doesn't wait: what it asks
    // for is to be granted in the same clock, and product_i is the product 3 clocks later.
    output wire                                    request_o,
    output wire signed [`WH_DATA_W-1:0]            factor_o,       // of whatever is due: i_n, W{v},
    output wire signed [`WH_COEF_W-1:0]            coefficient_o,  // η W{v} + x - f, u; s, η, a, s
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i
);

    // ---- Word lengths. A product keeps all its bits; each is then brought to its sum's place.
    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer COEF_W    = `WH_COEF_W;
    localparam integer GUARD     = `WH_STATE_GUARD;
    localparam integer STATE_W   = `WH_STATE_W;
    localparam integer PRODUCT_W = DATA_W + COEF_W;

    localparam integer SI_SHIFT   = `WH_ROOT_Q + `WH_CURRENT_Q - `WH_WAVE_Q;
    localparam integer ETA_SHIFT  = `WH_ETA_Q;
    localparam integer A_SHIFT    = `WH_A_Q - GUARD;
    localparam integer SU_SHIFT   = `WH_ROOT_Q + `WH_WAVE_Q - `WH_VOLTAGE_Q;
    localparam integer SI_W       = PRODUCT_W - SI_SHIFT;
    localparam integer ETA_V_W    = PRODUCT_W - ETA_SHIFT;
    localparam integer STEP_W     = PRODUCT_W - A_SHIFT;
    localparam integer SU_W       = PRODUCT_W - SU_SHIFT;

    localparam integer V_SUM_W = 1 + ((SI_W > DATA_W) ? SI_W : DATA_W);
    localparam integer ERROR_W = STATE_W + 1 + OUTSIDE;
    localparam integer F_SUM_W = 2 + ((STEP_W > STATE_W) ? STEP_W : STATE_W);

    localparam integer LENGTH = 1 << DELAY_LOG2;
    localparam integer PORT_W = (N > 1) ? $clog2(N) : 1;
    localparam integer LINE_W = (N > 1) ? PORT_W + DELAY_LOG2 : DELAY_LOG2;
    localparam integer LAST   = N - 1;

    generate
        if (N < 1 || DELAY_LOG2 < 1 || OUTSIDE < 0 || OUTSIDE > 1
            || SHAPER < 0 || SHAPER > 2 || WITHHELD < 0 || WITHHELD > 1) begin : illegal_parameter
            wh_illegal_parameter_wave_core_n_delay_log2_outside_shaper_or_withheld stop ();
        end
        if (SHARED < 0 || SHARED > 1 || (SHARED == 1 && SHAPER != 0)) begin : illegal_shared
            wh_illegal_parameter_wave_core_shared_must_be_0_or_1_and_0_with_a_shaper stop ();
        end
        if (GUARD < 1 || A_SHIFT < 1 || SI_SHIFT < 1 || SU_SHIFT < 1) begin : illegal_format
            wh_illegal_parameter_wave_core_formats stop ();
        end
    endgenerate

    // ---- The table of steps, in clocks since the start of a port's turn. A product comes PRODUCT
    // clocks after its factors were given, and is cut and registered for the clock after. What
    // stands between two steps is a pipeline that runs all the time: only these clocks matter.
    localparam integer PRODUCT    = 3;
    localparam integer GIVE_SI    = 0;                         // s and i_n; u_n is looked up
    localparam integer TAKE_U_N   = GIVE_SI + 1;               // u_n comes out of the delay line
    localparam integer TAKE_V     = GIVE_SI + PRODUCT + 2;     // v = u_n - s i_n
    localparam integer GIVE_ETA_V = TAKE_V + 5 * SHAPER;       // η and W{v}
    localparam integer GIVE_A     = GIVE_ETA_V + PRODUCT + 3;  // a and η W{v} - f
    localparam integer TAKE_SUM   = GIVE_A + PRODUCT + 1;      // f + a (η W{v} - f)
    localparam integer TAKE_F     = TAKE_SUM + 2;              // the sum, clamped
    localparam integer TAKE_U     = TAKE_F + 1;                // into the delay line, and out of it
    localparam integer GIVE_SU    = TAKE_U + 1;                // s and u
    localparam integer TAKE_E     = GIVE_SU + PRODUCT + 1;     // e = s u: the turn's last clock

    reg [TAKE_E:0]   at_q;  // at_q[n]: this is clock n of a turn; waits at 0
    reg              busy_q;
    reg [PORT_W-1:0] port_q;

    // Where there is but one its number is constant, and nothing is selected by it.
    wire [PORT_W-1:0] port = (N > 1) ? port_q : {PORT_W{1'b0}};

    // The strobe's own clock is the first of the first turn.
    wire running   = busy_q || start_i;
    wire last_port = (port == LAST[PORT_W-1:0]);
    wire step_ends = at_q[TAKE_E] && last_port;

    assign busy_o  = busy_q;
    assign reads_o = running && !(last_port && (|at_q[TAKE_E:GIVE_SU+1]));

    always @(posedge clk) begin
        if (rst) begin
            at_q      <= {{TAKE_E{1'b0}}, 1'b1};
            busy_q    <= 1'b0;
            port_q    <= {PORT_W{1'b0}};
            valid_o   <= 1'b0;
            overrun_o <= 1'b0;
        end else begin
            valid_o <= step_ends;
            if (busy_q && start_i) begin
                overrun_o <= 1'b1;
            end
            if (running) begin
                busy_q <= !step_ends;
                at_q   <= {at_q[TAKE_E-1:0], at_q[TAKE_E]};
            end
            if (at_q[TAKE_E]) begin
                port_q <= last_port ? {PORT_W{1'b0}} : port_q + 1'b1;
            end
        end
    end

    // ---- What belongs to the port whose turn it is.
    wire signed [DATA_W-1:0]  current = $signed(current_i[port*DATA_W +: DATA_W]);
    wire signed [COEF_W-1:0]  eta     = $signed(eta_i[port*COEF_W +: COEF_W]);
    wire signed [COEF_W-1:0]  root    = $signed(root_i[port*COEF_W +: COEF_W]);
    wire signed [COEF_W-1:0]  a       = $signed(a_i[port*COEF_W +: COEF_W]);
    wire signed [DATA_W-1:0]  u_max   = $signed(u_max_i[port*DATA_W +: DATA_W]);
    wire signed [DATA_W-1:0]  u_n     = $signed(u_o[port*DATA_W +: DATA_W]);
    wire signed [STATE_W-1:0] f       = f_q[port];

    // ---- The multiplier, given what is due.
    wire signed [DATA_W-1:0]    shaped;
    wire signed [DATA_W-1:0]    error;
    reg  signed [DATA_W-1:0]    u_held_q;
    reg  signed [DATA_W-1:0]    data;
    reg  signed [COEF_W-1:0]    coef;
    wire signed [PRODUCT_W-1:0] product;

    always @* begin
        if (at_q[GIVE_ETA_V]) begin
            data = shaped;
            coef = eta;
        end else if (at_q[GIVE_A]) begin
            data = error;
            coef = a;
        end else if (at_q[GIVE_SU]) begin
            data = u_held_q;
            coef = root;
        end else begin  // GIVE_SI
            data = current;
            coef = root;
        end
    end

    generate
        if (SHARED == 1) begin : shared
            assign request_o     = running && (at_q[GIVE_SI] || at_q[GIVE_ETA_V] || at_q[GIVE_A]
                                               || at_q[GIVE_SU]);
            assign factor_o      = data;
            assign coefficient_o = coef;
        end else begin : alone
            wire unused_product = &{1'b0, product_i};

            assign request_o     = 1'b0;
            assign factor_o      = {DATA_W{1'b0}};
            assign coefficient_o = {COEF_W{1'b0}};
        end
    endgenerate

    // ---- W{v}, in the clocks that the multiplier has to spare. Its coefficients are longer.
    generate
        if (SHAPER > 0) begin : shaped_wave
            localparam integer LONG_W = (`WH_SHAPE_W > COEF_W) ? `WH_SHAPE_W : COEF_W;

            wire                             give;
            wire signed [DATA_W-1:0]         shape_data;
            wire signed [`WH_SHAPE_W-1:0]    shape_coef;
            wire signed [LONG_W-1:0]         long_coef;
            wire signed [DATA_W+LONG_W-1:0]  long_product;

            assign long_coef = give ? $signed({{(LONG_W - `WH_SHAPE_W + 1){shape_coef[`WH_SHAPE_W-1]}},
                                               shape_coef[`WH_SHAPE_W-2:0]})
                                    : $signed({{(LONG_W - COEF_W + 1){coef[COEF_W-1]}},
                                               coef[COEF_W-2:0]});

            wh_multiply #(
                .COEF_W    (LONG_W)
            ) multiply (
                .clk       (clk),
                .take_i    (busy_q),
                .data_i    (give ? shape_data : data),
                .coef_i    (long_coef),
                .product_o (long_product)
            );

            // A product of a short coefficient has as many signs more as that is short of.
            assign product = $signed(long_product[PRODUCT_W-1:0]);

            wh_shaper #(
                .N         (N),
                .SECTIONS  (SHAPER),
                .PRODUCT_W (DATA_W + LONG_W)
            ) shaper (
                .clk       (clk),
                .rst       (rst),
                .turn_i    (running && at_q[GIVE_SI]),
                .port_i    (port),
                .mode_i    (shape_mode_i),
                .words_i   (shape_words_i),
                .value_i   (v),
                .value_o   (shaped),
                .give_o    (give),
                .data_o    (shape_data),
                .coef_o    (shape_coef),
                .product_i (long_product)
            );
        end else begin : plain_wave
            wire unused_shape = &{1'b0, shape_mode_i, shape_words_i};

            assign shaped = v;

            if (SHARED == 1) begin : others_too
                assign product = product_i;
            end else begin : own
                wh_multiply multiply (
                    .clk       (clk),
                    .take_i    (busy_q),
                    .data_i    (data),
                    .coef_i    (coef),
                    .product_o (product)
                );
            end
        end
    endgenerate

    // ---- wh_truncate's up goes in as a sum's carry, from a place below the last that is dropped
    // again: floor(((2 x + 1) + (2 y + up)) / 2) = x + y + up,
    // floor((2 x - (2 y + up)) / 2) = x - y - up.

    // ---- v = u_n - s i_n
    wire signed [SI_W-1:0]    si_floor;
    wire                      si_up;
    reg  signed [SI_W-1:0]    si_floor_q;
    reg                       si_up_q;
    wire signed [V_SUM_W:0]   v_sum;
    reg  signed [V_SUM_W-1:0] v_sum_q;
    wire signed [DATA_W-1:0]  v_near;
    wire signed [DATA_W-1:0]  v;

    wh_truncate #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (SI_SHIFT)
    ) truncate_si (
        .value_i (product),
        .floor_o (si_floor),
        .up_o    (si_up)
    );

    assign v_sum = $signed({{(V_SUM_W - DATA_W){u_n[DATA_W-1]}}, u_n, 1'b0})
                 - $signed({{(V_SUM_W - SI_W){si_floor_q[SI_W-1]}}, si_floor_q, si_up_q});

    wh_saturate #(
        .IN_W    (V_SUM_W),
        .OUT_W   (DATA_W)
    ) saturate_v (
        .value_i (v_sum_q),
        .value_o (v_near)
    );

    // At which end i_n is, known some clocks before v.
    wire [1:0] most   = {current[DATA_W-1] && !(|current[DATA_W-2:0]),
                         !current[DATA_W-1] && (&current[DATA_W-2:0])};
    reg  [1:0] ends_q;
    wire       v_back = v_sum_q[V_SUM_W-1];
    wire       v_far  = (v_sum_q[V_SUM_W-1:DATA_W-1] != {(V_SUM_W - DATA_W + 1){v_back}});

    assign v = $signed(v_near & ~{DATA_W{v_back ? ends_q[1] : ends_q[0]}});

    always @(posedge clk) begin
        ends_q     <= ends_i[2*port +: 2] | most;
        si_floor_q <= si_floor;
        si_up_q    <= si_up;
        v_sum_q    <= $signed(v_sum[V_SUM_W:1]);
    end

    // ---- The goal η W{v} + x, and how far f is from it. The goal is limited before up is added, while
    // the sign is at hand: up belongs to a negative value only, and can't bring it out of the word.
    wire signed [ETA_V_W-1:0]       eta_v_floor;
    wire                            eta_v_up;
    wire signed [DATA_W:0]          goal_limited;
    reg  signed [DATA_W-1:0]        goal_floor_q;
    reg                             goal_up_q;
    wire signed [DATA_W-1:0]        goal;
    reg  signed [ERROR_W-1:0]       guarded_error_q;
    wire signed [ERROR_W-GUARD-1:0] error_floor;
    wire                            error_up;
    reg  signed [ERROR_W-GUARD-1:0] wide_error_q;

    wh_truncate #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (ETA_SHIFT)
    ) truncate_eta_v (
        .value_i (product),
        .floor_o (eta_v_floor),
        .up_o    (eta_v_up)
    );

    wh_saturate #(
        .IN_W    (ETA_V_W + 1),
        .OUT_W   (DATA_W + 1)
    ) saturate_goal (
        .value_i ($signed({eta_v_floor, eta_v_up})),
        .value_o (goal_limited)
    );

    assign goal = goal_floor_q + $signed({{(DATA_W - 1){1'b0}}, goal_up_q});

    // f - x, which stands long before the goal does.
    wire signed [ERROR_W-1:0] base;

    generate
        if (OUTSIDE == 1) begin : added
            wire signed [DATA_W-1:0] outside = $signed(outside_i[port*DATA_W +: DATA_W]);
            reg signed [ERROR_W-1:0] base_q;

            always @(posedge clk) begin
                base_q <= $signed({{2{f[STATE_W-1]}}, f})
                        - $signed({{2{outside[DATA_W-1]}}, outside, {GUARD{1'b0}}});
            end

            assign base = base_q;
        end else begin : plain
            wire unused_outside = &{1'b0, outside_i};

            assign base = $signed({f[STATE_W-1], f});
        end
    endgenerate

    wh_truncate #(
        .IN_W    (ERROR_W),
        .SHIFT   (GUARD)
    ) truncate_error (
        .value_i (guarded_error_q),
        .floor_o (error_floor),
        .up_o    (error_up)
    );

    wh_saturate #(
        .IN_W    (ERROR_W - GUARD),
        .OUT_W   (DATA_W)
    ) saturate_error (
        .value_i (wide_error_q),
        .value_o (error)
    );

    always @(posedge clk) begin
        goal_floor_q    <= $signed(goal_limited[DATA_W:1]);
        goal_up_q       <= goal_limited[DATA_W] && goal_limited[0];
        guarded_error_q <= $signed({{(1 + OUTSIDE){goal[DATA_W-1]}}, goal, {GUARD{1'b0}}}) - base;
        wide_error_q    <= error_floor + $signed({{(ERROR_W - GUARD - 1){1'b0}}, error_up});
    end

    // ---- D(s): f + a (η W{v} - f), clamped to ±u_max
    wire signed [STEP_W-1:0]  step_floor;
    wire                      step_up;
    reg  signed [STEP_W-1:0]  step_floor_q;
    reg                       step_up_q;
    wire signed [F_SUM_W:0]   f_sum;
    reg  signed [F_SUM_W-1:0] f_sum_q;
    reg  signed [STATE_W-1:0] f_clamped;
    wire signed [DATA_W-1:0]  u_floor;
    wire                      u_up;
    wire signed [DATA_W-1:0]  u;

    wh_truncate #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (A_SHIFT)
    ) truncate_step (
        .value_i (product),
        .floor_o (step_floor),
        .up_o    (step_up)
    );

    assign f_sum = $signed({{(F_SUM_W - STATE_W){f[STATE_W-1]}}, f, 1'b1})
                 + $signed({{(F_SUM_W - STEP_W){step_floor_q[STEP_W-1]}}, step_floor_q, step_up_q});

    wire signed [STATE_W-1:0] limit      = $signed({u_max, {GUARD{1'b0}}});
    wire signed [F_SUM_W-1:0] limit_wide =
        $signed({{(F_SUM_W - STATE_W){limit[STATE_W-1]}}, limit});

    // f_sum < -limit is asked without the cost of a negation.
    wire signed [F_SUM_W-1:0] above_low = f_sum_q + limit_wide;
    reg                       over_q;
    reg                       under_q;

    always @* begin
        if (over_q || u_max[DATA_W-1]) begin  // as wave_core.py has it for a limit below 0, too
            f_clamped = limit;
        end else if (under_q) begin
            f_clamped = -limit;
        end else begin
            f_clamped = $signed(f_sum_q[STATE_W-1:0]);
        end
    end

    wh_truncate #(
        .IN_W    (STATE_W),
        .SHIFT   (GUARD)
    ) truncate_u (
        .value_i (f),
        .floor_o (u_floor),
        .up_o    (u_up)
    );

    // What wh_truncate finds of f, found a clock before: its OR and the sum are too long for one.
    reg  u_up_q;
    wire unused_up = &{1'b0, u_up};

    assign u = u_floor + $signed({{(DATA_W - 1){1'b0}}, u_up_q});

    always @(posedge clk) begin
        step_floor_q <= step_floor;
        step_up_q    <= step_up;
        u_up_q       <= f_clamped[STATE_W-1] && (|f_clamped[GUARD-1:0]);
        over_q       <= f_sum_q > limit_wide;
        under_q      <= above_low[F_SUM_W-1];
        if (at_q[TAKE_SUM]) begin
            f_sum_q <= $signed(f_sum[F_SUM_W:1]);
        end
    end

    // ---- e = s u, limited in the same way as the goal
    wire signed [SU_W-1:0]   su_floor;
    wire                     su_up;
    wire signed [DATA_W:0]   e_limited;
    reg  signed [DATA_W-1:0] e_floor_q;
    reg                      e_up_q;
    wire signed [DATA_W-1:0] e;

    wh_truncate #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (SU_SHIFT)
    ) truncate_su (
        .value_i (product),
        .floor_o (su_floor),
        .up_o    (su_up)
    );

    wh_saturate #(
        .IN_W    (SU_W + 1),
        .OUT_W   (DATA_W + 1)
    ) saturate_e (
        .value_i ($signed({su_floor, su_up})),
        .value_o (e_limited)
    );

    assign e = e_floor_q + $signed({{(DATA_W - 1){1'b0}}, e_up_q});

    always @(posedge clk) begin
        e_floor_q <= $signed(e_limited[DATA_W:1]);
        e_up_q    <= e_limited[DATA_W] && e_limited[0];
    end

    wire unused = &{1'b0, v_sum[0], f_sum[0], above_low[F_SUM_W-2:0]};

    // ---- The delay line of u: one memory for all ports, a write and a read port. It is read at
    // the first clock of a turn for u_n, and at all others for the u that this step will put out.
    reg  signed [DATA_W-1:0]     line [0:N*LENGTH-1];
    reg  signed [DATA_W-1:0]     line_q;
    reg         [DELAY_LOG2-1:0] head_q;    // place of the newest u of each port
    reg         [DELAY_LOG2:0]   filled_q;  // steps since reset, up to LENGTH

    wire [DELAY_LOG2-1:0] new_head  = head_q + 1'b1;
    wire [DELAY_LOG2-1:0] read_slot =
        at_q[GIVE_SI] ? head_q - extra_ticks_i : new_head - hold_ticks_i;
    wire [LINE_W-1:0]     write_place;
    wire [LINE_W-1:0]     read_place;

    generate
        if (N > 1) begin : many_ports
            assign write_place = {port, new_head};
            assign read_place  = {port, read_slot};
        end else begin : one_port
            assign write_place = new_head;
            assign read_place  = read_slot;
        end
    endgenerate

    wire u_n_is_there  = {1'b0, extra_ticks_i} < filled_q;
    wire held_is_there = {1'b0, hold_ticks_i} <= filled_q;
    wire hold_is_none  = (hold_ticks_i == {DELAY_LOG2{1'b0}});

    always @(posedge clk) begin
        line_q <= line[read_place];
        if (at_q[TAKE_U]) begin
            line[write_place] <= u;
            u_held_q          <= hold_is_none ? u : held_is_there ? line_q : {DATA_W{1'b0}};
        end
    end

    always @(posedge clk) begin
        if (rst) begin
            head_q   <= {DELAY_LOG2{1'b0}};
            filled_q <= {(DELAY_LOG2 + 1){1'b0}};
        end else if (step_ends) begin
            head_q   <= new_head;
            filled_q <= filled_q[DELAY_LOG2] ? filled_q : filled_q + 1'b1;
        end
    end

    // ---- What u lacks: what the limit takes from f, (f_sum - f)/2^GUARD rounded down, or what rounding
    // f to u has taken so far, as soon as that is a whole place.
    generate
        if (WITHHELD == 1) begin : withholding
            localparam integer WITHHELD_W = F_SUM_W - GUARD;

            reg  signed [F_SUM_W-1:0]    past_low_q;
            reg  signed [F_SUM_W-1:0]    past_high_q;
            reg         [N*DATA_W-1:0]   withheld_q;
            reg         [N*GUARD-1:0]    lost_q;
            wire signed [WITHHELD_W-1:0] past =
                (over_q || u_max[DATA_W-1]) ? $signed(past_high_q[F_SUM_W-1:GUARD])
                                            : $signed(past_low_q[F_SUM_W-1:GUARD]);
            wire signed [DATA_W-1:0]     withheld;
            wire        [GUARD:0]        lost     = {1'b0, lost_q[port*GUARD +: GUARD]}
                                                    + {1'b0, f[GUARD-1:0]};

            wh_saturate #(
                .IN_W    (WITHHELD_W),
                .OUT_W   (DATA_W)
            ) saturate_withheld (
                .value_i (past),
                .value_o (withheld)
            );

            always @(posedge clk) begin
                past_low_q  <= above_low;
                past_high_q <= f_sum_q - limit_wide;
                if (rst) begin
                    withheld_q <= 0;
                    lost_q     <= 0;
                end else if (at_q[TAKE_U]) begin
                    lost_q[port*GUARD +: GUARD]        <= lost[GUARD-1:0];
                    withheld_q[port*DATA_W +: DATA_W] <=
                        (over_q || under_q) ? withheld
                        : {{DATA_W-1{u_up_q && !lost[GUARD]}}, u_up_q ^ lost[GUARD]};
                end
            end

            wire unused_low = &{1'b0, past_low_q[GUARD-1:0], past_high_q[GUARD-1:0]};

            assign withheld_o = withheld_q;
        end else begin : not_withholding
            assign withheld_o = {N*DATA_W{1'b0}};
        end
    endgenerate

    // ---- When the waves of a port are there.
    reg [N-1:0] waves_q;

    always @(posedge clk) begin
        waves_q <= 0;
        if (!rst && at_q[TAKE_V]) begin
            waves_q[port] <= 1'b1;
        end
    end

    assign waves_o = waves_q;

    // ---- State and results.
    reg signed [STATE_W-1:0] f_q [0:N-1];
    integer n;

    always @(posedge clk) begin
        if (rst) begin
            voltage_o   <= 0;
            u_o         <= 0;
            v_o         <= 0;
            saturated_o <= 0;
            clipped_o   <= 0;
            for (n = 0; n < N; n = n + 1) begin
                f_q[n] <= {STATE_W{1'b0}};
            end
        end else begin
            if (at_q[TAKE_U_N]) begin
                u_o[port*DATA_W +: DATA_W] <= u_n_is_there ? line_q : {DATA_W{1'b0}};
            end
            if (at_q[TAKE_V]) begin
                v_o[port*DATA_W +: DATA_W] <= v;
                clipped_o[port]            <= (|ends_q) || v_far;
            end
            if (at_q[TAKE_F]) begin
                f_q[port]         <= f_clamped;
                saturated_o[port] <= over_q || under_q;
            end
            if (at_q[TAKE_E]) begin
                voltage_o[port*DATA_W +: DATA_W] <= e;
            end
        end
    end

endmodule

`default_nettype wire
