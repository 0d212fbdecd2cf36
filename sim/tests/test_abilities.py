# SPDX-License-Identifier: Apache-2.0
"""Every key of a scene on every controller: it has an effect, is said to have none, or refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from wavehaptics.fpga.boards import load_board
from wavehaptics.ladder.abilities import ABILITIES, asked, left_out, refuse
from wavehaptics.ladder.hosted import HostedSimulation, Line
from wavehaptics.ladder.run import CONTROLLERS
from wavehaptics.scene import Scene, SceneError, load_scene
from wavehaptics.trace.columns import Column, Word

BASE = """
[scene]
name = "every_key"
duration_s = 0.05
[motor]
preset = "re25-118743"
[hand]
path = "taps"
amplitude_rad = 0.1
frequency_hz = 20
stiffness = 0.5
damping = 2e-3
[controller]
tick_hz = 250e3
lambda = 1e4
extra_ticks = 1
walls = [[0.0123, 1.0]]
"""

ENCODER = ("encoder.counts_per_rev=4000",)
SENSED = ("adc.bits=10", "adc.full_scale_a=2.5")
READ = ("encoder.kind=absolute", "encoder.bits=12", "encoder.read_hz=50e3")
DRIVEN = ("drive.bus_v=12",)
RISING = ("drive.supply_sinks=false", "drive.bus_farad=10e-6")
ANCHORED = (*ENCODER, *DRIVEN, *SENSED, "controller.anchor_auto=true")
HOT = ("thermal.start_c=80", "scene.duration_s=0.2", "controller.tick_hz=50e3")
BRUSHLESS = ("motor.preset=gbm2804-100t",)
SERVO = ("servo.foc_hz=25e3",)  # of which a tick is a whole part
SPRING = ("shaper.feel=spring", "shaper.stiffness=0.3", "shaper.damping=0.1e-3")

NOT_OF_A_RUN = {
    "scene.name", "scene.duration_s", "scene.trace_hz",  # of files
    "transmission.ratio", "transmission.lever_m",  # every angle is the rotor's: of metrics
    "hand.speed_rad_s",  # of the path `impact`, which lets no key stand that the base has
    "guard.saturated_s",  # of a rotor that swings at the voltage limit (test_saturated.py)
}  # fmt: skip

KEYS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "motor.R_ohm": ((), ("motor.R_ohm=3",)),
    "motor.L_h": ((), ("motor.L_h=0.3e-3",)),
    "motor.k_t": ((), ("motor.k_t=0.03",)),
    "motor.J_kgm2": ((), ("motor.J_kgm2=2e-6",)),
    "motor.preset": ((), ("motor.preset=re40-148877",)),
    "motor.kind": ((), ("motor.kind=pmsm", *BRUSHLESS, *SERVO)),
    "motor.pole_pairs": ((*BRUSHLESS, *SERVO), ("motor.pole_pairs=6",)),
    "motor.psi_vs": ((*BRUSHLESS, *SERVO), ("motor.psi_vs=3e-3",)),
    "motor.l_d_part": ((*BRUSHLESS, *SERVO), ("motor.l_d_part=0.6",)),
    "motor.harmonic_5": ((*BRUSHLESS, *SERVO), ("motor.harmonic_5=0.05",)),
    "motor.harmonic_7": ((*BRUSHLESS, *SERVO), ("motor.harmonic_7=0.05",)),
    "motor.magnet_rad": ((*BRUSHLESS, *SERVO), ("motor.magnet_rad=0.1",)),
    "load.inertia_kgm2": ((), ("load.inertia_kgm2=1e-6",)),
    "friction.coulomb_nm": ((), ("friction.coulomb_nm=1e-3",)),
    "friction.viscous": ((), ("friction.viscous=1e-4",)),
    "brushes.drop_v": ((), ("brushes.drop_v=0.3",)),
    "brushes.knee_a": (("brushes.drop_v=0.3",), ("brushes.knee_a=0.1",)),
    "brushes.contact_noise": ((), ("brushes.contact_noise=0.03",)),
    "brushes.noise_rad": (("brushes.contact_noise=0.03",), ("brushes.noise_rad=1e-3",)),
    "brushes.flicker_noise": ((), ("brushes.flicker_noise=0.03",)),
    "brushes.flicker_s": (("brushes.flicker_noise=0.03",), ("brushes.flicker_s=1e-4",)),
    "brushes.segments": (("brushes.segments=11", "brushes.ripple=0.04"), ("brushes.segments=5",)),
    "brushes.ripple": (("brushes.segments=11",), ("brushes.ripple=0.04",)),
    "brushes.step": (("brushes.segments=11",), ("brushes.step=0.04",)),
    "brushes.step_at_rad": (
        ("brushes.segments=11", "brushes.step=0.04"),
        ("brushes.step_at_rad=0.01",),
    ),
    "winding.eddy_ohm": ((), ("winding.eddy_ohm=5", "winding.eddy_part=0.3")),
    "winding.eddy_part": (
        ("winding.eddy_ohm=5", "winding.eddy_part=0.2"),
        ("winding.eddy_part=0.4",),
    ),
    "winding.saturation_a": ((), ("winding.saturation_a=1",)),
    "cogging.torque_nm": ((), ("cogging.torque_nm=2e-3", "cogging.per_rev=11")),
    "cogging.per_rev": (("cogging.torque_nm=2e-3", "cogging.per_rev=11"), ("cogging.per_rev=7",)),
    "hand.path": ((), ("hand.path=sine",)),
    "hand.amplitude_rad": ((), ("hand.amplitude_rad=0.05",)),
    "hand.frequency_hz": ((), ("hand.frequency_hz=30",)),
    "hand.stiffness": ((), ("hand.stiffness=0.3",)),
    "hand.damping": ((), ("hand.damping=1e-3",)),
    "hand.inertia_kgm2": ((), ("hand.inertia_kgm2=1e-6",)),
    "encoder.counts_per_rev": (ENCODER, ("encoder.counts_per_rev=700",)),
    "encoder.stops_at_s": (ENCODER, ("encoder.stops_at_s=0.005",)),
    "encoder.uneven": (ENCODER, ("encoder.uneven=0.2",)),
    "encoder.reverses_at_s": (ENCODER, ("encoder.reverses_at_s=0.005",)),
    "encoder.skips_per_rev": (ENCODER, ("encoder.skips_per_rev=100",)),
    "encoder.kind": (
        ("encoder.counts_per_rev=4096",),
        ("encoder.kind=absolute", "encoder.read_hz=3.7e3"),
    ),
    "encoder.part": (READ[:1] + READ[2:] + ("encoder.bits=14",), ("encoder.part=AS5047P",)),
    "encoder.bits": (
        (*READ, "encoder.counts_per_rev=4096", "encoder.noise_counts=4"),
        ("encoder.bits=14",),
    ),
    "encoder.read_hz": (READ, ("encoder.read_hz=3.7e3",)),
    "encoder.latency_s": (READ, ("encoder.latency_s=100e-6",)),
    "encoder.noise_counts": (READ, ("encoder.noise_counts=3",)),
    "encoder.bandwidth_hz": (READ, ("encoder.bandwidth_hz=100",)),
    "encoder.hysteresis_counts": (READ, ("encoder.hysteresis_counts=8",)),
    "adc.part": (("adc.full_scale_a=2.5", "adc.bits=12"), ("adc.part=MAX11125",)),
    "adc.bits": (("adc.full_scale_a=2.5", "adc.bits=12"), ("adc.bits=8",)),
    "adc.full_scale_a": (SENSED, ("adc.full_scale_a=5",)),
    "adc.noise_a": (SENSED, ("adc.noise_a=5e-3",)),
    "adc.offset_a": (SENSED, ("adc.offset_a=5e-3",)),
    "adc.bandwidth_hz": (SENSED, ("adc.bandwidth_hz=200e3",)),
    "adc.common_mode_a": (SENSED, ("adc.common_mode_a=5e-3",)),
    "adc.edge_settle_s": (
        (*SENSED, *DRIVEN, "adc.common_mode_a=5e-3"),
        ("adc.edge_settle_s=1e-6",),
    ),
    "adc.edge_hold_s": ((*SENSED, *DRIVEN), ("adc.edge_hold_s=10e-6",)),
    "adc.edge_hold_restarts": (
        (*SENSED, *DRIVEN, "adc.edge_hold_s=10e-6"),
        ("adc.edge_hold_restarts=false",),
    ),
    "adc.drift_a_per_s": (SENSED, ("adc.drift_a_per_s=0.5",)),
    "guard.trip_a": (
        (*SENSED, *DRIVEN, "guard.trip_a=2.4", "guard.watch=false"),
        ("guard.trip_a=0.2",),
    ),
    "guard.watch": (
        (*SENSED, *DRIVEN, "guard.trip_a=2.4", "guard.watch=false"),
        ("guard.watch=true",),
    ),
    "guard.overspeed_rad_s": (
        (*ENCODER, *SENSED, *DRIVEN, "guard.trip_a=2.4"),
        ("guard.overspeed_rad_s=2",),
    ),
    "guard.window_rad": (
        (*ENCODER, *SENSED, *DRIVEN, "guard.trip_a=2.4"),
        ("guard.window_rad=[-0.2, 0.005]",),
    ),
    "drive.mode": (DRIVEN, ("drive.mode=sign-magnitude",)),
    "drive.bus_v": (DRIVEN, ("drive.bus_v=1",)),
    "drive.limit_v": (DRIVEN, ("drive.limit_v=0.5",)),
    "drive.current_limit_a": (DRIVEN, ("drive.current_limit_a=0.2",)),
    "drive.pwm_hz": (DRIVEN, ("drive.pwm_hz=62500",)),
    "drive.dead_time_s": (DRIVEN, ("drive.dead_time_s=200e-9",)),
    "drive.compensate": ((*DRIVEN, "drive.dead_time_s=200e-9"), ("drive.compensate=false",)),
    "drive.min_pulse_s": (DRIVEN, ("drive.min_pulse_s=300e-9",)),
    "drive.gain_error": (DRIVEN, ("drive.gain_error=0.05",)),
    "drive.bus_actual_v": (DRIVEN, ("drive.bus_actual_v=10",)),
    "drive.bus_ripple_v": (DRIVEN, ("drive.bus_ripple_v=1", "drive.bus_ripple_hz=100")),
    "drive.bus_ripple_hz": (
        (*DRIVEN, "drive.bus_ripple_v=1", "drive.bus_ripple_hz=100"),
        ("drive.bus_ripple_hz=300",),
    ),
    "drive.bus_measured": ((*DRIVEN, "drive.bus_actual_v=10"), ("drive.bus_measured=true",)),
    "drive.step_v": (DRIVEN, ("drive.step_v=3", "drive.step_s=0.005")),
    "drive.step_s": ((*DRIVEN, "drive.step_v=3", "drive.step_s=0.005"), ("drive.step_s=0.01",)),
    "drive.sag_ohm": (DRIVEN, ("drive.sag_ohm=2",)),
    "drive.supply_sinks": (DRIVEN, RISING),
    "drive.bus_farad": ((*DRIVEN, *RISING), ("drive.bus_farad=2e-6",)),
    "thermal.rth_winding": ((*HOT, "thermal.rth_winding=3.1"), ("thermal.rth_winding=0.01",)),
    "thermal.rth_housing": ((*HOT, "thermal.tau_housing_s=0.5"), ("thermal.rth_housing=0.01",)),
    "thermal.tau_winding_s": (HOT, ("thermal.tau_winding_s=0.5",)),
    "thermal.tau_housing_s": ((*HOT, "thermal.tau_winding_s=0.5"), ("thermal.tau_housing_s=0.5",)),
    "thermal.alpha_per_k": (HOT, ("thermal.alpha_per_k=0.001",)),
    "thermal.magnet_per_k": (HOT, ("thermal.magnet_per_k=-0.002",)),
    "thermal.ambient_c": ((*HOT, "thermal.tau_winding_s=0.5"), ("thermal.ambient_c=100",)),
    "thermal.start_c": (
        ("scene.duration_s=0.2", "controller.tick_hz=50e3"),
        ("thermal.start_c=80",),
    ),
    "transmission.cable_stiffness": ((), ("transmission.cable_stiffness=1",)),
    "transmission.cable_damping": (
        ("transmission.cable_stiffness=1",),
        ("transmission.cable_damping=1e-4",),
    ),
    "transmission.backlash_rad": (
        ("transmission.cable_stiffness=1",),
        ("transmission.backlash_rad=0.01",),
    ),
    "servo.rate_hz": (("servo.rate_hz=1000",), ("servo.rate_hz=5000",)),
    "servo.stiffness": (("servo.rate_hz=1000",), ("servo.stiffness=0.1",)),
    "servo.damping": (("servo.rate_hz=1000",), ("servo.damping=1e-4",)),
    "servo.amplifier_hz": (("servo.rate_hz=1000",), ("servo.amplifier_hz=500",)),
    "servo.foc_hz": (
        (*BRUSHLESS, "servo.foc_hz=50e3", "servo.amplifier_hz=1000"),
        ("servo.foc_hz=125e3",),
    ),
    "servo.delay_s": (("servo.rate_hz=1000",), ("servo.delay_s=1e-3",)),
    "host.rate_hz": (("host.rate_hz=1000",), ("host.rate_hz=500",)),
    "host.timeout": (("host.rate_hz=1000",), ("host.timeout=10",)),
    "shaper.feel": ((), SPRING),
    "shaper.stiffness": (SPRING, ("shaper.stiffness=0.2",)),
    "shaper.damping": (SPRING, ("shaper.damping=0.4e-3",)),
    "shaper.mass_kgm2": (("shaper.feel=mass", "shaper.mass_kgm2=5e-6"), ("shaper.mass_kgm2=1e-5",)),
    "shaper.sos": ((), ("shaper.sos=[[0.5,0,0,1,0,0]]",)),
    "shaper.walls": ((*SPRING, "controller.walls=[[0.0,0.01],[0.01,1.0]]"), ("shaper.walls=[0]",)),
    "controller.tick_hz": ((), ("controller.tick_hz=125e3",)),
    "controller.extra_ticks": ((), ("controller.extra_ticks=3",)),
    "controller.lambda": ((), ("controller.lambda=1e5",)),
    "controller.eta_contact": ((), ("controller.eta_contact=-0.5",)),
    "controller.eta_free": ((), ("controller.eta_free=0.8",)),
    "controller.walls": ((), ("controller.walls=[[0.03,1.0]]",)),
    "controller.edge_hysteresis": (ENCODER, ("controller.edge_hysteresis=true",)),
    "controller.r_hat": ((), ("controller.r_hat=2.0",)),
    "controller.l_hat": (ANCHORED, ("controller.l_hat=0.3e-3",)),
    "controller.k_t_hat": (ANCHORED, ("controller.k_t_hat=0.03",)),
    "controller.j_hat": (ANCHORED, ("controller.j_hat=4e-6",)),
    "controller.magnet_hat_rad": (
        (*ANCHORED, *BRUSHLESS, *SERVO),
        ("controller.magnet_hat_rad=0.3",),
    ),
    "controller.find_magnet": ((*ANCHORED, *BRUSHLESS), ("controller.find_magnet=true",)),
    "controller.clock_hz": ((), ("controller.clock_hz=25e6",)),
    "controller.anchor_auto": ((*ENCODER, *SENSED, *DRIVEN), ("controller.anchor_auto=true",)),
    "controller.anchor_ohm": (ANCHORED, ("controller.anchor_ohm=2",)),
    "controller.anchor_ohm_per_s": (ANCHORED, ("controller.anchor_ohm_per_s=500",)),
    "controller.anchor_limit_v": (ANCHORED, ("controller.anchor_limit_v=0.05",)),
    "controller.r_hat_part": (ANCHORED, ("controller.r_hat_part=0.8",)),
}
"""For each key what else is set, and the settings that change it."""

PARTLY = {("analog", "controller.anchor_auto")}
"""All that the analog circuit does of an anchor is its R̂."""


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("abilities") / "every_key.toml"
    path.write_text(BASE)
    return path


@cache
def rows_of(path: Path, controller: str, settings: tuple[str, ...]) -> np.ndarray | str:
    """The run's rows, or why it is refused."""
    scene = load_scene(path, settings)
    ticks = round(scene.scene.duration_s * scene.controller.tick_hz)
    try:
        refuse(scene, controller)
        if controller == "hosted":
            return HostedSimulation(scene, None, 4, Line()).advance(ticks >> 4)
        simulation = CONTROLLERS[controller](scene)
    except SceneError as error:
        return str(error)
    rows = np.zeros((round(scene.scene.duration_s / simulation.tick_s), len(Column)))
    simulation.advance(rows, np.zeros((len(rows), len(Word)), dtype=np.int64))
    return rows[:, 1:]  # without the time


