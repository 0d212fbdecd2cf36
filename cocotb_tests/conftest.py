# SPDX-License-Identifier: Apache-2.0
"""pytest: every test that asks for ``simulator`` runs once on each."""

from __future__ import annotations

import pytest
from simulators import SIMULATORS


@pytest.fixture(params=SIMULATORS)
def simulator(request: pytest.FixtureRequest) -> str:
    """Name of a simulator. A missing one is an error of its build, never a skipped test."""
    return request.param
