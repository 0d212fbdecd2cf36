// SPDX-License-Identifier: Apache-2.0
//
// wavehaptics_words.h: the table of words, rtl/words.toml, for C. `make numbers` writes it; each list is a
// macro that takes a macro, X(...) for each row.

#ifndef WAVEHAPTICS_WORDS_H
#define WAVEHAPTICS_WORDS_H

// <!-- begin c-words -->
#define WH_WORDS_CRC 0x69734c31u

#define WH_MAP_VERSION 1u
#define WH_TABLE_REGISTER 0x2000u
#define WH_MOTOR_STRIDE 0x100u
#define WH_MOST_READ 62u
#define WH_BRUSHLESS_SHAPER 3u
#define WH_AXES 2u

// Words of the identification, from register 0 on.
#define WH_IDENTIFICATION(X) \
    X(TABLE) \
    X(BUILD) \
    X(OPTIONS) \
    X(CLOCK_HZ) \
    X(MOTORS) \
    X(RATE) \
    X(VERSION) \
    X(RATES) \
    X(FRAMES) \
    X(CRC_ERRORS) \
    X(FRAMING_ERRORS) \
    X(OVERRUNS)

// Of its word `options`: name, lowest bit, bits.
#define WH_OPTIONS(X) \
    X(motors, 0, 4) \
    X(walls, 4, 5) \
    X(shaper, 9, 2) \
    X(delay_log2, 11, 4) \
    X(adc, 15, 2) \
    X(anchor, 18, 1) \
    X(guard, 19, 1) \
    X(sense, 20, 1) \
    X(host, 21, 1) \
    X(bus, 22, 1) \
    X(modes, 23, 1) \
    X(min_pulse, 24, 1) \
    X(dead_time, 25, 1) \
    X(arm, 27, 1) \
    X(capture, 28, 4)

// Bits a second by the word `rate`.
#define WH_RATES(X) \
    X(115200) \
    X(1000000) \
    X(1500000) \
    X(3000000)

