# SPDX-License-Identifier: Apache-2.0
"""From a board and the RTL to a bitstream, its numbers and its netlist in a loop."""
