"""Modes of a small body of revolution whose surface at rest is curved, with surface tension: any contact angle.

The surface z = f(r) moves upright by zeta = x n(r); the liquid takes the kinetic energy of `revolved_modes` below the
curved surface, and surface and gravity hold, over pi rho g/2 and with the capillary length c and W^2 = 1 + f'^2,

    integral of [r^2 n^2 + c^2 ((r n)'^2/W^3 + n^2/W)] r dr + c^2 b R^2 n(R)^2 .

The contact line slides at its angle: the natural condition at an upright wall. A wall that leans by d, tan d = t,
adds b = R (k t + d' cos psi) cos d cos psi/cos(d + psi), where k is the curvature of the meridian of the surface at the
wall and psi its slope [docs/physics/vessels.md]. A pinned line has n(R) = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import splu

from nospill.core.arrays import read_only
from nospill.core.units import format_quantity
from nospill.errors import ModelError
from nospill.scene.meridian import Meridian
from nospill.scene.sloshing.meridian_mesh import MeridianMesh, mesh_liquid
from nospill.scene.sloshing.revolved_modes import surface_elements, surface_terms, volume_terms
from nospill.scene.surface_tension.meniscus import RestSurface, rest_surface, slope_at_wall

_REACH = 2.0
"""Depth, in radii of the surface, down to which the mesh is raised with it."""
_STEEPEST = 0.4
"""Part of this depth that the surface may be off the flat one."""
_STEP = 1e-3
"""Of the radius: difference of heights by which the curvature of the wall is taken."""


@dataclass(frozen=True, slots=True)
class CurvedModes:
    """What a vessel, a level, a capillary length and a contact angle determine; n modes of the free line by frequency.

    Attributes:
        curvature: (n,) part of omega^2/g that is gravity's, 1/m.
        tension: (n,) part of it that is the surface's, 1/m.
        pinned: (n,) omega^2/g of the modes of a pinned line, 1/m.
        volume: (n,) modal mass over density, m^3.
        height: (n,) of the modal mass above the vessel's bottom, m.
        surface_gain: (n,) rise of the contact line per displacement of the modal mass.
        quasi_static_gain: rise of the contact line at rest per lean of the apparent gravity, m.
    """

    curvature: np.ndarray
    tension: np.ndarray
    pinned: np.ndarray
    volume: np.ndarray
    height: np.ndarray
    surface_gain: np.ndarray
    quasi_static_gain: float


def curved_modes(meridian: Meridian, level: float, count: int, length: float, contact_angle: float) -> CurvedModes:
    """The first `count` modes; solved once for a vessel, a level, a length and an angle.

    Args:
        meridian: of the inside.
        level: height of the flat surface, m.
        count: of modes.
        length: capillary length, m.
        contact_angle: between wall and surface in the liquid, rad.

    Raises:
        ModelError: the region is too intricate, or too shallow for the meniscus.
    """
    return solve_curved(meridian, level, surface_elements(count), length, contact_angle)


@lru_cache(maxsize=512)
def solve_curved(meridian: Meridian, level: float, elements: int, length: float, contact_angle: float) -> CurvedModes:
    """The modes that so many elements along the surface's radius can carry: a quarter as many.

    Raises:
        ModelError: see `curved_modes`.
    """
    lean, radius = meridian.lean(level), meridian.radius(level)
    slope = slope_at_wall(lean, contact_angle)
    surface = rest_surface(length, radius, slope)
    mesh = _raise_surface(mesh_liquid(meridian, level, elements), meridian, level, surface)
    stiffness, turning = volume_terms(mesh, level)
    surface_nodes = np.unique(mesh.surface)
    mass, tension = surface_terms(mesh, surface_nodes)
    wall = int(np.argmax(mesh.nodes[surface_nodes, 0]))
    reach, step = float(mesh.nodes[surface_nodes[wall], 0]), _STEP * radius
    bend = (meridian.lean(level + step) - meridian.lean(level - step)) / (2 * step)
    curvature = surface.meniscus.rise / length**2 + math.sin(slope) / radius
    flare = math.cos(lean) * math.cos(slope) / math.cos(lean + slope)
    at_wall = reach * (curvature * math.tan(lean) + bend * math.cos(slope)) * flare
    tension[wall, wall] += math.pi * at_wall * reach**2
    solve = splu(stiffness, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve
    unit = np.zeros((len(mesh.nodes), len(surface_nodes)))
    unit[surface_nodes, np.arange(len(surface_nodes))] = 1.0
    flexibility, turned = solve(unit)[surface_nodes], solve(turning)[surface_nodes]
    kinetic = mass @ (flexibility + flexibility.T) / 2 @ mass
    spring = mass + length**2 * tension
    count = elements // 4
    try:
        inverse, shapes = eigh(kinetic, spring)
    except np.linalg.LinAlgError:
        raise ModelError("the surface at rest would not stay with this contact_angle; give another") from None
    shapes = shapes[:, ::-1][:, :count] / np.sqrt(inverse[::-1][:count])  # of unit kinetic energy
    held = np.delete(np.arange(len(surface_nodes)), wall)
    pinned = eigh(kinetic[np.ix_(held, held)], spring[np.ix_(held, held)], eigvals_only=True)
    push = mass.sum(axis=0)
    surge, turn = push @ shapes, (mass @ turned) @ shapes
    # The line rises by more than the surface next to it where the wall opens.
    rise = reach * math.cos(lean) * math.cos(slope) / math.cos(lean + slope)
    gravity = np.einsum("in,ij,jn->n", shapes, mass, shapes)
    return CurvedModes(
        curvature=read_only(gravity),
        tension=read_only(1.0 / inverse[::-1][:count] - gravity),
        pinned=read_only(1.0 / pinned[::-1][:count]),
        volume=read_only(surge**2),
        height=read_only(level + turn / surge),
        surface_gain=read_only(rise * shapes[wall] * surge),
        quasi_static_gain=rise * float(np.linalg.solve(spring, push)[wall]),
    )


def _raise_surface(mesh: MeridianMesh, meridian: Meridian, level: float, surface: RestSurface) -> MeridianMesh:
    """The mesh below the flat surface, moved up and down with the surface at rest, its outer nodes along the wall.

    Nodes crowd towards a steep wall, so that they are alike far apart along the surface.
    """
    rise, drop = surface.meniscus
    if rise == 0.0:
        return mesh
    points = meridian.points
    flat = points[:-1][(np.diff(points[:, 1]) < 1e-9) & (points[:-1, 1] < level)]
    ledge = max(meridian.bottom, float(np.max(flat[:, 1], initial=meridian.bottom)))
    depth = min(level - ledge, _REACH * meridian.radius(level))
    if max(abs(rise), abs(drop)) > _STEEPEST * depth:
        shown, deep = (format_quantity(value, "length", digits=3) for value in (max(abs(rise), abs(drop)), depth))
        raise ModelError(
            f"the meniscus is {shown} high and the liquid {deep} deep above its bottom or a ledge: at least 2.5 times "
            "the meniscus is needed; pour in more, or leave contact_angle out"
        )
    r, z = mesh.nodes.T
    share = np.clip((z - level + depth) / depth, 0.0, 1.0) ** 2
    width = np.interp(z, points[:, 1], points[:, 0])
    outer = np.unique(mesh.wall)
    width[outer] = np.where(share[outer] > 0.0, r[outer], width[outer])
    part = np.divide(r, width, out=np.zeros_like(r), where=width > 0.0)
    way = np.append(0.0, np.cumsum(np.hypot(np.diff(surface.radius), np.diff(surface.height))))
    crowded = np.interp(part * way[-1], way, surface.radius) / surface.radius[-1]
    part += share * (crowded - part)
    height = z + share * np.interp(part * surface.radius[-1], surface.radius, surface.height)
    at_wall = z + share * rise
    wide = np.interp(at_wall, points[:, 1], points[:, 0])
    wide[outer] = [meridian.radius(place) for place in at_wall[outer].tolist()]
    moved = share > 0.0
    nodes = np.column_stack([np.where(moved, part * wide, r), height])
    return MeridianMesh(read_only(nodes), mesh.triangles, mesh.surface, mesh.wall)
