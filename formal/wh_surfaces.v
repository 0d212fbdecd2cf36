// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_surfaces: what a surface does to two ports' waves, from any state in which it begins to act, with any words
// that wh_surface_words lets in. Before that the multiplier may still have waves of the phase before to save.
//
//   PART 0, with any squares: its account is paid p^2, and holds no more than it may.
//   PART 1, to p, with any products: it is the sum of g v without its fraction, as a data word.
//   PART 2, from y, with any products: the change along g is y - p, or less where the exact p counts, and each wave is
//     the sum of itself and g times the change, without its fraction, as a data word.
//   PART 3, with any squares: y^2 and what account and budget hold after it are at most what they held before, and
//     neither is ever below 0.
//   PART 4, where a surface is left: what its account has goes to the budget, as far as that may hold it.
//
// With |g| <= 1 those waves have |u|^2 <= |v|^2 + y^2 - p^2, which sim/tests/test_surfaces.py tries for every short
// word. Loss across is not in here.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_surfaces #(
    parameter integer PART = 0
) (
    input wire clk
);

    localparam integer DATA_W    = `WH_DATA_W;
    localparam integer COEF_W    = `WH_COEF_W;
    localparam integer Q         = `WH_SURFACE_Q;
    localparam integer ACCOUNT_W = 2 * DATA_W;
    localparam integer SUM_W     = 2 * DATA_W + 2;
    localparam integer W         = ACCOUNT_W + 6;
    // The step of ACT with which it begins.
    localparam [5:0]   FIRST     = (PART == 0) ? 6'd11 : (PART == 1) ? 6'd0 : (PART == 3) ? 6'd27 : 6'd33;

    localparam signed [COEF_W-1:0]  ONE     = 1 << Q;
    localparam        [W-1:0]       MOST    = 1 << (ACCOUNT_W - 1);
    localparam signed [W-1:0]       HIGH    = (1 << (DATA_W - 1)) - 1;

    localparam [3:0] TEST  = 4'd1;
    localparam [3:0] ACT   = 4'd13;
    localparam [3:0] NONE  = 4'd0;
    localparam [1:0] POSITION = 2'd0;
    localparam [3:0] VALUE = 4'd1;
    localparam [3:0] PLACE = 4'd4;
    localparam [3:0] P     = 4'd8;
    localparam [3:0] PAY   = 4'd9;
    localparam [3:0] ASK   = 4'd12;
    localparam [3:0] REFUSE = 4'd13;

    reg [5:0] at = FIRST;

    (* anyconst *) wire        [ACCOUNT_W-1:0] budget;
    (* anyconst *) wire signed [COEF_W-1:0]    g0;
    (* anyconst *) wire signed [COEF_W-1:0]    g1;
    (* anyconst *) wire signed [COEF_W-1:0]    a;
    (* anyconst *) wire signed [COEF_W-1:0]    eta;
    (* anyconst *) wire        [DATA_W-2:0]    most;
    (* anyseq *)   wire signed [DATA_W:0]      other;

    reg  [6:0]             row_q;
    reg  [2:0]             word_q;
    reg  signed [DATA_W:0] word;
    wire [6:0]             row;
    wire [2:0]             place;

    // One vector is read, and one surface's words.
    always @* begin
        word = other;
        if (row_q < 7'd96 && word_q == 3'd0) word = g0;
        if (row_q < 7'd96 && word_q == 3'd1) word = g1;
        if (row_q >= 7'd96 && row_q[0] && word_q == 3'd1) word = a;
        if (row_q >= 7'd96 && row_q[0] && word_q == 3'd2) word = eta;
    end

    wh_surfaces #(
        .PORTS      (2)
    ) block (
        .clk        (clk),
        .rst        (1'b0),
        .valid_i    (1'b0),
        .port_i     (2'd0),
        .position_i ({`WH_COUNT_W{1'b0}}),
        .current_i  ({DATA_W{1'b0}}),
        .wave_i     ({DATA_W{1'b0}}),
        .free_i     ({COEF_W{1'b0}}),
        .budget_i   (budget),
        .take_o     (),
        .row_o      (row),
        .word_o     (place),
        .word_i     ({{(31 - DATA_W){word[DATA_W]}}, word}),
        .present_i  (8'd255),
        .busy_o     (),
        .valid_o    (),
        .port_o     (),
        .wave_o     (),
        .acting_o   ()
    );

    (* hierconn *) wire [3:0]                \block.phase_q ;
    (* hierconn *) wire [5:0]                \block.step_q ;
    (* hierconn *) wire [1:0]                \block.port_q ;
    (* hierconn *) wire                      \block.half_q ;
    (* hierconn *) wire                      \block.asks_q ;
    (* hierconn *) wire [1:0]                \block.order_q ;
    (* hierconn *) wire [1:0]                \block.acting_q ;
    (* hierconn *) wire [8:0]                \block.active_q ;
    (* hierconn *) wire                      \block.begins ;
    (* hierconn *) wire [23:0]               \block.is_q ;
    (* hierconn *) wire [23:0]               \block.to_q ;
    (* hierconn *) wire                      \block.limited_q ;
    (* hierconn *) wire [3:0]                \block.to_7_q ;
    (* hierconn *) wire                      \block.mixed_q ;
    (* hierconn *) wire [9:7]                \block.bent_q ;
    (* hierconn *) wire [9:7]                \block.filtered_q ;
    (* hierconn *) wire [2:1]                \block.paid_q ;
    (* hierconn *) wire [2:1]                \block.settles_q ;
    (* hierconn *) wire                      \block.left_behind_q ;
    (* hierconn *) wire [2:1]                \block.came_q ;
    (* hierconn *) wire                      \block.out_q ;
    (* hierconn *) wire signed [DATA_W-1:0]  \block.most_q ;
    (* hierconn *) wire signed [SUM_W-1:0]   \block.sum_q ;
    (* hierconn *) wire [17:0]               \block.of_q ;
    (* hierconn *) wire [2:0]                \block.wait_q ;
    (* hierconn *) wire [7:0]                \block.touching_q ;
    (* hierconn *) wire                      \block.touches ;
    (* hierconn *) wire signed [DATA_W-1:0]  \block.p_q ;
    (* hierconn *) wire                      \block.p_exact_q ;
    (* hierconn *) wire                      \block.p_beyond_q ;
    (* hierconn *) wire                      \block.p_sign_q ;
    (* hierconn *) wire signed [DATA_W+1:0]  \block.registers[3] ;
    (* hierconn *) wire                      \block.asked_y_q ;
    (* hierconn *) wire                      \block.asked_r_q ;
    (* hierconn *) wire signed [DATA_W-1:0]  \block.y_q ;
    (* hierconn *) wire signed [DATA_W-1:0]  \block.resting_q ;
    (* hierconn *) wire signed [DATA_W:0]    \block.change ;
    (* hierconn *) wire [ACCOUNT_W-1:0]      \block.spent_q ;
    (* hierconn *) wire [ACCOUNT_W-1:0]      \block.budget_q ;
    (* hierconn *) wire [ACCOUNT_W-1:0]      \block.accounts[0] ;
    (* hierconn *) wire signed [SUM_W-1:0]   \block.account_q ;
    (* hierconn *) wire [SUM_W-2:0]          \block.funds_q ;
    (* hierconn *) wire signed [DATA_W+1:0]  \block.registers[15] ;
    (* hierconn *) wire signed [DATA_W+1:0]  \block.registers[8] ;
    (* hierconn *) wire signed [DATA_W+1:0]  \block.registers[9] ;
    (* hierconn *) wire signed [DATA_W+1:0]  \block.multiply.data_q3 ;
    (* hierconn *) wire signed [DATA_W:0]    \block.multiply.coef_q3 ;
    (* hierconn *) wire signed [2*DATA_W+2:0] \block.multiply.product_o ;

    // x / 2^Q toward zero, as a data word.
    function signed [DATA_W-1:0] value(input signed [SUM_W-1:0] x);
        reg signed [W-1:0] wide;
        begin
            wide = x;
            wide = (wide < 0) ? -((-wide) >>> Q) : wide >>> Q;
            value = (wide > HIGH) ? HIGH : (wide < -HIGH - 1) ? -HIGH - 1 : wide;
        end
    endfunction

    function fits(input signed [DATA_W+1:0] x);
        fits = x <= HIGH && x >= -HIGH - 1;
    endfunction

    // ---- What the multiplier was asked for 5 clocks ago and 6, and the sum of it.
    reg signed [DATA_W+1:0]   data_5, data_6;
    reg signed [DATA_W:0]     coef_5, coef_6;
    reg signed [SUM_W-1:0]    made_5, made_6;
    wire [3:0]                is_5 = \block.is_q [19:16];
    wire [1:0]                to_5 = \block.to_q [17:16];
    wire signed [SUM_W-1:0]   sum  = \block.sum_q ;

    // ---- The law.
    wire signed [DATA_W+1:0] v0 = \block.registers[8] ;
    wire signed [DATA_W+1:0] v1 = \block.registers[9] ;
    reg  signed [SUM_W-1:0]  e, paid, wanted, refused;
    reg  signed [DATA_W-1:0] w0, w1, u0, u1;
    wire signed [DATA_W-1:0] p       = value(e);
    wire signed [W-1:0]      wide_e  = e;
    wire signed [W-1:0]      wide_p  = p;
    wire signed [W-1:0]      rest    = wide_e - (wide_p <<< Q);   // what the rounding, or the limit, took
    wire                     limited = rest >= (1 << Q) || rest <= -(1 << Q);
    wire signed [DATA_W-1:0] y       = \block.asked_y_q ? \block.y_q : \block.asked_r_q ? \block.resting_q : 0;
    wire signed [DATA_W:0]   step    = y - p;
    wire signed [DATA_W:0]   change  = (rest > 0 && step > 0) ? (limited ? 0 : step - 1)
                                       : (rest < 0 && step < 0) ? (limited ? 0 : step + 1) : step;
    reg  signed [DATA_W:0]   change_q;
    reg  [W-1:0]             held;
    reg  [DATA_W+2:0]        p_was;
    reg                      left;
    wire signed [W-1:0]      exact_p = (wide_e < 0) ? -((-wide_e) >>> Q) : wide_e >>> Q;
    (* anyconst *) wire signed [SUM_W-1:0] some;

    wire                     turned = is_5 == VALUE && at > FIRST;
    wire [W-1:0]             given  = \block.asked_y_q ? wanted : \block.asked_r_q ? refused : {SUM_W{1'b0}};
    wire [ACCOUNT_W-1:0]     unspent = budget - \block.spent_q ;
    wire [W-1:0]             holds  = {6'd0, \block.accounts[0] } + unspent;
    wire [W-1:0]             live   = {{(W - SUM_W){\block.account_q [SUM_W-1]}}, \block.account_q };
    wire [DATA_W+2:0]        p_is   = {\block.p_q , \block.p_exact_q , \block.p_beyond_q , \block.p_sign_q };
    wire                     same   = v0 == w0 && v1 == w1 && p_was == p_is;
    wire                     alike  = \block.p_q == p && \block.p_exact_q == (rest == 0)
                                      && \block.p_beyond_q == (wide_p != exact_p)
                                      && \block.p_sign_q == (e < 0);

    // Where the multiplier still has something, it's a wave of a port.
    function value_or_none(input [3:0] is, input [3:0] to);
        value_or_none = is == NONE || (is == VALUE && to[3:1] == 3'b100);
    endfunction

    wire quiet = !\block.limited_q && !\block.mixed_q && \block.bent_q == 3'd0 && \block.paid_q == 2'd0
                 && \block.settles_q == 2'd0 && !\block.left_behind_q  && \block.came_q == 2'd0
                 && !\block.out_q ;
    wire rests = quiet && \block.filtered_q == 3'd0;

    always @(posedge clk) begin
        at     <= (at == 6'd63) ? at : at + 6'd1;
        row_q  <= row;
        word_q <= place;
        {data_6, data_5} <= {data_5, \block.multiply.data_q3 };
        {coef_6, coef_5} <= {coef_5, \block.multiply.coef_q3 };
        made_6 <= made_5;
        made_5 <= \block.multiply.product_o [SUM_W-1:0];

        // A product by 1 is exact.
        if (\block.multiply.coef_q3 == (1 << Q)) begin
            assume (\block.multiply.product_o == \block.multiply.data_q3 <<< Q);
        end
        assume (a >= 0 && a <= ONE && eta <= ONE && eta >= -ONE && budget <= MOST);
        if (at == FIRST) begin
            // What a surface has.
            p_was <= p_is;
            assume (\block.active_q == 9'd0 && \block.order_q < \block.acting_q && \block.most_q >= 0);
            assume (\block.accounts[0] <= MOST && \block.spent_q <= budget && \block.budget_q == unspent);
            assume (fits(v0) && fits(v1));
            held <= ((PART != 4 && \block.begins ) ? 0 : {6'd0, \block.accounts[0] }) + unspent;
            {w0, w1} <= {v0[DATA_W-1:0], v1[DATA_W-1:0]};
            e <= some;
        end
        if (at == FIRST && PART != 4) begin
            assume (\block.phase_q == ACT && \block.step_q == FIRST && \block.port_q == 2'd0 && !\block.half_q );
            assume (\block.asks_q );
        end

        case (PART)
            0: begin
                if (at == FIRST) begin
                    assume (\block.is_q == 24'd0 && rests && \block.registers[3] == \block.p_q );
                end
                if (at == 6'd16) begin
                    assert (is_5 == PAY && data_5 == \block.p_q && coef_5 == \block.p_q && sum == made_5);
                    paid <= sum;
                end
                if (at == 6'd27) begin
                    assert (live + unspent <= held + paid);
                    assert (live <= MOST && \block.spent_q <= budget && \block.budget_q == unspent);
                    assert (\block.funds_q == live + \block.budget_q );
                    assert (same && quiet && \block.filtered_q == 3'b100 && \block.is_q == 24'd0);
                    assert (\block.registers[15] == \block.resting_q );
                end
                cover (at == 6'd27 && live == MOST && paid != 0);
            end
            3: begin
                if (at == FIRST) begin
                    assume (\block.is_q == 24'd0 && quiet && \block.filtered_q == 3'b100 && live <= MOST);
                    assume (\block.funds_q == live + \block.budget_q );
                    assume (\block.registers[15] == \block.resting_q );
                    held <= live + unspent;
                end
                if (at == 6'd32) begin
                    assert (is_5 == ASK && data_5 == \block.y_q && coef_5 == \block.y_q && sum == made_5);
                    wanted <= sum;
                end
                if (at == 6'd33) begin
                    assert (is_5 == REFUSE && sum == made_5);
                    assert (data_5 == \block.resting_q && coef_5 == \block.resting_q );
                    refused <= sum;
                    assert (\block.is_q [23:16] == {ASK, REFUSE} && \block.is_q [15:0] == 16'd0 && rests);
                end
                if (at == 6'd36) begin
                    assert (given + holds <= held);
                    assert (\block.accounts[0] <= MOST && \block.spent_q <= budget && same);
                    assert (\block.budget_q == unspent);
                end
                cover (at == 6'd36 && \block.asked_y_q && wanted > \block.account_q );
                cover (at == 6'd36 && !\block.asked_y_q && \block.asked_r_q );
                cover (at == 6'd36 && !\block.asked_y_q && !\block.asked_r_q );
            end
            1: begin
                if (at == FIRST) begin
                    assume (!\block.mixed_q && \block.bent_q == 3'd0 && \block.filtered_q == 3'd0);
                    assume (\block.settles_q == 2'd0 && \block.came_q == 2'd0 && \block.is_q [15:12] == NONE);
                    assume (\block.is_q [7:0] == 8'd0 && (!\block.limited_q || \block.to_7_q [3:2] == POSITION));
                    assume (value_or_none(\block.is_q [11:8], \block.to_q [11:8]));
                    assume (value_or_none(\block.is_q [19:16], \block.to_q [19:16]));
                    assume (value_or_none(\block.is_q [23:20], \block.to_q [23:20]));
                end
                if (at == 6'd6) {w0, w1} <= {v0[DATA_W-1:0], v1[DATA_W-1:0]};
                if (at == 6'd9) begin
                    assert (is_5 == P && data_6 == w0 && coef_6 == g0 && data_5 == w1 && coef_5 == g1);
                    assert (sum == made_6 + made_5);
                    e <= sum;
                end
                if (at == 6'd11) begin
                    assert (alike && \block.registers[3] == p);
                    assert (\block.is_q == 24'd0 && rests);
                    assert (v0 == w0 && v1 == w1 && fits(v0) && fits(v1));
                end
            end
            2: begin
                // p of the sum e.
                if (at == FIRST + 6'd1) assume (alike);
                if (at == FIRST) begin
                    assume (\block.is_q [23:16] == {ASK, REFUSE} && \block.is_q [15:0] == 16'd0 && rests);
                end
                if (at == 6'd35) begin
                    assert (\block.settles_q [2] && \block.change == change);
                    change_q <= change;
                end
                if (at == 6'd40) assert (turned && to_5 == 2'd0 && data_6 == w0 && coef_5 == g0);
                if (at == 6'd42) assert (turned && to_5 == 2'd1 && data_6 == w1 && coef_5 == g1);
                if (turned) begin
                    assert (coef_6 == (1 << Q) && data_5 == change_q && sum == made_6 + made_5);
                end
                if (turned && to_5 == 2'd0) u0 <= value(sum);
                if (turned && to_5 == 2'd1) u1 <= value(sum);
                if (at == 6'd44) assert (v0 == u0 && v1 == u1);
            end
            default: begin
                if (at == FIRST) begin
                    assume (\block.phase_q == TEST && \block.is_q [23:20] == PLACE && \block.of_q [17:15] == 3'd0);
                    assume (\block.is_q [19:0] == 20'd0 && rests);
                    assume (\block.wait_q == 3'd0 && !\block.asks_q );
                    left <= \block.touching_q [0] && !\block.touches ;
                end
                if (at == FIRST + 6'd4) begin
                    assert (unspent <= (left ? held : held - \block.accounts[0] ));
                    assert (\block.spent_q <= budget && \block.budget_q == unspent);
                    assert (!left || !\block.touching_q [0]);
                end
                cover (at == FIRST + 6'd4 && left && unspent == held && \block.accounts[0] != 0);
            end
        endcase
    end

endmodule

`default_nettype wire
