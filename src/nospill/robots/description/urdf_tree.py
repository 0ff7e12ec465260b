"""The text of a URDF file as records and back: what the format says, checked, without meshes.

Units and conventions are those of the format (http://wiki.ros.org/urdf/XML): m, rad, kg, kg m^2; roll, pitch and yaw
turn about fixed x, y and z in this order; a joint's frame is its child link's frame.
"""

from __future__ import annotations

import html
import math
import re
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from nospill.errors import ScenarioError

JOINT_KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")

Vector = tuple[float, ...]

_ZERO = (0.0, 0.0, 0.0)
_NOT_SET = math.nan
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_XACRO = re.compile(r"<xacro:|=\s*\"[^\"]*\$[({]|=\s*'[^']*\$[({]")
_DECLARATION = re.compile(r"<!(DOCTYPE|ENTITY)", re.IGNORECASE)
_MESHES = "mesh files named in the original and not used here: "
_LARGEST = 1e9
"""No number of a description is larger: squares stay far from the end of the floating-point range."""


@dataclass(frozen=True, slots=True)
class Inertial:
    """Mass properties of a link: mass, kg; centre of mass, m; axes of the tensor, rad; tensor about the centre, kg m^2.

    The tensor is (ixx, ixy, ixz, iyy, iyz, izz).
    """

    mass: float
    centre: Vector
    rpy: Vector
    tensor: Vector

    def inertia(self) -> np.ndarray:
        """Return the inertia (3, 3) about the centre of mass in link axes, kg m^2."""
        xx, xy, xz, yy, yz, zz = self.tensor
        turn = rotation_of(self.rpy)
        return turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """One joint; limits that are not written are NaN.

    Attributes:
        name: as written.
        kind: `type` of the file, one of `JOINT_KINDS`.
        parent: link.
        child: link.
        position: origin of the joint frame in the parent link's frame at zero, m.
        rpy: its roll, pitch and yaw there, rad.
        axis: as written, in the joint frame, never zero.
        lower: rad (m if prismatic).
        upper: likewise.
        max_speed: `velocity` of the file, rad/s.
        max_torque: `effort` of the file, N m.
        mimic: whether it copies another joint.
    """

    name: str
    kind: str
    parent: str
    child: str
    position: Vector = _ZERO
    rpy: Vector = _ZERO
    axis: Vector = (1.0, 0.0, 0.0)
    lower: float = _NOT_SET
    upper: float = _NOT_SET
    max_speed: float = _NOT_SET
    max_torque: float = _NOT_SET
    mimic: bool = False


@dataclass(frozen=True, slots=True)
class UrdfTree:
    """A description: every link with its mass properties, every joint, one root.

    Attributes:
        name: the robot's name, "robot" where none is written.
        links: link -> mass properties or None.
        joints: in the order of the file.
        meshes: number of mesh files it named; they are not used.
    """

    name: str
    links: dict[str, Inertial | None]
    joints: tuple[UrdfJoint, ...]
    meshes: int = 0

    def root(self) -> str:
        """The link that no joint carries."""
        carried = {joint.child for joint in self.joints}
        return next(link for link in self.links if link not in carried)

    def way_to(self, tip: str) -> list[UrdfJoint]:
        """The joints from the root to a link, in this order."""
        carrier = {joint.child: joint for joint in self.joints}
        way: list[UrdfJoint] = []
        link = tip
        while link in carrier:
            way.append(carrier[link])
            link = carrier[link].parent
        return way[::-1]

    def joints_on(self) -> dict[str, list[UrdfJoint]]:
        """Link -> the joints it carries, in the order of the file; links without any are left out."""
        found: dict[str, list[UrdfJoint]] = {}
        for joint in self.joints:
            found.setdefault(joint.parent, []).append(joint)
        return found


def read_tree(text: str) -> UrdfTree:
    """Read the text of a URDF file.

    Raises:
        ScenarioError: it is no URDF (no XML, another format, a xacro file, declarations of its own), or it contradicts
            itself (names twice or unknown, numbers that are none, several roots, a loop).
    """
    bare = _COMMENT.sub("", text)
    if _DECLARATION.search(bare):
        raise ScenarioError(
            "the URDF declares a document type or entities; remove the <!DOCTYPE ...> and <!ENTITY ...>"
        )
    if _XACRO.search(bare):
        raise ScenarioError("this is a xacro file, not a URDF; expand it first (xacro arm.xacro > arm.urdf)")
    try:
        top = ElementTree.fromstring(bare.strip())
    except (ElementTree.ParseError, ValueError) as error:  # ValueError: characters XML does not allow
        raise ScenarioError(f"the URDF is no XML ({error}); give a URDF file") from None
    if top.tag != "robot":
        raise ScenarioError(f"the URDF starts with <{_short(top.tag)}> where <robot> is expected; give a URDF file")
    links: dict[str, Inertial | None] = {}
    for element in top.findall("link"):
        name = _name(element, "link")
        if name in links:
            raise ScenarioError(f"the URDF has two links named {name!r}; give every link its own name")
        links[name] = _inertial(element, name)
    joints = tuple(_joint(element) for element in top.findall("joint"))
    # written by write_tree, so that reading what it wrote gives an equal tree
    written = re.search(re.escape(_MESHES) + r"(\d{1,6}) ", text)
    meshes = int(written[1]) if written else sum(1 for _ in top.iter("mesh"))
    tree = UrdfTree(top.get("name") or "robot", links, joints, meshes)
    _check(tree)
    return tree