def test_every_key_of_the_format_is_tried() -> None:
    every = {
        f"{table}.{field.alias or key}"
        for table, model in Scene.model_fields.items()
        for key, field in table_of(model).model_fields.items()
    }
    assert set(KEYS) | NOT_OF_A_RUN == every
    assert not set(KEYS) & NOT_OF_A_RUN


def table_of(field):
    """The model of a table's field, which may be None."""
    options = getattr(field.annotation, "__args__", (field.annotation,))
    return next(option for option in options if option is not type(None))


@pytest.mark.kept("analog", "golden", "core", "encoder", "hosted")
@pytest.mark.parametrize("controller", [*CONTROLLERS, "hosted"])
def test_a_key_has_an_effect_or_is_said_to_have_none(base: Path, controller: str) -> None:
    if controller == "core":
        pytest.skip("the same integers as golden, test_run.py")
    wrong = []
    for key, (others, change) in KEYS.items():
        scene = load_scene(base, (*others, *change))
        name = key.replace("controller.lambda", "controller.lambda_")
        before = rows_of(base, controller, others)
        after = rows_of(base, controller, (*others, *change))
        refused = isinstance(after, str) or isinstance(before, str)
        same = not refused and before.shape == after.shape and np.array_equal(
            before, after, equal_nan=True
        )  # fmt: skip
        table = name.partition(".")[0]
        named = {name, table} & ABILITIES[controller].left_out
        if same and not named:
            wrong.append(f"{key} has no effect and nothing says so")
        if named and not same and not refused and (controller, key) not in PARTLY:
            wrong.append(f"{key} is said to have no effect and has one")
        if refused and not isinstance(after, str):
            wrong.append(f"{key}: {before}")
        if same and not {name, f"[{table}]"} & set(left_out(scene, controller)):
            wrong.append(f"{key} isn't told to a person")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", sorted(ABILITIES))
