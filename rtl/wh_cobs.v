// SPDX-License-Identifier: Apache-2.0
//
// wh_cobs: two kinds of frames on one transmitter, a Modbus slave's answers and a stream's packets.
//
// Without credit_i there are no packets, and an answer's bytes go through as they are. An answer that begins
// with credit_i waits until it is whole and goes as a frame, as packets do: consistent overhead byte stuffing
// (S. Cheshire, M. Baker, IEEE/ACM Trans. Networking 7, 1999) and a zero,
//
//   code   code - 1 bytes   code   code - 1 bytes   ...   0
//
// in which a code below 255 stands for a zero behind its bytes, but for the last one. So there is a zero at
// each frame's end and nowhere else. No packet begins while there is an answer or none has to be, and none
// without credit_i; one that has begun is sent to its end. An answer goes before all packets that wait.
//
//   answer: answers_i is high from before its first byte to its last one; rests_i from then on, or instead
//   where there are no bytes, until answer_ready_o says that the line rests, in one more clock without a byte
//   packet: byte_first_i with the first byte, PACKET bytes, packet_i; room_o says that there is room for a whole one
//
// Five packets wait; those of a credit that is over are forgotten.
//
// Latency: a frame begins three clocks for each byte up to its first zero later, or 254; so does each code.
// tx_ready_i has to be low for three clocks or more after a byte was taken. Reset: nothing is sent.

