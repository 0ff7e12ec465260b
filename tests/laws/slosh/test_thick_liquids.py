"""Overdamped modes: their free motion, its bound, and how long they take to level."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

from nospill.laws.slosh.residual import free_states, residual_bound
from nospill.plans.settling import _decay
from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.vessels import Tapered
from nospill.scene.liquids import LIQUIDS, Liquid
from nospill.scene.sloshing.modes import STANDARD_GRAVITY

OMEGA = 22.6


@pytest.mark.parametrize("ratio", [0.0, 0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.3, 8.0, 100.0])
def test_the_free_motion_solves_its_equation(ratio: float) -> None:
    t = np.linspace(0.0, 1.5, 60)
    start = [2e-3, -0.3]
    rates = np.array([[0.0, 1.0], [-(OMEGA**2), -2.0 * ratio * OMEGA]])
    exact = np.array([expm(rates * now) @ start for now in t]).T
    q, qd = free_states(np.array([OMEGA]), np.array([ratio]), np.array(start[:1]), np.array(start[1:]), t)
    assert q[:, 0] == pytest.approx(exact[0], abs=1e-8)
    assert qd[:, 0] == pytest.approx(exact[1], abs=1e-7)
    late, _ = free_states(np.array([OMEGA]), np.array([ratio]), np.array(start[:1]), np.array(start[1:]), t + 1e4)
    assert np.all(np.isfinite(late)) and (ratio == 0.0 or np.max(np.abs(late)) < 1e-6)


@pytest.mark.parametrize("ratio", [1.0, 1.5, 10.0])
def test_the_bound_holds_for_ever(ratio: float) -> None:
    random = np.random.default_rng(3)
    t = np.linspace(0.0, 4.0, 4000)
    for _ in range(40):
        q, qd = random.uniform(-1, 1, 2) * 5e-3, random.uniform(-1, 1, 2) * 5e-3 * OMEGA
        bound = float(
            ca.evalf(residual_bound(ca.SX(ca.DM(q)), ca.SX(ca.DM(qd)), frequency=OMEGA, damping=ratio, smoothing=1e-9))
        )
        later, _ = free_states(np.full(2, OMEGA), np.full(2, ratio), q, qd, t)
        assert np.max(np.linalg.norm(later, axis=1)) <= bound * (1 + 1e-9)


def test_a_mode_levels_at_its_slower_rate() -> None:
    for ratio in (0.3, 1.0, 2.0, 20.0):
        roots = np.roots([1.0, 2 * ratio, 1.0])
        assert _decay(ratio) == pytest.approx(np.min(-roots.real), rel=1e-6)


@pytest.mark.parametrize(
    "container",
    [Cylinder(0.035, 0.1), Box(0.07, 0.06, 0.1), Tapered(bottom_radius=0.03, top_radius=0.04, height=0.1)],
    ids=["cylinder", "box", "tapered"],
)
def test_a_thick_liquid_creeps_and_a_thin_one_is_as_before(container: Cylinder | Box | Tapered) -> None:
    """Deep and thick, a wave falls as exp(-g t/(2 nu k)) [Lamb, Hydrodynamics, sec. 349]."""
    thick = Liquid("tar", 1400.0, 0.2, 0.05)
    (mode, *_) = container.slosh_modes(thick, 0.09, 1).oscillators
    levelling = _decay(mode.damping) * mode.frequency
    k = mode.wave_number**2 / mode.stiffness  # the same as the wave number where the wall is upright
    assert levelling == pytest.approx(STANDARD_GRAVITY / (2 * thick.kinematic_viscosity * k), rel=0.02)
    for name in ("water", "light-oil", "olive-oil"):
        twice = Liquid("x", LIQUIDS[name].density, 4 * LIQUIDS[name].kinematic_viscosity, 0.05)
        thin, more = (container.slosh_modes(item, 0.09, 1).oscillators[0].damping for item in (LIQUIDS[name], twice))
        assert more / thin == pytest.approx(2.0, rel=1e-9)  # the formula's square root
    honey = container.slosh_modes(LIQUIDS["honey"], 0.09, 2).oscillators
    assert all(0.5 < mode.damping < 2.0 for mode in honey)
