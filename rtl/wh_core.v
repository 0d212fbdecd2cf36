// SPDX-License-Identifier: Apache-2.0
//
// wh_core: the wave controller's step, for N ports in turn.
//
//   v  = u_n - s i_n            u_n: the wave applied in the measured period, from the delay line
//   f += a (η W{v} + x - f)     D(s) = η λ/(s + λ); η is that of contact or free space, x a wave from outside
//   f  = clamp(f, ±u_max)       u_max: the setting less room, the port anchor's share of it; 0 or more
//   e  = s u                    u: f, or an earlier one from the delay line
//
// For each port it equals wh_wave_core bit for bit; that header has rounding, clipping and formats.
//
// The turn, in clocks since valid_i:
//   0               port and bank are taken
//   1 6 12 20       the products s i_n, η v, a (η v + x - f) and s u are requested. Each is valid three clocks
//                   later. No other station may request a product in these clocks
//   2, 7            u_o is valid, then v_o and clipped_o
//   5               u_max is computed
//   19              f is computed, and the residue of u
//   25              voltage_o, with valid_o
// A look (LOOK, look_i with valid_i) ends with goal_o in clock 10.
// The next valid_i may come 25 clocks after this one. current_i is taken in clock 1, ends_i from 1 to 5, eta_i in 6,
// outside_i from 8 to 10. Outputs hold until the next turn changes them. Those named `before` are of the port's
// previous step, and hold to clock 17.
// With SHAPER, each section delays all of this by 5 clocks, except for clocks 1, 2, 5 and 7. W (wh_shaper_ports) has
// its own multiplier. shape_mode_i is taken from clock 9 to 21, with two sections to 32.
//
// All ports make one step in a period, in order, so they share one position in the delay line.
// State, by port, in LUT RAM (wh_port_state), besides that of W: f (40 bits), residue of the limit (31) and of rounding
// (9), e (31), room (31), saturated. The delay line is a RAM. Settings: s, a, u_max (wh_port_settings).
// Latency: above. Reset: as wh_wave_core, for all ports; a turn that has begun is dropped.

`default_nettype none
`include "wh_formats.vh"

