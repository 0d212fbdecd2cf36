# SPDX-License-Identifier: Apache-2.0
"""What is wired to a board: one table of parts, and all that is made from it.

``boards/wiring.toml`` names each part once. :mod:`parts` reads it, :mod:`spice` simulates the
circuits on which safety rests, :mod:`drawings` draws them, :mod:`pages` fills the tables of the
boards' pages. ``python -m wavetools.wiring`` makes drawings and tables anew.
"""
