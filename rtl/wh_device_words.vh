// SPDX-License-Identifier: Apache-2.0
//
// wh_device_words: the groups of settings, the commands and the live words of wh_device, in which this
// stands. It is made from words.toml.
//
// <!-- begin device-words -->
// Settings and commands, on their way to the controller and beside it.

wire [15:0] set_half_clocks;
wire [15:0] set_tick_halves;
wire [15:0] set_sample_clocks;
wire [8:0] set_samples;
wire [7:0] set_sample_lead;
wire [0:0] set_sample_late;
wire [7:0] set_sclk_half_clocks;
wire [5:0] set_frame_bits;
wire [5:0] set_lead_bits;
wire [4:0] set_data_bits;
wire [7:0] set_quiet_clocks;
wire [7:0] set_setup_clocks;
wire [7:0] set_hold_clocks;
wire [5:0] set_calibrate_bits;
wire [0:0] set_sclk_idle;
wire [0:0] set_read_trailing;
wire [15:0] set_trip;
wire [15:0] set_range;
wire [15:0] set_stuck_words;
wire [22:0] set_zero_limit;
wire [0:0] set_zero_start;
wire [3:0] set_filter_clocks;
wire [31:0] set_count_angle;
wire [31:0] set_zero_angle;
wire [0:0] set_find_magnet;
wire [0:0] set_magnet_start;
wire [3:0] set_host_period_log2;
wire [7:0] set_host_timeout;
wire [PARTS*8-1:0] set_host_sequence;
wire [PARTS*`WH_DATA_W-1:0] set_host_u;
wire [PARTS-1:0] set_host_strobe;
wire [DELAY_LOG2-1:0] set_extra_ticks;
wire [DELAY_LOG2-1:0] set_hold_ticks;
wire [PARTS*`WH_COEF_W-1:0] set_eta_contact;
wire [PARTS*`WH_COEF_W-1:0] set_eta_free;
wire [PARTS*`WH_COEF_W-1:0] set_root;
wire [PARTS*`WH_COEF_W-1:0] set_a;
wire [PARTS*`WH_DATA_W-1:0] set_u_max;
wire [1:0] set_mode;
wire [7:0] set_min_pulse;
wire [7:0] set_dead_clocks;
wire [0:0] set_compensate;
wire [7:0] set_settle_ticks;
wire [0:0] set_second_order;
wire [`WH_COEF_W-1:0] set_bus_share;
wire [281:0] set_guard;
wire [0:0] set_clear;
wire [0:0] set_host_alive;
wire [0:0] set_restart;
wire [PARTS*24-1:0] set_zero;
wire [PARTS*`WH_COEF_W-1:0] set_gain;
wire [PARTS*`WH_COEF_W-1:0] set_clocks_per_volt;
wire [PARTS*`WH_DATA_W-1:0] set_side_current;
wire [PARTS*(8*`WH_COEF_W + 3*`WH_DATA_W + 33)-1:0] set_anchor_words;
wire [PARTS-1:0] set_edge_hysteresis;
wire [PARTS*WALLS*`WH_COUNT_W-1:0] set_wall_min;
wire [PARTS*WALLS*`WH_COUNT_W-1:0] set_wall_max;
wire [PARTS*WALLS-1:0] set_wall_enable;
wire [PARTS*WALLS-1:0] set_wall_shaped;
wire [PARTS*SECTIONS*(9*`WH_SHAPE_W + 36)-1:0] set_shape_words;
wire [95:0] set_capture_channel;
wire [3:0] set_capture_channels;
wire [15:0] set_capture_rows;
wire [15:0] set_capture_pre;
wire [3:0] set_capture_decimation;
wire [2:0] set_capture_trigger;
wire [31:0] set_capture_level;
wire [47:0] set_stream_channel;
wire [1:0] set_stream_last;
wire [3:0] set_stream_decimation;
wire [15:0] set_stream_shift;
wire [31:0] set_surface_budget;

// Widths that a tool or the hardware sets.

localparam [7:0] DATA_W_8 = `WH_DATA_W;
localparam [7:0] DELAY_LOG2_8 = DELAY_LOG2[7:0];
localparam [7:0] COEF_W_8 = `WH_COEF_W;
localparam [7:0] COUNT_W_8 = `WH_COUNT_W;
localparam [7:0] SHAPE_W_8 = `WH_SHAPE_W;

// What the controller tells.

wire [PARTS-1:0] overcurrent;
wire [PARTS-1:0] adc_range;
wire [PARTS-1:0] adc_stuck;
wire [PARTS-1:0] zero_fault;
wire [PARTS-1:0] zero_busy;
wire [PARTS-1:0] encoder_fault;
wire [0:0] magnet_found;
wire [31:0] magnet_angle;
wire [PARTS-1:0] host_strobe;
wire [PARTS*8-1:0] host_sequence;
wire [PARTS*`WH_DATA_W-1:0] host_v;
wire [PARTS-1:0] host_active;
wire [PARTS*`WH_DATA_W-1:0] voltage;
wire [PARTS*`WH_DATA_W-1:0] u;
wire [PARTS*`WH_DATA_W-1:0] v;
wire [PARTS*`WH_DATA_W-1:0] current;
wire [PARTS*`WH_COUNT_W-1:0] position;
wire [PARTS-1:0] contact;
wire [PARTS-1:0] saturated;
wire [PARTS-1:0] clipped;
wire [23:0] faults;
wire [0:0] running;
wire [0:0] adc_ready;
wire [0:0] tick;
wire [0:0] core_valid;
wire [0:0] overrun;
wire [3:0] words_hold;
wire [PARTS*`WH_DATA_W-1:0] correction;
wire [PARTS*`WH_DATA_W-1:0] offset;
wire [PARTS*`WH_DATA_W-1:0] flux;
wire [PARTS*`WH_DATA_W-1:0] lag;
wire [PARTS-1:0] anchor_fault;
wire [PARTS*24-1:0] contact_energy;
wire [PARTS*24-1:0] contact_energy_peak;
wire [3:0] surfaces = 4'd0;
wire [1:0] surfaces_acting = 2'd0;
wire [0:0] surfaces_pending = 1'd0;
wire [7:0] surfaces_refused = 8'd0;
wire [15:0] surfaces_stamp = 16'd0;
wire unused_others = &{1'b0, set_surface_budget};

// The groups.

wire pending_carrier;
wire [65:0] carrier_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h00),
    .STRIDE    (8'd1),
    .WORDS     (6),
    .WIDTHS    ({8'd1, 8'd8, 8'd9, 8'd16, 8'd16, 8'd16}),
    .TOTAL_W   (66)
) carrier (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_carrier),
    .words_o   (carrier_words)
);

assign set_half_clocks[0 +: 16] = carrier_words[0 +: 16];
assign set_tick_halves[0 +: 16] = carrier_words[16 +: 16];
assign set_sample_clocks[0 +: 16] = carrier_words[32 +: 16];
assign set_samples[0 +: 9] = carrier_words[48 +: 9];
assign set_sample_lead[0 +: 8] = carrier_words[57 +: 8];
assign set_sample_late[0 +: 1] = carrier_words[65 +: 1];

wire pending_frame;
wire [56:0] frame_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h08),
    .STRIDE    (8'd1),
    .WORDS     (10),
    .WIDTHS    ({8'd1, 8'd1, 8'd6, 8'd8, 8'd8, 8'd8, 8'd5, 8'd6, 8'd6, 8'd8}),
    .TOTAL_W   (57)
) frame (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_frame),
    .words_o   (frame_words)
);

assign set_sclk_half_clocks[0 +: 8] = frame_words[0 +: 8];
assign set_frame_bits[0 +: 6] = frame_words[8 +: 6];
assign set_lead_bits[0 +: 6] = frame_words[14 +: 6];
assign set_data_bits[0 +: 5] = frame_words[20 +: 5];
assign set_quiet_clocks[0 +: 8] = frame_words[25 +: 8];
assign set_setup_clocks[0 +: 8] = frame_words[33 +: 8];
assign set_hold_clocks[0 +: 8] = frame_words[41 +: 8];
assign set_calibrate_bits[0 +: 6] = frame_words[49 +: 6];
assign set_sclk_idle[0 +: 1] = frame_words[55 +: 1];
assign set_read_trailing[0 +: 1] = frame_words[56 +: 1];

wire pending_trip;
wire [15:0] trip_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h18),
    .STRIDE    (8'd1),
    .WORDS     (1),
    .WIDTHS    ({8'd16}),
    .TOTAL_W   (16)
) trip (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_trip),
    .words_o   (trip_words)
);

assign set_trip[0 +: 16] = trip_words[0 +: 16];

wire pending_sense;
wire [31:0] sense_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h1a),
    .STRIDE    (8'd1),
    .WORDS     (2),
    .WIDTHS    ({8'd16, 8'd16}),
    .TOTAL_W   (32)
) sense (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_sense),
    .words_o   (sense_words)
);

assign set_range[0 +: 16] = sense_words[0 +: 16];
assign set_stuck_words[0 +: 16] = sense_words[16 +: 16];

wire pending_zero;
wire [22:0] zero_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h1c),
    .STRIDE    (8'd1),
    .WORDS     (1),
    .WIDTHS    ({8'd23}),
    .TOTAL_W   (23)
) zero (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_zero),
    .words_o   (zero_words)
);

assign set_zero_limit[0 +: 23] = zero_words[0 +: 23];

wire pending_encoder;
wire [3:0] encoder_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h20),
    .STRIDE    (8'd1),
    .WORDS     (1),
    .WIDTHS    ({8'd4}),
    .TOTAL_W   (4)
) encoder (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_encoder),
    .words_o   (encoder_words)
);

assign set_filter_clocks[0 +: 4] = encoder_words[0 +: 4];

wire pending_magnet;
wire [64:0] magnet_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h21),
    .STRIDE    (8'd1),
    .WORDS     (3),
    .WIDTHS    ({8'd1, 8'd32, 8'd32}),
    .TOTAL_W   (65)
) magnet (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_magnet),
    .words_o   (magnet_words)
);

assign set_count_angle[0 +: 32] = magnet_words[0 +: 32];
assign set_zero_angle[0 +: 32] = magnet_words[32 +: 32];
assign set_find_magnet[0 +: 1] = magnet_words[64 +: 1];

wire pending_host;
wire [11:0] host_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h24),
    .STRIDE    (8'd1),
    .WORDS     (2),
    .WIDTHS    ({8'd8, 8'd4}),
    .TOTAL_W   (12)
) host (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_host),
    .words_o   (host_words)
);

assign set_host_period_log2[0 +: 4] = host_words[0 +: 4];
assign set_host_timeout[0 +: 8] = host_words[4 +: 8];

wire pending_delay;
wire [2*DELAY_LOG2-1:0] delay_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h28),
    .STRIDE    (8'd1),
    .WORDS     (2),
    .WIDTHS    ({DELAY_LOG2_8, DELAY_LOG2_8}),
    .TOTAL_W   (2*DELAY_LOG2)
) delay (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_delay),
    .words_o   (delay_words)
);

assign set_extra_ticks[0 +: DELAY_LOG2] = delay_words[0 +: DELAY_LOG2];
assign set_hold_ticks[0 +: DELAY_LOG2] = delay_words[DELAY_LOG2 +: DELAY_LOG2];

wire [PARTS-1:0] pending_eta;
generate
    for (n = 0; n < PARTS; n = n + 1) begin : eta_of_motor
        localparam [31:0] PART = n + 1;
        wire [2*`WH_COEF_W-1:0] eta_words;

        wh_setting_group #(
            .STAGED    (1),
            .PART      (PART[3:0]),
            .FIRST     (8'h08),
            .STRIDE    (8'd1),
            .WORDS     (2),
            .WIDTHS    ({COEF_W_8, COEF_W_8}),
            .TOTAL_W   (2*`WH_COEF_W)
        ) eta (
            `WH_DEVICE_BUS
            .hold_i    (hold_core),
            .pending_o (pending_eta[n]),
            .words_o   (eta_words)
        );

        assign set_eta_contact[n*`WH_COEF_W +: `WH_COEF_W] = eta_words[0 +: `WH_COEF_W];
        assign set_eta_free[n*`WH_COEF_W +: `WH_COEF_W] = eta_words[`WH_COEF_W +: `WH_COEF_W];
    end
endgenerate

wire [PARTS-1:0] pending_wave;
generate
    for (n = 0; n < PARTS; n = n + 1) begin : wave_of_motor
        localparam [31:0] PART = n + 1;
        wire [2*`WH_COEF_W + `WH_DATA_W-1:0] wave_words;

        wh_setting_group #(
            .STAGED    (1),
            .PART      (PART[3:0]),
            .FIRST     (8'h10),
            .STRIDE    (8'd1),
            .WORDS     (3),
            .WIDTHS    ({DATA_W_8, COEF_W_8, COEF_W_8}),
            .TOTAL_W   (2*`WH_COEF_W + `WH_DATA_W)
        ) wave (
            `WH_DEVICE_BUS
            .hold_i    (hold_core),
            .pending_o (pending_wave[n]),
            .words_o   (wave_words)
        );

        assign set_root[n*`WH_COEF_W +: `WH_COEF_W] = wave_words[0 +: `WH_COEF_W];
        assign set_a[n*`WH_COEF_W +: `WH_COEF_W] = wave_words[`WH_COEF_W +: `WH_COEF_W];
        assign set_u_max[n*`WH_DATA_W +: `WH_DATA_W] = wave_words[2*`WH_COEF_W +: `WH_DATA_W];
    end
endgenerate

wire pending_bridge;
wire [27:0] bridge_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h30),
    .STRIDE    (8'd1),
    .WORDS     (6),
    .WIDTHS    ({8'd1, 8'd8, 8'd1, 8'd8, 8'd8, 8'd2}),
    .TOTAL_W   (28)
) bridge (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_bridge),
    .words_o   (bridge_words)
);

assign set_mode[0 +: 2] = bridge_words[0 +: 2];
assign set_min_pulse[0 +: 8] = bridge_words[2 +: 8];
assign set_dead_clocks[0 +: 8] = bridge_words[10 +: 8];
assign set_compensate[0 +: 1] = bridge_words[18 +: 1];
assign set_settle_ticks[0 +: 8] = bridge_words[19 +: 8];
assign set_second_order[0 +: 1] = bridge_words[27 +: 1];

wire pending_bus;
wire [`WH_COEF_W-1:0] bus_words;

wh_setting_group #(
    .STAGED    (1),
    .PART      (4'd0),
    .FIRST     (8'h38),
    .STRIDE    (8'd1),
    .WORDS     (1),
    .WIDTHS    ({COEF_W_8}),
    .TOTAL_W   (`WH_COEF_W)
) bus (
    `WH_DEVICE_BUS
    .hold_i    (hold_core),
    .pending_o (pending_bus),
    .words_o   (bus_words)
);

assign set_bus_share[0 +: `WH_COEF_W] = bus_words[0 +: `WH_COEF_W];

wire pending_guard;
wire [281:0] guard_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h40),
    .STRIDE    (8'd1),
    .WORDS     (16),
    .WIDTHS    ({8'd16, 8'd32, 8'd16, 8'd16, 8'd16, 8'd24, 8'd16, 8'd16, 8'd16, 8'd16, 8'd16, 8'd16, 8'd16, 8'd2, 8'd24, 8'd24}),
    .TOTAL_W   (282)
) guard (
    `WH_DEVICE_BUS
    .hold_i    (hold_off),
    .pending_o (pending_guard),
    .words_o   (guard_words)
);

assign set_guard[0 +: 24] = guard_words[0 +: 24];
assign set_guard[24 +: 24] = guard_words[24 +: 24];
assign set_guard[48 +: 2] = guard_words[48 +: 2];
assign set_guard[50 +: 16] = guard_words[50 +: 16];
assign set_guard[66 +: 16] = guard_words[66 +: 16];
assign set_guard[82 +: 16] = guard_words[82 +: 16];
assign set_guard[98 +: 16] = guard_words[98 +: 16];
assign set_guard[114 +: 16] = guard_words[114 +: 16];
assign set_guard[130 +: 16] = guard_words[130 +: 16];
assign set_guard[146 +: 16] = guard_words[146 +: 16];
assign set_guard[162 +: 24] = guard_words[162 +: 24];
assign set_guard[186 +: 16] = guard_words[186 +: 16];
assign set_guard[202 +: 16] = guard_words[202 +: 16];
assign set_guard[218 +: 16] = guard_words[218 +: 16];
assign set_guard[234 +: 32] = guard_words[234 +: 32];
assign set_guard[266 +: 16] = guard_words[266 +: 16];

wire pending_capture;
wire [170:0] capture_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h50),
    .STRIDE    (8'd1),
    .WORDS     (14),
    .WIDTHS    ({8'd32, 8'd3, 8'd4, 8'd16, 8'd16, 8'd4, 8'd12, 8'd12, 8'd12, 8'd12, 8'd12, 8'd12, 8'd12, 8'd12}),
    .TOTAL_W   (171)
) capture (
    `WH_DEVICE_BUS
    .hold_i    (hold_any),
    .pending_o (pending_capture),
    .words_o   (capture_words)
);

assign set_capture_channel[0 +: 96] = capture_words[0 +: 96];
assign set_capture_channels[0 +: 4] = capture_words[96 +: 4];
assign set_capture_rows[0 +: 16] = capture_words[100 +: 16];
assign set_capture_pre[0 +: 16] = capture_words[116 +: 16];
assign set_capture_decimation[0 +: 4] = capture_words[132 +: 4];
assign set_capture_trigger[0 +: 3] = capture_words[136 +: 3];
assign set_capture_level[0 +: 32] = capture_words[139 +: 32];

wire pending_stream;
wire [53:0] stream_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h2a),
    .STRIDE    (8'd1),
    .WORDS     (6),
    .WIDTHS    ({8'd4, 8'd2, 8'd12, 8'd12, 8'd12, 8'd12}),
    .TOTAL_W   (54)
) stream (
    `WH_DEVICE_BUS
    .hold_i    (hold_any),
    .pending_o (pending_stream),
    .words_o   (stream_words)
);

assign set_stream_channel[0 +: 48] = stream_words[0 +: 48];
assign set_stream_last[0 +: 2] = stream_words[48 +: 2];
assign set_stream_decimation[0 +: 4] = stream_words[50 +: 4];

wire pending_cut;
wire [15:0] cut_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h3a),
    .STRIDE    (8'd1),
    .WORDS     (4),
    .WIDTHS    ({8'd4, 8'd4, 8'd4, 8'd4}),
    .TOTAL_W   (16)
) cut (
    `WH_DEVICE_BUS
    .hold_i    (hold_any),
    .pending_o (pending_cut),
    .words_o   (cut_words)
);

assign set_stream_shift[0 +: 16] = cut_words[0 +: 16];

wire [PARTS-1:0] pending_current;
generate
    for (n = 0; n < PARTS; n = n + 1) begin : current_of_motor
        localparam [31:0] PART = n + 1;
        wire [`WH_COEF_W + 24-1:0] current_words;

        wh_setting_group #(
            .STAGED    (1),
            .PART      (PART[3:0]),
            .FIRST     (8'h00),
            .STRIDE    (8'd1),
            .WORDS     (2),
            .WIDTHS    ({COEF_W_8, 8'd24}),
            .TOTAL_W   (`WH_COEF_W + 24)
        ) current (
            `WH_DEVICE_BUS
            .hold_i    (hold_sum),
            .pending_o (pending_current[n]),
            .words_o   (current_words)
        );

        assign set_zero[n*24 +: 24] = current_words[0 +: 24];
        assign set_gain[n*`WH_COEF_W +: `WH_COEF_W] = current_words[24 +: `WH_COEF_W];
    end
endgenerate

wire [PARTS-1:0] pending_scale;
generate
    for (n = 0; n < PARTS; n = n + 1) begin : scale_of_motor
        localparam [31:0] PART = n + 1;
        wire [`WH_COEF_W-1:0] scale_words;

        wh_setting_group #(
            .STAGED    (1),
            .PART      (PART[3:0]),
            .FIRST     (8'h18),
            .STRIDE    (8'd1),
            .WORDS     (1),
            .WIDTHS    ({COEF_W_8}),
            .TOTAL_W   (`WH_COEF_W)
        ) scale (
            `WH_DEVICE_BUS
            .hold_i    (hold_scale),
            .pending_o (pending_scale[n]),
            .words_o   (scale_words)
        );

        assign set_clocks_per_volt[n*`WH_COEF_W +: `WH_COEF_W] = scale_words[0 +: `WH_COEF_W];
    end
endgenerate

wire [PARTS-1:0] pending_side;
generate
    for (n = 0; n < PARTS; n = n + 1) begin : side_of_motor
        localparam [31:0] PART = n + 1;
        wire [`WH_DATA_W-1:0] side_words;

        wh_setting_group #(
            .STAGED    (1),
            .PART      (PART[3:0]),
            .FIRST     (8'h1a),
            .STRIDE    (8'd1),
            .WORDS     (1),
            .WIDTHS    ({DATA_W_8}),
            .TOTAL_W   (`WH_DATA_W)
        ) side (
            `WH_DEVICE_BUS
            .hold_i    (hold_core),
            .pending_o (pending_side[n]),
            .words_o   (side_words)
        );

        assign set_side_current[n*`WH_DATA_W +: `WH_DATA_W] = side_words[0 +: `WH_DATA_W];
    end
endgenerate

wire [PARTS-1:0] pending_anchor;
generate
    for (n = 0; n < PARTS; n = n + 1) begin : anchor_of_motor
        localparam [31:0] PART = n + 1;
        wire [8*`WH_COEF_W + 3*`WH_DATA_W + 33-1:0] anchor_words;

        wh_setting_group #(
            .STAGED    (1),
            .PART      (PART[3:0]),
            .FIRST     (8'h20),
            .STRIDE    (8'd1),
            .WORDS     (14),
            .WIDTHS    ({8'd20, 8'd12, DATA_W_8, DATA_W_8, DATA_W_8, COEF_W_8, COEF_W_8, COEF_W_8, COEF_W_8, COEF_W_8, COEF_W_8, COEF_W_8, COEF_W_8, 8'd1}),
            .TOTAL_W   (8*`WH_COEF_W + 3*`WH_DATA_W + 33)
        ) anchor (
            `WH_DEVICE_BUS
            .hold_i    (hold_anchor[n]),
            .pending_o (pending_anchor[n]),
            .words_o   (anchor_words)
        );

        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) +: 1] = anchor_words[0 +: 1];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 1 +: `WH_COEF_W] = anchor_words[1 +: `WH_COEF_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + `WH_COEF_W + 1 +: `WH_COEF_W] = anchor_words[`WH_COEF_W + 1 +: `WH_COEF_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 2*`WH_COEF_W + 1 +: `WH_COEF_W] = anchor_words[2*`WH_COEF_W + 1 +: `WH_COEF_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 3*`WH_COEF_W + 1 +: `WH_COEF_W] = anchor_words[3*`WH_COEF_W + 1 +: `WH_COEF_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 4*`WH_COEF_W + 1 +: `WH_COEF_W] = anchor_words[4*`WH_COEF_W + 1 +: `WH_COEF_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 5*`WH_COEF_W + 1 +: `WH_COEF_W] = anchor_words[5*`WH_COEF_W + 1 +: `WH_COEF_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 6*`WH_COEF_W + 1 +: `WH_COEF_W] = anchor_words[6*`WH_COEF_W + 1 +: `WH_COEF_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 7*`WH_COEF_W + 1 +: `WH_COEF_W] = anchor_words[7*`WH_COEF_W + 1 +: `WH_COEF_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 8*`WH_COEF_W + 1 +: `WH_DATA_W] = anchor_words[8*`WH_COEF_W + 1 +: `WH_DATA_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 8*`WH_COEF_W + `WH_DATA_W + 1 +: `WH_DATA_W] = anchor_words[8*`WH_COEF_W + `WH_DATA_W + 1 +: `WH_DATA_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 8*`WH_COEF_W + 2*`WH_DATA_W + 1 +: `WH_DATA_W] = anchor_words[8*`WH_COEF_W + 2*`WH_DATA_W + 1 +: `WH_DATA_W];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 8*`WH_COEF_W + 3*`WH_DATA_W + 1 +: 12] = anchor_words[8*`WH_COEF_W + 3*`WH_DATA_W + 1 +: 12];
        assign set_anchor_words[n*(8*`WH_COEF_W + 3*`WH_DATA_W + 33) + 8*`WH_COEF_W + 3*`WH_DATA_W + 13 +: 20] = anchor_words[8*`WH_COEF_W + 3*`WH_DATA_W + 13 +: 20];
    end
endgenerate

wire [PARTS-1:0] pending_edges;
generate
    for (n = 0; n < PARTS; n = n + 1) begin : edges_of_motor
        localparam [31:0] PART = n + 1;
        wire [0:0] edges_words;

        wh_setting_group #(
            .STAGED    (1),
            .PART      (PART[3:0]),
            .FIRST     (8'h30),
            .STRIDE    (8'd1),
            .WORDS     (1),
            .WIDTHS    ({8'd1}),
            .TOTAL_W   (1)
        ) edges (
            `WH_DEVICE_BUS
            .hold_i    (hold_round),
            .pending_o (pending_edges[n]),
            .words_o   (edges_words)
        );

        assign set_edge_hysteresis[n +: 1] = edges_words[0 +: 1];
    end
endgenerate

wire [PARTS*WALLS-1:0] pending_walls;
generate
    for (n = 0; n < PARTS; n = n + 1) begin : walls_of_motor
        localparam [31:0] PART = n + 1;
        for (k = 0; k < WALLS; k = k + 1) begin : each_copy
            localparam [31:0] K = k;
            wire [2*`WH_COUNT_W + 2-1:0] walls_words;

            wh_setting_group #(
                .STAGED    (1),
                .PART      (PART[3:0]),
                .FIRST     (8'h40 + K[7:0]),
                .STRIDE    (8'd16),
                .WORDS     (4),
                .WIDTHS    ({8'd1, 8'd1, COUNT_W_8, COUNT_W_8}),
                .TOTAL_W   (2*`WH_COUNT_W + 2)
            ) walls (
                `WH_DEVICE_BUS
                .hold_i    (hold_round),
                .pending_o (pending_walls[n*WALLS + k]),
                .words_o   (walls_words)
            );

            assign set_wall_min[(n*WALLS + k)*`WH_COUNT_W +: `WH_COUNT_W] = walls_words[0 +: `WH_COUNT_W];
            assign set_wall_max[(n*WALLS + k)*`WH_COUNT_W +: `WH_COUNT_W] = walls_words[`WH_COUNT_W +: `WH_COUNT_W];
            assign set_wall_enable[(n*WALLS + k) +: 1] = walls_words[2*`WH_COUNT_W +: 1];
            assign set_wall_shaped[(n*WALLS + k) +: 1] = walls_words[2*`WH_COUNT_W + 1 +: 1];
        end
    end
endgenerate

wire [PARTS*SECTIONS-1:0] pending_shape;
generate
    for (n = 0; n < PARTS; n = n + 1) begin : shape_of_motor
        localparam [31:0] PART = n + 1;
        for (k = 0; k < SECTIONS; k = k + 1) begin : each_copy
            localparam [31:0] K = k;
            wire [9*`WH_SHAPE_W-1:0] shape_words;

            wh_setting_group #(
                .STAGED    (1),
                .PART      (PART[3:0]),
                .FIRST     (8'h80 + 8'd9 * K[7:0]),
                .STRIDE    (8'd1),
                .WORDS     (9),
                .WIDTHS    ({SHAPE_W_8, SHAPE_W_8, SHAPE_W_8, SHAPE_W_8, SHAPE_W_8, SHAPE_W_8, SHAPE_W_8, SHAPE_W_8, SHAPE_W_8}),
                .TOTAL_W   (9*`WH_SHAPE_W)
            ) shape (
                `WH_DEVICE_BUS
                .hold_i    (hold_core),
                .pending_o (pending_shape[n*SECTIONS + k]),
                .words_o   (shape_words)
            );

            assign set_shape_words[(n*SECTIONS + k)*(9*`WH_SHAPE_W + 36) +: 9*`WH_SHAPE_W] = shape_words[0 +: 9*`WH_SHAPE_W];
        end
    end
endgenerate

wire [PARTS*SECTIONS-1:0] pending_shape_1;
generate
    for (n = 0; n < PARTS; n = n + 1) begin : shape_1_of_motor
        localparam [31:0] PART = n + 1;
        for (k = 0; k < SECTIONS; k = k + 1) begin : each_copy
            localparam [31:0] K = k;
            wire [35:0] shape_1_words;

            wh_setting_group #(
                .STAGED    (1),
                .PART      (PART[3:0]),
                .FIRST     (8'h92 + 8'd3 * K[7:0]),
                .STRIDE    (8'd1),
                .WORDS     (3),
                .WIDTHS    ({8'd12, 8'd12, 8'd12}),
                .TOTAL_W   (36)
            ) shape_1 (
                `WH_DEVICE_BUS
                .hold_i    (hold_core),
                .pending_o (pending_shape_1[n*SECTIONS + k]),
                .words_o   (shape_1_words)
            );

            assign set_shape_words[(n*SECTIONS + k)*(9*`WH_SHAPE_W + 36) + 9*`WH_SHAPE_W +: 36] = shape_1_words[0 +: 36];
        end
    end
endgenerate

wire pending_budget;
wire [31:0] budget_words;

wh_setting_group #(
    .STAGED    (0),
    .PART      (4'd0),
    .FIRST     (8'h5e),
    .STRIDE    (8'd1),
    .WORDS     (1),
    .WIDTHS    ({8'd32}),
    .TOTAL_W   (32)
) budget (
    `WH_DEVICE_BUS
    .hold_i    (hold_any),
    .pending_o (pending_budget),
    .words_o   (budget_words)
);

assign set_surface_budget[0 +: 32] = budget_words[0 +: 32];

assign changing = (|pending_carrier) || (|pending_frame) || (|pending_trip) || (|pending_sense) || (|pending_zero) || (|pending_encoder) || (|pending_magnet) || (|pending_host) || (|pending_delay) || (|pending_eta) || (|pending_wave) || (|pending_bridge) || (|pending_bus) || (|pending_guard) || (|pending_capture) || (|pending_stream) || (|pending_cut) || (|pending_current) || (|pending_scale) || (|pending_side) || (|pending_anchor) || (|pending_edges) || (|pending_walls) || (|pending_shape) || (|pending_shape_1) || (|pending_budget);

// Commands.

assign set_zero_start = command_q && command_address_q == 12'h01d && command_data_q[0];
assign set_magnet_start = command_q && command_address_q == 12'h065 && command_data_q[0];
generate
    for (n = 0; n < PARTS; n = n + 1) begin : host_answer_sequence_of_motor
        localparam [31:0] PART = n + 1;

        reg [7:0] word_q;

        always @(posedge clk) begin
            if (command_q && command_address_q == {PART[3:0], 8'ha1}) begin
                word_q <= command_data_q[7:0];
            end
        end

        assign set_host_sequence[n*8 +: 8] = word_q;
    end
endgenerate
generate
    for (n = 0; n < PARTS; n = n + 1) begin : host_u_of_motor
        localparam [31:0] PART = n + 1;

        reg [`WH_DATA_W-1:0] word_q;

        always @(posedge clk) begin
            if (command_q && command_address_q == {PART[3:0], 8'ha2}) begin
                word_q <= command_data_q[`WH_DATA_W-1:0];
            end
        end

        assign set_host_u[n*`WH_DATA_W +: `WH_DATA_W] = word_q;
    end
endgenerate
generate
    for (n = 0; n < PARTS; n = n + 1) begin : host_answer_of_motor
        localparam [31:0] PART = n + 1;

        assign set_host_strobe[n] = command_q && command_address_q == {PART[3:0], 8'ha3} && command_data_q[0];
    end
endgenerate
assign set_clear = command_q && command_address_q == 12'h060 && command_data_q[0];
assign set_host_alive = command_q && command_address_q == 12'h061 && command_data_q[0];
assign set_restart = command_q && command_address_q == 12'h06d && command_data_q[0];
assign set_arm = command_q && command_address_q == 12'h078;
assign set_capture = command_q && command_address_q == 12'h074;
assign set_capture_offset = command_q && command_address_q == 12'h075;
assign set_stream = command_q && command_address_q == 12'h076;

// Live words.

always @* begin
    live = 33'd0;
    case (bus_address_i)
        12'h066: live = {32'd0, magnet_found};
        12'h067: live = {{1{1'b0}}, magnet_angle[0 +: 32]};
        12'h039: live = {{17{1'b0}}, bus_i[0 +: 16]};
        12'h062: live = {{9{1'b0}}, faults[0 +: 24]};
        12'h063: live = {32'd0, running};
        12'h068: live = {32'd0, adc_ready};
        12'h069: live = {32'd0, tick};
        12'h06a: live = {32'd0, core_valid};
        12'h06b: live = {32'd0, overrun};
        12'h06c: live = {{29{1'b0}}, words_hold[0 +: 4]};
        12'h064: live = {{1{1'b0}}, ticks[0 +: 32]};
        12'h079: live = {32'd0, armed};
        12'h07a: live = {{28{1'b0}}, arm_refused[0 +: 5]};
        12'h0c0: live = {{30{1'b0}}, capture_state[0 +: 3]};
        12'h0c1: live = {{17{1'b0}}, capture_count[0 +: 16]};
        12'h0c2: live = {{17{1'b0}}, capture_first[0 +: 16]};
        12'h0c3: live = {{17{1'b0}}, capture_left[0 +: 16]};
        12'h0c4: live = {{31{1'b0}}, stream_state[0 +: 2]};
        12'h0c5: live = {{17{1'b0}}, stream_lost[0 +: 16]};
        12'h0c6: live = {{29{1'b0}}, surfaces[0 +: 4]};
        12'h0c7: live = {{31{1'b0}}, surfaces_acting[0 +: 2]};
        12'h0c8: live = {32'd0, surfaces_pending};
        12'h0c9: live = {{25{1'b0}}, surfaces_refused[0 +: 8]};
        12'h0ca: live = {{17{1'b0}}, surfaces_stamp[0 +: 16]};
        default: live = 33'd0;
    endcase
    if (bus_address_i[11:6] == 6'h2) live = {{1{1'b0}}, capture_data[0 +: 32]};
    for (m = 0; m < PARTS; m = m + 1) begin
        if ({28'd0, bus_address_i[11:8]} == m + 1) begin
            case (bus_address_i[7:0])
                8'hd4: live = {32'd0, overcurrent[m]};
                8'hd0: live = {32'd0, adc_range[m]};
                8'hd1: live = {32'd0, adc_stuck[m]};
                8'hd2: live = {32'd0, zero_fault[m]};
                8'hd3: live = {32'd0, zero_busy[m]};
                8'hd5: live = {32'd0, encoder_fault[m]};
                8'ha4: live = {32'd0, host_strobe[m]};
                8'ha5: live = {{25{1'b0}}, seen_host_sequence[m*8 +: 8]};
                8'ha6: live = {{33-`WH_DATA_W{seen_host_v[m*`WH_DATA_W + `WH_DATA_W - 1]}}, seen_host_v[m*`WH_DATA_W +: `WH_DATA_W]};
                8'ha7: live = {32'd0, host_active[m]};
                8'hb0: live = {{33-`WH_DATA_W{voltage[m*`WH_DATA_W + `WH_DATA_W - 1]}}, voltage[m*`WH_DATA_W +: `WH_DATA_W]};
                8'hb1: live = {{33-`WH_DATA_W{u[m*`WH_DATA_W + `WH_DATA_W - 1]}}, u[m*`WH_DATA_W +: `WH_DATA_W]};
                8'hb2: live = {{33-`WH_DATA_W{v[m*`WH_DATA_W + `WH_DATA_W - 1]}}, v[m*`WH_DATA_W +: `WH_DATA_W]};
                8'hb3: live = {{33-`WH_DATA_W{current[m*`WH_DATA_W + `WH_DATA_W - 1]}}, current[m*`WH_DATA_W +: `WH_DATA_W]};
                8'hb4: live = {{33-`WH_COUNT_W{position[m*`WH_COUNT_W + `WH_COUNT_W - 1]}}, position[m*`WH_COUNT_W +: `WH_COUNT_W]};
                8'hb5: live = {32'd0, contact[m]};
                8'hb6: live = {32'd0, saturated[m]};
                8'hb7: live = {32'd0, clipped[m]};
                8'hd6: live = {{25{1'b0}}, flags[m*8 +: 8]};
                8'hc0: live = {{33-`WH_DATA_W{correction[m*`WH_DATA_W + `WH_DATA_W - 1]}}, correction[m*`WH_DATA_W +: `WH_DATA_W]};
                8'hc1: live = {{33-`WH_DATA_W{offset[m*`WH_DATA_W + `WH_DATA_W - 1]}}, offset[m*`WH_DATA_W +: `WH_DATA_W]};
                8'hc2: live = {{33-`WH_DATA_W{flux[m*`WH_DATA_W + `WH_DATA_W - 1]}}, flux[m*`WH_DATA_W +: `WH_DATA_W]};
                8'hc3: live = {{33-`WH_DATA_W{lag[m*`WH_DATA_W + `WH_DATA_W - 1]}}, lag[m*`WH_DATA_W +: `WH_DATA_W]};
                8'hc4: live = {32'd0, anchor_fault[m]};
                8'hb8: live = {{9{contact_energy[m*24 + 24 - 1]}}, contact_energy[m*24 +: 24]};
                8'hb9: live = {{9{contact_energy_peak[m*24 + 24 - 1]}}, contact_energy_peak[m*24 +: 24]};
                default: live = 33'd0;
            endcase
        end
    end
