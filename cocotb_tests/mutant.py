# SPDX-License-Identifier: Apache-2.0
"""One run of a bench with a mutant in its design: ``python mutant.py JOB.json NUMBER``.

The job's keys are :func:`simulators.simulate`'s arguments. Ends with 0 where all tests pass, 1
where one fails, 2 where nothing could be built. A process of its own, because a mutant may well
hang, and is then killed with its simulator.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from simulators import SimulationError, simulate

PASSED, FAILED, NOT_BUILT = 0, 1, 2


def main(job: Path, number: int) -> int:
    told = json.loads(job.read_text(encoding="utf-8"))
    told["sources"] = [Path(source) for source in told["sources"]]
    try:
        simulate("verilator", **told, plusargs=[f"+mutant={number}"])
    except SimulationError as error:
        print(error)
        return NOT_BUILT if str(error).startswith("build failed") else FAILED
    return PASSED


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), int(sys.argv[2])))
