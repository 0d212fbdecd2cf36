# SPDX-License-Identifier: Apache-2.0
"""From a board's scene to the words that its bitstream holds, as Verilog macros.

A board's top gives ``wh_controller`` constants instead of registers. They are computed here from
the board's scene and from the data sheet of its ADC, so that no number is typed twice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from wavehaptics import formats
from wavehaptics.pins import Ports, Timing, controller_ports, timing
from wavehaptics.pins_timing import CORE_CLOCKS, latency_clocks
from wavehaptics.scene import Scene, SceneError


@dataclass(frozen=True)
class AdcPart:
    """A converter that ``wh_adc_serial`` can read, by its data sheet.

    ``lead_bits`` zeros and ``data_bits`` come with the ``frame_bits`` falls of SCLK. ``sclk_hz`` is
    the fastest SCLK, ``setup_s`` the least time from the fall of CS to that of SCLK, ``quiet_s``
    from the end of the frame to the next CS, ``acquire_s`` from 12.5 periods of SCLK after its
    first fall to the next CS; ``access_s`` is the longest time from a fall of SCLK to its data.
    """

    lead_bits: int
    data_bits: int
    frame_bits: int
    sclk_hz: float
    setup_s: float
    quiet_s: float
    acquire_s: float
    access_s: float


ADC_PARTS = {
    # The acquisition time is from memory.
    "AD7476A": AdcPart(4, 12, 16, 20e6, 10e-9, 50e-9, 250e-9, 40e-9),
    # The access time is from memory.
    "AD7276": AdcPart(2, 12, 14, 48e6, 6e-9, 4e-9, 60e-9, 15e-9),
}
"""Converters by name. The figures are the makers', but for those said to be from memory: look them
up in the data sheet before a design leans on them."""

_CONVERTED = 12.5  # periods of SCLK from its first fall until the part follows its input again

WIDTHS = {
    "half_clocks": formats.TICK_W,
    "tick_halves": formats.TICK_W,
    "sample_clocks": formats.TICK_W,
    "samples": 9,
    "sample_lead": 8,
    "sclk_half_clocks": 8,
    "frame_bits": 6,
    "lead_bits": 6,
    "data_bits": 5,
    "quiet_clocks": 8,
    "zero": formats.SUM_W,
    "gain": formats.COEF_W,
    "filter_clocks": 4,
    "eta_contact": formats.COEF_W,
    "eta_free": formats.COEF_W,
    "root": formats.COEF_W,
    "a": formats.COEF_W,
    "u_max": formats.DATA_W,
    "extra_ticks": None,
    "hold_ticks": None,
    "clocks_per_volt": formats.COEF_W,
    "dead_clocks": 8,
}
"""Bits of each setting of ``wh_controller``; ``None`` is DELAY_LOG2, which is chosen here."""

_PER_PORT = frozenset(
    ("zero", "gain", "eta_contact", "eta_free", "root", "a", "u_max", "clocks_per_volt")
)


@dataclass(frozen=True)
class BoardWords:
    """What a board's bitstream is made with; ``words`` as in :class:`wavehaptics.pins.Ports`."""

    ports: Ports
    words: dict[str, int]
    motors: int
    delay_log2: int

    @property
    def walls(self) -> list[tuple[int, int]]:
        """Walls (min, max) in counts; an empty one where the scene has none."""
        return self.ports.walls or [(0, 0)]


def board_words(scene: Scene, part: AdcPart, motors: int = 1) -> BoardWords:
    """Words of a board with ``motors`` equal motors and the converter ``part`` for each.

    :class:`SceneError` where the scene's ADC isn't the part, or its clock or tick doesn't suit it.
    """
    if scene.adc is None or scene.adc.bits != part.data_bits:
        raise SceneError(f"{_at(scene)}the board's ADC has {part.data_bits} bits; set adc.bits so")
    ports = controller_ports(scene)
    # The part's own frame, which may be longer than the simulated ADC's.
    laid = timing(scene, part.frame_bits)
    words = dict(ports.words)
    half = words["sclk_half_clocks"]
    quiet = max(words["quiet_clocks"], math.ceil(part.quiet_s * laid.clock_hz))
    _check_frame(scene, part, laid, half, quiet)
    words.update(
        half_clocks=laid.half_clocks,
        tick_halves=laid.tick_halves,
        sample_clocks=laid.sample_clocks,
        samples=laid.samples,
        frame_bits=part.frame_bits,
        lead_bits=part.lead_bits,
        data_bits=part.data_bits,
        quiet_clocks=quiet,
        gain=ports.sensor.gain_word(laid.samples),
        hold_ticks=_hold_ticks(scene, part, laid, half, words["sample_lead"], motors),
    )
    delay_log2 = max(1, words["extra_ticks"].bit_length())
    return BoardWords(ports, words, motors, delay_log2)


