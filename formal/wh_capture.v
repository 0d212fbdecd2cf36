// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_capture: whatever is told and whatever it listens to, a capture writes no more words than there
// are, each row's in turn to its place of the ring, and none while it is at rest or done: what is done stays until
// a start. It triggers when the rows before the trigger's are there, and is done by itself with exactly these,
// the trigger's behind them and all others behind that. Without a kind it is only a write that triggers.
// For a memory of 16 words. Proven by induction, smtbmc z3.

`default_nettype none

module prove_wh_capture (
    input wire                   clk,
    input wire                   rst,
    input wire                   strobe,
    input wire                   take,
    input wire [31:0]            word,
    input wire                   mean,
    input wire                   any,
    input wire                   contact,
    input wire                   fault,
    input wire [95:0]            channel,
    input wire [3:0]             channels,
    input wire [15:0]            rows,
    input wire [15:0]            pre,
    input wire [3:0]             decimation,
    input wire [2:0]             kind,
    input wire [31:0]            level,
    input wire                   hold,
    input wire                   write,
    input wire                   write_offset,
    input wire [15:0]            data,
    input wire [5:0]             read
);

    localparam [2:0] REST      = 3'd0;
    localparam [2:0] FILLS     = 3'd1;
    localparam [2:0] WAITS     = 3'd2;
    localparam [2:0] TRIGGERED = 3'd3;
    localparam [2:0] DONE      = 3'd4;

    wire [2:0]  state;
    wire [15:0] count;
    wire [15:0] first;
    wire [15:0] left;
    wire [31:0] read_data;
    wire        want;
    wire        reads;
    wire [11:0] code;

    wh_capture #(
        .DEPTH_LOG2     (4)
    ) block (
        .clk            (clk),
        .rst            (rst),
        .strobe_i       (strobe),
        .want_o         (want),
        .take_i         (take),
        .reads_o        (reads),
        .code_o         (code),
        .word_i         (word),
        .mean_i         (mean),
        .any_i          (any),
        .contact_i      (contact),
        .fault_i        (fault),
        .channel_i      (channel),
        .channels_i     (channels),
        .rows_i         (rows),
        .pre_i          (pre),
        .decimation_i   (decimation),
        .trigger_i      (kind),
        .level_i        (level),
        .hold_i         (hold),
        .write_i        (write),
        .write_offset_i (write_offset),
        .data_i         (data),
        .state_o        (state),
        .count_o        (count),
        .first_o        (first),
        .left_o         (left),
        .read_i         (read),
        .read_data_o    (read_data)
    );

    (* hierconn *) wire [3:0]  \block.rows.turn_q ;
    (* hierconn *) wire [3:0]  \block.channels_q ;
    (* hierconn *) wire [15:0] \block.rows_q ;
    (* hierconn *) wire [15:0] \block.pre_q ;
    (* hierconn *) wire [15:0] \block.row_q ;
    (* hierconn *) wire [3:0]  \block.place_q ;
    (* hierconn *) wire        \block.rows.last_q ;
    (* hierconn *) wire [2:0]  \block.trigger_q ;
    (* hierconn *) wire        \block.told_q ;
    (* hierconn *) wire        \block.stores ;
    (* hierconn *) wire        \block.obeys ;
    (* hierconn *) wire        \block.starts ;
    (* hierconn *) wire        \block.starts_q ;
    (* hierconn *) wire        \block.triggers_q ;
    (* hierconn *) wire        \block.stops_q ;
    (* hierconn *) wire [19:0] \block.needed_q ;
    (* hierconn *) wire        \block.ring_ends_q ;
    (* hierconn *) wire        \block.filled_q ;
    (* hierconn *) wire [31:0] \block.memory[5] ;

    wire [3:0]  turn  = \block.rows.turn_q ;
    wire [3:0]  each  = \block.channels_q ;
    wire [15:0] all   = \block.rows_q ;
    wire [15:0] early = \block.pre_q ;
    wire [15:0] row   = \block.row_q ;
    wire        last  = \block.rows.last_q ;

    wire        active = (state == FILLS) || (state == WAITS) || (state == TRIGGERED);
    wire        itself = (state == DONE) && (left == 16'd0);  // not stopped

    // A product with a number of channels, which is short.
    function [19:0] times;
        input [15:0] rows;
        input [3:0]  channels;
        begin
            times = (channels[0] ? {4'd0, rows} : 20'd0) + (channels[1] ? {3'd0, rows, 1'd0} : 20'd0)
                    + (channels[2] ? {2'd0, rows, 2'd0} : 20'd0)
                    + (channels[3] ? {1'd0, rows, 3'd0} : 20'd0);
        end
    endfunction

    // Words of the row that is being written.
    wire [3:0]  there = (!last || turn < 4'd4) ? 4'd0 : (turn - 4'd4 < each) ? turn - 4'd4 : each;
    wire [19:0] begin_of_row = times(row, each);
    wire [4:0]  place = begin_of_row[4:0] + {1'b0, there};

    // Rows from the trigger on, and where the next one stands by that.
    wire [15:0] since = all - early - left;
    reg  [15:0] trigger_row;
    wire [16:0] behind = {1'b0, trigger_row} + {1'b0, since};
    wire [16:0] next   = (behind >= {1'b0, all}) ? behind - {1'b0, all} : behind;
    wire [16:0] oldest = {1'b0, first} + {1'b0, early};

    // What a listener knows.
    reg        begun = 1'b0;
    reg        rst_q;
    reg  [2:0] state_q;
    reg        started_q;
    reg        stores_q;
    reg  [3:0] place_q;
    reg [31:0] memory_q;
    reg        told;        // a trigger was written since the start
    reg  [2:0] wanted;      // start, trigger, stop: written and not done
    wire       obeys = \block.obeys ;
    reg [19:0] needed;
    reg [39:0] settings_q;

    always @(posedge clk) begin
        begun      <= 1'b1;
        rst_q      <= rst;
        state_q    <= state;
        started_q  <= \block.starts ;
        stores_q   <= \block.stores ;
        place_q    <= \block.place_q ;
        memory_q   <= \block.memory[5] ;
        needed     <= times(rows, channels);
        settings_q <= {rows, channels, pre, decimation};
        // Orders as they are written: a start forgets those before it, and no other is forgotten.
        if (rst) begin
            wanted <= 3'd0;
        end else begin
            wanted <= (write && data[1:0] == 2'd1) ? 3'b001
                    : (wanted & ~{{2{obeys}}, \block.starts })
                      | {write && data[1:0] == 2'd0, write && data[1:0] == 2'd2, 1'b0};
        end
        if (\block.starts ) begin
            told <= 1'b0;
        end else if (obeys && wanted[1]) begin
            told <= 1'b1;
        end
        if (turn == 4'd12 && last && state == WAITS) begin
            trigger_row <= row;
        end

        if (!begun) begin
            assume (rst);
        end else begin
            // wh_round_words gives a tick's words to who wants them, in its strobe.
            if (take) assume (strobe && want);
            // wh_registers says so: nothing changes but while something is about to.
            if (!hold) assume (settings_q == {rows, channels, pre, decimation});

            assert (state <= DONE && turn <= 4'd12);
            assert (\block.needed_q == needed);
            if (rst_q) assert (state == REST && turn == 4'd0);
            assert (wanted == {\block.stops_q , \block.triggers_q , \block.starts_q });
            // What waits is done as soon as no tick is worked off, but a start while settings may change.
            assert (obeys == (!strobe && turn == 4'd0 && !wanted[0]));
            assert (\block.starts == (!strobe && turn == 4'd0 && wanted[0] && !hold));

            // At rest, or done: nothing is written, and nothing becomes of it but by a start.
            if (!active) assert (turn == 4'd0 && !\block.stores );
            if (state != state_q && !rst_q) begin
                assert (state_q == REST ? started_q : state_q == DONE ? started_q : 1'b1);
                if (state == TRIGGERED) assert (state_q == WAITS);
                if (state == WAITS) assert (state_q == FILLS || started_q);
            end
            if (!stores_q || place_q != 4'd5) assert (\block.memory[5] == memory_q);

            // What is active, or was.
            if (state != REST) begin
                assert (each >= 4'd1 && each <= 4'd8);
                assert (all >= 16'd1 && all <= 16'd16 && early < all);
                assert (times(all, each) <= 20'd16);
                assert (row < all && count <= all && (count == all || row == count));
                assert (left <= all - early);
                assert (first == ((count == all) ? row : 16'd0));
            end
            if (active) begin
                assert (\block.place_q == place[3:0]);
                if (\block.stores ) assert (place < 5'd16 && turn - 4'd4 < each && turn >= 4'd4);
            end
            if (active && turn != 4'd0) begin
                assert (\block.ring_ends_q == (row + 16'd1 == all));
                assert (\block.filled_q == (count + 16'd1 == early));
            end
            if (state == FILLS) assert (count < early && left == all - early);
            if (state == WAITS) assert (count >= early && left == all - early);
            if (state == TRIGGERED) assert (left != 16'd0 && left < all - early);
            if (state == TRIGGERED || itself) begin
                assert (count >= all - left);
                assert (trigger_row < all && {1'b0, row} == next);
            end
            if (itself) begin
                assert (count == all);
                assert (((oldest >= {1'b0, all}) ? oldest - {1'b0, all} : oldest) == {1'b0, trigger_row});
            end

            // A write triggers, or what was asked for.
            if (active) assert (\block.told_q == told);
            if (state_q == WAITS && (state == TRIGGERED || itself) && \block.trigger_q == 3'd0) assert (told);

            cover (state == WAITS && early == 16'd1 && each == 4'd2);
            cover (itself && \block.trigger_q == 3'd1);
            cover (state == DONE && left == 16'd1 && count == 16'd1);
        end
    end

endmodule

`default_nettype wire
