"""Smooth motions that need no solver, and certified plans of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from nospill.certification.certificate import judge
from nospill.motion.interpolation import JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.robots.joint_paths.search import JointPath
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from nospill.transcription.export_samples import export_samples
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import Start, smooth_start
from tests.builders import joint_path_of, one_mode, with_few_speeds


@dataclass(frozen=True)
class SmoothMotion:
    """A scene with a quintic motion along its path, on the grid of the optimal control problem and as exported.

    The scene states one mode of each liquid; the model is the scene with one mode, of which the grid is.
    """

    scene: Scene
    model: Scene
    stages: Stages
    trajectory: Trajectory


@cache
def _joint_path(name: str) -> JointPath:
    scene = read_scenario(name)
    return joint_path_of(scene)


@cache
def _smooth_motion(name: str, cargo: int | None, intervals: int, start: Start) -> SmoothMotion:
    scene = one_mode(name)
    scene = scene.changed({"cargo": scene.source["cargo"][:cargo]})
    model = scene.with_one_mode()
    stages = smooth_start(model, _joint_path(name), intervals, start)
    return SmoothMotion(scene, model, stages, export_samples(model, stages))


def smooth_motion(
    name: str,
    *,
    cargo: int | None = None,
    intervals: int = 200,
    stretch: float = 1.0,
    skew: float = 0.0,
    tilt: tuple[float, float] = (0.0, 0.0),
) -> SmoothMotion:
    """The smooth motion of an example, made once: name, number of objects kept, intervals, and how it starts."""
    return _smooth_motion(name, cargo, intervals, Start(stretch, skew, tilt))


@cache
def gentle_plan(name: str, cargo: int | None = None) -> Plan:
    """A certified plan of an example, slow enough to keep every limit with room: its name, and how many objects."""
    motion = smooth_motion(name, cargo=cargo, stretch=0.8 if name == "matrix-rigid" else 1.3)
    judgement = judge(motion.trajectory, motion.scene)
    assert judgement.certificate.ok
    report = PlanningReport.empty()
    maxima = motion_maxima(judgement, motion.scene)
    return with_few_speeds(Plan(motion.scene, motion.trajectory, judgement.certificate, maxima, report))


def curve(samples: int = 40, joints: int = 6, rate: float = 500.0) -> JointSamples:
    """A rest-to-rest quintic in every joint, with different ends; times as whole nanoseconds."""
    t = np.round(np.arange(samples) / rate * 1e9) / 1e9
    u, length = (t / t[-1])[:, None], t[-1]
    start, way = np.linspace(-1.3, 2.1, joints), np.linspace(0.5, -3.0, joints)
    return JointSamples(
        t,
        start + way * (10 * u**3 - 15 * u**4 + 6 * u**5),
        way * (30 * u**2 - 60 * u**3 + 30 * u**4) / length,
        way * (60 * u - 180 * u**2 + 120 * u**3) / length**2,
    )
