// SPDX-License-Identifier: Apache-2.0
//
// wh_motor_device: wh_controller, or wh_brushless, with its settings memory: wh_device of one motor.
//
//   bus -> wh_settings -> groups (wh_setting_group) -> wh_controller or wh_brushless -> pins
//
// LEGS = 3 is one brushless motor. Its axes alpha and beta, and the phases a and b whose current is measured,
// stand where other motors have 0 and 1; what there is once of it is at motor 0, and nowhere else. Of
// wh_controller's parameters it has WALLS, DELAY_LOG2, SENSE, ZERO_LOG2, DEAD_TIME, MIN_PULSE, ANCHOR and GUARD.
//
// Every word of rtl/words.toml is on the bus, as wh_settings has it. A setting takes effect with a commit:
// the core's between two steps, the anchors' and those that scale voltages from the same step on, gain and
// zero between two ticks' sums, walls between two rounds, all others with the bridges off only, while
// carrier and ADC begin anew. All words of a group change in one clock. A commit completes at every period
// (wh_settings), within three ticks where they are long enough for their work; a group that wasn't written is
// not waited for. With BUS = 1 the core's limit is the one of before for as long as wh_bus_scale takes.
//
// SENSE = 1: the zero of the currents is measured as wh_arm arms, with a rise of clear while the bridges are off,
// and by zero_start, which is refused while they are on.
//
// Nothing on the bus lets the bridges on where enable_i, a pin, is low. With ARM = 0 they are on where it
// is high, with ARM = 1 where the bus or press_i has armed them as well (wh_arm). They stay off while words
// that want them off are given, (PARTS + 1) 2^9 clocks or so.
// Live words are those of the clock in which they are read: two of them needn't be of one step. Those of
// one step, and of many after another, stand in what CAPTURE has them written to (wh_capture), and in what STREAM
// sends (wh_stream). A packet's number and its v are of one packet where they are read one after the other, less
// than 64 clocks apart.
//
// Latency: of the bus as wh_settings has it, of a command a clock more, of all else as the controller has it.
// Reset: that of the controller, which lasts until the settings are what the table says: 4 times 2^7
// clocks for each motor and for the board, rounded up to a power of two, and twice as many with a shaper.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_motor_device #(
    parameter integer N            = 1,  // these are wh_controller's
    parameter integer WALLS        = 4,
    parameter integer DELAY_LOG2   = 2,
    parameter integer ADC          = 0,
    parameter integer OSR          = 32,
    parameter integer CAPTURE_RISE = 0,
    parameter integer TRIP_OSR     = 8,
    parameter integer SENSE        = 0,
    parameter integer ZERO_LOG2    = 10,
    parameter integer SHAPER       = 0,
    parameter integer DEAD_TIME    = 1,
    parameter integer MODES        = 0,
    parameter integer MIN_PULSE    = 0,
    parameter integer BUS          = 0,
    parameter integer HOST         = 0,
    parameter integer ANCHOR       = 0,
    parameter integer SHARED       = 0,
    parameter integer GUARD        = 0,
    parameter integer ARM          = 0,  // 1: the bridges are on by command, while it is renewed, or by press_i
    parameter integer ARM_CLOCKS   = 4800000, // clocks that a command of either lasts, 2...2^30
    parameter integer CAPTURE      = 0,  // words that a capture takes, 2^this, 4...15; 0: there is none
    parameter integer STREAM       = 0,  // 1: with a stream
    parameter integer LEGS         = 2,  // half bridges of a motor: 2, wh_controller; 3, wh_brushless
    parameter integer PARTS        = (LEGS == 3) ? 2 : N  // derived, leave it: motors, or axes of one
) (
    input  wire                 clk,
    input  wire                 rst,
    input  wire                 enable_i,       // synchronous to clk

    // The bus (wh_settings).
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
    input  wire [N-1:0]         anchor_fault_i,
    input  wire                 clear_i,        // these two do what their words do, a rise of the first
    input  wire                 zero_start_i,
    input  wire                 press_i,        // strobe: arm, until something is against it; with ARM = 1

    output wire                 tick_o,         // strobe, last clock of a tick
    output wire                 running_o,      // the bridges are on
    output wire                 contact_o,      // any motor is in a wall
    output wire                 fault_o,        // the guard found something, or a tick is too short
    output wire                 fault_lasts_o,  // the same but for a zero, which arming measures anew
    output reg                  ready_o,        // since reset all settings were given
    output wire                 clear_o,        // strobe: the bus wants faults forgotten
    output wire [PARTS-1:0]     zero_busy_o,    // these are wh_controller's
    output wire [PARTS-1:0]     zero_fault_o,
    output wire [N-1:0]         anchor_fault_o,
    output wire [N-1:0]         encoder_fault_o,
    output wire [PARTS-1:0]     overcurrent_o,

    // A stream's packets (wh_stream).
    output wire                 stream_credit_o,
    output wire                 stream_valid_o,
    output wire                 stream_first_o,
    output wire [7:0]           stream_byte_o,
    output wire                 stream_packet_o,
    input  wire                 stream_room_i
);

    localparam integer SECTIONS = (SHAPER > 0) ? SHAPER : 1;
    localparam [`WH_FAULTS-1:0] ZERO = {{`WH_FAULTS-1{1'b0}}, 1'b1} << `WH_FAULT_ZERO;

    generate
        if (LEGS != 2 && LEGS != 3) begin : illegal_legs
            wh_illegal_parameter_device_legs_must_be_2_or_3 stop ();
        end
        if (ARM != 0 && ARM != 1) begin : illegal_arm
            wh_illegal_parameter_device_arm_must_be_0_or_1 stop ();
        end
        if (STREAM != 0 && STREAM != 1) begin : illegal_stream
            wh_illegal_parameter_device_stream_must_be_0_or_1 stop ();
        end
        if (LEGS == 3 && (N != 1 || ADC != 0 || SHAPER != 0 || MODES != 0 || BUS != 0
                          || HOST != 0 || SHARED != 0)) begin : illegal_of_brushless
            wh_illegal_parameter_device_with_three_legs_has_one_motor_and_a_serial_adc_alone stop ();
        end
    endgenerate

    wire        ready;
    wire        loading;
    wire        busy;
    wire        write;
    wire        copy;
    wire [11:0] address;
    wire [31:0] data;
    wire        change;
    wire        discard;
    wire        now;
    wire        changing;
    wire        command;
    reg         command_q;          // a clock late: the way from the bus to all that takes one is long
    reg  [11:0] command_address_q;
    reg  [`WH_DATA_W-1:0] command_data_q;
    reg  [32:0] live;
    reg  [31:0] live_q;

    genvar  n;
    genvar  k;
    integer m;

