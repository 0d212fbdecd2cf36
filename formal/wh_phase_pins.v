// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_phase_pins: of a leg never both gates, and never one too soon after the other, whatever the widths, the
// carrier, run_i and reset do; both off a clock after reset or run_i = 0. The dead time is any constant. The patterns
// are any (any_pwm.v): all levels in all orders, so those of every duty among them.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_phase_pins #(
    parameter integer LEG = 0
) (
    input wire                         clk,
    input wire                         rst,
    input wire                         run,
    input wire                         enc_a,
    input wire                         enc_b,
    input wire [3:0]                   filter_clocks,
    input wire                         clear,
    input wire [`WH_TICK_W-1:0]        half_clocks,
    input wire [`WH_TICK_W-1:0]        phase,
    input wire [`WH_TICK_W-1:0]        remaining,
    input wire                         half,
    input wire                         update,
    input wire [2:0]                   width_valid,
    input wire signed [`WH_TICK_W-1:0] width
);

    (* anyconst *) wire [7:0] dead;

    wire [2:0] gate_high;
    wire [2:0] gate_low;

    wh_phase_pins block (
        .clk             (clk),
        .rst             (rst),
        .run_i           (run),
        .enc_a_i         (enc_a),
        .enc_b_i         (enc_b),
        .gate_high_o     (gate_high),
        .gate_low_o      (gate_low),
        .filter_clocks_i (filter_clocks),
        .clear_i         (clear),
        .position_o      (),
        .moved_o         (),
        .direction_o     (),
        .illegal_move_o  (),
        .encoder_fault_o (),
        .phase_i         (phase),
        .remaining_i     (remaining),
        .half_i          (half),
        .update_i        (update),
        .width_valid_i   (width_valid),
        .width_i         (width),
        .half_clocks_i   (half_clocks),
        .dead_clocks_i   (dead)
    );

    // One leg a proof: three together are the same three times over, and take z3 thirty times as long.
    (* hierconn *) wire       \block.leg[0].half_bridge.leg_q ;
    (* hierconn *) wire       \block.leg[1].half_bridge.leg_q ;
    (* hierconn *) wire       \block.leg[2].half_bridge.leg_q ;
    (* hierconn *) wire [7:0] \block.leg[0].half_bridge.dead_q ;
    (* hierconn *) wire [7:0] \block.leg[1].half_bridge.dead_q ;
    (* hierconn *) wire [7:0] \block.leg[2].half_bridge.dead_q ;

    wire       leg_q  = LEG == 0 ? \block.leg[0].half_bridge.leg_q
                      : LEG == 1 ? \block.leg[1].half_bridge.leg_q
                                 : \block.leg[2].half_bridge.leg_q ;
    wire [7:0] dead_q = LEG == 0 ? \block.leg[0].half_bridge.dead_q
                      : LEG == 1 ? \block.leg[1].half_bridge.dead_q
                                 : \block.leg[2].half_bridge.dead_q ;
    wire       high   = gate_high[LEG];
    wire       low    = gate_low[LEG];

    reg       begun = 1'b0;
    reg       off_q;        // the last clock had reset or no run
    reg [8:0] since_high;   // clocks without the gate, up to 256
    reg [8:0] since_low;

    always @(posedge clk) begin
        begun      <= 1'b1;
        off_q      <= rst || !run;
        since_high <= high ? 9'd0 : since_high[8] ? 9'd256 : since_high + 9'd1;
        since_low  <= low ? 9'd0 : since_low[8] ? 9'd256 : since_low + 9'd1;

        if (!begun) begin
            assume (rst);
            assume (!high && !low);
            assume (since_high == 9'd256 && since_low == 9'd256);
        end else begin
            assert (!(high && low));
            if (off_q) assert (!high && !low);
            if (high) assert (since_low >= {1'b0, dead});
            if (low) assert (since_high >= {1'b0, dead});

            // What makes that inductive.
            assert (since_high <= 9'd256 && since_low <= 9'd256);
            assert (dead_q <= dead);
            if (high) assert (leg_q && dead_q == 8'd0);
            if (low) assert (!leg_q && dead_q == 8'd0);
            if (!leg_q) assert ({1'b0, since_high} + 10'd1 + dead_q >= {1'b0, dead});
            if (leg_q) assert ({1'b0, since_low} + 10'd1 + dead_q >= {1'b0, dead});
        end

        cover (begun && dead == 8'd3 && gate_high == 3'b111);
        cover (begun && dead == 8'd2 && gate_low == 3'b101 && gate_high == 3'b010);
        cover (begun && dead == 8'd2 && low && since_high == 9'd2);
    end

endmodule

`default_nettype wire
