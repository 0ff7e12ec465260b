"""Products of matrices have one thread while nospill works, and as many as before afterwards."""

from __future__ import annotations

import os
from pathlib import Path

import numpy  # noqa: F401  # the library whose threads are counted
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from nospill.core.blas_threads import SETTINGS, _controller_of, one_blas_thread, one_thread_by_default


def threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def two_threads(monkeypatch: pytest.MonkeyPatch):
    for name in SETTINGS:
        monkeypatch.delenv(name, raising=False)
    with one_blas_thread():
        pass  # from now on the library that CasADi brings, where one is loaded, is counted too
    with threadpool_limits(2, user_api="blas"):
        yield


def test_one_thread_inside_and_as_many_as_before_after_an_error() -> None:
    before = threads()
    with pytest.raises(KeyError), one_blas_thread():
        assert threads() <= {1}
        raise KeyError
    assert threads() == before


def test_the_library_that_casadi_brings_has_one_too(capfd: pytest.CaptureFixture[str]) -> None:
    """IPOPT adds its vectors up with it. CasADi says so where it is loaded again."""
    import casadi

    casadi.has_nlpsol("ipopt")
    _controller_of.cache_clear()
    if not any("casadi-tp-openblas" in path.name for path in Path(casadi.__file__).parent.iterdir()):
        pytest.skip("this CasADi has no OpenBLAS of its own")
    with one_blas_thread():
        inside = [library for library in threadpool_info() if library["prefix"] == "libcasadi-tp-openblas"]
    assert [library["num_threads"] for library in inside] == [1]
    assert capfd.readouterr().err == ""


def test_of_two_callers_the_last_to_leave_puts_the_number_back() -> None:
    """As two threads that plan: the second enters while the first is at work, and leaves after it."""
    before, first, second = threads(), one_blas_thread(), one_blas_thread()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert threads() <= {1}
    second.__exit__(None, None, None)
    assert threads() == before


@pytest.mark.parametrize("name", SETTINGS)
def test_a_number_that_is_set_stays(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setenv(name, "2")
    before = threads()
    with one_blas_thread():
        assert threads() == before
    environment = dict(os.environ)
    one_thread_by_default()
    assert dict(os.environ) == environment


def test_by_default_a_process_begins_with_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "environ", {})
    one_thread_by_default()
    assert os.environ == {SETTINGS[0]: "1"}
