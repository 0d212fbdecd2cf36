// SPDX-License-Identifier: Apache-2.0
//
// wh_drive: from the voltages of N ports, which arrive in turn, to the pulse widths of their bridges.
//
//   driven = e_id + c,  c: from the port anchor's previous step
//   width  = round(driven * clocks_per_volt + extra + rests), once in each carrier half
//
// For each port it equals wh_port, wh_dead_time and wh_modulator bit for bit; their headers have equations and formats.
//
// The turn: 2 clocks after current_valid_i the sign of the dead time's compensation (its side) is known.
// voltage_o is valid in the clock of voltage_valid_i. Its product is requested 1 clock later; no other station may
// request then. 5 clocks after voltage_valid_i the new duty waits to be taken.
//
// The walk: from the clock after walk_i the widths of all ports are computed, one a clock, five clocks each.
// width_valid_o comes with width_o for width_port_o, the last one N + 5 clocks after walk_i. take_i, in the clock of
// walk_i, first puts the waiting duties in force.
//
// Legs: a brushed motor's bridge counts as one leg, with its port's number. A brushless motor has three, marked in
// PHASES; the number of the third is behind those of all ports. Each leg has its own side, and a width once a period,
// with half_i; least_i doesn't apply to it. A voltage with voltage_axis_i is an axis': its own product isn't requested.
// wh_legs requests those of the legs, with the scale that was read for the axis, and returns the leg with its product.
//
// State, by port, in LUT RAM (wh_port_state): c (31 bits), the side (10), two duties (36 each), of which one is in
// force, and the rests (35). Settings: clocks_per_volt, side_current (wh_port_settings).
// Latency: above. Reset: duties, rests and widths 0, as wh_modulator; c by correction_rst_i.

`default_nettype none
`include "wh_formats.vh"

