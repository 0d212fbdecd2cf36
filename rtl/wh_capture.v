// SPDX-License-Identifier: Apache-2.0
//
// wh_capture: rows of live values in block RAM, from before a trigger to after it. It only listens: nothing of it
// reaches what it listens to.
//
// A row has up to eight values, `channels_i` of the addresses in `channel_i`, for 2^decimation_i ticks (wh_rows).
//
//   write 1   start: drop the old rows, take the settings, and record pre_i rows
//   write 2   trigger, once those rows are recorded
//   write 0   stop, after the row's present tick
//
// After the first pre_i rows, the first row that meets the condition trigger_i is the trigger's:
// 0 write 2 only; the first channel's value 1 is level_i or more, 2 is less, 3 rises to it, 4 falls below it, 5 differs
// from the row before; 6 a contact begins, 7 there is a fault. Write 2 triggers with any of them. Recording continues
// until there are rows_i rows: pre_i before the trigger's, the others from it on. Rows are in a ring of rows_i; the
// oldest is row first_o of it. A start with invalid settings stays idle: 0 or more than 8 channels, rows_i times the
// channels beyond the memory, or pre_i not below rows_i.
//
// state_o: 0 idle, 1 recording the rows before the trigger, 2 waiting for it, 3 triggered, 4 done or stopped.
// count_o: rows recorded; left_o: rows still to record from the trigger's on.
//
// Latency: a row is in the memory 12 clocks after its last step. A tick needs 14 clocks or more; shorter ones are left
// out. A write acts when no tick is being processed; a start also waits while hold_i is high. A trigger or a stop right
// behind a start waits for it; a start drops those before it. read_data_o is the value at offset + read_i in the
// memory, 3 clocks after read_i or after the write of the offset.
// Reset: idle, the offset 0; the memory keeps its contents.

