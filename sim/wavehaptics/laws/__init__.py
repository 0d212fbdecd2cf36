# SPDX-License-Identifier: Apache-2.0
"""Closed forms of the physics, and choices made by them, in SI units."""
