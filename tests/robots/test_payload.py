"""The load at the flange against sums over small pieces of it."""

import numpy as np

from nospill.robots.dynamics import Load, load_of
from nospill.robots.payload import board_load, standing_load
from nospill.tray import Tray

TRAY = Tray(size=np.array([0.335, 0.25]), offset=np.array([0.01, -0.02, 0.108]), yaw_on_flange=0.6, mass=0.8)


def turned(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])


def pieces_load(points: np.ndarray, mass: float) -> Load:
    """Point masses of equal size at `points` (k, 3) in flange axes."""
    loads = [load_of(mass / len(points), point) for point in points]
    return sum(loads[1:], start=loads[0])


def assert_same(ours: Load, theirs: Load, tolerance: float) -> None:
    assert np.isclose(float(ours.mass), float(theirs.mass))
    for one, other in ((ours.first_moment, theirs.first_moment), (ours.inertia, theirs.inertia)):
        np.testing.assert_allclose(np.asarray(one), np.asarray(other), atol=tolerance)


def test_board_is_the_sum_of_its_pieces() -> None:
    count = 100
    steps = (np.arange(count) + 0.5) / count - 0.5
    x, y = np.meshgrid(steps * TRAY.size[0], steps * TRAY.size[1])
    plane = np.stack([x.ravel(), y.ravel(), np.zeros(count * count)], axis=1)
    points = TRAY.offset + plane @ turned(TRAY.yaw_on_flange).T
    assert_same(
        board_load(TRAY), pieces_load(points, TRAY.mass), 2e-6
    )  # the grid's own error is 1e-4 of the plate's inertia


def test_standing_body_is_the_sum_of_its_pieces() -> None:
    generator = np.random.default_rng(0)
    body = generator.uniform(-0.05, 0.1, (200, 3))
    centre = body.mean(axis=0)
    arms = body - centre
    inertia = 0.4 / 200 * sum((arm @ arm * np.eye(3) - np.outer(arm, arm) for arm in arms), start=np.zeros((3, 3)))
    position, yaw = np.array([0.09, -0.07]), -1.1
    on_tray = np.array([*position, 0.0]) + body @ turned(yaw).T
    points = TRAY.offset + on_tray @ turned(TRAY.yaw_on_flange).T
    ours = standing_load(TRAY, 0.4, centre=centre, inertia=inertia, position=position, yaw=yaw)
    assert_same(ours, pieces_load(points, 0.4), 1e-12)
