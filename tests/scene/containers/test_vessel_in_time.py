"""Liquids of vessels pushed sideways, against the potential flow stepped in time by scikit-fem.

Nothing of the oracle is a mode: the potential at the surface and the height of the surface are integrated in time, the
potential inside follows from them and from the wall's velocity, and its rate is the pressure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import splu

from nospill.scene.containers.modes import STANDARD_GRAVITY
from nospill.scene.containers.vessel import Vessel
from nospill.scene.liquids import LIQUIDS
from tests.builders import VESSELS

pytestmark = pytest.mark.oracle

WATER = LIQUIDS["water"]
PUSH, STEPS, STEP = 0.5, 400, 2e-3


def surge(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration and velocity of the vessel: forth and back within `PUSH` s, m/s^2 and m/s."""
    rate, on = 2 * np.pi / PUSH, t < PUSH
    acceleration = np.where(on, np.sin(rate * t) * (1 - np.cos(rate * t)), 0.0)
    velocity = np.where(on, ((1 - np.cos(rate * t)) / rate - np.sin(rate * t) ** 2 / (2 * rate)), 0.0)
    return acceleration, velocity


@dataclass(frozen=True)
class Answer:
    """Force on the vessel (N) and its moment about the bottom's centre (N m), height at the wall (m), over time."""

    force: np.ndarray
    moment: np.ndarray
    height: np.ndarray


def stepped(vessel: Vessel, level: float) -> Answer:
    skfem = pytest.importorskip("skfem")
    bottom = float(vessel.meridian.points[0, 1])
    across, up = np.linspace(0.0, 1.0, 17), 1.0 - (1.0 - np.linspace(0.0, 1.0, 33)) ** 2
    square = skfem.MeshTri.init_tensor(across, up)
    height = bottom + (level - bottom) * square.p[1]
    # a pointed or round bottom begins with a small disc
    radius = np.array([vessel.meridian.radius(max(z, bottom + 1e-3 * (level - bottom))) for z in height])
    mesh = skfem.MeshTri(np.stack([square.p[0] * radius, height]), square.t)
    basis = skfem.Basis(mesh, skfem.ElementTriP2(), intorder=6)
    on_surface = mesh.facets_satisfying(lambda x: np.isclose(x[1], level), boundaries_only=True)
    on_axis = mesh.facets_satisfying(lambda x: np.isclose(x[0], 0.0), boundaries_only=True)
    wall_facets = np.setdiff1d(mesh.boundary_facets(), np.union1d(on_surface, on_axis))
    surface = skfem.FacetBasis(mesh, skfem.ElementTriP2(), facets=on_surface, intorder=6)
    wall = skfem.FacetBasis(mesh, skfem.ElementTriP2(), facets=wall_facets, intorder=6)

    @skfem.BilinearForm
    def energy(p, q, w):
        r = w.x[0]
        return np.pi * (r * (p.grad[0] * q.grad[0] + p.grad[1] * q.grad[1]) + p * q / r)

    @skfem.BilinearForm
    def mass(p, q, w):
        return np.pi * w.x[0] * p * q

    @skfem.LinearForm
    def sideways(q, w):
        return np.pi * w.x[0] * w.n[0] * q

    @skfem.LinearForm
    def turning(q, w):
        return np.pi * w.x[0] * (w.x[1] * w.n[0] - w.x[0] * w.n[1]) * q

    free = basis.complement_dofs(basis.get_dofs(lambda x: np.isclose(x[0], 0.0)))
    places = basis.doflocs[:, free]
    above = np.flatnonzero(np.isclose(places[1], level))
    inside = np.setdiff1d(np.arange(len(free)), above)
    stiffness = energy.assemble(basis)[free][:, free].tocsc()
    surface_mass = mass.assemble(surface)[free][:, free][above][:, above].toarray()
    push, turn = (form.assemble(wall)[free] for form in (sideways, turning))
    inner = splu(stiffness[inside][:, inside].tocsc())
    coupling = stiffness[inside][:, above].toarray()
    lift = inner.solve(coupling)
    flux = stiffness[above][:, above].toarray() - coupling.T @ lift
    given = push[above] - lift.T @ push[inside]
    pushed = inner.solve(push[inside])

    # S eta' = flux phi - given U and phi' = -g eta, by the implicit midpoint rule in eta
    half = STEP / 2
    system = lu_factor(surface_mass + half**2 * STANDARD_GRAVITY * flux)
    t = STEP * np.arange(STEPS + 1)
    acceleration, _ = surge(t)
    _, middle = surge(t[:-1] + half)
    phi, eta = np.zeros(len(above)), np.zeros(len(above))
    edge = int(np.argmax(places[0, above]))
    rows = []
    for step in range(STEPS + 1):
        rate = np.zeros(len(free))
        rate[above] = -STANDARD_GRAVITY * eta
        rate[inside] = pushed * acceleration[step] - lift @ rate[above]
        rows.append((-WATER.density * push @ rate, -WATER.density * turn @ rate, eta[edge]))
        if step < STEPS:
            load = flux @ (phi - half * STANDARD_GRAVITY * eta) - given * middle[step]
            mean = lu_solve(system, surface_mass @ eta + half * load + half**2 * STANDARD_GRAVITY * (flux @ eta))
            phi, eta = phi - STEP * STANDARD_GRAVITY * mean, 2 * mean - eta
    return Answer(*np.array(rows).T)


def modal(vessel: Vessel, level: float) -> Answer:
    """The record's answer, with three modes as the optimiser carries them at most."""
    modes = vessel.slosh_modes(WATER, level, 3, damping=0.0)
    fine = 4
    t = STEP / fine * np.arange(STEPS * fine + 1)
    acceleration, _ = surge(t)
    force = -modes.fixed_mass * acceleration
    moment = -modes.fixed_mass * modes.fixed_height * acceleration
    height = -modes.static_correction[0] * acceleration / STANDARD_GRAVITY
    for mode in modes.oscillators:
        # exact for an acceleration that is linear in each step
        q = np.zeros((len(t), 2))
        angle, step = mode.frequency * STEP / fine, STEP / fine
        cosine, sine = np.cos(angle), np.sin(angle)
        for index in range(len(t) - 1):
            a, slope = -acceleration[index], -(acceleration[index + 1] - acceleration[index]) / step
            still, drift = a / mode.frequency**2, slope / mode.frequency**2
            x, v = q[index, 0] - still, (q[index, 1] - drift) / mode.frequency
            q[index + 1] = (
                still + drift * step + cosine * x + sine * v,
                drift + mode.frequency * (cosine * v - sine * x),
            )
        swing = -(mode.frequency**2) * q[:, 0]  # the acceleration in space
        force -= mode.mass * swing
        moment += mode.mass * (STANDARD_GRAVITY * q[:, 0] - mode.height * swing)
        height += mode.surface_gain * q[:, 0]
    return Answer(force[::fine], moment[::fine], height[::fine])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "level"), [("tapered", 0.08), ("bowl", 0.04), ("wine-glass", 0.15), ("conical-flask", 0.06)]
)
def test_force_moment_and_height_of_a_push(shape: str, level: float) -> None:
    found, exact = modal(VESSELS[shape], level), stepped(VESSELS[shape], level)
    for name in ("force", "moment", "height"):
        ours, theirs = getattr(found, name), getattr(exact, name)
        apart = float(np.max(np.abs(ours - theirs)) / np.max(np.abs(theirs)))
        assert apart < 0.02, (shape, name)
