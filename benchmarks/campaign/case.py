"""One case of the campaign in a process of its own: draws, plans, judges twice, simulates, prints lines of JSON.

    python -m benchmarks.campaign.case SEED             the case
    python -m benchmarks.campaign.case SEED --starts 10     the same scene from further random starts, each by itself

The scenario comes drawn from the seed, or as JSON on the standard input with `--given`. The first line printed is the
scenario, so that it is known even if the rest never comes.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.campaign.combined import BACK_AFTER, ON_FROM, way_back
from nospill.certification.certificate import judge
from nospill.certification.wording import describe
from nospill.errors import REST, NoSolutionError, NospillError, ScenarioError
from nospill.path_search.base_yaw import choose_base_yaw
from nospill.planning import planner
from nospill.planning.active_set import Task
from nospill.planning.attempts import STEP_BY_STEP, Attempt
from nospill.planning.candidate import Candidate
from nospill.planning.log import Log
from nospill.planning.refinement import Judged
from nospill.planning.search import PassageSearch, best_of, find_motion, passage_searches
from nospill.planning.shortening import certify_by_refinement
from nospill.plans.plan import Plan
from nospill.plans.rows import seam_fault, with_residual_slosh
from nospill.robots.joint_paths.search import joint_paths, preferred_path
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import Start
from nospill.verify import verify

FINE_RATE = 8000.0
"""Hz; grid of the second certificate."""

PLANNED, UNCERTIFIED = "planned", "not certified"
REFUSED, IMPOSSIBLE, OUT_OF_REACH, NOT_FOUND = "refused", "proven impossible", "out of reach", "not found"
CRASH, TIMEOUT = "crash", "out of time"
KINDS = (PLANNED, UNCERTIFIED, REFUSED, IMPOSSIBLE, OUT_OF_REACH, NOT_FOUND, CRASH, TIMEOUT)
"""How a case may end. `refused`: the reader did not take the scenario. `crash`: anything but an error of nospill."""

_STARTS_STREAM = 7
_SEARCHING = 0.6
"""Part of a process's time that is for the search; the rest is for the reason, the judges and the simulation."""


@dataclass(frozen=True, slots=True)
class Failure:
    """Why there is no plan: how the case ended, the reason as the user reads it, what kind it is and what it blames."""

    kind: str
    reason: str
    told: str | None = None
    blamed: str | None = None


def failure_of(error: NospillError, scene: Scene) -> Failure:
    """Sort an error of planning into one of `KINDS`.

    A limit that is broken even nearly at rest is broken at any speed; anything else is a motion that was not found.
    """
    if isinstance(error, NoSolutionError):
        blamed = f"{error.reason.constraint} of {error.reason.subject}" if error.reason else None
        return Failure(IMPOSSIBLE if error.kind == REST else NOT_FOUND, str(error), error.kind, blamed)
    if isinstance(error, ScenarioError):
        try:
            joint_paths(scene.robot, scene.path, tool=scene.tray.tool)
        except ScenarioError:
            return Failure(OUT_OF_REACH, str(error))
        return Failure(REFUSED, str(error))
    return Failure(NOT_FOUND, f"{type(error).__name__}: {error}")


def limited(scene: Scene, longest: float) -> Scene:
    """The scene with so much time to look for a motion, s, that a reason can be told before the process ends."""
    return scene.changed({"planning.max_plan_time": min(longest, scene.planning.max_plan_time)})


def run(table: dict[str, Any], name: str, *, longest: float = math.inf) -> dict[str, Any]:
    """Plan a scenario and look at the answer from three sides; the figures of its line.

    Args:
        table: the scenario.
        name: what it is called.
        longest: time to look for a motion, s.
    """
    wait, on_from = table.get(BACK_AFTER), table.get(ON_FROM)
    table = {key: value for key, value in table.items() if key not in (BACK_AFTER, ON_FROM)}
    try:
        scene = limited(scene_from_table(table, name=name), longest)
    except NospillError as error:
        return {"kind": REFUSED, "reason": str(error)}
    began = time.process_time()
    try:
        plan = planner.plan(scene)
    except NospillError as error:
        spent = {"plan_processor_s": time.process_time() - began}
        failure = failure_of(error, scene)
        return {"kind": failure.kind, "reason": failure.reason, "told": failure.told, "blamed": failure.blamed} | spent
    spent = {"plan_processor_s": time.process_time() - began}
    after = {} if wait is None or not plan.certificate.ok else {"next": gone_on(plan, table, wait, longest)}
    if on_from is not None and plan.certificate.ok:
        after["from_the_midst"] = from_the_midst(plan, on_from["share"], stop=on_from["stop"])
    return figures(plan) | spent | after


