"""The direction that stands for the freedom of seven joints, against the nearest point of a convex hull."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from nospill.robots.kinematics.redundancy import widest_direction


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@pytest.mark.parametrize("seed", range(20))
def test_it_is_that_of_the_nearest_point_of_the_convex_hull(seed: int) -> None:
    """Weights >= 0 with the least |sum w v|^2 + (1 - sum w)^2 are, but for their sum, those of that point."""
    random = np.random.default_rng(seed)
    vectors = unit(random.normal(size=7) + random.uniform(0.1, 0.6) * random.normal(size=(150, 7)))
    weights, _ = nnls(np.vstack([vectors.T, np.ones(150)]), np.append(np.zeros(7), 1.0))
    nearest = weights @ vectors
    assert np.min(vectors @ unit(nearest)) > 0.1
    np.testing.assert_allclose(widest_direction(vectors), unit(nearest), atol=1e-9)


def test_it_is_the_mean_where_no_direction_is_on_one_side_of_all_vectors() -> None:
    random = np.random.default_rng(0)
    first = unit(random.normal(size=(4, 7)))
    vectors = np.concatenate([first, -first[:1]])
    np.testing.assert_allclose(widest_direction(vectors), unit(vectors.mean(axis=0)), atol=1e-12)
    almost = np.array([[1.0, 1e-4, 0.0], [-1.0, 1e-4, 0.0], [0.6, 0.8, 0.0]])
    np.testing.assert_allclose(widest_direction(unit(almost)), unit(unit(almost).mean(axis=0)), atol=1e-12)
