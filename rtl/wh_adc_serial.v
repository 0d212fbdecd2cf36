// SPDX-License-Identifier: Apache-2.0
//
// wh_adc_serial: reads analog-to-digital converters of the AD7476A and AD7276 kind.
//
//   CS_n    ‾\_______________________________________/‾‾‾‾‾
//   SCLK    ‾‾‾\__/‾‾\__/‾‾ ... ‾‾\__/‾‾\__/‾‾‾‾‾‾‾‾‾‾‾‾‾‾      (frame_bits_i falls)
//   sample = (code - 2^(data_bits-1)) * 2^(16-data_bits)
//
// CS_n falls in the clock after start_i, and the part holds its input at that edge. SCLK idles high
// and first falls sclk_half_clocks_i later. Bit k is read at fall k of SCLK: in the clock edge that
// makes the fall, so before the part changes its output. lead_bits_i zeros come first, then
// data_bits_i bits from the highest on, straight binary with 0 A at mid-scale. CS_n rises with
// SCLK's last rise, and quiet_clocks_i or more pass before it may fall again.
// All converters share CS_n and SCLK, so they sample at the same instant.
//
// AD7476A: lead 4, data 12, frame 16; AD7276: lead 2, data 12, frame 14. Their limits in seconds
// are the user's: SCLK's rate, CS_n to SCLK (sclk_half_clocks_i), quiet time and least CS_n high.
//
// Formats: sample s16, full scale +-2^15 at any resolution. Latency: 1 + (2k - 1)
// sclk_half_clocks_i from start_i to valid_o, k = lead_bits_i + data_bits_i. sample_o is where the
// bits are put down: it holds from valid_o until the next frame's data. Reset: CS_n and SCLK high
// at once; if that cuts a frame short, the part may take the next one to recover.

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
    input  wire [5:0]                   frame_bits_i,        // falls of SCLK, lead + data...63
    input  wire [5:0]                   lead_bits_i,         // 0...
    input  wire [4:0]                   data_bits_i,         // 1...16
    input  wire [7:0]                   quiet_clocks_i,      // CS_n high, clocks; 0 is as 1

    input  wire                         start_i,             // strobe; ignored while busy_o
    output wire                         busy_o,
    output wire                         valid_o,             // strobe
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
    reg [7:0] wait_q;       // clocks to SCLK's next edge, or to the end of the quiet time
    reg [5:0] falls_q;      // falls of SCLK still to come
    reg [5:0] lead_q;       // of them, zeros
    reg [4:0] data_q;       // of them, data bits
    reg       valid_q;
    reg       overrun_q;

    wire quiet = cs_n_q && (wait_q != 8'd0);
    wire start = start_i && !busy_o;
    wire turn  = !cs_n_q && (wait_q == 8'd0);
    wire fall  = turn && sclk_q;
    wire lead  = (lead_q != 6'd0);
    wire data  = !lead && (data_q != 5'd0);

    wire [7:0] half_wait  = sclk_half_clocks_i - 8'd1;
    wire [7:0] quiet_wait = (quiet_clocks_i == 8'd0) ? 8'd0 : quiet_clocks_i - 8'd1;

    assign busy_o = !cs_n_q || quiet;

    always @(posedge clk) begin
        valid_q <= 1'b0;
        if (rst) begin
            cs_n_q    <= 1'b1;
            sclk_q    <= 1'b1;
            wait_q    <= quiet_wait;
            falls_q   <= 6'd0;
            lead_q    <= 6'd0;
            data_q    <= 5'd0;
            overrun_q <= 1'b0;
        end else begin
            if (start_i && busy_o) begin
                overrun_q <= 1'b1;
            end
            if (start) begin
                cs_n_q  <= 1'b0;
                wait_q  <= half_wait;
                falls_q <= frame_bits_i;
                lead_q  <= lead_bits_i;
                data_q  <= data_bits_i;
            end else if (wait_q != 8'd0) begin
                wait_q <= wait_q - 8'd1;
            end else if (fall) begin
                sclk_q  <= 1'b0;
                wait_q  <= half_wait;
                falls_q <= falls_q - 6'd1;
                lead_q  <= lead ? lead_q - 6'd1 : 6'd0;
                data_q  <= data ? data_q - 5'd1 : data_q;
                valid_q <= data && (data_q == 5'd1);
            end else if (turn) begin
                sclk_q <= 1'b1;
                cs_n_q <= (falls_q == 6'd0);
                wait_q <= (falls_q == 6'd0) ? quiet_wait : half_wait;
            end
        end
    end

    // Where the next data bit goes: from the highest bit of the word down.
    reg [`WH_SAMPLE_W-1:0] place_q;

    always @(posedge clk) begin
        if (start) begin
            place_q <= {1'b1, {`WH_SAMPLE_W-1{1'b0}}};
        end else if (fall && data) begin
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
                if (fall && data) begin
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
    assign valid_o    = valid_q;
    assign overrun_o  = overrun_q;

endmodule

`default_nettype wire
