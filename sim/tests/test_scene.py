# SPDX-License-Identifier: Apache-2.0
"""Scenes: what is taken, what is refused and in which words, and the description of the format."""

from __future__ import annotations

import os
import pickle
import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from wavehaptics.parts.motors import PRESETS
from wavehaptics.runtime.toml_source import parse
from wavehaptics.scene import (
    SCENES_DIR,
    SPACE_TABLES,
    TABLES,
    Scene,
    SceneError,
    find_scene,
    load_device,
    load_scene,
    shipped_scenes,
)
from wavehaptics.scene.keys import field_texts

BASE = """\
[scene]
name = "bench"
duration_s = 1
[motor]
preset = "re25-118743"
[controller]
tick_hz = 1e6
lambda = 1e4
"""
AFTER_BASE = BASE.count("\n") + 1
PRESET = 'preset = "re25-118743"'
PRESET_LINE = 5
HAND = "[hand]\namplitude_rad = 0.1\nstiffness = 0.1\n"


def load_text(folder: Path, text: str | bytes, *overrides: str) -> Scene:
    path = folder / "bench.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return load_scene(path, overrides)


def refusal(folder: Path, text: str | bytes, *overrides: str) -> str:
    """The message of a refusal without the folder; it is one printable line."""
    with pytest.raises(SceneError) as refused:
        load_text(folder, text, *overrides)
    message = str(refused.value)
    assert message.isprintable()
    assert ";" in message
    return message.removeprefix(f"{folder}{os.sep}")


def in_motor(lines: str) -> str:
    """A scene with ``lines`` in place of the motor's preset, from line 5 on."""
    return BASE.replace(PRESET, lines)


def test_smallest_scene_and_its_defaults(tmp_path):
    scene = load_text(tmp_path, BASE)
    assert scene.scene.name == "bench"
    assert scene.scene.duration_s == 1.0
    assert scene.scene.trace_hz is None
    preset = PRESETS["re25-118743"]
    assert scene.motor.model_dump(include=set(preset._fields)) == preset._asdict()
    assert scene.motor.kind == "dc"
    absent = ("friction", "hand", "encoder", "adc", "drive", "thermal", "transmission", "shaper")
    assert all(getattr(scene, table) is None for table in absent)
    controller = scene.controller
    assert (controller.tick_hz, controller.lambda_, controller.extra_ticks) == (1e6, 1e4, 1)
    assert (controller.eta_contact, controller.eta_free, controller.walls) == (-1.0, 1.0, ())
    assert controller.r_hat == 2.18
    assert controller.clock_hz is None


def test_every_key_is_read(tmp_path):
    text = """
        scene = {name = "all", duration_s = 2.5, trace_hz = 1e3}
        motor = {preset = "re40-148877", R_ohm = 3, L_h = 1e-3, k_t = 0.05, J_kgm2 = 1e-6}
        friction = {coulomb_nm = 1e-3, viscous = 1e-6}
        hand = {path = "sine", amplitude_rad = 1, frequency_hz = 2, stiffness = 3, damping = 4}
        encoder = {counts_per_rev = 4096}
        adc = {bits = 12, full_scale_a = 5, noise_a = 1e-3, offset_a = -2e-3}
        drive.bus_v = 24
        drive.limit_v = 12
        drive.pwm_hz = 1e5
        drive.dead_time_s = 1e-7
        drive.compensate = false
        drive.gain_error = 0.05
        transmission.ratio = 8
        transmission.lever_m = 0.14
        [controller]
        tick_hz = 1e5
        extra_ticks = 3
        lambda = 5e3
        eta_contact = -0.5
        eta_free = 0.9
        walls = [[1, 2], [-2.0, -1.0]]
        r_hat = 2.9
        clock_hz = 50e6
        anchor_auto = false
    """
    scene = load_text(tmp_path, text)
    assert scene.motor.R_ohm == 3.0
    assert scene.hand.damping == 4.0
    assert scene.adc.offset_a == -2e-3
    assert scene.drive.pwm_hz == 1e5
    assert scene.transmission.lever_m == 0.14
    assert scene.controller.walls == ((1.0, 2.0), (-2.0, -1.0))
    assert (scene.controller.r_hat, scene.controller.clock_hz) == (2.9, 50e6)


@pytest.mark.parametrize("preset", PRESETS)
def test_presets(tmp_path, preset):
    scene = load_text(tmp_path, in_motor(f'preset = "{preset}"\nk_t = 0.5'))
    assert scene.motor.k_t == 0.5
    assert scene.motor.L_h == PRESETS[preset].L_h


