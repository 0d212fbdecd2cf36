// SPDX-License-Identifier: Apache-2.0
//
// wh_brushless: the wave controller of one brushless motor from its pins to its pins: two ports of one
// wave core on three phases in star, and no angle in the way of the force.
//
//   two ADC lines -> wh_adc -> wh_current a, b -> wh_clarke -> wh_axes alpha, beta
//                 -> wh_inverse_clarke -> wh_three_phase -> six gates
//   encoder       -> wh_quadrature -> (wh_rotor_flux ->) wh_contact -> eta of both ports
//
// A positive current of a phase runs out of its leg into the motor; where the magnets lie the waves don't
// know. The encoder's count says only which wall the rotor is in. ANCHOR = 1: it says as well what it does
// to the flux of both axes, for their port anchors, which want zero_angle_i, the electrical angle at the
// position of the reset, or find it by the first movement. Both ports have the same words: what
// R and L are, they are along any direction. u_max_i is each axis' own; legs in the middle of the bus
// reach 2/(3 + √3) of it on both at once (docs/brushless.md).
//
// enable_i = 0 keeps the gates off and the wave core and the pulses in reset; ADC, currents and position
// run on, so that zero_i can be measured. enable_i is synchronous to clk.
// The settings may change as those of wh_controller do. anchor_hold_o is of both anchors, which have the same
// settings. All legs are driven by the clocks_per_volt_i of their step.
// The angles, and whether it is to be found, act from a reset or a magnet_start_i on.
//
// SENSE = 1: the words of both phases are checked (wh_sense_check), and a zero of each is measured on
// command with the gates off (wh_zero), to which zero_i is added.
//
// GUARD = 1: wh_guard watches three phases, the third as -a - b, in samples for its limit and in amperes
// for zero and heat. Its port u + v is that of alpha and beta, which turn with the rotor: a rotor that
// is lost is seen only while it keeps within half an electrical turn for so many ticks. What damps makes
// eta 0 on both axes. A third phase beyond the ADC's scale counts as a word at its end.
//
// Latency: the last sample of a tick reaches the gates with the next tick that ends
//     conversion + 80 + 10 SHAPER clocks
// after its sample strobe or later; a tick has 52 + 10 SHAPER clocks or more, in whole
// carrier periods.
// The gates show the carrier's phase after 2 clocks, dead time aside; CS_n falls 1 clock after the
// sample's phase.
// Reset: gates off at the next clock edge, CS_n high, f = 0, no contact, position 0.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_brushless #(
    parameter integer WALLS      = 4,  // 1...16
    parameter integer DELAY_LOG2 = 2,  // the delay line keeps 2^DELAY_LOG2 steps, 1...
    parameter integer MIN_PULSE  = 0,  // 1: min_pulse_i counts; 0: pulses may be of one clock
    parameter integer SHAPER     = 0,  // sections of W (wh_shaper), 0...2; 0: W = 1
    parameter integer DEAD_TIME  = 1,  // 1: dead time can be made good
    parameter integer SENSE      = 0,  // 1: sense checks and a measured zero; 0: their inputs mean nothing
    parameter integer ZERO_LOG2  = 10, // SENSE = 1: ticks of a zero, 2^ZERO_LOG2; 2...16
    parameter integer GUARD      = 0,  // 1: wh_guard watches; 0: its inputs mean nothing
    parameter integer ANCHOR     = 0,  // 1: port anchors; 0: their inputs mean nothing
    parameter integer SHAPE_BITS = ((SHAPER > 0) ? SHAPER : 1)  // derived, leave it
                                   * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W)
) (
    input  wire                         clk,
    input  wire                         rst,
    input  wire                         enable_i,

    // Pins.
    output wire                         adc_cs_n_o,
    output wire                         adc_sclk_o,
    input  wire [1:0]                   adc_sdata_i,         // phase a lowest
    input  wire                         enc_a_i,             // asynchronous
    input  wire                         enc_b_i,             // asynchronous
    output wire [2:0]                   gate_high_o,         // leg a lowest
    output wire [2:0]                   gate_low_o,

    // Carrier, tick and samples (wh_carrier).
    input  wire [`WH_TICK_W-1:0]        half_clocks_i,       // clocks in a carrier half
    input  wire [`WH_TICK_W-1:0]        tick_halves_i,       // halves in a tick, even
    input  wire [`WH_TICK_W-1:0]        sample_clocks_i,     // clocks from sample to sample
    input  wire [8:0]                   samples_i,           // samples in a tick, 1...256
    input  wire signed [7:0]            sample_lead_i,       // clocks that samples come early
    input  wire                         sample_late_i,       // a clock later in odd ticks

    // ADC frame (wh_adc_serial).
    input  wire [7:0]                   sclk_half_clocks_i,  // half a period of SCLK, clocks
    input  wire [5:0]                   frame_bits_i,        // pulses of SCLK
    input  wire [5:0]                   lead_bits_i,         // zeros
    input  wire [4:0]                   data_bits_i,         // data bits, 1...16
    input  wire [7:0]                   quiet_clocks_i,      // CS_n high, clocks
    input  wire [7:0]                   setup_clocks_i,      // CS_n to the first pulse, clocks
    input  wire [7:0]                   hold_clocks_i,       // last pulse to CS_n, clocks
    input  wire [5:0]                   calibrate_bits_i,    // pulses of the first frame; 0: none
    input  wire                         sclk_idle_i,         // SCLK between frames
    input  wire                         read_trailing_i,     // read at the end of a pulse

    // Currents of the phases a and b (wh_current), a lowest.
    input  wire [2*`WH_SUM_W-1:0]       zero_i,              // s24, a tick's sum at 0 A
    input  wire [15:0]                  range_i,             // of 2^15, end of the ADC's range
    // With SENSE = 1: the checks, and a zero measured on command, to which zero_i is added.
    input  wire [15:0]                  stuck_words_i,       // words that are never all the same
    input  wire                         zero_start_i,        // strobe; nothing while the bridge is on
    input  wire [`WH_SUM_W-2:0]         zero_limit_i,        // largest permitted |zero|
    input  wire [2*`WH_COEF_W-1:0]      gain_i,              // s27q35 A per unit of the sum
    input  wire [15:0]                  trip_i,              // of 2^15, full scale; more: never

    // Position and contact (wh_quadrature, wh_contact).
    input  wire [3:0]                   filter_clocks_i,     // samples that a level must hold
    input  wire [WALLS*`WH_COUNT_W-1:0] wall_min_i,          // s32, counts
    input  wire [WALLS*`WH_COUNT_W-1:0] wall_max_i,          // s32, counts
    input  wire [WALLS-1:0]             wall_enable_i,
    input  wire                         edge_hysteresis_i,   // walls are left one count later
    input  wire [`WH_COEF_W-1:0]        eta_contact_i,       // s27q25, in [-1, 1]
    input  wire [`WH_COEF_W-1:0]        eta_free_i,          // s27q25, in [-1, 1]

    // Wave core (wh_wave_core), both ports alike.
    input  wire [`WH_COEF_W-1:0]        root_i,              // s27q22 √Ω: √(2R̂), R̂ of a phase
    input  wire [`WH_COEF_W-1:0]        a_i,                 // s27q25, in (0, 1]
    input  wire [`WH_DATA_W-1:0]        u_max_i,             // s31q23 √W, of each axis
    input  wire [DELAY_LOG2-1:0]        extra_ticks_i,       // ticks
    input  wire [DELAY_LOG2-1:0]        hold_ticks_i,        // ticks

    // W of both axes (wh_shaper): its words, and the walls that feel so; in others it stands still.
    input  wire [SHAPE_BITS-1:0]        shape_words_i,
    input  wire [WALLS-1:0]             wall_shaped_i,

    // Port anchors (wh_anchor), and the rotor's flux (wh_rotor_flux).
    input  wire [`WH_ANCHOR_W-1:0]      anchor_words_i,
    input  wire [31:0]                  count_angle_i,       // turns of 2^32 by which a count turns the magnets
    input  wire [31:0]                  zero_angle_i,        // at the position of the reset, or of the start
    input  wire                         find_magnet_i,       // it isn't known: wh_magnet_angle finds it
    input  wire                         magnet_start_i,      // strobe, while enable_i = 0: begin anew with both

    // Drive (wh_three_phase).
    input  wire [7:0]                   min_pulse_i,         // clocks that a leg stays, or more
    input  wire [`WH_COEF_W-1:0]        clocks_per_volt_i,   // s27q16, half_clocks / bus
    input  wire [7:0]                   dead_clocks_i,       // clocks
    input  wire                         compensate_i,        // the dead time
    input  wire [`WH_DATA_W-1:0]        side_current_i,      // s31q24 A, 0...: where it has a side
    input  wire [7:0]                   settle_ticks_i,      // ticks between changes of side, ...249
    input  wire                         second_order_i,      // error feedback of order 2

    // Guard (wh_guard; wh_faults.vh has the fields and the faults).
    input  wire [`WH_GUARD_W-1:0]       guard_i,             // its settings
    input  wire                         clear_i,             // strobe: forget what is over
    input  wire                         stop_i,              // pin, asynchronous
    input  wire                         driver_fault_i,      // pin, asynchronous
    input  wire                         host_alive_i,        // strobe
    input  wire [`WH_BUS_W-1:0]         bus_i,               // u16q9 V
    output wire [`WH_FAULTS-1:0]        faults_o,            // latched
    output wire                         running_o,           // the bridge is on

    // What it sees and does; of two, alpha or a lowest.
    output wire                         adc_ready_o,         // the ADC is set up: ticks go on
    output wire                         tick_o,              // strobe, last clock of a tick
    output wire                         core_valid_o,        // strobe, the words below are new
    output wire [2*`WH_DATA_W-1:0]      voltage_o,           // s31q23 V, +-128 V: e to be applied
    output wire [2*`WH_DATA_W-1:0]      u_o,                 // s31q23 √W: u_n, measured tick
    output wire [2*`WH_DATA_W-1:0]      v_o,                 // s31q23 √W: v_n, measured tick
    output wire [2*`WH_DATA_W-1:0]      current_o,           // s31q24 A, +-64 A: i_n
    output wire [2*`WH_DATA_W-1:0]      phase_current_o,     // s31q24 A, of the phases a and b
    output wire [`WH_COUNT_W-1:0]       position_o,          // s32, counts
    output wire                         contact_o,
    output wire [1:0]                   saturated_o,         // the voltage limit was at work
    output wire [1:0]                   clipped_o,           // a sample, i_n or v_n at the end of its range
    output wire [2*`WH_DATA_W-1:0]      correction_o,        // s31q23 V: the anchors' part of e
    output wire [2*`WH_DATA_W-1:0]      offset_o,            // s31q24 A: what the anchors take off
    output wire [2*`WH_DATA_W-1:0]      flux_o,              // s31q16 cells: χ
    output wire [2*`WH_DATA_W-1:0]      lag_o,               // s31q16 cells: ω̂ over 256 ticks
    output wire                         magnet_found_o,      // the anchors have a say; until rst or
                                                             // magnet_start_i
    output wire [31:0]                  magnet_angle_o,      // electrical angle in the position's middle
    output wire                         anchor_fault_o,      // waves and encoder have parted; until rst or
                                                             // enable_i = 0
    output wire [1:0]                   adc_range_o,         // last word at the end of the scale
    output wire [1:0]                   adc_stuck_o,         // last stuck_words_i words the same
    output wire [1:0]                   zero_fault_o,        // no permitted zero was found
    output wire [1:0]                   zero_busy_o,         // a zero is being measured
    output wire [1:0]                   overcurrent_o,       // trip_i is reached, as long as it is
    output wire                         encoder_fault_o,     // illegal move seen; until clear_i
    // Its settings.
    input  wire                         restart_i,           // carrier and ADC begin anew, while the
                                                             // bridge is off; what was sampled before
                                                             // it is forgotten
    output wire [3:0]                   words_hold_o,        // settings are being read: see above
    output wire                         scale_hold_o,
    output wire                         anchor_hold_o,
    output wire                         overrun_o            // a tick is too short for its work, or ticks
                                                             // pass without; until rst or restart_i (core:
                                                             // or enable_i = 0)
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam integer WALL_W = (WALLS < 2) ? 1 : $clog2(WALLS);

    // Users of the shared multiplier.
    localparam integer OF_CURRENTS = 0;
    localparam integer OF_CLARKE   = 2;
    localparam integer OF_INVERSE  = 3;
    localparam integer OF_LEGS     = 4;
    localparam integer OF_ANCHORS  = 7;
    localparam integer USERS       = 9;

    generate
        if (GUARD != 0 && GUARD != 1) begin : illegal_guard
            wh_illegal_parameter_brushless_guard_must_be_0_or_1 stop ();
        end
        if (SENSE != 0 && SENSE != 1) begin : illegal_sense
            wh_illegal_parameter_brushless_sense_must_be_0_or_1 stop ();
        end
    endgenerate

    wire faulty;  // the guard wants the bridge off
    reg  off_q;
    wire damp;
    wire run       = enable_i && !faulty && !off_q;
    // As in wh_controller: what holds words knows of a fault a clock later.
    wire reading   = enable_i && !off_q;
    wire drive_rst = rst || !run;
    wire zero_begins = zero_start_i && !run && SENSE != 0;
    wire sense_restart = restart_i && !reading;
    wire sense_rst     = rst || sense_restart;

    always @(posedge clk) begin
        off_q <= faulty && !rst;
    end

    assign running_o = run;

    // ---- Carrier. The ticks begin when the ADC is ready.

    wire [`WH_TICK_W-1:0] phase;
    wire [`WH_TICK_W-1:0] remaining;
    wire                  half;
    wire                  update;
    wire                  take;
    wire                  sample;
    wire                  sample_first;

    wire last_half;
    wire unused_half = &{1'b0, last_half};

    wh_carrier carrier (
        .clk             (clk),
        .rst             (sense_rst || !adc_ready_o),
        .half_clocks_i   (half_clocks_i),
        .tick_halves_i   (tick_halves_i),
        .sample_clocks_i (sample_clocks_i),
        .samples_i       (samples_i),
        .sample_lead_i   (sample_lead_i),
        .sample_late_i   (sample_late_i),
        .phase_o         (phase),
        .remaining_o     (remaining),
        .half_o          (half),
        .update_o        (update),
        .take_o          (take),
        .last_half_o     (last_half),
        .tick_o          (tick_o),
        .sample_o        (sample),
        .sample_first_o  (sample_first)
    );

    // ---- One multiplier for the currents, both transforms and the legs. A user's reset drops its
    // products, or one of before would be taken for one of after.

    wire        [USERS-1:0]         request;
    wire        [USERS*DATA_W-1:0]  factor;
    wire        [USERS*COEF_W-1:0]  coefficient;
    wire        [USERS-1:0]         grant;
    wire        [USERS-1:0]         done;
    wire signed [DATA_W+COEF_W-1:0] product;

    wh_multiply_shared #(
        .USERS     (USERS)
    ) multiply_shared (
        .clk       (clk),
        .rst       (rst),
        .drop_i    ({{(USERS - OF_INVERSE){drive_rst}}, {OF_INVERSE{sense_rst}}}),
        .request_i (request),
        .data_i    (factor),
        .coef_i    (coefficient),
        .grant_o   (grant),
        .done_o    (done),
        .product_o (product)
    );

    // ---- Currents of the phases, and of the axes. Those of a tick come in turn, so b's starts the
    // transform.

    wire                      adc_din;
    wire                      adc_valid;
    wire                      adc_first;
    wire [2*`WH_SAMPLE_W-1:0] adc_sample;
    wire                      adc_overrun;
    wire                      unused_adc = &{1'b0, adc_din};

    wh_adc #(
        .LINES              (2)
    ) adc (
        .clk                (clk),
        .rst                (rst),
        .restart_i          (sense_restart),
        .adc_cs_n_o         (adc_cs_n_o),
        .adc_sclk_o         (adc_sclk_o),
        .adc_din_o          (adc_din),
        .adc_sdata_i        (adc_sdata_i),
        .sclk_half_clocks_i (sclk_half_clocks_i),
        .frame_bits_i       (frame_bits_i),
        .lead_bits_i        (lead_bits_i),
        .data_bits_i        (data_bits_i),
        .quiet_clocks_i     (quiet_clocks_i),
        .setup_clocks_i     (setup_clocks_i),
        .hold_clocks_i      (hold_clocks_i),
        .calibrate_bits_i   (calibrate_bits_i),
        .sclk_idle_i        (sclk_idle_i),
        .read_trailing_i    (read_trailing_i),
        .trip_i             (trip_i),
        .start_i            (sample),
        .first_i            (sample_first),
        .ready_o            (adc_ready_o),
        .valid_o            (adc_valid),
        .first_o            (adc_first),
        .sample_o           (adc_sample),
        .trip_o             (overcurrent_o),
        .overrun_o          (adc_overrun)
    );

    wire [1:0] current_valid;
    wire [3:0] phase_ends;

    genvar n;
    generate
        for (n = 0; n < 2; n = n + 1) begin : phase_of
            wire signed [`WH_SAMPLE_W-1:0] word  = $signed(adc_sample[n*`WH_SAMPLE_W +: `WH_SAMPLE_W]);
            wire signed [`WH_SUM_W-1:0]    given = $signed(zero_i[n*`WH_SUM_W +: `WH_SUM_W]);
            wire signed [`WH_SUM_W-1:0]    zero;

            if (SENSE != 0) begin : sense
                wire                        zero_done;
                wire                        measured;
                wire signed [`WH_SUM_W-1:0] measured_zero;
                wire                        unused = &{1'b0, zero_done, measured};

                // Both are signed, and one more bit holds their sum. What is measured is 0 at first.
                wh_saturate #(
                    .IN_W    (`WH_SUM_W + 1),
                    .OUT_W   (`WH_SUM_W)
                ) saturate_zero (
                    .value_i ({measured_zero[`WH_SUM_W-1], measured_zero}
                              + {given[`WH_SUM_W-1], given}),
                    .value_o (zero)
                );

                wh_sense_check sense_check (
                    .clk           (clk),
                    .rst           (rst),
                    .valid_i       (adc_valid),
                    .sample_i      (word),
                    .range_i       (range_i),
                    .stuck_words_i (stuck_words_i),
                    .range_o       (adc_range_o[n]),
                    .stuck_o       (adc_stuck_o[n])
                );

                wh_zero #(
                    .LOG2_TICKS    (ZERO_LOG2)
                ) measure_zero (
                    .clk           (clk),
                    .rst           (rst),
                    .valid_i       (adc_valid),
                    .first_i       (adc_first),
                    .sample_i      (word),
                    .start_i       (zero_begins),
                    .bridge_off_i  (!run),
                    .limit_i       (zero_limit_i),
                    .busy_o        (zero_busy_o[n]),
                    .done_o        (zero_done),
                    .measured_o    (measured),
                    .zero_o        (measured_zero),
                    .fault_o       (zero_fault_o[n])
                );
            end else begin : plain
                wire unused = &{1'b0, stuck_words_i, zero_begins, zero_limit_i};

                assign zero            = given;
                assign adc_range_o[n]  = 1'b0;
                assign adc_stuck_o[n]  = 1'b0;
                assign zero_fault_o[n] = 1'b0;
                assign zero_busy_o[n]  = 1'b0;
            end

            wh_current current (
                .clk        (clk),
                .rst        (sense_rst),
                .valid_i    (adc_valid),
                .first_i    (adc_first),
                .sample_i   (word),
                .samples_i  (samples_i),
                .range_i    (range_i),
                .zero_i     (zero),
                .request_o  (request[OF_CURRENTS+n]),
                .grant_i    (grant[OF_CURRENTS+n]),
                .factor_o   (factor[(OF_CURRENTS+n)*DATA_W +: DATA_W]),
                .done_i     (done[OF_CURRENTS+n]),
                .product_i  (product),
                .offset_i   ({DATA_W{1'b0}}),
                .valid_o    (current_valid[n]),
                .current_o  (phase_current_o[n*DATA_W +: DATA_W]),
                .ends_o     (phase_ends[2*n +: 2])
            );

            assign coefficient[(OF_CURRENTS+n)*COEF_W +: COEF_W] = gain_i[n*COEF_W +: COEF_W];
        end
    endgenerate

    // The third phase's is what the other two leave, a clock after b's. Two bits more hold their sum,
    // and what it is negated.
    wire signed [DATA_W-1:0] current_a = $signed(phase_current_o[DATA_W-1:0]);
    wire signed [DATA_W-1:0] current_b = $signed(phase_current_o[2*DATA_W-1:DATA_W]);
    wire signed [DATA_W+1:0] wide_current = -$signed({{2{current_a[DATA_W-1]}}, current_a})
                                            - $signed({{2{current_b[DATA_W-1]}}, current_b});
    wire signed [DATA_W-1:0] saturated_c;
    reg  signed [DATA_W-1:0] current_c_q;
    reg                      valid_c_q;

    wh_saturate #(
        .IN_W    (DATA_W + 2),
        .OUT_W   (DATA_W)
    ) saturate_current (
        .value_i (wide_current),
        .value_o (saturated_c)
    );

    always @(posedge clk) begin
        valid_c_q <= current_valid[1] && !rst;
        if (current_valid[1]) begin
            current_c_q <= saturated_c;
        end
    end

    wire                core_start;
    wire [2*DATA_W-1:0] axes_current;
    wire [1:0]          beta_ends;

    wh_clarke clarke (
        .clk           (clk),
        .rst           (sense_rst),
        .valid_i       (current_valid[1]),
        .a_i           (phase_current_o[DATA_W-1:0]),
        .b_i           (phase_current_o[2*DATA_W-1:DATA_W]),
        .request_o     (request[OF_CLARKE]),
        .grant_i       (grant[OF_CLARKE]),
        .factor_o      (factor[OF_CLARKE*DATA_W +: DATA_W]),
        .coefficient_o (coefficient[OF_CLARKE*COEF_W +: COEF_W]),
        .done_i        (done[OF_CLARKE]),
        .product_i     (product),
        .valid_o       (core_start),
        .alpha_o       (axes_current[DATA_W-1:0]),
        .beta_o        (axes_current[2*DATA_W-1:DATA_W]),
        .beta_ends_o   (beta_ends)
    );

    // ---- Position and contact. Nothing is read of it in a step's first clock, in which it may still
    // change: a clock between any two steps, even where the next starts as one ends.

    wire                          moved;
    wire                          illegal_move;
    wire                          direction;
    wire        [7:0]             encoder_faults;
    wire                          core_busy;
    wire                          in_round;
    wire        [WALL_W-1:0]      wall;
    wire                          wall_shaped;
    wire signed [`WH_COUNT_W-1:0] depth;
    wire        [COEF_W-1:0]      contact_eta;
    wire signed [`WH_COUNT_W-1:0] counted;
    wire [2*(`WH_PLACE_W+`WH_SINE_Q)-1:0] place;
    wire [2*(`WH_SINE_Q+2)-1:0]   last_cell;
    wire                          turn;
    wire [31:0]                   turn_by;
    wire                          turned;
    wire                          unused_contact = &{1'b0, direction, encoder_faults, wall, depth};

    wh_quadrature quadrature (
        .clk             (clk),
        .rst             (rst),
        .a_i             (enc_a_i),
        .b_i             (enc_b_i),
        .filter_clocks_i (filter_clocks_i),
        .clear_i         (clear_i),
        .position_o      (counted),
        .moved_o         (moved),
        .direction_o     (direction),
        .illegal_o       (illegal_move),
        .fault_o         (encoder_fault_o),
        .faults_o        (encoder_faults)
    );

    // Who finds the magnets begins a clock later, at the position that the flux then has.
    wire magnet_start = magnet_start_i && !reading;
    reg  magnet_start_q;

    always @(posedge clk) begin
        magnet_start_q <= magnet_start && !rst;
    end

    generate
        if (ANCHOR == 1) begin : with_its_flux
            wh_rotor_flux rotor_flux (
                .clk           (clk),
                .rst           (rst || magnet_start),
                .position_i    (counted),
                .count_angle_i (count_angle_i),
                .zero_angle_i  (zero_angle_i),
                .turn_i        (turn),
                .by_i          (turn_by),
                .turned_o      (turned),
                .angle_o       (magnet_angle_o),
                .position_o    (position_o),
                .place_o       (place),
                .cell_o        (last_cell)
            );
        end else begin : alone
            wire unused_angle = &{1'b0, zero_angle_i, turn, turn_by, magnet_start};

            assign turned         = 1'b0;
            assign magnet_angle_o = 32'd0;

            assign position_o = counted;
            assign place      = {2*(`WH_PLACE_W+`WH_SINE_Q){1'b0}};
            assign last_cell  = {2*(`WH_SINE_Q+2){1'b0}};
        end
    endgenerate

    wh_contact #(
        .WALLS         (WALLS)
    ) contact (
        .clk           (clk),
        .rst           (rst),
        .position_i    (position_o),
        .hold_i        (core_busy),
        .wall_min_i    (wall_min_i),
        .wall_max_i    (wall_max_i),
        .wall_enable_i (wall_enable_i),
        .wall_shaped_i (wall_shaped_i),
        .hysteresis_i  (edge_hysteresis_i),
        .eta_contact_i (eta_contact_i),
        .eta_free_i    (eta_free_i),
        .round_o       (in_round),
        .contact_o     (contact_o),
        .wall_o        (wall),
        .shaped_o      (wall_shaped),
        .depth_o       (depth),
        .eta_o         (contact_eta)
    );

    // ---- Ports of both axes, with the same words and the same eta.

    wire                core_overrun;
    wire                core_reads;
    wire                anchors_read;
    wire                anchors_busy;
    wire [2*DATA_W-1:0] next_correction;
    wire                unused_axes = &{1'b0, next_correction, anchors_busy};

    wh_axes #(
        .DELAY_LOG2     (DELAY_LOG2),
        .SHAPER         (SHAPER),
        .ANCHOR         (ANCHOR)
    ) axes (
        .clk            (clk),
        .rst            (drive_rst),
        .damp_i         (damp),
        .start_i        (core_start),
        .busy_o         (core_busy),
        .reads_o        (core_reads),
        .anchor_busy_o  (anchors_busy),
        .anchor_reads_o (anchors_read),
        .valid_o        (core_valid_o),
        .overrun_o      (core_overrun),
        .current_i      (axes_current),
        .ends_i         ({phase_ends[3:2] | phase_ends[1:0] | beta_ends, phase_ends[1:0]}),
        .eta_i          (contact_eta),
        .root_i         (root_i),
        .a_i            (a_i),
        .u_max_i        (u_max_i),
        .extra_ticks_i  (extra_ticks_i),
        .hold_ticks_i   (hold_ticks_i),
        .shape_words_i  (shape_words_i),
        .shaped_i       (wall_shaped),
        .position_i     (position_o),
        .place_i        (place),
        .cell_i         (last_cell),
        .contact_i      (contact_o),
        .anchor_words_i (anchor_words_i),
        .angle_rst_i    (rst || magnet_start_q),
        .find_magnet_i  (find_magnet_i),
        .count_angle_i  (count_angle_i),
        .turn_o         (turn),
        .by_o           (turn_by),
        .turned_i       (turned),
        .magnet_found_o (magnet_found_o),
        .voltage_o      (voltage_o),
        .current_o      (current_o),
        .u_o            (u_o),
        .v_o            (v_o),
        .saturated_o    (saturated_o),
        .clipped_o      (clipped_o),
        .correction_o   (correction_o),
        .next_o         (next_correction),
        .offset_o       (offset_o),
        .flux_o         (flux_o),
        .lag_o          (lag_o),
        .anchor_fault_o (anchor_fault_o),
        .request_o      (request[OF_ANCHORS +: 2]),
        .factor_o       (factor[OF_ANCHORS*DATA_W +: 2*DATA_W]),
        .coefficient_o  (coefficient[OF_ANCHORS*COEF_W +: 2*COEF_W]),
        .grant_i        (grant[OF_ANCHORS +: 2]),
        .done_i         (done[OF_ANCHORS +: 2]),
        .product_i      (product)
    );

    // Currents are made, and steps asked for, while the drive is off as well.
    wire missing;

    wh_step_watch step_watch (
        .clk       (clk),
        .rst       (sense_rst),
        .start_i   (core_start),
        .tick_i    (tick_o),
        .overrun_o (missing)
    );

    assign overrun_o = adc_overrun || core_overrun || missing;

    // ---- Who reads settings. Those of the sum are read until the last product of both currents has begun;
    // what scales voltages is read with core_valid_o, behind the clocks in which the core reads none any more.
    wire summed = |request[OF_CURRENTS +: 2];
    reg  sum_q;

    always @(posedge clk) begin
        sum_q <= run && (adc_valid || (sum_q && !summed));
    end

    assign words_hold_o  = {in_round, reading && (adc_valid || sum_q || summed), anchor_hold_o,
                            reading && core_reads};
    assign scale_hold_o  = reading && core_busy && !core_reads;
    assign anchor_hold_o = reading && anchors_read;

    // ---- Drive. All legs have the word of their step, whose products come after it.

    wire                legs_valid;
    wire [3*DATA_W-1:0] legs;
    reg  [COEF_W-1:0]   clocks_per_volt_q;

    always @(posedge clk) begin
        if (core_valid_o) begin
            clocks_per_volt_q <= clocks_per_volt_i;
        end
    end

    wh_inverse_clarke inverse_clarke (
        .clk           (clk),
        .rst           (drive_rst),
        .valid_i       (core_valid_o),
        .alpha_i       (voltage_o[DATA_W-1:0]),
        .beta_i        (voltage_o[2*DATA_W-1:DATA_W]),
        .request_o     (request[OF_INVERSE]),
        .grant_i       (grant[OF_INVERSE]),
        .factor_o      (factor[OF_INVERSE*DATA_W +: DATA_W]),
        .coefficient_o (coefficient[OF_INVERSE*COEF_W +: COEF_W]),
        .done_i        (done[OF_INVERSE]),
        .product_i     (product),
        .valid_o       (legs_valid),
        .legs_o        (legs)
    );

    wh_three_phase #(
        .MIN_PULSE         (MIN_PULSE),
        .DEAD_TIME         (DEAD_TIME)
    ) three_phase (
        .clk               (clk),
        .rst               (rst),
        .enable_i          (run),
        .half_clocks_i     (half_clocks_i),
        .phase_i           (phase),
        .remaining_i       (remaining),
        .half_i            (half),
        .update_i          (update),
        .take_i            (take),
        .clocks_per_volt_i (clocks_per_volt_q),
        .min_pulse_i       (min_pulse_i),
        .dead_clocks_i     (dead_clocks_i),
        .second_order_i    (second_order_i),
        .compensate_i      (compensate_i),
        .side_current_i    (side_current_i),
        .settle_ticks_i    (settle_ticks_i),
        .current_valid_i   ({valid_c_q, current_valid}),
        .currents_i        ({current_c_q, phase_current_o}),
        .valid_i           (legs_valid),
        .legs_i            (legs),
        .request_o         (request[OF_LEGS +: 3]),
        .grant_i           (grant[OF_LEGS +: 3]),
        .factor_o          (factor[OF_LEGS*DATA_W +: 3*DATA_W]),
        .coefficient_o     (coefficient[OF_LEGS*COEF_W +: 3*COEF_W]),
        .done_i            (done[OF_LEGS +: 3]),
        .product_i         (product),
        .gate_high_o       (gate_high_o),
        .gate_low_o        (gate_low_o)
    );

    // ---- Guard. A sample of the third phase is what the other two leave, too, a clock later.

    generate
        if (GUARD != 0) begin : guarded
            localparam integer SAMPLE_W = `WH_SAMPLE_W;

            wire signed [SAMPLE_W-1:0] sample_a = $signed(adc_sample[SAMPLE_W-1:0]);
            wire signed [SAMPLE_W-1:0] sample_b = $signed(adc_sample[2*SAMPLE_W-1:SAMPLE_W]);
            wire signed [SAMPLE_W+1:0] wide_sample =
                -$signed({{2{sample_a[SAMPLE_W-1]}}, sample_a})
                - $signed({{2{sample_b[SAMPLE_W-1]}}, sample_b});
            wire signed [SAMPLE_W-1:0] sample_c;
            reg  signed [SAMPLE_W-1:0] sample_c_q;
            reg                        sampled_q;
            wire                       illegal_setting;
            wire        [7:0]          spare = (min_pulse_i >> 1) + {7'd0, min_pulse_i[0]};

            always @(posedge clk) begin
                sampled_q  <= adc_valid && !rst;
                sample_c_q <= sample_c;
            end

            wh_saturate #(
                .IN_W    (SAMPLE_W + 2),
                .OUT_W   (SAMPLE_W)
            ) saturate_sample (
                .value_i (wide_sample),
                .value_o (sample_c)
            );

            wh_setting_check #(
                .N                 (2)
            ) setting_check (
                .clk               (clk),
                .rst               (rst),
                .half_clocks_i     (half_clocks_i),
                .tick_halves_i     (tick_halves_i),
                .sample_clocks_i   (sample_clocks_i),
                .samples_i         (samples_i),
                .sample_lead_i     (sample_lead_i),
                .sample_late_i     (sample_late_i),
                .whole_i           (1'b1),
                .least_i           (8'd0),
                .spare_i           ((MIN_PULSE != 0) ? spare : 8'd0),
                .dead_clocks_i     (dead_clocks_i),
                .compensate_i      (compensate_i && DEAD_TIME != 0),
                .compensable_i     (1'b1),
                .root_i            ({2{root_i}}),
                .a_i               ({2{a_i}}),
                .eta_contact_i     ({2{eta_contact_i}}),
                .eta_free_i        ({2{eta_free_i}}),
                .gain_i            (gain_i),
                .clocks_per_volt_i ({2{clocks_per_volt_i}}),
                .u_max_i           ({2{u_max_i}}),
                .illegal_o         (illegal_setting)
            );

            wh_guard #(
                .N              (3)
            ) guard (
                .clk            (clk),
                .rst            (rst),
                .settings_i     (guard_i),
                .clear_i        (clear_i),
                .running_i      (run),
                .stop_i         (stop_i),
                .driver_i       ({3{driver_fault_i}}),
                .host_alive_i   (host_alive_i),
                .bus_i          (bus_i),
                .sample_valid_i (sampled_q),
                .sample_i       ({sample_c_q, adc_sample}),
                .range_i        ({1'b0, adc_range_o}),
                .stuck_i        ({1'b0, adc_stuck_o}),
                .zero_i         ({1'b0, zero_fault_o}),
                .zero_start_i   (zero_begins),
                .zero_busy_i    (|zero_busy_o),
                .trip_i         ({1'b0, overcurrent_o}),
                .encoder_i      ({2'd0, illegal_move}),
                .moved_i        ({3{moved}}),
                .anchor_i       ({2'd0, anchor_fault_o}),
                .energy_i       (3'd0),
                .setting_i      (illegal_setting),
                .overrun_i      (overrun_o),
                .tick_i         (tick_o),
                .valid_i        (valid_c_q),
                .current_i      ({current_c_q, phase_current_o}),
                .u_i            ({{DATA_W{1'b0}}, u_o}),
                .v_i            ({{DATA_W{1'b0}}, v_o}),
                .faults_o       (faults_o),
                .off_o          (faulty),
                .damp_o         (damp)
            );
        end else begin : unguarded
            wire unused_guard = &{1'b0, guard_i, stop_i, driver_fault_i, host_alive_i, bus_i, moved,
                                  illegal_move};

            assign faults_o = {`WH_FAULTS{1'b0}};
            assign faulty   = 1'b0;
            assign damp     = 1'b0;
        end
    endgenerate

endmodule

`default_nettype wire