module wh_drive #(
    parameter integer N         = 1,                     // ports, 1...8
    parameter integer MIN_PULSE = 0,                     // 1: least_i and spare_i are used; 0: both are 0
    parameter integer LEGS      = N,                     // N, and one more for each brushless motor; up to 12
    parameter integer PHASES    = 0,                     // 0...: bit n: leg n is one of a brushless motor's three
    parameter integer PORT_W    = (N > 1) ? $clog2(N) : 1, // these two are derived, leave them
    parameter integer LEG_W     = (LEGS > 1) ? $clog2(LEGS) : 1
) (
    input  wire                          clk,
    input  wire                          rst,

    // A turn's current.
    input  wire                          current_valid_i, // strobe
    input  wire [PORT_W-1:0]             current_port_i,  // of its settings
    input  wire [LEG_W-1:0]              current_leg_i,
    input  wire                          current_bank_i,
    input  wire signed [`WH_DATA_W-1:0]  current_i,       // s31q24 A, in the clock after

    // A turn's voltage.
    input  wire                          voltage_valid_i, // strobe
    input  wire [PORT_W-1:0]             voltage_port_i,
    input  wire                          voltage_bank_i,
    input  wire                          voltage_axis_i,  // it drives no leg
    input  wire signed [`WH_DATA_W-1:0]  voltage_i,       // s31q23 V: e_id
    output wire signed [`WH_DATA_W-1:0]  voltage_o,       // s31q23 V: e
    output wire signed [`WH_DATA_W-1:0]  correction_o,    // s31q23 V: c of it

    // A valid product, of a phase's voltage (wh_legs).
    input  wire                          duty_valid_i,    // strobe
    input  wire [LEG_W-1:0]              duty_leg_i,

    // The port anchor's correction (wh_anchor_ports).
    input  wire [N-1:0]                  correction_rst_i,   // it is 0 for these ports
    input  wire                          correction_valid_i, // strobe
    input  wire [PORT_W-1:0]             correction_port_i,
    input  wire signed [`WH_DATA_W-1:0]  correction_i,       // s31q23 V

    // Of all ports.
    input  wire [`WH_TICK_W-1:0]         half_clocks_i,   // clocks in a half, 6...
    input  wire                          compensate_i,    // the dead time
    input  wire [7:0]                    dead_clocks_i,   // clocks
    input  wire [7:0]                    settle_ticks_i,  // ticks between its changes of side
    input  wire                          second_order_i,  // error feedback of order 2
    input  wire [7:0]                    least_i,         // clocks, least width that isn't 0
    input  wire [7:0]                    spare_i,         // clocks

    // The register bus (wh_port_settings).
    input  wire                          write_i,
    input  wire                          write_bank_i,
    input  wire [11:0]                   address_i,
    input  wire [31:0]                   data_i,

    // The multiplier.
    output wire                          request_o,
    output wire signed [`WH_DATA_W-1:0]  factor_o,        // s31q23 V
    output wire signed [`WH_COEF_W-1:0]  coefficient_o,   // s27q16 clocks/V
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i, // s58q39 clocks, 3 clocks after request_o

    // Widths.
    input  wire                          walk_i,          // strobe
    input  wire                          half_i,          // with walk_i: also the phases
    input  wire                          take_i,          // with it
    output reg                           width_valid_o,   // strobe
    output reg  [LEG_W-1:0]              width_leg_o,
    output reg  signed [`WH_TICK_W-1:0]  width_o          // s16, clocks
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer PRODUCT_W = `WH_DATA_W + `WH_COEF_W;
    localparam integer FRACTION  = `WH_DUTY_Q;
    localparam integer DUTY_W    = PRODUCT_W - `WH_VOLTAGE_Q;   // s35q16
    localparam integer REST_W    = FRACTION + ((MIN_PULSE != 0) ? 9 : 1);     // s17q16
    localparam integer OWED_W    = `WH_EXTRA_W + FRACTION - `WH_EXTRA_Q
                                   + ((MIN_PULSE != 0) ? 2 : 1);              // s26q16
    localparam integer TOTAL_W   = DUTY_W + 1;                  // s36q16
    localparam integer ROUND_W   = TOTAL_W - FRACTION + 1;      // s21
    localparam integer LAST      = LEGS - 1;
    localparam integer PLACES    = 1 << LEG_W;

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_drive_n_must_be_1_to_8 stop ();
        end
        if (LEGS < N || LEGS > 12) begin : illegal_legs
            wh_illegal_parameter_drive_legs_must_be_n_to_12 stop ();
        end
        if (ROUND_W < `WH_TICK_W + 1) begin : illegal_format
            wh_illegal_WH_DATA_W_or_WH_COEF_W_too_small_for_a_pulse_width stop ();
        end
        if (MIN_PULSE != 0 && MIN_PULSE != 1) begin : illegal_min_pulse
            wh_illegal_parameter_drive_min_pulse_must_be_0_or_1 stop ();
        end
    endgenerate

    wire [PLACES-1:0] phases = PHASES[PLACES-1:0];

    // ---- The side of the dead time. -current is taken as ~current, one LSB less, which costs only inverters.
    reg               side_at_q;    // the clock after current_valid_i,
    reg               side_next_q;  // and the one after that
    reg  [LEG_W-1:0]  side_leg_q;
    wire [LEG_W-1:0]  walk_leg;
    wire [DATA_W-1:0] threshold;
    wire              negative_before, start_before;
    wire [7:0]        settle_before;
    wire              settled = (settle_before == 8'd0);
    wire [DATA_W-1:0] along   = current_i ^ {DATA_W{negative_before}};
    wire signed [DATA_W:0] beyond = $signed({along[DATA_W-1], along}) - $signed({threshold[DATA_W-1], threshold});
    reg               below_q;
    wire              turns   = below_q && settled;
    wire              unused_beyond = &{1'b0, beyond[DATA_W-1:0], start_before};

    always @(posedge clk) begin
        if (current_valid_i) begin
            side_leg_q  <= current_leg_i;
        end
        below_q     <= beyond[DATA_W];
        side_at_q   <= current_valid_i && !rst;
        side_next_q <= side_at_q && !rst;
    end

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (0),
        .W            (DATA_W),
        .FIRST        (26),
        .BLOCK        (0)
    ) thresholds (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (current_valid_i),
        .bank_i       (current_bank_i),
        .port_i       (current_port_i),
        .word_i       (1'b0),
        .word_o       (threshold)
    );

    // The turn changes it; the walk reads its effect on the width.
    wire       side_save = side_next_q && compensate_i;
    wire [9:0] side_next = {negative_before ^ turns, below_q,
                            turns ? settle_ticks_i : settled ? 8'd0 : settle_before - 8'd1};
    wire       negative, start;

    wh_port_state #(
        .N           (LEGS),
        .W           (10)
    ) side_state (
        .clk         (clk),
        .rst         (rst || !compensate_i),
        .port_i      (side_leg_q),
        .save_i      (side_save),
        .save_port_i (side_leg_q),
        .value_i     (side_next),
        .value_o     ({negative_before, start_before, settle_before})
    );

    wh_port_state #(
        .N           (LEGS),
        .W           (2)
    ) sign_state (
        .clk         (clk),
        .rst         (rst || !compensate_i),
        .port_i      (walk_leg),
        .save_i      (side_save),
        .save_port_i (side_leg_q),
        .value_i     (side_next[9:8]),
        .value_o     ({negative, start})
    );

    reg signed [`WH_EXTRA_W-1:0] most_q;  // s17q8 clocks
    reg signed [`WH_EXTRA_W-1:0] more_q;  // of a side that changed lately

    wire signed [`WH_EXTRA_W-1:0] most  = $signed({2'b00, dead_clocks_i, {`WH_EXTRA_Q-1{1'b0}}});
    wire signed [`WH_EXTRA_W-1:0] size  = start ? more_q : most_q;
    wire signed [`WH_EXTRA_W-1:0] extra = negative ? -size : size;

    always @(posedge clk) begin
        most_q <= compensate_i ? most : {`WH_EXTRA_W{1'b0}};
        more_q <= compensate_i ? most + (most >>> 2) : {`WH_EXTRA_W{1'b0}};
    end

    // ---- The voltage.
    reg                      ask_q;
    reg signed [DATA_W-1:0]  driven_q;
    reg        [LEG_W-1:0]   driven_leg_q;
    reg        [3:1]         asked_q;  // clocks since the product was requested
    wire signed [DATA_W-1:0] correction;
    wire [31:0]              voltage_leg = {{(32 - PORT_W){1'b0}}, voltage_port_i};
    wire                     unused_leg  = &{1'b0, voltage_leg[31:LEG_W]};

    wh_port_state #(
        .N           (N),
        .RESETS      (N),
        .W           (DATA_W)
    ) correction_state (
        .clk         (clk),
        .rst         (correction_rst_i),
        .port_i      (voltage_port_i),
        .save_i      (correction_valid_i),
        .save_port_i (correction_port_i),
        .value_i     (correction_i),
        .value_o     (correction)
    );

    assign correction_o = correction;

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_voltage (
        .value_i ($signed({voltage_i[DATA_W-1], voltage_i}) + $signed({correction[DATA_W-1], correction})),
        .value_o (voltage_o)
    );

    always @(posedge clk) begin
        if (voltage_valid_i) begin
            driven_q      <= voltage_o;
            driven_leg_q  <= voltage_leg[LEG_W-1:0];
        end
        ask_q   <= voltage_valid_i && !voltage_axis_i && !rst;
        asked_q <= rst ? 3'd0 : {asked_q[2:1], ask_q};
    end

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (0),
        .W            (`WH_COEF_W),
        .FIRST        (24),
        .BLOCK        (0)
    ) scales (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (voltage_valid_i),
        .bank_i       (voltage_bank_i),
        .port_i       (voltage_port_i),
        .word_i       (1'b0),
        .word_o       (coefficient_o)
    );

    assign request_o = ask_q;
    assign factor_o  = driven_q;

    // ---- Duties: a floor and wh_truncate's up, which the total takes as its carry. A new duty goes to the page
    // that isn't in force, and is in force once it is taken.
    wire signed [DUTY_W-1:0] duty_floor;
    wire                     duty_up;
    reg  [LEGS-1:0]          page_q;  // the page in force
    reg  [LEGS-1:0]          new_q;   // the other one waits to be taken
    wire                     made     = asked_q[3] || duty_valid_i;  // a duty
    wire [LEG_W-1:0]         made_leg = duty_valid_i ? duty_leg_i : driven_leg_q;
    wire signed [DUTY_W-1:0] duty_0, duty_1;
    wire                     up_0, up_1;

    wh_truncate #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (`WH_VOLTAGE_Q)
    ) truncate (
        .value_i (product_i),
        .floor_o (duty_floor),
        .up_o    (duty_up)
    );

    wh_port_state #(
        .N           (LEGS),
        .W           (DUTY_W + 1)
    ) duty_state_0 (
        .clk         (clk),
        .rst         (rst),
        .port_i      (walk_leg),
        .save_i      (made && page_q[made_leg]),
        .save_port_i (made_leg),
        .value_i     ({duty_floor, duty_up}),
        .value_o     ({duty_0, up_0})
    );

    wh_port_state #(
        .N           (LEGS),
        .W           (DUTY_W + 1)
    ) duty_state_1 (
        .clk         (clk),
        .rst         (rst),
        .port_i      (walk_leg),
        .save_i      (made && !page_q[made_leg]),
        .save_port_i (made_leg),
        .value_i     ({duty_floor, duty_up}),
        .value_o     ({duty_1, up_1})
    );

    always @(posedge clk) begin
        if (rst) begin
            page_q <= {LEGS{1'b0}};
            new_q  <= {LEGS{1'b0}};
        end else begin
            if (walk_i && take_i) begin
                page_q <= page_q ^ new_q;
                new_q  <= {LEGS{1'b0}};
            end
            if (made) begin
                new_q[made_leg] <= 1'b1;
            end
        end
    end

    // ---- The walk. walk_q[n]: the port of walk_port_q[n] is at its n-th clock.
    reg  [5:1]             walk_q;
    reg  [LEG_W-1:0]       port_1_q, port_2_q, port_3_q, port_4_q, port_5_q;
    reg                    half_q;
    wire signed [REST_W:0]   rests;    // s18q16
    wire signed [REST_W-1:0] older;    // s17q16, rest of the half before
    reg  signed [REST_W-1:0] older_2_q, older_3_q, older_4_q;
    reg  signed [REST_W-1:0] rest_5_q;
    reg  signed [REST_W:0]   rests_5_q;

    assign walk_leg = port_1_q;

    always @(posedge clk) begin
        if (rst) begin
            walk_q <= 5'd0;
        end else begin
            walk_q <= {walk_q[4:1], walk_i || (walk_q[1] && port_1_q != LAST[LEG_W-1:0])};
        end
        port_1_q <= walk_i ? {LEG_W{1'b0}} : port_1_q + 1'b1;
        half_q   <= walk_i ? half_i : half_q;
        port_2_q <= port_1_q;
        port_3_q <= port_2_q;
        port_4_q <= port_3_q;
        port_5_q <= port_4_q;
    end

    wh_port_state #(
        .N           (LEGS),
        .W           (2 * REST_W + 1)
    ) rests_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (walk_leg),
        .save_i      (walk_q[5] && (half_q || !phases[port_5_q])),
        .save_port_i (port_5_q),
        .value_i     ({rests_5_q, rest_5_q}),
        .value_o     ({rests, older})
    );

    // Clock 1: the rests. 2: the total. 3: the rounded one. 4: limits. 5: width and rests.
    localparam integer EXTRA_SIGN_W = OWED_W - `WH_EXTRA_W - FRACTION + `WH_EXTRA_Q;

    reg  signed [OWED_W-1:0]  owed_q;      // s26q16
    reg  signed [DUTY_W-1:0]  duty_q;      // s35q16
    reg                       up_q;
    reg  signed [TOTAL_W-1:0] total_q;     // s36q16 clocks
    reg  signed [ROUND_W-1:0] rounded_q;
    reg  signed [FRACTION:0]  rest_q;      // s17q16, +-1/2
    wire signed [ROUND_W-1:0] rounded;
    wire signed [OWED_W-1:0]  extra_long = $signed({{EXTRA_SIGN_W{extra[`WH_EXTRA_W-1]}}, extra,
                                                    {FRACTION-`WH_EXTRA_Q{1'b0}}});
    wire signed [OWED_W-1:0]  rests_long = $signed({{OWED_W-REST_W-1{rests[REST_W]}}, rests});
    wire signed [TOTAL_W:0]   sum        = $signed({duty_q[DUTY_W-1], duty_q, 1'b1})
                                           + $signed({{TOTAL_W-OWED_W{owed_q[OWED_W-1]}}, owed_q, up_q});
    wire                      unused_carry = &{1'b0, sum[0]};

    wh_round #(
        .IN_W    (TOTAL_W),
        .SHIFT   (FRACTION)
    ) round (
        .value_i (total_q),
        .value_o (rounded)
    );

    // Half of an odd half_clocks_i is rounded down. Legs that must stay longer than that have no pulse.
    reg  signed [`WH_TICK_W-1:0] limit_q;
    reg  signed [`WH_TICK_W-1:0] minus_limit_q;
    wire        [7:0]            spare      = (MIN_PULSE != 0) ? spare_i : 8'd0;
    wire signed [`WH_TICK_W-1:0] room       = $signed({1'b0, half_clocks_i[`WH_TICK_W-1:1]})
                                              - $signed({{`WH_TICK_W-8{1'b0}}, spare});
    wire signed [`WH_TICK_W-1:0] limit      = room[`WH_TICK_W-1] ? {`WH_TICK_W{1'b0}} : room;
    wire signed [ROUND_W-1:0]    limit_long = {{ROUND_W-`WH_TICK_W{1'b0}}, limit_q};
    wire signed [ROUND_W-1:0]    minus_long = $signed({{ROUND_W-`WH_TICK_W{minus_limit_q[`WH_TICK_W-1]}},
                                                       minus_limit_q});
    wire                         above      = rounded_q > limit_long;
    wire                         below      = rounded_q < minus_long;
    wire                         unused_odd = &{1'b0, half_clocks_i[0], least_i, spare_i};
    wire signed [`WH_TICK_W-1:0] bounded    = above ? limit_q : below ? minus_limit_q
                                            : $signed(rounded_q[`WH_TICK_W-1:0]);
    wire signed [REST_W-1:0]     rest_wide  = $signed({{REST_W-FRACTION{rest_q[FRACTION]}}, rest_q[FRACTION-1:0]});
    wire signed [`WH_TICK_W-1:0] chosen;
    wire                         clipped;
    wire signed [REST_W-1:0]     left;    // total - chosen

    // A width that is too short becomes 0 or least_i, as in wh_modulator.
    generate
        if (MIN_PULSE != 0) begin : minimum
            localparam integer CLOCKS_W = REST_W - FRACTION;

            reg         [7:0]            least_q;
            reg  signed [8:0]            minus_least_q;
            reg                          wide_q;        // least_i is longer than the limit
            reg  signed [`WH_TICK_W-1:0] size_q;
            reg  signed [`WH_TICK_W-1:0] minus_size_q;
            wire signed [ROUND_W-1:0]    least       = $signed({{ROUND_W-8{1'b0}}, least_q});
            wire signed [ROUND_W-1:0]    minus_least = $signed({{ROUND_W-9{minus_least_q[8]}}, minus_least_q});
            wire                         wide        = least > limit_long;

            always @(posedge clk) begin
                least_q       <= least_i;
                minus_least_q <= -$signed({1'b0, least_i});
                wide_q        <= wide;
                size_q        <= wide ? limit_q : $signed(least[`WH_TICK_W-1:0]);
                minus_size_q  <= wide ? minus_limit_q : $signed(minus_least[`WH_TICK_W-1:0]);
            end

            wire signed [ROUND_W:0]      twice   = $signed({rounded_q, 1'b0});
            wire                         short   = !phases[port_4_q] && rounded_q < least && rounded_q > minus_least;
            wire                         up      = twice >= $signed({1'b0, least});
            wire                         down    = twice <= $signed({minus_least[ROUND_W-1], minus_least});
            wire signed [`WH_TICK_W-1:0] instead = up ? size_q : down ? minus_size_q : {`WH_TICK_W{1'b0}};
            // total - chosen: its whole clocks, of which rest_q is one below where it is negative.
            wire signed [CLOCKS_W-1:0]   few     = $signed(rounded_q[CLOCKS_W-1:0])
                                                   + $signed({CLOCKS_W{rest_q[FRACTION]}});
            wire signed [CLOCKS_W-1:0]   taken   = $signed({{CLOCKS_W-8{1'b0}}, least_q});
            wire signed [CLOCKS_W-1:0]   clocks  = up ? few - taken : down ? few + taken : few;

            assign chosen  = short ? instead : bounded;
            assign clipped = short ? wide_q && (up || down) : above || below;
            assign left    = short ? $signed({clocks, rest_q[FRACTION-1:0]}) : rest_wide;
        end else begin : any_pulse
            assign chosen  = bounded;
            assign clipped = above || below;
            assign left    = rest_wide;
        end
    endgenerate

    wire signed [REST_W-1:0]     rest       = clipped ? {REST_W{1'b0}} : left;
    wire signed [REST_W:0]       rest_long  = $signed({rest[REST_W-1], rest});
    wire signed [REST_W:0]       older_long = $signed({older_4_q[REST_W-1], older_4_q});

    always @(posedge clk) begin
        limit_q       <= limit;
        minus_limit_q <= -limit;
        owed_q        <= rests_long + extra_long;
        duty_q        <= page_q[port_1_q] ? duty_1 : duty_0;
        up_q          <= page_q[port_1_q] ? up_1 : up_0;
        older_2_q     <= older;
        total_q       <= $signed(sum[TOTAL_W:1]);
        older_3_q     <= older_2_q;
        rounded_q     <= rounded;
        rest_q        <= $signed({rounded[0] ^ total_q[FRACTION], total_q[FRACTION-1:0]});
        older_4_q     <= older_3_q;
        rest_5_q      <= rest;
        rests_5_q     <= second_order_i ? (rest_long <<< 1) - older_long : rest_long;
        width_valid_o <= walk_q[4] && (half_q || !phases[port_4_q]) && !rst;
        width_leg_o   <= port_4_q;
        width_o       <= chosen;
    end

endmodule

`default_nettype wire
