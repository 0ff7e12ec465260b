"""The sparse LDL^T through the entry points of MA27: inertia, solutions and reports, against dense linear algebra."""

from __future__ import annotations

import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.native import libraries
from nospill.transcription.solvers import linear_solvers
from tests.hasty import COMPILER
from tests.native.ma27 import LA_TOO_SMALL, LIW_TOO_SMALL, SINGULAR, Entries, Factor
from tests.native.systems import chain, check, factorised_in_growing_room, kkt, of_upper, refined, states

pytestmark = pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler")

SEEDS = range(12)


@pytest.fixture(scope="module")
def library() -> Path:
    found = linear_solvers.ldl_library()
    assert found is not None
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_systems_of_an_interior_point_method(library: Path, seed: int) -> None:
    """Convex and not: the pivots' signs count the negative eigenvalues of either."""
    matrix = kkt(seed, curvature=4.0 if seed % 2 else 0.3)
    entries = of_upper(matrix)
    check(Factor(library, entries), matrix, entries.value)


@pytest.mark.parametrize(("stages", "variables", "equalities"), [(2, 3, 1), (40, 9, 5), (12, 30, 22), (5, 90, 70)])
def test_chains_of_stages(library: Path, stages: int, variables: int, equalities: int) -> None:
    """Panels of several columns, and panels that reach into the next ones."""
    matrix = chain(stages, stages, variables, equalities)
    entries = of_upper(matrix)
    check(Factor(library, entries), matrix, entries.value)


@pytest.mark.parametrize("inequalities", [1, 2, 7, 8, 9, 30])
def test_inequalities_on_the_same_variables(library: Path, inequalities: int) -> None:
    """Leaves of the tree with the same rows, in panels of eight at most."""
    matrix = chain(inequalities, 12, 9, 5, inequalities)
    entries = of_upper(matrix)
    check(Factor(library, entries), matrix, entries.value)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 14), st.integers(1, 12), st.data())
def test_any_chain(library: Path, seed: int, stages: int, variables: int, data: st.DataObject) -> None:
    equalities = data.draw(st.integers(0, variables))
    matrix = chain(seed, stages, variables, equalities, data.draw(st.integers(0, 20)))
    entries = of_upper(matrix)
    factor = Factor(library, entries)
    assert factor.factorise(entries.value) == 0
    assert factor.negative == np.sum(np.linalg.eigvalsh(matrix) < 0.0)
    right = matrix @ np.ones(len(matrix))
    assert np.max(np.abs(matrix @ refined(factor, matrix, right) - right)) <= 1e-9 * np.max(np.abs(right))


