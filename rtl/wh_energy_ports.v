// SPDX-License-Identifier: Apache-2.0
//
// wh_energy_ports: observes the energy that contacts of N ports deliver to their shafts. The ports take turns.
//
//   E    += way * i_n   way: counts that the rotor has moved since the turn before, less the first one after a turn
//                       of the rotor; 0 unless that turn was in contact
//   peak  = the largest E of the contact, 0 or more
//   over  = in contact, and peak > limit, in the limit's places
//
// It does for each port what wh_energy does for one, by one product for all counts of a period; what is counted, and
// why, is in that header. A period whose counts would take E beyond its word is left out as a whole, where wh_energy
// leaves out those beyond; with either, the contact is not judged any more.
//
// The turn, in clocks since valid_i: 1, the product of way and current is asked for, and nobody else may ask then;
// 6, energy_o is there, and 7, peak_o; 8, over_o. energy_valid_o and peak_valid_o come in clocks 7 and 8.
// position_i and contact_i are taken with valid_i, port_i and current_i hold to clock 8. The next valid_i may come
// 9 clocks after this one.
// Formats: E and peak s24q10 A·counts, of a current that is cut to as many places downwards.
// State, by port, in LUT RAM (wh_port_state): position and way (13 bits), contact, E (25), peak (23).
// Latency: above. Reset: E, peak and positions 0; no contact, with run_i = 0 too.

`default_nettype none
`include "wh_formats.vh"

