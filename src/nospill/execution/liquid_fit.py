"""Fill, damping, clock and gauge of a cup, from the motion of the tray and the measured height of its liquid."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nospill.core.batches import evaluate
from nospill.errors import ModelError
from nospill.execution.estimates import Estimate, Fit, Residuals, fitted, profile_ends
from nospill.judge.replay import liquid_step, tray_from_joints
from nospill.judge.traces import object_figures_function
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.kinds import numbers_of_object, object_kind
from nospill.laws.parameters import flatten
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.integrate import integrate
from nospill.motion.interpolation import JointMotion
from nospill.scene.cargo import Cargo
from nospill.scene.perturbation import Perturbation, perturbed
from nospill.scene.scene import Scene
from nospill.simulation.compare import compare
from nospill.simulation.motion_file import Heights

_STEP = 0.004
"""s; of the integration, some sixty to a swing."""
_SIGNED = 0.3
"""A record that falls below rest by more than this part of its highest value has signs: a crest has none."""
_FILL_STEP, _DAMPING_STEP = 2e-4, 0.02
"""m, and logarithm of the factor; of the differences that give the derivatives by fill and damping."""
_FILL, _DAMPING = 0.3, np.log(30.0)
"""Part of the stated fill, and logarithm of the factor, by which the fit may leave what is stated."""
_TOLD = {"clock": 0.01, "fill": 3e-3, "damping": 0.5, "frequency": 0.5, "gauge": 2e-3}
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
    first = min(cargo.filling.modes.oscillators, key=lambda mode: mode.frequency)
    length = float(measured.t[-1] - measured.t[0])
    law = _Law(motion, replace(scene, cargo=(cargo,)), begin, end + max(length - (end - begin), 0.5) + 0.5)
    stated = law.heights(0.0, 0.0)
    aligned = compare(_from_rest(law.t, stated, max(length - (end - begin), 0.5)), measured)
    fill = cargo.filling.liquid_height
    signed = np.min(measured.height) < -_SIGNED * np.max(measured.height)
    height = np.abs(measured.height) if signed else measured.height

    def residuals(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        clock, rise, damping, gauge = values
        here = law.heights(rise, damping)
        by_fill = (law.heights(rise + _FILL_STEP, damping) - here) / _FILL_STEP
        by_damping = (law.heights(rise, damping + _DAMPING_STEP) - here) / _DAMPING_STEP
        speed = np.gradient(here, law.t)
        t = measured.t - clock
        found, speed, by_fill, by_damping = (
            np.interp(t, law.t, column, left=0.0) for column in (here, speed, by_fill, by_damping)
        )
        return found + gauge - height, np.column_stack([-speed, by_fill, by_damping, np.ones(len(t))])

    lower = np.array([aligned.shift - 0.1, -_FILL * fill, -_DAMPING, -0.01])
    upper = np.array([aligned.shift + 0.1, min(_FILL * fill, cargo.container.height - fill - 1e-4), _DAMPING, 0.01])
    free = np.ones(4, dtype=bool)
    start = np.array([aligned.shift, 0.0, 0.0, 0.0])
    while True:
        found = _with_held(residuals, start, lower, upper, free)
        estimates = _estimates(subject, found, free, law, fill, first.damping)
        untold = [_PLACES[own.name] for own in estimates if own.name in _STATED and not own.told]
        untold = [place for place in untold if free[place]]
        if not untold:
            ends = _profiles(_of_free(residuals, start, free), found, lower, upper, free)
            stated_now = fill, first.damping
            return LiquidFit(
                subject, tuple(_with_ends(own, ends, stated_now) for own in estimates), stated_now, found.left
            )
        free[untold[0]] = False


_PLACES = {"clock": 0, "fill": 1, "damping": 2, "gauge": 3}
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
    residuals: Residuals, found: Fit, lower: np.ndarray, upper: np.ndarray, free: np.ndarray
) -> dict[str, tuple[float, float]]:
    """Ends of the intervals of what the scenario states, where the likelihood is not quadratic."""
    own = Fit(found.values[free], found.covariance[np.ix_(free, free)], found.left, found.alone[free])
    ends = {}
    for name in _STATED:
        if free[_PLACES[name]]:
            place = int(np.sum(free[: _PLACES[name]]))
            ends[name] = profile_ends(residuals, own, place, _SCALE[free], lower[free], upper[free])
    return {name: found for name, found in ends.items() if found is not None}


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
    subject: str, found: Fit, free: np.ndarray, law: _Law, fill: float, stated: float
) -> tuple[Estimate, ...]:
    clock, rise, damping, gauge = (float(value) for value in found.values)
    deviation = [float(value) for value in np.sqrt(np.diag(found.covariance))]
    here = law.frequency(rise)
    slope = abs(law.frequency(rise + _FILL_STEP) - here) / _FILL_STEP
    ratio = stated * float(np.exp(damping))
    return (
        Estimate("clock", subject, "s", clock, deviation[0], _TOLD["clock"]),
        Estimate("fill", subject, "m", fill + rise, deviation[1], _TOLD["fill"]),
        Estimate("damping", subject, "1", ratio, ratio * deviation[2], _TOLD["damping"] * ratio),
        Estimate("frequency", subject, "rad/s", here, slope * deviation[1], _TOLD["frequency"]),
        Estimate("gauge", subject, "m", gauge, deviation[3], _TOLD["gauge"]),
    )


class _Law:
    """The height of one liquid along one motion, for any fill and damping."""

    def __init__(self, motion: JointMotion, scene: Scene, begin: float, stop: float) -> None:
        count = int(np.ceil((stop - begin) / _STEP))
        half = begin + 0.5 * _STEP * np.arange(2 * count + 1)
        _, self._body = tray_from_joints(scene, [motion(half, order) for order in range(3)])
        self._scene, self.t = scene, half[::2]
        structure = structure_of(scene)
        self._kind = object_kind(structure, structure.objects[0])
        self._step = liquid_step(self._kind)
        self._known: dict[tuple[float, float], np.ndarray] = {}

    def heights(self, rise: float, damping: float) -> np.ndarray:
        """Crest (m,) m at `t`, for a fill that is higher by `rise`, m, and exp(damping) times the damping."""
        key = rise, damping
        if key not in self._known:
            if len(self._known) > 8:
                self._known.clear()
            self._known[key] = self._integrated(rise, damping)
        return self._known[key]

    def frequency(self, rise: float) -> float:
        """Of the first mode, rad/s."""
        filling = self._cup(rise, 0.0).filling
        assert filling is not None
        return min(mode.frequency for mode in filling.modes.oscillators)

    def _cup(self, rise: float, damping: float) -> Cargo:
        by = Perturbation(liquid_height=rise, damping=float(np.exp(damping)))
        return perturbed(self._scene.cargo[0], by, fidelity=self._scene.fidelity)

    def _integrated(self, rise: float, damping: float) -> np.ndarray:
        scene = replace(self._scene, cargo=(self._cup(rise, damping),))
        own = np.asarray(flatten(numbers_of_object(numbers_of(scene), 0)))
        start = np.zeros(self._step.size1_in(0))
        states = integrate(
            self._step, start, inputs=self._body, lengths=np.full(len(self.t) - 1, _STEP), parameters=own
        ).T
        count = len(start) // 2
        function, names = object_figures_function(self._kind, EvaluationPoint.OBJECT)
        rows = evaluate(function, [self._body[:, ::2], states[:count], states[count:]], own)
        height = rows[3 * names.index(SloshHeight.name)]
        if not np.isfinite(height).all():
            raise ModelError(f"{scene.cargo[0].name}: the liquid leaves its cup along this motion")
        return height


def _from_rest(t: np.ndarray, height: np.ndarray, before: float) -> Heights:
    count = int(before / _STEP)
    early = t[0] - _STEP * np.arange(count, 0, -1)
    return Heights(np.concatenate([early, t]), np.concatenate([np.zeros(count), height]))
