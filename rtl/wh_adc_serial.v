// SPDX-License-Identifier: Apache-2.0
//
// wh_adc_serial: reads analog-to-digital converters whose frame is CS_n, pulses of SCLK and bits.
//
//   CS_n    ‾\__________________________________________/‾‾‾‾
//   SCLK    ‾‾‾‾\__/‾‾\__/‾‾ ... ‾‾\__/‾‾\__/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾    sclk_idle_i = 1
//   SCLK    ____/‾‾\__/‾‾\__ ... __/‾‾\__/‾‾\________________    sclk_idle_i = 0
//           setup  1st pulse        frame_bits_i-th  hold  quiet
//   sample = (code - 2^(data_bits-1)) * 2^(16-data_bits)
//
// CS_n falls in the clock after start_i, and the part holds its input at that edge. The first pulse
// begins setup_clocks_i later; a pulse and the pause after it last sclk_half_clocks_i each. Bit k is
// read at pulse k: in the clock edge that begins the pulse (read_trailing_i = 0) or ends it, so
// before the part changes its output there. lead_bits_i zeros come first, then data_bits_i bits
// from the highest on, straight binary with 0 A at mid-scale. CS_n rises hold_clocks_i after the
// last pulse has ended, and quiet_clocks_i or more pass before it may fall again.
// All converters share CS_n and SCLK, so they sample at the same instant.
//
// Where calibrate_bits_i isn't 0, a frame of so many pulses comes by itself after reset, with which
// the part measures its own offset; ready_o rises after it, and start_i is without effect before.
// Settings of the parts, and their limits in seconds: sim/wavehaptics/parts/adcs.py.
//
// Formats: sample s16, full scale +-2^15 at any resolution. Latency from start_i to valid_o:
// 1 + setup_clocks_i + (e - 1) sclk_half_clocks_i, e = 2 (lead_bits_i + data_bits_i) - 1 +
// read_trailing_i. sample_o is where the bits are put down: it holds from valid_o until the next
// frame's data. Reset: CS_n high and SCLK idle at once; if that cuts a frame short, the part may
// take the next one to recover.

`default_nettype none
`include "wh_formats.vh"

