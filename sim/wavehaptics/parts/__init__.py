# SPDX-License-Identifier: Apache-2.0
"""What makers say of their motors and ADCs."""
