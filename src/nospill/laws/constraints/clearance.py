"""Bodies keep apart: arm, tray and cargo from obstacles, and from each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

import casadi as ca
import numpy as np

from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, Role, RowId
from nospill.laws.sample import Sample
from nospill.scene.scene import Scene


class Clearance(Constraint):
    """distance >= clearance, for every pair of bodies.

    The judge finds the distances of bodies itself (`judge.clearance`). Which pairs there are, and the planes by which
    the optimiser keeps them apart, is geometry of the arm (`collisions`), not of a sample: the rows are made beside
    those of the table, by `clearance_row`.
    """

    name = "clearance"
    unit = "m"
    role = Role.CLEARANCE
    evaluated_at = EvaluationPoint.JOINT
    in_words = "clearance of {subject}"
    description = "Distance of two bodies above its limit at all times: the obstacle's `clearance`, or contact."
    backoff = 2e-3
    least_size = 0.1  # m; a pair farther apart than this is of no concern

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """None that a sample tells of."""
        return ()

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """None that a sample tells of."""
        return ()


_Values = TypeVar("_Values", ca.MX, np.ndarray)


def clearance_row(distance: _Values, limit: _Values, reserve: _Values) -> _Values:
    """Rows, at least zero, of distances from planes between two bodies; a budget is `least_size`.

    Args:
        distance: as parts of `least_size`.
        limit: that is to be kept, m.
        reserve: fraction of the budget that is kept from the optimiser.
    """
    return distance - limit / Clearance.least_size - reserve


def clearance_backoff(slack: Mapping[RowId, float]) -> dict[RowId, float]:
    """First back-off of each pair, which leaves no less than both ends of the motion have, where the arm has to be.

    Args:
        slack: what the ends leave above the limit, as a part of `least_size`.
    """
    return {row: min(max(value, 0.0), Clearance.backoff) for row, value in slack.items()}
