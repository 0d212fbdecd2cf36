# SPDX-License-Identifier: Apache-2.0
"""FuseSoC's generator of headers: ``wavehaptics.core`` says for what.

It is called with the path of a file that FuseSoC writes, and writes the headers and a core of them
into the working directory.
"""

from __future__ import annotations

import sys
from pathlib import Path

import yaml
from wavehaptics.fpga.boards import load_board, write_headers
from wavehaptics.fpga.scene_registers import as_text, scene_registers
from wavehaptics.runtime.files import write_text
from wavehaptics.scene import load_scene


def main(path: Path) -> None:
    asked = yaml.safe_load(path.read_text(encoding="utf-8"))
    parameters, here = asked["parameters"], Path.cwd()
    if board := parameters.get("board"):
        chosen = load_board(board)
        write_headers(chosen, here)
        names = list(chosen.headers())
    else:
        scene = load_scene(Path(asked["files_root"], parameters["scene"]))
        names = ["wh_scene.vh"]
        write_text(here / names[0], as_text(scene_registers(scene), "verilog"))
    core = {
        "name": asked["vlnv"],
        "filesets": {
            "headers": {
                "file_type": "verilogSource-2005",
                "files": [{name: {"is_include_file": True}} for name in names],
            }
        },
        "targets": {"default": {"filesets": ["headers"]}},
    }
    write_text(here / "headers.core", "CAPI=2:\n" + yaml.safe_dump(core))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