// NAME, name, address, kind, of what, words of one, places of the fraction, has a sign,
// least and greatest value, unit.
#define WH_WORDS(X) \
    X(HALF_CLOCKS, "half_clocks", 0x000, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 1.0, 65535.0, "clocks") \
    X(TICK_HALVES, "tick_halves", 0x001, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 1.0, 65535.0, "") \
    X(SAMPLE_CLOCKS, "sample_clocks", 0x002, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 1.0, 65535.0, "clocks") \
    X(SAMPLES, "samples", 0x003, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 1.0, 256.0, "") \
    X(SAMPLE_LEAD, "sample_lead", 0x004, WH_SETTING, WH_OF_BOARD, 1, 0, 1, -128.0, 127.0, "clocks") \
    X(SAMPLE_LATE, "sample_late", 0x005, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(SCLK_HALF_CLOCKS, "sclk_half_clocks", 0x008, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 1.0, 255.0, "clocks") \
    X(FRAME_BITS, "frame_bits", 0x009, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 1.0, 63.0, "") \
    X(LEAD_BITS, "lead_bits", 0x00a, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 63.0, "") \
    X(DATA_BITS, "data_bits", 0x00b, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 1.0, 16.0, "") \
    X(QUIET_CLOCKS, "quiet_clocks", 0x00c, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 255.0, "clocks") \
    X(SETUP_CLOCKS, "setup_clocks", 0x00d, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 1.0, 255.0, "clocks") \
    X(HOLD_CLOCKS, "hold_clocks", 0x00e, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 255.0, "clocks") \
    X(CALIBRATE_BITS, "calibrate_bits", 0x00f, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 63.0, "") \
    X(SCLK_IDLE, "sclk_idle", 0x010, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(READ_TRAILING, "read_trailing", 0x011, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(TRIP, "trip", 0x018, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(RANGE, "range", 0x01a, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(STUCK_WORDS, "stuck_words", 0x01b, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(ZERO_LIMIT, "zero_limit", 0x01c, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 8388607.0, "") \
    X(ZERO_START, "zero_start", 0x01d, WH_COMMAND, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(FILTER_CLOCKS, "filter_clocks", 0x020, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 15.0, "clocks") \
    X(COUNT_ANGLE, "count_angle", 0x021, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 4294967295.0, "") \
    X(ZERO_ANGLE, "zero_angle", 0x022, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 4294967295.0, "") \
    X(FIND_MAGNET, "find_magnet", 0x023, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(HOST_PERIOD_LOG2, "host_period_log2", 0x024, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 15.0, "") \
    X(HOST_TIMEOUT, "host_timeout", 0x025, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 255.0, "") \
    X(EXTRA_TICKS, "extra_ticks", 0x028, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, WH_BY_DELAY, "ticks") \
    X(HOLD_TICKS, "hold_ticks", 0x029, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, WH_BY_DELAY, "ticks") \
    X(STREAM_CHANNEL, "stream_channel", 0x02a, WH_SETTING, WH_OF_BOARD, 4, 0, 0, 0.0, 4095.0, "") \
    X(STREAM_LAST, "stream_last", 0x02e, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 3.0, "") \
    X(STREAM_DECIMATION, "stream_decimation", 0x02f, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 15.0, "") \
    X(MODE, "mode", 0x030, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 3.0, "") \
    X(MIN_PULSE, "min_pulse", 0x031, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 255.0, "clocks") \
    X(DEAD_CLOCKS, "dead_clocks", 0x032, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 255.0, "clocks") \
    X(COMPENSATE, "compensate", 0x033, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(SETTLE_TICKS, "settle_ticks", 0x034, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 255.0, "ticks") \
    X(SECOND_ORDER, "second_order", 0x035, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(BUS_SHARE, "bus_share", 0x038, WH_SETTING, WH_OF_BOARD, 1, 24, 1, 0.0, 3.9999999403953552, "1/V") \
    X(BUS, "bus", 0x039, WH_LIVE, WH_OF_BOARD, 1, 9, 0, 0.0, 127.998046875, "V") \
    X(STREAM_SHIFT, "stream_shift", 0x03a, WH_SETTING, WH_OF_BOARD, 4, 0, 0, 0.0, 15.0, "") \
    X(GUARD_SATURATED, "guard_saturated", 0x03e, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "ticks") \
    X(GUARD_MASK, "guard_mask", 0x040, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 16777215.0, "") \
    X(GUARD_DAMP, "guard_damp", 0x041, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 16777215.0, "") \
    X(GUARD_LEVELS, "guard_levels", 0x042, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 3.0, "") \
    X(GUARD_CURRENT, "guard_current", 0x043, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(GUARD_RANGE, "guard_range", 0x044, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(GUARD_STUCK, "guard_stuck", 0x045, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "samples") \
    X(GUARD_ZERO, "guard_zero", 0x046, WH_SETTING, WH_OF_BOARD, 1, 9, 0, 0.0, 127.998046875, "A") \
    X(GUARD_ZERO_TICKS, "guard_zero_ticks", 0x047, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "ticks") \
    X(GUARD_LOST, "guard_lost", 0x048, WH_SETTING, WH_OF_BOARD, 1, 8, 0, 0.0, 255.99609375, "√W") \
    X(GUARD_LOST_TICKS, "guard_lost_ticks", 0x049, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "ticks") \
    X(GUARD_HOST, "guard_host", 0x04a, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 16777215.0, "ticks") \
    X(GUARD_BUS_MIN, "guard_bus_min", 0x04b, WH_SETTING, WH_OF_BOARD, 1, 9, 0, 0.0, 127.998046875, "V") \
    X(GUARD_BUS_MAX, "guard_bus_max", 0x04c, WH_SETTING, WH_OF_BOARD, 1, 9, 0, 0.0, 127.998046875, "V") \
    X(GUARD_HEAT_TICKS, "guard_heat_ticks", 0x04d, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "ticks") \
    X(GUARD_HEAT, "guard_heat", 0x04e, WH_SETTING, WH_OF_BOARD, 1, 18, 0, 0.0, 16383.999996185303, "A²") \
    X(GUARD_ENERGY, "guard_energy", 0x04f, WH_SETTING, WH_OF_BOARD, 1, 3, 0, 0.0, 8191.875, "A·counts") \
    X(CAPTURE_CHANNEL, "capture_channel", 0x050, WH_SETTING, WH_OF_BOARD, 8, 0, 0, 0.0, 4095.0, "") \
    X(CAPTURE_CHANNELS, "capture_channels", 0x058, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 1.0, 8.0, "") \
    X(CAPTURE_ROWS, "capture_rows", 0x059, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 1.0, 65535.0, "") \
    X(CAPTURE_PRE, "capture_pre", 0x05a, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(CAPTURE_DECIMATION, "capture_decimation", 0x05b, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 15.0, "") \
    X(CAPTURE_TRIGGER, "capture_trigger", 0x05c, WH_SETTING, WH_OF_BOARD, 1, 0, 0, 0.0, 7.0, "") \
    X(CAPTURE_LEVEL, "capture_level", 0x05d, WH_SETTING, WH_OF_BOARD, 1, 0, 1, -2147483648.0, 2147483647.0, "") \
    X(SURFACE_BUDGET, "surface_budget", 0x05e, WH_SETTING, WH_OF_BOARD, 1, 16, 0, 0.0, 65535.99998474121, "W") \
    X(CLEAR, "clear", 0x060, WH_COMMAND, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(HOST_ALIVE, "host_alive", 0x061, WH_COMMAND, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(FAULTS, "faults", 0x062, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 16777215.0, "") \
    X(RUNNING, "running", 0x063, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(TICKS, "ticks", 0x064, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 4294967295.0, "ticks") \
    X(MAGNET_START, "magnet_start", 0x065, WH_COMMAND, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(MAGNET_FOUND, "magnet_found", 0x066, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(MAGNET_ANGLE, "magnet_angle", 0x067, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 4294967295.0, "") \
    X(ADC_READY, "adc_ready", 0x068, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(TICK, "tick", 0x069, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(CORE_VALID, "core_valid", 0x06a, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(OVERRUN, "overrun", 0x06b, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(WORDS_HOLD, "words_hold", 0x06c, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 15.0, "") \
    X(RESTART, "restart", 0x06d, WH_COMMAND, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(COMMIT, "commit", 0x070, WH_MEMORY, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(DISCARD, "discard", 0x071, WH_MEMORY, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(SETTINGS_BUSY, "settings_busy", 0x072, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(SETTINGS_STAGED, "settings_staged", 0x073, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(CAPTURE, "capture", 0x074, WH_COMMAND, WH_OF_BOARD, 1, 0, 0, 0.0, 2.0, "") \
    X(CAPTURE_OFFSET, "capture_offset", 0x075, WH_COMMAND, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(STREAM, "stream", 0x076, WH_COMMAND, WH_OF_BOARD, 1, 0, 0, 0.0, 2.0, "") \
    X(ARM, "arm", 0x078, WH_COMMAND, WH_OF_BOARD, 1, 0, 0, 0.0, 2.0, "") \
    X(ARMED, "armed", 0x079, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(ARM_REFUSED, "arm_refused", 0x07a, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 31.0, "") \
    X(CAPTURE_DATA, "capture_data", 0x080, WH_LIVE, WH_OF_BOARD, 64, 0, 0, 0.0, 4294967295.0, "") \
    X(CAPTURE_STATE, "capture_state", 0x0c0, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 7.0, "") \
    X(CAPTURE_COUNT, "capture_count", 0x0c1, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(CAPTURE_FIRST, "capture_first", 0x0c2, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(CAPTURE_LEFT, "capture_left", 0x0c3, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(STREAM_STATE, "stream_state", 0x0c4, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 3.0, "") \
    X(STREAM_LOST, "stream_lost", 0x0c5, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(SURFACES, "surfaces", 0x0c6, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 15.0, "") \
    X(SURFACES_ACTING, "surfaces_acting", 0x0c7, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 3.0, "") \
    X(SURFACES_PENDING, "surfaces_pending", 0x0c8, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 1.0, "") \
    X(SURFACES_REFUSED, "surfaces_refused", 0x0c9, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 255.0, "") \
    X(SURFACES_STAMP, "surfaces_stamp", 0x0ca, WH_LIVE, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(SURFACE_WORD, "surface_word", 0x0cb, WH_COMMAND, WH_OF_BOARD, 52, 0, 0, 0.0, 4294967295.0, "") \
    X(SURFACE_COMMIT, "surface_commit", 0x0ff, WH_COMMAND, WH_OF_BOARD, 1, 0, 0, 0.0, 65535.0, "") \
    X(ZERO, "zero", 0x100, WH_SETTING, WH_OF_MOTOR, 1, 0, 1, -8388608.0, 8388607.0, "") \
    X(GAIN, "gain", 0x101, WH_SETTING, WH_OF_MOTOR, 1, 35, 1, 0.0, 0.0019531249708961695, "A") \
    X(ETA_CONTACT, "eta_contact", 0x108, WH_SETTING, WH_OF_MOTOR, 1, 25, 1, -1.0, 1.0, "") \
    X(ETA_FREE, "eta_free", 0x109, WH_SETTING, WH_OF_MOTOR, 1, 25, 1, -1.0, 1.0, "") \
    X(ROOT, "root", 0x110, WH_SETTING, WH_OF_MOTOR, 1, 22, 1, 0.0, 15.999999761581421, "√Ω") \
    X(A, "a", 0x111, WH_SETTING, WH_OF_MOTOR, 1, 25, 1, 0.0, 1.0, "") \
    X(U_MAX, "u_max", 0x112, WH_SETTING, WH_OF_MOTOR, 1, 23, 1, 0.0, 127.99999988079071, "√W") \
    X(CLOCKS_PER_VOLT, "clocks_per_volt", 0x118, WH_SETTING, WH_OF_MOTOR, 1, 16, 1, 0.0, 1023.9999847412109, "clocks/V") \
    X(SIDE_CURRENT, "side_current", 0x11a, WH_SETTING, WH_OF_MOTOR, 1, 24, 1, 0.0, 63.999999940395355, "A") \
    X(ANCHOR_ENABLE, "anchor_enable", 0x120, WH_SETTING, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(ANCHOR_FLUX_GAIN, "anchor_flux_gain", 0x121, WH_SETTING, WH_OF_MOTOR, 1, 22, 1, 0.0, 15.999999761581421, "cells/√W") \
    X(ANCHOR_OWED_GAIN, "anchor_owed_gain", 0x122, WH_SETTING, WH_OF_MOTOR, 1, 22, 1, 0.0, 15.999999761581421, "cells/√W") \
    X(ANCHOR_CELLS_GAIN, "anchor_cells_gain", 0x123, WH_SETTING, WH_OF_MOTOR, 1, 12, 1, 0.0, 16383.999755859375, "cells/A") \
    X(ANCHOR_PULL_GAIN, "anchor_pull_gain", 0x124, WH_SETTING, WH_OF_MOTOR, 1, 20, 1, 0.0, 63.999999046325684, "V/cell") \
    X(ANCHOR_LEARN_GAIN, "anchor_learn_gain", 0x125, WH_SETTING, WH_OF_MOTOR, 1, 33, 1, 0.0, 0.007812499883584678, "V/count²") \
    X(ANCHOR_LEARN_MAX, "anchor_learn_max", 0x126, WH_SETTING, WH_OF_MOTOR, 1, 20, 1, 0.0, 63.999999046325684, "V/count") \
    X(ANCHOR_ZERO_GAIN, "anchor_zero_gain", 0x127, WH_SETTING, WH_OF_MOTOR, 1, 22, 1, 0.0, 15.999999761581421, "A/V") \
    X(ANCHOR_ROOM_GAIN, "anchor_room_gain", 0x128, WH_SETTING, WH_OF_MOTOR, 1, 22, 1, 0.0, 15.999999761581421, "√W/V") \
    X(ANCHOR_REACH, "anchor_reach", 0x129, WH_SETTING, WH_OF_MOTOR, 1, 23, 1, 0.0, 64.0, "V") \
    X(ANCHOR_STRANGE, "anchor_strange", 0x12a, WH_SETTING, WH_OF_MOTOR, 1, 23, 1, 0.0, 127.99999988079071, "V") \
    X(ANCHOR_BRUSH, "anchor_brush", 0x12b, WH_SETTING, WH_OF_MOTOR, 1, 16, 1, 0.0, 8192.0, "counts") \
    X(ANCHOR_FOLLOW_TICKS, "anchor_follow_ticks", 0x12c, WH_SETTING, WH_OF_MOTOR, 1, 0, 0, 0.0, 4095.0, "periods") \
    X(ANCHOR_SLOW_TICKS, "anchor_slow_ticks", 0x12d, WH_SETTING, WH_OF_MOTOR, 1, 0, 0, 0.0, 1048575.0, "periods") \
    X(EDGE_HYSTERESIS, "edge_hysteresis", 0x130, WH_SETTING, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(OVERSPEED, "overspeed", 0x131, WH_SETTING, WH_OF_MOTOR, 1, 0, 0, 0.0, 65535.0, "counts") \
    X(WINDOW_LOW, "window_low", 0x132, WH_SETTING, WH_OF_MOTOR, 1, 0, 1, -2147483648.0, 2147483647.0, "counts") \
    X(WINDOW_HIGH, "window_high", 0x133, WH_SETTING, WH_OF_MOTOR, 1, 0, 1, -2147483648.0, 2147483647.0, "counts") \
    X(WALL_MIN, "wall_min", 0x140, WH_SETTING, WH_OF_WALL, 1, 0, 1, -2147483648.0, 2147483647.0, "counts") \
    X(WALL_MAX, "wall_max", 0x150, WH_SETTING, WH_OF_WALL, 1, 0, 1, -2147483648.0, 2147483647.0, "counts") \
    X(WALL_ENABLE, "wall_enable", 0x160, WH_SETTING, WH_OF_WALL, 1, 0, 0, 0.0, 1.0, "") \
    X(WALL_SHAPED, "wall_shaped", 0x170, WH_SETTING, WH_OF_WALL, 1, 0, 0, 0.0, 1.0, "") \
    X(SHAPE_COEFFICIENT, "shape_coefficient", 0x180, WH_SETTING, WH_OF_SECTION, 9, 29, 1, -2.0, 1.9999999981373549, "") \
    X(SHAPE_LOSS, "shape_loss", 0x192, WH_SETTING, WH_OF_SECTION, 3, 0, 0, 0.0, 4095.0, "") \
    X(HOST_ANSWER_SEQUENCE, "host_answer_sequence", 0x1a1, WH_COMMAND, WH_OF_MOTOR, 1, 0, 0, 0.0, 255.0, "") \
    X(HOST_U, "host_u", 0x1a2, WH_COMMAND, WH_OF_MOTOR, 1, 23, 1, -128.0, 127.99999988079071, "√W") \
    X(HOST_ANSWER, "host_answer", 0x1a3, WH_COMMAND, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(HOST_PACKET, "host_packet", 0x1a4, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(HOST_PACKET_SEQUENCE, "host_packet_sequence", 0x1a5, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 255.0, "") \
    X(HOST_V, "host_v", 0x1a6, WH_LIVE, WH_OF_MOTOR, 1, 23, 1, -128.0, 127.99999988079071, "√W") \
    X(HOST_ACTIVE, "host_active", 0x1a7, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(VOLTAGE, "voltage", 0x1b0, WH_LIVE, WH_OF_MOTOR, 1, 23, 1, -128.0, 127.99999988079071, "V") \
    X(U, "u", 0x1b1, WH_LIVE, WH_OF_MOTOR, 1, 23, 1, -128.0, 127.99999988079071, "√W") \
    X(V, "v", 0x1b2, WH_LIVE, WH_OF_MOTOR, 1, 23, 1, -128.0, 127.99999988079071, "√W") \
    X(CURRENT, "current", 0x1b3, WH_LIVE, WH_OF_MOTOR, 1, 24, 1, -64.0, 63.999999940395355, "A") \
    X(POSITION, "position", 0x1b4, WH_LIVE, WH_OF_MOTOR, 1, 0, 1, -2147483648.0, 2147483647.0, "counts") \
    X(CONTACT, "contact", 0x1b5, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(SATURATED, "saturated", 0x1b6, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(CLIPPED, "clipped", 0x1b7, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(CONTACT_ENERGY, "contact_energy", 0x1b8, WH_LIVE, WH_OF_MOTOR, 1, 10, 1, -8192.0, 8191.9990234375, "A·counts") \
    X(CONTACT_ENERGY_PEAK, "contact_energy_peak", 0x1b9, WH_LIVE, WH_OF_MOTOR, 1, 10, 1, -8192.0, 8191.9990234375, "A·counts") \
    X(CORRECTION, "correction", 0x1c0, WH_LIVE, WH_OF_MOTOR, 1, 23, 1, -128.0, 127.99999988079071, "V") \
    X(OFFSET, "offset", 0x1c1, WH_LIVE, WH_OF_MOTOR, 1, 24, 1, -64.0, 63.999999940395355, "A") \
    X(FLUX, "flux", 0x1c2, WH_LIVE, WH_OF_MOTOR, 1, 16, 1, -16384.0, 16383.999984741211, "cells") \
    X(LAG, "lag", 0x1c3, WH_LIVE, WH_OF_MOTOR, 1, 16, 1, -16384.0, 16383.999984741211, "cells") \
    X(ANCHOR_FAULT, "anchor_fault", 0x1c4, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(ADC_RANGE, "adc_range", 0x1d0, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(ADC_STUCK, "adc_stuck", 0x1d1, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(ZERO_FAULT, "zero_fault", 0x1d2, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(ZERO_BUSY, "zero_busy", 0x1d3, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(OVERCURRENT, "overcurrent", 0x1d4, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(ENCODER_FAULT, "encoder_fault", 0x1d5, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 1.0, "") \
    X(FLAGS, "flags", 0x1d6, WH_LIVE, WH_OF_MOTOR, 1, 0, 0, 0.0, 255.0, "")

// Bits of the word `faults`: bit, NAME, meaning.
#define WH_FAULTS(X) \
    X(0, CURRENT, "a sample beyond the limit") \
    X(1, TRIP, "the trip of the current's fast path") \
    X(2, ADC_STUCK, "the ADC repeats one value") \
    X(3, ADC_RANGE, "a sample at the end of the ADC's range") \
    X(4, ZERO, "current with the bridge off") \
    X(5, ENCODER, "an illegal move") \
    X(6, LOST, "voltage and current show motion, the encoder doesn't") \
    X(7, HOST, "no sign of the host") \
    X(8, DRIVER, "the driver's fault pin") \
    X(9, STOP, "emergency stop") \
    X(10, BUS_LOW, "") \
    X(11, BUS_HIGH, "") \
    X(12, HEAT, "the winding's losses, averaged over its time constant") \
    X(13, SETTING, "a setting that a block can't use") \
    X(14, OVERRUN, "a tick too short for its work, or ticks without a step") \
    X(15, ANCHOR, "waves and encoder disagree on the rotor's position") \
    X(16, ENERGY, "a contact delivered more energy than its limit") \
    X(17, SATURATED, "in contact at the voltage limit the rotor swings to and fro") \
    X(18, OVERSPEED, "a rotor is too fast") \
    X(19, WINDOW, "a position outside its interval")

// Bits of the word `arm_refused`.
#define WH_ARM_REFUSALS(X) \
    X(0, "the board's switch is off (enable_i)") \
    X(1, "there is a fault") \
    X(2, "settings were being committed") \
    X(3, "no permitted zero of the currents was found") \
    X(4, "it wasn't renewed in time")

// Exceptions of Modbus.
#define WH_EXCEPTIONS(X) \
    X(1, "the device doesn't have this function") \
    X(2, "no such register, or it can't be read or written") \
    X(3, "a value is out of its register's range") \
    X(4, "the device's registers don't answer") \
    X(6, "not now: it needs the bridges off, or a commit is under way")
// <!-- end c-words -->

#endif
