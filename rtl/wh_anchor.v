// SPDX-License-Identifier: Apache-2.0
//
// wh_anchor: the port anchor, which holds what a port renders where the encoder sees the rotor.
//
//   χ  = L̂ i + k̂_T x - Σ (s T/2)(u + v)       flux of the port, in counts of k̂_T Δ; 0 if all is ideal
//   z  = χ + σ/4 after a full count, χ - σ/32 after a reversal (σ/16 with AXIS = 1); σ: direction of the last edge
//   p  = z beyond ±1/2, z/128 (AXIS = 1: z/256) within; the last edge's bound χ_b replaces one end of ±1/2
//   θ -= g_θ p sgn y'                          in contact, if z is beyond ±1/2; 0...learn_max, at first a quarter
//   θ -= θ/2                                   instead, with a turn outwards
//   c  = θ (y' + sgn y' y_b - d) - g_ρ p       the first term in contact only
//   d  = 2 (y - y')                            y = L̂ i; 0 while the rotor travels
//   |g_ρ p| <= c_0 + |e_id|/2                  c_0/2 out of contact
//
// An edge with the direction of the edge before is a full count. The rotor travels while its last two full counts had
// the same direction. Only then y' follows y: by 1/128 (AXIS = 1: 1/256) of the distance in one tick of follow_ticks,
// and by a quarter with each full count (not with AXIS = 1). y_b stands for the brushes, and decreases by half of what
// y' falls. A turn outwards is a rotor's first full count outwards after it travelled inwards. It halves θ, as a θ that
// has learned a brush's voltage would feed the swing of a lever; not while c is at its limit, nor with AXIS = 1.
//
// The bound χ_b: after an edge upwards z stays below the χ from before the last edge downwards, and the other way
// round. So a rotor that crosses back over an edge meets no more force on its way out, and no less on its way in, than
// it met there before. If χ_b is beyond the zone's other end, that end is the bound. It is in force until the next
// edge; with AXIS = 1, until z has been there once.
//
// c is a voltage in series with the port, limited to its format. It is added to e_id = s u after the wave core, which
// doesn't see it. Its share of the drive's limit, room_o, is no longer the wave's. A contact's first edge, in the
// period that reports the contact or one of the two before, sets χ to a quarter of a count plus the present content of
// the λ filter, which its u shows. In contact, the residue of voltage limit and rounding counts as flux. In free
// space, while the rotor is slow, c shows the sensor's offset, which is integrated within its format.
//
// fault_o, and c = 0: a g_ρ p that exceeds its limit by strange, while the waves are below theirs, shows that waves
// and encoder don't follow the same motor. So does a χ or an L̂ i in the outer half of its range.
// In a period whose current or v is at the end of its range, blind_i, nothing is learned, and the next c is 0; χ
// continues. While c has been at its limit since then, that is no fault.
//
// AXIS = 1: the port is one of a brushless motor's two axes. A count changes its flux by a fraction of a count, and its
// position comes from wh_rotor_flux. The zone is ± half of that fraction, and a contact begins with half of it.
//
// sim/wavehaptics/controller/anchor.py is the same with integers, and this module equals it bit for bit. One adder
// works through the steps below, one in a clock, with its state in a memory. The products come from a multiplier that
// other blocks share (wh_multiply_shared), eight in a period.
// Formats: long values s48q33, counts, V or A, and θ s48q37 V a count; factors are their upper bits, s31q16. reach,
// strange, learn_max and brush are 0 or more.
// Latency: 28 clocks from waves_i, plus the time that the multiplier makes it wait. c of one period is next_o a clock
// later, and correction_o from the next waves_i on, three clocks later. The next waves_i may come in the last of the
// 28. An earlier one is ignored, and sets overrun_o. reads_o is 0 in at least two clocks of every step, at the latest
// in the last two before the next waves_i.
// Reset: χ, θ, mean, offset, room and c are 0, slow, no contact, no fault; of any length, at any clock.

`default_nettype none
`include "wh_formats.vh"

