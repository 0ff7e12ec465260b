"""The scene in the browser: an arm, a tray with what stands on it, a path; built once, then only moved.

Everything works on a `viser.SceneApi`, which may belong to a server (all tabs see the same) or to one client (a tab of
its own). Nodes hang below one root, so that several plans stand side by side and one can be taken away whole.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from nospill.drawing.arm_bodies import arm_bodies, holder
from nospill.drawing.colours import BLACK, GREEN, PURPLE, RED, rgb, use_colours
from nospill.drawing.geometry import board, contact_collar, container_body, creased
from nospill.drawing.props import followed_line, limit_ring
from nospill.drawing.robot_model import DrawnChain, read_chain
from nospill.drawing.surfaces import LiquidSurface, liquid_surface
from nospill.drawing.timeline import Film
from nospill.drawing.views import CLOSE, View, camera_frame
from nospill.robots.robot import Robot
from nospill.scene.cargo import Cargo
from nospill.scene.heights import HeightOrder
from nospill.scene.tray import TRAY_THICKNESS, Tray
from nospill.viewer.gravity import against, arrow, free_spot
from nospill.viewer.names import ABOVE_RIM, Letters, title_height
from nospill.viewer.nodes import add_mesh
from nospill.viewer.surroundings import add_surroundings

if TYPE_CHECKING:
    import trimesh
    import viser

_ARM, _BOARD, _CUP, _SOLID = (176, 181, 187), (222, 205, 178), (214, 226, 234), (143, 128, 160)
_CUP_OPACITY = 0.22
LETTERS = 0.02
"""m; height of the letters of names before a view is chosen."""
_BELOW = np.array([0.0, 0.0, -0.001])
"""m; the ground lies a little below the robot's foot."""
_ARROW = (70, 70, 70)
_SKY, _SUN = 2.2, 1.6
"""Intensities of the light from all sides and of that from above."""


