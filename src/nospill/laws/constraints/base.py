"""What a constraint is: name, unit, role, subjects and budgets, and the figures that planning and judging need of it.

Everything that walks the constraints reads only this; no other package has a table by the names of constraints.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, NamedTuple

import casadi as ca
import numpy as np

from nospill.core.frames import SX
from nospill.laws.sample import ObjectSample, Sample
from nospill.scene.scene import Scene


class EvaluationPoint(Enum):
    """Where along the motion a constraint is imposed, and so which part of the sample it reads."""

    OBJECT = "object"
    """objects: at every node and in the middle of every interval."""
    JOINT = "joint"
    """joint_position, joint_speed, joint_acceleration: at every node."""
    TRAY = "tray"
    """tray_position, tray_velocity, tray_acceleration: at every node."""
    CONTROL = "control"
    """tilt, tilt_speed, jerks, joint_jerk: at every node; the judge takes third differences of the samples."""
    PASSING = "passing"
    """path_parameter, offset: at every node; the judge takes the nearest instant of the whole motion."""
    END = "end"
    """objects at the end of the motion, the tray at rest and level."""


EVERYWHERE = tuple(EvaluationPoint)
OF_OBJECTS = (EvaluationPoint.OBJECT, EvaluationPoint.END)
"""Where the constraints on objects are imposed."""


class Role(Enum):
    """What a constraint protects."""

    LIQUID = "liquid"
    """The liquid in its cup."""
    CONTACT = "contact"
    """The object in its place on the tray."""
    JOINT = "joint"
    """A joint of the arm."""
    CLEARANCE = "clearance"
    """Arm, tray and cargo from what they could run into."""
    TRAY = "tray"
    """Tilt, speed and acceleration of the tray, and the smoothness of path parameter and tilt."""


class RowId(NamedTuple):
    """A row of the problem or of the certificate: one constraint on one subject.

    Attributes:
        constraint: its name.
        subject: what it applies to, as `Constraint.subjects` names it.
    """

    constraint: str
    subject: str

    @property
    def label(self) -> str:
        """As records name it: "slip | c1"."""
        return f"{self.constraint} | {self.subject}"

    @classmethod
    def of(cls, label: str) -> RowId:
        """The row of a label."""
        constraint, _, subject = label.partition(" | ")
        return cls(constraint, subject)


ALL = "all"
"""Subject where a row is about more than one."""


@dataclass(frozen=True, slots=True)
class ObjectKey:
    """A limit in the entry of an object (or of the tray, where it stands for all objects).

    Attributes:
        key: in `[[cargo]]`.
    """

    key: str


@dataclass(frozen=True, slots=True)
class JointKey:
    """A limit of every joint, in `[robot.limits]`.

    Attributes:
        key: there.
        attribute: of the robot, (n,) in SI units.
        dimension: as in `core.units`.
        falls_with_load: whether a lighter cargo helps as a higher limit does.
    """

    key: str
    attribute: str
    dimension: str
    falls_with_load: bool = False


@dataclass(frozen=True, slots=True)
class MotionKey:
    """A limit among the rules of the motion.

    Attributes:
        key: in its table, and the attribute of the rules, SI units.
        dimension: as in `core.units`.
        largest: value that the scenario allows, SI units.
        table: of the scenario.
    """

    key: str
    dimension: str
    largest: float
    table: str = "motion"


LimitKey = ObjectKey | JointKey | MotionKey
"""Where the scenario has the limit of a constraint, so that a diagnosis can relax it."""


@dataclass(frozen=True, slots=True)
class Cone:
    """|demand| <= capacity.

    Attributes:
        demand: (k, 1).
        capacity: scalar, same unit.
        scale: a positive size of the capacity; the capacity itself, where that is positive and constant.
    """

    demand: SX
    capacity: SX | float
    scale: SX | float


@dataclass(frozen=True, slots=True)
class Range:
    """lower <= value <= upper.

    Attributes:
        value: scalar.
        lower: scalar, same unit; None for a limit from above alone.
        upper: likewise; None for a limit from below alone.
        scale: a positive size of them.
    """

    value: SX
    lower: SX | float | None
    upper: SX | float | None
    scale: SX | float


@dataclass(frozen=True, slots=True)
class Stop:
    """|value| <= capacity, and slow enough to stop before either end.

    That is value <= sqrt(above) - offset and -value <= sqrt(below) - offset, with squares of speeds above the offset.
    """

    value: SX
    capacity: SX
    below: SX
    above: SX
    offset: SX


Budget = Cone | Range | Stop


def smooth_rows(budget: Budget, reserve: SX) -> tuple[SX, np.ndarray, np.ndarray]:
    """A budget less a reserve as rows with constant bounds: values (m, 1), lower (m,), upper (m,).

    A cone of one dimension gives two linear rows, one with both bounds where its capacity is constant; of more,
    capacity^2 - |demand|^2 >= 0, valid because every capacity is proportional to a pressing force that another
    constraint keeps positive, or constant. A way to stop is squared where the value goes towards its end, so that it
    has a slope wherever it is at its limit.
    """
    if isinstance(budget, Stop):
        value = budget.value / (1 - reserve)
        scale, offset = (budget.capacity + budget.offset) ** 2, budget.offset
        ways = (budget.above - ca.fmax(offset + value, 0) ** 2, budget.below - ca.fmax(offset - value, 0) ** 2)
        rows: SX = ca.vertcat(value / budget.capacity, *[way / scale for way in ways])
        return rows, np.array([-1.0, 0.0, 0.0]), np.array([1.0, np.inf, np.inf])
    if isinstance(budget, Range):
        if budget.lower is None or budget.upper is None:
            return _one_end(budget)[1] / budget.scale - reserve, np.zeros(1), np.full(1, np.inf)
        middle, half = (budget.upper + budget.lower) / 2, (budget.upper - budget.lower) / 2
        return (budget.value - middle) / (half * (1 - reserve)), -np.ones(1), np.ones(1)
    capacity = budget.capacity * (1 - reserve) / budget.scale
    demand = budget.demand / budget.scale
    if demand.numel() == 1:
        if budget.capacity is budget.scale:
            return demand / (1 - reserve), -np.ones(1), np.ones(1)
        return ca.vertcat(capacity - demand, capacity + demand), np.zeros(2), np.full(2, np.inf)
    return capacity**2 - ca.dot(demand, demand), np.zeros(1), np.full(1, np.inf)


def _one_end(budget: Range) -> tuple[SX, SX]:
    """The end of a range that has one, and what is left to it."""
    if budget.lower is not None:
        return SX(budget.lower), budget.value - budget.lower
    assert budget.upper is not None
    return SX(budget.upper), budget.upper - budget.value


def figures(budget: Budget, relative: bool) -> tuple[SX, SX, SX]:
    """Value, limit and margin of a budget as the certificate prints them (margin >= 0 holds).

    Relative figures are fractions of the capacity; a capacity that has gone to zero or below gives a negative margin.
    """
    if isinstance(budget, Stop):
        way = ca.if_else(budget.value < 0, budget.below, budget.above)
        least = ca.fmin(budget.capacity, ca.sqrt(way) - budget.offset)
        return budget.value, ca.if_else(budget.value < 0, -least, least), least - ca.fabs(budget.value)
    if isinstance(budget, Range):
        if budget.lower is None or budget.upper is None:
            return budget.value, *_one_end(budget)
        low, high = budget.value - budget.lower, budget.upper - budget.value
        return budget.value, ca.if_else(low < high, budget.lower, budget.upper), ca.fmin(low, high)
    demand = ca.norm_2(budget.demand) if budget.demand.numel() > 1 else ca.fabs(budget.demand)
    if not relative:
        return demand, SX(budget.capacity), budget.capacity - demand
    # Without pressing force there is no budget: what is missing counts as demand, in millionths of the scale.
    floor = 1e-6 * budget.scale
    use = (demand + ca.fmax(floor - budget.capacity, 0)) / ca.fmax(budget.capacity, floor)
    return use, SX(1), 1 - use


class Constraint(ABC):
    """One constraint family.

    Attributes:
        name: as in the certificate.
        unit: of the printed figures ("1" for a fraction).
        role: what it protects.
        evaluated_at: where along the motion it is imposed.
        description: one sentence for the documentation.
        relative: whether cones are printed as a fraction of their capacity.
        backoff: fraction of every budget that is kept from the optimiser at first. It is what the limit typically
            exceeds between grid points, and where the spline through the samples rounds the corners of the jerk,
            measured on the examples: enough for most motions to be certified at once, little enough to cost less than a
            thousandth of the duration.
        restart_backoff: least fraction that is kept back where planning goes on from an earlier answer. One more round
            of tightening would take longer than all the rest; what is kept back beyond `backoff` costs less than a
            tenth of a percent of the duration.
        judge_resolution: fraction of the limit that a plan has to leave: what a grid four times finer than the judge's
            may find between its instants, most where accelerations with corners decide. Measured on some hundred
            random scenarios.
        integration_error: what it has to leave besides, in the constraint's unit, where the judge integrates.
        least_size: what a margin is measured by at least, in the constraint's unit, where the limit's distance from
            zero says nothing.
        limit_key: where the scenario has the limit; None where no key relaxes this constraint alone.
        in_words: what holds a motion back where this limit does, about a "{subject}"; where it is empty, the name.
        objects: names of the objects that a limit given from Python is about; empty for all that `subjects` names.
    """

    name: str
    unit: ClassVar[str]
    role: ClassVar[Role]
    evaluated_at: ClassVar[EvaluationPoint]
    description: ClassVar[str] = ""
    relative: ClassVar[bool] = False
    backoff: ClassVar[float] = 1e-3
    restart_backoff: ClassVar[float] = 0.0
    judge_resolution: ClassVar[float] = 0.0
    integration_error: ClassVar[float] = 0.0
    least_size: ClassVar[float] = 0.0
    limit_key: ClassVar[LimitKey | None] = None
    in_words: ClassVar[str] = ""
    objects: tuple[str, ...] = ()

    @abstractmethod
    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """What it applies to, in the order of `budgets`; empty where it does not apply."""

    @abstractmethod
    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """Per subject, the budgets that must hold at this instant."""


def worst_figures(constraint: Constraint, budgets: tuple[Budget, ...]) -> SX:
    """Value, limit and margin (3, 1) of the budget of a subject that has the least margin."""
    worst, *others = (ca.vertcat(*figures(budget, constraint.relative)) for budget in budgets)
    for other in others:
        worst = ca.if_else(other[2] < worst[2], other, worst)
    return worst


def liquid_names(scene: Scene) -> tuple[str, ...]:
    """Names of the cargo with liquid."""
    return tuple(cargo.name for cargo in scene.cargo if cargo.filling)


def open_names(scene: Scene) -> tuple[str, ...]:
    """Names of the cargo whose liquid may spill: it has no lid."""
    return tuple(cargo.name for cargo in scene.cargo if cargo.filling and not cargo.filling.lid)


def loose_names(scene: Scene) -> tuple[str, ...]:
    """Names of the cargo that is held by its weight alone."""
    return tuple(cargo.name for cargo in scene.cargo if not cargo.fixed)


def loose(sample: Sample) -> tuple[ObjectSample, ...]:
    """The objects of a sample that are held by their weight alone."""
    return tuple(item for item in sample.objects if not item.structure.fixed)


def standing_names(scene: Scene) -> tuple[str, ...]:
    """Names of the cargo that friction holds on the tray itself."""
    return tuple(cargo.name for cargo in scene.cargo if not (cargo.carrier or cargo.fixed))


def standing(sample: Sample) -> tuple[ObjectSample, ...]:
    """The objects of a sample that friction holds on the tray itself."""
    return tuple(item for item in loose(sample) if not item.structure.in_carrier)
