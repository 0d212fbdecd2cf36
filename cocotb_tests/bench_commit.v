// SPDX-License-Identifier: Apache-2.0
//
// bench_commit: wh_motor_device with its clock, an ADC that says anything and rotors that turn, in periods of
// any length, and a master that commits settings while the bridges are on.
//
// A run begins with a change of go_i and ends with done_o equal to it. In commit r every setting that may
// change while the bridges are on is its first value and r. mixed_o counts the words that were read in a
// step of the core, by its port anchors or by what scales its voltages, and that aren't of one commit.

`default_nettype none
`include "wh_formats.vh"

module bench_commit #(
    parameter integer N      = 1,
    parameter integer LEGS   = 2,
    parameter integer ANCHOR = 0,
    parameter integer SHAPER = 0,
    parameter integer SHARED = 0,
    parameter integer BUS    = 0,
    parameter integer PARTS  = (LEGS == 3) ? 2 : N  // derived, leave it
) (
    input  wire        go_i,
    input  wire [15:0] half_clocks_i,
    input  wire [15:0] tick_halves_i,
    input  wire [5:0]  frame_bits_i,
    input  wire [7:0]  commits_i,
    input  wire [3:0]  kinds_i,        // written: core, scale, anchor, sum and walls
    output reg         done_o,
    output reg  [31:0] worst_o,        // clocks from the command to the change-over's end
    output reg  [15:0] stuck_o,        // commits that took 64 periods and more
    output reg  [15:0] errors_o,       // of the bus
    output reg  [31:0] mixed_o,
    output reg  [31:0] steps_o,        // of the core, in which words were looked at
    output reg  [31:0] held_o,         // clocks in which a group waited that nobody had written
    output reg         overrun_o
);

    localparam [31:0] ROOT    = 32'h00400000;
    localparam [31:0] A       = 32'h01000000;
    localparam [31:0] U_MAX   = 32'h06000000;
    localparam [31:0] ETA     = 32'h01000000;
    localparam [31:0] SLOW    = 32'h00080000;
    localparam [31:0] SCALE   = 32'h00020000;
    localparam [31:0] GAIN    = 32'h00001000;

    reg clk = 1'b0;
    always #5 clk = !clk;

    reg              rst = 1'b1;
    reg              enable = 1'b0;
    reg              valid = 1'b0;
    reg              write = 1'b0;
    reg  [11:0]      address = 12'd0;
    reg  [31:0]      data = 32'd0;
    wire             ready;
    wire [31:0]      answer;
    wire [1:0]       error;
    wire             has_sign;
    reg  [PARTS-1:0] sdata = {PARTS{1'b0}};
    reg  [N-1:0]     enc_a = {N{1'b0}};
    reg  [N-1:0]     enc_b = {N{1'b0}};
    wire             given;

    wire             cs_n, sclk, din, tick, running, contact, fault, clears;
    wire [N-1:0]     ah, al, anchor_fault, encoder_fault;
    wire [PARTS-1:0] bh, bl, zero_busy, zero_fault, overcurrent;
    wire             credit, byte_valid, byte_first, packet;
    wire [7:0]       one_byte;
    wire             unused = &{1'b0, has_sign, cs_n, sclk, din, contact, fault, clears, ah, al, bh, bl, tick,
                                running, anchor_fault, encoder_fault, zero_busy, zero_fault, overcurrent,
                                credit, byte_valid, byte_first, packet, one_byte};

    wh_motor_device #(
        .N               (N),
        .LEGS            (LEGS),
        .ANCHOR          (ANCHOR),
        .SHAPER          (SHAPER),
        .SHARED          (SHARED),
        .BUS             (BUS)
    ) dut (
        .clk             (clk),
        .rst             (rst),
        .enable_i        (enable),
        .bus_valid_i     (valid),
        .bus_write_i     (write),
        .bus_check_i     (1'b0),
        .bus_address_i   (address),
        .bus_data_i      (data),
        .bus_ready_o     (ready),
        .bus_data_o      (answer),
        .bus_error_o     (error),
        .bus_signed_o    (has_sign),
        .adc_cs_n_o      (cs_n),
        .adc_sclk_o      (sclk),
        .adc_din_o       (din),
        .adc_sdata_i     (sdata),
        .enc_a_i         (enc_a),
        .enc_b_i         (enc_b),
        .gate_ah_o       (ah),
        .gate_al_o       (al),
        .gate_bh_o       (bh),
        .gate_bl_o       (bl),
        .bus_i           (16'd6144),
        .stop_i          (1'b0),
        .driver_fault_i  ({N{1'b0}}),
        .anchor_fault_i  ({N{1'b0}}),
        .clear_i         (1'b0),
        .zero_start_i    (1'b0),
        .press_i         (1'b0),
        .tick_o          (tick),
        .running_o       (running),
        .contact_o       (contact),
        .fault_o         (fault),
        .ready_o         (given),
        .clear_o         (clears),
        .zero_busy_o     (zero_busy),
        .zero_fault_o    (zero_fault),
        .anchor_fault_o  (anchor_fault),
        .encoder_fault_o (encoder_fault),
        .overcurrent_o   (overcurrent),
        .stream_credit_o (credit),
        .stream_valid_o  (byte_valid),
        .stream_first_o  (byte_first),
        .stream_byte_o   (one_byte),
        .stream_packet_o (packet),
        .stream_room_i   (1'b0)
    );

    // ---- The rotors, and the sensors' bits.
    reg [5:0]  turn = 6'd0;
    reg [31:0] noise = 32'd0;

    always @(negedge clk) begin
        noise <= $random;
        sdata <= noise[PARTS-1:0];
        turn  <= (turn == 6'd36) ? 6'd0 : turn + 6'd1;
        if (turn == 6'd0) begin
            enc_a <= enc_a ^ {N{enc_a == enc_b}};
            enc_b <= enc_b ^ {N{enc_a != enc_b}};
        end
    end

    // ---- The master.
    integer    m;
    integer    k;
    integer    r;
    integer    n;
    reg [31:0] read;
    reg [11:0] at;
    reg [31:0] waits;

    task ask;
        input        writes;
        input [11:0] where;
        input [31:0] word;
        begin
            valid   = 1'b1;
            write   = writes;
            address = where;
            data    = word;
            @(negedge clk);
            while (!ready) @(negedge clk);
            read = answer;
            if (error != 2'd0) errors_o = errors_o + 16'd1;
            valid = 1'b0;
            @(negedge clk);
        end
    endtask

    task rests;
        begin
            read = 32'd1;
            while (read[0]) ask(1'b0, 12'h072, 32'd0);
        end
    endtask

    // Settings of all motors, as commit `each` has them.
    task settings;
        input [3:0]  kinds;
        input [31:0] each;
        begin
            for (m = 1; m <= PARTS; m = m + 1) begin
                at = {m[3:0], 8'd0};
                if (kinds[3]) ask(1'b1, at + 12'h001, GAIN + each);
                if (LEGS == 2 || m == 1) begin
                    if (kinds[0]) begin
                        ask(1'b1, at + 12'h008, each - ETA);
                        ask(1'b1, at + 12'h009, ETA + each);
                        ask(1'b1, at + 12'h010, ROOT + each);
                        ask(1'b1, at + 12'h011, A + each);
                        ask(1'b1, at + 12'h012, U_MAX + each);
                    end
                    if (kinds[1]) ask(1'b1, at + 12'h018, SCALE + each);
                    if (kinds[2]) begin
                        for (k = 33; k <= 40; k = k + 1) ask(1'b1, at + k[11:0], ROOT + each);
                        ask(1'b1, at + 12'h029, U_MAX + each);
                        ask(1'b1, at + 12'h02a, U_MAX + each);
                        ask(1'b1, at + 12'h02d, SLOW + each);
                    end
                    if (kinds[3]) begin
                        ask(1'b1, at + 12'h040, each - 32'd40);
                        ask(1'b1, at + 12'h050, each);
                    end
                end
            end
        end
    endtask

    initial begin
        done_o = 1'b0;
        repeat (4) @(negedge clk);
        rst = 1'b0;
        while (!given) @(negedge clk);
        rests;
        while (1) begin
            while (go_i == done_o) @(negedge clk);
            worst_o  = 32'd0;
            stuck_o  = 16'd0;
            errors_o = 16'd0;
            mixed_o  = 32'd0;
            steps_o  = 32'd0;
            held_o   = 32'd0;
            ask(1'b1, 12'h000, {16'd0, half_clocks_i});
            ask(1'b1, 12'h001, {16'd0, tick_halves_i});
            ask(1'b1, 12'h002, half_clocks_i * tick_halves_i);
            ask(1'b1, 12'h009, {26'd0, frame_bits_i});
            ask(1'b1, 12'h00b, {26'd0, frame_bits_i} - 32'd2);
            ask(1'b1, 12'h020, 32'd1);
            settings(4'b1111, 32'd0);
            for (m = 1; m <= N; m = m + 1) begin
                at = {m[3:0], 8'd0};
                ask(1'b1, at + 12'h020, 32'd1);
                ask(1'b1, at + 12'h02b, 32'd100);
                ask(1'b1, at + 12'h02c, 32'd16);
                ask(1'b1, at + 12'h060, 32'd1);
            end
            ask(1'b1, 12'h070, 32'd1);
            rests;
            enable = 1'b1;
            repeat (12) @(posedge tick);
            for (r = 1; r <= commits_i; r = r + 1) begin
                settings(kinds_i, r);
                repeat ($random & 127) @(negedge clk);
                ask(1'b1, 12'h070, 32'd1);
                waits = 32'd0;
                while (dut.settings.commits_q || dut.settings.wait_q || dut.settings.settle_q) begin
                    @(negedge clk);
                    waits = waits + 32'd1;
                    if (waits == half_clocks_i * tick_halves_i * 64) begin
                        stuck_o = stuck_o + 16'd1;
                        enable  = 1'b0;
                        repeat (20) @(negedge clk);
                        enable  = 1'b1;
                    end
                end
                if (waits > worst_o) worst_o = waits;
                rests;
                repeat (2) @(posedge tick);
                @(negedge clk);
            end
            ask(1'b0, 12'h06b, 32'd0);
            overrun_o = read[0];
            enable    = 1'b0;
            repeat (4) @(negedge clk);
            done_o = go_i;
        end
    end

    // ---- Who reads what of which commit.
    wire [3:0] unwritten = ~kinds_i;

    always @(posedge clk) begin
        if (enable && dut.settings.settle_q) begin
            held_o <= held_o + ((unwritten[0] && ((|dut.pending_eta) || (|dut.pending_wave)))
                                || (unwritten[1] && (|dut.pending_scale))
                                || (unwritten[2] && (|dut.pending_anchor))
                                || (unwritten[3] && ((|dut.pending_current) || (|dut.pending_walls))));
        end
    end

    genvar g;
    generate
        if (LEGS == 2) begin : motors
            localparam integer LAST_READ = 19 + 5 * SHAPER;
            localparam integer PORT_W    = (N > 1) ? $clog2(N) : 1;

            wire        starts = dut.of_motors.controller.core_start && enable;
            wire        works  = dut.of_motors.controller.core_busy;
            wire        last   = dut.of_motors.controller.wave_core.last_port;
            wire [31:0] port   = {{32-PORT_W{1'b0}}, dut.of_motors.controller.wave_core.port};
            wire        reads  = starts || (works && !(last && (dut.of_motors.controller.wave_core.at_q >> (LAST_READ + 1)) != 0));
            wire [15:0] root   = dut.set_root[15:0];
            reg  [15:0] step_q;   // commit of the core's step
            reg  [15:0] voltage_q;  // of the voltages that it made
            wire [15:0] step   = starts ? root : step_q;

            always @(posedge clk) begin
                if (starts) begin
                    step_q  <= root;
                    steps_o <= steps_o + 32'd1;
                end
                if (dut.of_motors.controller.core_valid_o) begin
                    voltage_q <= step_q;
                end
            end

            for (g = 0; g < N; g = g + 1) begin : of_motor
                wire [`WH_COEF_W-1:0]   eta   = dut.of_motors.controller.eta[g*`WH_COEF_W +: `WH_COEF_W];
                wire [`WH_ANCHOR_W-1:0] words = dut.set_anchor_words[g*`WH_ANCHOR_W +: `WH_ANCHOR_W];
                wire                    asks  = dut.of_motors.controller.drive_request[g]
                                                && dut.of_motors.controller.others_grant[N+g];
                wire [15:0]             scale = dut.set_clocks_per_volt[g*`WH_COEF_W +: 16];
                wire [15:0]             made  = (ANCHOR == 0 && dut.of_motors.controller.core_valid_o) ? step_q
                                                                                                   : voltage_q;

                always @(posedge clk) begin
                    if (enable && reads
                        && (dut.set_root[g*`WH_COEF_W +: 16] != step
                            || dut.set_a[g*`WH_COEF_W +: 16] != step
                            || dut.set_u_max[g*`WH_DATA_W +: 16] != step
                            || (eta != 0 && works && port == g
                                && dut.of_motors.controller.wave_core.at_q[5 + 5 * SHAPER]
                                && eta[15:0] != step))) begin
                        mixed_o <= mixed_o + 32'd1;
                    end
                    if (enable && BUS == 0 && asks && scale != made) begin
                        mixed_o <= mixed_o + 32'd1;
                    end
                end

                if (ANCHOR != 0) begin : anchored
                    wire       begins = dut.of_motors.controller.waves[g];
                    wire       busy   = dut.of_motors.controller.each[g].port.anchored.anchor.busy_q;
                    wire [4:0] at_step = dut.of_motors.controller.each[g].port.anchored.anchor.step_q;
                    reg [15:0] own_q;
                    wire [15:0] own = begins ? step_q : own_q;

                    always @(posedge clk) begin
                        own_q <= own;
                        if (enable && (begins || (busy && at_step != 5'd0 && at_step < 5'd26))
                            && (words[16:1] != own || words[1+7*`WH_COEF_W +: 16] != own
                                || words[`WH_ANCHOR_W-`WH_REST_W +: 16] != own)) begin
                            mixed_o <= mixed_o + 32'd1;
                        end
                    end
                end
            end
        end else begin : one_brushless
            wire        starts = dut.brushless.controller.core_start && enable;
            wire        works  = dut.brushless.controller.core_busy;
            wire        last   = dut.brushless.controller.axes.wave_core.last_port;
            wire        reads  = starts || (works && !(last && (dut.brushless.controller.axes.wave_core.at_q >> 20) != 0));
            wire [15:0] root   = dut.set_root[15:0];
            wire [`WH_COEF_W-1:0]   eta   = dut.brushless.controller.axes.eta;
            wire [`WH_ANCHOR_W-1:0] words = dut.set_anchor_words[`WH_ANCHOR_W-1:0];
            reg  [15:0] step_q;
            wire [15:0] step   = starts ? root : step_q;

            always @(posedge clk) begin
                if (starts) begin
                    step_q  <= root;
                    steps_o <= steps_o + 32'd1;
                end
                if (enable && reads
                    && (root != step || dut.set_a[15:0] != step || dut.set_u_max[15:0] != step
                        || (works && eta != 0 && dut.brushless.controller.axes.wave_core.at_q[5]
                            && eta[15:0] != step))) begin
                    mixed_o <= mixed_o + 32'd1;
                end
                if (enable && dut.brushless.controller.core_valid_o && dut.set_clocks_per_volt[15:0] != step_q) begin
                    mixed_o <= mixed_o + 32'd1;
                end
            end

            if (ANCHOR != 0) begin : anchored
                for (g = 0; g < 2; g = g + 1) begin : of_axis
                    wire       begins = dut.brushless.controller.axes.waves[g];
                    wire       busy   = dut.brushless.controller.axes.anchored.axis[g].anchor.busy_q;
                    wire [4:0] at_step = dut.brushless.controller.axes.anchored.axis[g].anchor.step_q;
                    reg [15:0] own_q;
                    wire [15:0] own = begins ? step_q : own_q;

                    always @(posedge clk) begin
                        own_q <= own;
                        if (enable && (begins || (busy && at_step != 5'd0 && at_step < 5'd26))
                            && (words[16:1] != own || words[1+7*`WH_COEF_W +: 16] != own
                                || words[`WH_ANCHOR_W-`WH_REST_W +: 16] != own)) begin
                            mixed_o <= mixed_o + 32'd1;
                        end
                    end
                end
            end
        end
    endgenerate

endmodule

`default_nettype wire