def test_presets_reproduce_the_stiffnesses_of_the_paper():
    stiffness = {name: motor.k_t**2 / motor.L_h for name, motor in PRESETS.items()}
    assert stiffness["re25-118743"] == pytest.approx(2.2815, abs=1e-12)
    assert stiffness["re25-phantom"] * (8 / 0.14) ** 2 == pytest.approx(7500, rel=0.01)


@pytest.mark.parametrize(
    ("keys", "bus_v", "limit_v"),
    [
        ("limit_v = 2.1", 12.0, 2.1),
        ("limit_v = 12", 12.0, 12.0),
        ("limit_v = 12.1", 24.0, 12.1),
        ("limit_v = 30", 48.0, 30.0),
        ("limit_v = 60\nbus_v = 60", 60.0, 60.0),
        ("bus_v = 36", 36.0, 36.0),
        ("gain_error = 0.05", None, None),
    ],
)
def test_drive_defaults(tmp_path, keys, bus_v, limit_v):
    drive = load_text(tmp_path, f"{BASE}[drive]\n{keys}").drive
    assert (drive.bus_v, drive.limit_v) == (bus_v, limit_v)


def test_scene_is_immutable_hashable_and_picklable(tmp_path):
    scene = load_text(tmp_path, BASE + "walls = [[0.0, 1.0]]")
    with pytest.raises(ValidationError):
        scene.motor.R_ohm = 1.0
    with pytest.raises(ValidationError):
        scene.controller = None
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert isinstance(hash(scene), int)


def test_byte_order_mark_and_carriage_returns(tmp_path):
    text = BASE.replace("\n", "\r\n")
    assert load_text(tmp_path, b"\xef\xbb\xbf" + text.encode()).scene.name == "bench"
    assert refusal(tmp_path, text + "eta_free = 2\r\n").startswith("bench.toml:9: ")


def test_touching_walls_do_not_overlap(tmp_path):
    assert load_text(tmp_path, BASE + "walls = [[0, 1], [1, 2]]").controller.walls[1] == (1, 2)


