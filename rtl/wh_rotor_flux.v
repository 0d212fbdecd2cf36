// SPDX-License-Identifier: Apache-2.0
//
// wh_rotor_flux: what the encoders' counts do to the flux that the magnets of brushless motors have in the axes alpha
// and beta, in counts of the encoder. It stands between wh_quadrature and all that looks at the position, which comes
// out of it with the flux that belongs to it.
//
//   a count up passes an edge at the electrical angle θ, and changes the flux by q = (-sin θ, cos θ);
//   a count down takes the same words off again, unless the angle was turned (wh_magnet_angle) in between
//
// sim/wavehaptics/controller/rotor_flux.py says the same with integers, and this module equals it bit for
// bit, count for count. A quarter of a sine, 256 words from wh_sine.vh, is looked up for the one axis and
// then for the other.
// Several motors take turns, count by count: a motor without a count takes one clock, one with a count two.
//
// Formats: angles are words of 2^32 to the turn.
// Latency: 6 clocks from position_i to position_o, which follows by a count in two clocks at most; with several motors
// up to 2 (MOTORS - 1) clocks more, and a count in 2 MOTORS clocks.
// Reset: position_o is position_i, whose middle is at zero_angle_i; no flux. Several motors' positions and angles are
// taken in the clocks after it, with load_o: a motor in each.

`default_nettype none
`include "wh_formats.vh"