module wh_core #(
    parameter integer N          = 1,  // ports, 1...8
    parameter integer DELAY_LOG2 = 2,  // the delay line keeps 2^DELAY_LOG2 steps, 1...
    parameter integer OUTSIDE    = 0,  // 1: outside_i is added to the goal, 0: it is ignored
    parameter integer SHAPER     = 0,  // sections of W (wh_shaper_ports), 0...2; 0: W = 1
    parameter integer LOOK       = 0,  // 1: a turn may be a look, 0: look_i is ignored
    parameter integer PORT_W     = (N > 1) ? $clog2(N) : 1  // derived, leave it
) (
    input  wire                             clk,
    input  wire                             rst,

    // A turn.
    input  wire                             valid_i,         // strobe
    input  wire        [PORT_W-1:0]         port_i,
    input  wire                             bank_i,          // bank of its settings
    input  wire                             look_i,          // it ends with η v, and no state changes
    input  wire signed [`WH_DATA_W-1:0]     current_i,       // s31q24 A, ±64 A: the period's mean i_n
    input  wire        [1:0]                ends_i,          // i_n is at the high (bit 0), low end of its range
    input  wire signed [`WH_COEF_W-1:0]     eta_i,           // s27q25 η, used in [-1, 1]
    input  wire signed [`WH_DATA_W-1:0]     outside_i,       // s31q23 √W, ±128 √W: x
    input  wire        [1:0]                shape_mode_i,    // of W, as in wh_shaper
    input  wire        [DELAY_LOG2-1:0]     extra_ticks_i,   // as in wh_wave_core; constant
    input  wire        [DELAY_LOG2-1:0]     hold_ticks_i,

    // The port anchor's share of u_max (wh_anchor_ports).
    input  wire        [N-1:0]              room_rst_i,      // it is 0 for these ports
    input  wire                             room_valid_i,    // strobe
    input  wire        [PORT_W-1:0]         room_port_i,
    input  wire signed [`WH_DATA_W-1:0]     room_i,          // s31q23 √W, 0...

    // The register bus (wh_port_settings).
    input  wire                             write_i,
    input  wire                             write_bank_i,
    input  wire        [11:0]               address_i,
    input  wire        [31:0]               data_i,

    // The multiplier.
    output wire                             request_o,
    output wire signed [`WH_DATA_W-1:0]     factor_o,
    output wire signed [`WH_COEF_W-1:0]     coefficient_o,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i, // 3 clocks after request_o

    // The step.
    output reg                              valid_o,         // strobe
    output wire                             waves_valid_o,   // strobe, the clock before v_o is valid
    output wire                             looked_o,        // strobe of a look: goal_o is valid
    output wire signed [`WH_DATA_W-1:0]     goal_o,          // s31q23 √W, ±128 √W: η v
    output wire        [PORT_W-1:0]         port_o,          // the port of the turn,
    output wire                             bank_o,          // and the bank of its settings
    output reg  signed [`WH_DATA_W-1:0]     voltage_o,       // s31q23 V, ±128 V: e to be applied
    output reg  signed [`WH_DATA_W-1:0]     u_o,             // s31q23 √W, ±128 √W: u_n, measured period
    output reg  signed [`WH_DATA_W-1:0]     v_o,             // s31q23 √W, ±128 √W: v_n, measured period
    output reg                              clipped_o,       // i_n or v_n is at the end of its range
    output reg                              saturated_o,     // f was outside ±u_max, with valid_o
    output wire signed [`WH_DATA_W-1:0]     voltage_before_o,
    output wire signed [`WH_DATA_W-1:0]     withheld_before_o, // s31q23 √W: residue of u
    output wire                             saturated_before_o
);

    // ---- Word lengths. A product keeps all its bits; each is then aligned to its sum.
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
    localparam integer LINE_W = (N > 1) ? PORT_W + DELAY_LOG2 : DELAY_LOG2;
    localparam integer LAST   = N - 1;

    generate
        if (N < 1 || N > 8 || DELAY_LOG2 < 1 || OUTSIDE < 0 || OUTSIDE > 1 || SHAPER < 0 || SHAPER > 2
            || LOOK < 0 || LOOK > 1)
        begin : illegal_parameter
            wh_illegal_parameter_core_n_delay_log2_outside_shaper_or_look stop ();
        end
        if (GUARD < 1 || A_SHIFT < 1 || SI_SHIFT < 1 || SU_SHIFT < 1) begin : illegal_format
            wh_illegal_parameter_core_formats stop ();
        end
    endgenerate

    // ---- The turn. A product comes PRODUCT clocks after its factors, and is cut and registered for the clock
    // after. The pipeline between two steps runs all the time: only these clocks matter.
    localparam integer PRODUCT    = 3;
    localparam integer GIVE_SI    = 1;                         // s and i_n; u_n is read
    localparam integer TAKE_U_N   = GIVE_SI + 1;               // u_n comes out of the delay line
    localparam integer TAKE_MAX   = GIVE_SI + 4;               // u_max
    localparam integer TAKE_V     = GIVE_SI + PRODUCT + 2;     // v = u_n - s i_n
    localparam integer GIVE_ETA_V = TAKE_V + 5 * SHAPER;       // η and W{v}
    localparam integer GIVE_A     = GIVE_ETA_V + PRODUCT + 3;  // a and η v - f
    localparam integer TAKE_SUM   = GIVE_A + PRODUCT + 1;      // f + a (η v - f)
    localparam integer TAKE_F     = TAKE_SUM + 2;              // the sum, clamped
    localparam integer TAKE_U     = TAKE_F + 1;                // into the delay line, and out of it
    localparam integer GIVE_SU    = TAKE_U + 1;                // s and u
    localparam integer TAKE_E     = GIVE_SU + PRODUCT + 1;     // e = s u: the turn's last clock

    reg [TAKE_E:1]   at_q;  // at_q[n]: this is clock n of a turn
    reg [PORT_W-1:0] port_q;
    reg              bank_q;

    reg  look_q;
    wire looks = LOOK != 0 && look_q;
    wire ends  = at_q[TAKE_E] && port_q == LAST[PORT_W-1:0];

    assign port_o        = port_q;
    assign bank_o        = bank_q;
    assign waves_valid_o = at_q[TAKE_V] && !looks;
    assign looked_o      = at_q[GIVE_A-2] && looks;

    always @(posedge clk) begin
        if (valid_i) begin
            port_q <= port_i;
            bank_q <= bank_i;
            look_q <= look_i;
        end
        if (rst) begin
            at_q    <= {TAKE_E{1'b0}};
            valid_o <= 1'b0;
        end else begin
            at_q    <= {at_q[TAKE_E-1:1], valid_i};
            if (looks) begin
                at_q[GIVE_A] <= 1'b0;
            end
            valid_o <= at_q[TAKE_E];
        end
    end

    // ---- Settings, by their addresses in the register map, each read in the clock before its use.
    localparam [1:0] S_ROOT = 0, S_A = 1, S_U_MAX = 2;

    wire [DATA_W-1:0] setting;

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (2),
        .W            (DATA_W),
        .FIRST        (16)
    ) settings (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (valid_i || at_q[TAKE_MAX-1] || at_q[GIVE_A-1] || at_q[GIVE_SU-1]),
        .bank_i       (valid_i ? bank_i : bank_q),
        .port_i       (valid_i ? port_i : port_q),
        .word_i       (at_q[TAKE_MAX-1] ? S_U_MAX : at_q[GIVE_A-1] ? S_A : S_ROOT),
        .word_o       (setting)
    );

    // ---- State of the turn's port.
    wire signed [STATE_W-1:0] f;
    wire signed [DATA_W-1:0]  room;
    reg         [DATA_W-1:0]  u_max_q;
    wire signed [DATA_W-1:0]  left = $signed(setting) - room;  // c may need more than u_max has

    wh_port_state #(
        .N           (N),
        .RESETS      (N),
        .W           (DATA_W)
    ) room_state (
        .clk         (clk),
        .rst         ({N{rst}} | room_rst_i),
        .port_i      (port_q),
        .save_i      (room_valid_i),
        .save_port_i (room_port_i),
        .value_i     (room_i),
        .value_o     (room)
    );

    always @(posedge clk) begin
        if (at_q[TAKE_MAX]) begin
            u_max_q <= left[DATA_W-1] ? {DATA_W{1'b0}} : left;
        end
    end

    // ---- The multiplier's operands.
    wire signed [DATA_W-1:0]    error;
    reg  signed [DATA_W-1:0]    u_held_q;
    wire signed [DATA_W-1:0]    shaped;  // W{v}

    assign request_o     = at_q[GIVE_SI] || at_q[GIVE_ETA_V] || at_q[GIVE_A] || at_q[GIVE_SU];
    assign factor_o      = at_q[GIVE_ETA_V] ? shaped : at_q[GIVE_A] ? error : at_q[GIVE_SU] ? u_held_q : current_i;
    assign coefficient_o = at_q[GIVE_ETA_V] ? eta_i : $signed(setting[COEF_W-1:0]);

    // ---- wh_truncate's up enters as a sum's carry, one bit below the LSB; that bit is dropped again:
    // floor(((2 x + 1) + (2 y + up)) / 2) = x + y + up,
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
        .value_i (product_i),
        .floor_o (si_floor),
        .up_o    (si_up)
    );

    assign v_sum = $signed({{(V_SUM_W - DATA_W){u_o[DATA_W-1]}}, u_o, 1'b0})
                 - $signed({{(V_SUM_W - SI_W){si_floor_q[SI_W-1]}}, si_floor_q, si_up_q});

    wh_saturate #(
        .IN_W    (V_SUM_W),
        .OUT_W   (DATA_W)
    ) saturate_v (
        .value_i (v_sum_q),
        .value_o (v_near)
    );

    // The end of the range at which i_n is, some clocks before v.
    wire [1:0] most   = {current_i[DATA_W-1] && !(|current_i[DATA_W-2:0]),
                         !current_i[DATA_W-1] && (&current_i[DATA_W-2:0])};
    reg  [1:0] ends_q;
    wire       v_back = v_sum_q[V_SUM_W-1];
    wire       v_far  = (v_sum_q[V_SUM_W-1:DATA_W-1] != {(V_SUM_W - DATA_W + 1){v_back}});

    assign v = $signed(v_near & ~{DATA_W{v_back ? ends_q[1] : ends_q[0]}});

    always @(posedge clk) begin
        ends_q     <= ends_i | most;
        si_floor_q <= si_floor;
        si_up_q    <= si_up;
        v_sum_q    <= $signed(v_sum[V_SUM_W:1]);
    end

    // ---- W{v}
    generate
        if (SHAPER > 0) begin : shaped_wave
            wh_shaper_ports #(
                .N            (N),
                .SECTIONS     (SHAPER)
            ) shaper (
                .clk          (clk),
                .rst          (rst),
                .turn_i       (at_q[GIVE_SI]),
                .port_i       (port_q),
                .bank_i       (bank_q),
                .mode_i       (shape_mode_i),
                .value_i      (v),
                .value_o      (shaped),
                .write_i      (write_i),
                .write_bank_i (write_bank_i),
                .address_i    (address_i),
                .data_i       (data_i)
            );
        end else begin : plain_wave
            wire unused_shape = &{1'b0, shape_mode_i};

            assign shaped = v;
        end
    endgenerate

    // ---- The goal η W{v} + x, and its distance from f. The goal is limited before up is added, while the
    // sign is available: only a negative value has up, which can't make it overflow.
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
        .value_i (product_i),
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

    assign goal   = goal_floor_q + $signed({{(DATA_W - 1){1'b0}}, goal_up_q});
    assign goal_o = goal;

    // f - x, valid long before the goal.
    wire signed [ERROR_W-1:0] base;

    generate
        if (OUTSIDE == 1) begin : added
            reg signed [ERROR_W-1:0] base_q;

            always @(posedge clk) begin
                base_q <= $signed({{2{f[STATE_W-1]}}, f})
                        - $signed({{2{outside_i[DATA_W-1]}}, outside_i, {GUARD{1'b0}}});
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

    // ---- D(s): f + a (η v - f), clamped to ±u_max
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
        .value_i (product_i),
        .floor_o (step_floor),
        .up_o    (step_up)
    );

    assign f_sum = $signed({{(F_SUM_W - STATE_W){f[STATE_W-1]}}, f, 1'b1})
                 + $signed({{(F_SUM_W - STEP_W){step_floor_q[STEP_W-1]}}, step_floor_q, step_up_q});

    wire signed [STATE_W-1:0] limit      = $signed({u_max_q, {GUARD{1'b0}}});
    wire signed [F_SUM_W-1:0] limit_wide =
        $signed({{(F_SUM_W - STATE_W){limit[STATE_W-1]}}, limit});

    // f_sum < -limit, without a negation.
    wire signed [F_SUM_W-1:0] above_low = f_sum_q + limit_wide;
    reg                       over_q;
    reg                       under_q;

    always @* begin
        if (over_q) begin
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

    // wh_truncate's up of f, a clock earlier: its OR and the sum are too long for one clock.
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
        .value_i (product_i),
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

    // ---- The delay line of u: one memory for all ports, a write and a read port. It is read at GIVE_SI for u_n,
    // and then for the u that this step puts out.
    reg  signed [DATA_W-1:0]     line [0:N*LENGTH-1];
    reg  signed [DATA_W-1:0]     line_q;
    reg         [DELAY_LOG2-1:0] head_q;    // position of the newest u of all ports
    reg         [DELAY_LOG2:0]   filled_q;  // steps since reset, up to LENGTH

    wire [DELAY_LOG2-1:0] new_head  = head_q + 1'b1;
    wire [DELAY_LOG2-1:0] read_slot =
        at_q[GIVE_SI] ? head_q - extra_ticks_i : new_head - hold_ticks_i;
    wire [LINE_W-1:0]     write_place;
    wire [LINE_W-1:0]     read_place;

    generate
        if (N > 1) begin : many_ports
            assign write_place = {port_q, new_head};
            assign read_place  = {port_q, read_slot};
        end else begin : one_port
            assign write_place = new_head;
            assign read_place  = read_slot;
        end
    endgenerate

    wire u_n_is_there  = {1'b0, extra_ticks_i} < filled_q;
    wire held_is_there = {1'b0, hold_ticks_i} <= filled_q;
    wire hold_is_none  = (hold_ticks_i == {DELAY_LOG2{1'b0}});

    always @(posedge clk) begin
        if (|at_q) begin
            line_q <= line[read_place];
        end
        if (at_q[TAKE_U]) begin
            line[write_place] <= u;
            u_held_q          <= hold_is_none ? u : held_is_there ? line_q : {DATA_W{1'b0}};
        end
    end

    always @(posedge clk) begin
        if (rst) begin
            head_q   <= {DELAY_LOG2{1'b0}};
            filled_q <= {(DELAY_LOG2 + 1){1'b0}};
        end else if (ends) begin
            head_q   <= new_head;
            filled_q <= filled_q[DELAY_LOG2] ? filled_q : filled_q + 1'b1;
        end
    end

    // ---- The residue of u: what the limit cut off from f, (f_sum - f)/2^GUARD rounded down, or what rounding f
    // to u has cut off so far, once that is a whole LSB.
    localparam integer WITHHELD_W = F_SUM_W - GUARD;

    reg  signed [F_SUM_W-1:0]    past_low_q;
    reg  signed [F_SUM_W-1:0]    past_high_q;
    wire signed [WITHHELD_W-1:0] past = over_q ? $signed(past_high_q[F_SUM_W-1:GUARD])
                                               : $signed(past_low_q[F_SUM_W-1:GUARD]);
    wire signed [DATA_W-1:0]     withheld;
    wire        [GUARD-1:0]      lost_before;
    wire        [GUARD:0]        lost = {1'b0, lost_before} + {1'b0, f[GUARD-1:0]};

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
    end

    wire unused_low = &{1'b0, past_low_q[GUARD-1:0], past_high_q[GUARD-1:0]};

    // ---- State and results.
    wh_port_state #(
        .N           (N),
        .W           (STATE_W + 1)
    ) f_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_q),
        .save_i      (at_q[TAKE_F]),
        .save_port_i (port_q),
        .value_i     ({f_clamped, over_q || under_q}),
        .value_o     ({f, saturated_before_o})
    );

    wh_port_state #(
        .N           (N),
        .W           (GUARD + DATA_W)
    ) withheld_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_q),
        .save_i      (at_q[TAKE_U]),
        .save_port_i (port_q),
        .value_i     ({lost[GUARD-1:0],
                       (over_q || under_q) ? withheld
                       : $signed({{DATA_W-1{u_up_q && !lost[GUARD]}}, u_up_q ^ lost[GUARD]})}),
        .value_o     ({lost_before, withheld_before_o})
    );

    wh_port_state #(
        .N           (N),
        .W           (DATA_W)
    ) voltage_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_q),
        .save_i      (at_q[TAKE_E]),
        .save_port_i (port_q),
        .value_i     (e),
        .value_o     (voltage_before_o)
    );

    always @(posedge clk) begin
        if (rst) begin
            voltage_o   <= {DATA_W{1'b0}};
            u_o         <= {DATA_W{1'b0}};
            v_o         <= {DATA_W{1'b0}};
            clipped_o   <= 1'b0;
            saturated_o <= 1'b0;
        end else begin
            if (at_q[TAKE_U_N]) begin
                u_o <= u_n_is_there ? line_q : {DATA_W{1'b0}};
            end
            if (at_q[TAKE_V]) begin
                v_o       <= v;
                clipped_o <= (|ends_q) || v_far;
            end
            if (at_q[TAKE_F]) begin
                saturated_o <= over_q || under_q;
            end
            if (at_q[TAKE_E]) begin
                voltage_o <= e;
            end
        end
    end

    generate
        if (DATA_W > COEF_W) begin : longer_settings
            wire unused_setting = &{1'b0, setting[DATA_W-1:COEF_W]};
        end
    endgenerate

endmodule

`default_nettype wire
