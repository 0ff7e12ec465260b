"""A description as URDF text: links with mass properties and joints, every digit kept; reading gives it again."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence

from nospill.robots.description.urdf_tree import MESHES, UrdfJoint, UrdfTree, Vector


def write_tree(tree: UrdfTree) -> str:
    """Write a description as URDF text: links with mass properties, joints and what a reader says of them."""
    lines = ['<?xml version="1.0"?>', *([f"<!-- {MESHES}{tree.meshes} -->"] if tree.meshes else [])]
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
    lines += _beside(tree.geared, "transmission", "actuator", "<mechanicalReduction>other than 1</mechanicalReduction>")
    lines += _beside(tree.narrowed, "ros2_control", "command_interface", '<param name="max"/>')
    return "\n".join([*lines, "</robot>", ""])


def _joint_lines(joint: UrdfJoint) -> list[str]:
    lines = [
        f'  <joint name={_quoted(joint.name)} type="{joint.kind}">',
        f"    <parent link={_quoted(joint.parent)}/>",
        f"    <child link={_quoted(joint.child)}/>",
        f'    <origin xyz="{_row(joint.position)}" rpy="{_row(joint.rpy)}"/>',
    ]
    if joint.kind in ("revolute", "continuous", "prismatic"):
        lines.append(f'    <axis xyz="{_row(joint.axis)}"/>')
    stated = " ".join(f'{key}="{_digits(value)}"' for key, value in joint.limits().items())
    if stated:
        lines.append(f"    <limit {stated}/>")
    if joint.mimic is not None:
        factor, offset = _digits(joint.mimic.multiplier), _digits(joint.mimic.offset)
        lines.append(f'    <mimic joint={_quoted(joint.mimic.joint)} multiplier="{factor}" offset="{offset}"/>')
    if joint.safety is not None:
        soft = joint.safety
        keys = {"soft_lower_limit": soft.lower, "soft_upper_limit": soft.upper}
        keys |= {"k_position": soft.position_gain, "k_velocity": soft.speed_gain}
        own = "".join(f' {key}="{_digits(value)}"' for key, value in keys.items() if not math.isnan(value))
        lines.append(f"    <safety_controller{own}/>")
    if joint.calibrated:
        lines.append("    <calibration/>")
    if joint.has_friction:
        lines.append('    <dynamics friction="1"/>')
    return [*lines, "  </joint>"]


def _beside(joints: Sequence[str], tag: str, part: str, own: str) -> list[str]:
    """An element beside the joints which says that something is stated for them; its value is not kept."""
    rows = [f"<joint name={_quoted(name)}><{part}>{own}</{part}></joint>" for name in joints]
    return [f"  <{tag}>{''.join(rows)}</{tag}>"] if rows else []


def _quoted(text: str) -> str:
    # xml.sax.saxutils, which is meant for this, would load urllib and http with it
    return f'"{html.escape(text)}"'


def _row(values: Vector) -> str:
    return " ".join(_digits(value) for value in values)


def _digits(value: float) -> str:
    return repr(int(value)) if value.is_integer() else repr(float(value))
