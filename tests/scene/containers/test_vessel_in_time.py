"""Liquids of vessels pushed sideways and turned, against the potential flow stepped in time by scikit-fem.

Nothing of the oracle is a mode: the potential at the surface and the height of the surface are integrated in time, the
potential inside follows from them and from the wall's velocity, and its rate is the pressure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import splu

from nospill.scene.containers.vessel import Vessel
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.builders import VESSELS

pytestmark = pytest.mark.oracle

WATER = LIQUIDS["water"]
PUSH, STEPS, STEP = 0.5, 400, 2e-3


def forth_and_back(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Second and first derivative and value of a push that ends within `PUSH` s; m or rad, away from where it began."""
    rate, on = 2 * np.pi / PUSH, t < PUSH
    second = np.where(on, np.sin(rate * t) * (1 - np.cos(rate * t)), 0.0)
    first = np.where(on, ((1 - np.cos(rate * t)) / rate - np.sin(rate * t) ** 2 / (2 * rate)), 0.0)
    t = np.minimum(t, PUSH)
    return second, first, (0.75 * t - np.sin(rate * t) / rate + np.sin(2 * rate * t) / (8 * rate)) / rate


@dataclass(frozen=True)
class Answer:
    """Force on the vessel (N) and its moment about the bottom's centre (N m), height at the wall (m), over time.

    In the vessel's frame; (steps, 2), of a push sideways and of a turn about the bottom's centre.
    """

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
    driving = np.stack([push, turn], axis=1)
    given = driving[above] - lift.T @ driving[inside]
    pushed = inner.solve(driving[inside])

    # S eta' = flux phi - given U and phi' = -g eta, by the implicit midpoint rule in eta, which counts from the level
    # plane; both motions at once
    half = STEP / 2
    system = lu_factor(surface_mass + half**2 * STANDARD_GRAVITY * flux)
    t = STEP * np.arange(STEPS + 1)
    acceleration, _, place = forth_and_back(t)
    _, middle, _ = forth_and_back(t[:-1] + half)
    phi, eta = np.zeros((2, len(above), 2))
    edge = int(np.argmax(places[0, above]))
    radius = places[0, above[edge]]
    weight = WATER.density * STANDARD_GRAVITY
    volume, centre, _ = vessel.meridian.body(level)
    # A turn leaves the weight aslant, and lifts it; the surface at the wall counts from the vessel's own level.
    aslant = np.array((weight * volume, weight * (volume * centre + np.pi * radius**4 / 4), radius))[:, None] * (0, 1)
    rows = []
    for step in range(STEPS + 1):
        rate = np.zeros((len(free), 2))
        rate[above] = -STANDARD_GRAVITY * eta
        rate[inside] = pushed * acceleration[step] - lift @ rate[above]
        loads = np.stack([-WATER.density * push @ rate, -WATER.density * turn @ rate, eta[edge]])
        rows.append(loads + aslant * place[step])
        if step < STEPS:
            load = flux @ (phi - half * STANDARD_GRAVITY * eta) - given * middle[step]
            mean = lu_solve(system, surface_mass @ eta + half * load + half**2 * STANDARD_GRAVITY * (flux @ eta))
            phi, eta = phi - STEP * STANDARD_GRAVITY * mean, 2 * mean - eta
    return Answer(*np.array(rows).swapaxes(0, 1))


def modal(vessel: Vessel, level: float) -> Answer:
    """The record's answer, with three modes as the optimiser carries them at most."""
    modes = vessel.slosh_modes(WATER, level, 3, damping=0.0)
    fine = 4
    t = STEP / fine * np.arange(STEPS * fine + 1)
    second, _, angle = forth_and_back(t)
    sideways = np.stack([second, -STANDARD_GRAVITY * angle], axis=1)
    turning = np.stack([0 * second, second], axis=1)

    def felt(height: float) -> np.ndarray:
        return sideways + height * turning

    force = -modes.fixed_mass * felt(modes.fixed_height)
    moment = modes.fixed_height * force - modes.fixed_inertia[1] * turning
    height = -modes.static_correction[0] * felt(level) / STANDARD_GRAVITY
    for mode in modes.oscillators:
        # exact for an acceleration that is linear in each step
        push, q, v = -felt(mode.height), np.zeros((len(t), 2)), np.zeros(2)
        phase, step = mode.frequency * STEP / fine, STEP / fine
        cosine, sine = np.cos(phase), np.sin(phase)
        for index in range(len(t) - 1):
            still = push[index] / mode.frequency**2
            drift = (push[index + 1] - push[index]) / step / mode.frequency**2
            x, y = q[index] - still, (v - drift) / mode.frequency
            q[index + 1] = still + drift * step + cosine * x + sine * y
            v = drift + mode.frequency * (cosine * y - sine * x)
        pull = mode.mass * mode.frequency**2 * q  # of the spring
        force += pull
        moment += mode.height * pull + mode.mass * STANDARD_GRAVITY * q
        height += mode.surface_gain * q
    return Answer(force[::fine], moment[::fine], height[::fine])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "level"), [("tapered", 0.08), ("bowl", 0.04), ("wine-glass", 0.15), ("conical-flask", 0.06)]
)
def test_force_moment_and_height_of_a_push_and_a_turn(shape: str, level: float) -> None:
    found, exact = modal(VESSELS[shape], level), stepped(VESSELS[shape], level)
    for name in ("force", "moment", "height"):
        ours, theirs = getattr(found, name), getattr(exact, name)
        apart = np.max(np.abs(ours - theirs), axis=0) / np.max(np.abs(theirs), axis=0)
        assert np.all(apart < 0.02), (shape, name, apart)
