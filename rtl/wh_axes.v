// SPDX-License-Identifier: Apache-2.0
//
// wh_axes: the two ports of a brushless motor, alpha and beta: a wave core, and a port anchor for each.
//
//   current - offset -> wh_wave_core -> e_id + correction -> voltage       of each axis
//   waves, flux by the encoder (wh_rotor_flux) -> wh_anchor -> correction, offset, room
//   jumps of the anchors' χ -> wh_magnet_angle -> the angle that is wrong, before the anchors have a say
//
// Both ports have the same words, the same eta and the same W, with states of W each.
// sim/wavehaptics/ladder/brushless.py puts the integer models together in the same way.
// ANCHOR = 0: no anchors; the position and the flux mean nothing.
//
// Formats: those of the blocks.
// Latency: the wave core's, 48 clocks and 10 for each section of W; the anchors go on behind it,
// anchor_busy_o. A step that starts before they are done is an overrun, as what they find acts in it.
// Reset: the blocks'; with angle_rst_i, at power-up, the magnets are to be found anew.

`default_nettype none
`include "wh_formats.vh"

module wh_axes #(
    parameter integer DELAY_LOG2 = 2,  // the delay line keeps 2^DELAY_LOG2 steps, 1...
    parameter integer SHAPER     = 0,  // sections of W (wh_shaper), 0...2; 0: W = 1
    parameter integer ANCHOR     = 0,  // 1: there are port anchors
    parameter integer SHAPE_BITS = ((SHAPER > 0) ? SHAPER : 1)  // derived, leave it
                                   * (9 * `WH_SHAPE_W + 3 * `WH_SHAPE_LOSS_W)
) (
    input  wire                              clk,
    input  wire                              rst,

    input  wire                              damp_i,          // eta is 0, and the anchors in reset
    input  wire                              start_i,         // strobe
    output wire                              busy_o,          // the wave core
    output wire                              reads_o,         // it reads settings
    output wire                              anchor_busy_o,   // an anchor
    output wire                              anchor_reads_o,  // one reads settings
    output wire                              valid_o,         // strobe, the core's
    output wire                              overrun_o,

    // Of two words, alpha's lowest.
    input  wire [2*`WH_DATA_W-1:0]           current_i,       // s31q24 A
    input  wire [3:0]                        ends_i,          // at the high, low end of its range, each axis
    input  wire [`WH_COEF_W-1:0]             eta_i,           // s27q25
    input  wire [`WH_COEF_W-1:0]             root_i,          // s27q22 √Ω
    input  wire [`WH_COEF_W-1:0]             a_i,             // s27q25
    input  wire [`WH_DATA_W-1:0]             u_max_i,         // s31q23 √W
    input  wire [DELAY_LOG2-1:0]             extra_ticks_i,
    input  wire [DELAY_LOG2-1:0]             hold_ticks_i,

    // W of both axes (wh_shaper): its words, and whether the wall in contact feels so.
    input  wire [SHAPE_BITS-1:0]             shape_words_i,
    input  wire                              shaped_i,        // for all of the core's step

    // The rotor (wh_rotor_flux), as it is in the clock of start_i.
    input  wire signed [`WH_COUNT_W-1:0]     position_i,      // s32, counts
    input  wire [2*(`WH_PLACE_W+`WH_SINE_Q)-1:0] place_i,     // s30q15 cells
    input  wire [2*(`WH_SINE_Q+2)-1:0]       cell_i,          // s17q15 cells
    input  wire                              contact_i,       // for all of the core's step
    input  wire [`WH_ANCHOR_W-1:0]           anchor_words_i,

    // The magnets' angle (wh_magnet_angle), which a stop doesn't forget.
    input  wire                              angle_rst_i,
    input  wire                              find_magnet_i,
    input  wire [31:0]                       count_angle_i,
    output wire                              turn_o,
    output wire [31:0]                       by_o,
    input  wire                              turned_i,
    output wire                              magnet_found_o,

    output wire [2*`WH_DATA_W-1:0]           voltage_o,       // s31q23 V: e to be applied
    output reg  [2*`WH_DATA_W-1:0]           current_o,       // s31q24 A: i_n, without the offset
    output wire [2*`WH_DATA_W-1:0]           u_o,             // s31q23 √W: u_n
    output wire [2*`WH_DATA_W-1:0]           v_o,             // s31q23 √W: v_n
    output wire [1:0]                        saturated_o,
    output wire [1:0]                        clipped_o,       // i_n or v_n is at the end of its range
    output wire [2*`WH_DATA_W-1:0]           correction_o,    // s31q23 V: c, in this step's voltage
    output wire [2*`WH_DATA_W-1:0]           next_o,          // s31q23 V: c of the next
    output wire [2*`WH_DATA_W-1:0]           offset_o,        // s31q24 A
    output wire [2*`WH_DATA_W-1:0]           flux_o,          // s31q16 cells: χ
    output wire [2*`WH_DATA_W-1:0]           lag_o,           // s31q16 cells
    output wire                              anchor_fault_o,

    // The shared multiplier.
    output wire [1:0]                        request_o,
    output wire [2*`WH_DATA_W-1:0]           factor_o,
    output wire [2*`WH_COEF_W-1:0]           coefficient_o,
    input  wire [1:0]                        grant_i,
    input  wire [1:0]                        done_i,
    input  wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product_i
);

    localparam integer DATA_W  = `WH_DATA_W;
    localparam integer COEF_W  = `WH_COEF_W;
    localparam integer COUNT_W = `WH_COUNT_W;
    localparam integer FLUX_W  = `WH_PLACE_W + `WH_SINE_Q;
    localparam integer CELL_W  = `WH_SINE_Q + 2;

    generate
        if (ANCHOR != 0 && ANCHOR != 1) begin : illegal_anchor
            wh_illegal_parameter_axes_anchor_must_be_0_or_1 stop ();
        end
    endgenerate

    // ---- Wave core. Anchors that have lost the rotor leave ports that only damp.

    wire                core_overrun;
    wire [2*DATA_W-1:0] step_max;      // what a step's waves may have
    wire [2*DATA_W-1:0] wave_voltage;  // e_id
    wire [2*DATA_W-1:0] withheld;
    wire [1:0]          waves;
    wire                core_request;  // of a shared multiplier
    wire [DATA_W-1:0]   core_factor;
    wire [COEF_W-1:0]   core_coefficient;
    wire [2*DATA_W-1:0] current;       // without the offset, in the clock of start_i
    reg  [3:0]          ends_q;        // of the step's current
    wire [1:0]          shape_mode  = !contact_i ? 2'd0 : shaped_i ? 2'd2 : 2'd1;
    wire [COEF_W-1:0]   eta         = (damp_i || anchor_fault_o) ? {COEF_W{1'b0}} : eta_i;
    wire                unused_core = &{1'b0, core_request, core_factor, core_coefficient};

    wh_wave_core #(
        .N             (2),
        .DELAY_LOG2    (DELAY_LOG2),
        .SHAPER        (SHAPER),
        .WITHHELD      (ANCHOR)
    ) wave_core (
        .clk           (clk),
        .rst           (rst),
        .start_i       (start_i),
        .busy_o        (busy_o),
        .reads_o       (reads_o),
        .valid_o       (valid_o),
        .overrun_o     (core_overrun),
        .current_i     (start_i ? current : current_o),
        .eta_i         ({2{eta}}),
        .outside_i     ({2*DATA_W{1'b0}}),
        .ends_i        (start_i ? ends_i : ends_q),
        .shape_mode_i  ({2{shape_mode}}),
        .shape_words_i ({2{shape_words_i}}),
        .root_i        ({2{root_i}}),
        .a_i           ({2{a_i}}),
        .u_max_i       (step_max),
        .extra_ticks_i (extra_ticks_i),
        .hold_ticks_i  (hold_ticks_i),
        .voltage_o     (wave_voltage),
        .u_o           (u_o),
        .v_o           (v_o),
        .saturated_o   (saturated_o),
        .withheld_o    (withheld),
        .clipped_o     (clipped_o),
        .waves_o       (waves),
        .request_o     (core_request),
        .factor_o      (core_factor),
        .coefficient_o (core_coefficient),
        .product_i     ({DATA_W + COEF_W{1'b0}})
    );

    always @(posedge clk) begin
        if (start_i) begin
            current_o <= current;
            ends_q    <= ends_i;
        end
    end

    // ---- Port anchors.

    genvar n;
    generate
        if (ANCHOR == 1) begin : anchored
            // The rotor that belongs to the step, until the port's turn.
            wire               begins;        // the anchors, with the magnets found
            wire               magnet_busy;
            wire               calm_rst = rst || damp_i || begins;
            wire [`WH_ANCHOR_W-1:0] words = {anchor_words_i[`WH_ANCHOR_W-1:1],
                                             anchor_words_i[0] && magnet_found_o};
            reg                late_q;
            reg                working_q;     // beta's anchor
            reg                contact_q;     // of the step
            reg [COUNT_W-1:0]  position_q;
            reg [2*FLUX_W-1:0] place_q;
            reg [2*CELL_W-1:0] cell_q;
            wire [1:0]         anchor_busy;
            wire [1:0]         anchor_reads;
            wire [1:0]         anchor_overrun;
            wire [1:0]         anchor_fault;

            assign anchor_busy_o  = |{anchor_busy, waves, magnet_busy};
            assign anchor_reads_o = |anchor_reads;
            assign overrun_o      = core_overrun || (|anchor_overrun) || late_q;
            assign anchor_fault_o = |anchor_fault;

            always @(posedge clk) begin
                if (rst) begin
                    late_q <= 1'b0;
                end else if (start_i && anchor_busy_o) begin
                    late_q <= 1'b1;
                end
                if (start_i) begin
                    position_q <= position_i;
                    place_q    <= place_i;
                    cell_q     <= cell_i;
                end
            end

            // Beta's anchor begins and ends last: with it the tick is done, once, though alpha's may have
            // ended long before and neither works while they are in reset.
            wire               works = anchor_busy[1] || waves[1];

            always @(posedge clk) begin
                working_q <= !rst && works;
                contact_q <= (|waves) ? contact_i : contact_q;
            end

            wh_magnet_angle magnet_angle (
                .clk           (clk),
                .rst           (angle_rst_i),
                .find_i        (find_magnet_i),
                .motor_i       (1'b0),
                .count_angle_i (count_angle_i),
                .load_i        (1'b0),
                .load_motor_i  (1'b0),
                .rest_ticks_i  (anchor_words_i[`WH_ANCHOR_W-1 -: `WH_REST_W]),
                .done_i        (working_q && !works),
                .position_i    (angle_rst_i ? position_i : position_q),
                .contact_i     (contact_q),
                .cell_i        (cell_q),
                .flux_i        (flux_o),
                .busy_o        (magnet_busy),
                .turn_o        (turn_o),
                .by_o          (by_o),
                .turned_i      (turned_i),
                .found_o       (magnet_found_o),
                .begin_o       (begins)
            );

            for (n = 0; n < 2; n = n + 1) begin : axis
                wire signed [DATA_W-1:0] raw        = $signed(current_i[n*DATA_W +: DATA_W]);
                wire signed [DATA_W-1:0] offset     = $signed(offset_o[n*DATA_W +: DATA_W]);
                wire signed [DATA_W-1:0] ideal      = $signed(wave_voltage[n*DATA_W +: DATA_W]);
                wire signed [DATA_W-1:0] correction = $signed(correction_o[n*DATA_W +: DATA_W]);
                wire signed [DATA_W-1:0] room;
                wire signed [DATA_W-1:0] left       = $signed(u_max_i) - room;
                reg  signed [DATA_W-1:0] step_max_q;
                wire signed [DATA_W:0]   wide_current = $signed({raw[DATA_W-1], raw})
                                                        - $signed({offset[DATA_W-1], offset});
                wire signed [DATA_W:0]   wide_voltage = $signed({ideal[DATA_W-1], ideal})
                                                        + $signed({correction[DATA_W-1], correction});

                assign step_max[n*DATA_W +: DATA_W] = step_max_q;

                // One limit for a step, in which an anchor may take room from the next one; c may want
                // more than there is.
                always @(posedge clk) begin
                    if (start_i) begin
                        step_max_q <= left[DATA_W-1] ? {DATA_W{1'b0}} : left;
                    end
                end

                wh_saturate #(
                    .IN_W    (DATA_W + 1),
                    .OUT_W   (DATA_W)
                ) saturate_current (
                    .value_i (wide_current),
                    .value_o (current[n*DATA_W +: DATA_W])
                );

                wh_saturate #(
                    .IN_W    (DATA_W + 1),
                    .OUT_W   (DATA_W)
                ) saturate_voltage (
                    .value_i (wide_voltage),
                    .value_o (voltage_o[n*DATA_W +: DATA_W])
                );

                wh_anchor #(
                    .AXIS          (1)
                ) anchor (
                    .clk           (clk),
                    .rst           (calm_rst),
                    .position_i    (position_q),
                    .place_i       (place_q[n*FLUX_W +: FLUX_W]),
                    .cell_i        (cell_q[n*CELL_W +: CELL_W]),
                    .contact_i     (contact_i),
                    .waves_i       (waves[n]),
                    .current_i     (current_o[n*DATA_W +: DATA_W]),
                    .u_i           (u_o[n*DATA_W +: DATA_W]),
                    .v_i           (v_o[n*DATA_W +: DATA_W]),
                    .withheld_i    (withheld[n*DATA_W +: DATA_W]),
                    .voltage_i     (ideal),
                    .saturated_i   (saturated_o[n]),
                    .blind_i       (clipped_o[n]),
                    .busy_o        (anchor_busy[n]),
                    .reads_o       (anchor_reads[n]),
                    .overrun_o     (anchor_overrun[n]),
                    .words_i       (words),
                    .request_o     (request_o[n]),
                    .factor_o      (factor_o[n*DATA_W +: DATA_W]),
                    .coefficient_o (coefficient_o[n*COEF_W +: COEF_W]),
                    .grant_i       (grant_i[n]),
                    .done_i        (done_i[n]),
                    .product_i     (product_i),
                    .correction_o  (correction_o[n*DATA_W +: DATA_W]),
                    .next_o        (next_o[n*DATA_W +: DATA_W]),
                    .room_o        (room),
                    .offset_o      (offset_o[n*DATA_W +: DATA_W]),
                    .flux_o        (flux_o[n*DATA_W +: DATA_W]),
                    .lag_o         (lag_o[n*DATA_W +: DATA_W]),
                    .fault_o       (anchor_fault[n])
                );
            end
        end else begin : by_their_waves_alone
            wire unused = &{1'b0, withheld, waves, position_i, place_i, cell_i, anchor_words_i,
                            angle_rst_i, find_magnet_i, count_angle_i,
                            turned_i, grant_i,
                            done_i, product_i};

            assign step_max       = {2{u_max_i}};
            assign current        = current_i;
            assign voltage_o      = wave_voltage;
            assign anchor_busy_o  = 1'b0;
            assign anchor_reads_o = 1'b0;
            assign overrun_o      = core_overrun;
            assign anchor_fault_o = 1'b0;
            assign turn_o         = 1'b0;
            assign by_o           = 32'd0;
            assign magnet_found_o = 1'b0;
            assign correction_o   = {2*DATA_W{1'b0}};
            assign next_o         = {2*DATA_W{1'b0}};
            assign offset_o       = {2*DATA_W{1'b0}};
            assign flux_o         = {2*DATA_W{1'b0}};
            assign lag_o          = {2*DATA_W{1'b0}};
            assign request_o      = 2'b00;
            assign factor_o       = {2*DATA_W{1'b0}};
            assign coefficient_o  = {2*COEF_W{1'b0}};
        end
    endgenerate

endmodule

`default_nettype wire
