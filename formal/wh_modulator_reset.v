// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_modulator_reset: a reset of one clock, in any state, is as good as a long one: from then on the
// block is equal, in all that it shows and keeps, to a second one that was in reset long before.
// Settings are any constants, all other inputs do what they like. Mode prove, depth 11, z3; cover 18.

`default_nettype none
`include "wh_formats.vh"

// The block's parameters: Yosys' -chparam fails on a top with two copies of a block.
`ifndef PROVE_MIN_PULSE
`define PROVE_MIN_PULSE 0
`endif

module prove_wh_modulator_reset #(
    parameter integer MIN_PULSE = `PROVE_MIN_PULSE
) (
    input wire                                    clk,
    input wire                                    rst,
    input wire                                    valid,
    input wire signed [`WH_DATA_W-1:0]            voltage,
    input wire signed [`WH_EXTRA_W-1:0]           extra,
    input wire                                    grant,
    input wire                                    done,
    input wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product,
    input wire                                    take,
    input wire                                    update
);

    (* anyconst *) wire signed [`WH_COEF_W-1:0] clocks_per_volt;
    (* anyconst *) wire [`WH_TICK_W-1:0]        half_clocks;
    (* anyconst *) wire                         second_order;
    (* anyconst *) wire [7:0]                   least, spare;

    // The one with a short reset is in any state, the other has been in reset for LONG clocks.
    localparam [3:0] LONG = 4'd8;

    reg  [3:0] clocks = 4'd0;
    wire       compare = (clocks == LONG + 4'd1);
    wire [1:0] resets = {rst || clocks < LONG + 4'd1, rst || clocks == LONG};

    wire signed [`WH_TICK_W-1:0] width   [0:1];
    wire                         request [0:1];

    genvar n;
    generate
        for (n = 0; n < 2; n = n + 1) begin : copy
            wire signed [`WH_DATA_W-1:0] factor;
            wire signed [`WH_COEF_W-1:0] coefficient;

            wh_modulator #(
                .MIN_PULSE         (MIN_PULSE)
            ) block (
                .clk               (clk),
                .rst               (resets[n]),
                .valid_i           (valid),
                .voltage_i         (voltage),
                .clocks_per_volt_i (clocks_per_volt),
                .half_clocks_i     (half_clocks),
                .second_order_i    (second_order),
                .extra_i           (extra),
                .least_i           (least),
                .spare_i           (spare),
                .request_o         (request[n]),
                .grant_i           (grant),
                .factor_o          (factor),
                .coefficient_o     (coefficient),
                .done_i            (done),
                .product_i         (product),
                .take_i            (take),
                .update_i          (update),
                .width_o           (width[n])
            );
        end
    endgenerate

    // All that a copy keeps, with the widths of the block.
    localparam integer FRACTION = `WH_DUTY_Q;
    localparam integer DUTY_W   = `WH_DATA_W + `WH_COEF_W - `WH_VOLTAGE_Q;
    localparam integer REST_W   = FRACTION + ((MIN_PULSE != 0) ? 9 : 1);
    localparam integer OWED_W   = `WH_EXTRA_W + FRACTION - `WH_EXTRA_Q + ((MIN_PULSE != 0) ? 2 : 1);
    localparam integer TOTAL_W  = DUTY_W + 1;
    localparam integer ROUND_W  = TOTAL_W - FRACTION + 1;

    (* hierconn *) wire \copy[0].block.waiting_q ;
    (* hierconn *) wire \copy[1].block.waiting_q ;
    (* hierconn *) wire [DUTY_W-1:0] \copy[0].block.pending_q ;
    (* hierconn *) wire [DUTY_W-1:0] \copy[1].block.pending_q ;
    (* hierconn *) wire \copy[0].block.pending_up_q ;
    (* hierconn *) wire \copy[1].block.pending_up_q ;
    (* hierconn *) wire [DUTY_W-1:0] \copy[0].block.active_q ;
    (* hierconn *) wire [DUTY_W-1:0] \copy[1].block.active_q ;
    (* hierconn *) wire \copy[0].block.active_up_q ;
    (* hierconn *) wire \copy[1].block.active_up_q ;
    (* hierconn *) wire [OWED_W-1:0] \copy[0].block.owed_q ;
    (* hierconn *) wire [OWED_W-1:0] \copy[1].block.owed_q ;
    (* hierconn *) wire [TOTAL_W-1:0] \copy[0].block.total_q ;
    (* hierconn *) wire [TOTAL_W-1:0] \copy[1].block.total_q ;
    (* hierconn *) wire [ROUND_W-1:0] \copy[0].block.rounded_q ;
    (* hierconn *) wire [ROUND_W-1:0] \copy[1].block.rounded_q ;
    (* hierconn *) wire [FRACTION:0] \copy[0].block.rest_q ;
    (* hierconn *) wire [FRACTION:0] \copy[1].block.rest_q ;
    (* hierconn *) wire [REST_W-1:0] \copy[0].block.next_rest_q ;
    (* hierconn *) wire [REST_W-1:0] \copy[1].block.next_rest_q ;
    (* hierconn *) wire [REST_W:0] \copy[0].block.rests_q ;
    (* hierconn *) wire [REST_W:0] \copy[1].block.rests_q ;
    (* hierconn *) wire [REST_W-1:0] \copy[0].block.older_q ;
    (* hierconn *) wire [REST_W-1:0] \copy[1].block.older_q ;

    always @(posedge clk) begin
        clocks <= compare ? clocks : clocks + 4'd1;
        assert (clocks <= LONG + 4'd1);

        if (compare) begin
            assert (width[0] == width[1]);
            assert (request[0] == request[1]);

            // What makes that inductive.
            assert (\copy[0].block.waiting_q == \copy[1].block.waiting_q );
            assert (\copy[0].block.pending_q == \copy[1].block.pending_q );
            assert (\copy[0].block.pending_up_q == \copy[1].block.pending_up_q );
            assert (\copy[0].block.active_q == \copy[1].block.active_q );
            assert (\copy[0].block.active_up_q == \copy[1].block.active_up_q );
            assert (\copy[0].block.owed_q == \copy[1].block.owed_q );
            assert (\copy[0].block.total_q == \copy[1].block.total_q );
            assert (\copy[0].block.rounded_q == \copy[1].block.rounded_q );
            assert (\copy[0].block.rest_q == \copy[1].block.rest_q );
            assert (\copy[0].block.next_rest_q == \copy[1].block.next_rest_q );
            assert (\copy[0].block.rests_q == \copy[1].block.rests_q );
            assert (\copy[0].block.older_q == \copy[1].block.older_q );
        end

        cover (compare && width[0] == 16'sd5 && !rst);
    end

endmodule

`default_nettype wire
