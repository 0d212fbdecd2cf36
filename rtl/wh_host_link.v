// SPDX-License-Identifier: Apache-2.0
//
// wh_host_link: one port's link to an environment that runs on a computer.
//
//   v_mean = mean of v over a period of 2^period_log2_i ticks, toward zero, with a number
//   u      = the host's answer, for a whole period, as far as the budget covers it:
//            budget += v_mean^2, budget -= u^2; a u that is not covered is halved until it is
//
// While active_o is high, the wave core has eta = 0 and u_o as its wave from outside. Then the port can't give out
// energy, whether the host answers late, twice, never or anything: the mean has at most the energy that came in, and
// the budget pays for every period of u.
//
// An answer counts if its number is newer than any that counted, and less than 128 periods old. The newest one of a
// period is taken at its end, if it came at least 80 clocks before; without one u is held. After timeout_i such periods
// in a row active_o falls, and the budget is emptied.
// sim/wavehaptics/controller/host_link.py is the same with integers, and this module equals it bit for bit.
// Formats: waves s31q23 √W; the budget in squares of a wave's LSB, limited at 2^62 - 1.
// Latency: u_o and active_o change 1 clock after the valid_i that ends a period, strobe_o comes 3 + period_log2_i
// clocks after it, and v_mean^2 is in the budget 33 clocks later. A period is longer than all that, 150 clocks.
// Reset: not active, u and v_mean 0, the next packet is number 1.

`default_nettype none
`include "wh_formats.vh"

