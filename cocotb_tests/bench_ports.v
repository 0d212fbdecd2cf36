// SPDX-License-Identifier: Apache-2.0
//
// bench_ports: wh_ports beside a wh_controller of as many motors, with the same pins and settings.
//
// The ADC parts answer the controller's frame, of 2 leading zeros and 12 bits that the part gives as SCLK falls;
// wh_ports gets the same bits, and frames_differ_o says that it has asked for them at another time. gates_differ_o
// says that gates were not the same in some clock, while both had had their bridges on for some clocks.
// Live values of wh_ports are gathered until they are compared; differs_o has those of each port that aren't the
// controller's: the host's packet and whether it has the port, largest energy of a contact, energy, ω̂, χ, offset, c,
// e, flags, position, current, v, u from the highest on. What was looked at as the core's step started is kept here
// for that of the controller.
// Energies are not compared once the bridges went off in the midst of a step, which some ports have made with the one
// and not with the other: until rst, energy_unknown_o. One that leaves its word isn't either, until the next contact.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module bench_ports #(
    parameter integer N          = 1,
    parameter integer WALLS      = 4,
    parameter integer DELAY_LOG2 = 2,
    parameter integer ZERO_LOG2  = 3,
    parameter integer SHAPER     = 0,
    parameter integer HOST       = 0,
    parameter integer MODES      = 0,
    parameter integer MIN_PULSE  = 0,
    parameter integer SHAPE_BITS = N * ((SHAPER > 0) ? SHAPER : 1) * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W),
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

    input  wire [N*`WH_SUM_W-1:0]       zero_i,           // of the controller
    input  wire [N*`WH_COEF_W-1:0]      gain_i,
    input  wire [N*WALLS*`WH_COUNT_W-1:0] wall_min_i,
    input  wire [N*WALLS*`WH_COUNT_W-1:0] wall_max_i,
    input  wire [N*WALLS-1:0]           wall_enable_i,
    input  wire [N-1:0]                 edge_hysteresis_i,
    input  wire [N*16-1:0]              overspeed_i,
    input  wire [N*`WH_COUNT_W-1:0]     window_low_i,
    input  wire [N*`WH_COUNT_W-1:0]     window_high_i,
    input  wire [N*`WH_COEF_W-1:0]      eta_contact_i,
    input  wire [N*`WH_COEF_W-1:0]      eta_free_i,
    input  wire [SHAPE_BITS-1:0]        shape_words_i,
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
    input  wire [N-1:0]                 host_strobe_i,
    input  wire [7:0]                   host_sequence_i,
    input  wire [`WH_DATA_W-1:0]        host_u_i,

    output wire                         tick_o,
    output wire                         round_o,          // strobe, the first port's slot begins
    output wire                         adc_ready_o,
    output wire [1:0]                   running_o,        // wh_ports, controller
    output wire                         damp_o,           // of wh_ports
    output wire [`WH_FAULTS-1:0]        faults_o,         // of wh_ports
    output wire [`WH_FAULTS-1:0]        controller_faults_o,
    output wire [13*N-1:0]              differs_o,
    output wire [N-1:0]                 host_active_o,
    output wire [N*8-1:0]               host_sequence_o,  // of the controller
    output reg                          energy_unknown_o,
    output wire [N-1:0]                 energy_o,         // of a contact, but 0
    output reg                          frames_differ_o,  // until rst
    output reg                          gates_differ_o,
    output reg                          met_o,            // two stations asked for a product at once
    output wire [N-1:0]                 contact_o,
    output wire [N-1:0]                 clipped_o,
    output wire [N-1:0]                 anchor_fault_o,
    output wire [N*`WH_DATA_W-1:0]      correction_o,
    output wire [N*`WH_DATA_W-1:0]      voltage_o,
    output wire [N*`WH_DATA_W-1:0]      offset_o
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

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
                                      ports_found, ports_angles};

    wire       surface_busy, surface_refused;
    wire [6:0] surface_row;
    wire [1:0] surfaces_acting;
    wire       unused_surfaces = &{1'b0, surface_busy, surface_refused, surface_row, surfaces_acting};

    wh_ports #(
        .N               (N),
        .WALLS           (WALLS),
        .DELAY_LOG2      (DELAY_LOG2),
        .ZERO_LOG2       (ZERO_LOG2),
        .SHAPER          (SHAPER),
        .HOST            (HOST),
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
        .driver_fault_i  (driver_fault_i),
        .bus_i           (bus_i),
        .carrier_i       (carrier_i),
        .frame_i         (frame_i),
        .sense_i         (sense_i),
        .filter_clocks_i (filter_clocks_i),
        .delay_i         (delay_i),
        .bridge_i        (bridge_i),
        .guard_i         (guard_i),
        .surface_write_i   (1'b0),
        .surface_address_i (10'd0),
        .surface_commit_i  (1'b0),
        .budget_i          (62'd0),
        .surface_busy_o    (surface_busy),
        .surface_refused_o (surface_refused),
        .surface_refused_row_o (surface_row),
        .acting_o          (surfaces_acting),
        .force_i         (force_i),
        .write_i         (write_i),
        .write_bank_i    (write_bank_i),
        .address_i       (address_i),
        .data_i          (data_i),
        .clear_i         (clear_i),
        .host_alive_i    (host_alive_i),
        .zero_start_i    (zero_start_i),
        .restart_i       (restart_i),
        .magnet_start_i  (1'b0),
        .magnets_i       ({65*N{1'b0}}),
        .host_i          (host_i),
        .host_strobe_i   (host_strobe_i),
        .host_sequence_i (host_sequence_i),
        .host_u_i        (host_u_i),
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

    assign damp_o  = ports.damp;

    // The controller is made to damp from a step to the next as well, by the same rounds: by itself it does so in the
    // midst of a step, in which some ports have a voltage already and others don't.
    reg damp_q;

    always @(posedge clk) begin
        if (rst) begin
            damp_q <= 1'b0;
        end else if (round_o) begin
            damp_q <= (|controller_faults_o) && !controller.guarded.guard.off_o;
        end
    end

    always @(damp_q) begin
        force controller.damp = damp_q;
    end

    assign round_o = ports.slot_valid && ports.slot_port == {PORT_W{1'b0}};

    wire [5:0] requests = {ports.sense_request, ports.core_request, ports.anchor_request, ports.drive_request,
                           ports.guard_request, ports.energy_request};

    always @(posedge clk) begin
        if (rst) begin
            met_o <= 1'b0;
        end else if ((requests & (requests - 6'd1)) != 6'd0) begin
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
            if (rst || ports.calm_rst) begin
                live_q[32*(16*p + `WH_LIVE_CORRECTION) +: 32] <= 32'd0;
                live_q[32*(16*p + `WH_LIVE_OFFSET) +: 32]     <= 32'd0;
                live_q[32*(16*p + `WH_LIVE_FLUX) +: 32]       <= 32'd0;
                live_q[32*(16*p + `WH_LIVE_LAG) +: 32]        <= 32'd0;
            end
        end
    end

    // ---- The controller, with the same settings.
    wire [N-1:0]              ah, al, bh, bl;
    wire                      din, core_valid, overrun, scale_hold;
    wire [N*DATA_W-1:0]       flux, lag, u, v, current;
    wire [N*`WH_COUNT_W-1:0]  position;
    wire [N-1:0]              contact, saturated, clipped, adc_range, adc_stuck, zero_fault, zero_busy, overcurrent,
                              encoder_fault, host_strobe, anchor_hold;
    wire [N*DATA_W-1:0]       host_v;
    wire [N*`WH_ENERGY_W-1:0] energy, energy_peak;
    wire [3:0]                words_hold;
    wire                      unused = &{1'b0, din, ports_din, overrun, scale_hold, saturated, adc_range, adc_stuck,
                                         zero_fault, zero_busy, overcurrent, encoder_fault, host_strobe,
                                         anchor_hold, words_hold};

    wh_controller #(
        .N                  (N),
        .WALLS              (WALLS),
        .DELAY_LOG2         (DELAY_LOG2),
        .SENSE              (1),
        .SHAPER             (SHAPER),
        .HOST               (HOST),
        .MODES              (MODES),
        .MIN_PULSE          (MIN_PULSE),
        .ZERO_LOG2          (ZERO_LOG2),
        .ANCHOR             (1),
        .GUARD              (1)
    ) controller (
        .clk                (clk),
        .rst                (rst),
        .enable_i           (enable_i),
        .adc_cs_n_o         (cs_n),
        .adc_sclk_o         (sclk),
        .adc_din_o          (din),
        .adc_sdata_i        (sdata),
        .enc_a_i            (enc_a_i),
        .enc_b_i            (enc_b_i),
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
        .zero_i             (zero_i),
        .range_i            (sense_i[31:16]),
        .stuck_words_i      (sense_i[47:32]),
        .zero_start_i       (zero_start_i),
        .zero_limit_i       (sense_i[70:48]),
        .gain_i             (gain_i),
        .filter_clocks_i    (filter_clocks_i),
        .wall_min_i         (wall_min_i),
        .wall_max_i         (wall_max_i),
        .wall_enable_i      (wall_enable_i),
        .edge_hysteresis_i  (edge_hysteresis_i),
        .overspeed_i        (overspeed_i),
        .window_low_i       (window_low_i),
        .window_high_i      (window_high_i),
        .eta_contact_i      (eta_contact_i),
        .eta_free_i         (eta_free_i),
        .shape_words_i      (shape_words_i),
        .wall_shaped_i      (wall_shaped_i),
        .host_period_log2_i (host_i[3:0]),
        .host_timeout_i     (host_i[11:4]),
        .host_strobe_i      (host_strobe_i),
        .host_sequence_i    ({N{host_sequence_i}}),
        .host_u_i           ({N{host_u_i}}),
        .host_strobe_o      (host_strobe),
        .host_sequence_o    (host_sequence_o),
        .host_v_o           (host_v),
        .host_active_o      (host_active_o),
        .root_i             (root_i),
        .a_i                (a_i),
        .u_max_i            (u_max_i),
        .anchor_words_i     (anchor_words_i),
        .extra_ticks_i      (delay_i[DELAY_LOG2-1:0]),
        .hold_ticks_i       (delay_i[2*DELAY_LOG2-1:DELAY_LOG2]),
        .mode_i             (bridge_i[1:0]),
        .min_pulse_i        (bridge_i[9:2]),
        .clocks_per_volt_i  (clocks_per_volt_i),
        .bus_share_i        ({COEF_W{1'b0}}),
        .dead_clocks_i      (bridge_i[17:10]),
        .compensate_i       (bridge_i[18]),
        .side_current_i     (side_current_i),
        .settle_ticks_i     (bridge_i[26:19]),
        .second_order_i     (bridge_i[27]),
        .bus_i              (bus_i),
        .guard_i            (guard_i),
        .clear_i            (clear_i),
        .stop_i             (stop_i),
        .driver_fault_i     (driver_fault_i),
        .host_alive_i       (host_alive_i),
        .anchor_fault_i     ({N{1'b0}}),
        .faults_o           (controller_faults_o),
        .running_o          (running_o[1]),
        .adc_ready_o        (adc_ready_o),
        .tick_o             (tick_o),
        .core_valid_o       (core_valid),
        .voltage_o          (voltage_o),
        .correction_o       (correction_o),
        .offset_o           (offset_o),
        .flux_o             (flux),
        .lag_o              (lag),
        .anchor_fault_o     (anchor_fault_o),
        .contact_energy_o   (energy),
        .contact_energy_peak_o (energy_peak),
        .u_o                (u),
        .v_o                (v),
        .current_o          (current),
        .position_o         (position),
        .contact_o          (contact),
        .saturated_o        (saturated),
        .clipped_o          (clipped),
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

    // What its last step saw, and whether that was since it was on.
    reg [N*`WH_COUNT_W-1:0] position_q;
    reg [N-1:0]             contact_q;
    reg                     stepped_q;
    reg [N*(DATA_W+9)-1:0]  host_q;     // whether a host has it, its packet
    reg [N-1:0]             packet_q;   // packets since, of the two
    reg [N-1:0]             ports_packet_q;

    always @(posedge clk) begin
        if (!running_o[1] || !running_o[0] || rst) begin
            stepped_q <= 1'b0;
        end else if (core_valid) begin
            stepped_q <= 1'b1;
        end
        // A packet comes some clocks after the step that ends a host's period.
        if (rst || round_o) begin
            packet_q       <= {N{1'b0}};
            ports_packet_q <= {N{1'b0}};
        end else begin
            packet_q       <= packet_q | host_strobe;
            ports_packet_q <= ports_packet_q | ports_packet;
        end
        if (rst) begin
            contact_q  <= {N{1'b0}};
        end else if (core_valid) begin
            position_q <= position;
            host_q     <= {host_active_o, host_sequence_o, host_v};
            contact_q  <= contact;
        end
    end

    // The voltage that went to the drive: what the anchor adds is 0 once it is damped.
    reg [N*DATA_W-1:0] voltage_q;

    always @(posedge clk) begin
        if (controller.drive_rst) begin
            voltage_q <= {N*DATA_W{1'b0}};
        end else if (core_valid) begin
            voltage_q <= voltage_o;
        end
    end

    assign contact_o = contact_q;
    assign clipped_o = clipped;

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

    generate
        for (n = 0; n < N; n = n + 1) begin : compare
            wire [32*16-1:0] live = live_q[32*16*n +: 32*16];
            wire unused_live = &{1'b0, live};
            wire judged = !energy_unknown_o && !controller.each[n].port.energy.full_q;

            assign energy_o[n] = judged && (|energy[n*`WH_ENERGY_W +: `WH_ENERGY_W]);

            // Before the first packet there is no mean.
            wire [8:0]        host = {host_q[N*(DATA_W+8) + n], host_q[N*DATA_W + 8*n +: 8]};
            wire [DATA_W-1:0] mean = host_q[n*DATA_W +: DATA_W];

            assign differs_o[13*n +: 13] = {
                HOST == 1 && stepped_q
                && (host != {live[32*`WH_LIVE_FLAGS+7], live[32*`WH_LIVE_HOST_SEQUENCE +: 8]}
                    || (host[7:0] != 8'd0 && mean != live[32*`WH_LIVE_HOST_V +: DATA_W])
                    || packet_q[n] != ports_packet_q[n]),
                judged && live[32*`WH_LIVE_ENERGY_PEAK +: `WH_ENERGY_W]
                          != energy_peak[n*`WH_ENERGY_W +: `WH_ENERGY_W],
                judged && live[32*`WH_LIVE_ENERGY +: `WH_ENERGY_W] != energy[n*`WH_ENERGY_W +: `WH_ENERGY_W],
                live[32*`WH_LIVE_LAG +: DATA_W] != lag[n*DATA_W +: DATA_W],
                live[32*`WH_LIVE_FLUX +: DATA_W] != flux[n*DATA_W +: DATA_W],
                live[32*`WH_LIVE_OFFSET +: DATA_W] != offset_o[n*DATA_W +: DATA_W],
                live[32*`WH_LIVE_CORRECTION +: DATA_W] != correction_o[n*DATA_W +: DATA_W],
                live[32*`WH_LIVE_VOLTAGE +: DATA_W] != voltage_q[n*DATA_W +: DATA_W],
                ports.anchor_faults[n] != anchor_fault_o[n]
                || (stepped_q && {live[32*`WH_LIVE_FLAGS+`WH_FLAG_CLIPPED], live[32*`WH_LIVE_FLAGS]} != {clipped[n], contact_q[n]}),
                stepped_q && live[32*`WH_LIVE_POSITION +: 32] != position_q[n*`WH_COUNT_W +: `WH_COUNT_W],
                live[32*`WH_LIVE_CURRENT +: DATA_W] != current[n*DATA_W +: DATA_W],
                live[32*`WH_LIVE_V +: DATA_W] != v[n*DATA_W +: DATA_W],
                live[32*`WH_LIVE_U +: DATA_W] != u[n*DATA_W +: DATA_W]
            };
        end
    endgenerate

    // ---- Pins.
    reg [3:0] on_q;  // clocks that both had their bridges on

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
            if (on_q == 4'd15 && {ah, al, bh, bl} != {ports_ah, ports_al, ports_bh, ports_bl}) begin
                gates_differ_o <= 1'b1;
            end
        end
    end

endmodule

`default_nettype wire
