# SPDX-License-Identifier: Apache-2.0
"""The live scope: a page on loopback that shows a device, and sets and stops it."""
