# SPDX-License-Identifier: Apache-2.0
"""Formats and codes of the words that cross a border, their table and what is made of it."""
