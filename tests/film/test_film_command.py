"""nospill film as a user calls it: small films of all kinds, and mistakes that cost one line."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner, Result

from nospill.cli import app
from nospill.drawing.timeline import Film
from nospill.film.overlay import caption, titles_of

SMALL = ["--size", "96x64", "--rate", "1", "--speed", "0.5"]


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["film", *arguments])


def wanted_pictures(*films: Film) -> int:
    length = max(film.plan.duration for film in films) + 0.4
    return int(np.ceil(length / 0.5 - 1e-9)) + 1


@pytest.mark.slow
def test_webp_of_two_plans(folders: tuple[str, str], tmp_path: Path, tilting_film: Film, level_film: Film) -> None:
    target = tmp_path / "both.webp"
    result = run(*folders, "-o", str(target), *SMALL)
    assert result.exit_code == 0, result.output
    count = wanted_pictures(tilting_film, level_film)
    assert f"{count} pictures" in result.stdout
    with Image.open(target) as image:
        assert image.size == (96, 64)
        assert image.n_frames == count  # pyright: ignore[reportAttributeAccessIssue]
        pictures = []
        for index in range(count):
            image.seek(index)
            pictures.append(np.asarray(image.convert("RGB"), dtype=float))
    assert np.abs(pictures[0] - pictures[count // 2]).mean() > 2.0
    assert [path.name for path in tmp_path.iterdir()] == ["both.webp"]


@pytest.mark.slow
def test_gif_is_as_long_as_the_motion(folders: tuple[str, str], tmp_path: Path, tilting_film: Film) -> None:
    target = tmp_path / "one.gif"
    assert run(folders[1], "-o", str(target), "--view", "fixed", *SMALL).exit_code == 0
    total = 0.0
    with Image.open(target) as image:
        for index in range(image.n_frames):  # pyright: ignore[reportAttributeAccessIssue]
            image.seek(index)
            total += image.info["duration"] / 1000.0
    assert total == pytest.approx(wanted_pictures(tilting_film), abs=0.02)


@pytest.mark.slow
def test_mp4_has_every_picture(folders: tuple[str, str], tmp_path: Path, tilting_film: Film) -> None:
    pytest.importorskip("imageio_ffmpeg", reason="imageio-ffmpeg is not installed")
    import imageio.v2 as imageio

    target = tmp_path / "one.mp4"
    assert run(folders[1], "-o", str(target), "--view", "arm", *SMALL).exit_code == 0
    with imageio.get_reader(target) as reader:
        assert reader.count_frames() == wanted_pictures(tilting_film)  # pyright: ignore[reportAttributeAccessIssue]
        assert reader.get_data(0).shape == (64, 96, 3)  # pyright: ignore[reportAttributeAccessIssue]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere", "-o", "x.webp"], "nowhere: no such folder"),
        (["{}", "-o", "x.avi"], "a film ends in .mp4, .webp or .gif"),
        (["{}", "-o", "film"], "a film ends in .mp4, .webp or .gif"),
        (["{}", "-o", "nowhere/x.gif"], "there is no folder nowhere"),
        (["{}", "-o", "x.webp", "--view", "below"], "no view; there are tray, fixed, arm, above"),
        (["{}", "-o", "x.webp", "--speed", "0"], "0.02 to 10 times real time"),
        (["{}", "-o", "x.webp", "--size", "big"], "for example 1280x720"),
        (["{}", "-o", "x.webp", "--size", "95x64"], "even numbers of pixels"),
        (["{}", "-o", "x.webp", "--rate", "1000"], "1 to 60 pictures a second"),
    ],
)
def test_mistakes_are_one_line(
    folders: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(*[item.format(folders[0]) for item in arguments])
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_without_ffmpeg_an_mp4_names_the_extra_and_webp_needs_none(
    folders: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    result = run(folders[0], "-o", str(tmp_path / "x.mp4"))
    assert result.exit_code == 2
    assert 'pip install "nospill[film]"' in result.stderr
    assert result.stderr.count("\n") == 1


def test_captions_tell_who_is_first(tilting_film: Film, level_film: Film) -> None:
    both = [level_film, tilting_film]
    assert titles_of(both) == ["level tray", "tilting tray"]
    assert titles_of([tilting_film]) == ["matrix-liquid-tilt"]
    early = caption(both, 0, 0.1)
    assert (early.clock, early.verdict) == ("0.10 s", "")
    late = [caption(both, number, 99.0) for number in range(2)]
    first = min(range(2), key=lambda number: both[number].end_time)
    apart = abs(level_film.end_time - tilting_film.end_time)
    assert ("sooner" in late[first].verdict) == (apart > 5e-3)
    assert "sooner" not in late[1 - first].verdict
    assert late[0].clock == f"{level_film.end_time:.2f} s"
    assert [name for name, _ in early.bars] == ["liquid", "contact"]
