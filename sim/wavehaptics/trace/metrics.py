# SPDX-License-Identifier: Apache-2.0
"""The numbers of a run, gathered tick by tick at full rate in memory that does not grow.

:class:`Metrics` takes the chunks of a simulation in order and gives the same result, bit for bit,
however the run is cut into chunks. A metric that the scene does not define is None, JSON ``null``.

**Contacts.** A contact lasts while :attr:`Column.CONTACT` is set. Its edge x_w is found as the
controller finds it: the nearer edge of the wall that holds the position in the first tick, the
lower one if both are as near. Walls are taken not to touch each other. *Depth* is the way from x_w
inwards, *push* the torque outwards, so that both sides of a wall read the same.

**The first contact** is the first that *counts*: at least ``LEAST_TICKS`` long and at least
``LEAST_COUNTS`` counts deep (``IDEAL_DEPTH_RAD`` without an encoder), so that chatter on the edge
is passed over. Where none is so deep it is the deepest of a count or more, and ``reasons`` says so.
A bare rotor (path ``impact``) has no chatter to fear and may hit softly: there the depth does not
matter. A contact under way in the run's first tick has no way in; it is used only if no other one
counts.

**Its compression** runs from its first tick to its deepest, so that a wall which grows while it is
held, and pushes the rotor out, does not count with its later torque.

``stiffness`` is the slope of the least-squares line of −TORQUE over X, each tick alike, from the
first tick of the compression to the first in which the push reaches 90 % of the compression's peak
(found to 0.01 %), or to the last before the voltage saturates or the current is clipped, whichever
comes first. The lag of the controller's filter at the start is in it. None with fewer than three
ticks, or where the line explains less than ``LEAST_R2`` of the force.
``stiffness_zero_rad`` is the x where that line crosses zero torque, ``contact_edge_rad`` the x_w of
the first contact.

**The energy of a contact** is what the motor's torque did to the shaft in it, ``∫ F dx``, from the
tick's mean torque and the way that the shaft moved: above zero the wall gave energy out. A wall
that is a spring gives back as much as it took, and a real one less. ``contact_energy_j`` is the
largest of any contact, ``contact_energy_ratio`` the largest of this energy over the most that the
wall's design spring held in the same contact, ``½F²/K``. Both may be negative.

- An encoder can't tell what happens within a count or two of the edge. So a contact's account stays
  open while the rotor is out of contact but within ``EDGE_COUNTS`` counts of x_w: a rotor that
  chatters at an edge is one contact, with the energy of all its hits. And no contact is judged
  against less than what the spring holds at a depth of ``EDGE_COUNTS``: touches that are shallower
  than that count with their energy, and not with a ratio to nothing.
- A contact still open when the run ends counts with what its spring then holds, ``½F²/K``, as if
  all of that came back: a wall that only holds is not above zero, one that works on a hand is.

**A hold** compares F and x with the design spring. Where the back-EMF of a brushless motor has
harmonics, its torque for an ampere swings with the angle
(:func:`~wavehaptics.laws.closed_forms.brushless_own_k_t`), and warm magnets make less of it; the
spring's k_T is the motor's own where and as it rests, as it is the motor's own where ``k_t`` and
``k_t_hat`` differ: none of it says that the wall has moved.

``swing_rad`` is the amplitude of a sine with the RMS of the rotor's position about a straight line
in the last tenth of a ``press``: slow drift is no swing. ``swing_hz`` is the frequency Ω/2π with
which the acceleration is ``−Ω²`` times that position, by least squares; it is None where nothing
pulls the rotor back. Both are reported whether the wall still holds or not.

**A port anchor** puts c in series with a port whose voltage is ``E = s(u + v)/2``, against all that
is wrong with the motor, as a voltage d. With the port's flux by the true motor and rotor, ``χ =
L i + k_T x − ∫E dt``, it is ``c − d = dχ/dt``, and its work ``∫ i dχ = [iχ] − ∫ χ di``: as if the
wall's edge were moved to and fro with χ while the current changes. ``correction_out_max_j`` is the
most that the running sum of ``ENERGY_OUT − T·E·i`` has reached. It takes the true mean current;
with the sensor's, as in ``½T(u² − v²)``, the noise that the waves take in would count as given out
for ever. ``correction_bound_j`` is what the work can't exceed: the sum over
contacts and the ways between of half the range of χ times (current at the beginning + at the end +
total variation of the current). As the true χ goes on where the anchor sets its own anew, nothing
is to be added for that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wavehaptics.laws import closed_forms
from wavehaptics.runtime.compiled import compiled_counting
from wavehaptics.trace.columns import Column

if TYPE_CHECKING:
    from wavehaptics.scene import Scene

LEAST_TICKS = 4
"""A shorter contact is chatter."""
LEAST_COUNTS = 4
"""So many counts of the encoder less deep, it may be chatter on the edge as well."""
LEAST_FIT = 3
"""Ticks that a line takes."""
LOST_REFERENCE = 0.25
"""What the reference's force lacks of the spring's, as a mean over its peak, from which on it has
lost its wall. One that is held is at 0.02 or below, up to 0.17 where the voltage saturates."""
LEAST_R2 = 0.8
"""A line explains this part of the force's variance, or it is none. A wall with an anchor has 0.86
over 4 counts, and the right slope; over 2 counts it has 0.5, and half of the slope."""
IDEAL_DEPTH_RAD = 1e-5
"""Takes their place where the scene has no encoder: 23 µN·m on the paper's motor."""
EDGE_COUNTS = 2.0
"""Encoder counts beside an edge within which a contact's account of energy stays open, and the
depth whose stored energy it is compared with at least."""
PEAK_PART = 0.9
"""The fit ends where the push first reaches this part of its peak."""
_LEVEL_STEP = 1e-4
_LEVELS = 2048
assert (1.0 + _LEVEL_STEP) ** _LEVELS > 1.0 / PEAK_PART, "the ring must reach back to 90 %"

