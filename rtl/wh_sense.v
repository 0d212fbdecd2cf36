// SPDX-License-Identifier: Apache-2.0
//
// wh_sense: the currents of N ports, from their ADC samples.
//
//   current = round((sum of samples_i samples - zero) * gain) - offset
//
// For each port it equals wh_current, wh_sense_check and wh_zero bit for bit, and judges samples as wh_guard does;
// their headers have equations and formats. The zeros of all ports are measured at once.
//
// The walk: the samples of all ports arrive together, with word_valid_i. From the next clock on they are processed,
// one a clock, three clocks each. After a period's last sample each port's sum is stored for its turn, as the next
// samples may come before that. summed_o comes one clock before the first port's sum is valid.
//
// The turn, in clocks since valid_i: 1, the product of the sum is requested; no other station may request then;
// 6, current_o and ends_o are valid, with valid_o. They hold until the next turn's.
//
// KINDS = 1: a turn has a kind. Alpha's has the current of phase a. That of phase b, without an offset, is a turn of
// beta's port, and appears at phase_o only. Beta's own turn processes no samples: it takes beta_i in clocks 4 and 5.
// phase_o is the current of a phase, and with a brushed motor current_o.
//
// The next word_valid_i may come N + 2 clocks after this one, the next valid_i 6 clocks. word_i holds for N clocks.
// State, by port, in LUT RAM (wh_port_state): the sum and its ends (27 bits), the same for its turn, the last sample
// and its number of repetitions (32), the zero being measured and the one in force, the offset (31).
// Settings: zero and gain (wh_port_settings). A sum uses the zero of the bank in force at its first sample.
// Latency: above. Reset: rst resets everything; sense_rst_i drops a sum that has begun.

`default_nettype none
`include "wh_formats.vh"

