"""One call of the planner: search on a coarse grid, refinement, tightening until the judge agrees."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from nospill.errors import NOT_CONVERGED, ModelError, NoSolutionError, Reason
from nospill.judge.certificate import Judgement, judge
from nospill.judge.verdict import Row
from nospill.laws.constraints.residual_height import EndDisplacement
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import structure_of
from nospill.motion.trajectory import Trajectory
from nospill.planning.beside import Beside, beside
from nospill.planning.records import Memory as Memory
from nospill.planning.records import PlanningProgress as PlanningProgress
from nospill.planning.records import Progress as Progress
from nospill.planning.records import Second
from nospill.planning.reserves import falls_short, range_reserves
from nospill.planning.rows import Rows
from nospill.planning.starts import SECOND_ITERATIONS, Attempt, agreed, alike, attempts
from nospill.planning.warm_start import is_broken, slow_enough, with_restart_reserves
from nospill.plans.plan import Plan, PlanningReport, Starts
from nospill.robots.joint_paths.search import JointPath
from nospill.robots.kinematics.regularity import clearance, determinants, keeps_branch
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.transcription.answer import export_samples, with_joints_solved
from nospill.transcription.layout import layout_of
from nospill.transcription.problem import Problem, build_problem
from nospill.transcription.resampling import resample, resolving_intervals
from nospill.transcription.solvers import FEASIBLE, Solution, SolveOptions, row_slack, solve, usable
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import USUAL_START, Start, estimate_duration, smooth_start
from nospill.transcription.trajectory_start import from_trajectory

_ROUNDS = 8
_COARSEST = 25
_COARSE_SWING, _FINE_SWING = 2.5, 0.7
REFINE_BARRIERS = (1e-5, 1e-4, 0.1)
_TIGHTEN_BARRIER = _AGAIN_BARRIER = 1e-6
_NO_ROOM, _ROOM_IF_BROKEN = 1e-6, 0.05
_BROKEN_ITERATIONS, _TIGHTEN_ITERATIONS = 50, 40
REFINE_ITERATIONS = 100
_NEAR_AT_START = 0.75
_LEAST_TIME = 10.0
_TIME_IS_UP = "; the time planning.max_plan_time was up"


@dataclass(slots=True)
class PlanningRun:
    """One call of `plan`: its clock, counters and the steps of the story.

    Where it `forks`, a copy of this process searches from the second start, beside the first. The flange carries
    `payload`, the cargo of the scene where that is None.
    """

    scene: Scene
    progress: Progress | None
    ignored: frozenset[str]
    began: float = field(default_factory=time.perf_counter)
    phases: dict[str, float] = field(default_factory=dict)
    solve_time: float = 0.0
    iterations: int = 0
    rounds: int = 0
    tried: int = 0
    durations: list[float] = field(default_factory=list)
    regular: bool = False
    least_determinant: float = 0.0
    crossed: JointPath | None = None
    asked: Scene | None = None
    forks: bool = False
    payload: tuple[Cargo, ...] | None = None
    last_export: tuple[Stages, Trajectory] | None = None
    rows: Rows = field(init=False)

    def __post_init__(self) -> None:
        self.rows = Rows.of(self.scene, self.ignored)

    @property
    def _time_left(self) -> float:
        return self.began + self.scene.planning.max_plan_time - time.perf_counter()

    @property
    def out_of_time(self) -> bool:
        """Whether the time to look for a motion is up."""
        return self._time_left < 0.0

    @property
    def reserves(self) -> dict[tuple[str, int], float]:
        """Part of every budget that is kept from the optimiser."""
        return self.rows.reserves

    def settle(self, scene: Scene) -> None:
        """Go on with a scene of the same structure."""
        self.scene = scene

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Account the time spent inside to a phase."""
        if self.progress is not None:
            self.progress(PlanningProgress(name))
        start = time.perf_counter()
        try:
            yield
        finally:
            self.phases[name] = self.phases.get(name, 0.0) + time.perf_counter() - start

    def solve(
        self,
        start: Stages,
        *,
        barrier: float | None = None,
        room: float | None = None,
        warm: Solution | None = None,
        iterations: int | None = None,
        by_error: bool = False,
        roughly: bool = False,
    ) -> Solution:
        """Solve on the start's grid, with the rows that are kept; a first barrier alone says that the start is good."""
        options = self.scene.planning
        problem = self.problem(start)
        with self.phase("solve"):
            solution = solve(
                problem,
                start,
                solver=options.solver,
                options=SolveOptions(
                    max_iterations=iterations or options.max_iterations,
                    max_time=min(options.max_solve_time, max(self._time_left, _LEAST_TIME)),
                    barrier_start=barrier,
                    bound_push=_NO_ROOM if room is None and barrier is not None else room,
                    kkt_error_globalization=by_error,
                    loose_tolerances=roughly,
                    progress=self._iteration if self.progress is not None else None,
                ),
                warm=warm,
            )
        self.solve_time += solution.solve_time_s
        self.iterations += solution.iterations
        return solution

    def problem(self, motion: Stages) -> Problem:
        """The problem with the rows that are kept, about a motion."""
        return self._problem(motion, self.rows.active)

    def _problem(self, start: Stages, active: Collection[tuple[str, int]]) -> Problem:
        scene = self.scene
        if EndDisplacement.name in self.ignored:
            # Its equalities are bounds of the variables, which only another end condition takes away.
            scene = replace(scene, motion=replace(scene.motion, end="residual"))
        with self.phase("build"):
            return build_problem(
                scene,
                start.intervals,
                nominal_duration=start.duration,
                backoff=self.reserves,
                active=frozenset(active),
                payload=self.payload,
                exact_rest=self.payload is None or len(scene.cargo) <= len(self.payload),
                self_motion=start.self_motion,
                least_determinant=self.least_determinant if self.regular else None,
            )

    def _slack(self, motion: Stages) -> dict[tuple[str, int], float]:
        """Of every row, kept or not, on a motion."""
        return row_slack(self._problem(motion, self.rows.all), motion)

    def solve_near(self, start: Stages, *, iterations: int, by_error: bool = False) -> Solution:
        """Solve with the rows that come near their limits on the start; what the answer breaks is added, and again.

        Most rows of most objects are far from their limits all the time, and an interior point method pays for each.
        """
        self._join_near(start)
        return self._solved_with_broken(start, iterations=iterations, by_error=by_error)

    def _join_near(self, start: Stages) -> None:
        """Keep the rows that come near their limits on a start."""
        # The start's liquids are at rest: their height says nothing.
        slack = self._slack(start)
        near = {key for key, value in slack.items() if value <= _NEAR_AT_START or key[0] == SloshHeight.name}
        self.rows.kept = (self.rows.kept | near) & self.rows.all

    def _solved_with_broken(self, start: Stages, *, iterations: int, by_error: bool) -> Solution:
        rows, barrier = self.rows, None
        while True:
            solution = self.solve(start, barrier=barrier, iterations=iterations, by_error=by_error)
            if not usable(solution):
                return solution
            solution = replace(solution, slack=self._slack(solution.stages))
            broken = {key for key, value in solution.slack.items() if value < -FEASIBLE} & rows.all
            if broken <= rows.kept:
                return solution
            rows.kept |= broken
            start, barrier = solution.stages, REFINE_BARRIERS[1]

    def _determinants(self, stages: Stages) -> np.ndarray:
        layout = layout_of(structure_of(self.scene))
        return determinants(self.scene.robot, stages.table[:-1, layout.joint_position], stages.self_motion)

    def _keeps_branch(self, stages: Stages) -> bool:
        return keeps_branch(self._determinants(stages))

    def _iteration(self, iteration: int, duration: float, violation: float) -> None:
        if self.progress is not None:
            self.progress(PlanningProgress("solve", iteration, duration, violation))

    def trial(self, scene: Scene) -> PlanningRun:
        """A run of its own on a scene, which reports to the same place; what it learns does not come back."""
        other = PlanningRun(scene, self.progress, self.ignored, payload=self.payload)
        other.regular, other.rows.kept = self.regular, set()
        return other

    def is_possible(self, scene: Scene, joint_path: JointPath) -> bool:
        """Whether a motion of a scene is found at once; what is learnt of it does not come back."""
        from nospill.diagnosis.search import WITHIN, Trials

        found = Trials(self, joint_path).fastest(scene)
        if found is None or found.duration > WITHIN * scene.motion.max_duration:
            return False
        return self._keeps_branch(found.solution.stages)

    def start(self, joint_path: JointPath, start: Start = USUAL_START) -> Stages:
        """A smooth starting motion on the coarse grid."""
        expected = estimate_duration(self.scene, joint_path)
        fewest = resolving_intervals(self.scene, expected, _COARSE_SWING)
        motion = smooth_start(self.scene, joint_path, max(_COARSEST, self.scene.planning.intervals // 4, fewest), start)
        values = self._determinants(motion)
        if self.scene.motion.tilt_free and values[0] * values[-1] > 0.0 and not keeps_branch(values):
            values = values[[0, -1]]  # a tray that may lean gets round a singularity it does not end behind
        self.least_determinant = clearance(values)
        # A seventh joint gets past by itself.
        self.crossed = None if motion.self_motion is not None or keeps_branch(values) else joint_path
        for key, room in range_reserves(self.scene, joint_path).items():
            self.reserves[key] = min(self.reserves[key], room)
        return motion

    def find(self, joint_path: JointPath) -> Solution:
        """Search and refine; once more with the arm kept regular if the motion leaves its branch.

        Each instant of a problem sees its own joints only: a motion can hop between branches, or run through a
        singularity, between two of them. Most motions do neither, and the rows against it are left out. They cannot
        hold where the path itself leads through a singularity. A level tray goes through by its joint path, a leaning
        one would need joints without a limit of speed: it leans past the singularity, or else stays level.
        """
        values = self._determinants(self.start(joint_path))
        singular = not (len(self.scene.robot.joints) > 6 or keeps_branch(values))
        may_lean = self.scene.motion.tilt_free and singular
        if may_lean and self.crossed is not None:
            return self._found_level(joint_path)
        coarse = self.search(joint_path)
        if self.crossed or self._keeps_branch(coarse.stages):
            fine = self.refine(coarse)
            if self.crossed or self._is_playable(fine):
                return fine
        self.regular = True
        if not may_lean:
            return self.refine(self.search(joint_path))
        try:
            fine = self.refine(self.search(joint_path, briefly=True))
        except NoSolutionError:
            return self._found_level(joint_path)
        return fine if self._is_playable(fine) else self._found_level(joint_path)

    def _found_level(self, joint_path: JointPath) -> Solution:
        """The same where the tray, though it might lean, stays level."""
        self.asked, self.regular = self.scene, False
        self.scene = replace(self.scene, motion=replace(self.scene.motion, tilt_free=False))
        self.rows = Rows.of(self.scene, self.ignored)
        return self.refine(self.search(joint_path))

    def _is_playable(self, solution: Solution) -> bool:
        """Whether the arm follows between the nodes as well, on its branch."""
        try:
            joints = self.exported(solution.stages).joint_position
        except ModelError:
            return False
        return keeps_branch(determinants(self.scene.robot, joints, solution.stages.self_motion))

    def search(self, joint_path: JointPath, *, briefly: bool = False) -> Solution:
        """Solve from several starts on a coarse grid and return the best answer.

        Raises:
            NoSolutionError: there is none; where the search is brief, without much of a reason.
        """
        options = self.scene.planning
        self.durations.clear()
        self.rows.kept = set()
        tried, expected = 0, estimate_duration(self.scene, joint_path)
        # Where even the estimate reaches the longest motion allowed, a look at that motion saves a long vain search.
        if expected >= 0.79 * self.scene.motion.max_duration and self._is_hopeless(joint_path):
            return self._overlooked(joint_path, None)
        best: Solution | None = None
        last: Solution | None = None
        planned = attempts(self.scene, briefly=briefly)
        first, second = planned[0], planned[1] if min(options.starts, len(planned)) > 1 else None
        forks = self.forks and self._is_compiled(joint_path)
        with beside(partial(self._second, joint_path, first, second) if forks and second else None) as other:
            for attempt in planned:
                if (tried >= options.starts and best is not None) or (tried and self.out_of_time):
                    break
                if attempt.all_rows:
                    self.rows.keep_all()
                motion = self.start(joint_path, attempt.start)
                last = self._taken(other, best) if attempt is second and other is not None else None
                if last is None:
                    iterations = attempt.iterations if best is None else SECOND_ITERATIONS
                    last = self.solve_near(motion, iterations=iterations, by_error=attempt.by_error)
                tried += 1
                if usable(last):
                    self.durations.append(last.stages.duration)
                    if best is None or last.objective < best.objective:
                        best = last
                elif best is None and self._is_hopeless(joint_path):
                    break
                if agreed(self.scene, self.durations):
                    break
        self.tried += tried
        if best is None and briefly:
            raise NoSolutionError("No motion found at once.")
        return self._overlooked(joint_path, last) if best is None else best

    def _is_compiled(self, joint_path: JointPath) -> bool:
        """Whether machine code serves the problem; CasADi's virtual machine keeps all cores busy by itself."""
        return self._problem(self.start(joint_path), self.rows.all).transcription.stage.compiled

    def _second(self, joint_path: JointPath, first: Attempt, second: Attempt) -> Second:
        """In a copy of this process: from the second start, as if the first had an answer that breaks no other rows."""
        self.progress, self.iterations, self.solve_time = None, 0, 0.0
        for attempt in (first, second):
            motion = self.start(joint_path, attempt.start)
            self._join_near(motion)
        joined = set(self.rows.kept)
        solution = self._solved_with_broken(motion, iterations=SECOND_ITERATIONS, by_error=second.by_error)
        return Second(solution, joined, self.rows.kept, self.iterations, self.solve_time)

    def _taken(self, other: Beside[Second], best: Solution | None) -> Solution | None:
        """The copy's answer, if it is what would come out here; None where it must be solved here."""
        with self.phase("solve"):
            found = other.result() if best is not None else other.stop()
        if found is None or not self.rows.kept <= found.joined:
            return None
        self.rows.kept = found.kept
        self.iterations, self.solve_time = self.iterations + found.iterations, self.solve_time + found.solve_time
        return found.solution

    def _is_hopeless(self, joint_path: JointPath) -> bool:
        from nospill import diagnosis  # loaded where something is wrong

        return diagnosis.is_hopeless(self.scene, joint_path, self.payload)

    def _overlooked(self, joint_path: JointPath, last: Solution | None) -> Solution:
        from nospill import diagnosis

        found = diagnosis.last_resort(self, joint_path, last)
        self.durations.append(found.stages.duration)
        return found

    def memory(self, solution: Solution) -> Memory:
        """What the next run on a similar scene may start from."""
        return Memory(structure_of(self.scene), solution, frozenset(self.rows.kept), dict(self.reserves))

    def restart(self, earlier: Plan, memory: Memory | None) -> Solution | None:
        """Solve from an earlier plan, with its multipliers where they are at hand; None where neither converges."""
        if memory is not None and memory.structure == structure_of(self.scene) and not self.ignored:
            self.rows.kept = set(memory.kept)
            self.rows.reserves = with_restart_reserves(memory.reserves)
            if self._wanted_intervals(earlier.duration) == memory.solution.stages.intervals:
                found = self._restarted(memory.solution.stages, warm=memory.solution)
                if found is not None:
                    return found
        self.rows.keep_near(earlier.certificate.rows)
        self.rows.recall(earlier.report.reserves)
        self.rows.reserves = with_restart_reserves(self.reserves)
        start = from_trajectory(self.scene, earlier.trajectory, self._wanted_intervals(earlier.duration))
        found = self._restarted(start, warm=None)
        if found is None:
            self.rows.keep_all()
        return found

    def _wanted_intervals(self, duration: float) -> int:
        return max(self.scene.planning.intervals, resolving_intervals(self.scene, duration, _FINE_SWING))

    def _restarted(self, start: Stages, *, warm: Solution | None) -> Solution | None:
        """Solve from a motion of an earlier scene, slowed down if the new one has tighter limits."""
        self.tried += 1
        problem = self.problem(start)
        if is_broken(problem, start):
            start = slow_enough(problem, start)
            solution = self.solve(start, room=_ROOM_IF_BROKEN, warm=warm, iterations=_BROKEN_ITERATIONS, roughly=True)
            if not solution.converged:
                solution = self.solve(start, barrier=REFINE_BARRIERS[1], iterations=REFINE_ITERATIONS)
        else:
            barrier = _AGAIN_BARRIER if warm else REFINE_BARRIERS[0]
            solution = self.solve(start, barrier=barrier, warm=warm, iterations=REFINE_ITERATIONS, roughly=True)
        if not (usable(solution) and solution.converged and self._keeps_branch(solution.stages)):
            return None
        self.durations.append(solution.stages.duration)
        return solution

    def refine(self, coarse: Solution) -> Solution:
        """Carry the coarse answer to the full grid, or as far as that goes: the judge does not ask for a grid."""
        fewest = resolving_intervals(self.scene, coarse.stages.duration, _FINE_SWING)
        wanted = max(self.scene.planning.intervals, fewest)
        first = self._refined(coarse.stages, wanted, self.rows.close(coarse.slack))
        if first is not None:
            return first
        middle = max(wanted // 2, coarse.stages.intervals)
        halfway = self._refined(coarse.stages, middle, self.rows.all)
        last = None if halfway is None else self._refined(halfway.stages, wanted, self.rows.all)
        return last or halfway or coarse

    def _refined(self, start: Stages, intervals: int, kept: set[tuple[str, int]]) -> Solution | None:
        """Solve with some rows from a motion on another grid; None where no barrier to begin with leads anywhere."""
        self.rows.kept = set(kept)
        start = resample(start, layout_of(structure_of(self.scene)), intervals)
        start = with_joints_solved(self.scene, start, self.crossed)
        for barrier in REFINE_BARRIERS:
            if self.out_of_time:
                break
            solution = self.solve(start, barrier=barrier, iterations=REFINE_ITERATIONS)
            if usable(solution) and solution.converged:
                return solution
        return None

    def tighten(self, solution: Solution) -> tuple[Trajectory, Judgement, Solution]:
        """Judge, keep back more of what was exceeded, solve again, until the judge agrees."""
        try:
            return self._tightened(solution)
        except ModelError as error:
            raise NoSolutionError(
                f"No motion found: one of {solution.stages.duration:.3f} s on {solution.stages.intervals} intervals "
                f"cannot be played, {error}. Try another planning.intervals or a path away from singularities.",
                Reason(NOT_CONVERGED, "singularity", self.scene.robot.name),
            ) from None

    def _tightened(self, solution: Solution) -> tuple[Trajectory, Judgement, Solution]:
        trajectory, judgement = self._judged(solution)
        last = self.rounds + _ROUNDS
        while (objections := self._objections(judgement)) and self.rounds < last and not self.out_of_time:
            kept = len(self.rows.kept)
            if not self.rows.answer(objections):
                break
            self.rounds += 1
            rows = len(self.problem(solution.stages).transcription.lower)
            if len(self.rows.kept) == kept and len(solution.multipliers) == rows:
                again = self.solve(
                    solution.stages, barrier=_TIGHTEN_BARRIER, warm=solution, iterations=_TIGHTEN_ITERATIONS
                )
            else:
                again = self.solve(solution.stages, barrier=REFINE_BARRIERS[0], iterations=REFINE_ITERATIONS)
            if not usable(again) or not again.converged:
                again = self.solve(solution.stages)
            if not usable(again):
                break
            solution = again
            trajectory, judgement = self._judged(solution)
        return trajectory, judgement, solution

    def _judged(self, solution: Solution) -> tuple[Trajectory, Judgement]:
        with self.phase("export"):
            trajectory = self.exported(solution.stages)
        with self.phase("certify"):
            return trajectory, judge(trajectory, self.asked or self.scene)

    def exported(self, stages: Stages) -> Trajectory:
        """The samples of a motion."""
        if self.last_export is None or self.last_export[0] is not stages:
            # where joints cross a singularity, no instant of the problem knows on which branch the one before was
            solved = stages if self.crossed is None else with_joints_solved(self.scene, stages, self.crossed)
            self.last_export = stages, export_samples(self.scene, solved)
        return self.last_export[1]

    def _objections(self, judgement: Judgement) -> list[Row]:
        """The rows that fail or come too near to it, by the subjects of the run's scene."""
        return [row for row in judgement.certificate.rows if falls_short(row)]

    def report(self, solution: Solution) -> PlanningReport:
        """What it cost."""
        return PlanningReport(
            plan_time=time.perf_counter() - self.began,
            solve_time=self.solve_time,
            iterations=self.iterations,
            rounds=self.rounds,
            starts=Starts(self.tried, len(self.durations), alike(self.durations), tuple(self.durations)),
            phases=dict(self.phases),
            solver_status=solution.status + (_TIME_IS_UP if self.out_of_time else ""),
            reserves=self.rows.raised(),
        )
