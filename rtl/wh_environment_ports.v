// SPDX-License-Identifier: Apache-2.0
//
// wh_environment_ports: the environment of N ports, which take turns, as three values for wh_core.
//
//   w = eta_o v + wave_o, shaped as mode_o says
//
// For each port it equals wh_environment bit for bit; that header has the conditions. With HOST = 1 each port has its
// own wh_host_link: only the host's values need it, and answers may come at any time.
//
// The turn: port_i selects the port while contact and eta are valid. step_valid_i ends its step, with v_i; in the next
// clock the host link's values are valid. host_sequence_o, host_v_o and host_active_o are those of port_i as well.
// Formats: eta s27q25 in [-1, 1]; waves s31q23 √W.
// Latency: none besides wh_host_link's. Reset: that of wh_host_link, for all ports.

`default_nettype none
`include "wh_formats.vh"

module wh_environment_ports #(
    parameter integer N      = 1,                        // ports, 1...8
    parameter integer HOST   = 0,                        // 1: a computer can be the environment
    parameter integer PORT_W = (N > 1) ? $clog2(N) : 1   // derived, leave it
) (
    input  wire                         clk,
    input  wire                         rst,

    // A turn.
    input  wire [PORT_W-1:0]            port_i,
    input  wire                         damps_i,
    input  wire                         contact_i,
    input  wire                         shaped_i,
    input  wire [`WH_COEF_W-1:0]        eta_i,           // s27q25
    input  wire                         step_valid_i,    // strobe
    input  wire [`WH_DATA_W-1:0]        v_i,             // s31q23 √W

    // A host's (wh_host_link).
    input  wire [3:0]                   host_period_log2_i,
    input  wire [7:0]                   host_timeout_i,
    input  wire [N-1:0]                 host_strobe_i,   // an answer for that port
    input  wire [7:0]                   host_sequence_i,
    input  wire [`WH_DATA_W-1:0]        host_u_i,        // s31q23 √W
    output wire [N-1:0]                 host_strobe_o,   // a packet
    output wire [7:0]                   host_sequence_o,
    output wire [`WH_DATA_W-1:0]        host_v_o,        // s31q23 √W, mean of v
    output wire                         host_active_o,

    output wire [`WH_COEF_W-1:0]        eta_o,           // s27q25
    output wire [`WH_DATA_W-1:0]        wave_o,          // s31q23 √W
    output wire [1:0]                   mode_o           // of W, as in wh_shaper
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

    wire [DATA_W-1:0] goal;

    genvar n;
    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_environment_ports_n_must_be_1_to_8 stop ();
        end
        if (HOST != 0 && HOST != 1) begin : illegal_host
            wh_illegal_parameter_environment_ports_host_must_be_0_or_1 stop ();
        end

        if (HOST == 1) begin : hosted
            wire [N-1:0]        active;
            wire [N*8-1:0]      sequences;
            wire [N*DATA_W-1:0] means;
            wire [N*DATA_W-1:0] goals;

            for (n = 0; n < N; n = n + 1) begin : port
                wh_host_link host_link (
                    .clk           (clk),
                    .rst           (rst),
                    .period_log2_i (host_period_log2_i),
                    .timeout_i     (host_timeout_i),
                    .valid_i       (step_valid_i && {{(32 - PORT_W){1'b0}}, port_i} == n),
                    .v_i           (v_i),
                    .active_o      (active[n]),
                    .u_o           (goals[n*DATA_W +: DATA_W]),
                    .strobe_o      (host_strobe_o[n]),
                    .sequence_o    (sequences[n*8 +: 8]),
                    .v_mean_o      (means[n*DATA_W +: DATA_W]),
                    .strobe_i      (host_strobe_i[n]),
                    .sequence_i    (host_sequence_i),
                    .u_i           (host_u_i)
                );
            end

            assign goal            = goals[port_i*DATA_W +: DATA_W];
            assign host_active_o   = active[port_i];
            assign host_sequence_o = sequences[port_i*8 +: 8];
            assign host_v_o        = means[port_i*DATA_W +: DATA_W];
        end else begin : alone
            wire unused = &{1'b0, clk, rst, port_i, step_valid_i, v_i, host_period_log2_i, host_timeout_i,
                            host_strobe_i, host_sequence_i, host_u_i};

            assign goal            = {DATA_W{1'b0}};
            assign host_active_o   = 1'b0;
            assign host_strobe_o   = {N{1'b0}};
            assign host_sequence_o = 8'd0;
            assign host_v_o        = {DATA_W{1'b0}};
        end
    endgenerate

    // While a host is the environment, v goes to the host, and W must not store a part of it.
    assign mode_o = (!contact_i || host_active_o) ? 2'd0 : shaped_i ? 2'd2 : 2'd1;
    assign wave_o = (host_active_o && !damps_i) ? goal : {DATA_W{1'b0}};
    assign eta_o  = (host_active_o || damps_i) ? {COEF_W{1'b0}} : eta_i;

endmodule

`default_nettype wire
