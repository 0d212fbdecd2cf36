// SPDX-License-Identifier: Apache-2.0
//
// wh_linked_device: wh_device with a serial line in place of its bus.
//
//   uart_rx_i -> wh_link -> wh_device -> pins
//
// With SPI = 1 a master on SPI can have the line's place (wh_link).
//
// What stands on the line, and what of it does nothing, is said by wh_modbus. enable_i is a pin that
// allows: with it, and ARM = 1, the word `arm` lets the bridges on for 200 ms, and press_i until something is
// against it (wh_arm); with ARM = 0 the pin alone does. Word 2 of the identification, its options, is made here:
//
//   3:0 MOTORS   8:4 WALLS   10:9 SHAPER   14:11 DELAY_LOG2   16:15 ADC   18 ANCHOR   19 GUARD
//   20 SENSE   21 HOST   22 BUS   23 MODES   24 MIN_PULSE   25 DEAD_TIME
//   27 ARM   31:28 CAPTURE
//
// SHAPER is 3 there with AXES; all motors are then brushless ones. ANCHOR, GUARD, SENSE and DEAD_TIME are always 1;
// BUS and the bits 17 and 26 are 0. Whether there is a STREAM, the word stream_state says, which is 0 without. How many
// SURFACES there are, the register `surfaces` says.
//
// Latency and reset: those of wh_modbus and of wh_device.

`default_nettype none
`include "wh_formats.vh"

