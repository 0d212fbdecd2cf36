# SPDX-License-Identifier: Apache-2.0
"""Scenes: what is to be simulated, read from TOML, checked, and immutable.

``sim/scenes/README.md`` describes the format; a test holds that page and this schema together.
Every angle, speed and torque is the rotor's. Units are SI and stand in each key's metadata.
A further table is a module in ``tables`` and a field of ``schema``'s Scene.
"""

from wavehaptics.runtime.repository import SCENES_DIR
from wavehaptics.scene.device import Device
from wavehaptics.scene.loading import (
    device_of,
    find_scene,
    first_comment,
    load_device,
    load_scene,
    read_scene,
    shipped_scenes,
)
from wavehaptics.scene.places import SceneError
from wavehaptics.scene.schema import TABLES, Scene, drive_gain, encoder_end, without_anchor
from wavehaptics.scene.space import SPACE_TABLES, Space

__all__ = [
    "SCENES_DIR",
    "SPACE_TABLES",
    "TABLES",
    "Device",
    "Scene",
    "SceneError",
    "Space",
    "device_of",
    "drive_gain",
    "encoder_end",
    "find_scene",
    "first_comment",
    "load_device",
    "load_scene",
    "read_scene",
    "shipped_scenes",
    "without_anchor",
]
