// SPDX-License-Identifier: Apache-2.0
//
// wh_board_reset: holds reset until the PLL has been locked for a while.
//
// Latency: rst_o falls 2^HOLD_LOG2 clocks after locked_i has risen, and rises 3 clocks after it
// falls. Without a clock it stays where it was. The registers begin at 0, which is reset, as the
// FPGA's configuration leaves them.

`default_nettype none

module wh_board_reset #(
    parameter integer HOLD_LOG2 = 16  // reset lasts 2^HOLD_LOG2 clocks
) (
    input  wire clk,
    input  wire locked_i,  // asynchronous
    output wire rst_o
);

    wire locked;

    wh_synchroniser #(
        .WIDTH   (1)
    ) synchroniser (
        .clk     (clk),
        .level_i (locked_i),
        .level_o (locked)
    );

    reg [HOLD_LOG2-1:0] held_q;
    reg                 run_q;

    initial begin
        held_q = {HOLD_LOG2{1'b0}};
        run_q  = 1'b0;
    end

    always @(posedge clk) begin
        if (!locked) begin
            held_q <= {HOLD_LOG2{1'b0}};
            run_q  <= 1'b0;
        end else begin
            held_q <= held_q + 1'b1;
            run_q  <= run_q || (held_q == {HOLD_LOG2{1'b1}});
        end
    end

    assign rst_o = !run_q;

endmodule

`default_nettype wire