# The ripple's median comes from a histogram of 2^-10 relative steps from 2^-50 A to 2^14 A: the
# top bits of a double are its exponent and the first of its fraction, and grow with its value.
_BIN_SHIFT = 52 - 10
_BIN_BASE = (1023 - 50) << 10
_BINS = 64 << 10

_X, _OMEGA, _I, _TORQUE, _CONTACT, _SATURATED, _CLIPPED, _ENERGY_OUT, _RIPPLE, _U, _V, _T = map(
    int,
    (Column.X, Column.OMEGA, Column.I, Column.TORQUE, Column.CONTACT, Column.SATURATED,
     Column.CLIPPED, Column.ENERGY_OUT, Column.RIPPLE, Column.U, Column.V, Column.T),
)  # fmt: skip
_X_HAT, _OMEGA_HAT, _FAULT = map(int, (Column.X_HAT, Column.OMEGA_HAT, Column.FAULT))

# Slots of fits: two by turns for contacts that began in the run, one for that of its beginning.
_FIRST_FRESH, _INITIAL, _OTHER_FRESH, _NONE = 0, 1, 2, -1
_PENDING, _KNOWN, _REFUSED = 0, 1, 2


def _record(*groups: str) -> np.dtype:
    """A record of groups of fields: each a type and the fields' names."""
    split = [group.split() for group in groups]
    return np.dtype([(name, kind) for kind, *names in split for name in names], align=True)


_RUN = _record(
    # Of the scene: the tick from which a hold is judged, past every run without one; whether the
    # path is an impact, and k_T changes with the magnets' temperature.
    "i8 hold_start impact warm",
    # A count, the depth of a contact that counts, 1/K of the design spring of the wall that is
    # touched; of the motor's own k_T its swing, six times an electrical turn.
    "f8 cell least compliance swing pole_pairs magnet shape_power",
    # Sums over the run; ``unfit`` is 0 while every number is finite, then NaN.
    "i8 ticks saturated clipped free_ticks",
    "f8 unfit torque_peak current_peak energy energy_peak free_square error_square reference_peak",
    # Of the reference's contacts: where the rotor came in, and how far its force is from the
    # spring's.
    "i8 reference_contact reference_ticks",
    "f8 reference_edge reference_spring reference_lack",
    # The contact under way; which fit it feeds, and whether the fresh one is settled.
    "i8 in_contact contacts length fit settled",
    "f8 edge side omega_in omega_last",
    # Slot of the contact under way, or of the one that counts, and of the deepest that doesn't;
    # contacts that don't count, before the one that does.
    "i8 fresh shallow passed",
    "f8 passed_depth",
    "i8 bounce",
    "f8 restitution",
    # The last tenth of a hold.
    "i8 hold_ticks hold_contact",
    "f8 hold_offset hold_depth hold_first hold_sum hold_square hold_x hold_omega",
    # From a tick's middle to the next: sums of x, with the number, and squared; and of the change
    # of ω, with the number, and with x.
    "f8 swing_last swing_sum swing_moment swing_square pull_sum pull_moment pull_product",
    # A port anchor: of the scene, ``half_root`` is s/2; and sums over the run.
    "i8 anchored",
    "f8 half_root tick_s inductance k_t",
    "f8 work work_peak flux x_hat_square omega_hat_square fault_s",
    # The account of a contact's energy, with ½F²/K of the latest tick and the most of any, and of
    # those closed.
    "i8 account accounts",
    "f8 account_edge account_compliance account_j account_held_j account_most_j",
    "f8 contact_j contact_ratio",
    # Of the contact, or the way between, and of those before.
    "f8 bound chi_low chi_high variation i_first i_last chi_last",
    "i8 contact_last",
)

_FIT = _record(
    "f8 edge side spring deepest push_peak",
    # Of the compression, up to the deepest tick so far; whether voltage or current came to their
    # limit: no more ticks into the sums.
    "f8 peak level",
    "i8 length closed levels",
    # The first level at 90 % of the peak, or the next one to come; which level is in the ring's
    # last row, -1 for none.
    "i8 end aside",
    # Sums over the ticks of the depth's and the torque's products.
    "i8 n",
    "f8 x f xx xf ff",
)
_LEVEL_FIELDS = 7  # level n x f xx xf ff


@compiled_counting()
def _find_edge(walls: np.ndarray, x: float) -> tuple[float, float, float]:
    """Edge through which a rotor that is at ``x`` in its first tick of contact came in.

    Returns (x_w, side, K), side = +1 for a lower edge and −1 for an upper one, K the wall's.
    """
    for n in range(walls.shape[0]):
        if walls[n, 0] <= x < walls[n, 1]:
            if x - walls[n, 0] <= walls[n, 1] - x:
                return walls[n, 0], 1.0, walls[n, 2]
            return walls[n, 1], -1.0, walls[n, 2]
    # The tick's mean position may still lie outside.
    edge, side, spring, nearest = x, 1.0, 0.0, np.inf
    for n in range(walls.shape[0]):
        for end in range(2):
            if abs(x - walls[n, end]) < nearest:
                nearest = abs(x - walls[n, end])
                edge, side, spring = walls[n, end], 1.0 - 2.0 * end, walls[n, 2]
    return edge, side, spring


