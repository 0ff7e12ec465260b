"""Bodies as arrays: places, axes and corners of many of them, each at a configuration of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nospill.collisions.bodies import Body
from nospill.robots.kinematics.frames import JointFrames


@dataclass(frozen=True, slots=True, eq=False)
class Cores:
    """Those of b bodies whose cores have as many corners, k.

    Attributes:
        points: (b, k, 3) in the joint's frame, m.
        discs: (b, k) radius of the disc at each of them, m.
    """

    points: np.ndarray
    discs: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class BodyArrays:
    """Numbers of b bodies.

    Attributes:
        joint: (b,) number of the moving joints before each.
        position: (b, 3) origin of its own frame in the joint's, m.
        rotation: (b, 3, 3) axes of the same; its discs are about the last one.
        ends: (b, 2, 3) its first and its last corner in the joint's frame, m: of a capsule the ends of its axis.
        ball: (b,) radius by which it is rounded, m.
        cores: of the bodies, by their number of corners.
        core: (b,) in which of these it is.
        place: (b,) and where there.
    """

    joint: np.ndarray
    position: np.ndarray
    rotation: np.ndarray
    ends: np.ndarray
    ball: np.ndarray
    cores: tuple[Cores, ...]
    core: np.ndarray
    place: np.ndarray

    @classmethod
    def of(cls, bodies: Sequence[Body]) -> BodyArrays:
        """Of one body or more."""
        corners = np.array([len(body.points) for body in bodies])
        counts, core = np.unique(corners, return_inverse=True)
        place, cores = np.zeros(len(bodies), dtype=int), []
        for number in range(len(counts)):
            own = np.flatnonzero(core == number)
            place[own] = np.arange(len(own))
            some = [bodies[index] for index in own.tolist()]
            cores.append(Cores(np.array([item.points for item in some]), np.array([item.shape.discs for item in some])))
        return cls(
            joint=np.array([body.joint for body in bodies]),
            position=np.array([body.position for body in bodies]),
            rotation=np.array([body.rotation for body in bodies]),
            ends=np.array([body.points[[0, -1]] for body in bodies]),
            ball=np.array([body.shape.ball for body in bodies]),
            cores=tuple(cores),
            core=core,
            place=place,
        )

    def poses(self, which: np.ndarray, frames: JointFrames, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (m, 3), m, and axes (m, 3, 3) of bodies' own frames, by their numbers (m,), at samples (m,)."""
        joint = self.joint[which]
        turns = frames.rotation[joint, samples]
        position = frames.position[joint, samples] + (turns @ self.position[which][:, :, None])[:, :, 0]
        return position, turns @ self.rotation[which]

    def ends_at(self, which: np.ndarray, frames: JointFrames, samples: np.ndarray) -> np.ndarray:
        """(m, 2, 3) ends of the axes of capsules, by their numbers (m,), in base axes, m."""
        joint = self.joint[which]
        turned = self.ends[which] @ np.swapaxes(frames.rotation[joint, samples], 1, 2)
        return frames.position[joint, samples][:, None] + turned
