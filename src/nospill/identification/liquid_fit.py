"""Fill, damping, clock and gauge of a cup, from the motion of the tray and the measured height of its liquid."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nospill.identification.estimates import Estimate, Fit, Residuals, fitted, profile_ends
from nospill.identification.liquid_law import FILL_STEP, NUMBERS, STEP, LiquidLaw
from nospill.motion.interpolation import JointMotion
from nospill.scene.scene import Scene
from nospill.simulation.compare import compare
from nospill.simulation.motion_file import Heights

_SIGNED = 0.3
"""A record that falls below rest by more than this part of its highest value has signs: a crest has none."""
_FILL, _DAMPING = 0.3, np.log(30.0)
"""Part of the stated fill, and logarithm of the factor, by which the fit may leave what is stated."""
IDENTIFIABLE = {"clock": 0.01, "fill": 3e-3, "damping": 0.5, "frequency": 0.5, "gauge": 2e-3}
"""Half widths of 95 % above which a number is not told: s, m, part of the value, rad/s, m."""
_NEIGHBOURS = 6


@dataclass(frozen=True, slots=True, eq=False)
class LiquidFit:
    """What the measured height of a cup tells.

    Attributes:
        subject: the cup.
        estimates: clock (s, to be added to the clock of the motion), fill (m), damping (ratio of the first mode),
            frequency (of the first mode at this fill, rad/s), gauge (m, what the gauge shows at rest).
        stated: (fill, damping ratio) of the scenario.
        left: root mean square of what is left, m.
    """

    subject: str
    estimates: tuple[Estimate, ...]
    stated: tuple[float, float]
    left: float

    def of(self, name: str) -> Estimate:
        """One estimate by its name."""
        return next(own for own in self.estimates if own.name == name)


def fit_liquid(
    motion: JointMotion, scene: Scene, subject: str, measured: Heights, *, begin: float, end: float
) -> LiquidFit:
    """Fit the law of a liquid to a measured height.

    The measured height is that of the crest. A record with signs counts without them: a crest has none. What the
    motion does not tell stays as stated, and the rest is fitted again.

    Args:
        motion: of the joints, at rest before `begin` and after `end`, s.
        scene: with the cup.
        subject: its name.
        measured: its height, from rest on.
        begin: of the motion, s.
        end: likewise.

    Raises:
        ScenarioError: the height never changes.
        ModelError: the liquid leaves its cup.
    """
    cargo = next(item for item in scene.cargo if item.name == subject)
    assert cargo.filling is not None  # checked with the measured heights
    first = cargo.filling.modes.slowest
    length = float(measured.t[-1] - measured.t[0])
    law = LiquidLaw(motion, replace(scene, cargo=(cargo,)), begin, end + max(length - (end - begin), 0.5) + 0.5)
    stated = law.heights(0.0, 0.0)
    aligned = compare(_from_rest(law.t, stated, max(length - (end - begin), 0.5)), measured)
    fill = cargo.filling.liquid_height
    signed = np.min(measured.height) < -_SIGNED * np.max(measured.height)
    height = np.abs(measured.height) if signed else measured.height

    def residuals(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        clock, rise, damping, gauge = values
        fit, slopes = law.with_slopes(rise, damping, measured.t - clock)
        return fit + gauge - height, slopes

    lower = np.array([aligned.shift - 0.1, -_FILL * fill, -_DAMPING, -0.01])
    upper = np.array([aligned.shift + 0.1, min(_FILL * fill, cargo.container.height - fill - 1e-4), _DAMPING, 0.01])
    free = np.ones(4, dtype=bool)
    start = np.array([aligned.shift, 0.0, 0.0, 0.0])
    while True:
        fit = _with_held(residuals, start, lower, upper, free)
        estimates = _estimates(subject, fit, free, law, fill, first.damping)
        unidentifiable = [
            _PLACES[estimate.name] for estimate in estimates if estimate.name in _STATED and not estimate.identifiable
        ]
        unidentifiable = [place for place in unidentifiable if free[place]]
        if not unidentifiable:
            ends = _profiles(_of_free(residuals, start, free), fit, lower, upper, free)
            stated_now = fill, first.damping
            return LiquidFit(
                subject, tuple(_with_ends(estimate, ends, stated_now) for estimate in estimates), stated_now, fit.left
            )
        free[unidentifiable[0]] = False


_PLACES = {name: place for place, name in enumerate(NUMBERS)}
_STATED = ("fill", "damping")
"""What the scenario states, and what may stay so; in the order in which it is given up."""
_SCALE = np.array([1e-2, 1e-3, 0.3, 1e-3])


def _of_free(residuals: Residuals, start: np.ndarray, free: np.ndarray) -> Residuals:
    """The residuals by the free values, the others as at the start."""

    def of_free(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        whole = start.copy()
        whole[free] = values
        left, slopes = residuals(whole)
        return left, slopes[:, free]

    return of_free


def _with_held(residuals: Residuals, start: np.ndarray, lower: np.ndarray, upper: np.ndarray, free: np.ndarray) -> Fit:
    """The fit of the free values, the others as at the start, with infinite variance."""
    own = _of_free(residuals, start, free)
    found = fitted(own, start[free], _SCALE[free], lower[free], upper[free], neighbours=_NEIGHBOURS)
    values, covariance, alone = start.copy(), np.diag(np.full(len(start), np.inf)), np.full(len(start), np.inf)
    values[free], alone[free] = found.values, found.alone
    covariance[np.ix_(free, free)] = found.covariance
    return Fit(values, covariance, found.left, alone)


def _profiles(
    residuals: Residuals, fit: Fit, lower: np.ndarray, upper: np.ndarray, free: np.ndarray
) -> dict[str, tuple[float, float]]:
    """Ends of the intervals of what the scenario states, where the likelihood is not quadratic."""
    free_fit = Fit(fit.values[free], fit.covariance[np.ix_(free, free)], fit.left, fit.alone[free])
    ends = {}
    for name in _STATED:
        if free[_PLACES[name]]:
            place = int(np.sum(free[: _PLACES[name]]))
            ends[name] = profile_ends(residuals, free_fit, place, lower[free], upper[free])
    return {name: fit for name, fit in ends.items() if fit is not None}


def _with_ends(own: Estimate, ends: dict[str, tuple[float, float]], stated: tuple[float, float]) -> Estimate:
    """An estimate with the ends of its interval, from those of the values that are fitted."""
    if own.name not in ends:
        return own
    low, high = ends[own.name]
    fill, damping = stated
    if own.name == "fill":
        return replace(own, ends=(fill + low, fill + high))
    return replace(own, ends=(damping * float(np.exp(low)), damping * float(np.exp(high))))


def _estimates(
    subject: str, fit: Fit, free: np.ndarray, law: LiquidLaw, fill: float, stated: float
) -> tuple[Estimate, ...]:
    clock, rise, damping, gauge = (float(value) for value in fit.values)
    deviation = [float(value) for value in np.sqrt(np.diag(fit.covariance))]
    here = law.frequency(rise)
    slope = abs(law.frequency(rise + FILL_STEP) - here) / FILL_STEP
    ratio = stated * float(np.exp(damping))
    return (
        Estimate("clock", subject, "s", clock, deviation[0], IDENTIFIABLE["clock"]),
        Estimate("fill", subject, "m", fill + rise, deviation[1], IDENTIFIABLE["fill"]),
        Estimate("damping", subject, "1", ratio, ratio * deviation[2], IDENTIFIABLE["damping"] * ratio),
        Estimate("frequency", subject, "rad/s", here, slope * deviation[1], IDENTIFIABLE["frequency"]),
        Estimate("gauge", subject, "m", gauge, deviation[3], IDENTIFIABLE["gauge"]),
    )


def _from_rest(t: np.ndarray, height: np.ndarray, before: float) -> Heights:
    count = int(before / STEP)
    early = t[0] - STEP * np.arange(count, 0, -1)
    return Heights(np.concatenate([early, t]), np.concatenate([np.zeros(count), height]))
