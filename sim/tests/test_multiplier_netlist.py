# SPDX-License-Identifier: Apache-2.0
"""A multiplier as the UP5K's blocks, where a coefficient's highest bits are known to be 0.

Then Yosys makes a product narrower than the register behind it, and takes that into the block.
"""

import shutil
import subprocess
from pathlib import Path

import pytest
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain
from wavetools.fpga.synthesis import synthesis_command

TOP = """
`include "wh_formats.vh"
module known_sign #(
    parameter integer BITS = 26
) (
    input wire clk, input wire take, input wire signed [`WH_DATA_W-1:0] data,
    input wire [BITS-1:0] coef, output wire signed [`WH_DATA_W+`WH_COEF_W-1:0] product
);
    wh_multiply multiply (
        .clk(clk), .take_i(take), .data_i(data), .product_o(product),
        .coef_i({{(`WH_COEF_W - BITS){1'b0}}, coef})
    );
endmodule
"""

BENCH = """
`timescale 1ns / 1ps
module bench;
    localparam integer BITS = `BITS;
    reg clk = 0, take = 1;
    reg signed [30:0] data = 0;
    reg [BITS-1:0] coef = 0;
    wire signed [57:0] product;
    reg signed [57:0] first, second, third;
    integer n, wrong = 0, checked = 0;
    known_sign dut (.clk(clk), .take(take), .data(data), .coef(coef), .product(product));
    always #50 clk = !clk;
    always @(posedge clk) begin
        first <= data * $signed({1'b0, coef});
        second <= first;
        third <= second;
    end
    initial begin
        for (n = 0; n < 2000; n = n + 1) begin
            @(posedge clk); #10;
            if (n > 5) begin
                checked = checked + 1;
                if (product !== third) wrong = wrong + 1;
            end
            data = $random;
            coef = n[0] ? $random : $random & 1023;
        end
        $display("%0d wrong of %0d", wrong, checked);
        $finish;
    end
endmodule
"""


@pytest.mark.parametrize("bits", [26, 25, 24, 20, 17])
def test_no_bit_of_a_product_is_lost(bits: int, tmp_path: Path) -> None:
    tools = Toolchain.of_environment()
    (tmp_path / "top.v").write_text(TOP, encoding="utf-8")
    (tmp_path / "bench.v").write_text(BENCH, encoding="utf-8")
    for name in ("wh_formats.vh", "wh_multiply.v"):
        shutil.copy(ROOT / "rtl" / name, tmp_path)
    script = (
        f"read_verilog top.v wh_multiply.v; chparam -set BITS {bits} known_sign; "
        f"{synthesis_command('ice40', 'up5k')} -top known_sign; "
        "select -assert-count 4 t:SB_MAC16; write_verilog -noattr -noexpr net.v"
    )
    log = tmp_path / "yosys.log"
    assert not tools.run("yosys", ["-p", script], tmp_path, log), log.read_text(encoding="utf-8")
    files = [str(tmp_path / "bench.v"), str(tmp_path / "net.v"),
             str(tools.share() / "ice40" / "cells_sim.v")]  # fmt: skip
    program = tmp_path / "bench"
    subprocess.run(
        ["iverilog", "-g2012", "-DNO_ICE40_DEFAULT_ASSIGNMENTS", "-DICE40_U", f"-DBITS={bits}",
         "-o", str(program), *files],
        check=True, capture_output=True,
    )  # fmt: skip
    shown = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout
    assert shown.strip() == "0 wrong of 1994"
