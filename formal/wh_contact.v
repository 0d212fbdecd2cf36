// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_contact: a rotor at rest in an enabled wall is in contact at the first clock without
// hold_i behind two rounds of the walls, and from then on; one at rest outside all walls is free (two
// counts outside, with hysteresis). While hold_i is high nothing that is shown changes. η and
// shaped_o belong to what is shown. For all walls and positions, and whatever hold_i does.
//
// The rest is counted from a clock in which the position may have been any other.
// Proven by induction, smtbmc z3 at depth 2 (one wall; more take z3 long).

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
    (* anyconst *) wire [WALLS-1:0]             shaped;
    (* anyconst *) wire                         hysteresis;
    (* anyconst *) wire [`WH_COEF_W-1:0]        eta_contact;
    (* anyconst *) wire [`WH_COEF_W-1:0]        eta_free;

    wire                          round;
    wire                          contact;
    wire                          wall_shaped;
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
        .wall_shaped_i (shaped),
        .hysteresis_i  (hysteresis),
        .eta_contact_i (eta_contact),
        .eta_free_i    (eta_free),
        .round_o       (round),
        .contact_o     (contact),
        .wall_o        (wall),
        .shaped_o      (wall_shaped),
        .depth_o       (depth),
        .eta_o         (eta)
    );

    (* hierconn *) wire        [WALL_W-1:0]      \block.select_q ;
    (* hierconn *) wire        [WALL_W-1:0]      \block.edges_wall_q ;
    (* hierconn *) wire                          \block.edges_valid_q ;
    (* hierconn *) wire                          \block.edges_enable_q ;
    (* hierconn *) wire                          \block.linger_shaped_q ;
    (* hierconn *) wire                          \block.found_shaped_q ;
    (* hierconn *) wire                          \block.in_shaped_q ;
    (* hierconn *) wire                          \block.shaped_q ;
    (* hierconn *) wire                          \block.edges_shaped_q ;
    (* hierconn *) wire signed [`WH_COUNT_W-1:0] \block.min_q ;
    (* hierconn *) wire signed [`WH_COUNT_W-1:0] \block.max_q ;
    (* hierconn *) wire signed [`WH_COUNT_W-1:0] \block.position_q ;
    (* hierconn *) wire        [WALL_W-1:0]      \block.wall_q ;
    (* hierconn *) wire                          \block.valid_q ;
    (* hierconn *) wire                          \block.enable_q ;
    (* hierconn *) wire signed [`WH_COUNT_W:0]   \block.from_min_q ;
    (* hierconn *) wire signed [`WH_COUNT_W:0]   \block.from_max_q ;
    (* hierconn *) wire                          \block.found_q ;
    (* hierconn *) wire        [WALL_W-1:0]      \block.found_wall_q ;
    (* hierconn *) wire                          \block.linger_q ;
    (* hierconn *) wire                          \block.contact_q ;
    (* hierconn *) wire        [WALL_W-1:0]      \block.in_wall_q ;
    (* hierconn *) wire signed [`WH_COUNT_W-1:0] \block.depth_q ;

    wire [WALL_W-1:0] select     = \block.select_q ;
    wire [WALL_W-1:0] edges_wall = \block.edges_wall_q ;
    wire [WALL_W-1:0] at         = \block.wall_q ;
    wire              edges      = \block.edges_valid_q ;
    wire              valid      = \block.valid_q ;

    // Of the walls: one that holds the position, and whether it is within a count of any.
    reg inside;
    reg near;
    reg signed [`WH_COUNT_W:0] from_low;
    reg signed [`WH_COUNT_W:0] from_high;
    reg [WALL_W-1:0] first;
    reg [WALLS-1:0]  holds;
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
            holds[n] = enable[n] && from_low >= 0 && from_high > 0;
            if (holds[n]) begin
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
    wire [3:0] rest  = rests ? rest_q : 4'd0;
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
            if (contact) assert (wall_shaped == shaped[wall]);
            if (shown) begin
                if (inside) assert (contact && wall == first);
                if (!inside && !(hysteresis && near)) assert (!contact && depth == 0);
            end

            // What makes that inductive: the stages of the round, and of the position that it is made
            // for only what has been at rest for as long as the stage is behind.
            assert (rest_q <= ROUNDS && (!shown_q || rest_q == ROUNDS));
            assert (select < WALLS && (!edges || edges_wall < WALLS) && (!valid || at < WALLS));
            assert (edges == !rst_q && (edges || select == 0));
            assert (edges || !valid);
            if (edges) assert (select == ((edges_wall == WALLS - 1) ? 0 : edges_wall + 1));
            if (valid) assert (edges_wall == ((at == WALLS - 1) ? 0 : at + 1));
            if (edges && !valid) assert (rest <= 1 && edges_wall == 0);
            if (edges) assert (\block.edges_shaped_q == shaped[edges_wall]);
            if (valid) assert (\block.shaped_q == shaped[at]);
            if (\block.contact_q ) assert (\block.in_shaped_q == shaped[\block.in_wall_q ]);
            if (\block.found_q && valid && at != 0) begin
                assert (\block.found_shaped_q == shaped[\block.found_wall_q ]);
            end
            if (\block.linger_q && valid && at != 0) begin
                assert (\block.linger_shaped_q == shaped[\block.in_wall_q ]);
            end
            if (edges) begin
                assert (\block.min_q == $signed(low[edges_wall*`WH_COUNT_W +: `WH_COUNT_W]));
                assert (\block.max_q == $signed(high[edges_wall*`WH_COUNT_W +: `WH_COUNT_W]));
                assert (\block.edges_enable_q == enable[edges_wall]);
                if (rest > edges_wall) assert (\block.position_q == position);
            end
            if (valid) begin
                assert (\block.enable_q == enable[at]);
                if (rest > at + 4'd1) begin
                    assert (\block.from_min_q == $signed({position[`WH_COUNT_W-1], position})
                            - $signed({low[at*`WH_COUNT_W + `WH_COUNT_W-1],
                                       low[at*`WH_COUNT_W +: `WH_COUNT_W]}));
                    assert (\block.from_max_q == $signed({high[at*`WH_COUNT_W + `WH_COUNT_W-1],
                                                          high[at*`WH_COUNT_W +: `WH_COUNT_W]})
                            - $signed({position[`WH_COUNT_W-1], position}));
                    if (at != 0) begin
                        assert (\block.found_q == (inside && first < at));
                        if (\block.found_q ) assert (\block.found_wall_q == first);
                        if (\block.linger_q ) assert (hysteresis && near);
                    end
                end
                if (rest > WALLS + at + 4'd1) begin
                    if (inside) assert (\block.contact_q && \block.in_wall_q == first);
                    if (!inside && !(hysteresis && near)) begin
                        assert (!\block.contact_q && \block.depth_q == 0);
                    end
                end
            end
        end

        cover (begun && shown && contact && hold && wall == WALLS - 1);
        cover (begun && shown && !contact && rest_q == ROUNDS);
    end

endmodule

`default_nettype wire