def test_processors_without_fused_products_find_the_same(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = "#define WITHOUT_FMA\n" + libraries.source("ldl")
    monkeypatch.setattr(libraries, "source", lambda _: plain)
    monkeypatch.setenv("CC", COMPILER)
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path / "cache"))
    other = linear_solvers.ldl_library()
    assert other is not None and other != library
    matrix = chain(3)
    entries, right = of_upper(matrix), np.ones(len(matrix))
    one, two = Factor(library, entries), Factor(other, entries)
    check(two, matrix, entries.value)
    assert one.factorise(entries.value) == 0
    assert one.negative == two.negative
    np.testing.assert_allclose(refined(one, matrix, right), refined(two, matrix, right), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_quasi_definite_matrices(library: Path, seed: int) -> None:
    random = np.random.default_rng(seed)
    matrix = kkt(seed, curvature=9.0)
    matrix[39:, 39:] -= np.diag(random.uniform(0.1, 2.0, 21))
    entries = of_upper(matrix)
    check(Factor(library, entries), matrix, entries.value)


def test_one_structure_serves_many_numbers(library: Path) -> None:
    """Pivots are chosen from the first ones; later ones have other magnitudes, zeros and signs."""
    entries = of_upper(kkt(3))
    factor = Factor(library, entries)
    for seed in range(6):
        value = entries.value * np.random.default_rng(seed).uniform(-2.0, 2.0, len(entries.value))
        matrix = Entries(entries.size, entries.row, entries.column, value).dense()
        check(factor, matrix, value)


def test_a_diagonal_of_zeros(library: Path) -> None:
    """No pivot of one row exists at the start, yet the system is regular: pairs are needed."""
    matrix = np.zeros((8, 8))
    matrix[:4, 4:] = np.triu(np.full((4, 4), 0.5)) + np.eye(4)
    matrix += matrix.T
    entries = of_upper(matrix)
    check(Factor(library, entries), matrix, entries.value)


def test_entries_in_either_triangle_and_in_parts_add_up(library: Path) -> None:
    whole = of_upper(kkt(5))
    turned = np.arange(len(whole.value)) % 2 == 0
    row, column = np.where(turned, whole.column, whole.row), np.where(turned, whole.row, whole.column)
    parts = Entries(
        whole.size,
        np.concatenate([row, column]),
        np.concatenate([column, row]),
        np.concatenate([0.25 * whole.value, 0.75 * whole.value]),
    )
    np.testing.assert_allclose(parts.dense(), kkt(5), atol=1e-15)
    check(Factor(library, parts), parts.dense(), parts.value)


def test_a_diagonal_alone(library: Path) -> None:
    matrix = np.diag([3.0, -2.0, 5.0, -7.0])
    entries = of_upper(matrix)
    check(Factor(library, entries), matrix, entries.value)


def test_one_row(library: Path) -> None:
    check(Factor(library, of_upper(np.array([[-4.0]]))), np.array([[-4.0]]), np.array([-4.0]))


def test_a_row_without_entries_counts_by_its_kind(library: Path) -> None:
    """A constraint that depends on nothing has the sign of a dual row, a free variable that of a primal one."""
    matrix = kkt(1)
    matrix[-1, :] = matrix[:, -1] = 0.0
    matrix[4, :] = matrix[:, 4] = 0.0
    factor = Factor(library, of_upper(matrix))
    assert factor.factorise(of_upper(matrix).value) == 0
    kept = [index for index in range(len(matrix)) if index not in (4, len(matrix) - 1)]
    rest = matrix[np.ix_(kept, kept)]
    assert factor.negative == np.sum(np.linalg.eigvalsh(rest) < 0.0) + 1


def test_a_constraint_named_twice_counts_as_negative(library: Path) -> None:
    matrix = kkt(2, equalities=6, inequalities=4, curvature=6.0)
    matrix[35, :] = matrix[34, :]
    matrix[:, 35] = matrix[:, 34]
    entries = of_upper(matrix)
    factor = Factor(library, entries)
    assert factor.factorise(entries.value) == 0
    assert factor.negative == 10


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_no_number_is_reported_as_singular(library: Path, value: float) -> None:
    entries = of_upper(kkt(4))
    factor = Factor(library, entries)
    spoilt = entries.value.copy()
    spoilt[3] = value
    assert factor.factorise(spoilt) == SINGULAR
    check(factor, kkt(4), entries.value)  # and leaves nothing behind


def test_pairs_that_cancel_spoil_no_digits(library: Path) -> None:
    """Whole numbers and no curvature: of many a pair exactly nothing is left, though the system is regular."""
    checked = 0
    for seed in range(40):
        random = np.random.default_rng(seed)
        jacobian = np.where(random.random((10, 13)) < 0.4, random.choice([-1.0, 1.0], (10, 13)), 0.0)
        jacobian[:, 0] = 1.0
        matrix = np.zeros((23, 23))
        matrix[13:, :13] = jacobian
        matrix[range(9, 13), range(9, 13)] = 2.0
        matrix[:13, 13:] = jacobian.T
        if np.linalg.cond(matrix) < 1e4:
            entries = of_upper(matrix)
            check(Factor(library, entries), matrix, entries.value)
            checked += 1
    assert checked > 10


def test_a_stage_fills_in_the_states_before_it_and_not_their_multipliers(library: Path) -> None:
    """As Riccati's recursion: of 20 stages with 10 states each a stage is 20 columns with 10 rows below them."""
    matrix = states(stages=20, size=10)
    entries = of_upper(matrix)
    factor = Factor(library, entries)
    factorised_in_growing_room(factor, entries)
    check(factor, matrix, entries.value)
    of_columns = len(entries.value) + 8 * len(matrix) + 1
    assert factor.room <= of_columns + (20 + 1) * 20 * (20 + 10)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_products_that_are_left_out_are_zero(library: Path, share: float) -> None:
    """Multipliers with a diagonal and without: where one has any, its pair fills in whatever either row touches."""
    matrix, random = states(stages=12, size=20), np.random.default_rng(7)
    dual = np.flatnonzero(np.diag(matrix) == 0.0)
    some = dual[random.random(len(dual)) < share]
    matrix[some, some] -= random.uniform(0.1, 2.0, len(some))
    entries = of_upper(matrix)
    check(Factor(library, entries), matrix, entries.value)


def test_too_little_room_is_reported_with_what_is_needed(library: Path) -> None:
    """As IPOPT does it: arrays of the size that the report names, then the same call again."""
    entries = of_upper(kkt(6))
    factor = Factor(library, entries)
    seen = factorised_in_growing_room(factor, entries)
    assert set(seen) == {LA_TOO_SMALL, LIW_TOO_SMALL} and len(seen) <= 3
    check(factor, kkt(6), entries.value)


def test_instances_side_by_side_do_not_meet(library: Path) -> None:
    first, second = kkt(7), kkt(8, variables=50, equalities=20)
    one, other = Factor(library, of_upper(first)), Factor(library, of_upper(second))
    assert one.factorise(of_upper(first).value) == other.factorise(of_upper(second).value) == 0
    for factor, matrix in ((one, first), (other, second), (one, first)):
        right = np.ones(len(matrix))
        np.testing.assert_allclose(matrix @ refined(factor, matrix, right), right, atol=1e-9)


def test_threads_do_not_meet(library: Path) -> None:
    def work(seed: int) -> None:
        matrix = kkt(seed, variables=80, equalities=30)
        entries = of_upper(matrix)
        factor = Factor(library, entries)
        for _ in range(20):
            check(factor, matrix, entries.value)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(work, (20, 21)))
