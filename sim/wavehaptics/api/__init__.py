# SPDX-License-Identifier: Apache-2.0
"""What a Python program uses by ``import wavehaptics``: scenes, runs, sweeps and boards."""
