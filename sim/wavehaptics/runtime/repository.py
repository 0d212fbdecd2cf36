# SPDX-License-Identifier: Apache-2.0
"""Where the repository stands, which the package reads scenes, RTL and shims from."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
"""The repository."""

SHIMS = ROOT / "sim" / "verilated"
"""The C++ between the compiled loops and Verilated RTL, and Verilog tops of it."""

CELLS = ROOT / "sim" / "cells"
"""Models of cells that Yosys' libraries have as black boxes."""
