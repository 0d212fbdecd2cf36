# SPDX-License-Identifier: Apache-2.0
"""The motor and all that is around it: hand, brushes, heat, sensor, supply, bridge."""
