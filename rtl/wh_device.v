// SPDX-License-Identifier: Apache-2.0
//
// wh_device: the controller with its registers: pins, the bus, and little else. It is wh_ports_device, with N motors
// with brushes that take turns, or, LEGS = 3, with one brushless motor whose two axes do.
//
// Latency and reset: those of wh_ports_device.

`default_nettype none
`include "wh_formats.vh"

module wh_device #(
    parameter integer N            = 1,  // these are wh_ports'
    parameter integer WALLS        = 4,
    parameter integer DELAY_LOG2   = 2,
    parameter integer ADC          = 0,
    parameter integer OSR          = 32,
    parameter integer ZERO_LOG2    = 10,
    parameter integer SHAPER       = 0,
    parameter integer MODES        = 0,
    parameter integer MIN_PULSE    = 0,
    parameter integer HOST         = 0,
    parameter integer SURFACES     = 0,  // across all motors (wh_surfaces), 0...8
    parameter integer ARM          = 0,  // 1: the bridges are on by command, while it is renewed, or by press_i
    parameter integer ARM_CLOCKS   = 4800000, // clocks that a command of either lasts, 2...2^30
    parameter integer CAPTURE      = 0,  // words that a capture takes, 2^this, 4...15; 0: there is none
    parameter integer STREAM       = 0,  // 1: with a stream
    parameter integer LEGS         = 2,  // half bridges of a motor; 3: a brushless one
    parameter integer PARTS        = (LEGS == 3) ? 2 : N  // derived, leave it: motors, or axes of one
) (
    input  wire                 clk,
    input  wire                 rst,
    input  wire                 enable_i,       // synchronous to clk

    // The bus (wh_registers).
    input  wire                 bus_valid_i,    // held until bus_ready_o, as are the words below
    input  wire                 bus_write_i,
    input  wire                 bus_check_i,
    input  wire [11:0]          bus_address_i,
    input  wire [31:0]          bus_data_i,
    output wire                 bus_ready_o,    // strobe
    output wire [31:0]          bus_data_o,
    output wire [1:0]           bus_error_o,
    output wire                 bus_signed_o,

    // Pins, and what a board wires.
    output wire                 adc_cs_n_o,
    output wire                 adc_sclk_o,
    output wire                 adc_din_o,
    input  wire [PARTS-1:0]     adc_sdata_i,    // of a motor, or of phase a, lowest
    input  wire [N-1:0]         enc_a_i,        // asynchronous
    input  wire [N-1:0]         enc_b_i,        // asynchronous
    output wire [N-1:0]         gate_ah_o,
    output wire [N-1:0]         gate_al_o,
    output wire [PARTS-1:0]     gate_bh_o,      // leg b; with LEGS = 3 those of b, lowest, and c
    output wire [PARTS-1:0]     gate_bl_o,
    input  wire [`WH_BUS_W-1:0] bus_i,          // u16q9 V, the measured bus
    input  wire                 stop_i,         // asynchronous
    input  wire [N-1:0]         driver_fault_i, // asynchronous
    input  wire                 clear_i,        // these two do what their words do, a rise of the first
    input  wire                 zero_start_i,
    input  wire                 press_i,        // strobe: arm, until something is against it; with ARM = 1

    output wire                 tick_o,         // strobe, last clock of a tick
    output wire                 running_o,      // the bridges are on
    output wire                 contact_o,      // any motor is in a wall
    output wire                 fault_o,        // the guard found something, or a tick is too short
    output wire                 fault_lasts_o,  // the same but for a zero, which arming measures anew
    output wire                 ready_o,        // since reset all settings were given
    output wire                 clear_o,        // strobe: the bus wants faults forgotten
    output wire [PARTS-1:0]     zero_busy_o,    // zeros are measured
    output wire [PARTS-1:0]     zero_fault_o,   // no permitted zero was found

    // A stream's packets (wh_stream).
    output wire                 stream_credit_o,
    output wire                 stream_valid_o,
    output wire                 stream_first_o,
    output wire [7:0]           stream_byte_o,
    output wire                 stream_packet_o,
    input  wire                 stream_room_i
);

    wire [PARTS-1:0] enc_a, enc_b, ah, al, bh, bl, drivers;

    generate
        if (LEGS != 2 && (LEGS != 3 || N != 1)) begin : illegal_legs
            wh_illegal_parameter_device_legs_must_be_2_or_with_one_motor_3 stop ();
        end

        // A brushless motor's leg c is leg A of its second port.
        if (LEGS == 3) begin : brushless
            wire unused_legs = &{1'b0, bh[1], bl[1]};

            assign enc_a     = {1'b0, enc_a_i};
            assign enc_b     = {1'b0, enc_b_i};
            assign drivers   = {2{driver_fault_i}};
            assign gate_ah_o = ah[0];
            assign gate_al_o = al[0];
            assign gate_bh_o = {ah[1], bh[0]};
            assign gate_bl_o = {al[1], bl[0]};
        end else begin : brushed
            assign enc_a     = enc_a_i;
            assign enc_b     = enc_b_i;
            assign drivers   = driver_fault_i;
            assign gate_ah_o = ah;
            assign gate_al_o = al;
            assign gate_bh_o = bh;
            assign gate_bl_o = bl;
        end
    endgenerate

    wire zero_busy;  // all are measured at once

    assign zero_busy_o = {PARTS{zero_busy}};

    wh_ports_device #(
        .N          (PARTS),
        .AXES       ((LEGS == 3) ? 1 : 0),
        .WALLS      (WALLS),
        .DELAY_LOG2 (DELAY_LOG2),
        .ADC        (ADC),
        .OSR        (OSR),
        .ZERO_LOG2  (ZERO_LOG2),
        .SHAPER     (SHAPER),
        .MODES      (MODES),
        .MIN_PULSE  (MIN_PULSE),
        .HOST       (HOST),
        .SURFACES   (SURFACES),
        .ARM        (ARM),
        .ARM_CLOCKS (ARM_CLOCKS),
        .CAPTURE    (CAPTURE),
        .STREAM     (STREAM)
    ) device (
        .clk             (clk),
        .rst             (rst),
        .enable_i        (enable_i),
        .bus_valid_i     (bus_valid_i),
        .bus_write_i     (bus_write_i),
        .bus_check_i     (bus_check_i),
        .bus_address_i   (bus_address_i),
        .bus_data_i      (bus_data_i),
        .bus_ready_o     (bus_ready_o),
        .bus_data_o      (bus_data_o),
        .bus_error_o     (bus_error_o),
        .bus_signed_o    (bus_signed_o),
        .adc_cs_n_o      (adc_cs_n_o),
        .adc_sclk_o      (adc_sclk_o),
        .adc_din_o       (adc_din_o),
        .adc_sdata_i     (adc_sdata_i),
        .enc_a_i         (enc_a),
        .enc_b_i         (enc_b),
        .gate_ah_o       (ah),
        .gate_al_o       (al),
        .gate_bh_o       (bh),
        .gate_bl_o       (bl),
        .bus_i           (bus_i),
        .stop_i          (stop_i),
        .driver_fault_i  (drivers),
        .clear_i         (clear_i),
        .zero_start_i    (zero_start_i),
        .press_i         (press_i),
        .tick_o          (tick_o),
        .running_o       (running_o),
        .contact_o       (contact_o),
        .fault_o         (fault_o),
        .fault_lasts_o   (fault_lasts_o),
        .ready_o         (ready_o),
        .clear_o         (clear_o),
        .zero_busy_o     (zero_busy),
        .zero_fault_o    (zero_fault_o),
        .stream_credit_o (stream_credit_o),
        .stream_valid_o  (stream_valid_o),
        .stream_first_o  (stream_first_o),
        .stream_byte_o   (stream_byte_o),
        .stream_packet_o (stream_packet_o),
        .stream_room_i   (stream_room_i)
    );

endmodule

`default_nettype wire
