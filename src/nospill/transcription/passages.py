"""How the arm passes the singularities of its path: settings of a problem and of its export."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nospill.laws.scene_parameters import structure_of
from nospill.robots.joint_paths.search import JointPath
from nospill.robots.kinematics.regularity import clearance, determinants, keeps_branch
from nospill.scene.scene import Scene
from nospill.transcription.layout import layout_of
from nospill.transcription.stages import Stages


@dataclass(frozen=True, slots=True)
class Passage:
    """How the arm passes the singularities of its path.

    Each instant of a problem sees its own joints only: a motion can hop between branches, or run through a singularity,
    between two of them. Most motions do neither, so the rows against it are left out at first.

    Attributes:
        determinant: what the determinant of the Jacobian stays beyond, sign included; None leaves it free.
        along: joint path that leads through a singularity and that the joints follow there; None where there is none.
        level: whether the tray stays level though it may tilt: a tilting one would need endless joint speed there.
        brief: whether only the starts that the scenario requests are tried.
    """

    determinant: float | None = None
    along: JointPath | None = None
    level: bool = False
    brief: bool = False


NOT_BOUNDED = Passage()
"""The determinant left free, which suffices for most paths."""


def passages(scene: Scene, joint_path: JointPath, motion: Stages) -> tuple[Passage, ...]:
    """Ways to pass the singularities along a joint path, in the order in which they are tried.

    Args:
        scene: the task.
        joint_path: joints along the path of a level tray.
        motion: a starting motion along it.
    """
    if scene.path.joint_curve is not None:  # it is followed whatever the arm passes
        return (Passage(along=joint_path),)
    values = stage_determinants(scene, motion)
    if motion.self_motion is not None or keeps_branch(values):  # a seventh joint passes by itself
        return NOT_BOUNDED, Passage(determinant=clearance(values))
    through = Passage(along=joint_path, level=not scene.motion.is_given)
    if scene.motion.is_given or not keeps_branch(values[[0, -1]]):
        return (through,)
    # a tilting tray passes beside a singularity if it does not end behind it
    return NOT_BOUNDED, Passage(determinant=clearance(values[[0, -1]]), brief=True), through


def stage_determinants(scene: Scene, stages: Stages) -> np.ndarray:
    """Determinant of the Jacobian at the nodes but the last, shape (N,)."""
    layout = layout_of(structure_of(scene))
    return determinants(scene.robot, stages.table[:-1, layout.joint_position], stages.self_motion)


def bounded_as(passage: Passage, scene: Scene, motion: Stages) -> Passage | None:
    """A passage with the determinant bounded as on a motion; None where it is bounded, or leads through."""
    if passage.determinant is not None or passage.along is not None:
        return None
    return replace(passage, determinant=clearance(stage_determinants(scene, motion)))


def keeps_branch_at_nodes(scene: Scene, stages: Stages) -> bool:
    """Whether the arm stays on its branch at the nodes."""
    return keeps_branch(stage_determinants(scene, stages))


def keeps_branch_between(scene: Scene, stages: Stages, q: np.ndarray) -> bool:
    """Whether it does so at exported samples q (m, n), rad, as well."""
    return keeps_branch(determinants(scene.robot, q, stages.self_motion))
