"""Heights of second order over a band of arms: no drawn arm, integrated apart from the judge, is above what it says."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pytest

from nospill.certification import joints_off, tracking_band
from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.second_order import waves_along
from nospill.certification.tracked_rows import Followed
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.margins.laws import object_margins, simulate_arms
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene
from nospill.scene.tracking import Arm
from tests.builders import with_linear_heights
from tests.motions import SmoothMotion

DELAY = 6e-3
HEIGHT = RowId(SloshHeight.name, "cup")


@pytest.fixture(scope="module")
def motion(smooth_motion: Callable) -> SmoothMotion:
    return smooth_motion("mixed-tray", cargo=1, intervals=50, stretch=0.7, tilt=(-0.2, 0.2))


def _over(motion: SmoothMotion, delays: np.ndarray) -> Scene:
    return motion.scene.changed({"tolerance.tracking": {"delay": delays.tolist()}})


@pytest.fixture(scope="module")
def judged(motion: SmoothMotion) -> Judgement:
    return judge_motion(motion.trajectory, _over(motion, np.full(6, DELAY)))


def _drawn(motion: SmoothMotion) -> Iterator[float]:
    """Uses of the height by arms of the band, half of them with joints at its ends."""
    draws = np.random.default_rng(11).uniform(size=(24, 6))
    draws[::2] = np.round(draws[::2])
    arms = [Arm.late(Controller(DELAY * share, np.zeros(6))) for share in draws]
    for played in simulate_arms(motion.trajectory, motion.scene, arms, after=DELAY):
        (found,) = object_margins(motion.scene, [motion.scene.cargo], played)
        column = [own.name for own in found.constraints].index(SloshHeight.name)
        yield 1.0 - float(found.margin[0, column]) / abs(float(found.limit[0, column]))


@pytest.fixture(scope="module")
def drawn(motion: SmoothMotion) -> float:
    return max(_drawn(motion))


def _use(judged: Judgement) -> float:
    assert judged.band is not None
    return judged.band.use[HEIGHT]


def test_no_drawn_arm_is_above_the_height_over_the_band(judged: Judgement, drawn: float) -> None:
    (planned,) = (row for row in judged.planned_rows if row.id == HEIGHT)
    assert planned.linear_value is not None  # it is of second order
    assert planned.use + 0.02 < drawn <= _use(judged)
    assert _use(judged) - drawn < 0.2 * (_use(judged) - planned.use)  # and it is no bound that nothing comes near


def test_without_the_share_of_one_joint_it_is_too_low(
    motion: SmoothMotion, drawn: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fault that the comparison with drawn arms sees, where no combination is replayed."""
    played_of = joints_off._Played.of

    def without_the_first(few: Followed, arms: Sequence[Arm], after: float) -> joints_off._Played:
        return played_of(few, [arms[0] if index in (1, 7) else arm for index, arm in enumerate(arms)], after)

    monkeypatch.setattr(joints_off._Played, "of", without_the_first)
    monkeypatch.setattr(tracking_band, "_worst_arms", lambda *_: iter(()))
    assert _use(judge_motion(motion.trajectory, _over(motion, np.full(6, DELAY)))) < drawn


def test_a_band_of_nothing_is_the_plan_as_stated(motion: SmoothMotion) -> None:
    alone = judge_motion(motion.trajectory, motion.scene)
    none = judge_motion(motion.trajectory, _over(motion, np.full(6, 1e-9)))
    stated = {row.id: row.use for row in alone.certificate.rows}
    assert {row.id: row.use for row in none.certificate.rows} == pytest.approx(stated, abs=3e-5)  # by coarse replays


def test_the_linear_height_is_as_it_was(motion: SmoothMotion, judged: Judgement) -> None:
    linear = judge_motion(motion.trajectory, with_linear_heights(_over(motion, np.full(6, DELAY))))
    assert _use(linear) > _use(judged) + 0.02  # on this motion, whose crests are wide
    rows = {row.id: row.worst_value for row in linear.planned_rows}
    (planned,) = (row for row in judged.planned_rows if row.id == HEIGHT)
    assert planned.linear_value == pytest.approx(rows[HEIGHT])


def test_motions_behind_one_another_are_each_as_alone(motion: SmoothMotion) -> None:
    (cup,) = motion.scene.cargo
    count, draw = 60, np.random.default_rng(4)
    k = len(cup.initial_coordinates[0])
    bodies, shifts = [], []
    for _ in range(3):
        body = 0.3 * draw.normal(size=(9, 1)) * np.sin(np.linspace(0.0, 2.0, count)) + np.eye(9)[8][:, None] * 9.81
        bodies.append(body)
        shifts.append(1e-3 * np.sin(np.linspace(0.0, 3.0, count))[:, None] * draw.normal(size=(1, k)))
    for angle in (0.04, 0.3):
        alone = [
            waves_along(cup, body, q, 0.0 * q, 2e-3, step_angle=angle) for body, q in zip(bodies, shifts, strict=True)
        ]
        q = np.concatenate(shifts)
        together = waves_along(cup, np.hstack(bodies), q, 0.0 * q, 2e-3, motions=3, step_angle=angle)
        np.testing.assert_allclose(together.crests, np.concatenate([own.crests for own in alone]), rtol=0, atol=1e-15)
