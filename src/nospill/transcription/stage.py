"""One stage of the optimal control problem as expressions of its own variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import casadi as ca
import numpy as np

from nospill.core.frames import SX, frame_at_rest
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import EvaluationPoint, smooth_rows
from nospill.laws.contact import Wrench
from nospill.laws.parameters import SceneNumbers, Structure
from nospill.laws.sample import ObjectSample, Sample, object_motion, sample_objects, split_states
from nospill.laws.slosh.motion import motion_residual
from nospill.transcription.collocation import POINTS, advance_chain, gauss_step, interior
from nospill.transcription.joint_equalities import joint_equalities
from nospill.transcription.layout import IntegratorChain, Layout
from nospill.transcription.lifted_variables import LiftedVariables
from nospill.transcription.tray_state import tray_state


class RowIndex(NamedTuple):
    """A row of a structure, whose subjects have no names yet.

    Attributes:
        constraint: its name.
        subject: index of its subject.
    """

    constraint: str
    subject: int


@dataclass(frozen=True, slots=True)
class Block:
    """Rows of one constraint and one subject inside a stage.

    Attributes:
        constraint: its name.
        subject: index of its subject.
        first: index of the first row.
        count: number of rows.
        repetition: which point of the interval they stand at, 0 for the node.
    """

    constraint: str
    subject: int
    first: int
    count: int
    repetition: int

    @property
    def row(self) -> RowIndex:
        """Constraint and subject."""
        return RowIndex(self.constraint, self.subject)


class RowCollector:
    """Gathers smooth rows and remembers which constraint and subject each belongs to."""

    def __init__(self, backoff: Mapping[RowIndex, SX]) -> None:
        self._backoff = backoff
        self.values: list[SX] = []
        self.lower: list[np.ndarray] = []
        self.upper: list[np.ndarray] = []
        self.blocks: list[Block] = []
        self._count = 0

    def add(self, sample: Sample, points: tuple[EvaluationPoint, ...], repetition: int = 0) -> None:
        """Add every constraint of the given points."""
        for constraint in CONSTRAINTS:
            if constraint.evaluated_at not in points:
                continue
            for subject, budgets in enumerate(constraint.budgets(sample)):
                first = self._count
                for budget in budgets:
                    value, lower, upper = smooth_rows(budget, self._backoff[RowIndex(constraint.name, subject)])
                    self.values.append(value)
                    self.lower.append(lower)
                    self.upper.append(upper)
                    self._count += len(lower)
                self.blocks.append(Block(constraint.name, subject, first, self._count - first, repetition))

    def stacked(self) -> tuple[SX, np.ndarray, np.ndarray]:
        """All rows with their bounds."""
        if not self.values:
            return SX(0, 1), np.zeros(0), np.zeros(0)
        return ca.vertcat(*self.values), np.concatenate(self.lower), np.concatenate(self.upper)


@dataclass(frozen=True, slots=True)
class StageExpressions:
    """The pieces a transcription maps over the stages; they may read symbols of the lifted variables.

    Attributes:
        lifted: the lifted variables.
        following: (layout.states, 1) the next state, in physical units.
        equalities: zero on a solution; those of the liquids are divided by their scales, others in physical units.
        rows: of the constraints (see `smooth_rows`).
        lower: (m,) bounds of the rows.
        upper: likewise.
        blocks: which rows belong to what.
        cost: share of the stage, s.
    """

    lifted: LiftedVariables
    following: SX
    equalities: SX
    rows: SX
    lower: np.ndarray
    upper: np.ndarray
    blocks: tuple[Block, ...]
    cost: SX


def stage_expressions(
    structure: Structure,
    layout: Layout,
    numbers: SceneNumbers,
    stage: SX,
    *,
    scales: SX,
    backoff: Mapping[RowIndex, SX],
    intervals: SX,
) -> StageExpressions:
    """One stage: `stage` (layout.size, 1) in physical units, `scales` of the same shape."""
    chains = tuple(layout.chain(stage, index) for index in range(layout.chains))
    jerks = stage[layout.jerks]
    interval = stage[layout.interval]
    accelerations = (stage[layout.acceleration(0)], stage[layout.acceleration(1)])
    step = gauss_step(stage[layout.displacement], stage[layout.velocity], accelerations, interval)

    lifted = LiftedVariables()
    ends = _moved(chains, jerks, interval)
    following = ca.vertcat(*[ca.vertcat(*end) for end in ends], interval, step.end_displacement, step.end_velocity)

    collector = RowCollector(backoff)
    start = tray_state(structure, numbers, chains).lifted(lifted)
    equalities = [joint_equalities(structure, numbers, stage, layout, chains, start)]
    tilt = ca.vertcat(chains[1][0], chains[2][0]) if structure.tilt_free else None
    node = Sample(
        structure,
        numbers,
        joint_position=stage[layout.joint_position],
        joint_speed=stage[layout.joint_speed],
        joint_acceleration=stage[layout.joint_derivative(2)] if layout.orders > 1 else None,
        joint_jerk=stage[layout.joint_derivative(3)] if layout.orders > 2 else None,
        tilt=tilt,
        jerks=jerks,
    )
    collector.add(node, (EvaluationPoint.JOINT, EvaluationPoint.CONTROL))

    for point in range(2):
        moved = _lifted(_moved(chains, jerks, POINTS[point] * interval), lifted)
        tray = tray_state(structure, numbers, moved).lifted(lifted).motion
        position, velocity = lifted.lift(step.point_displacements[point]), lifted.lift(step.point_velocities[point])
        slosh = split_states(structure, position, velocity, accelerations[point])
        residuals = [
            motion_residual(
                oscillator,
                directions,
                object_motion(own, tray),
                state,
                damp_against_spin=structure.fidelity == "deliverable",
            )
            for own, item, states in zip(numbers.objects, structure.objects, slosh, strict=True)
            for oscillator, directions, state in zip(own.oscillators, item.oscillators, states, strict=True)
        ]
        if residuals:
            equalities.append(ca.vertcat(*residuals) / scales[layout.acceleration(point)])

    # Constraints are imposed at the node, where jerk-limited accelerations have their corners, and in the middle.
    for repetition, fraction in enumerate((0.0, 0.5)):
        tray = start.motion
        if repetition:
            moved = _lifted(_moved(chains, jerks, fraction * interval), lifted)
            tray = tray_state(structure, numbers, moved).lifted(lifted).motion
        inside = interior(stage[layout.displacement], stage[layout.velocity], accelerations, fraction, interval)
        position, velocity, acceleration = (lifted.lift(part) for part in inside)
        objects = sample_objects(structure, numbers, tray, split_states(structure, position, velocity, acceleration))
        objects = tuple(_lifted_object(item, lifted) for item in objects)
        collector.add(Sample(structure, numbers, objects=objects), (EvaluationPoint.OBJECT,), repetition)

    weights = [numbers.path_jerk_weight] + [numbers.tilt_jerk_weight] * layout.tilts
    weights += [numbers.tilt_jerk_weight] * layout.redundant
    cost = interval + sum(weight / intervals * jerks[index] ** 2 for index, weight in enumerate(weights))
    rows, lower, upper = collector.stacked()
    return StageExpressions(
        lifted, following, ca.vertcat(*equalities), rows, lower, upper, tuple(collector.blocks), cost
    )


def _moved(chains: tuple[IntegratorChain, ...], jerks: SX, time: SX) -> tuple[IntegratorChain, ...]:
    return tuple(advance_chain(chain, jerks[index], time) for index, chain in enumerate(chains))


def _lifted(chains: tuple[IntegratorChain, ...], lifted: LiftedVariables) -> tuple[IntegratorChain, ...]:
    return tuple((lifted.lift(chain[0]), lifted.lift(chain[1]), lifted.lift(chain[2])) for chain in chains)


def _lifted_object(item: ObjectSample, lifted: LiftedVariables) -> ObjectSample:
    wrench = Wrench(lifted.lift(item.wrench.force), lifted.lift(item.wrench.moment))
    return replace(item, wrench=wrench, surface=lifted.lift(item.surface))


def terminal_rows(
    structure: Structure,
    layout: Layout,
    numbers: SceneNumbers,
    state: SX,
    backoff: Mapping[RowIndex, SX],
) -> RowCollector:
    """Rows on the final state, the tray at rest and level; slosh accelerations are not read there."""
    slosh = split_states(structure, state[layout.displacement], state[layout.velocity], SX.zeros(layout.coordinates))
    objects = sample_objects(structure, numbers, frame_at_rest(numbers.gravity), slosh)
    collector = RowCollector(backoff)
    collector.add(Sample(structure, numbers, objects=objects), (EvaluationPoint.END,))
    return collector