def test_what_is_refused_is_told_in_one_line(base: Path, name: str) -> None:
    settings = {
        "shaper": SPRING,
        "thermal": ("thermal.start_c=80",),
        "servo": ("servo.rate_hz=1000",),
        "controller.anchor_auto": ANCHORED,
        "controller.find_magnet": (*ANCHORED, *BRUSHLESS, "controller.find_magnet=true"),
        "controller.edge_hysteresis": (*ENCODER, "controller.edge_hysteresis=true"),
        "adc.edge_settle_s": (*SENSED, "adc.common_mode_a=5e-3", "adc.edge_settle_s=1e-6"),
        "adc.edge_hold_s": (*SENSED, "adc.edge_hold_s=1e-6"),
        "drive.bus_measured": (*DRIVEN, "drive.bus_measured=true"),
        "encoder.kind": READ,
    }
    refuse(load_scene(base), name)
    for what, cure in ABILITIES[name].refused.items():
        scene = load_scene(base, settings[what])
        assert what in asked(scene)
        with pytest.raises(SceneError) as refused:
            refuse(scene, name)
        assert what in str(refused.value)
        assert str(refused.value).endswith(cure)
        assert "\n" not in str(refused.value)


def test_a_board_refuses_what_its_bitstream_has_not(tmp_path: Path) -> None:
    board = load_board("ulx3s")
    toml = (board.root / board.folder / "board.toml").read_text()
    path = tmp_path / "board.toml"
    path.write_text(toml)
    for settings in (("drive.bus_measured=true",), ("servo.rate_hz=1000",)):
        asking = replace(board, scene=load_scene(path, settings))
        with pytest.raises(SceneError, match="is not for `a board`"):
            asking.words()
    assert replace(board, scene=load_scene(path)).words().words == board.words().words
    asking = replace(board, scene=load_scene(path, ("controller.edge_hysteresis=true",)))
    assert asking.words().words["edge_hysteresis"] == 1


