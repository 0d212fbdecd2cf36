// SPDX-License-Identifier: Apache-2.0
//
// bench_lost_clock: wh_board_controller behind wh_board_clock_watch, joined as in the tops of the
// boards that have an oscillator of their own, without PLL, oscillator and pads.
//
// gate_*_o are the pads; bridge_on_o is 1 while a gate is on before them.

`default_nettype none
`include "wh_board_settings.vh"

module bench_lost_clock #(
    parameter integer SETTLE_LOG2 = 6,
    parameter integer ZERO_LOG2   = 2
) (
    input  wire clk,
    input  wire rst,
    input  wire watch_clk,

    input  wire start_i,
    input  wire stop_i,
    `WH_BOARD_MORE_PORTS
    output wire adc_cs_n_o,
    output wire adc_sclk_o,
    input  wire adc_sdata_i,
    input  wire enc_a_i,
    input  wire enc_b_i,
    output wire gate_ah_o,
    output wire gate_al_o,
    output wire gate_bh_o,
    output wire gate_bl_o,
    output wire bridge_on_o,
    output wire alive_o,
    output wire running_o,
    output wire fault_o
);

    wire clock_lost;
    wire bridge_ah;
    wire bridge_al;
    wire bridge_bh;
    wire bridge_bl;
    wire contact;
    wire uart_tx;
    wire unused = &{1'b0, contact, uart_tx};

    wh_board_clock_watch clock_watch (
        .clk       (clk),
        .rst       (rst),
        .watch_clk (watch_clk),
        .gates_i   ({bridge_ah, bridge_al, bridge_bh, bridge_bl}),
        .gates_o   ({gate_ah_o, gate_al_o, gate_bh_o, gate_bl_o}),
        .lost_o    (clock_lost)
    );

    assign bridge_on_o = bridge_ah || bridge_al || bridge_bh || bridge_bl;

    wh_board_controller #(
        .SETTLE_LOG2  (SETTLE_LOG2),
        .ZERO_LOG2    (ZERO_LOG2)
    ) board_controller (
        .clk          (clk),
        .rst          (rst),
        .start_i      (start_i),
        .stop_i       (stop_i),
        .clock_lost_i (clock_lost),
        .uart_rx_i    (1'b1),
        .uart_tx_o    (uart_tx),
        `WH_BOARD_MORE_PINS
        .adc_cs_n_o   (adc_cs_n_o),
        .adc_sclk_o   (adc_sclk_o),
        .adc_sdata_i  (adc_sdata_i),
        .enc_a_i      (enc_a_i),
        .enc_b_i      (enc_b_i),
        .gate_ah_o    (bridge_ah),
        .gate_al_o    (bridge_al),
        .gate_bh_o    (bridge_bh),
        .gate_bl_o    (bridge_bl),
        .alive_o      (alive_o),
        .running_o    (running_o),
        .contact_o    (contact),
        .fault_o      (fault_o)
    );

endmodule

`default_nettype wire
