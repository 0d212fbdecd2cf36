// SPDX-License-Identifier: Apache-2.0
//
// wh_sinc3: the words of sigma-delta modulators' bit streams, by a sinc filter of the third order.
//
//   y = (1 + z^-1 + ... + z^-(OSR-1))^3 x,  x = +1 for a one and -1 for a zero: -OSR^3 ... OSR^3
//   sample = round(y * 2^(15 - LOG2)), LOG2 = ceil(log2(OSR^3)), saturated
//
// The block makes the modulators' clock, of sclk_half_clocks_i a half, without a pause from reset on,
// and takes a bit of each with every period: in the clock edge that makes the clock rise
// (CAPTURE_RISE = 1) or fall (0), so before the modulator answers to that edge. One flip-flop for each
// line takes it, and the sums in the clock after, which is before the next bit.
// start_i asks for a word of the bits taken so far. Starts must be OSR bits apart (overrun_o tells
// where they are not): then no bit is lost, and as the filter spans three such intervals, centred
// one and a half before the start, a word belongs to the start before the last. first_o is first_i
// of that start. The first two starts after reset bring no word, the third one 0, and from the
// fourth on there are three intervals of bits to make a word of: the filter settles in 3 OSR bits.
// ready_o rises when the fast path has settled.
//
// The fast path is a sinc filter of the second order over 2 TRIP_OSR bits, TRIP_OSR a power of two:
//   trip_o, for the bits taken since trip_o could last change: |sum| 2^15 / TRIP_OSR^2 >= trip_i
//
// No word overflows: widths hold OSR^3, and only an endless stream of ones with OSR a power of two
// reaches the saturation.
// Formats: sample s16; 2^15 times OSR^3 / 2^LOG2 stands for ones only. Latency: 4 clocks from
// start_i to valid_o; trip_o TRIP_OSR bits after the last but one bit, and 3 clocks.
// Reset: clock low, sums 0, no trip.

`default_nettype none
`include "wh_formats.vh"

