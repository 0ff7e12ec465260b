"""One picture of a plan: bodies lit, shadows, glass, ground."""

from __future__ import annotations

import numpy as np

from nospill.drawing.geometry import corner_normals, unit_vectors
from nospill.drawing.props import Body, Kind, SceneBuilder
from nospill.drawing.stage import Camera, axes_facing
from nospill.drawing.views import CameraFrame
from nospill.film.ground import ground_colours
from nospill.film.raster import (
    Canvas,
    Triangles,
    clipped,
    covered,
    facing,
    layer,
    nearest,
)

SAMPLES = 2
"""Samples a pixel along each side."""

_LIGHT = np.array([-0.55, 0.25])
"""Direction to the light for one upwards: to the right of the camera, and towards it. It goes with the carriage, so
that colours do not change on the way."""
_AMBIENT, _DIFFUSE = 0.62, 0.42
_ON_BOARD, _ON_GROUND = 0.80, 0.87
"""Brightness in a shadow."""
_GLASS_FACE, _GLASS_EDGE = 0.10, 0.62
"""Opacity of glass seen straight and along its wall."""
_GLASS_TONE = 0.92
"""Brightness of glass, which no lamp lights."""


def draw(hand: SceneBuilder, index: int, camera: Camera, ride: CameraFrame, *, size: tuple[int, int]) -> np.ndarray:
    """A picture of a film as (height, width, 3), 0 to 255.

    Args:
        hand: whose bodies.
        index: of the picture.
        camera: on its carriage.
        ride: the carriage.
        size: width and height, px.
    """
    width, height = size
    canvas = Canvas.of(camera, SAMPLES * width, SAMPLES * height)
    axes = axes_facing(camera.position - camera.look_at)
    rotation = ride.rotation[index] @ axes
    origin = ride.position[index] + ride.rotation[index] @ camera.position
    bodies = hand.bodies(index)
    sun = ride.rotation[index] @ _light(camera)
    light = rotation.T @ sun
    colours = np.array([body.colour for body in bodies])
    boards = np.array([body.kind is Kind.BOARD for body in bodies])

    opaque = [(number, body) for number, body in enumerate(bodies) if body.kind is not Kind.GLASS]
    triangles = clipped(_lit(opaque, origin, rotation, light))
    marks = np.array([body.kind is Kind.MARK for body in bodies])
    surface = nearest(canvas, triangles.of(facing(triangles) | marks[triangles.label]))

    lookout = origin, rotation
    colour = ground_colours(camera, lookout, (width, height), samples=SAMPLES).reshape(-1, 3)
    _darken_ground(colour, bodies, lookout, canvas)
    colour[surface.pixel] = np.clip(colours[surface.label] * surface.shade[:, None], 0.0, 255.0)
    _darken_board(colour, bodies, hand, index, sun, lookout, canvas, surface.pixel[boards[surface.label]])
    for number in _far_to_near(bodies, origin):
        wall = clipped(_glass(number, bodies[number], origin, rotation))
        front = facing(wall)
        for side in (~front, front):
            pixel, _, opacity = layer(canvas, wall.of(side), surface)
            colour[pixel] += opacity[:, None].astype(np.float32) * (
                colours[number].astype(np.float32) * 0.92 - colour[pixel]
            )
    samples = colour.reshape(height, SAMPLES, width, SAMPLES, 3)
    # a sum of slices takes a third of the time that the mean over two short axes takes
    mixed = sum(samples[:, i, :, j] for i, j in np.ndindex(SAMPLES, SAMPLES)) / np.float32(SAMPLES**2)
    return np.clip(np.rint(mixed), 0, 255).astype(np.uint8)


def _light(camera: Camera) -> np.ndarray:
    axes = axes_facing(camera.position - camera.look_at)
    direction = np.array([0.0, 0.0, 1.0]) + axes[:, 0] * _LIGHT[0] + axes[:, 2] * _LIGHT[1]
    return direction / np.linalg.norm(direction)


