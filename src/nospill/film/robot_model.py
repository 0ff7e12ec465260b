"""The arm as it is drawn: a chain of joint frames from its URDF, and a body for every link.

Without meshes the bodies are tapered tubes from joint to joint with a short cylinder about every axis; the thickness
follows from the arm's own length, so any chain of six or seven joints looks like an arm.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from nospill.errors import ScenarioError
from nospill.film.geometry import Mesh, joined, tube
from nospill.scene.tray import TRAY_THICKNESS, Tray

_THICK, _THIN = 0.048, 0.024
"""Radius at the base and at the flange, as a fraction of the length from the base to the flange along the joints."""


@dataclass(frozen=True, slots=True)
class ChainJoint:
    """One joint between the base and the flange.

    Attributes:
        name: of the joint.
        child: name of the link it carries.
        index: of its angle in q, or None where it does not move.
        position: (3,) its origin in the frame of the joint before, m.
        rotation: (3, 3) its frame at angle zero, to the frame of the joint before.
        axis: (3,) unit vector it turns about, its own frame.
    """

    name: str
    child: str
    index: int | None
    position: np.ndarray
    rotation: np.ndarray
    axis: np.ndarray

    def wxyz(self, q: np.ndarray) -> np.ndarray:
        """Attitude in the frame of the joint before for joint positions q (m, n), rad: (m, 4), (w, x, y, z)."""
        fixed = Rotation.from_matrix(self.rotation)
        angle = np.zeros(len(q)) if self.index is None else np.asarray(q)[:, self.index]
        return (fixed * Rotation.from_rotvec(angle[:, None] * self.axis)).as_quat()[:, [3, 0, 1, 2]]


@dataclass(frozen=True, slots=True)
class DrawnChain:
    """All joints from the base to the flange, fixed ones too; `base` is the link the first one stands on."""

    base: str
    joints: tuple[ChainJoint, ...]

    def frames(self, q: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Origin (m, 3), m, and rotation (m, 3, 3) in the base frame of every joint's frame, for q (m, n), rad."""
        position, turned = np.zeros((len(q), 3)), Rotation.identity(len(q))
        found = []
        for joint in self.joints:
            position = position + turned.apply(joint.position)
            turned = turned * Rotation.from_quat(joint.wxyz(q)[:, [1, 2, 3, 0]])
            found.append((position, turned.as_matrix()))
        return found


def read_chain(urdf: str, joints: tuple[str, ...], tip: str, *, source: str = "robot description") -> DrawnChain:
    """The joints between the base and `tip` in URDF text.

    Args:
        urdf: the text.
        joints: names of the moving joints in the order of q; all others stay at zero.
        tip: the flange link.
        source: what messages call the text.

    Raises:
        ScenarioError: the text is no URDF, or the tip or a joint is not in it.
    """
    tree = parsed_urdf(urdf, source)
    above = {_child(joint): joint for joint in tree.findall("joint")}
    if tip not in above:
        raise ScenarioError(f"{source}: no joint carries the flange link {tip!r}; its links: {', '.join(above)}")
    found: list[ChainJoint] = []
    link = tip
    while link in above and len(found) <= len(above):
        found.append(_joint(above[link], joints, source))
        parent = above[link].find("parent")
        link = parent.get("link", "") if parent is not None else ""
    missing = [name for name in joints if name not in [joint.name for joint in found]]
    if missing:
        raise ScenarioError(f"{source}: between the base and {tip!r} the joints {', '.join(missing)} are missing")
    return DrawnChain(link, tuple(reversed(found)))


def parsed_urdf(urdf: str, source: str) -> ElementTree.Element:
    """The root element of URDF text.

    Raises:
        ScenarioError: the text is no XML or no URDF.
    """
    try:
        tree = ElementTree.fromstring(urdf)
    except ElementTree.ParseError as error:
        raise ScenarioError(f"{source} is no XML: {error}; give a URDF file") from error
    if tree.tag != "robot":
        raise ScenarioError(f"{source} starts with <{tree.tag}>, expected <robot>; give a URDF file")
    return tree


def origin_of(element: ElementTree.Element, source: str) -> tuple[np.ndarray, np.ndarray]:
    """Position (3,), m, and rotation (3, 3) of the <origin> of a joint or visual; the standard where it has none.

    Raises:
        ScenarioError: it does not hold three numbers each.
    """
    origin = element.find("origin")
    xyz = "0 0 0" if origin is None else origin.get("xyz", "0 0 0")
    rpy = "0 0 0" if origin is None else origin.get("rpy", "0 0 0")
    return three_numbers(xyz, source), Rotation.from_euler("xyz", three_numbers(rpy, source)).as_matrix()


