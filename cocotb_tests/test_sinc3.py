# SPDX-License-Identifier: Apache-2.0
"""How wh_sinc3 takes its pins; its bench is in ``benches.toml``."""

import json
import os
from pathlib import Path

import pytest
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.toolchain import Toolchain


@pytest.mark.parametrize("capture_rise", [0, 1])
def test_a_pin_ends_in_a_flip_flop(tmp_path: Path, capture_rise: int) -> None:
    """One, and without logic before it: what a late edge spoils is a bit, and never a sum."""
    lines = 2
    parts = "wh_sinc3", "wh_round", "wh_saturate"
    made = tmp_path / "sinc3.json"
    script = (
        f"read_verilog -Irtl {' '.join(f'rtl/{part}.v' for part in parts)};"
        f" chparam -set LINES {lines} -set CAPTURE_RISE {capture_rise} wh_sinc3;"
        " hierarchy -top wh_sinc3; proc; flatten; opt; write_json"
    )
    relative = os.path.relpath(made, ROOT)
    log = tmp_path / "yosys.log"
    failed = Toolchain.of_environment().run("yosys", ["-p", f"{script} {relative}"], ROOT, log)
    assert not failed, log.read_text("utf-8")
    module = json.loads(made.read_bytes())["modules"]["wh_sinc3"]
    pins = module["ports"]["adc_sdata_i"]["bits"]
    assert len(pins) == lines
    for pin in pins:
        seen = [
            (cell["type"], port)
            for cell in module["cells"].values()
            for port, bits in cell["connections"].items()
            if pin in bits
        ]
        assert seen == [("$dff", "D")]
