// SPDX-License-Identifier: Apache-2.0
//
// wh_legs: from the voltages of a brushless motor's two axes, which come in turn, to the products of its three legs.
//
//   alpha, beta -> wh_inverse_clarke -> legs a, b, c;  product of leg x = leg x * scale_i
//
// The axes come with valid_i, beta's last. In clocks since beta's: 1, √3/2 beta is asked for; 9, 10, 11, and with W
// 20, 21, 22, the products of the legs a, b, c, by the scale of their step, which scale_i holds until then. Nobody
// else may ask in these clocks. Each is there three clocks later, with duty_valid_o for duty_leg_o.
// The legs a and b have the numbers of both ports, c that of third_i, which is taken with beta's valid_i.
// The next valid_i of an alpha may come 10 clocks after this, and that of a beta behind the last product.
// Formats: below. Latency: above. Reset: nothing is under way.

`default_nettype none
`include "wh_formats.vh"

module wh_legs #(
    parameter integer SHAPER = 0,  // sections of W, 0...2
    parameter integer LEG_W  = 2   // bits of a leg's number
) (
    input  wire                          clk,
    input  wire                          rst,

    // The axes.
    input  wire                          valid_i,       // strobe
    input  wire                          beta_i,        // with it: it is beta's
    input  wire [LEG_W-1:0]              port_i,        // of beta
    input  wire [LEG_W-1:0]              third_i,
    input  wire signed [`WH_DATA_W-1:0]  voltage_i,     // s31q23 V

    // The multiplier.
    output wire                          request_o,
    output wire signed [`WH_DATA_W-1:0]  factor_o,      // s31q23 V
    output wire signed [`WH_COEF_W-1:0]  coefficient_o, // s27q25, or the scale
    input  wire signed [`WH_COEF_W-1:0]  scale_i,       // s27q16 clocks/V
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i,  // 3 clocks after request_o

    output wire                          duty_valid_o,  // strobe, product_i is a leg's
    output wire [LEG_W-1:0]              duty_leg_o
);

    localparam integer DATA_W  = `WH_DATA_W;
    localparam integer COEF_W  = `WH_COEF_W;
    localparam integer PRODUCT = 3;                          // clocks of a product
    localparam integer GIVE    = 1;                          // beta
    localparam integer GIVE_A  = (SHAPER > 0) ? 20 : 9;      // leg a
    localparam integer ENDS    = GIVE_A + 2 + PRODUCT;

    generate
        if (SHAPER < 0 || SHAPER > 2) begin : illegal
            wh_illegal_parameter_legs_shaper_must_be_0_to_2 stop ();
        end
    endgenerate

    reg [ENDS:1]             at_q;  // at_q[n]: clock n since beta's
    reg [LEG_W-1:0]          port_q;
    reg [LEG_W-1:0]          third_q;
    reg signed [DATA_W-1:0]  alpha_q;
    reg signed [DATA_W-1:0]  beta_q;

    always @(posedge clk) begin
        at_q <= rst ? {ENDS{1'b0}} : {at_q[ENDS-1:1], valid_i && beta_i};
        if (valid_i && beta_i) begin
            beta_q  <= voltage_i;
            port_q  <= port_i;
            third_q <= third_i;
        end else if (valid_i) begin
            alpha_q <= voltage_i;
        end
    end

    wire                     transform_request;
    wire signed [DATA_W-1:0] transform_factor;
    wire signed [COEF_W-1:0] transform_coefficient;
    wire                     legs_valid;
    wire [3*DATA_W-1:0]      legs;
    wire                     unused = &{1'b0, transform_request, legs_valid};

    wh_inverse_clarke inverse_clarke (
        .clk           (clk),
        .rst           (rst),
        .valid_i       (at_q[GIVE]),
        .alpha_i       (alpha_q),
        .beta_i        (beta_q),
        .request_o     (transform_request),
        .grant_i       (at_q[GIVE]),
        .factor_o      (transform_factor),
        .coefficient_o (transform_coefficient),
        .done_i        (at_q[GIVE+PRODUCT]),
        .product_i     (product_i),
        .valid_o       (legs_valid),
        .legs_o        (legs)
    );

    assign request_o     = at_q[GIVE] || (|at_q[GIVE_A+2:GIVE_A]);
    assign factor_o      = at_q[GIVE]       ? transform_factor
                           : at_q[GIVE_A]   ? $signed(legs[DATA_W-1:0])
                           : at_q[GIVE_A+1] ? $signed(legs[2*DATA_W-1:DATA_W])
                                            : $signed(legs[3*DATA_W-1:2*DATA_W]);
    assign coefficient_o = at_q[GIVE] ? transform_coefficient : scale_i;

    assign duty_valid_o  = |at_q[ENDS:ENDS-2];
    assign duty_leg_o    = at_q[ENDS] ? third_q : at_q[ENDS-1] ? port_q : port_q - 1'b1;

endmodule

`default_nettype wire
