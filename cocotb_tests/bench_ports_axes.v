// SPDX-License-Identifier: Apache-2.0
//
// bench_ports_axes: wh_ports with a brushless motor beside a wh_brushless, with the same pins and settings, and a
// brushed one of its ports beside a wh_controller.
//
// The brushless motor is the first one of AXES, the brushed one is the first port that isn't of any; both axes have
// alpha's settings. The ADC parts are those of bench_ports, as are what is gathered, differs_o of each port, and what
// is done about damping. An axis has no energies. hold_flux_i lets the flux of both stand still, whatever the rotor
// does, so that magnets are found.
// Where the bridges go off in the midst of a step, one of the two may have made it and the other one not: of energies
// and magnets nothing is known then, unknown_o, until rst.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module bench_ports_axes #(
    parameter integer N          = 2,
    parameter integer AXES       = 1,
    parameter integer WALLS      = 4,
    parameter integer DELAY_LOG2 = 2,
    parameter integer ZERO_LOG2  = 3,
    parameter integer SHAPER     = 0,
    parameter integer MODES      = 0,
    parameter integer MIN_PULSE  = 0,
    parameter integer SECTION_W  = ((SHAPER > 0) ? SHAPER : 1) * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W),
    parameter integer PORT_W     = (N > 1) ? $clog2(N) : 1
) (
    input  wire                         clk,
    input  wire                         rst,
    input  wire                         enable_i,

    input  wire [N*12-1:0]              code_i,           // of the ADC parts, taken as CS_n falls
    input  wire [N*12-1:0]              noise_i,          // bits of it that are noise
    input  wire [N-1:0]                 enc_a_i,
    input  wire [N-1:0]                 enc_b_i,
    input  wire                         stop_i,
    input  wire [N-1:0]                 driver_fault_i,
    input  wire [`WH_BUS_W-1:0]         bus_i,

    input  wire [65:0]                  carrier_i,
    input  wire [56:0]                  frame_i,
    input  wire [70:0]                  sense_i,
    input  wire [3:0]                   filter_clocks_i,
    input  wire [2*DELAY_LOG2-1:0]      delay_i,
    input  wire [27:0]                  bridge_i,
    input  wire [`WH_GUARD_W-1:0]       guard_i,

    input  wire [N*`WH_SUM_W-1:0]       zero_i,           // of wh_brushless and wh_controller
    input  wire [N*`WH_COEF_W-1:0]      gain_i,
    input  wire [N*WALLS*`WH_COUNT_W-1:0] wall_min_i,
    input  wire [N*WALLS*`WH_COUNT_W-1:0] wall_max_i,
    input  wire [N*WALLS-1:0]           wall_enable_i,
    input  wire [N-1:0]                 edge_hysteresis_i,
    input  wire [N*`WH_COEF_W-1:0]      eta_contact_i,
    input  wire [N*`WH_COEF_W-1:0]      eta_free_i,
    input  wire [N*SECTION_W-1:0]       shape_words_i,
    input  wire [N*WALLS-1:0]           wall_shaped_i,
    input  wire [N*`WH_COEF_W-1:0]      root_i,
    input  wire [N*`WH_COEF_W-1:0]      a_i,
    input  wire [N*`WH_DATA_W-1:0]      u_max_i,
    input  wire [N*`WH_ANCHOR_W-1:0]    anchor_words_i,
    input  wire [N*`WH_COEF_W-1:0]      clocks_per_volt_i,
    input  wire [N*`WH_DATA_W-1:0]      side_current_i,

    input  wire                         force_i,          // of wh_ports
    input  wire                         write_i,
    input  wire                         write_bank_i,
    input  wire [11:0]                  address_i,
    input  wire [31:0]                  data_i,

    input  wire                         clear_i,
    input  wire                         host_alive_i,
    input  wire                         zero_start_i,
    input  wire                         restart_i,
    input  wire [11:0]                  host_i,
    input  wire [64:0]                  magnets_i,        // find, zero_angle, count_angle
    input  wire                         magnet_start_i,
    input  wire                         hold_flux_i,

    output wire                         tick_o,
    output wire                         round_o,          // strobe, the first port's slot begins
    output wire                         adc_ready_o,
    output wire [1:0]                   running_o,        // wh_ports, wh_brushless
    output wire [`WH_FAULTS-1:0]        faults_o,         // of wh_ports
    output wire [`WH_FAULTS-1:0]        controller_faults_o,  // of wh_brushless
    output wire [12*N-1:0]              differs_o,
    output reg                          energy_unknown_o, // and magnets, as above
    output wire [N-1:0]                 energy_o,         // of a contact, but 0
    output reg                          frames_differ_o,  // until rst
    output reg                          gates_differ_o,
    output reg                          met_o,            // two stations asked for a product at once
    output wire                         angle_differs_o,  // the magnets', or whether they are found
    output wire                         found_o,
    output wire [N-1:0]                 contact_o,
    output wire [N-1:0]                 clipped_o,
    output wire [N-1:0]                 anchor_fault_o,
    output wire [N*`WH_DATA_W-1:0]      correction_o,
    output wire [N*`WH_DATA_W-1:0]      voltage_o,
    output wire [N*`WH_DATA_W-1:0]      offset_o
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam integer COUNT_W = `WH_COUNT_W;
    localparam integer BETAS  = AXES << 1;

    // Alpha of the first brushless motor, and the first brushed motor; N: none.
    localparam integer A = ((AXES & 1) != 0) ? 0 : ((AXES & 2) != 0) ? 1 : ((AXES & 4) != 0) ? 2 : 3;
    localparam integer EVERY = AXES | BETAS;
    localparam integer B = ((EVERY & 1) == 0) ? 0 : ((EVERY & 2) == 0) ? 1 : ((EVERY & 4) == 0) ? 2
                           : ((EVERY & 8) == 0) ? 3 : 4;
    localparam integer BRUSHED = (B < N) ? 1 : 0;
    localparam integer P = (BRUSHED == 1) ? B : 0;

    // ---- ADC parts.
    wire         cs_n, sclk;
    reg          cs_before_q, sclk_before_q;
    reg  [4:0]   pulse_q;
    reg  [N*12-1:0] code_q;
    reg  [31:0]  lfsr_q;
    wire [N-1:0] sdata;
    wire [3:0]   place = 4'd14 - pulse_q[3:0];  // 12 bits from the third pulse on

    integer k;
    always @(posedge clk) begin
        cs_before_q   <= cs_n;
        sclk_before_q <= sclk;
        if (rst) begin
            lfsr_q <= 32'hdead_beef;
        end else if (cs_before_q && !cs_n) begin
            pulse_q <= 5'd0;
            lfsr_q  <= {lfsr_q[30:0], lfsr_q[31] ^ lfsr_q[21] ^ lfsr_q[1] ^ lfsr_q[0]};
            for (k = 0; k < N; k = k + 1) begin
                code_q[12*k +: 12] <= code_i[12*k +: 12] ^ (lfsr_q[2*k +: 12] & noise_i[12*k +: 12]);
            end
        end else if (!cs_n && !sclk && sclk_before_q) begin
            pulse_q <= pulse_q + 5'd1;
        end
    end

    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : part
            assign sdata[n] = pulse_q >= 5'd3 && pulse_q <= 5'd14 && code_q[12*n + place];
        end
    endgenerate

    // ---- wh_ports.
    wire              live_valid;
    wire [PORT_W-1:0] live_port;
    wire [3:0]        live_word;
    wire [31:0]       live_data;
    wire              ports_cs_n, ports_sclk, ports_din;
    wire [N-1:0]      ports_ah, ports_al, ports_bh, ports_bl;
    wire              ports_tick, ports_ready;
    wire [N-1:0]      ports_packet;
    wire              ports_zero_busy;
    wire [N-1:0]      ports_zero_faults;
    wire [N-1:0]      ports_found;
    wire [32*N-1:0]   ports_angles;
    wire              unused_zero = &{1'b0, ports_zero_busy, ports_zero_faults,  // faults_o has them
                                      ports_found, ports_angles, ports_packet};

    wire [N-1:0]      alphas = AXES[N-1:0];

    wh_ports #(
        .N               (N),
        .WALLS           (WALLS),
        .DELAY_LOG2      (DELAY_LOG2),
        .ZERO_LOG2       (ZERO_LOG2),
        .SHAPER          (SHAPER),
        .AXES            (AXES),
        .MODES           (MODES),
        .MIN_PULSE       (MIN_PULSE)
    ) ports (
        .clk             (clk),
        .rst             (rst),
        .enable_i        (enable_i),
        .adc_cs_n_o      (ports_cs_n),
        .adc_sclk_o      (ports_sclk),
        .adc_din_o       (ports_din),
        .adc_sdata_i     (sdata),
        .enc_a_i         (enc_a_i),
        .enc_b_i         (enc_b_i),
        .gate_ah_o       (ports_ah),
        .gate_al_o       (ports_al),
        .gate_bh_o       (ports_bh),
        .gate_bl_o       (ports_bl),
        .stop_i          (stop_i),
        .driver_fault_i  ((driver_fault_i & ~(alphas << 1)) | ((driver_fault_i & alphas) << 1)),
        .bus_i           (bus_i),
        .carrier_i       (carrier_i),
        .frame_i         (frame_i),
        .sense_i         (sense_i),
        .filter_clocks_i (filter_clocks_i),
        .delay_i         (delay_i),
        .bridge_i        (bridge_i),
        .guard_i         (guard_i),
        .force_i         (force_i),
        .write_i         (write_i),
        .write_bank_i    (write_bank_i),
        .address_i       (address_i),
        .data_i          (data_i),
        .clear_i         (clear_i),
        .host_alive_i    (host_alive_i),
        .zero_start_i    (zero_start_i),
        .restart_i       (restart_i),
        .magnet_start_i  (magnet_start_i),
        .magnets_i       ({N{magnets_i}}),
        .host_i          (host_i),
        .host_strobe_i   ({N{1'b0}}),
        .host_sequence_i (8'd0),
        .host_u_i        ({DATA_W{1'b0}}),
        .host_strobe_o   (ports_packet),
        .live_valid_o    (live_valid),
        .live_port_o     (live_port),
        .live_word_o     (live_word),
        .live_data_o     (live_data),
        .tick_o          (ports_tick),
        .adc_ready_o     (ports_ready),
        .running_o       (running_o[0]),
        .zero_busy_o     (ports_zero_busy),
        .zero_faults_o   (ports_zero_faults),
        .magnets_found_o (ports_found),
        .magnet_angles_o (ports_angles),
        .faults_o        (faults_o)
    );

    // Both others are made to damp, and an axis that is lost to take the other one with it, from a step to the next as
    // well, by the same rounds: by themselves they do so in the midst of a step.
    reg damp_q;
    reg lost_q;

    always @(posedge clk) begin
        if (rst) begin
            damp_q <= 1'b0;
        end else if (round_o) begin
            damp_q <= (|controller_faults_o) && !brushless.guarded.guard.off_o;
        end
        if (brushless.core_start) begin
            lost_q <= brushless.anchor_fault_o;
        end
    end

    always @(damp_q) begin
        force brushless.damp = damp_q;
    end

    wire [COEF_W-1:0] brushless_eta = (damp_q || lost_q) ? {COEF_W{1'b0}} : brushless.contact_eta;

    always @(brushless_eta) begin
        force brushless.axes.eta = brushless_eta;
    end

    // A flux that stands still.
    always @(hold_flux_i) begin
        if (hold_flux_i) begin
            force brushless.place = {2*(`WH_PLACE_W+`WH_SINE_Q){1'b0}};
            force ports.motor[A].brushless.rotor.place = {2*(`WH_PLACE_W+`WH_SINE_Q){1'b0}};
        end else begin
            release brushless.place;
            release ports.motor[A].brushless.rotor.place;
        end
    end

    assign round_o = ports.slot_valid && ports.slot_port == {PORT_W{1'b0}};

    wire [6:0] requests = {ports.sense_request, ports.core_request, ports.anchor_request, ports.drive_request,
                           ports.guard_request, ports.energy_request, ports.axis_request};

    always @(posedge clk) begin
        if (rst) begin
            met_o <= 1'b0;
        end else if ((requests & (requests - 7'd1)) != 7'd0
                     || (ports.with_axes.clarke_request && ports.with_axes.legs_request)) begin
            met_o <= 1'b1;
        end
    end

    // The last value of each; what a step's reset sets to 0 is set to 0.
    reg [32*(16<<PORT_W)-1:0] live_q;

    integer p;
    always @(posedge clk) begin
        if (live_valid) begin
            live_q[32*{live_port, live_word} +: 32] <= live_data;
        end
        for (p = 0; p < N; p = p + 1) begin
            if (rst || ports.core_rst) begin
                live_q[32*(16*p + `WH_LIVE_VOLTAGE) +: 32] <= 32'd0;
                live_q[32*(16*p + `WH_LIVE_U) +: 32]       <= 32'd0;
                live_q[32*(16*p + `WH_LIVE_V) +: 32]       <= 32'd0;
            end
            if (rst || ports.sense_rst) begin
                live_q[32*(16*p + `WH_LIVE_CURRENT) +: 32] <= 32'd0;
            end
            if (rst) begin
                live_q[32*(16*p + `WH_LIVE_ENERGY) +: 32]      <= 32'd0;
                live_q[32*(16*p + `WH_LIVE_ENERGY_PEAK) +: 32] <= 32'd0;
            end
            if (rst || ports.calm_rst || ports.forget[p]) begin
                live_q[32*(16*p + `WH_LIVE_CORRECTION) +: 32] <= 32'd0;
                live_q[32*(16*p + `WH_LIVE_OFFSET) +: 32]     <= 32'd0;
                live_q[32*(16*p + `WH_LIVE_FLUX) +: 32]       <= 32'd0;
                live_q[32*(16*p + `WH_LIVE_LAG) +: 32]        <= 32'd0;
            end
        end
    end

    // ---- wh_brushless, with the same settings.
    wire                 core_valid, contact, encoder_fault, overrun, scale_hold, anchor_hold, lost,
                         found;
    wire [2:0]           high, low;
    wire [2*DATA_W-1:0]  voltage, u, v, current, phase_current, correction, offset, flux, lag;
    wire [COUNT_W-1:0]   position;
    wire [1:0]           saturated, clipped, adc_range, adc_stuck, zero_fault, zero_busy, overcurrent;
    wire [31:0]          angle;
    wire [3:0]           words_hold;
    wire                 unused = &{1'b0, overrun, scale_hold, anchor_hold, encoder_fault, phase_current, saturated,
                                    adc_range, adc_stuck, zero_fault, zero_busy, overcurrent, words_hold, ports_din};

    wh_brushless #(
        .WALLS              (WALLS),
        .DELAY_LOG2         (DELAY_LOG2),
        .SENSE              (1),
        .SHAPER             (SHAPER),
        .MIN_PULSE          (MIN_PULSE),
        .ZERO_LOG2          (ZERO_LOG2),
        .ANCHOR             (1),
        .GUARD              (1)
    ) brushless (
        .clk                (clk),
        .rst                (rst),
        .enable_i           (enable_i),
        .adc_cs_n_o         (cs_n),
        .adc_sclk_o         (sclk),
        .adc_sdata_i        (sdata[A+1:A]),
        .enc_a_i            (enc_a_i[A]),
        .enc_b_i            (enc_b_i[A]),
        .gate_high_o        (high),
        .gate_low_o         (low),
        .half_clocks_i      (carrier_i[15:0]),
        .tick_halves_i      (carrier_i[31:16]),
        .sample_clocks_i    (carrier_i[47:32]),
        .samples_i          (carrier_i[56:48]),
        .sample_lead_i      ($signed(carrier_i[64:57])),
        .sample_late_i      (carrier_i[65]),
        .sclk_half_clocks_i (frame_i[7:0]),
        .frame_bits_i       (frame_i[13:8]),
        .lead_bits_i        (frame_i[19:14]),
        .data_bits_i        (frame_i[24:20]),
        .quiet_clocks_i     (frame_i[32:25]),
        .setup_clocks_i     (frame_i[40:33]),
        .hold_clocks_i      (frame_i[48:41]),
        .calibrate_bits_i   (frame_i[54:49]),
        .sclk_idle_i        (frame_i[55]),
        .read_trailing_i    (frame_i[56]),
        .trip_i             (sense_i[15:0]),
        .zero_i             (zero_i[A*`WH_SUM_W +: 2*`WH_SUM_W]),
        .range_i            (sense_i[31:16]),
        .stuck_words_i      (sense_i[47:32]),
        .zero_start_i       (zero_start_i),
        .zero_limit_i       (sense_i[70:48]),
        .gain_i             (gain_i[A*COEF_W +: 2*COEF_W]),
        .filter_clocks_i    (filter_clocks_i),
        .wall_min_i         (wall_min_i[A*WALLS*COUNT_W +: WALLS*COUNT_W]),
        .wall_max_i         (wall_max_i[A*WALLS*COUNT_W +: WALLS*COUNT_W]),
        .wall_enable_i      (wall_enable_i[A*WALLS +: WALLS]),
        .edge_hysteresis_i  (edge_hysteresis_i[A]),
        .eta_contact_i      (eta_contact_i[A*COEF_W +: COEF_W]),
        .eta_free_i         (eta_free_i[A*COEF_W +: COEF_W]),
        .shape_words_i      (shape_words_i[A*SECTION_W +: SECTION_W]),
        .wall_shaped_i      (wall_shaped_i[A*WALLS +: WALLS]),
        .root_i             (root_i[A*COEF_W +: COEF_W]),
        .a_i                (a_i[A*COEF_W +: COEF_W]),
        .u_max_i            (u_max_i[A*DATA_W +: DATA_W]),
        .extra_ticks_i      (delay_i[DELAY_LOG2-1:0]),
        .hold_ticks_i       (delay_i[2*DELAY_LOG2-1:DELAY_LOG2]),
        .anchor_words_i     (anchor_words_i[A*`WH_ANCHOR_W +: `WH_ANCHOR_W]),
        .count_angle_i      (magnets_i[31:0]),
        .zero_angle_i       (magnets_i[63:32]),
        .find_magnet_i      (magnets_i[64]),
        .magnet_start_i     (magnet_start_i),
        .min_pulse_i        (bridge_i[9:2]),
        .clocks_per_volt_i  (clocks_per_volt_i[A*COEF_W +: COEF_W]),
        .dead_clocks_i      (bridge_i[17:10]),
        .compensate_i       (bridge_i[18]),
        .side_current_i     (side_current_i[A*DATA_W +: DATA_W]),
        .settle_ticks_i     (bridge_i[26:19]),
        .second_order_i     (bridge_i[27]),
        .guard_i            (guard_i),
        .clear_i            (clear_i),
        .stop_i             (stop_i),
        .driver_fault_i     (driver_fault_i[A]),
        .host_alive_i       (host_alive_i),
        .bus_i              (bus_i),
        .faults_o           (controller_faults_o),
        .running_o          (running_o[1]),
        .adc_ready_o        (adc_ready_o),
        .tick_o             (tick_o),
        .core_valid_o       (core_valid),
        .voltage_o          (voltage),
        .u_o                (u),
        .v_o                (v),
        .current_o          (current),
        .phase_current_o    (phase_current),
        .position_o         (position),
        .contact_o          (contact),
        .saturated_o        (saturated),
        .clipped_o          (clipped),
        .correction_o       (correction),
        .offset_o           (offset),
        .flux_o             (flux),
        .lag_o              (lag),
        .magnet_found_o     (found),
        .magnet_angle_o     (angle),
        .anchor_fault_o     (lost),
        .adc_range_o        (adc_range),
        .adc_stuck_o        (adc_stuck),
        .zero_fault_o       (zero_fault),
        .zero_busy_o        (zero_busy),
        .overcurrent_o      (overcurrent),
        .encoder_fault_o    (encoder_fault),
        .restart_i          (restart_i),
        .words_hold_o       (words_hold),
        .scale_hold_o       (scale_hold),
        .anchor_hold_o      (anchor_hold),
        .overrun_o          (overrun)
    );

    assign found_o         = found;
    assign angle_differs_o = {found, angle} != {ports_found[A], ports_angles[32*A +: 32]};

    // What its last step saw, and whether that was since it was on.
    reg [COUNT_W-1:0]  position_q;
    reg                contact_q;
    reg                stepped_q;
    reg                sensed_q;     // a current was made
    reg [2*DATA_W-1:0] voltage_q;

    always @(posedge clk) begin
        if (!running_o[1] || !running_o[0] || rst) begin
            stepped_q <= 1'b0;
        end else if (core_valid) begin
            stepped_q <= 1'b1;
        end
        if (rst || ports.sense_rst) begin
            sensed_q <= 1'b0;
        end else if (brushless.core_start) begin
            sensed_q <= 1'b1;
        end
        if (rst) begin
            contact_q  <= 1'b0;
        end else if (core_valid) begin
            position_q <= position;
            contact_q  <= contact;
        end
        if (brushless.drive_rst) begin
            voltage_q <= {2*DATA_W{1'b0}};
        end else if (core_valid) begin
            voltage_q <= voltage;
        end
    end

    // A step is under way from a round's beginning to the next tick.
    reg       steps_q;
    reg [1:0] running_q;

    always @(posedge clk) begin
        running_q <= running_o;
        if (rst) begin
            steps_q          <= 1'b0;
            energy_unknown_o <= 1'b0;
        end else begin
            steps_q <= round_o || (steps_q && !tick_o);
            if ((round_o || steps_q) && (running_q & ~running_o) != 2'b00) begin
                energy_unknown_o <= 1'b1;
            end
        end
    end

    genvar m;
    generate
        for (m = 0; m < 2; m = m + 1) begin : axis
            wire [32*16-1:0] live = live_q[32*16*(A+m) +: 32*16];
            wire unused_live = &{1'b0, live};

            assign energy_o[A+m]                         = 1'b0;
            assign contact_o[A+m]                        = contact_q;
            assign clipped_o[A+m]                        = clipped[m];
            assign anchor_fault_o[A+m]                   = lost;
            assign correction_o[(A+m)*DATA_W +: DATA_W]  = correction[m*DATA_W +: DATA_W];
            assign voltage_o[(A+m)*DATA_W +: DATA_W]     = voltage[m*DATA_W +: DATA_W];
            assign offset_o[(A+m)*DATA_W +: DATA_W]      = offset[m*DATA_W +: DATA_W];

            assign differs_o[12*(A+m) +: 12] = {
                2'b00,
                live[32*`WH_LIVE_LAG +: DATA_W] != lag[m*DATA_W +: DATA_W],
                live[32*`WH_LIVE_FLUX +: DATA_W] != flux[m*DATA_W +: DATA_W],
                live[32*`WH_LIVE_OFFSET +: DATA_W] != offset[m*DATA_W +: DATA_W],
                live[32*`WH_LIVE_CORRECTION +: DATA_W] != correction[m*DATA_W +: DATA_W],
                live[32*`WH_LIVE_VOLTAGE +: DATA_W] != voltage_q[m*DATA_W +: DATA_W],
                |ports.anchor_faults[A+1:A] != lost
                || (stepped_q && {live[32*`WH_LIVE_FLAGS+`WH_FLAG_CLIPPED], live[32*`WH_LIVE_FLAGS]}
                                 != {clipped[m], contact_q}),
                stepped_q && live[32*`WH_LIVE_POSITION +: 32] != position_q,
                sensed_q && live[32*`WH_LIVE_CURRENT +: DATA_W] != current[m*DATA_W +: DATA_W],
                live[32*`WH_LIVE_V +: DATA_W] != v[m*DATA_W +: DATA_W],
                live[32*`WH_LIVE_U +: DATA_W] != u[m*DATA_W +: DATA_W]
            };
        end
    endgenerate

    // ---- A brushed motor beside it, if there is one.
    wire brushed_gates_differ;

    generate
        if (BRUSHED == 1) begin : brushed
            wire                   b_cs_n, b_sclk, b_din, b_tick, b_ready, b_running, b_valid;
            wire                   ah, al, bh, bl;
            wire [`WH_FAULTS-1:0]  b_faults;
            wire [DATA_W-1:0]      b_voltage, b_correction, b_offset, b_flux, b_lag, b_u, b_v, b_current;
            wire [COUNT_W-1:0]     b_position;
            wire                   b_contact, b_lost, b_clipped;
            wire [`WH_ENERGY_W-1:0] b_energy, b_peak;

            wh_controller #(
                .N                  (1),
                .WALLS              (WALLS),
                .DELAY_LOG2         (DELAY_LOG2),
                .SENSE              (1),
                .SHAPER             (SHAPER),
                .MODES              (MODES),
                .MIN_PULSE          (MIN_PULSE),
                .ZERO_LOG2          (ZERO_LOG2),
                .ANCHOR             (1),
                .GUARD              (1)
            ) controller (
                .clk                (clk),
                .rst                (rst),
                .enable_i           (enable_i),
                .adc_cs_n_o         (b_cs_n),
                .adc_sclk_o         (b_sclk),
                .adc_din_o          (b_din),
                .adc_sdata_i        (sdata[P]),
                .enc_a_i            (enc_a_i[P]),
                .enc_b_i            (enc_b_i[P]),
                .gate_ah_o          (ah),
                .gate_al_o          (al),
                .gate_bh_o          (bh),
                .gate_bl_o          (bl),
                .half_clocks_i      (carrier_i[15:0]),
                .tick_halves_i      (carrier_i[31:16]),
                .sample_clocks_i    (carrier_i[47:32]),
                .samples_i          (carrier_i[56:48]),
                .sample_lead_i      ($signed(carrier_i[64:57])),
                .sample_late_i      (carrier_i[65]),
                .sclk_half_clocks_i (frame_i[7:0]),
                .frame_bits_i       (frame_i[13:8]),
                .lead_bits_i        (frame_i[19:14]),
                .data_bits_i        (frame_i[24:20]),
                .quiet_clocks_i     (frame_i[32:25]),
                .setup_clocks_i     (frame_i[40:33]),
                .hold_clocks_i      (frame_i[48:41]),
                .calibrate_bits_i   (frame_i[54:49]),
                .sclk_idle_i        (frame_i[55]),
                .read_trailing_i    (frame_i[56]),
                .trip_i             (sense_i[15:0]),
                .zero_i             (zero_i[P*`WH_SUM_W +: `WH_SUM_W]),
                .range_i            (sense_i[31:16]),
                .stuck_words_i      (sense_i[47:32]),
                .zero_start_i       (zero_start_i),
                .zero_limit_i       (sense_i[70:48]),
                .gain_i             (gain_i[P*COEF_W +: COEF_W]),
                .filter_clocks_i    (filter_clocks_i),
                .wall_min_i         (wall_min_i[P*WALLS*COUNT_W +: WALLS*COUNT_W]),
                .wall_max_i         (wall_max_i[P*WALLS*COUNT_W +: WALLS*COUNT_W]),
                .wall_enable_i      (wall_enable_i[P*WALLS +: WALLS]),
                .edge_hysteresis_i  (edge_hysteresis_i[P]),
                .eta_contact_i      (eta_contact_i[P*COEF_W +: COEF_W]),
                .eta_free_i         (eta_free_i[P*COEF_W +: COEF_W]),
                .shape_words_i      (shape_words_i[P*SECTION_W +: SECTION_W]),
                .wall_shaped_i      (wall_shaped_i[P*WALLS +: WALLS]),
                .host_period_log2_i (host_i[3:0]),
                .host_timeout_i     (host_i[11:4]),
                .host_strobe_i      (1'b0),
                .host_sequence_i    (8'd0),
                .host_u_i           ({DATA_W{1'b0}}),
                .host_strobe_o      (),
                .host_sequence_o    (),
                .host_v_o           (),
                .host_active_o      (),
                .root_i             (root_i[P*COEF_W +: COEF_W]),
                .a_i                (a_i[P*COEF_W +: COEF_W]),
                .u_max_i            (u_max_i[P*DATA_W +: DATA_W]),
                .anchor_words_i     (anchor_words_i[P*`WH_ANCHOR_W +: `WH_ANCHOR_W]),
                .extra_ticks_i      (delay_i[DELAY_LOG2-1:0]),
                .hold_ticks_i       (delay_i[2*DELAY_LOG2-1:DELAY_LOG2]),
                .mode_i             (bridge_i[1:0]),
                .min_pulse_i        (bridge_i[9:2]),
                .clocks_per_volt_i  (clocks_per_volt_i[P*COEF_W +: COEF_W]),
                .bus_share_i        ({COEF_W{1'b0}}),
                .dead_clocks_i      (bridge_i[17:10]),
                .compensate_i       (bridge_i[18]),
                .side_current_i     (side_current_i[P*DATA_W +: DATA_W]),
                .settle_ticks_i     (bridge_i[26:19]),
                .second_order_i     (bridge_i[27]),
                .bus_i              (bus_i),
                .guard_i            (guard_i),
                .clear_i            (clear_i),
                .stop_i             (stop_i),
                .driver_fault_i     (driver_fault_i[P]),
                .host_alive_i       (host_alive_i),
                .anchor_fault_i     (1'b0),
                .faults_o           (b_faults),
                .running_o          (b_running),
                .adc_ready_o        (b_ready),
                .tick_o             (b_tick),
                .core_valid_o       (b_valid),
                .voltage_o          (b_voltage),
                .correction_o       (b_correction),
                .offset_o           (b_offset),
                .flux_o             (b_flux),
                .lag_o              (b_lag),
                .anchor_fault_o     (b_lost),
                .contact_energy_o   (b_energy),
                .contact_energy_peak_o (b_peak),
                .u_o                (b_u),
                .v_o                (b_v),
                .current_o          (b_current),
                .position_o         (b_position),
                .contact_o          (b_contact),
                .saturated_o        (),
                .clipped_o          (b_clipped),
                .adc_range_o        (),
                .adc_stuck_o        (),
                .zero_fault_o       (),
                .zero_busy_o        (),
                .overcurrent_o      (),
                .encoder_fault_o    (),
                .restart_i          (restart_i),
                .words_hold_o       (),
                .scale_hold_o       (),
                .anchor_hold_o      (),
                .overrun_o          ()
            );

            wire unused_brushed = &{1'b0, b_din, b_faults, b_tick, b_ready, b_running, b_cs_n, b_sclk};

            reg [COUNT_W-1:0] b_position_q;
            reg               b_contact_q;
            reg [DATA_W-1:0]  b_voltage_q;

            always @(posedge clk) begin
                if (rst) begin
                    b_contact_q  <= 1'b0;
                end else if (b_valid) begin
                    b_position_q <= b_position;
                    b_contact_q  <= b_contact;
                end
                if (controller.drive_rst) begin
                    b_voltage_q <= {DATA_W{1'b0}};
                end else if (b_valid) begin
                    b_voltage_q <= b_voltage;
                end
            end

            wire [32*16-1:0] live = live_q[32*16*P +: 32*16];
            wire unused_live = &{1'b0, live};
            wire judged = !energy_unknown_o && !controller.each[0].port.energy.full_q;

            assign energy_o[P]                        = judged && (|b_energy);
            assign contact_o[P]                       = b_contact_q;
            assign clipped_o[P]                       = b_clipped;
            assign anchor_fault_o[P]                  = b_lost;
            assign correction_o[P*DATA_W +: DATA_W]   = b_correction;
            assign voltage_o[P*DATA_W +: DATA_W]      = b_voltage;
            assign offset_o[P*DATA_W +: DATA_W]       = b_offset;

            assign differs_o[12*P +: 12] = {
                judged && live[32*`WH_LIVE_ENERGY_PEAK +: `WH_ENERGY_W] != b_peak,
                judged && live[32*`WH_LIVE_ENERGY +: `WH_ENERGY_W] != b_energy,
                live[32*`WH_LIVE_LAG +: DATA_W] != b_lag,
                live[32*`WH_LIVE_FLUX +: DATA_W] != b_flux,
                live[32*`WH_LIVE_OFFSET +: DATA_W] != b_offset,
                live[32*`WH_LIVE_CORRECTION +: DATA_W] != b_correction,
                live[32*`WH_LIVE_VOLTAGE +: DATA_W] != b_voltage_q,
                ports.anchor_faults[P] != b_lost
                || (stepped_q && {live[32*`WH_LIVE_FLAGS+`WH_FLAG_CLIPPED], live[32*`WH_LIVE_FLAGS]}
                                 != {b_clipped, b_contact_q}),
                stepped_q && live[32*`WH_LIVE_POSITION +: 32] != b_position_q,
                live[32*`WH_LIVE_CURRENT +: DATA_W] != b_current,
                live[32*`WH_LIVE_V +: DATA_W] != b_v,
                live[32*`WH_LIVE_U +: DATA_W] != b_u
            };

            assign brushed_gates_differ = {ah, al, bh, bl}
                                          != {ports_ah[P], ports_al[P], ports_bh[P], ports_bl[P]};
        end else begin : brushless_alone
            assign brushed_gates_differ = 1'b0;
        end
        for (m = 0; m < N; m = m + 1) begin : others
            if (m != A && m != A + 1 && (BRUSHED == 0 || m != P)) begin : another
                assign energy_o[m]                       = 1'b0;
                assign contact_o[m]                      = 1'b0;
                assign clipped_o[m]                      = 1'b0;
                assign anchor_fault_o[m]                 = 1'b0;
                assign correction_o[m*DATA_W +: DATA_W]  = {DATA_W{1'b0}};
                assign voltage_o[m*DATA_W +: DATA_W]     = {DATA_W{1'b0}};
                assign offset_o[m*DATA_W +: DATA_W]      = {DATA_W{1'b0}};
                assign differs_o[12*m +: 12]             = 12'd0;
            end
        end
    endgenerate

    // ---- Pins.
    reg  [3:0] on_q;  // clocks that all had their bridges on
    wire [5:0] legs        = {high, low};
    wire [5:0] ports_legs  = {ports_ah[A+1], ports_bh[A], ports_ah[A], ports_al[A+1], ports_bl[A], ports_al[A]};
    wire       legs_differ = legs != ports_legs;
    wire       core_start  = brushless.core_start;

    always @(posedge clk) begin
        if (rst) begin
            frames_differ_o <= 1'b0;
            gates_differ_o  <= 1'b0;
            on_q            <= 4'd0;
        end else begin
            if ({ports_cs_n, ports_sclk, ports_tick, ports_ready} != {cs_n, sclk, tick_o, adc_ready_o}) begin
                frames_differ_o <= 1'b1;
            end
            on_q <= (running_o != 2'b11) ? 4'd0 : (on_q == 4'd15) ? on_q : on_q + 4'd1;
            if (on_q == 4'd15 && (legs_differ || brushed_gates_differ)) begin
                gates_differ_o <= 1'b1;
            end
        end
    end

endmodule

`default_nettype wire
