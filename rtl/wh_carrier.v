// SPDX-License-Identifier: Apache-2.0
//
// wh_carrier: carrier halves, ticks and sampling instants for all blocks.
//
//   half  = half_clocks_i clocks,  phase 0 ... half_clocks_i - 1
//   tick  = tick_halves_i halves, samples_i * sample_clocks_i clocks or longer
//   sample n of a tick: sample_clocks_i / 2 - sample_lead_i + n * sample_clocks_i after its start
//
// half_o is the half's parity, which selects the zero vector of wh_pwm; it continues from tick to tick. The lead is
// negative if the samples have to wait, for instance for the gates' registers, dead time or the bridge. With
// sample_late_i the samples of every odd tick come a clock later: half a clock on average. Settings may change only in
// reset.
// Outputs are decoded from registers. Latency: phase 0 of a tick is the first clock after reset.
// Reset: the state before that clock; no strobes.

`default_nettype none
`include "wh_formats.vh"

module wh_carrier (
    input  wire                        clk,
    input  wire                        rst,

    input  wire        [`WH_TICK_W-1:0] half_clocks_i,    // clocks in a carrier half, 6...
    input  wire        [`WH_TICK_W-1:0] tick_halves_i,    // halves in a tick, 1...
    input  wire        [`WH_TICK_W-1:0] sample_clocks_i,  // clocks from sample to sample, 2...
    input  wire        [8:0]            samples_i,        // samples in a tick, 1...256
    input  wire signed [7:0]            sample_lead_i,    // clocks that samples come early; first
                                                          // sample in 0...sample_clocks_i - 1
    input  wire                        sample_late_i,     // a clock later in odd ticks

    output wire        [`WH_TICK_W-1:0] phase_o,          // clocks since the half's start
    output wire        [`WH_TICK_W-1:0] remaining_o,      // half_clocks_i - 1 - phase_o
    output wire                         half_o,           // parity of the half
    output wire                         update_o,         // strobe, last clock of a half
    output wire                         take_o,           // strobe, 4 clocks before tick_o
    output wire                         last_half_o,      // of a tick
    output wire                         tick_o,           // strobe, last clock of a tick

    output wire                         sample_o,         // strobe, start of a conversion
    output wire                         sample_first_o    // with sample_o: first of a tick
);

    localparam [`WH_TICK_W-1:0] ONE = {{`WH_TICK_W-1{1'b0}}, 1'b1};
    localparam [`WH_TICK_W-1:0] FIVE = {{`WH_TICK_W-3{1'b0}}, 3'd5};

    reg                  running_q;
    reg [`WH_TICK_W-1:0] phase_q;
    reg [`WH_TICK_W-1:0] remaining_q;
    reg                  ends_q;         // remaining_q is 0: a comparison is asked a clock ahead
    reg                  half_q;
    reg [`WH_TICK_W-1:0] halves_left_q;  // after this one

    reg                  take_q;

    wire last_half = (halves_left_q == {`WH_TICK_W{1'b0}});

    assign phase_o     = phase_q;
    assign remaining_o = remaining_q;
    assign half_o      = half_q;
    assign update_o    = running_q && ends_q;
    assign take_o      = take_q;
    assign last_half_o = last_half;
    assign tick_o      = update_o && last_half;

    always @(posedge clk) begin
        running_q <= !rst;
        take_q    <= !rst && running_q && last_half && (remaining_q == FIVE);
        // A reset of one clock has to leave nothing of its half either: in the clock after it
        // nothing runs, but phase and half are looked at.
        if (rst || !running_q || update_o) begin
            phase_q     <= {`WH_TICK_W{1'b0}};
            remaining_q <= half_clocks_i - ONE;
            ends_q      <= (half_clocks_i == ONE);
        end else begin
            phase_q     <= phase_q + ONE;
            remaining_q <= remaining_q - ONE;
            ends_q      <= (remaining_q == ONE);
        end
        if (rst || !running_q) begin
            half_q        <= 1'b0;
            halves_left_q <= tick_halves_i - ONE;
        end else if (update_o) begin
            half_q        <= !half_q;
            halves_left_q <= last_half ? tick_halves_i - ONE : halves_left_q - ONE;
        end
    end

    reg [`WH_TICK_W-1:0] wait_q;    // clocks to the next sample
    reg [8:0]            left_q;    // samples of this tick still to come
    reg                  due_q;     // wait_q is 0, and left_q is not
    reg                  first_q;

    reg                   odd_q;     // this tick's parity

    wire [`WH_TICK_W-1:0] first_wait = (sample_clocks_i >> 1)
                                       - {{`WH_TICK_W-8{sample_lead_i[7]}}, sample_lead_i}
                                       + {{`WH_TICK_W-1{1'b0}}, sample_late_i && running_q && !odd_q};

    assign sample_o       = running_q && due_q;
    assign sample_first_o = first_q;

    always @(posedge clk) begin
        if (!running_q) begin
            odd_q <= 1'b0;
        end else if (tick_o) begin
            odd_q <= !odd_q;
        end
    end

    always @(posedge clk) begin
        if (!running_q || tick_o) begin
            wait_q  <= first_wait;
            left_q  <= samples_i;
            due_q   <= (first_wait == {`WH_TICK_W{1'b0}}) && (samples_i != 9'd0);
            first_q <= 1'b1;
        end else if (sample_o) begin
            wait_q  <= sample_clocks_i - ONE;
            left_q  <= left_q - 9'd1;
            due_q   <= (sample_clocks_i == ONE) && (left_q != 9'd1);
            first_q <= 1'b0;
        end else begin
            wait_q  <= wait_q - ONE;
            due_q   <= (wait_q == ONE) && (left_q != 9'd0);
        end
    end

endmodule

`default_nettype wire
