// SPDX-License-Identifier: Apache-2.0
//
// bench_listeners: wh_capture and wh_stream with the words of ticks as short as they may be. Words are given as
// wh_round_words gives those of a round: to one reader at a time, a strobe a tick, the capture at first, the chosen one
// a clock after its code.

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

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer MEANS  = 8;  // voltage, u, v, current, correction, offset, flux, lag
    localparam [8*MEANS-1:0] CODES = {8'hc3, 8'hc2, 8'hc1, 8'hc0, 8'hb3, 8'hb2, 8'hb1, 8'hb0};

    wire [23:0] code;
    wire [1:0]  want, reads;

    // ---- A tick's step, or without one its end.
    reg         stepped_q, missed_q;
    wire        strobe = valid_i || missed_q;

    always @(posedge clk) begin
        stepped_q <= !rst && !tick_i && (stepped_q || valid_i);
        missed_q  <= !rst && tick_i && !stepped_q && !valid_i;
    end

    // ---- Whose turn it is.
    reg         second_q;  // the stream waits for the capture
    wire        begins = strobe && !second_q && (reads == 2'b00);
    wire [1:0]  take   = {(begins && want == 2'b10) || (second_q && !reads[0] && want[1]), begins && want[0]};

    always @(posedge clk) begin
        second_q <= !rst && ((begins && want == 2'b11) || (second_q && reads[0]));
    end

    // ---- The words that they choose from.
    reg  [MEANS*N*DATA_W-1:0] means_q;
    reg  [N*`WH_COUNT_W-1:0]  position_q;
    reg  [N*8-1:0]            flags_q;
    reg  [`WH_BUS_W-1:0]      bus_q;
    reg  [`WH_FAULTS-1:0]     faults_q;
    reg  [11:0]               code_q;
    reg  signed [31:0]        word;
    reg                       mean, any;
    integer                   m, k;

    always @(posedge clk) begin
        if (begins && want != 2'b00) begin
            means_q    <= {lag_i, flux_i, offset_i, correction_i, current_i, v_i, u_i, voltage_i};
            position_q <= position_i;
            flags_q    <= flags_i;
            bus_q      <= bus_i;
            faults_q   <= faults_i;
        end
        code_q <= (take[1] || reads[1]) ? code[23:12] : code[11:0];
    end

    always @* begin
        word = 32'd0;
        any  = (code_q == 12'h062);
        mean = (code_q == 12'h039);
        if (any) begin
            word = {{32-`WH_FAULTS{1'b0}}, faults_q};
        end
        if (mean) begin
            word = {{32-`WH_BUS_W{1'b0}}, bus_q};
        end
        for (m = 0; m < N; m = m + 1) begin
            if ({28'd0, code_q[11:8]} == m + 1) begin
                if (code_q[7:0] == 8'hb4) begin
                    word = position_q[m*`WH_COUNT_W +: `WH_COUNT_W];
                end
                if (code_q[7:0] == 8'hd6) begin
                    word = {24'd0, flags_q[m*8 +: 8]};
                    any  = 1'b1;
                end
                for (k = 0; k < MEANS; k = k + 1) begin
                    if (code_q[7:0] == CODES[k*8 +: 8]) begin
                        word = {{32-DATA_W{means_q[(k*N + m + 1)*DATA_W - 1]}}, means_q[(k*N + m)*DATA_W +: DATA_W]};
                        mean = 1'b1;
                    end
                end
            end
        end
    end

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