`default_nettype none

module wh_capture #(
    parameter integer N          = 1,  // motors, 1...8
    parameter integer DEPTH_LOG2 = 12  // words of 32 bits, 2^this: 4...15
) (
    input  wire                         clk,
    input  wire                         rst,

    // What it listens to: the words of a tick (wh_round_words), contact and faults as they are with its strobe.
    input  wire                         strobe_i,         // strobe, once a tick
    output wire                         want_o,
    input  wire                         take_i,           // strobe, with strobe_i
    output wire                         reads_o,
    output wire [11:0]                  code_o,
    input  wire [31:0]                  word_i,
    input  wire                         mean_i,
    input  wire                         any_i,
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
    input  wire                         hold_i,           // they are about to change: no start

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

    localparam [19:0]  WORDS   = 20'd1 << DEPTH_LOG2;

    generate
        if (DEPTH_LOG2 < 4 || DEPTH_LOG2 > 15) begin : illegal
            wh_illegal_parameter_capture_depth_log2_must_be_4_to_15 stop ();
        end
    endgenerate

    localparam [2:0] REST      = 3'd0;
    localparam [2:0] FILLS     = 3'd1;
    localparam [2:0] WAITS     = 3'd2;
    localparam [2:0] TRIGGERED = 3'd3;
    localparam [2:0] DONE      = 3'd4;

    localparam [3:0] TURN_LAST = 4'd12;

    reg  [2:0]  state_q;
    wire        active = (state_q == FILLS) || (state_q == WAITS) || (state_q == TRIGGERED);

    // ---- The rows: eight channels, one after another.

    wire        idle;
    wire        fresh;
    wire [3:0]  turn;
    wire        last;
    wire [31:0] value;
    wire        starts;
    wire        unused_mean;

    wh_rows #(
        .CHANNELS     (8)
    ) rows (
        .clk          (clk),
        .rst          (rst),
        .take_i       (take_i),
        .idle_o       (idle),
        .reads_o      (reads_o),
        .code_o       (code_o),
        .word_i       (word_i),
        .mean_i       (mean_i),
        .any_i        (any_i),
        .start_i      (starts),
        .channel_i    (channel_i),
        .decimation_i (decimation_i),
        .shift_i      (4'd0),
        .fresh_o      (fresh),
        .turn_o       (turn),
        .last_o       (last),
        .mean_o       (unused_mean),
        .value_o      (value)
    );

    assign want_o = active && idle;

    wire [3:0] written = turn - 4'd4;

    // ---- The memory.

    (* ram_style = "block" *) reg [31:0] memory [0:(1<<DEPTH_LOG2)-1];

    reg  [3:0]            channels_q;
    reg  [DEPTH_LOG2-1:0] place_q;    // the next word's
    wire                  stores = active && last && (turn >= 4'd4) && (turn < TURN_LAST)
                                   && (written < channels_q);

    reg  [15:0]           read_offset_q;
    reg  [15:0]           read_place_q;
    reg  [31:0]           read_q;
    wire                  unused_place = &{1'b0, read_place_q};

    always @(posedge clk) begin
        if (stores) begin
            memory[place_q] <= value;
        end
        if (rst || write_offset_i) begin
            read_offset_q <= rst ? 16'd0 : data_i;
        end
        read_place_q <= (write_offset_i ? data_i : read_offset_q) + {10'd0, read_i};
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

    wire ends_row = (turn == TURN_LAST) && last;

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
        if (strobe_i) begin
            contact_q <= contact_i;
        end
        if (take_i) begin
            touched_q <= (|(contact_i & ~contact_q)) || (touched_q && !fresh);
            wrong_q   <= fault_i || (wrong_q && !fresh);
        end
        if (turn == 4'd4 && last) begin
            over_q     <= ($signed(value) >= level_q);
            differs_q  <= (value != previous_q);
            previous_q <= value;
        end
        if (ends_row) begin
            was_over_q <= over_q;
        end
    end

    // ---- What it does.

    reg         starts_q;   // orders that wait
    reg         triggers_q;
    reg         stops_q;
    reg  [15:0] rows_q;
    reg  [15:0] pre_q;
    reg  [15:0] row_q;      // of the ring, the next one
    reg  [15:0] count_q;
    reg  [15:0] left_q;
    reg  [19:0] needed_q;   // words, of the settings as they are
    // A row takes many clocks, so that these may be one late: what they compare is long.
    reg         ring_ends_q;  // the row is the ring's last
    reg         filled_q;     // with it there are as many as go before the trigger

    wire order_0 = write_i && (data_i[1:0] == 2'd0);
    wire order_1 = write_i && (data_i[1:0] == 2'd1);
    wire order_2 = write_i && (data_i[1:0] == 2'd2);
    wire free    = !strobe_i && idle;
    wire obeys   = free && !starts_q;  // what isn't a start

    assign starts = free && starts_q && !hold_i;

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
        ring_ends_q <= (next_row == rows_q);
        filled_q    <= (count_q + 16'd1 == pre_q);
        if (rst) begin
            state_q    <= REST;
            starts_q   <= 1'b0;
            triggers_q <= 1'b0;
            stops_q    <= 1'b0;
            count_q    <= 16'd0;
            rows_q     <= 16'd0;
            row_q      <= 16'd0;
            left_q     <= 16'd0;
        end else begin
            starts_q   <= order_1 || (starts_q && !starts);
            triggers_q <= order_2 || (triggers_q && !order_1 && !obeys);
            stops_q    <= order_0 || (stops_q && !order_1 && !obeys);

            if (stores) begin
                place_q <= place_q + {{DEPTH_LOG2-1{1'b0}}, 1'b1};
            end

            // The rows.
            if (ends_row) begin
                known_q <= 1'b1;
                row_q   <= next_row;
                if (ring_ends_q) begin
                    row_q   <= 16'd0;
                    place_q <= {DEPTH_LOG2{1'b0}};
                end
                if (!full) begin
                    count_q <= count_q + 16'd1;
                end
                if (state_q == FILLS && filled_q) begin
                    state_q <= WAITS;
                end
                if (state_q == TRIGGERED || (state_q == WAITS && (hit || told_q))) begin
                    left_q  <= left_q - 16'd1;
                    state_q <= (left_q == 16'd1) ? DONE : TRIGGERED;
                end
            end

            // The commands.
            if (obeys && stops_q && active) begin
                state_q <= DONE;
            end
            if (obeys && triggers_q) begin
                told_q <= 1'b1;
            end
            if (starts) begin
                state_q      <= !fits ? REST : (pre_i == 16'd0) ? WAITS : FILLS;
                channels_q   <= channels_i;
                rows_q       <= rows_i;
                pre_q        <= pre_i;
                left_q       <= rows_i - pre_i;
                trigger_q    <= trigger_i;
                level_q      <= level_i;
                row_q        <= 16'd0;
                place_q      <= {DEPTH_LOG2{1'b0}};
                count_q      <= 16'd0;
                known_q      <= 1'b0;
                told_q       <= 1'b0;
            end
        end
    end

endmodule

`default_nettype wire
