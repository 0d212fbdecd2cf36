# SPDX-License-Identifier: Apache-2.0
"""A board or a scene as the values that its RTL is built with."""
