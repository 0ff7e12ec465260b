"""The flow to the first order is the package's modal model; the second order is what the full flow adds to it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nospill.potential_flow import crests_along
from nospill.potential_flow.crests import Crests
from nospill.scene.cargo import Cargo
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.simulation.container_motion import body_rows, pose_spline
from nospill.simulation.motion_file import checked_motion
from nospill.simulation.simulate import simulate_slosh
from tests.waters import cup, tub

T = np.arange(0.0, 1.35, 0.002)
END = 1.15


def _poses(size: float, *, way: float = 0.0, pitch: float = 0.0, roll: float = 0.0, yaw: float = 0.0) -> tuple:
    """A move from rest to rest in 0.9 s, scaled but for its yaw, and a lean there and back."""
    s = np.clip(T / 0.9, 0.0, 1.0)
    there, bump = s**3 * (10 - 15 * s + 6 * s**2), 64 * (s * (1 - s)) ** 3
    angles = np.column_stack([yaw * there, size * pitch * bump, size * roll * bump])
    return size * way * np.outer(there, [1.0, 0.4, 0.2]), Rotation.from_euler("ZYX", angles).as_quat()


def _crests(cargo: Cargo, poses: tuple) -> Crests:
    spline = pose_spline(checked_motion(T, *poses))
    return crests_along(cargo, lambda t: body_rows(spline, t, STANDARD_GRAVITY), 0.0, END, after=0.1)


MOTIONS = {
    "translation": {"way": 0.003},
    "lean": {"pitch": 0.004, "roll": 0.002},
    "both with yaw": {"way": 0.003, "pitch": 0.004, "roll": 0.003, "yaw": 1.5},
}


@pytest.mark.parametrize(
    ("cargo", "motion"),
    [*((cup(), motion) for motion in MOTIONS.values()), (cup(0.05, 0.02), MOTIONS["both with yaw"])],
    ids=[*MOTIONS, "shallow, both with yaw"],
)
def test_first_order_in_a_cup_is_the_modal_model(cargo: Cargo, motion: dict[str, float]) -> None:
    poses = _poses(1.0, **motion)
    found = _crests(cargo, poses)
    expected = np.interp(found.t, T, simulate_slosh(cargo, T, *poses, modes=20, height="corrected").height)
    assert np.max(np.abs(found.linear - expected)) < 2e-3 * np.max(expected)


def test_first_order_in_a_box_is_the_modal_model() -> None:
    for motion in ({"way": 0.003}, {"pitch": 0.004, "roll": 0.002}):
        poses = _poses(1.0, **motion)
        found = _crests(tub(), poses)
        model = simulate_slosh(tub(), T, *poses, modes=20, height="corrected").height
        # the model looks into the corners; low crests may stand between them
        assert np.max(found.linear) == pytest.approx(np.max(model), rel=1e-4)
        assert np.all(found.linear > np.interp(found.t, T, model) - 2e-3 * np.max(model))


def test_turn_of_a_box_excites_its_yaw_modes_as_in_the_modal_model() -> None:
    poses = _poses(1.0, yaw=0.02)
    found = _crests(tub(), poses)
    expected = np.interp(found.t, T, simulate_slosh(tub(), T, *poses, modes=20, height="corrected").height)
    assert np.max(found.linear) == pytest.approx(np.max(expected), rel=0.05)  # the model looks at nine places


def test_turn_about_its_axis_leaves_a_cup_level() -> None:
    found = _crests(cup(), _poses(1.0, yaw=2.0))
    assert max(map(np.max, (found.linear, found.second, found.full))) < 1e-9


@pytest.mark.parametrize(
    ("cargo", "motion"),
    [
        (cup(), {"way": 0.1, "pitch": 0.15, "roll": 0.1, "yaw": 1.5}),
        (cup(), {"pitch": 0.2}),
        (tub(), {"way": 0.1, "pitch": 0.1, "roll": 0.05}),
    ],
    ids=["cup", "leaning cup", "box"],
)
def test_second_order_leaves_an_error_of_the_third(cargo: Cargo, motion: dict[str, float]) -> None:
    """Half the motion: a quarter of the second order, an eighth of what it leaves."""
    added, left = [], []
    for size in (0.25, 0.5):
        found = _crests(cargo, _poses(size, **motion))
        added.append(np.max(np.abs(found.second - found.linear)))
        left.append(np.max(np.abs(found.full - found.second)))
    assert added[1] / added[0] == pytest.approx(4.0, rel=0.15)
    assert left[1] / left[0] == pytest.approx(8.0, rel=0.3)
    assert left[1] < 0.5 * added[1]
