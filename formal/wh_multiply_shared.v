// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_multiply_shared: one grant at most, to the lowest that asks; done_o three clocks after a
// grant, unless there was rst or that user's drop_i in the grant's clock or later, and else never.
// Mode prove, depth 5, z3; cover 8.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_multiply_shared #(
    parameter integer USERS = 6
) (
    input wire                         clk,
    input wire                         rst,
    input wire [USERS-1:0]             drop,
    input wire [USERS-1:0]             request,
    input wire [USERS*`WH_DATA_W-1:0]  data,
    input wire [USERS*`WH_COEF_W-1:0]  coef
);

    (* anyconst *) wire [2:0] user;

    wire [USERS-1:0]                        grant, done;
    wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product;

    wh_multiply_shared #(
        .USERS     (USERS)
    ) block (
        .clk       (clk),
        .rst       (rst),
        .drop_i    (drop),
        .request_i (request),
        .data_i    (data),
        .coef_i    (coef),
        .grant_o   (grant),
        .done_o    (done),
        .product_o (product)
    );

    reg       begun = 1'b0;
    reg [2:0] due;   // the user's products: granted, and forgotten by nobody

    wire      forgets = rst || drop[user];

    integer n;

    always @(posedge clk) begin
        begun <= 1'b1;
        due   <= forgets ? 3'd0 : {due[1:0], grant[user]};

        assume (user < USERS);
        if (!begun) begin
            assume (rst);
        end else begin
            assert (done[user] == due[2]);
            assert ((done & (done - 1'b1)) == 0);
        end
        assert ((grant & ~request) == 0 && (grant & (grant - 1'b1)) == 0);
        assert (grant != 0 || request == 0);
        for (n = 1; n < USERS; n = n + 1) begin
            if (grant[n]) assert ((request & ((1 << n) - 1)) == 0);
        end

        cover (begun && user == 2 && due == 3'b111 && done[2]);
        cover (begun && user == 1 && due == 3'b000 && drop[1] && grant[1] && done[3]);
    end

endmodule

`default_nettype wire
