# SPDX-License-Identifier: Apache-2.0
"""Latencies of ``rtl/wh_controller.v``, and of ``rtl/wh_ports.v``, in clocks.

A cocotb test measures each at the RTL.
"""

from __future__ import annotations

from wavehaptics.controller.surfaces import MOST_ACTIVE
from wavehaptics.words.table import AXES, THREE_PHASE_LEGS

CORE_CLOCKS = 24
"""Clocks that one port's step takes in ``wh_wave_core``."""

SECTION_CLOCKS = 5
"""Clocks that each section of W adds to it."""

GATE_CLOCKS = 2
"""Clocks from the carrier's phase to the gates, dead time aside: ``wh_pwm``, ``wh_half_bridge``."""

HOLD_CLOCKS = 1
"""Clocks from the carrier's sample strobe to the fall of CS, where the ADC holds its input."""

CENTRED_LEAD = HOLD_CLOCKS - GATE_CLOCKS
"""``sample_lead_i`` with which the ADC holds its input in the exact middle of the gates' pulse."""

WAVES_CLOCKS = 6
"""Clocks from the start of a port's step to the start of its anchor's, ``wh_anchor``."""

ANCHOR_CLOCKS = 29
"""Clocks from there until it is done, if the shared multiplier lets it."""

CURRENT_CLOCKS = 6
"""Clocks from a tick's last word to its mean current, ``wh_current``."""

SUM_CLOCKS = 3
"""Clocks from a tick's last word to the first port's turn in ``rtl/wh_ports.v``: ``wh_sense``."""

CORRECTION_CLOCKS = 1
"""Clocks that it takes to add the anchor's voltage."""

DUTY_CLOCKS = 8
"""Clocks from a step's voltage to the soonest tick that it can drive, ``wh_modulator``."""

ENCODER_CLOCKS = 3
"""Clocks from an encoder's pin to ``position_o``, its filter aside: ``wh_quadrature``."""

FLUX_CLOCKS = 6
"""Clocks from there to the position that belongs to the rotor's flux, ``wh_rotor_flux``."""


def step_end_clocks(conversion_clocks: int, ports: int = 1, sections: int = 0) -> int:
    """Clocks from the sample strobe that :func:`latency_clocks` means to the last step's end."""
    step = CORE_CLOCKS + SECTION_CLOCKS * sections
    return conversion_clocks + CURRENT_CLOCKS + ports - 1 + step * ports


def latency_clocks(
    conversion_clocks: int, ports: int = 1, sections: int = 0, anchored: bool = False
) -> int:
    """Clocks from a sample strobe to the soonest tick strobe after which its voltage is driven.

    ``conversion_clocks`` are the ADC reader's from the strobe to the word
    (:attr:`wavehaptics.parts.adcs.Frame.conversion_clocks`). Then come the mean current, the wave
    core's step for each port, and the duty; currents and duties of several ports pass one
    multiplier in turn. ``sections`` are those of W, SHAPER. The strobe meant is the carrier's that
    brings the tick's last word. ``anchored`` is ``wh_controller``'s ANCHOR.
    """
    step_end = step_end_clocks(conversion_clocks, ports, sections)
    return step_end + CORRECTION_CLOCKS * anchored + DUTY_CLOCKS + ports - 1


def shortest_tick_clocks(
    ports: int = 1, sections: int = 0, anchored: bool = False, shared: bool = False
) -> int:
    """Clocks of the shortest tick of motors with brushes: the steps of all ports, or of an anchor.

    ``sections`` are those of W; ``shared`` is ``wh_controller``'s SHARED.
    """
    needed = (CORE_CLOCKS + SECTION_CLOCKS * sections) * ports
    if anchored:
        needed = max(needed, ANCHOR_CLOCKS)
    if shared:
        needed = max(needed, shared_tick_clocks(ports, anchored))
    return needed


def turn_clocks(sections: int = 0) -> int:
    """Clocks from a port's turn to the next one's in ``rtl/wh_ports.v``: ``wh_slots``."""
    return 36 if sections == 2 else 32


