"""A scene as an optimal control problem with numbers.

Parameters, scales, bounds, and the way in and out of its variables.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from nospill.laws.constraints import by_name, constraints_of
from nospill.laws.constraints.base import EvaluationPoint, RowId
from nospill.laws.parameters import Number, SceneNumbers
from nospill.laws.scene_parameters import initial_coordinates, numbers_of, structure_of
from nospill.laws.slosh.driven_modes import driven_frequencies
from nospill.laws.structure import Structure
from nospill.robots.kinematics.regularity import determinants
from nospill.scene.cargo import Cargo
from nospill.scene.initial_state import InitialState
from nospill.scene.scene import Scene
from nospill.transcription.clearance_planes import NO_PLANES, Planes
from nospill.transcription.layout import Layout
from nospill.transcription.nlp import Transcription, transcribe
from nospill.transcription.problem_numbers import ProblemNumbers
from nospill.transcription.stage import RowIndex
from nospill.transcription.stages import Stages
from nospill.transcription.weights import jerk_weights, jump_time, jump_weights

_SHORTEST = 0.05
"""Shortest motion considered, s: keeps the interval away from zero."""

_LARGEST_SLOSH_SCALE = 0.02
"""Scale of a surface height when its limit is generous, m."""

_DRIVEN = 0.3
"""Height of a mode of second order over that of the surface, for its scale."""

_SELF_MOTION_JERK = 1000.0
"""Bound on the third derivative of a seven-joint arm's free parameter, rad/s^3."""

EASED, WIDER = 0.1, 0.02
"""Part of a motion from a state in motion in which rows are wider by this part of a budget: the motion before may stand
on its limits there, and back-off that later instants need would leave no motion that goes on from it. The judge looks
there too."""
_LEAST_EASED = 2
"""Intervals."""

Backoff = Mapping[RowId, float]
"""Row -> fraction of the budget that is kept from the optimiser, 0 where it is not named."""


class RowPlaces(NamedTuple):
    """Where a row stands.

    Attributes:
        row: of the scene.
        places: (m,) among the constraints.
        nodes: (m,) that each is about.
    """

    row: RowId
    places: np.ndarray
    nodes: np.ndarray


@dataclass(frozen=True, slots=True)
class Problem:
    """One nonlinear programme.

    Attributes:
        scene: what it was made from.
        structure: of the scene.
        numbers: of the scene.
        own: of the problem alone.
        transcription: functions and constraint bounds.
        parameters: of the functions.
        scales: (layout.size,) physical size of a scaled one.
        lower: (n,) bounds of the scaled variables.
        upper: likewise.
        self_motion: as in `Stages`.
        rows: row of the structure -> row of the scene, whether it takes part or not.
        backoff: fraction of each budget that is kept from the optimiser.
        planes: of the rows of clearance.
        sums: (n, `SUMS`, N) gains of the joints' speeds in running sums, whose squares are a part of the cost; None
            where there are none.
        jump_weights: (c,) of the jumps of the scaled jerks in the cost; empty where these cost nothing.
        row_lower: (m,) bounds of the constraints: those of the transcription, but for a motion that begins in motion:
            without the rows on its first instant, which nothing can change, and with wider ones right after it.
        row_upper: likewise.
    """

    scene: Scene
    structure: Structure
    numbers: SceneNumbers
    own: ProblemNumbers
    transcription: Transcription
    parameters: np.ndarray
    scales: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    self_motion: np.ndarray | None
    rows: Mapping[RowIndex, RowId]
    backoff: Backoff
    planes: Planes
    sums: np.ndarray | None
    jump_weights: np.ndarray
    row_lower: np.ndarray
    row_upper: np.ndarray

    def with_more_backoff(self, step: float) -> np.ndarray:
        """Parameters with every back-off larger by a step."""
        return self.parameters_of(self.numbers, {row: value + step for row, value in self.backoff.items()})

    def parameters_of(self, numbers: SceneNumbers, backoff: Backoff) -> np.ndarray:
        """Parameters with other numbers and back-off."""
        indexed = {index: backoff.get(row, 0.0) for index, row in self.rows.items()}
        of_table = self.transcription.parameters(numbers, self.own, self.scales, indexed)
        scale = self.scales[self.transcription.layout.joint_speed][None, :, None]
        of_sums = np.zeros(0) if self.sums is None else (self.sums.transpose(2, 0, 1) * scale).ravel()
        return np.concatenate([of_table, self.planes.parameters(backoff), self.jump_weights, of_sums])

    @property
    def places(self) -> tuple[RowPlaces, ...]:
        """Where each row that takes part stands among the constraints, some rows more than once."""
        transcription = self.transcription
        found = (RowPlaces(self.rows[row], places, own) for row, places, own in transcription.row_places)
        behind = len(transcription.lower) - transcription.clearance_rows
        apart = (RowPlaces(row, behind + places, nodes) for row, (places, nodes) in self.planes.places().items())
        return (*found, *apart)

    def encode(self, stages: Stages) -> np.ndarray:
        """Scaled variables of a candidate on this problem's grid."""
        layout, table = self.transcription.layout, stages.table
        if layout.regular:
            values = determinants(self.scene.robot, table[:, layout.joint_position], self.self_motion)
            table = np.column_stack([table, values])
        of_motion = (table / self.scales).ravel()[: self.transcription.motion_variables]
        return np.concatenate([of_motion, self._sums_of(table), self.planes.values])

    def _sums_of(self, table: np.ndarray) -> np.ndarray:
        """The running sums of a motion, as its variables are."""
        if self.sums is None:
            return np.zeros(0)
        speeds = table[:-1, self.transcription.layout.joint_speed]
        return np.cumsum(self.sums.transpose(2, 0, 1) * speeds[:, :, None], axis=0).ravel()

    def planes_at(self, variables: np.ndarray) -> Planes:
        """The planes where scaled variables put them."""
        return replace(self.planes, values=variables[len(variables) - self.transcription.plane_variables :])

    def duration(self, variables: np.ndarray) -> float:
        """End time of the candidate that scaled variables stand for, s."""
        index = self.transcription.layout.interval
        return float(variables[index] * self.scales[index]) * self.transcription.intervals

    def decode(self, variables: np.ndarray) -> Stages:
        """The candidate that scaled variables stand for."""
        size = self.transcription.layout.size
        padded = np.zeros((self.transcription.intervals + 1) * size)
        padded[: self.transcription.motion_variables] = variables[: self.transcription.motion_variables]
        table = (padded.reshape(-1, size) * self.scales)[:, : size - self.transcription.layout.regular]
        return Stages(float(table[0, self.transcription.layout.interval]), table, self.self_motion)


