// SPDX-License-Identifier: Apache-2.0
//
// wh_anchor: the port anchor, which holds what a port feels like to where the encoder sees the rotor.
//
//   χ   = L̂ i + k̂_T x - Σ (s T/2)(u + v)      flux of the port, in cells of k̂_T Δ; 0 if all is ideal
//   p   = dz(χ, 1/2) + χ/256                  a cell's half is left alone, but for a 256th
//   c_I -= g_γ p                              every tick at rest, one in 8 while the rotor moves
//   c   = c_I - g_ρ p - g_d (L̂ i - its mean)  the last in contact and at rest
//   |c| <= min(c_0 + |e_id|/4, drive - |e_id|)
//
// c is a voltage in series with the port: it is added to e_id = s u behind the wave core, which does
// not see it. A contact's first edge sets χ to a quarter of a cell; in contact, what the voltage
// limit withholds from the waves counts as flux. In free space and at rest c shows the sensor's
// offset, which is summed up. A c that wants to go beyond its limit by strange tells that waves and
// encoder don't follow the same motor: fault_o, and c = 0.
//
// sim/wavehaptics/anchor.py says the same with integers, and this module equals it bit for bit.
// One adder works through the steps below, a step a clock, with its state in a memory; the products
// come from a multiplier that others use as well (wh_multiply_shared), eight in a step.
// Formats: long words s48q33, cells, V or A; factors are their upper bits, s31q16.
// Latency: 28 clocks from waves_i, and those that the multiplier makes it wait. c of one step is
// correction_o from the next waves_i on. A waves_i while busy is ignored and shows as overrun_o.
// Reset: χ, c_I, mean, offset and c are 0, at rest, no contact, no fault; of any length, at any clock.

`default_nettype none
`include "wh_formats.vh"

