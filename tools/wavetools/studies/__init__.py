# SPDX-License-Identifier: Apache-2.0
"""Runs whose results the pages show, and how fast the simulation is."""
