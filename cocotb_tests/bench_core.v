// SPDX-License-Identifier: Apache-2.0
//
// bench_core: N ports of one wh_core beside N wh_wave_core, which get the same words.
//
// go_i begins a period: every wh_wave_core makes its step at once, and the ports of wh_core theirs in turn, PITCH
// clocks each. done_o follows when all of them have ended. Of each port's results differs_o says which ones aren't
// the same then: what is before the next step (withheld, e, saturated), saturated, clipped, e, v, u, from the
// highest on.

`default_nettype none
`include "wh_formats.vh"

module bench_core #(
    parameter integer N          = 1,
    parameter integer DELAY_LOG2 = 2,
    parameter integer OUTSIDE    = 0,
    parameter integer SHAPER     = 0,
    parameter integer PITCH      = (SHAPER == 2) ? 36 : 32,
    parameter integer SHAPE_BITS = ((SHAPER > 0) ? SHAPER : 1) * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W),
    parameter integer PORT_W     = (N > 1) ? $clog2(N) : 1
) (
    input  wire                       clk,
    input  wire                       rst,

    input  wire                       go_i,
    output wire                       done_o,        // strobe

    input  wire [N*`WH_DATA_W-1:0]    current_i,
    input  wire [2*N-1:0]             ends_i,
    input  wire [N*`WH_COEF_W-1:0]    eta_i,
    input  wire [N*`WH_DATA_W-1:0]    outside_i,
    input  wire [2*N-1:0]             shape_mode_i,
    input  wire [DELAY_LOG2-1:0]      extra_ticks_i,
    input  wire [DELAY_LOG2-1:0]      hold_ticks_i,
    input  wire                       room_valid_i,  // strobe
    input  wire [PORT_W-1:0]          room_port_i,
    input  wire [`WH_DATA_W-1:0]      room_i,

    input  wire [N*`WH_COEF_W-1:0]    root_i,        // settings
    input  wire [N*`WH_COEF_W-1:0]    a_i,
    input  wire [N*`WH_DATA_W-1:0]    u_max_i,
    input  wire [N*SHAPE_BITS-1:0]    shape_words_i,
    input  wire                       bank_i,
    input  wire                       write_i,
    input  wire                       write_bank_i,
    input  wire [11:0]                address_i,
    input  wire [31:0]                data_i,

    output reg  [N*`WH_DATA_W-1:0]    voltage_o,     // of wh_core
    output reg  [N-1:0]               saturated_o,
    output reg  [N-1:0]               clipped_o,
    output wire [6*N-1:0]             differs_o
);

    localparam [7:0]   TURN   = PITCH[7:0];
    localparam integer LATER  = 5 * SHAPER;  // with W
    localparam [7:0]   W      = LATER[7:0];
    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam [7:0]   MODE_ENDS = (SHAPER == 2) ? 8'd32 : 8'd21;

    // ---- Turns.
    reg [PORT_W-1:0] turn_q;
    reg [7:0]        wait_q;
    reg              runs_q;
    wire             last  = ({{(32 - PORT_W){1'b0}}, turn_q} == N - 1);
    wire             valid = go_i || (runs_q && wait_q == 8'd0 && !last);
    wire [PORT_W-1:0] port = go_i ? {PORT_W{1'b0}} : turn_q + 1'b1;

    assign done_o = runs_q && last && wait_q == 8'd0;

    always @(posedge clk) begin
        if (rst) begin
            runs_q <= 1'b0;
            turn_q <= {PORT_W{1'b0}};
        end else if (valid) begin
            runs_q <= 1'b1;
            turn_q <= port;
            wait_q <= TURN - 8'd1;
        end else if (runs_q) begin
            wait_q <= wait_q - 8'd1;
            runs_q <= !done_o;
        end
    end

    // ---- One for all ports, whose words are noise whenever they don't count. at is the clock of the turn.
    wire [7:0]        at       = TURN - wait_q;
    wire [DATA_W-1:0] current  = current_i[turn_q*DATA_W +: DATA_W] ^ {DATA_W{at < 8'd1 || at > 8'd5}};
    wire [COEF_W-1:0] eta      = eta_i[turn_q*COEF_W +: COEF_W] ^ {COEF_W{at != 8'd6 + W}};
    wire [DATA_W-1:0] outside  = outside_i[turn_q*DATA_W +: DATA_W] ^ {DATA_W{at < 8'd8 + W || at > 8'd10 + W}};

    wire                            request, core_valid, clipped, saturated, saturated_before;
    wire                            waves_valid, bank;
    wire                            unused_turn = &{1'b0, waves_valid, bank};
    wire [PORT_W-1:0]               whose;
    wire                            looked;  // there are none
    wire signed [DATA_W-1:0]        goal;
    wire                            unused_look = &{1'b0, looked, goal};
    wire signed [DATA_W-1:0]        factor, voltage, u, v, voltage_before, withheld_before;
    wire signed [COEF_W-1:0]        coefficient;
    wire signed [DATA_W+COEF_W-1:0] product, made;

    wh_core #(
        .N                  (N),
        .DELAY_LOG2         (DELAY_LOG2),
        .OUTSIDE            (OUTSIDE),
        .SHAPER             (SHAPER)
    ) core (
        .clk                (clk),
        .rst                (rst),
        .valid_i            (valid),
        .port_i             (port),
        .bank_i             (bank_i),
        .look_i             (1'b0),
        .current_i          ($signed(current)),
        .ends_i             (ends_i[2*turn_q +: 2] ^ {2{at < 8'd1 || at > 8'd5}}),
        .eta_i              ($signed(eta)),
        .outside_i          ($signed(outside)),
        .shape_mode_i       (shape_mode_i[2*turn_q +: 2] ^ {2{at < 8'd9 || at > MODE_ENDS}}),
        .extra_ticks_i      (extra_ticks_i),
        .hold_ticks_i       (hold_ticks_i),
        .room_rst_i         ({N{1'b0}}),
        .room_valid_i       (room_valid_i),
        .room_port_i        (room_port_i),
        .room_i             ($signed(room_i)),
        .write_i            (write_i),
        .write_bank_i       (write_bank_i),
        .address_i          (address_i),
        .data_i             (data_i),
        .request_o          (request),
        .factor_o           (factor),
        .coefficient_o      (coefficient),
        .product_i          (product),
        .valid_o            (core_valid),
        .looked_o           (looked),
        .goal_o             (goal),
        .waves_valid_o      (waves_valid),
        .port_o             (whose),
        .bank_o             (bank),
        .voltage_o          (voltage),
        .u_o                (u),
        .v_o                (v),
        .clipped_o          (clipped),
        .saturated_o        (saturated),
        .voltage_before_o   (voltage_before),
        .withheld_before_o  (withheld_before),
        .saturated_before_o (saturated_before)
    );

    // What nobody asked for is no product.
    reg [2:0] asked_q;

    always @(posedge clk) begin
        asked_q <= {asked_q[1:0], request};
    end

    wh_multiply multiply (
        .clk       (clk),
        .take_i    (1'b1),
        .data_i    (factor),
        .coef_i    (coefficient),
        .product_o (made)
    );

    assign product = asked_q[2] ? made : ~made;

    reg [N*DATA_W-1:0] u_q;
    reg [N*DATA_W-1:0] v_q;
    reg [2*N*DATA_W+N-1:0] before_q;  // what the turn of each port found
    wire [2*DATA_W:0]      before_now = {saturated_before, withheld_before, voltage_before};

    always @(posedge clk) begin
        if (rst) begin
            voltage_o   <= {N*DATA_W{1'b0}};
            u_q         <= {N*DATA_W{1'b0}};
            v_q         <= {N*DATA_W{1'b0}};
            saturated_o <= {N{1'b0}};
            clipped_o   <= {N{1'b0}};
            before_q    <= {2*N*DATA_W+N{1'b0}};
        end else begin
            if (runs_q && at == 8'd17 + W) begin
                before_q[whose*(2*DATA_W+1) +: 2*DATA_W+1] <= before_now;
            end
            if (core_valid) begin
                voltage_o[whose*DATA_W +: DATA_W] <= voltage;
                u_q[whose*DATA_W +: DATA_W]       <= u;
                v_q[whose*DATA_W +: DATA_W]       <= v;
                saturated_o[whose]                <= saturated;
                clipped_o[whose]                  <= clipped;
            end
        end
    end

    // ---- One for each port. Its limit is the setting less the room, as of the step's start.
    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : each
            wire signed [DATA_W-1:0] one_voltage, one_u, one_v, one_withheld, one_factor;
            wire signed [COEF_W-1:0] one_coefficient;
            wire                     one_clipped, one_saturated, busy, reads, one_valid, overrun, waves, one_request;
            wire                     unused = &{1'b0, busy, reads, one_valid, overrun, waves, one_request,
                                                one_factor, one_coefficient};
            reg  signed [DATA_W-1:0] room_q;
            reg  signed [DATA_W-1:0] max_q;
            reg  [2*DATA_W:0]        one_before_q;
            wire signed [DATA_W-1:0] left = $signed(u_max_i[n*DATA_W +: DATA_W]) - room_q;

            always @(posedge clk) begin
                if (rst) begin
                    room_q <= {DATA_W{1'b0}};
                end else if (room_valid_i && {{(32 - PORT_W){1'b0}}, room_port_i} == n) begin
                    room_q <= $signed(room_i);
                end
                if (go_i) begin
                    max_q <= left[DATA_W-1] ? {DATA_W{1'b0}} : left;
                end
                if (rst) begin
                    one_before_q <= {2*DATA_W+1{1'b0}};
                end else if (go_i) begin
                    one_before_q <= {one_saturated, one_withheld, one_voltage};
                end
            end

            wh_wave_core #(
                .N             (1),
                .DELAY_LOG2    (DELAY_LOG2),
                .OUTSIDE       (OUTSIDE),
                .SHAPER        (SHAPER),
                .WITHHELD      (1)
            ) wave_core (
                .clk           (clk),
                .rst           (rst),
                .start_i       (go_i),
                .busy_o        (busy),
                .reads_o       (reads),
                .valid_o       (one_valid),
                .overrun_o     (overrun),
                .current_i     ($signed(current_i[n*DATA_W +: DATA_W])),
                .eta_i         ($signed(eta_i[n*COEF_W +: COEF_W])),
                .outside_i     ($signed(outside_i[n*DATA_W +: DATA_W])),
                .ends_i        (ends_i[2*n +: 2]),
                .shape_mode_i  (shape_mode_i[2*n +: 2]),
                .shape_words_i (shape_words_i[n*SHAPE_BITS +: SHAPE_BITS]),
                .root_i        ($signed(root_i[n*COEF_W +: COEF_W])),
                .a_i           ($signed(a_i[n*COEF_W +: COEF_W])),
                .u_max_i       (max_q),
                .extra_ticks_i (extra_ticks_i),
                .hold_ticks_i  (hold_ticks_i),
                .voltage_o     (one_voltage),
                .u_o           (one_u),
                .v_o           (one_v),
                .saturated_o   (one_saturated),
                .withheld_o    (one_withheld),
                .clipped_o     (one_clipped),
                .waves_o       (waves),
                .request_o     (one_request),
                .factor_o      (one_factor),
                .coefficient_o (one_coefficient),
                .product_i     ({(DATA_W + COEF_W){1'b0}})
            );

            assign differs_o[6*n +: 6] = {
                one_before_q != before_q[n*(2*DATA_W+1) +: 2*DATA_W+1],
                one_saturated != saturated_o[n],
                one_clipped != clipped_o[n],
                one_voltage != $signed(voltage_o[n*DATA_W +: DATA_W]),
                one_v != $signed(v_q[n*DATA_W +: DATA_W]),
                one_u != $signed(u_q[n*DATA_W +: DATA_W])
            };
        end
    endgenerate

endmodule

`default_nettype wire
