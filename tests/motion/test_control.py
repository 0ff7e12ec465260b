"""Commands, and what joints make of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.motion.control import command_for, commanded, commanded_at, followed, settling_after
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.scene.controller import Controller

DELAYS = np.array([0.002, 0.008, 0.0])
LAGS = np.array([0.015, 0.0, 0.03])
T = np.linspace(-0.1, 1.3, 3001)


def record() -> Trajectory:
    t = np.arange(501) / 500.0
    u = t[:, None]
    way = np.array([1.0, -2.0, 0.3])
    return Trajectory.of_joints(
        t,
        ("a", "b", "c"),
        way * (35 * u**4 - 84 * u**5 + 70 * u**6 - 20 * u**7),
        way * (140 * u**3 - 420 * u**4 + 420 * u**5 - 140 * u**6),
        way * (420 * u**2 - 1680 * u**3 + 2100 * u**4 - 840 * u**5),
    )


def integrated(command: Any, controller: Controller, t: np.ndarray) -> np.ndarray:
    """lag q' + q = command(t - delay) by steps in which the command is a straight line, exactly."""
    step, columns = t[1] - t[0], []
    for joint, (delay, lag) in enumerate(zip(controller.delay, controller.lag, strict=True)):
        asked = command(t - delay)[:, joint]
        found = asked.copy()
        if lag:
            slope, decay = np.diff(asked) / step, np.exp(-step / lag)
            for index in range(1, len(t)):
                before = found[index - 1] - asked[index - 1] + lag * slope[index - 1]
                found[index] = asked[index] - lag * slope[index - 1] + before * decay
        columns.append(found)
    return np.column_stack(columns)


def test_what_is_not_compensated_is_followed_as_the_equation_says() -> None:
    plan, controller = record(), Controller(DELAYS, LAGS, compensate=False)
    asked = plan.motion
    t = np.arange(-0.1, 1.4, 5e-5)
    theirs = integrated(asked, controller, t)
    ours = followed(asked, controller, 0.0, 1.0)(t - controller.latest)
    assert np.max(np.abs(ours - theirs)) < 1e-7
    assert np.max(np.abs(ours - asked(t))) > 0.02


@pytest.mark.parametrize(("order", "least"), [(0, 1e-8), (1, 1e-5), (2, 2e-2)])
def test_the_command_makes_the_joints_do_what_was_planned(order: int, least: float) -> None:
    plan, controller = record(), Controller(DELAYS, LAGS)
    samples = commanded(plan, controller)
    done = followed(QUINTIC_SPLINE.motion(samples), controller, float(samples.t[0]), float(samples.t[-1]))
    assert np.max(np.abs(done(T, order) - plan.motion(T, order))) < least


def test_derivatives_of_what_is_followed_agree() -> None:
    controller = Controller(DELAYS, LAGS, compensate=False)
    done = followed(record().motion, controller, 0.0, 1.0)
    t, step = np.linspace(0.1, 1.1, 200), 1e-5
    for order in (0, 1):
        difference = (done(t + step, order) - done(t - step, order)) / (2 * step)
        assert np.max(np.abs(difference - done(t, order + 1))) < 1e-4


def test_a_command_lasts_as_much_longer_as_the_delays_differ() -> None:
    plan = record()
    assert commanded(plan, Controller(np.full(3, 0.008), LAGS)).t[-1] == pytest.approx(1.0)
    assert commanded(plan, Controller(DELAYS, LAGS)).t[-1] == pytest.approx(1.008)
    assert commanded_at(plan, Controller(DELAYS, LAGS), 250.0).t[-1] == pytest.approx(1.008)
    assert settling_after(Controller(DELAYS, LAGS)) == 0.0
    assert settling_after(Controller(DELAYS, LAGS, compensate=False)) > 0.03 * 10


def test_an_even_delay_is_no_command_at_all() -> None:
    plan = record()
    own = commanded(plan, Controller(np.full(3, 0.008), np.zeros(3)))
    assert np.max(np.abs(own.position - plan.joint_position)) < 1e-12


def test_without_a_controller_the_record_is_the_command() -> None:
    plan = record()
    assert commanded(plan, None).position is plan.joint_position
    assert isinstance(commanded_at(plan, None, 100.0), JointSamples)


def test_the_command_leads_by_lag_times_speed() -> None:
    controller = Controller(np.zeros(3), LAGS)
    asked, planned = command_for(record().motion, controller), record().motion
    assert asked(T) == pytest.approx(planned(T) + LAGS * planned(T, 1), abs=1e-12)
