// SPDX-License-Identifier: Apache-2.0
//
// wh_round: drops low bits, rounding to the nearest word, halves away from zero.
//
//   value_o = sign(value_i) * floor(|value_i| / 2^SHIFT + 1/2)
//
// For sensors and for the pulse width, where rounding toward zero would be an offset or a dead
// zone; the wave path has wh_truncate. Odd in value_i, so both signs are treated alike.
// Formats: s<IN_W>q<q> -> s<OUT_W>q<q - SHIFT>; the rounding can carry, so one bit is gained.
// Combinational; no reset.

`default_nettype none

module wh_round #(
    parameter integer IN_W  = 16,               // 3...
    parameter integer SHIFT = 8,                // 2...IN_W - 1
    parameter integer OUT_W = IN_W - SHIFT + 1  // derived, leave it
) (
    input  wire signed [IN_W-1:0]  value_i,
    output wire signed [OUT_W-1:0] value_o
);

    generate
        if (SHIFT < 2 || SHIFT >= IN_W || OUT_W != IN_W - SHIFT + 1) begin : illegal
            wh_illegal_parameter_round_shift_or_out_w stop ();
        end
    endgenerate

    // One adder: half a place is added, less one last place below zero so that an exact half goes
    // away from zero there too. The place in front of the last makes the carry of that last place.
    wire                   negative = value_i[IN_W-1];
    wire signed [IN_W+1:0] sum      = $signed({negative, value_i, 1'b1})
                                      + $signed({{IN_W+2-SHIFT{1'b0}}, {SHIFT-1{1'b1}}, !negative});

    assign value_o = sum[IN_W+1:SHIFT+1];

    wire unused = &{1'b0, sum[SHIFT:0]};

endmodule

`default_nettype wire