def three_numbers(text: str, source: str) -> np.ndarray:
    """Three numbers from an attribute, (3,).

    Raises:
        ScenarioError: there are not three, or they are no numbers.
    """
    try:
        values = np.array([float(part) for part in text.split()])
    except ValueError as error:
        raise ScenarioError(f"{source}: {text!r} is not a list of numbers") from error
    if values.shape != (3,):
        raise ScenarioError(f"{source}: {text!r} has {len(values)} numbers, 3 are needed")
    return values


def drawn_links(chain: DrawnChain, tray: Tray | None = None, *, only_holder: bool = False) -> dict[str, Mesh]:
    """Bodies of an arm without meshes, each in its link's own frame (that of the joint that carries it), m.

    Args:
        chain: of the arm.
        tray: what the flange carries: the last link reaches to below its board, and no joint's body through it.
        only_holder: leave out the links themselves, which have meshes.

    Returns:
        By the name of the link, only links that have a body; the base under `chain.base`.
    """
    offsets = [joint.position for joint in chain.joints]
    reach = sum(float(np.linalg.norm(offset)) for offset in offsets)
    ends = np.cumsum([0.0] + [float(np.linalg.norm(offset)) for offset in offsets]) / reach
    radii = reach * (_THICK + (_THIN - _THICK) * ends)
    links = [chain.base, *[joint.child for joint in chain.joints]]
    parts: dict[str, list[Mesh]] = {link: [] for link in links}
    foot = radii[0]
    parts[chain.base].append(tube(np.zeros(3), np.array([0.0, 0.0, 0.03 * reach]), (1.7 * foot, 1.5 * foot)))
    for number, joint in enumerate(chain.joints):
        length = float(np.linalg.norm(offsets[number]))
        if length > 1e-6:
            parts[links[number]].append(tube(np.zeros(3), offsets[number], (radii[number], radii[number + 1])))
        if joint.index is not None:
            half = 1.25 * radii[number + 1] * joint.axis
            thick = float(1.2 * radii[number + 1])
            parts[joint.child].append(tube(-half, half, (thick, thick)))
    if only_holder:
        parts = {link: [] for link in links}
    elif tray is not None:
        _keep_below_tray(chain, parts, tray, radii)
    if tray is not None:
        parts[links[-1]].append(_holder(tray, radii[-1]))
    return {link: joined(meshes) for link, meshes in parts.items() if meshes}


def _holder(tray: Tray, radius: float) -> Mesh:
    """From the flange to the underside of the board, flange frame."""
    end = np.asarray(tray.tool.position, dtype=float) - np.array([0.0, 0.0, TRAY_THICKNESS])
    plate = tube(end - np.array([0.0, 0.0, 0.35 * radius]), end, (1.9 * radius, 1.9 * radius))
    if np.linalg.norm(end) < 1e-3:
        return plate
    return joined([tube(np.zeros(3), end, (radius, radius)), plate])


def _keep_below_tray(chain: DrawnChain, parts: dict[str, list[Mesh]], tray: Tray, radii: np.ndarray) -> None:
    """Cut the last moving joint's cylinder where it would reach through the board."""
    last = max(number for number, joint in enumerate(chain.joints) if joint.index is not None)
    joint = chain.joints[last]
    position, rotation = np.zeros(3), np.eye(3)
    for later in chain.joints[last + 1 :]:
        position = position + rotation @ later.position
        rotation = rotation @ later.rotation
    below = position + rotation @ (np.asarray(tray.tool.position) - np.array([0.0, 0.0, TRAY_THICKNESS]))
    room = float(abs(below @ joint.axis))
    usual = 1.25 * radii[last + 1]
    if room < usual:
        side = np.sign(below @ joint.axis) or 1.0
        start, end = -usual * side * joint.axis, 0.9 * room * side * joint.axis
        parts[joint.child] = [tube(start, end, (1.2 * radii[last + 1], 1.2 * radii[last + 1])), *parts[joint.child][1:]]


def _joint(element: ElementTree.Element, joints: tuple[str, ...], source: str) -> ChainJoint:
    name = element.get("name", "")
    position, rotation = origin_of(element, source)
    axis_element = element.find("axis")
    axis = three_numbers("1 0 0" if axis_element is None else axis_element.get("xyz", "1 0 0"), source)
    length = float(np.linalg.norm(axis))
    return ChainJoint(
        name=name,
        child=_child(element),
        index=joints.index(name) if name in joints else None,
        position=position,
        rotation=rotation,
        axis=axis / length if length > 0 else np.array([1.0, 0.0, 0.0]),
    )


def _child(element: ElementTree.Element) -> str:
    child = element.find("child")
    return "" if child is None else child.get("link", "")
