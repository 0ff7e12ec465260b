"""What the full model says of a motion judged with less: a warning next to its certificate.

The full model has the physics of full fidelity and so many modes of each liquid that one more changes nothing.
"""

from __future__ import annotations

from dataclasses import replace

from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.verdict import Certificate
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.carriers import with_modes
from nospill.scene.scene import FULL_MODES, Scene
from nospill.scene.turning import turning, turns


def full_scene(scene: Scene) -> Scene:
    """The scene with the whole physics: moving liquids with all their modes, contact that shares its friction.

    Without obstacles, of which it says nothing new.
    """
    count = max(scene.slosh_modes, FULL_MODES)
    cargo = tuple(with_modes(item, count) for item in scene.cargo)
    if turns(scene.path, scene.motion):
        cargo = tuple(turning(item) for item in cargo)
    return replace(scene, fidelity="full", cargo=cargo, slosh_modes=count, obstacles=())


def judged_in_full(judgement: Judgement, trajectory: Trajectory, scene: Scene) -> Judgement:
    """The judgement of the same motion by the full model: the one at hand where the scene has all of it.

    Raises:
        ModelError: the liquids cannot be integrated.
    """
    return judgement if _is_full(scene) else judge_motion(trajectory, full_scene(scene))


def with_full_model(
    certificate: Certificate, trajectory: Trajectory, scene: Scene, *, motion: JointMotion | None = None
) -> Certificate:
    """A certificate with the rows on objects that the same motion breaks in the full model.

    As it is where they are known.

    Raises:
        ModelError: the liquids cannot be integrated.
    """
    if certificate.full_model is not None:
        return certificate
    if _is_full(scene):
        return replace(certificate, full_model=())
    return with_rows_of(certificate, judge_motion(trajectory, full_scene(scene), motion=motion), scene)


def with_rows_of(certificate: Certificate, full: Judgement, scene: Scene) -> Certificate:
    """The same from a judgement at hand, as `judged_in_full` has it."""
    if certificate.full_model is not None:
        return certificate
    rows = () if _is_full(scene) else full.certificate.rows
    return replace(certificate, full_model=tuple(row for row in rows if not row.ok and row.of_object))


def _is_full(scene: Scene) -> bool:
    return scene.fidelity == "full" and scene.fewer_modes is None
