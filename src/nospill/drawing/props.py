"""Everything that a drawn film shows of a plan, as bodies in frames that move: arm, tray, objects, liquids, marks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto
from itertools import pairwise

import numpy as np

from nospill.drawing.arm_bodies import arm_bodies
from nospill.drawing.colours import GREEN, GREY, PURPLE, RED, rgb, use_colours
from nospill.drawing.geometry import (
    Mesh,
    bands,
    board,
    capsule,
    contact_collar,
    container_body,
    drawn_section,
    half_width,
    outline_at,
    ribbon,
    shrunk,
    transform_mesh,
    tube,
    wall_thickness,
)
from nospill.drawing.obstacles import OBSTACLE, obstacle_mesh
from nospill.drawing.robot_model import read_chain
from nospill.drawing.surfaces import LiquidSurface, liquid_surface
from nospill.drawing.timeline import Film
from nospill.scene.cargo import Cargo
from nospill.scene.tray import TRAY_THICKNESS

ARM, BOARD, CUP, SOLID = (176, 181, 187), (222, 205, 178), (214, 226, 234), (143, 128, 160)
"""Colours of what carries none of a use."""

_PATH_POINTS, _PATH_RADIUS, _END_RADIUS = 60, 0.003, 0.011
_RING = 0.0013
"""m; height of the ring at the limit and of the line round the water's edge."""
_INK = np.array([25.0, 35.0, 45.0])


class Kind(Enum):
    """How a body is drawn."""

    OPAQUE = auto()
    GLASS = auto()
    BOARD = auto()
    """Opaque, and shows the shadows of what stands on it."""
    MARK = auto()
    """Opaque, in its own colour in any light, without a shadow."""


@dataclass(frozen=True, slots=True)
class Body:
    """A mesh with one colour, in place.

    Attributes:
        mesh: in the base frame, m.
        colour: (3,), 0 to 255.
        kind: how it is drawn.
        group: name of the object it belongs to; empty for arm, tray and path.
    """

    mesh: Mesh
    colour: np.ndarray
    kind: Kind
    group: str = ""


@dataclass(frozen=True, slots=True)
class Placed:
    """Where an object is on its tray, a picture at a time.

    Attributes:
        position: (m, 3) of its bottom centre in the tray frame, m.
        rotation: (m, 3, 3), its container frame to the tray's.
    """

    position: np.ndarray
    rotation: np.ndarray


def placement_at_rest(cargo: Cargo, count: int) -> Placed:
    """An object that stays where the scene has it, over so many pictures."""
    sine, cosine = np.sin(cargo.yaw), np.cos(cargo.yaw)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return Placed(np.broadcast_to(cargo.place, (count, 3)), np.broadcast_to(turn, (count, 3, 3)))


class SceneBuilder:
    """Bodies of a plan, made once and put in place for every picture.

    Attributes:
        film: what is shown.
    """

    def __init__(self, film: Film, *, path: bool, placed: Mapping[str, Placed] | None = None) -> None:
        """Make the bodies.

        Args:
            film: what is shown.
            path: whether the line is shown that the tray follows.
            placed: where the objects stand, where that is not where the scene has them.

        Raises:
            ScenarioError: the robot's URDF cannot be read.
        """
        self.film, self._placed = film, dict(placed or {})
        scene = film.plan.scene
        self._chain = read_chain(scene.robot.urdf, scene.robot.joints, scene.robot.tip)
        self._links = arm_bodies(scene.robot, self._chain, scene.tray)
        self._frames = self._chain.frames(film.joint_position)
        self._board = board(scene.tray.size, TRAY_THICKNESS)
        self._surfaces = {
            item.name: liquid_surface(item, scene.motion.slosh_height)
            for item in scene.cargo
            if item.filling is not None
        }
        self._path = _path_bodies(followed_line(film)) if path else []
        around = [mesh for item in scene.obstacles if (mesh := obstacle_mesh(item)) is not None]
        # like glass, so that nothing is hidden behind them
        self._around = [Body(mesh, np.array(OBSTACLE, dtype=float), Kind.GLASS) for mesh in around]
        for place in scene.motion.via:
            ball = transform_mesh(capsule(0.0, place.radius), np.array(place.position), np.eye(3))
            self._around.append(Body(ball, np.array(rgb(GREEN), dtype=float), Kind.GLASS))

    def bodies(self, index: int) -> list[Body]:
        """Everything at a picture of the film."""
        film, scene = self.film, self.film.plan.scene
        bodies = [*self._path, *self._around, *self._arm(index)]
        position, rotation = film.tray_position[index], film.tray_rotation[index]
        bodies.append(Body(transform_mesh(self._board, position, rotation), np.array(BOARD, dtype=float), Kind.BOARD))
        for cargo in scene.cargo:
            placed = self._where(cargo)
            foot, turned = position + rotation @ placed.position[index], rotation @ placed.rotation[index]
            for mesh, colour, kind in self._object(cargo, index):
                bodies.append(Body(transform_mesh(mesh, foot, turned), colour, kind, cargo.name))
        return bodies

    def _where(self, cargo: Cargo) -> Placed:
        """Where an object stands at every picture: what a carrier holds goes along with it."""
        count = len(self.film.t)
        carrier = self._placed.get(cargo.carrier)
        if carrier is None:
            return self._placed.get(cargo.name) or placement_at_rest(cargo, count)
        placed = placement_at_rest(cargo, count)
        rest = placement_at_rest(next(item for item in self.film.plan.scene.cargo if item.name == cargo.carrier), count)
        turn = carrier.rotation @ np.swapaxes(rest.rotation, 1, 2)
        arm = (turn @ (placed.position - rest.position)[:, :, None])[:, :, 0]
        return Placed(carrier.position + arm, turn @ placed.rotation)

    def _arm(self, index: int) -> list[Body]:
        colour = np.array(ARM, dtype=float)
        bodies = []
        base = self._links.get(self._chain.base)
        if base is not None:
            bodies.append(Body(base, colour, Kind.OPAQUE))
        for joint, (position, rotation) in zip(self._chain.joints, self._frames, strict=True):
            mesh = self._links.get(joint.child)
            if mesh is not None:
                bodies.append(Body(transform_mesh(mesh, position[index], rotation[index]), colour, Kind.OPAQUE))
        return bodies

    def _object(self, cargo: Cargo, index: int) -> list[tuple[Mesh, np.ndarray, Kind]]:
        """Meshes of an object in its container frame."""
        parts: list[tuple[Mesh, np.ndarray, Kind]] = []
        if not cargo.carrier:
            contact = use_colours(self.film.contact_use[cargo.name][index : index + 1])[0].astype(float)
            parts.append((contact_collar(cargo.container), contact, Kind.OPAQUE))
        if cargo.contents is not None:
            parts.append((_glass(cargo), np.array(SOLID, dtype=float), Kind.GLASS))
            return parts
        if cargo.filling is None:
            parts.append((container_body(cargo.container, hollow=False), np.array(SOLID, dtype=float), Kind.OPAQUE))
            return parts
        track = self.film.liquids[cargo.name]
        colour = use_colours(track.height[index : index + 1] / track.limit)[0].astype(float)
        parts += _liquid(self._surfaces[cargo.name], track.coordinates[index], colour)
        parts.append((_glass(cargo), np.array(CUP, dtype=float), Kind.GLASS))
        limit = limit_ring(cargo)
        if limit is not None:
            parts.append((limit, np.array(rgb(RED), dtype=float), Kind.MARK))
        rim = outline_at(cargo.container, cargo.container.height)
        parts.append((ribbon(_at(rim, cargo.container.height), _RING), np.array(rgb(GREY), dtype=float), Kind.MARK))
        return parts


