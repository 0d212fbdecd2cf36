// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_uart: bits are read and sent at their times to the clock, so that errors don't add up; a byte
// received is the nine levels at its bits' middles, and one without a stop bit says so; after that none
// begins before the line was high. The line does what it likes.

`default_nettype none

module prove_wh_uart #(
    parameter [15:0] BIT_CLOCKS = 16'd0     // sixteenths of a clock; 0: any
) (
    input wire       clk,
    input wire       rst,
    input wire       rx,
    input wire       tx_valid,
    input wire [7:0] tx_data
);

    (* anyconst *) wire [15:0] any_clocks;

    wire [15:0] bit_clocks = (BIT_CLOCKS == 16'd0) ? any_clocks : BIT_CLOCKS;

    wire       tx, rx_valid, rx_error, tx_ready;
    wire [7:0] rx_data;

    wh_uart block (
        .clk          (clk),
        .rst          (rst),
        .bit_clocks_i (bit_clocks),
        .rx_i         (rx),
        .tx_o         (tx),
        .rx_valid_o   (rx_valid),
        .rx_error_o   (rx_error),
        .rx_data_o    (rx_data),
        .tx_valid_i   (tx_valid),
        .tx_data_i    (tx_data),
        .tx_ready_o   (tx_ready)
    );

    (* hierconn *) wire        \block.high ;
    (* hierconn *) wire        \block.rx_busy_q ;
    (* hierconn *) wire        \block.rx_wait_q ;
    (* hierconn *) wire        \block.rx_start_q ;
    (* hierconn *) wire        \block.rx_middle ;
    (* hierconn *) wire [15:0] \block.rx_left_q ;
    (* hierconn *) wire [8:0]  \block.rx_bits_q ;
    (* hierconn *) wire        \block.tx_busy_q ;
    (* hierconn *) wire [15:0] \block.tx_left_q ;
    (* hierconn *) wire [9:0]  \block.tx_bits_q ;

    wire        high    = \block.high ;
    wire        busy    = \block.rx_busy_q ;
    wire        waits   = \block.rx_wait_q ;
    wire        middle  = \block.rx_middle && busy;
    wire        sending = \block.tx_busy_q ;
    wire [19:0] long_bit = {4'd0, bit_clocks};

    // The bits of a byte as they come in from above, behind a mark.
    function [8:0] shown;
        input [3:0] count;
        input [7:0] value;
        integer k;
        begin
            shown = 9'h100;
            for (k = 0; k < 8; k = k + 1) begin
                if (k + 1 < count) shown = {value[k], shown[8:1]};
            end
        end
    endfunction

    reg         begun = 1'b0;
    reg         high_q;
    reg         busy_q;
    reg         waits_q;
    reg         rst_q;
    reg  [19:0] due_q;      // the next one's middle, in sixteenths since the start
    reg  [19:0] end_q;      // the end of the bit that is sent, likewise
    reg  [15:0] passed_q;   // clocks since the byte began, received
    reg  [3:0]  count_q;    // bits that were read, the start bit first
    reg  [7:0]  read_q;     // levels at their middles
    reg         stopped_q;  // so was the stop bit
    reg         ended_q;    // it was read in the clock before
    reg  [15:0] gone_q;     // clocks since the byte began, sent
    reg  [3:0]  sent_q;     // bits that are over
    reg  [7:0]  data_q;

    wire [9:0]  frame = {1'b1, data_q, 1'b0};

    always @(posedge clk) begin
        begun     <= 1'b1;
        rst_q     <= rst;
        high_q    <= high;
        busy_q    <= busy;
        waits_q   <= waits;
        ended_q   <= middle && count_q == 4'd9 && !rst;
        passed_q  <= (busy && !rst) ? passed_q + 16'd1 : 16'd0;
        if (!busy || rst) begin
            count_q <= 4'd0;
            due_q   <= long_bit >> 1;
        end else if (middle) begin
            due_q   <= due_q + long_bit;
            count_q <= count_q + 4'd1;
            if (count_q >= 4'd1 && count_q <= 4'd8) read_q[count_q - 4'd1] <= high;
            if (count_q == 4'd9) stopped_q <= high;
        end
        gone_q <= (sending && !rst) ? gone_q + 16'd1 : 16'd0;
        if (!sending) begin
            sent_q <= 4'd0;
            data_q <= tx_data;
            end_q  <= long_bit;
        end else if (\block.tx_left_q < 16'd16) begin
            end_q  <= end_q + long_bit;
            sent_q <= sent_q + 4'd1;
        end
        if (rst) sent_q <= 4'd0;

        assume (bit_clocks >= 16'd96 && bit_clocks < 16'd4096);
        if (!begun) begin
            assume (rst);
        end else begin
            // A byte is what was read, and tells whether its stop bit was there.
            assert (rx_valid == ended_q);
            if (rx_valid) assert (rx_data == read_q && rx_error == !stopped_q && stopped_q == high_q);
            // Bit k is read k bits and a half after the start was seen, to the clock.
            if (busy) begin
                assert ({passed_q, 4'd0} + {4'd0, \block.rx_left_q } + 20'd24 == due_q);
                assert (count_q <= 4'd9 && \block.rx_start_q == (count_q == 4'd0));
                assert (!waits);
            end
            // No byte begins after one without a stop bit, or a reset, before the line was high.
            if (rx_valid && rx_error) assert (waits);
            if (busy && !busy_q && !rst_q) assert (!waits_q && !high_q);
            if (!rst_q && waits_q && !waits) assert (high_q);
            if (rst_q) assert (waits && !busy && !rx_valid);

            // Bit k of a byte that is sent stands from k to k + 1 bits, to the clock.
            assert (tx_ready == !sending);
            assert (tx == (!sending || frame[sent_q]));
            if (sending) begin
                assert ({gone_q, 4'd0} + {4'd0, \block.tx_left_q } + 20'd16 == end_q);
            end

            // What makes that inductive.
            if (busy && count_q >= 4'd1) assert (\block.rx_bits_q == shown(count_q, read_q));
            if (rx_valid) assert (\block.rx_bits_q [8:1] == read_q);
            assert (\block.rx_left_q < bit_clocks || !busy);
            if (sending) begin
                assert (sent_q <= 4'd9 && \block.tx_bits_q == (frame >> sent_q));
                assert (\block.tx_left_q < bit_clocks);
            end
        end

        cover (begun && rx_valid && !rx_error && rx_data == 8'h5a);
        cover (begun && rx_valid && rx_error);
        cover (begun && sending && sent_q == 4'd9 && data_q == 8'hc3);
    end

endmodule

`default_nettype wire
