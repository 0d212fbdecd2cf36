// SPDX-License-Identifier: Apache-2.0
//
// bench_listeners: wh_capture and wh_stream behind wh_tick_words, as wh_device has them.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module bench_listeners #(
    parameter integer N          = 1,
    parameter integer DEPTH_LOG2 = 6,
    parameter integer CREDIT     = 4000
) (
    input  wire                     clk,
    input  wire                     rst,

    input  wire                     tick_i,
    input  wire                     valid_i,
    input  wire [N*`WH_DATA_W-1:0]  voltage_i,
    input  wire [N*`WH_DATA_W-1:0]  u_i,
    input  wire [N*`WH_DATA_W-1:0]  v_i,
    input  wire [N*`WH_DATA_W-1:0]  current_i,
    input  wire [N*`WH_COUNT_W-1:0] position_i,
    input  wire [N*`WH_DATA_W-1:0]  correction_i,
    input  wire [N*`WH_DATA_W-1:0]  offset_i,
    input  wire [N*`WH_DATA_W-1:0]  flux_i,
    input  wire [N*`WH_DATA_W-1:0]  lag_i,
    input  wire [N*8-1:0]           flags_i,
    input  wire [`WH_BUS_W-1:0]     bus_i,
    input  wire [`WH_FAULTS-1:0]    faults_i,

    // The capture.
    input  wire [N-1:0]             contact_i,
    input  wire                     fault_i,
    input  wire [95:0]              channel_i,
    input  wire [3:0]               channels_i,
    input  wire [15:0]              rows_i,
    input  wire [15:0]              pre_i,
    input  wire [3:0]               decimation_i,
    input  wire [2:0]               trigger_i,
    input  wire signed [31:0]       level_i,
    input  wire                     hold_i,
    input  wire                     write_i,
    input  wire                     write_offset_i,
    input  wire [15:0]              data_i,
    output wire [2:0]               state_o,
    output wire [15:0]              count_o,
    output wire [15:0]              first_o,
    output wire [15:0]              left_o,
    input  wire [5:0]               read_i,
    output wire [31:0]              read_data_o,

    // The stream.
    input  wire [47:0]              stream_channel_i,
    input  wire [1:0]               stream_last_i,
    input  wire [15:0]              stream_shift_i,
    input  wire [3:0]               stream_decimation_i,
    input  wire                     stream_hold_i,
    input  wire                     stream_write_i,
    input  wire [1:0]               stream_data_i,
    output wire [1:0]               stream_state_o,
    output wire [15:0]              stream_lost_o,
    output wire                     stream_credit_o,
    input  wire                     stream_room_i,
    output wire                     stream_valid_o,
    output wire                     stream_first_o,
    output wire [7:0]               stream_byte_o,
    output wire                     stream_packet_o
);

    wire        strobe;
    wire [1:0]  want;
    wire [1:0]  take;
    wire [1:0]  reads;
    wire [23:0] code;
    wire [31:0] word;
    wire        mean;
    wire        any;

    wh_tick_words #(
        .N            (N)
    ) tick_words (
        .clk          (clk),
        .rst          (rst),
        .tick_i       (tick_i),
        .valid_i      (valid_i),
        .voltage_i    (voltage_i),
        .u_i          (u_i),
        .v_i          (v_i),
        .current_i    (current_i),
        .position_i   (position_i),
        .correction_i (correction_i),
        .offset_i     (offset_i),
        .flux_i       (flux_i),
        .lag_i        (lag_i),
        .flags_i      (flags_i),
        .bus_i        (bus_i),
        .faults_i     (faults_i),
        .want_i       (want),
        .reads_i      (reads),
        .code_i       (code),
        .strobe_o     (strobe),
        .take_o       (take),
        .word_o       (word),
        .mean_o       (mean),
        .any_o        (any)
    );

    wh_capture #(
        .N              (N),
        .DEPTH_LOG2     (DEPTH_LOG2)
    ) capture (
        .clk            (clk),
        .rst            (rst),
        .strobe_i       (strobe),
        .want_o         (want[0]),
        .take_i         (take[0]),
        .reads_o        (reads[0]),
        .code_o         (code[11:0]),
        .word_i         (word),
        .mean_i         (mean),
        .any_i          (any),
        .contact_i      (contact_i),
        .fault_i        (fault_i),
        .channel_i      (channel_i),
        .channels_i     (channels_i),
        .rows_i         (rows_i),
        .pre_i          (pre_i),
        .decimation_i   (decimation_i),
        .trigger_i      (trigger_i),
        .level_i        (level_i),
        .hold_i         (hold_i),
        .write_i        (write_i),
        .write_offset_i (write_offset_i),
        .data_i         (data_i),
        .state_o        (state_o),
        .count_o        (count_o),
        .first_o        (first_o),
        .left_o         (left_o),
        .read_i         (read_i),
        .read_data_o    (read_data_o)
    );

    wh_stream #(
        .CREDIT         (CREDIT)
    ) stream (
        .clk            (clk),
        .rst            (rst),
        .strobe_i       (strobe),
        .want_o         (want[1]),
        .take_i         (take[1]),
        .reads_o        (reads[1]),
        .code_o         (code[23:12]),
        .word_i         (word),
        .mean_i         (mean),
        .any_i          (any),
        .channel_i      (stream_channel_i),
        .last_i         (stream_last_i),
        .shift_i        (stream_shift_i),
        .decimation_i   (stream_decimation_i),
        .hold_i         (stream_hold_i),
        .write_i        (stream_write_i),
        .data_i         (stream_data_i),
        .state_o        (stream_state_o),
        .lost_o         (stream_lost_o),
        .credit_o       (stream_credit_o),
        .room_i         (stream_room_i),
        .byte_valid_o   (stream_valid_o),
        .byte_first_o   (stream_first_o),
        .byte_o         (stream_byte_o),
        .packet_o       (stream_packet_o)
    );

endmodule

`default_nettype wire
