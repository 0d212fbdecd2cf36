// SPDX-License-Identifier: Apache-2.0
//
// wh_multiply: signed multiplier, one product a clock, out of multipliers that every FPGA has.
//
//   product_o = data_i * coef_i,   3 clocks later, if take_i is 1 in the clock after them
//
// While take_i is 0 the product stays. A user that needs no such patience holds it at 1 while there
// is work: the iCE40's multiplier has a register with an enable at its output, and one without in
// its middle, before a last sum. Yosys takes the former where there is an enable, which saves 3 ns.
//
// A word longer than LIMB_W + 1 bits is split as word = high * 2^LIMB_W + low, with low >= 0 made
// signed by a leading zero, so that each partial product is signed times signed:
//
//   product = (dh ch) 2^(2 LIMB_W) + (dh cl + dl ch) 2^LIMB_W + dl cl
//
// With LIMB_W = 15 each fits one SB_MAC16 (16 x 16) of the iCE40 or one MULT18X18D of the ECP5.
// Formats: s<DATA_W> x s<COEF_W> -> s<DATA_W + COEF_W>; the binary points add. Nothing is lost.
// Latency: 3 clocks: operands, partial products, sum. No register has a reset, so that the FPGA's
// multipliers can absorb the operands and the partial products.

`default_nettype none
`include "wh_formats.vh"

