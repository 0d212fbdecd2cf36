# SPDX-License-Identifier: Apache-2.0
"""How code is compiled, read and run; it knows nothing of motors."""
