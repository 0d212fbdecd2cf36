// SPDX-License-Identifier: Apache-2.0
//
// wh_round_words: the live values of a round (wh_ports), kept for two readers, who choose some of them one after
// another. Values are written as they come, and those of the last whole round are read.
//
// A round ends with strobe_o, TAIL clocks after the last port's flags: all of its values are there then, and none of
// the next round's. A reader that wants them (want_i) is given them by take_o: reader 0 with the strobe, reader 1 with
// it as well, or, where 0 has been, once that has chosen. It then has reads_i high for the clocks in which it chooses,
// from the next one on, 9 at most. A reader that still chooses as a round ends isn't given that one.
//
// code_i: the address of rtl/words.toml that a reader chooses, 0 lowest; word_o is the register there of who reads,
// in the next clock, sign-extended, and one that is none of those below is 0. mean_o: of several periods the mean is
// meant, as of numbers with a sign and of the bus; any_o: bits, of which those count that were there in any period;
// neither: the last one, as of the position. What a step makes is 0 in a round without one, and in a round in which
// the bridges went off before its end. contact_o: by port, as its flags last had it.
//
// Latency: as above. Reset: nobody is given anything.

`default_nettype none
`include "wh_formats.vh"
`include "wh_faults.vh"

module wh_round_words #(
    parameter integer N      = 1,                        // ports, 1...8
    parameter integer PORT_W = (N > 1) ? $clog2(N) : 1   // derived, leave it
) (
    input  wire                         clk,
    input  wire                         rst,

    // What it keeps.
    input  wire                         live_valid_i,     // strobe
    input  wire [PORT_W-1:0]            live_port_i,
    input  wire [3:0]                   live_word_i,      // WH_LIVE_...
    input  wire [31:0]                  live_data_i,
    input  wire [`WH_BUS_W-1:0]         bus_i,            // u16q9 V
    input  wire [`WH_FAULTS-1:0]        faults_i,
    output reg  [N-1:0]                 contact_o,

    // The readers, 0 lowest.
    input  wire [1:0]                   want_i,
    input  wire [1:0]                   reads_i,          // not both
    input  wire [23:0]                  code_i,
    output wire                         strobe_o,         // strobe, once a round
    output wire [1:0]                   take_o,           // strobes
    output wire [31:0]                  word_o,
    output wire                         mean_o,
    output wire                         any_o
);

    localparam integer PART_W = (N > 1) ? PORT_W : 0;
    localparam integer LAST   = N - 1;
    localparam [4:0]   TAIL   = 5'd29;  // wh_slots: the next round's first value comes 31 after the flags or later

    // ---- The round's end.
    wire       of_last = live_valid_i && live_port_i == LAST[PORT_W-1:0];
    reg  [4:0] tail_q;     // clocks that are left
    reg        bank_q;     // which is written
    reg  [1:0] step_q;     // of the last port's step, ω̂ and c came, the last two of its values
    reg        stepped_q;  // both of the other bank

    assign strobe_o = (tail_q == 5'd1);

    always @(posedge clk) begin
        if (rst) begin
            tail_q <= 5'd0;
            bank_q <= 1'b0;
            step_q <= 2'b00;
        end else begin
            tail_q <= (of_last && live_word_i == `WH_LIVE_FLAGS) ? TAIL : (tail_q == 5'd0) ? 5'd0 : tail_q - 5'd1;
            step_q <= {of_last && live_word_i == `WH_LIVE_LAG, of_last && live_word_i == `WH_LIVE_CORRECTION}
                      | (strobe_o ? 2'b00 : step_q);
            if (strobe_o) begin
                bank_q    <= !bank_q;
                stepped_q <= &step_q;
            end
        end
    end

    // ---- Whose turn it is.
    reg  second_q;  // reader 1 waits for reader 0
    wire begins = strobe_o && !second_q && (reads_i == 2'b00);

    assign take_o[0] = begins && want_i[0];
    assign take_o[1] = (begins && want_i == 2'b10) || (second_q && !reads_i[0] && want_i[1]);

    always @(posedge clk) begin
        second_q <= !rst && ((begins && want_i == 2'b11) || (second_q && reads_i[0]));
    end

    // ---- What is chosen: whose it is, and which value. Whose turn it will be is known before a reader is given
    // anything. A value's place follows from few bits of the address, whether it is one comes a clock later.
    wire         chooser = reads_i[1] || (!reads_i[0] && (second_q || !want_i[0]));
    wire [11:0]  code    = chooser ? code_i[23:12] : code_i[11:0];
    wire [3:0]   part    = code[11:8] - 4'd1;
    wire [3:0]   chosen  = !code[6] ? {1'b0, code[2:0]} : code[4] ? `WH_LIVE_FLAGS : {2'b10, code[1:0]};
    reg  [11:0]  code_q;
    reg          of_step;  // of code_q
    reg          of_port;

    always @* begin
        of_step = 1'b0;
        of_port = (code_q[11:8] != 4'd0) && ({28'd0, code_q[11:8]} <= N);
        casez (code_q[7:0])
            8'hb0, 8'hb1, 8'hb2, 8'b1100_00??: of_step = 1'b1;
            8'hb3, 8'hb4, 8'hd6:               of_step = 1'b0;
            default:                           of_port = 1'b0;
        endcase
    end

    // ---- The values, in two banks.
    wire [7:0]  to   = {bank_q, {(3 - PORT_W){1'b0}}, live_port_i, live_word_i};
    wire [7:0]  from = {!bank_q ^ strobe_o, part[2:0], chosen};
    wire [31:0] read;
    wire        unused = &{1'b0, part[3], to, from};

    wh_register_ram #(
        .PLACE_W       (PART_W + 5)
    ) values (
        .clk           (clk),
        .write_i       (live_valid_i),
        .write_place_i ({to[7], to[PART_W+3:0]}),
        .write_data_i  (live_data_i),
        .read_place_i  ({from[7], from[PART_W+3:0]}),
        .read_data_o   (read)
    );

    reg  [`WH_BUS_W-1:0]  bus_q;
    reg  [`WH_FAULTS-1:0] faults_q;

    always @(posedge clk) begin
        code_q <= code;
        if (strobe_o) begin
            bus_q    <= bus_i;
            faults_q <= faults_i;
        end
        if (live_valid_i && live_word_i == `WH_LIVE_FLAGS) begin
            contact_o[live_port_i] <= live_data_i[0];
        end
        if (rst) begin
            contact_o <= {N{1'b0}};
        end
    end

    wire is_flags  = of_port && code_q[7:0] == 8'hd6;
    wire is_faults = (code_q == 12'h062);

    assign word_o = (code_q == 12'h039)                  ? {{32-`WH_BUS_W{1'b0}}, bus_q}
                  : is_faults                            ? {{32-`WH_FAULTS{1'b0}}, faults_q}
                  : !of_port || (of_step && !stepped_q)  ? 32'd0
                  : is_flags                             ? {24'd0, read[7:0]} : read;
    assign any_o  = is_faults || is_flags;
    assign mean_o = !any_o && !(of_port && code_q[7:0] == 8'hb4);

endmodule

`default_nettype wire
