// SPDX-License-Identifier: Apache-2.0
//
// wh_shaper: the wave-domain filter W{v} between the incoming wave and the λ filter.
//
//   value_o = W{value_i},  W = 1
//
// Any W with |W(jω)| <= 1 keeps the virtual environment passive.
// Formats: s<DATA_W>q<WH_WAVE_Q> √W, ±128 √W, in and out. Combinational; no state, no reset.

`default_nettype none
`include "wh_formats.vh"

module wh_shaper (
    input  wire signed [`WH_DATA_W-1:0] value_i,  // s31q23 √W, ±128 √W
    output wire signed [`WH_DATA_W-1:0] value_o   // s31q23 √W, ±128 √W
);

    assign value_o = value_i;

endmodule

`default_nettype wire