@pytest.mark.parametrize(
    ("lines", "line", "fragments"),
    [
        # unknown keys
        (
            "R = 2.18",
            5,
            ["unknown key motor.R;", "did you mean R_ohm?", "takes preset, R_ohm, L_h"],
        ),
        (f"{PRESET}\nk_T = 1", 6, ["unknown key motor.k_T;", "did you mean k_t?"]),
        (f"{PRESET}\nlimit_v = 2", 6, ["unknown key motor.limit_v;", "belongs in [drive]"]),
        (f"{PRESET}\nzzz = 2", 6, ["unknown key motor.zzz; [motor] takes"]),
        (f'{PRESET}\n"a\\nb" = 2', 6, ['unknown key motor."a\\nb";']),
        (f"{PRESET}\n[motor.winding]\nx = 1", 6, ["unknown key motor.winding;"]),
        # types and units
        ('L_h = "0.24 mH"', 5, ["a number in H", 'the string "0.24 mH"', "write 0.24e-3"]),
        (f'{PRESET}\nL_h = "0.24mH"', 6, ["write 0.24e-3"]),
        (f'{PRESET}\nL_h = "240 µH"', 6, ["write 240e-6"]),
        (f'{PRESET}\nL_h = "2.4e-1 mH"', 6, ["write 2.4e-4"]),
        (f'{PRESET}\nL_h = "0.24e-3"', 6, ["write 0.24e-3"]),
        (f'{PRESET}\nL_h = "0.24 mF"', 6, ["write the number alone, 1e-6 to 1 H"]),
        (f'{PRESET}\nL_h = ""', 6, ["write the number alone"]),
        (f'{PRESET}\nR_ohm = "2.18 Ohm"', 6, ["a number in Ω", "write 2.18"]),
        (f'{PRESET}\nR_ohm = "2.18 kΩ"', 6, ["write 2.18e3"]),
        (f'{PRESET}\nk_t = "23.4 mNm/A"', 6, ["write 23.4e-3"]),
        (f'{PRESET}\nk_t = "23.4 mN·m/A"', 6, ["write 23.4e-3"]),
        (f'{PRESET}\nJ_kgm2 = "10.3 g·cm²"', 6, ["a number in kg·m²", "write 10.3e-7"]),
        (f"{PRESET}\nk_t = true", 6, ["must be a number in N·m/A, not true"]),
        (f"{PRESET}\nk_t = [1]", 6, ["not an array"]),
        (f"{PRESET}\nk_t = {{a = 1}}", 6, ["not a table"]),
        (f"{PRESET}\nk_t = 2020-01-01", 6, ["not 2020-01-01"]),
        ("preset = 25", 5, ["motor.preset must be a string in quotes, not 25"]),
        # values
        (f"{PRESET}\nL_h = -0.24e-3", 6, ["motor.L_h = -0.00024 is out of range", "1e-6 to 1 H"]),
        (f"{PRESET}\nL_h = 0", 6, ["motor.L_h = 0 is out of range"]),
        (f"{PRESET}\nR_ohm = 128", 6, ["0.01 to 127 Ω"]),
        (f"{PRESET}\nk_t = nan", 6, ["finite", "nan"]),
        (f"{PRESET}\nk_t = -inf", 6, ["finite", "-inf"]),
        (f"{PRESET}\nk_t = 1e999", 6, ["finite", "inf"]),
        (f"{PRESET}\nk_t = 0x{'F' * 3000}", 6, ["an integer of 12000 bits"]),
        (f"{PRESET}\nk_t = {'9' * 4500}", 6, ["4506 characters", "at most 4000"]),
        ('preset = "re25-11874"', 5, ["is unknown", 'did you mean "re25-118743"?', "re30-48v"]),
        ('preset = "x"\nR_ohm = 2', 5, ['"x" is unknown; known: re25-118743']),
        ("R_ohm = 2.18\nL_h = 1e-3", 4, ["motor.k_t is missing; give preset, or all of R_ohm"]),
        # syntax
        ("R_ohm = 2.18 Ohm", 5, ["not valid TOML", "write the number alone, without a unit"]),
        ("preset = re25-118743", 5, ["not valid TOML", "a string stands in quotes"]),
        ('preset = "re25-118743', 5, ["a string ends with its quote on the same line"]),
        ("R_ohm = .5", 5, ["digits on both sides of its point"]),
        ("R_ohm = 2.", 5, ["digits on both sides of its point"]),
        ("R_ohm = 2,18", 5, ["the decimal sign is a point"]),
        ("R_ohm =", 5, ["a value stands after the ="]),
        ("R_ohm: 2.18", 5, ["with = in place of :"]),
        ("R_ohm 2.18", 5, ["a line is key = value"]),
        ("[motor", 5, ["a table is [name]"]),
        ("k_t = 2020-02-31", 5, ["not valid TOML"]),
        ("R_ohm = 2\0", 5, ["not valid TOML"]),
        (f"{PRESET}\n\n{PRESET}", 7, ["motor.preset is given twice, first on line 5"]),
        (f"{PRESET}\n[motor]", 6, ["table [motor] is given twice, first on line 4"]),
        (
            f"{PRESET}\nk_t = 1\n# k_t\nk_t = [\n1]",
            8,
            ["motor.k_t is given twice, first on line 6"],
        ),
        (f"{PRESET}\nmotor.k_t = {{b = 1, b = 2}}", 6, ["given twice"]),
    ],
)
def test_refused_in_motor(tmp_path, lines, line, fragments):
    message = refusal(tmp_path, in_motor(lines))
    assert message.startswith(f"bench.toml:{line}: ")
    for fragment in fragments:
        assert fragment in message


