// SPDX-License-Identifier: Apache-2.0
//
// wh_anchor: the port anchor, which holds what a port feels like to where the encoder sees the rotor.
//
//   χ   = L̂ i + k̂_T x - Σ (s T/2)(u + v)      flux of the port, in cells of k̂_T Δ; 0 if all is ideal
//   p   = dz(χ, 1/2) + χ/256                  a cell's half is left alone, but for a 256th
//   c_I -= g_γ p                              every tick at rest, one in 8 while the rotor moves; from 0
//                                             on when a contact ends
//   c   = c_I - g_ρ p - g_d (L̂ i - its mean)  the last in contact, at rest and below 4 cells
//   |c| <= c_0 + |e_id|/2                     c_0/2 out of contact
//   rebounds_o                                within 16 rest_ticks of a contact: back the way it began
//
// c is a voltage in series with the port: it is added to e_id = s u behind the wave core, which does
// not see it, and what it takes of the drive's limit, room_o, is the wave's no more. A contact's first
// edge, in the tick that tells of the contact or one of the two before, sets χ to a quarter of a cell and
// what is in the λ filter then, which its u tells; in contact, what the voltage limit or rounding withholds
// from the waves counts as flux. In free space and at rest c shows the sensor's offset, which is summed up.
// While a rotor that hit a wall goes back out of it, the environment returns less, rebound_eta_o, so that
// a hit comes back with no more than it had whatever c gives; that is flux which the wall lacks, and with the
// edge with which the rotor turns in again χ is what it would be if the contact began there.
// A c that wants to go beyond its limit by strange, with the waves below theirs, tells that waves and encoder
// don't follow the same motor: fault_o, and c = 0. So does a χ in the outer half of its range.
// In a tick whose current or v is at the end of its range, blind_i, nothing is learned, and the next c is
// 0; χ counts on. While c is at its limit since, that is no fault.
//
// AXIS = 1: the port is one of a brushless motor's two axes, whose flux a count changes by a part of a cell
// (wh_rotor_flux): its place comes from there, the dead zone is half of that part, and so is what a contact
// begins with.
//
// sim/wavehaptics/controller/anchor.py says the same with integers, and this module equals it bit for bit.
// One adder works through the steps below, one in a clock, with its state in a memory; the products
// come from a multiplier that others use as well (wh_multiply_shared), eight in a tick.
// Formats: long words s48q33, cells, V or A; factors are their upper bits, s31q16.
// Latency: 28 clocks from waves_i, and those that the multiplier makes it wait. c of one tick is
// correction_o from the next waves_i on, two clocks later. The next waves_i may come in the last of the
// 28, the next start_i in the last four, or together with its waves_i. A waves_i before is ignored and
// a start_i before spoils what is under way; both show as overrun_o. reads_o is 0 in at least two clocks of
// every step, the last two before the next waves_i at the latest.
// Reset: χ, c_I, mean, offset, room and c are 0, at rest, no contact, no fault; of any length, at any clock.

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
    output reg                                rebounds_o,    // of the step to come
    output wire signed [`WH_COEF_W-1:0]       rebound_eta_o, // s27q25: η of such a step, the word
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
    localparam integer UNIT_W    = `WH_REST_UNIT_W;

    localparam integer NEAR_SHIFT = `WH_CURRENT_Q + `WH_CELLS_Q - LONG_Q;
    localparam integer FAR_SHIFT  = `WH_WAVE_Q + `WH_FLUX_Q - LONG_Q;
    localparam integer VOLT_SHIFT = LONG_Q - `WH_VOLTAGE_Q;
    localparam integer AMP_SHIFT  = LONG_Q - `WH_CURRENT_Q;
    localparam integer INNER_SHIFT = 8;  // of χ within the dead zone, of both means
    localparam integer SWING_W     = 2;  // swings are smaller than 2^2 cells
    localparam [1:0]   FRESH_TICKS = 3;  // a contact is told in its edge's tick or in the next two

    generate
        if (NEAR_SHIFT < 1 || NEAR_SHIFT != `WH_PULL_Q - CUT || FAR_SHIFT != `WH_LEARN_Q - CUT
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
    wire signed [COEF_W-1:0] damp_gain;    // s27q20 V a cell: g_d
    wire signed [COEF_W-1:0] learn_gain;   // s27q29 V a cell: g_γ
    wire signed [COEF_W-1:0] zero_gain;    // s27q22 A a V
    wire signed [COEF_W-1:0] room_gain;    // s27q22 √W a V: 1/s
    wire signed [DATA_W-1:0] reach;        // s31q23 V, 0...64 V: c_0
    wire signed [DATA_W-1:0] strange;      // s31q23 V
    wire        [REST_W-1:0] rest_ticks;   // ticks, 1...
    wire        [UNIT_W-1:0] slow_units;   // of rest_ticks
    wire signed [COEF_W-1:0] rebound_eta;  // s27q25; 0: no contact is told from another

    assign rebound_eta_o = rebound_eta;
    assign {rebound_eta, slow_units, rest_ticks, strange, reach, room_gain, zero_gain, learn_gain,
            damp_gain, pull_gain, cells_gain, owed_gain, flux_gain, enable} = words_i;

    // ---- What the tick brought.
    reg        [PLACE_W-1:0] position_q;
    reg signed [MOVE_W-1:0]  moved_q;
    reg                      started_q;   // there was a tick before
    reg                      start_q;     // moved_q is a new tick's: its rest is counted in this clock
    reg                      contact_q;
    reg                      begins_q;    // the contact
    reg                      over_q;      // the contact, in this tick
    reg                      back_q;      // direction of the last edge
    reg [1:0]                fresh_q;     // ticks for which that edge is one that a contact can begin with
    reg [REST_W-1:0]         ticks_q;     // left of a unit of rest
    reg [UNIT_W-1:0]         units_q;     // since the last edge the same way as the one before
    reg [4:0]                phase_q;     // ticks, modulo 32
    reg                      into_q;      // direction of the edge with which the contact began
    reg [REST_W-2:0]         young_q;     // the contact is, for 32 ticks as many times
    reg                      bounced_q;   // it has been a rebound
    reg                      returns_q;   // the rotor turns in again, in this tick
    reg                      anew_q;      // χ is set, as that or as the contact begins

    wire signed [MOVE_W-1:0] moved    =
        started_q ? $signed(position_i[MOVE_W-1:0] - position_q[MOVE_W-1:0]) : {MOVE_W{1'b0}};
    wire                     moves    = |moved_q;
    wire                     back     = moved_q[MOVE_W-1];
    wire                     one      = back ? (&moved_q) : (moved_q[MOVE_W-1:1] == 0);
    wire                     same_way = moves && (back == back_q || !one);
    wire                     unit     = (ticks_q[REST_W-1:1] == 0);
    wire                     edged    = (fresh_q != 2'd0);
    wire                     young    = |young_q;
    wire                     hits     = enable && (|rebound_eta);
    wire                     turns    = hits && contact_q && !begins_q && moves;
    wire                     returns  = turns && bounced_q && back == into_q;
    wire                     anew     = start_q ? begins_q || returns : anew_q;

    always @(posedge clk) begin
        if (rst) begin
            started_q <= 1'b0;
            start_q   <= 1'b0;
            contact_q <= 1'b0;
            begins_q  <= 1'b0;
            over_q    <= 1'b0;
            back_q    <= 1'b0;
            fresh_q   <= 2'd0;
            ticks_q   <= rest_ticks;
            units_q   <= {UNIT_W{1'b1}};
            phase_q   <= 5'd0;
            into_q    <= 1'b0;
            young_q   <= {(REST_W - 1){1'b0}};
            bounced_q <= 1'b0;
            returns_q <= 1'b0;
            anew_q    <= 1'b0;
        end else begin
            start_q <= start_i;
            if (start_i) begin
                started_q <= 1'b1;
                contact_q <= contact_i;
                begins_q  <= contact_i && !contact_q;
                over_q    <= !contact_i && contact_q;
                phase_q   <= phase_q + 5'd1;
            end
            if (start_q) begin
                back_q  <= moves ? back : back_q;
                fresh_q <= moves ? FRESH_TICKS : edged ? fresh_q - 2'd1 : 2'd0;
                ticks_q <= (same_way || unit) ? rest_ticks : ticks_q - 1'b1;
                if (same_way) begin
                    units_q <= {UNIT_W{1'b0}};
                end else if (unit && !(&units_q)) begin
                    units_q <= units_q + 1'b1;
                end
                if (begins_q) begin
                    into_q  <= moves ? back : back_q;
                    young_q <= rest_ticks[REST_W-1:1];  // 16 units of them
                end else if (phase_q == 5'd0 && young) begin
                    young_q <= young_q - 1'b1;
                end
                bounced_q <= begins_q ? 1'b0 : !turns ? bounced_q
                           : (back != into_q && (young || bounced_q));
                anew_q    <= anew;
                returns_q <= returns;
            end
        end
        if (start_i) begin
            position_q <= position_i[PLACE_W-1:0];
            moved_q    <= moved;
        end
    end

    // What the encoder tells of the flux: all of it, what the tick changed, what a contact begins with,
    // and whether χ, sum_q of the step INNER, is beyond half of what a count changes.
    wire signed [LONG_W-1:0] place;
    wire signed [LONG_W-1:0] moved_flux;
    wire signed [LONG_W-1:0] start_flux;
    wire signed [LONG_W-1:0] half_flux;
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
            assign out        = back_sum ? (chi < -half) : (chi >= half);
        end else begin : motor
            wire unused_axis = &{1'b0, place_i, cell_i};

            assign place      = $signed({position_q, {LONG_Q{1'b0}}});
            assign moved_flux = $signed({{(LONG_W - LONG_Q - MOVE_W){moved_q[MOVE_W-1]}}, moved_q,
                                         {LONG_Q{1'b0}}});
            assign start_flux = $signed({{(LONG_W - LONG_Q + 1){edged && back_q}}, edged,
                                         {(LONG_Q - 2){1'b0}}});
            assign half_flux  = $signed({{(LONG_W - LONG_Q){1'b0}}, 1'b1, {(LONG_Q - 1){1'b0}}});
            assign out        = back_sum ? !(&sum_q[LONG_W-2:LONG_Q-1])
                                         : (|sum_q[LONG_W-2:LONG_Q-1]);
        end
    endgenerate

    // The tick's own, also in the clock of its start.
    wire touches = start_i ? contact_i : contact_q;

    wire rests = |units_q;
    wire still = units_q[UNIT_W-1];
    wire slow  = (units_q >= slow_units);

    // ---- The steps: what is added to what, and where the sum goes. A step's words are fetched in one
    // clock (step_q), where the sums with a product wait for it, and added in the next (adds_q). What
    // would have to be found out from step_q, and then go to every bit of a word, is known a clock before.
    // BEGIN, while there is nothing to do: the tick's words are there a clock later.
    localparam [4:0] BEGIN = 0, REACH = 1, LIMIT = 2,
                     TAKE_ZERO = 3, ZERO = 4, CURRENT = 5, SWING = 6, MEAN = 7,
                     BASE = 8, ADD_OWED = 9, ADD_U = 10, ADD_V = 11, EDGE = 12, FLUX = 13,
                     INNER = 14, HALF = 15, OUTER = 16,
                     PLACE = 17, X_HAT = 18, LAG = 19, FOLLOW = 20,
                     TAKE_LEARNED = 21, LEARN = 22, CORRECT = 23, DAMP = 24,
                     CLIP = 25, STRANGE = 26, CHOOSE = 27;

    // The memory's words.
    localparam [3:0] M_FLUX = 0, M_LEARNED = 1, M_MEAN = 2, M_ZERO = 3, M_FOLLOWER = 4, M_BEGUN = 8,
                     M_LIMIT = 9, M_CURRENT = 10, M_WANTED = 12, M_CHI = 13;

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
    localparam [2:0] B_NEAR = 0, B_FAR = 1,  // products
                     B_REACH = 2, B_STRANGE = 3, B_VOLTAGE = 4, B_EDGE = 5, B_HALF = 6, B_PLACE = 7;

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
    reg        [2:0]        b_from_q, b_from;
    reg                     waits;
    reg                     bare_q, bare;            // b_q is 0
    reg                     halves_q;                // nothing is added if χ isn't outside
    reg                     minus_q, minus;
    reg                     to_zero_q;               // minus if the sum isn't
    reg                     out_q;                   // χ is outside the dead zone
    reg                     clipped_q;
    reg                     negative_q;              // the correction that is wanted

    wire e_back = voltage_q[DATA_W-1];
    wire back_sum = sum_q[LONG_W-1];
    wire learns = (still || phase_q[2:0] == 3'd0) && !clipped_q && !saturated_q && !blind_q;
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
                inner      = (phase_q == 5'd0) && !blind_q;
                memory_too = 1'b1;
                fresh      = 1'b1;
                read_from  = M_MEAN;
                writes     = 1'b1;
                write_to   = M_MEAN;
            end
            BASE: begin
                memory_too = !begins_q;
                fresh      = 1'b1;
                minus      = returns_q;
                read_from  = returns_q ? M_BEGUN : M_FLUX;
            end
            ADD_OWED: begin
                sum_too = 1'b1;
                minus   = !anew_q;
            end
            ADD_U: begin
                sum_too = 1'b1;
                minus   = !returns_q;
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
                write_to   = M_CHI;
            end
            INNER: inner = 1'b1;
            HALF: begin
                sum_too = 1'b1;
                minus   = !back_sum;
            end
            OUTER: begin
                sum_too    = 1'b1;
                memory_too = out_q;
                read_from  = M_CHI;
            end
            PLACE: begin
                writes   = begins_q;
                write_to = M_BEGUN;
            end
            X_HAT: begin
                sum_too    = 1'b1;
                memory_too = 1'b1;
                read_from  = M_CHI;
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
            TAKE_LEARNED: begin
                memory_too = !over_q;
                fresh      = 1'b1;
                read_from  = M_LEARNED;
            end
            LEARN: begin
                sum_too  = 1'b1;
                minus    = 1'b1;
                writes   = 1'b1;
                write_to = M_LEARNED;
            end
            CORRECT: begin
                sum_too = 1'b1;
                minus   = 1'b1;
            end
            DAMP: begin
                sum_too  = 1'b1;
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
                b_from = returns_q ? B_PLACE : B_FAR;
            end
            ADD_V: begin
                waits  = 1'b1;
                bare   = anew_q;
                b_from = B_FAR;
            end
            EDGE:    b_from = B_EDGE;
            HALF:    b_from = B_HALF;
            PLACE:   b_from = B_PLACE;
            LEARN: begin
                waits  = 1'b1;
                bare   = !learns;
                b_from = B_FAR;
            end
            DAMP: begin
                waits  = 1'b1;
                bare   = !contact_q || !rests || !small_q;
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
        if (bare_q) begin
            b_q <= {LONG_W{1'b0}};
        end else begin
            case (b_from_q)
                B_NEAR:    b_q <= $signed(product_i[NEAR_SHIFT +: LONG_W]);
                B_FAR:     b_q <= $signed({{(LONG_W - DATA_W - COEF_W + FAR_SHIFT)
                                                {product_i[DATA_W+COEF_W-1]}},
                                           product_i[DATA_W+COEF_W-1:FAR_SHIFT]});
                B_VOLTAGE: b_q <= $signed({{(LONG_W - DATA_W - VOLT_SHIFT + 1){e_back}}, voltage_q,
                                           {(VOLT_SHIFT - 1){1'b0}}});
                B_EDGE:    b_q <= anew_q ? start_flux : moved_flux;
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
        halves_q     <= (step_q == HALF);
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

    wire unused = &{1'b0, product_i[NEAR_SHIFT-1:0], position_i[`WH_COUNT_W-1:PLACE_W]};

    always @(posedge clk) begin
        if (go_q && (out_q || !halves_q)) begin
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
    localparam [3:0] G_ZERO = 0, G_CURRENT = 1, G_OWED = 2, G_U = 3, G_V = 4, G_DAMP = 7;  // 8: none

    reg        [3:0]        give_q;         // one of them
    reg        [2:0]        open_q;         // runs that may be asked for
    reg signed [DATA_W-1:0] factor_q;       // of give_q, but for G_ZERO's and G_DAMP's
    reg signed [COEF_W-1:0] coefficient_q;  // of give_q
    reg signed [DATA_W-1:0] swing_q;        // s31q16 cells
    reg                     small_q;        // it is a swing, and no move

    assign request_o = (open_q[0] && give_q <= G_CURRENT) || (open_q[1] && give_q <= G_V)
                       || (open_q[2] && give_q <= G_DAMP);

    // With a grant come the next product's operands; G_ZERO's gain waits, its factor is there too late
    // for that. p = s31q16 cells, which is there just in time, is G_LEARN's and G_PULL's factor.
    wire       granted = request_o && grant_i;
    wire       placed  = go_q && adds_q == PLACE;
    reg  [2:0] after_q;  // gain of the product after this one
    wire [2:0] gain    = open_q[0] ? after_q : {2'b00, touches};

    assign factor_o      = (give_q == G_ZERO) ? next_o : (give_q == G_DAMP) ? swing_q : factor_q;
    assign coefficient_o = coefficient_q;

    always @(posedge clk) begin
        if (!open_q[0]) begin
            after_q <= 3'd2;
        end else if (granted) begin
            case (give_q)
                G_ZERO:    after_q <= (saturated_q || anew) ? 3'd3 : 3'd4;
                G_CURRENT: after_q <= 3'd4;
                G_OWED:    after_q <= 3'd4;
                G_U:       after_q <= 3'd5;
                G_V:       after_q <= 3'd6;
                default:   after_q <= 3'd7;  // of the two that learn and pull, G_DAMP's comes last
            endcase
        end
        if (placed || (granted && !give_q[2])) begin
            factor_q <= placed                ? $signed(sum_q[LONG_W-1:CUT])
                      : (give_q == G_ZERO)    ? current_i
                      : (give_q == G_CURRENT && !anew_q) ? withheld_i
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
                3'd6:    coefficient_q <= pull_gain;
                default: coefficient_q <= damp_gain;
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
                MEAN: begin
                    swing_q <= $signed(sum_q[LONG_W-1:CUT]);
                    small_q <= (&sum_q[LONG_W-1:LONG_Q+SWING_W]) || !(|sum_q[LONG_W-1:LONG_Q+SWING_W]);
                end
                INNER: begin
                    out_q <= out;
                    far_q <= (sum_q[LONG_W-1] != sum_q[LONG_W-2]);
                end
                CLIP:    negative_q <= back_sum;
                default: ;
            endcase
        end
    end

    // ---- Steps and results.
    reg  signed [DATA_W-1:0] next_q;
    reg                      chosen_q;  // c is still in sum_q, and
    reg                      none_q;    // it is not wanted
    wire                     strange_c = clipped_q && past && !saturated_q && !overloaded_q;
    wire                     lost = enable_q && (fault_o || far_q || strange_c);

    assign next_o = none_q ? {DATA_W{1'b0}} : chosen_q ? $signed(sum_q[VOLT_SHIFT +: DATA_W]) : next_q;

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
            rebounds_o   <= 1'b0;
        end else begin
            if ((waves_i && !accepts) || (start_i && step_q != BEGIN && step_q <= DAMP)) begin
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
                        room_o <= contact_q ? $signed(sum_q[VOLT_SHIFT +: DATA_W]) : {DATA_W{1'b0}};
                        if (!contact_q) begin
                            tracked_q <= 1'b1;
                            offset_o  <= $signed(sum_q[AMP_SHIFT +: DATA_W]);
                        end
                    end
                    INNER:   flux_o    <= $signed(sum_q[LONG_W-1:CUT]);
                    FOLLOW:  lag_o     <= $signed(sum_q[LONG_W-1:CUT]);
                    DAMP:    rebounds_o <= hits && contact_q && young && back_q != into_q;
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
