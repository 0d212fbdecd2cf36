# SPDX-License-Identifier: Apache-2.0
"""Stiffness over λ for two rates, on all cores; the CSV lets an interrupted sweep go on."""

import matplotlib.pyplot as plt
import wavehaptics as wh

RATES_HZ = (1e6, 2e5)

if __name__ == "__main__":  # the processes of a sweep import this file
    scene = wh.load_scene("paper_taps").with_(scene__duration_s=0.3)
    axes = {"controller.tick_hz": RATES_HZ, "controller.lambda": [3e3, 1e4, 3e4, 1e5]}
    rows = wh.sweep(scene, axes, out="sweep.csv", workers=2)
    for rate in RATES_HZ:
        at = [row for row in rows if row["controller.tick_hz"] == rate]
        plt.semilogx(
            [row["controller.lambda"] for row in at], [row["stiffness"] for row in at],
            "o-", label=f"{rate:g} Hz",
        )  # fmt: skip
    plt.xlabel("λ, rad/s")
    plt.ylabel("stiffness, N·m/rad")
    plt.legend()
    plt.savefig("sweep.png")
    print(f"{len(rows)} points, the stiffest {max(row['stiffness'] for row in rows):.3f} N·m/rad")