@pytest.mark.parametrize(
    ("lines", "offset", "fragments"),
    [
        ("[motr]\nx = 1", 0, ["unknown table [motr]; did you mean [motor]?"]),
        ("[zzz]", 0, ["unknown table [zzz]; the tables are [scene], [motor]"]),
        ("[[adc]]\nbits = 12", 0, ["adc must be a table, not an array; write [adc]"]),
        # friction, encoder, adc
        ("[friction]\nviscous = -1", 1, ["0 to 100 N·m·s/rad"]),
        ("[encoder]", 0, ["encoder.counts_per_rev is missing"]),
        ("[encoder]\ncounts_per_rev = 2", 1, ["a multiple of 4 from 4 to 4e6"]),
        ("[encoder]\ncounts_per_rev = 10", 1, ["a multiple of 4 from 4 to 4e6"]),
        ("[encoder]\ncounts_per_rev = 1e4", 1, ["whole number, not 10000.0; write 10000"]),
        ("[encoder]\ncounts_per_rev = 4.5", 1, ["whole number, not 4.5; use a multiple of 4"]),
        ("[adc]\nbits = 7\nfull_scale_a = 2", 1, ["adc.bits = 7", "8 to 16 bits"]),
        ("[adc]\nbits = 17\nfull_scale_a = 2", 1, ["adc.bits = 17", "8 to 16 bits"]),
        ("[adc]\nfull_scale_a = 2", 0, ["adc.bits is missing; give 8 to 16 bits"]),
        ('[adc]\npart = "AD7476"', 1, ['adc.part "AD7476" is unknown; did you mean "AD7476A"?']),
        ("[adc]\npart = 7276", 1, ["adc.part must be a string in quotes, not 7276"]),
        (
            '[adc]\npart = "ADS7056"\nbits = 12',
            2,
            ['adc.bits = 12 contradicts adc.part = "ADS7056", which has 14; leave bits out'],
        ),
        ("[adc]\nbits = 12\noffset_a = 12", 2, ["leaves the range of ±11.0092 A"]),
        ("[adc]\nbits = 12\nfull_scale_a = 64", 2, ["0.001 to 63 A"]),
        ("[adc]\nbits = 12\nfull_scale_a = 2\noffset_a = -2", 3, ["leaves the range of ±2 A"]),
        # drive
        ("[drive]\nbus_v = 12\n\nlimit_v = 13", 3, ["limit_v = 13 is above bus_v = 12"]),
        ("[drive]\nlimit_v = 49", 1, ["drive.bus_v is missing", "give bus_v"]),
        ("[drive]\npwm_hz = 1e6\ndead_time_s = 0.5e-6", 2, ["must be below 5e-7 s"]),
        ('[drive]\ngain_error = "5 %"', 1, ["write 5e-2"]),
        ('[drive]\nlimit_v = "2100 mV"', 1, ["write 2100e-3"]),
        # hand
        ("[hand]\namplitude_rad = 1", 0, ["hand.path is missing", "`taps`"]),
        (HAND + 'path = "tap"', 3, ['"tap" is unknown; did you mean "taps"? known: taps, press']),
        ('[drive]\nmode = "unipole"', 1, ['mean "unipolar"? known: unipolar, locked-anti-']),
        ('[shaper]\nfeel = "soft"', 1, ['"soft" is unknown; known: spring, layer, mass']),
        (HAND + "path = 1", 3, ["hand.path must be a string in quotes, not 1"]),
        (HAND + 'path = "taps"', 3, ["hand.frequency_hz is missing", "give it in Hz"]),
        (HAND + 'path = "free"', 3, ["hand.frequency_hz is missing"]),
        (HAND + 'path = "sine"', 3, ["hand.frequency_hz is missing"]),
        (HAND + 'path = "press"\nfrequency_hz = 1', 4, ["frequency_hz makes no sense", "press"]),
        (HAND + 'path = "press"\nspeed_rad_s = 1', 4, ["speed_rad_s makes no sense"]),
        (HAND + 'path = "press"\ndamping = -1', 4, ["hand.damping = -1", "0 to 1000 N·m·s/rad"]),
        (HAND + 'path = "impact"\nspeed_rad_s = 1', 2, ["stiffness makes no sense", "has no hand"]),
        (
            '[hand]\npath = "impact"\namplitude_rad = 1\nspeed_rad_s = 1\ndamping = 0',
            4,
            ["damping makes no sense", "it takes amplitude_rad, speed_rad_s"],
        ),
        ('[hand]\npath = "impact"\namplitude_rad = 1', 1, ["speed_rad_s is missing"]),
        ('[hand]\npath = "impact"\namplitude_rad = 1\nspeed_rad_s = 0', 3, ["is no impact"]),
        ('[hand]\npath = "press"\namplitude_rad = 1', 1, ["hand.stiffness is missing"]),
        ('[hand]\npath = "press"\nstiffness = 1', 0, ["hand.amplitude_rad is missing"]),
        # controller
        ("eta_contact = -1.1", 0, ["controller.eta_contact = -1.1", "-1 to 1"]),
        ("eta_free = 1.1", 0, ["controller.eta_free = 1.1", "-1 to 1"]),
        ("extra_ticks = -1", 0, ["0 to 1000 ticks"]),
        ("extra_ticks = 1001", 0, ["0 to 1000 ticks"]),
        ("r_hat = 127.1", 0, ["0.001 to 127 Ω"]),
        ("clock_hz = 48.3e6", 0, ["no whole multiple of tick_hz = 1e6; the nearest is 48e6"]),
        ("walls = [[0, 1], [2, 2]]", 0, ["walls[1] = [2, 2] is empty", "x_min < x_max"]),
        ("walls = [\n  [0, 1],\n  # far\n  [3, 2],\n]", 3, ["walls[1] = [3, 2] is empty"]),
        ("walls = [\n  [0, 1],\n  [5, 6],\n  [0.5, 2],\n]", 3, ["walls[2] overlaps walls[0]"]),
        ('walls = [\n  [0,\n "1 rad"]]', 2, ["walls[0][1] must be a number in rad", "write 1"]),
        ("walls = [0.0, 1.0]", 0, ["walls[0] must hold pairs", "walls = [[x_min, x_max]]"]),
        ("walls = [[0.0]]", 0, ["walls[0] must hold pairs"]),
        ("walls = [[0.0, 1.0, 2.0]]", 0, ["walls[0] must hold pairs"]),
        ("walls = 1", 0, ["controller.walls must hold pairs"]),
        ("walls = [[0, inf]]", 0, ["walls[0][1] must be a finite number"]),
        ("walls = [[0, 1001]]", 0, ["walls[0][1] = 1001 is out of range"]),
        # thermal
        ("[thermal]\nrth = 14", 1, ["unknown key thermal.rth", "rth_"]),
        ("[thermal]\ntau_winding_s = 0", 1, ["thermal.tau_winding_s = 0", "0.5 to 1e6 s"]),
        # anchor
        ("anchor_auto = 0", 0, ["controller.anchor_auto = 0", "true, false"]),
        ("anchor_ohm = 0", 0, ["controller.anchor_ohm = 0", "0.001 to 1000"]),
        ("r_hat_part = 0.8", 0, ["r_hat_part belongs to a port anchor; add anchor_auto = true"]),
        ('shaper = "notch"', 0, ["controller.shaper", "[controller] takes"]),
        # order of the file
        ("eta_free = 2\n[motr]\n[drive]\nbus_v = 0", 0, ["controller.eta_free"]),
        ("[motr]\n[drive]\nbus_v = 0", 0, ["unknown table [motr]"]),
    ],
)
def test_refused_after_the_base(tmp_path, lines, offset, fragments):
    message = refusal(tmp_path, BASE + lines)
    assert message.startswith(f"bench.toml:{AFTER_BASE + offset}: ")
    for fragment in fragments:
        assert fragment in message


