"""Films as files: mp4, WebP, GIF; whole or not at all."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from nospill.core.files import atomic_file, require_writable
from nospill.drawing.props import Placed, SceneBuilder
from nospill.drawing.timeline import Film
from nospill.drawing.views import CLOSE, View, camera_frame, viewpoint
from nospill.errors import MissingExtraError, ScenarioError
from nospill.film.overlay import caption, write_over
from nospill.film.picture import draw

SUFFIXES = (".mp4", ".webp", ".gif")
"""Kinds of film."""
SIZE = (1280, 720)
"""px; width and height of a film."""
SMALLEST, LARGEST = 64, 4096
"""px; of a side."""
RATE = 25.0
"""Pictures a second."""
SPEEDS = (0.02, 10.0)
"""Slowest and fastest."""
_QUALITY = 70
"""Of WebP, 0 to 100."""


@dataclass(frozen=True, slots=True)
class Format:
    """How a film looks.

    Attributes:
        view: where it is seen from.
        speed: time of the motion over that of the film.
        size: width and height, px.
        rate: pictures a second.
    """

    view: View = View.TRAY
    speed: float = 0.25
    size: tuple[int, int] = SIZE
    rate: float = RATE

    def __post_init__(self) -> None:
        """Refuse what no film can be.

        Raises:
            ScenarioError: speed, size or rate is out of range.
        """
        slow, fast = SPEEDS
        if not slow <= self.speed <= fast:
            raise ScenarioError(f"speed {self.speed:g}: {slow:g} to {fast:g} times real time is possible")
        if not all(SMALLEST <= side <= LARGEST and side % 2 == 0 for side in self.size):
            raise ScenarioError(
                f"size {self.size[0]}x{self.size[1]}: even numbers of pixels from {SMALLEST} to {LARGEST} are possible"
            )
        if not 1.0 <= self.rate <= 60.0:
            raise ScenarioError(f"rate {self.rate:g}: 1 to 60 pictures a second are possible")

    @property
    def motion_rate(self) -> float:
        """Pictures for a second of the motion; what a `Film` must be cut at."""
        return self.rate / self.speed


def require_film(path: Path) -> None:
    """Check, before any long work, that a film can be written.

    Raises:
        ScenarioError: an ending that is no kind of film. PlanFolderError: no folder for it, or nothing may be written
            there. MissingExtraError: an mp4 is wanted, and imageio or its ffmpeg is not installed.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise ScenarioError(f"{path}: a film ends in {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}; name it so")
    require_writable(path)
    if path.suffix.lower() == ".mp4":
        _imageio()


def save_film(
    films: Sequence[Film],
    path: Path,
    form: Format,
    *,
    placed: Mapping[str, Placed] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> int:
    """Draw motions side by side on one clock and write the film.

    Args:
        films: all cut at `form.motion_rate` and of one length.
        path: of the file; an earlier one is replaced.
        form: how it looks.
        placed: where the objects stand, where that is not where their scene has them.
        progress: called with the number of pictures drawn and that of all.

    Returns:
        The number of pictures.

    Raises:
        As `require_film`; ScenarioError: a robot's URDF cannot be read; PlanFolderError: the disk refuses.
    """
    require_film(path)
    count = max(len(film.t) for film in films)
    with atomic_file(path) as partial:
        _write(partial, _count(pictures(films, form, placed), count, progress), form.rate, count)
    return count


def _count(
    found: Iterator[np.ndarray], count: int, progress: Callable[[int, int], None] | None
) -> Iterator[np.ndarray]:
    for number, picture in enumerate(found):
        if progress is not None:
            progress(number + 1, count)
        yield picture


def pictures(films: Sequence[Film], form: Format, placed: Mapping[str, Placed] | None = None) -> Iterator[np.ndarray]:
    """Every picture of a film (height, width, 3), 0 to 255, in order; arguments as of `save_film`."""
    width, height = form.size
    edges = np.rint(np.linspace(0, width, len(films) + 1)).astype(int)
    camera = viewpoint(films, form.view, aspect=width / len(films) / height)
    hands = [SceneBuilder(film, path=form.view not in CLOSE, placed=placed) for film in films]
    rides = [camera_frame(film, form.view) for film in films]
    times = max(films, key=lambda film: film.length).t

    def picture(t: float) -> np.ndarray:
        panels = [
            draw(hand, film.index(t), camera, ride, size=(int(edges[number + 1] - edges[number]), height))
            for number, (hand, film, ride) in enumerate(zip(hands, films, rides, strict=True))
        ]
        captions = [caption(films, number, t) for number in range(len(films))]
        return write_over(np.concatenate(panels, axis=1), captions, speed=form.speed)

    workers = min(4, os.cpu_count() or 1)
    with ThreadPoolExecutor(workers) as pool:
        for start in range(0, len(times), 2 * workers):
            yield from pool.map(picture, times[start : start + 2 * workers])


def _write(path: Path, pictures: Iterator[np.ndarray], rate: float, count: int) -> None:
    """Write pictures as they come: none is kept but by the encoder."""
    if path.suffix.lower() == ".mp4":
        options: dict[str, Any] = {"fps": rate, "macro_block_size": 2, "quality": 7, "pixelformat": "yuv420p"}
        with _imageio().get_writer(path, format="FFMPEG", **options) as writer:
            for picture in pictures:
                writer.append_data(picture)
        return
    # A GIF counts in hundredths of a second: rounded so that the whole film is as long as it is.
    step = 10 if path.suffix.lower() == ".gif" else 1
    ends = step * np.rint(1000.0 / rate / step * np.arange(count + 1))
    options = {"quality": _QUALITY, "method": 4} if path.suffix.lower() == ".webp" else {"optimize": True}
    _FrameSequence(pictures, count).save(
        path, save_all=True, duration=[int(each) for each in np.diff(ends)], loop=0, **options
    )


class _FrameSequence(Image.Image):
    """Pictures as one image of many, each drawn when Pillow's writers come to it; they only go forwards."""

    def __init__(self, found: Iterator[np.ndarray], count: int) -> None:
        super().__init__()
        self._found, self._shown = found, 0
        self.n_frames, self.is_animated = count, count > 1
        self.__dict__.update(Image.fromarray(next(found)).__dict__)

    def seek(self, frame: int) -> None:
        """Go on to a picture; going back, which a writer does when it is ready, changes nothing."""
        if frame >= self.n_frames:
            raise EOFError
        while self._shown < frame:
            self.paste(Image.fromarray(next(self._found)))
            self._shown += 1

    def tell(self) -> int:
        """The number of the picture."""
        return self._shown


def _imageio() -> Any:
    try:
        importlib.import_module("imageio_ffmpeg")
        return importlib.import_module("imageio.v2")
    except ImportError as error:
        raise MissingExtraError(
            f'an mp4 needs imageio and ffmpeg, which cannot be loaded ({error}); pip install "nospill[film]", '
            "or name a .webp or .gif"
        ) from error
