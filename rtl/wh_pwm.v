// SPDX-License-Identifier: Apache-2.0
//
// wh_pwm: the switching pattern of a bridge, by mode; the mean over a half follows its width.
//
// Unipolar, symmetric in each half:
//   active vector where phase < |width| or remaining < |width|:  leg A is width > 0, leg B is not
//   zero vector in the middle:                                   both legs are half_i
// so the mean of (A - B) over a half is 2 width / half_clocks, and the middle of the half is quiet:
// a sample there is close to the mean current. As the zero vectors alternate, each leg switches at
// most twice in a carrier period while the width keeps its sign.
//
// The other modes, MODES = 1, have one width in a carrier period, half 0 and half 1. The pulse is on
// in the first clocks of half 0 and in the last ones of half 1, on_clocks in each:
//   locked anti-phase  on_clocks = half_clocks / 2 + width   A = on, B = not on
//   sign-magnitude     on_clocks = 2 |width|                 B = width < 0, A = on xor B
//   half bridge        on_clocks = half_clocks / 2 + width   A = on, B's gates stay off
// The mean of (A - B), or in the half bridge of 2 A - 1, is 2 width / half_clocks as well. The
// period is symmetric, so the current passes its mean where the halves meet, and a tick has to be
// whole periods. Half of an odd half_clocks is rounded down in half 0 and up in half 1. Each leg that
// switches does so at most twice in a period; in sign-magnitude leg B rests until the width changes
// its sign.
//
// Latency: the legs show a phase one clock later. Reset: both legs low.

`default_nettype none
`include "wh_formats.vh"

module wh_pwm #(
    parameter integer MODES = 0  // 1: mode_i chooses; 0: unipolar
) (
    input  wire                         clk,
    input  wire                         rst,

    input  wire        [`WH_MODE_W-1:0] mode_i,         // WH_MODE_...; MODES = 1
    input  wire        [`WH_TICK_W-1:0] half_clocks_i,  // clocks in a half; MODES = 1
    input  wire        [`WH_TICK_W-1:0] phase_i,        // clocks since the half's start
    input  wire        [`WH_TICK_W-1:0] remaining_i,    // clocks to the half's last
    input  wire                         half_i,         // parity of the half
    input  wire                         update_i,       // strobe, last clock of a half
    input  wire signed [`WH_TICK_W-1:0] width_i,        // s16, clocks, for the half after update_i,
                                                        // in the other modes after half 1

    output reg                          leg_a_o,        // 1: leg A to the bus, 0: to ground
    output reg                          leg_b_o
);

    localparam integer TICK_W = `WH_TICK_W;

    generate
        if (MODES != 0 && MODES != 1) begin : illegal
            wh_illegal_parameter_pwm_modes_must_be_0_or_1 stop ();
        end
    endgenerate

    reg  [TICK_W-1:0] magnitude_q;
    reg               negative_q;
    wire [TICK_W-1:0] magnitude = width_i[TICK_W-1] ? -width_i : width_i;

    always @(posedge clk) begin
        if (rst) begin
            magnitude_q <= {TICK_W{1'b0}};
            negative_q  <= 1'b0;
        end else if (update_i) begin
            magnitude_q <= magnitude;
            negative_q  <= width_i[TICK_W-1];
        end
    end

    wire active = (phase_i < magnitude_q) || (remaining_i < magnitude_q);
    wire leg_a  = active ? !negative_q : half_i;
    wire leg_b  = active ? negative_q : half_i;

    wire next_a;
    wire next_b;

    generate
        if (MODES != 0) begin : by_mode
            reg  [TICK_W-1:0] on_clocks_q;
            reg               sign_q;
            wire              signed_mode = (mode_i == `WH_MODE_SIGN_MAGNITUDE);
            wire              odd         = half_clocks_i[0] && !signed_mode;
            wire [TICK_W-1:0] centre      = signed_mode ? {TICK_W{1'b0}} : half_clocks_i >> 1;
            wire [TICK_W-1:0] more        = signed_mode ? magnitude << 1 : width_i;

            always @(posedge clk) begin
                if (rst) begin
                    on_clocks_q <= centre;
                    sign_q      <= 1'b0;
                end else if (update_i && half_i) begin
                    on_clocks_q <= centre + more;
                    if (width_i != {TICK_W{1'b0}}) begin
                        sign_q <= width_i[TICK_W-1];
                    end
                end else if (update_i) begin
                    on_clocks_q <= on_clocks_q + {{TICK_W-1{1'b0}}, odd};
                end
            end

            wire on = (half_i ? remaining_i : phase_i) < on_clocks_q;

            assign next_a = (mode_i == `WH_MODE_UNIPOLAR) ? leg_a
                          : signed_mode                   ? on ^ sign_q : on;
            assign next_b = (mode_i == `WH_MODE_UNIPOLAR) ? leg_b
                          : signed_mode                   ? sign_q : !on;
        end else begin : unipolar
            wire unused = &{1'b0, mode_i, half_clocks_i};

            assign next_a = leg_a;
            assign next_b = leg_b;
        end
    endgenerate

    always @(posedge clk) begin
        if (rst) begin
            leg_a_o <= 1'b0;
            leg_b_o <= 1'b0;
        end else begin
            leg_a_o <= next_a;
            leg_b_o <= next_b;
        end
    end

endmodule

`default_nettype wire
