# SPDX-License-Identifier: Apache-2.0
"""What pyproject.toml can't say: a wheel has copies of the files that simulations read.

They are at the repository's own paths below ``wavehaptics/_repository``, where
``wavehaptics.runtime.repository`` finds them. An editable installation reads the files themselves.
"""

from glob import glob
from os.path import isfile
from pathlib import Path
from shutil import rmtree

from setuptools import setup
from setuptools.command.build_py import build_py

READ_BY_SIMULATIONS = (
    "rtl/*.v", "rtl/*.vh", "rtl/*.toml", "sim/verilated/*", "sim/scenes/*.toml",
    "boards/sensing.toml", "boards/summary.json",
)  # fmt: skip


class BuildWithCopies(build_py):
    def copies(self) -> dict[str, str]:
        """Paths of the copies in the build, by those of the files."""
        target = Path(self.build_lib, "wavehaptics", "_repository")
        found = (path for pattern in READ_BY_SIMULATIONS for path in sorted(glob(pattern)))
        return {path: str(target / path) for path in found if isfile(path)}

    def run(self) -> None:
        if not self.editable_mode:
            # What an earlier build left would be in the wheel as well.
            rmtree(Path(self.build_lib, "wavehaptics"), ignore_errors=True)
        super().run()
        if not self.editable_mode:
            for path, copy in self.copies().items():
                self.mkpath(str(Path(copy).parent))
                self.copy_file(path, copy)

    def get_source_files(self) -> list[str]:
        return [*super().get_source_files(), *self.copies()]


setup(cmdclass={"build_py": BuildWithCopies})
