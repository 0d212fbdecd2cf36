// SPDX-License-Identifier: Apache-2.0
//
// wh_uart: bytes over a serial line, 8 bits, no parity, one stop bit, least bit first.
//
//   a bit takes bit_clocks_i / 16 clocks; edges are at the nearest clock, and errors don't add up
//
// A level counts that two of three successive clocks had. A byte starts with a low level that is still
// there half a bit later; its bits are read in their middles. With a stop bit that is low the byte's
// strobe comes with rx_error_o, and the next byte starts after the line was high again.
// A byte to be sent is taken in a clock with tx_valid_i and tx_ready_o, which is high once the stop
// bit of the one before is over.
//
// Formats: bit_clocks_i u16q4 clocks, 6 clocks or more; it may change while nothing is on the way.
// Latency: rx_valid_o comes 4 or 5 clocks after the middle of the stop bit; tx_o falls a clock after the
// byte was taken. Reset: the line rests, high; a byte that is being received is lost.

`default_nettype none

module wh_uart (
    input  wire        clk,
    input  wire        rst,

    input  wire [15:0] bit_clocks_i,

    // The line.
    input  wire        rx_i,        // asynchronous
    output wire        tx_o,

    // Received.
    output wire        rx_valid_o,  // strobe
    output wire        rx_error_o,  // with the strobe: there was no stop bit
    output wire [7:0]  rx_data_o,

    // To be sent.
    input  wire        tx_valid_i,
    input  wire [7:0]  tx_data_i,
    output wire        tx_ready_o
);

    localparam [15:0] CLOCK = 16'd16;

    // ---- Reception.

    wire level;

    wh_synchroniser #(
        .WIDTH   (1)
    ) line (
        .clk     (clk),
        .level_i (rx_i),
        .level_o (level)
    );

    reg [1:0] before_q;
    wire      high = (level && before_q[0]) || (level && before_q[1]) || (&before_q);

    reg        rx_busy_q;
    reg        rx_wait_q;   // for a high level
    reg        rx_start_q;  // the start bit is under way
    reg        rx_valid_q;
    reg        rx_error_q;
    reg [15:0] rx_left_q;   // to the next bit's middle, in clocks / 16
    reg [8:0]  rx_bits_q;   // the highest is the last one; a 1 in the lowest says that all are there

    // The level is seen half a clock late on average, and counted from the clock after.
    localparam [15:0] LATE = 16'd24;

    wire rx_middle = (rx_left_q < CLOCK);

    assign rx_valid_o = rx_valid_q;
    assign rx_error_o = rx_error_q;
    assign rx_data_o  = rx_bits_q[8:1];

    always @(posedge clk) begin
        before_q <= {before_q[0], level};
        if (!rx_busy_q) begin
            rx_left_q <= {1'b0, bit_clocks_i[15:1]} - LATE;
        end else begin
            rx_left_q <= rx_left_q - CLOCK + (rx_middle ? bit_clocks_i : 16'd0);
        end
        if (rst) begin
            rx_busy_q  <= 1'b0;
            rx_wait_q  <= 1'b1;
            rx_start_q <= 1'b0;
            rx_valid_q <= 1'b0;
            rx_error_q <= 1'b0;
            rx_bits_q  <= 9'd0;
        end else begin
            rx_valid_q <= 1'b0;
            if (!rx_busy_q) begin
                rx_wait_q  <= rx_wait_q && !high;
                rx_busy_q  <= !rx_wait_q && !high;
                rx_start_q <= 1'b1;
            end else if (rx_middle) begin
                rx_start_q <= 1'b0;
                if (rx_start_q) begin
                    rx_busy_q <= !high;
                    rx_bits_q <= 9'h100;
                end else if (rx_bits_q[0]) begin
                    rx_busy_q  <= 1'b0;
                    rx_wait_q  <= !high;
                    rx_error_q <= !high;
                    rx_valid_q <= 1'b1;
                end else begin
                    rx_bits_q <= {high, rx_bits_q[8:1]};
                end
            end
        end
    end

    // ---- Transmission.

    reg        tx_busy_q;
    reg [15:0] tx_left_q;  // to the bit's end, in clocks / 16
    reg [9:0]  tx_bits_q;  // the lowest is on the line; a 1 above the last one, zeros further up

    wire tx_end = (tx_left_q < CLOCK);

    assign tx_o       = tx_bits_q[0] || !tx_busy_q;
    assign tx_ready_o = !tx_busy_q;

    always @(posedge clk) begin
        if (!tx_busy_q) begin
            tx_left_q <= bit_clocks_i - CLOCK;
            tx_bits_q <= {1'b1, tx_data_i, 1'b0};
        end else begin
            tx_left_q <= tx_left_q - CLOCK + (tx_end ? bit_clocks_i : 16'd0);
            // The stop bit stays, so that the line's gate sees one change at a time.
            if (tx_end && tx_bits_q != 10'd1) begin
                tx_bits_q <= {1'b0, tx_bits_q[9:1]};
            end
        end
        if (rst) begin
            tx_busy_q <= 1'b0;
        end else if (!tx_busy_q) begin
            tx_busy_q <= tx_valid_i;
        end else if (tx_end && tx_bits_q == 10'd1) begin
            tx_busy_q <= 1'b0;
        end
    end

endmodule

`default_nettype wire
