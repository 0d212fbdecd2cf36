// SPDX-License-Identifier: Apache-2.0
//
// bench_wishbone: wh_wishbone in front of wh_device, whose bridges are off.

`default_nettype none
`include "wh_formats.vh"

module bench_wishbone #(
    parameter integer WALLS = 1
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        cyc_i,
    input  wire        stb_i,
    input  wire        we_i,
    input  wire [11:0] adr_i,
    input  wire [31:0] dat_i,
    input  wire [3:0]  sel_i,
    output wire [31:0] dat_o,
    output wire        ack_o,
    output wire        err_o,
    output wire        ready_o
);

    wire        valid;
    wire        write;
    wire        check;
    wire [11:0] address;
    wire [31:0] data;
    wire        ready;
    wire [31:0] read;
    wire [1:0]  error;

    wh_wishbone wishbone (
        .clk           (clk),
        .rst           (rst),
        .cyc_i         (cyc_i),
        .stb_i         (stb_i),
        .we_i          (we_i),
        .adr_i         (adr_i),
        .dat_i         (dat_i),
        .sel_i         (sel_i),
        .dat_o         (dat_o),
        .ack_o         (ack_o),
        .err_o         (err_o),
        .bus_valid_o   (valid),
        .bus_write_o   (write),
        .bus_check_o   (check),
        .bus_address_o (address),
        .bus_data_o    (data),
        .bus_ready_i   (ready),
        .bus_data_i    (read),
        .bus_error_i   (error)
    );

    wh_device #(
        .WALLS           (WALLS)
    ) device (
        .clk             (clk),
        .rst             (rst),
        .enable_i        (1'b0),
        .bus_valid_i     (valid),
        .bus_write_i     (write),
        .bus_check_i     (check),
        .bus_address_i   (address),
        .bus_data_i      (data),
        .bus_ready_o     (ready),
        .bus_data_o      (read),
        .bus_error_o     (error),
        .bus_signed_o    (),
        .adc_cs_n_o      (),
        .adc_sclk_o      (),
        .adc_din_o       (),
        .adc_sdata_i     (1'b0),
        .enc_a_i         (1'b0),
        .enc_b_i         (1'b0),
        .gate_ah_o       (),
        .gate_al_o       (),
        .gate_bh_o       (),
        .gate_bl_o       (),
        .bus_i           ({`WH_BUS_W{1'b0}}),
        .stop_i          (1'b0),
        .driver_fault_i  (1'b0),
        .clear_i         (1'b0),
        .zero_start_i    (1'b0),
        .press_i         (1'b0),
        .tick_o          (),
        .running_o       (),
        .contact_o       (),
        .fault_o         (),
        .fault_lasts_o   (),
        .ready_o         (ready_o),
        .clear_o         (),
        .zero_busy_o     (),
        .zero_fault_o    (),
        .stream_credit_o (),
        .stream_valid_o  (),
        .stream_first_o  (),
        .stream_byte_o   (),
        .stream_packet_o (),
        .stream_room_i   (1'b0)
    );

endmodule

`default_nettype wire
