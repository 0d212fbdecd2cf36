// SPDX-License-Identifier: Apache-2.0
//
// start_up: a Wishbone master that writes the registers of wh_scene.vh after reset, for a design without a
// processor. A processor does the same with the C header (docs/use_in_your_design.md).
//
// It reads `settings_busy` until that is 0, as no setting can be written before; writes every row; writes 1 to
// `commit`; and reads `settings_busy` until that is 0 again. With a brushless motor it then writes 1 to
// `magnet_start`. done_o and failed_o stay until reset; an err ends the sequence.
//
// Latency: 8 clocks for each register, and what the device takes to be ready and to apply the commit.
// Reset: the sequence begins anew.

`default_nettype none
`include "wh_scene.vh"

module start_up (
    input  wire        clk,
    input  wire        rst,

    // Wishbone, classic cycles.
    output wire        cyc_o,
    output wire        stb_o,
    output wire        we_o,
    output wire [11:0] adr_o,
    output wire [31:0] dat_o,
    input  wire [31:0] dat_i,
    input  wire        ack_i,
    input  wire        err_i,

    output wire        done_o,     // the settings are in force
    output wire        failed_o    // the device refused one
);

    localparam [11:0] COUNT  = `WH_SCENE_COUNT;
    localparam [11:0] WAIT   = 12'd0;             // steps; from here to COUNT a row each
    localparam [11:0] COMMIT = COUNT + 12'd1;
    localparam [11:0] APPLY  = COUNT + 12'd2;
    localparam [11:0] MAGNET = COUNT + 12'd3;
    localparam [11:0] LAST   = (`WH_SCENE_AXES != 0) ? MAGNET : APPLY;

    reg [43:0] rows [0:`WH_SCENE_COUNT-1];        // address, value

    initial begin
`define WH_SCENE_WRITE(NUMBER, ADDRESS, RAW) rows[NUMBER] = {ADDRESS, RAW};
`include "wh_scene.vh"
`undef WH_SCENE_WRITE
    end

    reg  [11:0] step_q;
    reg  [43:0] row_q;
    reg         cycle_q;
    reg         done_q;
    reg         failed_q;

    // A step is over with its ack, one that waits once `settings_busy` reads 0.
    wire        waits = (step_q == WAIT) || (step_q == APPLY);
    wire        over  = cycle_q && ack_i && !(waits && dat_i[0]);

    localparam integer PLACE_W = $clog2(`WH_SCENE_COUNT);
    wire        [11:0] place   = step_q - 12'd1;  // of the row, in the steps that have one
    wire               unused  = &{1'b0, dat_i[31:1], place[11:PLACE_W]};

    assign cyc_o    = cycle_q;
    assign stb_o    = cycle_q;
    assign we_o     = !waits;
    assign adr_o    = (step_q == COMMIT) ? `WH_SCENE_AT_COMMIT
                    : waits              ? `WH_SCENE_AT_SETTINGS_BUSY
                    : (step_q == MAGNET) ? `WH_SCENE_AT_MAGNET_START : row_q[43:32];
    assign dat_o    = (step_q >= COMMIT) ? 32'd1 : row_q[31:0];
    assign done_o   = done_q;
    assign failed_o = failed_q;

    always @(posedge clk) begin
        row_q <= rows[place[PLACE_W-1:0]];
        if (rst) begin
            step_q   <= 12'd0;
            cycle_q  <= 1'b0;
            done_q   <= 1'b0;
            failed_q <= 1'b0;
        end else begin
            cycle_q <= !done_q && !failed_q && !(cycle_q && (ack_i || err_i));
            if (cycle_q && err_i) begin
                failed_q <= 1'b1;
            end
            if (over) begin
                step_q <= step_q + 12'd1;
                done_q <= (step_q == LAST);
            end
        end
    end

endmodule

`default_nettype wire
