// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_adc_serial: whatever the settings, a frame comes to an end: a number that says how far
// it is only falls. A word comes after each accepted start and after nothing else, and holds the
// bits that were read. Reset and start_i come when they like.

`default_nettype none
`include "wh_formats.vh"

module prove_wh_adc_serial (
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
    (* anyconst *) wire [5:0] calibrate;
    (* anyconst *) wire       idle_level;
    (* anyconst *) wire       trailing;

    wire        cs_n, sclk, ready, busy, lead_edge, valid, first_o, overrun;
    wire [15:0] sample;

    wh_adc_serial block (
        .clk                (clk),
        .rst                (rst),
        .adc_cs_n_o         (cs_n),
        .adc_sclk_o         (sclk),
        .adc_sdata_i        (sdata),
        .sclk_half_clocks_i (half),
        .frame_bits_i       (frame),
        .lead_bits_i        (lead),
        .data_bits_i        (data),
        .quiet_clocks_i     (quiet),
        .setup_clocks_i     (setup),
        .hold_clocks_i      (hold),
        .calibrate_bits_i   (calibrate),
        .sclk_idle_i        (idle_level),
        .read_trailing_i    (trailing),
        .start_i            (start),
        .first_i            (first),
        .ready_o            (ready),
        .busy_o             (busy),
        .lead_edge_o        (lead_edge),
        .valid_o            (valid),
        .first_o            (first_o),
        .sample_o           (sample),
        .overrun_o          (overrun)
    );

    (* hierconn *) wire [7:0] \block.wait_q ;
    (* hierconn *) wire [5:0] \block.pulses_q ;
    (* hierconn *) wire [5:0] \block.lead_q ;
    (* hierconn *) wire [4:0] \block.data_q ;
    (* hierconn *) wire [15:0] \block.place_q ;

    wire        pulse = (sclk != idle_level);
    // How far the frame and the quiet time after it still have to go.
    wire [15:0] togo  = {!cs_n, \block.pulses_q , pulse, \block.wait_q };

    reg         begun = 1'b0;
    reg         rst_q, busy_q, ready_q, overrun_q, start_q, cs_n_q, sclk_q;
    reg  [15:0] togo_q;
    reg         open_q = 1'b0;    // a start was accepted, and its word is still to come
    reg         first_q;
    reg         calibrating_q;    // the frame that comes by itself
    reg  [5:0]  pulses;           // of this frame, begun so far
    reg  [5:0]  reads;            // of this frame
    reg  [15:0] bits;             // data bits of this frame
    wire        accepted = start && ready && !busy;
    wire        read = trailing ? (!cs_n && \block.wait_q == 8'd0 && pulse) : lead_edge;
    wire [4:0]  put  = data - \block.data_q ;  // data bits of this frame so far

    always @(posedge clk) begin
        begun     <= 1'b1;
        rst_q     <= rst;
        busy_q    <= busy;
        ready_q   <= ready;
        overrun_q <= overrun;
        start_q   <= start;
        cs_n_q    <= cs_n;
        sclk_q    <= sclk;
        togo_q    <= togo;

        assume (half >= 1 && setup >= 1 && data >= 1 && data <= 16);
        assume ({1'b0, frame} >= {1'b0, lead} + {2'd0, data});
        if (!begun) assume (rst);

        if (rst) begin
            open_q <= 1'b0;
        end else begin
            if (accepted) begin
                open_q  <= 1'b1;
                first_q <= first;
            end else if (valid) begin
                open_q <= 1'b0;
            end
        end
        if (cs_n) begin
            pulses        <= 6'd0;
            reads         <= 6'd0;
            bits          <= 16'd0;
            calibrating_q <= !ready;
        end else begin
            if (lead_edge) pulses <= pulses + 6'd1;
            if (read) begin
                reads <= reads + 6'd1;
                if (reads >= lead && !calibrating_q && reads - lead < {1'b0, data}) begin
                    bits <= {bits[14:0], sdata};
                end
            end
        end

        if (begun) begin
            // After reset, and so after a frame that it cut, the reader is at rest but for the quiet.
            if (rst_q) assert (cs_n && sclk == idle_level && !valid && !overrun
                               && ready == (calibrate == 6'd0)
                               && \block.wait_q == ((quiet == 8'd0) ? 8'd0 : quiet - 8'd1));
            // Busy comes to an end.
            if (!rst_q && busy_q && !(cs_n_q && !cs_n)) assert (togo < togo_q || !busy);
            if (!rst_q && busy_q && cs_n_q && !cs_n) assert (!ready_q);  // only by itself
            if (!rst_q && ready_q) assert (ready);
            if (cs_n && \block.wait_q == 8'd0 && ready) assert (!busy);
            // A word for every start.
            if (valid) assert (open_q && first_o == first_q);
            if (open_q && !valid) assert (!cs_n);
            if (cs_n && !cs_n_q && !rst_q && !calibrating_q) assert (!open_q || valid);
            if (valid) assert (sample == ((bits << (5'd16 - data)) ^ 16'h8000));
            // The frame at the pins.
            if (!cs_n && !cs_n_q && sclk != sclk_q && sclk == idle_level) assert (pulses != 6'd0);
            // An overrun is a start while busy, and stays.
            if (!rst_q) assert (overrun == (overrun_q || (start_q && ready_q && busy_q)));

            // What makes that inductive.
            if (cs_n) assert (sclk == idle_level && (!open_q || valid));
            if (!cs_n) begin
                assert (calibrating_q == !ready);
                assert (pulses + \block.pulses_q == (calibrating_q ? calibrate : frame));
                assert (pulses <= (calibrating_q ? calibrate : frame));
                assert (reads == (trailing ? pulses - pulse : pulses));
                assert (!(pulse && pulses == 6'd0));
                if (!calibrating_q) begin
                    assert (\block.lead_q == ((reads < lead) ? lead - reads : 6'd0));
                    assert ({1'b0, \block.data_q } == ((reads < lead) ? {1'b0, data}
                            : (reads - lead < {1'b0, data}) ? data - (reads - lead) : 6'd0));
                    assert (open_q == (\block.data_q != 5'd0 || valid));
                    assert (first_o == first_q);
                    assert (\block.place_q == (17'h8000 >> put));
                    assert (bits >> put == 16'd0);
                    if (put != 5'd0) assert (sample == ((bits << (5'd16 - put)) ^ 16'h8000));
                end else begin
                    assert (!open_q && \block.data_q == 5'd0 && !valid);
                end
            end else begin
                if (valid) assert (!cs_n_q);
            end
            if (valid) assert (\block.data_q == 5'd0);
        end

        cover (begun && valid && data == 5'd3 && lead == 6'd1 && trailing && sample == 16'h4000);
        cover (begun && valid && !trailing && quiet == 8'd0 && calibrate == 6'd0);
        cover (begun && ready && !ready_q && calibrate == 6'd2 && !rst_q);
        cover (begun && overrun && !overrun_q && !cs_n);
    end

endmodule

`default_nettype wire
