// SPDX-License-Identifier: Apache-2.0
//
// wh_stream: rows of live values, one packet after another, while a host gives credit. It only listens: nothing of it
// reaches what it listens to.
//
// A row has last_i + 1 values of 16 bits, from the addresses in channel_i, for 2^decimation_i ticks (wh_rows). shift_i
// is the number of low bits that a value drops, rounding down. A mean that is still too large becomes the largest
// value; of other values the lowest 16 bits stay.
//
//   write 1   credit for CREDIT clocks; if there is some, renew
//   write 2   if there is credit, renew; else nothing
//   write 0   end it
//
// With the first credit the settings are taken, and rows begin. 60 values make a packet of 125 bytes:
//
//   248 + last_i   number (2 bytes)   60 values (2 bytes each)   CRC-16 (2 bytes)
//
// High byte first, except for the CRC, which is that of Modbus over all bytes before it. Rows follow each other without
// a gap. Packets are numbered from 0 modulo 2^16, including those that are dropped: because there was no room_i in a
// packet's first row, or because a row came before the previous one was written. lost_o counts these.
//
// state_o: 1 idle, 2 sending.
//
// Latency: a row is written within 9 clocks for each of its bytes, and five more in a packet, from the 9th clock after
// its tick was taken on, which may be 9 after its step (wh_round_words). A tick needs 10 clocks or more, 14 with another
// reader; shorter ones are left out. Credit begins and ends as armed_o of wh_arm does.
// Reset: no credit.

