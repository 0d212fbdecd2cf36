// SPDX-License-Identifier: Apache-2.0
//
// wh_rows: chosen live words of a tick, one after another, and what becomes of those of several ticks.
//
// A row has up to CHANNELS words, of the addresses of rtl/words.toml in channel_i; an address that is none
// of those below gives 0. It is made of 2^decimation_i ticks: of numbers with a sign and of the bus it has the
// mean, of the position what it was last, of bits those that were there in any tick. shift_i more bits are
// cut off below, rounding down.
// A tick's words are those of its step, as it ends; without one, as with the bridges off, those of the clock
// behind its last one: strobe_o. They are taken (take_o) where active_i is high and no tick is worked off.
//
//   turn_o   0 nothing to do; channel k is chosen in 1 + k, shift_i is its in 3 + k, value_o in 4 + k;
//            CHANNELS + 4 is the tick's last one
//   last_o   the tick that is worked off is its row's last, for which value_o is the row's word
//   fresh_o  the next tick, and in its strobe that one, is a row's first
//
// start_i takes the settings over, in a clock without strobe_o and with turn_o = 0; a row begins then.
//
// Latency: as turn_o says. A tick has to be CHANNELS + 6 clocks or longer; what ends sooner is left out.
// Reset: nothing is worked off.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_rows #(
    parameter integer N        = 1,  // motors, 1...8
    parameter integer CHANNELS = 8   // 2...8
) (
    input  wire                         clk,
    input  wire                         rst,

    // What it listens to.
    input  wire                         tick_i,           // strobe, last clock of a tick
    input  wire                         valid_i,          // strobe, a step's words are new
    input  wire [N*`WH_DATA_W-1:0]      voltage_i,        // s31q23 V
    input  wire [N*`WH_DATA_W-1:0]      u_i,              // s31q23 √W
    input  wire [N*`WH_DATA_W-1:0]      v_i,              // s31q23 √W
    input  wire [N*`WH_DATA_W-1:0]      current_i,        // s31q24 A
    input  wire [N*`WH_COUNT_W-1:0]     position_i,       // s32 counts
    input  wire [N*`WH_DATA_W-1:0]      correction_i,     // s31q23 V
    input  wire [N*`WH_DATA_W-1:0]      offset_i,         // s31q24 A
    input  wire [N*`WH_DATA_W-1:0]      flux_i,           // s31q16 cells
    input  wire [N*`WH_DATA_W-1:0]      lag_i,            // s31q16 cells
    input  wire [N*8-1:0]               flags_i,          // bits of the word `flags`
    input  wire [`WH_BUS_W-1:0]         bus_i,            // u16q9 V
    input  wire [`WH_FAULTS-1:0]        faults_i,

    // Settings, taken over by a start.
    input  wire                         start_i,          // strobe
    input  wire [12*CHANNELS-1:0]       channel_i,        // addresses, the first lowest
    input  wire [3:0]                   decimation_i,     // a row is of 2^this ticks
    input  wire [3:0]                   shift_i,          // 0...15, of a channel in its turn

    // The rows.
    input  wire                         active_i,         // they are wanted
    output wire                         strobe_o,         // strobe, once a tick
    output wire                         take_o,           // strobe, the tick is taken
    output wire                         fresh_o,
    output wire [3:0]                   turn_o,
    output wire                         last_o,
    output wire                         mean_o,           // with value_o: it is a mean
    output wire [31:0]                  value_o
);

    localparam integer DATA_W  = `WH_DATA_W;
    localparam integer COUNT_W = `WH_COUNT_W;
    localparam integer SUM_W   = 47;           // 2^15 words of 32 bits

    generate
        if (CHANNELS < 2 || CHANNELS > 8) begin : illegal
            wh_illegal_parameter_rows_channels_must_be_2_to_8 stop ();
        end
    endgenerate

    // Addresses of rtl/words.toml; a motor's without the motor.
    localparam [7:0]  VOLTAGE    = 8'hb0;
    localparam [7:0]  U          = 8'hb1;
    localparam [7:0]  V          = 8'hb2;
    localparam [7:0]  CURRENT    = 8'hb3;
    localparam [7:0]  POSITION   = 8'hb4;
    localparam [7:0]  CORRECTION = 8'hc0;
    localparam [7:0]  OFFSET     = 8'hc1;
    localparam [7:0]  FLUX       = 8'hc2;
    localparam [7:0]  LAG        = 8'hc3;
    localparam [7:0]  FLAGS      = 8'hd6;
    localparam [11:0] BUS        = 12'h039;
    localparam [11:0] FAULTS     = 12'h062;

    localparam [1:0] MEAN = 2'd0;  // what becomes of a word's ticks
    localparam [1:0] LAST = 2'd1;
    localparam [1:0] ANY  = 2'd2;

    // ---- One strobe a tick: its step's, or without one its end, which comes late in its clock.

    reg  stepped_q;  // this tick had a step
    reg  missed_q;   // the one before had none
    wire strobe = valid_i || missed_q;

    always @(posedge clk) begin
        stepped_q <= !rst && !tick_i && (stepped_q || valid_i);
        missed_q  <= !rst && tick_i && !stepped_q && !valid_i;
    end

    // ---- What the words are then. The channels' turns come one after another.

    localparam [31:0] CHANNELS_32 = CHANNELS;
    localparam [3:0]  CHOSEN_LAST = CHANNELS_32[3:0];
    localparam [3:0]  SUMMED_LAST = CHOSEN_LAST + 4'd2;
    localparam [3:0]  TURN_LAST   = CHOSEN_LAST + 4'd4;

    reg  [3:0] turn_q;
    wire       take = strobe && active_i && (turn_q == 4'd0);

    reg  [N*DATA_W-1:0]    voltage_q;
    reg  [N*DATA_W-1:0]    u_q;
    reg  [N*DATA_W-1:0]    v_q;
    reg  [N*DATA_W-1:0]    current_q;
    reg  [N*COUNT_W-1:0]   position_q;
    reg  [N*DATA_W-1:0]    correction_q;
    reg  [N*DATA_W-1:0]    offset_q;
    reg  [N*DATA_W-1:0]    flux_q;
    reg  [N*DATA_W-1:0]    lag_q;
    reg  [N*8-1:0]         flags_q;
    reg  [`WH_BUS_W-1:0]   bus_q;
    reg  [`WH_FAULTS-1:0]  faults_q;

    always @(posedge clk) begin
        if (take) begin
            voltage_q    <= voltage_i;
            u_q          <= u_i;
            v_q          <= v_i;
            current_q    <= current_i;
            position_q   <= position_i;
            correction_q <= correction_i;
            offset_q     <= offset_i;
            flux_q       <= flux_i;
            lag_q        <= lag_i;
            flags_q      <= flags_i;
            bus_q        <= bus_i;
            faults_q     <= faults_i;
        end
    end

    // ---- A channel's word, and what becomes of it.

    reg  [12*CHANNELS-1:0] codes_q;  // the turn's address lowest
    wire [11:0] code = codes_q[11:0];
    reg  [32:0] word;
    reg  [1:0]  kind;
    integer     m;

    always @* begin
        word = 33'd0;
        kind = LAST;
        if (code == BUS) begin
            word = {{33-`WH_BUS_W{1'b0}}, bus_q};
            kind = MEAN;
        end
        if (code == FAULTS) begin
            word = {{33-`WH_FAULTS{1'b0}}, faults_q};
            kind = ANY;
        end
        for (m = 0; m < N; m = m + 1) begin
            if ({28'd0, code[11:8]} == m + 1) begin
                case (code[7:0])
                    VOLTAGE:    word = {{33-DATA_W{voltage_q[m*DATA_W + DATA_W-1]}}, voltage_q[m*DATA_W +: DATA_W]};
                    U:          word = {{33-DATA_W{u_q[m*DATA_W + DATA_W-1]}}, u_q[m*DATA_W +: DATA_W]};
                    V:          word = {{33-DATA_W{v_q[m*DATA_W + DATA_W-1]}}, v_q[m*DATA_W +: DATA_W]};
                    CURRENT:    word = {{33-DATA_W{current_q[m*DATA_W + DATA_W-1]}}, current_q[m*DATA_W +: DATA_W]};
                    POSITION:   word = {{33-COUNT_W{position_q[m*COUNT_W + COUNT_W-1]}}, position_q[m*COUNT_W +: COUNT_W]};
                    CORRECTION: word = {{33-DATA_W{correction_q[m*DATA_W + DATA_W-1]}}, correction_q[m*DATA_W +: DATA_W]};
                    OFFSET:     word = {{33-DATA_W{offset_q[m*DATA_W + DATA_W-1]}}, offset_q[m*DATA_W +: DATA_W]};
                    FLUX:       word = {{33-DATA_W{flux_q[m*DATA_W + DATA_W-1]}}, flux_q[m*DATA_W +: DATA_W]};
                    LAG:        word = {{33-DATA_W{lag_q[m*DATA_W + DATA_W-1]}}, lag_q[m*DATA_W +: DATA_W]};
                    FLAGS:      word = {25'd0, flags_q[m*8 +: 8]};
                    default:    word = 33'd0;
                endcase
                kind = (code[7:0] == POSITION) ? LAST : (code[7:0] == FLAGS) ? ANY : MEAN;
            end
        end
    end

    wire unused_word = &{1'b0, word[32]};

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
    reg  [1:0]       kind_q;
    reg  [1:0]       sum_kind_q;
    reg  [31:0]      value_q;
    reg              mean_q;

    wire [2:0] chosen  = turn_q[2:0] - 3'd1;
    wire [2:0] summed  = turn_q[2:0] - 3'd3;

    wire        [SUM_W-1:0] sofar  = first_q ? {SUM_W{1'b0}} : before_q;
    wire        [SUM_W-1:0] longer = {{SUM_W-32{word_q[31]}}, word_q};
    wire signed [SUM_W-1:0] sum    = $signed(sum_q);
    wire        [4:0]       amount = ((sum_kind_q == MEAN) ? {1'b0, decimation_q} : 5'd0) + {1'b0, shift_i};
    wire signed [SUM_W-1:0] mean   = sum >>> amount;
    wire                    unused_mean = &{1'b0, mean[SUM_W-1:32]};

    always @(posedge clk) begin
        word_q     <= word[31:0];
        kind_q     <= kind;
        before_q   <= sums[chosen];
        sum_q      <= (kind_q == MEAN) ? sofar + longer : (kind_q == ANY) ? (sofar | longer) : longer;
        sum_kind_q <= kind_q;
        value_q    <= mean[31:0];
        mean_q     <= (sum_kind_q == MEAN);
        if (turn_q >= 4'd3 && turn_q <= SUMMED_LAST) begin
            sums[summed] <= sum_q;
        end
    end

    // ---- The turns.

    assign strobe_o = strobe;
    assign take_o   = take;
    assign fresh_o  = (tick_q == 15'd0);
    assign turn_o   = turn_q;
    assign last_o   = last_q;
    assign mean_o   = mean_q;
    assign value_o  = value_q;

    always @(posedge clk) begin
        if (rst) begin
            turn_q <= 4'd0;
        end else begin
            if (take) begin
                turn_q  <= 4'd1;
                first_q <= (tick_q == 15'd0);
                last_q  <= (tick_q == ticks_q);
            end else if (turn_q != 4'd0) begin
                turn_q  <= (turn_q == TURN_LAST) ? 4'd0 : turn_q + 4'd1;
            end
            if (turn_q >= 4'd1 && turn_q <= CHOSEN_LAST) begin
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