def write_tree(tree: UrdfTree) -> str:
    """Write a description as URDF text: links with mass properties, joints, nothing else; every digit is kept."""
    lines = ['<?xml version="1.0"?>', *([f"<!-- {_MESHES}{tree.meshes} -->"] if tree.meshes else [])]
    lines.append(f"<robot name={_quoted(tree.name)}>")
    for name, inertial in tree.links.items():
        if inertial is None:
            lines.append(f"  <link name={_quoted(name)}/>")
            continue
        tensor = " ".join(
            f'i{axes}="{_digits(value)}"'
            for axes, value in zip(("xx", "xy", "xz", "yy", "yz", "zz"), inertial.tensor, strict=True)
        )
        lines += [
            f"  <link name={_quoted(name)}>",
            "    <inertial>",
            f'      <origin xyz="{_row(inertial.centre)}" rpy="{_row(inertial.rpy)}"/>',
            f'      <mass value="{_digits(inertial.mass)}"/>',
            f"      <inertia {tensor}/>",
            "    </inertial>",
            "  </link>",
        ]
    for joint in tree.joints:
        lines += _joint_lines(joint)
    return "\n".join([*lines, "</robot>", ""])


def rotation_of(rpy: Vector) -> np.ndarray:
    """Return Rz(yaw) Ry(pitch) Rx(roll) (3, 3); entries below 1e-15, the rounding of right angles, are zero."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    turn = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    return np.where(np.abs(turn) < 1e-15, 0.0, turn)


def rpy_of(rotation: np.ndarray) -> Vector:
    """Return roll, pitch and yaw of a rotation (3, 3), rad; exact at pitch = +-90 deg too.

    The yaw comes first and the roll from what is left of the rotation without it, so that both stay consistent where
    they are not separate.
    """
    pitch = math.atan2(-rotation[2, 0], math.hypot(rotation[0, 0], rotation[1, 0]))
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    s, c = math.sin(yaw), math.cos(yaw)
    roll = math.atan2(s * rotation[0, 2] - c * rotation[1, 2], c * rotation[1, 1] - s * rotation[0, 1])
    return (roll, pitch, yaw)


def about_axis(axis: Vector, angle: float) -> np.ndarray:
    """Return the rotation (3, 3) by an angle, rad, about an axis of any length (Rodrigues' formula)."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def _name(element: ElementTree.Element, kind: str) -> str:
    name = element.get("name", "")
    if not name.strip():
        raise ScenarioError(f"the URDF has a {kind} without a name; give every {kind} one")
    return name


def _numbers(element: ElementTree.Element | None, key: str, count: int, where: str, standard: Vector) -> Vector:
    text = None if element is None else element.get(key)
    if text is None:
        return standard
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != count or not all(abs(value) < _LARGEST for value in values):
        wanted = "a number" if count == 1 else f"{count} numbers"
        raise ScenarioError(f'the URDF has {key}="{_short(text)}" at {where}, where {wanted} must stand')
    return values


def _number(element: ElementTree.Element | None, key: str, where: str, standard: float = _NOT_SET) -> float:
    return _numbers(element, key, 1, where, (standard,))[0]


def _limit(element: ElementTree.Element | None, key: str, where: str, moves: bool) -> float:
    """A limit, or NaN where none is written; "inf" is none."""
    if not moves or element is None or element.get(key, "").strip().lstrip("+-").lower() in ("inf", "infinity", "nan"):
        return _NOT_SET
    return _number(element, key, where)


def _inertial(link: ElementTree.Element, name: str) -> Inertial | None:
    element = link.find("inertial")
    if element is None:
        return None
    where = f"the <inertial> of link {name!r}"
    origin, tensor = element.find("origin"), element.find("inertia")
    return Inertial(
        mass=_number(element.find("mass"), "value", where, 0.0),
        centre=_numbers(origin, "xyz", 3, where, _ZERO),
        rpy=_numbers(origin, "rpy", 3, where, _ZERO),
        tensor=tuple(_number(tensor, key, where, 0.0) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")),
    )


def _joint(element: ElementTree.Element) -> UrdfJoint:
    name = _name(element, "joint")
    where, kind = f"joint {name!r}", element.get("type", "")
    if kind not in JOINT_KINDS:
        raise ScenarioError(f"the URDF has type={_short(kind)!r} at {where}; known are {', '.join(JOINT_KINDS)}")
    ends = [None if end is None else end.get("link") for end in (element.find("parent"), element.find("child"))]
    if not ends[0] or not ends[1]:
        raise ScenarioError(f"the URDF has no <parent link=...> or no <child link=...> at {where}")
    origin, limit = element.find("origin"), element.find("limit")
    axis = _numbers(element.find("axis"), "xyz", 3, where, (1.0, 0.0, 0.0))
    moves = kind in ("revolute", "continuous", "prismatic")
    if moves and np.linalg.norm(axis) < 1e-6:
        raise ScenarioError(f"the URDF has a zero axis at {where}; give the direction it turns about")
    return UrdfJoint(
        name=name,
        kind=kind,
        parent=ends[0],
        child=ends[1],
        position=_numbers(origin, "xyz", 3, where, _ZERO),
        rpy=_numbers(origin, "rpy", 3, where, _ZERO),
        axis=axis if moves else (1.0, 0.0, 0.0),
        lower=_limit(limit, "lower", where, moves),
        upper=_limit(limit, "upper", where, moves),
        max_speed=_limit(limit, "velocity", where, moves),
        max_torque=_limit(limit, "effort", where, moves),
        mimic=element.find("mimic") is not None,
    )


def _check(tree: UrdfTree) -> None:
    if not tree.links:
        raise ScenarioError("the URDF has no links; give the file of an arm")
    names: set[str] = set()
    carrier: dict[str, UrdfJoint] = {}
    for joint in tree.joints:
        if joint.name in names:
            raise ScenarioError(f"the URDF has two joints named {joint.name!r}; give every joint its own name")
        names.add(joint.name)
        for end in (joint.parent, joint.child):
            if end not in tree.links:
                raise ScenarioError(f"the URDF has no link {end!r}, which joint {joint.name!r} names")
        if joint.child in carrier:
            raise ScenarioError(
                f"the URDF carries link {joint.child!r} by two joints, {carrier[joint.child].name!r} and "
                f"{joint.name!r}; a closed chain cannot be read"
            )
        carrier[joint.child] = joint
    roots = [link for link in tree.links if link not in carrier]
    if len(roots) > 1:
        raise ScenarioError(f"the URDF falls apart: no joint carries {roots[0]!r} nor {roots[1]!r}; join them")
    children: dict[str, list[str]] = {}
    for joint in tree.joints:
        children.setdefault(joint.parent, []).append(joint.child)
    reached, waiting = set(), roots[:1]
    while waiting:
        link = waiting.pop()
        reached.add(link)
        waiting += children.get(link, [])
    if len(reached) < len(tree.links):
        lost = next(link for link in tree.links if link not in reached)
        raise ScenarioError(f"the URDF has a loop of joints at link {lost!r}; a closed chain cannot be read")


def _joint_lines(joint: UrdfJoint) -> list[str]:
    lines = [
        f'  <joint name={_quoted(joint.name)} type="{joint.kind}">',
        f"    <parent link={_quoted(joint.parent)}/>",
        f"    <child link={_quoted(joint.child)}/>",
        f'    <origin xyz="{_row(joint.position)}" rpy="{_row(joint.rpy)}"/>',
    ]
    if joint.kind in ("revolute", "continuous", "prismatic"):
        lines.append(f'    <axis xyz="{_row(joint.axis)}"/>')
    limits = {"lower": joint.lower, "upper": joint.upper, "velocity": joint.max_speed, "effort": joint.max_torque}
    stated = " ".join(f'{key}="{_digits(value)}"' for key, value in limits.items() if not math.isnan(value))
    if stated:
        lines.append(f"    <limit {stated}/>")
    if joint.mimic:
        lines.append("    <mimic/>")
    return [*lines, "  </joint>"]


def _quoted(text: str) -> str:
    # xml.sax.saxutils, which is meant for this, would load urllib and http with it
    return f'"{html.escape(text)}"'


def _row(values: Vector) -> str:
    return " ".join(_digits(value) for value in values)


def _digits(value: float) -> str:
    return repr(int(value)) if value.is_integer() else repr(float(value))


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= 40 else line[:36] + " ..."
