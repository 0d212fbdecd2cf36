// SPDX-License-Identifier: Apache-2.0
//
// wh_pwm: the switching pattern of a full bridge, symmetric in each carrier half.
//
//   active vector where phase < |width| or remaining < |width|:  leg A is width > 0, leg B is not
//   zero vector in the middle:                                   both legs are half_i
//
// so the mean of (A - B) over a half is 2 width / half_clocks, and the middle of the half is quiet:
// a sample there is close to the mean current (design 1.1). As the zero vectors alternate, each leg
// switches at most twice in a carrier period while the width keeps its sign.
// Latency: the legs show a phase one clock later. Reset: both legs low.

`default_nettype none
`include "wh_formats.vh"

module wh_pwm (
    input  wire                         clk,
    input  wire                         rst,

    input  wire        [`WH_TICK_W-1:0] phase_i,      // clocks since the half's start
    input  wire        [`WH_TICK_W-1:0] remaining_i,  // clocks to the half's last
    input  wire                         half_i,       // parity of the half
    input  wire                         update_i,     // strobe, last clock of a half
    input  wire signed [`WH_TICK_W-1:0] width_i,      // s16, clocks, for the half after update_i

    output reg                          leg_a_o,      // 1: leg A to the bus, 0: to ground
    output reg                          leg_b_o
);

    reg [`WH_TICK_W-1:0] magnitude_q;
    reg                  negative_q;

    always @(posedge clk) begin
        if (rst) begin
            magnitude_q <= {`WH_TICK_W{1'b0}};
            negative_q  <= 1'b0;
        end else if (update_i) begin
            magnitude_q <= width_i[`WH_TICK_W-1] ? -width_i : width_i;
            negative_q  <= width_i[`WH_TICK_W-1];
        end
    end

    wire active = (phase_i < magnitude_q) || (remaining_i < magnitude_q);

    always @(posedge clk) begin
        if (rst) begin
            leg_a_o <= 1'b0;
            leg_b_o <= 1'b0;
        end else begin
            leg_a_o <= active ? !negative_q : half_i;
            leg_b_o <= active ? negative_q : half_i;
        end
    end

endmodule

`default_nettype wire
