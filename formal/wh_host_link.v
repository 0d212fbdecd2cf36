// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_host_link: the budget pays for every u. Beside the block runs an account without a limit:
// + v_mean^2 where that is paid in, - u^2 for every period with u. The budget is never above it, so it
// never goes below zero. The host's packets come when they like, and the periods, which last as long
// as the port asks for, end when they like.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_host_link (
    input wire                         clk,
    input wire                         rst,
    input wire                         valid,
    input wire signed [`WH_DATA_W-1:0] v,
    input wire                         answer,
    input wire        [7:0]            sequence_in,
    input wire signed [`WH_DATA_W-1:0] u_in
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer TANK_W = 2 * DATA_W;
    localparam integer LAST   = DATA_W + 1;
    localparam integer W      = TANK_W + 6;

    (* anyconst *) wire [7:0] timeout;

    wire                     active, strobe;
    wire [7:0]               sequence_out;
    wire signed [DATA_W-1:0] u, v_mean;

    wh_host_link block (
        .clk           (clk),
        .rst           (rst),
        .period_log2_i (4'd0),
        .timeout_i     (timeout),
        .valid_i       (valid),
        .v_i           (v),
        .active_o      (active),
        .u_o           (u),
        .strobe_o      (strobe),
        .sequence_o    (sequence_out),
        .v_mean_o      (v_mean),
        .strobe_i      (answer),
        .sequence_i    (sequence_in),
        .u_i           (u_in)
    );

    (* hierconn *) wire              \block.ends ;
    (* hierconn *) wire              \block.mean_q ;
    (* hierconn *) wire              \block.negate_q ;
    (* hierconn *) wire              \block.shifting_q ;
    (* hierconn *) wire              \block.done ;
    (* hierconn *) wire              \block.settled ;
    (* hierconn *) wire              \block.next_active ;
    (* hierconn *) wire              \block.square_q ;
    (* hierconn *) wire              \block.of_mean_q ;
    (* hierconn *) wire              \block.answer_q ;
    (* hierconn *) wire              \block.credit_q ;
    (* hierconn *) wire              \block.waiting_q ;
    (* hierconn *) wire              \block.counts ;
    (* hierconn *) wire [5:0]        \block.step_q ;
    (* hierconn *) wire [DATA_W-1:0] \block.factor_q ;
    (* hierconn *) wire [DATA_W-1:0] \block.high_q ;
    (* hierconn *) wire [DATA_W-1:0] \block.low_q ;
    (* hierconn *) wire [DATA_W-1:0] \block.magnitude_q ;
    (* hierconn *) wire [DATA_W-1:0] \block.answer_magnitude_q ;
    (* hierconn *) wire [TANK_W-1:0] \block.tank_q ;
    (* hierconn *) wire [TANK_W-1:0] \block.cost_q ;
    (* hierconn *) wire [DATA_W+15:0] \block.shift_q ;
    (* hierconn *) wire [TANK_W-1:0] \block.square ;

    reg                begun = 1'b0;
    reg         [4:0]  since;         // clocks in this period
    reg  [W-1:0]       account;
    reg                paid_q;        // this period's mean is in the account
    reg [DATA_W-1:0]   mean_was;
    wire [W-1:0]       mean_squared   = mean_was * mean_was;
    wire signed [W-1:0] u_next        = \block.settled && \block.next_active ? \block.magnitude_q : 0;
    wire [W-1:0]       tank           = \block.tank_q ;
    wire [W-1:0]       magnitude      = \block.magnitude_q ;
    wire [W-1:0]       cost           = \block.cost_q ;
    wire [W-1:0]       factor         = \block.factor_q ;

    // What the square's adder has come to so far: the factor times its lowest step bits.
    wire [3:0]         so_far         = \block.step_q - 6'd1;
    wire [W-1:0]       part           = {\block.high_q , \block.low_q } >> (LAST - 1 - so_far);
    wire [W-1:0]       bits           = factor & ((1 << so_far) - 1);

    always @(posedge clk) begin
        begun <= 1'b1;
        since <= (rst || \block.ends ) ? 5'd0 : (since == 5'd31) ? 5'd31 : since + 5'd1;
        // A period is longer than what is done in it (150 clocks of 31-bit words).
        assume (!valid || since >= 5'd3 + LAST);
        if (!begun) assume (rst);

        if (\block.mean_q ) mean_was <= \block.shift_q [DATA_W-1:0];
        if (rst || \block.ends && !\block.next_active ) begin
            account <= {W{1'b0}};
        end else if (\block.ends ) begin
            account <= account - u_next * u_next;
        end else if (\block.done && \block.of_mean_q && \block.credit_q && account < (1 << (TANK_W + 2))) begin
            account <= account + mean_squared;
        end

        if (begun) begin
            // The budget is the account's, or less where it was full.
            assert (tank <= account);
            // So what is taken from it is there.
            if (\block.ends && \block.next_active ) assert (u_next * u_next <= tank);
            if (!active) assert (u == 0);

            // What makes that inductive.
            assert (cost >= magnitude * magnitude);
            assert (account < (1 << (TANK_W + 3)));
            assert (!\block.of_mean_q || \block.square_q );
            if (\block.square_q ) begin
                assert (\block.step_q >= 6'd1 && \block.step_q <= LAST);
                assert (part == factor * bits);
                if (so_far < DATA_W) begin
                    assert ((\block.low_q & ((1 << (DATA_W - so_far)) - 1)) == (factor >> so_far));
                end
                assert (\block.factor_q == (\block.of_mean_q ? mean_was : \block.answer_magnitude_q ));
            end
        end

        cover (begun && active && u > 0 && account == 0);
        cover (begun && active && u == -2);
        cover (begun && \block.ends && \block.settled && !\block.next_active && active);
    end

endmodule

`default_nettype wire
