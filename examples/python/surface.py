# SPDX-License-Identifier: Apache-2.0
"""Three motors move one tip along a plane: force and place of the tip, torque of each motor."""

import matplotlib.pyplot as plt
import wavehaptics as wh

run = wh.run(wh.load_scene("phantom_plane").with_(scene__duration_s=0.2))
print(f"surface error: {1e6 * run.metrics['surface_error_max_m']:.0f} µm at most")

figure, (above, below) = plt.subplots(2, 1, sharex=True)
for axis, name in enumerate("xyz"):
    above.plot(run.trace["time"], run.trace["force"][:, axis], label=name)
above.set_ylabel("force, N")
for name, motor in run.motors.items():
    below.plot(motor.trace["time"], motor.trace["torque"], label=name)
below.set_ylabel("torque, N·m")
below.set_xlabel("time, s")
above.legend()
below.legend()
figure.savefig("surface.png")
