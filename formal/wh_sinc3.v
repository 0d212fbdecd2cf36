// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_sinc3: after a reset of any length at any clock the first two starts bring no word and the
// third brings 0; each word comes four clocks after its start and after nothing else, with the mark
// of the start before the last; no start counts and nothing trips before ready_o, which comes after a
// bounded time; overrun_o is a start that isn't OSR bits after the last.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_sinc3 #(
    parameter integer OSR      = 4,
    parameter integer TRIP_OSR = 2
) (
    input wire clk,
    input wire rst,
    input wire sdata,
    input wire start,
    input wire first
);

    localparam integer SETTLE = 2 * TRIP_OSR + 2;

    (* anyconst *) wire [7:0]  half;
    (* anyconst *) wire [15:0] trip_level;

    wire               sclk, ready, valid, first_o, trip, overrun;
    wire signed [15:0] sample;

    wh_sinc3 #(
        .OSR                (OSR),
        .TRIP_OSR           (TRIP_OSR)
    ) block (
        .clk                (clk),
        .rst                (rst),
        .adc_sclk_o         (sclk),
        .adc_sdata_i        (sdata),
        .sclk_half_clocks_i (half),
        .trip_i             (trip_level),
        .start_i            (start),
        .first_i            (first),
        .ready_o            (ready),
        .valid_o            (valid),
        .first_o            (first_o),
        .sample_o           (sample),
        .trip_o             (trip),
        .overrun_o          (overrun)
    );

    (* hierconn *) wire       \block.capture ;
    (* hierconn *) wire [6:0] \block.settle_q ;
    (* hierconn *) wire [7:0] \block.wait_q ;
    (* hierconn *) wire [8:0] \block.bits_q ;
    (* hierconn *) wire [1:0] \block.starts_q ;
    (* hierconn *) wire [1:0] \block.first_q ;
    (* hierconn *) wire [3:0] \block.stage_q ;
    (* hierconn *) wire [2:0] \block.answer_q ;

    wire        started = start && ready;
    // Until ready: bits, then clocks of the bit.
    wire [15:0] togo = {\block.settle_q , sclk == 1'b0, \block.wait_q };

    reg        begun = 1'b0;
    reg        rst_q, ready_q, overrun_q, started_q, early_q;
    reg [15:0] togo_q;
    reg [1:0]  starts = 2'd0;      // since reset, up to 3
    reg [8:0]  bits;               // since the last start, up to 511
    reg        mark1, mark2;       // of the last start, and of the one before
    reg [3:0]  due = 4'd0;         // words to come, by the clocks until then
    reg [3:0]  zero = 4'd0;        // and whether that is the third start's
    reg        mark_due;
    reg [2:0]  since;              // clocks since the last start, up to 4

    always @(posedge clk) begin
        begun     <= 1'b1;
        rst_q     <= rst;
        ready_q   <= ready;
        overrun_q <= overrun;
        togo_q    <= togo;
        started_q <= started;
        early_q   <= started && starts != 2'd0 && bits != OSR;

        assume (half >= 8'd1);
        // Two clocks a bit at the least, and OSR bits from start to start.
        assume (!started || since == 3'd4);
        if (!begun) assume (rst);

        since <= (rst || !started && since == 3'd4) ? 3'd4 : started ? 3'd1 : since + 3'd1;
        if (rst) begin
            starts <= 2'd0;
            bits   <= 9'd0;
            due    <= 4'd0;
            zero   <= 4'd0;
        end else begin
            due  <= {due[2:0], started && starts >= 2'd2};
            zero <= {zero[2:0], started && starts == 2'd2};
            if (started) begin
                starts   <= (starts == 2'd3) ? 2'd3 : starts + 2'd1;
                bits     <= {8'd0, \block.capture };
                mark1    <= first;
                mark2    <= mark1;
                mark_due <= mark2;
            end else if (\block.capture && bits != 9'h1ff) begin
                bits <= bits + 9'd1;
            end
        end

        if (begun) begin
            if (rst_q) assert (!valid && !overrun && !trip && !ready && !sclk);
            if (!rst_q && ready_q) assert (ready);
            if (!rst_q && !ready_q) assert (togo < togo_q);
            if (!ready) assert (!valid && !trip);
            assert (valid == due[3]);
            if (valid) assert (first_o == mark_due);
            if (valid && zero[3]) assert (sample == 16'sd0);
            if (!rst_q) assert (overrun == (overrun_q || early_q));

            // What makes that inductive.
            assert (\block.starts_q == starts && \block.bits_q == bits);
            assert (\block.settle_q <= SETTLE && \block.wait_q < half);
            if (!ready) assert (starts == 2'd0 && due == 4'd0);
            if (starts != 2'd0) assert (\block.first_q [0] == mark1);
            if (starts >= 2'd2) assert (\block.first_q [1] == mark2);
            assert (since >= 3'd1 && since <= 3'd4);
            if (starts == 2'd0) assert (due == 4'd0 && \block.stage_q == 4'd0);
            assert ((due & ~\block.stage_q ) == 4'd0);
            assert ((zero & ~due) == 4'd0);
            // One start at a time.
            assert (\block.stage_q == 4'd0 || (\block.stage_q == (4'd1 << (since - 3'd1))));
            if (\block.stage_q != 4'd0) begin
                assert ((due != 4'd0) == \block.answer_q [1]);
                assert ((due != 4'd0 && zero == 4'd0) == \block.answer_q [2]);
                if (due != 4'd0) assert (\block.answer_q [0] == mark_due);
                assert (starts != 2'd0);
                assert ((due != 4'd0) == (starts == 2'd3));
            end
        end

        cover (begun && valid && sample > 16'sd0 && !overrun);
        cover (begun && valid && sample < 16'sd0 && overrun);
        cover (begun && trip);
    end

endmodule

`default_nettype wire
