// SPDX-License-Identifier: Apache-2.0
//
// wh_bus_scale: pulse width per volt on the measured bus, and the u_max that the bus allows.
//
//   clocks_per_volt = floor(half_clocks / (2 reach bus)),   reach = 1/2 in a half bridge, else 1
//   share = min(1, floor(bus bus_share)),                   bus_share = reach / limit
//   u_max = floor(u_max share)
//
// limit is the voltage of u_max plus the pulse's reserve for dead time and shortest pulses; the largest of all ports.
// So the voltage that the core assumes is the applied one on any bus. A bus that is measured too low acts like an R̂
// that is too high. A quotient beyond its format saturates. The block runs continuously, one bit a clock: the division
// and the share for the whole design, then a product for each port. All results of one bus change together, in the
// first clock without hold_i, as a step of the core needs one u_max from its first clock to its last.
// sim/wavehaptics/controller/bus_scale.py is the same with integers, and this module equals it bit for bit.
//
// Formats: at the ports; share has WH_BUS_SHARE_Q + WH_BUS_Q - WH_BUS_W fraction bits, 17 at present.
// Latency: 60 clocks a bus for WH_COEF_W = 27: a change of bus_i acts after at most 119, plus the wait for a clock
// without hold_i. A change of u_max_i acts at once while share is 1, else like one of bus_i.
// Reset: clocks_per_volt_o = clocks_per_volt_i, share = 1; both hold until the first quotient.

`default_nettype none
`include "wh_formats.vh"

