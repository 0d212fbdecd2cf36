# SPDX-License-Identifier: Apache-2.0
"""Steps a second and error of motulator on the machine that is nearest to a DC motor.

Run by the interpreter that has that package; prints one line of JSON. It has no DC motor: a
synchronous machine that stands still is a winding with ``L di/dt = u − R i`` in each axis. The
controller gives the voltages of each period; the model is solved with the package's own settings.
"""

import json
import math
import sys
import time
from importlib.metadata import version

import numpy as np
from motulator.drive import model
from motulator.drive.utils import SynchronousMachinePars

PERIOD_S = 250e-6
BUS_V = 540.0
R_OHM, L_H = 3.6, 0.036


class SquareWave:
    """A control system that gives a duty cycle along the d axis, up and down."""

    def __init__(self) -> None:
        self.n = 0

    def __call__(self, mdl):
        duty = 0.02 * math.copysign(1.0, math.sin(0.05 * self.n))
        self.n += 1
        return PERIOD_S, [0.5 + duty, 0.5 - duty / 2, 0.5 - duty / 2]

    def post_process(self) -> None:
        """Nothing is kept."""


def main(steps: int) -> None:
    """Time ``steps`` control periods, and compare the current with the exact one."""
    par = SynchronousMachinePars(n_p=3, R_s=R_OHM, L_d=L_H, L_q=L_H, psi_f=0.545)
    machine = model.SynchronousMachine(par)
    drive = model.Drive(
        model.VoltageSourceConverter(u_dc=BUS_V), machine, model.ExternalRotorSpeed(lambda t: 0 * t)
    )
    simulation = model.Simulation(drive, SquareWave())
    began = time.process_time()
    simulation.simulate(t_stop=(steps - 1) * PERIOD_S)
    seconds = time.process_time() - began
    t = np.asarray(machine.data.t if hasattr(machine.data, "t") else drive.converter.data.t)
    volts = np.real(drive.converter.data.u_cs)
    found = np.real(machine.data.i_ss)
    exact = np.empty(len(t))
    current = found[0]
    for n in range(len(t)):
        if n:
            final = volts[n] / R_OHM  # u holds from the sample before to this one
            current = final + (current - final) * math.exp(-R_OHM / L_H * (t[n] - t[n - 1]))
        exact[n] = current
    error = math.sqrt(np.mean((found - exact) ** 2)) / np.abs(exact).max()
    print(
        json.dumps(
            {
                "name": "motulator",
                "version": version("motulator"),
                "what": f"synchronous machine at rest, its own solver: a period of "
                f"{1e6 * PERIOD_S:g} µs",
                "steps": steps,
                "ended_early": 0,
                "step_s": PERIOD_S,
                "steps_per_s": steps / seconds,
                "simulated_s_per_s": steps * PERIOD_S / seconds,
                "current_error": error,
            }
        )
    )


if __name__ == "__main__":
    main(int(sys.argv[1]))
