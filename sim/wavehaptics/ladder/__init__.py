# SPDX-License-Identifier: Apache-2.0
"""The controllers that a scene runs on, and the run."""
