# SPDX-License-Identifier: Apache-2.0
"""``[drive]``: the bridge and its bus."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any, Literal

from pydantic import model_validator
from pydantic.functional_validators import ModelWrapValidatorHandler

from wavehaptics.scene.keys import (
    CURRENT_MAX_A,
    VOLTAGE_MAX_V,
    Table,
    as_number,
    broken_rule,
    scene_key,
)
from wavehaptics.words.bridge_modes import HALF_BRIDGE, MODE_WORDS, UNIPOLAR

USUAL_BUSES_V = (12.0, 24.0, 48.0)
"""Bus voltages, V, from which a drive's default is taken."""
THREE_PHASE_REACH = 2.0 / (3.0 + math.sqrt(3.0))
"""Largest voltage of each axis α and β of three phases in star, in parts of the bus, if both may
have it at once: the square ±this is the largest in the bridge's hexagon, with a common voltage of
the legs that keeps them between the rails."""
Mode = Literal["unipolar", "locked-anti-phase", "sign-magnitude", "half-bridge"]


class Drive(Table):
    """The bridge; without this table every voltage is reached, exactly."""

    mode: Mode = scene_key(
        "–", "How the bridge of `pins` switches, see below", UNIPOLAR, default_text="`unipolar`",
        range_text=", ".join(f"`{name}`" for name in MODE_WORDS),
    )  # fmt: skip
    bus_v: float | None = scene_key(
        "V", "Bus voltage of the bridge", None,
        default_text="smallest of 12, 24, 48 to reach `limit_v`; 12 on `pins` without `limit_v`",
        ge=0.1, le=VOLTAGE_MAX_V,
    )  # fmt: skip
    limit_v: float | None = scene_key(
        "V",
        "Largest voltage either way, not above the bus; of a half bridge, half the bus; of a "
        "brushless motor each axis' own, at most 0.4226 of the bus",
        None, default_text="what the bus reaches where `bus_v` is given, else no limit", ge=1e-3,
        le=VOLTAGE_MAX_V,
    )  # fmt: skip
    current_limit_a: float | None = scene_key(
        "A",
        "Largest current at rest: the voltage is at most `r_hat` times this. A rotor that turns at "
        "ω into the wall adds at most k_T·ω/R",
        None, default_text="what `limit_v` leaves", ge=1e-3, le=CURRENT_MAX_A,
    )  # fmt: skip
    pwm_hz: float | None = scene_key(
        "Hz",
        "PWM carrier of `pins`; where half its period is longer than a tick, that is the tick, and "
        "the run says so",
        None, default_text="chosen by `pins` to fit the tick", ge=100, le=1e7,
    )  # fmt: skip
    dead_time_s: float = scene_key(
        "s", "Dead time of a half bridge, below half a carrier period", 0.0, ge=0, le=1e-3
    )
    compensate: bool = scene_key("–", "Whether `pins` compensates the dead time", True)
    min_pulse_s: float = scene_key(
        "s", "Shortest time that a gate of `pins` stays on; 0: any", 0.0, ge=0, le=1e-3
    )
    gain_error: float = scene_key(
        "–", "The motor gets (1 + this) times the voltage asked for", 0.0, ge=-0.9, le=1
    )
    bus_actual_v: float | None = scene_key(
        "V", "True bus voltage; the controller assumes `bus_v` unless it measures the bus", None,
        default_text="`bus_v`", ge=0.1, le=VOLTAGE_MAX_V,
    )  # fmt: skip
    bus_ripple_v: float = scene_key(
        "V", "Amplitude of a sine on the bus of `pins`", 0.0, ge=0, le=VOLTAGE_MAX_V
    )
    bus_ripple_hz: float | None = scene_key(
        "Hz", "Frequency of that sine, required with it", None, ge=1e-3, le=1e5
    )
    bus_measured: bool = scene_key(
        "–", "Whether the controller measures the bus, and scales its pulses and its limit by it",
        False,
    )  # fmt: skip

    step_v: float = scene_key(
        "V", "Change of the bus at `step_s`", 0.0, ge=-VOLTAGE_MAX_V, le=VOLTAGE_MAX_V
    )
    step_s: float | None = scene_key("s", "Time of that step, required with it", None, ge=0, le=1e6)
    sag_ohm: float = scene_key(
        "Ω", "Resistance of the source: how far the bus falls per ampere that the bridge draws",
        0.0, ge=0, le=100,
    )  # fmt: skip

    supply_sinks: bool = scene_key(
        "–",
        "On `pins`: whether the supply takes back what the bridge returns; if not, the bus rises",
        True,
    )
    bus_farad: float | None = scene_key(
        "F", "Capacitance of the bus, which a supply that doesn't sink needs", None, ge=1e-7, le=1
    )

    @property
    def true_bus_v(self) -> float | None:
        """The bus as it is, without ripple, V; None where the scene has none."""
        return self.bus_v if self.bus_actual_v is None else self.bus_actual_v

    @property
    def gain(self) -> float:
        """Voltage at the motor over the voltage asked for, within the limit."""
        known, true = self.bus_v, self.true_bus_v
        if known is None or true is None or self.bus_measured:
            return 1.0 + self.gain_error
        return (1.0 + self.gain_error) * (true / known)

    @property
    def reached_v(self) -> float:
        """Largest voltage that a controller can ask for which knows its bus, V."""
        if not self.bus_measured or self.bus_v is None or self.true_bus_v is None:
            return math.inf
        return (self.true_bus_v + min(0.0, self.step_v)) * self.reach

    def limit(self, r_hat: float) -> float:
        """Largest voltage that a controller with R̂ = ``r_hat`` asks for, V."""
        limit_v = math.inf if self.limit_v is None else self.limit_v
        current_a = math.inf if self.current_limit_a is None else self.current_limit_a
        return min(limit_v, r_hat * current_a)

    @property
    def reach(self) -> float:
        """Largest voltage at the motor, in parts of the bus."""
        return 0.5 if self.mode == HALF_BRIDGE else 1.0

    def of_three_phases(self, given: Collection[str]) -> Drive:
        """The same for three phases in star; ``given`` are the keys that the scene has.

        The limit is that of each axis α and β by itself, at most THREE_PHASE_REACH of the bus.
        """
        bus_v, limit_v = self.bus_v, self.limit_v
        if bus_v is None or limit_v is None:
            return self
        if "limit_v" not in given:
            return self.model_copy(update={"limit_v": bus_v * THREE_PHASE_REACH})
        buses = [bus_v] if "bus_v" in given else [*USUAL_BUSES_V]
        reached = [bus for bus in buses if bus * THREE_PHASE_REACH >= limit_v]
        if not reached:
            largest = max(buses) * THREE_PHASE_REACH
            broken_rule(
                f"drive.limit_v = {as_number(limit_v)} is above what both axes of three phases "
                f"have of a bus of {max(buses):g} V; it may be at most {largest:.4g} V",
                ("drive", "limit_v"),
                ("drive", "bus_v"),
            )
        return self.model_copy(update={"bus_v": reached[0]})

    @model_validator(mode="wrap")
    @classmethod
    def _resolve(cls, data: Any, handler: ModelWrapValidatorHandler[Drive]) -> Drive:
        drive = handler(data)
        bus_v, limit_v, reach = drive.bus_v, drive.limit_v, drive.reach
        if limit_v is None:
            limit_v = None if bus_v is None else bus_v * reach
        elif bus_v is None:
            bus_v = next((usual for usual in USUAL_BUSES_V if usual * reach >= limit_v), None)
            if bus_v is None:
                largest = USUAL_BUSES_V[-1] * reach
                broken_rule(
                    f"drive.bus_v is missing and limit_v = {as_number(limit_v)} is above "
                    f"{largest:g} V, the most with the largest default; give bus_v",
                    "limit_v",
                )
        elif limit_v > bus_v * reach:
            of = "" if reach == 1.0 else f"what a {drive.mode} has of "
            broken_rule(
                f"drive.limit_v = {as_number(limit_v)} is above {of}bus_v = {as_number(bus_v)}; "
                f"it may be at most {bus_v * reach:g} V",
                "limit_v",
                "bus_v",
            )
        if drive.pwm_hz is not None and 2 * drive.dead_time_s * drive.pwm_hz >= 1:
            broken_rule(
                f"drive.dead_time_s = {as_number(drive.dead_time_s)} fills half a carrier period; "
                f"it must be below {as_number(1 / (2 * drive.pwm_hz))} s",
                "dead_time_s",
                "pwm_hz",
            )
        drive._check_bus(bus_v)
        drive._check_supply()
        return drive.model_copy(update={"bus_v": bus_v, "limit_v": limit_v})

    def _check_supply(self) -> None:
        """Refuse a supply that takes nothing back without a bus to keep it, and the contrary."""
        if not self.supply_sinks and self.bus_farad is None:
            broken_rule(
                "drive.supply_sinks = false leaves on the bus what the bridge returns; give "
                "bus_farad",
                "supply_sinks",
            )
        if self.supply_sinks and self.bus_farad is not None:
            broken_rule(
                "drive.bus_farad does nothing where the supply sinks; add supply_sinks = false",
                "bus_farad",
            )
        if not self.supply_sinks and self.sag_ohm:
            broken_rule(
                "drive.sag_ohm also lets the bus rise by what returns, which supply_sinks = false "
                "does by bus_farad; leave one out",
                "sag_ohm",
                "supply_sinks",
            )

    def _check_bus(self, bus_v: float | None) -> None:
        """Refuse a true bus that can't be, for the resolved ``bus_v``."""
        if bus_v is None:
            for key in (
                "bus_actual_v", "bus_ripple_v", "bus_ripple_hz", "bus_measured", "step_v",
                "sag_ohm", "bus_farad",
            ):  # fmt: skip
                if getattr(self, key):
                    broken_rule(f"drive.{key} needs to know the bus; give bus_v", key)
            return
        if self.bus_ripple_v and self.bus_ripple_hz is None:
            broken_rule("drive.bus_ripple_v has no frequency; give bus_ripple_hz", "bus_ripple_v")
        if self.bus_ripple_hz is not None and not self.bus_ripple_v:
            broken_rule("drive.bus_ripple_hz has no amplitude; give bus_ripple_v", "bus_ripple_hz")
        name = "bus_v" if self.bus_actual_v is None else "bus_actual_v"
        actual_v = bus_v if self.bus_actual_v is None else self.bus_actual_v
        room_v = min(actual_v, VOLTAGE_MAX_V - actual_v)
        if self.bus_ripple_v and self.bus_ripple_v >= room_v:
            broken_rule(
                f"drive.bus_ripple_v = {as_number(self.bus_ripple_v)} on {name} = "
                f"{as_number(actual_v)} leaves 0 to {VOLTAGE_MAX_V} V; it must be below "
                f"{as_number(room_v)}",
                "bus_ripple_v",
                name,
            )
        if self.step_v and self.step_s is None:
            broken_rule("drive.step_v has no time; give step_s", "step_v")
        if self.step_s is not None and "step_v" not in self.model_fields_set:
            broken_rule("drive.step_s has nothing to change; give step_v", "step_s")
        after_v = actual_v + self.step_v
        if not self.bus_ripple_v < after_v <= VOLTAGE_MAX_V - self.bus_ripple_v:
            broken_rule(
                f"drive.step_v = {as_number(self.step_v)} takes {name} = {as_number(actual_v)} out "
                f"of 0 to {VOLTAGE_MAX_V} V; it must be above "
                f"{as_number(self.bus_ripple_v - actual_v)} and at most "
                f"{as_number(VOLTAGE_MAX_V - self.bus_ripple_v - actual_v)}",
                "step_v",
                name,
            )
