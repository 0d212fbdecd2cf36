// SPDX-License-Identifier: Apache-2.0
//
// wh_guard: latches every fault, and stops the bridges until a command clears it.
//
//   faults = (faults, unless clear_i) or (causes and mask)
//   off    = any fault that doesn't damp;  damp = any fault, if none switches off
//
// A cause is a level: the last judgement of a sample or a current stays valid until the next one. So clear_i keeps a
// fault whose cause lasts, and one that arises in its own clock. A fault damps if its bit of DAMP is 1 and the current
// can still be trusted (WH_FAULTS_DAMPABLE in wh_faults.vh, which names the bits and the settings' fields). off_o
// switches the gates off one clock after the fault is latched. damp_o makes η = 0 everywhere: a damper k_T² / R, with
// nothing stored once f has decayed.
//
// Causes, each for any motor:
//   CURRENT, ADC_RANGE   |sample| > limit, each sample by itself
//   ADC_STUCK            a number of consecutive samples are identical; real ones have noise
//   ZERO                 |current| > limit after the bridge has been off for a number of ticks
//   LOST                 |u + v| = 2 |e - R̂ i| / s > limit, as a mean of about 256 ticks, with one sign, in a number
//                        of ticks more than without, and no count: the back-EMF shows motion, the encoder doesn't
//   HOST                 a number of ticks without host_alive_i
//   BUS_LOW, BUS_HIGH    bus_i outside its limits
//   HEAT                 h > limit, h += (i² - h) / 2^16 every so many ticks (0 counts as 1): a winding with a time
//                        constant of 2^16 squares
//   SETTING              an illegal setting, found outside (setting_i)
//   ENERGY               a contact delivered more than its limit (wh_energy); a limit of 0: no check
//   SATURATED            the rotor turned back 16 times in a row, each time in contact at the voltage limit
//                        (saturated_i), and within a number of ticks of the last time; 0: no check. A turn back is two
//                        counts in a row against the way so far
//   OVERSPEED, WINDOW    a rotor too fast, or outside its interval (overspeed_i, outside_i)
//   OVERRUN              a tick too short for its work, or ticks without a step (overrun_i)
//   ENCODER              an illegal move, a strobe from outside
//   the others           inputs; stop_i and driver_i pass synchronisers here
//
// The start of a zero measurement, zero_start_i, also clears ZERO; the measurement's result decides anew. With the
// bridge off, the current isn't judged while a zero is measured, nor in the ticks that had begun by then.
//
// LOST, ANCHOR, ENERGY, SATURATED and a core's OVERRUN need a bridge that is on. So their causes are over once it is
// off or damped, and return if they last. OVERRUN of an ADC's reader, or of ticks without a step, lasts until rst. All
// others end with their cause.
//
// Formats: in wh_faults.vh and below. Latency: a level is latched in the next clock (pins: 2 clocks later), and one
// clock after that off_o has switched the gates off (wh_half_bridge). A measured value is judged in the clock after it:
// a sample, a tick's current, or, for HEAT, 18 clocks after it.
// Reset: no fault, counts and heat 0.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_guard #(
    parameter integer N = 1  // motors, 1...8
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

    input  wire                       sample_valid_i,  // strobe
    input  wire [N*`WH_SAMPLE_W-1:0]  sample_i,        // s16
    input  wire [N-1:0]               range_i,         // these three found outside
    input  wire [N-1:0]               stuck_i,
    input  wire [N-1:0]               zero_i,          // no permitted zero was found
    input  wire                       zero_start_i,    // strobe: a zero is measured
    input  wire                       zero_busy_i,     // from the next clock on, until it is
    input  wire [N-1:0]               trip_i,
    input  wire [N-1:0]               encoder_i,       // strobe, illegal move
    input  wire [N-1:0]               moved_i,         // a count,
    input  wire [N-1:0]               direction_i,     // and its direction
    input  wire [N-1:0]               anchor_i,        // waves and counts don't agree
    input  wire [N-1:0]               energy_i,        // more than a contact's limit
    input  wire [N-1:0]               saturated_i,     // of a tick's step: the voltage limit acts in contact
    input  wire                       overspeed_i,     // these two of any motor (wh_motion)
    input  wire                       outside_i,
    input  wire                       setting_i,       // illegal word
    input  wire                       overrun_i,

    input  wire                       tick_i,          // strobe
    input  wire                       valid_i,         // strobe: current_i, u_i, v_i are a tick's
    input  wire [N*`WH_DATA_W-1:0]    current_i,       // s31q24 A
    input  wire [N*`WH_DATA_W-1:0]    u_i,             // s31q23 √W
    input  wire [N*`WH_DATA_W-1:0]    v_i,             // s31q23 √W

    output reg  [`WH_FAULTS-1:0]      faults_o,
    output reg                        off_o,
    output wire                       damp_o
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer MEAN_LOG2 = 8;  // of u + v

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_guard_n_must_be_1_to_8 stop ();
        end
    endgenerate

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

    // ---- Ticks until currents are made with the zero that was measured.

    localparam [1:0] OLD_TICKS = 2'd2;

    reg  [1:0] old_q;
    wire       stands = !zero_start_i && !zero_busy_i && (old_q == 2'd0);

    always @(posedge clk) begin
        if (rst) begin
            old_q <= 2'd0;
        end else if (zero_busy_i) begin
            old_q <= OLD_TICKS;
        end else if (valid_i && !stands) begin
            old_q <= old_q - 2'd1;
        end
    end

    // ---- Ticks from one square to the next.

    reg  [15:0] pace_q;
    wire        square = valid_i && pace_q == 16'd0;
    wire [15:0] pace   = settings_i[`WH_GUARD_HEAT_TICKS];

    always @(posedge clk) begin
        if (rst) begin
            pace_q <= 16'd0;
        end else if (valid_i) begin
            pace_q <= !square ? pace_q - 16'd1 : (pace == 16'd0) ? 16'd0 : pace - 16'd1;
        end
    end

    // ---- Rotors that turn back: two counts in a row against the way so far.

    reg  [N-1:0] newest_q;  // direction of the last count
    reg  [N-1:0] way_q;     // and of the last two that had the same
    wire [N-1:0] again = moved_i & ~(direction_i ^ newest_q);
    wire [N-1:0] turns = again & (direction_i ^ way_q);

    always @(posedge clk) begin
        if (rst) begin
            newest_q <= {N{1'b0}};
            way_q    <= {N{1'b0}};
        end else begin
            newest_q <= (moved_i & direction_i) | (~moved_i & newest_q);
            way_q    <= (again & direction_i) | (~again & way_q);
        end
    end

    // ---- Each motor's.

    wire [N-1:0] current_cause;
    wire [N-1:0] range_cause;
    wire [N-1:0] stuck_cause;
    wire [N-1:0] zero_cause;
    wire [N-1:0] lost_cause;
    wire [N-1:0] heat_cause;
    wire [N-1:0] saturated_cause;

    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : motor

            // Samples.
            wire signed [`WH_SAMPLE_W-1:0] sample = sample_i[n*`WH_SAMPLE_W +: `WH_SAMPLE_W];
            reg         [`WH_SAMPLE_W-1:0] sample_size_q;
            reg         [`WH_SAMPLE_W-1:0] last_q;
            reg         [15:0]             same_q;         // 0: none has come

            always @(posedge clk) begin
                if (rst) begin
                    sample_size_q <= {`WH_SAMPLE_W{1'b0}};
                    last_q        <= {`WH_SAMPLE_W{1'b0}};
                    same_q        <= 16'd0;
                end else if (sample_valid_i) begin
                    sample_size_q <= sample[`WH_SAMPLE_W-1] ? -sample : sample;
                    last_q        <= sample;
                    if (sample != last_q) begin
                        same_q <= 16'd1;
                    end else if (same_q != 16'hffff) begin
                        same_q <= same_q + 16'd1;
                    end
                end
            end

            assign current_cause[n] = sample_size_q > settings_i[`WH_GUARD_CURRENT];
            assign range_cause[n]   = sample_size_q > settings_i[`WH_GUARD_RANGE];
            assign stuck_cause[n]   = same_q != 16'd0 && same_q >= settings_i[`WH_GUARD_STUCK];

            // Current, in its 16 highest bits: u16q9 A.
            wire signed [15:0] current = $signed(current_i[n*DATA_W + DATA_W - 1 -: 16]);
            reg         [15:0] current_size_q;
            reg                measured_q;
            wire               unused_current = &{1'b0, current_i[n*DATA_W +: DATA_W - 16]};

            always @(posedge clk) begin
                measured_q     <= !rst && valid_i;
                current_size_q <= current[15] ? -current : current;
            end

            // A judgement ends with the next, as the bridge goes on, or with a new zero.
            wire zero_judged = rested && !running_i
                               && current_size_q > settings_i[`WH_GUARD_ZERO];
            reg  zero_q;

            always @(posedge clk) begin
                if (rst || running_i || !stands) begin
                    zero_q <= 1'b0;
                end else if (measured_q) begin
                    zero_q <= zero_judged;
                end
            end

            assign zero_cause[n] = stands && (measured_q ? zero_judged : zero_q && !running_i);

            // u + v against the counts.
            wire signed [15:0] u_high = $signed(u_i[n*DATA_W + DATA_W - 1 -: 16]);
            wire signed [15:0] v_high = $signed(v_i[n*DATA_W + DATA_W - 1 -: 16]);
            wire               unused_waves = &{1'b0, u_i[n*DATA_W +: DATA_W - 16],
                                                v_i[n*DATA_W +: DATA_W - 16]};
            reg  signed [16+MEAN_LOG2:0] turning_q;  // sum that forgets 2^-MEAN_LOG2 a tick
            reg                negative_q;
            reg         [15:0] still_q;   // ticks of turning, less those of not
            wire signed [16:0] limit    = $signed({1'b0, settings_i[`WH_GUARD_LOST]});
            wire signed [16:0] turning  = $signed(turning_q[16+MEAN_LOG2:MEAN_LOG2]);
            wire               forward  = turning > limit;
            wire               backward = turning < -limit;

            always @(posedge clk) begin
                if (rst || !running_i) begin
                    turning_q <= {17+MEAN_LOG2{1'b0}};
                end else if (measured_q) begin
                    turning_q <= turning_q
                                 + $signed({{MEAN_LOG2+1{u_high[15]}}, u_high})
                                 + $signed({{MEAN_LOG2+1{v_high[15]}}, v_high})
                                 - $signed({{MEAN_LOG2{turning[16]}}, turning});
                end
                if (rst || !running_i || moved_i[n]) begin
                    still_q    <= 16'd0;
                    negative_q <= 1'b0;
                end else if (measured_q) begin
                    if (still_q == 16'd0) begin
                        negative_q <= backward;
                    end
                    if (negative_q ? backward : forward) begin
                        still_q <= (still_q == 16'hffff) ? still_q : still_q + 16'd1;
                    end else begin
                        still_q <= (still_q == 16'd0) ? still_q : still_q - 16'd1;
                    end
                end
            end

            assign lost_cause[n] = still_q >= settings_i[`WH_GUARD_LOST_TICKS]
                                   && still_q != 16'd0;

            // Turns back at the voltage limit, in a row, and ticks since the last one.
            reg        turned_q;  // since the last tick
            reg [4:0]  swings_q;
            reg [15:0] since_q;
            wire       late = since_q >= settings_i[`WH_GUARD_SATURATED];

            always @(posedge clk) begin
                if (rst || !running_i) begin
                    turned_q <= 1'b0;
                    swings_q <= 5'd0;
                    since_q  <= 16'd0;
                end else begin
                    turned_q <= turns[n] || (turned_q && !measured_q);
                    if (measured_q) begin
                        since_q  <= turned_q ? 16'd0 : late ? since_q : since_q + 16'd1;
                        swings_q <= turned_q ? (!saturated_i[n] ? 5'd0 : swings_q[4] ? swings_q : swings_q + 5'd1)
                                             : late ? 5'd0 : swings_q;
                    end
                end
            end

            assign saturated_cause[n] = swings_q[4] && |settings_i[`WH_GUARD_SATURATED];

            // i², a bit a clock, and the winding's heat.
            reg  [31:0] square_q;
            reg  [31:0] addend_q;
            reg  [15:0] factor_q;
            reg  [4:0]  step_q;    // 17...1 at work
            reg  [31+`WH_GUARD_HEAT_LOG2:0] heat_q;  // u48q34 A² with the time constant's factor

            wire [31:0] heat = heat_q[31+`WH_GUARD_HEAT_LOG2:`WH_GUARD_HEAT_LOG2];

            always @(posedge clk) begin
                if (rst) begin
                    step_q <= 5'd0;
                    heat_q <= {32+`WH_GUARD_HEAT_LOG2{1'b0}};
                end else if (square) begin
                    step_q <= 5'd18;
                end else if (step_q != 5'd0) begin
                    step_q <= step_q - 5'd1;
                    if (step_q == 5'd1) begin
                        heat_q <= heat_q + {{`WH_GUARD_HEAT_LOG2{1'b0}}, square_q}
                                  - {{`WH_GUARD_HEAT_LOG2{1'b0}}, heat};
                    end
                end
                if (step_q == 5'd18) begin
                    square_q <= 32'd0;
                    addend_q <= {16'd0, current_size_q};
                    factor_q <= current_size_q;
                end else begin
                    square_q <= factor_q[0] ? square_q + addend_q : square_q;
                    addend_q <= addend_q << 1;
                    factor_q <= factor_q >> 1;
                end
            end

            assign heat_cause[n] = heat > settings_i[`WH_GUARD_HEAT];
        end
    endgenerate

    // ---- The latch.

    wire [`WH_FAULTS-1:0] causes;

    assign causes[`WH_FAULT_CURRENT]   = |current_cause;
    assign causes[`WH_FAULT_TRIP]      = |trip_i;
    assign causes[`WH_FAULT_ADC_STUCK] = |stuck_cause || |stuck_i;
    assign causes[`WH_FAULT_ADC_RANGE] = |range_cause || |range_i;
    assign causes[`WH_FAULT_ZERO]      = |zero_cause || (|zero_i && !zero_start_i);
    assign causes[`WH_FAULT_ENCODER]   = |encoder_i;
    assign causes[`WH_FAULT_LOST]      = |lost_cause;
    assign causes[`WH_FAULT_HOST]      = silent;
    assign causes[`WH_FAULT_DRIVER]    = |(driver ~^ {N{levels[1]}});
    assign causes[`WH_FAULT_STOP]      = stop == levels[0];
    assign causes[`WH_FAULT_BUS_LOW]   = bus_i < settings_i[`WH_GUARD_BUS_MIN];
    assign causes[`WH_FAULT_BUS_HIGH]  = bus_i > settings_i[`WH_GUARD_BUS_MAX];
    assign causes[`WH_FAULT_HEAT]      = |heat_cause;
    assign causes[`WH_FAULT_SETTING]   = setting_i;
    assign causes[`WH_FAULT_OVERRUN]   = overrun_i;
    assign causes[`WH_FAULT_ANCHOR]    = |anchor_i;
    assign causes[`WH_FAULT_ENERGY]    = |energy_i && |settings_i[`WH_GUARD_ENERGY];
    assign causes[`WH_FAULT_SATURATED] = |saturated_cause;
    assign causes[`WH_FAULT_OVERSPEED] = overspeed_i;
    assign causes[`WH_FAULT_WINDOW]    = outside_i;
    assign causes[`WH_FAULTS-1:`WH_FAULT_WINDOW+1] = {`WH_FAULTS-1-`WH_FAULT_WINDOW{1'b0}};

    // off_o is made beside the faults and not of them: all that it stops hangs on it in the same clock.
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
