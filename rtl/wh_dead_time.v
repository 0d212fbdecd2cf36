// SPDX-License-Identifier: Apache-2.0
//
// wh_dead_time: the extra half pulse width that compensates the bridge's dead time.
//
//   extra = side * (dead_clocks / 2)                   side: +1 or -1, the sign of the current
//   extra = side * (dead_clocks / 2) * 5/4             after a change of the side, see below
//   side changes when  side * current < threshold,  at least settle_ticks after its last change
//                      (-current as ~current)
//
// In a dead time the diodes hold a leg where the current drives it. Of the edges of wh_pwm's pulse one is late by the
// dead time, always the one that takes from the voltage along the current: dead_clocks in each half, half of it from
// each end of the pulse, at any voltage. So extra needs no gain and no bus voltage, and is exact.
//
// A current that reaches zero stays there: a leg floats in its dead time, and a shorter pulse has no effect. Dead time
// is friction, and like friction it holds what is at rest: near 0 A there is no current to read the side from. So this
// block tries both sides. After a change of the side, while the current is still below the threshold, the pulse is
// longer by a quarter more of the dead time, which starts a current on that side. Then the circuit has no friction, and
// what drives it makes the current grow, or brings it down to the threshold: then the other side is tried. If nothing
// drives it, the current stays just above the threshold on one side and the other in turn.
//
// The threshold has to exceed the error of the current (offset and half a step of the ADC), even after half a dead
// time's step of current, bus * dead time / (2 L), is subtracted from it. settle_ticks covers the ticks from a pulse to
// the current that shows it.
//
// Formats: below. Latency: 3 clocks from valid_i to extra_o. Reset, or compensate_i = 0: side +1 and extra 0.

`default_nettype none
`include "wh_formats.vh"

module wh_dead_time (
    input  wire                          clk,
    input  wire                          rst,

    input  wire                          compensate_i,
    input  wire        [7:0]             dead_clocks_i,   // clocks
    input  wire signed [`WH_DATA_W-1:0]  threshold_i,     // s31q24 A, 0...
    input  wire        [7:0]             settle_ticks_i,  // ticks

    input  wire                          valid_i,         // strobe
    input  wire signed [`WH_DATA_W-1:0]  current_i,       // s31q24 A

    output reg  signed [`WH_EXTRA_W-1:0] extra_o          // s17q8 clocks
);

    localparam integer DATA_W = `WH_DATA_W;

    reg       negative_q;
    reg       start_q;     // the side was taken lately, and its current isn't there yet
    reg [7:0] settle_q;    // ticks in which the side can't change

    // -current is taken as one place less, which only inverters cost.
    wire        [DATA_W-1:0] along   = current_i ^ {DATA_W{negative_q}};
    wire signed [DATA_W:0]   beyond  = $signed({along[DATA_W-1], along})
                                       - $signed({threshold_i[DATA_W-1], threshold_i});
    reg                      below_q;
    reg                      valid_q;
    wire                     settled = (settle_q == 8'd0);
    wire                     unused  = &{1'b0, beyond[DATA_W-1:0]};

    always @(posedge clk) begin
        below_q <= beyond[DATA_W];
        if (rst || !compensate_i) begin
            valid_q    <= 1'b0;
            negative_q <= 1'b0;
            start_q    <= 1'b0;
            settle_q   <= 8'd0;
        end else begin
            valid_q <= valid_i;
            if (valid_q) begin
                start_q <= below_q;
                if (below_q && settled) begin
                    negative_q <= !negative_q;
                    settle_q   <= settle_ticks_i;
                end else if (!settled) begin
                    settle_q   <= settle_q - 8'd1;
                end
            end
        end
    end

    wire signed [`WH_EXTRA_W-1:0] most  = $signed({2'b00, dead_clocks_i, {`WH_EXTRA_Q-1{1'b0}}});
    wire signed [`WH_EXTRA_W-1:0] extra = start_q ? most + (most >>> 2) : most;

    always @(posedge clk) begin
        if (rst || !compensate_i) begin
            extra_o <= {`WH_EXTRA_W{1'b0}};
        end else begin
            extra_o <= negative_q ? -extra : extra;
        end
    end

endmodule

`default_nettype wire
