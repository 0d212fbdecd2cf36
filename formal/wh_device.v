// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_device: the bridges are on only where the pin enable says so and wh_arm does, whatever stands
// on the bus and whatever the settings are: running_o is low with either, and every gate a clock later; both
// also while settings that want them off are committed. With AXES = 1 of a brushless motor's six gates.
//
// Everything inside is as it is, in any state, but for products (any_multiply) and the memories and table of the
// settings (any_register_ram, any_settings_rom). Proven by induction, smtbmc z3.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_device #(
    parameter integer N    = 1,
    parameter integer AXES = 0
) (
    input wire                 clk,
    input wire                 rst,
    input wire                 enable,
    input wire                 bus_valid,
    input wire                 bus_write,
    input wire                 bus_check,
    input wire [11:0]          bus_address,
    input wire [31:0]          bus_data,
    input wire [N-1:0]         adc_sdata,
    input wire [N-1:0]         enc_a,
    input wire [N-1:0]         enc_b,
    input wire [`WH_BUS_W-1:0] bus,
    input wire                 stop,
    input wire [N-1:0]         driver_fault,
    input wire                 clear,
    input wire                 zero_start,
    input wire                 press
);

    wire        bus_ready;
    wire [31:0] bus_read;
    wire [1:0]  bus_error;
    wire        bus_signed;
    wire        adc_cs_n;
    wire        adc_sclk;
    wire        adc_din;
    wire [N-1:0] ah, al, bh, bl;
    wire        tick;
    wire        running;
    wire        contact;
    wire        fault;
    wire        clears;

    wh_device #(
        .N              (N),
        .AXES           (AXES),
        .WALLS          (1),
        .ARM            (1)
    ) block (
        .clk            (clk),
        .rst            (rst),
        .enable_i       (enable),
        .bus_valid_i    (bus_valid),
        .bus_write_i    (bus_write),
        .bus_check_i    (bus_check),
        .bus_address_i  (bus_address),
        .bus_data_i     (bus_data),
        .bus_ready_o    (bus_ready),
        .bus_data_o     (bus_read),
        .bus_error_o    (bus_error),
        .bus_signed_o   (bus_signed),
        .adc_cs_n_o     (adc_cs_n),
        .adc_sclk_o     (adc_sclk),
        .adc_din_o      (adc_din),
        .adc_sdata_i    (adc_sdata),
        .enc_a_i        (enc_a),
        .enc_b_i        (enc_b),
        .gate_ah_o      (ah),
        .gate_al_o      (al),
        .gate_bh_o      (bh),
        .gate_bl_o      (bl),
        .bus_i          (bus),
        .stop_i         (stop),
        .driver_fault_i (driver_fault),
        .clear_i        (clear),
        .zero_start_i   (zero_start),
        .press_i        (press),
        .tick_o         (tick),
        .running_o      (running),
        .contact_o      (contact),
        .fault_o        (fault),
        .clear_o        (clears)
    );

    (* hierconn *) wire \block.loading ;
    (* hierconn *) wire \block.armed ;

    reg begun = 1'b0;
    reg enable_q;
    reg loading_q;
    reg armed_q;

    always @(posedge clk) begin
        begun     <= 1'b1;
        enable_q  <= enable;
        loading_q <= \block.loading ;
        armed_q   <= \block.armed ;
        if (!enable || !\block.armed || \block.loading ) assert (!running);
        if (begun && (!enable_q || !armed_q || loading_q)) assert ({ah, al, bh, bl} == 0);

        cover (begun && running && {ah, al} != 0);
    end

endmodule

`default_nettype wire
