"""A plan at a lower speed on the same way: the same poses and joints, at other times, certified.

A motion that is slowed down is another motion: its liquids are excited at other frequencies, and a tray leans against
an acceleration that is not there. The same motion at one rate is tried first; where it breaks a limit, the rate is made
to vary along the way, so that the largest use of a limit on an object is least, by linear approximations of all uses
[M. J. D. Powell, A direct search optimization method that models the objective and constraint functions by linear
interpolation, 1994]. The certificate decides.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import KDTree

from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.other_speeds import object_traces
from nospill.certification.tracks import judged_tracks, with_recorded_modes
from nospill.certification.verdict import Row, worst_row
from nospill.certification.wording import describe
from nospill.core.attitudes import angles_between
from nospill.errors import NoSolutionError
from nospill.laws.like_objects import hull_objects
from nospill.motion.interpolation import HeldMotion
from nospill.motion.time_law import SHAPES, RetimedMotion, TimeLaw, retimed
from nospill.motion.trajectory import Trajectory
from nospill.planning.request import require_constraints
from nospill.plans.approach import with_approach
from nospill.plans.plan import Plan, judged_plan
from nospill.plans.records import PlanningReport
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.scene import Scene

SAME_PLACE, SAME_ATTITUDE = 1e-3, float(np.radians(0.1))
"""m and rad; two motions that are nowhere farther apart have the same geometry."""
SPEEDS = (1.0, 0.85, 0.7)
"""Parts of the speed asked for that are looked at, the first that holds is taken."""

_ENOUGH, _TRIES = 0.98, 120
"""Largest use of a limit on the coarse grid with which a time law is judged, and laws that are tried at a speed."""
_HOPELESS = 20.0
"""A use above this is no nearer to holding than this."""
_SLOWEST_RATE = 0.2
"""Least coefficient of a law's rate, of the mean."""
_LOOKED_AT, _AMONG = 500.0, 16
"""Hz; two motions are compared at so many instants a second of one, with so many times more of the other."""


@dataclass(frozen=True, slots=True)
class Apart:
    """Largest distance of two motions whatever their times: of each pose of either from the nearest of the other.

    Attributes:
        distance: of the tray's centre, m.
        angle: of its attitude, rad.
        joints: of a joint, rad.
    """

    distance: float
    angle: float
    joints: float

    @property
    def is_same(self) -> bool:
        """Whether the two have the same geometry."""
        return self.distance <= SAME_PLACE and self.angle <= SAME_ATTITUDE


def slower(planned: Plan, speed: float) -> Plan:
    """The plan's motion at a part of its speed or a little less, on the same way, certified.

    Args:
        planned: the plan.
        speed: above 0 and at most 1.

    Raises:
        ScenarioError: the plan was saved with a limit that is not at hand.
        NoSolutionError: no time law was found that holds on this way; says which limit is nearest to holding.
    """
    require_constraints(planned.scene)
    began, nearest = time.perf_counter(), None
    for law, worst in _laws(planned, speed):
        if worst is not None and (nearest is None or worst.use < nearest.use):
            nearest = worst
        if worst is not None and worst.use > 1.0:
            continue
        scene, trajectory, judgement = _judge(planned, law)
        if judgement.certificate.ok:
            report = replace(
                PlanningReport.empty("another time law"),
                branch=planned.report.branch,
                base_yaw=planned.report.base_yaw,
                end_yaws=planned.report.end_yaws,
                blocked_way=planned.report.blocked_way,
                plan_time=time.perf_counter() - began,
            )
            return with_approach(judged_plan(scene, trajectory, judgement, report))
        nearest = judgement.certificate.worst
    least = 100 * SPEEDS[-1] * speed
    nearest_text = "" if nearest is None else f"; in the motion that comes nearest {describe(nearest)}"
    raise NoSolutionError(
        f"on the way of this plan no motion of {100 * speed:.3g} to {least:.3g} % of its speed was found that holds"
        f"{nearest_text}"
    )


