// SPDX-License-Identifier: Apache-2.0
//
// wh_link: the bus of the settings memory over a serial line: a UART (wh_uart) and a Modbus RTU slave
// (wh_modbus), whose header says what it does. With STREAM = 1 packets of a stream share the transmitter, and
// answers are framed, as long as there is credit (wh_cobs).
//
// With SPI = 1 a master on SPI (wh_spi) can have the slave in place of the UART, with the same frames:
//
//   CS falls: the UART isn't heard any more, and once the frame under way is over the master on SPI is;
//   no valid frame for a second: the UART has the slave again, and waiting answers are dropped
//
// Only one of the two is heard at a time, so the bus and the registers that wait for a commit have one master.
// Packets of a stream go out on the UART in either case.
//
//   rate_o of wh_modbus   0 115,200   1 1,000,000   2 1,500,000   3 3,000,000 bits a second
//
// Rates with fewer than six clocks a bit are refused. A request reaches the bus a clock late, out of
// registers, as the memory decodes its address in the same clock; so between two there is a clock
// without one. Latency and reset: those of the two, and that clock.

`default_nettype none

module wh_link #(
    parameter integer UNIT     = 1,         // these are wh_modbus's
    parameter integer CLOCK_HZ = 24000000,  // 700 kHz...
    parameter integer SILENCE  = CLOCK_HZ / 500,
    parameter integer FALLBACK = 500,
    parameter [31:0]  BUILD    = 32'd0,
    parameter [31:0]  OPTIONS  = 32'd0,
    parameter integer MOTORS   = 1,
    parameter integer STREAM   = 0,
    parameter integer SPI      = 0          // 1: an SPI slave beside the UART
) (
    input  wire        clk,
    input  wire        rst,

    input  wire        uart_rx_i,     // asynchronous
    output wire        uart_tx_o,
    input  wire        spi_cs_n_i,    // asynchronous; these do nothing with SPI = 0
    input  wire        spi_sclk_i,    // asynchronous
    input  wire        spi_mosi_i,    // asynchronous
    output wire        spi_miso_o,
    output wire        spi_drives_o,  // CS is low

    // The bus (wh_registers).
    output reg         bus_valid_o,
    output reg         bus_write_o,
    output reg         bus_check_o,
    output reg  [11:0] bus_address_o,
    output reg  [31:0] bus_data_o,
    input  wire        bus_ready_i,
    input  wire [31:0] bus_data_i,
    input  wire [1:0]  bus_error_i,
    input  wire        bus_signed_i,

    // A stream's packets (wh_cobs).
    input  wire        stream_credit_i,
    input  wire        stream_valid_i,
    input  wire        stream_first_i,
    input  wire [7:0]  stream_byte_i,
    input  wire        stream_packet_i,
    output wire        stream_room_o
);

    generate
        if (CLOCK_HZ < 700000 || CLOCK_HZ > 400000000) begin : illegal
            wh_illegal_parameter_link_clock_hz_must_be_700000_to_400000000 stop ();
        end
        if (STREAM != 0 && STREAM != 1) begin : illegal_stream
            wh_illegal_parameter_link_stream_must_be_0_or_1 stop ();
        end
        if (SPI != 0 && SPI != 1) begin : illegal_spi
            wh_illegal_parameter_link_spi_must_be_0_or_1 stop ();
        end
    endgenerate

    localparam integer RATES = (CLOCK_HZ >= 18000000) ? 4 : (CLOCK_HZ >= 9000000) ? 3
                             : (CLOCK_HZ >= 6000000)  ? 2 : 1;

    // Clocks of a bit, u16q4, to the nearest.
    localparam [31:0] BIT_0 = (CLOCK_HZ + 3600) / 7200;
    localparam [31:0] BIT_1 = (CLOCK_HZ + 31250) / 62500;
    localparam [31:0] BIT_2 = (CLOCK_HZ + 46875) / 93750;
    localparam [31:0] BIT_3 = (CLOCK_HZ + 93750) / 187500;

    wire        rx_valid;
    wire        rx_error;
    wire [7:0]  rx_data;
    wire        heard_valid;    // of the UART or of SPI, whichever has the slave
    wire        heard_error;
    wire [7:0]  heard_data;
    wire        heard_end;
    wire        by_spi;         // SPI has it
    wire        spi_ready;
    wire        idle;
    wire        lost;
    wire        line_ready;     // the UART's
    wire        tx_valid;
    wire [7:0]  tx_data;
    wire        tx_ready;
    wire        answer_valid;
    wire [7:0]  answer;
    wire        answer_ready;
    wire        answers;
    wire        rests;
    wire [1:0]  rate;
    reg  [15:0] bit_clocks;
    wire        asks;
    wire        writes;
    wire        checks;
    wire [11:0] address;
    wire [31:0] data;

    always @* begin
        case (rate)
            2'd0:    bit_clocks = BIT_0[15:0];
            2'd1:    bit_clocks = BIT_1[15:0];
            2'd2:    bit_clocks = BIT_2[15:0];
            default: bit_clocks = BIT_3[15:0];
        endcase
    end

    wh_uart uart (
        .clk          (clk),
        .rst          (rst),
        .bit_clocks_i (bit_clocks),
        .rx_i         (uart_rx_i),
        .tx_o         (uart_tx_o),
        .rx_valid_o   (rx_valid),
        .rx_error_o   (rx_error),
        .rx_data_o    (rx_data),
        .tx_valid_i   (tx_valid),
        .tx_data_i    (tx_data),
        .tx_ready_o   (tx_ready)
    );

    wh_modbus #(
        .UNIT          (UNIT),
        .CLOCK_HZ      (CLOCK_HZ),
        .RATES         (RATES),
        .SILENCE       (SILENCE),
        .FALLBACK      (FALLBACK),
        .BUILD         (BUILD),
        .OPTIONS       (OPTIONS),
        .MOTORS        (MOTORS)
    ) modbus (
        .clk           (clk),
        .rst           (rst),
        .rx_valid_i    (heard_valid),
        .rx_error_i    (heard_error),
        .rx_data_i     (heard_data),
        .framed_i      (by_spi),
        .ends_i        (heard_end),
        .tx_valid_o    (answer_valid),
        .tx_data_o     (answer),
        .tx_ready_i    (answer_ready),
        .answers_o     (answers),
        .rests_o       (rests),
        .rate_o        (rate),
        .idle_o        (idle),
        .lost_o        (lost),
        .bus_valid_o   (asks),
        .bus_write_o   (writes),
        .bus_check_o   (checks),
        .bus_address_o (address),
        .bus_data_o    (data),
        .bus_ready_i   (bus_ready_i),
        .bus_data_i    (bus_data_i),
        .bus_error_i   (bus_error_i),
        .bus_signed_i  (bus_signed_i)
    );

    assign answer_ready = by_spi ? spi_ready : line_ready;

    generate
        if (SPI != 0) begin : spi
            reg        wants_q;  // CS has fallen
            reg        has_q;    // SPI has the slave
            reg        gives_q;  // not any more, once the slave is idle
            wire       takes = has_q && !gives_q;
            wire       begins;
            wire       spi_valid;
            wire       spi_error;
            wire [7:0] spi_data;

            wh_spi bytes (
                .clk        (clk),
                .rst        (rst),
                .cs_n_i     (spi_cs_n_i),
                .sclk_i     (spi_sclk_i),
                .mosi_i     (spi_mosi_i),
                .miso_o     (spi_miso_o),
                .drives_o   (spi_drives_o),
                .takes_i    (takes),
                .begins_o   (begins),
                .ends_o     (heard_end),
                .rx_valid_o (spi_valid),
                .rx_error_o (spi_error),
                .rx_data_o  (spi_data),
                .tx_valid_i (answer_valid && takes),
                .tx_data_i  (answer),
                .tx_ready_o (spi_ready)
            );

            always @(posedge clk) begin
                if (rst) begin
                    wants_q <= 1'b0;
                    has_q   <= 1'b0;
                    gives_q <= 1'b0;
                end else begin
                    wants_q <= begins || (wants_q && !idle);
                    gives_q <= has_q && (lost || (gives_q && !idle));
                    if (idle) begin
                        has_q <= wants_q || takes;
                    end
                end
            end

            assign by_spi      = has_q;
            assign heard_valid = has_q ? spi_valid : (rx_valid && !wants_q);
            assign heard_error = has_q ? spi_error : rx_error;
            assign heard_data  = has_q ? spi_data : rx_data;
        end else begin : uart_only
            wire unused_spi = &{1'b0, spi_cs_n_i, spi_sclk_i, spi_mosi_i, idle, lost};

            assign by_spi       = 1'b0;
            assign heard_valid  = rx_valid;
            assign heard_error  = rx_error;
            assign heard_data   = rx_data;
            assign heard_end    = 1'b0;
            assign spi_ready    = 1'b0;
            assign spi_miso_o   = 1'b0;
            assign spi_drives_o = 1'b0;
        end
        if (STREAM != 0) begin : streams
            wh_cobs frames (
                .clk            (clk),
                .rst            (rst),
                .credit_i       (stream_credit_i),
                .answers_i      (answers && !by_spi),
                .rests_i        (rests && !by_spi),
                .answer_valid_i (answer_valid && !by_spi),
                .answer_i       (answer),
                .answer_ready_o (line_ready),
                .byte_valid_i   (stream_valid_i),
                .byte_first_i   (stream_first_i),
                .byte_i         (stream_byte_i),
                .packet_i       (stream_packet_i),
                .room_o         (stream_room_o),
                .tx_valid_o     (tx_valid),
                .tx_data_o      (tx_data),
                .tx_ready_i     (tx_ready)
            );
        end else begin : answers_only
            wire unused = &{1'b0, answers, rests, stream_credit_i, stream_valid_i, stream_first_i,
                            stream_byte_i, stream_packet_i};

            assign tx_valid      = answer_valid && !by_spi;
            assign tx_data       = answer;
            assign line_ready    = tx_ready;
            assign stream_room_o = 1'b0;
        end
    endgenerate

    always @(posedge clk) begin
        bus_valid_o   <= !rst && asks && !(bus_valid_o && bus_ready_i);
        bus_write_o   <= writes;
        bus_check_o   <= checks;
        bus_address_o <= address;
        bus_data_o    <= data;
    end

endmodule

`default_nettype wire
