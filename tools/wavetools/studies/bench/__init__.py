# SPDX-License-Identifier: Apache-2.0
"""How fast the simulation is, what was tried to make it faster, and how fast others are."""