module wh_multiply #(
    parameter integer DATA_W = `WH_DATA_W,  // 2...2 LIMB_W + 1
    parameter integer COEF_W = `WH_COEF_W,  // 2...2 LIMB_W + 1
    parameter integer LIMB_W = `WH_LIMB_W   // 1...
) (
    input wire clk,

    input  wire                            take_i,    // the last clock's operands count
    input  wire signed [DATA_W-1:0]        data_i,
    input  wire signed [COEF_W-1:0]        coef_i,
    output reg  signed [DATA_W+COEF_W-1:0] product_o
);

    generate
        if (LIMB_W < 1 || DATA_W < 2 || DATA_W > 2 * LIMB_W + 1
                       || COEF_W < 2 || COEF_W > 2 * LIMB_W + 1) begin : illegal
            wh_illegal_parameter_multiply_widths stop ();
        end
    endgenerate

    localparam integer PRODUCT_W = DATA_W + COEF_W;
    localparam integer SPLIT_DATA = (DATA_W > LIMB_W + 1) ? 1 : 0;
    localparam integer SPLIT_COEF = (COEF_W > LIMB_W + 1) ? 1 : 0;

    generate
        if (SPLIT_DATA == 1 && SPLIT_COEF == 1) begin : four_products
            localparam integer DATA_HIGH_W = DATA_W - LIMB_W;
            localparam integer COEF_HIGH_W = COEF_W - LIMB_W;
            // One factor has no sign: the leading zero of its limb is not in the product.
            localparam integer DH_CL_W     = DATA_HIGH_W + LIMB_W;
            localparam integer DL_CH_W     = COEF_HIGH_W + LIMB_W;

            reg signed [DATA_HIGH_W-1:0] dh_q;
            reg signed [COEF_HIGH_W-1:0] ch_q;
            reg signed [LIMB_W:0]        dl_q;
            reg signed [LIMB_W:0]        cl_q;

            // dh ch without its highest bit, which is the next one's copy but for the most negative
            // of both. Where a coefficient's sign is known to be 0 Yosys makes the product a bit
            // narrower, and ice40_dsp loses that bit of a register as wide as the whole product.
            reg signed [DATA_HIGH_W+COEF_HIGH_W-2:0] dh_ch_q;
            reg                                      most_q;
            reg signed [DH_CL_W-1:0]                 dh_cl_q;
            reg signed [DL_CH_W-1:0]                 dl_ch_q;
            reg signed [2*LIMB_W+1:0]                dl_cl_q;

            // dl cl >= 0 has 2 LIMB_W bits and fits below dh ch without a sum.
            wire unused = &{1'b0, dl_cl_q[2*LIMB_W+1:2*LIMB_W]};

            // By the factors, as a block's product is not seen before its register.
            wire most = dh_q[DATA_HIGH_W-1] && !(|dh_q[DATA_HIGH_W-2:0])
                     && ch_q[COEF_HIGH_W-1] && !(|ch_q[COEF_HIGH_W-2:0]);

            wire signed [DATA_HIGH_W+COEF_HIGH_W-1:0] dh_ch = dh_q * ch_q;
            wire unused_copy = &{1'b0, dh_ch[DATA_HIGH_W+COEF_HIGH_W-1]};

            wire highest = dh_ch_q[DATA_HIGH_W+COEF_HIGH_W-2] && !most_q;

            always @(posedge clk) begin
                dh_q <= $signed(data_i[DATA_W-1:LIMB_W]);
                dl_q <= $signed({1'b0, data_i[LIMB_W-1:0]});
                ch_q <= $signed(coef_i[COEF_W-1:LIMB_W]);
                cl_q <= $signed({1'b0, coef_i[LIMB_W-1:0]});

                if (take_i) begin
                    dh_ch_q <= dh_ch[DATA_HIGH_W+COEF_HIGH_W-2:0];
                    most_q  <= most;
                    dh_cl_q <= dh_q * cl_q;
                    dl_ch_q <= dl_q * ch_q;
                    dl_cl_q <= dl_q * cl_q;
                end

                // In this order no sum is of two products alone: Yosys' ice40_dsp would take the
                // registers of both for one multiplier, and lose the other.
                product_o <= $signed({highest, dh_ch_q, dl_cl_q[2*LIMB_W-1:0]})
                           + $signed({{(PRODUCT_W - DH_CL_W - LIMB_W){dh_cl_q[DH_CL_W-1]}},
                                      dh_cl_q, {LIMB_W{1'b0}}})
                           + $signed({{(PRODUCT_W - DL_CH_W - LIMB_W){dl_ch_q[DL_CH_W-1]}},
                                      dl_ch_q, {LIMB_W{1'b0}}});
            end
        end else if (SPLIT_DATA == 1 || SPLIT_COEF == 1) begin : two_products
            // The shorter factor is one limb, whichever it is.
            localparam integer LONG_W  = (SPLIT_DATA == 1) ? DATA_W : COEF_W;
            localparam integer SHORT_W = PRODUCT_W - LONG_W;
            localparam integer HIGH_W  = LONG_W - LIMB_W;

            wire signed [LONG_W-1:0]  long_word;
            wire signed [SHORT_W-1:0] short_word;
            if (SPLIT_DATA == 1) begin : long_data
                assign long_word  = data_i;
                assign short_word = coef_i;
            end else begin : long_coef
                assign long_word  = coef_i;
                assign short_word = data_i;
            end

            reg signed [HIGH_W-1:0]         high_q;
            reg signed [LIMB_W:0]           low_q;
            reg signed [SHORT_W-1:0]        short_q;
            reg signed [HIGH_W+SHORT_W-1:0] high_short_q;
            reg signed [LIMB_W+SHORT_W:0]   low_short_q;

            always @(posedge clk) begin
                high_q  <= $signed(long_word[LONG_W-1:LIMB_W]);
                low_q   <= $signed({1'b0, long_word[LIMB_W-1:0]});
                short_q <= short_word;

                if (take_i) begin
                    high_short_q <= high_q * short_q;
                    low_short_q  <= low_q * short_q;
                end

                product_o <= $signed({high_short_q, {LIMB_W{1'b0}}})
                           + $signed({{(HIGH_W - 1){low_short_q[LIMB_W+SHORT_W]}}, low_short_q});
            end
        end else begin : one_product
            reg signed [DATA_W-1:0]    data_q;
            reg signed [COEF_W-1:0]    coef_q;
            reg signed [PRODUCT_W-1:0] data_coef_q;

            always @(posedge clk) begin
                data_q      <= data_i;
                coef_q      <= coef_i;
                product_o   <= data_coef_q;
                if (take_i) begin
                    data_coef_q <= data_q * coef_q;
                end
            end
        end
    endgenerate

endmodule

`default_nettype wire
