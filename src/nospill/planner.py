"""The story of a plan: starts on a coarse grid, the best one refined, judged, tightened until the judge agrees."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from nospill.approaching import require_possible, starts_alike, with_approach
from nospill.base_yaw import base_yaw_text, has_free_base, settled_base
from nospill.certificate import Certificate, Judgement, judge
from nospill.constraints import CONSTRAINTS
from nospill.constraints.residual_height import EndDisplacement
from nospill.constraints.slosh_height import SloshHeight
from nospill.errors import ModelError, NoSolutionError, ScenarioError
from nospill.ocp.answer import export_samples
from nospill.ocp.guess import Start, estimate_duration, from_trajectory, resample, smooth_start
from nospill.ocp.layout import layout_of
from nospill.ocp.problem import Problem, Reserves, build_problem
from nospill.ocp.stages import Stages
from nospill.plans import Plan, PlanningReport, Starts, describe, motion_maxima
from nospill.robots.inverse import JointPath, branch_in_words, joint_paths, preferred_path
from nospill.robots.regularity import clearance, determinants, keeps_branch
from nospill.scene import Scene
from nospill.scene_numbers import structure_of
from nospill.solvers import Solution, SolveOptions, row_slack, solve
from nospill.trajectory import Trajectory

FIRST_RESERVE = 1e-3
FIRST_RESERVES = {"slip": 4.5e-3, "tip": 4e-3, "slosh height": 1.5e-3, "joint acceleration": 8e-3}
"""Fraction of every budget kept from the optimiser at first, by constraint where it is not `FIRST_RESERVE`.

