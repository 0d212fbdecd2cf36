// SPDX-License-Identifier: Apache-2.0
//
// wh_formats: every word length and binary point of the design, in one place.
//
// A word s<W>q<Q> is a two's complement integer of W bits; value = raw / 2^Q in the SI unit named.
// Python reads this file (sim/wavehaptics/words/formats.py), so the RTL and the integer model can't drift
// apart. A width guarded by `ifndef may be set from the tool's command line.

`ifndef WH_FORMATS_VH
`define WH_FORMATS_VH

// Data words: current, voltage and waves share one width, so that one multiplier serves them.
`ifndef WH_DATA_W
`define WH_DATA_W 31
`endif
`define WH_CURRENT_Q (`WH_DATA_W - 7)  // A,   full scale +-64 A
`define WH_VOLTAGE_Q (`WH_DATA_W - 8)  // V,   full scale +-128 V
`define WH_WAVE_Q    (`WH_DATA_W - 8)  // √W,  full scale +-128 √W

// Coefficients: s, eta and a share one width, for the same reason.
`ifndef WH_COEF_W
`define WH_COEF_W 27
`endif
`define WH_ROOT_Q    (`WH_COEF_W - 5)  // s = √(2R̂) in √Ω, full scale +-16, so R̂ < 128 Ω
`define WH_ETA_Q     (`WH_COEF_W - 2)  // η, full scale +-2, used in [-1, 1]
`define WH_A_Q       (`WH_COEF_W - 2)  // a, full scale +-2, used in (0, 1]

// Guard bits below the wave's last place in the state f of the λ filter. A step smaller than one
// guarded place is lost, so f stops short of its goal by at most 2^-(WH_WAVE_Q + guard) / a:
// 5 µ√W at the smallest a of the design, 5e-5 (λ = 100 rad/s at T = 0.5 µs).
`ifndef WH_STATE_GUARD
`define WH_STATE_GUARD 9
`endif
`define WH_STATE_W   (`WH_DATA_W + `WH_STATE_GUARD)

// The shaper W. A coefficient is a place of a contractive matrix, less 1 on its diagonal. A state
// has WH_SHAPE_HEADROOM bits above a wave's full scale, as a filter of corner frequency p keeps
// √(2/(p T)) times its input, and its guard bits below the word that is multiplied.
`ifndef WH_SHAPE_W
`define WH_SHAPE_W 31
`endif
`define WH_SHAPE_Q        (`WH_SHAPE_W - 2)  // +-2
`ifndef WH_SHAPE_HEADROOM
`define WH_SHAPE_HEADROOM 4
`endif
`define WH_SHAPE_LOSS_W   12                 // last places that a rounding takes, at most

// Bits of the low limb when a product is split. 15 bits and a sign fit a 16-bit signed multiplier
// of the iCE40 and an 18-bit one of the ECP5, without a mixed-sign product.
`define WH_LIMB_W 15

// The port anchor: long words for what it sums up, cells, V or A; a factor is a long word's upper
// DATA_W bits.
`ifndef WH_LONG_GUARD
`define WH_LONG_GUARD 17
`endif
`define WH_LONG_W      (`WH_DATA_W + `WH_LONG_GUARD)
`define WH_LONG_Q      (`WH_DATA_W + 2)   // cells, V or A, full scale +-2^14
`define WH_SEEN_Q      (`WH_LONG_Q - `WH_LONG_GUARD)  // cells, χ and x̂ less its slow copy as shown
`define WH_FLUX_Q      (`WH_COEF_W - 5)   // cells a √W and tick, full scale +-16
`define WH_CELLS_Q     (`WH_COEF_W - 15)  // cells an A, full scale +-2^14
`define WH_PULL_Q      (`WH_COEF_W - 7)   // V a cell, full scale +-64
`define WH_LEARN_Q     (`WH_COEF_W + 6)   // V a count, per count and period, full scale +-2^-7
`define WH_REST_W      20                 // periods between two edges of a slow rotor
`define WH_FOLLOW_W    12                 // periods from one step of a mean to the next
`define WH_MOVE_W      12                 // counts that the rotor may move in a tick
`define WH_PLACE_W     (`WH_LONG_W - `WH_LONG_Q)  // cells that the anchor's positions hold, modulo
`define WH_SINE_Q      15                 // of a cell's parts in the two axes of a brushless motor
`define WH_ANCHOR_W (8 * `WH_COEF_W + 3 * `WH_DATA_W + `WH_FOLLOW_W + `WH_REST_W + 1)  // settings

// Surfaces across the motors of a group (sim/wavehaptics/controller/surfaces.py).
`define WH_SURFACE_Q  (`WH_COEF_W - 2)  // g of waves, G of counts, full scale +-2, used in [-1, 1]
`define WH_MIX_Q      (`WH_COEF_W - 5)  // wall velocities of a set, full scale +-16
`define WH_DISTANCE_W 40
`define WH_DISTANCE_Q 8                 // counts, where a plane lies

// Current sensing.
`define WH_SAMPLE_W 16  // ADC word, signed, left-justified: full scale is +-2^15 at any resolution
`define WH_SUM_W    24  // sum of a tick's samples, up to 256 of them
`define WH_GAIN_Q   35  // A per unit of the sum, in a coefficient word, < 1.95 mA

// Position and walls, in counts of the encoder.
`ifndef WH_COUNT_W
`define WH_COUNT_W 32
`endif

// Energy of a contact, A·counts.
`define WH_ENERGY_W       24
`define WH_ENERGY_Q       10  // A·counts, full scale +-8192
`define WH_ENERGY_LIMIT_W 16
`define WH_ENERGY_LIMIT_Q 3   // A·counts

// Drive: half width of the bridge's pulse in clocks.
`define WH_DUTY_Q   16  // clocks per volt in a coefficient word, and the fraction of the half width
`define WH_BUS_W    16  // a measured bus, without sign
`define WH_BUS_Q    9   // V, < 128 V
`define WH_BUS_SHARE_Q (`WH_COEF_W - 3)  // 1/V, inverse of the bus that the limit takes, < 4
`define WH_EXTRA_Q  8   // fraction of what dead time takes from the half width
`define WH_EXTRA_W  17  // at most 160 clocks: 5/8 of the longest dead time
`define WH_TICK_W   16  // counts of clocks
`define WH_MODE_W   2   // the bridge's switching pattern (wh_pwm)
`define WH_MODE_UNIPOLAR       0
`define WH_MODE_LOCKED         1
`define WH_MODE_SIGN_MAGNITUDE 2
`define WH_MODE_HALF_BRIDGE    3

// Live values of a port that takes turns with others.
`define WH_LIVE_VOLTAGE    0
`define WH_LIVE_U          1
`define WH_LIVE_V          2
`define WH_LIVE_CURRENT    3
`define WH_LIVE_POSITION   4
`define WH_LIVE_FLAGS      5  // the register `flags`, and three bits more:
`define WH_FLAG_CLIPPED    8
`define WH_FLAG_SHAPED     9
`define WH_FLAG_STUCK      10
`define WH_LIVE_ENERGY     6
`define WH_LIVE_ENERGY_PEAK 7
`define WH_LIVE_CORRECTION 8
`define WH_LIVE_OFFSET     9
`define WH_LIVE_FLUX       10
`define WH_LIVE_LAG        11
`define WH_LIVE_HOST_V     12
`define WH_LIVE_HOST_SEQUENCE 13

`endif
