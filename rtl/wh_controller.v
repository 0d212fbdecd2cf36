// SPDX-License-Identifier: Apache-2.0
//
// wh_controller: the wave controller from ADC pins to gate pins, for N motors.
//
//   ADC bits -> wh_adc -> wh_motor -> current  -> wh_port, wh_wave_core -> voltage -> wh_motor -> gates
//   encoder ------------> wh_motor -> position -> wh_port                wh_carrier times everything
//
// A positive current flows into the motor from bridge leg A and out to leg B. A positive voltage has leg A high while
// leg B is low. A positive current turns the rotor towards positive positions.
//
// enable_i = 0 keeps the gates off, and the wave core and the pulse width in reset. ADC, currents and positions run on,
// so that zero_i can be measured. enable_i is synchronous to clk.
//
// A setting may change (a) in reset, (b) while enable_i = 0 and restart_i = 1, or (c) on a clock edge where its hold is
// 0; the register map says which hold (column Change):
//   words_hold_o[0]  the core reads its settings
//   scale_hold_o     a voltage has yet to be scaled by the settings of its step
//   anchor_hold_o    the anchor of that motor reads its settings
//   words_hold_o[2]  a sum has begun
//   words_hold_o[3]  a round of the walls has begun
// words_hold_o[1] is the OR of anchor_hold_o. In every tick that is long enough for the steps of core and anchors each
// hold is 0 at least once. Settings of the core change first, as scaling and anchors still need those of the step that
// ends. From the clock after the bridges went off only words_hold_o[3] can be 1.
//
// Latency: the gates show the carrier's phase after 2 clocks plus dead time, and CS_n falls 1 clock after the sample's
// phase. So sample_lead_i = -1 samples in the pulse's middle, and half the dead time less in the middle of the pulse
// that dead time leaves. The last sample of a tick reaches the gates with the next tick that ends at least
//     conversion + 14 + (24 + 5 SHAPER) N + 2 (N - 1) + ANCHOR clocks
// after its sample strobe; conversion is the reader's latency (latency_clocks in
// sim/wavehaptics/controller/pins_timing.py).
// SHARED = 1 halves the multipliers and changes no value. The core's products come first: in a tick of fewer clocks
// than shared_tick_clocks other products would be late.
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
    parameter integer SENSE      = 0,  // 1: sense checks and a measured zero (wh_sense_check, wh_zero)
    parameter integer ZERO_LOG2  = 10, // SENSE = 1: ticks of a zero, 2^ZERO_LOG2; 2...16
    parameter integer SHAPER     = 0,  // sections of W (wh_shaper), 0...2; 0: W = 1
    parameter integer DEAD_TIME  = 1,  // 1: dead-time compensation exists
    parameter integer MODES      = 0,  // 1: mode_i selects the bridge's pattern; 0: unipolar
    parameter integer MIN_PULSE  = 0,  // 1: min_pulse_i is in force; 0: pulses may last one clock
    parameter integer BUS        = 0,  // 1: bus_i scales the drive; 0: clocks_per_volt_i does
    parameter integer HOST       = 0,  // 1: a computer can be the environment (wh_host_link)
    parameter integer ANCHOR     = 0,  // 1: port anchors (wh_anchor)
    parameter integer SHARED     = 0,  // 1: one multiplier serves all, the core too; SHAPER is 0
    parameter integer GUARD      = 0,  // 1: wh_guard watches; 0: its inputs have no effect
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
    input  wire signed [7:0]            sample_lead_i,       // clocks by which samples come early
    input  wire                         sample_late_i,       // 1: a clock later in odd ticks

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
    input  wire [15:0]                  trip_i,              // full scale is 2^15; more: never

    // Current (wh_current).
    input  wire [N*`WH_SUM_W-1:0]       zero_i,              // s24, a tick's sum at 0 A
    input  wire [15:0]                  range_i,             // full scale is 2^15: end of the ADC's range
    // With SENSE = 1: the checks, and a zero measured on command, to which zero_i is added.
    input  wire [15:0]                  stuck_words_i,       // identical samples that are a fault
    input  wire                         zero_start_i,        // strobe; no effect while the bridges are on
    input  wire [`WH_SUM_W-2:0]         zero_limit_i,        // largest permitted |zero|
    input  wire [N*`WH_COEF_W-1:0]      gain_i,              // s27q35 A per unit of the sum

    // Position and contact (wh_quadrature, wh_contact).
    input  wire [3:0]                   filter_clocks_i,     // clocks that a level must hold
    input  wire [N*WALLS*`WH_COUNT_W-1:0] wall_min_i,        // s32, counts
    input  wire [N*WALLS*`WH_COUNT_W-1:0] wall_max_i,        // s32, counts
    input  wire [N*WALLS-1:0]           wall_enable_i,
    input  wire [N-1:0]                 edge_hysteresis_i,   // walls are left one count later
    input  wire [N*`WH_COEF_W-1:0]      eta_contact_i,       // s27q25, in [-1, 1]
    input  wire [N*`WH_COEF_W-1:0]      eta_free_i,          // s27q25, in [-1, 1]

    // Speed and position that are a fault (wh_motion), GUARD = 1.
    input  wire [N*16-1:0]              overspeed_i,         // counts in 2^WH_SPAN_LOG2 ticks; 0: no check
    input  wire [N*`WH_COUNT_W-1:0]     window_low_i,        // s32, counts
    input  wire [N*`WH_COUNT_W-1:0]     window_high_i,       // s32, counts

    // W (wh_shaper): its settings, port 0 lowest, and the walls that it shapes; in others it keeps its state.
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
    input  wire [7:0]                   min_pulse_i,         // clocks that a leg stays at least
    input  wire [N*`WH_COEF_W-1:0]      clocks_per_volt_i,   // s27q16 clocks/V; BUS = 1: at first
    input  wire [`WH_COEF_W-1:0]        bus_share_i,         // s27q24 1/V, BUS = 1 (wh_bus_scale)
    input  wire [7:0]                   dead_clocks_i,       // clocks
    input  wire                         compensate_i,        // the dead time
    input  wire [N*`WH_DATA_W-1:0]      side_current_i,      // s31q24 A, 0...: from which on it has a side
    input  wire [7:0]                   settle_ticks_i,      // ticks between its changes of side
    input  wire                         second_order_i,      // error feedback of order 2

    input  wire [`WH_BUS_W-1:0]         bus_i,               // u16q9 V, for the guard as well

    // Guard (wh_guard; wh_faults.vh has the fields and the faults).
    input  wire [`WH_GUARD_W-1:0]       guard_i,             // its settings
    input  wire                         clear_i,             // strobe: clear faults whose cause is over
    input  wire                         stop_i,              // pin, asynchronous
    input  wire [N-1:0]                 driver_fault_i,      // pins, asynchronous
    input  wire                         host_alive_i,        // strobe
    input  wire [N-1:0]                 anchor_fault_i,      // like the port anchor's own fault
    output wire [`WH_FAULTS-1:0]        faults_o,            // latched
    output wire                         running_o,           // the bridges are on

    // State and live values.
    output wire                         adc_ready_o,         // the ADC is set up, and ticks follow each other
    output wire                         tick_o,              // strobe, last clock of a tick
    output wire                         core_valid_o,        // strobe, the words below are new
    output wire [N*`WH_DATA_W-1:0]      voltage_o,           // s31q23 V, +-128 V: e to be applied
    output wire [N*`WH_DATA_W-1:0]      correction_o,        // s31q23 V: the anchor's share of it
    output wire [N*`WH_DATA_W-1:0]      offset_o,            // s31q24 A: the offset that the anchor subtracts
    output wire [N*`WH_DATA_W-1:0]      flux_o,              // s31q16 cells: x̂ = x + 1/2 - this
    output wire [N*`WH_DATA_W-1:0]      lag_o,               // s31q16 cells: ω̂ over 256 ticks
    output wire [N-1:0]                 anchor_fault_o,      // waves and encoder don't agree; until rst
                                                             // or enable_i = 0
    output wire [N*`WH_ENERGY_W-1:0]    contact_energy_o,    // s24q10 A·counts: energy of a contact to the shaft
    output wire [N*`WH_ENERGY_W-1:0]    contact_energy_peak_o, // s24q10 A·counts: its maximum
    output wire [N*`WH_DATA_W-1:0]      u_o,                 // s31q23 √W: u_n, measured tick
    output wire [N*`WH_DATA_W-1:0]      v_o,                 // s31q23 √W: v_n, measured tick
    output wire [N*`WH_DATA_W-1:0]      current_o,           // s31q24 A, +-64 A: i_n
    output wire [N*`WH_COUNT_W-1:0]     position_o,          // s32, counts
    output wire [N-1:0]                 contact_o,
    output wire [N-1:0]                 saturated_o,         // the voltage limit acts
    output wire [N-1:0]                 clipped_o,           // a sample, i_n or v_n at the end of its range
    output wire [N-1:0]                 adc_range_o,         // last sample at the end of the scale
    output wire [N-1:0]                 adc_stuck_o,         // last stuck_words_i samples identical
    output wire [N-1:0]                 zero_fault_o,        // no accepted zero was found
    output wire [N-1:0]                 zero_busy_o,         // a zero is being measured
    output wire [N-1:0]                 overcurrent_o,       // while trip_i is reached
    output wire [N-1:0]                 encoder_fault_o,     // illegal move seen; until clear_i
    input  wire                         restart_i,           // carrier and ADC begin anew, while the
                                                             // bridges are off; what was sampled before
                                                             // it is forgotten
    output wire [3:0]                   words_hold_o,        // settings are being read: see above
    output wire                         scale_hold_o,
    output wire [N-1:0]                 anchor_hold_o,
    output wire                         overrun_o            // a tick is too short for its work, or ticks
                                                             // pass without; until rst or restart_i
                                                             // (core: or enable_i = 0)
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam integer OTHERS = (ANCHOR != 0) ? 3 * N : 2 * N;
    localparam integer USERS  = OTHERS + ((SHARED != 0) ? 1 : 0);

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_controller_n_must_be_1_to_8 stop ();
        end
        if (ANCHOR != 0 && ANCHOR != 1) begin : illegal_anchor
            wh_illegal_parameter_controller_anchor_must_be_0_or_1 stop ();
        end
        if ((SHARED != 0 && SHARED != 1) || (SHARED == 1 && SHAPER != 0)) begin : illegal_shared
            wh_illegal_parameter_controller_shared_must_be_0_or_1_and_0_with_a_shaper stop ();
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

    wire faulty;  // the guard requires the bridges off
    reg  off_q;
    wire damp;
    wire off       = faulty || off_q;
    wire run       = enable_i && !off;
    // The holds follow a fault a clock later; the bridges come on again a clock later too.
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

    // ---- Current.

    wire                      adc_valid;
    wire                      adc_first;
    wire [N*`WH_SAMPLE_W-1:0] adc_sample;
    wire                      adc_overrun;

    wh_adc #(
        .LINES              (N),
        .ADC                (ADC),
        .OSR                (OSR)
    ) adc (
        .clk                (clk),
        .rst                (rst),
        .restart_i          (sense_restart),
        .adc_cs_n_o         (adc_cs_n_o),
        .adc_sclk_o         (adc_sclk_o),
        .adc_din_o          (adc_din_o),
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

    wire [N-1:0] current_valid;

    // ---- One multiplier for the currents (users 0...N-1), the voltages (N...2N-1) and the anchors
    // (2N...3N-1), which have the most time. A user's reset drops its products, else an old one
    // would be taken for a new one. With SHARED = 1 the core comes first, as it can't wait.

    wire                            anchor_rst = drive_rst || damp;
    wire        [USERS-1:0]         multiply_drop;
    wire        [USERS-1:0]         multiply_request;
    wire        [USERS*DATA_W-1:0]  multiply_data;
    wire        [USERS*COEF_W-1:0]  multiply_coef;
    wire        [USERS-1:0]         multiply_grant;
    wire        [USERS-1:0]         multiply_done;
    wire signed [DATA_W+COEF_W-1:0] product;

    wire        [OTHERS-1:0]        others_drop;
    wire        [OTHERS-1:0]        others_request;
    wire        [OTHERS*DATA_W-1:0] others_data;
    wire        [OTHERS*COEF_W-1:0] others_coef;
    wire        [OTHERS-1:0]        others_grant = multiply_grant[USERS-1 -: OTHERS];
    wire        [OTHERS-1:0]        others_done  = multiply_done[USERS-1 -: OTHERS];
    wire                            core_request;
    wire signed [DATA_W-1:0]        core_factor;
    wire signed [COEF_W-1:0]        core_coefficient;

    generate
        if (SHARED == 1) begin : with_core
            wire unused_core = &{1'b0, multiply_grant[0], multiply_done[0]};

            assign multiply_drop    = {others_drop, drive_rst};
            assign multiply_request = {others_request, core_request};
            assign multiply_data    = {others_data, core_factor};
            assign multiply_coef    = {others_coef, core_coefficient};
        end else begin : without_core
            wire unused_core = &{1'b0, core_request, core_factor, core_coefficient};

            assign multiply_drop    = others_drop;
            assign multiply_request = others_request;
            assign multiply_data    = others_data;
            assign multiply_coef    = others_coef;
        end
    endgenerate

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

    wire [N-1:0]        current_request;
    wire [N*DATA_W-1:0] current_factor;
    wire [N-1:0]        drive_request;
    wire [N*DATA_W-1:0] drive_factor;
    wire [N*COEF_W-1:0] drive_coefficient;
    wire [N-1:0]        anchor_request;
    wire [N*DATA_W-1:0] anchor_factor;
    wire [N*COEF_W-1:0] anchor_coefficient;
    wire [N-1:0]        anchor_grant;
    wire [N-1:0]        anchor_done;

    generate
        if (ANCHOR != 0) begin : with_anchors
            assign others_drop    = {{N{anchor_rst}}, {N{drive_rst}}, {N{sense_rst}}};
            assign others_request = {anchor_request, drive_request, current_request};
            assign others_data    = {anchor_factor, drive_factor, current_factor};
            assign others_coef    = {anchor_coefficient, drive_coefficient, gain_i};
            assign anchor_grant   = others_grant[2*N +: N];
            assign anchor_done    = others_done[2*N +: N];
        end else begin : without
            wire unused = &{1'b0, anchor_rst, anchor_request, anchor_factor, anchor_coefficient};

            assign others_drop    = {{N{drive_rst}}, {N{sense_rst}}};
            assign others_request = {drive_request, current_request};
            assign others_data    = {drive_factor, current_factor};
            assign others_coef    = {drive_coefficient, gain_i};
            assign anchor_grant   = {N{1'b0}};
            assign anchor_done    = {N{1'b0}};
        end
    endgenerate

    // ---- Wave core. The currents of a tick come in turn, so the last port's starts it.

    wire                core_start = current_valid[N-1];
    wire [2*N-1:0]      current_ends;
    wire                core_busy;
    wire                core_looks;   // it reads settings
    wire                core_overrun;
    wire [N*DATA_W-1:0] wave_voltage; // e_id
    wire [N*DATA_W-1:0] withheld;
    wire [N-1:0]        waves;
    wire [N-1:0]        anchor_overrun;
    wire [N*COEF_W-1:0] eta;          // of contact, or 0 while a host is the environment
    wire [N*DATA_W-1:0] outside;      // a host's goal
    wire [N*DATA_W-1:0] u_max;        // u_max_i, or less by the bus
    wire [N*DATA_W-1:0] step_max;     // the same less the port anchors' share, for the present step
    wire [N*COEF_W-1:0] clocks_per_volt;
    wire [2*N-1:0]      shape_mode;

    wh_wave_core #(
        .N             (N),
        .DELAY_LOG2    (DELAY_LOG2),
        .OUTSIDE       (HOST),
        .SHAPER        (SHAPER),
        .WITHHELD      (ANCHOR),
        .SHARED        (SHARED)
    ) wave_core (
        .clk           (clk),
        .rst           (drive_rst),
        .start_i       (core_start),
        .busy_o        (core_busy),
        .reads_o       (core_looks),
        .valid_o       (core_valid_o),
        .overrun_o     (core_overrun),
        .current_i     (current_o),
        .eta_i         (eta),
        .outside_i     (outside),
        .ends_i        (current_ends),
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
        .clipped_o     (clipped_o),
        .waves_o       (waves),
        .request_o     (core_request),
        .factor_o      (core_factor),
        .coefficient_o (core_coefficient),
        .product_i     (product)
    );

    // Currents are computed, and steps requested, also while the drive is off.
    wire missing;

    wh_step_watch step_watch (
        .clk       (clk),
        .rst       (sense_rst),
        .start_i   (core_start),
        .tick_i    (tick_o),
        .overrun_o (missing)
    );

    assign overrun_o = adc_overrun || core_overrun || (|anchor_overrun) || missing;

    // ---- Which blocks read settings.

    wire         core_reads;
    wire         scale_reads;
    wire [N-1:0] anchor_reads;
    wire [N-1:0] in_round;
    wire         summed    = |current_request;
    reg          sum_q;  // a sum has begun, and not all its products have

    always @(posedge clk) begin
        sum_q <= run && (adc_valid || (sum_q && !summed));
    end

    assign words_hold_o  = {|in_round, reading && (adc_valid || sum_q || summed), |anchor_hold_o,
                            reading && core_reads};
    assign scale_hold_o  = reading && scale_reads;
    assign anchor_hold_o = {N{reading}} & anchor_reads;

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

    // ---- Effect of the measured bus.

    generate
        if (BUS == 1) begin : measured_bus
            wire bus_gives;

            assign core_reads  = !bus_gives;
            assign scale_reads = !bus_gives;

            // One u_max for a step.
            wire words_hold = !drive_rst && core_looks;

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

            // A voltage is scaled by the settings of the step that made it. The step ends: it reads none
            // any more.
            wire core_ends = core_busy && !core_looks;
            wire scales = (ANCHOR != 0 && core_valid_o) || (|(drive_request & ~others_grant[N +: N]));

            assign core_reads  = core_looks;
            assign scale_reads = core_ends || scales;

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

    // ---- Guard.

    wire [N-1:0] moved;
    wire [N-1:0] direction;
    wire [N-1:0] illegal_move;
    wire         illegal_setting;
    wire [N-1:0] energy_over;
    wire [N-1:0] limited;

    wh_setting_check #(
        .N                 (N)
    ) setting_check (
        .clk               (clk),
        .rst               (rst),
        .half_clocks_i     (half_clocks_i),
        .tick_halves_i     (tick_halves_i),
        .sample_clocks_i   (sample_clocks_i),
        .samples_i         (samples_i),
        .sample_lead_i     (sample_lead_i),
        .sample_late_i     (sample_late_i),
        .whole_i           (whole),
        .least_i           ((MIN_PULSE != 0) ? least : 8'd0),
        .spare_i           ((MIN_PULSE != 0) ? spare : 8'd0),
        .dead_clocks_i     (dead_clocks_i),
        .compensate_i      (compensate_i && DEAD_TIME != 0),
        .compensable_i     (!whole),
        .root_i            (root_i),
        .a_i               (a_i),
        .eta_contact_i     (eta_contact_i),
        .eta_free_i        (eta_free_i),
        .gain_i            (gain_i),
        .clocks_per_volt_i (clocks_per_volt_i),
        .u_max_i           (u_max_i),
        .illegal_o         (illegal_setting)
    );

    genvar g;
    generate
        if (GUARD != 0) begin : guarded
            wire [N-1:0] overspeeds, strays;

            for (g = 0; g < N; g = g + 1) begin : motor
                wh_motion #(
                    .N           (1)
                ) motion (
                    .clk         (clk),
                    .rst         (rst),
                    .restart_i   (sense_rst),
                    .valid_i     (current_valid[N-1]),
                    .port_i      (1'b0),
                    .position_i  (position_o[g*`WH_COUNT_W +: `WH_COUNT_W]),
                    .overspeed_i (overspeed_i[g*16 +: 16]),
                    .low_i       (window_low_i[g*`WH_COUNT_W +: `WH_COUNT_W]),
                    .high_i      (window_high_i[g*`WH_COUNT_W +: `WH_COUNT_W]),
                    .overspeed_o (overspeeds[g]),
                    .outside_o   (strays[g])
                );
            end

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
                .zero_start_i   (zero_begins),
                .zero_busy_i    (|zero_busy_o),
                .trip_i         (overcurrent_o),
                .encoder_i      (illegal_move),
                .moved_i        (moved),
                .direction_i    (direction),
                .anchor_i       (anchor_fault_i | anchor_fault_o),
                .energy_i       (energy_over),
                .saturated_i    (limited),
                .overspeed_i    (|overspeeds),
                .outside_i      (|strays),
                .setting_i      (illegal_setting),
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
                                  anchor_fault_i, illegal_setting, moved, direction, illegal_move,
                                  energy_over, limited, overspeed_i, window_low_i, window_high_i};

            assign faults_o = {`WH_FAULTS{1'b0}};
            assign faulty   = 1'b0;
            assign damp     = 1'b0;
        end
    endgenerate

    // ---- The parts that each motor and each port has.

    wire [N-1:0]        shaped;
    wire [N*COEF_W-1:0] contact_eta;
    wire [N-1:0]        driven_valid;
    wire [N*DATA_W-1:0] driven;

    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : each

            wh_motor #(
                .WALLS               (WALLS),
                .SENSE               (SENSE),
                .ZERO_LOG2           (ZERO_LOG2),
                .DEAD_TIME           (DEAD_TIME),
                .MODES               (MODES),
                .MIN_PULSE           (MIN_PULSE)
            ) motor (
                .clk                 (clk),
                .rst                 (rst),
                .sense_rst_i         (sense_rst),
                .run_i               (run),
                .enc_a_i             (enc_a_i[n]),
                .enc_b_i             (enc_b_i[n]),
                .gate_ah_o           (gate_ah_o[n]),
                .gate_al_o           (gate_al_o[n]),
                .gate_bh_o           (gate_bh_o[n]),
                .gate_bl_o           (gate_bl_o[n]),
                .phase_i             (phase),
                .remaining_i         (remaining),
                .half_i              (half),
                .update_i            (update),
                .take_i              (take),
                .word_valid_i        (adc_valid),
                .word_first_i        (adc_first),
                .word_i              (adc_sample[n*`WH_SAMPLE_W +: `WH_SAMPLE_W]),
                .samples_i           (samples_i),
                .zero_i              (zero_i[n*`WH_SUM_W +: `WH_SUM_W]),
                .range_i             (range_i),
                .stuck_words_i       (stuck_words_i),
                .zero_start_i        (zero_begins),
                .zero_limit_i        (zero_limit_i),
                .offset_i            (offset_o[n*DATA_W +: DATA_W]),
                .current_valid_o     (current_valid[n]),
                .current_o           (current_o[n*DATA_W +: DATA_W]),
                .current_ends_o      (current_ends[2*n +: 2]),
                .adc_range_o         (adc_range_o[n]),
                .adc_stuck_o         (adc_stuck_o[n]),
                .zero_fault_o        (zero_fault_o[n]),
                .zero_busy_o         (zero_busy_o[n]),
                .filter_clocks_i     (filter_clocks_i),
                .clear_i             (clear_i),
                .contact_hold_i      (core_busy),
                .wall_min_i          (wall_min_i[n*WALLS*`WH_COUNT_W +: WALLS*`WH_COUNT_W]),
                .wall_max_i          (wall_max_i[n*WALLS*`WH_COUNT_W +: WALLS*`WH_COUNT_W]),
                .wall_enable_i       (wall_enable_i[n*WALLS +: WALLS]),
                .wall_shaped_i       (wall_shaped_i[n*WALLS +: WALLS]),
                .edge_hysteresis_i   (edge_hysteresis_i[n]),
                .eta_contact_i       (eta_contact_i[n*COEF_W +: COEF_W]),
                .eta_free_i          (eta_free_i[n*COEF_W +: COEF_W]),
                .position_o          (position_o[n*`WH_COUNT_W +: `WH_COUNT_W]),
                .moved_o             (moved[n]),
                .direction_o         (direction[n]),
                .illegal_move_o      (illegal_move[n]),
                .encoder_fault_o     (encoder_fault_o[n]),
                .round_o             (in_round[n]),
                .contact_o           (contact_o[n]),
                .shaped_o            (shaped[n]),
                .eta_o               (contact_eta[n*COEF_W +: COEF_W]),
                .voltage_valid_i     (driven_valid[n]),
                .voltage_i           (driven[n*DATA_W +: DATA_W]),
                .half_clocks_i       (half_clocks_i),
                .mode_i              (mode_i),
                .half_bridge_i       (half_bridge),
                .whole_i             (whole),
                .least_i             (least),
                .spare_i             (spare),
                .clocks_per_volt_i   (clocks_per_volt[n*COEF_W +: COEF_W]),
                .dead_clocks_i       (dead_clocks_i),
                .compensate_i        (compensate_i),
                .side_current_i      (side_current_i[n*DATA_W +: DATA_W]),
                .settle_ticks_i      (settle_ticks_i),
                .second_order_i      (second_order_i),
                .current_request_o   (current_request[n]),
                .current_factor_o    (current_factor[n*DATA_W +: DATA_W]),
                .current_grant_i     (others_grant[n]),
                .current_done_i      (others_done[n]),
                .drive_request_o     (drive_request[n]),
                .drive_factor_o      (drive_factor[n*DATA_W +: DATA_W]),
                .drive_coefficient_o (drive_coefficient[n*COEF_W +: COEF_W]),
                .drive_grant_i       (others_grant[N+n]),
                .drive_done_i        (others_done[N+n]),
                .product_i           (product)
            );

            wh_port #(
                .HOST               (HOST),
                .ANCHOR             (ANCHOR)
            ) port (
                .clk                (clk),
                .rst                (rst),
                .run_i              (run),
                .damp_i             (damp),
                .core_start_i       (core_start),
                .core_valid_i       (core_valid_o),
                .waves_i            (waves[n]),
                .clipped_i          (clipped_o[n]),
                .current_i          (current_o[n*DATA_W +: DATA_W]),
                .u_i                (u_o[n*DATA_W +: DATA_W]),
                .v_i                (v_o[n*DATA_W +: DATA_W]),
                .withheld_i         (withheld[n*DATA_W +: DATA_W]),
                .wave_voltage_i     (wave_voltage[n*DATA_W +: DATA_W]),
                .saturated_i        (saturated_o[n]),
                .u_max_i            (u_max[n*DATA_W +: DATA_W]),
                .step_max_o         (step_max[n*DATA_W +: DATA_W]),
                .eta_o              (eta[n*COEF_W +: COEF_W]),
                .wave_o             (outside[n*DATA_W +: DATA_W]),
                .shape_mode_o       (shape_mode[2*n +: 2]),
                .position_i         (position_o[n*`WH_COUNT_W +: `WH_COUNT_W]),
                .contact_i          (contact_o[n]),
                .shaped_i           (shaped[n]),
                .contact_eta_i      (contact_eta[n*COEF_W +: COEF_W]),
                .host_period_log2_i (host_period_log2_i),
                .host_timeout_i     (host_timeout_i),
                .host_strobe_i      (host_strobe_i[n]),
                .host_sequence_i    (host_sequence_i[n*8 +: 8]),
                .host_u_i           (host_u_i[n*DATA_W +: DATA_W]),
                .host_strobe_o      (host_strobe_o[n]),
                .host_sequence_o    (host_sequence_o[n*8 +: 8]),
                .host_v_o           (host_v_o[n*DATA_W +: DATA_W]),
                .host_active_o      (host_active_o[n]),
                .anchor_words_i     (anchor_words_i[n*`WH_ANCHOR_W +: `WH_ANCHOR_W]),
                .energy_limit_i     (guard_i[`WH_GUARD_ENERGY]),
                .energy_o           (contact_energy_o[n*`WH_ENERGY_W +: `WH_ENERGY_W]),
                .energy_peak_o      (contact_energy_peak_o[n*`WH_ENERGY_W +: `WH_ENERGY_W]),
                .energy_over_o      (energy_over[n]),
                .limited_o          (limited[n]),
                .driven_valid_o     (driven_valid[n]),
                .driven_o           (driven[n*DATA_W +: DATA_W]),
                .voltage_o          (voltage_o[n*DATA_W +: DATA_W]),
                .correction_o       (correction_o[n*DATA_W +: DATA_W]),
                .offset_o           (offset_o[n*DATA_W +: DATA_W]),
                .flux_o             (flux_o[n*DATA_W +: DATA_W]),
                .lag_o              (lag_o[n*DATA_W +: DATA_W]),
                .anchor_reads_o     (anchor_reads[n]),
                .anchor_overrun_o   (anchor_overrun[n]),
                .anchor_fault_o     (anchor_fault_o[n]),
                .request_o          (anchor_request[n]),
                .factor_o           (anchor_factor[n*DATA_W +: DATA_W]),
                .coefficient_o      (anchor_coefficient[n*COEF_W +: COEF_W]),
                .grant_i            (anchor_grant[n]),
                .done_i             (anchor_done[n]),
                .product_i          (product)
            );
        end
    endgenerate

endmodule

`default_nettype wire
