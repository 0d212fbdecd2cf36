// SPDX-License-Identifier: Apache-2.0
//
// prove_wh_wishbone: every cycle that is held ends once, by ack or err, in bounded time; the answer is that of its
// own request; nothing is written but by a cycle that gets ack, or that is given up in that very clock; a partial
// write never reaches the device; a request stands until the device answers. The device answers when it
// likes, within PATIENCE clocks, and says what it likes. The master begins and gives up cycles when it likes.

`default_nettype none

module prove_wh_wishbone #(
    parameter [3:0] PATIENCE = 4'd3
) (
    input wire        clk,
    input wire        rst,
    input wire        cyc,
    input wire        stb,
    input wire        we,
    input wire [11:0] adr,
    input wire [31:0] dat,
    input wire [3:0]  sel,
    input wire        answers,  // the device judges in this clock, and answers in the next one
    input wire [1:0]  verdict,
    input wire [31:0] read
);

    wire [31:0] dat_o, data;
    wire [11:0] address;
    wire        ack, err, valid, write, check;

    reg         begun = 1'b0;

    // The device, as wh_registers has it: it writes in the clock of its answer, by the check of the clock before.
    reg         ready_q;
    reg         wrote_q;
    reg  [1:0]  error_q;
    reg  [3:0]  waits_q;
    wire        judges = valid && !ready_q && answers;

    wh_wishbone block (
        .clk           (clk),
        .rst           (rst),
        .cyc_i         (cyc),
        .stb_i         (stb),
        .we_i          (we),
        .adr_i         (adr),
        .dat_i         (dat),
        .sel_i         (sel),
        .dat_o         (dat_o),
        .ack_o         (ack),
        .err_o         (err),
        .bus_valid_o   (valid),
        .bus_write_o   (write),
        .bus_check_o   (check),
        .bus_address_o (address),
        .bus_data_o    (data),
        .bus_ready_i   (ready_q),
        .bus_data_i    (read),
        .bus_error_i   (error_q)
    );

    wire        open = cyc && stb;

    // Of the clock before.
    reg         in_q;      // the cycle was open, and had no answer
    reg         valid_q;
    reg         ended_q;   // the device's answer
    reg         own_q;     // the request was that of the open cycle
    reg         write_q;
    reg  [11:0] address_q;
    reg  [31:0] data_q;
    reg         we_q;
    reg  [11:0] adr_q;
    reg  [31:0] dat_q;
    reg  [3:0]  sel_q;
    reg  [3:0]  open_q;    // clocks that the cycle has been open
    reg         dropped_q; // a request outlived its cycle, since the last answer

    wire        fresh = valid && (!valid_q || ended_q);
    wire        own   = valid && (fresh || own_q) && open && in_q;

    always @(posedge clk) begin
        begun     <= 1'b1;
        ready_q   <= !rst && judges;
        wrote_q   <= !rst && judges && write && !check && (verdict == 2'd0);
        error_q   <= verdict;
        waits_q   <= (rst || !valid || ready_q) ? 4'd0 : waits_q + 4'd1;
        in_q      <= !rst && open && !ack && !err;
        valid_q   <= !rst && valid;
        ended_q   <= ready_q;
        own_q     <= !rst && own;
        write_q   <= write;
        address_q <= address;
        data_q    <= data;
        we_q      <= we;
        adr_q     <= adr;
        dat_q     <= dat;
        sel_q     <= sel;
        open_q    <= (rst || !open || ack || err) ? 4'd0 : open_q + 4'd1;
        dropped_q <= !rst && !ack && (dropped_q || (valid && !open));

        if (!begun) begin
            assume (rst);
        end else if (!rst) begin
            assume (!(valid && !ready_q && waits_q == PATIENCE) || answers);
            if (in_q && open) begin
                assume (we == we_q && adr == adr_q && dat == dat_q && sel == sel_q);
            end

            // An answer ends an open cycle, and is its own request's.
            assert (!(ack && err));
            assert (open || !(ack || err));
            assert (!ack || (own && ready_q && error_q == 2'd0));
            assert (!err || (own && ready_q && error_q != 2'd0)
                    || (in_q && !valid && we && sel != 4'b1111));
            assert (!(ready_q && own) || ack || err);
            assert (!ack || dat_o == read);
            assert (open_q <= 2*PATIENCE + 4'd5);

            // What is written.
            assert (!wrote_q || own_q);
            assert (!wrote_q || ack || !open);
            assert (!wrote_q || !err);

            // What the device is asked for.
            if (fresh) begin
                assert (in_q && write == we_q && address == adr_q && data == dat_q);
                assert (!we_q || sel_q == 4'b1111);
            end
            if (valid_q && !ended_q) begin
                assert (valid && write == write_q && address == address_q && data == data_q);
            end
            assert (!ready_q || valid);
            assert (waits_q <= PATIENCE + 4'd1);

            cover (ack && wrote_q);
            cover (ack && !write && dropped_q);
            cover (err && ready_q);
            cover (err && !valid);
            cover (wrote_q && !open);
            cover (ack && ended_q == 1'b0 && open_q == 4'd9);
        end
    end

endmodule

`default_nettype wire