`default_nettype none

module wh_stream #(
    parameter integer CREDIT = 4800000  // clocks, 2...2^30
) (
    input  wire                         clk,
    input  wire                         rst,

    // The words of a tick (wh_round_words).
    input  wire                         strobe_i,         // strobe, once a tick
    output wire                         want_o,
    input  wire                         take_i,           // strobe, with strobe_i or later
    output wire                         reads_o,
    output wire [11:0]                  code_o,
    input  wire [31:0]                  word_i,
    input  wire                         mean_i,
    input  wire                         any_i,

    // Settings, taken over with the first credit.
    input  wire [47:0]                  channel_i,        // four addresses, the first lowest
    input  wire [1:0]                   last_i,           // number of the last one that counts
    input  wire [15:0]                  shift_i,          // four times 0...15
    input  wire [3:0]                   decimation_i,     // a row is of 2^this ticks
    input  wire                         hold_i,           // they are about to change

    // Commands and state.
    input  wire                         write_i,          // strobe
    input  wire [1:0]                   data_i,
    output wire [1:0]                   state_o,
    output wire [15:0]                  lost_o,

    // Packets (wh_cobs).
    output wire                         credit_o,
    input  wire                         room_i,           // for a whole packet
    output wire                         byte_valid_o,     // strobe
    output wire                         byte_first_o,     // with it: a packet begins
    output wire [7:0]                   byte_o,
    output wire                         packet_o          // strobe, behind its last byte
);

    // ---- Credit.

    wire       credit;
    wire       unused_start;
    wire [4:0] unused_refused;

    wh_arm #(
        .SENSE        (0),
        .CREDIT       (CREDIT)
    ) granted (
        .clk          (clk),
        .rst          (rst),
        .enable_i     (1'b1),
        .fault_i      (1'b0),
        .zero_i       (1'b0),
        .loading_i    (1'b0),
        .write_i      (write_i),
        .value_i      (data_i),
        .press_i      (1'b0),
        .zero_start_o (unused_start),
        .zero_busy_i  (1'b0),
        .zero_fault_i (1'b0),
        .armed_o      (credit),
        .refused_o    (unused_refused)
    );

    // ---- Rows.

    localparam [3:0] FIRST_TURN = 4'd4;  // of the words
    localparam [3:0] LAST_TURN  = 4'd8;

    reg         runs_q;
    reg  [1:0]  last_q;
    reg  [15:0] shifts_q;
    reg  [5:0]  last_row_q;  // of a packet
    wire        idle;
    wire        unused_fresh;
    wire [3:0]  turn;
    wire        last;
    wire        is_mean;
    wire [31:0] value;
    wire        starts = credit && !runs_q && !hold_i && !strobe_i && idle;

    wire [3:0]  summed = turn - 4'd3;

    wh_rows #(
        .CHANNELS     (4)
    ) rows (
        .clk          (clk),
        .rst          (rst),
        .take_i       (take_i),
        .idle_o       (idle),
        .reads_o      (reads_o),
        .code_o       (code_o),
        .word_i       (word_i),
        .mean_i       (mean_i),
        .any_i        (any_i),
        .start_i      (starts),
        .channel_i    (channel_i),
        .decimation_i (decimation_i),
        .shift_i      (shifts_q[4*summed[1:0] +: 4]),
        .fresh_o      (unused_fresh),
        .turn_o       (turn),
        .last_o       (last),
        .mean_o       (is_mean),
        .value_o      (value)
    );

    assign want_o = runs_q && idle;

    wire        fits = (value[31:15] == {17{value[31]}}) || !is_mean;
    wire [15:0] word = fits ? value[15:0] : {value[31], {15{!value[31]}}};
    wire        unused = &{1'b0, summed[3:2]};

    // ---- Packets. A row's words wait, the first highest, until its bytes are written.

    localparam [2:0] WAIT   = 3'd0;
    localparam [2:0] KIND   = 3'd1;
    localparam [2:0] SEQ_H  = 3'd2;
    localparam [2:0] SEQ_L  = 3'd3;
    localparam [2:0] WORD_H = 3'd4;
    localparam [2:0] WORD_L = 3'd5;
    localparam [2:0] CRC_0  = 3'd6;
    localparam [2:0] CRC_1  = 3'd7;

    reg  [2:0]  state_q;
    reg  [3:0]  bit_q;      // of the byte: 0 it is written, 1...8 it goes into the CRC
    reg  [63:0] row_q;
    reg  [1:0]  left_q;     // words of it that are to be written, but for one
    reg  [5:0]  rows_q;     // of the packet, that have passed
    reg         bad_q;      // the packet is left out
    reg         ends_q;     // the row is the packet's last
    reg         done_q;
    reg  [15:0] number_q;
    reg  [15:0] lost_q;
    reg  [15:0] crc_q;
    reg  [7:0]  next;

    wire        row_begins = (turn == FIRST_TURN) && last;
    wire        row_ends   = (turn == LAST_TURN) && last;
    wire        first_row  = (rows_q == 6'd0);
    wire        last_row   = (rows_q == last_row_q);
    wire        writes     = (state_q != WAIT) && (bit_q == 4'd0);
    wire        after      = (bit_q == 4'd8);

    always @* begin
        case (state_q)
            KIND:    next = {6'b111110, last_q};
            SEQ_H:   next = number_q[15:8];
            SEQ_L:   next = number_q[7:0];
            WORD_H:  next = row_q[63:56];
            WORD_L:  next = row_q[55:48];
            default: next = crc_q[7:0];
        endcase
    end

    assign credit_o     = credit;
    assign state_o      = {runs_q, !runs_q};
    assign lost_o       = lost_q;
    assign byte_valid_o = writes;
    assign byte_first_o = (state_q == KIND);
    assign byte_o       = next;
    assign packet_o     = done_q;

    always @(posedge clk) begin
        done_q <= !rst && runs_q && credit && (state_q == CRC_1) && after;

        // The words, each to its place.
        if (turn >= FIRST_TURN && turn < LAST_TURN && last && state_q == WAIT) begin
            row_q[{~turn[1:0], 4'd0} +: 16] <= word;
        end else if (state_q == WORD_L && after) begin
            row_q <= {row_q[47:0], 16'd0};
        end

        // The CRC.
        if (state_q == WAIT) begin
            crc_q <= first_row ? 16'hffff : crc_q;
        end else if (writes) begin
            crc_q[7:0] <= crc_q[7:0] ^ next;
        end else begin
            crc_q <= {1'b0, crc_q[15:1]} ^ (crc_q[0] ? 16'ha001 : 16'd0);
        end

        if (rst) begin
            runs_q   <= 1'b0;
            state_q  <= WAIT;
            bit_q    <= 4'd0;
            rows_q   <= 6'd0;
            number_q <= 16'd0;
            lost_q   <= 16'd0;
        end else begin
            // The bytes.
            bit_q <= (state_q == WAIT || after) ? 4'd0 : bit_q + 4'd1;
            if (after) begin
                case (state_q)
                    WORD_L: begin
                        left_q  <= left_q - 2'd1;
                        state_q <= (left_q != 2'd0) ? WORD_H : ends_q ? CRC_0 : WAIT;
                    end
                    CRC_1:   state_q <= WAIT;
                    default: state_q <= state_q + 3'd1;
                endcase
            end

            // The rows.
            if (row_begins) begin
                bad_q <= (state_q != WAIT) || (first_row ? !room_i : bad_q);
            end
            if (row_ends) begin
                rows_q <= last_row ? 6'd0 : rows_q + 6'd1;
                if (!bad_q) begin
                    ends_q  <= last_row;
                    left_q  <= last_q;
                    state_q <= first_row ? KIND : WORD_H;
                end
                if (last_row) begin
                    number_q <= number_q + 16'd1;
                    lost_q   <= lost_q + {15'd0, bad_q};
                end
            end

            // Credit.
            if (starts) begin
                runs_q     <= 1'b1;
                last_q     <= last_i;
                shifts_q   <= shift_i;
                last_row_q <= (last_i == 2'd0) ? 6'd59 : (last_i == 2'd1) ? 6'd29
                            : (last_i == 2'd2) ? 6'd19 : 6'd14;
                rows_q     <= 6'd0;
                number_q   <= 16'd0;
                lost_q     <= 16'd0;
            end else if (!credit) begin
                runs_q <= 1'b0;
            end
            if (!runs_q) begin
                state_q <= WAIT;
            end
        end
    end

endmodule

`default_nettype wire
