// SPDX-License-Identifier: Apache-2.0
//
// wh_surfaces: walls in space, as one group of 2 or 3 ports meets them.
//
// A surface is a plane G·x >= d in the counts x of the ports, and a vector g, |g| <= 1, of their waves. While the
// rotors are beyond it, waves along g are reflected, and all others pass:
//
//   p = g·v,   y = η H{p} + ξ,   u = v + g (y - p),   |u|^2 <= |v|^2 + y^2 - p^2
//
// Up to three surfaces act, one after another. A surface's account pays for its y, as does the group's budget for
// what ξ gives beyond. sim/wavehaptics/controller/surfaces.py has the law, and is equalled in every bit: contact, ξ,
// loss across, filter, account, roundings. Words: wh_surface_words.
//
// A round: strobes valid_i of port 0 to the last one, 4 clocks apart or more, with position, current and wave, which
// hold for the two clocks after it, too. With the last one the law begins, by one multiplier, a product a clock. Then
// valid_o strobes for each port in turn, with its wave: of a port in a group where nothing acts that is its own.
// acting_o says how many surfaces act, until the next round ends. free_i holds until then. The next round may begin
// with the last port's valid_o.
//
// Clocks from the last valid_i to the last valid_o, for P = PORTS and S = SURFACES, by the number of surfaces that act:
//
//   none:  9 + P + (2 + P) S, and if A act
//   A:     26 + P + (2 + P) S + (37 + 3 P) A,  and with a loss across 16 + 3 P more if A = 1,
//          and 35 + 11 P if A = 2
//
// State of a surface, in LUT RAM: the filter's f s40q32, its account u62q46, and what of ε the currents were s31q16;
// in registers that it is touched, without which the others mean 0. Of the group: what of the budget is spent.
// Formats: WH_SURFACE_..., products of 65 bits, sums of 64: nothing is lost before its rounding. With other data words
// all widths follow them; accounts have twice their bits.
// Latency: above. Reset: nothing is touched or spent, and a round under way ends.

`default_nettype none
`include "wh_formats.vh"

