// SPDX-License-Identifier: Apache-2.0
//
// wh_energy: observes the energy that a contact delivers to the shaft, count by count.
//
//   E     = sum of +-i_n   over the counts of a contact, each with the current of its period; times k_T Δ this is in
//           joules
//   peak  = the largest E of the contact, 0 or more
//   over  = in contact, and peak > limit, in the limit's format
//
// Position and mean current i_n of a period n are those that the port uses. Force along the motion increases E: a
// pressed spring has E < 0, and E > 0 is energy that was never put in. A count in the direction of the one before has
// crossed a whole interval between two edges, and is added. A count after a reversal has not: the rotor goes back
// through the same edge. So a rotor that chatters at an edge adds nothing.
// A contact's first period sets E and peak to 0. A period is counted if the period before was in contact: so the
// contact's last count is in E, and the count that began it is not. Out of contact, and while run_i = 0, both keep
// their values; the next period in contact begins a new contact.
// Each count takes a clock, so a jump of several needs no multiplier. A period may have as many counts as it has
// clocks, less two, and less than 2^(WH_MOVE_W-1). An encoder has at most two in filter_clocks_i + 1 clocks.
// Formats: E and peak s24q10 A·counts. The current is rounded down to as many fraction bits; what this takes on the
// way in it returns on the way out. A count that would overflow E is left out, and the contact isn't judged any more:
// beyond 8191 A·counts in a contact there is no observation.
// Latency: the first count is in E three clocks after start_i, in peak and over_o a clock later.
// Reset: E, peak and position 0, no contact.

`default_nettype none
`include "wh_formats.vh"

module wh_energy (
    input  wire                           clk,
    input  wire                           rst,
    input  wire                           run_i,       // the bridges are on

    input  wire                           start_i,     // strobe, while run_i: a period's words are there
    input  wire                           contact_i,
    input  wire [`WH_MOVE_W-1:0]          position_i,  // counts, modulo 2^12
    input  wire signed [`WH_DATA_W-1:0]   current_i,   // s31q24 A: i_n, until the next start_i
    input  wire [`WH_ENERGY_LIMIT_W-1:0]  limit_i,     // u16q3 A·counts

    output reg  signed [`WH_ENERGY_W-1:0] energy_o,    // s24q10 A·counts
    output wire signed [`WH_ENERGY_W-1:0] peak_o,      // s24q10 A·counts, 0 or more
    output wire                           over_o
);

    localparam integer ENERGY_W = `WH_ENERGY_W;
    localparam integer PEAK_W   = ENERGY_W - 1;
    localparam integer LIMIT_W  = `WH_ENERGY_LIMIT_W;
    localparam integer MOVE_W   = `WH_MOVE_W;
    localparam integer CUT      = `WH_CURRENT_Q - `WH_ENERGY_Q;

    generate
        if (PEAK_W - LIMIT_W != `WH_ENERGY_Q - `WH_ENERGY_LIMIT_Q || MOVE_W > `WH_COUNT_W) begin : illegal
            wh_illegal_WH_ENERGY_LIMIT_W_must_be_the_highest_bits_of_a_peak stop ();
        end
    endgenerate

    // ---- Counts, one a clock.

    reg              contact_q;  // of the newest period
    reg              counts_q;   // of the one before: what the newest has moved counts
    reg [MOVE_W-1:0] goal_q;     // position of the newest period
    reg [MOVE_W-1:0] place_q;    // follows it
    reg              back_q;     // the last count was downwards,
    reg              step_q;     // and is to be added

    wire              begins = start_i && contact_i && !contact_q;
    wire [MOVE_W-1:0] way    = goal_q - place_q;
    wire              back   = way[MOVE_W-1];
    wire              moves  = |way;

    always @(posedge clk) begin
        if (rst) begin
            goal_q  <= {MOVE_W{1'b0}};
            place_q <= {MOVE_W{1'b0}};
        end else begin
            if (start_i) begin
                goal_q <= position_i;
            end
            place_q <= place_q + {{MOVE_W-1{back}}, moves};  // without a way to go back is 0
        end
        if (rst) begin
            back_q <= 1'b0;
        end else if (moves) begin
            back_q <= back;
        end
        if (rst || !run_i) begin
            contact_q <= 1'b0;
            counts_q  <= 1'b0;
            step_q    <= 1'b0;
        end else begin
            if (start_i) begin
                contact_q <= contact_i;
                counts_q  <= contact_q;
            end
            step_q <= moves && counts_q && (back == back_q);
        end
    end

    // ---- Their energy.

    wire signed [ENERGY_W-1:0] current =
        {{ENERGY_W-`WH_DATA_W+CUT{current_i[`WH_DATA_W-1]}}, current_i[`WH_DATA_W-1:CUT]};
    wire signed [ENERGY_W-1:0] part    = current ^ {ENERGY_W{back_q}};
    wire signed [ENERGY_W-1:0] sum     = energy_o + part + $signed({{ENERGY_W-1{1'b0}}, back_q});
    // Both of one sign, and the sum of the other.
    wire                       beyond  = (energy_o[ENERGY_W-1] == part[ENERGY_W-1])
                                         && (sum[ENERGY_W-1] != energy_o[ENERGY_W-1]);
    reg                        full_q;

    // Comparisons by a difference's carry: a greater-than would be as many LUTs more.
    reg  [PEAK_W-1:0]  peak_q;
    wire [PEAK_W-1:0]  above;
    wire               higher;
    wire [LIMIT_W-1:0] left;
    wire               beneath;

    assign {higher, above} = {1'b0, peak_q} - {1'b0, energy_o[PEAK_W-1:0]};
    assign {beneath, left} = {1'b0, limit_i} - {1'b0, peak_q[PEAK_W-1 -: LIMIT_W]};

    wire unused = &{1'b0, current_i[CUT-1:0], above, left};

    assign peak_o = $signed({1'b0, peak_q});
    assign over_o = contact_q && beneath && !full_q;

    always @(posedge clk) begin
        if (rst || begins) begin
            energy_o <= {ENERGY_W{1'b0}};
            peak_q   <= {PEAK_W{1'b0}};
            full_q   <= 1'b0;
        end else begin
            if (step_q && beyond) begin
                full_q <= 1'b1;
            end
            if (step_q && !beyond) begin
                energy_o <= sum;
            end
            if (higher && !energy_o[ENERGY_W-1]) begin
                peak_q <= energy_o[PEAK_W-1:0];
            end
        end
    end

endmodule

`default_nettype wire
