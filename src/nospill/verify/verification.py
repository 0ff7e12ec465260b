"""A plan judged by a physics engine that has never seen our laws."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nospill.export import EXPORTERS
from nospill.plans.loading import load_plan
from nospill.plans.names import TRAJECTORY_FILE
from nospill.plans.plan import Plan
from nospill.scene.scene import Scene
from nospill.verify.bodies import Body, bodies_of
from nospill.verify.engine import STEP, build, mujoco, simulate
from nospill.verify.report import ObjectReport, Thresholds, VerifyReport, object_reports
from nospill.verify.touching import touches
from nospill.verify.tray_motion import PlayedJoints, TrayMotion, planned_joints, replay_joints, tray_motion

SETTLE = 0.3
"""s at rest before the motion, in which objects and contacts come to rest; slides are counted from its end."""

AFTER = 1.0
"""s at rest after the motion, in which the liquid goes on swinging."""

_SHORTEST = STEP / 4
"""s; step of the simulation before an object counts as moved: what rattles on rigid contacts creeps less in short ones.
"""

_JOINT_FILE = "lab-csv"


@dataclass(frozen=True, slots=True)
class Stage:
    """What one simulation needs: the objects, the tray's motion, and how many of its rows are for settling."""

    bodies: tuple[Body, ...]
    motion: TrayMotion
    settled: int


def stage(joints: PlayedJoints, scene: Scene, step: float = STEP) -> Stage:
    """Set up a simulation in steps of this length, s."""
    motion = tray_motion(joints, scene, step=step, before=SETTLE, after=AFTER)
    return Stage(bodies_of(scene), motion, round(SETTLE / step))


def verify(plan: Plan, *, thresholds: Thresholds | None = None, joints: PlayedJoints | None = None) -> VerifyReport:
    """Simulate every object of a plan on its moving tray in MuJoCo, and look what touches an obstacle.

    Nothing is written.

    Contacts have the friction as measured, without the reserve the plan keeps. Where an object moves, the simulation is
    repeated in steps of half and of a quarter of the length: a slide that is none disappears.

    Args:
        plan: certified or not.
        thresholds: from where on an object counts as moved; 0.5 mm and 0.5 deg by default.
        joints: the joint motion; by default the plan's own trajectory.

    Raises:
        MissingExtraError: MuJoCo is not installed.
        ModelError: the engine lost the solution.
        PlanFolderError: the joint motion is none of this robot.
    """
    engine = mujoco()
    used = thresholds or Thresholds()
    given = joints or planned_joints(plan.trajectory, plan.scene, source="trajectory")
    step = STEP
    scene, objects = _simulate(given, plan.scene, step, used)
    while not all(item.ok for item in objects) and step > _SHORTEST:
        step /= 2
        scene, objects = _simulate(given, plan.scene, step, used)
    return VerifyReport(
        objects=objects,
        thresholds=used,
        source=given.source,
        engine=f"MuJoCo {engine.__version__}",
        simulated=float(scene.motion.t[-1] - scene.motion.t[scene.settled]),
        touches=touches(plan.scene, scene.motion.t, given.motion(scene.motion.t, 0)),
    )


def _simulate(
    joints: PlayedJoints, scene: Scene, step: float, thresholds: Thresholds
) -> tuple[Stage, tuple[ObjectReport, ...]]:
    set_up = stage(joints, scene, step)
    simulation = simulate(build(set_up.bodies, step), set_up.bodies, set_up.motion)
    return set_up, object_reports(simulation, set_up.bodies, settled=set_up.settled, thresholds=thresholds)


def verify_folder(folder: str | Path, *, thresholds: Thresholds | None = None) -> VerifyReport:
    """`verify` for a plan folder, driven by the joint file in it.

    Raises:
        As `verify`, and PlanFolderError for a folder or joint file that cannot be read.
    """
    plan = load_plan(folder)
    return verify(plan, thresholds=thresholds, joints=folder_joints(folder, plan))


def folder_joints(folder: str | Path, plan: Plan) -> PlayedJoints:
    """The joints as the controller gets and plays them: the laboratory's file where there is one, else trajectory.csv.

    Raises:
        PlanFolderError: the joint file is damaged.
    """
    exporter = EXPORTERS[_JOINT_FILE]
    if exporter.plan_file is not None and (Path(folder) / exporter.plan_file).is_file():
        samples = exporter.read(Path(folder) / exporter.plan_file, plan.scene)
        return replay_joints(samples, plan.scene, interpolation=exporter.interpolation, source=exporter.plan_file)
    return planned_joints(plan.trajectory, plan.scene, source=TRAJECTORY_FILE)
