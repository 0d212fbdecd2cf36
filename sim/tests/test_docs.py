# SPDX-License-Identifier: Apache-2.0
"""``make docs``: the pages build without a warning, need no network, and a broken link fails."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from wavehaptics.runtime.repository import ROOT

PYTHON = ROOT / ".venv-docs" / "bin" / "python"
TIMEOUT_S = 1200

pytestmark = pytest.mark.skipif(not PYTHON.exists(), reason="`make docs` makes .venv-docs")


def build(source: Path, out: Path) -> subprocess.CompletedProcess[str]:
    options = ("-q", "-E", "-W", "--keep-going", "-b", "html", "-c", "docs", "-d", str(out / "d"))
    return subprocess.run(
        [PYTHON, "-m", "sphinx", *options, ".", str(out / "html")],
        cwd=source, capture_output=True, text=True, timeout=TIMEOUT_S, check=False,
    )  # fmt: skip


FETCHED = re.compile(r"<(?:script|img|link|iframe)\b[^>]*?\b(?:src|href)=\"(?:https?:)?//[^\"]*")


def test_pages_build_without_a_warning_and_need_no_network(tmp_path):
    made = build(ROOT, tmp_path)
    assert made.returncode == 0, made.stderr
    html = tmp_path / "html"
    front = (html / "index.html").read_text(encoding="utf-8")
    assert "motor's own inductance" in front.replace("’", "'")
    assert (html / "source" / "rtl" / "wh_anchor.v.html").exists()
    reference = html / "build" / "api" / "wavehaptics" / "laws" / "closed_forms" / "index.html"
    assert "filter_stiffness" in reference.read_text(encoding="utf-8")
    pages = list(html.rglob("*.html"))
    assert len(pages) > 100
    for page in pages:
        assert FETCHED.findall(page.read_text(encoding="utf-8")) == [], page


@pytest.mark.parametrize(
    ("link", "told"),
    [("docs/nowhere.md", "nowhere"), ("#no-such-place", "no-such-place"), ("a.v", "a.v")],
)
def test_a_link_that_leads_nowhere_fails(tmp_path, link, told):
    source = tmp_path / "source"
    for name in ("conf.py", "source_pages.py"):
        (source / "docs").mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / "docs" / name, source / "docs")
    shutil.copy(ROOT / "pyproject.toml", source)
    package = source / "sim" / "wavehaptics"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text('"""A package."""\n')
    (source / "README.md").write_text(f"# Title\n\nA [link]({link}).\n")
    made = build(source, tmp_path)
    assert made.returncode != 0
    assert [line for line in made.stderr.splitlines() if told in line and "README" in line]