def test_a_board_with_a_link_has_the_host_that_its_scene_asks_for() -> None:
    """Its period and patience as `pins` gets them; without a link there is nobody to be heard."""
    board = load_board("ulx3s")
    path = board.root / board.folder / "board.toml"
    asking = replace(board, scene=load_scene(path, ("host.rate_hz=4e3", "host.timeout=7")))
    assert "`define WH_BOARD_HOST 1\n" in asking.headers()["wh_board_settings.vh"]
    assert asking.words().words["host_period_log2"] == 8  # 0.83 MHz / 2^8
    assert asking.words().words["host_timeout"] == 7
    alone = load_board("hx8k")
    path = alone.root / alone.folder / "board.toml"
    assert "`define WH_BOARD_HOST 0\n" in alone.headers()["wh_board_settings.vh"]
    with pytest.raises(SceneError, match=r"no link to a host; leave \[host\] out"):
        replace(alone, scene=load_scene(path, ("host.rate_hz=1e3",))).words()


def test_a_board_has_the_w_that_its_scene_asks_for() -> None:
    """Its words in the header are those that `pins` gets, with the walls that feel so."""
    board = load_board("ulx3s")
    asking = ("controller.extra_ticks=3", *SPRING)
    scene = load_scene(board.root / board.folder / "board.toml", asking)
    words = replace(board, scene=scene).words()
    shaper = words.ports.settings.shaper.words
    assert words.words["shape_coefficient"] == shaper[:, :9].ravel().tolist()
    header = replace(board, scene=scene).headers()["wh_board_settings.vh"]
    assert f"`define WH_BOARD_SHAPER {len(shaper)}\n" in header
    assert ".wall_shaped_i ({1'h0, 1'h0, 1'h0, 1'h1})," in header  # and three empty ones
