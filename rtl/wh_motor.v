// SPDX-License-Identifier: Apache-2.0
//
// wh_motor: what one motor's pins are, on the way in and on the way out.
//
//   ADC word -> wh_zero, wh_sense_check, wh_current -> current     position -> wh_contact -> eta
//   A, B     -> wh_quadrature -> position
//   voltage  -> wh_dead_time, wh_modulator -> wh_pwm -> wh_half_bridge -> gates
//
// What happens between current and voltage is wh_port's. Two products come from the multiplier that
// all share: current_* of the sum, drive_* of the voltage.
// Formats: those of the blocks.
// Latency: those of the blocks; wh_controller's header has their sum.
// Reset: gates off, position 0, no contact; the pulse width and the dead time's side with run_i = 0 too.

`default_nettype none
`include "wh_formats.vh"

module wh_motor #(
    parameter integer WALLS      = 4,  // these are wh_controller's
    parameter integer SENSE      = 0,
    parameter integer ZERO_LOG2  = 10,
    parameter integer DEAD_TIME  = 1,
    parameter integer MODES      = 0,
    parameter integer MIN_PULSE  = 0
) (
    input  wire                              clk,
    input  wire                              rst,
    input  wire                              sense_rst_i,      // carrier and ADC begin anew, so do currents
    input  wire                              run_i,            // the bridges are on

    // Pins.
    input  wire                              enc_a_i,          // asynchronous
    input  wire                              enc_b_i,          // asynchronous
    output wire                              gate_ah_o,
    output wire                              gate_al_o,
    output wire                              gate_bh_o,
    output wire                              gate_bl_o,

    // The carrier (wh_carrier).
    input  wire [`WH_TICK_W-1:0]             phase_i,
    input  wire [`WH_TICK_W-1:0]             remaining_i,
    input  wire                              half_i,
    input  wire                              update_i,
    input  wire                              take_i,

    // Words of the ADC to a current.
    input  wire                              word_valid_i,
    input  wire                              word_first_i,
    input  wire signed [`WH_SAMPLE_W-1:0]    word_i,
    input  wire [8:0]                        samples_i,
    input  wire signed [`WH_SUM_W-1:0]       zero_i,
    input  wire [15:0]                       range_i,
    input  wire [15:0]                       stuck_words_i,    // these three with SENSE = 1
    input  wire                              zero_start_i,
    input  wire [`WH_SUM_W-2:0]              zero_limit_i,
    input  wire signed [`WH_DATA_W-1:0]      offset_i,         // s31q24 A, taken off
    output wire                              current_valid_o,
    output wire signed [`WH_DATA_W-1:0]      current_o,        // s31q24 A
    output wire [1:0]                        current_ends_o,   // at the high, at the low end of its range
    output wire                              adc_range_o,
    output wire                              adc_stuck_o,
    output wire                              zero_fault_o,
    output wire                              zero_busy_o,

    // Position and contact.
    input  wire [3:0]                        filter_clocks_i,
    input  wire                              clear_i,
    input  wire                              contact_hold_i,   // a step of the core is under way
    input  wire [WALLS*`WH_COUNT_W-1:0]      wall_min_i,
    input  wire [WALLS*`WH_COUNT_W-1:0]      wall_max_i,
    input  wire [WALLS-1:0]                  wall_enable_i,
    input  wire [WALLS-1:0]                  wall_shaped_i,
    input  wire                              edge_hysteresis_i,
    input  wire signed [`WH_COEF_W-1:0]      eta_contact_i,
    input  wire signed [`WH_COEF_W-1:0]      eta_free_i,
    output wire signed [`WH_COUNT_W-1:0]     position_o,
    output wire                              moved_o,
    output wire                              direction_o,
    output wire                              illegal_move_o,
    output wire                              encoder_fault_o,
    output wire                              round_o,
    output wire                              contact_o,
    output wire                              shaped_o,
    output wire signed [`WH_COEF_W-1:0]      eta_o,

    // A voltage to the gates.
    input  wire                              voltage_valid_i,
    input  wire signed [`WH_DATA_W-1:0]      voltage_i,        // s31q23 V
    input  wire [`WH_TICK_W-1:0]             half_clocks_i,
    input  wire [`WH_MODE_W-1:0]             mode_i,
    input  wire                              half_bridge_i,    // leg B is not used
    input  wire                              whole_i,          // one width for both halves
    input  wire [7:0]                        least_i,
    input  wire [7:0]                        spare_i,
    input  wire signed [`WH_COEF_W-1:0]      clocks_per_volt_i,
    input  wire [7:0]                        dead_clocks_i,
    input  wire                              compensate_i,
    input  wire signed [`WH_DATA_W-1:0]      side_current_i,
    input  wire [7:0]                        settle_ticks_i,
    input  wire                              second_order_i,

    // The shared multiplier.
    output wire                              current_request_o,
    output wire signed [`WH_DATA_W-1:0]      current_factor_o, // the tick's sum
    input  wire                              current_grant_i,
    input  wire                              current_done_i,
    output wire                              drive_request_o,
    output wire signed [`WH_DATA_W-1:0]      drive_factor_o,
    output wire signed [`WH_COEF_W-1:0]      drive_coefficient_o,
    input  wire                              drive_grant_i,
    input  wire                              drive_done_i,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i
);

    localparam integer WALL_W = (WALLS < 2) ? 1 : $clog2(WALLS);

    generate
        if (SENSE != 0 && SENSE != 1) begin : illegal_sense
            wh_illegal_parameter_motor_sense_must_be_0_or_1 stop ();
        end
        if (DEAD_TIME != 0 && DEAD_TIME != 1) begin : illegal_dead_time
            wh_illegal_parameter_motor_dead_time_must_be_0_or_1 stop ();
        end
    endgenerate

    wire drive_rst = rst || !run_i;

    // ---- Current.

    wire signed [`WH_SUM_W-1:0] zero;

    generate
        if (SENSE != 0) begin : sense
            wire                        zero_done;
            wire                        measured;
            wire signed [`WH_SUM_W-1:0] measured_zero;
            wire                        unused = &{1'b0, zero_done, measured};

            // Both are signed, and one more bit holds their sum. What is measured is 0 at first.
            wh_saturate #(
                .IN_W    (`WH_SUM_W + 1),
                .OUT_W   (`WH_SUM_W)
            ) saturate_zero (
                .value_i ({measured_zero[`WH_SUM_W-1], measured_zero}
                          + {zero_i[`WH_SUM_W-1], zero_i}),
                .value_o (zero)
            );

            wh_sense_check sense_check (
                .clk           (clk),
                .rst           (rst),
                .valid_i       (word_valid_i),
                .sample_i      (word_i),
                .range_i       (range_i),
                .stuck_words_i (stuck_words_i),
                .range_o       (adc_range_o),
                .stuck_o       (adc_stuck_o)
            );

            wh_zero #(
                .LOG2_TICKS    (ZERO_LOG2)
            ) measure_zero (
                .clk           (clk),
                .rst           (rst),
                .valid_i       (word_valid_i),
                .first_i       (word_first_i),
                .sample_i      (word_i),
                .start_i       (zero_start_i),
                .bridge_off_i  (!run_i),
                .limit_i       (zero_limit_i),
                .busy_o        (zero_busy_o),
                .done_o        (zero_done),
                .measured_o    (measured),
                .zero_o        (measured_zero),
                .fault_o       (zero_fault_o)
            );
        end else begin : plain
            wire unused = &{1'b0, stuck_words_i, zero_start_i, zero_limit_i};

            assign zero         = zero_i;
            assign adc_range_o  = 1'b0;
            assign adc_stuck_o  = 1'b0;
            assign zero_fault_o = 1'b0;
            assign zero_busy_o  = 1'b0;
        end
    endgenerate

    wh_current current (
        .clk        (clk),
        .rst        (sense_rst_i),
        .valid_i    (word_valid_i),
        .first_i    (word_first_i),
        .sample_i   (word_i),
        .samples_i  (samples_i),
        .range_i    (range_i),
        .zero_i     (zero),
        .request_o  (current_request_o),
        .grant_i    (current_grant_i),
        .factor_o   (current_factor_o),
        .done_i     (current_done_i),
        .product_i  (product_i),
        .offset_i   (offset_i),
        .valid_o    (current_valid_o),
        .current_o  (current_o),
        .ends_o     (current_ends_o)
    );

    // ---- Position and contact.

    wire [7:0]                    faults;
    wire [WALL_W-1:0]             wall;
    wire signed [`WH_COUNT_W-1:0] depth;
    wire                          unused_of_contact = &{1'b0, faults, wall, depth};

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

    // Nothing is read of it in a step's first clock, in which it may still change: a clock
    // between any two steps, even where the next starts as one ends.
    wh_contact #(
        .WALLS         (WALLS)
    ) contact (
        .clk           (clk),
        .rst           (rst),
        .position_i    (position_o),
        .hold_i        (contact_hold_i),
        .wall_min_i    (wall_min_i),
        .wall_max_i    (wall_max_i),
        .wall_enable_i (wall_enable_i),
        .wall_shaped_i (wall_shaped_i),
        .hysteresis_i  (edge_hysteresis_i),
        .eta_contact_i (eta_contact_i),
        .eta_free_i    (eta_free_i),
        .round_o       (round_o),
        .contact_o     (contact_o),
        .wall_o        (wall),
        .shaped_o      (shaped_o),
        .depth_o       (depth),
        .eta_o         (eta_o)
    );

    // ---- Drive.

    wire signed [`WH_TICK_W-1:0]  width;
    wire signed [`WH_EXTRA_W-1:0] extra;
    wire                          leg_a;
    wire                          leg_b;

    generate
        if (DEAD_TIME != 0) begin : compensated
            wh_dead_time dead_time (
                .clk            (clk),
                .rst            (drive_rst),
                .compensate_i   (compensate_i),
                .dead_clocks_i  (dead_clocks_i),
                .threshold_i    (side_current_i),
                .settle_ticks_i (settle_ticks_i),
                .valid_i        (current_valid_o),
                .current_i      (current_o),
                .extra_o        (extra)
            );
        end else begin : as_it_is
            wire unused_dead = &{1'b0, compensate_i, side_current_i, settle_ticks_i};

            assign extra = {`WH_EXTRA_W{1'b0}};
        end
    endgenerate

    wh_modulator #(
        .MIN_PULSE         (MIN_PULSE)
    ) modulator (
        .clk               (clk),
        .rst               (drive_rst),
        .valid_i           (voltage_valid_i),
        .voltage_i         (voltage_i),
        .clocks_per_volt_i (clocks_per_volt_i),
        .half_clocks_i     (half_clocks_i),
        .second_order_i    (second_order_i),
        .extra_i           (extra),
        .least_i           (least_i),
        .spare_i           (spare_i),
        .request_o         (drive_request_o),
        .grant_i           (drive_grant_i),
        .factor_o          (drive_factor_o),
        .coefficient_o     (drive_coefficient_o),
        .done_i            (drive_done_i),
        .product_i         (product_i),
        .take_i            (take_i),
        .update_i          (update_i && (half_i || !whole_i)),
        .width_o           (width)
    );

    wh_pwm #(
        .MODES         (MODES)
    ) pwm (
        .clk           (clk),
        .rst           (drive_rst),
        .mode_i        (mode_i),
        .half_clocks_i (half_clocks_i),
        .phase_i       (phase_i),
        .remaining_i   (remaining_i),
        .half_i        (half_i),
        .update_i      (update_i),
        .width_i       (width),
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
