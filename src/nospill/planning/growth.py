"""Planning with fewer objects than the judge looks at: those he objects to join the problem.

An iteration of the optimiser takes longer with every object, and few of them ever matter. So a run solves with some
of them; the judge looks at all; what he objects to is taken into the problem, which is solved again from the motion at
hand, until he objects to none.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from nospill.errors import NoSolutionError
from nospill.judge.certificate import Judgement, constraint_traces, judge
from nospill.judge.replay import replay
from nospill.judge.verdict import Row
from nospill.laws.constraints.base import Place
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import structure_of
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.planning.rows import Rows
from nospill.planning.run import REFINE_BARRIERS, REFINE_ITERATIONS, PlanningRun
from nospill.robots.kinematics.regularity import clearance
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.transcription.solvers import Solution, usable
from nospill.transcription.trajectory_start import from_trajectory

_GROWTHS = 12

Key = TypeVar("Key")
"""What names something that can join the problem."""


@dataclass(slots=True, kw_only=True)
class GrowingRun(PlanningRun, ABC, Generic[Key]):
    """A run whose scene holds some of the objects.

    Attributes:
        whole: the scene that is judged.
    """

    whole: Scene

    def settle(self, scene: Scene) -> None:
        """Go on with a scene that differs in the robot only."""
        self.whole, self.scene = scene, replace(self.scene, robot=scene.robot)

    @abstractmethod
    def missing(self, judgement: Judgement) -> set[Key]:
        """What the judge objects to and is not in the problem."""

    @abstractmethod
    def choose(self, wanted: Iterable[Key]) -> None:
        """Take some more into the problem."""

    @abstractmethod
    def problem_rows(self, judgement: Judgement) -> list[Row]:
        """The rows of a verdict that speak of what is in the problem, by the names it has there."""

    @abstractmethod
    def start_tracks(self, trajectory: Trajectory) -> Mapping[str, SloshTrack]:
        """The liquids of the problem along a motion of the whole scene, by the names they have in the problem."""

    @abstractmethod
    def nothing_holds(self, trajectory: Trajectory, judgement: Judgement) -> NoSolutionError:
        """The error where a motion was found without what is missing, and none with it."""

    def tighten(self, solution: Solution) -> tuple[Trajectory, Judgement, Solution]:
        """Tighten; bring into the problem what the judge objects to; until he objects to none.

        Raises:
            NoSolutionError: a motion was found without what is missing, but none with it.
        """
        trajectory, judgement, solution = PlanningRun.tighten(self, solution)
        for _ in range(_GROWTHS):
            wanted = self.missing(judgement)
            if not wanted:
                break
            self.choose(wanted)
            grown = self.solved_from(trajectory, judgement)
            if grown is None:
                raise self.nothing_holds(trajectory, judgement)
            self.rounds += 1
            trajectory, judgement, solution = PlanningRun.tighten(self, grown)
        return trajectory, judgement, solution

    def _judged(self, solution: Solution) -> tuple[Trajectory, Judgement]:
        with self.phase("export"):
            trajectory = self.recorded(self.exported(solution.stages))
        with self.phase("certify"):
            return trajectory, judge(trajectory, self.whole)

    def recorded(self, trajectory: Trajectory) -> Trajectory:
        """The trajectory with the liquids of the whole scene, which is what a plan records."""
        names = {cargo.name: cargo.name for cargo in self.whole.cargo}
        return replace(trajectory, slosh=tracks(trajectory, self.whole, names))

    def set_cargo(self, cargo: tuple[Cargo, ...]) -> None:
        """Let the problem hold other objects, with the reserves that are known."""
        known = self.rows.labelled()
        self.scene = replace(self.scene, cargo=cargo)
        self.rows = Rows.of(self.scene, self.ignored)
        self.rows.recall(known)

    def solved_from(self, trajectory: Trajectory, judgement: Judgement) -> Solution | None:
        """Solve on the full grid from a motion of the whole scene; None where nothing converges."""
        self.rows.keep_near(self.problem_rows(judgement))
        with self.phase("corners"):
            slosh = dict(self.start_tracks(trajectory))
        start = from_trajectory(
            self.scene, replace(trajectory, slosh=slosh), self._wanted_intervals(trajectory.end_time)
        )
        if not self.least_determinant:
            self.least_determinant = clearance(self._determinants(start))
        for barrier in (*REFINE_BARRIERS, None):
            if self.out_of_time:
                break
            solution = self.solve(start, barrier=barrier, iterations=REFINE_ITERATIONS)
            if usable(solution) and solution.converged:
                if self.regular or self._keeps_branch(solution.stages):
                    return solution
                self.regular = True
        return None


def tracks(trajectory: Trajectory, scene: Scene, names: Mapping[str, str]) -> dict[str, SloshTrack]:
    """The liquids of a scene along a motion as the judge integrates them, at the samples.

    Args:
        trajectory: the motion; its own liquids are not read.
        scene: whose liquids.
        names: object -> what its track is called; others are left out.
    """
    played = replay(trajectory, scene)
    every = round(played.rate / trajectory.rate)
    traces = constraint_traces(trajectory, scene, played, places=(Place.OBJECT,))
    heights = {trace.subject: trace.value[::every] for trace in traces if trace.constraint == SloshHeight.name}
    found, first = {}, 0
    for cargo, item in zip(scene.cargo, structure_of(scene).objects, strict=True):
        own = slice(first, first + item.coordinates)
        first = own.stop
        if item.oscillators and cargo.name in names:
            parts = (played.slosh_displacement[::every, own], played.slosh_velocity[::every, own])
            found[names[cargo.name]] = SloshTrack(*parts, heights[cargo.name])
    return found