@pytest.mark.parametrize(
    ("old", "new", "line", "fragment"),
    [
        (
            "tick_hz = 1e6",
            "tick_hz = 0",
            7,
            "controller.tick_hz = 0 is out of range; it must be 10",
        ),
        ("tick_hz = 1e6", "tick_hz = 5e6", 7, "10 to 4e6 Hz"),
        ("tick_hz = 1e6", 'tick_hz = "1 MHz"', 7, "write 1e6"),
        ("tick_hz = 1e6\n", "", 6, "controller.tick_hz is missing; give 10 to 4e6 Hz"),
        ("lambda = 1e4\n", "", 6, "controller.lambda is missing; give 1 to 1e9 rad/s"),
        ("lambda = 1e4", "lambda = 0", 8, "controller.lambda = 0 is out of range"),
        ("lambda = 1e4", "lambda_ = 1e4", 8, "controller.lambda_; did you mean lambda?"),
        ("duration_s = 1", "duration_s = 0", 3, "scene.duration_s = 0 is out of range"),
        ("duration_s = 1", "duration_s = -1.0", 3, "scene.duration_s = -1.0 is out of range"),
        ("duration_s = 1", "duration_s = 1\ntrace_hz = 0", 4, "scene.trace_hz = 0"),
        ("duration_s = 1", 'duration_s = "150 ms"', 3, "write 150e-3"),
        ("duration_s = 1", "duration = 1", 3, "did you mean duration_s?"),
        ('name = "bench"', "name = 1", 2, "scene.name must be a string in quotes, not 1"),
        ('name = "bench"', 'name = "a/b"', 2, "can't name a folder"),
        ('name = "bench"', 'name = " "', 2, "can't name a folder"),
        ('name = "bench"', 'name = """a\nb"""', 2, "can't name a folder"),
        ("[motor]\npreset", "[motor]\n[friction]\npreset", 6, "unknown key friction.preset"),
        ("[scene]\n", "tick_hz = 1\n[scene]\n", 1, "tables; it belongs in [controller]"),
        ("[scene]\n", "zzz = 1\n[scene]\n", 1, "unknown key zzz outside the tables"),
        ("[scene]\n", "drive = 3\n[scene]\n", 1, "drive must be a table, not 3; write [drive]"),
        ("[scene]\n", "# c\nadc = {bits = 12, full_scale_a = 0}\n[scene]\n", 2, "full_scale_a = 0"),
        ("[scene]\n", "drive.bus_v = 1\ndrive.limit_v = 2\n[scene]\n", 2, "limit_v = 2 is above"),
        ("[scene]\n", '"drive"."bus_v" = 0\n[scene]\n', 1, "drive.bus_v = 0 is out of range"),
        ("[motor]", "# μ\n[ motor ] # é", 5, "motor.J_kgm2 is missing"),
    ],
)
def test_refused_in_the_base(tmp_path, old, new, line, fragment):
    text = BASE.replace(old, new)
    if new.endswith("# é"):
        text = text.replace(PRESET, "R_ohm = 1\nL_h = 1\nk_t = 1")
    message = refusal(tmp_path, text)
    assert message.startswith(f"bench.toml:{line}: ")
    assert fragment in message


