"""What a plan survives of its arm: against every combination of late joints, and against closed forms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from nospill.certification.survival import Looked, delay_fault, survival, survived, swing_fault
from nospill.certification.survived import DAMPING, Survival, Survived
from nospill.certification.tracked_rows import Followed, worst_of
from nospill.laws.constraints.base import RowId
from nospill.motion.tracking import elastic


@pytest.fixture(scope="module")
def followed(smooth_motion: Callable) -> Followed:
    """Cups and a bottle on a leaning tray, to be played by other arms."""
    motion = smooth_motion("mixed-tray", stretch=0.693, tilt=(0.1, 0.05))
    return Followed.of(motion.trajectory, motion.scene)


@pytest.fixture(scope="module")
def plan(followed: Followed) -> Looked:
    return Looked.at(followed)


def test_no_combination_of_late_joints_fails_within_the_delay(followed: Followed, plan: Looked) -> None:
    """All of them but none and all, which are the plan; a tenth beyond it the worst of them fails."""
    fault = delay_fault(followed)
    found = survived(plan, fault)
    assert found.size is not None
    assert found.size > 0.0
    none = np.zeros(followed.joints)
    shares = [np.array(share) for share in product((0.0, 1.0), repeat=followed.joints)][1:-1]

    def worst(size: float) -> tuple[float, RowId]:
        arms = [fault.motion(size * share, none) for share in shares]
        return max(worst_of(uses) for uses in followed.rows(*arms, after=size))

    assert worst_of(plan.stated)[0] < worst(found.size)[0] < 1.0
    beyond = worst(1.1 * found.size)
    assert beyond[0] > 1.0
    assert beyond[1].label == found.first


def test_a_plan_far_from_its_limits_survives_every_delay_that_is_looked_at(smooth_motion: Callable) -> None:
    motion = smooth_motion("matrix-rigid", cargo=2, stretch=0.8)
    followed = Followed.of(motion.trajectory, motion.scene)
    assert survived(Looked.at(followed), delay_fault(followed)).size is None


def test_a_delay_of_all_joints_alike_only_shifts_the_time(followed: Followed) -> None:
    fault, none = delay_fault(followed), np.zeros(followed.joints)
    planned, late = followed.rows(followed.motion, fault.motion(none + 0.01, none), after=0.02)
    for row, use in planned.items():
        assert np.max(late[row]) == pytest.approx(np.max(use), abs=2e-3)


def test_rows_of_some_motions_are_those_of_each_alone(plan: Looked, followed: Followed) -> None:
    """The final state too, which motions that are late reach at different times."""
    fault, none = delay_fault(followed), np.zeros(followed.joints)
    motions = [fault.motion(none + delay, none) for delay in (0.002, 0.005)]
    for motion, together in zip(motions, plan.few.rows(*motions, after=0.01), strict=True):
        (alone,) = plan.few.rows(motion, after=0.01)
        assert any(len(use) == 1 for use in alone.values())
        assert alone.keys() == together.keys()
        for row, use in alone.items():
            np.testing.assert_allclose(together[row], use, rtol=1e-9, atol=1e-12)


def test_no_phases_of_swinging_joints_fail_within_the_swing(followed: Followed, plan: Looked) -> None:
    fault = swing_fault(followed)
    found = survived(plan, fault)
    assert found.size is not None
    phases = np.random.default_rng(3).uniform(-np.pi, np.pi, size=(40, followed.joints))
    size = np.full(followed.joints, found.size)
    played = followed.rows(*(fault.motion(size, phase) for phase in phases), at_end=False)
    worst = max(worst_of(uses)[0] for uses in played)
    assert worst_of(plan.stated)[0] < worst < 1.0


def test_resonances_above_the_one_survived_hold_and_the_next_fails(smooth_motion: Callable) -> None:
    motion = smooth_motion("mixed-tray", stretch=0.7, tilt=(0.1, 0.05))
    survives = survival(motion.trajectory, motion.scene)
    assert survives is not None
    found = survives.resonance
    followed = Followed.of(motion.trajectory, motion.scene).with_few_modes()
    start, stop = followed.span

    def use(frequency: float) -> float:
        rings = elastic(followed.motion, np.full(followed.joints, frequency), DAMPING, start, stop + 0.7)
        return worst_of(followed.rows(rings, after=0.35, at_end=False)[0])[0]

    assert found.size is not None
    assert all(use(factor * found.size) <= 1.0 for factor in (1.0, 1.2, 1.5))
    assert use(0.93 * found.size) > 1.0


def test_a_plan_that_fails_as_stated_survives_nothing(smooth_motion: Callable) -> None:
    motion = smooth_motion("mixed-tray", stretch=0.4, tilt=(0.1, 0.05))
    found = survival(motion.trajectory, motion.scene)
    assert found is not None
    assert found.delay.size == 0.0
    assert found.swing.size == 0.0
    assert found.delay.first


def test_of_an_empty_tray_there_is_nothing_to_say(smooth_motion: Callable) -> None:
    motion = smooth_motion("matrix-rigid", cargo=2)
    assert survival(motion.trajectory, replace(motion.scene, cargo=())) is None


def test_reserves_are_used_up_first(smooth_motion: Callable) -> None:
    """The measured friction counts, whatever part of it the plan was made with."""
    motion = smooth_motion("matrix-rigid", cargo=2)
    halves = tuple(replace(item, friction_reserve=0.5) for item in motion.scene.cargo)
    reserved = Followed.of(motion.trajectory, replace(motion.scene, cargo=halves))
    stated = Followed.of(motion.trajectory, motion.scene)
    (uses,), (others,) = (own.rows(own.motion) for own in (stated, reserved))
    for row, use in uses.items():
        assert np.allclose(others[row], use)


def test_the_line_says_sizes_and_what_fails_first() -> None:
    slip = RowId("slip", "bottle").label
    found = Survival(Survived(2.487e-4, slip), Survived(1.8e-5, slip), Survived(54.4, slip))
    assert found.text == (
        "survives 0.24 ms between joints, 0.018 mrad of swing at 5 Hz, resonances above 54 Hz; first to fail: slip of "
        "bottle"
    )
    assert Survival.of_dict(found.to_dict()) == found
    nothing = Survival(Survived(None), Survived(None), Survived(None))
    assert nothing.text == (
        "survives more than 20 ms between joints, more than 50 mrad of swing at 5 Hz, resonances above 6 Hz"
    )
