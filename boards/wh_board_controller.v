// SPDX-License-Identifier: Apache-2.0
//
// wh_board_controller: the controller with a board's constants, what lets it run (wh_arm), and its button
// and stop (wh_board_switch).
//
// The constants are those of wh_board_settings.vh, made from the board's scene: WH_BOARD_PORTS has
// every word of rtl/words.toml, WH_BOARD_WIRES a wire for each that the controller tells. A board with
// a link (WH_BOARD_LINKED) has wh_linked_device in place of wh_controller: it begins with the same words,
// which then stand in wh_board_settings_rom.vh, and those of some groups can be changed. Its line arms
// and disarms, beside the button, and forgets faults that are over, and only where the switch permits
// it. Without a link the button alone lets the gates on, faults last until reset, and uart_tx_o is high.
// WH_BOARD_N are ports. Brushless motors (WH_BOARD_AXES) have a link, and two ports each, with wh_device's pins.
//
// WH_BOARD_MORE_PORTS are pins that only some boards have: of SPI, with which a host MCU can have the line's
// place (wh_link), and overcurrent_n_i, low once comparators beside the FPGA have shut the gates. On the other
// boards they rest, by WH_BOARD_MORE_WIRES.
//
// start_i, stop_i, clock_lost_i, alive_o and fault_o are the switch's; running_o: the gates are on.
// Latency: those of the switch, of wh_arm, of wh_controller and of wh_linked_device.
// Reset: gates off, not running, alive_o low; with a link until all settings are given.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"
`include "wh_board_settings.vh"

module wh_board_controller #(
    parameter integer SETTLE_LOG2 = 16, // start_i must be still for 2^SETTLE_LOG2 clocks
    parameter integer ZERO_LOG2   = 10  // ticks of a zero, 2^ZERO_LOG2; 2...16
) (
    input  wire                  clk,
    input  wire                  rst,

    input  wire                  start_i,      // asynchronous
    input  wire                  stop_i,       // asynchronous
    input  wire                  clock_lost_i, // asynchronous

    input  wire                  uart_rx_i,    // asynchronous
    output wire                  uart_tx_o,
    `WH_BOARD_MORE_PORTS

    output wire                  adc_cs_n_o,
    output wire                  adc_sclk_o,
    input  wire [`WH_BOARD_N-1:0] adc_sdata_i,
    input  wire [`WH_BOARD_N-1:0] enc_a_i,     // asynchronous
    input  wire [`WH_BOARD_N-1:0] enc_b_i,     // asynchronous
    output wire [`WH_BOARD_N-1:0] gate_ah_o,
    output wire [`WH_BOARD_N-1:0] gate_al_o,
    output wire [`WH_BOARD_N-1:0] gate_bh_o,
    output wire [`WH_BOARD_N-1:0] gate_bl_o,

    output wire                  alive_o,
    output wire                  running_o,
    output wire                  contact_o,    // any motor is in a wall
    output wire                  fault_o
);

    localparam integer N     = `WH_BOARD_N;

    `WH_BOARD_MORE_WIRES

    generate
        if (`WH_BOARD_AXES != 0 && `WH_BOARD_LINKED == 0) begin : illegal
            wh_illegal_parameter_board_controller_with_axes_is_linked stop ();
        end
    endgenerate

    wire         permit;
    wire         press;
    wire         running_seen;
    wire         forget;
    wire         forgets_too;  // the line wants it
    wire         first_zero;
    wire         ready;
    wire         tick_seen;
    wire         overrun_seen;
    wire         guard_seen;
    wire         guard_lasts;
    wire         zero_busy_seen;
    wire [N-1:0] zero_fault_seen;
    wire [N-1:0] anchor_fault_seen;
    wire [N-1:0] encoder_fault_seen;
    wire [N-1:0] overcurrent_seen;
    wire         adc_din;  // of an ADC that no board has
    wire         unused = &{1'b0, adc_din};

    assign running_o = running_seen;

    wh_board_switch #(
        .N               (N),
        .AGAIN           (`WH_BOARD_AGAIN),
        .SETTLE_LOG2     (SETTLE_LOG2)
    ) board_switch (
        .clk             (clk),
        .rst             (rst || !ready),
        .start_i         (start_i),
        .stop_i          (stop_i),
        .clock_lost_i    (clock_lost_i),
        .tick_i          (tick_seen),
        .running_i       (running_seen),
        .overrun_i       (overrun_seen),
        .zero_busy_i     (zero_busy_seen),
        .zero_fault_i    (zero_fault_seen),
        .anchor_fault_i  (anchor_fault_seen),
        .encoder_fault_i (encoder_fault_seen),
        .overcurrent_i   (overcurrent_seen),
        .guard_fault_i   (guard_seen),
        .guard_lasts_i   (guard_lasts),
        .clear_i         (forgets_too),
        .forget_o        (forget),
        .zero_start_o    (first_zero),
        .press_o         (press),
        .permit_o        (permit),
        .alive_o         (alive_o),
        .fault_o         (fault_o)
    );

    // What both have, wh_controller and wh_linked_device.