@pytest.mark.parametrize("table", ["scene", "motor", "controller"])
def test_missing_table(tmp_path, table):
    text = re.sub(rf"\[{table}\]\n(?:[^\[].*\n)*", "", BASE)
    message = refusal(tmp_path, text)
    assert message.startswith(f"bench.toml:1: table [{table}] is missing")


def test_duration_of_less_than_a_tick(tmp_path):
    text = BASE.replace("duration_s = 1", "duration_s = 1e-3")
    assert load_text(tmp_path, text, "controller.tick_hz=1000").scene.duration_s == 1e-3
    message = refusal(tmp_path, text.replace("tick_hz = 1e6", "tick_hz = 500"))
    assert message.startswith("bench.toml:3: scene.duration_s = 0.001 is shorter than a tick")
    # The override made the two disagree, so it is what the message points at.
    message = refusal(tmp_path, text, "controller.tick_hz=500")
    assert message.startswith("--set controller.tick_hz=500: scene.duration_s = 0.001 is shorter")


def test_not_utf8(tmp_path):
    message = refusal(tmp_path, BASE.encode() + b"# \xb5H\n")
    assert message.startswith("bench.toml:9: byte 0xb5 is not UTF-8")


@pytest.mark.parametrize("text", ["x = " + "[" * 3000, "x = [\n" * 2000, "a." * 1900 + "b = 1"])
def test_deep_nesting(tmp_path, text):
    assert refusal(tmp_path, text).startswith("bench.toml:")


def test_files_that_cannot_be_read(tmp_path):
    cases = [
        (tmp_path / "none.toml", "no such file"),
        (tmp_path, "is a directory"),
        (tmp_path / ("x" * 300), "can't be read"),
        (Path("/dev/zero"), "larger than"),
        ("a\0b", "can't be read"),
    ]
    locked = tmp_path / "locked.toml"
    locked.write_text(BASE)
    locked.chmod(0)
    if not os.access(locked, os.R_OK):  # root reads everything
        cases.append((locked, "can't be read"))
    for path, fragment in cases:
        with pytest.raises(SceneError) as refused:
            load_scene(path)
        assert fragment in str(refused.value)
        assert str(refused.value).isprintable()


def test_overrides(tmp_path):
    scene = load_text(
        tmp_path,
        BASE,
        "controller.tick_hz=200e3",
        " motor.preset = re40-148877 ",
        "scene.name=two words",
        "controller.walls=[[0, 1]]",
        "hand.path=press",
        "hand.amplitude_rad=0.1",
        "hand.stiffness=0.1 # comment",
        "controller.tick_hz=100e3",
    )
    assert scene.controller.tick_hz == 100e3
    assert scene.motor.preset == "re40-148877"
    assert scene.scene.name == "two words"
    assert scene.controller.walls == ((0.0, 1.0),)
    assert scene.hand.path == "press"


@pytest.mark.parametrize(
    ("override", "fragment"),
    [
        ("controller.tick_hz=0", "controller.tick_hz = 0 is out of range; it must be 10 to 4e6 Hz"),
        ("controller.tick_hz=1.5 kHz", "write 1.5e3"),
        ("controller.tick_hz", "no value; it must be table.key=value"),
        ("controller.tick_hz=", '"" is not a TOML value'),
        ("controller.walls=[[0,1]", "is not a TOML value"),
        ("controller.walls=[[1,0]]", "walls[0] = [1, 0] is empty"),
        ("controller.lambda=1\n[adc]", "is not a TOML value"),
        ('scene.name="x', "is not a TOML value"),
        ("motor.kind=bldc", 'motor.kind "bldc" is unknown; did you mean "pmsm"? known: dc, pmsm'),
        ("controller.nope=1", "unknown key controller.nope"),
        ("nope.x=1", "unknown table [nope]"),
        ("tick_hz=1", "names no table; did you mean controller.tick_hz?"),
        ("nope=1", "names no table; it must be table.key=value"),
        ("a.b.c=1", "is not table.key"),
        (".x=1", "is not table.key"),
        ("=1", "it must be table.key=value"),
        ("", "it must be table.key=value"),
        ("adc.full_scale_a=2", "adc.bits is missing"),
        ("hand.path=taps", "hand.amplitude_rad is missing"),
        ("thermal.x=1", "unknown key thermal.x"),
        ("motor.preset=re25", '"re25" is unknown'),
    ],
)
def test_refused_overrides(tmp_path, override, fragment):
    message = refusal(tmp_path, BASE, override)
    assert message.startswith(f"--set {override}: ".replace("\n", "\\n"))
    assert fragment in message


