// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_wave_core: one step from any state of rest, with any products (any_multiply.v). What it
// leaves is such a state again, so the proof holds for all steps. |eta| <= 1, 0 <= a <= 1 and
// u_max >= 0, as the ports ask for. Where reads_o is low, root, a and u_max may be anything. The claims are proven
// one by one; part 3 follows from 1 and 2, and is proven by itself at short words. With SHARED = 1 the multiplier is outside, and what it
// makes is any word at all where the core hasn't asked three clocks before.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_wave_core #(
    parameter integer OUTSIDE = 0,
    parameter integer SHARED  = 0,
    parameter integer PART    = 0   // of the claims: one after the other they are soon proven
) (
    input wire clk
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer COEF_W    = `WH_COEF_W;
    localparam integer GUARD     = `WH_STATE_GUARD;
    localparam integer STATE_W   = `WH_STATE_W;
    localparam integer PRODUCT_W = DATA_W + COEF_W;
    localparam integer SI_SHIFT  = `WH_ROOT_Q + `WH_CURRENT_Q - `WH_WAVE_Q;
    localparam integer SU_SHIFT  = `WH_ROOT_Q + `WH_WAVE_Q - `WH_VOLTAGE_Q;
    localparam integer A_SHIFT   = `WH_A_Q - GUARD;
    localparam integer CLOCKS    = 24;

    (* anyconst *) wire signed [DATA_W-1:0] current;
    (* anyconst *) wire signed [DATA_W-1:0] outside;
    (* anyconst *) wire signed [COEF_W-1:0] eta;
    (* anyconst *) wire signed [COEF_W-1:0] root;
    (* anyconst *) wire signed [COEF_W-1:0] a;
    (* anyconst *) wire signed [DATA_W-1:0] u_max;
    (* anyconst *) wire        [1:0]        ends;
    (* anyconst *) wire        [1:0]        extra_ticks;
    (* anyconst *) wire        [1:0]        hold_ticks;

    reg [4:0] at = 5'd0;

    wire                     busy, reads, valid, overrun, saturated, clipped;
    (* anyseq *) wire signed [COEF_W-1:0] any_root;
    (* anyseq *) wire signed [COEF_W-1:0] any_a;
    (* anyseq *) wire signed [DATA_W-1:0] any_u_max;
    wire signed [DATA_W-1:0] voltage, u_n, v;

    wire                        request;
    wire signed [DATA_W-1:0]    factor;
    wire signed [COEF_W-1:0]    coefficient;
    wire signed [PRODUCT_W-1:0] asked_for;
    (* anyseq *) wire signed [PRODUCT_W-1:0] another;
    reg                  [2:0]  asked;

    wh_multiply multiply (
        .clk       (clk),
        .take_i    (asked[0]),
        .data_i    (factor),
        .coef_i    (coefficient),
        .product_o (asked_for)
    );

    wh_wave_core #(
        .OUTSIDE       (OUTSIDE),
        .SHARED        (SHARED)
    ) block (
        .clk           (clk),
        .rst           (1'b0),
        .start_i       (at == 5'd0),
        .busy_o        (busy),
        .reads_o       (reads),
        .valid_o       (valid),
        .overrun_o     (overrun),
        .current_i     (current),
        .eta_i         (eta),
        .outside_i     (outside),
        .ends_i        (ends),
        .shape_mode_i  (2'd0),
        .shape_words_i ({(9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W){1'b0}}),
        .root_i        (reads ? root : any_root),
        .a_i           (reads ? a : any_a),
        .u_max_i       (reads ? u_max : any_u_max),
        .extra_ticks_i (extra_ticks),
        .hold_ticks_i  (hold_ticks),
        .voltage_o     (voltage),
        .u_o           (u_n),
        .v_o           (v),
        .saturated_o   (saturated),
        .withheld_o    (),
        .clipped_o     (clipped),
        .waves_o       (),
        .request_o     (request),
        .factor_o      (factor),
        .coefficient_o (coefficient),
        .product_i     (asked[2] ? asked_for : another)
    );

    (* hierconn *) wire [CLOCKS-1:0]           \block.at_q ;
    (* hierconn *) wire                        \block.port_q ;
    (* hierconn *) wire signed [STATE_W-1:0]   \block.f_q[0] ;
    (* hierconn *) wire signed [DATA_W-1:0]    \block.u_held_q ;
    (* hierconn *) wire signed [DATA_W-1:0]    \block.v ;
    (* hierconn *) wire signed [DATA_W-1:0]    \block.error ;
    (* hierconn *) wire signed [PRODUCT_W-1:0] \block.product ;

    localparam signed [DATA_W-1:0]  WORD  = {1'b0, {(DATA_W - 1){1'b1}}};
    localparam signed [COEF_W-1:0]  ONE   = {2'b01, {(COEF_W - 2){1'b0}}};
    localparam signed [STATE_W-1:0] LARGEST = {WORD, {GUARD{1'b0}}};

    localparam signed [DATA_W:0]    LOWEST  = {2'b01, {(DATA_W - 1){1'b0}}};

    // Long enough for everything below.
    localparam integer W = PRODUCT_W + GUARD + 4;

    function signed [W-1:0] size(input signed [W-1:0] x);
        size = (x < 0) ? -x : x;
    endfunction

    // x / 2^n toward zero.
    function signed [W-1:0] toward_zero(input signed [W-1:0] x, input integer n);
        toward_zero = (x < 0) ? -((-x) >>> n) : x >>> n;
    endfunction

    function signed [W-1:0] clamp(input signed [W-1:0] x, input signed [W-1:0] low,
                                  input signed [W-1:0] high);
        clamp = (x < low) ? low : (x > high) ? high : x;
    endfunction

    // What is known of the current, and v by it.
    wire at_high = ends[0] || current == WORD;
    wire at_low  = ends[1] || current == ~WORD;
    wire signed [W-1:0] wide_v = u_n - toward_zero(si, SI_SHIFT);
    wire above   = wide_v > 0;
    wire below   = wide_v < 0;

    reg signed [STATE_W-1:0]   f_before;
    reg signed [PRODUCT_W-1:0] si, eta_v, step, su;

    wire signed [STATE_W-1:0] f     = \block.f_q[0] ;
    wire signed [W-1:0]       goal  = clamp(toward_zero(eta_v, `WH_ETA_Q), -LOWEST, WORD);
    wire signed [W-1:0]       aim   = (goal + ((OUTSIDE == 1) ? outside : 0)) <<< GUARD;
    wire signed [W-1:0]       taken = toward_zero(step, A_SHIFT);
    wire signed [W-1:0]       limit = $signed({u_max, {GUARD{1'b0}}});
    wire signed [W-1:0]       was   = f_before;
    wire signed [W-1:0]       is    = f;

    always @(posedge clk) begin
        at <= (at == 5'd25) ? 5'd25 : at + 5'd1;
        assume (u_max >= 0 && a >= 0 && a <= ONE && eta <= ONE && eta >= -ONE);
        if (at == 5'd0) begin
            assume (\block.at_q == 24'd1 && !busy && !\block.port_q );
            assume (f <= LARGEST && f >= -LARGEST);
            assume (!overrun);
            f_before <= f;
        end
        // Where a product is cut, in the clock before the table's next step.
        if (at == 5'd3) si <= \block.product ;
        if (at == 5'd8) eta_v <= \block.product ;
        if (at == 5'd14) step <= \block.product ;
        if (at == 5'd22) su <= \block.product ;

        // What is asked for, and that no other clock is.
        asked <= {asked[1:0], request};
        if (SHARED == 1) begin
            assert (request == (at == 5'd0 || at == 5'd5 || at == 5'd11 || at == 5'd19));
            if (at == 5'd0) assert (factor == current && coefficient == root);
            if (at == 5'd5) assert (factor == \block.v  && coefficient == eta);
            if (at == 5'd11) assert (factor == \block.error  && coefficient == a);
            if (at == 5'd19) assert (factor == \block.u_held_q  && coefficient == root);
        end

        assert (reads == (at < 5'd20));

        if (at == 5'd24) begin
            case (PART)
                0: begin
                    assert (valid && !busy && !overrun);
                    assert (\block.at_q == 24'd1 && !\block.port_q );
                    // v and e are limited, and don't wrap.
                    assert (v == (((above && at_high) || (below && at_low)) ? 0
                                  : clamp(wide_v, -LOWEST, WORD)));
                    assert (clipped == (at_high || at_low || wide_v > WORD || wide_v < -LOWEST));
                    assert (voltage == clamp(toward_zero(su, SU_SHIFT), -LOWEST, WORD));
                end
                1: begin
                    // Neither does f.
                    assert (is == clamp(was + taken, -limit, limit));
                    assert (saturated == (was + taken > limit || was + taken < -limit));
                end
                2: begin
                    // The aim is no longer than v, and a step goes toward it and not past it.
                    assert (size(goal) <= size(v));
                    assert ((taken >= 0 && taken <= aim - was)
                            || (taken <= 0 && taken >= aim - was));
                end
                3: begin
                    // Which comes to:
                    assert (size(is) <= size(was) || size(is) <= size(aim));
                    assert (size(is) <= size(was + taken) && size(is) <= limit);
                    assert (f <= LARGEST && f >= -LARGEST);
                end
                default: begin
                    // What is put out is no longer than f.
                    if (hold_ticks == 0) begin
                        assert (size($signed({\block.u_held_q , {GUARD{1'b0}}})) <= size(is));
                    end
                    // Without anything to aim at f only dies out, by all that the product says.
                    if (aim == 0) assert (size(was + taken) == size(was) - size(taken));
                end
            endcase
        end

        cover (at == 5'd24 && saturated && is != 0 && u_n > 0 && v < 0);
        cover (at == 5'd24 && aim == 0 && is < was && is > 0);
        cover (at == 5'd24 && is > was && aim > is && !saturated);
    end

endmodule

`default_nettype wire
