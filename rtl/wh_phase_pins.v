// SPDX-License-Identifier: Apache-2.0
//
// wh_phase_pins: what each brushless motor has of its own at its pins: its encoder's count, and three half bridges.
//
//   A, B   -> wh_quadrature -> position
//   widths -> wh_pwm, a half bridge's pattern each -> wh_half_bridge -> gates
//
// A leg is high for half_clocks_i / 2 + width clocks of each half, around the end of a carrier's period, and low around
// its middle. So all three are centred at one instant, and legs of equal widths switch together: at 0 V the winding
// sees no carrier at all.
// Formats, latency: those of the blocks. A width holds until the next.
// Reset: gates off, position 0; the widths with run_i = 0 too.

`default_nettype none
`include "wh_formats.vh"

module wh_phase_pins (
    input  wire                         clk,
    input  wire                         rst,
    input  wire                         run_i,            // the bridge is on

    // Pins.
    input  wire                         enc_a_i,          // asynchronous
    input  wire                         enc_b_i,          // asynchronous
    output wire [2:0]                   gate_high_o,      // leg a lowest
    output wire [2:0]                   gate_low_o,

    // The encoder.
    input  wire [3:0]                   filter_clocks_i,
    input  wire                         clear_i,
    output wire signed [`WH_COUNT_W-1:0] position_o,      // s32, counts
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
    input  wire [2:0]                   width_valid_i,    // strobes, leg a lowest
    input  wire signed [`WH_TICK_W-1:0] width_i,          // s16, clocks, for the period after the next
    input  wire [`WH_TICK_W-1:0]        half_clocks_i,
    input  wire [7:0]                   dead_clocks_i
);

    localparam [`WH_MODE_W-1:0] HALF_BRIDGE = `WH_MODE_HALF_BRIDGE;

    wire [7:0] faults;
    wire       unused = &{1'b0, faults};
    wire       off    = rst || !run_i;

    wh_quadrature quadrature (
        .clk             (clk),
        .rst             (rst),
        .a_i             (enc_a_i),
        .b_i             (enc_b_i),
        .filter_clocks_i (filter_clocks_i),
        .clear_i         (clear_i),
        .position_o      (position_o),
        .moved_o         (moved_o),
        .direction_o     (direction_o),
        .illegal_o       (illegal_move_o),
        .fault_o         (encoder_fault_o),
        .faults_o        (faults)
    );

    genvar n;
    generate
        for (n = 0; n < 3; n = n + 1) begin : leg
            reg signed [`WH_TICK_W-1:0] width_q;
            wire                        level;
            wire                        opposite;
            wire                        unused_opposite = &{1'b0, opposite};

            always @(posedge clk) begin
                if (off) begin
                    width_q <= {`WH_TICK_W{1'b0}};
                end else if (width_valid_i[n]) begin
                    width_q <= width_i;
                end
            end

            wh_pwm #(
                .MODES         (1)
            ) pwm (
                .clk           (clk),
                .rst           (off),
                .mode_i        (HALF_BRIDGE),
                .half_clocks_i (half_clocks_i),
                .phase_i       (phase_i),
                .remaining_i   (remaining_i),
                .half_i        (half_i),
                .update_i      (update_i),
                .width_i       (width_q),
                .leg_a_o       (level),
                .leg_b_o       (opposite)
            );

            wh_half_bridge half_bridge (
                .clk           (clk),
                .rst           (rst),
                .enable_i      (run_i),
                .leg_i         (level),
                .dead_clocks_i (dead_clocks_i),
                .high_o        (gate_high_o[n]),
                .low_o         (gate_low_o[n])
            );
        end
    endgenerate

endmodule

`default_nettype wire