`define WH_DEVICE_BUS \
    .clk       (clk), \
    .rst       (rst), \
    .write_i   (write), \
    .copy_i    (copy), \
    .address_i (address), \
    .data_i    (data), \
    .change_i  (change), \
    .discard_i (discard),

    wire             hold_off;
    wire             hold_core;
    wire             hold_scale;
    wire [PARTS-1:0] hold_anchor;
    wire             hold_sum;
    wire             hold_round;
    wire             hold_any;
    wire             scale_hold;
    wire [PARTS-1:0] anchor_hold;

    wire       set_arm;
    wire       armed;
    wire       permitted = enable_i && armed && !loading;  // the bridges
    wire [4:0] arm_refused;
    wire       arm_zero_start;
    wire       clear_zero;  // strobe, a clear that begins with the bridges off

    reg  [31:0]    ticks;
    wire [PARTS*8-1:0] flags;
    wire           set_capture;
    wire           set_capture_offset;
    wire [31:0]    capture_data;
    wire [2:0]     capture_state;
    wire [15:0]    capture_count;
    wire [15:0]    capture_first;
    wire [15:0]    capture_left;
    wire           set_stream;
    wire [1:0]     stream_state;
    wire [15:0]    stream_lost;

    wire [PARTS*8-1:0]          seen_host_sequence;
    wire [PARTS*`WH_DATA_W-1:0] seen_host_v;

