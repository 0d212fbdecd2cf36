// SPDX-License-Identifier: Apache-2.0
//
// bench_closed_loop: wh_controller with a clock, settings to write to, and the ADC's shift register.
//
// The test loads shift when CS_n falls; the bits go out as an AD7276-like part sends them: a first
// lead bit with the fall of CS_n, the next bit after each fall of SCLK.

`timescale 1ns / 1ps
`default_nettype none
`include "wh_formats.vh"

module bench_closed_loop #(
    parameter integer CLOCK_PS = 20832,  // even, so that a half is whole
    parameter integer WALLS    = 4
) ();

    reg clk = 1'b0;
    always #(CLOCK_PS / 2000.0) clk = !clk;

    // Clocks since reset was released; the gates of clock n hold from edge n to edge n + 1.
    reg         rst = 1'b1;
    reg         enable = 1'b0;
    reg  [63:0] now = 64'd0;
    always @(posedge clk) now <= rst ? 64'd0 : now + 64'd1;

    reg  [`WH_TICK_W-1:0]        half_clocks = 0;
    reg  [`WH_TICK_W-1:0]        tick_halves = 0;
    reg  [`WH_TICK_W-1:0]        sample_clocks = 0;
    reg  [8:0]                   samples = 0;
    reg  [7:0]                   sample_lead = 0;
    reg                          sample_late = 1'b0;
    reg  [7:0]                   sclk_half_clocks = 0;
    reg  [5:0]                   frame_bits = 0;
    reg  [5:0]                   lead_bits = 0;
    reg  [4:0]                   data_bits = 0;
    reg  [7:0]                   quiet_clocks = 0;
    reg  [7:0]                   setup_clocks = 0;
    reg  [7:0]                   hold_clocks = 0;
    reg  [5:0]                   calibrate_bits = 0;
    reg                          sclk_idle = 0;
    reg                          read_trailing = 0;
    reg  [15:0]                  trip = 0;
    reg  [`WH_SUM_W-1:0]         zero = 0;
    reg  [`WH_COEF_W-1:0]        gain = 0;
    reg  [3:0]                   filter_clocks = 0;
    reg  [WALLS*`WH_COUNT_W-1:0] wall_min = 0;
    reg  [WALLS*`WH_COUNT_W-1:0] wall_max = 0;
    reg  [WALLS-1:0]             wall_enable = 0;
    reg  [`WH_COEF_W-1:0]        eta_contact = 0;
    reg  [`WH_COEF_W-1:0]        eta_free = 0;
    reg  [`WH_COEF_W-1:0]        root = 0;
    reg  [`WH_COEF_W-1:0]        a = 0;
    reg  [`WH_DATA_W-1:0]        u_max = 0;
    reg  [1:0]                   extra_ticks = 0;
    reg  [1:0]                   hold_ticks = 0;
    reg  [`WH_MODE_W-1:0]        mode = 0;
    reg  [7:0]                   min_pulse = 0;
    reg  [`WH_COEF_W-1:0]        clocks_per_volt = 0;
    reg  [`WH_COEF_W-1:0]        bus_share = 0;
    reg  [7:0]                   dead_clocks = 0;
    reg                          compensate = 1'b0;
    reg  [`WH_DATA_W-1:0]        side_current = 0;
    reg  [7:0]                   settle_ticks = 0;
    reg                          second_order = 1'b0;

    reg         enc_a = 1'b0;
    reg         enc_b = 1'b0;
    reg  [31:0] shift = 32'd0;  // highest bit on the wire

    wire        cs_n;
    wire        sclk;
    wire [3:0]  gates;          // BL BH AL AH

    always @(negedge sclk) shift <= shift << 1;

    wire                   tick;
    wire                   core_valid;
    wire [`WH_DATA_W-1:0]  voltage;
    wire [`WH_DATA_W-1:0]  u;
    wire [`WH_DATA_W-1:0]  v;
    wire [`WH_DATA_W-1:0]  current;
    wire [`WH_COUNT_W-1:0] position;
    wire                   contact;
    wire                   saturated;
    wire                   encoder_fault;
    wire                   overrun;

    wh_controller controller (
        .clk(clk), .rst(rst), .enable_i(enable),
        .adc_cs_n_o(cs_n), .adc_sclk_o(sclk), .adc_din_o(), .adc_sdata_i(shift[31]),
        .enc_a_i(enc_a), .enc_b_i(enc_b),
        .edge_hysteresis_i(1'b0), .wall_shaped_i({WALLS{1'b0}}),
        .shape_words_i({9*`WH_SHAPE_W+3*`WH_SHAPE_LOSS_W{1'b0}}),
        .host_period_log2_i(4'd0), .host_timeout_i(8'd0), .host_strobe_i(1'b0),
        .host_sequence_i(8'd0), .host_u_i({`WH_DATA_W{1'b0}}), .host_strobe_o(),
        .host_sequence_o(), .host_v_o(), .host_active_o(),
        .gate_ah_o(gates[0]), .gate_al_o(gates[1]), .gate_bh_o(gates[2]), .gate_bl_o(gates[3]),
        .half_clocks_i(half_clocks), .tick_halves_i(tick_halves),
        .sample_clocks_i(sample_clocks), .samples_i(samples), .sample_lead_i(sample_lead),
        .sample_late_i(sample_late),
        .sclk_half_clocks_i(sclk_half_clocks), .frame_bits_i(frame_bits),
        .lead_bits_i(lead_bits), .data_bits_i(data_bits), .quiet_clocks_i(quiet_clocks),
        .setup_clocks_i(setup_clocks), .hold_clocks_i(hold_clocks),
        .calibrate_bits_i(calibrate_bits), .sclk_idle_i(sclk_idle),
        .read_trailing_i(read_trailing), .trip_i(trip),
        .range_i(16'hffff), .stuck_words_i(16'd0), .zero_start_i(1'b0),
        .zero_limit_i({`WH_SUM_W-1{1'b0}}),
        .zero_i(zero), .gain_i(gain), .filter_clocks_i(filter_clocks),
        .wall_min_i(wall_min), .wall_max_i(wall_max), .wall_enable_i(wall_enable),
        .eta_contact_i(eta_contact), .eta_free_i(eta_free),
        .root_i(root), .a_i(a), .u_max_i(u_max), .anchor_words_i({`WH_ANCHOR_W{1'b0}}),
        .extra_ticks_i(extra_ticks), .hold_ticks_i(hold_ticks),
        .mode_i(mode), .min_pulse_i(min_pulse), .clocks_per_volt_i(clocks_per_volt),
        .bus_share_i(bus_share), .dead_clocks_i(dead_clocks), .compensate_i(compensate), .side_current_i(side_current),
        .settle_ticks_i(settle_ticks), .second_order_i(second_order),
        .guard_i(0), .clear_i(1'b0), .stop_i(1'b0), .driver_fault_i(1'b0), .host_alive_i(1'b0),
        .bus_i(16'd0), .anchor_fault_i(1'b0), .faults_o(), .running_o(),
        .adc_ready_o(), .tick_o(tick), .core_valid_o(core_valid), .voltage_o(voltage), .u_o(u), .v_o(v),
        .current_o(current), .position_o(position), .contact_o(contact),
        .correction_o(), .offset_o(), .flux_o(), .lag_o(), .anchor_fault_o(),
        .saturated_o(saturated), .overcurrent_o(), .adc_range_o(),
        .adc_stuck_o(), .zero_fault_o(), .zero_busy_o(), .encoder_fault_o(encoder_fault), .overrun_o(overrun)
    );

endmodule

`default_nettype wire
