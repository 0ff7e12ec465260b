"""The block of one row of clearance: a point of a body stays on its side of a plane that is fixed to another body.

It reads the joints between the two bodies and the three variables of the plane, and is made once for each pair of
joints of an arm. With no joint between, it is the row of the body that the plane is fixed to, on the other side.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.frames import SX
from nospill.laws import codegen
from nospill.laws.constraints.base import smooth_rows
from nospill.laws.constraints.clearance import Clearance, clearance_budget
from nospill.robots.description.urdf_tree import read_tree
from nospill.robots.kinematics.bodies import chain_bodies
from nospill.robots.kinematics.chain import frame_in_frame
from nospill.transcription.tray_block import functions_of

PLANE = 3
"""Variables of a plane: two turns of its normal, tangents of angles, and its way along that in `Clearance.least_size`.
"""
POINT, DISC, AXIS = slice(0, 3), 3, slice(4, 7)
"""Places among a row's numbers: a point of the core of its body and the radius of its disc, m, about an axis, in the
frame of its joint."""
NORMAL, ACROSS, OFFSET = slice(7, 10), slice(10, 16), 16
"""Of the plane where its variables are zero: its unit normal towards the body it is fixed to, two unit vectors across
that, and its offset, m, in the frame of the joint that it is fixed to; what the body's ball takes is taken off."""
LIMIT, RESERVE = 17, 18
"""The distance to be kept from the plane, m, and the back-off."""
NUMBERS = 19

_ROUNDED = 1e-6
"""Rounds off the reach of a disc that faces its plane, to the safe side: by a thousandth of its radius."""


@dataclass(frozen=True, slots=True)
class Between:
    """The joints between two bodies of an arm.

    Attributes:
        urdf, joints, tip: of the arm.
        inner: number of the moving joints before the body that the plane is fixed to, 0 where it stands still.
        outer: before the body that keeps away from it; as many for the row of the first body itself.
    """

    urdf: str
    joints: tuple[str, ...]
    tip: str
    inner: int
    outer: int

    @property
    def count(self) -> int:
        """How many joints there are between the two."""
        return self.outer - self.inner


@dataclass(frozen=True, eq=False)
class ClearanceBlock:
    """Functions of z, the joints between the bodies, rad, and the variables of the plane, and of a row's numbers.

    Attributes:
        value: (z, numbers) -> row, at least zero.
        slope: (z, numbers) -> row, its gradient.
        curvature: (z, numbers, multiplier) -> upper triangle of the Hessian, column by column.
    """

    value: Any
    slope: Any
    curvature: Any


@lru_cache(maxsize=64)
def clearance_block(between: Between) -> ClearanceBlock:
    """The block of a pair of joints."""
    made, _, _ = codegen.functions("plane", between, lambda: (_build(between), None))
    return ClearanceBlock(made["value"], made["slope"], made["curvature"])


def _build(between: Between) -> codegen.Functions:
    z, own, multiplier = SX.sym("z", between.count + PLANE), SX.sym("own", NUMBERS), SX.sym("l")
    q, turns, way = z[: between.count], z[between.count : between.count + 2], z[-1]
    chain = chain_bodies(read_tree(between.urdf), between.joints, between.tip)
    position, rotation = frame_in_frame(chain, between.inner, q)
    normal = (own[NORMAL] + ca.reshape(own[ACROSS], 3, 2) @ turns) / ca.sqrt(1 + ca.sumsqr(turns))
    beyond = own[OFFSET] + Clearance.least_size * way - ca.dot(normal, position + rotation @ own[POINT])
    facing = ca.dot(normal, rotation @ own[AXIS])
    reach = own[DISC] * ca.sqrt(1 - facing**2 + _ROUNDED)
    distance = (beyond if between.count else -beyond) - reach
    row, _, _ = smooth_rows(clearance_budget(distance, own[LIMIT]), own[RESERVE])
    rows, columns = upper_triangle(z.numel())
    hessian = ca.densify(ca.hessian(multiplier * row, z)[0])
    return functions_of(
        {
            "value": ([z, own], [row]),
            "slope": ([z, own], [row, ca.gradient(row, z)]),
            "curvature": ([z, own, multiplier], [hessian[(columns * z.numel() + rows).tolist()]]),
        }
    )


def upper_triangle(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the entries of an upper triangle, column by column."""
    columns, rows = np.tril_indices(size)
    return rows, columns
