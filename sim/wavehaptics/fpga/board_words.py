# SPDX-License-Identifier: Apache-2.0
"""From a board's scene to the words that its bitstream holds, as Verilog macros.

A board's top gives ``wh_controller`` constants instead of registers. They are computed here from
the board's scene and from the data sheet of its ADC, so that no number is typed twice.
"""

from __future__ import annotations

from dataclasses import dataclass

from wavehaptics.controller.pins_timing import CORE_CLOCKS, early_tick_clocks
from wavehaptics.ladder import guarded_pins
from wavehaptics.ladder.pins import Ports, controller_ports, natural_ticks
from wavehaptics.parts.adcs import Part, frame
from wavehaptics.scene import Scene, SceneError
from wavehaptics.words import formats
from wavehaptics.words.bridge_modes import MODE_WORDS, UNIPOLAR

WIDTHS = {
    "half_clocks": formats.TICK_W,
    "tick_halves": formats.TICK_W,
    "sample_clocks": formats.TICK_W,
    "samples": 9,
    "sample_lead": 8,
    "sample_late": 1,
    "sclk_half_clocks": 8,
    "frame_bits": 6,
    "lead_bits": 6,
    "data_bits": 5,
    "quiet_clocks": 8,
    "setup_clocks": 8,
    "hold_clocks": 8,
    "calibrate_bits": 6,
    "sclk_idle": 1,
    "read_trailing": 1,
    "trip": 16,
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
    "mode": formats.MODE_W,
    "min_pulse": 8,
    "clocks_per_volt": formats.COEF_W,
    "bus_share": formats.COEF_W,
    "dead_clocks": 8,
    "compensate": 1,
    "side_current": formats.DATA_W,
    "settle_ticks": 8,
    "second_order": 1,
}
"""Bits of each setting of ``wh_controller``; ``None`` is DELAY_LOG2, which is chosen here."""

_PER_PORT = frozenset(
    (
        "zero",
        "gain",
        "eta_contact",
        "eta_free",
        "root",
        "a",
        "u_max",
        "clocks_per_volt",
        "side_current",
    )
)


@dataclass(frozen=True)
class BoardWords:
    """What a board's bitstream is made with.

    ``words`` as in :class:`wavehaptics.ladder.pins.Ports`.
    """

    ports: Ports
    words: dict[str, int]
    motors: int
    delay_log2: int
    guard: int | None
    """The guard's word; None for a board without one."""

    @property
    def walls(self) -> list[tuple[int, int]]:
        """Walls (min, max) in counts; an empty one where the scene has none."""
        return self.ports.walls or [(0, 0)]


def board_words(scene: Scene, part: Part, motors: int = 1, *, guarded: bool = False) -> BoardWords:
    """Words of a board with ``motors`` equal motors and the converter ``part`` for each.

    :class:`SceneError` where the scene's ADC isn't the part, or its clock or tick doesn't suit it.
    """
    if scene.adc is None or scene.adc.bits != part.bits:
        raise SceneError(f"{_at(scene)}the board's ADC has {part.bits} bits; set adc.bits so")
    if scene.adc.part not in (None, part.name):
        raise SceneError(f"{_at(scene)}the board's ADC is an {part.name}; set adc.part so")
    ports = controller_ports(scene, lambda clock_hz, _: frame(part, clock_hz))
    words = dict(ports.words, hold_ticks=_hold_ticks(scene, ports, motors))
    delay_log2 = max(1, words["extra_ticks"].bit_length())
    return BoardWords(ports, words, motors, delay_log2, _guard(scene, ports) if guarded else None)


def _guard(scene: Scene, ports: Ports) -> int:
    limits = guarded_pins.board_limits(scene, ports)
    return guarded_pins.settings(limits, ports.timing.tick_s, ports.sensor, ports.settings.s)


def _at(scene: Scene) -> str:
    return f"{scene.scene.name}: "


def _hold_ticks(scene: Scene, ports: Ports, motors: int) -> int:
    """Ticks that a voltage waits, so that the latency is the scene's ``extra_ticks``."""
    laid, lead = ports.timing, ports.words["sample_lead"] - ports.words["sample_late"]
    natural = natural_ticks(
        laid.tick_clocks, laid.samples, lead, laid.frame, motors, early=laid.early
    )
    extra = ports.settings.extra_ticks
    if extra < natural:
        raise SceneError(
            f"{_at(scene)}controller.extra_ticks = {extra} is less than the board needs: a voltage "
            f"is ready {natural} ticks of {laid.tick_clocks} clocks late; set extra_ticks = "
            f"{natural} or more"
        )
    early = early_tick_clocks(motors, ports.settings.anchored)
    needed = early if laid.early else CORE_CLOCKS * motors
    if needed > laid.tick_clocks:
        raise SceneError(
            f"{_at(scene)}a tick of {laid.tick_clocks} clocks is shorter than the "
            f"{needed} that {motors} motors need; lower controller.tick_hz"
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
        f"`define WH_BOARD_MODES {int(board.words['mode'] != MODE_WORDS[UNIPOLAR])}",
        f"`define WH_BOARD_SHORTEST {int(board.words['min_pulse'] > 0)}",
        f"`define WH_BOARD_DELAY_LOG2 {board.delay_log2}",
        f"`define WH_BOARD_EARLY {int(board.ports.timing.early)}",
        f"`define WH_BOARD_GUARDED {int(board.guard is not None)}",
        f"`define WH_BOARD_GUARD {_literal(board.guard or 0, guarded_pins.WIDTH)}",
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
