// SPDX-License-Identifier: Apache-2.0
//
// wh_anchor_ports: the port anchor of N ports, which take turns.
//
// For each port it equals wh_anchor bit for bit; that header has the equations and formats.
//
// valid_i begins the turn of port_i, with the settings of bank bank_i. In clocks since valid_i (step_q):
//   0           port and bank are taken
//   1, 2        the rotor's movement, and the counters of edges
//   3...30      the steps, one a clock: an adder takes the sum of the step before, a value from the memory, and a
//               product or an input. A step's sum is in sum_q two clocks later
//   2 3 4 7 8   the products of v, u, the residue, c and i_n are requested; at 22, 23, 26 those of p, p and the
//               value that θ multiplies. Each is used three clocks later. No other station may request then
//   12...32     results: data_o with the strobe of one of them, for port_o
// The next valid_i may come 32 clocks after this one, for any port. port_i and bank_i are taken with valid_i. All
// other inputs hold from then to clock 9; no copy is kept.
//
// State, by port. Block RAM: 16 values of 48 bits, as in wh_anchor. LUT RAM (wh_port_state): the values that edges
// change (33 bits and the bound's), two counters of periods, the limits' flags (12 bits), y_b, θ and c.
// Settings: 14 values in two banks in one block RAM (wh_port_settings), each read in the clock before its use.
//
// AXES: if bit n is 1, ports n and n + 1 are the axes of a brushless motor, and each equals wh_anchor with AXIS = 1.
// place_i and cell_i hold as all inputs do. Until found_i the electrical angle is unknown, and the anchor adds nothing.
// forget_i resets a port while no turn, or only another port's, is under way.
//
// Latency: above. Reset: that of wh_anchor, for all ports; of any length, at any clock. It ends a turn under way.

`default_nettype none
`include "wh_formats.vh"

