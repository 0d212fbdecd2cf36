// SPDX-License-Identifier: Apache-2.0
//
// wh_board_controller: wh_controller with a board's constants, and the switch that lets it run.
//
// The constants are those of wh_board_settings.vh, made from the board's scene.
//
// The gates go on when start_i rises while stop_i is low, and go off when stop_i is high, at a fault
// of the encoder, when a tick is too short for its work, when a sample of the current reaches
// WH_BOARD_TRIP, which lies below what clips, at what the guard finds where the board has one, when
// the clock was lost, and in reset. They stay off until start_i rises again; after a fault, until
// reset. start_i and stop_i are asynchronous, and believed once they have been still for
// 2^SETTLE_LOG2 clocks; off needs no patience. What encoder, current and guard say before that time
// is over, as long as an ADC wakes up, is forgotten.
//
// Without a clock the gates stay as they are. clock_lost_i is what wh_board_clock_watch found, which
// takes them off the pads; 0 where the board has none. alive_o changes at each tick while the gates
// are on, and is low otherwise; it stands still without a clock, and a charge pump behind it lets
// go of the bridge.
// Reset: gates off, not running, alive_o low.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"
`include "wh_board_settings.vh"

module wh_board_controller #(
    parameter integer SETTLE_LOG2 = 16  // start_i must be still for 2^SETTLE_LOG2 clocks
) (
    input  wire                  clk,
    input  wire                  rst,

    input  wire                  start_i,      // asynchronous
    input  wire                  stop_i,       // asynchronous
    input  wire                  clock_lost_i, // asynchronous

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
    output wire                  fault_o       // until reset
);

    localparam integer N = `WH_BOARD_N;

    // ---- The switch.

    wire start;
    wire stop;
    wire clock_lost;

    wh_synchroniser #(
        .WIDTH   (3)
    ) synchroniser (
        .clk     (clk),
        .level_i ({start_i, stop_i, clock_lost_i}),
        .level_o ({start, stop, clock_lost})
    );

    // Pressed is a level that has lasted: it may be the press that goes on through reset, which is
    // no rise.
    reg [SETTLE_LOG2-1:0] settle_q;
    reg                   pressed_q;
    reg                   running_q;
    reg                   fault_q;

    wire settled = (settle_q == {SETTLE_LOG2{1'b1}});

    wire [N-1:0] encoder_fault;
    wire         overrun;
    wire         guarded_fault;
    reg          awake_q;        // start_i has been believed once
    wire [N-1:0] overcurrent;
    wire         forgets = !awake_q;

    always @(posedge clk) begin
        if (rst) begin
            settle_q  <= {SETTLE_LOG2{1'b0}};
            pressed_q <= 1'b1;
            running_q <= 1'b0;
            fault_q   <= 1'b0;
            awake_q   <= 1'b0;
        end else begin
            fault_q <= fault_q || overrun || clock_lost
                       || (((|encoder_fault) || (|overcurrent) || guarded_fault) && !forgets);
            awake_q <= awake_q || settled;
            if (start == pressed_q) begin
                settle_q <= {SETTLE_LOG2{1'b0}};
            end else begin
                settle_q <= settle_q + 1'b1;
                if (settled) begin
                    pressed_q <= start;
                end
            end
            if (stop || fault_q) begin
                running_q <= 1'b0;
            end else if (settled && start && !pressed_q) begin
                running_q <= 1'b1;
            end
        end
    end

    assign running_o = running_q;
    assign fault_o   = fault_q;

    wire tick;
    reg  alive_q;

    always @(posedge clk) begin
        alive_q <= !rst && running_q && (alive_q ^ tick);
    end

    assign alive_o = alive_q;

    // ---- The controller.

    wire [N-1:0]             contact;
    wire                     adc_din;
    wire                     adc_ready;
    wire                     core_valid;
    wire [N*`WH_DATA_W-1:0]  voltage;
    wire [N*`WH_DATA_W-1:0]  u;
    wire [N*`WH_DATA_W-1:0]  v;
    wire [N*`WH_DATA_W-1:0]  current;
    wire [N*`WH_COUNT_W-1:0] position;
    wire [N-1:0]             saturated;
    wire [N-1:0]             adc_range;
    wire [N-1:0]             adc_stuck;
    wire [N-1:0]             zero_fault;
    wire [N-1:0]             zero_busy;
    wire [`WH_FAULTS-1:0]    faults;
    wire                     bridges_on;

    // For a host, which this top doesn't have.
    wire unused = &{1'b0, adc_din, adc_ready, core_valid, voltage, u, v, current, position,
                    saturated, adc_range, adc_stuck, zero_fault, zero_busy, bridges_on};

    assign guarded_fault = |faults;

    assign contact_o = |contact;

    wire [N-1:0]             host_strobe;
    wire [N*8-1:0]           host_sequence;
    wire [N*`WH_DATA_W-1:0]  host_v;
    wire [N-1:0]             host_active;

    wire unused_host = &{1'b0, host_strobe, host_sequence, host_v, host_active};

    // Of the port anchor, which this top doesn't have.
    wire [N*`WH_DATA_W-1:0]  correction;
    wire [N*`WH_DATA_W-1:0]  offset;
    wire [N*`WH_DATA_W-1:0]  flux;
    wire [N*`WH_DATA_W-1:0]  lag;
    wire [N-1:0]             anchor_fault;

    wire unused_anchor = &{1'b0, correction, offset, flux, lag, anchor_fault};

    wh_controller #(
        .N                  (N),
        .WALLS              (`WH_BOARD_WALLS),
        .DELAY_LOG2         (`WH_BOARD_DELAY_LOG2),
        .MODES              (`WH_BOARD_MODES),
        .MIN_PULSE          (`WH_BOARD_SHORTEST),
        .EARLY              (`WH_BOARD_EARLY),
        .ANCHOR             (0),
        .GUARD              (`WH_BOARD_GUARDED)
    ) controller (
        .clk                (clk),
        .rst                (rst),
        .enable_i           (running_q),
        .adc_cs_n_o         (adc_cs_n_o),
        .adc_sclk_o         (adc_sclk_o),
        .adc_din_o          (adc_din),
        .adc_sdata_i        (adc_sdata_i),
        .enc_a_i            (enc_a_i),
        .enc_b_i            (enc_b_i),
        .gate_ah_o          (gate_ah_o),
        .gate_al_o          (gate_al_o),
        .gate_bh_o          (gate_bh_o),
        .gate_bl_o          (gate_bl_o),
        .half_clocks_i      (`WH_BOARD_HALF_CLOCKS),
        .tick_halves_i      (`WH_BOARD_TICK_HALVES),
        .sample_clocks_i    (`WH_BOARD_SAMPLE_CLOCKS),
        .samples_i          (`WH_BOARD_SAMPLES),
        .sample_lead_i      (`WH_BOARD_SAMPLE_LEAD),
        .sample_late_i      (`WH_BOARD_SAMPLE_LATE),
        .sclk_half_clocks_i (`WH_BOARD_SCLK_HALF_CLOCKS),
        .frame_bits_i       (`WH_BOARD_FRAME_BITS),
        .lead_bits_i        (`WH_BOARD_LEAD_BITS),
        .data_bits_i        (`WH_BOARD_DATA_BITS),
        .quiet_clocks_i     (`WH_BOARD_QUIET_CLOCKS),
        .setup_clocks_i     (`WH_BOARD_SETUP_CLOCKS),
        .hold_clocks_i      (`WH_BOARD_HOLD_CLOCKS),
        .calibrate_bits_i   (`WH_BOARD_CALIBRATE_BITS),
        .sclk_idle_i        (`WH_BOARD_SCLK_IDLE),
        .read_trailing_i    (`WH_BOARD_READ_TRAILING),
        .trip_i             (`WH_BOARD_TRIP),
        .zero_i             (`WH_BOARD_ZERO),
        .range_i            (16'hffff),
        .stuck_words_i      (16'd0),
        .zero_start_i       (1'b0),
        .zero_limit_i       ({`WH_SUM_W-1{1'b0}}),
        .gain_i             (`WH_BOARD_GAIN),
        .filter_clocks_i    (`WH_BOARD_FILTER_CLOCKS),
        .wall_min_i         (`WH_BOARD_WALL_MIN),
        .wall_max_i         (`WH_BOARD_WALL_MAX),
        .wall_enable_i      (`WH_BOARD_WALL_ENABLE),
        .eta_contact_i      (`WH_BOARD_ETA_CONTACT),
        .eta_free_i         (`WH_BOARD_ETA_FREE),
        .host_period_log2_i (4'd0),
        .host_timeout_i     (8'd0),
        .host_strobe_i      ({N{1'b0}}),
        .host_sequence_i    ({N*8{1'b0}}),
        .host_u_i           ({N*`WH_DATA_W{1'b0}}),
        .host_strobe_o      (host_strobe),
        .host_sequence_o    (host_sequence),
        .host_v_o           (host_v),
        .host_active_o      (host_active),
        .edge_hysteresis_i  ({N{1'b0}}),
        .shape_words_i      ({N*(9*`WH_SHAPE_W+3*`WH_SHAPE_LOSS_W){1'b0}}),
        .wall_shaped_i      ({N*`WH_BOARD_WALLS{1'b0}}),
        .root_i             (`WH_BOARD_ROOT),
        .a_i                (`WH_BOARD_A),
        .u_max_i            (`WH_BOARD_U_MAX),
        .anchor_words_i     ({N*`WH_ANCHOR_W{1'b0}}),
        .extra_ticks_i      (`WH_BOARD_EXTRA_TICKS),
        .hold_ticks_i       (`WH_BOARD_HOLD_TICKS),
        .mode_i             (`WH_BOARD_MODE),
        .min_pulse_i        (`WH_BOARD_MIN_PULSE),
        .clocks_per_volt_i  (`WH_BOARD_CLOCKS_PER_VOLT),
        .bus_share_i        (`WH_BOARD_BUS_SHARE),
        .dead_clocks_i      (`WH_BOARD_DEAD_CLOCKS),
        .guard_i            (`WH_BOARD_GUARD),
        .clear_i            (forgets),
        .stop_i             (1'b0),
        .driver_fault_i     ({N{1'b0}}),
        .host_alive_i       (1'b0),
        .bus_i              (16'd0),
        .anchor_fault_i     ({N{1'b0}}),
        .faults_o           (faults),
        .running_o          (bridges_on),
        .adc_ready_o        (adc_ready),
        .compensate_i       (`WH_BOARD_COMPENSATE),
        .side_current_i     (`WH_BOARD_SIDE_CURRENT),
        .settle_ticks_i     (`WH_BOARD_SETTLE_TICKS),
        .second_order_i     (`WH_BOARD_SECOND_ORDER),
        .tick_o             (tick),
        .core_valid_o       (core_valid),
        .voltage_o          (voltage),
        .correction_o       (correction),
        .offset_o           (offset),
        .flux_o             (flux),
        .lag_o              (lag),
        .anchor_fault_o     (anchor_fault),
        .u_o                (u),
        .v_o                (v),
        .current_o          (current),
        .position_o         (position),
        .contact_o          (contact),
        .saturated_o        (saturated),
        .adc_range_o        (adc_range),
        .adc_stuck_o        (adc_stuck),
        .zero_fault_o       (zero_fault),
        .zero_busy_o        (zero_busy),
        .overcurrent_o      (overcurrent),
        .encoder_fault_o    (encoder_fault),
        .overrun_o          (overrun)
    );

endmodule

`default_nettype wire