def build_problem(
    scene: Scene,
    intervals: int,
    *,
    nominal_duration: float,
    jerk_weight_factor: float = 1.0,
    backoff: Backoff,
    active: Set[RowId] | None = None,
    payload: Sequence[Cargo] | None = None,
    exact_rest: bool = True,
    self_motion: np.ndarray | None = None,
    least_determinant: float | None = None,
    planes: Planes = NO_PLANES,
    sums: np.ndarray | None = None,
) -> Problem:
    """The problem of a scene on a grid.

    Args:
        scene: the task.
        intervals: N.
        nominal_duration: expected end time, s, for the scales, and for the weights of the jerks that are not stated.
        jerk_weight_factor: factor on those weights; where joints ring jumps of the jerk weigh more instead.
        backoff: fraction of each budget kept from the optimiser.
        active: which rows take part, on the final state as elsewhere; None for all.
        payload: what the flange carries, where the cargo of the scene is only some of it or several variants of it;
            None where it is the cargo itself.
        exact_rest: whether liquids that end at rest do so exactly, by bounds of the variables. Several variants of one
            object do not come to rest at one instant: without the bounds, the rows on the final state hold them as near
            to it as the judge demands.
        self_motion: of a seven-joint arm, as in `Stages`.
        least_determinant: with its sign, what the determinant of the Jacobian stays beyond; None leaves it free.
        planes: that keep bodies apart, on this grid.
        sums: as in `Problem`.
    """
    structure = replace(structure_of(scene), regular=least_determinant is not None)
    numbers = numbers_of(scene, payload)
    direction = np.zeros(len(structure.joints)) if self_motion is None else self_motion
    problem_numbers = ProblemNumbers(**jerk_weights(scene, nominal_duration, jerk_weight_factor), self_motion=direction)
    rows = {RowIndex(row.constraint, index): row for index, row in _rows(scene)}
    taking_part = None if active is None else frozenset(index for index, row in rows.items() if row in active)
    transcription = transcribe(
        structure,
        intervals,
        active=taking_part,
        clearance=planes.groups,
        jumps=jump_time(scene) > 0.0,
        sums=sums is not None,
    )
    scales = _scales(scene, structure, numbers, transcription.layout, nominal_duration, intervals)
    lower, upper = _bounds(
        scene, structure, transcription.layout, scales, intervals, exact_rest=exact_rest, self_motion=self_motion
    )
    if least_determinant is not None:
        size = transcription.layout.size
        scales[size - 1] = least_determinant
        lower[size - 1 : intervals * size : size] = 1.0
    row_lower, row_upper = transcription.lower, transcription.upper
    if scene.initial_state is not None:
        given, first = _given_places(scene, transcription)
        row_lower, row_upper = row_lower.copy(), row_upper.copy()
        eased = max(_LEAST_EASED, int(EASED * intervals))
        early = given[None] + transcription.rows_per_stage * np.arange(eased)[:, None]
        row_lower[early] -= WIDER
        row_upper[early] += WIDER
        row_lower[given[first]], row_upper[given[first]] = -np.inf, np.inf
    of_planes = np.concatenate([np.full(transcription.sum_variables, np.inf), planes.bounds()])
    lower, upper = np.concatenate([lower, -of_planes]), np.concatenate([upper, of_planes])
    problem = Problem(
        scene=scene,
        structure=structure,
        numbers=numbers,
        own=problem_numbers,
        transcription=transcription,
        parameters=np.zeros(0),
        scales=scales,
        lower=lower,
        upper=upper,
        self_motion=self_motion,
        rows=rows,
        backoff=backoff,
        planes=planes,
        sums=sums,
        jump_weights=_jump_weights(
            scene, transcription.layout, scales, nominal_duration, intervals, jerk_weight_factor
        ),
        row_lower=row_lower,
        row_upper=row_upper,
    )
    return replace(problem, parameters=problem.parameters_of(numbers, backoff))


