// SPDX-License-Identifier: Apache-2.0
//
// wh_registers: the register bus of wh_ports. It holds the settings and commits them together, hands commands on,
// and keeps the last live value of each port.
//
// A request holds bus_valid_i until bus_ready_o. Addresses, kinds and ranges are those of rtl/words.toml
// (wh_settings_rom). A register with a sign is sign-extended to 32 bits; bus_signed_o is then 1.
// bus_error_o, with bus_ready_o:
//   0 done
//   1 no such register, or it can't be written or read; it reads 0
//   2 the value is outside its range
//   3 not now: a setting, `commit` or `discard` during a commit (busy_o); a setting or a command that needs the
//     bridges off, while they are on; `commit` with such a setting written, while they are on
// A request that ends with an error changes nothing. With bus_check_i a write is judged only.
//
// Settings are in three memories:
//   written   what the bus wrote and reads
//   in force  as of the last commit
//   defaults  a ROM; all ports have the same
// A pass reads one of these from its first setting to its last, one a clock, and writes each into the others, into
// the stations' bank that isn't in force (wh_port_settings), and into the shadow registers of the settings of all
// ports. With the last one, force_o selects that bank, and the settings of all ports change in the same
// clock. wh_slots takes force_i as a round begins, so each round has the settings of one commit. A pass writes every
// setting, so the other bank's old contents don't matter. `commit` starts a pass from the written settings, `discard`
// one from those in force, a reset one from the defaults.
//
// After a pass, a round that began before still uses the old bank: the next pass waits SETTLE clocks.
// Settings of all ports need the bridges off. During a commit of such a setting loading_o is high: then the bridges
// have to stay off, and restart_o restarts carrier and ADC.
//
// A brushless motor (AXES) has its settings in alpha's part. Only the zeros and gains of its phases are in the parts of
// both axes; beta's other settings are those of alpha, whatever is written. The settings of the magnets are common to
// all brushless motors.
//
// Commands and reads never wait. Live values: those of a step read 0 while the bridges are off. A packet's number and
// its v belong together if both are read within 64 clocks.
//
// Latency: 5 clocks from bus_valid_i to bus_ready_o, always; a command's strobe comes a clock later. busy_o is high
// from the clock after the answer to `commit` on, for
//     COPIED + 2 + SETTLE ... COPIED + COPIED / 5 + 3 + SETTLE clocks,
// COPIED = 96 + 128 N, or 96 + 152 N with a shaper, SETTLE = 27 + 36 N; force_o changes SETTLE clocks before the end. A
// request takes a clock of the pass; nothing else on bus or ports delays it.
// Reset: a pass from the defaults; ready_o rises at its end. Until then no request ends, and the ports have to be in
// reset.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_registers #(
    parameter integer N          = 1,  // as in wh_ports
    parameter integer WALLS      = 4,
    parameter integer DELAY_LOG2 = 2,
    parameter integer SHAPER     = 0,
    parameter integer AXES       = 0,  // 0...: bit n: ports n, n + 1 are a brushless motor's axes
    parameter integer PORT_W     = (N > 1) ? $clog2(N) : 1  // derived, leave it
) (
    input  wire                     clk,
    input  wire                     rst,

    // The bus.
    input  wire                     bus_valid_i,    // held until bus_ready_o, as are the four below
    input  wire                     bus_write_i,
    input  wire                     bus_check_i,
    input  wire [11:0]              bus_address_i,
    input  wire [31:0]              bus_data_i,
    output wire                     bus_ready_o,    // strobe
    output wire [31:0]              bus_data_o,
    output wire [1:0]               bus_error_o,
    output wire                     bus_signed_o,

    // Settings of all ports, packed as in wh_ports.
    output wire [65:0]              carrier_o,
    output wire [56:0]              frame_o,
    output wire [70:0]              sense_o,
    output wire [3:0]               filter_clocks_o,
    output wire [2*DELAY_LOG2-1:0]  delay_o,
    output wire [27:0]              bridge_o,
    output wire [`WH_GUARD_W-1:0]   guard_o,
    output wire [11:0]              host_o,
    output wire [64:0]              magnets_o,      // AXES

    // Settings of each port.
    output wire                     force_o,
    output wire                     write_o,        // strobe
    output wire                     write_bank_o,
    output wire [11:0]              address_o,
    output wire [31:0]              data_o,

    // Commands. Those of other modules are command_o, with address and data.
    output wire                     clear_o,        // strobes
    output wire                     host_alive_o,
    output wire                     zero_start_o,
    output wire                     magnet_start_o,
    output wire                     restart_o,      // and while loading_o
    output wire                     command_o,      // strobe, of any command
    output wire [11:0]              command_address_o,
    output wire [31:0]              command_data_o,

    // State.
    output wire                     ready_o,        // all settings were written since reset
    output wire                     loading_o,      // the bridges have to stay off
    output wire                     busy_o,         // a commit is under way
    input  wire                     running_i,      // the bridges are on
    input  wire                     adc_ready_i,
    input  wire                     tick_i,         // strobe
    input  wire [`WH_FAULTS-1:0]    faults_i,

    // Live values.
    input  wire                     live_valid_i,   // strobe
    input  wire [PORT_W-1:0]        live_port_i,
    input  wire [3:0]               live_word_i,    // WH_LIVE_...
    input  wire [31:0]              live_data_i,
    input  wire [31:0]              other_i         // of other modules, for bus_address_i, up to 4 clocks late
);

    localparam integer   PART_W  = (N > 1) ? PORT_W : 0;
    localparam integer   PLACE_W = PART_W + 8;
    localparam integer   LAST    = N - 1;
    localparam integer   BETAS   = AXES << 1;
    localparam [7:0]     BOARD   = 8'ha0;  // the settings of all ports, in the first port's part of a memory
    localparam [7:0]     LAST_SLOT = (SHAPER > 0) ? 8'h97 : 8'h7f;  // of a port's settings
    localparam integer   ROUND   = 27 + 36 * N;  // clocks until a round that has begun has read all its settings
    localparam [8:0]     SETTLE  = ROUND[8:0];

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_registers_n_must_be_1_to_8 stop ();
        end
    endgenerate

    // Registers of the memory itself, and commands.
    localparam [11:0] ZERO_START = 12'h01d;
    localparam [11:0] CLEAR      = 12'h060;
    localparam [11:0] HOST_ALIVE = 12'h061;
    localparam [11:0] MAGNETS    = 12'h065;
    localparam [11:0] RESTART    = 12'h06d;
    localparam [11:0] COMMIT     = 12'h070;
    localparam [11:0] DISCARD    = 12'h071;

    localparam [1:0] SETTING = 2'd1;
    localparam [1:0] COMMAND = 2'd2;
    localparam [1:0] LIVE    = 2'd3;

    localparam [2:0] IDLE  = 3'd0;
    localparam [2:0] LEAST = 3'd1;  // the least value of the range is read
    localparam [2:0] MOST  = 3'd2;  // the greatest one, and the written setting
    localparam [2:0] LOW   = 3'd3;  // the least one is compared
    localparam [2:0] JUDGE = 3'd4;  // the greatest one
    localparam [2:0] DONE  = 3'd5;

    localparam [1:0] WRITTEN  = 2'd0;
    localparam [1:0] IN_FORCE = 2'd1;
    localparam [1:0] DEFAULTS = 2'd2;

    reg [2:0] state_q;
    reg       ready_q;
    reg       pass_q;     // from the pass' begin until SETTLE clocks after its end
    reg       copies_q;   // settings remain to be read
    reg [1:0] source_q;
    reg [8:0] settle_q;   // clocks of SETTLE that remain
    reg       force_q;
    reg       loading_q;
    reg       staged_q;   // something was written since the last pass
    reg       off_q;      // of these, one that needs the bridges off

    // ---- The register map's entry of the address.
    wire [1:0]  kind;
    wire        off;
    wire        has_sign;
    wire [31:0] bound;
    wire        of_board = (bus_address_i[11:8] == 4'd0);
    wire        in_part  = ({28'd0, bus_address_i[11:8]} <= N);

    wh_settings_rom #(
        .WALLS      (WALLS),
        .SHAPER     (SHAPER),
        .DELAY_LOG2 (DELAY_LOG2),
        .BOTH       ((AXES != 0) ? 1 : 0)
    ) rom (
        .clk        (clk),
        .address_i  ({!of_board, bus_address_i[7:0]}),
        .kind_o     (kind),
        .off_o      (off),
        .signed_o   (has_sign),
        .greatest_i (state_q == MOST),
        .bound_o    (bound)
    );

    // One subtraction for both ends: the carry of bound - data shows bound >= data, that of bound - data - 1
    // bound > data.
    reg         enough_q;  // not below the least value
    wire [31:0] value      = {bus_data_i[31] ^ has_sign, bus_data_i[30:0]};
    wire [33:0] difference = {1'b0, bound, 1'b1} + {1'b0, ~value, state_q == JUDGE};
    wire        reaches    = difference[33];

    // ---- The verdict.
    wire setting = (kind == SETTING) && in_part;
    wire fixed   = (kind == LIVE) && off && in_part;
    wire command = (kind == COMMAND) && in_part;
    wire live    = (kind == LIVE) && !off && in_part;
    wire commit  = (bus_address_i == COMMIT);
    wire discard = (bus_address_i == DISCARD);
    wire known   = bus_write_i ? (setting || command) : (setting || fixed || live);
    wire not_now = (off && running_i) || ((setting || commit || discard) && pass_q)
                   || (commit && off_q && running_i);
    wire [1:0] verdict = !known                   ? 2'd1
                       : !bus_write_i             ? 2'd0
                       : !(enough_q && reaches)   ? 2'd2
                       : not_now                  ? 2'd3 : 2'd0;
    wire       accepts = (state_q == JUDGE) && bus_write_i && !bus_check_i && (verdict == 2'd0);

    // An accepted request acts in the next clock, with bus_ready_o; a command's strobe comes a clock later.
    reg        written_q;
    reg        written_off_q;
    reg        commits_q;
    reg        discards_q;
    reg        accepted_q;
    reg        command_q;
    reg [11:0] command_address_q;
    reg [31:0] command_data_q;
    reg [1:0]  error_q;

    always @(posedge clk) begin
        written_q         <= !rst && accepts && setting;
        written_off_q     <= off;
        commits_q         <= !rst && accepts && commit && bus_data_i[0];
        discards_q        <= !rst && accepts && discard && bus_data_i[0];
        accepted_q        <= !rst && accepts && command && !commit && !discard;
        command_q         <= !rst && accepted_q;
        command_address_q <= bus_address_i;
        command_data_q    <= bus_data_i;
        if (state_q == LOW) begin
            enough_q <= !reaches;
        end
        if (state_q == JUDGE) begin
            error_q <= verdict;
        end
    end

    assign clear_o           = command_q && command_address_q == CLEAR && command_data_q[0];
    assign host_alive_o      = command_q && command_address_q == HOST_ALIVE && command_data_q[0];
    assign zero_start_o      = command_q && command_address_q == ZERO_START && command_data_q[0];
    assign magnet_start_o    = AXES != 0 && command_q && command_address_q == MAGNETS && command_data_q[0];
    assign restart_o         = loading_q || (command_q && command_address_q == RESTART && command_data_q[0]);
    assign command_o         = command_q;
    assign command_address_o = command_address_q;
    assign command_data_o    = command_data_q;

    // ---- The memories. A port's part has its settings at their addresses; the first one also has those of all ports.
    reg  [2:0]  part_q;   // the part that the pass reads
    reg  [7:0]  slot_q;
    reg         read_q;   // they are valid: of the previous clock,
    reg  [10:0] read_place_q;
    reg         read_last_q;
    reg         write_q;  // and of the one before it
    reg  [10:0] place_q;
    reg         last_q;
    reg  [31:0] word_q;

    wire        bus_reads = (state_q == MOST);
    wire        reads     = copies_q && !bus_reads;
    wire        ends_part = (slot_q == LAST_SLOT);
    wire        last      = ends_part && part_q == LAST[2:0];
    wire        flips     = write_q && last_q;
    wire [3:0]  bus_part  = bus_address_i[11:8] - 4'd1;
    wire [10:0] bus_place = of_board ? {3'd0, BOARD + bus_address_i[7:0]} : {bus_part[2:0], bus_address_i[7:0]};
    wire [7:0]  betas     = BETAS[7:0];
    wire        of_alpha  = betas[part_q] && slot_q > 8'h01;  // common to both axes
    wire [10:0] from      = bus_reads ? bus_place : {part_q - {2'd0, of_alpha}, slot_q};
    wire [10:0] to        = write_q ? place_q : bus_place;
    wire [31:0] written;
    wire [31:0] in_force;
    reg  [31:0] default_q;
    reg  [31:0] read_data_q;
    wire        unused    = &{1'b0, bus_part[3], difference[32:0], from, to};

    wh_register_ram #(
        .PLACE_W       (PLACE_W)
    ) written_ram (
        .clk           (clk),
        .write_i       (written_q || (write_q && source_q != WRITTEN)),
        .write_place_i (to[PLACE_W-1:0]),
        .write_data_i  (write_q ? word_q : bus_data_i),
        .read_place_i  (from[PLACE_W-1:0]),
        .read_data_o   (written)
    );

    wh_register_ram #(
        .PLACE_W       (PLACE_W)
    ) in_force_ram (
        .clk           (clk),
        .write_i       (write_q && source_q != IN_FORCE),
        .write_place_i (to[PLACE_W-1:0]),
        .write_data_i  (word_q),
        .read_place_i  (from[PLACE_W-1:0]),
        .read_data_o   (in_force)
    );

    (* rom_style = "block" *) reg [31:0] defaults [0:255];

    integer i;

`define WH_SETTINGS_WORD(FIRST, COPIES, WHO, INFO, DEFAULT) \
        for (i = FIRST; i < FIRST + (COPIES); i = i + 1) begin \
            defaults[(FIRST < 256) ? i + 160 : i - 256] = DEFAULT; \
        end
`define WH_SETTINGS_TOLD(FIRST, COPIES, WHO, INFO)
`define WH_SETTINGS_BOUNDS(TYPE, LEAST, GREATEST)

    initial begin
        for (i = 0; i < 256; i = i + 1) begin
            defaults[i] = 32'd0;
        end
`ifdef WH_BOARD_ROM
`include "wh_board_settings_rom.vh"
`else
`include "wh_settings_rom.vh"
`endif
    end

`undef WH_SETTINGS_WORD
`undef WH_SETTINGS_TOLD
`undef WH_SETTINGS_BOUNDS

    always @(posedge clk) begin
        default_q    <= defaults[slot_q];
        read_place_q <= {part_q, slot_q};
        read_last_q  <= last;
        place_q      <= read_place_q;
        last_q       <= read_last_q;
        word_q       <= (source_q == DEFAULTS) ? default_q : (source_q == IN_FORCE) ? in_force : written;
        read_data_q  <= (pass_q && source_q == IN_FORCE) ? in_force : written;  // a discarded setting isn't read
    end

    // ---- To the stations, and to the settings of all ports.
    wire of_all = (place_q[7:0] >= BOARD);

    assign force_o      = force_q;
    assign write_o      = write_q;
    assign write_bank_o = !force_q;
    assign address_o    = of_all ? {4'd0, place_q[7:0] - BOARD} : {{1'b0, place_q[10:8]} + 4'd1, place_q[7:0]};
    assign data_o       = word_q;

    // The groups of their settings: first address, number, and bits of each, the first one lowest.
    localparam integer GROUPS  = 10;
    localparam integer ALL     = 52;
    localparam [23:0]  MAGNET_WIDTHS = (AXES != 0) ? {8'd1, 8'd32, 8'd32} : 24'd0;
    localparam [7:0]   DELAY_W = DELAY_LOG2[7:0];
    localparam [GROUPS*16-1:0] ADDRESSES = {8'h21, 8'd3, 8'h24, 8'd2, 8'h3e, 8'd1, 8'h40, 8'd16, 8'h30, 8'd6,
                                            8'h28, 8'd2, 8'h20, 8'd1, 8'h18, 8'd5, 8'h08, 8'd10, 8'h00, 8'd6};
    localparam [ALL*8-1:0] WIDTHS = {
        MAGNET_WIDTHS,
        8'd8, 8'd4,                                              // host
        8'd16,                                                   // guard_saturated
        8'd16, 8'd32, 8'd16, 8'd16, 8'd16, 8'd24, 8'd16, 8'd16,  // guard
        8'd16, 8'd16, 8'd16, 8'd16, 8'd16, 8'd2, 8'd24, 8'd24,
        8'd1, 8'd8, 8'd1, 8'd8, 8'd8, 8'd2,                      // bridge
        DELAY_W, DELAY_W,                                        // delay
        8'd4,                                                    // filter_clocks
        8'd23, 8'd16, 8'd16, 8'd0, 8'd16,                        // sense; 0x19 is none
        8'd1, 8'd1, 8'd6, 8'd8, 8'd8, 8'd8, 8'd5, 8'd6, 8'd6, 8'd8,  // frame
        8'd1, 8'd8, 8'd9, 8'd16, 8'd16, 8'd16                    // carrier
    };
    localparam integer MOST_W = 66 + 57 + 71 + 4 + 2 * DELAY_LOG2 + 28 + `WH_GUARD_W + 12;
    localparam integer ALL_W  = MOST_W + ((AXES != 0) ? 65 : 0);

    // Bits below setting `count`, and its address.
    function integer below;
        input integer count;
        integer k;
        begin
            below = 0;
            for (k = 0; k < count; k = k + 1) begin
                below = below + {24'd0, WIDTHS[k*8 +: 8]};
            end
        end
    endfunction

    function [7:0] address_of;
        input integer count;
        integer k;
        integer first;  // of the group
        begin
            address_of = 8'd0;
            first      = 0;
            for (k = 0; k < GROUPS; k = k + 1) begin
                if (count >= first) begin
                    address_of = ADDRESSES[k*16 + 8 +: 8] + count[7:0] - first[7:0];
                end
                first = first + {24'd0, ADDRESSES[k*16 +: 8]};
            end
        end
    endfunction

    wire [ALL_W-1:0] all;

    assign {host_o, guard_o, bridge_o, delay_o, filter_clocks_o, sense_o, frame_o, carrier_o} = all[MOST_W-1:0];

    genvar n;
    generate
        if (below(ALL) != ALL_W) begin : illegal_table
            wh_illegal_parameter_registers_widths_must_be_those_of_wh_ports stop ();
        end
        if (AXES != 0) begin : of_magnets
            assign magnets_o = all[ALL_W-1:MOST_W];
        end else begin : of_no_magnets
            assign magnets_o = 65'd0;
        end
        for (n = 0; n < ALL; n = n + 1) begin : shared
            localparam integer WIDTH = {24'd0, WIDTHS[n*8 +: 8]};

            if (WIDTH > 0) begin : setting
                wh_setting_group #(
                    .FIRST     (address_of(n)),
                    .WIDTHS    (WIDTHS[n*8 +: 8]),
                    .TOTAL_W   (WIDTH)
                ) group (
                    .clk       (clk),
                    .copy_i    (write_q),
                    .address_i (address_o),
                    .data_i    (word_q),
                    .change_i  (flips),
                    .words_o   (all[below(n) +: WIDTH])
                );
            end
        end
    endgenerate

    // ---- Live values. A port's flags are one of its values. A reset makes all 0.
    wire [7:0] address = bus_address_i[7:0];
    reg  [3:0] live_word;

    always @* begin
        casez (address)
            8'b1011_00??: live_word = {2'd0, address[1:0]};
            8'ha5:        live_word = `WH_LIVE_HOST_SEQUENCE;
            8'ha6:        live_word = `WH_LIVE_HOST_V;
            8'hb4:        live_word = `WH_LIVE_POSITION;
            8'hb8:        live_word = `WH_LIVE_ENERGY;
            8'hb9:        live_word = `WH_LIVE_ENERGY_PEAK;
            8'b1100_00??: live_word = {2'd2, address[1:0]};
            default:      live_word = `WH_LIVE_FLAGS;
        endcase
    end

    wire [6:0]  live_to   = ready_q ? {{(3 - PORT_W){1'b0}}, live_port_i, live_word_i} : slot_q[6:0];
    wire [6:0]  live_from = {bus_part[2:0], live_word};
    wire [31:0] live_data;
    reg  [31:0] live_q;
    reg  [7:0]  stepped_q;  // by port: there was a step since the bridges went on
    reg  [31:0] ticks_q;
    reg  [31:0] answer_q;
    reg  [31:0] answer;
    wire        unused_live = &{1'b0, live_to, live_from};

    // A packet to a host is its number and its v, in two consecutive clocks. It doesn't change while a host reads it.
    wire        of_v      = (live_word_i == `WH_LIVE_HOST_V);
    wire        of_packet = of_v || (live_word_i == `WH_LIVE_HOST_SEQUENCE);
    wire        reads_one = bus_valid_i && !bus_write_i && !of_board && (address[7:2] == 6'h29);
    reg  [5:0]  reading_q;  // clocks in which the next register of a frame may be read
    reg         skips_q;
    wire        skips     = of_v ? (reads_one || reading_q != 6'd0) : skips_q;

    always @(posedge clk) begin
        reading_q <= rst ? 6'd0 : reads_one ? 6'd63 : (reading_q == 6'd0) ? 6'd0 : reading_q - 6'd1;
        if (live_valid_i && of_v) begin
            skips_q <= skips;
        end
    end

    wh_register_ram #(
        .PLACE_W       (PART_W + 4)
    ) live_ram (
        .clk           (clk),
        .write_i       (!ready_q || (live_valid_i && !(of_packet && skips))),
        .write_place_i (live_to[PART_W+3:0]),
        .write_data_i  (ready_q ? live_data_i : 32'd0),
        .read_place_i  (live_from[PART_W+3:0]),
        .read_data_o   (live_data)
    );

    always @(posedge clk) begin
        ticks_q <= rst ? 32'd0 : ticks_q + {31'd0, tick_i};
        live_q  <= live_data;
        if (rst || !running_i) begin
            stepped_q <= 8'd0;
        end else if (live_valid_i && live_word_i == `WH_LIVE_CORRECTION) begin
            stepped_q <= stepped_q | (8'd1 << live_port_i);
        end
    end

    always @* begin
        answer = other_i;
        if (setting || fixed) begin
            answer = read_data_q;
        end else if (of_board) begin
            case (address)
                8'h62:   answer = {{32-`WH_FAULTS{1'b0}}, faults_i};
                8'h63:   answer = {31'd0, running_i};
                8'h64:   answer = ticks_q;
                8'h68:   answer = {31'd0, adc_ready_i};
                8'h6b:   answer = {31'd0, faults_i[`WH_FAULT_OVERRUN]};
                8'h72:   answer = {31'd0, pass_q};
                8'h73:   answer = {31'd0, staged_q};
                default: answer = other_i;
            endcase
        end else begin
            casez (address)
                8'b1011_000?, 8'hb2, 8'b1100_00??: answer = stepped_q[bus_part[2:0]] ? live_q : 32'd0;
                8'ha5, 8'ha6:                      answer = live_q;
                8'ha7:                             answer = {31'd0, live_q[7]};  // host_active
                8'hb3, 8'hb4, 8'hb8, 8'hb9:        answer = live_q;
                8'hb5:   answer = {31'd0, live_q[0]};  // contact
                8'hb6:   answer = {31'd0, live_q[1]};  // saturated
                8'hb7:   answer = {31'd0, live_q[`WH_FLAG_CLIPPED]};
                8'hc4:   answer = {31'd0, live_q[6]};  // anchor_fault
                8'hd0:   answer = {31'd0, live_q[4]};  // adc_range
                8'hd1:   answer = {31'd0, live_q[`WH_FLAG_STUCK]};
                8'hd4:   answer = {31'd0, live_q[3]};  // overcurrent
                8'hd5:   answer = {31'd0, live_q[5]};  // encoder_fault
                8'hd6:   answer = {24'd0, live_q[7:0]};  // flags
                default: answer = other_i;
            endcase
        end
    end

    always @(posedge clk) begin
        if (state_q == JUDGE) begin
            answer_q <= (setting || fixed || live) ? answer : 32'd0;
        end
    end

    assign bus_ready_o  = (state_q == DONE);
    assign bus_data_o   = answer_q;
    assign bus_error_o  = error_q;
    assign bus_signed_o = has_sign;

    // ---- Requests and passes.
    assign ready_o   = ready_q;
    assign loading_o = loading_q;
    assign busy_o    = pass_q;

    wire begins  = commits_q || discards_q;
    wire settled = pass_q && settle_q == 9'd1;

    always @(posedge clk) begin
        if (rst) begin
            state_q   <= IDLE;
            ready_q   <= 1'b0;
            pass_q    <= 1'b1;
            copies_q  <= 1'b1;
            source_q  <= DEFAULTS;
            settle_q  <= 9'd0;
            force_q   <= 1'b0;
            loading_q <= 1'b1;
            staged_q  <= 1'b0;
            off_q     <= 1'b0;
            part_q    <= 3'd0;
            slot_q    <= BOARD;
            read_q    <= 1'b0;
            write_q   <= 1'b0;
        end else begin
            case (state_q)
                IDLE:    state_q <= (bus_valid_i && ready_q) ? LEAST : IDLE;
                LEAST:   state_q <= MOST;
                MOST:    state_q <= LOW;
                LOW:     state_q <= JUDGE;
                JUDGE:   state_q <= DONE;
                default: state_q <= IDLE;
            endcase

            if (begins) begin
                pass_q   <= 1'b1;
                copies_q <= 1'b1;
                source_q <= commits_q ? WRITTEN : IN_FORCE;
                part_q   <= 3'd0;
                slot_q   <= BOARD;
            end else if (reads) begin
                copies_q <= !last;
                part_q   <= part_q + {2'd0, ends_part};
                slot_q   <= ends_part ? 8'd0 : slot_q + 8'd1;
            end
            read_q  <= reads;
            write_q <= read_q;

            if (flips) begin
                force_q  <= !force_q;
                settle_q <= SETTLE;
            end else if (settle_q != 9'd0) begin
                settle_q <= settle_q - 9'd1;
            end
            if (settled) begin
                pass_q    <= 1'b0;
                ready_q   <= 1'b1;
                loading_q <= 1'b0;
            end else if (commits_q && off_q) begin
                loading_q <= 1'b1;
            end

            staged_q <= (staged_q || written_q) && !begins;
            off_q    <= (off_q || (written_q && written_off_q)) && !begins;
        end
    end

endmodule

`default_nettype wire