module wh_bus_scale #(
    parameter integer N = 1  // motors, 1...8
) (
    input  wire                    clk,
    input  wire                    rst,

    input  wire                    hold_i,             // the outputs stay as they are
    output wire                    gives_o,            // they change with this clock's end: no word
                                                       // below is under way then

    input  wire [`WH_TICK_W-1:0]   half_clocks_i,      // clocks in a carrier half
    input  wire                    half_bridge_i,      // the bus reaches half of itself
    input  wire [`WH_BUS_W-1:0]    bus_i,              // u16q9 V
    input  wire [`WH_COEF_W-1:0]   bus_share_i,        // s27q24 1/V, 0...

    input  wire [N*`WH_COEF_W-1:0] clocks_per_volt_i,  // s27q16 clocks/V, for reset
    output reg  [N*`WH_COEF_W-1:0] clocks_per_volt_o,  // s27q16 clocks/V

    input  wire [N*`WH_DATA_W-1:0] u_max_i,            // s31q23 √W, 0...
    output wire [N*`WH_DATA_W-1:0] u_max_o             // s31q23 √W
);

    localparam integer COEF_W  = `WH_COEF_W;
    localparam integer DATA_W  = `WH_DATA_W;
    localparam integer BUS_W   = `WH_BUS_W;
    localparam integer WORD_W  = COEF_W - 1;                            // a coefficient's magnitude
    localparam integer SHARE_Q = `WH_BUS_SHARE_Q + `WH_BUS_Q - BUS_W;       // fraction bits of share
    // Bits of half_clocks / (2 reach bus) in words: half_clocks 2^ZEROS / bus, twice in a half bridge.
    localparam integer ZEROS   = `WH_DUTY_Q + `WH_BUS_Q - 1;
    localparam integer STEPS   = 1 + `WH_TICK_W + ZEROS;

    // The clocks: 0 takes the bus, 1...STEPS divide, then the products, and in LAST all is there.
    localparam [6:0]   DIVIDED = STEPS[6:0];
    localparam [6:0]   LAST    = STEPS[6:0] + SHARE_Q[6:0] + 7'd1;

    generate
        if (N < 1 || N > 8) begin : illegal
            wh_illegal_parameter_bus_scale_n_must_be_1_to_8 stop ();
        end
        if (WORD_W < `WH_TICK_W + 2 || SHARE_Q < 1 || STEPS + SHARE_Q + 1 > 127)
        begin : illegal_format
            wh_illegal_WH_COEF_W_too_small_for_a_bus stop ();
        end
    endgenerate

    reg  [6:0] step_q;  // 0: the next one begins
    wire       begins   = (step_q == 7'd0);
    wire       divides  = (step_q <= DIVIDED);
    wire       last     = (step_q == LAST);
    wire       gives    = last && !hold_i;

    assign gives_o = gives;

    always @(posedge clk) begin
        if (rst || gives) begin
            step_q <= 7'd0;
        end else if (!last) begin
            step_q <= step_q + 7'd1;
        end
    end

    // ---- The division. digits_q holds the dividend's bits to come, then zeros, and behind both the
    // quotient. What leaves it after WORD_W steps is the quotient's, too much for the word.
    reg  [BUS_W-1:0]  bus_q;     // held for a quotient
    reg  [WORD_W-1:0] digits_q;
    reg  [BUS_W-1:0]  rest_q;
    reg               over_q;
    wire [BUS_W:0]    trial = {rest_q, digits_q[WORD_W-1]};
    wire [BUS_W:0]    less  = trial - {1'b0, bus_q};
    wire              fits  = trial >= {1'b0, bus_q};
    wire              unused_less = &{1'b0, less[BUS_W], trial[BUS_W]};

    // ---- The share: bus_share for each bit of the bus, the lowest first, and half of the sum so far.
    // Behind the division its bits leave for the products.
    reg  [WORD_W-1:0] share_q;
    wire [WORD_W:0]   share_sum = {1'b0, share_q}
                                  + (bus_q[step_q[3:0] - 4'd1] ? {1'b0, bus_share_i[WORD_W-1:0]}
                                                               : {WORD_W+1{1'b0}});
    reg               whole_q;   // share is 1
    reg               pass_q;    // the same of the words that are given
    wire              unused_share = &{1'b0, share_sum[0], bus_share_i[COEF_W-1]};

    integer n;

    always @(posedge clk) begin
        if (rst) begin
            pass_q <= 1'b1;
        end else if (gives) begin
            pass_q <= whole_q;
        end
        for (n = 0; n < N; n = n + 1) begin
            if (rst) begin
                clocks_per_volt_o[n*COEF_W +: COEF_W] <= clocks_per_volt_i[n*COEF_W +: COEF_W];
            end else if (gives) begin
                clocks_per_volt_o[n*COEF_W +: COEF_W] <=
                    {1'b0, digits_q | {WORD_W{over_q}}};
            end
        end
        if (begins) begin
            bus_q    <= bus_i;
            digits_q <= half_bridge_i ? {half_clocks_i, {WORD_W-`WH_TICK_W{1'b0}}}
                                      : {1'b0, half_clocks_i, {WORD_W-`WH_TICK_W-1{1'b0}}};
            rest_q   <= {BUS_W{1'b0}};
            over_q   <= 1'b0;
            share_q  <= {WORD_W{1'b0}};
        end else if (divides) begin
            digits_q <= {digits_q[WORD_W-2:0], fits};
            rest_q   <= fits ? less[BUS_W-1:0] : trial[BUS_W-1:0];
            over_q   <= over_q || (step_q > WORD_W[6:0] && digits_q[WORD_W-1]);
            if (step_q <= BUS_W[6:0]) begin
                share_q <= share_sum[WORD_W:1];
            end
            whole_q <= |share_q[WORD_W-1:SHARE_Q];
        end else if (!last) begin
            share_q <= share_q >> 1;
        end
    end

    // ---- u_max of each port, by the share's bits, as above.
    genvar g;
    generate
        for (g = 0; g < N; g = g + 1) begin : port
            localparam integer SIZE_W = DATA_W - 1;

            wire [SIZE_W-1:0]  u_max = u_max_i[g*DATA_W +: SIZE_W];
            reg  [SIZE_W-1:0]  sum_q;
            reg  [SIZE_W-1:0]  result_q;
            wire [SIZE_W:0]    sum   = {1'b0, sum_q}
                                       + (share_q[0] ? {1'b0, u_max} : {SIZE_W+1{1'b0}});
            wire               unused_sum = &{1'b0, sum[0]};

            always @(posedge clk) begin
                if (divides) begin
                    sum_q <= {SIZE_W{1'b0}};
                end else if (!last) begin
                    sum_q <= sum[SIZE_W:1];
                end
                if (gives) begin
                    result_q <= sum_q;
                end
            end

            assign u_max_o[g*DATA_W +: DATA_W] = pass_q ? u_max_i[g*DATA_W +: DATA_W]
                                                        : {1'b0, result_q};
        end
    endgenerate

endmodule

`default_nettype wire
