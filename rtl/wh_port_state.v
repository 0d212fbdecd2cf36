// SPDX-License-Identifier: Apache-2.0
//
// wh_port_state: a word of state for each of N ports that take turns.
//
//   value_o = the word of port_i;  save_i writes value_i to that of save_port_i
//
// A station names the port whose turn it is, and its state is there in the same clock. N = 1 is a register.
// With more ports it is a RAM of the FPGA's LUTs, which has no reset: a bit for each port says that its word
// has not been written since, and reads as 0. State whose reset value isn't 0 is stored with these bits
// inverted.
// Formats: any. Latency: none from port_i; a word that is written can be read in the next clock.
// Reset: every port's word is 0; with RESETS = N, one bit of rst for each, that port's alone.

`default_nettype none

module wh_port_state #(
    parameter integer N      = 1,                        // ports, 1...
    parameter integer W      = 8,                        // bits of a word, 1...
    parameter integer RESETS = 1,                        // 1...: bits of rst, 1 or N
    parameter integer PORT_W = (N > 1) ? $clog2(N) : 1   // derived, leave it
) (
    input  wire              clk,
    input  wire [RESETS-1:0] rst,

    input  wire [PORT_W-1:0] port_i,   // 0...N - 1
    input  wire              save_i,
    input  wire [PORT_W-1:0] save_port_i,
    input  wire [W-1:0]      value_i,
    output wire [W-1:0]      value_o
);

    generate
        if (N < 1 || W < 1 || (RESETS != 1 && RESETS != N) || PORT_W != ((N > 1) ? $clog2(N) : 1)) begin : illegal
            wh_illegal_parameter_port_state_n_or_w stop ();
        end
    endgenerate

    generate
        if (N == 1) begin : one
            reg [W-1:0] value_q;

            wire unused = &{1'b0, port_i, save_port_i};

            always @(posedge clk) begin
                if (rst) begin
                    value_q <= {W{1'b0}};
                end else if (save_i) begin
                    value_q <= value_i;
                end
            end

            assign value_o = value_q;
        end else begin : several
            reg [W-1:0]         words [0:(1<<PORT_W)-1];
            reg [(1<<PORT_W)-1:0] written_q;
            integer             n;

            always @(posedge clk) begin
                if (save_i) begin
                    words[save_port_i] <= value_i;
                end
                if (save_i) begin
                    written_q[save_port_i] <= 1'b1;
                end
                for (n = 0; n < (1<<PORT_W); n = n + 1) begin
                    if (rst[(n < RESETS) ? n : 0]) begin
                        written_q[n] <= 1'b0;
                    end
                end
            end

            assign value_o = words[port_i] & {W{written_q[port_i]}};
        end
    endgenerate

endmodule

`default_nettype wire