def apart(first: Plan, second: Plan) -> Apart:
    """How far the ways of two motions of one arm are apart, whatever their times."""
    tool, ways = first.scene.tray.tool, []
    for plan in (first, second):
        end = plan.trajectory.rest_time
        q = plan.trajectory.motion(np.linspace(0.0, end, _AMONG * int(np.ceil(_LOOKED_AT * end)) + 1))
        tray = kinematics(plan.scene.robot).motions(q, np.zeros_like(q), np.zeros_like(q), tool=tool)
        # a place and an attitude that count the same are as far apart: columns of R differ by the angle
        features = np.hstack(
            [tray.position / SAME_PLACE, tray.rotation.reshape(-1, 9) / (np.sqrt(2.0) * SAME_ATTITUDE)]
        )
        ways.append((q, tray, features))
    worst = np.zeros(3)
    for (q, tray, features), (other_q, other, others) in (ways, ways[::-1]):
        some = slice(None, None, _AMONG)
        near = KDTree(others).query(features[some])[1]
        gaps = (
            np.linalg.norm(tray.position[some] - other.position[near], axis=1),
            angles_between(tray.rotation[some], other.rotation[near]),
            np.max(np.abs(q[some] - other_q[near]), axis=1),
        )
        worst = np.maximum(worst, [float(np.max(gap)) for gap in gaps])
    return Apart(*map(float, worst))


def _laws(planned: Plan, speed: float) -> Iterator[tuple[TimeLaw, Row | None]]:
    """Laws that may hold, with the object's row that uses most of its limit; None where there is no object."""
    length, shape = planned.trajectory.rest_time, np.ones(SHAPES)
    for part in SPEEDS:
        even = TimeLaw.even(length, length / (speed * part))
        rows = _rows(planned, even)
        yield even, max(rows, key=lambda row: row.use, default=None)
        if rows:
            law = _best(planned, replace(even, shape=shape))
            shape = law.shape
            yield law, max(_rows(planned, law), key=lambda row: row.use)


def _best(planned: Plan, law: TimeLaw) -> TimeLaw:
    """The law of this duration whose largest use is least, nowhere faster than the plan, as far as it has to be."""
    found, least = law, np.inf

    def uses(shape: np.ndarray) -> np.ndarray:
        nonlocal found, least
        if least <= _ENOUGH:
            raise StopIteration
        own = replace(law, shape=np.maximum(shape, _SLOWEST_RATE))
        values = np.array([*(row.use for row in _rows(planned, own)), own.fastest])
        if (largest := float(np.max(values))) < least:
            found, least = own, largest
        return np.minimum(values, _HOPELESS)

    def spare(variables: np.ndarray) -> np.ndarray:
        return np.concatenate([variables[-1] - uses(variables[:-1]), variables[:-1] - _SLOWEST_RATE])

    start = np.append(law.shape, 1.0)
    with suppress(StopIteration):
        minimize(
            lambda variables: variables[-1],
            start,
            method="COBYLA",
            constraints={"type": "ineq", "fun": spare},
            options={"rhobeg": 0.3, "maxiter": _TRIES, "tol": 1e-3},
        )
    return found


def _rows(planned: Plan, law: TimeLaw) -> list[Row]:
    """Of the limits on objects, on the coarse grid, of like objects those of the outer ones."""
    scene = replace(planned.scene, cargo=hull_objects(planned.scene))
    motion = HeldMotion(RetimedMotion(planned.trajectory.motion, law), 0.0, law.duration)
    t = np.arange(int(np.ceil(law.duration * planned.trajectory.rate - 1e-6)) + 1) / planned.trajectory.rate
    record = Trajectory.of_joints(t, planned.trajectory.joints, *(motion(t, order) for order in range(3)))
    return [worst_row(trace) for trace in object_traces(record, scene, motion)]


def _judge(planned: Plan, law: TimeLaw) -> tuple[Scene, Trajectory, Judgement]:
    """The scene with the duration, the record with its liquids, and the verdict."""
    scene = planned.scene.changed({"motion.duration": law.duration})
    record = retimed(planned.trajectory, scene, law)
    judgement = judge_motion(record, scene)
    tracks = judged_tracks(record, scene, judgement.replay, judgement.traces)
    return scene, with_recorded_modes(replace(record, slosh=tracks), scene), judgement
