# SPDX-License-Identifier: Apache-2.0
"""Set, arm and read a board. A port in place of the scene, wh.Board("/dev/ttyUSB0"), is a real one.

The first start of a simulated board compiles its RTL, which takes minutes.
"""

import time

import matplotlib.pyplot as plt
import wavehaptics as wh

places = []
with wh.Board.virtual("live_wall") as board:
    board.set(eta_contact=-0.9)
    print(f"eta_contact: {board['eta_contact']:.3f}, walls at {board['wall_min']} counts")
    with board.armed():  # the bridges are off at the block's end, however that comes
        for _ in range(50):
            places.append(board["position"])
            time.sleep(0.02)
    print(f"armed: {board['armed']}")
    plt.plot(places)
    plt.ylabel(f"position, {board.units['position']}")
plt.xlabel("sample")
plt.savefig("board.png")