def turns_clocks(
    motors: int, sections: int = 0, *, brushless: bool = False, surfaces: int = 0
) -> int:
    """Clocks of the shortest period in which ``motors`` ports take their turns, one or more.

    ``brushless`` motors have two ports each: their axes. ``surfaces`` may be across the others.
    """
    if brushless:
        return turn_clocks(sections) * (AXES * motors - 1) + BETA_CLOCKS[sections]
    turns = turn_clocks(sections) * (motors - 1) + (42 if sections == 2 else 38)
    return turns + max(look_clocks(motors, surfaces))


def surface_clocks(motors: int, surfaces: int, acting: int, lossy: bool) -> int:
    """Clocks of ``rtl/wh_surfaces.v`` from the last port's v to the last port's goal.

    ``acting`` of its ``surfaces`` do, and ``lossy`` means that there is a loss across them.
    """
    clocks = 9 + motors + (2 + motors) * surfaces
    if acting:
        clocks += 17 + (37 + 3 * motors) * acting
    if lossy and acting == 1:
        clocks += 16 + 3 * motors
    if lossy and acting == 2:
        clocks += 35 + 11 * motors
    return clocks


def look_clocks(motors: int, surfaces: int) -> tuple[int, int]:
    """Clocks that a round's first pass in ``rtl/wh_ports.v`` takes, the fewest and the most.

    They depend on how many ``surfaces`` act; without any there is no first pass.
    """
    if not surfaces:
        return 0, 0
    law = [
        surface_clocks(motors, surfaces, acting, lossy)
        for acting in range(min(surfaces, MOST_ACTIVE) + 1)
        for lossy in (False, True)
    ]
    fewest, most = (turn_clocks() * (motors - 1) + max(38, 18 + one(law)) for one in (min, max))
    return fewest, most


BETA_CLOCKS = (42, 58, 63)
"""Clocks from the turn of a brushless motor's second axis to the next round, by sections of W."""

LEGS_CLOCKS = (54, 70, 75)
"""Clocks that such a turn adds to the latency instead of 43 and those of W."""


def least_half_clocks(motors: int, *, brushless: bool = False) -> int:
    """Clocks of the shortest half of a carrier period, of ``motors`` that share a walk.

    The walk is along the legs, three of a ``brushless`` motor, which has clocks more.
    """
    return THREE_PHASE_LEGS * motors + 11 if brushless else motors + 8


def turn_begin_clocks(conversion_clocks: int, motor: int = 0, sections: int = 0) -> int:
    """Clocks to the turn of a motor's port, whose position is that of then.

    They count from the sample strobe that :func:`latency_clocks` means.
    """
    return conversion_clocks + SUM_CLOCKS + turn_clocks(sections) * motor


def turns_latency_clocks(
    conversion_clocks: int, motors: int, sections: int = 0, *, brushless: bool = False
) -> int:
    """As :func:`latency_clocks`, of ``rtl/wh_ports.v``."""
    if brushless:
        last = turn_clocks(sections) * (AXES * motors - 1)
        return conversion_clocks + last + LEGS_CLOCKS[sections] + THREE_PHASE_LEGS * motors
    last = turn_clocks(sections) * (motors - 1)
    return conversion_clocks + last + 43 + motors + SECTION_CLOCKS * sections


def shared_tick_clocks(ports: int = 1, anchored: bool = False) -> int:
    """Clocks of a tick with SHARED in which all products come in time; a shorter one may do.

    No voltage of a step asks for one when the next step has begun, and no current before the core
    has asked for its last. The last port's anchor has time to wait for each of them, and for two of
    the core's.
    """
    needed = (CORE_CLOCKS + 1) * ports + anchored
    if anchored:
        waits = 2 + 2 * ports
        needed = max(needed, CORE_CLOCKS * (ports - 1) + WAVES_CLOCKS + ANCHOR_CLOCKS + waits)
    return needed
