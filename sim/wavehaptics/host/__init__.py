# SPDX-License-Identifier: Apache-2.0
"""A computer at the device's serial line, and a device of which there is no more than the line."""
