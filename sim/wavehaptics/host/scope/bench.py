# SPDX-License-Identifier: Apache-2.0
"""What is on the bench: words of one motor in SI units, its design spring, and what sliders write.

With a scene all is known. Without one what the device itself tells is: amperes and counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wavehaptics.controller import wave_core
from wavehaptics.controller.ports import controller_ports
from wavehaptics.controller.shaper import Shaper, design
from wavehaptics.host.client import Client
from wavehaptics.host.names import HostError, Place, number, places, readable, settable
from wavehaptics.host.scope.feels import FEELS, Feel, placed
from wavehaptics.ladder.design_spring import rendered_stiffness
from wavehaptics.laws import closed_forms
from wavehaptics.laws.reflection import WishError
from wavehaptics.parts.adcs import KINDS
from wavehaptics.scene import Device, Scene, SceneError, load_device
from wavehaptics.words import formats

if TYPE_CHECKING:
    from wavehaptics.host.scope.arm import ArmBench

LAMBDA_SPAN = 300.0
"""Largest λ of the slider over the least."""

WALL_SPAN_RAD = 0.2
"""How far the wall's slider goes from where the wall is at first, rad."""

WALL_SPAN_COUNTS = 1000
"""The same where a count's angle isn't known."""

_SHAPE_PARTS = (0.05, 0.9)
"""Stiffness of W on the slider, in parts of what motor and delay have in front."""

_ANCHOR = ("anchor_enable", "anchor_flux_gain", "anchor_owed_gain")
"""Words of an anchor that are looked at."""

_DAMPERS = 4.0
"""Largest damping of W on the slider, in parts of k_T²/R."""

STEP = ("voltage", "u", "v", "current", "position", "contact", "saturated")
"""Live words of one frame."""

ANCHOR = ("correction", "offset", "flux", "lag")
"""Live words of a port anchor, of one frame."""

AXIS = ("voltage", "u", "v", "current")
"""Live words of a brushless motor's second axis, of one frame; they come as ``voltage@1``, ..."""

_SHAPE = ("shape_coefficient", "shape_loss")
"""Words of W."""

_INSTEAD = {
    "arm": "Arm and Stop on this page do that",
    "clear": "Forget what is over on this page does that",
}
"""Of the commands that the page has, where they are."""

_TURN = 2.0 * math.pi / 2.0**32
"""An angle's last place, rad."""


@dataclass(frozen=True)
class Known:
    """What the host is told of motor and encoder, SI units; None is not known."""

    scene: Scene | None = None
    path: Path | None = None
    """Of the scene's file, and with it ``overrides``, as it is read anew with another W."""
    overrides: tuple[str, ...] = ()
    k_t: float | None = None
    cell_rad: float | None = None
    start_count: int = 0
    """Where the device's count is 0, in cells of the scene's angle."""
    starts: bool = False
    """Whether that is known."""
    device: Device | None = None
    """The motors of an arm, of which ``scene`` is one."""

    @classmethod
    def of_scene(cls, path: Path, overrides: tuple[str, ...], *, starts: bool) -> Known:
        """All that a scene tells. ``starts``: the device began to count where the scene does."""
        device = load_device(path, overrides)
        scene = first_scene(device)
        ports = controller_ports(scene)
        return cls(
            scene, path, overrides, scene.motor.k_t, ports.settings.cell_rad,
            ports.start_count if starts else 0, starts,
            device if device.space is not None else None,
        )  # fmt: skip

    def but(self, k_t: float | None, counts: int | None) -> Known:
        """The same with another torque constant, N·m/A, or encoder, counts a turn, if given."""
        cell_rad = None if counts is None else 2 * math.pi / counts
        return replace(self, k_t=k_t or self.k_t, cell_rad=cell_rad or self.cell_rad)


def first_scene(device: Device) -> Scene:
    """The scene of a motor of an arm, or of the only one; :class:`SceneError` where there are
    several without an arm."""
    if device.space is not None:
        return device.scenes[0]
    return device.one("one is taken here; leave one of them in the file")


@dataclass
class _Wish:
    """W as its sliders have it."""

    stiffness: float
    damping: float
    shaper: Shaper


_Change = tuple[dict[Place, float], _Wish | None]
"""Words to be written, and W after that."""


