# SPDX-License-Identifier: Apache-2.0
"""From a board's scene to the words that its bitstream holds, as Verilog macros.

A board's top gives ``wh_controller`` constants instead of registers, or ``wh_linked_device`` the
words that it begins with. They are computed here from the board's scene and from the data sheet of
its ADC, so that no number is typed twice; what they leave open has its default of
``rtl/words.toml``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from typing import Any

from wavehaptics.controller import guard
from wavehaptics.controller.pins_timing import shared_tick_clocks
from wavehaptics.controller.ports import Ports, controller_ports
from wavehaptics.controller.tick_layout import FrameAt
from wavehaptics.ladder.abilities import refuse
from wavehaptics.ladder.brushless import magnet_words
from wavehaptics.parts.adcs import KINDS, Frame, Modulator, Part, frame, modulator_frame
from wavehaptics.scene import Scene
from wavehaptics.words import formats
from wavehaptics.words.bridge_modes import LOCKED, MODE_WORDS, SIGN_MAGNITUDE, UNIPOLAR
from wavehaptics.words.generated import LICENCE, connections, macro, settings_rom
from wavehaptics.words.memory import apart, first_words
from wavehaptics.words.table import AXES, LEGS, THREE_PHASE_LEGS, WORDS, Sizes, Values

ZERO_A = 0.1
"""Offset of the current beyond which a board's sensor isn't what the scene says."""

UNUSED_OSR = 32
"""Of a board without a modulator; any that the RTL takes."""

ALIVE_S = 4e-6
"""Period of several motors in which ``alive`` changes twice when it is longer: the pump's."""

LINKED_WALLS = 4
"""Walls of a motor, at least, where they can be changed, unless a board says another number."""

CHANGEABLE = (
    "wh_current.current", "wh_wave_core.eta", "wh_wave_core.wave", "wh_anchor.anchor",
    "wh_contact.edges", "wh_contact.walls", "wh_shaper.shape", "wh_capture.capture",
    "wh_stream.stream", "wh_stream.cut", "wh_host_link.host", "wh_rotor_flux.magnet",
    "wh_surface_frame.budget",
)  # fmt: skip
"""Groups of words that can be changed on a board: none of the hardware, and none of its limits."""


PATTERNS = (LOCKED, SIGN_MAGNITUDE)
"""Patterns of a full bridge in one another's place: all that differs is the word `mode`. A unipolar
bridge is sampled elsewhere, and the lead B of a half bridge is wired to something else."""

OPTIONAL_PINS = {
    "spi": {
        "spi_cs_n_i": "1'b1", "spi_sclk_i": "1'b0", "spi_mosi_i": "1'b0", "spi_miso_o": "",
        "spi_drives_o": "",
    },
    "overcurrent": {"overcurrent_n_i": "1'b1"},
}  # fmt: skip
"""Ports of ``boards/wh_board_ecp5.v`` that only some boards have, by the key of ``fpga.toml``: and
the level that an input has on the others."""


