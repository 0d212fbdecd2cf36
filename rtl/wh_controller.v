// SPDX-License-Identifier: Apache-2.0
//
// wh_controller: the wave controller from its pins to its pins, for N motors.
//
//   ADC bits -> wh_adc_serial -> wh_current -> wh_wave_core -> wh_modulator -> wh_pwm -> gates
//   encoder  -> wh_quadrature -> wh_contact -> eta ---^            wh_carrier times everything
//
// A positive current runs into the motor from bridge leg A and out to leg B; a positive voltage has
// leg A high while leg B is low; a positive position is where a positive current turns the rotor.
//
// enable_i = 0 keeps the gates off and the wave core and the pulse width in reset; the ADC, the
// currents and the positions run on, so that zero_i can be measured. enable_i is synchronous to
// clk.
// The settings, other than the walls, may change only in reset.
//
// Latency: the gates show the carrier's phase after 2 clocks, dead time aside, and CS_n falls 1
// clock after the sample's phase: sample_lead_i = -1 samples in the pulse's middle. The last sample
// of a tick reaches the gates with the next tick that ends
//     1 + (2k - 1) sclk_half_clocks_i + 14 + 24 N + 2 (N - 1) clocks
// after its sample strobe or later, k = lead_bits_i + data_bits_i (latency_clocks in
// sim/wavehaptics/pins_timing.py).
// Reset: gates off at the next clock edge, CS_n high, f = 0, no contact, position 0.

`default_nettype none
`include "wh_formats.vh"

