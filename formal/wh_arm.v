// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_arm: of a wh_arm without a zero and one with it, whatever comes in: armed_o lasts CREDIT clocks
// at most after the last write of 1 or 2 unless it was pressed for since it began, and no longer than to the
// clock after enable_i was low, a fault was there, settings were given or 0 was written; it comes by a write of 1
// or a press only, in a clock without these, and with a zero only after one that was asked for since and found good,
// with no renewal too late. What ends it but a 0, or refuses a 1 or a press, stands in refused_o. A fault of the
// zero is one as any other without a zero; with one it doesn't keep a new one from being measured, and counts
// as that ends and from then on. Proven by induction, smtbmc z3.

`default_nettype none

module prove_wh_arm (
    input wire       clk,
    input wire       rst,
    input wire       enable,
    input wire       fault,
    input wire       old_zero,
    input wire       loading,
    input wire       write,
    input wire [1:0] value,
    input wire       press,
    input wire       zero_busy,
    input wire       zero_fault
);

    localparam [2:0] CREDIT = 3'd6;

    wire [1:0] armed;
    wire [1:0] start;
    wire [4:0] refused   [0:1];
    wire [1:0] measuring;
    wire [1:0] stays;
    wire [2:0] left      [0:1];

    (* hierconn *) wire       \plain.measuring_q ;
    (* hierconn *) wire       \sensed.measuring_q ;
    (* hierconn *) wire       \plain.start_q ;
    (* hierconn *) wire       \sensed.start_q ;
    (* hierconn *) wire       \plain.stays_q ;
    (* hierconn *) wire       \sensed.stays_q ;
    (* hierconn *) wire [2:0] \plain.credit_q ;
    (* hierconn *) wire [2:0] \sensed.credit_q ;

    wh_arm #(
        .SENSE        (0),
        .CREDIT       (6)
    ) plain (
        .clk          (clk),
        .rst          (rst),
        .enable_i     (enable),
        .fault_i      (fault),
        .zero_i       (old_zero),
        .loading_i    (loading),
        .write_i      (write),
        .value_i      (value),
        .press_i      (press),
        .zero_start_o (start[0]),
        .zero_busy_i  (zero_busy),
        .zero_fault_i (zero_fault),
        .armed_o      (armed[0]),
        .refused_o    (refused[0])
    );

    wh_arm #(
        .SENSE        (1),
        .CREDIT       (6)
    ) sensed (
        .clk          (clk),
        .rst          (rst),
        .enable_i     (enable),
        .fault_i      (fault),
        .zero_i       (old_zero),
        .loading_i    (loading),
        .write_i      (write),
        .value_i      (value),
        .press_i      (press),
        .zero_start_o (start[1]),
        .zero_busy_i  (zero_busy),
        .zero_fault_i (zero_fault),
        .armed_o      (armed[1]),
        .refused_o    (refused[1])
    );

    assign measuring = {\sensed.measuring_q , \plain.measuring_q };
    assign stays     = {\sensed.stays_q , \plain.stays_q };
    assign left[0]   = \plain.credit_q ;
    assign left[1]   = \sensed.credit_q ;

    // What a listener knows, by the last clock.
    reg       begun = 1'b0;
    reg       rst_q;
    reg       wrote_0_q;
    reg       wrote_1_q;    // or pressed
    reg [2:0] against_q [0:1];
    reg       zero_good_q;  // no zero is being measured, and the last one was good
    reg       zero_bad_q;
    reg [1:0] armed_q;
    reg [1:0] measuring_q;
    reg       start_q;
    reg [2:0] since_q;      // clocks since the last write of 1 or 2 or press, no more than CREDIT
    reg [1:0] wanted;       // pressed since it became active
    reg [1:0] wanted_q;
    reg [4:0] refused_q [0:1];

    wire drop  = write && value == 2'd0;
    wire push  = press && !drop;
    wire renew = push || (write && (value == 2'd1 || value == 2'd2));
    wire counts = armed[1] || (measuring[1] && !start[1] && !zero_busy);  // the zero's fault does

    integer k;

    always @(posedge clk) begin
        begun       <= 1'b1;
        rst_q       <= rst;
        wrote_0_q   <= drop;
        wrote_1_q   <= push || (write && value == 2'd1);
        against_q[0] <= {loading, fault || old_zero, !enable};
        against_q[1] <= {loading, fault || (old_zero && counts), !enable};
        zero_good_q <= !zero_busy && !zero_fault && !start[1];
        zero_bad_q  <= !zero_busy && zero_fault && !start[1];
        armed_q     <= armed;
        measuring_q <= measuring;
        start_q     <= start[1];
        since_q     <= renew ? 3'd0 : (since_q == CREDIT) ? since_q : since_q + 3'd1;
        wanted      <= rst ? 2'b00 : push ? 2'b11 : (wanted & (armed | measuring));
        wanted_q    <= wanted;
        refused_q[0] <= refused[0];
        refused_q[1] <= refused[1];

        if (!begun) begin
            assume (rst);
            assume (since_q == CREDIT);
        end else begin
            for (k = 0; k < 2; k = k + 1) begin
                // The invariant: what is left is told by the last write, or doesn't matter.
                if (armed[k] || measuring[k]) begin
                    assert (stays[k] == wanted[k]);
                    assert (wanted[k] || (since_q < CREDIT && left[k] == CREDIT - 3'd1 - since_q));
                    assert (!rst_q && !wrote_0_q && against_q[k] == 3'd0 && refused[k] == 5'd0);
                end
                assert (!(armed[k] && measuring[k]));
                if (rst_q) begin
                    assert (!armed[k] && !measuring[k] && refused[k] == 5'd0);
                end
                // Why it ended, or why it didn't begin.
                if (!rst_q && (armed_q[k] || measuring_q[k]) && !(armed[k] || measuring[k])) begin
                    assert (wrote_0_q ? refused[k] == 5'd0
                            : refused[k][2:0] == against_q[k]
                              && refused[k][4] == (since_q == CREDIT && !wanted_q[k])
                              && refused[k][3] == (measuring_q[k] && zero_bad_q)
                              && refused[k] != 5'd0);
                end
                if (!rst_q && !(armed_q[k] || measuring_q[k])) begin
                    assert (refused[k] == (wrote_1_q ? {2'd0, against_q[k]} : refused_q[k]));
                end
                cover (armed[k] && armed_q[k] && since_q == 3'd0);
                cover (!armed[k] && armed_q[k] && refused[k] == 5'b10000);
                cover (armed[k] && since_q == CREDIT);
                cover (!armed[k] && armed_q[k] && refused[k] == 5'b00010);
            end
            // A beginning.
            assert (!measuring[0] && !start[0]);
            if (armed[0] && !armed_q[0]) begin
                assert (wrote_1_q);
            end
            if (measuring[1] && !measuring_q[1]) begin
                assert (wrote_1_q && start[1]);
            end
            assert (start[1] == (measuring[1] && !measuring_q[1]));
            if (armed[1] && !armed_q[1]) begin
                assert (measuring_q[1] && !start_q && zero_good_q);
            end
            cover (armed[1] && refused_q[1] == 5'd0 && since_q == 3'd4);
            cover (measuring[1] && measuring_q[1] && old_zero);
            cover (!armed[1] && armed_q[1] && refused[1] == 5'b00010 && !fault);
            cover (!measuring[1] && measuring_q[1] && refused[1] == 5'b01000);
        end
    end

endmodule

`default_nettype wire
