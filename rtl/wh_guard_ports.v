// SPDX-License-Identifier: Apache-2.0
//
// wh_guard_ports: wh_guard for N ports, which take turns.
//
//   faults = (faults, unless clear_i) or (causes and mask)
//   off    = any fault that doesn't damp;  damp = any fault, if none switches off
//
// It behaves like wh_guard; that header has the causes, what ends them, and what a clear needs. wh_sense judges the
// samples. ZERO, LOST, SATURATED and HEAT are judged in the port's turn.
//
// The turn, in clocks since valid_i, which comes with current_i: 1, its magnitude; 2, the previous turn's u + v
// and limit are judged, and which counts came since; 15, the product i_n^2 is requested, if this period has a square;
// no other station may request then. waves_valid_i, in between, comes one clock before this turn's u_i and v_i are
// valid. The next valid_i may come 20 clocks after this one.
//
// State, by port: u + v and whether the limit acts (18 bits), the mean of u + v (25), the periods of turning (17), the
// turns back and the time since (21), the heat (48) in LUT RAM (wh_port_state); one bit for each judgement.
// Formats, latency: as wh_guard, but HEAT comes 19 clocks after its current. Reset: no fault, counts and heat 0.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_guard_ports #(
    parameter integer N      = 1,                        // ports, and third phases of brushless motors, 1...12
    parameter integer PORT_W = (N > 1) ? $clog2(N) : 1   // derived, leave it
) (
    input  wire                       clk,
    input  wire                       rst,

    input  wire [`WH_GUARD_W-1:0]     settings_i,      // wh_faults.vh
    input  wire                       clear_i,         // strobe
    input  wire                       running_i,       // the bridges are on

    input  wire                       stop_i,          // pin, asynchronous
    input  wire [N-1:0]               driver_i,        // pins, asynchronous
    input  wire                       host_alive_i,    // strobe
    input  wire [`WH_BUS_W-1:0]       bus_i,           // u16q9 V

    // Found outside.
    input  wire [N-1:0]               current_cause_i, // these three: of the last samples (wh_sense)
    input  wire [N-1:0]               range_cause_i,
    input  wire [N-1:0]               stuck_cause_i,
    input  wire [N-1:0]               range_i,         // also these, with limits of wh_sense
    input  wire [N-1:0]               stuck_i,
    input  wire [N-1:0]               zero_i,          // no permitted zero was found
    input  wire                       zero_start_i,    // strobe: a zero is measured
    input  wire                       zero_busy_i,     // from the next clock to the end of that
    input  wire [N-1:0]               trip_i,
    input  wire [N-1:0]               encoder_i,       // strobe, illegal move
    input  wire [N-1:0]               moved_i,         // strobe, a count,
    input  wire [N-1:0]               direction_i,     // and its direction
    input  wire [N-1:0]               anchor_i,        // waves and counts don't agree
    input  wire [N-1:0]               energy_i,        // more than a contact's limit
    input  wire                       overspeed_i,     // these two of any port (wh_motion)
    input  wire                       outside_i,
    input  wire                       setting_i,       // illegal setting
    input  wire                       overrun_i,

    input  wire                       tick_i,          // strobe

    // A turn.
    input  wire                       valid_i,         // strobe
    input  wire [PORT_W-1:0]          port_i,
    input  wire signed [`WH_DATA_W-1:0] current_i,     // s31q24 A
    input  wire                       waves_valid_i,   // strobe, a clock before u_i and v_i
    input  wire signed [`WH_DATA_W-1:0] u_i,           // s31q23 √W
    input  wire signed [`WH_DATA_W-1:0] v_i,           // s31q23 √W
    input  wire                       saturated_i,     // with waves_valid_i: the voltage limit acts in contact

    // The multiplier.
    output wire                       request_o,
    output wire signed [`WH_DATA_W-1:0] factor_o,
    output wire signed [`WH_COEF_W-1:0] coefficient_o,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i, // 3 clocks after request_o

    output reg  [`WH_FAULTS-1:0]      faults_o,
    output reg                        off_o,
    output wire                       damp_o
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer MEAN_LOG2 = 8;  // of u + v

    generate
        if (N < 1 || N > 12) begin : illegal
            wh_illegal_parameter_guard_ports_n_must_be_1_to_12 stop ();
        end
    endgenerate

    wire begins = valid_i && port_i == {PORT_W{1'b0}};  // a round

    wire unused_settings = &{1'b0, settings_i[`WH_GUARD_CURRENT], settings_i[`WH_GUARD_RANGE],
                             settings_i[`WH_GUARD_STUCK]};

    // ---- Pins.

    wire         stop;
    wire [N-1:0] driver;
    wire [1:0]   levels = settings_i[`WH_GUARD_LEVELS];

    wh_synchroniser #(
        .WIDTH   (N + 1)
    ) synchroniser (
        .clk     (clk),
        .level_i ({driver_i, stop_i}),
        .level_o ({driver, stop})
    );

    // ---- The host, in ticks.

    reg  [23:0] silent_q;
    wire        silent = silent_q >= settings_i[`WH_GUARD_HOST];

    always @(posedge clk) begin
        if (rst || host_alive_i) begin
            silent_q <= 24'd0;
        end else if (tick_i && !silent) begin
            silent_q <= silent_q + 24'd1;
        end
    end

    // ---- Ticks since the bridge went off.

    reg  [15:0] rest_q;
    wire        rested = rest_q >= settings_i[`WH_GUARD_ZERO_TICKS];

    always @(posedge clk) begin
        if (rst || running_i) begin
            rest_q <= 16'd0;
        end else if (tick_i && !rested) begin
            rest_q <= rest_q + 16'd1;
        end
    end

    // ---- Periods, as a round begins, until the currents use the measured zero.

    localparam [1:0] OLD_TICKS = 2'd2;

    reg  [1:0] old_q;
    wire       stands = !zero_start_i && !zero_busy_i && (old_q == 2'd0);

    always @(posedge clk) begin
        if (rst) begin
            old_q <= 2'd0;
        end else if (zero_busy_i) begin
            old_q <= OLD_TICKS;
        end else if (begins && !stands) begin
            old_q <= old_q - 2'd1;
        end
    end

    // ---- Periods from one square to the next.

    reg  [15:0] pace_q;
    wire        square = (pace_q == 16'd0);
    wire [15:0] pace   = settings_i[`WH_GUARD_HEAT_TICKS];

    always @(posedge clk) begin
        if (rst) begin
            pace_q <= 16'd0;
        end else if (begins) begin
            pace_q <= !square ? pace_q - 16'd1 : (pace == 16'd0) ? 16'd0 : pace - 16'd1;
        end
    end

    // ---- The turn: at_q[n] is clock n of it.
    localparam integer GIVE = 15;  // i_n^2
    localparam integer HEAT = GIVE + 3;

    reg [HEAT:1]     at_q;
    reg [PORT_W-1:0] port_q;
    reg              square_q; // of this round

    always @(posedge clk) begin
        if (valid_i) begin
            port_q <= port_i;
        end
        if (begins) begin
            square_q <= square;
        end
        at_q   <= rst ? {HEAT{1'b0}} : {at_q[HEAT-1:1], valid_i};
    end

    // ---- Current with the bridge off, in its 16 highest bits: u16q9 A. A judgement ends with the next one,
    // when the bridge goes on, or with a new zero.
    wire signed [15:0] current = $signed(current_i[DATA_W-1 -: 16]);
    wire               unused_current = &{1'b0, current_i[DATA_W-17:0]};
    reg         [15:0] size_q;
    reg         [N-1:0] zero_q;

    always @(posedge clk) begin
        if (valid_i) begin
            size_q <= current[15] ? -current : current;
        end
        if (rst || running_i || !stands) begin
            zero_q <= {N{1'b0}};
        end else if (at_q[1]) begin
            zero_q[port_q] <= rested && size_q > settings_i[`WH_GUARD_ZERO];
        end
    end

    wire zero_cause = stands && !running_i && (|zero_q);

    // ---- u + v against the counts, of the previous turn, as the anchor's fault.
    wire signed [15:0] u_high = $signed(u_i[DATA_W-1 -: 16]);
    wire signed [15:0] v_high = $signed(v_i[DATA_W-1 -: 16]);
    wire               unused_waves = &{1'b0, u_i[DATA_W-17:0], v_i[DATA_W-17:0]};
    wire signed [16:0] both;
    reg                waves_q;
    reg                saturated_q;
    wire               limits;   // it acted
    wire signed [16:0] sum_now  = $signed({u_high[15], u_high}) + $signed({v_high[15], v_high});
    wire               turn_rst = rst || !running_i;

    always @(posedge clk) begin
        waves_q     <= waves_valid_i && !turn_rst;
        saturated_q <= saturated_i;
    end

    wh_port_state #(
        .N           (N),
        .W           (18)
    ) waves_state (
        .clk         (clk),
        .rst         (turn_rst),
        .port_i      (port_q),
        .save_i      (waves_q),
        .save_port_i (port_q),
        .value_i     ({saturated_q, sum_now}),
        .value_o     ({limits, both})
    );

    wire signed [16+MEAN_LOG2:0] sum;       // it forgets 2^-MEAN_LOG2 a turn
    wire signed [16:0]           limit    = $signed({1'b0, settings_i[`WH_GUARD_LOST]});
    wire signed [16:0]           turning  = $signed(sum[16+MEAN_LOG2:MEAN_LOG2]);
    wire                         forward  = turning > limit;
    wire                         backward = turning < -limit;
    reg  [N-1:0]                 moved_q;       // since the port's last turn
    reg                          moved_now_q;   // of the previous clock, as the others below
    wire                         negative_before;
    wire [15:0]                  still_before;  // turns with a turning rotor, less those without
    reg                          negative_q;
    reg  [15:0]                  still_q;
    wire                         negative = !moved_now_q && negative_q;
    wire [15:0]                  still    = moved_now_q ? 16'd0 : still_q;
    reg                          forward_q;
    reg                          backward_q;
    wire [15:0]                  next     =
        (negative ? backward_q : forward_q) ? ((still == 16'hffff) ? still : still + 16'd1)
                                            : ((still == 16'd0) ? still : still - 16'd1);

    // Rotors that turn back, as in wh_guard; the turns back at the limit, in a row, and periods since the last one.
    reg  [N-1:0] newest_q;
    reg  [N-1:0] way_q;
    wire [N-1:0] again = moved_i & ~(direction_i ^ newest_q);
    wire [N-1:0] turns = again & (direction_i ^ way_q);
    reg  [N-1:0] turned_q;      // since the port's last turn
    reg          turned_now_q;  // of the previous clock, as these
    reg          limits_q;
    reg          late_q;
    reg  [4:0]   swings_q;
    reg  [15:0]  since_q;
    wire [4:0]   swings;
    wire [15:0]  since;
    wire [4:0]   more_swings  = !limits_q ? 5'd0 : swings_q[4] ? swings_q : swings_q + 5'd1;

    reg signed [16+MEAN_LOG2:0] kept_q;  // the part of the sum that is kept

    always @(posedge clk) begin
        moved_now_q <= moved_q[port_q];
        forward_q  <= forward;
        backward_q <= backward;
        negative_q <= negative_before;
        still_q    <= still_before;
        turned_now_q <= turned_q[port_q];
        limits_q   <= limits;
        late_q     <= since >= settings_i[`WH_GUARD_SATURATED];
        swings_q   <= swings;
        since_q    <= since;
        kept_q     <= sum - $signed({{MEAN_LOG2{turning[16]}}, turning});
    end

    wh_port_state #(
        .N           (N),
        .W           (17 + MEAN_LOG2)
    ) turning_state (
        .clk         (clk),
        .rst         (turn_rst),
        .port_i      (port_q),
        .save_i      (at_q[2]),
        .save_port_i (port_q),
        .value_i     (kept_q + $signed({{MEAN_LOG2{both[16]}}, both})),
        .value_o     (sum)
    );

    wh_port_state #(
        .N           (N),
        .W           (17)
    ) still_state (
        .clk         (clk),
        .rst         (turn_rst),
        .port_i      (port_q),
        .save_i      (at_q[3]),
        .save_port_i (port_q),
        .value_i     ({(still == 16'd0) ? backward_q : negative, next}),
        .value_o     ({negative_before, still_before})
    );

    wh_port_state #(
        .N           (N),
        .W           (21)
    ) swings_state (
        .clk         (clk),
        .rst         (turn_rst),
        .port_i      (port_q),
        .save_i      (at_q[3]),
        .save_port_i (port_q),
        .value_i     ({turned_now_q ? more_swings : late_q ? 5'd0 : swings_q,
                       turned_now_q ? 16'd0 : late_q ? since_q : since_q + 16'd1}),
        .value_o     ({swings, since})
    );

    reg [N-1:0] lost_q;
    reg [N-1:0] swinging_q;

    always @(posedge clk) begin
        if (rst) begin
            newest_q <= {N{1'b0}};
            way_q    <= {N{1'b0}};
        end else begin
            newest_q <= (moved_i & direction_i) | (~moved_i & newest_q);
            way_q    <= (again & direction_i) | (~again & way_q);
        end
    end

    always @(posedge clk) begin
        moved_q <= moved_q | moved_i;
        if (at_q[2]) begin
            moved_q[port_q] <= moved_i[port_q];
        end
        lost_q  <= lost_q & ~moved_i;
        turned_q <= turned_q | turns;
        if (at_q[2]) begin
            turned_q[port_q] <= turns[port_q];
        end
        if (at_q[4]) begin
            lost_q[port_q] <= still_before >= settings_i[`WH_GUARD_LOST_TICKS] && still_before != 16'd0;
            swinging_q[port_q] <= swings[4] && |settings_i[`WH_GUARD_SATURATED];
        end
        if (turn_rst) begin
            moved_q <= {N{1'b0}};
            lost_q  <= {N{1'b0}};
            turned_q   <= {N{1'b0}};
            swinging_q <= {N{1'b0}};
        end
    end

    // ---- The winding's heat, u48q34 A^2 with the time constant's factor.
    wire [31+`WH_GUARD_HEAT_LOG2:0] heat;
    wire [31:0]                     mean = heat[31+`WH_GUARD_HEAT_LOG2:`WH_GUARD_HEAT_LOG2];
    wire                            unused_product = &{1'b0, product_i[DATA_W+`WH_COEF_W-1:32]};
    reg  [N-1:0]                    heat_q;
    // The turn's heat is judged two clocks after it was saved.
    reg  [31+`WH_GUARD_HEAT_LOG2:0] cooled_q;
    reg  [31:0]                     mean_q;
    reg  [1:0]                      judge_q;

    always @(posedge clk) begin
        cooled_q <= heat - {{`WH_GUARD_HEAT_LOG2{1'b0}}, mean};
        mean_q   <= mean;
    end

    assign request_o     = at_q[GIVE] && square_q;
    assign factor_o      = $signed({{DATA_W-16{1'b0}}, size_q});
    assign coefficient_o = $signed({{`WH_COEF_W-16{1'b0}}, size_q});

    wh_port_state #(
        .N           (N),
        .W           (32 + `WH_GUARD_HEAT_LOG2)
    ) heat_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_q),
        .save_i      (at_q[HEAT] && square_q),
        .save_port_i (port_q),
        .value_i     (cooled_q + {{`WH_GUARD_HEAT_LOG2{1'b0}}, product_i[31:0]}),
        .value_o     (heat)
    );

    always @(posedge clk) begin
        judge_q <= {judge_q[0], at_q[HEAT]} & {2{!rst}};
        if (rst) begin
            heat_q <= {N{1'b0}};
        end else if (judge_q[1]) begin
            heat_q[port_q] <= mean_q > settings_i[`WH_GUARD_HEAT];
        end
    end

    // ---- The latch.

    wire [`WH_FAULTS-1:0] causes;

    assign causes[`WH_FAULT_CURRENT]   = |current_cause_i;
    assign causes[`WH_FAULT_TRIP]      = |trip_i;
    assign causes[`WH_FAULT_ADC_STUCK] = |stuck_cause_i || |stuck_i;
    assign causes[`WH_FAULT_ADC_RANGE] = |range_cause_i || |range_i;
    assign causes[`WH_FAULT_ZERO]      = zero_cause || (|zero_i && !zero_start_i && !zero_busy_i);  // of all ports
    assign causes[`WH_FAULT_ENCODER]   = |encoder_i;
    assign causes[`WH_FAULT_LOST]      = |lost_q;
    assign causes[`WH_FAULT_HOST]      = silent;
    assign causes[`WH_FAULT_DRIVER]    = |(driver ~^ {N{levels[1]}});
    assign causes[`WH_FAULT_STOP]      = stop == levels[0];
    assign causes[`WH_FAULT_BUS_LOW]   = bus_i < settings_i[`WH_GUARD_BUS_MIN];
    assign causes[`WH_FAULT_BUS_HIGH]  = bus_i > settings_i[`WH_GUARD_BUS_MAX];
    assign causes[`WH_FAULT_HEAT]      = |heat_q;
    assign causes[`WH_FAULT_SETTING]   = setting_i;
    assign causes[`WH_FAULT_OVERRUN]   = overrun_i;
    assign causes[`WH_FAULT_ANCHOR]    = |anchor_i;
    assign causes[`WH_FAULT_ENERGY]    = |energy_i && |settings_i[`WH_GUARD_ENERGY];
    assign causes[`WH_FAULT_SATURATED] = |swinging_q;
    assign causes[`WH_FAULT_OVERSPEED] = overspeed_i;
    assign causes[`WH_FAULT_WINDOW]    = outside_i;
    assign causes[`WH_FAULTS-1:`WH_FAULT_WINDOW+1] = {`WH_FAULTS-1-`WH_FAULT_WINDOW{1'b0}};

    // off_o is computed beside the faults, not from them, as everything that it stops depends on it in the same clock.
    wire [`WH_FAULTS-1:0] zero   = zero_start_i ? ({{`WH_FAULTS-1{1'b0}}, 1'b1} << `WH_FAULT_ZERO)
                                                : {`WH_FAULTS{1'b0}};
    wire [`WH_FAULTS-1:0] faults = (clear_i ? {`WH_FAULTS{1'b0}} : faults_o & ~zero)
                                   | (causes & settings_i[`WH_GUARD_MASK]);

    always @(posedge clk) begin
        if (rst) begin
            faults_o <= {`WH_FAULTS{1'b0}};
            off_o    <= 1'b0;
        end else begin
            faults_o <= faults;
            off_o    <= |(faults & ~(settings_i[`WH_GUARD_DAMP] & `WH_FAULTS_DAMPABLE));
        end
    end

    assign damp_o = |faults_o && !off_o;

endmodule

`default_nettype wire
