"""What a wider limit would save: the multipliers of a solution times what its rows would move.

By the envelope theorem the optimum's objective changes with a number p of the problem by dL/dp = df/dp + lambda' dg/dp,
the variables held. Limits stand among the parameters of the rows, so that the rows at two values of a limit are all
that is needed; no row has a derivative of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields, replace

import numpy as np

from nospill.laws.constraints import by_name
from nospill.laws.constraints.base import ALL, JointKey, LimitKey, MotionKey, ObjectKey, RowId
from nospill.laws.parameters import ObjectNumbers, SceneNumbers, sources
from nospill.transcription.problem import Backoff, Problem
from nospill.transcription.solvers import Solution

WIDER = 0.1
"""Part by which a limit is made wider."""
_STEP = 1e-4
"""Part of a limit by which it is moved either way for its derivative; rows are at most quadratic in it."""
_OF_OBJECTS = {"friction": "planned_friction"}
"""Key of a limit of an object -> name of its number, where that is another."""


def savings(problem: Problem, solution: Solution, rows: Iterable[RowId]) -> dict[str, float]:
    """Seconds that the motion would be shorter with one limit `WIDER`, to the first order.

    A limit of objects is widened for all of them at once: like objects are at their limits at the same instants, and
    what one of them alone would save is then not determined by the multipliers (it is nothing). So is a limit of the
    motion, which all tilt angles share.

    Args:
        problem: that was solved.
        solution: its answer.
        rows: whose limits, subjects as in the scene; those without a limit that can be widened by itself are left out.

    Returns:
        By the row's label, with the subject `ALL` where it is about more than one; nothing where a duration is stated.
        The limit is that of the scenario: with `max_slosh_height` the residual height moves too, with `friction` what
        holds objects against turning.
    """
    savings_of: dict[str, float] = {}
    known = by_name(problem.scene)
    if problem.scene.motion.duration is not None:
        return savings_of
    for row in rows:
        constraint = known.get(row.constraint)
        key = constraint.limit_key if constraint is not None else None
        name = (row if isinstance(key, JointKey) else RowId(row.constraint, ALL)).label
        if name in savings_of:
            continue
        more, less = (_scale_limit(problem, row, key, factor) for factor in (1.0 + _STEP, 1.0 - _STEP))
        if more is not None and less is not None:
            parameters = [problem.parameters_of(varied, problem.backoff) for varied in (more, less)]
            high, low = (lagrangian(problem, solution, varied) for varied in parameters)
            savings_of[name] = -WIDER * (high - low) / (2.0 * _STEP)
    return savings_of


def saving_of(problem: Problem, solution: Solution, backoff: Backoff) -> float:
    """Seconds that the motion would be shorter with another back-off, to the first order; 0 of a stated duration."""
    if problem.scene.motion.duration is not None:
        return 0.0
    after = problem.parameters_of(problem.numbers, backoff)
    return lagrangian(problem, solution, problem.parameters) - lagrangian(problem, solution, after)


def lagrangian(problem: Problem, solution: Solution, parameters: np.ndarray) -> float:
    """The part of the Lagrangian that changes with the parameters."""
    return float(solution.multipliers @ problem.transcription.constraints(solution.variables, parameters))


def _scale_limit(problem: Problem, row: RowId, key: LimitKey | None, factor: float) -> SceneNumbers | None:
    """The numbers with one limit so many times as large; None where nothing is called a limit alone."""
    numbers = problem.numbers
    if isinstance(key, JointKey):
        values = np.array(getattr(numbers, key.attribute), dtype=float)
        values[problem.scene.robot.joints.index(row.subject)] *= factor
        return replace(numbers, **{key.attribute: values})
    if isinstance(key, MotionKey):
        name = next(name for name, source in sources(SceneNumbers).items() if source == f"motion.{key.key}")
        return replace(numbers, **{name: factor * getattr(numbers, name)})
    if isinstance(key, ObjectKey):
        name = _OF_OBJECTS.get(key.key, key.key)
        if name in {field.name for field in fields(ObjectNumbers)}:
            objects = tuple(replace(item, **{name: factor * getattr(item, name)}) for item in numbers.objects)
            return replace(numbers, objects=objects)
    return None
