// SPDX-License-Identifier: Apache-2.0
//
// wh_anchor: holds a wall where the encoder says it is, and lets R̂ follow the winding.
//
//   i*    = -(k_T/L_eff) (x - x_w)      current of the design spring, x in the middle of its cell
//   x     = (2 ρ/s) (dz(i* - i_n) + (i* - i_n)/256)      the wave that joins the core's goal
//   s    += -side (γ T/s) (...)         the same error in contact; only down in the first two cells
//   u_max = base - slope s              the tangent of limit/s
//
// dz is a dead zone of half a cell: inside it the inductor knows better than the encoder, and only
// a 256th of the error counts, so that what drifts within a cell dies out. While the rotor moves,
// up to its second turn in a contact, ρ is release_gain where the force errs to the side of the
// motion, on the way out without dead zone and with a 16th of the current on top, and an eighth of
// it where it errs to the other. Inside the dead zone the encoder can't tell whether the rotor has
// turned: there the current of a moving rotor is damped by surface_gain, in the first cell that of
// a resting one as well, and in the second where it is above i*, so that no R̂ can make it grow
// unseen. A contact ends where the torque would pull, until the rotor moves in again.
//
// An error that stays large, or an s that stays at its limit, means that the encoder doesn't follow
// the motor: fault_o, and the plain wave wall. So does a rotor that moves while its encoder stands,
// which looks like another R: once s has settled, a change beyond lost_root without an edge, over
// what warm_root lets pass as a winding's warming; s goes back to what was known before. So does an
// s that never settles; it goes back to root_start.
//
// Out of contact s is root_free.
//
// sim/wavehaptics/anchor.py says the same with integers, and this module equals it bit for bit.
// Products come from a multiplier that others use as well (wh_multiply_shared), four in a step:
// the half cell's current, the anchor's wave, the tracking, and u_max.
// Formats: at the ports. Latency: 24 clocks from start_i and those that the multiplier makes it
// wait; the outputs take the step's words over at update_i, or at the step's end if that is later.
// A start_i while busy is ignored. Reset: s = root_start, free space, no fault.

`default_nettype none
`include "wh_formats.vh"

