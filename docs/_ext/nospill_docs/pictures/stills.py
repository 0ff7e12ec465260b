"""Pictures in perspective, drawn by the package's own film: moments of a motion, four views of it, all arms."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from nospill.drawing.arm_bodies import arm_bodies
from nospill.drawing.geometry import Mesh
from nospill.drawing.props import ARM, Body, Kind, SceneBuilder
from nospill.drawing.robot_model import read_chain
from nospill.drawing.stage import axes_facing, framed
from nospill.drawing.timeline import Film, make_film
from nospill.drawing.views import CLOSE, VIEW_NAMES, CameraFrame, View, camera_frame, viewpoint
from nospill.film.picture import draw
from nospill.film.raster import Canvas
from nospill.plans.approach import judged
from nospill.plans.plan import Plan
from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill_docs.pictures.paper import sheet

_RATE = 100.0
_APART = 1.3
"""m between the bases of two arms."""
_ASIDE = np.array([[0.5, 0.866, 0.0], [-0.866, 0.5, 0.0], [0.0, 0.0, 1.0]])
"""Turn of an arm that is to be seen from its side."""


def film_of(plan: Plan) -> Film:
    """A plan cut into pictures, ten to a tenth of a second."""
    return make_film(plan, judged(plan), rate=_RATE)


def moments(film: Film, view: View, times: Sequence[float], size: tuple[int, int]) -> list[np.ndarray]:
    """Pictures (height, width, 3) of a motion at some parts (0 to 1) of its time."""
    hand = SceneBuilder(film, path=view not in CLOSE)
    camera, ride = viewpoint([film], view, aspect=size[0] / size[1]), camera_frame(film, view)
    return [draw(hand, film.index(part * film.end_time), camera, ride, size=size) for part in times]


def save_moment(plan: Plan, path: Path, *, part: float = 0.62, size: tuple[int, int] = (960, 540)) -> None:
    """One moment of a motion, close to the tray, as a picture of its own."""
    Image.fromarray(moments(film_of(plan), View.TRAY, [part], size)[0]).save(path)


def strip(plan: Plan) -> Figure:
    """Six moments of a motion from near, with their times."""
    film = film_of(plan)
    parts = np.linspace(0.0, 1.0, 6)
    return _grid(
        moments(film, View.TRAY, parts.tolist(), (500, 380)),
        [f"{part * film.end_time:.2f} s" for part in parts],
        columns=3,
    )


def views(plan: Plan) -> Figure:
    """The same moment in all views of film and viewer."""
    film = film_of(plan)
    pictures = [moments(film, view, [0.3], (740, 460))[0] for view in View]
    return _grid(pictures, [VIEW_NAMES[view] for view in View], columns=2)


def around_a_column(plan: Plan) -> Figure:
    """A motion on a free way round an obstacle, three moments of it with the whole arm and its path."""
    film = film_of(plan)
    parts = (0.1, 0.5, 0.9)
    return _grid(
        moments(film, View.ARM, parts, (500, 460)), [f"{part * film.end_time:.2f} s" for part in parts], columns=3
    )


class _Arms:
    """All arms of the catalogue in a row, each at home; stands in for a `SceneBuilder`."""

    def __init__(self) -> None:
        self._bodies: list[Body] = []
        self.places: list[float] = []
        colour = np.array(ARM, dtype=float)
        for number, name in enumerate(ROBOTS):
            robot = load_robot(name)
            chain = read_chain(robot.urdf, robot.joints, robot.tip)
            links, place = arm_bodies(robot, chain), np.array([0.0, _APART * number, 0.0])
            self.places.append(place[1])
            frames = chain.frames(robot.home[None])
            parts = [(links.get(chain.base), np.zeros(3), np.eye(3))]
            parts += [
                (links.get(joint.child), position[0], rotation[0])
                for joint, (position, rotation) in zip(chain.joints, frames, strict=True)
            ]
            for mesh, position, rotation in parts:
                if mesh is not None:
                    moved = Mesh((mesh.vertices @ rotation.T + position) @ _ASIDE.T + place, mesh.faces)
                    self._bodies.append(Body(moved, colour, Kind.OPAQUE))

    def bodies(self, index: int) -> list[Body]:
        """The same at every moment."""
        return self._bodies


def robots() -> Figure:
    """Every arm of the catalogue at its home, to one scale."""
    arms = _Arms()
    size = (1480, 340)
    vertices = np.concatenate([body.mesh.vertices for body in arms.bodies(0)])
    # Room for the names at both ends.
    vertices = np.vstack([vertices, vertices[0] * (1, 0, 1) - (0, 0.7, 0), vertices[-1] + (0, 0.45, 0)])
    back = np.array([1.0, 0.0, 0.12])
    camera = framed(vertices, back / np.linalg.norm(back), aspect=size[0] / size[1], angle=float(np.radians(9.0)))
    ride = CameraFrame(np.zeros((1, 3)), np.eye(3)[None])
    picture = draw(arms, 0, camera, ride, size=size)  # pyright: ignore[reportArgumentType]
    figure = sheet(2.1)
    axes = figure.add_axes((0.0, 0.19, 1.0, 0.81))
    axes.imshow(picture)
    axes.set_axis_off()
    canvas = Canvas.of(camera, *size)
    feet = (np.array([[0.0, place, 0.0] for place in arms.places]) - camera.position) @ axes_facing(
        camera.position - camera.look_at
    )
    for across, name in zip(canvas.project(feet)[:, 0] / size[0], ROBOTS, strict=True):
        figure.text(across, 0.16, name.replace("-", "-\n", 1), ha="center", va="top", size=8.5)
    return figure


def _grid(pictures: Sequence[np.ndarray], names: Sequence[str], *, columns: int) -> Figure:
    rows = -(-len(pictures) // columns)
    tall = pictures[0].shape[0] / pictures[0].shape[1] * 7.4 / columns
    figure = sheet(rows * tall)
    for number, (picture, name) in enumerate(zip(pictures, names, strict=True)):
        row, column = divmod(number, columns)
        axes = figure.add_axes(((column + 0.004) / columns, 1 - (row + 0.992) / rows, 0.992 / columns, 0.984 / rows))
        axes.imshow(picture)
        axes.set_axis_off()
        axes.text(0.03, 0.95, name, transform=axes.transAxes, ha="left", va="top", size=9, weight="bold")
    return figure
