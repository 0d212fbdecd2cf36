// SPDX-License-Identifier: Apache-2.0
//
// wh_anchor: the port anchor, which holds what a port feels like to where the encoder sees the rotor.
//
//   χ  = L̂ i + k̂_T x - Σ (s T/2)(u + v)       flux of the port, in counts of k̂_T Δ; 0 if all is ideal
//   z  = χ, or a quarter of a count more in the direction of an edge that is the second the same way
//   p  = z beyond ±1/2, z/256 within; or z - χ_b if the last edge's bound isn't kept yet
//   θ -= g_θ p sgn y'                          in contact, where z is beyond ±1/2; 0...learn_max, at first a quarter
//   c  = θ (y' + sgn y' y_b) - g_ρ p           the first term in contact only
//   |g_ρ p| <= c_0 + |e_id|/2                  c_0/2 out of contact
//
// y' is the mean of L̂ i while the rotor travels, two counts and more the same way, y_b stands for the brushes and shrinks by half of what y'
// falls. The bound χ_b: after an edge upwards z must come down to the χ from before the last edge downwards,
// and the other way round; so a rotor that crosses back over an edge meets no more force on its way out, and
// no less on its way in, than it met there before.
// c is a voltage in series with the port: it is added to e_id = s u behind the wave core, which does
// not see it, and what it takes of the drive's limit, room_o, is no longer the wave's. A contact's first
// edge, in the period that reports the contact or one of the two before, sets χ to a quarter of a count and
// what is in the λ filter then, which its u shows; in contact, what the voltage limit or rounding withholds
// from the waves counts as flux. In free space, when the rotor is slow, c shows the sensor's offset, which is
// summed up. A c that asks for more than its limit by strange, with the waves below theirs, shows that waves
// and encoder don't follow the same motor: fault_o, and c = 0. So does a χ in the outer half of its range.
// In a period whose current or v is at the end of its range, blind_i, nothing is learned, and the next c is
// 0; χ counts on. While c is at its limit since, that is no fault.
//
// AXIS = 1: the port is one of a brushless motor's two axes, whose flux a count changes by a fraction of a count
// (wh_rotor_flux): its place comes from there, the zone is half of that fraction, and so is what a contact
// begins with.
//
// sim/wavehaptics/controller/anchor.py says the same with integers, and this module equals it bit for bit.
// One adder works through the steps below, one in a clock, with its state in a memory; the products
// come from a multiplier that others use as well (wh_multiply_shared), eight in a period.
// Formats: long words s48q33, counts, V or A, and θ s48q37 V a count; factors are their upper bits, s31q16.
// Latency: 29 clocks from waves_i, and those that the multiplier makes it wait. c of one period is
// correction_o from the next waves_i on, two clocks later. The next waves_i may come in the last of the
// 29, the next start_i in the last four, or together with its waves_i. A waves_i before is ignored and
// a start_i before spoils what is under way; both show as overrun_o. reads_o is 0 in at least two clocks of
// every step, the last two before the next waves_i at the latest.
// Reset: χ, θ, mean, offset, room and c are 0, slow, no contact, no fault; of any length, at any clock.

`default_nettype none
`include "wh_formats.vh"