class TrayView:
    """A tray and the objects on it, below a node that is the tray frame.

    Attributes:
        surfaces: the liquids' surfaces, by the name of the object.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        tray: Tray,
        *,
        cargo: Sequence[Cargo],
        root: str,
        names: str | None = None,
        order: HeightOrder = "linear",
    ) -> None:
        """Add the nodes.

        Args:
            scene: where to.
            tray: its board.
            cargo: what stands on it.
            root: name of the tray frame's node, which must exist.
            names: of a node that does not move, which the names of the objects hang below where the tray moves; they
                are then placed by `place_names`. The browser draws a name where its parent was one picture ago.
            order: of the surfaces of the liquids.
        """
        self._order: HeightOrder = order
        self.surfaces: dict[str, LiquidSurface] = {}
        self._liquids: dict[str, viser.MeshHandle] = {}
        self._collars: dict[str, viser.MeshHandle] = {}
        self._labels: list[viser.LabelHandle] = []
        self._tops: list[np.ndarray] = []
        add_mesh(scene, f"{root}/board", board(tray.size, TRAY_THICKNESS), color=_BOARD, flat_shading=True)
        for item in cargo:
            self._add_object(scene, item, f"{root}/{item.name}")
        for item in (item for item in cargo if not item.carrier):
            self._tops.append(np.array([*item.position, item.container.height + ABOVE_RIM]))
            self._labels.append(
                scene.add_label(
                    f"{names or root}/name_{item.name}",
                    item.title,
                    position=tuple(self._tops[-1]),
                    anchor="bottom-center",
                    font_size_mode="scene",
                    font_scene_height=LETTERS,
                )
            )

    def _add_object(self, scene: viser.SceneApi, cargo: Cargo, root: str) -> None:
        half = cargo.yaw / 2
        scene.add_frame(root, show_axes=False, position=tuple(cargo.place), wxyz=(np.cos(half), 0.0, 0.0, np.sin(half)))
        hollow = cargo.filling is not None or cargo.contents is not None
        look = {"color": _CUP, "opacity": _CUP_OPACITY, "side": "double"} if hollow else {"color": _SOLID}
        body = creased(container_body(cargo.container, hollow=hollow))
        add_mesh(scene, f"{root}/body", body, cast_shadow=not hollow, **look)
        if not cargo.carrier:
            self._collars[cargo.name] = add_mesh(
                scene, f"{root}/contact", contact_collar(cargo.container), color=_colour(0.0), cast_shadow=False
            )
        if cargo.filling is not None:
            surface = liquid_surface(cargo, self._order)
            self.surfaces[cargo.name] = surface
            self._liquids[cargo.name] = add_mesh(
                scene, f"{root}/liquid", surface.rest, color=_colour(0.0), cast_shadow=False, receive_shadow=False
            )
            ring = limit_ring(cargo)
            if ring is not None:
                add_mesh(scene, f"{root}/limit", ring, color=rgb(RED), side="double", cast_shadow=False)

    def set_liquid(self, name: str, coordinates: np.ndarray, *, use: float) -> None:
        """Move a liquid's surface and colour it by the use of its height limit.

        Args:
            name: of the object.
            coordinates: (k + 2,) slosh coordinates, m, and leans.
            use: height over limit, 1 at the limit.
        """
        handle = self._liquids[name]
        handle.vertices = self.surfaces[name].vertices(coordinates).astype(np.float32)
        handle.color = _colour(use)

    def set_contact(self, name: str, use: float) -> None:
        """Colour the collar at the foot of an object by the largest use of its contact's limits."""
        self._collars[name].color = _colour(use)

    def place_names(self, position: np.ndarray, rotation: np.ndarray) -> None:
        """Put the names above the objects for a tray frame at (3,), m, with axes (3, 3), in that of their node."""
        for label, top in zip(self._labels, self._tops, strict=True):
            label.position = position + rotation @ top

    def show_names(self, wanted: bool) -> None:
        """Show or hide the names above the objects."""
        for label in self._labels:
            label.visible = wanted

    def set_letters(self, height: float) -> None:
        """Write the names in letters of this height, m."""
        for label in self._labels:
            label.font_scene_height = height


class ArmView:
    """An arm below a node; `flange` is the name of the node that is its flange frame."""

    def __init__(
        self,
        scene: viser.SceneApi,
        robot: Robot,
        *,
        root: str,
        tray: Tray | None = None,
        chain: DrawnChain | None = None,
        meshes: Mapping[str, trimesh.Trimesh] | None = None,
    ) -> None:
        """Add the nodes.

        Args:
            scene: where to.
            robot: the arm.
            root: name of the base frame's node, which must exist.
            tray: what the flange carries, for the holder between them.
            chain: joints to draw by, where not those of the robot's own URDF.
            meshes: by the name of the link, in its frame, m, in place of `arm_bodies`.

        Raises:
            ScenarioError: the robot's URDF cannot be read.
        """
        self.chain = chain or read_chain(robot.urdf, robot.joints, robot.tip)
        self._moving: list[viser.FrameHandle] = []
        if meshes is None:
            bodies = arm_bodies(robot, self.chain, tray)
        else:
            bodies = {} if tray is None else {self.chain.joints[-1].child: holder(tray)}
        nodes = {self.chain.base: root}
        node = root
        for joint in self.chain.joints:
            node = f"{node}/{joint.name}"
            frame = scene.add_frame(
                node,
                show_axes=False,
                position=tuple(joint.position),
                wxyz=joint.wxyz(np.zeros((1, len(robot.joints))))[0],
            )
            nodes[joint.child] = node
            if joint.index is not None:
                self._moving.append(frame)
        self.flange = node
        for link, body in bodies.items():
            add_mesh(scene, f"{nodes[link]}/body", body, color=_ARM, receive_shadow=False)
        for link, mesh in (meshes or {}).items():
            if link in nodes:
                scene.add_mesh_trimesh(f"{nodes[link]}/mesh", mesh)

    def attitudes(self, q: np.ndarray) -> np.ndarray:
        """Attitude of every moving joint's node for joint positions (m, n), rad: (m, n, 4), (w, x, y, z)."""
        return np.stack([joint.wxyz(q) for joint in self.chain.joints if joint.index is not None], axis=1)

    def set_attitudes(self, attitudes: np.ndarray) -> None:
        """Turn the joints to one row of `attitudes`, (n, 4)."""
        for frame, wxyz in zip(self._moving, attitudes, strict=True):
            frame.wxyz = wxyz

    def set_joints(self, q: np.ndarray) -> None:
        """Turn the joints to positions (n,), rad."""
        self.set_attitudes(self.attitudes(np.asarray(q)[None])[0])


