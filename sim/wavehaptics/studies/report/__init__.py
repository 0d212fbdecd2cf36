# SPDX-License-Identifier: Apache-2.0
"""The report: sweeps → JSON → pictures → one HTML page.

Each section is a module with ``TITLE``, ``tasks(quick)``, ``gather(tasks, results)``, which makes
the section's JSON of the tasks' results, and ``show(data, folder)``, which draws its pictures into
the folder and returns the section's blocks from that JSON alone.
"""