@dataclass(frozen=True)
class BoardWords:
    """What a board's bitstream is made with.

    ``words`` as in :class:`wavehaptics.controller.ports.Ports`.
    """

    ports: Ports
    words: dict[str, Any]
    motors: int
    delay_log2: int
    guard: int | None
    """The guard's word; None for a board without one."""
    linked: bool = False
    """Whether there is a line over which some of the words can be changed."""
    capture: int = 0
    """Words that a capture takes, 2^this; 0 where there is none."""
    linked_walls: int = LINKED_WALLS
    """Walls of a motor, at least, where there is a line over which they are changed."""
    stream: bool = False
    """Whether live words can be sent as a stream."""
    host: bool = False
    """Whether a computer on the line can have the environment."""
    legs: int = LEGS
    """Half bridges of a motor."""
    shared: bool = False
    """Whether one multiplier makes the wave core's products as well as all others."""
    surfaces: int = 0
    """Surfaces across all motors, which a computer writes."""
    spi: bool = False
    """Whether a host MCU can have the line's place."""
    overcurrent: bool = False
    """Whether the comparators tell the guard that they have shut the gates."""

    @property
    def alive_again(self) -> int:
        """Clocks after a tick at which ``alive`` changes once more; 0: it changes once a tick."""
        time = self.ports.timing
        return time.tick_clocks // 2 if self.motors > 1 and time.tick_s > ALIVE_S else 0

    @property
    def patterns(self) -> tuple[str, ...]:
        """Patterns of the bridge between which the line chooses, with the bridge off."""
        one = self.words["mode"] in [MODE_WORDS[name] for name in PATTERNS]
        return PATTERNS if one and self.linked and self.legs == LEGS else ()

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Words that can be changed on this board, beside the groups in :data:`CHANGEABLE`."""
        modes = [MODE_WORDS[name] for name in self.patterns]
        return {"mode": (min(modes), max(modes))} if modes else {}

    @property
    def walls(self) -> int:
        """Walls of a motor, some of them empty where the scene has fewer."""
        return max(self.linked_walls if self.linked else 1, len(self.ports.walls))


def turns_of(motors: int, legs: int, *, linked: bool) -> int:
    """Motors of a board that take turns in ``rtl/wh_device.v``; 0: a single one that has none.

    That is a brushless one, whose two axes do, or one with brushes at ``wh_controller``.
    """
    return motors if motors > 1 or (linked and legs == LEGS) else 0


def board_words(
    scene: Scene, part: Part | Modulator | None, motors: int = 1, *, guarded: bool = False,
    pad_registers: bool = False, trip_a: float | None = None, zero_a: float = ZERO_A,
    delay_log2: int = 1, linked: bool = False, capture: int = 0,
    stream: bool = False, legs: int = LEGS, shared: bool = False,
    linked_walls: int = LINKED_WALLS, surfaces: int = 0, spi: bool = False,
    overcurrent: bool = False,
) -> BoardWords:  # fmt: skip
    """Words of a board with ``motors`` equal motors and the converter ``part`` for each.

    None: the converter is the scene's own, as `pins` has it.

    A motor has ``legs`` half bridges; with three it is a brushless one, with two converters.

    ``pad_registers`` are those of :func:`wavehaptics.parts.adcs.frame`; a current of ``trip_a``
    takes the gates off, and an offset of more than ``zero_a`` is a fault. :class:`SceneError` where
    the scene's ADC isn't the part, or its clock or tick doesn't suit it, or so many ``surfaces``
    across the motors. The delay line has
    2^``delay_log2`` steps or more. ``shared`` is the multiplier, which W has no room in.
    """
    refuse(scene, "a board")
    _check_legs(scene, legs)
    if part is not None:
        _check_part(scene, part)
    if shared and scene.shaper is not None:
        raise scene.refusal(
            "[shaper] needs a multiplier that the wave core has for itself; leave it out, "
            "or shared_multiplier of the board's fpga.toml",
            "shaper",
        )
    frame_at: FrameAt | None = None
    if part is not None:
        frame_at = partial(part_frame, part, pad_registers)
    turns = turns_of(motors, legs, linked=linked)
    ports = controller_ports(scene, frame_at, turns=turns, surfaces=surfaces)
    if shared:
        _check_shared(scene, ports)
    words = {
        **ports.words, **_each_motor(ports.settings.words(), motors),
        **(magnet_words(scene, ports.settings, ports.start_count) if scene.motor.brushless else {}),
        "zero_limit": min(
            round(zero_a / formats.GAIN.to_value(ports.words["gain"])),
            WORDS["zero_limit"].fixed.raw_max,
        ),
    }  # fmt: skip
    if trip_a is not None:
        words["trip"] = guard.trip_word(trip_a, ports.sensor)
    if scene.host is not None and not linked:
        raise scene.refusal("the board has no link to a host; leave [host] out", "host")
    delay_log2 = max(delay_log2, words["extra_ticks"].bit_length())
    motion = guard.motion_words(scene, ports)
    if motion and not guarded:
        raise scene.refusal(
            "the board has no guard; leave guard.overspeed_rad_s and guard.window_rad out",
            "guard.overspeed_rad_s", "guard.window_rad",
        )  # fmt: skip
    words |= motion
    word = _guard(scene, ports, trip_a, overcurrent) if guarded else None
    return BoardWords(
        ports, words, motors, delay_log2, word, linked, capture if linked else 0, linked_walls,
        linked and stream, scene.host is not None, legs, shared, surfaces, spi, overcurrent,
    )  # fmt: skip


def part_frame(
    part: Part | Modulator, pad_registers: bool, clock_hz: float, tick_clocks: int
) -> Frame:
    """The frame of a board's converter on a clock."""
    if isinstance(part, Modulator):
        return modulator_frame(part, clock_hz, tick_clocks, pad_registers)
    return frame(part, clock_hz, pad_registers)


