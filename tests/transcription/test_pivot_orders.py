"""Orders of pivots that go from solve to solve: when they serve, and that they change no answer."""

from __future__ import annotations

import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.transcription.solvers import linear_solvers
from nospill.transcription.solvers.pivot_orders import PivotOrder, with_order
from tests.hasty import COMPILER
from tests.native.ma27 import LIW_TOO_SMALL, Entries, Factor
from tests.native.systems import chain, check, factorised_in_growing_room, kkt, of_upper, refined

pytestmark = pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler")


@pytest.fixture(scope="module")
def library() -> Path:
    found = linear_solvers.ldl_library()
    assert found is not None
    return found


def factorised(library: Path, entries: Entries, order: PivotOrder | None) -> tuple[Factor, PivotOrder]:
    """A first factorisation that may use an order, and the order to keep."""

    def run() -> Factor:
        factor = Factor(library, entries)
        check(factor, entries.dense(), entries.value)
        return factor

    factor, kept = with_order(str(library), order, run)
    assert kept is not None
    return factor, kept


def changed(entries: Entries, seed: int, part: float) -> Entries:
    """Other numbers in the same places, each up to `part` larger or smaller."""
    factor = np.random.default_rng(seed).uniform(1.0 - part, 1.0 + part, len(entries.value))
    return Entries(entries.size, entries.row, entries.column, entries.value * factor)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 10), st.integers(1, 10), st.data())
def test_a_kept_order_serves_other_numbers(
    library: Path, seed: int, stages: int, variables: int, data: st.DataObject
) -> None:
    """Inertia against dense linear algebra, and the residual of a solution, as `test_any_chain` has them."""
    equalities = data.draw(st.integers(0, variables))
    first = of_upper(chain(seed, stages, variables, equalities, data.draw(st.integers(0, 12))))
    _, order = with_order(str(library), None, lambda: Factor(library, first).factorise(first.value))
    entries, factor = changed(first, seed, 0.3), Factor(library, first)
    flag, kept = with_order(str(library), order, lambda: factor.factorise(entries.value))
    assert flag == 0 and kept is order
    matrix = entries.dense()
    assert factor.negative == np.sum(np.linalg.eigvalsh(matrix) < 0.0)
    right = matrix @ np.ones(len(matrix))
    assert np.max(np.abs(matrix @ refined(factor, matrix, right) - right)) <= 1e-9 * np.max(np.abs(right))


def test_the_same_numbers_give_the_same_bits(library: Path) -> None:
    entries, right = of_upper(chain(4)), np.linspace(-1.0, 2.0, len(chain(4)))
    first, order = factorised(library, entries, None)
    second, _ = factorised(library, entries, order)
    np.testing.assert_array_equal(first.solve(right), second.solve(right))


@pytest.mark.parametrize("other", [kkt(3, variables=31), kkt(4), chain(3)], ids=["more rows", "other places", "chain"])
def test_another_structure_finds_its_own(library: Path, other: np.ndarray) -> None:
    _, order = factorised(library, of_upper(kkt(3)), None)
    _, kept = factorised(library, of_upper(other), order)
    assert kept is not order


def test_an_entry_in_another_place_is_another_structure(library: Path) -> None:
    """As many rows and entries as before."""
    entries = of_upper(kkt(3))
    _, order = factorised(library, entries, None)
    row, column = entries.row.copy(), entries.column.copy()
    off = int(np.flatnonzero((row != column) & (column < 30))[0])
    free = next(c for c in range(30) if c > row[off] and not np.any((row == row[off]) & (column == c)))
    column[off] = free
    _, kept = factorised(library, Entries(entries.size, row, column, entries.value), order)
    assert kept is not order


@pytest.mark.parametrize(("size", "serves"), [(1e-3, True), (1e-5, False), (0.0, False)])
def test_pairs_that_have_become_bad_are_chosen_anew(library: Path, size: float, serves: bool) -> None:
    """One row's pair, of two entries of which the other stays: 1 and 1, then `size` and 1."""
    entries = of_upper(np.array([[1.0, 0.0, 1.0], [0.0, 2.0, 1.0], [1.0, 1.0, 0.0]]))
    _, order = factorised(library, entries, None)
    pair = _paired_entry(library, entries, order)
    value = entries.value.copy()
    value[pair] = size
    _, kept = with_order(str(library), order, lambda: Factor(library, entries).factorise(value))
    assert (kept is order) == serves


def _paired_entry(library: Path, entries: Entries, order: PivotOrder) -> int:
    """The one of the two entries of the dual row without which the order does not serve."""
    served = []
    for k in np.flatnonzero(entries.row != entries.column):
        value = entries.value.copy()
        value[k] = 0.0
        _, kept = with_order(str(library), order, lambda value=value: Factor(library, entries).factorise(value))
        served.append((kept is order, int(k)))
    assert sorted(good for good, _ in served) == [False, True]
    return next(k for good, k in served if not good)


def test_an_order_serves_the_first_matrix_only(library: Path) -> None:
    """A second instance, as the restoration phase has one, neither uses it nor is what is kept."""
    one, two = of_upper(kkt(5)), of_upper(chain(5))

    def run() -> None:
        for entries in (one, two):
            check(Factor(library, entries), entries.dense(), entries.value)

    _, order = with_order(str(library), None, run)
    _, kept = factorised(library, one, order)
    assert kept is order
    _, kept = factorised(library, two, order)
    assert kept is not order


def test_a_solve_that_is_interrupted_leaves_nothing(library: Path) -> None:
    entries = of_upper(kkt(6))
    _, order = factorised(library, entries, None)

    def stop() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        with_order(str(library), order, stop)
    order.fill(-1)  # what it held is gone
    check(Factor(library, entries), entries.dense(), entries.value)


def test_room_that_is_too_small_is_asked_for_with_a_given_order(library: Path) -> None:
    entries = of_upper(chain(7))
    _, order = factorised(library, entries, None)

    def run() -> None:
        factor = Factor(library, entries)
        assert LIW_TOO_SMALL in factorised_in_growing_room(factor, entries)
        check(factor, entries.dense(), entries.value)

    _, kept = with_order(str(library), order, run)
    np.testing.assert_array_equal(kept, order)


def test_threads_keep_their_own(library: Path) -> None:
    def work(seed: int) -> None:
        entries, order = of_upper(chain(seed)), None
        for again in range(15):
            _, kept = factorised(library, changed(entries, again, 0.2), order)
            assert order is None or kept is order
            order = kept

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(work, (30, 31)))
