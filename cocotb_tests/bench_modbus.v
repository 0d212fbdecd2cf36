// SPDX-License-Identifier: Apache-2.0
//
// bench_modbus: wh_modbus with the settings memory, and counts of what the bus did.

`default_nettype none

module bench_modbus #(
    parameter integer SILENCE  = 2000,
    parameter integer FALLBACK = 20,
    parameter integer RATES    = 3
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        rx_valid_i,
    input  wire        rx_error_i,
    input  wire [7:0]  rx_data_i,
    output wire        tx_valid_o,
    output wire [7:0]  tx_data_o,
    input  wire        tx_ready_i,
    output wire        answers_o,
    output wire        rests_o,
    output wire [1:0]  rate_o,
    input  wire        dead_i,      // the bus hears nothing
    input  wire        enable_i,
    input  wire        trap_i,      // enable rises with the second word that is written
    input  wire        tick_i,
    output wire        ready_o,
    output reg  [15:0] writes_o,    // words accepted
    output reg  [15:0] commands_o,
    output reg  [15:0] changes_o,   // commits given
    output reg  [15:0] judged_o     // words judged only
);

    wire        valid;
    wire        write;
    wire        check;
    wire [11:0] address;
    wire [31:0] data;
    wire        bus_ready;
    wire [31:0] read;
    wire [1:0]  error;
    wire        signs;
    wire        command;
    wire        loading;
    wire        busy;
    wire        written;
    wire        copy;
    wire [11:0] given_address;
    wire [31:0] given_data;
    wire        change;
    wire        now;
    wire        discard;

    reg         trapped_q;
    reg         change_q;

    wh_modbus #(
        .SILENCE       (SILENCE),
        .FALLBACK      (FALLBACK),
        .RATES         (RATES),
        .BUILD         (32'h20261122),
        .OPTIONS       (32'hfedcba98),
        .MOTORS        (1)
    ) modbus (
        .clk           (clk),
        .rst           (rst),
        .rx_valid_i    (rx_valid_i),
        .rx_error_i    (rx_error_i),
        .rx_data_i     (rx_data_i),
        .tx_valid_o    (tx_valid_o),
        .tx_data_o     (tx_data_o),
        .tx_ready_i    (tx_ready_i),
        .answers_o     (answers_o),
        .rests_o       (rests_o),
        .rate_o        (rate_o),
        .bus_valid_o   (valid),
        .bus_write_o   (write),
        .bus_check_o   (check),
        .bus_address_o (address),
        .bus_data_o    (data),
        .bus_ready_i   (bus_ready),
        .bus_data_i    (read),
        .bus_error_i   (error),
        .bus_signed_i  (signs)
    );

    wh_settings settings (
        .clk           (clk),
        .rst           (rst),
        .bus_valid_i   (valid && !dead_i),
        .bus_write_i   (write),
        .bus_check_i   (check),
        .bus_address_i (address),
        .bus_data_i    (data),
        .bus_ready_o   (bus_ready),
        .bus_data_o    (read),
        .bus_error_o   (error),
        .bus_signed_o  (signs),
        .live_i        (32'h1234abcd),
        .command_o     (command),
        .running_i     ((enable_i || trapped_q) && !loading),
        .tick_i        (tick_i),
        .ready_o       (ready_o),
        .loading_o     (loading),
        .busy_o        (busy),
        .write_o       (written),
        .copy_o        (copy),
        .address_o     (given_address),
        .data_o        (given_data),
        .change_o      (change),
        .now_o         (now),
        .discard_o     (discard),
        .changing_i    (1'b0)
    );

    wire unused = &{1'b0, busy, copy, given_address, given_data, now, discard};

    always @(posedge clk) begin
        change_q <= change;
        if (rst) begin
            writes_o   <= 16'd0;
            commands_o <= 16'd0;
            changes_o  <= 16'd0;
            judged_o   <= 16'd0;
            trapped_q  <= 1'b0;
        end else begin
            writes_o   <= writes_o + {15'd0, written};
            commands_o <= commands_o + {15'd0, command};
            changes_o  <= changes_o + {15'd0, change && !change_q};
            judged_o   <= judged_o + {15'd0, bus_ready && write && check};
            trapped_q  <= trap_i && (trapped_q || written);
        end
    end

endmodule

`default_nettype wire