module wh_linked_device #(
    parameter integer N            = 1,  // these are wh_device's
    parameter integer WALLS        = 4,
    parameter integer DELAY_LOG2   = 2,
    parameter integer ADC          = 0,
    parameter integer OSR          = 32,
    parameter integer ZERO_LOG2    = 10,
    parameter integer SHAPER       = 0,
    parameter integer MODES        = 0,
    parameter integer MIN_PULSE    = 0,
    parameter integer HOST         = 0,
    parameter integer SURFACES     = 0,
    parameter integer AXES         = 0,
    parameter integer ARM          = 1,
    parameter integer CAPTURE      = 0,
    parameter integer STREAM       = 0,
    parameter integer SPI          = 0,  // of the link
    parameter integer CLOCK_HZ     = 24000000,
    parameter integer UNIT         = 1,  // 1...247, of the link
    parameter [31:0]  BUILD        = 32'd0,
    parameter integer SILENCE      = CLOCK_HZ / 500,  // these two are wh_modbus's
    parameter integer FALLBACK     = 500,
    parameter integer CREDIT       = CLOCK_HZ / 5     // clocks that the words `arm` and `stream` last
) (
    input  wire                 clk,
    input  wire                 rst,
    input  wire                 enable_i,       // synchronous to clk

    // The line.
    input  wire                 uart_rx_i,      // asynchronous
    output wire                 uart_tx_o,
    input  wire                 spi_cs_n_i,     // asynchronous; these do nothing with SPI = 0
    input  wire                 spi_sclk_i,     // asynchronous
    input  wire                 spi_mosi_i,     // asynchronous
    output wire                 spi_miso_o,
    output wire                 spi_drives_o,   // CS is low

    // Pins, and what a board wires.
    output wire                 adc_cs_n_o,
    output wire                 adc_sclk_o,
    output wire                 adc_din_o,
    input  wire [N-1:0]         adc_sdata_i,    // of a brushless motor: of its phases a and b
    input  wire [N-1:0]         enc_a_i,        // asynchronous
    input  wire [N-1:0]         enc_b_i,        // asynchronous
    output wire [N-1:0]         gate_ah_o,
    output wire [N-1:0]         gate_al_o,
    output wire [N-1:0]         gate_bh_o,      // leg b; see AXES of wh_device
    output wire [N-1:0]         gate_bl_o,
    input  wire [`WH_BUS_W-1:0] bus_i,          // u16q9 V, the measured bus
    input  wire                 stop_i,         // asynchronous
    input  wire [N-1:0]         driver_fault_i, // asynchronous
    input  wire                 clear_i,        // these two do what their words do
    input  wire                 zero_start_i,
    input  wire                 press_i,

    output wire                 tick_o,         // strobe, last clock of a tick
    output wire                 running_o,      // the bridges are on
    output wire                 contact_o,      // any motor is in a wall
    output wire                 fault_o,        // the guard found something, or a tick is too short
    output wire                 fault_lasts_o,  // the same but for a zero, which arming measures anew
    output wire                 ready_o,        // since reset all settings were given
    output wire                 clear_o,        // strobe: the line wants faults forgotten
    output wire                 zero_busy_o,    // these are wh_device's
    output wire [N-1:0]         zero_fault_o
);

    localparam integer MOTORS   = N - (AXES & 1) - ((AXES >> 1) & 1) - ((AXES >> 2) & 1) - ((AXES >> 3) & 1)
                                  - ((AXES >> 4) & 1) - ((AXES >> 5) & 1) - ((AXES >> 6) & 1);
    localparam [31:0] MOTORS_32 = MOTORS;
    localparam [31:0] WALLS_32  = WALLS;
    localparam [31:0] SHAPER_32 = (AXES != 0) ? 3 : SHAPER;
    localparam [31:0] DELAY_32  = DELAY_LOG2;
    localparam [31:0] ADC_32    = ADC;
    localparam [31:0] CAPTURE_32 = CAPTURE;
    localparam [31:0] OPTIONS = {
        CAPTURE_32[3:0], ARM != 0, 1'b0, 1'b1, MIN_PULSE != 0, MODES != 0, 1'b0, HOST != 0,
        1'b1, 1'b1, 1'b1, 1'b0, ADC_32[1:0], DELAY_32[3:0],
        SHAPER_32[1:0], WALLS_32[4:0], MOTORS_32[3:0]
    };

    wire        bus_valid;
    wire        bus_write;
    wire        bus_check;
    wire [11:0] bus_address;
    wire [31:0] bus_data;
    wire        bus_ready;
    wire [31:0] bus_read;
    wire [1:0]  bus_error;
    wire        bus_signed;
    wire        stream_credit;
    wire        stream_valid;
    wire        stream_first;
    wire [7:0]  stream_byte;
    wire        stream_packet;
    wire        stream_room;

    // The memory's answer has a clock of its own, in which the request that it ends still stands.
    reg         ready_q;
    reg  [31:0] read_q;
    reg  [1:0]  error_q;
    reg         signed_q;

    always @(posedge clk) begin
        ready_q  <= !rst && bus_ready;
        read_q   <= bus_read;
        error_q  <= bus_error;
        signed_q <= bus_signed;
    end

    wh_link #(
        .UNIT          (UNIT),
        .CLOCK_HZ      (CLOCK_HZ),
        .SILENCE       (SILENCE),
        .FALLBACK      (FALLBACK),
        .BUILD         (BUILD),
        .OPTIONS       (OPTIONS),
        .MOTORS        (MOTORS),
        .STREAM        (STREAM),
        .SPI           (SPI)
    ) link (
        .clk           (clk),
        .rst           (rst),
        .uart_rx_i     (uart_rx_i),
        .uart_tx_o     (uart_tx_o),
        .spi_cs_n_i    (spi_cs_n_i),
        .spi_sclk_i    (spi_sclk_i),
        .spi_mosi_i    (spi_mosi_i),
        .spi_miso_o    (spi_miso_o),
        .spi_drives_o  (spi_drives_o),
        .bus_valid_o   (bus_valid),
        .bus_write_o   (bus_write),
        .bus_check_o   (bus_check),
        .bus_address_o (bus_address),
        .bus_data_o    (bus_data),
        .bus_ready_i   (ready_q),
        .bus_data_i    (read_q),
        .bus_error_i   (error_q),
        .bus_signed_i  (signed_q),
        .stream_credit_i (stream_credit),
        .stream_valid_i  (stream_valid),
        .stream_first_i  (stream_first),
        .stream_byte_i   (stream_byte),
        .stream_packet_i (stream_packet),
        .stream_room_o   (stream_room)
    );

    wh_device #(
        .N              (N),
        .WALLS          (WALLS),
        .DELAY_LOG2     (DELAY_LOG2),
        .ADC            (ADC),
        .OSR            (OSR),
        .ZERO_LOG2      (ZERO_LOG2),
        .SHAPER         (SHAPER),
        .MODES          (MODES),
        .MIN_PULSE      (MIN_PULSE),
        .HOST           (HOST),
        .SURFACES       (SURFACES),
        .AXES           (AXES),
        .ARM            (ARM),
        .ARM_CLOCKS     (CREDIT),
        .CAPTURE        (CAPTURE),
        .STREAM         (STREAM)
    ) device (
        .clk             (clk),
        .rst             (rst),
        .enable_i        (enable_i),
        .bus_valid_i     (bus_valid && !ready_q),
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
        .adc_din_o       (adc_din_o),
        .adc_sdata_i     (adc_sdata_i),
        .enc_a_i         (enc_a_i),
        .enc_b_i         (enc_b_i),
        .gate_ah_o       (gate_ah_o),
        .gate_al_o       (gate_al_o),
        .gate_bh_o       (gate_bh_o),
        .gate_bl_o       (gate_bl_o),
        .bus_i           (bus_i),
        .stop_i          (stop_i),
        .driver_fault_i  (driver_fault_i),
        .tick_o          (tick_o),
        .running_o       (running_o),
        .contact_o       (contact_o),
        .fault_o         (fault_o),
        .fault_lasts_o   (fault_lasts_o),
        .clear_i         (clear_i),
        .zero_start_i    (zero_start_i),
        .press_i         (press_i),
        .ready_o         (ready_o),
        .clear_o         (clear_o),
        .zero_busy_o     (zero_busy_o),
        .zero_fault_o    (zero_fault_o),
        .stream_credit_o (stream_credit),
        .stream_valid_o  (stream_valid),
        .stream_first_o  (stream_first),
        .stream_byte_o   (stream_byte),
        .stream_packet_o (stream_packet),
        .stream_room_i   (stream_room)
    );

endmodule

`default_nettype wire
