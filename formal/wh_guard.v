// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_guard: a fault that counts is latched in the clock after its cause and stays while the
// cause lasts, whatever clear_i does; a judgement lasts until the next sample or current; SATURATED needs
// a count for each turn back since the bridge went on, and begins anew with a turn back where the limit
// doesn't act; and with wh_half_bridge behind it both gates are off two clocks after the cause, and stay so.
// Settings are any constants, all inputs do what they like. Mode prove, depth 4, z3; cover 12.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module prove_wh_guard (
    input wire                           clk,
    input wire                           rst,
    input wire                           clear,
    input wire                           enable,
    input wire                           stop,
    input wire                           driver,
    input wire                           alive,
    input wire [`WH_BUS_W-1:0]           bus,
    input wire                           sampled,
    input wire signed [`WH_SAMPLE_W-1:0] sample,
    input wire                           energy,
    input wire                           saturated,
    input wire                           direction,
    input wire [9:0]                     inputs,   // faults found outside, as below
    input wire                           zero_start,
    input wire                           zero_busy,
    input wire                           moved,
    input wire                           tick,
    input wire                           valid,
    input wire signed [`WH_DATA_W-1:0]   current,
    input wire signed [`WH_DATA_W-1:0]   u,
    input wire signed [`WH_DATA_W-1:0]   v,
    input wire                           leg
);

    (* anyconst *) wire [`WH_GUARD_W-1:0] settings;
    (* anyconst *) wire [7:0]             dead;

    wire [`WH_FAULTS-1:0] faults;
    wire                  off, damp, high, low;
    wire                  run = enable && !off;

    wh_guard #(
        .N              (1)
    ) block (
        .clk            (clk),
        .rst            (rst),
        .settings_i     (settings),
        .clear_i        (clear),
        .running_i      (run),
        .stop_i         (stop),
        .driver_i       (driver),
        .host_alive_i   (alive),
        .bus_i          (bus),
        .sample_valid_i (sampled),
        .sample_i       (sample),
        .range_i        (inputs[0]),
        .stuck_i        (inputs[1]),
        .zero_i         (inputs[2]),
        .zero_start_i   (zero_start),
        .zero_busy_i    (zero_busy),
        .trip_i         (inputs[3]),
        .encoder_i      (inputs[4]),
        .moved_i        (moved),
        .direction_i    (direction),
        .anchor_i       (inputs[5]),
        .energy_i       (energy),
        .saturated_i    (saturated),
        .overspeed_i    (inputs[8]),
        .outside_i      (inputs[9]),
        .setting_i      (inputs[6]),
        .overrun_i      (inputs[7]),
        .tick_i         (tick),
        .valid_i        (valid),
        .current_i      (current),
        .u_i            (u),
        .v_i            (v),
        .faults_o       (faults),
        .off_o          (off),
        .damp_o         (damp)
    );

    wh_half_bridge bridge (
        .clk            (clk),
        .rst            (rst),
        .enable_i       (run),
        .leg_i          (leg),
        .dead_clocks_i  (dead),
        .high_o         (high),
        .low_o          (low)
    );

    (* hierconn *) wire [`WH_FAULTS-1:0] \block.causes ;
    (* hierconn *) wire                  \block.motor[0].measured_q ;
    (* hierconn *) wire [`WH_SAMPLE_W-1:0] \block.motor[0].sample_size_q ;
    (* hierconn *) wire [4:0]             \block.motor[0].swings_q ;
    (* hierconn *) wire                   \block.motor[0].turned_q ;
    (* hierconn *) wire                   \block.way_q ;
    (* hierconn *) wire                   \block.newest_q ;

    wire [`WH_FAULTS-1:0] causes   = \block.causes ;
    wire [`WH_FAULTS-1:0] mask     = settings[`WH_GUARD_MASK];
    wire [`WH_FAULTS-1:0] switches = ~(settings[`WH_GUARD_DAMP] & `WH_FAULTS_DAMPABLE);

    // Inputs that are causes as they are.
    wire [`WH_FAULTS-1:0] direct = inputs[3] << `WH_FAULT_TRIP    | inputs[1] << `WH_FAULT_ADC_STUCK
                                 | inputs[0] << `WH_FAULT_ADC_RANGE
                                 | (inputs[2] && !zero_start) << `WH_FAULT_ZERO
                                 | inputs[4] << `WH_FAULT_ENCODER | inputs[5] << `WH_FAULT_ANCHOR
                                 | (energy && settings[`WH_GUARD_ENERGY] != 0) << `WH_FAULT_ENERGY
                                 | inputs[8] << `WH_FAULT_OVERSPEED | inputs[9] << `WH_FAULT_WINDOW
                                 | inputs[6] << `WH_FAULT_SETTING | inputs[7] << `WH_FAULT_OVERRUN;

    // What the last sample says, found apart from the block.
    function [`WH_FAULTS-1:0] judged(input [`WH_SAMPLE_W-1:0] size);
        judged = (size > settings[`WH_GUARD_CURRENT]) << `WH_FAULT_CURRENT
               | (size > settings[`WH_GUARD_RANGE]) << `WH_FAULT_ADC_RANGE;
    endfunction

    wire [`WH_FAULTS-1:0] says = judged(sample[`WH_SAMPLE_W-1] ? -sample : sample);

    reg                  begun = 1'b0;
    reg                  rst_q, clear_q, zero_start_q, sampled_q, run_q, stops_q;
    reg [`WH_FAULTS-1:0] faults_q, causes_q, direct_q, said_q, said_q2;

    // Counts since the bridge went on, up to 63, and whether the last two went the same way.
    reg  [5:0]  counts_q;
    reg         judged_q, turn_q, acts_q;

    wire [5:0]  swings = {1'b0, \block.motor[0].swings_q };
    wire        turned = \block.motor[0].turned_q ;
    wire        owes   = \block.newest_q != \block.way_q ;  // a count so far

    localparam [`WH_FAULTS-1:0] SAMPLES = 1 << `WH_FAULT_CURRENT;

    always @(posedge clk) begin
        begun     <= 1'b1;
        rst_q     <= rst;
        clear_q   <= clear;
        zero_start_q <= zero_start;
        sampled_q <= sampled;
        run_q     <= run;
        faults_q  <= faults;
        causes_q  <= causes;
        direct_q  <= direct;
        said_q    <= rst ? 0 : sampled ? says : said_q;
        said_q2   <= rst ? 0 : said_q;
        stops_q   <= !rst && |(causes & mask & switches);
        judged_q  <= valid && !rst;
        turn_q    <= judged_q && turned && !rst && run;
        acts_q    <= saturated;
        if (rst || !run) begin
            counts_q <= 0;
        end else if (moved && counts_q != 63) begin
            counts_q <= counts_q + 1;
        end

        if (!begun) begin
            assume (rst);
        end else begin
            assert (off == |(faults & switches));
            assert (damp == (|faults && !off));
            if (rst_q) begin
                assert (faults == 0);
            end else begin
                assert (faults == ((clear_q ? 0 : faults_q & ~(zero_start_q << `WH_FAULT_ZERO)) | (causes_q & mask)));
                assert ((direct_q & mask & ~faults) == 0);
                assert ((said_q2 & mask & ~faults) == 0);
                // What makes that inductive.
                assert (said_q == judged(\block.motor[0].sample_size_q ));
                if (stops_q) assert (off);
            end
            assert (\block.motor[0].measured_q == judged_q);
            if (run_q && counts_q < 15) assert (!causes[`WH_FAULT_SATURATED]);
            if (run_q && counts_q != 63) assert (swings + turned <= counts_q);
            if (turn_q && !acts_q) assert (swings == 0);
            if (settings[`WH_GUARD_SATURATED] == 0) assert (!causes[`WH_FAULT_SATURATED]);
            // Levels: no cause of a sample or a current ends before the next.
            if (!rst_q && !sampled_q) begin
                if (causes_q[`WH_FAULT_CURRENT]) assert (causes[`WH_FAULT_CURRENT]);
                if (causes_q[`WH_FAULT_ADC_RANGE] && !direct_q[`WH_FAULT_ADC_RANGE]) begin
                    assert (causes[`WH_FAULT_ADC_RANGE]);
                end
                if (causes_q[`WH_FAULT_ADC_STUCK] && !direct_q[`WH_FAULT_ADC_STUCK]) begin
                    assert (causes[`WH_FAULT_ADC_STUCK]);
                end
            end
            // One of a current with the gates off, by a zero that stands.
            if (!rst_q && !run_q && !run && !zero_start && !zero_busy && !\block.motor[0].measured_q
                && causes_q[`WH_FAULT_ZERO] && !direct_q[`WH_FAULT_ZERO]) begin
                assert (causes[`WH_FAULT_ZERO]);
            end
            // Gates: off one clock after off, so two after the cause.
            if (!run_q) assert (!high && !low);
        end

        cover (begun && clear_q && faults_q == SAMPLES && faults == SAMPLES && !sampled_q && off);
        cover (begun && clear_q && faults_q[`WH_FAULT_CURRENT] && faults == 0);
        cover (begun && damp && high && clear);
    end

endmodule

`default_nettype wire