module wh_surfaces #(
    parameter integer PORTS    = 3,  // 2...3
    parameter integer SURFACES = 8   // 1...8
) (
    input  wire                          clk,
    input  wire                          rst,

    // A round.
    input  wire                          valid_i,     // strobe
    input  wire [1:0]                    port_i,
    input  wire signed [`WH_COUNT_W-1:0] position_i,  // counts
    input  wire signed [`WH_DATA_W-1:0]  current_i,   // s31q24 A
    input  wire signed [`WH_DATA_W-1:0]  wave_i,      // s31q23 √W
    input  wire signed [`WH_COEF_W-1:0]  free_i,      // s27q25: the least η of the ports' free space
    input  wire [2*`WH_DATA_W-1:0]       budget_i,    // u62q46 W, <= 2^61: what moving walls may give out; it may change

    // Words.
    output wire                          take_o,      // strobe
    output wire [6:0]                    row_o,
    output wire [2:0]                    word_o,
    input  wire [31:0]                   word_i,      // a clock later
    input  wire [7:0]                    present_i,

    output wire                          busy_o,      // a round goes on
    output wire                          valid_o,     // strobe
    output wire [1:0]                    port_o,
    output wire signed [`WH_DATA_W-1:0]  wave_o,      // s31q23 √W
    output wire [1:0]                    acting_o
);

    localparam integer DATA_W  = `WH_DATA_W;
    localparam integer COEF_W  = `WH_COEF_W;
    localparam integer STATE_W = `WH_STATE_W;
    localparam integer GUARD   = `WH_STATE_GUARD;
    localparam integer WIDE_W  = DATA_W + 2;
    localparam integer Q       = `WH_SURFACE_Q;
    localparam integer PLACE_Q = Q - `WH_SEEN_Q;
    localparam integer A_CUT   = `WH_A_Q - GUARD;
    localparam integer WORD_W  = DATA_W + 1;      // of a word that is read
    localparam integer SUM_W   = 2 * DATA_W + 2;
    localparam integer ACCOUNT_W = 2 * DATA_W;
    localparam integer VALUE_W = SUM_W - Q;       // of a sum without its fraction
    localparam integer XI_UP   = 2;               // of the 7 places that ξ's product lacks its word has 5
    localparam integer LAST    = PORTS - 1;
    localparam integer END     = SURFACES - 1;

    generate
        if (PORTS < 2 || PORTS > 3) begin : illegal_ports
            wh_illegal_parameter_surfaces_ports_must_be_2_or_3 stop ();
        end
        if (SURFACES < 1 || SURFACES > 8) begin : illegal_surfaces
            wh_illegal_parameter_surfaces_must_be_1_to_8 stop ();
        end
    endgenerate

    // ---- The program: phases, and steps of each. A step may ask for one product.
    localparam [3:0] IDLE   = 4'd0;
    localparam [3:0] TEST   = 4'd1;   // places, contacts
    localparam [3:0] BEND   = 4'd2;   // deflections
    localparam [3:0] MOVE   = 4'd3;   // wall velocities
    localparam [3:0] ALONG  = 4'd4;   // loss across: p,
    localparam [3:0] KEEP   = 4'd5;   // of one surface: what is kept of it,
    localparam [3:0] LOSE   = 4'd6;   // waves;
    localparam [3:0] FIRST  = 4'd7;   // of two: waves less the first one's,
    localparam [3:0] BESIDE = 4'd8;   // p of the second one in that,
    localparam [3:0] SECOND = 4'd9;   // less that too: all that is across,
    localparam [3:0] LESS   = 4'd10;  // waves that have lost that,
    localparam [3:0] JUDGE  = 4'd11;  // whether they are smaller,
    localparam [3:0] CHOOSE = 4'd12;  // waves
    localparam [3:0] ACT    = 4'd13;  // a surface: from mixed velocity and p to y,
    localparam [3:0] TURN   = 4'd14;  // waves
    localparam [3:0] OUT    = 4'd15;

    // Clocks from the last product of a phase that is asked for to the next one's first.
    localparam integer WAIT = 6;

    // Registers of the multiplier's: groups of four, by port, and one more in each.
    localparam [1:0] POSITION = 2'd0;  // and later ξ of each surface that acts; 3: p
    localparam [1:0] CURRENT  = 2'd1;  // 3: what a phase has for the next one
    localparam [1:0] WAVE     = 2'd2;  // 3: y
    localparam [1:0] REST     = 2'd3;  // ε beyond half a count, or waves; 3: y without ξ

    localparam [3:0] AT_P       = {POSITION, 2'd3};
    localparam [3:0] AT_NEXT    = {CURRENT, 2'd3};
    localparam [3:0] AT_Y       = {WAVE, 2'd3};
    localparam [3:0] AT_RESTING = {REST, 2'd3};

    // What a factor is multiplied by.
    localparam [2:0] BY_WORD   = 3'd0;
    localparam [2:0] BY_ONE    = 3'd1;  // 2^Q
    localparam [2:0] BY_ITSELF = 3'd2;
    localparam [2:0] BY_LOSS   = 3'd3;
    localparam [2:0] WHOLE     = 3'd4;  // the word by -2^Q, a count,
    localparam [2:0] PART      = 3'd5;  // or by its 256th

    // What a sum is, when its last product is in it.
    localparam [3:0] NONE   = 4'd0;
    localparam [3:0] VALUE  = 4'd1;   // a wave, saturated
    localparam [3:0] WIDE   = 4'd2;   // one that fits
    localparam [3:0] LIMIT  = 4'd3;   // ξ of a surface
    localparam [3:0] PLACE  = 4'd4;   // G·x - d
    localparam [3:0] BENT   = 4'd5;   // Σ C i
    localparam [3:0] SMALLER = 4'd6;  // whether waves are
    localparam [3:0] XI     = 4'd7;   // ξ of a set
    localparam [3:0] P      = 4'd8;   // a wave, saturated, and which way the exact one is beyond
    localparam [3:0] PAY    = 4'd9;   // p²
    localparam [3:0] GOAL   = 4'd10;  // η p
    localparam [3:0] FILTER = 4'd11;  // f's step
    localparam [3:0] ASK    = 4'd12;  // y²
    localparam [3:0] REFUSE = 4'd13;  // the square of y without ξ
    localparam [3:0] MOST   = 4'd14;  // a word without a product: the largest ξ
    localparam [3:0] ACROSS = 4'd15;  // η across

    reg  [3:0] phase_q;
    reg  [5:0] step_q;      // TEST: of a surface; ACT
    reg  [2:0] surface_q;   // TEST
    reg  [1:0] order_q;     // which of those that act
    reg  [1:0] port_q;
    reg        half_q;      // second product of a port
    reg        asks_q;      // products are still to be asked for
    reg  [2:0] wait_q;
    reg  [1:0] acting_q;    // surfaces that act,
    reg  [8:0] active_q;    // their numbers,
    reg  [2:0] fresh_q;     // and those whose contact begins

    wire [2:0] active_0 = active_q[2:0];
    wire [2:0] active_1 = active_q[5:3];
    wire [2:0] active_2 = active_q[8:6];
    wire [2:0] active   = (order_q == 2'd0) ? active_0 : (order_q == 2'd1) ? active_1 : active_2;

    // Rows of vectors: of the first, of the second beside it, of the third beside both.
    function [4:0] pair;  // t (t - 1)/2 + s
        input [2:0] s;
        input [2:0] t;
        begin
            case (t)
                3'd2:    pair = 5'd1;
                3'd3:    pair = 5'd3;
                3'd4:    pair = 5'd6;
                3'd5:    pair = 5'd10;
                3'd6:    pair = 5'd15;
                3'd7:    pair = 5'd21;
                default: pair = 5'd0;
            endcase
            pair = pair + {2'd0, s};
        end
    endfunction

    function [6:0] triple;  // 36 + r (r - 1)(r - 2)/6
        input [2:0] r;
        begin
            case (r)
                3'd3:    triple = 7'd37;
                3'd4:    triple = 7'd40;
                3'd5:    triple = 7'd46;
                3'd6:    triple = 7'd56;
                3'd7:    triple = 7'd71;
                default: triple = 7'd36;
            endcase
        end
    endfunction

    wire [4:0] pair_row = pair(active_0, active_1);
    wire       beside   = phase_q == BESIDE || phase_q == SECOND;
    wire       acts     = phase_q == ACT || phase_q == TURN;
    wire [6:0] vector   = (beside || (acts && order_q == 2'd1)) ? 7'd8 + {2'd0, pair_row}
                          : (acts && order_q == 2'd2)           ? triple(active_2) + {2'd0, pair_row}
                                                                : {4'd0, active_0};
    wire [6:0] plane    = {3'b110, active, 1'b0};  // its first row

    // What a step asks for.
    reg        ask;
    reg  [3:0] factor;
    reg  [2:0] by;
    reg  [6:0] row;
    reg  [2:0] word;
    reg        first;  // product of a sum
    reg        less;   // taken off
    reg        cut;    // without its fraction: downwards if added, toward zero if taken off
    reg  [3:0] is;
    reg  [3:0] to;
    wire       last_port = port_q == LAST[1:0];
    wire       starts    = phase_q == IDLE && valid_i && port_i == LAST[1:0];
    wire [2:0] of        = (phase_q == TEST) ? surface_q : {1'b0, order_q};
    wire [1:0] test_port = step_q[1:0] - 2'd2;
    wire [1:0] acts_port = step_q[1:0] - 2'd3;

    always @* begin
        ask    = asks_q;
        factor = {WAVE, port_q};
        by     = BY_WORD;
        row    = vector;
        word   = {1'b0, port_q};
        first  = !half_q;
        less   = 1'b0;
        cut    = 1'b0;
        is     = NONE;
        to     = {WAVE, port_q};
        case (phase_q)
            IDLE: begin
                ask  = 1'b0;
                row  = 7'd112;
                word = 3'd0;
                is   = starts ? MOST : NONE;
            end
            TEST: begin
                factor = {POSITION, test_port};
                by     = (step_q == 6'd0) ? WHOLE : (step_q == 6'd1) ? PART : BY_WORD;
                row    = {3'b110, surface_q, 1'b0};
                word   = step_q[2:0];
                first  = step_q == 6'd0;
                is     = (step_q == LAST[5:0] + 6'd2 && asks_q) ? PLACE : NONE;
            end
            BEND: begin
                factor = {CURRENT, port_q};
                row    = plane;
                word   = 3'd5 + {1'b0, port_q};
                first  = port_q == 2'd0;
                cut    = 1'b1;
                is     = (last_port && asks_q) ? BENT : NONE;
            end
            MOVE: begin
                ask    = asks_q && half_q;
                factor = {REST, order_q};
                row    = plane | 7'd1;
                word   = half_q ? 3'd0 : 3'd3;
                first  = 1'b1;
                less   = 1'b1;
                is     = !asks_q ? NONE : half_q ? LIMIT : ACROSS;
                to     = {POSITION, order_q};
            end
            ALONG: begin
                first  = port_q == 2'd0;
                is     = (last_port && asks_q) ? P : NONE;
                to     = AT_P;
            end
            KEEP: begin
                factor = AT_P;
                by     = BY_LOSS;
                is     = asks_q ? WIDE : NONE;
                to     = AT_NEXT;
            end
            LOSE: begin
                factor = half_q ? AT_NEXT : {WAVE, port_q};
                by     = half_q ? BY_WORD : BY_LOSS;
                is     = (half_q && asks_q) ? VALUE : NONE;
            end
            FIRST, SECOND: begin
                factor = half_q ? AT_P : {(phase_q == FIRST) ? WAVE : REST, port_q};
                by     = half_q ? BY_WORD : BY_ONE;
                less   = half_q;
                cut    = half_q;
                is     = (half_q && asks_q) ? WIDE : NONE;
                to     = {REST, port_q};
            end
            BESIDE: begin
                factor = {REST, port_q};
                first  = port_q == 2'd0;
                is     = (last_port && asks_q) ? WIDE : NONE;
                to     = AT_P;
            end
            LESS: begin
                factor = {half_q ? REST : WAVE, port_q};
                by     = half_q ? BY_LOSS : BY_ONE;
                less   = half_q;
                cut    = half_q;
                is     = (half_q && asks_q) ? VALUE : NONE;
                to     = {REST, port_q};
            end
            JUDGE: begin
                factor = {half_q ? REST : WAVE, port_q};
                by     = BY_ITSELF;
                first  = !half_q && port_q == 2'd0;
                less   = half_q;
                is     = (half_q && last_port && asks_q) ? SMALLER : NONE;
            end
            CHOOSE: begin
                factor = {smaller_q ? REST : WAVE, port_q};
                by     = BY_ONE;
                first  = 1'b1;
                is     = asks_q ? VALUE : NONE;
            end
            ACT: begin
                ask = 1'b1;
                to  = AT_P;
                case (step_q)
                    6'd0, 6'd1, 6'd2: begin  // of the set's wall velocities
                        ask    = step_q[1:0] <= order_q;
                        factor = {POSITION, step_q[1:0]};
                        word   = 3'd3 + step_q[2:0];
                        first  = step_q == 6'd0;
                        is     = (step_q[1:0] == order_q) ? XI : NONE;
                    end
                    6'd3, 6'd4, 6'd5: begin
                        ask    = acts_port <= LAST[1:0];
                        factor = {WAVE, acts_port};
                        word   = {1'b0, acts_port};
                        first  = step_q == 6'd3;
                        is     = (acts_port == LAST[1:0]) ? P : NONE;
                    end
                    6'd11: begin
                        factor = AT_P;
                        by     = BY_ITSELF;
                        first  = 1'b1;
                        is     = PAY;
                    end
                    6'd12: begin
                        factor = AT_P;
                        row    = plane | 7'd1;
                        word   = 3'd2;
                        first  = 1'b1;
                        is     = GOAL;
                        to     = AT_NEXT;
                    end
                    6'd18: begin
                        factor = AT_NEXT;
                        row    = plane | 7'd1;
                        word   = 3'd1;
                        first  = 1'b1;
                        is     = FILTER;
                    end
                    6'd27: begin
                        factor = AT_Y;
                        by     = BY_ITSELF;
                        first  = 1'b1;
                        is     = ASK;
                    end
                    6'd28: begin
                        factor = AT_RESTING;
                        by     = BY_ITSELF;
                        first  = 1'b1;
                        is     = REFUSE;
                    end
                    default: ask = 1'b0;
                endcase
            end
            TURN: begin
                factor = half_q ? AT_NEXT : {WAVE, port_q};
                by     = half_q ? BY_WORD : BY_ONE;
                is     = (half_q && asks_q) ? VALUE : NONE;
            end
            default: ask = 1'b0;  // OUT
        endcase
    end

    assign take_o = starts;
    assign row_o  = row;
    assign word_o = word;

    // ---- From phase to phase.
    localparam [5:0] ACT_END = 6'd33;

    wire       ends    = (phase_q == ACT) ? step_q == ACT_END : !asks_q && wait_q == 3'd0;
    wire       more    = order_q + 2'd1 != acting_q;
    wire       loops   = phase_q == TURN && more;   // one more acts
    reg  [3:0] next;

    always @* begin
        case (phase_q)
            TEST:    next = (acting_q == 2'd0) ? OUT : BEND;
            BEND:    next = MOVE;
            MOVE:    next = loses ? ALONG : ACT;
            ALONG:   next = (acting_q == 2'd1) ? KEEP : FIRST;
            KEEP:    next = LOSE;
            FIRST:   next = BESIDE;
            BESIDE:  next = SECOND;
            SECOND:  next = LESS;
            LESS:    next = JUDGE;
            JUDGE:   next = CHOOSE;
            ACT:     next = TURN;
            TURN:    next = more ? ACT : OUT;
            default: next = ACT;  // LOSE, CHOOSE
        endcase
    end

    // The last product of a phase, in which ports come one after the other, with one or two of each.
    wire by_halves = phase_q == LOSE || phase_q == FIRST || phase_q == SECOND || phase_q == LESS || phase_q == JUDGE
                     || phase_q == TURN;
    wire port_ends = half_q || !by_halves;

    always @(posedge clk) begin
        if (starts) begin
            phase_q   <= TEST;
            step_q    <= 6'd0;
            surface_q <= 3'd0;
            asks_q    <= 1'b1;
        end else if (phase_q == OUT) begin
            port_q  <= port_q + 2'd1;
            if (last_port) begin
                phase_q <= IDLE;
            end
        end else if (phase_q != IDLE && ends) begin
            phase_q <= next;
            step_q  <= 6'd0;
            port_q  <= 2'd0;
            half_q  <= 1'b0;
            asks_q  <= 1'b1;
            order_q <= (phase_q == TURN && more) ? order_q + 2'd1 : (next == TURN) ? order_q : 2'd0;
        end else if (!asks_q) begin
            wait_q <= wait_q - 3'd1;
        end else begin
            case (phase_q)
                TEST: begin
                    wait_q <= WAIT[2:0];
                    step_q <= step_q + 6'd1;
                    if (step_q == LAST[5:0] + 6'd2) begin
                        step_q    <= 6'd0;
                        surface_q <= surface_q + 3'd1;
                        asks_q    <= surface_q != END[2:0];
                    end
                end
                BEND: begin
                    wait_q <= WAIT[2:0];
                    port_q <= last_port ? 2'd0 : port_q + 2'd1;
                    if (last_port) begin
                        order_q <= order_q + 2'd1;
                        asks_q  <= more;
                    end
                end
                MOVE: begin
                    wait_q <= WAIT[2:0] - 3'd1;
                    half_q <= 1'b1;
                    if (half_q) begin
                        order_q <= order_q + 2'd1;
                        asks_q  <= more;
                    end
                end
                ACT: step_q <= step_q + 6'd1;
                default: begin
                    wait_q <= (loops) ? WAIT[2:0] - 3'd5 : WAIT[2:0] - 3'd2;
                    half_q <= by_halves && !half_q;
                    if (port_ends) begin
                        port_q <= port_q + 2'd1;
                        asks_q <= !last_port && phase_q != KEEP;
                    end
                end
            endcase
        end
        if (rst) begin
            phase_q <= IDLE;
        end
    end

    // ---- What was asked for comes through the multiplier: field n of these is n clocks old.
    reg  [4:1]  asked_q;
    reg  [4:1]  firsts_q, lesses_q, cuts_q;
    reg  [23:0] is_q;   // four bits for each clock, the newest lowest
    reg  [23:0] to_q;
    reg  [17:0] of_q;
    reg  [3:0]  factor_q;
    reg  [2:0]  by_q;

    wire [3:0]  is_1 = is_q[3:0];
    wire [3:0]  is_5 = is_q[19:16];
    wire [3:0]  is_6 = is_q[23:20];
    wire [3:0]  to_6 = to_q[23:20];
    wire [2:0]  of_6 = of_q[17:15];

    always @(posedge clk) begin
        factor_q <= (phase_q == OUT) ? {WAVE, port_q} : factor;
        by_q     <= by;
        firsts_q <= {firsts_q[3:1], first};
        lesses_q <= {lesses_q[3:1], less};
        cuts_q   <= {cuts_q[3:1], cut};
        to_q     <= {to_q[19:0], to};
        of_q     <= {of_q[14:0], of};
        asked_q  <= rst ? 4'd0 : {asked_q[3:1], ask && phase_q != IDLE};
        is_q     <= rst ? {6{NONE}} : {is_q[19:0], is};
    end

    // ---- Registers of the multiplier's.
    (* no_rw_check *)
    reg  signed [WIDE_W-1:0] registers [0:15];
    wire signed [WIDE_W-1:0] read = registers[factor_q];
    reg                      saves;
    reg  [3:0]               save_at;
    reg  signed [WIDE_W-1:0] saved;

    always @(posedge clk) begin
        if (saves) begin
            registers[save_at] <= saved;
        end
    end

    wire signed [WIDE_W-1:0] data = (by_q == WHOLE)  ? -$signed({{(WIDE_W - 1){1'b0}}, 1'b1} << Q)
                                    : (by_q == PART) ? -$signed({{(WIDE_W - 1){1'b0}}, 1'b1} << (Q - `WH_DISTANCE_Q))
                                                     : read;
    reg  [Q:0]               loss_q;   // 1 - η across, and η at last
    reg  signed [WORD_W-1:0] coefficient;

    always @* begin
        case (by_q)
            BY_ONE:    coefficient = $signed({{(WORD_W - 1){1'b0}}, 1'b1} << Q);
            BY_ITSELF: coefficient = $signed(read[WORD_W-1:0]);
            BY_LOSS:   coefficient = $signed({{(WORD_W - 1 - Q){1'b0}}, loss_q});
            default:   coefficient = $signed(word_i[WORD_W-1:0]);
        endcase
    end

    wire signed [WIDE_W+WORD_W-1:0] product;

    wh_multiply #(
        .DATA_W    (WIDE_W),
        .COEF_W    (WORD_W),
        .LIMB_W    (16)
    ) multiply (
        .clk       (clk),
        .take_i    (1'b1),
        .data_i    (data),
        .coef_i    (coefficient),
        .product_o (product)
    );

    // ---- Sums. A fraction that is cut off a product that is taken off is cut toward zero: one that is negative
    // goes up by one, which is a carry less.
    reg  signed [SUM_W-1:0] sum_q;
    wire                    up    = product[SUM_W-1] && (|product[Q-1:0]);
    wire                    carry = lesses_q[4] && !(cuts_q[4] && up);
    wire [Q-1:0]            low   = cuts_q[4] ? {Q{carry}} : product[Q-1:0] ^ {Q{lesses_q[4]}};
    wire [SUM_W-1:0]        added = {product[SUM_W-1:Q] ^ {(SUM_W - Q){lesses_q[4]}}, low};
    wire                    unused_product = &{1'b0, product[WIDE_W+WORD_W-1:SUM_W]};

    always @(posedge clk) begin
        if (asked_q[4]) begin
            sum_q <= $signed((firsts_q[4] ? {SUM_W{1'b0}} : sum_q) + added + {{(SUM_W - 1){1'b0}}, carry});
        end
    end

    // ---- A sum without its fraction.
    reg  signed [VALUE_W-1:0] value_q;
    reg                       exact_q;     // nothing was cut off
    reg                       negative_q;  // it was below 0
    reg                       smaller_q;
    wire                      fraction = |sum_q[Q-1:0];
    wire                      sum_sign = sum_q[SUM_W-1];

    always @(posedge clk) begin
        value_q <= $signed(sum_q[SUM_W-1:Q]) + $signed({{(VALUE_W - 1){1'b0}}, sum_sign && fraction});
        exact_q    <= !fraction;
        negative_q <= sum_sign;
        if (is_5 == SMALLER) begin
            smaller_q <= !sum_sign;
        end
    end

    wire signed [DATA_W-1:0] value;
    wire                     value_sign = value_q[VALUE_W-1];
    wire                     beyond     = value_q[VALUE_W-1:DATA_W-1] != {(VALUE_W - DATA_W + 1){value_sign}};

    wh_saturate #(
        .IN_W    (VALUE_W),
        .OUT_W   (DATA_W)
    ) saturate_value (
        .value_i (value_q),
        .value_o (value)
    );

    // A place, in the fraction of ε, as far as a deflection can change it.
    localparam integer PLACE_W = WIDE_W;
    reg  signed [PLACE_W-1:0] place_q;
    wire signed [PLACE_W-1:0] place;

    wh_saturate #(
        .IN_W    (SUM_W - PLACE_Q),
        .OUT_W   (PLACE_W)
    ) saturate_place (
        .value_i ($signed(sum_q[SUM_W-1:PLACE_Q])),
        .value_o (place)
    );

    // ---- Contact.
    reg  [7:0]                touching_q;
    reg  signed [PLACE_W-1:0] places [0:3];   // of those that act
    wire [2:0]                tested   = of_6;
    wire                      tests    = is_6 == PLACE;
    wire                      touches  = present_i[tested] && !place_q[PLACE_W-1] && acting_q != 2'd3;
    wire                      leaves   = tests && !touches && touching_q[tested];
    reg                       left_behind_q;  // the clock after it

    always @(posedge clk) begin
        place_q       <= place;
        left_behind_q <= leaves && !rst;
        if (starts) begin
            acting_q <= 2'd0;
        end else if (tests && touches) begin
            acting_q <= acting_q + 2'd1;
            case (acting_q)
                2'd0:    active_q[2:0] <= tested;
                2'd1:    active_q[5:3] <= tested;
                default: active_q[8:6] <= tested;
            endcase
            fresh_q[acting_q] <= !touching_q[tested];
            places[acting_q]  <= place_q;
        end
        if (tests) begin
            touching_q[tested] <= touches;
        end
        if (rst) begin
            touching_q <= 8'd0;
        end
    end

    // ---- ε: how deep, and how far the springs are bent. Clocks 7, 8 and 9 of a sum.
    localparam signed [DATA_W-1:0] HALF = (`WH_SEEN_Q > 0) ? (1 << `WH_SEEN_Q) >> 1 : 0;

    reg  [9:7]               bent_q;
    reg  [1:0]               bent_order_q, bent_after_q, bent_last_q;
    reg  signed [DATA_W-1:0] bend_q;
    reg  signed [DATA_W:0]   deflection_q;
    reg  signed [DATA_W-1:0] error_q;
    reg  signed [DATA_W-1:0] rests [0:7];
    wire [2:0]               bent_surface = (bent_order_q == 2'd0) ? active_0
                                            : (bent_order_q == 2'd1) ? active_1 : active_2;
    wire                     alone        = acting_q == 2'd1;
    wire signed [DATA_W-1:0] rest         = alone                   ? {DATA_W{1'b0}}
                                            : fresh_q[bent_order_q] ? bend_q : rests[bent_surface];
    wire signed [PLACE_W:0]  deep         = places[bent_after_q]
                                            + $signed({{(PLACE_W - DATA_W){deflection_q[DATA_W]}}, deflection_q});
    wire signed [DATA_W-1:0] error;
    wire signed [DATA_W-1:0] outside      = error_q + (error_q[DATA_W-1] ? HALF : -HALF);
    wire                     far          = outside[DATA_W-1] == error_q[DATA_W-1];

    wh_saturate #(
        .IN_W    (PLACE_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_error (
        .value_i (deep),
        .value_o (error)
    );

    always @(posedge clk) begin
        bent_q       <= rst ? 3'd0 : {bent_q[8:7], is_6 == BENT};
        bent_order_q <= of_6[1:0];
        bent_after_q <= bent_order_q;
        bent_last_q  <= bent_after_q;
        bend_q       <= value;
        deflection_q <= bend_q - rest;
        error_q      <= error;
        if (bent_q[7]) begin
            rests[bent_surface] <= rest;
        end
    end

    // ---- Velocities, within the largest: a clock after other values.
    reg  signed [DATA_W-1:0] most_q;
    reg  signed [DATA_W-1:0] xi_q;
    reg                      limited_q;   // ξ of a surface is there
    reg                      mixed_q;     // that of a set is
    reg  [3:0]               to_7_q;
    wire signed [DATA_W:0]   past    = $signed({bend_q[DATA_W-1], bend_q})
                                       + (bend_q[DATA_W-1] ? $signed({1'b0, most_q}) : -$signed({1'b0, most_q}));
    wire                     limits  = past[DATA_W] == bend_q[DATA_W-1];
    wire signed [DATA_W-1:0] limited = !limits ? bend_q : bend_q[DATA_W-1] ? -most_q : most_q;

    always @(posedge clk) begin
        if (is_1 == MOST) begin
            most_q <= $signed(word_i[DATA_W-1:0]);
        end
        limited_q <= is_6 == LIMIT && !rst;
        mixed_q   <= is_6 == XI;
        to_7_q    <= to_6;
        if (mixed_q) begin
            xi_q <= limited;
        end
    end

    // ---- Loss across: of one surface its own, if that is more than in free space.
    reg signed [COEF_W-1:0] eta_q;
    reg                     across_q;
    wire signed [COEF_W-1:0] across = $signed(word_i[COEF_W-1:0]);
    wire signed [COEF_W-1:0] one    = {{(COEF_W - 1){1'b0}}, 1'b1} << Q;
    wire                     loses  = eta_q < one && acting_q != 2'd3;

    always @(posedge clk) begin
        across_q <= is_1 == ACROSS;
        if (is_1 == ACROSS) begin
            eta_q <= (alone && across < free_i) ? across : free_i;
        end
        if (across_q) begin
            loss_q <= eta_q[COEF_W-1] ? one[Q:0] : one[Q:0] - eta_q[Q:0];
        end else if (phase_q == KEEP && ends) begin
            loss_q <= one[Q:0] - loss_q;
        end
    end

    // ---- A surface's filter: f's step, its loss, its limits, in clocks 5, 6 and 7 of a sum; y in 8 and 9.
    localparam integer STEP_W = STATE_W + 3;

    reg  signed [STATE_W-1:0] filters [0:7];
    reg  signed [STATE_W-1:0] f_q;
    reg  signed [DATA_W:0]    goal_q;
    reg  [COEF_W-1:0]         a_q;
    reg  signed [STEP_W-1:0]  step_sum_q;
    reg  signed [STEP_W-1:0]  f_sum_q;
    reg                       f_sign_q;
    reg  [9:7]                filtered_q;
    reg  signed [DATA_W-1:0]  resting_q, y_q;
    wire                      whole    = a_q[Q];  // a = 1
    wire [2:0]                in_turn  = (phase_q == TEST) ? tested : active;
    wire                      begins   = fresh_q[order_q];
    wire                      loads    = phase_q == ACT && step_q == 6'd11;
    wire signed [DATA_W:0]    error_f  = $signed(value_q[DATA_W:0]) - $signed({{(DATA_W + 1 - STATE_W + GUARD)
                                             {f_q[STATE_W-1]}}, f_q[STATE_W-1:GUARD]})
                                         - $signed({{DATA_W{1'b0}}, |f_q[GUARD-1:0]});
    wire signed [STEP_W-1:0]  a_loss   = $signed({{(STEP_W - COEF_W + A_CUT){1'b0}}, a_q[COEF_W-1:A_CUT]});
    wire                      f_crosses = f_sum_q[STEP_W-1] != f_sign_q;
    wire                      f_far     = f_sum_q[STEP_W-1:STATE_W-1] != {(STEP_W - STATE_W + 1){f_sign_q}}
                                          || (&(f_sum_q[STATE_W-2:GUARD] ^ {(DATA_W - 1){f_sign_q}}));
    wire [DATA_W-2:0]         f_high    = {(DATA_W - 1){1'b1}};
    wire signed [STATE_W-1:0] f_limit   = {1'b0, f_high, {GUARD{1'b0}}};
    wire signed [DATA_W-1:0]  resting   = $signed(f_q[STATE_W-1:GUARD])
                                          + $signed({{(DATA_W - 1){1'b0}}, f_q[STATE_W-1] && (|f_q[GUARD-1:0])});
    wire signed [DATA_W:0]    y_wide    = resting_q + xi_q;
    wire signed [DATA_W-1:0]  y;

    wh_saturate #(
        .IN_W    (DATA_W + 1),
        .OUT_W   (DATA_W)
    ) saturate_y (
        .value_i (y_wide),
        .value_o (y)
    );

    always @(posedge clk) begin
        filtered_q <= rst ? 3'd0 : {filtered_q[8:7], is_6 == FILTER};
        if (is_1 == FILTER) begin
            a_q <= word_i[COEF_W-1:0];
        end
        if (is_6 == GOAL) begin
            goal_q <= $signed(value_q[DATA_W:0]);
        end
        step_sum_q <= $signed({{(STEP_W - STATE_W){f_q[STATE_W-1]}}, f_q}) + $signed(sum_q[A_CUT +: STEP_W]);
        f_sign_q   <= whole ? goal_q[DATA_W] : step_sum_q[STEP_W-1];
        f_sum_q    <= whole ? $signed({{(STEP_W - DATA_W - 1 - GUARD){goal_q[DATA_W]}}, goal_q, {GUARD{1'b0}}})
                      : step_sum_q + (step_sum_q[STEP_W-1] ? a_loss + {{(STEP_W - 2){1'b0}}, 2'd2} : ~a_loss);
        if (loads) begin
            f_q <= begins ? {STATE_W{1'b0}} : filters[in_turn];
        end else if (filtered_q[7]) begin
            f_q <= f_crosses ? {STATE_W{1'b0}}
                   : !f_far  ? f_sum_q[STATE_W-1:0] : f_sign_q ? -f_limit : f_limit;
        end
        if (filtered_q[8]) begin
            resting_q <= resting;
        end
        if (filtered_q[9]) begin
            y_q <= y;
        end
    end

    // ---- What y may be: accounts.
    reg  [ACCOUNT_W-1:0]    accounts [0:7];
    reg  signed [SUM_W-1:0] account_q;
    reg  [ACCOUNT_W-1:0]    spent_q;    // of the budget
    reg  [ACCOUNT_W-1:0]    budget_q;   // what is left of it
    reg  [SUM_W-2:0]        funds_q;
    reg  [2:1]              paid_q;
    reg                     asked_y_q;  // y is covered,
    reg                     asked_r_q;  // or else y without ξ
    reg  [2:1]              settles_q;
    wire                    pays    = is_5 == PAY;
    wire signed [SUM_W-1:0] account = account_q + $signed(pays ? sum_q : ~sum_q)
                                      + $signed({{(SUM_W - 1){1'b0}}, !pays});
    wire signed [SUM_W-1:0] funds   = $signed({2'b00, budget_q}) + account_q;
    wire                    unused_funds = &{1'b0, funds[SUM_W-1]};
    wire                    covered = {1'b0, funds_q} >= sum_q;
    wire signed [SUM_W-1:0] spent   = $signed({2'b00, spent_q}) - account_q;
    wire        [ACCOUNT_W:0] room  = {1'b0, budget_i} - {1'b0, spent_q};
    wire                    unused_spent = &{1'b0, spent[SUM_W-2]};
    wire                    asks_y  = is_5 == ASK;
    wire                    asks_r  = is_5 == REFUSE && !asked_y_q;

    always @(posedge clk) begin
        paid_q    <= rst ? 2'd0 : {paid_q[1], pays};
        settles_q <= rst ? 2'd0 : {settles_q[1], is_5 == REFUSE};
        if (leaves || loads) begin
            account_q <= (loads && begins) ? {SUM_W{1'b0}} : $signed({2'b00, accounts[in_turn]});
        end else if (pays || ((asks_y || asks_r) && covered)) begin
            account_q <= account;
        end else if (paid_q[1] && (|account_q[SUM_W-2:SUM_W-3])) begin
            account_q <= $signed({3'b001, {(SUM_W - 3){1'b0}}});
        end else if (settles_q[1] && account_q[SUM_W-1]) begin
            account_q <= {SUM_W{1'b0}};
        end
        if (paid_q[2]) begin
            funds_q <= funds[SUM_W-2:0];
        end
        if (asks_y) begin
            asked_y_q <= covered;
        end
        if (is_5 == REFUSE) begin
            asked_r_q <= covered;
        end
        // A surface that is left pays back what its account has; one whose y was more than its account owes the rest.
        if (left_behind_q || (settles_q[1] && account_q[SUM_W-1])) begin
            spent_q <= spent[SUM_W-1] ? {ACCOUNT_W{1'b0}} : spent[ACCOUNT_W-1:0];
        end
        // The budget may change at any time.
        budget_q <= room[ACCOUNT_W] ? {ACCOUNT_W{1'b0}} : room[ACCOUNT_W-1:0];
        if (settles_q[2]) begin
            accounts[active] <= account_q[ACCOUNT_W-1:0];
            filters[active]  <= f_q;
        end
        if (rst) begin
            spent_q <= {ACCOUNT_W{1'b0}};
        end
    end

    // ---- By how much the waves along g change. Where y goes further than p the other way, the exact p counts.
    reg  signed [DATA_W-1:0] p_q;
    reg                      p_exact_q, p_beyond_q, p_sign_q;
    reg  signed [DATA_W:0]   change_q;
    wire signed [DATA_W-1:0] given    = asked_y_q ? y_q : asked_r_q ? resting_q : {DATA_W{1'b0}};
    wire                     further  = !p_exact_q && (|change_q) && change_q[DATA_W] == p_sign_q;
    wire signed [DATA_W:0]   change   = !further    ? change_q
                                        : p_beyond_q ? {(DATA_W + 1){1'b0}}
                                                     : change_q + $signed({{DATA_W{!p_sign_q}}, 1'b1});

    always @(posedge clk) begin
        if (is_6 == P) begin
            p_q        <= value;
            p_exact_q  <= exact_q && !beyond;
            p_beyond_q <= beyond;
            p_sign_q   <= negative_q;
        end
        change_q <= given - p_q;
    end

    // ---- What is saved, and where.
    reg [2:1] came_q;   // a port's position is taken at once, current and wave follow

    always @(posedge clk) begin
        came_q <= rst ? 2'd0 : {came_q[1], valid_i};
    end

    always @* begin
        saves   = 1'b1;
        save_at = to_6;
        saved   = $signed({{(WIDE_W - DATA_W){value[DATA_W-1]}}, value});
        if (is_6 == VALUE || is_6 == P) begin
            saves = 1'b1;
        end else if (is_6 == WIDE) begin
            saved = $signed(value_q[WIDE_W-1:0]);
        end else if (limited_q) begin
            save_at = to_7_q;
            saved   = $signed({{(WIDE_W - DATA_W){limited[DATA_W-1]}}, limited});
        end else if (is_6 == GOAL) begin
            saved = $signed({error_f[DATA_W], error_f});
        end else if (bent_q[9]) begin
            save_at = {REST, bent_last_q};
            saved   = far ? $signed({outside, {XI_UP{1'b0}}}) : {WIDE_W{1'b0}};
        end else if (filtered_q[8]) begin
            save_at = AT_RESTING;
            saved   = $signed({{(WIDE_W - DATA_W){resting[DATA_W-1]}}, resting});
        end else if (filtered_q[9]) begin
            save_at = AT_Y;
            saved   = $signed({{(WIDE_W - DATA_W){y[DATA_W-1]}}, y});
        end else if (settles_q[2]) begin
            save_at = AT_NEXT;
            saved   = $signed({change[DATA_W], change});
        end else if (valid_i) begin
            save_at = {POSITION, port_i};
            saved   = $signed({{(WIDE_W - `WH_COUNT_W){position_i[`WH_COUNT_W-1]}}, position_i});
        end else if (came_q[1]) begin
            save_at = {CURRENT, port_i};
            saved   = $signed({{(WIDE_W - DATA_W){current_i[DATA_W-1]}}, current_i});
        end else if (came_q[2]) begin
            save_at = {WAVE, port_i};
            saved   = $signed({{(WIDE_W - DATA_W){wave_i[DATA_W-1]}}, wave_i});
        end else begin
            saves   = 1'b0;
        end
    end

    // ---- Results.
    reg                      out_q, valid_q;
    reg [1:0]                out_port_q, valid_port_q;
    reg signed [DATA_W-1:0]  wave_q;
    reg [1:0]                acted_q;

    always @(posedge clk) begin
        out_q        <= phase_q == OUT && !rst;
        out_port_q   <= port_q;
        valid_q      <= out_q && !rst;
        valid_port_q <= out_port_q;
        wave_q       <= $signed(read[DATA_W-1:0]);
        if (out_q) begin
            acted_q  <= acting_q;
        end
        if (rst) begin
            acted_q  <= 2'd0;
        end
    end

    assign busy_o   = phase_q != IDLE || out_q || valid_q;
    assign valid_o  = valid_q;
    assign port_o   = valid_port_q;
    assign wave_o   = wave_q;
    assign acting_o = acted_q;

endmodule

`default_nettype wire