module wh_sinc3 #(
    parameter integer LINES        = 1,   // modulators, 1...
    parameter integer OSR          = 32,  // bits a word, 4...256
    parameter integer CAPTURE_RISE = 0,   // 1: bits are taken as the clock rises, 0: as it falls
    parameter integer TRIP_OSR     = 8    // half the bits of the fast path, 2, 4, 8, 16, 32
) (
    input  wire                         clk,
    input  wire                         rst,

    output wire                         adc_sclk_o,          // the modulators' clock
    input  wire [LINES-1:0]             adc_sdata_i,

    input  wire [7:0]                   sclk_half_clocks_i,  // half a period of it, clocks, 1...
    input  wire [15:0]                  trip_i,              // of 2^15, ones only

    input  wire                         start_i,             // strobe, every OSR bits
    input  wire                         first_i,             // with start_i: comes back as first_o
    output wire                         ready_o,             // the filter has settled
    output wire                         valid_o,             // strobe
    output wire                         first_o,             // with valid_o
    output wire [LINES*`WH_SAMPLE_W-1:0] sample_o,           // s16 each, line 0 lowest

    output wire [LINES-1:0]             trip_o,              // by the fast path
    output wire                         overrun_o            // a start too early or late; until rst
);

    localparam integer CUBE   = OSR * OSR * OSR;
    localparam integer LOG2   = $clog2(CUBE);
    localparam integer W      = LOG2 + 2;  // -OSR^3 ... OSR^3
    localparam integer TRIP_LOG2 = $clog2(TRIP_OSR);
    localparam integer TRIP_W = 2 * TRIP_LOG2 + 2;
    localparam integer SETTLE = 2 * TRIP_OSR + 2;
    localparam integer TRIP_LAST = TRIP_OSR - 1;

    generate
        if (OSR < 4 || OSR > 256) begin : illegal_osr
            wh_illegal_parameter_sinc3_osr_must_be_4_to_256 stop ();
        end
        if (TRIP_OSR != 2 && TRIP_OSR != 4 && TRIP_OSR != 8 && TRIP_OSR != 16
            && TRIP_OSR != 32) begin : illegal_trip_osr
            wh_illegal_parameter_sinc3_trip_osr_must_be_2_4_8_16_or_32 stop ();
        end
        if (CAPTURE_RISE != 0 && CAPTURE_RISE != 1) begin : illegal_capture_rise
            wh_illegal_parameter_sinc3_capture_rise_must_be_0_or_1 stop ();
        end
        if (LINES < 1) begin : illegal_lines
            wh_illegal_parameter_sinc3_lines_must_be_1_or_more stop ();
        end
    endgenerate

    // ---- The modulators' clock, and which of its clocks takes a bit.

    reg       sclk_q;
    reg [7:0] wait_q;

    reg       taken_q;    // the clock after capture: the bits are in their flip-flops

    wire turn    = (wait_q == 8'd0);
    wire capture = turn && ((CAPTURE_RISE != 0) ? !sclk_q : sclk_q);

    always @(posedge clk) begin
        if (rst) begin
            sclk_q  <= 1'b0;
            taken_q <= 1'b0;
            wait_q  <= sclk_half_clocks_i - 8'd1;
        end else begin
            sclk_q  <= sclk_q ^ turn;
            taken_q <= capture;
            wait_q  <= turn ? sclk_half_clocks_i - 8'd1 : wait_q - 8'd1;
        end
    end

    assign adc_sclk_o = sclk_q;

    // ---- Starts: how far apart, and what belongs to which.

    reg [6:0] settle_q;    // bits until the fast path has settled
    reg [8:0] bits_q;      // bits since the last start
    reg [1:0] starts_q;    // starts so far, up to 3
    reg [1:0] first_q;     // first_i of the last start and of the one before
    reg       overrun_q;

    wire ready = (settle_q == 7'd0);
    wire start = start_i && ready;

    always @(posedge clk) begin
        if (rst) begin
            settle_q  <= SETTLE[6:0];
            bits_q    <= 9'd0;
            starts_q  <= 2'd0;
            first_q   <= 2'd0;
            overrun_q <= 1'b0;
        end else begin
            if (capture && !ready) begin
                settle_q <= settle_q - 7'd1;
            end
            if (start) begin
                bits_q   <= {8'd0, capture};
                starts_q <= (starts_q == 2'd3) ? 2'd3 : starts_q + 2'd1;
                first_q  <= {first_q[0], first_i};
                if (starts_q != 2'd0 && bits_q != OSR[8:0]) begin
                    overrun_q <= 1'b1;
                end
            end else if (capture && bits_q != 9'h1ff) begin
                bits_q <= bits_q + 9'd1;
            end
        end
    end

    // The differences of a start follow each other, a clock each.
    reg [3:0] stage_q;
    reg [2:0] answer_q;    // {is settled, is one, its first_i}

    always @(posedge clk) begin
        if (rst) begin
            stage_q  <= 4'd0;
            answer_q <= 3'd0;
        end else begin
            stage_q <= {stage_q[2:0], start};
            if (start) begin
                answer_q <= {starts_q == 2'd3, starts_q[1], first_q[1]};
            end
        end
    end

    assign ready_o   = ready;
    assign valid_o   = stage_q[3] && answer_q[1];
    assign first_o   = answer_q[0];
    assign overrun_o = overrun_q;

    // ---- The fast path's pace.

    reg [4:0] trip_bits_q;
    reg [1:0] trip_stage_q;

    wire trip_start = capture && (trip_bits_q == TRIP_LAST[4:0]);

    always @(posedge clk) begin
        if (rst) begin
            trip_bits_q  <= 5'd0;
            trip_stage_q <= 2'd0;
        end else begin
            trip_stage_q <= {trip_stage_q[0], trip_start};
            if (capture) begin
                trip_bits_q <= trip_start ? 5'd0 : trip_bits_q + 5'd1;
            end
        end
    end

    // ---- Sums and differences of each line. They wrap, and the last difference is right again. Two
    // captures are two clocks apart or more: the first sum has its bit by the next one, which is when
    // the second wants it.

    genvar n;
    generate
        for (n = 0; n < LINES; n = n + 1) begin : line
            reg signed [W-1:0] sum1_q, sum2_q, sum3_q;
            reg signed [W-1:0] kept1_q, kept2_q, kept3_q;
            reg signed [W-1:0] diff1_q, diff2_q, diff3_q;
            reg                bit_q;

            always @(posedge clk) begin
                bit_q <= adc_sdata_i[n];
            end

            wire signed [W-1:0] one = bit_q ? {{W-1{1'b0}}, 1'b1} : {W{1'b1}};

            always @(posedge clk) begin
                if (rst) begin
                    sum1_q <= {W{1'b0}};
                    sum2_q <= {W{1'b0}};
                    sum3_q <= {W{1'b0}};
                end else begin
                    if (taken_q) begin
                        sum1_q <= sum1_q + one;
                    end
                    if (capture) begin
                        sum2_q <= sum2_q + sum1_q;
                        sum3_q <= sum3_q + sum2_q;
                    end
                end
            end

            always @(posedge clk) begin
                if (rst) begin
                    kept1_q <= {W{1'b0}};
                    kept2_q <= {W{1'b0}};
                    kept3_q <= {W{1'b0}};
                    diff1_q <= {W{1'b0}};
                    diff2_q <= {W{1'b0}};
                    diff3_q <= {W{1'b0}};
                end else begin
                    if (start) begin
                        kept1_q <= sum3_q;
                        diff1_q <= sum3_q - kept1_q;
                    end
                    if (stage_q[0]) begin
                        kept2_q <= diff1_q;
                        diff2_q <= diff1_q - kept2_q;
                    end
                    if (stage_q[1]) begin
                        kept3_q <= diff2_q;
                        diff3_q <= diff2_q - kept3_q;
                    end
                end
            end

            reg signed [`WH_SAMPLE_W-1:0] sample_q;

            if (LOG2 > `WH_SAMPLE_W) begin : narrower
                localparam integer DROP = LOG2 - `WH_SAMPLE_W + 1;
                wire signed [W-DROP:0]         rounded;
                wire signed [`WH_SAMPLE_W-1:0] word;

                wh_round #(
                    .IN_W    (W),
                    .SHIFT   (DROP)
                ) round (
                    .value_i (diff3_q),
                    .value_o (rounded)
                );

                wh_saturate #(
                    .IN_W    (W - DROP + 1),
                    .OUT_W   (`WH_SAMPLE_W)
                ) saturate (
                    .value_i (rounded),
                    .value_o (word)
                );

                always @(posedge clk) begin
                    if (stage_q[2]) begin
                        sample_q <= answer_q[2] ? word : {`WH_SAMPLE_W{1'b0}};
                    end
                end
            end else begin : wider
                // One bit at most doesn't fit: that of OSR^3 itself, or one below the last place.
                localparam integer ADD = `WH_SAMPLE_W - 1 - LOG2;
                wire signed [`WH_SAMPLE_W+1:0] wide;
                wire signed [`WH_SAMPLE_W-1:0] word;

                if (ADD >= 0) begin : shift_left
                    assign wide = {{`WH_SAMPLE_W+2-W-ADD{diff3_q[W-1]}}, diff3_q, {ADD{1'b0}}};
                end else begin : shift_right
                    assign wide = diff3_q >>> 1;
                end

                wh_saturate #(
                    .IN_W    (`WH_SAMPLE_W + 2),
                    .OUT_W   (`WH_SAMPLE_W)
                ) saturate (
                    .value_i (wide),
                    .value_o (word)
                );

                always @(posedge clk) begin
                    if (stage_q[2]) begin
                        sample_q <= answer_q[2] ? word : {`WH_SAMPLE_W{1'b0}};
                    end
                end
            end

            assign sample_o[n*`WH_SAMPLE_W +: `WH_SAMPLE_W] = sample_q;

            // ---- Fast path.

            reg signed [TRIP_W-1:0] fast1_q, fast2_q, before1_q, before2_q, step1_q, step2_q;
            reg                     trip_q;

            wire signed [TRIP_W-1:0] bit_in =
                bit_q ? {{TRIP_W-1{1'b0}}, 1'b1} : {TRIP_W{1'b1}};
            wire [TRIP_W-1:0]        magnitude = step2_q[TRIP_W-1] ? -step2_q : step2_q;
            wire [16:0]              level =
                {{17-TRIP_W{1'b0}}, magnitude} << (`WH_SAMPLE_W - 1 - 2 * TRIP_LOG2);

            always @(posedge clk) begin
                if (rst) begin
                    fast1_q   <= {TRIP_W{1'b0}};
                    fast2_q   <= {TRIP_W{1'b0}};
                    before1_q <= {TRIP_W{1'b0}};
                    before2_q <= {TRIP_W{1'b0}};
                    step1_q   <= {TRIP_W{1'b0}};
                    step2_q   <= {TRIP_W{1'b0}};
                    trip_q    <= 1'b0;
                end else begin
                    if (taken_q) begin
                        fast1_q <= fast1_q + bit_in;
                    end
                    if (capture) begin
                        fast2_q <= fast2_q + fast1_q;
                    end
                    if (trip_start) begin
                        before1_q <= fast2_q;
                        step1_q   <= fast2_q - before1_q;
                    end
                    if (trip_stage_q[0]) begin
                        before2_q <= step1_q;
                        step2_q   <= step1_q - before2_q;
                    end
                    if (trip_stage_q[1]) begin
                        trip_q <= ready && (level >= {1'b0, trip_i});
                    end
                end
            end

            assign trip_o[n] = trip_q;
        end
    endgenerate

endmodule

`default_nettype wire
