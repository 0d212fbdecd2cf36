# SPDX-License-Identifier: Apache-2.0
"""``python -m wavetools.cli.fault_table``: cause every fault, keep the times, fill the page."""

from __future__ import annotations

from wavehaptics.runtime.files import write_json
from wavehaptics.runtime.repository import ROOT
from wavehaptics.studies.fault_table import CASES, KEPT, measure

from wavetools.pages import faults, filler


def main() -> None:
    """Measure every fault, and write the numbers and the pages."""
    rows = [measure(case) for case in CASES]
    write_json(ROOT / KEPT, rows, indent=1)
    filler.write()
    print(faults.table(rows), end="")


if __name__ == "__main__":
    main()
