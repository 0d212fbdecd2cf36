// SPDX-License-Identifier: Apache-2.0
//
// wh_settings_rom: what the settings memory knows of each word of words.toml, which this is made from.
// It stands in an initial block of wh_settings_rom and of wh_registers, which say what a row does.
//
//   WH_SETTINGS_WORD(address, copies in a part, who, {kind, off, type}, word at first), of a setting
//   WH_SETTINGS_TOLD(address, copies in a part, who, {kind, off, type}), of another word
//   WH_SETTINGS_BOUNDS(type, least, greatest), 2^31 more for a word with a sign
//
// Who has it: motors with brushes (low bit), brushless ones.
//
// <!-- begin settings-rom -->
`WH_SETTINGS_WORD('h000, 1, 2'b11, 8'h60, 32'd48)  // half_clocks
`WH_SETTINGS_WORD('h001, 1, 2'b11, 8'h60, 32'd1)  // tick_halves
`WH_SETTINGS_WORD('h002, 1, 2'b11, 8'h60, 32'd48)  // sample_clocks
`WH_SETTINGS_WORD('h003, 1, 2'b11, 8'h61, 32'd1)  // samples
`WH_SETTINGS_WORD('h004, 1, 2'b11, 8'h74, -32'd1)  // sample_lead
`WH_SETTINGS_WORD('h005, 1, 2'b11, 8'h62, 32'd0)  // sample_late
`WH_SETTINGS_WORD('h008, 1, 2'b11, 8'h63, 32'd1)  // sclk_half_clocks
`WH_SETTINGS_WORD('h009, 1, 2'b11, 8'h64, 32'd14)  // frame_bits
`WH_SETTINGS_WORD('h00a, 1, 2'b11, 8'h65, 32'd2)  // lead_bits
`WH_SETTINGS_WORD('h00b, 1, 2'b11, 8'h66, 32'd12)  // data_bits
`WH_SETTINGS_WORD('h00c, 1, 2'b11, 8'h67, 32'd0)  // quiet_clocks
`WH_SETTINGS_WORD('h00d, 1, 2'b11, 8'h63, 32'd1)  // setup_clocks
`WH_SETTINGS_WORD('h00e, 1, 2'b11, 8'h67, 32'd0)  // hold_clocks
`WH_SETTINGS_WORD('h00f, 1, 2'b11, 8'h65, 32'd0)  // calibrate_bits
`WH_SETTINGS_WORD('h010, 1, 2'b11, 8'h62, 32'd0)  // sclk_idle
`WH_SETTINGS_WORD('h011, 1, 2'b11, 8'h62, 32'd0)  // read_trailing
`WH_SETTINGS_WORD('h018, 1, 2'b11, 8'h68, 32'd65535)  // trip
`WH_SETTINGS_TOLD('h1d4, 1, 2'b11, 8'hc2)  // overcurrent
`WH_SETTINGS_WORD('h01a, 1, 2'b11, 8'h68, 32'd65535)  // range
`WH_SETTINGS_WORD('h01b, 1, 2'b11, 8'h68, 32'd0)  // stuck_words
`WH_SETTINGS_TOLD('h1d0, 1, 2'b11, 8'hc2)  // adc_range
`WH_SETTINGS_TOLD('h1d1, 1, 2'b11, 8'hc2)  // adc_stuck
`WH_SETTINGS_WORD('h01c, 1, 2'b11, 8'h69, 32'd0)  // zero_limit
`WH_SETTINGS_TOLD('h01d, 1, 2'b11, 8'ha2)  // zero_start
`WH_SETTINGS_TOLD('h1d2, 1, 2'b11, 8'hc2)  // zero_fault
`WH_SETTINGS_TOLD('h1d3, 1, 2'b11, 8'hc2)  // zero_busy
`WH_SETTINGS_WORD('h020, 1, 2'b11, 8'h6a, 32'd2)  // filter_clocks
`WH_SETTINGS_TOLD('h1d5, 1, 2'b11, 8'hc2)  // encoder_fault
`WH_SETTINGS_WORD('h021, 1, 2'b10, 8'h6b, 32'd0)  // count_angle
`WH_SETTINGS_WORD('h022, 1, 2'b10, 8'h6b, 32'd0)  // zero_angle
`WH_SETTINGS_WORD('h023, 1, 2'b10, 8'h62, 32'd0)  // find_magnet
`WH_SETTINGS_TOLD('h065, 1, 2'b10, 8'ha2)  // magnet_start
`WH_SETTINGS_TOLD('h066, 1, 2'b10, 8'hc2)  // magnet_found
`WH_SETTINGS_TOLD('h067, 1, 2'b10, 8'hcb)  // magnet_angle
`WH_SETTINGS_WORD('h024, 1, 2'b01, 8'h6a, 32'd0)  // host_period_log2
`WH_SETTINGS_WORD('h025, 1, 2'b01, 8'h67, 32'd0)  // host_timeout
`WH_SETTINGS_TOLD('h1a1, 1, 2'b01, 8'h87)  // host_answer_sequence
`WH_SETTINGS_TOLD('h1a2, 1, 2'b01, 8'h95)  // host_u
`WH_SETTINGS_TOLD('h1a3, 1, 2'b01, 8'h82)  // host_answer
`WH_SETTINGS_TOLD('h1a4, 1, 2'b01, 8'hc2)  // host_packet
`WH_SETTINGS_TOLD('h1a5, 1, 2'b01, 8'hc7)  // host_packet_sequence
`WH_SETTINGS_TOLD('h1a6, 1, 2'b01, 8'hd5)  // host_v
`WH_SETTINGS_TOLD('h1a7, 1, 2'b01, 8'hc2)  // host_active
`WH_SETTINGS_WORD('h028, 1, 2'b11, 8'h6c, 32'd1)  // extra_ticks
`WH_SETTINGS_WORD('h029, 1, 2'b11, 8'h6c, 32'd0)  // hold_ticks
`WH_SETTINGS_WORD('h108, 1, 2'b11, 8'h56, (-32'd1 << `WH_ETA_Q))  // eta_contact
`WH_SETTINGS_WORD('h109, 1, 2'b11, 8'h56, (32'd1 << `WH_ETA_Q))  // eta_free
`WH_SETTINGS_WORD('h110, 1, 2'b11, 8'h57, 32'd0)  // root
`WH_SETTINGS_WORD('h111, 1, 2'b11, 8'h58, (32'd1 << `WH_A_Q))  // a
`WH_SETTINGS_WORD('h112, 1, 2'b11, 8'h59, 32'd0)  // u_max
`WH_SETTINGS_TOLD('h1b0, 1, 2'b11, 8'hd5)  // voltage
`WH_SETTINGS_TOLD('h1b1, 1, 2'b11, 8'hd5)  // u
`WH_SETTINGS_TOLD('h1b2, 1, 2'b11, 8'hd5)  // v
`WH_SETTINGS_TOLD('h1b3, 1, 2'b11, 8'hd5)  // current
`WH_SETTINGS_TOLD('h1b4, 1, 2'b11, 8'hc0)  // position
`WH_SETTINGS_TOLD('h1b5, 1, 2'b11, 8'hc2)  // contact
`WH_SETTINGS_TOLD('h1b6, 1, 2'b11, 8'hc2)  // saturated
`WH_SETTINGS_TOLD('h1b7, 1, 2'b11, 8'hc2)  // clipped
`WH_SETTINGS_WORD('h030, 1, 2'b01, 8'h6d, 32'd0)  // mode
`WH_SETTINGS_WORD('h031, 1, 2'b11, 8'h67, 32'd0)  // min_pulse
`WH_SETTINGS_WORD('h032, 1, 2'b11, 8'h67, 32'd0)  // dead_clocks
`WH_SETTINGS_WORD('h033, 1, 2'b11, 8'h62, 32'd0)  // compensate
`WH_SETTINGS_WORD('h034, 1, 2'b11, 8'h67, 32'd0)  // settle_ticks
`WH_SETTINGS_WORD('h035, 1, 2'b11, 8'h62, 32'd0)  // second_order
`WH_SETTINGS_WORD('h038, 1, 2'b01, 8'h57, 32'd0)  // bus_share
`WH_SETTINGS_TOLD('h039, 1, 2'b11, 8'hc8)  // bus
`WH_SETTINGS_WORD('h040, 1, 2'b11, 8'h6e, 32'd0)  // guard_mask
`WH_SETTINGS_WORD('h041, 1, 2'b11, 8'h6e, 32'd0)  // guard_damp
`WH_SETTINGS_WORD('h042, 1, 2'b11, 8'h6d, 32'd0)  // guard_levels
`WH_SETTINGS_WORD('h043, 1, 2'b11, 8'h68, 32'd0)  // guard_current
`WH_SETTINGS_WORD('h044, 1, 2'b11, 8'h68, 32'd0)  // guard_range
`WH_SETTINGS_WORD('h045, 1, 2'b11, 8'h68, 32'd0)  // guard_stuck
`WH_SETTINGS_WORD('h046, 1, 2'b11, 8'h68, 32'd0)  // guard_zero
`WH_SETTINGS_WORD('h047, 1, 2'b11, 8'h68, 32'd0)  // guard_zero_ticks
`WH_SETTINGS_WORD('h048, 1, 2'b11, 8'h68, 32'd0)  // guard_lost
`WH_SETTINGS_WORD('h049, 1, 2'b11, 8'h68, 32'd0)  // guard_lost_ticks
`WH_SETTINGS_WORD('h04a, 1, 2'b11, 8'h6e, 32'd0)  // guard_host
`WH_SETTINGS_WORD('h04b, 1, 2'b11, 8'h68, 32'd0)  // guard_bus_min
`WH_SETTINGS_WORD('h04c, 1, 2'b11, 8'h68, 32'd0)  // guard_bus_max
`WH_SETTINGS_WORD('h04d, 1, 2'b11, 8'h68, 32'd0)  // guard_heat_ticks
`WH_SETTINGS_WORD('h04e, 1, 2'b11, 8'h6b, 32'd0)  // guard_heat
`WH_SETTINGS_WORD('h04f, 1, 2'b11, 8'h68, 32'd0)  // guard_energy
`WH_SETTINGS_WORD('h03e, 1, 2'b11, 8'h68, 32'd0)  // guard_saturated
`WH_SETTINGS_TOLD('h060, 1, 2'b11, 8'h82)  // clear
`WH_SETTINGS_TOLD('h061, 1, 2'b11, 8'h82)  // host_alive
`WH_SETTINGS_TOLD('h062, 1, 2'b11, 8'hce)  // faults
`WH_SETTINGS_TOLD('h063, 1, 2'b11, 8'hc2)  // running
`WH_SETTINGS_TOLD('h068, 1, 2'b11, 8'hc2)  // adc_ready
`WH_SETTINGS_TOLD('h069, 1, 2'b11, 8'hc2)  // tick
`WH_SETTINGS_TOLD('h06a, 1, 2'b11, 8'hc2)  // core_valid
`WH_SETTINGS_TOLD('h06b, 1, 2'b11, 8'hc2)  // overrun
`WH_SETTINGS_TOLD('h06c, 1, 2'b11, 8'hca)  // words_hold
`WH_SETTINGS_TOLD('h06d, 1, 2'b11, 8'ha2)  // restart
`WH_SETTINGS_TOLD('h064, 1, 2'b11, 8'hcb)  // ticks
`WH_SETTINGS_TOLD('h070, 1, 2'b11, 8'h82)  // commit
`WH_SETTINGS_TOLD('h071, 1, 2'b11, 8'h82)  // discard
`WH_SETTINGS_TOLD('h072, 1, 2'b11, 8'hc2)  // settings_busy
`WH_SETTINGS_TOLD('h073, 1, 2'b11, 8'hc2)  // settings_staged
`WH_SETTINGS_TOLD('h078, 1, 2'b11, 8'h8f)  // arm
`WH_SETTINGS_TOLD('h079, 1, 2'b11, 8'hc2)  // armed
`WH_SETTINGS_TOLD('h07a, 1, 2'b11, 8'hc0)  // arm_refused
`WH_SETTINGS_WORD('h050, 8, 2'b11, 8'h50, 32'd0)  // capture_channel
`WH_SETTINGS_WORD('h058, 1, 2'b11, 8'h51, 32'd1)  // capture_channels
`WH_SETTINGS_WORD('h059, 1, 2'b11, 8'h40, 32'd1)  // capture_rows
`WH_SETTINGS_WORD('h05a, 1, 2'b11, 8'h48, 32'd0)  // capture_pre
`WH_SETTINGS_WORD('h05b, 1, 2'b11, 8'h4a, 32'd0)  // capture_decimation
`WH_SETTINGS_WORD('h05c, 1, 2'b11, 8'h52, 32'd0)  // capture_trigger
`WH_SETTINGS_WORD('h05d, 1, 2'b11, 8'h5a, 32'd0)  // capture_level
`WH_SETTINGS_TOLD('h074, 1, 2'b11, 8'h8f)  // capture
`WH_SETTINGS_TOLD('h075, 1, 2'b11, 8'h88)  // capture_offset
`WH_SETTINGS_TOLD('h080, 64, 2'b11, 8'hcb)  // capture_data
`WH_SETTINGS_TOLD('h0c0, 1, 2'b11, 8'hd2)  // capture_state
`WH_SETTINGS_TOLD('h0c1, 1, 2'b11, 8'hc8)  // capture_count
`WH_SETTINGS_TOLD('h0c2, 1, 2'b11, 8'hc8)  // capture_first
`WH_SETTINGS_TOLD('h0c3, 1, 2'b11, 8'hc8)  // capture_left
`WH_SETTINGS_TOLD('h1d6, 1, 2'b11, 8'hc7)  // flags
`WH_SETTINGS_WORD('h02a, 4, 2'b11, 8'h50, 32'd0)  // stream_channel
`WH_SETTINGS_WORD('h02e, 1, 2'b11, 8'h4d, 32'd0)  // stream_last
`WH_SETTINGS_WORD('h02f, 1, 2'b11, 8'h4a, 32'd0)  // stream_decimation
`WH_SETTINGS_WORD('h03a, 4, 2'b11, 8'h4a, 32'd0)  // stream_shift
`WH_SETTINGS_TOLD('h076, 1, 2'b11, 8'h8f)  // stream
`WH_SETTINGS_TOLD('h0c4, 1, 2'b11, 8'hcd)  // stream_state
`WH_SETTINGS_TOLD('h0c5, 1, 2'b11, 8'hc8)  // stream_lost
`WH_SETTINGS_WORD('h100, 1, 2'b11, 8'h5b, 32'd0)  // zero
`WH_SETTINGS_WORD('h101, 1, 2'b11, 8'h57, 32'd0)  // gain
`WH_SETTINGS_WORD('h118, 1, 2'b11, 8'h57, 32'd0)  // clocks_per_volt
`WH_SETTINGS_WORD('h11a, 1, 2'b11, 8'h59, 32'd0)  // side_current
`WH_SETTINGS_WORD('h120, 1, 2'b11, 8'h42, 32'd0)  // anchor_enable
`WH_SETTINGS_WORD('h121, 1, 2'b11, 8'h57, 32'd0)  // anchor_flux_gain
`WH_SETTINGS_WORD('h122, 1, 2'b11, 8'h57, 32'd0)  // anchor_owed_gain
`WH_SETTINGS_WORD('h123, 1, 2'b11, 8'h57, 32'd0)  // anchor_cells_gain
`WH_SETTINGS_WORD('h124, 1, 2'b11, 8'h57, 32'd0)  // anchor_pull_gain
`WH_SETTINGS_WORD('h125, 1, 2'b11, 8'h57, 32'd0)  // anchor_learn_gain
`WH_SETTINGS_WORD('h126, 1, 2'b11, 8'h57, 32'd0)  // anchor_learn_max
`WH_SETTINGS_WORD('h127, 1, 2'b11, 8'h57, 32'd0)  // anchor_zero_gain
`WH_SETTINGS_WORD('h128, 1, 2'b11, 8'h57, 32'd0)  // anchor_room_gain
`WH_SETTINGS_WORD('h129, 1, 2'b11, 8'h5c, 32'd0)  // anchor_reach
`WH_SETTINGS_WORD('h12a, 1, 2'b11, 8'h59, 32'd0)  // anchor_strange
`WH_SETTINGS_WORD('h12b, 1, 2'b11, 8'h5d, 32'd0)  // anchor_brush
`WH_SETTINGS_WORD('h12c, 1, 2'b11, 8'h50, 32'd0)  // anchor_follow_ticks
`WH_SETTINGS_WORD('h12d, 1, 2'b11, 8'h53, 32'd0)  // anchor_slow_ticks
`WH_SETTINGS_TOLD('h1c0, 1, 2'b11, 8'hd5)  // correction
`WH_SETTINGS_TOLD('h1c1, 1, 2'b11, 8'hd5)  // offset
`WH_SETTINGS_TOLD('h1c2, 1, 2'b11, 8'hd5)  // flux
`WH_SETTINGS_TOLD('h1c3, 1, 2'b11, 8'hd5)  // lag
`WH_SETTINGS_TOLD('h1c4, 1, 2'b11, 8'hc2)  // anchor_fault
`WH_SETTINGS_WORD('h130, 1, 2'b11, 8'h42, 32'd0)  // edge_hysteresis
`WH_SETTINGS_WORD('h140, WALLS, 2'b11, 8'h5e, 32'd0)  // wall_min
`WH_SETTINGS_WORD('h150, WALLS, 2'b11, 8'h5e, 32'd0)  // wall_max
`WH_SETTINGS_WORD('h160, WALLS, 2'b11, 8'h42, 32'd0)  // wall_enable
`WH_SETTINGS_WORD('h170, WALLS, 2'b01, 8'h42, 32'd0)  // wall_shaped
`WH_SETTINGS_WORD('h131, 1, 2'b11, 8'h68, 32'd0)  // overspeed
`WH_SETTINGS_WORD('h132, 1, 2'b11, 8'h7e, -32'd2147483648)  // window_low
`WH_SETTINGS_WORD('h133, 1, 2'b11, 8'h7e, 32'd2147483647)  // window_high
`WH_SETTINGS_WORD('h180, 9 * SHAPER, 2'b01, 8'h5f, 32'd0)  // shape_coefficient
`WH_SETTINGS_WORD('h192, 3 * SHAPER, 2'b01, 8'h50, 32'd0)  // shape_loss
`WH_SETTINGS_TOLD('h1b8, 1, 2'b01, 8'hdb)  // contact_energy
`WH_SETTINGS_TOLD('h1b9, 1, 2'b01, 8'hdb)  // contact_energy_peak
`WH_SETTINGS_WORD('h05e, 1, 2'b01, 8'h4b, 32'd0)  // surface_budget
`WH_SETTINGS_TOLD('h0c6, 1, 2'b01, 8'hca)  // surfaces
`WH_SETTINGS_TOLD('h0c7, 1, 2'b01, 8'hcd)  // surfaces_acting
`WH_SETTINGS_TOLD('h0c8, 1, 2'b01, 8'hc2)  // surfaces_pending
`WH_SETTINGS_TOLD('h0c9, 1, 2'b01, 8'hc7)  // surfaces_refused
`WH_SETTINGS_TOLD('h0ca, 1, 2'b01, 8'hc8)  // surfaces_stamp
`WH_SETTINGS_TOLD('h0cb, 52, 2'b01, 8'h8b)  // surface_word
`WH_SETTINGS_TOLD('h0ff, 1, 2'b01, 8'h88)  // surface_commit
`WH_SETTINGS_BOUNDS(0, 32'd1, (32'hffffffff >> (32 - 16)))
`WH_SETTINGS_BOUNDS(1, 32'd1, 32'd256)
`WH_SETTINGS_BOUNDS(20, (32'h80000000 + (32'd0 - (32'd1 << (8 - 1)))), (32'h80000000 + ((32'd1 << (8 - 1)) - 32'd1)))
`WH_SETTINGS_BOUNDS(2, 32'd0, (32'hffffffff >> (32 - 1)))
`WH_SETTINGS_BOUNDS(3, 32'd1, (32'hffffffff >> (32 - 8)))
`WH_SETTINGS_BOUNDS(4, 32'd1, (32'hffffffff >> (32 - 6)))
`WH_SETTINGS_BOUNDS(5, 32'd0, (32'hffffffff >> (32 - 6)))
`WH_SETTINGS_BOUNDS(6, 32'd1, 32'd16)
`WH_SETTINGS_BOUNDS(7, 32'd0, (32'hffffffff >> (32 - 8)))
`WH_SETTINGS_BOUNDS(8, 32'd0, (32'hffffffff >> (32 - 16)))
`WH_SETTINGS_BOUNDS(9, 32'd0, (32'hffffffff >> (32 - 23)))
`WH_SETTINGS_BOUNDS(10, 32'd0, (32'hffffffff >> (32 - 4)))
`WH_SETTINGS_BOUNDS(11, 32'd0, (32'hffffffff >> (32 - 32)))
`WH_SETTINGS_BOUNDS(21, (32'h80000000 + (32'd0 - (32'd1 << (`WH_DATA_W - 1)))), (32'h80000000 + ((32'd1 << (`WH_DATA_W - 1)) - 32'd1)))
`WH_SETTINGS_BOUNDS(12, 32'd0, (32'hffffffff >> (32 - DELAY_LOG2)))
`WH_SETTINGS_BOUNDS(22, (32'h80000000 + (-32'd1 << `WH_ETA_Q)), (32'h80000000 + (32'd1 << `WH_ETA_Q)))
`WH_SETTINGS_BOUNDS(23, (32'h80000000 + 32'd0), (32'h80000000 + ((32'd1 << (`WH_COEF_W - 1)) - 32'd1)))
`WH_SETTINGS_BOUNDS(24, (32'h80000000 + 32'd0), (32'h80000000 + (32'd1 << `WH_A_Q)))
`WH_SETTINGS_BOUNDS(25, (32'h80000000 + 32'd0), (32'h80000000 + ((32'd1 << (`WH_DATA_W - 1)) - 32'd1)))
`WH_SETTINGS_BOUNDS(13, 32'd0, (32'hffffffff >> (32 - 2)))
`WH_SETTINGS_BOUNDS(14, 32'd0, (32'hffffffff >> (32 - 24)))
`WH_SETTINGS_BOUNDS(15, 32'd0, 32'd2)
`WH_SETTINGS_BOUNDS(16, 32'd0, (32'hffffffff >> (32 - 12)))
`WH_SETTINGS_BOUNDS(17, 32'd1, 32'd8)
`WH_SETTINGS_BOUNDS(18, 32'd0, (32'hffffffff >> (32 - 3)))
`WH_SETTINGS_BOUNDS(26, (32'h80000000 + (32'd0 - (32'd1 << (32 - 1)))), (32'h80000000 + ((32'd1 << (32 - 1)) - 32'd1)))
`WH_SETTINGS_BOUNDS(27, (32'h80000000 + (32'd0 - (32'd1 << (24 - 1)))), (32'h80000000 + ((32'd1 << (24 - 1)) - 32'd1)))
`WH_SETTINGS_BOUNDS(28, (32'h80000000 + 32'd0), (32'h80000000 + (32'd64 << `WH_VOLTAGE_Q)))
`WH_SETTINGS_BOUNDS(29, (32'h80000000 + 32'd0), (32'h80000000 + (32'd8192 << `WH_SEEN_Q)))
`WH_SETTINGS_BOUNDS(19, 32'd0, (32'hffffffff >> (32 - 20)))
`WH_SETTINGS_BOUNDS(30, (32'h80000000 + (32'd0 - (32'd1 << (`WH_COUNT_W - 1)))), (32'h80000000 + ((32'd1 << (`WH_COUNT_W - 1)) - 32'd1)))
`WH_SETTINGS_BOUNDS(31, (32'h80000000 + (32'd0 - (32'd1 << (`WH_SHAPE_W - 1)))), (32'h80000000 + ((32'd1 << (`WH_SHAPE_W - 1)) - 32'd1)))
// <!-- end settings-rom -->
