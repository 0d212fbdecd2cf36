// SPDX-License-Identifier: Apache-2.0
//
// wh_controller: the wave controller from its pins to its pins, for N motors.
//
//   ADC bits -> wh_adc_serial -> wh_current -> wh_wave_core -> wh_modulator -> wh_pwm -> gates
//   encoder  -> wh_quadrature -> wh_contact -> eta ---^            wh_carrier times everything
//
// A positive current runs into the motor from bridge leg A and out to leg B; a positive voltage has
// leg A high while leg B is low; a positive position is where a positive current turns the rotor.
//
// enable_i = 0 keeps the gates off and the wave core and the pulse width in reset; the ADC, the
// currents and the positions run on, so that zero_i can be measured. enable_i is synchronous to
// clk.
// The settings may change only in reset; or, the table of words says which, while enable_i = 0, with
// restart_i = 1 in the meantime, or with the end of a clock in which their bit of words_hold_o is low:
// 0 the core, or with EARLY = 1 wh_early, reads them; 1 an anchor; 2 a sum is under way; 3 a round of
// the walls. From the clock after that in which the bridges went off only the last one ever is 1. The core needs
// a tick of a clock more than its steps take, or bit 0 is never low.
//
// Latency: the gates show the carrier's phase after 2 clocks, dead time aside, and CS_n falls 1
// clock after the sample's phase: sample_lead_i = -1 samples in the pulse's middle, and half the
// dead time less samples in the middle of what dead time makes of the pulse. The last sample
// of a tick reaches the gates with the next tick that ends
//     conversion + 14 + (24 + 5 SHAPER) N + 2 (N - 1) + ANCHOR clocks
// after its sample strobe or later, conversion being the reader's own latency (latency_clocks in
// sim/wavehaptics/controller/pins_timing.py).
// With EARLY = 1 it is conversion + 10 clocks, for a conversion of 18 clocks or more and a tick of
// 22 + 25 N or more; with ANCHOR = 1 as well 35 + 25 N (early_tick_clocks).
// Reset: gates off at the next clock edge, CS_n high, f = 0, no contact, position 0.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_controller #(
    parameter integer N          = 1,  // motors, 1...8
    parameter integer WALLS      = 4,  // walls of each, 1...16
    parameter integer DELAY_LOG2 = 2,  // the delay line keeps 2^DELAY_LOG2 steps, 1...
    parameter integer ADC        = 0,  // reader: 0 wh_adc_serial, 1 wh_adc_max11125, 2 wh_sinc3
    parameter integer OSR        = 32, // ADC = 2: bits a word, 4...256
    parameter integer CAPTURE_RISE = 0, // ADC = 2: take bits as the clock rises, not as it falls
    parameter integer TRIP_OSR   = 8,  // ADC = 2: half the bits of the fast path, 2, 4, 8, 16, 32
    parameter integer SENSE      = 0,  // 1: sense checks and a measured zero (wh_sense_check, wh_zero)
    parameter integer ZERO_LOG2  = 10, // SENSE = 1: ticks of a zero, 2^ZERO_LOG2; 2...16
    parameter integer SHAPER     = 0,  // sections of W (wh_shaper), 0...2; 0: W = 1
    parameter integer DEAD_TIME  = 1,  // 1: dead time can be compensated
    parameter integer EARLY      = 0,  // 1: wh_early makes the duty; SHAPER and hold_ticks_i are 0
    parameter integer MODES      = 0,  // 1: mode_i chooses the bridge's pattern; 0: unipolar
    parameter integer MIN_PULSE  = 0,  // 1: min_pulse_i counts; 0: pulses may be of one clock
    parameter integer BUS        = 0,  // 1: bus_i scales the drive; 0: clocks_per_volt_i does
    parameter integer HOST       = 0,  // 1: a computer can have the environment (wh_host_link)
    parameter integer ANCHOR     = 0,  // 1: the port anchor holds what a port feels like (wh_anchor)
    parameter integer GUARD      = 0,  // 1: wh_guard watches; 0: its inputs mean nothing
    parameter integer SHAPE_BITS = N * ((SHAPER > 0) ? SHAPER : 1)  // derived, leave it
                                   * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W)
) (
    input  wire                         clk,
    input  wire                         rst,
    input  wire                         enable_i,

    // Pins.
    output wire                         adc_cs_n_o,
    output wire                         adc_sclk_o,
    output wire                         adc_din_o,           // ADC = 1: commands
    input  wire [N-1:0]                 adc_sdata_i,         // ADC = 1: bit 0, from one part
    input  wire [N-1:0]                 enc_a_i,             // asynchronous
    input  wire [N-1:0]                 enc_b_i,             // asynchronous
    output wire [N-1:0]                 gate_ah_o,
    output wire [N-1:0]                 gate_al_o,
    output wire [N-1:0]                 gate_bh_o,
    output wire [N-1:0]                 gate_bl_o,

    // Carrier, tick and samples (wh_carrier).
    input  wire [`WH_TICK_W-1:0]        half_clocks_i,       // clocks in a carrier half
    input  wire [`WH_TICK_W-1:0]        tick_halves_i,       // halves in a tick
    input  wire [`WH_TICK_W-1:0]        sample_clocks_i,     // clocks from sample to sample
    input  wire [8:0]                   samples_i,           // samples in a tick, 1...256
    input  wire signed [7:0]            sample_lead_i,       // clocks that samples come early
    input  wire                         sample_late_i,       // a clock later in odd ticks

    // ADC frame (wh_adc_serial; sim/wavehaptics/parts/adcs.py has the parts' words).
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

    // Fast path of the current: the last word, or with ADC = 2 a filter of its own.
    input  wire [15:0]                  trip_i,              // of 2^15, full scale; more: never

    // Current (wh_current).
    input  wire [N*`WH_SUM_W-1:0]       zero_i,              // s24, a tick's sum at 0 A
    // With SENSE = 1: the checks, and a zero measured on command, to which zero_i is added.
    input  wire [15:0]                  range_i,             // of 2^15, end of the scale
    input  wire [15:0]                  stuck_words_i,       // words that are never all the same
    input  wire                         zero_start_i,        // strobe, while enable_i = 0
    input  wire [`WH_SUM_W-2:0]         zero_limit_i,        // largest permitted |zero|
    input  wire [N*`WH_COEF_W-1:0]      gain_i,              // s27q35 A per unit of the sum

    // Position and contact (wh_quadrature, wh_contact).
    input  wire [3:0]                   filter_clocks_i,     // samples that a level must hold
    input  wire [N*WALLS*`WH_COUNT_W-1:0] wall_min_i,        // s32, counts
    input  wire [N*WALLS*`WH_COUNT_W-1:0] wall_max_i,        // s32, counts
    input  wire [N*WALLS-1:0]           wall_enable_i,
    input  wire [N-1:0]                 edge_hysteresis_i,   // walls are left one count later
    input  wire [N*`WH_COEF_W-1:0]      eta_contact_i,       // s27q25, in [-1, 1]
    input  wire [N*`WH_COEF_W-1:0]      eta_free_i,          // s27q25, in [-1, 1]

    // W (wh_shaper): its words, port 0 lowest, and the walls that feel so; in others it stands still.
    input  wire [SHAPE_BITS-1:0]        shape_words_i,
    input  wire [N*WALLS-1:0]           wall_shaped_i,

    // A computer's environment, HOST = 1 (wh_host_link).
    input  wire [3:0]                   host_period_log2_i,  // ticks of a period, 2^this
    input  wire [7:0]                   host_timeout_i,      // periods
    input  wire [N-1:0]                 host_strobe_i,       // an answer
    input  wire [N*8-1:0]               host_sequence_i,     // of the packet that it answers
    input  wire [N*`WH_DATA_W-1:0]      host_u_i,            // s31q23 √W
    output wire [N-1:0]                 host_strobe_o,       // a packet
    output wire [N*8-1:0]               host_sequence_o,
    output wire [N*`WH_DATA_W-1:0]      host_v_o,            // s31q23 √W, mean of v
    output wire [N-1:0]                 host_active_o,       // the answers are in force

    // Wave core (wh_wave_core).
    input  wire [N*`WH_COEF_W-1:0]      root_i,              // s27q22 √Ω, +-16: √(2R̂)
    input  wire [N*`WH_COEF_W-1:0]      a_i,                 // s27q25, in (0, 1]
    input  wire [N*`WH_DATA_W-1:0]      u_max_i,             // s31q23 √W, 0...128 √W
    input  wire [N*`WH_ANCHOR_W-1:0]    anchor_words_i,      // wh_anchor's settings
    input  wire [DELAY_LOG2-1:0]        extra_ticks_i,       // ticks
    input  wire [DELAY_LOG2-1:0]        hold_ticks_i,        // ticks

    // Drive (wh_modulator, wh_dead_time, wh_pwm, wh_half_bridge).
    input  wire [`WH_MODE_W-1:0]        mode_i,              // WH_MODE_...; but for unipolar,
                                                             // tick_halves_i is even
    input  wire [7:0]                   min_pulse_i,         // clocks that a leg stays, or more
    input  wire [N*`WH_COEF_W-1:0]      clocks_per_volt_i,   // s27q16 clocks/V; BUS = 1: at first
    input  wire [`WH_COEF_W-1:0]        bus_share_i,         // s27q24 1/V, BUS = 1 (wh_bus_scale)
    input  wire [7:0]                   dead_clocks_i,       // clocks
    input  wire                         compensate_i,        // the dead time
    input  wire [N*`WH_DATA_W-1:0]      side_current_i,      // s31q24 A, 0...: where it has a side
    input  wire [7:0]                   settle_ticks_i,      // ticks between its changes of side
    input  wire                         second_order_i,      // error feedback of order 2

    input  wire [`WH_BUS_W-1:0]         bus_i,               // u16q9 V, for the guard as well

    // Guard (wh_guard; wh_faults.vh has the fields and the faults).
    input  wire [`WH_GUARD_W-1:0]       guard_i,             // its settings
    input  wire                         clear_i,             // strobe: forget what is over
    input  wire                         stop_i,              // pin, asynchronous
    input  wire [N-1:0]                 driver_fault_i,      // pins, asynchronous
    input  wire                         host_alive_i,        // strobe
    input  wire [N-1:0]                 anchor_fault_i,      // as what the port anchor finds itself
    output wire [`WH_FAULTS-1:0]        faults_o,            // latched
    output wire                         running_o,           // the bridges are on

    // What it sees and does.
    output wire                         adc_ready_o,         // the ADC is set up: ticks go on
    output wire                         tick_o,              // strobe, last clock of a tick
    output wire                         core_valid_o,        // strobe, the words below are new
    output wire [N*`WH_DATA_W-1:0]      voltage_o,           // s31q23 V, +-128 V: e to be applied
    output wire [N*`WH_DATA_W-1:0]      correction_o,        // s31q23 V: the anchor's part of it
    output wire [N*`WH_DATA_W-1:0]      offset_o,            // s31q24 A: what it takes off the current
    output wire [N*`WH_DATA_W-1:0]      flux_o,              // s31q16 cells: x̂ = x + 1/2 - this
    output wire [N*`WH_DATA_W-1:0]      lag_o,               // s31q16 cells: ω̂ over 256 ticks
    output wire [N-1:0]                 anchor_fault_o,      // waves and encoder don't agree; until rst
                                                             // or enable_i = 0
    output wire [N*`WH_DATA_W-1:0]      u_o,                 // s31q23 √W: u_n, measured tick
    output wire [N*`WH_DATA_W-1:0]      v_o,                 // s31q23 √W: v_n, measured tick
    output wire [N*`WH_DATA_W-1:0]      current_o,           // s31q24 A, +-64 A: i_n
    output wire [N*`WH_COUNT_W-1:0]     position_o,          // s32, counts
    output wire [N-1:0]                 contact_o,
    output wire [N-1:0]                 saturated_o,         // the voltage limit was at work
    output wire [N-1:0]                 adc_range_o,         // last word at the end of the scale
    output wire [N-1:0]                 adc_stuck_o,         // last stuck_words_i words the same
    output wire [N-1:0]                 zero_fault_o,        // no permitted zero was found
    output wire [N-1:0]                 zero_busy_o,         // a zero is being measured
    output wire [N-1:0]                 overcurrent_o,       // trip_i is reached, as long as it is
    output wire [N-1:0]                 encoder_fault_o,     // illegal move seen; until clear_i
    input  wire                         restart_i,           // carrier and ADC begin anew, while the
                                                             // bridges are off
    output wire [3:0]                   words_hold_o,        // words are being read: see above
    output wire                         overrun_o            // a tick is too short for its work, or ticks
                                                             // pass without; until rst or restart_i
                                                             // (core: or enable_i = 0)
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam integer USERS  = (ANCHOR != 0) ? 3 * N : 2 * N;
    localparam integer WALL_W = (WALLS < 2) ? 1 : $clog2(WALLS);

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_controller_n_must_be_1_to_8 stop ();
        end
        if (ADC < 0 || ADC > 2) begin : illegal_adc
            wh_illegal_parameter_controller_adc_must_be_0_to_2 stop ();
        end
        if ((EARLY != 0 && EARLY != 1) || (EARLY == 1 && SHAPER != 0)) begin : illegal_early
            wh_illegal_parameter_controller_early_must_be_0_or_1_and_0_with_a_shaper stop ();
        end
        if (ANCHOR != 0 && ANCHOR != 1) begin : illegal_anchor
            wh_illegal_parameter_controller_anchor_must_be_0_or_1 stop ();
        end
        if (BUS != 0 && BUS != 1) begin : illegal_bus
            wh_illegal_parameter_controller_bus_must_be_0_or_1 stop ();
        end
        if (GUARD != 0 && GUARD != 1) begin : illegal_guard
            wh_illegal_parameter_controller_guard_must_be_0_or_1 stop ();
        end
        if (DEAD_TIME != 0 && DEAD_TIME != 1) begin : illegal_dead_time
            wh_illegal_parameter_controller_dead_time_must_be_0_or_1 stop ();
        end
    endgenerate

    wire faulty;  // the guard wants the bridges off
    reg  off_q;
    wire damp;
    wire off       = faulty || off_q;
    wire run       = enable_i && !off;
    // What holds words knows of a fault a clock later; the bridges come on again a clock later too.
    wire reading   = enable_i && !off_q;
    wire drive_rst = rst || !run;
    wire sense_rst = rst || (restart_i && !reading);

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
        .tick_o          (tick_o),
        .sample_o        (sample),
        .sample_first_o  (sample_first)
    );

    // ---- Current.

    wire                      adc_valid;
    wire                      adc_first;
    wire [N*`WH_SAMPLE_W-1:0] adc_sample;
    wire                      adc_overrun;

    generate
        if (ADC == 0) begin : serial
            wire busy;
            wire lead_edge;
            wire unused = &{1'b0, busy, lead_edge};

            assign adc_din_o = 1'b0;

            wh_adc_serial #(
                .LINES              (N)
            ) adc (
                .clk                (clk),
                .rst                (sense_rst),
                .adc_cs_n_o         (adc_cs_n_o),
                .adc_sclk_o         (adc_sclk_o),
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
                .start_i            (sample),
                .first_i            (sample_first),
                .ready_o            (adc_ready_o),
                .busy_o             (busy),
                .lead_edge_o        (lead_edge),
                .valid_o            (adc_valid),
                .first_o            (adc_first),
                .sample_o           (adc_sample),
                .overrun_o          (adc_overrun)
            );
        end else if (ADC == 1) begin : command
            wire busy;
            wire unused = &{1'b0, busy, adc_sdata_i, calibrate_bits_i};

            wh_adc_max11125 #(
                .LINES              (N)
            ) adc (
                .clk                (clk),
                .rst                (sense_rst),
                .adc_cs_n_o         (adc_cs_n_o),
                .adc_sclk_o         (adc_sclk_o),
                .adc_din_o          (adc_din_o),
                .adc_sdata_i        (adc_sdata_i[0]),
                .sclk_half_clocks_i (sclk_half_clocks_i),
                .frame_bits_i       (frame_bits_i),
                .lead_bits_i        (lead_bits_i),
                .data_bits_i        (data_bits_i),
                .quiet_clocks_i     (quiet_clocks_i),
                .setup_clocks_i     (setup_clocks_i),
                .hold_clocks_i      (hold_clocks_i),
                .sclk_idle_i        (sclk_idle_i),
                .read_trailing_i    (read_trailing_i),
                .start_i            (sample),
                .first_i            (sample_first),
                .ready_o            (adc_ready_o),
                .busy_o             (busy),
                .valid_o            (adc_valid),
                .first_o            (adc_first),
                .sample_o           (adc_sample),
                .overrun_o          (adc_overrun)
            );
        end else begin : sigma_delta
            wire unused = &{1'b0, frame_bits_i, lead_bits_i, data_bits_i, quiet_clocks_i,
                            setup_clocks_i, hold_clocks_i, calibrate_bits_i, sclk_idle_i,
                            read_trailing_i};

            assign adc_cs_n_o = 1'b1;
            assign adc_din_o  = 1'b0;

            wh_sinc3 #(
                .LINES              (N),
                .OSR                (OSR),
                .CAPTURE_RISE       (CAPTURE_RISE),
                .TRIP_OSR           (TRIP_OSR)
            ) adc (
                .clk                (clk),
                .rst                (sense_rst),
                .adc_sclk_o         (adc_sclk_o),
                .adc_sdata_i        (adc_sdata_i),
                .sclk_half_clocks_i (sclk_half_clocks_i),
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
        end
    endgenerate

    wire [N-1:0] current_valid;

    // ---- One multiplier for the currents (users 0...N-1), the voltages (N...2N-1) and the anchors
    // (2N...3N-1), which have the most time. A user's reset drops its products, or one of before
    // would be taken for one of after.

    wire                            anchor_rst = drive_rst || damp;
    wire        [USERS-1:0]         multiply_drop;
    wire        [USERS-1:0]         multiply_request;
    wire        [USERS*DATA_W-1:0]  multiply_data;
    wire        [USERS*COEF_W-1:0]  multiply_coef;
    wire        [USERS-1:0]         multiply_grant;
    wire        [USERS-1:0]         multiply_done;
    wire signed [DATA_W+COEF_W-1:0] product;

    wh_multiply_shared #(
        .USERS     (USERS)
    ) multiply_shared (
        .clk       (clk),
        .rst       (rst),
        .drop_i    (multiply_drop),
        .request_i (multiply_request),
        .data_i    (multiply_data),
        .coef_i    (multiply_coef),
        .grant_o   (multiply_grant),
        .done_o    (multiply_done),
        .product_o (product)
    );

    generate
        if (ANCHOR != 0) begin : drops_of_anchors
            assign multiply_drop = {{N{anchor_rst}}, {N{drive_rst}}, {N{rst}}};
        end else begin : drops
            assign multiply_drop = {{N{drive_rst}}, {N{rst}}};
        end
    endgenerate

    // ---- Wave core. The currents of a tick come in turn, so the last port's starts it.

    wire                core_start = current_valid[N-1];
    wire                core_busy;
    wire                core_overrun;
    wire [N*DATA_W-1:0] wave_voltage; // e_id
    wire [N*DATA_W-1:0] withheld;
    wire [N-1:0]        waves;
    wire [N-1:0]        anchor_overrun;
    wire [N*COEF_W-1:0] eta;          // of contact, or 0 while a host has the environment
    wire [N*DATA_W-1:0] outside;      // a host's goal
    wire [N*DATA_W-1:0] u_max;        // what the bus leaves of u_max_i
    wire [N*DATA_W-1:0] wave_max;     // and the port anchor of that
    wire [N*DATA_W-1:0] step_max;     // the same for the step that has begun
    wire [N*COEF_W-1:0] clocks_per_volt;
    wire [2*N-1:0]      shape_mode;
    wire [N*DATA_W-1:0] host_u;
    wire [N*DATA_W-1:0] newest_u;
    wire [N*DATA_W-1:0] next_u;
    wire [N-1:0]        early_overrun;

    wh_wave_core #(
        .N             (N),
        .DELAY_LOG2    (DELAY_LOG2),
        .OUTSIDE       (HOST),
        .SHAPER        (SHAPER),
        .AHEAD         (EARLY),
        .WITHHELD      (ANCHOR)
    ) wave_core (
        .clk           (clk),
        .rst           (drive_rst),
        .start_i       (core_start),
        .busy_o        (core_busy),
        .valid_o       (core_valid_o),
        .overrun_o     (core_overrun),
        .current_i     (current_o),
        .eta_i         (eta),
        .outside_i     (outside),
        .shape_mode_i  (shape_mode),
        .shape_words_i (shape_words_i),
        .root_i        (root_i),
        .a_i           (a_i),
        .u_max_i       (step_max),
        .extra_ticks_i (extra_ticks_i),
        .hold_ticks_i  (hold_ticks_i),
        .voltage_o     (wave_voltage),
        .u_o           (u_o),
        .v_o           (v_o),
        .saturated_o   (saturated_o),
        .withheld_o    (withheld),
        .waves_o       (waves),
        .newest_u_o    (newest_u),
        .next_u_o      (next_u)
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

    assign overrun_o = adc_overrun || core_overrun || (|anchor_overrun) || (|early_overrun)
                       || missing;

    // From a word that may be a tick's last to the start of the step that it belongs to, what wh_early
    // needs of that step is yet to come: the next frame may begin there.
    reg  due_q;
    wire summed   = |multiply_request[N-1:0];
    wire step_due = adc_valid || summed || due_q || core_start;

    always @(posedge clk) begin
        due_q <= !rst && (summed || (due_q && !core_start));
    end

    // ---- Who reads words. The core reads one in the first clock of its step.

    wire         core_reads;
    wire [N-1:0] anchor_reads;
    wire [N-1:0] in_round;
    reg          sum_q;  // words of a sum have come, and its products have not all begun

    always @(posedge clk) begin
        sum_q <= run && (adc_valid || (sum_q && !summed));
    end

    assign words_hold_o = {|in_round, reading && (adc_valid || sum_q || summed),
                           reading && (|anchor_reads), core_reads};

    // ---- The bridge's pattern.

    wire half_bridge;
    wire whole;        // one width for both halves of a period

    generate
        if (MODES != 0) begin : modes
            assign half_bridge = (mode_i == `WH_MODE_HALF_BRIDGE);
            assign whole       = (mode_i != `WH_MODE_UNIPOLAR);
        end else begin : unipolar
            assign half_bridge = 1'b0;
            assign whole       = 1'b0;
        end
    endgenerate

    // ---- What the measured bus changes.

    generate
        if (BUS == 1) begin : measured_bus
            wire bus_gives;

            assign core_reads = reading && (core_start || !bus_gives);

            // One u_max for a step, not read in its first clock. wh_early's words of a step are made
            // before it starts, from the end of the step before on.
            wire words_hold = !drive_rst && ((EARLY == 1) ? !core_valid_o : core_busy);

            wh_bus_scale #(
                .N                 (N)
            ) bus_scale (
                .clk               (clk),
                .rst               (rst),
                .hold_i            (words_hold),
                .gives_o           (bus_gives),
                .half_clocks_i     (half_clocks_i),
                .half_bridge_i     (half_bridge),
                .bus_i             (bus_i),
                .bus_share_i       (bus_share_i),
                .clocks_per_volt_i (clocks_per_volt_i),
                .clocks_per_volt_o (clocks_per_volt),
                .u_max_i           (u_max_i),
                .u_max_o           (u_max)
            );
        end else begin : known_bus
            wire unused_bus = &{1'b0, bus_i, bus_share_i};

            assign core_reads = reading
                                && (core_start || ((EARLY == 1) ? !core_valid_o : core_busy));

            assign clocks_per_volt = clocks_per_volt_i;
            assign u_max           = u_max_i;
        end
    endgenerate

    // Widths that keep every leg where it is for min_pulse_i. Unipolar: a pulse of one width where
    // the sign changes, two of them less than the half otherwise. Sign-magnitude: twice the width
    // where the sign changes. In the others a pulse is short only near the end of the scale.
    wire [7:0] spare = (min_pulse_i >> 1) + {7'd0, min_pulse_i[0]};
    wire [7:0] least = !whole                              ? min_pulse_i
                     : (mode_i == `WH_MODE_SIGN_MAGNITUDE) ? spare : 8'd0;

    // ---- Guard. An illegal word is one that no block has a meaning for.

    wire [N-1:0] moved;
    wire [N-1:0] illegal_move;
    reg          setting_q;
    reg          setting;
    integer      m;

    always @* begin
        setting = half_clocks_i < 6 || tick_halves_i == 0 || sample_clocks_i < 2
                  || samples_i == 0 || samples_i > 256
                  || (whole && tick_halves_i[0]);
        for (m = 0; m < N; m = m + 1) begin
            setting = setting || illegal_part(a_i[m*COEF_W +: COEF_W])
                      || a_i[m*COEF_W + COEF_W-1] || a_i[m*COEF_W +: COEF_W] == 0
                      || illegal_part(eta_contact_i[m*COEF_W +: COEF_W])
                      || illegal_part(eta_free_i[m*COEF_W +: COEF_W])
                      || root_i[m*COEF_W + COEF_W-1] || root_i[m*COEF_W +: COEF_W] == 0
                      || clocks_per_volt_i[m*COEF_W + COEF_W-1]
                      || clocks_per_volt_i[m*COEF_W +: COEF_W] == 0
                      || gain_i[m*COEF_W + COEF_W-1] || gain_i[m*COEF_W +: COEF_W] == 0
                      || u_max_i[m*DATA_W + DATA_W-1];
        end
    end

    // Whether a word of full scale +-2 is outside [-1, 1].
    function illegal_part;
        input [COEF_W-1:0] word;
        begin
            illegal_part = word[COEF_W-1] ? !word[COEF_W-2]
                                          : word[COEF_W-2] && |word[COEF_W-3:0];
        end
    endfunction

    always @(posedge clk) begin
        setting_q <= !rst && setting;
    end

    generate
        if (GUARD != 0) begin : guarded
            wh_guard #(
                .N              (N)
            ) guard (
                .clk            (clk),
                .rst            (rst),
                .settings_i     (guard_i),
                .clear_i        (clear_i),
                .running_i      (run),
                .stop_i         (stop_i),
                .driver_i       (driver_fault_i),
                .host_alive_i   (host_alive_i),
                .bus_i          (bus_i),
                .sample_valid_i (adc_valid),
                .sample_i       (adc_sample),
                .range_i        (adc_range_o),
                .stuck_i        (adc_stuck_o),
                .zero_i         (zero_fault_o),
                .trip_i         (overcurrent_o),
                .encoder_i      (illegal_move),
                .moved_i        (moved),
                .anchor_i       (anchor_fault_i | anchor_fault_o),
                .setting_i      (setting_q),
                .overrun_i      (overrun_o),
                .tick_i         (tick_o),
                .valid_i        (current_valid[N-1]),
                .current_i      (current_o),
                .u_i            (u_o),
                .v_i            (v_o),
                .faults_o       (faults_o),
                .off_o          (faulty),
                .damp_o         (damp)
            );
        end else begin : unguarded
            wire unused_guard = &{1'b0, guard_i, stop_i, driver_fault_i, host_alive_i, bus_i,
                                  anchor_fault_i, setting_q, moved, illegal_move};

            assign faults_o = {`WH_FAULTS{1'b0}};
            assign faulty   = 1'b0;
            assign damp     = 1'b0;
        end
    endgenerate

    // ---- What each motor has of its own.

    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : port

            wire signed [`WH_SUM_W-1:0] zero;

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
                              + {zero_i[(n+1)*`WH_SUM_W-1], zero_i[n*`WH_SUM_W +: `WH_SUM_W]}),
                    .value_o (zero)
                );

                wh_sense_check sense_check (
                    .clk           (clk),
                    .rst           (rst),
                    .valid_i       (adc_valid),
                    .sample_i      (adc_sample[n*`WH_SAMPLE_W +: `WH_SAMPLE_W]),
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
                    .sample_i      (adc_sample[n*`WH_SAMPLE_W +: `WH_SAMPLE_W]),
                    .start_i       (zero_start_i),
                    .bridge_off_i  (!enable_i),
                    .limit_i       (zero_limit_i),
                    .busy_o        (zero_busy_o[n]),
                    .done_o        (zero_done),
                    .measured_o    (measured),
                    .zero_o        (measured_zero),
                    .fault_o       (zero_fault_o[n])
                );
            end else begin : plain
                wire unused = &{1'b0, range_i, stuck_words_i, zero_start_i, zero_limit_i};

                assign zero            = zero_i[n*`WH_SUM_W +: `WH_SUM_W];
                assign adc_range_o[n]  = 1'b0;
                assign adc_stuck_o[n]  = 1'b0;
                assign zero_fault_o[n] = 1'b0;
                assign zero_busy_o[n]  = 1'b0;
            end

            wh_current current (
                .clk       (clk),
                .rst       (rst),
                .valid_i   (adc_valid),
                .first_i   (adc_first),
                .sample_i  (adc_sample[n*`WH_SAMPLE_W +: `WH_SAMPLE_W]),
                .samples_i (samples_i),
                .zero_i    (zero),
                .request_o (multiply_request[n]),
                .grant_i   (multiply_grant[n]),
                .factor_o  (multiply_data[n*DATA_W +: DATA_W]),
                .done_i    (multiply_done[n]),
                .product_i (product),
                .offset_i  (offset_o[n*DATA_W +: DATA_W]),
                .valid_o   (current_valid[n]),
                .current_o (current_o[n*DATA_W +: DATA_W])
            );

            if (ADC != 2) begin : trip
                wh_trip trip (
                    .clk      (clk),
                    .rst      (rst),
                    .valid_i  (adc_valid),
                    .sample_i (adc_sample[n*`WH_SAMPLE_W +: `WH_SAMPLE_W]),
                    .trip_i   (trip_i),
                    .trip_o   (overcurrent_o[n])
                );
            end

            assign multiply_coef[n*COEF_W +: COEF_W] = gain_i[n*COEF_W +: COEF_W];

            wire       direction;
            wire [7:0] faults;

            wh_quadrature quadrature (
                .clk             (clk),
                .rst             (rst),
                .a_i             (enc_a_i[n]),
                .b_i             (enc_b_i[n]),
                .filter_clocks_i (filter_clocks_i),
                .clear_i         (clear_i),
                .position_o      (position_o[n*`WH_COUNT_W +: `WH_COUNT_W]),
                .moved_o         (moved[n]),
                .direction_o     (direction),
                .illegal_o       (illegal_move[n]),
                .fault_o         (encoder_fault_o[n]),
                .faults_o        (faults)
            );

            wire        [WALL_W-1:0]      wall;
            wire                          wall_shaped;
            wire signed [`WH_COUNT_W-1:0] depth;
            wire signed [COEF_W-1:0]      contact_eta;

            // For a host's registers, which this module doesn't have.
            wire unused = &{1'b0, direction, faults, wall, depth};

            // Nothing is read of it in a step's first clock, in which it may still change: a clock
            // between any two steps, even where the next starts as one ends.
            wh_contact #(
                .WALLS         (WALLS)
            ) contact (
                .clk           (clk),
                .rst           (rst),
                .position_i    (position_o[n*`WH_COUNT_W +: `WH_COUNT_W]),
                .hold_i        (core_busy),
                .wall_min_i    (wall_min_i[n*WALLS*`WH_COUNT_W +: WALLS*`WH_COUNT_W]),
                .wall_max_i    (wall_max_i[n*WALLS*`WH_COUNT_W +: WALLS*`WH_COUNT_W]),
                .wall_enable_i (wall_enable_i[n*WALLS +: WALLS]),
                .wall_shaped_i (wall_shaped_i[n*WALLS +: WALLS]),
                .hysteresis_i  (edge_hysteresis_i[n]),
                .eta_contact_i (eta_contact_i[n*COEF_W +: COEF_W]),
                .eta_free_i    (eta_free_i[n*COEF_W +: COEF_W]),
                .round_o       (in_round[n]),
                .contact_o     (contact_o[n]),
                .wall_o        (wall),
                .shaped_o      (wall_shaped),
                .depth_o       (depth),
                .eta_o         (contact_eta)
            );

            wire              anchor_busy;
            wire [DATA_W-1:0] next_correction;
            wire              driven_valid;
            wire [DATA_W-1:0] driven;

            assign anchor_reads[n] = anchor_busy || waves[n];

            if (ANCHOR != 0) begin : anchored
                wire signed [DATA_W:0] wide_voltage =
                    $signed({wave_voltage[n*DATA_W + DATA_W-1], wave_voltage[n*DATA_W +: DATA_W]})
                    + $signed({correction_o[n*DATA_W + DATA_W-1], correction_o[n*DATA_W +: DATA_W]});
                wire signed [DATA_W-1:0] voltage;

                wh_saturate #(
                    .IN_W    (DATA_W + 1),
                    .OUT_W   (DATA_W)
                ) saturate_voltage (
                    .value_i (wide_voltage),
                    .value_o (voltage)
                );

                assign voltage_o[n*DATA_W +: DATA_W] = voltage;

                // The sum and what chooses the multiplier's user are too much for one clock.
                reg                driven_valid_q;
                reg  [DATA_W-1:0]  driven_q;

                assign driven_valid = driven_valid_q;
                assign driven       = driven_q;

                always @(posedge clk) begin
                    driven_valid_q <= core_valid_o && !drive_rst;
                    driven_q       <= voltage;
                end

                // The position that belongs to the contact, until the port's turn: the anchor may still
                // be at the step before when the core starts. One limit for a step, which takes room
                // from the next one.
                reg  [`WH_COUNT_W-1:0]   position_q;
                reg  [DATA_W-1:0]        step_max_q;
                wire signed [DATA_W-1:0] room;

                assign wave_max[n*DATA_W +: DATA_W] = u_max[n*DATA_W +: DATA_W] - room;
                assign step_max[n*DATA_W +: DATA_W] = step_max_q;

                always @(posedge clk) begin
                    if (core_start) begin
                        position_q <= position_o[n*`WH_COUNT_W +: `WH_COUNT_W];
                        step_max_q <= wave_max[n*DATA_W +: DATA_W];
                    end
                end

                // A host's environment counts as contact: its current may be what it likes.
                wh_anchor anchor (
                    .clk           (clk),
                    .rst           (anchor_rst),
                    .start_i       (waves[n]),
                    .position_i    (position_q),
                    .contact_i     (contact_o[n] || host_active_o[n]),
                    .waves_i       (waves[n]),
                    .current_i     (current_o[n*DATA_W +: DATA_W]),
                    .u_i           (u_o[n*DATA_W +: DATA_W]),
                    .v_i           (v_o[n*DATA_W +: DATA_W]),
                    .withheld_i    (withheld[n*DATA_W +: DATA_W]),
                    .voltage_i     (wave_voltage[n*DATA_W +: DATA_W]),
                    .saturated_i   (saturated_o[n]),
                    .busy_o        (anchor_busy),
                    .overrun_o     (anchor_overrun[n]),
                    .words_i       (anchor_words_i[n*`WH_ANCHOR_W +: `WH_ANCHOR_W]),
                    .request_o     (multiply_request[2*N+n]),
                    .factor_o      (multiply_data[(2*N+n)*DATA_W +: DATA_W]),
                    .coefficient_o (multiply_coef[(2*N+n)*COEF_W +: COEF_W]),
                    .grant_i       (multiply_grant[2*N+n]),
                    .done_i        (multiply_done[2*N+n]),
                    .product_i     (product),
                    .correction_o  (correction_o[n*DATA_W +: DATA_W]),
                    .next_o        (next_correction),
                    .room_o        (room),
                    .offset_o      (offset_o[n*DATA_W +: DATA_W]),
                    .flux_o        (flux_o[n*DATA_W +: DATA_W]),
                    .lag_o         (lag_o[n*DATA_W +: DATA_W]),
                    .fault_o       (anchor_fault_o[n])
                );
            end else begin : by_its_waves_alone
                wire unused_anchor = &{1'b0, anchor_rst, waves[n], withheld[n*DATA_W +: DATA_W],
                                       anchor_words_i[n*`WH_ANCHOR_W +: `WH_ANCHOR_W]};

                assign driven_valid                     = core_valid_o;
                assign driven                           = wave_voltage[n*DATA_W +: DATA_W];
                assign voltage_o[n*DATA_W +: DATA_W]    = wave_voltage[n*DATA_W +: DATA_W];
                assign correction_o[n*DATA_W +: DATA_W] = {DATA_W{1'b0}};
                assign offset_o[n*DATA_W +: DATA_W]     = {DATA_W{1'b0}};
                assign flux_o[n*DATA_W +: DATA_W]       = {DATA_W{1'b0}};
                assign lag_o[n*DATA_W +: DATA_W]        = {DATA_W{1'b0}};
                assign next_correction                  = {DATA_W{1'b0}};
                assign wave_max[n*DATA_W +: DATA_W]     = u_max[n*DATA_W +: DATA_W];
                assign step_max[n*DATA_W +: DATA_W]     = u_max[n*DATA_W +: DATA_W];
                assign anchor_busy                      = 1'b0;
                assign anchor_overrun[n]                = 1'b0;
                assign anchor_fault_o[n]                = 1'b0;
            end

            // While a host has the environment v is the host's, and W may not keep a part of it.
            assign shape_mode[2*n +: 2] = (!contact_o[n] || host_active_o[n]) ? 2'd0
                                        : wall_shaped                         ? 2'd2 : 2'd1;

            // An anchor that has lost the rotor leaves a port that only damps.
            wire              damps           = damp || anchor_fault_o[n];
            wire [DATA_W-1:0] present_outside = (host_active_o[n] && !damps)
                                              ? host_u[n*DATA_W +: DATA_W] : {DATA_W{1'b0}};
            wire [COEF_W-1:0] present_eta     = (host_active_o[n] || damps) ? {COEF_W{1'b0}}
                                                                            : contact_eta;

            // ---- A duty that doesn't wait for the core. What it is made with, the core uses too.
            wire                                   early_valid;
            wire [DATA_W+COEF_W-`WH_VOLTAGE_Q-1:0] early_duty;

            if (EARLY == 1) begin : early
                wh_early early (
                    .clk               (clk),
                    .rst               (drive_rst),
                    .frame_i           (sample),
                    .word_valid_i      (adc_valid),
                    .word_first_i      (adc_first),
                    .samples_i         (samples_i),
                    .busy_i            (step_due || core_busy || anchor_busy),
                    .f_i               (newest_u[n*DATA_W +: DATA_W]),
                    .u_n_i             (next_u[n*DATA_W +: DATA_W]),
                    .u_max_i           (wave_max[n*DATA_W +: DATA_W]),
                    .root_i            (root_i[n*COEF_W +: COEF_W]),
                    .a_i               (a_i[n*COEF_W +: COEF_W]),
                    .gain_i            (gain_i[n*COEF_W +: COEF_W]),
                    .clocks_per_volt_i (clocks_per_volt[n*COEF_W +: COEF_W]),
                    .eta_i             (present_eta),
                    .wave_i            (present_outside),
                    .offset_i          (offset_o[n*DATA_W +: DATA_W]),
                    .correction_i      (next_correction),
                    .eta_o             (eta[n*COEF_W +: COEF_W]),
                    .wave_o            (outside[n*DATA_W +: DATA_W]),
                    .sum_valid_i       (multiply_request[n]),
                    .sum_i             (multiply_data[n*DATA_W +: DATA_W]),
                    .duty_valid_o      (early_valid),
                    .duty_o            (early_duty),
                    .overrun_o         (early_overrun[n])
                );
            end else begin : in_turn
                wire unused_early = &{1'b0, step_due, wave_max[n*DATA_W +: DATA_W],
                                      newest_u[n*DATA_W +: DATA_W], next_u[n*DATA_W +: DATA_W],
                                      anchor_busy, next_correction};

                assign outside[n*DATA_W +: DATA_W] = present_outside;
                assign eta[n*COEF_W +: COEF_W]     = present_eta;
                assign early_valid                 = 1'b0;
                assign early_duty                  = {DATA_W+COEF_W-`WH_VOLTAGE_Q{1'b0}};
                assign early_overrun[n]            = 1'b0;
            end

            if (HOST == 1) begin : hosted
                wire signed [DATA_W-1:0] goal;

                wh_host_link host_link (
                    .clk           (clk),
                    .rst           (drive_rst || damp),
                    .period_log2_i (host_period_log2_i),
                    .timeout_i     (host_timeout_i),
                    .valid_i       (core_valid_o),
                    .v_i           (v_o[n*DATA_W +: DATA_W]),
                    .active_o      (host_active_o[n]),
                    .u_o           (goal),
                    .strobe_o      (host_strobe_o[n]),
                    .sequence_o    (host_sequence_o[n*8 +: 8]),
                    .v_mean_o      (host_v_o[n*DATA_W +: DATA_W]),
                    .strobe_i      (host_strobe_i[n]),
                    .sequence_i    (host_sequence_i[n*8 +: 8]),
                    .u_i           (host_u_i[n*DATA_W +: DATA_W])
                );

                assign host_u[n*DATA_W +: DATA_W] = goal;
            end else begin : alone
                wire unused_host = &{1'b0, host_period_log2_i, host_timeout_i, host_strobe_i[n],
                                     host_sequence_i[n*8 +: 8], host_u_i[n*DATA_W +: DATA_W]};

                assign host_u[n*DATA_W +: DATA_W]   = {DATA_W{1'b0}};
                assign host_active_o[n]             = 1'b0;
                assign host_strobe_o[n]             = 1'b0;
                assign host_sequence_o[n*8 +: 8]    = 8'd0;
                assign host_v_o[n*DATA_W +: DATA_W] = {DATA_W{1'b0}};
            end

            wire signed [`WH_TICK_W-1:0]  width;
            wire signed [`WH_EXTRA_W-1:0] extra;
            wire                          leg_a;
            wire                          leg_b;

            if (DEAD_TIME != 0) begin : compensated
                wh_dead_time dead_time (
                    .clk            (clk),
                    .rst            (drive_rst),
                    .compensate_i   (compensate_i),
                    .dead_clocks_i  (dead_clocks_i),
                    .threshold_i    (side_current_i[n*DATA_W +: DATA_W]),
                    .settle_ticks_i (settle_ticks_i),
                    .valid_i        (current_valid[n]),
                    .current_i      (current_o[n*DATA_W +: DATA_W]),
                    .extra_o        (extra)
                );
            end else begin : as_it_is
                wire unused_dead = &{1'b0, compensate_i, side_current_i[n*DATA_W +: DATA_W],
                                     settle_ticks_i};

                assign extra = {`WH_EXTRA_W{1'b0}};
            end

            wh_modulator #(
                .EARLY             (EARLY),
                .MIN_PULSE         (MIN_PULSE)
            ) modulator (
                .clk               (clk),
                .rst               (drive_rst),
                .valid_i           (driven_valid),
                .voltage_i         (driven),
                .clocks_per_volt_i (clocks_per_volt[n*COEF_W +: COEF_W]),
                .half_clocks_i     (half_clocks_i),
                .second_order_i    (second_order_i),
                .extra_i           (extra),
                .least_i           (least),
                .spare_i           (spare),
                .request_o         (multiply_request[N+n]),
                .grant_i           (multiply_grant[N+n]),
                .factor_o          (multiply_data[(N+n)*DATA_W +: DATA_W]),
                .coefficient_o     (multiply_coef[(N+n)*COEF_W +: COEF_W]),
                .done_i            (multiply_done[N+n]),
                .product_i         (product),
                .early_valid_i     (early_valid),
                .early_i           (early_duty),
                .take_i            (take),
                .update_i          (update && (half || !whole)),
                .width_o           (width)
            );

            wh_pwm #(
                .MODES         (MODES)
            ) pwm (
                .clk           (clk),
                .rst           (drive_rst),
                .mode_i        (mode_i),
                .half_clocks_i (half_clocks_i),
                .phase_i       (phase),
                .remaining_i   (remaining),
                .half_i        (half),
                .update_i      (update),
                .width_i       (width),
                .leg_a_o       (leg_a),
                .leg_b_o       (leg_b)
            );

            wh_half_bridge leg_a_bridge (
                .clk           (clk),
                .rst           (rst),
                .enable_i      (run),
                .leg_i         (leg_a),
                .dead_clocks_i (dead_clocks_i),
                .high_o        (gate_ah_o[n]),
                .low_o         (gate_al_o[n])
            );

            wh_half_bridge leg_b_bridge (
                .clk           (clk),
                .rst           (rst),
                .enable_i      (run && !half_bridge),
                .leg_i         (leg_b),
                .dead_clocks_i (dead_clocks_i),
                .high_o        (gate_bh_o[n]),
                .low_o         (gate_bl_o[n])
            );
        end
    endgenerate

endmodule

`default_nettype wire