def test_override_repairs_what_the_file_has_wrong(tmp_path):
    text = BASE + "walls = [[1.0, 0.0]]\n"
    assert load_text(tmp_path, text, "controller.walls=[]").controller.walls == ()


def test_shipped_scenes():
    shipped = shipped_scenes()
    assert set(shipped) == {
        "bounce",
        "brushless_hold",
        "brushless_soft",
        "brushless_taps",
        "brushless_wall",
        "centring",
        "click",
        "damped",
        "detents",
        "encoder_wall",
        "free_space",
        "held_wall",
        "hosted_wall",
        "impact",
        "live_arm",
        "live_brushless",
        "live_wall",
        "mass",
        "paper_taps",
        "phantom",
        "phantom_plane",
        "planar_disc",
        "press_hold",
        "resonance",
        "soft_layer",
        "spring_damper",
        "stiffest",
        "teleoperation",
        "texture",
        "two_motors",
        "two_walls",
        "warm_winding",
    }
    for name, path in shipped.items():
        assert load_device(path).name == name
        assert find_scene(name) == path
    stiffest = load_scene(shipped["stiffest"]).controller
    assert stiffest.lambda_ == stiffest.tick_hz / (1 + stiffest.extra_ticks)


def test_find_scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match="did you mean paper_taps"):
        find_scene("paper_tap")
    assert find_scene("paper_tap.toml") == Path("paper_tap.toml")
    Path("stiffest").mkdir()
    assert find_scene("stiffest").is_file()
    Path("impact").write_text(BASE)
    assert find_scene("impact") == Path("impact")


def _described() -> dict[str, list[tuple[str, ...]]]:
    """Rows of the tables of keys in the format's description, by the table they describe."""
    described: dict[str, list[tuple[str, ...]]] = {}
    rows: list[tuple[str, ...]] | None = None
    for line in (SCENES_DIR / "README.md").read_text(encoding="utf-8").splitlines():
        if heading := re.fullmatch(r"### \[+(\w+)\]+( at the tip)?", line):
            rows = described.setdefault(heading[1] + (heading[2] or ""), [])
            in_keys = False
        elif rows is not None and line.startswith("|"):
            cells = tuple(cell.strip() for cell in line.strip("|").split("|"))
            if cells[0] == "key":
                in_keys = True
            elif in_keys and not cells[0].startswith("---"):
                rows.append((cells[0].strip("`"), *cells[1:]))
        else:
            in_keys = False
    return described


def test_description_has_every_key_with_its_unit_default_range_and_meaning():
    described = _described()
    tables = {**TABLES, **SPACE_TABLES, "hand at the tip": SPACE_TABLES["hand"]}
    tables["hand"] = TABLES["hand"]
    assert list(described) == [*TABLES, "device", "surface", "coupling", "hand at the tip"]
    assert list(TABLES) == list(Scene.model_fields)
    for name, table in tables.items():
        assert described[name] == [tuple(field_texts(table, key)) for key in table.model_fields]


def test_description_has_the_presets():
    page = (SCENES_DIR / "README.md").read_text(encoding="utf-8")
    for name, motor in PRESETS.items():
        (row,) = re.findall(rf"^\| `{name}` \|(.*)\|$", page, re.MULTILINE)
        assert tuple(float(cell) for cell in row.split("|")) == pytest.approx(tuple(motor))


def test_examples_of_the_description_are_scenes(tmp_path):
    page = (SCENES_DIR / "README.md").read_text(encoding="utf-8")
    example, motors, arm = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    assert load_text(tmp_path, example).scene.name == "my_taps"
    path = tmp_path / "motors.toml"
    path.write_text(motors + re.sub(r"\[motor\]\n.*\n", "", BASE))
    assert list(load_device(path).motors) == ["shoulder", "elbow"]
    motor = f"[[motors]]\n{PRESET}\n"
    path.write_text(arm + motor * 3 + re.sub(r"\[motor\]\n.*\n", "", BASE))
    space = load_device(path).space
    assert space is not None
    assert len(space.surface) == 1


