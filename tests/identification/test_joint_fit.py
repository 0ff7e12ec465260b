"""Delay and lag of joints, learnt again from what they would have done."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nospill.execution.log import JointLog
from nospill.execution.motion import recorded_motion
from nospill.identification.joint_fit import JointFit, against_the_first, fit_joints
from nospill.motion.control import followed
from nospill.scene.controller import Controller
from tests.motions import SmoothMotion

CLOCK = 0.4


@pytest.fixture(scope="module")
def plan(smooth_motion: Callable[..., SmoothMotion]) -> SmoothMotion:
    """A brisk motion; its liquid does not matter."""
    return smooth_motion("matrix-liquid", cargo=1, stretch=0.55)


def fits_of(
    plan: SmoothMotion, delay: np.ndarray, lag: np.ndarray, *, noise: float = 2e-6, seed: int = 0
) -> tuple[JointFit, ...]:
    """What is learnt from the log of an arm that follows so; the log's clock is `CLOCK` ahead of the plan's."""
    generator = np.random.default_rng(seed)
    command, length = plan.trajectory.motion, float(plan.trajectory.t[-1])
    controller = Controller(delay, lag, compensate=False)
    t = np.arange(0.0, length + 1.2, 0.002)
    done = followed(command, controller, 0.0, length)(t - CLOCK - controller.latest)
    stamps = t + 2e-5 * generator.uniform(-1.0, 1.0, len(t))
    log = JointLog("run", stamps, plan.scene.robot.joints, done + noise * generator.standard_normal(done.shape))
    return fit_joints(recorded_motion(log, plan.scene), command, (0.0, length))


def test_delay_and_lag_are_told_apart(plan: SmoothMotion) -> None:
    delay, lag = 1e-3 * np.array([8.0, 4, 6, 0, 2, 10]), 1e-3 * np.array([15.0, 20, 10, 5, 25, 8])
    for joint, found in enumerate(fits_of(plan, delay, lag)):
        if joint == 3:  # which stands still in this motion
            assert not found.moves
            assert not found.lag.identifiable
            continue
        assert found.delay.identifiable
        assert found.lag.identifiable
        assert found.delay.value == pytest.approx(CLOCK + delay[joint], abs=1e-3)
        assert found.lag.value == pytest.approx(lag[joint], rel=0.05)


def test_a_joint_without_a_lag(plan: SmoothMotion) -> None:
    found = fits_of(plan, np.full(6, 0.005), np.zeros(6))[0]
    assert found.lag.value == pytest.approx(0.0, abs=2e-4)


def test_delays_against_the_joint_that_begins_first(plan: SmoothMotion) -> None:
    found = against_the_first(fits_of(plan, 1e-3 * np.array([8.0, 4, 6, 0, 2, 10]), np.full(6, 0.015)))
    told = [own.delay.value for own in found if own.moves]
    assert told == pytest.approx([6e-3, 2e-3, 4e-3, 0.0, 8e-3], abs=1e-4)


def test_a_lag_of_second_order_is_told_where_the_first_leaves_more_than_noise(plan: SmoothMotion) -> None:
    """The arm is integrated by an outside solver, in steps of its own."""
    from scipy.integrate import solve_ivp

    command, length = plan.trajectory.motion, float(plan.trajectory.t[-1])
    period, ratio, delay, noise = 0.012, 0.6, 0.004, 2e-6
    t = np.arange(0.0, length + 1.2, 0.002)
    done = command(t - CLOCK)
    first = done[0, 0]

    def rate(at: float, state: np.ndarray) -> list[float]:
        asked = float(command(np.array([at - CLOCK - delay]))[0, 0]) - first
        return [state[1], (asked - state[0] - 2.0 * ratio * period * state[1]) / period**2]

    done[:, 0] = first + solve_ivp(rate, (0.0, t[-1]), [0.0, 0.0], t_eval=t, max_step=0.01, rtol=1e-7, atol=1e-9).y[0]
    generator = np.random.default_rng(0)
    log = JointLog("run", t, plan.scene.robot.joints, done + noise * generator.standard_normal(done.shape))
    found = fit_joints(recorded_motion(log, plan.scene), command, (0.0, length))
    own = found[0].second
    assert found[0].misfit
    assert not found[0].unexplained
    assert own is not None
    assert own.frequency.value == pytest.approx(1.0 / period, rel=0.05)
    assert own.damping.value == pytest.approx(ratio, rel=0.05)
    assert own.delay.value == pytest.approx(CLOCK + delay, abs=1e-3)
    assert all(fit.second is None for fit in found[1:])


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say(plan: SmoothMotion) -> None:
    generator, inside, apart = np.random.default_rng(5), [], []
    for seed in range(6):
        delay, lag = generator.uniform(2e-3, 12e-3, 6), generator.uniform(5e-3, 30e-3, 6)
        for joint, found in enumerate(fits_of(plan, delay, lag, noise=1e-5, seed=seed)):
            if found.moves:
                off = np.array([found.delay.value - CLOCK - delay[joint], found.lag.value - lag[joint]])
                inside.append(np.abs(off) < [found.delay.half_width, found.lag.half_width])
                apart.append(np.abs(off) / [1e-3, 0.05 * lag[joint]])
    assert np.max(apart) < 1.0
    assert np.all(np.mean(inside, axis=0) >= 0.90)
