// SPDX-License-Identifier: Apache-2.0
//
// wh_pins: what each motor has of its own: the count of its encoder, and the pattern and gates of its bridge.
//
//   A, B  -> wh_quadrature -> count
//   width -> wh_pwm -> wh_half_bridge -> gates
//
// Formats, latency: those of the blocks. A width holds until the next.
// Reset: gates off, count 0; the width with run_i = 0 too.

`default_nettype none
`include "wh_formats.vh"

module wh_pins #(
    parameter integer MODES = 0  // 1: mode_i chooses the bridge's pattern; 0: unipolar
) (
    input  wire                         clk,
    input  wire                         rst,
    input  wire                         run_i,            // the bridge is on

    // Pins.
    input  wire                         enc_a_i,          // asynchronous
    input  wire                         enc_b_i,          // asynchronous
    output wire                         gate_ah_o,
    output wire                         gate_al_o,
    output wire                         gate_bh_o,
    output wire                         gate_bl_o,

    // The encoder.
    input  wire [3:0]                   filter_clocks_i,
    input  wire                         clear_i,
    output wire [`WH_MOVE_W-1:0]        count_o,          // counts, modulo 2^12
    output wire                         moved_o,          // strobe,
    output wire                         direction_o,      // of the last move: 1 is +, 0 is -
    output wire                         illegal_move_o,   // strobe
    output wire                         encoder_fault_o,  // until clear_i

    // The carrier (wh_carrier).
    input  wire [`WH_TICK_W-1:0]        phase_i,
    input  wire [`WH_TICK_W-1:0]        remaining_i,
    input  wire                         half_i,
    input  wire                         update_i,

    // The bridge.
    input  wire                         width_valid_i,    // strobe
    input  wire signed [`WH_TICK_W-1:0] width_i,          // s16, clocks, for the half after the next update_i
    input  wire [`WH_TICK_W-1:0]        half_clocks_i,
    input  wire [`WH_MODE_W-1:0]        mode_i,
    input  wire                         half_bridge_i,    // leg B is not used
    input  wire [7:0]                   dead_clocks_i
);

    wire [7:0] faults;
    wire       unused = &{1'b0, faults};
    wire       leg_a;
    wire       leg_b;
    wire       off    = rst || !run_i;

    wh_quadrature #(
        .COUNT_W         (`WH_MOVE_W)
    ) quadrature (
        .clk             (clk),
        .rst             (rst),
        .a_i             (enc_a_i),
        .b_i             (enc_b_i),
        .filter_clocks_i (filter_clocks_i),
        .clear_i         (clear_i),
        .position_o      (count_o),
        .moved_o         (moved_o),
        .direction_o     (direction_o),
        .illegal_o       (illegal_move_o),
        .fault_o         (encoder_fault_o),
        .faults_o        (faults)
    );

    reg signed [`WH_TICK_W-1:0] width_q;

    always @(posedge clk) begin
        if (off) begin
            width_q <= {`WH_TICK_W{1'b0}};
        end else if (width_valid_i) begin
            width_q <= width_i;
        end
    end

    wh_pwm #(
        .MODES         (MODES)
    ) pwm (
        .clk           (clk),
        .rst           (off),
        .mode_i        (mode_i),
        .half_clocks_i (half_clocks_i),
        .phase_i       (phase_i),
        .remaining_i   (remaining_i),
        .half_i        (half_i),
        .update_i      (update_i),
        .width_i       (width_q),
        .leg_a_o       (leg_a),
        .leg_b_o       (leg_b)
    );

    wh_half_bridge leg_a_bridge (
        .clk           (clk),
        .rst           (rst),
        .enable_i      (run_i),
        .leg_i         (leg_a),
        .dead_clocks_i (dead_clocks_i),
        .high_o        (gate_ah_o),
        .low_o         (gate_al_o)
    );

    wh_half_bridge leg_b_bridge (
        .clk           (clk),
        .rst           (rst),
        .enable_i      (run_i && !half_bridge_i),
        .leg_i         (leg_b),
        .dead_clocks_i (dead_clocks_i),
        .high_o        (gate_bh_o),
        .low_o         (gate_bl_o)
    );

endmodule

`default_nettype wire