module wh_rotor_flux #(
    parameter integer MOTORS  = 1,                                 // 1...4
    parameter integer MOTOR_W = (MOTORS > 1) ? $clog2(MOTORS) : 1  // derived, leave it
) (
    input  wire                                   clk,
    input  wire                                   rst,

    // The first motor lowest.
    input  wire [MOTORS*`WH_COUNT_W-1:0]          position_i,     // s32, counts
    input  wire [32*MOTORS-1:0]                   count_angle_i,  // by which a count turns the magnets
    input  wire [32*MOTORS-1:0]                   zero_angle_i,
    input  wire                                   turn_i,         // the angle of turn_motor_i is to be turned...
    input  wire [MOTOR_W-1:0]                     turn_motor_i,
    input  wire [31:0]                            by_i,           // ... by this
    output wire                                   turned_o,       // it is, in this clock
    output wire [32*MOTORS-1:0]                   angle_o,        // of the position that comes, in its middle

    output wire                                   load_o,         // strobe, after a reset: position and angle...
    output wire [MOTOR_W-1:0]                     load_motor_o,   // ... of this motor
    output wire signed [`WH_COUNT_W-1:0]          load_position_o,

    input  wire [MOTOR_W-1:0]                     motor_i,        // whose these are, in the same clock
    output wire signed [`WH_COUNT_W-1:0]          position_o,     // s32, counts
    // Alpha lowest.
    output wire [2*(`WH_PLACE_W+`WH_SINE_Q)-1:0]  place_o,        // s30q15 cells, modulo 2^15: all counts
    output wire [2*(`WH_SINE_Q+2)-1:0]            cell_o          // s17q15 cells: q of the last one
);

    localparam integer COUNT_W = `WH_COUNT_W;
    localparam integer SINE_W  = `WH_SINE_Q + 1;
    localparam integer CELL_W  = `WH_SINE_Q + 2;
    localparam integer FLUX_W  = `WH_PLACE_W + `WH_SINE_Q;
    localparam integer SUMS_W  = 2 * FLUX_W + COUNT_W;
    localparam integer LAST    = MOTORS - 1;

    generate
        if (MOTORS < 1 || MOTORS > 4) begin : illegal
            wh_illegal_parameter_rotor_flux_motors_must_be_1_to_4 stop ();
        end
    endgenerate

    // ---- A quarter of a sine, at the middles of its entries' parts.

    (* rom_style = "block" *) reg [SINE_W-1:0] sines [0:255];

    initial begin
`define WH_SINE(INDEX, WORD) sines[INDEX] = WORD;
`include "wh_sine.vh"
`undef WH_SINE
    end

    // ---- Whose turn it is: the motor whose count is looked for in this clock, or in the first of two is taken.

    reg  [MOTOR_W-1:0] next_q;
    reg  [MOTOR_W-1:0] due_motor_q;  // of due_q
    reg                due_q;        // there is a count,
    reg                back_q;       // down
    reg                second_q;     // the second clock
    wire               load;
    wire               takes = !second_q && due_q;
    wire [MOTOR_W-1:0] motor = takes ? due_motor_q : next_q;

    generate
        if (MOTORS == 1) begin : one
            assign load = rst;

            always @(posedge clk) begin
                next_q      <= 1'b0;
                due_motor_q <= 1'b0;
            end
        end else begin : several
            reg [(1<<MOTOR_W)-1:0] fresh_q;  // since a reset nothing was taken of it

            assign load = fresh_q[next_q] && !takes && !rst;

            always @(posedge clk) begin
                if (rst) begin
                    fresh_q     <= {(1<<MOTOR_W){1'b1}};
                    next_q      <= {MOTOR_W{1'b0}};
                    due_motor_q <= {MOTOR_W{1'b0}};
                end else if (!takes) begin
                    fresh_q[next_q] <= 1'b0;
                    due_motor_q     <= next_q;
                    next_q          <= (next_q == LAST[MOTOR_W-1:0]) ? {MOTOR_W{1'b0}} : next_q + 1'b1;
                end
            end
        end
    endgenerate

    // ---- Counts, each in the first of two clocks: the angle of its edge, and of what comes behind it.

    reg         [32*MOTORS-1:0] angles_q;  // in the middle of the position that comes
    reg         [31:0]          edge_q;    // the edge's, then a quarter of a turn more
    wire signed [COUNT_W-1:0]   ahead;     // position that is passed, soon
    wire        [MOTOR_W-1:0]   angle_motor = takes ? due_motor_q : turn_motor_i;
    reg  signed [COUNT_W-1:0]   position;
    reg         [31:0]          count_angle;
    reg         [31:0]          angle;
    integer                     k;

    always @* begin
        position    = $signed(position_i[COUNT_W-1:0]);
        count_angle = count_angle_i[31:0];
        angle       = angles_q[31:0];
        for (k = 1; k < MOTORS; k = k + 1) begin
            if (motor == k[MOTOR_W-1:0]) begin
                position    = $signed(position_i[k*COUNT_W +: COUNT_W]);
                count_angle = count_angle_i[32*k +: 32];
            end
            if (angle_motor == k[MOTOR_W-1:0]) begin
                angle = angles_q[32*k +: 32];
            end
        end
    end

    // Whether there is one, and which way, is of the clock before: of the second, after one.
    wire signed [COUNT_W-1:0] left = position - ahead;

    assign turned_o        = turn_i && !takes && !load && !rst;
    assign angle_o         = angles_q;
    assign load_o          = load;
    assign load_motor_o    = next_q;
    assign load_position_o = position;

    wh_port_state #(
        .N           (MOTORS),
        .W           (COUNT_W)
    ) aheads (
        .clk         (clk),
        .rst         (1'b0),
        .port_i      (motor),
        .save_i      (load || takes),
        .save_port_i (motor),
        .value_i     (load ? position : back_q ? ahead - 1'b1 : ahead + 1'b1),
        .value_o     (ahead)
    );

    // Half of a count's angle, the larger one up: so both ways pass the same edge.
    wire [31:0] less = ~{1'b0, count_angle[31:1]} + 32'd1;
    wire [31:0] more = {1'b0, count_angle[31:1]} + {31'd0, count_angle[0]};

    always @(posedge clk) begin
        due_q    <= (left != {COUNT_W{1'b0}}) && !load && !rst;
        back_q   <= left[COUNT_W-1];
        second_q <= takes && !rst;
        edge_q   <= second_q ? {edge_q[31:30] + 2'd1, edge_q[29:0]} : angle + (back_q ? less : more);
    end

    genvar n;
    generate
        for (n = 0; n < MOTORS; n = n + 1) begin : of_motor
            always @(posedge clk) begin
                if (load && (MOTORS == 1 || next_q == n[MOTOR_W-1:0])) begin
                    angles_q[32*n +: 32] <= zero_angle_i[32*n +: 32];
                end else if ((takes || turned_o) && (MOTORS == 1 || angle_motor == n[MOTOR_W-1:0])) begin
                    angles_q[32*n +: 32] <= !takes ? angle + by_i : back_q ? angle - count_angle : angle + count_angle;
                end
            end
        end
    endgenerate

    // ---- The sine of that angle; the first is alpha's, -sin θ, the other one beta's.

    reg  [SINE_W-1:0] sine_q;
    reg               negative_q;
    reg  signed [CELL_W-1:0] word_q;  // with its sign; a register of its own, as a memory is slow
    reg               looks_q;   // sine_q is alpha's, in the next clock beta's
    reg               keeps_q;   // word_q is alpha's
    reg               adds_q;    // it is beta's
    reg               way_q;     // of the newest count, down
    reg               down_q;    // of the one whose words come
    reg  [MOTOR_W-1:0] newest_q; // motor of the newest count
    reg  [MOTOR_W-1:0] sum_q;    // of the one whose words come
    reg  signed [CELL_W-1:0] cell_a_q;

    wire        [7:0]        entry = edge_q[29:22] ^ {8{edge_q[30]}};
    wire signed [CELL_W-1:0] wide  = $signed({1'b0, sine_q});
    wire signed [CELL_W-1:0] sine  = negative_q ? -wide : wide;

    always @(posedge clk) begin
        sine_q     <= sines[entry];
        negative_q <= edge_q[31];
        word_q     <= sine;
        looks_q    <= second_q && !rst;
        keeps_q    <= looks_q && !rst;
        adds_q     <= keeps_q && !rst;
        if (takes) begin
            way_q    <= back_q;
            newest_q <= due_motor_q;
        end
        if (looks_q) begin
            down_q <= way_q;
            sum_q  <= newest_q;
        end
        if (keeps_q) begin
            cell_a_q <= -word_q;
        end
    end

    // ---- The sums: flux and position, which are read to be added to and to be shown.

    wire signed [FLUX_W-1:0]  place_a, place_b;
    wire signed [COUNT_W-1:0] passed;

    wire signed [FLUX_W-1:0] by_a = $signed({{(FLUX_W - CELL_W){cell_a_q[CELL_W-1]}}, cell_a_q});
    wire signed [FLUX_W-1:0] by_b = $signed({{(FLUX_W - CELL_W){word_q[CELL_W-1]}}, word_q});
    wire signed [FLUX_W-1:0] next_a = down_q ? place_a - by_a : place_a + by_a;
    wire signed [FLUX_W-1:0] next_b = down_q ? place_b - by_b : place_b + by_b;
    wire signed [COUNT_W-1:0] follows = down_q ? passed - 1'b1 : passed + 1'b1;
    wire [SUMS_W-1:0] sums = load ? {{2*FLUX_W{1'b0}}, position} : {next_b, next_a, follows};
    wire              saves = load || adds_q;
    wire [MOTOR_W-1:0] saved_motor = load ? next_q : sum_q;

    wh_port_state #(
        .N           (MOTORS),
        .W           (SUMS_W)
    ) sum_state (
        .clk         (clk),
        .rst         (1'b0),
        .port_i      (sum_q),
        .save_i      (saves),
        .save_port_i (saved_motor),
        .value_i     (sums),
        .value_o     ({place_b, place_a, passed})
    );

    wh_port_state #(
        .N           (MOTORS),
        .W           (2 * CELL_W + SUMS_W)
    ) shown_state (
        .clk         (clk),
        .rst         (1'b0),
        .port_i      (motor_i),
        .save_i      (saves),
        .save_port_i (saved_motor),
        .value_i     ({load ? {2*CELL_W{1'b0}} : {word_q, cell_a_q}, sums}),
        .value_o     ({cell_o, place_o, position_o})
    );

endmodule

`default_nettype wire
