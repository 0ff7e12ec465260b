"""One plan, many sets of numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nospill.certification.verdict import limit_use
from nospill.certification.wording import finding
from nospill.core.blas_threads import one_blas_thread
from nospill.errors import ScenarioError
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import EvaluationPoint, Role
from nospill.laws.constraints.lift import Lift
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slip import Slip
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.constraints.tip import Tip
from nospill.laws.constraints.twist import Twist
from nospill.margins.arms import ArmRanges, draw_arms, draws_arms
from nospill.margins.drawn_object import drawn_object
from nospill.margins.laws import Margins, TrayMotion, object_margins, simulate_arms, tray_motion
from nospill.margins.ranges import FACTORS, Ranges, draw, scenario_ranges
from nospill.margins.report import ConstraintRisk, Influence, MarginsReport, probability
from nospill.plans.plan import Plan
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.scene.tolerances import require_valid_fill

LARGEST_SAMPLES = 1_000_000

MEASURES = {
    role.value: tuple(
        item.name for item in CONSTRAINTS if item.role is role and item.evaluated_at is EvaluationPoint.OBJECT
    )
    for role in (Role.LIQUID, Role.CONTACT)
}
"""What the influence of a number is measured on: the worst margin over these constraints during the motion."""

_NOTHING = 1e-9
"""Of a limit; what moves a margin by less moves it by rounding."""

_SWEEP = 9
"""Places along a range at which its number is tried."""

_BATCH = 16
"""Samples that are played together where the tray moves alike in all of them: the least processor time of 4 to 100."""

ObjectCallback = Callable[[int, int], None]
"""Called with how many of how many samples are done."""


@dataclass(frozen=True, slots=True)
class _Found:
    """Figures of one object in m samples.

    Attributes:
        name: of the object.
        use: of the limit, (m,), by constraint.
        value: limit less margin, in the constraint's unit, (m,), by constraint.
        points: where each constraint is evaluated.
        freeboard: distance from the liquid at rest to the rim, (m,), m; None without an open liquid.
    """

    name: str
    use: dict[str, np.ndarray]
    value: dict[str, np.ndarray]
    points: dict[str, EvaluationPoint]
    freeboard: np.ndarray | None


@one_blas_thread()
def margins(
    plan: Plan,
    *,
    ranges: Ranges | Sequence[Ranges] | None = None,
    arm: ArmRanges | None = None,
    samples: int = 1000,
    seed: int = 0,
    progress: ObjectCallback | None = None,
) -> MarginsReport:
    """Draw friction, fill, damping, position and mass of every object and see what is left of the plan's margins.

    The joints, and so the tray, move as planned in every sample, unless delay and lag of the arm are drawn too: then
    every sample has an arm of its own, which plays the plan's command. The laws are those of the scene's fidelity.

    Args:
        plan: certified or not.
        ranges: how far the numbers may be off, of all objects alike or of each; what the scenario states when left
            out (`scenario_ranges`).
        arm: how far delay and lag of the joints may be off; when left out the band that the scenario states, if any.
        samples: how many sets of numbers, 1 to 1,000,000.
        seed: of the draw; the same seed gives the same figures.
        progress: called after each batch.

    Raises:
        ScenarioError: a number of samples that is not allowed, an empty tray, a constraint that is not at hand, or a
            range that empties a cup or fills it over its rim.
        ModelError: the slosh model does not cover a drawn filling.
    """
    if not 1 <= samples <= LARGEST_SAMPLES:
        raise ScenarioError(f"samples = {samples}: 1 to {LARGEST_SAMPLES} are allowed")
    if seed < 0:
        raise ScenarioError(f"seed = {seed}: a whole number of at least 0 is needed")
    scene = plan.scene
    if not scene.cargo:
        raise ScenarioError(f"{scene.name}: nothing stands on the tray, so no number of an object can be off")
    if scene.unjudged:
        raise ScenarioError(f"the margins of this plan cannot be studied: {finding(plan.certificate)}")
    used = _for_each(scene, ranges)
    for cargo, own in zip(scene.cargo, used, strict=True):
        require_valid_fill(cargo, own.fill, key="range of fill")
        _require_known_swing(cargo, own)
    draws = draw(used, samples, seed=seed)
    swept, labels = _sweeps(used)
    changed = []
    for index, cargo in enumerate(scene.cargo):
        own = np.vstack([draws[:, index], swept[:, index], np.zeros((1, len(FACTORS)))])
        changed.append([drawn_object(cargo, item, scene) for item in own])
    total = samples + len(labels) + 1
    parts, done = [], 0
    for motion, part in _motions(plan, arm, samples, total, seed):
        parts.append(object_margins(scene, [own[part] for own in changed], motion))
        done += len(range(*part.indices(total)))
        if progress is not None:
            progress(done, total)
    every = [
        _figures(cargo.name, own, objects)
        for cargo, own, objects in zip(scene.cargo, zip(*parts, strict=True), changed, strict=True)
    ]
    all_margins = [item for item in every if item.use]
    if not all_margins:
        raise ScenarioError(f"{scene.name}: no object has a limit, as all are fixed; there are no margins to study")
    drawn = slice(0, samples)
    worst = 1.0 - np.max([use for item in all_margins for use in _during(item).values()], axis=0)
    return MarginsReport(
        scenario=scene.name,
        ranges={cargo.name: own for cargo, own in zip(scene.cargo, used, strict=True)},
        samples=samples,
        seed=seed,
        arm=arm or ArmRanges(),
        arms=samples if draws_arms(plan.scene, arm) else 0,
        nominal=float(worst[-1]),
        worst_margin=worst[drawn],
        draws=draws,
        spill=probability(np.any([_spilt(item) for item in all_margins], axis=0)[drawn]),
        over_limit=probability(_breaks(all_margins, (SloshHeight.name,))[drawn]),
        slide=probability(_breaks(all_margins, (Slip.name, Twist.name, Lift.name))[drawn]),
        tip=probability(_breaks(all_margins, (Tip.name,))[drawn]),
        any_limit=probability(
            _breaks(all_margins, tuple({name: None for item in all_margins for name in item.use}))[drawn]
        ),
        constraints=_risks(all_margins, drawn),
        influences=_influences(all_margins, labels, samples),
    )


def _require_known_swing(cargo: Cargo, ranges: Ranges) -> None:
    """Refuse draws of a liquid that begins with a swing: that of one with other numbers is not in the plan."""
    swings = cargo.filling is not None and cargo.filling.initial_swing is not None
    if swings and (ranges.fill or ranges.position or ranges.damping != (1.0, 1.0)):
        raise ScenarioError(
            f'cargo "{cargo.name}" begins with the swing that a motion before has left, which is another one where its '
            "fill, damping or place is off; draw the other numbers alone: --fill 0 --damping 1..1 --position 0"
        )


def _motions(
    plan: Plan, ranges: ArmRanges | None, samples: int, total: int, seed: int
) -> Iterator[tuple[TrayMotion, slice]]:
    """Motions of the tray and which sets of numbers are played along each.

    Of drawn arms every sample has one of its own, so that samples are independent of each other; the sets after them
    are played as planned, with as much rest at the end.
    """
    after, first = 0.0, 0
    if draws_arms(plan.scene, ranges):
        arms, after = draw_arms(plan.scene, ranges, samples, seed=seed)
        for first, motion in enumerate(simulate_arms(plan.trajectory, plan.scene, arms, after=after)):
            yield motion, slice(first, first + 1)
        first = samples
    planned = tray_motion(plan.trajectory, plan.scene, after=after)
    for begin in range(first, total, _BATCH):
        yield planned, slice(begin, min(begin + _BATCH, total))


def _figures(name: str, parts: Sequence[Margins], objects: Sequence[Cargo]) -> _Found:
    """What was found of one object in all samples, of which each part holds some."""
    constraints = parts[0].constraints
    margin, limit = (np.vstack([getattr(part, field) for part in parts]) for field in ("margin", "limit"))
    freeboards = [
        item.container.height - item.filling.liquid_height for item in objects if item.filling and not item.filling.lid
    ]
    return _Found(
        name=name,
        use={own.name: limit_use(own, limit[:, k], margin[:, k]) for k, own in enumerate(constraints)},
        value={own.name: limit[:, k] - margin[:, k] for k, own in enumerate(constraints)},
        points={own.name: own.evaluated_at for own in constraints},
        freeboard=np.array(freeboards) if freeboards else None,
    )


def _during(item: _Found) -> dict[str, np.ndarray]:
    return {name: use for name, use in item.use.items() if item.points[name] is EvaluationPoint.OBJECT}


def _spilt(item: _Found) -> np.ndarray:
    if item.freeboard is None:
        return np.zeros(len(next(iter(item.use.values()))), dtype=bool)
    return np.maximum(item.value[SloshHeight.name], item.value[ResidualHeight.name]) > item.freeboard


def _breaks(found: list[_Found], names: tuple[str, ...]) -> np.ndarray:
    """Where any object breaks one of these constraints, (m,)."""
    count = len(next(iter(found[0].use.values())))
    columns = [item.use[name] > 1.0 for item in found for name in names if name in item.use]
    return np.any(columns, axis=0) if columns else np.zeros(count, dtype=bool)


def _risks(found: list[_Found], drawn: slice) -> tuple[ConstraintRisk, ...]:
    names = {name: None for item in found for name in item.use}
    risks = []
    for name in names:
        owners = [(float(np.max(item.use[name][drawn])), item.name) for item in found if name in item.use]
        largest, subject = max(owners)
        risks.append(ConstraintRisk(name, probability(_breaks(found, (name,))[drawn]), largest, subject))
    return tuple(risks)


def _for_each(scene: Scene, ranges: Ranges | Sequence[Ranges] | None) -> tuple[Ranges, ...]:
    if ranges is None:
        return scenario_ranges(scene)
    found = (ranges,) * len(scene.cargo) if isinstance(ranges, Ranges) else tuple(ranges)
    if len(found) != len(scene.cargo):
        raise ScenarioError(f"ranges: {len(found)} are given, {len(scene.cargo)} are needed, one for each object")
    return found


def _sweeps(ranges: Sequence[Ranges]) -> tuple[np.ndarray, list[tuple[str, str]]]:
    """Draws with one number off, (n, objects, 6), and of each the number's name and its value as text.

    A number is moved on all objects together, each over its own range.
    """
    low, high = (np.array(ends) for ends in zip(*(item.bounds() for item in ranges), strict=True))
    rows, labels = [], []
    for column, factor in enumerate(FACTORS):
        if factor.startswith("position"):
            continue
        for share in np.linspace(0.0, 1.0, _SWEEP).tolist():
            row = np.zeros(low.shape)
            row[:, column] = low[:, column] + share * (high[:, column] - low[:, column])
            rows.append(row)
            labels.append(
                (factor, _common(row[:, column], share, lambda value, factor=factor: _range_text(factor, value)))
            )
    x, y = FACTORS.index("position x"), FACTORS.index("position y")
    for right in (-1, 0, 1):
        for forward in (-1, 0, 1):
            row = np.zeros(low.shape)
            row[:, x], row[:, y] = right * high[:, x], forward * high[:, y]
            rows.append(row)
            place = f"({right:+d}, {forward:+d}) of the range"
            if np.ptp(high[:, x]) == 0.0:
                place = f"({1e3 * row[0, x]:+.3g}, {1e3 * row[0, y]:+.3g}) mm"
            labels.append(("position", place))
    return np.array(rows), labels


def _common(values: np.ndarray, share: float, written: Callable[[float], str]) -> str:
    """The value (objects,) as text if all objects share it, else its place in the range from 0 to 100 %."""
    alike = np.ptp(values) <= _NOTHING * np.max(np.abs(values))
    return written(float(values[0])) if alike else f"{100 * share:.3g} % of the range"


def _range_text(factor: str, value: float) -> str:
    if factor == "damping":
        return f"x {math.exp(value):.3g}"
    return f"{1e3 * value:+.3g} mm" if factor == "fill" else f"{1e2 * value:+.3g} %"


def _influences(figures: list[_Found], labels: list[tuple[str, str]], samples: int) -> tuple[Influence, ...]:
    influences, places = [], [*(place for _, place in labels), "as planned"]
    for measure, wanted in MEASURES.items():
        owned = [(item, name) for item in figures for name in wanted if name in item.use]
        if not owned:
            continue
        swept = 1.0 - np.array([item.use[name][samples:] for item, name in owned])
        worst = np.min(swept, axis=0)
        for factor in dict.fromkeys(name for name, _ in labels):
            # The scenario's own numbers are the last column.
            rows = [*(k for k, (name, _) in enumerate(labels) if name == factor), len(labels)]
            least, greatest = rows[int(np.argmin(worst[rows]))], rows[int(np.argmax(worst[rows]))]
            limiting, constraint = owned[int(np.argmin(swept[:, least]))]
            influence = Influence(
                factor=factor,
                measure=measure,
                nominal=float(worst[-1]),
                least=float(worst[least]),
                greatest=float(worst[greatest]),
                least_at=places[least],
                greatest_at=places[greatest],
                limited_by=f"{constraint} of {limiting.name}",
            )
            if influence.swing > _NOTHING:
                influences.append(influence)
    return tuple(sorted(influences, key=lambda item: -item.swing))
