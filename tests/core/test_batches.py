"""Functions on many samples: chunks of any length give what one sample at a time gives."""

from __future__ import annotations

from itertools import pairwise

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.core.batches import call, evaluate, over_columns, thread_count


def function() -> ca.Function:
    x, y, p = ca.SX.sym("x", 2), ca.SX.sym("y"), ca.SX.sym("p", 3)
    return ca.Function("f", [x, y, p], [ca.vertcat(p[0] * x[0] + ca.sin(y), p[1] * x[1] * y + p[2])])


F = function()
P = np.array([2.0, -3.0, 0.5])


def columns(count: int, seed: int = 0) -> list[np.ndarray]:
    random = np.random.default_rng(seed)
    return [random.normal(size=(2, count)), random.normal(size=(1, count))]


def expected(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.array([P[0] * x[0] + np.sin(y[0]), P[1] * x[1] * y[0] + P[2]])


@pytest.mark.parametrize("count", [1, 2, 499, 500, 501, 999, 1000, 1001, 2345])
def test_against_closed_form_on_both_sides_of_a_chunk(count: int) -> None:
    x, y = columns(count)
    result = evaluate(F, [x, y], P)
    assert result.shape == (2, count)
    np.testing.assert_allclose(result, expected(x, y), rtol=1e-14, atol=1e-14)


@settings(deadline=None, max_examples=20)
@given(st.integers(1, 1200), st.integers(0, 1200))
def test_a_cut_changes_nothing(count: int, cut: int) -> None:
    x, y = columns(count, seed=count)
    whole = evaluate(F, [x, y], P)
    ends = sorted({0, min(cut, count), count})
    parts = [evaluate(F, [x[:, a:b], y[:, a:b]], P) for a, b in pairwise(ends)]
    np.testing.assert_array_equal(np.concatenate(parts, axis=1), whole)


def test_shared_input_and_arguments_are_taken_anew_each_time() -> None:
    x, y = columns(600)
    first = evaluate(F, [x, y], P)
    np.testing.assert_array_equal(evaluate(F, [x, y], 2 * P)[1] - 2 * P[2], 2 * (first[1] - P[2]))
    np.testing.assert_array_equal(evaluate(F, [x, y], P), first)


def test_inputs_are_left_alone() -> None:
    x, y = columns(700)
    before = x.copy(), y.copy()
    evaluate(F, [x, y], P)
    assert np.array_equal(x, before[0]) and np.array_equal(y, before[1])


def test_two_functions_are_not_mixed_up() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    one, two = ca.Function("f", [x, p], [x + p]), ca.Function("f", [x, p], [x - p])
    values = np.arange(3.0)[None, :]
    np.testing.assert_array_equal(evaluate(one, [values], np.ones(1)), values + 1)
    np.testing.assert_array_equal(evaluate(two, [values], np.ones(1)), values - 1)


def test_a_value_that_is_no_number_stays_in_its_column() -> None:
    x, y = columns(501)
    y[0, 500] = np.nan
    result = evaluate(F, [x, y], P)
    assert np.all(np.isfinite(result[:, :500])) and np.all(np.isnan(result[:, 500]))


@pytest.mark.parametrize("order", ["C", "F"])
def test_call_takes_and_gives_arrays_of_any_order(order: str) -> None:
    a, b = ca.SX.sym("a", 3, 4), ca.SX.sym("b", 2)
    made = ca.Function("made", [a, b], [b[0] * a[:2, :] + b[1]])
    x = np.random.default_rng(1).normal(size=(6, 8))[::2, ::2].copy(order=order)  # pyright: ignore[reportArgumentType]
    np.testing.assert_allclose(call(made, x, np.array([2.0, 3.0])), 2.0 * x[:2] + 3.0, rtol=1e-15)
    np.testing.assert_array_equal(call(made, x[:, :], np.array([[2.0], [3.0]])), call(made, x, np.array([2.0, 3.0])))


def test_call_refuses_what_does_not_fit() -> None:
    a = ca.SX.sym("a", 3)
    dense, sparse = ca.Function("dense", [a], [2 * a]), ca.Function("sparse", [a], [ca.diag(a)])
    with pytest.raises(ValueError, match="dense takes 1 arguments, 2 are given"):
        call(dense, np.zeros(3), np.zeros(3))
    with pytest.raises(ValueError, match=r"argument 0 has the shape \(4,\)"):
        call(dense, np.zeros(4))
    with pytest.raises(ValueError, match="its output is sparse"):
        call(sparse, np.zeros(3))


@pytest.mark.parametrize("threads", [1, 2, 3, 4, 7])
@pytest.mark.parametrize("count", [1, 2, 5, 100, 101])
def test_threads_change_no_bit(threads: int, count: int) -> None:
    x, y = columns(count)
    found = over_columns(F, count, [2], threads=threads)(x, y, P).full()
    np.testing.assert_array_equal(found, over_columns(F, count, [2])(x, y, P).full())
    np.testing.assert_allclose(found, expected(x, y), rtol=1e-14, atol=1e-14)


def test_threads_within_an_expression_with_two_outputs_and_two_shared_inputs() -> None:
    x, p, q = ca.SX.sym("x", 2), ca.SX.sym("p"), ca.SX.sym("q")
    two = ca.Function("two", [x, p, q], [p * ca.sum1(x), ca.vertcat(q + x[0], x[1], p)])
    columns_of, first, second = ca.MX.sym("x", 2, 5), ca.MX.sym("p"), ca.MX.sym("q")
    whole = ca.Function(
        "whole", [columns_of, first, second], list(over_columns(two, 5, [1, 2], threads=2)(columns_of, first, second))
    )
    values = np.arange(10.0).reshape(2, 5)
    sums, rest = whole(values, 2.0, 3.0)
    np.testing.assert_array_equal(sums.full(), 2 * values.sum(axis=0, keepdims=True))
    np.testing.assert_array_equal(rest.full(), [values[0] + 3, values[1], np.full(5, 2.0)])


@pytest.mark.parametrize(("setting", "count"), [("3", 3), ("0", 1), ("1", 1)])
def test_threads_are_as_many_as_set(setting: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOSPILL_THREADS", setting)
    assert thread_count() == count


@pytest.mark.parametrize("setting", ["", "many", "-2", "1.5"])
def test_threads_are_otherwise_as_many_as_the_process_may_run(setting: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOSPILL_THREADS", setting)
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0, 3, 5}, raising=False)
    assert thread_count() == 3
