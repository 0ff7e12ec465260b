"""What the whole physics say of a motion judged by the published equations: a warning beside its certificate."""

from __future__ import annotations

from dataclasses import replace

from nospill.judge.certificate import judge_motion
from nospill.judge.verdict import Certificate
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import Role
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.cargo import with_modes
from nospill.scene.scene import Scene, mode_count


def full_scene(scene: Scene) -> Scene:
    """The scene with the whole physics: moving liquids with all their modes, contact that shares its friction."""
    count = mode_count("full", scene.slosh_modes)
    return replace(scene, fidelity="full", cargo=tuple(with_modes(cargo, count) for cargo in scene.cargo))


def with_full_model(
    certificate: Certificate, trajectory: Trajectory, scene: Scene, *, motion: JointMotion | None = None
) -> Certificate:
    """A certificate with the rows on objects that the same motion breaks under the whole physics.

    As it is at full fidelity.

    Raises:
        ModelError: the liquids cannot be integrated.
    """
    if not certificate.published:
        return certificate
    rows = judge_motion(trajectory, full_scene(scene), motion=motion).certificate.rows
    broken = (row for row in rows if not row.ok and row.constraint in BY_NAME)
    of_objects = tuple(row for row in broken if BY_NAME[row.constraint].role in (Role.LIQUID, Role.CONTACT))
    return replace(certificate, full_model=of_objects)
