"""The bodies of a scene: the arm's capsules, what holds the tray, the tray, the objects on it, the obstacles.

An object whose place may be off fills all places that its tolerance allows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nospill.core.shapes import Shape, box_shape, capsule_shape, hull_shape
from nospill.robots.capsules import PlacedCapsule, placed_capsules
from nospill.robots.description.urdf_tree import about_axis
from nospill.robots.kinematics.bodies import z_to
from nospill.robots.kinematics.frames import arm_chain
from nospill.robots.tool import Tool
from nospill.scene.cargo import Cargo
from nospill.scene.obstacles import Obstacle
from nospill.scene.scene import Scene
from nospill.scene.tray import TRAY_THICKNESS

TRAY, HOLDER, LOAD = "tray", "holder", "tray and cargo"
HOLDER_RADIUS = 0.025
"""m; the tray stands on a round bar from the flange to the middle of its underside, or on two of a bracket."""


@dataclass(frozen=True, eq=False)
class Body:
    """A convex solid fixed to a joint's frame (as in `robots.kinematics.bodies`) or standing still.

    Attributes:
        name: of the link, the object, the obstacle; several bodies of a link share it.
        joint: number of the moving joints before it, 0 for what stands still.
        shape: in its own frame.
        position: (3,) origin of that frame in the joint's frame, m.
        rotation: (3, 3) axes of the same.
        obstacle: of which it is the solid; None for what the arm is and carries.
        of_region: whether it is beyond a side of a region, from which tray and cargo keep away, as one.
        on_path: whether it is the tray or stands on it, and so goes where the path leads whatever the arm does.
        place_tolerance: how far the object may be off its place, m, either side in x and y of the tray; the body holds
            all of it.
    """

    name: str
    joint: int
    shape: Shape
    position: np.ndarray
    rotation: np.ndarray
    obstacle: Obstacle | None = None
    on_path: bool = False
    of_region: bool = False
    place_tolerance: float = 0.0

    @property
    def of_arm(self) -> bool:
        """Whether it is a link or the holder, and so a capsule."""
        return self.obstacle is None and not self.on_path

    @cached_property
    def points(self) -> np.ndarray:
        """(k, 3) corners of the core in the joint's frame, m."""
        return self.position + self.shape.points @ self.rotation.T

    @cached_property
    def centre(self) -> np.ndarray:
        """(3,) centre of the ball about it in the joint's frame, m."""
        return self.position + self.rotation @ self.shape.centre

    @cached_property
    def radius(self) -> float:
        """Of the ball about it, m; infinite for a half-space."""
        return self.shape.radius


def region_bodies(scene: Scene, *, loaded: bool = True) -> tuple[Body, tuple[Body, ...]]:
    """Tray and cargo as one body, their hull, and the half-spaces beyond the sides of all regions."""
    parts = _on_path(scene, scene.cargo if loaded else ())
    tray = parts[0]
    points = [(item.points - tray.position) @ tray.rotation for item in parts]
    shape = hull_shape(np.concatenate(points), np.concatenate([item.shape.discs for item in parts]))
    off = max(item.place_tolerance for item in parts)
    load = Body(LOAD, tray.joint, shape, tray.position, tray.rotation, on_path=True, place_tolerance=off)
    sides = [
        Body(side.name, 0, side.shape, side.position, side.rotation, side, of_region=True)
        for region in scene.regions
        for side in region.sides
    ]
    return load, tuple(sides)


def scene_bodies(scene: Scene, *, loaded: bool = True) -> tuple[Body, ...]:
    """All bodies, base to tip, then tray, cargo and obstacles.

    Args:
        scene: the task.
        loaded: whether the cargo is on the tray.

    Raises:
        ScenarioError: the arm's description cannot be read.
    """
    arm = [_capsule(item) for item in placed_capsules(scene.robot)]
    still = [Body(item.name, 0, item.shape, item.position, item.rotation, item) for item in scene.obstacles]
    return (*arm, *_load_bodies(scene, scene.cargo if loaded else ()), *still)


