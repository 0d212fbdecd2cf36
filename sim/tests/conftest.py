# SPDX-License-Identifier: Apache-2.0
"""Fixtures for tests that need a scene and its simulation."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from wavehaptics.scene import Scene, load_scene

BASE = """
[scene]
name = "test"
duration_s = 0.1
[motor]
preset = "re25-118743"
[controller]
tick_hz = 1e6
lambda = 1e4
"""


@pytest.fixture
def make_scene(tmp_path: Path) -> Callable[..., Scene]:
    """A function that makes a scene of ``table.key=value`` settings on the paper's motor."""
    path = tmp_path / "scene.toml"
    path.write_text(BASE)
    return lambda *settings: load_scene(path, settings)
