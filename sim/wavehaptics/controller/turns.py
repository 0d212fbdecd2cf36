# SPDX-License-Identifier: Apache-2.0
"""Settings of ``rtl/wh_ports.v``, in which several motors with brushes take turns.

The settings of each motor are those of :mod:`.ports` for its scene, on a period that is long enough
for all of them. What the motors share has to be the same in all scenes.
"""

from __future__ import annotations

from collections.abc import Sequence

from wavehaptics.controller import guard
from wavehaptics.controller.ports import Ports, controller_ports
from wavehaptics.controller.tick_layout import sections_of
from wavehaptics.scene import Scene
from wavehaptics.words import table
from wavehaptics.words.memory import settings_requests
from wavehaptics.words.table import WORDS, Sizes, Values

MOST_MOTORS = 8
CHANNELS = "command"
"""Kind of a converter that measures the currents of all motors, one after another."""

_PACKED = (("carrier",), ("frame",), ("trip", "sense", "zero"), ("encoder",), ("delay",),
           ("bridge",), ("guard", "saturated"), ("host",))  # fmt: skip
"""Groups of ``rtl/words.toml`` whose settings ``wh_ports`` has once, by its ports."""


def take_turns(scenes: Sequence[Scene]) -> bool:
    """Whether the motors of these scenes are ports of one controller."""
    return len(scenes) > 1 and not any(scene.motor.brushless for scene in scenes)


def sections(scenes: Sequence[Scene]) -> int:
    """Sections of W that each motor has, which is as many as any of them needs."""
    return max(map(sections_of, scenes))


def turns_ports(scenes: Sequence[Scene], surfaces: int = 0) -> list[Ports]:
    """Settings for each motor; :class:`SceneError` where one controller can't do what they ask for.

    Their timing is the same, and has time for so many ``surfaces`` across them.
    """
    motors = len(scenes)
    if motors > MOST_MOTORS:
        raise scenes[MOST_MOTORS].refusal(
            f"the scene has {motors} motors, and one controller has {MOST_MOTORS}; leave some "
            "out or take `golden`",
            "motor",
        )
    most = sections(scenes)
    found = [
        controller_ports(scene, turns=motors, most_sections=most, surfaces=surfaces)
        for scene in scenes
    ]
    kind = found[0].timing.frame.kind
    if kind == CHANNELS and motors > 1:
        part = scenes[0].adc and scenes[0].adc.part
        raise scenes[0].refusal(
            f"adc.part = {part} has a channel for each motor, and `pins` simulates its first; "
            "take another part, or run one motor with --motor",
            "adc.part",
        )
    _check_shared(scenes, found)
    return found


def _check_shared(scenes: Sequence[Scene], ports: Sequence[Ports]) -> None:
    """:class:`SceneError` where motors ask for different words of what the controller has once."""
    values = [
        {**one.words, **(guard.scene_words(scene, one) if scene.guard else {})}
        for scene, one in zip(scenes, ports, strict=True)
    ]
    shared = {group for groups in _PACKED for group in groups}
    for name in [name for name in values[0] if WORDS[name].group in shared]:
        for scene, own in zip(scenes, values, strict=True):
            if own.get(name) != values[0][name]:
                cure, *keys = _SAME.get(WORDS[name].group, _SAME["frame"])
                raise scene.refusal(
                    f"{name} is {own.get(name)} for this motor and {values[0][name]} for the "
                    f"first, and one controller has it once; {cure}, or run one with --motor",
                    *keys,
                )


_SAME = {
    "guard": ("give all motors the same adc.full_scale_a, R and walls, or leave [guard] out",
              "guard"),
    "saturated": ("give all motors the same guard.saturated_s", "guard"),
    "trip": ("give all motors the same adc.full_scale_a, or leave [guard] out", "guard"),
    "frame": ("give all motors an [adc] and a [drive], or none of them", "adc", "drive", "motor"),
}  # fmt: skip
"""By a word's group: how it becomes the same, and the keys that it hangs on."""


def shared_words(values: Values, sizes: Sizes, ports: int) -> list[int]:
    """What ``wh_ports`` has once: each packed port in parts of 32 bits, the lowest first.

    The magnets' words come last, for each of so many ``ports``.
    """
    found: list[int] = []
    for groups, copies in (*((groups, 1) for groups in _PACKED), (("magnet",), ports)):
        words = [w for w in WORDS.values() if w.group in groups and w.row.kind == "setting"]
        fields = [(int(values.get(w.name, w.default)), w.width(sizes)) for w in words] * copies  # type: ignore[arg-type]
        raw, width = table.side_by_side(fields), sum(bits for _, bits in fields)
        found += [raw >> place & 0xFFFFFFFF for place in range(0, width, 32)]
    return found


def port_requests(values: Values, sizes: Sizes, motor: int) -> list[tuple[int, int]]:
    """(address, raw word) of every setting of one port, which has no defaults of its own."""
    found: dict[int, int] = {}
    for word in WORDS.values():
        if word.row.kind == "setting" and word.row.per != "board" and word.row.brushless != "only":
            copies = word.row.count * {"wall": sizes.walls, "section": sizes.sections}.get(
                word.row.per, 1
            )
            found |= {word.at(motor, n): word.default & 0xFFFFFFFF for n in range(copies)}
    own = settings_requests(values, motor=motor)
    return list((found | {at: raw for at, raw in own if at in found}).items())
