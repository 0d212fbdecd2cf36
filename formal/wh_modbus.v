// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_modbus: what a frame has to be before anything comes of it, and when the slave is done with it.
// Beside the block stand the frame's unit, function and length, and whether its CRC was zero at its
// end; that it is the right CRC is left to the tests. The line, the bus and what the memories hold are
// anything at all.

`default_nettype none

module prove_wh_modbus (
    input wire        clk,
    input wire        rst,
    input wire        rx_valid,
    input wire        rx_error,
    input wire [7:0]  rx_data,
    input wire        tx_ready,
    input wire        bus_ready,
    input wire [31:0] bus_read,
    input wire [1:0]  bus_error,
    input wire        bus_signed
);

    localparam integer SILENCE = 4;
    localparam [7:0]   UNIT    = 8'd1;

    wire        tx_valid, bus_valid, bus_write, bus_check;
    wire [7:0]  tx_data;
    wire [1:0]  rate;
    wire [11:0] bus_address;
    wire [31:0] bus_data;

    wh_modbus #(
        .SILENCE       (SILENCE),
        .FALLBACK      (3)
    ) block (
        .clk           (clk),
        .rst           (rst),
        .rx_valid_i    (rx_valid),
        .rx_error_i    (rx_error),
        .rx_data_i     (rx_data),
        .tx_valid_o    (tx_valid),
        .tx_data_o     (tx_data),
        .tx_ready_i    (tx_ready),
        .rate_o        (rate),
        .bus_valid_o   (bus_valid),
        .bus_write_o   (bus_write),
        .bus_check_o   (bus_check),
        .bus_address_o (bus_address),
        .bus_data_o    (bus_data),
        .bus_ready_i   (bus_ready),
        .bus_data_i    (bus_read),
        .bus_error_i   (bus_error),
        .bus_signed_i  (bus_signed)
    );

    (* hierconn *) wire [4:0]  \block.state_q ;
    (* hierconn *) wire [2:0]  \block.step_q ;
    (* hierconn *) wire [7:0]  \block.place_q ;
    (* hierconn *) wire [7:0]  \block.end_q ;
    (* hierconn *) wire [15:0] \block.crc_q ;
    (* hierconn *) wire [15:0] \block.address_q ;
    (* hierconn *) wire [10:0] \block.taken_q ;
    (* hierconn *) wire [1:0]  \block.pass_q ;
    (* hierconn *) wire [1:0]  \block.counter_q ;
    (* hierconn *) wire [1:0]  \block.late_q ;
    (* hierconn *) wire [1:0]  \block.period_q ;
    (* hierconn *) wire        \block.stores ;
    (* hierconn *) wire        \block.breaks ;
    (* hierconn *) wire        \block.broken ;
    (* hierconn *) wire        \block.hangs ;
    (* hierconn *) wire        \block.skip_q ;
    (* hierconn *) wire        \block.mine_q ;
    (* hierconn *) wire        \block.all_q ;
    (* hierconn *) wire        \block.reads_q ;
    (* hierconn *) wire        \block.writes_q ;
    (* hierconn *) wire        \block.one_q ;
    (* hierconn *) wire        \block.names_q ;
    (* hierconn *) wire        \block.open_q ;
    (* hierconn *) wire        \block.whole_q ;
    (* hierconn *) wire        \block.sends_q ;
    (* hierconn *) wire        \block.refused_q ;

    localparam [4:0] GET = 5'd0, TAKE = 5'd1, SHIFT = 5'd2, NEXT = 5'd3, END = 5'd4, COUNT = 5'd5;
    localparam [4:0] CARRY = 5'd6, POLL = 5'd7, HEAD = 5'd8, LOAD = 5'd12, ASK = 5'd13, DROP = 5'd15;
    localparam [4:0] RATE = 5'd14, EMIT = 5'd16, STEP = 5'd17, STAGED = 5'd18, GIVE = 5'd19;
    localparam [4:0] ANSWER = 5'd20, SEND = 5'd21, SENT = 5'd22, REST = 5'd23;

    wire [4:0]  state   = \block.state_q ;
    wire [2:0]  step    = \block.step_q ;
    wire [7:0]  place   = \block.place_q ;
    wire [1:0]  pass    = \block.pass_q ;
    wire [7:0]  byte_in = \block.taken_q [7:0];
    wire        stores  = \block.stores ;
    wire        skips   = \block.skip_q ;
    wire        sends   = \block.sends_q ;
    wire        refused = \block.refused_q ;
    wire [15:0] address = \block.address_q ;

    reg         begun = 1'b0;
    reg  [8:0]  count_q;     // bytes of the frame
    reg  [7:0]  unit_q;
    reg  [7:0]  function_q;
    reg  [7:0]  type_q;      // byte 2
    reg  [7:0]  size_q;      // byte 6
    reg         zero_q;      // so was the CRC at their end
    reg         spoilt_q;    // a byte that was none, or lost, and no silence since
    reg         answered_q;
    reg         judged_q;    // a word was refused when words were judged
    reg         failed_q;    // or when they were written
    reg  [4:0]  wait_q;

    wire [4:0]  waits = (step == 3'd0) ? 5'd0 : wait_q;  // clocks for one request of the bus
    wire        first = (count_q == 9'd0);

    wire asks   = (state == POLL) || (state == ASK) || (state == STAGED) || (state == GIVE);
    wire takes  = (state == GET) || (state == TAKE) || (state == NEXT) || (state == END)
                  || (state == SHIFT && !sends);
    wire counts = (state == COUNT) || (state == CARRY);
    wire acts   = (state >= POLL) || (state == SHIFT && sends);
    // The answer is on its way, or there is none.
    wire done   = (state == SEND) || (state == SENT) || (state == SHIFT && sends) || (state == REST);

    // By its function and length.
    wire simple = (function_q == 8'd3) || (function_q == 8'd4) || (function_q == 8'd6);
    wire many   = (function_q == 8'd16);
    wire named  = (function_q == 8'd43);
    wire open   = !(simple || (many && (count_q < 9'd7 || size_q < 8'd248))
                    || (named && (count_q < 9'd3 || type_q == 8'd14)));
    wire whole  = simple ? (count_q == 9'd8)
                : many   ? (count_q == size_q + 9'd9 && size_q < 8'd248 && count_q >= 9'd9)
                         : (named && type_q == 8'd14 && count_q == 9'd7);
    wire right  = zero_q && !spoilt_q && (unit_q == 8'd0 || unit_q == UNIT)
                  && (whole || (open && count_q >= 9'd4));

    always @(posedge clk) begin
        begun <= 1'b1;
        if (stores) begin
            count_q <= count_q + 9'd1;
            if (count_q == 9'd0) unit_q     <= byte_in;
            if (count_q == 9'd1) function_q <= byte_in;
            if (count_q == 9'd2) type_q     <= byte_in;
            if (count_q == 9'd6) size_q     <= byte_in;
            if (first) answered_q <= 1'b0;
            judged_q <= 1'b0;
            failed_q <= 1'b0;
        end
        if (state == GET && place == 8'd0) count_q <= 9'd0;
        if (state == NEXT || state == END) zero_q <= (\block.crc_q == 16'd0);
        if (state == TAKE && !\block.breaks && \block.broken ) spoilt_q <= 1'b1;
        if (state == END) spoilt_q <= 1'b0;
        if (state == ANSWER) answered_q <= 1'b1;
        if (bus_valid && bus_write && bus_check && bus_ready && bus_error != 2'd0 && pass != 2'd0) begin
            judged_q <= 1'b1;
        end
        if (bus_valid && bus_write && !bus_check && bus_ready && bus_error != 2'd0) failed_q <= 1'b1;
        wait_q <= waits + 5'd1;
        if (rst) begin
            count_q  <= 9'd0;
            spoilt_q <= 1'b0;
        end
    end

    // What holds between any two clocks, and leads to what is asked for below.

    wire line_holds = (state == GET || state == TAKE || state == END)
            ? (!(skips && place != 8'd0) && (place == 8'd0 || count_q == {1'b0, place})
               && (!spoilt_q || skips) && (state != TAKE || place != 8'd0 || first)
               && (state != END || skips || place != 8'd0))
        : (takes && !skips && !spoilt_q && !first && count_q == place + 9'd1);

    wire inside = (takes && place != 8'd0) || (takes && (state == SHIFT || state == NEXT))
                  || (counts && \block.counter_q == 2'd0) || acts;
    wire known  = inside && (count_q >= 9'd2);

    wire flags_hold = (\block.mine_q == (unit_q == 8'd0 || unit_q == UNIT))
                      && (\block.all_q == (unit_q == 8'd0)) && !first;
    wire kind_holds = (\block.reads_q == (function_q == 8'd3 || function_q == 8'd4))
                      && (\block.writes_q == (function_q == 8'd6 || many))
                      && (\block.one_q == (function_q == 8'd6))
                      && (\block.names_q == (named && (count_q < 9'd3 || type_q == 8'd14)))
                      && (\block.open_q == open);
    wire end_holds  = open || (\block.end_q == (simple ? 8'd7 : (many && count_q >= 9'd7) ? size_q + 8'd8
                                                             : 8'd6));
    wire fits       = (address[15:13] == 3'd1 && address[12:2] != 11'h038)
                      || (address[15:1] == 15'd5);

    wire holds = (state <= REST) && (count_q <= 9'd256)
            && (!takes || line_holds)
            && (!sends || done) && (sends || !(state == SEND || state == SENT))
            && (!(counts && spoilt_q) || skips)
            && (!inside || flags_hold) && (!known || kind_holds)
            && (!(known && takes) || end_holds)
            && (!((state == TAKE && first) || (takes && inside && !known)) || \block.end_q == 8'hff)
            && (!(takes && inside) || (pass == 2'd0 && !refused && !answered_q && !judged_q && !failed_q))
            && (!(counts && \block.counter_q == 2'd0)
                || (right && pass == 2'd0 && !refused && !answered_q && !judged_q && !failed_q))
            && (!(state == NEXT && \block.whole_q ) || whole)
            && (!acts || right)
            && (!(acts && !done) || !answered_q)
            && (!(acts && done && state != REST) || (answered_q && unit_q != 8'd0))
            && (!(acts && pass != 2'd0) || \block.writes_q )
            && (!(acts && pass[1]) || !judged_q)
            && (!(acts && failed_q) || refused)
            && (!(acts && !pass[1]) || !failed_q)
            && (state != GIVE || bus_data[0])
            && (!((state == STAGED) || (state == GIVE)) || pass[1])
            && (!(acts && judged_q) || (refused && (done || state == ANSWER)))
            && (!(acts && !done && state != ANSWER && refused) || (state == STAGED || state == GIVE))
            && (!(state == POLL) || (pass == 2'd0 && \block.writes_q && !judged_q))
            && (!((state == LOAD || state == ASK || state == RATE || state == STEP) && \block.writes_q )
                || state == STEP || fits)
            && (!(state == ASK) || address[15:13] == 3'd1)
            && (!(pass == 2'd3 && acts && !done) || state == STAGED || state == GIVE || state == ANSWER)
            && (!asks || waits <= {1'b0, \block.late_q , 2'd0} + {3'd0, \block.period_q })
            && (!(state == HEAD || state == LOAD) || step <= 3'd4)
            && (!(state == DROP || state == EMIT) || step <= 3'd1);

    wire writes = bus_valid && bus_write && !bus_check;

    always @(posedge clk) begin
        // From reset, or from anything that a run leaves behind.
        if (!begun) begin
            assume (rst || holds);
        end else begin
            assert (holds);

            // The bus is asked for nothing before a whole frame's CRC was right, of this unit or of all.
            if (bus_valid) assert (right);
            // Only functions 6 and 16 write, or judge, and these with all their bytes.
            if (bus_valid && bus_write) begin
                assert (function_q == 8'd6 || many);
                if (function_q == 8'd6) assert (count_q == 9'd8);
                if (many && size_q < 8'd248) assert (count_q == size_q + 9'd9);
            end
            // Nothing is written of a frame of which a word was refused.
            if (writes) assert (!judged_q);
            // Words are given by the block itself, none of which was refused; else they are forgotten.
            if (bus_valid && bus_write && bus_address[11:1] == 11'h038) begin
                assert (state == GIVE && bus_data[0] && !bus_check);
                if (!bus_address[0]) assert (!failed_q && !judged_q);
                if (bus_address[0]) assert (refused);
            end
            // An answer is that of a frame for this unit alone, and the only one.
            if (tx_valid) assert (right && unit_q == UNIT && answered_q);
            if (state == ANSWER) assert (!answered_q);
            // Nothing waits for the bus longer than four silences.
            if (asks) assert (waits <= 4 * SILENCE);
        end

        cover (begun && writes && bus_address == 12'h070 && bus_ready);
        cover (begun && writes && bus_address == 12'h071 && bus_ready && failed_q);
        cover (begun && writes && many && count_q == 9'd13 && bus_ready && bus_error == 2'd0);
        cover (begun && tx_valid && tx_ready);
        cover (begun && state == GIVE && unit_q == 8'd0);
        cover (begun && asks && waits == 5'd12);
    end

endmodule

`default_nettype wire