def _loads_or_refuses(folder: Path, content: bytes, *overrides: str) -> None:
    try:
        scene = load_text(folder, content, *overrides)
    except SceneError as error:
        message = str(error)
        assert message.isprintable()
        place = re.match(r"(--set |.*bench\.toml:(\d+): )", message)
        assert place
        if place[2]:
            assert 1 <= int(place[2]) <= content.count(b"\n") + 1
    else:
        assert isinstance(scene, Scene)


@pytest.fixture(scope="module")
def fuzz_folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz")


@given(st.binary(max_size=200))
@settings(deadline=None)
def test_random_bytes_are_refused_in_words(fuzz_folder, content):
    _loads_or_refuses(fuzz_folder, content)


_names = st.sampled_from(
    [*TABLES, *(field_texts(t, key).key for t in TABLES.values() for key in t.model_fields)]
)
_pieces = st.one_of(
    _names,
    st.sampled_from(
        [*"[]{}=.,#\"'\n\\ ", '"""', "[[", "]]", "\n[[motors]]\n", " = ", "\n[", "nan", "-inf"]
    ),
    st.sampled_from(['"taps"', '"re25-118743"', '"0.24 mH"', "true", "1e4", "[[0.0, 1.0]]"]),
    st.integers().map(str),
    st.floats().map(repr),
    st.text(max_size=5),
)


@given(st.lists(_pieces, max_size=30).map("".join))
@settings(deadline=None)
def test_random_text_is_refused_in_words(fuzz_folder, text):
    _loads_or_refuses(fuzz_folder, text.encode("utf-8", "replace"))
    _loads_or_refuses(fuzz_folder, (BASE + text).encode("utf-8", "replace"))


_values = st.recursive(
    st.one_of(
        st.sampled_from(
            ['"taps"', '"impact"', '"re25-118743"', '"0.24 mH"', "true", "12", "1e4", "1e-3"]
        ),
        st.integers().map(str),
        st.floats().map(lambda value: repr(value).replace("e+", "e")),
        st.sampled_from(["1979-05-27", "07:32:00", "0xFF", '""', "{}", "[]"]),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda items: f"[{', '.join(items)}]"),
        st.dictionaries(_names, inner, max_size=3).map(
            lambda pairs: "{" + ", ".join(f"{k} = {v}" for k, v in pairs.items()) + "}"
        ),
    ),
    max_leaves=6,
)
_tables = st.dictionaries(
    st.sampled_from([*TABLES, "device", "zzz"]),
    st.dictionaries(_names, _values, max_size=5),
    max_size=6,
)
_motors = st.lists(
    st.dictionaries(_names | st.sampled_from(["name", *TABLES]), _values, max_size=3), max_size=2
)


@given(_tables, st.lists(st.tuples(_names, _names, _values), max_size=2), _motors, st.booleans())
@settings(deadline=None, max_examples=300)
def test_random_documents_are_taken_or_refused_in_words(
    fuzz_folder, tables, overrides, further, complete
):
    if complete:  # so that what needs a valid rest is reached
        given_tables, _ = parse(BASE.encode())
        for name, keys in given_tables.items():
            known = {key: f'"{v}"' if isinstance(v, str) else repr(v) for key, v in keys.items()}
            tables = {**tables, name: {**known, **tables.get(name, {})}}
        if further:
            del tables["motor"]
            further = [{"preset": '"re25-118743"', **keys} for keys in further]
    text = "".join(
        (f"[{name}]\n" if name in tables else "[[motors]]\n")
        + "".join(f"{key} = {value}\n" for key, value in keys.items())
        for name, keys in (*tables.items(), *[("motors", keys) for keys in further])
    )
    parse(text.encode())  # the generator makes valid TOML
    settings_ = [f"{table}.{key}={value}" for table, key, value in overrides]
    _loads_or_refuses(fuzz_folder, text.encode(), *settings_)


def test_adc_part(tmp_path):
    """A part brings its bits; without a full scale there is room for twice the largest current."""
    path = tmp_path / "scene.toml"
    path.write_text(BASE)
    adc = load_scene(path, ["adc.part=ADS7056", "drive.limit_v=2.18"]).adc
    assert (adc.part, adc.bits) == ("ADS7056", 14)
    assert adc.full_scale_a == pytest.approx(2.0)
    adc = load_scene(path, ["adc.part=AD7278", "adc.bits=8", "adc.full_scale_a=3.0"]).adc
    assert (adc.bits, adc.full_scale_a) == (8, 3.0)
    assert load_scene(path, ["adc.bits=10"]).adc.part is None
