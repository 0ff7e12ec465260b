"""Fill, damping, clock and gauge of a cup, learnt again from what its liquid would have done."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import judge_joints
from nospill.identification.liquid_fit import LiquidFit, fit_liquid
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.motion.trajectory import Trajectory
from nospill.scene.perturbation import Perturbation, perturbed
from nospill.scene.scene import Scene
from nospill.simulation.motion_file import Heights

RECORD = 12.0
"""s; long enough for the swings to decay."""


@pytest.fixture(scope="module")
def lively(smooth_motion):  # type: ignore[no-untyped-def]
    """A quick motion that leaves the liquid swinging, with one cup."""
    return smooth_motion("matrix-liquid", cargo=1, stretch=0.55)


def height_of(
    scene: Scene, trajectory: Trajectory, *, rise: float = 0.0, factor: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """What the judge sees of a cup with another fill and damping: times and heights."""
    cup = perturbed(scene.cargo[0], Perturbation(liquid_height=rise, damping=factor), fidelity=scene.fidelity)
    motion = trajectory.motion
    t = np.arange(0.0, trajectory.end_time + RECORD, 0.002)
    record = Trajectory.of_joints(t, trajectory.joints, *(motion(t, order) for order in range(3)))
    traces = judge_joints(record, replace(scene, cargo=(cup,)), motion=motion, rate=500.0).traces
    trace = next(own for own in traces if own.constraint == SloshHeight.name)
    return trace.t, trace.value


def fit(lively, t: np.ndarray, height: np.ndarray, *, clock: float, gauge: float, noise: float, seed: int) -> LiquidFit:  # type: ignore[no-untyped-def]
    """What is learnt from a camera at 60 Hz."""
    generator = np.random.default_rng(seed)
    shown = np.arange(0.0, RECORD, 1 / 60) + clock - 0.3
    seen = np.interp(shown - clock, t, height, left=0.0) + gauge + noise * generator.standard_normal(len(shown))
    motion = lively.trajectory.motion
    return fit_liquid(motion, lively.scene, "c1", Heights(shown, seen), begin=0.0, end=lively.trajectory.end_time)


def test_everything_is_learnt_again(lively) -> None:  # type: ignore[no-untyped-def]
    t, height = height_of(lively.scene, lively.trajectory, rise=1.5e-3, factor=1.6)
    found = fit(lively, t, height, clock=0.7, gauge=4e-4, noise=5e-4, seed=0)
    stated = found.stated
    assert found.of("clock").value == pytest.approx(0.7, abs=2e-3)
    assert found.of("fill").value == pytest.approx(stated[0] + 1.5e-3, abs=1e-3)
    assert found.of("damping").value == pytest.approx(1.6 * stated[1], rel=0.1)
    assert found.of("gauge").value == pytest.approx(4e-4, abs=2e-4)
    assert found.of("frequency").identifiable
    assert found.left == pytest.approx(5e-4, rel=0.1)


def test_a_record_without_decay_tells_neither_fill_nor_damping(lively) -> None:  # type: ignore[no-untyped-def]
    t, height = height_of(lively.scene, lively.trajectory)
    short = t < lively.trajectory.end_time
    generator = np.random.default_rng(0)
    shown = t[short][::8]
    seen = Heights(shown, height[short][::8] + 2e-3 * generator.standard_normal(len(shown)))
    motion = lively.trajectory.motion
    found = fit_liquid(motion, lively.scene, "c1", seen, begin=0.0, end=lively.trajectory.end_time)
    assert not found.of("fill").identifiable
    assert found.of("fill").value == found.stated[0]
    assert found.of("clock").identifiable


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say(lively) -> None:  # type: ignore[no-untyped-def]
    generator, inside, apart = np.random.default_rng(3), [], []
    for seed in range(7):
        rise, factor = generator.uniform(-3e-3, 3e-3), generator.uniform(0.7, 2.0)
        clock, gauge = generator.uniform(0.2, 1.0), generator.uniform(-1e-3, 1e-3)
        t, height = height_of(lively.scene, lively.trajectory, rise=rise, factor=factor)
        found = fit(lively, t, height, clock=clock, gauge=gauge, noise=3e-4, seed=seed)
        truth = {"clock": clock, "fill": found.stated[0] + rise, "damping": factor * found.stated[1], "gauge": gauge}
        off = {name: found.of(name).value - value for name, value in truth.items()}
        inside.append([abs(off[name]) < found.of(name).half_width for name in truth])
        apart.append([abs(off["fill"]) / 1e-3, abs(off["damping"]) / (0.1 * truth["damping"])])
    assert np.max(apart) < 1.0
    assert np.mean(inside) >= 0.90
