"""Views: what the camera rides on, that everything is in the picture, and that the cups are large in it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nospill.drawing.props import Kind, SceneBuilder, limit_ring
from nospill.drawing.stage import axes_facing, framed
from nospill.drawing.timeline import Film
from nospill.drawing.views import CLOSE, View, arrangement, camera_frame, headings, load_outline, viewpoint
from nospill.film.picture import draw
from nospill.film.raster import Canvas, Triangles, clipped, nearest

SIZE = (96, 72)
ASPECT = SIZE[0] / SIZE[1]


def share_of_objects(hand: SceneBuilder, index: int, view: View, aspect: float) -> float:
    """Part of the picture in which one sees an object on the tray, by pixels; what the arm hides does not count.

    Obstacles are drawn like glass, through which one sees.
    """
    film = hand.film
    camera, ride = viewpoint([film], view, aspect=aspect), camera_frame(film, view)
    canvas = Canvas.of(camera, round(72 * aspect), 72)
    rotation = ride.rotation[index] @ axes_facing(camera.position - camera.look_at)
    origin = ride.position[index] + ride.rotation[index] @ camera.position
    bodies = [body for body in hand.bodies(index) if body.kind is not Kind.MARK]
    solid = [body for body in bodies if body.kind is not Kind.GLASS or body.group]
    corners = [((body.mesh.vertices - origin) @ rotation)[body.mesh.faces] for body in solid]
    label = np.concatenate([np.full(len(own), bool(body.group)) for own, body in zip(corners, solid, strict=True)])
    joined = np.concatenate(corners)
    surface = nearest(canvas, clipped(Triangles(joined, np.ones(joined.shape[:2]), label.astype(int))))
    return float(np.sum(surface.label)) / (canvas.width * canvas.height)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["matrix-liquid-tilt", "pp-two-cups", "coffee-to-go", "mixed-tray", "soup-and-wine", "vial-rack"]
)  # the trays of the other examples, as they are planned: tests/system/test_example_films.py
def test_objects_fill_a_tenth_of_the_picture_throughout(name: str, example_film: Callable[[str], Film]) -> None:
    film = example_film(name)
    hand = SceneBuilder(film, path=False)
    for view in CLOSE:
        for aspect in (0.89, 16 / 9):
            assert min(share_of_objects(hand, index, view, aspect) for index in range(0, len(film.t), 6)) >= 0.1


def test_a_heading_is_what_is_left_without_the_tilt() -> None:
    rng = np.random.default_rng(1)
    turn = rng.uniform(-np.pi, np.pi, 20)
    direction = rng.uniform(0, 2 * np.pi, 20)
    swing = np.column_stack([np.cos(direction), np.sin(direction), np.zeros(20)]) * rng.uniform(0, 1, (20, 1))
    whole = Rotation.from_euler("z", turn[:, None]) * Rotation.from_rotvec(swing)
    assert headings(whole.as_matrix()) == pytest.approx(Rotation.from_euler("z", turn[:, None]).as_matrix())


def test_carriages(tilting_film: Film) -> None:
    follow = camera_frame(tilting_film, View.TRAY)
    above = np.einsum("mi,mi->m", follow.position - tilting_film.tray_position, tilting_film.tray_rotation[:, :, 2])
    tallest = max(item.container.height for item in tilting_film.plan.scene.cargo)
    assert above == pytest.approx(np.full(len(above), tallest / 2))
    assert np.all(follow.rotation[:, 2] == (0.0, 0.0, 1.0))  # level
    fixed = load_outline(tilting_film, View.FIXED)
    assert fixed == pytest.approx(np.broadcast_to(fixed[0], fixed.shape))  # the tray stands still
    still = camera_frame(tilting_film, View.ARM)
    assert np.all(still.position == 0.0)
    position, rotation = follow.base(5)
    assert rotation @ follow.position[5] + position == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize("view", CLOSE)
def test_tray_and_objects_stay_in_the_picture(view: View, tilting_film: Film) -> None:
    camera = viewpoint([tilting_film], view, aspect=ASPECT)
    axes = axes_facing(camera.position - camera.look_at)
    seen = (load_outline(tilting_film, view).reshape(-1, 3) - camera.position) @ axes
    pixels = Canvas.of(camera, *SIZE).project(seen)
    assert pixels[:, 0].min() >= -0.5
    assert pixels[:, 0].max() <= SIZE[0] - 0.5
    assert pixels[:, 1].min() >= -0.5
    assert pixels[:, 1].max() <= SIZE[1] - 0.5


def test_the_nearest_camera_touches_the_edges() -> None:
    rng = np.random.default_rng(2)
    points = rng.uniform(-1, 1, (200, 3))
    camera = framed(points, np.array([1.0, 0.4, 0.5]), aspect=1.5, angle=0.6)
    axes = axes_facing(camera.position - camera.look_at)
    seen = (points - camera.position) @ axes
    x, y = seen[:, 0] / -seen[:, 2] / np.tan(0.3) / 1.5, seen[:, 1] / -seen[:, 2] / np.tan(0.3)
    assert 0.9 < max(np.abs(x).max(), np.abs(y).max()) <= 1.0


def test_two_trays_stand_apart(tilting_film: Film, level_film: Film) -> None:
    places, camera = arrangement([level_film, tilting_film], View.TRAY, aspect=1.2)
    right = axes_facing(camera.position - camera.look_at)[:, 0]
    assert (places[1] - places[0]) @ right > np.hypot(*level_film.plan.scene.tray.size)


@pytest.mark.parametrize("view", list(View))
def test_a_picture_shows_water_and_limit_rings(view: View, tilting_film: Film) -> None:
    hand, index = SceneBuilder(tilting_film, path=view not in CLOSE), 0
    picture = draw(
        hand, index, viewpoint([tilting_film], view, aspect=ASPECT), camera_frame(tilting_film, view), size=SIZE
    )
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    red, green, blue = np.moveaxis(picture.astype(int), 2, 0)
    water = np.mean((blue > red + 60) & (blue > green + 20))
    if view in CLOSE:
        assert water > 0.04
        assert np.any((red > green + 30) & (green > blue))  # the ring at the limit
    else:
        assert water > 0.0


def test_the_free_surface_is_drawn_where_the_judge_has_it(tilting_film: Film) -> None:
    """The line round the water's edge touches the ring at the limit where the height is at its limit."""
    name, track = next(iter(tilting_film.liquids.items()))
    cargo = next(item for item in tilting_film.plan.scene.cargo if item.name == name)
    index = int(np.argmax(track.height))
    ring = limit_ring(cargo)
    assert ring is not None
    assert cargo.filling is not None
    assert ring.vertices[:, 2].mean() == pytest.approx(cargo.filling.liquid_height + cargo.filling.max_slosh_height)
    hand = SceneBuilder(tilting_film, path=False)
    bodies = [body for body in hand.bodies(index) if body.group == name and body.kind is Kind.MARK]
    up = tilting_film.tray_rotation[index][:, 2]
    edge = (bodies[0].mesh.vertices - tilting_film.tray_position[index]) @ up
    rise = edge.max() - cargo.filling.liquid_height
    assert rise == pytest.approx(track.height[index], rel=0.05, abs=1.5e-3)
