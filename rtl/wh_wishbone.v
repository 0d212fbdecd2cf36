// SPDX-License-Identifier: Apache-2.0
//
// wh_wishbone: a classic Wishbone slave in front of the register bus of wh_device.
//
// A cycle lasts while cyc_i and stb_i are high. ack_o or err_o ends it, for one clock; the next cycle may
// begin in the clock after, with stb_i still high. Addresses count registers of 32 bits (docs/words.md):
// adr_i is a byte address divided by 4. A read returns all 32 bits, whatever sel_i is. err_o ends:
//   - a write with sel_i != 4'b1111, which does nothing and doesn't reach the device;
//   - what the device refuses: no such register, or it can't be written or read; a value outside its range;
//     a setting that can't change now. A refused write changes nothing.
//
// The request is latched when the cycle begins. A master should hold cyc_i and stb_i until the answer. If it
// gives the cycle up earlier, the device ends the request as a check (bus_check), so nothing is written,
// and the answer is dropped. A write takes effect with the answer: only a cycle that is given up in the very
// clock of its answer may have written. A cycle that begins meanwhile waits until the device is free.
//
// Latency: 1 clock, and what wh_registers takes: 6 clocks from stb_i to ack_o, of a partial write
// 2. After reset the first cycle waits until the device is ready (ready_o).
// Reset: no cycle is open; reset the device with it.

`default_nettype none

module wh_wishbone (
    input  wire        clk,
    input  wire        rst,

    // Wishbone, classic cycles of 32 bits.
    input  wire        cyc_i,
    input  wire        stb_i,
    input  wire        we_i,
    input  wire [11:0] adr_i,         // in registers of 32 bits
    input  wire [31:0] dat_i,
    input  wire [3:0]  sel_i,
    output wire [31:0] dat_o,         // valid with ack_o
    output wire        ack_o,
    output wire        err_o,

    // The register bus of wh_device.
    output wire        bus_valid_o,   // held until bus_ready_i, as are the outputs below but bus_check_o
    output wire        bus_write_o,
    output wire        bus_check_o,   // the cycle was given up: write nothing
    output wire [11:0] bus_address_o,
    output wire [31:0] bus_data_o,
    input  wire        bus_ready_i,   // strobe
    input  wire [31:0] bus_data_i,
    input  wire [1:0]  bus_error_i    // 0: done
);

    reg        busy_q;        // the device has a request
    reg        given_up_q;    // whose cycle is over
    reg        partial_q;     // a partial write is refused in this clock
    reg        write_q;
    reg [11:0] address_q;
    reg [31:0] data_q;

    wire open     = cyc_i && stb_i;
    wire partial  = we_i && (sel_i != 4'b1111);
    wire begins   = open && !busy_q && !partial_q;
    wire answered = busy_q && bus_ready_i && open && !given_up_q;

    assign bus_valid_o   = busy_q;
    assign bus_write_o   = write_q;
    assign bus_check_o   = given_up_q || !open;
    assign bus_address_o = address_q;
    assign bus_data_o    = data_q;

    assign dat_o = bus_data_i;
    assign ack_o = answered && (bus_error_i == 2'd0);
    assign err_o = (answered && (bus_error_i != 2'd0)) || (partial_q && open);

    always @(posedge clk) begin
        if (rst) begin
            busy_q     <= 1'b0;
            given_up_q <= 1'b0;
            partial_q  <= 1'b0;
        end else begin
            busy_q     <= (begins && !partial) || (busy_q && !bus_ready_i);
            given_up_q <= busy_q && !bus_ready_i && (given_up_q || !open);
            partial_q  <= begins && partial;
        end
        if (begins) begin
            write_q   <= we_i;
            address_q <= adr_i;
            data_q    <= dat_i;
        end
    end

endmodule

`default_nettype wire
