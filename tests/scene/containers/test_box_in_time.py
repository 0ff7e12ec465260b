"""Liquids of boxes turned about the vertical, against the potential flow stepped in time by scikit-fem in 3-D.

Nothing of the oracle is a mode. The potential is odd in x and in y, so that a quarter of the box is meshed, with the
potential zero on both planes of symmetry.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import splu

from nospill.core.frames import SX, body_motion
from nospill.core.trees import constants
from nospill.laws.contact import contact_wrench
from nospill.laws.sample import object_states
from nospill.laws.scene_parameters import object_numbers, object_structure
from nospill.laws.slosh.motion import modal_accelerations
from nospill.scene.cargo import Cargo
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.scene.turning import turning
from nospill.simulation.cup_file import cup_from_table
from nospill.simulation.simulate import SloshSimulation, simulate_slosh

pytestmark = pytest.mark.oracle

WATER = LIQUIDS["water"]
LEVEL, TURN, ANGLE, STEP, STEPS = 0.04, 0.5, 0.3, 2e-3, 500
BOXES = [(0.24, 0.20), (0.20, 0.20)]


def forth(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Yaw (rad), its rate and acceleration: a turn with continuous acceleration that ends after `TURN` s."""
    u, rate = 2 * np.pi * np.clip(t / TURN, 0.0, 1.0), 2 * np.pi / TURN
    angle = ANGLE / (2 * np.pi) * (u - np.sin(u))
    return angle, ANGLE / (2 * np.pi) * rate * (1 - np.cos(u)), ANGLE / (2 * np.pi) * rate**2 * np.sin(u)


@dataclass(frozen=True)
class Answer:
    """Moment on the liquid about the vertical (N m), height in the corner and greatest height along the wall (m)."""

    moment: np.ndarray
    corner: np.ndarray
    crest: np.ndarray


@cache
def stepped(length: float, width: float) -> Answer:
    skfem = pytest.importorskip("skfem")
    # finer towards the walls, where the flow turns the corner, and towards the surface
    part = np.sin(np.linspace(0.0, np.pi / 2, 9))
    mesh = skfem.MeshHex.init_tensor(part * length / 2, part * width / 2, LEVEL * np.linspace(0.0, 1.0, 6))
    element = skfem.ElementHex2()
    basis = skfem.Basis(mesh, element)

    def facets(where):
        return skfem.FacetBasis(mesh, element, facets=mesh.facets_satisfying(where, boundaries_only=True))

    surface = facets(lambda x: np.isclose(x[2], LEVEL))
    walls = facets(lambda x: np.isclose(x[0], length / 2) | np.isclose(x[1], width / 2))

    @skfem.BilinearForm
    def energy(p, q, w):
        return p.grad[0] * q.grad[0] + p.grad[1] * q.grad[1] + p.grad[2] * q.grad[2]

    @skfem.BilinearForm
    def mass(p, q, w):
        return p * q

    @skfem.LinearForm
    def swept(q, w):
        return (w.x[0] * w.n[1] - w.x[1] * w.n[0]) * q

    fixed = basis.get_dofs(lambda x: np.isclose(x[0], 0.0) | np.isclose(x[1], 0.0))
    free = basis.complement_dofs(fixed)
    places = basis.doflocs[:, free]
    above = np.flatnonzero(np.isclose(places[2], LEVEL))
    inside = np.setdiff1d(np.arange(len(free)), above)
    stiffness = energy.assemble(basis)[free][:, free].tocsc()
    surface_mass = mass.assemble(surface)[free][:, free][above][:, above].toarray()
    push = swept.assemble(walls)[free]
    inner = splu(stiffness[inside][:, inside].tocsc())
    coupling = stiffness[inside][:, above].toarray()
    lift = inner.solve(coupling)
    flux = stiffness[above][:, above].toarray() - coupling.T @ lift
    given, pushed = push[above] - lift.T @ push[inside], inner.solve(push[inside])
    half = STEP / 2
    system = lu_factor(surface_mass + half**2 * STANDARD_GRAVITY * flux)
    t = STEP * np.arange(STEPS + 1)
    (_, _, acceleration), (_, middle, _) = forth(t), forth(t[:-1] + half)
    at_wall = np.isclose(places[0, above], length / 2) | np.isclose(places[1, above], width / 2)
    corner = int(np.argmax(places[0, above] / length + places[1, above] / width))
    phi, eta = np.zeros((2, len(above)))
    rows = []
    for step in range(STEPS + 1):
        rate = np.zeros(len(free))
        rate[above] = -STANDARD_GRAVITY * eta
        rate[inside] = pushed * acceleration[step] - lift @ rate[above]
        rows.append((4 * WATER.density * push @ rate, eta[corner], np.max(np.abs(eta[at_wall]))))
        if step < STEPS:
            load = flux @ (phi - half * STANDARD_GRAVITY * eta) - given * middle[step]
            mean = lu_solve(system, surface_mass @ eta + half * load + half**2 * STANDARD_GRAVITY * (flux @ eta))
            phi, eta = phi - STEP * STANDARD_GRAVITY * mean, 2 * mean - eta
    return Answer(*np.array(rows).T)


