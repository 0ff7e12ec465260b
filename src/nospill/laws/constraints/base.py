"""What a constraint is: a name, a unit, subjects and budgets. Everything that walks the constraints reads only this."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

import casadi as ca
import numpy as np

from nospill.core.frames import SX
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class Place(Enum):
    """Where along the motion a constraint is imposed, and so which part of the sample it reads."""

    OBJECT = "object"
    """objects: at every collocation point."""
    JOINT = "joint"
    """joint_position, joint_speed, joint_acceleration: at every node."""
    CONTROL = "control"
    """tilt, jerks, joint_jerk: at every node; the judge takes third differences of the samples."""
    END = "end"
    """objects at the end of the motion, the tray at rest and level."""


@dataclass(frozen=True, slots=True)
class Cone:
    """|demand| <= capacity; demand (k, 1), capacity scalar, `scale` a positive size of the capacity, same unit."""

    demand: SX
    capacity: SX
    scale: SX


@dataclass(frozen=True, slots=True)
class Range:
    """lower <= value <= upper, or lower <= value where `upper` is None, in units of `scale`."""

    value: SX
    lower: SX
    upper: SX | None
    scale: SX


Budget = Cone | Range


def smooth_rows(budget: Budget, reserve: SX) -> tuple[SX, np.ndarray, np.ndarray]:
    """A budget less a reserve as rows with constant bounds: values (m, 1), lower (m,), upper (m,).

    A cone of one dimension gives two linear rows; of more, capacity^2 - |demand|^2 >= 0, valid because every capacity
    is proportional to a pressing force that another constraint keeps positive, or constant.
    """
    if isinstance(budget, Range):
        if budget.upper is None:
            return (budget.value - budget.lower) / budget.scale - reserve, np.zeros(1), np.full(1, np.inf)
        middle, half = (budget.upper + budget.lower) / 2, (budget.upper - budget.lower) / 2
        return (budget.value - middle) / (half * (1 - reserve)), -np.ones(1), np.ones(1)
    capacity = budget.capacity * (1 - reserve) / budget.scale
    demand = budget.demand / budget.scale
    if demand.numel() == 1:
        return ca.vertcat(capacity - demand, capacity + demand), np.zeros(2), np.full(2, np.inf)
    return capacity**2 - ca.dot(demand, demand), np.zeros(1), np.full(1, np.inf)


def figures(budget: Budget, relative: bool) -> tuple[SX, SX, SX]:
    """Value, limit and margin of a budget as the certificate prints them (margin >= 0 holds).

    Relative figures are fractions of the capacity; a capacity that has gone to zero or below gives a negative margin.
    """
    if isinstance(budget, Range):
        low = budget.value - budget.lower
        if budget.upper is None:
            return budget.value, budget.lower, low
        high = budget.upper - budget.value
        return budget.value, ca.if_else(low < high, budget.lower, budget.upper), ca.fmin(low, high)
    demand = ca.norm_2(budget.demand) if budget.demand.numel() > 1 else ca.fabs(budget.demand)
    if not relative:
        return demand, budget.capacity, budget.capacity - demand
    # Without pressing force there is no budget: what is missing counts as demand, in millionths of the scale.
    floor = 1e-6 * budget.scale
    use = (demand + ca.fmax(floor - budget.capacity, 0)) / ca.fmax(budget.capacity, floor)
    return use, SX(1), 1 - use


class Constraint(ABC):
    """One constraint family.

    Class attributes:
        name: as in the certificate. unit: of the printed figures ("1" for a fraction). symbol: for formulas and plots.
        place: see `Place`. relative: print cones as a fraction of their capacity.
        description: one sentence for the documentation.
    """

    name: ClassVar[str]
    unit: ClassVar[str]
    place: ClassVar[Place]
    description: ClassVar[str]
    relative: ClassVar[bool] = False

    @abstractmethod
    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Who it speaks of, in the order of `budgets`; empty where it does not apply."""

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


def object_names(scene: Scene) -> tuple[str, ...]:
    """Names of all cargo."""
    return tuple(cargo.name for cargo in scene.cargo)
