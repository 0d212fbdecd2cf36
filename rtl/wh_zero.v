// SPDX-License-Identifier: Apache-2.0
//
// wh_zero: measures the sum of a tick's samples that stands for 0 A, with the bridge off.
//
//   zero = round(sum of all samples of 2^LOG2_TICKS ticks / 2^LOG2_TICKS)
//
// start_i begins with the next tick's first sample, and clears the previous fault. If bridge_off_i falls before the
// last sample, nothing is measured, and fault_o rises. It also rises if |zero| is above limit_i: the sensor has
// drifted, or the bridge isn't off. zero_o is the last accepted zero; measured_o is 1 once there is one.
//
// Formats: samples s16, zero s24 as wh_current takes it, rounded to the nearest, halves away from zero. Latency: done_o
// comes 3 clocks after the first sample of the tick that follows.
// Reset: no zero, no fault.

`default_nettype none
`include "wh_formats.vh"

module wh_zero #(
    parameter integer LOG2_TICKS = 10  // 2...16
) (
    input  wire                           clk,
    input  wire                           rst,

    input  wire                           valid_i,       // strobe
    input  wire                           first_i,       // with valid_i: first of a tick
    input  wire signed [`WH_SAMPLE_W-1:0] sample_i,      // s16

    input  wire                           start_i,       // strobe
    input  wire                           bridge_off_i,
    input  wire [`WH_SUM_W-2:0]           limit_i,       // largest permitted |zero|

    output reg                            busy_o,
    output reg                            done_o,        // strobe: zero_o or fault_o is new
    output reg                            measured_o,
    output reg  signed [`WH_SUM_W-1:0]    zero_o,        // s24
    output reg                            fault_o        // until the next start
);

    localparam integer TOTAL_W = `WH_SUM_W + LOG2_TICKS;
    localparam [LOG2_TICKS-1:0] LAST = {LOG2_TICKS{1'b1}};

    generate
        if (LOG2_TICKS < 2 || LOG2_TICKS > 16) begin : illegal
            wh_illegal_parameter_zero_log2_ticks_must_be_2_to_16 stop ();
        end
    endgenerate

    reg                           running_q;  // a tick of the measurement has begun
    reg        [1:0]              closing_q;  // the last word has come: rounding, limit
    reg signed [TOTAL_W-1:0]      total_q;
    reg        [LOG2_TICKS-1:0]   ticks_q;    // whole ticks in total_q

    wire signed [TOTAL_W-1:0] sample = {{TOTAL_W-`WH_SAMPLE_W{sample_i[`WH_SAMPLE_W-1]}}, sample_i};
    wire                      begins = valid_i && first_i && !running_q;
    wire                      ends   = valid_i && first_i && running_q && (ticks_q == LAST);

    // One adder. A half, or for a negative total a last place less, and what floor leaves of that is
    // the nearest word, halves away from zero.
    wire signed [TOTAL_W-1:0] half = {{TOTAL_W-LOG2_TICKS+1{1'b0}}, {LOG2_TICKS-1{1'b1}}};
    wire                      up   = closing_q[0] && !total_q[TOTAL_W-1];
    wire signed [TOTAL_W-1:0] sum  = (begins ? {TOTAL_W{1'b0}} : total_q)
                                   + (closing_q[0] ? half : sample)
                                   + $signed({{TOTAL_W-1{1'b0}}, up});

    wire signed [`WH_SUM_W-1:0] mean  = total_q[TOTAL_W-1:LOG2_TICKS];
    wire signed [`WH_SUM_W-1:0] limit = {1'b0, limit_i};
    wire                        good  = (mean <= limit) && (mean >= -limit);

    always @(posedge clk) begin
        done_o    <= 1'b0;
        closing_q <= {closing_q[0], 1'b0};
        if (rst) begin
            busy_o     <= 1'b0;
            running_q  <= 1'b0;
            measured_o <= 1'b0;
            zero_o     <= {`WH_SUM_W{1'b0}};
            fault_o    <= 1'b0;
            total_q    <= {TOTAL_W{1'b0}};
            ticks_q    <= {LOG2_TICKS{1'b0}};
            closing_q  <= 2'b00;
        end else if (start_i) begin
            busy_o     <= 1'b1;
            running_q  <= 1'b0;
            closing_q  <= 2'b00;
            fault_o    <= 1'b0;
        end else if (busy_o && !bridge_off_i) begin
            busy_o     <= 1'b0;
            closing_q  <= 2'b00;
            done_o     <= 1'b1;
            fault_o    <= 1'b1;
        end else if (closing_q[1]) begin
            busy_o     <= 1'b0;
            done_o     <= 1'b1;
            fault_o    <= !good;
            if (good) begin
                zero_o     <= mean;
                measured_o <= 1'b1;
            end
        end else if (closing_q[0]) begin
            total_q <= sum;
        end else if (busy_o && valid_i) begin
            if (ends) begin
                closing_q[0] <= 1'b1;
            end else if (begins || running_q) begin
                running_q <= 1'b1;
                total_q   <= sum;
                ticks_q   <= begins ? {LOG2_TICKS{1'b0}}
                                    : ticks_q + {{LOG2_TICKS-1{1'b0}}, first_i};
            end
        end
    end

endmodule

`default_nettype wire
