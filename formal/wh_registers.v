// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_registers: of one setting, which may be any, of all ports or of one of N = 3.
//
// A commit ends: busy_o is high for MOST clocks at most, whatever the bus does. The bank in force changes once in it,
// when the other bank has the setting as it was written as the commit began (for `discard`: as it is in force); else
// neither that bank's word nor a setting of all ports changes. A bank isn't written for 135 clocks after it was in
// force. Every request is answered in 5 clocks, a command that is accepted is there a clock after. A read gives what
// was written, and with `discard` under way what is in force. A setting that needs the bridges off is written, and
// committed, while they are off: from the commit on until its end loading_o is high. No value outside its range is
// ever stored, or goes to a station.
//
// The master holds what it asks for until the answer. The station's memory of the setting stands here. Its state
// before the first clock is a reset, or anything of which the invariant holds. Memories and register map:
// any_register_ram, any_settings_rom. Proven by induction.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module prove_wh_registers (
    input wire                  clk,
    input wire                  rst,
    input wire                  bus_valid,
    input wire                  bus_write,
    input wire                  bus_check,
    input wire [11:0]           bus_address,
    input wire [31:0]           bus_data,
    input wire                  enable,
    input wire                  tick,
    input wire [`WH_FAULTS-1:0] faults,
    input wire                  live_valid,
    input wire [31:0]           live_data,
    input wire [31:0]           other
);

    localparam integer N      = 3;
    localparam integer COPIED = 96 + 128 * N;
    localparam integer MOST   = COPIED + COPIED / 5 + 3 + 135;
    localparam [8:0]   SETTLE = 9'd135;
    localparam [7:0]   BOARD  = 8'ha0;

    localparam [2:0] AT_IDLE  = 3'd0;
    localparam [2:0] AT_LEAST = 3'd1;
    localparam [2:0] AT_MOST  = 3'd2;
    localparam [2:0] AT_LOW   = 3'd3;
    localparam [2:0] AT_JUDGE = 3'd4;
    localparam [2:0] AT_DONE  = 3'd5;

    localparam [1:0] WRITTEN  = 2'd0;
    localparam [1:0] IN_FORCE = 2'd1;
    localparam [1:0] DEFAULTS = 2'd2;

    wire        bus_ready;
    wire [31:0] bus_read;
    wire [1:0]  bus_error;
    wire        bus_signed;
    wire [65:0] carrier;
    wire [56:0] frame;
    wire [70:0] sense;
    wire [3:0]  filter_clocks;
    wire [3:0]  delay;
    wire [27:0] bridge;
    wire [11:0] host;
    wire [`WH_GUARD_W-1:0] guard;
    wire        in_force;
    wire        write;
    wire        write_bank;
    wire [11:0] address;
    wire [31:0] data;
    wire        clear;
    wire        host_alive;
    wire        zero_start;
    wire        restart;
    wire        command;
    wire [11:0] command_address;
    wire [31:0] command_data;
    wire        ready;
    wire        loading;
    wire        busy;
    wire        running = enable && !loading;

    wh_registers #(
        .N                 (N)
    ) block (
        .clk               (clk),
        .rst               (rst),
        .bus_valid_i       (bus_valid),
        .bus_write_i       (bus_write),
        .bus_check_i       (bus_check),
        .bus_address_i     (bus_address),
        .bus_data_i        (bus_data),
        .bus_ready_o       (bus_ready),
        .bus_data_o        (bus_read),
        .bus_error_o       (bus_error),
        .bus_signed_o      (bus_signed),
        .carrier_o         (carrier),
        .frame_o           (frame),
        .sense_o           (sense),
        .filter_clocks_o   (filter_clocks),
        .delay_o           (delay),
        .bridge_o          (bridge),
        .host_o            (host),
        .guard_o           (guard),
        .force_o           (in_force),
        .write_o           (write),
        .write_bank_o      (write_bank),
        .address_o         (address),
        .data_o            (data),
        .clear_o           (clear),
        .host_alive_o      (host_alive),
        .zero_start_o      (zero_start),
        .restart_o         (restart),
        .command_o         (command),
        .command_address_o (command_address),
        .command_data_o    (command_data),
        .ready_o           (ready),
        .loading_o         (loading),
        .busy_o            (busy),
        .running_i         (running),
        .adc_ready_i       (1'b0),
        .tick_i            (tick),
        .faults_i          (faults),
        .live_valid_i      (live_valid),
        .live_port_i       (2'd0),
        .live_word_i       (4'd0),
        .live_data_i       (live_data),
        .other_i           (other)
    );

    (* hierconn *) wire [2:0]  \block.state_q ;
    (* hierconn *) wire        \block.copies_q ;
    (* hierconn *) wire [1:0]  \block.source_q ;
    (* hierconn *) wire [8:0]  \block.settle_q ;
    (* hierconn *) wire        \block.staged_q ;
    (* hierconn *) wire        \block.off_q ;
    (* hierconn *) wire [2:0]  \block.part_q ;
    (* hierconn *) wire [7:0]  \block.slot_q ;
    (* hierconn *) wire        \block.read_q ;
    (* hierconn *) wire [10:0] \block.read_place_q ;
    (* hierconn *) wire        \block.read_last_q ;
    (* hierconn *) wire [10:0] \block.place_q ;
    (* hierconn *) wire        \block.last_q ;
    (* hierconn *) wire [31:0] \block.word_q ;
    (* hierconn *) wire [31:0] \block.default_q ;
    (* hierconn *) wire        \block.written_q ;
    (* hierconn *) wire        \block.written_off_q ;
    (* hierconn *) wire        \block.commits_q ;
    (* hierconn *) wire        \block.discards_q ;
    (* hierconn *) wire        \block.accepted_q ;
    (* hierconn *) wire [1:0]  \block.kind ;
    (* hierconn *) wire        \block.enough_q ;
    (* hierconn *) wire [31:0] \block.read_data_q ;
    (* hierconn *) wire [9:0]  \block.written_ram.place ;
    (* hierconn *) wire [31:0] \block.written_ram.word_q ;
    (* hierconn *) wire [31:0] \block.written_ram.read_data_o ;
    (* hierconn *) wire [9:0]  \block.in_force_ram.place ;
    (* hierconn *) wire [31:0] \block.in_force_ram.word_q ;
    (* hierconn *) wire [31:0] \block.in_force_ram.read_data_o ;
    (* hierconn *) wire [8:0]  \block.rom.address ;
    (* hierconn *) wire [3:0]  \block.rom.info ;
    (* hierconn *) wire [3:0]  \block.rom.info_q ;
    (* hierconn *) wire [3:0]  \block.rom.told_q ;
    (* hierconn *) wire        \block.rom.here_q ;
    (* hierconn *) wire [31:0] \block.rom.least ;
    (* hierconn *) wire [31:0] \block.rom.greatest ;
    (* hierconn *) wire [31:0] \block.rom.bound_q ;
    (* hierconn *) wire [31:0] \block.rom.bound_o ;

    // ---- The setting, its address, and its place in the memories.
    (* anyconst *) wire [1:0] port;
    wire [8:0]  watched  = \block.rom.address ;
    wire        of_port  = watched[8];
    wire        off      = \block.rom.info [1];
    wire        has_sign = \block.rom.info [0];
    wire [31:0] least    = \block.rom.least ;
    wire [31:0] greatest = \block.rom.greatest ;
    wire [11:0] full     = {of_port ? {2'd0, port} + 4'd1 : 4'd0, watched[7:0]};
    wire [10:0] place    = of_port ? {1'b0, port, watched[7:0]} : {3'd0, BOARD + watched[7:0]};
    wire        here     = (bus_address == full);
    wire        known    = ({bus_address[11:8] != 4'd0, bus_address[7:0]} == watched);

    wire [2:0]  state    = \block.state_q ;
    wire        copies   = \block.copies_q ;
    wire [1:0]  source   = \block.source_q ;
    wire [8:0]  settle   = \block.settle_q ;
    wire [2:0]  part     = \block.part_q ;
    wire [7:0]  slot     = \block.slot_q ;
    wire        read     = \block.read_q ;
    wire        commits  = \block.commits_q ;
    wire        discards = \block.discards_q ;
    wire        writes   = \block.written_q ;
    wire [31:0] written  = \block.written_ram.word_q ;
    wire [31:0] forced   = \block.in_force_ram.word_q ;
    wire        flips    = write && \block.last_q ;
    wire        before   = busy && settle == 9'd0;  // the bank in force changes
    wire        looks    = (state != AT_IDLE);
    wire         reads_here = looks && here && !bus_write;
    wire [241+`WH_GUARD_W:0] all = {carrier, frame, sense, filter_clocks, delay, bridge, guard, host};

    function fits;  // it is in the setting's range
        input [31:0] word;
        fits = ({word[31] ^ has_sign, word[30:0]} >= least) && ({word[31] ^ has_sign, word[30:0]} <= greatest);
    endfunction

    // ---- What is kept here.
    reg         begun = 1'b0;
    reg         rst_q;
    reg         asked_q;
    reg         bus_write_q;
    reg         bus_check_q;
    reg  [11:0] bus_address_q;
    reg  [31:0] bus_data_q;
    reg  [31:0] bank_0_q;     // the station's
    reg  [31:0] bank_1_q;
    reg  [31:0] goal_q;       // what the pass is to bring, or has brought
    reg  [31:0] forced_q;     // a clock before
    reg         in_force_q;
    reg  [241+`WH_GUARD_W:0] all_q;
    reg         flips_q;
    reg  [9:0]  clocks_q;     // of busy
    reg  [9:0]  stalls_q;     // of these, such that a request took
    reg  [8:0]  since_q;      // clocks since the bank changed, 135 at most
    reg  [2:0]  waits_q;      // clocks of a request
    reg         commanded_q;  // a command was accepted
    reg         running_q;
    reg         off_here_q;   // it was written, and wants the bridges off
    reg         off_given_q;  // it is being committed

    wire [31:0] current = in_force ? bank_1_q : bank_0_q;
    wire [31:0] resting = in_force ? bank_0_q : bank_1_q;
    wire [9:0]  index   = (part == 3'd0 && slot >= BOARD) ? {2'd0, slot - BOARD}
                          : 10'd96 + {part, 7'd0} + {2'd0, slot};
    wire [9:0]  mine    = of_port ? 10'd96 + {1'b0, port, 7'd0} + {2'd0, watched[7:0]} : {2'd0, watched[7:0]};
    wire        reading = read && \block.read_place_q == place;
    wire        bringing = write && \block.place_q == place;
    wire        copied  = index > mine && !reading && !bringing;
    wire [31:0] taken   = (source == DEFAULTS) ? \block.default_q
                          : (source == IN_FORCE) ? \block.in_force_ram.read_data_o : \block.written_ram.read_data_o ;
    wire        excluded = bus_address[7] || (bus_address[11:8] == 4'd0 && bus_address[7:0] >= 8'h60);
    wire        discarding = busy && source == IN_FORCE;
    wire [31:0] expected = discarding ? forced : written;  // of a read
    wire [31:0] selected = discarding ? \block.in_force_ram.read_data_o : \block.written_ram.read_data_o ;
    wire [9:0]  fives   = {stalls_q[7:0], 2'd0} + stalls_q;  // 5 times
    wire [9:0]  room    = (state == AT_LOW)   ? 10'd5 : (state == AT_JUDGE) ? 10'd4 : (state == AT_DONE) ? 10'd3
                          : (state == AT_IDLE) ? 10'd2 : (state == AT_LEAST) ? 10'd1 : 10'd0;

    always @(posedge clk) begin
        begun         <= 1'b1;
        rst_q         <= rst;
        asked_q       <= bus_valid && !bus_ready && !rst;
        bus_write_q   <= bus_write;
        bus_check_q   <= bus_check;
        bus_address_q <= bus_address;
        bus_data_q    <= bus_data;
        in_force_q    <= in_force;
        forced_q      <= current;
        all_q         <= all;
        flips_q       <= flips;
        running_q     <= running;
        commanded_q   <= !rst && bus_ready && \block.accepted_q ;
        waits_q       <= (rst || !bus_valid || bus_ready || !ready) ? 3'd0 : waits_q + 3'd1;
        if (write && address == full) begin
            if (write_bank) bank_1_q <= data;
            else            bank_0_q <= data;
        end
        if (commits || discards) goal_q <= commits ? written : forced;
        if (source == DEFAULTS && reading) goal_q <= \block.default_q ;
        clocks_q      <= (rst || !busy) ? 10'd0 : clocks_q + 10'd1;
        stalls_q      <= (rst || !busy) ? 10'd0 : stalls_q + {9'd0, copies && state == AT_MOST};
        since_q       <= rst ? SETTLE : flips ? 9'd0 : (since_q == SETTLE) ? SETTLE : since_q + 9'd1;
        off_here_q    <= !rst && (off_here_q || (writes && here && off)) && !commits && !discards;
        off_given_q   <= !rst && ((commits && off_here_q) || off_given_q) && !(busy && settle == 9'd1);
    end

    // ---- The invariant.
    function walked;
        input [10:0] at;
        walked = at[10:8] < 3'd3 && (at[7:0] < 8'h80 || (at[10:8] == 3'd0 && at[7:0] >= BOARD));
    endfunction

    wire walks = (!busy || (copies ? walked({part, slot}) : part == 3'd3 && slot == 8'd0))
                 && (!read || walked(\block.read_place_q )) && (!write || walked(\block.place_q ));
    wire stage = (!busy || (copies && settle == 9'd0 && !(read && \block.read_last_q ) && !flips)
                  || (!copies && settle == 9'd0 && read && \block.read_last_q && !flips)
                  || (!copies && settle == 9'd0 && !read && flips)
                  || (!copies && settle != 9'd0 && !read && !write));
    wire rests = busy || (!copies && !read && !write && settle == 9'd0);
    wire times = !busy || (copies             ? clocks_q == index + stalls_q
                           : settle != 9'd0   ? clocks_q == 10'd480 + 10'd2 + stalls_q + {1'd0, SETTLE - settle}
                           : write && flips   ? clocks_q == 10'd480 + 10'd1 + stalls_q
                           : clocks_q == 10'd480 + stalls_q);
    wire stall = !busy || (stalls_q <= 10'd97 && fives <= (copies ? index + room : 10'd485));
    wire brings = (!(before && copied) || (resting == goal_q && (source == WRITTEN || written == goal_q)
                                           && (source == IN_FORCE || forced == goal_q)))
                  && (!(before && reading) || source == DEFAULTS || taken == goal_q)
                  && (!bringing || \block.word_q == goal_q)
                  && (!(before && source == WRITTEN) || written == goal_q)
                  && (!(before && source == IN_FORCE) || forced == goal_q)
                  && (before || (current == goal_q && forced == goal_q && (\block.staged_q || written == goal_q)));
    wire bus   = state <= AT_DONE && (!looks || (asked_q && ready))
                 && (ready ? !(busy && source == DEFAULTS) : busy && loading && source == DEFAULTS)
                 && (!looks || state == AT_LEAST || \block.rom.told_q [3:2] != 2'd1 || !excluded)
                 && (!(writes || commits || discards) || (state == AT_DONE && !busy && ready))
                 && (writes + commits + discards <= 2'd1) && waits_q == ((state == AT_IDLE) ? 3'd0 : state)
                 && (source != 2'd3);
    wire offs  = (!off_here_q || (\block.off_q && off)) && (!off_given_q || (busy && loading && off))
                 && (!\block.staged_q || !busy) && (!\block.off_q || \block.staged_q );
    wire banks = settle <= SETTLE && since_q == SETTLE - settle;
    wire told  = (!looks || ( \block.rom.here_q == known && (!known || \block.rom.info_q == \block.rom.info )))
                 && (!looks || \block.rom.info_q [3:2] != 2'd1 || !excluded)
                 && (state <= AT_LEAST || !known || \block.rom.told_q == \block.rom.info )
                 && (!writes || (!excluded && bus_address[11:8] <= 4'd3 && (!here || \block.written_off_q == off)))
                 && (!\block.accepted_q || state == AT_DONE);
    wire seen  = (!(reads_here && state == AT_LOW) || selected == expected)
                 && (!(reads_here && state == AT_JUDGE) || \block.read_data_q == expected)
                 && (!(reads_here && state == AT_DONE) || bus_read == expected);
    wire range = (ready ? fits(written) && fits(forced) && fits(goal_q)
                        : (before && !copied && !bringing) || fits(goal_q))
                 && (state != AT_MOST || !known || \block.rom.bound_q == least)
                 && (state != AT_LOW || !known || (\block.rom.bound_q == greatest && \block.rom.bound_o == least))
                 && (state != AT_JUDGE || !known
                     || (\block.rom.bound_o == greatest
                         && \block.enough_q == ({bus_data[31] ^ has_sign, bus_data[30:0]} >= least)))
                 && (!(writes && here) || fits(bus_data));
    wire invariant = walks && stage && rests && times && stall && brings && bus && offs && banks && told && seen
                     && range;

    always @(posedge clk) begin
        // The memories are looked at where the setting is. It is one, and has room.
        assume (\block.written_ram.place == place[9:0] && \block.in_force_ram.place == place[9:0]);
        assume (\block.rom.info [3:2] == 2'd1 && port < 2'd3);
        assume (of_port ? watched[7:0] < 8'h80 : watched[7:0] < 8'h60);
        assume (!(reading && source == DEFAULTS) || fits(\block.default_q ));
        if (bus_address[11:8] == 4'd0 && bus_address[7:0] >= 8'h60) assume (\block.rom.info_q [3:2] != 2'd1);

        if (asked_q) begin
            assume (bus_valid && bus_write == bus_write_q && bus_address == bus_address_q
                    && bus_data == bus_data_q && bus_check == bus_check_q);
        end

        if (!begun) begin
            assume (rst || invariant);
        end else begin
            assert (walks);
            assert (stage);
            assert (rests);
            assert (times);
            assert (stall);
            assert (brings);
            assert (bus);
            assert (offs);
            assert (banks);
            assert (told);
            assert (seen);
            assert (range);

            // Neither the memories nor a station get a value outside its range.
            if (write && address == full) assert (fits(data));

            // A commit ends.
            assert (!busy || clocks_q < MOST);

            // What is in force changes with the bank alone, to what was to come; so do the settings of all ports.
            if (!rst_q && in_force == in_force_q) assert (current == forced_q);
            if (!rst_q && in_force != in_force_q) assert (flips_q && current == goal_q);
            if (!flips_q) assert (all == all_q);

            // Nothing is written where a round may still read.
            if (write) assert (write_bank != in_force && since_q == SETTLE);

            // Requests, reads, commands.
            assert (waits_q <= 3'd5);
            assert (command == commanded_q);
            if (bus_ready && \block.accepted_q ) assert (bus_error == 2'd0 && bus_write && !bus_check);
            if (commits && off_here_q) assert (!running_q);
            if (off_given_q) assert (loading && !running);
        end

        cover (begun && !rst_q && flips_q && ready && !loading);
        cover (begun && commits && off_here_q);
        cover (begun && command && busy && !loading);
        cover (begun && bus_ready && bus_error == 2'd3 && here && bus_write && busy);
    end

endmodule

`default_nettype wire
