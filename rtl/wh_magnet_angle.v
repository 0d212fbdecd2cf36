// SPDX-License-Identifier: Apache-2.0
//
// wh_magnet_angle: finds where the magnets of brushless motors are, by the first movement of the hand.
//
//   an electrical angle that is off by δ makes χ of both axes' anchors jump with a count, by δ (-q_β, q_α);
//   the larger part of q says how far to turn back, a tenth of δ
//   found: in half a turn of the magnets, in quick counts, it was never turned back by an eighth, and the
//   jumps are a quarter of a cell in the mean; an encoder the wrong way round turns it by a whole turn
//
// Until then the anchors have no say (found_o = 0), and with it they begin anew (begin_o).
// Several motors take turns: motor_i holds from done_i until busy_o is low.
// sim/wavehaptics/controller/magnet_angle.py says the same with integers, and this module equals it bit
// for bit.
//
// Formats: angles are words of 2^32 to the turn; the mean is u17q16 cells, χ is s31q16.
// Latency: busy_o is low 5 clocks after done_i, or when the turn has been taken.
// Reset: found_o is !find_i, and nothing has moved since position_i, or with several motors since that of load_i.

`default_nettype none
`include "wh_formats.vh"

module wh_magnet_angle #(
    parameter integer MOTORS  = 1,                                 // 1...4
    parameter integer MOTOR_W = (MOTORS > 1) ? $clog2(MOTORS) : 1  // derived, leave it
) (
    input  wire                           clk,
    input  wire                           rst,

    input  wire [MOTORS-1:0]              find_i,         // 0: the angle is known
    input  wire [MOTOR_W-1:0]             motor_i,        // whose tick it is
    input  wire [31:0]                    count_angle_i,  // by which a count turns the magnets

    // Several motors, each once behind a reset: position_i is where load_motor_i stood.
    input  wire                           load_i,         // strobe, never with done_i
    input  wire [MOTOR_W-1:0]             load_motor_i,

    input  wire [`WH_REST_W-1:0]          rest_ticks_i,   // counts that come within it are quick

    // A tick, behind its anchors.
    input  wire                           done_i,         // strobe
    input  wire signed [`WH_COUNT_W-1:0]  position_i,     // s32, counts
    input  wire                           contact_i,
    input  wire [2*(`WH_SINE_Q+2)-1:0]    cell_i,         // s17q15 cells: q of the last count, alpha lowest
    input  wire [2*`WH_DATA_W-1:0]        flux_i,         // s31q16 cells: χ
    output wire                           busy_o,

    output reg                            turn_o,         // the angle is to be turned...
    output wire [31:0]                    by_o,           // ... by this
    input  wire                           turned_i,       // strobe, it is
    output reg  [MOTORS-1:0]              found_o,
    output reg                            begin_o         // strobe, for motor_i
);

    localparam integer DATA_W     = `WH_DATA_W;
    localparam integer CELL_W     = `WH_SINE_Q + 2;
    localparam integer SEEN_Q     = `WH_SEEN_Q;
    localparam integer JUMP_W     = SEEN_Q + 2;         // +-2 cells
    localparam integer MEAN_SHIFT = 6;
    localparam integer LOOP_SHIFT = 32 - SEEN_Q - 6;    // a rad of δ is turned back by 2^-6 of a turn
    localparam [JUMP_W-2:0] CELL  = {1'b1, {(JUMP_W - 2){1'b0}}};
    localparam [JUMP_W-2:0] SMALL = {3'b001, {(JUMP_W - 4){1'b0}}};

    // ---- What the tick brought: counts, and how far χ is from that of the last one.

    wire signed [`WH_COUNT_W-1:0] position;
    wire        [2*DATA_W-1:0]    flux;       // at the last count
    reg  signed [`WH_COUNT_W-1:0] moved_q;
    reg  signed [JUMP_W-1:0]      jump_a_q;
    reg  signed [JUMP_W-1:0]      jump_b_q;
    wire signed [JUMP_W-1:0]      jump_a;
    wire signed [JUMP_W-1:0]      jump_b;

    wire signed [DATA_W-1:0] from_a = $signed(flux_i[DATA_W-1:0]) - $signed(flux[DATA_W-1:0]);
    wire signed [DATA_W-1:0] from_b = $signed(flux_i[2*DATA_W-1:DATA_W])
                                      - $signed(flux[2*DATA_W-1:DATA_W]);

    wh_saturate #(
        .IN_W    (DATA_W),
        .OUT_W   (JUMP_W)
    ) saturate_a (
        .value_i (from_a),
        .value_o (jump_a)
    );

    wh_saturate #(
        .IN_W    (DATA_W),
        .OUT_W   (JUMP_W)
    ) saturate_b (
        .value_i (from_b),
        .value_o (jump_b)
    );

    wire                load       = (MOTORS == 1) ? rst : load_i;
    wire                known;  // the angle of this motor
    wire [31:0]         motor      = (MOTORS == 1) ? 32'd0 : {{(32 - MOTOR_W){1'b0}}, motor_i};

    assign known = |(found_o & ({{MOTORS-1{1'b0}}, 1'b1} << motor));

    wh_port_state #(
        .N           (MOTORS),
        .W           (`WH_COUNT_W)
    ) position_state (
        .clk         (clk),
        .rst         (1'b0),
        .port_i      (motor_i),
        .save_i      (load || done_i),
        .save_port_i (load ? load_motor_i : motor_i),
        .value_i     (position_i),
        .value_o     (position)
    );

    // ---- The steps of a tick.
    localparam [2:0] REST = 3'd0, COUNT = 3'd1, SIZE = 3'd2, MEAN = 3'd3, JUDGE = 3'd4, TURN = 3'd5;

    reg  [2:0]            state_q;
    wire                  back_was;  // direction of the last count
    wire [`WH_REST_W-1:0] ticks;     // since then
    wire [31:0]           passed;    // turned in quick counts, of half a turn
    wire [31:0]           net;       // and by what it was turned back
    wire                  far_was;   // that was an eighth
    wire [JUMP_W-2:0]     level;     // the mean of both jumps
    reg  [JUMP_W-2:0]     size_q;    // of this one
    reg  signed [JUMP_W-1:0] error_q;

    wire moved = (moved_q != {`WH_COUNT_W{1'b0}});
    wire back  = moved_q[`WH_COUNT_W-1];
    wire quick = (back == back_was) && (ticks < rest_ticks_i) && !contact_i;

    wire signed [CELL_W-1:0] cell_a = $signed(cell_i[CELL_W-1:0]);
    wire signed [CELL_W-1:0] cell_b = $signed(cell_i[2*CELL_W-1:CELL_W]);
    wire signed [CELL_W-1:0] size_a = cell_a[CELL_W-1] ? -cell_a : cell_a;
    wire signed [CELL_W-1:0] size_b = cell_b[CELL_W-1] ? -cell_b : cell_b;
    wire                     of_b   = (size_a >= size_b);
    wire                     minus  = of_b ? !(cell_a[CELL_W-1] ^ back) : (cell_b[CELL_W-1] ^ back);

    // A bit more holds -jump and both sizes; the least jump's size is its complement's and one.
    wire        [JUMP_W:0]   both   =
        {1'b0, jump_a_q[JUMP_W-1] ? -jump_a_q : jump_a_q}
        + {1'b0, jump_b_q[JUMP_W-1] ? -jump_b_q : jump_b_q};
    wire signed [JUMP_W-1:0] chosen = of_b ? jump_b_q : jump_a_q;
    reg                      minus_q;

    wire signed [JUMP_W-1:0] to_size = $signed({1'b0, size_q}) - $signed({1'b0, level});
    wire signed [JUMP_W-1:0] by_part = to_size >>> MEAN_SHIFT;
    wire        [JUMP_W-1:0] mean    = {1'b0, level} + by_part;
    wire        [31:0]       turn    = count_angle_i[31] ? -count_angle_i : count_angle_i;
    wire        [32:0]       passes  = {1'b0, passed} + {1'b0, turn};
    wire        [32-LOOP_SHIFT:0] error = {{(33 - LOOP_SHIFT - JUMP_W){error_q[JUMP_W-1]}}, error_q};
    wire        [32-LOOP_SHIFT:0] by    = minus_q ? -error : error;
    wire                     far     = far_was || !((&net[31:29]) || !(|net[31:29]));
    wire                     ends    = passed[31];  // half a turn
    wire                     unused  = &{1'b0, mean[JUMP_W-1], by[32-LOOP_SHIFT], load_i};

    assign busy_o = (state_q != REST) || done_i || begin_o;
    assign by_o   = {by[31-LOOP_SHIFT:0], {LOOP_SHIFT{1'b0}}};

    // A motor's counts and its half turn. What isn't 0 behind a reset is stored inverted.
    wire [`WH_REST_W-1:0] ticks_inverted;
    wire [JUMP_W-2:0]     level_inverted;

    assign ticks = ~ticks_inverted;
    assign level = level_inverted ^ CELL;

    wh_port_state #(
        .N           (MOTORS),
        .W           (1 + `WH_REST_W + 2 * DATA_W)
    ) count_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (motor_i),
        .save_i      (state_q == COUNT),
        .save_port_i (motor_i),
        .value_i     (moved ? {back, {`WH_REST_W{1'b1}}, flux_i}
                            : {back_was, ticks_inverted - {{`WH_REST_W-1{1'b0}}, |ticks_inverted}, flux}),
        .value_o     ({back_was, ticks_inverted, flux})
    );

    wh_port_state #(
        .N           (MOTORS),
        .W           (65 + JUMP_W - 1)
    ) turn_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (motor_i),
        .save_i      (state_q == MEAN || state_q == JUDGE),
        .save_port_i (motor_i),
        .value_i     ((state_q == MEAN) ? {far_was, passes[32] ? 32'hffffffff : passes[31:0], net + by_o,
                                           mean[JUMP_W-2:0] ^ CELL}
                                        : {far && !ends, ends ? 64'd0 : {passed, net}, level_inverted}),
        .value_o     ({far_was, passed, net, level_inverted})
    );

    always @(posedge clk) begin
        begin_o <= 1'b0;
        if (rst) begin
            state_q <= REST;
            turn_o  <= 1'b0;
            found_o <= ~find_i;
        end else begin
            case (state_q)
                REST:    state_q <= (done_i && !known) ? COUNT : REST;
                COUNT:   state_q <= (moved && quick) ? SIZE : REST;
                SIZE:    state_q <= MEAN;
                MEAN:    state_q <= JUDGE;
                JUDGE: begin
                    if (ends && level < SMALL && !far) begin
                        found_o <= found_o | ({{MOTORS-1{1'b0}}, 1'b1} << motor);
                        begin_o <= 1'b1;
                    end
                    turn_o  <= 1'b1;
                    state_q <= TURN;
                end
                default: begin
                    if (turned_i) begin
                        turn_o  <= 1'b0;
                        state_q <= REST;
                    end
                end
            endcase
        end
        if (done_i) begin
            moved_q  <= position_i - position;
            jump_a_q <= jump_a;
            jump_b_q <= jump_b;
        end
        if (state_q == SIZE) begin
            error_q <= chosen;
            minus_q <= minus;
            size_q  <= (|both[JUMP_W:JUMP_W-1]) ? {JUMP_W-1{1'b1}} : both[JUMP_W-2:0];
        end
    end

endmodule

`default_nettype wire
