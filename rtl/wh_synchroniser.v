// SPDX-License-Identifier: Apache-2.0
//
// wh_synchroniser: brings asynchronous levels into the clock domain, two flip-flops a bit.
//
//   level_o = level_i, two clock edges later
//
// Bits are taken one by one: where several change at once, they may arrive a clock apart.
// Latency: 2 clocks, or 3 where an edge falls into the first flip-flop's setup time. No reset: the
// output follows the pins in reset as well, so that it is right when reset ends.

`default_nettype none

module wh_synchroniser #(
    parameter integer WIDTH = 1  // 1...
) (
    input  wire             clk,

    input  wire [WIDTH-1:0] level_i,
    output wire [WIDTH-1:0] level_o
);

    generate
        if (WIDTH < 1) begin : illegal
            wh_illegal_parameter_synchroniser_width stop ();
        end
    endgenerate

    reg [WIDTH-1:0] first_q;
    reg [WIDTH-1:0] second_q;

    always @(posedge clk) begin
        first_q  <= level_i;
        second_q <= first_q;
    end

    assign level_o = second_q;

endmodule

`default_nettype wire