def limit_ring(cargo: Cargo) -> Mesh | None:
    """A ring round a cup at the greatest height its liquid may reach, container frame; None above the rim or a lid."""
    assert cargo.filling is not None
    height = cargo.filling.liquid_height + cargo.filling.max_slosh_height
    if cargo.filling.lid or height > cargo.container.height:
        return None
    return ribbon(_at(shrunk(outline_at(cargo.container, height), -0.0006), height), _RING)


def _liquid(surface: LiquidSurface, coordinates: np.ndarray, colour: np.ndarray) -> list[tuple[Mesh, np.ndarray, Kind]]:
    """Side, free surface and the line round its edge: three tones, or the tilt is not seen."""
    vertices = surface.vertices(coordinates)
    flat = surface.upper_faces
    top, side = Mesh(vertices, surface.rest.faces[:flat]), Mesh(vertices, surface.rest.faces[flat:])
    edge = vertices[surface.edge]
    edge = np.column_stack([1.006 * edge[:, :2], edge[:, 2]])
    return [
        (side, colour, Kind.OPAQUE),
        (top, 0.55 * colour + 0.45 * 255.0, Kind.OPAQUE),
        (ribbon(edge, _RING), 0.45 * colour + 0.55 * _INK, Kind.MARK),
    ]


def _glass(cargo: Cargo) -> Mesh:
    """The wall alone, without a lid: what is seen of thin glass."""
    container = cargo.container
    outside, low = drawn_section(container.outside, half_width(container)), wall_thickness(container)
    return bands([size * container.outline for size in outside[:, 0]], np.maximum(outside[:, 1], low))


def followed_line(film: Film) -> np.ndarray:
    """The line (m, 3) that the tray follows, m: its path, or where it may leave that, its motion."""
    plan = film.plan
    if not plan.scene.motion.leaves_path:
        return plan.scene.path.at(np.linspace(0.0, 1.0, _PATH_POINTS))[:, :3]
    positions = plan.trajectory.tray_position
    return positions[np.linspace(0, len(positions) - 1, _PATH_POINTS).round().astype(int)]


def _path_bodies(points: np.ndarray) -> list[Body]:
    pieces = [
        Body(tube(start, end, (_PATH_RADIUS, _PATH_RADIUS), sides=6), _INK, Kind.MARK)
        for start, end in pairwise(points)
        if np.linalg.norm(end - start) > 1e-9
    ]
    up = np.array([0.0, 0.0, _END_RADIUS])
    for at, colour in ((points[0], GREEN), (points[-1], PURPLE)):
        pieces.append(Body(tube(at - up, at + up, (_END_RADIUS, _END_RADIUS)), np.array(rgb(colour), float), Kind.MARK))
    return pieces


def _at(outline: np.ndarray, height: float) -> np.ndarray:
    return np.column_stack([outline, np.full(len(outline), height)])