module wh_anchor_ports #(
    parameter integer N      = 1,                        // ports, 1...8
    parameter integer AXES   = 0,                        // bit n: ports n, n + 1 are a brushless motor's axes
    parameter integer PORT_W = (N > 1) ? $clog2(N) : 1   // derived, leave it
) (
    input  wire                               clk,
    input  wire                               rst,

    // A turn.
    input  wire                               valid_i,       // strobe
    input  wire [PORT_W-1:0]                  port_i,
    input  wire                               bank_i,        // bank of its settings

    // The period's measurements.
    input  wire signed [`WH_COUNT_W-1:0]      position_i,    // s32, counts
    input  wire signed [`WH_PLACE_W+`WH_SINE_Q-1:0] place_i, // s30q15 cells: of an axis (wh_rotor_flux)
    input  wire signed [`WH_SINE_Q+1:0]       cell_i,        // s17q15 cells
    input  wire [N-1:0]                       found_i,       // the electrical angle is known
    input  wire [N-1:0]                       forget_i,      // strobes
    input  wire                               contact_i,
    input  wire                               blind_i,       // i_n or v_n is at the end of its range
    input  wire signed [`WH_DATA_W-1:0]       current_i,     // s31q24 A: i_n
    input  wire signed [`WH_DATA_W-1:0]       u_i,           // s31q23 √W: u_n
    input  wire signed [`WH_DATA_W-1:0]       v_i,           // s31q23 √W: v_n
    // Of the core's step before.
    input  wire signed [`WH_DATA_W-1:0]       withheld_i,    // s31q23 √W
    input  wire signed [`WH_DATA_W-1:0]       voltage_i,     // s31q23 V: e_id
    input  wire                               saturated_i,

    // The register bus (wh_port_settings).
    input  wire                               write_i,
    input  wire                               write_bank_i,
    input  wire [11:0]                        address_i,
    input  wire [31:0]                        data_i,

    // The multiplier.
    output wire                               request_o,
    output wire signed [`WH_DATA_W-1:0]       factor_o,
    output wire signed [`WH_COEF_W-1:0]       coefficient_o,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i, // 3 clocks after request_o

    // Results: what data_o is, of port_o. Strobes.
    output wire                               room_valid_o,
    output wire                               offset_valid_o,
    output wire                               flux_valid_o,
    output wire                               lag_valid_o,
    output wire                               correction_valid_o,
    output wire [PORT_W-1:0]                  port_o,
    output wire signed [`WH_DATA_W-1:0]       data_o,        // c, room, offset, χ, ω̂ as wh_anchor's
    output reg  [N-1:0]                       faults_o       // until rst
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer COEF_W    = `WH_COEF_W;
    localparam integer LONG_W    = `WH_LONG_W;
    localparam integer LONG_Q    = `WH_LONG_Q;
    localparam integer CUT       = `WH_LONG_GUARD;
    localparam integer PLACE_W   = `WH_PLACE_W;      // of the counts in x̂'s copy
    localparam integer MOVE_W    = `WH_MOVE_W;
    localparam integer SINE_Q    = `WH_SINE_Q;
    localparam integer REST_W    = `WH_REST_W;
    localparam integer FOLLOW_W  = `WH_FOLLOW_W;

    localparam integer NEAR_SHIFT = `WH_CURRENT_Q + `WH_CELLS_Q - LONG_Q;
    localparam integer FAR_SHIFT  = `WH_WAVE_Q + `WH_FLUX_Q - LONG_Q;
    localparam integer VOLT_SHIFT = LONG_Q - `WH_VOLTAGE_Q;
    localparam integer AMP_SHIFT  = LONG_Q - `WH_CURRENT_Q;
    localparam integer INNER_SHIFT = 7;  // of z within the dead zone, of both means; one more for an axis
    localparam integer BETAS       = AXES << 1;
    localparam integer COUNT_SHIFT = 2;  // of what y' takes with a full count
    localparam integer FADE_SHIFT  = 1;  // of what a turn outwards takes of θ
    localparam integer BEHIND_SHIFT = 5;  // of the count by which z is behind χ after a reversal; one less for an axis
    localparam integer FEW_SHIFT   = INNER_SHIFT + 1 + CUT;  // by half of a step of y' shrinks y_b,
    localparam integer LESS_SHIFT  = COUNT_SHIFT + 1 + CUT;  // of one with a count
    localparam integer THETA_CUT   = `WH_LEARN_Q + LONG_Q - CUT - FAR_SHIFT - `WH_PULL_Q;  // of θ below a coefficient
    localparam integer THETA_W     = LONG_W - THETA_CUT;
    localparam [1:0]   FRESH_TICKS = 3;  // a contact is reported in the period of its edge or in the next two
    localparam integer EXCUSES_W   = 5;  // c may be far beyond its limit for 2^EXCUSES_W - 1 steps of y'

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_anchor_ports_n_must_be_1_to_8 stop ();
        end
        if (NEAR_SHIFT < 1 || NEAR_SHIFT != `WH_PULL_Q - CUT || THETA_CUT < VOLT_SHIFT + 1 || THETA_W < COEF_W
            || DATA_W + COEF_W - NEAR_SHIFT < LONG_W || VOLT_SHIFT < 2) begin : illegal_format
            wh_illegal_parameter_anchor_ports_formats stop ();
        end
    endgenerate

    // ---- The turn. A step's operands are fetched in one clock (step_q) and added in the next (adds_q). Selections
    // that depend on step_q and drive every bit of an operand are computed a clock before.
    localparam [4:0] IDLE = 0, EDGES = 2,
                     BASE = 3, EDGE = 4, ADD_V = 5, ADD_U = 6, ADD_OWED = 7,
                     HALF = 8, LIMIT = 9,
                     ZERO = 10, CURRENT = 11, SWING = 12, MEAN = 13, FLUX = 14, CHI = 15,
                     AHEAD = 16, BOUND = 17, BACK = 18, BEYOND = 19,
                     PLACE = 20, X_HAT = 21, LAG = 22, FOLLOW = 23,
                     TAKE_THETA = 24, LEARN = 25, CORRECT = 26,
                     CLIP = 27, STRANGE = 28, HELD = 29, CHOOSE = 30;

    reg [4:0]        step_q;     // clocks since valid_i; IDLE in its clock and while there is no turn
    reg [4:0]        ahead_q;    // the step after step_q
    reg [4:0]        adds_q;     // the step before it,
    reg              go_q;       // which adds
    reg [PORT_W-1:0] port_q;
    reg              bank_q;

    wire [(1<<PORT_W)-1:0] axes = AXES[(1<<PORT_W)-1:0] | BETAS[(1<<PORT_W)-1:0];
    wire                   axis = axes[port_q];        // of a brushless motor
    wire [N-1:0]           resets = {N{rst}} | forget_i;

    wire busy = (step_q != IDLE);
    wire ends = go_q && adds_q == CHOOSE;

    always @(posedge clk) begin
        if (valid_i) begin
            port_q <= port_i;
            bank_q <= bank_i;
        end
        if (rst) begin
            step_q <= IDLE;
            go_q   <= 1'b0;
        end else begin
            step_q <= (valid_i || busy) ? step_q + 5'd1 : IDLE;
            go_q   <= (step_q >= BASE && step_q <= CHOOSE);
        end
        ahead_q <= busy ? step_q + 5'd2 : 5'd2;
        adds_q  <= step_q;
    end

    // ---- Settings, by their addresses in the register map; the comments give the clock in which each is valid.
    localparam [3:0] S_ENABLE = 0, S_FLUX = 1, S_OWED = 2, S_CELLS = 3, S_PULL = 4, S_LEARN = 5, S_LEARN_MAX = 6,
                     S_ZERO = 7, S_ROOM = 8, S_REACH = 9, S_STRANGE = 10, S_BRUSH = 11, S_FOLLOW = 12, S_SLOW = 13;

    reg  [3:0]        setting_word;
    wire [DATA_W-1:0] setting;

    always @* begin
        case (step_q)
            5'd1:    setting_word = S_FLUX;                          // 2: product of v
            5'd2:    setting_word = begins_q ? S_OWED : S_FLUX;      // 3: of u; as a contact begins, u counts as flux
            5'd3:    setting_word = saturated_i ? S_OWED : S_FLUX;   // 4: of the residue
            5'd4:    setting_word = S_SLOW;
            5'd5:    setting_word = S_FOLLOW;
            5'd6:    setting_word = contact_q ? S_ROOM : S_ZERO;     // 7: of c
            5'd7:    setting_word = S_CELLS;                         // 8: of i_n
            5'd8:    setting_word = S_REACH;
            5'd9:    setting_word = S_ENABLE;
            5'd13:   setting_word = S_BRUSH;
            5'd21:   setting_word = S_LEARN;                         // 22: of p
            5'd22:   setting_word = S_PULL;                          // 23: of p
            5'd27:   setting_word = S_STRANGE;
            default: setting_word = S_LEARN_MAX;                     // 24, 27, 29
        endcase
    end

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (4),
        .W            (DATA_W),
        .FIRST        (32)
    ) settings (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (busy),
        .bank_i       (bank_q),
        .port_i       (port_q),
        .word_i       (setting_word),
        .word_o       (setting)
    );

    wire [COEF_W-1:0] gain      = setting[COEF_W-1:0];
    wire [COEF_W-1:0] learn_max = setting[COEF_W-1:0];

    // ---- State that edges change, at clock 2.
    wire       [PLACE_W-1:0] position_q;
    wire                     started_q;   // there was a turn before
    wire                     contact_q;
    wire                     back_q;      // direction of the last edge
    wire                     turned_q;    // it differs from that of the edge before
    wire                     counted_q;   // direction of the last full count
    wire                     travels_q;   // the full count before had the same direction
    wire                     sinks_q;     // the last edge reduced the flux
    wire [1:0]               fresh_q;     // turns for which that edge can begin a contact
    wire [1:0]               chi_at_q;    // where in the memory χ is, 1 to 3,
    wire [1:0]               up_at_q;     // χ before the last edge that raised the flux,
    wire [1:0]               down_at_q;   // and that before the last one that reduced it
    wire                     knows_up_q;  // these are of this contact, with single counts since, and
    wire                     knows_down_q;  // they aren't beyond the end of the zone that they would replace
    wire                     up_all_q;    // they are beyond its other end
    wire                     down_all_q;
    wire                     bound_q;     // the last edge's bound is in force
    wire                     copies_q;    // x̂'s slow copy stays in this turn

    reg  signed [MOVE_W-1:0] moved_q;
    reg                      begins_q;    // the contact
    reg                      first_q;     // the first turn: the memory's state reads as 0
    reg                      same_way_q;
    reg                      turns_back_q;  // a rotor that travelled
    reg                      chi_above_q; // χ of the turn before is above the zone,
    reg                      chi_below_q; // or below it

    wire                     edges    = (step_q == EDGES);
    wire signed [MOVE_W-1:0] moved    =
        started_q ? $signed(position_i[MOVE_W-1:0] - position_q[MOVE_W-1:0]) : {MOVE_W{1'b0}};
    wire                     moves    = |moved_q;
    wire                     back     = moved_q[MOVE_W-1];
    wire                     one      = back ? (&moved_q) : (moved_q[MOVE_W-1:1] == 0);
    wire                     same_way = moves && (back == back_q || !one);
    wire                     sinks;       // this turn's edge reduces the flux
    wire                     edged    = (fresh_q != 2'd0);
    wire                     steps    = moves && !begins_q;
    wire                     trades   = steps && one;

    always @(posedge clk) begin
        if (step_q == 5'd1) begin
            moved_q  <= moved;
            begins_q <= contact_i && !contact_q;
            first_q  <= !started_q;
        end
        if (edges) begin
            same_way_q   <= same_way;
            turns_back_q <= travels_q && back != counted_q && !begins_q;
        end
    end

    localparam integer EDGES_W = PLACE_W + 21;

    // Where χ and its bounds are before the first edge: bits that are stored inverted.
    localparam [5:0] PLACES = {2'd1, 2'd2, 2'd3};
    wire [5:0] places;
    assign {chi_at_q, up_at_q, down_at_q} = places ^ PLACES;

    wire [1:0] fresh_next = moves ? FRESH_TICKS : edged ? fresh_q - 2'd1 : 2'd0;
    wire [1:0] chi_next   = !trades ? chi_at_q : sinks ? down_at_q : up_at_q;
    wire [1:0] up_next    = (trades && !sinks) ? chi_at_q : up_at_q;
    wire [1:0] down_next  = (trades && sinks) ? chi_at_q : down_at_q;
    wire       released;  // z has been at an axis' bound since the edge

    wh_port_state #(
        .N       (N),
        .RESETS  (N),
        .W       (EDGES_W)
    ) edges_state (
        .clk     (clk),
        .rst     (resets),
        .port_i  (port_q),
        .save_i  (edges),
        .save_port_i (port_q),
        .value_i ({position_i[PLACE_W-1:0], 1'b1, contact_i,
                   moves ? back : back_q,
                   !(begins_q || (moves ? same_way : !turned_q)),
                   (begins_q || same_way) ? (moves ? back : back_q) : counted_q,
                   begins_q || (same_way ? back == counted_q : travels_q),
                   moves ? sinks : sinks_q,
                   fresh_next,
                   {chi_next, up_next, down_next} ^ PLACES,
                   !begins_q && (steps ? one && (sinks ? knows_up_q : !chi_below_q) : knows_up_q),
                   !begins_q && (steps ? one && (sinks ? !chi_above_q : knows_down_q) : knows_down_q),
                   (steps && !sinks) ? chi_above_q : up_all_q,
                   (steps && sinks) ? chi_below_q : down_all_q,
                   (begins_q || moves) ? !begins_q : bound_q && !released,
                   started_q && !copies_q && !axis}),
        .value_o ({position_q, started_q, contact_q, back_q, turned_q, counted_q, travels_q, sinks_q, fresh_q,
                   places, knows_up_q, knows_down_q, up_all_q, down_all_q, bound_q, copies_q})
    );

    wire same_q = !turned_q;

    // ---- State that periods change, as their settings become valid.
    wire   [REST_W-1:0] quiet_q;    // periods until a rotor without a full count is slow
    wire [FOLLOW_W-1:0] phase_q;    // y' moves in the turn where this is 1 or 0
    reg                 strobe_q;   // y' moves in this turn, as in one of follow_ticks,
    reg                 counts_q;   // or with a full count
    reg                 fading_q;   // this turn halves θ
    reg                 clipped_q;  // c was at its limit

    wire slow    = (quiet_q == {REST_W{1'b0}});
    wire follows = (phase_q[FOLLOW_W-1:1] == {(FOLLOW_W - 1){1'b0}});
    wire counts  = same_way_q && !axis;  // a count moves y'
    wire outward = (back_q == presses_q);

    wh_port_state #(
        .N       (N),
        .RESETS  (N),
        .W       (REST_W)
    ) quiet_state (
        .clk     (clk),
        .rst     (resets),
        .port_i  (port_q),
        .save_i  (step_q == 5'd5),
        .save_port_i (port_q),
        .value_i (same_way_q ? setting[REST_W-1:0] : quiet_q - {{(REST_W - 1){1'b0}}, !slow}),
        .value_o (quiet_q)
    );

    wh_port_state #(
        .N       (N),
        .RESETS  (N),
        .W       (FOLLOW_W)
    ) phase_state (
        .clk     (clk),
        .rst     (resets),
        .port_i  (port_q),
        .save_i  (step_q == 5'd6),
        .save_port_i (port_q),
        .value_i (follows ? setting[FOLLOW_W-1:0] : phase_q - 1'b1),
        .value_o (phase_q)
    );

    always @(posedge clk) begin
        if (step_q == 5'd6) begin
            strobe_q <= follows;
            counts_q <= counts;
            fading_q <= counts && outward && turns_back_q && contact_q && !clipped_q;
        end
    end

    // ---- Flags of the limits, from turn to turn.
    reg  tracked_q;       // the offset is in the memory, else it is 0
    reg  presses_q;       // y' is below 0
    reg  full_q;          // θ is the largest
    reg  void_q;          // θ is below 0
    reg  [EXCUSES_W-1:0] excuses_q;  // steps of y' in which c may yet be far beyond its limit
    wire [EXCUSES_W-1:0] excuses;
    wire chi_above, chi_below, tracked, presses, full_before, void_before, clipped;

    localparam integer FLAGS_W  = 7 + EXCUSES_W;
    localparam integer LIMITS_W = FLAGS_W + ((AXES != 0) ? 1 : 0);
    wire                met;         // the bound of an axis is released
    wire [LIMITS_W-1:0] limits;
    wire                unused_met  = &{1'b0, limits_next[FLAGS_W]};
    wire [FLAGS_W:0]    limits_next = {met, chi_above_q, chi_below_q, tracked_q, presses_q, full_q, void_q,
                                       clipped_q, excuses_q};

    wh_port_state #(
        .N       (N),
        .RESETS  (N),
        .W       (LIMITS_W)
    ) limits_state (
        .clk     (clk),
        .rst     (resets),
        .port_i  (port_q),
        .save_i  (ends),
        .save_port_i (port_q),
        .value_i (limits_next[LIMITS_W-1:0]),
        .value_o (limits)
    );

    assign {chi_above, chi_below, tracked, presses, full_before, void_before, clipped, excuses} = limits[FLAGS_W-1:0];
    assign released = limits[LIMITS_W-1] && AXES != 0;

    // ---- The flux by the encoder: all of it, its change in the period, its value as a contact begins, half of its
    // change by a count, the distance of z from χ, and whether χ or z, sum_q of the steps AHEAD and BOUND,
    // is beyond that half.
    wire signed [LONG_W-1:0] place, moved_flux, start_flux, half_flux, ahead_flux;
    wire                     out;
    wire signed [LONG_W-1:0] motor_place = $signed({position_q, {LONG_Q{1'b0}}});
    wire signed [LONG_W-1:0] motor_moved = $signed({{(LONG_W - LONG_Q - MOVE_W){moved_q[MOVE_W-1]}}, moved_q,
                                                    {LONG_Q{1'b0}}});
    wire signed [LONG_W-1:0] motor_start = $signed({{(LONG_W - LONG_Q + 1){edged && back_q}}, edged,
                                                    {(LONG_Q - 2){1'b0}}});
    wire signed [LONG_W-1:0] motor_half  = $signed({{(LONG_W - LONG_Q){1'b0}}, 1'b1, {(LONG_Q - 1){1'b0}}});
    wire signed [LONG_W-1:0] motor_ahead = $signed({{(LONG_W - LONG_Q + 1){1'b0}}, same_q,
                                                    {(BEHIND_SHIFT - 3){1'b0}}, !same_q,
                                                    {(LONG_Q - BEHIND_SHIFT){1'b0}}});
    wire                     motor_out   = back_sum ? !(&sum_q[LONG_W-2:LONG_Q-1])
                                                    : (|sum_q[LONG_W-2:LONG_Q-1]);

    generate
        if (AXES != 0) begin : of_axes
            localparam integer FLUX_W = PLACE_W + SINE_Q;
            localparam integer HALF_W = LONG_W - LONG_Q + SINE_Q + 1;  // χ in fractions of the LSB of half a count

            reg  signed [FLUX_W-1:0] words [0:(1<<PORT_W)-1];
            wire signed [FLUX_W-1:0] place_q = words[port_q];
            reg  signed [FLUX_W-1:0] moved_flux_q;
            reg  signed [SINE_Q+1:0] cell_q;

            always @(posedge clk) begin
                if (step_q == 5'd1) begin
                    moved_flux_q <= started_q ? place_i - place_q : {FLUX_W{1'b0}};
                    cell_q       <= cell_i;
                end
                if (edges) begin
                    words[port_q] <= place_i;
                end
            end

            reg                      released_q;
            wire signed [SINE_Q+1:0] size = cell_q[SINE_Q+1] ? -cell_q : cell_q;
            wire signed [SINE_Q+1:0] way  = !edged ? {SINE_Q+2{1'b0}} : back_q ? -cell_q : cell_q;
            wire signed [HALF_W-1:0] half = $signed({{(HALF_W - SINE_Q - 2){1'b0}}, size});
            wire signed [HALF_W-1:0] chi  = $signed(sum_q[LONG_W-1:LONG_Q-SINE_Q-1]);

            assign place      = axis ? $signed({place_q, {(LONG_Q - SINE_Q){1'b0}}}) : motor_place;
            assign moved_flux = axis ? $signed({moved_flux_q, {(LONG_Q - SINE_Q){1'b0}}}) : motor_moved;
            assign start_flux = axis ? $signed({{(HALF_W - SINE_Q - 2){way[SINE_Q+1]}}, way,
                                                {(LONG_Q - SINE_Q - 1){1'b0}}}) : motor_start;
            assign half_flux  = axis ? $signed({half, {(LONG_Q - SINE_Q - 1){1'b0}}}) : motor_half;
            assign ahead_flux = !axis   ? motor_ahead
                                : same_q ? $signed({1'b0, half, {(LONG_Q - SINE_Q - 2){1'b0}}})
                                         : $signed({{(LONG_W - LONG_Q + BEHIND_SHIFT - 2){1'b0}}, 1'b1,
                                                    {(LONG_Q - BEHIND_SHIFT + 1){1'b0}}});
            assign met        = released_q;
            assign sinks      = axis ? moved_flux_q[FLUX_W-1] : back;
            assign out        = !axis ? motor_out : back_sum ? (chi < -half) : (chi >= half);

            always @(posedge clk) begin
                if (step_q == 5'd1) begin
                    released_q <= released;
                end else if (edges && (begins_q || moves)) begin
                    released_q <= 1'b0;
                end else if (go_q && adds_q == BACK) begin
                    released_q <= released_q || (axis && contact_q && !beside);
                end
            end
        end else begin : of_motors
            wire unused_axis = &{1'b0, place_i, cell_i, found_i};

            assign place      = motor_place;
            assign moved_flux = motor_moved;
            assign start_flux = motor_start;
            assign half_flux  = motor_half;
            assign ahead_flux = motor_ahead;
            assign sinks      = back;
            assign out        = motor_out;
            assign met        = 1'b0;
        end
    endgenerate

    // The memory's words; χ and its two bounds take turns in the last three.
    localparam [3:0] M_FLUX = 0, M_THETA = 1, M_MEAN = 2, M_ZERO = 3, M_FOLLOWER = 4,
                     M_LIMIT = 9, M_CURRENT = 10, M_WANTED = 12,
                     M_LOSS = 12;  // the decrease of the offset, until c is valid
    wire [3:0] m_chi   = {2'b11, chi_at_q};
    wire [3:0] m_bound = {2'b11, sinks_q ? up_at_q : down_at_q};
    localparam integer MEMORY_W = ((N > 1) ? PORT_W : 0) + 4;

    // ---- The operands of a step.
    localparam [3:0] B_NEAR = 0, B_FAR = 1,        // products
                     B_VOLTAGE = 2, B_THETA = 3,   // the latter a quarter of the largest
                     B_REACH = 4, B_FREE = 5,      // a setting, or half of it
                     B_HALF = 6, B_MOVED = 7, B_PLACE = 8, B_START = 9, B_AHEAD = 10;

    // No value is read in the clock in which it is written, so the block RAM's behaviour then doesn't matter;
    // else Yosys would add logic for it.
    (* ram_style = "block", no_rw_check *)
    reg signed [LONG_W-1:0] memory [0:(1<<(MEMORY_W))-1];
    reg signed [LONG_W-1:0] read_q;
    reg signed [LONG_W-1:0] sum_q;
    reg                     turns_q;                 // the second adder subtracts y_b
    reg                     swings_q;
    reg signed [LONG_W-1:0] b_q;
    reg                     saturated_q;
    reg                     blind_q;                 // nothing is learned, and c is 0
    reg                     far_q;                   // χ or L̂ i is in the outer half of its range
    reg                     over_q;                  // the product in b_q was, and
    reg                     below_q;                 // below 0
    reg        [3:0]        read_from;
    reg        [3:0]        write_to_q;
    reg        [3:0]        write_to;
    reg                     writes_q, writes;
    reg        [3:0]        store_to_q;
    reg                     stores_q;                // sum_q is to be written
    reg                     sum_too_q, sum_too;      // a is the sum, or
    reg                     inner_q, inner;          // its 128th,
    reg                     quarter_q, half_q;       // a quarter or half of it, or 0
    reg                     memory_too_q, memory_too;  // b is the value read, or b_q
    reg                     fresh;                   // the value read counts as 0 in the first turn
    reg        [3:0]        b_from;
    reg        [1:0]        low_q, mid_q, high_q, top_q;  // how b_q's chains begin, and
    reg        [4:0]        high_by_q;                    // which of their links chooses
    reg        [1:0]        top_by_q;
    reg                     near_q;                       // b_q is of a product, B_NEAR
    reg                     bare_q, bare;            // b_q is 0
    reg                     minus_q, minus;
    reg                     to_zero_q;               // minus if the sum isn't
    reg                     out_q;                   // z is outside the zone,
    reg                     above_q;                 // above it
    wire signed [DATA_W-1:0] brush_q;                // s31q16 counts, 0...: y_b
    reg signed [DATA_W-1:0] told_q;                  // s31q16 counts: y' + sgn y' y_b - 2 (y - y')
    wire signed [COEF_W-1:0] theta_q;                // s27q20 V a count: θ, 0...learn_max
    reg                     strange_q;               // c exceeds its limit by strange
    reg                     negative_q;              // the requested correction g_ρ p is below 0;
    reg                     wild_q;                  // it doesn't fit its format
    reg                     huge_q;                  // θ (y' + sgn y' y_b) doesn't fit its format,
    reg                     sign_q;                  // and is below 0
    wire                    loses;                   // sum_q is not to be written
    reg                     sinks_p_q;               // p is below 0
    wire signed [DATA_W-1:0] next_q;                 // s31q23 V: c of the turn before
    reg                     enable_q;

    wire back_sum = sum_q[LONG_W-1];
    wire moves_mean = (strobe_q || counts_q) && contact_q && travels_q && !blind_q && !far_q && !begins_q;

    wire grows  = (sinks_p_q != presses_q);
    wire learns = contact_q && out_q && !saturated_q && !blind_q && !(grows ? full_q || clipped_q : void_q);

    // Whether z is beyond the last edge's bound: of z less the bound, sum_q of the step BACK. The bound's flags are
    // valid since the turn's first clocks.
    reg  known_q;  // the bound is in force,
    reg  all_q;    // and is beyond the dead zone's other end
    wire beside = known_q && (all_q || back_sum == sinks_q) && !(out_q && above_q == sinks_q);

    always @(posedge clk) begin
        known_q <= bound_q && contact_q && (sinks_q ? knows_up_q : knows_down_q);
        all_q   <= sinks_q ? up_all_q : down_all_q;
    end

    wire past   = wild_q || (back_sum == negative_q);

    always @* begin
        sum_too    = 1'b0;
        inner      = 1'b0;
        memory_too = 1'b0;
        fresh      = 1'b0;
        minus      = 1'b0;
        read_from  = M_FOLLOWER;
        writes     = 1'b0;
        write_to   = M_FLUX;
        case (step_q)
            HALF: minus = voltage_i[DATA_W-1];
            LIMIT: begin
                sum_too  = 1'b1;
                writes   = 1'b1;
                write_to = M_LIMIT;
            end
            BASE: begin
                memory_too = !begins_q;
                fresh      = 1'b1;
                read_from  = M_FLUX;
            end
            EDGE: sum_too = 1'b1;
            ADD_V: begin
                sum_too = 1'b1;
                minus   = 1'b1;
            end
            ADD_U: begin
                sum_too = 1'b1;
                minus   = !begins_q;
            end
            ADD_OWED: begin
                sum_too = 1'b1;
                minus   = 1'b1;
                writes  = 1'b1;
            end
            ZERO: begin
                minus    = contact_q && next_q[DATA_W-1];
                writes   = 1'b1;
                write_to = M_LOSS;
            end
            CURRENT: begin
                writes   = 1'b1;
                write_to = M_CURRENT;
            end
            SWING: begin  // out of contact the offset's
                sum_too    = contact_q;
                memory_too = contact_q || tracked_q;
                read_from  = contact_q ? M_MEAN : M_ZERO;
                minus      = contact_q;
            end
            MEAN: begin
                sum_too    = !contact_q;
                inner      = moves_mean;
                memory_too = !begins_q;
                minus      = !contact_q || begins_q;  // begins with what presses against the rotor's way
                read_from  = contact_q ? M_MEAN : M_LOSS;
                writes     = 1'b1;
                write_to   = contact_q ? M_MEAN : M_ZERO;
            end
            FLUX: begin
                memory_too = 1'b1;
                read_from  = M_FLUX;
            end
            CHI: begin
                sum_too    = 1'b1;
                memory_too = 1'b1;
                read_from  = M_CURRENT;
                writes     = 1'b1;
                write_to   = m_chi;
            end
            AHEAD: begin
                sum_too = 1'b1;
                minus   = (sinks_q == same_q);
            end
            BOUND: begin
                sum_too    = 1'b1;
                memory_too = known_q;
                read_from  = m_bound;
                minus      = 1'b1;
            end
            BACK: begin
                sum_too    = 1'b1;
                memory_too = known_q;
                read_from  = m_bound;
            end
            BEYOND: begin
                sum_too    = beside || out_q;
                inner      = !beside && !out_q;
                memory_too = beside && !all_q;
                read_from  = m_bound;
                minus      = !beside ? above_q : !all_q || sinks_q;
            end
            X_HAT: begin
                sum_too    = 1'b1;
                memory_too = 1'b1;
                read_from  = m_chi;
                minus      = 1'b1;
            end
            LAG: begin
                sum_too    = 1'b1;
                memory_too = 1'b1;
                fresh      = 1'b1;
                minus      = 1'b1;
            end
            FOLLOW: begin
                inner      = 1'b1;
                memory_too = 1'b1;
                fresh      = 1'b1;
                writes     = !copies_q;
                write_to   = M_FOLLOWER;
            end
            TAKE_THETA: begin
                memory_too = 1'b1;
                fresh      = 1'b1;
                minus      = fading_q;
                read_from  = M_THETA;
            end
            LEARN: begin
                sum_too    = !fading_q;
                inner      = fading_q;
                memory_too = fading_q;
                read_from  = M_THETA;
                minus      = !presses_q && !fading_q;
                writes     = 1'b1;
                write_to   = M_THETA;
            end
            CORRECT: begin
                minus    = 1'b1;
                writes   = 1'b1;
                write_to = M_WANTED;
            end
            CLIP: begin
                sum_too    = 1'b1;
                memory_too = 1'b1;
                read_from  = M_LIMIT;
            end
            STRANGE: begin
                sum_too = 1'b1;
                minus   = !back_sum;
            end
            CHOOSE: begin
                sum_too    = 1'b1;
                memory_too = 1'b1;
                read_from  = clipped_q ? M_LIMIT : M_WANTED;
                minus      = clipped_q && negative_q;
            end
            default: ;
        endcase
    end

    // The source of b_q in the next step.
    always @* begin
        bare   = 1'b0;
        b_from = B_VOLTAGE;
        case (ahead_q)
            HALF:    ;
            LIMIT:   b_from = contact_q ? B_REACH : B_FREE;
            EDGE:    b_from = begins_q ? B_START : B_MOVED;
            ADD_V: begin
                bare   = begins_q;
                b_from = B_FAR;
            end
            ADD_U: begin
                b_from = B_FAR;
            end
            ADD_OWED: begin
                bare   = !contact_q || begins_q;
                b_from = B_FAR;
            end
            ZERO: begin
                bare   = !contact_q && (!slow || blind_q);
                b_from = B_FAR;
            end
            CURRENT, CORRECT: begin
                b_from = B_NEAR;
            end
            MEAN: begin
                bare   = !begins_q;
                b_from = B_START;
            end
            TAKE_THETA: begin
                bare   = !first_q;
                b_from = B_THETA;
            end
            AHEAD: begin
                bare   = !contact_q;
                b_from = B_AHEAD;
            end
            BEYOND:  b_from = B_HALF;
            PLACE:   b_from = B_PLACE;
            LEARN: begin
                bare   = !learns || fading_q;
                b_from = B_FAR;
            end
            HELD: begin
                bare   = !contact_q;
                b_from = B_NEAR;
            end
            STRANGE: b_from = B_REACH;
            default: bare = 1'b1;
        endcase
    end

    // Inputs are selected by chains. Each link is a LUT for two operands: either it passes on the link before, or it
    // gives the second operand where that is 1, and the first where it is 0. A chain's first link gives a product,
    // 1 or 0. The lowest bits have products only, the middle ones no flux, the highest no setting.
    localparam integer LOW_W   = VOLT_SHIFT - 1;
    localparam integer COUNT_Q = (AXES != 0) ? LONG_Q - SINE_Q - 2 : LONG_Q - BEHIND_SHIFT;
    localparam integer THETA_Q = THETA_CUT - 2;  // of a quarter of the largest θ
    localparam integer TOP_Q   = (VOLT_SHIFT + DATA_W > THETA_Q + COEF_W) ? VOLT_SHIFT + DATA_W - 1
                                                                          : THETA_Q + COEF_W - 1;
    localparam integer MID_W   = COUNT_Q - LOW_W;
    localparam integer HIGH_W  = TOP_Q - COUNT_Q;
    localparam integer TOP_W   = LONG_W - TOP_Q;

    wire [LONG_W-1:0] near_b    = product_i[NEAR_SHIFT +: LONG_W];
    wire [LONG_W-1:0] far_b     = {{(LONG_W - DATA_W - COEF_W + FAR_SHIFT){product_i[DATA_W+COEF_W-1]}},
                                   product_i[DATA_W+COEF_W-1:FAR_SHIFT]};
    wire [LONG_W-1:0] voltage_b = {{(LONG_W - DATA_W - VOLT_SHIFT + 1){voltage_i[DATA_W-1]}}, voltage_i,
                                   {(VOLT_SHIFT - 1){1'b0}}};
    wire [TOP_Q-1:0]  reach_b   = {{(TOP_Q - VOLT_SHIFT - DATA_W + 1){1'b0}}, setting[DATA_W-2:0],
                                   {VOLT_SHIFT{1'b0}}};
    wire [TOP_Q-1:0]  free_b    = {{(TOP_Q - VOLT_SHIFT - DATA_W + 2){1'b0}}, setting[DATA_W-2:1],
                                   {VOLT_SHIFT{1'b0}}};
    wire [TOP_Q-1:0]  theta_b   = {{(TOP_Q - THETA_Q - COEF_W + 1){1'b0}}, learn_max[COEF_W-2:0],
                                   {THETA_Q{1'b0}}};

    wire [LOW_W-1:0]  b_low  = ({LOW_W{low_q[0]}} & near_b[LOW_W-1:0]) | ({LOW_W{low_q[1]}} & far_b[LOW_W-1:0]);

    wire [MID_W-1:0]  mid_0  = ({MID_W{mid_q[0]}} & (near_b[LOW_W +: MID_W] | {MID_W{mid_q[1]}}))
                             | ({MID_W{mid_q[1] && !mid_q[0]}} & far_b[LOW_W +: MID_W]);
    wire [MID_W-1:0]  mid_1  = high_by_q[0] ? (mid_0 & theta_b[LOW_W +: MID_W])
                                              | (~mid_0 & voltage_b[LOW_W +: MID_W]) : mid_0;
    wire [MID_W-1:0]  b_mid  = high_by_q[1] ? (mid_1 & free_b[LOW_W +: MID_W])
                                              | (~mid_1 & reach_b[LOW_W +: MID_W]) : mid_1;

    wire [HIGH_W-1:0] high_0 = ({HIGH_W{high_q[0]}} & (near_b[COUNT_Q +: HIGH_W] | {HIGH_W{high_q[1]}}))
                             | ({HIGH_W{high_q[1] && !high_q[0]}} & far_b[COUNT_Q +: HIGH_W]);
    wire [HIGH_W-1:0] high_1 = high_by_q[0] ? (high_0 & theta_b[COUNT_Q +: HIGH_W])
                                              | (~high_0 & voltage_b[COUNT_Q +: HIGH_W]) : high_0;
    wire [HIGH_W-1:0] high_2 = high_by_q[1] ? (high_1 & free_b[COUNT_Q +: HIGH_W])
                                              | (~high_1 & reach_b[COUNT_Q +: HIGH_W]) : high_1;
    wire [HIGH_W-1:0] high_3 = high_by_q[2] ? high_2 & half_flux[COUNT_Q +: HIGH_W] : high_2;
    wire [HIGH_W-1:0] high_4 = high_by_q[3] ? (high_3 & place[COUNT_Q +: HIGH_W])
                                              | (~high_3 & moved_flux[COUNT_Q +: HIGH_W]) : high_3;
    wire [HIGH_W-1:0] b_high = high_by_q[4] ? (high_4 & ahead_flux[COUNT_Q +: HIGH_W])
                                              | (~high_4 & start_flux[COUNT_Q +: HIGH_W]) : high_4;

    wire [TOP_W-1:0]  top_0  = ({TOP_W{top_q[0]}} & (near_b[TOP_Q +: TOP_W] | {TOP_W{top_q[1]}}))
                             | ({TOP_W{top_q[1] && !top_q[0]}} & far_b[TOP_Q +: TOP_W]);
    wire [TOP_W-1:0]  top_1  = top_by_q[0] ? (top_0 & moved_flux[TOP_Q +: TOP_W])
                                             | (~top_0 & voltage_b[TOP_Q +: TOP_W]) : top_0;
    wire [TOP_W-1:0]  b_top  = top_by_q[1] ? (top_1 & place[TOP_Q +: TOP_W])
                                             | (~top_1 & start_flux[TOP_Q +: TOP_W]) : top_1;

    // A product of the outer half of a long word's range, or beyond it.
    wire outer = !(&product_i[DATA_W+COEF_W-1:NEAR_SHIFT+LONG_W-2])
                 && (|product_i[DATA_W+COEF_W-1:NEAR_SHIFT+LONG_W-2]);

    always @(posedge clk) begin
        b_q <= (bare_q || (step_q == BEYOND && (beside ? !all_q : !out_q))) ? {LONG_W{1'b0}}
               : {b_top, b_high, b_mid, b_low};
        over_q       <= !bare_q && near_q && outer;
        below_q      <= product_i[DATA_W+COEF_W-1];
        sum_too_q    <= sum_too;
        inner_q      <= inner && !(step_q == MEAN && counts_q) && !(step_q == LEARN);
        quarter_q    <= inner && step_q == MEAN && counts_q;
        half_q       <= inner && step_q == LEARN;
        memory_too_q <= memory_too && !(fresh && first_q);
        minus_q      <= minus;
        to_zero_q    <= (step_q == CLIP);
        swings_q     <= (step_q == SWING);
        writes_q     <= writes;
        write_to_q   <= write_to;
    end

    // ---- The adder. Its sum goes only to sum_q, so that sum and register share an FPGA's cells. The two steps after
    // a write can't read it.
    wire                     takes_off = to_zero_q ? !back_sum : minus_q;
    wire signed [LONG_W-1:0] inner_sum = sum_q >>> INNER_SHIFT;
    wire signed [LONG_W-1:0] part      = axis ? inner_sum >>> 1 : inner_sum;
    wire signed [LONG_W-1:0] quarter   = sum_q >>> COUNT_SHIFT;
    wire signed [LONG_W-1:0] halved    = sum_q >>> FADE_SHIFT;
    wire signed [LONG_W-1:0] a    = ({LONG_W{sum_too_q}} & sum_q) | ({LONG_W{inner_q}} & part)
                                    | ({LONG_W{quarter_q}} & quarter) | ({LONG_W{half_q}} & halved);
    wire signed [LONG_W-1:0] b    =
        (b_q | ({LONG_W{memory_too_q}} & read_q)) ^ {LONG_W{takes_off}};
    // The sign once more, for where it drives every bit of an operand; in the step SWING its opposite.
    wire                     turns;
    wire signed [LONG_W-1:0] sum;
    assign {turns, sum} = {a[LONG_W-1], a} + {b[LONG_W-1] ^ swings_q, b} + {{LONG_W{1'b0}}, takes_off};

    wire unused = &{1'b0, product_i[NEAR_SHIFT-1:0], position_i[`WH_COUNT_W-1:PLACE_W], setting[DATA_W-1],
                    place[COUNT_Q-1:0], moved_flux[COUNT_Q-1:0],
                    start_flux[COUNT_Q-1:0], half_flux[LONG_W-1:TOP_Q], half_flux[COUNT_Q-1:0],
                    ahead_flux[LONG_W-1:TOP_Q], ahead_flux[COUNT_Q-1:0], voltage_b[LOW_W-1:0], reach_b[LOW_W-1:0],
                    free_b[LOW_W-1:0], theta_b[LOW_W-1:0]};

    always @(posedge clk) begin
        if (go_q) begin
            sum_q   <= sum;
            turns_q <= turns;
        end
        stores_q   <= go_q && writes_q;
        store_to_q <= write_to_q;
    end

    wire [MEMORY_W-1:0] read_place;
    wire [MEMORY_W-1:0] store_place;

    generate
        if (N > 1) begin : several_ports
            assign read_place  = {port_q, read_from};
            assign store_place = {port_q, store_to_q};
        end else begin : one_port
            assign read_place  = read_from;
            assign store_place = store_to_q;
        end
    endgenerate

    always @(posedge clk) begin
        if (busy) begin
            read_q <= memory[read_place];
        end
        if (stores_q && !loses) begin
            memory[store_place] <= sum_q;
        end
    end

    // ---- Selection of the next step's b_q.
    always @(posedge clk) begin
        bare_q    <= bare;
        near_q    <= (b_from == B_NEAR);
        low_q     <= {b_from == B_FAR, b_from == B_NEAR};
        mid_q     <= {b_from == B_FAR, b_from == B_NEAR} | {2{b_from == B_THETA || b_from == B_FREE}};
        high_q    <= {b_from == B_FAR, b_from == B_NEAR}
                     | {2{b_from == B_THETA || b_from == B_FREE || b_from == B_HALF || b_from == B_PLACE
                          || b_from == B_AHEAD}};
        high_by_q <= {b_from == B_START || b_from == B_AHEAD, b_from == B_MOVED || b_from == B_PLACE,
                      b_from == B_HALF, b_from == B_REACH || b_from == B_FREE,
                      b_from == B_VOLTAGE || b_from == B_THETA};
        top_q     <= {b_from == B_FAR, b_from == B_NEAR} | {2{b_from == B_MOVED || b_from == B_PLACE}};
        top_by_q  <= {b_from == B_START || b_from == B_PLACE, b_from == B_VOLTAGE || b_from == B_MOVED};
    end

    // ---- The products. Their factors are selected a clock before; p = s31q16 counts is just in time.
    reg signed [DATA_W-1:0] factor_q;

    always @(posedge clk) begin
        case (step_q)
            5'd1:    factor_q <= v_i;
            5'd2:    factor_q <= u_i;
            5'd3:    factor_q <= withheld_i;
            5'd6:    factor_q <= next_q;
            5'd7:    factor_q <= current_i;
            5'd21:   factor_q <= $signed(sum_q[LONG_W-1:CUT]);
            5'd25:   factor_q <= told_q;
            default: ;
        endcase
    end

    assign request_o     = step_q == 5'd2 || step_q == 5'd3 || step_q == 5'd4 || step_q == 5'd7 || step_q == 5'd8
                           || step_q == 5'd22 || step_q == 5'd23 || step_q == 5'd26;
    assign factor_o      = factor_q;
    assign coefficient_o = (step_q == 5'd26) ? theta_q : $signed(gain);
    // ---- Flags within a turn, and those that the next turn starts from.
    always @(posedge clk) begin
        case (step_q)
            5'd1: begin
                saturated_q  <= saturated_i;
                blind_q      <= blind_i;
                chi_above_q  <= chi_above;
                chi_below_q  <= chi_below;
                tracked_q    <= tracked;
                presses_q    <= presses;
                full_q       <= full_before;
                void_q       <= void_before;
                clipped_q    <= clipped;
                excuses_q    <= excuses;
            end
            5'd10:   enable_q <= setting[0] && (!axis || found_i[port_q]);
            default: ;
        endcase
        if (go_q) begin
            case (adds_q)
                LIMIT:   huge_q <= 1'b0;
                CURRENT: far_q  <= over_q;
                FLUX: begin
                    if (contact_q) begin
                        presses_q <= back_sum;
                    end else if (!loses) begin
                        tracked_q <= 1'b1;
                    end
                end
                AHEAD: begin
                    far_q       <= far_q || sum_q[LONG_W-1] != sum_q[LONG_W-2];
                    chi_above_q <= out && !back_sum;
                    chi_below_q <= out && back_sum;
                end
                BOUND: begin
                    out_q   <= out;
                    above_q <= !back_sum;
                end
                PLACE:   sinks_p_q <= back_sum;
                CORRECT: begin
                    wild_q     <= over_q;
                    negative_q <= !below_q;
                    full_q     <= full;
                    void_q     <= back_sum;
                end
                CLIP:    negative_q <= wild_q ? negative_q : back_sum;
                STRANGE: begin
                    clipped_q    <= past;
                    excuses_q    <= (blind_q || begins_q || saturated_q) ? {EXCUSES_W{1'b1}}
                                  : !past                                ? {EXCUSES_W{1'b0}}
                                  : excuses_q - {{(EXCUSES_W - 1){1'b0}}, strobe_q && (|excuses_q)};
                end
                HELD: begin
                    huge_q    <= over_q;
                    sign_q    <= below_q;
                    strange_q <= past;
                end
                default: ;
            endcase
        end
    end

    // The offset, the sum of the step MEAN, keeps its value if it would leave its range.
    wire                     ranged = (&sum_q[LONG_W-1:AMP_SHIFT+DATA_W-1])
                                      || !(|sum_q[LONG_W-1:AMP_SHIFT+DATA_W-1]);
    assign loses = adds_q == FLUX && !contact_q && !ranged;

    // A sum as a voltage or √W, within its range.
    wire                     low     = huge_q ? sign_q : back_sum;
    wire                     beyond  = huge_q || (!(&sum_q[LONG_W-1:VOLT_SHIFT+DATA_W-1])
                                                  && (|sum_q[LONG_W-1:VOLT_SHIFT+DATA_W-1]));
    wire signed [DATA_W-1:0] limited = beyond ? $signed({low, {(DATA_W - 1){!low}}})
                                              : $signed(sum_q[VOLT_SHIFT +: DATA_W]);

    // A second adder: y_b less its decrease, from the sum of the step SWING, computed as -(-y_b + ...) if that is above
    // 0. Its carry shows whether the sum is 0 or more. Beside it LEARN's θ is compared with the largest one, as a
    // setting comes late in its clock. Results that drive a whole operand wait for a clock.
    reg shrinks_q, caps_q;  // which of the two, a clock before

    always @(posedge clk) begin
        shrinks_q <= (step_q == MEAN);
        caps_q    <= (step_q == CORRECT);
    end

    wire [DATA_W-1:0] few    = {{(DATA_W - LONG_W + FEW_SHIFT){back_sum}}, sum_q[LONG_W-1:FEW_SHIFT]};
    wire [DATA_W-1:0] less   = {{(DATA_W - LONG_W + LESS_SHIFT){back_sum}}, sum_q[LONG_W-1:LESS_SHIFT]};
    wire [DATA_W-1:0] side_b = counts_q ? less : axis ? {back_sum, few[DATA_W-1:1]} : few;
    wire [DATA_W-1:0] side;
    wire              carry;
    assign {carry, side} = {1'b0, brush_q ^ {DATA_W{turns_q}}} + {1'b0, side_b} + {{DATA_W{1'b0}}, back_sum};
    wire              full   = !back_sum && sum_q[LONG_W-2:THETA_CUT] >= {{(THETA_W - 1 - COEF_W){1'b0}}, learn_max};

    // The value that θ multiplies: the sum of the step SWING if the rotor doesn't travel, plus that of MEAN, plus y_b,
    // which by then has shrunk.
    reg                       adds_brush_q;
    wire                      damps = !travels_q && !begins_q && !blind_q && !far_q;
    wire                      takes = shrinks_q || (adds_brush_q && presses_q);
    wire signed [DATA_W-1:0]  tells = adds_brush_q  ? brush_q
                                      : shrinks_q ? $signed({sum_q[CUT +: DATA_W-1], 1'b0})
                                                      : $signed(sum_q[CUT +: DATA_W]);

    always @(posedge clk) begin
        adds_brush_q <= (step_q == CHI);
        if (go_q && (adds_q == SWING || (shrinks_q && !damps))) begin
            told_q <= {DATA_W{1'b0}};
        end else if (go_q && (shrinks_q || adds_q == FLUX || adds_brush_q)) begin
            told_q <= told_q + (tells ^ {DATA_W{takes}}) + {{(DATA_W - 1){1'b0}}, takes};
        end
    end

    // ---- Results.
    reg  chosen_q;  // c is in sum_q,
    reg  none_q;    // but the result is 0
    wire fault = faults_o[port_q];
    integer n;
    wire lost  = enable_q && (fault || far_q || (clipped_q && strange_q && excuses_q == {EXCUSES_W{1'b0}}));

    always @(posedge clk) begin
        chosen_q <= ends && !rst;
        none_q   <= !enable_q || lost || blind_q;
        if (ends) begin
            faults_o[port_q] <= lost;
        end
        for (n = 0; n < N; n = n + 1) begin
            if (resets[n]) begin
                faults_o[n] <= 1'b0;
            end
        end
    end

    wire rooms   = go_q && adds_q == CURRENT;
    wire offsets = go_q && adds_q == FLUX && !contact_q && ranged;
    wire fluxes  = go_q && adds_q == AHEAD;
    wire lags    = go_q && adds_q == FOLLOW;

    assign room_valid_o       = rooms;
    assign offset_valid_o     = offsets;
    assign flux_valid_o       = fluxes;
    assign lag_valid_o        = lags;
    assign correction_valid_o = chosen_q;
    assign port_o             = port_q;
    assign data_o             =
        (fluxes || lags) ? $signed(sum_q[LONG_W-1:CUT])
        : offsets        ? $signed(sum_q[AMP_SHIFT +: DATA_W])
        : ((rooms && (!contact_q || back_sum)) || (chosen_q && none_q)) ? {DATA_W{1'b0}} : limited;

    wh_port_state #(
        .N       (N),
        .RESETS  (N),
        .W       (DATA_W)
    ) next_state (
        .clk     (clk),
        .rst     (resets),
        .port_i  (port_q),
        .save_i  (chosen_q),
        .save_port_i (port_q),
        .value_i (data_o),
        .value_o (next_q)
    );

    // y_b and θ. Values that become 0 or their limit wait for the second adder's carry.
    wire follow  = go_q && shrinks_q && moves_mean && back_sum != presses_q;
    wire learned = go_q && caps_q;

    reg  brush_none_q;  // y_b has shrunk below 0
    reg  theta_all_q;   // θ was learned and is at its largest, which is read again:
    reg  theta_caps_q;  // now it is valid

    always @(posedge clk) begin
        brush_none_q <= follow && carry == turns_q && !rst;
        theta_all_q  <= learned && full && !rst;
        theta_caps_q <= theta_all_q && !rst;
    end

    wh_port_state #(
        .N       (N),
        .RESETS  (N),
        .W       (DATA_W)
    ) brush_state (
        .clk     (clk),
        .rst     (resets),
        .port_i  (port_q),
        .save_i  (brush_none_q || follow || (go_q && shrinks_q && begins_q)),
        .save_port_i (port_q),
        .value_i (brush_none_q ? {DATA_W{1'b0}} : begins_q ? setting
                  : side ^ {DATA_W{turns_q}}),
        .value_o (brush_q)
    );

    wh_port_state #(
        .N       (N),
        .RESETS  (N),
        .W       (COEF_W)
    ) theta_state (
        .clk     (clk),
        .rst     (resets),
        .port_i  (port_q),
        .save_i  (learned || theta_caps_q),
        .save_port_i (port_q),
        .value_i (theta_caps_q ? learn_max : back_sum ? {COEF_W{1'b0}} : sum_q[THETA_CUT +: COEF_W]),
        .value_o (theta_q)
    );

endmodule

`default_nettype wire
