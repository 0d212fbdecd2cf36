// SPDX-License-Identifier: Apache-2.0
//
// wh_settings_rom as the proof of wh_registers has it: one address, which may be any, whose kind and
// range may be any; of other addresses anything is said, but that there is no setting from 0x80 on,
// where the memory without a shaper has no place, and that `commit` and `discard` are commands.

`default_nettype none

module wh_settings_rom #(
    parameter integer WALLS      = 4,
    parameter integer SHAPER     = 0,
    parameter integer DELAY_LOG2 = 2,
    parameter integer BOTH       = 0
) (
    input  wire        clk,
    input  wire [8:0]  address_i,
    output wire [1:0]  kind_o,
    output wire        off_o,
    output wire        signed_o,
    input  wire        greatest_i,
    output reg  [31:0] bound_o
);

    (* anyconst *) wire [8:0]  address;
    (* anyconst *) wire [3:0]  info;
    (* anyconst *) wire [31:0] least;
    (* anyconst *) wire [31:0] greatest;
    (* anyseq *)   wire [3:0]  other;
    (* anyseq *)   wire [31:0] other_bound;

    wire [3:0] elsewhere = (address_i[8:1] == 8'h38)                ? 4'b1000
                         : (address_i[7] && other[3:2] == 2'd1)     ? 4'b0000 : other;

    reg [3:0]  info_q;
    reg        here_q;  // info_q is of the address
    reg [3:0]  told_q;
    reg [31:0] bound_q;

    assign {kind_o, off_o, signed_o} = told_q;

    always @(posedge clk) begin
        here_q  <= (address_i == address);
        info_q  <= (address_i == address) ? info : elsewhere;
        told_q  <= info_q;
        bound_q <= !here_q ? other_bound : greatest_i ? greatest : least;
        bound_o <= bound_q;
    end

endmodule

`default_nettype wire