`include "wh_device_words.vh"

    // A step is made with the settings of one commit: an anchor's, and those that scale its voltages, wait
    // until the core's may change. That is before the step whose waves and voltages they are for.
    reg  passed_q;
    wire core_first = words_hold[0] && !passed_q;

    always @(posedge clk) begin
        passed_q <= change && (passed_q || !words_hold[0]);
    end

    // A clear measures the zero anew, once however long it lasts.
    reg  clears_q;
    wire clears = set_clear || clear_i;

    assign clear_zero = clears && !clears_q && !permitted;

    always @(posedge clk) begin
        clears_q <= rst || !ready || clears;
    end

    assign hold_off    = running;
    assign hold_core   = words_hold[0] && !now;
    assign hold_scale  = (scale_hold || core_first) && !now;
    assign hold_anchor = (anchor_hold | {PARTS{core_first}}) & {PARTS{!now}};
    assign hold_sum    = words_hold[2] && !now;
    assign hold_round  = words_hold[3] && !now;
    assign hold_any    = 1'b0;

    generate
        if (ARM != 0) begin : by_command
            wire [`WH_FAULTS-1:0] stops = faults & ~(set_guard[`WH_GUARD_DAMP] & `WH_FAULTS_DAMPABLE);

            wh_arm #(
                .SENSE        (SENSE),
                .CREDIT       (ARM_CLOCKS)
            ) arm (
                .clk          (clk),
                .rst          (rst || !ready),
                .enable_i     (enable_i),
                .fault_i      (overrun || (|(stops & ~ZERO))),
                .zero_i       (|(stops & ZERO)),
                .loading_i    (loading),
                .write_i      (set_arm),
                .value_i      (command_data_q[1:0]),
                .press_i      (press_i),
                .zero_start_o (arm_zero_start),
                .zero_busy_i  (|zero_busy),
                .zero_fault_i (|zero_fault),
                .armed_o      (armed),
                .refused_o    (arm_refused)
            );
        end else begin : by_pin
            wire unused = &{1'b0, set_arm, press_i};

            assign arm_zero_start = 1'b0;
            assign armed          = 1'b1;
            assign arm_refused    = 5'd0;
        end
    endgenerate

    // ---- The words of a tick, of which a capture (0) and a stream (1) choose theirs.
    wire        kept_strobe;
    wire [1:0]  kept_want;
    wire [1:0]  kept_take;
    wire [1:0]  kept_reads;
    wire [23:0] kept_code;
    wire [31:0] kept_word;
    wire        kept_mean;
    wire        kept_any;

    generate
        for (n = 0; n < PARTS; n = n + 1) begin : bits_of_motor
            assign flags[n*8 +: 8] = {host_active[n], anchor_fault[n], encoder_fault[n], adc_range[n],
                                      overcurrent[n], running, saturated[n], contact[n]};
        end

        if (CAPTURE != 0 || STREAM != 0) begin : keeps
            wh_tick_words #(
                .N            (PARTS)
            ) tick_words (
                .clk          (clk),
                .rst          (rst || !ready),
                .tick_i       (tick),
                .valid_i      (core_valid),
                .voltage_i    (voltage),
                .u_i          (u),
                .v_i          (v),
                .current_i    (current),
                .position_i   (position),
                .correction_i (correction),
                .offset_i     (offset),
                .flux_i       (flux),
                .lag_i        (lag),
                .flags_i      (flags),
                .bus_i        (bus_i),
                .faults_i     (faults),
                .want_i       (kept_want),
                .reads_i      (kept_reads),
                .code_i       (kept_code),
                .strobe_o     (kept_strobe),
                .take_o       (kept_take),
                .word_o       (kept_word),
                .mean_o       (kept_mean),
                .any_o        (kept_any)
            );
        end else begin : keeps_none
            assign kept_strobe = 1'b0;
            assign kept_take   = 2'b00;
            assign kept_word   = 32'd0;
            assign kept_mean   = 1'b0;
            assign kept_any    = 1'b0;
        end
    endgenerate

    wire unused_kept = &{1'b0, kept_strobe, kept_want, kept_take, kept_reads, kept_code, kept_word, kept_mean,
                         kept_any};

    generate
        if (CAPTURE != 0) begin : captures
            wh_capture #(
                .N              (PARTS),
                .DEPTH_LOG2     (CAPTURE)
            ) recorder (
                .clk            (clk),
                .rst            (rst || !ready),
                .strobe_i       (kept_strobe),
                .want_o         (kept_want[0]),
                .take_i         (kept_take[0]),
                .reads_o        (kept_reads[0]),
                .code_o         (kept_code[11:0]),
                .word_i         (kept_word),
                .mean_i         (kept_mean),
                .any_i          (kept_any),
                .contact_i      (contact),
                .fault_i        (fault_o),
                .channel_i      (set_capture_channel),
                .channels_i     (set_capture_channels),
                .rows_i         (set_capture_rows),
                .pre_i          (set_capture_pre),
                .decimation_i   (set_capture_decimation),
                .trigger_i      (set_capture_trigger),
                .level_i        (set_capture_level),
                .hold_i         (busy),
                .write_i        (set_capture),
                .write_offset_i (set_capture_offset),
                .data_i         (command_data_q[15:0]),
                .state_o        (capture_state),
                .count_o        (capture_count),
                .first_o        (capture_first),
                .left_o         (capture_left),
                .read_i         (bus_address_i[5:0]),
                .read_data_o    (capture_data)
            );
        end else begin : captures_nothing
            wire unused_capture = &{1'b0, set_capture_channel, set_capture_channels, set_capture_rows,
                                    set_capture_pre, set_capture_decimation, set_capture_trigger,
                                    set_capture_level, set_capture, set_capture_offset, busy};

            assign kept_want[0]    = 1'b0;
            assign kept_reads[0]   = 1'b0;
            assign kept_code[11:0] = 12'd0;
            assign capture_data  = 32'd0;
            assign capture_state = 3'd0;
            assign capture_count = 16'd0;
            assign capture_first = 16'd0;
            assign capture_left  = 16'd0;
        end
    endgenerate

    // ---- The packet that the bus shows: the newest, or the one before it while words of it are read. A
    // period is far longer than the frame that reads four words.
    generate
        if (HOST != 0) begin : shows_packets
            reg  [5:0] reading_q;  // clocks in which the frame's next word may come
            wire       reads = bus_valid_i && !bus_write_i && (bus_address_i[7:2] == 6'h29);

            always @(posedge clk) begin
                if (rst) begin
                    reading_q <= 6'd0;
                end else begin
                    reading_q <= reads ? 6'd63 : (reading_q == 6'd0) ? 6'd0 : reading_q - 6'd1;
                end
            end

            for (n = 0; n < PARTS; n = n + 1) begin : packet_of_motor
                reg [`WH_DATA_W+7:0] newest_q;
                reg [`WH_DATA_W+7:0] seen_q;

                always @(posedge clk) begin
                    if (rst) begin
                        newest_q <= {`WH_DATA_W+8{1'b0}};
                        seen_q   <= {`WH_DATA_W+8{1'b0}};
                    end else begin
                        if (host_strobe[n]) begin
                            newest_q <= {host_sequence[n*8 +: 8], host_v[n*`WH_DATA_W +: `WH_DATA_W]};
                        end
                        if (!reads && reading_q == 6'd0) begin
                            seen_q <= newest_q;
                        end
                    end
                end

                assign seen_host_sequence[n*8 +: 8]            = seen_q[`WH_DATA_W +: 8];
                assign seen_host_v[n*`WH_DATA_W +: `WH_DATA_W] = seen_q[`WH_DATA_W-1:0];
            end
        end else begin : shows_none
            assign seen_host_sequence = host_sequence;
            assign seen_host_v        = host_v;
        end
    endgenerate

    generate
        if (STREAM != 0) begin : streams
            wh_stream #(
                .CREDIT       (ARM_CLOCKS)
            ) stream (
                .clk          (clk),
                .rst          (rst || !ready),
                .strobe_i     (kept_strobe),
                .want_o       (kept_want[1]),
                .take_i       (kept_take[1]),
                .reads_o      (kept_reads[1]),
                .code_o       (kept_code[23:12]),
                .word_i       (kept_word),
                .mean_i       (kept_mean),
                .any_i        (kept_any),
                .channel_i    (set_stream_channel),
                .last_i       (set_stream_last),
                .shift_i      (set_stream_shift),
                .decimation_i (set_stream_decimation),
                .hold_i       (busy),
                .write_i      (set_stream),
                .data_i       (command_data_q[1:0]),
                .state_o      (stream_state),
                .lost_o       (stream_lost),
                .credit_o     (stream_credit_o),
                .room_i       (stream_room_i),
                .byte_valid_o (stream_valid_o),
                .byte_first_o (stream_first_o),
                .byte_o       (stream_byte_o),
                .packet_o     (stream_packet_o)
            );
        end else begin : streams_nothing
            wire unused_stream = &{1'b0, set_stream_channel, set_stream_last, set_stream_shift,
                                   set_stream_decimation, set_stream, stream_room_i};

            assign kept_want[1]     = 1'b0;
            assign kept_reads[1]    = 1'b0;
            assign kept_code[23:12] = 12'd0;
            assign stream_state    = 2'd0;
            assign stream_lost     = 16'd0;
            assign stream_credit_o = 1'b0;
            assign stream_valid_o  = 1'b0;
            assign stream_first_o  = 1'b0;
            assign stream_byte_o   = 8'd0;
            assign stream_packet_o = 1'b0;
        end
    endgenerate

    // One bit is for a word of the whole 32.
    wire unused = &{1'b0, live[32]};

    always @(posedge clk) begin
        command_q         <= !rst && command;
        command_address_q <= bus_address_i;
        command_data_q    <= bus_data_i[`WH_DATA_W-1:0];
    end

    always @(posedge clk) begin
        live_q  <= live[31:0];
        ready_o <= !rst && (ready_o || (ready && !loading));
        ticks   <= rst ? 32'd0 : ticks + {31'd0, tick};
    end

    wh_settings #(
        .N             (PARTS),
        .WALLS         (WALLS),
        .SHAPER        (SHAPER),
        .DELAY_LOG2    (DELAY_LOG2),
        .LEGS          (LEGS)
    ) settings (
        .clk           (clk),
        .rst           (rst),
        .bus_valid_i   (bus_valid_i),
        .bus_write_i   (bus_write_i),
        .bus_check_i   (bus_check_i),
        .bus_address_i (bus_address_i),
        .bus_data_i    (bus_data_i),
        .bus_ready_o   (bus_ready_o),
        .bus_data_o    (bus_data_o),
        .bus_error_o   (bus_error_o),
        .bus_signed_o  (bus_signed_o),
        .live_i        (live_q),
        .command_o     (command),
        .running_i     (running),
        .tick_i        (tick),
        .ready_o       (ready),
        .loading_o     (loading),
        .busy_o        (busy),
        .write_o       (write),
        .copy_o        (copy),
        .address_o     (address),
        .data_o        (data),
        .change_o      (change),
        .now_o         (now),
        .discard_o     (discard),
        .changing_i    (changing)
    );

    generate
        if (LEGS == 3) begin : brushless
            // What it tells once, both axes show.
            `WH_BRUSHLESS_ONCE

            assign anchor_hold[PARTS-1] = 1'b0;  // both axes' settings are at the first
            assign host_strobe   = {PARTS{1'b0}};
            assign host_sequence = {PARTS*8{1'b0}};
            assign host_v        = {PARTS*`WH_DATA_W{1'b0}};
            assign host_active   = {PARTS{1'b0}};
            assign contact_energy      = {PARTS*`WH_ENERGY_W{1'b0}};
            assign contact_energy_peak = {PARTS*`WH_ENERGY_W{1'b0}};
            assign adc_din_o     = 1'b0;

            wire [2*`WH_DATA_W-1:0] phase_current;
            wire unused_words = &{1'b0, phase_current, anchor_fault_i, `WH_BRUSHLESS_WITHOUT};

            wh_brushless #(
                .WALLS           (WALLS),
                .DELAY_LOG2      (DELAY_LOG2),
                .MIN_PULSE       (MIN_PULSE),
                .DEAD_TIME       (DEAD_TIME),
                .SENSE           (SENSE),
                .ZERO_LOG2       (ZERO_LOG2),
                .GUARD           (GUARD),
                .ANCHOR          (ANCHOR)
            ) controller (
                .clk             (clk),
                .rst             (rst || !ready),
                .enable_i        (permitted),
                .adc_cs_n_o      (adc_cs_n_o),
                .adc_sclk_o      (adc_sclk_o),
                .adc_sdata_i     (adc_sdata_i),
                .enc_a_i         (enc_a_i[0]),
                .enc_b_i         (enc_b_i[0]),
                .gate_high_o     ({gate_bh_o, gate_ah_o}),
                .gate_low_o      ({gate_bl_o, gate_al_o}),
                `WH_BRUSHLESS_PORTS
                .scale_hold_o    (scale_hold),
                .anchor_hold_o   (anchor_hold[0]),
                .shape_words_i   ({9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W{1'b0}}),
                .wall_shaped_i   ({WALLS{1'b0}}),
                .stop_i          (stop_i),
                .driver_fault_i  (driver_fault_i[0]),
                .phase_current_o (phase_current)
            );
        end else begin : of_motors
            wire unused_words = &{1'b0, `WH_DEVICE_WITHOUT};

            assign magnet_found = 1'b0;
            assign magnet_angle = 32'd0;

            wh_controller #(
                .N              (N),
                .WALLS          (WALLS),
                .DELAY_LOG2     (DELAY_LOG2),
                .ADC            (ADC),
                .OSR            (OSR),
                .CAPTURE_RISE   (CAPTURE_RISE),
                .TRIP_OSR       (TRIP_OSR),
                .SENSE          (SENSE),
                .ZERO_LOG2      (ZERO_LOG2),
                .SHAPER         (SHAPER),
                .DEAD_TIME      (DEAD_TIME),
                .MODES          (MODES),
                .MIN_PULSE      (MIN_PULSE),
                .BUS            (BUS),
                .HOST           (HOST),
                .ANCHOR         (ANCHOR),
                .SHARED         (SHARED),
                .GUARD          (GUARD)
            ) controller (
                .clk            (clk),
                .rst            (rst || !ready),
                .enable_i       (permitted),
                .adc_cs_n_o     (adc_cs_n_o),
                .adc_sclk_o     (adc_sclk_o),
                .adc_din_o      (adc_din_o),
                .adc_sdata_i    (adc_sdata_i),
                .enc_a_i        (enc_a_i),
                .enc_b_i        (enc_b_i),
                .gate_ah_o      (gate_ah_o),
                .gate_al_o      (gate_al_o),
                .gate_bh_o      (gate_bh_o),
                .gate_bl_o      (gate_bl_o),
                `WH_DEVICE_PORTS
                .scale_hold_o   (scale_hold),
                .anchor_hold_o  (anchor_hold),
                .stop_i         (stop_i),
                .driver_fault_i (driver_fault_i),
                .anchor_fault_i (anchor_fault_i)
            );
        end
    endgenerate

    assign tick_o    = tick;
    assign running_o = running;
    assign contact_o = |contact;
    assign fault_o   = overrun || |faults;
    assign fault_lasts_o = overrun || |(faults & ~ZERO);
    assign clear_o   = set_clear;

    assign zero_busy_o     = zero_busy;
    assign zero_fault_o    = zero_fault;
    assign anchor_fault_o  = anchor_fault[N-1:0];
    assign encoder_fault_o = encoder_fault[N-1:0];
    assign overcurrent_o   = overcurrent;

endmodule

`undef WH_DEVICE_BUS
`undef WH_DEVICE_PORTS
`undef WH_DEVICE_WITHOUT
`undef WH_BRUSHLESS_PORTS
`undef WH_BRUSHLESS_WITHOUT
`undef WH_BRUSHLESS_ONCE

`default_nettype wire
