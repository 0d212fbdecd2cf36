# SPDX-License-Identifier: Apache-2.0
"""``python -m wavetools``."""

from wavetools.cli.main import main

main()
