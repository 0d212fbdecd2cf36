// SPDX-License-Identifier: Apache-2.0
//
// wh_port_check: whether any setting of a port is a word that no station has a meaning for.
//
//   a outside (0, 1], |eta| > 1, and a root, a gain, clocks per volt or a limit that is not positive
//
// The words are judged as they are written, and a bit for each is kept, by port and bank. When the bank in force
// changes, or a word in it, the ports are looked at one a clock.
// Formats: those of the settings (wh_port_settings). Latency: 2 to N + 1 clocks.
// State, by port and bank, in LUT RAM: 7 bits. As the settings, these have no reset: a word that nobody wrote is
// not known to be legal. Reset: nothing is wrong; all is looked at after it.

`default_nettype none
`include "wh_formats.vh"

module wh_port_check #(
    parameter integer N      = 1,                        // ports, 1...8
    parameter integer PORT_W = (N > 1) ? $clog2(N) : 1   // derived, leave it
) (
    input  wire        clk,
    input  wire        rst,

    // The register bus (wh_port_settings), and the bank in force.
    input  wire        force_i,
    input  wire        write_i,       // strobe
    input  wire        write_bank_i,
    input  wire [11:0] address_i,     // part and place
    input  wire [31:0] data_i,

    output reg         illegal_o
);

    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;
    localparam integer LAST   = N - 1;
    localparam integer WORDS  = 7;

    generate
        if (N < 1 || N > 8) begin : illegal_parameter
            wh_illegal_parameter_port_check_n_must_be_1_to_8 stop ();
        end
    endgenerate

    // ---- The word that is written. A coefficient of full scale +-2 has its highest bits to tell.
    wire [COEF_W-1:0] word         = data_i[COEF_W-1:0];
    wire              negative     = word[COEF_W-1];
    wire              positive     = !negative && (|word);
    wire              beyond_one   = negative ? !word[COEF_W-2] : word[COEF_W-2] && (|word[COEF_W-3:0]);
    reg  [WORDS-1:0]  which;  // of the words that are judged; none: another one
    reg               legal;

    always @* begin
        case (address_i[7:0])
            8'h01:   {which, legal} = {7'b0000001, positive};                 // gain
            8'h08:   {which, legal} = {7'b0000010, !beyond_one};              // eta_contact
            8'h09:   {which, legal} = {7'b0000100, !beyond_one};              // eta_free
            8'h10:   {which, legal} = {7'b0001000, positive};                 // root
            8'h11:   {which, legal} = {7'b0010000, positive && !beyond_one};  // a
            8'h12:   {which, legal} = {7'b0100000, !data_i[DATA_W-1]};        // u_max
            8'h18:   {which, legal} = {7'b1000000, positive};                 // clocks_per_volt
            default: {which, legal} = 8'd0;
        endcase
    end

    // ---- What is known of a port, and a place of a bank and a port for it.
    reg  [WORDS-1:0]  legal_words [0:(2<<PORT_W)-1];
    reg  [PORT_W-1:0] look_q;    // at this port
    reg               looks_q;
    reg               found_q;   // one that is illegal
    reg               force_q;

    wire [3:0]        part    = address_i[11:8] - 4'd1;
    wire              here    = write_i && {28'd0, part} < N;
    wire [PORT_W:0]   written = {write_bank_i, part[PORT_W-1:0]};
    wire [WORDS-1:0]  known   = legal_words[written];
    wire              wrong   = !(&legal_words[{force_q, look_q}]);
    wire              last    = look_q == LAST[PORT_W-1:0];
    wire              unused  = &{1'b0, data_i};

    always @(posedge clk) begin
        if (here) begin
            legal_words[written] <= legal ? known | which : known & ~which;
        end
        force_q <= force_i;
        if (rst) begin
            illegal_o <= 1'b0;
            looks_q   <= 1'b1;
            look_q    <= {PORT_W{1'b0}};
            found_q   <= 1'b0;
        end else if (force_i != force_q || (here && write_bank_i == force_i)) begin
            looks_q   <= 1'b1;
            look_q    <= {PORT_W{1'b0}};
            found_q   <= 1'b0;
        end else if (looks_q) begin
            illegal_o <= found_q || wrong || (illegal_o && !last);
            looks_q   <= !last;
            look_q    <= look_q + 1'b1;
            found_q   <= found_q || wrong;
        end
    end

endmodule

`default_nettype wire