class PlanView:
    """A whole plan: arm, tray, objects, path; `show` moves it to a time.

    The camera of a browser stays where its user leaves it, so a view that follows the tray moves the world the other
    way.

    Attributes:
        film: what is shown.
        root: name of the node everything hangs below, which stands still.
        arm, tray: the parts.
        title: written above the tray.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        film: Film,
        *,
        root: str = "/plan",
        title: str = "",
        position: tuple[float, float, float] = (0.0, 0.0, 0.0),
        chain: DrawnChain | None = None,
        meshes: Mapping[str, trimesh.Trimesh] | None = None,
        ground: viser.SceneNodeHandle | None = None,
    ) -> None:
        """Add the nodes and show the first picture, seen from where the robot stands.

        Args:
            scene: where to.
            film: the plan's pictures.
            root: name of a node that does not exist yet.
            title: written above the tray; empty for none.
            position: of the robot's base in the world, m.
            chain: as in `ArmView`, likewise `meshes`.
            meshes: see there.
            ground: what the robot stands on and goes with it, if anything does.

        Raises:
            ScenarioError: the robot's URDF cannot be read.
        """
        whole, planned = film.plan.scene, film.plan.trajectory
        self.film, self.root, self._ground = film, root, ground
        self._root = scene.add_frame(root, show_axes=False, position=position)
        world = f"{root}/world"
        self._world = scene.add_frame(world, show_axes=False)
        scene.add_frame(f"{world}/arm", show_axes=False)
        self.arm = ArmView(scene, whole.robot, root=f"{world}/arm", tray=whole.tray, chain=chain, meshes=meshes)
        tray_node = f"{self.arm.flange}/tray"
        scene.add_frame(
            tray_node,
            show_axes=False,
            position=tuple(whole.tray.tool.position),
            wxyz=Rotation.from_matrix(whole.tray.tool.rotation).as_quat()[[3, 0, 1, 2]],
        )
        scene.add_frame(f"{root}/names", show_axes=False)
        names, order = f"{root}/names", whole.motion.slosh_height
        self.tray = TrayView(scene, whole.tray, cargo=whole.cargo, root=tray_node, names=names, order=order)
        self._paths = add_path(scene, f"{world}/path", followed_line(film))
        add_surroundings(scene, f"{world}/around", whole)
        self._above = np.array([0.0, 0.0, title_height(film)])
        self.title = title
        self._title = (
            scene.add_label(
                f"{root}/title", title, anchor="bottom-center", font_size_mode="scene", font_scene_height=LETTERS
            )
            if title
            else None
        )
        pointer = f"{tray_node}/gravity"
        self._gravity = scene.add_frame(pointer, show_axes=False, position=(*free_spot(whole.tray, whole.cargo), 0.0))
        add_mesh(scene, f"{pointer}/arrow", arrow(whole.cargo), color=_ARROW, cast_shadow=False)
        self._pulls = against(film.specific_force)
        assert planned.joints == whole.robot.joints
        self._attitudes = self.arm.attitudes(film.joint_position)
        self._carriage, self._close, self._path_wanted = camera_frame(film, View.ARM), False, True
        self._shown = -1
        self.show(0.0)

    def show(self, t: float) -> None:
        """Move everything to the picture at time t in s; nothing is sent where that is the one shown already."""
        index = self.film.index(t)
        if index == self._shown:
            return
        self._shown = index
        self.arm.set_attitudes(self._attitudes[index])
        position, rotation = self._carriage.base(index)
        x, y, z, w = Rotation.from_matrix(rotation).as_quat()
        self._world.position, self._world.wxyz = position, (w, x, y, z)
        if self._ground is not None:
            self._ground.position = self._root.position + position + rotation @ _BELOW
            self._ground.wxyz = (w, x, y, z)
        self._gravity.wxyz = self._pulls[index]
        place = position + rotation @ self.film.tray_position[index]
        self.tray.place_names(place, rotation @ self.film.tray_rotation[index])
        if self._title is not None:
            self._title.position = place + self._above
        for name, track in self.film.liquids.items():
            self.tray.set_liquid(name, track.coordinates[index], use=float(track.height[index] / track.limit))
        for name, use in self.film.contact_use.items():
            self.tray.set_contact(name, float(use[index]))

    def ride(self, view: View, place: np.ndarray) -> None:
        """See the plan from the carriage of a view, which stands at a place (3,), m."""
        self._carriage, self._close = camera_frame(self.film, view), view in CLOSE
        self._root.position = place
        self.show_path(self._path_wanted)
        shown, self._shown = self._shown, -1
        self.show(float(self.film.t[shown]))

    def write_names(self, letters: Letters) -> None:
        """Write the names of objects and plan in these letters; names that would cover each other are hidden."""
        self.tray.show_names(letters.apart)
        self.tray.set_letters(letters.names)
        if self._title is not None:
            self._title.font_scene_height = letters.titles

    def show_path(self, wanted: bool) -> None:
        """Show or hide the path; seen from close by it would cut through the cups and is hidden in any case."""
        self._path_wanted = wanted
        for handle in self._paths:
            handle.visible = wanted and not self._close

    def remove(self) -> None:
        """Take everything away."""
        self._root.remove()


def prepare(scene: viser.SceneApi) -> viser.SceneNodeHandle:
    """Ground and light of an empty scene, of a server or of one client; the ground is returned."""
    scene.set_up_direction("+z")
    # viser's own lights turn pale colours white, its surroundings are slow to draw without a graphics card, and shadows
    # fall on a tilted tray in stripes
    scene.configure_default_lights(False)
    scene.configure_environment_map(None)
    scene.add_light_hemisphere("/lights/sky", intensity=_SKY)
    scene.add_light_directional("/lights/sun", intensity=_SUN, position=(-2.0, 1.5, 5.0))
    return scene.add_grid(
        "/ground",
        width=12.0,
        height=12.0,
        cell_size=0.25,
        section_size=1.0,
        cell_color=(228, 228, 228),
        section_color=(200, 200, 200),
        plane_color=(250, 250, 250),
        plane_opacity=1.0,
        position=tuple(_BELOW),
    )


def add_path(scene: viser.SceneApi, root: str, points: np.ndarray) -> list[viser.SceneNodeHandle]:
    """The path as a line, with its start (green) and end (purple)."""
    segments = np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
    ends = [("start", points[0], GREEN), ("end", points[-1], PURPLE)]
    scene.add_frame(root, show_axes=False)
    return [
        scene.add_line_segments(
            f"{root}/line", segments, np.array(rgb(BLACK)), thickness=2.0, thickness_units="screen"
        ),
        *[
            scene.add_icosphere(f"{root}/{name}", radius=0.012, color=rgb(colour), subdivisions=2, position=tuple(at))
            for name, at, colour in ends
        ],
    ]


def _colour(use: float) -> tuple[int, int, int]:
    red, green, blue = (int(channel) for channel in use_colours(np.array([use]))[0])
    return red, green, blue
