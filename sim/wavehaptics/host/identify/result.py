# SPDX-License-Identifier: Apache-2.0
"""What was identified: as a table, as a scene, and as words for the device."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, TypeAlias

from wavehaptics.controller.rotor_flux import count_word
from wavehaptics.controller.settings import settings
from wavehaptics.host import session
from wavehaptics.host.identify.brushed import Found
from wavehaptics.host.identify.brushless import FoundBrushless
from wavehaptics.host.identify.driver import Driver
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
        return rounded(self.scale * self.estimate.value, abs(self.scale) * self.estimate.sd)

    @property
    def spread(self) -> str:
        """Its spread, one standard deviation."""
        return f"{abs(self.scale) * self.estimate.sd:.1g}"


def rounded(value: float, sd: float) -> str:
    """A value to a place behind its spread's, of seven at most."""
    if not value or not sd:
        return f"{value:.4g}"
    digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(sd)) + 2
    return f"{value:.{min(max(digits, 2), 7)}g}"


AnyFound: TypeAlias = Found | FoundBrushless


def rows(found: AnyFound) -> Iterator[Row]:
    """What was identified, a row each."""
    motion = found.mechanics
    yield from _windings(found) if isinstance(found, Found) else _phases(found)
    yield Row("J", motion.inertia, 1e7, "g·cm²")
    yield Row("Coulomb friction", motion.coulomb, 1e3, "mN·m")
    yield Row("viscous friction", motion.viscous, 1e6, "µN·m·s/rad")
    if motion.per_rev:
        yield Row(f"cogging, {motion.per_rev} a turn", motion.cogging, 1e3, "mN·m")
    yield Row("sensor's zero", found.offset_a, 1e3, "mA")


def _windings(found: Found) -> Iterator[Row]:
    winding = found.resistance
    yield Row("R", winding.ohm, 1, "Ω")
    if winding.segments:
        yield Row(f"R(θ), {winding.segments} a turn", winding.ripple, 100, "% of R")
    yield Row("brushes V_b", winding.drop_v, 1, "V")
    yield Row("L", found.inductance, 1e3, "mH")
    yield Row("k_T", found.back_emf.k_t, 1e3, "mN·m/A")
    yield Row("  forward", found.back_emf.forward, 1e3, "mV·s/rad")
    yield Row("  backward", found.back_emf.backward, 1e3, "mV·s/rad")
    yield Row("K_L = k_T²/L", spring(found.back_emf.k_t, found.inductance, 1.0), 1, "N·m/rad")


def _phases(found: FoundBrushless) -> Iterator[Row]:
    turning = found.magnets
    yield Row("R", turning.ohm, 1, "Ω")
    yield Row("dead time's V_d", turning.dead_v, 1, "V")
    if found.salient:
        yield Row("L_q", found.inductance, 1e3, "mH")
        yield Row("L_d", found.inductance_d, 1e3, "mH")
    else:
        yield Row("L", found.inductance, 1e3, "mH")
    yield Row("pole pairs", Estimate(turning.pole_pairs, 0.0), 1, "")
    yield Row("ψ", turning.flux, 1e3, "mV·s")
    yield Row("k_T = 1.5 pψ", turning.k_t, 1e3, "mN·m/A")
    yield Row("K_L = 1.5 (pψ)²/L", spring(turning.k_t, found.inductance, 1.5), 1, "N·m/rad")
    yield Row("θ at x = 0", found.magnet_place, -turning.pole_pairs * _DEGREES, "°")


_DEGREES = 180.0 / math.pi


def spring(k_t: Estimate, henry: Estimate, axes: float) -> Estimate:
    """K_L in N·m/rad, of a k_T that is ``axes`` times that of the back-EMF."""
    value = k_t.value**2 / henry.value / axes
    part = math.hypot(2 * k_t.sd / k_t.value, henry.sd / henry.value)
    return Estimate(value, value * part)


def scene_text(found: AnyFound, driver: Driver, name: str) -> str:
    """The scene of the motor on this device, as TOML."""
    motion = found.mechanics
    lines = [
        "# Identified over the link by `wavehaptics board identify`; ± is one standard deviation.",
        "", "[scene]", f"name = {json.dumps(name, ensure_ascii=False)}",
        f"duration_s = {DURATION_S}",
        "", "[motor]",
        *(_brushed_keys(found) if isinstance(found, Found) else _brushless_keys(found)),
        "", "[friction]", _key("coulomb_nm", motion.coulomb), _key("viscous", motion.viscous),
    ]  # fmt: skip
    if motion.per_rev:
        lines += ["", "[cogging]", _key("torque_nm", motion.cogging), f"per_rev = {motion.per_rev}"]
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


def _key(key: str, estimate: Estimate) -> str:
    return f"{key} = {rounded(estimate.value, estimate.sd)} # ± {estimate.sd:.1g}"


def _brushed_keys(found: Found) -> list[str]:
    """The rest of [motor], and [brushes]."""
    winding = found.resistance
    drop_v = Estimate(max(0.0, winding.drop_v.value), winding.drop_v.sd)
    lines = [
        _key("R_ohm", winding.ohm), _key("L_h", found.inductance),
        _key("k_t", found.back_emf.k_t), _key("J_kgm2", found.mechanics.inertia),
        "", "[brushes]", _key("drop_v", drop_v),
    ]  # fmt: skip
    if winding.segments:
        lines += [f"segments = {winding.segments}", _key("ripple", winding.ripple)]
    return lines


def _brushless_keys(found: FoundBrushless) -> list[str]:
    """The rest of [motor]."""
    turning = found.magnets
    lines = [
        'kind = "pmsm"', _key("R_ohm", turning.ohm), _key("L_h", found.inductance),
        f"pole_pairs = {turning.pole_pairs}", _key("psi_vs", turning.flux),
        _key("J_kgm2", found.mechanics.inertia), _key("magnet_rad", found.magnet_place),
    ]  # fmt: skip
    if found.salient:
        part = found.inductance_d.value / found.inductance.value
        spread = part * math.hypot(
            found.inductance_d.sd / found.inductance_d.value,
            found.inductance.sd / found.inductance.value,
        )
        lines.append(_key("l_d_part", Estimate(part, spread)))
    return lines


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
    if scene.motor.pole_pairs is not None:
        raws["count_angle"] = count_word(scene.motor.pole_pairs, set_.cell_rad)
    elif driver.dead_time_volt_s:
        side_a = 0.5 * driver.dead_time_volt_s / scene.controller.l_hat
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


def write(found: AnyFound, driver: Driver, path: Path, motor: int) -> tuple[Path, Path]:
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
