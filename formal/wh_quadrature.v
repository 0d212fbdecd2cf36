// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_quadrature: a line's believed level changes at the last of filter_clocks_i samples in a row
// that contradict it, and then only; every change of one line counts as the table of the encoder
// has it, and every change of both is latched. The pins do what they like.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_quadrature (
    input wire clk,
    input wire rst,
    input wire a,
    input wire b,
    input wire clear
);

    (* anyconst *) wire [3:0] filter;

    wire signed [`WH_COUNT_W-1:0] position;
    wire                          moved, direction, fault;
    wire        [7:0]             faults;

    wh_quadrature block (
        .clk             (clk),
        .rst             (rst),
        .a_i             (a),
        .b_i             (b),
        .filter_clocks_i (filter),
        .clear_i         (clear),
        .position_o      (position),
        .moved_o         (moved),
        .direction_o     (direction),
        .fault_o         (fault),
        .faults_o        (faults)
    );

    (* hierconn *) wire [1:0] \block.seen ;
    (* hierconn *) wire [1:0] \block.level ;
    (* hierconn *) wire [1:0] \block.before_q ;
    (* hierconn *) wire [3:0] \block.settle_q ;
    (* hierconn *) wire [3:0] \block.line[0].against_q ;
    (* hierconn *) wire [3:0] \block.line[1].against_q ;

    wire [1:0] level   = \block.level ;
    wire       settled = (\block.settle_q == 4'd15);

    // Where in an encoder's line the levels {A, B} stand.
    function [1:0] place(input [1:0] levels);
        case (levels)
            2'b00:   place = 2'd0;
            2'b10:   place = 2'd1;
            2'b11:   place = 2'd2;
            default: place = 2'd3;
        endcase
    endfunction

    reg                          begun = 1'b0;
    reg        [1:0]             level_q;      // believed, a clock before
    reg signed [`WH_COUNT_W-1:0] count;
    reg                          illegal_q;    // both changed, a clock before
    reg                          settled_q, clear_q, rst_q, fault_q;
    reg        [7:0]             faults_q;
    reg signed [`WH_COUNT_W-1:0] position_q;
    reg        [3:0]             against [0:1];  // samples in a row against the level, up to 15
    reg        [1:0]             must;           // give way in this clock
    wire       [1:0]             step = place(level) - place(\block.before_q );

    integer n;

    always @(posedge clk) begin
        begun      <= 1'b1;
        level_q    <= level;
        settled_q  <= settled && !rst;
        clear_q    <= clear;
        rst_q      <= rst;
        fault_q    <= fault;
        faults_q   <= faults;
        position_q <= position;
        illegal_q  <= settled && !rst && step == 2'd2;
        count      <= (rst || !settled) ? 32'd0
                    : (step == 2'd1) ? count + 32'd1
                    : (step == 2'd3) ? count - 32'd1 : count;
        for (n = 0; n < 2; n = n + 1) begin
            against[n] <= (rst || !settled || \block.seen [n] == level[n]
                           || {1'b0, against[n]} + 5'd1 >= {1'b0, filter}) ? 4'd0
                        : against[n] + 4'd1;
            must[n]    <= !rst && settled && \block.seen [n] != level[n]
                          && {1'b0, against[n]} + 5'd1 >= {1'b0, filter};
        end

        assume (filter >= 4'd1);
        if (!begun) begin
            assume (rst);
        end else begin
            assert (position == count);
            assert (position - position_q == 0 || position - position_q == 1
                    || position - position_q == -1 || !settled_q);
            if (settled_q) begin
                assert (moved == (position != position_q));
                if (moved) assert (direction == (position - position_q == 1));
                assert ((level_q ^ level) == must);
            end
            if (rst_q) assert (!fault && faults == 8'd0 && position == 0);
            if (illegal_q && !clear_q) begin
                assert (fault && faults == ((faults_q == 8'hFF) ? 8'hFF : faults_q + 8'd1));
            end
            // Nothing else sets it, and only clear_i and reset end it.
            if (!illegal_q) assert (!fault || fault_q);
            if (fault_q && !clear_q && !rst_q) assert (fault);
            assert (fault == (faults != 8'd0));

            // What makes that inductive.
            assert (\block.before_q == level_q);
            assert (\block.line[0].against_q == against[0] && \block.line[1].against_q == against[1]);
            assert (against[0] < filter && against[1] < filter);
            if (!settled_q && !settled) assert (position == 0);
        end

        cover (begun && filter == 4'd1 && position == -2);
        cover (begun && filter == 4'd2 && position == 1);
        cover (begun && fault && faults == 8'd1);
    end

endmodule

`default_nettype wire
