// SPDX-License-Identifier: Apache-2.0
//
// wh_truncate: drops low bits, rounding toward zero.
//
//   value_o = value_i / 2^SHIFT without its fraction
//
// The magnitude can only shrink, so a rounding step can take energy out of the waves and never put
// any in. No word overflows: -2^(IN_W-1) is divided exactly.
// Formats: s<IN_W>q<q> -> s<OUT_W>q<q - SHIFT>. Combinational; no reset.

`default_nettype none

module wh_truncate #(
    parameter integer IN_W  = 16,           // 2...
    parameter integer SHIFT = 8,            // 1...IN_W - 1
    parameter integer OUT_W = IN_W - SHIFT  // follows from the others
) (
    input  wire signed [IN_W-1:0]  value_i,
    output wire signed [OUT_W-1:0] value_o
);

    generate
        if (SHIFT < 1 || SHIFT >= IN_W || OUT_W != IN_W - SHIFT) begin : illegal
            wh_illegal_parameter_truncate_shift_or_out_w stop ();
        end
    endgenerate

    // The slice rounds down; a negative value that loses something goes one up again, to 0 at most.
    wire lost = |value_i[SHIFT-1:0];
    wire up   = value_i[IN_W-1] && lost;

    assign value_o = $signed(value_i[IN_W-1:SHIFT]) + $signed({{(OUT_W - 1){1'b0}}, up});

endmodule

`default_nettype wire
