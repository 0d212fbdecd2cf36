// SPDX-License-Identifier: Apache-2.0
//
// wh_arm: lets the bridges on by a command that has to be renewed, or by a button.
//
//   write 1   arm for CREDIT clocks; if armed, renew
//   write 2   if armed, renew; else nothing
//   write 0   disarm
//   press     arm without an end to the credit; if armed, the present credit no longer ends
//
// It stays armed until 0 is written, or until a reason against it appears. refused_o then holds the reason, a bit each,
// until it is armed again:
//
//   0 enable_i is low   1 a fault   2 settings are being applied   3 no accepted zero   4 the credit ran out
//
// During one of the first three, a 1 or a press is refused with that reason. After a reason has gone, only a new 1 or
// press arms; a 2 doesn't. If a press and a 0 come in one clock, the 0 counts.
// With SENSE = 1 the zero of the currents is measured first, as wh_zero does with the bridges off, and it is armed if
// that ends with an accepted zero. The credit runs meanwhile. An earlier failed zero, zero_i, doesn't prevent this: the
// new measurement clears it.
//
// Latency: armed_o and refused_o change one clock after their cause.
// Reset: not armed, no reason.

`default_nettype none

module wh_arm #(
    parameter integer SENSE  = 0,        // 1: with a measured zero
    parameter integer CREDIT = 4800000   // clocks, 2...2^30
) (
    input  wire       clk,
    input  wire       rst,

    input  wire       enable_i,      // the board lets it
    input  wire       fault_i,       // the guard's, or a tick's
    input  wire       zero_i,        // a fault as well: the guard's of the zero
    input  wire       loading_i,     // settings are being committed

    input  wire       write_i,       // strobe
    input  wire [1:0] value_i,       // with write_i
    input  wire       press_i,       // strobe: whoever stands beside it wants it on

    output wire       zero_start_o,  // strobe
    input  wire       zero_busy_i,   // from the clock after the strobe on
    input  wire       zero_fault_i,  // with the end of zero_busy_i

    output wire       armed_o,
    output wire [4:0] refused_o
);

    localparam integer    CREDIT_W = $clog2(CREDIT);
    localparam [31:0]     LAST_32  = CREDIT - 1;
    localparam [CREDIT_W-1:0] LAST = LAST_32[CREDIT_W-1:0];

    generate
        if (SENSE != 0 && SENSE != 1) begin : illegal_sense
            wh_illegal_parameter_arm_sense_must_be_0_or_1 stop ();
        end
        if (CREDIT < 2 || CREDIT > (1 << 30)) begin : illegal
            wh_illegal_parameter_arm_credit_must_be_2_to_2_30 stop ();
        end
    endgenerate

    reg                armed_q;
    reg                measuring_q;  // the zero, before the bridges go on
    reg                start_q;
    reg [4:0]          refused_q;
    reg                stays_q;      // credit has no end
    reg [CREDIT_W-1:0] credit_q;     // clocks left, but for this one

    wire drops    = write_i && (value_i == 2'd0);
    wire pressed  = press_i && !drops;
    wire arms     = pressed || (write_i && (value_i == 2'd1));
    wire renews   = arms || (write_i && (value_i == 2'd2));
    wire active   = armed_q || measuring_q;
    wire measured = measuring_q && !start_q && !zero_busy_i;
    wire spent    = (credit_q == {CREDIT_W{1'b0}}) && !renews && !stays_q;

    wire       counts  = (SENSE == 0) || armed_q || measured;  // zero_i does
    wire [2:0] against = {loading_i, fault_i || (zero_i && counts), !enable_i};
    wire [4:0] ends    = {spent, measured && zero_fault_i, against};

    always @(posedge clk) begin
        if (rst) begin
            armed_q     <= 1'b0;
            measuring_q <= 1'b0;
            start_q     <= 1'b0;
            refused_q   <= 5'd0;
            stays_q     <= 1'b0;
            credit_q    <= {CREDIT_W{1'b0}};
        end else begin
            start_q  <= 1'b0;
            stays_q  <= pressed || (active && stays_q);
            credit_q <= renews ? LAST : credit_q - 1'b1;
            if (active) begin
                if (drops || (|ends)) begin
                    armed_q     <= 1'b0;
                    measuring_q <= 1'b0;
                    refused_q   <= drops ? 5'd0 : ends;
                end else if (measured) begin
                    armed_q     <= 1'b1;
                    measuring_q <= 1'b0;
                end
            end else if (arms) begin
                refused_q <= {2'd0, against};
                if (against == 3'd0) begin
                    armed_q     <= (SENSE == 0);
                    measuring_q <= (SENSE != 0);
                    start_q     <= (SENSE != 0);
                end
            end
        end
    end

    assign zero_start_o = start_q;
    assign armed_o      = armed_q;
    assign refused_o    = refused_q;

endmodule

`default_nettype wire
