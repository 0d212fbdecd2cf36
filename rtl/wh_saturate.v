// SPDX-License-Identifier: Apache-2.0
//
// wh_saturate: limits a sum to a shorter word, so that it never wraps.
//
//   value_o = min(max(value_i, -2^(OUT_W-1)), 2^(OUT_W-1) - 1)
//
// Formats: s<IN_W>q<q> -> s<OUT_W>q<q>. Combinational; no reset.

`default_nettype none

module wh_saturate #(
    parameter integer IN_W  = 16,  // OUT_W + 1...
    parameter integer OUT_W = 8    // 2...
) (
    input  wire signed [IN_W-1:0]  value_i,
    output wire signed [OUT_W-1:0] value_o
);

    generate
        if (OUT_W < 2 || IN_W <= OUT_W) begin : illegal
            wh_illegal_parameter_saturate_widths stop ();
        end
    endgenerate

    // A value fits if all bits above the shorter word repeat its sign.
    wire negative = value_i[IN_W-1];
    wire fits     = value_i[IN_W-1:OUT_W-1] == {(IN_W - OUT_W + 1){negative}};

    assign value_o = fits ? $signed(value_i[OUT_W-1:0])
                          : $signed({negative, {(OUT_W - 1){!negative}}});

endmodule

`default_nettype wire
