// SPDX-License-Identifier: Apache-2.0
//
// wh_faults: the faults by their bits in the status word, and the fields of the guard's settings.
// Python reads this file (sim/wavehaptics/controller/guard.py).

`ifndef WH_FAULTS_VH
`define WH_FAULTS_VH

`define WH_FAULTS            24  // bits of the word; those without a name are 0
`define WH_FAULT_CURRENT     0   // a sample beyond the limit
`define WH_FAULT_TRIP        1   // the trip of the current's fast path
`define WH_FAULT_ADC_STUCK   2   // the ADC repeats one value
`define WH_FAULT_ADC_RANGE   3   // a sample at the end of the ADC's range
`define WH_FAULT_ZERO        4   // current with the bridge off
`define WH_FAULT_ENCODER     5   // an illegal move
`define WH_FAULT_LOST        6   // voltage and current show motion, the encoder doesn't
`define WH_FAULT_HOST        7   // no sign of the host
`define WH_FAULT_DRIVER      8   // the driver's fault pin
`define WH_FAULT_STOP        9   // emergency stop
`define WH_FAULT_BUS_LOW     10
`define WH_FAULT_BUS_HIGH    11
`define WH_FAULT_HEAT        12  // the winding's losses, averaged over its time constant
`define WH_FAULT_SETTING     13  // a setting that a block can't use
`define WH_FAULT_OVERRUN     14  // a tick too short for its work, or ticks without a step
`define WH_FAULT_ANCHOR      15  // waves and encoder disagree on the rotor's position
`define WH_FAULT_ENERGY      16  // a contact delivered more energy than its limit
`define WH_FAULT_SATURATED   17  // in contact at the voltage limit the rotor swings to and fro
`define WH_FAULT_OVERSPEED   18  // a rotor is too fast
`define WH_FAULT_WINDOW      19  // a position outside its interval

// Faults after which the current can still be trusted: these alone may end in damping.
`define WH_FAULTS_DAMPABLE   24'h0080e0

// Fields of the settings, as high:low, of words.toml; `make numbers` writes them.
// <!-- begin guard-fields -->
`define WH_GUARD_W           298
`define WH_GUARD_MASK        23:0     // u24, faults that have an effect, a bit each
`define WH_GUARD_DAMP        47:24    // u24, those of them that damp and don't switch off
`define WH_GUARD_LEVELS      49:48    // u2, active level of the stop pin (bit 0) and of the drivers' fault pins (bit 1)
`define WH_GUARD_CURRENT     65:50    // u16, limit of a sample's magnitude, full scale is 2^15
`define WH_GUARD_RANGE       81:66    // u16, magnitude of a sample at the end of the ADC's range, full scale is 2^15
`define WH_GUARD_STUCK       97:82    // u16 samples, identical consecutive samples that raise ADC_STUCK; 0: no check
`define WH_GUARD_ZERO        113:98   // u16q9 A, largest current with the bridge off
`define WH_GUARD_ZERO_TICKS  129:114  // u16 ticks, time with the bridge off before that is judged
`define WH_GUARD_LOST        145:130  // u16q8 √W, limit of the mean of u + v, for LOST
`define WH_GUARD_LOST_TICKS  161:146  // u16 ticks, time beyond that limit, without a count, that raises LOST
`define WH_GUARD_HOST        185:162  // u24 ticks, longest time without host_alive
`define WH_GUARD_BUS_MIN     201:186  // u16q9 V, lowest permitted bus voltage
`define WH_GUARD_BUS_MAX     217:202  // u16q9 V, highest permitted bus voltage
`define WH_GUARD_HEAT_TICKS  233:218  // u16 ticks, interval at which the current is squared for HEAT
`define WH_GUARD_HEAT        265:234  // u32q18 A², largest mean square of the current
`define WH_GUARD_ENERGY      281:266  // u16q3 A·counts, most energy that a contact may deliver; 0: no check; no effect with brushless motors
`define WH_GUARD_SATURATED   297:282  // u16 ticks, longest time between two turns back in contact at the voltage limit, of which 16 in a row raise SATURATED; 0: no check
// <!-- end guard-fields -->

`define WH_GUARD_CURRENT_Q   9        // of currents; the bus has WH_BUS_Q
`define WH_GUARD_WAVE_Q      8
`define WH_GUARD_HEAT_LOG2   16       // time constant: 2^this squares
`define WH_SPAN_LOG2         8        // a speed is counts in 2^this control periods

`endif
