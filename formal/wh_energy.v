// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_energy: E and peak stay within their words and never wrap, peak is at least E and 0; a contact's first
// period makes both 0; a clock changes E by one count's current at most, and only for a count within a contact
// that goes on in the direction of the one before; over_o is exactly a peak beyond the limit in a contact that is
// still judged. Words as they come; start_i only while run_i, and not before the counts are done.
// Mode prove, depth 4, z3; cover 12.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_energy (
    input wire                          clk,
    input wire                          rst,
    input wire                          run,
    input wire                          start,
    input wire                          contact,
    input wire [`WH_MOVE_W-1:0]         position,
    input wire signed [`WH_DATA_W-1:0]  current
);

    localparam integer W   = `WH_ENERGY_W;
    localparam integer CUT = `WH_CURRENT_Q - `WH_ENERGY_Q;

    (* anyconst *) wire [`WH_ENERGY_LIMIT_W-1:0] limit;

    wire signed [W-1:0] energy;
    wire signed [W-1:0] peak;
    wire                over;

    wh_energy block (
        .clk        (clk),
        .rst        (rst),
        .run_i      (run),
        .start_i    (start),
        .contact_i  (contact),
        .position_i (position),
        .current_i  (current),
        .limit_i    (limit),
        .energy_o   (energy),
        .peak_o     (peak),
        .over_o     (over)
    );

    (* hierconn *) wire [`WH_MOVE_W-1:0] \block.goal_q ;
    (* hierconn *) wire [`WH_MOVE_W-1:0] \block.place_q ;
    (* hierconn *) wire                  \block.counts_q ;
    (* hierconn *) wire                  \block.contact_q ;
    (* hierconn *) wire                  \block.step_q ;
    (* hierconn *) wire                  \block.back_q ;
    (* hierconn *) wire                  \block.full_q ;

    // What is there to be followed, and whether a contact is under way, found apart from the block.
    reg                      begun = 1'b0;
    reg  [`WH_MOVE_W-1:0]    goal;
    reg                      within;    // the newest period is in contact
    reg                      before;    // and the one before it
    reg                      judged;    // no count was left out
    reg                      back;      // the last count
    wire [`WH_MOVE_W-1:0]    way    = goal - \block.place_q ;
    wire                     moves  = (way != 0);
    wire signed [W:0]        part   = current >>> CUT;
    wire signed [W:0]        count  = back ? -part : part;
    wire signed [W:0]        sum    = {energy[W-1], energy} + count;
    wire                     fits   = (sum[W] == sum[W-1]);
    wire                     begins = start && contact && !within;

    reg                      due_q;
    wire                     alike  = \block.goal_q == goal && \block.contact_q == within
                                      && \block.counts_q == before && \block.back_q == back
                                      && \block.step_q == due_q && \block.full_q == !judged;

    reg                      rst_q, begins_q, adds_q, high_q;
    reg  signed [W-1:0]      energy_q, peak_q;
    reg  signed [W:0]        sum_q;

    always @(posedge clk) begin
        begun    <= 1'b1;
        goal     <= rst ? 0 : start ? position : goal;
        within   <= (rst || !run) ? 1'b0 : start ? contact : within;
        before   <= (rst || !run) ? 1'b0 : start ? within : before;
        back     <= rst ? 1'b0 : moves ? way[`WH_MOVE_W-1] : back;
        due_q    <= !rst && run && moves && before && way[`WH_MOVE_W-1] == back;
        judged   <= (rst || begins) ? 1'b1 : judged && !(due_q && !fits);
        rst_q    <= rst;
        begins_q <= begins;
        adds_q   <= due_q && fits;
        energy_q <= energy;
        peak_q   <= peak;
        sum_q    <= sum;
        high_q   <= (energy > peak);

        // It begins with a reset or in the midst of things: no search from a reset would be as long as a sum that
        // leaves its word.
        if (!begun) begin
            assume (rst || (alike && peak >= 0));
        end else begin
            assume (!start || run);
            assume (!start || !moves);
            assert (alike);  // makes that inductive
            assert (peak >= 0);
            if (rst_q || begins_q) begin
                assert (energy == 0 && peak == 0 && !over);
            end else begin
                assert ({energy[W-1], energy} == (adds_q ? sum_q : {energy_q[W-1], energy_q}));
                assert (peak == (high_q ? energy_q : peak_q));
            end
            // One clock behind.
            if (!adds_q) assert (peak >= energy);
            assert (over == (within && judged && peak[W-2 -: `WH_ENERGY_LIMIT_W] > limit));
        end

        cover (begun && over && limit != 0 && energy < 0);
        cover (begun && !judged && within);
        cover (begun && !within && energy > 0 && peak > energy);
    end

endmodule

`default_nettype wire