@compiled_counting()
def _counts(fit: Any, least: float, impact: int) -> bool:
    return fit["length"] >= LEAST_TICKS and (impact != 0 or fit["deepest"] >= least)


@compiled_counting()
def _compress(fit: Any, ring: np.ndarray, x: float, torque: float, limited: bool) -> None:
    """One tick of the contact that ``fit`` follows.

    The end of the fit, 90 % of the peak, is known only when the peak is. So the sums up to each new
    height of the push are kept in a ring, 10⁻⁴ of the height apart, which reaches back to 1/1.22 of
    the newest; those that end the fit for the peak so far are set aside in its last row.
    """
    fit.length += 1
    depth = fit.side * (x - fit.edge)
    push = -fit.side * torque
    fit.push_peak = max(fit.push_peak, push)
    if limited:
        fit.closed = 1
    if not fit.closed:
        # Both about the edge and outwards, which leaves the slope as it is.
        fit.n += 1
        fit.x += depth
        fit.f += push
        fit.xx += depth * depth
        fit.xf += depth * push
        fit.ff += push * push
        if push > fit.level * (1.0 + _LEVEL_STEP):
            fit.level = push
            at = fit.levels % _LEVELS
            fit.levels += 1
            ring[at, 0] = push
            ring[at, 1] = fit.n
            ring[at, 2] = fit.x
            ring[at, 3] = fit.f
            ring[at, 4] = fit.xx
            ring[at, 5] = fit.xf
            ring[at, 6] = fit.ff
    if depth > fit.deepest:
        fit.deepest = depth
        fit.peak = fit.push_peak
        end = max(fit.end, fit.levels - _LEVELS)
        while end < fit.levels and ring[end % _LEVELS, 0] < PEAK_PART * fit.peak:
            end += 1
        if end < fit.levels and end != fit.aside:
            ring[_LEVELS] = ring[end % _LEVELS]
            fit.aside = end
        fit.end = end


@compiled_counting()
def _enter(run: Any, fits: np.ndarray, walls: np.ndarray, x: float) -> None:
    """First tick of a contact."""
    run.in_contact = 1
    run.contacts += 1
    run.length = 0
    run.edge, run.side, spring = _find_edge(walls, x)
    if spring > 0.0:
        run.compliance = 1.0 / spring
    run.omega_in = run.omega_last
    if run.ticks == 0:
        run.fit = _INITIAL
        run.bounce = _REFUSED  # no speed of entry
    elif not run.settled:
        run.fit = run.fresh
    else:
        return
    fit = fits[run.fit]
    fit.edge = run.edge
    fit.side = run.side
    fit.spring = spring
    fit.length = 0
    fit.deepest = 0.0
    fit.push_peak = 0.0
    fit.peak = 0.0
    fit.closed = 0
    fit.level = 0.0
    fit.levels = 0
    fit.end = 0
    fit.aside = -1
    fit.n = 0
    fit.x = 0.0
    fit.f = 0.0
    fit.xx = 0.0
    fit.xf = 0.0
    fit.ff = 0.0


@compiled_counting()
def _leave(run: Any, fits: np.ndarray, omega: float) -> None:
    """First tick out of contact, in which the mean speed is ``omega``."""
    run.in_contact = 0
    if run.fit == run.fresh:
        fit = fits[run.fresh]
        if _counts(fit, run.least, run.impact):
            run.settled = 1
        else:
            run.passed += 1
            run.passed_depth = max(run.passed_depth, fit.deepest)
            if _counts(fit, run.cell, 0) and (
                run.shallow == _NONE or fit.deepest > fits[run.shallow].deepest
            ):
                run.shallow = run.fresh
                run.fresh = _FIRST_FRESH + _OTHER_FRESH - run.fresh
    run.fit = _NONE
    if run.bounce == _PENDING:
        if run.side * omega < 0.0 and run.omega_in != 0.0:
            run.bounce = _KNOWN
            run.restitution = abs(omega / run.omega_in)
        elif run.length >= LEAST_TICKS:
            run.bounce = _REFUSED  # it went through


@compiled_counting()
def _open_account(run: Any) -> None:
    """First tick of a contact whose energy is to be counted."""
    run.account = 1
    run.account_edge = run.edge
    run.account_compliance = run.compliance
    run.account_j = 0.0
    run.account_held_j = 0.0
    # What the spring holds at EDGE_COUNTS, 0 where there is no spring.
    run.account_most_j = 0.0
    if run.compliance > 0.0:
        run.account_most_j = 0.5 * (EDGE_COUNTS * run.cell) ** 2 / run.compliance


@compiled_counting()
def _close_account(run: Any) -> None:
    """The rotor is away from the edge: the contact's energy is known."""
    energy = run["account_j"]
    ratio = energy / run["account_most_j"] if run["account_most_j"] > 0.0 else 0.0
    if run["accounts"] == 0:
        run["contact_j"], run["contact_ratio"] = energy, ratio
    run["contact_j"] = max(run["contact_j"], energy)
    run["contact_ratio"] = max(run["contact_ratio"], ratio)
    run["accounts"] += 1
    run["account"] = 0


