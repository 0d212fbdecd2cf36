// SPDX-License-Identifier: Apache-2.0
//
// use_in_a_design: a template of a design with wh_device in it, with registers of a scene behind Wishbone.
//
// wh_scene.vh has the parameters and the registers; `wavehaptics registers` writes it from scene.toml.
// start_up is the only master here. In a design with a processor its place is taken by the interconnect.
// docs/use_in_your_design.md explains the ports and the order in which things start.
//
// Latency: that of wh_device.
// Reset: rst is synchronous, high for a clock or longer; the gates are off until start_up is done, enable_i is high
// and press_i has armed the device.

`default_nettype none
`include "wh_formats.vh"
`include "wh_scene.vh"

module use_in_a_design #(
    parameter integer N = `WH_SCENE_N  // ports
) (
    input  wire             clk,             // WH_SCENE_CLOCK_HZ
    input  wire             rst,

    input  wire             enable_i,        // synchronous to clk; low: the gates are off
    input  wire             press_i,         // strobe: measure the current's zero, then switch on
    input  wire             clear_i,         // a rise: forget faults that are over

    output wire             adc_cs_n_o,
    output wire             adc_sclk_o,
    input  wire [N-1:0]     adc_sdata_i,
    input  wire [N-1:0]     enc_a_i,         // asynchronous
    input  wire [N-1:0]     enc_b_i,         // asynchronous
    output wire [N-1:0]     gate_ah_o,
    output wire [N-1:0]     gate_al_o,
    output wire [N-1:0]     gate_bh_o,
    output wire [N-1:0]     gate_bl_o,

    output wire             started_o,       // the scene's settings are in force
    output wire             failed_o,        // the device refused one
    output wire             running_o,       // the gates are on
    output wire             contact_o,       // a motor is in a wall
    output wire             fault_o
);

    wire        cyc;
    wire        stb;
    wire        we;
    wire [11:0] adr;
    wire [31:0] written;
    wire [31:0] read;
    wire        ack;
    wire        err;

    // In a design with a processor: the interconnect's port for this slave.
    start_up master (
        .clk           (clk),
        .rst           (rst),
        .cyc_o         (cyc),
        .stb_o         (stb),
        .we_o          (we),
        .adr_o         (adr),
        .dat_o         (written),
        .dat_i         (read),
        .ack_i         (ack),
        .err_i         (err),
        .done_o        (started_o),
        .failed_o      (failed_o)
    );

    wire        bus_valid;
    wire        bus_write;
    wire        bus_check;
    wire [11:0] bus_address;
    wire [31:0] bus_data;
    wire        bus_ready;
    wire [31:0] bus_read;
    wire [1:0]  bus_error;

    wh_wishbone wishbone (
        .clk           (clk),
        .rst           (rst),
        .cyc_i         (cyc),
        .stb_i         (stb),
        .we_i          (we),
        .adr_i         (adr),
        .dat_i         (written),
        .sel_i         (4'b1111),
        .dat_o         (read),
        .ack_o         (ack),
        .err_o         (err),
        .bus_valid_o   (bus_valid),
        .bus_write_o   (bus_write),
        .bus_check_o   (bus_check),
        .bus_address_o (bus_address),
        .bus_data_o    (bus_data),
        .bus_ready_i   (bus_ready),
        .bus_data_i    (bus_read),
        .bus_error_i   (bus_error)
    );

    // What this design doesn't use.
    wire             bus_signed;
    wire             adc_din;      // of converters with commands
    wire             tick;
    wire             fault_lasts;
    wire             ready;
    wire             clear_seen;
    wire             zero_busy;
    wire [N-1:0]     zero_fault;
    wire             stream_credit;
    wire             stream_valid;
    wire             stream_first;
    wire [7:0]       stream_byte;
    wire             stream_packet;
    wire             unused = &{1'b0, bus_signed, adc_din, tick, fault_lasts, ready, clear_seen, zero_busy, zero_fault,
                                stream_credit, stream_valid, stream_first, stream_byte, stream_packet};

    wh_device #(
        .N               (N),
        .AXES            (`WH_SCENE_AXES),
        .WALLS           (`WH_SCENE_WALLS),
        .DELAY_LOG2      (`WH_SCENE_DELAY_LOG2),
        .ADC             (`WH_SCENE_ADC),
        .SHAPER          (`WH_SCENE_SHAPER),
        .HOST            (`WH_SCENE_HOST),
        .MODES           (`WH_SCENE_MODES),
        .MIN_PULSE       (`WH_SCENE_MIN_PULSE),
        .ARM             (1)
    ) device (
        .clk             (clk),
        .rst             (rst),
        .enable_i        (enable_i && started_o),
        .bus_valid_i     (bus_valid),
        .bus_write_i     (bus_write),
        .bus_check_i     (bus_check),
        .bus_address_i   (bus_address),
        .bus_data_i      (bus_data),
        .bus_ready_o     (bus_ready),
        .bus_data_o      (bus_read),
        .bus_error_o     (bus_error),
        .bus_signed_o    (bus_signed),
        .adc_cs_n_o      (adc_cs_n_o),
        .adc_sclk_o      (adc_sclk_o),
        .adc_din_o       (adc_din),
        .adc_sdata_i     (adc_sdata_i),
        .enc_a_i         (enc_a_i),
        .enc_b_i         (enc_b_i),
        .gate_ah_o       (gate_ah_o),
        .gate_al_o       (gate_al_o),
        .gate_bh_o       (gate_bh_o),
        .gate_bl_o       (gate_bl_o),
        .bus_i           ({`WH_BUS_W{1'b0}}),
        .stop_i          (1'b0),  // a scene's guard_mask leaves it out: stop by enable_i
        .driver_fault_i  ({N{1'b0}}),
        .clear_i         (clear_i),
        .zero_start_i    (1'b0),
        .press_i         (press_i),
        .tick_o          (tick),
        .running_o       (running_o),
        .contact_o       (contact_o),
        .fault_o         (fault_o),
        .fault_lasts_o   (fault_lasts),
        .ready_o         (ready),
        .clear_o         (clear_seen),
        .zero_busy_o     (zero_busy),
        .zero_fault_o    (zero_fault),
        .stream_credit_o (stream_credit),
        .stream_valid_o  (stream_valid),
        .stream_first_o  (stream_first),
        .stream_byte_o   (stream_byte),
        .stream_packet_o (stream_packet),
        .stream_room_i   (1'b0)
    );

endmodule

`default_nettype wire
