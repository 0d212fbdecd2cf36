// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_carrier: in every tick samples_i samples, the first marked; halves and ticks of the right
// length; take_o four clocks before tick_o. The settings are any small constants that the ports allow.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_carrier #(
    parameter integer BITS = 3  // of a setting
) (
    input wire clk,
    input wire rst
);

    (* anyconst *) wire        [BITS:0]   half;
    (* anyconst *) wire        [BITS-1:0] halves;
    (* anyconst *) wire        [BITS-1:0] gap;
    (* anyconst *) wire        [BITS-1:0] samples;
    (* anyconst *) wire signed [7:0]      lead;
    (* anyconst *) wire                   late;

    wire [`WH_TICK_W-1:0] phase, remaining;
    wire                  parity, update, take, tick, sample, first;

    wh_carrier block (
        .clk             (clk),
        .rst             (rst),
        .half_clocks_i   ({{(`WH_TICK_W - BITS - 1){1'b0}}, half}),
        .tick_halves_i   ({{(`WH_TICK_W - BITS){1'b0}}, halves}),
        .sample_clocks_i ({{(`WH_TICK_W - BITS){1'b0}}, gap}),
        .samples_i       ({{(9 - BITS){1'b0}}, samples}),
        .sample_lead_i   (lead),
        .sample_late_i   (late),
        .phase_o         (phase),
        .remaining_o     (remaining),
        .half_o          (parity),
        .update_o        (update),
        .take_o          (take),
        .tick_o          (tick),
        .sample_o        (sample),
        .sample_first_o  (first)
    );

    (* hierconn *) wire                  \block.running_q ;
    (* hierconn *) wire                  \block.odd_q ;
    (* hierconn *) wire                  \block.first_q ;
    (* hierconn *) wire [`WH_TICK_W-1:0] \block.halves_left_q ;
    (* hierconn *) wire [`WH_TICK_W-1:0] \block.wait_q ;
    (* hierconn *) wire [8:0]            \block.left_q ;
    (* hierconn *) wire                  \block.due_q ;

    wire signed [15:0] first_place = $signed({9'd0, gap}) / 2 - lead;
    wire        [15:0] length      = half * halves;

    reg        begun = 1'b0;
    reg [15:0] place;    // clocks since the tick's start
    reg [8:0]  seen;     // samples of this tick so far
    reg [15:0] last;     // place of the last of them
    reg [3:0]  takes;    // take_o of the last clocks

    wire [15:0] togo = \block.halves_left_q * half + remaining;

    always @(posedge clk) begin
        begun <= 1'b1;
        assume (half >= 6 && halves >= 1 && gap >= 2 && samples >= 1);
        assume (length >= samples * gap);
        // The sample that comes a clock later has to fit as well.
        assume (first_place >= 0 && first_place + $signed({15'd0, late}) < $signed({13'd0, gap}));
        if (!begun) assume (rst && !\block.running_q );
        takes <= \block.running_q ? {takes[2:0], take} : 4'd0;

        if (!\block.running_q || tick) begin
            place <= 16'd0;
            seen  <= 9'd0;
        end else begin
            place <= place + 16'd1;
            if (sample) begin
                seen <= seen + 9'd1;
                last <= place;
            end
        end

        if (!begun) begin
            // Any state.
        end else if (!\block.running_q ) begin
            assert (!update && !take && !tick && !sample);
        end else begin
            assert (phase + remaining + 1 == half && remaining < half && phase < half);
            assert (update == (remaining == 0));
            assert (tick == (place + 1 == length));
            if (tick) assert (seen + sample == samples);
            if (tick) assert (takes[3] && !takes[2] && !takes[1] && !takes[0] && !take);
            if (sample) begin
                assert (first == (seen == 0));
                if (seen == 0) assert (place == first_place + (late && \block.odd_q ));
                else assert (place == last + gap);
            end
            if (take) assert (place + 5 == length);

            // What makes that inductive.
            assert (\block.halves_left_q < halves);
            assert (place + 1 + togo == length && togo < length);
            assert (\block.left_q + seen == samples && seen <= samples);
            assert (\block.first_q == (seen == 0));
            assert (\block.due_q == (\block.wait_q == 0 && \block.left_q != 0));
            if (\block.left_q != 0) begin
                if (seen == 0) assert (place + \block.wait_q == first_place + (late && \block.odd_q )
                                       && \block.wait_q < gap);
                else assert (place + \block.wait_q == last + gap && \block.wait_q < gap);
                assert (place + \block.wait_q + 1 <= (seen + 1) * gap);
            end
            if (seen != 0) assert (last < place && last + 1 <= seen * gap);
            assert (take == (place + 5 == length));
            assert (takes[3] == (place + 1 == length));
            assert (takes[2] == (place + 2 == length));
            assert (takes[1] == (place + 3 == length));
            assert (takes[0] == (place + 4 == length));
        end

        cover (tick && samples == 3 && halves == 2 && late && \block.odd_q );
        cover (tick && sample);
        cover (tick && samples == 1 && halves == 3 && lead < 0);
    end

endmodule

`default_nettype wire
