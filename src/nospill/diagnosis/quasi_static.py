"""The task without haste: standing along the path, and the slowest smooth motion, as the judge sees them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.certification.certificate import judge
from nospill.certification.verdict import Certificate, Row
from nospill.certification.wording import describe
from nospill.core.units import format_quantity
from nospill.diagnosis.changes import advice
from nospill.diagnosis.least_relaxation import wide_enough
from nospill.diagnosis.search import MOST_TIME, SLOW, Trials
from nospill.diagnosis.singularity import at_singularity
from nospill.errors import MOTION, REST, Change, ModelError, NoSolutionError, Reason
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.joint_speed import JointSpeed
from nospill.laws.constraints.tilt import Tilt
from nospill.motion.trajectory import Trajectory
from nospill.robots.joint_paths.no_joint_path import place_in_words
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.perturbation import without_swing
from nospill.scene.scene import Scene
from nospill.transcription.export_samples import export_samples
from nospill.transcription.problem import build_problem
from nospill.transcription.solvers import row_slack
from nospill.transcription.starting_motions import Start, smooth_start

_STANDING = 1e5
"""s; a motion of this length is quasi-static."""


def is_hopeless(scene: Scene, joint_path: JointPath) -> bool:
    """Whether even the slowest smooth motion breaks a limit several times over; of a given duration none is slow.

    Near a singularity of the arm it says nothing of joints: a motion may slow down there alone. Liquids count by their
    modes after the end, which a faster motion may still as well: where the flow of this one breaks down, that is no
    measure.
    """
    if scene.motion.duration is not None:
        return False
    by_modes = replace(scene, motion=replace(scene.motion.without_flow, residual_height="linear"))
    judged = quasi_static_motion(by_modes, joint_path)
    if judged is None or judged[0].worst.worst_margin >= -abs(judged[0].worst.limit):
        return False
    worst, trajectory = judged[0].worst, judged[1]
    at_s = path_place(trajectory, worst.at_s)
    return at_singularity(scene, joint_path, worst.constraint, at_s) is None


def require_possible_at_rest(trials: Trials) -> None:
    """Raise NoSolutionError if a limit is broken somewhere on the path even by standing there with a level tray."""
    scene, joint_path = _from_rest(trials.run.scene), trials.joint_path
    certain = _from_rest(trials.run.trial(trials.run.scene, joint_path).scene)
    key = _row_at_rest(certain, joint_path)
    if key is None:
        return
    judged = quasi_static_motion(with_time(scene, max(trials.limit, SLOW)), joint_path)
    subject = key.subject
    rows = () if judged is None else judged[0].rows
    row = next((row for row in rows if row.id == key), None)
    if key.constraint == JointSpeed.name:
        raise _too_slow_a_joint(trials, joint_path, subject, row)
    use = 1.1 if row is None else max(row.use, 1.0)
    changes = [change for _, change in wide_enough(trials, key.constraint, subject, use - 1.0)]
    at_s = None if row is None or judged is None else path_place(judged[1], row.at_s)
    finding = f"{key.constraint} of {subject} is over its limit" if row is None else without_time(row)
    where = "" if at_s is None else f" at {place_in_words(scene.path, at_s)}"
    raise NoSolutionError(
        f"No motion found: {finding} even standing still{where}. "
        + advice(changes, "Relax that limit or lighten the load."),
        Reason(REST, key.constraint, subject, at_s, use - 1.0, changes=tuple(changes)),
    )


def _too_slow_a_joint(trials: Trials, joint_path: JointPath, joint: str, row: Row | None) -> NoSolutionError:
    """The error for a joint whose speed limit makes the path take longer than any motion may."""
    scene = trials.run.scene
    index, limit = scene.robot.joints.index(joint), max(trials.limit, SLOW)
    turn = float(np.sum(np.abs(np.diff(joint_path.at(np.linspace(0.0, 1.0, 1001))[:, index]))))
    at_most = float(scene.robot.max_speed[index])
    peak = 2.0 * turn / limit if row is None else abs(row.worst_value)
    slow, needed = (format_quantity(value, "angular_speed", digits=3) for value in (at_most, 1.05 * peak))
    return NoSolutionError(
        f"No motion found: the path turns {joint} by {format_quantity(turn, 'angle', digits=3)}, which takes "
        f"{turn / at_most:.3g} s at its speed limit of {slow}. A smooth motion of {limit:.3g} s asks {needed} of it: "
        "raise its limits.speed to that, or choose a path that turns it less.",
        Reason(MOTION, JointSpeed.name, joint, None, peak / at_most - 1.0),
    )


def _row_at_rest(scene: Scene, joint_path: JointPath) -> RowId | None:
    """The row that standing along the path with a level tray breaks most; None where it keeps all."""
    still = smooth_start(with_time(scene, _STANDING), joint_path, 50, Start(stretch=1e9))
    problem = build_problem(
        replace(scene, motion=replace(scene.motion, end="residual")),
        still.intervals,
        nominal_duration=still.duration,
        backoff={},
        self_motion=still.self_motion,
    )
    slack = {
        key: value for key, value in row_slack(problem, still).items() if value < 0.0 and key.constraint != Tilt.name
    }
    return min(slack, key=lambda key: slack[key]) if slack else None


def _from_rest(scene: Scene) -> Scene:
    """The scene without what moves when its motion begins: nothing stands still that swings."""
    return replace(scene, cargo=tuple(map(without_swing, scene.cargo)), initial_state=None)


def with_time(scene: Scene, max_duration: float) -> Scene:
    """The scene with another longest duration, s, and none given."""
    return replace(scene, motion=replace(scene.motion, max_duration=max_duration, duration=None))


def longer_time(trials: Trials, use: float) -> list[Change]:
    """A longer duration in which a smooth motion keeps every limit: nothing where none does.

    Args:
        trials: of the task.
        use: of the limit that the slowest smooth motion of the time allowed breaks most.
    """
    scene, slow = trials.run.scene, max(trials.limit, SLOW)
    for factor in (np.sqrt(use), use):  # what breaks it falls with the square of the duration, or with the duration
        needed = float(1.05 * factor * slow)
        judged = None if needed > MOST_TIME else quasi_static_motion(with_time(scene, needed), trials.joint_path)
        if judged is not None and judged[0].ok:
            key = "max_duration" if scene.motion.duration is None else "duration"
            text = f"{key} {needed:.3g} s instead of {trials.limit:.3g} s"
            return [Change(key, f"motion.{key}", needed, text)]
    return []


def quasi_static_motion(scene: Scene, joint_path: JointPath) -> tuple[Certificate, Trajectory] | None:
    """What the judge says of the slowest smooth motion, and that motion.

    None if the arm cannot follow it between the nodes or its liquids cannot be integrated.
    """
    try:
        trajectory = export_samples(scene, smooth_start(scene, joint_path, 100, Start(stretch=1e6)))
        verdict = judge(trajectory, scene).certificate
    except ModelError:
        return None
    rows: tuple[Row, ...] = tuple(row for row in verdict.rows if not row.of_record)
    return Certificate(all(row.ok for row in rows), verdict.grid_hz, rows), trajectory


def without_time(row: Row) -> str:
    """What is wrong, without the time at which the slow motion was there."""
    return describe(row).removesuffix(f" at t = {row.at_s:.3f} s")


def path_place(trajectory: Trajectory, t: float) -> float:
    """Path parameter, 0 to 1, where a motion is at a time in s."""
    return float(np.interp(t, trajectory.t, trajectory.s))
