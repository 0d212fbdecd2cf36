// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_cobs: whatever the slave, the stream and the line do that keep to its header: where an answer begins
// without credit, its bytes are the line's, each in the clock in which it is taken, and there are no others;
// a frame has a zero at its end and nowhere else; no packet begins without credit, nor between an answer's
// beginning and its end; a packet's bytes aren't overwritten while it is sent. For packets of 3 bytes, answers
// of 7 or fewer and so 32 bytes of memory. Proven by induction, smtbmc z3.

`default_nettype none

module prove_wh_cobs (
    input wire       clk,
    input wire       rst,
    input wire       credit,
    input wire       speaks,   // the slave begins, or ends
    input wire       offers,
    input wire [7:0] answer,
    input wire       writes,
    input wire       first,
    input wire [7:0] data,
    input wire       packs,
    input wire       listens   // the line has room, if it can
);

    localparam [2:0] IDLE  = 3'd0;
    localparam [2:0] SCAN  = 3'd1;
    localparam [2:0] CODE  = 3'd2;
    localparam [2:0] BYTES = 3'd3;
    localparam [2:0] END   = 3'd4;
    localparam [2:0] NEXT  = 3'd5;
    localparam [2:0] REST  = 3'd6;

    // ---- What is around it.

    reg        begun = 1'b0;
    reg        answers_q;
    reg        rests_q;
    reg  [2:0] said_q;      // bytes
    reg        writing_q;   // a packet
    reg        dropped_q;   // its credit ended in the clock before
    reg  [1:0] written_q;   // bytes of it
    reg  [1:0] busy_q;      // clocks in which the line has no room

    wire       answer_ready;
    wire       room;
    wire       tx_valid;
    wire [7:0] tx_data;

    wire tx_ready = listens && (busy_q == 2'd0);
    wire valid    = answers_q && offers && (said_q != 3'd7);
    wire byte     = writes && (first ? room : (dropped_q || (writing_q && written_q != 2'd3)));
    wire packet   = packs && !writes && writing_q && (written_q == 2'd3);

    always @(posedge clk) begin
        begun <= 1'b1;
        if (rst) begin
            answers_q <= 1'b0;
            rests_q   <= 1'b0;
            said_q    <= 3'd0;
            writing_q <= 1'b0;
            dropped_q <= 1'b0;
            written_q <= 2'd0;
            busy_q    <= 2'd0;
        end else begin
            if (rests_q) begin
                rests_q <= !answer_ready;
            end else if (speaks) begin
                answers_q <= !answers_q;
                rests_q   <= answers_q;
            end
            said_q    <= !answers_q ? 3'd0 : (valid && answer_ready) ? said_q + 3'd1 : said_q;
            writing_q <= credit && ((byte && first) || (writing_q && !packet));
            dropped_q <= !credit && writing_q;
            if (byte) begin
                written_q <= first ? 2'd1 : written_q + 2'd1;
            end
            busy_q <= (tx_valid && tx_ready) ? 2'd3 : (busy_q == 2'd0) ? 2'd0 : busy_q - 2'd1;
        end
    end

    wh_cobs #(
        .PACKET         (3),
        .SLOT_LOG2      (2)
    ) block (
        .clk            (clk),
        .rst            (rst),
        .credit_i       (credit),
        .answers_i      (answers_q),
        .rests_i        (rests_q),
        .answer_valid_i (valid),
        .answer_i       (answer),
        .answer_ready_o (answer_ready),
        .byte_valid_i   (byte),
        .byte_first_i   (first),
        .byte_i         (data),
        .packet_i       (packet),
        .room_o         (room),
        .tx_valid_o     (tx_valid),
        .tx_data_o      (tx_data),
        .tx_ready_i     (tx_ready)
    );

    (* hierconn *) wire [2:0] \block.state_q ;
    (* hierconn *) wire [2:0] \block.write_slot_q ;
    (* hierconn *) wire [2:0] \block.read_slot_q ;
    (* hierconn *) wire [2:0] \block.waiting_q ;
    (* hierconn *) wire [2:0] \block.count_q ;
    (* hierconn *) wire       \block.framed_q ;
    (* hierconn *) wire       \block.stale_q ;
    (* hierconn *) wire       \block.sends_packet_q ;
    (* hierconn *) wire       \block.skips_q ;
    (* hierconn *) wire [1:0] \block.clock_q ;
    (* hierconn *) wire [4:0] \block.at_q ;
    (* hierconn *) wire [4:0] \block.end_q ;
    (* hierconn *) wire [4:0] \block.begin_q ;
    (* hierconn *) wire [7:0] \block.code_q ;
    (* hierconn *) wire [7:0] \block.from_ram_q ;
    (* hierconn *) wire [7:0] \block.byte_q ;
    (* hierconn *) wire [7:0] \block.memory[0] ;
    (* hierconn *) wire [7:0] \block.memory[1] ;
    (* hierconn *) wire [7:0] \block.memory[2] ;
    (* hierconn *) wire [7:0] \block.memory[3] ;
    (* hierconn *) wire [7:0] \block.memory[4] ;
    (* hierconn *) wire [7:0] \block.memory[5] ;
    (* hierconn *) wire [7:0] \block.memory[6] ;
    (* hierconn *) wire [7:0] \block.memory[7] ;
    (* hierconn *) wire [7:0] \block.memory[8] ;
    (* hierconn *) wire [7:0] \block.memory[9] ;
    (* hierconn *) wire [7:0] \block.memory[10] ;
    (* hierconn *) wire [7:0] \block.memory[11] ;
    (* hierconn *) wire [7:0] \block.memory[12] ;
    (* hierconn *) wire [7:0] \block.memory[13] ;
    (* hierconn *) wire [7:0] \block.memory[14] ;
    (* hierconn *) wire [7:0] \block.memory[15] ;
    (* hierconn *) wire [7:0] \block.memory[16] ;
    (* hierconn *) wire [7:0] \block.memory[17] ;
    (* hierconn *) wire [7:0] \block.memory[18] ;
    (* hierconn *) wire [7:0] \block.memory[19] ;
    (* hierconn *) wire [7:0] \block.memory[20] ;
    (* hierconn *) wire [7:0] \block.memory[21] ;
    (* hierconn *) wire [7:0] \block.memory[22] ;
    (* hierconn *) wire [7:0] \block.memory[23] ;
    (* hierconn *) wire [7:0] \block.memory[24] ;
    (* hierconn *) wire [7:0] \block.memory[25] ;
    (* hierconn *) wire [7:0] \block.memory[26] ;
    (* hierconn *) wire [7:0] \block.memory[27] ;
    (* hierconn *) wire [7:0] \block.memory[28] ;
    (* hierconn *) wire [7:0] \block.memory[29] ;
    (* hierconn *) wire [7:0] \block.memory[30] ;
    (* hierconn *) wire [7:0] \block.memory[31] ;
    wire [255:0] bytes = {\block.memory[31] , \block.memory[30] , \block.memory[29] , \block.memory[28] , \block.memory[27] , \block.memory[26] , \block.memory[25] , \block.memory[24] , \block.memory[23] , \block.memory[22] , \block.memory[21] , \block.memory[20] , \block.memory[19] , \block.memory[18] , \block.memory[17] , \block.memory[16] , \block.memory[15] , \block.memory[14] , \block.memory[13] , \block.memory[12] , \block.memory[11] , \block.memory[10] , \block.memory[9] , \block.memory[8] , \block.memory[7] , \block.memory[6] , \block.memory[5] , \block.memory[4] , \block.memory[3] , \block.memory[2] , \block.memory[1] , \block.memory[0] };

    wire [2:0] state   = \block.state_q ;
    wire [2:0] waiting = \block.waiting_q ;
    wire [4:0] at      = \block.at_q ;
    wire [4:0] begins_at = \block.begin_q ;
    wire [4:0] ends_at = \block.end_q ;
    wire [7:0] code    = \block.code_q ;
    wire       idle    = (state == IDLE);
    wire       packets = !idle && \block.sends_packet_q ;
    wire [2:0] sent    = begins_at[4:2];  // slot

    // Behind the bytes of the block that are known to be no zeros, and their first.
    wire [4:0] from = (state == BYTES) ? at : begins_at;
    wire [8:0] to   = (state == SCAN) ? {4'd0, at}
                    : (state == CODE) ? {4'd0, begins_at} + {1'b0, code} - 9'd1
                    : (state == BYTES) ? {4'd0, at} + {1'b0, code} : 9'd0;

    // Slots in turn, from the one that is read next on.
    wire [3:0] ahead = {1'b0, \block.read_slot_q } + {1'b0, waiting};
    wire [3:0] next  = (ahead > 4'd7) ? ahead - 4'd6 : ahead;
    wire [2:0] behind = (\block.read_slot_q == 3'd2) ? 3'd7 : \block.read_slot_q - 3'd1;

    reg        plain_q;   // the answer began without credit
    reg        quiet_q;
    reg        credit_q;
    reg        rst_q;
    reg        idle_q;
    reg  [2:0] state_before_q;
    reg  [1:0] age_q;     // clocks since at changed, 2 or more
    integer    k;

    always @(posedge clk) begin
        rst_q    <= rst;
        quiet_q  <= !answers_q && !rests_q;
        credit_q <= credit;
        idle_q   <= idle;
        state_before_q <= state;
        if (!answers_q && !rests_q) begin
            plain_q <= !credit;
        end

        if (!begun) begin
            assume (rst);
        end else if (rst_q) begin
            assert (idle && waiting == 3'd0 && !\block.framed_q && !\block.stale_q );
        end else begin
            // ---- What is promised.

            // Without credit.
            if (answers_q && plain_q) begin
                assert (!\block.framed_q );
                if (idle) begin
                    assert (tx_valid == valid && answer_ready == tx_ready);
                    assert (!tx_valid || tx_data == answer);
                end else begin
                    assert (!answer_ready);
                end
            end
            if (idle && !(answers_q && plain_q)) assert (!tx_valid);
            if (idle_q && !idle && quiet_q) assert (credit_q);
            if (rests_q && plain_q) assert (idle || packets);

            // A zero at the end of a frame, and nowhere else.
            if (tx_valid && tx_ready && !idle) assert ((tx_data == 8'd0) == (state == END));
            if (idle && !idle_q) assert (state_before_q == REST);

            // Nothing but what is under way is before an answer, and its own frame.
            if (packets && idle_q) assert (quiet_q && credit_q);
            if (packets && byte) assert (\block.write_slot_q != sent);

            // ---- What that follows from.
            assert (state <= REST);
            assert (!(answers_q && rests_q));
            assert (\block.framed_q == (quiet_q ? credit_q : \block.framed_q ));
            if (answers_q || rests_q) assert (plain_q == !\block.framed_q );
            if (!idle && !\block.sends_packet_q ) assert (rests_q && !plain_q);
            if (answers_q) assert (\block.count_q == (plain_q ? 3'd0 : said_q));
            if (plain_q) assert (\block.count_q == 3'd0);
            if (!answers_q && !rests_q) assert (\block.count_q == 3'd0);

            assert (\block.read_slot_q >= 3'd2 && \block.write_slot_q >= 3'd2);
            assert (waiting <= 3'd5 && next == {1'b0, \block.write_slot_q });
            if (writing_q || dropped_q) assert (waiting <= 3'd4);
            if (writing_q) assert (!\block.stale_q );
            if (packets) begin
                assert (sent >= 3'd2 && ends_at == {sent, 2'd3});
                assert (\block.stale_q || sent == behind);
                if (dropped_q) assert (sent != \block.write_slot_q );
            end
            if (!idle && !packets) begin
                assert (sent <= 3'd1 && ends_at <= 5'd7 && ends_at != 5'd0);
                assert (\block.count_q == ((state == REST) ? 3'd0 : ends_at[2:0]));
            end
            if (!idle && state != REST && state != END) begin
                assert (begins_at <= ends_at && at <= ends_at && begins_at <= at);
            end
            if (state == SCAN) assert (code == {3'd0, at} - {3'd0, begins_at} + 8'd1);
            if (state == CODE) begin
                assert (at == begins_at && code >= 8'd1 && code <= 8'd32);
                assert (to + {8'd0, \block.skips_q } <= {4'd0, ends_at});
            end
            if (state == BYTES) begin
                assert (code >= 8'd1 && code <= 8'd32);
                assert (to + {8'd0, \block.skips_q } <= {4'd0, ends_at});
            end
            if (state == NEXT) assert ({1'b0, at} + {5'd0, \block.skips_q } <= {1'b0, ends_at});
            if (state == SCAN) assert (\block.clock_q <= 2'd2);
            for (k = 0; k < 32; k = k + 1) begin
                if (state == SCAN || state == CODE || state == BYTES) begin
                    if (k >= from && k < to) assert (bytes[8*k +: 8] != 8'd0);
                end
            end
            // What the memory puts out, after its clocks.
            if (state == SCAN && \block.clock_q >= 2'd1) assert (\block.from_ram_q == bytes[8*at +: 8]);
            if (state == SCAN && \block.clock_q == 2'd2) assert (\block.byte_q == bytes[8*at +: 8]);
            if (state == BYTES && busy_q <= 2'd1) assert (\block.from_ram_q == bytes[8*at +: 8]);
            if (state == BYTES && busy_q == 2'd0) assert (\block.byte_q == bytes[8*at +: 8]);

            cover (state == CODE && packets && \block.skips_q );
            cover (answers_q && plain_q && packets);
            cover (state == END && !packets && \block.count_q == 3'd1);
            cover (waiting == 3'd2 && packets);
            cover (\block.stale_q && credit);
        end
    end

endmodule

`default_nettype wire