module wh_energy_ports #(
    parameter integer N      = 1,                        // ports, 1...8
    parameter integer PORT_W = (N > 1) ? $clog2(N) : 1   // derived, leave it
) (
    input  wire                           clk,
    input  wire                           rst,
    input  wire                           run_i,          // the bridges are on

    // A turn.
    input  wire                           valid_i,        // strobe, while run_i
    input  wire [PORT_W-1:0]              port_i,
    input  wire                           contact_i,
    input  wire [`WH_MOVE_W-1:0]          position_i,     // counts, modulo 2^12
    input  wire signed [`WH_DATA_W-1:0]   current_i,      // s31q24 A: i_n
    input  wire [`WH_ENERGY_LIMIT_W-1:0]  limit_i,        // u16q3 A·counts

    // The multiplier.
    output wire                           request_o,
    output wire signed [`WH_DATA_W-1:0]   factor_o,       // s31q10 A
    output wire signed [`WH_COEF_W-1:0]   coefficient_o,  // s27q0 counts
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i, // 3 clocks after request_o

    output wire                           energy_valid_o, // strobes
    output wire                           peak_valid_o,
    output wire signed [`WH_ENERGY_W-1:0] energy_o,       // s24q10 A·counts
    output wire signed [`WH_ENERGY_W-1:0] peak_o,         // s24q10 A·counts, 0 or more
    output reg  [N-1:0]                   over_o          // until the port's next turn
);

    localparam integer DATA_W   = `WH_DATA_W;
    localparam integer COEF_W   = `WH_COEF_W;
    localparam integer ENERGY_W = `WH_ENERGY_W;
    localparam integer PEAK_W   = ENERGY_W - 1;
    localparam integer LIMIT_W  = `WH_ENERGY_LIMIT_W;
    localparam integer MOVE_W   = `WH_MOVE_W;
    localparam integer CUT      = `WH_CURRENT_Q - `WH_ENERGY_Q;
    localparam integer PART_W   = DATA_W - CUT + MOVE_W;   // of a period's product
    localparam integer SUM_W    = 1 + ((PART_W > ENERGY_W) ? PART_W : ENERGY_W);

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_energy_ports_n_must_be_1_to_8 stop ();
        end
        if (PEAK_W - LIMIT_W != `WH_ENERGY_Q - `WH_ENERGY_LIMIT_Q || COEF_W < MOVE_W) begin : illegal_format
            wh_illegal_WH_ENERGY_LIMIT_W_must_be_the_highest_bits_of_a_peak stop ();
        end
    endgenerate

    // ---- The turn: at_q[n] is clock n of it.
    localparam integer TAKE  = 4;  // the product
    localparam integer SAVE  = TAKE + 1;
    localparam integer PEAK  = SAVE + 1;
    localparam integer JUDGE = PEAK + 1;
    localparam integer ENDS  = JUDGE + 1;

    reg [ENDS:1] at_q;

    always @(posedge clk) begin
        at_q <= (rst || !run_i) ? {ENDS{1'b0}} : {at_q[ENDS-1:1], valid_i};
    end

    assign energy_valid_o = at_q[JUDGE];
    assign peak_valid_o   = at_q[ENDS];

    // ---- The way. Without one, the last count's direction stays.
    wire        [MOVE_W-1:0] position_before;
    wire                     back_before;
    wire                     contact_before;
    wire        [MOVE_W-1:0] way   = position_i - position_before;
    wire                     back  = way[MOVE_W-1];
    wire                     moves = (position_i != position_before);  // beside the difference, not after it
    wire                     turns = moves && (back != back_before);
    wire signed [MOVE_W-1:0] nearer = $signed(way) + $signed({{MOVE_W-1{!back}}, 1'b1});  // by a count to 0
    wire signed [MOVE_W-1:0] counts = turns ? nearer : $signed(way);
    reg  signed [MOVE_W-1:0] counts_q;
    reg                      begins_q;   // a contact

    always @(posedge clk) begin
        if (valid_i) begin
            counts_q <= contact_before ? counts : {MOVE_W{1'b0}};
            begins_q <= contact_i && !contact_before;
        end
    end

    wh_port_state #(
        .N           (N),
        .W           (MOVE_W + 1)
    ) way_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_i),
        .save_i      (valid_i),
        .save_port_i (port_i),
        .value_i     ({position_i, moves ? back : back_before}),
        .value_o     ({position_before, back_before})
    );

    wh_port_state #(
        .N           (N),
        .W           (1)
    ) contact_state (
        .clk         (clk),
        .rst         (rst || !run_i),
        .port_i      (port_i),
        .save_i      (valid_i),
        .save_port_i (port_i),
        .value_i     (contact_i),
        .value_o     (contact_before)
    );

    // ---- Its energy.
    assign request_o     = at_q[1];
    assign factor_o      = $signed({{CUT{current_i[DATA_W-1]}}, current_i[DATA_W-1:CUT]});
    assign coefficient_o = $signed({{COEF_W-MOVE_W{counts_q[MOVE_W-1]}}, counts_q});

    wire signed [ENERGY_W-1:0] energy;
    wire                       full;
    reg  signed [SUM_W-1:0]    sum_q;
    wire                       fits = sum_q[SUM_W-1:ENERGY_W-1] == {(SUM_W - ENERGY_W + 1){sum_q[SUM_W-1]}};

    always @(posedge clk) begin
        sum_q <= $signed({{(SUM_W - PART_W){product_i[PART_W-1]}}, product_i[PART_W-1:0]})
                 + $signed({{(SUM_W - ENERGY_W){energy[ENERGY_W-1]}}, energy});
    end

    wh_port_state #(
        .N           (N),
        .W           (ENERGY_W + 1)
    ) energy_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_i),
        .save_i      (at_q[SAVE]),
        .save_port_i (port_i),
        .value_i     (begins_q ? {(ENERGY_W + 1){1'b0}}
                      : fits ? {full, sum_q[ENERGY_W-1:0]} : {1'b1, energy}),
        .value_o     ({full, energy})
    );

    // ---- Its most. Comparisons by a difference's carry, as wh_energy.
    wire [PEAK_W-1:0]  size = energy[PEAK_W-1:0];
    wire [PEAK_W-1:0]  peak;
    wire [PEAK_W-1:0]  above;
    wire               higher;
    wire [LIMIT_W-1:0] left;
    wire               beneath;

    assign {higher, above} = {1'b0, peak} - {1'b0, size};
    assign {beneath, left} = {1'b0, limit_i} - {1'b0, peak[PEAK_W-1 -: LIMIT_W]};

    wh_port_state #(
        .N           (N),
        .W           (PEAK_W)
    ) peak_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_i),
        .save_i      (at_q[PEAK] && (begins_q || (higher && !energy[ENERGY_W-1]))),
        .save_port_i (port_i),
        .value_i     (size),  // as a contact begins, 0
        .value_o     (peak)
    );

    assign energy_o = energy;
    assign peak_o   = $signed({1'b0, peak});

    always @(posedge clk) begin
        if (rst || !run_i) begin
            over_o <= {N{1'b0}};
        end else if (at_q[JUDGE]) begin
            over_o[port_i] <= contact_before && beneath && !full;
        end
    end

    wire unused = &{1'b0, current_i[CUT-1:0], above, left, product_i[DATA_W+COEF_W-1:PART_W]};

endmodule

`default_nettype wire
