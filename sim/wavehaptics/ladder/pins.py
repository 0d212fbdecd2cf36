# SPDX-License-Identifier: Apache-2.0
"""The controller ``pins``: the whole RTL at its pins, clock by clock, with a switching bridge.

ADC bits, encoder edges and gates are what a board would see.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from wavehaptics.controller import bus_scale, guard
from wavehaptics.controller.ports import Ports, bus_voltage, controller_ports
from wavehaptics.controller.settings import Settings
from wavehaptics.controller.tick_layout import MOST_SAMPLES, bridge_mode
from wavehaptics.ladder import pins_loop, verilated
from wavehaptics.motor import sigma_delta
from wavehaptics.motor.imperfections import Real, real_parts, warm_real
from wavehaptics.motor.plant import C, P, X, load_words
from wavehaptics.motor.sensor import NOISE_SEED
from wavehaptics.motor.thermal import Winding
from wavehaptics.parts.adcs import KINDS, PARTS, Frame, Part
from wavehaptics.scene import Scene, encoder_end
from wavehaptics.scene.tables.drive import Drive
from wavehaptics.trace.columns import Column, Word
from wavehaptics.words.bridge_modes import HALF_BRIDGE, MODE_WORDS, UNIPOLAR
from wavehaptics.words.table import LEGS, Values

DELAY_LOG2 = 10
MIN_WALLS = 4
"""Walls of the simulated RTL, at least: one build serves most scenes."""
STEPS = 128
"""Clocks of the longest step that has a table."""


def soldered(ports: Ports) -> dict[str, int]:
    """Parameters of the RTL that converter and bridge make.

    Those of the bridge are in one build, which takes longer than the run.
    """
    frame, words = ports.timing.frame, ports.words
    usual = words["mode"] == MODE_WORDS[UNIPOLAR] and not words["min_pulse"]
    return {
        "ADC": KINDS.index(frame.kind),
        **({"OSR": frame.osr} if frame.osr else {}),
        **({} if usual else {"MODES": 1, "MIN_PULSE": 1}),
    }


def scene_values(scene: Scene, ports: Ports, walls: int) -> Values:
    """Words of the RTL for a scene, with places for so many ``walls``."""
    return {
        **ports.words, **ports.settings.words(), **ports.wall_words(walls),
        "bus": bus_scale.bus_word(true_bus_v(scene)),
        **(guard.scene_words(scene, ports) if scene.guard else {}),
    }  # fmt: skip


def wire(part: Part | None, frame: Frame) -> tuple[int, int]:
    """Place of the code on the simulated ADC's wire, and the level of SCLK that launches a bit."""
    late = part is not None and part.launch_late
    trailing = part is not None and part.launch_trailing
    bits = frame.lead_bits + frame.data_bits + late
    return 64 - bits, frame.sclk_idle if trailing else 1 - frame.sclk_idle


def true_bus_v(scene: Scene) -> float:
    """The bus of the scene's bridge as it is, V."""
    known_v = scene.drive.true_bus_v if scene.drive is not None else None
    return known_v or bus_voltage(scene)


def pass_ticks(
    rows: Sequence[np.ndarray], words: Sequence[np.ndarray], kept: np.ndarray,
    motors: Sequence[PinsSimulation], clocks: int = 0, tip: tuple[Any, ...] | None = None,
) -> None:  # fmt: skip
    """Fill the ``rows`` and ``words`` of each motor, all of them at one controller.

    ``kept`` are the motors' own arrays of that name. Where there are no rows, ``clocks`` pass.
    ``tip`` is what :func:`pins_loop.advance` has of a hand at the motors' tip.
    """
    done = np.zeros(len(motors), dtype=np.int64)
    parts = tuple(motor.parts for motor in motors)
    if not pins_loop.advance(tuple(rows), tuple(words), clocks, done, kept, parts, tip):
        raise RuntimeError("the controller's RTL stopped answering")


def pass_clocks(
    clocks: int, kept: np.ndarray, motors: Sequence[PinsSimulation],
    tip: tuple[Any, ...] | None = None,
) -> None:  # fmt: skip
    """Let clocks pass of which no rows are made."""
    none, no_words = np.zeros((0, len(Column))), np.zeros((0, len(Word)), dtype=np.int64)
    pass_ticks([none] * len(motors), [no_words] * len(motors), kept, motors, clocks, tip)


