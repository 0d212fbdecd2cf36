# SPDX-License-Identifier: Apache-2.0
"""Small faults planted by a tool, one at a time, that the tests have to see: formal/MUTATE.md."""
