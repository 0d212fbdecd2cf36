# SPDX-License-Identifier: Apache-2.0
"""The early duty as integers: what ``rtl/wh_early.v`` computes, in Python's own."""

from __future__ import annotations

from typing import NamedTuple

from wavehaptics.words import formats

_SA_Q = formats.DATA_W - 5
_SCALE_Q = formats.DATA_W + 3
_SLOPE_Q = formats.DATA_W + 2
_DUTY_W = formats.DATA_W + formats.COEF_W - formats.VOLTAGE.fraction


class Early(NamedTuple):
    """What is ready before the tick's last word: ``base − slope·(sum − zero)``, in limits.

    ``slope`` has DATA_W + 2 fraction bits, clocks per unit of the sum; ``base``, ``low``, ``high``
    and ``still``, the duty of v = 0, are in 2⁻¹⁶ clocks of half width. ``back`` is η < 0.
    """

    base: int
    slope: int
    low: int
    high: int
    still: int
    back: bool

    def duty(self, total: int, ends: int = 0) -> int:
        """Half width in 2⁻¹⁶ clocks for a tick's sum less its zero, with words at these ends."""
        wide = self.base - (self.slope * total >> _SLOPE_Q - formats.DUTY.fraction)
        above, below = formats.AT_HIGH, formats.AT_LOW
        if self.back:
            above, below = below, above
        high = self.still if ends & above else self.high
        low = self.still if ends & below else self.low
        return high if wide >= high else max(wide, low)


def _limited(value: int, shift: int, width: int) -> int:
    """``value`` without its last ``shift`` bits, rounded down, and limited to a word."""
    top = 1 << (width - 1)
    return min(max(value >> shift, -top), top - 1)


def prepare(
    f: int, u_n: int, u_max: int, root: int, a: int, gain: int, clocks_per_volt: int, eta: int,
    wave: int, offset: int = 0, correction: int = 0,
) -> Early:  # fmt: skip
    """The words of one tick, from those that ``rtl/wh_early.v`` names so."""
    data, coef = formats.DATA_W, formats.COEF_W
    root_q, eta_q = formats.ROOT.fraction, formats.ETA.fraction
    sa = _limited(root * a, root_q + formats.A.fraction - _SA_Q, data)
    sa_cut = _limited(root * a, formats.A.fraction, coef)
    drop_q = root_q + formats.CURRENT.fraction - formats.WAVE.fraction
    u_n = _limited(u_n + _limited(offset * root, drop_q, data), 0, data)
    f_volt = _limited(f * root, root_q, data)

    def volt(error: int) -> int:
        made = f_volt + _limited(_limited(error, 0, data) * sa_cut, root_q, data)
        return _limited(made, 0, data) * clocks_per_volt >> formats.VOLTAGE.fraction

    scale = _limited(
        gain * clocks_per_volt, formats.GAIN.fraction + formats.DUTY.fraction - _SCALE_Q, data
    )
    scale_s = _limited(scale * root, _SCALE_Q + root_q - _SLOPE_Q, data)
    sae = _limited(sa * eta, _SA_Q + eta_q - root_q, coef)
    limit_v = _limited(u_max * root, root_q, data)
    limit = limit_v * clocks_per_volt >> formats.VOLTAGE.fraction
    added = correction * clocks_per_volt >> formats.VOLTAGE.fraction
    still = min(max(volt(wave - f), -limit), limit)
    return Early(
        base=volt(_limited(u_n * eta, eta_q, data) + wave - f) + added,
        slope=_limited(scale_s * sae, root_q, data),
        low=_limited(added - limit, 0, _DUTY_W),
        high=_limited(added + limit, 0, _DUTY_W),
        still=_limited(added + still, 0, _DUTY_W),
        back=eta < 0,
    )


def slope_fits(root: int, gain: int, clocks_per_volt: int) -> bool:
    """Whether the stiffest slope, η = ±1 and a = 1, stays within the RTL's words."""
    top = (1 << (formats.DATA_W - 1)) - 1
    scale = gain * clocks_per_volt >> (formats.GAIN.fraction + formats.DUTY.fraction - _SCALE_Q)
    scale_s = scale * root >> (_SCALE_Q + formats.ROOT.fraction - _SLOPE_Q)
    return max(scale, scale_s, scale_s * root >> formats.ROOT.fraction) <= top
