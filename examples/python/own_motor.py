# SPDX-License-Identifier: Apache-2.0
"""A wall of a motor of your own, from its data sheet: a scene file of four tables."""

from pathlib import Path

import matplotlib.pyplot as plt
import wavehaptics as wh

Path("own_motor.toml").write_text(
    """
[scene]
name = "own_motor"
duration_s = 0.3
trace_hz = 20e3
[motor] # the data sheet's resistance, inductance, torque constant and inertia
R_ohm = 2.45
L_h = 0.513e-3
k_t = 53.8e-3
J_kgm2 = 34.7e-7
[hand] # a finger that taps twice in the run
path = "taps"
amplitude_rad = 0.02
frequency_hz = 5.0
stiffness = 2.0
damping = 2e-3
[controller]
tick_hz = 1e6
lambda = 1e5
walls = [[0.0, 1.0]]
"""
)
run = wh.run(wh.load_scene("own_motor.toml"))
print(f"stiffness: {run.metrics['stiffness']:.2f} of {run.metrics['k_l']:.2f} N·m/rad, K_L")
plt.plot(run.trace["time"], run.trace["torque"])
plt.xlabel("time, s")
plt.ylabel("torque, N·m")
plt.savefig("own_motor.png")
