// SPDX-License-Identifier: Apache-2.0
//
// wh_rows: chosen live words of a tick (wh_round_words), one after another, and what becomes of those of several ticks.
//
// A row has up to CHANNELS words, of the addresses in channel_i. It is made of 2^decimation_i ticks: of words
// with mean_i it has the mean, of those with any_i the bits that were there in any tick, of others what they were
// last. shift_i more bits are cut off below, rounding down. A tick is worked off from take_i on, which comes with
// idle_o.
//
//   turn_o   0 nothing to do; channel k's word comes in 1 + k, and code_o is its address a clock before; shift_i is
//            its in 3 + k, value_o in 4 + k;
//            CHANNELS + 4 is the tick's last one
//   last_o   the tick that is worked off is its row's last, for which value_o is the row's word
//   fresh_o  the next tick, and in take_i that one, is a row's first
//
// start_i takes the settings over, in a clock with idle_o and without take_i; a row begins then.
//
// Latency: as turn_o says. Reset: nothing is worked off.

`default_nettype none

module wh_rows #(
    parameter integer CHANNELS = 8   // 2...8
) (
    input  wire                         clk,
    input  wire                         rst,

    // The words of a tick.
    input  wire                         take_i,           // strobe, they are there
    output wire                         idle_o,           // no tick is worked off
    output wire                         reads_o,
    output wire [11:0]                  code_o,
    input  wire [31:0]                  word_i,
    input  wire                         mean_i,
    input  wire                         any_i,

    // Settings, taken over by a start.
    input  wire                         start_i,          // strobe
    input  wire [12*CHANNELS-1:0]       channel_i,        // addresses, the first lowest
    input  wire [3:0]                   decimation_i,     // a row is of 2^this ticks
    input  wire [3:0]                   shift_i,          // 0...15, of a channel in its turn

    // The rows.
    output wire                         fresh_o,
    output wire [3:0]                   turn_o,
    output wire                         last_o,
    output wire                         mean_o,           // with value_o: it is a mean
    output wire [31:0]                  value_o
);

    localparam integer SUM_W = 47;  // 2^15 words of 32 bits

    generate
        if (CHANNELS < 2 || CHANNELS > 8) begin : illegal
            wh_illegal_parameter_rows_channels_must_be_2_to_8 stop ();
        end
    endgenerate

    // ---- The channels' turns, one after another.

    localparam [31:0] CHANNELS_32 = CHANNELS;
    localparam [3:0]  CHOSEN_LAST = CHANNELS_32[3:0];
    localparam [3:0]  SUMMED_LAST = CHOSEN_LAST + 4'd2;
    localparam [3:0]  TURN_LAST   = CHOSEN_LAST + 4'd4;

    reg  [3:0]             turn_q;
    reg  [12*CHANNELS-1:0] codes_q;  // the turn's address lowest

    assign idle_o  = (turn_q == 4'd0);
    assign reads_o = (turn_q >= 4'd1) && (turn_q <= CHOSEN_LAST);
    assign code_o  = reads_o ? codes_q[23:12] : codes_q[11:0];

    // ---- A row is of so many ticks.

    reg  [3:0]  decimation_q;
    reg  [14:0] ticks_q;      // of the row, but for one
    reg  [14:0] tick_q;       // which of them the next one is
    reg         first_q;      // the tick that is worked off is the row's first
    reg         last_q;

    // Sums of the channels, by turns as well.
    reg  [SUM_W-1:0] sums [0:7];
    reg  [SUM_W-1:0] before_q;
    reg  [SUM_W-1:0] sum_q;
    reg  [31:0]      word_q;
    reg              is_mean_q;  // of word_q
    reg              is_any_q;
    reg              sum_mean_q;
    reg  [31:0]      value_q;
    reg              mean_q;

    wire [2:0] chosen  = turn_q[2:0] - 3'd1;
    wire [2:0] summed  = turn_q[2:0] - 3'd3;

    wire        [SUM_W-1:0] sofar  = first_q ? {SUM_W{1'b0}} : before_q;
    wire        [SUM_W-1:0] longer = {{SUM_W-32{word_q[31]}}, word_q};
    wire signed [SUM_W-1:0] sum    = $signed(sum_q);
    wire        [4:0]       amount = (sum_mean_q ? {1'b0, decimation_q} : 5'd0) + {1'b0, shift_i};
    wire signed [SUM_W-1:0] mean   = sum >>> amount;
    wire                    unused_mean = &{1'b0, mean[SUM_W-1:32]};

    always @(posedge clk) begin
        word_q     <= word_i;
        is_mean_q  <= mean_i;
        is_any_q   <= any_i;
        before_q   <= sums[chosen];
        sum_q      <= is_mean_q ? sofar + longer : is_any_q ? (sofar | longer) : longer;
        sum_mean_q <= is_mean_q;
        value_q    <= mean[31:0];
        mean_q     <= sum_mean_q;
        if (turn_q >= 4'd3 && turn_q <= SUMMED_LAST) begin
            sums[summed] <= sum_q;
        end
    end

    // ---- The turns.

    assign fresh_o  = (tick_q == 15'd0);
    assign turn_o   = turn_q;
    assign last_o   = last_q;
    assign mean_o   = mean_q;
    assign value_o  = value_q;

    always @(posedge clk) begin
        if (rst) begin
            turn_q <= 4'd0;
        end else begin
            if (take_i) begin
                turn_q  <= 4'd1;
                first_q <= (tick_q == 15'd0);
                last_q  <= (tick_q == ticks_q);
            end else if (turn_q != 4'd0) begin
                turn_q  <= (turn_q == TURN_LAST) ? 4'd0 : turn_q + 4'd1;
            end
            if (reads_o) begin
                codes_q <= {codes_q[11:0], codes_q[12*CHANNELS-1:12]};
            end
            if (turn_q == TURN_LAST) begin
                tick_q <= last_q ? 15'd0 : tick_q + 15'd1;
            end
            if (start_i) begin
                codes_q      <= channel_i;
                decimation_q <= decimation_i;
                ticks_q      <= 15'h7fff >> (4'd15 - decimation_i);
                tick_q       <= 15'd0;
            end
        end
    end

endmodule

`default_nettype wire
