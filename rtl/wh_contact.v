// SPDX-License-Identifier: Apache-2.0
//
// wh_contact: says which wall the rotor is in, how deep, and which eta that makes.
//
//   in wall n:  wall_min[n] <= position < wall_max[n], enabled; the first such wall wins
//   depth     = position - x_w,  x_w the edge through which the rotor came in
//   eta       = eta_contact in a wall, eta_free outside
//
// With hysteresis_i a wall that has been entered is not left in the first count outside, only in the
// next, unless another wall holds the position: a finger that rests on the edge does not chatter.
//
// A rotor that is found inside a wall came in through the nearer edge, through wall_min if both are
// as near; the edge stays until the rotor leaves the wall. An edge may be moved under a rotor in
// contact, and x_w moves with it.
// The walls are looked at in turn, one a clock, all of a round at one position, so that one pair of
// subtractors serves every wall. The rounds go on while hold_i keeps the outputs as they are; each
// clock without it shows what the newest round has found, whenever that ended.
// Formats: s32, counts; depth saturates. Latency: WALLS + 2 clocks from the position that a round
// is made for, then the first clock without hold_i; a round begins every WALLS clocks.
// Walls that change together do so with the end of a clock in which round_o is low, or a round mixes
// old ones and new ones.
// Reset: free space.

`default_nettype none
`include "wh_formats.vh"

