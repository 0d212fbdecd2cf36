// SPDX-License-Identifier: Apache-2.0
//
// wh_device: the controller with its registers: wh_ports, the bus, and little else.
//
//   bus -> wh_registers -> settings, commands -> wh_ports -> pins
//               ^                                   |
//               `------------ live values ----------+-> wh_round_words -> wh_capture, wh_stream
//
// wh_arm, where ARM = 1, lets the bridges on by command or by press_i. Nothing on the bus lets them on where enable_i,
// a pin, is low. They stay off while settings that want them off are committed.
//
// Every register of rtl/words.toml is on the bus, as wh_registers has it. A port's settings change between two rounds,
// those of all ports with the bridges off. Of what wh_ports hasn't got, the registers can be written and nothing
// reads them; those that tell of it are 0. The live value core_valid, a strobe, and words_hold are 0.
// Brushless motors (AXES): bit n of AXES: ports n and n + 1 are one's axes. Its encoder is port n's. Its leg a is leg A
// of port n, b is leg B of port n, c is leg A of port n + 1; leg B of port n + 1 is always off. wh_registers says where
// its settings are. magnet_found is 1 once the magnets of all are found, and magnet_angle is the first one's.
// Surfaces across the ports (SURFACES): wh_surface_frame says how a frame of them comes over the bus. An accepted frame
// is a sign of life of the host, as host_alive is: the guard's fault HOST then damps, switches off, or isn't there.
// A clear that begins with the bridges off measures the zeros anew, as arming does.
//
// Latency: of the bus as wh_registers has it, and more after a word of a surface; of all else as wh_ports has it.
// Reset: that of wh_ports, which lasts until the settings are what the table says, COPIED + 70 clocks
// (wh_registers).

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_device #(
    parameter integer N          = 1,  // ports; these are wh_ports'
    parameter integer WALLS      = 4,
    parameter integer DELAY_LOG2 = 2,
    parameter integer ADC        = 0,
    parameter integer OSR        = 32,
    parameter integer ZERO_LOG2  = 10,
    parameter integer SHAPER     = 0,
    parameter integer MODES      = 0,
    parameter integer MIN_PULSE  = 0,
    parameter integer HOST       = 0,
    parameter integer SURFACES   = 0,
    parameter integer AXES       = 0,
    parameter integer ARM        = 0,  // 1: the bridges are on by command, while it is renewed, or by press_i
    parameter integer ARM_CLOCKS = 4800000, // clocks that a command of either lasts, 2...2^30
    parameter integer CAPTURE    = 0,  // values that a capture takes, 2^this, 4...15; 0: there is none
    parameter integer STREAM     = 0   // 1: with a stream
) (
    input  wire                 clk,
    input  wire                 rst,
    input  wire                 enable_i,       // synchronous to clk

    // The bus (wh_registers).
    input  wire                 bus_valid_i,    // held until bus_ready_o, as are the four below
    input  wire                 bus_write_i,
    input  wire                 bus_check_i,
    input  wire [11:0]          bus_address_i,
    input  wire [31:0]          bus_data_i,
    output wire                 bus_ready_o,    // strobe
    output wire [31:0]          bus_data_o,
    output wire [1:0]           bus_error_o,
    output wire                 bus_signed_o,

    // Pins, and what a board wires.
    output wire                 adc_cs_n_o,
    output wire                 adc_sclk_o,
    output wire                 adc_din_o,
    input  wire [N-1:0]         adc_sdata_i,    // of a brushless motor: of its phases a and b
    input  wire [N-1:0]         enc_a_i,        // asynchronous
    input  wire [N-1:0]         enc_b_i,        // asynchronous
    output wire [N-1:0]         gate_ah_o,
    output wire [N-1:0]         gate_al_o,
    output wire [N-1:0]         gate_bh_o,      // leg b; see AXES
    output wire [N-1:0]         gate_bl_o,
    input  wire [`WH_BUS_W-1:0] bus_i,          // u16q9 V, the measured bus
    input  wire                 stop_i,         // asynchronous
    input  wire [N-1:0]         driver_fault_i, // asynchronous
    input  wire                 clear_i,        // these two do what their registers do, a rise of the first
    input  wire                 zero_start_i,
    input  wire                 press_i,        // strobe: arm, until something is against it; with ARM = 1

    output wire                 tick_o,         // strobe, last clock of a period
    output wire                 running_o,      // the bridges are on
    output wire                 contact_o,      // any motor is in a wall
    output wire                 fault_o,        // the guard found something
    output wire                 fault_lasts_o,  // the same but for a zero, which arming measures anew
    output wire                 ready_o,        // since reset all settings were given
    output wire                 clear_o,        // strobe: the bus wants faults forgotten
    output wire                 zero_busy_o,    // zeros are measured
    output wire [N-1:0]         zero_fault_o,   // no permitted zero was found

    // A stream's packets (wh_stream).
    output wire                 stream_credit_o,
    output wire                 stream_valid_o,
    output wire                 stream_first_o,
    output wire [7:0]           stream_byte_o,
    output wire                 stream_packet_o,
    input  wire                 stream_room_i
);

    localparam integer PORT_W = (N > 1) ? $clog2(N) : 1;
    // Alpha of the first brushless motor; without one, a port whose angle is 0.
    localparam integer FIRST  = ((AXES & 1) != 0 || AXES == 0) ? 0 : ((AXES & 2) != 0) ? 1 : ((AXES & 4) != 0) ? 2
                                : ((AXES & 8) != 0) ? 3 : ((AXES & 16) != 0) ? 4 : ((AXES & 32) != 0) ? 5 : 6;
    localparam [`WH_FAULTS-1:0] ZERO = {{`WH_FAULTS-1{1'b0}}, 1'b1} << `WH_FAULT_ZERO;

    // Registers that are here.
    localparam [11:0] CAPTURE_GO     = 12'h074;
    localparam [11:0] CAPTURE_OFFSET = 12'h075;
    localparam [11:0] STREAM_GO      = 12'h076;
    localparam [11:0] ARM_GO         = 12'h078;
    localparam [11:0] SURFACE_WORD   = 12'h0cb;  // the first one
    localparam [11:0] SURFACE_COMMIT = 12'h0ff;
    localparam [7:0]  ANSWER_SEQUENCE = 8'ha1;  // of a port
    localparam [7:0]  ANSWER_U       = 8'ha2;
    localparam [7:0]  ANSWER         = 8'ha3;

    generate
        if (ARM != 0 && ARM != 1) begin : illegal_arm
            wh_illegal_parameter_device_arm_must_be_0_or_1 stop ();
        end
        if (STREAM != 0 && STREAM != 1) begin : illegal_stream
            wh_illegal_parameter_device_stream_must_be_0_or_1 stop ();
        end
    endgenerate

    // ---- Registers.
    wire [65:0]             carrier;
    wire [56:0]             frame;
    wire [70:0]             sense;
    wire [3:0]              filter_clocks;
    wire [2*DELAY_LOG2-1:0] delay;
    wire [27:0]             bridge;
    wire [`WH_GUARD_W-1:0]  guard;
    wire [11:0]             host;
    wire [64:0]             magnets;
    wire                    magnet_start;
    wire                    in_force, write, write_bank;
    wire [11:0]             address;
    wire [31:0]             data;
    wire                    set_clear, host_alive, set_zero_start, set_restart;
    wire                    command;
    wire [11:0]             command_address;
    wire [31:0]             command_data;
    wire                    loading, busy;
    wire                    adc_ready;
    wire [`WH_FAULTS-1:0]   faults;
    wire                    live_valid;
    wire [PORT_W-1:0]       live_port;
    wire [3:0]              live_word;
    wire [31:0]             live_data;
    reg  [31:0]             other_q;
    wire                    surface_hold;
    wire [31:0]             surface_live;

    wh_registers #(
        .N                 (N),
        .WALLS             (WALLS),
        .DELAY_LOG2        (DELAY_LOG2),
        .SHAPER            (SHAPER),
        .AXES              (AXES)
    ) registers (
        .clk               (clk),
        .rst               (rst),
        .bus_valid_i       (bus_valid_i && !surface_hold),
        .bus_write_i       (bus_write_i),
        .bus_check_i       (bus_check_i),
        .bus_address_i     (bus_address_i),
        .bus_data_i        (bus_data_i),
        .bus_ready_o       (bus_ready_o),
        .bus_data_o        (bus_data_o),
        .bus_error_o       (bus_error_o),
        .bus_signed_o      (bus_signed_o),
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
        .write_o           (write),
        .write_bank_o      (write_bank),
        .address_o         (address),
        .data_o            (data),
        .clear_o           (set_clear),
        .host_alive_o      (host_alive),
        .zero_start_o      (set_zero_start),
        .magnet_start_o    (magnet_start),
        .restart_o         (set_restart),
        .command_o         (command),
        .command_address_o (command_address),
        .command_data_o    (command_data),
        .ready_o           (ready_o),
        .loading_o         (loading),
        .busy_o            (busy),
        .running_i         (running_o),
        .adc_ready_i       (adc_ready),
        .tick_i            (tick_o),
        .faults_i          (faults),
        .live_valid_i      (live_valid),
        .live_port_i       (live_port),
        .live_word_i       (live_word),
        .live_data_i       (live_data),
        .other_i           (other_q | surface_live)
    );

    // ---- On and off.
    wire       armed;
    wire [4:0] arm_refused;
    wire       arm_zero_start;
    wire       permitted = enable_i && armed && !loading;  // the bridges
    reg        clears_q;
    wire       clears     = set_clear || clear_i;
    wire       clear_zero = clears && !clears_q && !permitted;  // once, however long it lasts

    always @(posedge clk) begin
        clears_q <= rst || !ready_o || clears;
    end

    generate
        if (ARM != 0) begin : by_command
            wire [`WH_FAULTS-1:0] stops = faults & ~(guard[`WH_GUARD_DAMP] & `WH_FAULTS_DAMPABLE);

            wh_arm #(
                .SENSE        (1),
                .CREDIT       (ARM_CLOCKS)
            ) arm (
                .clk          (clk),
                .rst          (rst || !ready_o),
                .enable_i     (enable_i),
                .fault_i      (|(stops & ~ZERO)),
                .zero_i       (|(stops & ZERO)),
                .loading_i    (loading),
                .write_i      (command && command_address == ARM_GO),
                .value_i      (command_data[1:0]),
                .press_i      (press_i),
                .zero_start_o (arm_zero_start),
                .zero_busy_i  (zero_busy_o),
                .zero_fault_i (|zero_fault_o),
                .armed_o      (armed),
                .refused_o    (arm_refused)
            );
        end else begin : by_pin
            wire unused_press = &{1'b0, press_i};

            assign arm_zero_start = 1'b0;
            assign armed          = 1'b1;
            assign arm_refused    = 5'd0;
        end
    endgenerate

    // ---- A computer's answer: what was written last of its number and u, for any port.
    wire [3:0]            command_port = command_address[11:8] - 4'd1;
    reg  [7:0]            answer_sequence_q;
    reg  [`WH_DATA_W-1:0] answer_u_q;
    reg  [N-1:0]          answers_q;

    always @(posedge clk) begin
        answers_q <= {N{1'b0}};
        if (command && command_address[11:8] != 4'd0) begin
            if (command_address[7:0] == ANSWER_SEQUENCE) begin
                answer_sequence_q <= command_data[7:0];
            end
            if (command_address[7:0] == ANSWER_U) begin
                answer_u_q <= command_data[`WH_DATA_W-1:0];
            end
            if (command_address[7:0] == ANSWER) begin
                answers_q <= {{N-1{1'b0}}, command_data[0]} << command_port;
            end
        end
    end

    // ---- The controller.
    wire [N-1:0] unused_strobe;  // packets: live values

    wire [N-1:0]    found;
    wire [32*N-1:0] angles;
    wire            unused_angles = &{1'b0, angles};

    // ---- Surfaces across the ports.
    wire        surface_write, surface_commit, surface_busy, surface_refused, surface_alive;
    wire [9:0]  surface_address;
    wire [31:0] surface_data, surface_budget;
    wire [6:0]  surface_row;
    wire [1:0]  surfaces_acting;

    generate
        if (SURFACES > 0) begin : in_space
            localparam [31:0] SURFACES_32 = SURFACES;
            wire [15:0] stamp;
            reg  [31:0] live_q;  // as other_q

            assign surface_live = live_q;

            always @(posedge clk) begin
                live_q <= 32'd0;
                case (bus_address_i)
                    12'h0c6: live_q[3:0]  <= SURFACES_32[3:0];
                    12'h0c7: live_q[1:0]  <= surfaces_acting;
                    12'h0c8: live_q[0]    <= surface_busy;
                    12'h0c9: live_q[7:0]  <= surface_refused ? {1'b1, surface_row} : 8'd0;
                    12'h0ca: live_q[15:0] <= stamp;
                    default: live_q       <= 32'd0;
                endcase
            end

            wh_setting_group #(
                .STAGED       (0),
                .FIRST        (8'h5e),
                .WIDTHS       (8'd32),
                .TOTAL_W      (32)
            ) budget (
                .clk          (clk),
                .copy_i       (write),
                .address_i    (address),
                .data_i       (data),
                .change_i     (1'b0),
                .words_o      (surface_budget)
            );

            wh_surface_frame surface_frame (
                .clk       (clk),
                .rst       (rst || !ready_o),
                .word_i    (command && command_address >= SURFACE_WORD && command_address < SURFACE_COMMIT),
                .commit_i  (command && command_address == SURFACE_COMMIT),
                .data_i    (command_data),
                .hold_o    (surface_hold),
                .stamp_o   (stamp),
                .alive_o   (surface_alive),
                .free_i    (!write),
                .write_o   (surface_write),
                .address_o (surface_address),
                .data_o    (surface_data),
                .commit_o  (surface_commit),
                .refused_i (surface_refused)
            );
        end else begin : without_surfaces
            wire unused_surfaces = &{1'b0, surface_busy, surface_refused, surface_row, surfaces_acting};

            assign surface_live    = 32'd0;
            assign surface_hold    = 1'b0;
            assign surface_write   = 1'b0;
            assign surface_address = 10'd0;
            assign surface_data    = 32'd0;
            assign surface_commit  = 1'b0;
            assign surface_budget  = 32'd0;
            assign surface_alive   = 1'b0;
        end
    endgenerate

    wh_ports #(
        .N               (N),
        .WALLS           (WALLS),
        .DELAY_LOG2      (DELAY_LOG2),
        .ADC             (ADC),
        .OSR             (OSR),
        .ZERO_LOG2       (ZERO_LOG2),
        .SHAPER          (SHAPER),
        .MODES           (MODES),
        .MIN_PULSE       (MIN_PULSE),
        .HOST            (HOST),
        .SURFACES        (SURFACES),
        .AXES            (AXES)
    ) ports (
        .clk             (clk),
        .rst             (rst || !ready_o),
        .enable_i        (permitted),
        .adc_cs_n_o      (adc_cs_n_o),
        .adc_sclk_o      (adc_sclk_o),
        .adc_din_o       (adc_din_o),
        .adc_sdata_i     (adc_sdata_i),
        .enc_a_i         (enc_a_i),
        .enc_b_i         (enc_b_i),
        .gate_ah_o       (gate_ah_o),
        .gate_al_o       (gate_al_o),
        .gate_bh_o       (gate_bh_o),
        .gate_bl_o       (gate_bl_o),
        .stop_i          (stop_i),
        .driver_fault_i  (driver_fault_i),
        .bus_i           (bus_i),
        .carrier_i       (carrier),
        .frame_i         (frame),
        .sense_i         (sense),
        .filter_clocks_i (filter_clocks),
        .delay_i         (delay),
        .bridge_i        (bridge),
        .guard_i         (guard),
        .host_i          (host),
        .magnets_i       ({N{magnets}}),
        .surface_write_i   (surface_write),
        .surface_address_i (surface_address),
        .surface_commit_i  (surface_commit),
        .budget_i          ({surface_budget, 30'd0}),
        .surface_busy_o    (surface_busy),
        .surface_refused_o (surface_refused),
        .surface_refused_row_o (surface_row),
        .acting_o          (surfaces_acting),
        .force_i         (in_force),
        .write_i         (write),
        .write_bank_i    (write_bank),
        .address_i       (address),
        .data_i          (surface_write ? surface_data : data),
        .clear_i         (clears),
        .host_alive_i    (host_alive || surface_alive),
        .zero_start_i    (set_zero_start || zero_start_i || arm_zero_start || clear_zero),
        .restart_i       (set_restart),
        .magnet_start_i  (magnet_start),
        .host_strobe_i   (answers_q),
        .host_sequence_i (answer_sequence_q),
        .host_u_i        (answer_u_q),
        .host_strobe_o   (unused_strobe),
        .live_valid_o    (live_valid),
        .live_port_o     (live_port),
        .live_word_o     (live_word),
        .live_data_o     (live_data),
        .tick_o          (tick_o),
        .adc_ready_o     (adc_ready),
        .running_o       (running_o),
        .zero_busy_o     (zero_busy_o),
        .zero_faults_o   (zero_fault_o),
        .magnets_found_o (found),
        .magnet_angles_o (angles),
        .faults_o        (faults)
    );

    // ---- The values of a round, of which a capture (0) and a stream (1) choose theirs.
    wire         round;
    wire [1:0]   want, take, reads;
    wire [23:0]  code;
    wire [31:0]  word;
    wire         mean, any;
    wire [N-1:0] contact;

    wh_round_words #(
        .N            (N)
    ) round_words (
        .clk          (clk),
        .rst          (rst || !ready_o),
        .live_valid_i (live_valid),
        .live_port_i  (live_port),
        .live_word_i  (live_word),
        .live_data_i  (live_data),
        .bus_i        (bus_i),
        .faults_i     (faults),
        .contact_o    (contact),
        .want_i       (want),
        .reads_i      (reads),
        .code_i       (code),
        .strobe_o     (round),
        .take_o       (take),
        .word_o       (word),
        .mean_o       (mean),
        .any_o        (any)
    );

    wire [31:0] capture_data;
    wire [2:0]  capture_state;
    wire [15:0] capture_count, capture_first, capture_left;

    generate
        if (CAPTURE != 0) begin : captures
            // channel (8), channels, rows, pre, decimation, trigger, level
            wire [170:0] settings;

            wh_setting_group #(
                .STAGED         (0),
                .FIRST          (8'h50),
                .WORDS          (14),
                .WIDTHS         ({8'd32, 8'd3, 8'd4, 8'd16, 8'd16, 8'd4, {8{8'd12}}}),
                .TOTAL_W        (171)
            ) group (
                .clk            (clk),
                .copy_i         (write),
                .address_i      (address),
                .data_i         (data),
                .change_i       (1'b0),
                .words_o        (settings)
            );

            wh_capture #(
                .N              (N),
                .DEPTH_LOG2     (CAPTURE)
            ) recorder (
                .clk            (clk),
                .rst            (rst || !ready_o),
                .strobe_i       (round),
                .want_o         (want[0]),
                .take_i         (take[0]),
                .reads_o        (reads[0]),
                .code_o         (code[11:0]),
                .word_i         (word),
                .mean_i         (mean),
                .any_i          (any),
                .contact_i      (contact),
                .fault_i        (fault_o),
                .channel_i      (settings[95:0]),
                .channels_i     (settings[99:96]),
                .rows_i         (settings[115:100]),
                .pre_i          (settings[131:116]),
                .decimation_i   (settings[135:132]),
                .trigger_i      (settings[138:136]),
                .level_i        (settings[170:139]),
                .hold_i         (busy),
                .write_i        (command && command_address == CAPTURE_GO),
                .write_offset_i (command && command_address == CAPTURE_OFFSET),
                .data_i         (command_data[15:0]),
                .state_o        (capture_state),
                .count_o        (capture_count),
                .first_o        (capture_first),
                .left_o         (capture_left),
                .read_i         (bus_address_i[5:0]),
                .read_data_o    (capture_data)
            );
        end else begin : captures_nothing
            assign want[0]       = 1'b0;
            assign reads[0]      = 1'b0;
            assign code[11:0]    = 12'd0;
            assign capture_data  = 32'd0;
            assign capture_state = 3'd0;
            assign capture_count = 16'd0;
            assign capture_first = 16'd0;
            assign capture_left  = 16'd0;
        end
    endgenerate

    wire [1:0]  stream_state;
    wire [15:0] stream_lost;

    generate
        if (STREAM != 0) begin : streams
            wire [53:0] settings;  // channel (4), last, decimation
            wire [15:0] shifts;

            wh_setting_group #(
                .STAGED       (0),
                .FIRST        (8'h2a),
                .WORDS        (6),
                .WIDTHS       ({8'd4, 8'd2, {4{8'd12}}}),
                .TOTAL_W      (54)
            ) group (
                .clk          (clk),
                .copy_i       (write),
                .address_i    (address),
                .data_i       (data),
                .change_i     (1'b0),
                .words_o      (settings)
            );

            wh_setting_group #(
                .STAGED       (0),
                .FIRST        (8'h3a),
                .WORDS        (4),
                .WIDTHS       ({4{8'd4}}),
                .TOTAL_W      (16)
            ) cut (
                .clk          (clk),
                .copy_i       (write),
                .address_i    (address),
                .data_i       (data),
                .change_i     (1'b0),
                .words_o      (shifts)
            );

            wh_stream #(
                .CREDIT       (ARM_CLOCKS)
            ) stream (
                .clk          (clk),
                .rst          (rst || !ready_o),
                .strobe_i     (round),
                .want_o       (want[1]),
                .take_i       (take[1]),
                .reads_o      (reads[1]),
                .code_o       (code[23:12]),
                .word_i       (word),
                .mean_i       (mean),
                .any_i        (any),
                .channel_i    (settings[47:0]),
                .last_i       (settings[49:48]),
                .shift_i      (shifts),
                .decimation_i (settings[53:50]),
                .hold_i       (busy),
                .write_i      (command && command_address == STREAM_GO),
                .data_i       (command_data[1:0]),
                .state_o      (stream_state),
                .lost_o       (stream_lost),
                .credit_o     (stream_credit_o),
                .room_i       (stream_room_i),
                .byte_valid_o (stream_valid_o),
                .byte_first_o (stream_first_o),
                .byte_o       (stream_byte_o),
                .packet_o     (stream_packet_o)
            );
        end else begin : streams_nothing
            wire unused_room = &{1'b0, stream_room_i};

            assign want[1]         = 1'b0;
            assign reads[1]        = 1'b0;
            assign code[23:12]     = 12'd0;
            assign stream_state    = 2'd0;
            assign stream_lost     = 16'd0;
            assign stream_credit_o = 1'b0;
            assign stream_valid_o  = 1'b0;
            assign stream_first_o  = 1'b0;
            assign stream_byte_o   = 8'd0;
            assign stream_packet_o = 1'b0;
        end
    endgenerate

    // ---- Live registers that wh_registers hasn't got, a clock late; capture_data three.
    wire [3:0] part = bus_address_i[11:8] - 4'd1;
    wire       zero_faulty = ({28'd0, part} < N) && zero_fault_o[part[PORT_W-1:0]];

    always @(posedge clk) begin
        other_q <= 32'd0;
        if (bus_address_i[11:8] != 4'd0) begin
            case (bus_address_i[7:0])
                8'hd2:   other_q[0] <= zero_faulty;
                8'hd3:   other_q[0] <= zero_busy_o;
                default: other_q    <= 32'd0;
            endcase
        end else begin
            casez (bus_address_i[7:0])
                8'h39:        other_q[`WH_BUS_W-1:0] <= bus_i;
                8'h66:        other_q[0]    <= AXES != 0 && (&found);
                8'h67:        other_q       <= angles[32*FIRST +: 32];
                8'h69:        other_q[0]    <= tick_o;
                8'h79:        other_q[0]    <= armed;
                8'h7a:        other_q[4:0]  <= arm_refused;
                8'b10??_????: other_q       <= capture_data;
                8'hc0:        other_q[2:0]  <= capture_state;
                8'hc1:        other_q[15:0] <= capture_count;
                8'hc2:        other_q[15:0] <= capture_first;
                8'hc3:        other_q[15:0] <= capture_left;
                8'hc4:        other_q[1:0]  <= stream_state;
                8'hc5:        other_q[15:0] <= stream_lost;
                default:      other_q       <= 32'd0;
            endcase
        end
    end

    assign contact_o     = |contact;
    assign fault_o       = |faults;
    assign fault_lasts_o = |(faults & ~ZERO);
    assign clear_o       = set_clear;

    wire unused = &{1'b0, unused_strobe, command, command_address, command_data, busy, part, round, take, word, mean,
                    any};

endmodule

`default_nettype wire
