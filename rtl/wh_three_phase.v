// SPDX-License-Identifier: Apache-2.0
//
// wh_three_phase: three half bridges on one carrier, from the voltages of their legs to six gates.
//
//   leg x is high for  half_clocks / 2 + width_x  clocks of each half,  width_x by wh_modulator
//   mean voltage of leg x over the middle of the bus = bus * width_x / half_clocks
//
// Each leg has a modulator, a pattern and a pair of gates of its own, in the pattern of a half bridge
// (wh_pwm): high around the end of a carrier's period, low around its middle, where half 0 and half 1
// meet. So all three are centred at one instant, and legs of equal widths switch together: at 0 V the
// winding sees no carrier at all. What a whole clock is too coarse for is owed to the next period, leg
// by leg.
// Dead time takes half of itself from a leg's width, against its current, once a period: one of the two
// edges is late. With DEAD_TIME = 1 a wh_dead_time each makes it good, by the leg's own current: what it
// says of a bridge of two legs and a half of the carrier holds of one leg and a period. Where no current
// has a side the legs try both, and three that try the same one drive nothing: so leg b waits PACE ticks
// longer between two changes than leg a, and leg c twice that. It wants an ADC whose step, noise and
// offset stay below side_current_i, or three mistaken legs hold each other.
// With MIN_PULSE = 1 a leg stays high or low for min_pulse_i clocks or more; every voltage has
// (min_pulse_i + 1) / 2 clocks of width less at either end.
//
// The products are made by a multiplier shared with other blocks (wh_multiply_shared), as in
// wh_current, whose users 0, 1 and 2 here are the legs a, b and c; voltage_i holds from valid_i until
// the last grant. A tick is whole periods: tick_halves_i of the carrier is even.
//
// Formats: below. Latency: as wh_modulator's, and 2 clocks from the carrier's phase to the gates, dead
// time aside. Reset or enable_i low: all six gates off at the next clock edge, widths 0.

`default_nettype none
`include "wh_formats.vh"