def _check_part(scene: Scene, part: Part | Modulator) -> None:
    """:class:`SceneError` where the scene's ADC isn't the board's."""
    if scene.adc is not None and scene.adc.part not in (None, part.name):
        raise scene.refusal(f"the board's ADC is an {part.name}; set adc.part so", "adc.part")
    if scene.adc is None or scene.adc.bits != part.bits:
        raise scene.refusal(f"the board's ADC has {part.bits} bits; set adc.bits so", "adc.bits")


def _check_shared(scene: Scene, ports: Ports) -> None:
    """:class:`SceneError` where a tick is too short for one multiplier that makes all products."""
    needed, clocks = shared_tick_clocks(1, ports.settings.anchored), ports.timing.tick_clocks
    if needed > clocks:
        raise scene.refusal(
            f"a tick of {clocks} clocks is shorter than the {needed} that the shared multiplier "
            "needs; lower controller.tick_hz",
            "controller.tick_hz",
        )


def _check_legs(scene: Scene, legs: int) -> None:
    """:class:`SceneError` where the scene's motor isn't one for the board's half bridges."""
    if scene.motor.brushless != (legs == THREE_PHASE_LEGS):
        needed = THREE_PHASE_LEGS if scene.motor.brushless else LEGS
        raise scene.refusal(
            f'motor.kind = "{scene.motor.kind}" needs {needed} half bridges, and the '
            f"board has {legs} (legs of its fpga.toml); take another motor or another board",
            "motor.kind", "motor.preset",
        )  # fmt: skip


def _each_motor(words: Values, motors: int) -> dict[str, Any]:
    """Those of one motor, for ``motors`` of them."""
    return {name: word if isinstance(word, int) else [*word] * motors
            for name, word in words.items()}  # fmt: skip


def _guard(scene: Scene, ports: Ports, trip_a: float | None, overcurrent: bool) -> int:
    if scene.thermal is not None and scene.thermal.ambient_c >= guard.WINDING_MOST_C:
        raise scene.refusal(
            f"thermal.ambient_c = {scene.thermal.ambient_c:g} °C leaves a winding "
            f"nothing that bears {guard.WINDING_MOST_C:g} °C; lower it",
            "thermal.ambient_c",
        )
    limits = guard.board_limits(scene, ports, trip_a, driver=overcurrent)
    time = ports.timing
    return guard.settings(
        limits, time.tick_s, ports.sensor, ports.settings.s, time.frame.unity
    )  # fmt: skip


def first_values(board: BoardWords, motors: int) -> Values:
    """What each word of ``motors`` of the board's motors is."""
    each = board.ports.settings.words()
    return {
        **board.words,
        **_each_motor({name: board.words[name][: len(word)]
                       for name, word in each.items() if not isinstance(word, int)}, motors),
        "guard": board.guard or 0,
        **board.ports.wall_words(board.walls, motors),
    }  # fmt: skip


def build_number() -> int:
    """The package's version as a linked board tells it: 8 bits each, a zero above."""
    parts = [int(part) for part in version("wavehaptics").split(".")[:3]]
    return parts[0] << 16 | parts[1] << 8 | parts[2]


def memory_header(board: BoardWords, source: str) -> str:
    """Text of ``wh_board_settings_rom.vh``: the words that a linked board begins with.

    Those of :data:`CHANGEABLE` and of the board's ``ranges`` can be changed; what is the hardware's
    is read only.
    """
    return (
        f"{LICENCE}// Settings that wh_linked_device begins with, made from {source}.\n\n"
        + settings_rom(apart(first_values(board, 1)), CHANGEABLE, board.ranges)
    )


