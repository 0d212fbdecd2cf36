// SPDX-License-Identifier: Apache-2.0
//
// wh_truncate: drops low bits, rounding toward zero.
//
//   value_i / 2^SHIFT without its fraction = floor_o + up_o
//
// The magnitude can only shrink, so a rounding step can take energy out of the waves and never put
// any in. floor_o is rounded down, and up_o is 1 where a negative value lost something; whatever
// sum takes the value can take up_o as its carry, at no cost. floor_o + up_o fits where floor_o
// does, because up_o is 1 only with a negative floor_o.
// Formats: s<IN_W>q<q> -> s<OUT_W>q<q - SHIFT>. Combinational; no reset.

`default_nettype none

module wh_truncate #(
    parameter integer IN_W  = 16,           // 2...
    parameter integer SHIFT = 8,            // 1...IN_W - 1
    parameter integer OUT_W = IN_W - SHIFT  // follows from the others
) (
    input  wire signed [IN_W-1:0]  value_i,
    output wire signed [OUT_W-1:0] floor_o,
    output wire                    up_o
);

    generate
        if (SHIFT < 1 || SHIFT >= IN_W || OUT_W != IN_W - SHIFT) begin : illegal
            wh_illegal_parameter_truncate_shift_or_out_w stop ();
        end
    endgenerate

    assign floor_o = $signed(value_i[IN_W-1:SHIFT]);
    assign up_o    = value_i[IN_W-1] && |value_i[SHIFT-1:0];

endmodule

`default_nettype wire