class Bench:
    """One motor of a device, with what is known of it. ``motor`` is its place on the device.

    ``before`` is the bench before the line was lost: what it set is known still, where the device
    has it still. All that talks to the device raises :class:`HostError`.
    """

    def __init__(
        self, client: Client, known: Known, motor: int = 0, before: Bench | None = None
    ) -> None:
        self.client, self.known, self.motor = client, known, motor
        options = client.identification.options
        self.anchored = bool(options["anchor"])
        self.arms = bool(options["arm"])
        self.brushless = client.shape.brushless
        if self.brushless and known.scene is not None and not known.scene.motor.brushless:
            raise HostError("the device has a brushless motor, and the scene's has brushes")
        self._step, self._seen = self._all(STEP), self._all(ANCHOR) if self.anchored else []
        if self.brushless:
            beta = motor + 1
            self._step += self._all(AXIS, beta)
            self._seen += self._all((*(ANCHOR if self.anchored else ()), "saturated"), beta)
        self._magnet: tuple[int, int] | None = None
        """A position and the electrical angle in its middle, both as raw words."""
        self._status = self._all(("faults", "running", "overrun", "armed", "arm_refused"))
        self._clock_hz = client.identification.words["clock_hz"]
        self._sections = options["shaper"]
        self._wish: _Wish | None = None
        self.arm_bench: ArmBench | None = None
        if known.device is not None:
            from wavehaptics.host.scope.arm import ArmBench  # compiles

            self.arm_bench = ArmBench(client, known.device)
        self._names = (
            "half_clocks", "tick_halves", "extra_ticks", "samples", "gain", "root", "a", "u_max",
            "eta_contact", "eta_free",
            "wall_min", "wall_max", "wall_enable",
            *(("wall_shaped", *_SHAPE) if self._sections else ()),
            *(_ANCHOR if self.anchored else ()),
            *(("count_angle",) if self.brushless else ()),
        )  # fmt: skip
        self.refresh()
        self._owes = self.anchored and bool(self._value("anchor_owed_gain"))
        self._wall_at = self._value("wall_min")
        self._free_at, self._most_free = self._value("eta_free"), 1.0
        self._feel = ""
        table = known.scene.shaper if known.scene else None
        spring = table is not None and self._sections and table.feel == "spring"
        # Without a port W's sliders aren't there, until the scope begins anew.
        if table is not None and spring and self._moves:
            self._wish = self._wished(table.stiffness or 0.0, table.damping, self.tau_s)
        if before is not None and before.client.identification.options == options:
            self._go_on(before)

    def _go_on(self, before: Bench) -> None:
        """Know what the bench before knew, as far as the device wasn't reset or set by others."""
        self._wall_at, self._owes = before._wall_at, before._owes

        def has(*names: str) -> bool:
            return all(self._values[at] == was for at, was in before._values.items()
                       if not names or at[0] in names)  # fmt: skip

        if has(*_SHAPE):
            self._wish = before._wish
        if has("eta_free"):
            self._free_at, self._most_free = before._free_at, before._most_free
        if has():
            self._feel = before._feel

    def _all(self, names: Iterable[str], motor: int | None = None) -> list[Place]:
        return [self._place(name, motor) for name in names]

    def _place(self, name: str, motor: int | None = None) -> Place:
        motor = self.motor if motor is None else motor
        return readable(places(name, self.client.shape, motor)[0])

    def refresh(self) -> None:
        """Read the settings that the page shows."""
        found = [p for name in self._names for p in places(name, self.client.shape, self.motor)]
        raws = self.client.read(found)
        self._values = {
            (p.word.name, p.index): p.value(raw) for p, raw in zip(found, raws, strict=True)
        }

    def _value(self, name: str, index: int = 0) -> float:
        return self._values[name, index]

    # ---- What is read again and again.

    def step(self) -> dict[str, float]:
        """Live words of one tick by their names, in their units."""
        return self._live(self._step)

    def seen(self) -> dict[str, float]:
        """Live words of the port anchor, none without one."""
        return self._live(self._seen)

    def status(self) -> dict[str, int]:
        """Faults and arming, as raw words."""
        if self.brushless and self.anchored:
            self._find_magnet()
        raws = self.client.read(self._status)
        return {p.word.name: raw for p, raw in zip(self._status, raws, strict=True)}

    def _live(self, found: list[Place]) -> dict[str, float]:
        """Values by name; those of a brushless motor's second axis with ``@1`` behind it."""
        raws = self.client.read(found)
        names = (
            f"{p.word.name}@{p.motor - self.motor}" if p.motor > self.motor else p.word.name
            for p in found
        )
        return {name: p.value(raw) for name, p, raw in zip(names, found, raws, strict=True)}

    def _find_magnet(self) -> None:
        """Take the magnets' angle at a position, once the device knows it and the rotor rests.

        It tells that of its first motor alone.
        """
        (found,) = self.client.read([self._place("magnet_found")])
        if not found:
            self._magnet = None
        elif self._magnet is None and self.motor == 0:
            position, angle = self._place("position"), self._place("magnet_angle")
            before, turned, after = (self.client.read([p])[0] for p in (position, angle, position))
            if before == after:
                self._magnet = before, turned

    def _theta(self, position: float) -> float | None:
        """Electrical angle at a position in counts, rad; None while nobody knows it.

        The device's own, with port anchors; without them that of a scene in which it began.
        """
        scene = self.known.scene
        if self._magnet is not None:
            at, angle = self._magnet
            counts = (int(position) - at) * int(self._value("count_angle"))
            return _TURN * ((angle + counts) % 2**32)
        if self.anchored or scene is None or not self.known.starts:
            return None
        pairs = scene.motor.pole_pairs or 0
        return pairs * (self.place_rad(position) - scene.controller.magnet_hat_rad)

    # ---- What is commanded.

    def arm(self, value: int) -> None:
        """Write the word ``arm``."""
        self.client.write([(places("arm", self.client.shape)[0], value)])

    def clear(self) -> None:
        """Forget faults that are over."""
        self.client.write([(places("clear", self.client.shape)[0], 1)])

    def set_word(self, text: str) -> None:
        """Write ``NAME=VALUE``, in the word's unit. Settings alone: what arms is to be renewed."""
        name, _, value = text.partition("=")
        try:
            given = number(value.strip()) if name.strip() else None
        except ValueError:
            given = None
        if given is None:
            what = f"{text.strip()}: " if text.strip() else ""
            raise HostError(f"{what}write NAME=NUMBER, as in root=2.0")
        found = [settable(p) for p in places(name.strip(), self.client.shape, self.motor)]
        if found[0].word.row.kind == "command":
            word = found[0].word.name
            instead = _INSTEAD.get(word, "`board set` writes it")
            raise HostError(f"{word} is a command and no setting; {instead}")
        if len(found) > 1:
            raise HostError(f"{text}: which one? Take {found[0].text}...{found[-1].text}")
        self.client.write([(found[0], found[0].raw(given))])
        self._feel = ""
        self.refresh()

    def slide(self, name: str, value: float) -> None:
        """Write what a slider of :meth:`shown` means."""
        found = {
            "lambda": self._lambda_words, "eta": self._eta_words, "wall": self._wall_words,
            "soft": self._soft_words, "stiffness": self._stiffness_words,
            "damping": self._damping_words,
        }.get(name)  # fmt: skip
        if found is None or not math.isfinite(value):
            raise HostError(f"{name} = {value}: there is no such slider, or the value is no number")
        if name in ("stiffness", "damping", "soft") and self._wish is None:
            raise HostError(f"{name}: W of this device isn't known; it takes a scene's [shaper]")
        words, wish = found(value)
        self._write(words)
        self._wish, self._feel = wish, ""

    def _write(self, words: Mapping[Place, float]) -> None:
        raws = {place: place.raw(word) for place, word in words.items()}
        self.client.write(raws.items())
        self._values |= {
            (p.word.name, p.index): p.value(raw & 0xFFFFFFFF) for p, raw in raws.items()
        }

    def feel(self, name: str) -> None:
        """Set a feel of :data:`FEELS`: its walls, η and W, in free space until all of it is there.

        Each frame of the line is a commit of its own. So the old walls end with the first one, and
        the new ones begin together with the last.
        """
        feel = FEELS.get(name)
        if feel is None:
            raise HostError(f"{name}: there is no such feel; take one of {', '.join(FEELS)}")
        walls = self._feel_walls(feel)
        place = self._place("position")
        at, face = place.value(self.client.read([place])[0]), self._edge(self._wall_at)
        low, high = (face + self._span * end for end in feel.start)
        if not low <= self._edge(at) < high:
            where = f"{low:.4g} to {high:.4g}" if math.isfinite(low) else f"below {high:.4g}"
            raise HostError(
                f"{feel.title}: the rotor would be inside its wall; move it first, to {where} "
                + ("counts" if self.known.cell_rad is None else "rad")
            )
        words, wish = self._filter_words(self._value("a"), feel.eta_contact, feel.eta_free)
        free = self._place("eta_free")
        words[free] = min(words.get(free, self._free_at), feel.eta_free)
        if feel.soft:
            scene, tau_s = self.known.scene, self.tau_s
            assert scene is not None
            damper = closed_forms.b_r(scene.controller.k_t_hat, self._r_hat)
            wish = self._wished(feel.stiffness * self._front(tau_s), feel.damping * damper, tau_s)
            words |= self._shape_words(wish)
        words |= zip(self._each("wall_min"), (low for low, _ in walls), strict=False)
        words |= zip(self._each("wall_max"), (high for _, high in walls), strict=False)
        if self._sections:
            words |= {p: int(n < feel.soft) for n, p in enumerate(self._each("wall_shaped"))}
        off = dict.fromkeys(self._each("wall_enable"), 0)
        there = {p: int(n < len(walls)) for n, p in enumerate(off)}
        for place, word in words.items():
            place.raw(word)  # all is in range before anything is written
        for part in (off, words, there):
            self._write(part)
        self._wish, self._feel, self._most_free = wish, name, feel.eta_free

    def _each(self, name: str) -> list[Place]:
        return places(name, self.client.shape, self.motor)

    def _feel_walls(self, feel: Feel) -> list[tuple[float, float]]:
        """Both edges of each wall, counts of the device; :class:`HostError` where it can't be."""
        if self.brushless or self.arm_bench is not None or self.client.shape.motors != 1:
            raise HostError(f"{feel.title}: feels are for a board with one motor with brushes")
        if feel.soft and self._wish is None:
            raise HostError(
                f"{feel.title}: W of this device isn't known; it takes a scene's [shaper]"
            )
        found = placed(feel, len(self._each("wall_min")), self._span / (self.known.cell_rad or 1.0))
        return [(self._wall_at + low, self._wall_at + high) for low, high in found]

    def _has(self, feel: Feel) -> bool:
        try:
            self._feel_walls(feel)
        except HostError:
            return False
        return self._moves

    def _lambda_words(self, lambda_: float) -> _Change:
        if lambda_ <= 0.0:
            raise HostError(f"lambda = {lambda_:g} rad/s is out of range; it is above 0")
        matched = closed_forms.matched_a(self.tick_s, lambda_, self._extra_ticks)
        return self._filter_words(matched, self._value("eta_contact"), self._most_free)

    def _eta_words(self, eta: float) -> _Change:
        return self._filter_words(self._value("a"), eta, self._most_free)

    def _filter_words(self, a: float, eta: float, most_free: float) -> _Change:
        """Of a and η, with what depends on them: free space, W, and what the anchor is owed."""
        a = formats.A.to_value(formats.A.to_raw(a))
        if not a:
            raise HostError(
                f"lambda is too low: a would be below its last place {formats.A.step:.1e}"
            )
        words: dict[Place, float] = {self._place("a"): a, self._place("eta_contact"): eta}
        if self._owes:
            owed = self._value("anchor_flux_gain") / a if eta == -1.0 else 0.0
            words[self._place("anchor_owed_gain")] = min(owed, formats.FLUX.largest)
        tau_s = closed_forms.tau(self.tick_s, a, self._extra_ticks)
        if self.known.scene is not None:
            try:
                control = self._scene(f"controller.lambda={1.0 / tau_s!r}").controller
            except SceneError as error:
                raise HostError(" ".join(str(error).split())) from None
            words[self._place("eta_free")] = min(control.eta_free, most_free)
        if self._wish is None:
            return words, None
        wish = self._wished(self._wish.stiffness, self._wish.damping, tau_s)
        return words | self._shape_words(wish), wish

    def _wall_words(self, edge: float) -> _Change:
        cell = self.known.cell_rad
        count = edge if cell is None else edge / cell - self.known.start_count
        return {self._place("wall_min"): round(count)}, self._wish

    def _soft_words(self, soft: float) -> _Change:
        return {self._place("wall_shaped"): int(bool(soft))}, self._wish

    def _stiffness_words(self, stiffness: float) -> _Change:
        assert self._wish is not None
        wish = self._wished(stiffness, self._wish.damping, self.tau_s)
        return self._shape_words(wish), wish

    def _damping_words(self, damping: float) -> _Change:
        assert self._wish is not None
        wish = self._wished(self._wish.stiffness, damping, self.tau_s)
        return self._shape_words(wish), wish

    def _wished(self, stiffness: float, damping: float, tau_s: float) -> _Wish:
        """W for a spring and a damper, no stiffer than motor and delay leave for now."""
        if not (self._r_hat and math.isfinite(tau_s)):
            raise HostError("a or root of the device is 0, with which there is no W; set it first")
        had = min(stiffness, _SHAPE_PARTS[1] * self._front(tau_s))
        try:
            scene = self._scene(f"shaper.stiffness={had!r}", f"shaper.damping={damping!r}")
            made = design(scene, self.tick_s, tau_s, self._r_hat)
        except (WishError, SceneError) as error:
            raise HostError(" ".join(str(error).split())) from None
        return _Wish(stiffness, damping, made)

    def _scene(self, *more: str) -> Scene:
        """The scene with further keys; :class:`SceneError` where it can't have them."""
        assert self.known.path is not None
        return first_scene(load_device(self.known.path, [*self.known.overrides, *more]))

    def _shape_words(self, wish: _Wish) -> dict[Place, float]:
        words = wish.shaper.words
        found: dict[Place, float] = {}
        parts = words[:, : wave_core.LOSS1].ravel(), words[:, wave_core.LOSS1 :].ravel()
        for name, raws in zip(_SHAPE, parts, strict=True):
            there = places(name, self.client.shape, self.motor)
            found |= {
                p: p.value(int(raw) & 0xFFFFFFFF) for p, raw in zip(there, raws, strict=False)
            }
        return found

    # ---- What follows from them.

    @property
    def tick_s(self) -> float:
        """T, s."""
        return self._value("half_clocks") * self._value("tick_halves") / self._clock_hz

    @property
    def _extra_ticks(self) -> int:
        return int(self._value("extra_ticks"))

    @property
    def tau_s(self) -> float:
        """τ of the filter's coefficient that the device has, s; endless for a = 0."""
        a = self._value("a")
        return closed_forms.tau(self.tick_s, a, self._extra_ticks) if a else math.inf

    @property
    def root(self) -> float:
        """s of the port, √Ω."""
        return self._value("root")

    @property
    def u_max(self) -> float:
        """Largest u that the port asks for, √W."""
        return self._value("u_max")

    @property
    def full_scale_a(self) -> float | None:
        """Current at the end of the ADC's scale; None where a word of it isn't the whole scale."""
        if self.client.identification.options.get("adc", 0) >= KINDS.index("sigma_delta"):
            return None
        return self._value("gain") * self._value("samples") * 2.0 ** (formats.SAMPLE_W - 1)

    @property
    def _r_hat(self) -> float:
        """R̂ of the port, Ω."""
        return 0.5 * self.root**2

    @property
    def _moves(self) -> bool:
        """Whether there is a port at all: a and root above 0, and time that passes."""
        return bool(self.tick_s and self._value("a") and self._value("root"))

    @property
    def _anchor_on(self) -> bool:
        return self.anchored and bool(self._value("anchor_enable"))

    @property
    def _soft(self) -> bool:
        return self._wish is not None and bool(self._value("wall_shaped"))

    def _front(self, tau_s: float) -> float:
        assert self.known.scene is not None
        return rendered_stiffness(self.known.scene, self._r_hat, tau_s, -1.0, self._anchor_on, None)

    @property
    def stiffness(self) -> float | None:
        """K of the design spring with the words that the device has, N·m/rad, if it is known."""
        scene = self.known.scene
        if scene is None or not self._moves:
            return None
        wish = self._wish.shaper.wish if self._wish is not None and self._soft else None
        return rendered_stiffness(
            scene, self._r_hat, self.tau_s, self._value("eta_contact"), self._anchor_on,
            wish.spring if wish is not None else None,
        )  # fmt: skip

    def place_rad(self, count: float) -> float:
        """Angle of the middle of a cell; the count itself where its angle isn't known."""
        if self.known.cell_rad is None:
            return count
        return (count + self.known.start_count + 0.5) * self.known.cell_rad

    def _edge(self, count: float) -> float:
        cell = self.known.cell_rad
        return count if cell is None else (count + self.known.start_count) * cell

    @property
    def _span(self) -> float:
        """How far the wall's slider goes to each side, rad or counts."""
        return WALL_SPAN_COUNTS if self.known.cell_rad is None else WALL_SPAN_RAD

    def shown(self) -> dict[str, Any]:
        """Settings and what follows from them, for the page."""
        scene = self.known.scene
        wall, span = self._edge(self._wall_at), self._span
        sliders: dict[str, dict[str, float]] = {
            "eta": {"value": self._value("eta_contact"), "min": -1.0, "max": 1.0},
            "wall": {
                "value": self._edge(self._value("wall_min")), "min": wall - span, "max": wall + span
            },
        }  # fmt: skip
        if self.tick_s:
            most = 1.0 / closed_forms.tau(self.tick_s, closed_forms.MOST_A, self._extra_ticks)
            least = most / LAMBDA_SPAN
            # The slider is of λ's logarithm, which a = 0 doesn't have.
            value = 1.0 / self.tau_s if self._value("a") else least
            sliders = {"lambda": {"value": value, "min": least, "max": most}, **sliders}
        if self._wish is not None and scene is not None and self._moves:
            front = self._front(self.tau_s)
            damper = _DAMPERS * closed_forms.b_r(scene.controller.k_t_hat, self._r_hat)
            low, high = (part * front for part in _SHAPE_PARTS)
            sliders["soft"] = {"value": float(self._soft), "min": 0.0, "max": 1.0}
            stiffness = min(self._wish.stiffness, high)
            sliders["stiffness"] = {"value": stiffness, "min": low, "max": high}
            sliders["damping"] = {"value": self._wish.damping, "min": 0.0, "max": damper}
        return {
            "sliders": sliders,
            "arm": self.arm_bench.shown() if self.arm_bench is not None else None,
            "a": self._value("a"),
            "eta_free": self._value("eta_free"),
            "tau_s": self.tau_s if self._moves else None,
            "tick_s": self.tick_s,
            "stiffness": self.stiffness,
            "k_l": closed_forms.k_l(scene.motor.felt_k_t, scene.motor.L_h) if scene else None,
            "brushless": self.brushless,
            "pairs": scene.motor.pole_pairs if scene and self.brushless else None,
            "magnet": self._magnet is not None if self.brushless and self.anchored else None,
            "wall": [self._edge(self._value(name)) for name in ("wall_min", "wall_max")],
            "walls": [
                {
                    "from": self._edge(self._value("wall_min", n)),
                    "to": self._edge(self._value("wall_max", n)),
                    "soft": bool(self._sections and self._value("wall_shaped", n)),
                }
                for n in range(len(self._each("wall_enable")))
                if self._value("wall_enable", n)
            ],
            "feels": [name for name, feel in FEELS.items() if self._has(feel)],
            "feel": self._feel,
            "torque": self.known.k_t is not None,
            "rad": self.known.cell_rad is not None,
            "cell": self.known.cell_rad or 1.0,
        }

    def row(self, step: Mapping[str, float], seen: Mapping[str, float]) -> dict[str, float]:
        """A row of a trace, by the names of a simulation's, of one tick's words.

        Of a brushless motor the parts along q, NaN while the magnets' angle isn't known, and both
        axes' currents; its second axis is read a frame later.
        """
        k_t, contact = self.known.k_t, bool(step["contact"])
        told = {**seen, **step}
        row = {
            "x": self.place_rad(step["position"]),
            "eta": self._value("eta_contact" if contact else "eta_free"),
            "contact": float(contact),
            "saturated": max(step["saturated"], seen.get("saturated@1", 0.0)),
        }
        if self.brushless:
            row |= {"i_alpha": step["current"], "i_beta": step["current@1"]}
            theta = self._theta(step["position"])
            cos, sin = (math.nan, math.nan) if theta is None else (math.cos(theta), math.sin(theta))
            told |= {
                name: told[f"{name}@1"] * cos - told[name] * sin
                for name in (*AXIS, *ANCHOR)
                if name in told
            }
        row |= {name: told[word] for name, word in _COLUMNS.items() if word in told}
        row["torque"] = math.nan if k_t is None else k_t * row["i"]
        return row


_COLUMNS = {"i": "current", "e_a": "voltage", "u": "u", "v": "v", "correction": "correction",
            "flux": "flux"}  # fmt: skip
"""Columns of a trace by the words that they are."""
