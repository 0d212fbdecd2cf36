// SPDX-License-Identifier: Apache-2.0
//
// wh_board_brushless: the controller of a brushless motor with a board's constants, what lets it run
// (wh_arm), and its button and stop (wh_board_switch). What wh_board_controller is for motors with brushes.
//
// The constants are those of wh_board_settings.vh, made from the board's scene: WH_BOARD_PORTS has all
// that wh_brushless is told. There is no link: the button alone lets the gates on, and faults last until
// reset.
//
// start_i, stop_i, clock_lost_i, alive_o and fault_o are the switch's; running_o: the gates are on.
// Latency: those of the switch, of wh_arm and of wh_brushless.
// Reset: gates off, not running, alive_o low.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"
`include "wh_board_settings.vh"

module wh_board_brushless #(
    parameter integer SETTLE_LOG2 = 16, // start_i must be still for 2^SETTLE_LOG2 clocks
    parameter integer ZERO_LOG2   = 10  // ticks of a zero, 2^ZERO_LOG2; 2...16
) (
    input  wire       clk,
    input  wire       rst,

    input  wire       start_i,      // asynchronous
    input  wire       stop_i,       // asynchronous
    input  wire       clock_lost_i, // asynchronous

    output wire       adc_cs_n_o,
    output wire       adc_sclk_o,
    input  wire [1:0] adc_sdata_i,  // phase a lowest
    input  wire       enc_a_i,      // asynchronous
    input  wire       enc_b_i,      // asynchronous
    output wire [2:0] gate_high_o,  // leg a lowest
    output wire [2:0] gate_low_o,

    output wire       alive_o,
    output wire       running_o,
    output wire       contact_o,    // in a wall
    output wire       fault_o
);

    wire       permit;
    wire       press;
    wire       forget;
    wire       first_zero;
    wire       armed;
    wire       arm_zero;
    wire [4:0] refused;  // of a command that never comes

    wire       tick;
    wire       overrun;
    wire       anchor_fault;
    wire       encoder_fault;
    wire [1:0] zero_busy;
    wire [1:0] zero_fault;
    wire [1:0] overcurrent;

    wire [`WH_FAULTS-1:0] faults;

    wh_board_switch #(
        .SETTLE_LOG2     (SETTLE_LOG2)
    ) board_switch (
        .clk             (clk),
        .rst             (rst),
        .start_i         (start_i),
        .stop_i          (stop_i),
        .clock_lost_i    (clock_lost_i),
        .tick_i          (tick),
        .running_i       (running_o),
        .overrun_i       (overrun),
        .zero_busy_i     (|zero_busy),
        .zero_fault_i    (|zero_fault),
        .anchor_fault_i  (anchor_fault),
        .encoder_fault_i (encoder_fault),
        .overcurrent_i   (|overcurrent),
        .guard_fault_i   (|faults),
        .clear_i         (1'b0),
        .forget_o        (forget),
        .zero_start_o    (first_zero),
        .press_o         (press),
        .permit_o        (permit),
        .alive_o         (alive_o),
        .fault_o         (fault_o)
    );

    // The button is all that arms, and no command comes that would have to be renewed.
    wh_arm #(
        .SENSE        (1),
        .CREDIT       (2)
    ) arm (
        .clk          (clk),
        .rst          (rst),
        .enable_i     (permit),
        .fault_i      (1'b0),
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

    // What it sees besides is nobody's here.
    wire                     adc_ready;
    wire                     core_valid;
    wire                     magnet_found;
    wire [1:0]               saturated;
    wire [1:0]               adc_range;
    wire [1:0]               adc_stuck;
    wire [`WH_COUNT_W-1:0]   position;
    wire [2*`WH_DATA_W-1:0]  voltage;
    wire [2*`WH_DATA_W-1:0]  u;
    wire [2*`WH_DATA_W-1:0]  v;
    wire [2*`WH_DATA_W-1:0]  current;
    wire [2*`WH_DATA_W-1:0]  phase_current;
    wire [2*`WH_DATA_W-1:0]  correction;
    wire [2*`WH_DATA_W-1:0]  flux;
    wire [2*`WH_DATA_W-1:0]  lag;
    wire                     unused = &{1'b0, refused, adc_ready, core_valid, magnet_found, saturated,
                                        adc_range, adc_stuck, position, voltage, u, v, current,
                                        phase_current, correction, flux, lag};

    wh_brushless #(
        .WALLS           (`WH_BOARD_WALLS),
        .DELAY_LOG2      (`WH_BOARD_DELAY_LOG2),
        .MIN_PULSE       (`WH_BOARD_SHORTEST),
        .DEAD_TIME       (`WH_BOARD_COMPENSATE),
        .SENSE           (1),
        .ZERO_LOG2       (ZERO_LOG2),
        .GUARD           (`WH_BOARD_GUARDED),
        .ANCHOR          (`WH_BOARD_ANCHOR)
    ) brushless (
        `WH_BOARD_PORTS
        .clk             (clk),
        .rst             (rst),
        .enable_i        (permit && armed),
        .zero_start_i    (first_zero || arm_zero),
        .clear_i         (forget),
        .adc_cs_n_o      (adc_cs_n_o),
        .adc_sclk_o      (adc_sclk_o),
        .adc_sdata_i     (adc_sdata_i),
        .enc_a_i         (enc_a_i),
        .enc_b_i         (enc_b_i),
        .gate_high_o     (gate_high_o),
        .gate_low_o      (gate_low_o),
        .stop_i          (1'b0),
        .driver_fault_i  (1'b0),
        .faults_o        (faults),
        .running_o       (running_o),
        .adc_ready_o     (adc_ready),
        .tick_o          (tick),
        .core_valid_o    (core_valid),
        .voltage_o       (voltage),
        .u_o             (u),
        .v_o             (v),
        .current_o       (current),
        .phase_current_o (phase_current),
        .position_o      (position),
        .contact_o       (contact_o),
        .saturated_o     (saturated),
        .correction_o    (correction),
        .flux_o          (flux),
        .lag_o           (lag),
        .magnet_found_o  (magnet_found),
        .anchor_fault_o  (anchor_fault),
        .adc_range_o     (adc_range),
        .adc_stuck_o     (adc_stuck),
        .zero_fault_o    (zero_fault),
        .zero_busy_o     (zero_busy),
        .overcurrent_o   (overcurrent),
        .encoder_fault_o (encoder_fault),
        .overrun_o       (overrun)
    );

endmodule

`default_nettype wire