def gone_on(plan: Plan, table: dict[str, Any], wait: float, longest: float) -> dict[str, Any]:
    """The motion back along a plan's path, with what swings a wait after it: planned, judged, and the seam.

    Args:
        plan: of the motion before.
        table: its scenario.
        wait: s between the two.
        longest: time to look for a motion, s.
    """
    scene = plan.scene
    try:
        scene = limited(scene_from_table(way_back(table), name=f"{plan.scene.name}-back"), longest)
        second = planner.plan(with_residual_slosh(scene, plan, wait))
    except NospillError as error:
        failure = failure_of(error, scene)
        return {"kind": failure.kind, "reason": failure.reason}
    return figures(second) | {"seam": seam_fault(plan, second)}


def from_the_midst(plan: Plan, share: float, *, stop: bool) -> dict[str, Any]:
    """The motion of its own that goes on from the midst of a plan to the same goal, or to a stop.

    Args:
        plan: of the motion.
        share: of its duration that is over.
        stop: whether it may rest anywhere on the path.
    """
    t = share * plan.duration
    try:
        state = plan.state_at(t)
        second = planner.plan(plan.scene, start=state, stop=stop)
    except NospillError as error:
        failure = failure_of(error, plan.scene)
        return {"kind": failure.kind, "reason": failure.reason}
    return figures(second) | {"stop": stop, "rest_s": plan.duration - t}


def figures(plan: Plan) -> dict[str, Any]:
    """What a plan is worth: its own certificate, a finer one, and the simulation."""
    worst = plan.certificate.worst
    line: dict[str, Any] = {
        "kind": PLANNED if plan.certificate.ok else UNCERTIFIED,
        "reason": None if plan.certificate.ok else describe(worst),
        "duration_s": plan.duration,
        "plan_time_s": plan.report.plan_time,
        "iterations": plan.report.iterations,
        "rounds": plan.report.rounds,
        "starts": [plan.report.starts.tried, plan.report.starts.converged, plan.report.starts.agreed],
        "solver_status": plan.report.solver_status,
        "phases_s": plan.report.phases,
        "branch": np.round(np.degrees(plan.trajectory.joint_position[0]), 1).tolist(),
        "certified": plan.certificate.ok,
        "binding": f"{worst.constraint} of {worst.subject}",
    }
    try:
        fine = judge(plan.trajectory, plan.scene, rate=FINE_RATE).certificate
        broken = [describe(row) for row in fine.rows if not row.ok]
        usual = {row.id: row.use for row in plan.certificate.rows}
        # a pair of the arm that is nearer than 50 mm on one grid alone has no row on the other
        more = max((row.use - usual[row.id], row.constraint) for row in fine.rows if row.id in usual)
        line["fine"] = {"ok": fine.ok, "grid_hz": fine.grid_hz, "broken": broken, "more": more}
    except NospillError as error:
        line["fine"] = {"ok": False, "broken": [str(error)]}
    try:
        report = verify(plan)
        line["verify"] = {"ok": report.ok, "message": report.message} | {
            "slide_mm": max(1e3 * item.slide.value for item in report.objects)
        }
    except NospillError as error:
        line["verify"] = {"ok": False, "message": str(error), "slide_mm": None}
    return line


_ALIKE = 1e-3
"""Coarse answers whose durations differ by less, relatively, are taken for the same one: only the first is refined."""


@dataclass(frozen=True, slots=True)
class Coarse:
    """A coarse answer that was refined.

    Attributes:
        bounded: whether the determinant of the Jacobian was bounded.
        duration: s.
        outcome: of the start that led to it.
    """

    bounded: bool
    duration: float
    outcome: dict[str, Any]


