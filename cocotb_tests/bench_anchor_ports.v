// SPDX-License-Identifier: Apache-2.0
//
// bench_anchor_ports: N ports of one wh_anchor_ports beside N wh_anchor, which get the same words.
//
// go_i begins a period: every wh_anchor gets its words at once, and the ports of wh_anchor_ports theirs in turn,
// PITCH clocks each. done_o follows when all of them have ended. Of each port's results differs_o says which
// ones aren't the same then: fault, ω̂, χ, offset, room, c from the highest on.

`default_nettype none
`include "wh_formats.vh"

module bench_anchor_ports #(
    parameter integer N      = 1,
    parameter integer PITCH  = 32,
    parameter integer AXES   = 0,
    parameter integer PORT_W = (N > 1) ? $clog2(N) : 1
) (
    input  wire                       clk,
    input  wire                       rst,

    input  wire                       go_i,
    output wire                       done_o,        // strobe

    input  wire [N*`WH_COUNT_W-1:0]   position_i,
    input  wire [N*(`WH_PLACE_W+`WH_SINE_Q)-1:0] place_i,  // of axes, as is cell_i
    input  wire [N*(`WH_SINE_Q+2)-1:0] cell_i,
    input  wire [N-1:0]               forget_i,
    input  wire [N-1:0]               contact_i,
    input  wire [N-1:0]               blind_i,
    input  wire [N*`WH_DATA_W-1:0]    current_i,
    input  wire [N*`WH_DATA_W-1:0]    u_i,
    input  wire [N*`WH_DATA_W-1:0]    v_i,
    input  wire [N*`WH_DATA_W-1:0]    withheld_i,
    input  wire [N*`WH_DATA_W-1:0]    voltage_i,
    input  wire [N-1:0]               saturated_i,

    input  wire [N*`WH_ANCHOR_W-1:0]  words_i,       // settings
    input  wire                       bank_i,
    input  wire                       write_i,
    input  wire                       write_bank_i,
    input  wire [11:0]                address_i,
    input  wire [31:0]                data_i,

    output reg  [N*`WH_DATA_W-1:0]    correction_o,  // of wh_anchor_ports
    output reg  [N*`WH_DATA_W-1:0]    room_o,
    output reg  [N*`WH_DATA_W-1:0]    offset_o,
    output reg  [N*`WH_DATA_W-1:0]    flux_o,
    output reg  [N*`WH_DATA_W-1:0]    lag_o,
    output wire [N-1:0]               faults_o,
    output wire [6*N-1:0]             differs_o
);

    localparam [7:0]   TURN   = PITCH[7:0];
    localparam integer OF     = AXES | AXES << 1;
    localparam integer FLUX_W = `WH_PLACE_W + `WH_SINE_Q;
    localparam integer CELL_W = `WH_SINE_Q + 2;
    localparam integer DATA_W = `WH_DATA_W;
    localparam integer COEF_W = `WH_COEF_W;

    // ---- Turns.
    reg [PORT_W-1:0] turn_q;
    reg [7:0]        wait_q;
    reg              runs_q;
    wire             last  = ({{(32 - PORT_W){1'b0}}, turn_q} == N - 1);
    wire             valid = go_i || (runs_q && wait_q == 8'd0 && !last);
    wire [PORT_W-1:0] port = go_i ? {PORT_W{1'b0}} : turn_q + 1'b1;
    reg  [PORT_W-1:0] port_q;

    assign done_o = runs_q && last && wait_q == 8'd0;

    always @(posedge clk) begin
        if (rst) begin
            runs_q <= 1'b0;
        end else if (valid) begin
            runs_q <= 1'b1;
            turn_q <= port;
            port_q <= port;
            wait_q <= TURN - 8'd1;
        end else if (runs_q) begin
            wait_q <= wait_q - 8'd1;
            runs_q <= !done_o;
        end
    end

    // ---- One for all ports. Its words are there from valid_i on, and are noise nine clocks later.
    wire [PORT_W-1:0] now   = valid ? port : port_q;
    wire              holds = valid || (runs_q && wait_q >= TURN - 8'd9);
    wire [DATA_W-1:0] noise = {DATA_W{!holds}};

    wire                            request;
    wire signed [DATA_W-1:0]        factor;
    wire signed [COEF_W-1:0]        coefficient;
    wire signed [DATA_W+COEF_W-1:0] product;
    wire                            room_valid, offset_valid, flux_valid, lag_valid, correction_valid;
    wire [PORT_W-1:0]               whose;
    wire signed [DATA_W-1:0]        data;

    wh_anchor_ports #(
        .N                  (N),
        .AXES               (AXES)
    ) anchor_ports (
        .clk                (clk),
        .rst                (rst),
        .valid_i            (valid),
        .port_i             (port),
        .bank_i             (bank_i),
        .position_i         ($signed(position_i[now*`WH_COUNT_W +: `WH_COUNT_W])),
        .place_i            ($signed(place_i[now*FLUX_W +: FLUX_W] ^ {FLUX_W{!holds}})),
        .cell_i             ($signed(cell_i[now*CELL_W +: CELL_W] ^ {CELL_W{!holds}})),
        .found_i            ({N{1'b1}}),
        .forget_i           (forget_i),
        .contact_i          (contact_i[now] ^ !holds),
        .blind_i            (blind_i[now] ^ !holds),
        .current_i          ($signed(current_i[now*DATA_W +: DATA_W] ^ noise)),
        .u_i                ($signed(u_i[now*DATA_W +: DATA_W] ^ noise)),
        .v_i                ($signed(v_i[now*DATA_W +: DATA_W] ^ noise)),
        .withheld_i         ($signed(withheld_i[now*DATA_W +: DATA_W] ^ noise)),
        .voltage_i          ($signed(voltage_i[now*DATA_W +: DATA_W] ^ noise)),
        .saturated_i        (saturated_i[now] ^ !holds),
        .write_i            (write_i),
        .write_bank_i       (write_bank_i),
        .address_i          (address_i),
        .data_i             (data_i),
        .request_o          (request),
        .factor_o           (factor),
        .coefficient_o      (coefficient),
        .product_i          (product),
        .room_valid_o       (room_valid),
        .offset_valid_o     (offset_valid),
        .flux_valid_o       (flux_valid),
        .lag_valid_o        (lag_valid),
        .correction_valid_o (correction_valid),
        .port_o             (whose),
        .data_o             (data),
        .faults_o           (faults_o)
    );

    // What nobody asked for is no product.
    reg [2:0]                        asked_q;
    wire signed [DATA_W+COEF_W-1:0]  made;

    always @(posedge clk) begin
        asked_q <= {asked_q[1:0], request};
    end

    wh_multiply multiply (
        .clk       (clk),
        .take_i    (1'b1),
        .data_i    (factor),
        .coef_i    (coefficient),
        .product_o (made)
    );

    assign product = asked_q[2] ? made : ~made;

    integer k;

    always @(posedge clk) begin
        if (rst) begin
            correction_o <= {N*DATA_W{1'b0}};
            room_o       <= {N*DATA_W{1'b0}};
            offset_o     <= {N*DATA_W{1'b0}};
            flux_o       <= {N*DATA_W{1'b0}};
            lag_o        <= {N*DATA_W{1'b0}};
        end else begin
            if (correction_valid) correction_o[whose*DATA_W +: DATA_W] <= data;
            if (room_valid)       room_o[whose*DATA_W +: DATA_W]       <= data;
            if (offset_valid)     offset_o[whose*DATA_W +: DATA_W]     <= data;
            if (flux_valid)       flux_o[whose*DATA_W +: DATA_W]       <= data;
            if (lag_valid)        lag_o[whose*DATA_W +: DATA_W]        <= data;
            for (k = 0; k < N; k = k + 1) begin
                if (forget_i[k]) begin
                    correction_o[k*DATA_W +: DATA_W] <= {DATA_W{1'b0}};
                    room_o[k*DATA_W +: DATA_W]       <= {DATA_W{1'b0}};
                    offset_o[k*DATA_W +: DATA_W]     <= {DATA_W{1'b0}};
                    flux_o[k*DATA_W +: DATA_W]       <= {DATA_W{1'b0}};
                    lag_o[k*DATA_W +: DATA_W]        <= {DATA_W{1'b0}};
                end
            end
        end
    end

    // ---- One for each port.
    genvar n;
    generate
        for (n = 0; n < N; n = n + 1) begin : each
            wire                            one_request, one_grant, one_done;
            wire signed [DATA_W-1:0]        one_factor;
            wire signed [COEF_W-1:0]        one_coefficient;
            wire signed [DATA_W+COEF_W-1:0] one_product;
            wire signed [DATA_W-1:0]        correction, next, room, offset, flux, lag;
            wire                            fault, busy, reads, overrun;
            wire                            unused = &{1'b0, correction, busy, reads, overrun};

            wh_multiply_shared #(
                .USERS     (1)
            ) multiply_shared (
                .clk       (clk),
                .rst       (rst),
                .drop_i    (1'b0),
                .request_i (one_request),
                .data_i    (one_factor),
                .coef_i    (one_coefficient),
                .grant_o   (one_grant),
                .done_o    (one_done),
                .product_o (one_product)
            );

            wh_anchor #(
                .AXIS          ((OF >> n) & 1)
            ) anchor (
                .clk           (clk),
                .rst           (rst || forget_i[n]),
                .waves_i       (go_i),
                .position_i    ($signed(position_i[n*`WH_COUNT_W +: `WH_COUNT_W])),
                .place_i       ($signed(place_i[n*FLUX_W +: FLUX_W])),
                .cell_i        ($signed(cell_i[n*CELL_W +: CELL_W])),
                .contact_i     (contact_i[n]),
                .blind_i       (blind_i[n]),
                .current_i     ($signed(current_i[n*DATA_W +: DATA_W])),
                .u_i           ($signed(u_i[n*DATA_W +: DATA_W])),
                .v_i           ($signed(v_i[n*DATA_W +: DATA_W])),
                .withheld_i    ($signed(withheld_i[n*DATA_W +: DATA_W])),
                .voltage_i     ($signed(voltage_i[n*DATA_W +: DATA_W])),
                .saturated_i   (saturated_i[n]),
                .busy_o        (busy),
                .reads_o       (reads),
                .overrun_o     (overrun),
                .words_i       (words_i[n*`WH_ANCHOR_W +: `WH_ANCHOR_W]),
                .request_o     (one_request),
                .factor_o      (one_factor),
                .coefficient_o (one_coefficient),
                .grant_i       (one_grant),
                .done_i        (one_done),
                .product_i     (one_product),
                .correction_o  (correction),
                .next_o        (next),
                .room_o        (room),
                .offset_o      (offset),
                .flux_o        (flux),
                .lag_o         (lag),
                .fault_o       (fault)
            );

            assign differs_o[6*n +: 6] = {
                fault != faults_o[n],
                lag != $signed(lag_o[n*DATA_W +: DATA_W]),
                flux != $signed(flux_o[n*DATA_W +: DATA_W]),
                offset != $signed(offset_o[n*DATA_W +: DATA_W]),
                room != $signed(room_o[n*DATA_W +: DATA_W]),
                next != $signed(correction_o[n*DATA_W +: DATA_W])
            };
        end
    endgenerate

endmodule

`default_nettype wire
