# SPDX-License-Identifier: Apache-2.0
"""`pins` of motors with brushes: ``rtl/wh_ports.v``, in which they take turns, in one loop.

Each motor has its own bridge, bus, encoder, converter and hand, as a single one has.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np

from wavehaptics.controller.ports import Ports
from wavehaptics.controller.turns import port_requests, sections, shared_words, turns_ports
from wavehaptics.ladder import pins_loop, verilated
from wavehaptics.ladder.pins import (
    DELAY_LOG2,
    MIN_WALLS,
    PinsSimulation,
    pass_ticks,
    scene_values,
    soldered,
)
from wavehaptics.scene import Scene
from wavehaptics.words.table import Sizes, Values


class TurnsSimulation:
    """The motors of ``scenes``, one or more, at one controller.

    There are so many ``surfaces`` across them, with a ``budget`` in squares of a wave's LSB.
    """

    def __init__(self, scenes: Sequence[Scene], surfaces: int = 0, budget: int = 0) -> None:
        ports = turns_ports(scenes, surfaces)
        walls = max(MIN_WALLS, *(len(one.walls) for one in ports))
        values = [scene_values(scene, one, walls) for scene, one in zip(scenes, ports, strict=True)]
        self._design = verilated.Design(
            "wh_ports",
            "ports_shim.cpp",
            {
                "N": len(scenes), "WALLS": walls, "DELAY_LOG2": DELAY_LOG2,
                "SHAPER": sections(scenes),
                **({"SURFACES": surfaces} if surfaces else {}),
                **soldered(ports[0]),
            },
            ("ports_steps.vlt",),
        )  # fmt: skip
        self._library = verilated.load(self._design)
        verilated.declare_destructor(self._library.wh_ports_delete)
        self._model = self._new_model(ports, values, budget)
        self.motors = [
            _Motor(scene, one, self._library, self._model)
            for scene, one in zip(scenes, ports, strict=True)
        ]
        if any(motor._real is not None for motor in self.motors):
            # The loop has one kind of motor.
            for motor, scene in zip(self.motors, scenes, strict=True):
                motor._real = motor._imperfections(scene, always=True)
        self._kept = np.stack([motor._kept for motor in self.motors])
        for motor, kept in zip(self.motors, self._kept, strict=True):
            motor._kept = kept
        self.tick_s = self.motors[0].tick_s

    def _new_model(self, ports: Sequence[Ports], values: Sequence[Values], budget: int) -> int:
        """The RTL, where its first tick begins."""
        inputs = sum(
            pins_loop.encoder_levels.py_func(one.start_count) << pins_loop.MOTOR_INPUTS * n
            for n, one in enumerate(ports)
        )
        model = new_ports(self._library, self._design.sizes, values, inputs, budget)
        if not model:
            raise RuntimeError("the controller's RTL never got its ADC ready")
        return model

    def advance(self, rows: Sequence[np.ndarray], words: Sequence[np.ndarray]) -> None:
        """Simulate ticks into the rows and words of each motor, which have the same length."""
        for part in max((motor.winding.pieces(len(rows[0])) for motor in self.motors), key=len):
            pass_ticks(
                [one[part] for one in rows], [one[part] for one in words], self._kept, self.motors
            )
            for motor, made in zip(self.motors, rows, strict=True):
                if motor.winding.heat(made[part]):
                    motor.warm(motor.winding.plant)

    def __del__(self) -> None:
        if getattr(self, "_model", None):
            self._library.wh_ports_delete(self._model)


def new_ports(
    library: ctypes.CDLL, sizes: Sizes, values: Sequence[Values], inputs: int, budget: int = 0
) -> int | None:
    """``wh_ports`` with the ``values`` of each port, where its first tick begins."""
    shared = shared_words(values[0], sizes, len(values))
    pairs = [word for n, one in enumerate(values) for pair in port_requests(one, sizes, n)
             for word in pair]  # fmt: skip
    new = library.wh_ports_new
    words = ctypes.POINTER(ctypes.c_uint32)
    new.argtypes, new.restype = [words, words, *[ctypes.c_int64] * 4], ctypes.c_void_p
    model: int | None = new(
        (ctypes.c_uint32 * len(shared))(*shared), (ctypes.c_uint32 * len(pairs))(*pairs),
        len(pairs) // 2, values[0]["bus"], budget, inputs,
    )  # fmt: skip
    return model


class _Motor(PinsSimulation):
    """One of several, whose controller is another's."""

    PREFIX = "wh_ports"

    def __init__(self, scene: Scene, ports: Ports, library: ctypes.CDLL, model: int) -> None:
        self._ports, self._library, self._controller = ports, library, model
        super().__init__(scene)

    def _ports_of(self, scene: Scene, most_samples: int) -> Ports:
        return self._ports

    def _begin(self, scene: Scene, ports: Ports, host: bool) -> None:
        self._model = self._controller

    def __del__(self) -> None:
        """The controller is not its own."""
