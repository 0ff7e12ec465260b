"""Builders of what many tests need: changed tables, the joint path of a scene, smooth records."""

from __future__ import annotations

from dataclasses import replace

from nospill.certification.other_speeds import uses_at
from nospill.certification.tracks import variant_tracks
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.robots.joint_paths.search import JointPath, joint_paths
from nospill.scenario import read_scenario
from nospill.scene.containers.vessel import Vessel
from nospill.scene.containers.vessels import Bowl, ConicalFlask, Profile, RoundFlask, Tapered, TestTube, WineGlass
from nospill.scene.scene import Scene
from nospill.transcription.export_samples import export_samples
from nospill.transcription.starting_motions import Start, smooth_start

VESSELS: dict[str, Vessel] = {
    "tapered": Tapered(bottom_radius=0.03, top_radius=0.045, height=0.11),
    "bowl": Bowl(radius=0.07, bottom_radius=0.03, height=0.06),
    "wine-glass": WineGlass(radius=0.045, rim_radius=0.035, bowl_height=0.1, height=0.2, base_radius=0.035),
    "conical-flask": ConicalFlask(bottom_radius=0.045, neck_radius=0.0175, shoulder_height=0.1, height=0.13),
    "round-flask": RoundFlask(radius=0.05, bottom_radius=0.02, neck_radius=0.015, height=0.15),
    "test-tube": TestTube(radius=0.009, height=0.1, base_radius=0.02),
    "profile": Profile(profile=((0.0, 0.0), (0.02, 0.0), (0.02, 0.02), (0.05, 0.02), (0.045, 0.09)), wall=0.002),
}
"""A vessel of every shape that is a body of revolution."""


def one_mode(name: str, *settings: str) -> Scene:
    """An example that states one mode of each liquid: judged and planned in a fraction of the time of twenty.

    Settings are as of the command line.
    """
    scene = read_scenario(name, settings=settings)
    return scene if scene.slosh_modes == 1 else read_scenario(name, settings=["planning.slosh_modes=1", *settings])


def with_linear_heights(scene: Scene) -> Scene:
    """The scene as it was before heights of second order, for tests of the linear law."""
    return replace(scene, motion=replace(scene.motion, slosh_height="linear"))


def joint_paths_of(scene: Scene, *, samples: int = 101) -> list[JointPath]:
    """Every joint motion that carries the scene's level tray along its path."""
    return joint_paths(scene.robot, scene.path, tool=scene.tray.tool, samples=samples)


def joint_path_of(scene: Scene, *, samples: int = 101) -> JointPath:
    """The first of them."""
    return joint_paths_of(scene, samples=samples)[0]


def smooth_record(scene: Scene, path: JointPath, intervals: int, start: Start) -> Trajectory:
    """A smooth motion of a scene as a plan records it, with the modes of its liquids."""
    model = scene.with_one_mode()
    record = export_samples(model, smooth_start(model, path, intervals, start))
    names = {(cargo.name, ""): cargo.name for cargo in scene.cargo}
    tracks = variant_tracks(record, scene, names)
    # what a carrier feels of its liquids is no liquid of its own
    dry = {item.name for item in scene.cargo if item.filling is None}
    return replace(record, slosh={name: track for name, track in tracks.items() if name not in dry})


def with_few_speeds(plan: Plan) -> Plan:
    """The plan with its second looks, at half its speed alone instead of a dozen speeds."""
    uses = uses_at(plan.trajectory, plan.scene, (0.5,))
    return replace(plan, maxima=replace(plan.maxima, other_speeds=uses)).with_second_looks()


def plan_for(plan: Plan, name: str) -> Plan:
    """The plan for a format of this name: its arm has a name that URScript is for."""
    robot = plan.scene.robot
    return replace(plan, scene=replace(plan.scene, robot=replace(robot, name="ur10e"))) if name == "urscript" else plan