def _jump_weights(
    scene: Scene, layout: Layout, scales: np.ndarray, duration: float, intervals: int, jerk_weight_factor: float
) -> np.ndarray:
    """Weights (c,) of the jumps of the scaled jerks; empty where they cost nothing."""
    if jump_time(scene) == 0.0:
        return np.zeros(0)
    named = jump_weights(scene, duration, intervals, jerk_weight_factor)
    weights = np.array([named["path_jerk_weight"], *[named["tilt_jerk_weight"]] * (layout.chains - 1)])
    weights[[*layout.freedom.offset_chains]] = named["offset_jerk_weight"]
    found: np.ndarray = weights / intervals * scales[layout.jerks] ** 2
    return found


def _given_places(scene: Scene, transcription: Transcription) -> tuple[np.ndarray, np.ndarray]:
    """Places (m,) of the rows on the first interval that are not of the jerks; which of them are on its first instant.

    Those follow from the state alone.
    """
    known = by_name(scene)
    blocks = [
        block for block in transcription.blocks if known[block.constraint].evaluated_at is not EvaluationPoint.CONTROL
    ]
    places = [np.arange(block.first, block.first + block.count) for block in blocks]
    first = [np.full(block.count, block.repetition == 0) for block in blocks]
    return np.concatenate([np.zeros(0, dtype=int), *places]), np.concatenate([np.zeros(0, dtype=bool), *first])


def _rows(scene: Scene) -> Iterator[tuple[int, RowId]]:
    """Every row of a scene with the index of its subject."""
    for constraint in constraints_of(scene):
        for index, subject in enumerate(constraint.subjects(scene)):
            yield index, RowId(constraint.name, subject)


def _scales(
    scene: Scene, structure: Structure, numbers: SceneNumbers, layout: Layout, duration: float, intervals: int
) -> np.ndarray:
    scales = np.ones(layout.size)
    freedom = layout.freedom
    sizes: dict[int, Number] = dict.fromkeys(freedom.tilt_chains, 0.3)
    sizes |= dict.fromkeys(freedom.offset_chains, numbers.corridor)
    for chain in range(layout.chains):
        value = sizes.get(chain, 1.0)
        scales[3 * chain : 3 * chain + 3] = value, 2 * value / duration, 10 * value / duration**2
    scales[layout.interval] = duration / intervals
    limits = [scene.motion.path_jerk_limit] + [scene.motion.tilt_jerk_limit] * (layout.chains - 1)
    for chain in layout.freedom.offset_chains:
        limits[chain] = numbers.offset_jerk_limit
    if layout.redundant:
        limits[-1] = _SELF_MOTION_JERK
    scales[layout.jerks] = [0.3 * limit for limit in limits]
    oscillations: list[tuple[float, float]] = []
    for item, object_numbers in zip(structure.objects, numbers.objects, strict=True):
        height = min(object_numbers.max_slosh_height, _LARGEST_SLOSH_SCALE)
        for directions, mode in zip(item.oscillators, object_numbers.oscillators, strict=True):
            oscillations += [(height / abs(mode.surface_gain), mode.frequency)] * len(directions)
        if item.driven:
            frequencies = driven_frequencies(object_numbers.driven, item.driven, numbers.gravity)
            oscillations += [(_DRIVEN * height, frequency) for frequency in frequencies]
    displacement = np.array([amplitude for amplitude, _ in oscillations])
    frequency = np.array([frequency for _, frequency in oscillations])
    scales[layout.displacement] = displacement
    scales[layout.velocity] = displacement * frequency
    for point in range(2):
        scales[layout.acceleration(point)] = displacement * frequency**2
    further = (scene.robot.max_acceleration, scene.robot.max_jerk)
    scales[layout.joint_speed] = scene.robot.max_speed
    for order in range(2, layout.orders + 1):
        limit, usual = further[order - 2], 2.0 * scene.robot.max_speed * (2.0 / duration) ** (order - 1)
        scales[layout.joint_derivative(order)] = usual if limit is None else limit
    return scales