def memory_words(board: BoardWords) -> list[int]:
    """The words of :func:`memory_header` as ``rtl/wh_registers.v`` has them in its ROM."""
    sections = len(board.ports.settings.shaper.words)
    return first_words(apart(first_values(board, 1)), board.walls, sections)


def parameters(board: BoardWords) -> dict[str, int]:
    """Parameters of ``rtl/wh_device.v`` that follow from the scene, by their names."""
    words, time_frame = board.words, board.ports.timing.frame
    brushless = board.legs == THREE_PHASE_LEGS
    return {
        "N": board.motors * (AXES if brushless else 1),
        "AXES": sum(1 << AXES * n for n in range(board.motors)) if brushless else 0,
        "WALLS": board.walls,
        "DELAY_LOG2": board.delay_log2,
        "ADC": KINDS.index(time_frame.kind),
        **({"OSR": time_frame.osr} if time_frame.osr else {}),
        "SHAPER": len(board.ports.settings.shaper.words),
        "HOST": int(board.host),
        "MODES": int(words["mode"] != MODE_WORDS[UNIPOLAR] and not brushless),
        "MIN_PULSE": int(words["min_pulse"] > 0),
    }


def hardware(board: BoardWords) -> dict[str, int]:
    """What a board is synthesised with besides its first words, by the macros' names."""
    made = parameters(board)
    return {
        "N": made["N"],
        "AXES": made["AXES"],
        "WALLS": made["WALLS"],
        "MODES": made["MODES"],
        "ADC": made["ADC"],
        "OSR": made.get("OSR", UNUSED_OSR),
        "SHORTEST": made["MIN_PULSE"],
        "DELAY_LOG2": made["DELAY_LOG2"],
        "SHAPER": made["SHAPER"],
        "ANCHOR": int(board.ports.settings.anchored),
        "SHARED": int(board.shared),
        "GUARDED": int(board.guard is not None),
        "LINKED": int(board.linked),
        "CAPTURE": board.capture,
        "STREAM": int(board.stream),
        "SURFACES": board.surfaces,
        "SPI": int(board.spi),
        "AGAIN": board.alive_again,
        "HOST": made["HOST"],
        "CLOCK_HZ": round(board.ports.timing.clock_hz),
        "BUILD": build_number(),
    }


def optional_pins(board: BoardWords) -> str:
    """Verilog macros of :data:`OPTIONAL_PINS`, for the modules that a board's top is made of.

    ``WH_BOARD_MORE_PORTS`` declares those that the board has, ``WH_BOARD_MORE_PINS`` connects them
    from one module to the next, and ``WH_BOARD_MORE_WIRES`` is in the place of the others.
    """
    has: list[tuple[str, str]] = []
    others: list[tuple[str, str]] = []
    for key, pins in OPTIONAL_PINS.items():
        (has if getattr(board, key) else others).extend(pins.items())
    ends = [name for name, level in others if not level]
    wires = [f"wire {name} = {level};" if level else f"wire {name};" for name, level in others]
    wires += [f"wire unused_pins = &{{1'b0, {', '.join(ends)}}};"] if ends else []
    ports = [f"{'input ' if level else 'output'} wire {name}," for name, level in has]
    return "\n".join([
        macro("WH_BOARD_MORE_PORTS", ports),
        macro("WH_BOARD_MORE_PINS", (f".{name} ({name})," for name, _ in has)),
        macro("WH_BOARD_MORE_WIRES", wires),
    ])  # fmt: skip


def verilog_header(board: BoardWords, source: str) -> str:
    """Text of ``wh_board_settings.vh``; ``source`` is named in it as where the numbers are from."""
    # With three legs there is a link, and of wh_controller nothing but its ports' names.
    sizes = Sizes(
        board.motors, board.walls, len(board.ports.settings.shaper.words), board.delay_log2
    )
    values = first_values(board, board.motors)
    told = connections("WH_BOARD", sizes, values, ("clear", "zero_start"))
    return "\n".join(
        [
            f"{LICENCE}// Settings of wh_controller, made from {source}.",
            "",
            *(f"`define WH_BOARD_{name} {value}" for name, value in hardware(board).items()),
            "",
            optional_pins(board),
            told,
        ]
    )
