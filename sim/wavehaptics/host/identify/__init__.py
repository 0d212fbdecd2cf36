# SPDX-License-Identifier: Apache-2.0
"""A motor identified over the link: what is measured of it, step by step (docs/identify.md).

Each step is a function of recorded :class:`~.segments.Segment`; :mod:`.brushed` and
:mod:`.brushless` make the records on a device and ask the steps in turn.
"""