def box(length: float, width: float, modes: int) -> Cargo:
    """A box of no mass, so that its wrench is the liquid's."""
    table = {"shape": "box", "length": length, "width": width, "height": 0.2, "liquid": "water", "damping": 0.0}
    table |= {"liquid_height": LEVEL, "empty_mass": 1e-9}
    return turning(cup_from_table(table, slosh_modes=modes))


def turned(cargo: Cargo) -> SloshSimulation:
    t = STEP * np.arange(STEPS + 1)
    angle = forth(t)[0]
    quaternion = np.column_stack([0 * t, 0 * t, np.sin(angle / 2), np.cos(angle / 2)])
    count = cargo.filling.modes.count if cargo.filling else 1
    return simulate_slosh(cargo, t, np.zeros((len(t), 3)), quaternion, modes=count, height="corrected")


def felt(cargo: Cargo, found: SloshSimulation) -> np.ndarray:
    """Moment (m,) about the vertical that the tray exerts on the box, N m, of the law of its contact."""
    structure = object_structure(cargo)
    numbers = constants(object_numbers(cargo, fidelity="full", gravity=STANDARD_GRAVITY))
    count = structure.coordinates
    body, q, qd = SX.sym("b", 9), SX.sym("q", count), SX.sym("qd", count)
    motion = body_motion(body)
    qdd = modal_accelerations(structure, numbers, motion, q, qd, damp_against_spin=False)
    wrench = contact_wrench("full", numbers, structure, motion, object_states(structure, q, qd, qdd))
    law = ca.Function("moment", [body, q, qd], [wrench.moment[2]])
    _, rate, acceleration = forth(found.t)
    rows = np.zeros((9, len(found.t)))
    rows[2], rows[5], rows[8] = rate, acceleration, STANDARD_GRAVITY
    return law(rows, found.displacement.T, found.velocity.T).full()[0]


@pytest.mark.parametrize("sides", BOXES)
def test_heights_and_moment_of_a_turned_box_are_those_of_the_potential_flow(sides: tuple[float, float]) -> None:
    """Squares too, whose corners stay level; ten modes of a side are within the error of these elements."""
    truth, cargo = stepped(*sides), box(*sides, 10)
    found, size = turned(cargo), float(np.max(truth.crest))
    assert size > 1.5e-3
    after = found.t > TURN
    for part in (after, ~after):
        assert np.max(found.height[part]) == pytest.approx(np.max(truth.crest[part]), rel=0.03)
    corner = found.displacement[:, -19:].sum(axis=1)
    np.testing.assert_allclose(corner, truth.corner, atol=0.03 * size)
    moment = felt(cargo, found)
    assert np.max(np.abs(truth.moment)) > 1e-2
    np.testing.assert_allclose(moment, truth.moment, atol=0.03 * np.max(np.abs(truth.moment)))


def test_liquid_in_a_box_resists_a_turn_less_than_a_frozen_one() -> None:
    cargo = box(0.24, 0.20, 10)
    frozen = cargo.total.inertia[2, 2] - cargo.empty.inertia[2, 2]
    moment, acceleration = felt(cargo, turned(cargo)), forth(STEP * np.arange(STEPS + 1))[2]
    assert 0.05 * frozen < np.max(np.abs(moment)) / np.max(acceleration) < 0.4 * frozen