module wh_adc_serial #(
    parameter integer LINES = 1  // converters, 1...
) (
    input  wire                         clk,
    input  wire                         rst,

    output wire                         adc_cs_n_o,
    output wire                         adc_sclk_o,
    input  wire [LINES-1:0]             adc_sdata_i,

    input  wire [7:0]                   sclk_half_clocks_i,  // half a period of SCLK, clocks, 1...
    input  wire [5:0]                   frame_bits_i,        // pulses of SCLK, lead + data...63
    input  wire [5:0]                   lead_bits_i,         // 0...
    input  wire [4:0]                   data_bits_i,         // 1...16
    input  wire [7:0]                   quiet_clocks_i,      // CS_n high, clocks; 0 is as 1
    input  wire [7:0]                   setup_clocks_i,      // CS_n to the first pulse, clocks, 1...
    input  wire [7:0]                   hold_clocks_i,       // last pulse's end to CS_n, clocks, 0...
    input  wire [5:0]                   calibrate_bits_i,    // pulses of the first frame; 0: none
    input  wire                         sclk_idle_i,         // SCLK between frames
    input  wire                         read_trailing_i,     // read at the end of a pulse

    input  wire                         start_i,             // strobe; ignored while busy_o
    input  wire                         first_i,             // with start_i: comes back as first_o
    output wire                         ready_o,             // the part has been set up
    output wire                         busy_o,
    output wire                         lead_edge_o,         // SCLK's pulse begins with this clock
    output wire                         valid_o,             // strobe
    output wire                         first_o,             // with valid_o
    output wire [LINES*`WH_SAMPLE_W-1:0] sample_o,           // s16 each, line 0 lowest

    output wire                         overrun_o            // start_i came too early; until rst
);

    generate
        if (LINES < 1) begin : illegal
            wh_illegal_parameter_adc_serial_lines_must_be_1_or_more stop ();
        end
    endgenerate

    reg       cs_n_q;
    reg       sclk_q;
    reg [7:0] wait_q;       // clocks to the next edge, or to the end of the quiet time
    reg [5:0] pulses_q;     // pulses of SCLK still to begin
    reg [5:0] lead_q;       // of them, zeros
    reg [4:0] data_q;       // of them, data bits
    reg       ready_q;
    reg       first_q;
    reg       valid_q;
    reg       overrun_q;

    wire quiet  = cs_n_q && (wait_q != 8'd0);
    wire idle   = cs_n_q && !quiet;
    wire start  = start_i && idle && ready_q;
    wire set_up = idle && !ready_q;
    wire turn   = !cs_n_q && (wait_q == 8'd0);
    wire pulse  = (sclk_q != sclk_idle_i);
    wire last   = (pulses_q == 6'd0);
    wire begins = turn && !pulse && !last;
    wire ends   = turn && pulse;
    wire finish = turn && last && (pulse ? (hold_clocks_i == 8'd0) : 1'b1);
    wire read   = read_trailing_i ? ends : begins;
    wire lead   = (lead_q != 6'd0);
    wire data   = !lead && (data_q != 5'd0);

    wire [7:0] half_wait  = sclk_half_clocks_i - 8'd1;
    wire [7:0] quiet_wait = (quiet_clocks_i == 8'd0) ? 8'd0 : quiet_clocks_i - 8'd1;

    assign busy_o      = !idle || !ready_q;
    assign lead_edge_o = begins;

    always @(posedge clk) begin
        valid_q <= 1'b0;
        if (rst) begin
            cs_n_q    <= 1'b1;
            sclk_q    <= sclk_idle_i;
            wait_q    <= quiet_wait;
            pulses_q  <= 6'd0;
            lead_q    <= 6'd0;
            data_q    <= 5'd0;
            ready_q   <= (calibrate_bits_i == 6'd0);
            first_q   <= 1'b0;
            overrun_q <= 1'b0;
        end else begin
            if (start_i && ready_q && !idle) begin
                overrun_q <= 1'b1;
            end
            if (start || set_up) begin
                cs_n_q   <= 1'b0;
                wait_q   <= setup_clocks_i - 8'd1;
                pulses_q <= set_up ? calibrate_bits_i : frame_bits_i;
                lead_q   <= lead_bits_i;
                data_q   <= set_up ? 5'd0 : data_bits_i;
                first_q  <= first_i;
            end else if (wait_q != 8'd0) begin
                wait_q <= wait_q - 8'd1;
            end else if (turn) begin
                if (begins || ends) begin
                    sclk_q <= !sclk_q;
                end
                if (begins) begin
                    pulses_q <= pulses_q - 6'd1;
                end
                if (read) begin
                    lead_q  <= lead ? lead_q - 6'd1 : 6'd0;
                    data_q  <= data ? data_q - 5'd1 : data_q;
                    valid_q <= data && (data_q == 5'd1);
                end
                cs_n_q <= finish;
                wait_q <= finish ? quiet_wait : (ends && last) ? hold_clocks_i - 8'd1 : half_wait;
                if (finish) begin
                    ready_q <= 1'b1;
                end
            end
        end
    end

    // Where the next data bit goes: from the highest bit of the word down.
    reg [`WH_SAMPLE_W-1:0] place_q;

    always @(posedge clk) begin
        if (start) begin
            place_q <= {1'b1, {`WH_SAMPLE_W-1{1'b0}}};
        end else if (read && data) begin
            place_q <= place_q >> 1;
        end
    end

    genvar n;
    generate
        for (n = 0; n < LINES; n = n + 1) begin : line
            reg  [`WH_SAMPLE_W-1:0] sample_q;
            // Straight binary minus mid-scale: the highest bit turned over.
            wire                    bit_in = adc_sdata_i[n] ^ place_q[`WH_SAMPLE_W-1];

            always @(posedge clk) begin
                if (read && data) begin
                    // The first bit also clears what an earlier, longer code left below it.
                    sample_q <= (place_q[`WH_SAMPLE_W-1] ? {`WH_SAMPLE_W{1'b0}} : sample_q)
                                | (place_q & {`WH_SAMPLE_W{bit_in}});
                end
            end

            assign sample_o[n*`WH_SAMPLE_W +: `WH_SAMPLE_W] = sample_q;
        end
    endgenerate

    assign adc_cs_n_o = cs_n_q;
    assign adc_sclk_o = sclk_q;
    assign ready_o    = ready_q;
    assign valid_o    = valid_q;
    assign first_o    = first_q;
    assign overrun_o  = overrun_q;

endmodule

`default_nettype wire
