// SPDX-License-Identifier: Apache-2.0
//
// wh_setting_check: whether any setting is a word that no block has a meaning for.
//
//   half_clocks < 6, no halves, samples or clocks between them, odd halves where one width serves two
//   a first sample before its tick or sample_clocks behind its start or later
//   no room for a pulse:                  half_clocks / 2 < spare + max(least, 1)
//   gates that never go on:               dead_clocks >= half_clocks
//   a compensation as long as a pulse:    5/8 dead_clocks >= half_clocks / 2 - spare
//   or one in a pattern in which dead time takes no fixed part of the voltage
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
    input  wire signed [7:0]       sample_lead_i,
    input  wire                    sample_late_i,
    input  wire                    whole_i,           // one width for both halves of a period
    input  wire [7:0]              least_i,           // these two are wh_modulator's
    input  wire [7:0]              spare_i,
    input  wire [7:0]              dead_clocks_i,
    input  wire                    compensate_i,
    input  wire                    compensable_i,     // the pattern's dead time can be compensated
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

    localparam integer TICK_W = `WH_TICK_W;

    wire signed [TICK_W:0]   first  = $signed({2'b00, sample_clocks_i[TICK_W-1:1]})
                                      - $signed({{TICK_W-7{sample_lead_i[7]}}, sample_lead_i});
    wire        [TICK_W:0]   behind = $unsigned(first) + {{TICK_W{1'b0}}, sample_late_i};
    wire        [TICK_W-2:0] half   = half_clocks_i[TICK_W-1:1];
    wire        [8:0]        takes  = {1'b0, spare_i} + {1'b0, (least_i == 8'd0) ? 8'd1 : least_i};
    // 5/8 of the dead time is what wh_dead_time adds at most; in eighths.
    wire        [11:0]       longer = {2'b00, dead_clocks_i, 2'b00} + {4'd0, dead_clocks_i}
                                      + {1'b0, spare_i, 3'b000};

    reg     illegal;
    integer n;

    always @* begin
        illegal = half_clocks_i < 6 || tick_halves_i == 0 || sample_clocks_i < 2
                  || samples_i == 0 || samples_i > 256
                  || (whole_i && tick_halves_i[0])
                  || first[TICK_W] || behind >= {1'b0, sample_clocks_i}
                  || {{TICK_W-10{1'b0}}, takes} > half
                  || {{TICK_W-8{1'b0}}, dead_clocks_i} >= half_clocks_i
                  || (compensate_i && (!compensable_i || {{TICK_W-10{1'b0}}, longer} >= {half, 3'b000}));
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