class _SameAnswerError(NospillError):
    """A start came to a coarse answer that an earlier one came to."""

    def __init__(self, outcome: dict[str, Any]) -> None:
        super().__init__()
        self.outcome = outcome


def random_starts(
    table: dict[str, Any], name: str, count: int, *, longest: float = math.inf
) -> Iterator[dict[str, Any]]:
    """The outcome of `count` random starts, each taken as if it were the only one; drawn from the scenario's name.

    Each has `longest` s to look for a motion.
    """
    scene = choose_base_yaw(limited(scene_from_table(table, name=name), longest))
    random = np.random.default_rng([_STARTS_STREAM, *name.encode()])
    known: list[Coarse] = []
    for index in range(count):
        lean = random.uniform(-0.3, 0.3, 2) * min(1.0, scene.motion.max_tilt / 0.3)
        start = Start(float(random.uniform(0.4, 1.6)), float(random.uniform(-0.6, 0.6)), (lean[0], lean[1]))
        outcome: dict[str, Any] = {"start": index, "duration_s": None, "reason": None}
        try:
            found = planned_from(scene, start, known, outcome)
        except _SameAnswerError as same:
            outcome |= same.outcome | {"start": index, "as": same.outcome["start"]}
        except NospillError as error:
            outcome["reason"] = str(error)
        else:
            certificate = found.judgement.certificate
            outcome["duration_s"] = found.trajectory.end_time if certificate.ok else None
            outcome["reason"] = None if certificate.ok else describe(certificate.worst)
        yield outcome


def planned_from(scene: Scene, start: Start, known: list[Coarse], outcome: dict[str, Any]) -> Judged:
    """The certified motion from one start and nothing else.

    Args:
        scene: the task.
        start: from where.
        known: coarse answers that were refined before; that of this start joins them.
        outcome: of this start, to be filled in by the caller.

    Raises:
        NospillError: the start leads nowhere, or to a coarse answer that is known.
    """

    def search(own: PassageSearch, log: Log) -> Candidate:
        best, last = best_of(own.task, own.joint_path, log, (Attempt(start, STEP_BY_STEP),))
        if best is None:
            raise NoSolutionError("the start led nowhere" if last is None else last.solution.status)
        bounded, duration = own.task.passage.determinant is not None, best.stages.duration
        for coarse in known:
            if coarse.bounded == bounded and abs(duration / coarse.duration - 1.0) < _ALIKE:
                raise _SameAnswerError(coarse.outcome)
        known.append(Coarse(bounded, duration, outcome))
        return best

    log = Log(None, scene.planning.max_plan_time)
    paths = joint_paths(scene.robot, scene.path, tool=scene.tray.tool)
    joint_path = preferred_path(paths, scene.robot, scene.start_near)
    return certify_by_refinement(find_motion(passage_searches(Task.of(scene), joint_path), log, search), log)


def _print(line: dict[str, Any]) -> None:
    print(json.dumps(line), flush=True)


def main() -> None:
    """Run one case."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("seed", type=int)
    parser.add_argument("--starts", type=int, default=0, metavar="COUNT")
    parser.add_argument("--processor-time", type=int, metavar="SECONDS", help="longest, then the system ends us")
    parser.add_argument("--given", action="store_true", help="read the scenario from the standard input")
    arguments = parser.parse_args()
    if arguments.processor_time is not None:
        # The hard limit is later: at the soft one the system says SIGXCPU, which cannot be mistaken for a crash.
        resource.setrlimit(resource.RLIMIT_CPU, (arguments.processor_time, arguments.processor_time + 5))
    longest = _SEARCHING * (arguments.processor_time or math.inf) / max(1, arguments.starts)
    name = f"campaign-{arguments.seed}"
    if arguments.given:
        table = json.load(sys.stdin)
    else:
        from benchmarks.campaign.scenes import draw_case  # a given scenario needs no distributions

        case = draw_case(arguments.seed)
        table = case.table
        _print({"scenario": table, "structure": case.structure, "unreachable": case.unreachable})
    if arguments.starts:
        for outcome in random_starts(table, name, arguments.starts, longest=longest):
            _print(outcome)
        return
    line = run(table, name, longest=longest)
    _print(line | {"peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024})


if __name__ == "__main__":
    main()
