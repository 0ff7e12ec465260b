"""The frames of a film, grey, with their times."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np

from nospill.errors import MissingExtraError, ScenarioError

_LARGEST_SIDE = 8192
"""Pixels; what is larger is no film."""


def opencv() -> ModuleType:
    """The library OpenCV.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import cv2
    except ImportError as error:
        raise MissingExtraError(
            "measuring a film needs the library OpenCV; install it with pip install 'nospill[video]'"
        ) from error
    return cv2


def footage(path: str | os.PathLike[str], rate: float | None = None) -> Iterator[tuple[float, np.ndarray]]:
    """The frames of a film, one after the other: time from the first one, s, and brightness (height, width), 0 to 255.

    Args:
        path: of any film that OpenCV reads (mp4, mov, avi, mkv, webm).
        rate: frames a second as filmed; as the file says where left out.

    Raises:
        MissingExtraError: OpenCV is not installed.
        ScenarioError: no such file, no film, or a film that does not say its rate.
    """
    cv2 = opencv()
    name = os.fsdecode(path)
    if not Path(name).is_file():
        raise ScenarioError(f"{name}: no such file; give a film")
    before = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(0)  # what it prints of damaged files would stand beside our one line
    film = cv2.VideoCapture(name, cv2.CAP_FFMPEG)
    try:
        more, frame = film.read()
        if not more:
            raise ScenarioError(f"{name}: cannot be read as a film; give mp4, mov, avi, mkv or webm")
        said = float(film.get(cv2.CAP_PROP_FPS))
        rate = said if rate is None else rate
        if not 0.0 < rate < 1e5:
            raise ScenarioError(f"{name}: does not say how many frames a second it has; state --rate")
        if max(frame.shape) > _LARGEST_SIDE:
            raise ScenarioError(f"{name}: {frame.shape[1]} x {frame.shape[0]} pixels; at most {_LARGEST_SIDE} a side")
        number = 0
        while more:
            yield number / rate, cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
            number += 1
            more, frame = film.read()
    finally:
        film.release()
        cv2.utils.logging.setLogLevel(before)
