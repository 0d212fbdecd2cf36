// SPDX-License-Identifier: Apache-2.0
//
// bench_wave_core: drives wh_wave_core with a stream of ticks at the simulator's own speed.
//
// tb_wave_core.py writes stimulus.hex (a word a tick), raises go_i, and waits for done_o; the
// answers are then in response.hex. Each tick is a step, with some clocks of pause before it; on
// request it begins with a reset, has another start_i while the core is busy, or is cut short by a
// reset.
// The inputs change in the middle of a clock, so a pause of 0 starts together with valid_o.
// With SHARED = 1 the core has a multiplier for which somebody else asks in every clock.

`default_nettype none
`include "wh_formats.vh"
`timescale 1ns / 1ps

module bench_wave_core #(
    parameter integer N          = 1,
    parameter integer DELAY_LOG2 = 2,
    parameter integer OUTSIDE    = 1,
    parameter integer SHAPER     = 0,
    parameter integer WITHHELD   = 0,
    parameter integer SHARED     = 0,
    parameter integer TICKS      = 1024  // room in the memories, and for more: see EIGHTHS and LIMITS
) (
    input  wire        go_i,
    input  wire [31:0] ticks_i,
    output reg         done_o
);

    localparam integer DATA_N = N * `WH_DATA_W;
    localparam integer COEF_N = N * `WH_COEF_W;
    // In stimulus.hex's words, from the top: reset, abort, poke, clock, pause; the core's inputs.
    localparam integer SHAPE_N = N * ((SHAPER > 0) ? SHAPER : 1)
                                 * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W);
    localparam integer STIMULUS_W = 3 + 8 + 8 + 2 * DELAY_LOG2 + 4 * N + SHAPE_N
                                    + 3 * DATA_N + 3 * COEF_N;
    // In response.hex's words, from the top: faults, clocks, overrun; the core's outputs.
    localparam integer RESPONSE_W = 8 + 16 + 1 + 2 * N + 4 * DATA_N;

    // Clocks of a port's turn, and from its first one until its waves are there.
    localparam integer TURN  = 24 + 5 * SHAPER;
    localparam integer WAVES = 6;

    localparam integer EIGHTHS = 200;
    localparam integer LIMITS  = 60;

    reg [STIMULUS_W-1:0] stimulus [0:TICKS+EIGHTHS+LIMITS-1];
    reg [RESPONSE_W-1:0] response [0:TICKS+EIGHTHS+LIMITS-1];

    reg clk = 1'b0;
    reg rst = 1'b1;
    reg start = 1'b0;
    always #5 clk = !clk;

    reg              reset_first;
    reg              abort;  // reset after `at` clocks of the step
    reg              poke;   // start again after `at` clocks of the step
    reg [7:0]        at;
    reg [7:0]        pause;
    reg [DELAY_LOG2-1:0] extra_ticks = {DELAY_LOG2{1'b0}};
    reg [DELAY_LOG2-1:0] hold_ticks = {DELAY_LOG2{1'b0}};
    reg [DATA_N-1:0] current = {DATA_N{1'b0}};
    reg [DATA_N-1:0] outside = {DATA_N{1'b0}};
    reg [2*N-1:0]    ends = {2*N{1'b0}};
    reg [2*N-1:0]    mode = {2*N{1'b0}};
    reg [SHAPE_N-1:0] shape = {SHAPE_N{1'b0}};
    reg [DATA_N-1:0] u_max = {DATA_N{1'b0}};
    reg [COEF_N-1:0] eta = {COEF_N{1'b0}};
    reg [COEF_N-1:0] root = {COEF_N{1'b0}};
    reg [COEF_N-1:0] a = {COEF_N{1'b0}};

    wire              busy;
    wire              reads;
    wire              valid;
    wire              overrun;
    wire [DATA_N-1:0] voltage;
    wire [DATA_N-1:0] u;
    wire [DATA_N-1:0] v;
    wire [N-1:0]      saturated;
    wire [DATA_N-1:0] withheld;
    wire [N-1:0]      clipped;
    wire [N-1:0]      waves;

    wire                                    request;
    wire signed [`WH_DATA_W-1:0]            factor;
    wire signed [`WH_COEF_W-1:0]            coefficient;
    wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product;

    generate
        if (SHARED == 1) begin : shared
            wh_multiply_shared #(
                .USERS     (2)
            ) multiply_shared (
                .clk       (clk),
                .rst       (rst),
                .drop_i    (2'b00),
                .request_i ({1'b1, request}),
                .data_i    ({~factor, factor}),
                .coef_i    ({~coefficient, coefficient}),
                .grant_o   (),
                .done_o    (),
                .product_o (product)
            );
        end else begin : own
            assign product = {`WH_DATA_W + `WH_COEF_W{1'b0}};
        end
    endgenerate

    wh_wave_core #(
        .N             (N),
        .DELAY_LOG2    (DELAY_LOG2),
        .OUTSIDE       (OUTSIDE),
        .SHAPER        (SHAPER),
        .WITHHELD      (WITHHELD),
        .SHARED        (SHARED)
    ) core (
        .clk           (clk),
        .rst           (rst),
        .start_i       (start),
        .busy_o        (busy),
        .reads_o       (reads),
        .valid_o       (valid),
        .overrun_o     (overrun),
        .current_i     (current),
        .eta_i         (busy ? eta : ~eta),          // not read in a step's first clock
        .outside_i     (busy ? outside : ~outside),
        .ends_i        (ends),
        .shape_mode_i  (busy ? mode : ~mode),
        .shape_words_i (reads ? shape : ~shape),     // nor these in its last ones
        .root_i        (reads ? root : ~root),
        .a_i           (reads ? a : ~a),
        .u_max_i       ((busy && reads) ? u_max : ~u_max),
        .extra_ticks_i (extra_ticks),
        .hold_ticks_i  (hold_ticks),
        .voltage_o     (voltage),
        .u_o           (u),
        .v_o           (v),
        .saturated_o   (saturated),
        .withheld_o    (withheld),
        .clipped_o     (clipped),
        .waves_o       (waves),
        .request_o     (request),
        .factor_o      (factor),
        .coefficient_o (coefficient),
        .product_i     (product)
    );

    integer    tick;
    reg [15:0] clocks;
    reg [7:0]  faults;  // valid, busy or waves where they should not be, or not where they should
    reg        going;
    integer    port;

    // The waves of each port when their strobe came.
    reg [DATA_N-1:0] strobed_u;
    reg [DATA_N-1:0] strobed_v;
    reg [N-1:0]      strobed_clipped;

    initial begin
        done_o = 1'b0;
        wait (go_i);
        $readmemh("stimulus.hex", stimulus);
        repeat (2) @(negedge clk);
        rst = 1'b0;
        for (tick = 0; tick < ticks_i; tick = tick + 1) begin
            {reset_first, abort, poke, at, pause,
             extra_ticks, hold_ticks, ends, mode, shape, u_max, a, root, outside, eta, current} = stimulus[tick];
            faults = 8'd0;
            if (reset_first) begin
                rst = 1'b1;
                @(negedge clk);
                rst = 1'b0;
                if (valid !== 1'b0 || busy !== 1'b0 || waves !== {N{1'b0}}) faults = faults + 8'd1;
            end
            repeat ({24'd0, pause}) begin
                @(negedge clk);
                if (valid !== 1'b0 || busy !== 1'b0 || waves !== {N{1'b0}}) faults = faults + 8'd1;
            end
            start  = 1'b1;
            clocks = 16'd0;
            going  = 1'b1;
            while (going) begin
                @(negedge clk);
                clocks = clocks + 16'd1;
                start  = poke && clocks == {8'd0, at};
                for (port = 0; port < N; port = port + 1) begin
                    if (waves[port] !== ({16'd0, clocks} == port * TURN + WAVES)) faults = faults + 8'd1;
                    if (waves[port]) begin
                        strobed_u[port*`WH_DATA_W +: `WH_DATA_W] = u[port*`WH_DATA_W +: `WH_DATA_W];
                        strobed_v[port*`WH_DATA_W +: `WH_DATA_W] = v[port*`WH_DATA_W +: `WH_DATA_W];
                        strobed_clipped[port] = clipped[port];
                    end
                end
                if (abort && clocks == {8'd0, at}) begin
                    rst = 1'b1;
                    @(negedge clk);
                    rst = 1'b0;
                    if (valid !== 1'b0 || waves !== {N{1'b0}}) faults = faults + 8'd1;
                end
                if (busy !== !(valid || (abort && clocks == {8'd0, at}))) faults = faults + 8'd1;
                going = busy === 1'b1 && clocks != 16'hFFFF;
            end
            if (!abort && {strobed_clipped, strobed_u, strobed_v} !== {clipped, u, v})
                faults = faults + 8'd1;
            response[tick] = {faults, clocks, overrun, clipped, saturated, withheld, v, u, voltage};
        end
        $writememh("response.hex", response);
        done_o = 1'b1;
    end

endmodule

`default_nettype wire