`default_nettype none

module wh_cobs #(
    parameter integer PACKET    = 125,  // bytes of a packet, 2...2^SLOT_LOG2
    parameter integer SLOT_LOG2 = 7     // that, and half of what an answer can be, 2...7
) (
    input  wire       clk,
    input  wire       rst,

    input  wire       credit_i,

    // Answers (wh_modbus).
    input  wire       answers_i,
    input  wire       rests_i,
    input  wire       answer_valid_i,
    input  wire [7:0] answer_i,
    output wire       answer_ready_o,

    // Packets (wh_stream).
    input  wire       byte_valid_i,    // strobe
    input  wire       byte_first_i,
    input  wire [7:0] byte_i,
    input  wire       packet_i,        // strobe
    output wire       room_o,

    // The line (wh_uart).
    output wire       tx_valid_o,
    output wire [7:0] tx_data_o,
    input  wire       tx_ready_i
);

    // ---- The frames' memory: eight slots, of which two are an answer's, the others of packets.

    localparam integer PLACE_W  = SLOT_LOG2 + 3;
    localparam [31:0]  PACKET_32 = PACKET;
    localparam [PLACE_W-1:0] LENGTH = PACKET_32[PLACE_W-1:0];
    localparam [2:0]  FIRST     = 3'd2;
    localparam [2:0]  LAST      = 3'd7;
    localparam [2:0]  MOST      = 3'd4;  // packets that wait where another one may begin; one is being sent

    (* ram_style = "block" *) reg [7:0] memory [0:(8<<SLOT_LOG2)-1];

    reg  [2:0] write_slot_q;
    reg  [2:0] read_slot_q;
    reg  [2:0] waiting_q;    // packets
    reg        framed_q;     // the answer goes as a frame
    reg        stale_q;      // the packet that is sent is of a credit that is over

    reg  [SLOT_LOG2-1:0] place_q;  // of the packet that is written
    reg  [SLOT_LOG2:0]   count_q;  // bytes of the answer that are there

    wire [SLOT_LOG2-1:0] place = byte_first_i ? {SLOT_LOG2{1'b0}} : place_q;
    wire       stores = framed_q && answers_i && answer_valid_i && !byte_valid_i;

    // ---- Sending.

    localparam [2:0] IDLE  = 3'd0;
    localparam [2:0] SCAN  = 3'd1;  // for the next zero
    localparam [2:0] CODE  = 3'd2;
    localparam [2:0] BYTES = 3'd3;
    localparam [2:0] END   = 3'd4;
    localparam [2:0] NEXT  = 3'd5;  // the block is over
    localparam [2:0] REST  = 3'd6;  // until the line rests

    reg  [2:0] state_q;
    reg        sends_packet_q;
    reg  [7:0] code_q;
    reg        whole_q;      // the block ends the frame
    reg        skips_q;      // a zero stands behind it
    reg  [1:0] clock_q;      // of the byte that is looked at
    reg  [7:0] from_ram_q;   // what the memory puts out comes late in its clock: it gets one more
    reg  [7:0] byte_q;

    reg  [PLACE_W-1:0] at_q;     // the next byte that is looked at or sent
    reg  [PLACE_W-1:0] end_q;    // behind the last one
    reg  [PLACE_W-1:0] begin_q;  // of the block

    wire       idle    = (state_q == IDLE);
    wire       quiet   = !answers_i && !rests_i;
    wire       framed  = rests_i && (count_q != {SLOT_LOG2+1{1'b0}});
    wire       begins  = idle && quiet && credit_i && (waiting_q != 3'd0);
    wire       at_end  = (at_q == end_q);
    wire       full    = (code_q == 8'd255);
    wire       is_zero = (byte_q == 8'd0);
    wire [PLACE_W-1:0] start = begins ? {read_slot_q, {SLOT_LOG2{1'b0}}} : {PLACE_W{1'b0}};
    wire [PLACE_W-1:0] skip  = {{PLACE_W-1{1'b0}}, skips_q};

    wire [2:0] after_write = (write_slot_q == LAST) ? FIRST : write_slot_q + 3'd1;
    wire [2:0] after_read  = (read_slot_q == LAST) ? FIRST : read_slot_q + 3'd1;

    assign room_o         = (waiting_q + {2'd0, packet_i} <= MOST) && !stale_q;
    assign answer_ready_o = rests_i ? (idle && !framed && tx_ready_i)
                          : framed_q ? !byte_valid_i : (idle && tx_ready_i);
    assign tx_valid_o     = idle ? (answers_i && !framed_q && answer_valid_i)
                                 : (state_q == CODE || state_q == BYTES || state_q == END);
    assign tx_data_o      = idle ? answer_i : (state_q == CODE) ? code_q
                          : (state_q == BYTES) ? byte_q : 8'd0;

    always @(posedge clk) begin
        if (byte_valid_i || stores) begin
            memory[byte_valid_i ? {write_slot_q, place} : {2'd0, count_q}] <= byte_valid_i ? byte_i : answer_i;
        end
        from_ram_q <= memory[at_q];
        byte_q     <= from_ram_q;

        if (rst) begin
            state_q      <= IDLE;
            write_slot_q <= FIRST;
            read_slot_q  <= FIRST;
            waiting_q    <= 3'd0;
            count_q      <= {SLOT_LOG2+1{1'b0}};
            framed_q     <= 1'b0;
            stale_q      <= 1'b0;
        end else begin
            if (quiet) begin
                framed_q <= credit_i;
            end
            if (stores) begin
                count_q <= count_q + 1'b1;
            end

            // The packets that wait.
            if (byte_valid_i) begin
                place_q <= place + 1'b1;
            end
            if (!credit_i) begin
                waiting_q   <= 3'd0;
                read_slot_q <= write_slot_q;
                stale_q     <= !idle && sends_packet_q;
            end else begin
                waiting_q    <= waiting_q + {2'd0, packet_i} - {2'd0, begins};
                write_slot_q <= packet_i ? after_write : write_slot_q;
                read_slot_q  <= begins ? after_read : read_slot_q;
                stale_q      <= stale_q && !idle;
            end

            // The frame.
            clock_q <= (state_q != SCAN || clock_q == 2'd2) ? 2'd0 : clock_q + 2'd1;
            case (state_q)
                IDLE: begin
                    at_q           <= start;
                    begin_q        <= start;
                    end_q          <= start + (begins ? LENGTH : {2'd0, count_q});
                    code_q         <= 8'd1;
                    sends_packet_q <= begins;
                    if (begins || framed) begin
                        state_q <= SCAN;
                    end
                end
                SCAN: begin
                    if (at_end || full || (clock_q == 2'd2 && is_zero)) begin
                        whole_q <= at_end;
                        skips_q <= !at_end && !full;
                        at_q    <= begin_q;
                        state_q <= CODE;
                    end else if (clock_q == 2'd2) begin
                        at_q   <= at_q + 1'b1;
                        code_q <= code_q + 8'd1;
                    end
                end
                CODE: begin
                    if (tx_ready_i) begin
                        code_q  <= code_q - 8'd1;
                        state_q <= (code_q == 8'd1) ? NEXT : BYTES;
                    end
                end
                BYTES: begin
                    if (tx_ready_i) begin
                        at_q    <= at_q + 1'b1;
                        code_q  <= code_q - 8'd1;
                        state_q <= (code_q == 8'd1) ? NEXT : BYTES;
                    end
                end
                NEXT: begin
                    at_q    <= at_q + skip;
                    begin_q <= at_q + skip;
                    code_q  <= 8'd1;
                    state_q <= whole_q ? END : SCAN;
                end
                END: begin
                    if (tx_ready_i) begin
                        state_q <= REST;
                        if (!sends_packet_q) begin
                            count_q <= {SLOT_LOG2+1{1'b0}};
                        end
                    end
                end
                default: begin
                    if (tx_ready_i) begin
                        state_q <= IDLE;
                    end
                end
            endcase
        end
    end

endmodule

`default_nettype wire
