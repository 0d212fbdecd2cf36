// SPDX-License-Identifier: Apache-2.0
//
// wh_spi: bytes over SPI as a slave, most significant bit first, mode 0 (mode 3 works as well).
//
//   a transfer   CS low, any number of bytes both ways, CS high
//   MISO         the bytes that wait to be sent, in their order; 0 where none waits
//
// SCLK is sampled: at most a sixth of clk, each level for two clocks or longer. CS falls six clocks before the first
// edge of SCLK, rises three after the last one, and stays high for eight. A level counts that two of three successive
// samples had, so a shorter pulse on CS or SCLK does nothing. MISO changes after SCLK's rising edge: the master has a
// whole period less four clocks to sample it at the next one. 512 bytes can wait to be sent. A byte leaves when its
// last bit is read: what a transfer broke off comes again, whole, with the next one.
//
// A transfer that ends within a byte gives a byte with rx_error_o. A transfer that began before takes_i rose is not
// heard, and while takes_i is low nothing waits to be sent. drives_o is for the pad, if others share MISO.
// Latency: rx_valid_o comes 4 or 5 clocks after the eighth rising edge, ends_o 5 or 6 after CS.
// Reset: no transfer, until CS has been high; nothing waits.

`default_nettype none

module wh_spi (
    input  wire       clk,
    input  wire       rst,

    // The pins.
    input  wire       cs_n_i,      // asynchronous
    input  wire       sclk_i,      // asynchronous
    input  wire       mosi_i,      // asynchronous
    output wire       miso_o,
    output wire       drives_o,    // CS is low

    // A transfer.
    input  wire       takes_i,
    output reg        begins_o,    // strobe
    output reg        ends_o,      // strobe, after the last byte's

    // Received.
    output reg        rx_valid_o,  // strobe
    output reg        rx_error_o,  // with the strobe: the transfer has ended within the byte
    output wire [7:0] rx_data_o,

    // To be sent.
    input  wire       tx_valid_i,
    input  wire [7:0] tx_data_i,
    output wire       tx_ready_o
);

    // ---- The levels.

    wire cs;
    wire sclk;
    wire mosi;

    wh_synchroniser #(
        .WIDTH   (3)
    ) pins (
        .clk     (clk),
        .level_i ({cs_n_i, sclk_i, mosi_i}),
        .level_o ({cs, sclk, mosi})
    );

    reg [1:0] cs_q;
    reg [1:0] sclk_q;
    reg       mosi_q;  // as SCLK was first sampled high
    reg       high_q;
    reg       apart_q; // CS has been high
    reg       open_q;  // it is low

    wire cs_high   = (cs && cs_q[0]) || (cs && cs_q[1]) || (&cs_q);
    wire sclk_high = (sclk && sclk_q[0]) || (sclk && sclk_q[1]) || (&sclk_q);
    wire rises     = open_q && sclk_high && !high_q;
    wire ends      = open_q && cs_high;

    always @(posedge clk) begin
        cs_q   <= {cs_q[0], cs};
        sclk_q <= {sclk_q[0], sclk};
        mosi_q <= mosi;
        high_q <= sclk_high;
        if (rst) begin
            apart_q  <= 1'b0;
            open_q   <= 1'b0;
            begins_o <= 1'b0;
        end else begin
            apart_q  <= apart_q || cs_high;
            open_q   <= apart_q && !cs_high;
            begins_o <= apart_q && !cs_high && !open_q;
        end
    end

    assign drives_o = open_q;

    // ---- Reception.

    reg  [7:0] in_q;
    reg  [2:0] bits_q;
    reg        deaf_q;   // to this transfer
    reg        ended_q;
    wire       whole = rises && (&bits_q);

    assign rx_data_o = in_q;

    always @(posedge clk) begin
        if (rises) begin
            in_q <= {in_q[6:0], mosi_q};
        end
        if (rst) begin
            bits_q     <= 3'd0;
            deaf_q     <= 1'b0;
            ended_q    <= 1'b0;
            ends_o     <= 1'b0;
            rx_valid_o <= 1'b0;
            rx_error_o <= 1'b0;
        end else begin
            bits_q     <= !open_q ? 3'd0 : bits_q + {2'd0, rises};
            deaf_q     <= open_q && (deaf_q || (whole && !takes_i));
            ended_q    <= ends;
            ends_o     <= ended_q;
            rx_error_o <= ends;
            rx_valid_o <= takes_i && !deaf_q && (ends ? bits_q != 3'd0 : whole);
        end
    end

    // ---- What waits to be sent.

    (* ram_style = "block" *) reg [7:0] waiting [0:511];

    reg  [8:0] write_q;
    reg  [8:0] read_q;
    reg  [7:0] from_ram_q;   // what block RAM puts out comes late in its clock: it gets one more
    reg  [7:0] next_q;
    reg  [1:0] there_q;      // from_ram_q and next_q are bytes that wait
    reg  [7:0] out_q;
    reg        holds_q;      // out_q is the byte at read_q
    wire [8:0] after_write = write_q + 9'd1;
    wire [8:0] at          = read_q + {8'd0, open_q && holds_q};

    assign tx_ready_o = (after_write != read_q);
    assign miso_o     = out_q[7];

    always @(posedge clk) begin
        if (tx_valid_i && tx_ready_o) begin
            waiting[write_q] <= tx_data_i;
        end
        from_ram_q <= waiting[at];
        next_q     <= from_ram_q;
        if (!open_q || whole) begin
            out_q <= there_q[1] ? next_q : 8'd0;
        end else if (rises) begin
            out_q <= {out_q[6:0], 1'b0};
        end
        if (rst || !takes_i) begin
            write_q <= 9'd0;
            read_q  <= 9'd0;
            there_q <= 2'd0;
            holds_q <= 1'b0;
        end else begin
            there_q <= {there_q[0], at != write_q};
            if (tx_valid_i && tx_ready_o) begin
                write_q <= after_write;
            end
            if (!open_q || whole) begin
                holds_q <= there_q[1];
            end
            if (whole && holds_q) begin
                read_q <= read_q + 9'd1;
            end
        end
    end

endmodule

`default_nettype wire
