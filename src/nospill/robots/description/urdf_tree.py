"""The text of a URDF file as records: what the format says, checked, without meshes; `urdf_text` writes them again.

Units and conventions are those of the format (http://wiki.ros.org/urdf/XML): m, rad, kg, kg m^2; roll, pitch and yaw
turn about fixed x, y and z in this order; a joint's frame is its child link's frame.
"""

from __future__ import annotations

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
MESHES = "mesh files named in the original and not used here: "
_LARGEST = 1e9
"""No length, mass or angle of a description is larger: squares stay far from the end of the floating-point range."""


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
class Mimic:
    """What a joint follows: its position is `multiplier` times that of another joint, plus `offset` (rad or m)."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class SafetyController:
    """Soft limits of a joint, rad, and the gains of what keeps to them, 1/s and N m s; NaN where none are written."""

    lower: float = math.nan
    upper: float = math.nan
    position_gain: float = math.nan
    speed_gain: float = math.nan


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """One joint; limits that are not written are NaN, "inf" stays infinite.

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
        max_acceleration: `acceleration` of the file, rad/s^2.
        max_jerk: `jerk` of the file, rad/s^3.
        mimic: the joint it follows, or None.
        safety: its safety controller, or None.
        calibrated: whether reference positions are written.
        has_friction: whether friction or damping is written.
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
    max_acceleration: float = _NOT_SET
    max_jerk: float = _NOT_SET
    mimic: Mimic | None = None
    safety: SafetyController | None = None
    calibrated: bool = False
    has_friction: bool = False

    def limits(self) -> dict[str, float]:
        """What its `<limit>` states, by the attributes of the format."""
        stated = {
            "lower": self.lower,
            "upper": self.upper,
            "velocity": self.max_speed,
            "effort": self.max_torque,
            "acceleration": self.max_acceleration,
            "jerk": self.max_jerk,
        }
        return {key: value for key, value in stated.items() if not math.isnan(value)}


@dataclass(frozen=True, slots=True)
class UrdfTree:
    """A description: every link with its mass properties, every joint, one root.

    Attributes:
        name: the robot's name, "robot" where none is written.
        links: link -> mass properties or None.
        joints: in the order of the file.
        meshes: number of mesh files it named; they are not used.
        geared: joints whose transmission states a reduction.
        narrowed: joints for which a command interface states a least or greatest value.
    """

    name: str
    links: dict[str, Inertial | None]
    joints: tuple[UrdfJoint, ...]
    meshes: int = 0
    geared: tuple[str, ...] = ()
    narrowed: tuple[str, ...] = ()

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
    written = re.search(re.escape(MESHES) + r"(\d{1,6}) ", text)
    meshes = int(written[1]) if written else sum(1 for _ in top.iter("mesh"))
    known = {joint.name for joint in joints}
    geared, narrowed = (tuple(dict.fromkeys(name for name in found(top) if name in known)) for found in _BESIDE)
    tree = UrdfTree(top.get("name") or "robot", links, joints, meshes, geared, narrowed)
    _check(tree)
    return tree


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
    """A limit, or NaN where none is written; exporters write any large number, and "inf", where there is none."""
    text = None if element is None or not moves else element.get(key)
    if text is None:
        return _NOT_SET
    try:
        return float(text)
    except ValueError:
        raise ScenarioError(f'the URDF has {key}="{_short(text)}" at {where}, where a number must stand') from None


def _mimic(element: ElementTree.Element | None, where: str) -> Mimic | None:
    if element is None:
        return None
    name = element.get("joint", "").strip()
    if not name:
        raise ScenarioError(f"the URDF has a <mimic> without a joint at {where}; name the joint that it follows")
    return Mimic(name, _number(element, "multiplier", where, 1.0), _number(element, "offset", where, 0.0))


def _safety(element: ElementTree.Element | None, where: str) -> SafetyController | None:
    if element is None:
        return None
    keys = ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity")
    return SafetyController(*(_limit(element, key, where, True) for key in keys))


def _has_friction(element: ElementTree.Element | None, where: str) -> bool:
    return any(_number(element, key, where, 0.0) != 0.0 for key in ("friction", "damping"))


def _geared(top: ElementTree.Element) -> list[str]:
    """Joints of the transmissions that state another reduction than 1; what is no number counts too."""
    found: list[str] = []
    for element in top.iter("transmission"):
        stated = [(own.text or "").strip() for own in element.iter("mechanicalReduction")]
        stated += [(own.text or "").strip() for own in element.iter("mechanical_reduction")]
        if any(text not in ("", "1", "1.0") for text in stated):
            found += [own.get("name", "") for own in element.iter("joint")]
    return found


def _narrowed(top: ElementTree.Element) -> list[str]:
    """Joints of ros2_control for which a command interface states "min" or "max"."""
    return [
        joint.get("name", "")
        for control in top.iter("ros2_control")
        for joint in control.iter("joint")
        if any(
            param.get("name") in ("min", "max")
            for interface in joint.iter("command_interface")
            for param in interface.iter("param")
        )
    ]


_BESIDE = (_geared, _narrowed)


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
        max_acceleration=_limit(limit, "acceleration", where, moves),
        max_jerk=_limit(limit, "jerk", where, moves),
        mimic=_mimic(element.find("mimic"), where) if moves else None,
        safety=_safety(element.find("safety_controller"), where) if moves else None,
        calibrated=moves and element.find("calibration") is not None,
        has_friction=moves and _has_friction(element.find("dynamics"), where),
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


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= 40 else line[:36] + " ..."
