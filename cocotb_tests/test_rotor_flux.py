# SPDX-License-Identifier: Apache-2.0
"""Runs :mod:`tb_rotor_flux` on each simulator."""

from simulators import simulate


def test_rotor_flux(simulator: str) -> None:
    simulate(simulator, "wh_rotor_flux", "tb_rotor_flux")