class PinsSimulation:
    """A scene on the whole RTL, with the ADC's bits, the encoder's edges and a switching bridge.

    ``most_samples`` limits the samples in a tick: 1 is point sampling in its middle.
    """

    TOP = "wh_controller"
    SHIM = "pins_shim.cpp"
    SHOWS: tuple[str, ...] = ()
    PREFIX = "wh_pins"
    """What the shim's functions begin with."""
    LEGS = LEGS

    INPUTS_SHIFT = 0
    """Converters of a motor besides the first, before its encoder in the inputs."""
    KEPT = pins_loop.OFF_AT + 1
    """Integers that the loop keeps."""

    turns = 0
    """Motors that take turns at its controller; 0: it has one of its own."""

    winding: Winding

    def __init__(
        self, scene: Scene, *, host: bool = False, most_samples: int = MOST_SAMPLES
    ) -> None:
        ports = self._ports_of(scene, most_samples)
        self.timing = time = ports.timing
        self.settings: Settings = ports.settings.for_a_host() if host else ports.settings
        self.sensor = sensor = ports.sensor
        self.tick_s = time.tick_s
        self._dt = 1.0 / time.clock_hz
        plant = self._plant_of(scene)
        self._longest = min(STEPS, max(1, math.floor(time.clock_hz * plant.longest_step_s)))
        self._model: int | None = None
        self._begin(scene, ports, host)
        self._state: np.ndarray = plant.start.copy()
        self._kept = np.zeros(self.KEPT, dtype=np.int64)
        self._kept[pins_loop.COUNT] = ports.start_count
        self._kept[pins_loop.TICK_START] = -1
        self._kept[pins_loop.PINS] = self._idle_pins(time.frame)
        self._kept[pins_loop.HELD] = 1 << (sensor.bits - 1)
        self._sums = np.zeros(pins_loop.HAND_NM + 1)
        self._sums[pins_loop.X0] = self._state[X]
        self._sums[pins_loop.HAND0] = self._state[P] + self._state[C]
        self._pending = np.zeros((pins_loop.PENDING, len(Column)))
        code_shift, launch_level = self._wire(scene, time.frame)
        drive = scene.drive or Drive.model_validate({})
        self._ints = np.array(
            [self._model, verilated.address(self._function("clock")),
             verilated.address(self._function("words")), time.tick_clocks,
             code_shift, sensor.bits, self.settings.u_max, self._longest, launch_level,
             time.frame.pipeline, time.frame.osr, bridge_mode(scene) == HALF_BRIDGE,
             verilated.address(self._function("bus")) if drive.bus_measured else 0,
             self.settings.anchored, ports.start_count],
            dtype=np.int64,
        )  # fmt: skip
        self._floats = np.array(
            [self._dt, self.settings.cell_rad, true_bus_v(scene), 1.0 + drive.gain_error, 0.0, 0.0,
             scene.controller.eta_contact, scene.controller.eta_free, encoder_end(scene),
             drive.bus_ripple_v, 2 * math.pi * (drive.bus_ripple_hz or 0.0), drive.bus_farad or 0.0]
        )  # fmt: skip
        self._sensor = sensor.constants()
        self._rng = np.random.default_rng(NOISE_SEED)
        self._buffer = np.zeros(pins_loop.WORDS_OF, dtype=np.int64)
        self._bits = sigma_delta.new_state()
        self._real = self._imperfections(scene)
        self.warm(plant)

    def _ports_of(self, scene: Scene, most_samples: int) -> Ports:
        return controller_ports(scene, most_samples=most_samples, turns=self.turns)

    def _plant_of(self, scene: Scene) -> Any:
        """The motor as it is at first."""
        self.winding = Winding(scene, self.tick_s)
        return self.winding.plant

    def _idle_pins(self, frame: Frame) -> int:
        """The pins before the first frame of the ADC."""
        return 1 << pins_loop.CS_N | frame.sclk_idle << pins_loop.SCLK

    def _wire(self, scene: Scene, frame: Frame) -> tuple[int, int]:
        """Place of the code on the ADC's wire, and the level of SCLK that launches a bit."""
        part = PARTS.get(scene.adc.part or "") if scene.adc is not None else None
        return wire(part, frame)

    def _begin(self, scene: Scene, ports: Ports, host: bool) -> None:
        """Build the RTL, and bring it to where its first tick begins."""
        places = max(MIN_WALLS, len(ports.walls))
        self._design = design = verilated.Design(
            self.TOP,
            self.SHIM,
            {
                "WALLS": places,
                "DELAY_LOG2": DELAY_LOG2,
                **self._hardware(scene, ports, host),
                **({} if self.turns else self._stations(scene)),
                **self._parameters(),
            },
            self.SHOWS,
        )
        self._library = verilated.load(design)
        verilated.declare_destructor(self._function("delete"))
        self._values = {
            **scene_values(scene, ports, places), **self.settings.words(),
            **self._magnet(scene, ports),
        }  # fmt: skip
        levels = pins_loop.encoder_levels.py_func(ports.start_count) << self.INPUTS_SHIFT
        self._model = self._new_model(self._port_words(design), levels)
        if not self._model:
            raise RuntimeError("the controller's RTL never got its ADC ready")

    def _hardware(self, scene: Scene, ports: Ports, host: bool) -> dict[str, int]:
        """Parameters of the RTL for what the scene has, anchor and guard aside."""
        measured = scene.drive is not None and scene.drive.bus_measured
        return {
            "N": max(1, self.turns),
            "SHAPER": len(self.settings.shaper.words),
            **soldered(ports),
            **({"BUS": 1} if measured else {}),
            **({"HOST": 1} if host else {}),
        }

    def _stations(self, scene: Scene) -> dict[str, int]:
        """Parameters of the RTL for what motors that take turns have always."""
        return {
            **({"ANCHOR": 1} if self.settings.anchored else {}),
            **({"GUARD": 1} if scene.guard else {}),
        }

    def _magnet(self, scene: Scene, ports: Ports) -> Values:
        """Words of the magnets' angle, which a motor with brushes hasn't."""
        del scene, ports
        return {}

    def _port_words(self, design: verilated.Design) -> ctypes.Array[ctypes.c_uint32]:
        """The settings as ports of the RTL take them."""
        return verilated.words_of(design, self._values)

    def connect_host(self, period_log2: int, timeout: int) -> None:
        """Say how long a period of the link to a host is, and how many may pass in silence."""
        self._library.wh_pins_host.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64]
        self._library.wh_pins_answer.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64]
        self._library.wh_pins_packet.argtypes = [ctypes.c_void_p, ctypes.POINTER(ctypes.c_int64)]
        self._library.wh_pins_host(self._model, period_log2, timeout)

    def host_answer(self, sequence: int, u: int) -> None:
        """The host's answer u to packet ``sequence``, in the coming clock."""
        self._library.wh_pins_answer(self._model, sequence, u)

    def host_packet(self) -> tuple[int, int, int, int]:
        """(packets so far, number and mean v of the newest, whether the host is in force)."""
        words = (ctypes.c_int64 * 4)()
        self._library.wh_pins_packet(self._model, words)
        return tuple(words)

    @property
    def faults(self) -> int:
        """What was seen: bit 0 a tick too short for its work or ticks without, bit 1 an encoder's
        illegal move, from bit 2 on the guard's faults.
        """
        return int(self._kept[pins_loop.FAULTS])

    @property
    def off_s(self) -> float:
        """Time at which the guard had the gates off, to a tick; 0 if it never had."""
        return float(self._kept[pins_loop.OFF_AT]) / self.timing.clock_hz

    @property
    def bus_highest_v(self) -> float | None:
        """Highest bus so far, V; None where the supply takes back what the bridge returns."""
        highest_v = float(self._sums[pins_loop.HIGHEST_V])
        return highest_v if self._floats[pins_loop.FARAD] else None

    @property
    def clock_cycles(self) -> int:
        """Clocks of the RTL so far."""
        return int(self._kept[pins_loop.NOW])

    def _imperfections(self, scene: Scene, *, always: bool = False) -> Real | None:
        """What the loop takes of a real motor; ``always`` of one that is ideal as well."""
        steps_s = [n * self._dt for n in range(STEPS + 1)]
        plant, cell_rad = self.winding.plant, self.settings.cell_rad
        return real_parts(scene, plant, cell_rad, steps_s, switching=True, always=always)

    def _function(self, name: str) -> Any:
        return getattr(self._library, f"{self.PREFIX}_{name}")

    def _parameters(self) -> dict[str, int]:
        """Parameters of the RTL besides the scene's."""
        return {}

    def _new_model(self, words: ctypes.Array[ctypes.c_uint32], inputs: int) -> int | None:
        return verilated.new_model(self._library.wh_pins_new, words, inputs)

    def advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        """Simulate ``len(rows)`` ticks into ``rows`` (Column) and ``words`` (Word)."""
        self.winding.advance(rows, lambda part: self._advance(rows[part], words[part]), self.warm)

    def warm(self, plant: Any) -> None:
        """Go on with the motor as it is now, of other R and k_T perhaps."""
        self._tables = np.stack([plant.transition(n * self._dt) for n in range(STEPS + 1)])
        self._load = load_words(plant)
        self._floats[[pins_loop.RESISTANCE, pins_loop.K_T]] = plant.resistance, plant.k_t
        warm_real(self._real, plant)

    def _advance(self, rows: np.ndarray, words: np.ndarray) -> None:
        pass_ticks([rows], [words], self._kept[np.newaxis], [self])

    @property
    def parts(self) -> pins_loop.Motor:
        """The motor as :func:`pins_loop.advance` takes it."""
        return (
            self._state, self._kept, self._sums, self._pending, self._tables, self._ints,
            self._floats, self._load, self._sensor, self._rng, self._buffer, self._bits, self._real,
        )  # fmt: skip

    def __del__(self) -> None:
        if getattr(self, "_model", None):
            self._function("delete")(self._model)
