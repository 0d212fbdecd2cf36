// SPDX-License-Identifier: Apache-2.0
//
// wh_rotor: what brushless motors have behind their encoders: the flux by their counts, and the angles of their
// magnets. All motors share its blocks.
//
//   positions -> wh_rotor_flux -> position, flux of alpha and beta, as of look_i
//   χ of both axes' anchors -> wh_magnet_angle -> the angle that is turned
//
// look_i begins the turn of motor_i, done_i ends that of turn_motor_i, with the anchors' χ. Once its magnets are found,
// its forget_o comes with forget_i, behind both anchors' turns: they begin anew.
// start_i begins to find the magnets, or takes another zero_angle; count_angle counts all the time.
// What a look shows stays until the next look. A turn's done_i comes at least 4 clocks before another motor's, and at
// most two clocks before another motor's look.
// Formats: those of the blocks. Latency: theirs. Reset: theirs.

`default_nettype none
`include "wh_formats.vh"

module wh_rotor #(
    parameter integer MOTORS  = 1,                                 // 1...4
    parameter integer MOTOR_W = (MOTORS > 1) ? $clog2(MOTORS) : 1  // derived, leave it
) (
    input  wire                                   clk,
    input  wire                                   rst,

    // The first motor lowest.
    input  wire [MOTORS*`WH_COUNT_W-1:0]          position_i,    // s32, counts, of the encoders
    input  wire [65*MOTORS-1:0]                   magnets_i,     // find, zero_angle, count_angle
    input  wire                                   start_i,       // strobe

    // A turn.
    input  wire                                   look_i,        // strobe
    input  wire [MOTOR_W-1:0]                     motor_i,
    input  wire                                   done_i,        // strobe
    input  wire                                   forget_i,      // strobe
    input  wire [MOTOR_W-1:0]                     turn_motor_i,  // with both, and between them
    input  wire                                   contact_i,     // with done_i, and for two clocks after it
    input  wire [`WH_REST_W-1:0]                  rest_ticks_i,
    input  wire [2*`WH_DATA_W-1:0]                flux_i,        // s31q16 counts: χ, alpha lowest

    output wire [`WH_MOVE_W-1:0]                  count_o,       // counts, modulo 2^12, of motor_i now
    output reg  [2*(`WH_PLACE_W+`WH_SINE_Q)-1:0]  place_o,       // s30q15 counts, until the next look_i
    output reg  [2*(`WH_SINE_Q+2)-1:0]            cell_o,        // s17q15 counts
    output wire [MOTORS-1:0]                      found_o,
    output wire [MOTORS-1:0]                      forget_o,      // strobes
    output wire [32*MOTORS-1:0]                   angle_o        // of the magnets, turns of 2^32
);

    localparam integer COUNT_W = `WH_COUNT_W;

    wire [32*MOTORS-1:0] count_angles, zero_angles;
    wire [MOTORS-1:0]    finds;

    genvar n;
    generate
        for (n = 0; n < MOTORS; n = n + 1) begin : motor
            assign {finds[n], zero_angles[32*n +: 32], count_angles[32*n +: 32]} = magnets_i[65*n +: 65];
        end
    endgenerate

    wire [31:0] turn_motor  = (MOTORS == 1) ? 32'd0 : {{(32 - MOTOR_W){1'b0}}, turn_motor_i};
    reg  [31:0] count_angle;
    integer     k;

    always @* begin
        count_angle = count_angles[31:0];
        for (k = 1; k < MOTORS; k = k + 1) begin
            count_angle = (turn_motor == k) ? count_angles[32*k +: 32] : count_angle;
        end
    end

    wire                                  turn, turned, begins, busy, load;
    wire [MOTOR_W-1:0]                    load_motor;
    wire [31:0]                           by;
    wire signed [COUNT_W-1:0]             position, load_position;
    wire [2*(`WH_PLACE_W+`WH_SINE_Q)-1:0] place;
    wire [2*(`WH_SINE_Q+2)-1:0]           last_cell;
    reg  signed [COUNT_W-1:0]             position_q; // of the turn
    reg                                   begins_q;
    wire                                  unused = &{1'b0, busy};

    assign count_o  = position[`WH_MOVE_W-1:0];
    assign forget_o = {{MOTORS-1{1'b0}}, forget_i && begins_q} << turn_motor;

    always @(posedge clk) begin
        if (look_i) begin
            position_q <= position;
            place_o    <= place;
            cell_o     <= last_cell;
        end
        if (rst || forget_i) begin
            begins_q <= 1'b0;
        end else if (begins) begin
            begins_q <= 1'b1;
        end
    end

    wh_rotor_flux #(
        .MOTORS          (MOTORS)
    ) rotor_flux (
        .clk             (clk),
        .rst             (rst || start_i),
        .position_i      (position_i),
        .count_angle_i   (count_angles),
        .zero_angle_i    (zero_angles),
        .turn_i          (turn),
        .turn_motor_i    (turn_motor_i),
        .by_i            (by),
        .turned_o        (turned),
        .angle_o         (angle_o),
        .load_o          (load),
        .load_motor_o    (load_motor),
        .load_position_o (load_position),
        .motor_i         (motor_i),
        .position_o      (position),
        .place_o         (place),
        .cell_o          (last_cell)
    );

    wh_magnet_angle #(
        .MOTORS          (MOTORS)
    ) magnet_angle (
        .clk             (clk),
        .rst             (rst || start_i),
        .find_i          (finds),
        .motor_i         (turn_motor_i),
        .count_angle_i   (count_angle),
        .load_i          (load),
        .load_motor_i    (load_motor),
        .rest_ticks_i    (rest_ticks_i),
        .done_i          (done_i),
        .position_i      (load ? load_position : position_q),
        .contact_i       (contact_i),
        .cell_i          (cell_o),
        .flux_i          (flux_i),
        .busy_o          (busy),
        .turn_o          (turn),
        .by_o            (by),
        .turned_i        (turned),
        .found_o         (found_o),
        .begin_o         (begins)
    );

endmodule

`default_nettype wire
