"""A trajectory altered after it was judged is never certified: random corruptions, large enough to matter."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nospill.certification.certificate import certify
from nospill.errors import NospillError
from nospill.motion.trajectory import Trajectory
from nospill.plans.plan import Plan

QUICK = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])

LEAST = {
    "t": 1e-5,
    "joint_position": 2e-3,
    "joint_speed": 5e-3,
    "joint_acceleration": 1.0,
    "tray_position": 1e-3,
    "tilt": 1e-3,
}
"""Column -> a change of one sample that nobody may overlook, in the column's unit."""


class Subject:
    """A plan and its judge; what is shown of it in a failure is short."""

    def __init__(self, plan: Plan) -> None:
        self.scene, self.trajectory = plan.scene, plan.trajectory

    def certified(self, **changes: np.ndarray) -> bool:
        """Whether the trajectory with other columns is certified; refusing to judge at all is no certificate."""
        try:
            return certify(replace(self.trajectory, **changes), self.scene).ok  # type: ignore[arg-type]
        except NospillError:
            return False


@pytest.fixture(scope="module")
def subject(small_plan: Plan) -> Subject:
    return Subject(small_plan)


def test_the_plan_itself_is_certified(subject: Subject) -> None:
    assert subject.certified()


@pytest.mark.slow
@given(st.sampled_from(sorted(LEAST)), st.floats(0.0, 1.0), st.floats(1.0, 1e3), st.booleans(), st.integers(0, 5))
@QUICK
def test_one_sample_changed(subject: Subject, name: str, where: float, size: float, up: bool, component: int) -> None:
    values = np.array(getattr(subject.trajectory, name))
    change = (1 if up else -1) * size * LEAST[name]
    index = round(where * (len(values) - 1))
    if values.ndim == 1:
        values[index] += change
    else:
        values[index, component % values.shape[1]] += change
    assert not subject.certified(**{name: values})


@pytest.mark.slow
@given(st.floats(0.02, 0.98), st.integers(1, 200))
@QUICK
def test_samples_missing(subject: Subject, where: float, count: int) -> None:
    kept = np.ones(len(subject.trajectory.t), dtype=bool)
    first = int(where * len(kept))
    kept[first : first + count] = False
    columns = (field.name for field in fields(Trajectory) if field.name not in ("joints", "slosh", "in_motion"))
    assert not subject.certified(**{name: getattr(subject.trajectory, name)[kept] for name in columns})


@pytest.mark.slow
@given(st.data())
@QUICK
def test_samples_swapped(subject: Subject, data: st.DataObject) -> None:
    """Joint rows in another order, times as they were: the arm would jump."""
    count = len(subject.trajectory.t)
    first = data.draw(st.integers(count // 4, 3 * count // 4 - 60))
    second = data.draw(st.integers(first + 20, first + 60))
    order = np.arange(count)
    order[[first, second]] = order[[second, first]]
    changed = {name: getattr(subject.trajectory, name)[order] for name in ("joint_position", "joint_speed")}
    assert not subject.certified(**changed)


@pytest.mark.slow
@given(st.floats(0.3, 0.9))
@QUICK
def test_played_faster(subject: Subject, factor: float) -> None:
    """The same way in less time: the samples are no longer the controller's, or the speeds contradict the positions."""
    assert not subject.certified(t=subject.trajectory.t * factor)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # 1e300 overflows in squares and third differences
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e9, 1e300])
@pytest.mark.parametrize("name", [*LEAST, "s", "tray_quaternion"])
def test_numbers_that_are_none(subject: Subject, name: str, value: float) -> None:
    values = np.array(getattr(subject.trajectory, name))
    values.flat[values.size // 2] = value
    assert not subject.certified(**{name: values})
