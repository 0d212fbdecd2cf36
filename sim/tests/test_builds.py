# SPDX-License-Identifier: Apache-2.0
"""A library of the RTL that several ask for at a time is built once."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from wavehaptics.ladder import verilated


def test_who_comes_second_waits_for_the_first(monkeypatch, tmp_path: Path) -> None:
    built = []

    def build(top: str, arguments: object, target: Path, *_: object) -> None:
        built.append(top)
        time.sleep(0.2)
        target.touch()

    monkeypatch.setattr(verilated, "BUILD_DIR", tmp_path)
    monkeypatch.setattr(verilated, "_verilate", build)
    target = tmp_path / "wh_a-1.so"
    with ThreadPoolExecutor(3) as pool:
        found = list(pool.map(lambda _: verilated.verilate("wh_a", (), target), range(3)))
    assert found == [target] * 3
    assert built == ["wh_a"]
