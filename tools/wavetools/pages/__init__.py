# SPDX-License-Identifier: Apache-2.0
"""Measured numbers in the pages that people read."""
