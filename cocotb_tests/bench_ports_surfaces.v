// SPDX-License-Identifier: Apache-2.0
//
// bench_ports_surfaces: wh_ports with surfaces across its ports, and ADC parts.
//
// The parts answer with 2 leading zeros and 12 bits. The newest of each live value is in live_o, one by one, 16 of
// each port. steps_o counts the voltages of ports that came. pass_clocks_o are those from a round's begin to that of its
// second pass.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module bench_ports_surfaces #(
    parameter integer N          = 3,
    parameter integer SURFACES   = 8,
    parameter integer WALLS      = 4,
    parameter integer DELAY_LOG2 = 2,
    parameter integer ZERO_LOG2  = 3,
    parameter integer PORT_W     = (N > 1) ? $clog2(N) : 1
) (
    input  wire                         clk,
    input  wire                         rst,
    input  wire                         enable_i,

    input  wire [N*12-1:0]              code_i,           // of the ADC parts, taken as CS_n falls
    input  wire [N*12-1:0]              noise_i,          // bits of it that are noise
    input  wire [N-1:0]                 enc_a_i,
    input  wire [N-1:0]                 enc_b_i,
    input  wire                         stop_i,
    input  wire [N-1:0]                 driver_fault_i,
    input  wire [`WH_BUS_W-1:0]         bus_i,

    input  wire [65:0]                  carrier_i,
    input  wire [56:0]                  frame_i,
    input  wire [70:0]                  sense_i,
    input  wire [3:0]                   filter_clocks_i,
    input  wire [2*DELAY_LOG2-1:0]      delay_i,
    input  wire [27:0]                  bridge_i,
    input  wire [`WH_GUARD_W-1:0]       guard_i,
    input  wire [11:0]                  host_i,

    input  wire                         surface_write_i,
    input  wire [9:0]                   surface_address_i,
    input  wire                         surface_commit_i,
    input  wire [61:0]                  budget_i,
    output wire                         surface_busy_o,
    output wire                         surface_refused_o,
    output wire [6:0]                   surface_refused_row_o,
    output wire [1:0]                   acting_o,

    input  wire                         force_i,
    input  wire                         write_i,
    input  wire                         write_bank_i,
    input  wire [11:0]                  address_i,
    input  wire [31:0]                  data_i,

    input  wire                         clear_i,
    input  wire                         host_alive_i,
    input  wire                         zero_start_i,
    input  wire                         restart_i,

    output wire                         tick_o,
    output wire                         round_o,          // strobe, the first port's slot begins
    output wire                         running_o,
    output wire [`WH_FAULTS-1:0]        faults_o,
    output reg  [31:0]                  steps_o,
    output reg  [15:0]                  pass_clocks_o,
    output reg                          met_o,            // two stations asked for a product at once
    output wire [32*(16<<PORT_W)-1:0]   live_o
);

    // ---- ADC parts.
    wire         cs_n, sclk;
    reg          cs_before_q, sclk_before_q;
    reg  [4:0]   pulse_q;
    reg  [N*12-1:0] code_q;
    reg  [31:0]  lfsr_q;
    wire [N-1:0] sdata;
    wire [3:0]   place = 4'd14 - pulse_q[3:0];  // 12 bits from the third pulse on

    integer k;
    always @(posedge clk) begin
        cs_before_q   <= cs_n;
        sclk_before_q <= sclk;
        if (rst) begin
            lfsr_q <= 32'hdead_beef;
        end else if (cs_before_q && !cs_n) begin
            pulse_q <= 5'd0;
            lfsr_q  <= {lfsr_q[30:0], lfsr_q[31] ^ lfsr_q[21] ^ lfsr_q[1] ^ lfsr_q[0]};
            for (k = 0; k < N; k = k + 1) begin
                code_q[12*k +: 12] <= code_i[12*k +: 12] ^ (lfsr_q[2*k +: 12] & noise_i[12*k +: 12]);
            end
        end else if (!cs_n && !sclk && sclk_before_q) begin
            pulse_q <= pulse_q + 5'd1;
        end
    end

    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : part
            assign sdata[n] = pulse_q >= 5'd3 && pulse_q <= 5'd14 && code_q[12*n + place];
        end
    endgenerate

    // ---- wh_ports.
    wire              live_valid;
    wire [PORT_W-1:0] live_port;
    wire [3:0]        live_word;
    wire [31:0]       live_data;
    wire              ports_din;
    wire [N-1:0]      ports_ah, ports_al, ports_bh, ports_bl;
    wire              ports_ready;
    wire [N-1:0]      ports_packet;
    wire              ports_zero_busy;
    wire [N-1:0]      ports_zero_faults;
    wire [N-1:0]      ports_found;
    wire [32*N-1:0]   ports_angles;
    wire              unused_zero = &{1'b0, ports_zero_busy, ports_zero_faults,  // faults_o has them
                                      ports_found, ports_angles, ports_packet, ports_din, ports_ready, ports_ah, ports_al,
                                      ports_bh, ports_bl};

    wh_ports #(
        .N               (N),
        .WALLS           (WALLS),
        .DELAY_LOG2      (DELAY_LOG2),
        .ZERO_LOG2       (ZERO_LOG2),
        .SURFACES        (SURFACES)
    ) ports (
        .clk             (clk),
        .rst             (rst),
        .enable_i        (enable_i),
        .adc_cs_n_o      (cs_n),
        .adc_sclk_o      (sclk),
        .adc_din_o       (ports_din),
        .adc_sdata_i     (sdata),
        .enc_a_i         (enc_a_i),
        .enc_b_i         (enc_b_i),
        .gate_ah_o       (ports_ah),
        .gate_al_o       (ports_al),
        .gate_bh_o       (ports_bh),
        .gate_bl_o       (ports_bl),
        .stop_i          (stop_i),
        .driver_fault_i  (driver_fault_i),
        .bus_i           (bus_i),
        .carrier_i       (carrier_i),
        .frame_i         (frame_i),
        .sense_i         (sense_i),
        .filter_clocks_i (filter_clocks_i),
        .delay_i         (delay_i),
        .bridge_i        (bridge_i),
        .guard_i         (guard_i),
        .surface_write_i   (surface_write_i),
        .surface_address_i (surface_address_i),
        .surface_commit_i  (surface_commit_i),
        .budget_i          (budget_i),
        .surface_busy_o    (surface_busy_o),
        .surface_refused_o (surface_refused_o),
        .surface_refused_row_o (surface_refused_row_o),
        .acting_o          (acting_o),
        .force_i         (force_i),
        .write_i         (write_i),
        .write_bank_i    (write_bank_i),
        .address_i       (address_i),
        .data_i          (data_i),
        .clear_i         (clear_i),
        .host_alive_i    (host_alive_i),
        .zero_start_i    (zero_start_i),
        .restart_i       (restart_i),
        .magnet_start_i  (1'b0),
        .magnets_i       ({65*N{1'b0}}),
        .host_i          (host_i),
        .host_strobe_i   ({N{1'b0}}),
        .host_sequence_i (8'd0),
        .host_u_i        ({`WH_DATA_W{1'b0}}),
        .host_strobe_o   (ports_packet),
        .live_valid_o    (live_valid),
        .live_port_o     (live_port),
        .live_word_o     (live_word),
        .live_data_o     (live_data),
        .tick_o          (tick_o),
        .adc_ready_o     (ports_ready),
        .running_o       (running_o),
        .zero_busy_o     (ports_zero_busy),
        .zero_faults_o   (ports_zero_faults),
        .magnets_found_o (ports_found),
        .magnet_angles_o (ports_angles),
        .faults_o        (faults_o)
    );

    assign round_o = ports.slot_valid && ports.slot_port == {PORT_W{1'b0}} && ports.slot_look;

    wire [5:0] requests = {ports.sense_request, ports.core_request, ports.anchor_request, ports.drive_request,
                           ports.guard_request, ports.energy_request};

    reg [15:0]                clock_q;  // of the round
    reg [32*(16<<PORT_W)-1:0] live_q;

    assign live_o = live_q;

    always @(posedge clk) begin
        clock_q <= round_o ? 16'd1 : clock_q + 16'd1;
        if (ports.slot_valid && ports.slot_port == {PORT_W{1'b0}} && !ports.slot_look) begin
            pass_clocks_o <= clock_q;
        end
        if (live_valid) begin
            live_q[32*{live_port, live_word} +: 32] <= live_data;
        end
        if (rst) begin
            steps_o <= 32'd0;
            met_o   <= 1'b0;
            live_q  <= {32*(16<<PORT_W){1'b0}};
        end else begin
            if (live_valid && live_word == `WH_LIVE_VOLTAGE) begin
                steps_o <= steps_o + 32'd1;
            end
            if ((requests & (requests - 6'd1)) != 6'd0) begin
                met_o <= 1'b1;
            end
        end
    end

endmodule

`default_nettype wire
