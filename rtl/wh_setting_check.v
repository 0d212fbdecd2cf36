// SPDX-License-Identifier: Apache-2.0
//
// wh_setting_check: whether any setting is a word that no block has a meaning for.
//
//   half_clocks < 6, no halves, samples or clocks between them, odd halves where one width serves two
//   a outside (0, 1], |eta| > 1, and a root, a gain, clocks per volt or a limit that is not positive
//
// Formats: those of wh_controller's ports. Latency: 1 clock. Reset: nothing is wrong.

`default_nettype none
`include "wh_formats.vh"

module wh_setting_check #(
    parameter integer N = 1  // ports
) (
    input  wire                    clk,
    input  wire                    rst,
    input  wire [`WH_TICK_W-1:0]   half_clocks_i,
    input  wire [`WH_TICK_W-1:0]   tick_halves_i,
    input  wire [`WH_TICK_W-1:0]   sample_clocks_i,
    input  wire [8:0]              samples_i,
    input  wire                    whole_i,           // one width for both halves of a period
    input  wire [N*`WH_COEF_W-1:0] root_i,
    input  wire [N*`WH_COEF_W-1:0] a_i,
    input  wire [N*`WH_COEF_W-1:0] eta_contact_i,
    input  wire [N*`WH_COEF_W-1:0] eta_free_i,
    input  wire [N*`WH_COEF_W-1:0] gain_i,
    input  wire [N*`WH_COEF_W-1:0] clocks_per_volt_i,
    input  wire [N*`WH_DATA_W-1:0] u_max_i,
    output reg                     illegal_o
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

    // Whether a word of full scale +-2 is outside [-1, 1].
    function illegal_part;
        input [COEF_W-1:0] word;
        begin
            illegal_part = word[COEF_W-1] ? !word[COEF_W-2]
                                          : word[COEF_W-2] && |word[COEF_W-3:0];
        end
    endfunction

    function not_positive;
        input [COEF_W-1:0] word;
        begin
            not_positive = word[COEF_W-1] || word == 0;
        end
    endfunction

    reg     illegal;
    integer n;

    always @* begin
        illegal = half_clocks_i < 6 || tick_halves_i == 0 || sample_clocks_i < 2
                  || samples_i == 0 || samples_i > 256
                  || (whole_i && tick_halves_i[0]);
        for (n = 0; n < N; n = n + 1) begin
            illegal = illegal || illegal_part(a_i[n*COEF_W +: COEF_W])
                      || not_positive(a_i[n*COEF_W +: COEF_W])
                      || illegal_part(eta_contact_i[n*COEF_W +: COEF_W])
                      || illegal_part(eta_free_i[n*COEF_W +: COEF_W])
                      || not_positive(root_i[n*COEF_W +: COEF_W])
                      || not_positive(clocks_per_volt_i[n*COEF_W +: COEF_W])
                      || not_positive(gain_i[n*COEF_W +: COEF_W])
                      || u_max_i[n*DATA_W + DATA_W-1];
        end
    end

    always @(posedge clk) begin
        illegal_o <= !rst && illegal;
    end

endmodule

`default_nettype wire
