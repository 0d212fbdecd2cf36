// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_multiply: the product of the factors three clocks ago, if take_i was high one clock after
// them. Second, what any_multiply.v takes for granted of it.

`default_nettype none

module prove_wh_multiply #(
    parameter integer DATA_W = 7,
    parameter integer COEF_W = 7,
    parameter integer LIMB_W = 3
) (
    input wire                     clk,
    input wire                     take,
    input wire signed [DATA_W-1:0] data,
    input wire signed [COEF_W-1:0] coef
);

    localparam integer PRODUCT_W = DATA_W + COEF_W;
    localparam integer Q = COEF_W - 2;

    wire signed [PRODUCT_W-1:0] product;

    wh_multiply #(
        .DATA_W    (DATA_W),
        .COEF_W    (COEF_W),
        .LIMB_W    (LIMB_W)
    ) block (
        .clk       (clk),
        .take_i    (take),
        .data_i    (data),
        .coef_i    (coef),
        .product_o (product)
    );

    reg signed [DATA_W-1:0]    data_q1, data_q2, data_q3;
    reg signed [COEF_W-1:0]    coef_q1, coef_q2, coef_q3;
    reg                        take_q1, take_q2;
    reg signed [PRODUCT_W-1:0] product_q;
    reg [1:0]                  age = 2'd0;

    wire signed [PRODUCT_W:0] size    = product[PRODUCT_W-1] ? -product : product;
    wire signed [PRODUCT_W:0] data_3  = data_q3;
    wire signed [PRODUCT_W:0] at_most = ((data_3 < 0) ? -data_3 : data_3) <<< Q;
    wire                      within  = coef_q3 <= $signed({2'b01, {Q{1'b0}}})
                                        && coef_q3 >= -$signed({2'b01, {Q{1'b0}}});

    always @(posedge clk) begin
        {data_q3, data_q2, data_q1} <= {data_q2, data_q1, data};
        {coef_q3, coef_q2, coef_q1} <= {coef_q2, coef_q1, coef};
        {take_q2, take_q1} <= {take_q1, take};
        product_q <= product;
        age <= (age == 2'd3) ? 2'd3 : age + 2'd1;

        if (age == 2'd3) begin
            if (take_q2) begin
                assert (product == data_q3 * coef_q3);
                if (data_q3 == 0 || coef_q3 == 0) assert (product == 0);
                if (product > 0) assert (data_q3[DATA_W-1] == coef_q3[COEF_W-1]);
                if (product < 0) assert (data_q3[DATA_W-1] != coef_q3[COEF_W-1]);
                if (within) assert (size <= at_most);
            end
        end
        cover (age == 2'd3 && take_q2 && product < 0 && data_q3 > 0);
        cover (age == 2'd3 && take_q2 && data_q3 < 0 && coef_q3 < 0 && product > 0);
        cover (age == 2'd3 && !take_q2 && product != 0);
    end

endmodule

`default_nettype wire
