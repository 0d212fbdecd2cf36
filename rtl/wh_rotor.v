// SPDX-License-Identifier: Apache-2.0
//
// wh_rotor: what each brushless motor has of its own behind its encoder: the flux by its counts, and the angle of its
// magnets.
//
//   position -> wh_rotor_flux -> position, flux of alpha and beta, as of look_i
//   χ of both axes' anchors -> wh_magnet_angle -> the angle that is turned
//
// look_i begins the motor's turn, done_i ends it, with the anchors' χ. Once the magnets are found, forget_o comes with
// forget_i, behind both anchors' turns: they begin anew.
// start_i begins to find the magnets, or takes another zero_angle; count_angle counts all the time.
// Formats: those of the blocks. Latency: theirs. Reset: theirs.

`default_nettype none
`include "wh_formats.vh"

module wh_rotor (
    input  wire                                   clk,
    input  wire                                   rst,

    input  wire signed [`WH_COUNT_W-1:0]          position_i,    // s32, counts, of the encoder
    input  wire [64:0]                            magnets_i,     // find, zero_angle, count_angle
    input  wire                                   start_i,       // strobe

    // A turn.
    input  wire                                   look_i,        // strobe
    input  wire                                   done_i,        // strobe
    input  wire                                   forget_i,      // strobe
    input  wire                                   contact_i,     // with done_i, and for two clocks after it
    input  wire [`WH_REST_W-1:0]                  rest_ticks_i,
    input  wire [2*`WH_DATA_W-1:0]                flux_i,        // s31q16 counts: χ, alpha lowest

    output wire [`WH_MOVE_W-1:0]                  count_o,       // counts, modulo 2^12, now
    output reg  [2*(`WH_PLACE_W+`WH_SINE_Q)-1:0]  place_o,       // s30q15 counts, until the next look_i
    output reg  [2*(`WH_SINE_Q+2)-1:0]            cell_o,        // s17q15 counts
    output wire                                   found_o,
    output wire                                   forget_o,      // strobe
    output wire [31:0]                            angle_o        // of the magnets, turns of 2^32
);

    localparam integer COUNT_W = `WH_COUNT_W;

    wire [31:0] count_angle = magnets_i[31:0];
    wire [31:0] zero_angle  = magnets_i[63:32];
    wire        find        = magnets_i[64];

    wire                                  turn, turned, begins, busy;
    wire [31:0]                           by;
    wire signed [COUNT_W-1:0]             position;
    wire [2*(`WH_PLACE_W+`WH_SINE_Q)-1:0] place;
    wire [2*(`WH_SINE_Q+2)-1:0]           last_cell;
    reg                                   start_q;    // the flux is that of the start
    reg  signed [COUNT_W-1:0]             position_q; // of the turn
    reg                                   begins_q;
    wire                                  unused = &{1'b0, busy};

    assign count_o  = position[`WH_MOVE_W-1:0];
    assign forget_o = forget_i && begins_q;

    always @(posedge clk) begin
        start_q <= start_i && !rst;
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

    wh_rotor_flux rotor_flux (
        .clk           (clk),
        .rst           (rst || start_i),
        .position_i    (position_i),
        .count_angle_i (count_angle),
        .zero_angle_i  (zero_angle),
        .turn_i        (turn),
        .by_i          (by),
        .turned_o      (turned),
        .angle_o       (angle_o),
        .position_o    (position),
        .place_o       (place),
        .cell_o        (last_cell)
    );

    wh_magnet_angle magnet_angle (
        .clk           (clk),
        .rst           (rst || start_q),
        .find_i        (find),
        .count_angle_i (count_angle),
        .rest_ticks_i  (rest_ticks_i),
        .done_i        (done_i),
        .position_i    ((rst || start_q) ? position : position_q),
        .contact_i     (contact_i),
        .cell_i        (cell_o),
        .flux_i        (flux_i),
        .busy_o        (busy),
        .turn_o        (turn),
        .by_o          (by),
        .turned_i      (turned),
        .found_o       (found_o),
        .begin_o       (begins)
    );

endmodule

`default_nettype wire
