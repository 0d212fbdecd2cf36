// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_clarke: whatever the currents and the product, beta's factor is (a + 2 b) / 2 toward zero
// and beta the product without its fraction, each the nearest word; alpha is a; valid_o comes once,
// 7 clocks after valid_i. Mode bmc from any state, in which no transform need be at rest: the first
// clock is a reset.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_clarke (
    input wire                                    clk,
    input wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer PRODUCT_W = `WH_DATA_W + `WH_COEF_W;
    localparam integer COEF_Q = `WH_COEF_W - 2;

    (* anyconst *) wire signed [DATA_W-1:0] a;
    (* anyconst *) wire signed [DATA_W-1:0] b;

    wire                     request, valid;
    wire signed [DATA_W-1:0] factor, alpha, beta;
    wire [1:0]               beta_ends;

    reg [3:0] clock = 4'd0;   // 0 is the reset's, 1 valid_i's

    wh_clarke block (
        .clk           (clk),
        .rst           (clock == 4'd0),
        .valid_i       (clock == 4'd1),
        .a_i           (a),
        .b_i           (b),
        .request_o     (request),
        .grant_i       (request),
        .factor_o      (factor),
        .coefficient_o (),
        .done_i        (clock == 4'd6),
        .product_i     (product),
        .valid_o       (valid),
        .alpha_o       (alpha),
        .beta_o        (beta),
        .beta_ends_o   (beta_ends)
    );

    // Toward zero by sizes, then the nearest word; wide enough that nothing here can wrap.
    function signed [PRODUCT_W:0] cut(input signed [PRODUCT_W:0] value, input integer places);
        reg signed [PRODUCT_W:0] size;
        begin
            size = value[PRODUCT_W] ? -value : value;
            size = size >>> places;
            cut  = value[PRODUCT_W] ? -size : size;
        end
    endfunction

    wire signed [PRODUCT_W:0] one  = 1;
    wire signed [PRODUCT_W:0] most = (one <<< (DATA_W - 1)) - one;

    function signed [PRODUCT_W:0] nearest(input signed [PRODUCT_W:0] value);
        nearest = (value > most) ? most : (value < -most - one) ? -most - one : value;
    endfunction

    wire signed [PRODUCT_W:0] sum = a + (b + b);
    reg  signed [PRODUCT_W:0] wide_product;

    always @(posedge clk) begin
        clock <= clock + (clock != 4'd15);
        if (clock == 4'd6) wide_product <= product;

        if (clock != 4'd0) assert (request == (clock == 4'd3));
        if (clock != 4'd0) assert (valid == (clock == 4'd8));
        if (clock == 4'd3) assert (factor == nearest(cut(sum, 1)));
        if (clock == 4'd8 || clock == 4'd9) begin
            assert (alpha == a);
            assert (beta == nearest(cut(wide_product, COEF_Q)));
            assert (beta_ends == {beta == -most - one, beta == most});
        end
        cover (clock == 4'd8 && valid && beta == most);
        cover (clock == 4'd8 && valid && beta == -3 && factor == -5);
    end

endmodule

`default_nettype wire