`define WH_SAME_PARAMETERS \
        .N               (N), \
        .WALLS           (`WH_BOARD_WALLS), \
        .DELAY_LOG2      (`WH_BOARD_DELAY_LOG2), \
        .MODES           (`WH_BOARD_MODES), \
        .ADC             (`WH_BOARD_ADC), \
        .OSR             (`WH_BOARD_OSR), \
        .MIN_PULSE       (`WH_BOARD_SHORTEST), \
        .SHAPER          (`WH_BOARD_SHAPER), \
        .ZERO_LOG2       (ZERO_LOG2), \
        .HOST            (`WH_BOARD_HOST)

`define WH_SAME_PINS \
        .clk             (clk), \
        .rst             (rst), \
        .adc_cs_n_o      (adc_cs_n_o), \
        .adc_sclk_o      (adc_sclk_o), \
        .adc_din_o       (adc_din), \
        .adc_sdata_i     (adc_sdata_i), \
        .enc_a_i         (enc_a_i), \
        .enc_b_i         (enc_b_i), \
        .gate_ah_o       (gate_ah_o), \
        .gate_al_o       (gate_al_o), \
        .gate_bh_o       (gate_bh_o), \
        .gate_bl_o       (gate_bl_o), \
        .stop_i          (1'b0), \
        .driver_fault_i  ({N{overcurrent_n_i}}), \
        .clear_i         (forget)

    generate
        if (`WH_BOARD_LINKED != 0) begin : linked
            // The device's fault_o has these in it.
            assign overrun_seen       = 1'b0;
            assign anchor_fault_seen  = {N{1'b0}};
            assign encoder_fault_seen = {N{1'b0}};
            assign overcurrent_seen   = {N{1'b0}};

            wh_linked_device #(
                `WH_SAME_PARAMETERS,
                .AXES            (`WH_BOARD_AXES),
                .ARM             (1),
                .CAPTURE         (`WH_BOARD_CAPTURE),
                .STREAM          (`WH_BOARD_STREAM),
                .SPI             (`WH_BOARD_SPI),
                .SURFACES        (`WH_BOARD_SURFACES),
                .CLOCK_HZ        (`WH_BOARD_CLOCK_HZ),
                .BUILD           (`WH_BOARD_BUILD)
            ) device (
                `WH_SAME_PINS,
                .enable_i        (permit),
                .press_i         (press),
                .zero_start_i    (first_zero),
                .uart_rx_i       (uart_rx_i),
                .uart_tx_o       (uart_tx_o),
                .spi_cs_n_i      (spi_cs_n_i),
                .spi_sclk_i      (spi_sclk_i),
                .spi_mosi_i      (spi_mosi_i),
                .spi_miso_o      (spi_miso_o),
                .spi_drives_o    (spi_drives_o),
                .bus_i           ({`WH_BUS_W{1'b0}}),
                .tick_o          (tick_seen),
                .running_o       (running_seen),
                .contact_o       (contact_o),
                .fault_o         (guard_seen),
                .fault_lasts_o   (guard_lasts),
                .ready_o         (ready),
                .clear_o         (forgets_too),
                .zero_busy_o     (zero_busy_seen),
                .zero_fault_o    (zero_fault_seen)
            );
        end else begin : alone
            `WH_BOARD_WIRES
            wire armed;
            wire arm_zero;
            localparam [`WH_FAULTS-1:0] ZERO = {{`WH_FAULTS-1{1'b0}}, 1'b1} << `WH_FAULT_ZERO;
            wire [4:0] refused;
            wire unused_too = &{1'b0, uart_rx_i, spi_cs_n_i, spi_sclk_i, spi_mosi_i, refused};

            // The button is all that arms, and no command comes that would have to be renewed.
            wh_arm #(
                .SENSE        (1),
                .CREDIT       (2)
            ) arm (
                .clk          (clk),
                .rst          (rst),
                .enable_i     (permit),
                .fault_i      (1'b0),
                .zero_i       (|(faults & ZERO)),
                .loading_i    (1'b0),
                .write_i      (1'b0),
                .value_i      (2'd0),
                .press_i      (press),
                .zero_start_o (arm_zero),
                .zero_busy_i  (|zero_busy),
                .zero_fault_i (|zero_fault),
                .armed_o      (armed),
                .refused_o    (refused)
            );

            assign forgets_too        = 1'b0;
            assign running_seen       = running;
            assign ready              = 1'b1;
            assign uart_tx_o          = 1'b1;
            assign spi_miso_o         = 1'b0;
            assign spi_drives_o       = 1'b0;
            assign contact_o          = |contact;
            assign tick_seen          = tick;
            assign overrun_seen       = overrun;
            assign guard_seen         = |faults;
            assign guard_lasts        = |(faults & ~ZERO);
            assign zero_busy_seen     = |zero_busy;
            assign zero_fault_seen    = zero_fault;
            assign anchor_fault_seen  = anchor_fault;
            assign encoder_fault_seen = encoder_fault;
            assign overcurrent_seen   = overcurrent;

            wh_controller #(
                `WH_SAME_PARAMETERS,
                .ANCHOR          (`WH_BOARD_ANCHOR),
                .SHARED          (`WH_BOARD_SHARED),
                .SENSE           (1),
                .GUARD           (`WH_BOARD_GUARDED)
            ) controller (
                `WH_BOARD_PORTS
                .anchor_fault_i  ({N{1'b0}}),
                .scale_hold_o    (),
                .anchor_hold_o   (),
                .enable_i        (permit && armed),
                .zero_start_i    (first_zero || arm_zero),
                `WH_SAME_PINS
            );
        end
    endgenerate

`undef WH_SAME_PARAMETERS
`undef WH_SAME_PINS

endmodule

`default_nettype wire
