"""Products of matrices have one thread while nospill works, and as many as before afterwards."""

from __future__ import annotations

import os

import pytest

from nospill.core import blas_threads
from nospill.core.blas_threads import SETTINGS, one_blas_thread, one_thread_by_default


class _Library:
    def __init__(self) -> None:
        self.threads = 4

    def get(self) -> int:
        return self.threads

    def set(self, threads: int) -> None:
        self.threads = threads


@pytest.fixture
def library(monkeypatch: pytest.MonkeyPatch) -> _Library:
    library = _Library()
    monkeypatch.setattr(blas_threads, "_functions", lambda: (library.get, library.set))
    for name in SETTINGS:
        monkeypatch.delenv(name, raising=False)
    return library


def test_one_thread_inside_and_as_many_as_before_after_an_error(library: _Library) -> None:
    with pytest.raises(KeyError), one_blas_thread():
        assert library.threads == 1
        raise KeyError
    assert library.threads == 4


@pytest.mark.parametrize("name", SETTINGS)
def test_a_number_that_is_set_stays(library: _Library, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setenv(name, "3")
    with one_blas_thread():
        assert library.threads == 4
    before = dict(os.environ)
    one_thread_by_default()
    assert dict(os.environ) == before


def test_by_default_a_process_begins_with_one(library: _Library, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "environ", {})
    one_thread_by_default()
    assert os.environ == {SETTINGS[0]: "1"}


def test_numpys_library_is_found_or_there_is_nothing_to_set() -> None:
    found = blas_threads._functions()
    assert found is None or found[0]() >= 1