module wh_anchor (
    input  wire                               clk,
    input  wire                               rst,

    input  wire                               start_i,         // strobe, with the core's
    input  wire                               update_i,        // the core has done its step
    output wire                               busy_o,
    output reg                                overrun_o,       // start_i while busy; until rst

    // The tick.
    input  wire signed [`WH_COUNT_W-1:0]      position_i,      // s32, counts
    input  wire                               contact_i,
    input  wire signed [`WH_COUNT_W-1:0]      depth_i,         // s32, counts, x - x_w
    input  wire signed [`WH_DATA_W-1:0]       current_i,       // s31q24 A: i_n
    input  wire                               saturated_i,     // in the core's step before

    input  wire [`WH_ANCHOR_W-1:0]            words_i,         // settings, to be changed in reset

    // The shared multiplier.
    output reg                                request_o,
    output reg  signed [`WH_DATA_W-1:0]       factor_o,
    output reg  signed [`WH_COEF_W-1:0]       coefficient_o,
    input  wire                               grant_i,
    input  wire                               done_i,          // strobe
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i,

    // For the next tick.
    output reg  signed [`WH_DATA_W-1:0]       wave_o,          // s31q23 √W, ±128 √W
    output reg  signed [`WH_COEF_W-1:0]       root_o,          // s27q22 √Ω, ±16: s
    output reg  signed [`WH_DATA_W-1:0]       limit_o,         // s31q23 √W, ±128 √W: u_max
    output reg                                pulled_o,        // the contact has ended: it pulled
    output wire signed [`WH_COEF_W-1:0]       tracked_o,       // s27q22 √Ω, ±16: s in contact
    output reg                                fault_o          // encoder lost; until rst
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer COEF_W    = `WH_COEF_W;
    localparam integer COUNT_W   = `WH_COUNT_W;
    localparam integer TICK_W    = `WH_ANCHOR_TICK_W;
    localparam integer PRODUCT_W = DATA_W + COEF_W;
    localparam integer SUM_W     = `WH_ROOT_SUM_W;
    localparam integer GUARD     = `WH_ROOT_GUARD;

    localparam integer CELL_SHIFT  = `WH_CELL_CURRENT_Q - `WH_CURRENT_Q;
    localparam integer PULL_SHIFT  = `WH_PULL_Q + `WH_CURRENT_Q - `WH_WAVE_Q;
    localparam integer TRACK_SHIFT = `WH_TRACK_Q + `WH_CURRENT_Q - `WH_ROOT_SUM_Q;
    localparam integer SLOPE_SHIFT = `WH_ROOT_Q;
    localparam integer INNER_SHIFT = 8;
    localparam integer MOVING_SHIFT = 3;
    localparam integer OUTWARD_SHIFT = 4;
    localparam [TICK_W:0] FAR_TICKS = 8;
    localparam integer SETTLED_SHIFT = 2;
    localparam integer CHANGED_SHIFT = 2;
    localparam integer UNSETTLED_SHIFT = 3;
    localparam integer WARM_SHIFT = `WH_ROOT_SUM_Q - `WH_WARM_Q;
    localparam integer STIRRED_W = TICK_W + UNSETTLED_SHIFT;

    localparam integer CELL_W  = PRODUCT_W - CELL_SHIFT;
    localparam integer PULL_W  = PRODUCT_W - PULL_SHIFT;
    localparam integer TRACK_W = PRODUCT_W - TRACK_SHIFT;
    localparam integer DROP_W  = PRODUCT_W - SLOPE_SHIFT;
    localparam integer NEXT_W  = 2 + ((TRACK_W > SUM_W) ? TRACK_W : SUM_W);
    localparam integer LIMIT_W = 1 + ((DROP_W > DATA_W) ? DROP_W : DATA_W);

    // ---- Settings, the last one highest: as sim/wavehaptics/anchor.py has their places.
    wire                     enable;         // 0: the plain wave wall
    wire signed [COEF_W-1:0] half_cell;      // s27q25 A, ±2
    wire signed [DATA_W-1:0] dead_zone;      // s31q24 A, ±64 A, used from 0 on
    wire signed [COEF_W-1:0] anchor_gain;    // s27q20 √Ω, ±64: 2ρ/s
    wire signed [COEF_W-1:0] release_gain;   // s27q20 √Ω, ±64; 0: no release
    wire signed [COEF_W-1:0] surface_gain;   // s27q20 √Ω, ±64
    wire signed [COEF_W-1:0] track_gain;     // s27q32 √Ω/A, ±1/64: γ T/s
    wire signed [COEF_W-1:0] root_free;      // s27q22 √Ω, ±16
    wire signed [DATA_W-1:0] limit_free;     // s31q23 √W, ±128 √W
    wire signed [COEF_W-1:0] root_start;     // s27q22 √Ω, ±16
    wire signed [COEF_W-1:0] root_min;       // s27q22 √Ω, ±16
    wire signed [COEF_W-1:0] root_max;       // s27q22 √Ω, ±16
    wire signed [DATA_W-1:0] limit_base;     // s31q23 √W, ±128 √W
    wire signed [DATA_W-1:0] limit_slope;    // s31q23 √W/√Ω, ±128
    wire [TICK_W-1:0]        release_ticks;  // ticks that an edge counts for
    wire                     push_only;      // 1: a contact ends where it pulls
    wire signed [DATA_W-1:0] lost_current;   // s31q24 A, ±64 A, used from 0 on
    wire [TICK_W-1:0]        lost_ticks;     // ticks, 1...
    wire signed [COEF_W-1:0] lost_root;      // s27q22 √Ω, ±16, used from 0 on; 0: no such rule
    wire signed [COEF_W-1:0] warm_root;      // s27q38 √Ω, ±2^-12, used from 0 on

    assign {warm_root, lost_root, lost_ticks, lost_current, push_only, release_ticks, limit_slope,
            limit_base, root_max, root_min, root_start, limit_free, root_free, track_gain,
            surface_gain, release_gain, anchor_gain, dead_zone, half_cell, enable} = words_i;

    generate
        if (CELL_SHIFT < 1 || PULL_SHIFT < 1 || TRACK_SHIFT < 1 || INNER_SHIFT >= DATA_W)
        begin : illegal_format
            wh_illegal_parameter_anchor_formats stop ();
        end
    endgenerate

    // ---- The steps. Products come in the order in which they were asked for.
    localparam [4:0] IDLE = 0, GIVE_CELL = 1, WAIT_CELL = 2, TARGET = 3, ERROR = 4, BEYOND = 5,
                     PULL = 6, CHOOSE = 7, GIVE_PULL = 8, GIVE_TRACK = 9, WAIT_TRACK = 10,
                     STEP = 11, SUM = 12, CLAMP = 13, SETTLE = 14, GIVE_LIMIT = 15,
                     WAIT_LIMIT = 16, DONE = 17;
    localparam [1:0] CELL_PRODUCT = 0, PULL_PRODUCT = 1, TRACK_PRODUCT = 2, LIMIT_PRODUCT = 3;

    reg [4:0] step_q;
    reg [1:0] product_q;  // the one that comes next
    reg       updated_q;  // update_i has come for this step

    assign busy_o = (step_q != IDLE);

    wire cell_done  = done_i && product_q == CELL_PRODUCT;
    wire pull_done  = done_i && product_q == PULL_PRODUCT;
    wire track_done = done_i && product_q == TRACK_PRODUCT;
    wire limit_done = done_i && product_q == LIMIT_PRODUCT;
    wire takes_over = (step_q == DONE) && (updated_q || update_i);

    // ---- What the tick brought.
    reg signed [COUNT_W-1:0] position_q;
    reg                      negative_q;  // direction of the last edge
    reg [TICK_W-1:0]         motion_q;
    reg [1:0]                reversals_q;
    reg                      touching_q;
    reg                      pulled_q;
    reg signed [DATA_W-1:0]  current_q;
    reg signed [COUNT_W-1:0] depth_q;
    reg                      saturated_q;
    reg                      inward_q;    // an edge went into the wall in this tick
    reg                      fault_q;

    wire signed [COUNT_W-1:0] moved      = position_i - position_q;
    wire                      moves      = |moved;
    wire                      negative   = moved[COUNT_W-1];
    wire                      turns      = moves && (negative != negative_q);

    // ---- The numbers of a step.
    reg signed [CELL_W-1:0]  cell_floor_q;
    reg                      cell_up_q;
    reg signed [DATA_W-1:0]  target_q;
    reg signed [DATA_W-1:0]  error_q;
    reg signed [DATA_W-1:0]  beyond_q;
    reg signed [DATA_W-1:0]  pull_q;
    reg signed [DATA_W-1:0]  word_q;
    reg signed [COEF_W-1:0]  gain_q;
    reg signed [DATA_W-1:0]  wave_floor_q;
    reg                      wave_up_q;
    reg                      far_q;
    reg signed [TRACK_W-1:0] track_floor_q;
    reg                      track_up_q;
    reg signed [TRACK_W-1:0] track_q;
    reg signed [NEXT_W-1:0]  next_q;
    reg                      too_low_q;
    reg                      too_high_q;
    reg signed [SUM_W-1:0]   sum_q;       // s47q42 √Ω: s
    reg [TICK_W:0]           lost_q;
    reg signed [SUM_W-1:0]   known_q;     // s47q42 √Ω: s as the winding alone can have made it
    reg signed [SUM_W:0]     change_q;    // s48q42 √Ω: s - known
    reg                      strange_q;   // the change is no winding's
    reg                      changed_q;   // the change is a part of that
    reg signed [SUM_W-1:0]   warmer_q;    // s47q42 √Ω: known after a tick of warming
    reg [TICK_W-1:0]         quiet_q;     // ticks in which s has stayed near known
    reg [STIRRED_W-1:0]      stirred_q;   // ticks without an edge in which s has not settled
    reg                      moves_q;     // an edge in this tick

    wire low_side_q = !depth_q[COUNT_W-1];  // the wall lies above its edge
    wire surface    = (depth_q[COUNT_W-1:1] == {(COUNT_W - 1){depth_q[COUNT_W-1]}});  // two cells
    wire first_cell = surface && (depth_q[0] == depth_q[COUNT_W-1]);

    // 2 depth + 1, limited to a data word.
    wire signed [DATA_W-1:0] twice_depth;

    wh_saturate #(
        .IN_W    (COUNT_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_depth (
        .value_i ($signed({depth_q, 1'b1})),
        .value_o (twice_depth)
    );

    // i* = -floor - up
    wire signed [CELL_W-1:0] cell_floor;
    wire                     cell_up;
    wire signed [DATA_W-1:0] target;

    wh_truncate #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (CELL_SHIFT)
    ) truncate_cell (
        .value_i (product_i),
        .floor_o (cell_floor),
        .up_o    (cell_up)
    );

    wire signed [CELL_W:0] cell_negated =
        -$signed({cell_floor_q[CELL_W-1], cell_floor_q}) - $signed({{CELL_W{1'b0}}, cell_up_q});

    wh_saturate #(
        .IN_W    (CELL_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_target (
        .value_i (cell_negated),
        .value_o (target)
    );

    // i* - i_n
    wire signed [DATA_W:0]   wide_error = $signed({target_q[DATA_W-1], target_q})
                                        - $signed({current_q[DATA_W-1], current_q});
    wire signed [DATA_W-1:0] error;

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_error (
        .value_i (wide_error),
        .value_o (error)
    );

    // dz(i* - i_n): one of two differences, or none.
    wire signed [DATA_W:0] above = $signed({error_q[DATA_W-1], error_q})
                                 - $signed({dead_zone[DATA_W-1], dead_zone});
    wire signed [DATA_W:0] below = $signed({error_q[DATA_W-1], error_q})
                                 + $signed({dead_zone[DATA_W-1], dead_zone});
    wire over  = !above[DATA_W] && (|above);
    wire under = below[DATA_W];

    // pull = dz(...) + (i* - i_n)/256
    wire signed [DATA_W-INNER_SHIFT-1:0] inner_floor;
    wire                                 inner_up;
    wire signed [DATA_W-1:0]             pull;

    wh_truncate #(
        .IN_W    (DATA_W),
        .SHIFT   (INNER_SHIFT)
    ) truncate_inner (
        .value_i (error_q),
        .floor_o (inner_floor),
        .up_o    (inner_up)
    );

    wire signed [DATA_W:0] wide_pull =
        $signed({beyond_q[DATA_W-1], beyond_q})
        + $signed({{(INNER_SHIFT + 1){inner_floor[DATA_W-INNER_SHIFT-1]}}, inner_floor})
        + $signed({{DATA_W{1'b0}}, inner_up});

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_pull (
        .value_i (wide_pull),
        .value_o (pull)
    );

    // -i_n
    wire signed [DATA_W:0]   negated = -$signed({current_q[DATA_W-1], current_q});
    wire signed [DATA_W-1:0] damping;

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_damping (
        .value_i (negated),
        .value_o (damping)
    );

    // i* - i_n - i_n/16
    wire signed [DATA_W-OUTWARD_SHIFT-1:0] part_floor;
    wire                                   part_up;
    wire signed [DATA_W-1:0]               outward;

    wh_truncate #(
        .IN_W    (DATA_W),
        .SHIFT   (OUTWARD_SHIFT)
    ) truncate_outward (
        .value_i (current_q),
        .floor_o (part_floor),
        .up_o    (part_up)
    );

    wire signed [DATA_W:0] wide_outward =
        $signed({error_q[DATA_W-1], error_q})
        - $signed({{(OUTWARD_SHIFT + 1){part_floor[DATA_W-OUTWARD_SHIFT-1]}}, part_floor})
        - $signed({{DATA_W{1'b0}}, part_up});

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_outward (
        .value_i (wide_outward),
        .value_o (outward)
    );

    // ---- Which error counts, and how much.
    wire moving = (|release_gain) && motion_q < release_ticks && !reversals_q[1];
    wire going_out = (negative_q == low_side_q);
    wire past_zone = (|beyond_q);
    wire excess    = (|error_q) && (error_q[DATA_W-1] != low_side_q);

    // ---- An error that a true encoder doesn't leave.
    wire signed [DATA_W:0] past_lost = $signed({beyond_q[DATA_W-1], beyond_q})
                                     + $signed({lost_current[DATA_W-1], lost_current});
    wire                   far       = (beyond_q > lost_current) || past_lost[DATA_W];

    // ---- Where a contact ends because it pulls: the half cell's current as a current word.
    wire signed [COEF_W-CELL_SHIFT-1:0] half_current = $signed(half_cell[COEF_W-1:CELL_SHIFT]);
    wire signed [DATA_W:0]              push         =
        low_side_q ? $signed({current_q[DATA_W-1], current_q}) : negated;
    wire                                pulls        =
        push > $signed({{(DATA_W + 1 - COEF_W + CELL_SHIFT){half_current[COEF_W-CELL_SHIFT-1]}},
                        half_current});

    wire held = touching_q && !pulled_q;
    wire on   = held && enable && !fault_o;  // fault_o: of the step before

    // ---- The wave.
    wire signed [PULL_W-1:0] pull_floor;
    wire                     pull_up;
    wire signed [DATA_W:0]   wave_limited;

    wh_truncate #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (PULL_SHIFT)
    ) truncate_pull (
        .value_i (product_i),
        .floor_o (pull_floor),
        .up_o    (pull_up)
    );

    // Limited before up is added: up belongs to a negative value, and can't bring it out again.
    wh_saturate #(
        .IN_W    (PULL_W + 1),
        .OUT_W   (DATA_W + 1)
    ) saturate_wave (
        .value_i ($signed({pull_floor, pull_up})),
        .value_o (wave_limited)
    );

    // ---- The tracking.
    wire signed [TRACK_W-1:0] track_floor;
    wire                      track_up;

    wh_truncate #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (TRACK_SHIFT)
    ) truncate_track (
        .value_i (product_i),
        .floor_o (track_floor),
        .up_o    (track_up)
    );

    wire signed [NEXT_W-1:0] track_wide = $signed({{(NEXT_W - TRACK_W){track_q[TRACK_W-1]}},
                                                   track_q});
    wire signed [NEXT_W-1:0] sum_wide   = $signed({{(NEXT_W - SUM_W){sum_q[SUM_W-1]}}, sum_q});
    wire signed [SUM_W-1:0]  low        = $signed({root_min, {GUARD{1'b0}}});
    wire signed [SUM_W-1:0]  high       = $signed({root_max, {GUARD{1'b0}}});
    wire                     tracks     = on && (!surface || excess) && !saturated_q;
    wire                     pinned     = too_low_q || too_high_q;
    wire                     suspect    = on && !saturated_q && (pinned || far_q);
    wire [TICK_W:0]          lost       = lost_q + (far_q ? FAR_TICKS : {{TICK_W{1'b0}}, 1'b1});
    wire                     loses      = (suspect && lost >= {1'b0, lost_ticks})
                                          || unseen || unsettled;

    // ---- A rotor that moves unseen. known, s and what is made of them stand still until SETTLE.
    wire signed [SUM_W:0]      strange    =
        $signed({lost_root[COEF_W-1], lost_root, {GUARD{1'b0}}});
    wire signed [SUM_W:0]      part       = strange >>> CHANGED_SHIFT;
    wire signed [SUM_W:0]      warm       =
        $signed({{(SUM_W + 1 - COEF_W - WARM_SHIFT){warm_root[COEF_W-1]}},
                 warm_root, {WARM_SHIFT{1'b0}}});
    wire signed [SUM_W:0]      warming    = (change_q > warm)  ? warm
                                          : (change_q < -warm) ? -warm : change_q;
    wire                       unused_warming = &{1'b0, warming[SUM_W]};
    wire                       settled    = quiet_q >= (lost_ticks >> SETTLED_SHIFT);
    wire                       watched    = tracks && !moves_q && lost_root > 0;
    wire                       unseen     = watched && settled && strange_q;
    wire [STIRRED_W-1:0]       stirred    = stirred_q + 1'b1;
    wire                       unsettled  = watched && !settled
                                            && stirred >= {lost_ticks, {UNSETTLED_SHIFT{1'b0}}};

    always @(posedge clk) begin
        change_q  <= $signed({sum_q[SUM_W-1], sum_q}) - $signed({known_q[SUM_W-1], known_q});
        strange_q <= change_q > strange || change_q < -strange;
        changed_q <= change_q > part || change_q < -part;
        warmer_q  <= known_q + $signed(warming[SUM_W-1:0]);
    end

    // ---- u_max
    wire signed [LIMIT_W-1:0] limit_wide =
        $signed({{(LIMIT_W - DATA_W){limit_base[DATA_W-1]}}, limit_base})
        - $signed({{(LIMIT_W - DROP_W){product_i[PRODUCT_W-1]}},
                   product_i[PRODUCT_W-1:SLOPE_SHIFT]});
    wire signed [DATA_W-1:0]  limit;
    reg  signed [DATA_W-1:0]  limit_q;

    wh_saturate #(
        .IN_W    (LIMIT_W),
        .OUT_W   (DATA_W)
    ) saturate_limit (
        .value_i (limit_wide),
        .value_o (limit)
    );

    wire signed [COEF_W-1:0] root = $signed(sum_q[SUM_W-1:GUARD]);

    assign tracked_o = root;

    // ---- The multiplier's operands.
    always @* begin
        request_o     = 1'b1;
        factor_o      = twice_depth;
        coefficient_o = half_cell;
        case (step_q)
            GIVE_CELL: begin
                factor_o      = twice_depth;
                coefficient_o = half_cell;
            end
            GIVE_PULL: begin
                factor_o      = word_q;
                coefficient_o = gain_q;
            end
            GIVE_TRACK: begin
                factor_o      = pull_q;
                coefficient_o = track_gain;
            end
            GIVE_LIMIT: begin
                factor_o      = limit_slope;
                coefficient_o = root;
            end
            default: request_o = 1'b0;
        endcase
    end

    // ---- What has a meaning in its own step only.
    always @(posedge clk) begin
        if (cell_done) begin
            cell_floor_q <= cell_floor;
            cell_up_q    <= cell_up;
        end
        if (pull_done) begin
            wave_floor_q <= $signed(wave_limited[DATA_W:1]);
            wave_up_q    <= wave_limited[DATA_W] && wave_limited[0];
        end
        if (track_done) begin
            track_floor_q <= track_floor;
            track_up_q    <= track_up;
        end
        if (limit_done) begin
            limit_q <= limit[DATA_W-1] ? {DATA_W{1'b0}} : limit;
        end
        case (step_q)
            TARGET: target_q <= target;
            ERROR:  error_q  <= error;
            BEYOND: beyond_q <= over  ? $signed(above[DATA_W-1:0])
                              : under ? $signed(below[DATA_W-1:0]) : {DATA_W{1'b0}};
            PULL: begin
                pull_q <= pull;
                far_q  <= far;
            end
            CHOOSE: begin
                word_q <= pull_q;
                gain_q <= moving ? release_gain >>> MOVING_SHIFT : anchor_gain;
                if (moving && going_out && excess) begin
                    word_q <= outward;
                    gain_q <= release_gain;
                end else if (moving && !going_out && !excess && past_zone) begin
                    gain_q <= release_gain;
                end else if ((moving || first_cell || (surface && excess)) && (|release_gain)
                             && !past_zone) begin
                    word_q <= damping;
                    gain_q <= surface_gain;
                end
            end
            STEP: track_q <= track_floor_q + $signed({{(TRACK_W - 1){1'b0}}, track_up_q});
            SUM:  next_q  <= !tracks    ? sum_wide
                           : low_side_q ? sum_wide - track_wide : sum_wide + track_wide;
            CLAMP: begin
                too_low_q  <= next_q < $signed({{(NEXT_W - SUM_W){low[SUM_W-1]}}, low});
                too_high_q <= next_q > $signed({{(NEXT_W - SUM_W){high[SUM_W-1]}}, high});
            end
            default: ;
        endcase
    end

    // ---- Steps, state and results.
    always @(posedge clk) begin
        if (rst) begin
            step_q      <= IDLE;
            product_q   <= CELL_PRODUCT;
            updated_q   <= 1'b0;
            overrun_o   <= 1'b0;
            position_q  <= {COUNT_W{1'b0}};
            negative_q  <= 1'b0;
            motion_q    <= release_ticks;
            reversals_q <= 2'd0;
            touching_q  <= 1'b0;
            pulled_q    <= 1'b0;
            inward_q    <= 1'b0;
            sum_q       <= $signed({root_start, {GUARD{1'b0}}});
            lost_q      <= {(TICK_W + 1){1'b0}};
            known_q     <= $signed({root_start, {GUARD{1'b0}}});
            quiet_q     <= {TICK_W{1'b0}};
            stirred_q   <= {STIRRED_W{1'b0}};
            moves_q     <= 1'b0;
            fault_q     <= 1'b0;
            wave_o      <= {DATA_W{1'b0}};
            root_o      <= root_free;
            limit_o     <= limit_free;
            pulled_o    <= 1'b0;
            fault_o     <= 1'b0;
        end else begin
            overrun_o <= overrun_o || (start_i && busy_o);
            product_q <= product_q + {1'b0, done_i};
            updated_q <= busy_o && (updated_q || update_i) && !takes_over;

            case (step_q)
                IDLE: if (start_i) begin
                    step_q      <= GIVE_CELL;
                    position_q  <= position_i;
                    touching_q  <= contact_i;
                    current_q   <= current_i;
                    depth_q     <= depth_i;
                    saturated_q <= saturated_i;
                    moves_q     <= moves;
                    inward_q    <= moves && (negative != !depth_i[COUNT_W-1]);
                    if (moves) begin
                        negative_q <= negative;
                        motion_q   <= {TICK_W{1'b0}};
                    end else if (motion_q < release_ticks) begin
                        motion_q <= motion_q + 1'b1;
                    end
                    if (contact_i && !touching_q) begin
                        reversals_q <= 2'd0;
                    end else if (turns && !reversals_q[1]) begin
                        reversals_q <= reversals_q + 2'd1;
                    end
                end
                GIVE_CELL: begin
                    if (!touching_q || inward_q) begin
                        pulled_q <= 1'b0;
                    end else if (push_only && pulls) begin
                        pulled_q <= 1'b1;
                    end
                    step_q <= grant_i ? WAIT_CELL : GIVE_CELL;
                end
                WAIT_CELL:  step_q <= cell_done ? TARGET : WAIT_CELL;
                GIVE_PULL:  step_q <= grant_i ? GIVE_TRACK : GIVE_PULL;
                GIVE_TRACK: step_q <= grant_i ? WAIT_TRACK : GIVE_TRACK;
                WAIT_TRACK: step_q <= track_done ? STEP : WAIT_TRACK;
                SETTLE: begin
                    step_q  <= GIVE_LIMIT;
                    sum_q   <= loses && settled ? known_q
                             : loses      ? $signed({root_start, {GUARD{1'b0}}})
                             : too_high_q ? high
                             : too_low_q  ? low : $signed(next_q[SUM_W-1:0]);
                    lost_q  <= suspect ? lost : {(TICK_W + 1){1'b0}};
                    fault_q <= fault_q || loses;
                    if (!held || (suspect && !settled)) begin
                        quiet_q <= {TICK_W{1'b0}};
                    end else if (tracks && !settled) begin
                        if (changed_q) begin
                            quiet_q <= {TICK_W{1'b0}};
                            known_q <= sum_q;
                        end else if (motion_q >= release_ticks) begin
                            quiet_q <= quiet_q + 1'b1;
                        end
                    end else if (tracks) begin
                        known_q <= moves_q ? sum_q : warmer_q;
                    end
                    if (moves_q || settled || !held) begin
                        stirred_q <= {STIRRED_W{1'b0}};
                    end else if (watched) begin
                        stirred_q <= stirred;
                    end
                end
                GIVE_LIMIT: step_q <= grant_i ? WAIT_LIMIT : GIVE_LIMIT;
                WAIT_LIMIT: step_q <= limit_done ? DONE : WAIT_LIMIT;
                DONE:       step_q <= takes_over ? IDLE : DONE;
                default:    step_q <= step_q + 5'd1;
            endcase

            if (takes_over) begin
                wave_o   <= on ? wave_floor_q + $signed({{(DATA_W - 1){1'b0}}, wave_up_q})
                                    : {DATA_W{1'b0}};
                root_o   <= held ? root : root_free;
                limit_o  <= held ? limit_q : limit_free;
                pulled_o <= pulled_q;
                fault_o  <= fault_q;
            end
        end
    end

endmodule

`default_nettype wire
