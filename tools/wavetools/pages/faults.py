# SPDX-License-Identifier: Apache-2.0
"""The table of the guard's faults, of the rows that :mod:`wavehaptics.studies.fault_table` made."""

from __future__ import annotations

from typing import Any


def table(rows: list[dict[str, Any]]) -> str:
    """The rows as Markdown."""
    lines = ["| bit | fault | cause in the test | gates off after | at most |",
             "| --: | --- | --- | --: | --: |"]  # fmt: skip
    for row in rows:
        time = row["time_s"]
        shown = f"{time * 1e9:.0f} ns" if time < 1e-6 else f"{time * 1e6:.4g} µs"
        lines.append(
            f"| {row['bit']} | `{row['fault']}` | {row['cause']} | {shown}, {row['clocks']} clocks "
            f"| {row['limit_clocks']} clocks |"
        )
    return "\n".join(lines) + "\n"
