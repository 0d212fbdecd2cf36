// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_half_bridge: never both gates, and never one too soon after the other, whatever the leg,
// enable_i and reset do. The dead time is any constant.

`default_nettype none

module prove_wh_half_bridge (
    input wire clk,
    input wire rst,
    input wire enable,
    input wire leg
);

    (* anyconst *) wire [7:0] dead;

    wire high;
    wire low;

    wh_half_bridge block (
        .clk           (clk),
        .rst           (rst),
        .enable_i      (enable),
        .leg_i         (leg),
        .dead_clocks_i (dead),
        .high_o        (high),
        .low_o         (low)
    );

    (* hierconn *) wire       \block.leg_q ;
    (* hierconn *) wire [7:0] \block.dead_q ;

    reg       begun = 1'b0;
    reg       off_q;        // the last clock had reset or no enable
    reg [8:0] since_high;   // clocks without the gate, up to 256
    reg [8:0] since_low;
    reg [8:0] held;         // clocks in which the leg was the same and enabled, up to 257

    always @(posedge clk) begin
        begun      <= 1'b1;
        off_q      <= rst || !enable;
        since_high <= high ? 9'd0 : since_high[8] ? 9'd256 : since_high + 9'd1;
        since_low  <= low ? 9'd0 : since_low[8] ? 9'd256 : since_low + 9'd1;
        held       <= (rst || !enable) ? 9'd0
                    : (leg != \block.leg_q ) ? 9'd1
                    : (held == 9'd257) ? 9'd257 : held + 9'd1;

        if (!begun) begin
            assume (rst);
            assume (!high && !low);
            assume (since_high == 9'd256 && since_low == 9'd256);
        end else begin
            assert (!(high && low));
            if (off_q) assert (!high && !low);
            if (high) assert (since_low >= {1'b0, dead});
            if (low) assert (since_high >= {1'b0, dead});
            // It is not late either.
            if (held > {1'b0, dead}) assert (\block.leg_q ? high : low);

            // What makes that inductive.
            assert (since_high <= 9'd256 && since_low <= 9'd256);
            assert (\block.dead_q <= dead);
            if (high) assert (\block.leg_q && \block.dead_q == 8'd0);
            if (low) assert (!\block.leg_q && \block.dead_q == 8'd0);
            if (!\block.leg_q ) assert ({1'b0, since_high} + 10'd1 + \block.dead_q >= {1'b0, dead});
            if (\block.leg_q ) assert ({1'b0, since_low} + 10'd1 + \block.dead_q >= {1'b0, dead});
            assert (\block.dead_q == 8'd0 || {1'b0, held} + \block.dead_q <= {2'b00, dead});
            assert (held <= 9'd257);
        end

        cover (begun && dead == 8'd3 && high && since_low == 9'd3 && !off_q);
        cover (begun && dead == 8'd3 && low && since_high == 9'd3);
        cover (begun && dead == 8'd0 && low && since_high == 9'd0);
        cover (begun && dead == 8'd2 && high && since_low == 9'd5 && held == 9'd3);
    end

endmodule

`default_nettype wire
