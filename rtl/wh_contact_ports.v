// SPDX-License-Identifier: Apache-2.0
//
// wh_contact_ports: position and contact of N ports, which take turns.
//
//   position += change of its encoder's count since its last turn
//   in wall n:  wall_min[n] <= position < wall_max[n], enabled; the first such wall wins
//
// For each port it computes what wh_contact does; that header has the side of entry and the hysteresis. In a turn all
// walls are compared with one position.
//
// The turn, in clocks since valid_i: 1, the position is valid; 2 ... WALLS + 1, the walls are read, one a clock;
// WALLS + 4, contact_o and shaped_o are valid, and a clock later eta_o. They hold until the next turn's.
// The next valid_i may come WALLS + 5 clocks after this one. count_i is taken with valid_i.
//
// State, by port, in LUT RAM (wh_port_state): position, contact, wall and side. Settings: edges and flags of the
// walls, hysteresis, two η (wh_port_settings).
// Latency: above. Reset: position 0 and free space, as the encoders' own counts.

`default_nettype none
`include "wh_formats.vh"

module wh_contact_ports #(
    parameter integer N      = 1,                                // ports, 1...8
    parameter integer WALLS  = 4,                                // of each, 1...16
    parameter integer PORT_W = (N > 1) ? $clog2(N) : 1,          // these two are derived, leave them
    parameter integer WALL_W = (WALLS < 2) ? 1 : $clog2(WALLS)
) (
    input  wire                          clk,
    input  wire                          rst,

    // A turn.
    input  wire                          valid_i,       // strobe
    input  wire [PORT_W-1:0]             port_i,
    input  wire                          bank_i,
    input  wire [N*`WH_MOVE_W-1:0]       count_i,       // counts, modulo 2^12

    // The register bus (wh_port_settings).
    input  wire                          write_i,
    input  wire                          write_bank_i,
    input  wire [11:0]                   address_i,
    input  wire [31:0]                   data_i,

    output wire signed [`WH_COUNT_W-1:0] position_o,    // s32, counts
    output wire                          contact_o,
    output wire                          shaped_o,      // wall_shaped of the wall in contact
    output wire signed [`WH_COEF_W-1:0]  eta_o          // s27q25
);

    localparam integer COUNT_W    = `WH_COUNT_W;
    localparam integer MOVE_W     = `WH_MOVE_W;
    localparam integer DISTANCE_W = COUNT_W + 1;
    localparam integer READ_W     = (WALLS < 2) ? 0 : $clog2(WALLS);

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_contact_ports_n_must_be_1_to_8 stop ();
        end
        if (WALLS < 1 || WALLS > 16) begin : illegal_walls
            wh_illegal_parameter_contact_ports_walls_must_be_1_to_16 stop ();
        end
    endgenerate

    // ---- The turn: at_q[n] is clock n of it.
    localparam integer READ  = 1;              // the first wall is read
    localparam integer JUDGE = READ + 2;       // its distances are valid
    localparam integer ENDS  = JUDGE + WALLS;  // all walls are judged

    reg [ENDS+1:1]    at_q;
    reg [PORT_W-1:0]  port_q;
    reg               bank_q;
    reg [MOVE_W-1:0]  count_q;

    always @(posedge clk) begin
        if (valid_i) begin
            port_q  <= port_i;
            bank_q  <= bank_i;
            count_q <= count_i[port_i*MOVE_W +: MOVE_W];
        end
        at_q <= rst ? {(ENDS + 1){1'b0}} : {at_q[ENDS:1], valid_i};
    end

    // ---- Position.
    wire signed [COUNT_W-1:0] position;
    wire        [MOVE_W-1:0]  way = count_q - position[MOVE_W-1:0];

    wh_port_state #(
        .N           (N),
        .W           (COUNT_W)
    ) position_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_q),
        .save_i      (at_q[1]),
        .save_port_i (port_q),
        .value_i     (position + $signed({{(COUNT_W - MOVE_W){way[MOVE_W-1]}}, way})),
        .value_o     (position)
    );

    assign position_o = position;

    // ---- The walls' settings. Each is read while the one before is subtracted.
    reg  [WALL_W-1:0]         read_wall_q;
    reg  [WALL_W-1:0]         edges_wall_q;
    reg  [WALL_W-1:0]         wall_q;
    wire                      reads = |at_q[READ+WALLS-1:READ];
    wire signed [COUNT_W-1:0] min;
    wire signed [COUNT_W-1:0] max;
    wire                      enable;
    wire                      shaped;
    wire                      hysteresis;

    always @(posedge clk) begin
        read_wall_q  <= valid_i ? {WALL_W{1'b0}} : read_wall_q + 1'b1;
        edges_wall_q <= read_wall_q;
        wall_q       <= edges_wall_q;
    end

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (READ_W),
        .W            (COUNT_W),
        .FIRST        (64)
    ) mins (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (reads),
        .bank_i       (bank_q),
        .port_i       (port_q),
        .word_i       (read_wall_q),
        .word_o       (min)
    );

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (READ_W),
        .W            (COUNT_W),
        .FIRST        (80)
    ) maxs (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (reads),
        .bank_i       (bank_q),
        .port_i       (port_q),
        .word_i       (read_wall_q),
        .word_o       (max)
    );

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (READ_W),
        .W            (1),
        .FIRST        (96),
        .BLOCK        (0)
    ) enables (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (reads),
        .bank_i       (bank_q),
        .port_i       (port_q),
        .word_i       (read_wall_q),
        .word_o       (enable)
    );

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (READ_W),
        .W            (1),
        .FIRST        (112),
        .BLOCK        (0)
    ) shapes (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (reads),
        .bank_i       (bank_q),
        .port_i       (port_q),
        .word_i       (read_wall_q),
        .word_o       (shaped)
    );

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (0),
        .W            (1),
        .FIRST        (48),
        .BLOCK        (0)
    ) hystereses (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (at_q[1]),
        .bank_i       (bank_q),
        .port_i       (port_q),
        .word_i       (1'b0),
        .word_o       (hysteresis)
    );

    // ---- Distances from the edges, positive inside. One bit more than a position: no wrap.
    reg signed [DISTANCE_W-1:0] from_min_q;
    reg signed [DISTANCE_W-1:0] from_max_q;
    reg                         enable_q;
    reg                         shaped_q;

    always @(posedge clk) begin
        from_min_q <= {position[COUNT_W-1], position} - {min[COUNT_W-1], min};
        from_max_q <= {max[COUNT_W-1], max} - {position[COUNT_W-1], position};
        enable_q   <= enable;
        shaped_q   <= shaped;
    end

    // ---- The first wall that contains the position, else the wall in contact if it was left by a count at most.
    wire              contact_before;
    wire              side_before;      // 1: the rotor came in through wall_max
    wire [WALL_W-1:0] wall_before;
    reg               found_q;
    reg               linger_q;
    reg  [WALL_W-1:0] found_wall_q;
    reg               found_side_q;
    reg               found_shaped_q;   // of the wall that contains the position,
    reg               linger_shaped_q;  // or that is being left

    wire judges  = |at_q[JUDGE+WALLS-1:JUDGE];
    wire holds   = enable_q && !from_min_q[DISTANCE_W-1] && !from_max_q[DISTANCE_W-1]
                   && (from_max_q != {DISTANCE_W{1'b0}});
    wire stays   = contact_before && (wall_before == wall_q);
    wire side    = stays ? side_before : (from_min_q > from_max_q);
    wire lingers = hysteresis && stays && enable_q
                   && ((from_min_q == {DISTANCE_W{1'b1}}) || (from_max_q == {DISTANCE_W{1'b0}}));

    always @(posedge clk) begin
        if (at_q[1]) begin
            found_q        <= 1'b0;
            linger_q       <= 1'b0;
            found_wall_q   <= wall_before;
            found_side_q   <= side_before;
        end else if (judges) begin
            found_q  <= found_q || holds;
            linger_q <= linger_q || lingers;
            if (holds && !found_q) begin
                found_wall_q   <= wall_q;
                found_side_q   <= side;
                found_shaped_q <= shaped_q;
            end
            if (lingers && !linger_q) begin
                linger_shaped_q <= shaped_q;
            end
        end
    end

    reg contact_q;
    reg shape_q;

    always @(posedge clk) begin
        if (rst) begin
            contact_q <= 1'b0;
            shape_q   <= 1'b0;
        end else if (at_q[ENDS]) begin
            contact_q <= found_q || linger_q;
            shape_q   <= found_q ? found_shaped_q : linger_q && linger_shaped_q;
        end
    end

    assign contact_o = contact_q;
    assign shaped_o  = shape_q;

    wh_port_state #(
        .N           (N),
        .W           (WALL_W + 2)
    ) contact_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_q),
        .save_i      (at_q[ENDS]),
        .save_port_i (port_q),
        .value_i     ({found_q || linger_q, found_side_q, found_wall_q}),
        .value_o     ({contact_before, side_before, wall_before})
    );

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (1),
        .W            (`WH_COEF_W),
        .FIRST        (8),
        .BLOCK        (0)
    ) etas (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (at_q[ENDS+1]),
        .bank_i       (bank_q),
        .port_i       (port_q),
        .word_i       (!contact_q),
        .word_o       (eta_o)
    );

endmodule

`default_nettype wire