def _lit(bodies: list[tuple[int, Body]], origin: np.ndarray, rotation: np.ndarray, light: np.ndarray) -> Triangles:
    """Bodies in camera coordinates with the light at their corners; marks shine by themselves."""
    corners, shades, labels = [], [], []
    for number, body in bodies:
        corners.append(((body.mesh.vertices - origin) @ rotation)[body.mesh.faces])
        if body.kind is Kind.MARK:
            shade = np.ones((len(body.mesh.faces), 3))
        else:
            normals = corner_normals(body.mesh) @ rotation
            shade = _AMBIENT + _DIFFUSE * (0.5 + 0.5 * (normals @ light))
        shades.append(shade)
        labels.append(np.full(len(body.mesh.faces), number))
    return Triangles(np.concatenate(corners), np.concatenate(shades), np.concatenate(labels))


def _glass(number: int, body: Body, origin: np.ndarray, rotation: np.ndarray) -> Triangles:
    """A wall with its opacity at the corners, which grows where it is seen along."""
    corners = ((body.mesh.vertices - origin) @ rotation)[body.mesh.faces]
    normals = corner_normals(body.mesh) @ rotation
    straight = np.abs(np.einsum("kci,kci->kc", normals, unit_vectors(corners)))
    opacity = _GLASS_FACE + (_GLASS_EDGE - _GLASS_FACE) * (1.0 - straight) ** 3
    return Triangles(corners, opacity, np.full(len(corners), number))


def _far_to_near(bodies: list[Body], origin: np.ndarray) -> list[int]:
    glass = [number for number, body in enumerate(bodies) if body.kind is Kind.GLASS]
    return sorted(glass, key=lambda number: -float(np.linalg.norm(bodies[number].mesh.vertices.mean(axis=0) - origin)))


def _shadow(
    bodies: list[Body],
    plane: tuple[np.ndarray, np.ndarray],
    light: np.ndarray,
    lookout: tuple[np.ndarray, np.ndarray],
    canvas: Canvas,
) -> np.ndarray:
    """Mask (pixels,) of the shadow of bodies on a plane (a point and the normal) in light from a direction."""
    point, normal = plane
    origin, rotation = lookout
    pieces = []
    for body in bodies:
        above = body.mesh.vertices - np.outer((body.mesh.vertices - point) @ normal / (light @ normal), light)
        pieces.append(((above - origin) @ rotation)[body.mesh.faces])
    corners = np.concatenate(pieces)
    triangles = clipped(Triangles(corners, np.zeros(corners.shape[:2]), np.zeros(len(corners), dtype=int)))
    return covered(canvas, triangles)


def _darken_ground(
    colour: np.ndarray, bodies: list[Body], lookout: tuple[np.ndarray, np.ndarray], canvas: Canvas
) -> None:
    solid = [body for body in bodies if body.kind in (Kind.OPAQUE, Kind.BOARD)]
    up = np.array([0.0, 0.0, 1.0])
    if lookout[0][2] > 0.0:
        colour[_shadow(solid, (np.zeros(3), up), up, lookout, canvas)] *= np.float32(_ON_GROUND)


def _darken_board(
    colour: np.ndarray,
    bodies: list[Body],
    hand: SceneBuilder,
    index: int,
    sun: np.ndarray,
    lookout: tuple[np.ndarray, np.ndarray],
    canvas: Canvas,
    seen: np.ndarray,
) -> None:
    """Shadows of the objects on the tray, thrown slantwise as the light falls."""
    load = [body for body in bodies if body.group and body.kind in (Kind.OPAQUE, Kind.GLASS)]
    if not load or not len(seen):
        return
    normal = hand.film.tray_rotation[index][:, 2]
    mask = _shadow(load, (hand.film.tray_position[index], normal), sun, lookout, canvas)
    dark = seen[mask[seen]]
    colour[dark] *= np.float32(_ON_BOARD)