module wh_three_phase #(
    parameter integer MIN_PULSE = 0, // 1: min_pulse_i counts; 0: pulses may be of one clock
    parameter integer DEAD_TIME = 1  // 1: dead time can be made good
) (
    input  wire                                    clk,
    input  wire                                    rst,
    input  wire                                    enable_i,

    // Carrier (wh_carrier).
    input  wire        [`WH_TICK_W-1:0]            half_clocks_i,      // clocks in a half, 6...
    input  wire        [`WH_TICK_W-1:0]            phase_i,            // clocks since its start
    input  wire        [`WH_TICK_W-1:0]            remaining_i,        // clocks to its last
    input  wire                                    half_i,             // its parity
    input  wire                                    update_i,           // strobe, its last clock
    input  wire                                    take_i,             // strobe, tick_o - 4 clocks

    // Settings.
    input  wire signed [`WH_COEF_W-1:0]            clocks_per_volt_i,  // s27q16, half_clocks / bus
    input  wire        [7:0]                       min_pulse_i,        // clocks that a leg stays
    input  wire        [7:0]                       dead_clocks_i,      // clocks
    input  wire                                    second_order_i,     // error feedback of order 2
    input  wire                                    compensate_i,       // the dead time
    input  wire signed [`WH_DATA_W-1:0]            side_current_i,     // s31q24 A, 0...: where a
                                                                       // leg's current has a side
    input  wire        [7:0]                       settle_ticks_i,     // between changes of side of leg
                                                                       // a; more than 255 - 2 PACE: that

    input  wire        [2:0]                       current_valid_i,    // strobes, leg a lowest
    input  wire        [3*`WH_DATA_W-1:0]          currents_i,         // s31q24 A, out of the legs

    input  wire                                    valid_i,            // strobe
    input  wire        [3*`WH_DATA_W-1:0]          legs_i,             // s31q23 V, leg a lowest

    output wire        [2:0]                       request_o,
    input  wire        [2:0]                       grant_i,
    output wire        [3*`WH_DATA_W-1:0]          factor_o,           // s31q23 V
    output wire        [3*`WH_COEF_W-1:0]          coefficient_o,      // s27q16 clocks/V
    input  wire        [2:0]                       done_i,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i,          // s58q39 clocks

    output wire        [2:0]                       gate_high_o,        // leg a lowest
    output wire        [2:0]                       gate_low_o
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam integer PACE   = 3;
    localparam [`WH_MODE_W-1:0] HALF_BRIDGE = `WH_MODE_HALF_BRIDGE;

    generate
        if (DEAD_TIME != 0 && DEAD_TIME != 1) begin : illegal_dead_time
            wh_illegal_parameter_three_phase_dead_time_must_be_0_or_1 stop ();
        end
    endgenerate

    wire drive_rst = rst || !enable_i;

    // Leg c's still fits into its word.
    localparam [7:0] SETTLE_MOST = 8'd255 - 2 * PACE[7:0];
    wire       [7:0] settle      = (settle_ticks_i > SETTLE_MOST) ? SETTLE_MOST : settle_ticks_i;

    // Enough from either end of the scale for a leg's shortest pulse.
    wire [7:0] spare = (min_pulse_i >> 1) + {7'd0, min_pulse_i[0]};

    genvar n;
    generate
        for (n = 0; n < 3; n = n + 1) begin : leg
            wire signed [`WH_TICK_W-1:0]  width;
            wire                          level;
            wire                          opposite;
            wire                          unused = &{1'b0, opposite};
            wire signed [`WH_EXTRA_W-1:0] extra;

            if (DEAD_TIME != 0) begin : compensated
                localparam integer LATER  = n * PACE;
                localparam [7:0]   LONGER = LATER[7:0];

                wh_dead_time dead_time (
                    .clk            (clk),
                    .rst            (drive_rst),
                    .compensate_i   (compensate_i),
                    .dead_clocks_i  (dead_clocks_i),
                    .threshold_i    (side_current_i),
                    .settle_ticks_i (settle + LONGER),
                    .valid_i        (current_valid_i[n]),
                    .current_i      (currents_i[n*DATA_W +: DATA_W]),
                    .extra_o        (extra)
                );
            end else begin : as_it_is
                wire unused_dead = &{1'b0, compensate_i, side_current_i, settle,
                                     current_valid_i[n], currents_i[n*DATA_W +: DATA_W]};

                assign extra = {`WH_EXTRA_W{1'b0}};
            end

            wh_modulator #(
                .MIN_PULSE         (MIN_PULSE)
            ) modulator (
                .clk               (clk),
                .rst               (drive_rst),
                .valid_i           (valid_i),
                .voltage_i         (legs_i[n*DATA_W +: DATA_W]),
                .clocks_per_volt_i (clocks_per_volt_i),
                .half_clocks_i     (half_clocks_i),
                .second_order_i    (second_order_i),
                .extra_i           (extra),
                .least_i           (8'd0),
                .spare_i           (spare),
                .request_o         (request_o[n]),
                .grant_i           (grant_i[n]),
                .factor_o          (factor_o[n*DATA_W +: DATA_W]),
                .coefficient_o     (coefficient_o[n*COEF_W +: COEF_W]),
                .done_i            (done_i[n]),
                .product_i         (product_i),
                .take_i            (take_i),
                .update_i          (update_i && half_i),
                .width_o           (width)
            );

            wh_pwm #(
                .MODES         (1)
            ) pwm (
                .clk           (clk),
                .rst           (drive_rst),
                .mode_i        (HALF_BRIDGE),
                .half_clocks_i (half_clocks_i),
                .phase_i       (phase_i),
                .remaining_i   (remaining_i),
                .half_i        (half_i),
                .update_i      (update_i),
                .width_i       (width),
                .leg_a_o       (level),
                .leg_b_o       (opposite)
            );

            wh_half_bridge half_bridge (
                .clk           (clk),
                .rst           (rst),
                .enable_i      (enable_i),
                .leg_i         (level),
                .dead_clocks_i (dead_clocks_i),
                .high_o        (gate_high_o[n]),
                .low_o         (gate_low_o[n])
            );
        end
    endgenerate

endmodule

`default_nettype wire
