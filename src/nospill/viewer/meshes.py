"""Meshes of an arm from a URDF file, read by trimesh, which viser brings along."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from nospill.drawing.robot_model import DrawnChain, origin_of, parsed_urdf, read_chain, three_numbers
from nospill.errors import ScenarioError
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.robot import Robot
from nospill.viewer.library import require_viser

if TYPE_CHECKING:
    import trimesh

_SAME_PLACE = 1e-3
"""m and rad; the file's flange may differ from the robot's by this much."""


@dataclass(frozen=True, slots=True)
class Visuals:
    """What a URDF file shows of an arm.

    Attributes:
        chain: its joints.
        meshes: by the name of the link, in its frame, m; None where a mesh's file is missing.
        missing: names of the mesh files that are not there.
    """

    chain: DrawnChain
    meshes: dict[str, trimesh.Trimesh] | None
    missing: tuple[str, ...]


def load_visuals(file: str | Path, robot: Robot) -> Visuals:
    """Read the meshes of an arm.

    Args:
        file: a URDF file with the robot's joints. Mesh names may be paths from its folder, absolute paths or start with
            package://, whose folder is looked for above the file.
        robot: the arm it must agree with.

    Raises:
        MissingExtraError: viser is not installed.
        ScenarioError: the file cannot be read, is another arm, or a mesh in it cannot be read.
    """
    require_viser()
    place = Path(file)
    try:
        text = place.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{place}: cannot be read ({error}); name a URDF file") from error
    chain = read_chain(text, robot.joints, robot.tip, source=str(place))
    _require_same_arm(chain, robot, place)
    tree = parsed_urdf(text, str(place))
    wanted = {chain.base, *(joint.child for joint in chain.joints)}
    links = [link for link in tree.findall("link") if link.get("name") in wanted]
    names = [mesh.get("filename", "") for link in links for mesh in link.iterfind("visual/geometry/mesh")]
    missing = tuple(name for name in names if _mesh_file(name, place) is None)
    if missing:
        return Visuals(chain, None, missing)
    meshes = {link.get("name", ""): mesh for link in links if (mesh := _link_mesh(link, place)) is not None}
    return Visuals(chain, meshes or None, ())


def _require_same_arm(chain: DrawnChain, robot: Robot, place: Path) -> None:
    """Both must carry the flange to the same place, at two configurations."""
    middle = (robot.lower + robot.upper) / 2
    q = np.stack([middle, middle + 0.1 * (robot.upper - robot.lower)])
    position, rotation = chain.frames(q)[-1]
    wanted_position, wanted_rotation = kinematics(robot).poses(q)
    distance = float(np.max(np.linalg.norm(position - wanted_position, axis=1)))
    turn = float(np.max(np.abs(rotation - wanted_rotation)))
    if distance > _SAME_PLACE or turn > _SAME_PLACE:
        raise ScenarioError(
            f"{place}: its flange is {1e3 * distance:.1f} mm away from that of {robot.name} at the same joint angles; "
            "give the URDF of the same arm"
        )


def _mesh_file(name: str, urdf: Path) -> Path | None:
    """The file a mesh name means, or None where there is none."""
    if name.startswith("file://"):
        tries = [Path(name.removeprefix("file://"))]
    elif name.startswith("package://"):
        inside = name.removeprefix("package://")
        short = inside.partition("/")[2]
        tries = [folder / part for folder in urdf.resolve().parents for part in (inside, short)]
    else:
        tries = [urdf.parent / name]
    return next((path for path in tries if path.is_file()), None)


def _link_mesh(link: ElementTree.Element, place: Path) -> trimesh.Trimesh | None:
    """All visuals of a link as one mesh in its frame; None where it has none."""
    import trimesh

    parts = []
    for visual in link.findall("visual"):
        geometry = visual.find("geometry")
        part = None if geometry is None else _geometry(geometry, place)
        if part is None:
            continue
        position, rotation = origin_of(visual, str(place))
        transform = np.eye(4)
        transform[:3, :3], transform[:3, 3] = rotation, position
        parts.append(part.apply_transform(transform))
    return trimesh.util.concatenate(parts) if parts else None  # type: ignore[return-value]


def _geometry(geometry: ElementTree.Element, place: Path) -> trimesh.Trimesh | None:
    """The body of one <geometry>; None for a kind that is not known."""
    import trimesh

    shape = next(iter(geometry), None)
    if shape is None:
        return None
    try:
        if shape.tag == "mesh":
            file = _mesh_file(shape.get("filename", ""), place)
            mesh = trimesh.load_scene(file).to_mesh()
            if len(mesh.faces) == 0:
                raise ValueError("no triangles in it")
            return mesh.apply_scale(three_numbers(shape.get("scale", "1 1 1"), str(place)))
        if shape.tag == "box":
            return trimesh.creation.box(extents=three_numbers(shape.get("size", ""), str(place)))
        if shape.tag == "sphere":
            return trimesh.creation.icosphere(subdivisions=2, radius=float(shape.get("radius", "")))
        if shape.tag == "cylinder":
            return trimesh.creation.cylinder(
                radius=float(shape.get("radius", "")), height=float(shape.get("length", "")), sections=32
            )
    except ScenarioError:
        raise
    except Exception as error:  # every reader of a mesh format raises its own kinds
        name = shape.get("filename", shape.tag)
        raise ScenarioError(f"{place}: {name} cannot be read: {error}; give a mesh as STL, OBJ, GLB or DAE") from error
    return None