@compiled_counting()
def _own_spring(run: Any, x: float, i: float, torque: float) -> float:
    """The spring of a wall with the motor's k_T as it is, in parts of the design spring."""
    own = 1.0
    if run.swing != 0.0:
        theta = run.pole_pairs * (x - run.magnet)
        own += run.swing * math.cos(6.0 * theta)
    if run.warm and i != 0.0:
        own = torque / (run.k_t * i)
    part: float = own**run.shape_power
    return part


@compiled_counting()
def _account(run: Any, omega: float, torque: float, spring_part: float) -> None:
    """A tick of a contact, or close to the edge of one."""
    run.account_j += torque * omega * run.tick_s
    run.account_held_j = 0.5 * torque * torque * run.account_compliance / spring_part
    run.account_most_j = max(run.account_most_j, run.account_held_j)


@compiled_counting()
def _swing(run: Any, swung: float, pull: float) -> None:
    """From the middle of a hold's tick to that of the next, with ``pull`` the change of ω."""
    middle = 0.5 * (swung + run.swing_last)
    run.swing_last = swung
    run.swing_sum += middle
    run.swing_moment += run.hold_ticks * middle
    run.swing_square += middle * middle
    run.pull_sum += pull
    run.pull_moment += run.hold_ticks * pull
    run.pull_product += pull * middle


@compiled_counting()
def _part_bound(run: Any) -> float:
    """Most work of c − d in the contact under way, or on the way between two."""
    half_range = 0.5 * (run["chi_high"] - run["chi_low"])
    most: float = half_range * (abs(run["i_first"]) + abs(run["i_last"]) + run["variation"])
    return most


@compiled_counting()
def _correct(run: Any, row: np.ndarray, contact: bool) -> None:
    """A tick of a port anchor."""
    i = row[_I]
    port = run.half_root * (row[_U] + row[_V]) * run.tick_s
    run.work += row[_ENERGY_OUT] - port * i
    run.work_peak = max(run.work_peak, run.work)
    chi = run.inductance * i + run.k_t * row[_X] - (run.flux + 0.5 * port)
    run.flux += port
    if run.ticks == 0:
        run.i_last, run.chi_last, run.contact_last = i, chi, -1
    if contact != run.contact_last:
        if run.ticks:
            run.bound += _part_bound(run)
        run.contact_last = contact
        run.chi_low = run.chi_high = run.chi_last
        run.i_first = run.i_last
        run.variation = 0.0
    run.chi_low, run.chi_high = min(run.chi_low, chi), max(run.chi_high, chi)
    run.variation += abs(i - run.i_last)
    run.i_last, run.chi_last = i, chi
    x = row[_X] + 0.5 * row[_OMEGA] * run.tick_s
    run.x_hat_square += (row[_X_HAT] - x) ** 2
    run.omega_hat_square += (row[_OMEGA_HAT] - row[_OMEGA]) ** 2
    if row[_FAULT] != 0.0 and run.fault_s < 0.0:
        run.fault_s = row[_T]


@compiled_counting()
def _refer(run: Any, walls: np.ndarray, row: np.ndarray) -> None:
    """A tick of the reference: what its force lacks of the spring's, towards its peak."""
    if row[_CONTACT] == 0.0:
        run.reference_contact = 0
        return
    if not run.reference_contact:
        run.reference_contact = 1
        run.reference_edge, _, _ = _find_edge(walls, row[_X])
    depth = row[_X] - run.reference_edge
    wanted = -run.reference_spring * depth
    run.reference_ticks += 1
    run.reference_lack += (wanted - row[_TORQUE]) * (1.0 if wanted > 0.0 else -1.0)


@compiled_counting()
def _gather(
    runs: np.ndarray, fits: np.ndarray, rings: np.ndarray, bin_counts: np.ndarray,
    bin_sums: np.ndarray, walls: np.ndarray, rows: np.ndarray, bits: np.ndarray,
    reference: np.ndarray,
) -> None:  # fmt: skip
    """Take a chunk of rows; ``bits`` are the same numbers as int64, ``reference`` may be empty."""
    run = runs[0]
    compared = reference.shape[0] == rows.shape[0]
    for n in range(rows.shape[0]):
        x = rows[n, _X]
        omega = rows[n, _OMEGA]
        torque = rows[n, _TORQUE]
        ripple = rows[n, _RIPPLE]
        contact = rows[n, _CONTACT] != 0.0
        saturated = rows[n, _SATURATED] != 0.0
        clipped = rows[n, _CLIPPED] != 0.0

        energy = run.energy + rows[n, _ENERGY_OUT]
        run.energy = energy
        run.energy_peak = max(run.energy_peak, energy)
        run.torque_peak = max(run.torque_peak, abs(torque))
        run.current_peak = max(run.current_peak, abs(rows[n, _I]))
        run.saturated += saturated
        run.clipped += clipped
        run.unfit += 0.0 * (x + omega + torque + ripple + rows[n, _I] + energy)

        at = min(max((bits[n, _RIPPLE] >> _BIN_SHIFT) - _BIN_BASE, 0), _BINS - 1)
        bin_counts[at] += 1
        bin_sums[at] += ripple

        if compared:
            run.error_square += (torque - reference[n, _TORQUE]) ** 2
            run.reference_peak = max(run.reference_peak, abs(reference[n, _TORQUE]))
            _refer(run, walls, reference[n])

        if contact:
            if not run.in_contact:
                _enter(run, fits, walls, x)
                if not run.account:
                    _open_account(run)
            run.length += 1
            if run.fit >= 0:
                _compress(fits[run.fit], rings[run.fit], x, torque, saturated or clipped)
        else:
            if run.in_contact:
                _leave(run, fits, omega)
            if run.account and abs(x - run.account_edge) > EDGE_COUNTS * run.cell:
                _close_account(run)
            run.free_ticks += 1
            run.free_square += torque * torque
        spring_part = 1.0
        if run.swing != 0.0 or run.warm:
            spring_part = _own_spring(run, x, rows[n, _I], torque)
        if run.account:
            _account(run, omega, torque, spring_part)
        run.omega_last = omega
        if run.anchored:
            _correct(run, rows[n], contact)

        if run.ticks >= run.hold_start:
            if run.hold_ticks == 0:
                run.hold_first = torque
                run.hold_x, run.swing_last = x, 0.0
            else:
                _swing(run, x - run.hold_x, omega - run.hold_omega)
            run.hold_omega = omega
            run.hold_ticks += 1
            run.hold_contact += contact
            run.hold_offset += torque * run.compliance / spring_part + x - run.edge
            run.hold_depth += x - run.edge
            # About the first value: the mean is far larger than the ripple.
            run.hold_sum += torque - run.hold_first
            run.hold_square += (torque - run.hold_first) ** 2
        run.ticks += 1


