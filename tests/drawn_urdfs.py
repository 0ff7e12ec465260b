"""URDFs as others write them: six or seven joints drawn at random, with the defects of real files among them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

DEFECTS = (
    "mimic",
    "mimic chain",
    "soft limits",
    "huge limits",
    "no limit",
    "degrees",
    "deg/s",
    "massless",
    "no inertial",
    "triangle",
    "millimetres",
    "rpy in degrees",
    "turned tip",
    "effort 1000",
    "gripper",
    "rail",
    "transmission",
    "comment",
)
"""What may be wrong, or unusual, in a drawn file."""


@dataclass
class DrawnUrdf:
    """Text of a URDF, and what is in it.

    Attributes:
        text: of the file.
        laws: joint that follows -> (joint followed, factor, offset), through others too.
        bounds: joint -> lower and upper limit that bind by the file, where both are meant in rad.
        speeds: joint -> speed limit, likewise.
    """

    text: str = ""
    laws: dict[str, tuple[str, float, float]] = field(default_factory=dict)
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)
    speeds: dict[str, float] = field(default_factory=dict)


def drawn_urdf(seed: int, defects: frozenset[str]) -> DrawnUrdf:
    """A file with some of `DEFECTS`."""
    generator = np.random.default_rng(seed)
    found = DrawnUrdf()
    joints = int(generator.integers(6, 8))
    parts = ['<link name="base"/>']
    parent = "base"
    if "rail" in defects:
        parts.append(
            '<link name="car"/><joint name="rail" type="prismatic"><parent link="base"/><child link="car"/>'
            '<axis xyz="0 1 0"/><limit lower="0.1" upper="0.9" velocity="1" effort="100"/></joint>'
        )
        parent = "car"
    free = [f"j{number}" for number in range(1, joints + 1)]
    victim = int(generator.integers(1, joints + 1))
    follower = int(generator.integers(2, joints + 1))
    for number, name in enumerate(free, start=1):
        defective = number == victim
        parts.append(_link(generator, f"l{number}", defects if defective else frozenset(), number))
        lower, upper = -float(generator.uniform(1.0, 3.0)), float(generator.uniform(1.0, 3.0))
        speed = float(generator.uniform(1.0, 4.0))
        kept = True
        inner = ""
        if defective and "soft limits" in defects:
            soft = lower + 0.2, upper + 0.3
            inner = f'<safety_controller soft_lower_limit="{soft[0]!r}" soft_upper_limit="{soft[1]!r}" k_velocity="9"/>'
            own = "degrees" in defects or "huge limits" in defects or "no limit" in defects  # no others bind
            found.bounds[name] = soft[0], soft[1] if own else upper
        shown = [repr(lower), repr(upper), repr(speed), repr(float(generator.uniform(20.0, 200.0)))]
        if "degrees" in defects:
            shown[0], shown[1], kept = repr(57.3 * lower), repr(57.3 * upper), False
        if defective and "huge limits" in defects:
            shown[0], shown[1], kept = (
                "-1e19",
                str(generator.choice(["1e19", "9999", "1.7976931348623157e308"])),
                False,
            )
        if "deg/s" in defects:
            shown[2] = repr(57.3 * speed)
        else:
            found.speeds[name] = speed
        if defective and "effort 1000" in defects:
            shown[3] = "1000"
        if kept:
            found.bounds.setdefault(name, (lower, upper))
        keys = dict(zip(("lower", "upper", "velocity", "effort"), shown, strict=True))
        if defective and "no limit" in defects:
            del keys["lower"], keys["upper"]
            if "soft limits" not in defects:
                found.bounds.pop(name, None)
        limit = "<limit " + " ".join(f'{key}="{value}"' for key, value in keys.items()) + "/>"
        scale = 1000.0 if "millimetres" in defects else 1.0
        turn = 57.3 if "rpy in degrees" in defects else 1.0
        place = " ".join(repr(float(value)) for value in scale * generator.uniform(0.02, 0.3, 3))
        rpy = " ".join(repr(float(value)) for value in turn * generator.uniform(-1.5, 1.5, 3))
        axis = " ".join(repr(float(value)) for value in generator.uniform(0.2, 1.0, 3) * generator.choice([-1, 1], 3))
        parts.append(
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="l{number}"/>'
            f'<origin xyz="{place}" rpy="{rpy}"/><axis xyz="{axis}"/>{limit}{inner}</joint>'
        )
        parent = f"l{number}"
        if number == follower and ("mimic" in defects or "mimic chain" in defects):
            parent = _follow(generator, parts, found, parent, f"j{int(generator.integers(1, number + 1))}", "f1")
            if "mimic chain" in defects:
                parent = _follow(generator, parts, found, parent, "f1", "f2")
    rpy = "0 -1.5707963267948966 0" if "turned tip" in defects else "0 0 0"
    parts.append(
        f'<link name="tool0"/><joint name="tip" type="fixed"><parent link="{parent}"/><child link="tool0"/>'
        f'<origin xyz="0 0.01 0.05" rpy="{rpy}"/></joint>'
    )
    if "gripper" in defects:
        parts.append(
            f'<link name="jaw"><inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" '
            f'iyz="0"/></inertial></link><joint name="jaw" type="prismatic"><parent link="{parent}"/>'
            '<child link="jaw"/>'
            '<axis xyz="0 1 0"/><limit lower="0" upper="0.04" velocity="1" effort="10"/></joint>'
            f'<link name="other"/><joint name="other" type="prismatic"><parent link="{parent}"/><child link="other"/>'
            '<axis xyz="0 1 0"/><limit lower="0" upper="0.04" velocity="1" effort="10"/><mimic joint="jaw"/></joint>'
        )
    if "transmission" in defects:
        parts.append(
            '<transmission name="t"><joint name="j1"><hardwareInterface>p</hardwareInterface></joint>'
            '<actuator name="m">'
            "<mechanicalReduction>50</mechanicalReduction></actuator></transmission>"
        )
    if "comment" in defects:
        parts.append("<!-- made by ${tool} <xacro:arm/> -->")
    order = generator.permutation(len(parts)) if generator.uniform() < 0.3 else range(len(parts))
    found.text = f'<robot name="drawn">{"".join(parts[index] for index in order)}</robot>'
    return found


def _link(generator: np.random.Generator, name: str, defects: frozenset[str], number: int) -> str:
    if "no inertial" in defects:
        return f'<link name="{name}"/>'
    mass = 0.0 if "massless" in defects else float(generator.uniform(1.0, 4.0)) / number
    moments = [mass * float(value) for value in generator.uniform(0.004, 0.006, 3)]
    if "triangle" in defects:
        moments[2] = 3.0 * (moments[0] + moments[1])
    centre = " ".join(repr(float(value)) for value in generator.uniform(-0.05, 0.05, 3))
    tensor = " ".join(f'{key}="{value!r}"' for key, value in zip(("ixx", "iyy", "izz"), moments, strict=True))
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass!r}"/>'
        f'<inertia {tensor} ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _follow(
    generator: np.random.Generator, parts: list[str], found: DrawnUrdf, parent: str, leader: str, name: str
) -> str:
    factor, offset = float(generator.uniform(0.2, 1.5) * generator.choice([-1, 1])), float(generator.uniform(-0.2, 0.2))
    parts.append(
        f'<link name="link_{name}"><inertial><mass value="0.7"/><inertia ixx="0.003" iyy="0.003" izz="0.002" ixy="0" '
        f'ixz="0" iyz="0"/></inertial></link><joint name="{name}" type="revolute"><parent link="{parent}"/>'
        f'<child link="link_{name}"/><origin xyz="0 0.02 0.1" rpy="0.3 0 -0.2"/><axis xyz="0 1 0.2"/>'
        f'<limit lower="-2.0" upper="2.1" velocity="1.5" effort="50"/>'
        f'<mimic joint="{leader}" multiplier="{factor!r}" offset="{offset!r}"/></joint>'
    )
    further = found.laws.get(leader)
    if further is not None:
        leader, factor, offset = further[0], factor * further[1], factor * further[2] + offset
    found.laws[name] = leader, factor, offset
    return f"link_{name}"
