"""The scene before it moves: the arm where the path starts, the tray with its cargo, the path and what is around."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from nospill.drawing.robot_model import read_chain
from nospill.errors import NospillError
from nospill.path_search.candidates import feasible_paths, has_free_path
from nospill.robots.joint_paths.search import joint_paths
from nospill.scene.scene import Scene
from nospill.viewer.scene_view import ArmView, TrayView, add_path
from nospill.viewer.surroundings import add_surroundings

if TYPE_CHECKING:
    import viser

ROOT = "/layout"
_PATH_POINTS = 120
_ANGLE, _SPARE = float(np.radians(40.0)), 0.12
"""Vertical angle of view, as in the viewer; m beyond what is looked at."""
_BACK = np.array([1.0, 0.42, 0.58]) / np.linalg.norm([1.0, 0.42, 0.58])
"""From what is looked at to the camera: from the front, a little from the side and from above."""


class LayoutView:
    """Draws scenes one after the other in a thread of its own; of several that came meanwhile only the last."""

    def __init__(self, client: viser.ClientHandle, *, said: Callable[[str], None]) -> None:
        """Nothing is drawn yet.

        Args:
            client: whose browser.
            said: called with what is in the way of the arm on this path, "" for nothing, from the thread of `run`.
        """
        self._client, self._said = client, said
        self._root = client.scene.add_frame(ROOT, show_axes=False)
        self._drawn: dict[str, str] = {}
        self._nodes: dict[str, viser.FrameHandle] = {}
        self._tray_place = np.zeros(3)
        self._turn = 0.0
        self._looked = False
        self._seen = np.zeros((0, 3))
        self._window = self._size()
        self._wanted: Scene | None = None
        self._news = threading.Condition()

    def show(self, scene: Scene) -> None:
        """Ask for a scene; it comes soon."""
        with self._news:
            self._wanted = scene
            self._news.notify()

    @property
    def visible(self) -> bool:
        """Whether it is to be seen."""
        return self._root.visible

    @visible.setter
    def visible(self, wanted: bool) -> None:
        if self._root.visible != wanted:
            self._root.visible = wanted

    def run(self, stop: threading.Event) -> None:
        """Draw what was requested until `stop` is set and `show` or `wake` was called after it."""
        while True:
            with self._news:
                self._news.wait_for(lambda: self._wanted is not None or stop.is_set())
                scene, self._wanted = self._wanted, None
            if stop.is_set() or scene is None:
                return
            with suppress(RuntimeError):  # the browser went away in the middle of it
                try:
                    self._draw(scene)
                except NospillError as error:
                    self._said(" ".join(str(error).split()))

    def look_again(self) -> None:
        """Put the camera where the next scene is seen whole."""
        self._looked = False

    def window_changed(self) -> None:
        """Aim the camera anew where the scene has another size on the screen; a mere turn of it is the user's."""
        if self._size() != self._window and len(self._seen):
            self._look_at(self._seen)

    def _size(self) -> tuple[int, int]:
        camera = self._client.camera
        return camera.image_width, camera.image_height

    def wake(self) -> None:
        """Let `run` look at its stop."""
        with self._news:
            self._news.notify()

    def _draw(self, scene: Scene) -> None:
        """Draw what differs from what is there."""
        source = scene.source
        way = repr((source["robot"], source["path"], source["tray"]))
        around = repr((way, source.get("obstacle")))
        load = repr((way, source.get("cargo"), scene.fidelity, scene.slosh_modes))
        if self._drawn.get("way") != way or not self._looked:
            self._draw_way(scene)
        if self._drawn.get("load") != load:
            with self._client.atomic():
                node = self._fresh("load")
                node.position, node.wxyz = self._tray_place, _about_z(self._turn)
                TrayView(self._client.scene, scene.tray, cargo=scene.cargo, root=node.name)
        if self._drawn.get("around") != around:
            with self._client.atomic():
                add_surroundings(self._client.scene, f"{self._fresh('around').name}/all", scene)
        self._drawn = {"way": way, "load": load, "around": around}

    def _draw_way(self, scene: Scene) -> None:
        obstacle = ""
        if has_free_path(scene):
            try:
                scene = feasible_paths(scene)[0].scene
            except NospillError as error:
                obstacle = str(error)
        points = scene.path.at(np.linspace(0.0, 1.0, _PATH_POINTS))
        self._tray_place, self._turn = points[0, :3], float(points[0, 3])
        chain = read_chain(scene.robot.urdf, scene.robot.joints, scene.robot.tip)
        try:
            q = joint_paths(scene.robot, scene.path, tool=scene.tray.tool)[0].q[0]
        except NospillError as error:
            # An arm that vanished would say less than one that stands there and does not reach.
            q, obstacle = np.clip(np.zeros(len(scene.robot.joints)), scene.robot.lower, scene.robot.upper), str(error)
        with self._client.atomic():
            arm = self._fresh("arm")
            ArmView(self._client.scene, scene.robot, root=arm.name, tray=scene.tray, chain=chain).set_joints(q)
            self._fresh("path")
            add_path(self._client.scene, f"{ROOT}/path/way", points[:, :3])
        if not self._looked:
            self._looked = True
            joints = np.concatenate([position for position, _ in chain.frames(q[None])])
            self._look_at(
                np.concatenate([joints, points[:, :3], _corners(scene, points[0]), _corners(scene, points[-1])])
            )
        self._said(" ".join(obstacle.split()))

    def _fresh(self, name: str) -> viser.FrameHandle:
        """An empty node in place of the one there was."""
        old = self._nodes.pop(name, None)
        if old is not None:
            old.remove()
        self._nodes[name] = self._client.scene.add_frame(f"{ROOT}/{name}", show_axes=False)
        return self._nodes[name]

    def _look_at(self, points: np.ndarray) -> None:
        """Stand far enough for all points, (n, 3) in m, in a scene as wide and high as it is on the screen."""
        self._seen, self._window = points, self._size()
        width, height = self._window
        slope = np.tan(_ANGLE / 2)
        right = np.cross([0.0, 0.0, 1.0], _BACK)
        right /= np.linalg.norm(right)
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        across, up, near = ((points - middle) @ axis for axis in (right, np.cross(_BACK, right), _BACK))
        aspect = width / height if height else 1.0
        away = near + np.maximum((np.abs(across) + _SPARE) / aspect, np.abs(up) + _SPARE) / slope
        with self._client.atomic():
            self._client.camera.fov = _ANGLE
            # in this order: a new position carries the point looked at along
            self._client.camera.position = middle + _BACK * float(np.max(away))
            self._client.camera.look_at = middle


def _corners(scene: Scene, pose: np.ndarray) -> np.ndarray:
    """Corners of the level tray at x, y, z in m and yaw in rad: (4, 3)."""
    x, y = np.asarray(scene.tray.size) / 2
    sine, cosine = np.sin(pose[3]), np.cos(pose[3])
    corners = np.array([[x, y, 0.0], [x, -y, 0.0], [-x, -y, 0.0], [-x, y, 0.0]])
    return pose[:3] + corners @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _about_z(angle: float) -> np.ndarray:
    """Quaternion (w, x, y, z) of a turn about z, rad."""
    return np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])