def initial_chains(state: InitialState, layout: Layout, self_motion: np.ndarray | None) -> np.ndarray:
    """Value, rate and acceleration of every chain (3 c,) in a state, the self-motion of a seven-joint arm last."""
    freedom = layout.freedom
    of_tray = state.chains(tilt=freedom.tilt, offset=freedom.offset, yaw=freedom.yaw).ravel()
    if not layout.redundant:
        return of_tray
    assert self_motion is not None  # of an arm with seven joints
    return np.concatenate([of_tray, [float(self_motion @ part) for part in state.joints]])


def _bounds(
    scene: Scene,
    structure: Structure,
    layout: Layout,
    scales: np.ndarray,
    intervals: int,
    *,
    exact_rest: bool,
    self_motion: np.ndarray | None,
) -> tuple[np.ndarray, np.ndarray]:
    lower = np.full((intervals + 1, layout.size), -np.inf)
    upper = np.full((intervals + 1, layout.size), np.inf)
    lower[:, 1] = 0.0
    lower[:, layout.interval] = _SHORTEST / intervals
    upper[:, layout.interval] = scene.motion.longest / intervals
    if scene.motion.duration is not None:
        lower[0, layout.interval] = upper[0, layout.interval]  # all intervals are alike
    ends = (lower[0], upper[0], lower[-1], upper[-1])
    if layout.redundant:
        # No constraint of the table limits this jerk: the bound only keeps the self-motion smooth.
        own = layout.jerks.stop - 1
        lower[:, own], upper[:, own] = -_SELF_MOTION_JERK, _SELF_MOTION_JERK
    for row in ends:
        row[: layout.interval] = 0.0
    if layout.redundant:
        free = 3 * (layout.chains - 1)
        stated_ends = (None, None) if scene.motion.stop else scene.path.ends
        for side, stated in zip((ends[:2], ends[2:]), stated_ends, strict=True):
            value = np.inf if stated is None or self_motion is None else float(self_motion @ stated)
            side[0][free], side[1][free] = (-value, value) if np.isinf(value) else (value, value)
    for row in ends[2:]:
        row[0] = 1.0
    if scene.initial_state is not None:
        for row in ends[:2]:
            row[: layout.interval] = initial_chains(scene.initial_state, layout, self_motion)
        if scene.motion.stop:
            ends[2][0] = scene.initial_state.s
    for row in ends[:2]:
        row[layout.displacement], row[layout.velocity] = initial_coordinates(scene)
    # Flat modes come to rest as nearly as the judge demands: exactly so, each would cost two controls at the end.
    # So do the liquids in a carrier, many and nearly alike: their equations would nearly depend on each other. Of what
    # pushes the carrier nothing is demanded there.
    slow = np.array(
        [
            not (flat or item.spread or item.in_carrier)
            for item in structure.objects
            for axes, flat in [
                *zip(item.oscillators, item.flat, strict=True),
                *[((0,), True)] * item.driven_coordinates,
            ]
            for _ in axes
        ],
        dtype=bool,
    )
    for row in ends[2:]:
        if exact_rest and scene.motion.end in ("still", "published"):
            row[layout.displacement][slow] = 0.0
        if exact_rest and scene.motion.end == "still":
            row[layout.velocity][slow] = 0.0
    size = intervals * layout.size + layout.states
    return (lower / scales).ravel()[:size], (upper / scales).ravel()[:size]