module wh_anchor (
    input  wire                               clk,
    input  wire                               rst,

    // The tick: its position and contact when the core starts, its waves when they are there.
    input  wire                               start_i,       // strobe
    input  wire signed [`WH_COUNT_W-1:0]      position_i,    // s32, counts
    input  wire                               contact_i,
    input  wire                               waves_i,       // strobe, the words below are there
    input  wire signed [`WH_DATA_W-1:0]       current_i,     // s31q24 A: i_n
    input  wire signed [`WH_DATA_W-1:0]       u_i,           // s31q23 √W: u_n
    input  wire signed [`WH_DATA_W-1:0]       v_i,           // s31q23 √W: v_n
    // Of the core's step before, with waves_i; the first holds until its product is asked for.
    input  wire signed [`WH_DATA_W-1:0]       withheld_i,    // s31q23 √W
    input  wire signed [`WH_DATA_W-1:0]       voltage_i,     // s31q23 V: e_id
    input  wire                               saturated_i,
    output wire                               busy_o,
    output reg                                overrun_o,     // until rst

    input  wire [`WH_ANCHOR_W-1:0]            words_i,       // settings, to be changed in reset

    // The shared multiplier.
    output wire                               request_o,
    output reg  signed [`WH_DATA_W-1:0]       factor_o,
    output reg  signed [`WH_COEF_W-1:0]       coefficient_o,
    input  wire                               grant_i,
    input  wire                               done_i,        // strobe
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i,

    output reg  signed [`WH_DATA_W-1:0]       correction_o,  // s31q23 V: c
    output wire signed [`WH_DATA_W-1:0]       next_o,        // s31q23 V: c of the step to come
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
    localparam integer PLACE_W   = LONG_W - LONG_Q;  // of the counts that x̂'s copy holds
    localparam integer MOVE_W    = `WH_MOVE_W;
    localparam integer REST_W    = `WH_REST_W;
    localparam integer UNIT_W    = `WH_REST_UNIT_W;

    localparam integer NEAR_SHIFT = `WH_CURRENT_Q + `WH_CELLS_Q - LONG_Q;
    localparam integer FAR_SHIFT  = `WH_WAVE_Q + `WH_FLUX_Q - LONG_Q;
    localparam integer VOLT_SHIFT = LONG_Q - `WH_VOLTAGE_Q;
    localparam integer AMP_SHIFT  = LONG_Q - `WH_CURRENT_Q;
    localparam integer INNER_SHIFT = 8;  // of χ within the dead zone, of both means

    generate
        if (NEAR_SHIFT < 1 || NEAR_SHIFT != `WH_PULL_Q - CUT || FAR_SHIFT != `WH_LEARN_Q - CUT
            || DATA_W + COEF_W - NEAR_SHIFT < LONG_W || VOLT_SHIFT < 2) begin : illegal_format
            wh_illegal_parameter_anchor_formats stop ();
        end
    endgenerate

    // ---- Settings, the last one highest: as sim/wavehaptics/anchor.py has their places.
    wire                     enable;       // 0: c = 0, and no fault
    wire signed [COEF_W-1:0] flux_gain;    // s27q22 cells a √W
    wire signed [COEF_W-1:0] owed_gain;    // s27q22 cells a √W
    wire signed [COEF_W-1:0] cells_gain;   // s27q12 cells an A
    wire signed [COEF_W-1:0] pull_gain;    // s27q20 V a cell: g_ρ
    wire signed [COEF_W-1:0] damp_gain;    // s27q20 V a cell: g_d
    wire signed [COEF_W-1:0] learn_gain;   // s27q29 V a cell: g_γ
    wire signed [COEF_W-1:0] zero_gain;    // s27q22 A a V
    wire signed [DATA_W-1:0] reach;        // s31q23 V: c_0
    wire signed [DATA_W-1:0] drive;        // s31q23 V
    wire signed [DATA_W-1:0] strange;      // s31q23 V
    wire        [REST_W-1:0] rest_ticks;   // ticks, 1...
    wire        [UNIT_W-1:0] slow_units;   // of rest_ticks

    assign {slow_units, rest_ticks, strange, drive, reach, zero_gain, learn_gain, damp_gain,
            pull_gain, cells_gain, owed_gain, flux_gain, enable} = words_i;

    // ---- What the tick brought.
    reg        [PLACE_W-1:0] position_q;
    reg signed [MOVE_W-1:0]  moved_q;
    reg                      started_q;   // there was a tick before
    reg                      contact_q;
    reg                      begins_q;    // the contact
    reg                      back_q;      // direction of the last edge
    reg [REST_W-1:0]         ticks_q;     // within a unit of rest
    reg [UNIT_W-1:0]         units_q;     // since the last edge the same way as the one before
    reg [4:0]                phase_q;     // ticks, modulo 32

    wire signed [MOVE_W-1:0] moved    =
        started_q ? $signed(position_i[MOVE_W-1:0] - position_q[MOVE_W-1:0]) : {MOVE_W{1'b0}};
    wire                     moves    = |moved;
    wire                     back     = moved[MOVE_W-1];
    wire                     one      = back ? (&moved) : (moved[MOVE_W-1:1] == 0);
    wire                     same_way = moves && (back == back_q || !one);
    wire                     unit     = ({1'b0, ticks_q} + 1'b1 >= {1'b0, rest_ticks});

    always @(posedge clk) begin
        if (rst) begin
            started_q <= 1'b0;
            contact_q <= 1'b0;
            begins_q  <= 1'b0;
            back_q    <= 1'b0;
            ticks_q   <= {REST_W{1'b0}};
            units_q   <= {UNIT_W{1'b1}};
            phase_q   <= 5'd0;
        end else if (start_i) begin
            started_q <= 1'b1;
            contact_q <= contact_i;
            begins_q  <= contact_i && !contact_q;
            back_q    <= moves ? back : back_q;
            phase_q   <= phase_q + 5'd1;
            ticks_q   <= (same_way || unit) ? {REST_W{1'b0}} : ticks_q + 1'b1;
            if (same_way) begin
                units_q <= {UNIT_W{1'b0}};
            end else if (unit && !(&units_q)) begin
                units_q <= units_q + 1'b1;
            end
        end
        if (start_i) begin
            position_q <= position_i[PLACE_W-1:0];
            moved_q    <= moved;
        end
    end

    wire rests = |units_q;
    wire still = units_q[UNIT_W-1];
    wire slow  = (units_q >= slow_units);

    // ---- The steps: what is added to what, and where the sum goes. Sums with a product wait for it.
    localparam [4:0] DRIVE = 0, LEFT = 1, HOLD = 2, ZERO = 3, ADD_U = 4, ADD_V = 5, ADD_OWED = 6,
                     CURRENT = 7, SWING = 8, MEAN = 9, BASE = 10, EDGE = 11, FLUX = 12,
                     INNER = 13, PULL = 14, REACH = 15, LIMIT = 16, COMPARE = 17, LEARN = 18,
                     CORRECT = 19, DAMP = 20, CLIP = 21, STRANGE = 22, CHOOSE = 23,
                     PLACE = 24, X_HAT = 25, LAG = 26, FOLLOW = 27;
    localparam [4:0] LAST = FOLLOW;

    // The memory's words.
    localparam [3:0] M_FLUX = 0, M_LEARNED = 1, M_MEAN = 2, M_ZERO = 3, M_FOLLOWER = 4,
                     M_LEFT = 8, M_LIMIT = 9, M_CURRENT = 10, M_SWING = 11, M_WANTED = 12,
                     M_CHI = 13;

    reg [4:0] step_q;
    reg       busy_q;
    reg       first_q;    // no step has been made: the memory's state reads as 0

    wire consumes = (step_q >= ZERO && step_q <= CURRENT) || (step_q >= LEARN && step_q <= DAMP);
    wire advances = busy_q && (!consumes || done_i);
    wire ends     = advances && step_q == LAST;

    assign busy_o = busy_q;

    // ---- The adder.
    localparam [1:0] A_NONE = 0, A_SUM = 1, A_MEMORY = 2;
    localparam [2:0] B_NONE = 0, B_MEMORY = 1, B_SUM = 2, B_NEAR = 3, B_FAR = 4, B_INPUT = 5;

    reg signed [LONG_W-1:0] memory [0:15];
    reg signed [LONG_W-1:0] read_q;
    reg signed [LONG_W-1:0] sum_q;
    reg signed [DATA_W-1:0] voltage_q;
    reg                     saturated_q;
    reg signed [LONG_W-1:0] given;
    reg        [1:0]        a_from;
    reg        [2:0]        b_from;
    reg                     minus;
    reg                     fresh;      // what is read is 0 in the first step
    reg                     writes;
    reg        [3:0]        write_to;
    reg        [3:0]        read_next;  // for the step after this one
    reg                     over_left_q;
    reg                     out_q;      // χ is outside the dead zone
    reg                     clipped_q;
    reg                     negative_q; // the correction that is wanted

    wire signed [LONG_W-1:0] read   = (fresh && first_q) ? {LONG_W{1'b0}} : read_q;
    wire                     e_back = voltage_q[DATA_W-1];
    wire                     above  = !sum_q[LONG_W-1] && (|sum_q[LONG_W-2:LONG_Q-1]);
    wire                     below  = sum_q[LONG_W-1] && !(&sum_q[LONG_W-2:LONG_Q-1]);
    wire                     learns = (still || phase_q[2:0] == 3'd0) && !clipped_q && !saturated_q;
    wire                     past   = (sum_q[LONG_W-1] == negative_q);

    always @* begin
        a_from   = A_NONE;
        b_from   = B_NONE;
        minus    = 1'b0;
        fresh    = 1'b0;
        writes   = 1'b0;
        write_to = M_FLUX;
        case (step_q)
            DRIVE: b_from = B_INPUT;
            LEFT: begin
                a_from   = A_SUM;
                b_from   = B_INPUT;
                minus    = !e_back;
                writes   = 1'b1;
                write_to = M_LEFT;
            end
            ZERO: begin
                a_from   = A_MEMORY;
                b_from   = (!contact_q && slow) ? B_FAR : B_NONE;
                minus    = 1'b1;
                fresh    = 1'b1;
                writes   = 1'b1;
                write_to = M_ZERO;
            end
            ADD_U: begin
                a_from = A_MEMORY;
                b_from = B_FAR;
                minus  = 1'b1;
                fresh  = 1'b1;
            end
            ADD_V: begin
                a_from = A_SUM;
                b_from = B_FAR;
                minus  = 1'b1;
            end
            ADD_OWED: begin
                a_from = A_SUM;
                b_from = contact_q ? B_FAR : B_NONE;
                minus  = 1'b1;
                writes = 1'b1;
            end
            CURRENT: begin
                b_from   = B_NEAR;
                writes   = 1'b1;
                write_to = M_CURRENT;
            end
            SWING: begin
                a_from   = A_SUM;
                b_from   = B_MEMORY;
                minus    = 1'b1;
                fresh    = 1'b1;
                writes   = 1'b1;
                write_to = M_SWING;
            end
            MEAN: begin
                a_from   = A_MEMORY;
                b_from   = (phase_q == 5'd0) ? B_SUM : B_NONE;
                fresh    = 1'b1;
                writes   = 1'b1;
                write_to = M_MEAN;
            end
            BASE: begin  // reads the current where a contact begins, the flux otherwise
                b_from = B_MEMORY;
                minus  = begins_q;
            end
            EDGE: begin
                a_from = A_SUM;
                b_from = B_INPUT;
                writes = 1'b1;
            end
            FLUX: begin
                a_from   = A_SUM;
                b_from   = B_MEMORY;
                writes   = 1'b1;
                write_to = M_CHI;
            end
            INNER: begin
                a_from = (above || below) ? A_SUM : A_NONE;
                b_from = B_SUM;
            end
            PULL: begin
                a_from = A_SUM;
                b_from = out_q ? B_INPUT : B_NONE;
                minus  = !negative_q;
            end
            REACH: b_from = B_INPUT;
            LIMIT: begin
                a_from   = A_SUM;
                b_from   = B_INPUT;
                minus    = e_back;
                writes   = 1'b1;
                write_to = M_LIMIT;
            end
            COMPARE: begin
                a_from = A_SUM;
                b_from = B_MEMORY;
                minus  = 1'b1;
            end
            LEARN: begin
                a_from   = A_MEMORY;
                b_from   = learns ? B_FAR : B_NONE;
                minus    = 1'b1;
                fresh    = 1'b1;
                writes   = 1'b1;
                write_to = M_LEARNED;
            end
            CORRECT: begin
                a_from = A_SUM;
                b_from = B_NEAR;
                minus  = 1'b1;
            end
            DAMP: begin
                a_from   = A_SUM;
                b_from   = (contact_q && rests) ? B_NEAR : B_NONE;
                minus    = 1'b1;
                writes   = 1'b1;
                write_to = M_WANTED;
            end
            CLIP: begin
                a_from = A_SUM;
                b_from = B_MEMORY;
                minus  = !sum_q[LONG_W-1];
            end
            STRANGE: begin
                a_from = A_SUM;
                b_from = B_INPUT;
                minus  = !negative_q;
            end
            CHOOSE: begin
                b_from = B_MEMORY;
                minus  = clipped_q && negative_q;
            end
            PLACE: b_from = B_INPUT;
            X_HAT: begin
                a_from = A_SUM;
                b_from = B_MEMORY;
                minus  = 1'b1;
            end
            LAG: begin
                a_from = A_SUM;
                b_from = B_MEMORY;
                minus  = 1'b1;
                fresh  = 1'b1;
            end
            FOLLOW: begin
                a_from   = A_MEMORY;
                b_from   = B_SUM;
                fresh    = 1'b1;
                writes   = 1'b1;
                write_to = M_FOLLOWER;
            end
            default: a_from = A_SUM;  // HOLD
        endcase
    end

    // What comes from outside.
    wire signed [LONG_W-1:0] voltage = $signed({{(LONG_W - DATA_W){e_back}}, voltage_q});
    wire signed [DATA_W-1:0] limit   =
        (step_q == DRIVE) ? drive : (step_q == STRANGE) ? strange : reach;
    wire signed [LONG_W-1:0] setting =
        $signed({{(LONG_W - DATA_W - VOLT_SHIFT){limit[DATA_W-1]}}, limit, {VOLT_SHIFT{1'b0}}});

    always @* begin
        case (step_q)
            LEFT:    given = voltage <<< VOLT_SHIFT;
            LIMIT:   given = voltage <<< (VOLT_SHIFT - 2);
            EDGE:    given = !begins_q ? $signed({{(LONG_W - LONG_Q - MOVE_W){moved_q[MOVE_W-1]}},
                                                  moved_q, {LONG_Q{1'b0}}})
                           : $signed({{(LONG_W - LONG_Q + 1){moved_q[MOVE_W-1]}}, |moved_q,
                                      {(LONG_Q - 2){1'b0}}});
            PULL:    given = $signed({{(LONG_W - LONG_Q){1'b0}}, 1'b1, {(LONG_Q - 1){1'b0}}});
            PLACE:   given = $signed({position_q, {LONG_Q{1'b0}}});
            default: given = setting;
        endcase
    end

    reg  signed [LONG_W-1:0] b;
    wire signed [LONG_W-1:0] a = (a_from == A_SUM)    ? sum_q
                               : (a_from == A_MEMORY) ? read : {LONG_W{1'b0}};

    always @* begin
        case (b_from)
            B_MEMORY: b = read;
            B_SUM:    b = sum_q >>> INNER_SHIFT;
            B_NEAR:   b = $signed(product_i[NEAR_SHIFT +: LONG_W]);
            B_FAR:    b = $signed({{(LONG_W - DATA_W - COEF_W + FAR_SHIFT){product_i[DATA_W+COEF_W-1]}},
                                   product_i[DATA_W+COEF_W-1:FAR_SHIFT]});
            B_INPUT:  b = given;
            default:  b = {LONG_W{1'b0}};
        endcase
    end

    wire unused = &{1'b0, product_i[NEAR_SHIFT-1:0], position_i[`WH_COUNT_W-1:PLACE_W]};

    wire signed [LONG_W-1:0] sum = a + (b ^ {LONG_W{minus}}) + $signed({{(LONG_W - 1){1'b0}}, minus});

    // The word that the step after this one reads. What a step writes, the one after it can't read.
    always @* begin
        case (step_q)
            HOLD:    read_next = M_ZERO;
            ZERO:    read_next = M_FLUX;
            CURRENT: read_next = M_MEAN;
            SWING:   read_next = M_MEAN;
            MEAN:    read_next = begins_q ? M_CURRENT : M_FLUX;
            EDGE:    read_next = M_CURRENT;
            LIMIT:   read_next = M_LEFT;
            COMPARE: read_next = M_LEARNED;
            DAMP:    read_next = over_left_q ? M_LEFT : M_LIMIT;
            STRANGE: read_next = !past ? M_WANTED : over_left_q ? M_LEFT : M_LIMIT;
            PLACE:   read_next = M_CHI;
            default: read_next = M_FOLLOWER;
        endcase
    end

    always @(posedge clk) begin
        if (advances && writes) begin
            memory[write_to] <= sum;
        end
        if (advances) begin
            read_q <= memory[read_next];
        end
    end

    // ---- The products, in the order in which they are asked for, in two runs. A run's products come
    // one after the other and its steps follow each other, so that none comes before its step: the
    // first step stands as many clocks after its factor as a product takes, or more. The steps before
    // the first run take no product, so none that was asked for before a reset can be taken for another.
    localparam [3:0] G_ZERO = 0, G_U = 1, G_V = 2, G_OWED = 3, G_CURRENT = 4, G_LEARN = 5,
                     G_PULL = 6, G_DAMP = 7, G_DONE = 8;

    reg        [3:0]        give_q;
    reg signed [DATA_W-1:0] pull_q;   // s31q16 cells: p
    reg signed [DATA_W-1:0] swing_q;  // s31q16 cells

    assign request_o = busy_q && (give_q <= G_CURRENT || (give_q < G_DONE && step_q >= REACH));

    always @* begin
        case (give_q)
            G_U:       factor_o = u_i;
            G_V:       factor_o = v_i;
            G_OWED:    factor_o = withheld_i;
            G_CURRENT: factor_o = current_i;
            G_ZERO:    factor_o = correction_o;
            G_DAMP:    factor_o = swing_q;
            default:   factor_o = pull_q;
        endcase
        case (give_q)
            G_U,
            G_V:       coefficient_o = flux_gain;
            G_OWED:    coefficient_o = owed_gain;
            G_CURRENT: coefficient_o = cells_gain;
            G_ZERO:    coefficient_o = zero_gain;
            G_LEARN:   coefficient_o = learn_gain;
            G_PULL:    coefficient_o = pull_gain;
            default:   coefficient_o = damp_gain;
        endcase
    end

    // ---- What has a meaning within a step only.
    always @(posedge clk) begin
        if (waves_i && (!busy_q || ends)) begin
            voltage_q   <= voltage_i;
            saturated_q <= saturated_i;
        end
        if (advances) begin
            sum_q <= sum;
            case (step_q)
                SWING: swing_q <= $signed(sum[LONG_W-1:CUT]);
                INNER: begin
                    out_q      <= above || below;
                    negative_q <= sum_q[LONG_W-1];
                end
                PULL:  pull_q      <= $signed(sum[LONG_W-1:CUT]);
                LEARN: over_left_q <= !sum_q[LONG_W-1];
                CLIP:  negative_q  <= sum_q[LONG_W-1];
                default: ;
            endcase
        end
    end

    // ---- Steps and results.
    reg signed [DATA_W-1:0] next_q;

    assign next_o = next_q;

    always @(posedge clk) begin
        if (rst) begin
            step_q       <= DRIVE;
            busy_q       <= 1'b0;
            first_q      <= 1'b1;
            give_q       <= G_ZERO;
            overrun_o    <= 1'b0;
            clipped_q    <= 1'b0;
            fault_o      <= 1'b0;
            next_q       <= {DATA_W{1'b0}};
            correction_o <= {DATA_W{1'b0}};
            offset_o     <= {DATA_W{1'b0}};
            flux_o       <= {DATA_W{1'b0}};
            lag_o        <= {DATA_W{1'b0}};
        end else begin
            if (waves_i && busy_q && !ends) begin
                overrun_o <= 1'b1;
            end
            if (waves_i && (!busy_q || ends)) begin
                busy_q       <= 1'b1;
                step_q       <= DRIVE;
                give_q       <= G_ZERO;
                correction_o <= next_q;
            end else begin
                if (ends) begin
                    busy_q <= 1'b0;
                end
                if (advances) begin
                    step_q <= step_q + 5'd1;
                end
                if (request_o && grant_i) begin
                    give_q <= give_q + 4'd1;
                end
            end
            if (advances) begin
                case (step_q)
                    ADD_U:   offset_o  <= $signed(sum_q[AMP_SHIFT +: DATA_W]);
                    INNER:   flux_o    <= $signed(sum_q[LONG_W-1:CUT]);
                    STRANGE: clipped_q <= past;
                    CHOOSE:  fault_o   <= fault_o || (enable && clipped_q && past);
                    PLACE:   next_q    <= (enable && !fault_o) ? $signed(sum_q[VOLT_SHIFT +: DATA_W])
                                                               : {DATA_W{1'b0}};
                    FOLLOW: begin
                        lag_o   <= $signed(sum_q[LONG_W-1:CUT]);
                        first_q <= 1'b0;
                    end
                    default: ;
                endcase
            end
        end
    end

endmodule

`default_nettype wire
