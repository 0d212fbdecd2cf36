// SPDX-License-Identifier: Apache-2.0
//
// wh_adc_max11125: reads channels of a MAX11125 or MAX11123, which takes commands and answers late.
//
//   frame   CS_n low, 16 pulses of SCLK (idle high); DIN changes with SCLK's falls and is taken at
//           its rises, and the part's output the other way round
//   DIN     reset 0x0040, then 0x0800 | channel << 7: convert that channel by hand, without its
//           number in the answer
//   DOUT    0, data, zeros: of what the frame before has asked for
//
// After reset two frames go out by themselves, the reset and the first channel; ready_o rises after
// them. Each start_i makes LINES frames, which ask for the lines' channels in turn, line n's
// CS_n falls n frames after line 0's. The last line's code comes with the next start's first frame:
// then valid_o tells that the words of all lines are there. first_o is first_i of the start whose
// words they are; the first start after reset brings none.
//
// The frame is wh_adc_serial's, with sclk_idle_i = 1, read_trailing_i = 1 and a lead of 1.
// Formats: as wh_adc_serial. Latency: as wh_adc_serial from the next start's strobe.
// Reset: CS_n and SCLK high at once; the part is set up anew.

`default_nettype none
`include "wh_formats.vh"

module wh_adc_max11125 #(
    parameter integer LINES         = 1,  // channels, 1...8
    parameter integer FIRST_CHANNEL = 0   // that of line 0, 0...15; the next lines' follow
) (
    input  wire                         clk,
    input  wire                         rst,

    output wire                         adc_cs_n_o,
    output wire                         adc_sclk_o,
    output wire                         adc_din_o,
    input  wire                         adc_sdata_i,

    input  wire [7:0]                   sclk_half_clocks_i,  // as wh_adc_serial
    input  wire [5:0]                   frame_bits_i,
    input  wire [5:0]                   lead_bits_i,
    input  wire [4:0]                   data_bits_i,
    input  wire [7:0]                   quiet_clocks_i,
    input  wire [7:0]                   setup_clocks_i,
    input  wire [7:0]                   hold_clocks_i,
    input  wire                         sclk_idle_i,
    input  wire                         read_trailing_i,

    input  wire                         start_i,             // strobe; ignored while busy_o
    input  wire                         first_i,             // with start_i: comes back as first_o
    output wire                         ready_o,             // the part has been set up
    output wire                         busy_o,
    output wire                         valid_o,             // strobe
    output wire                         first_o,             // with valid_o
    output wire [LINES*`WH_SAMPLE_W-1:0] sample_o,           // s16 each, line 0 lowest

    output wire                         overrun_o            // start_i came too early; until rst
);

    generate
        if (LINES < 1 || LINES > 8) begin : illegal_lines
            wh_illegal_parameter_adc_max11125_lines_must_be_1_to_8 stop ();
        end
        if (FIRST_CHANNEL < 0 || FIRST_CHANNEL + LINES > 16) begin : illegal_channel
            wh_illegal_parameter_adc_max11125_channels_must_be_0_to_15 stop ();
        end
    endgenerate

    localparam [15:0] RESET_WORD  = 16'h0040;
    localparam [15:0] MANUAL_WORD = 16'h0800;
    localparam integer LAST       = LINES - 1;
    localparam [2:0]  LAST_LINE   = LAST[2:0];

    // ---- Which frame is next.

    reg [1:0] set_up_q;   // 0, 1: frames of the set-up that are out, 2: both, 3: ready
    reg [2:0] line_q;     // line that the next frame asks for
    reg       started_q;  // there has been a start
    reg       before_q;   // there has been one before it, whose last code is still to come
    reg       first_q;    // first_i of the start that is being served, and of the one before
    reg       first_out_q;
    reg       overrun_q;

    wire engine_busy;
    wire engine_valid;

    wire ready   = (set_up_q == 2'd3);
    wire in_turn = (line_q != 3'd0);
    wire start   = start_i && ready && !in_turn && !engine_busy;
    wire frame   = !engine_busy && (!set_up_q[1] || in_turn || start);

    // The first frame of a start is under way: the next line is the second, or the first again.
    wire first_frame = (LINES == 1) || (line_q == 3'd1);

    assign ready_o = ready;
    assign busy_o  = engine_busy || in_turn || !ready;

    always @(posedge clk) begin
        if (rst) begin
            set_up_q    <= 2'd0;
            line_q      <= 3'd0;
            started_q   <= 1'b0;
            before_q    <= 1'b0;
            first_q     <= 1'b0;
            first_out_q <= 1'b0;
            overrun_q   <= 1'b0;
        end else begin
            if (start_i && ready && !start) begin
                overrun_q <= 1'b1;
            end
            if (!ready && !engine_busy) begin
                set_up_q <= set_up_q + 2'd1;
            end
            if (start || in_turn && frame) begin
                line_q <= (line_q == LAST_LINE) ? 3'd0 : line_q + 3'd1;
            end
            if (start) begin
                started_q   <= 1'b1;
                before_q    <= started_q;
                first_q     <= first_i;
                first_out_q <= first_q;
            end
        end
    end

    // ---- Commands: a bit is on the wire from one fall of SCLK to the next.

    reg [15:0] command_q;
    reg        fresh_q;    // no fall yet
    wire       lead_edge;

    wire [3:0] channel = FIRST_CHANNEL[3:0] + {1'b0, line_q};

    always @(posedge clk) begin
        if (frame) begin
            command_q <= (set_up_q == 2'd0) ? RESET_WORD : MANUAL_WORD | {5'd0, channel, 7'd0};
            fresh_q   <= 1'b1;
        end else if (lead_edge) begin
            command_q <= fresh_q ? command_q : {command_q[14:0], 1'b0};
            fresh_q   <= 1'b0;
        end
    end

    assign adc_din_o = command_q[15];

    // ---- Words.

    wire [`WH_SAMPLE_W-1:0] word;
    wire                    engine_ready;
    wire                    engine_first;
    wire                    engine_overrun;
    wire                    unused = &{1'b0, engine_ready, engine_first, engine_overrun};

    wh_adc_serial #(
        .LINES              (1)
    ) serial (
        .clk                (clk),
        .rst                (rst),
        .adc_cs_n_o         (adc_cs_n_o),
        .adc_sclk_o         (adc_sclk_o),
        .adc_sdata_i        (adc_sdata_i),
        .sclk_half_clocks_i (sclk_half_clocks_i),
        .frame_bits_i       (frame_bits_i),
        .lead_bits_i        (lead_bits_i),
        .data_bits_i        (data_bits_i),
        .quiet_clocks_i     (quiet_clocks_i),
        .setup_clocks_i     (setup_clocks_i),
        .hold_clocks_i      (hold_clocks_i),
        .calibrate_bits_i   (6'd0),
        .sclk_idle_i        (sclk_idle_i),
        .read_trailing_i    (read_trailing_i),
        .start_i            (frame),
        .first_i            (1'b0),
        .ready_o            (engine_ready),
        .busy_o             (engine_busy),
        .lead_edge_o        (lead_edge),
        .valid_o            (engine_valid),
        .first_o            (engine_first),
        .sample_o           (word),
        .overrun_o          (engine_overrun)
    );

    assign sample_o[(LINES-1)*`WH_SAMPLE_W +: `WH_SAMPLE_W] = word;

    genvar n;
    generate
        for (n = 0; n < LINES - 1; n = n + 1) begin : line
            // Line n's code comes with the frame that asks for line n + 1.
            localparam integer NEXT = (n + 2 == LINES) ? 0 : n + 2;
            reg [`WH_SAMPLE_W-1:0] word_q;
            always @(posedge clk) begin
                if (engine_valid && ready && line_q == NEXT[2:0]) begin
                    word_q <= word;
                end
            end
            assign sample_o[n*`WH_SAMPLE_W +: `WH_SAMPLE_W] = word_q;
        end
    endgenerate

    assign valid_o   = engine_valid && ready && before_q && first_frame;
    assign first_o   = first_out_q;
    assign overrun_o = overrun_q;

endmodule

`default_nettype wire
