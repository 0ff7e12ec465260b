"""Pairs of bodies as arrays: all of them that does not depend on the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.body_arrays import BodyArrays
from nospill.collisions.capsule_distances import are_capsules
from nospill.collisions.pairs import Pair, scene_pairs
from nospill.core.arrays import cross
from nospill.robots.kinematics.bodies import BodyChain
from nospill.robots.kinematics.frames import JointFrames, arm_chain, axis_reach
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True, eq=False)
class PairArrays:
    """p pairs of b bodies.

    Attributes:
        pairs: themselves.
        bodies: their bodies.
        sides: (2, p) numbers of both bodies of each.
        reach: (joints of the arm, b) distance of each body's points from each axis, m, at most.
        centre: (b, 3) of the ball about each body in its joint's frame, m.
        radii: (p,) of both balls together, m; of the first alone where the second is a half-space.
        outwards: (p, 3) direction in which a half-space is left, from first to second; zero of other pairs.
        capsules: (p,) whether both are capsules.
        carried: (p,) whether the first is carried by the arm and the second a link.
        groups: numbers of the pairs of each subject, in the order of their first ones.
    """

    pairs: tuple[Pair, ...]
    bodies: BodyArrays
    sides: np.ndarray
    reach: np.ndarray
    centre: np.ndarray
    radii: np.ndarray
    outwards: np.ndarray
    capsules: np.ndarray
    carried: np.ndarray
    groups: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, chain: BodyChain, pairs: Sequence[Pair]) -> PairArrays:
        """Of one pair or more, on this arm."""
        numbers: dict[Body, int] = {}
        both = [(pair.first, pair.second) for pair in pairs]
        sides = np.array([[numbers.setdefault(body, len(numbers)) for body in bodies] for bodies in both])
        subjects: dict[str, list[int]] = {}
        for number, pair in enumerate(pairs):
            subjects.setdefault(pair.subject, []).append(number)
        reach = [
            axis_reach(chain, body.joint, body.points, float(np.max(body.shape.discs, initial=0.0))) for body in numbers
        ]
        halfspace = np.array([two.shape.kind == "halfspace" for _, two in both])
        return cls(
            pairs=tuple(pairs),
            bodies=BodyArrays.of(list(numbers)),
            sides=sides.T,
            reach=np.array(reach).T,
            centre=np.array([body.centre for body in numbers]),
            radii=np.array([one.radius + (0.0 if two.shape.kind == "halfspace" else two.radius) for one, two in both]),
            outwards=-1.0 * halfspace[:, None] * np.array([two.rotation[:, 2] for _, two in both]),
            capsules=np.array([are_capsules(*bodies) for bodies in both]),
            carried=np.array([pair.of_arm and pair.first.on_path for pair in pairs]),
            groups=tuple(map(tuple, subjects.values())),
        )

    def ball_gaps(self, frames: JointFrames, time: np.ndarray) -> np.ndarray:
        """Gaps (p, k), m, between the balls about both bodies of each pair for times (k,), s, about configurations."""
        joint = self.bodies.joint
        arm = (frames.rotation[joint] @ self.centre[:, None, :, None])[..., 0]
        centre = frames.position[joint] + arm
        speed = frames.velocity[joint] + cross(frames.angular_velocity[joint], arm)
        first, second = self.sides
        gap = centre[second] - centre[first]
        direction = gap / np.maximum(np.linalg.norm(gap, axis=2, keepdims=True), 1e-12)
        flat = np.any(self.outwards, axis=1)
        direction[flat] = self.outwards[flat, None]
        closing = np.abs(np.sum(direction * (speed[second] - speed[first]), axis=2)) * time
        return np.sum(direction * gap, axis=2) - self.radii[:, None] - closing  # type: ignore[no-any-return]


@lru_cache(maxsize=8)
def arrays_of_pairs(scene: Scene, loaded: bool) -> tuple[PairArrays | None, PairArrays | None]:
    """The pairs with obstacles and regions, and those of the arm with itself and its load; None where there are none.

    Those of the last few scenes are kept, as `scene_pairs` are.
    """
    pairs, chain = scene_pairs(scene, loaded=loaded), arm_chain(scene.robot)
    around, own = ([pair for pair in pairs if pair.of_arm is of_arm] for of_arm in (False, True))
    return (PairArrays.of(chain, around) if around else None), (PairArrays.of(chain, own) if own else None)
