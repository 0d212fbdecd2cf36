# SPDX-License-Identifier: Apache-2.0
"""A finger taps a wall: run a shipped scene, read a metric, plot the torque over the position."""

import matplotlib.pyplot as plt
import wavehaptics as wh

scene = wh.load_scene("paper_taps").with_(scene__duration_s=0.5)
run = wh.run(scene, "golden")
print(f"stiffness: {run.metrics['stiffness']:.3f} N·m/rad")
for note in run.notes:
    print(note)

trace = run.trace
plt.plot(trace["position"], trace["torque"])
plt.xlabel(f"position, {trace.units['position']}")
plt.ylabel(f"torque, {trace.units['torque']}")
plt.title(f"{scene.name}, λ = {scene['controller.lambda']:g} rad/s")
plt.savefig("first_wall.png")
