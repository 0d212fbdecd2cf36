# SPDX-License-Identifier: Apache-2.0
"""What makes it reliable: proofs, planted faults, coverage, a long random run."""
