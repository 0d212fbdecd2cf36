// SPDX-License-Identifier: Apache-2.0
//
// bench_ports_axes: wh_ports with brushless motors, its ADC parts, and what integers need to know of each round.
//
// frames_o are the last four codes of each line as a round begins, the newest one
// lowest; steps_o counts the steps since, broken_o says that the bridges weren't on all the time, and damp_o that the
// round damps. live_o are the values that came last, 16 of each port. trace_o are gates of the clocks before, the newest
// one lowest: AH, AL, BH, BL of each port. hold_flux_i lets the brushless motors' flux stand still, whatever the rotors
// do, so that magnets are found.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module bench_ports_axes #(
    parameter integer N          = 2,
    parameter integer AXES       = 1,
    parameter integer WALLS      = 4,
    parameter integer DELAY_LOG2 = 2,
    parameter integer ZERO_LOG2  = 3,
    parameter integer SHAPER     = 0,
    parameter integer MODES      = 0,
    parameter integer MIN_PULSE  = 0,
    parameter integer TRACE      = 1024,
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

    input  wire                         force_i,
    input  wire                         write_i,
    input  wire                         write_bank_i,
    input  wire [11:0]                  address_i,
    input  wire [31:0]                  data_i,

    input  wire                         clear_i,
    input  wire                         host_alive_i,
    input  wire                         zero_start_i,
    input  wire                         restart_i,
    input  wire [11:0]                  host_i,
    input  wire [64:0]                  magnets_i,        // find, zero_angle, count_angle
    input  wire                         magnet_start_i,
    input  wire                         hold_flux_i,

    output wire                         tick_o,
    output wire                         round_o,          // strobe, the first port's slot begins
    output wire                         running_o,
    output wire [`WH_FAULTS-1:0]        faults_o,
    output reg  [N*48-1:0]              frames_o,
    output reg  [3:0]                   steps_o,
    output reg                          broken_o,
    output wire                         damp_o,
    output wire [32*(16<<PORT_W)-1:0]   live_o,
    output wire [4*N*TRACE-1:0]         trace_o,
    output wire [N-1:0]                 found_o,
    output reg  [32*N-1:0]              angles_o,         // as a round begins
    output wire [N-1:0]                 zero_faults_o,
    output wire                         zero_busy_o,
    output reg                          met_o,            // until rst: two stations asked for a product at once
    output reg                          lit_o             // until rst: a gate was on with the bridges off
);

    localparam integer DATA_W = `WH_DATA_W;

    // ---- ADC parts.
    wire         cs_n, sclk;
    reg          cs_before_q, sclk_before_q;
    reg  [4:0]   pulse_q;
    reg  [N*12-1:0] code_q;
    wire [N*12-1:0] codes;
    reg  [N*48-1:0] codes_q;  // the last four
    reg  [31:0]  lfsr_q;
    wire [N-1:0] sdata;
    wire [3:0]   place = 4'd13 - pulse_q[3:0];  // 12 bits from the second pulse on

    integer k;
    always @(posedge clk) begin
        cs_before_q   <= cs_n;
        sclk_before_q <= sclk;
        if (rst) begin
            lfsr_q  <= 32'hdead_beef;
            codes_q <= {N*48{1'b0}};
        end else if (cs_before_q && !cs_n) begin
            pulse_q <= 5'd0;
            lfsr_q  <= {lfsr_q[30:0], lfsr_q[31] ^ lfsr_q[21] ^ lfsr_q[1] ^ lfsr_q[0]};
            for (k = 0; k < N; k = k + 1) begin
                code_q[12*k +: 12]  <= codes[12*k +: 12];
                codes_q[48*k +: 48] <= {codes_q[48*k +: 36], codes[12*k +: 12]};
            end
        end else if (!cs_n && !sclk && sclk_before_q) begin
            pulse_q <= pulse_q + 5'd1;
        end
    end

    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : part
            assign codes[12*n +: 12] = code_i[12*n +: 12] ^ (lfsr_q[2*n +: 12] & noise_i[12*n +: 12]);
            assign sdata[n] = pulse_q >= 5'd2 && pulse_q <= 5'd13 && code_q[12*n + place];
        end
    endgenerate

    // ---- wh_ports.
    wire              live_valid;
    wire [PORT_W-1:0] live_port;
    wire [3:0]        live_word;
    wire [31:0]       live_data;
    wire              din;
    wire [32*N-1:0]   angles;
    wire [N-1:0]      ah, al, bh, bl;
    wire [N-1:0]      packet;
    wire              ready;
    wire              unused = &{1'b0, din, packet, ready};

    wire [N-1:0]      alphas = AXES[N-1:0];

    wire       surface_busy, surface_refused;
    wire [6:0] surface_row;
    wire [1:0] surfaces_acting;
    wire       unused_surfaces = &{1'b0, surface_busy, surface_refused, surface_row, surfaces_acting};

    wh_ports #(
        .N               (N),
        .WALLS           (WALLS),
        .DELAY_LOG2      (DELAY_LOG2),
        .ZERO_LOG2       (ZERO_LOG2),
        .SHAPER          (SHAPER),
        .AXES            (AXES),
        .MODES           (MODES),
        .MIN_PULSE       (MIN_PULSE)
    ) ports (
        .clk             (clk),
        .rst             (rst),
        .enable_i        (enable_i),
        .adc_cs_n_o      (cs_n),
        .adc_sclk_o      (sclk),
        .adc_din_o       (din),
        .adc_sdata_i     (sdata),
        .enc_a_i         (enc_a_i),
        .enc_b_i         (enc_b_i),
        .gate_ah_o       (ah),
        .gate_al_o       (al),
        .gate_bh_o       (bh),
        .gate_bl_o       (bl),
        .stop_i          (stop_i),
        .driver_fault_i  ((driver_fault_i & ~(alphas << 1)) | ((driver_fault_i & alphas) << 1)),
        .bus_i           (bus_i),
        .carrier_i       (carrier_i),
        .frame_i         (frame_i),
        .sense_i         (sense_i),
        .filter_clocks_i (filter_clocks_i),
        .delay_i         (delay_i),
        .bridge_i        (bridge_i),
        .guard_i         (guard_i),
        .surface_write_i   (1'b0),
        .surface_address_i (10'd0),
        .surface_commit_i  (1'b0),
        .budget_i          (62'd0),
        .surface_busy_o    (surface_busy),
        .surface_refused_o (surface_refused),
        .surface_refused_row_o (surface_row),
        .acting_o          (surfaces_acting),
        .force_i         (force_i),
        .write_i         (write_i),
        .write_bank_i    (write_bank_i),
        .address_i       (address_i),
        .data_i          (data_i),
        .clear_i         (clear_i),
        .host_alive_i    (host_alive_i),
        .zero_start_i    (zero_start_i),
        .restart_i       (restart_i),
        .magnet_start_i  (magnet_start_i),
        .magnets_i       ({N{magnets_i}}),
        .host_i          (host_i),
        .host_strobe_i   ({N{1'b0}}),
        .host_sequence_i (8'd0),
        .host_u_i        ({DATA_W{1'b0}}),
        .host_strobe_o   (packet),
        .live_valid_o    (live_valid),
        .live_port_o     (live_port),
        .live_word_o     (live_word),
        .live_data_o     (live_data),
        .tick_o          (tick_o),
        .adc_ready_o     (ready),
        .running_o       (running_o),
        .zero_busy_o     (zero_busy_o),
        .zero_faults_o   (zero_faults_o),
        .magnets_found_o (found_o),
        .magnet_angles_o (angles),
        .faults_o        (faults_o)
    );

    assign damp_o = ports.damp;

    // A flux that stands still.
    always @(hold_flux_i) begin
        if (hold_flux_i) begin
            force ports.with_axes.rotor.place = {2*(`WH_PLACE_W+`WH_SINE_Q){1'b0}};
        end else begin
            release ports.with_axes.rotor.place;
        end
    end

    assign round_o = ports.slot_valid && ports.slot_port == {PORT_W{1'b0}};

    wire [6:0] requests = {ports.sense_request, ports.core_request, ports.anchor_request, ports.drive_request,
                           ports.guard_request, ports.energy_request, ports.axis_request};

    always @(posedge clk) begin
        if (rst) begin
            met_o <= 1'b0;
        end else if ((requests & (requests - 7'd1)) != 7'd0
                     || (ports.with_axes.clarke_request && ports.with_axes.legs_request)) begin
            met_o <= 1'b1;
        end
    end

    // The last value of each, and what a round was.
    reg [32*(16<<PORT_W)-1:0] live_q;

    reg                       was_on_q;

    assign live_o = live_q;

    always @(posedge clk) begin
        if (rst) begin
            live_q <= {32*(16<<PORT_W){1'b0}};
        end else if (live_valid) begin
            live_q[32*{live_port, live_word} +: 32] <= live_data;
        end
        if (round_o) begin
            frames_o <= codes_q;
            angles_o <= angles;
            steps_o  <= 4'd0;
            broken_o <= 1'b0;
        end else begin
            if (ports.core_valid) begin
                steps_o <= steps_o + 4'd1;
            end
            if (ports.core_rst || !ports.run) begin
                broken_o <= 1'b1;
            end
        end
        lit_o    <= !rst && (lit_o || (!running_o && !was_on_q && (|{ah, al, bh, bl})));
        was_on_q <= running_o;
    end

    genvar g;
    generate
        for (g = 0; g < N; g = g + 1) begin : gates
            reg [TRACE-1:0] ah_q, al_q, bh_q, bl_q;

            always @(posedge clk) begin
                ah_q <= rst ? {TRACE{1'b0}} : {ah_q[TRACE-2:0], ah[g]};
                al_q <= rst ? {TRACE{1'b0}} : {al_q[TRACE-2:0], al[g]};
                bh_q <= rst ? {TRACE{1'b0}} : {bh_q[TRACE-2:0], bh[g]};
                bl_q <= rst ? {TRACE{1'b0}} : {bl_q[TRACE-2:0], bl[g]};
            end

            assign trace_o[4*TRACE*g +: 4*TRACE] = {bl_q, bh_q, al_q, ah_q};
        end
    endgenerate

endmodule

`default_nettype wire