def _load_bodies(scene: Scene, cargo: Sequence[Cargo]) -> list[Body]:
    """Holder, tray and cargo in the frame of the last joint."""
    chain = arm_chain(scene.robot)
    tray, *objects = _on_path(scene, cargo)
    if not scene.tray.tool.upright:
        corners = chain.flange_position + bracket_corners(scene.tray.tool) @ chain.flange_rotation.T
        legs = (PlacedCapsule(HOLDER, len(chain.bodies), ends, HOLDER_RADIUS) for ends in (corners[:2], corners[1:]))
        return [tray, *map(_capsule, legs), *objects]
    flange, under = chain.flange_position, tray.position - TRAY_THICKNESS / 2 * tray.rotation[:, 2]
    gap = under - flange
    if float(np.linalg.norm(gap)) <= 2 * HOLDER_RADIUS:
        return [tray, *objects]
    # its round ends stay between flange and board
    inner = gap * (1.0 - 2.0 * HOLDER_RADIUS / float(np.linalg.norm(gap)))
    middle = flange + gap / 2
    ends = np.array([middle - inner / 2, middle + inner / 2])
    return [tray, _capsule(PlacedCapsule(HOLDER, len(chain.bodies), ends, HOLDER_RADIUS)), *objects]


def bracket_corners(tool: Tool) -> np.ndarray:
    """Ends and corner (3, 3) of the L on which a turned tray stands: middle lines of its round bars, flange axes, m.

    The first bar lies on the flange, along the tray's normal; the second one below the board, to its middle.
    """
    normal = tool.rotation[:, 2]
    start = np.array([0.0, 0.0, HOLDER_RADIUS])
    end = np.asarray(tool.position, dtype=float) - (TRAY_THICKNESS + HOLDER_RADIUS) * normal
    return np.array([start, start + normal * (normal @ (end - start)), end])


def _on_path(scene: Scene, cargo: Sequence[Cargo]) -> list[Body]:
    """Tray and cargo in the frame of the last joint."""
    chain, tool = arm_chain(scene.robot), scene.tray.tool
    last, axes = len(chain.bodies), chain.flange_rotation
    position, rotation = chain.flange_position + axes @ tool.position, axes @ tool.rotation
    up, (length, width) = rotation[:, 2], scene.tray.size
    board = box_shape((float(length), float(width), TRAY_THICKNESS))
    bodies = [Body(TRAY, last, board, position - TRAY_THICKNESS / 2 * up, rotation, on_path=True)]
    for item in cargo:
        turn = rotation @ about_axis((0.0, 0.0, 1.0), item.yaw)
        place, off = position + rotation @ item.place, _place_tolerance(item, cargo)
        shape = cargo_shape(item, place_tolerance=off)
        bodies.append(Body(item.name, last, shape, place, turn, on_path=True, place_tolerance=off))
    return bodies


def _place_tolerance(item: Cargo, cargo: Sequence[Cargo]) -> float:
    """How far an object may be off its place, m, either side in x and y: with its carrier where it stands in one."""
    standing = next((other for other in cargo if other.name == item.carrier), item)
    return standing.tolerance.position if standing.tolerance else 0.0


def cargo_shape(item: Cargo, *, place_tolerance: float = 0.0) -> Shape:
    """The outside of an object up to its rim, without its hollows, in the container frame.

    Args:
        item: the object.
        place_tolerance: m, either side along the tray's x and y; the shape holds the object at all of these places.
    """
    footprint, outside = item.container.footprint, item.container.outside
    points, discs = [], []
    for share, at in outside:
        core = share * footprint.core
        if place_tolerance:
            core = _at_all_places(core, place_tolerance, item.yaw)
        points.append(np.column_stack([core, np.full(len(core), at)]))
        discs.append(np.full(len(core), share * footprint.rounding))
    return hull_shape(np.concatenate(points), np.concatenate(discs))


def _at_all_places(core: np.ndarray, off: float, yaw: float) -> np.ndarray:
    """Corners (m, 2) of the hull of points (k, 2) of an object moved by up to `off` along x and y of the tray."""
    # imported here: needed for places that may be off only
    from scipy.spatial import ConvexHull

    cosine, sine = np.cos(yaw), np.sin(yaw)
    corners = off * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) @ [[cosine, -sine], [sine, cosine]]
    points = (core[:, None] + corners).reshape(-1, 2)
    return points[ConvexHull(points).vertices]


def _capsule(item: PlacedCapsule) -> Body:
    axis = item.ends[1] - item.ends[0]
    length = float(np.linalg.norm(axis))
    rotation = z_to(axis) if length > 0.0 else np.eye(3)
    shape = capsule_shape(item.radius, length + 2.0 * item.radius)
    return Body(item.link, item.joint, shape, item.ends.mean(axis=0), rotation)
