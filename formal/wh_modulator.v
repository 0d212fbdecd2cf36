// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_modulator: a width is within its limit, whatever the settings are, and 0 or least_i clocks at the
// least if that is no more than the limit; what it is off by is owed, to the last place, unless it was clipped;
// what is owed is bounded, and no sum of the error feedback wraps. The product may be any, at any clock.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_modulator #(
    parameter integer MIN_PULSE = 0
) (
    input wire                          clk,
    input wire                          rst,
    input wire                          done,
    input wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product,
    input wire signed [`WH_EXTRA_W-1:0] extra,
    input wire                          second_order,
    input wire                          take,
    input wire                          update
);

    localparam integer PRODUCT_W = `WH_DATA_W + `WH_COEF_W;
    localparam integer DUTY_W    = PRODUCT_W - `WH_VOLTAGE_Q;
    localparam integer FRACTION  = `WH_DUTY_Q;
    localparam integer REST_W    = FRACTION + ((MIN_PULSE != 0) ? 9 : 1);
    localparam integer OWED_W    = `WH_EXTRA_W + FRACTION - `WH_EXTRA_Q + ((MIN_PULSE != 0) ? 2 : 1);
    localparam integer TOTAL_W   = DUTY_W + 1;
    localparam integer W         = TOTAL_W + 4;

    (* anyconst *) wire [15:0] half_clocks;
    (* anyconst *) wire [7:0]  least_in;
    (* anyconst *) wire [7:0]  spare_in;

    wire signed [`WH_TICK_W-1:0] width;

    wh_modulator #(
        .MIN_PULSE         (MIN_PULSE)
    ) block (
        .clk               (clk),
        .rst               (rst),
        .valid_i           (1'b0),
        .voltage_i         ({`WH_DATA_W{1'b0}}),
        .clocks_per_volt_i ({`WH_COEF_W{1'b0}}),
        .half_clocks_i     (half_clocks),
        .second_order_i    (second_order),
        .extra_i           (extra),
        .least_i           (least_in),
        .spare_i           (spare_in),
        .request_o         (),
        .grant_i           (1'b0),
        .factor_o          (),
        .coefficient_o     (),
        .done_i            (done),
        .product_i         (product),
        .take_i            (take),
        .update_i          (update),
        .width_o           (width)
    );

    (* hierconn *) wire signed [REST_W:0]    \block.rests_q ;
    (* hierconn *) wire signed [REST_W-1:0]  \block.older_q ;
    (* hierconn *) wire signed [REST_W-1:0]  \block.next_rest_q ;
    (* hierconn *) wire signed [OWED_W-1:0]  \block.owed_q ;
    (* hierconn *) wire signed [TOTAL_W-1:0] \block.total_q ;
    (* hierconn *) wire signed [FRACTION:0]  \block.rest_q ;
    (* hierconn *) wire signed [DUTY_W-1:0]  \block.active_q ;
    (* hierconn *) wire                      \block.active_up_q ;

    wire signed [W-1:0] least  = (MIN_PULSE != 0) ? $signed({1'b0, least_in}) : 9'sd0;
    wire signed [W-1:0] spare  = (MIN_PULSE != 0) ? $signed({1'b0, spare_in}) : 9'sd0;
    wire signed [W-1:0] room   = $signed({1'b0, half_clocks[15:1]}) - spare;
    wire signed [W-1:0] limit  = (room < 0) ? 0 : room;
    wire signed [W-1:0] long_width = width;
    wire signed [W-1:0] rest   = \block.next_rest_q ;
    wire signed [W-1:0] older  = \block.older_q ;
    wire signed [W-1:0] rests  = \block.rests_q ;
    wire signed [W-1:0] owed   = \block.owed_q ;
    wire signed [W-1:0] total  = \block.total_q ;
    wire signed [W-1:0] active = \block.active_q ;
    wire signed [W-1:0] active_up = $signed({1'b0, \block.active_up_q });
    wire signed [W-1:0] extra_long = $signed(extra) <<< (FRACTION - `WH_EXTRA_Q);
    // Half a clock, or half of least_i and half a clock.
    wire signed [W-1:0] bound  = (least + 1) <<< (FRACTION - 1);
    wire signed [W-1:0] size   = (long_width < 0) ? -long_width : long_width;

    wire signed [W-1:0] fraction = \block.rest_q ;
    wire signed [W-1:0] half     = 1 <<< (FRACTION - 1);

    reg                begun = 1'b0;
    reg        [1:0]   age = 2'd0;   // clocks since reset, up to 3
    reg signed [W-1:0] total_q1, total_q2, rests_q1, extra_q1, owed_q1, active_q1;
    wire signed [W-1:0] off = total_q2 - (long_width <<< FRACTION);

    always @(posedge clk) begin
        age       <= rst ? 2'd0 : (age == 2'd3) ? 2'd3 : age + 2'd1;
        total_q1  <= total;
        total_q2  <= total_q1;
        rests_q1  <= rests;
        extra_q1  <= extra_long;
        owed_q1   <= owed;
        active_q1 <= active + active_up;

        assume (half_clocks >= 16'd6);
        // wh_dead_time's: 5/8 of the longest dead time.
        assume (extra <= 17'sd40960 && extra >= -17'sd40960);
        begun <= 1'b1;
        if (!begun) begin
            assume (rst);
            // No reset reaches it; every clock makes it so.
            assume (fraction <= half && fraction >= -half);
        end
        assert (!begun || (fraction <= half && fraction >= -half));

        if (age != 2'd0) begin
            assert (size <= limit);
            assert (rest <= bound && rest >= -bound);
            assert (older <= bound && older >= -bound);
            assert (rests <= 3 * bound && rests >= -3 * bound);
        end
        if (age == 2'd3) begin
            if (MIN_PULSE != 0 && limit >= least) assert (size == 0 || size >= least);
            // What it is off by is owed, unless the total was beyond the limit.
            assert (rest == off
                    || (rest == 0 && size == limit && ((off < 0) == (total_q2 < 0) || limit < least)
                        && ((total_q2 < 0) == (long_width < 0) || limit == 0)));
            // Sums are exact.
            assert (owed == rests_q1 + extra_q1);
            assert (total == active_q1 + owed_q1);
        end

        cover (age == 2'd3 && rest == off && off > 0 && width < 0 && rests < 0 && second_order);
        cover (age == 2'd3 && rest != off);
        cover (age == 2'd3 && update && rest < 0 && width > 0 && (size == least || MIN_PULSE == 0));
    end

endmodule

`default_nettype wire
