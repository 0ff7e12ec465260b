"""Functions that a process keeps once they are made, until it is told to make them anew."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import ParamSpec, TypeVar

_P = ParamSpec("_P")
_T = TypeVar("_T")

_forget: list[Callable[[], None]] = []


def kept(maxsize: int) -> Callable[[Callable[_P, _T]], Callable[_P, _T]]:
    """Keep what is made of the last arguments, which can be hashed.

    Args:
        maxsize: of how many arguments.
    """

    def keep(make: Callable[_P, _T]) -> Callable[_P, _T]:
        found = lru_cache(maxsize)(make)
        _forget.append(found.cache_clear)
        return found  # pyright: ignore[reportReturnType]

    return keep


def forget_functions() -> None:
    """Let this process make its functions anew, as NOSPILL_COMPILE and the other settings then say."""
    for forget in _forget:
        forget()
