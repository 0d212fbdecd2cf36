# SPDX-License-Identifier: Apache-2.0
"""A checkout in a folder whose name make, a shell or Verilator doesn't take as it is."""

from __future__ import annotations

import os
import shutil
import subprocess
import sysconfig
import venv
from pathlib import Path

import pytest
from wavehaptics.runtime import plain_paths
from wavehaptics.runtime.plain_paths import cache, is_plain, plain, workplace
from wavehaptics.runtime.repository import BUILD, ROOT

TIMEOUT_S = 900
ODD = "wave (haptics) jörg's"


@pytest.fixture
def home(tmp_path, monkeypatch) -> Path:
    """Where links and workplaces go in these tests."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    return tmp_path / "home" / "wavehaptics"


@pytest.mark.parametrize(
    ("path", "right"),
    [
        ("/home/a-b/wave.haptics_2+3@x/~", True),
        ("/tmp/a b", False),
        ("/tmp/jörg", False),
        ("/tmp/a(b)", False),
        ("/tmp/a,b", False),  # of -Wl,-rpath,PATH
        ("/tmp/100%", False),  # of make's rules
        ("/tmp/o'neil", False),
        ("/tmp/$HOME", False),
        ("/tmp/a\nb", False),
        ("/tmp/\udcfc", False),  # bytes that are no UTF-8
    ],
)
def test_what_is_plain(path, right):
    assert is_plain(Path(path)) is right


def test_a_link_to_the_tree(tmp_path, home):
    tree = tmp_path / "my projects" / ODD
    (tree / "rtl").mkdir(parents=True)
    (tree / "rtl" / "a.v").write_text("here")
    assert plain(tmp_path) == tmp_path
    seen = plain(tree / "rtl" / "a.v")
    assert is_plain(seen)
    assert seen.read_text() == "here"
    assert seen == plain(tree) / "rtl" / "a.v"
    assert plain(tree).parent == home
    assert list(home.iterdir()) == [plain(tree)]
    assert plain(tmp_path / "my projects" / "other") != plain(tree)


def test_a_link_that_is_wrong_or_gone_is_made_again(tmp_path, home):
    tree = tmp_path / ODD
    tree.mkdir()
    link = plain(tree)
    link.unlink()
    link.symlink_to(tmp_path)
    assert plain(tree) == link
    assert link.resolve() == tree
    shutil.rmtree(home)
    assert plain(tree).resolve() == tree


def test_no_link_can_be_made(tmp_path, monkeypatch):
    """The path itself is all that there is; a build tells it."""
    monkeypatch.setattr(plain_paths, "cache", lambda: tmp_path / "nowhere")
    assert plain(tmp_path / ODD) == tmp_path / ODD


def test_a_home_whose_path_is_not_plain(tmp_path, monkeypatch):
    monkeypatch.setattr(plain_paths, "_BESIDE", tmp_path / "beside")
    for home in (str(tmp_path / "jörg"), "relative", "/proc/nowhere"):
        monkeypatch.setenv("XDG_CACHE_HOME", home)
        assert cache() == tmp_path / "beside"
    assert cache().stat().st_mode & 0o777 == 0o700
    assert not (tmp_path / "jörg").exists()


def test_a_workplace(tmp_path, home):
    """A build really is where the path is plain, and is found where it is looked for."""
    assert workplace(tmp_path / "build" / "verilated") == tmp_path / "build" / "verilated"
    folder = tmp_path / ODD / "build" / "verilated"
    made = workplace(folder)
    (made / "log").write_text("made")
    assert (folder / "log").read_text() == "made"
    assert is_plain(made.resolve())
    assert workplace(folder) == made
    shutil.rmtree(home)
    assert not any(workplace(folder).iterdir())


def test_a_workplace_of_a_tree_that_was_moved(tmp_path, home):
    folder = workplace(tmp_path / "tree" / "build")
    (folder / "log").write_text("made")
    (tmp_path / "tree").rename(tmp_path / ODD)
    made = workplace(tmp_path / ODD / "build")
    assert (made / "log").read_text() == "made"
    assert is_plain(made.resolve())
    (tmp_path / ODD).rename(tmp_path / "tree")
    assert (workplace(tmp_path / "tree" / "build") / "log").read_text() == "made"


def test_make_refuses_a_colon(tmp_path):
    """It would end the folder's name in PATH."""
    folder = tmp_path / "a:b"
    folder.mkdir()
    shutil.copy(ROOT / "Makefile", folder)
    done = subprocess.run(
        ["make", "help"], cwd=folder, capture_output=True, text=True, check=False
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "has a colon, which ends a folder's name in PATH; rename it" in done.stderr


COPIED = (
    "Makefile", "boards", "cocotb_tests", "conftest.py", "pyproject.toml", "requirements",
    "rtl", "sim/setup", "sim/verilated", "sim/wavehaptics", "tools",
)  # fmt: skip
INSIDE = ("cocotb", "cocotb_tools", "verilator")
"""Packages whose own place matters: make and the linker get it."""


@pytest.fixture
def odd_tree(tmp_path) -> Path:
    """A checkout whose environment has these packages in it, and all others from this one."""
    tree = tmp_path / "my projects" / ODD
    for name in COPIED:
        if (ROOT / name).is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, tree / name, ignore=ignored)
        else:
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, tree / name)
    venv.create(tree / ".venv", with_pip=False)
    (site,) = (tree / ".venv" / "lib").glob("python*/site-packages")
    ours = Path(sysconfig.get_path("purelib"))
    for package in INSIDE:
        shutil.copytree(ours / package, site / package)
    (site / "here.pth").write_text("../../../../sim\n../../../../tools\n")
    (site / "others.pth").write_text(f"{ours}\n")
    subprocess.run(["sh", "sim/setup/verilator.sh"], cwd=tree, check=True)
    (tree / ".venv" / ".ready").write_text(f"{tree}\n")
    return tree


@pytest.mark.long
def test_it_builds_and_runs_there(tmp_path, home, odd_tree):
    """make with Verilator's front end, and a bench on both simulators."""
    shared = os.environ.get("CCACHE_DIR", str(BUILD / "ccache"))
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST", "MAKE"))}
    environment |= {"CCACHE_DIR": shared, "NUMBA_CACHE_DIR": str(home / "numba")}
    for command in (
        ["make", "lint-rtl", "LINT_CASES=wh_quadrature", "TOOLCHAIN=wheel"],
        [".venv/bin/python", "-m", "pytest", "-q", "-p", "no:cacheprovider",
         "cocotb_tests/test_benches.py", "-k", "quadrature"],
    ):  # fmt: skip
        done = subprocess.run(
            command, cwd=odd_tree, env=environment, capture_output=True, text=True,
            timeout=TIMEOUT_S, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
    assert "2 passed" in done.stdout
    made = odd_tree / "build" / "cocotb" / "tb_quadrature-wh_quadrature" / "verilator"
    assert (made / "test.log").exists()
    assert is_plain(made.resolve())