module wh_anchor #(
    parameter integer AXIS = 0  // 1: an axis of a brushless motor; 0: place_i and cell_i mean nothing
) (
    input  wire                               clk,
    input  wire                               rst,

    // The tick: its position and contact when the core starts, its waves when they are there.
    input  wire                               start_i,       // strobe
    input  wire signed [`WH_COUNT_W-1:0]      position_i,    // s32, counts
    input  wire signed [`WH_PLACE_W+`WH_SINE_Q-1:0] place_i, // s30q15 cells: the axis' flux by the encoder
    input  wire signed [`WH_SINE_Q+1:0]       cell_i,        // s17q15 cells: what the last count changed of it
    input  wire                               contact_i,
    input  wire                               waves_i,       // strobe, the words below are there
    input  wire signed [`WH_DATA_W-1:0]       current_i,     // s31q24 A: i_n
    input  wire signed [`WH_DATA_W-1:0]       u_i,           // s31q23 √W: u_n
    input  wire signed [`WH_DATA_W-1:0]       v_i,           // s31q23 √W: v_n
    // Of the core's step before, with waves_i; the first holds until its product is asked for.
    input  wire signed [`WH_DATA_W-1:0]       withheld_i,    // s31q23 √W
    input  wire signed [`WH_DATA_W-1:0]       voltage_i,     // s31q23 V: e_id
    input  wire                               saturated_i,
    input  wire                               blind_i,       // with waves_i: i_n or v_n is at its end
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
    output wire signed [`WH_DATA_W-1:0]       next_o,        // s31q23 V: c of the step to come
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
    localparam integer INNER_SHIFT = 8;  // of z within the zone, of both means
    localparam integer FEW_SHIFT   = INNER_SHIFT + 1 + CUT;  // by half of a step of y' shrinks y_b
    localparam integer THETA_CUT   = `WH_LEARN_Q + LONG_Q - CUT - FAR_SHIFT - `WH_PULL_Q;  // of θ below a coefficient
    localparam integer THETA_W     = LONG_W - THETA_CUT;
    localparam [1:0]   FRESH_TICKS = 3;  // a contact is told in its edge's tick or in the next two

    generate
        if (NEAR_SHIFT < 1 || NEAR_SHIFT != `WH_PULL_Q - CUT || THETA_CUT < 1 || THETA_W < COEF_W
            || DATA_W + COEF_W - NEAR_SHIFT < LONG_W || VOLT_SHIFT < 2
            || (AXIS == 1 && LONG_Q < SINE_Q + 1)) begin : illegal_format
            wh_illegal_parameter_anchor_formats stop ();
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
    reg [1:0]                fresh_q;     // ticks for which that edge is one that a contact can begin with
    reg [REST_W-1:0]         quiet_q;     // ticks left until a rotor without two edges the same way is slow
    reg [FOLLOW_W-1:0]       phase_q;     // ticks left until y' moves
    reg                      follows_q;   // it does in this tick
    reg [1:0]                chi_at_q;    // where in the memory χ is, 1 to 3,
    reg [1:0]                up_at_q;     // χ before the last edge that raised the flux,
    reg [1:0]                down_at_q;   // and that before the last one that lessened it
    reg                      knows_up_q;  // these are of this contact, and the rotor moved by single counts since
    reg                      knows_down_q;

    wire signed [MOVE_W-1:0] moved    =
        started_q ? $signed(position_i[MOVE_W-1:0] - position_q[MOVE_W-1:0]) : {MOVE_W{1'b0}};
    wire                     moves    = |moved_q;
    wire                     back     = moved_q[MOVE_W-1];
    wire                     one      = back ? (&moved_q) : (moved_q[MOVE_W-1:1] == 0);
    wire                     same_way = moves && (back == back_q || !one);
    wire                     edged    = (fresh_q != 2'd0);
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
            follows_q    <= 1'b0;
            chi_at_q     <= 2'd1;
            up_at_q      <= 2'd2;
            down_at_q    <= 2'd3;
            knows_up_q   <= 1'b0;
            knows_down_q <= 1'b0;
        end else begin
            start_q <= start_i;
            if (start_i) begin
                started_q <= 1'b1;
                contact_q <= contact_i;
                begins_q  <= contact_i && !contact_q;
            end
            if (start_q) begin
                follows_q <= (phase_q == {FOLLOW_W{1'b0}});
                phase_q   <= (phase_q != {FOLLOW_W{1'b0}})      ? phase_q - 1'b1
                           : (follow_ticks != {FOLLOW_W{1'b0}}) ? follow_ticks - 1'b1 : {FOLLOW_W{1'b0}};
                back_q    <= moves ? back : back_q;
                sinks_q   <= moves ? sinks : sinks_q;
                same_q    <= begins_q || (moves ? same_way : same_q);
                fresh_q   <= moves ? FRESH_TICKS : edged ? fresh_q - 2'd1 : 2'd0;
                quiet_q   <= same_way ? slow_ticks : (|quiet_q) ? quiet_q - 1'b1 : quiet_q;
                travels_q <= begins_q || (same_way ? back == counted_q : travels_q);
                counted_q <= (begins_q || same_way) ? (moves ? back : back_q) : counted_q;
            end
            if (start_q && begins_q) begin
                knows_up_q   <= 1'b0;
                knows_down_q <= 1'b0;
            end else if (steps) begin
                knows_up_q   <= one && (!sinks || knows_up_q);
                knows_down_q <= one && (sinks || knows_down_q);
                if (one) begin
                    chi_at_q  <= sinks ? down_at_q : up_at_q;
                    up_at_q   <= sinks ? up_at_q : chi_at_q;
                    down_at_q <= sinks ? chi_at_q : down_at_q;
                end
            end
        end
        if (start_i) begin
            position_q <= position_i[PLACE_W-1:0];
            moved_q    <= moved;
        end
    end

    // What the encoder tells of the flux: all of it, what the tick changed, what a contact begins with, half
    // and a quarter of what a count changes, and whether z, sum_q of the step BOUND, is beyond that half.
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
                if (start_i) begin
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
            assign ahead_flux = $signed({{1{1'b0}}, half, {(LONG_Q - SINE_Q - 2){1'b0}}});
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
            assign ahead_flux = $signed({{(LONG_W - LONG_Q + 1){1'b0}}, 1'b1, {(LONG_Q - 2){1'b0}}});
            assign sinks      = back;
            assign out        = back_sum ? !(&sum_q[LONG_W-2:LONG_Q-1])
                                         : (|sum_q[LONG_W-2:LONG_Q-1]);
        end
    endgenerate

    // The tick's own, also in the clock of its start.
    wire touches = start_i ? contact_i : contact_q;

    wire slow = (quiet_q == {REST_W{1'b0}});

    // ---- The steps: what is added to what, and where the sum goes. A step's words are fetched in one
    // clock (step_q), where the sums with a product wait for it, and added in the next (adds_q). What
    // would have to be found out from step_q, and then go to every bit of a word, is known a clock before.
    // BEGIN, while there is nothing to do: the tick's words are there a clock later.
    localparam [4:0] BEGIN = 0, REACH = 1, LIMIT = 2,
                     TAKE_ZERO = 3, ZERO = 4, CURRENT = 5, SWING = 6, MEAN = 7,
                     BASE = 8, ADD_OWED = 9, ADD_U = 10, ADD_V = 11, EDGE = 12, FLUX = 13,
                     AHEAD = 14, BOUND = 15, BACK = 16, BEYOND = 17,
                     PLACE = 18, X_HAT = 19, LAG = 20, FOLLOW = 21,
                     TAKE_THETA = 22, LEARN = 23, HELD = 24, CORRECT = 25,
                     CLIP = 26, STRANGE = 27, CHOOSE = 28;

    // The memory's words; χ and its two bounds take turns in the last three.
    localparam [3:0] M_FLUX = 0, M_THETA = 1, M_MEAN = 2, M_ZERO = 3, M_FOLLOWER = 4,
                     M_LIMIT = 9, M_CURRENT = 10, M_WANTED = 12;
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
    wire accepts = waves_i && (!busy_q || ends);
    wire fetches = (step_q == BEGIN) ? accepts : (!waits_q || done_i);

    assign busy_o  = busy_q;
    assign reads_o = waves_i || start_q || (busy_q && step_q != BEGIN && step_q < STRANGE);

    // ---- The words of a step.
    localparam [3:0] B_NEAR = 0, B_FAR = 1,  // products
                     B_REACH = 2, B_STRANGE = 3, B_VOLTAGE = 4, B_EDGE = 5, B_HALF = 6, B_PLACE = 7, B_AHEAD = 8,
                     B_THETA = 9;  // a quarter of the largest

    // No word is read for a sum in the clock in which it is written, so that it doesn't matter what a
    // block RAM would give then: else Yosys adds logic that knows.
    (* no_rw_check *)
    reg signed [LONG_W-1:0] memory [0:15];
    reg signed [LONG_W-1:0] read_q;
    reg signed [LONG_W-1:0] sum_q;
    reg signed [LONG_W-1:0] b_q;
    reg signed [DATA_W-1:0] voltage_q;
    reg                     saturated_q;
    reg                     blind_q;                 // nothing is learned, and c is 0
    reg                     overloaded_q;            // it was so, and c has been at its limit since
    reg                     far_q;                   // χ is in the outer half of its range
    reg        [3:0]        read_from;
    reg        [3:0]        write_to_q;
    reg        [3:0]        write_to;
    reg                     writes_q, writes;
    reg        [3:0]        store_to_q;
    reg                     stores_q;                // sum_q is to be written
    reg                     sum_too_q, sum_too;      // a: the sum, or
    reg                     inner_q, inner;          // its 256th, or 0
    reg                     memory_too_q, memory_too;  // b: what was read, or b_q
    reg                     fresh;                   // what is read is 0 in the first step
    reg        [3:0]        b_from_q, b_from;
    reg                     waits;
    reg                     bare_q, bare;            // b_q is 0
    reg                     minus_q, minus;
    reg                     to_zero_q;               // minus if the sum isn't
    reg                     out_q;                   // z is outside the zone,
    reg                     above_q;                 // above it
    reg signed [DATA_W-1:0] brush_q;                 // s31q16 counts, 0...: y_b
    reg signed [DATA_W-1:0] told_q;                  // s31q16 counts: y' + sgn y' y_b
    reg                     presses_q;               // y' is below 0
    reg signed [COEF_W-1:0] theta_q;                 // s27q20 V a count: θ, 0...learn_max
    reg signed [DATA_W-1:0] held_q;                  // s31q23 V: θ (y' + sgn y' y_b)
    reg                     full_q;                  // it is the largest
    reg                     void_q;                  // it is below 0
    reg                     bound_q;                 // the last edge's bound is still to be reached
    reg                     touched_q;               // the step's contact
    reg                     clipped_q;
    reg                     negative_q;              // the correction that is wanted

    wire e_back = voltage_q[DATA_W-1];
    wire back_sum = sum_q[LONG_W-1];
    wire moves_mean = follows_q && contact_q && travels_q && !blind_q && !begins_q;

    wire grows  = (factor_q[DATA_W-1] != presses_q);
    wire learns = contact_q && out_q && !clipped_q && !saturated_q && !blind_q && !(grows ? full_q : void_q);

    // Whether the last edge's bound isn't kept yet: of z less the bound, sum_q of the step BACK.
    wire known  = sinks_q ? knows_up_q : knows_down_q;
    wire beside = bound_q && contact_q && known && (back_sum == sinks_q) 
                  && !(out_q && above_q == sinks_q);
    wire past   = (back_sum == negative_q);

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
            REACH: sum_too = 1'b1;
            LIMIT: begin
                sum_too  = 1'b1;
                minus    = e_back;
                writes   = 1'b1;
                write_to = M_LIMIT;
            end
            TAKE_ZERO: begin
                memory_too = !contact_q && tracked_q;
                read_from  = M_ZERO;
            end
            ZERO: begin
                sum_too  = 1'b1;
                minus    = !contact_q || next_q[DATA_W-1];
                writes   = !contact_q;
                write_to = M_ZERO;
            end
            CURRENT: begin
                writes   = 1'b1;
                write_to = M_CURRENT;
            end
            SWING: begin
                sum_too    = 1'b1;
                memory_too = 1'b1;
                fresh      = 1'b1;
                read_from  = M_MEAN;
                minus      = 1'b1;
            end
            MEAN: begin
                inner      = moves_mean;
                memory_too = !begins_q;
                minus      = begins_q;  // begins with what presses against the rotor's way
                fresh      = 1'b1;
                read_from  = M_MEAN;
                writes     = 1'b1;
                write_to   = M_MEAN;
            end
            BASE: begin
                memory_too = !begins_q;
                fresh      = 1'b1;
                read_from  = M_FLUX;
            end
            ADD_OWED: begin
                sum_too = 1'b1;
                minus   = !begins_q;
            end
            ADD_U: begin
                sum_too = 1'b1;
                minus   = 1'b1;
            end
            ADD_V: begin
                sum_too = 1'b1;
                minus   = 1'b1;
            end
            EDGE: begin
                sum_too = 1'b1;
                writes  = 1'b1;
            end
            FLUX: begin
                sum_too    = 1'b1;
                memory_too = 1'b1;
                read_from  = M_CURRENT;
                writes     = 1'b1;
                write_to   = m_chi;
            end
            AHEAD: begin
                sum_too = 1'b1;
                minus   = sinks_q;
            end
            BOUND: begin
                sum_too    = 1'b1;
                memory_too = known;
                read_from  = m_bound;
                minus      = 1'b1;
            end
            BACK: begin
                sum_too    = 1'b1;
                memory_too = known;
                read_from  = m_bound;
            end
            BEYOND: begin
                sum_too    = beside || out_q;
                inner      = !beside && !out_q;
                memory_too = beside;
                read_from  = m_bound;
                minus      = beside || above_q;
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
                writes     = 1'b1;
                write_to   = M_FOLLOWER;
            end
            TAKE_THETA: begin
                memory_too = 1'b1;
                fresh      = 1'b1;
                read_from  = M_THETA;
            end
            LEARN: begin
                sum_too  = 1'b1;
                minus    = !presses_q;
                writes   = 1'b1;
                write_to = M_THETA;
            end
            CORRECT: begin  // held_q is HELD's sum
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
                memory_too = 1'b1;
                read_from  = past ? M_LIMIT : M_WANTED;
                minus      = past && negative_q;
            end
            default: ;
        endcase
    end

    // Of the step after this one: where b_q is from, and whether for that a product has to come.
    always @* begin
        waits  = 1'b0;
        bare   = 1'b0;
        b_from = B_REACH;
        case (ahead_q)
            BEGIN:   ;
            REACH:   bare = !touches;
            LIMIT:   b_from = B_VOLTAGE;
            ZERO: begin
                waits  = 1'b1;
                bare   = !contact_q && (!slow || blind_q);
                b_from = B_FAR;
            end
            CURRENT, CORRECT: begin
                waits  = 1'b1;
                b_from = B_NEAR;
            end
            ADD_OWED: begin
                waits  = 1'b1;
                bare   = !contact_q;
                b_from = B_FAR;
            end
            ADD_U: begin
                waits  = 1'b1;
                bare   = begins_q;
                b_from = B_FAR;
            end
            ADD_V: begin
                waits  = 1'b1;
                bare   = begins_q;
                b_from = B_FAR;
            end
            EDGE:    b_from = B_EDGE;
            MEAN: begin
                bare   = !begins_q;
                b_from = B_EDGE;
            end
            TAKE_THETA: begin
                bare   = !first_q;
                b_from = B_THETA;
            end
            AHEAD: begin
                bare   = !contact_q || !same_q;
                b_from = B_AHEAD;
            end
            BEYOND:  b_from = B_HALF;
            PLACE:   b_from = B_PLACE;
            LEARN: begin
                waits  = 1'b1;
                bare   = !learns;
                b_from = B_FAR;
            end
            HELD: begin
                waits  = 1'b1;
                bare   = !touched_q;
                b_from = B_NEAR;
            end
            STRANGE: b_from = B_STRANGE;
            default: bare = 1'b1;
        endcase
    end

    // What comes from outside. c_0 comes as two halves: out of contact the second stays away.
    wire signed [DATA_W:0] setting = (b_from_q == B_STRANGE)
        ? $signed({strange, 1'b0}) : $signed({reach[DATA_W-1], reach[DATA_W-1:1], reach[0] && touches});

    always @(posedge clk) begin
        if (bare_q || (step_q == BEYOND && (beside || !out_q))) begin
            b_q <= {LONG_W{1'b0}};
        end else begin
            case (b_from_q)
                B_NEAR:    b_q <= $signed(product_i[NEAR_SHIFT +: LONG_W]);
                B_FAR:     b_q <= $signed({{(LONG_W - DATA_W - COEF_W + FAR_SHIFT)
                                                {product_i[DATA_W+COEF_W-1]}},
                                           product_i[DATA_W+COEF_W-1:FAR_SHIFT]});
                B_VOLTAGE: b_q <= $signed({{(LONG_W - DATA_W - VOLT_SHIFT + 1){e_back}}, voltage_q,
                                           {(VOLT_SHIFT - 1){1'b0}}});
                B_EDGE:    b_q <= begins_q ? start_flux : moved_flux;
                B_AHEAD:   b_q <= ahead_flux;
                B_THETA:   b_q <= $signed({{(LONG_W - COEF_W - THETA_CUT + 2){learn_max[COEF_W-1]}}, learn_max,
                                           {(THETA_CUT - 2){1'b0}}});
                B_HALF:    b_q <= half_flux;
                B_PLACE:   b_q <= place;
                default:   b_q <= $signed({{(LONG_W - DATA_W - VOLT_SHIFT){setting[DATA_W]}}, setting,
                                           {(VOLT_SHIFT - 1){1'b0}}});
            endcase
        end
        read_q       <= memory[read_from];
        adds_q       <= step_q;
        sum_too_q    <= sum_too;
        inner_q      <= inner;
        memory_too_q <= memory_too && !(fresh && first_q);
        minus_q      <= minus;
        to_zero_q    <= (step_q == CLIP);
        writes_q     <= writes;
        write_to_q   <= write_to;
    end

    // ---- The adder. Its sum goes to sum_q alone, and from there on, so that sum and register are one
    // cell of an FPGA. What a step writes, the two after it can't read.
    wire                     takes_off = to_zero_q ? !back_sum : minus_q;
    wire signed [LONG_W-1:0] part = sum_q >>> INNER_SHIFT;
    wire signed [LONG_W-1:0] a    = ({LONG_W{sum_too_q}} & sum_q) | ({LONG_W{inner_q}} & part);
    wire signed [LONG_W-1:0] b    =
        (b_q | ({LONG_W{memory_too_q}} & read_q)) ^ {LONG_W{takes_off}};
    wire signed [LONG_W-1:0] sum  = a + b + $signed({{(LONG_W - 1){1'b0}}, takes_off});

    wire unused = &{1'b0, product_i[NEAR_SHIFT-1:0], position_i[`WH_COUNT_W-1:PLACE_W],
                     size[FEW_SHIFT-1:0]};

    always @(posedge clk) begin
        if (go_q) begin
            sum_q <= sum;
        end
        stores_q   <= go_q && writes_q;
        store_to_q <= write_to_q;
        if (stores_q) begin
            memory[store_to_q] <= sum_q;
        end
    end

    // ---- The products, in the order in which they are asked for, in three runs. A run's products
    // come one after the other, as its steps do, and so that none comes before its step: the first
    // step is as many clocks from where they are asked for as a product takes, or more. No step before
    // the first run takes a product, so none that was asked for before a reset is taken for another.
    localparam [3:0] G_ZERO = 0, G_CURRENT = 1, G_OWED = 2, G_U = 3, G_V = 4, G_HELD = 6, G_PULL = 7;  // 8: none

    reg        [3:0]        give_q;         // one of them
    reg        [2:0]        open_q;         // runs that may be asked for
    reg signed [DATA_W-1:0] factor_q;       // of give_q, but for G_ZERO's and G_HELD's
    reg signed [COEF_W-1:0] coefficient_q;  // of give_q
    assign request_o = (open_q[0] && give_q <= G_CURRENT) || (open_q[1] && give_q <= G_V)
                       || (open_q[2] && give_q <= G_PULL);

    // With a grant come the next product's operands; G_ZERO's gain waits, its factor is there too late
    // for that. p = s31q16 cells, which is there just in time, is G_LEARN's and G_PULL's factor.
    wire       granted = request_o && grant_i;
    wire       placed  = go_q && adds_q == PLACE;
    reg  [2:0] after_q;  // gain of the product after this one
    wire [2:0] gain    = open_q[0] ? after_q : {2'b00, touches};

    assign factor_o      = (give_q == G_ZERO) ? next_o : (give_q == G_HELD) ? told_q : factor_q;
    assign coefficient_o = coefficient_q;

    always @(posedge clk) begin
        if (!open_q[0]) begin
            after_q <= 3'd2;
        end else if (granted) begin
            case (give_q)
                G_ZERO:    after_q <= (saturated_q || begins_q) ? 3'd3 : 3'd4;
                G_CURRENT: after_q <= 3'd4;
                G_OWED:    after_q <= 3'd4;
                G_U:       after_q <= 3'd5;
                G_V:       after_q <= 3'd6;
                default:   after_q <= 3'd7;  // of the last run G_PULL's comes last
            endcase
        end
        if (placed || (granted && !give_q[2])) begin
            factor_q <= placed                ? $signed(sum_q[LONG_W-1:CUT])
                      : (give_q == G_ZERO)    ? current_i
                      : (give_q == G_CURRENT && !begins_q) ? withheld_i
                      : (give_q != G_U)       ? u_i : v_i;  // where χ is set, u is owed
        end
        if (granted || !open_q[0]) begin
            case (gain)
                3'd0:    coefficient_q <= zero_gain;
                3'd1:    coefficient_q <= room_gain;
                3'd2:    coefficient_q <= cells_gain;
                3'd3:    coefficient_q <= owed_gain;
                3'd4:    coefficient_q <= flux_gain;
                3'd5:    coefficient_q <= learn_gain;
                3'd6:    coefficient_q <= theta_q;
                default: coefficient_q <= pull_gain;
            endcase
        end
    end

    // ---- What has a meaning within a step only.
    always @(posedge clk) begin
        if (accepts) begin
            voltage_q   <= voltage_i;
            saturated_q <= saturated_i;
            blind_q     <= blind_i;
            enable_q    <= enable;
        end
        if (go_q) begin
            case (adds_q)
                BASE: begin
                    touched_q <= contact_q;
                    told_q    <= $signed(sum_q[LONG_W-1:CUT]) + (back_sum ? -brush_q : brush_q);
                end
                AHEAD:   far_q <= (sum_q[LONG_W-1] != sum_q[LONG_W-2]);
                BOUND: begin
                    out_q   <= out;
                    above_q <= !back_sum;
                end
                CLIP:    negative_q <= back_sum;
                default: ;
            endcase
        end
    end

    // θ as a coefficient, sum_q of the step HELD, and y_b less what it shrinks by, of the step MEAN.
    wire                     full = ($signed(sum_q[LONG_W-1:THETA_CUT])
                                     >= $signed({{(THETA_W - COEF_W){learn_max[COEF_W-1]}}, learn_max}));
    wire                     none = full ? learn_max[COEF_W-1] : back_sum;
    wire [LONG_W-1:0]        size = sum_q ^ {LONG_W{back_sum}};
    wire signed [DATA_W:0]   less = $signed({brush_q[DATA_W-1], brush_q})
                                  - $signed({{(DATA_W + 1 - LONG_W + FEW_SHIFT){1'b0}}, size[LONG_W-1:FEW_SHIFT]});

    // ---- Steps and results.
    reg  signed [DATA_W-1:0] next_q;
    reg                      chosen_q;  // c is still in sum_q, and
    reg                      none_q;    // it is not wanted
    wire                     strange_c = clipped_q && past && !saturated_q && !overloaded_q;
    wire                     lost = enable_q && (fault_o || far_q || strange_c);

    wire signed [DATA_W-1:0] chosen = $signed(sum_q[VOLT_SHIFT +: DATA_W]) + held_q;

    assign next_o = none_q ? {DATA_W{1'b0}} : chosen_q ? chosen : next_q;

    always @(posedge clk) begin
        if (rst) begin
            step_q       <= BEGIN;
            ahead_q      <= REACH;
            waits_q      <= 1'b0;
            bare_q       <= 1'b0;
            b_from_q     <= B_REACH;
            go_q         <= 1'b0;
            busy_q       <= 1'b0;
            first_q      <= 1'b1;
            tracked_q    <= 1'b0;
            give_q       <= G_ZERO;
            open_q       <= 3'b000;
            overrun_o    <= 1'b0;
            clipped_q    <= 1'b0;
            overloaded_q <= 1'b0;
            fault_o      <= 1'b0;
            next_q       <= {DATA_W{1'b0}};
            chosen_q     <= 1'b0;
            none_q       <= 1'b0;
            correction_o <= {DATA_W{1'b0}};
            room_o       <= {DATA_W{1'b0}};
            offset_o     <= {DATA_W{1'b0}};
            flux_o       <= {DATA_W{1'b0}};
            lag_o        <= {DATA_W{1'b0}};
            brush_q      <= {DATA_W{1'b0}};
            bound_q      <= 1'b0;
            theta_q      <= {COEF_W{1'b0}};
            held_q       <= {DATA_W{1'b0}};
            full_q       <= 1'b0;
            void_q       <= 1'b0;
            presses_q    <= 1'b0;
        end else begin
            if ((waves_i && !accepts) || (start_i && step_q != BEGIN && step_q <= CORRECT)) begin
                overrun_o <= 1'b1;
            end
            go_q     <= fetches;
            chosen_q <= ends;
            none_q   <= ends && (!enable_q || lost || blind_q);
            next_q   <= next_o;
            if (fetches) begin
                step_q   <= ahead_q;
                ahead_q  <= (ahead_q == CHOOSE) ? BEGIN : ahead_q + 5'd1;
                waits_q  <= waits;
                bare_q   <= bare;
                b_from_q <= b_from;
                open_q   <= (step_q == CHOOSE)  ? 3'b000
                          : (step_q == BEGIN)   ? 3'b001
                          : (step_q == CURRENT) ? 3'b011
                          : (step_q == X_HAT)   ? 3'b111 : open_q;
            end
            if (start_q && (begins_q || moves)) begin
                bound_q <= !begins_q;
            end
            if (accepts) begin
                busy_q <= 1'b1;
                give_q <= G_ZERO;
            end else begin
                if (ends) begin
                    busy_q <= 1'b0;
                end
                give_q <= give_q + {3'd0, granted};
            end
            if (go_q) begin
                case (adds_q)
                    BEGIN:   correction_o <= next_o;
                    CURRENT: begin
                        room_o <= (!contact_q || back_sum) ? {DATA_W{1'b0}}
                                : (|sum_q[LONG_W-2:VOLT_SHIFT+DATA_W-1]) ? {1'b0, {(DATA_W - 1){1'b1}}}
                                : $signed(sum_q[VOLT_SHIFT +: DATA_W]);
                        if (!contact_q) begin
                            tracked_q <= 1'b1;
                            offset_o  <= $signed(sum_q[AMP_SHIFT +: DATA_W]);
                        end
                    end
                    AHEAD:   flux_o    <= $signed(sum_q[LONG_W-1:CUT]);
                    FOLLOW:  lag_o     <= $signed(sum_q[LONG_W-1:CUT]);
                    BASE:    presses_q <= back_sum;
                    MEAN: begin
                        if (begins_q) begin
                            brush_q <= brush;
                        end else if (moves_mean && back_sum != presses_q) begin
                            brush_q <= less[DATA_W] ? {DATA_W{1'b0}} : $signed(less[DATA_W-1:0]);
                        end
                    end
                    BACK: begin
                        bound_q <= bound_q && (beside || !contact_q);
                    end
                    CORRECT: held_q <= $signed(sum_q[VOLT_SHIFT +: DATA_W]);
                    HELD: begin
                        theta_q <= none ? {COEF_W{1'b0}} : full ? learn_max
                                 : $signed(sum_q[THETA_CUT +: COEF_W]);
                        full_q  <= full;
                        void_q  <= back_sum;
                    end
                    STRANGE: begin
                        clipped_q    <= past;
                        overloaded_q <= blind_q || (past && overloaded_q);
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
