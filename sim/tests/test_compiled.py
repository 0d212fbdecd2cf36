# SPDX-License-Identifier: Apache-2.0
"""What makes numba compile anew, and what doesn't: counted in processes of their own."""

from __future__ import annotations

import importlib
import json
import os
import pkgutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import wavehaptics
from numba.core.dispatcher import Dispatcher
from wavehaptics.ladder import brushless_pins, pins_loop
from wavehaptics.runtime import compiled
from wavetools.fpga import board_simulation

TIMEOUT_S = 120

LEAVES = '''\
"""A module of leaves."""
from typing import NamedTuple
from wavehaptics.runtime.compiled import compiled
STEP = 3
UNUSED = 5
class Word(NamedTuple):
    top: int
WORD = Word(255)
@compiled()
def step(x):
    """A step."""
    return x + STEP
@compiled()
def other(x):
    return x - 1
'''
TREE = """\
import leaves
from wavehaptics.runtime.compiled import compiled, compiled_counting
@compiled()
def walk(x):
    return leaves.step(x) * 2 & leaves.WORD.top
@compiled_counting()
def climb(x):
    return walk(x) + 1
"""
ASK = """\
import json, tree, leaves
found = tree.climb(1)
stats = [function.stats for function in (tree.climb, tree.walk, leaves.step)]
print(json.dumps([found, sum(sum(one.cache_misses.values()) for one in stats)]))
"""


@pytest.fixture
def asked(tmp_path):
    """A function that runs the modules and says what came out and what had to be compiled."""
    (tmp_path / "leaves.py").write_text(LEAVES)
    (tmp_path / "tree.py").write_text(TREE)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "kept")}

    def ask(**more: str) -> tuple[int, int]:
        done = subprocess.run(
            [sys.executable, "-c", ASK], cwd=tmp_path, env=environment | more, timeout=TIMEOUT_S,
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        return tuple(json.loads(done.stdout))

    return ask


def change(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


HARMLESS = (
    ("leaves.py", "STEP = 3", "# A comment\n\n\nSTEP = 3"),
    ("leaves.py", '"""A step."""', '"""A step of three,\n\n    and no more."""'),
    ("leaves.py", "return x - 1", "return x - 2"),
    ("leaves.py", "UNUSED = 5", "UNUSED = 6"),
    ("tree.py", "import leaves", "import leaves  # more"),
)
"""Changes that say nothing to what is called, but for the lines that it stands in."""
TELLING = (
    ("leaves.py", "STEP = 3", "STEP = 4", 11, 3),
    ("leaves.py", "return x + STEP", "return x + STEP + 4", 19, 3),
    ("leaves.py", "WORD = Word(255)", "WORD = Word(16)", 17, 2),
    ("tree.py", "return walk(x) + 1", "return walk(x) + 2", 18, 1),
    ("tree.py", "@compiled_counting()", "@compiled_counting(fastmath=True)", 18, 1),
)
"""One upon the other, with what is found then and how many functions are compiled for it."""


def test_only_what_is_changed_is_compiled_anew(asked, tmp_path):
    """It, and what calls it; and back again nothing is, as both are kept."""
    assert asked() == (9, 3)
    for file, old, new in HARMLESS:
        change(tmp_path / file, old, new)
    # Nor is it for what a test bench is told of itself.
    assert asked(WH_PARAMETERS='{"N": 3}', WH_DEFINES="{}", WH_SEED="4") == (9, 0)
    for file, old, new, found, compiled_anew in TELLING:
        change(tmp_path / file, old, new)
        assert asked() == (found, compiled_anew), new
    for file, old, new, _, _ in TELLING:
        change(tmp_path / file, new, old)
    assert asked() == (9, 0)


def dispatchers() -> dict[str, Dispatcher]:
    """Every compiled function of the package by its full name."""
    found = {}
    for info in pkgutil.walk_packages(wavehaptics.__path__, "wavehaptics."):
        if not info.name.endswith(("__main__", "bench.once")):
            module = importlib.import_module(info.name)
            for name, value in vars(module).items():
                if isinstance(value, Dispatcher) and value.py_func.__module__ == info.name:
                    found[f"{info.name}.{name}"] = value
    return found


def test_every_function_of_the_package_is_kept_by_its_sources(monkeypatch):
    """And none by the whole package, for want of a way to look into what it uses."""

    def whole() -> str:
        raise AssertionError("something that can't be looked into")

    monkeypatch.setattr(compiled, "_whole_package", whole)
    found = dispatchers()
    assert len(found) > 90
    for name, dispatcher in found.items():
        assert isinstance(dispatcher._cache, compiled._KeptBySources), name
        assert compiled.sources_digest(dispatcher), name


def test_other_word_lengths_are_other_code():
    """Of the waves, not of the contact, which has no such words."""
    ask = (
        "from wavehaptics.controller import wave_core;"
        "from wavehaptics.runtime import compiled;"
        "print(compiled.sources_digest(wave_core.wave_core_step),"
        "      compiled.sources_digest(wave_core.contact_step))"
    )
    digests = [
        subprocess.run(
            [sys.executable, "-c", ask], env=os.environ | width, timeout=TIMEOUT_S,
            capture_output=True, text=True, check=True,
        ).stdout.split()
        for width in ({}, {}, {"WH_STATE_GUARD": "4"})
    ]  # fmt: skip
    assert digests[0] == digests[1]
    assert digests[0][0] != digests[2][0]
    assert digests[0][1] == digests[2][1]


@compiled.compiled_drawing
def drawn(rng, most, below):
    """The first draw below ``below``, and how many there were."""
    value, draws = rng.standard_normal(), 1
    while draws < most and value >= below:
        value, draws = rng.standard_normal(), draws + 1
    return value, draws


def test_a_loop_that_draws_leaves_its_generator_as_it_was():
    """But for what it has drawn: as numpy draws, and no count of it is kept or lost."""
    rng, same = np.random.default_rng(5), np.random.default_rng(5)
    first, count = drawn(rng, 100, -1.0)
    assert count > 1
    assert [same.standard_normal() for _ in range(count)][-1] == first
    counts = sys.getrefcount(rng), sys.getrefcount(rng.bit_generator)
    for _ in range(100):
        drawn(rng, 2, 0.0)
    assert (sys.getrefcount(rng), sys.getrefcount(rng.bit_generator)) == counts


def test_loops_that_clock_an_rtl_count_no_references():
    """Not once in each clock: half of the time of `pins` was spent on that."""
    loops = (
        pins_loop.advance, brushless_pins.rest, brushless_pins._advance, board_simulation._rest,
    )  # fmt: skip
    for entered in loops:
        (inner,) = [cell.cell_contents for cell in entered.py_func.__closure__]
        assert inner.targetoptions["_nrt"] is False, entered


PLAIN = """
from wavehaptics.controller.wave_core import saturate
assert saturate is saturate.py_func
print(saturate(1 << 60), saturate.py_func(-(1 << 60)))
"""


def test_without_the_compiler_the_functions_are_those_of_python():
    """As in `make coverage`; whoever asks for ``py_func`` gets the same."""
    done = subprocess.run(
        [sys.executable, "-c", PLAIN], env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        timeout=TIMEOUT_S, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    high, low = map(int, done.stdout.split())
    assert high == -low - 1 > 0
