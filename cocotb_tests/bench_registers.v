// SPDX-License-Identifier: Apache-2.0
//
// bench_registers: wh_registers with wh_slots and the settings memories of wh_ports' stations.
//
// Each memory reads all its words in a window of 32 clocks of a slot, of port and bank as of the slot's begin; its
// window begins as late as clock 22, so that the last word is read in clock 53, as late as a station reads. The
// words of a slot make a sum, which holds each word times an odd factor of its address:
//
//   sum_o = sum of word * (address + 1) * FACTOR, modulo 2^64, over all reads of the slot, with sum_valid_o
//
// generation_o is how often the bank in force has changed since the reset, sum_generation_o what it was as the
// slot's round began.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module bench_registers #(
    parameter integer N          = 1,
    parameter integer WALLS      = 4,
    parameter integer DELAY_LOG2 = 2,
    parameter integer SHAPER     = 0,
    parameter integer AXES       = 0,
    parameter integer PORT_W     = (N > 1) ? $clog2(N) : 1,
    parameter integer ALL_W      = 238 + 2 * DELAY_LOG2 + `WH_GUARD_W + ((AXES != 0) ? 65 : 0)
) (
    input  wire                   clk,
    input  wire                   rst,

    input  wire                   bus_valid_i,
    input  wire                   bus_write_i,
    input  wire                   bus_check_i,
    input  wire [11:0]            bus_address_i,
    input  wire [31:0]            bus_data_i,
    output wire                   bus_ready_o,
    output wire [31:0]            bus_data_o,
    output wire [1:0]             bus_error_o,
    output wire                   bus_signed_o,

    output wire [ALL_W-1:0]       all_o,             // settings of all ports, carrier lowest
    output wire [5:0]             commands_o,        // magnet_start, command, restart, zero_start, host_alive,
                                                     // clear
    output wire [11:0]            command_address_o,
    output wire [31:0]            command_data_o,
    output reg  [15:0]            strobes_o,         // of command_o, since rst

    input  wire                   enable_i,
    output wire                   running_o,
    output wire                   ready_o,
    output wire                   loading_o,
    output wire                   busy_o,
    input  wire                   adc_ready_i,
    input  wire                   tick_i,
    input  wire [`WH_FAULTS-1:0]  faults_i,
    input  wire                   live_valid_i,
    input  wire [PORT_W-1:0]      live_port_i,
    input  wire [3:0]             live_word_i,
    input  wire [31:0]            live_data_i,
    input  wire [31:0]            other_i,

    input  wire                   summed_i,
    output reg  [15:0]            generation_o,
    output wire                   sum_valid_o,       // strobe
    output wire [PORT_W-1:0]      sum_port_o,
    output wire [15:0]            sum_generation_o,
    output reg  [63:0]            sum_o,
    output reg                    mixed_o,           // all_o changed without force_o, or while running; until rst
    output reg  [15:0]            busy_clocks_o      // clocks of the longest busy_o since ready_o
);

    localparam integer SUM_AT = 60;
    localparam integer GROUPS = (SHAPER > 0) ? 14 : 12;
    localparam [63:0]  FACTOR = 64'h9e37_79b9_7f4a_7c15;

    // First address, log2 of the words, and bits, of each memory; the first one lowest.
    localparam [14*8-1:0] FIRSTS = {8'h90, 8'h80, 8'h70, 8'h60, 8'h50, 8'h40, 8'h30, 8'h20, 8'h1a, 8'h18, 8'h10,
                                    8'h08, 8'h01, 8'h00};
    localparam [14*8-1:0] LOGS   = {8'd3, 8'd5, 8'd3, 8'd3, 8'd3, 8'd3, 8'd0, 8'd4, 8'd0, 8'd0, 8'd2,
                                    8'd1, 8'd0, 8'd0};
    localparam [14*8-1:0] BITS   = {8'd12, 8'd31, 8'd1, 8'd1, 8'd32, 8'd32, 8'd1, 8'd31, 8'd31, 8'd27, 8'd31,
                                    8'd27, 8'd27, 8'd24};

    wire                 force_now, write, write_bank;
    wire [11:0]          address;
    wire [31:0]          data;
    wire                 valid, bank;
    wire [PORT_W-1:0]    port;
    wire                 running = enable_i && !loading_o;
    wire                 slots_run, slots_damp, slots_overrun;

    wire [64:0]          magnets;

    assign running_o = running;

    generate
        if (AXES != 0) begin : brushless
            assign all_o[ALL_W-1 -: 65] = magnets;
        end else begin : brushed
            wire unused_magnets = &{1'b0, magnets};
        end
    endgenerate

    wh_registers #(
        .N                 (N),
        .WALLS             (WALLS),
        .DELAY_LOG2        (DELAY_LOG2),
        .SHAPER            (SHAPER),
        .AXES              (AXES)
    ) registers (
        .clk               (clk),
        .rst               (rst),
        .bus_valid_i       (bus_valid_i),
        .bus_write_i       (bus_write_i),
        .bus_check_i       (bus_check_i),
        .bus_address_i     (bus_address_i),
        .bus_data_i        (bus_data_i),
        .bus_ready_o       (bus_ready_o),
        .bus_data_o        (bus_data_o),
        .bus_error_o       (bus_error_o),
        .bus_signed_o      (bus_signed_o),
        .carrier_o         (all_o[65:0]),
        .frame_o           (all_o[122:66]),
        .sense_o           (all_o[193:123]),
        .filter_clocks_o   (all_o[197:194]),
        .delay_o           (all_o[198 +: 2*DELAY_LOG2]),
        .bridge_o          (all_o[198 + 2*DELAY_LOG2 +: 28]),
        .guard_o           (all_o[226 + 2*DELAY_LOG2 +: `WH_GUARD_W]),
        .host_o            (all_o[226 + 2*DELAY_LOG2 + `WH_GUARD_W +: 12]),
        .magnets_o         (magnets),
        .force_o           (force_now),
        .write_o           (write),
        .write_bank_o      (write_bank),
        .address_o         (address),
        .data_o            (data),
        .clear_o           (commands_o[0]),
        .host_alive_o      (commands_o[1]),
        .zero_start_o      (commands_o[2]),
        .magnet_start_o    (commands_o[5]),
        .restart_o         (commands_o[3]),
        .command_o         (commands_o[4]),
        .command_address_o (command_address_o),
        .command_data_o    (command_data_o),
        .ready_o           (ready_o),
        .loading_o         (loading_o),
        .busy_o            (busy_o),
        .running_i         (running),
        .adc_ready_i       (adc_ready_i),
        .tick_i            (tick_i),
        .faults_i          (faults_i),
        .live_valid_i      (live_valid_i),
        .live_port_i       (live_port_i),
        .live_word_i       (live_word_i),
        .live_data_i       (live_data_i),
        .other_i           (other_i)
    );

    wire slots_phase, slots_third;  // of brushless motors
    wire slots_look;                // of surfaces
    wire unused_axes = &{1'b0, slots_phase, slots_third, slots_look};

    wh_slots #(
        .N         (N),
        .SHAPER    (SHAPER)
    ) slots (
        .clk       (clk),
        .rst       (rst || !ready_o),
        .summed_i  (summed_i),
        .force_i   (force_now),
        .run_i     (running),
        .damp_i    (1'b0),
        .busy_i    (1'b0),
        .valid_o   (valid),
        .port_o    (port),
        .bank_o    (bank),
        .look_o    (slots_look),
        .phase_o   (slots_phase),
        .third_o   (slots_third),
        .run_o     (slots_run),
        .damp_o    (slots_damp),
        .overrun_o (slots_overrun)
    );

    // ---- Slots under way: clock k of one is bit k.
    reg  [SUM_AT:1]          valid_q;
    reg  [SUM_AT:1]          bank_q;
    reg  [SUM_AT*PORT_W-1:0] port_q;        // of clock k at k - 1
    reg  [SUM_AT*16-1:0]     generation_q;
    wire [SUM_AT:0]          valids      = {valid_q, valid};
    wire [SUM_AT:0]          banks       = {bank_q, bank};
    wire [(SUM_AT+1)*PORT_W-1:0] ports   = {port_q, port};
    reg                      force_q;
    wire                     flipped     = ready_o && force_now != force_q;
    wire [15:0]              generation  = generation_o + {15'd0, flipped};
    reg  [15:0]              round_q;
    wire [15:0]              of_round    = (valid && port == {PORT_W{1'b0}}) ? generation : round_q;
    wire                     unused      = &{1'b0, slots_run, slots_damp, slots_overrun, ports};

    always @(posedge clk) begin
        valid_q      <= (rst || !ready_o) ? {SUM_AT{1'b0}} : valids[SUM_AT-1:0];
        bank_q       <= banks[SUM_AT-1:0];
        port_q       <= ports[SUM_AT*PORT_W-1:0];
        generation_q <= {generation_q[(SUM_AT-1)*16-1:0], of_round};
        round_q      <= of_round;
        force_q      <= force_now;
        generation_o <= rst ? 16'd0 : generation;
    end

    wire [GROUPS*64-1:0] sums;

    genvar g;
    generate
        for (g = 0; g < GROUPS; g = g + 1) begin : memory
            localparam integer FIRST  = {24'd0, FIRSTS[g*8 +: 8]};
            localparam integer LOG2   = {24'd0, LOGS[g*8 +: 8]};
            localparam integer W      = {24'd0, BITS[g*8 +: 8]};
            localparam integer WORD_W = (LOG2 > 0) ? LOG2 : 1;
            localparam integer BEGIN  = (g * 7) % 23;

            reg  [5:0]        clock_q;  // of the window, 32: none
            reg               taken_q;
            reg  [7:0]        taken_address_q;
            reg               last_q;
            reg               bank_now_q;
            reg  [PORT_W-1:0] port_now_q;
            reg  [63:0]       part_q;
            reg  [63:0]       whole_q;
            wire              begins  = valids[BEGIN];
            wire [5:0]        now     = begins ? 6'd0 : clock_q;
            wire [7:0]        at      = (LOG2 > 0) ? {2'd0, now} & ((8'd1 << LOG2) - 8'd1) : 8'd0;
            wire [W-1:0]      word;
            wire              nothing = (taken_address_q >= 8'h98);  // the shaper's memory ends before its last words
            wire [63:0]       product = nothing ? 64'd0
                                        : {{(64 - W){1'b0}}, word} * FACTOR * ({56'd0, taken_address_q} + 64'd1);

            wh_port_settings #(
                .N            (N),
                .WORDS_LOG2   (LOG2),
                .W            (W),
                .FIRST        (FIRST),
                .BLOCK        ((LOG2 > 1) ? 1 : 0)
            ) settings (
                .clk          (clk),
                .write_i      (write),
                .write_bank_i (write_bank),
                .address_i    (address),
                .data_i       (data),
                .read_i       (!now[5]),
                .bank_i       (begins ? banks[BEGIN] : bank_now_q),
                .port_i       (begins ? ports[BEGIN*PORT_W +: PORT_W] : port_now_q),
                .word_i       (at[WORD_W-1:0]),
                .word_o       (word)
            );

            always @(posedge clk) begin
                clock_q         <= rst ? 6'd32 : now[5] ? 6'd32 : now + 6'd1;
                taken_q         <= !now[5];
                taken_address_q <= FIRSTS[g*8 +: 8] + at;
                last_q          <= (now == 6'd31);
                if (begins) begin
                    bank_now_q <= banks[BEGIN];
                    port_now_q <= ports[BEGIN*PORT_W +: PORT_W];
                end
                if (taken_q) begin
                    part_q <= last_q ? 64'd0 : part_q + product;
                end
                if (taken_q && last_q) begin
                    whole_q <= part_q + product;
                end
                if (rst) begin
                    part_q <= 64'd0;
                end
            end

            assign sums[g*64 +: 64] = whole_q;
        end
    endgenerate

    assign sum_valid_o      = valid_q[SUM_AT];
    assign sum_port_o       = port_q[(SUM_AT-1)*PORT_W +: PORT_W];
    assign sum_generation_o = generation_q[(SUM_AT-1)*16 +: 16];

    integer k;
    always @* begin
        sum_o = 64'd0;
        for (k = 0; k < GROUPS; k = k + 1) begin
            sum_o = sum_o + sums[k*64 +: 64];
        end
    end

    // ---- What may not happen, and how long it takes.
    reg [ALL_W-1:0] all_q;
    reg [15:0]      clocks_q;

    always @(posedge clk) begin
        all_q <= all_o;
        if (rst || !ready_o) begin
            mixed_o       <= 1'b0;
            strobes_o     <= 16'd0;
            clocks_q      <= 16'd0;
            busy_clocks_o <= 16'd0;
        end else begin
            if (all_o != all_q && (!flipped || running || !commands_o[3])) begin
                mixed_o <= 1'b1;
            end
            strobes_o <= strobes_o + {15'd0, commands_o[4]};
            clocks_q  <= busy_o ? clocks_q + 16'd1 : 16'd0;
            if (clocks_q > busy_clocks_o) begin
                busy_clocks_o <= clocks_q;
            end
        end
    end

endmodule

`default_nettype wire
