"""The block of one body beside a plane that is fixed to another body: how far its points are from the plane.

It reads the joints between the two bodies and the three variables of the plane, and is made once for each pair of
joints of an arm. With no joint between, it is of the body that the plane is fixed to, on the other side.

The distance of a point is linear in it and in the radius of its disc, with five coefficients that all points of a body
share: these are what the block gives, so the arm's kinematics are found once for all points.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from nospill.compiled import codegen
from nospill.compiled.kept import kept
from nospill.core.frames import SX
from nospill.laws.constraints.clearance import Clearance
from nospill.robots.kinematics.chain import frame_in_frame, joints_between
from nospill.robots.kinematics.frames import arm_chain
from nospill.transcription.tray_block import functions_of

PLANE = 3
"""Variables of a plane: two turns of its normal, tangents of angles, and its way along that in `Clearance.least_size`.
"""
AXIS, NORMAL, ACROSS, OFFSET = slice(0, 3), slice(3, 6), slice(6, 12), 12
"""Places among the numbers of a body beside a plane: the axis of the body's discs, in the frame of its joint. Of the
plane where its variables are zero: its unit normal towards the body it is fixed to, two unit vectors across that, and
its offset, m, in the frame of the joint that it is fixed to; what the body's ball takes is taken off."""
NUMBERS = 13
POINT, DISC, LIMIT, BACKOFF = slice(0, 3), 3, 4, 5
"""Places among the numbers of a point, which is a row: the point of the core of its body in the frame of its joint and
the radius of its disc, m, the distance to be kept from the plane, m, and the back-off."""
POINT_NUMBERS = 6
COEFFICIENTS = 5
"""Of 1, of a point's three coordinates and of the radius of its disc, in its distance as part of `least_size`."""

_ROUNDED = 1e-6
"""Rounds off the reach of a disc that faces its plane, to the safe side: by a thousandth of its radius."""


@dataclass(frozen=True, slots=True)
class Between:
    """The joints between two bodies of an arm.

    Attributes:
        urdf, joints, tip: of the arm.
        inner: number of the moving joints (those that follow others counted) before the body that the plane is fixed
            to, 0 where it stands still.
        outer: before the body that keeps away from it; as many for the row of the first body itself.
    """

    urdf: str
    joints: tuple[str, ...]
    tip: str
    inner: int
    outer: int

    @property
    def read(self) -> list[int]:
        """Indices in q of the joints that turn what is between the two; none of the row of the first body itself."""
        return joints_between(arm_chain(self), self.inner, self.outer)

    @property
    def count(self) -> int:
        """How many joints these are."""
        return len(self.read)


@dataclass(frozen=True, eq=False)
class ClearanceBlock:
    """Functions of z, the joints between the bodies, rad, and the variables of the plane, and of a body's numbers.

    Attributes:
        value: (z, numbers) -> coefficients (1, `COEFFICIENTS`).
        slope: (z, numbers) -> coefficients, and the gradient of each, a column.
        curvature: (z, numbers, multipliers of the coefficients) -> upper triangle of the Hessian, column by column.
    """

    value: Any
    slope: Any
    curvature: Any


@kept(maxsize=64)
def clearance_block(between: Between) -> ClearanceBlock:
    """The block of a pair of joints."""
    made, _, _ = codegen.functions("plane", between, lambda: (_build(between), None))
    return ClearanceBlock(made["value"], made["slope"], made["curvature"])


def _build(between: Between) -> codegen.Functions:
    count = between.count
    z, own = SX.sym("z", count + PLANE), SX.sym("own", NUMBERS)
    multipliers = SX.sym("l", COEFFICIENTS)
    q, turns, way = z[:count], z[count : count + 2], z[-1]
    position, rotation = frame_in_frame(arm_chain(between), between.inner, between.outer, q)
    normal = (own[NORMAL] + ca.reshape(own[ACROSS], 3, 2) @ turns) / ca.sqrt(1 + ca.sumsqr(turns))
    beyond = own[OFFSET] + Clearance.least_size * way - ca.dot(normal, position)
    seen = rotation.T @ normal  # from the body's joint
    reach = ca.sqrt(1 - ca.dot(seen, own[AXIS]) ** 2 + _ROUNDED)
    distance = ca.vertcat(beyond, -seen) if count else ca.vertcat(-beyond, seen)
    coefficients = ca.vertcat(distance, -reach) / Clearance.least_size
    rows, columns = upper_triangle(z.numel())
    hessian = ca.densify(ca.hessian(ca.dot(multipliers, coefficients), z)[0])
    return functions_of(
        {
            "value": ([z, own], [coefficients.T]),
            "slope": ([z, own], [coefficients.T, ca.densify(ca.jacobian(coefficients, z).T)]),
            "curvature": ([z, own, multipliers], [hessian[(columns * z.numel() + rows).tolist()]]),
        }
    )


def upper_triangle(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the entries of an upper triangle, column by column."""
    columns, rows = np.tril_indices(size)
    return rows, columns
