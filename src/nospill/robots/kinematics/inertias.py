"""Masses and inertias of a description: what cannot be real, link by link, and which joint torques do not need it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nospill.robots.description.urdf_tree import Inertial, UrdfTree
from nospill.robots.kinematics.bodies import carried, turned_by

_LIGHTEST = 1e-6  # kg
_FLATTEST = 1e-9  # kg m^2
_ROUNDING = 0.05
"""Part by which a principal moment may exceed the sum of the other two: descriptions are rounded to few digits."""
_DENSEST = 1000.0
"""kg/m^3 of the mass of an arm over the cube of its length; a UR5e has some 20."""


@dataclass(frozen=True, slots=True)
class InertiaFaults:
    """What speaks against the masses and inertias of an arm.

    Attributes:
        known: for each joint, whether its torque needs nothing that is in doubt: it depends on what is behind it alone.
        reason: in words with links and values, or None.
    """

    known: tuple[bool, ...]
    reason: str | None


def inertia_faults(tree: UrdfTree, joints: Sequence[str], *, length: float | None = None) -> InertiaFaults:
    """Return what cannot be real.

    Args:
        tree: the description.
        joints: its moving joints, base to tip.
        length: of the chain, m, against which masses and distances are compared; None leaves that out.
    """
    children = tree.joints_on()
    moving = sorted(
        (item for item in tree.joints if turned_by(item, joints)), key=lambda item: len(tree.way_to(item.child))
    )
    names = {item.name for item in moving}
    faults: list[str] = []
    last = -1
    stated: list[Inertial] = []
    total = 0.0
    for number, joint in enumerate(moving):
        own = tree.links[joint.child]
        mass, _, inertia = carried(tree, children, joint.child, names)
        total += mass
        fault = _fault(joint.child, own, mass, inertia, length)
        if fault is not None:
            faults.append(fault)
            last = number
        if own is not None:
            stated.append(own)
    everywhere = _of_all(stated, total, length)
    if everywhere is not None:
        return InertiaFaults((False,) * len(joints), everywhere)
    # a joint's torque is that of all bodies from the first one that it turns
    first = {name: next(k for k, item in enumerate(moving) if turned_by(item, joints) == name) for name in joints}
    return InertiaFaults(tuple(first[name] > last for name in joints), "; ".join(faults[:3]) or None)


def _fault(link: str, own: Inertial | None, mass: float, inertia: np.ndarray, length: float | None) -> str | None:
    if mass < _LIGHTEST:
        return f"link {link!r} has no mass"
    alone = own is not None and own.mass >= _LIGHTEST
    principal = np.linalg.eigvalsh(own.inertia()) if own is not None and alone else None
    if np.linalg.eigvalsh(inertia)[0] < _FLATTEST or (principal is not None and principal[0] <= 0.0):
        return f"the inertia of link {link!r} is not positive definite"
    if own is None or principal is None:
        return None
    if principal[2] > (1.0 + _ROUNDING) * (principal[0] + principal[1]):
        least, middle, greatest = (f"{value:.3g}" for value in principal)
        return (
            f"the inertia of link {link!r} breaks the triangle inequality: its principal moments are {least}, {middle} "
            f"and {greatest} kg m^2, and none of a body is above the sum of the other two"
        )
    if length is not None:
        gyration, centre = float(np.sqrt(principal[2] / own.mass)), float(np.linalg.norm(own.centre))
        if gyration > length:
            return (
                f"the inertia of link {link!r} is that of {own.mass:.3g} kg at {gyration:.3g} m from its centre, which "
                f"is more than the whole arm is long ({length:.3g} m)"
            )
        if centre > length:
            return f"the centre of mass of link {link!r} is {centre:.3g} m from its joint, in an arm of {length:.3g} m"
    return None


def _of_all(stated: Sequence[Inertial], total: float, length: float | None) -> str | None:
    kinds = {(own.mass, own.tensor) for own in stated}
    if len(stated) > 1 and len(kinds) == 1 and stated[0].mass >= _LIGHTEST:
        return "all links have the same mass and inertia, which are placeholders"
    if stated and all(own.tensor == (1.0, 0.0, 0.0, 1.0, 0.0, 1.0) for own in stated):
        return "all links have the unit inertia, which is a placeholder"
    if length is not None and total > _DENSEST * length**3:
        return f"the links weigh {total:.4g} kg in an arm of {length:.3g} m, which is hardly meant in kg"
    return None