class Metrics:
    """Gathers the metrics of one run of ``scene`` on ``controller``, chunk by chunk.

    ``tick_s`` is T in s. ``stiffness_predicted`` is the K of the design spring in N·m/rad, computed
    with the coefficients as the controller holds them; None where the controller has none, and then
    the metrics of a hold are None too. ``walls`` are the intervals (x_min, x_max) in rad as the
    encoder quantises them, and ``springs`` the K of each, where they aren't all that one. ``root``
    is s of a port with an anchor, √Ω; None without one. Of the motor's own k_T over the nominal one
    the design spring has the power ``shape_power``: 1 where
    the controller's position makes the current, 2 where the winding's own flux does.
    ``reference_spring`` is the K of the reference's wall, N·m/rad, where it may lose that and the
    run doesn't. ``path`` is that of a hand that isn't the scene's, and ``count`` what takes the
    place of its encoder's: those of a device's tip (:mod:`wavehaptics.trace.tip`). With
    ``through_edge`` the line of the stiffness is that through the wall's edge.
    """

    def __init__(
        self, scene: Scene, tick_s: float, *, controller: str,
        stiffness_predicted: float | None = None, walls: Sequence[tuple[float, float]] = (),
        springs: Sequence[float] | None = None, root: float | None = None, shape_power: int = 1,
        reference_spring: float | None = None, path: str | None = None, count: float | None = None,
        through_edge: bool = False,
    ) -> None:  # fmt: skip
        self._scene = scene
        self._through_edge = through_edge
        self._tick_s = tick_s
        self._controller = controller
        self._predicted = stiffness_predicted
        each = [stiffness_predicted or 0.0] * len(walls) if springs is None else springs
        self._walls = np.array(
            [(low, high, spring) for (low, high), spring in zip(walls, each, strict=True)],
            dtype=np.float64,
        ).reshape(-1, 3)
        self._has_reference: bool | None = None
        self._runs = np.zeros(1, dtype=_RUN)
        self._fits = np.zeros(3, dtype=_FIT)
        self._rings = np.zeros((3, _LEVELS + 1, _LEVEL_FIELDS))
        self._bin_counts = np.zeros(_BINS, dtype=np.int64)
        self._bin_sums = np.zeros(_BINS)
        self._nothing = np.zeros((0, len(Column)))

        if scene.hand is not None:
            path = scene.hand.path
        ticks = round(scene.scene.duration_s / tick_s)
        run = self._runs[0]
        run["fit"] = run["shallow"] = _NONE
        run["fresh"] = _FIRST_FRESH
        run["impact"] = path == "impact"
        run["bounce"] = _PENDING if path == "impact" else _REFUSED
        run["cell"] = run["least"] = IDEAL_DEPTH_RAD
        if scene.encoder is not None:
            run["cell"] = 2.0 * math.pi / scene.encoder.counts_per_rev
            run["least"] = LEAST_COUNTS * run["cell"]
        if count is not None:
            run["cell"], run["least"] = count, LEAST_COUNTS * count
        run["compliance"] = 1.0 / stiffness_predicted if stiffness_predicted else 0.0
        motor = scene.motor
        if motor.brushless:
            run["swing"] = motor.harmonic_7 - motor.harmonic_5
            run["pole_pairs"], run["magnet"] = motor.pole_pairs, motor.magnet_rad
        run["anchored"] = root is not None
        run["half_root"] = 0.5 * (root or 0.0)
        run["reference_spring"] = reference_spring or 0.0
        run["tick_s"] = tick_s
        run["inductance"] = scene.motor.L_h
        run["k_t"] = scene.motor.k_t
        run["fault_s"] = -1.0
        run["shape_power"] = shape_power
        run["warm"] = scene.thermal is not None and scene.thermal.magnet_per_k != 0.0
        run["hold_start"] = ticks - ticks // 10 if path == "press" else np.iinfo(np.int64).max

    def update(self, rows: np.ndarray, reference_rows: np.ndarray | None = None) -> None:
        """Take the next ticks: ``rows`` float64 (n, len(Column)), in order.

        ``reference_rows``, of the same shape, are those of the analog circuit in the same ticks;
        they come with every chunk or with none, else ``ValueError``. ``FloatingPointError`` if a
        number is not finite.
        """
        if rows.ndim != 2 or rows.shape[1] != len(Column):
            raise ValueError(f"rows must be (ticks, {len(Column)}), not {rows.shape}")
        if reference_rows is not None and reference_rows.shape != rows.shape:
            raise ValueError(f"reference rows are {reference_rows.shape}, rows {rows.shape}")
        if self._has_reference not in (None, reference_rows is not None):
            raise ValueError("reference rows must come with every chunk or with none")
        self._has_reference = reference_rows is not None
        reference = self._nothing if reference_rows is None else reference_rows
        rows = np.ascontiguousarray(rows, dtype=np.float64)
        _gather(
            self._runs,
            self._fits,
            self._rings,
            self._bin_counts,
            self._bin_sums,
            self._walls,
            rows,
            rows.view(np.int64),
            np.ascontiguousarray(reference, dtype=np.float64),
        )
        run = self._runs[0]
        if run["unfit"] != 0.0:
            bad = rows[~np.isfinite(rows).all(axis=1), Column.T]
            where = f" at t = {bad[0]:.9g} s" if bad.size else ""
            raise FloatingPointError(f"the simulation has left the finite numbers{where}")
        if run["contacts"] and not self._walls.size:
            raise ValueError("rows in contact, but no walls were given")

    def _first_contact(self) -> int | None:
        run = self._runs[0]
        fresh, shallow = int(run["fresh"]), int(run["shallow"])
        if shallow != _NONE and self._fits[fresh]["deepest"] < self._fits[shallow]["deepest"]:
            fresh = shallow
        for least in (run["least"], run["cell"]):
            for slot in (fresh, _INITIAL):
                if _counts.py_func(self._fits[slot], least, run["impact"]):
                    return slot
        return None

    def _stiffness(self, slot: int | None) -> tuple[float | None, float | None, str | None]:
        """Slope of −F over x and x of its zero, of the contact in ``slot``; what to say of it."""
        if slot is None:
            return None, None, self._no_contact()
        fit = self._fits[slot]
        if fit["peak"] <= 0.0:
            return None, None, "the wall never pushed outwards in the first contact"
        if fit["end"] == fit["aside"]:
            n, x, f, xx, xf, ff = self._rings[slot, _LEVELS, 1:]
        else:  # voltage or current came to their limit before
            n, x, f, xx, xf, ff = (float(fit[name]) for name in ("n", "x", "f", "xx", "xf", "ff"))
        if n < LEAST_FIT:
            return None, None, (
                f"voltage or current were at their limit from tick {int(n) + 1} of the first "
                "contact on"
            )  # fmt: skip
        variance, spread, common = xx - x * x / n, ff - f * f / n, xf - x * f / n
        if variance <= 0.0 or common <= 0.0:
            return None, None, f"the force doesn't grow with the depth{self._only(slot)}"
        explained = common * common / (variance * spread)
        if explained < LEAST_R2:
            return None, None, (
                f"the force is no line over the depth{self._only(slot)}: r² is {explained:.2g}"
            )  # fmt: skip
        if self._through_edge:
            return xf / xx, float(fit["edge"]), self._passed_over(slot)
        slope = common / variance
        return slope, fit["edge"] + fit["side"] * (x - f / slope) / n, self._passed_over(slot)

    def _no_contact(self) -> str | None:
        """Why no contact counts; None where the scene has no wall."""
        run = self._runs[0]
        if not self._walls.size:
            return None
        if not run["contacts"]:
            return "the rotor never came into a wall"
        deepest = max(run["passed_depth"], *(float(fit["deepest"]) for fit in self._fits))
        return (
            f"no contact lasts {LEAST_TICKS} ticks and is {self._depth(run['cell'])} deep; the "
            f"deepest is {self._depth(deepest)}"
        )

    def _only(self, slot: int) -> str:
        """That the contact in ``slot`` is one of those that are hardly deep enough."""
        run, deepest = self._runs[0], float(self._fits[slot]["deepest"])
        if run["impact"] or deepest >= run["least"]:
            return ""
        return f" of a contact of only {self._depth(deepest)}"

    def _passed_over(self, slot: int) -> str | None:
        passed = int(self._runs[0]["passed"])
        if only := self._only(slot):
            return only[1:]
        if not passed:
            return None
        several = "contacts" if passed > 1 else "contact"
        return (
            f"{passed} {several} before, shorter than {LEAST_TICKS} ticks or less deep than "
            f"{self._depth(self._runs[0]['least'])}, passed over"
        )

    def _depth(self, depth: float) -> str:
        """A depth in rad, in counts where there is an encoder."""
        if self._scene.encoder is None:
            return f"{depth:.2g} rad"
        return f"{depth / self._runs[0]['cell']:.2g} counts"

    def _ripple_median(self) -> float | None:
        total = int(self._bin_counts.sum())
        if total == 0:
            return None
        middle = np.searchsorted(
            np.cumsum(self._bin_counts), [(total - 1) // 2, total // 2], side="right"
        )
        return float(np.mean(self._bin_sums[middle] / self._bin_counts[middle]))

    def _predicted_of(self, slot: int | None) -> float | None:
        """K of the design spring of the wall that was touched, N·m/rad."""
        if slot is None or self._predicted is None or self._fits[slot]["spring"] == 0.0:
            return self._predicted
        return float(self._fits[slot]["spring"])

    def _hold(self) -> tuple[float | None, float | None, float | None, float | None]:
        """Offset in rad, offset over depth, mean torque, and its RMS about that."""
        run = self._runs[0]
        n = int(run["hold_ticks"])
        if n == 0 or run["hold_contact"] < n or not self._predicted:
            return None, None, None, None
        offset, depth = run["hold_offset"] / n, run["hold_depth"] / n
        mean = run["hold_sum"] / n
        ripple = math.sqrt(max(run["hold_square"] / n - mean**2, 0.0))
        return offset, offset / depth if depth else None, run["hold_first"] + mean, ripple

    def _swing(self) -> tuple[float | None, float | None]:
        """Amplitude in rad and frequency in Hz of a hold's swing."""
        run = self._runs[0]
        n = int(run["hold_ticks"]) - 1
        if n < LEAST_TICKS:
            return None, None
        # About the straight line of least squares, whose middle is at the number (n + 1)/2.
        middle, square = 0.5 * (n + 1), (n * n - 1.0) / 12.0 * n
        moment = run["swing_moment"] - middle * run["swing_sum"]
        swing = run["swing_square"] - run["swing_sum"] ** 2 / n - moment**2 / square
        pull = run["pull_product"] - run["swing_sum"] * run["pull_sum"] / n
        pull -= moment * (run["pull_moment"] - middle * run["pull_sum"]) / square
        if swing <= 0.0:
            return 0.0, None
        hertz = math.sqrt(-pull / self._tick_s / swing) / (2.0 * math.pi) if pull < 0.0 else None
        return math.sqrt(2.0 * swing / n), hertz

    def _contact_energy(self) -> tuple[float | None, float | None]:
        """Largest energy that a contact delivered, J, and largest over what its spring held."""
        run = self._runs[0].copy()
        if run["account"]:
            run["account_j"] += run["account_held_j"]
            _close_account.py_func(run)
        if not run["accounts"]:
            return None, None
        return run["contact_j"], run["contact_ratio"] if self._predicted else None

    def result(
        self, *, wall_clock_s: float | None = None, clock_cycles: int | None = None
    ) -> dict[str, Any]:
        """All metrics by name, SI units, plain Python numbers, text or None.

        ``wall_clock_s`` is the time that the run took, ``clock_cycles`` the clocks simulated (None
        for a controller without a clock). May be called at any time; the run can go on.

        ============================  ==========================================================
        ``scene``, ``controller``     names
        ``hand``                      path of the scene's hand
        ``duration_s``                simulated time
        ``wall_clock_s``              as given
        ``ticks``
        ``clock_cycles``              as given
        ``k_l``                       K_L of the motor, N·m/rad
        ``stiffness``                 measured, N·m/rad: see the head of the module
        ``stiffness_zero_rad``        where the fitted line crosses zero torque
        ``contact_edge_rad``          x_w of the first contact
        ``stiffness_predicted``       of the wall of the first contact; as given without one
        ``tip_stiffness``             ``stiffness`` · (ratio/lever)², N/m, with a transmission
        ``peak_torque``               largest magnitude in the run, N·m
        ``peak_current_a``            largest magnitude of a tick's mean in the run
        ``current_ripple_a``          median over the ticks of the ripple, peak to peak
        ``torque_nrmse_vs_analog``    RMS of the difference over the reference's largest magnitude
        ``free_space_torque_rms``     over all ticks out of contact, N·m
        ``energy_out_max_j``          the most that the running sum of ENERGY_OUT has reached; 0 if
                                      it never rose above zero
        ``hold_offset_rad``           mean of F/K + x − x_w with the design spring's K: how far the
                                      wall has moved, towards larger x if above zero
        ``hold_error``                that over the mean of x − x_w
        ``hold_torque``               mean of F, N·m
        ``hold_ripple_rms``           RMS of the torque about its mean, N·m; a drift counts
        ``contact_energy_j``          the most energy that a contact delivered to the shaft: see the
                                      head of the module; None without a contact
        ``contact_energy_ratio``      the largest of these over the most that the contact's spring
                                      held
        ``swing_rad``, ``swing_hz``   amplitude and frequency of the rotor in the last tenth of a
                                      ``press``
        ``restitution``               mean speed in the first tick after the first contact over that
                                      in the last tick before it
        ``saturated_fraction``        of all ticks
        ``clipped_fraction``          of all ticks: those with a sample, a current or a wave v at
                                      the end of its range
        ``correction_out_max_j``      most net work of c less what it cancels: see the module's head
        ``correction_bound_j``        what that can't exceed; None with ``[winding]``, whose flux is
                                      not L·i, and where magnets warm
        ``x_hat_error_rms_rad``       of x̂ against x at the ticks' ends
        ``omega_hat_error_rms``       of ω̂ against the tick's mean ω, rad/s
        ``anchor_fault_s``            time at which the anchor gave up, or None
        ``reasons``                   by metric: why it is None though the scene defines it, or what
                                      was left out of it
        ============================  ==========================================================

        The four of a hold need the path ``press`` and contact in every one of the last tenth of
        the scene's ticks. ``restitution`` needs the path ``impact``, an entry after the first tick
        and a rotor that came back: it is None where the rotor went through the wall or stayed in
        it. A contact shorter than ``LEAST_TICKS`` that did not turn the rotor round is passed over.
        Those of the correction and of the anchor need a port anchor. ``stiffness`` speaks in
        ``reasons`` for all that are made of it, ``hold_error`` for the four of a hold.
        """
        scene, run = self._scene, self._runs[0]
        ticks = int(run["ticks"])
        slot = self._first_contact()
        reasons: dict[str, str] = {}
        slope, zero, said = self._stiffness(slot)
        if said is not None:
            reasons["stiffness"] = said
        tip = None
        arm = scene.transmission
        if slope is not None and arm is not None and arm.ratio and arm.lever_m:
            tip = slope * (arm.ratio / arm.lever_m) ** 2
        error = None
        if self._has_reference and run["reference_peak"] > 0.0:
            error = math.sqrt(run["error_square"] / ticks) / run["reference_peak"]
            if (lost := self._lost_reference()) is not None:
                error, reasons["torque_nrmse_vs_analog"] = None, lost
        free = None
        if run["free_ticks"]:
            free = math.sqrt(run["free_square"] / run["free_ticks"])
        offset, offset_part, held, ripple = self._hold()
        delivered, delivered_part = self._contact_energy()
        swing, swing_hz = self._swing()
        if held is None and run["hold_ticks"]:
            reasons["hold_error"] = "the rotor isn't in contact in all of the last tenth"
        if run["impact"] and run["bounce"] != _KNOWN and ticks:
            reasons["restitution"] = (
                "the rotor went through the wall or stayed in it"
                if run["contacts"] else "the rotor never came into a wall"
            )  # fmt: skip
        metrics: dict[str, Any] = {
            "scene": scene.scene.name,
            "controller": self._controller,
            "hand": None if scene.hand is None else scene.hand.path,
            "duration_s": round(ticks * self._tick_s, 12),  # 0.1, not 0.09999999999999999
            "wall_clock_s": wall_clock_s,
            "ticks": ticks,
            "tick_hz": float(f"{1.0 / self._tick_s:.9g}"),
            "clock_cycles": clock_cycles,
            "k_l": closed_forms.k_l(scene.motor.felt_k_t, scene.motor.L_h),
            "stiffness": slope,
            "stiffness_zero_rad": zero,
            "contact_edge_rad": None if slot is None else self._fits[slot]["edge"],
            "stiffness_predicted": self._predicted_of(slot),
            "tip_stiffness": tip,
            "peak_torque": run["torque_peak"] if ticks else None,
            "peak_current_a": run["current_peak"] if ticks else None,
            "current_ripple_a": self._ripple_median(),
            "torque_nrmse_vs_analog": error,
            "free_space_torque_rms": free,
            "energy_out_max_j": run["energy_peak"] if ticks else None,
            "hold_offset_rad": offset,
            "hold_error": offset_part,
            "hold_torque": held,
            "hold_ripple_rms": ripple,
            "contact_energy_j": delivered,
            "contact_energy_ratio": delivered_part,
            "swing_rad": swing,
            "swing_hz": swing_hz,
            "restitution": run["restitution"] if run["bounce"] == _KNOWN else None,
            "saturated_fraction": run["saturated"] / ticks if ticks else None,
            "clipped_fraction": run["clipped"] / ticks if ticks else None,
        }
        metrics |= self._correction()
        if run["anchored"] and ticks and scene.winding is not None:
            reasons["correction_bound_j"] = "the flux of [winding] isn't L·i"
        metrics["reasons"] = reasons
        return {name: _plain(value) for name, value in metrics.items()}

    def _lost_reference(self) -> str | None:
        """Why the reference isn't the wall that was asked for; None where it is.

        Beside a controller that holds its wall by the encoder stands a circuit that doesn't. That
        loses the wall where R̂ isn't the motor's R, or where the motor has brushes.
        """
        run, scene = self._runs[0], self._scene
        judged = run["reference_spring"] > 0.0 and run["reference_ticks"]
        if not judged or scene.controller.eta_contact > -1.0:
            return None
        lack = run["reference_lack"] / run["reference_ticks"] / run["reference_peak"]
        if abs(lack) <= LOST_REFERENCE:
            return None
        drive = scene.drive
        estimate = scene.controller.r_hat * (1.0 if drive is None else drive.gain)
        off = 100.0 * (estimate / scene.motor.R_ohm - 1.0)
        cause = f" (R̂ with the drive's gain is {off:+.2g} % off R)" if abs(off) > 1e-4 else ""
        return f"the analog circuit has no port anchor and loses this wall{cause}"

    def _correction(self) -> dict[str, Any]:
        run = self._runs[0]
        ticks = int(run["ticks"])
        names = ("correction_out_max_j", "correction_bound_j", "x_hat_error_rms_rad",
                 "omega_hat_error_rms", "anchor_fault_s")  # fmt: skip
        if not (run["anchored"] and ticks):
            return dict.fromkeys(names)
        # Its flux is not L i + k_T x.
        otherwise = self._scene.winding is not None or bool(run["warm"])
        values = (
            run["work_peak"],
            None if otherwise else run["bound"] + _part_bound.py_func(run),
            math.sqrt(run["x_hat_square"] / ticks),
            math.sqrt(run["omega_hat_square"] / ticks),
            run["fault_s"] if run["fault_s"] >= 0.0 else None,
        )
        return dict(zip(names, values, strict=True))


def _plain(value: Any) -> Any:
    """``value`` as JSON knows it: numpy numbers become Python's, what is not finite None."""
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
