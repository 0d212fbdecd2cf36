# SPDX-License-Identifier: Apache-2.0
"""What was identified: as a table, as a scene, and as words for the device."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from wavehaptics.controller.settings import settings
from wavehaptics.host import session
from wavehaptics.host.identify.driver import Driver
from wavehaptics.host.identify.procedure import Found
from wavehaptics.host.identify.segments import Estimate
from wavehaptics.host.names import HostError, Place, Shape, places
from wavehaptics.scene import Scene, SceneError, load_scene
from wavehaptics.words import formats
from wavehaptics.words.table import ports

WORDS_SUFFIX = ".words.toml"
"""Of the file of words beside a scene's."""

DURATION_S = 1.0


class Row(NamedTuple):
    """A value with its spread, ``scale`` times, in ``unit``."""

    name: str
    estimate: Estimate
    scale: float
    unit: str

    @property
    def value(self) -> str:
        """The value, with as many places as its spread is worth."""
        return rounded(self.scale * self.estimate.value, self.scale * self.estimate.sd)

    @property
    def spread(self) -> str:
        """Its spread, one standard deviation."""
        return f"{self.scale * self.estimate.sd:.1g}"


def rounded(value: float, sd: float) -> str:
    """A value to a place behind its spread's, of seven at most."""
    if not value or not sd:
        return f"{value:.4g}"
    digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(sd)) + 2
    return f"{value:.{min(max(digits, 2), 7)}g}"


def rows(found: Found) -> Iterator[Row]:
    """What was identified, a row each."""
    winding, motion = found.resistance, found.mechanics
    yield Row("R", winding.ohm, 1, "Ω")
    if winding.segments:
        yield Row(f"R(θ), {winding.segments} a turn", winding.ripple, 100, "% of R")
    yield Row("brushes V_b", winding.drop_v, 1, "V")
    yield Row("L", found.inductance, 1e3, "mH")
    yield Row("k_T", found.back_emf.k_t, 1e3, "mN·m/A")
    yield Row("  forward", found.back_emf.forward, 1e3, "mV·s/rad")
    yield Row("  backward", found.back_emf.backward, 1e3, "mV·s/rad")
    yield Row("K_L = k_T²/L", spring(found), 1, "N·m/rad")
    yield Row("J", motion.inertia, 1e7, "g·cm²")
    yield Row("Coulomb friction", motion.coulomb, 1e3, "mN·m")
    yield Row("viscous friction", motion.viscous, 1e6, "µN·m·s/rad")
    if motion.per_rev:
        yield Row(f"cogging, {motion.per_rev} a turn", motion.cogging, 1e3, "mN·m")
    yield Row("sensor's zero", found.offset_a, 1e3, "mA")


def spring(found: Found) -> Estimate:
    """K_L in N·m/rad."""
    k_t, henry = found.back_emf.k_t, found.inductance
    value = k_t.value**2 / henry.value
    part = math.hypot(2 * k_t.sd / k_t.value, henry.sd / henry.value)
    return Estimate(value, value * part)


def scene_text(found: Found, driver: Driver, name: str) -> str:
    """The scene of the motor on this device, as TOML."""
    winding, motion = found.resistance, found.mechanics

    def line(key: str, estimate: Estimate) -> str:
        return f"{key} = {rounded(estimate.value, estimate.sd)} # ± {estimate.sd:.1g}"

    drop_v = Estimate(max(0.0, winding.drop_v.value), winding.drop_v.sd)
    lines = [
        "# Identified over the link by `wavehaptics board identify`; ± is one standard deviation.",
        "", "[scene]", f"name = {json.dumps(name, ensure_ascii=False)}",
        f"duration_s = {DURATION_S}",
        "", "[motor]", line("R_ohm", winding.ohm), line("L_h", found.inductance),
        line("k_t", found.back_emf.k_t), line("J_kgm2", motion.inertia),
        "", "[brushes]", line("drop_v", drop_v),
    ]  # fmt: skip
    if winding.segments:
        lines += [f"segments = {winding.segments}", line("ripple", winding.ripple)]
    lines += [
        "", "[friction]", line("coulomb_nm", motion.coulomb), line("viscous", motion.viscous)
    ]  # fmt: skip
    if motion.per_rev:
        lines += ["", "[cogging]", line("torque_nm", motion.cogging), f"per_rev = {motion.per_rev}"]
    lines += [
        "", "[encoder]", f"counts_per_rev = {found.counts}",
        "", "[adc]", f"bits = {driver.adc_bits}", f"full_scale_a = {driver.full_scale_a:.6g}",
        "", "[drive]", f"limit_v = {driver.limit_v:.6g}",
        "", "[controller]", f"tick_hz = {1 / driver.tick_s:.9g}",
        f"extra_ticks = {driver.extra_ticks}", f"lambda = {_lambda(driver):.6g}",
    ]  # fmt: skip
    if driver.anchored:
        lines.append("anchor_auto = true")
    return "\n".join(lines) + "\n"


def _lambda(driver: Driver) -> float:
    """λ of the device's coefficient, rad/s."""
    return 1.0 / (driver.tick_s * (1.0 / max(driver.lambda_a, formats.A.step) + driver.extra_ticks))


def words(scene: Scene, driver: Driver, motor: int) -> list[tuple[Place, int]]:
    """The device's words that depend on the motor, for a scene of :func:`scene_text`."""
    set_ = settings(scene, driver.tick_s, limit_v=driver.limit_v)
    raws = {"root": set_.root, "u_max": set_.u_max}
    if driver.anchored:
        names = [word.name for word in ports()["anchor_words"]]
        raws |= {"eta_free": set_.eta_free, **dict(zip(names, set_.anchor.tolist(), strict=True))}
    if driver.dead_time_volt_s:
        side_a = 0.5 * driver.dead_time_volt_s / scene.motor.L_h
        raws["side_current"] = formats.CURRENT.to_raw(min(side_a, 0.5 * formats.CURRENT.largest))
    return [(_place(name, driver.shape, motor), int(raw)) for name, raw in raws.items()]


def _place(name: str, shape: Shape, motor: int) -> Place:
    return places(name, shape, motor)[0]


def _scene_name(path: Path) -> str:
    """A scene's name of its file's: printable, and none of a path's parts."""
    kept = (c if c.isprintable() and c not in "/\\" else "_" for c in path.stem)
    return "".join(kept).strip()[:60] or "motor"


def beside(path: Path, suffix: str = WORDS_SUFFIX) -> Path:
    """The file with another suffix beside a scene's ``path``: of words, or what else is named."""
    return path.with_name((path.stem if path.suffix == ".toml" else path.name) + suffix)


def write(found: Found, driver: Driver, path: Path, motor: int) -> tuple[Path, Path]:
    """The scene into ``path``, and the words for ``board load`` beside it: both paths."""
    session.write_file(path, scene_text(found, driver, _scene_name(path)))
    words_path = beside(path)
    try:
        scene = load_scene(path)
        given = words(scene, driver, motor)
    except SceneError as error:
        raise HostError(f"{path} is written, but there are no words for it: {error}") from None
    session.write_file(words_path, session.to_text((p, raw & 0xFFFFFFFF) for p, raw in given))
    return path, words_path