end

`define WH_DEVICE_PORTS \
    .half_clocks_i (set_half_clocks), \
    .tick_halves_i (set_tick_halves), \
    .sample_clocks_i (set_sample_clocks), \
    .samples_i (set_samples), \
    .sample_lead_i (set_sample_lead), \
    .sample_late_i (set_sample_late), \
    .sclk_half_clocks_i (set_sclk_half_clocks), \
    .frame_bits_i (set_frame_bits), \
    .lead_bits_i (set_lead_bits), \
    .data_bits_i (set_data_bits), \
    .quiet_clocks_i (set_quiet_clocks), \
    .setup_clocks_i (set_setup_clocks), \
    .hold_clocks_i (set_hold_clocks), \
    .calibrate_bits_i (set_calibrate_bits), \
    .sclk_idle_i (set_sclk_idle), \
    .read_trailing_i (set_read_trailing), \
    .trip_i (set_trip), \
    .range_i (set_range), \
    .stuck_words_i (set_stuck_words), \
    .zero_limit_i (set_zero_limit), \
    .zero_start_i (set_zero_start || zero_start_i || arm_zero_start || clear_zero), \
    .filter_clocks_i (set_filter_clocks), \
    .host_period_log2_i (set_host_period_log2), \
    .host_timeout_i (set_host_timeout), \
    .host_sequence_i (set_host_sequence), \
    .host_u_i (set_host_u), \
    .host_strobe_i (set_host_strobe), \
    .extra_ticks_i (set_extra_ticks), \
    .hold_ticks_i (set_hold_ticks), \
    .eta_contact_i (set_eta_contact), \
    .eta_free_i (set_eta_free), \
    .root_i (set_root), \
    .a_i (set_a), \
    .u_max_i (set_u_max), \
    .mode_i (set_mode), \
    .min_pulse_i (set_min_pulse), \
    .dead_clocks_i (set_dead_clocks), \
    .compensate_i (set_compensate), \
    .settle_ticks_i (set_settle_ticks), \
    .second_order_i (set_second_order), \
    .bus_share_i (set_bus_share), \
    .bus_i (bus_i), \
    .guard_i (set_guard), \
    .clear_i (set_clear || clear_i), \
    .host_alive_i (set_host_alive), \
    .restart_i (set_restart || loading), \
    .zero_i (set_zero), \
    .gain_i (set_gain), \
    .clocks_per_volt_i (set_clocks_per_volt), \
    .side_current_i (set_side_current), \
    .anchor_words_i (set_anchor_words), \
    .edge_hysteresis_i (set_edge_hysteresis), \
    .wall_min_i (set_wall_min), \
    .wall_max_i (set_wall_max), \
    .wall_enable_i (set_wall_enable), \
    .wall_shaped_i (set_wall_shaped), \
    .shape_words_i (set_shape_words), \
    .overcurrent_o (overcurrent), \
    .adc_range_o (adc_range), \
    .adc_stuck_o (adc_stuck), \
    .zero_fault_o (zero_fault), \
    .zero_busy_o (zero_busy), \
    .encoder_fault_o (encoder_fault), \
    .host_strobe_o (host_strobe), \
    .host_sequence_o (host_sequence), \
    .host_v_o (host_v), \
    .host_active_o (host_active), \
    .voltage_o (voltage), \
    .u_o (u), \
    .v_o (v), \
    .current_o (current), \
    .position_o (position), \
    .contact_o (contact), \
    .saturated_o (saturated), \
    .clipped_o (clipped), \
    .faults_o (faults), \
    .running_o (running), \
    .adc_ready_o (adc_ready), \
    .tick_o (tick), \
    .core_valid_o (core_valid), \
    .overrun_o (overrun), \
    .words_hold_o (words_hold), \
    .correction_o (correction), \
    .offset_o (offset), \
    .flux_o (flux), \
    .lag_o (lag), \
    .anchor_fault_o (anchor_fault), \
    .contact_energy_o (contact_energy), \
    .contact_energy_peak_o (contact_energy_peak),

`define WH_DEVICE_WITHOUT \
    set_count_angle, \
    set_zero_angle, \
    set_find_magnet, \
    set_magnet_start

