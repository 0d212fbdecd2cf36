# SPDX-License-Identifier: Apache-2.0
"""``python -m wavehaptics``: the command line without the installed script."""

from wavehaptics.cli.main import main

main()
