# SPDX-License-Identifier: Apache-2.0
"""A motor identified over the link: what is measured of it, step by step (docs/identify.md).

Each step is a function of recorded :class:`~.segments.Segment`; :mod:`.procedure` makes the
records on a device and asks the steps in turn.
"""