module wh_controller #(
    parameter integer N          = 1,  // motors, 1...8
    parameter integer WALLS      = 4,  // walls of each, 1...16
    parameter integer DELAY_LOG2 = 2   // the delay line keeps 2^DELAY_LOG2 steps, 1...
) (
    input  wire                         clk,
    input  wire                         rst,
    input  wire                         enable_i,

    // Pins.
    output wire                         adc_cs_n_o,
    output wire                         adc_sclk_o,
    input  wire [N-1:0]                 adc_sdata_i,
    input  wire [N-1:0]                 enc_a_i,             // asynchronous
    input  wire [N-1:0]                 enc_b_i,             // asynchronous
    output wire [N-1:0]                 gate_ah_o,
    output wire [N-1:0]                 gate_al_o,
    output wire [N-1:0]                 gate_bh_o,
    output wire [N-1:0]                 gate_bl_o,

    // Carrier, tick and samples (wh_carrier).
    input  wire [`WH_TICK_W-1:0]        half_clocks_i,       // clocks in a carrier half
    input  wire [`WH_TICK_W-1:0]        tick_halves_i,       // halves in a tick
    input  wire [`WH_TICK_W-1:0]        sample_clocks_i,     // clocks from sample to sample
    input  wire [8:0]                   samples_i,           // samples in a tick, 1...256
    input  wire signed [7:0]            sample_lead_i,       // clocks that samples come early

    // ADC frame (wh_adc_serial).
    input  wire [7:0]                   sclk_half_clocks_i,  // half a period of SCLK, clocks
    input  wire [5:0]                   frame_bits_i,        // falls of SCLK
    input  wire [5:0]                   lead_bits_i,         // zeros
    input  wire [4:0]                   data_bits_i,         // data bits, 1...16
    input  wire [7:0]                   quiet_clocks_i,      // CS_n high, clocks

    // Current (wh_current).
    input  wire [N*`WH_SUM_W-1:0]       zero_i,              // s24, a tick's sum at 0 A
    input  wire [N*`WH_COEF_W-1:0]      gain_i,              // s27q35 A per unit of the sum

    // Position and contact (wh_quadrature, wh_contact).
    input  wire [3:0]                   filter_clocks_i,     // samples that a level must hold
    input  wire [N*WALLS*`WH_COUNT_W-1:0] wall_min_i,        // s32, counts
    input  wire [N*WALLS*`WH_COUNT_W-1:0] wall_max_i,        // s32, counts
    input  wire [N*WALLS-1:0]           wall_enable_i,
    input  wire [N*`WH_COEF_W-1:0]      eta_contact_i,       // s27q25, in [-1, 1]
    input  wire [N*`WH_COEF_W-1:0]      eta_free_i,          // s27q25, in [-1, 1]

    // Wave core (wh_wave_core).
    input  wire [N*`WH_COEF_W-1:0]      root_i,              // s27q22 √Ω, +-16: √(2R̂)
    input  wire [N*`WH_COEF_W-1:0]      a_i,                 // s27q25, in (0, 1]
    input  wire [N*`WH_DATA_W-1:0]      u_max_i,             // s31q23 √W, 0...128 √W
    input  wire [DELAY_LOG2-1:0]        extra_ticks_i,       // ticks
    input  wire [DELAY_LOG2-1:0]        hold_ticks_i,        // ticks

    // Drive (wh_modulator, wh_half_bridge).
    input  wire [N*`WH_COEF_W-1:0]      clocks_per_volt_i,   // s27q16 clocks/V
    input  wire [7:0]                   dead_clocks_i,       // clocks

    // What it sees and does.
    output wire                         tick_o,              // strobe, last clock of a tick
    output wire                         core_valid_o,        // strobe, the words below are new
    output wire [N*`WH_DATA_W-1:0]      voltage_o,           // s31q23 V, +-128 V: e to be applied
    output wire [N*`WH_DATA_W-1:0]      u_o,                 // s31q23 √W: u_n, measured tick
    output wire [N*`WH_DATA_W-1:0]      v_o,                 // s31q23 √W: v_n, measured tick
    output wire [N*`WH_DATA_W-1:0]      current_o,           // s31q24 A, +-64 A: i_n
    output wire [N*`WH_COUNT_W-1:0]     position_o,          // s32, counts
    output wire [N-1:0]                 contact_o,
    output wire [N-1:0]                 saturated_o,         // the voltage limit was at work
    output wire [N-1:0]                 encoder_fault_o,     // illegal move seen; until rst
    output wire                         overrun_o            // a tick is too short for its work;
                                                             // until rst (core: or enable_i = 0)
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam integer USERS  = 2 * N;
    localparam integer WALL_W = (WALLS < 2) ? 1 : $clog2(WALLS);

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_controller_n_must_be_1_to_8 stop ();
        end
    endgenerate

    wire drive_rst = rst || !enable_i;

    // ---- Carrier.

    wire [`WH_TICK_W-1:0] phase;
    wire [`WH_TICK_W-1:0] remaining;
    wire                  half;
    wire                  update;
    wire                  take;
    wire                  sample;
    wire                  sample_first;

    wh_carrier carrier (
        .clk             (clk),
        .rst             (rst),
        .half_clocks_i   (half_clocks_i),
        .tick_halves_i   (tick_halves_i),
        .sample_clocks_i (sample_clocks_i),
        .samples_i       (samples_i),
        .sample_lead_i   (sample_lead_i),
        .phase_o         (phase),
        .remaining_o     (remaining),
        .half_o          (half),
        .update_o        (update),
        .take_o          (take),
        .tick_o          (tick_o),
        .sample_o        (sample),
        .sample_first_o  (sample_first)
    );

    // ---- Current.

    wire                      adc_busy;
    wire                      adc_valid;
    wire [N*`WH_SAMPLE_W-1:0] adc_sample;
    wire                      adc_overrun;

    wh_adc_serial #(
        .LINES              (N)
    ) adc_serial (
        .clk                (clk),
        .rst                (rst),
        .adc_cs_n_o         (adc_cs_n_o),
        .adc_sclk_o         (adc_sclk_o),
        .adc_sdata_i        (adc_sdata_i),
        .sclk_half_clocks_i (sclk_half_clocks_i),
        .frame_bits_i       (frame_bits_i),
        .lead_bits_i        (lead_bits_i),
        .data_bits_i        (data_bits_i),
        .quiet_clocks_i     (quiet_clocks_i),
        .start_i            (sample),
        .busy_o             (adc_busy),
        .valid_o            (adc_valid),
        .sample_o           (adc_sample),
        .overrun_o          (adc_overrun)
    );

    // Whether the conversion that is under way is its tick's first.
    reg converting_first_q;

    always @(posedge clk) begin
        if (rst) begin
            converting_first_q <= 1'b0;
        end else if (sample && !adc_busy) begin
            converting_first_q <= sample_first;
        end
    end

    wire [N-1:0] current_valid;

    // ---- One multiplier for the currents (users 0...N-1) and the voltages (N...2N-1).

    wire        [USERS-1:0]         multiply_request;
    wire        [USERS*DATA_W-1:0]  multiply_data;
    wire        [USERS*COEF_W-1:0]  multiply_coef;
    wire        [USERS-1:0]         multiply_grant;
    wire        [USERS-1:0]         multiply_done;
    wire signed [DATA_W+COEF_W-1:0] product;

    wh_multiply_shared #(
        .USERS     (USERS)
    ) multiply_shared (
        .clk       (clk),
        .rst       (rst),
        .request_i (multiply_request),
        .data_i    (multiply_data),
        .coef_i    (multiply_coef),
        .grant_o   (multiply_grant),
        .done_o    (multiply_done),
        .product_o (product)
    );

    // ---- Wave core. The currents of a tick come in turn, so the last port's starts it.

    wire                core_start = current_valid[N-1];
    wire                core_busy;
    wire                core_overrun;
    wire [N*COEF_W-1:0] eta;

    wh_wave_core #(
        .N             (N),
        .DELAY_LOG2    (DELAY_LOG2)
    ) wave_core (
        .clk           (clk),
        .rst           (drive_rst),
        .start_i       (core_start),
        .busy_o        (core_busy),
        .valid_o       (core_valid_o),
        .overrun_o     (core_overrun),
        .current_i     (current_o),
        .eta_i         (eta),
        .root_i        (root_i),
        .a_i           (a_i),
        .u_max_i       (u_max_i),
        .extra_ticks_i (extra_ticks_i),
        .hold_ticks_i  (hold_ticks_i),
        .voltage_o     (voltage_o),
        .u_o           (u_o),
        .v_o           (v_o),
        .saturated_o   (saturated_o)
    );

    assign overrun_o = adc_overrun || core_overrun;

    // ---- What each motor has of its own.

    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : port

            wh_current current (
                .clk       (clk),
                .rst       (rst),
                .valid_i   (adc_valid),
                .first_i   (converting_first_q),
                .sample_i  (adc_sample[n*`WH_SAMPLE_W +: `WH_SAMPLE_W]),
                .samples_i (samples_i),
                .zero_i    (zero_i[n*`WH_SUM_W +: `WH_SUM_W]),
                .request_o (multiply_request[n]),
                .grant_i   (multiply_grant[n]),
                .factor_o  (multiply_data[n*DATA_W +: DATA_W]),
                .done_i    (multiply_done[n]),
                .product_i (product),
                .valid_o   (current_valid[n]),
                .current_o (current_o[n*DATA_W +: DATA_W])
            );

            assign multiply_coef[n*COEF_W +: COEF_W] = gain_i[n*COEF_W +: COEF_W];

            wire       moved;
            wire       direction;
            wire [7:0] faults;

            wh_quadrature quadrature (
                .clk             (clk),
                .rst             (rst),
                .a_i             (enc_a_i[n]),
                .b_i             (enc_b_i[n]),
                .filter_clocks_i (filter_clocks_i),
                .clear_i         (1'b0),
                .position_o      (position_o[n*`WH_COUNT_W +: `WH_COUNT_W]),
                .moved_o         (moved),
                .direction_o     (direction),
                .fault_o         (encoder_fault_o[n]),
                .faults_o        (faults)
            );

            wire        [WALL_W-1:0]      wall;
            wire signed [`WH_COUNT_W-1:0] depth;

            // For a host's registers, which this module doesn't have.
            wire unused = &{1'b0, moved, direction, faults, wall, depth};

            wh_contact #(
                .WALLS         (WALLS)
            ) contact (
                .clk           (clk),
                .rst           (rst),
                .position_i    (position_o[n*`WH_COUNT_W +: `WH_COUNT_W]),
                .hold_i        (core_start || core_busy),
                .wall_min_i    (wall_min_i[n*WALLS*`WH_COUNT_W +: WALLS*`WH_COUNT_W]),
                .wall_max_i    (wall_max_i[n*WALLS*`WH_COUNT_W +: WALLS*`WH_COUNT_W]),
                .wall_enable_i (wall_enable_i[n*WALLS +: WALLS]),
                .eta_contact_i (eta_contact_i[n*COEF_W +: COEF_W]),
                .eta_free_i    (eta_free_i[n*COEF_W +: COEF_W]),
                .contact_o     (contact_o[n]),
                .wall_o        (wall),
                .depth_o       (depth),
                .eta_o         (eta[n*COEF_W +: COEF_W])
            );

            wire signed [`WH_TICK_W-1:0] width;
            wire                         leg_a;
            wire                         leg_b;

            wh_modulator modulator (
                .clk               (clk),
                .rst               (drive_rst),
                .valid_i           (core_valid_o),
                .voltage_i         (voltage_o[n*DATA_W +: DATA_W]),
                .clocks_per_volt_i (clocks_per_volt_i[n*COEF_W +: COEF_W]),
                .half_clocks_i     (half_clocks_i),
                .request_o         (multiply_request[N+n]),
                .grant_i           (multiply_grant[N+n]),
                .factor_o          (multiply_data[(N+n)*DATA_W +: DATA_W]),
                .coefficient_o     (multiply_coef[(N+n)*COEF_W +: COEF_W]),
                .done_i            (multiply_done[N+n]),
                .product_i         (product),
                .take_i            (take),
                .update_i          (update),
                .width_o           (width)
            );

            wh_pwm pwm (
                .clk         (clk),
                .rst         (drive_rst),
                .phase_i     (phase),
                .remaining_i (remaining),
                .half_i      (half),
                .update_i    (update),
                .width_i     (width),
                .leg_a_o     (leg_a),
                .leg_b_o     (leg_b)
            );

            wh_half_bridge leg_a_bridge (
                .clk           (clk),
                .rst           (rst),
                .enable_i      (enable_i),
                .leg_i         (leg_a),
                .dead_clocks_i (dead_clocks_i),
                .high_o        (gate_ah_o[n]),
                .low_o         (gate_al_o[n])
            );

            wh_half_bridge leg_b_bridge (
                .clk           (clk),
                .rst           (rst),
                .enable_i      (enable_i),
                .leg_i         (leg_b),
                .dead_clocks_i (dead_clocks_i),
                .high_o        (gate_bh_o[n]),
                .low_o         (gate_bl_o[n])
            );
        end
    endgenerate

endmodule

`default_nettype wire
