"""An answer's multipliers in a problem with other objects on the tray: a start that says what holds the motion back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from nospill.transcription.nlp import Transcription
from nospill.transcription.placing import PlacedObject
from nospill.transcription.problem import Problem
from nospill.transcription.solvers.solution import Solution

_Pairs = list[tuple[np.ndarray, np.ndarray]]
"""Places in a stage of one problem, and of the same rows or variables in a stage of another."""


def carried_over(solution: Solution, before: Problem, problem: Problem) -> Solution | None:
    """The answer with its multipliers arranged for another problem, without its order of pivots.

    Those of the tray, and of objects by their names; of objects that join zero, as of rows that took no part, of
    running sums and of planes between bodies.

    Args:
        solution: of the problem before.
        before: that one.
        problem: for which; on the same grid.

    Returns:
        None where the grid is another, or the tray moves otherwise.
    """
    first, second = before.transcription, problem.transcription
    trays = first.stage.tray, second.stage.tray
    if first.intervals != second.intervals or any(
        len(getattr(trays[0], part)) != len(getattr(trays[1], part)) for part in ("variables", "rows")
    ):
        return None
    objects = list(_in_both(before, problem))
    rows: _Pairs = [(trays[0].rows, trays[1].rows), *((one.rows, other.rows) for one, other in objects)]
    variables: _Pairs = [(trays[0].variables, trays[1].variables)]
    variables += [(one.variables, other.variables) for one, other in objects]
    ends = [(one.end_rows, other.end_rows) for one, other in objects]
    return replace(
        solution,
        multipliers=_of_rows(solution.multipliers, first, second, rows, ends),
        bound_multipliers=_of_variables(solution.bound_multipliers, first, second, variables, len(problem.lower)),
        pivot_order=None,
        plane_variables=second.plane_variables,
        plane_rows=second.clearance_rows,
    )


def _in_both(before: Problem, problem: Problem) -> Iterator[tuple[PlacedObject, PlacedObject]]:
    """The blocks of objects that are in both problems under one name and with the same rows and variables."""
    known = dict(zip((item.name for item in before.scene.cargo), before.transcription.stage.objects, strict=True))
    for cargo, own in zip(problem.scene.cargo, problem.transcription.stage.objects, strict=True):
        other = known.get(cargo.name)
        if other is not None and all(
            len(getattr(own, part)) == len(getattr(other, part)) for part in ("variables", "rows", "end_rows")
        ):
            yield other, own


def _of_rows(values: np.ndarray, first: Transcription, second: Transcription, rows: _Pairs, ends: _Pairs) -> np.ndarray:
    count = first.intervals * len(first.active)
    stages = np.zeros((first.intervals, first.stage.sizes.rows_per_stage))
    stages[:, first.active] = values[:count].reshape(first.intervals, -1)
    end = np.zeros(len(first.stage.sizes.end_lower))
    end[first.end_active] = values[count : count + len(first.end_active)]
    of_stages = np.zeros((second.intervals, second.stage.sizes.rows_per_stage))
    of_end = np.zeros(len(second.stage.sizes.end_lower))
    for one, other in rows:
        of_stages[:, other] = stages[:, one]
    for one, other in ends:
        of_end[other] = end[one]
    found = np.concatenate([of_stages[:, second.active].ravel(), of_end[second.end_active]])
    return np.append(found, np.zeros(len(second.lower) - len(found)))


def _of_variables(
    values: np.ndarray, first: Transcription, second: Transcription, variables: _Pairs, count: int
) -> np.ndarray:
    padded = np.zeros((first.intervals + 1) * first.layout.size)
    padded[: first.motion_variables] = values[: first.motion_variables]
    stages, found = padded.reshape(-1, first.layout.size), np.zeros((second.intervals + 1, second.layout.size))
    for one, other in variables:
        found[:, other] = stages[:, one]
    of_motion = found.ravel()[: second.motion_variables]
    return np.append(of_motion, np.zeros(count - len(of_motion)))
