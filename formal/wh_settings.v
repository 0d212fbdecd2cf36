// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_settings: of one setting, which may be any, with any range: a word outside of it is never
// stored, in either bank, and never goes to the groups. Every request ends, within CLOCKS clocks once reset's words
// are given. What is read is what is in force; that changes with a change-over only, to what was written;
// after its copy both banks are the same. A request that ends in an error writes nothing.
// What is judged only is never stored. A change-over waits for the groups (changing) for PATIENCE ticks at
// most: then now_o has them change.
// A word that wants the bridges off is accepted while they are off only, and so is the commit that gives
// it, from which on loading_o is high until all words are copied. Nothing on the bus can raise loading_o's
// opposite: the bridges (running) are what enable and loading_o make of them, and enable may be anything.
//
// The master holds what it asks for until it is answered. Banks and table: any_settings_ram,
// any_settings_rom. Proven by induction, smtbmc z3.

`default_nettype none

module prove_wh_settings (
    input wire        clk,
    input wire        rst,
    input wire        bus_valid,
    input wire        bus_write,
    input wire        bus_check,
    input wire [11:0] bus_address,
    input wire [31:0] bus_data,
    input wire [31:0] live,
    input wire        enable,
    input wire        tick,
    input wire        changing
);

    localparam integer CLOCKS = 9;
    localparam [3:0] PATIENCE = 4'd15;

    localparam [3:0] IDLE  = 4'd0;
    localparam [3:0] LEAST = 4'd1;
    localparam [3:0] MOST  = 4'd2;
    localparam [3:0] LOW   = 4'd3;
    localparam [3:0] JUDGE = 4'd4;
    localparam [3:0] DONE  = 4'd5;
    localparam [3:0] READ  = 4'd6;
    localparam [3:0] TAKE  = 4'd7;
    localparam [3:0] WRITE = 4'd8;

    wire        bus_ready;
    wire [31:0] bus_read;
    wire [1:0]  bus_error;
    wire        bus_signed;
    wire        command;
    wire        ready;
    wire        loading;
    wire        busy;
    wire        write;
    wire        copy;
    wire [11:0] address;
    wire [31:0] data;
    wire        change;
    wire        now;
    wire        discard;
    wire        running = enable && !loading;

    wh_settings block (
        .clk           (clk),
        .rst           (rst),
        .bus_valid_i   (bus_valid),
        .bus_write_i   (bus_write),
        .bus_check_i   (bus_check),
        .bus_address_i (bus_address),
        .bus_data_i    (bus_data),
        .bus_ready_o   (bus_ready),
        .bus_data_o    (bus_read),
        .bus_error_o   (bus_error),
        .bus_signed_o  (bus_signed),
        .live_i        (live),
        .command_o     (command),
        .running_i     (running),
        .tick_i        (tick),
        .ready_o       (ready),
        .loading_o     (loading),
        .busy_o        (busy),
        .write_o       (write),
        .copy_o        (copy),
        .address_o     (address),
        .data_o        (data),
        .change_o      (change),
        .now_o         (now),
        .discard_o     (discard),
        .changing_i    (changing)
    );

    (* hierconn *) wire [3:0]  \block.state_q ;
    (* hierconn *) wire        \block.fresh_q ;
    (* hierconn *) wire        \block.pass_q ;
    (* hierconn *) wire [7:0]  \block.place_q ;
    (* hierconn *) wire        \block.wait_q ;
    (* hierconn *) wire        \block.settle_q ;
    (* hierconn *) wire        \block.change_q ;
    (* hierconn *) wire [3:0]  \block.ticks_q ;
    (* hierconn *) wire        \block.force_q ;
    (* hierconn *) wire        \block.loading_q ;
    (* hierconn *) wire        \block.off_q ;
    (* hierconn *) wire        \block.staged_q ;
    (* hierconn *) wire        \block.enough_q ;
    (* hierconn *) wire        \block.written_q ;
    (* hierconn *) wire        \block.written_off_q ;
    (* hierconn *) wire        \block.commits_q ;
    (* hierconn *) wire        \block.discards_q ;
    (* hierconn *) wire [7:0]  \block.ram.place ;
    (* hierconn *) wire [31:0] \block.ram.first ;
    (* hierconn *) wire [31:0] \block.ram.low_q ;
    (* hierconn *) wire [31:0] \block.ram.high_q ;
    (* hierconn *) wire [31:0] \block.ram.read_data_o ;
    (* hierconn *) wire [31:0] \block.read_q ;
    (* hierconn *) wire [8:0]  \block.rom.address ;
    (* hierconn *) wire [3:0]  \block.rom.info ;
    (* hierconn *) wire [3:0]  \block.rom.info_q ;
    (* hierconn *) wire        \block.rom.here_q ;
    (* hierconn *) wire [31:0] \block.rom.least ;
    (* hierconn *) wire [31:0] \block.rom.greatest ;
    (* hierconn *) wire [3:0]  \block.rom.told_q ;
    (* hierconn *) wire [31:0] \block.rom.bound_q ;
    (* hierconn *) wire [31:0] \block.rom.bound_o ;

    wire [3:0]  state    = \block.state_q ;
    wire        in_force = \block.force_q ;
    wire [31:0] least    = \block.rom.least ;
    wire [31:0] greatest = \block.rom.greatest ;
    wire [31:0] current  = in_force ? \block.ram.high_q : \block.ram.low_q ;
    wire [31:0] resting  = in_force ? \block.ram.low_q : \block.ram.high_q ;
    wire [8:0]  watched  = \block.rom.address ;
    wire [7:0]  place    = \block.ram.place ;
    wire        has_sign = \block.rom.info [0];
    wire        off      = \block.rom.info [1];
    wire        setting  = (\block.rom.info [3:2] == 2'd1);

    // The watched word: that of motor 0, or of the board.
    wire [11:0] full     = {3'd0, watched[8], watched[7:0]};
    wire        here     = (bus_address == full);
    wire        told     = bus_valid && here && bus_write;

    function fits;
        input [31:0] word;
        fits = ({word[31] ^ has_sign, word[30:0]} >= least)
               && ({word[31] ^ has_sign, word[30:0]} <= greatest);
    endfunction

    reg         begun = 1'b0;
    reg         rst_q;
    reg         asked_q;      // a request stood without an answer
    reg         bus_write_q;
    reg         bus_check_q;
    reg  [11:0] bus_address_q;
    reg  [31:0] bus_data_q;
    reg  [31:0] current_q;
    reg  [31:0] current_q2;
    reg  [31:0] resting_q;
    reg         in_force_q;
    reg         running_q;
    reg         tick_q;
    reg         now_q;
    reg         now_q2;
    reg  [3:0]  ticks_q;      // of this change-over
    reg         accepts_q;    // the watched word was accepted in the clock before
    reg         copies_q;
    reg  [3:0]  waits_q;      // clocks of a request
    reg         off_here_q;   // the watched word is written, and wants the bridges off
    reg         off_given_q;  // it is being given

    wire [7:0] at       = \block.place_q ;
    wire       fresh    = \block.fresh_q ;
    wire       pass     = \block.pass_q ;
    wire       waits    = \block.wait_q ;
    wire       settles  = \block.settle_q ;
    wire       begins   = \block.change_q ;
    wire       accepts  = write && here;
    wire       copied   = !pass || at > place;
    wire       commits  = \block.commits_q ;
    wire       discards = \block.discards_q ;
    wire       looks    = (state == LEAST || state == MOST || state == LOW || state == JUDGE
                             || state == DONE);
    wire       known    = ({bus_address[11:8] != 4'd0, bus_address[7:0]} == watched);

    always @(posedge clk) begin
        begun         <= 1'b1;
        rst_q         <= rst;
        asked_q       <= bus_valid && !bus_ready && !rst;
        bus_write_q   <= bus_write;
        bus_check_q   <= bus_check;
        bus_address_q <= bus_address;
        bus_data_q    <= bus_data;
        current_q     <= current;
        current_q2    <= current_q;
        resting_q     <= resting;
        in_force_q    <= in_force;
        running_q     <= running;
        tick_q        <= tick;
        now_q         <= now && !rst;
        now_q2        <= now_q && !rst;
        ticks_q       <= !settles ? 4'd0 : (tick && ticks_q != PATIENCE) ? ticks_q + 4'd1 : ticks_q;
        accepts_q     <= accepts && !rst;
        copies_q      <= copy && !rst;
        waits_q       <= (rst || !bus_valid || bus_ready || !ready) ? 4'd0 : waits_q + 4'd1;
        off_here_q    <= !rst && (off_here_q || (accepts && off)) && !commits && !discards;
        off_given_q   <= !rst && ((commits && off_here_q) || (off_given_q && !(copy && at == 8'hff)));

        // The memory is for a board and one motor. The table's word has a place, and a range that its
        // default is in, and is none of the memory's own.
        assume (place == {watched[8], watched[6:0]} && !watched[7]);
        assume (setting && least <= greatest && fits(\block.ram.first ));
        assume (full != 12'h070 && full != 12'h071);

        // From reset, or from rest with any words in force; the proof itself says that this is what is
        // left of both.
        if (!begun) begin
            assume (rst || (state == IDLE && !fresh && !pass && !waits && !settles && at == 8'd0
                            && !write && !commits && !discards && !command && !begins
                            && !loading && !\block.staged_q && !\block.off_q && fits(current)
                            && resting == current));
            assume (!asked_q && waits_q == 4'd0 && !off_here_q && !off_given_q && !accepts_q);
            assume (!now_q && !now_q2 && ticks_q == 4'd0 && (rst || \block.ticks_q == 4'd0));
        end else begin
            if (asked_q) begin
                assume (bus_valid && bus_write == bus_write_q && bus_address == bus_address_q
                        && bus_data == bus_data_q && bus_check == bus_check_q);
            end

            // Nothing out of range is stored, or goes to the groups.
            if (ready) assert (fits(current));
            if (copied) assert (fits(resting));
            if (accepts) assert (fits(bus_data) && !bus_check && bus_ready && bus_error == 2'd0);

            // Every request ends.
            assert (waits_q < CLOCKS);

            // What is in force is what is read, and changes with a change-over only.
            if (!rst_q && ready && in_force == in_force_q) assert (current == current_q);
            if (!rst_q && ready && in_force != in_force_q) assert (current == resting_q);
            if (bus_ready && here && !bus_write && bus_error == 2'd0) assert (bus_read == current_q2);

            // What is written is what is accepted or copied; a copy makes both banks the same.
            if (!rst_q && in_force == in_force_q && !accepts_q && !copies_q) begin
                assert (resting == resting_q);
            end
            if (!rst_q && accepts_q) assert (resting == bus_data_q);
            if (ready && copied && !waits && !settles && !\block.staged_q ) begin
                assert (resting == current);
            end

            // Bridges that have to be off, when that was judged.
            if (accepts && off) assert (!running_q);
            if (commits && off_here_q) assert (!running_q);
            if (off_given_q) assert (loading && !running);
            if (begins && running_q) assert (tick_q && !off_given_q && !off_here_q);
            if (begins) assert (waits);
            assert (change == (begins || settles));
            assert (discard == discards);

            // A change-over waits for PATIENCE ticks; then no group is held, nor pending a clock later.
            assert (now == (settles && ticks_q == PATIENCE));
            if (now_q) assume (!changing);
            assert (!(now && now_q && now_q2));
            assert (\block.ticks_q == ticks_q || !settles);
            if (!ready) assert (loading);

            // What makes that inductive.
            assert (state <= WRITE);
            if (looks) assert (asked_q && ready);
            if (looks) assert (\block.rom.here_q == known);
            if (looks && known) assert (\block.rom.info_q == \block.rom.info );
            if (looks && bus_address[7]) assert (\block.rom.info_q [3:2] != 2'd1);
            if (looks && bus_address[11:1] == 11'h038) assert (\block.rom.info_q == 4'b1000);
            if (looks && state != LEAST) begin
                if (known) assert (\block.rom.told_q == \block.rom.info );
                if (bus_address[7]) assert (\block.rom.told_q [3:2] != 2'd1);
                if (bus_address[11:1] == 11'h038) assert (\block.rom.told_q == 4'b1000);
            end
            if (state == MOST && known) assert (\block.rom.bound_q == least);
            if (state == LOW && known) begin
                assert (\block.rom.bound_q == greatest && \block.rom.bound_o == least);
            end
            if (state == JUDGE && known) begin
                assert (\block.rom.bound_o == greatest);
                assert (\block.enough_q
                        == ({bus_data[31] ^ has_sign, bus_data[30:0]} >= least));
            end
            if (looks && here) assert (\block.ram.read_data_o == current_q);
            if (state == READ || state == TAKE || state == WRITE) assert (pass);
            if (state == TAKE && at == place) begin
                assert (\block.ram.read_data_o == (fresh ? \block.ram.first : current));
            end
            if (state == WRITE && at == place) begin
                assert (\block.read_q == (fresh ? \block.ram.first : current));
            end
            assert (pass || at == 8'd0);
            assert (!(pass && (waits || settles)) && !(waits && settles));
            assert (!fresh || pass || waits || settles);
            if (fresh) assert (!\block.staged_q && !\block.off_q && !off_here_q && !off_given_q);
            if (off_here_q) assert (\block.off_q && \block.staged_q && off);
            if (off_given_q) assert (\block.loading_q && busy);
            if (\block.staged_q ) assert (!busy);
            if (\block.written_q || commits || discards) begin
                assert (state == DONE && !busy && !fresh && bus_error == 2'd0 && bus_write && !bus_check);
            end
            assert (\block.written_q + commits + discards <= 2'd1);
            if (accepts) assert (\block.written_off_q == off);
            if (\block.written_q ) assert (bus_address[11:9] == 3'd0 && !bus_address[7]);
            case (state)
                READ:    assert (waits_q == 4'd0);
                TAKE:    assert (waits_q <= 4'd1);
                WRITE:   assert (waits_q <= 4'd2);
                IDLE:    assert (waits_q <= 4'd3);
                LEAST:   assert (waits_q <= 4'd4);
                MOST:    assert (waits_q <= 4'd5);
                LOW:     assert (waits_q <= 4'd6);
                JUDGE:   assert (waits_q <= 4'd7);
                default: assert (waits_q <= 4'd8);
            endcase
        end

        cover (begun && accepts && !running && off && ready);
        cover (begun && accepts && running && !off);
        cover (begun && bus_ready && bus_error == 2'd2 && here);
        cover (begun && bus_ready && bus_error == 2'd3 && here);
    end

endmodule

`default_nettype wire
