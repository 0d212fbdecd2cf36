// SPDX-License-Identifier: Apache-2.0
//
// wh_settings: the register file and its bus. Settings are written while the controller runs, and applied together.
//
// A request holds bus_valid_i until bus_ready_o: it writes bus_data_i to bus_address_i, or reads bus_data_o from it,
// which is valid with bus_ready_o. Addresses, kinds and ranges are those of rtl/words.toml (wh_settings_rom). A signed
// value is sign-extended to 32 bits; bus_signed_o is then 1, with bus_ready_o.
// bus_error_o: 0 done; 1 no such register, or it can't be written or read; 2 the value is outside its range; 3 not now:
// the setting or the command needs the bridges off, or a setting is written during a commit (busy_o). A request with
// an error changes nothing. With bus_check_i a write is judged only: the answer is the same, and nothing changes.
//
// There are two banks. One is in force and is read. Writes go to the other one, and to the groups (wh_setting_group) by
// write_o. Writing 1 to `commit` applies them: from the clock after a tick on, or at once with the bridges off
// (running_i = 0), change_o is 1, and every written group takes its new settings as soon as no block reads the old
// ones. Once all have (changing_i), the banks swap. Then all settings are copied to the other bank, and pass by the
// groups with copy_o as well. Writing 1 to `discard` (discard_o) starts such a copy without a swap.
// After PATIENCE further ticks no group waits any more (now_o), so every commit ends with any settings. Blocks that
// keep up with their ticks have released all settings long before.
// Settings that need the bridges off are applied as they are copied. Meanwhile loading_o requires the bridges off, and
// the blocks that read them have to restart. If such settings were written and the bridges are on, `commit` is refused
// with error 3.
//
// Commands of other blocks are passed on by command_o. Live values come from live_i, at least 4 clocks after their
// address was on the bus.
//
// Latency: 5 clocks from bus_valid_i to bus_ready_o, 1 to 3 more during a copy: values from block RAM are late in their
// clock, so they are compared and passed on in the next one. A copy takes 4 clocks for each address of the memory,
// (N + 1) 2^SLOT_W or the next power of two, and 5 more for each request meanwhile. The swap takes no clock if no group
// is held.
// Reset: the defaults are applied like a commit; until then no request ends. ready_o rises then; before, the groups'
// values are invalid.

`default_nettype none
`include "wh_formats.vh"

