"""The arm as it is drawn: a chain of joint frames from its URDF."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from nospill.errors import ScenarioError


@dataclass(frozen=True, slots=True)
class ChainJoint:
    """One joint between the base and the flange.

    Attributes:
        name: of the joint.
        child: name of the link it carries.
        index: in q of the joint that turns it, its own or the one it follows, or None where it does not move.
        position: (3,) its origin in the frame of the joint before, m.
        rotation: (3, 3) its frame at angle zero, to the frame of the joint before.
        axis: (3,) unit vector it turns about, its own frame.
        factor: its angle per angle of that joint.
        offset: its angle where that joint is at zero, rad.
    """

    name: str
    child: str
    index: int | None
    position: np.ndarray
    rotation: np.ndarray
    axis: np.ndarray
    factor: float = 1.0
    offset: float = 0.0

    def wxyz(self, q: np.ndarray) -> np.ndarray:
        """Attitude in the frame of the joint before for joint positions q (m, n), rad: (m, 4), (w, x, y, z)."""
        fixed = Rotation.from_matrix(self.rotation)
        angle = np.zeros(len(q)) if self.index is None else self.factor * np.asarray(q)[:, self.index] + self.offset
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
        joints: names of the moving joints in the order of q; what follows them moves, all others stay at zero.
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


def _joint(element: ElementTree.Element, joints: tuple[str, ...], source: str) -> ChainJoint:
    name = element.get("name", "")
    position, rotation = origin_of(element, source)
    axis_element = element.find("axis")
    axis = three_numbers("1 0 0" if axis_element is None else axis_element.get("xyz", "1 0 0"), source)
    length = float(np.linalg.norm(axis))
    mimic, factor, offset = element.find("mimic"), 1.0, 0.0
    turned_by = name
    if name not in joints and mimic is not None:
        turned_by = mimic.get("joint", "")
        factor, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
    return ChainJoint(
        name=name,
        child=_child(element),
        index=joints.index(turned_by) if turned_by in joints else None,
        position=position,
        rotation=rotation,
        axis=axis / length if length > 0 else np.array([1.0, 0.0, 0.0]),
        factor=factor,
        offset=offset,
    )


def _child(element: ElementTree.Element) -> str:
    child = element.find("child")
    return "" if child is None else child.get("link", "")
