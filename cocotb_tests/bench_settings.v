// SPDX-License-Identifier: Apache-2.0
//
// bench_settings: wh_settings with groups of each kind, and free holds.

`default_nettype none
`include "wh_formats.vh"

module bench_settings #(
    parameter integer N          = 2,
    parameter integer WALLS      = 4,
    parameter integer SHAPER     = 0,
    parameter integer DELAY_LOG2 = 2,
    parameter integer LEGS       = 2
) (
    input  wire                     clk,
    input  wire                     rst,
    input  wire                     bus_valid_i,
    input  wire                     bus_write_i,
    input  wire                     bus_check_i,
    input  wire [11:0]              bus_address_i,
    input  wire [31:0]              bus_data_i,
    output wire                     bus_ready_o,
    output wire [31:0]              bus_data_o,
    output wire [1:0]               bus_error_o,
    output wire                     bus_signed_o,
    input  wire [31:0]              live_i,
    output wire                     command_o,
    input  wire                     enable_i,
    input  wire                     tick_i,
    input  wire [1:0]               hold_i,     // of the waves, of the walls
    output wire                     ready_o,
    output wire                     loading_o,
    output wire                     busy_o,
    output wire                     write_o,
    output wire                     change_o,
    output wire                     now_o,
    output wire [N*(2*`WH_COEF_W+`WH_DATA_W)-1:0] wave_o,    // root, a, u_max of each motor
    output wire [66-1:0]            wall_o,     // min, max, enable, shaped of motor 0's wall 1
    output wire [57-1:0]            frame_o     // the ADC's
);

    localparam integer   WAVE_W = 2 * `WH_COEF_W + `WH_DATA_W;
    localparam [7:0]     COEF_8 = `WH_COEF_W;
    localparam [7:0]     DATA_8 = `WH_DATA_W;

    wire        copy;
    wire        discard;
    wire [11:0] address;
    wire [31:0] data;
    wire [N:0]  pending;
    wire        never;
    wire        running = enable_i && !loading_o;

    wh_settings #(
        .N             (N),
        .WALLS         (WALLS),
        .SHAPER        (SHAPER),
        .DELAY_LOG2    (DELAY_LOG2),
        .LEGS          (LEGS)
    ) settings (
        .clk           (clk),
        .rst           (rst),
        .bus_valid_i   (bus_valid_i),
        .bus_write_i   (bus_write_i),
        .bus_check_i   (bus_check_i),
        .bus_address_i (bus_address_i),
        .bus_data_i    (bus_data_i),
        .bus_ready_o   (bus_ready_o),
        .bus_data_o    (bus_data_o),
        .bus_error_o   (bus_error_o),
        .bus_signed_o  (bus_signed_o),
        .live_i        (live_i),
        .command_o     (command_o),
        .running_i     (running),
        .tick_i        (tick_i),
        .ready_o       (ready_o),
        .loading_o     (loading_o),
        .busy_o        (busy_o),
        .write_o       (write_o),
        .copy_o        (copy),
        .address_o     (address),
        .data_o        (data),
        .change_o      (change_o),
        .now_o         (now_o),
        .discard_o     (discard),
        .changing_i    (|pending || never)
    );

    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : motor
            localparam [31:0] PART = n + 1;

            wh_setting_group #(
                .PART      (PART[3:0]),
                .FIRST     (8'h10),
                .WORDS     (3),
                .WIDTHS    ({DATA_8, COEF_8, COEF_8}),
                .TOTAL_W   (WAVE_W)
            ) wave (
                .clk       (clk),
                .rst       (rst),
                .write_i   (write_o),
                .copy_i    (copy),
                .address_i (address),
                .data_i    (data),
                .change_i  (change_o),
                .discard_i (discard),
                .hold_i    (hold_i[0] && !now_o),
                .pending_o (pending[n]),
                .words_o   (wave_o[n*WAVE_W +: WAVE_W])
            );
        end
    endgenerate

    wh_setting_group #(
        .PART      (4'd1),
        .FIRST     (8'h41),
        .STRIDE    (8'd16),
        .WORDS     (4),
        .WIDTHS    ({8'd1, 8'd1, 8'd32, 8'd32}),
        .TOTAL_W   (66)
    ) wall (
        .clk       (clk),
        .rst       (rst),
        .write_i   (write_o),
        .copy_i    (copy),
        .address_i (address),
        .data_i    (data),
        .change_i  (change_o),
        .discard_i (discard),
        .hold_i    (hold_i[1] && !now_o),
        .pending_o (pending[N]),
        .words_o   (wall_o)
    );

    wh_setting_group #(
        .STAGED    (0),
        .FIRST     (8'h08),
        .WORDS     (10),
        .WIDTHS    ({8'd1, 8'd1, 8'd6, 8'd8, 8'd8, 8'd8, 8'd5, 8'd6, 8'd6, 8'd8}),
        .TOTAL_W   (57)
    ) frame (
        .clk       (clk),
        .rst       (rst),
        .write_i   (write_o),
        .copy_i    (copy),
        .address_i (address),
        .data_i    (data),
        .change_i  (change_o),
        .discard_i (discard),
        .hold_i    (running),
        .pending_o (never),
        .words_o   (frame_o)
    );

endmodule

`default_nettype wire