module wh_sense #(
    parameter integer N         = 1,   // ports and third phases, whose words come last, 1...12
    parameter integer KINDS     = 0,   // 1: kind_i counts
    parameter integer ZERO_LOG2 = 10,  // ticks of a zero, 2^ZERO_LOG2; 2...16
    parameter integer PORT_W    = (N > 1) ? $clog2(N) : 1  // derived, leave it
) (
    input  wire                          clk,
    input  wire                          rst,
    input  wire                          sense_rst_i,

    // Words.
    input  wire                          word_valid_i,   // strobe
    input  wire                          word_first_i,   // with it: first of a period
    input  wire [N*`WH_SAMPLE_W-1:0]     word_i,         // s16, +-2^15 is full scale
    input  wire [8:0]                    samples_i,      // words in a sum, 1...256
    output wire                          summed_o,       // strobe

    // Checks of the samples, a level for each port until its next sample.
    input  wire [15:0]                   range_i,        // full scale is 2^15: end of the ADC's range
    input  wire [15:0]                   stuck_words_i,  // identical samples that are a fault; 0, 1: off
    input  wire [15:0]                   guard_current_i, // these three as in wh_guard
    input  wire [15:0]                   guard_range_i,
    input  wire [15:0]                   guard_stuck_i,
    output reg  [N-1:0]                  range_o,
    output reg  [N-1:0]                  stuck_o,
    output reg  [N-1:0]                  guard_current_o,
    output reg  [N-1:0]                  guard_range_o,
    output reg  [N-1:0]                  guard_stuck_o,

    // The zero.
    input  wire                          zero_start_i,   // strobe
    input  wire                          bridge_off_i,
    input  wire [`WH_SUM_W-2:0]          zero_limit_i,   // largest |zero| that is accepted
    output reg                           zero_busy_o,
    output reg  [N-1:0]                  zero_fault_o,

    // A turn.
    input  wire                          valid_i,        // strobe
    input  wire [PORT_W-1:0]             port_i,
    input  wire                          bank_i,
    input  wire [1:0]                    kind_i,         // 0 a brushed motor's, 1 alpha's, 2 phase b's, 3 beta's
    input  wire signed [`WH_DATA_W-1:0]  beta_i,         // s31q24 A, beta's current
    input  wire [1:0]                    beta_ends_i,
    output reg                           valid_o,        // strobe
    output wire                          phase_valid_o,  // strobe
    output wire signed [`WH_DATA_W-1:0]  phase_o,        // s31q24 A, until the next
    output wire [1:0]                    phase_ends_o,
    output wire [PORT_W-1:0]             port_o,
    output wire                          bank_o,
    output reg  signed [`WH_DATA_W-1:0]  current_o,      // s31q24 A, +-64 A
    output reg  [1:0]                    ends_o,         // at the high end of its range (bit 0), at the low end

    // The offset that the port anchor subtracts (wh_anchor_ports).
    input  wire                          offset_valid_i, // strobe
    input  wire [PORT_W-1:0]             offset_port_i,
    input  wire signed [`WH_DATA_W-1:0]  offset_i,       // s31q24 A
    input  wire [N-1:0]                  offset_rst_i,   // it is 0 for these ports
    output wire signed [`WH_DATA_W-1:0]  offset_o,       // of the turn's port, until the next turn

    // The register bus (wh_port_settings), and the bank in force.
    input  wire                          force_i,
    input  wire                          write_i,
    input  wire                          write_bank_i,
    input  wire [11:0]                   address_i,
    input  wire [31:0]                   data_i,

    // The multiplier.
    output wire                          request_o,
    output wire signed [`WH_DATA_W-1:0]  factor_o,       // s31q0, sum - zero
    output wire signed [`WH_COEF_W-1:0]  coefficient_o,  // s27q35 A
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i  // 3 clocks after request_o
);

    localparam integer DATA_W       = `WH_DATA_W;
    localparam integer SAMPLE_W     = `WH_SAMPLE_W;
    localparam integer SUM_W        = `WH_SUM_W;
    localparam integer DIFFERENCE_W = SUM_W + 1;
    localparam integer PRODUCT_W    = DIFFERENCE_W + `WH_COEF_W;  // the bits of product_i in use
    localparam integer SHIFT        = `WH_GAIN_Q - `WH_CURRENT_Q;
    localparam integer ROUND_W      = PRODUCT_W - SHIFT + 1;
    localparam integer NEAR_W       = DATA_W + 1;
    localparam integer WIDE_W       = (ROUND_W > NEAR_W) ? ROUND_W : NEAR_W;
    localparam integer TOTAL_W      = SUM_W + ZERO_LOG2;
    localparam integer LAST         = N - 1;

    generate
        if (N < 1 || N > 12) begin : illegal
            wh_illegal_parameter_sense_n_must_be_1_to_12 stop ();
        end
        if (KINDS != 0 && KINDS != 1) begin : illegal_kinds
            wh_illegal_parameter_sense_kinds_must_be_0_or_1 stop ();
        end
        if (ZERO_LOG2 < 2 || ZERO_LOG2 > 16) begin : illegal_zero
            wh_illegal_parameter_sense_zero_log2_must_be_2_to_16 stop ();
        end
        if (DATA_W < DIFFERENCE_W) begin : illegal_format
            wh_illegal_WH_DATA_W_must_hold_a_tick_sum_WH_SUM_W_plus_1 stop ();
        end
    endgenerate

    // ---- The walk: ask_q reads a sample, look_q has it, and add_q adds it.
    reg              ask_q;
    reg [PORT_W-1:0] ask_port_q;
    reg              look_q;
    reg [PORT_W-1:0] look_port_q;
    reg              add_q;
    reg [PORT_W-1:0] add_port_q;
    reg              first_q;  // the sample in look_q is a period's first,
    reg              last_q;   // or its last
    reg [8:0]        count_q;  // words in a sum
    reg              zero_bank_q;

    wire [8:0] count = word_first_i ? 9'd1 : count_q + 9'd1;

    always @(posedge clk) begin
        if (rst || sense_rst_i) begin
            ask_q   <= 1'b0;
            look_q  <= 1'b0;
            add_q   <= 1'b0;
            count_q <= 9'd0;
            last_q  <= 1'b0;
        end else begin
            if (word_valid_i) begin
                ask_q   <= 1'b1;
                count_q <= count;
                last_q  <= (count == samples_i);
            end else if (ask_port_q == LAST[PORT_W-1:0]) begin
                ask_q   <= 1'b0;
            end
            look_q <= ask_q;
            add_q  <= look_q;
        end
        if (word_valid_i) begin
            ask_port_q <= {PORT_W{1'b0}};
            first_q    <= word_first_i;
        end else begin
            ask_port_q <= ask_port_q + 1'b1;
        end
        if (word_valid_i && word_first_i) begin
            zero_bank_q <= force_i;
        end
        look_port_q <= ask_port_q;
        add_port_q  <= look_port_q;
    end

    assign summed_o = add_q && last_q && add_port_q == {PORT_W{1'b0}};

    reg signed [SAMPLE_W-1:0] word_q;

    always @(posedge clk) begin
        if (ask_q) begin
            word_q <= $signed(word_i[ask_port_q*SAMPLE_W +: SAMPLE_W]);
        end
    end

    // ---- Checks, in the clock of look_q.
    wire [SAMPLE_W-1:0]        size = word_q[SAMPLE_W-1] ? -word_q : word_q;
    wire signed [SAMPLE_W-1:0] last_word;
    wire [15:0]                same_words;
    wire [15:0]                same = (word_q != last_word)      ? 16'd1
                                    : (same_words == 16'hffff) ? same_words : same_words + 16'd1;
    reg  [SAMPLE_W-1:0]        size_q;
    reg  [15:0]                same_q;

    wh_port_state #(
        .N           (N),
        .W           (SAMPLE_W + 16)
    ) words_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (look_port_q),
        .save_i      (look_q),
        .save_port_i (look_port_q),
        .value_i     ({word_q, same}),
        .value_o     ({last_word, same_words})
    );

    always @(posedge clk) begin
        if (look_q) begin
            size_q <= size;
            same_q <= same;
        end
        if (rst) begin
            range_o         <= {N{1'b0}};
            stuck_o         <= {N{1'b0}};
            guard_current_o <= {N{1'b0}};
            guard_range_o   <= {N{1'b0}};
            guard_stuck_o   <= {N{1'b0}};
        end else if (add_q) begin
            range_o[add_port_q]         <= (size_q >= range_i);
            stuck_o[add_port_q]         <= (stuck_words_i > 16'd1) && (same_q >= stuck_words_i);
            guard_current_o[add_port_q] <= (size_q > guard_current_i);
            guard_range_o[add_port_q]   <= (size_q > guard_range_i);
            guard_stuck_o[add_port_q]   <= (same_q >= guard_stuck_i);
        end
    end

    // ---- The zero: the setting plus the measured one, both signed, in one bit more.
    wire signed [SUM_W-1:0] zero_setting;
    wire signed [SUM_W-1:0] measured;
    wire signed [SUM_W-1:0] zero;
    reg  signed [SUM_W-1:0] zero_q;

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (0),
        .W            (SUM_W),
        .FIRST        (0),
        .BLOCK        (0)
    ) zero_settings (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (ask_q && first_q),
        .bank_i       (zero_bank_q),
        .port_i       (ask_port_q),
        .word_i       (1'b0),
        .word_o       (zero_setting)
    );

    wh_saturate #(
        .IN_W    (SUM_W + 1),
        .OUT_W   (SUM_W)
    ) saturate_zero (
        .value_i ({measured[SUM_W-1], measured} + {zero_setting[SUM_W-1], zero_setting}),
        .value_o (zero)
    );

    // ---- The sum begins at -zero, which is ~zero + 1, so the difference is valid with the last sample.
    reg  signed [SAMPLE_W-1:0]     sample_q;  // word_q, a clock later
    reg                            at_end_q;  // of the range
    wire signed [DIFFERENCE_W-1:0] sum;
    wire [1:0]                     sum_ends;
    wire signed [DIFFERENCE_W-1:0] base     = first_q ? $signed(~{zero_q[SUM_W-1], zero_q}) : sum;
    wire signed [DIFFERENCE_W-1:0] next_sum = base
                                              + $signed({{DIFFERENCE_W-SAMPLE_W{sample_q[SAMPLE_W-1]}}, sample_q})
                                              + $signed({{DIFFERENCE_W-1{1'b0}}, first_q});
    wire [1:0]                     next_ends = {at_end_q && sample_q[SAMPLE_W-1], at_end_q && !sample_q[SAMPLE_W-1]}
                                               | (first_q ? 2'b00 : sum_ends);

    always @(posedge clk) begin
        if (look_q) begin
            zero_q   <= zero;
            sample_q <= word_q;
            at_end_q <= (size >= range_i);
        end
    end

    wh_port_state #(
        .N           (N),
        .W           (DIFFERENCE_W + 2)
    ) sums_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (add_port_q),
        .save_i      (add_q),
        .save_port_i (add_port_q),
        .value_i     ({next_sum, next_ends}),
        .value_o     ({sum, sum_ends})
    );

    // ---- Measurement of the zeros of all ports: it begins with a period's first sample, and ends with the first
    // one of the period after its last, which isn't added.
    reg                  running_q;  // its first period has begun
    reg                  begins_q;   // with the sample in look_q it begins,
    reg                  ends_q;     // or ends,
    reg                  adds_q;     // or adds the sample
    reg  [ZERO_LOG2-1:0] ticks_q;    // whole periods so far
    wire                 ends = word_first_i && running_q && (&ticks_q);

    wire signed [TOTAL_W-1:0] total;
    wire signed [TOTAL_W-1:0] half       = {{TOTAL_W-ZERO_LOG2+1{1'b0}}, {ZERO_LOG2-1{1'b1}}};
    wire                      up         = ends_q && !total[TOTAL_W-1];
    wire signed [TOTAL_W-1:0] next_total = (begins_q ? {TOTAL_W{1'b0}} : total)
                                           + (ends_q ? half
                                              : $signed({{TOTAL_W-SAMPLE_W{word_q[SAMPLE_W-1]}}, word_q}))
                                           + $signed({{TOTAL_W-1{1'b0}}, up});
    reg  signed [SUM_W-1:0]   mean_q;
    wire signed [SUM_W-1:0]   limit = $signed({1'b0, zero_limit_i});
    wire                      good  = (mean_q <= limit) && (mean_q >= -limit);
    wire                      judges = add_q && ends_q && zero_busy_o && bridge_off_i && !zero_start_i;

    wh_port_state #(
        .N           (N),
        .W           (TOTAL_W)
    ) totals_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (look_port_q),
        .save_i      (look_q && adds_q),
        .save_port_i (look_port_q),
        .value_i     (next_total),
        .value_o     (total)
    );

    wh_port_state #(
        .N           (N),
        .W           (SUM_W)
    ) measured_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (look_port_q),
        .save_i      (judges && good),
        .save_port_i (add_port_q),
        .value_i     (mean_q),
        .value_o     (measured)
    );

    always @(posedge clk) begin
        if (look_q) begin
            mean_q <= $signed(next_total[TOTAL_W-1:ZERO_LOG2]);
        end
        if (word_valid_i) begin
            begins_q <= word_first_i && !running_q;
            adds_q   <= zero_busy_o && (running_q || word_first_i);
        end
        if (rst) begin
            zero_busy_o  <= 1'b0;
            running_q    <= 1'b0;
            ends_q       <= 1'b0;
            ticks_q      <= {ZERO_LOG2{1'b0}};
            zero_fault_o <= {N{1'b0}};
        end else if (zero_start_i) begin
            zero_busy_o  <= 1'b1;
            running_q    <= 1'b0;
            ends_q       <= 1'b0;
            zero_fault_o <= {N{1'b0}};
        end else if (zero_busy_o && !bridge_off_i) begin
            zero_busy_o  <= 1'b0;
            ends_q       <= 1'b0;
            zero_fault_o <= {N{1'b1}};
        end else begin
            if (judges) begin
                zero_fault_o[add_port_q] <= !good;
                if (add_port_q == LAST[PORT_W-1:0]) begin
                    zero_busy_o <= 1'b0;
                    ends_q      <= 1'b0;
                end
            end
            if (word_valid_i && zero_busy_o) begin
                ends_q    <= ends;
                running_q <= running_q || word_first_i;
                if (word_first_i) begin
                    ticks_q <= running_q ? ticks_q + {{ZERO_LOG2-1{1'b0}}, 1'b1} : {ZERO_LOG2{1'b0}};
                end
            end
        end
    end

    // ---- The turn.
    reg [PORT_W-1:0] port_q;
    reg              bank_q;
    reg [5:1]        at_q;   // at_q[n]: this is clock n of it
    reg [1:0]        kind_q;

    localparam [1:0] BRUSHED = 2'd0, PHASE_B = 2'd2, BETA = 2'd3;
    wire [1:0] kind = (KINDS != 0) ? kind_q : BRUSHED;

    wire signed [DIFFERENCE_W-1:0] done_sum;
    wire [1:0]                     done_ends;
    wire signed [DATA_W-1:0]       offset;

    assign port_o = port_q;
    assign bank_o = bank_q;
    assign offset_o = offset;

    always @(posedge clk) begin
        if (valid_i) begin
            port_q <= port_i;
            bank_q <= bank_i;
            kind_q <= kind_i;
        end
        if (rst || sense_rst_i) begin
            at_q    <= 5'd0;
            valid_o <= 1'b0;
        end else begin
            at_q    <= {at_q[4:1], valid_i};
            valid_o <= at_q[5] && kind != PHASE_B;
        end
    end

    wh_port_state #(
        .N           (N),
        .W           (DIFFERENCE_W + 2)
    ) done_state (
        .clk         (clk),
        .rst         (rst),
        .port_i      (port_q),
        .save_i      (add_q && last_q),
        .save_port_i (add_port_q),
        .value_i     ({next_sum, next_ends}),
        .value_o     ({done_sum, done_ends})
    );

    wh_port_state #(
        .N           (N),
        .RESETS      (N),
        .W           (DATA_W)
    ) offset_state (
        .clk         (clk),
        .rst         ({N{rst}} | offset_rst_i),
        .port_i      (port_q),
        .save_i      (offset_valid_i),
        .save_port_i (offset_port_i),
        .value_i     (offset_i),
        .value_o     (offset)
    );

    wh_port_settings #(
        .N            (N),
        .WORDS_LOG2   (0),
        .W            (`WH_COEF_W),
        .FIRST        (1),
        .BLOCK        (0)
    ) gain_settings (
        .clk          (clk),
        .write_i      (write_i),
        .write_bank_i (write_bank_i),
        .address_i    (address_i),
        .data_i       (data_i),
        .read_i       (valid_i),
        .bank_i       (bank_i),
        .port_i       (port_i),
        .word_i       (1'b0),
        .word_o       (coefficient_o)
    );

    assign request_o = at_q[1] && kind != BETA;
    assign factor_o  = {{DATA_W-DIFFERENCE_W{done_sum[DIFFERENCE_W-1]}}, done_sum};

    // 25 x 27 bits: the bits above the product repeat its sign.
    wire unused = &{1'b0, product_i[DATA_W+`WH_COEF_W-1:PRODUCT_W]};

    // Rounded in one clock; offset subtracted and saturated in the next. What doesn't fit NEAR_W bits saturates with
    // any offset, so the subtraction needs no more bits.
    wire signed [ROUND_W-1:0] rounded;
    reg  signed [ROUND_W-1:0] rounded_q;
    wire signed [DATA_W-1:0]  saturated;
    wire signed [ROUND_W-1:0] word;        // rounded_q; of a phase, limited to its range
    wire [1:0]                found_ends;  // of this turn, besides those of its samples
    wire signed [WIDE_W-1:0]  wide = {{(WIDE_W - ROUND_W + 1){word[ROUND_W-1]}}, word[ROUND_W-2:0]};
    wire                      back = wide[WIDE_W-1];
    wire                      far  = (wide[WIDE_W-1:NEAR_W-1] != {(WIDE_W - NEAR_W + 1){back}});
    wire signed [NEAR_W:0]    near = $signed({wide[NEAR_W-1], wide[NEAR_W-1:0]})
                                     - $signed({{2{offset[DATA_W-1]}}, offset});
    wire signed [NEAR_W:0]    less = $signed({far ? {back, !back} : near[NEAR_W:NEAR_W-1], near[NEAR_W-2:0]});
    wire                      high = !less[NEAR_W] && (|less[NEAR_W-1:DATA_W-1]);
    wire                      low  = less[NEAR_W] && !(&less[NEAR_W-1:DATA_W-1]);

    wh_round #(
        .IN_W    (PRODUCT_W),
        .SHIFT   (SHIFT)
    ) round (
        .value_i ($signed(product_i[PRODUCT_W-1:0])),
        .value_o (rounded)
    );

    wh_saturate #(
        .IN_W    (NEAR_W + 1),
        .OUT_W   (DATA_W)
    ) saturate (
        .value_i (less),
        .value_o (saturated)
    );

    always @(posedge clk) begin
        if (at_q[4]) begin
            rounded_q <= (kind == BETA) ? $signed({{(ROUND_W - DATA_W){beta_i[DATA_W-1]}}, beta_i}) : rounded;
        end
        if (rst || sense_rst_i) begin
            current_o <= {DATA_W{1'b0}};
            ends_o    <= 2'b00;
        end else if (at_q[5] && kind != PHASE_B) begin
            current_o <= saturated;
            ends_o    <= (kind == BETA) ? beta_ends_i : done_ends | found_ends;
        end
    end

    // ---- Phases: the offset is subtracted after the transform; a current beyond its range stays there.
    generate
        if (KINDS != 0) begin : phases
            wire signed [DATA_W-1:0] phase;
            reg                      valid_q;
            reg  signed [DATA_W-1:0] phase_q;
            reg  [1:0]               phase_ends_q;
            wire                     beyond = (rounded_q[ROUND_W-1:DATA_W-1]
                                               != {(ROUND_W - DATA_W + 1){rounded_q[ROUND_W-1]}});

            wh_saturate #(
                .IN_W    (ROUND_W),
                .OUT_W   (DATA_W)
            ) saturate_phase (
                .value_i (rounded_q),
                .value_o (phase)
            );

            assign word       = (kind == BRUSHED) ? rounded_q
                                                  : $signed({{(ROUND_W - DATA_W){phase[DATA_W-1]}}, phase});
            assign found_ends = (kind == BRUSHED) ? {low, high}
                                                  : {2{beyond}} & {rounded_q[ROUND_W-1], !rounded_q[ROUND_W-1]};

            always @(posedge clk) begin
                if (rst || sense_rst_i) begin
                    valid_q      <= 1'b0;
                    phase_q      <= {DATA_W{1'b0}};
                    phase_ends_q <= 2'b00;
                end else begin
                    valid_q      <= at_q[5] && kind != BETA;
                    if (at_q[5] && kind != BETA) begin
                        phase_q      <= (kind == BRUSHED) ? saturated : phase;
                        phase_ends_q <= done_ends | found_ends;
                    end
                end
            end

            assign phase_valid_o = valid_q;
            assign phase_o       = phase_q;
            assign phase_ends_o  = phase_ends_q;
        end else begin : brushed
            wire unused_axes = &{1'b0, kind_q, beta_i, beta_ends_i};

            assign word          = rounded_q;
            assign found_ends    = {low, high};
            assign phase_valid_o = valid_o;
            assign phase_o       = current_o;
            assign phase_ends_o  = ends_o;
        end
    endgenerate

endmodule

`default_nettype wire
