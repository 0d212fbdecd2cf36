// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_three_phase: of a leg never both gates, and never one too soon after the other, whatever the
// voltages, the carrier, the settings, enable_i and reset do; both off a clock after reset or
// enable_i = 0. The dead time is any constant. Modulators and patterns are any (any_modulator.v,
// any_pwm.v): all levels in all orders, so those of every duty among them.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_three_phase #(
    parameter integer LEG = 0
) (
    input wire                                    clk,
    input wire                                    rst,
    input wire                                    enable,
    input wire        [`WH_TICK_W-1:0]            half_clocks,
    input wire        [`WH_TICK_W-1:0]            phase,
    input wire        [`WH_TICK_W-1:0]            remaining,
    input wire                                    half,
    input wire                                    update,
    input wire                                    take,
    input wire signed [`WH_COEF_W-1:0]            clocks_per_volt,
    input wire        [7:0]                       min_pulse,
    input wire                                    second_order,
    input wire                                    compensate,
    input wire signed [`WH_DATA_W-1:0]            side_current,
    input wire        [7:0]                       settle_ticks,
    input wire        [2:0]                       current_valid,
    input wire        [3*`WH_DATA_W-1:0]          currents,
    input wire                                    valid,
    input wire        [3*`WH_DATA_W-1:0]          legs,
    input wire        [2:0]                       grant,
    input wire        [2:0]                       done,
    input wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product
);

    (* anyconst *) wire [7:0] dead;

    wire [2:0] gate_high;
    wire [2:0] gate_low;

    wh_three_phase #(
        .MIN_PULSE         (1)
    ) block (
        .clk               (clk),
        .rst               (rst),
        .enable_i          (enable),
        .half_clocks_i     (half_clocks),
        .phase_i           (phase),
        .remaining_i       (remaining),
        .half_i            (half),
        .update_i          (update),
        .take_i            (take),
        .clocks_per_volt_i (clocks_per_volt),
        .min_pulse_i       (min_pulse),
        .dead_clocks_i     (dead),
        .second_order_i    (second_order),
        .compensate_i      (compensate),
        .side_current_i    (side_current),
        .settle_ticks_i    (settle_ticks),
        .current_valid_i   (current_valid),
        .currents_i        (currents),
        .valid_i           (valid),
        .legs_i            (legs),
        .request_o         (),
        .grant_i           (grant),
        .factor_o          (),
        .coefficient_o     (),
        .done_i            (done),
        .product_i         (product),
        .gate_high_o       (gate_high),
        .gate_low_o        (gate_low)
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
    reg       off_q;        // the last clock had reset or no enable
    reg [8:0] since_high;   // clocks without the gate, up to 256
    reg [8:0] since_low;

    always @(posedge clk) begin
        begun      <= 1'b1;
        off_q      <= rst || !enable;
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
