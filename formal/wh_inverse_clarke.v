// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_inverse_clarke: whatever the voltages and the product, what lies between two legs is what
// lies between the phases, which are alpha, side - alpha/2 and -side - alpha/2, the last two as the
// nearest words; the highest leg is as far up as the lowest is down, to a last place; nothing wraps;
// valid_o comes once, 8 clocks after valid_i, and the legs hold. Mode bmc from any state: the first
// clock is a reset.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_inverse_clarke (
    input wire                                    clk,
    input wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer PRODUCT_W = `WH_DATA_W + `WH_COEF_W;
    localparam integer COEF_Q = `WH_COEF_W - 2;

    (* anyconst *) wire signed [DATA_W-1:0] alpha;
    (* anyconst *) wire signed [DATA_W-1:0] beta;

    wire                request, valid;
    wire [3*DATA_W-1:0] legs;

    reg [3:0] clock = 4'd0;   // 0 is the reset's, 1 valid_i's

    wh_inverse_clarke block (
        .clk           (clk),
        .rst           (clock == 4'd0),
        .valid_i       (clock == 4'd1),
        .alpha_i       (alpha),
        .beta_i        (beta),
        .request_o     (request),
        .grant_i       (request),
        .factor_o      (),
        .coefficient_o (),
        .done_i        (clock == 4'd4),
        .product_i     (product),
        .valid_o       (valid),
        .legs_o        (legs)
    );

    // Wide enough that nothing here can wrap.
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

    reg  signed [PRODUCT_W:0] wide_product;
    wire signed [PRODUCT_W:0] wide_alpha = alpha;
    wire signed [PRODUCT_W:0] half    = cut(wide_alpha, 1);
    wire signed [PRODUCT_W:0] side    = cut(wide_product, COEF_Q);
    wire signed [PRODUCT_W:0] phase_b = nearest(side - half);
    wire signed [PRODUCT_W:0] phase_c = nearest(-side - half);
    wire signed [PRODUCT_W:0] a = $signed(legs[DATA_W-1:0]);
    wire signed [PRODUCT_W:0] b = $signed(legs[2*DATA_W-1:DATA_W]);
    wire signed [PRODUCT_W:0] c = $signed(legs[3*DATA_W-1:2*DATA_W]);

    wire signed [PRODUCT_W:0] b_or_c  = (phase_b > phase_c) ? phase_b : phase_c;
    wire signed [PRODUCT_W:0] highest = (wide_alpha > b_or_c) ? wide_alpha : b_or_c;
    wire signed [PRODUCT_W:0] c_or_b  = (phase_b > phase_c) ? phase_c : phase_b;
    wire signed [PRODUCT_W:0] lowest  = (wide_alpha > c_or_b) ? c_or_b : wide_alpha;
    wire signed [PRODUCT_W:0] common  = cut(highest + lowest, 1);
    wire signed [PRODUCT_W:0] tilt    = highest + lowest - common - common;

    // On the way: what z3 need not find again.
    (* hierconn *) wire [DATA_W-1:0] \block.b_q ;
    (* hierconn *) wire [DATA_W-1:0] \block.c_q ;
    (* hierconn *) wire [DATA_W-1:0] \block.highest_q ;
    (* hierconn *) wire [DATA_W-1:0] \block.lowest_q ;
    (* hierconn *) wire [DATA_W:0]   \block.ends_q ;

    wire signed [PRODUCT_W:0] b_q       = $signed(\block.b_q );
    wire signed [PRODUCT_W:0] c_q       = $signed(\block.c_q );
    wire signed [PRODUCT_W:0] highest_q = $signed(\block.highest_q );
    wire signed [PRODUCT_W:0] lowest_q  = $signed(\block.lowest_q );
    wire signed [PRODUCT_W:0] ends_q    = $signed(\block.ends_q );

    always @(posedge clk) begin
        clock <= clock + (clock != 4'd15);
        if (clock == 4'd4) wide_product <= product;

        if (clock != 4'd0) assert (request == (clock == 4'd1));
        if (clock != 4'd0) assert (valid == (clock == 4'd9));
        if (clock >= 4'd1 && clock <= 4'd8) assert (legs == 0);
        if (clock >= 4'd6 && clock <= 4'd8) assert (b_q == phase_b && c_q == phase_c);
        if (clock == 4'd7) assert (highest_q == highest && lowest_q == lowest);
        if (clock == 4'd8) assert (ends_q == highest + lowest);
        if (clock >= 4'd9) begin
            // The same integer off all three, so what lies between two is what lay between them.
            assert (a == wide_alpha - common);
            assert (b == phase_b - common);
            assert (c == phase_c - common);
            // The highest leg and the lowest together.
            assert (tilt <= one && tilt >= -one);
        end
        cover (valid && a > b && b > c && tilt == one);
        cover (valid && c > b && b > a && c == most - 1);
        cover (valid && phase_b == most && phase_c < -most);
    end

endmodule

`default_nettype wire