`define WH_BRUSHLESS_PORTS \
    .half_clocks_i (set_half_clocks), \
    .tick_halves_i (set_tick_halves), \
    .sample_clocks_i (set_sample_clocks), \
    .samples_i (set_samples), \
    .sample_lead_i (set_sample_lead), \
    .sample_late_i (set_sample_late), \
    .sclk_half_clocks_i (set_sclk_half_clocks), \
    .frame_bits_i (set_frame_bits), \
    .lead_bits_i (set_lead_bits), \
    .data_bits_i (set_data_bits), \
    .quiet_clocks_i (set_quiet_clocks), \
    .setup_clocks_i (set_setup_clocks), \
    .hold_clocks_i (set_hold_clocks), \
    .calibrate_bits_i (set_calibrate_bits), \
    .sclk_idle_i (set_sclk_idle), \
    .read_trailing_i (set_read_trailing), \
    .trip_i (set_trip), \
    .range_i (set_range), \
    .stuck_words_i (set_stuck_words), \
    .zero_limit_i (set_zero_limit), \
    .zero_start_i (set_zero_start || zero_start_i || arm_zero_start || clear_zero), \
    .filter_clocks_i (set_filter_clocks), \
    .count_angle_i (set_count_angle), \
    .zero_angle_i (set_zero_angle), \
    .find_magnet_i (set_find_magnet), \
    .magnet_start_i (set_magnet_start), \
    .extra_ticks_i (set_extra_ticks), \
    .hold_ticks_i (set_hold_ticks), \
    .eta_contact_i (set_eta_contact[`WH_COEF_W-1:0]), \
    .eta_free_i (set_eta_free[`WH_COEF_W-1:0]), \
    .root_i (set_root[`WH_COEF_W-1:0]), \
    .a_i (set_a[`WH_COEF_W-1:0]), \
    .u_max_i (set_u_max[`WH_DATA_W-1:0]), \
    .min_pulse_i (set_min_pulse), \
    .dead_clocks_i (set_dead_clocks), \
    .compensate_i (set_compensate), \
    .settle_ticks_i (set_settle_ticks), \
    .second_order_i (set_second_order), \
    .bus_i (bus_i), \
    .guard_i (set_guard), \
    .clear_i (set_clear || clear_i), \
    .host_alive_i (set_host_alive), \
    .restart_i (set_restart || loading), \
    .zero_i (set_zero), \
    .gain_i (set_gain), \
    .clocks_per_volt_i (set_clocks_per_volt[`WH_COEF_W-1:0]), \
    .side_current_i (set_side_current[`WH_DATA_W-1:0]), \
    .anchor_words_i (set_anchor_words[(8*`WH_COEF_W + 3*`WH_DATA_W + 33)-1:0]), \
    .edge_hysteresis_i (set_edge_hysteresis[0]), \
    .wall_min_i (set_wall_min[WALLS*`WH_COUNT_W-1:0]), \
    .wall_max_i (set_wall_max[WALLS*`WH_COUNT_W-1:0]), \
    .wall_enable_i (set_wall_enable[WALLS-1:0]), \
    .overcurrent_o (overcurrent), \
    .adc_range_o (adc_range), \
    .adc_stuck_o (adc_stuck), \
    .zero_fault_o (zero_fault), \
    .zero_busy_o (zero_busy), \
    .encoder_fault_o (once_encoder_fault), \
    .magnet_found_o (magnet_found), \
    .magnet_angle_o (magnet_angle), \
    .voltage_o (voltage), \
    .u_o (u), \
    .v_o (v), \
    .current_o (current), \
    .position_o (once_position), \
    .contact_o (once_contact), \
    .saturated_o (saturated), \
    .clipped_o (clipped), \
    .faults_o (faults), \
    .running_o (running), \
    .adc_ready_o (adc_ready), \
    .tick_o (tick), \
    .core_valid_o (core_valid), \
    .overrun_o (overrun), \
    .words_hold_o (words_hold), \
    .correction_o (correction), \
    .offset_o (offset), \
    .flux_o (flux), \
    .lag_o (lag), \
    .anchor_fault_o (once_anchor_fault),

`define WH_BRUSHLESS_WITHOUT \
    set_host_period_log2, \
    set_host_timeout, \
    set_host_sequence, \
    set_host_u, \
    set_host_strobe, \
    set_eta_contact, \
    set_eta_free, \
    set_root, \
    set_a, \
    set_u_max, \
    set_mode, \
    set_bus_share, \
    set_clocks_per_volt, \
    set_side_current, \
    set_anchor_words, \
    set_edge_hysteresis, \
    set_wall_min, \
    set_wall_max, \
    set_wall_enable, \
    set_wall_shaped, \
    set_shape_words

`define WH_BRUSHLESS_ONCE \
    wire [0:0] once_encoder_fault; \
    assign encoder_fault = {PARTS{once_encoder_fault}}; \
    wire [`WH_COUNT_W-1:0] once_position; \
    assign position = {PARTS{once_position}}; \
    wire [0:0] once_contact; \
    assign contact = {PARTS{once_contact}}; \
    wire [0:0] once_anchor_fault; \
    assign anchor_fault = {PARTS{once_anchor_fault}};

// <!-- end device-words -->
