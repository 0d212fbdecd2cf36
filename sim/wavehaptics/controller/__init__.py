# SPDX-License-Identifier: Apache-2.0
"""The controller as integers, bit for bit the RTL's, and its settings from SI units."""
