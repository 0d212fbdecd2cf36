// SPDX-License-Identifier: Apache-2.0
//
// wh_board_controller: wh_controller with a board's constants, and the switch that lets it run.
//
// The constants are those of wh_board_settings.vh, made from the board's scene: WH_BOARD_PORTS has
// every word of rtl/words.toml, WH_BOARD_WIRES a wire for each that the controller tells.
//
// When start_i rises while stop_i is low, the zero of the currents is measured over 2^ZERO_LOG2 ticks,
// and then the gates go on. They go off when stop_i is high, at a fault of the encoder, when waves and
// encoder don't agree, when a tick is too short for its work, when a sample of the current reaches
// trip, which lies below what clips, at what the guard finds where the board has one, when
// the clock was lost, and in reset. They stay off until start_i rises again; after a fault, until
// reset. A zero beyond zero_limit is a fault. start_i and stop_i are asynchronous, and believed once
// they have been still for 2^SETTLE_LOG2 clocks; off needs no patience. What encoder, current and guard
// say before that time is over, as long as an ADC wakes up, and before a first zero, is forgotten.
//
// Without a clock the gates stay as they are. clock_lost_i is what wh_board_clock_watch found, which
// takes them off the pads; 0 where the board has none. alive_o changes at each tick while the gates
// are on, and is low otherwise; it stands still without a clock, and a charge pump behind it lets
// go of the bridge.
// Reset: gates off, not running, alive_o low.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"
`include "wh_board_settings.vh"

module wh_board_controller #(
    parameter integer SETTLE_LOG2 = 16, // start_i must be still for 2^SETTLE_LOG2 clocks
    parameter integer ZERO_LOG2   = 10  // ticks of a zero, 2^ZERO_LOG2; 2...16
) (
    input  wire                  clk,
    input  wire                  rst,

    input  wire                  start_i,      // asynchronous
    input  wire                  stop_i,       // asynchronous
    input  wire                  clock_lost_i, // asynchronous

    output wire                  adc_cs_n_o,
    output wire                  adc_sclk_o,
    input  wire [`WH_BOARD_N-1:0] adc_sdata_i,
    input  wire [`WH_BOARD_N-1:0] enc_a_i,     // asynchronous
    input  wire [`WH_BOARD_N-1:0] enc_b_i,     // asynchronous
    output wire [`WH_BOARD_N-1:0] gate_ah_o,
    output wire [`WH_BOARD_N-1:0] gate_al_o,
    output wire [`WH_BOARD_N-1:0] gate_bh_o,
    output wire [`WH_BOARD_N-1:0] gate_bl_o,

    output wire                  alive_o,
    output wire                  running_o,
    output wire                  contact_o,    // any motor is in a wall
    output wire                  fault_o       // until reset
);

    localparam integer N = `WH_BOARD_N;

    // ---- The switch.

    wire start;
    wire stop;
    wire clock_lost;

    wh_synchroniser #(
        .WIDTH   (3)
    ) synchroniser (
        .clk     (clk),
        .level_i ({start_i, stop_i, clock_lost_i}),
        .level_o ({start, stop, clock_lost})
    );

    // Pressed is a level that has lasted: it may be the press that goes on through reset, which is
    // no rise.
    reg [SETTLE_LOG2-1:0] settle_q;
    reg                   pressed_q;
    reg                   running_q;
    reg                   fault_q;

    wire settled = (settle_q == {SETTLE_LOG2{1'b1}});

    `WH_BOARD_WIRES

    // The first zero comes unasked, so that what is judged with the gates off has one.
    reg        starting_q;     // the gates are to go on after this zero
    reg        measuring_q;
    reg        zero_start_q;
    reg        zeroed_q;       // there is a zero
    reg  [2:0] zero_ticks_q;   // ticks since then: currents of before have passed
    wire       awake    = zero_ticks_q[2];
    wire       forgets  = !awake;
    wire       pressed  = settled && start && !pressed_q;
    wire       measures = settled && !running_q && (start || !zeroed_q);
    wire       measured = measuring_q && !zero_start_q && !(|zero_busy);

    always @(posedge clk) begin
        if (rst) begin
            settle_q     <= {SETTLE_LOG2{1'b0}};
            pressed_q    <= 1'b1;
            running_q    <= 1'b0;
            fault_q      <= 1'b0;
            starting_q   <= 1'b0;
            measuring_q  <= 1'b0;
            zero_start_q <= 1'b0;
            zeroed_q     <= 1'b0;
            zero_ticks_q <= 3'b000;
        end else begin
            fault_q <= fault_q || overrun || clock_lost || (|zero_fault) || (|anchor_fault)
                       || (((|encoder_fault) || (|overcurrent) || (|faults)) && !forgets);
            if (start == pressed_q) begin
                settle_q <= {SETTLE_LOG2{1'b0}};
            end else begin
                settle_q <= settle_q + 1'b1;
                if (settled) begin
                    pressed_q <= start;
                end
            end
            zero_start_q <= measures;
            measuring_q  <= measures || (measuring_q && !measured);
            zeroed_q     <= zeroed_q || measured;
            if (tick) begin
                zero_ticks_q <= {zero_ticks_q[1:0], zeroed_q};
            end
            if (stop || fault_q) begin
                starting_q <= 1'b0;
                running_q  <= 1'b0;
            end else if (pressed) begin
                starting_q <= !running_q;
            end else if (starting_q && measured && !(|zero_fault)) begin
                starting_q <= 1'b0;
                running_q  <= 1'b1;
            end
        end
    end

    assign running_o = running_q;
    assign fault_o   = fault_q;

    reg alive_q;

    always @(posedge clk) begin
        alive_q <= !rst && running_q && (alive_q ^ tick);
    end

    assign alive_o = alive_q;

    // ---- The controller.

    wire adc_din;  // of an ADC that no board has
    wire unused = &{1'b0, adc_din};

    assign contact_o = |contact;

    wh_controller #(
        .N                  (N),
        .WALLS              (`WH_BOARD_WALLS),
        .DELAY_LOG2         (`WH_BOARD_DELAY_LOG2),
        .MODES              (`WH_BOARD_MODES),
        .MIN_PULSE          (`WH_BOARD_SHORTEST),
        .EARLY              (`WH_BOARD_EARLY),
        .SHAPER             (`WH_BOARD_SHAPER),
        .ANCHOR             (`WH_BOARD_ANCHOR),
        .SENSE              (1),
        .ZERO_LOG2          (ZERO_LOG2),
        .GUARD              (`WH_BOARD_GUARDED)
    ) controller (
        .clk                (clk),
        .rst                (rst),
        .enable_i           (running_q),
        .adc_cs_n_o         (adc_cs_n_o),
        .adc_sclk_o         (adc_sclk_o),
        .adc_din_o          (adc_din),
        .adc_sdata_i        (adc_sdata_i),
        .enc_a_i            (enc_a_i),
        .enc_b_i            (enc_b_i),
        .gate_ah_o          (gate_ah_o),
        .gate_al_o          (gate_al_o),
        .gate_bh_o          (gate_bh_o),
        .gate_bl_o          (gate_bl_o),
        .clear_i            (forgets),
        .zero_start_i       (zero_start_q),
        `WH_BOARD_PORTS
        .stop_i             (1'b0),
        .driver_fault_i     ({N{1'b0}}),
        .anchor_fault_i     ({N{1'b0}})
    );

endmodule

`default_nettype wire
