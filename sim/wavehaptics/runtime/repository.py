# SPDX-License-Identifier: Apache-2.0
"""Where things stand: what the package reads of the repository, and where it builds.

In a checkout these are the repository's own files, and the folder ``build`` in it. An installed
package has copies of those that simulations need (``setup.py`` lists them), and builds in a cache
of the user's. No other module asks for its own place.
"""

from __future__ import annotations

from pathlib import Path

from wavehaptics.runtime.plain_paths import cache, plain

PACKAGE = Path(__file__).resolve().parents[1]
"""The package's own folder."""

_COPIES = PACKAGE / "_repository"

INSTALLED = _COPIES.is_dir()
"""Whether the package was installed without the repository, of which it has some files."""

ROOT = plain(_COPIES if INSTALLED else PACKAGE.parents[1])
"""The repository, or the copies of its files at the same paths."""

RTL_DIR = ROOT / "rtl"
"""The design, its formats and its table of words."""

SCENES_DIR = ROOT / "sim" / "scenes"
"""The shipped scenes."""

SHIMS = ROOT / "sim" / "verilated"
"""The C++ between the compiled loops and Verilated RTL, and Verilog tops of it."""

CELLS = ROOT / "sim" / "cells"
"""Models of cells that Yosys' libraries have as black boxes."""

BUILD = cache() if INSTALLED else ROOT / "build"
"""Where compiled code is kept, and results that may be wanted again."""
