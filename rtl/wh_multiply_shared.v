// SPDX-License-Identifier: Apache-2.0
//
// wh_multiply_shared: one pipelined multiplier for several users.
//
//   product_o = data_i[n] * coef_i[n] of the user that was granted 3 clocks ago
//
// A user holds request_i[n] and its operands until grant_o[n]; the lowest user that asks is granted
// in the same clock. done_o[n] says that product_o is this user's.
// A user that asks once in USERS clocks or less often waits USERS - 1 clocks at most.
// drop_i[n] is for a user that has a reset of its own: what it was granted before and what it is
// granted meanwhile never shows as done, from the clock after the first one of drop_i on.
// Formats: whatever the users agree on; the product has every bit. Latency: 3 clocks from grant_o
// to done_o. Reset: products under way are forgotten.

`default_nettype none
`include "wh_formats.vh"

module wh_multiply_shared #(
    parameter integer USERS = 2  // 1...
) (
    input  wire                                    clk,
    input  wire                                    rst,

    input  wire [USERS-1:0]                        drop_i,
    input  wire [USERS-1:0]                        request_i,
    input  wire [USERS*`WH_DATA_W-1:0]             data_i,     // user 0 lowest
    input  wire [USERS*`WH_COEF_W-1:0]             coef_i,     // user 0 lowest
    output wire [USERS-1:0]                        grant_o,

    output wire [USERS-1:0]                        done_o,     // strobe
    output wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_o
);

    localparam integer LATENCY = 3;  // of wh_multiply

    generate
        if (USERS < 1) begin : illegal
            wh_illegal_parameter_multiply_shared_users_must_be_1_or_more stop ();
        end
    endgenerate

    // The lowest bit that is set, by what is below each: a difference would be a carry chain, which is
    // slower than the few gates.
    genvar user;
    generate
        for (user = 0; user < USERS; user = user + 1) begin : turn
            if (user == 0) begin : first
                assign grant_o[user] = request_i[user];
            end else begin : later
                assign grant_o[user] = request_i[user] && !(|request_i[user-1:0]);
            end
        end
    endgenerate

    reg [`WH_DATA_W-1:0] data;
    reg [`WH_COEF_W-1:0] coef;

    integer n;

    // The last user's, where no other asks: what it takes to know that it asks delays no operand.
    always @* begin
        data = data_i[(USERS-1)*`WH_DATA_W +: `WH_DATA_W];
        coef = coef_i[(USERS-1)*`WH_COEF_W +: `WH_COEF_W];
        for (n = USERS - 2; n >= 0; n = n - 1) begin
            if (request_i[n]) begin
                data = data_i[n*`WH_DATA_W +: `WH_DATA_W];
                coef = coef_i[n*`WH_COEF_W +: `WH_COEF_W];
            end
        end
    end

    reg [LATENCY*USERS-1:0] owner_q;

    wh_multiply multiply (
        .clk       (clk),
        .take_i    (|owner_q[USERS-1:0]),
        .data_i    (data),
        .coef_i    (coef),
        .product_o (product_o)
    );

    always @(posedge clk) begin
        if (rst) begin
            owner_q <= {LATENCY*USERS{1'b0}};
        end else begin
            owner_q <= {owner_q[(LATENCY-1)*USERS-1:0], grant_o} & ~{LATENCY{drop_i}};
        end
    end

    assign done_o = owner_q[LATENCY*USERS-1 -: USERS];

endmodule

`default_nettype wire
