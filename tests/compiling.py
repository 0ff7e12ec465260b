"""Machine code of tests: functions compared, and libraries that are compiled for the tests of one file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from nospill.compiled.small_libraries import small_library
from nospill.core.batches import columns_at_once
from tests.hasty import COMPILER


@contextmanager
def own_library(name: str, cache: Path) -> Iterator[Path]:
    """A small library compiled into an empty cache, in which functions look for it while this lasts."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CC", COMPILER)
        patch.setenv("NOSPILL_COMPILE", "wait")
        patch.setenv("NOSPILL_CACHE", str(cache))
        found = small_library(name, wait=True)
        assert found is not None
        yield found


def assert_same(ours: ca.Function, theirs: ca.Function, *, tolerance: float = 1e-12) -> None:
    """Machine code of one or of a few columns at once, against a function of one column, each column another one."""
    random, starts = np.random.default_rng(3), range(theirs.n_in())
    at_once = columns_at_once(ours, [])
    for _ in range(5):
        columns = [
            random.uniform(0.2, 1.2, (theirs.size1_in(index), ours.size2_in(index) // theirs.size2_in(index)))
            for index in starts
        ]
        found = [part.full() for part in ours.call(columns)]
        wanted = [
            theirs.call([column[:, min(index, column.shape[1] - 1)] for column in columns]) for index in range(at_once)
        ]
        for place, one in enumerate(found):
            other = np.concatenate([part[place].full() for part in wanted], axis=1)
            largest = np.abs(other[np.isfinite(other)]).max(initial=1.0)
            np.testing.assert_allclose(one, other, rtol=tolerance, atol=tolerance * largest)
