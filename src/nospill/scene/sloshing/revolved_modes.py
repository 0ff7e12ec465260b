"""Modes of the liquid in a body of revolution by finite elements in the meridian plane.

Only potentials phi = x u(r, z) are excited by a small motion of the vessel, x = r cos(theta). For them

    a(u, v) = integral of grad(x u).grad(x v) = pi * integral of [(r u)_r (r v)_r + u v + r^2 u_z v_z] r dr dz
    s(u, v) = integral of x^2 u v over the surface = pi * integral of u v r^3 dr

and a free mode has a(u, v) = kappa s(u, v) for every v, with omega^2 = g kappa. The function u is smooth on the axis
and one for a surge, so that the sums over the modes are exact for the elements too. The derivation and that of the
masses stands in docs/physics/vessels.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.sparse as sp
from scipy.linalg import eigh
from scipy.sparse.linalg import splu

from nospill.core.arrays import read_only
from nospill.errors import ModelError
from nospill.scene.meridian import Meridian
from nospill.scene.sloshing.meridian_mesh import MeridianMesh, mesh_liquid

_FEW, _MANY = 40, 80
"""Elements along the surface's radius: for the first modes, and for many."""
_MOST_OF_FEW = 4

_CORNER = 0.470142064105115
_SIDE = 0.101286507323456
_QUADRATURE = np.array(
    [(1 / 3, 1 / 3), *((a, b) for k in (_CORNER, _SIDE) for a, b in ((k, k), (k, 1 - 2 * k), (1 - 2 * k, k)))]
)
_AREA_WEIGHTS = 0.5 * np.array([0.225] + 3 * [0.132394152788506] + 3 * [0.125939180544827])
"""Of degree five on a triangle [Radon 1948]; with straight sides all integrals here are exact."""
_EDGE_NODES, _EDGE_WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True, slots=True)
class RevolvedModes:
    """What a vessel and a level determine alone, of a liquid of density one; n modes by frequency.

    Attributes:
        curvature: (n,) kappa = omega^2/g, 1/m.
        volume: (n,) modal mass over density, m^3.
        height: (n,) of the modal mass above the vessel's bottom, m.
        surface_gain: (n,) height at the wall per displacement of the modal mass.
        crest_gain: (n,) size of the greatest height anywhere on the surface per displacement: inside where the wall
            closes above the level [Kulczycki 2014], else at the wall.
        layer_ratio: (n,) integral of |grad phi|^2 over the wetted wall over that in the volume, 1/m.
        wave_number: (n,) square root of the integral of |grad_xy phi|^2 over that of phi^2 on the surface, 1/m.
        inertia: of the liquid closed off at its surface about a line across the middle of the surface, over density,
            m^5.
    """

    curvature: np.ndarray
    volume: np.ndarray
    height: np.ndarray
    surface_gain: np.ndarray
    crest_gain: np.ndarray
    layer_ratio: np.ndarray
    wave_number: np.ndarray
    inertia: float


def revolved_modes(meridian: Meridian, level: float, count: int) -> RevolvedModes:
    """The first `count` modes of the liquid up to a level, m; solved once for a vessel and a level.

    Raises:
        ModelError: the region is too intricate, or too many modes are asked for.
    """
    return solve_modes(meridian, level, surface_elements(count))


def surface_elements(count: int) -> int:
    """Elements along the surface's radius for so many modes."""
    return _FEW if count <= _MOST_OF_FEW else max(_MANY, 4 * count)


