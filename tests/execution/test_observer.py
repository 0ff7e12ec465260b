"""Liquids observed: what is not known of them by closed forms, and a swing that only a gauge can know."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.replay import Replay, replay
from nospill.errors import ScenarioError
from nospill.execution.observer import Gauge, observed_liquids
from nospill.laws.scene_parameters import structure_of
from nospill.plans.plan import Plan
from nospill.potential_flow import rows_at
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import wall_gains
from nospill.scene.swing import Swing, coordinates
from nospill.simulation.motion_file import Heights

QUIET = 1e-9
"""m/s^2; an unknown acceleration that is none."""


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[[str, int], Plan]) -> Plan:
    return gentle_plan("matrix-liquid-soft-end", 1)


@pytest.fixture(scope="module")
def played(plan: Plan) -> Replay:
    return replay(plan.trajectory, plan.scene)


def _swinging(scene: Scene, x: float, y: float) -> Scene:
    """The scene whose liquid begins with displacements of its slowest mode, m."""
    (cargo,) = scene.cargo
    assert cargo.filling is not None
    filling = replace(cargo.filling, initial_swing=Swing(((x, y),), ((0.0, 0.0),)))
    return replace(scene, cargo=(replace(cargo, filling=filling),))


def _wall(scene: Scene, played: Replay, azimuth: float) -> np.ndarray:
    """Heights over the replay at a place of the wall, m: of the modes, and of those that follow at once."""
    (cargo,), (part,) = scene.cargo, structure_of(scene).slosh_slices
    assert cargo.filling is not None
    toward = np.array([np.cos(azimuth), np.sin(azimuth)])
    force = rows_at(played.body, np.array([*cargo.position, cargo.filling.liquid_height]), cargo.yaw)[6:]
    at_once = -cargo.filling.modes.static_correction * toward @ (force[:2] / force[2])
    return played.slosh_displacement[:, part] @ (toward @ wall_gains(cargo.oscillators)[:2]) + at_once


def test_without_gauges_the_swing_is_the_replayed_one_and_its_spread_swings(plan: Plan, played: Replay) -> None:
    """With as much spread in both halves of a swing its ellipse only shrinks with the damping."""
    (found,) = observed_liquids(played, plan.scene, acceleration=QUIET, spread=1e-3).values()
    own = coordinates(found.swing, plan.scene.cargo[0].oscillators)
    np.testing.assert_allclose(own[0], played.slosh_displacement[-1], atol=1e-12)
    np.testing.assert_allclose(own[1], played.slosh_velocity[-1], atol=1e-12)
    mode = plan.scene.cargo[0].oscillators[0]
    decay = np.exp(-mode.damping * mode.frequency * (played.t[-1] - played.t[0]))
    np.testing.assert_allclose(found.height_spread, 1e-3 * decay, rtol=0.05)


def test_an_unknown_acceleration_adds_energy_in_proportion_to_time(plan: Plan, played: Replay) -> None:
    """Without damping: mean of v^2 + omega^2 q^2 grows by the density, 2 sigma^2 tau, each second."""
    (cargo,) = plan.scene.cargo
    assert cargo.filling is not None
    modes = replace(
        cargo.filling.modes, oscillators=tuple(replace(mode, damping=1e-12) for mode in cargo.filling.modes.oscillators)
    )
    still = replace(plan.scene, cargo=(replace(cargo, filling=replace(cargo.filling, modes=modes)),))
    (found,) = observed_liquids(played, still, acceleration=0.1, spread=1e-9).values()
    count, omega = len(found.covariance) // 2, cargo.oscillators[0].frequency
    energy = found.covariance[count, count] + omega**2 * found.covariance[0, 0]
    assert energy == pytest.approx(2.0 * 0.1**2 * 0.02 * (played.t[-1] - played.t[0]), rel=1e-6)


def test_a_gauge_finds_the_swing_that_the_replay_does_not_know(plan: Plan, played: Replay) -> None:
    """Readings of a liquid that was not at rest, by the replay of one that was."""
    truth = _swinging(plan.scene, 0.001, 0.0)
    true = replay(plan.trajectory, truth)
    times = true.t[::50]
    heights = np.interp(times, true.t, _wall(truth, true, 0.0))
    gauge = Gauge(Heights(times, heights), azimuth=0.0, noise=2e-4)
    ((name, blind),) = observed_liquids(played, plan.scene, spread=5e-3).items()
    seen = observed_liquids(played, plan.scene, {name: gauge}, spread=5e-3)[name]
    oscillators = plan.scene.cargo[0].oscillators
    wanted = np.array([true.slosh_displacement[-1], true.slosh_velocity[-1]])
    missed, before = (np.abs(coordinates(item.swing, oscillators) - wanted) for item in (seen, blind))
    assert missed[0, 0] < 0.1 * before[0, 0] and missed[1, 0] < 0.1 * before[1, 0]
    assert seen.height_spread[0] < 0.2 * blind.height_spread[0]  # towards the gauge
    assert missed[0, 0] * oscillators[0].surface_gain < 3.0 * seen.height_spread[0]


def test_what_makes_no_sense_is_refused(plan: Plan, played: Replay) -> None:
    gauge = Gauge(Heights(np.array([0.0, 1.0]), np.zeros(2)))
    with pytest.raises(ScenarioError, match="outside the motion"):
        observed_liquids(played, plan.scene, at=99.0)
    with pytest.raises(ScenarioError, match="spread = 0"):
        observed_liquids(played, plan.scene, spread=0.0)
    with pytest.raises(ScenarioError, match="gauge of nobody"):
        observed_liquids(played, plan.scene, {"nobody": gauge})
    with pytest.raises(ScenarioError, match="noise = 0"):
        observed_liquids(played, plan.scene, {plan.scene.cargo[0].name: replace(gauge, noise=0.0)})
