// SPDX-License-Identifier: Apache-2.0
//
// wh_capture: rows of live words in block RAM, from some time before a trigger to some time after it.
// It listens only: nothing of it goes to what it listens to.
//
// A row has up to eight words, `channels_i` of the addresses of rtl/words.toml in `channel_i`; an address
// that is none of those below gives 0. It is made of 2^decimation_i ticks: of numbers with a sign and of the
// bus it keeps the mean, rounded down, of the position what it was last, of bits those that were there in any tick.
// A tick's words are those of its step, as it ends; without one, as with the bridges off, those of the clock
// behind its last one.
//
//   write 1   start: forget what was written, take the settings over, and fill: pre_i rows
//   write 2   trigger, as soon as those rows are there
//   write 0   stop, after the row's tick that is under way
//
// The first row behind the first pre_i ones in which what trigger_i says is the case is the trigger's:
// 0 write 2 only, 1 the first channel's word is level_i or more, 2 less, 3 that it has become more, 4 less,
// 5 other than in the row before, 6 a contact begins, 7 a fault is there; write 2 does it with any. Then rows go on
// until there are rows_i of them, pre_i before the trigger's and the rest from it on. Rows lie in a ring of rows_i;
// the oldest is row first_o of it. With settings that don't fit, 0 or more than 8 channels, rows_i times these more
// than there are words, or pre_i not below rows_i, a start leaves it at rest.
//
// state_o: 0 at rest, 1 the rows before the trigger fill, 2 it waits for the trigger, 3 triggered, 4 done or stopped.
// count_o: rows that are there; left_o: rows that are to come from the trigger on, that row included.
//
// Latency: a row stands in the memory 12 clocks after its last step. A tick has to be 14 clocks or longer;
// what ends sooner is left out. A write acts when no tick is worked off and hold_i is low. read_data_o is the word
// offset + read_i of the memory, 3 clocks after read_i.
// Reset: at rest, the offset 0; what is in the memory stays.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_capture #(
    parameter integer N          = 1,  // motors, 1...8
    parameter integer DEPTH_LOG2 = 12  // words of 32 bits, 2^this: 4...15
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
    input  wire [N-1:0]                 contact_i,
    input  wire                         fault_i,          // something is wrong

    // Settings, taken over by a start.
    input  wire [95:0]                  channel_i,        // eight addresses, the first lowest
    input  wire [3:0]                   channels_i,       // 1...8
    input  wire [15:0]                  rows_i,           // 1...
    input  wire [15:0]                  pre_i,            // rows before the trigger's
    input  wire [3:0]                   decimation_i,     // a row is of 2^this ticks
    input  wire [2:0]                   trigger_i,
    input  wire signed [31:0]           level_i,          // in the format of the first channel's word
    input  wire                         hold_i,           // they are about to change

    // Commands.
    input  wire                         write_i,          // strobe
    input  wire                         write_offset_i,   // strobe, of the offset
    input  wire [15:0]                  data_i,           // with either

    // State.
    output wire [2:0]                   state_o,
    output wire [15:0]                  count_o,
    output wire [15:0]                  first_o,
    output wire [15:0]                  left_o,

    // What is in the memory.
    input  wire [5:0]                   read_i,
    output reg  [31:0]                  read_data_o
);

    localparam integer DATA_W  = `WH_DATA_W;
    localparam integer COUNT_W = `WH_COUNT_W;
    localparam integer SUM_W   = 47;           // 2^15 words of 32 bits
    localparam [19:0]  WORDS   = 20'd1 << DEPTH_LOG2;

    generate
        if (DEPTH_LOG2 < 4 || DEPTH_LOG2 > 15) begin : illegal
            wh_illegal_parameter_capture_depth_log2_must_be_4_to_15 stop ();
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

    localparam [2:0] REST      = 3'd0;
    localparam [2:0] FILLS     = 3'd1;
    localparam [2:0] WAITS     = 3'd2;
    localparam [2:0] TRIGGERED = 3'd3;
    localparam [2:0] DONE      = 3'd4;

    localparam [1:0] MEAN = 2'd0;  // what becomes of a word's ticks
    localparam [1:0] LAST = 2'd1;
    localparam [1:0] ANY  = 2'd2;

    reg  [2:0]  state_q;
    wire        active = (state_q == FILLS) || (state_q == WAITS) || (state_q == TRIGGERED);

    // ---- One strobe a tick: its step's, or without one its end, which comes late in its clock.

    reg  stepped_q;  // this tick had a step
    reg  missed_q;   // the one before had none
    wire strobe = valid_i || missed_q;

    always @(posedge clk) begin
        stepped_q <= !rst && !tick_i && (stepped_q || valid_i);
        missed_q  <= !rst && tick_i && !stepped_q && !valid_i;
    end

    // ---- What the words are then. The channels' turns come one after another.

    localparam [3:0] TURN_LAST = 4'd12;

    reg  [3:0] turn_q;  // 0 nothing to do; channel k is chosen in 1 + k, written in 4 + k
    wire       take = strobe && active && (turn_q == 4'd0);

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

    reg  [95:0] codes_q;  // the turn's address lowest
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

    wire [2:0] chosen  = turn_q[2:0] - 3'd1;
    wire [2:0] summed  = turn_q[2:0] - 3'd3;
    wire [3:0] written = turn_q - 4'd4;

    wire        [SUM_W-1:0] sofar  = first_q ? {SUM_W{1'b0}} : before_q;
    wire        [SUM_W-1:0] longer = {{SUM_W-32{word_q[31]}}, word_q};
    wire signed [SUM_W-1:0] sum    = $signed(sum_q);
    wire signed [SUM_W-1:0] mean   = sum >>> ((sum_kind_q == MEAN) ? decimation_q : 4'd0);
    wire                    unused_mean = &{1'b0, mean[SUM_W-1:32]};

    always @(posedge clk) begin
        word_q     <= word[31:0];
        kind_q     <= kind;
        before_q   <= sums[chosen];
        sum_q      <= (kind_q == MEAN) ? sofar + longer : (kind_q == ANY) ? (sofar | longer) : longer;
        sum_kind_q <= kind_q;
        value_q    <= mean[31:0];
        if (turn_q >= 4'd3 && turn_q <= 4'd10) begin
            sums[summed] <= sum_q;
        end
    end

    // ---- The memory.

    (* ram_style = "block" *) reg [31:0] memory [0:(1<<DEPTH_LOG2)-1];

    reg  [3:0]            channels_q;
    reg  [DEPTH_LOG2-1:0] place_q;    // the next word's
    wire                  stores = active && last_q && (turn_q >= 4'd4) && (turn_q < TURN_LAST)
                                   && (written < channels_q);

    reg  [15:0]           read_offset_q;
    reg  [15:0]           read_place_q;
    reg  [31:0]           read_q;
    wire                  unused_place = &{1'b0, read_place_q};

    always @(posedge clk) begin
        if (stores) begin
            memory[place_q] <= value_q;
        end
        if (rst || write_offset_i) begin
            read_offset_q <= rst ? 16'd0 : data_i;
        end
        read_place_q <= read_offset_q + {10'd0, read_i};
        read_q       <= memory[read_place_q[DEPTH_LOG2-1:0]];
        read_data_o  <= read_q;
    end

    // ---- The trigger.

    reg  [2:0]         trigger_q;
    reg signed [31:0]  level_q;
    reg                told_q;      // by a write
    reg                known_q;     // there was a row before
    reg  [31:0]        previous_q;  // its first word
    reg                was_over_q;  // that was the level or more
    reg                over_q;      // the row's is
    reg                differs_q;
    reg  [N-1:0]       contact_q;   // of the tick before
    reg                touched_q;   // a contact began in the row
    reg                wrong_q;     // a fault was there in the row
    reg                hit;

    wire ends_row = (turn_q == TURN_LAST) && last_q;

    always @* begin
        case (trigger_q)
            3'd0:    hit = 1'b0;
            3'd1:    hit = over_q;
            3'd2:    hit = !over_q;
            3'd3:    hit = known_q && over_q && !was_over_q;
            3'd4:    hit = known_q && !over_q && was_over_q;
            3'd5:    hit = known_q && differs_q;
            3'd6:    hit = touched_q;
            default: hit = wrong_q;
        endcase
    end

    always @(posedge clk) begin
        if (strobe) begin
            contact_q <= contact_i;
        end
        if (take) begin
            touched_q <= (|(contact_i & ~contact_q)) || (touched_q && tick_q != 15'd0);
            wrong_q   <= fault_i || (wrong_q && tick_q != 15'd0);
        end
        if (turn_q == 4'd4 && last_q) begin
            over_q     <= ($signed(value_q) >= level_q);
            differs_q  <= (value_q != previous_q);
            previous_q <= value_q;
        end
        if (ends_row) begin
            was_over_q <= over_q;
        end
    end

    // ---- What it does.

    reg         ordered_q;
    reg  [1:0]  order_q;
    reg  [15:0] rows_q;
    reg  [15:0] pre_q;
    reg  [15:0] row_q;      // of the ring, the next one
    reg  [15:0] count_q;
    reg  [15:0] left_q;
    reg  [19:0] needed_q;   // words, of the settings as they are

    wire obeys = ordered_q && !hold_i && !strobe && (turn_q == 4'd0);
    wire fits  = (needed_q <= WORDS) && (channels_i != 4'd0) && (channels_i <= 4'd8) && (pre_i < rows_i);

    wire        full     = (count_q == rows_q);
    wire [15:0] next_row = row_q + 16'd1;

    assign state_o = state_q;
    assign count_o = count_q;
    assign first_o = full ? row_q : 16'd0;
    assign left_o  = left_q;

    always @(posedge clk) begin
        needed_q <= (channels_i[0] ? {4'd0, rows_i} : 20'd0) + (channels_i[1] ? {3'd0, rows_i, 1'd0} : 20'd0)
                    + (channels_i[2] ? {2'd0, rows_i, 2'd0} : 20'd0)
                    + (channels_i[3] ? {1'd0, rows_i, 3'd0} : 20'd0);
        if (rst) begin
            state_q   <= REST;
            turn_q    <= 4'd0;
            ordered_q <= 1'b0;
            count_q   <= 16'd0;
            rows_q    <= 16'd0;
            row_q     <= 16'd0;
            left_q    <= 16'd0;
        end else begin
            ordered_q <= write_i || (ordered_q && !obeys);
            if (write_i) begin
                order_q <= data_i[1:0];
            end

            // The ticks.
            if (take) begin
                turn_q  <= 4'd1;
                first_q <= (tick_q == 15'd0);
                last_q  <= (tick_q == ticks_q);
            end else if (turn_q != 4'd0) begin
                turn_q  <= (turn_q == TURN_LAST) ? 4'd0 : turn_q + 4'd1;
            end
            if (turn_q >= 4'd1 && turn_q <= 4'd8) begin
                codes_q <= {codes_q[11:0], codes_q[95:12]};
            end
            if (stores) begin
                place_q <= place_q + {{DEPTH_LOG2-1{1'b0}}, 1'b1};
            end
            if (turn_q == TURN_LAST) begin
                tick_q <= last_q ? 15'd0 : tick_q + 15'd1;
            end

            // The rows.
            if (ends_row) begin
                known_q <= 1'b1;
                row_q   <= next_row;
                if (next_row == rows_q) begin
                    row_q   <= 16'd0;
                    place_q <= {DEPTH_LOG2{1'b0}};
                end
                if (!full) begin
                    count_q <= count_q + 16'd1;
                end
                if (state_q == FILLS && count_q + 16'd1 == pre_q) begin
                    state_q <= WAITS;
                end
                if (state_q == TRIGGERED || (state_q == WAITS && (hit || told_q))) begin
                    left_q  <= left_q - 16'd1;
                    state_q <= (left_q == 16'd1) ? DONE : TRIGGERED;
                end
            end

            // The commands.
            if (obeys) begin
                case (order_q)
                    2'd0: if (active) begin
                        state_q <= DONE;
                    end
                    2'd1: begin
                        state_q      <= !fits ? REST : (pre_i == 16'd0) ? WAITS : FILLS;
                        codes_q      <= channel_i;
                        channels_q   <= channels_i;
                        rows_q       <= rows_i;
                        pre_q        <= pre_i;
                        left_q       <= rows_i - pre_i;
                        decimation_q <= decimation_i;
                        ticks_q      <= 15'h7fff >> (4'd15 - decimation_i);
                        trigger_q    <= trigger_i;
                        level_q      <= level_i;
                        tick_q       <= 15'd0;
                        row_q        <= 16'd0;
                        place_q      <= {DEPTH_LOG2{1'b0}};
                        count_q      <= 16'd0;
                        known_q      <= 1'b0;
                        told_q       <= 1'b0;
                    end
                    2'd2: told_q <= 1'b1;
                    default: ;
                endcase
            end
        end
    end

endmodule

`default_nettype wire
