"""Ctrl-C while CasADi works, which answers as if nothing had come."""

from __future__ import annotations

import contextlib
import signal

import pytest

from nospill.transcription.solvers.callbacks import interruptible


def _answers_with_an_error_set() -> None:
    """As Python does of a call that returns while an error is set."""
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt as error:
        raise SystemError("a result with an exception set") from error


def test_an_interrupt_that_becomes_a_system_error_is_raised_as_what_it_is() -> None:
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), interruptible():
        _answers_with_an_error_set()
    assert signal.getsignal(signal.SIGINT) is before


def test_an_interrupt_that_is_swallowed_is_raised_after_the_call() -> None:
    with pytest.raises(KeyboardInterrupt), interruptible(), contextlib.suppress(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_a_system_error_of_another_origin_stays_one() -> None:
    with pytest.raises(SystemError, match="of CasADi itself"), interruptible():
        raise SystemError("of CasADi itself")
