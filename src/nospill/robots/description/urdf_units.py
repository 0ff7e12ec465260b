"""Lengths and angles of a URDF that are hardly meant in m and rad: the format has no other units.

Limits beyond what joints do count as not set (`urdf_limits`), masses and inertias as not known
(`kinematics.inertias`); a chain of a wrong size has no right reading and is refused.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from nospill.errors import ScenarioError
from nospill.robots.description.urdf_tree import UrdfJoint, UrdfTree

_LONGEST = 10.0
"""m from one joint to the next; a bare length of a scenario is no longer either."""
_MOST_TURNED = 4.0 * math.pi + 1e-3
"""rad of a roll, pitch or yaw; a bare angle of a scenario is no larger either."""


def require_si(way: Sequence[UrdfJoint]) -> None:
    """Refuse a chain whose numbers are hardly meant in SI units.

    Args:
        way: the joints from the root to the tip.

    Raises:
        ScenarioError: naming joint, value and the unit that is probably meant.
    """
    first = next((index for index, joint in enumerate(way) if joint.kind != "fixed"), 0)
    for index, joint in enumerate(way):
        far = max(abs(value) for value in joint.position)
        if far > _LONGEST and index > first:  # where the arm stands in its world is another matter
            raise ScenarioError(
                f'the URDF places joint {joint.name!r} at xyz="{_row(joint.position)}", which is hardly meant in m '
                f"({far:.4g} mm would be usual); a URDF is in m: divide its lengths by 1000, and check masses, "
                "inertias and the scale of its meshes"
            )
        turned = max(abs(value) for value in joint.rpy)
        if turned > _MOST_TURNED:
            raise ScenarioError(
                f'the URDF turns joint {joint.name!r} by rpy="{_row(joint.rpy)}", which is hardly meant in rad '
                f"({turned:.4g} deg would be usual); a URDF is in rad: multiply its angles by pi/180"
            )


def chain_length(way: Sequence[UrdfJoint]) -> float:
    """Length of a chain along its joints, m."""
    return sum(float(np.linalg.norm(joint.position)) for joint in way)


def arm_length(tree: UrdfTree, tip: str) -> float:
    """Length from the first moving joint to the tip, m: what stands below the arm is none of it."""
    way = tree.way_to(tip)
    first = next((index for index, joint in enumerate(way) if joint.kind != "fixed"), 0)
    return chain_length(way[first + 1 :])


def _row(values: Sequence[float]) -> str:
    return " ".join(f"{value:g}" for value in values)