module wh_contact #(
    parameter integer WALLS  = 4,                               // 1...16
    parameter integer WALL_W = (WALLS < 2) ? 1 : $clog2(WALLS)  // derived, leave it
) (
    input  wire                          clk,
    input  wire                          rst,

    input  wire signed [`WH_COUNT_W-1:0] position_i,     // s32, counts
    input  wire                          hold_i,         // the outputs stay as they are

    input  wire [WALLS*`WH_COUNT_W-1:0]  wall_min_i,     // s32 each, counts; wall 0 lowest
    input  wire [WALLS*`WH_COUNT_W-1:0]  wall_max_i,     // s32 each, counts
    input  wire [WALLS-1:0]              wall_enable_i,
    input  wire [WALLS-1:0]              wall_shaped_i,  // handed on with the wall in contact
    input  wire                          hysteresis_i,
    input  wire signed [`WH_COEF_W-1:0]  eta_contact_i,  // s27q25, +-2, used in [-1, 1]
    input  wire signed [`WH_COEF_W-1:0]  eta_free_i,     // s27q25, +-2, used in [-1, 1]

    output wire                          round_o,        // walls are being read: what of them changes
                                                         // with the end of a clock without it is in
                                                         // force for whole rounds
    output reg                           contact_o,
    output reg  [WALL_W-1:0]             wall_o,         // wall in contact, else holds the last one
    output reg                           shaped_o,       // wall_shaped_i of it
    output reg  signed [`WH_COUNT_W-1:0] depth_o,        // s32, counts, position - x_w, 0 when free
    output reg  signed [`WH_COEF_W-1:0]  eta_o           // s27q25
);

    generate
        if (WALLS < 1 || WALLS > 16 || WALL_W != ((WALLS < 2) ? 1 : $clog2(WALLS))) begin : illegal
            wh_illegal_parameter_contact_walls_must_be_1_to_16 stop ();
        end
    endgenerate

    localparam integer        DISTANCE_W = `WH_COUNT_W + 1;
    localparam [WALL_W-1:0]   LAST_WALL  = WALLS[WALL_W-1:0] - {{WALL_W-1{1'b0}}, 1'b1};

    // First stage: a wall's edges.
    reg        [WALL_W-1:0]      select_q;
    reg        [WALL_W-1:0]      edges_wall_q;
    reg                          edges_valid_q;
    reg                          edges_enable_q;
    reg                          edges_shaped_q;
    reg signed [`WH_COUNT_W-1:0] min_q;
    reg signed [`WH_COUNT_W-1:0] max_q;
    reg signed [`WH_COUNT_W-1:0] position_q;  // of the round

    assign round_o = !rst && (select_q != LAST_WALL);

    always @(posedge clk) begin
        min_q          <= $signed(wall_min_i[select_q*`WH_COUNT_W +: `WH_COUNT_W]);
        max_q          <= $signed(wall_max_i[select_q*`WH_COUNT_W +: `WH_COUNT_W]);
        edges_enable_q <= wall_enable_i[select_q];
        edges_shaped_q <= wall_shaped_i[select_q];
        edges_wall_q   <= select_q;
        if (select_q == {WALL_W{1'b0}}) begin
            position_q <= position_i;
        end
        if (rst) begin
            select_q      <= {WALL_W{1'b0}};
            edges_valid_q <= 1'b0;
        end else begin
            select_q      <= (select_q == LAST_WALL) ? {WALL_W{1'b0}}
                                                     : select_q + {{WALL_W-1{1'b0}}, 1'b1};
            edges_valid_q <= 1'b1;
        end
    end

    // Second stage: distances from the edges, positive inside. One bit more than a count: no wrap.
    reg        [WALL_W-1:0]     wall_q;
    reg                         valid_q;
    reg                         enable_q;
    reg                         shaped_q;
    reg signed [DISTANCE_W-1:0] from_min_q;
    reg signed [DISTANCE_W-1:0] from_max_q;

    always @(posedge clk) begin
        wall_q     <= edges_wall_q;
        enable_q   <= edges_enable_q;
        shaped_q   <= edges_shaped_q;
        from_min_q <= {position_q[`WH_COUNT_W-1], position_q} - {min_q[`WH_COUNT_W-1], min_q};
        from_max_q <= {max_q[`WH_COUNT_W-1], max_q} - {position_q[`WH_COUNT_W-1], position_q};
        valid_q    <= edges_valid_q && !rst;
    end

    // Third stage: the first wall of the round that holds the position.
    reg                          found_q;       // in an earlier wall of this round
    reg         [WALL_W-1:0]     found_wall_q;
    reg                          found_side_q;  // 1: came in through wall_max
    reg                          found_shaped_q;
    reg signed  [DISTANCE_W-1:0] found_depth_q;

    // What the newest round that has ended found.
    reg                          contact_q;
    reg         [WALL_W-1:0]     in_wall_q;
    reg                          in_shaped_q;
    reg                          side_q;
    reg  signed [`WH_COUNT_W-1:0] depth_q;

    wire first   = (wall_q == {WALL_W{1'b0}});
    wire last    = (wall_q == LAST_WALL);
    wire earlier = found_q && !first;
    wire holds   = enable_q && !from_min_q[DISTANCE_W-1] && !from_max_q[DISTANCE_W-1]
                   && (from_max_q != {DISTANCE_W{1'b0}});
    wire stays   = contact_q && (in_wall_q == wall_q);

    wire                         side  = stays ? side_q : (from_min_q > from_max_q);
    wire signed [DISTANCE_W-1:0] depth = side ? -from_max_q : from_min_q;

    // One count outside the wall that has been entered: kept if no wall holds the position.
    reg                          linger_q;      // an earlier wall of this round would be kept
    reg  signed [DISTANCE_W-1:0] linger_depth_q;
    reg                          linger_shaped_q;

    wire lingers_here  = hysteresis_i && stays && enable_q
                         && ((from_min_q == {DISTANCE_W{1'b1}})
                             || (from_max_q == {DISTANCE_W{1'b0}}));
    wire lingered      = linger_q && !first;
    wire lingers       = lingered || lingers_here;
    wire signed [DISTANCE_W-1:0] linger_depth = lingered ? linger_depth_q : depth;

    wire                         linger_shaped = lingered ? linger_shaped_q : shaped_q;

    wire                         now        = earlier || holds;
    wire                         now_shaped = earlier ? found_shaped_q : shaped_q;
    wire        [WALL_W-1:0]     now_wall   = earlier ? found_wall_q : wall_q;
    wire                         now_side   = earlier ? found_side_q : side;
    wire signed [DISTANCE_W-1:0] now_depth  = earlier ? found_depth_q : depth;

    wire signed [`WH_COUNT_W-1:0] depth_word;

    wh_saturate #(
        .IN_W    (DISTANCE_W),
        .OUT_W   (`WH_COUNT_W)
    ) saturate (
        .value_i (now ? now_depth : linger_depth),
        .value_o (depth_word)
    );

    wire                          ends         = valid_q && last;
    wire                          next_contact = ends ? (now || lingers) : contact_q;
    wire        [WALL_W-1:0]      next_wall    = (ends && now) ? now_wall : in_wall_q;
    wire                          next_shaped  = !ends ? in_shaped_q
                                               : now   ? now_shaped : linger_shaped;
    wire signed [`WH_COUNT_W-1:0] next_depth   = !ends            ? depth_q
                                               : (now || lingers) ? depth_word
                                                                  : {`WH_COUNT_W{1'b0}};

    always @(posedge clk) begin
        found_wall_q    <= now_wall;
        found_side_q    <= now_side;
        found_shaped_q  <= now_shaped;
        found_depth_q   <= now_depth;
        found_q         <= now && valid_q;
        linger_q        <= lingers && valid_q;
        linger_depth_q  <= linger_depth;
        linger_shaped_q <= linger_shaped;
        in_shaped_q     <= next_shaped;
        if (rst) begin
            contact_q <= 1'b0;
            in_wall_q <= {WALL_W{1'b0}};
            side_q    <= 1'b0;
            depth_q   <= {`WH_COUNT_W{1'b0}};
        end else begin
            contact_q <= next_contact;
            in_wall_q <= next_wall;
            depth_q   <= next_depth;
            if (ends && now) begin
                side_q <= now_side;
            end
        end
    end

    // ---- What of it is shown.
    always @(posedge clk) begin
        if (rst) begin
            contact_o <= 1'b0;
            wall_o    <= {WALL_W{1'b0}};
            shaped_o  <= 1'b0;
            depth_o   <= {`WH_COUNT_W{1'b0}};
            eta_o     <= eta_free_i;
        end else if (!hold_i) begin
            contact_o <= next_contact;
            wall_o    <= next_wall;
            shaped_o  <= next_shaped;
            depth_o   <= next_depth;
            eta_o     <= next_contact ? eta_contact_i : eta_free_i;
        end
    end

endmodule

`default_nettype wire
