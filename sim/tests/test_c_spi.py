# SPDX-License-Identifier: Apache-2.0
"""The C library and its example on SPI, compiled for a host MCU, against the RTL clock by clock."""

from __future__ import annotations

import re
import subprocess
import time
from pathlib import Path

import pytest
from test_c_library import CC, PATIENT_S, SOURCES, STRICT
from test_host_planes import SLOWER
from wavehaptics.host.scope.plug import VirtualPlug
from wavehaptics.ladder import verilated
from wavehaptics.runtime.repository import ROOT
from wavehaptics.runtime.terminals import check_terminals
from wavehaptics.runtime.toolchain import ToolError

CLOCK_HZ = 55_000_000
"""Of the board with surfaces."""
UPDATES = 20
EXAMPLE = ROOT / "examples" / "c"
DESIGN = verilated.Design(
    "wh_linked_device", "spi_shim.cpp",
    {"CLOCK_HZ": CLOCK_HZ, "N": 3, "WALLS": 2, "DELAY_LOG2": 2, "SURFACES": 8, "STREAM": 1,
     "SPI": 1},
)  # fmt: skip

pytestmark = pytest.mark.skipif(CC is None, reason="there is no C compiler")


def compiled(program: Path, *more: Path | str) -> str:
    """A program of the library, the files and the options."""
    command = [CC, *STRICT, "-O2", f"-I{SOURCES}", f"-I{EXAMPLE}", SOURCES / "wavehaptics.c"]
    subprocess.run([*map(str, (*command, *more)), "-lm", "-o", str(program)], check=True)
    return str(program)


@pytest.fixture(scope="module")
def mcu(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The program of an MCU, whose SPI ends at the RTL's pins; no POSIX is compiled into it."""
    library = verilated.build(DESIGN)
    return compiled(
        tmp_path_factory.mktemp("mcu") / "c_spi", EXAMPLE / "sphere.c",
        Path(__file__).with_name("c_spi.c"), "-DWH_NO_SERIAL", library,
        f"-Wl,-rpath,{library.parent}",
    )  # fmt: skip


@pytest.mark.parametrize("half", [3, 20])
def test_a_loop_of_a_host_mcu(mcu, half):
    """Angles, a plane and the force in each update; a lost bit is asked again."""
    done = subprocess.run(
        [mcu, str(CLOCK_HZ), str(half), str(UPDATES)], capture_output=True, text=True, timeout=120
    )
    result, root, clocks, moved, stamp, updates = done.stdout.split()
    assert (result, root) == ("0", "2")
    assert (int(stamp), int(updates)) == (UPDATES + 4, UPDATES + 5)
    # docs/c.md: 215 bytes an update, and 250 clocks beside them: 5.2 kHz at 55 MHz, 6 clocks a bit.
    assert int(moved) <= 215 * UPDATES
    assert int(clocks) <= 16 * half * int(moved) + 250 * UPDATES


def touched(program: str, port: str, gap: float) -> tuple[float, float]:
    """How deep the tip was in a ball so far away from it, mm, and the last force, N."""
    done = subprocess.run(
        [program, port, "20", str(gap), str(PATIENT_S)], capture_output=True, text=True,
        timeout=10 * PATIENT_S,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    found = re.fullmatch(r"20 updates, deepest (.*) mm, force (.*) N\n", done.stdout)
    assert found
    return float(found[1]), float(found[2])


def test_the_ball_over_a_serial_line(tmp_path):
    """Three motors of a virtual board, and a ball whose surface their tip is in from the start."""
    try:
        check_terminals()
    except ToolError as error:
        pytest.skip(str(error))
    program = compiled(tmp_path / "sphere", EXAMPLE / "sphere.c")
    scene = ROOT / "boards" / "ulx3s_three" / "board.toml"
    slower = [f"{key}={value}" for key, value in SLOWER.items()]
    plug = VirtualPlug(str(scene), slower, more=["--surfaces", "8"])
    try:
        until = time.monotonic() + 10 * PATIENT_S
        while plug.problem:
            assert plug.plugged, plug.problem
            assert time.monotonic() < until, plug.problem
            time.sleep(0.05)
        outside = touched(program, plug.port, 0.005)
        inside = touched(program, plug.port, -0.001)
        assert outside[0] == 0.0
        assert inside[0] > 0.99  # it began 1 mm deep
        assert inside[1] > 10 * outside[1]  # the current's noise
    finally:
        plug.close()
