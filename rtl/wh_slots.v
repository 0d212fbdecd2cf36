// SPDX-License-Identifier: Apache-2.0
//
// wh_slots: the schedule of the ports. A round has a slot for each port, and begins when a period's sums are ready.
//
// A slot begins every PITCH clocks, with valid_o, port_o and the bank of its settings. Each station passes these on
// with its data. The bank is the one in force as the round begins, so all ports of a round have the settings of one
// commit. A port's slot, in clocks since its valid_o, with the multiplier's requests in brackets; the end of a slot
// overlaps the beginning of the next:
//    0  wh_sense, wh_contact_ports begin     [1] sum * gain
//    6  the current is valid, wh_core begins [7] s i_n   [12] η v   [18] a (η v - f)   [26] s u
//   12  wh_anchor_ports begins, with v at 13 [14 15 16 19 20 34 35 38]
//   31  e is valid, wh_drive begins          [32] e * clocks_per_volt
//    6  wh_guard_ports begins                [21] i_n^2
//   12  wh_energy_ports begins               [13] way i_n
// Each section of W delays the requests of wh_core from η W{v} on by 5 clocks, and wh_drive with them.
//
// A brushless motor has two slots, alpha's and beta's (AXES). Besides the above, these do:
//   alpha 21  wh_sense computes the current of phase b        [22], and wh_clarke beta's of both    [29]
//         42  wh_guard_ports: the i_n^2 of b, begun at 27; beta's own doesn't begin
//   beta   5  wh_sense takes beta's current, without a request
//         15  the current of the third phase: its dead time, and wh_guard_ports                     [30]
//         31  e of both axes is valid, wh_legs begins         [32] e of beta * √3/2   [40 41 42] legs
// With W, in clocks of the same slots: [56 57 58] legs with one section, and [24 31 29 61 62 63] with two, where b
// comes at 23 and the third phase at 14. If beta's slot is the last, a round may begin once the legs have requested.
//
// Modulo 32, and modulo 36 with two sections, all these clocks differ. So the ports of a round never request at once.
// The next round may begin at any clock from TAIL after the last slot's begin on: 38, and 42 with two sections. Then
// the remaining requests of the last slot don't meet those of the new one. A round that is due earlier waits. A round
// that is due while another one waits is lost, and sets overrun_o.
//
// LOOK: a round has two passes. The slots of the first one (look_o) end in clock 16, with the wave that a port gives to
// the surfaces. The second pass begins TAIL after the last of these slots, or as soon as busy_i is 0. A period is longer
// by the first pass.
//
// run_o follows run_i, but rises only as a round begins, so all ports make their first step in the same period.
// damp_o is damp_i as of the round's beginning: a fault found in a port's turn damps all ports from the next round on.
//
// Latency: none from summed_i. Reset: no round, run_o = 0, damp_o = 0.

`default_nettype none

module wh_slots #(
    parameter integer N      = 1,                        // ports, 1...8
    parameter integer SHAPER = 0,                        // sections of W, 0...2
    parameter integer AXES   = 0,                        // bit n: ports n, n + 1 are a brushless motor's axes
    parameter integer LOOK   = 0,                        // 1: a round has two passes
    parameter integer PORT_W = (N > 1) ? $clog2(N) : 1   // derived, leave it
) (
    input  wire              clk,
    input  wire              rst,

    input  wire              summed_i,   // strobe, a round is due
    input  wire              force_i,    // the bank in force
    input  wire              run_i,      // the bridges are on
    input  wire              damp_i,     // the guard requests damping
    input  wire              busy_i,     // LOOK: the second pass has to wait

    output wire              valid_o,    // strobe, a slot
    output wire [PORT_W-1:0] port_o,
    output wire              bank_o,
    output wire              look_o,     // with valid_o: of the first pass
    output wire              phase_o,    // strobe, the current of phase b, for port_o, which is beta's
    output wire              third_o,    // strobe, that of phase c
    output wire              run_o,
    output reg               damp_o,
    output reg               overrun_o   // until rst
);

    localparam [5:0]   PITCH = (SHAPER == 2) ? 6'd36 : 6'd32;
    localparam integer LAST  = N - 1;
    localparam integer BETAS = AXES << 1;
    localparam integer ENDS  = (BETAS >> LAST) & 1;  // the last slots are a brushless motor's
    localparam [5:0]   TAIL  = (ENDS == 0) ? ((SHAPER == 2) ? 6'd42 : 6'd38)  // to the next round
                                           : ((SHAPER == 2) ? 6'd63 : (SHAPER == 1) ? 6'd58 : 6'd42);
    localparam [5:0]   PHASE = (SHAPER == 2) ? 6'd23 : 6'd21;
    localparam [5:0]   THIRD = (SHAPER == 2) ? 6'd14 : 6'd15;

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_slots_n_must_be_1_to_8 stop ();
        end
        if (SHAPER < 0 || SHAPER > 2) begin : illegal_shaper
            wh_illegal_parameter_slots_shaper_must_be_0_to_2 stop ();
        end
        if (LOOK != 0 && LOOK != 1) begin : illegal_look
            wh_illegal_parameter_slots_look_must_be_0_or_1 stop ();
        end
        if (AXES < 0 || AXES >> LAST != 0 || (AXES & BETAS) != 0) begin : illegal_axes
            wh_illegal_parameter_slots_axes_must_be_pairs_of_ports stop ();
        end
    endgenerate

    reg [5:0]        clock_q;  // of the slot, stops at TAIL
    reg [PORT_W-1:0] slot_q;
    reg              due_q;    // a round waits
    reg              run_q;
    reg              bank_q;   // the round's

    wire [(1<<PORT_W)-1:0] alphas = AXES[(1<<PORT_W)-1:0];
    wire [(1<<PORT_W)-1:0] betas  = BETAS[(1<<PORT_W)-1:0];

    reg  look_q;  // first pass

    wire last   = (slot_q == LAST[PORT_W-1:0]);
    wire begins = (summed_i || due_q) && last && clock_q == TAIL && !look_q;
    wire again  = look_q && last && clock_q == TAIL && !busy_i;
    wire next   = !last && clock_q == PITCH;

    assign valid_o = !rst && (begins || again || next);
    assign port_o  = (begins || again) ? {PORT_W{1'b0}} : slot_q + 1'b1;
    assign look_o  = LOOK != 0 && (begins || (look_q && !again));
    assign bank_o  = begins ? force_i : bank_q;
    assign run_o   = run_q && run_i;
    assign phase_o = !rst && alphas[slot_q] && clock_q == PHASE;
    assign third_o = !rst && betas[slot_q] && clock_q == THIRD;

    always @(posedge clk) begin
        if (rst) begin
            clock_q   <= TAIL;
            slot_q    <= LAST[PORT_W-1:0];
            due_q     <= 1'b0;
            overrun_o <= 1'b0;
            damp_o    <= 1'b0;
            look_q    <= 1'b0;
        end else begin
            if (valid_o) begin
                look_q <= look_o;
            end
            if (begins) begin
                damp_o <= damp_i;
                bank_q <= force_i;
            end
            if (valid_o) begin
                clock_q <= 6'd1;
                slot_q  <= port_o;
            end else if (clock_q != TAIL) begin
                clock_q <= clock_q + 6'd1;
            end
            due_q <= (summed_i || due_q) && !begins;
            if (summed_i && due_q) begin
                overrun_o <= 1'b1;
            end
        end
        if (rst || !run_i) begin
            run_q <= 1'b0;
        end else if (begins) begin
            run_q <= 1'b1;
        end
    end

endmodule

`default_nettype wire
