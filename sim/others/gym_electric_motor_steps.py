# SPDX-License-Identifier: Apache-2.0
"""Steps a second and error of gym-electric-motor on its permanently excited DC motor.

Run by the interpreter that has that package; prints one line of JSON. The environment is made with
its own settings: a DC motor at a constant speed, driven by the voltage of each step, so that
``L di/dt = u − R i − ψ ω`` has an exact solution between two steps.
"""

import json
import math
import sys
import time
from importlib.metadata import version

import gym_electric_motor as gem
import numpy as np

ENVIRONMENT = "Cont-CC-PermExDc-v0"


def main(steps: int) -> None:
    """Time ``steps`` steps, and compare the current with the exact one."""
    env = gem.make(ENVIRONMENT)
    system = env.unwrapped.physical_system
    motor = system.electrical_motor.motor_parameter
    names, limits = list(system.state_names), system.limits
    i_at, u_at, omega_at = names.index("i"), names.index("u"), names.index("omega")
    tau = system.tau
    # Around the voltage that the motor's own speed induces, so that no limit ends the run.
    actions = np.empty((steps, 1), dtype=np.float32)
    (state, _), _ = env.reset()
    omega = float(state[omega_at] * limits[omega_at])
    middle = motor["psi_e"] * omega / limits[u_at]
    actions[:, 0] = middle + 0.05 * np.sign(np.sin(0.05 * np.arange(steps)))
    states = np.empty((steps, len(names)))
    current = float(state[i_at] * limits[i_at])
    ended = 0
    began = time.process_time()
    for n in range(steps):
        (state, _), _, terminated, truncated, _ = env.step(actions[n])
        states[n] = state
        ended += terminated or truncated
    seconds = time.process_time() - began
    decay = math.exp(-motor["r_a"] / motor["l_a"] * tau)
    exact = np.empty(steps)
    for n in range(steps):
        induced = motor["psi_e"] * states[n, omega_at] * limits[omega_at]
        final = (states[n, u_at] * limits[u_at] - induced) / motor["r_a"]
        current = final + (current - final) * decay
        exact[n] = current
    found = states[:, i_at] * limits[i_at]
    error = math.sqrt(np.mean((found - exact) ** 2)) / np.abs(exact).max()
    print(
        json.dumps(
            {
                "name": "gym-electric-motor",
                "version": version("gym-electric-motor"),
                "what": f"{ENVIRONMENT}, its own settings: a step of {1e6 * tau:g} µs, "
                f"{type(system._ode_solver).__name__}",
                "steps": steps,
                "ended_early": int(ended),
                "step_s": tau,
                "steps_per_s": steps / seconds,
                "simulated_s_per_s": steps * tau / seconds,
                "current_error": error,
            }
        )
    )


if __name__ == "__main__":
    main(int(sys.argv[1]))
