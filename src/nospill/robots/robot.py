"""A robot: its chain as URDF text, its joint limits and where each figure comes from."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nospill.core.arrays import read_only
from nospill.robots.tracking import KnownTracking


@dataclass(frozen=True, slots=True)
class LinkCapsule:
    """All within `radius` of a segment.

    Attributes:
        link: that it belongs to.
        start: of the segment in the link's frame, m.
        end: likewise.
        radius: m.
    """

    link: str
    start: tuple[float, ...]
    end: tuple[float, ...]
    radius: float


@dataclass(frozen=True, slots=True)
class Doubt:
    """Something in the description of an arm that is hardly meant, or is stated and does not bind.

    Attributes:
        about: the same for all subjects: "tip", "joint speed", "joint torque".
        subject: link, joint or arm.
        text: a sentence or more with value, reason and what to try.
    """

    about: str
    subject: str
    text: str


@dataclass(frozen=True, slots=True)
class LinkMesh:
    """A mesh of a link as a package has it.

    Attributes:
        link: that it belongs to.
        file: from the folder of the package's meshes, STL or OBJ, in m.
        position: of the mesh's frame in the link's, m.
        rpy: likewise, turns about the fixed axes x, y, z, rad.
    """

    link: str
    file: str
    position: tuple[float, ...]
    rpy: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class PackagedMeshes:
    """Meshes of an arm that an installed package brings, for pictures.

    Attributes:
        package: its name on the Python package index.
        folder: of the meshes, from where packages are installed.
        links: what is drawn.
    """

    package: str
    folder: str
    links: tuple[LinkMesh, ...]


@dataclass(frozen=True, slots=True)
class Braking:
    """Joint speed limits that fall towards the ends of the joints' ranges, as far as a joint needs to stop there.

    At q it moves up no faster than sqrt(2 deceleration (upper - q)) - offset, and down no faster than
    sqrt(2 deceleration (q - lower)) - offset. All (n,) but the last.

    Attributes:
        lower: where the joints stop, rad; at or outside the limits of their positions.
        upper: likewise.
        deceleration: rad/s^2.
        offset: rad/s.
        ahead: s; the place is that where the joint is so much later, at its speed.
    """

    lower: np.ndarray
    upper: np.ndarray
    deceleration: np.ndarray
    offset: np.ndarray
    ahead: float = 0.0

    def scaled(self, factor: float) -> Braking:
        """The limits that are a part of these everywhere: k (sqrt(2 a w) - c) is sqrt(2 (k^2 a) w) - k c."""
        return replace(
            self, deceleration=read_only(factor**2 * self.deceleration), offset=read_only(factor * self.offset)
        )


@dataclass(frozen=True, slots=True)
class Robot:
    """A serial arm.

    Attributes:
        name: key in the catalogue or file stem.
        title: name for people.
        urdf: URDF text without meshes.
        joints: names of the moving joints, base to tip, shape of every array below: (n,).
        tip: the flange link.
        lower: joint position limits, rad.
        upper: likewise.
        max_speed: joint speed limits, rad/s.
        max_acceleration: joint acceleration limits, rad/s^2, or None where they are not limited.
        max_jerk: joint jerk limits, rad/s^3, or None.
        max_torque: joint torque limits, N m, infinite for a joint without one, or None where no joint has any.
        braking: what limits joint speeds near the ends of the ranges beside `max_speed`, or None.
        inertias_known: whether the URDF's masses and inertias are real, so that torques of joints with a limit can be
            computed.
        home: (n,) configuration the arm stands in before and after, rad, or None. The scenario's if it gives one, else
            the catalogue's.
        payload: kg, or None.
        reach: m, or None.
        sources: quantity -> where the figure comes from.
        not_known: quantities nobody states for this arm, in words.
        base_frame: which frame its root is, in words; empty where nobody states it.
        controller_base_turn: turn of the controller's own base frame against the root about z, rad, or None where it is
            not known.
        capsules: what its links fill, for collisions; those of its chain where there are none.
        self_collision: whether the arm is kept from touching itself, its tray and its cargo.
        meshes: what an installed package shows of it, or None.
        notes: what was assumed when its description was read, one sentence each, for people.
        doubts: what in its description is hardly meant, or stated and not applied.
        interfaces: by which it takes commands, names of `interfaces.INTERFACES`; None where nobody says.
        tracking: how late others found it to be; nothing is planned with it.
    """

    name: str
    title: str
    urdf: str
    joints: tuple[str, ...]
    tip: str
    lower: np.ndarray
    upper: np.ndarray
    max_speed: np.ndarray
    max_acceleration: np.ndarray | None
    payload: float | None
    reach: float | None
    sources: dict[str, str]
    not_known: tuple[str, ...] = ()
    max_jerk: np.ndarray | None = None
    max_torque: np.ndarray | None = None
    inertias_known: bool = False
    home: np.ndarray | None = None
    notes: tuple[str, ...] = ()
    base_frame: str = ""
    controller_base_turn: float | None = None
    capsules: tuple[LinkCapsule, ...] = ()
    self_collision: bool = True
    meshes: PackagedMeshes | None = None
    braking: Braking | None = None
    doubts: tuple[Doubt, ...] = ()
    interfaces: tuple[str, ...] | None = None
    tracking: tuple[KnownTracking, ...] = ()