module wh_host_link (
    input  wire                         clk,
    input  wire                         rst,

    input  wire        [3:0]            period_log2_i,
    input  wire        [7:0]            timeout_i,      // periods, 1...

    // The wave core's step.
    input  wire                         valid_i,        // strobe, a tick
    input  wire signed [`WH_DATA_W-1:0] v_i,            // s31q23 √W, ±128 √W: v_n
    output reg                          active_o,
    output reg  signed [`WH_DATA_W-1:0] u_o,            // s31q23 √W, ±128 √W: the goal

    // To the host.
    output reg                          strobe_o,
    output wire        [7:0]            sequence_o,
    output reg  signed [`WH_DATA_W-1:0] v_mean_o,       // s31q23 √W, ±128 √W

    // From the host.
    input  wire                         strobe_i,
    input  wire        [7:0]            sequence_i,
    input  wire signed [`WH_DATA_W-1:0] u_i             // s31q23 √W, ±128 √W
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer SUM_W  = DATA_W + 16;
    localparam integer TANK_W = 2 * DATA_W;
    localparam integer LAST   = DATA_W + 1;  // clocks of a square, one for each bit and one to end

    // ---- The sum of a period.
    reg  signed [SUM_W-1:0] sum_q;
    reg         [15:0]      ticks_q;

    wire signed [SUM_W-1:0] total = sum_q + $signed({{(SUM_W - DATA_W){v_i[DATA_W-1]}}, v_i});
    wire        [15:0]      next_ticks = ticks_q + 16'd1;
    wire                    ends = valid_i && next_ticks[period_log2_i];

    always @(posedge clk) begin
        if (rst) begin
            sum_q   <= {SUM_W{1'b0}};
            ticks_q <= 16'd0;
        end else if (valid_i) begin
            sum_q   <= ends ? {SUM_W{1'b0}} : total;
            ticks_q <= ends ? 16'd0 : next_ticks;
        end
    end

    // ---- The mean: magnitude, a place a clock, and its sign again.
    reg         [SUM_W-1:0] shift_q;
    reg                     shift_negative_q;
    reg                     negate_q;
    reg                     shifting_q;
    reg         [3:0]       places_q;
    reg                     mean_q;   // shift_q holds the mean's magnitude

    wire signed [DATA_W-1:0] mean_magnitude = $signed(shift_q[DATA_W-1:0]);

    always @(posedge clk) begin
        if (ends) begin
            shift_q          <= total;
            shift_negative_q <= total[SUM_W-1];
            places_q         <= period_log2_i;
        end else if (negate_q) begin
            shift_q <= shift_negative_q ? -shift_q : shift_q;
        end else if (shifting_q && places_q != 4'd0) begin
            shift_q  <= shift_q >> 1;
            places_q <= places_q - 4'd1;
        end
        if (mean_q) begin
            v_mean_o <= shift_negative_q ? -mean_magnitude : mean_magnitude;
        end
        if (rst) begin
            negate_q   <= 1'b0;
            shifting_q <= 1'b0;
            mean_q     <= 1'b0;
            strobe_o   <= 1'b0;
            v_mean_o   <= {DATA_W{1'b0}};
        end else begin
            negate_q   <= ends;
            shifting_q <= !ends && (negate_q || (shifting_q && places_q != 4'd0));
            mean_q     <= !ends && shifting_q && places_q == 4'd0;
            strobe_o   <= mean_q;
        end
    end

    // ---- What the host says: newer than all that counted, or nothing.
    reg        [7:0]        sequence_q;
    reg        [7:0]        age_q;      // of the newest that counted, 128 at most
    reg                     come_q;
    reg        [7:0]        come_sequence_q;
    reg signed [DATA_W-1:0] come_u_q;

    wire [7:0] age     = sequence_q - come_sequence_q;
    wire       counts  = come_q && !ends && age < age_q;

    assign sequence_o = sequence_q;

    always @(posedge clk) begin
        if (strobe_i) begin
            come_sequence_q <= sequence_i;
            come_u_q        <= u_i;
        end
        if (rst) begin
            sequence_q <= 8'd0;
            age_q      <= 8'd128;
            come_q     <= 1'b0;
        end else begin
            come_q <= strobe_i || (come_q && ends);
            if (ends) begin
                sequence_q <= sequence_q + 8'd1;
                age_q      <= age_q[7] ? 8'd128 : age_q + 8'd1;
            end else if (counts) begin
                age_q <= age;
            end
        end
    end

    // ---- Squares, by one adder: of the mean first, then of an answer.
    reg                 answer_q;         // an answer waits for its square
    reg  [DATA_W-1:0]   answer_magnitude_q;
    reg                 answer_negative_q;
    reg                 credit_q;         // this period's mean is to be paid in
    reg                 square_q;         // busy
    reg                 of_mean_q;
    reg  [5:0]          step_q;
    reg  [DATA_W-1:0]   factor_q;
    reg  [DATA_W-1:0]   high_q;
    reg  [DATA_W-1:0]   low_q;
    reg                 waiting_q;        // the mean is not there yet

    wire [DATA_W:0] partial = {1'b0, high_q} + (low_q[0] ? {1'b0, factor_q} : {(DATA_W+1){1'b0}});
    wire            done    = square_q && step_q == LAST[5:0];
    wire [TANK_W-1:0] square = {high_q, low_q};

    always @(posedge clk) begin
        if (mean_q) begin
            factor_q <= shift_q[DATA_W-1:0];
            low_q    <= shift_q[DATA_W-1:0];
            high_q   <= {DATA_W{1'b0}};
        end else if (!square_q && answer_q) begin
            factor_q <= answer_magnitude_q;
            low_q    <= answer_magnitude_q;
            high_q   <= {DATA_W{1'b0}};
        end else begin
            high_q <= partial[DATA_W:1];
            low_q  <= {partial[0], low_q[DATA_W-1:1]};
        end
        if (counts) begin
            answer_magnitude_q <= come_u_q[DATA_W-1] ? -come_u_q : come_u_q;
            answer_negative_q  <= come_u_q[DATA_W-1];
        end
        step_q <= square_q ? step_q + 6'd1 : 6'd1;
        if (mean_q) begin
            step_q <= 6'd1;
        end
        if (rst) begin
            answer_q  <= 1'b0;
            square_q  <= 1'b0;
            of_mean_q <= 1'b0;
            waiting_q <= 1'b0;
        end else begin
            if (ends) begin
                waiting_q <= 1'b1;
            end else if (mean_q) begin
                waiting_q <= 1'b0;
            end
            if (ends) begin
                square_q <= 1'b0;
            end else if (mean_q) begin
                square_q  <= 1'b1;
                of_mean_q <= 1'b1;
            end else if (counts && !of_mean_q) begin
                square_q <= 1'b0;
            end else if (done) begin
                square_q <= 1'b0;
                of_mean_q <= 1'b0;
            end else if (!square_q && answer_q && !waiting_q) begin
                square_q  <= 1'b1;
                of_mean_q <= 1'b0;
            end
            if (ends) begin
                of_mean_q <= 1'b0;
            end
            if (counts) begin
                answer_q <= 1'b1;
            end else if (done && !of_mean_q && !ends) begin
                answer_q <= 1'b0;
            end
        end
    end

    // ---- The budget, and the u that the next period will have if it ended now.
    reg  [TANK_W-1:0] tank_q;
    reg  [TANK_W-1:0] cost_q;
    reg  [DATA_W-1:0] magnitude_q;
    reg               negative_q;
    reg               fresh_q;     // it is a new answer, not the u that is held
    reg  [7:0]        silent_q;

    wire [TANK_W:0]   rest    = {1'b0, tank_q} - {1'b0, cost_q};
    wire              covered = !rest[TANK_W];
    wire [TANK_W:0]   paid    = {1'b0, tank_q} + {1'b0, square};
    // All is settled: the mean is paid in, no answer is on its way, and u is covered.
    wire              settled = covered && !waiting_q && !square_q && !answer_q && !come_q;
    wire              takes   = fresh_q && settled;
    // What the period makes of the silence beside that, so that only a choice is behind the subtraction.
    wire [7:0]        later        = (silent_q < timeout_i) ? silent_q + 8'd1 : silent_q;
    wire              later_active = active_o && later < timeout_i;
    wire [7:0]        next_silent  = takes ? 8'd0 : later;
    wire              next_active  = takes ? timeout_i != 8'd0 : later_active;

    wire signed [DATA_W-1:0] signed_magnitude = $signed(magnitude_q);

    always @(posedge clk) begin
        if (rst) begin
            tank_q      <= {TANK_W{1'b0}};
            cost_q      <= {TANK_W{1'b0}};
            magnitude_q <= {DATA_W{1'b0}};
            negative_q  <= 1'b0;
            fresh_q     <= 1'b0;
            silent_q    <= 8'd0;
            active_o    <= 1'b0;
            credit_q    <= 1'b0;
            u_o         <= {DATA_W{1'b0}};
        end else if (ends) begin
            silent_q <= next_silent;
            active_o <= next_active;
            credit_q <= active_o && next_active;
            fresh_q  <= fresh_q && !takes;
            if (!next_active) begin
                tank_q      <= {TANK_W{1'b0}};
                u_o         <= {DATA_W{1'b0}};
            end else if (settled) begin
                tank_q <= rest[TANK_W-1:0];
                u_o    <= negative_q ? -signed_magnitude : signed_magnitude;
            end else begin
                u_o <= {DATA_W{1'b0}};
            end
            if (!next_active && !fresh_q) begin
                cost_q      <= {TANK_W{1'b0}};
                magnitude_q <= {DATA_W{1'b0}};
            end
        end else begin
            if (done && of_mean_q && credit_q) begin
                tank_q <= paid[TANK_W] ? {TANK_W{1'b1}} : paid[TANK_W-1:0];
            end
            if (done && !of_mean_q && !counts) begin
                cost_q      <= square;
                magnitude_q <= answer_magnitude_q;
                negative_q  <= answer_negative_q;
                fresh_q     <= 1'b1;
            end else if (!covered && !waiting_q && !(square_q && of_mean_q)) begin
                cost_q      <= cost_q >> 2;
                magnitude_q <= magnitude_q >> 1;
            end
        end
    end

    wire unused = &{1'b0, shift_q[SUM_W-1:DATA_W]};

endmodule

`default_nettype wire
