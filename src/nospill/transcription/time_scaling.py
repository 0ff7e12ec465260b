"""The same motion, slower."""

from __future__ import annotations

from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.transcription.layout import Layout
from nospill.transcription.problem import Problem
from nospill.transcription.solvers import row_slack
from nospill.transcription.stages import Stages

_BROKEN = 0.2
_BROKEN_HEIGHT = 0.05
_SLOWEST = 1.5
_BISECTIONS = 6


def slowed(stages: Stages, layout: Layout, factor: float) -> Stages:
    """The same motion played `factor` times as slowly, its tilt angles in proportion to the acceleration.

    Liquids follow in proportion to the tray's acceleration, which is nearly what they do and keeps them in phase; their
    equation of motion no longer holds to the last digit, nor do the joint positions of a tray that tilts.
    """
    table = stages.table.copy()
    for chain in range(layout.chains):
        table[:, 3 * chain + 1] /= factor
        table[:, 3 * chain + 2] /= factor**2
    table[:, layout.jerks] /= factor**3
    for chain in layout.freedom.tilt_chains:  # as much of gravity along the tray as there is acceleration to balance
        table[:, 3 * chain : 3 * chain + 3] /= factor**2
        table[:, layout.jerks.start + chain] /= factor**2
    table[:, layout.interval] *= factor
    table[:, layout.displacement] /= factor**2
    table[:, layout.velocity] /= factor**3
    for point in range(2):
        table[:, layout.acceleration(point)] /= factor**4
    for order in range(1, layout.orders + 1):
        table[:, layout.joint_derivative(order)] /= factor**order
    return Stages(stages.interval * factor, table, stages.self_motion)


def is_broken(problem: Problem, motion: Stages) -> bool:
    """Whether a motion breaks rows of a problem so far that the multipliers of its own problem are no help.

    The height of a liquid follows from all of the motion before, the rest from the instant: it is harder to mend.
    """
    slack = row_slack(problem, motion)
    return any(value < -(_BROKEN_HEIGHT if key[0] == SloshHeight.name else _BROKEN) for key, value in slack.items())


def slow_enough(problem: Problem, motion: Stages, slowest: float = _SLOWEST) -> Stages:
    """The motion slowed down as little as keeps the rows of the problem; itself if slowing down does not help.

    From a motion that breaks many rows, the first dozen steps of an interior point method each end at the next bound.

    Args:
        problem: whose rows; how it is scaled does not matter.
        motion: on its grid.
        slowest: how many times as slowly at most.
    """

    def keeps(factor: float) -> bool:
        slow = slowed(motion, layout, factor)
        return min(row_slack(problem, slow).values(), default=0.0) >= 0.0

    layout = problem.transcription.layout
    low, high = 1.0, slowest
    if not keeps(high):
        return motion
    for _ in range(_BISECTIONS):
        middle = (low * high) ** 0.5
        low, high = (low, middle) if keeps(middle) else (middle, high)
    return slowed(motion, layout, high)
