# SPDX-License-Identifier: Apache-2.0
"""What a run leaves: its rows, metrics of them, pictures."""