It is what limits typically exceed between grid points and where the spline through the samples rounds the corners of
the jerk, measured on the examples: enough for most motions to be certified at once, little enough to cost less than a
thousandth of the duration.
"""

_UNBOUNDED = -1e3
_ROUNDS = 8
_FEASIBLE = 1e-5
_AGREEMENT = 5e-3
_COARSEST = 25
_COARSE_SWING = 2.5
_FINE_SWING = 0.7
_COARSE_ITERATIONS = 150
_LAST_ITERATIONS = 500
_LAST_STARTS = 4
_REFINE_BARRIERS = (1e-5, 1e-4, 0.1)
_TIGHTEN_BARRIER = 1e-6
_TIGHTEN_ITERATIONS = 40
_REFINE_ITERATIONS = 100
_FIXED_STARTS = (Start(stretch=0.7), Start(stretch=0.6, skew=-0.45), Start(stretch=0.5, skew=0.25))
_SAME = 1e-3
_NEAR = 0.3
_NEAR_AT_START = 0.75


@dataclass(frozen=True, slots=True)
class PlanningProgress:
    """Where planning stands.

    The phase and, while solving, iteration, current end time (s) and largest scaled violation.
    """

    phase: str
    iteration: int | None = None
    duration_s: float | None = None
    violation: float | None = None


Progress = Callable[[PlanningProgress], None]


def plan(
    scene: Scene, *, warm: Plan | None = None, ignore: Collection[str] = (), progress: Progress | None = None
) -> Plan:
    """Find the fastest motion of a scene that the judge certifies.

    Args:
        scene: the task.
        warm: an earlier plan of a similar scene (same robot, tilt and liquids), from which to start instead of
            searching; where that leads nowhere, the search is made all the same.
        ignore: names of constraints the optimiser leaves out, to see what they cost. The judge leaves out none.
        progress: called with where planning stands.

    Returns:
        The plan. If the judge still objects after the last tightening, the plan says so: status "uncertified".

    Raises:
        ScenarioError: the robot cannot follow the path, or `ignore` names no constraint.
        NoSolutionError: no start led to a motion, or no approach to it; names what is in the way.
        MissingExtraError: an approach is asked for, and ruckig is not installed.
    """
    unknown = set(ignore) - {constraint.name for constraint in CONSTRAINTS}
    if unknown:
        known = ", ".join(constraint.name for constraint in CONSTRAINTS)
        raise ScenarioError(f'ignore: "{sorted(unknown)[0]}" is no constraint; there are: {known}')
    require_possible(scene)
    run, base_is_free = _Run(scene, progress, frozenset(ignore)), has_free_base(scene)
    if base_is_free:
        with run.phase("base yaw"):
            run.scene = scene = settled_base(scene)
    # a plan on a branch chosen for another start of the arm is no place to go on from
    solution = run.restart(warm) if warm is not None and starts_alike(warm.scene, scene) else None
    if solution is None:
        with run.phase("kinematics"):
            paths = joint_paths(
                scene.robot, scene.path, tool_position=scene.tray.offset, tool_yaw=scene.tray.yaw_on_flange
            )
            joint_path = preferred_path(paths, scene.robot, scene.start_near)
        solution = run.find(joint_path)
    trajectory, judgement, solution = run.tighten(solution)
    found = Plan(
        scene=scene,
        trajectory=trajectory,
        certificate=judgement.certificate,
        maxima=motion_maxima(judgement, scene),
        report=run.report(solution),
        judgement=judgement,
    )
    if scene.approach is not None:
        with run.phase("approach"):
            found = with_approach(found)
    chosen = {"branch": branch_in_words(trajectory.joint_position[0])}
    if base_is_free:
        chosen["base_yaw"] = base_yaw_text(scene)
    return replace(found, report=replace(run.report(solution), **chosen))


class Planner:
    """Plans scene after scene, each from the answer before where the structure is the same.

    Not thread-safe: one per thread.
    Compiled functions are shared by all planners of a process anyway; what a planner keeps is the last plan.
    """

    def __init__(self, last: Plan | None = None) -> None:
        """Start with nothing, or with an earlier plan (for example `load_plan(folder)`)."""
        self.last = last

    def plan(self, scene: Scene, *, progress: Progress | None = None) -> Plan:
        """`plan(scene)`, warm from the last plan if that was of the same structure; raises the same."""
        similar = self.last is not None and structure_of(self.last.scene) == structure_of(scene)
        self.last = plan(scene, warm=self.last if similar else None, progress=progress)
        return self.last


@dataclass(slots=True)
class _Run:
    """One call of `plan`: its clock, counters and the steps of the story."""

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
    reserves: Reserves = field(default_factory=dict)
    kept: set[tuple[str, int]] = field(default_factory=set)
    regular: bool = False
    least_determinant: float = 0.0

    def __post_init__(self) -> None:
        counts = {constraint.name: len(constraint.subjects(self.scene)) for constraint in CONSTRAINTS}
        self.reserves = {(name, index): first_reserve(name) for name, count in counts.items() for index in range(count)}
        self._keep_all()
        # Rows at the end always stand in the problem; a budget a thousand times as large leaves them without effect.
        self.reserves |= {key: _UNBOUNDED for key in self.reserves if key[0] in self.ignored}

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
        warm: Solution | None = None,
        iterations: int | None = None,
    ) -> Solution:
        """Solve on the start's grid, with the rows that are kept."""
        options = self.scene.planning
        problem = self._problem(start, self.kept)
        with self.phase("solve"):
            solution = solve(
                problem,
                start,
                solver=options.solver,
                options=SolveOptions(
                    max_iterations=iterations or options.max_iterations,
                    max_time=options.max_solve_time,
                    barrier_start=barrier,
                    progress=self._iteration if self.progress is not None else None,
                ),
                warm=warm,
            )
        self.solve_time += solution.solve_time_s
        self.iterations += solution.iterations
        return solution

    def _problem(self, start: Stages, kept: Collection[tuple[str, int]]) -> Problem:
        scene = self.scene
        if EndDisplacement.name in self.ignored:
            # Its equalities are bounds of the variables, which only another end condition takes away.
            scene = replace(scene, motion=replace(scene.motion, end="residual"))
        with self.phase("build"):
            return build_problem(
                scene,
                start.intervals,
                nominal_duration=start.duration,
                reserves=self.reserves,
                kept=frozenset(kept),
                self_motion=start.self_motion,
                least_determinant=self.least_determinant if self.regular else None,
            )

    def _slack(self, motion: Stages) -> dict[tuple[str, int], float]:
        """Of every row, kept or not, on a motion."""
        return row_slack(self._problem(motion, self._all()), motion)

    def solve_near(self, start: Stages, *, iterations: int) -> Solution:
        """Solve with the rows that come near their limits on the start; what the answer breaks is added, and again.

        Most rows of most objects are far from their limits all the time, and an interior point method pays for each.
        """
        slack = self._slack(start)
        # The start's liquids are at rest: their height says nothing.
        self.kept |= {key for key, value in slack.items() if value <= _NEAR_AT_START or key[0] == SloshHeight.name}
        self.kept &= self._all()
        barrier: float | None = None
        while True:
            solution = self.solve(start, barrier=barrier, iterations=iterations)
            if not _usable(solution):
                return solution
            solution = replace(solution, slack=self._slack(solution.stages))
            broken = {key for key, value in solution.slack.items() if value < -_FEASIBLE} & self._all()
            if broken <= self.kept:
                return solution
            self.kept |= broken
            start, barrier = solution.stages, _REFINE_BARRIERS[1]

    def _determinants(self, stages: Stages) -> np.ndarray:
        layout = layout_of(structure_of(self.scene))
        return determinants(self.scene.robot, stages.table[:-1, layout.joint_position], stages.self_motion)

    def _keeps_branch(self, stages: Stages) -> bool:
        return keeps_branch(self._determinants(stages))

    def _iteration(self, iteration: int, duration: float, violation: float) -> None:
        if self.progress is not None:
            self.progress(PlanningProgress("solve", iteration, duration, violation))

    def find(self, joint_path: JointPath) -> Solution:
        """Search and refine; once more with the arm kept regular if the motion leaves its branch.

        Each instant of a problem sees its own joints only: a motion can hop between branches, or run through a
        singularity, between two of them. Most motions do neither, and the rows against it are left out.
        """
        coarse = self.search(joint_path)
        if self._keeps_branch(coarse.stages):
            fine = self.refine(coarse)
            if self._keeps_branch(fine.stages):
                return fine
        self.regular = True
        return self.refine(self.search(joint_path))

    def search(self, joint_path: JointPath) -> Solution:
        """Solve from several starts on a coarse grid and return the best answer."""
        options = self.scene.planning
        self.durations.clear()
        self.kept = set()
        tried = 0
        expected = estimate_duration(self.scene, joint_path)
        # Where even the estimate reaches the longest motion allowed, a look at that motion saves a long vain search.
        if expected >= 0.79 * self.scene.motion.max_duration and self._hopeless(joint_path):
            raise NoSolutionError(self._reason(None, joint_path))
        intervals = max(_COARSEST, options.intervals // 4, _resolving(self.scene, expected, _COARSE_SWING))
        best: Solution | None = None
        last: Solution | None = None
        for start in _starts(self.scene):
            if tried >= options.starts and best is not None:
                break
            patience = _COARSE_ITERATIONS if tried < options.starts else _LAST_ITERATIONS
            tried += 1
            motion = smooth_start(self.scene, joint_path, intervals, start)
            self.least_determinant = clearance(self._determinants(motion))
            last = self.solve_near(motion, iterations=patience)
            if _usable(last):
                self.durations.append(last.stages.duration)
                if best is None or last.objective < best.objective:
                    best = last
            elif best is None and self._hopeless(joint_path):
                break
            if self._agreed():
                break
        self.tried += tried
        if best is None:
            assert last is not None
            raise NoSolutionError(self._reason(last, joint_path))
        return best

    def _agreed(self) -> bool:
        """Two starts with the same end are enough, except for perfectly still liquids, which have poor local minima."""
        if self.scene.motion.end == "still" and any(cargo.filling for cargo in self.scene.cargo):
            return False
        return sum(duration <= min(self.durations) * (1 + _SAME) for duration in self.durations) >= 2

    def restart(self, earlier: Plan) -> Solution | None:
        """Solve from an earlier plan; None where that does not converge."""
        self._keep_near(earlier.certificate)
        self._recall(earlier.report.reserves)
        fewest = _resolving(self.scene, earlier.duration, _FINE_SWING)
        start = from_trajectory(self.scene, earlier.trajectory, max(self.scene.planning.intervals, fewest))
        self.tried += 1
        solution = self.solve(start, barrier=_REFINE_BARRIERS[0], iterations=_REFINE_ITERATIONS)
        if _usable(solution) and solution.converged and self._keeps_branch(solution.stages):
            self.durations.append(solution.stages.duration)
            return solution
        self._keep_all()
        return None

    def _recall(self, reserves: dict[str, float]) -> None:
        for key in self.reserves:
            self.reserves[key] = max(self.reserves[key], reserves.get(self._label(key), 0.0))

    def _label(self, key: tuple[str, int]) -> str:
        subjects = next(item.subjects(self.scene) for item in CONSTRAINTS if item.name == key[0])
        return f"{key[0]} | {subjects[key[1]]}"

    def _all(self) -> set[tuple[str, int]]:
        return {key for key in self.reserves if key[0] not in self.ignored}

    def _keep_all(self) -> None:
        self.kept = self._all()

    def _keep_near(self, certificate: Certificate) -> None:
        """Leave rows far from their limits to the judge: they come back if he objects. Fewer rows, faster steps."""
        subjects = {constraint.name: constraint.subjects(self.scene) for constraint in CONSTRAINTS}
        for row in certificate.rows:
            own = subjects.get(row.constraint, ())
            if row.subject in own and row.use < 1 - _NEAR:
                self.kept.discard((row.constraint, own.index(row.subject)))

    def refine(self, coarse: Solution) -> Solution:
        """Carry the coarse answer to the full grid."""
        fewest = _resolving(self.scene, coarse.stages.duration, _FINE_SWING)
        intervals = max(self.scene.planning.intervals, fewest)
        self.kept = {key for key, slack in coarse.slack.items() if slack <= _NEAR} & self._all()
        start = resample(coarse.stages, layout_of(structure_of(self.scene)), intervals)
        solution = coarse
        for barrier in (*_REFINE_BARRIERS, None):
            solution = self.solve(start, barrier=barrier, iterations=_REFINE_ITERATIONS)
            if _usable(solution) and solution.converged:
                return solution
        raise NoSolutionError(
            f"No motion found on {intervals} intervals, though one exists on {coarse.stages.intervals} "
            f"({coarse.stages.duration:.3f} s): {solution.status}. Try another planning.intervals."
        )

    def tighten(self, solution: Solution) -> tuple[Trajectory, Judgement, Solution]:
        """Judge, keep back more of what was exceeded, solve again, until the judge agrees."""
        trajectory, judgement = self._judged(solution)
        while not judgement.certificate.ok and self.rounds < _ROUNDS:
            kept = len(self.kept)
            if not self._raise_reserves(judgement.certificate):
                break
            self.rounds += 1
            if len(self.kept) == kept:
                again = self.solve(
                    solution.stages, barrier=_TIGHTEN_BARRIER, warm=solution, iterations=_TIGHTEN_ITERATIONS
                )
            else:
                again = self.solve(solution.stages, barrier=_REFINE_BARRIERS[0], iterations=_REFINE_ITERATIONS)
            if not _usable(again) or not again.converged:
                again = self.solve(solution.stages)
            if not _usable(again):
                break
            solution = again
            trajectory, judgement = self._judged(solution)
        return trajectory, judgement, solution

    def _judged(self, solution: Solution) -> tuple[Trajectory, Judgement]:
        with self.phase("export"):
            trajectory = export_samples(self.scene, solution.stages)
        with self.phase("certify"):
            return trajectory, judge(trajectory, self.scene)

    def _raise_reserves(self, certificate: Certificate) -> bool:
        """Take back rows that were left out, raise the reserve of the others; whether there was any to act on."""
        raised = False
        subjects = {constraint.name: constraint.subjects(self.scene) for constraint in CONSTRAINTS}
        for row in certificate.rows:
            if row.ok or row.constraint not in subjects or row.constraint in self.ignored:
                continue
            key = (row.constraint, subjects[row.constraint].index(row.subject))
            if key in self.kept:
                exceeded = -row.worst_margin / (abs(row.limit) or 1.0)
                self.reserves[key] += min(2.0 * exceeded + 5e-4, 0.1)
            self.kept.add(key)
            raised = True
        return raised

    def _slow_verdict(self, joint_path: JointPath) -> Certificate | None:
        """What the judge says of the slowest smooth motion; None if the liquids cannot even be integrated."""
        slow = smooth_start(self.scene, joint_path, 100, Start(stretch=1e6))
        try:
            verdict = judge(export_samples(self.scene, slow), self.scene).certificate
        except ModelError:
            return None
        names = {constraint.name for constraint in CONSTRAINTS}
        rows = tuple(row for row in verdict.rows if row.constraint in names)
        return Certificate(all(row.ok for row in rows), verdict.grid_hz, rows)

    def _hopeless(self, joint_path: JointPath) -> bool:
        """Even the slowest smooth motion breaks a limit several times over."""
        verdict = self._slow_verdict(joint_path)
        return verdict is not None and verdict.worst.worst_margin < -abs(verdict.worst.limit)

    def _reason(self, last: Solution | None, joint_path: JointPath) -> str:
        verdict = self._slow_verdict(joint_path)
        limit = self.scene.motion.max_duration
        if verdict is not None and not verdict.ok:
            return (
                f"No motion found: {describe(verdict.worst)} even in a smooth motion of {0.95 * limit:.3g} s, "
                f"nearly the longest allowed (max_duration {limit:g} s). Relax that limit."
            )
        assert last is not None  # without a solve there is a verdict
        return (
            f"No motion found: {last.status} after {last.iterations} iterations, although a smooth motion of "
            f"{0.95 * limit:.3g} s keeps every limit on the way; the end condition "
            f'"{self.scene.motion.end}" may be out of reach. Try another end condition, more starts or more intervals.'
        )

    def report(self, solution: Solution) -> PlanningReport:
        """What it cost."""
        best = min(self.durations)
        agreed = sum(duration <= best * (1 + _AGREEMENT) for duration in self.durations)
        return PlanningReport(
            plan_time=time.perf_counter() - self.began,
            solve_time=self.solve_time,
            iterations=self.iterations,
            rounds=self.rounds,
            starts=Starts(self.tried, len(self.durations), agreed, tuple(self.durations)),
            phases=dict(self.phases),
            solver_status=solution.status,
            reserves={self._label(key): value for key, value in self.reserves.items() if value > first_reserve(key[0])},
        )


def first_reserve(constraint: str) -> float:
    """Fraction of a constraint's budget that is kept from the optimiser at first."""
    return FIRST_RESERVES.get(constraint, FIRST_RESERVE)


def _resolving(scene: Scene, duration: float, swing: float) -> int:
    """Intervals in which no carried mode turns by more than `swing` rad over a motion of `duration` s."""
    fastest = max(
        (mode.frequency for cargo in scene.cargo if cargo.filling for mode in cargo.filling.modes.oscillators),
        default=0.0,
    )
    return int(np.ceil(fastest * duration / swing))


def _usable(solution: Solution) -> bool:
    return solution.violation <= _FEASIBLE


def _starts(scene: Scene) -> Iterator[Start]:
    """The starting motions: three fixed ones (even, early, late), then random ones from the scene's seed.

    As many as the scenario asks for, and some more for when all of those fail.
    """
    count = scene.planning.starts + _LAST_STARTS
    yield from _FIXED_STARTS
    random = np.random.default_rng(scene.planning.seed)
    for _ in range(count - len(_FIXED_STARTS)):
        lean = random.uniform(-0.3, 0.3, 2) * min(1.0, scene.motion.max_tilt / 0.3)
        yield Start(
            stretch=float(random.uniform(0.4, 1.6)),
            skew=float(random.uniform(-0.6, 0.6)),
            tilt=(float(lean[0]), float(lean[1])),
        )
