// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_pwm: no leg changes sooner than min_pulse clocks after it changed before, with the widths
// that wh_modulator allows (formal/wh_modulator.v) and the limits that wh_controller gives it, in
// every mode (BY_MODE says which) and halves shorter than LONGEST clocks, after a reset of any length
// at any clock. What a reset cuts short doesn't count, and it leaves both legs low.

`default_nettype none
`include "wh_formats.vh"

`ifdef BY_MODE
`define MODES 1
`else
`define MODES 0
`endif
`ifndef LONGEST
`define LONGEST 64
`endif

module prove_wh_pwm (
    input wire                         clk,
    input wire                         rst,
    input wire signed [`WH_TICK_W-1:0] width
);

    localparam integer TICK_W = `WH_TICK_W;
    localparam integer RUN_W  = 8;  // for halves of up to 63 clocks

    (* anyconst *) wire [TICK_W-1:0] half_clocks;
    (* anyconst *) wire [1:0]        mode;
    (* anyconst *) wire [7:0]        min_pulse;

    wire [TICK_W-1:0] phase, remaining;
    wire              half, update, leg_a, leg_b;

    wh_carrier carrier (
        .clk             (clk),
        .rst             (rst),
        .half_clocks_i   (half_clocks),
        .tick_halves_i   (16'd2),
        .sample_clocks_i (16'd2),
        .samples_i       (9'd1),
        .sample_lead_i   (8'sd0),
        .sample_late_i   (1'b0),
        .phase_o         (phase),
        .remaining_o     (remaining),
        .half_o          (half),
        .update_o        (update),
        .take_o          (),
        .tick_o          (),
        .sample_o        (),
        .sample_first_o  ()
    );

    wh_pwm #(
        .MODES         (`MODES)
    ) block (
        .clk           (clk),
        .rst           (rst),
        .mode_i        (mode),
        .half_clocks_i (half_clocks),
        .phase_i       (phase),
        .remaining_i   (remaining),
        .half_i        (half),
        .update_i      (update),
        .width_i       (width),
        .leg_a_o       (leg_a),
        .leg_b_o       (leg_b)
    );

    (* hierconn *) wire              \carrier.running_q ;
    (* hierconn *) wire              \carrier.ends_q ;
    (* hierconn *) wire [TICK_W-1:0] \block.magnitude_q ;
    (* hierconn *) wire              \block.negative_q ;

    // As wh_controller has them.
    wire        whole   = (`MODES == 1) && mode != `WH_MODE_UNIPOLAR;
    wire        signs   = whole && mode == `WH_MODE_SIGN_MAGNITUDE;
    wire [15:0] spare   = {8'd0, min_pulse >> 1} + {15'd0, min_pulse[0]};
    wire [15:0] least   = !whole ? {8'd0, min_pulse} : signs ? spare : 16'd0;
    wire signed [17:0] limit = $signed({3'd0, half_clocks[15:1]}) - $signed({2'd0, spare});
    wire signed [17:0] w     = width;
    wire signed [17:0] w_size = w[17] ? -w : w;

    // Clocks for which a leg has been where it is, this one included; enough after a reset.
    localparam [RUN_W-1:0] LONG = 8'd127;
    reg        begun = 1'b0;
    reg        rst_q;
    reg        a_q, b_q;
    reg [RUN_W-1:0] run_a_q, run_b_q;
    wire [RUN_W-1:0] run_a = rst_q ? LONG : (leg_a != a_q) ? 8'd1 : (run_a_q == LONG) ? LONG : run_a_q + 8'd1;
    wire [RUN_W-1:0] run_b = rst_q ? LONG : (leg_b != b_q) ? 8'd1 : (run_b_q == LONG) ? LONG : run_b_q + 8'd1;

    wire [RUN_W-1:0] long_half  = half_clocks[RUN_W-1:0];
    wire [RUN_W-1:0] least_run  = min_pulse;
    wire [RUN_W-1:0] p          = phase[RUN_W-1:0];
    wire [RUN_W-1:0] m          = \block.magnitude_q [RUN_W-1:0];
    wire [RUN_W-1:0] long_spare = spare[RUN_W-1:0];

    // Unipolar, what the legs show in this clock: the phase before.
    wire        active = p - 8'd1 < m || long_half - p < m;
    wire        shown  = leg_a == (active ? !\block.negative_q : half)
                         && leg_b == (active ? \block.negative_q : half);

    // The run of a leg that is at least what this place in the half makes it, while it is ahead of
    // a pattern that is on for the first and the last on clocks of a half.
    function at_least(input [RUN_W-1:0] run, input [RUN_W-1:0] on, input first_part, input last_part);
        at_least = (!first_part && p - 8'd1 < on) ? run >= p
                 : (!last_part && long_half - p < on) ? run + long_half >= p + on
                 : run + ((first_part) ? 8'd0 : on) >= p;
    endfunction

    always @(posedge clk) begin
        begun   <= 1'b1;
        rst_q   <= rst;
        a_q     <= leg_a;
        b_q     <= leg_b;
        run_a_q <= run_a;
        run_b_q <= run_b;

        assume (half_clocks >= 6 && half_clocks < `LONGEST);
        assume (limit >= $signed({2'd0, least}) && limit >= 0 && limit >= $signed({10'd0, min_pulse} ));
`ifdef BY_MODE
        // Locked and half bridge drive the legs alike.
        assume (`BY_MODE == 2 ? mode == `WH_MODE_SIGN_MAGNITUDE
                              : mode == `WH_MODE_LOCKED || mode == `WH_MODE_HALF_BRIDGE);
`endif
        // With 0 nothing is claimed.
        assume (min_pulse >= 8'd1);
        assume (w_size <= limit && (w_size == 0 || w_size >= $signed({2'd0, least})));
        if (!begun) assume (rst && !\carrier.running_q );

        if (begun) begin
            if (rst_q) assert (!leg_a && !leg_b);
            if (!rst_q) begin
                if (leg_a != a_q) assert (run_a_q >= least_run);
                if (leg_b != b_q) assert (run_b_q >= least_run);
            end

            // What makes that inductive.
            assert (\block.magnitude_q < 16'd64);
            assert (run_a >= 8'd1 && run_b >= 8'd1 && run_a <= LONG && run_b <= LONG);
            if (rst_q) assert (!\carrier.running_q );
            assert (\carrier.ends_q == (remaining == 16'd0));
            if (!\carrier.running_q ) begin
                assert (rst_q);
                assert (m == 8'd0 && !half && phase == 16'd0 && remaining + 16'd1 == half_clocks);
            end else begin
                assert (phase < half_clocks && phase + remaining + 16'd1 == half_clocks);
            end
        end
    end

`ifdef BY_MODE
    (* hierconn *) wire [TICK_W-1:0] \block.by_mode.on_clocks_q ;
    (* hierconn *) wire              \block.by_mode.sign_q ;

    wire [RUN_W-1:0] on     = \block.by_mode.on_clocks_q [RUN_W-1:0];
    wire [RUN_W-1:0] centre = half_clocks[RUN_W:1];
    wire [RUN_W-1:0] centre_now = signs ? 8'd0 : centre;
    wire        odd    = half_clocks[0] && !signs;

    reg fresh;   // no width has been taken since reset

    always @(posedge clk) begin
        fresh <= rst || (fresh && !(update && half));
        if (begun) begin
            assert (\block.by_mode.on_clocks_q < 16'd64);
            if (!\carrier.running_q ) begin
                assert (fresh && on == centre_now && !\block.by_mode.sign_q );
            end
            if (signs) begin
                assert (on == 8'd0 || on >= 2 * long_spare);
                assert (on + 2 * long_spare <= long_half);
                if (fresh) assert (on == 8'd0 && !\block.by_mode.sign_q );
                if (\carrier.running_q && phase == 16'd0) begin
                    assert (run_a >= least_run);
                    if (!half) assert (run_b >= least_run);
                    else assert (run_b >= long_half);
                end else if (\carrier.running_q ) begin
                    if (!half) begin
                        assert (leg_a == ((p - 8'd1 < on) ^ \block.by_mode.sign_q ));
                        assert (p - 8'd1 < on ? run_a >= p : run_a + on >= p);
                        assert (run_b >= p);
                    end else begin
                        assert (leg_a == ((long_half - p < on) ^ \block.by_mode.sign_q ));
                        assert (long_half - p < on ? run_a + long_half >= p + on : run_a >= p);
                        assert (run_b >= long_half);
                    end
                end
                if (\carrier.running_q && (p != 8'd0 || half)) begin
                    assert (leg_b == \block.by_mode.sign_q );
                end
            end else begin
                if (fresh) assert (on == centre + {7'd0, odd && half});
                assert (on >= long_spare && on + long_spare <= long_half);
                if (\carrier.running_q && !half) begin
                    assert (on + long_spare + {7'd0, odd} <= long_half);
                    if (phase == 16'd0) begin
                        if (!fresh) assert (run_a >= long_spare && run_b >= long_spare
                                            && leg_a && !leg_b);
                        else assert (leg_a && !leg_b);
                    end else if (p - 8'd1 < on) begin
                        assert (leg_a && !leg_b);
                        assert (run_a >= p + (fresh ? 8'd0 : long_spare));
                        assert (run_b >= p + (fresh ? 8'd0 : long_spare));
                    end else begin
                        assert (!leg_a && leg_b);
                        assert (run_a + on >= p && run_b + on >= p);
                    end
                end
                if (\carrier.running_q && half) begin
                    if (phase == 16'd0) begin
                        assert (!leg_a && leg_b && run_a >= long_spare && run_b >= long_spare);
                    end else if (long_half - p < on) begin
                        assert (leg_a && !leg_b);
                        assert (run_a + long_half >= p + on && run_b + long_half >= p + on);
                    end else begin
                        assert (!leg_a && leg_b);
                        assert (run_a >= p + long_spare && run_b >= p + long_spare);
                    end
                end
            end
        end
        cover (begun && !rst_q && min_pulse == 8'd2 && leg_a != a_q && run_a_q == 8'd2);
        cover (begun && !rst_q && leg_b != b_q && run_b_q > 8'd2);
    end
`else
    always @(posedge clk) begin
        if (begun) begin
            assert (m == 8'd0 || m >= least_run);
            assert (2 * m + least_run <= long_half);
            if (\carrier.running_q ) begin
                if (phase == 16'd0) begin
                    assert (run_a >= least_run && run_b >= least_run);
                end else begin
                    assert (shown && at_least(run_a, m, 1'b0, 1'b0));
                    assert (at_least(run_b, m, 1'b0, 1'b0));
                end
            end
        end
        cover (begun && !rst_q && min_pulse == 8'd2 && leg_a != a_q && run_a_q == 8'd2);
        cover (begun && !rst_q && min_pulse == 8'd3 && leg_b != b_q && run_b_q == 8'd3);
        cover (begun && !rst_q && \carrier.running_q && min_pulse == 8'd1 && leg_a && !leg_b && half);
    end
`endif

endmodule

`default_nettype wire