@lru_cache(maxsize=512)
def solve_modes(
    meridian: Meridian, level: float, surface_elements: int, refinement: float = 1.0, modes: int | None = None
) -> RevolvedModes:
    """The modes that so many elements along the surface's radius can carry: a quarter as many, or `modes`.

    Steklov's problem is reduced to the surface: with G the surface's part of the inverse of a, G s has the eigenvalues
    1/kappa. Zhukovsky's potential W of a turn about y solves a(W, v) = integral of z (x v)_x - x (x v)_z.

    Raises:
        ModelError: the region is too intricate.
    """
    mesh = mesh_liquid(meridian, level, surface_elements, refinement=refinement)
    stiffness, turning = volume_terms(mesh, level)
    surface_nodes = np.unique(mesh.surface)
    surface_mass, surface_stiffness = surface_terms(mesh, surface_nodes)
    solve = splu(stiffness, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve
    unit = np.zeros((len(mesh.nodes), len(surface_nodes)))
    unit[surface_nodes, np.arange(len(surface_nodes))] = 1.0
    influence, turned = solve(unit), solve(turning)
    # G in the basis where s is one: symmetric, so that the modes come out normal.
    factor = np.linalg.cholesky(surface_mass)
    flexibility = influence[surface_nodes]
    inverse, vectors = eigh(factor.T @ (flexibility + flexibility.T) / 2 @ factor)
    count = surface_elements // 4 if modes is None else modes
    kappa = 1.0 / inverse[::-1][:count]
    shapes = np.linalg.solve(factor.T, vectors[:, ::-1][:, :count])
    surge = shapes.T @ surface_mass @ np.ones(len(surface_nodes))
    lean = shapes.T @ surface_mass @ turned[surface_nodes]
    wall = int(np.argmax(mesh.nodes[surface_nodes, 0]))
    risen = mesh.nodes[surface_nodes, :1] * shapes * kappa * surge
    whole = influence @ (surface_mass @ shapes) * kappa
    return RevolvedModes(
        curvature=read_only(kappa),
        volume=read_only(kappa * surge**2),
        height=read_only(level + lean / surge),
        surface_gain=read_only(risen[wall]),
        crest_gain=read_only(np.max(np.abs(risen), axis=0)),
        layer_ratio=read_only(_wall_dissipation(mesh, whole) / kappa),
        wave_number=read_only(np.sqrt(np.einsum("in,ij,jn->n", shapes, surface_stiffness, shapes))),
        inertia=float(turning @ turned),
    )


def _shape(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quadratic shape functions (q, 6) and derivatives (q, 6, 2) at points of the unit triangle."""
    x, y = points.T
    z = 1 - x - y
    one = np.ones_like(x)
    value = np.stack([z * (2 * z - 1), x * (2 * x - 1), y * (2 * y - 1), 4 * x * z, 4 * x * y, 4 * y * z], axis=1)
    by_x = np.stack([1 - 4 * z, 4 * x - 1, 0 * one, 4 * (z - x), 4 * y, -4 * y], axis=1)
    by_y = np.stack([1 - 4 * z, 0 * one, 4 * y - 1, -4 * x, 4 * x, 4 * (z - y)], axis=1)
    return value, np.stack([by_x, by_y], axis=2)


def volume_terms(mesh: MeridianMesh, level: float) -> tuple[sp.csc_array, np.ndarray]:
    """The matrix of a and the right side of Zhukovsky's problem, z from the level.

    Raises:
        ModelError: an element is turned inside out.
    """
    value, derivative = _shape(_QUADRATURE)
    corners = mesh.nodes[mesh.triangles]
    place = np.einsum("qi,tix->tqx", value, corners)
    jacobian = np.einsum("qiy,tix->tqxy", derivative, corners)
    area = jacobian[..., 0, 0] * jacobian[..., 1, 1] - jacobian[..., 0, 1] * jacobian[..., 1, 0]
    if not np.all(area > 0.0):
        raise ModelError(
            "the liquid's shape is too intricate for the slosh model; give another fill, a plainer profile or no "
            "contact_angle"
        )
    inverse = np.linalg.inv(jacobian)
    slope = np.einsum("qiy,tqyx->tqix", derivative, inverse)
    r, z = place[..., 0], place[..., 1] - level
    weight = np.pi * r * area * _AREA_WEIGHTS
    radial = value + r[..., None] * slope[..., 0]
    upward = r[..., None] * slope[..., 1]
    root = np.sqrt(weight)[..., None]
    rows = np.concatenate([root * radial, root * value, root * upward], axis=1)
    element = np.einsum("tqi,tqj->tij", rows, rows)
    turning = np.einsum("tq,tqi->ti", weight, z[..., None] * (radial + value) - r[..., None] * upward)
    index = mesh.triangles
    size = len(mesh.nodes)
    matrix = sp.coo_array(
        (element.ravel(), (np.repeat(index, 6, axis=1).ravel(), np.tile(index, (1, 6)).ravel())), shape=(size, size)
    )
    return sp.csc_array(matrix), np.bincount(index.ravel(), turning.ravel(), size)


@dataclass(frozen=True, slots=True)
class Edges:
    """What is integrated along e quadratic edges at q Gauss points.

    Attributes:
        value: (q, 3) shape functions.
        slope: (e, q, 3) derivatives of r times them by the length.
        radius: (e, q) m.
        weight: (e, q) that sum to the length, m.
        upright: (e, q) dr over the length: the cosine of the edge's slope.
    """

    value: np.ndarray
    slope: np.ndarray
    radius: np.ndarray
    weight: np.ndarray
    upright: np.ndarray


def _along(mesh: MeridianMesh, edges: np.ndarray) -> Edges:
    t = _EDGE_NODES
    value = np.stack([t * (t - 1) / 2, t * (t + 1) / 2, 1 - t * t], axis=1)
    derivative = np.stack([t - 0.5, t + 0.5, -2 * t], axis=1)
    points = mesh.nodes[edges]
    radius = np.einsum("qi,ei->eq", value, points[..., 0])
    tangent = np.einsum("qi,eix->eqx", derivative, points)
    length = np.linalg.norm(tangent, axis=-1)
    slope = (value * tangent[..., :1] + radius[..., None] * derivative) / length[..., None]
    return Edges(value, slope, radius, length * _EDGE_WEIGHTS, tangent[..., 0] / length)


def surface_terms(mesh: MeridianMesh, surface_nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Over the surface z = f(r), in its own nodes: s, and what surface tension holds it with.

    With W^2 = 1 + f'^2, pi times the integrals of r^2 u v and of (r u)'(r v)'/W^3 + u v/W, both r dr; the latter is the
    integral of grad_xy(x u).grad_xy(x v) where the surface is flat.
    """
    edges = _along(mesh, mesh.surface)
    weight = np.pi * edges.radius * edges.weight * edges.upright
    mass = np.einsum("eq,qi,qj->eij", weight * edges.radius**2, edges.value, edges.value)
    weight = weight * edges.upright
    held = np.einsum("eq,eqi,eqj->eij", weight, edges.slope, edges.slope)
    held += np.einsum("eq,qi,qj->eij", weight, edges.value, edges.value)
    place = np.searchsorted(surface_nodes, mesh.surface)
    matrices = np.zeros((2, len(surface_nodes), len(surface_nodes)))
    for matrix, element in zip(matrices, (mass, held), strict=True):
        np.add.at(matrix, (place[:, :, None], place[:, None, :]), element)
    return matrices[0], matrices[1]


def _wall_dissipation(mesh: MeridianMesh, potentials: np.ndarray) -> np.ndarray:
    """Integral of the squared velocity along the wetted wall for every mode, (n,)."""
    edges = _along(mesh, mesh.wall)
    own = potentials[mesh.wall]
    along = np.einsum("eqi,ein->eqn", edges.slope, own)
    around = np.einsum("qi,ein->eqn", edges.value, own)
    return np.einsum("eq,eqn->n", np.pi * edges.radius * edges.weight, along**2 + around**2)
