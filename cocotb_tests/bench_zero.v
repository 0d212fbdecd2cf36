// SPDX-License-Identifier: Apache-2.0
//
// bench_zero: wh_device with an ADC of 12 bits on each line, whose codes stand at code_i.

`default_nettype none
`include "wh_formats.vh"

module bench_zero #(
    parameter integer N         = 1,
    parameter integer AXES      = 0,
    parameter integer ARM       = 1,
    parameter integer ZERO_LOG2 = 3
) (
    input  wire                clk,
    input  wire                rst,
    input  wire                enable_i,
    input  wire                bus_valid_i,
    input  wire                bus_write_i,
    input  wire                bus_check_i,
    input  wire [11:0]         bus_address_i,
    input  wire [31:0]         bus_data_i,
    output wire                bus_ready_o,
    output wire [31:0]         bus_data_o,
    output wire [1:0]          bus_error_o,
    output wire                bus_signed_o,
    input  wire [12*N-1:0]     code_i,       // straight binary, line 0 lowest
    input  wire                clear_i,
    input  wire                zero_start_i,
    input  wire                press_i,
    output wire                tick_o,
    output wire                running_o,
    output wire                fault_o,
    output wire                fault_lasts_o,
    output wire                zero_busy_o,
    output wire [N-1:0]        zero_fault_o
);

    wire             cs_n;
    wire             sclk;
    wire             din;
    wire [N-1:0]     sdata;
    wire [N-1:0]     ah, al, bh, bl;
    wire             contact, ready, clears;
    wire             credit, byte_valid, byte_first, packet;
    wire [7:0]       one_byte;
    wire             unused = &{1'b0, din, ah, al, bh, bl, contact, ready, clears, credit, byte_valid, byte_first,
                                packet, one_byte};

    wh_device #(
        .N               (N),
        .AXES            (AXES),
        .ZERO_LOG2       (ZERO_LOG2),
        .ARM             (ARM),
        .ARM_CLOCKS      (100000000)
    ) dut (
        .clk             (clk),
        .rst             (rst),
        .enable_i        (enable_i),
        .bus_valid_i     (bus_valid_i),
        .bus_write_i     (bus_write_i),
        .bus_check_i     (bus_check_i),
        .bus_address_i   (bus_address_i),
        .bus_data_i      (bus_data_i),
        .bus_ready_o     (bus_ready_o),
        .bus_data_o      (bus_data_o),
        .bus_error_o     (bus_error_o),
        .bus_signed_o    (bus_signed_o),
        .adc_cs_n_o      (cs_n),
        .adc_sclk_o      (sclk),
        .adc_din_o       (din),
        .adc_sdata_i     (sdata),
        .enc_a_i         ({N{1'b0}}),
        .enc_b_i         ({N{1'b0}}),
        .gate_ah_o       (ah),
        .gate_al_o       (al),
        .gate_bh_o       (bh),
        .gate_bl_o       (bl),
        .bus_i           (16'd6144),
        .stop_i          (1'b0),
        .driver_fault_i  ({N{1'b0}}),
        .clear_i         (clear_i),
        .zero_start_i    (zero_start_i),
        .press_i         (press_i),
        .tick_o          (tick_o),
        .running_o       (running_o),
        .contact_o       (contact),
        .fault_o         (fault_o),
        .fault_lasts_o   (fault_lasts_o),
        .ready_o         (ready),
        .clear_o         (clears),
        .zero_busy_o     (zero_busy_o),
        .zero_fault_o    (zero_fault_o),
        .stream_credit_o (credit),
        .stream_valid_o  (byte_valid),
        .stream_first_o  (byte_first),
        .stream_byte_o   (one_byte),
        .stream_packet_o (packet),
        .stream_room_i   (1'b0)
    );

    // Two zeros and the code, highest bit first, each read as SCLK rises.
    reg  [4:0] bit_q;
    reg        sclk_q;
    wire       rises = sclk && !sclk_q;
    wire [4:0] place = bit_q + {4'd0, rises};

    always @(posedge clk) begin
        sclk_q <= sclk;
        bit_q  <= cs_n ? 5'd0 : place;
    end

    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : line
            wire [15:0] frame = {2'b00, code_i[12*n +: 12], 2'b00};

            assign sdata[n] = frame[4'd15 - place[3:0]];
        end
    endgenerate

endmodule

`default_nettype wire
