// SPDX-License-Identifier: Apache-2.0
//
// wh_ports: the wave controller of N motors, whose ports take turns.
//
//   wh_pins[N] - encoder, pattern, gates: all that exists once for each motor
//       |
//   wh_adc -> wh_sense -(wh_clarke)----------> wh_core -(wh_legs)-> wh_drive -> (wh_pins, wh_phase_pins)
//   wh_contact_ports -> wh_environment_ports -^   |
//       `------------------> wh_anchor_ports <----'
//
// wh_guard_ports latches faults, wh_energy_ports observes contacts, wh_motion speeds and positions, wh_port_check finds
// illegal settings, wh_carrier times everything, and wh_slots has the schedule.
//
// Each station exists once. wh_slots begins a port's turn; port and bank go from station to station with valid and
// data. Each station keeps the ports' states, and their settings in two banks, in its own memories. One multiplier
// serves all stations but W, by the schedule in wh_slots' header: requests never meet, so no station waits.
//
// For each port it equals wh_controller with SENSE, GUARD and ANCHOR bit for bit, with one exception: a fault switches
// off at once, but damps only from the next round on, so a round is damped for all ports or for none. wh_controller
// damps within a step.
//
// AXES: if bit n is 1, ports n and n + 1 are the axes alpha and beta of a brushless motor. They have consecutive slots
// (wh_slots' header) and equal the integers of cocotb_tests/axes_model.py bit for bit. Both axes have the same settings,
// but for zero and gain, which are those of phases a and b. Encoder and walls are port n's. Legs a and b are port n's,
// c is leg A of port n + 1; driver_fault_i is that of both. Widths are computed once a carrier period, so a tick is a
// whole number of these. If one axis' anchor loses the rotor, both are damped, from the next round on. The electrical
// angle: wh_rotor.
//
// SURFACES: walls across all ports (wh_surfaces), besides those of each port, bit for bit as in
// sim/wavehaptics/ladder/joint.py. A round has two passes: the first computes v, the second is as without surfaces. In
// contact with surfaces, their waves replace every port's goal. If a port's anchor loses its rotor, all ports are damped.
// surface_write_i takes data_i; a frame that is committed is in force from the next round on, and at once while no
// surface acts because the bridges are off or the ports only damp.
//
// Signs, enable_i and restart_i are those of wh_controller. Settings of each port change with force_i, from the next
// round on. The packed settings of all ports may change in reset, or as wh_controller's.
//
// Latency: the last sample of a period reaches the gates with the next tick that ends at least
//     conversion + 32 (N - 1) + 43 + N + 5 SHAPER clocks
// after its sample strobe. A period has at least 32 (N - 1) + 38 clocks, a carrier half at least N + 8.
// With SHAPER = 2, a port takes 36 clocks instead of 32, and the last one 42 instead of 38.
// If the last port is beta's, its motor's legs need 54, 70 or 75 instead of 43 + 5 SHAPER, for SHAPER = 0, 1 or 2, and
// a period ends with 42, 58 or 63 instead of 38. Each brushless motor's third leg adds one to N in the latency and in
// a half's N + 8, which then has three clocks more.
// With SURFACES, the first pass adds 32 (N - 1) + 38 clocks to a period, or 32 (N - 1) + 18 and the clocks in
// wh_surfaces' header if these are more: a period of three ports and eight surfaces has at least 413 clocks.
//
// Live values: live_valid_o strobes with the port, the index of the value, and the value, each once a period; an
// offset that changes in a step comes twice.
// Reset: gates off at the next clock edge, CS_n high, f = 0, no contact, position 0.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_ports #(
    parameter integer N          = 1,  // motors, 1...8
    parameter integer WALLS      = 4,  // walls of each, 1...7
    parameter integer DELAY_LOG2 = 2,  // the delay line keeps 2^DELAY_LOG2 steps, 1...
    parameter integer ADC        = 0,  // reader: 0 wh_adc_serial, 1 wh_adc_max11125, 2 wh_sinc3
    parameter integer OSR        = 32, // ADC = 2: bits a word, 4...256
    parameter integer ZERO_LOG2  = 10, // ticks of a zero, 2^ZERO_LOG2; 2...16
    parameter integer SHAPER     = 0,  // sections of W (wh_shaper_ports), 0...2; 0: W = 1
    parameter integer HOST       = 0,  // 1: a computer can be the environment (wh_host_link)
    parameter integer MODES      = 0,  // 1: mode selects the bridges' pattern; 0: unipolar
    parameter integer MIN_PULSE  = 0,  // 1: min_pulse is in force; 0: pulses may last one clock
    parameter integer SURFACES   = 0,  // across all ports (wh_surfaces), 0...8
    parameter integer AXES       = 0,  // 0...: bit n: ports n, n + 1 are a brushless motor's axes
    parameter integer PORT_W     = (N > 1) ? $clog2(N) : 1  // derived, leave it
) (
    input  wire                         clk,
    input  wire                         rst,
    input  wire                         enable_i,

    // Pins.
    output wire                         adc_cs_n_o,
    output wire                         adc_sclk_o,
    output wire                         adc_din_o,        // ADC = 1: commands
    input  wire [N-1:0]                 adc_sdata_i,      // ADC = 1: bit 0, from one part
    input  wire [N-1:0]                 enc_a_i,          // asynchronous
    input  wire [N-1:0]                 enc_b_i,          // asynchronous
    output wire [N-1:0]                 gate_ah_o,
    output wire [N-1:0]                 gate_al_o,
    output wire [N-1:0]                 gate_bh_o,
    output wire [N-1:0]                 gate_bl_o,
    input  wire                         stop_i,           // asynchronous
    input  wire [N-1:0]                 driver_fault_i,   // asynchronous
    input  wire [`WH_BUS_W-1:0]         bus_i,            // u16q9 V

    // Settings of all ports, in the order of the register map, the first one lowest.
    input  wire [65:0]                  carrier_i,        // wh_carrier
    input  wire [56:0]                  frame_i,          // wh_adc_serial
    input  wire [70:0]                  sense_i,          // trip, range, stuck_words, zero_limit
    input  wire [3:0]                   filter_clocks_i,  // wh_quadrature
    input  wire [2*DELAY_LOG2-1:0]      delay_i,          // extra_ticks, hold_ticks
    input  wire [27:0]                  bridge_i,         // mode, min_pulse, dead_clocks, compensate, settle_ticks,
                                                          // second_order
    input  wire [`WH_GUARD_W-1:0]       guard_i,          // wh_faults.vh
    input  wire [11:0]                  host_i,           // host_period_log2, host_timeout
    input  wire [65*N-1:0]              magnets_i,        // of each brushless motor, its alpha: find, zero_angle,
                                                          // count_angle (wh_rotor)

    // Surfaces across the ports (wh_surface_words), SURFACES > 0; their words are data_i's.
    input  wire                         surface_write_i,  // strobe
    input  wire [9:0]                   surface_address_i,
    input  wire                         surface_commit_i, // strobe
    output wire                         surface_busy_o,
    output wire                         surface_refused_o,
    output wire [6:0]                   surface_refused_row_o,
    input  wire [61:0]                  budget_i,         // u62q46 W: what moving surfaces may give out
    output wire [1:0]                   acting_o,         // surfaces in contact

    // Settings of each port (wh_port_settings).
    input  wire                         force_i,          // the bank in force
    input  wire                         write_i,          // strobe
    input  wire                         write_bank_i,
    input  wire [11:0]                  address_i,
    input  wire [31:0]                  data_i,

    // Commands, strobes.
    input  wire                         clear_i,          // forget faults that are over
    input  wire                         host_alive_i,
    input  wire                         zero_start_i,     // nothing while the bridges are on
    input  wire                         restart_i,        // nothing while the bridges are on
    input  wire                         magnet_start_i,   // nothing while the bridges are on: set or search the angle

    // A computer's environment, HOST = 1 (wh_host_link). Its packets' contents are live values.
    input  wire [N-1:0]                 host_strobe_i,    // an answer for that port
    input  wire [7:0]                   host_sequence_i,  // of the packet that it answers
    input  wire [`WH_DATA_W-1:0]        host_u_i,         // s31q23 √W
    output wire [N-1:0]                 host_strobe_o,    // a packet

    // State.
    output wire                         live_valid_o,     // strobe
    output wire [PORT_W-1:0]            live_port_o,
    output wire [3:0]                   live_word_o,      // WH_LIVE_...
    output wire [31:0]                  live_data_o,      // signed values are sign-extended
    output wire                         tick_o,           // strobe, last clock of a tick
    output wire                         adc_ready_o,      // the ADC is set up, and ticks follow each other
    output wire                         running_o,        // the bridges are on
    output wire                         zero_busy_o,      // zeros are measured
    output wire [N-1:0]                 zero_faults_o,    // no permitted zero was found
    output wire [N-1:0]                 magnets_found_o,  // of a brushed motor: 1
    output wire [32*N-1:0]              magnet_angles_o,  // turns of 2^32; of a brushed motor: 0
    output wire [`WH_FAULTS-1:0]        faults_o          // latched
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam integer LAST   = N - 1;
    localparam [COEF_W-1:0] ONE_STEP = 1;

    // Brushless motors: their axes, and a third leg for each, numbered behind the ports.
    localparam integer BETAS  = AXES << 1;
    localparam integer THIRDS = (AXES & 1) + ((AXES >> 1) & 1) + ((AXES >> 2) & 1) + ((AXES >> 3) & 1)
                                + ((AXES >> 4) & 1) + ((AXES >> 5) & 1) + ((AXES >> 6) & 1);
    localparam integer LEGS   = N + THIRDS;
    localparam integer LEG_W  = (LEGS > 1) ? $clog2(LEGS) : 1;
    localparam integer PHASES = AXES | BETAS | (((1 << THIRDS) - 1) << N);
    localparam integer FLUX_W = `WH_PLACE_W + `WH_SINE_Q;
    localparam integer CELL_W = `WH_SINE_Q + 2;

    wire [(1<<PORT_W)-1:0] alphas = AXES[(1<<PORT_W)-1:0];
    wire [(1<<PORT_W)-1:0] betas  = BETAS[(1<<PORT_W)-1:0];
    wire [(1<<PORT_W)-1:0] axes   = alphas | betas;

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_ports_n_must_be_1_to_8 stop ();
        end
        if (WALLS < 1 || WALLS > 7) begin : illegal_walls
            wh_illegal_parameter_ports_walls_must_be_1_to_7 stop ();
        end
        if (SURFACES < 0 || SURFACES > 8 || (SURFACES > 0 && (N < 2 || N > 3 || SHAPER != 0 || HOST != 0 || AXES != 0)))
        begin : illegal_surfaces
            wh_illegal_parameter_ports_surfaces_need_2_or_3_ports_without_shaper_host_and_axes stop ();
        end
        if (MODES != 0 && MODES != 1) begin : illegal_modes
            wh_illegal_parameter_ports_modes_must_be_0_or_1 stop ();
        end
    endgenerate

    // ---- Settings of all ports.
    wire        [`WH_TICK_W-1:0] half_clocks, tick_halves, sample_clocks;
    wire        [8:0]            samples;
    wire signed [7:0]            sample_lead;
    wire                         sample_late;
    wire        [7:0]            sclk_half_clocks, quiet_clocks, setup_clocks, hold_clocks;
    wire        [5:0]            frame_bits, lead_bits, calibrate_bits;
    wire        [4:0]            data_bits;
    wire                         sclk_idle, read_trailing;
    wire        [15:0]           trip, range, stuck_words;
    wire        [`WH_SUM_W-2:0]  zero_limit;
    wire        [DELAY_LOG2-1:0] extra_ticks, hold_ticks;
    wire        [`WH_MODE_W-1:0] mode;
    wire        [7:0]            min_pulse, dead_clocks, settle_ticks;
    wire                         compensate, second_order;

    assign {sample_late, sample_lead, samples, sample_clocks, tick_halves, half_clocks} = carrier_i;
    assign {read_trailing, sclk_idle, calibrate_bits, hold_clocks, setup_clocks, quiet_clocks, data_bits, lead_bits,
            frame_bits, sclk_half_clocks} = frame_i;
    assign {zero_limit, stuck_words, range, trip} = sense_i;
    assign {hold_ticks, extra_ticks} = delay_i;
    assign {second_order, settle_ticks, compensate, dead_clocks, min_pulse, mode} = bridge_i;

    // Widths that keep every leg's level for min_pulse, as in wh_controller.
    wire       half_bridge = MODES != 0 && mode == `WH_MODE_HALF_BRIDGE;
    wire       whole       = MODES != 0 && mode != `WH_MODE_UNIPOLAR;  // one width for both halves of a period
    wire [7:0] spare       = (MIN_PULSE != 0) ? (min_pulse >> 1) + {7'd0, min_pulse[0]} : 8'd0;
    wire [7:0] least       = (MIN_PULSE == 0)                  ? 8'd0
                           : !whole                          ? min_pulse
                           : (mode == `WH_MODE_SIGN_MAGNITUDE) ? spare : 8'd0;

    // ---- On and off.
    wire faulty;      // the guard requires the bridges off,
    wire damp_wanted; // or damping,
    wire damp;        // from a round's beginning on
    reg  off_q;
    wire run           = enable_i && !(faulty || off_q);
    wire drive_rst     = rst || !run;
    wire zero_begins   = zero_start_i && !run;
    wire sense_restart = restart_i && !(enable_i && !off_q);
    wire sense_rst     = rst || sense_restart;
    wire slots_run;
    wire core_rst      = rst || !slots_run;  // from a round's beginning on
    wire calm_rst      = core_rst || damp;

    always @(posedge clk) begin
        off_q <= faulty && !rst;
    end

    assign running_o = run;

    // ---- Carrier and ADC. The ticks begin when the ADC is ready.
    wire [`WH_TICK_W-1:0]     phase, remaining;
    wire                      half, update, take, last_half, sample, sample_first;
    wire                      word_valid, word_first, adc_overrun;
    wire [N*`WH_SAMPLE_W-1:0] word;
    wire [N-1:0]              trips;
    wire [LEGS*`WH_SAMPLE_W-1:0] words;  // with those of third phases
    wire                      unused_take = &{1'b0, take};

    wh_carrier carrier (
        .clk             (clk),
        .rst             (sense_rst || !adc_ready_o),
        .half_clocks_i   (half_clocks),
        .tick_halves_i   (tick_halves),
        .sample_clocks_i (sample_clocks),
        .samples_i       (samples),
        .sample_lead_i   (sample_lead),
        .sample_late_i   (sample_late),
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
        .sclk_half_clocks_i (sclk_half_clocks),
        .frame_bits_i       (frame_bits),
        .lead_bits_i        (lead_bits),
        .data_bits_i        (data_bits),
        .quiet_clocks_i     (quiet_clocks),
        .setup_clocks_i     (setup_clocks),
        .hold_clocks_i      (hold_clocks),
        .calibrate_bits_i   (calibrate_bits),
        .sclk_idle_i        (sclk_idle),
        .read_trailing_i    (read_trailing),
        .trip_i             (trip),
        .start_i            (sample),
        .first_i            (sample_first),
        .ready_o            (adc_ready_o),
        .valid_o            (word_valid),
        .first_o            (word_first),
        .sample_o           (word),
        .trip_o             (trips),
        .overrun_o          (adc_overrun)
    );

    // ---- Slots.
    wire              summed, slot_valid, slot_bank, slots_overrun, phase_turn, third_turn;
    wire [PORT_W-1:0] slot_port;

    wire              slot_look;   // a first pass, for the surfaces
    wire              slot_waits;  // for them

    wh_slots #(
        .N         (N),
        .SHAPER    (SHAPER),
        .LOOK      ((SURFACES > 0) ? 1 : 0),
        .AXES      (AXES)
    ) slots (
        .clk       (clk),
        .rst       (sense_rst),
        .summed_i  (summed),
        .force_i   (force_i),
        .run_i     (run),
        .damp_i    (damp_wanted),
        .busy_i    (slot_waits),
        .valid_o   (slot_valid),
        .port_o    (slot_port),
        .bank_o    (slot_bank),
        .look_o    (slot_look),
        .phase_o   (phase_turn),
        .third_o   (third_turn),
        .run_o     (slots_run),
        .damp_o    (damp),
        .overrun_o (slots_overrun)
    );

    // ---- The multiplier. Requests never meet, so it needs no arbiter.
    wire                            sense_request, core_request, anchor_request, drive_request, guard_request,
                                    energy_request, axis_request;
    wire signed [DATA_W-1:0]        sense_factor, core_factor, anchor_factor, drive_factor, guard_factor,
                                    energy_factor, axis_factor;
    wire signed [COEF_W-1:0]        sense_coefficient, core_coefficient, anchor_coefficient, drive_coefficient,
                                    guard_coefficient, energy_coefficient, axis_coefficient;
    wire signed [DATA_W+COEF_W-1:0] product;
    reg                             asked_q;

    always @(posedge clk) begin
        asked_q <= sense_request || core_request || anchor_request || drive_request || guard_request
                   || energy_request || axis_request;
    end

    wh_multiply multiply (
        .clk       (clk),
        .take_i    (asked_q),
        .data_i    (anchor_request  ? anchor_factor
                    : core_request  ? core_factor
                    : sense_request ? sense_factor
                    : guard_request ? guard_factor
                    : axis_request ? axis_factor
                    : energy_request ? energy_factor : drive_factor),
        .coef_i    (anchor_request  ? anchor_coefficient
                    : core_request  ? core_coefficient
                    : sense_request ? sense_coefficient
                    : guard_request ? guard_coefficient
                    : axis_request ? axis_coefficient
                    : energy_request ? energy_coefficient : drive_coefficient),
        .product_o (product)
    );

    // ---- Signals between stations.
    wire                     room_valid, offset_valid, flux_valid, lag_valid, correction_valid;
    wire [PORT_W-1:0]        anchor_port;
    wire signed [DATA_W-1:0] anchor_data;
    wire [N-1:0]             anchor_faults;

    // ---- Sense: currents.
    wire                     current_valid, current_bank;
    wire [LEG_W-1:0]         sense_port;
    wire [PORT_W-1:0]        current_port = sense_port[PORT_W-1:0];
    wire signed [DATA_W-1:0] current, current_offset;
    wire [1:0]               current_ends;
    wire [LEGS-1:0]          ranges, stucks, guard_currents, guard_ranges, guard_stucks, zero_faults;
    wire                     sense_valid, sense_phase_valid;  // in the first pass, too
    wire                     phase_valid;    // the current of a phase, or of a brushed motor
    wire signed [DATA_W-1:0] phase_current;
    wire [1:0]               phase_ends;
    wire signed [DATA_W-1:0] beta_current;
    wire [1:0]               beta_ends;
    wire [31:0]              slot_leg     = {{(32 - PORT_W){1'b0}}, slot_port};
    wire [31:0]              offset_leg   = {{(32 - PORT_W){1'b0}}, anchor_port};
    wire [1:0]               kind         = phase_turn ? 2'd2 : {betas[slot_port], axes[slot_port]};
    wire [LEGS-1:0]          offset_rst;
    wire [N-1:0]             forget;         // reset of an axis
    wire                     unused_legs  = &{1'b0, slot_leg[31:LEG_W], offset_leg[31:LEG_W]};

    assign zero_faults_o = zero_faults[N-1:0];

    wh_sense #(
        .N               (LEGS),
        .KINDS           ((AXES != 0) ? 1 : 0),
        .ZERO_LOG2       (ZERO_LOG2)
    ) sense (
        .clk             (clk),
        .rst             (rst),
        .sense_rst_i     (sense_rst),
        .word_valid_i    (word_valid),
        .word_first_i    (word_first),
        .word_i          (words),
        .samples_i       (samples),
        .summed_o        (summed),
        .range_i         (range),
        .stuck_words_i   (stuck_words),
        .guard_current_i (guard_i[`WH_GUARD_CURRENT]),
        .guard_range_i   (guard_i[`WH_GUARD_RANGE]),
        .guard_stuck_i   (guard_i[`WH_GUARD_STUCK]),
        .range_o         (ranges),
        .stuck_o         (stucks),
        .guard_current_o (guard_currents),
        .guard_range_o   (guard_ranges),
        .guard_stuck_o   (guard_stucks),
        .zero_start_i    (zero_begins),
        .bridge_off_i    (!run),
        .zero_limit_i    (zero_limit),
        .zero_busy_o     (zero_busy_o),
        .zero_fault_o    (zero_faults),
        .valid_i         (slot_valid || phase_turn),
        .port_i          (slot_leg[LEG_W-1:0]),
        .bank_i          (slot_bank),
        .kind_i          (kind),
        .beta_i          (beta_current),
        .beta_ends_i     (beta_ends),
        .valid_o         (sense_valid),
        .phase_valid_o   (sense_phase_valid),
        .phase_o         (phase_current),
        .phase_ends_o    (phase_ends),
        .port_o          (sense_port),
        .bank_o          (current_bank),
        .current_o       (current),
        .ends_o          (current_ends),
        .offset_valid_i  (offset_valid),
        .offset_port_i   (offset_leg[LEG_W-1:0]),
        .offset_i        (anchor_data),
        .offset_rst_i    (offset_rst),
        .offset_o        (current_offset),
        .force_i         (force_i),
        .write_i         (write_i),
        .write_bank_i    (write_bank_i),
        .address_i       (address_i),
        .data_i          (data_i),
        .request_o       (sense_request),
        .factor_o        (sense_factor),
        .coefficient_o   (sense_coefficient),
        .product_i       (product)
    );

    // ---- Contact: positions, walls.
    wire [N*`WH_MOVE_W-1:0]       counts;
    wire signed [`WH_COUNT_W-1:0] position;
    wire        [`WH_MOVE_W-1:0]  position_end = position[`WH_MOVE_W-1:0];
    wire                          contact, shaped;
    wire signed [COEF_W-1:0]      contact_eta;

    wh_contact_ports #(
        .N            (N),
        .WALLS        (WALLS)
    ) contacts (
        .clk          (clk),
        .rst          (rst),
        .valid_i      (slot_valid && !betas[slot_port]),  // of both axes
        .port_i       (slot_port),
        .bank_i       (slot_bank),
        .count_i      (round_counts),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .position_o   (position),
        .contact_o    (contact),
        .shaped_o     (shaped),
        .eta_o        (contact_eta)
    );

    // ---- Environment. An anchor that has lost the rotor leaves a port that only damps.
    wire [COEF_W-1:0]        eta;
    wire [DATA_W-1:0]        outside;
    wire [1:0]               shape_mode;
    wire                     host_active;
    wire [7:0]               host_sequence;
    wire [DATA_W-1:0]        host_v;
    wire                     core_valid;
    wire [PORT_W-1:0]        core_port;
    wire                     lost;
    wire signed [DATA_W-1:0] u, v;

    wh_environment_ports #(
        .N                  (N),
        .HOST               (HOST)
    ) environment (
        .clk                (clk),
        .rst                (calm_rst),
        .port_i             (core_port),
        .damps_i            (damp || lost || all_lost),
        .contact_i          (contact),
        .shaped_i           (shaped),
        .eta_i              (contact_eta),
        .step_valid_i       (core_valid),
        .v_i                (v),
        .host_period_log2_i (host_i[3:0]),
        .host_timeout_i     (host_i[11:4]),
        .host_strobe_i      (host_strobe_i),
        .host_sequence_i    (host_sequence_i),
        .host_u_i           (host_u_i),
        .host_strobe_o      (host_strobe_o),
        .host_sequence_o    (host_sequence),
        .host_v_o           (host_v),
        .host_active_o      (host_active),
        .eta_o              (eta),
        .wave_o             (outside),
        .mode_o             (shape_mode)
    );

    // ---- Core: waves, e_id.
    wire                     core_bank, waves_valid, clipped, saturated, saturated_before;
    wire signed [DATA_W-1:0] wave_voltage, voltage_before, withheld_before;

    wh_core #(
        .N                  (N),
        .DELAY_LOG2         (DELAY_LOG2),
        .OUTSIDE            ((SURFACES > 0) ? 1 : HOST),
        .SHAPER             (SHAPER),
        .LOOK               ((SURFACES > 0) ? 1 : 0)
    ) core (
        .clk                (clk),
        .rst                (core_rst),
        .valid_i            (sense_valid),
        .port_i             (current_port),
        .bank_i             (current_bank),
        .look_i             (looking),
        .current_i          (current),
        .ends_i             (current_ends),
        .eta_i              (acts ? {COEF_W{1'b0}} : eta),
        .outside_i          (acts ? surface_wave : outside),
        .shape_mode_i       (shape_mode),
        .extra_ticks_i      (extra_ticks),
        .hold_ticks_i       (hold_ticks),
        .room_rst_i         ({N{calm_rst}} | forget),
        .room_valid_i       (room_valid),
        .room_port_i        (anchor_port),
        .room_i             (anchor_data),
        .write_i            (write_i),
        .write_bank_i       (write_bank_i),
        .address_i          (address_i),
        .data_i             (data_i),
        .request_o          (core_request),
        .factor_o           (core_factor),
        .coefficient_o      (core_coefficient),
        .product_i          (product),
        .valid_o            (core_valid),
        .waves_valid_o      (waves_valid),
        .looked_o           (looked),
        .goal_o             (goal),
        .port_o             (core_port),
        .bank_o             (core_bank),
        .voltage_o          (wave_voltage),
        .u_o                (u),
        .v_o                (v),
        .clipped_o          (clipped),
        .saturated_o        (saturated),
        .voltage_before_o   (voltage_before),
        .withheld_before_o  (withheld_before),
        .saturated_before_o (saturated_before)
    );

    // ---- Surfaces across the ports. A round's first pass finds what comes in at each port, or what a wall of its own
    // makes of it. In the second one the surfaces' waves are every port's goal. An anchor that has lost its rotor
    // leaves ports that only damp, all of them.
    wire                     looking;   // the slot is one of the first pass
    wire                     looked;
    wire                     acts;      // surfaces do, in this round
    wire                     all_lost;
    wire signed [DATA_W-1:0] goal, surface_wave;
    wire [N*`WH_MOVE_W-1:0]  round_counts;

    assign current_valid = sense_valid && !looking;
    assign phase_valid   = sense_phase_valid && !looking;

    generate
        if (SURFACES > 0) begin : in_space
            wire        begins = slot_valid && slot_look && slot_port == {PORT_W{1'b0}};
            reg         looking_q, lost_q, looked_q;
            reg  [N*`WH_MOVE_W-1:0]  counts_q;
            reg  signed [DATA_W-1:0] wave_q;
            reg  signed [COEF_W-1:0] free_q;
            wire        [COEF_W-1:0] free;
            wire                     frame_taken, answered, busy;
            wire [6:0]               surface_row;
            wire [2:0]               surface_place;
            wire [31:0]              surface_word;
            wire [7:0]               present;
            wire [1:0]               answered_port;
            wire signed [DATA_W-1:0] answer;
            wire [31:0]              core_number = {{(32 - PORT_W){1'b0}}, core_port};
            wire                     unused_port = &{1'b0, core_number[31:2], answered_port};

            // Both passes of a round see the same positions, η and faults.
            wire lost_now = (core_port == {PORT_W{1'b0}}) ? |anchor_faults : lost_q;

            always @(posedge clk) begin
                if (slot_valid) begin
                    looking_q <= slot_look;
                end
                if (begins) begin
                    counts_q <= counts;
                end
                looked_q <= looked && !lost_now && !calm_rst;
                if (looked) begin
                    lost_q <= lost_now;
                    wave_q <= contact ? goal : v;
                    free_q <= (core_port == {PORT_W{1'b0}} || $signed(free) < free_q) ? $signed(free) : free_q;
                end
                if (calm_rst) begin
                    lost_q <= 1'b0;
                end
                if (sense_rst) begin
                    looking_q <= 1'b0;
                end
            end

            assign looking      = looking_q;
            assign all_lost     = lost_q;
            assign round_counts = begins ? counts : counts_q;
            assign acts         = (|acting_o) && !lost_q && !looking_q;
            assign slot_waits   = busy;

            wh_port_settings #(
                .N            (N),
                .WORDS_LOG2   (0),
                .W            (COEF_W),
                .FIRST        (9),  // eta_free
                .BLOCK        (0)
            ) frees (
                .clk          (clk),
                .write_i      (write_i),
                .write_bank_i (write_bank_i),
                .address_i    (address_i),
                .data_i       (data_i),
                .read_i       (slot_valid),
                .bank_i       (slot_bank),
                .port_i       (slot_port),
                .word_i       (1'b0),
                .word_o       (free)
            );

            wh_surface_words surface_words (
                .clk       (clk),
                .rst       (rst),
                .write_i   (surface_write_i),
                .address_i (surface_address_i),
                .data_i    (data_i),
                .commit_i  (surface_commit_i),
                .busy_o    (surface_busy_o),
                .refused_o (surface_refused_o),
                .refused_row_o (surface_refused_row_o),
                .take_i    (frame_taken || calm_rst || lost_q),
                .row_i     (surface_row),
                .word_i    (surface_place),
                .word_o    (surface_word),
                .present_o (present)
            );

            wh_surfaces #(
                .PORTS      (N),
                .SURFACES   (SURFACES)
            ) surfaces (
                .clk        (clk),
                .rst        (calm_rst),
                .valid_i    (looked_q),
                .port_i     (core_number[1:0]),
                .position_i (position),
                .current_i  (current),
                .wave_i     (wave_q),
                .free_i     (free_q),
                .budget_i   (budget_i),
                .take_o     (frame_taken),
                .row_o      (surface_row),
                .word_o     (surface_place),
                .word_i     (surface_word),
                .present_i  (present),
                .busy_o     (busy),
                .valid_o    (answered),
                .port_o     (answered_port),
                .wave_o     (answer),
                .acting_o   (acting_o)
            );

            wh_port_state #(
                .N           (N),
                .W           (DATA_W)
            ) answers (
                .clk         (clk),
                .rst         (calm_rst),
                .port_i      (core_port),
                .save_i      (answered),
                .save_port_i (answered_port[PORT_W-1:0]),
                .value_i     (answer),
                .value_o     (surface_wave)
            );
        end else begin : without_surfaces
            wire unused_surfaces = &{1'b0, slot_look, looked, goal, surface_write_i, surface_address_i,
                                     surface_commit_i, budget_i};

            assign looking           = 1'b0;
            assign all_lost          = 1'b0;
            assign round_counts      = counts;
            assign acts              = 1'b0;
            assign slot_waits        = 1'b0;
            assign surface_wave      = {DATA_W{1'b0}};
            assign surface_busy_o    = 1'b0;
            assign surface_refused_o = 1'b0;
            assign surface_refused_row_o = 7'd0;
            assign acting_o          = 2'd0;
        end
    endgenerate

    // ---- Anchor: c.
    wire [2*FLUX_W-1:0]      places;  // of both axes of the brushless motor whose turn it is
    wire [2*CELL_W-1:0]      cells;

    wh_anchor_ports #(
        .N                  (N),
        .AXES               (AXES)
    ) anchors (
        .clk                (clk),
        .rst                (calm_rst),
        .valid_i            (waves_valid),
        .port_i             (core_port),
        .bank_i             (core_bank),
        .position_i         (position),
        .place_i            (betas[core_port] ? places[2*FLUX_W-1:FLUX_W] : places[FLUX_W-1:0]),
        .cell_i             (betas[core_port] ? cells[2*CELL_W-1:CELL_W] : cells[CELL_W-1:0]),
        .found_i            (magnets_found_o),
        .forget_i           (forget),
        .contact_i          (contact || host_active || acts),  // a host may set any current
        .blind_i            (clipped),
        .current_i          (current),
        .u_i                (u),
        .v_i                (v),
        .withheld_i         (withheld_before),
        .voltage_i          (voltage_before),
        .saturated_i        (saturated_before),
        .write_i            (write_i),
        .write_bank_i       (write_bank_i),
        .address_i          (address_i),
        .data_i             (data_i),
        .request_o          (anchor_request),
        .factor_o           (anchor_factor),
        .coefficient_o      (anchor_coefficient),
        .product_i          (product),
        .room_valid_o       (room_valid),
        .offset_valid_o     (offset_valid),
        .flux_valid_o       (flux_valid),
        .lag_valid_o        (lag_valid),
        .correction_valid_o (correction_valid),
        .port_o             (anchor_port),
        .data_o             (anchor_data),
        .faults_o           (anchor_faults)
    );

    // ---- Energy: what contacts deliver.
    wire                           energy_valid, peak_valid;
    wire signed [`WH_ENERGY_W-1:0] energy, energy_peak;
    wire [N-1:0]                   energy_over;

    wh_energy_ports #(
        .N              (N)
    ) energies (
        .clk            (clk),
        .rst            (rst),
        .run_i          (run),
        .valid_i        (waves_valid && !axes[core_port]),
        .port_i         (core_port),
        .contact_i      (contact && !host_active),
        .position_i     (position_end),
        .current_i      (current),
        .limit_i        (guard_i[`WH_GUARD_ENERGY]),
        .request_o      (energy_request),
        .factor_o       (energy_factor),
        .coefficient_o  (energy_coefficient),
        .product_i      (product),
        .energy_valid_o (energy_valid),
        .peak_valid_o   (peak_valid),
        .energy_o       (energy),
        .peak_o         (energy_peak),
        .over_o         (energy_over)
    );

    // ---- Drive: widths, of all ports in time for the end of each half, or of each period.
    localparam integer           AHEAD = ((AXES != 0) ? 8 : 5) + LEGS;  // clocks of a half's end
    wire                         walk_due = !(sense_rst || !adc_ready_o) && remaining == AHEAD[`WH_TICK_W-1:0]
                                            && (half || !whole);
    wire                         walk;
    wire signed [DATA_W-1:0]     voltage, correction;
    wire                         width_valid;
    wire [LEG_W-1:0]             width_leg;
    wire                         leg_valid;       // the current out of a leg
    wire [LEG_W-1:0]             leg;
    wire signed [DATA_W-1:0]     leg_current;     // with leg_valid,
    wire signed [DATA_W-1:0]     leg_current_after;  // and a clock later
    wire [7:0]                   leg_settle;
    wire                         duty_valid;
    wire [LEG_W-1:0]             duty_leg;
    wire signed [`WH_TICK_W-1:0] width;

    wh_drive #(
        .N                  (N),
        .MIN_PULSE          (MIN_PULSE),
        .LEGS               (LEGS),
        .PHASES             (PHASES)
    ) drive (
        .clk                (clk),
        .rst                (drive_rst),
        .current_valid_i    (leg_valid),
        .current_port_i     (current_port),
        .current_leg_i      (leg),
        .current_bank_i     (current_bank),
        .current_i          (leg_current_after),
        .voltage_valid_i    (core_valid),
        .voltage_port_i     (core_port),
        .voltage_bank_i     (core_bank),
        .voltage_axis_i     (axes[core_port]),
        .voltage_i          (wave_voltage),
        .voltage_o          (voltage),
        .correction_o       (correction),
        .duty_valid_i       (duty_valid),
        .duty_leg_i         (duty_leg),
        .correction_rst_i   ({N{calm_rst}} | forget),
        .correction_valid_i (correction_valid),
        .correction_port_i  (anchor_port),
        .correction_i       (anchor_data),
        .half_clocks_i      (half_clocks),
        .compensate_i       (compensate),
        .dead_clocks_i      (dead_clocks),
        .settle_ticks_i     (leg_settle),
        .second_order_i     (second_order),
        .least_i            (least),
        .spare_i            (spare),
        .write_i            (write_i),
        .write_bank_i       (write_bank_i),
        .address_i          (address_i),
        .data_i             (data_i),
        .request_o          (drive_request),
        .factor_o           (drive_factor),
        .coefficient_o      (drive_coefficient),
        .product_i          (product),
        .walk_i             (walk),
        .half_i             (half),
        .take_i             (last_half),
        .width_valid_o      (width_valid),
        .width_leg_o        (width_leg),
        .width_o            (width)
    );

    // ---- Illegal settings: those of all ports, checked with legal ones of a port, and those of each port.
    localparam ALL_AXES = (AXES | BETAS) == (1 << N) - 1;
    wire illegal_setting, illegal_port;

    wh_setting_check setting_check (
        .clk               (clk),
        .rst               (rst),
        .half_clocks_i     (half_clocks),
        .tick_halves_i     (tick_halves),
        .sample_clocks_i   (sample_clocks),
        .samples_i         (samples),
        .sample_lead_i     (sample_lead),
        .sample_late_i     (sample_late),
        .whole_i           (whole || AXES != 0),
        .least_i           (ALL_AXES ? 8'd0 : least),
        .spare_i           (spare),
        .dead_clocks_i     (dead_clocks),
        .compensate_i      (compensate),
        .compensable_i     (!whole || ALL_AXES),
        .root_i            (ONE_STEP),
        .a_i               (ONE_STEP),
        .eta_contact_i     (ONE_STEP),
        .eta_free_i        (ONE_STEP),
        .gain_i            (ONE_STEP),
        .clocks_per_volt_i (ONE_STEP),
        .u_max_i           ({DATA_W{1'b0}}),
        .illegal_o         (illegal_setting)
    );

    wh_port_check #(
        .N            (N)
    ) port_check (
        .clk          (clk),
        .rst          (rst),
        .force_i      (force_i),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .illegal_o    (illegal_port)
    );

    // ---- Guard: faults.
    wire         missing;
    wire [N-1:0] moved, directions, illegal_moves, encoder_faults;
    localparam [LEGS-1:0] OF_PORTS = (1 << N) - 1;
    wire [LEGS-1:0] leg_drivers, leg_trips, leg_illegal_moves, leg_moved, leg_directions, leg_anchor_faults;
    wire [LEGS-1:0] leg_energies;
    wire         round = current_valid && current_port == LAST[PORT_W-1:0];

    wh_step_watch step_watch (
        .clk       (clk),
        .rst       (sense_rst),
        .start_i   (round),
        .tick_i    (tick_o),
        .overrun_o (missing)
    );

    // Speeds and positions: of brushless motors once, at alpha's turn.
    wire                          moves_turn = slot_valid && !slot_look && !betas[slot_port];
    wire [15:0]                   overspeed_limit;
    wire signed [`WH_COUNT_W-1:0] window_low, window_high;
    wire                          overspeed, strays;

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (0),
        .W            (16),
        .FIRST        (49),
        .BLOCK        (0)
    ) overspeeds (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (moves_turn),
        .bank_i       (slot_bank),
        .port_i       (slot_port),
        .word_i       (1'b0),
        .word_o       (overspeed_limit)
    );

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (0),
        .W            (`WH_COUNT_W),
        .FIRST        (50),
        .BLOCK        (0)
    ) lows (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (moves_turn),
        .bank_i       (slot_bank),
        .port_i       (slot_port),
        .word_i       (1'b0),
        .word_o       (window_low)
    );

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (0),
        .W            (`WH_COUNT_W),
        .FIRST        (51),
        .BLOCK        (0)
    ) highs (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (moves_turn),
        .bank_i       (slot_bank),
        .port_i       (slot_port),
        .word_i       (1'b0),
        .word_o       (window_high)
    );

    wh_motion #(
        .N            (N)
    ) motion (
        .clk          (clk),
        .rst          (rst),
        .restart_i    (sense_rst),
        .valid_i      (moves_turn),
        .port_i       (slot_port),
        .position_i   (position),
        .overspeed_i  (overspeed_limit),
        .low_i        (window_low),
        .high_i       (window_high),
        .overspeed_o  (overspeed),
        .outside_o    (strays)
    );

    wh_guard_ports #(
        .N               (LEGS)
    ) guard (
        .clk             (clk),
        .rst             (rst),
        .settings_i      (guard_i),
        .clear_i         (clear_i),
        .running_i       (run),
        .stop_i          (stop_i),
        .driver_i        (leg_drivers),
        .host_alive_i    (host_alive_i),
        .bus_i           (bus_i),
        .current_cause_i (guard_currents),
        .range_cause_i   (guard_ranges),
        .stuck_cause_i   (guard_stucks),
        .range_i         (ranges & OF_PORTS),
        .stuck_i         (stucks & OF_PORTS),
        .zero_i          (zero_faults & OF_PORTS),
        .zero_start_i    (zero_begins),
        .zero_busy_i     (zero_busy_o),
        .trip_i          (leg_trips),
        .encoder_i       (leg_illegal_moves),
        .moved_i         (leg_moved),
        .direction_i     (leg_directions),
        .anchor_i        (leg_anchor_faults),
        .energy_i        (leg_energies),
        .overspeed_i     (overspeed),
        .outside_i       (strays),
        .setting_i       (illegal_setting || illegal_port),
        .overrun_i       (adc_overrun || slots_overrun || missing),
        .tick_i          (tick_o),
        .valid_i         (leg_valid),
        .port_i          (leg),
        .current_i       (leg_current),
        .waves_valid_i   (waves_valid),
        .u_i             (u),
        .v_i             (v),
        .saturated_i     (saturated_before && contact && !host_active),
        .request_o       (guard_request),
        .factor_o        (guard_factor),
        .coefficient_o   (guard_coefficient),
        .product_i       (product),
        .faults_o        (faults_o),
        .off_o           (faulty),
        .damp_o          (damp_wanted)
    );

    // ---- Pins. Brushless motors are numbered as their third legs are.
    localparam integer                MOTORS  = (THIRDS > 0) ? THIRDS : 1;
    wire [MOTORS*`WH_COUNT_W-1:0]     rotor_positions;
    wire [65*MOTORS-1:0]              rotor_magnets;
    wire [`WH_MOVE_W-1:0]             rotor_count;  // of the port whose slot begins
    wire [MOTORS-1:0]                 rotors_found, rotors_forget;
    wire [32*MOTORS-1:0]              rotor_angles;
    wire                              unused_magnets = &{1'b0, magnets_i, magnet_start_i, half_bridge};

    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : motor
            if (((BETAS >> n) & 1) != 0) begin : beta
                wire unused = &{1'b0, enc_a_i[n], enc_b_i[n]};

                assign gate_bh_o[n]                          = 1'b0;
                assign gate_bl_o[n]                          = 1'b0;
                assign counts[n*`WH_MOVE_W +: `WH_MOVE_W]    = {`WH_MOVE_W{1'b0}};
                assign illegal_moves[n]                      = 1'b0;
            end else if (((AXES >> n) & 1) != 0) begin : brushless
                localparam integer THIRD = N + (n > 0 ? (AXES & 1) : 0) + (n > 1 ? (AXES >> 1) & 1 : 0)
                                           + (n > 2 ? (AXES >> 2) & 1 : 0) + (n > 3 ? (AXES >> 3) & 1 : 0)
                                           + (n > 4 ? (AXES >> 4) & 1 : 0) + (n > 5 ? (AXES >> 5) & 1 : 0);
                wire signed [`WH_COUNT_W-1:0] encoder_position;
                wire [31:0]                   width_of = {{(32 - LEG_W){1'b0}}, width_leg};
                wire                          moves, direction, fault;

                assign moved[n+1:n]                  = {2{moves}};
                assign directions[n+1:n]             = {2{direction}};
                assign encoder_faults[n+1:n]         = {2{fault}};
                assign magnets_found_o[n+1:n]        = {2{rotors_found[THIRD-N]}};
                assign magnet_angles_o[32*n +: 64]   = {2{rotor_angles[32*(THIRD-N) +: 32]}};
                assign forget[n+1:n]                 = {2{rotors_forget[THIRD-N]}};
                assign leg_moved[THIRD]              = moves;
                assign leg_directions[THIRD]         = direction;
                assign counts[n*`WH_MOVE_W +: `WH_MOVE_W]             = rotor_count;
                assign rotor_magnets[65*(THIRD-N) +: 65]              = magnets_i[65*n +: 65];
                assign rotor_positions[`WH_COUNT_W*(THIRD-N) +: `WH_COUNT_W] = encoder_position;

                wh_phase_pins phase_pins (
                    .clk             (clk),
                    .rst             (rst),
                    .run_i           (run),
                    .enc_a_i         (enc_a_i[n]),
                    .enc_b_i         (enc_b_i[n]),
                    .gate_high_o     ({gate_ah_o[n+1], gate_bh_o[n], gate_ah_o[n]}),
                    .gate_low_o      ({gate_al_o[n+1], gate_bl_o[n], gate_al_o[n]}),
                    .filter_clocks_i (filter_clocks_i),
                    .clear_i         (clear_i),
                    .position_o      (encoder_position),
                    .moved_o         (moves),
                    .direction_o     (direction),
                    .illegal_move_o  (illegal_moves[n]),
                    .encoder_fault_o (fault),
                    .phase_i         (phase),
                    .remaining_i     (remaining),
                    .half_i          (half),
                    .update_i        (update),
                    .width_valid_i   ({3{width_valid}} & {width_of == THIRD, width_of == n + 1, width_of == n}),
                    .width_i         (width),
                    .half_clocks_i   (half_clocks),
                    .dead_clocks_i   (dead_clocks)
                );
            end else begin : brushed
                assign magnets_found_o[n]          = 1'b1;
                assign magnet_angles_o[32*n +: 32] = 32'd0;
                assign forget[n]                   = 1'b0;

                wh_pins #(
                    .MODES           (MODES)
                ) pins (
                    .clk             (clk),
                    .rst             (rst),
                    .run_i           (run),
                    .enc_a_i         (enc_a_i[n]),
                    .enc_b_i         (enc_b_i[n]),
                    .gate_ah_o       (gate_ah_o[n]),
                    .gate_al_o       (gate_al_o[n]),
                    .gate_bh_o       (gate_bh_o[n]),
                    .gate_bl_o       (gate_bl_o[n]),
                    .filter_clocks_i (filter_clocks_i),
                    .clear_i         (clear_i),
                    .count_o         (counts[n*`WH_MOVE_W +: `WH_MOVE_W]),
                    .moved_o         (moved[n]),
                    .direction_o     (directions[n]),
                    .illegal_move_o  (illegal_moves[n]),
                    .encoder_fault_o (encoder_faults[n]),
                    .phase_i         (phase),
                    .remaining_i     (remaining),
                    .half_i          (half),
                    .update_i        (update),
                    .width_valid_i   (width_valid && {{(32 - LEG_W){1'b0}}, width_leg} == n),
                    .width_i         (width),
                    .half_clocks_i   (half_clocks),
                    .mode_i          (mode),
                    .half_bridge_i   (half_bridge),
                    .dead_clocks_i   (dead_clocks)
                );
            end
        end
    endgenerate

    // ---- Brushless motors: between phases and axes, and the turn of a rotor.
    generate
        if (AXES != 0) begin : with_axes
            // Where no current has a side the legs try both, and three that try the same one drive nothing: so leg b
            // waits for so many ticks longer between two changes than leg a, and leg c twice that.
            localparam integer PACE    = 3;
            localparam [7:0]   MOST    = 8'd255 - 2 * PACE[7:0];
            localparam integer TURNED  = 18;  // clocks from beta's waves to its χ
            localparam integer ENDS    = 33;
            localparam integer MOTOR_W = (MOTORS > 1) ? $clog2(MOTORS) : 1;

            // Third phases: words, currents.
            reg  signed [DATA_W-1:0] phase_a_q;
            reg  [1:0]               ends_a_q;
            reg  signed [DATA_W-1:0] third_q;
            reg                      third_turn_q;
            wire signed [DATA_W-1:0] third;
            wire signed [DATA_W+1:0] wide_third = -$signed({{2{phase_a_q[DATA_W-1]}}, phase_a_q})
                                                  - $signed({{2{phase_current[DATA_W-1]}}, phase_current});
            reg  [LEG_W-1:0]         third_leg;
            reg  [7:0]               settle_q;
            wire [7:0]               settle = (settle_ticks > MOST) ? MOST : settle_ticks;
            reg  [LEG_W-1:0]         third_of;  // of the port whose voltage is there
            reg  [31:0]              look_motor, turn_motor;  // number of the motor whose slot begins, whose turn ends
            reg  [PORT_W-1:0]        turn_port_q;             // its beta's
            integer                  k, place;

            wh_saturate #(
                .IN_W    (DATA_W + 2),
                .OUT_W   (DATA_W)
            ) saturate_third (
                .value_i (wide_third),
                .value_o (third)
            );

            always @* begin
                third_leg = {LEG_W{1'b0}};
                third_of  = {LEG_W{1'b0}};
                look_motor = 32'd0;
                turn_motor = 32'd0;
                place     = N;
                for (k = 1; k < N; k = k + 1) begin
                    if (((BETAS >> k) & 1) != 0) begin
                        third_leg = third_leg | (({{(32 - PORT_W){1'b0}}, current_port} == k) ? place[LEG_W-1:0]
                                                                                           : {LEG_W{1'b0}});
                        third_of  = third_of | (({{(32 - PORT_W){1'b0}}, core_port} == k) ? place[LEG_W-1:0]
                                                                                          : {LEG_W{1'b0}});
                        look_motor = look_motor
                                     | (({{(32 - PORT_W){1'b0}}, slot_port} == k - 1) ? place - N : 32'd0);
                        turn_motor = turn_motor
                                     | (({{(32 - PORT_W){1'b0}}, turn_port_q} == k) ? place - N : 32'd0);
                        place     = place + 1;
                    end
                end
            end

            always @(posedge clk) begin
                third_q      <= third;
                third_turn_q <= third_turn;
                if (phase_valid && alphas[current_port]) begin
                    phase_a_q <= phase_current;
                    ends_a_q  <= phase_ends;
                end
                if (leg_valid) begin
                    settle_q <= third_turn            ? settle + 2 * PACE[7:0]
                                : betas[current_port] ? settle + PACE[7:0]
                                : alphas[current_port] ? settle : settle_ticks;
                end
            end

            assign leg_valid         = phase_valid || third_turn;
            assign leg               = third_turn ? third_leg : sense_port;
            assign leg_current       = third_turn ? third_q : phase_current;
            assign leg_current_after = third_turn_q ? third_q : phase_current;
            assign leg_settle        = settle_q;

            for (n = 0; n < N - 1; n = n + 1) begin : phases
                if (((AXES >> n) & 1) != 0) begin : of_motor
                    localparam integer THIRD = N + (n > 0 ? (AXES & 1) : 0) + (n > 1 ? (AXES >> 1) & 1 : 0)
                                               + (n > 2 ? (AXES >> 2) & 1 : 0) + (n > 3 ? (AXES >> 3) & 1 : 0)
                                               + (n > 4 ? (AXES >> 4) & 1 : 0) + (n > 5 ? (AXES >> 5) & 1 : 0);
                    wire signed [`WH_SAMPLE_W-1:0] word_a = $signed(word[n*`WH_SAMPLE_W +: `WH_SAMPLE_W]);
                    wire signed [`WH_SAMPLE_W-1:0] word_b = $signed(word[(n+1)*`WH_SAMPLE_W +: `WH_SAMPLE_W]);
                    wire signed [`WH_SAMPLE_W+1:0] wide   = -$signed({{2{word_a[`WH_SAMPLE_W-1]}}, word_a})
                                                            - $signed({{2{word_b[`WH_SAMPLE_W-1]}}, word_b});

                    wh_saturate #(
                        .IN_W    (`WH_SAMPLE_W + 2),
                        .OUT_W   (`WH_SAMPLE_W)
                    ) saturate_word (
                        .value_i (wide),
                        .value_o (words[THIRD*`WH_SAMPLE_W +: `WH_SAMPLE_W])
                    );

                    assign leg_drivers[THIRD] = driver_fault_i[n];
                end
            end

            assign leg_trips[LEGS-1:N]         = {THIRDS{1'b0}};
            assign leg_illegal_moves[LEGS-1:N] = {THIRDS{1'b0}};
            assign leg_anchor_faults[LEGS-1:N] = {THIRDS{1'b0}};
            assign leg_energies[LEGS-1:N]      = {THIRDS{1'b0}};
            assign offset_rst[LEGS-1:N]        = {THIRDS{1'b0}};

            // Transforms.
            wire                     clarke_request, legs_request, clarke_valid;
            wire signed [DATA_W-1:0] clarke_factor, legs_factor, clarke_alpha;
            wire signed [COEF_W-1:0] clarke_coefficient, legs_coefficient;
            wire [1:0]               clarke_ends;
            reg  [3:1]               clarke_asked_q;  // clocks since the request
            wire                     unused_clarke = &{1'b0, clarke_valid, clarke_alpha};

            always @(posedge clk) begin
                clarke_asked_q <= sense_rst ? 3'd0 : {clarke_asked_q[2:1], clarke_request};
            end

            wh_clarke clarke (
                .clk           (clk),
                .rst           (sense_rst),
                .valid_i       (phase_valid && betas[current_port]),
                .a_i           (phase_a_q),
                .b_i           (phase_current),
                .request_o     (clarke_request),
                .grant_i       (1'b1),
                .factor_o      (clarke_factor),
                .coefficient_o (clarke_coefficient),
                .done_i        (clarke_asked_q[3]),
                .product_i     (product),
                .valid_o       (clarke_valid),
                .alpha_o       (clarke_alpha),
                .beta_o        (beta_current),
                .beta_ends_o   (clarke_ends)
            );

            assign beta_ends = clarke_ends | ends_a_q | phase_ends;

            wh_legs #(
                .SHAPER        (SHAPER),
                .LEG_W         (LEG_W)
            ) of_legs (
                .clk           (clk),
                .rst           (drive_rst),
                .valid_i       (core_valid && axes[core_port]),
                .beta_i        (betas[core_port]),
                .port_i        (core_leg[LEG_W-1:0]),
                .third_i       (third_of),
                .voltage_i     (voltage),
                .request_o     (legs_request),
                .factor_o      (legs_factor),
                .coefficient_o (legs_coefficient),
                .scale_i       (drive_coefficient),
                .product_i     (product),
                .duty_valid_o  (duty_valid),
                .duty_leg_o    (duty_leg)
            );

            // All three legs are driven by one step: the walk waits until all three duties are there.
            reg  walk_waits_q;

            always @(posedge clk) begin
                walk_waits_q <= !sense_rst && (walk_due || walk_waits_q) && duty_valid;
            end

            assign walk = (walk_due || walk_waits_q) && !duty_valid;

            wire [31:0] core_leg    = {{(32 - PORT_W){1'b0}}, core_port};
            wire        unused_core = &{1'b0, core_leg[31:LEG_W]};

            assign axis_request     = clarke_request || legs_request;
            assign axis_factor      = clarke_request ? clarke_factor : legs_factor;
            assign axis_coefficient = clarke_request ? clarke_coefficient : legs_coefficient;

            // If one axis' anchor loses the rotor, the other axis is damped too, in the same step.
            wire [N-1:0] either = anchor_faults | (anchor_faults >> 1);
            reg          lost_q;

            always @(posedge clk) begin
                if (current_valid && alphas[current_port]) begin
                    lost_q <= either[current_port];
                end
            end

            assign lost = axes[core_port] ? lost_q : anchor_faults[core_port];

            // The rotor's turn, as seen by both anchors.
            reg  [5:0]               after_q;    // clocks since beta's waves
            reg                      contact_q;
            reg  signed [DATA_W-1:0] flux_a_q;
            reg  signed [DATA_W-1:0] flux_b_q;

            always @(posedge clk) begin
                if (core_rst) begin
                    after_q <= 6'd0;
                end else if (waves_valid && betas[core_port]) begin
                    after_q <= 6'd1;
                end else if (after_q != 6'd0) begin
                    after_q <= (after_q == ENDS[5:0]) ? 6'd0 : after_q + 6'd1;
                end
                if (waves_valid && betas[core_port]) begin
                    turn_port_q <= core_port;
                    contact_q   <= contact || host_active;
                end
                if (calm_rst) begin
                    flux_a_q <= {DATA_W{1'b0}};
                    flux_b_q <= {DATA_W{1'b0}};
                end else if (flux_valid && alphas[anchor_port]) begin
                    flux_a_q <= anchor_data;
                end else if (flux_valid && betas[anchor_port]) begin
                    flux_b_q <= anchor_data;
                end
            end

            wire [`WH_REST_W-1:0] turn_rest;
            wire                  unused_motor = &{1'b0, look_motor[31:MOTOR_W], turn_motor[31:MOTOR_W]};

            wh_rotor #(
                .MOTORS       (MOTORS)
            ) rotor (
                .clk          (clk),
                .rst          (rst),
                .position_i   (rotor_positions),
                .magnets_i    (rotor_magnets),
                .start_i      (magnet_start_i && !(enable_i && !off_q)),
                .look_i       (slot_valid && alphas[slot_port]),
                .motor_i      (look_motor[MOTOR_W-1:0]),
                .done_i       (after_q == TURNED[5:0]),  // both anchors have taken the rotor's flux,
                .forget_i     (after_q == ENDS[5:0]),    // and everything else
                .turn_motor_i (turn_motor[MOTOR_W-1:0]),
                .contact_i    (contact_q),
                .rest_ticks_i (turn_rest),
                .flux_i       ({flux_b_q, flux_a_q}),
                .count_o      (rotor_count),
                .place_o      (places),
                .cell_o       (cells),
                .found_o      (rotors_found),
                .forget_o     (rotors_forget),
                .angle_o      (rotor_angles)
            );

            wh_port_settings #(
                .N            (N),
                .WORDS_LOG2   (0),
                .W            (`WH_REST_W),
                .FIRST        (45),  // the anchor's slow_ticks
                .BLOCK        (0)
            ) rests (
                .clk          (clk),
                .write_i      (write_i),
                .write_bank_i (write_bank_i),
                .address_i    (address_i),
                .data_i       (data_i),
                .read_i       (waves_valid && betas[core_port]),
                .bank_i       (core_bank),
                .port_i       (core_port),
                .word_i       (1'b0),
                .word_o       (turn_rest)
            );
        end else begin : without_axes
            wire unused_axes = &{1'b0, phase_ends, third_turn, alphas, betas, axes, rotors_found, rotors_forget,
                                 rotor_angles, rotor_count, rotor_magnets, rotor_positions};

            assign walk              = walk_due;
            assign leg_valid         = phase_valid;
            assign leg               = sense_port;
            assign leg_current       = phase_current;
            assign leg_current_after = phase_current;
            assign leg_settle        = settle_ticks;
            assign axis_request      = 1'b0;
            assign axis_factor       = {DATA_W{1'b0}};
            assign axis_coefficient  = {COEF_W{1'b0}};
            assign beta_current      = {DATA_W{1'b0}};
            assign beta_ends         = 2'b00;
            assign duty_valid        = 1'b0;
            assign duty_leg          = {LEG_W{1'b0}};
            assign lost              = anchor_faults[core_port];
            assign places            = {2*FLUX_W{1'b0}};
            assign cells             = {2*CELL_W{1'b0}};
            assign rotor_positions   = {MOTORS*`WH_COUNT_W{1'b0}};
            assign rotor_magnets     = {65*MOTORS{1'b0}};
            assign rotor_count       = {`WH_MOVE_W{1'b0}};
            assign rotors_found      = {MOTORS{1'b0}};
            assign rotors_forget     = {MOTORS{1'b0}};
            assign rotor_angles      = {32*MOTORS{1'b0}};
        end
    endgenerate

    assign words[N*`WH_SAMPLE_W-1:0] = word;
    assign offset_rst[N-1:0]         = {N{calm_rst}} | forget;
    assign leg_drivers[N-1:0]        = driver_fault_i;
    assign leg_trips[N-1:0]          = trips;
    assign leg_illegal_moves[N-1:0]  = illegal_moves;
    assign leg_moved[N-1:0]          = moved;
    assign leg_directions[N-1:0]     = directions;
    assign leg_anchor_faults[N-1:0]  = anchor_faults;
    assign leg_energies[N-1:0]       = energy_over;

    // ---- Live values, each in its own clock of the slot: 8 current, 9 position, 10, 11 a host's packet,
    // 13 u, 14 v, 15 flags, 19, 20 energy of the contact and its most, 32, 33 e and c of it, with W later; 27 offset,
    // 29 χ, 36 ω̂. They are all held until then. 16 the offset
    // as it was, 17, 18 χ and ω̂ where they are damped: 0.
    reg [12:1] since_q;  // clocks since the current was valid
    reg [2:1] drove_q;  // the voltage, of this port
    reg [PORT_W-1:0] drove_port_q;
    reg signed [DATA_W-1:0] voltage_q;
    reg signed [DATA_W-1:0] correction_q;
    reg run_q;

    always @(posedge clk) begin
        run_q        <= run;
        since_q      <= sense_rst ? 12'd0 : {since_q[11:1], current_valid};
        drove_q      <= core_rst ? 2'd0 : {drove_q[1], core_valid};
        if (core_valid) begin
            drove_port_q <= core_port;
            voltage_q    <= voltage;
            correction_q <= correction;
        end
    end

    wire [31:0] flags = {21'd0, stucks[sense_port], shaped, clipped, host_active, anchor_faults[current_port],
                         encoder_faults[current_port], ranges[sense_port], trips[current_port], run_q,
                         saturated_before, contact || acts};
    wire        waves_1 = since_q[7] && !core_rst;
    wire        waves_2 = since_q[8] && !core_rst;
    wire        waves_3 = since_q[10] && !core_rst;
    wire        damped  = (|since_q[12:11]) && damp && !core_rst;

    reg  [3:0]               word_now;
    reg  [31:0]              data_now;
    reg  signed [DATA_W-1:0] value_now;
    wire                     anchored = offset_valid || flux_valid || lag_valid;

    always @* begin
        value_now = current;
        word_now  = `WH_LIVE_CURRENT;
        if (anchored) begin
            value_now = anchor_data;
            word_now  = offset_valid ? `WH_LIVE_OFFSET : flux_valid ? `WH_LIVE_FLUX : `WH_LIVE_LAG;
        end else if (drove_q[1]) begin
            value_now = voltage_q;
            word_now  = `WH_LIVE_VOLTAGE;
        end else if (drove_q[2]) begin
            value_now = correction_q;
            word_now  = `WH_LIVE_CORRECTION;
        end else if (since_q[7]) begin
            value_now = u;
            word_now  = `WH_LIVE_U;
        end else if (since_q[8]) begin
            value_now = v;
            word_now  = `WH_LIVE_V;
        end else if (since_q[3]) begin
            word_now  = `WH_LIVE_POSITION;
        end else if (since_q[4]) begin
            value_now = $signed(host_v);
            word_now  = `WH_LIVE_HOST_V;
        end else if (since_q[5]) begin
            word_now  = `WH_LIVE_HOST_SEQUENCE;
        end else if (since_q[9]) begin
            word_now  = `WH_LIVE_FLAGS;
        end else if (since_q[10]) begin
            value_now = current_offset;
            word_now  = `WH_LIVE_OFFSET;
        end else if (|since_q[12:11]) begin
            value_now = {DATA_W{1'b0}};
            word_now  = since_q[11] ? `WH_LIVE_FLUX : `WH_LIVE_LAG;
        end
        data_now = {{(32 - DATA_W){value_now[DATA_W-1]}}, value_now};
        if (energy_valid) begin
            word_now = `WH_LIVE_ENERGY;
            data_now = {{(32 - `WH_ENERGY_W){energy[`WH_ENERGY_W-1]}}, energy};
        end else if (peak_valid) begin
            word_now = `WH_LIVE_ENERGY_PEAK;
            data_now = {{(32 - `WH_ENERGY_W){1'b0}}, energy_peak};
        end else if (word_now == `WH_LIVE_POSITION) begin
            data_now = position;
        end else if (word_now == `WH_LIVE_HOST_SEQUENCE) begin
            data_now = {24'd0, host_sequence};
        end else if (word_now == `WH_LIVE_FLAGS) begin
            data_now = flags;
        end
    end

    reg              live_valid_q;
    reg [PORT_W-1:0] live_port_q;
    reg [3:0]        live_word_q;
    reg [31:0]       live_data_q;

    always @(posedge clk) begin
        live_valid_q <= (|since_q[3:2]) || (HOST == 1 && (|since_q[5:4])) || since_q[9] || waves_1 || waves_2 || waves_3
                        || (|drove_q) || energy_valid || peak_valid || anchored || damped;
        live_port_q  <= anchored                       ? anchor_port
                        : (|drove_q)                   ? drove_port_q
                        : (energy_valid || peak_valid) ? core_port : current_port;
        live_word_q  <= word_now;
        live_data_q  <= data_now;
    end

    assign live_valid_o = live_valid_q;
    assign live_port_o  = live_port_q;
    assign live_word_o  = live_word_q;
    assign live_data_o  = live_data_q;

    wire unused = &{1'b0, saturated};

endmodule

`default_nettype wire
