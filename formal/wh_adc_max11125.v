// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_adc_max11125: after reset the reader gets ready by itself, and after every start again; a
// number that says how far it is only falls. The first start brings no word, each later one brings
// one, with the mark of the start before.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_adc_max11125 #(
    parameter integer LINES = 3
) (
    input wire clk,
    input wire rst,
    input wire sdata,
    input wire start,
    input wire first
);

    (* anyconst *) wire [7:0] half;
    (* anyconst *) wire [5:0] frame;
    (* anyconst *) wire [5:0] lead;
    (* anyconst *) wire [4:0] data;
    (* anyconst *) wire [7:0] quiet;
    (* anyconst *) wire [7:0] setup;
    (* anyconst *) wire [7:0] hold;

    wire                cs_n, sclk, din, ready, busy, valid, first_o, overrun;
    wire [LINES*16-1:0] sample;

    wh_adc_max11125 #(
        .LINES              (LINES)
    ) block (
        .clk                (clk),
        .rst                (rst),
        .adc_cs_n_o         (cs_n),
        .adc_sclk_o         (sclk),
        .adc_din_o          (din),
        .adc_sdata_i        (sdata),
        .sclk_half_clocks_i (half),
        .frame_bits_i       (frame),
        .lead_bits_i        (lead),
        .data_bits_i        (data),
        .quiet_clocks_i     (quiet),
        .setup_clocks_i     (setup),
        .hold_clocks_i      (hold),
        .sclk_idle_i        (1'b1),
        .read_trailing_i    (1'b1),
        .start_i            (start),
        .first_i            (first),
        .ready_o            (ready),
        .busy_o             (busy),
        .valid_o            (valid),
        .first_o            (first_o),
        .sample_o           (sample),
        .overrun_o          (overrun)
    );

    (* hierconn *) wire [1:0] \block.set_up_q ;
    (* hierconn *) wire [2:0] \block.line_q ;
    (* hierconn *) wire       \block.started_q ;
    (* hierconn *) wire       \block.before_q ;
    (* hierconn *) wire       \block.first_q ;
    (* hierconn *) wire       \block.serial.ready_q ;
    (* hierconn *) wire       \block.serial.valid_q ;
    (* hierconn *) wire       \block.serial.cs_n_q ;
    (* hierconn *) wire       \block.serial.sclk_q ;
    (* hierconn *) wire [7:0] \block.serial.wait_q ;
    (* hierconn *) wire [5:0] \block.serial.pulses_q ;
    (* hierconn *) wire [5:0] \block.serial.lead_q ;
    (* hierconn *) wire [4:0] \block.serial.data_q ;

    // Frames still to begin, then the frame, then its quiet time.
    wire [2:0]  frames = !ready ? 3'd3 - {1'b0, \block.set_up_q }
                       : (\block.line_q != 3'd0) ? LINES - \block.line_q : 3'd0;
    wire [18:0] togo   = {frames, !\block.serial.cs_n_q , \block.serial.pulses_q ,
                          !\block.serial.sclk_q , \block.serial.wait_q };

    reg        begun = 1'b0;
    reg        rst_q, busy_q, ready_q, overrun_q, start_q, cs_n_q;
    reg [18:0] togo_q;
    reg [1:0]  starts = 2'd0;   // accepted since reset, up to 2
    reg        open_q = 1'b0;   // the last accepted start's word is still to come
    reg        mark_q, mark_before_q;

    wire accepted = start && ready && !busy;
    wire frame_of_first = !\block.serial.cs_n_q && ((LINES == 1) || \block.line_q == 3'd1);

    always @(posedge clk) begin
        begun     <= 1'b1;
        rst_q     <= rst;
        busy_q    <= busy;
        ready_q   <= ready;
        overrun_q <= overrun;
        start_q   <= start;
        cs_n_q    <= cs_n;
        togo_q    <= togo;

        assume (half >= 1 && setup >= 1 && data >= 1 && data <= 16);
        assume ({1'b0, frame} >= {1'b0, lead} + {2'd0, data});
        if (!begun) assume (rst);

        if (rst) begin
            starts <= 2'd0;
            open_q <= 1'b0;
        end else if (accepted) begin
            starts        <= (starts == 2'd2) ? 2'd2 : starts + 2'd1;
            open_q        <= (starts != 2'd0);
            mark_q        <= first;
            mark_before_q <= mark_q;
        end else if (valid) begin
            open_q <= 1'b0;
        end

        if (begun) begin
            if (rst_q) assert (cs_n && sclk && !valid && !overrun && !ready);
            if (!rst_q && busy_q) assert (togo < togo_q || !busy);
            if (!rst_q && ready_q) assert (ready);
            if (valid) assert (open_q && first_o == mark_before_q);
            // It has come before the reader can be started again.
            if (ready && !busy && !valid) assert (!open_q);
            if (!rst_q) assert (overrun == (overrun_q || (start_q && ready_q && busy_q)));

            // What makes that inductive.
            assert (\block.serial.ready_q );
            assert (starts <= 2'd2 && \block.line_q < LINES);
            if (!ready) assert (starts == 2'd0 && \block.line_q == 3'd0);
            if (cs_n) assert (sclk);
            if (ready) assert (\block.started_q == (starts != 2'd0));
            if (!ready) assert (!\block.started_q && !\block.before_q );
            assert (\block.before_q == (starts == 2'd2));
            if (starts == 2'd2) assert (first_o == mark_before_q);
            if (starts != 2'd0) assert (\block.first_q == mark_q);
            if (!cs_n) assert (\block.serial.data_q <= 5'd16);
            if (open_q && !valid) assert (frame_of_first && \block.serial.data_q != 5'd0);
            if (open_q) assert (starts == 2'd2);
            if (cs_n && \block.serial.valid_q ) assert (!cs_n_q);
            if (\block.serial.valid_q ) assert (\block.serial.data_q == 5'd0);
            if (ready && starts == 2'd2 && frame_of_first) begin
                assert (open_q == (\block.serial.data_q != 5'd0 || \block.serial.valid_q ));
            end
            if (!cs_n) assert (({1'b0, \block.serial.pulses_q } + !sclk >= {1'b0, \block.serial.lead_q } + {2'd0, \block.serial.data_q }));
            if (cs_n) assert (!\block.serial.valid_q || \block.serial.data_q == 5'd0);
        end

        cover (begun && ready && !ready_q && !rst_q);
        cover (begun && valid && frame == 6'd2);
        cover (begun && overrun && starts == 2'd2);
    end

endmodule

`default_nettype wire
