"""The story of a plan: a path for the joints, the fastest motion along it, the judge's verdict."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from nospill.errors import ScenarioError
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.scene_parameters import structure_of
from nospill.planning.base_yaw import base_yaw_text, has_free_base, settled_base
from nospill.planning.corners import corner_run
from nospill.planning.hull import hull_run
from nospill.planning.run import Memory, PlanningRun, Progress
from nospill.planning.run import PlanningProgress as PlanningProgress
from nospill.plans.approach import require_possible, starts_alike, with_approach
from nospill.plans.plan import Plan, motion_maxima
from nospill.robots.joint_paths.search import branch_in_words, joint_paths, preferred_path
from nospill.scene.scene import Scene
from nospill.scene.tolerances import is_uncertain


def plan(
    scene: Scene,
    *,
    warm: Plan | None = None,
    ignore: Collection[str] = (),
    progress: Progress | None = None,
    fork: bool = False,
) -> Plan:
    """Find the fastest motion of a scene that the judge certifies.

    Args:
        scene: the task.
        warm: an earlier plan of a similar scene (same robot, tilt and liquids), from which to start instead of
            searching; where that leads nowhere, the search is made all the same.
        ignore: names of constraints the optimiser leaves out, to see what they cost. The judge leaves out none.
        progress: called with where planning stands.
        fork: search from the second start in a forked copy of this process, at the same time: the same answer, an
            eighth sooner for the command on two cores. On Linux only, and only where no other thread of the process is
            inside CasADi or holds what a copy needs: for programs of which you own all threads, as the command line.

    Returns:
        The plan. If the judge still objects after the last tightening, the plan says so: status "uncertified".

    Raises:
        ScenarioError: the robot cannot follow the path, or `ignore` names no constraint.
        NoSolutionError: no start led to a motion, or no approach to it; names what is in the way.
        MissingExtraError: an approach is asked for, and ruckig is not installed.
    """
    return _planned(scene, warm=warm, memory=None, ignore=ignore, progress=progress, fork=fork)[0]


def _planned(
    scene: Scene,
    *,
    warm: Plan | None,
    memory: Memory | None,
    ignore: Collection[str],
    progress: Progress | None,
    fork: bool = False,
) -> tuple[Plan, Memory]:
    """`plan`, with what the next one may start from."""
    unknown = set(ignore) - {constraint.name for constraint in CONSTRAINTS}
    if unknown:
        known = ", ".join(constraint.name for constraint in CONSTRAINTS)
        raise ScenarioError(f'ignore: "{sorted(unknown)[0]}" is no constraint; there are: {known}')
    require_possible(scene)
    run = (corner_run if is_uncertain(scene) else hull_run)(scene, progress, frozenset(ignore))
    run.forks = fork
    base_is_free = has_free_base(scene)
    if base_is_free:
        with run.phase("base yaw"):
            try:
                scene = settled_base(scene)
            except ScenarioError as error:
                raise _advised(scene, error, run) from None
            run.settle(scene)
    # a plan on a branch chosen for another start of the arm is no place to go on from
    solution = run.restart(warm, memory) if warm is not None and starts_alike(warm.scene, scene) else None
    if solution is None:
        with run.phase("kinematics"):
            try:
                paths = joint_paths(
                    scene.robot, scene.path, tool_position=scene.tray.offset, tool_yaw=scene.tray.yaw_on_flange
                )
            except ScenarioError as error:
                raise _advised(scene, error, run) from None
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
    return replace(found, report=replace(run.report(solution), **chosen)), run.memory(solution)


def _advised(scene: Scene, error: ScenarioError, run: PlanningRun) -> ScenarioError:
    from nospill.diagnosis import advised  # loaded where something is wrong

    return advised(scene, error, run.is_possible)


class Planner:
    """Plans scene after scene, each from the answer before where the structure is the same.

    Not thread-safe: one per thread.
    Compiled functions are shared by all planners of a process anyway; what a planner keeps is the last plan.
    """

    def __init__(self, last: Plan | None = None) -> None:
        """Start with nothing, or with an earlier plan (for example `load_plan(folder)`)."""
        self.last = last
        self._memory: Memory | None = None

    def plan(self, scene: Scene, *, progress: Progress | None = None) -> Plan:
        """`plan(scene)`, warm from the last plan if that was of the same structure; raises the same."""
        similar = self.last is not None and structure_of(self.last.scene) == structure_of(scene)
        self.last, self._memory = _planned(
            scene, warm=self.last if similar else None, memory=self._memory, ignore=(), progress=progress
        )
        return self.last