def _at(scene: Scene) -> str:
    return f"{scene.scene.name}: "


def _check_frame(scene: Scene, part: AdcPart, laid: Timing, half: int, quiet: int) -> None:
    """Refuse a clock that the part doesn't take."""
    sclk_hz = laid.clock_hz / (2 * half)
    if sclk_hz > part.sclk_hz or half < part.setup_s * laid.clock_hz:
        raise SceneError(
            f"{_at(scene)}controller.clock_hz = {laid.clock_hz:g} makes an SCLK of "
            f"{sclk_hz / 1e6:g} MHz; the board's ADC takes {part.sclk_hz / 1e6:g} MHz"
        )
    frame = 2 * half * part.frame_bits
    acquire = math.ceil(half + 2 * half * _CONVERTED + part.acquire_s * laid.clock_hz)
    needed = max(frame + quiet, acquire)
    if needed > laid.sample_clocks:
        raise SceneError(
            f"{_at(scene)}the board's ADC needs {needed} clocks from sample to sample, and "
            f"controller.tick_hz leaves {laid.sample_clocks}; lower it or raise clock_hz"
        )


def _hold_ticks(
    scene: Scene, part: AdcPart, laid: Timing, half: int, lead: int, motors: int
) -> int:
    """Ticks that a voltage waits, so that the latency is the scene's ``extra_ticks``."""
    last_sample = (laid.samples - 1) * laid.sample_clocks + laid.sample_clocks // 2 - lead
    ready = last_sample + latency_clocks(half, part.lead_bits + part.data_bits, motors)
    natural = ready // laid.tick_clocks
    extra = scene.controller.extra_ticks
    if extra < natural:
        raise SceneError(
            f"{_at(scene)}controller.extra_ticks = {extra} is less than the board needs: a voltage "
            f"is ready {ready} clocks after its tick began, {natural} ticks of "
            f"{laid.tick_clocks} clocks; set extra_ticks = {natural} or more"
        )
    if CORE_CLOCKS * motors > laid.tick_clocks:
        raise SceneError(
            f"{_at(scene)}a tick of {laid.tick_clocks} clocks is shorter than the "
            f"{CORE_CLOCKS * motors} that {motors} motors need; lower controller.tick_hz"
        )
    return extra - natural


def _literal(value: int, width: int) -> str:
    return f"{width}'h{value & ((1 << width) - 1):x}"


def _packed(values: list[int], width: int) -> str:
    """A concatenation, the first value lowest."""
    return "{" + ", ".join(_literal(value, width) for value in reversed(values)) + "}"


def verilog_header(board: BoardWords, source: str) -> str:
    """Text of ``wh_board_settings.vh``; ``source`` is named in it as where the numbers are from."""
    walls = board.walls * board.motors
    enabled = [1 if low < high else 0 for low, high in walls]
    lines = [
        "// SPDX-License-Identifier: Apache-2.0",
        f"// Settings of wh_controller, made from {source}.",
        "",
        f"`define WH_BOARD_N {board.motors}",
        f"`define WH_BOARD_WALLS {len(board.walls)}",
        f"`define WH_BOARD_DELAY_LOG2 {board.delay_log2}",
        "",
    ]
    for name, width in WIDTHS.items():
        copies = board.motors if name in _PER_PORT else 1
        text = _packed([board.words[name]] * copies, width or board.delay_log2)
        lines.append(f"`define WH_BOARD_{name.upper()} {text}")
    for name, values, width in (
        ("WALL_MIN", [wall[0] for wall in walls], formats.COUNT_W),
        ("WALL_MAX", [wall[1] for wall in walls], formats.COUNT_W),
        ("WALL_ENABLE", enabled, 1),
    ):
        lines.append(f"`define WH_BOARD_{name} {_packed(values, width)}")
    return "\n".join(lines) + "\n"
