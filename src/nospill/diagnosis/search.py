"""Solving changed tasks: how long the fastest motion takes once a limit is wider, and which limit holds it back.

A task that is impossible in the time allowed is possible with more time, and solves well then. So every trial here
leaves the time open and looks at how long the fastest motion takes; a change is enough when that is short enough.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from nospill.laws.constraints.base import RowId
from nospill.robots.joint_paths.search import JointPath
from nospill.robots.kinematics.regularity import determinants, keeps_branch
from nospill.scene.scene import Scene
from nospill.transcription.problem import Problem
from nospill.transcription.solvers import Solution, usable
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import USUAL_START, Start, coarse_start

_MORE_TIME = 8.0
"""Times the longest motion allowed that a trial may take."""
_LEAST_TIME, MOST_TIME = 20.0, 600.0
"""s; bounds of that."""
SLOW = 20.0
"""s; a motion of this length is slow enough to tell what is impossible at any speed."""
_MOST_INTERVALS = 250
"""A trial on more intervals than this takes too long to be worth it."""
_PATIENCE = 80
_STARTS = (USUAL_START, Start(stretch=1.3))
_FURTHER_STARTS = (Start(stretch=0.6, skew=-0.45), Start(stretch=2.0))
"""Of the task itself, where those lead nowhere."""
_STEP = 1e-4
BUDGET = 20.0
"""s of processor time; no new trial begins later than this after the first."""
WITHIN = 0.98
"""Part of the time allowed that a changed task should need: what the fine grid and the judge take on top."""


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """A motion on a grid, and the problem that it answers.

    Attributes:
        solution: what the solver returned.
        problem: that was solved.
    """

    solution: Solution
    problem: Problem


@dataclass(frozen=True, slots=True)
class Trial:
    """A changed scene along one joint path.

    Attributes:
        scene: of the problem: its objects at their stated numbers, with the least friction.
        solve: starting motion, most iterations -> the answer.
    """

    scene: Scene
    solve: Callable[[Stages, int], Answer]


@dataclass(frozen=True, slots=True)
class Searcher:
    """A failed search, and how it tries a changed scene.

    Attributes:
        scene: what was searched for.
        trial: a changed scene along a joint path.
        out_of_time: whether the time of the search is up; a trial has a time of its own.
    """

    scene: Scene
    trial: Callable[[Scene, JointPath], Trial]
    out_of_time: Callable[[], bool]


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """How strongly a subject's budget holds a motion back.

    Attributes:
        elasticity: part by which the duration shrinks over the part by which the budget grows.
        at_s: where on the path it does most.
    """

    elasticity: float
    at_s: float


@dataclass(frozen=True, slots=True)
class Found:
    """A fastest motion of a task with the time left open, and what holds it back."""

    answer: Answer
    sensitivities: dict[RowId, Sensitivity]

    @property
    def stages(self) -> Stages:
        """The motion."""
        return self.answer.solution.stages

    @property
    def duration(self) -> float:
        """Of the motion, s."""
        return self.stages.duration


@dataclass(slots=True)
class Trials:
    """Solves changed tasks along one joint path until its time is up.

    Attributes:
        run: the search that failed.
        joint_path: along which.
    """

    run: Searcher
    joint_path: JointPath
    began: float = field(default_factory=time.process_time)

    @property
    def limit(self) -> float:
        """The longest motion allowed, s."""
        return self.run.scene.motion.longest

    @property
    def over(self) -> bool:
        """Whether the time for trials is up."""
        return time.process_time() - self.began > BUDGET

    def fastest(
        self,
        scene: Scene,
        *,
        near: Stages | None = None,
        longest: float | None = None,
        enough: float | None = None,
        joint_path: JointPath | None = None,
    ) -> Found | None:
        """The fastest motion of a scene with the time left open; None where none is found.

        Args:
            scene: the task, its max_duration aside.
            near: a motion to start from, of the same structure.
            longest: time that is open, s; several times what the task allows when left out.
            enough: duration that ends the search; the first motion found when left out, else the best of all starts.
            joint_path: in place of the one the search failed with.
        """
        if longest is None:
            longest = min(max(_MORE_TIME * self.limit, _LEAST_TIME), MOST_TIME)
        scene = replace(scene, motion=replace(scene.motion, max_duration=longest, duration=None))
        joint_path = joint_path or self.joint_path
        trial = self.run.trial(scene, joint_path)
        kinds = _STARTS if enough is None else (*_STARTS, *_FURTHER_STARTS)
        starts = [coarse_start(trial.scene, joint_path, kind) for kind in kinds]
        best: Found | None = None
        for tried, start in enumerate(([near] if near is not None else []) + starts):
            if best is not None and tried >= len(_STARTS):
                break
            if start.intervals > _MOST_INTERVALS or self.over:
                break
            answer = trial.solve(start, _PATIENCE)
            if usable(answer.solution) and (best is None or answer.solution.stages.duration < best.duration):
                best = Found(answer, _sensitivities(answer))
            if best is not None and (enough is None or best.duration <= enough):
                break
        return best


def _sensitivities(answer: Answer) -> dict[RowId, Sensitivity]:
    """What the multipliers say: by the envelope theorem dT/dp = lambda^T dg/dp, here with p every budget's back-off."""
    solution, stages = answer.solution, answer.solution.stages
    problem = answer.problem
    transcription = problem.transcription
    values = [
        transcription.constraints(solution.variables, parameters)
        for parameters in (
            problem.parameters,
            problem.with_more_backoff(_STEP),
        )
    ]
    if len(solution.multipliers) != len(values[0]):
        return {}
    effect = solution.multipliers * (values[1] - values[0]) / _STEP / stages.duration
    sensitivities: dict[RowId, Sensitivity] = {}
    for row, places, nodes in problem.places:
        per_node = np.bincount(nodes, effect[places])
        at_s = float(stages.table[np.argmax(per_node), 0])
        before = sensitivities.get(row, Sensitivity(0.0, at_s))
        total = float(per_node.sum())
        most = at_s if total > before.elasticity else before.at_s
        sensitivities[row] = Sensitivity(before.elasticity + total, most)
    return sensitivities


def is_possible(search: Searcher, scene: Scene, joint_path: JointPath) -> bool:
    """Whether a motion of a changed scene is found at once, on which the arm keeps its branch."""
    found = Trials(search, joint_path).fastest(scene)
    if found is None or found.duration > WITHIN * scene.motion.longest:
        return False
    if scene.path.joint_curve is not None:
        return True
    # the problem may carry fewer objects than the scene
    layout = found.answer.problem.transcription.layout
    joints = found.stages.table[:-1, layout.joint_position]
    return keeps_branch(determinants(scene.robot, joints, found.stages.self_motion))


def first_share(duration: float, limit: float, elasticity: float) -> float:
    """Part by which a budget has to grow if the duration falls as a power of it; infinite where it hardly does."""
    if elasticity < 1e-3:
        return math.inf
    return math.expm1(min(math.log(duration / (WITHIN * limit)) / elasticity, 50.0))
