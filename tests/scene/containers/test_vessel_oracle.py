"""Modes of a tapered cup and a bowl against scikit-fem: another mesh, another unknown, another eigenvalue problem."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.linalg import eigsh

from nospill.scene.sloshing.revolved_modes import solve_modes
from tests.builders import VESSELS

pytestmark = pytest.mark.oracle


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "level"), [("tapered", 0.08), ("bowl", 0.04)])
def test_frequencies_and_masses(shape: str, level: float) -> None:
    skfem = pytest.importorskip("skfem")
    vessel = VESSELS[shape]
    across, up = np.linspace(0.0, 1.0, 33), 1.0 - (1.0 - np.linspace(0.0, 1.0, 81)) ** 2
    square = skfem.MeshTri.init_tensor(across, up)
    radius = np.array([vessel.meridian.radius(level * t) if t > 0.0 else vessel.footprint.radius for t in square.p[1]])
    # Straight sides, so many that the wall's curvature is met to 4e-5.
    mesh = skfem.MeshTri(np.stack([square.p[0] * radius, level * square.p[1]]), square.t)
    basis = skfem.Basis(mesh, skfem.ElementTriP2(), intorder=6)
    on_surface = mesh.facets_satisfying(lambda x: np.isclose(x[1], level), boundaries_only=True)
    surface = skfem.FacetBasis(mesh, skfem.ElementTriP2(), facets=on_surface, intorder=6)

    # The potential itself, Phi cos(theta), where ours is r u cos(theta).
    @skfem.BilinearForm
    def energy(p, q, w):
        r = w.x[0]
        return np.pi * (r * (p.grad[0] * q.grad[0] + p.grad[1] * q.grad[1]) + p * q / r)

    @skfem.BilinearForm
    def height(p, q, w):
        return np.pi * w.x[0] * p * q

    free = basis.complement_dofs(basis.get_dofs(lambda x: np.isclose(x[0], 0.0)))
    stiffness, mass = (form.assemble(own)[free][:, free] for form, own in ((energy, basis), (height, surface)))
    inverse, potentials = eigsh(mass.tocsc(), k=3, M=stiffness.tocsc(), which="LM")
    order = np.argsort(-inverse)
    kappa = 1.0 / inverse[order]
    surge = basis.doflocs[0, free] @ mass @ potentials[:, order]
    normal = np.einsum("in,in->n", potentials[:, order], mass @ potentials[:, order])
    found = solve_modes(vessel.meridian, level, 40)
    np.testing.assert_allclose(found.curvature[:3], kappa, rtol=6e-4)
    np.testing.assert_allclose(found.curvature[0], kappa[0], rtol=1e-4)
    np.testing.assert_allclose(found.volume[0], kappa[0] * surge[0] ** 2 / normal[0], rtol=2e-4)
