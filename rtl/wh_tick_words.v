// SPDX-License-Identifier: Apache-2.0
//
// wh_tick_words: the live words of a tick, kept for two readers, who choose some of them one after another.
//
// A tick's words are those of its step, as it ends; without one, as with the bridges off, those of the clock
// behind its last one: strobe_o. They are kept unless the words of the tick before are still read. A reader
// that wants them (want_i) is given them by take_o: reader 0 with the strobe, reader 1 with it as well, or,
// where 0 has been, once that has chosen. It then has reads_i high for the clocks in which it chooses, from
// the next one on.
//
// code_i: the address of rtl/words.toml that a reader chooses, 0 lowest; word_o is the word there of who reads,
// in the next clock, sign-extended, and one that is none of those below is 0. mean_o: of several ticks the mean is
// meant, as of numbers with a sign and of the bus; any_o: bits, of which those count that were there in any tick;
// neither: the last one, as of the position.
//
// Latency: as above. Reset: nobody is given anything.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_tick_words #(
    parameter integer N = 1  // motors, 1...8
) (
    input  wire                         clk,
    input  wire                         rst,

    // What it keeps.
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

    // The readers, 0 lowest.
    input  wire [1:0]                   want_i,
    input  wire [1:0]                   reads_i,          // not both
    input  wire [23:0]                  code_i,
    output wire                         strobe_o,         // strobe, once a tick
    output wire [1:0]                   take_o,           // strobes
    output wire [31:0]                  word_o,
    output wire                         mean_o,
    output wire                         any_o
);

    localparam integer DATA_W  = `WH_DATA_W;
    localparam integer COUNT_W = `WH_COUNT_W;

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

    // ---- One strobe a tick: its step's, or without one its end, which comes late in its clock.

    reg  stepped_q;  // this tick had a step
    reg  missed_q;   // the one before had none
    wire strobe = valid_i || missed_q;

    always @(posedge clk) begin
        stepped_q <= !rst && !tick_i && (stepped_q || valid_i);
        missed_q  <= !rst && tick_i && !stepped_q && !valid_i;
    end

    // ---- Whose turn it is.

    reg  second_q;  // reader 1 waits for reader 0
    wire begins = strobe && !second_q && (reads_i == 2'b00);

    assign strobe_o  = strobe;
    assign take_o[0] = begins && want_i[0];
    assign take_o[1] = (begins && want_i == 2'b10) || (second_q && !reads_i[0] && want_i[1]);

    always @(posedge clk) begin
        second_q <= !rst && ((begins && want_i == 2'b11) || (second_q && reads_i[0]));
    end

    // ---- What the words are then.

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
        if (begins && want_i != 2'b00) begin
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

    // ---- The word that is chosen.

    reg  [11:0] code_q;
    reg  [32:0] word;
    reg         mean;
    reg         any;
    integer     m;

    assign word_o = word[31:0];

    always @(posedge clk) begin
        code_q <= (take_o[1] || reads_i[1]) ? code_i[23:12] : code_i[11:0];
    end
    assign mean_o = mean;
    assign any_o  = any;

    always @* begin
        word = 33'd0;
        mean = 1'b0;
        any  = 1'b0;
        if (code_q == BUS) begin
            word = {{33-`WH_BUS_W{1'b0}}, bus_q};
            mean = 1'b1;
        end
        if (code_q == FAULTS) begin
            word = {{33-`WH_FAULTS{1'b0}}, faults_q};
            any  = 1'b1;
        end
        for (m = 0; m < N; m = m + 1) begin
            if ({28'd0, code_q[11:8]} == m + 1) begin
                case (code_q[7:0])
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
                any  = (code_q[7:0] == FLAGS);
                mean = (code_q[7:0] != POSITION) && !any;
            end
        end
    end

    wire unused_word = &{1'b0, word[32]};

endmodule

`default_nettype wire
