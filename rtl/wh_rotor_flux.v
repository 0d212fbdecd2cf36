// SPDX-License-Identifier: Apache-2.0
//
// wh_rotor_flux: what the encoder's counts do to the flux that a brushless motor's magnets have in the
// axes alpha and beta, in cells of the encoder. It stands between wh_quadrature and all that looks at the
// position, which comes out of it with the flux that belongs to it.
//
//   a count up passes an edge at the electrical angle θ, and changes the flux by q = (-sin θ, cos θ);
//   a count down takes the same words off again, unless the angle was turned (wh_magnet_angle) in between
//
// sim/wavehaptics/controller/rotor_flux.py says the same with integers, and this module equals it bit for
// bit, count for count. A quarter of a sine, 256 words from wh_sine.vh, is looked up for the one axis and
// then for the other.
//
// Formats: angles are words of 2^32 to the turn.
// Latency: 6 clocks from position_i to position_o, which follows by a count in two clocks at most.
// Reset: position_o is position_i, whose middle is at zero_angle_i; no flux.

`default_nettype none
`include "wh_formats.vh"

module wh_rotor_flux (
    input  wire                                   clk,
    input  wire                                   rst,

    input  wire signed [`WH_COUNT_W-1:0]          position_i,     // s32, counts
    input  wire [31:0]                            count_angle_i,  // by which a count turns the magnets
    input  wire [31:0]                            zero_angle_i,
    input  wire                                   turn_i,         // the angle is to be turned...
    input  wire [31:0]                            by_i,           // ... by this
    output wire                                   turned_o,       // it is, in this clock
    output wire [31:0]                            angle_o,        // of the position that comes, in its middle

    output reg  signed [`WH_COUNT_W-1:0]          position_o,     // s32, counts
    // Alpha lowest.
    output wire [2*(`WH_PLACE_W+`WH_SINE_Q)-1:0]  place_o,        // s30q15 cells, modulo 2^15: all counts
    output wire [2*(`WH_SINE_Q+2)-1:0]            cell_o          // s17q15 cells: q of the last one
);

    localparam integer COUNT_W = `WH_COUNT_W;
    localparam integer SINE_W  = `WH_SINE_Q + 1;
    localparam integer CELL_W  = `WH_SINE_Q + 2;
    localparam integer FLUX_W  = `WH_PLACE_W + `WH_SINE_Q;

    // ---- A quarter of a sine, at the middles of its entries' parts.

    (* rom_style = "block" *) reg [SINE_W-1:0] sines [0:255];

    initial begin
`define WH_SINE(INDEX, WORD) sines[INDEX] = WORD;
`include "wh_sine.vh"
`undef WH_SINE
    end

    // ---- Counts, each in the first of two clocks: the angle of its edge, and of what comes behind it.

    reg  signed [COUNT_W-1:0] ahead_q;   // position that is passed, soon
    reg  [31:0]               angle_q;   // in its middle
    reg  [31:0]               edge_q;    // the edge's, then a quarter of a turn more
    reg                       second_q;  // the second clock

    // Whether there is one, and which way, is of the clock before: of the second, after one.
    reg                       due_q;
    reg                       back_q;

    wire signed [COUNT_W-1:0] left  = position_i - ahead_q;
    wire                      takes = !second_q && due_q;

    assign turned_o = turn_i && !takes && !rst;
    assign angle_o  = angle_q;

    // Half of a count's angle, the larger one up: so both ways pass the same edge.
    wire [31:0] less = ~{1'b0, count_angle_i[31:1]} + 32'd1;
    wire [31:0] more = {1'b0, count_angle_i[31:1]} + {31'd0, count_angle_i[0]};

    always @(posedge clk) begin
        due_q  <= (left != {COUNT_W{1'b0}}) && !rst;
        back_q <= left[COUNT_W-1];
        if (rst) begin
            ahead_q  <= position_i;
            angle_q  <= zero_angle_i;
            second_q <= 1'b0;
        end else begin
            second_q <= takes;
            if (takes) begin
                ahead_q <= back_q ? ahead_q - 1'b1 : ahead_q + 1'b1;
                angle_q <= back_q ? angle_q - count_angle_i : angle_q + count_angle_i;
            end else if (turn_i) begin
                angle_q <= angle_q + by_i;
            end
        end
        edge_q <= second_q ? {edge_q[31:30] + 2'd1, edge_q[29:0]} : angle_q + (back_q ? less : more);
    end

    // ---- The sine of that angle; the first is alpha's, -sin θ, the other one beta's.

    reg  [SINE_W-1:0] sine_q;
    reg               negative_q;
    reg  signed [CELL_W-1:0] word_q;  // with its sign; a register of its own, as a memory is slow
    reg               looks_q;   // sine_q is alpha's, in the next clock beta's
    reg               keeps_q;   // word_q is alpha's
    reg               adds_q;    // it is beta's
    reg               way_q;     // of the newest count, down
    reg               down_q;    // of the one whose words come
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
        way_q      <= takes ? back_q : way_q;
        down_q     <= looks_q ? way_q : down_q;
        if (keeps_q) begin
            cell_a_q <= -word_q;
        end
    end

    // ---- The sums.

    reg signed [FLUX_W-1:0] place_a_q;
    reg signed [FLUX_W-1:0] place_b_q;
    reg signed [CELL_W-1:0] shown_a_q;
    reg signed [CELL_W-1:0] shown_b_q;

    wire signed [FLUX_W-1:0] by_a = $signed({{(FLUX_W - CELL_W){cell_a_q[CELL_W-1]}}, cell_a_q});
    wire signed [FLUX_W-1:0] by_b = $signed({{(FLUX_W - CELL_W){word_q[CELL_W-1]}}, word_q});

    assign place_o = {place_b_q, place_a_q};
    assign cell_o  = {shown_b_q, shown_a_q};

    always @(posedge clk) begin
        if (rst) begin
            position_o <= position_i;
            place_a_q  <= {FLUX_W{1'b0}};
            place_b_q  <= {FLUX_W{1'b0}};
            shown_a_q  <= {CELL_W{1'b0}};
            shown_b_q  <= {CELL_W{1'b0}};
        end else if (adds_q) begin
            position_o <= down_q ? position_o - 1'b1 : position_o + 1'b1;
            place_a_q  <= down_q ? place_a_q - by_a : place_a_q + by_a;
            place_b_q  <= down_q ? place_b_q - by_b : place_b_q + by_b;
            shown_a_q  <= cell_a_q;
            shown_b_q  <= word_q;
        end
    end

endmodule

`default_nettype wire
