// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_contact: a rotor at rest in an enabled wall is in contact at the first clock without
// hold_i behind two rounds of the walls, and from then on; one at rest outside all walls is free (two
// counts outside, with hysteresis). While hold_i is high nothing that is shown changes. η belongs to
// what is shown. For all walls and positions, and whatever hold_i does.
//
// The rest is counted from a clock in which the position may have been any other. No state but the
// round's is given: what the rotor did before doesn't matter.
// Proven by induction with z3: depth 8 for WALLS = 1, 10 for 2, 12 for 3.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_contact #(
    parameter integer WALLS = 3
) (
    input wire                          clk,
    input wire                          rst,
    input wire                          hold,
    input wire signed [`WH_COUNT_W-1:0] position
);

    localparam integer WALL_W = (WALLS < 2) ? 1 : $clog2(WALLS);
    localparam integer ROUNDS = 2 * WALLS + 1;  // clocks: a round that has begun, and one of its own

    (* anyconst *) wire [WALLS*`WH_COUNT_W-1:0] low;
    (* anyconst *) wire [WALLS*`WH_COUNT_W-1:0] high;
    (* anyconst *) wire [WALLS-1:0]             enable;
    (* anyconst *) wire                         hysteresis;
    (* anyconst *) wire [`WH_COEF_W-1:0]        eta_contact;
    (* anyconst *) wire [`WH_COEF_W-1:0]        eta_free;

    wire                          contact;
    wire        [WALL_W-1:0]      wall;
    wire signed [`WH_COUNT_W-1:0] depth;
    wire        [`WH_COEF_W-1:0]  eta;

    wh_contact #(
        .WALLS         (WALLS)
    ) block (
        .clk           (clk),
        .rst           (rst),
        .position_i    (position),
        .hold_i        (hold),
        .wall_min_i    (low),
        .wall_max_i    (high),
        .wall_enable_i (enable),
        .hysteresis_i  (hysteresis),
        .eta_contact_i (eta_contact),
        .eta_free_i    (eta_free),
        .contact_o     (contact),
        .wall_o        (wall),
        .depth_o       (depth),
        .eta_o         (eta)
    );

    (* hierconn *) wire [WALL_W-1:0] \block.select_q ;
    (* hierconn *) wire [WALL_W-1:0] \block.edges_wall_q ;
    (* hierconn *) wire [WALL_W-1:0] \block.wall_q ;
    (* hierconn *) wire              \block.edges_valid_q ;
    (* hierconn *) wire              \block.valid_q ;

    // Of the walls: one that holds the position, and whether it is within a count of any.
    reg inside;
    reg near;
    reg signed [`WH_COUNT_W:0] from_low;
    reg signed [`WH_COUNT_W:0] from_high;
    reg [WALL_W-1:0] first;
    integer n;

    always @* begin
        inside = 1'b0;
        near   = 1'b0;
        first  = {WALL_W{1'b0}};
        for (n = WALLS - 1; n >= 0; n = n - 1) begin
            // As differences of one bit more, which is what the solver finds in the block.
            from_low  = $signed({position[`WH_COUNT_W-1], position})
                        - $signed({low[n*`WH_COUNT_W + `WH_COUNT_W-1],
                                   low[n*`WH_COUNT_W +: `WH_COUNT_W]});
            from_high = $signed({high[n*`WH_COUNT_W + `WH_COUNT_W-1],
                                 high[n*`WH_COUNT_W +: `WH_COUNT_W]})
                        - $signed({position[`WH_COUNT_W-1], position});
            if (enable[n] && from_low >= 0 && from_high > 0) begin
                inside = 1'b1;
                first  = n[WALL_W-1:0];
            end
            if (enable[n] && (from_low == -1 || from_high == 0)) begin
                near = 1'b1;
            end
        end
    end

    reg                          begun = 1'b0;
    reg                          rst_q, hold_q, contact_q;
    reg        [WALL_W-1:0]      wall_q;
    reg signed [`WH_COUNT_W-1:0] depth_q, position_q;
    reg        [`WH_COEF_W-1:0]  eta_q;
    reg        [3:0]             rest_q;   // clock edges at this position
    reg                          shown_q;  // one without hold has been behind the rounds

    wire       rests = begun && !rst_q && position == position_q;
    wire [3:0] rest  = !rests ? 4'd0 : rest_q;
    wire       shown = rests && shown_q;

    always @(posedge clk) begin
        begun      <= 1'b1;
        rst_q      <= rst;
        hold_q     <= hold;
        contact_q  <= contact;
        wall_q     <= wall;
        depth_q    <= depth;
        eta_q      <= eta;
        position_q <= position;
        rest_q     <= (rest == ROUNDS[3:0]) ? rest : rest + 4'd1;
        shown_q    <= !rst && (shown || (rest >= ROUNDS[3:0] - 4'd1 && !hold));

        if (!begun) begin
            assume (rst);
        end else begin
            if (rst_q) begin
                assert (!contact && eta == eta_free);
            end
            if (!rst_q && hold_q) begin
                assert (contact == contact_q && wall == wall_q && depth == depth_q && eta == eta_q);
            end
            assert (eta == (contact ? eta_contact : eta_free));
            if (shown) begin
                if (inside) assert (contact && wall == first);
                if (!inside && !(hysteresis && near)) assert (!contact && depth == 0);
            end

            // What makes that inductive: the round.
            assert (\block.select_q < WALLS && rest_q <= ROUNDS);
            if (\block.edges_valid_q ) begin
                assert (\block.select_q == ((\block.edges_wall_q == WALLS - 1)
                                            ? 0 : \block.edges_wall_q + 1));
            end
            if (\block.valid_q ) begin
                assert (\block.edges_valid_q
                        || rst_q);
                assert (rst_q || \block.edges_wall_q == ((\block.wall_q == WALLS - 1)
                                                         ? 0 : \block.wall_q + 1));
            end
            if (!rst_q) assert (\block.edges_valid_q );
        end

        cover (begun && shown && contact && hold && wall == WALLS - 1);
        cover (begun && shown && !contact && rest_q == ROUNDS);
    end

endmodule

`default_nettype wire