module wh_settings #(
    parameter integer N          = 1,  // as wh_controller has them
    parameter integer WALLS      = 4,
    parameter integer SHAPER     = 0,
    parameter integer DELAY_LOG2 = 2,
    parameter integer LEGS       = 2,  // as wh_device has it; with 3 there are N = 2 axes
    parameter integer SLOT_W     = (SHAPER > 0) ? 8 : 7  // derived, leave it
) (
    input  wire        clk,
    input  wire        rst,

    // The bus.
    input  wire        bus_valid_i,    // held until bus_ready_o, as are the words below
    input  wire        bus_write_i,
    input  wire        bus_check_i,
    input  wire [11:0] bus_address_i,
    input  wire [31:0] bus_data_i,
    output wire        bus_ready_o,    // strobe
    output wire [31:0] bus_data_o,
    output wire [1:0]  bus_error_o,
    output wire        bus_signed_o,

    // What is read and told besides settings.
    input  wire [31:0] live_i,         // the live word that the bus asks for
    output wire        command_o,      // strobe, bus_address_i and bus_data_i are a command

    // The controller.
    input  wire        running_i,      // the bridges are on
    input  wire        tick_i,         // strobe, last clock of a tick
    output wire        ready_o,        // the groups have words
    output wire        loading_o,      // the bridges have to stay off
    output wire        busy_o,         // nothing can be written

    // The groups.
    output wire        write_o,        // strobe, a word was accepted
    output wire        copy_o,         // strobe, a word is copied
    output wire [11:0] address_o,
    output wire [31:0] data_o,
    output wire        change_o,       // groups take their words over
    output wire        now_o,          // also those whose words are being read
    output wire        discard_o,      // strobe
    input  wire        changing_i      // a group has still to change
);

    localparam integer PART_W  = $clog2(N + 1);
    localparam integer PLACE_W = PART_W + SLOT_W;

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_settings_n_must_be_1_to_8 stop ();
        end
        if (LEGS == 3 && N != 2) begin : illegal_axes
            wh_illegal_parameter_settings_n_must_be_2_with_three_legs stop ();
        end
    endgenerate

    localparam [1:0] SETTING = 2'd1;
    localparam [1:0] COMMAND = 2'd2;
    localparam [1:0] LIVE    = 2'd3;

    // Words of the memory itself.
    localparam [11:0] COMMIT  = 12'h070;
    localparam [11:0] DISCARD = 12'h071;
    localparam [11:0] BUSY    = 12'h072;
    localparam [11:0] STAGED  = 12'h073;

    localparam [3:0] IDLE  = 4'd0;
    localparam [3:0] LEAST = 4'd1;  // the least word of the range is asked for
    localparam [3:0] MOST  = 4'd2;  // the greatest one
    localparam [3:0] LOW   = 4'd3;  // the least one is compared
    localparam [3:0] JUDGE = 4'd4;  // the greatest one
    localparam [3:0] DONE  = 4'd5;
    localparam [3:0] READ  = 4'd6;  // of a word that is copied
    localparam [3:0] TAKE  = 4'd7;
    localparam [3:0] WRITE = 4'd8;

    // Longer than wh_bus_scale takes in ticks of 24 clocks.
    localparam [3:0] PATIENCE = 4'd15;

    reg  [3:0]         state_q;
    reg                fresh_q;    // since reset: the defaults are still to be given
    reg                pass_q;     // words are copied
    reg  [PLACE_W-1:0] place_q;    // the next one
    reg                wait_q;     // the change-over waits for a tick's end
    reg                settle_q;   // the groups change
    reg  [3:0]         ticks_q;    // since then, PATIENCE at most
    reg                force_q;    // the bank in force
    reg                loading_q;
    reg                staged_q;   // something was written
    reg                off_q;      // of that, something for which the bridges are off
    reg  [1:0]         error_q;

    wire last = (place_q == {PLACE_W{1'b1}});

    // ---- What the table says of the address.

    wire [1:0]  kind;
    wire        off;
    wire        has_sign;
    wire [31:0] bound;
    wire        in_part = ({28'd0, bus_address_i[11:8]} <= N);

    wh_settings_rom #(
        .WALLS      (WALLS),
        .SHAPER     (SHAPER),
        .DELAY_LOG2 (DELAY_LOG2),
        .LEGS       (LEGS)
    ) rom (
        .clk        (clk),
        .address_i  ({bus_address_i[11:8] != 4'd0, bus_address_i[7:0]}),
        .second_i   (LEGS == 3 && bus_address_i[11:8] == 4'd2),
        .kind_o     (kind),
        .off_o      (off),
        .signed_o   (has_sign),
        .greatest_i (state_q == MOST),
        .bound_o    (bound)
    );

    // One subtraction for both ends: the carry of bound - data says bound >= data, and that of
    // bound - data - 1 bound > data.
    reg         enough_q;  // not below the least word
    wire [31:0] value = {bus_data_i[31] ^ has_sign, bus_data_i[30:0]};
    wire [33:0] difference = {1'b0, bound, 1'b1} + {1'b0, ~value, state_q == JUDGE};
    wire        reaches    = difference[33];
    wire        in_range   = enough_q && reaches;
    wire        unused_difference = &{1'b0, difference[32:0]};

    // ---- The verdict.

    wire setting = (kind == SETTING) && in_part;
    wire fixed   = (kind == LIVE) && off && in_part;
    wire command = (kind == COMMAND) && in_part;
    wire live    = (kind == LIVE) && !off && in_part;
    wire commit  = (bus_address_i == COMMIT);
    wire discard = (bus_address_i == DISCARD);

    assign busy_o = wait_q || settle_q || pass_q;

    wire known   = bus_write_i ? (setting || command) : (setting || fixed || live);
    wire not_now = (off && running_i) || (setting && busy_o)
                   || (commit && (busy_o || (off_q && running_i))) || (discard && busy_o);
    wire [1:0] verdict = !known                   ? 2'd1
                       : !bus_write_i             ? 2'd0
                       : !in_range                ? 2'd2
                       : not_now                  ? 2'd3 : 2'd0;

    // What is accepted is done in the clock after, with bus_ready_o.
    wire accepts = (state_q == JUDGE) && bus_write_i && !bus_check_i && (verdict == 2'd0);
    reg  written_q;
    reg  written_off_q;  // of such a word: the bridges have to be off
    reg  commits_q;
    reg  discards_q;
    reg  commands_q;

    always @(posedge clk) begin
        written_q     <= !rst && accepts && setting;
        written_off_q <= off;
        commits_q     <= !rst && accepts && commit && bus_data_i[0];
        discards_q    <= !rst && accepts && discard && bus_data_i[0];
        commands_q    <= !rst && accepts && command && !commit && !discard;
    end

    assign command_o = commands_q;

    // ---- The banks. Places beyond the last motor's are copied too, and mean nothing.

    wire [PLACE_W-1:0] bus_place  = {bus_address_i[8 +: PART_W], bus_address_i[SLOT_W-1:0]};
    wire               copies     = (state_q == WRITE);
    wire [31:0]        read_data;
    reg  [31:0]        read_q;

    wh_settings_ram #(
        .WALLS           (WALLS),
        .SHAPER          (SHAPER),
        .PART_W          (PART_W),
        .SLOT_W          (SLOT_W)
    ) ram (
        .clk             (clk),
        .write_i         (written_q || copies),
        .write_bank_i    ({1'b0, !force_q}),
        .write_address_i (copies ? place_q : bus_place),
        .write_data_i    (data_o),
        .read_bank_i     ({fresh_q, force_q && !fresh_q}),
        .read_address_i  ((state_q == READ) ? place_q : bus_place),
        .read_data_o     (read_data)
    );

    wire [3:0] copy_part = {{4-PART_W{1'b0}}, place_q[SLOT_W +: PART_W]};
    wire [7:0] copy_slot = {{8-SLOT_W{1'b0}}, place_q[SLOT_W-1:0]};

    assign write_o   = written_q;
    assign copy_o    = copies;
    assign address_o = copies ? {copy_part, copy_slot} : bus_address_i;
    assign data_o    = copies ? read_q : bus_data_i;

    wire [31:0] own = {31'd0, (bus_address_i == BUSY) ? busy_o : staged_q};

    assign bus_ready_o  = (state_q == DONE);
    assign bus_error_o  = error_q;
    assign bus_signed_o = has_sign;
    assign bus_data_o  = !live ? read_q
                       : (bus_address_i == BUSY || bus_address_i == STAGED) ? own : live_i;

    // ---- The change-over.

    assign ready_o   = !fresh_q;
    assign loading_o = loading_q;

    wire ends   = copies && last;
    // A clock after the tick, whose end comes late in its clock for all the groups.
    reg  change_q;
    wire change = wait_q && !change_q && (tick_i || !running_i);

    assign change_o  = change_q || settle_q;
    assign now_o     = settle_q && (ticks_q == PATIENCE);
    assign discard_o = discards_q;

    always @(posedge clk) begin
        if (!settle_q) begin
            ticks_q <= 4'd0;
        end else if (tick_i && !now_o) begin
            ticks_q <= ticks_q + 4'd1;
        end
    end

    always @(posedge clk) begin
        read_q <= read_data;
        if (state_q == LOW) begin
            enough_q <= !reaches;
        end
        if (state_q == JUDGE) begin
            error_q <= verdict;
        end
        if (rst) begin
            state_q   <= IDLE;
            fresh_q   <= 1'b1;
            pass_q    <= 1'b1;
            place_q   <= {PLACE_W{1'b0}};
            wait_q    <= 1'b0;
            change_q  <= 1'b0;
            settle_q  <= 1'b0;
            force_q   <= 1'b0;
            loading_q <= 1'b1;
            staged_q  <= 1'b0;
            off_q     <= 1'b0;
        end else begin
            case (state_q)
                IDLE:    state_q <= (bus_valid_i && !fresh_q) ? LEAST : pass_q ? READ : IDLE;
                LEAST:   state_q <= MOST;
                MOST:    state_q <= LOW;
                LOW:     state_q <= JUDGE;
                JUDGE:   state_q <= DONE;
                DONE:    state_q <= pass_q ? READ : IDLE;
                READ:    state_q <= TAKE;
                TAKE:    state_q <= WRITE;
                default: state_q <= IDLE;
            endcase

            if (copies) begin
                place_q <= place_q + {{PLACE_W-1{1'b0}}, 1'b1};
            end
            if (settle_q && !changing_i) begin
                settle_q <= 1'b0;
                force_q  <= !force_q;
                fresh_q  <= 1'b0;
                pass_q   <= 1'b1;
            end else if (discards_q) begin
                pass_q   <= 1'b1;
            end else if (ends) begin
                pass_q   <= 1'b0;
            end

            // The defaults have been read into the resting bank: they are given like others.
            change_q <= change;
            wait_q   <= commits_q || (ends && fresh_q) || (wait_q && !change_q);
            if (change_q) begin
                settle_q <= 1'b1;
            end

            if (commits_q && off_q) begin
                loading_q <= 1'b1;
            end else if (ends && !fresh_q) begin
                loading_q <= 1'b0;
            end

            staged_q <= (staged_q || written_q) && !(commits_q || discards_q);
            off_q    <= (off_q || (written_q && written_off_q)) && !(commits_q || discards_q);
        end
    end

endmodule

`default_nettype wire