module wh_anchor #(
    parameter integer AXIS = 0  // 1: an axis of a brushless motor; 0: place_i and cell_i mean nothing
) (
    input  wire                               clk,
    input  wire                               rst,

    // The tick, when its waves are there.
    input  wire                               waves_i,       // strobe, the words below are there
    input  wire signed [`WH_COUNT_W-1:0]      position_i,    // s32, counts
    input  wire signed [`WH_PLACE_W+`WH_SINE_Q-1:0] place_i, // s30q15 cells: the axis' flux by the encoder
    input  wire signed [`WH_SINE_Q+1:0]       cell_i,        // s17q15 cells: what the last count changed of it
    input  wire                               contact_i,
    input  wire                               blind_i,       // i_n or v_n is at its end
    // These hold until their products are asked for.
    input  wire signed [`WH_DATA_W-1:0]       current_i,     // s31q24 A: i_n
    input  wire signed [`WH_DATA_W-1:0]       u_i,           // s31q23 √W: u_n
    input  wire signed [`WH_DATA_W-1:0]       v_i,           // s31q23 √W: v_n
    input  wire signed [`WH_DATA_W-1:0]       withheld_i,    // s31q23 √W, of the core's step before
    // Of the core's step before, with waves_i.
    input  wire signed [`WH_DATA_W-1:0]       voltage_i,     // s31q23 V: e_id
    input  wire                               saturated_i,
    output wire                               busy_o,
    output wire                               reads_o,
    output reg                                overrun_o,     // until rst

    input  wire [`WH_ANCHOR_W-1:0]            words_i,       // settings; they hold while reads_o

    // The shared multiplier.
    output wire                               request_o,
    output wire signed [`WH_DATA_W-1:0]       factor_o,
    output wire signed [`WH_COEF_W-1:0]       coefficient_o,
    input  wire                               grant_i,
    input  wire                               done_i,        // strobe
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i,

    output reg  signed [`WH_DATA_W-1:0]       correction_o,  // s31q23 V: c
    output reg  signed [`WH_DATA_W-1:0]       next_o,        // s31q23 V: c of the step to come
    output reg  signed [`WH_DATA_W-1:0]       room_o,        // s31q23 √W, 0...: |c|/s in contact, else 0
    output reg  signed [`WH_DATA_W-1:0]       offset_o,      // s31q24 A: to be taken off the current
    output reg  signed [`WH_DATA_W-1:0]       flux_o,        // s31q16 cells: χ; x̂ = x + 1/2 - χ
    output reg  signed [`WH_DATA_W-1:0]       lag_o,         // s31q16 cells: ω̂ over 256 ticks
    output reg                                fault_o        // until rst
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer COEF_W    = `WH_COEF_W;
    localparam integer LONG_W    = `WH_LONG_W;
    localparam integer LONG_Q    = `WH_LONG_Q;
    localparam integer CUT       = `WH_LONG_GUARD;
    localparam integer PLACE_W   = `WH_PLACE_W;      // of the counts that x̂'s copy holds
    localparam integer SINE_Q    = `WH_SINE_Q;
    localparam integer MOVE_W    = `WH_MOVE_W;
    localparam integer REST_W    = `WH_REST_W;
    localparam integer FOLLOW_W  = `WH_FOLLOW_W;

    localparam integer NEAR_SHIFT = `WH_CURRENT_Q + `WH_CELLS_Q - LONG_Q;
    localparam integer FAR_SHIFT  = `WH_WAVE_Q + `WH_FLUX_Q - LONG_Q;
    localparam integer VOLT_SHIFT = LONG_Q - `WH_VOLTAGE_Q;
    localparam integer AMP_SHIFT  = LONG_Q - `WH_CURRENT_Q;
    localparam integer INNER_SHIFT = (AXIS == 1) ? 8 : 7;  // of z within the zone, of both means
    localparam integer COUNT_SHIFT = 2;  // of what y' takes with a full count
    localparam integer FADE_SHIFT  = 1;  // of what a turn outwards takes of θ
    localparam integer BEHIND_SHIFT = (AXIS == 1) ? 4 : 5;  // of the count by which z is behind χ after a turn
    localparam integer FEW_SHIFT   = INNER_SHIFT + 1 + CUT;  // by half of a step of y' shrinks y_b,
    localparam integer LESS_SHIFT  = COUNT_SHIFT + 1 + CUT;  // of one with a count
    localparam integer THETA_CUT   = `WH_LEARN_Q + LONG_Q - CUT - FAR_SHIFT - `WH_PULL_Q;  // of θ below a coefficient
    localparam integer THETA_W     = LONG_W - THETA_CUT;
    localparam [1:0]   FRESH_TICKS = 3;  // a contact is told in its edge's tick or in the next two
    localparam integer EXCUSES_W   = 5;  // c may be far beyond its limit for 2^EXCUSES_W - 1 steps of y'

    generate
        if (NEAR_SHIFT < 1 || NEAR_SHIFT != `WH_PULL_Q - CUT || THETA_CUT < VOLT_SHIFT + 1 || THETA_W < COEF_W
            || DATA_W + COEF_W - NEAR_SHIFT < LONG_W || VOLT_SHIFT < 2
            || (AXIS == 1 && LONG_Q < SINE_Q + 1)) begin : illegal_format
            wh_illegal_parameter_anchor_formats stop ();
        end
        if (AXIS != 0 && AXIS != 1) begin : illegal_axis
            wh_illegal_parameter_anchor_axis_must_be_0_or_1 stop ();
        end
    endgenerate

    // ---- Settings, the last one highest: as sim/wavehaptics/controller/anchor.py has their places.
    wire                     enable;       // 0: c = 0, and no fault
    wire signed [COEF_W-1:0] flux_gain;    // s27q22 cells a √W
    wire signed [COEF_W-1:0] owed_gain;    // s27q22 cells a √W
    wire signed [COEF_W-1:0] cells_gain;   // s27q12 cells an A
    wire signed [COEF_W-1:0] pull_gain;    // s27q20 V a cell: g_ρ
    wire signed [COEF_W-1:0] learn_gain;   // s27q33 V a count, per count: g_θ
    wire signed [COEF_W-1:0] learn_max;    // s27q20 V a count: largest θ
    wire signed [COEF_W-1:0] zero_gain;    // s27q22 A a V
    wire signed [COEF_W-1:0] room_gain;    // s27q22 √W a V: 1/s
    wire signed [DATA_W-1:0] reach;        // s31q23 V, 0...64 V: c_0
    wire signed [DATA_W-1:0] strange;      // s31q23 V
    wire signed [DATA_W-1:0] brush;        // s31q16 counts, 0...: y_b of a new contact
    wire      [FOLLOW_W-1:0] follow_ticks; // periods, 1...: from one step of y' to the next
    wire        [REST_W-1:0] slow_ticks;   // periods without two edges the same way: the rotor is slow

    assign {slow_ticks, follow_ticks, brush, strange, reach, room_gain, zero_gain, learn_max, learn_gain,
            pull_gain, cells_gain, owed_gain, flux_gain, enable} = words_i;

    // ---- What the tick brought.
    reg        [PLACE_W-1:0] position_q;
    reg signed [MOVE_W-1:0]  moved_q;
    reg                      started_q;   // there was a tick before
    reg                      start_q;     // moved_q is a new tick's: its rest is counted in this clock
    reg                      contact_q;
    reg                      begins_q;    // the contact
    reg                      back_q;      // direction of the last edge
    reg                      same_q;      // it was that of the edge before it
    reg                      counted_q;   // direction of the last edge of which that was so
    reg                      travels_q;   // and the one before it had the same direction
    reg                      sinks_q;     // the last edge lessened the flux
    reg                      presses_q;   // y' is below 0
    reg                      clipped_q;   // c was at its limit
    reg [1:0]                fresh_q;     // ticks for which that edge is one that a contact can begin with
    reg [REST_W-1:0]         quiet_q;     // ticks left until a rotor without two edges the same way is slow
    reg [FOLLOW_W-1:0]       phase_q;     // y' moves in the tick that finds 1 or 0
    reg                      strobe_q;    // it does in this tick,
    reg                      counts_q;    // or with a full count
    reg                      fading_q;    // this tick halves θ
    reg                      copies_q;    // x̂'s slow copy moves in the tick that finds 0
    reg [1:0]                chi_at_q;    // where in the memory χ is, 1 to 3,
    reg [1:0]                up_at_q;     // χ before the last edge that raised the flux,
    reg [1:0]                down_at_q;   // and that before the last one that lessened it
    reg                      knows_up_q;  // these are of this contact, the rotor moved by single counts since, and
    reg                      knows_down_q;  // they aren't beyond the end of the zone that they would replace
    reg                      up_all_q;    // they are beyond its other end
    reg                      down_all_q;
    reg                      chi_above_q; // χ of the tick before is above the zone,
    reg                      chi_below_q; // or below it

    wire                     accepts;     // waves_i
    wire signed [MOVE_W-1:0] moved    =
        started_q ? $signed(position_i[MOVE_W-1:0] - position_q[MOVE_W-1:0]) : {MOVE_W{1'b0}};
    wire                     moves    = |moved_q;
    wire                     back     = moved_q[MOVE_W-1];
    wire                     one      = back ? (&moved_q) : (moved_q[MOVE_W-1:1] == 0);
    wire                     same_way = moves && (back == back_q || !one);
    wire                     edged    = (fresh_q != 2'd0);
    wire                     slow     = (quiet_q == {REST_W{1'b0}});
    wire                     follows  = (phase_q[FOLLOW_W-1:1] == {(FOLLOW_W - 1){1'b0}});
    wire                     counts   = same_way && AXIS == 0;  // a count moves y'
    wire                     outward  = (back == presses_q);
    wire                     sinks;       // this tick's edge lessens the flux
    wire                     steps    = start_q && moves && !begins_q;

    always @(posedge clk) begin
        if (rst) begin
            started_q    <= 1'b0;
            start_q      <= 1'b0;
            contact_q    <= 1'b0;
            begins_q     <= 1'b0;
            back_q       <= 1'b0;
            same_q       <= 1'b1;
            counted_q    <= 1'b0;
            travels_q    <= 1'b0;
            sinks_q      <= 1'b0;
            fresh_q      <= 2'd0;
            quiet_q      <= {REST_W{1'b0}};
            phase_q      <= {FOLLOW_W{1'b0}};
            strobe_q     <= 1'b0;
            counts_q     <= 1'b0;
            fading_q     <= 1'b0;
            copies_q     <= 1'b0;
            chi_at_q     <= 2'd1;
            up_at_q      <= 2'd2;
            down_at_q    <= 2'd3;
            knows_up_q   <= 1'b0;
            knows_down_q <= 1'b0;
        end else begin
            start_q <= accepts;
            if (accepts) begin
                started_q <= 1'b1;
                copies_q  <= started_q && !copies_q && AXIS == 0;
                contact_q <= contact_i;
                begins_q  <= contact_i && !contact_q;
            end
            if (start_q) begin
                strobe_q  <= follows;
                counts_q  <= counts;
                fading_q  <= counts && outward && travels_q && back != counted_q && !begins_q && contact_q && !clipped_q;
                phase_q   <= follows ? follow_ticks : phase_q - 1'b1;
                back_q    <= moves ? back : back_q;
                sinks_q   <= moves ? sinks : sinks_q;
                same_q    <= begins_q || (moves ? same_way : same_q);
                fresh_q   <= moves ? FRESH_TICKS : edged ? fresh_q - 2'd1 : 2'd0;
                quiet_q   <= same_way ? slow_ticks : quiet_q - {{(REST_W - 1){1'b0}}, !slow};
                travels_q <= begins_q || (same_way ? back == counted_q : travels_q);
                counted_q <= (begins_q || same_way) ? (moves ? back : back_q) : counted_q;
            end
            if (start_q && begins_q) begin
                knows_up_q   <= 1'b0;
                knows_down_q <= 1'b0;
            end else if (steps) begin
                knows_up_q   <= one && (sinks ? knows_up_q : !chi_below_q);
                knows_down_q <= one && (sinks ? !chi_above_q : knows_down_q);
                if (one) begin
                    chi_at_q  <= sinks ? down_at_q : up_at_q;
                    up_at_q   <= sinks ? up_at_q : chi_at_q;
                    down_at_q <= sinks ? chi_at_q : down_at_q;
                end
            end
        end
        if (steps) begin
            up_all_q   <= sinks ? up_all_q : chi_above_q;
            down_all_q <= sinks ? chi_below_q : down_all_q;
        end
        if (accepts) begin
            position_q <= position_i[PLACE_W-1:0];
            moved_q    <= moved;
        end
    end

    // What the encoder tells of the flux: all of it, what the tick changed, what a contact begins with, half
    // of what a count changes, how far z is from χ, and whether χ or z, sum_q of the steps AHEAD and BOUND,
    // is beyond that half.
    wire signed [LONG_W-1:0] place;
    wire signed [LONG_W-1:0] moved_flux;
    wire signed [LONG_W-1:0] start_flux;
    wire signed [LONG_W-1:0] half_flux;
    wire signed [LONG_W-1:0] ahead_flux;
    wire                     out;

    generate
        if (AXIS == 1) begin : axis
            localparam integer FLUX_W = PLACE_W + SINE_Q;
            localparam integer HALF_W = LONG_W - LONG_Q + SINE_Q + 1;  // χ in parts of half a cell's last

            reg signed [FLUX_W-1:0] place_q;
            reg signed [FLUX_W-1:0] moved_flux_q;
            reg signed [SINE_Q+1:0] cell_q;

            always @(posedge clk) begin
                if (accepts) begin
                    place_q      <= place_i;
                    moved_flux_q <= started_q ? place_i - place_q : {FLUX_W{1'b0}};
                    cell_q       <= cell_i;
                end
            end

            wire unused_motor = &{1'b0, position_q[PLACE_W-1:MOVE_W]};

            wire signed [SINE_Q+1:0] size = cell_q[SINE_Q+1] ? -cell_q : cell_q;
            wire signed [SINE_Q+1:0] way  = !edged ? {SINE_Q+2{1'b0}} : back_q ? -cell_q : cell_q;
            wire signed [HALF_W-1:0] half = $signed({{(HALF_W - SINE_Q - 2){1'b0}}, size});
            wire signed [HALF_W-1:0] chi  = $signed(sum_q[LONG_W-1:LONG_Q-SINE_Q-1]);

            assign place      = $signed({place_q, {(LONG_Q - SINE_Q){1'b0}}});
            assign moved_flux = $signed({moved_flux_q, {(LONG_Q - SINE_Q){1'b0}}});
            assign start_flux = $signed({{(HALF_W - SINE_Q - 2){way[SINE_Q+1]}}, way,
                                         {(LONG_Q - SINE_Q - 1){1'b0}}});
            assign half_flux  = $signed({half, {(LONG_Q - SINE_Q - 1){1'b0}}});
            assign ahead_flux = same_q ? $signed({1'b0, half, {(LONG_Q - SINE_Q - 2){1'b0}}})
                                : $signed({{(LONG_W - LONG_Q + BEHIND_SHIFT - 1){1'b0}}, 1'b1,
                                           {(LONG_Q - BEHIND_SHIFT){1'b0}}});
            assign sinks      = moved_flux_q[FLUX_W-1];
            assign out        = back_sum ? (chi < -half) : (chi >= half);
        end else begin : motor
            wire unused_axis = &{1'b0, place_i, cell_i};

            assign place      = $signed({position_q, {LONG_Q{1'b0}}});
            assign moved_flux = $signed({{(LONG_W - LONG_Q - MOVE_W){moved_q[MOVE_W-1]}}, moved_q,
                                         {LONG_Q{1'b0}}});
            assign start_flux = $signed({{(LONG_W - LONG_Q + 1){edged && back_q}}, edged,
                                         {(LONG_Q - 2){1'b0}}});
            assign half_flux  = $signed({{(LONG_W - LONG_Q){1'b0}}, 1'b1, {(LONG_Q - 1){1'b0}}});
            assign ahead_flux = $signed({{(LONG_W - LONG_Q + 1){1'b0}}, same_q, {(BEHIND_SHIFT - 3){1'b0}}, !same_q,
                                         {(LONG_Q - BEHIND_SHIFT){1'b0}}});
            assign sinks      = back;
            assign out        = back_sum ? !(&sum_q[LONG_W-2:LONG_Q-1])
                                         : (|sum_q[LONG_W-2:LONG_Q-1]);
        end
    endgenerate

    // ---- The steps: what is added to what, and where the sum goes. A step's words are fetched in one
    // clock (step_q), where the sums with a product wait for it, and added in the next (adds_q). What
    // would have to be found out from step_q, and then go to every bit of a word, is known a clock before.
    // BEGIN, while there is nothing to do: the tick's words are there a clock later.
    localparam [4:0] BEGIN = 0, LIMIT = 1,
                     BASE = 2, EDGE = 3, ADD_V = 4, ADD_U = 5, ADD_OWED = 6,
                     ZERO = 7, CURRENT = 8, SWING = 9, MEAN = 10, FLUX = 11, CHI = 12,
                     AHEAD = 13, BOUND = 14, BACK = 15, BEYOND = 16,
                     PLACE = 17, X_HAT = 18, LAG = 19, FOLLOW = 20,
                     TAKE_THETA = 21, LEARN = 22, CORRECT = 23,
                     CLIP = 24, STRANGE = 25, HELD = 26, CHOOSE = 27;

    // The memory's words; χ and its two bounds take turns in the last three.
    localparam [3:0] M_FLUX = 0, M_THETA = 1, M_MEAN = 2, M_ZERO = 3, M_FOLLOWER = 4,
                     M_LIMIT = 9, M_CURRENT = 10, M_WANTED = 12,
                     M_LOSS = 12;  // what the offset loses, until c is there
    wire [3:0] m_chi   = {2'b11, chi_at_q};
    wire [3:0] m_bound = {2'b11, sinks_q ? up_at_q : down_at_q};

    reg [4:0] step_q;
    reg [4:0] ahead_q;    // the step after step_q
    reg       waits_q;    // step_q takes a product
    reg [4:0] adds_q;
    reg       go_q;       // adds_q is to be done
    reg       busy_q;
    reg       enable_q;   // the step's own
    reg       first_q;    // no step has been made: the memory's state reads as 0
    reg       tracked_q;  // the offset's word is in the memory, else it is 0

    wire ends    = go_q && adds_q == CHOOSE;
    assign accepts = waves_i && (!busy_q || ends);
    wire fetches = (step_q == BEGIN) ? accepts : (!waits_q || done_i);

    assign busy_o  = busy_q;
    assign reads_o = waves_i || start_q || (busy_q && step_q != BEGIN && step_q < STRANGE);

    // ---- The words of a step.
    localparam [3:0] B_NEAR = 0, B_FAR = 1,        // products
                     B_VOLTAGE = 2, B_THETA = 3,   // the latter a quarter of the largest
                     B_REACH = 4, B_FREE = 5, B_STRANGE = 6,
                     B_HALF = 7, B_MOVED = 8, B_PLACE = 9, B_START = 10, B_AHEAD = 11;

    // No word is read for a sum in the clock in which it is written, so that it doesn't matter what a
    // block RAM would give then: else Yosys adds logic that knows.
    (* no_rw_check *)
    reg signed [LONG_W-1:0] memory [0:15];
    reg signed [LONG_W-1:0] read_q;
    reg signed [LONG_W-1:0] sum_q;
    reg                     turns_q;                 // the second adder takes y_b off
    reg                     swings_q;
    reg signed [LONG_W-1:0] b_q;
    reg                     saturated_q;
    reg                     blind_q;                 // nothing is learned, and c is 0
    reg     [EXCUSES_W-1:0] excuses_q;               // steps of y' in which c may yet be far beyond its limit
    reg                     far_q;                   // χ or L̂ i is in the outer half of its range
    reg                     over_q;                  // the product in b_q was, and
    reg                     below_q;                 // below 0
    reg        [3:0]        read_from;
    reg        [3:0]        write_to_q;
    reg        [3:0]        write_to;
    reg                     writes_q, writes;
    reg        [3:0]        store_to_q;
    reg                     stores_q;                // sum_q is to be written
    reg                     sum_too_q, sum_too;      // a: the sum, or
    reg                     inner_q, inner;          // its 256th,
    reg                     quarter_q, half_q;       // a quarter or half of it, or 0
    reg                     memory_too_q, memory_too;  // b: what was read, or b_q
    reg                     fresh;                   // what is read is 0 in the first step
    reg        [3:0]        b_from;
    reg        [1:0]        low_q, mid_q, high_q, top_q;  // how b_q's chains begin, and
    reg        [4:0]        high_by_q;                    // which of their links chooses
    reg        [1:0]        top_by_q;
    reg                     near_q;                       // b_q is of a product, B_NEAR
    reg                     waits;
    reg                     bare_q, bare;            // b_q is 0
    reg                     minus_q, minus;
    reg                     to_zero_q;               // minus if the sum isn't
    reg                     out_q;                   // z is outside the zone,
    reg                     above_q;                 // above it
    reg signed [DATA_W-1:0] brush_q;                 // s31q16 counts, 0...: y_b
    reg signed [DATA_W-1:0] told_q;                  // s31q16 counts: y' + sgn y' y_b - d
    reg signed [COEF_W-1:0] theta_q;                 // s27q20 V a count: θ, 0...learn_max
    reg                     full_q;                  // it is the largest
    reg                     void_q;                  // it is below 0
    reg                     bound_q;                 // the last edge's bound is in force
    reg                     strange_q;               // and wants to be beyond it by strange
    reg                     negative_q;              // the correction that is wanted, g_ρ p,
    reg                     wild_q;                  // and it is more than a word
    reg                     huge_q;                  // so is θ's product, which is
    reg                     sign_q;                  // below 0
    wire                    loses;                   // sum_q is not to be written
    reg                     sinks_p_q;               // p is below 0

    wire back_sum = sum_q[LONG_W-1];
    wire moves_mean = (strobe_q || counts_q) && contact_q && travels_q && !blind_q && !far_q && !begins_q;

    wire grows  = (sinks_p_q != presses_q);
    wire learns = contact_q && out_q && !saturated_q && !blind_q && !(grows ? full_q || clipped_q : void_q);

    // Whether z is beyond the last edge's bound: of z less the bound, sum_q of the step BACK. What is known of the
    // bound stands since the tick's first clocks.
    reg  known_q;  // it is in force,
    reg  all_q;    // and beyond the zone's other end
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
            BEGIN: minus = voltage_i[DATA_W-1];
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
                minus    = contact_q && next_o[DATA_W-1];
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

    // Of the step after this one: where b_q is from, and whether for that a product has to come.
    always @* begin
        waits  = 1'b0;
        bare   = 1'b0;
        b_from = B_VOLTAGE;
        case (ahead_q)
            BEGIN:   ;
            LIMIT:   b_from = contact_i ? B_REACH : B_FREE;  // with waves_i
            EDGE:    b_from = begins_q ? B_START : B_MOVED;
            ADD_V: begin
                waits  = 1'b1;
                bare   = begins_q;
                b_from = B_FAR;
            end
            ADD_U: begin
                waits  = 1'b1;
                b_from = B_FAR;
            end
            ADD_OWED: begin
                waits  = 1'b1;
                bare   = !contact_q || begins_q;
                b_from = B_FAR;
            end
            ZERO: begin
                waits  = 1'b1;
                bare   = !contact_q && (!slow || blind_q);
                b_from = B_FAR;
            end
            CURRENT, CORRECT: begin
                waits  = 1'b1;
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
                waits  = 1'b1;
                bare   = !learns || fading_q;
                b_from = B_FAR;
            end
            HELD: begin
                waits  = 1'b1;
                bare   = !contact_q;
                b_from = B_NEAR;
            end
            STRANGE: b_from = B_STRANGE;
            default: bare = 1'b1;
        endcase
    end

    // What comes from outside is chosen by chains, of which each link is a LUT for two words: it gives the
    // second of them where the one before gives 1, the first where that gives 0, or what that gives. A chain's
    // first link gives a product, 1 or 0. The lowest places have products only, the middle ones nothing of the
    // encoder, the highest no setting.
    localparam integer LOW_W   = VOLT_SHIFT - 1;
    localparam integer COUNT_Q = (AXIS == 1) ? LONG_Q - SINE_Q - 2 : LONG_Q - BEHIND_SHIFT;
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
    wire [TOP_Q-1:0]  reach_b   = {{(TOP_Q - VOLT_SHIFT - DATA_W + 1){1'b0}}, reach[DATA_W-2:0],
                                   {VOLT_SHIFT{1'b0}}};
    wire [TOP_Q-1:0]  free_b    = {{(TOP_Q - VOLT_SHIFT - DATA_W + 2){1'b0}}, reach[DATA_W-2:1],
                                   {VOLT_SHIFT{1'b0}}};
    wire [TOP_Q-1:0]  strange_b = {{(TOP_Q - VOLT_SHIFT - DATA_W + 1){1'b0}}, strange[DATA_W-2:0],
                                   {VOLT_SHIFT{1'b0}}};
    wire [TOP_Q-1:0]  theta_b   = {{(TOP_Q - THETA_Q - COEF_W + 1){1'b0}}, learn_max[COEF_W-2:0],
                                   {THETA_Q{1'b0}}};

    wire [LOW_W-1:0]  b_low  = ({LOW_W{low_q[0]}} & near_b[LOW_W-1:0]) | ({LOW_W{low_q[1]}} & far_b[LOW_W-1:0]);

    wire [MID_W-1:0]  mid_0  = ({MID_W{mid_q[0]}} & (near_b[LOW_W +: MID_W] | {MID_W{mid_q[1]}}))
                             | ({MID_W{mid_q[1] && !mid_q[0]}} & far_b[LOW_W +: MID_W]);
    wire [MID_W-1:0]  mid_1  = high_by_q[0] ? (mid_0 & theta_b[LOW_W +: MID_W])
                                              | (~mid_0 & voltage_b[LOW_W +: MID_W]) : mid_0;
    wire [MID_W-1:0]  mid_2  = high_by_q[1] ? (mid_1 & free_b[LOW_W +: MID_W])
                                              | (~mid_1 & reach_b[LOW_W +: MID_W]) : mid_1;
    wire [MID_W-1:0]  b_mid  = high_by_q[2] ? ~mid_2 & strange_b[LOW_W +: MID_W] : mid_2;

    wire [HIGH_W-1:0] high_0 = ({HIGH_W{high_q[0]}} & (near_b[COUNT_Q +: HIGH_W] | {HIGH_W{high_q[1]}}))
                             | ({HIGH_W{high_q[1] && !high_q[0]}} & far_b[COUNT_Q +: HIGH_W]);
    wire [HIGH_W-1:0] high_1 = high_by_q[0] ? (high_0 & theta_b[COUNT_Q +: HIGH_W])
                                              | (~high_0 & voltage_b[COUNT_Q +: HIGH_W]) : high_0;
    wire [HIGH_W-1:0] high_2 = high_by_q[1] ? (high_1 & free_b[COUNT_Q +: HIGH_W])
                                              | (~high_1 & reach_b[COUNT_Q +: HIGH_W]) : high_1;
    wire [HIGH_W-1:0] high_3 = high_by_q[2] ? (high_2 & half_flux[COUNT_Q +: HIGH_W])
                                              | (~high_2 & strange_b[COUNT_Q +: HIGH_W]) : high_2;
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
        read_q       <= memory[read_from];
        adds_q       <= step_q;
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

    // ---- The adder. Its sum goes to sum_q alone, and from there on, so that sum and register are one
    // cell of an FPGA. What a step writes, the two after it can't read.
    wire                     takes_off = to_zero_q ? !back_sum : minus_q;
    wire signed [LONG_W-1:0] part = sum_q >>> INNER_SHIFT;
    wire signed [LONG_W-1:0] quarter = sum_q >>> COUNT_SHIFT;
    wire signed [LONG_W-1:0] halved  = sum_q >>> FADE_SHIFT;
    wire signed [LONG_W-1:0] a    = ({LONG_W{sum_too_q}} & sum_q) | ({LONG_W{inner_q}} & part)
                                    | ({LONG_W{quarter_q}} & quarter) | ({LONG_W{half_q}} & halved);
    wire signed [LONG_W-1:0] b    =
        (b_q | ({LONG_W{memory_too_q}} & read_q)) ^ {LONG_W{takes_off}};
    // The sign once more, for where it goes to every bit of a word again; of the step SWING its opposite.
    wire                     turns;
    wire signed [LONG_W-1:0] sum;
    assign {turns, sum} = {a[LONG_W-1], a} + {b[LONG_W-1] ^ swings_q, b} + {{LONG_W{1'b0}}, takes_off};

    wire unused = &{1'b0, product_i[NEAR_SHIFT-1:0], position_i[`WH_COUNT_W-1:PLACE_W], reach[DATA_W-1],
                    strange[DATA_W-1], learn_max[COEF_W-1], place[COUNT_Q-1:0], moved_flux[COUNT_Q-1:0],
                    start_flux[COUNT_Q-1:0], half_flux[LONG_W-1:TOP_Q], half_flux[COUNT_Q-1:0],
                    ahead_flux[LONG_W-1:TOP_Q], ahead_flux[COUNT_Q-1:0], voltage_b[LOW_W-1:0], reach_b[LOW_W-1:0],
                    free_b[LOW_W-1:0], strange_b[LOW_W-1:0], theta_b[LOW_W-1:0]};

    always @(posedge clk) begin
        if (go_q) begin
            sum_q   <= sum;
            turns_q <= turns;
        end
        stores_q   <= go_q && writes_q;
        store_to_q <= write_to_q;
        if (stores_q && !loses) begin
            memory[store_to_q] <= sum_q;
        end
    end

    // ---- The products, in the order in which they are asked for, in two runs and one more. A run's products
    // come one after the other, as its steps do, and so that none comes before its step: the first
    // step is as many clocks from where they are asked for as a product takes, or more. HELD is three steps
    // behind CORRECT, and its product as many clocks behind that one's. No step before the first run takes a
    // product, so none that was asked for before a reset is taken for another.
    localparam [3:0] G_V = 0, G_U = 1, G_OWED = 2, G_ZERO = 3, G_CURRENT = 4, G_LEARN = 5, G_PULL = 6,
                     G_HELD = 7, G_NONE = 8;

    reg        [3:0]        give_q;         // one of them
    reg        [2:0]        open_q;         // runs that may be asked for
    reg        [1:0]        pulls_q;        // G_PULL was granted a clock ago, or two
    reg signed [DATA_W-1:0] factor_q;       // of give_q
    reg signed [COEF_W-1:0] coefficient_q;  // of give_q
    assign request_o = (open_q[0] && give_q <= G_CURRENT) || (open_q[1] && give_q <= G_PULL)
                       || (open_q[2] && give_q <= G_HELD);

    // With a grant come the next product's operands. p = s31q16 counts, which is there just in time, is
    // G_LEARN's and G_PULL's factor.
    wire       granted = request_o && grant_i;
    wire       placed  = go_q && adds_q == PLACE;

    assign factor_o      = factor_q;
    assign coefficient_o = coefficient_q;

    // Chains choose these as well. Codes: which of the links chooses, and two bits of the first one.
    localparam [4:0] C_FLUX = 5'b000_01, C_OWED = 5'b000_10, C_ZERO = 5'b001_00, C_ROOM = 5'b001_11,
                     C_CELLS = 5'b010_00, C_LEARN = 5'b010_11, C_PULL = 5'b100_00, C_THETA = 5'b100_11;
    localparam [4:0] F_V = 5'b000_01, F_U = 5'b000_10, F_WITHHELD = 5'b001_00, F_C = 5'b001_11,
                     F_CURRENT = 5'b010_00, F_TOLD = 5'b010_11, F_P = 5'b100_00;

    (* fsm_encoding = "none" *)
    reg [4:0] gain_q;     // of the product after this one
    (* fsm_encoding = "none" *)
    reg [4:0] operand_q;  // that factor_q takes next

    wire loads = accepts || placed || (granted && give_q != G_CURRENT && give_q != G_LEARN);

    wire [COEF_W-1:0] gain_0 = ({COEF_W{gain_q[0]}} & (flux_gain | {COEF_W{gain_q[1]}}))
                             | ({COEF_W{gain_q[1] && !gain_q[0]}} & owed_gain);
    wire [COEF_W-1:0] gain_1 = gain_q[2] ? (gain_0 & room_gain)  | (~gain_0 & zero_gain)  : gain_0;
    wire [COEF_W-1:0] gain_2 = gain_q[3] ? (gain_1 & learn_gain) | (~gain_1 & cells_gain) : gain_1;
    wire [COEF_W-1:0] gain_3 = gain_q[4] ? (gain_2 & theta_q)    | (~gain_2 & pull_gain)  : gain_2;

    wire [DATA_W-1:0] operand_0 = ({DATA_W{operand_q[0]}} & (v_i | {DATA_W{operand_q[1]}}))
                                | ({DATA_W{operand_q[1] && !operand_q[0]}} & u_i);
    wire [DATA_W-1:0] operand_1 = operand_q[2] ? (operand_0 & next_o) | (~operand_0 & withheld_i) : operand_0;
    wire [DATA_W-1:0] operand_2 = operand_q[3] ? (operand_1 & told_q) | (~operand_1 & current_i) : operand_1;
    wire [DATA_W-1:0] operand_3 = operand_q[4] ? sum_q[LONG_W-1:CUT] : operand_2;

    always @(posedge clk) begin
        if (rst) begin
            gain_q    <= C_FLUX;
            operand_q <= F_V;
        end else begin
            if (accepts || granted) begin
                case (give_q)
                    G_V:       gain_q <= saturated_q ? C_OWED : C_FLUX;
                    G_U:       gain_q <= contact_q ? C_ROOM : C_ZERO;
                    G_OWED:    gain_q <= C_CELLS;
                    G_ZERO:    gain_q <= C_LEARN;
                    G_CURRENT: gain_q <= C_PULL;
                    G_LEARN:   gain_q <= C_THETA;
                    G_PULL:    gain_q <= C_FLUX;
                    // Where a contact begins and χ is set, u is owed.
                    default:   gain_q <= (accepts && contact_i && !contact_q) ? C_OWED : C_FLUX;
                endcase
            end
            if (loads) begin
                case (give_q)
                    G_V:       operand_q <= F_WITHHELD;
                    G_U:       operand_q <= F_C;
                    G_OWED:    operand_q <= F_CURRENT;
                    G_ZERO:    operand_q <= F_P;
                    G_LEARN:   operand_q <= F_TOLD;
                    G_PULL:    operand_q <= F_V;
                    default:   operand_q <= accepts ? F_U : F_V;
                endcase
            end
        end
        if (loads) begin
            factor_q <= operand_3;
        end
        if (granted || !open_q[0]) begin
            coefficient_q <= gain_3;
        end
    end

    // ---- What has a meaning within a step only.
    always @(posedge clk) begin
        if (accepts) begin
            saturated_q <= saturated_i;
            blind_q     <= blind_i;
            enable_q    <= enable;
        end
        if (placed) begin
            sinks_p_q <= back_sum;
        end
        if (go_q) begin
            case (adds_q)
                LIMIT:   huge_q <= 1'b0;
                CURRENT: far_q  <= over_q;
                AHEAD: begin
                    far_q       <= far_q || sum_q[LONG_W-1] != sum_q[LONG_W-2];
                    chi_above_q <= out && !back_sum;
                    chi_below_q <= out && back_sum;
                end
                BOUND: begin
                    out_q   <= out;
                    above_q <= !back_sum;
                end
                CORRECT: begin
                    wild_q     <= over_q;
                    negative_q <= !below_q;
                end
                CLIP:    negative_q <= wild_q ? negative_q : back_sum;
                HELD: begin
                    huge_q    <= over_q;
                    sign_q    <= below_q;
                    strange_q <= past;
                end
                default: ;
            endcase
        end
    end

    // The offset stays where it would leave its word; it is the sum of the step MEAN.
    wire                     ranged = (&sum_q[LONG_W-1:AMP_SHIFT+DATA_W-1])
                                      || !(|sum_q[LONG_W-1:AMP_SHIFT+DATA_W-1]);
    assign loses = adds_q == FLUX && !contact_q && !ranged;

    // A sum as a voltage or √W, within its word.
    wire                     low     = huge_q ? sign_q : back_sum;
    wire                     beyond  = huge_q || (!(&sum_q[LONG_W-1:VOLT_SHIFT+DATA_W-1])
                                                  && (|sum_q[LONG_W-1:VOLT_SHIFT+DATA_W-1]));
    wire signed [DATA_W-1:0] limited = beyond ? $signed({low, {(DATA_W - 1){!low}}})
                                              : $signed(sum_q[VOLT_SHIFT +: DATA_W]);

    // A second adder: of the sum of the step SWING y_b less what it shrinks by, and of LEARN's θ less its
    // largest. What y_b shrinks by is taken off as -(-y_b + ...) where that is above 0. Of its sums the carry
    // says whether they are 0 or more; what follows from that for a whole word waits for a clock.
    localparam integer SIDE_W = (THETA_W > DATA_W) ? THETA_W : DATA_W;

    // Which of them, known before as it goes to every bit.
    reg shrinks_q, caps_q;

    always @(posedge clk) begin
        shrinks_q <= (step_q == MEAN);
        caps_q    <= (step_q == CORRECT);
    end

    wire [SIDE_W-1:0] side_a = caps_q ? ~{{(SIDE_W - COEF_W){1'b0}}, learn_max}
                             : {{(SIDE_W - DATA_W){1'b0}}, brush_q} ^ {SIDE_W{turns_q}};
    wire [SIDE_W-1:0] side_b =
        shrinks_q ? (counts_q ? {{(SIDE_W - LONG_W + LESS_SHIFT){back_sum}}, sum_q[LONG_W-1:LESS_SHIFT]}
                              : {{(SIDE_W - LONG_W + FEW_SHIFT){back_sum}}, sum_q[LONG_W-1:FEW_SHIFT]})
                  : {{(SIDE_W - THETA_W + 1){back_sum}}, sum_q[LONG_W-2:THETA_CUT]};
    wire [SIDE_W-1:0] side;
    wire              carry;
    assign {carry, side} = {1'b0, side_a} + {1'b0, side_b} + {{SIDE_W{1'b0}}, caps_q || back_sum};
    wire              full   = carry && !back_sum;

    // What θ acts on is added up from the sum of the step SWING, of a rotor that doesn't travel, that of MEAN and
    // y_b, which by then has shrunk.
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

    // ---- Steps and results.
    reg  chosen_q;  // c is still in sum_q, and
    reg  none_q;    // it is not wanted
    wire lost = enable_q && (fault_o || far_q || (clipped_q && strange_q && excuses_q == {EXCUSES_W{1'b0}}));

    // Words that are 0 or limited: 0 is a flip-flop's own reset.
    wire rooms   = go_q && adds_q == CURRENT;
    wire follow  = go_q && shrinks_q && moves_mean && back_sum != presses_q;
    wire learned = go_q && caps_q;

    reg  brush_none_q;  // y_b has shrunk to less than nothing
    reg  theta_all_q;   // θ was learned and is the largest

    always @(posedge clk) begin
        brush_none_q <= follow && carry == turns_q;
        theta_all_q  <= learned && full;
    end

    always @(posedge clk) begin
        if (rst || (chosen_q && none_q)) begin
            next_o <= {DATA_W{1'b0}};
        end else if (chosen_q) begin
            next_o <= limited;
        end
        if (rst || (rooms && (!contact_q || back_sum))) begin
            room_o <= {DATA_W{1'b0}};
        end else if (rooms) begin
            room_o <= limited;
        end
        if (rst || brush_none_q) begin
            brush_q <= {DATA_W{1'b0}};
        end else if (follow || (shrinks_q && begins_q)) begin
            brush_q <= begins_q ? brush : $signed(side[DATA_W-1:0] ^ {DATA_W{turns_q}});
        end
        if (rst || (learned && back_sum)) begin
            theta_q <= {COEF_W{1'b0}};
        end else if (learned || theta_all_q) begin
            theta_q <= theta_all_q ? learn_max : $signed(sum_q[THETA_CUT +: COEF_W]);
        end
    end

    always @(posedge clk) begin
        if (rst) begin
            step_q       <= BEGIN;
            ahead_q      <= LIMIT;
            waits_q      <= 1'b0;
            bare_q       <= 1'b0;
            near_q       <= 1'b0;
            low_q        <= 2'b00;
            mid_q        <= 2'b00;
            high_q       <= 2'b00;
            high_by_q    <= 5'b00001;
            top_q        <= 2'b00;
            top_by_q     <= 2'b01;
            go_q         <= 1'b0;
            busy_q       <= 1'b0;
            first_q      <= 1'b1;
            tracked_q    <= 1'b0;
            give_q       <= G_NONE;
            open_q       <= 3'b000;
            pulls_q      <= 2'b00;
            overrun_o    <= 1'b0;
            clipped_q    <= 1'b0;
            excuses_q    <= {EXCUSES_W{1'b0}};
            fault_o      <= 1'b0;
            chosen_q     <= 1'b0;
            none_q       <= 1'b0;
            correction_o <= {DATA_W{1'b0}};
            offset_o     <= {DATA_W{1'b0}};
            flux_o       <= {DATA_W{1'b0}};
            lag_o        <= {DATA_W{1'b0}};
            bound_q      <= 1'b0;
            full_q       <= 1'b0;
            void_q       <= 1'b0;
            presses_q    <= 1'b0;
        end else begin
            if (waves_i && !accepts) begin
                overrun_o <= 1'b1;
            end
            go_q     <= fetches;
            chosen_q <= ends;
            none_q   <= ends && (!enable_q || lost || blind_q);
            pulls_q  <= {pulls_q[0], granted && give_q == G_PULL};
            if (fetches) begin
                step_q   <= ahead_q;
                ahead_q  <= (ahead_q == CHOOSE) ? BEGIN : ahead_q + 5'd1;
                waits_q  <= waits;
                bare_q   <= bare;
                near_q   <= (b_from == B_NEAR);
                low_q    <= {b_from == B_FAR, b_from == B_NEAR};
                mid_q    <= {b_from == B_FAR, b_from == B_NEAR}
                            | {2{b_from == B_THETA || b_from == B_FREE || b_from == B_HALF}};
                high_q   <= {b_from == B_FAR, b_from == B_NEAR}
                            | {2{b_from == B_THETA || b_from == B_FREE || b_from == B_HALF || b_from == B_PLACE
                                 || b_from == B_AHEAD}};
                high_by_q <= {b_from == B_START || b_from == B_AHEAD, b_from == B_MOVED || b_from == B_PLACE,
                              b_from == B_STRANGE || b_from == B_HALF, b_from == B_REACH || b_from == B_FREE,
                              b_from == B_VOLTAGE || b_from == B_THETA};
                top_q    <= {b_from == B_FAR, b_from == B_NEAR} | {2{b_from == B_MOVED || b_from == B_PLACE}};
                top_by_q <= {b_from == B_START || b_from == B_PLACE, b_from == B_VOLTAGE || b_from == B_MOVED};
            end
            if (fetches && step_q == CHOOSE) begin
                open_q <= 3'b000;
            end else begin
                open_q <= open_q | {pulls_q[1], fetches && step_q == X_HAT, accepts};
            end
            if (start_q && (begins_q || moves)) begin
                bound_q <= !begins_q;
            end
            if (accepts) begin
                busy_q <= 1'b1;
                give_q <= G_V;
            end else begin
                if (ends) begin
                    busy_q <= 1'b0;
                end
                give_q <= give_q + {3'd0, granted};
            end
            if (go_q) begin
                case (adds_q)
                    LIMIT:   correction_o <= next_o;
                    FLUX: begin
                        if (contact_q) begin
                            presses_q <= back_sum;
                        end else begin
                            if (ranged) begin
                                tracked_q <= 1'b1;
                                offset_o  <= $signed(sum_q[AMP_SHIFT +: DATA_W]);
                            end
                        end
                    end
                    AHEAD:   flux_o    <= $signed(sum_q[LONG_W-1:CUT]);
                    FOLLOW:  lag_o     <= $signed(sum_q[LONG_W-1:CUT]);
                    BACK:    bound_q   <= bound_q && (AXIS == 0 || beside || !contact_q);
                    CORRECT: begin
                        full_q  <= full;
                        void_q  <= back_sum;
                    end
                    STRANGE: begin
                        clipped_q    <= past;
                        excuses_q <= (blind_q || begins_q || saturated_q) ? {EXCUSES_W{1'b1}}
                                   : !past                                ? {EXCUSES_W{1'b0}}
                                   : excuses_q - {{(EXCUSES_W - 1){1'b0}}, strobe_q && (|excuses_q)};
                    end
                    CHOOSE: begin
                        fault_o <= lost;
                        first_q <= 1'b0;
                    end
                    default: ;
                endcase
            end
        end
    end

endmodule

`default_nettype wire
