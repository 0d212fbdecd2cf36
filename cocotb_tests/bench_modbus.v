// SPDX-License-Identifier: Apache-2.0
//
// bench_modbus: wh_modbus with wh_registers, and counts of what the bus did.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

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
    input  wire        framed_i,
    input  wire        ends_i,
    output wire        tx_valid_o,
    output wire [7:0]  tx_data_o,
    input  wire        tx_ready_i,
    output wire        answers_o,
    output wire        rests_o,
    output wire [1:0]  rate_o,
    output wire        idle_o,
    output wire        lost_o,
    input  wire        dead_i,      // the bus hears nothing
    input  wire        enable_i,
    input  wire        trap_i,      // enable rises with the second word that is written
    input  wire        commits_i,   // one commit of the bench follows another; the line asks while one is under way
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
    wire        clears, alive, zeros, magnets_begin, restarts;
    wire [11:0] command_address;
    wire [31:0] command_data;
    wire [65:0] carrier;
    wire [56:0] frame;
    wire [70:0] sense;
    wire [3:0]  filter_clocks, delay;
    wire [27:0] bridge;
    wire [`WH_GUARD_W-1:0] guard;
    wire [11:0] host;
    wire [64:0] magnets;
    wire        in_force, copies, copies_to;
    wire [11:0] copied_address;
    wire [31:0] copied_data;

    localparam [11:0] COMMIT = 12'h070;
    localparam [7:0]  EARLY  = 8'd100;  // clocks of a commit, in which a request begins that ends in it

    reg  [7:0]  since_q;  // clocks since it began
    reg         own_q;    // a request of the bench is under way
    reg         asked_q;  // one of the line
    wire        asks     = valid && !dead_i && !own_q && (!commits_i || asked_q || (busy && since_q < EARLY));
    wire        ready;
    wire        accepted = bus_ready && write && !check && error == 2'd0;

    assign bus_ready = ready && !own_q;

    reg         trapped_q;
    reg         accepted_q;
    reg         own_address_q;  // `commit` or `discard`
    reg         commit_q;

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
        .framed_i      (framed_i),
        .ends_i        (ends_i),
        .tx_valid_o    (tx_valid_o),
        .tx_data_o     (tx_data_o),
        .tx_ready_i    (tx_ready_i),
        .answers_o     (answers_o),
        .rests_o       (rests_o),
        .rate_o        (rate_o),
        .idle_o        (idle_o),
        .lost_o        (lost_o),
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

    wh_registers registers (
        .clk               (clk),
        .rst               (rst),
        .bus_valid_i       (own_q || asks),
        .bus_write_i       (own_q || write),
        .bus_check_i       (!own_q && check),
        .bus_address_i     (own_q ? COMMIT : address),
        .bus_data_i        (own_q ? 32'd1 : data),
        .bus_ready_o       (ready),
        .bus_data_o        (read),
        .bus_error_o       (error),
        .bus_signed_o      (signs),
        .carrier_o         (carrier),
        .frame_o           (frame),
        .sense_o           (sense),
        .filter_clocks_o   (filter_clocks),
        .delay_o           (delay),
        .bridge_o          (bridge),
        .guard_o           (guard),
        .host_o            (host),
        .magnets_o         (magnets),
        .force_o           (in_force),
        .write_o           (copies),
        .write_bank_o      (copies_to),
        .address_o         (copied_address),
        .data_o            (copied_data),
        .clear_o           (clears),
        .host_alive_o      (alive),
        .zero_start_o      (zeros),
        .magnet_start_o    (magnets_begin),
        .restart_o         (restarts),
        .command_o         (command),
        .command_address_o (command_address),
        .command_data_o    (command_data),
        .ready_o           (ready_o),
        .loading_o         (loading),
        .busy_o            (busy),
        .running_i         ((enable_i || trapped_q) && !loading),
        .adc_ready_i       (1'b0),
        .tick_i            (1'b0),
        .faults_i          ({`WH_FAULTS{1'b0}}),
        .live_valid_i      (1'b0),
        .live_port_i       (1'b0),
        .live_word_i       (4'd0),
        .live_data_i       (32'd0),
        .other_i           (32'h1234abcd)
    );

    wire unused = &{1'b0, clears, alive, zeros, magnets_begin, restarts, command_address, command_data, carrier, frame,
                    sense, filter_clocks, delay, bridge, guard, host, magnets, in_force, copies, copies_to,
                    copied_address, copied_data};

    // A command's strobe comes a clock after its answer; what has none is a setting, or the memory's own.
    wire written = accepted_q && !command && !own_address_q;

    always @(posedge clk) begin
        accepted_q    <= !rst && accepted;
        own_address_q <= (address[11:1] == COMMIT[11:1]);
        commit_q      <= accepted && (address == COMMIT);
        asked_q       <= asks && !ready;
        own_q         <= !rst && (own_q ? !ready : (commits_i && ready_o && !busy && !asks));
        since_q       <= !busy ? 8'd0 : since_q + {7'd0, since_q != 8'hff};
        if (rst) begin
            writes_o   <= 16'd0;
            commands_o <= 16'd0;
            changes_o  <= 16'd0;
            judged_o   <= 16'd0;
            trapped_q  <= 1'b0;
        end else begin
            writes_o   <= writes_o + {15'd0, written};
            commands_o <= commands_o + {15'd0, command};
            changes_o  <= changes_o + {15'd0, commit_q};
            judged_o   <= judged_o + {15'd0, bus_ready && write && check};
            trapped_q  <= trap_i && (trapped_q || written);
        end
    end

endmodule

`default_nettype wire
